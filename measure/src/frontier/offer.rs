//! Which configurations are measured: those that the package offers, the scene allows and the user requests.

use sglow_graph::frame::Variant;
use sglow_renderer::request::derivation::{Derivation, others};
use sglow_runtime::package::Package;
use sglow_runtime::settings::Settings;
use sglow_shader_gen::library::Library;
use sglow_shader_gen::matrix::Allowed as AllowedValue;
use sglow_shaders::Filter;

use super::case::{Case, SelectError};
use crate::frontier::configuration::{self, Allowed};
use crate::frontier::screen::Single;
use crate::frontier::space::{Has, Space};

/// The values that are requested, as `axis=value`.
///
/// # Errors
///
/// All that is wrong, with what is known.
pub fn only(only: &[String], library: &Library) -> Result<Allowed, SelectError> {
    let base = Settings { others: others(library), ..Settings::default() };
    let allowed = configuration::allowed(only, &base).map_err(SelectError::Values)?;
    // Settings do not know the values of axes that are laid over the library.
    let unknown = allowed.iter().filter_map(|(axis, values)| {
        let axis = (axis, &library.axis.get(axis)?.value);
        let known = |value: &&String| !axis.1.iter().any(|known| known.name == **value);
        let value = values.iter().find(known)?;
        let known: Vec<&str> = axis.1.iter().map(|value| value.name.as_str()).collect();
        Some(format!("unknown value `{value}` of axis `{}`; known: {}", axis.0, known.join(", ")))
    });
    let unknown: Vec<String> = unknown.collect();
    if unknown.is_empty() { Ok(allowed) } else { Err(SelectError::Values(unknown)) }
}

/// The values of each axis that settings have no field for.
fn more(derivation: &Derivation, library: &Library) -> Vec<(String, Vec<String>)> {
    let others = derivation.settings.others.keys();
    let values = |axis: &String| {
        let values = library.axis.get(axis)?.value.iter().map(|value| value.name.clone());
        let own = Settings::default();
        // What a field can hold is among the values that are known without the library.
        let values = values.filter(|value| own.clone().set(axis, value).is_err());
        Some((axis.clone(), values.collect()))
    };
    others.filter_map(values).collect()
}

/// The configurations that differ from `base` in one value of such an axis.
pub(super) fn singles(
    space: &Space<'_>,
    base: &Settings,
    Case { derivation, library, .. }: &Case,
    allowed: &dyn Fn(&Settings) -> bool,
) -> Vec<Single> {
    let mut all = Vec::new();
    for (axis, values) in more(derivation, library) {
        for value in values {
            if let Some(settings) = space.with(base, &axis, &value).filter(allowed) {
                all.push(Single { axis: axis.clone(), value, settings });
            }
        }
    }
    all
}

/// Each with every value of these axes.
fn crossed(mut all: Vec<Settings>, more: &[(String, Vec<String>)]) -> Vec<Settings> {
    for (axis, values) in more {
        let with = |configuration: Settings| {
            let more = values.iter().filter_map(|value| {
                let mut configuration = configuration.clone();
                (configuration.get(axis).as_ref() != Some(value)
                    && configuration.set(axis, value).is_ok())
                .then_some(configuration)
            });
            let more: Vec<Settings> = more.collect();
            std::iter::once(configuration).chain(more)
        };
        all = all.into_iter().flat_map(with).collect();
    }
    all
}

/// What there is to choose from.
pub struct Offer<'a> {
    /// The shaders.
    pub package: &'a Package,
    /// Whether every legal combination is measured, not only those that screening leaves.
    pub all: bool,
    /// Whether the device filters 32-bit floats.
    pub filters: bool,
}

impl Offer<'_> {
    fn has(&self, id: &str) -> bool {
        self.package.text(id).is_ok()
    }

    /// Whether there is a variant, with any values on some axes.
    fn has_some(&self, variant: &Variant, open: &[&str]) -> bool {
        let same = |id: &str| {
            let mut words = id.split('-');
            let pass = words.next() == Some(&variant.pass);
            // An identifier leaves out the default of an axis that is implied.
            let mut values = words.zip(&variant.axes);
            pass && values
                .all(|(word, (axis, value))| open.contains(&axis.as_str()) || word == value)
        };
        if open.is_empty() { self.has(&variant.id) } else { self.package.variants().any(same) }
    }

    fn runs(&self, configuration: &Settings) -> bool {
        self.filters || configuration.filter == Filter::Exact
    }
}

/// Whether a configuration is one that the offer has, the scene's needs leave and the user requests.
pub(super) fn allowed(
    offer: &Offer<'_>,
    case: &Case,
    space: &Space<'_>,
    only: &Allowed,
    configuration: &Settings,
) -> bool {
    let variants = || space.variants(configuration);
    configuration::fits(configuration, only)
        && needs_leave(&case.derivation, configuration)
        && offer.runs(configuration)
        && variants().is_some_and(|variants| variants.iter().all(|id| offer.has(id)))
}

/// The requested values that the scene's needs leave.
fn needed_values(derivation: &Derivation, only: &Allowed) -> Allowed {
    let mut left = only.clone();
    for (axis, allowed) in &derivation.allowed {
        let values = allowed.values.iter().cloned();
        let requested = |value: &String| only.get(axis).is_none_or(|only| only.contains(value));
        left.insert(axis.clone(), values.filter(requested).collect());
    }
    left
}

fn needs_leave(derivation: &Derivation, configuration: &Settings) -> bool {
    configuration::axes(configuration).iter().all(|(axis, value)| {
        let allowed = derivation.allowed.get(*axis);
        allowed.is_none_or(|allowed| allowed.values.iter().any(|allowed| allowed == value))
    }) && configuration.others.iter().all(|(axis, value)| {
        let (allowed, value) = (derivation.allowed.get(axis), value.to_string());
        value.is_empty() || allowed.is_none_or(|allowed| allowed.values.contains(&value))
    })
}

/// The configurations of a scene: with all that its needs leave on each axis.
///
/// # Errors
///
/// When none remains: names the values that exclude the last ones.
pub fn of(offer: &Offer<'_>, case: &Case, only: &Allowed) -> Result<Vec<Settings>, SelectError> {
    let Case { scene, derivation, library, .. } = case;
    let scene = &scene.name;
    let because = |(axis, allowed): (&String, &AllowedValue)| -> Vec<String> {
        let requested = |value: &String| only.get(axis).is_some_and(|only| only.contains(value));
        if !only.contains_key(axis) || allowed.values.iter().any(requested) {
            return Vec::new();
        }
        let rules = allowed.because.iter().filter(|rule| rule.removed.iter().any(requested));
        rules
            .map(|rule| {
                format!(
                    "{} leaves out {axis} {}: {}",
                    rule.need,
                    rule.removed.join(", "),
                    rule.reason
                )
            })
            .collect()
    };
    let help: Vec<String> = derivation.allowed.iter().flat_map(because).collect();
    if !help.is_empty() {
        return Err(SelectError::Nothing { scene: scene.clone(), help });
    }
    let space = case.space()?;
    let base = &derivation.settings;
    let more = more(derivation, library);
    let every = |only: &Allowed, has: Has<'_>| {
        let mut all = crossed(space.every(base, only, has), &more);
        all.retain(|configuration| configuration::fits(configuration, only));
        all
    };
    let offered = |variant: &Variant, open: &[&str]| offer.has_some(variant, open);
    let needed = |configuration: &Settings| needs_leave(derivation, configuration);
    // What the scene needs leaves fewer to look at.
    let mut configurations = every(&needed_values(derivation, only), &offered);
    configurations.retain(|one| offer.runs(one) && needed(one));
    if !configurations.is_empty() {
        return Ok(configurations);
    }
    let nearest = space.nearest(base, only);
    let variants = space.variants(&nearest).filter(|_| configuration::fits(&nearest, only));
    let help = if variants.is_none() {
        "no legal variant has these values together"
    } else if variants.is_some_and(|variants| !variants.iter().all(|id| offer.has(id))) {
        "no variant of the package has these values together"
    } else if !offer.filters {
        "filter=hardware needs a device that filters 32-bit floats"
    } else {
        "the scene needs other values (`cargo xtask variants --scene SCENE --explain`)"
    };
    Err(SelectError::Nothing { scene: scene.clone(), help: vec![help.to_owned()] })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frontier::case::tests::case;

    fn configurations(
        scene: &str,
        words: &[&str],
        all: bool,
        filters: bool,
    ) -> Result<Vec<Settings>, SelectError> {
        let case = case(scene, &[]);
        let package = Package::embedded();
        let words: Vec<_> = words.iter().map(|&word| word.to_owned()).collect();
        let only = only(&words, &case.library).unwrap();
        of(&Offer { package: &package, all, filters }, &case, &only)
    }

    #[test]
    fn a_scene_is_measured_by_what_it_needs() {
        let some = ["visibility=none", "space=none"];
        let diffuse = configurations("cornell", &some, false, true).unwrap();
        assert!(
            diffuse
                .iter()
                .all(|configuration| configuration.specular == sglow_shaders::Specular::None)
        );
        let glossy = configurations("cornell-glossy", &some, false, true).unwrap();
        assert!(glossy.len() > 5 * diffuse.len());
        let exact = configurations("cornell", &some, false, false).unwrap();
        assert!(
            exact.len() < diffuse.len()
                && exact.iter().all(|configuration| configuration.filter == Filter::Exact)
        );
    }

    #[test]
    fn a_value_that_leaves_no_configuration_is_named() {
        let help = |scene, words: &[&str], all, filters| {
            configurations(scene, words, all, filters).unwrap_err().to_string()
        };
        let needs = help("cornell", &["specular=asg"], false, true);
        assert!(needs.contains("no-specular-surface") && !needs.contains("--all"), "{needs}");
        let committed = help("cornell", &["diffuse=erf"], false, true);
        assert!(committed.contains("no variant of the package"), "{committed}");
        let device = help("cornell", &["filter=hardware"], false, false);
        assert!(device.contains("filters 32-bit floats"), "{device}");
        let together = ["kernel=previous", "solver=bracketed"];
        assert!(help("cornell", &together, false, true).contains("no legal variant"));
    }
}
