//! A scene that is to be measured, and what is found of it.

use sglow_renderer::request::RequestError;
use sglow_renderer::request::derivation::{Derivation, Request};
use sglow_runtime::settings::Settings;
use sglow_scene::Scene;
use sglow_shader_gen::library::Library;
use sglow_shader_gen::matrix::Facts;
use thiserror::Error;

use super::configuration;
use super::space::Space;
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
    facts: Facts,
}

impl Case {
    /// Derives what a scene with one light needs.
    ///
    /// # Errors
    ///
    /// When what is requested is not possible.
    pub fn new(scene: Scene, library: Library, request: &Request) -> Result<Self, RequestError> {
        let derivation = Derivation::new(&library, &scene, &[], request)?;
        let facts = scene.facts().known();
        Ok(Self { scene, derivation, library, facts })
    }

    /// The configurations of scenes of its class.
    ///
    /// # Errors
    ///
    /// When the library describes no frame.
    pub fn space(&self) -> Result<Space<'_>, RequestError> {
        let frame = self.library.frame().ok_or(RequestError::NoFrame)?;
        Ok(Space::new(&frame.description, &self.facts))
    }

    /// What `--set` takes to give a configuration, without other options but the preset: the values in which it differs
    /// from the default, and those that defaults would have set which do not apply beside these.
    ///
    /// # Errors
    ///
    /// When the scene has no such configuration.
    pub fn set(&self, settings: &Settings) -> Result<Vec<String>, RequestError> {
        // Without numbers that were requested, since they are among the values.
        let request = Request { numbers: Vec::new(), ..self.derivation.request.clone() };
        let mut set: Vec<String> = Vec::new();
        loop {
            let found = Derivation::new(&self.library, &self.scene, &set, &request)?.settings;
            let name = configuration::name(settings, &found);
            if name == "default" {
                return Ok(set);
            }
            let parts = name.split(',').map(str::to_owned);
            let missing: Vec<String> = parts.filter(|part| !set.contains(part)).collect();
            if missing.is_empty() {
                let wrong = format!("--set {} gives another configuration", set.join(","));
                return Err(RequestError::Settings(vec![wrong]));
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

    pub(crate) fn case(scene: &str, over: &[PathBuf]) -> Case {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shaders");
        let library = Library::load_with(&folder, over).unwrap();
        let scene = load(scene, None, &sglow_scene::Options::default()).unwrap().0;
        Case::new(scene, library, &Request::of([16, 9])).unwrap()
    }

    #[test]
    fn what_set_takes_gives_the_configuration_back() {
        let numbers = Request { numbers: vec!["lights=1024".to_owned()], ..Request::of([16, 9]) };
        for (scene, request) in [
            ("cornell", Request::of([16, 9])),
            ("atrium", Request::of([16, 9])),
            ("cornell", numbers),
        ] {
            let case = case(scene, &[]);
            let case = Case::new(case.scene, case.library, &request).unwrap();
            let base = &case.derivation.settings;
            let of = |set: &[String]| {
                let request = Request::of([16, 9]);
                Derivation::new(&case.library, &case.scene, set, &request).unwrap().settings
            };
            let mut all = vec![base.clone()];
            for (axis, value) in [
                ("lights", "64"),
                ("lights", "4096"),
                ("cut", "none"),
                ("space", "none"),
                ("emitter", "lobe"),
            ] {
                all.extend(case.space().unwrap().with(base, axis, value));
            }
            assert!(all.len() >= 5);
            for settings in all {
                let set = case.set(&settings).unwrap();
                assert_eq!(configuration::name(&settings, &of(&set)), "default", "{set:?}");
            }
        }
        let case = case("cornell", &[]);
        let base = &case.derivation.settings;
        assert!(case.set(base).unwrap().is_empty());
        // The name alone gives flat lights.
        let few = case.space().unwrap().with(base, "lights", "64").unwrap();
        assert_eq!(configuration::name(&few, base), "lights=64");
        assert!(case.set(&few).unwrap().contains(&"cut=tile".to_owned()));
    }
}
