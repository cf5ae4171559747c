//! `report`: error against run time.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::time::{Duration, Instant};

use clap::Args;
use sglow_consumers::machine::repository;
use sglow_measure::cache::Cache;
use sglow_measure::frontier::subject::Subject;
use sglow_measure::frontier::{RUNS, scene};
use sglow_renderer::device::Gpu;
use sglow_renderer::needs::Decision;
use sglow_report::docs::{deviations, frontier};
use sglow_report::failure::Result;
use sglow_report::json::Report;
use sglow_report::page::report as page;
use sglow_report::{document, failure, presets, terminal, write};
use sglow_results::densities;
use sglow_results::densities::OnDensity;
use sglow_results::frontier::document::{Pictures, SceneReport};
use sglow_results::frontier::promise::{self};
use sglow_results::picture_error::{Display, flip_map};
use sglow_scene::Scene;
use sglow_shader_gen::library::Library;

use crate::derivation::Derivation;
use crate::progress::Bars;
use crate::selection::library_folder;
use crate::shot::{self, Numbers};
use crate::{measured, saving, say};

pub(crate) mod screening;
pub(crate) mod ways;

use screening::Planned;
use sglow_report::docs::deviations::Deviation;
use sglow_report::document::Document;
use ways::Offer;

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
    #[arg(long, value_name = "WxH", default_value = "112x63", value_parser = shot::size)]
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
    ///
    /// # Errors
    ///
    /// When nothing can be kept there.
    pub(crate) fn cache(&self) -> Result<Cache> {
        let folder = self.cache.clone().unwrap_or_else(measured::folder);
        write::probe(&folder).map_err(|wrong| {
            wrong.help("results are kept there; name another folder with --cache")
        })?;
        Ok(Cache::new(&folder, self.fresh))
    }
}

/// How far from the least error, as a share of it, a way still counts as good.
const WITHIN: f64 = 0.25;

/// What must not be concluded.
const DOES_NOT_SHOW: &[&str] = &[
    "Times on a software driver compare variants and promise nothing about GPUs.",
    "One light, one bounce, one camera; pictures are small, and times of passes over pixels grow with them.",
];

/// A scene that is to be measured.
pub(crate) struct Case {
    /// The scene, with one light.
    pub(crate) scene: Scene,
    /// What it needs.
    pub(crate) derivation: Derivation,
    /// The library that it was derived by.
    pub(crate) library: Library,
}

impl Case {
    /// Loads a scene and derives what it needs.
    ///
    /// # Errors
    ///
    /// When the scene cannot be read.
    pub(crate) fn new(name: &str, size: [u32; 2], numbers: &Numbers) -> Result<Self> {
        let scene = shot::load(name, numbers.light)?;
        let library = numbers.over.library()?;
        let derivation = Derivation::new(&library, &scene, &[], &numbers.request(size))?;
        Ok(Self { scene, derivation, library })
    }
}

/// What was measured of a scene, with all that belongs to it.
struct Found {
    measured: SceneReport,
    pictures: Pictures,
    flip: BTreeMap<String, Vec<f32>>,
    facts: Vec<page::Fact>,
    decisions: Vec<page::Decision>,
    left_out: Vec<page::LeftOut>,
}

/// Measures.
///
/// # Errors
///
/// When a scene, a variant or the device does not allow it, or a promise is not kept.
pub(crate) fn run(arguments: &Arguments) -> Result {
    if arguments.schema {
        say::line(document::schema()?);
        return Ok(());
    }
    let start = Instant::now();
    let names = if arguments.scene.is_empty() {
        ["cornell", "caustic", "columns"].map(str::to_owned).to_vec()
    } else {
        arguments.scene.clone()
    };
    let over = &arguments.numbers.over;
    let library = over.library()?;
    let only = ways::only(&arguments.choice.only, &library);
    let cache = arguments.choice.cache();
    let cases: Vec<Result<Case>> =
        names.iter().map(|name| Case::new(name, arguments.size, &arguments.numbers)).collect();
    let settled = failure::both(only, failure::both(cache, write::probe(&arguments.out)));
    let ((only, (cache, ())), cases) = failure::both(settled, failure::all(cases))?;
    let package = over.whole_space()?;
    let gpu = shot::gpu(&arguments.numbers)?;
    let mut report = Report::new();
    report.adapter.clone_from(&gpu.adapter.name);
    report.driver.clone_from(&gpu.adapter.driver);
    let filters = gpu.filters_float32();
    let offer = Offer { package: &package, all: arguments.choice.all, filters };
    let mut found = Vec::new();
    for (case, planned) in cases.iter().zip(screening::plan(&gpu, &offer, &cases, &only, &cache)?) {
        found.push(measure(&gpu, &offer, case, planned, &cache)?);
    }
    for scene in &found {
        say::line(terminal::frontier::show(&scene.measured));
        promise::checks(&scene.measured).into_iter().for_each(|check| report.check(check));
    }
    let on_densities =
        sglow_measure::densities::densities(&gpu, &package, arguments.numbers.steps(), &cache)?;
    say::line(terminal::densities::show(&on_densities));
    densities::checks(&on_densities).into_iter().for_each(|check| report.check(check));
    for (solver, ratios) in densities::sampling_times(&on_densities) {
        report.detail(&format!("sampling_time_{solver}_over_previous"), ratios)?;
    }
    say::line(format!("\n{}", report.table()));
    say::line(format!(
        "{}, {}; medians of {}. {}",
        gpu.adapter.name,
        gpu.adapter.driver,
        RUNS,
        DOES_NOT_SHOW.join(" ")
    ));
    let [kept, made, outdated] = cache.counts();
    say::line(format!(
        "{made} results measured, {outdated} of them since something had changed; {kept} as before"
    ));
    let scenes: Vec<SceneReport> = found.iter().map(|one| one.measured.clone()).collect();
    let deviations = deviations::deviations(&library, &scenes)?;
    if arguments.write_docs {
        docs(&names, &report, &scenes, &deviations)?;
    }
    if arguments.presets {
        let path = library_folder().join("presets.toml");
        write::text(&path, &presets::text(&scenes, &gpu.adapter.name)?)?;
        say::line(path.display());
    }
    write(arguments, &report, &found, deviations, on_densities, start.elapsed())?;
    report.verdict()
}

/// Writes the measured tables of documents, all or none.
fn docs(
    names: &[String],
    report: &Report,
    scenes: &[SceneReport],
    deviations: &[Deviation],
) -> Result {
    // A reader of the documents has other folders for results and pages.
    let arguments: String = names.iter().map(|name| format!(" --scene {name}")).collect();
    let how = format!("cargo xtask report{arguments} --write-docs");
    let folder = repository();
    let names = ["README.md", "docs/results.md", "docs/deviations.md"];
    let paths = names.map(|name| folder.join(name));
    let read = |path: &PathBuf| std::fs::read_to_string(path);
    let [readme, results, deviating] = [read(&paths[0])?, read(&paths[1])?, read(&paths[2])?];
    let texts = [
        frontier::by_lights(&readme, names[0], scenes, &how)?,
        frontier::frontier(&results, names[1], scenes, &report.checks, &how)?,
        deviations::written(&deviating, deviations, &how)?,
    ];
    let files: Vec<_> =
        paths.iter().zip(&texts).map(|(path, text)| (path.as_path(), text.as_str())).collect();
    write::texts(&files)?;
    for path in &paths {
        say::line(format!("{}", path.display()));
    }
    Ok(())
}

/// Writes the page, the numbers and what they mean, all or none.
fn write(
    arguments: &Arguments,
    report: &Report,
    found: &[Found],
    deviations: Vec<Deviation>,
    densities: Vec<OnDensity>,
    took: Duration,
) -> Result {
    let shown: Vec<_> = found
        .iter()
        .map(|one| page::Scene {
            measured: &one.measured,
            pictures: &one.pictures,
            flip: &one.flip,
            facts: &one.facts,
            decisions: &one.decisions,
            left_out: &one.left_out,
        })
        .collect();
    let page = page::page(&page::Input {
        report,
        scenes: &shown,
        within: WITHIN,
        minutes: took.as_secs_f64() / 60.0,
        does_not_show: DOES_NOT_SHOW,
    });
    let numbers = Document {
        schema_version: document::VERSION,
        report,
        scenes: found.iter().map(|one| one.measured.clone()).collect(),
        left_out: found
            .iter()
            .map(|one| (one.measured.scene.clone(), one.left_out.clone()))
            .collect(),
        deviations,
        densities,
        does_not_show: DOES_NOT_SHOW.iter().map(|&line| line.to_owned()).collect(),
    };
    let [index, json, schema] =
        ["index.html", "report.json", "report.schema.json"].map(|name| arguments.out.join(name));
    write::texts(&[
        (&index, &page),
        (&json, &(serde_json::to_string_pretty(&numbers)? + "\n")),
        (&schema, &(document::schema()? + "\n")),
    ])?;
    say::line(format!("{}\n{}", index.display(), json.display()));
    Ok(())
}

/// Measures one scene.
fn measure(
    gpu: &Gpu,
    offer: &Offer<'_>,
    case: &Case,
    planned: Planned,
    cache: &Cache,
) -> Result<Found> {
    let Case { scene, derivation, library } = case;
    let subject = Subject::new(gpu, offer.package, scene, derivation.settings.clone());
    let bars = Bars::default();
    let measured = scene::scene(&subject, &planned.ways, &planned.close(), cache, &bars);
    bars.clear();
    let (mut measured, pictures) = measured?;
    measured.screening = planned.screening;
    let rules = measured.pruned.as_ref().map(measured::saved);
    if let Some(pruned) = &measured.pruned {
        measured::keep(cache, scene, pruned, &gpu.adapter)?;
    }
    let (purpose, _) = saving::purpose(library, derivation, &scene.name, &[], rules.as_ref())?;
    let map = |picture| flip_map(&pictures.reference, picture, measured.size, Display::Automatic);
    let flip = pictures.ways.iter().map(|(name, picture)| (name.clone(), map(picture))).collect();
    Ok(Found {
        flip,
        facts: derivation.needs.facts.iter().map(page::Fact::from).collect(),
        decisions: derivation.needs.decisions.iter().map(decision).collect(),
        left_out: page::left_out_by(&purpose),
        measured,
        pictures,
    })
}

/// A decision as the page takes it.
fn decision(decision: &Decision) -> page::Decision {
    let (what, reason) = (decision.name.to_owned(), decision.reason.clone());
    page::Decision { what, value: decision.value.clone(), reason }
}
