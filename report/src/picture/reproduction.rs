//! The pictures of a reproduction.

use std::path::Path;

use image::RgbImage;
use sglow_results::reproduction::{Drawing, Drawn};

use crate::failure::Result;
use crate::picture::density::Density;
use crate::picture::{Image, compare, kernels, png, tone};

/// Writes each picture into a folder, and those of kernels side by side as `kernels.png`.
///
/// # Errors
///
/// When a picture has no pixels or cannot be written.
pub fn write(folder: &Path, drawings: &[Drawing]) -> Result {
    let mut sheet = Vec::new();
    for Drawing { file, drawn } in drawings {
        let picture = picture(drawn)?;
        png::write(&folder.join(file), &picture)?;
        if matches!(drawn, Drawn::Kernels { .. }) {
            sheet.push(picture);
        }
    }
    if sheet.is_empty() {
        return Ok(());
    }
    let sheet = compare::side_by_side(&sheet.iter().collect::<Vec<_>>());
    png::write(&folder.join("kernels.png"), &sheet)
}

fn picture(drawn: &Drawn) -> Result<RgbImage> {
    match drawn {
        Drawn::Radiance { size, pixels, exposure } => {
            let [width, height] = size.map(|side| side as usize);
            Ok(tone::radiance(&Image::new(width, height, pixels.clone())?, *exposure))
        }
        Drawn::Kernels { side, density, squares } => {
            let texels = density.clone();
            kernels::draw(&Density { name: String::new(), size: [*side; 2], texels }, squares)
        }
    }
}
