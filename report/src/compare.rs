//! Two pictures that are compared: files, their layers, the pixels that count.

use std::path::Path;

use sglow_results::picture_error::{
    Display, Pair, PictureError, Radiance, flip_map, mean, relative_errors,
};

use crate::failure::{self, Failure, Result};
use crate::picture::read::{INDIRECT, RADIANCE, Read};
use crate::picture::{Image, false_colour, png};

/// The files that are compared.
#[derive(Clone, Copy, Debug)]
pub struct Files<'a> {
    /// The picture that is tested.
    pub tested: &'a Path,
    /// Its reference.
    pub reference: &'a Path,
    /// The reference and this picture are independent halves of it.
    pub half: Option<&'a Path>,
    /// The layer that is compared, if one is requested.
    pub layer: Option<&'a str>,
}

/// Pictures that can be compared.
pub struct Loaded {
    /// The layer that is compared.
    pub layer: String,
    /// What some files are converted to, a line each.
    pub notes: Vec<String>,
    tested: Image,
    halves: [Image; 2],
    whole: Image,
    whole_halves: [Image; 2],
    /// Pixels that count, and how they are known.
    pub present: Option<(Vec<usize>, &'static str)>,
    display: Display,
}

impl Loaded {
    /// Compares them, with what `pair` makes of both.
    pub fn with<T>(&self, of: impl Fn(&Pair<'_>) -> T) -> T {
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

    /// Width and height.
    #[must_use]
    pub fn size(&self) -> [u32; 2] {
        [self.tested.width(), self.tested.height()].map(|side| side as u32)
    }
}

/// Reads the pictures and takes the layers.
///
/// # Errors
///
/// When a picture cannot be read, lacks the layer or has another size, or a number is not finite.
pub fn load(files: &Files<'_>) -> Result<Loaded> {
    let second = files.half;
    let mut notes = Vec::new();
    let mut paths = vec![files.tested, files.reference];
    paths.extend(second);
    let read = failure::all(paths.iter().map(|path| Read::new(path)).collect())?;
    for (path, _) in paths.iter().zip(&read).filter(|(_, read)| read.converted) {
        notes.push(format!("{}: converted from sRGB to linear light", path.display()));
    }
    let indirect = read.iter().all(|read| read.layer(INDIRECT).is_some());
    let layer = match files.layer {
        Some(layer) => Some(layer.to_owned()),
        None => indirect.then(|| INDIRECT.to_owned()),
    };
    let chosen = |(path, read): (&&Path, &Read)| -> Result<Image> {
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
    let names = [files.tested, files.reference, second.unwrap_or(files.reference)];
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
        notes,
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

/// The relative error and FLIP of every pixel in false colour.
///
/// # Errors
///
/// When a picture cannot be written.
pub fn draw(out: &Path, loaded: &Loaded, error: &PictureError) -> Result<Vec<String>> {
    let mut lines = Vec::new();
    let [width, height] = loaded.size();
    // A round number that most pixels are below.
    let top = [0.05_f32, 0.1, 0.2, 0.5].into_iter().find(|top| error.q95 <= f64::from(*top));
    let top = top.unwrap_or(1.0);
    let errors = loaded.with(relative_errors);
    let flip = loaded.with(|pair| {
        let reference = mean(pair.whole_halves);
        flip_map(&reference, pair.whole, pair.size, pair.display)
    });
    for (name, values, top, what) in
        [("difference.png", &errors, top, "relative error"), ("flip.png", &flip, 1.0, "FLIP")]
    {
        let path = out.join(name);
        png::write(&path, &false_colour::map(width, height, values, top)?)?;
        lines.push(format!("{} ({what}, from black at 0 to pale yellow at {top})", path.display()));
    }
    Ok(lines)
}

#[cfg(test)]
mod tests {
    use sglow_results::picture_error::compare;

    use super::*;
    use crate::picture::{Layer, Picture, exr};

    struct Folder {
        folder: tempfile::TempDir,
    }

    impl Folder {
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
    }

    /// The error of the first file against the second, and the third if there is one.
    fn of(paths: &[&str], layer: Option<&str>) -> Result<PictureError> {
        let files = Files {
            tested: Path::new(paths[0]),
            reference: Path::new(paths[1]),
            half: paths.get(2).map(Path::new),
            layer,
        };
        load(&files).map(|loaded| loaded.with(compare))
    }

    #[test]
    fn layers_are_compared_where_there_is_a_surface() {
        let files = Folder::new();
        let tested = files.exr("a.exr", [1.0, 3.0, 9.0]);
        let reference = files.exr("b.exr", [2.0, 2.0, 0.0]);
        let pair = [tested.as_str(), &reference];
        let error = of(&pair, None).unwrap();
        assert_eq!((error.pixels, error.rmse_over_mean, error.bias), (2, 0.5, 0.0));
        let direct = of(&pair, Some("direct")).unwrap();
        assert_eq!((direct.rmse_over_mean, direct.flip), (0.0, 0.0));
        let sum = of(&pair, Some("radiance")).unwrap();
        assert!((sum.rmse_over_mean - 1.0 / 3.0).abs() < 1e-6);
        // FLIP of indirect light is that of all that is seen with it.
        assert_eq!(sum.flip, error.flip);
        // Halves whose noise cancels: the squared error is free of it, and has an uncertainty.
        let [low, high] = [[1.5, 2.5, 0.0], [2.5, 1.5, 0.0]];
        let [one, other] = [files.exr("1.exr", low), files.exr("2.exr", high)];
        let halves = of(&[&tested, &one, &other], None).unwrap();
        let expected = (0.5 * (-0.5 * -1.5 + 0.5 * 1.5) / 4.0_f64).sqrt();
        assert!((halves.rmse_over_mean - expected).abs() < 1e-6, "{halves:?}");
        assert!(halves.uncertainty.rmse_over_mean > 0.0);
    }

    #[test]
    fn what_is_wrong_with_the_files_is_named() {
        let files = Folder::new();
        let one = files.exr("a.exr", [1.0, 2.0, 3.0]);
        let wrong =
            |other: &str, layer: Option<&str>| of(&[&one, other], layer).unwrap_err().to_string();
        let missing = wrong(&one, Some("depth"));
        assert!(missing.contains("no layer 'depth'") && missing.contains("direct, "), "{missing}");
        assert!(missing.contains("indirect"), "{missing}");
        let odd = files.exr("odd.exr", [1.0, f32::NAN, 3.0]);
        let text = wrong(&odd, None);
        assert!(
            text.contains("1 pixels are not finite") && text.contains("column 1, row 0"),
            "{text}"
        );
        // Where there is no surface nothing counts.
        let beyond = files.exr("beyond.exr", [1.0, 2.0, f32::INFINITY]);
        assert!(of(&[&one, &beyond], None).is_ok());
        let small = files.path("small.png");
        image::RgbImage::new(2, 1).save(&small).unwrap();
        let text = wrong(&small, Some("direct"));
        assert!(text.contains("no layer 'direct'") && text.contains("without a name"), "{text}");
        let large = files.path("large.hdr");
        image::Rgb32FImage::new(5, 4).save(&large).unwrap();
        let text = wrong(&large, None);
        assert!(text.contains("3 x 1") && text.contains("5 x 4"), "{text}");
        assert!(wrong(&files.path("none.exr"), None).contains("cannot read"));
    }
}
