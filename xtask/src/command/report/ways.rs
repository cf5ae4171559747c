//! Which ways are measured: those that the package offers, the scene allows and the user asks for.

use sglow_measure::frontier::way::{self, Allowed};
use sglow_runtime::device::Gpu;
use sglow_runtime::package::Package;
use sglow_runtime::settings::Settings;
use sglow_shaders::{Filter, Lobes, Specular};

use crate::failure::{Failure, Result};
use crate::selection::whole_space;
use crate::shot::Shot;

/// What `--only` says.
pub(crate) fn only(only: &[String]) -> Result<Allowed> {
    way::allowed(only).map_err(|wrong| Failure::new(wrong.join("\n")))
}

/// What is committed, or every legal variant.
pub(crate) fn package(all: bool) -> Result<Package> {
    if all { whole_space() } else { Ok(Package::embedded()) }
}

/// The ways of a scene.
///
/// # Errors
///
/// When none remains: says what took the last ones away.
pub(crate) fn of(
    gpu: &Gpu,
    package: &Package,
    shot: &Shot,
    only: &Allowed,
) -> Result<Vec<Settings>> {
    let base = &shot.settings;
    let offered = |way: &Settings| {
        way::variants(way).iter().all(|id| package.text(id).is_ok())
            && (way.filter == Filter::Exact || gpu.filters_float32())
    };
    let needed = |way: &Settings| {
        let nothing_specular = base.specular == Specular::None;
        !nothing_specular || way.lobes == Lobes::Diffuse && way.specular == Specular::None
    };
    let offered: Vec<Settings> = way::every(base).into_iter().filter(offered).collect();
    let needed: Vec<Settings> = offered.iter().filter(|way| needed(way)).cloned().collect();
    let asked: Vec<Settings> = needed.iter().filter(|way| way::fits(way, only)).cloned().collect();
    if asked.is_empty() {
        let fit = offered.iter().any(|way| way::fits(way, only));
        let failure = Failure::new(format!("{}: nothing remains to be measured", shot.scene.name));
        return Err(if fit {
            failure.help("the scene reflects nothing specularly, and what is specular is left out")
        } else {
            failure
                .help("no committed variant has these values together; --all takes every legal one")
        });
    }
    Ok(asked)
}
