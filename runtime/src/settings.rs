//! What a person chooses: sizes, numbers, and a value on each axis.

use std::str::FromStr;

use sglow_shaders::{Diffuse, Filter, Kernel, Light, Lobes, Ndf, Precision, Specular, Visibility};
use thiserror::Error;

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
    /// Width and height of the reflective shadow map: a power of two, at least 8.
    pub rsm_size: u32,
    /// Number of virtual lights, 1 to 65536.
    pub count: u32,
    /// K of Eq. (1) and Eq. (3), above 0.
    pub size_factor: f32,
    /// Bisection steps of Algorithm 1, 1 to 24.
    pub iterations: u32,
    /// The kind of the light.
    pub light: Light,
    /// The lobes that virtual lights emit.
    pub lobes: Lobes,
    /// The precision of moments and virtual lights in memory.
    pub precision: Precision,
    /// How kernels are sized.
    pub kernel: Kernel,
    /// How mips are filtered.
    pub filter: Filter,
    /// Diffuse reflection.
    pub diffuse: Diffuse,
    /// Specular reflection.
    pub specular: Specular,
    /// The distribution of microfacet normals.
    pub ndf: Ndf,
    /// What hides virtual lights; with anything but `none` the shading pass reads maps: see
    /// [`crate::indirect::Indirect::encode_shade_visible`].
    pub visibility: Visibility,
    /// Draws every surface with the variant that can do everything, whether it needs it or not: what the result of
    /// leaving things out is compared with.
    pub complete: bool,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            size: [640, 360],
            rsm_size: 256,
            count: 1024,
            size_factor: 1.0,
            iterations: 12,
            light: Light::Spot,
            lobes: Lobes::Both,
            precision: Precision::F32,
            kernel: Kernel::Modified,
            filter: Filter::Exact,
            diffuse: Diffuse::Fitted,
            specular: Specular::Asg,
            ndf: Ndf::Ggx,
            visibility: Visibility::None,
            complete: false,
        }
    }
}

/// The axes that `set` knows.
pub const AXES: [&str; 8] =
    ["light", "lobes", "precision", "kernel", "filter", "diffuse", "specular", "ndf"];

impl Settings {
    /// Sets one axis by the name of its value.
    pub fn set(&mut self, axis: &str, value: &str) -> Result<(), SettingsError> {
        fn parse<T: FromStr<Err: std::fmt::Display>>(value: &str) -> Result<T, SettingsError> {
            value.parse().map_err(|error: T::Err| SettingsError::UnknownValue(error.to_string()))
        }
        match axis {
            "light" => self.light = parse(value)?,
            "lobes" => self.lobes = parse(value)?,
            "precision" => self.precision = parse(value)?,
            "kernel" => self.kernel = parse(value)?,
            "filter" => self.filter = parse(value)?,
            "diffuse" => self.diffuse = parse(value)?,
            "specular" => self.specular = parse(value)?,
            "ndf" => self.ndf = parse(value)?,
            _ => {
                return Err(SettingsError::UnknownAxis {
                    axis: axis.to_owned(),
                    known: AXES.to_vec(),
                });
            }
        }
        Ok(())
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
            self.rsm_size.is_power_of_two() && (8..=most).contains(&self.rsm_size),
            "the size of the reflective shadow map",
            self.rsm_size.to_string(),
            format!("a power of two between 8 and {most}"),
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
        let shade = self.shade();
        if let Some(exclusion) = shade.excluded() {
            let (rule, reason) = (exclusion.name, exclusion.reason);
            faults.push(SettingsError::Excluded { id: shade.id(), rule, reason });
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

    /// The variant of the shading pass.
    pub fn shade(&self) -> sglow_shaders::shade::Shade {
        sglow_shaders::shade::Shade {
            diffuse: self.diffuse,
            specular: self.specular,
            ndf: self.ndf,
            lobes: self.lobes,
            precision: self.precision,
            visibility: self.visibility,
        }
    }
}
