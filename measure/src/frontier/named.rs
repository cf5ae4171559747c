//! The configurations that bounds are about.

use sglow_results::frontier::promise::named;
use sglow_runtime::settings::Settings;
use sglow_shaders::{
    Cut, Density, Diffuse, Draw, Emitter, Filter, Kernel, Precision, Sharpness, Solver, Space,
    Specular, SpecularPower, Variance, Visibility,
};

use super::screen;

/// The number of lights that promises are about, unless they say another.
const LIGHTS: u32 = 1024;

/// The configurations that promises are about, by what they are, about the default of a scene: the papers'
/// configuration is a preset, which the caller adds.
#[must_use]
pub fn configurations(base: &Settings) -> Vec<(&'static str, Settings)> {
    let base = &Settings { lights: LIGHTS, ..base.clone() };
    let bare = Settings { visibility: Visibility::None, ..base.clone() };
    let specular = if base.specular == Specular::None { Specular::None } else { Specular::Asg };
    let old = Settings {
        density: Density::Power,
        draw: Draw::Warped,
        kernel: Kernel::Modified,
        filter: Filter::Exact,
        precision: Precision::F32,
        specular_power: SpecularPower::F0,
        space: Space::None,
        solver: Solver::Bracketed,
        emitter: Emitter::Lobe,
        emission_sharpness: 2.0,
        variance: Variance::Trace,
        sharpness: Sharpness::Toksvig,
        size_factor: 1.0,
        diffuse: Diffuse::Fitted,
        specular,
        ..bare.clone()
    };
    let cut = |lights: u32, of: &Settings| Settings {
        space: Space::Tree,
        cut: Cut::Tile,
        emitter: Emitter::Disc,
        kernel: Kernel::Modified,
        solver: Solver::Bracketed,
        filter: Filter::Exact,
        precision: Precision::F32,
        lights,
        ..of.clone()
    };
    let emitter = |value| screen::with(base, "emitter", value).unwrap_or_else(|| base.clone());
    vec![
        (named::DEFAULT, base.clone()),
        (named::OLD, old),
        (named::BARE_64, Settings { lights: 64, ..bare.clone() }),
        (named::BARE_256, Settings { lights: 256, ..bare.clone() }),
        (named::BARE_16384, Settings { lights: 16_384, ..bare.clone() }),
        (named::CUT_BARE, cut(16, &bare)),
        (named::CUT, cut(screen::ROOTS, base)),
        (named::BARE, bare),
        (named::LOBE, emitter("lobe")),
        (named::COSINE, emitter("cosine")),
    ]
}

#[cfg(test)]
mod tests {
    use sglow_renderer::variants::Variants as _;

    use super::*;

    #[test]
    fn the_configurations_are_legal_and_differ() {
        let base = Settings {
            visibility: Visibility::ShadowMap,
            space: Space::World,
            emitter: Emitter::Disc,
            ..Settings::default()
        };
        let all = configurations(&base);
        for (what, settings) in &all {
            assert!(settings.shade().excluded().is_none(), "{what}");
            assert!(settings.sample().excluded().is_none(), "{what}");
        }
        let names: std::collections::BTreeSet<String> =
            all.iter().map(|(_, one)| super::super::configuration::name(one, &base)).collect();
        assert_eq!(names.len(), all.len());
    }
}
