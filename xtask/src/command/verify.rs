//! `verify`: compilers that share no code with the generator read every variant of a package, hosts in other languages run its
//! frame, and a browser opens pages.

use std::path::{Path, PathBuf};

use clap::Args;
use clap::builder::{PossibleValuesParser, TypedValueParser};
use sglow_consumers::machine::repository;
use sglow_consumers::verify::{Consumer, Request, absent, install, verify};
use sglow_report::failure::{Failure, Result};
use sglow_report::json::Report;

use crate::progress::Bars;
use crate::say;

/// What `--help` shows below the options.
pub(crate) const EXAMPLES: &str = "\
Examples:
  cargo xtask verify
  cargo xtask verify --package out/package --allow-missing
  cargo xtask verify --all
  cargo xtask verify --install --json out/verify.json
  cargo xtask verify --consumer chromium --page out/report/index.html

Consumers:
  spirv-val    SPIRV-Tools, built from source once (minutes), or the system's; reads the SPIR-V of each variant
  tint         Dawn in Node (npm webgpu); reads each WGSL file, makes a pipeline of each compute entry point
  tint-spirv   Dawn in Python (dawn-python); reads the SPIR-V of each variant, makes pipelines likewise
  hosts        programs in Python (wgpu) and JavaScript (npm webgpu) run frames of the committed package; the runtime
               repeats each, and results may differ by 1e-5
  chromium     opens a page of made-up numbers, and those of --page: 400 and 1600 pixels wide, light and dark

Each consumer must also refuse what is broken on purpose. What is fetched or built lies in target/verify; pictures of
pages lie beside the result, in verify.";

/// Options of `verify`.
#[derive(Debug, Args)]
pub(crate) struct Arguments {
    /// The package to read [default: shaders/packages/sglow]
    #[arg(long, value_name = "DIR")]
    package: Option<PathBuf>,
    /// Read every variant of the space instead, generated for this
    #[arg(long, conflicts_with = "package")]
    all: bool,
    /// Run only these consumers
    #[arg(long, value_name = "NAME", value_delimiter = ',',
        value_parser = consumers())]
    consumer: Vec<Consumer>,
    /// Also open this page in the browser; may be given more than once
    #[arg(long, value_name = "FILE")]
    page: Vec<PathBuf>,
    /// The file that receives the result [default: out/verify.json]
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// Succeed even if a consumer is not available
    #[arg(long)]
    allow_missing: bool,
    /// Install missing system packages with apt-get
    #[arg(long)]
    install: bool,
}

/// The names of consumers.
fn consumers() -> impl TypedValueParser<Value = Consumer> {
    PossibleValuesParser::new(Consumer::ALL.map(|one| one.0)).try_map(|text| {
        let found = Consumer::ALL.into_iter().find(|one| one.0 == text);
        found.map(|one| one.1).ok_or("unknown consumer")
    })
}

/// Runs every consumer.
pub(crate) fn run(arguments: &Arguments) -> Result {
    let json = arguments.json.clone().unwrap_or_else(|| repository().join("out/verify.json"));
    let bars = Bars::default();
    let request = Request {
        package: arguments.package.clone(),
        all: arguments.all,
        consumers: arguments.consumer.clone(),
        pages: arguments.page.clone(),
        pictures: json.parent().unwrap_or(Path::new("")).join("verify"),
        allow_missing: arguments.allow_missing,
        progress: &bars,
    };
    if !arguments.page.is_empty() && !request.includes(Consumer::Chromium) {
        return Err(Failure::new("`--page` is for the consumer chromium, which is not requested")
            .help("add it: --consumer chromium"));
    }
    if arguments.install {
        install(&request)?;
    }
    let mut report = Report::new();
    let missing = verify(&request, &mut report);
    bars.clear();
    let missing = missing?;
    say::line(report.table());
    report.detail("missing", &missing)?;
    report.write(&json)?;
    say::line(format!("written: {}", json.display()));
    absent(&missing, arguments.allow_missing)?;
    report.verdict()
}
