//! Extreme cases of the whole pipeline, and that their bounds notice what they are for: `measure/src/extreme.rs`. All of
//! them run in `cargo xtask stability`.

use sglow_measure::extreme::{LITERAL, attempt, names, without_origin};
use sglow_results::stability::report::{ExtremeReport, ExtremeVariant};
use sglow_runtime::package::Package;

use crate::common::{broken, gpu, whole_space};

fn report(name: &str, package: &Package) -> ExtremeReport {
    attempt(gpu(), package, name).unwrap().unwrap()
}

fn variant<'a>(report: &'a ExtremeReport, name: &str) -> &'a ExtremeVariant {
    report.variants.iter().find(|one| one.variant == name).unwrap()
}

#[test]
fn light_of_any_power_is_reflected_alike() {
    for name in ["dark", "bright", "no light arrives", "hot-texel"] {
        let report = report(name, whole_space());
        let failing: Vec<_> = report.variants.iter().filter(|variant| !variant.holds).collect();
        assert!(report.variants.len() >= 3 && failing.is_empty(), "{name}: {failing:?}");
    }
    assert!(attempt(gpu(), whole_space(), "no such case").unwrap().is_none());
    assert!(names().len() > 15);
}

#[test]
fn bounds_of_extremes_notice_what_they_are_for() {
    // The default's variants, each broken in one way.
    let sample = "sample-warped-modified-bracketed-exact-trace-exact-both-f32";
    let shade = "shade-cosine-fitted-asg-ggx-both-f32-none";
    let breaks = [
        // The length of what grows with the light's power, as it was: its square overflows.
        (
            "bright",
            sample,
            "mean = direction / weight;",
            "mean = direction / weight * (length(direction) / length(direction));",
        ),
        ("dark", sample, "SGLOW_LEAST_WEIGHT: f32 = 1e-37", "SGLOW_LEAST_WEIGHT: f32 = 1e-10"),
        ("no light arrives", shade, "diffuse *= surface.diffuse;", "diffuse += vec3<f32>(1e-3);"),
        (
            "mirrors",
            shade,
            "diffuse *= surface.diffuse;",
            "diffuse *= exp(100.0 + abs(surface.position.x));",
        ),
        ("one light", shade, "diffuse *= surface.diffuse;", "diffuse *= -1.0;"),
        ("far away", sample, "vsgl.position = origin + mean;", "vsgl.position = mean;"),
        (
            "ring",
            "sample-warped-modified-bracketed-exact-trace-exact-diffuse-f32",
            "texels / (f32(count) * max(filtered, 1e-30))",
            "1.1 * texels / (f32(count) * max(filtered, 1e-30))",
        ),
    ];
    for (name, id, from, to) in breaks {
        let report = report(name, &broken(id, from, to));
        assert!(!variant(&report, "default").holds, "{name}: {from} as {to} goes unnoticed");
    }
}

#[test]
fn moments_about_the_worlds_origin_lose_the_variance() {
    let report = report("far away", whole_space());
    let [stable, literal] = ["default", LITERAL].map(|name| variant(&report, name));
    let deviation = |variant: &ExtremeVariant| variant.deviation.unwrap().abs();
    println!("stable {:e}, literal {:e}", deviation(stable), deviation(literal));
    assert!(stable.holds && deviation(literal) > report.bound.unwrap(), "{literal:?}");
}

#[test]
fn scenes_far_from_the_origin_look_as_at_the_origin() {
    for name in ["spot light, 1e5 away", "directional light, 1e3 away", "point light, 1e6 away"] {
        let report = report(name, whole_space());
        let failing: Vec<_> = report.variants.iter().filter(|variant| !variant.holds).collect();
        assert!(report.variants.len() >= 7 && failing.is_empty(), "{name}: {failing:?}");
    }
    // Negative control.
    let off = without_origin(gpu(), whole_space()).unwrap();
    println!("without an origin: {off:e}");
    let bound = sglow_measure::bound::extreme("far with an origin").at_most.unwrap();
    assert!(off.abs() > 10.0 * bound, "{off}");
}

#[test]
fn bounds_of_halves_notice_what_they_are_for() {
    let report =
        |package: &Package| sglow_measure::halves::in_scene(gpu(), package, "cornell").unwrap();
    let failing = |package: &Package| -> Vec<&str> {
        report(package)
            .checks
            .iter()
            .filter(|check| !check.holds())
            .map(|check| check.name)
            .collect()
    };
    assert_eq!(failing(whole_space()), [""; 0]);
    // Powers in a unit that the brightest photon does not fit; a light that is stored too bright by a hundredth.
    let overflowing = broken(
        "moments-spot-both-f0-exact-f16",
        "sglow_moments_parameters.power_scale",
        "(1e6 * sglow_moments_parameters.power_scale)",
    );
    assert!(!failing(&overflowing).is_empty());
    let bright = broken(
        "sample-warped-modified-bracketed-exact-trace-exact-both-f16",
        "texels / (f32(count) * max(filtered, 1e-30))",
        "1.01 * texels / (f32(count) * max(filtered, 1e-30))",
    );
    let noticed = failing(&bright);
    assert!(noticed.len() >= 2, "{noticed:?}");
}
