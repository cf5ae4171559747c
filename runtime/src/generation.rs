//! Virtual lights from one map, of the light or of the camera: moments, density, mips, kernels.

use sglow_shaders::{
    Density, Draw, Emitter, Light, Lobes, Precision, SglowKernel, Space, SpecularPower, Texel,
    sample::Sample,
};

use crate::cluster::ClusterSettings;
use crate::metropolis::MetropolisSettings;
use crate::pyramid::{Levels, MipPasses, pyramid_bytes};
use crate::settings::density_variant;

/// What lights are made of.
#[derive(Clone)]
pub(crate) struct Recipe {
    /// Width and height of the map.
    pub(crate) size: [u32; 2],
    pub(crate) count: u32,
    pub(crate) light: Light,
    pub(crate) lobes: Lobes,
    pub(crate) specular_power: SpecularPower,
    pub(crate) precision: Precision,
    pub(crate) density: Density,
    pub(crate) sample: Sample,
    pub(crate) emitter: Emitter,
    /// Length of the mean direction of a texel's diffuse emission.
    pub(crate) diffuse_mean_length: f32,
    /// Clusters in some space instead of kernels.
    pub(crate) space: Space,
}

impl Recipe {
    /// Width and height of what is kept of the map. Mips of a power-of-two square hold exact means; what lies beyond the
    /// map stays zero.
    fn side(&self) -> u32 {
        self.size[0].max(self.size[1]).next_power_of_two()
    }

    fn clusters(&self) -> Option<ClusterSettings> {
        let Self { size, count, light, lobes, specular_power, space, .. } = *self;
        let diffuse_mean_length = self.diffuse_mean_length;
        let Sample { draw, variance, sharpness, .. } = self.sample;
        (space != Space::None).then_some(ClusterSettings {
            size,
            count,
            draw,
            space,
            light,
            variance,
            sharpness,
            lobes,
            specular_power,
            diffuse_mean_length,
        })
    }

    fn chains(&self) -> Option<MetropolisSettings> {
        (self.sample.draw == Draw::Metropolis).then(|| MetropolisSettings::of(self.count))
    }

    fn halves(&self) -> bool {
        self.precision == Precision::F16
    }

    /// Clusters sum what the map holds by themselves, and the reflectance is read from it, too.
    fn keeps_moments(&self) -> bool {
        self.space == Space::None || self.density != Density::Reflectance
    }

    /// With halves the moments pass writes the weight, which is the reflected power, by itself.
    fn has_density_pass(&self) -> bool {
        !(self.halves() && self.density == Density::Power)
    }

    fn keeps_weights(&self) -> bool {
        self.halves() && self.density != Density::Power
    }

    /// Layers of moments in 32 and in 16 bits.
    fn layers(&self) -> [u32; 2] {
        match (self.precision, self.lobes) {
            (Precision::F32, Lobes::Both) => [5, 0],
            (Precision::F32, Lobes::Diffuse) => [3, 0],
            (Precision::F16, Lobes::Both) => [2, 3],
            (Precision::F16, Lobes::Diffuse) => [1, 2],
        }
    }

    /// Levels of the moments: clusters need no mips.
    fn levels(&self) -> Levels {
        if self.space == Space::None { Levels::All } else { Levels::First }
    }

    fn moments_id(&self) -> String {
        let Self { light, lobes, specular_power, precision, .. } = *self;
        let sharpness = self.sample.sharpness;
        sglow_shaders::moments::Moments { light, lobes, specular_power, sharpness, precision }.id()
    }

    fn density_id(&self) -> String {
        density_variant(self.density, self.emitter, self.lobes, self.specular_power).id()
    }

    /// The variants that it runs.
    pub(crate) fn variants(&self) -> Vec<String> {
        let mut variants = MipPasses::variants(Texel::R32float);
        variants.extend(self.keeps_moments().then(|| self.moments_id()));
        variants.extend(self.has_density_pass().then(|| self.density_id()));
        if let Some(clusters) = self.clusters() {
            variants.extend(clusters.variants());
        } else {
            variants.extend(MipPasses::variants(Texel::Rgba32float));
            variants.push(self.sample.id());
        }
        if self.halves() {
            variants.extend(MipPasses::variants(Texel::Rgba16float));
        }
        variants.extend(self.chains().into_iter().flat_map(|chains| chains.variants()));
        variants
    }

    /// The bytes that it keeps, by name; textures first.
    pub(crate) fn bytes(&self) -> [Vec<(&'static str, u64)>; 2] {
        let [layers, half_layers] = self.layers();
        let texels = |layers: u32, texel, levels| pyramid_bytes(self.side(), layers, texel, levels);
        let mut textures = Vec::new();
        if self.keeps_moments() {
            textures.push(("moments", texels(layers, 16, self.levels())));
        }
        if self.halves() {
            textures.push(("half moments", texels(half_layers, 8, Levels::All)));
        }
        if self.keeps_weights() {
            textures.push(("weights", texels(1, 4, Levels::All)));
        }
        textures.push(("density", texels(1, 4, Levels::All)));
        let count = u64::from(self.count);
        let mut buffers = match self.clusters() {
            Some(clusters) => clusters.bytes(),
            None => vec![
                ("vsgls", count * vsgl_size(self.lobes, self.precision)),
                ("kernels", count * size_of::<SglowKernel>() as u64),
            ],
        };
        buffers.extend(self.chains().map(|chains| ("chains", chains.bytes())));
        [textures, buffers]
    }
}

/// The bytes of a virtual light.
pub(crate) fn vsgl_size(lobes: Lobes, precision: Precision) -> u64 {
    let size = match (precision, lobes) {
        (Precision::F32, Lobes::Both) => size_of::<sglow_shaders::SglowVsglBoth>(),
        (Precision::F32, Lobes::Diffuse) => size_of::<sglow_shaders::SglowVsglDiffuse>(),
        (Precision::F16, Lobes::Both) => size_of::<sglow_shaders::SglowPackedVsglBoth>(),
        (Precision::F16, Lobes::Diffuse) => size_of::<sglow_shaders::SglowPackedVsglDiffuse>(),
    };
    size as u64
}
