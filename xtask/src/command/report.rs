//! `report`: error against run time.

use std::path::PathBuf;
use std::time::Instant;

use clap::Args;
use sglow_consumers::cost;
use sglow_consumers::machine::{library_folder, repository};
use sglow_measure::cache::Cache;
use sglow_measure::frontier::case::Case;
use sglow_measure::frontier::found::measure;
use sglow_measure::frontier::offer::{self, Offer};
use sglow_measure::frontier::{RUNS, screening};
use sglow_report::docs::deviations;
use sglow_report::document::{self, Document};
use sglow_report::failure::{self, Failure, Result};
use sglow_report::json::Report;
use sglow_report::page::report as page;
use sglow_report::{docs, parse, presets, terminal, write};
use sglow_results::densities;
use sglow_results::frontier::document::SceneReport;
use sglow_results::frontier::promise;
use sglow_runtime::settings::Settings;

use crate::options::{Numbers, saved_folder};
use crate::progress::Bars;
use crate::{say, scene};

/// What `--help` shows below the options.
pub(crate) const EXAMPLES: &str = "\
Examples:
  cargo xtask report
  cargo xtask report --scene cornell --scene caustic
  cargo xtask report --scene columns --size 240x135 --only kernel=modified --only visibility=none
  cargo xtask report --scene cornell --scene columns --preset tokuyoshi2016
  cargo xtask report --scene cornell --all --only density=power --only visibility=none --only draw=warped
  cargo xtask report --scene cornell --scene columns --scene atrium --presets --write-docs

Configurations are screened: the default of each scene with each other value of one axis at a time, then what is on the
frontier of its axis by relative MSE crossed, on all scenes alike. Of each its time is measured, pass by pass,
and its error, which is three numbers: what is seen against the reference, the device against the oracle, the oracle
against the sum over all facets. The picture is compared by relative MSE, RMSE, median and 95 % quantile of the relative
error, bias and FLIP; the page shows the frontier by the metric that its reader picks, and where metrics disagree.

What is measured is kept (target/measured): a run that was interrupted goes on where it was, and a run in which nothing
has changed measures nothing.";

/// Options of `report`.
#[derive(Debug, Args)]
pub(crate) struct Arguments {
    /// A built-in scene, or a file: .gltf, .glb, .obj; may be given more than once [default: cornell, caustic, columns]
    #[arg(long, value_name = "FILE|NAME")]
    scene: Vec<String>,
    /// Pixels of the pictures that are compared
    #[arg(long, value_name = "WxH", default_value = "112x63", value_parser = parse::size)]
    size: [u32; 2],
    /// The folder that receives index.html and report.json
    #[arg(long, value_name = "DIR", default_value = "out/report")]
    out: PathBuf,
    /// Also write the presets fast, balanced and accurate to shaders/presets.toml
    #[arg(long, conflicts_with_all = ["all", "library"])]
    presets: bool,
    /// Also write the tables of README.md, docs/results.md and docs/deviations.md
    #[arg(long, conflicts_with_all = ["all", "library"])]
    write_docs: bool,
    /// Print the JSON schema of report.json, and measure nothing
    #[arg(long)]
    schema: bool,
    #[command(flatten)]
    choice: Choice,
    #[command(flatten)]
    numbers: Numbers,
}

/// Options that `report` and `choose` share.
#[derive(Debug, Args)]
pub(crate) struct Choice {
    /// Measure only configurations with these values; an axis or a parameter may be given more than once
    #[arg(long, value_name = "AXIS=VALUE", value_delimiter = ',')]
    pub(crate) only: Vec<String>,
    /// Every legal combination, not only what screening leaves; best narrowed by --only
    #[arg(long)]
    pub(crate) all: bool,
    /// Measure everything again
    #[arg(long)]
    fresh: bool,
    /// The folder that keeps what was measured [default: target/measured]
    #[arg(long, value_name = "DIR")]
    cache: Option<PathBuf>,
}

impl Choice {
    /// What was measured before.
    pub(crate) fn cache(&self) -> Result<Cache> {
        let folder = self.cache.clone().unwrap_or_else(saved_folder);
        write::probe(&folder).map_err(|wrong| {
            wrong.help("results are kept there; name another folder with --cache")
        })?;
        Ok(Cache::new(&folder, self.fresh))
    }
}

/// How far from the minimum error, as a share of it, a configuration still counts as good.
const WITHIN: f64 = 0.25;

/// What must not be concluded.
const DOES_NOT_SHOW: &[&str] = &[
    "Times on a software driver compare variants and do not predict those of GPUs.",
    "One bounce, one camera; pictures are small, and times of passes over pixels grow with them.",
];

/// Loads a scene and derives what it needs.
pub(crate) fn case(name: &str, size: [u32; 2], numbers: &Numbers) -> Result<Case> {
    let scene = numbers.reading.load(name, numbers.light)?;
    Ok(Case::new(scene, numbers.over.library()?, &numbers.request(size))?)
}

/// Measures.
pub(crate) fn run(arguments: &Arguments) -> Result {
    if arguments.schema {
        say::line(document::schema()?);
        return Ok(());
    }
    let start = Instant::now();
    let Arguments { choice, numbers, .. } = arguments;
    let names = if arguments.scene.is_empty() {
        ["cornell", "caustic", "columns"].map(str::to_owned).to_vec()
    } else {
        arguments.scene.clone()
    };
    let library = numbers.over.library()?;
    let only = offer::only(&choice.only, &library).map_err(Failure::from);
    let cases: Vec<Result<Case>> =
        names.iter().map(|name| case(name, arguments.size, numbers)).collect();
    let settled = failure::both(only, failure::both(choice.cache(), write::probe(&arguments.out)));
    let ((only, (cache, ())), cases) = failure::both(settled, failure::all(cases))?;
    let package = numbers.over.whole_space()?;
    let gpu = numbers.gpu()?;
    let mut report = Report::on(&gpu.adapter.name, &gpu.adapter.driver);
    let offer = Offer { package: &package, all: choice.all, filters: gpu.filters_float32() };
    let bars = Bars::default();
    let planned = screening::plan(&gpu, &offer, &cases, &only, &cache, &bars)?;
    let mut found = Vec::new();
    for (case, planned) in cases.iter().zip(planned) {
        found.push(measure(&gpu, &offer, case, planned, &cache, &bars)?);
    }
    let scenes: Vec<SceneReport> = found.iter().map(|one| one.measured.clone()).collect();
    for scene in &scenes {
        say::line(terminal::frontier::show(scene));
        report.checks(promise::checks(scene));
    }
    let steps = numbers.iterations.unwrap_or_else(|| Settings::default().iterations);
    let on_densities = sglow_measure::densities::densities(&gpu, &package, steps, &cache)?;
    say::line(terminal::densities::show(&on_densities));
    report.checks(densities::checks(&on_densities));
    for (solver, ratios) in densities::sampling_times(&on_densities) {
        report.detail(&format!("sampling_time_{solver}_over_previous"), ratios)?;
    }
    let [kept, made, outdated] = cache.counts();
    say::line(format!(
        "\n{}\n{}, {}; medians of {RUNS}. {}\n{made} results measured, {outdated} of them since something had changed; \
         {kept} as before",
        report.table(),
        gpu.adapter.name,
        gpu.adapter.driver,
        DOES_NOT_SHOW.join(" ")
    ));
    let deviations = deviations::deviations(&library, &scenes)?;
    if arguments.write_docs {
        let paths = docs::write(
            &repository(),
            &names,
            &report.checks,
            &scenes,
            &deviations,
            &on_densities,
        )?;
        paths.iter().for_each(|path| say::line(path.display()));
    }
    if arguments.presets {
        let path = library_folder().join("presets.toml");
        write::text(&path, &presets::text(&scenes, &gpu.adapter.name)?)?;
        say::line(path.display());
    }
    let known: Vec<_> = cases
        .iter()
        .zip(&found)
        .map(|(case, found)| {
            let needs = &case.derivation.needs;
            (scene::facts(needs), scene::decisions(needs), page::left_out_by(&found.purpose))
        })
        .collect();
    let shown: Vec<_> = found
        .iter()
        .zip(&known)
        .map(|(one, (facts, decisions, left_out))| page::Scene {
            measured: &one.measured,
            pictures: &one.pictures,
            flip: &one.flip,
            facts,
            decisions,
            left_out,
        })
        .collect();
    let static_costs = cost::committed(&scenes)?;
    let page = page::page(&page::Input {
        report: &report,
        scenes: &shown,
        within: WITHIN,
        minutes: start.elapsed().as_secs_f64() / 60.0,
        does_not_show: DOES_NOT_SHOW,
        static_costs: &static_costs,
    });
    let left_out =
        scenes.iter().zip(&known).map(|(one, known)| (one.scene.clone(), known.2.clone()));
    let document = Document {
        schema_version: document::VERSION,
        report: &report,
        left_out: left_out.collect(),
        scenes: scenes.clone(),
        deviations,
        densities: on_densities,
        static_costs,
        does_not_show: DOES_NOT_SHOW.iter().map(|&line| line.to_owned()).collect(),
    };
    document.write(&arguments.out, &page)?.iter().for_each(|path| say::line(path.display()));
    report.verdict()
}
