//! Frames as they are, bit for bit: a change of how frames run, and not of what they show, changes none of them.
//!
//! The snapshot `frames` has a line for each output of each frame of each configuration in `list`; `coverage` counts what
//! of `shaders/library.toml` they run. Bits depend on driver and processor, so that on another machine the readable
//! numbers beside them are compared instead, within [`record::TOLERANCE`]. To make the snapshot anew, on purpose:
//! `INSTA_UPDATE=always cargo test -p sglow-tests frames`; on another machine delete the file first.
//!
//! What it costs to encode a frame: `cargo run --release -p sglow-tests --example encode`.

mod coverage;
mod list;
mod poison;
mod record;
mod run;
mod scenes;

use std::collections::BTreeSet;
use std::io::Write;

use sglow_runtime::package::Package;
use sglow_shader_gen::library::AxisValue;

use crate::common::{gpu, library, package_of};
use coverage::{covered_by_each, missing, required};
use list::{Case, list};
use record::{Machine, Recording};

/// The variants that the configurations run, and no more.
fn package(cases: &[Case]) -> Package {
    package_of(&cases.iter().flat_map(Case::variants).collect())
}

fn record(cases: &[Case], package: &Package) -> Recording {
    let entries = cases.iter().flat_map(|case| case.run(package));
    Recording::new(Machine::of(&gpu().adapter), entries)
}

/// The committed snapshot, if there is one.
fn stored() -> Option<Recording> {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/src/snapshots/frames.snap");
    let text = std::fs::read_to_string(path).ok()?;
    Some(Recording::read(&text).expect("frames.snap to have this form: else delete it"))
}

#[test]
fn frames_are_as_they_were() {
    let cases = list();
    let found = record(&cases, &package(&cases));
    let differences = stored().map(|stored| stored.differences(&found));
    if let Some(differences) = &differences {
        // Beside what the snapshot shows: how far off what differs is, and where bits cannot be compared, that.
        println!("{}", differences.summary());
        for fault in differences.faults() {
            println!("  {fault}");
        }
    }
    found.assert_says_something();
    if let Some(differences) = differences.filter(|differences| !differences.same_machine) {
        // Past the harness, which would keep it to itself where the test passes.
        writeln!(std::io::stderr(), "frames: {}", differences.summary()).unwrap();
        let faults = differences.faults();
        assert!(faults.is_empty(), "{}", faults.join("\n"));
        return;
    }
    let mut settings = insta::Settings::clone_current();
    settings.set_omit_expression(true);
    settings.set_prepend_module_to_snapshot(false);
    settings.bind(|| insta::assert_snapshot!("frames", found.to_string()));
}

#[test]
fn every_value_and_every_rule_is_run() {
    let (library, cases) = (library(), list());
    let names: BTreeSet<&str> = cases.iter().map(|case| case.name.as_str()).collect();
    assert_eq!(names.len(), cases.len(), "two configurations have one name");
    let of_each = covered_by_each(&library, &cases);
    let all = required(&library);
    let none = missing(&all, &of_each);
    assert!(none.is_empty(), "no configuration runs: {none:#?}");
    println!("{} configurations run {} things", cases.len(), all.len());

    // Negative controls. Without one configuration that alone runs something, that is missing.
    for (name, unique) in [
        ("space=world sharpness=banerjee", "pass cluster_sum, sharpness banerjee"),
        ("start=uniform", "pass metropolis_start, start uniform"),
        ("tokuyoshi2016", "preset tokuyoshi2016"),
    ] {
        let mut fewer = of_each.clone();
        fewer.remove(cases.iter().position(|case| case.name == name).unwrap());
        let missing = missing(&all, &fewer);
        assert!(missing.contains(unique), "{unique} is not missing: {missing:?}");
    }
    // A value, a pass and a rule that nobody thought of are missing.
    let mut more = library.clone();
    let emitter = more.axis.get_mut("emitter").unwrap();
    emitter.value.push(AxisValue { name: "other".to_owned(), ..emitter.value[0].clone() });
    assert!(missing(&required(&more), &of_each).contains("pass shade, emitter other"));
    let mut more = library.clone();
    let pass = more.find_pass("shade").unwrap().clone();
    more.pass.push(sglow_shader_gen::library::Pass { name: "other".to_owned(), ..pass });
    assert!(missing(&required(&more), &of_each).contains("pass other"));
    let mut more = library.clone();
    let rule = more.presence[0].clone();
    more.presence.push(sglow_shader_gen::library::Presence { name: "other".to_owned(), ..rule });
    assert!(missing(&required(&more), &of_each).contains("presence other leaves something out"));
}

/// A few small configurations, twice; then with a shader that was changed a little, and much.
#[test]
fn other_bits_are_noticed_and_other_machines_are_not_taken_for_them() {
    let few = ["base", "draw=metropolis lights=7", "space=world lights=7"];
    let mut cases = list();
    cases.retain(|case| few.contains(&case.name.as_str()));
    assert_eq!(cases.len(), few.len());
    let package = package(&cases);
    let [one, two] = [record(&cases, &package), record(&cases, &package)];
    assert_eq!(one, two, "frames differ from run to run");
    let differences = one.differences(&two);
    assert!(differences.faults().is_empty() && differences.same_machine);
    assert_eq!(Recording::read(&one.to_string()).as_ref(), Some(&one), "the text loses something");

    let id = "shade-cosine-fitted-asg-ggx-both-f32-none";
    let broken = |from: &str, to: &str| {
        let text = package.text(id).unwrap();
        assert!(text.contains(from), "{id} has no '{from}' to break");
        let text = text.replace(from, to);
        record(&cases, &package.clone().with_text(id, text))
    };
    let elsewhere = |recording: &Recording| {
        recording
            .clone()
            .on(Machine { adapter: "another".to_owned(), ..recording.machine().clone() })
    };
    let reflected = "diffuse *= surface.diffuse;";
    // Some units in the last place: other bits here, nothing elsewhere.
    let little = broken(reflected, "diffuse *= 1.000001 * surface.diffuse;");
    let differences = one.differences(&little);
    println!("{}", differences.summary());
    assert!(!differences.faults().is_empty());
    let differences = one.differences(&elsewhere(&little));
    println!("{}", differences.summary());
    assert!(differences.faults().is_empty() && !differences.other_bits.is_empty());
    assert!(differences.summary().contains("BITS CANNOT BE COMPARED"));
    // A twentieth: noticed everywhere.
    let much = broken(reflected, "diffuse *= 1.05 * surface.diffuse;");
    assert!(!one.differences(&much).faults().is_empty());
    assert!(!one.differences(&elsewhere(&much)).faults().is_empty());
    // A configuration that is left out, and nothing at all.
    let fewer = record(&cases[1..], &package);
    assert!(!one.differences(&elsewhere(&fewer)).faults().is_empty());
    assert!(!record(&[], &package).differences(&record(&[], &package)).faults().is_empty());
}

/// Entry points write their workgroup memory before they read it, for SPIR-V does not zero it: whatever it has at first,
/// frames are the same, in each pass that has any.
#[test]
fn workgroup_memory_is_written_before_it_is_read() {
    // The last one unpacks its lights for a workgroup.
    let few = [
        "cut=tile precision=f32 lobes=both",
        "visibility=imperfect tile=64",
        "precision=f16 specular_power=albedo",
    ];
    let mut cases = list();
    cases.retain(|case| few.contains(&case.name.as_str()));
    assert_eq!(cases.len(), few.len());
    for case in &mut cases {
        (case.frames, case.settings.fill_levels) = (1, 4);
    }
    let package = package(&cases);
    let (poisoned, passes) = poison::poisoned(&package);
    let texts = crate::common::whole_space();
    let mut all: Vec<&str> = texts
        .variants()
        .filter(|id| texts.text(id).unwrap().contains("var<workgroup>"))
        .filter_map(|id| id.split('-').next())
        .collect();
    all.sort_unstable();
    all.dedup();
    assert_eq!(passes, all, "a pass with workgroup memory is not run");
    assert_eq!(record(&cases, &package), record(&cases, &poisoned));
    // Negative controls: what nobody writes, and what too few invocations write, shows.
    for (pass, from, to) in [
        ("shade", "sglow_tile_sums[64u * vote + lane] = sglow_tile", "let none = sglow_tile"),
        ("shade", "sglow_unpacked[lane] = ", "let none = "),
        ("sort_scatter", "word < 8u", "word < 7u"),
        ("light_fill", "sglow_coarse[start + at] = dot(", "let none = dot("),
    ] {
        let mut broken = poisoned.clone();
        for id in package.variants().filter(|id| id.split('-').next() == Some(pass)) {
            let text = poisoned.text(id).unwrap();
            broken = broken.with_text(id, text.replacen(from, to, 1));
        }
        assert_ne!(record(&cases, &package), record(&cases, &broken), "{pass}: {from}");
    }
}

/// What another machine may make of it, with the configurations of which most depends on a last bit.
#[test]
fn rounding_otherwise_stays_within_the_tolerance() {
    let sensitive = [
        "clusters of a scene without occluders",
        "light=point clusters",
        "scene=atrium visibility=shadow_map",
        "space=world density=reflectance draw=metropolis",
        "space=world lobes=diffuse",
        "visibility=shadow_map precision=f32 lobes=diffuse",
    ];
    let mut cases = list();
    cases.retain(|case| sensitive.contains(&case.name.as_str()));
    assert_eq!(cases.len(), sensitive.len());
    let package = package(&cases);
    let expected = record(&cases, &package);
    cases.iter_mut().for_each(|case| case.nudged = true);
    let machine = Machine { adapter: "another".to_owned(), ..expected.machine().clone() };
    let differences = expected.differences(&record(&cases, &package).on(machine));
    println!("{}", differences.summary());
    assert!(differences.faults().is_empty(), "{:#?}", differences.faults());
    // Light and maps have moved, or nothing was tried.
    assert!(10 * differences.other_bits.len() > 9 * differences.compared);
}
