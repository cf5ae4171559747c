//! What is known of a scene, as it is shown.

use serde_json::Value;
use sglow_shader_gen::package::Purpose;

/// Something that holds of a scene or does not, and how that is known.
#[derive(Clone, Debug)]
pub struct Fact {
    /// Its name.
    pub name: String,
    /// Whether it holds.
    pub holds: bool,
    /// How that is known.
    pub evidence: String,
}

/// A number or a choice that was made for a scene.
#[derive(Clone, Debug)]
pub struct Decision {
    /// What was decided.
    pub what: String,
    /// How.
    pub value: String,
    /// Why.
    pub reason: String,
    /// Whether it is other than requested.
    pub changed: bool,
}

impl From<&sglow_scene::Fact> for Fact {
    fn from(fact: &sglow_scene::Fact) -> Self {
        let (name, evidence) = (fact.name.to_owned(), fact.evidence.clone());
        Self { name, holds: fact.holds, evidence }
    }
}

/// Bytes of a part of a frame.
#[derive(Clone, Debug)]
pub struct Memory {
    /// The part.
    pub part: &'static str,
    /// Textures or buffers.
    pub storage: &'static str,
    /// For this scene.
    pub bytes: u64,
    /// If every fact held.
    pub bytes_if_every_fact_held: u64,
}

/// What follows from a scene.
#[derive(Clone, Debug)]
pub struct Derived<'a> {
    /// What is true of it.
    pub facts: Vec<Fact>,
    /// What was decided for it.
    pub decisions: Vec<Decision>,
    /// What was left out for it.
    pub purpose: &'a Purpose,
    /// The memory of a frame.
    pub memory: Vec<Memory>,
    /// The size, adapter and driver that milliseconds were measured with, if they were.
    pub measured: Option<([u32; 2], &'a str, &'a str)>,
    /// The same with the milliseconds, as JSON has it.
    pub milliseconds: Value,
}
