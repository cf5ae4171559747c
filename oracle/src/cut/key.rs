//! The key that a texel is sorted by.

use crate::vpl::along_the_curve;
use crate::{Real, Vector3};

/// The key of what is no leaf: a texel without a surface, without power, with a number that is not finite, or beyond the map.
pub const UNLIT: u32 = u32::MAX;
/// Bits of a cell's number along an axis.
const CELL_BITS: i32 = 10;
/// Bits of the number of one of the finest cells, by which boxes around nodes are kept.
const FINEST_BITS: i32 = 16;

/// A grid of cells on a lattice that is fixed in the world: two cells of the coarsest level along each axis hold all lit texels.
///
/// The width of a cell is a power of two and its corners are multiples of it, so that the planes between cells stay where
/// they are while the box around the texels moves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Grid {
    /// Binary logarithm of the width of the coarsest cells.
    pub exponent: i32,
    /// The lowest of the coarsest cells along each axis.
    pub first: [i64; 3],
}

impl Grid {
    /// The grid around a box, whose numbers are f32.
    #[must_use]
    #[expect(clippy::cast_possible_truncation, reason = "whole numbers that are kept in range")]
    pub fn around(low: [f32; 3], high: [f32; 3]) -> Self {
        let (low, high) = (low.map(f64::from), high.map(f64::from));
        let largest = low.iter().chain(&high).fold(0.0_f64, |a, b| a.max(b.abs()));
        let cells = |at: [f64; 3], exponent: i32| at.map(|x| (x * 2f64.powi(-exponent)).floor());
        // f32 has 24 bits: cells much smaller than the spacing of these numbers resolve nothing.
        let least = exponent(largest).saturating_sub(22).max(-100);
        let fits = |&exponent: &i32| {
            let (low, high) = (cells(low, exponent), cells(high, exponent));
            (0..3).all(|axis| high[axis] - low[axis] <= 1.0)
        };
        let exponent = (least..128).find(fits).unwrap_or(127);
        Self { exponent, first: cells(low, exponent).map(|cell| cell as i64) }
    }

    /// The width of the finest cells, 2^16 along each axis.
    #[must_use]
    pub fn finest(&self) -> f64 {
        2f64.powi(self.exponent + 1 - FINEST_BITS)
    }

    /// The middle of one of the finest cells.
    #[must_use]
    pub fn middle(&self, cell: [u32; 3]) -> Vector3 {
        let of = |axis: usize| {
            let first = self.first[axis] << (FINEST_BITS - 1);
            (first as f64 + f64::from(cell[axis]) + 0.5) * self.finest()
        };
        Vector3::new(of(0), of(1), of(2))
    }

    /// The cell of a position, 0 to 1023 along each axis, and whether rounding cannot find another one.
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "clamped to 0 to 1023"
    )]
    fn cell<R: Real>(&self, position: Vector3<R>) -> ([u32; 3], bool) {
        let scale = 2f64.powi(CELL_BITS - 1 - self.exponent);
        let mut certain = true;
        let parts = position.to_array();
        let cell = core::array::from_fn(|axis| {
            let of = |at: f64| {
                let cell = (at * scale).floor() - (self.first[axis] << (CELL_BITS - 1)) as f64;
                cell.clamp(0.0, 1023.0) as u32
            };
            let (at, error) = (parts[axis].value(), parts[axis].error());
            certain &= of(at - error) == of(at + error);
            of(at)
        });
        (cell, certain)
    }
}

/// The exponent of the power of two at or below a positive number; that of the least normal f32 for smaller ones.
fn exponent(number: f64) -> i32 {
    if number < f64::from(f32::MIN_POSITIVE) { -126 } else { number.log2().floor() as i32 }
}

/// The key of a texel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Key {
    /// Three bits of the normal's face (0 to 5 for +x, -x, +y, -y, +z, -z), then 29 bits of the Morton code of the cell.
    pub key: u32,
    /// Whether rounding cannot find another one.
    pub certain: bool,
}

impl Key {
    /// Of a normal of any length above 0 and of a position.
    // [Morton 1966]
    pub fn of<R: Real>(position: Vector3<R>, normal: Vector3, grid: &Grid) -> Self {
        let ([x, y, z], certain) = grid.cell(position);
        let code = spread_by_three(x) | spread_by_three(y) << 1 | spread_by_three(z) << 2;
        // The lowest bit has no room beside the face.
        Self { key: face(normal) << 29 | code >> 1, certain }
    }
}

/// The face of a cube that a direction looks through; the first one where two are equally near.
#[must_use]
pub fn face(normal: Vector3) -> u32 {
    let [x, y, z] = normal.map(f64::abs).to_array();
    let (axis, part) = if x >= y && x >= z {
        (0, normal.x)
    } else if y >= z {
        (1, normal.y)
    } else {
        (2, normal.z)
    };
    2 * axis + u32::from(part < 0.0)
}

/// Each of the lower ten bits, at three times its place.
fn spread_by_three(number: u32) -> u32 {
    (0..10).fold(0, |spread, bit| spread | (number >> bit & 1) << (3 * bit))
}

/// The texels of a map in the order in which they are sorted: along a curve whose pieces are compact, so that texels of equal
/// keys are split as the map is. Places beyond the map have none.
// [Morton 1966]
#[must_use]
pub fn places(size: [usize; 2]) -> Vec<Option<usize>> {
    let side = size[0].max(size[1]).next_power_of_two();
    let mut places = vec![None; side * side];
    for y in 0..size[1] {
        for x in 0..size[0] {
            if let Some(place) = places.get_mut(along_the_curve([x, y]) as usize) {
                *place = Some(y * size[0] + x);
            }
        }
    }
    places
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_stay_while_the_box_moves() {
        let at = Vector3::new(0.3, -0.7, 0.2);
        let grid = |shift: f32| {
            Grid::around([-1.0 + shift, -0.9 + shift, -0.5], [1.2 + shift, 0.8 + shift, 0.4])
        };
        let normal = Vector3::new(0.0, 1.0, 0.0);
        let keys: Vec<u32> =
            [0.0, 1e-3, 0.02, 0.1].map(|shift| Key::of(at, normal, &grid(shift)).key).into();
        assert!(keys.iter().all(|&key| key == keys[0]), "{keys:?}");
        assert_eq!(grid(0.0).exponent, 1);
        assert_eq!(grid(0.0).first, [-1, -1, -1]);
    }

    #[test]
    fn a_grid_holds_its_box_and_is_no_larger_than_it_has_to_be() {
        let boxes = [
            ([0.0; 3], [0.0; 3]),
            ([1e-38; 3], [1e-38; 3]),
            ([1.0; 3], [1.0; 3]),
            ([-3e37, 0.0, 0.0], [3e37, 0.0, 0.0]),
            ([1e6, 1e6, -1e6], [1e6 + 4.0, 1e6 + 0.25, -1e6 + 3.0]),
            ([0.99, 0.99, 0.99], [1.01, 1.01, 1.01]),
            ([-1e18; 3], [1e-18; 3]),
        ];
        for (low, high) in boxes {
            let grid = Grid::around(low, high);
            for corner in [low, high] {
                let scale = 2f64.powi(-grid.exponent);
                for axis in 0..3 {
                    let cell = (f64::from(corner[axis]) * scale).floor() as i64;
                    assert!((0..2).contains(&(cell - grid.first[axis])), "{grid:?} {corner:?}");
                }
            }
            let extent = (0..3).map(|axis| f64::from(high[axis]) - f64::from(low[axis]));
            let extent = extent.fold(0.0, f64::max);
            let cell = 2f64.powi(grid.exponent);
            let largest = low.iter().chain(&high).fold(0.0, |a, b| f64::max(a, f64::from(b.abs())));
            let unit = 2f64.powi((largest.max(1e-38).log2().floor() as i32 - 22).max(-100));
            assert!(cell <= (2.0 * extent).max(unit), "{grid:?} {extent}");
        }
    }

    #[test]
    fn faces_and_codes_are_told_apart() {
        let grid = Grid::around([0.0; 3], [1.0; 3]);
        let key = |position, normal| Key::of::<f64>(position, normal, &grid).key;
        let at = Vector3::splat(0.4);
        let [x, y, z] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]
            .map(|[x, y, z]| Vector3::new(x, y, z));
        let faces: Vec<u32> = [x, -x, y, -y, z, -z].map(|normal| key(at, normal) >> 29).into();
        assert_eq!(faces, [0, 1, 2, 3, 4, 5]);
        assert_eq!(face(Vector3::new(-0.5, 0.5, 0.5)), 1);
        // Along z first, then y, then x.
        let moved = |by: Vector3| key(at + by * 0.25, y) ^ key(at, y);
        assert!(moved(z) > moved(y) && moved(y) > moved(x));
        assert_eq!(key(Vector3::splat(-1.0), y) & 0x1fff_ffff, 0);
    }

    #[test]
    fn places_are_a_permutation_whose_squares_lie_together() {
        let places = places([8, 8]);
        let mut sorted: Vec<usize> = places.iter().map(|place| place.unwrap()).collect();
        for square in sorted.chunks(4) {
            let (x, y) = (square[0] % 8, square[0] / 8);
            assert!(square.iter().all(|at| at % 8 / 2 == x / 2 && at / 8 / 2 == y / 2));
        }
        sorted.sort_unstable();
        assert_eq!(sorted, (0..64).collect::<Vec<_>>());
        let odd = super::places([5, 3]);
        assert_eq!((odd.len(), odd.iter().flatten().count()), (64, 15));
    }
}
