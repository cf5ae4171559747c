//! What a person chooses: sizes, numbers, and a value on each axis.

use std::collections::BTreeMap;

use sglow_graph::description::{self, Setting};
use sglow_graph::{Configuration, Description, Errors};
use sglow_shaders::frame::parameter;
use sglow_shaders::{Emitter, Number, Sharpness};
use thiserror::Error;

use crate::host;
use crate::package::Assumption;

/// An invalid setting.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum SettingsError {
    /// A parameter gets no number of its kind.
    #[error("{name} is {value}, and must be a finite number, whole where the parameter is")]
    Range {
        /// The setting.
        name: String,
        /// Its value.
        value: String,
    },
    /// There is no such axis.
    #[error("unknown axis '{axis}'; expected one of: {}", known.join(", "))]
    UnknownAxis {
        /// The given name.
        axis: String,
        /// The axes that exist.
        known: Vec<String>,
    },
    /// There is no such value on the axis.
    #[error("{0}")]
    UnknownValue(String),
}

sglow_shaders::settings! {
    /// What the indirect light is made of: a value on each axis, and numbers.
    #[derive(Clone, Debug, PartialEq)]
    pub struct Settings {
        /// Width and height of the picture in pixels.
        pub size: [u32; 2] = [640, 360],
        /// With light several the number of the faces of the lights' map: six of a point light, one of another.
        pub light_faces: u32 = 1,
        /// Draws every surface with the variant that can do everything, whether it needs it or not: what the result of
        /// leaving things out is compared with.
        pub complete: bool = false,
        /// What was taken to be so of the scene when these were derived from it. A scene of which something else is so by
        /// now, and that needs more, is refused. Nothing where a person chose.
        pub assumed: Vec<Assumption> = Vec::new(),
        /// Axes and parameters of a library that was laid over this one, by name: the name of a value on an axis, the number of
        /// a parameter. An axis that has a field, and values that the field cannot hold, is there as well: empty while the
        /// field has its value.
        pub others: BTreeMap<String, Setting> = BTreeMap::new(),
    }
}

impl Settings {
    /// What a package advises for scenes of which these facts are known (those of its library, such as whether there are
    /// occluders; the others count as false): its defaults for the class, changed by a preset.
    ///
    /// # Errors
    ///
    /// An unknown preset, with those that there are.
    pub fn advised(
        description: &Description,
        facts: &BTreeMap<String, bool>,
        preset: Option<&str>,
    ) -> Result<Self, Errors> {
        let Configuration { axes, parameters, .. } =
            description.configure(facts, preset, &BTreeMap::new())?;
        let axes = axes.into_iter().map(|(name, value)| (name, Setting::Name(value)));
        let numbers = parameters.into_iter().map(|(name, number)| (name, Setting::Number(number)));
        let mut settings = Self::default();
        for (name, setting) in axes.chain(numbers) {
            if settings.set(&name, &setting.to_string()).is_err() {
                settings.others.insert(name, setting);
            }
        }
        Ok(settings)
    }

    /// Sets one axis by the name of its value, or one parameter.
    ///
    /// # Errors
    ///
    /// An unknown name or value, with those that are known; a number that is none.
    pub fn set(&mut self, name: &str, value: &str) -> Result<(), SettingsError> {
        let field = self.set_axis(name, value);
        let is_number = match (self.others.get_mut(name), field) {
            // Whether there is such a value, the description of the frame says.
            (Some(Setting::Name(other)), field) => {
                let of_other = if field == Some(Ok(())) { "" } else { value };
                of_other.clone_into(other);
                return Ok(());
            }
            (Some(Setting::Number(other)), _) => match Setting::read(value) {
                Setting::Number(number) => {
                    *other = number;
                    Some(true)
                }
                Setting::Name(_) => Some(false),
            },
            (None, Some(set)) => {
                return set.map_err(|error| SettingsError::UnknownValue(error.to_string()));
            }
            (None, None) => {
                let is_finite = value.parse().is_ok_and(f64::is_finite);
                self.number(name).map(|_| is_finite && self.set_number(name, value) == Some(true))
            }
        };
        let name = name.to_owned();
        match is_number {
            Some(true) => Ok(()),
            Some(false) => Err(SettingsError::Range { name, value: value.to_owned() }),
            None => {
                let known =
                    Self::AXES.iter().chain(Self::PARAMETERS).map(|name| (*name).to_owned());
                let known = known.chain(self.others.keys().cloned()).collect();
                Err(SettingsError::UnknownAxis { axis: name, known })
            }
        }
    }

    /// The value of an axis or a parameter, as [`Self::set`] takes it; nothing if there is none of this name.
    pub fn get(&self, name: &str) -> Option<String> {
        let other = self.others.get(name).map(Setting::to_string).filter(|text| !text.is_empty());
        other
            .or_else(|| self.axis(name).map(str::to_owned))
            .or_else(|| self.number(name).map(|number| number.to_string()))
    }

    /// The settings in the words of a frame's description.
    pub fn configuration(&self) -> Configuration {
        let value = |axis: &&str| Some(((*axis).to_owned(), self.axis(axis)?.to_owned()));
        let number = |name: &&str| {
            let number = match self.number(name)? {
                Number::Whole(number) => description::Number::Whole(number.into()),
                Number::Real(number) => description::Number::Real(number.into()),
            };
            Some(((*name).to_owned(), number))
        };
        let mut configuration = Configuration {
            axes: Self::AXES.iter().filter_map(value).collect(),
            parameters: Self::PARAMETERS.iter().filter_map(number).collect(),
            ..Configuration::default()
        };
        let [width, height] = self.size;
        for (name, number) in [
            (parameter::WIDTH, width),
            (parameter::HEIGHT, height),
            (parameter::LIGHT_FACES, self.light_faces),
        ] {
            let number = description::Number::Whole(number.into());
            configuration.parameters.insert(name.to_owned(), number);
        }
        for (name, setting) in self.others.clone() {
            match setting {
                Setting::Number(number) => drop(configuration.parameters.insert(name, number)),
                Setting::Name(value) if value.is_empty() => {}
                Setting::Name(value) => drop(configuration.axes.insert(name, value)),
            }
        }
        configuration
    }

    /// Length of the mean direction of a texel's diffuse emission: of its lobe with the emitter `lobe`, by what turns it
    /// back into a sharpness; else 1, for the direction is the normal.
    pub fn diffuse_mean_length(&self) -> f32 {
        let sharpness = f64::from(self.emission_sharpness);
        let length = match (self.emitter, self.sharpness) {
            (Emitter::Lobe, Sharpness::Toksvig) => host::mean_length_toksvig(sharpness),
            (Emitter::Lobe, _) => host::mean_length(sharpness),
            _ => 1.0,
        };
        length as f32
    }
}
