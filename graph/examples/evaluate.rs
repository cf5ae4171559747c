//! Evaluates a description for configurations: on standard input the description in JSON, as a manifest holds it under
//! `graph`, in the first line, and a configuration in each line behind it. One with `set` is changed from the defaults of
//! the class of its facts, or from its `preset`, by the axes and parameters in it.
//!
//! `cargo run -p sglow-graph --example evaluate < lines > frames`
//!
//! Each line of the result is a frame, or `{"errors": …}`. Evaluators in other languages are compared with it.

use std::error::Error;
use std::io::{BufRead as _, Write as _};

use serde::Deserialize;
use sglow_graph::configuration::Configuration;
use sglow_graph::description::{Description, Setting, Table};

#[derive(Deserialize)]
struct Request {
    preset: Option<String>,
    set: Option<Table<Setting>>,
    #[serde(flatten)]
    configuration: Configuration,
}

fn main() -> Result<(), Box<dyn Error>> {
    let mut lines = std::io::stdin().lock().lines();
    let description = lines.next().ok_or("expected a description in the first line")??;
    let description: Description = serde_json::from_str(&description)?;
    let mut out = std::io::stdout().lock();
    for line in lines {
        let Request { preset, set, configuration } = serde_json::from_str(&line?)?;
        let configured = set.map_or(Ok(configuration.clone()), |set| {
            let made = description.configure(&configuration.facts, preset.as_deref(), &set)?;
            let Configuration { axes, parameters, .. } = made;
            Ok(Configuration { axes, parameters, ..configuration })
        });
        let frame = match configured.and_then(|configuration| description.evaluate(&configuration))
        {
            Ok(frame) => serde_json::to_string(&frame)?,
            Err(errors) => serde_json::json!({ "errors": errors.to_string() }).to_string(),
        };
        writeln!(out, "{frame}")?;
    }
    Ok(())
}
