//! Which ways no other beats in error and in time.

use super::document::{Dominated, Way};
use crate::time::Time;

/// A way as ranking sees it.
#[derive(Clone, Copy, Debug)]
pub struct Place {
    /// How long it takes.
    pub time: Time,
    /// How wrong it is; what is not finite is beaten by all that is.
    pub error: f64,
}

/// An error counts as less than another if it is by more than this share: nobody sees the rest.
pub const SAME_ERROR: f64 = 0.01;
/// A time counts as less than another if it is by more than this share: runs differ by more.
pub const SAME_TIME: f64 = 0.02;

/// For each place the number of one that beats it, being as fast and as good and better in one of both; none on the
/// frontier. Errors and times that differ by no more than [`SAME_ERROR`] and [`SAME_TIME`] count as the same, and so do
/// errors below `floor`, where nothing is claimed. Of several that are alike in both the fastest stays. What beats is
/// always on the frontier itself.
#[must_use]
pub fn rank(places: &[Place], floor: f64) -> Vec<Option<usize>> {
    let error = |at: usize| {
        let error = places[at].error;
        if error.is_finite() { error.max(floor) } else { f64::INFINITY }
    };
    let time = |at: usize| places[at].time.median;
    let mut order: Vec<usize> = (0..places.len()).collect();
    order.sort_by(|&a, &b| {
        time(a).total_cmp(&time(b)).then(error(a).total_cmp(&error(b))).then(a.cmp(&b))
    });
    let mut beaten = vec![None; places.len()];
    // All that come before are as fast; the last one that stayed is the best of them, and beats what is not better.
    let mut stayed: Vec<usize> = Vec::new();
    for at in order {
        match stayed.last() {
            Some(&best) if (1.0 - SAME_ERROR) * error(best) <= error(at) => beaten[at] = Some(best),
            _ => stayed.push(at),
        }
    }
    // From the slowest and best on: what is no faster than one that stays, but for what runs differ by, is beaten by it.
    let mut best: Option<usize> = None;
    for &at in stayed.iter().rev() {
        match best {
            Some(best) if (1.0 - SAME_TIME) * time(best) <= time(at) => beaten[at] = Some(best),
            _ => best = Some(at),
        }
    }
    // What beat something and was beaten then gives way to what beat it.
    (0..places.len()).map(|at| beaten[at].map(|by| beaten[by].unwrap_or(by))).collect()
}

/// Marks the frontier in `ways` and names what beats the others, then sorts them: the frontier first, then by time.
pub fn mark(ways: &mut [Way], floor: f64) {
    let places: Vec<Place> = ways
        .iter()
        .map(|way| Place { time: way.time, error: way.picture.rmse_over_mean })
        .collect();
    let names: Vec<String> = ways.iter().map(|way| way.name.clone()).collect();
    for (at, by) in rank(&places, floor).into_iter().enumerate() {
        ways[at].frontier = by.is_none();
        ways[at].dominated = by.map(|by| Dominated {
            by: names[by].clone(),
            time_ratio: places[at].time.median / places[by].time.median,
            error_ratio: places[at].error / places[by].error,
            clear: places[by].time.most < places[at].time.least,
        });
    }
    ways.sort_by(|one, other| {
        other.frontier.cmp(&one.frontier).then(one.time.median.total_cmp(&other.time.median))
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    fn place(time: f64, error: f64) -> Place {
        let time = Time { median: time, least: 0.9 * time, most: 1.1 * time };
        Place { time, error }
    }

    #[test]
    fn the_frontier_is_what_nothing_beats_in_both() {
        let places = [
            place(1.0, 0.5),
            place(2.0, 0.6),
            place(3.0, 0.2),
            place(4.0, 0.3),
            place(5.0, f64::NAN),
            place(3.0, 0.2),
        ];
        assert_eq!(rank(&places, 0.0), [None, Some(0), None, Some(2), Some(2), Some(2)]);
        // Below the floor all are alike, and the fastest of them wins.
        assert_eq!(rank(&places, 0.55), [None, Some(0), Some(0), Some(0), Some(0), Some(0)]);
        assert_eq!(rank(&[], 0.0), [] as [Option<usize>; 0]);
        // What nobody sees does not count as better, and what no run shows not as faster.
        let near = [place(1.0, 0.5), place(2.0, 0.496), place(3.0, 0.494)];
        assert_eq!(rank(&near, 0.0), [None, Some(0), None]);
        let near = [place(1.0, 0.5), place(1.01, 0.6), place(1.015, 0.2), place(1.03, 0.1)];
        assert_eq!(rank(&near, 0.0), [None, Some(0), Some(3), None]);
        let chain = [place(1.0, 0.5), place(1.01, 0.3), place(0.999, 0.6)];
        assert_eq!(rank(&chain, 0.0), [Some(1), None, Some(1)]);
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
        let beats = |a: &Place, b: &Place| {
            let [time, error] = [(a.time.median, b.time.median), (a.error, b.error)];
            time.0 <= time.1 && error.0 <= error.1 && (time.0 < time.1 || error.0 < error.1)
        };
        let as_good = |a: &Place, b: &Place| {
            (1.0 - SAME_TIME) * a.time.median <= b.time.median
                && (1.0 - SAME_ERROR) * a.error <= b.error
        };
        let found = rank(&places, 0.0);
        for (at, place) in places.iter().enumerate() {
            if places.iter().any(|other| beats(other, place)) {
                assert!(found[at].is_some(), "{place:?} is beaten");
            }
            if let Some(by) = found[at] {
                assert!(by != at && as_good(&places[by], place), "{place:?} by {:?}", places[by]);
                assert_eq!(found[by], None, "what beats is on the frontier");
            }
        }
        assert!(found.iter().any(Option::is_none));
    }
}
