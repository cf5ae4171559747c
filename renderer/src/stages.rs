//! Stages of indirect light one by one, and what they leave: for tests and measurements.

use glam::Vec3;

use crate::timing::Timer;
use sglow_runtime::execute::{self, Stage};
use sglow_runtime::indirect::{Indirect, IndirectError, Inputs, SurfaceViews};
use sglow_runtime::light::LightView;
use sglow_shaders::frame::resource;

/// What encoding comes to.
type Encoded = Result<(), IndirectError>;

/// The stages of a frame of indirect light by the labels of their steps, and its resources by their names.
pub trait Stages {
    /// Everything.
    fn indirect(&self) -> &Indirect;

    /// The camera's virtual lights. Nothing without the bidirectional density.
    /// [Ritschel 2011; Tokuyoshi 2016, Section 5]
    ///
    /// # Errors
    ///
    /// What of the inputs does not fit, as in all the others.
    fn encode_camera(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        inputs: &Inputs<'_>,
        timer: Option<&mut Timer<'_>>,
    ) -> Encoded {
        run(self.indirect(), |stage| stage.label.starts_with(CAMERA), encoder, inputs, timer)
    }

    /// Level 0 of what clusters of the reflective shadow map sum.
    fn encode_moments(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        inputs: &Inputs<'_>,
        timer: Option<&mut Timer<'_>>,
    ) -> Encoded {
        run(self.indirect(), |stage| stage.label == "moments", encoder, inputs, timer)
    }

    /// Level 0 of the density. Nothing with 16-bit moments drawn by power, whose own pass writes the weight that the density
    /// is.
    fn encode_density(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        inputs: &Inputs<'_>,
        timer: Option<&mut Timer<'_>>,
    ) -> Encoded {
        run(self.indirect(), |stage| stage.label == "density", encoder, inputs, timer)
    }

    /// In place of that: level 0 of the density from another that has encoded it. Both have maps of the same size; copies
    /// as much as both hold.
    fn encode_density_of(&self, encoder: &mut wgpu::CommandEncoder, other: &Indirect) {
        let (Some(from), Some(to)) = (other.density(), self.density()) else { return };
        let size = wgpu::Extent3d {
            width: from.width().min(to.width()),
            height: from.height().min(to.height()),
            depth_or_array_layers: 1,
        };
        encoder.copy_texture_to_texture(from.as_image_copy(), to.as_image_copy(), size);
    }

    /// The mip chains from their levels 0.
    fn encode_mips(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        timer: Option<&mut Timer<'_>>,
    ) -> Encoded {
        let mips = |stage: Stage<'_>| stage.label.starts_with("mip ");
        encode(self.indirect(), mips, encoder, &execute::Inputs::new(), timer)
    }

    /// Kernels, or clusters, and virtual lights. Markov chains, if they draw the centres, move before.
    fn encode_sample(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        inputs: &Inputs<'_>,
        timer: Option<&mut Timer<'_>>,
    ) -> Encoded {
        run(self.indirect(), is_sample, encoder, inputs, timer)
    }

    /// Kernels alone, which need no map.
    fn encode_kernels(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        light: &LightView,
        timer: Option<&mut Timer<'_>>,
    ) -> Encoded {
        let own = self.indirect();
        encode(own, is_sample, encoder, &own.lit(light), timer)
    }

    /// The maps of virtual lights: of this frame's own or, where it has none, of those of `lights`, which have the precision,
    /// the lobes and the number of the settings.
    fn encode_light_maps(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        light: &LightView,
        lights: Option<&wgpu::Buffer>,
        timer: Option<&mut Timer<'_>>,
    ) -> Encoded {
        let own = self.indirect();
        let mut given = own.lit(light);
        if let Some(vsgls) = lights {
            given.buffer("vsgls", vsgls);
        }
        encode(own, |stage| stage.part == "visibility", encoder, &given, timer)
    }

    /// The virtual lights reflected towards the camera: this frame's own, or, where it has none, those of `lights`, and
    /// shadowed by their maps, if the settings have visibility.
    fn encode_shade(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        seen: &Seen<'_>,
        lights: Option<(&Indirect, Option<&wgpu::TextureView>)>,
        timer: Option<&mut Timer<'_>>,
    ) -> Encoded {
        let own = self.indirect();
        let mut given = own.lit(seen.light);
        own.seen(&mut given, seen.gbuffer, seen.eye);
        if let Some((lights, maps)) = lights {
            for name in LIGHTS {
                if let Some(buffer) = lights.buffer(name) {
                    given.buffer(name, &buffer);
                }
            }
            if let Some(maps) = maps {
                given.view("light_maps", maps);
            }
        }
        encode(own, |stage| stage.part == "shading", encoder, &given, timer)
    }

    /// Diffusely reflected radiance, rgba32float; nothing without diffuse reflection.
    fn diffuse(&self) -> Option<wgpu::Texture> {
        self.indirect().texture("diffuse")
    }

    /// Specularly reflected radiance, rgba32float; nothing without specular reflection.
    fn specular(&self) -> Option<wgpu::Texture> {
        self.indirect().texture("specular")
    }

    /// The moments with their mips, rgba32float, one layer for each: all of them, or those that 16 bits do not suffice
    /// for. A power-of-two square; texels beyond the reflective shadow map are 0. Clusters need no mips of them, and with
    /// the reflectance for density none at all.
    fn moments(&self) -> Option<wgpu::Texture> {
        self.indirect().texture("moments")
    }

    /// The moments that 16 bits suffice for with their mips, rgba16float, in [`LightView::power_unit`]; nothing with
    /// 32-bit precision.
    fn half_moments(&self) -> Option<wgpu::Texture> {
        self.indirect().texture("half_moments")
    }

    /// The weights with their mips, r32float, where they are neither in the moments (32-bit precision) nor the density
    /// (drawn by power).
    fn weights(&self) -> Option<wgpu::Texture> {
        self.indirect().texture("own_weights")
    }

    /// The density with its mips, r32float.
    fn density(&self) -> Option<wgpu::Texture> {
        self.indirect().texture("density")
    }

    /// The virtual lights: `SglowVsglBoth` or `SglowVsglDiffuse`, after the lobes; with 16-bit precision
    /// `SglowPackedVsglBoth` or `SglowPackedVsglDiffuse`.
    fn vsgls(&self) -> Option<wgpu::Buffer> {
        self.indirect().buffer("vsgls")
    }

    /// The kernels that the lights were made of: `SglowKernel`; nothing with clusters.
    fn kernels(&self) -> Option<wgpu::Buffer> {
        self.indirect().buffer("kernels")
    }

    /// The texels of the map in the order of their clusters, a word each; nothing with kernels.
    fn order(&self) -> Option<wgpu::Buffer> {
        // As many digits were sorted by as the numbers of clusters have.
        let bits = u32::BITS - (self.indirect().settings().lights - 1).leading_zeros();
        self.indirect()
            .buffer(["texels_values.0", "texels_values.1"][bits.div_ceil(4) as usize % 2])
    }

    /// Where the texels of each cluster begin in [`Self::order`], and behind the last one where they all end.
    fn starts(&self) -> Option<wgpu::Buffer> {
        self.indirect().buffer("starts")
    }

    /// The cluster of each texel, row by row: a word each; nothing with kernels.
    fn assignment(&self) -> Option<wgpu::Buffer> {
        self.indirect().buffer("texels_keys")
    }

    /// Where the chains are that draw the centres, two floats each; nothing if they are drawn otherwise.
    fn chains(&self) -> Option<wgpu::Buffer> {
        self.indirect().buffer("chains")
    }

    /// The camera's virtual lights, in 32 bits: `SglowVsglBoth` or `SglowVsglDiffuse`; nothing without the bidirectional
    /// density.
    fn camera_vsgls(&self) -> Option<wgpu::Buffer> {
        self.indirect().buffer("camera_vsgls")
    }

    /// The moments of the camera's G-buffer, as [`Self::moments`]; nothing without the bidirectional density.
    fn camera_moments(&self) -> Option<wgpu::Texture> {
        self.indirect().texture("camera_moments")
    }

    /// The density on the camera's G-buffer, as [`Self::density`]; nothing without the bidirectional density.
    fn camera_density(&self) -> Option<wgpu::Texture> {
        self.indirect().texture("camera_density")
    }

    /// The atlas of the virtual lights' maps, for each direction the light's near distance over that of what is met first, 0
    /// where there is nothing: depth32float with `shadow_map`, r32float with `imperfect`. Light i has tile i, in rows.
    fn light_maps(&self) -> Option<wgpu::Texture> {
        self.indirect().texture("light_maps")
    }

    /// What points left in the maps before holes were filled, tile by tile: the bits of f32 numbers. None with `shadow_map`.
    fn splats(&self) -> Option<wgpu::Buffer> {
        self.indirect().buffer("splats")
    }
}

/// Encodes some stages with all that a frame of indirect light reads.
fn run(
    own: &Indirect,
    selected: impl Fn(Stage<'_>) -> bool,
    encoder: &mut wgpu::CommandEncoder,
    inputs: &Inputs<'_>,
    timer: Option<&mut Timer<'_>>,
) -> Encoded {
    encode(own, selected, encoder, &own.given(inputs), timer)
}

/// Encodes some stages with what a host gives for them.
fn encode(
    own: &Indirect,
    selected: impl Fn(Stage<'_>) -> bool,
    encoder: &mut wgpu::CommandEncoder,
    given: &execute::Inputs<'_>,
    timer: Option<&mut Timer<'_>>,
) -> Encoded {
    let timer = timer.map(|timer| timer as _);
    Ok(own.executor().encode_where(selected, encoder, given, timer)?)
}

impl Stages for Indirect {
    fn indirect(&self) -> &Indirect {
        self
    }
}

/// What shading reads beside lights.
#[derive(Clone, Copy)]
pub struct Seen<'a> {
    /// The camera's G-buffer.
    pub gbuffer: SurfaceViews<'a>,
    /// The camera's position.
    pub eye: Vec3,
    /// The light; its maps' parameters follow from it.
    pub light: &'a LightView,
}

impl<'a> From<Inputs<'a>> for Seen<'a> {
    fn from(Inputs { gbuffer, eye, light, .. }: Inputs<'a>) -> Self {
        Self { gbuffer, eye, light }
    }
}

/// The buffers of lights: as many lights as the settings have, and of a cut for each tile the tree below them.
pub const LIGHTS: [&str; 4] =
    [resource::VSGLS, resource::ROOTS, resource::CUT_VSGLS, resource::BRANCHES];

/// What the labels of the camera's own stages begin with.
const CAMERA: &str = "camera ";

/// Whether a stage of what makes lights comes before the mip chains: level 0 of moments and density, and the camera's lights.
pub fn is_map(Stage { label, .. }: Stage<'_>) -> bool {
    label.starts_with(CAMERA) || ["moments", "density"].contains(&label)
}

/// Whether a stage makes the lights, of the camera's apart.
fn is_sample(stage: Stage<'_>) -> bool {
    stage.part == "lights" && !stage.label.starts_with("mip ") && !is_map(stage)
}
