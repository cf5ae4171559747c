//! `graph`: the frame of a configuration, as a list and as a drawing.

use std::path::{Path, PathBuf};

use clap::Args;
use sglow_renderer::request::derivation::Request;
use sglow_renderer::request::frame::{self, RequestedFrame};
use sglow_report::failure::{Failure, Result};
use sglow_report::json::Report;
use sglow_report::page::graph::content::{Access, Bindings, Content};
use sglow_report::page::graph::{drawing, text};
use sglow_report::{parse, write};

use crate::options::{Over, Reading};
use crate::say;

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
    #[arg(long, value_name = "WxH", default_value = "640x360", value_parser = parse::size)]
    size: [u32; 2],
    /// The one light of the scene that is used, counted from 0 [default: all of them]
    #[arg(long, value_name = "NUMBER", requires = "scene")]
    light: Option<usize>,
    #[command(flatten)]
    reading: Reading,
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
pub(crate) fn run(arguments: &Arguments) -> Result {
    let kind = arguments.out.as_deref().map(Kind::of).transpose()?;
    let library = arguments.over.library()?;
    let scene =
        arguments.scene.as_deref().map(|name| arguments.reading.load(name, arguments.light));
    let scene = scene.transpose()?;
    let package = arguments.package.as_deref();
    let package = package.map(|folder| arguments.over.package(Some(folder))).transpose()?;
    let request = Request { preset: arguments.preset.clone(), ..Request::of(arguments.size) };
    let (package, scene) = (package.as_ref(), scene.as_ref());
    let requested = RequestedFrame::new(&library, package, scene, &arguments.set, &request)?;
    let RequestedFrame { changed, configuration, frame, bindings } = requested;
    let [width, height] = arguments.size;
    let name = scene.map_or("any scene", |scene| &scene.name);
    let title = format!("{name}, {width} x {height}");
    let content = Content::new(title, changed, configuration, &frame, &accesses(bindings));
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

/// What variants do with their bindings, as a listing takes it.
fn accesses(bindings: frame::Bindings) -> Bindings {
    let access = |(name, frame::Access { reads, writes })| (name, Access { reads, writes });
    let of = |(variant, all): (String, std::collections::BTreeMap<_, _>)| {
        (variant, all.into_iter().map(access).collect())
    };
    bindings.into_iter().map(of).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_written_follows_from_the_files_name() {
        assert_eq!(Kind::of(Path::new("a/b.svg")).unwrap(), Kind::Drawing);
        assert!(Kind::of(Path::new("b.png")).unwrap_err().to_string().contains(".svg or .json"));
    }
}
