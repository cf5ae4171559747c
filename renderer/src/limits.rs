//! Limits of the device and the machine, checked before anything is allocated for a frame.

use sglow_runtime::package::Package;
use sglow_runtime::settings::Settings;
use sglow_scene::Scene;
use thiserror::Error;

use crate::device::Gpu;
use crate::plan::{Plan, Surfaces};
use crate::raster::{Raster, Vertex};

/// A limit that is exceeded.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum LimitError {
    /// A texture that is too large.
    #[error("{what}: {} x {} texels; textures of {adapter} are at most {maximum} wide and high", size[0], size[1])]
    Texture {
        /// What it is of.
        what: String,
        /// Its width and height.
        size: [u32; 2],
        /// The device.
        adapter: String,
        /// The largest width and height.
        maximum: u32,
    },
    /// A buffer that is too large.
    #[error("{what}: {needed} bytes; buffers of {adapter} have at most {maximum}")]
    Buffer {
        /// What it is of.
        what: String,
        /// Its bytes.
        needed: u64,
        /// The device.
        adapter: String,
        /// The maximum of a buffer.
        maximum: u64,
    },
    /// More memory than the machine has left.
    #[error("{what} would take {:.1} GB of memory, and {:.1} GB are available", *needed as f64 / 1e9, *available as f64 / 1e9)]
    Memory {
        /// What takes it.
        what: String,
        /// Its bytes.
        needed: u64,
        /// Bytes that are available.
        available: u64,
    },
    /// A density whose square is out of proportion to what it holds.
    #[error(
        "a density of {} x {} pixels is padded to {side} x {side} texels, which would take {:.1} GB: more than {DENSITY_PADDING} \
         times its pixels; scale it, or give it in a less narrow picture",
        size[0], size[1], *needed as f64 / 1e9
    )]
    Narrow {
        /// Its width and height.
        size: [usize; 2],
        /// The side of its square.
        side: u64,
        /// What that would take, in bytes.
        needed: u64,
    },
    /// A density that no map can hold.
    #[error(
        "a density of {} x {} pixels is padded to {side} x {side} texels, which would take {:.1} GB; at most {maximum} wide and high",
        size[0], size[1], *needed as f64 / 1e9
    )]
    Density {
        /// Its width and height.
        size: [usize; 2],
        /// The side of its square.
        side: u64,
        /// What that would take, in bytes.
        needed: u64,
        /// The largest width and height.
        maximum: u32,
    },
}

/// Bytes of each pixel of a frame that is read back: eight pictures, and what they are written from.
const PIXEL: u64 = 256;

/// How many times the pixels of a density its square may have, beyond 1024 by 1024 texels.
const DENSITY_PADDING: u64 = 256;
/// Texels of a square that any density may have.
const DENSITY_SQUARE: u64 = 1024 * 1024;

/// Bytes of each texel of a density's square: moments, density and power with their mips on the device, the numbers that are
/// uploaded, and the sums of the oracle.
const DENSITY_TEXEL: u64 = 200;

/// Bytes of memory that are available; nothing where the system has no `/proc/meminfo`.
#[must_use]
pub fn available() -> Option<u64> {
    let text = std::fs::read_to_string("/proc/meminfo").ok()?;
    let line = text.lines().find_map(|line| line.strip_prefix("MemAvailable:"))?;
    line.trim().strip_suffix("kB")?.trim().parse::<u64>().ok()?.checked_mul(1024)
}

/// Checks that the machine has so much memory left.
///
/// # Errors
///
/// What is needed, and what is available.
pub fn memory(what: &str, needed: u64) -> Result<(), LimitError> {
    within(what, needed, available())
}

fn within(what: &str, needed: u64, available: Option<u64>) -> Result<(), LimitError> {
    match available {
        Some(available) if needed > available => {
            Err(LimitError::Memory { what: what.to_owned(), needed, available })
        }
        _ => Ok(()),
    }
}

/// Checks that a device and the machine can hold a frame.
///
/// # Errors
///
/// The first of its textures and buffers that is too large, or the memory of all of them.
pub fn frame(
    gpu: &Gpu,
    package: &Package,
    scene: &Scene,
    settings: &Settings,
) -> Result<(), LimitError> {
    let limits = gpu.device.limits();
    let adapter = || gpu.adapter.name.clone();
    let picture = [("the picture".to_owned(), settings.size)];
    let map = [("the reflective shadow map".to_owned(), [settings.map; 2])];
    let images = scene
        .images
        .iter()
        .map(|image| (format!("image '{}'", image.name), [image.width, image.height]));
    let maximum = limits.max_texture_dimension_2d;
    for (what, size) in picture.into_iter().chain(map).chain(images) {
        if size.iter().any(|&side| side > maximum) {
            return Err(LimitError::Texture { what, size, adapter: adapter(), maximum });
        }
    }
    let vertex = size_of::<Vertex>() as u64;
    let mut taken = 0_u64;
    let surfaces = Surfaces::of(scene, settings.complete);
    let sum =
        |of: fn(&sglow_scene::Mesh) -> usize| scene.meshes.iter().map(of).sum::<usize>() as u64;
    let all = [
        ("vertices of all meshes", sum(|mesh| mesh.positions.len()).saturating_mul(vertex)),
        ("indices of all meshes", sum(|mesh| mesh.indices.len()).saturating_mul(4)),
    ];
    let maximum = limits.max_buffer_size;
    for (what, needed) in all {
        if needed > maximum {
            let what = what.to_owned();
            return Err(LimitError::Buffer { what, needed, adapter: adapter(), maximum });
        }
        taken = taken.saturating_add(needed);
    }
    let (needed, detail_maximum) = Raster::detail_bytes(gpu, scene, settings.complete);
    if needed > detail_maximum {
        let what = "normal maps, colours of vertices and second texture coordinates".to_owned();
        return Err(LimitError::Buffer {
            what,
            needed,
            adapter: adapter(),
            maximum: detail_maximum,
        });
    }
    taken = taken.saturating_add(needed);
    let plan = package.description().and_then(|of| Plan::new(of, settings, &surfaces).ok());
    // Its memory is the machine's. No API reports the free memory of another device.
    if gpu.adapter.software {
        for resource in plan.iter().flat_map(|plan| &plan.resources) {
            taken = taken.saturating_add(resource.bytes);
        }
    }
    let [width, height] = settings.size.map(u64::from);
    let pixels = width.saturating_mul(height).saturating_mul(PIXEL);
    memory(&format!("a frame of {width} x {height} pixels"), taken.saturating_add(pixels))
}

/// Checks that a density of so many pixels can be padded to a square, and kernels be drawn on it.
///
/// # Errors
///
/// What is needed, and what is available.
pub fn density(size: [usize; 2]) -> Result<(), LimitError> {
    let side = size[0].max(size[1]).checked_next_power_of_two().unwrap_or(usize::MAX) as u64;
    let needed = side.saturating_mul(side).saturating_mul(DENSITY_TEXEL);
    let maximum = wgpu::Limits::default().max_texture_dimension_2d;
    if side > u64::from(maximum) {
        return Err(LimitError::Density { size, side, needed, maximum });
    }
    let [width, height] = size;
    let pixels = (width as u64).saturating_mul(height as u64);
    if side * side > pixels.saturating_mul(DENSITY_PADDING).max(DENSITY_SQUARE) {
        return Err(LimitError::Narrow { size, side, needed });
    }
    memory(
        &format!("kernels on a density of {width} x {height} pixels, padded to a square,"),
        needed,
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_name_what_is_needed_and_what_is_available() {
        assert!(available().is_none_or(|bytes| bytes > 1 << 20));
        assert_eq!(within("it", 5, Some(5)), Ok(()));
        assert_eq!(within("it", u64::MAX, None), Ok(()));
        let text = within("it", 25_000_000_000, Some(4_000_000_000)).unwrap_err().to_string();
        assert_eq!(text, "it would take 25.0 GB of memory, and 4.0 GB are available");
        density([256, 3]).unwrap();
        let text = density([9000, 1]).unwrap_err().to_string();
        for part in ["9000 x 1", "16384 x 16384", "53.7 GB", "at most 8192"] {
            assert!(text.contains(part), "{text}");
        }
        assert!(density([usize::MAX, 1]).is_err());
        // What is drawn costs in proportion to what is there.
        density([1024, 1]).unwrap();
        density([2048, 8]).unwrap();
        let text = density([4096, 1]).unwrap_err().to_string();
        assert!(text.contains("4096 x 4096") && text.contains("more than 256 times"), "{text}");
    }
}
