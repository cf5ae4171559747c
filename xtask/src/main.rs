//! The command line of sglow: each command is one file in [`command`], and does little but call the libraries.

use std::process::ExitCode;

use clap::Parser as _;
use sglow_report::terminal::nearest::nearest;

mod cli;
mod command;
mod options;
mod progress;
mod say;
mod scene;

/// The line that an error ends in, if one of the names that it lists is like the one that is unknown.
fn tip(error: &str) -> String {
    let tip = |name| format!("\n  tip: a similar name exists: '{name}'");
    nearest(error).filter(|_| !error.contains("tip:")).map_or_else(String::new, tip)
}

fn main() -> ExitCode {
    let cli = cli::Cli::try_parse().unwrap_or_else(|error| {
        let tip = tip(&error.to_string());
        let _ = error.print();
        if !tip.is_empty() {
            eprintln!("{tip}");
        }
        std::process::exit(error.exit_code())
    });
    let Some(command) = cli.command else {
        say::line(cli::introduction());
        return ExitCode::SUCCESS;
    };
    match command.run() {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            let text = failure.to_string();
            eprintln!("{text}{}", tip(&text));
            ExitCode::FAILURE
        }
    }
}
