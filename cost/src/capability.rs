//! Which device features the capabilities of SPIR-V need.
//!
//! A feature that no module needs stays off, so that a figure does not depend on what else is compiled.

use ash::vk;
use rspirv::spirv::Capability as Is;

/// The structures that hold the features which modules can need.
#[derive(Clone, Copy, Default)]
pub(crate) struct Features {
    pub(crate) base: vk::PhysicalDeviceFeatures,
    pub(crate) v11: vk::PhysicalDeviceVulkan11Features<'static>,
    pub(crate) v12: vk::PhysicalDeviceVulkan12Features<'static>,
    pub(crate) v13: vk::PhysicalDeviceVulkan13Features<'static>,
}

/// Where a feature stands in them.
type Place = fn(&mut Features) -> &mut vk::Bool32;

/// A capability that is known here.
pub(crate) struct Capability {
    number: u32,
    /// The feature's name in Vulkan, and its place; none for what every device has.
    pub(crate) feature: Option<(&'static str, Place)>,
}

const fn free(number: u32) -> Capability {
    Capability { number, feature: None }
}

const fn needs(number: u32, name: &'static str, place: Place) -> Capability {
    Capability { number, feature: Some((name, place)) }
}

/// Stands for workgroup memory with an initialiser, which needs a feature but has no capability in SPIR-V.
pub(crate) const ZEROED_WORKGROUP: u32 = u32::MAX;

/// By number in SPIR-V.
static KNOWN: [Capability; 37] = [
    free(Is::Matrix as u32),
    free(Is::Shader as u32),
    needs(Is::Float16 as u32, "shaderFloat16", |f| &mut f.v12.shader_float16),
    needs(Is::Float64 as u32, "shaderFloat64", |f| &mut f.base.shader_float64),
    needs(Is::Int64 as u32, "shaderInt64", |f| &mut f.base.shader_int64),
    needs(Is::Int64Atomics as u32, "shaderBufferInt64Atomics", |f| {
        &mut f.v12.shader_buffer_int64_atomics
    }),
    needs(Is::Int16 as u32, "shaderInt16", |f| &mut f.base.shader_int16),
    needs(Is::ImageGatherExtended as u32, "shaderImageGatherExtended", |f| {
        &mut f.base.shader_image_gather_extended
    }),
    needs(Is::StorageImageMultisample as u32, "shaderStorageImageMultisample", |f| {
        &mut f.base.shader_storage_image_multisample
    }),
    needs(
        Is::UniformBufferArrayDynamicIndexing as u32,
        "shaderUniformBufferArrayDynamicIndexing",
        |f| &mut f.base.shader_uniform_buffer_array_dynamic_indexing,
    ),
    needs(
        Is::SampledImageArrayDynamicIndexing as u32,
        "shaderSampledImageArrayDynamicIndexing",
        |f| &mut f.base.shader_sampled_image_array_dynamic_indexing,
    ),
    needs(
        Is::StorageBufferArrayDynamicIndexing as u32,
        "shaderStorageBufferArrayDynamicIndexing",
        |f| &mut f.base.shader_storage_buffer_array_dynamic_indexing,
    ),
    needs(
        Is::StorageImageArrayDynamicIndexing as u32,
        "shaderStorageImageArrayDynamicIndexing",
        |f| &mut f.base.shader_storage_image_array_dynamic_indexing,
    ),
    needs(Is::ImageCubeArray as u32, "imageCubeArray", |f| &mut f.base.image_cube_array),
    needs(Is::Int8 as u32, "shaderInt8", |f| &mut f.v12.shader_int8),
    free(Is::Sampled1D as u32),
    free(Is::Image1D as u32),
    needs(Is::SampledCubeArray as u32, "imageCubeArray", |f| &mut f.base.image_cube_array),
    free(Is::SampledBuffer as u32),
    free(Is::ImageBuffer as u32),
    needs(Is::StorageImageExtendedFormats as u32, "shaderStorageImageExtendedFormats", |f| {
        &mut f.base.shader_storage_image_extended_formats
    }),
    free(Is::ImageQuery as u32),
    needs(Is::StorageImageReadWithoutFormat as u32, "shaderStorageImageReadWithoutFormat", |f| {
        &mut f.base.shader_storage_image_read_without_format
    }),
    needs(Is::StorageImageWriteWithoutFormat as u32, "shaderStorageImageWriteWithoutFormat", |f| {
        &mut f.base.shader_storage_image_write_without_format
    }),
    // The operations on subgroups are a property of the device, and RADV has all of them.
    free(Is::GroupNonUniform as u32),
    free(Is::GroupNonUniformVote as u32),
    free(Is::GroupNonUniformArithmetic as u32),
    free(Is::GroupNonUniformBallot as u32),
    free(Is::GroupNonUniformShuffle as u32),
    free(Is::GroupNonUniformShuffleRelative as u32),
    free(Is::GroupNonUniformQuad as u32),
    needs(Is::StorageBuffer16BitAccess as u32, "storageBuffer16BitAccess", |f| {
        &mut f.v11.storage_buffer16_bit_access
    }),
    needs(
        Is::UniformAndStorageBuffer16BitAccess as u32,
        "uniformAndStorageBuffer16BitAccess",
        |f| &mut f.v11.uniform_and_storage_buffer16_bit_access,
    ),
    needs(Is::VulkanMemoryModel as u32, "vulkanMemoryModel", |f| &mut f.v12.vulkan_memory_model),
    needs(Is::VulkanMemoryModelDeviceScope as u32, "vulkanMemoryModelDeviceScope", |f| {
        &mut f.v12.vulkan_memory_model_device_scope
    }),
    needs(Is::DotProduct as u32, "shaderIntegerDotProduct", |f| {
        &mut f.v13.shader_integer_dot_product
    }),
    needs(ZEROED_WORKGROUP, "shaderZeroInitializeWorkgroupMemory", |f| {
        &mut f.v13.shader_zero_initialize_workgroup_memory
    }),
];

/// The capability of that number, if it is known here.
pub(crate) fn find(number: u32) -> Option<&'static Capability> {
    KNOWN.iter().find(|capability| capability.number == number)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_ascend_and_places_differ() {
        assert!(KNOWN.is_sorted_by(|a, b| a.number < b.number));
        let mut features = Features::default();
        for capability in &KNOWN {
            if let Some((_, place)) = capability.feature {
                *place(&mut features) = vk::TRUE;
            }
        }
        assert_eq!(features.base.shader_float64, vk::TRUE);
        assert_eq!(features.base.robust_buffer_access, vk::FALSE);
    }
}
