//! Which ways are measured: those that the package offers, the scene allows and the user asks for.

use sglow_measure::frontier::way::{self, Allowed};
use sglow_runtime::device::Gpu;
use sglow_runtime::package::Package;
use sglow_runtime::settings::Settings;
use sglow_shaders::Filter;

use crate::derivation::Derivation;
use crate::failure::{Failure, Result};
use crate::selection::whole_space;

/// What `--only` says.
pub(crate) fn only(only: &[String]) -> Result<Allowed> {
    way::allowed(only).map_err(|wrong| Failure::new(wrong.join("\n")))
}

/// What is committed, or every legal variant.
pub(crate) fn package(all: bool) -> Result<Package> {
    if all { whole_space() } else { Ok(Package::embedded()) }
}

/// The ways of a scene: with all that its needs leave on each axis.
///
/// # Errors
///
/// When none remains: says what took the last ones away.
pub(crate) fn of(
    gpu: &Gpu,
    package: &Package,
    scene: &str,
    derivation: &Derivation,
    only: &Allowed,
) -> Result<Vec<Settings>> {
    let lacks_filter = |way: &Settings| way.filter != Filter::Exact && !gpu.filters_float32();
    let offered = |way: &Settings| {
        way::variants(way).iter().all(|id| package.text(id).is_ok()) && !lacks_filter(way)
    };
    let left = |axis: &str, value: &str| {
        let allowed = derivation.allowed.get(axis);
        allowed.is_none_or(|allowed| allowed.values.iter().any(|allowed| allowed == value))
    };
    let needed = |way: &Settings| way::axes(way).iter().all(|(axis, value)| left(axis, value));
    let fits = |way: &&Settings| way::fits(way, only);
    let offered: Vec<Settings> =
        way::every(&derivation.settings).into_iter().filter(offered).collect();
    let needed: Vec<Settings> = offered.iter().filter(|way| needed(way)).cloned().collect();
    let asked: Vec<Settings> = needed.iter().filter(fits).cloned().collect();
    if !asked.is_empty() {
        return Ok(asked);
    }
    let failure = Failure::new(format!("{scene}: nothing remains to be measured"));
    if !offered.iter().any(|way| fits(&way)) {
        return Err(failure.help(
            "no variant that is committed has these values together; --all takes every legal one",
        ));
    }
    let rules = derivation.allowed.iter().flat_map(|(axis, allowed)| {
        let asked = only.get(axis);
        allowed.because.iter().filter(move |rule| {
            asked.is_some_and(|asked| rule.removed.iter().any(|value| asked.contains(value)))
        })
    });
    Err(rules.fold(failure, |failure, rule| {
        failure.help(format!(
            "{} leaves out {}: {}",
            rule.need,
            rule.removed.join(", "),
            rule.reason
        ))
    }))
}
