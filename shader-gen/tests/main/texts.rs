//! Texts as a person would have written them.

use std::collections::BTreeSet;
use std::path::Path;

use sglow_shader_gen::emit::wgsl;
use sglow_shader_gen::generate;
use sglow_shader_gen::library::Library;
use sglow_shader_gen::matrix::Variant;
use sglow_shader_gen::name;
use sglow_shader_gen::parse::{Kind, parse};
use sglow_shader_gen::token::{TokenKind, tokenize};

use crate::foreign_library;
use crate::second_opinion::with_every_pair;

/// How our names begin.
const OURS: [&str; 3] = ["sglow_", "Sglow", "SGLOW_"];

/// What no person would have written in the text of a variant, each in a few words.
fn faults(text: &str, prefixes: &[&str]) -> Vec<String> {
    let mut faults = lines(text);
    faults.extend(order(text));
    faults.extend(numbers(text));
    faults.extend(names(text, prefixes));
    faults
}

/// Names with one of `prefixes` that comments speak of and the text does not have.
fn names(text: &str, prefixes: &[&str]) -> Vec<String> {
    let mut errors = Vec::new();
    let is_part = |c: char| c.is_ascii_alphanumeric() || c == '_';
    let (comments, code): (Vec<_>, Vec<_>) = tokenize(0, text, &mut errors)
        .into_iter()
        .partition(|token| token.kind == TokenKind::Comment);
    let known: BTreeSet<_> = code.iter().map(|token| &text[token.range()]).collect();
    let words = comments.iter().flat_map(|token| text[token.range()].split(|c| !is_part(c)));
    words
        .filter(|word| prefixes.iter().any(|prefix| word.starts_with(prefix)))
        .filter(|word| !known.contains(word))
        .map(|word| format!("a comment speaks of `{word}`, which is not there"))
        .collect()
}

fn lines(text: &str) -> Vec<String> {
    let lines: Vec<_> = text.lines().collect();
    let mut faults = Vec::new();
    for (number, line) in lines.iter().enumerate() {
        let before = number.checked_sub(1).map_or("", |before| lines[before]);
        let fault = match line.trim() {
            "{" => "a brace by itself",
            "" if before.trim().is_empty() => "a blank line behind another one",
            "" if before.ends_with('{') => "a blank line behind a brace",
            "}" if before.trim().is_empty() => "a blank line before a brace",
            _ if line.ends_with([' ', '\t']) => "space at the end of a line",
            comment if comment.starts_with("//") && line.chars().count() > 120 => "a long comment",
            _ => continue,
        };
        faults.push(format!("line {}: {fault}", number + 1));
    }
    faults
}

/// Bindings stand together in the order of their numbers, entry points behind them, functions behind those.
fn order(text: &str) -> Vec<String> {
    let mut errors = Vec::new();
    let module = parse(0, "", text, &mut errors);
    assert_eq!(errors, []);
    let declarations = &module.declarations;
    let mut faults = Vec::new();
    let bound: Vec<_> = declarations.iter().filter_map(|of| of.binding).collect();
    if !bound.is_sorted() {
        faults.push("bindings out of order".to_owned());
    }
    let first = declarations.iter().position(|of| of.binding.is_some()).unwrap_or(0);
    if declarations.iter().skip(first).take(bound.len()).any(|of| of.binding.is_none()) {
        faults.push("bindings apart from each other".to_owned());
    }
    let last_of = |kind: Kind| declarations.iter().rposition(|of| of.kind == kind);
    let first_function = declarations.iter().position(|of| of.kind == Kind::Function);
    for kind in [Kind::EntryPoint, Kind::Variable, Kind::Override] {
        if first_function < last_of(kind) && first_function.is_some() {
            faults.push(format!("{} behind a function", kind.name()));
        }
    }
    faults
}

/// Numbers that have a name, and masks that are not hexadecimal.
fn numbers(text: &str) -> Vec<String> {
    use core::f64::consts::{FRAC_1_PI, FRAC_PI_2, PI, TAU};
    let mut errors = Vec::new();
    let tokens: Vec<_> = tokenize(0, text, &mut errors)
        .into_iter()
        .filter(|token| token.kind != TokenKind::Comment)
        .collect();
    assert_eq!(errors, []);
    let mut faults = Vec::new();
    for (index, token) in tokens.iter().enumerate().filter(|(_, of)| of.kind == TokenKind::Number) {
        let number = &text[token.range()];
        let line = text[..token.start].rfind('\n').map_or(0, |newline| newline + 1);
        let is_named = text[line..].starts_with("const ");
        let value: Option<f64> = number.parse().ok();
        let has_name = |value: f64| {
            [PI, TAU, 2.0 * TAU, FRAC_PI_2, FRAC_1_PI, 0.5 * FRAC_1_PI, 0.5 * FRAC_1_PI * FRAC_1_PI]
                .iter()
                .any(|known| (value / known - 1.0).abs() < 1e-7)
        };
        if value.is_some_and(has_name) && !is_named {
            faults.push(format!("{number} without its name"));
        }
        let masks = |other: Option<usize>| {
            other.and_then(|other| tokens.get(other)).is_some_and(|of| of.is(b'&') || of.is(b'|'))
        };
        let integer: Option<u32> = number.trim_end_matches(['u', 'i']).parse().ok();
        if integer.is_some_and(|integer| integer >= 255)
            && (masks(index.checked_sub(1)) || masks(Some(index + 1)))
        {
            faults.push(format!("{number} is a mask and not hexadecimal"));
        }
    }
    faults
}

/// Values of axes that the head of a text speaks of, though it is about others.
fn strange_values(library: &Library, variant: &Variant, text: &str) -> Vec<String> {
    let contract = text.lines().skip_while(|line| *line != "// Contract:");
    let contract: Vec<_> = contract.take_while(|line| !line.trim_end().ends_with("//")).collect();
    let contract = contract.join("\n");
    let mut strange = Vec::new();
    for (axis, own) in &variant.values {
        for other in library.axis[axis].value.iter().filter(|value| value.name != *own) {
            let phrase = format!("{axis} {}", other.name);
            if contract.contains(&phrase) {
                strange.push(format!("{variant}: `{phrase}` in the contract"));
            }
        }
    }
    strange
}

#[test]
fn our_texts_are_as_a_person_would_have_written_them() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shaders");
    let library = Library::load(&root).unwrap_or_else(|report| panic!("{report}"));
    let variants = with_every_pair(library.variants());
    let validated =
        generate::variants(&library, &variants).unwrap_or_else(|report| panic!("{report}"));
    let mut found = BTreeSet::new();
    for one in &validated {
        let text = wgsl::variant(&library, &one.variant, &one.text);
        found.extend(
            faults(&text, &OURS).into_iter().map(|fault| format!("{}: {fault}", one.variant)),
        );
        found.extend(strange_values(&library, &one.variant, &text));
    }
    let found: Vec<_> = found.into_iter().collect();
    assert!(found.is_empty(), "{} faults:\n{}", found.len(), found.join("\n"));
}

#[test]
fn every_fault_is_found() {
    let sound = "const A_PI: f32 = 3.14159265;

@group(0) @binding(0) var<uniform> a_x: u32;
@group(0) @binding(1) var a_t: texture_2d<f32>;

@compute @workgroup_size(1)
fn a_main() {
    a_f();
}

fn a_f() {
    let mask = a_x & 0xffffu;
}
";
    assert_eq!(faults(sound, &["a_"]), Vec::<String>::new());
    let main = "@compute @workgroup_size(1)\nfn a_main() {\n    a_f();\n}\n\n";
    let texture = "@group(0) @binding(1) var a_t: texture_2d<f32>;\n";
    for (broken, fault) in [
        (sound.replace("    a_f();", "    {\n    a_f();\n    }"), "brace by itself"),
        (sound.replace("    a_f();", "\n    a_f();"), "behind a brace"),
        (sound.replace("    a_f();", "    a_f();\n"), "before a brace"),
        (sound.replace("\n\nfn", "\n\n\nfn"), "behind another one"),
        (sound.replace("a_f();", "a_f(); "), "end of a line"),
        (sound.replace("\n\nfn", &format!("\n\n// {}\nfn", "x".repeat(120))), "long comment"),
        (
            sound
                .replace("binding(1)", "binding(0)")
                .replace("binding(0) var<u", "binding(2) var<u"),
            "out of order",
        ),
        (sound.replace(texture, &format!("override a_n: u32 = 1;\n{texture}")), "apart"),
        (sound.replace(main, "") + "\n" + main.trim_end() + "\n", "entry point behind"),
        (sound.replace(texture, "") + "\n" + texture, "var behind"),
        (sound.replace("a_f();", "let x = 6.2831855;"), "without its name"),
        (sound.replace("0xffffu", "65535u"), "not hexadecimal"),
        (sound.replace("a_f();", "// As a_g.\n    a_f();"), "not there"),
    ] {
        let found = faults(&broken, &["a_"]);
        assert!(found.iter().any(|found| found.contains(fault)), "{fault}: {found:?}\n{broken}");
    }
}

#[test]
fn a_contract_is_that_of_its_variant_alone() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shaders");
    let library = Library::load(&root).unwrap_or_else(|report| panic!("{report}"));
    let mut conditional = 0;
    for variant in library.variants() {
        let contract = library.contract_of(&variant);
        let pass = library.find_pass(&variant.pass).unwrap();
        conditional += pass.contract.len() - contract.len();
        for line in pass.contract.iter().filter(|line| !contract.contains(&line.text)) {
            let differs = |(axis, values): (&String, &Vec<String>)| {
                !values.iter().any(|value| variant.value(axis) == Some(value))
            };
            assert!(line.when.iter().any(differs), "{variant}: {}", line.text);
        }
    }
    assert!(conditional > 0, "no line is about some variants alone");
    // Negative control: what is said of another variant is noticed.
    let variant = library.variant("shade", &[]).unwrap();
    let head = "// Contract:\n// - with visibility imperfect: holes\n//\n";
    assert_eq!(strange_values(&library, &variant, head).len(), 1);
}

#[test]
fn files_are_named_by_what_differs_from_the_defaults() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shaders");
    let ours = Library::load(&root).unwrap_or_else(|report| panic!("{report}"));
    for library in [ours.clone(), foreign_library()] {
        let variants = library.variants();
        let stems: BTreeSet<_> =
            variants.iter().map(|variant| name::stem(&library, variant)).collect();
        assert_eq!(stems.len(), variants.len(), "two variants share a file");
        // Case-insensitive file systems keep them apart, too.
        let folded: BTreeSet<_> = stems.iter().map(|stem| stem.to_lowercase()).collect();
        assert_eq!(folded.len(), stems.len());
        assert!(stems.iter().all(|stem| stem.len() < name::LONGEST));
    }
    let stem = |pass, values: &[(&str, &str)]| {
        name::stem(&ours, &ours.variant(pass, values).unwrap_or_else(|report| panic!("{report}")))
    };
    assert_eq!(stem("shade", &[]), "shade");
    assert_eq!(stem("shade", &[("diffuse", "constant")]), "shade-diffuse_constant");
    assert_eq!(
        stem("shade", &[("specular", "none"), ("ndf", "none"), ("lobes", "diffuse")]),
        "shade-specular_none-ndf_none-lobes_diffuse"
    );
}
