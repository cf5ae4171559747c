//! The entries of bind group layouts, and the functions that make them.

use proc_macro2::{Literal, TokenStream};
use quote::quote;

use super::described::Described;
use super::names::{ident, pascal};
use crate::manifest::{self, Access, Dimension, Resource, SampleType, SamplerType, Stage};

pub(super) fn stages(stages: &[Stage]) -> TokenStream {
    let name = |stage: &Stage| match stage {
        Stage::Vertex => quote!(wgpu::ShaderStages::VERTEX),
        Stage::Fragment => quote!(wgpu::ShaderStages::FRAGMENT),
        Stage::Compute => quote!(wgpu::ShaderStages::COMPUTE),
        Stage::Other => quote!(wgpu::ShaderStages::NONE),
    };
    match stages {
        [] => quote!(wgpu::ShaderStages::NONE),
        [first, rest @ ..] => {
            let first = name(first);
            let rest = rest.iter().map(name);
            quote!(#first #(.union(#rest))*)
        }
    }
}

pub(super) fn entry(binding: &manifest::Binding) -> TokenStream {
    let number = Literal::u32_unsuffixed(binding.binding);
    let visible = stages(&binding.visibility);
    match &binding.resource {
        Resource::Uniform { min_size, .. } => {
            let size = Literal::u64_unsuffixed(*min_size);
            quote!(super::uniform(#number, #visible, #size))
        }
        Resource::Storage { access, min_size, .. } => {
            let size = Literal::u64_unsuffixed(*min_size);
            let read_only = *access == Access::Read;
            quote!(super::storage(#number, #visible, #read_only, #size))
        }
        Resource::Texture { dimension, sample_type, multisampled } => {
            let dimension = view_dimension(*dimension);
            let sample_type = match sample_type {
                SampleType::Float => quote!(Float { filterable: true }),
                SampleType::UnfilterableFloat => quote!(Float { filterable: false }),
                SampleType::Depth => quote!(Depth),
                SampleType::Sint => quote!(Sint),
                SampleType::Uint => quote!(Uint),
            };
            quote! {
                super::texture(
                    #number, #visible, wgpu::TextureSampleType::#sample_type, #dimension, #multisampled,
                )
            }
        }
        Resource::StorageTexture { dimension, format, access } => {
            let dimension = view_dimension(*dimension);
            let format = ident(&texture_format(format));
            let access = match access {
                Access::Read => quote!(ReadOnly),
                Access::Write => quote!(WriteOnly),
                Access::ReadWrite => quote!(ReadWrite),
            };
            quote! {
                super::storage_texture(
                    #number, #visible, wgpu::StorageTextureAccess::#access,
                    wgpu::TextureFormat::#format, #dimension,
                )
            }
        }
        Resource::Sampler { sampler_type } => {
            let sampler_type = match sampler_type {
                SamplerType::Filtering => quote!(Filtering),
                SamplerType::Comparison => quote!(Comparison),
            };
            quote!(super::sampler(#number, #visible, wgpu::SamplerBindingType::#sampler_type))
        }
    }
}

fn view_dimension(dimension: Dimension) -> TokenStream {
    let name = match dimension {
        Dimension::D1 => quote!(D1),
        Dimension::D2 => quote!(D2),
        Dimension::D2Array => quote!(D2Array),
        Dimension::Cube => quote!(Cube),
        Dimension::CubeArray => quote!(CubeArray),
        Dimension::D3 => quote!(D3),
    };
    quote!(wgpu::TextureViewDimension::#name)
}

/// WebGPU's `rgba16float` as wgpu's `Rgba16Float`.
fn texture_format(format: &str) -> String {
    let numbers_end = format.rfind(|c: char| c.is_ascii_digit()).map_or(0, |at| at + 1);
    let (channels, kind) = format.split_at(numbers_end);
    pascal(channels) + &pascal(kind)
}

/// The functions that [`entry`] calls; those alone that are called.
pub(super) fn entry_makers(variants: &[Described<'_>]) -> TokenStream {
    let resources = || variants.iter().flat_map(|of| &of.variant.bindings).map(|of| &of.resource);
    let used = |is: fn(&Resource) -> bool, maker: TokenStream| resources().any(is).then_some(maker);
    let uniform = used(
        |of| matches!(of, Resource::Uniform { .. }),
        quote! {
            const fn uniform(
                binding: u32,
                visibility: wgpu::ShaderStages,
                min_size: u64,
            ) -> wgpu::BindGroupLayoutEntry {
                let ty = wgpu::BindingType::Buffer {
                    ty: wgpu::BufferBindingType::Uniform,
                    has_dynamic_offset: false,
                    min_binding_size: core::num::NonZeroU64::new(min_size),
                };
                wgpu::BindGroupLayoutEntry { binding, visibility, ty, count: None }
            }
        },
    );
    let storage = used(
        |of| matches!(of, Resource::Storage { .. }),
        quote! {
            const fn storage(
                binding: u32,
                visibility: wgpu::ShaderStages,
                read_only: bool,
                min_size: u64,
            ) -> wgpu::BindGroupLayoutEntry {
                let ty = wgpu::BindingType::Buffer {
                    ty: wgpu::BufferBindingType::Storage { read_only },
                    has_dynamic_offset: false,
                    min_binding_size: core::num::NonZeroU64::new(min_size),
                };
                wgpu::BindGroupLayoutEntry { binding, visibility, ty, count: None }
            }
        },
    );
    let texture = used(
        |of| matches!(of, Resource::Texture { .. }),
        quote! {
            const fn texture(
                binding: u32,
                visibility: wgpu::ShaderStages,
                sample_type: wgpu::TextureSampleType,
                view_dimension: wgpu::TextureViewDimension,
                multisampled: bool,
            ) -> wgpu::BindGroupLayoutEntry {
                let ty = wgpu::BindingType::Texture { sample_type, view_dimension, multisampled };
                wgpu::BindGroupLayoutEntry { binding, visibility, ty, count: None }
            }
        },
    );
    let storage_texture = used(
        |of| matches!(of, Resource::StorageTexture { .. }),
        quote! {
            const fn storage_texture(
                binding: u32,
                visibility: wgpu::ShaderStages,
                access: wgpu::StorageTextureAccess,
                format: wgpu::TextureFormat,
                view_dimension: wgpu::TextureViewDimension,
            ) -> wgpu::BindGroupLayoutEntry {
                let ty = wgpu::BindingType::StorageTexture { access, format, view_dimension };
                wgpu::BindGroupLayoutEntry { binding, visibility, ty, count: None }
            }
        },
    );
    let sampler = used(
        |of| matches!(of, Resource::Sampler { .. }),
        quote! {
            const fn sampler(
                binding: u32,
                visibility: wgpu::ShaderStages,
                ty: wgpu::SamplerBindingType,
            ) -> wgpu::BindGroupLayoutEntry {
                let ty = wgpu::BindingType::Sampler(ty);
                wgpu::BindGroupLayoutEntry { binding, visibility, ty, count: None }
            }
        },
    );
    quote!(#uniform #storage #texture #storage_texture #sampler)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texture_formats_are_wgpus() {
        let cases = [
            ("rgba16float", "Rgba16Float"),
            ("r32uint", "R32Uint"),
            ("rg11b10ufloat", "Rg11b10Ufloat"),
            ("rgb10a2unorm", "Rgb10a2Unorm"),
        ];
        for (format, expected) in cases {
            assert_eq!(texture_format(format), expected);
        }
    }
}
