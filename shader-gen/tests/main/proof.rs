//! A pruner that takes away too much, too little or the wrong thing is refused.

use std::collections::BTreeSet;

use naga::Module;
use sglow_shader_gen::prune::{Difference, prove};
use sglow_shader_gen::validate::validator;

const UNPRUNED: &str = "
const SCALE = 2.0;
const OTHER = 3.0;
override gain = 1.0;
struct Item { a: f32, b: f32 }
@group(0) @binding(0) var<storage, read_write> items: array<Item>;
@group(0) @binding(1) var<storage, read_write> unused: array<f32>;
fn weight(x: f32) -> f32 { return x * SCALE * gain; }
fn never(x: f32) -> f32 { return weight(x) * OTHER + unused[0]; }
@compute @workgroup_size(64) fn main() { items[0].a = weight(items[0].b); }
@compute @workgroup_size(1) fn trace() { unused[0] = never(1.0); }
";

fn read(text: &str) -> Option<Module> {
    let module = naga::front::wgsl::parse_str(text).ok()?;
    validator(&BTreeSet::new()).validate(&module).ok()?;
    Some(module)
}

/// The verdict on what is left of [`UNPRUNED`] after `edits`; none if naga does not even read it.
fn verdict(edits: &[(&str, &str)]) -> Option<Result<(), Difference>> {
    let mut pruned = UNPRUNED.to_owned();
    for (from, to) in edits {
        assert!(pruned.contains(from), "{from}");
        pruned = pruned.replacen(from, to, 1);
    }
    let rest = UNPRUNED.lines().filter(|line| !pruned.lines().any(|kept| name(kept) == name(line)));
    let unpruned = match edits {
        // What stays comes first, in the words of the unpruned text.
        [] => UNPRUNED.to_owned(),
        _ => {
            let kept =
                UNPRUNED.lines().filter(|line| pruned.lines().any(|kept| name(kept) == name(line)));
            kept.chain(rest).collect::<Vec<_>>().join("\n")
        }
    };
    Some(prove(&read(&pruned)?, Some(read(&unpruned).unwrap()), &["main".to_owned()]))
}

/// What a line declares.
fn name(line: &str) -> &str {
    let words = [
        "SCALE",
        "OTHER",
        "override gain",
        "Item {",
        "> items",
        "> unused",
        "fn weight",
        "fn never",
        "fn main",
        "fn trace",
    ];
    words.into_iter().find(|word| line.contains(word)).unwrap_or_default()
}

/// Everything that `main` does not need.
const RIGHT: [(&str, &str); 4] = [
    ("const OTHER = 3.0;\n", ""),
    ("@group(0) @binding(1) var<storage, read_write> unused: array<f32>;\n", ""),
    ("fn never(x: f32) -> f32 { return weight(x) * OTHER + unused[0]; }\n", ""),
    ("@compute @workgroup_size(1) fn trace() { unused[0] = never(1.0); }\n", ""),
];

#[test]
fn the_right_text_passes() {
    assert_eq!(verdict(&RIGHT), Some(Ok(())));
}

#[test]
fn a_constant_that_is_needed_is_missed() {
    let mut edits = RIGHT.to_vec();
    edits.push(("const SCALE = 2.0;\n", ""));
    assert_eq!(verdict(&edits), None);
}

#[test]
fn what_is_left_over_is_found() {
    let left = |kind, name: &str| Some(Err(Difference::Left { kind, name: name.to_owned() }));
    assert_eq!(verdict(&RIGHT[..3]), None, "the trace needs what it calls");
    assert_eq!(verdict(&[RIGHT[3]]), left("function", "never"));
    assert_eq!(verdict(&[RIGHT[2], RIGHT[3]]), left("var", "unused"));
    assert_eq!(verdict(&[]), left("function", "never"));
}

#[test]
fn a_change_is_found() {
    for (from, to, part) in [
        ("SCALE = 2.0", "SCALE = 2.5", "functions"),
        ("gain = 1.0", "gain = 1.5", "constant expressions"),
        ("x * SCALE * gain", "x * gain * SCALE", "functions"),
        ("items[0].a = weight(items[0].b)", "items[0].b = weight(items[0].b)", "entry points"),
        ("@workgroup_size(64)", "@workgroup_size(32)", "entry points"),
        ("a: f32, b: f32", "a: f32, @align(16) b: f32", "types"),
        ("@binding(0)", "@binding(7)", "variables"),
    ] {
        let mut edits = RIGHT.to_vec();
        edits.push((from, to));
        assert_eq!(verdict(&edits), Some(Err(Difference::Changed { part })), "{to}");
    }
}
