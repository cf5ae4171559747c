//! The numbers that a host computes where it draws surfaces and their direct light by the frame's own passes.

use glam::{Vec4, Vec4Swizzles as _};
use sglow_shaders::SglowView;
use sglow_shaders::frame::input;

use sglow_runtime::execute::{Input, Inputs};
use sglow_runtime::light::{LightView, MAXIMUM_FACES, eye_at};

/// Subtracted from a position's depth before it is compared with a shadow map, in units of depth.
pub const DEPTH_BIAS: f32 = 1e-5;

/// How far a position is moved along its normal before it is compared with a shadow map of a size, in world units: twice the
/// footprint of a texel at the distance of the scene's radius. `minimum_variance` is that of a map of `map` texels.
pub fn normal_offset(minimum_variance: f32, map: u32, shadow_map: u32) -> f32 {
    let footprint = (6.0 * minimum_variance).sqrt() * map as f32 / shadow_map as f32;
    2.0 * footprint
}

/// Gives the camera.
pub fn camera(inputs: &mut Inputs<'_>, view: &SglowView) {
    let eye = Vec4::from(view.eye);
    eye_at(inputs, eye.xyz());
    inputs
        .set(input::CAMERA_VIEW_EYE, eye.to_array())
        .set(input::CAMERA_CLIP_FROM_VIEW, view.clip_from_view);
}

/// Gives what keeps surfaces from shadowing themselves in a shadow map; `normal_offsets` has one number for each face.
pub fn shadow(inputs: &mut Inputs<'_>, depth_bias: f32, normal_offsets: &[f32]) {
    let mut padded: Vec<f32> = normal_offsets.iter().flat_map(|&of| [of, 0.0, 0.0, 0.0]).collect();
    padded.resize(4 * MAXIMUM_FACES, 0.0);
    inputs
        .set(input::DEPTH_BIAS, depth_bias)
        .set(input::NORMAL_OFFSET, normal_offsets.first().copied().unwrap_or_default())
        .set(input::FACE_NORMAL_OFFSET, Input::F32(padded));
}

/// [`normal_offset`] of each face of a light's map, or of several lights'.
pub fn normal_offsets(view: &LightView, shadow_map: u32) -> Vec<f32> {
    let [columns, _] = view.grid();
    let of_light = |light: &LightView| {
        let alone = normal_offset(light.minimum_variance, view.map, shadow_map);
        vec![alone * light.widened(columns); light.faces.len()]
    };
    view.each().iter().flat_map(of_light).collect()
}
