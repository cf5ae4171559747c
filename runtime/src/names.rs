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

fn unknown(what: &str, name: &str) -> String {
    format!("unknown {what} `{name}`")
}

/// What is called so in WebGPU and WGSL: Rust's name in small letters, but for hyphens.
pub(crate) fn find<T: Debug + Copy>(what: &str, all: &[T], name: &str) -> Result<T, String> {
    let plain = name.replace('-', "");
    let found = all.iter().find(|known| format!("{known:?}").to_lowercase() == plain);
    found.copied().ok_or_else(|| unknown(what, name))
}

pub(crate) fn texture(name: &str) -> Result<Texture, String> {
    find("texture format", &TEXTURES, name)
}

pub(crate) fn vertex(name: &str) -> Result<Vertex, String> {
    find("vertex format", &VERTICES, name)
}

pub(crate) fn comparison(name: &str) -> Result<Compare, String> {
    find("comparison", &COMPARISONS, name)
}

pub(crate) fn sampler(name: &str) -> Result<wgpu::SamplerBindingType, String> {
    use wgpu::SamplerBindingType as Sampler;
    find("sampler type", &[Sampler::Filtering, Sampler::Comparison], name)
}

/// A stage; none of WebGPU's is none here.
pub(crate) fn stage(name: &str) -> wgpu::ShaderStages {
    wgpu::ShaderStages::from_name(&name.to_uppercase()).unwrap_or(wgpu::ShaderStages::NONE)
}

pub(crate) fn dimension(name: &str) -> Result<wgpu::TextureViewDimension, String> {
    use wgpu::TextureViewDimension as View;
    Ok(match name {
        "1d" => View::D1,
        "2d" => View::D2,
        "2d-array" => View::D2Array,
        "cube" => View::Cube,
        "cube-array" => View::CubeArray,
        "3d" => View::D3,
        _ => return Err(unknown("dimension", name)),
    })
}

pub(crate) fn access(name: &str) -> Result<wgpu::StorageTextureAccess, String> {
    use wgpu::StorageTextureAccess as Access;
    Ok(match name {
        "read" => Access::ReadOnly,
        "write" => Access::WriteOnly,
        "read_write" => Access::ReadWrite,
        _ => return Err(unknown("access", name)),
    })
}

pub(crate) fn sample_type(name: &str) -> Result<wgpu::TextureSampleType, String> {
    use wgpu::TextureSampleType as Sample;
    match name {
        "float" => Ok(Sample::Float { filterable: true }),
        "unfilterable-float" => Ok(Sample::Float { filterable: false }),
        _ => find("sample type", &[Sample::Depth, Sample::Sint, Sample::Uint], name),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_those_of_webgpu() {
        assert_eq!(texture("rgba8unorm-srgb"), Ok(Texture::Rgba8UnormSrgb));
        assert_eq!(texture("depth32float"), Ok(Texture::Depth32Float));
        assert_eq!(vertex("float32x3"), Ok(Vertex::Float32x3));
        assert_eq!(comparison("greater-equal"), Ok(Compare::GreaterEqual));
        assert_eq!(stage("compute"), wgpu::ShaderStages::COMPUTE);
        // Every format whose size a frame knows can be made.
        for known in TEXTURES {
            let name = format!("{known:?}").to_lowercase().replace("srgb", "-srgb");
            let bytes = sglow_graph::frame::texel_bytes(&name);
            let expected = known.block_copy_size(None).map(u64::from);
            assert!(bytes.is_none() || bytes == expected, "{name}: {bytes:?}");
        }
        assert_eq!(texture("rgba"), Err("unknown texture format `rgba`".to_owned()));
        assert!(vertex("float").is_err() && comparison("").is_err());
    }
}
