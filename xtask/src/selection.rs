//! Which variants are meant: what is committed, what a scene needs, or a part of the space.

use std::collections::BTreeMap;
use std::path::PathBuf;

use clap::Args;
use sglow_runtime::package::Package;
use sglow_runtime::scene::Scene;
use sglow_shader_gen::generate;
use sglow_shader_gen::library::{Library, Pass};
use sglow_shader_gen::matrix::{Allowed, Because, Variant};

use crate::failure::{self, Failure, Result};
use crate::machine::repository;

/// Options that choose variants.
#[derive(Clone, Debug, Default, Args)]
pub(crate) struct Choice {
    /// Variants that this scene needs: a built-in scene, or a file (.gltf, .glb, .obj)
    #[arg(long, value_name = "FILE|NAME")]
    pub(crate) scene: Option<String>,
    /// Variants with these values; an axis may be given more than once
    #[arg(long, value_name = "AXIS=VALUE", value_delimiter = ',')]
    pub(crate) set: Vec<String>,
    /// Every legal variant, not only those that are committed
    #[arg(long)]
    pub(crate) all: bool,
}

/// The variants that a [`Choice`] means, and why.
#[derive(Debug)]
pub(crate) struct Selection {
    /// The variants, in the order of the library.
    pub(crate) variants: Vec<Variant>,
    /// Per axis the values that remain, and what took the others away.
    pub(crate) allowed: BTreeMap<String, Allowed>,
    /// What is true of the scene, if there is one.
    pub(crate) facts: BTreeMap<String, bool>,
    /// Passes none of whose legal variants remains.
    pub(crate) left_out: Vec<String>,
}

/// The folder of the library.
pub(crate) fn library_folder() -> PathBuf {
    repository().join("shaders")
}

/// Reads the library.
pub(crate) fn library() -> Result<Library> {
    Library::load(&library_folder()).map_err(failure::rendered)
}

/// Every legal variant of the library, generated in memory: what is not committed too.
pub(crate) fn whole_space() -> Result<Package> {
    let library = library()?;
    let variants = generate::variants(&library, &library.variants()).map_err(failure::rendered)?;
    let texts = variants.into_iter().map(|one| (one.variant.id(), one.text));
    Ok(Package::generated("every variant of the library", texts))
}

impl Choice {
    /// Whether this means what is committed.
    pub(crate) fn is_committed(&self) -> bool {
        self.scene.is_none() && self.set.is_empty() && !self.all
    }

    /// The variants that are meant: what is committed if nothing is chosen, and otherwise every legal variant that the
    /// scene's needs and the settings leave. A scene may need several of one pass: one per kind of material, say.
    ///
    /// # Errors
    ///
    /// When the scene cannot be read, an axis or value is not known, or nothing remains.
    pub(crate) fn select(&self, library: &Library) -> Result<Selection> {
        let facts: BTreeMap<String, bool> = match &self.scene {
            None => BTreeMap::new(),
            Some(name) => {
                let scene = Scene::load(name)?;
                for note in &scene.notes {
                    eprintln!("{}: {note}", scene.name);
                }
                scene.facts().known()
            }
        };
        let mut allowed = library.needed(&facts).map_err(failure::rendered)?;
        for (axis, values) in settings(library, &self.set)? {
            let Some(allowed) = allowed.get_mut(&axis) else {
                continue;
            };
            let kept = |value: &String| values.contains(value);
            let (values, removed) = allowed.values.drain(..).partition(kept);
            allowed.values = values;
            let reason = format!("--set asks for {}", kept_text(&self.set, &axis));
            allowed.because.push(Because { need: "--set".to_owned(), reason, removed });
        }
        if let Some((axis, allowed)) = allowed.iter().find(|(_, allowed)| allowed.values.is_empty())
        {
            let rules = allowed.because.iter().map(|rule| {
                format!("{} takes away {}: {}", rule.need, rule.removed.join(", "), rule.reason)
            });
            let failure = Failure::new(format!("no value remains on axis `{axis}`"));
            return Err(rules.fold(failure, Failure::help));
        }
        let fits = |variant: &Variant| {
            variant.values.iter().all(|(axis, value)| {
                allowed.get(axis).is_none_or(|allowed| allowed.values.contains(value))
            })
        };
        let mut variants =
            if self.is_committed() { library.selected() } else { library.variants() };
        variants.retain(|variant| fits(variant));
        let lacks = |pass: &&Pass| !variants.iter().any(|variant| variant.pass == pass.name);
        let left_out = library.pass.iter().filter(lacks).map(|pass| pass.name.clone()).collect();
        Ok(Selection { variants, allowed, facts, left_out })
    }
}

/// `axis=value` as values per axis.
fn settings(library: &Library, set: &[String]) -> Result<BTreeMap<String, Vec<String>>> {
    let mut values: BTreeMap<String, Vec<String>> = BTreeMap::new();
    let mut wrong = Vec::new();
    for setting in set {
        let Some((axis, value)) = setting.split_once('=') else {
            wrong.push(format!("`{setting}` is not AXIS=VALUE"));
            continue;
        };
        match library.axis.get(axis) {
            None => {
                let known: Vec<&str> = library.axis.keys().map(String::as_str).collect();
                wrong.push(format!("unknown axis `{axis}`; known: {}", known.join(", ")));
            }
            Some(known) if !known.value.iter().any(|known| known.name == value) => {
                let known: Vec<&str> =
                    known.value.iter().map(|value| value.name.as_str()).collect();
                wrong.push(format!(
                    "unknown value `{value}` of axis `{axis}`; known: {}",
                    known.join(", ")
                ));
            }
            Some(_) => values.entry(axis.to_owned()).or_default().push(value.to_owned()),
        }
    }
    if wrong.is_empty() { Ok(values) } else { Err(Failure::new(wrong.join("\n"))) }
}

fn kept_text(set: &[String], axis: &str) -> String {
    let of_axis = |setting: &&String| setting.split('=').next() == Some(axis);
    set.iter().filter(of_axis).cloned().collect::<Vec<_>>().join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn choice(set: &[&str], all: bool) -> Choice {
        Choice { scene: None, set: set.iter().map(|&word| word.to_owned()).collect(), all }
    }

    #[test]
    fn unknown_axes_and_values_are_told_all_at_once_with_those_that_are_known() {
        let library = library().unwrap();
        let wrong = choice(&["colour=red", "kernel=cubic", "kernel"], false).select(&library);
        let text = wrong.unwrap_err().to_string();
        for part in ["unknown axis `colour`", "known: previous, modified", "not AXIS=VALUE"] {
            assert!(text.contains(part), "{text}");
        }
    }

    #[test]
    fn settings_narrow_the_space() {
        let library = library().unwrap();
        let narrowed = choice(&["kernel=previous"], false).select(&library).unwrap().variants;
        assert!(narrowed.len() < library.variants().len());
        let kernels = || narrowed.iter().filter_map(|variant| variant.value("kernel"));
        assert!(kernels().count() > 0 && kernels().all(|kernel| kernel == "previous"));
        let two = choice(&["kernel=previous", "kernel=modified"], false).select(&library).unwrap();
        assert_eq!(two.variants, library.variants());
        assert_eq!(choice(&[], true).select(&library).unwrap().variants, library.variants());
        assert_eq!(choice(&[], false).select(&library).unwrap().variants, library.selected());
    }

    #[test]
    fn a_scene_needs_less_than_the_space_has_and_contradictions_are_explained() {
        let library = library().unwrap();
        let scene = |name: &str, set: &[&str]| {
            Choice { scene: Some(name.to_owned()), ..choice(set, true) }.select(&library)
        };
        let cornell = scene("cornell", &[]).unwrap();
        assert!(cornell.variants.len() < library.variants().len());
        let light = &cornell.allowed["light"];
        assert_eq!(light.values.len(), 2, "one kind of light, and the camera: {:?}", light.values);
        let other = light.because[0].removed[0].clone();
        let text = scene("cornell", &[&format!("light={other}")]).unwrap_err().to_string();
        assert!(
            text.contains("no value remains on axis `light`") && text.contains("--set"),
            "{text}"
        );
    }
}
