//! A Vulkan driver where there is none.

use sglow_report::failure::{Failure, Result};

use crate::machine::apt;
use crate::machine::vulkan::{self, Vulkan};

/// Installs a software driver if there is none.
///
/// # Errors
///
/// When there is none and none can be installed; the help is the line to type.
pub fn ensure_vulkan(may_install: bool) -> Result {
    let before = Vulkan::find();
    if before.usable() {
        return Ok(());
    }
    eprintln!("No usable Vulkan driver: {}.", lack(&before));
    if let Some(variable) = &before.variable {
        return Err(Failure::new(format!("{variable} names no driver that can be loaded"))
            .help(format!("unset {variable}, or let it name a driver's JSON file")));
    }
    if !may_install {
        return Err(Failure::new("the tests need a Vulkan driver")
            .help(format!("type: {}", apt::line(&vulkan::PACKAGES))));
    }
    eprintln!("Installing Mesa's software driver (lavapipe).");
    apt::install(&vulkan::PACKAGES)?;
    let after = Vulkan::find();
    if after.usable() {
        return Ok(());
    }
    Err(Failure::new(format!(
        "no usable Vulkan driver even after installing {}: {}",
        vulkan::PACKAGES.join(" and "),
        lack(&after)
    )))
}

/// What a machine without a usable driver lacks.
fn lack(vulkan: &Vulkan) -> String {
    let mut lacks = Vec::new();
    if vulkan.loader.is_none() {
        lacks.push("there is no loader (libvulkan.so.1)".to_owned());
    }
    if vulkan.drivers.is_empty() {
        lacks.push("no driver is registered".to_owned());
    }
    lacks.extend(vulkan.drivers.iter().filter_map(|driver| {
        let fault = driver.fault.as_ref()?;
        Some(format!("{}: {fault}", driver.manifest.display()))
    }));
    lacks.join("; ")
}
