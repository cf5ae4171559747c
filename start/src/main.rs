//! What `cargo xtask` starts. The committed package needs the generator and no device: `gen-shaders` and `gen-shaders --check`
//! compile that alone, which takes half the time on a new machine and works while the bindings do not compile. All else
//! is the package `xtask`; for `test` it is built together with the tests, which select features of dependencies that it
//! does not, so that these are compiled once and not twice.

use std::ffi::OsStr;
use std::path::Path;
use std::process::{Command, ExitCode};

/// The arguments of cargo that build `xtask` with all tests, where a command line runs them all.
fn built(arguments: &[String]) -> Option<&'static [&'static str]> {
    let all = arguments == ["test"];
    all.then_some(&["build", "--workspace", "--bins", "--tests", "--examples"])
}

/// The arguments of cargo that run a command line.
fn run(arguments: &[String]) -> Vec<String> {
    let alone = match arguments {
        [command, rest @ ..] => command == "gen-shaders" && rest.iter().all(|one| one == "--check"),
        [] => false,
    };
    let program: &[&str] = if alone {
        &["--package", "sglow-shader-gen", "--bin", "committed", "--"]
    } else {
        &["--package", "xtask", "--"]
    };
    let rest = &arguments[usize::from(alone)..];
    std::iter::once("run")
        .chain(program.iter().copied())
        .map(str::to_owned)
        .chain(rest.iter().cloned())
        .collect()
}

/// Runs a program to its end.
fn status(program: &OsStr, arguments: &[String]) -> Result<(), ExitCode> {
    match Command::new(program).args(arguments).status() {
        Ok(status) if status.success() => Ok(()),
        Ok(status) => {
            let code = status.code().and_then(|code| u8::try_from(code).ok());
            Err(code.map_or(ExitCode::FAILURE, ExitCode::from))
        }
        Err(error) => {
            eprintln!("error: {} does not run: {error}", Path::new(program).display());
            Err(ExitCode::FAILURE)
        }
    }
}

fn main() -> ExitCode {
    let mut arguments = Vec::new();
    for argument in std::env::args_os().skip(1) {
        match argument.into_string() {
            Ok(argument) => arguments.push(argument),
            Err(argument) => {
                eprintln!("error: the argument {} is not UTF-8", argument.display());
                return ExitCode::FAILURE;
            }
        }
    }
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    // Where this runs, relative paths of the user stay what they are.
    let manifest = concat!(env!("CARGO_MANIFEST_DIR"), "/../Cargo.toml");
    let here = |mut line: Vec<String>| {
        line.splice(1..1, ["--manifest-path".to_owned(), manifest.to_owned()]);
        line
    };
    // Built for tests, `xtask` stands beside this program if that is of the same profile and target.
    let own = std::env::current_exe()
        .ok()
        .filter(|own| own.ends_with(format!("target/debug/start{}", std::env::consts::EXE_SUFFIX)));
    let ended = match (built(&arguments), own) {
        (Some(build), Some(own)) => {
            let build = build.iter().map(|&one| one.to_owned()).collect();
            let xtask = own.with_file_name(format!("xtask{}", std::env::consts::EXE_SUFFIX));
            status(&cargo, &here(build)).and_then(|()| status(xtask.as_os_str(), &arguments))
        }
        _ => status(&cargo, &here(run(&arguments))),
    };
    ended.err().unwrap_or(ExitCode::SUCCESS)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_committed_package_takes_the_generator_alone_and_all_else_the_command_line() {
        let of = |line: &str| {
            run(&line.split_whitespace().map(str::to_owned).collect::<Vec<_>>()).join(" ")
        };
        let alone = "run --package sglow-shader-gen --bin committed --";
        assert_eq!(of("gen-shaders"), alone);
        assert_eq!(of("gen-shaders --check"), format!("{alone} --check"));
        for line in
            ["", "gen-shaders --help", "gen-shaders --scene cornell", "render --check", "test"]
        {
            assert_eq!(of(line), format!("run --package xtask -- {line}").trim_end());
        }
    }

    #[test]
    fn all_tests_are_built_with_the_command_line_and_one_package_is_not() {
        let of = |line: &str| {
            built(&line.split_whitespace().map(str::to_owned).collect::<Vec<_>>()).is_some()
        };
        assert!(of("test"));
        for line in ["", "render", "test --help", "test -- --package sglow-oracle", "gen-shaders"] {
            assert!(!of(line), "{line}");
        }
    }
}
