//! `render`: a scene as a picture.

use std::path::PathBuf;

use clap::builder::{PossibleValuesParser, TypedValueParser};
use clap::{Args, ValueEnum};
use sglow_measure::picture::{
    FrameReference, Noise, SEED, brute_force, error, indirect, paths, picture,
};
use sglow_renderer::frame::{Frame, Renderer, Times};
use sglow_renderer::variants::Variants as _;
use sglow_report::failure::{Failure, Result};
use sglow_report::json::Report;
use sglow_report::picture::{Layer, Picture, compare, exr, png, tone};
use sglow_report::{parse, terminal, write};
use sglow_scene::Scene;

use crate::options::Numbers;
use crate::progress::Bars;
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

/// Options of `render`.
#[derive(Debug, Args)]
pub(crate) struct Arguments {
    /// A built-in scene, or a file: .gltf, .glb, .obj
    #[arg(long, value_name = "FILE|NAME")]
    scene: String,
    /// Values of axes and parameters; the others follow from the scene and the defaults
    #[arg(long, value_name = "AXIS=VALUE", value_delimiter = ',')]
    set: Vec<String>,
    /// Pixels of the picture
    #[arg(long, value_name = "WxH", default_value = "640x360", value_parser = parse::size)]
    size: [u32; 2],
    /// The file to write: .png for the eye, .exr with all layers in linear units
    #[arg(long, value_name = "FILE")]
    out: PathBuf,
    /// Show one layer alone (.png)
    #[arg(long, value_name = "LAYER", value_parser = layers())]
    layer: Option<Layer>,
    /// Exposure in stops; without it the picture's mean becomes mid-grey (.png)
    #[arg(long, value_name = "STOPS", allow_hyphen_values = true, value_parser = parse::stops)]
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
    /// The file that receives times and errors as JSON [default: that of the picture, with .json]
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    #[command(flatten)]
    numbers: Numbers,
}

/// Renders.
pub(crate) fn run(arguments: &Arguments) -> Result {
    let extension = arguments.out.extension().and_then(|extension| extension.to_str());
    let exr = extension == Some("exr");
    if !exr && extension != Some("png") {
        let expected = "the extension decides the format; expected .png or .exr";
        return Err(Failure::new(format!("{}: {expected}", arguments.out.display())));
    }
    if exr && (arguments.layer.is_some() || arguments.exposure.is_some()) {
        return Err(Failure::new("--layer and --exposure are for .png")
            .help("an .exr holds every layer, in linear units"));
    }
    // Everything that can be known before the work.
    let others =
        [write::named(&arguments.out, "reference.1"), write::named(&arguments.out, "comparison")];
    let json = write::probe_pair(&arguments.out, arguments.json.as_deref(), &others)?;
    let shot = arguments.numbers.shot(&arguments.scene, &arguments.set, arguments.size)?;
    let gpu = arguments.numbers.gpu()?;
    let package = arguments.numbers.over.package(arguments.package.as_deref())?;
    let bar = progress::spinner(format!("rendering {} on {}", shot.scene.name, gpu.adapter.name));
    let renderer = Renderer::new(&gpu, &package, &shot.scene, &shot.settings, 0)?;
    // The first frame compiles the shaders; its times are not reported.
    renderer.render()?;
    let Times { passes: times, clock } = renderer.render()?;
    let frame = renderer.read()?;
    bar.finish_and_clear();

    let mut report = Report::on(&gpu.adapter.name, &gpu.adapter.driver);
    report.detail("scene", &shot.scene.name)?;
    report.detail("triangles", shot.scene.triangle_count())?;
    report.detail("shade", shot.settings.shade().id())?;
    report.detail("clock", clock.to_string())?;
    report.detail("passes", terminal::render::milliseconds(&times))?;

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

    if let Some(theirs) = reference(arguments, &renderer, &shot.scene, &frame)? {
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
        say::line(terminal::render::error(&error, what));
        let mut numbers = serde_json::to_value(error)?;
        if let Some(noise) = noise {
            let Noise { pixel, mean, samples } = noise;
            say::line(terminal::render::noise(pixel, mean, samples, error.reference_mean));
            numbers["samples"] = noise.samples.into();
            numbers["seed"] = SEED.into();
            numbers["standard_error"] = noise.pixel.into();
            numbers["standard_error_over_mean"] = serde_json::to_value(relative(noise.pixel))?;
            numbers["standard_error_of_mean"] = noise.mean.into();
        }
        report.detail(key, numbers)?;
        let path = write::named(&arguments.out, "reference");
        if exr {
            exr::write(&path, &theirs, &comment)?;
            for (half, name) in halves.iter().flatten().zip(["reference.1", "reference.2"]) {
                exr::write(&write::named(&arguments.out, name), &picture(half)?, &comment)?;
            }
        } else {
            png::write(&path, &developed(&theirs)?)?;
            let sheet = write::named(&arguments.out, "comparison");
            let scale = if lit { 0.5 * error.reference_mean as f32 } else { 1.0 };
            let difference = compare::difference(&ours_light, &theirs_light, scale)?;
            let (ours, theirs) = (developed(&ours)?, developed(&theirs)?);
            png::write(&sheet, &compare::side_by_side(&[&ours, &theirs, &difference]))?;
            say::line(format!("{} (ours, reference, difference)", sheet.display()));
        }
        say::line(format!("{}", path.display()));
    }
    say::line(terminal::render::passes(&times));
    say::line(format!("by {clock} on {}, {}", gpu.adapter.name, gpu.adapter.driver));
    report.write(&json)?;
    say::line(format!("{}", json.display()));
    Ok(())
}

/// The requested reference, if any.
fn reference(
    arguments: &Arguments,
    renderer: &Renderer<'_>,
    scene: &Scene,
    frame: &Frame,
) -> Result<Option<FrameReference>> {
    let bars = Bars::default();
    Ok(match arguments.reference {
        Reference::None => None,
        Reference::Vpl => {
            let frame = brute_force(renderer, frame, &bars)?;
            Some(FrameReference { frame, halves: None, standard_error: None })
        }
        Reference::Path => Some(paths(renderer, scene, frame, arguments.samples, &bars)?),
    })
}
