//! Kernels on densities that stress them: powers that must be kept, and those that the previous method loses.

use sglow_oracle::Bounded;
use sglow_oracle::fis::stress::{Random, Stress};
use sglow_oracle::fis::{bracketed_level, lattice, warp};
use sglow_oracle::rsm::Pyramid;
use sglow_renderer::density::{Sampled, sample, times};
use sglow_runtime::package::Package;
use sglow_runtime::settings::Settings;
use sglow_shaders::{Kernel, Solver};

use crate::common::{Comparison, broken, gpu};

const SIZE: u32 = 256;

fn run(stress: Stress, kernel: Kernel, package: &Package) -> Sampled {
    run_solver(stress, kernel, Settings::default().solver, package)
}

fn run_solver(stress: Stress, kernel: Kernel, solver: Solver, package: &Package) -> Sampled {
    let settings = Settings { rsm_size: SIZE, count: 1024, kernel, solver, ..Settings::default() };
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
        let package = Package::embedded();
        let bisected = ratio(&run_solver(stress, Kernel::Modified, Solver::Bisection, &package));
        assert!((bisected - 1.0).abs() <= 0.03, "{name}: bisection gives {bisected} of the total");
        let previous = ratio(&run(stress, Kernel::Previous, &package));
        println!("{name}: modified {modified:.4}, previous {previous:.4}");
        assert!((modified - 1.0).abs() <= 0.03, "{name}: modified gives {modified} of the total");
        assert!((previous - 1.0).abs() > 0.03, "{name}: previous gives {previous} of the total");
    }
}

#[test]
fn a_dropped_factor_is_noticed() {
    let package = broken(
        "sample-warped-modified-bracketed-exact-trace-exact-diffuse-f32",
        "texels / (f32(count)",
        "0.95 * texels / (f32(count)",
    );
    let modified = ratio(&run(Stress::Ring, Kernel::Modified, &package));
    assert!((modified - 1.0).abs() > 0.03, "{modified}");
}

#[test]
fn every_density_gives_finite_lights() {
    for (name, stress) in Stress::ALL {
        for (kernel, solver) in [
            (Kernel::Previous, Solver::None),
            (Kernel::Modified, Solver::Bisection),
            (Kernel::Modified, Solver::Bracketed),
        ] {
            let sampled = run_solver(stress, kernel, solver, &Package::embedded());
            assert!(
                sampled.powers.iter().all(|power| power.is_finite() && *power >= 0.0),
                "{name}, {kernel}, {solver}"
            );
            let lit = sampled.powers.iter().any(|&power| power > 0.0);
            assert_eq!(lit, stress != Stress::Zero, "{name}, {kernel}");
        }
    }
}

/// The text of the bracketed solver with the number of its look-ups in the place of the level that it finds.
fn counting(look_ups: &str, end: &str) -> Package {
    let id = "sample-warped-modified-bracketed-exact-trace-exact-diffuse-f32";
    let mut package = broken(id, "var ground = 1.0;", "var ground = 1.0;\n    var counted = 0.0;");
    for (from, to) in [
        ("ground = select(", "counted += 1.0;\n        ground = select("),
        ("return SglowSize(0.0, ground)", "return SglowSize(counted, ground)"),
        ("return SglowSize(found,", "return SglowSize(counted,"),
        ("SGLOW_LOOK_UPS: i32 = 5;", look_ups),
        ("abs(more_level - less_level) <= 1", end),
    ] {
        let text = package.text(id).unwrap().to_owned();
        assert!(text.contains(from), "{id} has no '{from}'");
        package = package.with_text(id, text.replace(from, to));
    }
    package
}

#[test]
fn five_look_ups_are_the_most() {
    let most = |stress, package: &Package| {
        let sampled = run(stress, Kernel::Modified, package);
        sampled.kernels.iter().map(|kernel| kernel.level).fold(0.0, f32::max)
    };
    let package = counting("SGLOW_LOOK_UPS: i32 = 5;", "abs(more_level - less_level) <= 1");
    for (name, stress) in Stress::ALL {
        let most = most(stress, &package);
        println!("{name}: {most} look-ups");
        assert!(most <= 5.0, "{name}: {most}");
    }
    // Negative control: one that goes on to a sixth.
    let package = counting("SGLOW_LOOK_UPS: i32 = 6;", "abs(more_level - less_level) < 0");
    let most = most(Stress::Noise { sigma: 3.0 }, &package);
    assert!(most > 5.0, "{most}");
}

/// The levels of the bracketed solver against the oracle's.
fn levels(stress: Stress, package: &Package) -> Comparison {
    let sampled = run(stress, Kernel::Modified, package);
    let texels = stress.texels(SIZE as usize, 1).into_iter().map(Bounded::exact).collect();
    let density = Pyramid::build(SIZE as usize, texels).unwrap();
    let mut comparison = Comparison::default();
    let mut undecided = 0;
    for (index, kernel) in (0..).zip(&sampled.kernels) {
        let warped = warp(&density, lattice::point::<Bounded>(index, 1024));
        if !warped.certain {
            undecided += 1;
            continue;
        }
        let centre = kernel.centre.map(Bounded::exact);
        let [low, high] = bracketed_level(&density, centre, warped.texel, 1024, 1.0).level.certain;
        undecided += usize::from(high - low > 0.5);
        let expected = Bounded::with_error(0.5 * (low + high), 0.5 * (high - low) + 1e-12);
        comparison.number(|| format!("level of kernel {index}"), kernel.level, expected);
    }
    assert!(undecided * 10 < 1024, "{undecided} of 1024 are left open by rounding");
    comparison
}

#[test]
fn the_bracketed_levels_agree_with_the_oracle() {
    for (name, stress) in Stress::ALL {
        // On equal texels, as on a checkerboard's levels, every second comparison of the warp is a tie.
        if !matches!(stress, Stress::Zero | Stress::Checkerboard) {
            levels(stress, &Package::embedded()).assert_holds(name);
        }
    }
    let id = "sample-warped-modified-bracketed-exact-trace-exact-diffuse-f32";
    for (from, to, what) in [
        ("step < 2;", "step < 1;", "one step less"),
        ("select(-1.0, 1.0, rising)", "1.0", "the other zero"),
        ("min(guided.ample, SGLOW_LOOK_UPS)", "1", "no look for the lowest root"),
    ] {
        levels(Stress::Noise { sigma: 3.0 }, &broken(id, from, to)).assert_fails(what);
    }
}

/// Times are for people to read; here they have to come out at all, one for each of the settings.
#[test]
fn settings_are_timed_in_turn() {
    let settings =
        |kernel, solver| Settings { rsm_size: 64, kernel, solver, ..Settings::default() };
    let candidates = [
        settings(Kernel::Previous, Solver::None),
        settings(Kernel::Modified, Solver::Bisection),
        settings(Kernel::Modified, Solver::Bracketed),
    ];
    let density = Stress::Ring.texels(64, 1);
    let times = times(gpu(), &Package::embedded(), &candidates, &density, &density).unwrap();
    println!("{times:?}");
    assert!(times.len() == 3 && times.iter().all(|time| !time.is_zero()));
}
