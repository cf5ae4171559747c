//! Which variants are meant: what is committed, what a scene needs, or a part of the space.

use std::collections::{BTreeMap, BTreeSet};

use sglow_runtime::package::Package;
use sglow_scene::Scene;
use sglow_shader_gen::library::{Library, Parameter, Pass, Setting};
use sglow_shader_gen::matrix::{Absent, AllowedValues, Because, Facts, Variant};
use sglow_shader_gen::package::{InMemory, Purpose, in_memory};

use crate::plan::{Plan, Storage};
use crate::request::derivation::{Derivation, Request};
use crate::request::{RequestError, saving};

/// Which variants are requested.
#[derive(Clone, Debug, Default)]
pub struct Choice {
    /// Variants with these values, as `axis=value`; an axis may come more than once.
    pub set: Vec<String>,
    /// A named configuration of the library instead of the scene's defaults.
    pub preset: Option<String>,
    /// Every legal variant, not only those that are committed; with a scene all that its needs leave, not only what a frame
    /// of it runs.
    pub all: bool,
}

/// The variants that a [`Choice`] means, and why.
#[derive(Debug)]
pub struct Selection {
    /// The variants, in the order of the library.
    pub variants: Vec<Variant>,
    /// Per axis the values that remain, and what took the others away.
    pub allowed: AllowedValues,
    /// Legal variants that are of no use with what remains, and the rules that say so.
    pub absent: Vec<Absent>,
    /// What follows from the scene, if there is one.
    pub derived: Option<Derived>,
    /// Passes none of whose legal variants remains.
    pub left_out: Vec<String>,
}

/// What follows from a scene.
#[derive(Debug)]
pub struct Derived {
    /// What it needs.
    pub derivation: Derivation,
    /// What was left out for it.
    pub purpose: Purpose,
    /// What a frame would take if every fact held.
    pub everything: Plan,
    /// What frames run, with each of the requested values.
    runs: Plan,
}

impl Derived {
    /// Bytes by part and by kind of memory, of this scene and of everything; what neither has is left out.
    #[must_use]
    pub fn memory(&self) -> Vec<(&'static str, &'static str, [u64; 2])> {
        let parts: [(_, &[_]); 4] = [
            ("surfaces", &["surfaces"]),
            ("indirect light", &["lights", "shading"]),
            ("visibility", &["visibility"]),
            ("picture", &["picture"]),
        ];
        let mut rows = Vec::new();
        for (name, parts) in parts {
            for (kind, storage) in [("textures", Storage::Texture), ("buffers", Storage::Buffer)] {
                let sizes = [&self.derivation.plan, &self.everything]
                    .map(|plan| plan.bytes(storage, parts));
                if sizes != [0; 2] {
                    rows.push((name, kind, sizes));
                }
            }
        }
        rows
    }
}

/// Every legal variant of a library, generated in memory: what is not committed too.
///
/// # Errors
///
/// Everything that is wrong with the library or a variant.
pub fn whole_space(library: &Library) -> Result<Package, RequestError> {
    let InMemory { texts, manifest } = in_memory(library, &library.variants())?;
    let names = library.overlays().iter().map(|overlay| format!(" with {}", overlay.name));
    let origin = format!("every variant of the library{}", names.collect::<String>());
    Ok(Package::generated(origin, texts).with_manifest(&manifest)?)
}

impl Choice {
    /// The variants that are meant: what is committed if nothing is chosen; with a scene what a frame of it runs, each
    /// axis settled as `render` does; with `all`, or without a scene, every legal variant that needs, settings and rules
    /// of presence leave.
    ///
    /// # Errors
    ///
    /// When the scene cannot be read, an axis or value is not known, or nothing remains.
    pub fn select(
        &self,
        library: &Library,
        scene: Option<&Scene>,
        milliseconds: Option<&BTreeMap<String, f64>>,
    ) -> Result<Selection, RequestError> {
        let set = settings(library, &self.set)?;
        let derived =
            scene.map(|scene| self.derive(library, scene, &set, milliseconds)).transpose()?;
        let mut allowed = match &derived {
            Some(derived) => derived.derivation.allowed.clone(),
            None => library.needed(&Facts::new())?,
        };
        let runs = derived.as_ref().map(|derived| &derived.runs);
        let (variants, absent) = match runs.filter(|_| !self.all) {
            Some(plan) => (saving::variants(library, plan), Vec::new()),
            None => {
                self.narrow(&mut allowed, set)?;
                let (mut variants, absent) = library.remaining(&allowed);
                if scene.is_none() && self.set.is_empty() && !self.all {
                    variants = library.selected();
                }
                // The camera's lights take values that are not requested.
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
        scene: &Scene,
        set: &BTreeMap<String, Vec<String>>,
        milliseconds: Option<&BTreeMap<String, f64>>,
    ) -> Result<Derived, RequestError> {
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
            derivations.push(Derivation::new(library, scene, set, &requested)?);
        }
        let plans = derivations.iter().map(|one| one.plan.clone());
        let runs = plans.reduce(Plan::or).unwrap_or_default();
        let first = derivations.into_iter().next().zip(combinations.first());
        let (derivation, set) = first.ok_or(RequestError::Nothing)?;
        let (purpose, everything) =
            saving::purpose(library, &derivation, &scene.name, set, milliseconds)?;
        Ok(Derived { derivation, purpose, everything, runs })
    }

    /// Takes away what is not requested.
    fn narrow(
        &self,
        allowed: &mut AllowedValues,
        set: BTreeMap<String, Vec<String>>,
    ) -> Result<(), RequestError> {
        for (axis, values) in set {
            let Some(allowed) = allowed.get_mut(&axis) else {
                continue;
            };
            let kept = |value: &String| values.contains(value);
            let (values, removed) = allowed.values.drain(..).partition(kept);
            allowed.values = values;
            let reason = format!("--set requests {}", kept_text(&self.set, &axis));
            allowed.because.push(Because { need: "--set".to_owned(), reason, removed });
        }
        let Some((axis, empty)) = allowed.iter().find(|(_, allowed)| allowed.values.is_empty())
        else {
            return Ok(());
        };
        let rule = |rule: &Because| {
            format!("{} takes away {}: {}", rule.need, rule.removed.join(", "), rule.reason)
        };
        let rules = empty.because.iter().map(rule).collect();
        Err(RequestError::NoValue { axis: axis.clone(), rules })
    }
}

/// The size of the picture that memory is stated for.
pub const SIZE: [u32; 2] = [640, 360];

/// `axis=value` as values per axis.
fn settings(
    library: &Library,
    set: &[String],
) -> Result<BTreeMap<String, Vec<String>>, RequestError> {
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
    if wrong.is_empty() { Ok(values) } else { Err(RequestError::Settings(wrong)) }
}

fn kept_text(set: &[String], axis: &str) -> String {
    let of_axis = |setting: &&String| setting.split('=').next() == Some(axis);
    set.iter().filter(of_axis).cloned().collect::<Vec<_>>().join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::request::library;
    use crate::request::shot::load;

    fn choice(set: &[&str], all: bool) -> Choice {
        let set = set.iter().map(|&word| word.to_owned()).collect();
        Choice { set, all, ..Choice::default() }
    }

    #[test]
    fn unknown_axes_and_values_are_told_all_at_once_with_those_that_are_known() {
        let library = library();
        let set = ["colour=red", "kernel=cubic", "kernel", "lights=0", "tile=8.5"];
        let text = choice(&set, false).select(&library, None, None).unwrap_err().to_string();
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
        let library = library();
        let narrowed =
            choice(&["kernel=previous"], false).select(&library, None, None).unwrap().variants;
        assert!(narrowed.len() < library.variants().len());
        let kernels = || narrowed.iter().filter_map(|variant| variant.value("kernel"));
        assert!(kernels().count() > 0 && kernels().all(|kernel| kernel == "previous"));
        let two = choice(&["kernel=previous", "kernel=modified"], false)
            .select(&library, None, None)
            .unwrap();
        assert_eq!(two.variants, library.variants());
        assert_eq!(
            choice(&[], true).select(&library, None, None).unwrap().variants,
            library.variants()
        );
        assert_eq!(
            choice(&[], false).select(&library, None, None).unwrap().variants,
            library.selected()
        );
    }

    #[test]
    fn a_scene_needs_less_than_the_space_has_and_contradictions_are_explained() {
        let library = library();
        let scene = |name: &str, set: &[&str]| {
            let scene = load(name, None, &sglow_scene::Options::default()).unwrap().0;
            choice(set, true).select(&library, Some(&scene), None)
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
