//! Textures with their mip chains.

use sglow_shaders::{Levels, Texel};

use crate::package::Package;
use crate::pipeline::{ComputePass, PipelineError, Step, encode_stage};
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

    /// Dispatches that make every level from the one below it, as far as `extent`, width and height of what level 0
    /// holds, reaches. The rest of each level stays as it is, zero in a new texture.
    pub(crate) fn encode_mips(
        &self,
        device: &wgpu::Device,
        encoder: &mut wgpu::CommandEncoder,
        passes: &MipPasses,
        extent: [u32; 2],
        timer: Option<&mut Timer<'_>>,
    ) {
        let mut steps = Vec::new();
        let mut from = 0;
        while from + 1 < self.levels.len() {
            let made = (self.levels.len() - 1 - from).min(passes.by_levels.len());
            let bindings = (0..)
                .zip(&self.levels[from..=from + made])
                .map(|(binding, view)| (binding, wgpu::BindingResource::TextureView(view)))
                .collect();
            from += made;
            // Texels of the highest level that is made, in workgroups of 8 x 8.
            let groups = extent.map(|side| side.div_ceil(1 << from).div_ceil(8));
            let workgroups = [groups[0], groups[1], self.layers()];
            steps.push(Step { pass: &passes.by_levels[made - 1], bindings, workgroups });
        }
        encode_stage(device, encoder, timer, passes.label, &steps);
    }
}

/// The passes of a mip chain.
pub(crate) struct MipPasses {
    /// Those that make one level, two and three at once.
    by_levels: [ComputePass; 3],
    label: &'static str,
}

impl MipPasses {
    pub(crate) fn new(
        device: &wgpu::Device,
        package: &Package,
        texel: Texel,
        label: &'static str,
    ) -> Result<Self, PipelineError> {
        let pass = |levels| {
            let id = sglow_shaders::mip::Mip { texel, levels }.id();
            ComputePass::new(device, package, &id, label, &[])
        };
        Ok(Self {
            by_levels: [pass(Levels::One)?, pass(Levels::Two)?, pass(Levels::Three)?],
            label,
        })
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
