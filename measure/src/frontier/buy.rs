//! What a budget buys of a scene's ways, measured.

use std::collections::BTreeMap;

use sglow_results::frontier::choose::{Bought, Budget, Purchase, choose};
use sglow_results::frontier::document::Metric;
use sglow_results::frontier::rank;
use sglow_results::progress::Progress;
use sglow_runtime::settings::Settings;

use super::subject::{FrontierError, Subject};
use super::together::whole_frames;
use super::truth::truth;
use super::{measure, way};
use crate::cache::Cache;

/// Finds what a budget buys among `ways`. Whatever comes first has been measured again as whole frames, in turns with
/// what comes close to it.
///
/// # Errors
///
/// When the scene does not render, a variant is missing or a result cannot be kept.
pub fn buy(
    subject: &Subject<'_>,
    ways: &[Settings],
    metric: Metric,
    budget: Budget,
    cache: &Cache,
    progress: &dyn Progress,
) -> Result<Purchase, FrontierError> {
    let truth = truth(subject, cache, progress)?;
    let mut measured = measure::every(subject, ways, &truth, cache, progress)?;
    rank::mark(&mut measured.ways);
    let settings: BTreeMap<String, &Settings> =
        ways.iter().map(|settings| (way::name(settings, &subject.base), settings)).collect();
    loop {
        let order: Vec<String> = match choose(&measured.ways, metric, budget) {
            Some(Bought::Ways(ways)) => ways.iter().map(|way| way.name.clone()).collect(),
            Some(Bought::Nothing { .. }) | None => Vec::new(),
        };
        let first = measured.ways.iter().find(|way| order.first() == Some(&way.name));
        if first.is_none_or(|way| way.whole.is_some()) {
            let (reference, clock) = (truth.reference, measured.clock);
            return Ok(Purchase { ways: measured.ways, order, reference, clock });
        }
        // Each round gives at least one more way a time of whole frames, so there is a last one.
        let named: Vec<(String, &Settings)> =
            order.iter().filter_map(|name| Some((name.clone(), *settings.get(name)?))).collect();
        progress.start(&format!("{}: {} ways in turns", subject.scene.name, named.len()), 0);
        let times = whole_frames(subject, &named, cache)?;
        for ((name, _), time) in named.iter().zip(times) {
            if let Some(way) = measured.ways.iter_mut().find(|way| way.name == *name) {
                way.whole = Some(time);
            }
        }
    }
}
