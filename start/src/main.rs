//! What `cargo xtask` starts. The committed package needs the generator and no device: `gen-shaders` and `gen-shaders --check`
//! compile that alone, which takes half the time on a new machine and works while the bindings do not compile. All else
//! is the package `xtask`.

use std::process::{Command, ExitCode};

/// The arguments of cargo that run a command line.
fn run(arguments: &[String]) -> Vec<String> {
    let alone = match arguments {
        [command, rest @ ..] => command == "gen-shaders" && rest.iter().all(|one| one == "--check"),
        [] => false,
    };
    let program: &[&str] = if alone {
        &["--package", "sglow-shader-gen", "--example", "committed", "--"]
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
    let mut run = run(&arguments);
    run.splice(1..1, ["--manifest-path".to_owned(), manifest.to_owned()]);
    match Command::new(cargo).args(run).status() {
        Ok(status) => status.code().map_or(ExitCode::FAILURE, |code| {
            u8::try_from(code).map_or(ExitCode::FAILURE, ExitCode::from)
        }),
        Err(error) => {
            eprintln!("error: cargo does not run: {error}");
            ExitCode::FAILURE
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_committed_package_takes_the_generator_alone_and_all_else_the_command_line() {
        let of = |line: &str| {
            run(&line.split_whitespace().map(str::to_owned).collect::<Vec<_>>()).join(" ")
        };
        let alone = "run --package sglow-shader-gen --example committed --";
        assert_eq!(of("gen-shaders"), alone);
        assert_eq!(of("gen-shaders --check"), format!("{alone} --check"));
        for line in
            ["", "gen-shaders --help", "gen-shaders --scene cornell", "render --check", "test"]
        {
            assert_eq!(of(line), format!("run --package xtask -- {line}").trim_end());
        }
    }
}
