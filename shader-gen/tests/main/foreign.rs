//! The foreign library as it should be.

use std::collections::BTreeSet;
use std::fs;

use sglow_shader_gen::emit::wgsl;
use sglow_shader_gen::functions::functions;
use sglow_shader_gen::generate;
use sglow_shader_gen::library::Library;
use sglow_shader_gen::matrix::{Facts, Variant};
use sglow_shader_gen::prune::Whole;
use sglow_shader_gen::validate::Validated;

use crate::{edited, foreign_library, foreign_root};

fn generate_all() -> Vec<Validated> {
    let library = foreign_library();
    generate::variants(&library, &library.variants()).unwrap_or_else(|report| panic!("{report}"))
}

fn generate_one(pass: &str, values: &[(&str, &str)]) -> Validated {
    let library = foreign_library();
    let variant = library.variant(pass, values).unwrap_or_else(|report| panic!("{report}"));
    generate::variants(&library, &[variant]).unwrap_or_else(|report| panic!("{report}")).remove(0)
}

fn ids(variants: &[Variant]) -> Vec<String> {
    variants.iter().map(Variant::id).collect()
}

#[test]
fn the_space_lacks_what_is_excluded() {
    let library = foreign_library();
    assert_eq!(
        ids(&library.variants()),
        [
            "count-red-direct",
            "count-mean-direct",
            "count-mean-workgroup",
            "count-largest-direct",
            "count-largest-workgroup",
            "scan-inclusive",
            "scan-exclusive",
            "show",
        ]
    );
    let excluded = library.excluded();
    assert_eq!(excluded.len(), 1);
    assert_eq!(excluded[0].variant.id(), "count-red-workgroup");
    assert_eq!(excluded[0].exclusion, "red-needs-no-workgroup");
}

#[test]
fn a_selection_takes_every_value_of_what_it_does_not_name() {
    assert_eq!(
        ids(&foreign_library().selected()),
        [
            "count-mean-direct",
            "count-mean-workgroup",
            "count-largest-direct",
            "count-largest-workgroup",
            "scan-inclusive",
        ]
    );
}

/// An axis that is added to a pass changes neither the names nor the texts that there were.
#[test]
fn an_implied_axis_is_named_where_it_is_not_the_default() {
    let implied = "default = \"workgroup\"\nimplied = true";
    let folder = edited(&[("library.toml", "default = \"workgroup\"", implied)]);
    let library = Library::load(folder.path()).unwrap_or_else(|report| panic!("{report}"));
    let variants = library.variants();
    assert_eq!(
        ids(&variants)[..5],
        [
            "count-red-direct",
            "count-mean-direct",
            "count-mean",
            "count-largest-direct",
            "count-largest"
        ]
    );
    let texts = generate::variants(&library, &variants).unwrap_or_else(|report| panic!("{report}"));
    let of = |id: &str| texts.iter().find(|one| one.variant.id() == id).unwrap();
    let file = |id: &str| wgsl::variant(&library, &of(id).variant, "");
    assert!(file("count-mean-direct").contains("// counter = direct"));
    let default = file("count-mean");
    assert!(default.contains("// channel = mean") && !default.contains("// counter"), "{default}");
    assert_eq!(of("count-mean").text, generate_one("count", &[]).text);
    // A frame runs it by this name.
    let description = &library.frame().unwrap().description;
    let run = |counter: &str| {
        let axes = [("counter".to_owned(), counter.to_owned())].into();
        let configuration = sglow_graph::Configuration { axes, ..Default::default() };
        let frame = description.evaluate(&configuration).unwrap();
        frame.variants().into_iter().map(|variant| variant.id.clone()).collect::<BTreeSet<_>>()
    };
    assert!(run("workgroup").contains("count-mean") && run("direct").contains("count-mean-direct"));
    assert!(run("workgroup").iter().all(|id| ids(&variants).contains(id)));
}

#[test]
fn an_axis_that_is_not_given_has_its_default() {
    let library = foreign_library();
    let variant = library.variant("count", &[("channel", "largest")]);
    assert_eq!(variant.unwrap().id(), "count-largest-workgroup");
}

#[test]
fn what_is_no_variant_is_named() {
    let library = foreign_library();
    let text =
        |pass, values: &[(&str, &str)]| library.variant(pass, values).unwrap_err().to_string();
    insta::assert_snapshot!(
        "no_variant",
        [
            text("sort", &[]),
            text("count", &[("colour", "red"), ("channel", "green")]),
            text("count", &[("channel", "red"), ("counter", "workgroup")]),
            text("scan", &[("order", "inclusive"), ("order", "exclusive")]),
        ]
        .concat()
    );
}

#[test]
fn facts_narrow_axes_and_say_why() {
    let library = foreign_library();
    let facts = Facts::from([("coloured".to_owned(), false), ("small".to_owned(), true)]);
    let needed = library.needed(&facts).unwrap();
    assert_eq!(needed["channel"].values, ["red"]);
    assert_eq!(needed["counter"].values, ["direct"]);
    assert_eq!(needed["order"].values, ["inclusive", "exclusive"]);
    let because = |axis: &str| -> Vec<&str> {
        needed[axis].because.iter().map(|because| because.need.as_str()).collect()
    };
    assert_eq!(because("channel"), ["one-channel"]);
    // The second rule takes nothing away that the first one has left.
    assert_eq!(because("counter"), ["one-channel"]);
    assert!(because("order").is_empty());

    assert_eq!(library.needed(&Facts::new()).unwrap()["channel"].values.len(), 3);
    let unknown = library.needed(&Facts::from([("bright".to_owned(), true)])).unwrap_err();
    assert!(unknown.to_string().contains("known: coloured, small"), "{unknown}");
}

#[test]
fn what_is_of_no_use_is_left_out_and_says_why() {
    let library = foreign_library();
    let left = |facts: &[(&str, bool)], keep: &[(&str, &str)]| {
        let facts = facts.iter().map(|&(fact, holds)| (fact.to_owned(), holds)).collect();
        let mut allowed = library.needed(&facts).unwrap();
        for &(axis, value) in keep {
            allowed.get_mut(axis).unwrap().values.retain(|known| known == value);
        }
        let (variants, absent) = library.remaining(&allowed);
        (ids(&variants), absent)
    };
    // Nothing is known: everything is of use.
    assert_eq!(left(&[], &[]), (ids(&library.variants()), Vec::new()));
    // One alternative is enough, and all parts of it are needed.
    for (counter, present) in [("workgroup", true), ("direct", false)] {
        let (variants, absent) = left(&[], &[("channel", "mean"), ("counter", counter)]);
        assert_eq!(variants.contains(&"scan-exclusive".to_owned()), present, "{counter}");
        assert_eq!(absent.is_empty(), present);
        // The rule holds for one value alone.
        assert!(variants.contains(&"scan-inclusive".to_owned()));
    }
    let (variants, absent) = left(&[("coloured", false)], &[]);
    assert_eq!(variants, ["count-red-direct", "scan-inclusive", "show"]);
    assert_eq!(absent.len(), 1);
    assert_eq!(absent[0].variant.id(), "scan-exclusive");
    assert_eq!(absent[0].presence, "nothing-to-run");
    assert!(absent[0].reason.contains("red channel"));
    // What the rules would allow without one of them.
    let facts = Facts::from([("coloured".to_owned(), false), ("small".to_owned(), true)]);
    let without = library.needed_without(&facts, "one-channel").unwrap();
    assert_eq!(without["channel"].values.len(), 3);
    assert_eq!(without["counter"].because[0].need, "few-pixels");
}

#[test]
fn every_variant_is_generated_as_it_was_before() {
    for validated in generate_all() {
        insta::assert_snapshot!(validated.variant.id(), validated.text);
    }
}

/// As many of `variants` as have each two values of two axes of a pass in one of them.
fn pairs(mut variants: Vec<Variant>) -> Vec<Variant> {
    let mut known = BTreeSet::new();
    variants.retain(|variant| {
        let values = variant.values.iter().enumerate();
        let pairs = values.flat_map(|(at, one)| {
            variant.values[at..]
                .iter()
                .map(|other| (variant.pass.clone(), one.clone(), other.clone()))
        });
        let new: Vec<_> = pairs.filter(|pair| !known.contains(pair)).collect();
        let any = !new.is_empty() || variant.values.is_empty();
        known.extend(new);
        any
    });
    variants
}

/// Of the project's own library each pair of values: `cargo xtask verify --all` proves all of it.
#[test]
fn variants_are_their_whole_modules_without_what_is_not_needed() {
    for root in [foreign_root(), foreign_root().join("../../../shaders")] {
        let library = Library::load(&root).unwrap_or_else(|report| panic!("{report}"));
        let variants = pairs(library.variants());
        assert!(variants.len() >= library.pass.len(), "{}", variants.len());
        println!("{} of {} variants", variants.len(), library.variants().len());
        generate::variants_against(&library, &variants, Whole::Modules)
            .unwrap_or_else(|report| panic!("{report}"));
    }
}

#[test]
fn every_line_of_a_text_is_a_line_of_the_sources() {
    let sources = foreign_library().sources().clone();
    let lines = || sources.files().iter().flat_map(|file| file.text.lines()).map(str::trim_start);
    // A condition's own bytes go; where one stands before its line's content, the rest of the line is left. What stood in
    // a block of a condition loses its indentation.
    let ends = lines().filter_map(|line| line.strip_prefix("@if(")?.split_once(") "));
    let known: BTreeSet<&str> = lines().chain(ends.map(|(_, rest)| rest.trim_start())).collect();
    for validated in generate_all() {
        for line in validated.text.lines() {
            assert!(known.contains(line.trim_start()), "{}: {line}", validated.variant);
        }
        assert!(!validated.text.contains("@if"), "{}", validated.text);
        assert!(!validated.text.contains("@else"), "{}", validated.text);
    }
}

#[test]
fn comments_go_and_stay_with_what_they_are_about() {
    let inclusive = generate_one("scan", &[("order", "inclusive")]).text;
    assert!(inclusive.contains("// An inclusive sum holds its own element.\n    tally_sums"));
    assert!(!inclusive.contains("An exclusive one does not"));
    assert!(inclusive.contains("/// [Blelloch 1990, Section 1.1]"));
    assert!(!inclusive.contains("An entry point that no pass offers."));

    let direct = generate_one("count", &[("counter", "direct")]).text;
    assert!(!direct.contains("// of the loop below"));
    assert!(!direct.contains("What follows is for the workgroup alone"));
    let workgroup = generate_one("count", &[("counter", "workgroup")]).text;
    assert!(workgroup.contains("    rounds: u32, // of the loop below\n}"), "{workgroup}");
}

#[test]
fn what_is_left_out_is_told_with_its_reason() {
    let validated = generate_one("count", &[("channel", "mean"), ("counter", "direct")]);
    let omitted: Vec<_> = validated
        .omitted
        .iter()
        .map(|omitted| format!("{} {}: {}", omitted.kind, omitted.name, omitted.reason))
        .collect();
    insta::assert_snapshot!("omitted", omitted.join("\n"));
}

#[test]
fn function_libraries_hold_functions_alone() {
    let functions = functions(&foreign_library()).unwrap_or_else(|report| panic!("{report}"));
    let functions = functions.unwrap();
    let source = fs::read_to_string(foreign_root().join("src/image/bin.wesl")).unwrap();
    assert_eq!(functions.whole, source);
    let modules: Vec<_> = functions.modules.iter().map(|of| (&*of.name, &*of.text)).collect();
    assert_eq!(modules, [("bins", &*source)]);
}

#[test]
fn generation_repeats_itself() {
    let texts = || -> Vec<String> { generate_all().into_iter().map(|one| one.text).collect() };
    assert_eq!(texts(), texts());
}

#[test]
fn a_cycle_of_imports_is_no_error() {
    let folder = edited(&[(
        "src/image/bin.wesl",
        "// How values fall into bins.\n",
        "import package::image::count::{TallyPixel};\n",
    )]);
    let library = Library::load(folder.path()).unwrap_or_else(|report| panic!("{report}"));
    generate::variants(&library, &library.variants()).unwrap_or_else(|report| panic!("{report}"));
}

#[test]
fn directives_come_first_and_need_their_feature() {
    let text = |requires: &str| {
        let flags = format!("flags = [\"inclusive\"]{requires}");
        let folder = edited(&[
            ("library.toml", "flags = [\"inclusive\"]", &flags),
            ("src/sum/scan.wesl", "\n\n", "\n@if(inclusive) enable f16;\n\n"),
            ("src/sum/scan.wesl", "= 0u;", "= u32(f16(0.0));"),
        ]);
        let library = Library::load(folder.path()).unwrap_or_else(|report| panic!("{report}"));
        let variant = library.variant("scan", &[("order", "inclusive")]).unwrap();
        generate::variants(&library, &[variant]).map(|mut one| one.remove(0).text)
    };
    let feature = "\nrequires = [\"shader-f16\"]";
    assert!(text(feature).unwrap().starts_with("enable f16;\n\n"));
    let refused = text("").unwrap_err().to_string();
    insta::assert_snapshot!("a_feature_that_is_not_required", refused);
}
