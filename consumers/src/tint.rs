//! Tint, the shader compiler of Dawn and Chromium: in Node it reads WGSL, in Python SPIR-V.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use serde::{Deserialize, Serialize};
use serde_json::json;
use sglow_report::failure::{Context as _, Failure, Result};
use sglow_report::write;
use sglow_results::progress::Progress;

use crate::machine::{apt, program, target_folder};
use crate::subject::Subject;

/// The packages of Debian that bring SwiftShader, a Vulkan driver in software that Dawn accepts.
pub const SWIFTSHADER_PACKAGES: [&str; 1] = ["chromium-common"];
/// Where browsers leave SwiftShader's manifest.
const SWIFTSHADER: [&str; 4] = [
    "/usr/lib/chromium/vk_swiftshader_icd.json",
    "/usr/lib64/chromium-browser/vk_swiftshader_icd.json",
    "/opt/google/chrome/vk_swiftshader_icd.json",
    "/snap/chromium/current/usr/lib/chromium-browser/vk_swiftshader_icd.json",
];
/// npm's package of Dawn for Node.
const WEBGPU: &str = "0.6.2";
/// PyPI's package of Dawn for Python.
const DAWN_PYTHON: &str = "0.3.0";

/// What a consumer says of all modules.
#[derive(Debug, Deserialize)]
pub struct Verdicts {
    /// The GPU, or what took its place.
    pub adapter: String,
    /// Its driver.
    pub driver: String,
    /// Versions of what took part.
    pub versions: BTreeMap<String, String>,
    /// One per module.
    pub results: Vec<Verdict>,
}

/// What a consumer says of one module.
#[derive(Debug, Deserialize, Serialize)]
pub struct Verdict {
    /// The module.
    pub name: String,
    /// `valid`, `invalid` or `skipped`.
    pub state: String,
    /// How many compute pipelines were made of it.
    pub pipelines: usize,
    /// What the consumer has to say.
    pub messages: Vec<String>,
}

/// How a consumer is run: variants, modules that are broken on purpose, a folder for its files.
pub type Read = fn(&[Subject], &[Subject], &Path, &dyn Progress) -> Result<Verdicts>;

/// SwiftShader's manifest, if a browser brought one.
pub fn swiftshader() -> Option<PathBuf> {
    SWIFTSHADER.map(PathBuf::from).into_iter().find(|path| path.exists())
}

/// Lets Tint read WGSL, through Dawn in Node.
///
/// # Errors
///
/// When Node, Dawn or a device for it is missing.
pub fn read_wgsl(
    subjects: &[Subject],
    controls: &[Subject],
    folder: &Path,
    progress: &dyn Progress,
) -> Result<Verdicts> {
    let lacking = |what: &str, package: &str| {
        Failure::new(format!("{what} is not installed"))
            .help(format!("type: {}", apt::line(&[package])))
    };
    let node = program("node").ok_or_else(|| lacking("Node", "nodejs"))?;
    let npm = program("npm").ok_or_else(|| lacking("npm", "npm"))?;
    let modules = target_folder().join("verify/node");
    install_once(
        &modules,
        "node_modules/webgpu",
        &format!("npm webgpu {WEBGPU}"),
        || {
            let package = json!({"private": true, "dependencies": {"webgpu": WEBGPU}});
            write::text(&modules.join("package.json"), &package.to_string())?;
            succeed(
                Command::new(npm)
                    .args(["install", "--no-audit", "--no-fund", "--ignore-scripts"])
                    .current_dir(&modules),
            )
        },
        progress,
    )?;
    let entries = subjects.iter().chain(controls).map(|subject| entry(subject, &subject.wgsl));
    let mut command = Command::new(node);
    command.arg(script("tint.mjs")).arg(&modules);
    run("Tint reads WGSL", command, entries.collect(), folder, progress)
}

/// Lets Tint read SPIR-V, through Dawn in Python: WebGPU in JavaScript takes WGSL alone.
///
/// # Errors
///
/// When Python, Dawn or a device for it is missing.
pub fn read_spirv(
    subjects: &[Subject],
    controls: &[Subject],
    folder: &Path,
    progress: &dyn Progress,
) -> Result<Verdicts> {
    let python = program("python3").ok_or_else(|| {
        Failure::new("Python is not installed")
            .help(format!("type: {}", apt::line(&["python3", "python3-venv"])))
    })?;
    let environment = target_folder().join("verify/python");
    let own_python = environment.join("bin/python");
    install_once(
        &environment,
        "bin/python",
        &format!("dawn-python {DAWN_PYTHON}"),
        || {
            succeed(Command::new(python).args(["-m", "venv"]).arg(&environment))?;
            succeed(
                Command::new(&own_python)
                    .args(["-m", "pip", "install", "--quiet", "--disable-pip-version-check"])
                    .arg(format!("dawn-python=={DAWN_PYTHON}")),
            )
        },
        progress,
    )?;
    let entries = subjects.iter().chain(controls).filter_map(|subject| {
        let spirv = subject.spirv.as_ref()?;
        Some(entry(subject, spirv))
    });
    let mut command = Command::new(own_python);
    command.arg(script("tint_spirv.py"));
    run("Tint reads SPIR-V", command, entries.collect(), folder, progress)
}

fn entry(subject: &Subject, file: &Path) -> serde_json::Value {
    json!({
        "name": subject.name,
        "file": file,
        "features": subject.features,
        "entry_points": subject.entry_points,
    })
}

fn script(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("scripts").join(name)
}

/// Runs a script with the list of modules and the file for its verdicts as last arguments.
fn run(
    doing: &str,
    mut command: Command,
    entries: Vec<serde_json::Value>,
    folder: &Path,
    progress: &dyn Progress,
) -> Result<Verdicts> {
    let (list, result) = (folder.join("list.json"), folder.join("result.json"));
    fs::write(&list, serde_json::to_string(&entries)?).context(list.display())?;
    if result.exists() {
        fs::remove_file(&result).context(result.display())?;
    }
    command.arg(&list).arg(&result);
    if let Some(icd) = swiftshader() {
        command.env("VK_ICD_FILENAMES", icd).env_remove("VK_DRIVER_FILES");
    }
    progress.start(&format!("{doing} ({})", entries.len()), 0);
    let ran = succeed(&mut command);
    progress.end();
    ran.map_err(|failure| {
        if swiftshader().is_some() {
            failure
        } else {
            failure.help(format!(
                "Dawn may lack a driver that it accepts, such as SwiftShader; type: {}",
                apt::line(&SWIFTSHADER_PACKAGES)
            ))
        }
    })?;
    let text = fs::read_to_string(&result).context("the script wrote no result")?;
    serde_json::from_str(&text).context("the script's result is not what is expected")
}

/// Makes `folder` by `install` unless it was made whole before for the same `version`.
fn install_once(
    folder: &Path,
    marker: &str,
    version: &str,
    install: impl FnOnce() -> Result,
    progress: &dyn Progress,
) -> Result {
    let stamp = folder.join("installed");
    let done = fs::read_to_string(&stamp).is_ok_and(|found| found == version);
    if done && folder.join(marker).exists() {
        return Ok(());
    }
    if folder.exists() {
        fs::remove_dir_all(folder).context(folder.display())?;
    }
    fs::create_dir_all(folder).context(folder.display())?;
    progress.start(&format!("fetching {version}"), 0);
    let installed = install();
    progress.end();
    installed?;
    write::text(&stamp, version)
}

/// Runs `command` silently.
///
/// # Errors
///
/// When it fails; with the end of what it said.
pub fn succeed(command: &mut Command) -> Result {
    let shown = Path::new(command.get_program()).display().to_string();
    let output = command.output().context(&shown)?;
    if output.status.success() {
        return Ok(());
    }
    let said = [output.stdout, output.stderr].concat();
    let said = String::from_utf8_lossy(&said);
    let lines: Vec<&str> = said.lines().collect();
    let last = &lines[lines.len().saturating_sub(12)..];
    Err(Failure::new(format!("{shown} ended with {}:\n{}", output.status, last.join("\n"))))
}
