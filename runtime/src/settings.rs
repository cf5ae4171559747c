//! What a person chooses: sizes, numbers, and a value on each axis.

use std::collections::BTreeMap;
use std::str::FromStr;

use sglow_graph::Configuration;
use sglow_graph::description::Number;
use sglow_shaders::{
    Density, Diffuse, Draw, Emitter, Filter, Importance, Kernel, Light, Lobes, Ndf, Precision,
    Sharpness, Solver, Space, Specular, SpecularPower, Variance, Visibility,
};
use thiserror::Error;

use crate::host;
use crate::package::Assumption;

/// Width and height of a light's tile where nobody says otherwise. 128 takes 1 to 8 % off the relative MSE against paths for
/// four times the texels.
pub const TILE: u32 = 64;
/// The points of each light's map with `imperfect` where nobody says otherwise.
pub const POINTS: u32 = 8192;
/// The near distance where nobody says otherwise. Chosen from 0, 1, 1.25, 1.5, 1.75, 2, 3, 4, 8 for the least geometric mean
/// of the relative MSE against paths on cornell, columns and atrium, K = 0.25, by
/// `what_each_parameter_of_maps_brings` of `tests/src/visibility/picture.rs`; `docs/numerics.md` has its numbers.
pub const NEAR_SCALE: f32 = 1.5;
/// The bias where nobody says otherwise: the least one without acne.
pub const BIAS_SCALE: f32 = 1.0;

/// A setting that cannot be.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum SettingsError {
    /// A number is out of its range.
    #[error("{name} is {value}, and must be {range}")]
    Range {
        /// The setting.
        name: &'static str,
        /// Its value.
        value: String,
        /// What would be right.
        range: String,
    },
    /// There is no such axis.
    #[error("there is no axis '{axis}' to set; there are: {}", known.join(", "))]
    UnknownAxis {
        /// What was asked for.
        axis: String,
        /// The axes that exist.
        known: Vec<&'static str>,
    },
    /// There is no such value on the axis.
    #[error("{0}")]
    UnknownValue(String),
    /// The values exclude each other.
    #[error("{id} is excluded by the rule '{rule}': {reason}")]
    Excluded {
        /// The variant that would be needed.
        id: String,
        /// The rule.
        rule: &'static str,
        /// Why.
        reason: &'static str,
    },
    /// The device cannot do it.
    #[error("{what} needs {needs}, which this device lacks; {instead}")]
    Unsupported {
        /// The setting.
        what: &'static str,
        /// What it needs.
        needs: &'static str,
        /// What would work.
        instead: &'static str,
    },
}

/// What the indirect light is made of.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// Width and height of the picture in pixels.
    pub size: [u32; 2],
    /// Width and height of the reflective shadow map, at least 1; a multiple of 4 with a point light. What is kept of a map
    /// whose size is no power of two is padded to the next one.
    pub rsm_size: u32,
    /// Number of virtual lights, 1 to 65536.
    pub count: u32,
    /// Number of the camera's virtual lights, 1 to 65536: what the bidirectional density is made of.
    pub camera_count: u32,
    /// K of Eq. (1) and Eq. (3), above 0.
    pub size_factor: f32,
    /// Bisection steps of Algorithm 1, 1 to 24; of no account with another solver.
    pub iterations: u32,
    /// The kind of the light.
    pub light: Light,
    /// The lobes that virtual lights emit.
    pub lobes: Lobes,
    /// The power of their specular lobes; ignored with diffuse lobes alone.
    pub specular_power: SpecularPower,
    /// The precision of moments and virtual lights in memory.
    pub precision: Precision,
    /// What kernels are drawn by.
    pub density: Density,
    /// How the centres of kernels or clusters are drawn.
    pub draw: Draw,
    /// Clusters in some space instead of kernels, in 32-bit precision.
    pub space: Space,
    /// How kernels are sized.
    pub kernel: Kernel,
    /// How the equation for the size of modified kernels is solved; of no account with previous kernels, whose size is
    /// in closed form.
    pub solver: Solver,
    /// How mips are filtered.
    pub filter: Filter,
    /// How virtual lights emit what their texels reflect diffusely.
    pub emitter: Emitter,
    /// Sharpness of the diffuse lobe of one texel, above 0, with the emitter `lobe` alone: 2 as printed
    /// [Tokuyoshi 2016, Appendix A.1]; 2.2925 is the least-squares fit among normalised lobes.
    pub emission_sharpness: f32,
    /// The variance of virtual lights' positions.
    pub variance: Variance,
    /// How the sharpness of virtual lights' directions follows from their mean.
    pub sharpness: Sharpness,
    /// Diffuse reflection.
    pub diffuse: Diffuse,
    /// Specular reflection.
    pub specular: Specular,
    /// The distribution of microfacet normals.
    pub ndf: Ndf,
    /// The visibility of virtual lights; with anything but `none` the shading pass reads maps of them.
    pub visibility: Visibility,
    /// Points that each virtual light sees of the scene, 1 to 1048576, with imperfect visibility.
    pub shadow_points: u32,
    /// Width and height of a virtual light's map in texels, with any visibility: a power of two, 8 to 256, with imperfect
    /// visibility at most 64.
    pub light_tile: u32,
    /// What lies within this many standard deviations of a light's positions does not hide it: at least 0.
    pub near_scale: f32,
    /// The bias of lights' maps, in units of the smallest one that keeps a plane from shadowing itself: 0 to 4.
    pub bias_scale: f32,
    /// Draws every surface with the variant that can do everything, whether it needs it or not: what the result of
    /// leaving things out is compared with.
    pub complete: bool,
    /// What was taken to be so of the scene when these were derived from it. A scene of which something else is so by now,
    /// and that needs more, is refused. Nothing where a person chose.
    pub assumed: Vec<Assumption>,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            size: [640, 360],
            rsm_size: 256,
            count: 1024,
            camera_count: 2048,
            size_factor: 1.0,
            iterations: 12,
            light: Light::Spot,
            lobes: Lobes::Both,
            specular_power: SpecularPower::F0,
            precision: Precision::F32,
            density: Density::Power,
            draw: Draw::Warped,
            space: Space::None,
            kernel: Kernel::Modified,
            solver: Solver::Bracketed,
            filter: Filter::Exact,
            emitter: Emitter::Cosine,
            emission_sharpness: 2.0,
            variance: Variance::Trace,
            sharpness: Sharpness::Exact,
            diffuse: Diffuse::Fitted,
            specular: Specular::Asg,
            ndf: Ndf::Ggx,
            visibility: Visibility::None,
            shadow_points: POINTS,
            light_tile: TILE,
            near_scale: NEAR_SCALE,
            bias_scale: BIAS_SCALE,
            complete: false,
            assumed: Vec::new(),
        }
    }
}

/// The axes that `set` knows.
pub const AXES: [&str; 17] = [
    "light",
    "lobes",
    "specular_power",
    "precision",
    "density",
    "draw",
    "kernel",
    "solver",
    "filter",
    "space",
    "emitter",
    "variance",
    "sharpness",
    "visibility",
    "diffuse",
    "specular",
    "ndf",
];

/// The parameters that `set` knows: numbers, with what they set in [`Settings`].
pub const PARAMETERS: [(&str, Parameter); 10] = [
    ("lights", Parameter::Whole(|settings| &mut settings.count)),
    ("map", Parameter::Whole(|settings| &mut settings.rsm_size)),
    ("camera_lights", Parameter::Whole(|settings| &mut settings.camera_count)),
    ("iterations", Parameter::Whole(|settings| &mut settings.iterations)),
    ("tile", Parameter::Whole(|settings| &mut settings.light_tile)),
    ("shadow_points", Parameter::Whole(|settings| &mut settings.shadow_points)),
    ("size_factor", Parameter::Real(|settings| &mut settings.size_factor)),
    ("emission_sharpness", Parameter::Real(|settings| &mut settings.emission_sharpness)),
    ("near_scale", Parameter::Real(|settings| &mut settings.near_scale)),
    ("bias_scale", Parameter::Real(|settings| &mut settings.bias_scale)),
];

/// Where a parameter stands.
#[derive(Clone, Copy)]
pub enum Parameter {
    /// A whole number.
    Whole(fn(&mut Settings) -> &mut u32),
    /// A real number.
    Real(fn(&mut Settings) -> &mut f32),
}

impl Settings {
    /// Sets one parameter; whether it is one.
    fn set_parameter(&mut self, name: &str, value: &str) -> Result<bool, SettingsError> {
        let Some((name, parameter)) = PARAMETERS.iter().find(|(known, _)| *known == name) else {
            return Ok(false);
        };
        let wrong = |range: &str| SettingsError::Range {
            name,
            value: value.to_owned(),
            range: range.to_owned(),
        };
        match parameter {
            Parameter::Whole(at) => {
                *at(self) = value.parse().map_err(|_| wrong("a whole number, at least 0"))?;
            }
            Parameter::Real(at) => {
                let number: f32 = value.parse().map_err(|_| wrong("a number"))?;
                if !number.is_finite() {
                    return Err(wrong("finite"));
                }
                *at(self) = number;
            }
        }
        Ok(true)
    }

    /// The value of a parameter that `set` knows, as `set` takes it.
    pub fn parameter(&self, name: &str) -> Option<String> {
        let (_, parameter) = PARAMETERS.iter().find(|(known, _)| *known == name)?;
        let mut own = self.clone();
        Some(match parameter {
            Parameter::Whole(at) => at(&mut own).to_string(),
            Parameter::Real(at) => at(&mut own).to_string(),
        })
    }

    /// Sets one axis by the name of its value, or one parameter.
    pub fn set(&mut self, axis: &str, value: &str) -> Result<(), SettingsError> {
        fn parse<T: FromStr<Err: std::fmt::Display>>(value: &str) -> Result<T, SettingsError> {
            value.parse().map_err(|error: T::Err| SettingsError::UnknownValue(error.to_string()))
        }
        match axis {
            "light" => self.light = parse(value)?,
            "lobes" => self.lobes = parse(value)?,
            "specular_power" => self.specular_power = parse(value)?,
            "precision" => self.precision = parse(value)?,
            "density" => self.density = parse(value)?,
            "draw" => self.draw = parse(value)?,
            "space" => self.space = parse(value)?,
            "visibility" => self.visibility = parse(value)?,
            "kernel" => self.kernel = parse(value)?,
            "solver" => self.solver = parse(value)?,
            "filter" => self.filter = parse(value)?,
            "emitter" => self.emitter = parse(value)?,
            "variance" => self.variance = parse(value)?,
            "sharpness" => self.sharpness = parse(value)?,
            "diffuse" => self.diffuse = parse(value)?,
            "specular" => self.specular = parse(value)?,
            "ndf" => self.ndf = parse(value)?,
            _ => {
                if !self.set_parameter(axis, value)? {
                    let parameters = PARAMETERS.iter().map(|(name, _)| *name);
                    return Err(SettingsError::UnknownAxis {
                        axis: axis.to_owned(),
                        known: AXES.into_iter().chain(parameters).collect(),
                    });
                }
            }
        }
        Ok(())
    }

    /// The name of the value on an axis that `set` knows.
    pub fn value(&self, axis: &str) -> Option<String> {
        Some(match axis {
            "light" => self.light.to_string(),
            "lobes" => self.lobes.to_string(),
            "specular_power" => self.specular_power.to_string(),
            "precision" => self.precision.to_string(),
            "density" => self.density.to_string(),
            "draw" => self.draw.to_string(),
            "space" => self.space.to_string(),
            "visibility" => self.visibility.to_string(),
            "kernel" => self.kernel.to_string(),
            "solver" => self.solver.to_string(),
            "filter" => self.filter.to_string(),
            "emitter" => self.emitter.to_string(),
            "variance" => self.variance.to_string(),
            "sharpness" => self.sharpness.to_string(),
            "diffuse" => self.diffuse.to_string(),
            "specular" => self.specular.to_string(),
            "ndf" => self.ndf.to_string(),
            _ => return None,
        })
    }

    /// The settings in the words of a frame's description.
    pub fn configuration(&self) -> Configuration {
        let value = |axis: &&str| Some(((*axis).to_owned(), self.value(axis)?));
        let mut own = self.clone();
        let mut parameters: BTreeMap<_, _> = PARAMETERS
            .iter()
            .map(|(name, parameter)| {
                let number = match parameter {
                    Parameter::Whole(at) => Number::Whole((*at(&mut own)).into()),
                    Parameter::Real(at) => Number::Real((*at(&mut own)).into()),
                };
                ((*name).to_owned(), number)
            })
            .collect();
        for (name, side) in [("width", self.size[0]), ("height", self.size[1])] {
            parameters.insert(name.to_owned(), Number::Whole(side.into()));
        }
        let axes = AXES.iter().filter_map(value).collect();
        Configuration { axes, parameters, ..Configuration::default() }
    }

    /// Everything that is wrong with these settings on this device.
    pub fn faults(&self, device: &wgpu::Device) -> Vec<SettingsError> {
        let limits = device.limits();
        let most = limits.max_texture_dimension_2d;
        let mut faults = Vec::new();
        let mut range = |holds: bool, name: &'static str, value: String, range: String| {
            if !holds {
                faults.push(SettingsError::Range { name, value, range });
            }
        };
        for (name, pixels) in [("width", self.size[0]), ("height", self.size[1])] {
            range(
                (1..=most).contains(&pixels),
                name,
                pixels.to_string(),
                format!("between 1 and {most}, the most this device's textures have"),
            );
        }
        range(
            self.rsm_size > 0 && self.rsm_size.next_power_of_two() <= most,
            "the size of the reflective shadow map",
            self.rsm_size.to_string(),
            format!("between 1 and {most}"),
        );
        range(
            self.light != Light::Point || self.rsm_size.is_multiple_of(4),
            "the size of a point light's reflective shadow map",
            self.rsm_size.to_string(),
            "a multiple of 4, for its six faces are tiles of it".to_owned(),
        );
        let bidirectional = self.density == Density::Bidirectional;
        range(
            !bidirectional || self.size.iter().all(|side| side.next_power_of_two() <= most),
            "the picture of a bidirectional density",
            format!("{} x {}", self.size[0], self.size[1]),
            format!("at most {most} each way when it is padded to a power of two"),
        );
        range(
            (1..=65536).contains(&self.camera_count),
            "the number of the camera's lights",
            self.camera_count.to_string(),
            "1 to 65536".to_owned(),
        );
        range(
            self.space == Space::None || self.precision == Precision::F32,
            "the precision of clusters",
            self.precision.to_string(),
            "f32; their sums are not held in halves".to_owned(),
        );
        range(
            self.light != Light::Camera,
            "the light",
            self.light.to_string(),
            "spot, directional or point; the camera lights nothing".to_owned(),
        );
        range(
            (1..=65536).contains(&self.count),
            "the number of lights",
            self.count.to_string(),
            "1 to 65536".to_owned(),
        );
        range(
            self.size_factor > 0.0 && self.size_factor.is_finite(),
            "the size factor K",
            self.size_factor.to_string(),
            "above 0 and finite".to_owned(),
        );
        range(
            (1..=24).contains(&self.iterations),
            "the number of iterations",
            self.iterations.to_string(),
            "1 to 24".to_owned(),
        );
        range(
            self.emission_sharpness > 0.0 && self.emission_sharpness <= 1e6,
            "the sharpness of the diffuse lobe",
            self.emission_sharpness.to_string(),
            "above 0 and at most 1e6".to_owned(),
        );
        let shade = self.shade();
        if let Some(exclusion) = shade.excluded() {
            let (rule, reason) = (exclusion.name, exclusion.reason);
            faults.push(SettingsError::Excluded { id: shade.id(), rule, reason });
        }
        let sample = self.sample();
        if let Some(exclusion) = sample.excluded() {
            let (rule, reason) = (exclusion.name, exclusion.reason);
            faults.push(SettingsError::Excluded { id: sample.id(), rule, reason });
        }
        if self.filter == Filter::Hardware
            && !device.features().contains(wgpu::Features::FLOAT32_FILTERABLE)
        {
            faults.push(SettingsError::Unsupported {
                what: "filter = hardware",
                needs: "filterable 32-bit float textures",
                instead: "filter = exact works everywhere",
            });
        }
        faults
    }

    /// The power of specular lobes, as the variants of the passes have it: F0 where there are none.
    pub fn specular_power(&self) -> SpecularPower {
        match self.lobes {
            Lobes::Diffuse => SpecularPower::F0,
            Lobes::Both => self.specular_power,
        }
    }

    /// The variant of the density pass.
    pub fn density(&self) -> sglow_shaders::density::Density {
        density_variant(self.density, self.emitter, self.lobes, self.specular_power())
    }

    /// The variant of the sampling pass.
    pub fn sample(&self) -> sglow_shaders::sample::Sample {
        sglow_shaders::sample::Sample {
            draw: self.draw,
            kernel: self.kernel,
            solver: match self.kernel {
                Kernel::Previous => Solver::None,
                Kernel::Modified => self.solver,
            },
            filter: self.filter,
            variance: self.variance,
            sharpness: self.sharpness,
            lobes: self.lobes,
            precision: self.precision,
        }
    }

    /// The variant of the shading pass.
    pub fn shade(&self) -> sglow_shaders::shade::Shade {
        sglow_shaders::shade::Shade {
            emitter: self.emitter,
            diffuse: self.diffuse,
            specular: self.specular,
            ndf: self.ndf,
            lobes: self.lobes,
            precision: self.precision,
            visibility: self.visibility,
        }
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

/// The variant of the density pass: only the bidirectional density evaluates what the camera's lights emit, by the cosine for
/// all emitters that have normals, and divides by the specular power.
pub(crate) fn density_variant(
    density: Density,
    emitter: Emitter,
    lobes: Lobes,
    specular_power: SpecularPower,
) -> sglow_shaders::density::Density {
    let importance = match (density, emitter) {
        (Density::Bidirectional, Emitter::Lobe) => Importance::Lobe,
        (Density::Bidirectional, _) => Importance::Cosine,
        _ => Importance::None,
    };
    let specular_power = match density {
        Density::Power | Density::Reflectance => SpecularPower::F0,
        Density::Bidirectional => specular_power,
    };
    sglow_shaders::density::Density { density, importance, lobes, specular_power }
}
