//! Measured tables within documents that people write.

pub mod cuts;
pub mod densities;
pub mod deviations;
pub mod frontier;
pub mod marks;
pub mod needed;
pub mod references;
pub mod rivals;
pub mod specular;
pub mod stability;

use std::path::{Path, PathBuf};

use sglow_results::check::Check;
use sglow_results::densities::OnDensity;
use sglow_results::frontier::document::SceneReport;

use crate::docs::deviations::Deviation;
use crate::failure::{Context as _, Result};
use crate::write;

/// Writes the tables of scenes that were measured into README.md, docs/results.md and docs/deviations.md of the
/// `repository`, all or none, and returns their places.
///
/// # Errors
///
/// When a document cannot be read or written, or lacks its marks.
pub fn write(
    repository: &Path,
    names: &[String],
    checks: &[Check],
    scenes: &[SceneReport],
    deviations: &[Deviation],
    on_densities: &[OnDensity],
) -> Result<[PathBuf; 3]> {
    // A reader of the documents has other folders for results and pages.
    let arguments: String = names.iter().map(|name| format!(" --scene {name}")).collect();
    let how = format!("cargo xtask report{arguments} --write-docs");
    let names = ["README.md", "docs/results.md", "docs/deviations.md"];
    let paths = names.map(|name| repository.join(name));
    let read = |path: &PathBuf| std::fs::read_to_string(path);
    let [readme, results, deviating] = [read(&paths[0])?, read(&paths[1])?, read(&paths[2])?];
    let results = frontier::frontier(&results, names[1], scenes, checks, &how)?;
    let results = needed::written(&results, names[1], scenes, &how)?;
    let texts = [
        frontier::by_lights(&readme, names[0], scenes, &how)?,
        densities::written(&results, names[1], on_densities, &how)?,
        deviations::written(&deviating, deviations, &how)?,
    ];
    let files: Vec<_> =
        paths.iter().zip(&texts).map(|(path, text)| (path.as_path(), text.as_str())).collect();
    write::texts(&files)?;
    Ok(paths)
}

/// Writes the tables of one document of the `repository`, and returns its place.
///
/// # Errors
///
/// When it cannot be read or written, or lacks its marks.
pub fn update(
    repository: &Path,
    name: &str,
    tables: impl FnOnce(&str, &str) -> Result<String>,
) -> Result<PathBuf> {
    let path = repository.join(name);
    let document =
        std::fs::read_to_string(&path).context(format!("cannot read {}", path.display()))?;
    write::text(&path, &tables(&document, name)?)?;
    Ok(path)
}
