//! Runs the generated packages with wgpu, on textures an engine already has.
//!
//! [`indirect::Indirect`] is what an engine embeds: it takes the surface textures of a reflective shadow map and of a
//! camera's G-buffer, and writes reflected radiance. [`scene`] and [`raster`] make those textures for who has none, and
//! [`frame::Renderer`] puts a whole frame together.
//!
//! ```no_run
//! # fn frame(
//! #     device: &wgpu::Device, queue: &wgpu::Queue, encoder: &mut wgpu::CommandEncoder,
//! #     rsm: sglow_runtime::indirect::SurfaceViews<'_>, gbuffer: sglow_runtime::indirect::SurfaceViews<'_>,
//! #     light: &sglow_runtime::light::LightView, eye: glam::Vec3,
//! # ) -> Result<(), sglow_runtime::indirect::IndirectError> {
//! use sglow_runtime::indirect::{Indirect, Inputs};
//! use sglow_runtime::settings::Settings;
//!
//! // Once: pipelines and buffers for 1920 x 1088 pixels and 1024 virtual lights.
//! let settings = Settings { size: [1920, 1088], rsm_size: 512, ..Settings::default() };
//! let indirect = Indirect::new(device, queue, &settings)?;
//! // Every frame: `rsm` and `gbuffer` are three textures each that the engine has rendered.
//! indirect.encode(encoder, &Inputs { rsm, gbuffer, light, eye }, None)?;
//! let reflected = indirect.texture("diffuse"); // radiance, to be added to the picture
//! # let _ = reflected;
//! # Ok(())
//! # }
//! ```
//!
//! Shader texts come from a [`package::Package`] and are used as they are.

pub mod check;
pub mod density;
pub mod device;
pub mod execute;
pub mod frame;
pub mod function;
pub mod host;
pub mod indirect;
pub mod interface;
pub mod light;
pub mod mips;
pub mod needs;
pub mod occluders;
pub mod package;
pub mod pipeline;
pub mod plan;
pub mod points;
pub mod raster;
pub mod readback;
#[cfg(feature = "reference")]
pub mod reference;
pub mod scene;
pub mod settings;
pub mod stages;
pub mod timing;

