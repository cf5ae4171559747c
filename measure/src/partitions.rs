//! What making lights of the map by kernels, by clusters or by a cut for each tile does to a picture, compared with paths.
//! `docs/numerics.md` shows it.

use sglow_renderer::device::Gpu;
use sglow_results::light_maps::OnScene;
use sglow_results::progress::Progress;
use sglow_runtime::package::Package;
use sglow_runtime::settings::Settings;
use sglow_scene::Scene;
use sglow_shaders::{Cut, Emitter, Space, SpecularPower, Visibility};

use crate::light_maps::{Case, LightMapsError};

/// The built-in scenes with occluders that are measured.
pub const SCENES: [&str; 5] = ["caustic", "cornell-glossy", "atrium", "cornell", "columns"];
/// Paths for each pixel of the reference.
pub const PATHS: u32 = 4096;

/// What all have in common: rasterised maps, kernels of a quarter of their share of the map, the default power of
/// specular lobes.
#[must_use]
pub fn base() -> Settings {
    let (visibility, specular_power) = (Visibility::ShadowMap, SpecularPower::Albedo);
    let size_factor = 0.25;
    Settings { size: [112, 63], size_factor, visibility, specular_power, ..Settings::default() }
}

/// Measures each on all of [`SCENES`].
///
/// # Errors
/// [`LightMapsError`] when a scene does not render or cannot be traced.
pub fn all(
    gpu: &Gpu,
    package: &Package,
    progress: &dyn Progress,
) -> Result<Vec<(&'static str, Vec<OnScene>)>, LightMapsError> {
    let flat = |space, emitter| (space, emitter, Cut::None, 1024, 1.5);
    let cut = |lights, near_scale| (Space::Tree, Emitter::Disc, Cut::Tile, lights, near_scale);
    let choices = [
        flat(Space::None, Emitter::Cosine),
        flat(Space::World, Emitter::Disc),
        cut(256, 0.75),
        cut(448, 0.0),
        cut(448, 0.75),
        cut(448, 1.5),
        cut(1024, 0.75),
    ];
    progress.start("kernels, clusters and cuts", SCENES.len());
    let mut all = Vec::new();
    for name in SCENES {
        let case = Case::new(gpu, package, Scene::load(name)?, base(), PATHS)?;
        let mut rows = Vec::new();
        for (space, emitter, cut, lights, near_scale) in choices {
            let change = |settings: &mut Settings| {
                (settings.space, settings.emitter) = (space, emitter);
                (settings.cut, settings.lights) = (cut, lights);
                settings.near_scale = near_scale;
            };
            let error = case.error(gpu, package, change)?;
            rows.push(OnScene {
                name: match cut {
                    Cut::None => format!("`space={space},emitter={emitter}`"),
                    Cut::Tile => format!("`cut={cut},lights={lights},near_scale={near_scale}`"),
                },
                default: false,
                error,
            });
        }
        all.push((name, rows));
        progress.done(all.len());
    }
    progress.end();
    Ok(all)
}
