//! The configurations that bounds are about.

use sglow_results::frontier::promise::named;
use sglow_runtime::settings::Settings;
use sglow_shaders::{
    Cut, Density, Diffuse, Draw, Emitter, Filter, Kernel, Precision, Sharpness, Solver, Space,
    Specular, SpecularPower, Variance, Visibility,
};

/// The number of flat lights that promises are about, unless they say another.
const LIGHTS: u32 = 1024;
/// The roots of a cut without visibility, which needs no more: they begin the search alone.
const BARE_ROOTS: u32 = 16;

/// Kernels that are drawn by power, without visibility, all else as in `base`; 1024 where it has a cut.
pub(super) fn kernels(base: &Settings) -> Settings {
    let usual = if base.cut == Cut::None {
        base.clone()
    } else {
        Settings { lights: LIGHTS, near_scale: Settings::default().near_scale, ..base.clone() }
    };
    Settings {
        density: Density::Power,
        draw: Draw::Warped,
        space: Space::None,
        cut: Cut::None,
        kernel: Kernel::Modified,
        solver: Solver::Bracketed,
        filter: Filter::Exact,
        precision: Precision::F32,
        visibility: Visibility::None,
        ..usual
    }
}

/// The configurations that promises are about, by what they are, about the default of a scene, with a cut as scenes with
/// `occluders` have it: the papers' configuration is a preset, which the caller adds.
#[must_use]
pub fn configurations(base: &Settings, occluders: &Settings) -> Vec<(&'static str, Settings)> {
    let kernels = Settings { visibility: base.visibility, lights: LIGHTS, ..kernels(base) };
    let flat = |lights| Settings {
        space: Space::World,
        emitter: Emitter::Disc,
        lights,
        ..kernels.clone()
    };
    let bare = |of: Settings| Settings { visibility: Visibility::None, ..of };
    let specular = if base.specular == Specular::None { Specular::None } else { Specular::Asg };
    let old = Settings {
        specular_power: SpecularPower::F0,
        emitter: Emitter::Lobe,
        emission_sharpness: 2.0,
        variance: Variance::Trace,
        sharpness: Sharpness::Toksvig,
        size_factor: 1.0,
        diffuse: Diffuse::Fitted,
        specular,
        ..bare(kernels.clone())
    };
    let cut = |lights| Settings {
        space: Space::Tree,
        cut: Cut::Tile,
        emitter: Emitter::Disc,
        lights,
        near_scale: occluders.near_scale,
        ..kernels.clone()
    };
    let emitter = |emitter| Settings { emitter, ..base.clone() };
    vec![
        (named::DEFAULT, base.clone()),
        (named::OLD, old),
        (named::FLAT, flat(LIGHTS)),
        (named::FLAT_64, flat(64)),
        (named::BARE_64, bare(flat(64))),
        (named::BARE_256, bare(flat(256))),
        (named::BARE_1024, bare(flat(LIGHTS))),
        (named::BARE_16384, bare(flat(16_384))),
        (named::BARE, bare(cut(BARE_ROOTS))),
        (named::CUT, cut(occluders.lights)),
        (named::LOBE, emitter(Emitter::Lobe)),
        (named::COSINE, emitter(Emitter::Cosine)),
    ]
}

#[cfg(test)]
mod tests {
    use sglow_runtime::package::Package;

    use super::*;
    use crate::frontier::configuration;
    use crate::frontier::space::Space;

    #[test]
    fn the_configurations_are_legal_and_differ() {
        let package = Package::embedded();
        let facts = [("occluders".to_owned(), true)].into();
        let space = Space::new(package.description().unwrap(), &facts);
        let base = space.of_class(&["occluders", "specular"]).unwrap();
        let all = configurations(&base, &space.of_class(&["occluders"]).unwrap());
        for (what, settings) in &all {
            assert!(space.legal(settings), "{what}");
        }
        let names: std::collections::BTreeSet<String> =
            all.iter().map(|(_, one)| configuration::name(one, &base)).collect();
        assert_eq!(names.len(), all.len());
    }
}
