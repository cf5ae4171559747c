//! `graph`: the frame of a configuration, as a list and as a drawing.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use clap::Args;
use sglow_graph::description::{DrawList, Parameter};
use sglow_graph::frame::Frame;
use sglow_graph::{Configuration, Description};
use sglow_renderer::plan::Surfaces;
use sglow_report::failure::{Failure, Result};
use sglow_report::json::Report;
use sglow_report::page::graph::content::{Access, Bindings, Content};
use sglow_report::page::graph::{drawing, text};
use sglow_report::{failure, write};
use sglow_runtime::interface;
use sglow_runtime::package::Package;
use sglow_runtime::settings::Settings;
use sglow_scene::Scene;
use sglow_shader_gen::generate;
use sglow_shader_gen::library::Library;
use sglow_shader_gen::manifest::{self, Resource};
use sglow_shader_gen::matrix::Facts;

use crate::command::render;
use crate::derivation::{Derivation, Request, settle};
use crate::selection::Over;
#[cfg(test)]
use crate::selection::library_folder;
use crate::{say, shot};

/// What `--help` shows below the options.
pub(crate) const EXAMPLES: &str = "\
Examples:
  cargo xtask graph
  cargo xtask graph --scene cornell
  cargo xtask graph --scene cornell --set precision=f16,space=none --size 1920x1080
  cargo xtask graph --scene columns --preset tokuyoshi2016 --out out/columns.svg
  cargo xtask graph --scene cornell --out out/cornell.json
  cargo xtask graph --package shaders/packages/sglow --set lights=4096

Which resources a frame keeps, the largest first in each part, and which steps it runs, in order: what each reads and writes,
and how many workgroups or draws that are. Steps that repeat are listed once, with the number of rounds. The .svg shows the
same: a lane for each resource, a column for each step. The .json holds every step and every resource.";

/// Options of `graph`.
#[derive(Debug, Args)]
pub(crate) struct Arguments {
    /// The frame of this scene: a built-in scene, or a file (.gltf, .glb, .obj) [default: of none, with a spot light]
    #[arg(long, value_name = "FILE|NAME")]
    scene: Option<String>,
    /// Values of axes and parameters
    #[arg(long, value_name = "AXIS=VALUE", value_delimiter = ',')]
    set: Vec<String>,
    /// A named configuration of the library; what else is given changes it [default: the defaults for the scene]
    #[arg(long, value_name = "NAME")]
    preset: Option<String>,
    /// Pixels of the picture
    #[arg(long, value_name = "WxH", default_value = "640x360", value_parser = shot::size)]
    size: [u32; 2],
    /// The scene's light that is used, counted from 0 [default: the one with the most power]
    #[arg(long, value_name = "NUMBER", requires = "scene")]
    light: Option<usize>,
    /// The frame that a package describes [default: that of the library]
    #[arg(long, value_name = "DIR")]
    package: Option<PathBuf>,
    #[command(flatten)]
    over: Over,
    /// Write a drawing (.svg) or the list for machines (.json) instead of showing tables
    #[arg(long, value_name = "FILE.svg|FILE.json")]
    out: Option<PathBuf>,
}

/// Shows, or writes.
///
/// # Errors
///
/// When the scene, the library or the package cannot be read, the configuration is not possible, or the file cannot be
/// written.
pub(crate) fn run(arguments: &Arguments) -> Result {
    let kind = arguments.out.as_deref().map(Kind::of).transpose()?;
    let content = content(arguments)?;
    let (Some(out), Some(kind)) = (&arguments.out, kind) else {
        say::line(text(&content));
        return Ok(());
    };
    match kind {
        Kind::Drawing => write::text(out, &drawing(&content))?,
        Kind::List => {
            let mut report = Report::new();
            report.detail("frame", &content)?;
            report.write(out)?;
        }
    }
    say::line(out.display());
    Ok(())
}

/// What is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Drawing,
    List,
}

impl Kind {
    fn of(out: &Path) -> Result<Self> {
        match out.extension().and_then(|extension| extension.to_str()) {
            Some("svg") => Ok(Self::Drawing),
            Some("json") => Ok(Self::List),
            _ => Err(Failure::new(format!("{}: expected a file .svg or .json", out.display()))),
        }
    }
}

fn content(arguments: &Arguments) -> Result<Content> {
    let library = arguments.over.library()?;
    let scene = arguments.scene.as_deref().map(|name| shot::load(name, arguments.light));
    let scene = scene.transpose()?;
    let request = Request { preset: arguments.preset.clone(), ..Request::of(arguments.size) };
    let settings = match &scene {
        Some(scene) => Derivation::new(&library, scene, &arguments.set, &request)?.settings,
        None => {
            let facts = Facts::new();
            let requested = request.settings(&library, &facts, &arguments.set)?;
            let allowed = library.needed(&facts).map_err(failure::rendered)?;
            settle(&library, &allowed, &arguments.set, &requested)?
        }
    };
    let package = arguments.package.as_deref();
    let package =
        package.map(|folder| render::package(Some(folder), &arguments.over)).transpose()?;
    let (description, origin) = match &package {
        Some(package) => (package.description(), package.origin()),
        None => (library.frame().map(|frame| &frame.description), "library"),
    };
    let none = || Failure::new(format!("{origin}: describes no frame"));
    let description = description.ok_or_else(none)?;
    let configuration = configuration(&settings, scene.as_ref(), description);
    let frame = description.evaluate(&configuration)?;
    let bindings = match &package {
        Some(package) => of_package(package, &frame)?,
        None => of_library(&library, &frame)?,
    };
    let [width, height] = arguments.size;
    let name = scene.map_or_else(|| "any scene".to_owned(), |scene| scene.name);
    let title = format!("{name}, {width} x {height}");
    let changed = changed(description, &configuration);
    Ok(Content::new(title, changed, configuration, &frame, &bindings))
}

/// Settings in the words of the frame. Without a scene the host draws with the defaults of its lists' axes.
fn configuration(
    settings: &Settings,
    scene: Option<&Scene>,
    description: &Description,
) -> Configuration {
    let mut configuration = settings.configuration();
    if let Some(scene) = scene {
        Surfaces::of(scene, settings.complete).describe(&mut configuration);
        return configuration;
    }
    let kind = |list: &DrawList| {
        let default =
            |axis: &String| Some((axis.clone(), description.axes.get(axis)?.default.clone()));
        BTreeSet::from([list.axes.iter().filter_map(default).collect()])
    };
    let lists = description.draws.iter();
    configuration.draws = lists.map(|(name, list)| (name.clone(), kind(list))).collect();
    configuration
}

/// What is not the default of the description, as `--set` takes it.
fn changed(description: &Description, configuration: &Configuration) -> Vec<String> {
    let axes = configuration.axes.iter().filter(|(name, value)| {
        description.axes.get(*name).is_some_and(|axis| axis.default != **value)
    });
    let axes = axes.map(|(name, value)| format!("{name}={value}"));
    let numbers = configuration.parameters.iter().filter(|(name, number)| {
        let known = description.parameter.get(*name);
        // Settings hold real numbers in 32 bits.
        let same = |known: &Parameter| known.default.real() as f32 == number.real() as f32;
        // The title says the sizes of what the host has, and the scene.
        known.is_some_and(|known| !known.host && !same(known))
    });
    let numbers = numbers.map(|(name, number)| format!("{name}={}", number.real() as f32));
    axes.chain(numbers).collect()
}

/// What the variants of a frame bind, by the texts that are generated of them.
fn of_library(library: &Library, frame: &Frame) -> Result<Bindings> {
    let mut variants = Vec::new();
    for variant in frame.variants() {
        let values: Vec<(&str, &str)> =
            variant.axes.iter().map(|(axis, value)| (axis.as_str(), value.as_str())).collect();
        variants.push(library.variant(&variant.pass, &values).map_err(failure::rendered)?);
    }
    let mut bindings = Bindings::new();
    for one in generate::variants(library, &variants).map_err(failure::rendered)? {
        let reflected = manifest::reflect(&one.text, &one.module, &one.info)?;
        let of = reflected.bindings.iter().filter_map(|binding| {
            let access = match &binding.resource {
                Resource::Storage { access, .. } | Resource::StorageTexture { access, .. } => {
                    let reads = *access != manifest::Access::Write;
                    Access { reads, writes: *access != manifest::Access::Read }
                }
                Resource::Uniform { .. } => return None,
                Resource::Texture { .. } | Resource::Sampler { .. } => READ,
            };
            Some((binding.name.clone(), access))
        });
        bindings.insert(one.variant.id(), of.collect());
    }
    Ok(bindings)
}

const READ: Access = Access { reads: true, writes: false };

/// What the variants of a frame bind, as a package says.
fn of_package(package: &Package, frame: &Frame) -> Result<Bindings> {
    let mut bindings = Bindings::new();
    for variant in frame.variants() {
        let id = variant.to_string();
        // A missing one is an error that names it.
        package.text(&id)?;
        let interface = package.interface(&id).map_or(&[][..], |known| &known.bindings);
        let of = interface.iter().filter_map(|binding| {
            let access = match &binding.kind {
                interface::Kind::Storage { access, .. }
                | interface::Kind::StorageTexture { access, .. } => {
                    let reads = *access != interface::Access::Write;
                    Access { reads, writes: *access != interface::Access::Read }
                }
                interface::Kind::Uniform { .. } => return None,
                interface::Kind::Texture { .. } | interface::Kind::Sampler { .. } => READ,
            };
            Some((binding.name.clone(), access))
        });
        bindings.insert(id, of.collect());
    }
    Ok(bindings)
}

#[cfg(test)]
mod tests {
    use sglow_report::page::graph::faults;

    use super::*;

    fn arguments(scene: Option<&str>, set: &[&str]) -> Arguments {
        Arguments {
            scene: scene.map(str::to_owned),
            set: set.iter().map(|&word| word.to_owned()).collect(),
            preset: None,
            size: [640, 360],
            light: None,
            package: None,
            out: None,
            over: Over::default(),
        }
    }

    #[test]
    fn the_frame_of_cornell_as_a_table_and_as_a_list() {
        let content = content(&arguments(Some("cornell"), &[])).unwrap();
        insta::assert_snapshot!("cornell", text(&content));
        let list = serde_json::to_string_pretty(&content).unwrap();
        insta::assert_snapshot!("cornell_list", list);
    }

    #[test]
    fn what_is_kept_and_used_is_what_is_bound() {
        let content = content(&arguments(Some("cornell"), &["visibility=none"])).unwrap();
        let step = |pass: &str| {
            let found = content.steps.iter().find(|step| step.pass.as_deref() == Some(pass));
            found.unwrap_or_else(|| panic!("no {pass}"))
        };
        let names = |uses: &[sglow_report::page::graph::content::Use]| -> Vec<String> {
            uses.iter().map(|one| one.resource.clone()).collect()
        };
        let shade = step("shade");
        assert_eq!(names(&shade.writes), ["diffuse"]);
        assert!(names(&shade.reads).contains(&"vsgls".to_owned()));
        // The group gives it, the variant does not bind it.
        assert!(!names(&shade.reads).contains(&"light_maps".to_owned()));
        let surface = step("surface");
        assert_eq!(surface.reads, []);
        assert_eq!(surface.writes.len(), 4);
        let bytes: u64 = content.resources.iter().map(|resource| resource.bytes).sum();
        assert_eq!(content.bytes, bytes);
    }

    #[test]
    fn nothing_in_a_drawing_is_on_top_of_something_else() {
        for (scene, set) in [
            (Some("cornell"), &[][..]),
            (Some("cornell-glossy"), &["density=bidirectional", "precision=f16", "space=none"]),
            (Some("atrium:15k"), &["visibility=imperfect", "draw=metropolis", "lights=65536"]),
            (None, &["space=none"]),
        ] {
            let content = content(&arguments(scene, set)).unwrap();
            assert_eq!(faults(&content), [""; 0], "{set:?}");
        }
    }

    #[test]
    fn a_package_has_the_frame_that_the_library_has() {
        let folder = library_folder().join("packages/sglow");
        // Variants of the default settings are committed; those of the scene's defaults need not be.
        let set = ["space=none", "visibility=none", "emitter=cosine"];
        let of = |package: Option<PathBuf>| {
            content(&Arguments { package, ..arguments(None, &set) }).unwrap()
        };
        assert_eq!(of(Some(folder.clone())), of(None));
        let missing = Arguments {
            package: Some(folder),
            ..arguments(None, &["diffuse=constant", "variance=planar", "sharpness=toksvig"])
        };
        let text = content(&missing).unwrap_err().to_string();
        assert!(text.contains("has no variant"), "{text}");
    }

    #[test]
    fn what_cannot_be_is_an_error() {
        for (set, wanted) in [
            (&["colour=red"][..], "colour"),
            (&["space=world", "precision=f16"], "precision: f32 with clusters"),
        ] {
            let text = content(&arguments(None, set)).unwrap_err().to_string();
            assert!(text.contains(wanted), "{text}");
        }
        assert_eq!(Kind::of(Path::new("a/b.svg")).unwrap(), Kind::Drawing);
        assert!(Kind::of(Path::new("b.png")).unwrap_err().to_string().contains(".svg or .json"));
    }
}
