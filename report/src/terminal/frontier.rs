//! The frontier of a scene, for a terminal.

use sglow_results::frontier::document::{Metric, SceneReport};

use crate::{picture_error, table};

/// The frontier as a table.
#[must_use]
pub fn show(scene: &SceneReport) -> String {
    let [width, height] = scene.size;
    let head = format!(
        "\n{}: {} triangles, {width} x {height}, map of {} squared, {} lights, {}; reference of paths, its noise {}",
        scene.scene,
        scene.triangles,
        scene.rsm_size,
        scene.lights,
        scene.clock,
        percent(scene.reference.noise_over_mean),
    );
    let [relative_mse, rmse, median, q95, flip, bias] = picture_error::HEADINGS;
    let header =
        ["frontier, and default", "ms", relative_mse, rmse, median, q95, flip, bias, "flicker"];
    let mut table = table::new(header);
    let metric = Metric::default();
    for configuration in scene
        .configurations
        .iter()
        .filter(|configuration| configuration.on_frontier(metric) || configuration.default)
    {
        let time = configuration.whole.unwrap_or(configuration.time);
        let dark = scene.reference.dark;
        let flicker =
            configuration.flicker.map(|flicker| picture_error::text(flicker, Metric::Rmse, dark));
        let [relative_mse, rmse, median, q95, flip, bias] =
            picture_error::cells(&configuration.picture);
        table.add_row([
            format!(
                "{}{}",
                configuration.name,
                if configuration.on_frontier(metric) { "" } else { " (dominated)" }
            ),
            format!("{:.1} ({:.1}-{:.1})", time.median, time.minimum, time.maximum),
            relative_mse,
            rmse,
            median,
            q95,
            flip,
            bias,
            flicker.unwrap_or_else(|| "–".to_owned()),
        ]);
    }
    let counts = Metric::ALL.map(|metric| {
        let count = scene
            .configurations
            .iter()
            .filter(|configuration| configuration.on_frontier(metric))
            .count();
        format!("{count} {}", metric.name())
    });
    format!(
        "{head}\n{table}\n{} configurations; on the frontier by each metric: {}",
        scene.configurations.len(),
        counts.join(", ")
    )
}

/// A share as a person reads it.
fn percent(share: f64) -> String {
    format!("{:.2} %", 100.0 * share)
}
