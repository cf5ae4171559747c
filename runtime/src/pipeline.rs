//! Modules of variants, with what a device refuses as errors that name them.

use thiserror::Error;

use crate::package::{Package, PackageError};
use crate::timing::{PassTimer, Stamps};

/// Why a variant does not become a pipeline.
#[derive(Debug, Error)]
pub enum PipelineError {
    /// The package does not give its text.
    #[error(transparent)]
    Package(#[from] PackageError),
    /// The device refuses it.
    #[error("variant '{id}' does not compile on this device: {message}")]
    Refused {
        /// The variant.
        id: String,
        /// What the device says.
        message: String,
    },
}

/// Runs `build` and turns what the device refuses in it into an error that names the variant.
///
/// # Errors
///
/// What the device says.
pub fn guarded<T>(
    device: &wgpu::Device,
    id: &str,
    build: impl FnOnce() -> T,
) -> Result<T, PipelineError> {
    let id = id.to_owned();
    checked(device, build).map_err(|message| PipelineError::Refused { id, message })
}

/// Runs `build`; or what the device says against it.
pub(crate) fn checked<T>(device: &wgpu::Device, build: impl FnOnce() -> T) -> Result<T, String> {
    let memory = device.push_error_scope(wgpu::ErrorFilter::OutOfMemory);
    let scope = device.push_error_scope(wgpu::ErrorFilter::Validation);
    let built = build();
    let wrong = pollster::block_on(scope.pop());
    match pollster::block_on(memory.pop()).or(wrong) {
        None => Ok(built),
        Some(error) => Err(error.to_string()),
    }
}

/// The shader module of a variant.
///
/// # Errors
///
/// When the package lacks it, or the device refuses it.
pub fn module(
    device: &wgpu::Device,
    package: &Package,
    id: &str,
) -> Result<wgpu::ShaderModule, PipelineError> {
    let text = package.text(id)?;
    guarded(device, id, || {
        device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some(id),
            source: wgpu::ShaderSource::Wgsl(text.into()),
        })
    })
}

/// Encodes one pass between the beginning and the end of its time.
pub(crate) fn timed(
    encoder: &mut wgpu::CommandEncoder,
    timer: Option<&mut (dyn PassTimer + '_)>,
    label: &str,
    encode: impl FnOnce(&mut wgpu::CommandEncoder, Option<&Stamps<'_>>),
) {
    match timer {
        None => encode(encoder, None),
        Some(timer) => {
            encode(encoder, timer.begin(label).as_ref());
            timer.end(encoder);
        }
    }
}
