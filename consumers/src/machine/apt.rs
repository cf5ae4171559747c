//! Packages of Debian-based systems, installed where that is allowed.

use std::process::Command;

use sglow_report::failure::{Context as _, Failure, Result};

use crate::machine::{first_line, program};

/// The line that a person types to install `packages`.
pub fn line(packages: &[&str]) -> String {
    format!(
        "sudo apt-get update && sudo apt-get install --yes --no-install-recommends {}",
        packages.join(" ")
    )
}

/// Installs `packages` if this user may without a password; shows each line it runs.
///
/// # Errors
///
/// When that is not allowed or does not work; the help is the line to type.
pub fn install(packages: &[&str]) -> Result {
    let refuse = |why: String| Failure::new(why).help(format!("type: {}", line(packages)));
    let list = packages.join(", ");
    let Some(apt) = program("apt-get") else {
        return Err(Failure::new(format!(
            "{list}: not installed, and this machine has no apt-get to install them with"
        ))
        .help("install what your system calls a Vulkan loader and Mesa's Vulkan drivers, such as `vulkan-loader` and `mesa-vulkan-drivers`, `vulkan-icd-loader` and `vulkan-swrast`"));
    };
    let root = first_line(Command::new("id").arg("-u")).as_deref() == Some("0");
    let sudo = program("sudo").filter(|sudo| {
        let silent = Command::new(sudo).args(["-n", "true"]).output();
        silent.is_ok_and(|output| output.status.success())
    });
    let prefix: Vec<String> = match (root, sudo) {
        (true, _) => Vec::new(),
        (false, Some(sudo)) => vec![sudo.display().to_string(), "-n".to_owned()],
        (false, None) => return Err(refuse(format!("{list}: not installed, and only root may"))),
    };
    let steps: [&[&str]; 2] = [&["update"], &["install", "--yes", "--no-install-recommends"]];
    for (step, names) in steps.into_iter().zip([&[][..], packages]) {
        let mut words = prefix.clone();
        words.extend(["env".to_owned(), "DEBIAN_FRONTEND=noninteractive".to_owned()]);
        words.push(apt.display().to_string());
        words.extend(step.iter().chain(names).map(|&word| word.to_owned()));
        let shown = words.join(" ");
        eprintln!("+ {shown}");
        let status = Command::new(&words[0]).args(&words[1..]).status().context(&shown)?;
        if !status.success() {
            return Err(refuse(format!("`{shown}` ended with {status}")));
        }
    }
    Ok(())
}
