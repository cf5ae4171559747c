//! The lists of a cut for each tile and their error, by the size of the light's map. `docs/numerics.md` shows them.

use sglow_oracle::cut::LightTree;
use sglow_oracle::cut::estimate::SLACK;
use sglow_oracle::cut::tile::How;
use sglow_oracle::metrics::luminance;
use sglow_oracle::surface::SurfaceTexel;
use sglow_renderer::device::{DeviceError, Gpu};
use sglow_renderer::frame::{Frame, Renderer};
use sglow_renderer::reference;
use sglow_renderer::reference::tree::TreeBuffers;
use sglow_results::cuts::{CutError, CutOfMap, CutsOnScene};
use sglow_results::picture_error::{Display, Pair, Radiance, compare};
use sglow_results::progress::Progress;
use sglow_runtime::package::Package;
use sglow_runtime::settings::Settings;
use sglow_scene::Scene;
use sglow_shaders::{Cut, Emitter, Lobes, Ndf, Space, Specular, Visibility};

use crate::light_maps::{LightMapsError, indirect};
use crate::tile_lists;

/// The built-in scenes that are measured.
pub const SCENES: [&str; 3] = ["cornell", "columns", "atrium"];
/// Widths and heights of the map in texels.
pub const MAPS: [u32; 5] = [64, 128, 256, 512, 1024];
/// The largest map whose texels can all be lights.
const ALL_TEXELS: u32 = 256;

/// Diffuse reflection without visibility, which changes no list's length by more than the maps darken.
#[must_use]
pub fn base() -> Settings {
    Settings {
        size: [240, 135],
        space: Space::Tree,
        cut: Cut::Tile,
        emitter: Emitter::Disc,
        visibility: Visibility::None,
        lobes: Lobes::Diffuse,
        specular: Specular::None,
        ndf: Ndf::None,
        lights: 16,
        ..Settings::default()
    }
}

/// Measures each map on all of [`SCENES`].
///
/// # Errors
/// [`LightMapsError`] when a scene does not render.
pub fn all(
    gpu: &Gpu,
    package: &Package,
    progress: &dyn Progress,
) -> Result<Vec<CutsOnScene>, LightMapsError> {
    progress.start("cuts", SCENES.len() * MAPS.len());
    let mut found = Vec::new();
    for name in SCENES {
        let scene = Scene::load(name)?;
        let mut maps = Vec::new();
        for map in MAPS {
            let settings = Settings { map, ..base() };
            maps.push(of_map(gpu, package, &scene, &settings)?);
            progress.done(found.len() * MAPS.len() + maps.len());
        }
        found.push(CutsOnScene { scene: name.to_owned(), maps });
    }
    progress.end();
    Ok(found)
}

/// Measures one cut.
///
/// # Errors
/// [`LightMapsError`] when the scene does not render.
pub fn of_map(
    gpu: &Gpu,
    package: &Package,
    scene: &Scene,
    settings: &Settings,
) -> Result<CutOfMap, LightMapsError> {
    let renderer = Renderer::new(gpu, package, scene, settings, 0)?;
    renderer.render()?;
    let frame = renderer.read()?;
    let buffers = TreeBuffers::read(gpu, renderer.indirect()).map_err(frame_error)?;
    let (tree, leaves) =
        buffers.map_or_else(Default::default, |buffers| (buffers.tree(), buffers.leaves));
    let eye = reference::vector(renderer.eye());
    drop(renderer);
    let surfaces: Vec<SurfaceTexel> = reference::texels(&frame.gbuffer);
    let model = reference::model(settings);
    let how = How { tolerance: settings.tolerance.into(), slack: SLACK, model: &model, eye };
    let size = settings.size.map(|side| side as usize);
    let lists = Lists::of(&tree, &surfaces, size, &how);
    let error = (settings.map <= ALL_TEXELS)
        .then(|| {
            let (cut, lights) = (Cut::None, settings.map * settings.map);
            let all = Settings { cut, lights, ..settings.clone() };
            let renderer = Renderer::new(gpu, package, scene, &all, 0)?;
            renderer.render()?;
            Ok::<_, LightMapsError>(error(&frame, &renderer.read()?, settings.size))
        })
        .transpose()?;
    Ok(CutOfMap {
        map: settings.map,
        leaves,
        nodes_mean: lists.mean(),
        nodes_95: lists.below(0.95),
        longest: lists.longest,
        error,
    })
}

fn frame_error(error: DeviceError) -> LightMapsError {
    LightMapsError::Frame(error.into())
}

/// The lists of a picture's tiles, by the oracle from the device's tree.
struct Lists {
    /// Number of nodes that each pixel with a surface takes, in increasing order.
    nodes: Vec<usize>,
    /// Number of nodes in the longest list.
    longest: usize,
}

impl Lists {
    fn of(tree: &LightTree, surfaces: &[SurfaceTexel], size: [usize; 2], how: &How<'_>) -> Self {
        let tiles = tile_lists::each(tree, surfaces, size, how).into_iter();
        let each: Vec<(usize, Vec<usize>)> =
            tiles.map(|tile| (tile.length, tile.taken.into_iter().flatten().collect())).collect();
        let longest = each.iter().map(|(length, _)| *length).max().unwrap_or(0);
        let mut nodes: Vec<usize> = each.into_iter().flat_map(|(_, nodes)| nodes).collect();
        nodes.sort_unstable();
        Self { nodes, longest }
    }

    fn mean(&self) -> f64 {
        self.nodes.iter().sum::<usize>() as f64 / self.nodes.len().max(1) as f64
    }

    fn below(&self, share: f64) -> usize {
        let at = (share * self.nodes.len() as f64) as usize;
        self.nodes.get(at.min(self.nodes.len().saturating_sub(1))).copied().unwrap_or(0)
    }
}

/// A cut's picture against that of all texels.
fn error(cut: &Frame, all: &Frame, size: [u32; 2]) -> CutError {
    let surfaces: Vec<SurfaceTexel> = reference::texels(&cut.gbuffer);
    let [picture, whole] = [cut, all].map(indirect);
    let present: Vec<usize> =
        (0..surfaces.len()).filter(|&pixel| surfaces[pixel].present).collect();
    let pair = Pair {
        size,
        present: Some(&present),
        picture: &picture,
        halves: [&whole; 2],
        whole: &picture,
        whole_halves: [&whole; 2],
        display: Display::Automatic,
    };
    CutError { picture: compare(&pair), jump: jump(&surfaces, &picture, &whole, size[0] as usize) }
}

/// The least cosine of the normals, and the largest slope from a plane, of two pixels of one surface.
const SAME: (f64, f64) = (0.99, 0.05);

/// The largest change of the relative error between neighbours on one surface. In the dark, errors are in parts of a
/// hundredth of the mean.
fn jump(surfaces: &[SurfaceTexel], picture: &Radiance, all: &Radiance, width: usize) -> f64 {
    let luminance = |pixel: [f32; 3]| luminance(pixel.map(f64::from));
    let mean = all.iter().map(|&pixel| luminance(pixel)).sum::<f64>() / all.len() as f64;
    let relative = |at: usize| {
        let (found, exact) = (luminance(picture[at]), luminance(all[at]));
        (found - exact) / exact.max(0.01 * mean)
    };
    let same = |one: usize, other: usize| {
        let (one, other) = (&surfaces[one], &surfaces[other]);
        let apart = one.position - other.position;
        let slope = apart.dot(one.normal).abs() / apart.length().max(1e-30);
        one.present && other.present && one.normal.dot(other.normal) > SAME.0 && slope < SAME.1
    };
    let right = (0..surfaces.len()).filter(|at| at % width + 1 < width).map(|at| (at, at + 1));
    let below = (0..surfaces.len().saturating_sub(width)).map(|at| (at, at + width));
    let steps = right.chain(below).filter(|&(one, other)| same(one, other));
    steps.map(|(one, other)| (relative(one) - relative(other)).abs()).fold(0.0, f64::max)
}
