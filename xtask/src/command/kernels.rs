//! `kernels`: where filtering kernels lie on a density, and what lies within them.

use std::path::PathBuf;

use clap::Args;
use serde::Serialize;
use sglow_oracle::fis::{Footprints, all_roots, kernel_mass};
use sglow_oracle::rsm::Pyramid;
use sglow_renderer::density;
use sglow_renderer::device::Gpu;
use sglow_report::failure::{Failure, Result};
use sglow_report::json::Report;
use sglow_report::picture::density::Density;
use sglow_report::picture::kernels::Square;
use sglow_report::picture::{compare, kernels, png};
use sglow_report::table;
use sglow_runtime::package::Package;
use sglow_runtime::settings::Settings;
use sglow_shaders::Kernel;

use crate::command::render::package;
use crate::selection::Over;
use crate::{progress, say, shot};

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
    /// Width and height of a built-in density
    #[arg(long, value_name = "TEXELS", default_value_t = 256, value_parser = clap::value_parser!(u32).range(1..=8192))]
    texels: u32,
    /// Number of kernels, 1 to 65536
    #[arg(long, value_name = "N", default_value_t = 1024)]
    samples: u32,
    /// Values of axes of the sampling pass; without `kernel=` both methods are shown
    #[arg(long, value_name = "AXIS=VALUE", value_delimiter = ',')]
    set: Vec<String>,
    /// K, the size of kernels relative to their share of the density
    #[arg(long, value_name = "K", default_value_t = 1.0)]
    size_factor: f32,
    /// Bisection steps of Algorithm 1, 1 to 24
    #[arg(long, value_name = "STEPS", default_value_t = 12)]
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

/// One kernel.
#[derive(Clone, Debug, Serialize)]
struct One {
    /// In pixels of the image, from its top left corner.
    centre: [f64; 2],
    level: f64,
    /// In pixels: 2^level.
    side: f64,
    /// The density's sum within the square, over the sum of all, times N.
    mass: f64,
    /// The left side of Eq. (3) times N: the same as filtering sees it.
    filtered_mass: f64,
    /// Times the filtered power per texel, it is the kernel's power.
    weight: f64,
    /// Of a total of 1 that is spread as the density is.
    power: f64,
    /// Levels that solve Eq. (3) for K.
    roots: Vec<f64>,
}

/// What one method makes of a density.
#[derive(Clone, Debug, Serialize)]
struct Method {
    kernel: &'static str,
    /// Standard deviation over mean of the masses.
    mass_variation: f64,
    /// The largest mass, times N.
    largest_mass: f64,
    /// The brightest light's power times N: 1 is ideal.
    brightest: f64,
    /// Sum of all lights' power, of a total of 1.
    power: f64,
    /// Shares of kernels for which Eq. (3) has no solution, and for which it has several.
    without_root: f64,
    several_roots: f64,
    kernels: Vec<One>,
}

/// Draws kernels.
///
/// # Errors
///
/// When the density, a setting or the device does not allow it.
pub(crate) fn run(arguments: &Arguments) -> Result {
    let density = Density::load(&arguments.density, arguments.texels as usize)?;
    let (side, square) = density::padded(density.size, &density.texels);
    let (settings, methods) = settings(arguments, side)?;
    let package = package(arguments.package.as_deref(), &arguments.over)?;
    let gpu = shot::open(arguments.adapter.as_deref())?;
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
    let pyramid = Pyramid::build(side, square.iter().copied().map(f64::from).collect())?;
    let mut found = Vec::new();
    for kernel in methods {
        let bar = progress::spinner(format!("{kernel} kernels on {}", gpu.adapter.name));
        let settings = Settings { kernel, ..settings.clone() };
        found.push(method(&gpu, &package, &settings, &density, &square, &pyramid)?);
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

    let mut table =
        table::new(["kernel", "variation", "largest", "brightest", "power", "no root", "several"]);
    for method in &found {
        table.add_row([
            method.kernel.to_owned(),
            format!("{:.4}", method.mass_variation),
            format!("{:.2}", method.largest_mass),
            format!("{:.2}", method.brightest),
            format!("{:.4}", method.power),
            percent(method.without_root),
            percent(method.several_roots),
        ]);
    }
    say::line(format!(
        "{} kernels; masses and powers times N, of a total of 1: their variation is the standard deviation over the \
         mean\n{table}",
        settings.lights
    ));
    let names: Vec<&str> = found.iter().map(|method| method.kernel).collect();
    say::line(format!("{} (from left to right: {})", picture.display(), names.join(", ")));

    let mut report = Report::new();
    report.adapter.clone_from(&gpu.adapter.name);
    report.driver.clone_from(&gpu.adapter.driver);
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

/// What is asked for, and by which methods.
fn settings(arguments: &Arguments, side: usize) -> Result<(Settings, Vec<Kernel>)> {
    let mut settings = Settings {
        map: side as u32,
        lights: arguments.samples,
        size_factor: arguments.size_factor,
        iterations: arguments.iterations,
        ..Settings::default()
    };
    let mut wrong = Vec::new();
    let mut methods = Kernel::ALL.to_vec();
    for setting in &arguments.set {
        match setting.split_once('=') {
            None => wrong.push(format!("`{setting}` is not AXIS=VALUE")),
            Some((axis, value)) => match settings.set(axis, value) {
                Err(error) => wrong.push(error.to_string()),
                Ok(()) if axis == "kernel" => methods = vec![settings.kernel],
                Ok(()) => {}
            },
        }
    }
    if wrong.is_empty() { Ok((settings, methods)) } else { Err(Failure::new(wrong.join("\n"))) }
}

fn method(
    gpu: &Gpu,
    package: &Package,
    settings: &Settings,
    density: &Density,
    square: &[f32],
    pyramid: &Pyramid<f64>,
) -> Result<Method> {
    let sampled = density::sample(gpu, package, settings, square, square)?;
    let footprints = Footprints::new(density.size, &density.texels);
    let (count, side) = (f64::from(settings.lights), f64::from(settings.map));
    // Without density every share of it is 0.
    let share = |value: f64, whole: f64| if whole > 0.0 { value / whole } else { 0.0 };
    let kernels: Vec<One> = sampled
        .kernels
        .iter()
        .zip(&sampled.powers)
        .map(|(kernel, &power)| {
            let place = kernel.centre.map(f64::from);
            let level = f64::from(kernel.level);
            let centre = place.map(|part| part * side);
            One {
                centre,
                level,
                side: level.exp2(),
                mass: count * share(footprints.mass(centre, level.exp2()), footprints.total()),
                filtered_mass: count * kernel_mass(pyramid, place, level),
                weight: f64::from(kernel.scale),
                power: share(power, sampled.total),
                roots: all_roots(pyramid, place, settings.lights, f64::from(settings.size_factor)),
            }
        })
        .collect();
    let largest = |value: fn(&One) -> f64| kernels.iter().map(value).fold(0.0, f64::max);
    let of_all = |test: fn(&One) -> bool| {
        kernels.iter().filter(|one| test(one)).count() as f64 / kernels.len().max(1) as f64
    };
    Ok(Method {
        kernel: settings.kernel.name(),
        mass_variation: variation(kernels.iter().map(|one| one.mass)),
        largest_mass: largest(|one| one.mass),
        brightest: count * largest(|one| one.power),
        power: kernels.iter().map(|one| one.power).sum(),
        without_root: of_all(|one| one.roots.is_empty()),
        several_roots: of_all(|one| one.roots.len() > 1),
        kernels,
    })
}

/// Standard deviation over mean; 0 where the mean is.
fn variation(values: impl Iterator<Item = f64> + Clone) -> f64 {
    let count = values.clone().count().max(1) as f64;
    let mean = values.clone().sum::<f64>() / count;
    let variance = values.map(|value| (value - mean).powi(2)).sum::<f64>() / count;
    if mean > 0.0 { variance.sqrt() / mean } else { 0.0 }
}

fn percent(share: f64) -> String {
    format!("{:.1} %", 100.0 * share)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn arguments(set: &[&str]) -> Arguments {
        Arguments {
            density: "ring".to_owned(),
            texels: 16,
            samples: 8,
            set: set.iter().map(|&word| word.to_owned()).collect(),
            size_factor: 2.0,
            iterations: 9,
            out: PathBuf::new(),
            adapter: None,
            package: None,
            over: Over::default(),
        }
    }

    #[test]
    fn both_methods_are_shown_unless_one_is_asked_for() {
        let (both, methods) = settings(&arguments(&[]), 16).unwrap();
        assert_eq!(methods, [Kernel::Previous, Kernel::Modified]);
        assert_eq!((both.lights, both.map, both.iterations), (8, 16, 9));
        assert_eq!(both.size_factor, 2.0);
        let (_, methods) = settings(&arguments(&["kernel=previous"]), 16).unwrap();
        assert_eq!(methods, [Kernel::Previous]);
        let wrong = settings(&arguments(&["kernel=cubic", "colour=red", "x"]), 16);
        let text = wrong.err().unwrap().to_string();
        for part in ["previous, modified", "unknown axis 'colour'", "`x` is not AXIS=VALUE"] {
            assert!(text.contains(part), "{text}");
        }
    }

    #[test]
    fn the_variation_is_relative_and_never_nan() {
        let of = |values: &[f64]| variation(values.iter().copied());
        assert!((of(&[1.0, 3.0]) - 0.5).abs() < 1e-15);
        assert_eq!((of(&[2.0, 2.0]), of(&[0.0, 0.0]), of(&[])), (0.0, 0.0, 0.0));
    }
}
