//! `report`: error against run time.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::time::{Duration, Instant};

use clap::Args;
use sglow_measure::cache::Cache;
use sglow_measure::frontier::document::{Pictures, SceneReport};
use sglow_measure::frontier::subject::Subject;
use sglow_measure::frontier::{judge, scene};
use sglow_runtime::device::Gpu;
use sglow_runtime::package::Package;

use crate::failure::{Failure, Result};
use crate::json::{Check, Relation, Report};
use crate::machine::target_folder;
use crate::page::report as page;
use crate::progress::Bars;
use crate::say;
use crate::shot::{self, Numbers, Shot};
use crate::table;
use crate::write;

mod densities;
mod ways;

/// What `--help` shows below the options.
pub(crate) const EXAMPLES: &str = "\
Examples:
  cargo xtask report
  cargo xtask report --scene cornell --scene caustic
  cargo xtask report --scene columns --size 240x135 --only kernel=modified --only visibility=none
  cargo xtask report --scene cornell --all --only density=power --only visibility=none --only draw=warped

For each scene, every way to its indirect light that the committed variants allow is measured: its time, pass by pass,
and its error, which is three numbers: what is seen against the reference, the device against the oracle, the oracle
against the sum over all points. The page says which way no other beats, and what beats the others.

What is measured is kept (target/measured): a run that was interrupted goes on where it was, and a run in which nothing
has changed measures nothing.";

/// Options of `report`.
#[derive(Debug, Args)]
pub(crate) struct Arguments {
    /// A built-in scene, or a file: .gltf, .glb, .obj; may be given more than once [default: cornell, caustic, columns]
    #[arg(long, value_name = "FILE|NAME")]
    scene: Vec<String>,
    /// Pixels of the pictures that are compared
    #[arg(long, value_name = "WxH", default_value = "160x90", value_parser = shot::size)]
    size: [u32; 2],
    /// The folder that receives index.html and report.json
    #[arg(long, value_name = "DIR", default_value = "out/report")]
    out: PathBuf,
    #[command(flatten)]
    choice: Choice,
    #[command(flatten)]
    numbers: Numbers,
}

/// Options that `report` and `choose` share.
#[derive(Debug, Args)]
pub(crate) struct Choice {
    /// Measure only ways with these values; an axis may be given more than once
    #[arg(long, value_name = "AXIS=VALUE", value_delimiter = ',')]
    only: Vec<String>,
    /// Every legal variant, not only those that are committed; best narrowed by --only
    #[arg(long)]
    all: bool,
    /// Measure everything again
    #[arg(long)]
    fresh: bool,
    /// The folder that keeps what was measured [default: target/measured]
    #[arg(long, value_name = "DIR")]
    cache: Option<PathBuf>,
}

impl Choice {
    /// What was measured before.
    pub(crate) fn cache(&self) -> Cache {
        let folder = self.cache.clone().unwrap_or_else(|| target_folder().join("measured"));
        Cache::new(&folder, self.fresh)
    }
}

/// How far from the least error, as a share of it, a way still counts as good.
const WITHIN: f64 = 0.05;

/// What must not be concluded.
const DOES_NOT_SHOW: &[&str] = &[
    "Times on a software driver compare variants and promise nothing about GPUs.",
    "One light, one bounce, one camera; pictures are small, and times of passes over pixels grow with them.",
];

/// Measures.
///
/// # Errors
///
/// When a scene, a variant or the device does not allow it, or a promise is not kept.
pub(crate) fn run(arguments: &Arguments) -> Result {
    let start = Instant::now();
    let only = ways::only(&arguments.choice.only)?;
    let names = if arguments.scene.is_empty() {
        ["cornell", "caustic", "columns"].map(str::to_owned).to_vec()
    } else {
        arguments.scene.clone()
    };
    let shots = names
        .iter()
        .map(|scene| Shot::new(scene, &[], arguments.size, &arguments.numbers))
        .collect::<Result<Vec<_>>>()?;
    let package = ways::package(arguments.choice.all)?;
    let gpu = shot::gpu(&arguments.numbers)?;
    let cache = arguments.choice.cache();
    let mut report = Report::new();
    report.adapter.clone_from(&gpu.adapter.name);
    report.driver.clone_from(&gpu.adapter.driver);
    let mut scenes = Vec::new();
    for shot in &shots {
        scenes.push(measure(&gpu, &package, shot, &only, &cache)?);
    }
    for (scene, _) in &scenes {
        show(scene);
        check(scene, &mut report);
    }
    let densities = densities::stress(&gpu, &package, &arguments.numbers, &cache, &mut report)?;
    report.detail("densities", densities)?;
    report.detail("scenes", scenes.iter().map(|one| &one.0).collect::<Vec<_>>())?;
    report.detail("does_not_show", DOES_NOT_SHOW)?;
    say::line(format!("\n{}", report.table()));
    say::line(format!(
        "{}, {}; medians of {}. {}",
        gpu.adapter.name,
        gpu.adapter.driver,
        scene::RUNS,
        DOES_NOT_SHOW.join(" ")
    ));
    let [found, made, outdated] = cache.counts();
    say::line(format!("{made} results measured, {found} as before, {outdated} of them outdated"));
    write(arguments, &report, &scenes, start.elapsed())?;
    report.verdict()
}

/// Writes the page, the numbers and what they mean, all or none.
fn write(
    arguments: &Arguments,
    report: &Report,
    scenes: &[(SceneReport, Pictures)],
    took: Duration,
) -> Result {
    let flip = |(scene, pictures): &(SceneReport, Pictures)| -> BTreeMap<String, Vec<f32>> {
        let map = |picture| judge::flip_map(&pictures.reference, picture, scene.size);
        pictures.ways.iter().map(|(name, picture)| (name.clone(), map(picture))).collect()
    };
    let flips: Vec<_> = scenes.iter().map(flip).collect();
    let shown: Vec<_> = scenes
        .iter()
        .zip(&flips)
        .map(|((measured, pictures), flip)| page::Scene {
            measured,
            pictures,
            flip,
            facts: &[],
            decisions: &[],
            left_out: &[],
        })
        .collect();
    let page = page::page(&page::Input {
        report,
        scenes: &shown,
        within: WITHIN,
        minutes: took.as_secs_f64() / 60.0,
        does_not_show: DOES_NOT_SHOW,
    });
    let [index, json] = ["index.html", "report.json"].map(|name| arguments.out.join(name));
    let numbers = serde_json::to_string_pretty(report)? + "\n";
    write::texts(&[(&index, &page), (&json, &numbers)])?;
    say::line(format!("{}\n{}", index.display(), json.display()));
    Ok(())
}

/// Measures one scene.
pub(crate) fn measure(
    gpu: &Gpu,
    package: &Package,
    shot: &Shot,
    only: &sglow_measure::frontier::way::Allowed,
    cache: &Cache,
) -> Result<(SceneReport, Pictures)> {
    let ways = ways::of(gpu, package, shot, only)?;
    let subject = Subject::new(gpu, package, &shot.scene, shot.settings.clone());
    let bars = Bars::default();
    let measured = scene::scene(&subject, &ways, cache, &bars);
    bars.clear();
    measured.map_err(Failure::from)
}

/// The frontier as a table.
fn show(scene: &SceneReport) {
    let [width, height] = scene.size;
    say::line(format!(
        "\n{}: {} triangles, {width} x {height}, map of {} squared, {} lights, {}; reference {:?}, itself off by {}",
        scene.scene,
        scene.triangles,
        scene.rsm_size,
        scene.lights,
        scene.clock,
        scene.reference.kind,
        percent(scene.reference.floor_over_mean),
    ));
    let mut table = table::new([
        "frontier, and default",
        "ms",
        "RMSE",
        "FLIP",
        "bias",
        "model",
        "rounding",
        "flicker",
    ]);
    for way in scene.ways.iter().filter(|way| way.frontier || way.default) {
        let maybe = |value: Option<f64>| value.map_or_else(|| "–".to_owned(), percent);
        let time = way.whole.unwrap_or(way.time);
        table.add_row([
            format!("{}{}", way.name, if way.frontier { "" } else { " (beaten)" }),
            format!("{:.1} ({:.1}-{:.1})", time.median, time.least, time.most),
            percent(way.picture.rmse_over_mean),
            format!("{:.3}", way.picture.flip),
            percent(way.picture.bias),
            maybe(way.model_rms_over_mean),
            way.rounding
                .as_ref()
                .map_or_else(|| "–".to_owned(), |one| format!("{:.1e}", one.rms_over_mean)),
            maybe(way.flicker),
        ]);
    }
    say::line(format!(
        "{table}\n{} ways, {} on the frontier",
        scene.ways.len(),
        scene.ways.iter().filter(|way| way.frontier).count()
    ));
}

/// What is promised of a scene.
fn check(scene: &SceneReport, report: &mut Report) {
    let name = &scene.scene;
    report.check(Check::new(
        format!("{name}: numbers that are not finite, in all variants"),
        scene.not_finite as f64,
        "numbers",
        Relation::Equal,
        0.0,
    ));
}

/// A share as a person reads it.
fn percent(share: f64) -> String {
    format!("{:.2} %", 100.0 * share)
}
