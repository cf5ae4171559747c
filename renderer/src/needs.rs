//! What a scene needs of a frame's numbers, each with its reason, and what was assumed of it.
//!
//! What it needs of the axes follows from [`sglow_scene::Facts`] by the rules of the shader library. No device is needed
//! for either.

use std::fmt;

use sglow_graph::Description;
use sglow_graph::frame::{Frame, Kind, Resource};
use sglow_shaders::frame::{parameter, part, resource};
use sglow_shaders::{Density, Light, Space, Visibility};

use crate::light;
use sglow_runtime::light::grid;
use sglow_runtime::package::Assumption;
use sglow_runtime::settings::Settings;
use sglow_scene::{Facts, LightKind, Scene};

/// What a scene needs and was taken not to.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MissingNeed {
    /// Name of the fact that holds and was taken not to.
    pub fact: String,
    /// Name of the rule that left something out because of it.
    pub rule: String,
    /// What shows that it holds.
    pub evidence: String,
}

impl fmt::Display for MissingNeed {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { fact, rule, evidence } = self;
        write!(f, "{evidence}, while `{fact}` was taken not to hold (rule `{rule}`)")
    }
}

/// Everything that a scene needs and that was taken not to hold. A fact that was taken to hold and does not means that
/// the scene needs less.
pub fn missing(facts: &Facts, assumed: &[Assumption]) -> Vec<MissingNeed> {
    let missing = |assumption: &Assumption| {
        let fact = facts.get(&assumption.fact).filter(|fact| fact.holds && !assumption.holds)?;
        Some(MissingNeed {
            fact: assumption.fact.clone(),
            rule: assumption.rule.clone(),
            evidence: fact.evidence.clone(),
        })
    };
    assumed.iter().filter_map(missing).collect()
}

/// A number or a choice that no axis has, with its reason.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Decision {
    /// What is decided.
    pub name: &'static str,
    /// The value.
    pub value: String,
    /// Why.
    pub reason: String,
    /// Whether it is another value than was requested.
    pub changed: bool,
}

/// What a scene needs.
#[derive(Clone, Debug, PartialEq)]
pub struct Needs {
    /// What is true of it.
    pub facts: Facts,
    /// Everything that was decided, with its reason.
    pub decisions: Vec<Decision>,
    /// The requested settings with what was decided.
    pub settings: Settings,
}

impl Needs {
    fn decide(&mut self, name: &'static str, requested: u32, value: u32, reason: String) -> u32 {
        let changed = requested != value;
        self.decisions.push(Decision { name, value: value.to_string(), reason, changed });
        value
    }

    fn note(&mut self, name: &'static str, value: impl Into<String>, reason: impl Into<String>) {
        let (value, reason) = (value.into(), reason.into());
        self.decisions.push(Decision { name, value, reason, changed: false });
    }
}

/// What every WebGPU device grants.
pub fn least_limits() -> wgpu::Limits {
    wgpu::Limits::default()
}

/// What a scene needs, lit by its light number `light` (the first if there is no such light), or by all if the
/// requested light is several, of the numbers of the requested settings. What a device with these limits could not do
/// is brought within them: how large things are, the frame of the `description` says. Settings of which it makes no
/// frame stay as they are; its evaluation says what is wrong.
pub fn needs(
    description: &Description,
    scene: &Scene,
    light: usize,
    requested: &Settings,
    limits: &wgpu::Limits,
) -> Needs {
    let several = requested.light == Light::Several;
    let facts = if several { scene.facts() } else { scene.facts_lit_by(light) };
    let mut needs = Needs { facts, decisions: Vec::new(), settings: requested.clone() };
    let one = scene.lights.get(light..=light).or(scene.lights.get(..1)).unwrap_or_default();
    let lights = if several { &scene.lights } else { one };
    let faces = light::faces(lights).max(1);
    let grid = grid(faces);
    if let [light, ..] = lights {
        needs.settings.light = if several { Light::Several } else { light::kind(light) };
        needs.settings.light_faces = faces;
        let (value, reason) = match light.kind {
            _ if several => {
                let [count, columns, rows] = [lights.len() as u32, grid[0], grid[1]];
                let faces = format!("{faces} faces in a grid of {columns} x {rows}");
                ("shared", format!("{count} lights share it: {faces}"))
            }
            LightKind::Spot { .. } => {
                ("planar", "a spot light sees its cone in one perspective image".to_owned())
            }
            LightKind::Directional => (
                "planar",
                "a directional light sees the scene in one orthographic image".to_owned(),
            ),
            LightKind::Point => (
                "deep",
                "a point light sees all around it: six faces in a grid of 4 x 2".to_owned(),
            ),
        };
        needs.note("reflective shadow map", value, reason);
    }
    size_of_map(&mut needs, description, grid[0], limits);
    number_of_lights(
        &mut needs,
        description,
        [u64::from(faces), (grid[0] * grid[1]).into()],
        limits,
    );
    light_maps(&mut needs, description, limits);
    roughness(&mut needs, scene);
    needs.note(
        "environment",
        "none",
        "no scene has one in this version; what a file has of one is ignored with a note",
    );
    needs
}

fn size_of_map(needs: &mut Needs, description: &Description, columns: u32, limits: &wgpu::Limits) {
    let requested = needs.settings.map;
    let mut most = 1 << limits.max_texture_dimension_2d.max(1).ilog2();
    let mut why =
        format!("this device's textures are at most {} wide", limits.max_texture_dimension_2d);
    let words = limits.max_storage_buffer_binding_size / 4;
    if needs.settings.space == Space::Tree {
        // Of a map of 4 by 4; what a cut keeps is as large as the square of a power of two that holds the map.
        let small =
            frame(description, &Settings { map: 4, light: Light::Spot, ..needs.settings.clone() });
        let moments = small.as_ref().and_then(|frame| find(frame, resource::BLOCKS));
        let texel = moments.map_or(1, |blocks| blocks.bytes / 16).max(1);
        let texels = limits.max_storage_buffer_binding_size / texel;
        let side = 1 << (texels.max(1).ilog2() / 2);
        if side < most {
            most = side;
            why = format!(
                "a cut keeps {texel} bytes of moments for each texel in a buffer of at most {} bytes on this device",
                limits.max_storage_buffer_binding_size
            );
        }
    } else if needs.settings.space != Space::None && words < u64::from(most).pow(2) {
        most = words.isqrt() as u32;
        why =
            format!("clusters sort its texels in a buffer of at most {words} words on this device");
    }
    let mut size = requested.clamp(1, most.max(1));
    let mut reason = if size < requested { why } else { "as requested".to_owned() };
    if !size.is_multiple_of(columns) {
        size = (size / columns).max(1) * columns;
        reason = format!("{reason}; a multiple of {columns}, for its faces are tiles of it");
    }
    needs.settings.map = needs.decide("size of the map", requested, size, reason);
}

/// The bounds of a parameter; those of all numbers without it.
fn bounds(description: &Description, name: &str) -> [u64; 2] {
    let of = description.parameter.get(name);
    let [minimum, maximum] = [of.and_then(|of| of.minimum), of.and_then(|of| of.maximum)];
    [minimum.map_or(0, |minimum| minimum as u64), maximum.map_or(u64::MAX, |most| most as u64)]
}

/// The frame of settings; nothing if there is none.
fn frame(description: &Description, settings: &Settings) -> Option<Frame> {
    description.evaluate(&settings.configuration()).ok()
}

fn find<'a>(frame: &'a Frame, name: &str) -> Option<&'a Resource> {
    frame.resources.get(frame.resource(name)?)
}

fn number_of_lights(
    needs: &mut Needs,
    description: &Description,
    [faces, tiles]: [u64; 2],
    limits: &wgpu::Limits,
) {
    let Settings { lights: requested, map: rsm_size, .. } = needs.settings;
    // Some tiles are empty: two of the eight of a point light's map.
    let texels = u64::from(rsm_size).pow(2) / tiles * faces;
    let single = frame(description, &Settings { lights: 1, ..needs.settings.clone() });
    let light = single.as_ref().and_then(|frame| find(frame, resource::VSGLS));
    let light = light.map_or(1, |vsgls| vsgls.bytes.max(1));
    let room = limits.max_storage_buffer_binding_size / light;
    let choices = [
        (u64::from(requested), "as requested; 1024 are those of [Tokuyoshi 2016]".to_owned()),
        (
            texels,
            format!("the map has no more texels than {texels}, and each makes one light at most"),
        ),
        (room, format!("a buffer of this device has room for {room} lights of {light} bytes")),
        (bounds(description, parameter::LIGHTS)[1], "the maximum".to_owned()),
    ];
    // The first of several that are alike.
    let least = choices.into_iter().min_by_key(|(count, _)| *count);
    if let Some((count, reason)) = least {
        let count = count.max(1) as u32;
        needs.settings.lights = needs.decide("number of VSGLs", requested, count, reason);
    }
    if needs.settings.density == Density::Bidirectional {
        let requested = needs.settings.camera_lights;
        let pixels: u64 = needs.settings.size.into_iter().map(u64::from).product();
        let count = u64::from(requested).min(pixels.max(1)) as u32;
        let reason = if count < requested { "no more than pixels" } else { "as requested" };
        needs.settings.camera_lights =
            needs.decide("number of the camera's VSGLs", requested, count, reason.to_owned());
    }
}

fn light_maps(needs: &mut Needs, description: &Description, limits: &wgpu::Limits) {
    if needs.settings.visibility == Visibility::None {
        return;
    }
    let most = u64::from(limits.max_texture_dimension_2d);
    let binding = limits.max_storage_buffer_binding_size.min(limits.max_buffer_size);
    let least = bounds(description, parameter::TILE)[0];
    let imperfect = needs.settings.visibility == Visibility::Imperfect;
    let within = |of: &Resource| match &of.kind {
        Kind::Texture { size, .. } => size.iter().all(|side| *side <= most),
        Kind::Buffer { .. } => of.bytes <= binding,
        Kind::Sampler { .. } => true,
    };
    // What the host supplies has a size of its own.
    let own = |of: &&Resource| of.part == part::VISIBILITY && !of.external;
    let fits = |maps: &Settings| {
        frame(description, maps).is_none_or(|frame| frame.resources.iter().filter(own).all(within))
    };
    let Settings { tile, lights: count, .. } = needs.settings;
    let mut maps = needs.settings.clone();
    while !fits(&maps) && u64::from(maps.tile) > least {
        maps.tile /= 2;
    }
    while !fits(&maps) && maps.lights > 1 {
        maps.lights /= 2;
    }
    let reason = |changed: bool| {
        if changed {
            format!(
                "so that the atlas of all maps is at most {most} wide and high, and its buffer at most {binding} bytes"
            )
        } else {
            "as requested; the atlas of all maps is within the device's limits".to_owned()
        }
    };
    needs.settings.tile =
        needs.decide("tile of a light's map", tile, maps.tile, reason(tile != maps.tile));
    if count != maps.lights {
        needs.settings.lights =
            needs.decide("number of VSGLs with maps", count, maps.lights, reason(true));
    }
    if imperfect {
        let requested = needs.settings.shadow_points;
        let single = frame(description, &Settings { shadow_points: 1, ..maps });
        let one = single.as_ref().and_then(|frame| find(frame, resource::POINTS));
        let one = one.map_or(1, |points| points.bytes.max(1));
        let points = u64::from(requested).min((binding / one).max(1)) as u32;
        let reason = if points < requested {
            "all sets of points are in one buffer"
        } else {
            "as requested"
        };
        needs.settings.shadow_points =
            needs.decide("points per light map", requested, points, reason.to_owned());
    }
}

fn roughness(needs: &mut Needs, scene: &Scene) {
    let traits = scene.traits();
    let used = scene.meshes.iter().filter_map(|mesh| traits.get(mesh.material));
    let specular: Vec<_> = used.filter(|traits| traits.specular).collect();
    if specular.is_empty() {
        return needs.note("roughness", "not used", "no surface is specular");
    }
    let least = specular.iter().map(|traits| traits.alpha[0]).fold(f32::MAX, f32::min);
    let most = specular.iter().map(|traits| traits.alpha[1]).fold(0.0, f32::max);
    needs.note(
        "roughness",
        format!("alpha {least:.3} to {most:.3}"),
        "every form is finite from 0.01, the least that is drawn, to 1 (docs/numerics.md): none is left out as unstable",
    );
}

#[cfg(test)]
mod tests {
    use super::*;

    fn limits() -> wgpu::Limits {
        wgpu::Limits::default()
    }

    fn needs(scene: &Scene, light: usize, requested: &Settings, limits: &wgpu::Limits) -> Needs {
        let package = sglow_runtime::package::Package::embedded();
        super::needs(package.description().unwrap(), scene, light, requested, limits)
    }

    fn value(needs: &Needs, name: &str) -> (String, bool) {
        let found = needs.decisions.iter().find(|decision| decision.name == name).unwrap();
        assert!(!found.reason.is_empty());
        (found.value.clone(), found.changed)
    }

    #[test]
    fn what_fits_stays_as_requested() {
        let scene = Scene::builtin("cornell").unwrap();
        let requested = Settings { visibility: Visibility::Imperfect, ..Settings::default() };
        let needs = needs(&scene, 0, &requested, &limits());
        assert_eq!(needs.settings, requested);
        assert!(needs.decisions.iter().all(|decision| !decision.changed), "{:?}", needs.decisions);
        assert_eq!(value(&needs, "reflective shadow map").0, "planar");
        assert_eq!(value(&needs, "environment").0, "none");
    }

    #[test]
    fn what_is_too_much_is_brought_within_the_limits() {
        let scene = Scene::builtin("cornell").unwrap();
        let decided = |requested: Settings| needs(&scene, 0, &requested, &limits());
        let few = decided(Settings { map: 8, ..Settings::default() });
        assert_eq!(
            (few.settings.lights, value(&few, "number of VSGLs")),
            (64, ("64".to_owned(), true))
        );
        let large = decided(Settings { map: 20000, ..Settings::default() });
        assert_eq!(large.settings.map, 8192);
        // 256 x 256 tiles: of 32 texels they are 8192 wide.
        let many =
            Settings { lights: 65536, visibility: Visibility::ShadowMap, ..Settings::default() };
        assert_eq!(decided(many.clone()).settings.tile, 32);
        // 4 * 65536 * 16^2 bytes are 64 MiB.
        let splats = Settings { visibility: Visibility::Imperfect, ..many.clone() };
        assert_eq!(decided(splats).settings.tile, 16);
        let small = wgpu::Limits { max_texture_dimension_2d: 1024, ..limits() };
        let fewer = needs(&scene, 0, &many, &small).settings;
        assert_eq!((fewer.tile, fewer.lights), (8, 16384));
        let space = Space::Image;
        let small = wgpu::Limits { max_storage_buffer_binding_size: 40_000, ..limits() };
        let sorted = needs(&scene, 0, &Settings { space, ..Settings::default() }, &small).settings;
        assert_eq!(sorted.map, 100);
        // Two blocks of 48 bytes for each texel: 416 texels, of which a square of 16 by 16 fits.
        let (space, lobes) = (Space::Tree, sglow_shaders::Lobes::Diffuse);
        let cut = Settings { space, lobes, ..Settings::default() };
        assert_eq!(needs(&scene, 0, &cut, &small).settings.map, 16);
        for settings in [many, Settings { lights: 0, map: 0, ..Settings::default() }] {
            let found = decided(settings).settings;
            assert!(found.lights > 0 && found.map > 0);
        }
    }

    #[test]
    fn a_point_light_has_a_deep_map_of_tiles() {
        let mut scene = Scene::builtin("cornell").unwrap();
        scene.lights[0].kind = LightKind::Point;
        let requested = Settings { map: 18, ..Settings::default() };
        let needs = needs(&scene, 0, &requested, &limits());
        assert_eq!(needs.settings.light, Light::Point);
        assert_eq!((needs.settings.map, needs.settings.lights), (16, 192));
        assert_eq!(value(&needs, "reflective shadow map").0, "deep");
    }

    #[test]
    fn several_lights_share_a_map_of_tiles() {
        let mut scene = Scene::builtin("cornell").unwrap();
        let own = scene.lights[0].clone();
        let kinds = [own.kind, LightKind::Point, LightKind::Directional];
        scene.lights = kinds.map(|kind| sglow_scene::Light { kind, ..own.clone() }).into();
        let requested = Settings { map: 18, light: Light::Several, ..Settings::default() };
        let several = needs(&scene, 0, &requested, &limits());
        let Settings { light, light_faces, map, lights, .. } = several.settings;
        assert_eq!((light, light_faces, map, lights), (Light::Several, 8, 16, 256));
        assert_eq!(value(&several, "reflective shadow map").0, "shared");
        assert_eq!(several.facts.holds("several_lights"), Some(true));
        // One of them alone.
        let one = needs(&scene, 2, &Settings { map: 18, ..Settings::default() }, &limits());
        assert_eq!((one.settings.light, one.settings.map), (Light::Directional, 18));
        assert_eq!(one.facts.holds("several_lights"), Some(false));
    }

    #[test]
    fn only_what_was_taken_not_to_hold_and_does_is_missing() {
        let facts = Scene::builtin("cornell-glossy").unwrap().facts();
        let assume = |fact: &str, holds| Assumption {
            rule: format!("rule-of-{fact}"),
            fact: fact.to_owned(),
            holds,
        };
        let assumed = [
            assume("specular", false),
            assume("cutout", false),
            assume("occluders", true),
            assume("textured", true),
        ];
        let missing = missing(&facts, &assumed);
        assert_eq!(missing.len(), 1);
        let text = missing[0].to_string();
        for part in ["`specular`", "rule-of-specular", "material `"] {
            assert!(text.contains(part), "{text}");
        }
    }
}
