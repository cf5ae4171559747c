//! A scene on the page.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::Serialize;
use sglow_results::frontier::document::{Pictures, SceneReport};
use sglow_shader_gen::manifest;
use sglow_shader_gen::package::Purpose;

use crate::scene::{Decision, Fact};

/// What a package was made without.
pub fn left_out_by(purpose: &Purpose) -> Vec<LeftOut> {
    let one = |left: &manifest::LeftOut| LeftOut {
        what: left.what(),
        rule: left.rule.clone(),
        reason: left.reason.clone(),
        saved: numbers(&left.saved),
    };
    let mut all: Vec<LeftOut> = purpose.left_out.iter().map(one).collect();
    all.push(LeftOut {
        what: "all of it".to_owned(),
        rule: String::new(),
        reason: "against all that a scene may need of which every fact holds".to_owned(),
        saved: numbers(&purpose.made_for.saved),
    });
    all
}

fn numbers(saved: &manifest::Saved) -> BTreeMap<String, f64> {
    let mut numbers: BTreeMap<String, f64> = [
        ("static_operations", saved.static_operations),
        ("bindings", saved.bindings),
        ("texture_bytes", saved.texture_bytes),
        ("buffer_bytes", saved.buffer_bytes),
        ("shader_bytes", saved.shader_bytes),
    ]
    .map(|(name, number)| (name.to_owned(), number as f64))
    .into();
    numbers.extend(saved.milliseconds.map(|time| ("milliseconds".to_owned(), time)));
    numbers
}

/// Something that a scene's package has not.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct LeftOut {
    /// What it is.
    pub what: String,
    /// The rule that left it out.
    pub rule: String,
    /// Why.
    pub reason: String,
    /// What that saves: bytes where the name ends in `bytes`, milliseconds where it is `milliseconds`, counts
    /// otherwise.
    pub saved: BTreeMap<String, f64>,
}

/// A scene on the page.
#[derive(Clone, Copy, Debug)]
pub struct Scene<'a> {
    /// What was measured of it.
    pub measured: &'a SceneReport,
    /// Its pictures.
    pub pictures: &'a Pictures,
    /// FLIP maps by the name of the configuration, 0 to 1 each pixel, row by row from the top.
    pub flip: &'a BTreeMap<String, Vec<f32>>,
    /// What it needs, and how that is known.
    pub facts: &'a [Fact],
    /// What was decided for it.
    pub decisions: &'a [Decision],
    /// What its package has not.
    pub left_out: &'a [LeftOut],
}
