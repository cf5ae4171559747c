//! Descriptions that no generator has checked: whatever is wrong is an error with its place.

#![allow(clippy::unwrap_used, reason = "helpers of tests are tests, too")]

use serde_json::{Value, json};
use sglow_graph::{Configuration, Description};

/// What is wrong with a description.
fn wrong(description: Value) -> Vec<String> {
    let description: Description = serde_json::from_value(description).unwrap();
    let errors = description.evaluate(&Configuration::default()).unwrap_err();
    errors.0.iter().map(ToString::to_string).collect()
}

#[test]
fn formulas_that_are_none_have_no_value() {
    for (formula, text) in [
        (json!({ "+": [1] }), "unknown operation: `+` of 1"),
        (json!({ "root": [4, 2] }), "unknown operation: `root` of 4, 2"),
        (json!({ "select": [1, 2] }), "unknown operation: `select` of 1, 2"),
        (json!({ "min": [1, 2, 3] }), "unknown operation: `min` of 1, 2, 3"),
        (json!({}), "an empty formula"),
        (json!({ "<<": [1, 64] }), "the result exceeds 64 bits: `<<` of 1, 64"),
        (json!({ "%": [1, { "-": [1, 1] }] }), "division by zero: `%` of 1, 0"),
        (json!({ "name": "nothing" }), "unknown name `nothing`"),
        (json!({ "is": ["tide", "low"] }), "unknown axis `tide`"),
    ] {
        let buffer = json!({ "length": 1, "stride": formula });
        let found = wrong(json!({ "resource": { "words": { "buffer": buffer } } }));
        assert_eq!(found, [format!("resource.words: {text}")]);
    }
    let circle =
        json!({ "wheel": { "name": "circle" }, "circle": { "+": [{ "name": "wheel" }, 1] } });
    let buffer = json!({ "length": { "name": "wheel" }, "stride": 4 });
    let found = wrong(json!({ "let": circle, "resource": { "words": { "buffer": buffer } } }));
    assert!(found[0].starts_with("let.") && found[0].ends_with("depends on itself"), "{found:?}");
}

#[test]
fn what_is_nothing_or_two_things_is_named() {
    let found = wrong(json!({
        "passes": { "sum": [] },
        "resource": {
            "image": { "texture": { "format": "r32float", "size": [4, 4], "layers": 1, "levels": 4 } },
        },
        "step": [
            {},
            { "pass": "sum" },
            { "pass": "sum", "dispatch": [1, 1, 1], "uniforms": { "numbers": "numbers" } },
            { "clear": { "resource": "nowhere" } },
            { "repeat": 2, "index": "round", "steps": [ {
                "pass": "sum", "dispatch": [1, 1, 1],
                "bind": { "image": { "resource": "image", "level": { "+": [{ "name": "round" }, 2] } } },
            } ] },
        ],
    }));
    let expected = [
        "resource.image: 4 levels; expected 1 to 3",
        "step.0: a step is one of `pass`, `clear` and `steps`",
        "step.1: a pass has one of `dispatch`, `indirect` and `draw`",
        "step.2: unknown uniform `numbers`",
        "step.3: unknown resource `nowhere`",
        "step.4.steps.0: level 3 of `image`, which has 3",
    ];
    assert_eq!(found, expected);
    let read = |resource: Value| {
        serde_json::from_value::<Description>(json!({ "resource": { "words": resource } }))
    };
    let buffer = json!({ "length": 1, "stride": 4 });
    assert!(read(json!({ "buffer": buffer })).is_ok());
    assert!(read(json!({ "sampler": "linear", "buffer": buffer })).is_err());
    assert!(read(json!({})).is_err());
}
