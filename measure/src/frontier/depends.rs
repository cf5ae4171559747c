//! What stages of a frame depend on: the axes and the parameters that their steps name, by the frame's description.

use std::collections::BTreeSet;

use serde_json::Value;
use sglow_graph::Description;
use sglow_graph::description::{Choice, Exclusion, Step};
use sglow_renderer::stages::{LIGHTS, is_map};
use sglow_runtime::execute::Stage;
use sglow_runtime::settings::Settings;
use sglow_shaders::frame::{parameter, part};

/// Names of axes and parameters.
pub type Names = BTreeSet<String>;

/// What each stage that is measured by itself depends on.
#[derive(Clone, Debug, Default)]
pub struct Depends {
    /// Level 0 of moments and density.
    maps: Names,
    /// Everything that makes lights.
    lights: Names,
    /// The layout of lights in memory.
    layout: Names,
    /// Their shadow maps.
    visibility: Names,
    /// Their shadow maps and their reflection.
    shading: Names,
    /// What each rule on whole configurations names.
    rules: Vec<Names>,
}

impl Depends {
    /// By the description of a frame; without one everything is taken to depend on all that is known.
    #[must_use]
    pub fn of(description: Option<&Description>) -> Self {
        let Some(description) = description else {
            let all: Names = Settings::AXES
                .iter()
                .chain(Settings::PARAMETERS)
                .map(|name| (*name).to_owned())
                .collect();
            let [maps, lights, layout, visibility, shading] = std::array::from_fn(|_| all.clone());
            return Self { maps, lights, layout, visibility, shading, rules: Vec::new() };
        };
        let stage = |counts: &dyn Fn(Stage<'_>) -> bool| steps(description, counts);
        let mut layout = Walk::new(description);
        for lights in LIGHTS {
            layout.entry("resource", lights);
        }
        Self {
            maps: stage(&|stage| stage.part == part::LIGHTS && is_map(stage)),
            lights: stage(&|stage| stage.part == part::LIGHTS),
            layout: layout.names,
            visibility: stage(&|stage| stage.part == part::VISIBILITY),
            shading: stage(&|stage| [part::VISIBILITY, part::SHADING].contains(&stage.part)),
            rules: rules(description),
        }
    }

    /// The default with some values of settings and what the rules name with these, with what the scene and the host have, and
    /// with what a library that was laid over this one adds.
    fn restricted(&self, settings: &Settings, names: &Names) -> Settings {
        let Settings { size, complete, assumed, others, .. } = settings.clone();
        let mut own = Settings { size, complete, assumed, others, ..Settings::default() };
        let usual = own.clone();
        let changed = |name: &String| names.contains(name) && settings.get(name) != usual.get(name);
        let ruled = self.rules.iter().filter(|rule| rule.iter().any(changed)).flatten();
        let compared = |axis: &&&str| Settings::COMPARED.contains(*axis);
        let given = Settings::AXES.iter().filter(|axis| !compared(axis)).copied();
        let given = given.chain([parameter::MAP]);
        for name in names.iter().chain(ruled).map(String::as_str).chain(given) {
            if let Some(value) = settings.get(name) {
                // What is known by name takes its own value.
                let _ = own.set(name, &value);
            }
        }
        own
    }

    /// The settings on which maps depend, all else as by default.
    #[must_use]
    pub fn of_maps(&self, settings: &Settings) -> Settings {
        self.restricted(settings, &self.maps)
    }

    /// The settings of what makes lights, whatever shadows and reflects them.
    #[must_use]
    pub fn of_lights(&self, settings: &Settings) -> Settings {
        self.restricted(settings, &self.lights)
    }

    /// The settings of what shadows and reflects lights, whatever makes them.
    #[must_use]
    pub fn of_shading(&self, settings: &Settings) -> Settings {
        self.restricted(settings, &self.shading)
    }

    /// The values on which the shadow maps of lights depend.
    #[must_use]
    pub fn visibility_id(&self, settings: &Settings) -> String {
        format!("{:?}", self.restricted(settings, &self.visibility))
    }

    /// The values on which the time of visibility and of reflection depends.
    #[must_use]
    pub fn shading_id(&self, settings: &Settings) -> String {
        format!("{:?}", self.of_shading(settings))
    }

    /// Whether the lights of two configurations have the same layout, so that the same shading reads both.
    #[must_use]
    pub fn same_layout(&self, one: &Settings, other: &Settings) -> bool {
        self.restricted(one, &self.layout) == self.restricted(other, &self.layout)
    }

    /// An order in which configurations that share maps follow each other, and of those the ones that share lights.
    #[must_use]
    pub fn shared(&self, settings: &Settings) -> [String; 3] {
        let stages = [self.of_maps(settings), self.of_lights(settings), settings.clone()];
        stages.map(|one| format!("{one:?}"))
    }
}

/// The labels of the stages that depend on an axis or a parameter; a stage without one is called as its pass.
#[must_use]
pub fn labels(description: &Description, name: &str) -> BTreeSet<String> {
    fn collect(on: (&Description, &str), step: &Step, outer: &[&Step], found: &mut Names) {
        let inner = [outer, &[step]].concat();
        step.steps.iter().for_each(|step| collect(on, step, &inner, found));
        let mut walk = Walk::new(on.0);
        walk.step(step, &|_| step.steps.is_empty(), outer);
        if walk.names.contains(on.1) {
            let pass = step.pass.as_ref().filter(|_| step.label.is_empty());
            found.insert(pass.unwrap_or(&step.label).clone());
        }
    }
    let mut found = Names::new();
    description.step.iter().for_each(|step| collect((description, name), step, &[], &mut found));
    found
}

/// What each rule on whole configurations names.
fn rules(description: &Description) -> Vec<Names> {
    let whole = description.exclusion.iter().filter(|rule| rule.passes.is_empty());
    whole.map(|rule| names(description, rule)).collect()
}

/// What each rule names, on whole configurations or on variants.
pub(super) fn related(description: &Description) -> Vec<Names> {
    description.exclusion.iter().map(|rule| names(description, rule)).collect()
}

fn names(description: &Description, rule: &Exclusion) -> Names {
    let mut walk = Walk::new(description);
    walk.value(&serde_json::to_value(&rule.when).unwrap_or_default());
    walk.names
}

/// What the steps of some stages depend on.
fn steps(description: &Description, counts: &dyn Fn(Stage<'_>) -> bool) -> Names {
    let mut walk = Walk { conditions: false, ..Walk::new(description) };
    for step in &description.step {
        walk.step(step, counts, &[]);
    }
    walk.names
}

/// Names that are reached so far.
struct Walk<'d> {
    description: &'d Description,
    names: Names,
    /// Lets, uniforms and resources that were looked at.
    seen: BTreeSet<(&'static str, String)>,
    /// Whether conditions of resources count. Those of a step that runs exist.
    conditions: bool,
}

impl<'d> Walk<'d> {
    fn new(description: &'d Description) -> Self {
        Self { description, names: Names::new(), seen: BTreeSet::new(), conditions: true }
    }

    /// A step with the steps in it; `outer` are the groups that it stands in.
    fn step(&mut self, step: &Step, counts: &dyn Fn(Stage<'_>) -> bool, outer: &[&Step]) {
        if !step.steps.is_empty() {
            let outer = [outer, &[step]].concat();
            for inner in &step.steps {
                self.step(inner, counts, &outer);
            }
            return;
        }
        if !counts(Stage { part: &step.part, label: &step.label }) {
            return;
        }
        for group in outer {
            self.value(&serde_json::json!([group.when, group.repeat]));
        }
        self.value(&serde_json::to_value(step).unwrap_or_default());
        for uniform in step.uniforms.values() {
            self.entry("uniform", uniform);
        }
        let axes = step.pass.as_ref().and_then(|pass| self.description.passes.get(pass));
        for axis in axes.into_iter().flatten() {
            let given = step.axes.get(axis).is_some_and(|choice| match choice {
                Choice::Always(_) => true,
                Choice::Cases(cases) => cases.iter().any(|case| case.when.is_none()),
            });
            if !given {
                self.names.insert(axis.clone());
            }
        }
    }

    /// What an entry of a table names.
    fn entry(&mut self, table: &'static str, name: &str) {
        if !self.seen.insert((table, name.to_owned())) {
            return;
        }
        let Description { lets, uniform, resource, .. } = self.description;
        let entry = match table {
            "let" => lets.get(name).map(serde_json::to_value),
            "uniform" => uniform.get(name).map(serde_json::to_value),
            _ => resource.get(name).map(serde_json::to_value),
        };
        if let Some(Ok(mut value)) = entry {
            if let (false, "resource", Some(entry)) =
                (self.conditions, table, value.as_object_mut())
            {
                entry.remove("when");
            }
            self.value(&value);
        }
    }

    /// What a formula, a reference, or anything that has some in it names.
    fn value(&mut self, value: &Value) {
        match value {
            Value::Array(list) => list.iter().for_each(|value| self.value(value)),
            Value::Object(map) => {
                if let (Some(Value::String(name)), 1) = (map.get("name"), map.len()) {
                    if self.description.lets.contains_key(name) {
                        self.entry("let", name);
                    } else {
                        self.names.insert(name.clone());
                    }
                }
                if let Some(Value::Array(is)) = map.get("is")
                    && let Some(Value::String(axis)) = is.first()
                {
                    self.names.insert(axis.clone());
                }
                for key in ["resource", "age", "new"] {
                    if let Some(Value::String(name)) = map.get(key) {
                        self.entry("resource", name);
                    }
                }
                map.values().for_each(|value| self.value(value));
            }
            _ => {}
        }
    }
}

#[cfg(test)]
mod tests {
    use sglow_graph::Formula;
    use sglow_graph::description::{Field, Setting};
    use sglow_runtime::package::Package;

    use super::*;

    fn with(settings: &Settings, name: &str, value: &str) -> Settings {
        let mut settings = settings.clone();
        settings.set(name, value).unwrap();
        settings
    }

    #[test]
    fn what_reflects_other_lights_or_runs_other_steps_is_another() {
        let package = Package::embedded();
        let depends = Depends::of(package.description());
        let base = Settings {
            others: [("denoise".to_owned(), Setting::Name("none".to_owned()))].into(),
            ..Settings::default()
        };
        let id = depends.shading_id(&base);
        for (name, value) in [
            ("density", "reflectance"),
            ("draw", "metropolis"),
            ("kernel", "previous"),
            ("filter", "hardware"),
            ("variance", "planar"),
            ("size_factor", "0.5"),
            ("iterations", "3"),
        ] {
            let same = with(&base, name, value);
            assert_eq!(depends.shading_id(&same), id, "how lights are made does not count: {name}");
            assert_ne!(depends.of_lights(&same), depends.of_lights(&base), "{name}");
        }
        for (name, value) in
            [("lights", "64"), ("tile", "32"), ("visibility", "imperfect"), ("denoise", "blur")]
        {
            assert_ne!(depends.shading_id(&with(&base, name, value)), id, "{name}");
        }
        for (name, value) in
            [("specular", "sg"), ("diffuse", "constant"), ("visibility", "imperfect")]
        {
            let other = with(&base, name, value);
            assert_eq!(depends.of_lights(&other), depends.of_lights(&base), "{name}");
            assert_eq!(depends.of_maps(&other), depends.of_maps(&base), "{name}");
        }
        // A rule needs the tree of a cut: what reflects it is measured with it.
        let tree = with(&with(&base, "space", "tree"), "lights", "64");
        let cut = depends.of_shading(&with(&tree, "cut", "tile"));
        assert_eq!(cut.get("space").as_deref(), Some("tree"));
        assert_eq!(depends.of_shading(&tree).get("space"), base.get("space"));
        let kernels = with(&base, "size_factor", "0.5");
        assert!(depends.same_layout(&kernels, &base));
        assert!(!depends.same_layout(&with(&base, "lights", "64"), &base));
    }

    #[test]
    fn stages_are_known_by_what_they_depend_on() {
        let package = Package::embedded();
        let on = |name: &str| labels(package.description().unwrap(), name);
        let has = |name: &str, label: &str| on(name).contains(label);
        assert!(has("lobes", "moments") && has("lobes", "shade") && has("emission", "emission"));
        assert!(!has("lobes", "surface light") && !has("emission", "shade"));
        assert!(on("tide").is_empty());
    }

    /// A library whose shading reads one number more needs no change here.
    #[test]
    fn a_uniform_that_gains_a_number_depends_on_it() {
        let package = Package::embedded();
        let mut description = package.description().unwrap().clone();
        let settings = Settings::default();
        let other = with(&settings, "seed", "7");
        let id = |description: &Description, settings: &Settings| {
            Depends::of(Some(description)).shading_id(settings)
        };
        assert_eq!(id(&description, &settings), id(&description, &other));
        let shading = |step: &&Step| step.part == part::SHADING && !step.uniforms.is_empty();
        let step = description.step.iter().flat_map(|step| [step].into_iter().chain(&step.steps));
        let uniform = step.clone().find(shading).unwrap().uniforms.values().next().unwrap().clone();
        let seed = Field::Formula(Formula::Name { name: "seed".to_owned() });
        description.uniform.get_mut(&uniform).unwrap().insert("seed".to_owned(), seed);
        assert_ne!(id(&description, &settings), id(&description, &other));
    }
}
