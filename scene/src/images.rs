//! Images: decoding within limits, reading single texels, and making images from others.

use std::io::Cursor;

use image::ImageFormat;

use super::Limits;

/// An image in memory, row 0 at the top.
#[derive(Clone, PartialEq, Eq)]
pub struct Image {
    /// Its name or file name.
    pub name: String,
    /// In texels, at least 1.
    pub width: u32,
    /// In texels, at least 1.
    pub height: u32,
    /// Red, green, blue and alpha, a byte each, row by row without padding.
    pub rgba8: Vec<u8>,
    /// Whether red, green and blue are sRGB encoded; alpha never is.
    pub srgb: bool,
}

impl std::fmt::Debug for Image {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { name, width, height, srgb, rgba8: _ } = self;
        write!(out, "Image({name:?}, {width}x{height}, srgb: {srgb})")
    }
}

impl Image {
    /// Decodes PNG, JPEG, WebP, BMP or TGA; the last has no signature and is known by its name. The error says why it
    /// does not decode. `texels` is what the images before left of the limits.
    pub(super) fn decode(
        name: &str,
        bytes: &[u8],
        srgb: bool,
        limits: &Limits,
        texels: usize,
    ) -> Result<Self, String> {
        let format = image::guess_format(bytes).ok();
        let tga = || name.to_lowercase().ends_with(".tga").then_some(ImageFormat::Tga);
        let format = format.or_else(tga).filter(ImageFormat::reading_enabled);
        let format = format.ok_or("is not PNG, JPEG, WebP, BMP or TGA")?;
        let reader = || image::ImageReader::with_format(Cursor::new(bytes), format);
        let (width, height) = reader().into_dimensions().map_err(|error| error.to_string())?;
        let count = (width as usize).saturating_mul(height as usize);
        if count == 0 {
            return Err(format!("is {width} by {height} texels, which is none"));
        }
        for (limit, whose) in [(limits.image_texels, "an image"), (texels, "all images together")] {
            if count > limit {
                return Err(format!(
                    "is {width} by {height} texels, more than the {limit} left to {whose}"
                ));
            }
        }
        let mut reader = reader();
        let mut allowed = image::Limits::default();
        // Of 16-bit images a decoder keeps 8 bytes a texel, and some a second copy.
        allowed.max_alloc = Some((count as u64).saturating_mul(24).saturating_add(1 << 22));
        reader.limits(allowed);
        let decoded = reader.decode().map_err(|error| error.to_string())?.into_rgba8();
        let (width, height) = decoded.dimensions();
        Ok(Self { name: name.to_owned(), width, height, rgba8: decoded.into_raw(), srgb })
    }

    /// Makes an image texel by texel, from `of(u, v)` at the texels' centres, each channel 0 to 1: red, green and blue
    /// linear, encoded if the image is `srgb`.
    pub(super) fn make(
        name: &str,
        [width, height]: [u32; 2],
        srgb: bool,
        of: impl Fn(f32, f32) -> [f32; 4],
    ) -> Self {
        let mut rgba8 = Vec::with_capacity(4 * width as usize * height as usize);
        for y in 0..height {
            for x in 0..width {
                let u = (x as f32 + 0.5) / width as f32;
                let v = (y as f32 + 0.5) / height as f32;
                let [r, g, b, a] = of(u, v);
                let [r, g, b] = [r, g, b].map(|linear| if srgb { encoded(linear) } else { linear });
                rgba8.extend([r, g, b, a].map(|value| (255.0 * value + 0.5) as u8));
            }
        }
        Self { name: name.to_owned(), width, height, rgba8, srgb }
    }

    /// The number of texels.
    pub(super) fn texels(&self) -> usize {
        self.rgba8.len() / 4
    }

    /// The texel at texture coordinates from 0 to 1: linear red, green, blue and alpha, each 0 to 1.
    pub(super) fn nearest(&self, u: f32, v: f32) -> [f32; 4] {
        let place = |at: f32, size: u32| ((at * size as f32) as u32).min(size - 1) as usize;
        let first = 4 * (place(v, self.height) * self.width as usize + place(u, self.width));
        self.linear(first)
    }

    /// The mean of all texels, linear.
    pub(super) fn mean(&self) -> [f32; 4] {
        let mut sums = [0.0_f64; 4];
        for first in (0..self.rgba8.len()).step_by(4) {
            for (sum, value) in sums.iter_mut().zip(self.linear(first)) {
                *sum += f64::from(value);
            }
        }
        sums.map(|sum| (sum / self.texels() as f64) as f32)
    }

    /// Whether some texel's alpha is not 1.
    pub(super) fn has_alpha(&self) -> bool {
        self.rgba8.as_chunks::<4>().0.iter().any(|texel| texel[3] < u8::MAX)
    }

    fn linear(&self, first: usize) -> [f32; 4] {
        let [r, g, b, a] = [0, 1, 2, 3].map(|channel| {
            let byte = self.rgba8.get(first + channel).copied().unwrap_or_default();
            f32::from(byte) / 255.0
        });
        let [r, g, b] = [r, g, b].map(|value| if self.srgb { decoded(value) } else { value });
        [r, g, b, a]
    }
}

/// [IEC 61966-2-1]
fn decoded(value: f32) -> f32 {
    if value <= 0.04045 { value / 12.92 } else { ((value + 0.055) / 1.055).powf(2.4) }
}

/// [IEC 61966-2-1]
fn encoded(value: f32) -> f32 {
    if value <= 0.003_130_8 { 12.92 * value } else { 1.055 * value.powf(1.0 / 2.4) - 0.055 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_encoded_is_decoded() {
        let image = Image::make("ramp", [256, 1], true, |u, _| [u, u * u, 1.0 - u, u]);
        for (x, texel) in image.rgba8.as_chunks::<4>().0.iter().enumerate() {
            let u = (x as f32 + 0.5) / 256.0;
            let found = image.nearest(u, 0.5);
            // Half a byte, times the steepest slope of the encoding's inverse.
            for (found, expected) in found.into_iter().zip([u, u * u, 1.0 - u, u]) {
                assert!(
                    (found - expected).abs() <= 2.4 / 510.0,
                    "{x}: {found} {expected} {texel:?}"
                );
            }
        }
        assert!(image.has_alpha() && image.texels() == 256);
        assert!((image.mean()[0] - 0.5).abs() < 1e-3);
    }
}
