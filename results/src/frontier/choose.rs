//! The way that a budget buys.

use crate::check::{Check, Relation};
use crate::frontier::document::{Metric, Reference, Way};
use crate::time::Time;

/// What may be spent.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Budget {
    /// The cheapest way that is at most so wrong.
    Error(f64),
    /// The most accurate way that takes at most so many milliseconds.
    Milliseconds(f64),
}

/// How many ways that come close are kept beside the best one.
const CLOSE: usize = 4;

/// What a budget buys.
#[derive(Clone, Debug, PartialEq)]
pub enum Bought<'a> {
    /// The way that wins and those that come next, best first.
    Ways(Vec<&'a Way>),
    /// Nothing: the way that comes nearest, and by how much it misses, in the unit of the budget.
    Nothing {
        /// The way.
        nearest: &'a Way,
        /// How much less would have done.
        by: f64,
    },
}

/// What a budget buys.
#[derive(Clone, Debug)]
pub struct Purchase {
    /// Every way; those that were compared closely have times of whole frames.
    pub ways: Vec<Way>,
    /// The names of those that win and come next, best first; nothing if the budget buys nothing.
    pub order: Vec<String>,
    /// What errors are against.
    pub reference: Reference,
    /// How times were taken.
    pub clock: String,
}

/// The time of a way: of whole frames where it was taken, else of its passes.
#[must_use]
pub fn time(way: &Way) -> Time {
    way.whole.unwrap_or(way.time)
}

/// What a budget buys of ways that were measured; nothing at all of no ways.
///
/// With an error to be kept, ways that are as fast go by their error; with a time to be kept, ways that are as good go by
/// their time.
#[must_use]
pub fn choose(ways: &[Way], metric: Metric, budget: Budget) -> Option<Bought<'_>> {
    let error = |way: &Way| way.picture.of(metric);
    let time = |way: &Way| time(way).median;
    let (spent, limit): (&dyn Fn(&Way) -> f64, f64) = match budget {
        Budget::Error(limit) => (&error, limit),
        Budget::Milliseconds(limit) => (&time, limit),
    };
    let mut bought: Vec<&Way> = ways.iter().filter(|way| spent(way) <= limit).collect();
    if bought.is_empty() {
        let nearest = ways.iter().min_by(|one, other| spent(one).total_cmp(&spent(other)))?;
        return Some(Bought::Nothing { nearest, by: spent(nearest) - limit });
    }
    bought.sort_by(|one, other| match budget {
        Budget::Error(_) => {
            time(one).total_cmp(&time(other)).then(error(one).total_cmp(&error(other)))
        }
        Budget::Milliseconds(_) => {
            error(one).total_cmp(&error(other)).then(time(one).total_cmp(&time(other)))
        }
    });
    bought.truncate(1 + CLOSE);
    Some(Bought::Ways(bought))
}

/// The budget as something that holds.
#[must_use]
pub fn kept(winner: &Way, metric: Metric, budget: Budget) -> Check {
    let relation = Relation::AtMost;
    match budget {
        Budget::Error(most) => {
            let error = winner.picture.of(metric);
            Check::new(
                "error of the configuration that was chosen",
                error,
                metric.title(),
                relation,
                most,
            )
        }
        Budget::Milliseconds(most) => {
            let time = time(winner).median;
            Check::new("time of the configuration that was chosen", time, "ms", relation, most)
        }
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::frontier::document::PictureError;

    pub(in crate::frontier) fn way(name: &str, time: f64, rmse: f64, flip: f64) -> Way {
        Way {
            name: name.to_owned(),
            complete: true,
            time: Time { median: time, least: time, most: time },
            picture: PictureError { rmse_over_mean: rmse, flip, ..PictureError::default() },
            ..Way::default()
        }
    }

    fn names(bought: Option<Bought<'_>>) -> Vec<String> {
        match bought {
            Some(Bought::Ways(ways)) => ways.iter().map(|way| way.name.clone()).collect(),
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn a_budget_buys_the_cheapest_or_the_most_accurate() {
        let ways = [
            way("rough", 1.0, 0.5, 0.01),
            way("good", 3.0, 0.2, 0.10),
            way("same", 3.0, 0.1, 0.30),
            way("best", 9.0, 0.05, 0.20),
            way("broken", 0.1, f64::NAN, f64::NAN),
        ];
        let rmse = |budget| names(choose(&ways, Metric::Rmse, budget));
        assert_eq!(rmse(Budget::Error(0.3)), ["same", "good", "best"]);
        assert_eq!(rmse(Budget::Error(0.2)), ["same", "good", "best"], "the limit itself will do");
        assert_eq!(rmse(Budget::Milliseconds(4.0)), ["same", "good", "rough", "broken"]);
        assert_eq!(names(choose(&ways, Metric::Flip, Budget::Milliseconds(4.0)))[0], "rough");
    }

    #[test]
    fn a_budget_that_buys_nothing_names_what_comes_nearest() {
        let ways = [way("rough", 1.0, 0.5, 0.5), way("good", 3.0, 0.25, 0.25)];
        let by = |budget| match choose(&ways, Metric::Rmse, budget) {
            Some(Bought::Nothing { nearest, by }) => (nearest.name.clone(), by),
            other => panic!("{other:?}"),
        };
        assert_eq!(by(Budget::Error(0.125)), ("good".to_owned(), 0.125));
        assert_eq!(by(Budget::Milliseconds(0.5)), ("rough".to_owned(), 0.5));
        assert_eq!(choose(&[], Metric::Rmse, Budget::Error(1.0)), None);
    }

    #[test]
    fn whole_frames_count_where_there_are_some() {
        let mut slower = way("slower", 1.0, 0.2, 0.2);
        slower.whole = Some(Time { median: 5.0, ..Time::default() });
        let ways = [slower, way("faster", 2.0, 0.2, 0.2)];
        assert_eq!(names(choose(&ways, Metric::Rmse, Budget::Error(1.0)))[0], "faster");
    }
}
