//! Numbers as colours, from black over purple to pale yellow: magma, whose lightness grows evenly, so that it can be read
//! without telling colours apart.

use image::{Rgb, RgbImage};

use crate::failure::{Failure, Result};

/// What stands for a number that is not finite: no colour of the map.
const NOT_FINITE: Rgb<u8> = Rgb([0, 255, 0]);

/// The colour of a share, 0 to 1; beyond is at the end.
pub fn colour(share: f64) -> [u8; 3] {
    let colour = colorous::MAGMA.eval_continuous(share.clamp(0.0, 1.0));
    [colour.r, colour.g, colour.b]
}

/// A picture of `values`, row by row from the top, with `top` and more at the bright end.
///
/// # Errors
///
/// When there are not `width * height` values, or none, or `top` is not positive.
pub fn map(width: u32, height: u32, values: &[f32], top: f32) -> Result<RgbImage> {
    let wanted = width as usize * height as usize;
    if values.is_empty() || values.len() != wanted {
        return Err(Failure::new(format!(
            "a map of {width} x {height} cannot have {} values",
            values.len()
        )));
    }
    if !(top > 0.0 && top.is_finite()) {
        return Err(Failure::new(format!(
            "the end of a colour scale has to be positive, not {top}"
        )));
    }
    Ok(RgbImage::from_fn(width, height, |x, y| {
        let value = values[(y * width + x) as usize];
        if value.is_finite() { Rgb(colour(f64::from(value / top))) } else { NOT_FINITE }
    }))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn larger_numbers_are_brighter_and_odd_ones_show() {
        let shown = map(4, 1, &[0.0, 0.2, 0.5, f32::NAN], 0.5).unwrap();
        let light = |x| shown.get_pixel(x, 0).0.iter().map(|part| u32::from(*part)).sum::<u32>();
        assert!(light(0) < light(1) && light(1) < light(2));
        assert_eq!(shown.get_pixel(3, 0), &NOT_FINITE);
        assert!((0..=1000).all(|step| Rgb(colour(f64::from(step) / 1000.0)) != NOT_FINITE));
    }

    #[test]
    fn sizes_and_scales_that_do_not_fit_are_refused() {
        assert!(map(2, 2, &[0.0; 3], 1.0).is_err());
        assert!(map(0, 2, &[], 1.0).is_err());
        assert!(map(1, 1, &[0.0], 0.0).is_err() && map(1, 1, &[0.0], f32::NAN).is_err());
    }
}
