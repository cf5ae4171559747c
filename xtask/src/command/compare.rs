//! `compare`: two pictures by every metric.

use std::path::PathBuf;

use clap::Args;
use sglow_report::compare::{Files, draw, load};
use sglow_report::failure::Result;
use sglow_report::json::Report;
use sglow_report::{parse, terminal, write};
use sglow_results::check::{Check, Relation};
use sglow_results::picture_error::{Metric, compare};

use crate::say;

/// What `--help` shows below the options.
pub(crate) const EXAMPLES: &str = "\
Examples:
  cargo xtask compare out/ours.exr out/ours.reference.exr --out out/compared
  cargo xtask compare out/ours.exr out/ours.reference.1.exr --half out/ours.reference.2.exr
  cargo xtask compare out/ours.exr mitsuba.exr --layer radiance --metric median --metric q95
  cargo xtask compare out/one.png out/other.png --metric rmse --at-most 5%

A is tested, B is its reference. Pictures are OpenEXR with layers by name, Radiance HDR or PNG; PNG is converted from
sRGB to linear light. Without --layer, files that `render` wrote are compared by their indirect light, others by the one
layer that they have. The sums `indirect` and `radiance` are layers too.

Metrics are over pixels that show a surface, where a file marks them (layer normal, or alpha), else over all:
  relative_mse  mean of (A - B)^2 / (B^2 + 1e-2 mean(B^2))
  rmse          root mean square of A - B over the mean of B
  median, q95   50 and 95 % quantiles of the luminance of |A - B| over that of B plus 1e-2 times its mean
  flip          mean of the FLIP map of the whole pictures, with one exposure; a PNG is shown as it is
  bias          mean of A over mean of B, minus 1

A reference with noise is best given as two independent halves: squared errors are then free of its noise, and every
error has an uncertainty. Without --half B counts as exact, and its noise as error of A.";

/// Options of `compare`.
#[derive(Debug, Args)]
pub(crate) struct Arguments {
    /// The picture that is tested: .exr, .hdr, .png
    #[arg(value_name = "A")]
    tested: PathBuf,
    /// Its reference
    #[arg(value_name = "B")]
    reference: PathBuf,
    /// B and this picture are independent halves of the reference
    #[arg(long, value_name = "FILE")]
    half: Option<PathBuf>,
    /// Show this metric alone: relative_mse, rmse, median, q95, flip, bias; may be given more than once
    #[arg(long, value_name = "METRIC")]
    metric: Vec<Metric>,
    /// Fail unless each shown metric is at most this: a number, or a percentage
    #[arg(long, value_name = "E", value_parser = parse::share, requires = "metric")]
    at_most: Option<f64>,
    /// The layer that is compared
    #[arg(long, value_name = "NAME")]
    layer: Option<String>,
    /// The folder that receives compare.json, and the relative error and FLIP of every pixel in false colour
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

/// Compares.
pub(crate) fn run(arguments: &Arguments) -> Result {
    if let Some(out) = &arguments.out {
        write::probe(out)?;
    }
    let loaded = load(&Files {
        tested: &arguments.tested,
        reference: &arguments.reference,
        half: arguments.half.as_deref(),
        layer: arguments.layer.as_deref(),
    })?;
    loaded.notes.iter().for_each(say::line);
    let error = loaded.with(compare);
    let mut report = Report::new();
    say::line(terminal::compare::show(&arguments.tested, &loaded, &error, &arguments.metric));
    if let Some(most) = arguments.at_most {
        for &metric in &arguments.metric {
            let unit = if metric.is_share() { "of the mean" } else { "" };
            report.check(Check::new(
                metric.title(),
                error.of(metric),
                unit,
                Relation::AtMost,
                most,
            ));
        }
    }
    report.detail("tested", &arguments.tested)?;
    report.detail("reference", &arguments.reference)?;
    report.detail("half", &arguments.half)?;
    report.detail("layer", &loaded.layer)?;
    report.detail("size", loaded.size())?;
    report.detail("pixels", loaded.present.as_ref().map_or("all", |present| present.1))?;
    report.detail("error", error)?;
    if let Some(out) = &arguments.out {
        draw(out, &loaded, &error)?.iter().for_each(say::line);
        let path = out.join("compare.json");
        report.write(&path)?;
        say::line(format!("{}", path.display()));
    }
    if report.checks.is_empty() { Ok(()) } else { report.verdict() }
}

#[cfg(test)]
mod tests {
    use clap::Parser;

    use super::*;

    #[derive(Debug, Parser)]
    struct Line {
        #[command(flatten)]
        arguments: Arguments,
    }

    #[test]
    fn numbers_and_pictures_are_written_and_a_bound_fails() {
        let folder = tempfile::tempdir().unwrap();
        let picture = |name: &str, light: [f32; 2]| {
            let path = folder.path().join(name);
            let grey = image::Rgb32FImage::from_fn(2, 1, |x, _| image::Rgb([light[x as usize]; 3]));
            grey.save(&path).unwrap();
            path.to_string_lossy().into_owned()
        };
        let (tested, reference) = (picture("a.hdr", [1.0, 3.0]), picture("b.hdr", [2.0, 2.0]));
        let out = folder.path().join("out");
        let compared = |more: &[&str]| {
            let place = out.to_string_lossy();
            let words = ["compare", &tested, &reference, "--out", &place];
            run(&Line::try_parse_from(words.iter().chain(more)).unwrap().arguments)
        };
        compared(&[]).unwrap();
        let json = std::fs::read(out.join("compare.json")).unwrap();
        let json: serde_json::Value = serde_json::from_slice(&json).unwrap();
        assert_eq!(json["error"]["rmse_over_mean"], 0.5);
        for name in ["difference.png", "flip.png"] {
            assert_eq!(image::open(out.join(name)).unwrap().width(), 2);
        }
        compared(&["--metric", "rmse", "--at-most", "50%"]).unwrap();
        let fails = compared(&["--metric", "rmse", "--at-most", "0.49"]).unwrap_err();
        assert!(fails.to_string().contains("RMSE over the mean"));
    }
}
