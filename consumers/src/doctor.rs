//! What this machine has and lacks.

use std::path::Path;
use std::process::Command;

use comfy_table::Table;
use serde::Serialize;
use sglow_report::table;
use sglow_results::check::{Check, Relation};

use crate::chromium;
use crate::machine::vulkan::{self, Vulkan};
use crate::machine::{apt, first_line, program};
use crate::tint::{SWIFTSHADER_PACKAGES, swiftshader};

/// Looks at everything. `gpus` are the GPUs that answer, a line each.
#[must_use]
pub fn findings(vulkan: &Vulkan, gpus: &[String]) -> Vec<Finding> {
    let mut findings = vec![rustc(), linker()];
    if cfg!(target_os = "linux") {
        findings.extend(drivers(vulkan));
    }
    findings.push(adapters(gpus));
    findings.extend(consumers());
    findings
}

/// The findings as a table.
#[must_use]
pub fn show(findings: &[Finding]) -> Table {
    let mut table = table::new(["", "what", "found", "needed for", "how to get it"]);
    for finding in findings {
        let mark = match (finding.present, finding.required) {
            (true, _) => "ok",
            (false, true) => "LACKS",
            (false, false) => "-",
        };
        table.add_row([mark, &finding.what, &finding.found, finding.needed_for, &finding.help]);
    }
    table
}

/// Something that a machine may have.
#[derive(Debug, Serialize)]
pub struct Finding {
    /// What it is.
    pub what: String,
    /// What needs it.
    pub needed_for: &'static str,
    /// Whether the tests cannot run without it.
    pub required: bool,
    /// Whether it is there.
    pub present: bool,
    /// Version and place, or what is wrong.
    pub found: String,
    /// What brings it, if it is missing.
    pub help: String,
}

impl Finding {
    /// That it is there.
    #[must_use]
    pub fn check(&self) -> Check {
        let present = f64::from(u8::from(self.present));
        Check::new(&self.what, present, "present", Relation::Equal, 1.0).note(&self.found)
    }
}

fn rustc() -> Finding {
    let wanted = env!("CARGO_PKG_RUST_VERSION");
    let rustc = std::env::var_os("RUSTC").unwrap_or_else(|| "rustc".into());
    let found = first_line(Command::new(rustc).arg("--version"));
    let present = found.as_deref().is_some_and(|line| at_least(line, wanted));
    Finding {
        what: "rustc".to_owned(),
        needed_for: "everything",
        required: true,
        present,
        found: found.unwrap_or_else(|| "none on the path".to_owned()),
        help: missing(present, format!("rustup toolchain install {wanted}")),
    }
}

/// Whether the first version in `line`, such as `rustc 1.95.0 (…)`, is `wanted` or later.
fn at_least(line: &str, wanted: &str) -> bool {
    let numbers = |version: &str| -> Vec<u32> {
        version.split(['.', '-']).map_while(|part| part.parse().ok()).collect()
    };
    let found = line.split_whitespace().map(numbers).find(|found| !found.is_empty());
    found.is_some_and(|found| found >= numbers(wanted))
}

fn linker() -> Finding {
    tool("cc", &["--version"], "linking", true, "sudo apt-get install gcc libc6-dev")
}

fn drivers(vulkan: &Vulkan) -> Vec<Finding> {
    let install = apt::line(&vulkan::PACKAGES);
    let mut findings = vec![Finding {
        what: "Vulkan loader".to_owned(),
        needed_for: "running shaders",
        required: true,
        present: vulkan.loader.is_some(),
        found: vulkan.loader.as_deref().map_or_else(|| "no libvulkan.so.1".to_owned(), shown),
        help: missing(vulkan.loader.is_some(), install.clone()),
    }];
    let loadable = vulkan.drivers.iter().filter(|driver| driver.fault.is_none());
    let names: Vec<String> = loadable.map(|driver| shown(&driver.manifest)).collect();
    findings.push(Finding {
        what: "Vulkan driver".to_owned(),
        needed_for: "running shaders",
        required: true,
        present: !names.is_empty(),
        found: match (&vulkan.variable, names.is_empty()) {
            (None, true) => "none is registered".to_owned(),
            (Some(variable), true) => format!("none that {variable} names"),
            (_, false) => names.join("\n"),
        },
        help: missing(!names.is_empty(), install),
    });
    findings
}

/// The GPUs that answer, which a registered driver alone does not promise.
fn adapters(lines: &[String]) -> Finding {
    let present = !lines.is_empty();
    Finding {
        what: "GPU".to_owned(),
        needed_for: "running shaders",
        required: true,
        present,
        found: if present { lines.join("\n") } else { "no driver answers".to_owned() },
        help: missing(present, apt::line(&vulkan::PACKAGES)),
    }
}

/// What `verify` can use.
fn consumers() -> Vec<Finding> {
    let icd = swiftshader();
    vec![
        tool(
            "spirv-val",
            &["--version"],
            "verify, if no newer one can be built",
            false,
            "sudo apt-get install spirv-tools",
        ),
        tool(
            "c++",
            &["--version"],
            "verify: builds a recent spirv-val",
            false,
            "sudo apt-get install g++",
        ),
        tool(
            "node",
            &["--version"],
            "verify: Tint reads WGSL",
            false,
            "sudo apt-get install nodejs",
        ),
        tool("npm", &["--version"], "verify: Tint reads WGSL", false, "sudo apt-get install npm"),
        tool(
            "python3",
            &["--version"],
            "verify: Tint reads SPIR-V",
            false,
            "sudo apt-get install python3 python3-venv",
        ),
        Finding {
            what: "SwiftShader".to_owned(),
            needed_for: "verify: a device for Dawn",
            required: false,
            present: icd.is_some(),
            found: icd.as_deref().map_or_else(|| "none".to_owned(), shown),
            help: missing(icd.is_some(), apt::line(&SWIFTSHADER_PACKAGES)),
        },
        tool(
            "chromium",
            &["--version"],
            "verify: opens pages",
            false,
            &apt::line(&chromium::PACKAGES),
        ),
    ]
}

fn tool(
    name: &str,
    arguments: &[&str],
    needed_for: &'static str,
    required: bool,
    help: &str,
) -> Finding {
    let place = program(name);
    let version = place.as_ref().and_then(|place| first_line(Command::new(place).args(arguments)));
    Finding {
        what: name.to_owned(),
        needed_for,
        required,
        present: place.is_some(),
        found: match (&place, version) {
            (None, _) => "none on the path".to_owned(),
            (Some(place), None) => shown(place),
            (Some(place), Some(version)) => format!("{version}\n{}", shown(place)),
        },
        help: missing(place.is_some(), help.to_owned()),
    }
}

fn missing(present: bool, help: String) -> String {
    if present { String::new() } else { help }
}

fn shown(path: &Path) -> String {
    path.display().to_string()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn versions_compare_as_numbers() {
        assert!(at_least("rustc 1.95.0 (59807616e 2026-04-14)", "1.95"));
        assert!(at_least("rustc 1.100.0", "1.95"));
        assert!(at_least("rustc 2.0.0-nightly", "1.95"));
        assert!(!at_least("rustc 1.94.1", "1.95"));
        assert!(!at_least("no version at all", "1.95"));
    }
}
