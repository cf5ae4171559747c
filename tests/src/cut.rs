//! A cut through a tree over a map's texels: `shaders/src/cut`.

mod run;

use sglow_oracle::Vector3;
use sglow_oracle::cut::key::UNLIT;
use sglow_oracle::vsgl::{Vsgl, packed};
use sglow_shaders::{Light, Lobes, Precision, Sharpness, SpecularPower, Variance};

use crate::common::{KINDS, broken, light, lights, whole_space};
use crate::part::cut::Cut;
use run::{Case, PARTS, Part, Run, case};

fn placed(mut case: Case, at: impl Fn(usize) -> [f32; 3]) -> Case {
    for (index, position) in case.surfaces.position.iter_mut().enumerate() {
        position[..3].copy_from_slice(&at(index));
    }
    case
}

/// Maps of all shapes, few and many lights, degenerate surfaces.
fn cases() -> Vec<Case> {
    let mut cases = vec![
        case("a square", [32, 32], 100),
        case("another shape", [50, 23], 64),
        case("one light", [20, 16], 1),
        case("two lights", [20, 16], 2),
        case("three lights", [9, 40], 3),
        case("more lights than texels", [9, 7], 300),
        case("one texel", [1, 1], 5),
        // More than one block of keys to sort, and more than one of ranks.
        case("many lights", [61, 64], 3000),
        placed(case("one place", [30, 30], 77), |_| [0.25, 0.5, -0.75]),
        placed(case("two places", [30, 30], 77), |index| {
            [if index % 3 == 0 { 0.25 } else { -1e-3 }, 0.5, -0.75]
        }),
        placed(case("a line", [30, 30], 50), |index| [index as f32 * 1e-3, 0.5, -0.75]),
    ];
    let mut plane = placed(case("a plane", [32, 32], 60), |index| {
        [(index % 32) as f32 * 0.05 - 0.8, -0.5, (index / 32) as f32 * 0.05 - 0.8]
    });
    for normal in &mut plane.surfaces.normal {
        normal[..3].copy_from_slice(&[0.0, 1.0, 0.0]);
    }
    let mut one = plane.clone();
    one.name = "one lit texel";
    for (index, position) in one.surfaces.position.iter_mut().enumerate() {
        position[3] = if index == 400 { 0.04 } else { -1.0 };
    }
    let mut strong = case("power over 1e12", [32, 32], 60);
    strong.light.uniform.intensity = [3e16, 2e16, 1e16];
    let mut weak = case("power of 1e-30", [32, 32], 60);
    weak.light.uniform.intensity = [3e-27, 2e-27, 1e-27];
    cases.extend([plane, one, strong, weak]);
    cases
}

#[test]
fn agrees_with_the_oracle() {
    for case in cases() {
        Run::new(&case, whole_space()).assert_holds();
    }
}

#[test]
fn all_lights_and_lobes_agree_with_the_oracle() {
    for (kind, of) in KINDS.into_iter().zip([Light::Spot, Light::Directional, Light::Point]) {
        for lobes in [Lobes::Diffuse, Lobes::Both] {
            let mut case = case("lights and lobes", [40, 24], 60);
            case.light = light(kind, 40);
            (case.settings.light, case.settings.lobes) = (of, lobes);
            Run::new(&case, whole_space()).assert_holds();
        }
        let mut case = case("lights by albedo", [40, 24], 60);
        case.light = light(kind, 40);
        (case.settings.light, case.settings.specular_power) = (of, SpecularPower::Albedo);
        let mut run = Run::new(&case, whole_space());
        run.assert_holds();
        // Negative control: they are other lights.
        run.case.settings.specular_power = SpecularPower::F0;
        assert!(!run.holds(Part::Blocks), "another specular power goes unnoticed");
    }
    for sharpness in Sharpness::ALL {
        for variance in Variance::ALL {
            let mut case = case("sharpness and variance", [24, 24], 40);
            (case.settings.sharpness, case.settings.variance) = (sharpness, variance);
            case.settings.diffuse_mean_length = 2.0 / 3.0;
            Run::new(&case, whole_space()).assert_holds();
        }
    }
}

/// The texels of several maps in one tree.
#[test]
fn several_lights_agree_with_the_oracle() {
    for (size, specular_power) in [
        ([40, 24], SpecularPower::F0),
        ([32, 32], SpecularPower::F0),
        ([40, 24], SpecularPower::Albedo),
    ] {
        let mut case = case("several lights", size, 60);
        case.light = lights(size[0]);
        let settings = &mut case.settings;
        (settings.light, settings.grid) = (Light::Several, case.light.grid());
        settings.specular_power = specular_power;
        let run = Run::new(&case, whole_space());
        run.assert_holds();
        assert!(run.lost_power() < 1e-4, "{}", run.lost_power());
        if specular_power == SpecularPower::F0 {
            let id = "cut_leaves-several-both-f0-exact";
            for (from, to) in [
                ("tile.y * grid.x + tile.x", "tile.y * grid.x"),
                ("light.half_extent > 0.0", "light.half_extent > 1e9"),
            ] {
                let broken = Run::new(&case, &broken(id, from, to));
                assert!(!broken.holds(Part::Blocks), "{to} goes unnoticed");
            }
        }
    }
}

/// 1e6 units from the world's origin: positions are f32, a sixteenth apart, and what is made of them is finite.
#[test]
fn far_from_the_origin_everything_is_finite() {
    let far = |offset: f32| {
        let mut case = case("far away", [32, 32], 60);
        for position in &mut case.surfaces.position {
            position[..3].iter_mut().for_each(|part| *part = 8.0 * *part + offset);
        }
        let place = |at: [f32; 3]| at.map(|part| 8.0 * part + offset);
        case.light.uniform.position = place(case.light.uniform.position);
        case.light.origin = place(case.light.origin.into()).into();
        Run::new(&case, whole_space())
    };
    let run = far(1e6);
    run.assert_holds();
    // The spread of the lights is that of the same map at the origin, to what is left of the positions.
    let near = far(0.0);
    let mean = |run: &Run| run.lights.iter().map(|light| light.variance).sum::<f64>();
    assert!((mean(&run) / mean(&near) - 1.0).abs() < 0.05, "{} {}", mean(&run), mean(&near));
}

#[test]
fn a_map_without_power_and_numbers_that_are_not_finite_are_left_out() {
    let mut dark = case("dark", [16, 16], 9);
    dark.light.uniform.intensity = [0.0; 3];
    let mut empty = case("empty", [16, 16], 9);
    for position in &mut empty.surfaces.position {
        position[3] = -1.0;
    }
    for case in [dark, empty] {
        let run = Run::new(&case, whole_space());
        assert_eq!(run.leaf_count, 0);
        run.assert_holds();
        assert!(run.lights.iter().all(|light| light.power() == Vector3::zero()));
    }
    let odd = |broken: bool| {
        let mut case = case("not finite", [16, 16], 30);
        let values = if broken { [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] } else { [0.1; 3] };
        for (index, value) in values.into_iter().enumerate() {
            case.surfaces.position[20 + index][index] = value;
            case.surfaces.normal[40 + index][index] = value;
            case.surfaces.base_color[60 + index] = [value; 4];
        }
        Run::new(&case, whole_space())
    };
    let (fine, run) = (odd(false), odd(true));
    assert!(run.leaf_count < fine.leaf_count && run.leaf_count + 9 >= fine.leaf_count);
    for light in &run.lights {
        assert!(light.power().length().is_finite() && light.position.length().is_finite());
    }
    assert_eq!(run.keys.iter().filter(|&&key| key != UNLIT).count(), run.leaf_count);
}

/// The same bits from run to run, whatever the order of execution.
#[test]
fn lights_are_the_same_from_run_to_run() {
    let case = case("again", [61, 64], 500);
    let runs = [0, 1, 2].map(|_| Run::new(&case, whole_space()));
    let bits = |run: &Run| -> Vec<u32> { run.blocks.iter().map(|part| part.to_bits()).collect() };
    for other in &runs[1..] {
        assert_eq!(bits(&runs[0]), bits(other));
        assert!(runs[0].lights == other.lights && runs[0].ranks == other.ranks);
    }
}

/// Lights in halves are those in f32 to what packing leaves.
#[test]
fn halves_are_the_packed_lights() {
    for lobes in [Lobes::Diffuse, Lobes::Both] {
        let mut case = case("halves", [40, 24], 60);
        case.settings.lobes = lobes;
        let full = Run::new(&case, whole_space());
        case.settings.precision = Precision::F16;
        let run = Run::new(&case, whole_space());
        let compare = |found: &[Vsgl]| {
            let mut wrong = 0;
            for (found, full) in found.iter().zip(&full.lights) {
                wrong +=
                    usize::from((found.position, found.variance) != (full.position, full.variance));
                let lobes = std::iter::once((found.diffuse, full.diffuse))
                    .chain(found.specular.zip(full.specular));
                for (found, full) in lobes {
                    let scale = full.coefficient.to_array().into_iter().fold(0.0, f64::max);
                    let step = (found.coefficient - full.coefficient).map(f64::abs).to_array();
                    let off = (found.sharpness - full.sharpness).abs();
                    wrong += usize::from(
                        (found.axis - full.axis).length() > packed::AXIS_ERROR
                            || step.into_iter().fold(0.0, f64::max) > scale / 65535.0
                            || off > full.sharpness / 2048.0 + 2f64.powi(-19),
                    );
                }
            }
            wrong
        };
        assert_eq!(compare(&run.lights), 0);
        // Negative control: the lights in another order.
        let mut turned = run.lights.clone();
        turned.rotate_left(1);
        assert!(compare(&turned) > 30);
    }
}

#[test]
fn what_is_broken_is_noticed() {
    let moments = "cut_leaves-spot-both-f0-exact";
    let breaks = [
        (
            "cut_lit-spot-both-f0",
            "sglow_box_part(moments.mean, part)",
            "sglow_box_part(0.9 * moments.mean, part)",
            Part::Box,
        ),
        (
            "cut_lit-spot-both-f0",
            "texel_moments.weight > 1e-37",
            "texel_moments.weight > 1e-3",
            Part::Keys,
        ),
        ("cut_keys", "<< 29u", "<< 28u", Part::Keys),
        ("cut_keys", "512.0 * grid.first", "511.0 * grid.first", Part::Keys),
        ("cut_keys", "sglow_exponent(widest) - 2", "sglow_exponent(widest) + 1", Part::Keys),
        (moments, "area * 0.16666667", "area * 0.083333333", Part::Blocks),
        (moments, "id.x + 1u;", "id.x;", Part::Keys),
        ("cut_sums-both", "share * right.variance", "left_share * right.variance", Part::Blocks),
        ("cut_sums-both", "+ left_share * share * dot(apart, apart)", "", Part::Blocks),
        ("cut_sums-both", "2u * block + 1u", "2u * block", Part::Blocks),
        ("cut_sums-both", "low | max(left", "low | min(left", Part::Blocks),
        (moments, "32768.0 * grid.first", "32767.0 * grid.first", Part::Blocks),
        ("cut_tree-both", "before > after", "before < after", Part::Tree),
        (
            "cut_tree-both",
            "step /= 2; step > 0; step /= 2",
            "step /= 4; step > 0; step /= 2",
            Part::Tree,
        ),
        ("cut_tree-both", "node.variance / whole.variance", "node.variance", Part::Costs),
        (
            "cut_tree-both",
            "(1.0 - coherence) * (1.0 + coherence)",
            "(1.0 - coherence)",
            Part::Costs,
        ),
        ("cut_tree-both", "high -= 1u;", "", Part::Costs),
        ("cut_ranks", "63u - min(prefix, 63u)", "min(prefix, 63u)", Part::Ranks),
        ("cut_ranks", "(least << 1u)", "(least << 2u)", Part::Ranks),
        ("cut_lights-trace-exact-both-f32", "node <= last_node", "node < last_node", Part::Lights),
        ("cut_lights-trace-exact-both-f32", "id.x - 1u", "id.x", Part::Lights),
        (
            "cut_lights-trace-exact-both-f32",
            "sum.weight * sum.variance",
            "sum.variance",
            Part::Lights,
        ),
        (
            "cut_lights-trace-exact-both-f32",
            "above = parent != node;",
            "above = false;",
            Part::Lights,
        ),
    ];
    let fine = Run::new(&case("broken", [50, 23], 64), whole_space());
    for (id, from, to, part) in breaks {
        assert!(fine.holds(part), "{part:?} fails by itself");
        let run = Run::new(&fine.case, &broken(id, from, to));
        assert!(!run.holds(part), "{id}: {from} as {to} goes unnoticed in {part:?}");
        let others: Vec<Part> = PARTS.into_iter().filter(|&other| !run.holds(other)).collect();
        println!("{id}: {from} as {to}: {others:?}");
    }
}

#[test]
fn settings_that_cannot_be_are_named() {
    let error = |count: u32| {
        let mut settings = case("settings", [8, 8], 4).settings;
        settings.count = count;
        Cut::new(whole_space(), &settings).err().map(|error| error.to_string())
    };
    assert_eq!(error(4), None);
    assert!(error(0).unwrap().contains("`lights` is 0"));
    assert!(error(65537).unwrap().contains("65537"));
}
