//! Points on a scene's surfaces: what imperfect shadow maps are drawn from.

use glam::DVec3;
use sglow_shaders::SglowShadowPoint;
use thiserror::Error;

/// Triangles, relative to [`crate::light::Surroundings::origin`].
#[derive(Clone, Copy, Debug)]
pub struct Geometry<'a> {
    /// Positions of vertices.
    pub positions: &'a [[f32; 3]],
    /// Three for each triangle, in either order.
    pub indices: &'a [u32],
}

/// Why triangles are none.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum GeometryError {
    /// Indices do not come in threes.
    #[error("there are {count} indices; triangles have three each")]
    Ragged {
        /// How many there are.
        count: usize,
    },
    /// An index without a position.
    #[error("index number {at} is {index}; there are {positions} positions")]
    OutOfRange {
        /// Its place among the indices.
        at: usize,
        /// The index.
        index: u32,
        /// The number of positions.
        positions: usize,
    },
    /// A position that is NaN or infinite.
    #[error("position number {at} is {position:?}; it has to be finite")]
    NotFinite {
        /// Its place among the positions.
        at: usize,
        /// The position.
        position: [f32; 3],
    },
}

impl Geometry<'_> {
    /// Checks indices and positions.
    ///
    /// # Errors
    ///
    /// The first index or position at fault.
    pub fn check(&self) -> Result<(), GeometryError> {
        if !self.indices.len().is_multiple_of(3) {
            return Err(GeometryError::Ragged { count: self.indices.len() });
        }
        let positions = self.positions.len();
        if let Some(at) = self.indices.iter().position(|index| *index as usize >= positions) {
            return Err(GeometryError::OutOfRange { at, index: self.indices[at], positions });
        }
        let finite = |position: &[f32; 3]| position.iter().all(|part| part.is_finite());
        match self.positions.iter().position(|position| !finite(position)) {
            Some(at) => Err(GeometryError::NotFinite { at, position: self.positions[at] }),
            None => Ok(()),
        }
    }

    fn triangles(&self) -> impl Iterator<Item = [DVec3; 3]> + '_ {
        self.indices.chunks_exact(3).filter_map(|corners| {
            let [a, b, c] = [corners[0], corners[1], corners[2]].map(|corner| {
                self.positions.get(corner as usize).map(|position| position.map(f64::from).into())
            });
            Some([a?, b?, c?])
        })
    }

    /// Points spread evenly over the area of all triangles: `subsets` sets of `count` each, set by set, every one of
    /// them a stratified sample of the whole by itself. None without any area. The same triangles give the same points.
    ///
    /// The triangles, laid end to end by their areas, are cut into as many equal parts as there are points, which go to
    /// the sets in turn. Within a triangle a point's place along its share is one coordinate, a multiple of the golden
    /// ratio the other.
    // [Ritschel 2008, Section 3.1]; the map from the square to a triangle is that of [Turk 1990, Graphics Gems, Generating random points in triangles]
    pub fn points(&self, count: u32, subsets: u32) -> Vec<SglowShadowPoint> {
        /// One over the golden ratio.
        const GOLDEN: f64 = 0.618_033_988_749_894_9;
        /// One over the plastic number: sets have other second coordinates than their neighbours.
        const PLASTIC: f64 = 0.754_877_666_246_692_8;
        let triangles: Vec<_> = self.triangles().filter(|one| area(*one) > 0.0).collect();
        let total: f64 = triangles.iter().copied().map(area).sum();
        let (count, subsets) = (u64::from(count), u64::from(subsets));
        let number = count * subsets;
        if !(total > 0.0 && total.is_finite()) || number == 0 {
            return Vec::new();
        }
        let mut points = vec![SglowShadowPoint::default(); number as usize];
        // The disc that covers a square of a point's share of the area.
        let radius = (0.5 * total / count as f64).sqrt() as f32;
        let (mut triangle, mut before) = (0, 0.0);
        for next in 0..number {
            let at = (next as f64 + 0.5) / number as f64 * total;
            // What rounding of the sum leaves over lies at the end of the last triangle.
            while at > before + area(triangles[triangle]) && triangle + 1 < triangles.len() {
                before += area(triangles[triangle]);
                triangle += 1;
            }
            let [a, b, c] = triangles[triangle];
            let along = (at - before) / area([a, b, c]);
            let (turn, set) = (next / subsets, next % subsets);
            let across = (turn as f64 * GOLDEN + set as f64 * PLASTIC).fract();
            let root = along.clamp(0.0, 1.0).sqrt();
            let position = a + (b - a) * (root * (1.0 - across)) + (c - a) * (root * across);
            let normal = (b - a).cross(c - a).normalize_or_zero();
            points[(set * count + turn) as usize] = SglowShadowPoint {
                position: position.as_vec3().into(),
                radius,
                normal: normal.as_vec3().into(),
                ..Default::default()
            };
        }
        points
    }
}

fn area([a, b, c]: [DVec3; 3]) -> f64 {
    0.5 * (b - a).cross(c - a).length()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A unit square in two triangles, and one of a quarter of its area far away.
    fn geometry() -> (Vec<[f32; 3]>, Vec<u32>) {
        let positions = vec![
            [0.0, 0.0, 0.0],
            [1.0, 0.0, 0.0],
            [1.0, 1.0, 0.0],
            [0.0, 1.0, 0.0],
            [5.0, 0.0, 0.0],
            [5.0, 0.5, 0.0],
            [5.0, 0.0, 1.0],
        ];
        (positions, vec![0, 1, 2, 0, 2, 3, 3, 3, 3, 4, 5, 6])
    }

    #[test]
    fn every_set_is_spread_evenly() {
        let (positions, indices) = geometry();
        let geometry = Geometry { positions: &positions, indices: &indices };
        geometry.check().unwrap();
        let (count, subsets) = (1280, 16);
        let points = geometry.points(count, subsets);
        assert_eq!(points.len(), 1280 * 16);
        assert_eq!(points, geometry.points(count, subsets));
        for set in points.chunks_exact(1280) {
            // A fifth of the area is far away, and an eighth of the square's points in each of 8 strips, either way.
            let far = set.iter().filter(|point| point.position[0] > 4.0).count();
            assert!(far.abs_diff(256) <= 1, "{far}");
            for axis in 0..2 {
                for strip in 0..8 {
                    let inside = |point: &&SglowShadowPoint| {
                        point.position[0] < 4.0
                            && (8.0 * point.position[axis]).floor() as usize == strip
                    };
                    let found = set.iter().filter(inside).count();
                    assert!(found.abs_diff(128) < 16, "{axis} {strip}: {found}");
                }
            }
            for point in set {
                let expected =
                    if point.position[0] > 4.0 { [1.0, 0.0, 0.0] } else { [0.0, 0.0, 1.0] };
                assert_eq!(point.normal, expected);
                assert!((2.0 * point.radius.powi(2) * 1280.0 - 1.25).abs() < 1e-5);
            }
        }
        let (first, second) = (&points[..1280], &points[1280..2560]);
        assert!(first.iter().all(|point| !second.contains(point)), "sets differ");
        // Negative control: one point in five of every set, in a row, is not spread evenly.
        let first = points[..256].iter().filter(|point| point.position[0] > 4.0).count();
        assert!(first.abs_diff(51) > 16, "{first}");
    }

    #[test]
    fn nothing_gives_no_points_and_faults_are_named() {
        let flat = Geometry { positions: &[[1.0; 3]; 3], indices: &[0, 1, 2] };
        assert_eq!(flat.points(64, 16), Vec::new());
        assert_eq!(Geometry { positions: &[], indices: &[] }.points(64, 16), Vec::new());
        let positions = [[0.0; 3], [f32::NAN; 3]];
        let fault = |indices: &[u32]| {
            Geometry { positions: &positions, indices }.check().unwrap_err().to_string()
        };
        assert_eq!(fault(&[0, 1]), "there are 2 indices; triangles have three each");
        assert_eq!(fault(&[0, 1, 2]), "index number 2 is 2; there are 2 positions");
        assert!(fault(&[0, 0, 0]).contains("position number 1"));
    }
}
