//! Kernels and the lights made of them: `shaders/src/fis`, `shaders/src/vsgl`.

use sglow_oracle::fis::{lattice, previous_level, warp};
use sglow_oracle::rsm::{Moments, Pyramid};
use sglow_oracle::vsgl::sample::level_by;
use sglow_oracle::vsgl::{self, Kernel as OracleKernel, Lobe, Vsgl, packed};
use sglow_oracle::{Bounded, Vector3};
use sglow_renderer::density::sample;
use sglow_renderer::stages::Stages as _;
use sglow_renderer::{readback, reference};
use sglow_runtime::package::Package;
use sglow_runtime::settings::Settings;
use sglow_shaders::{
    Emitter, Filter, Kernel, Lobes, Precision, SglowKernel, Sharpness, Solver, Variance,
};

use crate::common::{Comparison, KINDS, Run, broken, gpu, small, whole_space};

fn density(run: &Run) -> Pyramid<Bounded> {
    let texture = run.indirect.density().unwrap();
    let levels = (0..texture.mip_level_count())
        .map(|level| {
            let texels = readback::texture(gpu(), &texture, level).unwrap();
            texels.into_iter().map(|texel| Bounded::exact(texel[0])).collect()
        })
        .collect();
    Pyramid::of_levels(texture.width() as usize, levels).unwrap()
}

fn moments(run: &Run) -> Pyramid<Moments<Bounded>> {
    let texture = run.indirect.moments().unwrap();
    let levels = (0..texture.mip_level_count())
        .map(|level| reference::moments(gpu(), &run.indirect, &run.light, level).unwrap())
        .collect();
    Pyramid::of_levels(texture.width() as usize, levels).unwrap()
}

struct Comparisons {
    centres: Comparison,
    levels: Comparison,
    lights: Comparison,
    uncertain: usize,
    /// Kernels whose level rounding leaves open.
    undecided: usize,
}

fn compare(run: &Run) -> Comparisons {
    let settings = run.indirect.settings();
    let kernels: Vec<SglowKernel> =
        readback::buffer(gpu(), &run.indirect.kernels().unwrap()).unwrap();
    // What f64 holds is the f32 that was read, to the bit.
    let lights: Vec<Vsgl> = reference::lights(gpu(), &run.indirect).unwrap();
    let (density, moments) = (density(run), moments(run));
    let sample = reference::sample_settings(settings, &run.light);
    let mut comparisons = Comparisons {
        centres: Comparison::default(),
        levels: Comparison::default(),
        lights: Comparison::default(),
        uncertain: 0,
        undecided: 0,
    };
    for (index, (kernel, light)) in kernels.iter().zip(&lights).enumerate() {
        let warped = warp(&density, lattice::point::<Bounded>(index as u32, settings.count));
        if !warped.certain {
            // Rounding may lead the warp into another texel, and all that follows with it.
            comparisons.uncertain += 1;
            continue;
        }
        for axis in 0..2 {
            let name = || format!("centre {axis} of kernel {index}");
            comparisons.centres.number(name, kernel.centre[axis], warped.centre[axis]);
        }
        let centre = kernel.centre.map(Bounded::exact);
        let [x, y] = warped.texel;
        let level = match sample.kernel {
            OracleKernel::Previous => previous_level(
                density.at(0, x, y),
                density.top(),
                density.texel_count(),
                sample.count,
                sample.scale,
            ),
            OracleKernel::Modified(solver) => {
                level_by(solver, &density, centre, warped.texel, &sample)
            }
        };
        let [low, high] = level.certain;
        comparisons.undecided += usize::from(high - low > 0.5);
        let expected = Bounded::with_error(0.5 * (low + high), 0.5 * (high - low) + 1e-12);
        comparisons.levels.number(|| format!("level of kernel {index}"), kernel.level, expected);

        let expected = vsgl::sample::light_of_kernel(
            &density,
            &moments,
            centre,
            warped.texel,
            Bounded::exact(kernel.level),
            &sample,
        );
        let comparison = &mut comparisons.lights;
        let single = |vector: Vector3| vector.to_array().map(|part| part as f32);
        let position = format!("position of light {index}");
        comparison.vector(&position, single(light.position), expected.position);
        let variance = || format!("variance of light {index}");
        comparison.number(variance, light.variance as f32, expected.variance);
        if settings.precision == Precision::F32 {
            let name = || format!("mean length of light {index}");
            let length = expected.diffuse_mean_length;
            comparison.number(name, light.diffuse_mean_length as f32, length);
        }
        let expected: Vec<Lobe<Bounded>> = std::iter::once(expected.diffuse)
            .chain(expected.specular)
            .map(|lobe| match settings.precision {
                Precision::F32 => lobe,
                Precision::F16 => packed::packed(&lobe),
            })
            .collect();
        let measured: Vec<Lobe> = std::iter::once(light.diffuse).chain(light.specular).collect();
        assert_eq!(expected.len(), measured.len());
        for (lobe, (measured, expected)) in measured.into_iter().zip(expected).enumerate() {
            let name = |what: &str| format!("{what} of lobe {lobe} of light {index}");
            comparison.vector(&name("axis"), single(measured.axis), expected.axis);
            comparison.number(|| name("sharpness"), measured.sharpness as f32, expected.sharpness);
            comparison.vector(
                &name("coefficient"),
                single(measured.coefficient),
                expected.coefficient,
            );
        }
    }
    comparisons
}

/// The kernels, and how their size is found.
const KERNELS: [(Kernel, Solver); 3] = [
    (Kernel::Previous, Solver::None),
    (Kernel::Modified, Solver::Bisection),
    (Kernel::Modified, Solver::Bracketed),
];

fn settings(kernel: Kernel, lobes: Lobes) -> Settings {
    Settings { kernel, lobes, count: 200, ..small() }
}

fn halves() -> Settings {
    Settings { precision: Precision::F16, ..settings(Kernel::Modified, Lobes::Both) }
}

#[test]
fn agree_with_the_oracle() {
    for (kernel, solver) in KERNELS {
        for lobes in [Lobes::Diffuse, Lobes::Both] {
            for precision in Precision::ALL {
                let settings = Settings { solver, precision, ..settings(kernel, lobes) };
                let run = Run::new(&settings, KINDS[0], whole_space(), 3);
                let comparisons = compare(&run);
                let what = format!("{kernel}, {solver}, {lobes}, {precision}");
                println!("{what}: {} undecided", comparisons.undecided);
                assert!(comparisons.undecided * 20 < 200, "{}", comparisons.undecided);
                assert!(comparisons.uncertain * 10 < 200, "{} of 200", comparisons.uncertain);
                comparisons.centres.assert_holds(&format!("centres, {what}"));
                comparisons.levels.assert_holds(&format!("levels, {what}"));
                comparisons.lights.assert_holds(&format!("lights, {what}"));
            }
        }
    }
}

#[test]
fn lights_of_every_variance_and_sharpness_agree_with_the_oracle() {
    for variance in Variance::ALL {
        for sharpness in Sharpness::ALL {
            for emitter in [Emitter::Lobe, Emitter::Cosine] {
                let own = settings(Kernel::Modified, Lobes::Both);
                let settings = Settings { variance, sharpness, emitter, ..own };
                let run = Run::new(&settings, KINDS[0], whole_space(), 3);
                compare(&run).lights.assert_holds(&format!("{variance}, {sharpness}, {emitter}"));
            }
        }
    }
    // Negative controls: each as if it were another.
    let own = settings(Kernel::Modified, Lobes::Both);
    let id = |settings: &Settings| settings.sample().id();
    for (settings, from, to) in [
        (Settings { variance: Variance::Planar, ..own.clone() }, "variance *= 0.5;", ""),
        (
            Settings { sharpness: Sharpness::Banerjee, ..own.clone() },
            "r * (3.0 - r * r) / (rest * (1.0 + r))",
            "r / rest",
        ),
        (own.clone(), "sglow_vmf_mean_length_exact(diffuse.sharpness)", "0.9"),
    ] {
        let run = Run::new(&settings, KINDS[0], &broken(&id(&settings), from, to), 3);
        compare(&run).lights.assert_fails(to);
    }
}

#[test]
fn a_map_of_one_texel_has_one_level() {
    for (kernel, solver) in KERNELS {
        for count in [1, 16] {
            let settings = Settings { kernel, solver, count, rsm_size: 1, ..small() };
            let sampled = sample(gpu(), whole_space(), &settings, &[3.0], &[2.0]).unwrap();
            assert!(
                sampled.kernels.iter().all(|one| one.level == 0.0),
                "{kernel} {solver} {count}"
            );
            let power: f64 = sampled.powers.iter().sum();
            assert!((power / 2.0 - 1.0).abs() < 1e-4, "{kernel} {solver} {count}: {power}");
        }
    }
}

#[test]
fn a_broken_warp_is_noticed() {
    let package = broken(
        "sample-warped-modified-bracketed-exact-trace-exact-both-f32",
        "2654435769u",
        "2654435761u",
    );
    let run = Run::new(&settings(Kernel::Modified, Lobes::Both), KINDS[0], &package, 3);
    compare(&run).centres.assert_fails("another lattice");
}

#[test]
fn a_broken_kernel_is_noticed() {
    let [previous, bisection, bracketed] = KERNELS;
    let breaks = [
        (bisection, "exp2(2.0 * level)", "exp2(2.0 * level + 2.0)", "a level off by one"),
        (bisection, "* filtered < target_mass", "* filtered > target_mass", "the wrong way"),
        (bisection, "if level == below.level {", "if level >= below.level {", "another pair"),
        (bracketed, "step < 2;", "step < 0;", "the first guess alone"),
        (
            bracketed,
            "min(less_level, more_level)",
            "max(less_level, more_level)",
            "another bracket",
        ),
        (
            bracketed,
            "* filtered < target_mass",
            "* filtered < 0.25 * target_mass",
            "a wrong bracket",
        ),
        (previous, "0.5 * log2", "0.49 * log2", "another exponent"),
    ];
    for ((kernel, solver), from, to, what) in breaks {
        let package = broken(
            &format!("sample-warped-{kernel}-{solver}-exact-trace-exact-both-f32"),
            from,
            to,
        );
        let settings = Settings { solver, ..settings(kernel, Lobes::Both) };
        let run = Run::new(&settings, KINDS[0], &package, 3);
        compare(&run).levels.assert_fails(what);
    }
}

#[test]
fn a_broken_light_is_noticed() {
    let breaks = [
        (
            "texels / (f32(count) * max(filtered, 1e-30))",
            "1.0 / (f32(count) * max(filtered, 1e-30))",
            "a dropped number of texels",
        ),
        ("- dot(mean, mean)", "- 0.999 * dot(mean, mean)", "a mean that is not quite subtracted"),
        ("mean_length, 1.0 - mean_length", "mean_length, 1.001 - mean_length", "another sharpness"),
        ("min(lower_level + 1, top)", "min(lower_level + 2, top)", "a mip level off by one"),
    ];
    for (from, to, what) in breaks {
        let package =
            broken("sample-warped-modified-bracketed-exact-trace-exact-both-f32", from, to);
        let run = Run::new(&settings(Kernel::Modified, Lobes::Both), KINDS[0], &package, 3);
        compare(&run).lights.assert_fails(what);
    }
}

#[test]
fn a_broken_packing_is_noticed() {
    let breaks = [
        ("0.03125 * max(", "0.0312 * max(", "another unit of sharpness"),
        ("(1.0 - abs(point.yx))", "(1.0 - abs(point.xy))", "a lower half that is folded wrongly"),
        ("pack2x16unorm(color.rg)", "pack2x16unorm(color.gr)", "channels that are swapped"),
        ("return power * (weight / luminance)", "return power", "a luminance that is not mended"),
        (
            "vsgl.specular_coefficient *= sglow_sample_parameters.power_unit;",
            "",
            "a unit that is forgotten",
        ),
    ];
    for (from, to, what) in breaks {
        let package =
            broken("sample-warped-modified-bracketed-exact-trace-exact-both-f16", from, to);
        let run = Run::new(&halves(), KINDS[0], &package, 3);
        compare(&run).lights.assert_fails(what);
    }
}

/// The sampler's weights may have 8 fractional bits, which moves a position between texels by up to 2^-9 of a texel and
/// a level by 2^-9: the sum of powers, an average over all kernels, then stays within 1 % of the exact filter's.
#[test]
fn hardware_filtering_keeps_the_power() {
    if !gpu().filters_float32() {
        println!("skipped: this device does not filter 32-bit floats");
        return;
    }
    let power = |filter, package: &Package| {
        let settings = Settings { filter, ..settings(Kernel::Modified, Lobes::Diffuse) };
        let run = Run::new(&settings, KINDS[0], package, 3);
        let lights: Vec<Vsgl> = reference::lights(gpu(), &run.indirect).unwrap();
        lights.iter().map(|light| light.power().luminance()).sum::<f64>()
    };
    let exact = power(Filter::Exact, &Package::embedded());
    let hardware = power(Filter::Hardware, &Package::embedded());
    println!("summed power: exact {exact}, hardware {hardware}");
    assert!((hardware / exact - 1.0).abs() < 0.01);
    let package = broken(
        "sample-warped-modified-bracketed-hardware-trace-exact-diffuse-f32",
        "texels / (f32(count)",
        "1.02 * texels / (f32(count)",
    );
    let wrong = power(Filter::Hardware, &package);
    assert!((wrong / exact - 1.0).abs() > 0.01, "two percent went unnoticed");
    assert!(exact > 0.0);
}
