//! The names that WebGPU has for formats and comparisons.

use std::fmt::Debug;

use wgpu::{CompareFunction as Compare, TextureFormat as Texture, VertexFormat as Vertex};

/// Formats of textures that a frame may have.
const TEXTURES: [Texture; 24] = [
    Texture::R8Unorm,
    Texture::R8Uint,
    Texture::R16Float,
    Texture::R16Uint,
    Texture::Rg8Unorm,
    Texture::Depth16Unorm,
    Texture::R32Float,
    Texture::R32Uint,
    Texture::R32Sint,
    Texture::Rg16Float,
    Texture::Rgba8Unorm,
    Texture::Rgba8UnormSrgb,
    Texture::Bgra8Unorm,
    Texture::Rgb10a2Unorm,
    Texture::Rg11b10Ufloat,
    Texture::Rgba8Uint,
    Texture::Depth32Float,
    Texture::Rg32Float,
    Texture::Rg32Uint,
    Texture::Rgba16Float,
    Texture::Rgba16Uint,
    Texture::Rgba32Float,
    Texture::Rgba32Uint,
    Texture::Rgba32Sint,
];

const VERTICES: [Vertex; 16] = [
    Vertex::Float32,
    Vertex::Float32x2,
    Vertex::Float32x3,
    Vertex::Float32x4,
    Vertex::Float16x2,
    Vertex::Float16x4,
    Vertex::Uint32,
    Vertex::Uint32x2,
    Vertex::Uint32x3,
    Vertex::Uint32x4,
    Vertex::Snorm8x4,
    Vertex::Unorm8x4,
    Vertex::Snorm16x2,
    Vertex::Snorm16x4,
    Vertex::Unorm16x2,
    Vertex::Unorm16x4,
];

const COMPARISONS: [Compare; 8] = [
    Compare::Never,
    Compare::Less,
    Compare::Equal,
    Compare::LessEqual,
    Compare::Greater,
    Compare::NotEqual,
    Compare::GreaterEqual,
    Compare::Always,
];

/// What is called so in WebGPU: Rust's name in small letters, but for hyphens.
fn find<T: Debug + Copy>(all: &[T], name: &str) -> Option<T> {
    let name = name.replace('-', "");
    all.iter().find(|known| format!("{known:?}").to_lowercase() == name).copied()
}

pub(super) fn texture(name: &str) -> Option<Texture> {
    find(&TEXTURES, name)
}

pub(super) fn vertex(name: &str) -> Option<Vertex> {
    find(&VERTICES, name)
}

pub(super) fn comparison(name: &str) -> Option<Compare> {
    find(&COMPARISONS, name)
}

pub(super) fn dimension(name: &str) -> Option<wgpu::TextureViewDimension> {
    use wgpu::TextureViewDimension as View;
    Some(match name {
        "1d" => View::D1,
        "2d" => View::D2,
        "2d-array" => View::D2Array,
        "cube" => View::Cube,
        "cube-array" => View::CubeArray,
        "3d" => View::D3,
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_those_of_webgpu() {
        assert_eq!(texture("rgba8unorm-srgb"), Some(Texture::Rgba8UnormSrgb));
        assert_eq!(texture("depth32float"), Some(Texture::Depth32Float));
        assert_eq!(vertex("float32x3"), Some(Vertex::Float32x3));
        assert_eq!(comparison("greater-equal"), Some(Compare::GreaterEqual));
        // Every format whose size a frame knows can be made.
        for known in TEXTURES {
            let name = format!("{known:?}").to_lowercase().replace("srgb", "-srgb");
            let bytes = sglow_graph::frame::texel_bytes(&name);
            let expected = known.block_copy_size(None).map(u64::from);
            assert!(bytes.is_none() || bytes == expected, "{name}: {bytes:?}");
        }
        assert_eq!((texture("rgba"), vertex("float"), comparison("")), (None, None, None));
    }
}
