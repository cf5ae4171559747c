//! What each rule leaves out for a scene, and what that saves.

use std::collections::{BTreeMap, BTreeSet};

use sglow_runtime::settings::Settings;
use sglow_scene::Facts;
use sglow_shader_gen::library::Library;
use sglow_shader_gen::manifest::{Assumed, LeftOut, MadeFor, Saved, Weight};
use sglow_shader_gen::matrix::{Absent, AllowedValues, Facts as KnownFacts, Variant};
use sglow_shader_gen::package::{Purpose, weigh};
use sglow_shaders::surface::Surface;
use sglow_shaders::{Emission, Light, Material, Opacity};

use crate::plan::{Plan, Storage, Surfaces};
use crate::request::RequestError;
use crate::request::derivation::{
    self, Derivation, assumptions, decides, match_distribution, settle,
};
use crate::variants::Variants as _;

/// Axes that follow from the surfaces alone.
const SURFACE_AXES: [&str; 3] = ["material", "opacity", "emission"];

/// Something to compare with: a plan, and how it is called.
struct Alternative {
    rule: String,
    reason: String,
    values: BTreeMap<String, Vec<String>>,
    against: String,
    plan: Plan,
}

/// What a package for a scene is made for, what was left out of it, and what a frame would take if every fact held.
/// `milliseconds` are what rules were measured to save, by name.
///
/// # Errors
///
/// When the library is wrong.
pub fn purpose(
    library: &Library,
    derivation: &Derivation,
    name: &str,
    set: &[String],
    milliseconds: Option<&BTreeMap<String, f64>>,
) -> Result<(Purpose, Plan), RequestError> {
    let mut alternatives = Vec::new();
    for (rule, values) in removed(&derivation.allowed) {
        alternatives.push(without(library, derivation, &rule, values, set)?);
    }
    let everything = everything(library, derivation, set)?;
    let absent = absent(library, derivation);
    let plans = alternatives.iter().map(|one| &one.plan).chain([&derivation.plan, &everything]);
    let mut ids: BTreeSet<String> = plans.flat_map(|plan| plan.variants.clone()).collect();
    ids.extend(absent.iter().map(|one| one.variant.id()));
    let mut variants = library.variants();
    variants.retain(|variant| ids.contains(&variant.id()));
    let weights = weigh(library, &variants)?;
    let own = weight(&derivation.plan, &weights);
    let measured = |rule: &str| milliseconds.and_then(|saved| saved.get(rule).copied());
    let mut left_out: Vec<_> = alternatives
        .into_iter()
        .map(|Alternative { rule, reason, values, against, plan }| LeftOut {
            saved: Saved { milliseconds: measured(&rule), ..weight(&plan, &weights) - own },
            variants: Vec::new(),
            rule,
            reason,
            values,
            against,
        })
        .collect();
    left_out.extend(useless(library, &absent, &weights));
    let purpose = Purpose {
        made_for: MadeFor {
            input: name.to_owned(),
            assumed: assumed(library, derivation, set),
            chosen: derivation::axes(&derivation.settings)
                .into_iter()
                .filter(|axis| library.axis.contains_key(*axis))
                .filter_map(|axis| Some((axis.to_owned(), derivation.settings.get(axis)?)))
                .collect(),
            saved: weight(&everything, &weights) - own,
        },
        left_out,
    };
    Ok((purpose, everything))
}

/// The values that each rule removed, by axis, in the order of the rules' first axes.
fn removed(allowed: &AllowedValues) -> Vec<(String, BTreeMap<String, Vec<String>>)> {
    let mut rules: Vec<(String, BTreeMap<String, Vec<String>>)> = Vec::new();
    for (axis, allowed) in allowed {
        for because in &allowed.because {
            let at = rules.iter().position(|(rule, _)| *rule == because.need);
            let at = at.unwrap_or_else(|| {
                rules.push((because.need.clone(), BTreeMap::new()));
                rules.len() - 1
            });
            rules[at].1.insert(axis.clone(), because.removed.clone());
        }
    }
    rules
}

/// What a frame would take without a rule.
fn without(
    library: &Library,
    derivation: &Derivation,
    rule: &str,
    values: BTreeMap<String, Vec<String>>,
    set: &[String],
) -> Result<Alternative, RequestError> {
    let known = derivation.needs.facts.known();
    let allowed = library.needed_without(&known, rule)?;
    let own = &derivation.settings;
    let mut settings = settled(library, derivation, &known, &allowed, set)?;
    let differs = |settings: &Settings| {
        let differs = |axis: &&&str| settings.get(axis) != own.get(axis);
        Settings::AXES.iter().filter(differs).copied().collect::<Vec<_>>()
    };
    if differs(&settings).is_empty() {
        // The default remains: what the rule has spared is what else might have been chosen.
        for (axis, removed) in &values {
            if let Some(value) = removed.first()
                && axis != "light"
                && Settings::AXES.contains(&axis.as_str())
                && !decides(set, axis)
            {
                settings.set(axis, value)?;
            }
        }
        match_distribution(&mut settings);
    }
    let mut against: Vec<_> = differs(&settings)
        .into_iter()
        .filter_map(|axis| Some(format!("{axis}={}", settings.get(axis)?)))
        .collect();
    let mut surfaces = derivation.surfaces.clone();
    if values.keys().any(|axis| SURFACE_AXES.contains(&axis.as_str())) {
        surfaces = surfaces.and(&kinds(derivation, &allowed));
    }
    let mut plan = derivation::plan(library, &settings, &surfaces)?;
    for (axis, removed) in &values {
        let text = removed.join(", ");
        if axis == "light" {
            for light in Light::ALL.iter().filter(|light| removed.contains(&light.to_string())) {
                let other = Settings { light: *light, ..settings.clone() };
                plan = plan.or(derivation::plan(library, &other, &surfaces)?);
            }
            against.push(format!("{axis}={text} as well"));
        } else if SURFACE_AXES.contains(&axis.as_str()) {
            against.push(format!("{axis}={text} as well"));
        }
    }
    let reason = library.need.iter().find(|need| need.name == rule).map(|need| need.reason.clone());
    Ok(Alternative {
        rule: rule.to_owned(),
        reason: reason.unwrap_or_default(),
        values,
        against: against.join(", "),
        plan,
    })
}

/// The settings that these values lead to, with the numbers and the light of the derivation.
fn settled(
    library: &Library,
    derivation: &Derivation,
    facts: &KnownFacts,
    allowed: &AllowedValues,
    set: &[String],
) -> Result<Settings, RequestError> {
    let mut requested = derivation.settings.clone();
    // The defaults of an input with these facts, as in `Derivation::new`.
    let defaults = derivation.request.settings(library, facts, set)?;
    for axis in Settings::AXES.iter().copied() {
        if let Some(value) = defaults.get(axis) {
            requested.set(axis, &value)?;
        }
    }
    let mut settings = settle(library, allowed, set, &requested)?;
    settings.light = derivation.settings.light;
    Ok(settings)
}

/// Surfaces of every kind that is allowed.
fn kinds(derivation: &Derivation, allowed: &AllowedValues) -> Surfaces {
    let has = |axis: &str, value: String| {
        allowed.get(axis).is_none_or(|allowed| allowed.values.contains(&value))
    };
    let materials = Material::ALL.into_iter().filter(|one| has("material", one.to_string()));
    let opacities = Opacity::ALL.into_iter().filter(|one| has("opacity", one.to_string()));
    let opacities: Vec<_> = opacities.collect();
    let kinds = materials.flat_map(|material| {
        let surface = move |&opacity: &Opacity| Surface { material, opacity };
        let legal = opacities.iter().map(surface).filter(|one| one.is_legal());
        legal
            .map(|Surface { material, opacity }| (material.to_string(), opacity.to_string()))
            .collect::<Vec<_>>()
    });
    let seen = has("emission", Emission::Seen.to_string());
    derivation.surfaces.with_kinds(&kinds.collect::<Vec<_>>(), seen)
}

/// What a frame would take if every fact held.
fn everything(
    library: &Library,
    derivation: &Derivation,
    set: &[String],
) -> Result<Plan, RequestError> {
    let known: KnownFacts = library.fact.iter().map(|fact| (fact.name.clone(), true)).collect();
    let allowed = library.needed(&known)?;
    let settings = settled(library, derivation, &known, &allowed, set)?;
    let surfaces = kinds(derivation, &allowed);
    let lights = Light::ALL.into_iter().filter(|light| *light != Light::Camera);
    let mut all = Plan::default();
    for light in lights {
        let settings = Settings { light, ..settings.clone() };
        all = all.or(derivation::plan(library, &settings, &surfaces)?);
    }
    Ok(all)
}

/// The variants that are of no use with what was chosen, and by which rule.
fn absent(library: &Library, derivation: &Derivation) -> Vec<Absent> {
    let mut allowed = derivation.allowed.clone();
    let settings = &derivation.settings;
    for axis in Settings::AXES.iter().copied() {
        let chosen = match axis {
            "solver" => Some(settings.sample().solver.to_string()),
            _ => settings.get(axis),
        };
        let camera = (axis == "light").then(|| Light::Camera.to_string());
        let chosen: Vec<_> = chosen.into_iter().chain(camera).collect();
        if let Some(allowed) = allowed.get_mut(axis) {
            allowed.values = chosen;
        }
    }
    // What the camera's lights take of their own is of use.
    let (_, mut absent) = library.remaining(&allowed);
    absent.retain(|one| !derivation.plan.variants.contains(&one.variant.id()));
    absent
}

/// What rules of presence leave out. The memory that such variants work on stands with the choices that need it.
fn useless(
    library: &Library,
    absent: &[Absent],
    weights: &BTreeMap<String, Weight>,
) -> Vec<LeftOut> {
    let left_out = |rule: &sglow_shader_gen::library::Presence| {
        let of_rule = absent.iter().filter(|one| one.presence == rule.name);
        let variants: Vec<_> = of_rule.map(|one| one.variant.id()).collect();
        if variants.is_empty() {
            return None;
        }
        let taken = Plan { variants: variants.iter().cloned().collect(), ..Plan::default() };
        Some(LeftOut {
            rule: rule.name.clone(),
            reason: rule.reason.clone(),
            values: BTreeMap::new(),
            variants,
            against: "the same with these variants".to_owned(),
            saved: weight(&taken, weights) - Weight::default(),
        })
    };
    library.presence.iter().filter_map(left_out).collect()
}

fn weight(plan: &Plan, weights: &BTreeMap<String, Weight>) -> Weight {
    let of = |id: &String| weights.get(id).copied().unwrap_or_default();
    let sum = |part: fn(&Weight) -> u64| plan.variants.iter().map(|id| part(&of(id))).sum();
    Weight {
        static_operations: sum(|weight| weight.static_operations),
        bindings: sum(|weight| weight.bindings),
        texture_bytes: plan.bytes(Storage::Texture, &[]),
        buffer_bytes: plan.bytes(Storage::Buffer, &[]),
        shader_bytes: sum(|weight| weight.shader_bytes),
    }
}

fn assumed(library: &Library, derivation: &Derivation, set: &[String]) -> Vec<Assumed> {
    let axes: Vec<&str> = library.axis.keys().map(String::as_str).collect();
    let facts: &Facts = &derivation.needs.facts;
    let with_evidence = |assumption: sglow_runtime::package::Assumption| Assumed {
        evidence: facts.get(&assumption.fact).map(|fact| fact.evidence.clone()).unwrap_or_default(),
        fact: assumption.fact,
        holds: assumption.holds,
        rule: assumption.rule,
    };
    assumptions(library, &derivation.allowed, &axes, set).into_iter().map(with_evidence).collect()
}

/// The variants of a plan, in the order of the library.
pub fn variants(library: &Library, plan: &Plan) -> Vec<Variant> {
    let mut variants = library.variants();
    variants.retain(|variant| plan.variants.contains(&variant.id()));
    variants
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::request::derivation::Request;
    use crate::request::library;
    use crate::request::shot::load;

    fn of(name: &str, set: &[&str]) -> (Derivation, Purpose, Plan) {
        let library = library();
        let scene = load(name, None, &sglow_scene::Options::default()).unwrap().0;
        let set: Vec<_> = set.iter().map(|&word| word.to_owned()).collect();
        let requested = Request::of([640, 360]);
        let derivation = Derivation::new(&library, &scene, &set, &requested).unwrap();
        let measured = BTreeMap::from([("no-specular-surface".to_owned(), 1.5)]);
        let (purpose, everything) =
            purpose(&library, &derivation, name, &set, Some(&measured)).unwrap();
        (derivation, purpose, everything)
    }

    fn saved(purpose: &Purpose, rule: &str) -> Option<Saved> {
        purpose.left_out.iter().find(|left| left.rule == rule).map(|left| left.saved)
    }

    #[test]
    fn what_a_scene_without_specular_saves_is_listed_by_rule() {
        let (derivation, purpose, everything) = of("cornell", &[]);
        let specular = saved(&purpose, "no-specular-surface").unwrap();
        // A texture of 16 bytes a pixel: what a cut knows of the map is in buffers.
        assert_eq!(specular.texture_bytes, 16 * 640 * 360);
        assert_eq!(specular.milliseconds, Some(1.5));
        for number in [
            specular.static_operations,
            specular.bindings,
            specular.buffer_bytes,
            specular.shader_bytes,
        ] {
            assert!(number > 0, "{specular:?}");
        }
        assert_eq!(saved(&purpose, "no-emitter").unwrap().texture_bytes, 8 * 640 * 360);
        // What has no use is reported, too: maps of points, for the default's are rasterised.
        let left = purpose.left_out.iter().find(|left| left.rule == "no-light-maps-of-points");
        assert_eq!(left.unwrap().variants, ["light_points-diffuse-f32", "light_fill"]);
        // The whole is more than any part.
        let all = purpose.made_for.saved;
        assert!(
            all.texture_bytes > specular.texture_bytes && all.shader_bytes > specular.shader_bytes
        );
        let textures = |plan: &Plan| plan.bytes(Storage::Texture, &[]) as i64;
        assert_eq!(textures(&everything) - textures(&derivation.plan), all.texture_bytes);
        assert!(purpose.made_for.assumed.iter().all(|assumed| !assumed.evidence.is_empty()));
    }

    #[test]
    fn what_is_asked_for_by_hand_is_taken_for_granted_of_nothing() {
        let rules = |set: &[&str]| {
            let (_, purpose, _) = of("cornell", set);
            let assumed = purpose.made_for.assumed.into_iter().map(|assumed| assumed.rule);
            assumed.collect::<BTreeSet<_>>()
        };
        assert!(rules(&[]).contains("no-specular-surface"));
        assert!(
            !rules(&["lobes=diffuse", "specular=none", "ndf=none"]).contains("no-specular-surface")
        );
    }

    #[test]
    fn a_scene_that_needs_a_thing_saves_nothing_by_it() {
        let (_, purpose, _) = of("atrium", &[]);
        for rule in ["no-specular-surface", "no-texture", "no-cutout", "no-occluder", "spot-light"]
        {
            assert_eq!(saved(&purpose, rule), None, "{rule}");
        }
        assert!(saved(&purpose, "directional-light").is_some());
    }
}
