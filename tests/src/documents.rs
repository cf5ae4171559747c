//! Documents hold no figure that no command wrote, and no placeholder.

use std::path::{Path, PathBuf};

/// Tables whose numbers are definitions, formats or bounds that a named test holds, by document and heading.
const DEFINITIONS: [(&str, &str); 10] = [
    ("README.md", "Commands"),
    ("docs/conventions.md", "Surface textures"),
    ("docs/conventions.md", "Moments"),
    ("docs/deviations.md", "Light that is emitted"),
    ("docs/deviations.md", "Kernels"),
    ("docs/deviations.md", "Shading"),
    ("docs/numerics.md", "What stays in 32 bits when precision is f16"),
    ("docs/packages.md", "Packages"),
    ("docs/references.md", "Without visibility: the facets of the light's map"),
    ("docs/references.md", "With visibility: paths of one bounce"),
];

fn documents() -> Vec<(String, String)> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let mut paths: Vec<PathBuf> =
        ["README.md", "ARCHITECTURE.md", "CONTRIBUTING.md"].map(|name| root.join(name)).to_vec();
    for entry in std::fs::read_dir(root.join("docs")).unwrap() {
        paths.push(entry.unwrap().path());
    }
    paths.retain(|path| path.extension().is_some_and(|end| end == "md"));
    paths.sort();
    let name = |path: &Path| path.strip_prefix(&root).unwrap().display().to_string();
    paths.iter().map(|path| (name(path), std::fs::read_to_string(path).unwrap())).collect()
}

/// Whether a cell of a table holds a measured number: a decimal, a percentage, a time.
fn is_figure(cell: &str) -> bool {
    let numbers = cell.split(|c: char| !c.is_ascii_digit() && c != '.');
    let decimal = numbers.map(|part| part.trim_matches('.')).any(|part| {
        part.split_once('.').is_some_and(|(whole, rest)| !whole.is_empty() && !rest.contains('.'))
    });
    let unit = ["% ", "%,", "ms ", "MB "].iter().any(|unit| format!("{cell} ").contains(unit));
    cell.contains(|c: char| c.is_ascii_digit()) && (decimal || unit)
}

/// What is wrong with a document.
fn faults(name: &str, text: &str) -> Vec<String> {
    let (mut faults, mut heading, mut mark, mut code) = (Vec::new(), "", None, false);
    for (index, line) in text.lines().enumerate() {
        let mut fault = |what: &str| faults.push(format!("{name}:{}: {what}: {line}", index + 1));
        if let Some(rest) = line.strip_prefix("<!-- ") {
            if let Some(begun) = rest.strip_suffix(": begin -->") {
                mark = Some((begun, false));
            } else if let Some(ended) = rest.strip_suffix(": end -->") {
                match mark.take() {
                    Some((begun, true)) if begun == ended => {}
                    Some((begun, _)) if begun == ended => fault("no command has written this"),
                    _ => fault("this mark ends nothing"),
                }
            }
        }
        if line.starts_with('#') {
            heading = line.trim_start_matches('#').trim();
        }
        if let Some((begun, false)) = mark
            && line.starts_with("Measured by ")
        {
            mark = Some((begun, true));
        }
        if line.starts_with("```") {
            code = !code;
        }
        let table = line.starts_with('|');
        // A link or an image cannot be broken.
        if !table && !code && !line.starts_with(['!', '(']) && line.chars().count() > 120 {
            fault("more than 120 columns");
        }
        let defined = DEFINITIONS.contains(&(name, heading));
        if table && mark.is_none() && !defined && line.split('|').any(is_figure) {
            fault("no command writes this figure");
        }
        if ["todo", "tbd", "fixme", "xxx", "???", "to be measured"]
            .iter()
            .any(|one| line.to_lowercase().contains(one))
        {
            fault("a placeholder");
        }
    }
    faults
}

#[test]
fn every_table_of_figures_is_written_by_a_command() {
    let documents = documents();
    assert!(documents.len() >= 10);
    let faults: Vec<String> =
        documents.iter().flat_map(|(name, text)| faults(name, text)).collect();
    assert!(faults.is_empty(), "{}", faults.join("\n"));
    for (name, heading) in DEFINITIONS {
        let text = &documents.iter().find(|one| one.0 == name).unwrap().1;
        assert!(
            text.lines().any(|line| line.trim_start_matches('#').trim() == heading),
            "{heading}"
        );
    }
}

#[test]
fn figures_and_placeholders_are_found() {
    let found = |text: &str| faults("docs/x.md", text).len();
    assert_eq!(found("# Results\n| a | 0.5 |\n"), 1);
    assert_eq!(found(&format!("{0}\n```\n{0}\n```\n", "word ".repeat(30))), 1);
    assert_eq!(found("| a | 12 % |\n"), 1);
    assert_eq!(found("| a | 12 texels |\n"), 0);
    let marked = |how: &str| format!("<!-- a: begin -->\n{how}\n| a | 0.5 |\n<!-- a: end -->\n");
    assert_eq!(found(&marked("Measured by `cargo xtask docs`.")), 0);
    assert_eq!(found(&marked("")), 1);
    assert_eq!(found("the time is TBD\n"), 1);
    assert_eq!(found("<!-- a: begin -->\n<!-- b: end -->\n"), 1);
}
