//! The machine this runs on: its programs, its Vulkan drivers, and how it gets what it lacks.

use std::path::{Path, PathBuf};
use std::process::Command;

pub(crate) mod apt;
pub(crate) mod vulkan;

/// The root of the repository.
pub(crate) fn repository() -> PathBuf {
    let xtask = Path::new(env!("CARGO_MANIFEST_DIR"));
    xtask.parent().unwrap_or(xtask).to_path_buf()
}

/// Where builds and downloads lie that git does not see.
pub(crate) fn target_folder() -> PathBuf {
    match std::env::var_os("CARGO_TARGET_DIR") {
        Some(folder) if !folder.is_empty() => repository().join(folder),
        _ => repository().join("target"),
    }
}

/// The cargo that runs this, or the one on the path.
pub(crate) fn cargo() -> Command {
    let mut cargo = Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
    cargo.current_dir(repository());
    cargo
}

/// Where a program lies.
pub(crate) fn program(name: &str) -> Option<PathBuf> {
    which::which(name).ok()
}

/// The first line that a command prints.
pub(crate) fn first_line(command: &mut Command) -> Option<String> {
    let output = command.output().ok().filter(|output| output.status.success())?;
    let text = String::from_utf8_lossy(&output.stdout);
    text.lines().next().map(|line| line.trim().to_owned())
}
