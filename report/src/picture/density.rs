//! Images as densities: the luminance of every pixel.

use std::path::Path;

use sglow_oracle::fis::stress::Stress;

use crate::failure::{Failure, Result};
use crate::picture::read::{Read, decoded};

/// The seed of built-in densities: those of `report`.
const SEED: u64 = 1;

/// The sum of all texels at most: a thousandth of the largest number of 32 bits, for products with it are added up.
const LARGEST: f64 = 3e35;

/// A density of any size.
#[derive(Clone, Debug, PartialEq)]
pub struct Density {
    /// A built-in name or the file's name without its folder.
    pub name: String,
    /// Width and height in pixels.
    pub size: [usize; 2],
    /// Luminance of linear light, row by row from the top, each at least 0 and finite.
    pub texels: Vec<f32>,
}

impl Density {
    /// A built-in density of `side` squared texels by its name, or a file: .exr, .hdr, .png. Of the first, `layer` is the one
    /// that is read; without it, the channels that are of no layer, or the only layer.
    ///
    /// # Errors
    ///
    /// When there is neither, the file cannot be read, it has several layers or not that one, or a pixel is negative or not
    /// finite.
    pub fn load(name_or_path: &str, side: usize, layer: Option<&str>) -> Result<Self> {
        if let Some((name, stress)) = Stress::ALL.iter().find(|(name, _)| *name == name_or_path) {
            if layer.is_some() {
                return Err(no_layers(name_or_path));
            }
            let texels = stress.texels(side, SEED);
            return Ok(Self { name: (*name).to_owned(), size: [side; 2], texels });
        }
        let path = Path::new(name_or_path);
        let extension = path.extension().map(|word| word.to_string_lossy().to_lowercase());
        let (size, pixels) = match extension.as_deref() {
            Some("exr") => exr_pixels(path, layer)?,
            Some("hdr" | "png") if layer.is_some() => return Err(no_layers(name_or_path)),
            Some("hdr") => decoded(path, false)?,
            Some("png") => decoded(path, true)?,
            _ => {
                let names: Vec<&str> = Stress::ALL.iter().map(|(name, _)| *name).collect();
                return Err(Failure::new(format!("there is no density '{name_or_path}'"))
                    .help(format!("built-in densities: {}", names.join(", ")))
                    .help("or a file: .exr, .hdr, .png"));
            }
        };
        let name = path.file_name().map(|name| name.to_string_lossy().into_owned());
        Self::of_pixels(name.unwrap_or_default(), size, &pixels)
            .map_err(|failure| Failure::new(format!("{name_or_path}: {failure}")))
    }

    /// The luminance of linear pixels.
    fn of_pixels(name: String, size: [usize; 2], pixels: &[[f32; 3]]) -> Result<Self, String> {
        if pixels.is_empty() || size[0] * size[1] != pixels.len() {
            return Err("the image has no pixels".to_owned());
        }
        let mut texels = Vec::with_capacity(pixels.len());
        for (index, pixel) in pixels.iter().enumerate() {
            let [r, g, b] = pixel.map(f64::from);
            let luminance = (0.2126 * r + 0.7152 * g + 0.0722 * b) as f32;
            if !(pixel.iter().all(|part| *part >= 0.0) && luminance.is_finite()) {
                let (x, y) = (index % size[0], index / size[0]);
                return Err(format!(
                    "pixel ({x}, {y}) is ({r}, {g}, {b}); a density has to be finite and at least 0"
                ));
            }
            texels.push(luminance);
        }
        let total: f64 = texels.iter().copied().map(f64::from).sum();
        if total > LARGEST {
            return Err(format!(
                "the sum of all pixels is {total:e}, and numbers of 32 bits hold sums up to {LARGEST:e}; scale the image"
            ));
        }
        Ok(Self { name, size, texels })
    }
}

fn no_layers(of: &str) -> Failure {
    Failure::new(format!("{of}: has no layers")).help("--layer is for OpenEXR files")
}

/// Linear pixels of a layer of an OpenEXR file: the one that is named, else the channels without a layer, else the only
/// layer.
fn exr_pixels(path: &Path, layer: Option<&str>) -> Result<([usize; 2], Vec<[f32; 3]>)> {
    let place = path.display();
    let read = Read::new(path)?;
    let image = match (layer, read.layers.as_slice()) {
        (Some(name), _) => read.layer(name),
        (None, [(_, only)]) => Some(only.clone()),
        (None, _) => read.layer(""),
    };
    let image = image.ok_or_else(|| {
        let what = layer.map_or_else(
            || "several layers may be the density".to_owned(),
            |name| format!("no layer '{name}'"),
        );
        Failure::new(format!("{place}: {what}"))
            .help(format!("--layer takes one of: {}", read.names().join(", ")))
    })?;
    Ok(([image.width(), image.height()], image.pixels().to_vec()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::picture::{Image, Layer, Picture};

    fn error(result: Result<Density>) -> String {
        result.unwrap_err().to_string()
    }

    #[test]
    fn built_in_densities_have_names_and_a_wrong_name_lists_them() {
        let ring = Density::load("ring", 16, None).unwrap();
        assert_eq!((ring.size, ring.texels.len()), ([16, 16], 256));
        let text = error(Density::load("rong", 16, None));
        assert!(text.contains("'rong'") && text.contains("smooth, checkerboard"), "{text}");
        assert!(
            error(Density::load("/no/such.hdr", 16, None)).contains("/no/such.hdr: cannot read")
        );
    }

    #[test]
    fn files_give_the_luminance_of_linear_light() {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name).to_string_lossy().into_owned();
        let red = image::RgbImage::from_pixel(3, 2, image::Rgb([128, 0, 0]));
        red.save(path("red.png")).unwrap();
        let found = Density::load(&path("red.png"), 8, None).unwrap();
        assert_eq!((found.size, found.name.as_str()), ([3, 2], "red.png"));
        assert!((found.texels[5] - 0.2126 * 0.215_860_5).abs() < 1e-6);
        image::GrayImage::from_pixel(2, 5, image::Luma([128])).save(path("grey.png")).unwrap();
        let found = Density::load(&path("grey.png"), 8, None).unwrap();
        assert!(found.size == [2, 5] && (found.texels[9] - 0.215_860_5).abs() < 1e-6);

        let pixels = vec![[1.0, 2.0, 0.5]; 6];
        let layer = Image::new(2, 3, pixels.clone()).unwrap();
        let picture = Picture::new(vec![(Layer::Direct, layer)]).unwrap();
        crate::picture::exr::write(path("linear.exr").as_ref(), &picture, "a test").unwrap();
        let found = Density::load(&path("linear.exr"), 8, None).unwrap();
        let expected = 0.2126 + 2.0 * 0.7152 + 0.5 * 0.0722;
        assert!(found.size == [2, 3] && (found.texels[4] - expected).abs() < 1e-6);
        let hdr = image::Rgb32FImage::from_pixel(2, 3, image::Rgb([1.0, 2.0, 0.5]));
        hdr.save(path("linear.hdr")).unwrap();
        let found = Density::load(&path("linear.hdr"), 8, None).unwrap();
        // Radiance files have eight bits of the brightest channel.
        assert!(found.size == [2, 3] && (found.texels[4] - expected).abs() < 0.02);
    }

    /// A case of the repository.
    fn case(name: &str) -> String {
        format!("{}/tests/cases/{name}", env!("CARGO_MANIFEST_DIR"))
    }

    #[test]
    fn channels_without_a_layer_are_the_picture() {
        let plain = Density::load(&case("exr_rgb.exr"), 8, None).unwrap();
        let file = case("exr_extra_layer_first.exr");
        let found = Density::load(&file, 8, None).unwrap();
        assert_eq!((found.size, &found.texels), (plain.size, &plain.texels));
        // Negative control: the layer that comes first is another one.
        let other = Density::load(&file, 8, Some("AO")).unwrap();
        assert_ne!(other.texels, plain.texels);
        let text = error(Density::load(&file, 8, Some("albedo")));
        assert!(text.contains("no layer 'albedo'") && text.contains("one of: AO"), "{text}");
        let text = error(Density::load("ring", 8, Some("AO")));
        assert!(text.contains("ring: has no layers"), "{text}");
    }

    #[test]
    fn several_layers_are_listed_and_one_is_enough() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("layers.exr").to_string_lossy().into_owned();
        let image = |value: f32| Image::new(2, 1, vec![[value; 3]; 2]).unwrap();
        let two = vec![(Layer::Direct, image(1.0)), (Layer::IndirectDiffuse, image(2.0))];
        crate::picture::exr::write(path.as_ref(), &Picture::new(two).unwrap(), "").unwrap();
        let text = error(Density::load(&path, 8, None));
        for part in ["several layers", "--layer takes one of: direct, indirect_diffuse, radiance"] {
            assert!(text.contains(part), "{text}");
        }
        let sum = Density::load(&path, 8, Some("radiance")).unwrap();
        assert!((sum.texels[0] - 3.0).abs() < 1e-6);
        let one = vec![(Layer::IndirectDiffuse, image(2.0))];
        crate::picture::exr::write(path.as_ref(), &Picture::new(one).unwrap(), "").unwrap();
        assert!((Density::load(&path, 8, None).unwrap().texels[0] - 2.0).abs() < 1e-6);
    }

    #[test]
    fn a_pixel_that_is_no_density_is_named() {
        for (wrong, shown) in [(-1.0, "-1"), (f32::NAN, "NaN"), (f32::INFINITY, "inf")] {
            let mut pixels = vec![[0.5; 3]; 12];
            pixels[7][1] = wrong;
            let text = Density::of_pixels(String::new(), [4, 3], &pixels).unwrap_err();
            assert!(text.contains("pixel (3, 1)") && text.contains(shown), "{text}");
        }
        assert!(Density::of_pixels(String::new(), [0, 0], &[]).is_err());
        let huge = |value: f32| Density::of_pixels(String::new(), [2, 1], &[[value; 3]; 2]);
        assert!(huge(1e35).is_ok() && huge(2e35).unwrap_err().contains("sum of all pixels"));
        let zero = Density::of_pixels(String::new(), [1, 1], &[[0.0; 3]]).unwrap();
        assert_eq!(zero.texels, [0.0]);
    }
}
