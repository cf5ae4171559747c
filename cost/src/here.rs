//! Compiling in this process.

use std::collections::BTreeMap;
use std::env;
use std::fs;

use crate::capability::find;
use crate::cost::{Compiler, Costs, Skipped};
use crate::device::Driver;
use crate::error::Error;
use crate::issue::Generation;
use crate::pipeline::cost;
use crate::request::{Request, Shader};
use crate::spirv::{self, Module};

/// The variable that gives RADV a device without hardware.
pub(crate) const FAMILY: &str = "RADV_FORCE_FAMILY";

/// Compiles shaders. `RADV_FORCE_FAMILY` has to be the request's family, and Vulkan's loader has to find RADV, from the
/// start of the process on: [`compile`](crate::compile) sets both. `before` is called with each variant's identifier
/// before it is compiled; if the driver crashes, it does so on the last one.
///
/// # Errors
///
/// When the environment is another one, a module cannot be read, or the driver fails.
pub fn compile_here(request: &Request, mut before: impl FnMut(&str)) -> Result<Costs, Error> {
    match env::var(FAMILY) {
        Ok(family) if family == request.family => {}
        found => {
            return Err(Error::Environment {
                variable: FAMILY.to_owned(),
                found: found.map_or_else(|_| "not set".to_owned(), |family| format!("`{family}`")),
                right: request.family.clone(),
            });
        }
    }
    // Everything that can be refused is, before anything is compiled.
    let mut modules = Vec::new();
    for shader in &request.shaders {
        modules.push((shader, module(shader)?));
    }
    let driver = Driver::open(&request.family)?;
    let mut costs = Costs {
        compiler: Compiler {
            driver: driver.name.clone(),
            family: request.family.clone(),
            device: driver.device.clone(),
        },
        costs: Vec::new(),
        skipped: Vec::new(),
    };
    let generation = Generation::of(&request.family);
    // Declared after the driver, so that devices are dropped before it.
    let mut devices = BTreeMap::new();
    for (shader, module) in &modules {
        before(&shader.id);
        let capabilities = || module.capabilities.iter().copied();
        if let Some(feature) = driver.lacks(capabilities()) {
            let why = format!("the device lacks `{feature}`");
            costs.skipped.push(Skipped { id: shader.id.clone(), why });
            continue;
        }
        if !devices.contains_key(&module.capabilities) {
            devices.insert(module.capabilities.clone(), driver.device(capabilities())?);
        }
        if let Some(device) = devices.get(&module.capabilities) {
            costs.costs.push(cost(device, shader, module, generation)?);
        }
    }
    costs.sort();
    Ok(costs)
}

fn module(shader: &Shader) -> Result<Module, Error> {
    let path = &shader.path;
    let bytes = fs::read(path).map_err(|source| Error::Read { path: path.clone(), source })?;
    let module = spirv::read(&bytes, path)?;
    if !module.entry_points.contains(&shader.entry_point) {
        return Err(Error::NoEntryPoint {
            path: path.clone(),
            name: shader.entry_point.clone(),
            there: module.entry_points,
        });
    }
    match module.capabilities.iter().find(|number| find(**number).is_none()) {
        Some(&number) => Err(Error::Capability { path: path.clone(), number }),
        None => Ok(module),
    }
}
