//! A scene with settings that suit it: what a command that renders starts from.

use sglow_runtime::settings::Settings;
use sglow_scene::{Options, Scene};
use sglow_shader_gen::library::Library;

use crate::light;
use crate::needs::Decision;
use crate::request::RequestError;
use crate::request::derivation::{Derivation, Request};

/// A scene and the settings it is rendered with.
#[derive(Debug)]
pub struct Shot {
    /// The scene, with the lights that are used.
    pub scene: Scene,
    /// The settings.
    pub settings: Settings,
    /// What was decided other than requested, a line each.
    pub notes: Vec<String>,
}

impl Shot {
    /// Settles every axis of a scene with all its lights: by `set`, else by what the scene needs, else by the default.
    ///
    /// # Errors
    ///
    /// When an axis, a value or a number is not possible.
    pub fn new(
        library: &Library,
        scene: Scene,
        set: &[String],
        request: &Request,
    ) -> Result<Self, RequestError> {
        let derivation = Derivation::new(library, &scene, set, request)?;
        let changed = derivation.needs.decisions.iter().filter(|decision| decision.changed);
        let note = |Decision { name, value, reason, .. }: &Decision| {
            format!("{}: {name}: {value} ({reason})", scene.name)
        };
        let notes = changed.map(note).collect();
        let settings = derivation.settings;
        Ok(Self { scene, settings, notes })
    }
}

/// Loads a scene with all its lights, or with one by its number, and what a user should know of it, a line each.
///
/// # Errors
///
/// When the scene cannot be read, has no such light, or more lights than one map can have.
pub fn load(
    name: &str,
    light: Option<usize>,
    options: &Options,
) -> Result<(Scene, Vec<String>), RequestError> {
    let mut scene = Scene::load_with(name, options)?;
    let used = keep_lights(&mut scene, light)?;
    let notes = scene.notes.iter().map(ToString::to_string).chain(used);
    let notes = notes.map(|note| format!("{}: {note}", scene.name)).collect();
    Ok((scene, notes))
}

/// Keeps the light `wanted`, or all of them, and says which if there are others.
fn keep_lights(scene: &mut Scene, wanted: Option<usize>) -> Result<Option<String>, RequestError> {
    let count = scene.lights.len();
    if count == 0 || wanted.is_some_and(|wanted| wanted >= count) {
        return Err(RequestError::NoLight { wanted: wanted.unwrap_or(0), count });
    }
    let Some(chosen) = wanted else {
        if count > 1 {
            light::view_of_all(&scene.lights, &scene.bounds(), 1)?;
        }
        return Ok((count > 1).then(|| format!("lit by {count} lights; --light NUMBER takes one")));
    };
    let note = (count > 1).then(|| {
        format!("{count} lights; only light {chosen} ({}) is used", scene.lights[chosen].name)
    });
    scene.lights = vec![scene.lights.swap_remove(chosen)];
    Ok(note)
}

#[cfg(test)]
mod tests {
    use sglow_shaders::{Cut, Density, Emitter, Ndf, Space, Specular, Visibility};

    use super::*;
    use crate::request::library;

    fn request(preset: Option<&str>, numbers: &[&str]) -> Request {
        let numbers = numbers.iter().map(|&word| word.to_owned()).collect();
        Request { size: [8, 8], preset: preset.map(str::to_owned), numbers }
    }

    fn of(scene: &str, set: &[&str], request: &Request) -> Result<Settings, RequestError> {
        let set: Vec<_> = set.iter().map(|&word| word.to_owned()).collect();
        let scene = load(scene, None, &Options::default())?.0;
        Shot::new(&library(), scene, &set, request).map(|shot| shot.settings)
    }

    fn few() -> Request {
        request(None, &["lights=16", "map=32"])
    }

    #[test]
    fn a_preset_is_changed_by_numbers_and_by_set_and_narrowed_by_needs() {
        let printed = request(Some("tokuyoshi2016"), &[]);
        let glossy = of("cornell-glossy", &[], &printed).unwrap();
        assert_eq!(glossy.emitter, Emitter::Lobe);
        assert_eq!(
            (glossy.size_factor, glossy.lights, glossy.emission_sharpness),
            (1.0, 1024, 2.0)
        );
        // A scene without specular surfaces needs no specular lobe, whatever is printed.
        assert_eq!(of("cornell", &[], &printed).unwrap().specular, Specular::None);
        let fewer = request(Some("tokuyoshi2016"), &["lights=64"]);
        let changed = of("cornell", &["emitter=cosine", "size_factor=0.5"], &fewer).unwrap();
        assert_eq!((changed.lights, changed.size_factor), (64, 0.5));
        assert_eq!((changed.emitter, changed.density), (Emitter::Cosine, Density::Bidirectional));
        // Nothing given: the defaults of the scene's class.
        let usual = of("cornell", &[], &request(None, &[])).unwrap();
        assert_eq!(usual.visibility, Visibility::ShadowMap);
        assert_eq!(
            (usual.space, usual.cut, usual.emitter),
            (Space::Tree, Cut::Tile, Emitter::Disc)
        );
        // A number of lights is one of flat lights.
        let flat = of("cornell", &[], &request(None, &["lights=1024"])).unwrap();
        assert_eq!((flat.space, flat.cut, flat.lights), (Space::World, Cut::None, 1024));
        // Cuts and clusters give way to what is said of kernels, by an axis or by a number.
        let kernels = of("cornell", &["kernel=previous"], &request(None, &[])).unwrap();
        assert_eq!((kernels.space, kernels.emitter), (Space::None, Emitter::Cosine));
        let wide = request(None, &["size_factor=2"]);
        let wide = of("cornell", &[], &wide).unwrap();
        assert_eq!((wide.space, wide.size_factor), (Space::None, 2.0));
        let both = of("cornell", &["emitter=cosine"], &request(None, &[])).unwrap();
        assert_eq!((both.space, both.cut, both.emitter), (Space::Tree, Cut::Tile, Emitter::Cosine));
        let unknown = request(Some("best"), &[]);
        let text = of("cornell", &[], &unknown).unwrap_err().to_string();
        assert!(text.contains("best") && text.contains("tokuyoshi2016"), "{text}");
    }

    #[test]
    fn all_lights_are_kept_unless_one_is_wanted() {
        let mut scene = Scene::builtin("cornell").unwrap();
        let lights = |count: usize, scene: &Scene| vec![scene.lights[0].clone(); count];
        assert_eq!(keep_lights(&mut scene, None).unwrap(), None);
        let mut two = Scene { lights: lights(2, &scene), ..scene.clone() };
        let note = keep_lights(&mut two, None).unwrap().unwrap();
        assert!(two.lights.len() == 2 && note.contains("lit by 2 lights"), "{note}");
        let note = keep_lights(&mut two, Some(1)).unwrap().unwrap();
        assert!(two.lights.len() == 1 && note.contains("only light 1"), "{note}");
        let mut many = Scene { lights: lights(65, &scene), ..scene };
        let text = keep_lights(&mut many.clone(), None).unwrap_err().to_string();
        assert!(text.contains("65 lights have 65 faces") && text.contains("at most 64"), "{text}");
        // One of them is one light.
        keep_lights(&mut many, Some(64)).unwrap();
        let text = keep_lights(&mut many, Some(1)).unwrap_err().to_string();
        assert!(text.contains("no light 1; it has 1"), "{text}");
    }

    #[test]
    fn every_preset_and_default_of_the_library_can_be_set_and_every_parameter_is_declared() {
        let library = library();
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
    fn settings_remember_what_was_taken_for_granted() {
        let set = |set: &[&str]| {
            let assumed = of("cornell", set, &few()).unwrap().assumed;
            assumed.into_iter().map(|one| one.fact).collect::<Vec<_>>()
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
    fn a_scene_decides_what_is_not_requested() {
        let diffuse = of("cornell", &[], &few()).unwrap();
        assert_eq!((diffuse.specular, diffuse.ndf), (Specular::None, Ndf::None));
        let requested = of("cornell", &["specular=sg"], &few()).unwrap();
        assert_eq!((requested.specular, requested.ndf), (Specular::Sg, Ndf::Ggx));
        let glossy = of("cornell-glossy", &[], &few()).unwrap();
        assert_ne!(glossy.specular, Specular::None);
    }

    #[test]
    fn what_is_wrong_is_reported_all_at_once() {
        let set = ["colour=red", "kernel=cubic", "kernel"];
        let text = of("cornell", &set, &few()).unwrap_err().to_string();
        for part in ["unknown axis 'colour'", "previous, modified", "not AXIS=VALUE"] {
            assert!(text.contains(part), "{text}");
        }
        let twice = |set: &[&str], numbers: &[&str]| {
            of("cornell", set, &request(None, numbers)).map_err(|error| error.to_string())
        };
        let text = twice(&["kernel=previous", "kernel=modified"], &[]).unwrap_err();
        assert_eq!(text, "`kernel` is given twice: previous and modified");
        let text = twice(&["lights=16"], &["lights=32", "map=32"]).unwrap_err();
        assert_eq!(text, "`lights` is given twice: 32 and 16");
        assert!(twice(&["kernel=previous", "kernel=previous"], &["lights=16", "map=32"]).is_ok());
        let text = load("cornell", Some(7), &Options::default()).unwrap_err().to_string();
        assert!(text.contains("no light 7"), "{text}");
    }
}
