//! The lists of a cut for each tile of a picture, by the oracle from the device's tree.

use rayon::prelude::*;
use sglow_oracle::Vector3;
use sglow_oracle::cut::LightTree;
use sglow_oracle::cut::estimate::SLACK;
use sglow_oracle::cut::tile::{self, How, SIDE};
use sglow_oracle::surface::SurfaceTexel;
use sglow_renderer::reference;
use sglow_results::tile_lists::TileLists;
use sglow_runtime::settings::Settings;

/// The list of one tile.
#[derive(Clone, Debug)]
pub struct Tile {
    /// Number of its nodes.
    pub length: usize,
    /// Nodes that are not refined for want of room alone.
    pub unrefined: usize,
    /// Number of nodes that each of its pixels takes something of, row by row; none outside the picture and without a
    /// surface.
    pub taken: Vec<Option<usize>>,
}

/// The lists of a picture whose camera is at `eye`, tiles row by row.
#[must_use]
pub fn each(
    tree: &LightTree,
    surfaces: &[SurfaceTexel],
    settings: &Settings,
    eye: Vector3,
) -> Vec<Tile> {
    let model = reference::model(settings);
    let how = How { tolerance: settings.tolerance.into(), slack: SLACK, model: &model, eye };
    let size = settings.size.map(|side| side as usize);
    let columns = size[0].div_ceil(SIDE);
    let tiles = columns * size[1].div_ceil(SIDE);
    (0..tiles)
        .into_par_iter()
        .map(|at| {
            let tile = [at % columns, at / columns];
            let voters = tile::voters(tile, size, &|pixel| surfaces[pixel].present);
            let votes = voters.map(|pixel| surfaces[pixel]);
            let (entries, unrefined) = tile::list_and_unrefined(tree, &votes, &how);
            let taken = |at: usize| {
                let within = [at % SIDE, at / SIDE];
                let [x, y] = [0, 1].map(|axis| SIDE * tile[axis] + within[axis]);
                let surface = (x < size[0] && y < size[1]).then(|| &surfaces[y * size[0] + x]);
                let surface = surface.filter(|surface| surface.present)?;
                let shares = tile::shares(within, surface, &votes);
                Some(entries.iter().filter(|entry| entry.weight(&shares) > 0.0).count())
            };
            let taken = (0..SIDE * SIDE).map(taken).collect();
            Tile { length: entries.len(), unrefined, taken }
        })
        .collect()
}

/// The numbers of the lists of a picture of `size`, or of several such pictures.
#[must_use]
pub fn summary(tiles: &[Tile], size: [usize; 2]) -> TileLists {
    let columns = size[0].div_ceil(SIDE);
    let mut nodes: Vec<usize> =
        tiles.iter().flat_map(|tile| &tile.taken).flatten().copied().collect();
    nodes.sort_unstable();
    let below = (0.95 * nodes.len() as f64) as usize;
    TileLists {
        columns,
        lengths: tiles.iter().map(|tile| tile.length).collect(),
        mean: nodes.iter().sum::<usize>() as f64 / nodes.len().max(1) as f64,
        below_95: nodes.get(below).or(nodes.last()).copied().unwrap_or(0),
        maximum: nodes.last().copied().unwrap_or(0),
        limit: tile::NODES,
        stopped: tiles.iter().filter(|tile| tile.unrefined > 0).count(),
    }
}

/// Nodes that each pixel takes, row by row; none without a surface.
#[must_use]
pub fn of_pixels(tiles: &[Tile], size: [usize; 2]) -> Vec<Option<usize>> {
    let columns = size[0].div_ceil(SIDE);
    let pixels = (0..size[1]).flat_map(|y| (0..size[0]).map(move |x| [x, y]));
    let taken = |[x, y]: [usize; 2]| {
        let tile = tiles.get(y / SIDE * columns + x / SIDE)?;
        tile.taken.get(y % SIDE * SIDE + x % SIDE).copied()?
    };
    pixels.map(taken).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pixels_are_where_their_tiles_are() {
        // Two columns and two rows of tiles, of which the last ones have two pixels and one.
        let size = [SIDE + 2, SIDE + 1];
        let tile = |first: usize| Tile {
            length: 9 + first,
            unrefined: first / 3,
            taken: (0..SIDE * SIDE).map(|at| (at != 1).then_some(100 * first + at)).collect(),
        };
        let tiles: Vec<Tile> = (0..4).map(tile).collect();
        let pixels = of_pixels(&tiles, size);
        assert_eq!(pixels.len(), size[0] * size[1]);
        assert_eq!(pixels[..3], [Some(0), None, Some(2)]);
        assert_eq!(pixels[SIDE], Some(100));
        assert_eq!(pixels[size[0]], Some(SIDE));
        assert_eq!(pixels[SIDE * size[0]..][..1], [Some(200)]);
        assert_eq!(pixels[SIDE * size[0] + SIDE], Some(300));
        let found = summary(&tiles, size);
        assert_eq!((found.columns, found.stopped, found.maximum), (2, 1, 363));
        assert_eq!(found.lengths, [9, 10, 11, 12]);
    }
}
