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

/// An error counts as better if it is less than another by more than this share: nobody sees the rest.
pub const ALIKE: f64 = 0.01;

/// For each place the number of one that beats it, being as fast and as good; none on the frontier. Errors that differ
/// by no more than the share [`ALIKE`] are as good as each other, and so are those below `floor`, where nothing is
/// claimed. Of several that are alike in both the first one stays.
#[must_use]
pub fn rank(places: &[Place], floor: f64) -> Vec<Option<usize>> {
    let error = |place: &Place| {
        if place.error.is_finite() { place.error.max(floor) } else { f64::INFINITY }
    };
    let mut order: Vec<usize> = (0..places.len()).collect();
    order.sort_by(|&a, &b| {
        let (one, other) = (&places[a], &places[b]);
        let by_time = one.time.median.total_cmp(&other.time.median);
        by_time.then(error(one).total_cmp(&error(other))).then(a.cmp(&b))
    });
    let mut beaten = vec![None; places.len()];
    // All that come before are as fast; the best of those that nothing beats so far beats what is not better.
    let mut best: Option<usize> = None;
    for at in order {
        match best {
            Some(best) if (1.0 - ALIKE) * error(&places[best]) <= error(&places[at]) => {
                beaten[at] = Some(best);
            }
            _ => best = Some(at),
        }
    }
    beaten
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
        // What nobody sees does not count as better.
        let near = [place(1.0, 0.5), place(2.0, 0.496), place(3.0, 0.494)];
        assert_eq!(rank(&near, 0.0), [None, Some(0), None]);
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
        let found = rank(&places, 0.0);
        for (at, place) in places.iter().enumerate() {
            if places.iter().any(|other| beats(other, place)) {
                assert!(found[at].is_some(), "{place:?} is beaten");
            }
            if let Some(by) = found[at] {
                let alike =
                    places[by].error == place.error && places[by].time.median == place.time.median;
                assert!(alike && by != at || beats(&places[by], place));
                assert_eq!(found[by], None, "what beats is on the frontier");
            }
        }
    }
}
