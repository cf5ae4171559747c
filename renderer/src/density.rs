//! The sampling pass on a density of choice, without a scene: what a density does to the method.

use std::time::{Duration, Instant};

use sglow_shaders::{Lobes, Precision, SglowKernel, SglowVsglDiffuse};

use crate::device::Gpu;
use crate::frame::FrameError;
use crate::light;
use crate::stages::Stages as _;
use sglow_runtime::indirect::Indirect;
use sglow_runtime::light::LightView;
use sglow_runtime::occluders::Occluders;
use sglow_runtime::package::Package;
use sglow_runtime::settings::Settings;
use sglow_scene::{Bounds, Light, LightKind};

/// Sampling passes that are timed together.
const DISPATCHES: u32 = 64;

/// What the sampling pass made of a density.
#[derive(Clone, Debug)]
pub struct Sampled {
    /// Where the kernels lie and how large they are.
    pub kernels: Vec<SglowKernel>,
    /// Power of each light.
    pub powers: Vec<f64>,
    /// Power of all photons.
    pub total: f64,
    /// Time of one sampling pass, by wall-clock time around many.
    pub time: Duration,
}

/// The least side of a density that the passes take.
const LEAST_SIDE: usize = 8;

/// A density of any size, padded with zeros to the right and below to a square whose side is a power of two, and that
/// side; texels stay where they are, and none is resampled.
pub fn padded([width, height]: [usize; 2], texels: &[f32]) -> (usize, Vec<f32>) {
    let side = width.max(height).max(LEAST_SIDE).next_power_of_two();
    let mut square = vec![0.0; side * side];
    if width > 0 {
        for (row, texels) in texels.chunks(width).take(height).enumerate() {
            square[row * side..row * side + texels.len()].copy_from_slice(texels);
        }
    }
    (side, square)
}

/// Draws `settings.lights` kernels by a density of `settings.map` squared texels, row by row from the top, each at
/// least 0, and sums `power`, the power of the same texels' photons on a wall that reflects diffusely.
///
/// Where power is proportional to density the modified kernels keep its total by construction; give them a power that
/// is not.
pub fn sample(
    gpu: &Gpu,
    package: &Package,
    settings: &Settings,
    density: &[f32],
    power: &[f32],
) -> Result<Sampled, FrameError> {
    let settings = Settings { lobes: Lobes::Diffuse, ..settings.clone() };
    let (indirect, view) = prepare(gpu, package, &settings, density, power)?;
    // The first run compiles; the median of the next five is the time.
    let mut times = Vec::new();
    for _ in 0..6 {
        times.push(time(gpu, &indirect, &view)?);
    }
    let lights =
        indirect.vsgls().map(|lights| crate::readback::buffer(gpu, &lights)).transpose()?;
    let lights: Vec<SglowVsglDiffuse> = lights.unwrap_or_default();
    let kernels = indirect.kernels().map(|kernels| crate::readback::buffer(gpu, &kernels));
    Ok(Sampled {
        kernels: kernels.transpose()?.unwrap_or_default(),
        powers: lights
            .iter()
            .map(|light| lobe_power(light.diffuse_coefficient[0], light.diffuse_sharpness))
            .collect(),
        total: power.iter().map(|&weight| f64::from(weight)).sum(),
        time: median(times.split_off(1)),
    })
}

/// Rounds of [`times`].
const ROUNDS: usize = 15;

/// Median time of one sampling pass for each of several settings, which take turns within one run, by wall-clock time
/// around many; `density` and `power` as for [`sample`]. The lobes are the settings' own, the precision is `f32`.
pub fn times(
    gpu: &Gpu,
    package: &Package,
    candidates: &[Settings],
    density: &[f32],
    power: &[f32],
) -> Result<Vec<Duration>, FrameError> {
    let mut prepared = Vec::new();
    for settings in candidates {
        prepared.push((prepare(gpu, package, settings, density, power)?, Vec::new()));
    }
    // The first round compiles.
    for round in 0..=ROUNDS {
        for ((indirect, view), times) in &mut prepared {
            let time = time(gpu, indirect, view)?;
            if round > 0 {
                times.push(time);
            }
        }
    }
    Ok(prepared.into_iter().map(|(_, times)| median(times)).collect())
}

fn median(mut times: Vec<Duration>) -> Duration {
    times.sort();
    times.get(times.len() / 2).copied().unwrap_or_default()
}

/// One sampling pass; a dispatch is shorter than its submission, so that many are timed together.
fn time(gpu: &Gpu, indirect: &Indirect, view: &LightView) -> Result<Duration, FrameError> {
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    for _ in 0..DISPATCHES {
        indirect.encode_kernels(&mut encoder, view, None)?;
    }
    let commands = encoder.finish();
    let start = Instant::now();
    gpu.queue.submit([commands]);
    gpu.finish()?;
    Ok(start.elapsed() / DISPATCHES)
}

/// Passes whose moments and density, with their mips, are those of a wall.
fn prepare(
    gpu: &Gpu,
    package: &Package,
    settings: &Settings,
    density: &[f32],
    power: &[f32],
) -> Result<(Indirect, LightView), FrameError> {
    let mut settings = settings.clone();
    settings.precision = Precision::F32;
    settings.space = sglow_shaders::Space::None;
    settings.cut = sglow_shaders::Cut::None;
    settings.density = sglow_shaders::Density::Power;
    settings.specular = sglow_shaders::Specular::None;
    settings.ndf = sglow_shaders::Ndf::None;
    settings.emitter = sglow_shaders::Emitter::Lobe;
    settings.diffuse = sglow_shaders::Diffuse::Constant;
    settings.size = [1, 1];
    let indirect =
        Indirect::of_parts(gpu.source(package), &settings, &["lights"], &Occluders::default())?;
    let size = settings.map;
    // A wall of side one, so that positions are those of the image.
    let mut position = Vec::with_capacity(density.len());
    let mut powers = Vec::with_capacity(density.len());
    let mut direction = Vec::with_capacity(density.len());
    for (index, &weight) in power.iter().enumerate() {
        let x = (index as u32 % size) as f32 / size as f32 - 0.5;
        let y = (index as u32 / size) as f32 / size as f32 - 0.5;
        position.push([weight * x, weight * y, 0.0, weight * (x * x + y * y)]);
        powers.push([weight; 4]);
        direction.push([0.0, 0.0, weight * 2.0 / 3.0, weight]);
    }
    let mut layers = [position, powers, direction];
    // The specular layers, where there are any, hold the same numbers: only their time counts.
    let (count, layers) = match settings.lobes {
        Lobes::Diffuse => (3, layers.concat()),
        Lobes::Both => {
            let diffuse = layers.concat();
            let [_, powers, direction] = &mut layers;
            (5, [diffuse, std::mem::take(powers), std::mem::take(direction)].concat())
        }
    };
    let write = |texture: &wgpu::Texture, bytes: &[u8], layers: u32, texel: u32| {
        gpu.queue.write_texture(
            texture.as_image_copy(),
            bytes,
            wgpu::TexelCopyBufferLayout {
                offset: 0,
                bytes_per_row: Some(size * texel),
                rows_per_image: Some(size),
            },
            wgpu::Extent3d { width: size, height: size, depth_or_array_layers: layers },
        );
    };
    if let Some(moments) = indirect.moments() {
        write(&moments, bytemuck::cast_slice(&layers), count, 16);
    }
    if let Some(texture) = indirect.density() {
        write(&texture, bytemuck::cast_slice(density), 1, 4);
    }
    let light = Light {
        name: "density".to_owned(),
        kind: LightKind::Directional,
        position: [0.0; 3],
        direction: [0.0, 0.0, -1.0],
        intensity: [1.0; 3],
        range: None,
        map_share: 1.0,
    };
    let view = light::view(&light, &Bounds::around([[-0.5, -0.5, 0.0], [0.5, 0.5, 0.0]]), size);
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    indirect.encode_mips(&mut encoder, None)?;
    gpu.queue.submit([encoder.finish()]);
    gpu.finish()?;
    Ok((indirect, view))
}

/// The power that a lobe emits: its coefficient times the integral of its spherical Gaussian.
/// [Tokuyoshi 2016, Appendix A]
fn lobe_power(coefficient: f32, sharpness: f32) -> f64 {
    let sharpness = f64::from(sharpness);
    if sharpness == 0.0 {
        return 4.0 * std::f64::consts::PI * f64::from(coefficient);
    }
    f64::from(coefficient) * std::f64::consts::TAU * -(-2.0 * sharpness).exp_m1() / sharpness
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn padding_moves_no_texel() {
        let texels: Vec<f32> = (1_u8..=27).map(f32::from).collect();
        let (side, square) = padded([9, 3], &texels);
        assert_eq!((side, square.len()), (16, 256));
        for (index, texel) in texels.iter().enumerate() {
            assert_eq!(square[index / 9 * 16 + index % 9], *texel);
        }
        assert_eq!(square.iter().sum::<f32>(), texels.iter().sum::<f32>());
        assert_eq!(padded([1, 1], &[5.0]).0, 8);
        let same: Vec<f32> = vec![1.0; 64];
        assert_eq!(padded([8, 8], &same), (8, same));
        assert_eq!(padded([0, 0], &[]).0, 8);
    }
}
