//! Mip chains on their own: made of any texels, and timed against a copy of the same bytes.

use std::time::{Duration, Instant};

use sglow_shaders::Texel;

use crate::device::{DeviceError, Gpu};
use crate::package::Package;
use crate::pipeline::PipelineError;
use crate::pyramid::{Levels, MipPasses, Pyramid, texture_bytes};
use thiserror::Error;

/// Why there is no mip chain.
#[derive(Debug, Error)]
pub enum MipsError {
    /// A variant does not become a pipeline.
    #[error(transparent)]
    Pipeline(#[from] PipelineError),
    /// The device failed.
    #[error(transparent)]
    Device(#[from] DeviceError),
    /// Only squares of a power of two have levels that are exact means.
    #[error("the size is {0}; it has to be a power of two, at least 2")]
    Size(u32),
    /// The texels are not those of the extent.
    #[error("there are {found} bytes of texels; {wanted} are needed")]
    Texels {
        /// What there is.
        found: usize,
        /// What there has to be.
        wanted: usize,
    },
}

/// Rounds that are timed; a round times each candidate once.
const ROUNDS: usize = 15;

/// Median times of one run, each round by the wall's clock around `repetitions`.
#[derive(Clone, Debug)]
pub struct MipTimes {
    /// The whole chain made from level 0.
    pub mips: Duration,
    /// The whole chain, all levels and layers, copied to another texture by the queue.
    pub copy: Duration,
    /// Level 0 alone, all layers, copied to another texture.
    pub copy_of_level_0: Duration,
    /// Median of the rounds' ratios of `mips` over `copy`.
    pub ratio: f64,
    /// The bytes of the chain.
    pub bytes: u64,
}

fn format(texel: Texel) -> wgpu::TextureFormat {
    match texel {
        Texel::Rgba32float => wgpu::TextureFormat::Rgba32Float,
        Texel::Rgba16float => wgpu::TextureFormat::Rgba16Float,
        Texel::R32float => wgpu::TextureFormat::R32Float,
    }
}

fn pyramid(gpu: &Gpu, texel: Texel, size: u32, layers: u32) -> Result<Pyramid, MipsError> {
    if size < 2 || !size.is_power_of_two() {
        return Err(MipsError::Size(size));
    }
    Ok(Pyramid::new(&gpu.device, "sglow mips", size, layers, format(texel), Levels::All))
}

/// A mip chain of `size` squared texels of which the first `extent` columns and rows hold `texels`, layer by layer and
/// row by row from the top, in the bytes of their format; the others are zero. Levels are made as far as the extent
/// reaches.
///
/// # Errors
///
/// If the size is not a power of two, the texels are not as many as the extent and the layers need, or the device
/// refuses.
pub fn build(
    gpu: &Gpu,
    package: &Package,
    texel: Texel,
    size: u32,
    layers: u32,
    extent: [u32; 2],
    texels: &[u8],
) -> Result<wgpu::Texture, MipsError> {
    let pyramid = pyramid(gpu, texel, size, layers)?;
    let passes = MipPasses::new(&gpu.device, package, texel, "mips")?;
    let bytes = format(texel).block_copy_size(None).unwrap_or(0);
    let [width, height] = extent;
    let wanted = (width * height * layers * bytes) as usize;
    if texels.len() != wanted {
        return Err(MipsError::Texels { found: texels.len(), wanted });
    }
    gpu.queue.write_texture(
        pyramid.texture.as_image_copy(),
        texels,
        wgpu::TexelCopyBufferLayout {
            offset: 0,
            bytes_per_row: Some(width * bytes),
            rows_per_image: Some(height),
        },
        wgpu::Extent3d { width, height, depth_or_array_layers: layers },
    );
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    pyramid.encode_mips(&gpu.device, &mut encoder, &passes, extent, None);
    gpu.queue.submit([encoder.finish()]);
    gpu.finish()?;
    Ok(pyramid.texture)
}

/// Times a mip chain of `size` squared texels and `layers` layers against copies of the same bytes, in turn within one
/// run.
///
/// # Errors
///
/// If the size is not a power of two, or the device refuses.
pub fn measure(
    gpu: &Gpu,
    package: &Package,
    texel: Texel,
    size: u32,
    layers: u32,
) -> Result<MipTimes, MipsError> {
    let source = pyramid(gpu, texel, size, layers)?;
    let target = pyramid(gpu, texel, size, layers)?;
    let passes = MipPasses::new(&gpu.device, package, texel, "mips")?;
    let copy = |encoder: &mut wgpu::CommandEncoder, levels: u32| {
        for mip_level in 0..levels {
            let place = |texture| wgpu::TexelCopyTextureInfo {
                texture,
                mip_level,
                origin: wgpu::Origin3d::ZERO,
                aspect: wgpu::TextureAspect::All,
            };
            let side = size >> mip_level;
            encoder.copy_texture_to_texture(
                place(&source.texture),
                place(&target.texture),
                wgpu::Extent3d { width: side, height: side, depth_or_array_layers: layers },
            );
        }
    };
    // A submission should be small beside its work.
    let repetitions = (64 * 1024 * 1024 / texture_bytes(&source.texture)).clamp(2, 64) as u32;
    let time = |candidate: usize| -> Result<Duration, MipsError> {
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        for _ in 0..repetitions {
            match candidate {
                0 => source.encode_mips(&gpu.device, &mut encoder, &passes, [size; 2], None),
                1 => copy(&mut encoder, source.texture.mip_level_count()),
                _ => copy(&mut encoder, 1),
            }
        }
        let commands = encoder.finish();
        let start = Instant::now();
        gpu.queue.submit([commands]);
        gpu.finish()?;
        Ok(start.elapsed() / repetitions)
    };
    // The first round compiles and touches all memory.
    let mut rounds = Vec::new();
    for _ in 0..=ROUNDS {
        rounds.push([time(0)?, time(1)?, time(2)?]);
    }
    rounds.remove(0);
    let median = |index: usize| {
        let mut times: Vec<_> = rounds.iter().map(|round| round[index]).collect();
        times.sort();
        times[times.len() / 2]
    };
    let mut ratios: Vec<_> =
        rounds.iter().map(|round| round[0].as_secs_f64() / round[1].as_secs_f64()).collect();
    ratios.sort_by(f64::total_cmp);
    Ok(MipTimes {
        mips: median(0),
        copy: median(1),
        copy_of_level_0: median(2),
        ratio: ratios[ratios.len() / 2],
        bytes: texture_bytes(&source.texture),
    })
}
