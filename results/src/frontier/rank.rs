//! Which configurations no other dominates in error and in time, by each metric.

use crate::frontier::document::{Configuration, Dominated, Metric};
use crate::time::Time;

/// A configuration as ranking sees it.
#[derive(Clone, Copy, Debug)]
pub struct Place {
    /// How long it takes.
    pub time: Time,
    /// Its error; what is not finite is dominated by all that is.
    pub error: f64,
    /// How far noise may have moved that error.
    pub uncertainty: f64,
}

/// An error counts as less than another if it is by more than this share: nobody sees the rest.
pub const SAME_ERROR: f64 = 0.01;
/// A time counts as less than another if it is by more than this share: runs differ by more.
pub const SAME_TIME: f64 = 0.02;

/// Whether one error counts as less than another: by more than [`SAME_ERROR`] of it and by more than both uncertainties
/// together. Errors of the same noise are apart by less noise than that, so what counts as different is.
fn better(one: &Place, other: &Place) -> bool {
    let (one_error, other_error) = (finite_or_worst(one.error), finite_or_worst(other.error));
    if !other_error.is_finite() {
        return one_error.is_finite();
    }
    let same = SAME_ERROR * other_error;
    other_error - one_error > same.max(one.uncertainty.hypot(other.uncertainty))
}

/// What is not finite is worse than all that is, and alike.
fn finite_or_worst(error: f64) -> f64 {
    if error.is_finite() { error } else { f64::INFINITY }
}

/// For each place the number of one that dominates it, being as fast and as good and better in one of both; none on the
/// frontier. Errors that differ by no more than [`SAME_ERROR`] or their uncertainties and times that differ by no more
/// than [`SAME_TIME`] count as the same. Of several that are alike in both the fastest stays. What dominates is always
/// on the frontier itself.
#[must_use]
pub fn rank(places: &[Place]) -> Vec<Option<usize>> {
    let error = |at: usize| finite_or_worst(places[at].error);
    let time = |at: usize| places[at].time.median;
    let mut order: Vec<usize> = (0..places.len()).collect();
    order.sort_by(|&a, &b| {
        time(a).total_cmp(&time(b)).then(error(a).total_cmp(&error(b))).then(a.cmp(&b))
    });
    let mut dominated = vec![None; places.len()];
    // All that come before are as fast; the last one that stayed is the best of them, and dominates what is not better.
    let mut stayed: Vec<usize> = Vec::new();
    for at in order {
        match stayed.last() {
            Some(&best) if !better(&places[at], &places[best]) => dominated[at] = Some(best),
            _ => stayed.push(at),
        }
    }
    // From the slowest and best on: what is no faster than one that stays, but for what runs differ by, is dominated.
    let mut best: Option<usize> = None;
    for &at in stayed.iter().rev() {
        match best {
            Some(best) if (1.0 - SAME_TIME) * time(best) <= time(at) => dominated[at] = Some(best),
            _ => best = Some(at),
        }
    }
    // What dominated something and was dominated then gives way to what dominates it.
    (0..places.len()).map(|at| dominated[at].map(|by| dominated[by].unwrap_or(by))).collect()
}

/// Marks the frontier by every metric in `configurations` and names what dominates the others, then sorts them: the
/// frontier by the default metric first, then by time.
pub fn mark(configurations: &mut [Configuration]) {
    let names: Vec<String> =
        configurations.iter().map(|configuration| configuration.name.clone()).collect();
    for metric in Metric::ALL {
        let place = |configuration: &Configuration| Place {
            time: configuration.time,
            error: configuration.picture.of(metric),
            uncertainty: configuration.picture.measured(metric).uncertainty,
        };
        let places: Vec<Place> = configurations.iter().map(place).collect();
        for (at, by) in rank(&places).into_iter().enumerate() {
            let configuration = &mut configurations[at];
            let Some(by) = by else {
                configuration.dominated.remove(&metric);
                configuration.frontiers.insert(metric);
                continue;
            };
            configuration.frontiers.remove(&metric);
            let dominated = Dominated {
                by: names[by].clone(),
                time_ratio: places[at].time.median / places[by].time.median,
                error_ratio: places[at].error / places[by].error,
                clear: places[by].time.maximum < places[at].time.minimum,
            };
            configuration.dominated.insert(metric, dominated);
        }
    }
    let behind = |configuration: &Configuration| !configuration.on_frontier(Metric::default());
    configurations.sort_by(|one, other| {
        behind(one).cmp(&behind(other)).then(one.time.median.total_cmp(&other.time.median))
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    fn place(time: f64, error: f64) -> Place {
        let time = Time { median: time, minimum: 0.9 * time, maximum: 1.1 * time };
        Place { time, error, uncertainty: 0.0 }
    }

    #[test]
    fn the_frontier_is_what_nothing_dominates() {
        let places = [
            place(1.0, 0.5),
            place(2.0, 0.6),
            place(3.0, 0.2),
            place(4.0, 0.3),
            place(5.0, f64::NAN),
            place(3.0, 0.2),
        ];
        assert_eq!(rank(&places), [None, Some(0), None, Some(2), Some(2), Some(2)]);
        assert_eq!(rank(&[]), [] as [Option<usize>; 0]);
        // What nobody sees does not count as better, and what no run shows not as faster.
        let near = [place(1.0, 0.5), place(2.0, 0.496), place(3.0, 0.494)];
        assert_eq!(rank(&near), [None, Some(0), None]);
        let near = [place(1.0, 0.5), place(1.01, 0.6), place(1.015, 0.2), place(1.03, 0.1)];
        assert_eq!(rank(&near), [None, Some(0), Some(3), None]);
        let chain = [place(1.0, 0.5), place(1.01, 0.3), place(0.999, 0.6)];
        assert_eq!(rank(&chain), [Some(1), None, Some(1)]);
    }

    #[test]
    fn what_noise_may_have_made_is_not_ranked() {
        let uncertain =
            |time: f64, error: f64, uncertainty: f64| Place { uncertainty, ..place(time, error) };
        let places = [uncertain(1.0, 0.5, 0.1), uncertain(2.0, 0.4, 0.1), uncertain(3.0, 0.2, 0.1)];
        assert_eq!(rank(&places), [None, Some(0), None]);
        // The same numbers known exactly are apart.
        let exact = places.map(|place| Place { uncertainty: 0.0, ..place });
        assert_eq!(rank(&exact), [None, None, None]);
        // Below the noise all are equal.
        let below =
            [uncertain(1.0, 0.0, 0.1), uncertain(2.0, 0.05, 0.1), uncertain(0.5, 0.09, 0.1)];
        assert_eq!(rank(&below), [Some(2), Some(2), None]);
        let lost = [uncertain(1.0, f64::NAN, 0.0), uncertain(2.0, 0.5, 9.0)];
        assert_eq!(rank(&lost), [None, None], "what is finite is better than what is not");
    }

    #[test]
    fn metrics_may_disagree() {
        use crate::frontier::choose::tests::configuration;
        use crate::frontier::document::Uncertainty;
        let mut configurations =
            vec![configuration("one", 1.0, 0.5, 0.1), configuration("two", 2.0, 0.2, 0.3)];
        mark(&mut configurations);
        let two = configurations.iter().find(|configuration| configuration.name == "two").unwrap();
        assert!(two.on_frontier(Metric::Rmse) && !two.on_frontier(Metric::Flip));
        assert_eq!(two.dominated[&Metric::Flip].by, "one");
        assert_eq!(two.frontiers.len() + two.dominated.len(), Metric::ALL.len());
        // An uncertainty above both makes them alike.
        for configuration in &mut configurations {
            configuration.picture.uncertainty = Uncertainty {
                relative_mse: 1.0,
                rmse_over_mean: 1.0,
                median: 1.0,
                q95: 1.0,
                bias: 1.0,
                flip: 1.0,
            };
        }
        mark(&mut configurations);
        let two = configurations.iter().find(|configuration| configuration.name == "two").unwrap();
        assert!(two.frontiers.is_empty() && two.dominated.len() == Metric::ALL.len());
    }

    #[test]
    fn by_brute_force_the_frontier_is_the_same() {
        let mut random = sglow_oracle::fis::stress::Random::new(7);
        let places: Vec<Place> = (0..200)
            .map(|_| {
                let coarse = |value: f64| (value * 20.0).ceil();
                place(coarse(random.uniform()), coarse(random.uniform()))
            })
            .collect();
        let dominates = |a: &Place, b: &Place| {
            let [time, error] = [(a.time.median, b.time.median), (a.error, b.error)];
            time.0 <= time.1 && error.0 <= error.1 && (time.0 < time.1 || error.0 < error.1)
        };
        let as_good = |a: &Place, b: &Place| {
            (1.0 - SAME_TIME) * a.time.median <= b.time.median
                && (1.0 - SAME_ERROR) * a.error <= b.error
        };
        let found = rank(&places);
        for (at, place) in places.iter().enumerate() {
            if places.iter().any(|other| dominates(other, place)) {
                assert!(found[at].is_some(), "{place:?} is dominated");
            }
            if let Some(by) = found[at] {
                assert!(by != at && as_good(&places[by], place), "{place:?} by {:?}", places[by]);
                assert_eq!(found[by], None, "what dominates is on the frontier");
            }
        }
        assert!(found.iter().any(Option::is_none));
    }
}
