//! What is measured of scenes: one axis at a time, then what stays crossed, alike on all scenes.

use std::collections::{BTreeMap, BTreeSet};
use std::iter::once;

use sglow_renderer::device::Gpu;
use sglow_renderer::request::derivation::{Derivation, Request};
use sglow_results::frontier::document::Screening;
use sglow_results::frontier::promise;
use sglow_results::progress::Progress;
use sglow_runtime::settings::Settings;

use super::case::{Case, SelectError};
use super::offer::{self, Offer};
use crate::cache::Cache;
use crate::frontier::configuration::{self, Allowed};
use crate::frontier::depends::Depends;
use crate::frontier::named::configurations;
use crate::frontier::screen::{self, Single};
use crate::frontier::subject::Subject;

/// What is measured of one scene.
pub struct Planned {
    /// The configurations, in an order in which those that share maps and lights follow each other.
    pub configurations: Vec<Settings>,
    /// How they were found; none if they are all that there are.
    pub screening: Option<Screening>,
}

impl Planned {
    /// The names of configurations that promises are about: they are looked at closely.
    pub fn close(&self) -> BTreeSet<String> {
        let named = self.screening.iter().flat_map(|screening| screening.named.values());
        named.cloned().collect()
    }
}

/// A scene that is screened.
struct Started {
    base: Settings,
    singles: Vec<Single>,
}

/// What is measured of each scene: every configuration that is offered with `all`, else what screening leaves.
///
/// # Errors
///
/// When nothing remains of a scene, or it does not render.
pub fn plan(
    gpu: &Gpu,
    offer: &Offer<'_>,
    cases: &[Case],
    only: &Allowed,
    cache: &Cache,
    progress: &dyn Progress,
) -> Result<Vec<Planned>, SelectError> {
    if offer.all {
        let all = |case: &Case| {
            let configurations = offer::of(offer, case, only)?;
            Ok(Planned { configurations, screening: None })
        };
        return cases.iter().map(all).collect();
    }
    let mut started = Vec::new();
    let mut screened = Vec::new();
    for case in cases {
        let one = start(offer, case, only)?;
        let subject =
            Subject::new(gpu, offer.package, &case.scene, case.derivation.settings.clone());
        let found = screen::screen(&subject, &one.base, &one.singles, cache, progress);
        progress.end();
        screened.push(found?);
        started.push(one);
    }
    let kept = screen::keep(&screened, screen::CROSSED);
    let depends = Depends::of(offer.package.description());
    let mut planned = Vec::new();
    for (case, Started { base, singles }) in cases.iter().zip(started) {
        let space = case.space()?;
        let allowed = |one: &Settings| offer::allowed(offer, case, &space, only, one);
        let usual = &case.derivation.settings;
        let mut named = named(case)?;
        named.retain(|_, configuration| allowed(configuration));
        let names = named
            .iter()
            .map(|(what, configuration)| (what.clone(), configuration::name(configuration, usual)))
            .collect();
        let crossed = screen::crossed(&space, &base, &kept, &allowed);
        let screening = Screening {
            single: singles.len(),
            crossed: crossed.len(),
            axes: kept.clone(),
            named: names,
        };
        let all = once(base)
            .chain(singles.into_iter().map(|single| single.settings))
            .chain(named.into_iter().map(|one| one.1))
            .chain(crossed);
        planned.push(Planned {
            configurations: screen::distinct(usual, &depends, all),
            screening: Some(screening),
        });
    }
    Ok(planned)
}

/// Where screening starts: the default, changed where other values are requested.
fn start(offer: &Offer<'_>, case: &Case, only: &Allowed) -> Result<Started, SelectError> {
    let space = case.space()?;
    let allowed = |one: &Settings| offer::allowed(offer, case, &space, only, one);
    let base = space.nearest(&case.derivation.settings, only);
    if allowed(&base) {
        let mut singles = screen::singles(&space, &base, &allowed);
        singles.extend(offer::singles(&space, &base, case, &allowed));
        return Ok(Started { singles, base });
    }
    let name = &case.scene.name;
    offer::of(offer, case, only)?;
    Err(SelectError::Start { scene: name.clone() })
}

/// The configurations that promises are about.
fn named(case: &Case) -> Result<BTreeMap<String, Settings>, SelectError> {
    let Case { scene, derivation, library, .. } = case;
    let usual = &derivation.settings;
    let own = configurations(usual, &case.space()?.of_class(&["occluders"])?).into_iter();
    let mut named: BTreeMap<String, Settings> =
        own.map(|(what, settings)| (what.to_owned(), settings)).collect();
    let preset = promise::named::PRINTED.to_owned();
    let request = Request {
        size: usual.size,
        numbers: vec![format!("map={}", usual.map)],
        preset: Some(preset.clone()),
    };
    let printed = Derivation::new(library, scene, &[], &request)?.settings;
    named.insert(preset, Settings { assumed: usual.assumed.clone(), ..printed });
    Ok(named)
}

#[cfg(test)]
mod tests {
    use sglow_runtime::package::Package;

    use super::*;
    use crate::frontier::case::tests::case;

    fn started(scene: &str, words: &[&str]) -> Result<Started, SelectError> {
        let case = case(scene, &[]);
        let package = Package::embedded();
        let words: Vec<_> = words.iter().map(|&word| word.to_owned()).collect();
        let only = offer::only(&words, &case.library)?;
        start(&Offer { package: &package, all: false, filters: true }, &case, &only)
    }

    #[test]
    fn screening_starts_at_the_default_or_at_what_is_requested() {
        let usual = started("cornell", &[]).unwrap();
        let differs = |axis: &str| usual.singles.iter().any(|single| single.axis == axis);
        assert!(differs("visibility") && differs("lights") && differs("size_factor"));
        assert!(!differs("specular"), "a diffuse scene has no specular form");
        let few = started("cornell", &["visibility=none", "lights=64"]).unwrap();
        assert_eq!(few.base.lights, 64);
        assert!(few.singles.iter().all(|one| one.axis != "visibility" && one.axis != "lights"));
        let wrong = started("cornell", &["specular=asg"]).err().unwrap().to_string();
        assert!(wrong.contains("no-specular-surface"), "{wrong}");
    }

    #[test]
    fn what_promises_are_about_has_the_scenes_needs() {
        let case = case("cornell", &[]);
        let named = named(&case).unwrap();
        let printed = &named[promise::named::PRINTED];
        assert_eq!(printed.specular, sglow_shaders::Specular::None);
        assert_eq!((printed.size_factor, printed.map), (1.0, case.derivation.settings.map));
        assert_eq!(
            configuration::name(&named[promise::named::DEFAULT], &case.derivation.settings),
            "default"
        );
    }

    #[test]
    fn what_is_laid_over_the_library_is_screened() {
        let folder =
            std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/overlays/blur");
        let case = case("cornell", &[folder]);
        assert_eq!(case.derivation.settings.get("denoise").as_deref(), Some("none"));
        // What is chosen here need not run.
        let blurred = case.space().unwrap().with(&case.derivation.settings, "denoise", "blur");
        let ids = case.space().unwrap().variants(&blurred.unwrap()).unwrap();
        let package = ids.iter().filter(|id| Package::embedded().text(id).is_err());
        let package =
            package.fold(Package::embedded(), |package, id| package.with_text(id, String::new()));
        let of = |words: &[&str], all: bool| {
            let words: Vec<_> = words.iter().map(|&word| word.to_owned()).collect();
            let only = offer::only(&words, &case.library)?;
            let offer = Offer { package: &package, all, filters: true };
            let usual = &case.derivation.settings;
            let names = |configurations: &[Settings]| -> Vec<String> {
                configurations
                    .iter()
                    .map(|configuration| configuration::name(configuration, usual))
                    .collect()
            };
            if all {
                return Ok(names(&offer::of(&offer, &case, &only)?));
            }
            let Started { base, singles } = start(&offer, &case, &only)?;
            let singles: Vec<_> = singles.into_iter().map(|single| single.settings).collect();
            Ok::<_, SelectError>([names(&[base]), names(&singles)].concat())
        };
        let usual = of(&[], false).unwrap();
        assert!(usual.contains(&"denoise=blur".to_owned()), "{usual:?}");
        let few = of(&["denoise=blur", "blur_radius=4", "lights=64"], false).unwrap();
        assert_eq!(few[0], "lights=64,blur_radius=4,denoise=blur");
        let own = ["space=world", "visibility=none", "density=power", "draw=warped"];
        let both = ["denoise=none", "denoise=blur"];
        let two = of(&[&own[..], &both].concat(), true).unwrap();
        let one = of(&[&own[..], &both[..1]].concat(), true).unwrap();
        assert_eq!(two.len(), 2 * one.len());
        for wrong in ["denoise=sharpen", "denose=blur"] {
            let text = of(&[wrong], false).unwrap_err().to_string();
            assert!(text.contains("blur") || text.contains("denoise"), "{text}");
        }
    }
}
