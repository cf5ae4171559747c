//! Kernels drawn over their density, as Fig. 1 of [Tokuyoshi 2016] shows them.

use image::{Rgb, RgbImage};
use sglow_results::kernels::Square;

use crate::failure::Result;
use crate::picture::density::Density;
use crate::picture::{Image, tone};

/// Outlines of kernels.
const OUTLINE: Rgb<u8> = Rgb([255, 140, 26]);
/// Centres of kernels.
const CENTRE: Rgb<u8> = Rgb([226, 22, 32]);
/// The brightest grey of a density: outlines have to stand out before it.
const BRIGHTEST: f32 = 0.82;
/// The longer side of a picture has at least this many pixels.
const LEAST_SIDE: usize = 1200;
/// How much an outline covers where it lies; many of them overlap.
const OPACITY: f32 = 0.85;

/// How many pixels of a picture a pixel of the density becomes, along each side.
pub fn scale([width, height]: [usize; 2]) -> usize {
    LEAST_SIDE.div_ceil(width.max(height).max(1))
}

/// The density in grey with outlines and centres of kernels.
///
/// # Errors
///
/// When the density has no pixels.
pub fn draw(density: &Density, kernels: &[Square]) -> Result<RgbImage> {
    let [width, height] = density.size;
    let scale = scale(density.size);
    let grey = Image::new(width, height, density.texels.iter().map(|&texel| [texel; 3]).collect())?;
    let shown = tone::radiance(&grey, tone::Exposure::automatic(grey.pixels()));
    let mut picture = RgbImage::from_fn((width * scale) as u32, (height * scale) as u32, |x, y| {
        let Rgb(pixel) = *shown.get_pixel(x / scale as u32, y / scale as u32);
        Rgb(pixel.map(|channel| (BRIGHTEST * f32::from(channel)).round() as u8))
    });
    let longer = width.max(height) * scale;
    // Thin lines and small points where kernels are many.
    let (lines, points) = match kernels.len() {
        0..=256 => (400, 350.0),
        257..=2048 => (640, 500.0),
        _ => (longer, 800.0),
    };
    let line = (longer / lines).max(1) as i64;
    let radius = longer as f64 / points;
    // Large ones first, so that small ones are not hidden.
    let mut order: Vec<&Square> = kernels.iter().collect();
    order.sort_by(|a, b| b.side.total_cmp(&a.side));
    for kernel in &order {
        outline(&mut picture, kernel, scale as f64, line);
    }
    for kernel in &order {
        dot(&mut picture, kernel.centre.map(|part| part * scale as f64), radius);
    }
    Ok(picture)
}

/// Frames the pixels whose centres lie within a square, along the inside; at least one pixel.
fn outline(picture: &mut RgbImage, kernel: &Square, scale: f64, line: i64) {
    let edge = |axis: usize, sign: f64| {
        ((kernel.centre[axis] + sign * 0.5 * kernel.side) * scale).round() as i64
    };
    let ([left, top], [right, bottom]) =
        ([edge(0, -1.0), edge(1, -1.0)], [edge(0, 1.0) - 1, edge(1, 1.0) - 1]);
    let (right, bottom) = (right.max(left), bottom.max(top));
    let [width, height] = [picture.width(), picture.height()].map(i64::from);
    for y in top.max(0)..=bottom.min(height - 1) {
        let whole = y < top + line || y > bottom - line;
        for x in left.max(0)..=right.min(width - 1) {
            if whole || x < left + line || x > right - line {
                cover(picture, [x, y], OUTLINE, OPACITY);
            }
        }
    }
}

/// A disc with a soft edge.
fn dot(picture: &mut RgbImage, [x, y]: [f64; 2], radius: f64) {
    let reach = radius.ceil() as i64 + 1;
    let [width, height] = [picture.width(), picture.height()].map(i64::from);
    for row in (y as i64 - reach).max(0)..=(y as i64 + reach).min(height - 1) {
        for column in (x as i64 - reach).max(0)..=(x as i64 + reach).min(width - 1) {
            let distance = (column as f64 + 0.5 - x).hypot(row as f64 + 0.5 - y);
            let amount = (radius + 0.5 - distance).clamp(0.0, 1.0) as f32;
            if amount > 0.0 {
                cover(picture, [column, row], CENTRE, amount);
            }
        }
    }
}

fn cover(picture: &mut RgbImage, [x, y]: [i64; 2], color: Rgb<u8>, amount: f32) {
    let pixel = picture.get_pixel_mut(x as u32, y as u32);
    for (below, above) in pixel.0.iter_mut().zip(color.0) {
        let blended = f32::from(*below) * (1.0 - amount) + f32::from(above) * amount;
        *below = blended.round() as u8;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn black(size: [usize; 2]) -> Density {
        Density { name: String::new(), size, texels: vec![0.0; size[0] * size[1]] }
    }

    fn is_outline(pixel: &Rgb<u8>) -> bool {
        pixel.0[0] > 150 && pixel.0[1] > 80
    }

    #[test]
    fn a_kernel_has_its_outline_where_it_is() {
        let kernel = Square { centre: [6.0, 4.0], side: 4.0 };
        let picture = draw(&black([16, 8]), &[kernel]).unwrap();
        assert_eq!(scale([16, 8]), 75);
        assert_eq!(picture.dimensions(), (16 * 75, 8 * 75));
        // From 4 to 8 in x, from 2 to 6 in y.
        let found: Vec<(u32, u32)> = picture
            .enumerate_pixels()
            .filter(|(_, _, pixel)| is_outline(pixel))
            .map(|(x, y, _)| (x, y))
            .collect();
        let bounds = |part: fn(&(u32, u32)) -> u32| {
            let values = found.iter().map(part);
            (values.clone().min().unwrap(), values.max().unwrap())
        };
        assert_eq!(bounds(|at| at.0), (4 * 75, 8 * 75 - 1));
        assert_eq!(bounds(|at| at.1), (2 * 75, 6 * 75 - 1));
        // A frame three pixels wide, not a filled square.
        assert_eq!(found.len(), 300 * 300 - 294 * 294);
        assert!(is_outline(picture.get_pixel(4 * 75, 4 * 75)));
        assert!(!is_outline(picture.get_pixel(5 * 75, 4 * 75)));
        let centre = picture.get_pixel(6 * 75, 4 * 75);
        assert_eq!(*centre, CENTRE);
        // Negative control: moved by a pixel of the density it is elsewhere.
        let moved = Square { centre: [7.0, 4.0], ..kernel };
        let other = draw(&black([16, 8]), &[moved]).unwrap();
        assert!(!is_outline(other.get_pixel(4 * 75, 4 * 75)));
    }

    #[test]
    fn what_reaches_beyond_or_is_tiny_is_drawn_as_far_as_it_goes() {
        let kernels = [
            Square { centre: [0.0, 0.0], side: 6.0 },
            Square { centre: [3.99, 2.99], side: 64.0 },
            Square { centre: [2.5, 1.5], side: 1e-3 },
        ];
        let picture = draw(&black([4, 3]), &kernels).unwrap();
        assert_eq!(picture.dimensions(), (1200, 900));
        assert!(is_outline(picture.get_pixel(3 * 300 - 1, 100)));
        let empty = draw(&black([2048, 3]), &[]).unwrap();
        assert_eq!(empty.dimensions(), (2048, 3));
        assert!(empty.pixels().all(|pixel| pixel.0 == [0; 3]));
    }
}
