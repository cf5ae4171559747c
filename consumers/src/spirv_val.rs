//! The validator of SPIRV-Tools: a recent one that is built once, or else the system's.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::Command;

use sglow_report::failure::{Context as _, Failure, Result};
use sglow_results::progress::Progress;

use crate::machine::{apt, cargo, first_line, program, target_folder};
use crate::subject::Subject;
use crate::tint::{Verdict, Verdicts};

/// A validator for Vulkan 1.1.
pub enum Validator {
    /// Built from source, with its version.
    Built(PathBuf, String),
    /// The system's, with its version.
    System(PathBuf, String),
}

impl Validator {
    /// Builds a recent validator if a C++ compiler is here, and otherwise takes the system's.
    ///
    /// # Errors
    ///
    /// When there is neither.
    pub fn find(progress: &dyn Progress) -> Result<Self> {
        let why = match build(progress) {
            Ok(path) => {
                let version = version(&path);
                return Ok(Self::Built(path, version));
            }
            Err(why) => why,
        };
        eprintln!("spirv-val cannot be built: {why}");
        let path = program("spirv-val").ok_or_else(|| {
            Failure::new("no spirv-val can be built, and the system has none")
                .help(format!("type: {}", apt::line(&["g++"])))
        })?;
        let version = version(&path);
        eprintln!("using the system's instead, which may miss faults: {version}");
        Ok(Self::System(path, version))
    }

    /// Whether it may miss what a recent one finds.
    pub fn is_old(&self) -> bool {
        matches!(self, Self::System(..))
    }

    /// Its verdict on everything that has SPIR-V.
    ///
    /// # Errors
    ///
    /// When it cannot be run.
    pub fn read(
        &self,
        subjects: &[Subject],
        controls: &[Subject],
        progress: &dyn Progress,
    ) -> Result<Verdicts> {
        let (program, version, options) = match self {
            Self::Built(program, version) => (program, version, &[][..]),
            Self::System(program, version) => {
                (program, version, &["--target-env", "vulkan1.1"][..])
            }
        };
        progress.start("spirv-val", subjects.len() + controls.len());
        let mut results = Vec::new();
        for (done, subject) in subjects.iter().chain(controls).enumerate() {
            progress.done(done);
            let Some(spirv) = &subject.spirv else {
                continue;
            };
            let output = Command::new(program)
                .args(options)
                .arg(spirv)
                .output()
                .context(program.display())?;
            let valid = output.status.success();
            let said = [output.stdout, output.stderr].concat();
            results.push(Verdict {
                name: subject.name.clone(),
                state: if valid { "valid" } else { "invalid" }.to_owned(),
                pipelines: 0,
                messages: if valid {
                    Vec::new()
                } else {
                    vec![String::from_utf8_lossy(&said).trim().to_owned()]
                },
            });
        }
        progress.end();
        Ok(Verdicts {
            adapter: String::new(),
            driver: String::new(),
            versions: BTreeMap::from([("spirv-val".to_owned(), version.clone())]),
            results,
        })
    }
}

fn version(program: &Path) -> String {
    first_line(Command::new(program).arg("--version"))
        .unwrap_or_else(|| "of unknown version".to_owned())
}

/// Builds `consumers/spirv-val`, which lies outside the workspace because it takes minutes.
fn build(progress: &dyn Progress) -> Result<PathBuf> {
    if program("c++").is_none() {
        return Err(
            Failure::new("there is no C++ compiler").help(format!("type: {}", apt::line(&["g++"])))
        );
    }
    let target = target_folder().join("verify/spirv-val");
    let binary = target.join("release").join(format!("spirv-val{}", std::env::consts::EXE_SUFFIX));
    let doing = if binary.exists() {
        "looking at spirv-val"
    } else {
        "building SPIRV-Tools from source, once: about nine minutes of one core"
    };
    progress.start(doing, 0);
    let manifest = Path::new(env!("CARGO_MANIFEST_DIR")).join("spirv-val/Cargo.toml");
    let output = cargo()
        .args(["build", "--release", "--locked", "--quiet", "--manifest-path"])
        .arg(manifest)
        .arg("--target-dir")
        .arg(&target)
        .output()
        .context("cargo cannot be started")?;
    progress.end();
    if output.status.success() {
        return Ok(binary);
    }
    let said = String::from_utf8_lossy(&output.stderr);
    let last: Vec<&str> = said.lines().rev().take(12).collect();
    let last: Vec<&str> = last.into_iter().rev().collect();
    Err(Failure::new(format!("cargo ended with {}:\n{}", output.status, last.join("\n"))))
}
