//! `stability`: every function and the whole pipeline, over every regime, against the bounds.

use std::path::PathBuf;
use std::time::Instant;

use clap::Args;
use sglow_consumers::machine::repository;
use sglow_measure::halves::pipeline;
use sglow_measure::hold::Extent;
use sglow_measure::stability::variants;
use sglow_report::failure::{Failure, Result};
use sglow_report::json::Report;
use sglow_report::page::stability::{Findings, cosine_forms};
use sglow_report::terminal::stability::DOES_NOT_SHOW;
use sglow_report::{docs, failure, terminal, write};
use sglow_results::arithmetic::Arithmetic;
use sglow_results::stability::checks::{checks, of_run};
use sglow_runtime::package::Package;

use crate::options::Over;
use crate::progress::Bars;
use crate::{options, progress, say};

/// What `--help` shows below the options.
pub(crate) const EXAMPLES: &str = "\
Examples:
  cargo xtask stability
  cargo xtask stability --quick --only sg_integral --out out/integral
  cargo xtask stability --picture docs/pictures/cosine_forms.svg

Every function of the library runs on random and on hostile inputs, on the device and, under every arithmetic that a
driver may use, on the CPU; it is compared with the oracle and the reference, and timed. Then the whole pipeline meets
extreme scenes. DIR/index.html shows it, DIR/stability.json has every number and every bound.";

/// Options of `stability`.
#[derive(Debug, Args)]
pub(crate) struct Arguments {
    /// The folder that receives index.html and stability.json
    #[arg(long, value_name = "DIR", default_value = "out/stability")]
    out: PathBuf,
    /// Only this function, without the pipeline; may be given more than once
    #[arg(long, value_name = "NAME")]
    only: Vec<String>,
    /// A sixteenth of the inputs: a smoke test, without guarantee
    #[arg(long)]
    quick: bool,
    /// Also write the plot of error against time of the cosine forms, as SVG on white
    #[arg(long, value_name = "FILE")]
    picture: Option<PathBuf>,
    /// Also write the tables of docs/results.md
    #[arg(long, conflicts_with_all = ["only", "quick"])]
    write_docs: bool,
    /// The GPU whose name contains this [default: the most capable one]
    #[arg(long, value_name = "NAME")]
    adapter: Option<String>,
}

/// Measures and prints.
pub(crate) fn run(arguments: &Arguments) -> Result {
    let start = Instant::now();
    let chosen = sglow_measure::functions::chosen(&arguments.only)?;
    let whole_run = arguments.only.is_empty();
    let gpu = options::open(arguments.adapter.as_deref())?;
    let mut report = Report::on(&gpu.adapter.name, &gpu.adapter.driver);
    report.versions.insert("naga".to_owned(), sglow_shader_gen::hash::NAGA.to_owned());

    let spinner = progress::spinner("generating the functions' variants");
    let variants = variants(&Over::default().library()?).map_err(failure::rendered)?;
    let texts = variants.iter().map(|one| (one.variant.id(), one.text.clone()));
    let package = Package::generated("the functions of the library", texts);
    spinner.finish_and_clear();

    // One more: that of all times.
    let bar = progress::bar("functions", chosen.len() + 1);
    let extent = if arguments.quick { Extent::QUICK } else { Extent::FULL };
    let functions =
        sglow_measure::stability::functions(&gpu, &package, &variants, &chosen, &extent, |name| {
            bar.set_message(name.to_owned());
            bar.inc(1);
        })?;
    bar.finish_and_clear();
    let (extremes, halves) = if whole_run {
        let bars = Bars::default();
        pipeline(&gpu, &Over::default().whole_space()?, &bars)?
    } else {
        (Vec::new(), Vec::new())
    };
    let minutes = start.elapsed().as_secs_f64() / 60.0;

    report.checks(checks(&functions, &extremes, &halves, sglow_measure::bound::FITTED_OVER_ERF));
    report.checks(of_run(&functions, whole_run && !arguments.quick, minutes));

    report.detail("functions", &functions)?;
    report.detail("extremes", &extremes)?;
    report.detail("halves", &halves)?;
    report.detail("arithmetics", Arithmetic::ALL.map(Arithmetic::name))?;
    report.detail("does_not_show", DOES_NOT_SHOW)?;
    let findings = Findings {
        report: &report,
        functions: &functions,
        extremes: &extremes,
        halves: &halves,
        minutes,
        does_not_show: &DOES_NOT_SHOW,
    };
    let page = arguments.out.join("index.html");
    write::text(&page, &findings.page())?;
    report.write(&arguments.out.join("stability.json"))?;
    say::line(terminal::stability::show(&findings));
    say::line(page.display());
    if let Some(path) = &arguments.picture {
        let drawing = cosine_forms(&functions).drawing().ok_or_else(|| {
            Failure::new("there is no picture: no cosine form was measured")
                .help("leave `--only` out, or name functions that begin with sg_cosine_")
        })?;
        write::text(path, &drawing.file())?;
    }
    if arguments.write_docs {
        let tables =
            |text: &str, name: &str| docs::stability::written(text, name, &functions, &halves);
        say::line(docs::update(&repository(), "docs/results.md", tables)?.display());
    }
    report.verdict()
}
