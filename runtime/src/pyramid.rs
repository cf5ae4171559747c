//! Textures with their mip chains.

use crate::pipeline::{ComputePass, Dispatch};
use crate::timing::Timer;

/// A texture with its mip chain, and the views that its passes need.
pub(crate) struct Pyramid {
    pub(crate) texture: wgpu::Texture,
    pub(crate) all: wgpu::TextureView,
    pub(crate) levels: Vec<wgpu::TextureView>,
}

impl Pyramid {
    pub(crate) fn new(
        device: &wgpu::Device,
        label: &str,
        size: u32,
        layers: u32,
        format: wgpu::TextureFormat,
    ) -> Self {
        let levels = size.ilog2() + 1;
        let texture = device.create_texture(&wgpu::TextureDescriptor {
            label: Some(label),
            size: wgpu::Extent3d { width: size, height: size, depth_or_array_layers: layers },
            mip_level_count: levels,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format,
            usage: wgpu::TextureUsages::STORAGE_BINDING
                | wgpu::TextureUsages::TEXTURE_BINDING
                | wgpu::TextureUsages::COPY_SRC
                | wgpu::TextureUsages::COPY_DST,
            view_formats: &[],
        });
        let view = |base_mip_level, mip_level_count| {
            texture.create_view(&wgpu::TextureViewDescriptor {
                label: Some(label),
                dimension: Some(wgpu::TextureViewDimension::D2Array),
                base_mip_level,
                mip_level_count,
                ..Default::default()
            })
        };
        let all = view(0, None);
        let levels = (0..levels).map(|level| view(level, Some(1))).collect();
        Self { texture, all, levels }
    }

    pub(crate) fn layers(&self) -> u32 {
        self.texture.depth_or_array_layers()
    }

    /// Dispatches that make every level from the one below it.
    pub(crate) fn encode_mips(
        &self,
        device: &wgpu::Device,
        encoder: &mut wgpu::CommandEncoder,
        pass: &ComputePass,
        timer: Option<&mut Timer<'_>>,
    ) {
        let bindings: Vec<_> = self
            .levels
            .windows(2)
            .map(|pair| {
                [
                    (0, wgpu::BindingResource::TextureView(&pair[0])),
                    (1, wgpu::BindingResource::TextureView(&pair[1])),
                ]
            })
            .collect();
        let dispatches: Vec<_> = bindings
            .iter()
            .enumerate()
            .map(|(level, bindings)| {
                let groups = (self.texture.width() >> (level + 1)).div_ceil(8);
                Dispatch { bindings, workgroups: [groups, groups, self.layers()] }
            })
            .collect();
        pass.encode(device, encoder, timer, &dispatches);
    }
}

/// What a texture's texels take, on all its levels and layers.
pub(crate) fn texture_bytes(texture: &wgpu::Texture) -> u64 {
    let texel = u64::from(texture.format().block_copy_size(None).unwrap_or(0));
    let texels = (0..texture.mip_level_count()).map(|level| {
        let side = |size: u32| u64::from((size >> level).max(1));
        side(texture.width()) * side(texture.height())
    });
    texels.sum::<u64>() * u64::from(texture.depth_or_array_layers()) * texel
}
