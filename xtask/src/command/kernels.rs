//! `kernels`: where filtering kernels lie on a density, and what lies within them.

use std::path::PathBuf;

use clap::Args;
use sglow_measure::kernels::{place, requested};
use sglow_renderer::{density::padded, limits};
use sglow_report::failure::Result;
use sglow_report::json::Report;
use sglow_report::picture::density::Density;
use sglow_report::picture::{compare, kernels, png};
use sglow_report::{parse, terminal, write};
use sglow_results::kernels::Square;
use sglow_runtime::settings::Settings;

use crate::options::Over;
use crate::{options, progress, say};

/// What `--help` shows below the options.
pub(crate) const EXAMPLES: &str = "\
Examples:
  cargo xtask kernels --density ring --samples 64 --out out/ring
  cargo xtask kernels --density sky.hdr --samples 1024 --out out/sky
  cargo xtask kernels --density sky.hdr --samples 256 --set kernel=modified --size-factor 4 --out out/large";

/// Options of `kernels`.
#[derive(Debug, Args)]
pub(crate) struct Arguments {
    /// A built-in density (smooth, checkerboard, noise-2, noise-3, ring, hot-texel, zero), or a file: .exr, .hdr, .png,
    /// of which luminance is taken
    #[arg(long, value_name = "FILE|NAME")]
    density: String,
    /// The layer of an .exr that is the density [default: its channels without a layer, or its only layer]
    #[arg(long, value_name = "NAME")]
    layer: Option<String>,
    /// Width and height of a built-in density
    #[arg(long, value_name = "TEXELS", default_value_t = 256, value_parser = clap::value_parser!(u32).range(1..=8192))]
    texels: u32,
    /// Number of kernels, 1 to 65536
    #[arg(long, value_name = "N", default_value_t = 1024, value_parser = clap::value_parser!(u32).range(1..=65536))]
    samples: u32,
    /// Values of axes of the sampling pass; without `kernel=` both methods are shown
    #[arg(long, value_name = "AXIS=VALUE", value_delimiter = ',')]
    set: Vec<String>,
    /// K, the size of kernels relative to their share of the density
    #[arg(long, value_name = "K", default_value_t = 1.0, value_parser = parse::factor)]
    size_factor: f32,
    /// Bisection steps of Algorithm 1, 1 to 24
    #[arg(long, value_name = "STEPS", default_value_t = 12, value_parser = clap::value_parser!(u32).range(1..=24))]
    iterations: u32,
    /// The folder to write: kernels.png and kernels.json
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// The GPU whose name contains this [default: the most capable one]
    #[arg(long, value_name = "NAME")]
    adapter: Option<String>,
    /// A package that `gen-shaders --out` wrote [default: made from the library, every variant]
    #[arg(long, value_name = "DIR")]
    package: Option<PathBuf>,
    #[command(flatten)]
    over: Over,
}

/// Draws kernels.
pub(crate) fn run(arguments: &Arguments) -> Result {
    let density =
        Density::load(&arguments.density, arguments.texels as usize, arguments.layer.as_deref())?;
    limits::density(density.size)?;
    write::probe(&arguments.out)?;
    let (side, _) = padded(density.size, &density.texels);
    let base = Settings {
        map: side as u32,
        lights: arguments.samples,
        size_factor: arguments.size_factor,
        iterations: arguments.iterations,
        ..Settings::default()
    };
    let (settings, methods) = requested(base, &arguments.set)?;
    let package = arguments.over.package(arguments.package.as_deref())?;
    let gpu = options::open(arguments.adapter.as_deref())?;
    let [width, height] = density.size;
    say::line(format!("{}: {width} x {height} pixels", density.name));
    if density.size != [side; 2] {
        say::line(format!(
            "padded with zero density to {side} x {side}, and cropped again in the picture; no pixel is resampled"
        ));
    }
    let dark = density.texels.iter().all(|&texel| texel == 0.0);
    if dark {
        say::line("there is no density at all: kernels without power, wherever they lie");
    }
    let mut found = Vec::new();
    for kernel in methods {
        let bar = progress::spinner(format!("{kernel} kernels on {}", gpu.adapter.name));
        let settings = Settings { kernel, ..settings.clone() };
        found.push(place(&gpu, &package, &settings, density.size, &density.texels)?);
        bar.finish_and_clear();
    }

    let pictures = found
        .iter()
        .map(|method| {
            let squares = method.kernels.iter();
            let squares = squares.map(|one| Square { centre: one.centre, side: one.side });
            kernels::draw(&density, &squares.collect::<Vec<_>>())
        })
        .collect::<Result<Vec<_>>>()?;
    let picture = arguments.out.join("kernels.png");
    png::write(&picture, &compare::side_by_side(&pictures.iter().collect::<Vec<_>>()))?;

    say::line(terminal::kernels::show(&found, settings.lights));
    let names: Vec<&str> = found.iter().map(|method| method.kernel).collect();
    say::line(format!("{} (from left to right: {})", picture.display(), names.join(", ")));

    let mut report = Report::on(&gpu.adapter.name, &gpu.adapter.driver);
    report.detail("density", &density.name)?;
    report.detail("size", density.size)?;
    report.detail("padded_side", side)?;
    report.detail("without_density", dark)?;
    report.detail("samples", settings.lights)?;
    report.detail("size_factor", settings.size_factor)?;
    report.detail("iterations", settings.iterations)?;
    report.detail("picture_scale", kernels::scale(density.size))?;
    report.detail("methods", found)?;
    let path = arguments.out.join("kernels.json");
    report.write(&path)?;
    say::line(format!("{}", path.display()));
    Ok(())
}
