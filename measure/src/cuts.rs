//! The lists of a cut for each tile and their error, by the size of the light's map. `docs/numerics.md` shows them.

use sglow_oracle::metrics::luminance;
use sglow_oracle::surface::SurfaceTexel;
use sglow_renderer::device::{DeviceError, Gpu};
use sglow_renderer::frame::Renderer;
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
use crate::tile_lists::{self, Tile};

/// The built-in scenes that are measured.
pub const SCENES: [&str; 3] = ["cornell", "columns", "atrium"];
/// Widths and heights of the map in texels.
pub const MAPS: [u32; 3] = [64, 256, 1024];
/// The largest map whose texels can all be lights.
const ALL_TEXELS: u32 = 256;
/// How much wider and higher the picture is whose parts are measured.
pub const WIDER: u32 = 8;
/// Middles of these parts, within -1 to 1.
const WINDOWS: [[f32; 2]; 4] = [[-0.5, 0.5], [0.5, 0.5], [-0.5, -0.5], [0.5, -0.5]];

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

/// Parts of a scene's picture, in its full detail.
fn windows(scene: &Scene) -> Vec<Scene> {
    let [width, height] = base().size.map(|side| side as f32);
    let window = |at| scene.camera.window(at, 1.0 / WIDER as f32, width / height);
    let view = |at| Scene { camera: window(at), ..scene.clone() };
    WINDOWS.map(view).into()
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
        let views = windows(&scene);
        let mut maps = Vec::new();
        for map in MAPS {
            let settings = Settings { map, ..base() };
            maps.push(of_map(gpu, package, &views, &settings)?);
            progress.done(found.len() * MAPS.len() + maps.len());
        }
        found.push(CutsOnScene { scene: name.to_owned(), maps });
    }
    progress.end();
    Ok(found)
}

/// Measures one cut of a light's map by the pictures of some cameras.
///
/// # Errors
/// [`LightMapsError`] when a picture does not render.
pub fn of_map(
    gpu: &Gpu,
    package: &Package,
    views: &[Scene],
    settings: &Settings,
) -> Result<CutOfMap, LightMapsError> {
    let seen: Vec<Seen> = views
        .iter()
        .map(|view| Seen::of(gpu, package, view, settings))
        .collect::<Result<_, LightMapsError>>()?;
    let tiles: Vec<Tile> = seen.iter().flat_map(|seen| &seen.tiles).cloned().collect();
    let lists = tile_lists::summary(&tiles, settings.size.map(|side| side as usize));
    Ok(CutOfMap {
        map: settings.map,
        leaves: seen.first().map_or(0, |seen| seen.leaves),
        nodes_mean: lists.mean,
        nodes_95: lists.below_95,
        longest: lists.longest(),
        error: (settings.map <= ALL_TEXELS).then(|| error(&seen, settings.size)),
    })
}

/// The picture of one camera.
struct Seen {
    surfaces: Vec<SurfaceTexel>,
    tiles: Vec<Tile>,
    /// Lit texels.
    leaves: usize,
    /// Radiance by the cut, and of all texels as lights unless they are too many.
    pictures: [Radiance; 2],
}

impl Seen {
    fn of(
        gpu: &Gpu,
        package: &Package,
        scene: &Scene,
        settings: &Settings,
    ) -> Result<Self, LightMapsError> {
        let renderer = Renderer::new(gpu, package, scene, settings, 0)?;
        renderer.render()?;
        let frame = renderer.read()?;
        let buffers = TreeBuffers::read(gpu, renderer.indirect()).map_err(frame_error)?;
        let (tree, leaves) =
            buffers.map_or_else(Default::default, |buffers| (buffers.tree(), buffers.leaves));
        let eye = reference::vector(renderer.eye());
        drop(renderer);
        let surfaces: Vec<SurfaceTexel> = reference::texels(&frame.gbuffer);
        let tiles = tile_lists::each(&tree, &surfaces, settings, eye);
        let mut all = Radiance::new();
        if settings.map <= ALL_TEXELS {
            let lights = settings.map * settings.map;
            let settings = Settings { cut: Cut::None, lights, ..settings.clone() };
            let renderer = Renderer::new(gpu, package, scene, &settings, 0)?;
            renderer.render()?;
            all = indirect(&renderer.read()?);
        }
        Ok(Self { surfaces, tiles, leaves, pictures: [indirect(&frame), all] })
    }
}

fn frame_error(error: DeviceError) -> LightMapsError {
    LightMapsError::Frame(error.into())
}

/// Pictures of a cut, one below the other, against those of all texels.
fn error(seen: &[Seen], size: [u32; 2]) -> CutError {
    let joined = |which: usize| -> Radiance {
        seen.iter().flat_map(|seen| seen.pictures[which].iter().copied()).collect()
    };
    let [picture, whole] = [joined(0), joined(1)];
    let surfaces = seen.iter().flat_map(|seen| &seen.surfaces);
    let present: Vec<usize> =
        surfaces.enumerate().filter(|(_, surface)| surface.present).map(|(at, _)| at).collect();
    let pair = Pair {
        size: [size[0], size[1] * seen.len() as u32],
        present: Some(&present),
        picture: &picture,
        halves: [&whole; 2],
        whole: &picture,
        whole_halves: [&whole; 2],
        display: Display::Automatic,
    };
    let relative = relative(&picture, &whole);
    let pixels = (size[0] * size[1]) as usize;
    let mut jumps: Vec<f64> = seen
        .iter()
        .zip(relative.chunks(pixels))
        .flat_map(|(seen, relative)| jumps(&seen.surfaces, relative, size[0] as usize))
        .collect();
    jumps.sort_unstable_by(f64::total_cmp);
    let at = (0.999 * jumps.len() as f64) as usize;
    CutError {
        picture: compare(&pair),
        jump: jumps.last().copied().unwrap_or(0.0),
        jump_999: jumps.get(at).copied().unwrap_or(0.0),
    }
}

/// The relative error of each pixel; in the dark in parts of a hundredth of the mean.
fn relative(picture: &Radiance, all: &Radiance) -> Vec<f64> {
    let of = |pixel: &[f32; 3]| luminance(pixel.map(f64::from));
    let mean = all.iter().map(of).sum::<f64>() / all.len() as f64;
    let pairs = picture.iter().map(of).zip(all.iter().map(of));
    pairs.map(|(found, exact)| (found - exact) / exact.max(0.01 * mean)).collect()
}

/// The least cosine of the normals, and the largest slope from a plane, of two pixels of one surface.
const SAME: (f64, f64) = (0.99, 0.05);

/// The change of the relative error between all neighbours on one surface.
fn jumps(surfaces: &[SurfaceTexel], relative: &[f64], width: usize) -> Vec<f64> {
    let same = |one: usize, other: usize| {
        let (one, other) = (&surfaces[one], &surfaces[other]);
        let apart = one.position - other.position;
        let slope = apart.dot(one.normal).abs() / apart.length().max(f64::MIN_POSITIVE);
        one.present && other.present && one.normal.dot(other.normal) > SAME.0 && slope < SAME.1
    };
    let right = (0..surfaces.len()).filter(|at| at % width + 1 < width).map(|at| (at, at + 1));
    let below = (0..surfaces.len().saturating_sub(width)).map(|at| (at, at + width));
    let neighbours = right.chain(below).filter(|&(one, other)| same(one, other));
    neighbours.map(|(one, other)| (relative[one] - relative[other]).abs()).collect()
}
