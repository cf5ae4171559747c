//! What a budget buys, for a terminal.

use sglow_results::frontier::choose::{self, Budget, Purchase};
use sglow_results::frontier::document::{Configuration, Metric};

use crate::failure::Failure;
use crate::{picture_error, table};

/// What comes first and next.
#[must_use]
pub fn show(order: &[&Configuration], metric: Metric, purchase: &Purchase, runs: usize) -> String {
    let [relative_mse, rmse, median, q95, flip, bias] = picture_error::HEADINGS;
    let header = ["", "configuration", "ms", relative_mse, rmse, median, q95, flip, bias];
    let mut table = table::new(header);
    for (place, configuration) in order.iter().enumerate() {
        let time = choose::time(configuration);
        let [relative_mse, rmse, median, q95, flip, bias] =
            picture_error::cells(&configuration.picture);
        table.add_row([
            if place == 0 { "chosen".to_owned() } else { format!("{}", place + 1) },
            configuration.name.clone(),
            format!("{:.2} ({:.2}-{:.2})", time.median, time.minimum, time.maximum),
            relative_mse,
            rmse,
            median,
            q95,
            flip,
            bias,
        ]);
    }
    let below = order
        .first()
        .is_some_and(|configuration| configuration.picture.measured(metric).below_noise());
    format!(
        "{table}\n{} configurations measured; medians of {runs} whole frames in turns, {}; noise of the reference: {}{}",
        purchase.configurations.len(),
        purchase.clock,
        picture_error::text(
            purchase.reference.noise_over_mean,
            Metric::Rmse,
            purchase.reference.dark
        ),
        if below { "; the chosen error is below its noise" } else { "" },
    )
}

/// By how much the runner-up lost.
#[must_use]
pub fn margin(
    winner: &Configuration,
    runner_up: &Configuration,
    metric: Metric,
    budget: Budget,
) -> String {
    let (ours, theirs) = (choose::time(winner), choose::time(runner_up));
    let (right, wrong) = (winner.picture.of(metric), runner_up.picture.of(metric));
    let name = &runner_up.name;
    match budget {
        Budget::Error(_) => {
            let slower = theirs.median - ours.median;
            let within =
                if theirs.minimum <= ours.maximum { ", which is within the spread" } else { "" };
            format!(
                "Runner-up: {name}, slower by {slower:.2} ms ({:.1} %{within}), with an error of {} against {}.",
                100.0 * slower / ours.median,
                error(wrong, metric),
                error(right, metric)
            )
        }
        Budget::Milliseconds(_) => {
            let times = format!("in {:.2} ms against {:.2}", theirs.median, ours.median);
            let (theirs, ours) = (error(wrong, metric), error(right, metric));
            if theirs == ours {
                return format!("Runner-up: {name}, with the same error ({ours}), {times}.");
            }
            format!(
                "Runner-up: {name}, with {} more error, {theirs} against {ours}, {times}.",
                error(wrong - right, metric)
            )
        }
    }
}

/// An error as the table shows it.
fn error(value: f64, metric: Metric) -> String {
    picture_error::text(value, metric, false)
}

/// Why nothing was chosen.
#[must_use]
pub fn nothing(purchase: &Purchase, metric: Metric, budget: Budget) -> Failure {
    let Some(choose::Bought::Nothing { nearest, by }) =
        choose::choose(&purchase.configurations, metric, budget)
    else {
        return Failure::new("nothing was measured");
    };
    match budget {
        Budget::Error(most) => Failure::new(format!(
            "no configuration meets the error budget of {}; {} comes nearest, with {}: {} too much, in {:.2} ms",
            error(most, metric),
            nearest.name,
            error(nearest.picture.of(metric), metric),
            error(by, metric),
            choose::time(nearest).median
        )),
        Budget::Milliseconds(most) => Failure::new(format!(
            "no configuration takes at most {most} ms; {} comes nearest, with {:.2} ms: {by:.2} ms too long, with an error of {}",
            nearest.name,
            choose::time(nearest).median,
            error(nearest.picture.of(metric), metric)
        )),
    }
    .help(match budget {
        Budget::Error(_) => "more lights (--lights) reduce the error; --all tries every legal configuration",
        Budget::Milliseconds(_) => {
            "fewer lights (--lights), a smaller map (--rsm) or a smaller picture (--size) take less time; --all tries every legal configuration"
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_are_shown_as_the_table_has_them() {
        assert_eq!(error(0.25, Metric::Rmse), "25.0 %");
        assert_eq!(error(0.25, Metric::Flip), "0.250");
    }
}
