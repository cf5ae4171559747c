//! What is wrong with a drawing: text on text, on a mark or on a bar, or anything beyond the edge.

use std::collections::BTreeSet;

use crate::page::graph::layout::{ANGLE, Box, Fill, LANE, Layout, Shape, Text, wide};

/// Everything that is on top of something else, or beyond the drawing.
pub(super) fn faults(drawing: &Layout) -> Vec<String> {
    let mut faults = Vec::new();
    let mut inside = |what: &str, [x, y]: [f64; 2]| {
        if !(0.0..=drawing.width).contains(&x) || !(0.0..=drawing.height).contains(&y) {
            faults.push(format!("{what} leaves the drawing"));
        }
    };
    for text in &drawing.texts {
        corners(text).into_iter().for_each(|corner| inside(&text.text, corner));
    }
    for Shape { place: Box { x, y, width, height }, fill, .. } in &drawing.shapes {
        inside(&format!("{fill:?}"), [*x, *y]);
        inside(&format!("{fill:?}"), [x + width, y + height]);
    }
    for mark in &drawing.marks {
        inside(&mark.title, [mark.x - LANE / 4.0, mark.y - LANE / 4.0]);
        inside(&mark.title, [mark.x + LANE / 4.0, mark.y + LANE / 4.0]);
    }
    for (index, one) in drawing.texts.iter().enumerate() {
        for other in &drawing.texts[index + 1..] {
            if cross(&corners(one), &corners(other)) {
                faults.push(format!("`{}` is on top of `{}`", one.text, other.text));
            }
        }
        for mark in &drawing.marks {
            let half = LANE / 4.0;
            let (left, right) = (mark.x - half, mark.x + half);
            let (top, bottom) = (mark.y - half, mark.y + half);
            let square = [[left, top], [right, top], [right, bottom], [left, bottom]];
            if cross(&corners(one), &square) {
                faults.push(format!("`{}` is on top of a mark ({})", one.text, mark.title));
            }
        }
        let bars = drawing.shapes.iter().filter(|shape| shape.fill == Fill::Bytes);
        for Shape { place: Box { x, y, width, height }, .. } in bars {
            let bar = [[*x, *y], [x + width, *y], [x + width, y + height], [*x, y + height]];
            if cross(&corners(one), &bar) {
                faults.push(format!("`{}` is on top of a bar", one.text));
            }
        }
    }
    let places: BTreeSet<[u64; 2]> =
        drawing.marks.iter().map(|mark| [mark.x.to_bits(), mark.y.to_bits()]).collect();
    if places.len() < drawing.marks.len() {
        faults.push("marks are on top of marks".to_owned());
    }
    faults
}

/// Whether two convex shapes cross: no edge of either separates them.
fn cross(one: &[[f64; 2]; 4], other: &[[f64; 2]; 4]) -> bool {
    let apart = |edges: &[[f64; 2]; 4]| {
        (0..4).any(|index| {
            let ([ax, ay], [bx, by]) = (edges[index], edges[(index + 1) % 4]);
            let along = |[x, y]: &[f64; 2]| (by - ay) * x - (bx - ax) * y;
            let range = |shape: &[[f64; 2]; 4]| {
                let ends = (f64::INFINITY, f64::NEG_INFINITY);
                shape.iter().map(along).fold(ends, |(low, high), at| (low.min(at), high.max(at)))
            };
            let ((low, high), (from, to)) = (range(one), range(other));
            high <= from || to <= low
        })
    };
    !apart(one) && !apart(other)
}

/// The corners of a text, as it stands.
fn corners(of: &Text) -> [[f64; 2]; 4] {
    let width = wide(&of.text, of.size);
    let left = if of.right { -width } else { 0.0 };
    let (top, bottom) = (-0.8 * of.size, 0.22 * of.size);
    let (sin, cos) = if of.slanted { (-ANGLE).to_radians().sin_cos() } else { (0.0, 1.0) };
    [[left, top], [left + width, top], [left + width, bottom], [left, bottom]]
        .map(|[x, y]| [of.x + x * cos - y * sin, of.y + x * sin + y * cos])
}
