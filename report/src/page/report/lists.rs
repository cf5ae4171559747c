//! How many nodes of a cut each pixel and each tile takes, as pictures with one scale.

use maud::{Markup, html};
use sglow_oracle::cut::tile::SIDE;
use sglow_results::tile_lists::TileLists;

use crate::page::number::{count, figure};
use crate::page::report::named::Named;
use crate::page::report::pictures::{legend, picture};
use crate::picture::{false_colour, png};

pub(crate) fn section(named: &Named<'_>) -> Markup {
    let measured = named.scene.measured;
    let Some(lists) = &measured.lists else {
        return html! { p.quiet { "The default has no cut for each tile." } };
    };
    let [width, height] = measured.size;
    let top = scale_end(lists) as f32;
    let shown = |values: &[f32]| {
        false_colour::map(width, height, values, top).and_then(|map| png::data(&map))
    };
    let pixels = shown(&named.scene.pictures.nodes);
    let tiles = shown(&lengths(lists, measured.size));
    html! {
        p.quiet {
            "Of the default, by the oracle from the device's tree, without visibility: shadow maps darken the radiance that "
            "the tolerance is a part of, which makes lists longer, and keep nodes below an occluded root as they are, which makes "
            "them shorter. A pixel takes the nodes of its tile's list for which its own share of the votes is above 0. "
            "Black: no surface, or no light."
        }
        (legend("nodes 0", &html! { (top) }))
        div.both {
            (picture("nodes of each pixel", &format!("nodes of each pixel, at most {}", lists.maximum), width, height, Some(pixels.as_ref())))
            (picture("length of each tile's list", &format!("length of each tile's list, at most {}", lists.longest()), width, height, Some(tiles.as_ref())))
        }
        dl.facts {
            dt { "nodes of a pixel" } dd { "mean " (figure(lists.mean)) ", 95 % stay below " (count(lists.below_95)) ", at most " (count(lists.maximum)) }
            dt { "longest list" } dd { (count(lists.longest())) " of " (count(lists.limit)) " nodes that a list has room for" }
            dt { "tiles without room" } dd { (count(lists.stopped)) " of " (count(lists.lengths.len())) " stopped refining" }
        }
    }
}

/// The end of the colour scale: a list's room, or the smallest of its halves, quarters and so on that no list is above.
fn scale_end(lists: &TileLists) -> usize {
    let mut top = lists.limit.max(1);
    while top.is_multiple_of(2) && top / 2 >= lists.longest().max(1) {
        top /= 2;
    }
    top
}

/// The length of the list of each pixel's tile.
fn lengths(lists: &TileLists, [width, height]: [u32; 2]) -> Vec<f32> {
    let pixels = (0..height as usize).flat_map(|y| (0..width as usize).map(move |x| [x, y]));
    let tile = |[x, y]: [usize; 2]| y / SIDE * lists.columns + x / SIDE;
    let length = |at| lists.lengths.get(at).copied().unwrap_or(0) as f32;
    pixels.map(|pixel| length(tile(pixel))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lists(longest: usize) -> TileLists {
        TileLists { columns: 2, lengths: vec![3, longest], limit: 1152, ..TileLists::default() }
    }

    #[test]
    fn a_scale_ends_at_a_round_part_of_the_room() {
        for (longest, end) in [(0, 9), (9, 9), (72, 72), (73, 144), (577, 1152), (1152, 1152)] {
            assert_eq!(scale_end(&lists(longest)), end, "{longest}");
        }
    }

    #[test]
    fn a_tile_is_as_bright_as_its_list_is_long() {
        let found = lengths(&lists(7), [SIDE as u32 + 1, 1]);
        assert_eq!(found[..SIDE], [3.0; SIDE]);
        assert_eq!(found[SIDE..], [7.0]);
    }
}
