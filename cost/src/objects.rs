//! The objects of Vulkan that compile a module, destroyed together.

use std::collections::BTreeMap;
use std::ffi::CString;

use ash::vk;

use crate::device::Device;
use crate::error::Error;
use crate::request::Shader;
use crate::spirv::Module;

/// The most that every device takes.
const PUSH_CONSTANT_BYTES: u32 = 128;

/// A compute pipeline and what it was made of; null where not made yet.
pub(crate) struct Objects<'d> {
    device: &'d Device,
    module: vk::ShaderModule,
    sets: Vec<vk::DescriptorSetLayout>,
    layout: vk::PipelineLayout,
    pub(crate) pipeline: vk::Pipeline,
}

impl<'d> Objects<'d> {
    /// Compiles the entry point.
    pub(crate) fn new(device: &'d Device, shader: &Shader, module: &Module) -> Result<Self, Error> {
        let failed = |call| {
            move |result| Error::Vulkan {
                subject: format!("variant `{}`", shader.id),
                call,
                result,
            }
        };
        let mut objects = Self {
            device,
            module: vk::ShaderModule::null(),
            sets: Vec::new(),
            layout: vk::PipelineLayout::null(),
            pipeline: vk::Pipeline::null(),
        };
        let create = vk::ShaderModuleCreateInfo::default().code(&module.words);
        // SAFETY: the words are a well-formed module (`spirv::read`), whose capabilities the device has enabled.
        objects.module = unsafe { device.raw.create_shader_module(&create, None) }
            .map_err(failed("vkCreateShaderModule"))?;
        for bindings in sets(module) {
            let create = vk::DescriptorSetLayoutCreateInfo::default().bindings(&bindings);
            // SAFETY: `bindings` lives through the call and has each binding once.
            let set = unsafe { device.raw.create_descriptor_set_layout(&create, None) }
                .map_err(failed("vkCreateDescriptorSetLayout"))?;
            objects.sets.push(set);
        }
        let constants = [vk::PushConstantRange::default()
            .stage_flags(vk::ShaderStageFlags::COMPUTE)
            .size(PUSH_CONSTANT_BYTES)];
        let create = vk::PipelineLayoutCreateInfo::default()
            .set_layouts(&objects.sets)
            .push_constant_ranges(&constants[..usize::from(module.push_constants)]);
        // SAFETY: the sets are of this device.
        objects.layout = unsafe { device.raw.create_pipeline_layout(&create, None) }
            .map_err(failed("vkCreatePipelineLayout"))?;
        let name = CString::new(shader.entry_point.as_str()).map_err(|_| Error::NoEntryPoint {
            path: shader.path.clone(),
            name: shader.entry_point.clone(),
            there: module.entry_points.clone(),
        })?;
        let stage = vk::PipelineShaderStageCreateInfo::default()
            .stage(vk::ShaderStageFlags::COMPUTE)
            .module(objects.module)
            .name(&name);
        let create = vk::ComputePipelineCreateInfo::default()
            .flags(
                vk::PipelineCreateFlags::CAPTURE_STATISTICS_KHR
                    | vk::PipelineCreateFlags::CAPTURE_INTERNAL_REPRESENTATIONS_KHR,
            )
            .stage(stage)
            .layout(objects.layout);
        // SAFETY: module and layout are of this device; the layout has every binding of the module.
        let made = unsafe {
            device.raw.create_compute_pipelines(vk::PipelineCache::null(), &[create], None)
        };
        let failed = failed("vkCreateComputePipelines");
        let pipelines = made.map_err(|(_, result)| failed(result))?;
        objects.pipeline = pipelines.first().copied().unwrap_or_default();
        Ok(objects)
    }
}

/// The bindings of each set up to the highest; one in between may have none.
fn sets(module: &Module) -> Vec<Vec<vk::DescriptorSetLayoutBinding<'static>>> {
    let mut sets = BTreeMap::<u32, Vec<_>>::new();
    for (&(set, binding), &(kind, count)) in &module.bindings {
        sets.entry(set).or_default().push(
            vk::DescriptorSetLayoutBinding::default()
                .binding(binding)
                .descriptor_type(kind)
                .descriptor_count(count)
                .stage_flags(vk::ShaderStageFlags::COMPUTE),
        );
    }
    let count = sets.last_key_value().map_or(0, |(set, _)| set + 1);
    (0..count).map(|set| sets.remove(&set).unwrap_or_default()).collect()
}

impl Drop for Objects<'_> {
    fn drop(&mut self) {
        // SAFETY: all are of this device or null, nothing was ever submitted, and nothing else holds them.
        unsafe {
            self.device.raw.destroy_pipeline(self.pipeline, None);
            self.device.raw.destroy_pipeline_layout(self.layout, None);
            for set in &self.sets {
                self.device.raw.destroy_descriptor_set_layout(*set, None);
            }
            self.device.raw.destroy_shader_module(self.module, None);
        }
    }
}
