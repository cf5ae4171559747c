//! The configurations of indirect light that there are: a value on each axis, all legal combinations of what makes
//! virtual lights with what reflects them.

use std::collections::{BTreeMap, BTreeSet};

use sglow_renderer::variants::Variants as _;
use sglow_runtime::settings::{Settings, SettingsError};
use sglow_shaders::{
    Cut, Density, Diffuse, Draw, Emitter, Filter, Kernel, Lobes, Ndf, Precision, Solver, Space,
    Specular, Visibility, centres, cut_lights, light_points, light_shadow,
};

use sglow_oracle::cut::tile::MAX_ROOTS;

/// The value on each axis that methods are compared by, of those that follow from others as well.
#[must_use]
pub fn axes(settings: &Settings) -> BTreeMap<&'static str, &'static str> {
    let followed = settings.clone().followed();
    Settings::COMPARED.iter().filter_map(|axis| Some((*axis, followed.axis(axis)?))).collect()
}

/// Whether others decide the value on an axis.
fn follows(settings: &Settings, axis: &str) -> bool {
    let with = |value: &&str| {
        let mut other = settings.clone();
        let _ = other.set_axis(axis, value);
        other.followed().axis(axis)
    };
    let mut values = Settings::values(axis).iter().map(with);
    let first = values.next();
    values.all(|value| Some(value) == first)
}

/// The value of each parameter, and of what a library that was laid over this one adds.
pub fn parameters(settings: &Settings) -> impl Iterator<Item = (&str, String)> {
    let own = Settings::PARAMETERS.iter().copied();
    let others = settings.others.iter().filter(|(_, value)| !value.to_string().is_empty());
    own.chain(others.map(|(name, _)| name.as_str()))
        .map(|name| (name, settings.get(name).unwrap_or_default()))
}

/// The value on an axis, or of a parameter; nothing if there is neither.
#[must_use]
pub fn value(settings: &Settings, axis: &str) -> Option<String> {
    let other = settings.others.get(axis).is_some_and(|other| !other.to_string().is_empty());
    let of_axis = axes(settings).get(axis).filter(|_| !other).map(|value| (*value).to_owned());
    of_axis.or_else(|| settings.get(axis))
}

/// Values that one axis or parameter each may have; one that is not named may have any.
pub type Allowed = BTreeMap<String, BTreeSet<String>>;

/// Reads `axis=value`; an axis may be given more than once. `base` knows what a library that was laid over this one
/// adds.
///
/// # Errors
///
/// All that is wrong: an axis or a value that there is not, with those that there are.
pub fn allowed(only: &[String], base: &Settings) -> Result<Allowed, Vec<String>> {
    let mut allowed = Allowed::new();
    let mut wrong = Vec::new();
    for one in only {
        let Some((axis, value)) = one.split_once('=') else {
            wrong.push(format!("`{one}` is not AXIS=VALUE"));
            continue;
        };
        let known = Settings::COMPARED.iter().chain(Settings::PARAMETERS);
        let known = known.map(|name| (*name).to_owned());
        let known: Vec<String> = known.chain(base.others.keys().cloned()).collect();
        if !known.iter().any(|known| known == axis) {
            wrong.push(SettingsError::UnknownAxis { axis: axis.to_owned(), known }.to_string());
        } else if let Err(error) = base.clone().set(axis, value) {
            wrong.push(format!("axis {axis}: {error}"));
        } else {
            allowed.entry(axis.to_owned()).or_default().insert(value.to_owned());
        }
    }
    if wrong.is_empty() { Ok(allowed) } else { Err(wrong) }
}

/// Whether every value is one that its axis may have.
#[must_use]
pub fn fits(settings: &Settings, allowed: &Allowed) -> bool {
    allowed
        .iter()
        .all(|(axis, allowed)| value(settings, axis).is_none_or(|value| allowed.contains(&value)))
}

/// What a configuration is called: the values in which it differs from `base`. `--set` with these alone may give another
/// one, since some defaults do not apply beside values that are set: [`super::case::Case::set`] has them all.
#[must_use]
pub fn name(settings: &Settings, base: &Settings) -> String {
    let (ours, theirs) = (axes(settings), axes(base));
    let differs = |axis: &&str| {
        // What follows from another value is left out; the distribution of facets does from the specular lobe.
        ours.get(axis) != theirs.get(axis) && *axis != Ndf::AXIS && !follows(settings, axis)
    };
    let value = |axis| Some(format!("{axis}={}", ours.get(axis)?));
    let compared = Settings::COMPARED.iter().copied();
    let mut parts: Vec<String> = compared.filter(differs).filter_map(value).collect();
    let numbers = Settings::PARAMETERS.iter().copied();
    let others = settings.others.keys().map(String::as_str);
    for name in numbers.chain(others) {
        let [ours, theirs] = [settings, base].map(|one| self::value(one, name));
        let text = ours.iter().filter(|_| ours != theirs).map(|ours| format!("{name}={ours}"));
        // An axis that has a field is there already if that has changed.
        parts.extend(text.filter(|text| !parts.contains(text)).collect::<Vec<_>>());
    }
    if parts.is_empty() { "default".to_owned() } else { parts.join(",") }
}

/// The variants in which configurations differ: what draws or sums its lights, reflects and shadows them.
#[must_use]
pub fn variants(settings: &Settings) -> Vec<String> {
    let Settings { density, precision, space, .. } = *settings;
    let mut ids = Vec::new();
    if space != Space::Tree && (precision == Precision::F32 || density != Density::Power) {
        ids.push(settings.density().id());
    }
    ids.push(match space {
        Space::None => settings.sample().id(),
        Space::Image | Space::World => centres::Centres::from(settings).id(),
        Space::Tree => cut_lights::CutLights::from(settings).id(),
    });
    ids.push(settings.shade().id());
    match settings.visibility {
        Visibility::None => {}
        Visibility::ShadowMap => {
            ids.push(light_shadow::LightShadow::from(settings).id());
        }
        Visibility::Imperfect => {
            ids.push(light_points::LightPoints::from(settings).id());
        }
    }
    ids
}

/// Every configuration that is legal, with everything else as in `base`: those that make the same lights follow each
/// other.
#[must_use]
pub fn every(base: &Settings) -> Vec<Settings> {
    let mut all = Vec::new();
    for lights in makers(base) {
        for visibility in Visibility::ALL {
            for specular in Specular::ALL {
                let ndf = distribution(specular, base);
                for emitter in Emitter::ALL {
                    for diffuse in Diffuse::ALL {
                        let own = Settings { emitter, diffuse, ..lights.clone() };
                        let mut configuration = Settings { specular, ndf, visibility, ..own };
                        if base.near_scale == near_scale(base) {
                            configuration.near_scale = near_scale(&configuration);
                        }
                        if configuration.shade().excluded().is_none() {
                            all.push(configuration);
                        }
                    }
                }
            }
        }
    }
    all
}

/// The distribution of facets that goes with a lobe. It is what the material is, no choice of lighting: the reference
/// has the same.
pub(super) fn distribution(specular: Specular, base: &Settings) -> Ndf {
    match (specular, base.ndf) {
        (Specular::None, _) => Ndf::None,
        (_, Ndf::None) => Ndf::Ggx,
        (_, ndf) => ndf,
    }
}

/// The number of lights that a cut for each tile begins with, and `near_scale` with it: as the rules cut-with-occluders and
/// near-with-cut set them.
pub(super) const ROOTS: u32 = 256;
pub(super) const NEAR_SCALE: f32 = 0.75;

/// `near_scale` unless it is set: a cut's rasterised maps are seen from a surface.
pub(super) fn near_scale(settings: &Settings) -> f32 {
    let surface = settings.cut != Cut::None && settings.visibility == Visibility::ShadowMap;
    if surface { NEAR_SCALE } else { Settings::default().near_scale }
}

/// What makes virtual lights.
fn makers(base: &Settings) -> Vec<Settings> {
    let mut all = Vec::new();
    for lobes in Lobes::ALL {
        for precision in Precision::ALL {
            for density in Density::ALL {
                for draw in Draw::ALL {
                    let base = Settings { lobes, precision, density, draw, ..base.clone() };
                    all.extend(kernels(&base));
                    // Clusters have no kernels to size, and are held in 32 bits.
                    if precision == Precision::F32 {
                        let clusters = [Space::Image, Space::World];
                        all.extend(clusters.map(|space| grouped(&base, space, Cut::None)));
                    }
                    // Density and draw do not apply to trees.
                    if (density, draw) == (Density::Power, Draw::Warped) {
                        all.extend(Cut::ALL.map(|cut| grouped(&base, Space::Tree, cut)));
                    }
                }
            }
        }
    }
    all
}

/// Clusters, or the nodes of a tree, which have no kernels to size; with a cut at most as many as a tile takes.
fn grouped(base: &Settings, space: Space, cut: Cut) -> Settings {
    let lights = if cut == Cut::None { base.lights } else { base.lights.min(MAX_ROOTS as u32) };
    Settings {
        space,
        cut,
        lights,
        kernel: Kernel::Modified,
        solver: Solver::Bracketed,
        filter: Filter::Exact,
        ..base.clone()
    }
}

fn kernels(base: &Settings) -> Vec<Settings> {
    let sizes = [
        (Kernel::Previous, Solver::None),
        (Kernel::Modified, Solver::Bisection),
        (Kernel::Modified, Solver::Bracketed),
    ];
    sizes
        .into_iter()
        .flat_map(|(kernel, solver)| {
            Filter::ALL.map(|filter| Settings {
                space: Space::None,
                cut: Cut::None,
                kernel,
                solver,
                filter,
                ..base.clone()
            })
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_configuration_is_legal_and_is_there_once() {
        let base = Settings::default();
        let all = every(&base);
        let names: BTreeSet<String> =
            all.iter().map(|configuration| name(configuration, &base)).collect();
        assert_eq!(names.len(), all.len());
        assert!(names.contains("default") && names.contains("diffuse=constant,kernel=previous"));
        for configuration in &all {
            assert!(
                configuration.shade().excluded().is_none()
                    && configuration.sample().excluded().is_none()
            );
        }
        let cut = Settings {
            space: Space::Tree,
            cut: Cut::Tile,
            emitter: Emitter::Disc,
            visibility: Visibility::ShadowMap,
            lights: 448,
            near_scale: NEAR_SCALE,
            ..base.clone()
        };
        assert!(every(&cut).contains(&cut), "the default of a class");
        // What is not a configuration is noticed.
        assert!(Settings { specular: Specular::None, ..base }.shade().excluded().is_some());
    }

    #[test]
    fn a_name_leads_back_to_its_configuration() {
        let base = Settings::default();
        for configuration in every(&base) {
            let mut again = base.clone();
            for setting in name(&configuration, &base).split(',').filter(|name| *name != "default")
            {
                let (axis, value) = setting.split_once('=').unwrap();
                again.set(axis, value).unwrap();
            }
            again.ndf = distribution(again.specular, &base);
            assert_eq!(axes(&again), axes(&configuration));
        }
        let few = Settings { lights: 64, size_factor: 0.25, ..base.clone() };
        assert_eq!(name(&few, &base), "lights=64,size_factor=0.25");
        assert!(fits(&few, &allowed(&["lights=64".to_owned()], &base).unwrap()));
        assert!(!fits(&base, &allowed(&["lights=64".to_owned()], &base).unwrap()));
    }

    #[test]
    fn what_is_not_an_axis_or_a_value_is_reported_with_what_is() {
        let wrong = ["colour=red", "kernel=cubic", "kernel", "light=spot", "output=rgba16float"];
        let wrong = wrong.map(str::to_owned);
        let text = allowed(&wrong, &Settings::default()).unwrap_err().join("\n");
        let parts = [
            "unknown axis 'colour'",
            "previous, modified",
            "not AXIS=VALUE",
            "unknown axis 'light'",
            "unknown axis 'output'",
        ];
        for part in parts {
            assert!(text.contains(part), "{text}");
        }
        let two = ["kernel=previous", "kernel=modified"].map(str::to_owned);
        let base = Settings::default();
        let allowed = allowed(&two, &base).unwrap();
        assert!(fits(&base, &allowed));
        let one = super::allowed(&two[..1], &base).unwrap();
        assert!(!fits(&base, &one));
    }
}
