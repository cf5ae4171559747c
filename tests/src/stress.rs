//! Kernels on densities that stress them: powers that must be kept, and those that the previous method loses.

use sglow_oracle::fis::stress::{Random, Stress};
use sglow_runtime::density::{Sampled, sample};
use sglow_runtime::package::Package;
use sglow_runtime::settings::Settings;
use sglow_shaders::Kernel;

use crate::common::{broken, gpu};

const SIZE: u32 = 256;

fn run(stress: Stress, kernel: Kernel, package: &Package) -> Sampled {
    let settings = Settings { rsm_size: SIZE, count: 1024, kernel, ..Settings::default() };
    let density = stress.texels(SIZE as usize, 1);
    // Power that follows the density but for a reflectance; with the density itself Eq. (5) is exact by construction.
    let mut random = Random::new(2);
    let power: Vec<f32> =
        density.iter().map(|weight| weight * (0.4 + 0.4 * random.uniform() as f32)).collect();
    sample(gpu(), package, &settings, &density, &power).unwrap()
}

/// The summed power over the true total.
fn ratio(sampled: &Sampled) -> f64 {
    sampled.powers.iter().sum::<f64>() / sampled.total
}

#[test]
fn modified_keeps_the_power_where_previous_does_not() {
    for (name, stress) in [("ring", Stress::Ring), ("noise-2", Stress::Noise { sigma: 2.0 })] {
        let modified = ratio(&run(stress, Kernel::Modified, &Package::embedded()));
        let previous = ratio(&run(stress, Kernel::Previous, &Package::embedded()));
        println!("{name}: modified {modified:.4}, previous {previous:.4}");
        assert!((modified - 1.0).abs() <= 0.03, "{name}: modified gives {modified} of the total");
        assert!((previous - 1.0).abs() > 0.03, "{name}: previous gives {previous} of the total");
    }
}

#[test]
fn a_dropped_factor_is_noticed() {
    let package = broken(
        "sample-warped-modified-exact-diffuse-f32",
        "texels / (count",
        "0.95 * texels / (count",
    );
    let modified = ratio(&run(Stress::Ring, Kernel::Modified, &package));
    assert!((modified - 1.0).abs() > 0.03, "{modified}");
}

#[test]
fn every_density_gives_finite_lights() {
    for (name, stress) in Stress::ALL {
        for kernel in [Kernel::Previous, Kernel::Modified] {
            let sampled = run(stress, kernel, &Package::embedded());
            assert!(
                sampled.powers.iter().all(|power| power.is_finite() && *power >= 0.0),
                "{name}, {kernel}"
            );
            let lit = sampled.powers.iter().any(|&power| power > 0.0);
            assert_eq!(lit, stress != Stress::Zero, "{name}, {kernel}");
        }
    }
}
