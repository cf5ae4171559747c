//! Evaluates a description, as `dump` prints it, for configurations on standard input, one in each line.
//!
//! `cargo run -p sglow-graph --example evaluate graph.json < configurations > frames`
//!
//! Each line of the result is a frame, or `{"errors": …}`.

use std::error::Error;
use std::io::{BufRead as _, Write as _};

use sglow_graph::{Configuration, Description};

fn main() -> Result<(), Box<dyn Error>> {
    let path = std::env::args().nth(1).ok_or("name the file of the description")?;
    let description: Description = serde_json::from_str(&std::fs::read_to_string(path)?)?;
    let mut out = std::io::stdout().lock();
    for line in std::io::stdin().lock().lines() {
        let configuration: Configuration = serde_json::from_str(&line?)?;
        let frame = match description.evaluate(&configuration) {
            Ok(frame) => serde_json::to_string(&frame)?,
            Err(errors) => serde_json::json!({ "errors": errors.to_string() }).to_string(),
        };
        writeln!(out, "{frame}")?;
    }
    Ok(())
}
