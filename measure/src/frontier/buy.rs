//! What a budget buys of a scene's configurations, measured.

use std::collections::BTreeMap;

use sglow_results::frontier::choose::{Bought, Budget, Purchase, choose};
use sglow_results::frontier::document::Metric;
use sglow_results::frontier::rank;
use sglow_results::progress::Progress;
use sglow_runtime::settings::Settings;

use super::references::references;
use super::subject::{FrontierError, Subject};
use super::together::whole_frames;
use super::{configuration, measure};
use crate::cache::Cache;

/// Finds what a budget buys among `configurations`. Whatever comes first has been measured again as whole frames, in
/// turns with what comes close to it.
///
/// # Errors
///
/// When the scene does not render, a variant is missing or a result cannot be kept.
pub fn buy(
    subject: &Subject<'_>,
    configurations: &[Settings],
    metric: Metric,
    budget: Budget,
    cache: &Cache,
    progress: &dyn Progress,
) -> Result<Purchase, FrontierError> {
    let references = references(subject, cache, progress)?;
    let mut measured = measure::every(subject, configurations, &references, cache, progress)?;
    rank::mark(&mut measured.configurations);
    let settings: BTreeMap<String, &Settings> = configurations
        .iter()
        .map(|settings| (configuration::name(settings, &subject.base), settings))
        .collect();
    loop {
        let order: Vec<String> = match choose(&measured.configurations, metric, budget) {
            Some(Bought::Configurations(configurations)) => {
                configurations.iter().map(|configuration| configuration.name.clone()).collect()
            }
            Some(Bought::Nothing { .. }) | None => Vec::new(),
        };
        let first = measured
            .configurations
            .iter()
            .find(|configuration| order.first() == Some(&configuration.name));
        if first.is_none_or(|configuration| configuration.whole.is_some()) {
            let (reference, clock) = (references.reference, measured.clock);
            return Ok(Purchase {
                configurations: measured.configurations,
                order,
                reference,
                clock,
            });
        }
        // Each round gives at least one more configuration a time of whole frames, so there is a last one.
        let named: Vec<(String, &Settings)> =
            order.iter().filter_map(|name| Some((name.clone(), *settings.get(name)?))).collect();
        progress
            .start(&format!("{}: {} configurations in turns", subject.scene.name, named.len()), 0);
        let times = whole_frames(subject, &named, cache)?;
        for ((name, _), time) in named.iter().zip(times) {
            if let Some(configuration) =
                measured.configurations.iter_mut().find(|configuration| configuration.name == *name)
            {
                configuration.whole = Some(time);
            }
        }
    }
}
