//! Which ways are measured: those that the package offers, the scene allows and the user asks for.

use sglow_measure::frontier::way::{self, Allowed};
use sglow_runtime::package::Package;
use sglow_runtime::settings::Settings;
use sglow_shader_gen::matrix::Allowed as AllowedValue;
use sglow_shaders::Filter;

use crate::derivation::Derivation;
use crate::failure::{Failure, Result};

/// What `--only` says.
pub(crate) fn only(only: &[String]) -> Result<Allowed> {
    way::allowed(only).map_err(|wrong| Failure::new(wrong.join("\n")))
}

/// What there is to choose from.
pub(crate) struct Offer<'a> {
    /// The shaders.
    pub(crate) package: &'a Package,
    /// Whether every legal combination is measured, not only those that screening leaves.
    pub(crate) all: bool,
    /// Whether the device filters 32-bit floats.
    pub(crate) filters: bool,
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
    })
}

/// The ways of a scene: with all that its needs leave on each axis.
///
/// # Errors
///
/// When none remains: says what took the last ones away.
pub(crate) fn of(
    offer: &Offer<'_>,
    scene: &str,
    derivation: &Derivation,
    only: &Allowed,
) -> Result<Vec<Settings>> {
    let needed = |way: &&Settings| needs_leave(derivation, way);
    let mut asked = way::every(&derivation.settings);
    asked.retain(|way| way::fits(way, only));
    let failure = || Failure::new(format!("{scene}: nothing remains to be measured"));
    if asked.is_empty() {
        return Err(failure().help("no legal variant has these values together"));
    }
    asked.retain(|way| offer.has(way));
    if asked.is_empty() {
        return Err(failure().help("no variant of the package has these values together"));
    }
    asked.retain(|way| offer.runs(way));
    if asked.is_empty() {
        return Err(failure().help("filter=hardware needs a device that filters 32-bit floats"));
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
    Err(derivation.allowed.iter().flat_map(because).fold(failure(), Failure::help))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::command::report::Case;
    use crate::shot::Numbers;

    fn ways(scene: &str, words: &[&str], all: bool, filters: bool) -> Result<Vec<Settings>> {
        let case = Case::new(scene, [16, 9], &Numbers::default()).unwrap();
        let package = Package::embedded();
        let only = only(&words.iter().map(|&word| word.to_owned()).collect::<Vec<_>>()).unwrap();
        of(&Offer { package: &package, all, filters }, scene, &case.derivation, &only)
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
