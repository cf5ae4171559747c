//! `render`: a scene as a picture.

use std::path::{Path, PathBuf};

use clap::builder::{PossibleValuesParser, TypedValueParser};
use clap::{Args, ValueEnum};
use sglow_oracle::estimate::Estimate;
use sglow_oracle::shade::Reflected;
use sglow_renderer::frame::{Frame, Pixels, Renderer, Times};
use sglow_renderer::reference;
use sglow_renderer::variants::Variants as _;
use sglow_report::failure::{Failure, Result};
use sglow_report::json::Report;
use sglow_report::picture::{Image, Layer, Picture, exr, png, tone};
use sglow_report::{picture, picture_error};
use sglow_results::picture_error::{Display, Pair, PictureError, Radiance, compare};
use sglow_runtime::package::Package;
use sglow_scene::Scene;

use crate::selection::Over;
use crate::shot::{self, Numbers, Shot};
use crate::{progress, say};

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

/// The names of layers on the command line, in the order of [`Layer::ALL`].
const LAYERS: [&str; 7] =
    ["direct", "indirect-diffuse", "indirect-specular", "emission", "albedo", "normal", "position"];

fn layers() -> impl TypedValueParser<Value = Layer> {
    PossibleValuesParser::new(LAYERS).try_map(|text| {
        let at = LAYERS.iter().position(|name| *name == text);
        at.and_then(|at| Layer::ALL.get(at)).copied().ok_or("unknown layer")
    })
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
    #[arg(long, value_name = "LAYER", value_parser = layers())]
    layer: Option<Layer>,
    /// Exposure in stops; without it the picture's mean becomes mid-grey (.png)
    #[arg(long, value_name = "STOPS", allow_hyphen_values = true)]
    exposure: Option<f32>,
    /// Also compute the picture by brute force, and compare
    #[arg(long, value_enum, value_name = "HOW", default_value = "none")]
    reference: Reference,
    /// Paths per pixel of `--reference path`, half of them in each of two independent references, at least 4
    #[arg(long, value_name = "N", default_value_t = 4096, value_parser = clap::value_parser!(u32).range(4..))]
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
    let package = package(arguments.package.as_deref(), &arguments.numbers.over)?;
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
            None => ("facets of the map (without visibility)", "against_virtual_point_lights"),
            Some(_) => ("paths of one bounce (with visibility)", "against_paths"),
        };
        let error = error(&frame, &theirs)?;
        let halves = theirs.halves;
        let theirs = picture(&theirs.frame)?;
        let (ours_light, theirs_light) = (indirect(&ours)?, indirect(&theirs)?);
        // Where nothing is lit there is nothing to relate to.
        let lit = error.reference_mean > 0.0;
        let relative = |value: f64| lit.then_some(value / error.reference_mean);
        let percent = |value: Option<f64>| {
            value.map_or_else(|| "no light".to_owned(), |value| format!("{:.1} %", 100.0 * value))
        };
        let mut table = sglow_report::table::new(picture_error::HEADINGS);
        table.add_row(picture_error::cells(&error));
        say::line(format!(
            "indirect light against {what}, on {} pixels with a surface:\n{table}",
            error.pixels
        ));
        let mut numbers = serde_json::to_value(error)?;
        if let Some(noise) = noise {
            say::line(format!(
                "the reference's own standard error: {:.3e} root mean square ({} of the mean), from {} paths per pixel; \
                 of its mean {:.3e} ({})",
                noise.pixel,
                percent(relative(noise.pixel)),
                noise.samples,
                noise.mean,
                percent(relative(noise.mean)),
            ));
            numbers["samples"] = noise.samples.into();
            numbers["seed"] = SEED.into();
            numbers["standard_error"] = noise.pixel.into();
            numbers["standard_error_over_mean"] = serde_json::to_value(relative(noise.pixel))?;
            numbers["standard_error_of_mean"] = noise.mean.into();
        }
        report.detail(key, numbers)?;
        let path = beside(&arguments.out, "reference");
        if exr {
            exr::write(&path, &theirs, &comment)?;
            for (half, name) in halves.iter().flatten().zip(["reference.1", "reference.2"]) {
                exr::write(&beside(&arguments.out, name), &picture(half)?, &comment)?;
            }
        } else {
            png::write(&path, &developed(&theirs)?)?;
            let sheet = beside(&arguments.out, "comparison");
            let scale = if lit { 0.5 * error.reference_mean as f32 } else { 1.0 };
            let difference = picture::compare::difference(&ours_light, &theirs_light, scale)?;
            let (ours, theirs) = (developed(&ours)?, developed(&theirs)?);
            png::write(&sheet, &picture::compare::side_by_side(&[&ours, &theirs, &difference]))?;
            say::line(format!("{} (ours, reference, difference)", sheet.display()));
        }
        say::line(format!("{}", path.display()));
    }
    let mut table = sglow_report::table::new(["pass", "ms"]);
    for (pass, time) in &times {
        table.add_row([(*pass).to_owned(), format!("{:.3}", time.as_secs_f64() * 1e3)]);
    }
    say::line(format!("{table}\nby {clock} on {}, {}", gpu.adapter.name, gpu.adapter.driver));
    report.write(&arguments.out.with_extension("json"))
}

/// The package in a folder, or every variant of the library with what is laid over it.
pub(crate) fn package(folder: Option<&Path>, over: &Over) -> Result<Package> {
    let whole = || over.whole_space();
    folder.map_or_else(whole, |folder| {
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
    let bar = progress::bar("facets of the map", pixels);
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
    /// The same of two independent halves, if it has noise.
    pub(crate) halves: Option<[Frame; 2]>,
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
    /// Paths of each pixel, of both halves together.
    samples: u32,
}

/// How far a frame's indirect light is from a reference of it, by every metric.
pub(crate) fn error(frame: &Frame, truth: &Truth) -> Result<PictureError> {
    let halves = match &truth.halves {
        Some([one, other]) => [one, other],
        None => [&truth.frame; 2],
    };
    let pixels = |image: Image| -> Radiance { image.pixels().to_vec() };
    let both = |frame: &Frame| -> Result<[Radiance; 2]> {
        let picture = picture(frame)?;
        Ok([pixels(indirect(&picture)?), pixels(picture.radiance()?)])
    };
    let [light, whole] = both(frame)?;
    let [one, other] = [both(halves[0])?, both(halves[1])?];
    let position = &frame.gbuffer.position;
    let present: Vec<usize> = (0..position.len()).filter(|&at| position[at][3] >= 0.0).collect();
    if present.is_empty() {
        return Err(Failure::new("the camera sees no surface, so there is nothing to compare"));
    }
    Ok(compare(&Pair {
        size: frame.size,
        present: Some(&present),
        picture: &light,
        halves: [&one[0], &other[0]],
        whole: &whole,
        whole_halves: [&one[1], &other[1]],
        display: Display::Automatic,
    }))
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
            let frame = brute_force(renderer, frame)?;
            Ok(Some(Truth { frame, halves: None, standard_error: None }))
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
    let halves =
        reference::path_halves(light, settings, scene, gbuffer, eye, samples, SEED, progress)?
            .ok_or_else(|| Failure::new("the reference was not finished"))?;
    bar.finish_and_clear();
    let estimates: Vec<Estimate> = halves.iter().map(Estimate::mean_of).collect();
    let squares: f64 = estimates.iter().map(|one| one.standard_error.length_squared()).sum();
    let numbers = 3.0 * estimates.len() as f64;
    let noise =
        Noise { pixel: (squares / numbers).sqrt(), mean: squares.sqrt() / numbers, samples };
    let lit = |estimates: &mut dyn Iterator<Item = &Estimate>| {
        let reflected: Vec<_> = estimates.map(|one| one.mean).collect();
        with_indirect(frame, &reflected)
    };
    Ok(Truth {
        frame: lit(&mut estimates.iter()),
        halves: Some([0, 1].map(|half: usize| lit(&mut halves.iter().map(|both| &both[half])))),
        standard_error: Some(noise),
    })
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

/// `picture.png` as `picture.NAME.png`.
fn beside(path: &Path, name: &str) -> PathBuf {
    let extension = path.extension().unwrap_or_default().to_string_lossy().into_owned();
    path.with_extension(format!("{name}.{extension}"))
}
