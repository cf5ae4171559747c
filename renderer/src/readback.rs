//! Brings buffers and textures back to the CPU.

use bytemuck::AnyBitPattern;

use crate::device::{DeviceError, Gpu};
use sglow_runtime::indirect::Indirect;

/// A whole buffer that was made with `COPY_SRC`.
pub fn buffer<T: AnyBitPattern>(gpu: &Gpu, source: &wgpu::Buffer) -> Result<Vec<T>, DeviceError> {
    let staging = staging(gpu, source.size());
    let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    encoder.copy_buffer_to_buffer(source, 0, &staging, 0, source.size());
    gpu.queue.submit([encoder.finish()]);
    let bytes = map(gpu, &staging)?;
    Ok(bytes.chunks_exact(size_of::<T>()).map(bytemuck::pod_read_unaligned).collect())
}

/// The bytes of each buffer and of each texture, with its mips, that indirect light keeps between its passes, by name; those
/// of the parameters are left out.
pub fn bytes(of: &Indirect) -> Vec<(String, u64)> {
    let bytes = |name: &str| match (of.buffer(name), of.texture(name)) {
        (Some(buffer), _) => buffer.size(),
        (None, Some(texture)) => {
            let texel = u64::from(texture.format().block_copy_size(None).unwrap_or(0));
            let texels = (0..texture.mip_level_count()).map(|level| {
                let side = |size: u32| u64::from((size >> level).max(1));
                side(texture.width()) * side(texture.height())
            });
            texels.sum::<u64>() * u64::from(texture.depth_or_array_layers()) * texel
        }
        // A sampler has none.
        (None, None) => 0,
    };
    let names: Vec<_> = of.executor().own().map(str::to_owned).collect();
    names.into_iter().map(|name| (name.clone(), bytes(&name))).collect()
}

/// One mip level of a texture that was made with `COPY_SRC`, layer by layer and row by row, four floats a texel.
/// Channels that the format lacks are 0.
///
/// Formats: rgba32float, rgba16float, r32float, depth32float.
pub fn texture(
    gpu: &Gpu,
    source: &wgpu::Texture,
    level: u32,
) -> Result<Vec<[f32; 4]>, DeviceError> {
    let format = source.format();
    let texel_bytes = match format {
        wgpu::TextureFormat::Rgba32Float => 16,
        wgpu::TextureFormat::Rgba16Float => 8,
        wgpu::TextureFormat::R32Float | wgpu::TextureFormat::Depth32Float => 4,
        _ => {
            return Err(DeviceError::Refused {
                adapter: gpu.adapter.name.clone(),
                messages: vec![format!(
                    "a texture of format {format:?} cannot be read back; expected rgba32float, rgba16float, r32float or depth32float"
                )],
            });
        }
    };
    let (width, height) = ((source.width() >> level).max(1), (source.height() >> level).max(1));
    let layers = source.depth_or_array_layers();
    let row = (width * texel_bytes).next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
    let staging = staging(gpu, u64::from(row) * u64::from(height) * u64::from(layers));
    let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    encoder.copy_texture_to_buffer(
        wgpu::TexelCopyTextureInfo {
            texture: source,
            mip_level: level,
            origin: wgpu::Origin3d::ZERO,
            aspect: wgpu::TextureAspect::All,
        },
        wgpu::TexelCopyBufferInfo {
            buffer: &staging,
            layout: wgpu::TexelCopyBufferLayout {
                offset: 0,
                bytes_per_row: Some(row),
                rows_per_image: Some(height),
            },
        },
        wgpu::Extent3d { width, height, depth_or_array_layers: layers },
    );
    gpu.queue.submit([encoder.finish()]);
    let bytes = map(gpu, &staging)?;
    let texel = |bytes: &[u8]| -> [f32; 4] {
        let mut channels = [0.0; 4];
        if format == wgpu::TextureFormat::Rgba16Float {
            for (channel, bits) in channels.iter_mut().zip(bytes.chunks_exact(2)) {
                *channel = half::f16::from_le_bytes([bits[0], bits[1]]).to_f32();
            }
        } else {
            for (channel, bits) in channels.iter_mut().zip(bytes.chunks_exact(4)) {
                *channel = f32::from_le_bytes([bits[0], bits[1], bits[2], bits[3]]);
            }
        }
        channels
    };
    let used = (width * texel_bytes) as usize;
    Ok(bytes
        .chunks_exact(row as usize)
        .flat_map(|row| row[..used].chunks_exact(texel_bytes as usize).map(texel))
        .collect())
}

fn staging(gpu: &Gpu, size: u64) -> wgpu::Buffer {
    gpu.device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("sglow readback"),
        size,
        usage: wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST,
        mapped_at_creation: false,
    })
}

fn map(gpu: &Gpu, staging: &wgpu::Buffer) -> Result<Vec<u8>, DeviceError> {
    let (sender, receiver) = std::sync::mpsc::channel();
    staging.map_async(wgpu::MapMode::Read, .., move |result| {
        // The receiver waits below; if it is gone the result is not needed.
        let _ = sender.send(result);
    });
    gpu.finish()?;
    let refused = |message: String| DeviceError::Refused {
        adapter: gpu.adapter.name.clone(),
        messages: vec![message],
    };
    match receiver.recv() {
        Ok(Ok(())) => {}
        Ok(Err(error)) => return Err(refused(error.to_string())),
        Err(error) => return Err(refused(error.to_string())),
    }
    let range = staging.get_mapped_range(..).map_err(|error| refused(error.to_string()))?;
    Ok(range.to_vec())
}
