//! Textures with their mip chains.

use sglow_shaders::{Levels as LevelsAxis, Texel};

use crate::package::Package;
use crate::pipeline::{ComputePass, PipelineError, Step, encode_stage};
use crate::timing::Timer;

/// Which levels a texture has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Levels {
    /// All of them, down to one texel.
    All,
    /// Level 0.
    First,
}

impl Levels {
    fn count(self, side: u32) -> u32 {
        match self {
            Self::All => side.ilog2() + 1,
            Self::First => 1,
        }
    }
}

/// A texture with its mip chain, and the views that its passes need.
pub(crate) struct Pyramid {
    pub(crate) texture: wgpu::Texture,
    pub(crate) levels: Vec<wgpu::TextureView>,
}

impl Pyramid {
    pub(crate) fn new(
        device: &wgpu::Device,
        label: &str,
        size: u32,
        layers: u32,
        format: wgpu::TextureFormat,
        levels: Levels,
    ) -> Self {
        let levels = levels.count(size);
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
        let levels = (0..levels).map(|level| view(level, Some(1))).collect();
        Self { texture, levels }
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
        let [one, two, three] = LevelsAxis::ALL.map(pass);
        Ok(Self { by_levels: [one?, two?, three?], label })
    }

    /// The variants of a chain, of whatever size: a picture may change its size.
    pub(crate) fn variants(texel: Texel) -> Vec<String> {
        LevelsAxis::ALL.map(|levels| sglow_shaders::mip::Mip { texel, levels }.id()).into()
    }
}

/// What the texels of a square with its levels take; `texel` in bytes.
pub(crate) fn pyramid_bytes(side: u32, layers: u32, texel: u64, levels: Levels) -> u64 {
    let texels = (0..levels.count(side)).map(|level| u64::from(side >> level).pow(2));
    texels.sum::<u64>() * u64::from(layers) * texel
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
