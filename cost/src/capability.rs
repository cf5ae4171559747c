//! Which device features the capabilities of SPIR-V need.
//!
//! A feature that no module needs stays off, so that a figure does not depend on what else is compiled.

use ash::vk;

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
    free(0), // Matrix
    free(1), // Shader
    needs(9, "shaderFloat16", |f| &mut f.v12.shader_float16),
    needs(10, "shaderFloat64", |f| &mut f.base.shader_float64),
    needs(11, "shaderInt64", |f| &mut f.base.shader_int64),
    needs(12, "shaderBufferInt64Atomics", |f| &mut f.v12.shader_buffer_int64_atomics),
    needs(22, "shaderInt16", |f| &mut f.base.shader_int16),
    needs(25, "shaderImageGatherExtended", |f| &mut f.base.shader_image_gather_extended),
    needs(27, "shaderStorageImageMultisample", |f| &mut f.base.shader_storage_image_multisample),
    needs(28, "shaderUniformBufferArrayDynamicIndexing", |f| {
        &mut f.base.shader_uniform_buffer_array_dynamic_indexing
    }),
    needs(29, "shaderSampledImageArrayDynamicIndexing", |f| {
        &mut f.base.shader_sampled_image_array_dynamic_indexing
    }),
    needs(30, "shaderStorageBufferArrayDynamicIndexing", |f| {
        &mut f.base.shader_storage_buffer_array_dynamic_indexing
    }),
    needs(31, "shaderStorageImageArrayDynamicIndexing", |f| {
        &mut f.base.shader_storage_image_array_dynamic_indexing
    }),
    needs(34, "imageCubeArray", |f| &mut f.base.image_cube_array),
    needs(39, "shaderInt8", |f| &mut f.v12.shader_int8),
    free(43), // Sampled1D
    free(44), // Image1D
    needs(45, "imageCubeArray", |f| &mut f.base.image_cube_array),
    free(46), // SampledBuffer
    free(47), // ImageBuffer
    needs(49, "shaderStorageImageExtendedFormats", |f| {
        &mut f.base.shader_storage_image_extended_formats
    }),
    free(50), // ImageQuery
    needs(55, "shaderStorageImageReadWithoutFormat", |f| {
        &mut f.base.shader_storage_image_read_without_format
    }),
    needs(56, "shaderStorageImageWriteWithoutFormat", |f| {
        &mut f.base.shader_storage_image_write_without_format
    }),
    // The operations on subgroups are a property of the device, and RADV has all of them.
    free(61), // GroupNonUniform
    free(62), // GroupNonUniformVote
    free(63), // GroupNonUniformArithmetic
    free(64), // GroupNonUniformBallot
    free(65), // GroupNonUniformShuffle
    free(66), // GroupNonUniformShuffleRelative
    free(68), // GroupNonUniformQuad
    needs(4433, "storageBuffer16BitAccess", |f| &mut f.v11.storage_buffer16_bit_access),
    needs(4434, "uniformAndStorageBuffer16BitAccess", |f| {
        &mut f.v11.uniform_and_storage_buffer16_bit_access
    }),
    needs(5345, "vulkanMemoryModel", |f| &mut f.v12.vulkan_memory_model),
    needs(5346, "vulkanMemoryModelDeviceScope", |f| &mut f.v12.vulkan_memory_model_device_scope),
    needs(6019, "shaderIntegerDotProduct", |f| &mut f.v13.shader_integer_dot_product),
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
