//! Images made by code.

use crate::Image;

/// An sRGB image of `size` squared texels; `texel(x, y)` gives red, green, blue and alpha, 0 to 1,
/// still sRGB encoded, for the texel's centre from 0 to 1, y pointing down.
fn square(name: &str, size: u32, texel: impl Fn(f32, f32) -> [f32; 4]) -> Image {
    let centre = |i: u32| (i as f32 + 0.5) / size as f32;
    let rgba8 = (0..size)
        .flat_map(|y| (0..size).map(move |x| (x, y)))
        .flat_map(|(x, y)| texel(centre(x), centre(y)).map(|c| (c * 255.0).round() as u8))
        .collect();
    Image { name: name.to_owned(), width: size, height: size, rgba8, srgb: true }
}

/// White noise from 0 to 1 over the integers.
fn white(x: u32, y: u32) -> f32 {
    let mut bits = x.wrapping_mul(0x9e37_79b9) ^ y.wrapping_mul(0x85eb_ca6b);
    bits = (bits ^ (bits >> 15)).wrapping_mul(0x2c1b_3c6d);
    bits = (bits ^ (bits >> 12)).wrapping_mul(0x297a_2d39);
    ((bits ^ (bits >> 15)) >> 8) as f32 / 16_777_215.0
}

/// Smooth noise from 0 to 1 that repeats after `cells` in both directions.
fn smooth(x: f32, y: f32, cells: u32) -> f32 {
    let (x, y) = (x * cells as f32, y * cells as f32);
    let ease = |t: f32| t * t * (3.0 - 2.0 * t);
    let (column, row) = (x.floor() as u32, y.floor() as u32);
    let (u, v) = (ease(x.fract()), ease(y.fract()));
    let at = |i: u32, j: u32| white((column + i) % cells + cells * 131, (row + j) % cells);
    let upper = at(0, 0) + (at(1, 0) - at(0, 0)) * u;
    let lower = at(0, 1) + (at(1, 1) - at(0, 1)) * u;
    upper + (lower - upper) * v
}

/// Several octaves of [`smooth`].
fn cloudy(x: f32, y: f32) -> f32 {
    let octaves = [(4, 0.5), (8, 0.25), (16, 0.15), (32, 0.1)];
    octaves.iter().map(|&(cells, weight)| smooth(x, y, cells) * weight).sum()
}

fn grey(value: f32) -> [f32; 3] {
    [value; 3]
}

fn shade(color: [f32; 3], by: f32) -> [f32; 4] {
    let [r, g, b] = color.map(|channel| (channel * by).clamp(0.0, 1.0));
    [r, g, b, 1.0]
}

/// Marble tiles, two by two, light and dark by turns, with joints.
pub(super) fn tiles() -> Image {
    square("tiles", 256, |x, y| {
        let (column, row) = ((x * 2.0) as u32, (y * 2.0) as u32);
        let edge = |t: f32| (t * 2.0).fract().min(1.0 - (t * 2.0).fract());
        if edge(x).min(edge(y)) < 0.012 {
            return shade(grey(0.42), 1.0);
        }
        let vein = (cloudy(x, y) * 9.0 + (x + y) * 2.0).sin().abs().powf(0.35);
        let color =
            if (column + row).is_multiple_of(2) { [0.86, 0.83, 0.77] } else { [0.48, 0.34, 0.27] };
        shade(color, 0.82 + 0.18 * vein)
    })
}

/// Bricks in running bond, four courses by two.
pub(super) fn bricks() -> Image {
    const COURSES: f32 = 8.0;
    const LENGTHS: f32 = 4.0;
    square("bricks", 256, |x, y| {
        let course = (y * COURSES) as u32;
        let along = x * LENGTHS + if course.is_multiple_of(2) { 0.0 } else { 0.5 };
        let edge = |t: f32| t.fract().min(1.0 - t.fract());
        let joint = edge(along) < 0.03 || edge(y * COURSES) < 0.07;
        if joint {
            return shade([0.72, 0.69, 0.64], 0.9 + 0.1 * cloudy(x, y));
        }
        let tone = white(along as u32 % LENGTHS as u32, course);
        let color = [0.72 + 0.1 * tone, 0.46 + 0.08 * tone, 0.34 + 0.05 * tone];
        shade(color, 0.85 + 0.2 * cloudy(x, y))
    })
}

/// Weathered stone.
pub(super) fn stone() -> Image {
    square("stone", 256, |x, y| shade([0.88, 0.84, 0.76], 0.78 + 0.3 * cloudy(x, y)))
}

/// A plain weave with a broad stripe at its sides.
pub(super) fn fabric() -> Image {
    square("fabric", 128, |x, y| {
        let thread = |t: f32| (t * 32.0 * std::f32::consts::PI).sin().abs();
        let over = ((x * 32.0) as u32 + (y * 32.0) as u32).is_multiple_of(2);
        let weave = if over { thread(x) } else { thread(y) };
        shade(grey(0.95), 0.75 + 0.25 * weave)
    })
}

/// A leaf on nothing: alpha is 1 within its outline.
pub(super) fn leaf() -> Image {
    square("leaf", 128, |x, y| {
        // The stem is at the bottom, the tip at the top.
        let height = 1.0 - y;
        let half_width = 0.42 * (std::f32::consts::PI * height.powf(0.75)).sin().max(0.0);
        let across = (x - 0.5).abs();
        let lobe = 1.0 - 0.25 * (height * 40.0).sin().max(0.0);
        let inside = across < half_width * lobe || (across < 0.02 && height < 0.3);
        let rib = across < 0.012 || ((height - across * 0.8) * 14.0).fract() < 0.09;
        let color = if rib { [0.62, 0.74, 0.35] } else { [0.27, 0.5, 0.18] };
        let [r, g, b, _] = shade(color, 0.8 + 0.3 * cloudy(x, y));
        [r, g, b, if inside { 1.0 } else { 0.0 }]
    })
}
