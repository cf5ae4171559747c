//! Writes the committed package, or compares it with what the sources make of it: what `cargo xtask gen-shaders` is
//! without options, by the generator alone.
//!
//! `cargo run --package sglow-shader-gen --bin committed -- [--check]`

use std::io::IsTerminal as _;
use std::path::Path;
use std::process::ExitCode;
use std::time::Instant;

use sglow_shader_gen::library::Library;
use sglow_shader_gen::package::{self, Error, Options};

fn main() -> ExitCode {
    let check = std::env::args_os().skip(1).any(|argument| argument == "--check");
    let coloured = std::io::stderr().is_terminal();
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shaders");
    let library = match Library::load(&folder) {
        Ok(library) => library,
        Err(report) => {
            eprintln!("{}", report.render(coloured));
            return ExitCode::FAILURE;
        }
    };
    let start = Instant::now();
    let mut options = Options::new(folder.join("packages").join(library.package.name));
    options.check = check;
    options.cache = Some(folder.join("../target/generated"));
    match package::generate(&folder, &options, &mut |_| {}) {
        Ok(outcome) => {
            let (written, removed) = (outcome.written.len(), outcome.removed.len());
            let files = written + outcome.unchanged.len();
            let seconds = start.elapsed().as_secs_f64();
            println!(
                "{}: {files} files, {written} written, {removed} removed ({seconds:.2} s)",
                options.out.display()
            );
            ExitCode::SUCCESS
        }
        Err(Error::Library(report)) => {
            eprintln!("{}", report.render(coloured));
            ExitCode::FAILURE
        }
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}
