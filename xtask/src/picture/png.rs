//! 8-bit files for a person.

use std::path::Path;

use image::{ImageFormat, RgbImage};

use crate::failure::Result;
use crate::write;

/// Writes `image` as PNG.
///
/// # Errors
///
/// When the file cannot be written.
pub(crate) fn write(path: &Path, image: &RgbImage) -> Result {
    write::file(path, |sink| image.write_to(&mut &mut *sink, ImageFormat::Png))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_picture_comes_back() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("picture.png");
        let picture = RgbImage::from_fn(5, 3, |x, y| image::Rgb([x as u8, y as u8, 200]));
        write(&path, &picture).unwrap();
        assert_eq!(image::open(&path).unwrap().to_rgb8(), picture);
    }
}
