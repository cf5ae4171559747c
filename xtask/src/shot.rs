//! A scene with settings that suit it: what `render` and `report` start from.

use clap::{Args, value_parser};
use sglow_renderer::device::Gpu;
use sglow_renderer::needs::Decision;
use sglow_report::failure::{Failure, Result};
use sglow_runtime::settings::Settings;
use sglow_scene::{Light, LightKind, Scene};

use crate::derivation::{Derivation, Request};
use crate::selection::Over;

/// Numbers that `render` and `report` share, and the named configuration that they change.
#[derive(Clone, Debug, Default, Args)]
pub(crate) struct Numbers {
    #[command(flatten)]
    pub(crate) over: Over,
    /// A named configuration of the library; what else is given changes it [default: the defaults for the scene]
    #[arg(long, value_name = "NAME")]
    pub(crate) preset: Option<String>,
    /// Number of virtual lights, 1 to 65536 [default: the preset's or the scene's]
    #[arg(long, value_name = "N", allow_negative_numbers = true,
        value_parser = value_parser!(u32).range(1..=65536))]
    pub(crate) lights: Option<u32>,
    /// Width and height of the reflective shadow map, best a power of two [default: 256, or the paper's 512 to reproduce]
    #[arg(long, value_name = "TEXELS", allow_negative_numbers = true, value_parser = value_parser!(u32).range(1..))]
    pub(crate) rsm: Option<u32>,
    /// Bisection steps of Algorithm 1, 1 to 24 [default: the preset's or the scene's]
    #[arg(long, value_name = "STEPS", allow_negative_numbers = true,
        value_parser = value_parser!(u32).range(1..=24))]
    pub(crate) iterations: Option<u32>,
    /// K, the size of kernels relative to their share of the density [default: the preset's or the scene's]
    #[arg(long, value_name = "K", allow_negative_numbers = true, value_parser = factor)]
    pub(crate) size_factor: Option<f32>,
    /// The scene's light that is used, counted from 0 [default: the one with the most power]
    #[arg(long, value_name = "NUMBER")]
    pub(crate) light: Option<usize>,
    /// The GPU whose name contains this [default: the most capable one]
    #[arg(long, visible_alias = "device", value_name = "NAME")]
    pub(crate) adapter: Option<String>,
}

impl Numbers {
    /// What is requested with these numbers.
    pub(crate) fn request(&self, size: [u32; 2]) -> Request {
        let mut numbers = Vec::new();
        let mut given = |name: &str, value: Option<String>| {
            numbers.extend(value.map(|value| format!("{name}={value}")));
        };
        given("lights", self.lights.map(|number| number.to_string()));
        given("map", self.rsm.map(|number| number.to_string()));
        given("iterations", self.iterations.map(|number| number.to_string()));
        given("size_factor", self.size_factor.map(|number| number.to_string()));
        Request { size, preset: self.preset.clone(), numbers }
    }

    /// Bisection steps, where no scene settles them.
    pub(crate) fn steps(&self) -> u32 {
        self.iterations.unwrap_or_else(|| Settings::default().iterations)
    }
}

/// A scene and the settings it is rendered with.
pub(crate) struct Shot {
    /// The scene; its one light is number 0.
    pub(crate) scene: Scene,
    /// The settings.
    pub(crate) settings: Settings,
}

impl Shot {
    /// Loads a scene, and settles every axis: by `set`, else by what the scene needs, else by the default.
    ///
    /// # Errors
    ///
    /// When the scene cannot be read, or an axis, a value or a number is not possible.
    pub(crate) fn new(
        name: &str,
        set: &[String],
        size: [u32; 2],
        numbers: &Numbers,
    ) -> Result<Self> {
        let scene = load(name, numbers.light)?;
        let derivation =
            Derivation::new(&numbers.over.library()?, &scene, set, &numbers.request(size))?;
        for decision in derivation.needs.decisions.iter().filter(|decision| decision.changed) {
            let Decision { name, value, reason, .. } = decision;
            eprintln!("{}: {name}: {value} ({reason})", scene.name);
        }
        let settings = derivation.settings;
        Ok(Self { scene, settings })
    }
}

/// Loads a scene with the light that is used, and tells what there is to tell of it.
///
/// # Errors
///
/// When the scene cannot be read or has no such light.
pub(crate) fn load(name: &str, light: Option<usize>) -> Result<Scene> {
    let mut scene = Scene::load(name)?;
    for note in &scene.notes {
        eprintln!("{}: {note}", scene.name);
    }
    keep_one_light(&mut scene, light)?;
    Ok(scene)
}

/// Opens the GPU that is asked for.
pub(crate) fn gpu(numbers: &Numbers) -> Result<Gpu> {
    open(numbers.adapter.as_deref())
}

/// Opens the GPU whose name contains `adapter`, or the most capable one.
pub(crate) fn open(adapter: Option<&str>) -> Result<Gpu> {
    let gpu = Gpu::open(adapter)
        .map_err(|error| Failure::from(error).help("`cargo xtask doctor` shows what there is"))?;
    if gpu.adapter.software {
        eprintln!(
            "{} is a program on the CPU: its times compare variants, they promise nothing about GPUs",
            gpu.adapter.name
        );
    }
    Ok(gpu)
}

/// Roughly what a light emits, to choose the strongest: a directional light's irradiance over the scene, else the
/// intensity over the light's solid angle.
fn power(light: &Light, radius: f32) -> f32 {
    let [r, g, b] = light.intensity;
    let extent = match light.kind {
        LightKind::Directional => radius * radius,
        LightKind::Point => 4.0,
        LightKind::Spot { outer, .. } => 2.0 * (1.0 - outer.cos()),
    };
    (r + g + b) * extent
}

fn keep_one_light(scene: &mut Scene, wanted: Option<usize>) -> Result {
    let radius = scene.bounds().radius();
    let count = scene.lights.len();
    let strongest = (0..count).max_by(|&a, &b| {
        power(&scene.lights[a], radius).total_cmp(&power(&scene.lights[b], radius))
    });
    let Some(chosen) = wanted.or(strongest).filter(|&chosen| chosen < count) else {
        return Err(Failure::new(format!(
            "the scene has no light {}; it has {count}, counted from 0",
            wanted.unwrap_or(0)
        )));
    };
    if count > 1 {
        eprintln!(
            "{}: {count} lights; only light {chosen} ({}) is used",
            scene.name, scene.lights[chosen].name
        );
    }
    scene.lights = vec![scene.lights.swap_remove(chosen)];
    Ok(())
}

/// `WxH` in pixels.
pub(crate) fn size(text: &str) -> Result<[u32; 2], String> {
    let wrong = || format!("'{text}' is not a size such as 640x360");
    let (width, height) = text.split_once('x').ok_or_else(wrong)?;
    let size = [width, height].map(str::parse::<u32>);
    match size {
        [Ok(0), Ok(_)] | [Ok(_), Ok(0)] => Err(format!("'{text}' has no pixel; give at least 1x1")),
        [Ok(width), Ok(height)] => Ok([width, height]),
        _ => Err(wrong()),
    }
}

/// A number above 0.
fn factor(text: &str) -> Result<f32, String> {
    let number = text.parse::<f32>().ok().filter(|number| *number > 0.0 && number.is_finite());
    number.ok_or_else(|| format!("'{text}' is not a number above 0"))
}

#[cfg(test)]
mod tests {
    use clap::Parser;
    use sglow_shaders::{Density, Emitter, Ndf, Space, Specular, Visibility};

    use super::*;

    fn numbers() -> Numbers {
        Numbers { lights: Some(16), rsm: Some(32), ..Numbers::default() }
    }

    #[test]
    fn a_preset_is_changed_by_numbers_and_by_set_and_narrowed_by_needs() {
        let of = |scene: &str, set: &[&str], numbers: &Numbers| {
            let set: Vec<_> = set.iter().map(|&word| word.to_owned()).collect();
            Shot::new(scene, &set, [8, 8], numbers).map(|shot| shot.settings)
        };
        let printed = Numbers { preset: Some("tokuyoshi2016".to_owned()), ..Numbers::default() };
        let glossy = of("cornell-glossy", &[], &printed).unwrap();
        assert_eq!(glossy.emitter, Emitter::Lobe);
        assert_eq!(
            (glossy.size_factor, glossy.lights, glossy.emission_sharpness),
            (1.0, 1024, 2.0)
        );
        // A scene without specular surfaces needs no specular lobe, whatever is printed.
        assert_eq!(of("cornell", &[], &printed).unwrap().specular, Specular::None);
        let fewer = Numbers { lights: Some(64), ..printed.clone() };
        let changed = of("cornell", &["emitter=cosine", "size_factor=0.5"], &fewer).unwrap();
        assert_eq!((changed.lights, changed.size_factor), (64, 0.5));
        assert_eq!((changed.emitter, changed.density), (Emitter::Cosine, Density::Bidirectional));
        // Nothing given: the defaults of the scene's class.
        let usual = of("cornell", &[], &Numbers::default()).unwrap();
        assert_eq!(usual.visibility, Visibility::ShadowMap);
        assert_eq!(usual.lights, Settings::default().lights);
        // Clusters give way to what is said of kernels, by an axis or by a number.
        assert_eq!((usual.space, usual.emitter), (Space::World, Emitter::Disc));
        let kernels = of("cornell", &["kernel=previous"], &Numbers::default()).unwrap();
        assert_eq!((kernels.space, kernels.emitter), (Space::None, Emitter::Cosine));
        let wide = Numbers { size_factor: Some(2.0), ..Numbers::default() };
        let wide = of("cornell", &[], &wide).unwrap();
        assert_eq!((wide.space, wide.size_factor), (Space::None, 2.0));
        let both = of("cornell", &["emitter=cosine"], &Numbers::default()).unwrap();
        assert_eq!((both.space, both.emitter), (Space::World, Emitter::Cosine));
        let unknown = Numbers { preset: Some("best".to_owned()), ..Numbers::default() };
        let text = of("cornell", &[], &unknown).unwrap_err().to_string();
        assert!(text.contains("best") && text.contains("tokuyoshi2016"), "{text}");
    }

    #[test]
    fn every_preset_and_default_of_the_library_can_be_set_and_every_parameter_is_declared() {
        let library = crate::selection::library().unwrap();
        let sets = library.preset.iter().map(|one| (&one.name, &one.set));
        let sets = sets.chain(library.class_default.iter().map(|one| (&one.name, &one.set)));
        for (name, set) in sets {
            for (axis, value) in set {
                let result = Settings::default().set(axis, &value.to_string());
                assert!(result.is_ok(), "{name}: {axis}: {result:?}");
            }
        }
    }

    #[test]
    fn numbers_that_nothing_can_be_made_of_are_refused() {
        #[derive(Debug, Parser)]
        struct Line {
            #[command(flatten)]
            _numbers: Numbers,
        }
        let line = |option: &str, value: &str| Line::try_parse_from(["render", option, value]);
        for (option, good, wrong) in [
            ("--lights", ["1", "65536"], ["0", "65537", "-1"]),
            ("--rsm", ["1", "4096"], ["0", "-1", "x"]),
            ("--iterations", ["1", "24"], ["0", "25", "-1"]),
            ("--size-factor", ["0.5", "16"], ["0", "-1", "inf"]),
        ] {
            assert!(good.iter().all(|value| line(option, value).is_ok()), "{option}");
            for value in wrong {
                let text = line(option, value).unwrap_err().to_string();
                assert!(text.contains(option) && text.contains(value), "{text}");
            }
        }
    }

    #[test]
    fn settings_remember_what_was_taken_for_granted() {
        let set = |set: &[&str]| {
            let set: Vec<_> = set.iter().map(|&word| word.to_owned()).collect();
            let shot = Shot::new("cornell", &set, [8, 8], &numbers()).unwrap();
            shot.settings.assumed.into_iter().map(|one| one.fact).collect::<Vec<_>>()
        };
        let assumed = set(&[]);
        for fact in ["specular", "directional_light", "point_light"] {
            assert!(assumed.iter().any(|known| known == fact), "{fact}: {assumed:?}");
        }
        // Every axis of the rule is decided by hand: nothing is taken for granted.
        let by_hand = set(&["specular=none", "lobes=diffuse", "ndf=none", "light=spot"]);
        assert_eq!(by_hand, Vec::<String>::new());
    }

    #[test]
    fn a_scene_decides_what_nobody_asks_for() {
        let diffuse = Shot::new("cornell", &[], [8, 8], &numbers()).unwrap().settings;
        assert_eq!((diffuse.specular, diffuse.ndf), (Specular::None, Ndf::None));
        let set = ["specular=sg".to_owned()];
        let asked = Shot::new("cornell", &set, [8, 8], &numbers()).unwrap().settings;
        assert_eq!((asked.specular, asked.ndf), (Specular::Sg, Ndf::Ggx));
        let glossy = Shot::new("cornell-glossy", &[], [8, 8], &numbers()).unwrap().settings;
        assert_ne!(glossy.specular, Specular::None);
    }

    #[test]
    fn what_is_wrong_is_told_all_at_once() {
        let set = ["colour=red", "kernel=cubic", "kernel"].map(str::to_owned);
        let text = Shot::new("cornell", &set, [8, 8], &numbers()).err().unwrap().to_string();
        for part in ["unknown axis 'colour'", "previous, modified", "not AXIS=VALUE"] {
            assert!(text.contains(part), "{text}");
        }
        let light = Numbers { light: Some(7), ..numbers() };
        let text = Shot::new("cornell", &[], [8, 8], &light).err().unwrap().to_string();
        assert!(text.contains("no light 7"), "{text}");
    }

    #[test]
    fn sizes_are_read() {
        assert_eq!(size("640x360"), Ok([640, 360]));
        for wrong in ["640", "x", "640x", "-1x2", "axb"] {
            assert!(size(wrong).unwrap_err().contains(wrong));
        }
        for empty in ["0x0", "0x4", "4x0"] {
            assert!(size(empty).unwrap_err().contains("no pixel"), "{empty}");
        }
    }
}
