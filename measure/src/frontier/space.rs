//! The configurations that there are, by the description of a frame: which are legal, what each depends on, and which one
//! is next to another.

use std::collections::{BTreeMap, BTreeSet, VecDeque};

use sglow_graph::description::{Description, Number, Setting, Table};
use sglow_graph::frame::Variant;
use sglow_graph::{Configuration, Frame};
use sglow_renderer::request::RequestError;
use sglow_runtime::settings::Settings;
use sglow_shader_gen::matrix::Facts;

use super::configuration::{self, Allowed};
use super::depends::{Names, related};

/// The values of other axes that may go with one, at most: kernels in the place of a cut need neither its tree nor itself.
const COMPANIONS: usize = 2;

/// Whether there is a variant, with any values on some axes.
pub type Has<'a> = &'a dyn Fn(&Variant, &[&str]) -> bool;

/// The configurations of scenes of one class.
#[derive(Debug)]
pub struct Space<'d> {
    description: &'d Description,
    facts: &'d Facts,
    /// The names that each rule names.
    rules: Vec<Names>,
}

impl<'d> Space<'d> {
    /// Of scenes of which these facts are known.
    #[must_use]
    pub fn new(description: &'d Description, facts: &'d Facts) -> Self {
        Self { description, facts, rules: related(description) }
    }

    /// The frame of a configuration; nothing if it is not legal.
    fn frame(&self, settings: &Settings) -> Option<Frame> {
        let mut configuration = self.known(settings);
        // With anything that a pass may draw.
        let host = self.description.parameter.iter().filter(|(_, parameter)| parameter.host);
        for (name, parameter) in host.filter(|(_, parameter)| parameter.default == Number::Whole(0))
        {
            let least = parameter.allows(Number::Whole(3)).then_some(Number::Whole(3));
            configuration.parameters.extend(least.map(|least| (name.clone(), least)));
        }
        self.description.evaluate(&configuration).ok()
    }

    /// The settings, without what the description does not know.
    fn known(&self, settings: &Settings) -> Configuration {
        let Description { axes, parameter, .. } = self.description;
        let mut configuration = settings.configuration();
        configuration.axes.retain(|name, _| axes.contains_key(name));
        configuration.parameters.retain(|name, _| parameter.contains_key(name));
        configuration
    }

    /// Whether no rule excludes a configuration, and every number is in its range.
    #[must_use]
    pub fn legal(&self, settings: &Settings) -> bool {
        self.frame(settings).is_some()
    }

    /// The variants that a configuration runs; nothing if it is not legal.
    #[must_use]
    pub fn variants(&self, settings: &Settings) -> Option<Vec<String>> {
        let frame = self.frame(settings)?;
        Some(frame.variants().into_iter().map(|variant| variant.id.clone()).collect())
    }

    /// Whether a configuration is legal and differs from `base` in parameters that it depends on alone.
    #[must_use]
    pub fn plain(&self, settings: &Settings, base: &Settings) -> bool {
        let Some(frame) = self.frame(settings) else { return false };
        Settings::PARAMETERS
            .iter()
            .all(|name| frame.reads.contains(*name) || settings.get(name) == base.get(name))
    }

    /// `base` with one value, and with the values of the fewest other axes that it needs to be legal and to count: kernels
    /// have a size where there are no clusters. Axes that nothing depends on then have their defaults, and parameters that were
    /// as a rule has them for the base are so for the result. None if the base has the value already, or it counts nowhere.
    #[must_use]
    pub fn with(&self, base: &Settings, name: &str, value: &str) -> Option<Settings> {
        let mut first = base.clone();
        first.set(name, value).ok()?;
        if configuration::value(&first, name) == configuration::value(base, name) {
            return None;
        }
        let axes = &self.description.axes;
        let more = base.others.keys().map(String::as_str).filter(|axis| axes.contains_key(*axis));
        let compared: Vec<&str> = Settings::COMPARED.iter().copied().chain(more).collect();
        let mut next = VecDeque::from([(first, vec![name])]);
        while let Some((settings, changed)) = next.pop_front() {
            let frame = self.frame(&settings);
            let has = configuration::value(&settings, name).as_deref() == Some(value);
            match &frame {
                Some(frame) if has && frame.reads.contains(name) => {
                    let found = self.ruled(&usual(settings, &frame.reads, base), base, name);
                    // What follows from another value is none that differs.
                    let own = format!("{name}={value}");
                    let name = configuration::name(&found, base);
                    return name.split(',').any(|part| part == own).then_some(found);
                }
                // What is legal needs another axis to count; what is not, others of a rule that names it.
                Some(_) if changed.len() > 1 => continue,
                _ if changed.len() > COMPANIONS => continue,
                _ => {}
            }
            let others = if frame.is_some() { None } else { Some(self.related(&changed)) };
            for axis in &compared {
                let excluded = others.as_ref().is_some_and(|others| !others.contains(axis));
                if excluded || changed.contains(axis) {
                    continue;
                }
                let changed: Vec<&str> = changed.iter().copied().chain([*axis]).collect();
                let values = axes.get(*axis).map(|known| &known.values);
                for value in values.into_iter().flatten() {
                    let mut other = settings.clone();
                    if other.get(axis).as_ref() != Some(value) && other.set(axis, value).is_ok() {
                        next.push_back((other, changed.clone()));
                    }
                }
            }
        }
        None
    }

    /// `base` with the first of the requested values of each axis that goes with the others.
    #[must_use]
    pub fn nearest(&self, base: &Settings, only: &Allowed) -> Settings {
        let mut nearest = base.clone();
        for (axis, values) in only {
            if configuration::value(&nearest, axis).is_some_and(|value| values.contains(&value)) {
                continue;
            }
            if let Some(with) = values.iter().find_map(|value| self.with(&nearest, axis, value)) {
                nearest = with;
            }
        }
        nearest
    }

    /// What rules name beside any of these.
    fn related(&self, changed: &[&str]) -> BTreeSet<&str> {
        let names = |rule: &&Names| changed.iter().any(|name| rule.contains(*name));
        self.rules.iter().filter(names).flatten().map(String::as_str).collect()
    }

    /// Settings whose parameters, where `base` has them as rules say for its axes, are as rules say for these axes; but for
    /// `own`.
    #[must_use]
    pub fn ruled(&self, settings: &Settings, base: &Settings, own: &str) -> Settings {
        let mut ruled = settings.clone();
        let [old, new] = [base, settings].map(|one| self.advised(one));
        for name in old.keys().chain(new.keys()).filter(|name| *name != own) {
            let usual = || self.description.parameter.get(name).map(|one| one.default);
            let [old, new] = [&old, &new].map(|one| one.get(name).copied().or_else(usual));
            let (Some(old), Some(new)) = (old, new) else { continue };
            if base.get(name) == Some(old.to_string()) {
                // A description's numbers are those that settings take.
                let _ = ruled.set(name, &new.to_string());
            }
        }
        ruled
    }

    /// The parameters that rules set for a configuration's axes.
    fn advised(&self, settings: &Settings) -> Table<Number> {
        let axes = self.known(settings).axes.into_iter();
        let set = axes.map(|(axis, value)| (axis, Setting::Name(value))).collect();
        let advised = self.description.configure(self.facts, None, &set);
        advised.map(|advised| advised.parameters).unwrap_or_default()
    }

    /// The defaults of scenes of which these facts hold and no others.
    ///
    /// # Errors
    ///
    /// When the description has no such facts.
    pub fn of_class(&self, facts: &[&str]) -> Result<Settings, RequestError> {
        let facts = facts.iter().map(|fact| ((*fact).to_owned(), true)).collect();
        let advised = Settings::advised(self.description, &facts, None);
        advised.map_err(|errors| RequestError::Settings(vec![errors.to_string()]))
    }

    /// The legal configurations of these values of axes whose variants there are, all else as in `base`.
    #[must_use]
    pub fn every(&self, base: &Settings, only: &Allowed, has: Has<'_>) -> Vec<Settings> {
        let mut found = BTreeMap::new();
        let mut next = vec![(base.clone(), BTreeSet::new())];
        while let Some((settings, decided)) = next.pop() {
            let frame = self.frame(&settings);
            let axis = match &frame {
                Some(frame) => {
                    let Some(axis) = undecided(frame, &decided, has) else { continue };
                    axis
                }
                None => {
                    let changed: Vec<&str> = decided.iter().copied().collect();
                    let related = self.related(&changed);
                    let open = |axis: &&&str| related.contains(**axis) && !decided.contains(**axis);
                    let Some(axis) = Settings::COMPARED.iter().find(open) else { continue };
                    Some(*axis)
                }
            };
            let Some(axis) = axis else {
                let reads = frame.map(|frame| frame.reads).unwrap_or_default();
                let one = self.ruled(&usual(settings, &reads, base), base, "");
                // An axis that does not count has its default.
                let fits = |(axis, value): (&str, &str)| {
                    only.get(axis).is_none_or(|only| only.contains(value))
                };
                if configuration::axes(&one).into_iter().all(fits) {
                    found.insert(configuration::name(&one, base), one);
                }
                continue;
            };
            for value in Settings::values(axis) {
                if only.get(axis).is_none_or(|only| only.contains(*value)) {
                    let mut other = settings.clone();
                    if other.set(axis, value).is_ok() {
                        let decided = decided.iter().copied().chain([axis]).collect();
                        next.push((other, decided));
                    }
                }
            }
        }
        found.into_values().collect()
    }
}

/// The axis that is decided next: of the variant that lacks the fewest. None inside if all that count are; nothing if a
/// variant that is decided is not there.
fn undecided(
    frame: &Frame,
    decided: &BTreeSet<&str>,
    has: Has<'_>,
) -> Option<Option<&'static str>> {
    let open = |axis: &&'static str| frame.reads.contains(*axis) && !decided.contains(*axis);
    let open: Vec<&'static str> = Settings::COMPARED.iter().copied().filter(open).collect();
    let mut fewest: Option<Vec<&'static str>> = None;
    for variant in frame.variants() {
        let lacks: Vec<_> =
            open.iter().copied().filter(|axis| variant.value(axis).is_some()).collect();
        if !has(variant, &lacks) {
            return None;
        }
        let fewer = fewest.as_ref().is_none_or(|fewest| lacks.len() < fewest.len());
        if !lacks.is_empty() && fewer {
            fewest = Some(lacks);
        }
    }
    Some(fewest.and_then(|fewest| fewest.first().copied()).or_else(|| open.first().copied()))
}

/// The same with the defaults of axes that nothing depends on, and with the base's parameters in the place of those.
fn usual(mut settings: Settings, reads: &BTreeSet<String>, base: &Settings) -> Settings {
    let defaults = Settings::default();
    let axes = Settings::COMPARED.iter().map(|axis| (*axis, &defaults));
    let parameters = Settings::PARAMETERS.iter().map(|parameter| (*parameter, base));
    for (name, from) in axes.chain(parameters).filter(|(name, _)| !reads.contains(*name)) {
        if let Some(value) = from.get(name) {
            // What is known by name takes its own value.
            let _ = settings.set(name, &value);
        }
    }
    settings
}

#[cfg(test)]
mod tests {
    use sglow_runtime::package::Package;
    use sglow_shaders as shaders;
    use sglow_shaders::{Cut, Emitter, Kernel, Ndf, Precision, Solver, Specular, Visibility};

    use super::*;

    fn with_space<T>(facts: &[&str], test: impl FnOnce(&Space<'_>) -> T) -> T {
        let package = Package::embedded();
        let facts = facts.iter().map(|fact| ((*fact).to_owned(), true)).collect();
        test(&Space::new(package.description().unwrap(), &facts))
    }

    #[test]
    fn a_value_brings_what_it_needs() {
        with_space(&["occluders", "specular"], |space| {
            let base = space.of_class(&["occluders", "specular"]).unwrap();
            assert_eq!((base.cut, base.near_scale), (Cut::Tile, 0.75));
            // Kernels have neither a cut nor its tree; what is near a light is then more.
            let previous = space.with(&base, "kernel", "previous").unwrap();
            assert_eq!(
                (previous.space, previous.cut, previous.kernel, previous.near_scale),
                (shaders::Space::None, Cut::None, Kernel::Previous, 1.5)
            );
            assert_eq!(configuration::value(&previous, "solver").as_deref(), Some("none"));
            // Without a cut there may be a tree; a number that was set is kept.
            let near = Settings { near_scale: 0.25, ..base.clone() };
            let tree = space.with(&near, "cut", "none").unwrap();
            assert_eq!((tree.space, tree.near_scale), (shaders::Space::Tree, 0.25));
            let maps = space.with(&base, "visibility", "imperfect").unwrap();
            assert_eq!((maps.cut, maps.near_scale), (Cut::Tile, 1.5));
            // A cut remains one as long as a tile holds its roots.
            let lobe = space.with(&base, "emitter", "lobe").unwrap();
            assert_eq!((lobe.cut, lobe.emitter), (Cut::Tile, Emitter::Lobe));
            let many = space.with(&base, "lights", "4096").unwrap();
            assert_eq!((many.cut, many.lights), (Cut::None, 4096));
            let diffuse = space.with(&base, "specular", "none").unwrap();
            assert_eq!(diffuse.ndf, Ndf::None);
        });
        with_space(&[], |space| {
            let base = Settings::default();
            // The distribution goes with specular reflection, the cut with its tree.
            let none = Settings { specular: Specular::None, ndf: Ndf::None, ..base.clone() };
            assert_eq!(space.with(&none, "specular", "asg").unwrap().ndf, Ndf::Ggx);
            let cut = space.with(&base, "cut", "tile").unwrap();
            assert_eq!((cut.space, cut.lights), (shaders::Space::Tree, base.lights));
            let half = Settings { precision: Precision::F16, ..base.clone() };
            assert_eq!(space.with(&half, "space", "world").unwrap().precision, Precision::F32);
            let clusters = space.with(&base, "space", "world").unwrap();
            assert_eq!(space.with(&clusters, "size_factor", "4").unwrap().size_factor, 4.0);
            for (axis, value) in [("emitter", "cosine"), ("colour", "red"), ("kernel", "cubic")] {
                assert!(space.with(&base, axis, value).is_none(), "{axis}={value}");
            }
        });
    }

    #[test]
    fn a_configuration_is_what_its_frame_depends_on() {
        with_space(&[], |space| {
            let base = Settings::default();
            let clusters = space.with(&base, "space", "world").unwrap();
            assert!(space.plain(&clusters, &base));
            let sized = Settings { size_factor: 4.0, ..clusters };
            assert!(!space.plain(&sized, &base));
            assert!(space.plain(&Settings { size_factor: 4.0, ..base.clone() }, &base));
            assert!(!space.legal(&Settings { cut: Cut::Tile, ..base }));
        });
    }

    #[test]
    fn every_configuration_of_some_values_is_there_once() {
        with_space(&[], |space| {
            let package = Package::embedded();
            let base = Settings::default();
            let words = [
                "density=power",
                "draw=warped",
                "emitter=cosine",
                "emitter=disc",
                "diffuse=fitted",
                "specular=none",
                "visibility=none",
                "lobes=diffuse",
            ];
            let only = configuration::allowed(&words.map(str::to_owned), &base).unwrap();
            let all = space.every(&base, &only, &|one, open| {
                !open.is_empty() || package.text(&one.id).is_ok()
            });
            let names: BTreeSet<_> =
                all.iter().map(|one| configuration::name(one, &base)).collect();
            assert_eq!(names.len(), all.len());
            let has = |test: &dyn Fn(&Settings) -> bool| all.iter().any(test);
            assert!(
                has(&|one| one.kernel == Kernel::Previous && one.space == shaders::Space::None)
            );
            assert!(has(&|one| one.space == shaders::Space::World));
            assert!(has(&|one| one.cut == Cut::Tile));
            for one in &all {
                assert!(one.visibility == Visibility::None && one.ndf == Ndf::None);
                let variants = space.variants(one).unwrap();
                assert!(variants.iter().all(|id| package.text(id).is_ok()), "{variants:?}");
                // Kernels alone have a form and a solver.
                let usual = (Kernel::Modified, Solver::Bracketed);
                let kernels = one.space == shaders::Space::None;
                assert!(kernels || (one.kernel, one.solver) == usual);
            }
            assert!(space.every(&base, &only, &|_, _| false).is_empty());
        });
    }
}
