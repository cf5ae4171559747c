//! Runs the generated packages with wgpu, on textures an engine already has.
//!
//! [`indirect::Indirect`] is what an engine embeds: it takes the surface textures of a reflective shadow map and of a
//! camera's G-buffer, and writes reflected radiance. [`scene`] and [`raster`] make those textures for who has none, and
//! [`frame::Renderer`] puts a whole frame together.
//!
//! Shader texts come from a [`package::Package`] and are used as they are.

pub mod density;
pub mod device;
pub mod direct;
pub mod frame;
pub mod indirect;
pub mod light;
pub mod package;
pub mod pipeline;
pub mod raster;
pub mod readback;
#[cfg(feature = "reference")]
pub mod reference;
pub mod scene;
pub mod settings;
pub mod timing;
