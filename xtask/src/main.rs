//! The command line of sglow: each command is one file in [`command`], and does little but call the libraries.

use std::process::ExitCode;

use clap::Parser as _;

mod cli;
mod command;
mod options;
mod progress;
mod say;
mod scene;

fn main() -> ExitCode {
    let Some(command) = cli::Cli::parse().command else {
        say::line(cli::introduction());
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
