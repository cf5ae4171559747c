//! Runs the generated packages with wgpu, on textures an engine already has.

pub mod scene;
