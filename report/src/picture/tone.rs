//! From radiance to what an 8-bit screen shows.
//!
//! The mapping of radiance is [`sglow_results::display`]'s.

use image::{Rgb, RgbImage};
pub use sglow_results::display::Exposure;
use sglow_results::display::srgb;

use crate::picture::{Image, Layer};

/// What stands for a number that is not finite.
const NOT_FINITE: Rgb<u8> = Rgb([255, 0, 255]);

/// Radiance as a person sees it.
pub fn radiance(image: &Image, exposure: Exposure) -> RgbImage {
    map(image, |pixel| exposure.shown(pixel))
}

/// A layer in the mapping that suits it: radiance by [`radiance()`], reflectance encoded alone, normals with -1 to 1 on
/// 0 to 1, positions with the box around all pixels on 0 to 1.
pub fn layer(layer: Layer, image: &Image, exposure: Exposure) -> RgbImage {
    match layer {
        Layer::Direct | Layer::IndirectDiffuse | Layer::IndirectSpecular | Layer::Emission => {
            radiance(image, exposure)
        }
        Layer::Albedo => map(image, |pixel| pixel.map(srgb)),
        Layer::Normal => {
            map(
                image,
                |pixel| {
                    if pixel == [0.0; 3] { pixel } else { pixel.map(|value| 0.5 * value + 0.5) }
                },
            )
        }
        Layer::Position => {
            let (low, high) = bounds(image);
            map(image, |pixel| {
                std::array::from_fn(|axis| {
                    let extent = high[axis] - low[axis];
                    if extent > 0.0 { (pixel[axis] - low[axis]) / extent } else { 0.0 }
                })
            })
        }
    }
}

fn bounds(image: &Image) -> ([f32; 3], [f32; 3]) {
    let finite = |pixel: &&[f32; 3]| pixel.iter().all(|value| value.is_finite());
    image.pixels().iter().filter(finite).fold(
        ([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]),
        |(low, high), pixel| {
            (
                std::array::from_fn(|axis| low[axis].min(pixel[axis])),
                std::array::from_fn(|axis| high[axis].max(pixel[axis])),
            )
        },
    )
}

/// Each pixel through `to_display`, whose numbers from 0 to 1 become bytes.
fn map(image: &Image, to_display: impl Fn([f32; 3]) -> [f32; 3]) -> RgbImage {
    let pixels = image.pixels();
    RgbImage::from_fn(image.width() as u32, image.height() as u32, |x, y| {
        let pixel = pixels[y as usize * image.width() + x as usize];
        if pixel.iter().any(|value| !value.is_finite()) {
            return NOT_FINITE;
        }
        Rgb(to_display(pixel).map(|value| (255.0 * value.clamp(0.0, 1.0)).round() as u8))
    })
}

#[cfg(test)]
mod tests {
    use sglow_results::display::{WHITE, curve};

    use super::*;

    fn row(pixels: &[[f32; 3]]) -> Image {
        Image::new(pixels.len(), 1, pixels.to_vec()).unwrap()
    }

    #[test]
    fn the_curve_runs_from_black_to_white_without_a_step() {
        let values: Vec<f32> = (0..=100).map(|i| curve(WHITE * i as f32 / 100.0)).collect();
        assert_eq!((values[0], values[100]), (0.0, 1.0));
        assert!(values.windows(2).all(|pair| pair[0] < pair[1] && pair[1] - pair[0] < 0.05));
    }

    #[test]
    fn exposure_follows_the_scale_of_the_radiance() {
        let dim = row(&[[0.0; 3], [0.01, 0.02, 0.03], [0.5; 3]]);
        let bright = row(&dim.pixels().iter().map(|p| p.map(|v| v * 1024.0)).collect::<Vec<_>>());
        let stops = |image: &Image| Exposure::automatic(image.pixels()).stops();
        assert!((stops(&dim) - stops(&bright) - 10.0).abs() < 1e-4);
        assert_eq!(
            radiance(&dim, Exposure::automatic(dim.pixels())),
            radiance(&bright, Exposure::automatic(bright.pixels()))
        );
        assert_ne!(
            radiance(&dim, Exposure::from_stops(0.0)),
            radiance(&bright, Exposure::from_stops(0.0))
        );
        assert_eq!(Exposure::automatic(&[[0.0; 3]]).stops(), 0.0);
    }

    #[test]
    fn each_layer_has_a_mapping_that_suits_it() {
        let one = Exposure::from_stops(0.0);
        let normal = layer(Layer::Normal, &row(&[[0.0, 1.0, -1.0], [0.0; 3]]), one);
        assert_eq!(normal.get_pixel(0, 0), &Rgb([128, 255, 0]));
        assert_eq!(normal.get_pixel(1, 0), &Rgb([0, 0, 0]));
        let position = layer(Layer::Position, &row(&[[-5.0, 2.0, 0.0], [5.0, 2.0, 8.0]]), one);
        assert_eq!(position.get_pixel(0, 0), &Rgb([0, 0, 0]));
        assert_eq!(position.get_pixel(1, 0), &Rgb([255, 0, 255]));
        let albedo = layer(Layer::Albedo, &row(&[[0.215_860_5, 0.0, 1.0]]), one);
        assert_eq!(albedo.get_pixel(0, 0), &Rgb([128, 0, 255]));
    }

    #[test]
    fn what_is_not_finite_shows() {
        let odd = row(&[[f32::NAN, 0.0, 0.0], [0.0, f32::INFINITY, 0.0]]);
        let shown = radiance(&odd, Exposure::automatic(odd.pixels()));
        assert!(shown.pixels().all(|pixel| *pixel == NOT_FINITE));
    }
}
