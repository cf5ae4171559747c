//! Parts of the frame by themselves: a template of the library's description, with everything around it given by a test.

pub(crate) mod chains;
pub(crate) mod clusters;
pub(crate) mod cut;

use sglow_graph::Configuration;
use sglow_renderer::readback;
use sglow_runtime::execute::{Executor, Faults, Inputs, Lists};
use sglow_runtime::package::Package;

use crate::common::{gpu, library};

/// A frame of a test's own, over the library's templates.
pub(crate) struct Part {
    executor: Executor,
}

impl Part {
    /// The frame `description`, as JSON, in a configuration.
    pub(crate) fn new(
        package: &Package,
        description: serde_json::Value,
        configuration: &Configuration,
    ) -> Self {
        Self::try_new(package, description, configuration).unwrap()
    }

    /// The same; what the configuration does not allow is an error.
    pub(crate) fn try_new(
        package: &Package,
        description: serde_json::Value,
        configuration: &Configuration,
    ) -> Result<Self, sglow_graph::Errors> {
        let template = serde_json::from_value(description).unwrap();
        let library = library();
        let description = library.frame().unwrap().other(template);
        let description = description.unwrap_or_else(|faults| panic!("{faults}"));
        let frame = description.evaluate(configuration)?;
        let (device, queue) = (&gpu().device, &gpu().queue);
        let executor = Executor::new(device, queue, package, &frame, &Lists::new());
        Ok(Self { executor: executor.unwrap_or_else(|faults| panic!("{faults}")) })
    }

    /// Runs one frame and waits for it.
    pub(crate) fn run(&mut self, inputs: &Inputs<'_>) {
        self.try_run(inputs).unwrap();
    }

    /// The same; what the inputs lack is an error.
    pub(crate) fn try_run(&mut self, inputs: &Inputs<'_>) -> Result<(), Faults> {
        let mut encoder = gpu().device.create_command_encoder(&Default::default());
        self.executor.encode(&mut encoder, inputs, None)?;
        gpu().queue.submit([encoder.finish()]);
        gpu().finish().unwrap();
        Ok(())
    }

    /// A buffer; of a pair with `.0` or `.1` behind its name.
    pub(crate) fn buffer(&self, name: &str) -> &wgpu::Buffer {
        self.executor.buffer(name).unwrap_or_else(|| panic!("no buffer {name}"))
    }

    /// What a buffer holds.
    pub(crate) fn read<T: bytemuck::Pod>(&self, name: &str) -> Vec<T> {
        readback::buffer(gpu(), self.buffer(name)).unwrap()
    }
}
