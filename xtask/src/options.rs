//! Options that commands share, and what is opened for them.

use std::path::{Path, PathBuf};

use clap::{Args, value_parser};
use sglow_consumers::machine::library_folder;
use sglow_measure::saved;
use sglow_renderer::device::Gpu;
use sglow_renderer::request::derivation::Request;
use sglow_renderer::request::selection::{self, Selection, whole_space};
use sglow_renderer::request::shot;
use sglow_report::failure::{self, Failure, Result};
use sglow_report::parse;
use sglow_results::saved::Measured;
use sglow_runtime::package::Package;
use sglow_scene::Scene;
use sglow_shader_gen::library::Library;

/// What is laid over the library.
#[derive(Clone, Debug, Default, Args)]
pub(crate) struct Over {
    /// Lay a folder over the library: passes, axes, values, parameters, resources and steps of your own (docs/overlays.md);
    /// may be given more than once
    #[arg(long, value_name = "DIR")]
    pub(crate) library: Vec<PathBuf>,
}

impl Over {
    /// Reads the library with what is laid over it.
    pub(crate) fn library(&self) -> Result<Library> {
        Library::load_with(&library_folder(), &self.library).map_err(failure::rendered)
    }

    /// Every legal variant of it, generated in memory: what is not committed too.
    pub(crate) fn whole_space(&self) -> Result<Package> {
        Ok(whole_space(&self.library()?)?)
    }

    /// The package in a folder, or every variant of the library with what is laid over it.
    pub(crate) fn package(&self, folder: Option<&Path>) -> Result<Package> {
        let Some(folder) = folder else { return self.whole_space() };
        Package::load(folder).map_err(|errors| {
            let lines: Vec<_> = errors.iter().map(ToString::to_string).collect();
            Failure::new(lines.join("\n"))
        })
    }
}

/// How a scene's file is read.
#[derive(Clone, Copy, Debug, Default, Args)]
pub(crate) struct Reading {
    /// Read buffers, images and material libraries outside of the folder of the scene's file as well
    #[arg(long)]
    pub(crate) allow_outside: bool,
}

impl Reading {
    /// The same for those who load scenes.
    pub(crate) fn options(self) -> sglow_scene::Options {
        sglow_scene::Options { allow_outside: self.allow_outside, ..Default::default() }
    }

    /// Loads a scene with the light that is used, and prints what a user should know of it.
    pub(crate) fn load(self, name: &str, light: Option<usize>) -> Result<Scene> {
        let (scene, notes) = shot::load(name, light, &self.options())?;
        notes.iter().for_each(|note| eprintln!("{note}"));
        Ok(scene)
    }
}

/// Options that choose variants.
#[derive(Clone, Debug, Default, Args)]
pub(crate) struct Choice {
    #[command(flatten)]
    pub(crate) over: Over,
    /// What a frame of this scene runs: a built-in scene, or a file (.gltf, .glb, .obj)
    #[arg(long, value_name = "FILE|NAME")]
    pub(crate) scene: Option<String>,
    /// Variants with these values; an axis may be given more than once
    #[arg(long, value_name = "AXIS=VALUE", value_delimiter = ',')]
    pub(crate) set: Vec<String>,
    /// A named configuration of the library instead of the scene's defaults
    #[arg(long, value_name = "NAME", requires = "scene")]
    pub(crate) preset: Option<String>,
    /// Every legal variant, not only those that are committed; with --scene all that its needs leave, not only what a
    /// frame of it runs
    #[arg(long)]
    pub(crate) all: bool,
    /// The one light of the scene that is used, counted from 0 [default: all of them]
    #[arg(long, value_name = "NUMBER", requires = "scene")]
    pub(crate) light: Option<usize>,
    #[command(flatten)]
    pub(crate) reading: Reading,
}

impl Choice {
    /// Whether this means what is committed.
    pub(crate) fn is_committed(&self) -> bool {
        self.scene.is_none() && self.set.is_empty() && !self.all
    }

    /// The variants that are meant, and what `report` has measured of the scene.
    pub(crate) fn select(&self, library: &Library) -> Result<(Selection, Option<Measured>)> {
        let load = |name| self.reading.load(name, self.light);
        let scene = self.scene.as_deref().map(load).transpose()?;
        let measured = scene.as_ref().and_then(|scene| saved::find(&saved_folder(), scene));
        let Self { set, preset, all, .. } = self.clone();
        let choice = selection::Choice { set, preset, all };
        let milliseconds = measured.as_ref().map(|measured| &measured.rules);
        Ok((choice.select(library, scene.as_ref(), milliseconds)?, measured))
    }
}

/// The folder of results, unless another one is named.
pub(crate) fn saved_folder() -> PathBuf {
    sglow_consumers::machine::target_folder().join("measured")
}

/// Numbers that `render`, `report`, `choose` and `reproduce` share, and the named configuration that they change.
#[derive(Clone, Debug, Default, Args)]
pub(crate) struct Numbers {
    #[command(flatten)]
    pub(crate) over: Over,
    /// A named configuration of the library; what else is given changes it [default: the defaults for the scene]
    #[arg(long, value_name = "NAME")]
    pub(crate) preset: Option<String>,
    /// Number of virtual lights, 1 to 65536: flat ones, and no cut [default: the preset's or the scene's]
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
    #[arg(long, value_name = "K", allow_negative_numbers = true, value_parser = parse::factor)]
    pub(crate) size_factor: Option<f32>,
    /// The one light of the scene that is used, counted from 0 [default: all of them]
    #[arg(long, value_name = "NUMBER")]
    pub(crate) light: Option<usize>,
    /// The GPU whose name contains this [default: the most capable one]
    #[arg(long, visible_alias = "device", value_name = "NAME")]
    pub(crate) adapter: Option<String>,
    #[command(flatten)]
    pub(crate) reading: Reading,
}

impl Numbers {
    /// The numbers that are given, by the names of the command line and of the library.
    pub(crate) fn given(&self) -> Vec<(&'static str, &'static str, String)> {
        let mut given = Vec::new();
        let mut add = |option: &'static str, name: &'static str, value: Option<String>| {
            given.extend(value.map(|value| (option, name, value)));
        };
        add("--lights", "lights", self.lights.map(|number| number.to_string()));
        add("--rsm", "map", self.rsm.map(|number| number.to_string()));
        add("--iterations", "iterations", self.iterations.map(|number| number.to_string()));
        add("--size-factor", "size_factor", self.size_factor.map(|number| number.to_string()));
        given
    }

    /// What is requested with these numbers.
    pub(crate) fn request(&self, size: [u32; 2]) -> Request {
        let given = self.given().into_iter();
        let numbers = given.map(|(_, name, value)| format!("{name}={value}")).collect();
        Request { size, preset: self.preset.clone(), numbers }
    }

    /// A scene and the settings it is rendered with.
    pub(crate) fn shot(&self, name: &str, set: &[String], size: [u32; 2]) -> Result<shot::Shot> {
        let scene = self.reading.load(name, self.light)?;
        let shot = shot::Shot::new(&self.over.library()?, scene, set, &self.request(size))?;
        shot.notes.iter().for_each(|note| eprintln!("{note}"));
        Ok(shot)
    }

    /// Opens the GPU that is requested.
    pub(crate) fn gpu(&self) -> Result<Gpu> {
        open(self.adapter.as_deref())
    }
}

/// Opens the GPU whose name contains `adapter`, or the most capable one.
pub(crate) fn open(adapter: Option<&str>) -> Result<Gpu> {
    let gpu = Gpu::open(adapter)
        .map_err(|error| Failure::from(error).help("`cargo xtask doctor` shows what there is"))?;
    if gpu.adapter.software {
        eprintln!(
            "{} is a software rasterizer; its timings do not predict GPU performance",
            gpu.adapter.name
        );
    }
    Ok(gpu)
}

#[cfg(test)]
mod tests {
    use clap::Parser;

    use super::*;

    #[test]
    fn files_outside_of_the_scene_s_folder_are_read_where_that_is_allowed() {
        let folder = tempfile::tempdir().unwrap();
        let inside = folder.path().join("scene");
        std::fs::create_dir(&inside).unwrap();
        std::fs::write(folder.path().join("red.mtl"), "newmtl red\nKd 1 0 0\n").unwrap();
        let scene = inside.join("a.obj");
        let text = "mtllib ../red.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl red\nf 1 2 3\n";
        std::fs::write(&scene, text).unwrap();
        let color = |allow_outside: bool| {
            let scene = Reading { allow_outside }.load(scene.to_str().unwrap(), None).unwrap();
            scene.materials[0].base_color
        };
        assert_eq!([color(false), color(true)], [[0.5, 0.5, 0.5, 1.0], [1.0, 0.0, 0.0, 1.0]]);
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
}
