//! `render`: a scene as a picture.

use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};
use sglow_oracle::shade::Reflected;
use sglow_runtime::frame::{Frame, Pixels, Renderer, Times};
use sglow_runtime::package::Package;
use sglow_runtime::reference;
use sglow_runtime::scene::Scene;

use crate::failure::{Failure, Result};
use crate::json::Report;
use crate::picture::{Image, Layer, Picture, compare, exr, png, tone};
use crate::progress;
use crate::say;
use crate::selection::whole_space;
use crate::shot::{self, Numbers, Shot};

/// What `--help` shows below the options.
pub(crate) const EXAMPLES: &str = "\
Examples:
  cargo xtask render --scene cornell --out out/cornell.png
  cargo xtask render --scene atrium --size 960x540 --set kernel=previous --out out/previous.exr
  cargo xtask render --scene cornell-glossy --size 320x180 --reference vpl --out out/glossy.png
  cargo xtask render --scene cornell --size 160x90 --reference path --samples 256 --out out/path.png
  cargo xtask render --scene cornell --layer normal --out out/normal.png";

/// What a picture is compared with.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Reference {
    /// Nothing.
    None,
    /// Every texel of the reflective shadow map as a lit facet, in f64 on the CPU, without visibility.
    Vpl,
    /// Paths of one bounce, in f64 on the CPU, with exact visibility; they have noise, which is stated.
    Path,
}

/// The seed of paths: the same line gives the same picture.
const SEED: u64 = 2016;

/// Options of `render`.
#[derive(Debug, Args)]
pub(crate) struct Arguments {
    /// A built-in scene, or a file: .gltf, .glb, .obj
    #[arg(long, value_name = "FILE|NAME")]
    scene: String,
    /// Values of axes; the others follow the scene's needs and the defaults
    #[arg(long, value_name = "AXIS=VALUE", value_delimiter = ',')]
    set: Vec<String>,
    /// Pixels of the picture
    #[arg(long, value_name = "WxH", default_value = "640x360", value_parser = shot::size)]
    size: [u32; 2],
    /// The file to write: .png for the eye, .exr with all layers in linear units
    #[arg(long, value_name = "FILE")]
    out: PathBuf,
    /// Show one layer alone (.png)
    #[arg(long, value_name = "LAYER")]
    layer: Option<Layer>,
    /// Exposure in stops; without it the picture's mean becomes mid-grey (.png)
    #[arg(long, value_name = "STOPS", allow_hyphen_values = true)]
    exposure: Option<f32>,
    /// Also compute the picture by brute force, and compare
    #[arg(long, value_enum, value_name = "HOW", default_value = "none")]
    reference: Reference,
    /// Paths per pixel of `--reference path`, at least 2
    #[arg(long, value_name = "N", default_value_t = 4096, value_parser = clap::value_parser!(u32).range(2..))]
    samples: u32,
    /// A package that `gen-shaders --out` wrote [default: made from the library, every variant]
    #[arg(long, value_name = "DIR")]
    package: Option<PathBuf>,
    #[command(flatten)]
    numbers: Numbers,
}

/// Renders.
///
/// # Errors
///
/// When the scene, the variant or the device does not allow it.
pub(crate) fn run(arguments: &Arguments) -> Result {
    let extension = arguments.out.extension().and_then(|extension| extension.to_str());
    let exr = match extension {
        Some("exr") => true,
        Some("png") => false,
        _ => {
            return Err(Failure::new(format!(
                "{}: the kind of picture is told by the name; use .png or .exr",
                arguments.out.display()
            )));
        }
    };
    if exr && (arguments.layer.is_some() || arguments.exposure.is_some()) {
        return Err(Failure::new("--layer and --exposure are for .png")
            .help("an .exr holds every layer, in linear units"));
    }
    let package = package(arguments.package.as_deref())?;
    let shot = Shot::new(&arguments.scene, &arguments.set, arguments.size, &arguments.numbers)?;
    let gpu = shot::gpu(&arguments.numbers)?;
    let bar = progress::spinner(format!("rendering {} on {}", shot.scene.name, gpu.adapter.name));
    let renderer = Renderer::new(&gpu, &package, &shot.scene, &shot.settings, 0)?;
    // The first frame compiles the shaders; its times are not told.
    renderer.render()?;
    let Times { passes: times, clock } = renderer.render()?;
    let frame = renderer.read()?;
    bar.finish_and_clear();

    let mut report = Report::new();
    report.adapter.clone_from(&gpu.adapter.name);
    report.driver.clone_from(&gpu.adapter.driver);
    let milliseconds: Vec<_> = times
        .iter()
        .map(|(pass, time)| serde_json::json!({ "pass": pass, "milliseconds": time.as_secs_f64() * 1e3 }))
        .collect();
    report.detail("scene", &shot.scene.name)?;
    report.detail("triangles", shot.scene.triangle_count())?;
    report.detail("shade", shot.settings.shade().id())?;
    report.detail("clock", clock.to_string())?;
    report.detail("passes", milliseconds)?;

    let ours = picture(&frame)?;
    let exposure = match arguments.exposure {
        Some(stops) => tone::Exposure::from_stops(stops),
        None => tone::Exposure::automatic(ours.radiance()?.pixels()),
    };
    let comment = format!("{} by sglow, {}", shot.scene.name, report.command);
    let developed = |picture: &Picture| -> Result<_> {
        Ok(match arguments.layer {
            Some(layer) => tone::layer(layer, picture.layer(layer)?, exposure),
            None => tone::radiance(&picture.radiance()?, exposure),
        })
    };
    report.detail("exposure_stops", exposure.stops())?;
    if exr {
        exr::write(&arguments.out, &ours, &comment)?;
    } else {
        png::write(&arguments.out, &developed(&ours)?)?;
    }
    say::line(format!("{}", arguments.out.display()));

    if let Some(theirs) = truth(arguments, &renderer, &shot.scene, &frame)? {
        let noise = theirs.standard_error;
        let (what, key) = match noise {
            None => ("virtual point lights (without visibility)", "against_virtual_point_lights"),
            Some(_) => ("paths of one bounce (with visibility)", "against_paths"),
        };
        let theirs = picture(&theirs.frame)?;
        let (ours_light, theirs_light) = (indirect(&ours)?, indirect(&theirs)?);
        let metrics = sglow_oracle::metrics::compare(&flat(&ours_light), &flat(&theirs_light))
            .ok_or_else(|| Failure::new("the reference has no finite pixel"))?;
        // Where nothing is lit there is nothing to relate to.
        let lit = metrics.reference_mean > 0.0;
        let relative = |value: f64| lit.then_some(value / metrics.reference_mean);
        let percent = |value: Option<f64>| {
            value.map_or_else(|| "no light".to_owned(), |value| format!("{:.1} %", 100.0 * value))
        };
        let bias = lit.then_some(metrics.bias);
        say::line(format!(
            "indirect light against {what}: RMSE {:.3e} ({} of the mean), relative MSE {:.3e}, bias {}",
            metrics.rmse,
            percent(relative(metrics.rmse)),
            metrics.relative_mse,
            bias.map_or_else(|| "none".to_owned(), |bias| format!("{:+.1} %", 100.0 * bias)),
        ));
        let mut numbers = serde_json::json!({
            "rmse": metrics.rmse,
            "rmse_over_mean": relative(metrics.rmse),
            "relative_mse": metrics.relative_mse,
            "bias": bias,
            "reference_mean": metrics.reference_mean,
        });
        if let Some(noise) = noise {
            say::line(format!(
                "the reference's own standard error: {:.3e} root mean square ({} of the mean), from {} paths per pixel; \
                 of its mean {:.3e} ({})",
                noise.pixel,
                percent(relative(noise.pixel)),
                arguments.samples,
                noise.mean,
                percent(relative(noise.mean)),
            ));
            numbers["samples"] = arguments.samples.into();
            numbers["seed"] = SEED.into();
            numbers["standard_error"] = noise.pixel.into();
            numbers["standard_error_over_mean"] = serde_json::to_value(relative(noise.pixel))?;
            numbers["standard_error_of_mean"] = noise.mean.into();
        }
        report.detail(key, numbers)?;
        let path = beside(&arguments.out, "reference");
        if exr {
            exr::write(&path, &theirs, &comment)?;
        } else {
            png::write(&path, &developed(&theirs)?)?;
            let sheet = beside(&arguments.out, "comparison");
            let scale = if lit { 0.5 * metrics.reference_mean as f32 } else { 1.0 };
            let difference = compare::difference(&ours_light, &theirs_light, scale)?;
            let (ours, theirs) = (developed(&ours)?, developed(&theirs)?);
            png::write(&sheet, &compare::side_by_side(&[&ours, &theirs, &difference]))?;
            say::line(format!("{} (ours, reference, difference)", sheet.display()));
        }
        say::line(format!("{}", path.display()));
    }
    let mut table = crate::table::new(["pass", "ms"]);
    for (pass, time) in &times {
        table.add_row([(*pass).to_owned(), format!("{:.3}", time.as_secs_f64() * 1e3)]);
    }
    say::line(format!("{table}\nby {clock} on {}, {}", gpu.adapter.name, gpu.adapter.driver));
    report.write(&arguments.out.with_extension("json"))
}

/// The package in a folder, or every variant of the library.
pub(crate) fn package(folder: Option<&Path>) -> Result<Package> {
    folder.map_or_else(whole_space, |folder| {
        Package::load(folder).map_err(|errors| {
            let lines: Vec<_> = errors.iter().map(ToString::to_string).collect();
            Failure::new(lines.join("\n"))
        })
    })
}

/// The same frame with its indirect light by brute force.
pub(crate) fn brute_force(renderer: &Renderer<'_>, frame: &Frame) -> Result<Frame> {
    let settings = renderer.indirect().settings();
    let rsm = renderer.read_rsm()?;
    let pixels = frame.gbuffer.position.len();
    let bar = progress::bar("virtual point lights", pixels);
    let reflected = reference::unshadowed(
        renderer.light(),
        settings,
        &rsm,
        &frame.gbuffer,
        renderer.eye(),
        |done, _| {
            bar.set_position(done as u64);
            true
        },
    )
    .ok_or_else(|| Failure::new("the reference was not finished"))?;
    bar.finish_and_clear();
    Ok(with_indirect(frame, &reflected))
}

/// A reference.
pub(crate) struct Truth {
    /// The frame with the reference's indirect light; all else is ours.
    pub(crate) frame: Frame,
    /// How uncertain it is, if it is.
    pub(crate) standard_error: Option<Noise>,
}

/// How far the noise of paths may be off, in the unit of the picture.
#[derive(Clone, Copy)]
pub(crate) struct Noise {
    /// Root mean square over the picture's numbers.
    pub(crate) pixel: f64,
    /// Of the mean over the whole picture.
    mean: f64,
}

/// The reference that is asked for, if any.
fn truth(
    arguments: &Arguments,
    renderer: &Renderer<'_>,
    scene: &Scene,
    frame: &Frame,
) -> Result<Option<Truth>> {
    match arguments.reference {
        Reference::None => Ok(None),
        Reference::Vpl => {
            Ok(Some(Truth { frame: brute_force(renderer, frame)?, standard_error: None }))
        }
        Reference::Path => paths(renderer, scene, frame, arguments.samples).map(Some),
    }
}

/// The same frame with its indirect light by paths.
pub(crate) fn paths(
    renderer: &Renderer<'_>,
    scene: &Scene,
    frame: &Frame,
    samples: u32,
) -> Result<Truth> {
    let bar = progress::bar("paths of one bounce", frame.gbuffer.position.len());
    let settings = renderer.indirect().settings();
    let (light, gbuffer, eye) = (renderer.light(), &frame.gbuffer, renderer.eye());
    let progress = |done, _| {
        bar.set_position(done as u64);
        true
    };
    let estimates =
        reference::paths(light, settings, scene, gbuffer, eye, samples, SEED, progress)?
            .ok_or_else(|| Failure::new("the reference was not finished"))?;
    bar.finish_and_clear();
    let squares: f64 = estimates.iter().map(|one| one.standard_error.length_squared()).sum();
    let numbers = 3.0 * estimates.len() as f64;
    let noise = Noise { pixel: (squares / numbers).sqrt(), mean: squares.sqrt() / numbers };
    let reflected: Vec<_> = estimates.iter().map(|one| one.mean).collect();
    Ok(Truth { frame: with_indirect(frame, &reflected), standard_error: Some(noise) })
}

/// A frame with other indirect light, of the reflections that it has.
fn with_indirect(frame: &Frame, reflected: &[Reflected]) -> Frame {
    let diffuse = reference::pixels(reflected, |pixel| pixel.diffuse);
    let specular = reference::pixels(reflected, |pixel| pixel.specular);
    Frame {
        indirect_diffuse: frame.indirect_diffuse.is_some().then_some(diffuse),
        indirect_specular: frame.indirect_specular.is_some().then_some(specular),
        ..frame.clone()
    }
}

/// A frame as layers.
pub(crate) fn picture(frame: &Frame) -> Result<Picture> {
    let [width, height] = frame.size.map(|side| side as usize);
    let image = |pixels: &Pixels| {
        let pixels = pixels.iter().map(|&[r, g, b, _]| [r, g, b]).collect();
        Image::new(width, height, pixels)
    };
    let mut layers = vec![
        (Layer::Direct, image(&frame.direct)?),
        (Layer::Albedo, image(&frame.gbuffer.base_color)?),
        (Layer::Normal, image(&frame.gbuffer.normal)?),
        (Layer::Position, image(&frame.gbuffer.position)?),
    ];
    let optional = [
        (Layer::IndirectDiffuse, &frame.indirect_diffuse),
        (Layer::IndirectSpecular, &frame.indirect_specular),
        (Layer::Emission, &frame.emission),
    ];
    // What was left out is black: a reader of the file finds every layer.
    let black = vec![[0.0; 4]; frame.direct.len()];
    for (layer, pixels) in optional {
        layers.push((layer, image(pixels.as_ref().unwrap_or(&black))?));
    }
    Picture::new(layers)
}

/// The indirect light of a picture.
pub(crate) fn indirect(picture: &Picture) -> Result<Image> {
    let diffuse = picture.layer(Layer::IndirectDiffuse)?;
    let specular = picture.layer(Layer::IndirectSpecular)?;
    let sum = diffuse.pixels().iter().zip(specular.pixels());
    let pixels = sum.map(|(a, b)| std::array::from_fn(|channel| a[channel] + b[channel])).collect();
    Image::new(diffuse.width(), diffuse.height(), pixels)
}

/// The numbers of an image one after another.
pub(crate) fn flat(image: &Image) -> Vec<f32> {
    image.pixels().iter().flatten().copied().collect()
}

/// `picture.png` as `picture.NAME.png`.
fn beside(path: &Path, name: &str) -> PathBuf {
    let extension = path.extension().unwrap_or_default().to_string_lossy().into_owned();
    path.with_extension(format!("{name}.{extension}"))
}
