//! A library laid over another one: what it adds, what it changes, and what clashes.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use sglow_graph::frame::Action;
use sglow_graph::{Configuration, Frame};
use sglow_shader_gen::error::Report;
use sglow_shader_gen::library::Library;
use sglow_shader_gen::package::{self, Options};
use sglow_shader_gen::validate::Validated;
use sglow_shader_gen::{frame, generate, manifest};

use crate::{edited, edited_in, foreign_library, foreign_root};

/// The folder of what is laid over the foreign library.
fn over_root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/over")
}

/// The foreign library with, in each file named, the second text in place of the first of what is laid over it.
fn laid(edits: &[(&str, &str, &str)]) -> Result<Library, Report> {
    let folder = tempfile::tempdir().unwrap();
    // The last part of the folder's path stands in errors.
    let over = folder.path().join("over");
    edited_in(&over_root(), &over, edits);
    let library = Library::load_with(&foreign_root(), &[over])?;
    let variants = generate::variants(&library, &library.variants())?;
    let reflected = |one: &Validated| {
        let reflection = manifest::reflect(&one.text, &one.module, &one.info).unwrap();
        manifest::variant(&library, one, &reflection, Vec::new())
    };
    frame::check(&library, &variants.iter().map(reflected).collect::<Vec<_>>())?;
    Ok(library)
}

fn evaluated(library: &Library, axes: &[(&str, &str)]) -> Frame {
    let axes = axes.iter().map(|&(axis, value)| (axis.to_owned(), value.to_owned()));
    let configuration = Configuration { axes: axes.collect(), ..Configuration::default() };
    let description = &library.frame().unwrap().description;
    description.evaluate(&configuration).unwrap_or_else(|errors| panic!("{errors}"))
}

/// The labels of the steps, in their order; of a clear what it clears.
fn labels(frame: &Frame) -> Vec<String> {
    let label = |step: &sglow_graph::frame::Step| match step.action {
        Action::Clear(resource, _) => format!("clear {}", frame.resources[resource].name),
        _ => step.label.clone(),
    };
    frame.steps.iter().map(label).collect()
}

#[test]
fn what_is_laid_over_adds_passes_axes_values_parameters_resources_and_steps() {
    let library = laid(&[]).unwrap_or_else(|report| panic!("{report}"));
    let ids: Vec<_> = library.variants().iter().map(ToString::to_string).collect();
    for wanted in ["smooth", "count-green-direct", "count-red-direct", "scan-inclusive"] {
        assert!(ids.iter().any(|id| id == wanted), "{wanted}: {ids:?}");
    }
    let show = library.find_pass("show").unwrap();
    assert_eq!(show.entry_points, ["tally_bar", "tally_bar_color"], "what is not given stays");
    assert!(show.description.contains("smoothed"));
    assert_eq!(library.pass.last().unwrap().name, "smooth");
    assert_eq!(library.overlays()[0].name, "smooth");
    let smooth = evaluated(&library, &[("smooth", "box")]);
    assert_eq!(labels(&smooth), ["clear counted", "count", "sum", "smooth", "show"]);
    assert!(smooth.resource("smoothed").is_some());
    // Of the default nothing has changed.
    let (own, over) = (evaluated(&foreign_library(), &[]), evaluated(&library, &[]));
    assert_eq!((&own.resources, &own.groups), (&over.resources, &over.groups));
    assert_eq!(own.steps.len(), over.steps.len());
}

#[test]
fn the_sources_are_those_of_both_whatever_folder_holds_them() {
    let library = laid(&[]).unwrap();
    let paths: Vec<_> = library.sources().files().iter().map(|file| file.path.as_str()).collect();
    for wanted in ["library.toml", "over/library.toml", "over/frame.toml", "src/sum/scan.wesl"] {
        assert!(paths.contains(&wanted), "{paths:?}");
    }
    assert!(paths.contains(&"over/src/sum/smooth.wesl"), "{paths:?}");
    let green = library.variant("count", &[("channel", "green")]).unwrap();
    let text = generate::variants(&library, &[green]).unwrap().remove(0).text;
    assert!(text.contains("pixel.g") && !text.contains("pixel.r;"), "{text}");
}

#[test]
fn a_package_has_what_is_laid_over_and_its_hash_depends_on_it() {
    let folder = tempfile::tempdir().unwrap();
    let generated = |name: &str, over: &[PathBuf]| {
        let out = folder.path().join(name);
        let options = Options { over: over.to_vec(), ..Options::new(&out) };
        package::generate(&foreign_root(), &options, &mut |_| ()).unwrap();
        let manifest = std::fs::read_to_string(out.join("manifest.json")).unwrap();
        let manifest: serde_json::Value = serde_json::from_str(&manifest).unwrap();
        manifest
    };
    let (own, over) = (generated("own", &[]), generated("over", &[over_root()]));
    let hash = |manifest: &serde_json::Value| manifest["source_hash"].as_str().unwrap().to_owned();
    assert_ne!(hash(&own), hash(&over));
    assert!(own["graph"]["parameter"]["reach"].is_null());
    assert_eq!(over["graph"]["parameter"]["reach"]["default"], 1);
    assert!(over.to_string().contains("\"smooth\""));
    let other = tempfile::tempdir().unwrap();
    let copy = other.path().join("over");
    edited_in(&over_root(), &copy, &[("src/sum/smooth.wesl", "sum / ", "1u + sum / ")]);
    assert_ne!(hash(&over), hash(&generated("changed", std::slice::from_ref(&copy))));
    edited_in(&over_root(), &copy, &[]);
    assert_eq!(
        hash(&over),
        hash(&generated("elsewhere", &[copy])),
        "the folder's place is not a part"
    );
}

const TOML: &str = "library.toml";
const FRAME: &str = "frame.toml";
const PLACE: &str = "after = \"sum\"";

#[test]
fn a_step_stands_where_it_says() {
    let of = |place: &str, axes: &[(&str, &str)]| {
        // Before the sums there is nothing of them to be smoothed.
        let counted = (FRAME, "soft_sums = \"sums.front\"", "soft_sums = \"counted\"");
        let library = laid(&[(FRAME, PLACE, place), counted]);
        let library = library.unwrap_or_else(|report| panic!("{report}"));
        let (with, without) = (evaluated(&library, axes), evaluated(&library, &[]));
        (labels(&with), labels(&without))
    };
    let smooth = [("smooth", "box")];
    let usual = ["clear counted", "count", "sum", "show"].map(str::to_owned);
    let (with, without) = of("before = \"show\"", &smooth);
    assert_eq!((with[3].as_str(), with.len()), ("smooth", 5));
    assert_eq!(without, usual);
    // By its pass, since no step has that label: before the first of two, one of which is in a group.
    let (with, without) = of("before = \"scan\"", &smooth);
    assert_eq!((with[2].as_str(), with.len()), ("smooth", 5));
    assert_eq!(without, usual);
    // Two behind the same one keep their order.
    let second = "\n[[template.frame.step]]\nafter = \"sum\"\nlabel = \"second\"\nclear = \"smoothed\"\nwhen = \"smooth == 'box'\"\n";
    let edit = (
        FRAME,
        "\n[[template.frame.step]]\nextend",
        &*format!("{second}\n[[template.frame.step]]\nextend"),
    );
    let library = laid(&[edit]).unwrap_or_else(|report| panic!("{report}"));
    let frame = evaluated(&library, &smooth);
    assert_eq!(labels(&frame)[2..], ["sum", "smooth", "clear smoothed", "show"]);
}

#[test]
fn a_step_takes_the_place_of_others_in_its_configurations() {
    // The sums are smoothed instead of being summed a second time.
    let library = laid(&[
        (FRAME, PLACE, "replace = [\"sum\"]"),
        (FRAME, "soft_sums = \"sums.front\"", "soft_sums = \"counted\""),
    ]);
    let library = library.unwrap_or_else(|report| panic!("{report}"));
    let usual = evaluated(&library, &[]);
    assert_eq!(labels(&usual), ["clear counted", "count", "sum", "show"]);
    let smooth = evaluated(&library, &[("smooth", "box")]);
    assert_eq!(labels(&smooth), ["clear counted", "count", "smooth", "show"]);
    let steps = &library.frame().unwrap().authored.template["frame"].step;
    let whens: BTreeMap<_, _> = steps
        .iter()
        .filter_map(|step| Some((step.label.as_deref()?, step.when.as_ref()?.0.as_str())))
        .collect();
    assert_eq!(whens["sum"], "!(smooth == 'box')");
}

#[test]
fn presets_of_files_count_and_those_that_are_laid_over_them_clash_or_replace() {
    let base = edited(&[(
        "library.toml",
        "source = \"src\"",
        "source = \"src\"\npresets = \"more.toml\"",
    )]);
    let preset = |more: &str| {
        let set = "description = \"rough\"\nset = { channel = \"mean\" }\n";
        format!("[[preset]]\nname = \"quick\"\n{more}{set}")
    };
    std::fs::write(base.path().join("more.toml"), preset("")).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let over = folder.path().join("over");
    let with = |more: &str| {
        let _ = std::fs::remove_dir_all(&over);
        edited_in(&over_root(), &over, &[]);
        let path = over.join("library.toml");
        let text = std::fs::read_to_string(&path).unwrap() + "\n" + &preset(more);
        std::fs::write(&path, text.replace("\"mean\" }", "\"mean\", smooth = \"box\" }")).unwrap();
        Library::load_with(base.path(), std::slice::from_ref(&over))
    };
    let text = with("").unwrap_err().to_string();
    for part in ["over/library.toml:4", "more.toml:2:8", "`quick` of `preset`"] {
        assert!(text.contains(part), "{text}");
    }
    let library = with("replace = true\n").unwrap_or_else(|report| panic!("{report}"));
    assert_eq!(library.find_preset("quick").unwrap().set["smooth"].to_string(), "box");
    assert_eq!(library.preset.len(), 1);
}

/// What is said of the foreign library with `edits` of what is laid over it.
fn report(edits: &[(&str, &str, &str)]) -> String {
    laid(edits).map_or_else(|report| report.to_string(), |_| "nothing is wrong".to_owned())
}

macro_rules! errors {
    ($($name:ident: $($edit:expr),+;)+) => {
        $(
            #[test]
            fn $name() {
                insta::with_settings!({ omit_expression => true }, {
                    insta::assert_snapshot!(stringify!($name), report(&[$($edit),+]));
                });
            }
        )+
    };
}

#[test]
fn nothing_is_wrong_with_what_is_laid_over() {
    assert_eq!(report(&[]), "nothing is wrong");
}

errors! {
    everything_that_clashes_with_the_library:
        (TOML, "name = \"smooth\"\ndescription = \"smooths", "name = \"count\"\ndescription = \"smooths"),
        (TOML, "[axis.smooth]\n", "[axis.order]\n"),
        (TOML, "name = \"green\"", "name = \"red\""),
        (TOML, "replace = true\n", ""),
        (TOML, "select =", "name = \"smooth\"\nselect =");
    everything_that_clashes_with_the_frame:
        (FRAME, "[parameter.reach]", "[parameter.again]"),
        (FRAME, "resource.smoothed", "resource.sums"),
        (FRAME, "uniform.smooth]\nreach", "uniform.settings]\nrounds"),
        (FRAME, "extend = \"show\"\nreplace = true\n", "extend = \"show\"\n");
    a_module_that_clashes: (TOML, "replace = [\"image/channel.wesl\"]\n", "");
    modules_that_replace_nothing:
        (TOML, "replace = [\"image/channel.wesl\"]", "replace = [\"image/channel.wesl\", \"image/chanel.wesl\", \"sum/smooth.wesl\"]");
    what_is_not_there_to_be_replaced:
        (TOML, "name = \"smooth\"\ndescription = \"smooths", "replace = true\nname = \"smooth\"\ndescription = \"smooths"),
        (TOML, "[axis.smooth]\n", "[axis.smooth]\nreplace = true\n");
    steps_that_stand_nowhere:
        (FRAME, PLACE, "after = \"sums\""),
        (FRAME, "extend = \"show\"", "extend = 3");
    a_step_with_two_places: (FRAME, PLACE, "after = \"sum\"\nbefore = \"show\"");
    a_part_of_several_steps: (FRAME, "extend = \"show\"", "extend = \"sum\"");
    names_that_are_known_to_neither:
        (TOML, "source = \"sum/smooth.wesl\"", "source = \"sum/soft.wesl\""),
        (TOML, "{ pass = \"smooth\" }", "{ pass = \"soft\" }");
    what_is_laid_over_reads_what_nothing_wrote: (FRAME, PLACE, "before = \"count\"");
    what_is_laid_over_does_not_fit: (FRAME, "buffer = { length = \"bins\", stride = 4 }", "buffer = { length = \"bins\", stride = 8 }");
    an_unknown_name_in_a_condition_that_replaces:
        (FRAME, PLACE, "replace = \"sum\""),
        (FRAME, "pass = \"smooth\"\nwhen = \"smooth == 'box'\"", "pass = \"smooth\"\nwhen = \"smoth == 'box'\"");
    no_table_of_what_is_laid_over: (TOML, "[library]\nname = \"smooth\"\ndescription = \"Smoothed sums of histograms\"\nprefix = \"soft_\"\nsource = \"src\"\nframe = \"frame.toml\"\nreplace = [\"image/channel.wesl\"]\n", "");
    a_field_of_the_table_that_is_not_known: (TOML, "prefix = \"soft_\"", "prefixes = \"soft_\"");
    a_prefix_that_is_none: (TOML, "prefix = \"soft_\"", "prefix = \"soft\"");
    a_name_with_neither_prefix: ("src/sum/smooth.wesl", "struct SoftSettings", "struct Settings"), ("src/sum/smooth.wesl", ": SoftSettings", ": Settings");
}
