//! A device to run on, and what is known of it.

use sglow_runtime::indirect::Source;
use sglow_runtime::package::Package;
use std::sync::{Arc, Mutex};

use thiserror::Error;

/// Errors of devices: there is none, or none any more.
#[derive(Debug, Error)]
pub enum DeviceError {
    /// No adapter at all.
    #[error(
        "no GPU adapter was found: install a Vulkan driver (a software one is in Debian's and Ubuntu's mesa-vulkan-drivers)"
    )]
    NoAdapter,
    /// No adapter of the wanted name.
    #[error("no adapter is named like '{wanted}'; there are: {}", known.join(", "))]
    UnknownAdapter {
        /// What was requested.
        wanted: String,
        /// The adapters that exist.
        known: Vec<String>,
    },
    /// The adapter gave no device.
    #[error("adapter '{adapter}' gave no device: {source}")]
    NoDevice {
        /// The adapter's name.
        adapter: String,
        /// What the driver said.
        source: wgpu::RequestDeviceError,
    },
    /// The device was lost.
    #[error(
        "the device '{adapter}' was lost ({reason}); what it held is gone, so open a new one and render again"
    )]
    Lost {
        /// The adapter's name.
        adapter: String,
        /// What the driver said.
        reason: String,
    },
    /// The device refused something.
    #[error("the device '{adapter}' refused its work: {}", messages.join("; "))]
    Refused {
        /// The adapter's name.
        adapter: String,
        /// Each refusal.
        messages: Vec<String>,
    },
}

/// What a report says of an adapter.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct AdapterFacts {
    /// The adapter's name.
    pub name: String,
    /// The driver's name and version.
    pub driver: String,
    /// `Vulkan`, for example.
    pub backend: String,
    /// Whether the adapter is a software rasterizer: its times compare variants and do not predict those of GPUs.
    pub software: bool,
}

#[derive(Default)]
struct Trouble {
    lost: Option<String>,
    refused: Vec<String>,
}

/// A device, its queue, and what went wrong on it.
pub struct Gpu {
    /// The device.
    pub device: wgpu::Device,
    /// Its queue.
    pub queue: wgpu::Queue,
    /// What is known of the adapter.
    pub adapter: AdapterFacts,
    trouble: Arc<Mutex<Trouble>>,
}

fn facts(adapter: &wgpu::Adapter) -> AdapterFacts {
    let info = adapter.get_info();
    AdapterFacts {
        name: info.name,
        driver: format!("{} {}", info.driver, info.driver_info).trim().to_owned(),
        backend: info.backend.to_string(),
        software: info.device_type == wgpu::DeviceType::Cpu,
    }
}

fn adapters() -> Vec<wgpu::Adapter> {
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
    pollster::block_on(instance.enumerate_adapters(wgpu::Backends::PRIMARY))
}

/// Every adapter of this machine.
pub fn list() -> Vec<AdapterFacts> {
    adapters().iter().map(facts).collect()
}

/// An error message of several lines, as one.
fn one_line(text: &str) -> String {
    let lines = text.lines().map(str::trim);
    let lines = lines.filter(|line| !line.is_empty() && *line != "Caused by:");
    lines.collect::<Vec<_>>().join(": ")
}

impl Gpu {
    /// This device with a package: what frames are made on and of.
    pub fn source<'a>(&'a self, package: &'a Package) -> Source<'a> {
        Source { device: &self.device, queue: &self.queue, package }
    }

    /// Opens the adapter whose name contains `wanted`, or else the most capable one.
    ///
    /// Optional features that the variants can use (time stamps, filtering of 32-bit floats) are switched on where the
    /// adapter has them.
    pub fn open(wanted: Option<&str>) -> Result<Self, DeviceError> {
        let mut adapters = adapters();
        if adapters.is_empty() {
            return Err(DeviceError::NoAdapter);
        }
        if let Some(wanted) = wanted {
            let known: Vec<String> =
                adapters.iter().map(|adapter| adapter.get_info().name).collect();
            adapters.retain(|adapter| {
                adapter.get_info().name.to_lowercase().contains(&wanted.to_lowercase())
            });
            if adapters.is_empty() {
                return Err(DeviceError::UnknownAdapter { wanted: wanted.to_owned(), known });
            }
        }
        adapters.sort_by_key(|adapter| match adapter.get_info().device_type {
            wgpu::DeviceType::DiscreteGpu => 0,
            wgpu::DeviceType::IntegratedGpu => 1,
            wgpu::DeviceType::VirtualGpu => 2,
            wgpu::DeviceType::Other => 3,
            wgpu::DeviceType::Cpu => 4,
        });
        let adapter = adapters.swap_remove(0);
        let optional = wgpu::Features::TIMESTAMP_QUERY | wgpu::Features::FLOAT32_FILTERABLE;
        let available = adapter.limits();
        let limits = wgpu::Limits {
            max_texture_dimension_2d: available.max_texture_dimension_2d,
            max_buffer_size: available.max_buffer_size,
            max_storage_buffer_binding_size: available.max_storage_buffer_binding_size,
            ..wgpu::Limits::default()
        };
        let facts = facts(&adapter);
        let (device, queue) = pollster::block_on(adapter.request_device(&wgpu::DeviceDescriptor {
            label: Some("sglow"),
            required_features: adapter.features() & optional,
            required_limits: limits,
            ..wgpu::DeviceDescriptor::default()
        }))
        .map_err(|source| DeviceError::NoDevice { adapter: facts.name.clone(), source })?;
        let trouble = Arc::new(Mutex::new(Trouble::default()));
        let lost = Arc::clone(&trouble);
        device.set_device_lost_callback(move |reason, message| {
            if let Ok(mut trouble) = lost.lock() {
                trouble.lost = Some(format!("{reason:?}: {message}"));
            }
        });
        let refused = Arc::clone(&trouble);
        device.on_uncaptured_error(Arc::new(move |error: wgpu::Error| {
            if let Ok(mut trouble) = refused.lock() {
                trouble.refused.push(one_line(&error.to_string()));
            }
        }));
        Ok(Self { device, queue, adapter: facts, trouble })
    }

    /// Whether passes can be timed by the device itself.
    ///
    /// A software driver may offer time stamps that do not enclose compute work: lavapipe (Mesa 22.3.6) runs a dispatch
    /// when it is encoded and writes the stamps when it rasterises, and so gives 0.1 ms for a second of shading.
    pub fn has_timestamps(&self) -> bool {
        !self.adapter.software && self.device.features().contains(wgpu::Features::TIMESTAMP_QUERY)
    }

    /// Whether 32-bit float textures can be filtered by samplers.
    pub fn filters_float32(&self) -> bool {
        self.device.features().contains(wgpu::Features::FLOAT32_FILTERABLE)
    }

    /// Waits for all work, and says what went wrong since the last time.
    pub fn finish(&self) -> Result<(), DeviceError> {
        let waited = self.device.poll(wgpu::PollType::wait_indefinitely());
        let mut trouble = match self.trouble.lock() {
            Ok(trouble) => trouble,
            Err(poisoned) => poisoned.into_inner(),
        };
        if let Some(reason) = &trouble.lost {
            return Err(DeviceError::Lost {
                adapter: self.adapter.name.clone(),
                reason: reason.clone(),
            });
        }
        let mut messages = std::mem::take(&mut trouble.refused);
        if let Err(error) = waited {
            messages.push(one_line(&error.to_string()));
        }
        if messages.is_empty() {
            Ok(())
        } else {
            Err(DeviceError::Refused { adapter: self.adapter.name.clone(), messages })
        }
    }
}
