//! Images and materials of a scene on the device.

use std::collections::{BTreeMap, BTreeSet};

use sglow_shaders::{Material as MaterialAxis, SglowMaterialDetailed};

use super::filled::filled;
use super::kind::axes;
use crate::device::Gpu;
use sglow_scene::{Filter, Scene, TextureUse, Traits, Wrap};

/// The images that a scene's textured materials read, on the device, and a white one for what has no texture.
pub(super) struct Textures {
    images: BTreeMap<usize, wgpu::TextureView>,
    white: Option<wgpu::TextureView>,
    /// Of the vertices that have any.
    details: Option<wgpu::Buffer>,
}

/// What a material is read with.
#[derive(Clone, Copy)]
pub(super) struct Reads {
    pub(super) material: MaterialAxis,
    /// Whether vertices have colours.
    pub(super) colored: bool,
}

impl Textures {
    pub(super) fn new(
        gpu: &Gpu,
        scene: &Scene,
        traits: &[Traits],
        details: Option<wgpu::Buffer>,
    ) -> Self {
        let reads = |traits: &Traits| axes(traits).0 != MaterialAxis::Constant;
        let textured = || scene.materials.iter().zip(traits).filter(|(_, traits)| reads(traits));
        let read: BTreeSet<usize> = textured()
            .flat_map(|(material, _)| material.textures().map(|texture| texture.image))
            .collect();
        let white = sglow_scene::Image {
            name: "white".to_owned(),
            width: 1,
            height: 1,
            rgba8: vec![255; 4],
            srgb: false,
        };
        Self {
            images: read
                .into_iter()
                .filter_map(|index| Some((index, upload(gpu, scene.images.get(index)?))))
                .collect(),
            white: textured().next().map(|_| upload(gpu, &white)),
            details,
        }
    }

    pub(super) fn bind(
        &self,
        gpu: &Gpu,
        layout: &wgpu::BindGroupLayout,
        material: &sglow_scene::Material,
        Reads { material: read, colored }: Reads,
    ) -> wgpu::BindGroup {
        let rows = |texture: &Option<TextureUse>| {
            let rows = texture.map_or_else(Default::default, |texture| texture.transform).rows();
            let set = if texture.is_some_and(|texture| texture.second) { 1.0 } else { 0.0 };
            rows.map(|[a, b, c]| [a, b, c, set])
        };
        let mapped = material.normal_texture.is_some();
        let uniform = SglowMaterialDetailed {
            base_color: material.base_color,
            emission: material.emission,
            roughness: material.roughness,
            metallic: material.metallic,
            dielectric: material.dielectric,
            alpha_cutoff: material.alpha_cutoff.unwrap_or(0.0),
            base_color_coordinates: rows(&material.base_color_texture),
            metallic_roughness_coordinates: rows(&material.metallic_roughness_texture),
            emission_coordinates: rows(&material.emission_texture),
            normal_coordinates: rows(&material.normal_texture),
            normal_scale: if mapped { material.normal_scale } else { 0.0 },
            colored: colored.into(),
            ..bytemuck::Zeroable::zeroed()
        };
        let uniform = filled(gpu, bytemuck::bytes_of(&uniform), wgpu::BufferUsages::UNIFORM);
        let mut entries =
            vec![wgpu::BindGroupEntry { binding: 0, resource: uniform.as_entire_binding() }];
        let sampler = sampler(gpu, material.textures().next());
        if read != MaterialAxis::Constant {
            entries.push(wgpu::BindGroupEntry {
                binding: 1,
                resource: wgpu::BindingResource::Sampler(&sampler),
            });
            let textures = [
                (2, &material.base_color_texture),
                (3, &material.metallic_roughness_texture),
                (4, &material.emission_texture),
                (6, &material.normal_texture),
            ];
            let detailed = read == MaterialAxis::Detailed;
            for (binding, texture) in textures.into_iter().take(if detailed { 4 } else { 3 }) {
                let image = texture.and_then(|texture| self.images.get(&texture.image));
                entries.extend(image.or(self.white.as_ref()).map(|view| wgpu::BindGroupEntry {
                    binding,
                    resource: wgpu::BindingResource::TextureView(view),
                }));
            }
            entries.extend(self.details.as_ref().filter(|_| detailed).map(|details| {
                wgpu::BindGroupEntry { binding: 5, resource: details.as_entire_binding() }
            }));
        }
        gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some(&material.name),
            layout,
            entries: &entries,
        })
    }
}

fn sampler(gpu: &Gpu, texture: Option<&TextureUse>) -> wgpu::Sampler {
    let wrap = |wrap| match wrap {
        Wrap::Repeat => wgpu::AddressMode::Repeat,
        Wrap::Mirror => wgpu::AddressMode::MirrorRepeat,
        Wrap::Clamp => wgpu::AddressMode::ClampToEdge,
    };
    let filter = |filter| match filter {
        Filter::Nearest => wgpu::FilterMode::Nearest,
        Filter::Linear => wgpu::FilterMode::Linear,
    };
    let texture = texture.copied().unwrap_or_else(|| TextureUse::repeating(0));
    gpu.device.create_sampler(&wgpu::SamplerDescriptor {
        label: Some("sglow material"),
        address_mode_u: wrap(texture.wrap[0]),
        address_mode_v: wrap(texture.wrap[1]),
        mag_filter: filter(texture.magnify),
        min_filter: filter(texture.minify),
        mipmap_filter: match texture.mip {
            Some(Filter::Linear) => wgpu::MipmapFilterMode::Linear,
            Some(Filter::Nearest) | None => wgpu::MipmapFilterMode::Nearest,
        },
        lod_max_clamp: if texture.mip.is_some() { 32.0 } else { 0.0 },
        ..Default::default()
    })
}

/// Uploads an image with a full mip chain.
fn upload(gpu: &Gpu, image: &sglow_scene::Image) -> wgpu::TextureView {
    let levels = image.width.max(image.height).ilog2() + 1;
    let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some(&image.name),
        size: wgpu::Extent3d { width: image.width, height: image.height, depth_or_array_layers: 1 },
        mip_level_count: levels,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: if image.srgb {
            wgpu::TextureFormat::Rgba8UnormSrgb
        } else {
            wgpu::TextureFormat::Rgba8Unorm
        },
        usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
        view_formats: &[],
    });
    let (mut width, mut height, mut texels) = (image.width, image.height, image.rgba8.clone());
    for mip_level in 0..levels {
        if mip_level > 0 {
            (width, height, texels) = halved(width, height, &texels, image.srgb);
        }
        gpu.queue.write_texture(
            wgpu::TexelCopyTextureInfo {
                texture: &texture,
                mip_level,
                origin: wgpu::Origin3d::ZERO,
                aspect: wgpu::TextureAspect::All,
            },
            &texels,
            wgpu::TexelCopyBufferLayout {
                offset: 0,
                bytes_per_row: Some(4 * width),
                rows_per_image: Some(height),
            },
            wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
        );
    }
    texture.create_view(&Default::default())
}

/// The next mip level: the mean of two by two texels, of linear light where the image is sRGB.
fn halved(width: u32, height: u32, texels: &[u8], srgb: bool) -> (u32, u32, Vec<u8>) {
    let decode = |channel: usize, value: u8| {
        let value = f32::from(value) / 255.0;
        if !srgb || channel == 3 {
            value
        } else if value <= 0.04045 {
            value / 12.92
        } else {
            ((value + 0.055) / 1.055).powf(2.4)
        }
    };
    let encode = |channel: usize, value: f32| {
        let value = if !srgb || channel == 3 {
            value
        } else if value <= 0.003_130_8 {
            12.92 * value
        } else {
            1.055 * value.powf(1.0 / 2.4) - 0.055
        };
        (255.0 * value + 0.5) as u8
    };
    let table: Vec<[f32; 2]> =
        (0..=255).map(|value| [decode(0, value), decode(3, value)]).collect();
    let (half_width, half_height) = ((width / 2).max(1), (height / 2).max(1));
    let mut half = Vec::with_capacity(4 * (half_width * half_height) as usize);
    for y in 0..half_height {
        for x in 0..half_width {
            for channel in 0..4 {
                let mut sum = 0.0;
                for (dx, dy) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
                    let x = (2 * x + dx).min(width - 1);
                    let y = (2 * y + dy).min(height - 1);
                    let value = texels[(4 * (y * width + x)) as usize + channel];
                    sum += table[usize::from(value)][usize::from(channel == 3)];
                }
                half.push(encode(channel, 0.25 * sum));
            }
        }
    }
    (half_width, half_height, half)
}
