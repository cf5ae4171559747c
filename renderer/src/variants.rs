//! The variants of passes that settings lead to.

use sglow_runtime::settings::Settings;
use sglow_shaders::{Density, Emitter, Importance, Kernel, Lobes, Solver, SpecularPower};

/// Variants by the settings' axes, each with what follows from others.
pub trait Variants {
    /// The power of specular lobes, as the variants of the passes have it: F0 where there are none.
    fn specular_power(&self) -> SpecularPower;

    /// The variant of the density pass: only the bidirectional density evaluates what the camera's lights emit, by the cosine
    /// for all emitters that have normals, and divides by the specular power.
    fn density(&self) -> sglow_shaders::density::Density;

    /// The variant of the sampling pass.
    fn sample(&self) -> sglow_shaders::sample::Sample;

    /// The variant of the shading pass.
    fn shade(&self) -> sglow_shaders::shade::Shade;
}

impl Variants for Settings {
    fn specular_power(&self) -> SpecularPower {
        match self.lobes {
            Lobes::Diffuse => SpecularPower::F0,
            Lobes::Both => self.specular_power,
        }
    }

    fn density(&self) -> sglow_shaders::density::Density {
        let importance = match (self.density, self.emitter) {
            (Density::Bidirectional, Emitter::Lobe) => Importance::Lobe,
            (Density::Bidirectional, _) => Importance::Cosine,
            _ => Importance::None,
        };
        let specular_power = match self.density {
            Density::Power | Density::Reflectance => SpecularPower::F0,
            Density::Bidirectional => self.specular_power(),
        };
        let (density, lobes) = (self.density, self.lobes);
        sglow_shaders::density::Density { density, importance, lobes, specular_power }
    }

    fn sample(&self) -> sglow_shaders::sample::Sample {
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

    fn shade(&self) -> sglow_shaders::shade::Shade {
        sglow_shaders::shade::Shade {
            emitter: self.emitter,
            diffuse: self.diffuse,
            specular: self.specular,
            ndf: self.ndf,
            lobes: self.lobes,
            precision: self.precision,
            visibility: self.visibility,
            output: self.output,
            cut: self.cut,
        }
    }
}
