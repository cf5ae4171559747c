//! Evaluates a description for configurations: on standard input the description in JSON, as a manifest holds it under
//! `graph`, in the first line, and a configuration in each line behind it.
//!
//! `cargo run -p sglow-graph --example evaluate < lines > frames`
//!
//! Each line of the result is a frame, or `{"errors": …}`. Evaluators in other languages are compared with it.

use std::error::Error;
use std::io::{BufRead as _, Write as _};

use sglow_graph::{Configuration, Description};

fn main() -> Result<(), Box<dyn Error>> {
    let mut lines = std::io::stdin().lock().lines();
    let description = lines.next().ok_or("expected a description in the first line")??;
    let description: Description = serde_json::from_str(&description)?;
    let mut out = std::io::stdout().lock();
    for line in lines {
        let configuration: Configuration = serde_json::from_str(&line?)?;
        let frame = match description.evaluate(&configuration) {
            Ok(frame) => serde_json::to_string(&frame)?,
            Err(errors) => serde_json::json!({ "errors": errors.to_string() }).to_string(),
        };
        writeln!(out, "{frame}")?;
    }
    Ok(())
}
