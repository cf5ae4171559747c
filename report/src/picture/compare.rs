//! Pictures that set one image against another.

use image::{Rgb, RgbImage};

use crate::failure::{Failure, Result};
use crate::picture::{Image, luminance};

/// Colour between pictures that stand side by side.
const GAP: Rgb<u8> = Rgb([128, 128, 128]);
/// Pixels between them.
const GAP_WIDTH: u32 = 4;

/// The pictures from left to right, aligned at the top.
pub fn side_by_side(pictures: &[&RgbImage]) -> RgbImage {
    let gaps = GAP_WIDTH * (pictures.len() as u32).saturating_sub(1);
    let width = gaps + pictures.iter().map(|picture| picture.width()).sum::<u32>();
    let height = pictures.iter().map(|picture| picture.height()).max().unwrap_or(0);
    let mut sheet = RgbImage::from_pixel(width, height, GAP);
    let mut left = 0;
    for picture in pictures {
        image::imageops::replace(&mut sheet, *picture, i64::from(left), 0);
        left += picture.width() + GAP_WIDTH;
    }
    sheet
}

/// Where `tested` differs from `reference` in luminance: red where it is too bright, blue where too dark, white where
/// equal; full colour at a difference of `scale`, in the unit of the images. A number that is not finite is black.
///
/// # Errors
///
/// When the sizes differ or `scale` is not positive.
pub fn difference(tested: &Image, reference: &Image, scale: f32) -> Result<RgbImage> {
    if (tested.width(), tested.height()) != (reference.width(), reference.height()) {
        return Err(Failure::new(format!(
            "a picture of {} x {} cannot be compared with one of {} x {}",
            tested.width(),
            tested.height(),
            reference.width(),
            reference.height()
        )));
    }
    if !(scale > 0.0 && scale.is_finite()) {
        return Err(Failure::new(format!(
            "the scale of differences has to be positive, not {scale}"
        )));
    }
    let width = tested.width();
    Ok(RgbImage::from_fn(width as u32, tested.height() as u32, |x, y| {
        let at = y as usize * width + x as usize;
        diverging((luminance(tested.pixels()[at]) - luminance(reference.pixels()[at])) / scale)
    }))
}

/// From blue at -1 over white at 0 to red at 1.
fn diverging(value: f32) -> Rgb<u8> {
    if !value.is_finite() {
        return Rgb([0, 0, 0]);
    }
    let end = if value < 0.0 { [33, 90, 172] } else { [178, 24, 43] };
    let amount = value.abs().min(1.0);
    Rgb(end.map(|channel| (255.0 - amount * (255.0 - channel as f32)).round() as u8))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn differences_have_a_sign_and_equal_pictures_are_white() {
        let image = |values: [f32; 3]| Image::new(3, 1, values.map(|v| [v; 3]).to_vec()).unwrap();
        let shown = difference(&image([1.0, 3.0, f32::NAN]), &image([2.0, 2.0, 2.0]), 1.0).unwrap();
        let at = |x| shown.get_pixel(x, 0).0;
        assert!(at(0)[2] > at(0)[0] && at(1)[0] > at(1)[2] && at(2) == [0; 3]);
        let same = image([1.0, 2.0, 3.0]);
        let white = difference(&same, &same, 1.0).unwrap();
        assert!(white.pixels().all(|pixel| pixel.0 == [255; 3]));
        let single = Image::new(1, 1, vec![[0.0; 3]]).unwrap();
        assert!(difference(&same, &single, 1.0).is_err());
        assert!(difference(&same, &same, 0.0).is_err());
    }

    #[test]
    fn pictures_stand_side_by_side() {
        let black = RgbImage::new(3, 2);
        let white = RgbImage::from_pixel(2, 4, Rgb([255; 3]));
        let sheet = side_by_side(&[&black, &white]);
        assert_eq!(sheet.dimensions(), (3 + GAP_WIDTH + 2, 4));
        assert_eq!(sheet.get_pixel(0, 0).0, [0; 3]);
        assert_eq!(*sheet.get_pixel(0, 3), GAP);
        assert_eq!(*sheet.get_pixel(3, 0), GAP);
        assert_eq!(sheet.get_pixel(3 + GAP_WIDTH, 3).0, [255; 3]);
    }
}
