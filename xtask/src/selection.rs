//! Which variants are meant: what is committed, what a scene needs, or a part of the space.

use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;

use clap::Args;
use sglow_consumers::machine::repository;
use sglow_renderer::plan::Plan;
use sglow_report::failure;
use sglow_report::failure::{Failure, Result};
use sglow_runtime::package::Package;
use sglow_shader_gen::generate;
use sglow_shader_gen::library::{Library, Parameter, Pass, Setting};
use sglow_shader_gen::matrix::{Absent, AllowedValues, Because, Facts, Variant};
use sglow_shader_gen::package::Purpose;

use crate::derivation::{Derivation, Request};
use crate::measured::{self, Measured};
use crate::{saving, shot};

/// What is laid over the library.
#[derive(Clone, Debug, Default, Args)]
pub(crate) struct Over {
    /// Lay a folder over the library: passes, axes, values, parameters, resources and steps of your own (docs/overlays.md);
    /// may be given more than once
    #[arg(long, value_name = "DIR")]
    pub(crate) library: Vec<PathBuf>,
}

impl Over {
    /// Reads the library with what is laid over it.
    ///
    /// # Errors
    ///
    /// Everything that is wrong with it, and all that clashes.
    pub(crate) fn library(&self) -> Result<Library> {
        Library::load_with(&library_folder(), &self.library).map_err(failure::rendered)
    }

    /// Every legal variant of it, generated in memory: what is not committed too.
    ///
    /// # Errors
    ///
    /// Everything that is wrong with the library or a variant.
    pub(crate) fn whole_space(&self) -> Result<Package> {
        let library = self.library()?;
        let variants =
            generate::variants(&library, &library.variants()).map_err(failure::rendered)?;
        let manifest = sglow_shader_gen::manifest::in_memory(&library, &variants)?;
        let texts = variants.into_iter().map(|one| (one.variant.id(), one.text));
        let names = library.overlays().iter().map(|overlay| format!(" with {}", overlay.name));
        let origin = format!("every variant of the library{}", names.collect::<String>());
        Ok(Package::generated(origin, texts).with_manifest(&manifest)?)
    }
}

/// Options that choose variants.
#[derive(Clone, Debug, Default, Args)]
pub(crate) struct Choice {
    #[command(flatten)]
    pub(crate) over: Over,
    /// What a frame of this scene runs: a built-in scene, or a file (.gltf, .glb, .obj)
    #[arg(long, value_name = "FILE|NAME")]
    pub(crate) scene: Option<String>,
    /// Variants with these values; an axis may be given more than once
    #[arg(long, value_name = "AXIS=VALUE", value_delimiter = ',')]
    pub(crate) set: Vec<String>,
    /// A named configuration of the library instead of the scene's defaults
    #[arg(long, value_name = "NAME", requires = "scene")]
    pub(crate) preset: Option<String>,
    /// Every legal variant, not only those that are committed; with --scene all that its needs leave, not only what a
    /// frame of it runs
    #[arg(long)]
    pub(crate) all: bool,
    /// The scene's light that is used, counted from 0 [default: the one with the most power]
    #[arg(long, value_name = "NUMBER", requires = "scene")]
    pub(crate) light: Option<usize>,
}

/// The variants that a [`Choice`] means, and why.
#[derive(Debug)]
pub(crate) struct Selection {
    /// The variants, in the order of the library.
    pub(crate) variants: Vec<Variant>,
    /// Per axis the values that remain, and what took the others away.
    pub(crate) allowed: AllowedValues,
    /// Legal variants that are of no use with what remains, and the rules that say so.
    pub(crate) absent: Vec<Absent>,
    /// What follows from the scene, if there is one.
    pub(crate) derived: Option<Derived>,
    /// Passes none of whose legal variants remains.
    pub(crate) left_out: Vec<String>,
}

/// What follows from a scene.
#[derive(Debug)]
pub(crate) struct Derived {
    /// What it needs.
    pub(crate) derivation: Derivation,
    /// What was left out for it.
    pub(crate) purpose: Purpose,
    /// What a frame would take if every fact held.
    pub(crate) everything: Plan,
    /// What `report` has measured of it.
    pub(crate) measured: Option<Measured>,
    /// What frames run, with each of the values that were asked for.
    runs: Plan,
}

/// The folder of the library.
pub(crate) fn library_folder() -> PathBuf {
    repository().join("shaders")
}

/// Reads the library.
pub(crate) fn library() -> Result<Library> {
    Over::default().library()
}

/// Every legal variant of the library, generated in memory: what is not committed too.
pub(crate) fn whole_space() -> Result<Package> {
    Over::default().whole_space()
}

impl Choice {
    /// Whether this means what is committed.
    pub(crate) fn is_committed(&self) -> bool {
        self.scene.is_none() && self.set.is_empty() && !self.all
    }

    /// The variants that are meant: what is committed if nothing is chosen; with a scene what a frame of it runs, each
    /// axis settled as `render` does; with `all`, or without a scene, every legal variant that needs, settings and rules
    /// of presence leave.
    ///
    /// # Errors
    ///
    /// When the scene cannot be read, an axis or value is not known, or nothing remains.
    pub(crate) fn select(&self, library: &Library) -> Result<Selection> {
        let set = settings(library, &self.set)?;
        let derived = match &self.scene {
            None => None,
            Some(name) => Some(self.derive(library, name, &set)?),
        };
        let mut allowed = match &derived {
            Some(derived) => derived.derivation.allowed.clone(),
            None => library.needed(&Facts::new()).map_err(failure::rendered)?,
        };
        let runs = derived.as_ref().map(|derived| &derived.runs);
        let (variants, absent) = match runs.filter(|_| !self.all) {
            Some(plan) => (saving::variants(library, plan), Vec::new()),
            None => {
                self.narrow(&mut allowed, set)?;
                let (mut variants, absent) = library.remaining(&allowed);
                if self.is_committed() {
                    variants = library.selected();
                }
                // The camera's lights take values that nobody asks for.
                if let Some(plan) = runs {
                    let ids: BTreeSet<String> = variants.iter().map(Variant::id).collect();
                    variants = library.variants();
                    variants
                        .retain(|one| ids.contains(&one.id()) || plan.variants.contains(&one.id()));
                }
                (variants, absent)
            }
        };
        let lacks = |pass: &&Pass| !variants.iter().any(|variant| variant.pass == pass.name);
        let left_out = library.pass.iter().filter(lacks).map(|pass| pass.name.clone()).collect();
        Ok(Selection { variants, allowed, absent, derived, left_out })
    }

    /// What follows from a scene, and what frames of it run: one for each combination of the values that are set.
    fn derive(
        &self,
        library: &Library,
        name: &str,
        set: &BTreeMap<String, Vec<String>>,
    ) -> Result<Derived> {
        let scene = shot::load(name, self.light)?;
        let requested = Request { preset: self.preset.clone(), ..Request::of(SIZE) };
        // Axes that no renderer has are for `all` alone.
        let parameter = |name: &String| library.parameter(name).is_some();
        let of_renderer = |(axis, _): &(&String, &Vec<String>)| {
            let setting = library.axis.get(*axis).is_some_and(|axis| axis.setting);
            !self.all || setting || parameter(axis)
        };
        let mut combinations = vec![Vec::new()];
        for (axis, values) in set.iter().filter(of_renderer) {
            let with = |value: &String, set: &Vec<String>| {
                let mut set = set.clone();
                set.push(format!("{axis}={value}"));
                set
            };
            combinations = values
                .iter()
                .flat_map(|value| combinations.iter().map(move |set| with(value, set)))
                .collect();
        }
        let mut derivations = Vec::new();
        for set in &combinations {
            derivations.push(Derivation::new(library, &scene, set, &requested)?);
        }
        let plans = derivations.iter().map(|one| one.plan.clone());
        let runs = plans.reduce(Plan::or).unwrap_or_default();
        let first = derivations.into_iter().next().zip(combinations.first());
        let (derivation, set) = first.ok_or_else(|| Failure::new("nothing is asked for"))?;
        let measured = measured::find(&scene);
        let rules = measured.as_ref().map(|measured| &measured.rules);
        let (purpose, everything) = saving::purpose(library, &derivation, &scene.name, set, rules)?;
        Ok(Derived { derivation, purpose, everything, measured, runs })
    }

    /// Takes away what is not asked for.
    fn narrow(
        &self,
        allowed: &mut AllowedValues,
        set: BTreeMap<String, Vec<String>>,
    ) -> Result<()> {
        for (axis, values) in set {
            let Some(allowed) = allowed.get_mut(&axis) else {
                continue;
            };
            let kept = |value: &String| values.contains(value);
            let (values, removed) = allowed.values.drain(..).partition(kept);
            allowed.values = values;
            let reason = format!("--set asks for {}", kept_text(&self.set, &axis));
            allowed.because.push(Because { need: "--set".to_owned(), reason, removed });
        }
        let Some((axis, empty)) = allowed.iter().find(|(_, allowed)| allowed.values.is_empty())
        else {
            return Ok(());
        };
        let rules = empty.because.iter().map(|rule| {
            format!("{} takes away {}: {}", rule.need, rule.removed.join(", "), rule.reason)
        });
        let failure = Failure::new(format!("no value remains on axis `{axis}`"));
        Err(rules.fold(failure, Failure::help))
    }
}

/// The picture that memory is told for.
pub(crate) const SIZE: [u32; 2] = [640, 360];

/// `axis=value` as values per axis.
fn settings(library: &Library, set: &[String]) -> Result<BTreeMap<String, Vec<String>>> {
    let mut values: BTreeMap<String, Vec<String>> = BTreeMap::new();
    let mut wrong = Vec::new();
    for setting in set {
        let Some((axis, value)) = setting.split_once('=') else {
            wrong.push(format!("`{setting}` is not AXIS=VALUE"));
            continue;
        };
        let parameter = library.parameter(axis);
        let allowed = |parameter: &Parameter| match Setting::read(value) {
            Setting::Number(number) => parameter.allows(number),
            Setting::Name(_) => false,
        };
        match (library.axis.get(axis), parameter) {
            // No variant hangs on it, but what a frame keeps does.
            (None, Some(parameter)) if allowed(parameter) => {
                values.entry(axis.to_owned()).or_default().push(value.to_owned());
            }
            (None, Some(parameter)) => {
                let range = parameter.range();
                wrong.push(format!("parameter `{axis}` is {value}; expected {range}"));
            }
            (None, None) => {
                let known: Vec<&str> = library.axis.keys().map(String::as_str).collect();
                wrong.push(format!("unknown axis `{axis}`; known: {}", known.join(", ")));
            }
            (Some(known), _) if !known.value.iter().any(|known| known.name == value) => {
                let known: Vec<&str> =
                    known.value.iter().map(|value| value.name.as_str()).collect();
                wrong.push(format!(
                    "unknown value `{value}` of axis `{axis}`; known: {}",
                    known.join(", ")
                ));
            }
            (Some(_), _) => values.entry(axis.to_owned()).or_default().push(value.to_owned()),
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
        let set = set.iter().map(|&word| word.to_owned()).collect();
        Choice { set, all, ..Choice::default() }
    }

    #[test]
    fn unknown_axes_and_values_are_told_all_at_once_with_those_that_are_known() {
        let library = library().unwrap();
        let set = ["colour=red", "kernel=cubic", "kernel", "lights=0", "tile=8.5"];
        let text = choice(&set, false).select(&library).unwrap_err().to_string();
        for part in [
            "unknown axis `colour`",
            "known: previous, modified",
            "not AXIS=VALUE",
            "`lights` is 0; expected a whole number, at least 1, at most 65536",
            "`tile` is 8.5; expected a whole number",
        ] {
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
