//! The frames of many configurations, each of them once.

use std::collections::{BTreeMap, BTreeSet, HashSet};

use rayon::prelude::*;
use sglow_graph::{Configuration, Description, Errors, Frame};

use crate::deep::deep;

/// Configurations that are evaluated before any of their frames is looked at: all frames at once would take gigabytes.
const AT_ONCE: usize = 512;

/// Evaluates configurations that differ in axes and facts alone, on all cores, and lets `visit` see each frame in their
/// order. What gives the same values to all that an earlier frame reads has the same frame and is left out; so are illegal
/// configurations.
pub(crate) fn distinct(
    description: &Description,
    configurations: &[Configuration],
    mut visit: impl FnMut(&Configuration, Result<Frame, Errors>),
) {
    // Without resources and steps, all that can be wrong is the configuration.
    let empty =
        Description { resource: Default::default(), step: Vec::new(), ..description.clone() };
    let legal = |one: &Configuration| !empty.evaluate(one).is_err_and(|errors| errors.is_illegal());
    let mut seen = Seen::default();
    for configurations in configurations.chunks(AT_ONCE) {
        let new = configurations.iter().filter(|one| !seen.has(one) && legal(one));
        let new: Vec<_> = new.collect();
        let frames: Vec<_> = deep(|| new.par_iter().map(|one| description.evaluate(one)).collect());
        for (configuration, frame) in new.into_iter().zip(frames) {
            let new = match &frame {
                Ok(frame) => seen.insert(configuration, &frame.reads),
                Err(_) => true,
            };
            if new {
                visit(configuration, frame);
            }
        }
    }
}

/// Values that frames are known for, by the names that they read.
#[derive(Default)]
struct Seen(BTreeMap<BTreeSet<String>, HashSet<Vec<String>>>);

impl Seen {
    fn has(&self, configuration: &Configuration) -> bool {
        self.0.iter().any(|(reads, known)| known.contains(&values(configuration, reads)))
    }

    /// Whether it is new.
    fn insert(&mut self, configuration: &Configuration, reads: &BTreeSet<String>) -> bool {
        let values = values(configuration, reads);
        self.0.entry(reads.clone()).or_default().insert(values)
    }
}

/// The facts, and what a configuration says of these names. Parameters are the same in all.
fn values(configuration: &Configuration, reads: &BTreeSet<String>) -> Vec<String> {
    let facts = configuration.facts.values().map(bool::to_string);
    let of_axis = |axis: &String| configuration.axes.get(axis).cloned().unwrap_or_default();
    facts.chain(reads.iter().map(of_axis)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::library::Library;

    #[test]
    fn every_frame_is_seen_once() {
        let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../shaders");
        let library = Library::load(folder.as_ref()).unwrap();
        let frame = library.frame().unwrap();
        let (description, all) = (&frame.description, frame.configurations(1));
        let mut found = Vec::new();
        distinct(description, &all, |_, frame| found.extend(frame));
        let each: Vec<Frame> = all.iter().flat_map(|one| description.evaluate(one)).collect();
        println!("{} of {} frames", found.len(), each.len());
        assert!(10 < found.len() && found.len() < each.len());
        assert!(each.iter().all(|frame| found.contains(frame)));
        // Negative control: without a name that is read, frames are lost.
        let kept = |name: &str| {
            let mut seen = Seen::default();
            let frames = all.iter().flat_map(|one| Some((one, description.evaluate(one).ok()?)));
            let reads =
                |frame: Frame| frame.reads.into_iter().filter(|read| read != name).collect();
            frames.filter(|(one, frame)| seen.insert(one, &reads(frame.clone()))).count()
        };
        assert_eq!(kept(""), found.len());
        assert!(found[0].reads.iter().any(|name| kept(name) < found.len()));
    }
}
