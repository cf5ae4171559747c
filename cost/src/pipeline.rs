//! What the driver says of a compiled pipeline.

use ash::vk;

use crate::assembly::loops;
use crate::cost::Cost;
use crate::device::{Device, text};
use crate::error::Error;
use crate::issue::Generation;
use crate::objects::Objects;
use crate::request::Shader;
use crate::spirv::Module;
use crate::statistics::{Statistic, fill};

/// RADV's name of the machine code as text.
const ASSEMBLY: &str = "Assembly";

/// Compiles one entry point and reads its figures.
pub(crate) fn cost(
    device: &Device,
    shader: &Shader,
    module: &Module,
    generation: Option<Generation>,
) -> Result<Cost, Error> {
    let objects = Objects::new(device, shader, module)?;
    let failed = |call| {
        move |result| Error::Vulkan { subject: format!("variant `{}`", shader.id), call, result }
    };
    let pipeline = vk::PipelineInfoKHR::default().pipeline(objects.pipeline);
    // SAFETY: the pipeline is of this device and alive.
    let executables = unsafe { device.executables.get_pipeline_executable_properties(&pipeline) }
        .map_err(failed("vkGetPipelineExecutablePropertiesKHR"))?;
    let [executable] = &executables[..] else {
        return Err(Error::Executables { id: shader.id.clone(), count: executables.len() });
    };
    let info = vk::PipelineExecutableInfoKHR::default().pipeline(objects.pipeline);
    // SAFETY: the pipeline is alive, was made to capture statistics, and has executable 0.
    let statistics = unsafe { device.executables.get_pipeline_executable_statistics(&info) }
        .map_err(failed("vkGetPipelineExecutableStatisticsKHR"))?;
    let mut cost =
        Cost { id: shader.id.clone(), entry_point: shader.entry_point.clone(), ..Cost::default() };
    fill(&mut cost, &statistics.iter().map(statistic).collect::<Vec<_>>())?;
    let code = assembly(device, shader, &info)?;
    let found = loops(&code).map_err(|wrong| Error::Assembly {
        id: shader.id.clone(),
        line: wrong.line,
        what: wrong.what,
    })?;
    if found.instructions != cost.instructions {
        // A text that is misread gives another number than the compiler's.
        let (id, text, compiler) = (shader.id.clone(), found.instructions, cost.instructions);
        return Err(Error::Count { id, text, compiler });
    }
    cost.loops = found.count;
    if let Some(longest) = found.longest {
        cost.loop_instructions = Some(longest.len() as u64);
        let lanes = executable.subgroup_size;
        cost.loop_issue_cycles = generation.map(|kind| kind.cycles(&longest, lanes));
    }
    Ok(cost)
}

fn statistic(from: &vk::PipelineExecutableStatisticKHR<'_>) -> Statistic {
    use vk::PipelineExecutableStatisticFormatKHR as Format;
    let value = match from.format {
        // SAFETY: `format` says that the union holds an unsigned number.
        Format::UINT64 => Some(unsafe { from.value.u64 }),
        // SAFETY: `format` says that the union holds a signed number.
        Format::INT64 => u64::try_from(unsafe { from.value.i64 }).ok(),
        _ => None,
    };
    Statistic { name: text(from.name_as_c_str()), value }
}

/// The machine code as text. ash's own call asks for sizes only, so the second one is made here.
fn assembly(
    device: &Device,
    shader: &Shader,
    info: &vk::PipelineExecutableInfoKHR<'_>,
) -> Result<String, Error> {
    let failed = |result| Error::Vulkan {
        subject: format!("variant `{}`", shader.id),
        call: "vkGetPipelineExecutableInternalRepresentationsKHR",
        result,
    };
    // SAFETY: the pipeline is alive, was made to capture representations, and has executable 0.
    let mut all =
        unsafe { device.executables.get_pipeline_executable_internal_representations(info) }
            .map_err(failed)?;
    let mut buffers: Vec<Vec<u8>> = all.iter().map(|one| vec![0; one.data_size]).collect();
    for (one, buffer) in all.iter_mut().zip(&mut buffers) {
        one.p_data = buffer.as_mut_ptr().cast();
    }
    let mut count = u32::try_from(all.len()).unwrap_or(u32::MAX);
    let call = device.executables.fp().get_pipeline_executable_internal_representations_khr;
    // SAFETY: `all` has `count` elements, each with a buffer of the size that it states; they live through the call.
    unsafe { call(device.executables.device(), info, &mut count, all.as_mut_ptr()) }
        .result()
        .map_err(failed)?;
    let names = all.iter().map(|one| text(one.name_as_c_str()));
    for ((one, buffer), name) in all.iter().zip(&buffers).zip(names.clone()) {
        if name == ASSEMBLY && one.is_text == vk::TRUE {
            let end = buffer.iter().position(|byte| *byte == 0).unwrap_or(buffer.len());
            return Ok(String::from_utf8_lossy(&buffer[..end]).into_owned());
        }
    }
    Err(Error::NoAssembly { id: shader.id.clone(), there: names.collect() })
}
