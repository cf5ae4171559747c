//! A scene with settings that suit it: what `render` and `report` start from.

use clap::{Args, value_parser};
use sglow_runtime::device::Gpu;
use sglow_runtime::needs::Decision;
use sglow_runtime::scene::{Light, LightKind, Scene};
use sglow_runtime::settings::Settings;

use crate::derivation::Derivation;
use crate::failure::{Failure, Result};
use crate::selection::library;

/// Numbers that `render` and `report` share.
#[derive(Clone, Debug, Args)]
pub(crate) struct Numbers {
    /// Number of virtual lights, 1 to 65536
    #[arg(long, value_name = "N", default_value_t = 1024, allow_negative_numbers = true,
        value_parser = value_parser!(u32).range(1..=65536))]
    pub(crate) lights: u32,
    /// Width and height of the reflective shadow map, best a power of two [default: 256, or the paper's 512 to reproduce]
    #[arg(long, value_name = "TEXELS", allow_negative_numbers = true, value_parser = value_parser!(u32).range(1..))]
    pub(crate) rsm: Option<u32>,
    /// Bisection steps of Algorithm 1, 1 to 24
    #[arg(long, value_name = "STEPS", default_value_t = 12, allow_negative_numbers = true,
        value_parser = value_parser!(u32).range(1..=24))]
    pub(crate) iterations: u32,
    /// K, the size of kernels relative to their share of the density
    #[arg(long, value_name = "K", default_value_t = 1.0, allow_negative_numbers = true,
        value_parser = factor)]
    pub(crate) size_factor: f32,
    /// The scene's light that is used, counted from 0 [default: the one with the most power]
    #[arg(long, value_name = "NUMBER")]
    pub(crate) light: Option<usize>,
    /// The GPU whose name contains this [default: the most capable one]
    #[arg(long, visible_alias = "device", value_name = "NAME")]
    pub(crate) adapter: Option<String>,
}

impl Default for Numbers {
    fn default() -> Self {
        Self {
            lights: 1024,
            rsm: None,
            iterations: 12,
            size_factor: 1.0,
            light: None,
            adapter: None,
        }
    }
}

impl Numbers {
    /// The default settings with these numbers.
    pub(crate) fn settings(&self, size: [u32; 2]) -> Settings {
        Settings {
            size,
            rsm_size: self.rsm.unwrap_or(256),
            count: self.lights,
            size_factor: self.size_factor,
            iterations: self.iterations,
            ..Settings::default()
        }
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
        let derivation = Derivation::new(&library()?, &scene, set, &numbers.settings(size))?;
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
    use sglow_shaders::{Ndf, Specular};

    use super::*;

    fn numbers() -> Numbers {
        Numbers {
            lights: 16,
            rsm: Some(32),
            iterations: 12,
            size_factor: 1.0,
            light: None,
            adapter: None,
        }
    }

    #[test]
    fn numbers_that_nobody_gives_are_those_of_the_command_line() {
        #[derive(Parser)]
        struct Line {
            #[command(flatten)]
            numbers: Numbers,
        }
        let line = Line::parse_from(["render"]).numbers.settings([8, 8]);
        assert_eq!(line, Numbers::default().settings([8, 8]));
        assert_ne!(line, numbers().settings([8, 8]));
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
        for part in ["no axis 'colour'", "previous, modified", "not AXIS=VALUE"] {
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
