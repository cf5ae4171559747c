//! `compare`: two pictures by every metric.

use std::path::{Path, PathBuf};

use clap::Args;
use sglow_report::failure::{Failure, Result};
use sglow_report::json::Report;
use sglow_report::picture::read::{INDIRECT, RADIANCE, Read};
use sglow_report::picture::{Image, false_colour, png};
use sglow_report::picture_error::{HEADINGS, cells, text};
use sglow_report::{failure, table, write};
use sglow_results::check::{Check, Relation};
use sglow_results::picture_error::{
    Display, Metric, Pair, PictureError, Radiance, compare, flip_map, relative_errors,
};

use crate::say;

/// What `--help` shows below the options.
pub(crate) const EXAMPLES: &str = "\
Examples:
  cargo xtask compare out/ours.exr out/ours.reference.exr --out out/compared
  cargo xtask compare out/ours.exr out/ours.reference.1.exr --half out/ours.reference.2.exr
  cargo xtask compare out/ours.exr mitsuba.exr --layer radiance --metric median --metric q95
  cargo xtask compare out/one.png out/other.png --metric rmse --at-most 5%

A is tested, B is its reference. Pictures are OpenEXR with layers by name, Radiance HDR or PNG; PNG is converted from
sRGB to linear light. Without --layer, files that `render` wrote are compared by their indirect light, others by the one
layer that they have. The sums `indirect` and `radiance` are layers too.

Metrics are over pixels that show a surface, where a file tells them (layer normal, or alpha), else over all:
  relative_mse  mean of (A - B)^2 / (B^2 + 1e-2 mean(B^2))
  rmse          root mean square of A - B over the mean of B
  median, q95   50 and 95 % quantiles of the luminance of |A - B| over that of B plus 1e-2 times its mean
  flip          mean of the FLIP map of the whole pictures, with one exposure; a PNG is shown as it is
  bias          mean of A over mean of B, minus 1

A reference with noise is best given as two independent halves: squared errors are then free of its noise, and every
error has an uncertainty. Without --half B counts as exact, and its noise as error of A.";

/// Options of `compare`.
#[derive(Debug, Args)]
pub(crate) struct Arguments {
    /// The picture that is tested: .exr, .hdr, .png
    #[arg(value_name = "A")]
    tested: PathBuf,
    /// Its reference
    #[arg(value_name = "B")]
    reference: PathBuf,
    /// B and this picture are independent halves of the reference
    #[arg(long, value_name = "FILE")]
    half: Option<PathBuf>,
    /// Show this metric alone: relative_mse, rmse, median, q95, flip, bias; may be given more than once
    #[arg(long, value_name = "METRIC")]
    metric: Vec<Metric>,
    /// Fail unless each shown metric is at most this: a number, or a percentage
    #[arg(long, value_name = "E", value_parser = super::choose::share, requires = "metric")]
    at_most: Option<f64>,
    /// The layer that is compared
    #[arg(long, value_name = "NAME")]
    layer: Option<String>,
    /// The folder that receives compare.json, and the relative error and FLIP of every pixel in false colour
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

/// Pictures that can be compared.
struct Loaded {
    layer: String,
    tested: Image,
    halves: [Image; 2],
    whole: Image,
    whole_halves: [Image; 2],
    /// Pixels that count, and how they are known.
    present: Option<(Vec<usize>, &'static str)>,
    display: Display,
}

impl Loaded {
    /// Compares them, with what `pair` makes of both.
    fn with<T>(&self, of: impl Fn(&Pair<'_>) -> T) -> T {
        let pixels = |image: &Image| -> Radiance { image.pixels().to_vec() };
        let (picture, whole) = (pixels(&self.tested), pixels(&self.whole));
        let [halves, whole_halves] =
            [&self.halves, &self.whole_halves].map(|halves| halves.each_ref().map(pixels));
        of(&Pair {
            size: self.size(),
            present: self.present.as_ref().map(|present| present.0.as_slice()),
            picture: &picture,
            halves: halves.each_ref(),
            whole: &whole,
            whole_halves: whole_halves.each_ref(),
            display: self.display,
        })
    }

    fn size(&self) -> [u32; 2] {
        [self.tested.width(), self.tested.height()].map(|side| side as u32)
    }
}

/// Compares.
///
/// # Errors
///
/// When a picture cannot be read, lacks the layer or has another size, a number is not finite, or an error exceeds
/// `--at-most`.
pub(crate) fn run(arguments: &Arguments) -> Result {
    if let Some(out) = &arguments.out {
        write::probe(out)?;
    }
    let loaded = load(arguments)?;
    let error = loaded.with(compare);
    let mut report = Report::new();
    show(arguments, &loaded, &error);
    if let Some(most) = arguments.at_most {
        for &metric in &arguments.metric {
            let unit = if metric.is_share() { "of the mean" } else { "" };
            report.check(Check::new(
                metric.title(),
                error.of(metric),
                unit,
                Relation::AtMost,
                most,
            ));
        }
    }
    report.detail("tested", &arguments.tested)?;
    report.detail("reference", &arguments.reference)?;
    report.detail("half", &arguments.half)?;
    report.detail("layer", &loaded.layer)?;
    report.detail("size", loaded.size())?;
    report.detail("pixels", loaded.present.as_ref().map_or("all", |present| present.1))?;
    report.detail("error", error)?;
    if let Some(out) = &arguments.out {
        draw(out, &loaded, &error)?;
        let path = out.join("compare.json");
        report.write(&path)?;
        say::line(format!("{}", path.display()));
    }
    if report.checks.is_empty() { Ok(()) } else { report.verdict() }
}

/// Reads the pictures and takes the layers.
fn load(arguments: &Arguments) -> Result<Loaded> {
    let second = arguments.half.as_ref();
    let mut paths = vec![&arguments.tested, &arguments.reference];
    paths.extend(second);
    let read = failure::all(paths.iter().map(|path| Read::new(path)).collect())?;
    for (path, _) in paths.iter().zip(&read).filter(|(_, read)| read.converted) {
        say::line(format!("{}: converted from sRGB to linear light", path.display()));
    }
    let indirect = read.iter().all(|read| read.layer(INDIRECT).is_some());
    let layer = match &arguments.layer {
        Some(layer) => Some(layer.clone()),
        None => indirect.then(|| INDIRECT.to_owned()),
    };
    let chosen = |(path, read): (&&PathBuf, &Read)| -> Result<Image> {
        let found = match &layer {
            Some(layer) => read.layer(layer),
            None => read.whole(),
        };
        found.ok_or_else(|| {
            let what = layer.as_ref().map_or_else(
                || "more than one layer".to_owned(),
                |layer| format!("no layer '{layer}'"),
            );
            let names = read.names();
            let has = if names.is_empty() {
                "one layer without a name".to_owned()
            } else {
                names.join(", ")
            };
            Failure::new(format!("{}: {what}", path.display()))
                .help(format!("--layer takes one of: {has}"))
        })
    };
    let mut images = failure::all(paths.iter().zip(&read).map(chosen).collect())?;
    if images.len() == 2 {
        images.push(images[1].clone());
    }
    let size = |image: &Image| [image.width(), image.height()];
    let names = [&arguments.tested, &arguments.reference, second.unwrap_or(&arguments.reference)];
    for (path, image) in names.iter().zip(&images).skip(1) {
        let ([width, height], [other, tall]) = (size(&images[0]), size(image));
        if [width, height] != [other, tall] {
            return Err(Failure::new(format!(
                "{} has {width} x {height} pixels and {} has {other} x {tall}; they have to be the same",
                names[0].display(),
                path.display(),
            )));
        }
    }
    let present = surfaces(&read, images[0].pixels().len());
    let counts = |at: usize| present.as_ref().is_none_or(|one| one.0.binary_search(&at).is_ok());
    for (path, image) in names.iter().zip(&images) {
        finite(path, image, &counts)?;
    }
    // Indirect light is seen with all else that there is.
    let whole: Vec<Image> = read
        .iter()
        .zip(&images)
        .map(|(read, image)| {
            let all = read.layer(RADIANCE).filter(|_| layer.as_deref() == Some(INDIRECT));
            all.unwrap_or_else(|| image.clone())
        })
        .collect();
    let both = |images: &[Image]| {
        let second = images.get(2).or(images.get(1));
        [images[1].clone(), second.unwrap_or(&images[0]).clone()]
    };
    Ok(Loaded {
        layer: layer.unwrap_or_else(|| "the whole picture".to_owned()),
        halves: both(&images),
        whole_halves: both(&whole),
        tested: images.swap_remove(0),
        whole: whole[0].clone(),
        present,
        display: if read.iter().all(|read| read.converted) {
            Display::AsIs
        } else {
            Display::Automatic
        },
    })
}

/// The pixels that show a surface in the reference, or else in the tested picture.
fn surfaces(read: &[Read], pixels: usize) -> Option<(Vec<usize>, &'static str)> {
    let known = read.iter().skip(1).chain(read.first()).find_map(Read::surfaces);
    let (present, how) = known.filter(|known| known.0.len() == pixels)?;
    let present: Vec<usize> =
        present.iter().enumerate().filter(|one| *one.1).map(|one| one.0).collect();
    // A file without any surface does not say which pixels count.
    (!present.is_empty()).then_some((present, how))
}

/// Whether all numbers that count are finite.
fn finite(path: &Path, image: &Image, counts: &dyn Fn(usize) -> bool) -> Result {
    let odd = |at: &usize| image.pixels()[*at].iter().any(|part| !part.is_finite()) && counts(*at);
    let found: Vec<usize> = (0..image.pixels().len()).filter(odd).collect();
    match found.first() {
        None => Ok(()),
        Some(first) => Err(Failure::new(format!(
            "{}: {} pixels are not finite, the first at column {}, row {}",
            path.display(),
            found.len(),
            first % image.width(),
            first / image.width()
        ))),
    }
}

/// The numbers as a table.
fn show(arguments: &Arguments, loaded: &Loaded, error: &PictureError) {
    let shown: Vec<usize> = (0..Metric::ALL.len())
        .filter(|&at| arguments.metric.is_empty() || arguments.metric.contains(&Metric::ALL[at]))
        .collect();
    let dark = error.reference_mean == 0.0;
    let mut table = table::new(["metric", "error", "uncertainty"]);
    let cells = cells(error);
    for at in shown {
        let metric = Metric::ALL[at];
        let uncertainty = error.measured(metric).uncertainty;
        table.add_row([
            format!("{} ({})", HEADINGS[at], metric.name()),
            cells[at].clone(),
            if uncertainty > 0.0 { text(uncertainty, metric, dark) } else { "–".to_owned() },
        ]);
    }
    let [width, height] = loaded.size();
    say::line(format!(
        "{}: {} of {} pixels ({}), layer {}{}\n{table}",
        arguments.tested.display(),
        error.pixels,
        width * height,
        loaded.present.as_ref().map_or("all: no file tells where there is a surface", |one| one.1),
        loaded.layer,
        if dark { "; the reference is black, so errors are absolute" } else { "" },
    ));
}

/// The relative error and FLIP of every pixel in false colour.
fn draw(out: &Path, loaded: &Loaded, error: &PictureError) -> Result {
    let [width, height] = loaded.size();
    // A round number that most pixels are below.
    let top = [0.05_f32, 0.1, 0.2, 0.5].into_iter().find(|top| error.q95 <= f64::from(*top));
    let top = top.unwrap_or(1.0);
    let errors = loaded.with(relative_errors);
    let flip = loaded.with(|pair| {
        let reference = sglow_results::picture_error::mean(pair.whole_halves);
        flip_map(&reference, pair.whole, pair.size, pair.display)
    });
    for (name, values, top, what) in
        [("difference.png", &errors, top, "relative error"), ("flip.png", &flip, 1.0, "FLIP")]
    {
        let path = out.join(name);
        png::write(&path, &false_colour::map(width, height, values, top)?)?;
        say::line(format!("{} ({what}, from black at 0 to pale yellow at {top})", path.display()));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use clap::Parser;
    use sglow_report::picture::{Layer, Picture, exr};

    use super::*;

    #[derive(Debug, Parser)]
    struct Line {
        #[command(flatten)]
        arguments: Arguments,
    }

    fn line(words: &[String]) -> Arguments {
        let words = ["compare".to_owned()].into_iter().chain(words.iter().cloned());
        Line::try_parse_from(words).unwrap().arguments
    }

    struct Files {
        folder: tempfile::TempDir,
    }

    impl Files {
        fn new() -> Self {
            Self { folder: tempfile::tempdir().unwrap() }
        }

        fn path(&self, name: &str) -> String {
            self.folder.path().join(name).to_string_lossy().into_owned()
        }

        /// Indirect light of `light` on three pixels, the last without a surface.
        fn exr(&self, name: &str, light: [f32; 3]) -> String {
            let image = |values: [f32; 3]| {
                Image::new(3, 1, values.map(|value| [value; 3]).to_vec()).unwrap()
            };
            let layers = vec![
                (Layer::Direct, image([1.0; 3])),
                (Layer::IndirectDiffuse, image(light)),
                (Layer::IndirectSpecular, image([0.0; 3])),
                (Layer::Normal, image([1.0, 1.0, 0.0])),
            ];
            let path = self.path(name);
            exr::write(path.as_ref(), &Picture::new(layers).unwrap(), "a test").unwrap();
            path
        }

        fn error(&self, words: &[String]) -> Result<PictureError> {
            load(&line(words)).map(|loaded| loaded.with(compare))
        }
    }

    #[test]
    fn layers_are_compared_where_there_is_a_surface() {
        let files = Files::new();
        let tested = files.exr("a.exr", [1.0, 3.0, 9.0]);
        let reference = files.exr("b.exr", [2.0, 2.0, 0.0]);
        let words = [tested.clone(), reference.clone()];
        let error = files.error(&words).unwrap();
        assert_eq!((error.pixels, error.rmse_over_mean, error.bias), (2, 0.5, 0.0));
        let direct = files.error(&[words.as_slice(), &["--layer=direct".into()]].concat()).unwrap();
        assert_eq!((direct.rmse_over_mean, direct.flip), (0.0, 0.0));
        let sum = files.error(&[words.as_slice(), &["--layer=radiance".into()]].concat()).unwrap();
        assert!((sum.rmse_over_mean - 1.0 / 3.0).abs() < 1e-6);
        // FLIP of indirect light is that of all that is seen with it.
        assert_eq!(sum.flip, error.flip);
        // Halves whose noise cancels: the squared error is free of it, and has an uncertainty.
        let [low, high] = [[1.5, 2.5, 0.0], [2.5, 1.5, 0.0]];
        let words =
            [tested, files.exr("1.exr", low), "--half".to_owned(), files.exr("2.exr", high)];
        let halves = files.error(&words).unwrap();
        let expected = (0.5 * (-0.5 * -1.5 + 0.5 * 1.5) / 4.0_f64).sqrt();
        assert!((halves.rmse_over_mean - expected).abs() < 1e-6, "{halves:?}");
        assert!(halves.uncertainty.rmse_over_mean > 0.0);
    }

    #[test]
    fn what_is_wrong_with_the_files_is_named() {
        let files = Files::new();
        let one = files.exr("a.exr", [1.0, 2.0, 3.0]);
        let wrong = |words: &[String]| files.error(words).unwrap_err().to_string();
        let missing = wrong(&[one.clone(), one.clone(), "--layer=depth".to_owned()]);
        assert!(missing.contains("no layer 'depth'") && missing.contains("direct, "), "{missing}");
        assert!(missing.contains("indirect"), "{missing}");
        let odd = files.exr("odd.exr", [1.0, f32::NAN, 3.0]);
        let text = wrong(&[one.clone(), odd]);
        assert!(
            text.contains("1 pixels are not finite") && text.contains("column 1, row 0"),
            "{text}"
        );
        // Where there is no surface nothing counts.
        let beyond = files.exr("beyond.exr", [1.0, 2.0, f32::INFINITY]);
        assert!(files.error(&[one.clone(), beyond]).is_ok());
        let small = files.path("small.png");
        image::RgbImage::new(2, 1).save(&small).unwrap();
        let text = wrong(&[one.clone(), small, "--layer=direct".to_owned()]);
        assert!(text.contains("no layer 'direct'") && text.contains("without a name"), "{text}");
        let large = files.path("large.hdr");
        image::Rgb32FImage::new(5, 4).save(&large).unwrap();
        let text = wrong(&[one.clone(), large]);
        assert!(text.contains("3 x 1") && text.contains("5 x 4"), "{text}");
        assert!(wrong(&[one, files.path("none.exr")]).contains("cannot read"));
    }

    #[test]
    fn numbers_and_pictures_are_written_and_a_bound_fails() {
        let files = Files::new();
        let tested = files.exr("a.exr", [1.0, 3.0, 9.0]);
        let reference = files.exr("b.exr", [2.0, 2.0, 0.0]);
        let words = [tested, reference, "--out".to_owned(), files.path("out")];
        run(&line(&words)).unwrap();
        let json = std::fs::read(files.folder.path().join("out/compare.json")).unwrap();
        let json: serde_json::Value = serde_json::from_slice(&json).unwrap();
        assert_eq!(json["error"]["rmse_over_mean"], 0.5);
        assert_eq!(json["layer"], "indirect");
        for name in ["difference.png", "flip.png"] {
            assert_eq!(image::open(files.folder.path().join("out").join(name)).unwrap().width(), 3);
        }
        let bound = |most: &str| {
            let more = ["--metric", "rmse", "--at-most", most].map(str::to_owned);
            run(&line(&[words.as_slice(), &more].concat()))
        };
        bound("50%").unwrap();
        assert!(bound("0.49").unwrap_err().to_string().contains("RMSE over the mean"));
    }

    /// What `render` says of a picture is what `compare` says of the files that it wrote, and what `report` and `choose`
    /// say of the same light; `reproduce` calls what `render` does.
    #[test]
    fn every_command_has_the_same_numbers_for_the_same_pair() {
        use sglow_measure::frontier::evaluate::Evaluator;
        use sglow_measure::frontier::subject::Subject;
        use sglow_measure::frontier::truth::Truth;
        use sglow_oracle::metrics;
        use sglow_results::frontier::document::Reference;
        use sglow_results::picture_error::mean;

        use crate::command::render;
        use crate::shot::{self, Numbers, Shot};

        #[derive(Debug, Parser)]
        struct Render {
            #[command(flatten)]
            arguments: render::Arguments,
        }

        let files = Files::new();
        let package = concat!(env!("CARGO_MANIFEST_DIR"), "/../shaders/packages/sglow");
        let ours = files.path("ours.exr");
        let (scene, size, lights, rsm) = ("cornell", [24, 18], 16, 32);
        let words = format!(
            "render --scene {scene} --size 24x18 --lights {lights} --rsm {rsm} --reference path --samples 64 \
             --package {package} --out {ours}"
        );
        render::run(&Render::try_parse_from(words.split(' ')).unwrap().arguments).unwrap();
        let json = std::fs::read(files.path("ours.json")).unwrap();
        let json: serde_json::Value = serde_json::from_slice(&json).unwrap();
        let rendered: PictureError = serde_json::from_value(json["against_paths"].clone()).unwrap();

        let [one, other] = ["1", "2"].map(|half| files.path(&format!("ours.reference.{half}.exr")));
        let words = [ours.clone(), one.clone(), "--half".to_owned(), other.clone()];
        let compared = files.error(&words).unwrap();

        let light = |path: &str| -> Radiance {
            let read = Read::new(path.as_ref()).unwrap();
            read.layer(INDIRECT).unwrap().pixels().to_vec()
        };
        let (picture, halves) = (light(&ours), [light(&one), light(&other)]);
        let numbers = Numbers { lights: Some(lights), rsm: Some(rsm), ..Numbers::default() };
        let shot = Shot::new(scene, &[], size, &numbers).unwrap();
        let (gpu, package) =
            (shot::gpu(&numbers).unwrap(), sglow_runtime::package::Package::embedded());
        let subject = Subject::new(&gpu, &package, &shot.scene, shot.settings.clone());
        let drawn = subject.drawn().unwrap();
        let position = &drawn.frame.gbuffer.position;
        let truth = Truth {
            reference: Reference { samples: 64, mean: 1.0, noise_over_mean: 0.0, dark: false },
            indirect: mean(halves.each_ref()),
            halves,
            unshadowed: Vec::new(),
            present: (0..position.len()).filter(|&at| position[at][3] >= 0.0).collect(),
            sample: Vec::new(),
            points: Vec::new(),
        };
        let evaluator = Evaluator::new(&subject, &truth, &drawn.frame, drawn.renderer.eye());
        let reported = evaluator.picture(&picture);

        assert!(rendered.pixels > 0 && rendered.pixels < 24 * 18, "some pixels show no surface");
        for metric in Metric::ALL {
            let [one, two, three] =
                [rendered, compared, reported].map(|error| error.measured(metric));
            for other in [two, three] {
                let near = |a: f64, b: f64| (a - b).abs() <= 1e-5 * a.abs().max(1e-3);
                assert!(near(one.value, other.value), "{metric}: {one:?} {other:?}");
                assert!(near(one.uncertainty, other.uncertainty), "{metric}: {one:?} {other:?}");
            }
            assert!(one.value != 0.0 && one.uncertainty > 0.0, "{metric}: {one:?}");
        }
        // Over all pixels, as once, the number is another.
        let [one, other] = truth.halves.each_ref().map(Vec::as_slice);
        let all = metrics::compare(&picture, [one, other], None).unwrap().rmse_over_mean().value;
        assert!((all / rendered.rmse_over_mean - 1.0).abs() > 0.02, "{all} {rendered:?}");
    }
}
