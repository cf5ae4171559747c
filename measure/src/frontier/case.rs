//! A scene that is to be measured, and what is found of it.

use sglow_renderer::request::RequestError;
use sglow_renderer::request::derivation::{Derivation, Request};
use sglow_runtime::settings::Settings;
use sglow_scene::Scene;
use sglow_shader_gen::library::Library;
use thiserror::Error;

use super::configuration;
use super::subject::FrontierError;
use crate::cache::CacheError;

/// Errors of what is to be measured.
#[derive(Debug, Error)]
pub enum SelectError {
    /// Values that there are not.
    #[error("{}", .0.join("\n"))]
    Values(Vec<String>),
    /// No configuration remains.
    #[error("{scene}: nothing remains to be measured{}", help.iter().map(|line| format!("\nhelp: {line}")).collect::<String>())]
    Nothing {
        /// The scene.
        scene: String,
        /// The values that exclude the last ones.
        help: Vec<String>,
    },
    /// The default with the requested values is not legal.
    #[error(
        "{scene}: screening has no configuration to start from\nhelp: --all measures every legal one that has these values"
    )]
    Start {
        /// The scene.
        scene: String,
    },
    /// A scene or a setting is not possible.
    #[error(transparent)]
    Request(#[from] RequestError),
    /// A configuration cannot be measured.
    #[error(transparent)]
    Frontier(#[from] FrontierError),
    /// A result cannot be kept.
    #[error(transparent)]
    Cache(#[from] CacheError),
}

/// A scene that is to be measured.
#[derive(Debug)]
pub struct Case {
    /// The scene, with one light.
    pub scene: Scene,
    /// What it needs.
    pub derivation: Derivation,
    /// The library that it was derived by.
    pub library: Library,
}

impl Case {
    /// Derives what a scene with one light needs.
    ///
    /// # Errors
    ///
    /// When what is requested is not possible.
    pub fn new(scene: Scene, library: Library, request: &Request) -> Result<Self, RequestError> {
        let derivation = Derivation::new(&library, &scene, &[], request)?;
        Ok(Self { scene, derivation, library })
    }

    /// What `--set` takes to give a configuration: the values in which it differs from the default, and those that
    /// defaults would have set which do not apply beside these.
    ///
    /// # Errors
    ///
    /// When the scene has no such configuration.
    pub fn set(&self, settings: &Settings) -> Result<Vec<String>, RequestError> {
        let mut set = Vec::new();
        loop {
            let request = &self.derivation.request;
            let found = Derivation::new(&self.library, &self.scene, &set, request)?.settings;
            let name = configuration::name(settings, &found);
            let missing = name.split(',').filter(|part| *part != "default");
            let missing: Vec<String> = missing.map(str::to_owned).collect();
            if missing.iter().all(|part| set.contains(part)) {
                return Ok(set);
            }
            set.extend(missing);
        }
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use std::path::{Path, PathBuf};

    use sglow_renderer::request::shot::load;

    use super::*;
    use crate::frontier::screen;

    pub(crate) fn case(scene: &str, over: &[PathBuf]) -> Case {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shaders");
        let library = Library::load_with(&folder, over).unwrap();
        let scene = load(scene, None, &sglow_scene::Options::default()).unwrap().0;
        Case::new(scene, library, &Request::of([16, 9])).unwrap()
    }

    #[test]
    fn what_set_takes_gives_the_configuration_back() {
        let case = case("cornell", &[]);
        let base = &case.derivation.settings;
        assert_eq!((base.lights, base.near_scale), (screen::ROOTS, screen::NEAR_SCALE));
        for (axis, value) in
            [("lights", "64"), ("cut", "none"), ("space", "none"), ("lobes", "both")]
        {
            let Some(settings) = screen::with(base, axis, value) else { continue };
            let set = case.set(&settings).unwrap();
            let of = |set: &[String]| {
                let request = &case.derivation.request;
                let found = Derivation::new(&case.library, &case.scene, set, request).unwrap();
                configuration::name(&settings, &found.settings)
            };
            assert_eq!(of(&set), "default", "{set:?}");
            // Its name alone gives another one where a default does not apply beside it.
            let name = configuration::name(&settings, base);
            let parts: Vec<String> = name.split(',').map(str::to_owned).collect();
            assert_eq!(of(&parts) == "default", set == parts, "{name}");
        }
        let few = screen::with(base, "lights", "64").unwrap();
        assert!(case.set(&few).unwrap().contains(&"cut=tile".to_owned()));
        assert!(case.set(base).unwrap().is_empty());
    }
}
