//! RADV's device without hardware.

use ash::{Entry, Instance, khr, vk};

use crate::capability::{Features, find};
use crate::error::Error;

/// The driver, and what it can do.
pub(crate) struct Driver {
    // Holds the loader's library, which has to stay while the instance does.
    _entry: Entry,
    instance: Instance,
    physical: vk::PhysicalDevice,
    supported: Features,
    family: String,
    /// Driver and version.
    pub(crate) name: String,
    /// The device's name.
    pub(crate) device: String,
}

/// A device with just the features of one module.
pub(crate) struct Device {
    pub(crate) raw: ash::Device,
    pub(crate) executables: khr::pipeline_executable_properties::Device,
}

impl Driver {
    /// Loads the driver. The environment has to be set before.
    pub(crate) fn open(family: &str) -> Result<Self, Error> {
        let failed = |call| {
            move |result| Error::Vulkan { subject: format!("family `{family}`"), call, result }
        };
        // SAFETY: the loader is the system's; its initialisers have no conditions of their own.
        let entry = unsafe { Entry::load() }.map_err(|error| Error::Loader(error.to_string()))?;
        let application = vk::ApplicationInfo::default().api_version(vk::API_VERSION_1_3);
        let create = vk::InstanceCreateInfo::default().application_info(&application);
        // SAFETY: `create` and what it points to live through the call.
        let instance =
            unsafe { entry.create_instance(&create, None) }.map_err(failed("vkCreateInstance"))?;
        let mut driver = Self {
            _entry: entry,
            instance,
            physical: vk::PhysicalDevice::null(),
            supported: Features::default(),
            family: family.to_owned(),
            name: String::new(),
            device: String::new(),
        };
        // SAFETY: the instance is alive.
        let all = unsafe { driver.instance.enumerate_physical_devices() }
            .map_err(failed("vkEnumeratePhysicalDevices"))?;
        let mut there = Vec::new();
        for physical in all {
            let mut of_driver = vk::PhysicalDeviceDriverProperties::default();
            let mut of_device = vk::PhysicalDeviceProperties2::default().push_next(&mut of_driver);
            // SAFETY: `physical` is of this instance, and the chain lives through the call.
            unsafe { driver.instance.get_physical_device_properties2(physical, &mut of_device) };
            let properties = of_device.properties;
            let device = text(properties.device_name_as_c_str());
            // With a real device the driver would compile for what is there, whatever family is requested.
            if of_driver.driver_id == vk::DriverId::MESA_RADV && device.contains("Null hardware") {
                driver.name = format!(
                    "{} {}",
                    text(of_driver.driver_name_as_c_str()),
                    text(of_driver.driver_info_as_c_str())
                );
                (driver.physical, driver.device) = (physical, device);
                driver.supported = driver.features();
                return Ok(driver);
            }
            there.push(device);
        }
        Err(Error::NoDevice { family: family.to_owned(), there })
    }

    fn features(&self) -> Features {
        let mut all = Features::default();
        let mut whole = vk::PhysicalDeviceFeatures2::default()
            .push_next(&mut all.v11)
            .push_next(&mut all.v12)
            .push_next(&mut all.v13);
        // SAFETY: the physical device is of this instance, and the chain lives through the call.
        unsafe { self.instance.get_physical_device_features2(self.physical, &mut whole) };
        let base = whole.features;
        all.base = base;
        // The chain's links point into this frame; the values are all that is kept.
        all.v11.p_next = std::ptr::null_mut();
        all.v12.p_next = std::ptr::null_mut();
        all.v13.p_next = std::ptr::null_mut();
        all
    }

    /// The first feature that a module with these capabilities needs and the device lacks. Capabilities have to be
    /// known ones.
    pub(crate) fn lacks(
        &self,
        capabilities: impl IntoIterator<Item = u32>,
    ) -> Option<&'static str> {
        let mut supported = self.supported;
        capabilities
            .into_iter()
            .filter_map(|number| find(number)?.feature)
            .find(|(_, place)| *place(&mut supported) == vk::FALSE)
            .map(|(name, _)| name)
    }

    /// A device for modules with these capabilities.
    pub(crate) fn device(
        &self,
        capabilities: impl IntoIterator<Item = u32>,
    ) -> Result<Device, Error> {
        let mut features = Features::default();
        for (_, place) in capabilities.into_iter().filter_map(|number| find(number)?.feature) {
            *place(&mut features) = vk::TRUE;
        }
        let mut executables = vk::PhysicalDevicePipelineExecutablePropertiesFeaturesKHR::default()
            .pipeline_executable_info(true);
        let mut whole = vk::PhysicalDeviceFeatures2::default()
            .features(features.base)
            .push_next(&mut features.v11)
            .push_next(&mut features.v12)
            .push_next(&mut features.v13)
            .push_next(&mut executables);
        let queue = vk::DeviceQueueCreateInfo::default().queue_priorities(&[1.0]);
        let extensions = [khr::pipeline_executable_properties::NAME.as_ptr()];
        let create = vk::DeviceCreateInfo::default()
            .queue_create_infos(std::slice::from_ref(&queue))
            .enabled_extension_names(&extensions)
            .push_next(&mut whole);
        // SAFETY: the physical device is of this instance, and all that `create` points to lives through the call.
        let raw = unsafe { self.instance.create_device(self.physical, &create, None) }.map_err(
            |result| Error::Vulkan {
                subject: format!("family `{}`", self.family),
                call: "vkCreateDevice",
                result,
            },
        )?;
        let executables = khr::pipeline_executable_properties::Device::new(&self.instance, &raw);
        Ok(Device { raw, executables })
    }
}

impl Drop for Driver {
    fn drop(&mut self) {
        // SAFETY: devices are dropped before the driver (see `here.rs`), and nothing else uses the instance.
        unsafe { self.instance.destroy_instance(None) };
    }
}

impl Drop for Device {
    fn drop(&mut self) {
        // SAFETY: the objects of a device are dropped when a module is done, so that none is left.
        unsafe { self.raw.destroy_device(None) };
    }
}

/// A name of the driver; a text without end is a fault of the driver, and shown as such.
pub(crate) fn text<E>(name: Result<&std::ffi::CStr, E>) -> String {
    name.map_or_else(|_| "(unterminated)".to_owned(), |name| name.to_string_lossy().into_owned())
}
