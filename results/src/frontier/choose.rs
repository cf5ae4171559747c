//! The configuration that a budget buys.

use crate::check::{Check, Relation};
use crate::frontier::document::{Configuration, Metric, Reference};
use crate::time::Time;

/// What may be spent.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Budget {
    /// The cheapest configuration whose error is at most this.
    Error(f64),
    /// The most accurate configuration that takes at most so many milliseconds.
    Milliseconds(f64),
}

/// How many configurations that come close are kept beside the best one.
const CLOSE: usize = 4;

/// What a budget buys.
#[derive(Clone, Debug, PartialEq)]
pub enum Bought<'a> {
    /// The configuration that wins and those that come next, best first.
    Configurations(Vec<&'a Configuration>),
    /// Nothing: the configuration that comes nearest, and by how much it misses, in the unit of the budget.
    Nothing {
        /// The configuration.
        nearest: &'a Configuration,
        /// How much less would have done.
        by: f64,
    },
}

/// What a budget buys.
#[derive(Clone, Debug)]
pub struct Purchase {
    /// Every configuration; those that were compared closely have times of whole frames.
    pub configurations: Vec<Configuration>,
    /// The names of those that win and come next, best first; nothing if the budget buys nothing.
    pub order: Vec<String>,
    /// What errors are against.
    pub reference: Reference,
    /// How times were taken.
    pub clock: String,
}

/// The time of a configuration: of whole frames where it was taken, else of its passes.
#[must_use]
pub fn time(configuration: &Configuration) -> Time {
    configuration.whole.unwrap_or(configuration.time)
}

/// What a budget buys of configurations that were measured; nothing at all of no configurations.
///
/// With an error to be kept, configurations that are as fast go by their error; with a time to be kept, configurations
/// that are as good go by their time.
#[must_use]
pub fn choose(
    configurations: &[Configuration],
    metric: Metric,
    budget: Budget,
) -> Option<Bought<'_>> {
    let error = |configuration: &Configuration| configuration.picture.of(metric);
    let time = |configuration: &Configuration| time(configuration).median;
    let (spent, limit): (&dyn Fn(&Configuration) -> f64, f64) = match budget {
        Budget::Error(limit) => (&error, limit),
        Budget::Milliseconds(limit) => (&time, limit),
    };
    let mut bought: Vec<&Configuration> =
        configurations.iter().filter(|configuration| spent(configuration) <= limit).collect();
    if bought.is_empty() {
        let nearest =
            configurations.iter().min_by(|one, other| spent(one).total_cmp(&spent(other)))?;
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
    Some(Bought::Configurations(bought))
}

/// The budget as something that holds.
#[must_use]
pub fn kept(winner: &Configuration, metric: Metric, budget: Budget) -> Check {
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

    pub(in crate::frontier) fn configuration(
        name: &str,
        time: f64,
        rmse: f64,
        flip: f64,
    ) -> Configuration {
        Configuration {
            name: name.to_owned(),
            complete: true,
            time: Time { median: time, minimum: time, maximum: time },
            picture: PictureError { rmse_over_mean: rmse, flip, ..PictureError::default() },
            ..Configuration::default()
        }
    }

    fn names(bought: Option<Bought<'_>>) -> Vec<String> {
        match bought {
            Some(Bought::Configurations(configurations)) => {
                configurations.iter().map(|configuration| configuration.name.clone()).collect()
            }
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn a_budget_buys_the_cheapest_or_the_most_accurate() {
        let configurations = [
            configuration("rough", 1.0, 0.5, 0.01),
            configuration("good", 3.0, 0.2, 0.10),
            configuration("same", 3.0, 0.1, 0.30),
            configuration("best", 9.0, 0.05, 0.20),
            configuration("broken", 0.1, f64::NAN, f64::NAN),
        ];
        let rmse = |budget| names(choose(&configurations, Metric::Rmse, budget));
        assert_eq!(rmse(Budget::Error(0.3)), ["same", "good", "best"]);
        assert_eq!(rmse(Budget::Error(0.2)), ["same", "good", "best"], "the limit itself will do");
        assert_eq!(rmse(Budget::Milliseconds(4.0)), ["same", "good", "rough", "broken"]);
        assert_eq!(
            names(choose(&configurations, Metric::Flip, Budget::Milliseconds(4.0)))[0],
            "rough"
        );
    }

    #[test]
    fn a_budget_that_buys_nothing_names_what_comes_nearest() {
        let configurations =
            [configuration("rough", 1.0, 0.5, 0.5), configuration("good", 3.0, 0.25, 0.25)];
        let by = |budget| match choose(&configurations, Metric::Rmse, budget) {
            Some(Bought::Nothing { nearest, by }) => (nearest.name.clone(), by),
            other => panic!("{other:?}"),
        };
        assert_eq!(by(Budget::Error(0.125)), ("good".to_owned(), 0.125));
        assert_eq!(by(Budget::Milliseconds(0.5)), ("rough".to_owned(), 0.5));
        assert_eq!(choose(&[], Metric::Rmse, Budget::Error(1.0)), None);
    }

    #[test]
    fn whole_frames_count_where_there_are_some() {
        let mut slower = configuration("slower", 1.0, 0.2, 0.2);
        slower.whole = Some(Time { median: 5.0, ..Time::default() });
        let configurations = [slower, configuration("faster", 2.0, 0.2, 0.2)];
        assert_eq!(names(choose(&configurations, Metric::Rmse, Budget::Error(1.0)))[0], "faster");
    }
}
