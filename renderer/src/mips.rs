//! Mip chains on their own: made of any texels, and timed against a copy of the same bytes.

use std::time::{Duration, Instant};

use crate::device::{DeviceError, Gpu};
use sglow_graph::Configuration;
use sglow_runtime::execute::{Executor, Faults, Inputs, Lists};
use sglow_runtime::indirect::PARTS;
use sglow_runtime::package::Package;
use sglow_runtime::settings::Settings;
use sglow_shaders::{Density, Lobes, Space};
use thiserror::Error;

/// Errors of mip chains.
#[derive(Debug, Error)]
pub enum MipsError {
    /// The package describes no mip chains.
    #[error("{0}; generate the package again: cargo xtask gen-shaders --out DIR")]
    Description(String),
    /// The chain cannot be executed.
    #[error(transparent)]
    Frame(#[from] Faults),
    /// The device failed.
    #[error(transparent)]
    Device(#[from] DeviceError),
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

/// Median times of one run, each round by wall-clock time around `repetitions`.
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

/// What a mip chain is of: one that the frame makes of what the camera sees, whose extent is any.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pyramid {
    /// The density: r32float, one layer.
    Density,
    /// The moments of both lobes: rgba32float, five layers.
    Moments,
}

impl Pyramid {
    /// The resource, and the label of the steps that make its levels.
    fn names(self) -> [&'static str; 2] {
        match self {
            Self::Density => ["camera_density", "camera mip density"],
            Self::Moments => ["camera_moments", "camera mip moments"],
        }
    }
}

/// The steps of the frame that make a mip chain, of which the first `extent` columns and rows hold anything.
struct Chain {
    executor: Executor,
    texture: wgpu::Texture,
    bytes: u64,
}

impl Chain {
    fn new(
        gpu: &Gpu,
        package: &Package,
        pyramid: Pyramid,
        [width, height]: [u32; 2],
    ) -> Result<Self, MipsError> {
        let wrong = |error: &dyn std::fmt::Display| MipsError::Description(error.to_string());
        let description = package.description();
        let description = description.ok_or_else(|| wrong(&"the package describes no frame"))?;
        let settings = Settings {
            size: [width, height],
            density: Density::Bidirectional,
            lobes: Lobes::Both,
            space: Space::None,
            ..Settings::default()
        };
        let parts = Some([PARTS[0].to_owned()].into());
        let configuration = Configuration { parts, ..settings.configuration() };
        let mut frame = description.evaluate(&configuration).map_err(|error| wrong(&error))?;
        let [name, label] = pyramid.names();
        frame.steps.retain(|step| step.label == label);
        for resource in &mut frame.resources {
            // What other steps use is not made.
            resource.external = resource.name != name;
            resource.kept = resource.name == name;
        }
        let (device, queue) = (&gpu.device, &gpu.queue);
        let executor = Executor::new(device, queue, package, &frame, &Lists::new())?;
        let texture = executor.texture(name).cloned();
        let texture = texture.ok_or_else(|| wrong(&format!("there is no `{name}`")))?;
        let bytes = frame.resource(name).map_or(0, |index| frame.resources[index].bytes);
        Ok(Self { executor, texture, bytes })
    }

    fn encode(&mut self, encoder: &mut wgpu::CommandEncoder) -> Result<(), MipsError> {
        Ok(self.executor.encode(encoder, &Inputs::new(), None)?)
    }
}

/// A mip chain of the least square of a power of two that holds `extent`, whose first columns and rows hold `texels`, layer
/// by layer and row by row from the top, in the bytes of their format; the others are zero. Levels are made as far as the
/// extent reaches.
///
/// # Errors
///
/// If the texels are not as many as the extent and the layers need, or the device refuses.
pub fn build(
    gpu: &Gpu,
    package: &Package,
    pyramid: Pyramid,
    extent: [u32; 2],
    texels: &[u8],
) -> Result<wgpu::Texture, MipsError> {
    let mut chain = Chain::new(gpu, package, pyramid, extent)?;
    let bytes = chain.texture.format().block_copy_size(None).unwrap_or(0);
    let layers = chain.texture.depth_or_array_layers();
    let [width, height] = extent;
    let wanted = (width * height * layers * bytes) as usize;
    if texels.len() != wanted {
        return Err(MipsError::Texels { found: texels.len(), wanted });
    }
    gpu.queue.write_texture(
        chain.texture.as_image_copy(),
        texels,
        wgpu::TexelCopyBufferLayout {
            offset: 0,
            bytes_per_row: Some(width * bytes),
            rows_per_image: Some(height),
        },
        wgpu::Extent3d { width, height, depth_or_array_layers: layers },
    );
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    chain.encode(&mut encoder)?;
    gpu.queue.submit([encoder.finish()]);
    gpu.finish()?;
    Ok(chain.texture)
}

/// Times a mip chain of `size` squared texels against copies of the same bytes, in turn within one run.
///
/// # Errors
///
/// If the device refuses.
pub fn measure(
    gpu: &Gpu,
    package: &Package,
    pyramid: Pyramid,
    size: u32,
) -> Result<MipTimes, MipsError> {
    let mut source = Chain::new(gpu, package, pyramid, [size; 2])?;
    let target = Chain::new(gpu, package, pyramid, [size; 2])?.texture;
    let (texture, bytes) = (source.texture.clone(), source.bytes);
    let copy = |encoder: &mut wgpu::CommandEncoder, levels: u32| {
        for mip_level in 0..levels {
            let place = |texture| wgpu::TexelCopyTextureInfo {
                texture,
                mip_level,
                origin: wgpu::Origin3d::ZERO,
                aspect: wgpu::TextureAspect::All,
            };
            let side = texture.width() >> mip_level;
            encoder.copy_texture_to_texture(
                place(&texture),
                place(&target),
                wgpu::Extent3d {
                    width: side,
                    height: side,
                    depth_or_array_layers: texture.depth_or_array_layers(),
                },
            );
        }
    };
    // A submission should be small beside its work.
    let repetitions = (64 * 1024 * 1024 / bytes.max(1)).clamp(2, 64) as u32;
    let mut time = |candidate: usize| -> Result<Duration, MipsError> {
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        for _ in 0..repetitions {
            match candidate {
                0 => source.encode(&mut encoder)?,
                1 => copy(&mut encoder, texture.mip_level_count()),
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
        bytes,
    })
}
