//! What a reproduction found, for a terminal.

use sglow_results::reproduction::Findings;

use crate::table;

/// Tables for a terminal.
#[must_use]
pub fn show(found: &Findings) -> String {
    let mut lines = Vec::new();
    for times in &found.times {
        let mut table = table::new(["method", "map", "stage", "ms", "spread", "dispatches"]);
        for one in &times.methods {
            for stage in &one.stages {
                table.add_row([
                    one.method.name().to_owned(),
                    if stage.camera { "camera" } else { "light" }.to_owned(),
                    stage.name.to_owned(),
                    format!("{:.3}", stage.time.median),
                    format!("{:.3}-{:.3}", stage.time.minimum, stage.time.maximum),
                    stage.dispatches.to_string(),
                ]);
            }
            let total = format!("{:.3}", one.total(None));
            table.add_row([one.method.name(), "both", "total", &total, "", ""]);
        }
        lines
            .push(format!("\n{}: {}, density {}\n{table}", times.name, times.scene, times.density));
    }
    for surveyed in &found.surveys {
        let mut table = table::new([
            "method",
            "K",
            "gaps",
            "by weights",
            "sharing",
            "relMSE",
            "RMSE",
            "median",
            "bias",
            "floor",
        ]);
        for row in &surveyed.found.rows {
            table.add_row([
                row.method.name().to_owned(),
                row.size_factor.to_string(),
                format!("{:.3}", row.overlap.gaps),
                format!("{:.3}", row.weighted.gaps),
                format!("{:.2}", row.weighted.sharing),
                format!("{:.4}", row.relative_mse),
                format!("{:.3}", row.error),
                format!("{:.3}", row.median),
                format!("{:+.3}", row.bias),
                row.floor.map_or_else(String::new, |floor| format!("{:.4}", floor.relative_mse)),
            ]);
        }
        lines.push(format!("\n{}, density {}\n{table}", surveyed.scene, surveyed.density));
    }
    for (scene, flickers) in &found.flickers {
        let mut table = table::new(["method", "error", "flicker", "worst", "own change"]);
        for one in &flickers.contenders {
            table.add_row([
                one.name.clone(),
                format!("{:.3}", one.error),
                format!("{:.4}", one.flicker),
                format!("{:.4}", one.worst),
                format!("{:.4}", one.change),
            ]);
        }
        lines.push(format!(
            "\n{scene}: {} frames of a moving light; the reference's own change {:.4}\n{table}",
            flickers.walk.frames, flickers.reference_change
        ));
    }
    let mut table = table::new(["number", "measured", "bound", "met"]);
    for one in &found.requested {
        table.add_row([
            one.name.clone(),
            format!("{:.3}", one.value),
            format!("{} {}", one.relation.sign(), one.bound),
            if one.met { "yes" } else { "NO" }.to_owned(),
        ]);
    }
    if !found.requested.is_empty() {
        lines.push(format!("\n{table}"));
    }
    lines.join("\n")
}
