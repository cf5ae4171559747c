//! Runs the generated packages with wgpu, on textures an engine already has.
//!
//! [`indirect::Indirect`] is what an engine embeds: it takes the surface textures of a reflective shadow map and of a
//! camera's G-buffer, and writes reflected radiance. [`execute`] runs any frame that is data.
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
//! let settings = Settings { size: [1920, 1088], map: 512, ..Settings::default() };
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

pub mod execute;
pub mod host;
pub mod indirect;
pub mod interface;
pub mod light;
mod names;
pub mod occluders;
pub mod package;
pub mod pipeline;
pub mod points;
pub mod settings;
pub mod timing;
