//! The lists of a scene's default where that is a cut for each tile of pixels.

use sglow_oracle::surface::SurfaceTexel;
use sglow_renderer::reference;
use sglow_renderer::reference::tree::TreeBuffers;
use sglow_results::tile_lists::TileLists;
use sglow_shaders::Cut;

use super::subject::{Drawn, FrontierError, Subject};
use crate::cache::Cache;
use crate::tile_lists;

/// The lists of the default's tiles, without visibility, and the number of nodes that each pixel takes, row by row, 0
/// without a surface; none where the default has no such lists.
pub(super) fn lists(
    subject: &Subject<'_>,
    cache: &Cache,
) -> Result<Option<(TileLists, Vec<f32>)>, FrontierError> {
    let settings = &subject.base;
    if settings.cut != Cut::Tile {
        return Ok(None);
    }
    cache.get(&subject.key("tile lists", "default", settings)?, || {
        let Drawn { renderer, frame, .. } = subject.drawn()?;
        let (maps, _) = subject.maps(settings, 0)?;
        let (lights, _) = subject.lights(settings, &maps, 0)?;
        let Some(buffers) = TreeBuffers::read(subject.gpu, &lights)? else { return Ok(None) };
        let surfaces: Vec<SurfaceTexel> = reference::texels(&frame.gbuffer);
        let eye = reference::vector(renderer.eye());
        let size = settings.size.map(|side| side as usize);
        let tiles = tile_lists::each(&buffers.tree(), &surfaces, settings, eye);
        let pixels = tile_lists::of_pixels(&tiles, size).into_iter();
        let nodes = pixels.map(|nodes| nodes.unwrap_or(0) as f32).collect();
        Ok(Some((tile_lists::summary(&tiles, size), nodes)))
    })
}
