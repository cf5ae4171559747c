//! A rendered picture, for a terminal.

use std::time::Duration;

use sglow_results::picture_error::PictureError;

use crate::{picture_error, table};

/// The error of indirect light against a reference.
#[must_use]
pub fn error(error: &PictureError, reference: &str) -> String {
    let mut table = table::new(picture_error::HEADINGS);
    table.add_row(picture_error::cells(error));
    let pixels = error.pixels;
    format!("indirect light against {reference}, on {pixels} pixels with a surface:\n{table}")
}

/// The standard error of a reference: root mean square over pixels, and of its mean.
#[must_use]
pub fn noise(pixel: f64, mean: f64, samples: u32, reference_mean: f64) -> String {
    let percent = |value: f64| {
        // Where nothing is lit there is nothing to relate to.
        if reference_mean > 0.0 {
            format!("{:.1} %", 100.0 * value / reference_mean)
        } else {
            "no light".to_owned()
        }
    };
    format!(
        "the reference's own standard error: {pixel:.3e} root mean square ({} of the mean), from {samples} paths per pixel; \
         of its mean {mean:.3e} ({})",
        percent(pixel),
        percent(mean),
    )
}

/// The time of each pass.
#[must_use]
pub fn passes(times: &[(String, Duration)]) -> String {
    let mut table = table::new(["pass", "ms"]);
    for (pass, time) in times {
        table.add_row([pass.clone(), format!("{:.3}", time.as_secs_f64() * 1e3)]);
    }
    table.to_string()
}

/// The same in milliseconds, for JSON.
#[must_use]
pub fn milliseconds(times: &[(String, Duration)]) -> Vec<serde_json::Value> {
    let milliseconds = |(pass, time): &(String, Duration)| serde_json::json!({ "pass": pass, "milliseconds": time.as_secs_f64() * 1e3 });
    times.iter().map(milliseconds).collect()
}
