//! What is known of a scene, from the types of the renderer to those that are shown.

use sglow_renderer::needs::{self, Needs};
use sglow_renderer::request::selection;
use sglow_report::failure::Result;
use sglow_report::scene::{Decision, Derived, Fact, Memory};
use sglow_results::saved::Measured;

/// What is true of it.
pub(crate) fn facts(needs: &Needs) -> Vec<Fact> {
    needs.facts.iter().map(Fact::from).collect()
}

/// What was decided for it.
pub(crate) fn decisions(needs: &Needs) -> Vec<Decision> {
    let decision = |one: &needs::Decision| {
        let (what, value, reason) = (one.name.to_owned(), one.value.clone(), one.reason.clone());
        Decision { what, value, reason, changed: one.changed }
    };
    needs.decisions.iter().map(decision).collect()
}

/// What follows from it.
pub(crate) fn derived<'a>(
    derived: &'a selection::Derived,
    measured: Option<&'a Measured>,
) -> Result<Derived<'a>> {
    let needs = &derived.derivation.needs;
    let memory = |(part, storage, [bytes, bytes_if_every_fact_held]): (_, _, [u64; 2])| Memory {
        part,
        storage,
        bytes,
        bytes_if_every_fact_held,
    };
    Ok(Derived {
        facts: facts(needs),
        decisions: decisions(needs),
        purpose: &derived.purpose,
        memory: derived.memory().into_iter().map(memory).collect(),
        measured: measured.map(|one| (one.size, one.adapter.as_str(), one.driver.as_str())),
        milliseconds: serde_json::to_value(measured)?,
    })
}
