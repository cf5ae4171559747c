//! The closest centre of a point, by looking at all of them.

use crate::{Bounded, Real, Vector3};

/// The centre that is closest to a point.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Closest {
    /// Its number; of centres at the same place the first one's.
    pub cluster: usize,
    /// The numbers of all centres that rounding may find closest, this one among them.
    pub candidates: Vec<usize>,
}

impl Closest {
    /// Whether rounding cannot find another centre closest.
    #[must_use]
    pub fn certain(&self) -> bool {
        self.candidates.len() == 1
    }
}

/// The closest of some centres, which are f32 numbers, and those that are as close but for rounding.
///
/// In the image the third coordinates are 0. Centres at the same place have the same distance whatever rounding does, so
/// that the first one of them alone is a candidate. `None` without centres.
// [Tokuyoshi 2016, Appendix D]
#[must_use]
pub fn closest(centres: &[Vector3], point: Vector3) -> Option<Closest> {
    let bounded = Vector3::<Bounded>::constant(point);
    let distances: Vec<Bounded> = centres
        .iter()
        .map(|&centre| (Vector3::constant(centre) - bounded).length_squared())
        .collect();
    let first = |a: usize, b: usize| if distances[b].value < distances[a].value { b } else { a };
    let cluster = (0..centres.len()).reduce(first)?;
    let reach = distances[cluster].value + distances[cluster].error();
    let near = (0..centres.len())
        .filter(|&index| distances[index].value - distances[index].error() <= reach);
    let mut candidates: Vec<usize> = Vec::new();
    for index in near {
        if candidates.iter().all(|&other| centres[other] != centres[index]) {
            candidates.push(index);
        }
    }
    Some(Closest { cluster, candidates })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_closest_is_found_and_doubt_is_named() {
        let at = |x: f64, y: f64| Vector3::new(x, y, 0.0);
        let centres = [at(4.0, 0.0), at(0.0, 0.0), at(0.0, 0.0), at(2.0, 0.0)];
        let found = closest(&centres, at(0.5, 3.0)).unwrap();
        assert_eq!((found.cluster, found.certain()), (1, true));
        // Halfway between two.
        let found = closest(&centres, at(3.0, 1.0)).unwrap();
        assert_eq!((found.cluster, found.candidates), (0, vec![0, 3]));
        // An f32 cannot tell these apart, an f64 can.
        let found = closest(&centres, at(3.0 - 1e-8, 1.0)).unwrap();
        assert_eq!((found.cluster, found.candidates), (3, vec![0, 3]));
        let found = closest(&centres, at(3.0 - 1e-4, 1.0)).unwrap();
        assert_eq!((found.cluster, found.certain()), (3, true));
        assert_eq!(closest(&[], at(0.0, 0.0)), None);
    }
}
