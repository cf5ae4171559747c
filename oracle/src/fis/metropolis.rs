//! Markov chains whose stationary distribution is the density.

use crate::Real;
use crate::fis::hash::{hash, unit_number};
use crate::rsm::Pyramid;

/// How chains move in a frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Steps {
    /// Mutations of each chain.
    pub mutations: u32,
    /// Number of the frame.
    pub frame: u32,
    /// What the random numbers are made of.
    pub seed: u32,
    /// Half the side of the square that a small step leads into, 0 to 1, an f32 number.
    pub radius: f64,
    /// The share of steps that lead anywhere, 0 to 1, an f32 number.
    pub large_steps: f64,
}

/// Where a chain has come to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Moved<R = f64> {
    /// In the image, 0 to 1.
    pub position: [R; 2],
    /// Whether rounding cannot have changed a decision or a texel on the way.
    pub certain: bool,
    /// How many of the mutations were accepted.
    pub accepted: u32,
}

/// Where a chain without a density to follow begins: anywhere.
#[must_use]
pub fn anywhere(chain: u32, seed: u32) -> [f64; 2] {
    let bits = hash([chain, u32::MAX, 0, seed]);
    [unit_number(bits[0]), unit_number(bits[1])]
}

/// The density of the texel that holds a position, and whether rounding cannot have chosen another one.
fn density_at<R: Real>(density: &Pyramid<R>, position: [R; 2]) -> (R, bool) {
    let last = density.size() - 1;
    let mut certain = true;
    let texel = position.map(|coordinate| {
        let place = coordinate * R::constant(density.size() as f64);
        let texel = |place: f64| (place.max(0.0) as usize).min(last);
        let (low, high) = (place.value() - place.error(), place.value() + place.error());
        certain &= texel(low) == texel(high);
        texel(place.value())
    });
    (density.at(0, texel[0], texel[1]), certain)
}

/// A frame's mutations of a chain.
///
/// A step leads anywhere, or into a square about the chain that is folded back at the image's edges; both ways are as
/// likely as their reverse. It is taken with the probability `min(1, d(x')/d(x))`, and without density on either side.
// [Metropolis 1953], [Hastings 1970]; for [Barak 2013], whose own steps were not at hand
pub fn advance<R: Real>(
    density: &Pyramid<R>,
    chain: u32,
    position: [R; 2],
    steps: &Steps,
) -> Moved<R> {
    let (mut here, mut certain) = density_at(density, position);
    let mut moved = Moved { position, certain, accepted: 0 };
    for mutation in 0..steps.mutations {
        let bits = hash([chain, mutation, steps.frame, steps.seed]);
        let place = [unit_number(bits[0]), unit_number(bits[1])];
        // Of the bits that the place has no use for.
        let kind = f64::from((bits[0] & 255) * 256 + (bits[1] & 255)) / 65536.0;
        let proposal: [R; 2] = core::array::from_fn(|axis| {
            if kind < steps.large_steps {
                return R::constant(place[axis]);
            }
            let offset = R::constant(2.0 * place[axis]) - R::one();
            let unfolded = moved.position[axis] + R::constant(steps.radius) * offset;
            R::one() - (R::one() - unfolded.abs()).abs()
        });
        let (there, sure) = density_at(density, proposal);
        certain &= sure;
        let excess = R::constant(unit_number(bits[2])) * here - there;
        certain &= excess.sign_is_certain() || excess.error() == 0.0;
        if excess.value() <= 0.0 {
            moved = Moved { position: proposal, accepted: moved.accepted + 1, ..moved };
            here = there;
        }
    }
    Moved { certain, ..moved }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Bounded;
    use crate::fis::stress::Stress;
    use crate::fis::{lattice, warp};

    const SIZE: usize = 64;
    const BLOCKS: usize = 8;
    const COUNT: u32 = 4096;

    /// The chi-square of the counts of points in blocks of the image, over its degrees of freedom: 1 of points that know
    /// nothing of each other, less of stratified ones.
    fn chi_square(density: &Pyramid<f64>, points: &[[f64; 2]]) -> f64 {
        let mut counts = [0.0; BLOCKS * BLOCKS];
        let mut masses = [0.0; BLOCKS * BLOCKS];
        let scale = SIZE / BLOCKS;
        for (index, mass) in density.level(0).iter().enumerate() {
            masses[index / SIZE / scale * BLOCKS + index % SIZE / scale] += mass;
        }
        for point in points {
            let [x, y] = point.map(|part| ((part * BLOCKS as f64) as usize).min(BLOCKS - 1));
            counts[y * BLOCKS + x] += 1.0;
        }
        let share = points.len() as f64 / masses.iter().sum::<f64>();
        let pairs = counts.iter().zip(masses);
        pairs.map(|(count, mass)| (count - mass * share).powi(2) / (mass * share)).sum::<f64>()
            / (BLOCKS * BLOCKS - 1) as f64
    }

    fn run(
        density: &Pyramid<f64>,
        frames: u32,
        start: impl Fn(u32) -> [f64; 2],
        seed: u32,
    ) -> Vec<[f64; 2]> {
        let mut chains: Vec<[f64; 2]> = (0..COUNT).map(start).collect();
        for frame in 0..frames {
            let steps = Steps { mutations: 4, frame, seed, radius: 0.0625, large_steps: 0.25 };
            for (chain, position) in (0..).zip(&mut chains) {
                *position = advance(density, chain, *position, &steps).position;
            }
        }
        chains
    }

    #[test]
    fn the_density_is_stationary_and_nothing_is_stratified() {
        for stress in [Stress::Smooth, Stress::Noise { sigma: 1.0 }] {
            let density = stress.pyramid(SIZE, 3).unwrap();
            let drawn = |index| warp(&density, lattice::point(index, COUNT)).centre;
            let stratified = chi_square(&density, &(0..COUNT).map(drawn).collect::<Vec<_>>());
            let anywhere = |chain| anywhere(chain, 7);
            let forgotten = chi_square(&density, &run(&density, 30, anywhere, 7));
            let from_lattice = chi_square(&density, &run(&density, 30, drawn, 8));
            let at_start = chi_square(&density, &run(&density, 0, anywhere, 7));
            println!(
                "{stress:?}: lattice {stratified:.4}; chains after 30 frames {forgotten:.3} from anywhere, \
                 {from_lattice:.3} from the lattice; anywhere {at_start:.1}"
            );
            // Of 63 degrees of freedom: 1 with a standard deviation of 0.18.
            assert!((0.3..1.7).contains(&forgotten), "{stress:?}: {forgotten}");
            assert!((0.3..1.7).contains(&from_lattice), "{stress:?}: {from_lattice}");
            assert!(stratified < 0.1 * from_lattice, "{stress:?}: {stratified}");
        }
        // Negative control: where the chains began is not the density.
        let density = Stress::Smooth.pyramid(SIZE, 3).unwrap();
        let at_start = chi_square(&density, &run(&density, 0, |chain| anywhere(chain, 7), 7));
        assert!(at_start > 3.0, "{at_start}");
    }

    #[test]
    fn chains_stay_near_without_large_steps() {
        let density = Stress::Smooth.pyramid(SIZE, 3).unwrap();
        let steps = Steps { mutations: 4, frame: 0, seed: 7, radius: 0.0625, large_steps: 0.0 };
        let mut accepted = 0;
        for chain in 0..256 {
            let start = anywhere(chain, 1);
            let moved = advance(&density, chain, start, &steps);
            accepted += moved.accepted;
            for (axis, start) in start.into_iter().enumerate() {
                assert!((0.0..=1.0).contains(&moved.position[axis]));
                assert!((moved.position[axis] - start).abs() <= 4.0 * 0.0625);
            }
        }
        assert!(accepted > 600, "{accepted} of 1024");
    }

    #[test]
    fn no_density_is_never_entered_and_always_left() {
        let texels = (0..16).map(|index| f64::from(u8::from(index % 4 == 1))).collect();
        let density = Pyramid::build(4, texels).unwrap();
        let steps = Steps { mutations: 64, frame: 0, seed: 7, radius: 0.25, large_steps: 0.0 };
        for chain in 0..64 {
            let [x, _] = advance(&density, chain, [0.9, 0.5], &steps).position;
            assert!((0.25..0.5).contains(&x), "{x}");
        }
    }

    #[test]
    fn doubt_is_named() {
        let density = Stress::Noise { sigma: 1.0 }.pyramid(16, 0).unwrap();
        let texels = density.level(0).iter().map(|&texel| Bounded::exact(texel as f32)).collect();
        let density = Pyramid::build(16, texels).unwrap();
        let steps = Steps { mutations: 1, frame: 0, seed: 7, radius: 0.0, large_steps: 0.0 };
        let at = |x: f64| advance(&density, 0, [Bounded::constant(x), Bounded::exact(0.3)], &steps);
        assert!(at(0.26).certain && !at(0.25 + 1e-9).certain);
    }
}
