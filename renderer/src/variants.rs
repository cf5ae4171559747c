//! The variants of passes that settings lead to.

use sglow_runtime::settings::Settings;
use sglow_shaders::{Density, SpecularPower};

/// Variants by the settings' axes, each with what follows from others.
pub trait Variants {
    /// The power of specular lobes, as the variants of the passes have it: F0 where there are none.
    fn specular_power(&self) -> SpecularPower;

    /// The variant of the density pass: only the bidirectional density divides by the specular power.
    fn density(&self) -> sglow_shaders::density::Density;

    /// The variant of the sampling pass.
    fn sample(&self) -> sglow_shaders::sample::Sample;

    /// The variant of the shading pass.
    fn shade(&self) -> sglow_shaders::shade::Shade;
}

impl Variants for Settings {
    fn specular_power(&self) -> SpecularPower {
        self.clone().followed().specular_power
    }

    fn density(&self) -> sglow_shaders::density::Density {
        let own = sglow_shaders::density::Density::from(self);
        match self.density {
            Density::Power | Density::Reflectance => {
                sglow_shaders::density::Density { specular_power: SpecularPower::F0, ..own }
            }
            Density::Bidirectional => own,
        }
    }

    fn sample(&self) -> sglow_shaders::sample::Sample {
        self.into()
    }

    fn shade(&self) -> sglow_shaders::shade::Shade {
        self.into()
    }
}
