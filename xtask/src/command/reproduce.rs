//! `reproduce`: the tables and figures of the papers, ours beside theirs.

use std::path::PathBuf;

use clap::Args;
use sglow_consumers::machine::repository;
use sglow_measure::reproduce::{Found, Options, Work};
use sglow_renderer::request::derivation::Request;
use sglow_report::failure::{Failure, Result};
use sglow_report::json::Report;
use sglow_report::page::reproduce as page;
use sglow_report::picture::reproduction;
use sglow_report::{docs, parse, terminal, write};
use sglow_results::frontier::promise::named::PRINTED;
use sglow_results::reproduction::{DOES_NOT_SHOW, checks};

use crate::options::Numbers;
use crate::progress::Bars;
use crate::say;

/// What `--help` shows below the options.
pub(crate) const EXAMPLES: &str = "\
Examples:
  cargo xtask reproduce --out out/reproduce
  cargo xtask reproduce --scene chair.gltf --size 160x90 --samples 128 --out out/chair

Without --scene: Tables 1 to 3 and Figs. 1, 5, 6, 7 and 8 of Tokuyoshi 2016 on the built-in scenes, beside the paper's
own numbers. All forms are those of the preset tokuyoshi2016 (--preset takes another). With --scene: the same methods on those scenes. Everything also stands in reproduce.json. A whole run
takes about ten minutes on two cores with cargo run --release --package xtask -- reproduce.";

/// Options of `reproduce`.
#[derive(Debug, Args)]
pub(crate) struct Arguments {
    /// Scenes to show the methods on instead: built-in names or files
    #[arg(long, value_name = "FILE|NAME")]
    scene: Vec<String>,
    /// Pixels of the pictures
    #[arg(long, value_name = "WxH", default_value = "240x136", value_parser = parse::size)]
    size: [u32; 2],
    /// Pixels of the camera's map whose stages are timed; the paper's are the default
    #[arg(long, value_name = "WxH", default_value = "1920x1088", value_parser = parse::size)]
    timed_size: [u32; 2],
    /// Paths per pixel of the reference, half of them in each of two independent halves
    #[arg(long, value_name = "N", default_value_t = 256, value_parser = clap::value_parser!(u32).range(4..))]
    samples: u32,
    /// Frames of the moving light
    #[arg(long, value_name = "N", default_value_t = 17, value_parser = clap::value_parser!(u32).range(2..))]
    frames: u32,
    /// Virtual lights of the camera
    #[arg(long, value_name = "N", default_value_t = 2048)]
    camera_lights: u32,
    /// The folder to write: index.html, reproduce.json, pictures
    #[arg(long, value_name = "DIR", default_value = "out/reproduce")]
    out: PathBuf,
    /// Also write the table of docs/results.md
    #[arg(long, conflicts_with = "scene")]
    write_docs: bool,
    #[command(flatten)]
    numbers: Numbers,
}

/// Reproduces.
pub(crate) fn run(arguments: &Arguments) -> Result {
    let numbers = &arguments.numbers;
    let library = numbers.over.library()?;
    let package = numbers.over.whole_space()?;
    let gpu = numbers.gpu()?;
    std::fs::create_dir_all(&arguments.out)
        .map_err(|error| Failure::new(format!("{}: {error}", arguments.out.display())))?;
    let preset = numbers.preset.clone().or_else(|| Some(PRINTED.to_owned()));
    let options = Options {
        size: arguments.size,
        timed_size: arguments.timed_size,
        samples: arguments.samples,
        frames: arguments.frames as usize,
        camera_lights: arguments.camera_lights,
        map: numbers.rsm.unwrap_or(512),
        light: numbers.light,
        reading: numbers.reading.options(),
        request: Request { preset, ..numbers.request(arguments.size) },
    };
    let bars = Bars::default();
    let (library, package, options) = (&library, &package, &options);
    let work = Work { options, library, package, gpu: &gpu, progress: &bars };
    let mut found = Found::default();
    if arguments.scene.is_empty() {
        work.built_in(&mut found)?;
    } else {
        for scene in &arguments.scene {
            work.one_scene(scene, &mut found)?;
        }
    }
    let Found { findings: found, drawings } = found;
    reproduction::write(&arguments.out, &drawings)?;
    let mut report = Report::on(&gpu.adapter.name, &gpu.adapter.driver);
    report.checks(checks(&found));
    report.detail("requested", &found.requested)?;
    report.detail("times", &found.times)?;
    report.detail("code", &found.code)?;
    report.detail("sampling_over_previous", &found.sampling)?;
    report.detail("mips", &found.mips)?;
    report.detail("surveys", &found.surveys)?;
    report.detail("flicker", &found.flickers)?;
    report.detail("figures", &found.figures)?;
    report.detail("does_not_show", DOES_NOT_SHOW)?;
    say::line(terminal::reproduce::show(&found));
    say::line(format!("\n{}", report.table()));
    write::text(&arguments.out.join("index.html"), &page::page(&found, &report))?;
    let path = arguments.out.join("reproduce.json");
    report.write(&path)?;
    say::line(format!("{}\n{}", path.display(), arguments.out.join("index.html").display()));
    if arguments.write_docs {
        let table = |text: &str, name: &str| docs::rivals::written(text, name, &found);
        say::line(docs::update(&repository(), "docs/results.md", table)?.display());
    }
    report.verdict()
}
