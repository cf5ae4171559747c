//! The machine this runs on: its programs, its Vulkan drivers, and how it gets what it lacks.

use std::path::{Path, PathBuf};
use std::process::Command;

pub mod apt;
pub mod driver;
pub mod vulkan;

/// The root of the repository.
pub fn repository() -> PathBuf {
    let own = Path::new(env!("CARGO_MANIFEST_DIR"));
    own.parent().unwrap_or(own).to_path_buf()
}

/// The folder of the library.
#[must_use]
pub fn library_folder() -> PathBuf {
    repository().join("shaders")
}

/// Where builds and downloads lie that git does not see.
pub fn target_folder() -> PathBuf {
    match std::env::var_os("CARGO_TARGET_DIR") {
        Some(folder) if !folder.is_empty() => repository().join(folder),
        _ => repository().join("target"),
    }
}

/// The cargo that runs this, or the one on the path.
pub fn cargo() -> Command {
    let mut cargo = Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
    cargo.current_dir(repository());
    cargo
}

/// Where a program lies.
pub fn program(name: &str) -> Option<PathBuf> {
    which::which(name).ok()
}

/// The first line that a command prints.
pub fn first_line(command: &mut Command) -> Option<String> {
    let output = command.output().ok().filter(|output| output.status.success())?;
    let text = String::from_utf8_lossy(&output.stdout);
    text.lines().next().map(|line| line.trim().to_owned())
}
