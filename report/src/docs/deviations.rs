//! The effect of each deviation from the papers: the default beside the same with one value as printed.

use schemars::JsonSchema;
use serde::Serialize;
use sglow_results::frontier::document::{Configuration, Metric, PictureError, SceneReport};
use sglow_results::frontier::promise::named::PRINTED;
use sglow_shader_gen::library::Library;

use crate::docs::marks;
use crate::failure::Result;
use crate::{failure, picture_error};

/// An axis or parameter on which the default is not as printed.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct Deviation {
    /// The axis or the parameter.
    axis: String,
    /// The value that gives the printed form.
    printed: String,
    /// Each scene that was measured with both.
    scenes: Vec<OnScene>,
}

/// A deviation on one scene.
#[derive(Clone, Debug, Serialize, JsonSchema)]
struct OnScene {
    /// The scene.
    scene: String,
    /// The default's value.
    default: String,
    /// In what both differ from the default, where the value means nothing beside the default; else empty.
    beside: String,
    /// The error of the default's picture against paths.
    default_error: PictureError,
    /// That of the default with this one value as printed.
    printed_error: PictureError,
    /// Milliseconds of the default's passes.
    default_milliseconds: f64,
    /// Milliseconds with this one value as printed.
    printed_milliseconds: f64,
}

/// The deviations of what was measured, in alphabetical order.
///
/// # Errors
///
/// When the library has no preset of the papers.
pub fn deviations(library: &Library, scenes: &[SceneReport]) -> Result<Vec<Deviation>> {
    let printed = library.find_preset(PRINTED).map_err(failure::rendered)?;
    let mut all = Vec::new();
    for (axis, value) in &printed.set {
        let printed = value.to_string();
        let mut one =
            Deviation { axis: axis.clone(), printed: printed.clone(), scenes: Vec::new() };
        for scene in scenes {
            let name = format!("{axis}={printed}");
            let Some((default, changed)) = pair(&scene.configurations, &name) else { continue };
            // The roots of a cut are not the papers' lights.
            let of_cut = value_of(default, "cut") != "none";
            if of_cut && axis == "lights" {
                continue;
            }
            one.scenes.push(OnScene {
                scene: scene.scene.clone(),
                default: value_of(default, axis),
                beside: if default.default { String::new() } else { default.name.clone() },
                default_error: default.picture,
                printed_error: changed.picture,
                default_milliseconds: default.time.median,
                printed_milliseconds: changed.time.median,
            });
        }
        if !one.scenes.is_empty() {
            all.push(one);
        }
    }
    Ok(all)
}

/// The default and the same with one value; where that means nothing, both with the value that gives it a meaning.
fn pair<'a>(
    configurations: &'a [Configuration],
    name: &str,
) -> Option<(&'a Configuration, &'a Configuration)> {
    let find =
        |wanted: &str| configurations.iter().find(|configuration| configuration.name == wanted);
    if let Some(changed) = find(name) {
        return configurations
            .iter()
            .find(|configuration| configuration.default)
            .map(|default| (default, changed));
    }
    configurations.iter().find_map(|changed| {
        let beside = changed.name.strip_suffix(name)?.strip_suffix(',')?;
        // One other value, no more.
        (!beside.contains(',')).then(|| find(beside)).flatten().map(|beside| (beside, changed))
    })
}

fn value_of(configuration: &Configuration, axis: &str) -> String {
    configuration
        .axes
        .get(axis)
        .or_else(|| configuration.parameters.get(axis))
        .cloned()
        .unwrap_or_default()
}

/// A document whose table is that of `deviations`; what stands outside of the marks stays.
///
/// # Errors
///
/// When the document lacks a mark.
pub fn written(document: &str, deviations: &[Deviation], how: &str) -> Result<String> {
    marks::replaced(document, "docs/deviations.md", "measured", &table(deviations, how))
}

fn table(deviations: &[Deviation], how: &str) -> String {
    let mut text = format!(
        "Measured by `{how}`; the error by the default, then with the one value as printed.\n\n"
    );
    let metrics = Metric::ALL;
    let titles: Vec<&str> = metrics.iter().map(|metric| metric.title()).collect();
    text.push_str(&format!("| printed | default | scene | {} | ms |\n", titles.join(" | ")));
    text.push_str(&format!("|---|---|---|{}---|\n", "---|".repeat(metrics.len())));
    for one in deviations {
        for on in &one.scenes {
            let cell = |metric| {
                let [ours, theirs] = [&on.default_error, &on.printed_error]
                    .map(|error| picture_error::text(error.of(metric), metric, false));
                format!("{ours} → {theirs}")
            };
            let beside = if on.beside.is_empty() {
                String::new()
            } else {
                format!(", with `{}`", on.beside)
            };
            text.push_str(&format!(
                "| `{}={}` | `{}`{beside} | {} | {} | {:.1} → {:.1} |\n",
                one.axis,
                one.printed,
                on.default,
                on.scene,
                metrics.map(cell).join(" | "),
                on.default_milliseconds,
                on.printed_milliseconds
            ));
        }
    }
    if deviations.is_empty() {
        text.push_str("| nothing was measured with a printed value | | | | | | | | | |\n");
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::page::report::made_up;

    fn library() -> Result<Library> {
        let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../shaders");
        Library::load(&folder).map_err(failure::rendered)
    }

    #[test]
    fn a_value_as_printed_stands_beside_the_default_and_the_prose_stays() {
        let mut scene = made_up::scenes().remove(0).measured;
        let at =
            scene.configurations.iter().position(|configuration| !configuration.default).unwrap();
        scene.configurations[at].name = "emitter=lobe".to_owned();
        let found = deviations(&library().unwrap(), &[scene]).unwrap();
        assert_eq!(found.len(), 1);
        assert_eq!((found[0].axis.as_str(), found[0].printed.as_str()), ("emitter", "lobe"));
        assert_eq!(found[0].scenes[0].beside, "");
        // What means nothing beside the default stands beside what gives it a meaning.
        let mut clusters = made_up::scenes().remove(0).measured;
        for configuration in
            clusters.configurations.iter_mut().filter(|configuration| !configuration.default)
        {
            configuration.name.insert_str(0, "other ");
        }
        let others: Vec<usize> = (0..clusters.configurations.len())
            .filter(|&at| !clusters.configurations[at].default)
            .collect();
        clusters.configurations[others[0]].name = "space=none,size_factor=1".to_owned();
        assert!(deviations(&library().unwrap(), &[clusters.clone()]).unwrap().is_empty());
        clusters.configurations[others[1]].name = "space=none".to_owned();
        let beside = deviations(&library().unwrap(), &[clusters]).unwrap();
        let sized = beside.iter().find(|one| one.axis == "size_factor").unwrap();
        assert_eq!(sized.scenes[0].beside, "space=none");
        assert!(table(&beside, "").contains("with `space=none`"));
        let document = "# Title\n<!-- measured: begin -->\nold\n<!-- measured: end -->\nprose\n";
        let text = written(document, &found, "cargo xtask report").unwrap();
        assert!(text.contains("| `emitter=lobe` |") && text.ends_with("\nprose\n"), "{text}");
        assert!(!text.contains("old") && text.starts_with("# Title\n"));
        assert_eq!(written(&text, &found, "cargo xtask report").unwrap(), text);
        assert!(written("no marks", &found, "").is_err());
        let own = include_str!("../../../docs/deviations.md");
        assert!(written(own, &found, "").is_ok());
    }
}
