//! What few vertices have, as the passes read it.

use glam::{Vec2, Vec4, Vec4Swizzles as _};
use half::f16;
use sglow_scene::Mesh;
use sglow_shaders::SglowVertexDetail;

/// The details of a mesh's vertices: a second set of texture coordinates that is not there is 0, a colour white, a tangent 0,
/// which leaves the normal as it is.
pub(super) fn of(mesh: &Mesh) -> impl Iterator<Item = SglowVertexDetail> + '_ {
    let detail = &mesh.detail;
    (0..mesh.positions.len()).map(|vertex| {
        let color = detail.colors.get(vertex).map_or(Vec4::ONE, |&color| color.into());
        let tangent = detail.tangents.get(vertex).map_or(Vec4::ZERO, |&tangent| tangent.into());
        SglowVertexDetail {
            uv: detail.uvs.get(vertex).copied().unwrap_or_default(),
            color: [halves(color.xy()), halves(color.zw())],
            tangent: [normalized(tangent.xy()), normalized(tangent.zw())],
        }
    })
}

/// Two halves, the first in the low bits. [WGSL, pack2x16float]
fn halves(pair: Vec2) -> u32 {
    let [low, high] = pair.to_array().map(|one| u32::from(f16::from_f32(one).to_bits()));
    low | high << 16
}

/// Two numbers from -1 to 1. [WGSL, pack2x16snorm]
fn normalized(pair: Vec2) -> u32 {
    let bits = |one: f32| (0.5 + 32767.0 * one.clamp(-1.0, 1.0)).floor() as i16 as u16;
    let [low, high] = pair.to_array().map(|one| u32::from(bits(one)));
    low | high << 16
}
