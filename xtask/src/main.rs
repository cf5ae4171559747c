//! The command line of sglow: each command is one file in [`command`], and does little but call the libraries.

use std::process::ExitCode;

use clap::Parser as _;

mod cli;
mod command;
mod failure;
mod json;
mod machine;
#[expect(dead_code, reason = "`render` and `report` write pictures")]
mod picture;
mod progress;
mod table;
mod write;

fn main() -> ExitCode {
    let Some(command) = cli::Cli::parse().command else {
        print!("{}", cli::introduction());
        return ExitCode::SUCCESS;
    };
    match command.run() {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            eprintln!("{failure}");
            ExitCode::FAILURE
        }
    }
}
