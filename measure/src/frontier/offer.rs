//! Which ways are measured: those that the package offers, the scene allows and the user asks for.

use sglow_renderer::request::derivation::{Derivation, others};
use sglow_runtime::package::Package;
use sglow_runtime::settings::Settings;
use sglow_shader_gen::library::Library;
use sglow_shader_gen::matrix::Allowed as AllowedValue;
use sglow_shaders::Filter;

use super::case::{Case, SelectError};
use crate::frontier::screen::{self, Single};
use crate::frontier::way::{self, Allowed};

/// The values that are requested, as `axis=value`.
///
/// # Errors
///
/// All that is wrong, with what is known.
pub fn only(only: &[String], library: &Library) -> Result<Allowed, SelectError> {
    let base = Settings { others: others(library), ..Settings::default() };
    let allowed = way::allowed(only, &base).map_err(SelectError::Values)?;
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
    base: &Settings,
    derivation: &Derivation,
    library: &Library,
    allowed: &dyn Fn(&Settings) -> bool,
) -> Vec<Single> {
    let mut all = Vec::new();
    for (axis, values) in more(derivation, library) {
        for value in values {
            if let Some(settings) = screen::with(base, &axis, &value).filter(|one| allowed(one)) {
                all.push(Single { axis: axis.clone(), value, settings });
            }
        }
    }
    all
}

/// Each with every value of these axes.
fn crossed(mut all: Vec<Settings>, more: &[(String, Vec<String>)]) -> Vec<Settings> {
    for (axis, values) in more {
        let with = |way: Settings| {
            let more = values.iter().filter_map(|value| {
                let mut way = way.clone();
                (way.get(axis).as_ref() != Some(value) && way.set(axis, value).is_ok())
                    .then_some(way)
            });
            let more: Vec<Settings> = more.collect();
            std::iter::once(way).chain(more)
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
    fn has(&self, way: &Settings) -> bool {
        way::variants(way).iter().all(|id| self.package.text(id).is_ok())
    }

    fn runs(&self, way: &Settings) -> bool {
        self.filters || way.filter == Filter::Exact
    }
}

/// Whether a way is one that the offer has, the scene's needs leave and the user asks for.
pub(super) fn allowed(
    offer: &Offer<'_>,
    derivation: &Derivation,
    only: &Allowed,
    way: &Settings,
) -> bool {
    way::fits(way, only) && needs_leave(derivation, way) && offer.has(way) && offer.runs(way)
}

fn needs_leave(derivation: &Derivation, way: &Settings) -> bool {
    way::axes(way).iter().all(|(axis, value)| {
        let allowed = derivation.allowed.get(*axis);
        allowed.is_none_or(|allowed| allowed.values.iter().any(|allowed| allowed == value))
    }) && way.others.iter().all(|(axis, value)| {
        let (allowed, value) = (derivation.allowed.get(axis), value.to_string());
        value.is_empty() || allowed.is_none_or(|allowed| allowed.values.contains(&value))
    })
}

/// The ways of a scene: with all that its needs leave on each axis.
///
/// # Errors
///
/// When none remains: says what took the last ones away.
pub fn of(offer: &Offer<'_>, case: &Case, only: &Allowed) -> Result<Vec<Settings>, SelectError> {
    let Case { scene, derivation, library } = case;
    let scene = &scene.name;
    let needed = |way: &&Settings| needs_leave(derivation, way);
    let every = way::every(&derivation.settings);
    let mut asked = crossed(every, &more(derivation, library));
    asked.retain(|way| way::fits(way, only));
    let failure =
        |help: &str| SelectError::Nothing { scene: scene.clone(), help: vec![help.to_owned()] };
    if asked.is_empty() {
        return Err(failure("no legal variant has these values together"));
    }
    asked.retain(|way| offer.has(way));
    if asked.is_empty() {
        return Err(failure("no variant of the package has these values together"));
    }
    asked.retain(|way| offer.runs(way));
    if asked.is_empty() {
        return Err(failure("filter=hardware needs a device that filters 32-bit floats"));
    }
    let ways: Vec<Settings> = asked.iter().filter(needed).cloned().collect();
    if !ways.is_empty() {
        return Ok(ways);
    }
    let because = |(axis, allowed): (&String, &AllowedValue)| -> Vec<String> {
        let has = |value: &String| {
            asked.iter().all(|way| way::axes(way).get(axis.as_str()) == Some(&value.as_str()))
        };
        let rules = allowed.because.iter().filter(|rule| rule.removed.iter().any(has));
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
    let help = derivation.allowed.iter().flat_map(because).collect();
    Err(SelectError::Nothing { scene: scene.clone(), help })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frontier::case::tests::case;

    fn ways(
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
        let diffuse = ways("cornell", &[], false, true).unwrap();
        assert!(diffuse.iter().all(|way| way.specular == sglow_shaders::Specular::None));
        let glossy = ways("cornell-glossy", &[], false, true).unwrap();
        assert!(glossy.len() > 5 * diffuse.len());
        let exact = ways("cornell", &[], false, false).unwrap();
        assert!(exact.len() < diffuse.len() && exact.iter().all(|way| way.filter == Filter::Exact));
    }

    #[test]
    fn what_took_the_last_way_away_is_named() {
        let help = |scene, words: &[&str], all, filters| {
            ways(scene, words, all, filters).unwrap_err().to_string()
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
