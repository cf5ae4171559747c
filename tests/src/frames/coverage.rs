//! What of the shader library the configurations run: counted from `shaders/library.toml`, not from a list of our own.

use std::collections::{BTreeMap, BTreeSet};

use sglow_runtime::settings::Settings;
use sglow_shader_gen::library::{ClassDefault, Library, Need, Presence};
use sglow_shader_gen::matrix::{AllowedValues, Facts, Variant};

use super::list::{Case, base};
use super::scenes::Lamp;

/// Passes that are no part of a frame.
const MEASURES: [&str; 1] = ["function"];

/// Parameters that are sizes: a configuration with a name is run with others.
const SIZES: [&str; 3] = ["lights", "map", "camera_lights"];

/// One thing that some configuration has to run.
type Item = String;

fn value(pass: &str, axis: &str, value: &str) -> Item {
    format!("pass {pass}, {axis} {value}")
}

fn in_force(rule: &Presence) -> Item {
    format!("presence {} leaves something out", rule.name)
}

fn not_in_force(rule: &Presence) -> Item {
    format!("presence {} leaves something in", rule.name)
}

fn applied(rule: &Need) -> Item {
    format!("need {} is followed", rule.name)
}

fn unmet(rule: &Need) -> Item {
    format!("need {} takes something away from others", rule.name)
}

fn defaults(rule: &ClassDefault, holds: bool) -> Item {
    format!("the defaults of a scene with {} {holds}", rule.name)
}

/// Everything that has to be run: each value of each axis of each pass, each rule where it changes a frame and where it
/// does not, each parameter with two values, the defaults of each class of scenes, each preset that measurements do not
/// choose anew, and what a frame may stumble over.
pub(super) fn required(library: &Library) -> BTreeSet<Item> {
    let mut items = BTreeSet::new();
    for variant in library.variants() {
        if !MEASURES.contains(&variant.pass.as_str()) {
            items.extend(values(&variant));
        }
    }
    for rule in &library.presence {
        items.extend([in_force(rule), not_in_force(rule)]);
    }
    for rule in &library.need {
        items.extend([applied(rule), unmet(rule)]);
    }
    for rule in library.class_default.iter().filter(|rule| !rule.when.is_empty()) {
        items.extend([defaults(rule, true), defaults(rule, false)]);
    }
    let known = library.parameters().filter(|(name, _)| base().get(name).is_some());
    items.extend(known.map(|(name, _)| format!("two values of {name}")));
    let lasting = library.preset.iter().filter(|preset| preset.measured.is_empty());
    items.extend(lasting.map(|preset| format!("preset {}", preset.name)));
    items.extend(SITUATIONS.map(|(name, _)| name.to_owned()));
    items
}

/// What a variant is on each of its axes.
fn values(variant: &Variant) -> Vec<Item> {
    let pass = &variant.pass;
    let values = variant.values.iter().map(|(axis, name)| value(pass, axis, name));
    std::iter::once(format!("pass {pass}")).chain(values).collect()
}

/// Something that a frame may stumble over, and whether a configuration has it.
type Situation = (&'static str, fn(&Case) -> bool);

/// What a frame may stumble over, whatever it runs.
const SITUATIONS: [Situation; 12] = [
    ("one light", |case| case.settings.lights == 1),
    ("seven lights", |case| case.settings.lights == 7),
    ("more lights than a block of the sort has keys", |case| case.settings.lights > 1024),
    ("a map that is no power of two", |case| !case.settings.map.is_power_of_two()),
    ("a map of an odd size", |case| case.settings.map % 2 == 1 && case.settings.map > 1),
    ("a map whose chain ends in part of a workgroup", |case| {
        let side = case.settings.map;
        side.div_ceil(8).div_ceil(8) > (side / 8).div_ceil(8)
    }),
    ("a map of one texel", |case| case.settings.map == 1),
    ("a picture of one pixel", |case| case.settings.size == [1, 1]),
    ("three frames in a row", |case| case.frames == 3 && case.chains.is_none()),
    ("chains that begin again", |case| case.restarts && case.frames > 1),
    ("a light that lights nothing", |case| case.lamp == Lamp::Away),
    ("an eye that moves", |case| case.eye_moves && case.frames > 1),
];

/// What one configuration runs of it.
fn covered(library: &Library, legal: &[Variant], case: &Case, facts: &Facts) -> BTreeSet<Item> {
    let settings = case.settled();
    let ids = case.variants();
    let variants: Vec<&Variant> = legal.iter().filter(|one| ids.contains(&one.id())).collect();
    assert_eq!(variants.len(), ids.len(), "{}: a variant that is none", case.name);
    let mut items = BTreeSet::new();
    for variant in &variants {
        // A chain has the passes for all numbers of levels at hand, and runs those that its size asks for.
        if variant.pass != "mip" || dispatched(&settings, variant) {
            items.extend(values(variant));
        }
    }
    let follows = |when: &BTreeMap<String, bool>| {
        when.iter().all(|(fact, holds)| facts.get(fact) == Some(holds))
    };

    let (_, absent) = library.remaining(&allowed(library, &settings, &variants));
    for rule in &library.presence {
        if absent.iter().any(|absent| absent.presence == rule.name) {
            items.insert(in_force(rule));
        } else if variants.iter().any(|variant| matches(rule, variant)) {
            items.insert(not_in_force(rule));
        }
    }
    for rule in &library.need {
        let taken_away = variants
            .iter()
            .flat_map(|variant| &variant.values)
            .any(|(axis, value)| rule.set.get(axis).is_some_and(|kept| !kept.contains(value)));
        match (follows(&rule.when), taken_away) {
            (true, false) => drop(items.insert(applied(rule))),
            (false, true) => drop(items.insert(unmet(rule))),
            _ => {}
        }
    }

    let has = |name: &str, expected: &str| settings.get(name).is_none_or(|own| own == expected);
    let mut default: BTreeMap<&str, String> =
        library.axis.iter().map(|(name, axis)| (name.as_str(), axis.default.clone())).collect();
    // The light's kind is the scene's.
    default.remove("light");
    let mut hold = BTreeSet::new();
    for rule in &library.class_default {
        if rule.holds(facts, [], |axis| default.get(axis).cloned()) {
            default.extend(rule.set.iter().map(|(name, value)| (name.as_str(), value.to_string())));
            hold.insert(&rule.name);
        }
    }
    if default.iter().all(|(name, value)| has(name, value)) {
        for rule in library.class_default.iter().filter(|rule| !rule.when.is_empty()) {
            items.insert(defaults(rule, hold.contains(&rule.name)));
        }
    }
    for preset in &library.preset {
        let mut set = preset.set.iter().filter(|(name, _)| !SIZES.contains(&name.as_str()));
        if set.all(|(name, value)| has(name, &value.to_string())) {
            items.insert(format!("preset {}", preset.name));
        }
    }
    for (name, _) in library.parameters() {
        let own = settings.get(name);
        if own.is_some() && own != base().get(name) {
            items.insert(format!("two values of {name}"));
        }
    }
    let situations = SITUATIONS.iter().filter(|(_, holds)| holds(case));
    items.extend(situations.map(|(name, _)| (*name).to_owned()));
    items
}

/// What each configuration runs of it.
pub(super) fn covered_by_each(library: &Library, cases: &[Case]) -> Vec<BTreeSet<Item>> {
    let legal = library.variants();
    // Facts of a scene take a while to find.
    let mut known: BTreeMap<_, Facts> = BTreeMap::new();
    let mut facts = |case: &Case| {
        let of_scene = || {
            let facts = case.scene().facts();
            facts.iter().map(|fact| (fact.name.to_owned(), fact.holds)).collect()
        };
        known.entry((case.place, case.lamp)).or_insert_with(of_scene).clone()
    };
    cases.iter().map(|case| covered(library, &legal, case, &facts(case))).collect()
}

/// What no configuration runs of what has to be run.
pub(super) fn missing(required: &BTreeSet<Item>, covered: &[BTreeSet<Item>]) -> BTreeSet<Item> {
    let covered: BTreeSet<&Item> = covered.iter().flatten().collect();
    required.iter().filter(|item| !covered.contains(item)).cloned().collect()
}

/// Whether a chain of the size of the map runs a pass of this many levels: three at once, and what is left over.
fn dispatched(settings: &Settings, variant: &Variant) -> bool {
    let levels = settings.map.next_power_of_two().ilog2();
    match variant.value("levels") {
        Some("one") => levels % 3 == 1,
        Some("two") => levels % 3 == 2,
        Some("three") => levels >= 3,
        other => panic!("a chain makes {other:?} levels at once"),
    }
}

/// Where rules look whether something is of use, the values that a configuration has: those of its variants, else those of
/// its settings. All values on other axes.
fn allowed(library: &Library, settings: &Settings, variants: &[&Variant]) -> AllowedValues {
    let mut allowed = library.needed(&BTreeMap::new()).unwrap();
    let looked_at =
        library.presence.iter().flat_map(|rule| &rule.only_with).flat_map(BTreeMap::keys);
    for axis in looked_at {
        let of_variants = variants.iter().filter_map(|variant| variant.value(axis));
        let mut values: Vec<String> = of_variants.map(ToOwned::to_owned).collect();
        if values.is_empty() {
            values.extend(settings.get(axis));
        }
        // The camera is in every scene.
        if axis == "light" {
            values.push(sglow_shaders::Light::Camera.to_string());
        }
        assert!(!values.is_empty(), "no value of {axis}");
        allowed.get_mut(axis).unwrap().values.retain(|value| values.contains(value));
    }
    allowed
}

/// Whether a rule would leave a variant out if it were in force.
fn matches(rule: &Presence, variant: &Variant) -> bool {
    let fits = |(axis, values): (&String, &Vec<String>)| {
        variant.value(axis).is_some_and(|value| values.iter().any(|own| own == value))
    };
    rule.passes.contains(&variant.pass) && rule.when.iter().all(fits)
}
