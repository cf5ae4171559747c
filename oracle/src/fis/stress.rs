//! Densities that are hard on filtering kernels; the same for everybody.

use rand_pcg::Pcg32;
use rand_pcg::rand_core::Rng as _;

use crate::rsm::{Pyramid, PyramidError};

/// Random numbers of a seed: PCG with 64 bits of state and 32 bits of output (XSH-RR).
// [O'Neill 2014, PCG: A family of simple fast space-efficient statistically good algorithms]
#[derive(Clone, Debug)]
pub struct Random(Pcg32);

/// Which of its sequences: the one whose increment is that of Knuth's MMIX, 1442695040888963407 = 2 `STREAM` + 1.
const STREAM: u64 = 721_347_520_444_481_703;

impl Random {
    /// The generator of a seed.
    #[must_use]
    pub fn new(seed: u64) -> Self {
        Self(Pcg32::new(seed, STREAM))
    }

    /// The next 32 bits.
    pub fn bits(&mut self) -> u32 {
        self.0.next_u32()
    }

    /// Uniform in 0 to 1, both excluded.
    pub fn uniform(&mut self) -> f64 {
        (f64::from(self.bits()) + 0.5) / 4_294_967_296.0
    }

    /// Normally distributed with mean 0 and variance 1.
    // [Box and Muller 1958]
    pub fn normal(&mut self) -> f64 {
        let radius = (-2.0 * self.uniform().ln()).sqrt();
        radius * (2.0 * core::f64::consts::PI * self.uniform()).cos()
    }
}

/// A density of a regime that has a name.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Stress {
    /// A wide bump on a base.
    Smooth,
    /// Texels of 1 and 1e-4 in turn.
    Checkerboard,
    /// Log-normal noise, independent between texels.
    Noise {
        /// Standard deviation of the logarithm.
        sigma: f64,
    },
    /// A ring two texels wide over 1e-6.
    Ring,
    /// One texel of 1 over 1e-6.
    HotTexel,
    /// No mass at all.
    Zero,
}

impl Stress {
    /// Every kind, with its name, in the order of reports.
    pub const ALL: [(&str, Self); 7] = [
        ("smooth", Self::Smooth),
        ("checkerboard", Self::Checkerboard),
        ("noise-2", Self::Noise { sigma: 2.0 }),
        ("noise-3", Self::Noise { sigma: 3.0 }),
        ("ring", Self::Ring),
        ("hot-texel", Self::HotTexel),
        ("zero", Self::Zero),
    ];

    /// The texels of a square image, row by row, each an f32 number at least 0.
    #[must_use]
    pub fn texels(self, size: usize, seed: u64) -> Vec<f32> {
        let mut random = Random::new(seed);
        let middle = size as f64 / 2.0;
        (0..size * size)
            .map(|index| {
                let (column, row) = (index % size, index / size);
                let (x, y) =
                    ((column as f64 + 0.5 - middle) / middle, (row as f64 + 0.5 - middle) / middle);
                let density = match self {
                    Self::Smooth => 0.2 + (-2.0 * ((x - 0.2).powi(2) + (y + 0.1).powi(2))).exp(),
                    Self::Checkerboard => {
                        if (column + row).is_multiple_of(2) {
                            1.0
                        } else {
                            1e-4
                        }
                    }
                    Self::Noise { sigma } => (sigma * random.normal()).exp(),
                    Self::Ring => {
                        // A Gaussian profile whose standard deviation is one texel.
                        let distance = (x.hypot(y) - 0.6) * middle;
                        1e-6 + (-0.5 * distance * distance).exp()
                    }
                    Self::HotTexel => {
                        if (column, row) == (5 * size / 8, 3 * size / 8) {
                            1.0
                        } else {
                            1e-6
                        }
                    }
                    Self::Zero => 0.0,
                };
                #[expect(clippy::cast_possible_truncation, reason = "densities are f32 textures")]
                let texel = density as f32;
                texel
            })
            .collect()
    }

    /// The texels and their mips in f64.
    ///
    /// # Errors
    /// If the size is not a power of two.
    pub fn pyramid(self, size: usize, seed: u64) -> Result<Pyramid<f64>, PyramidError> {
        Pyramid::build(size, self.texels(size, seed).into_iter().map(f64::from).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fis::kernel::{
        is_monotone, kernel_mass, modified_factor, modified_level, previous_factor, previous_level,
    };
    use crate::fis::{lattice, trilinear, warp};

    #[test]
    fn random_numbers_are_the_same_everywhere() {
        // Computed by the definition of the generator in Python.
        let first = |seed| {
            let mut random = Random::new(seed);
            std::array::from_fn(|_| random.bits())
        };
        assert_eq!(first(0), [3_894_649_422_u32, 2_055_130_073, 2_315_086_854, 2_925_816_488]);
        assert_eq!(first(9), [3_396_683_593_u32, 298_473_608, 3_727_095_581, 3_489_016_208]);
    }

    #[test]
    fn the_generator_is_uniform_and_normal() {
        let mut random = Random::new(1);
        let count = 100_000;
        let numbers: Vec<(f64, f64)> =
            (0..count).map(|_| (random.uniform(), random.normal())).collect();
        let mean = |value: &dyn Fn(&(f64, f64)) -> f64| {
            numbers.iter().map(value).sum::<f64>() / f64::from(count)
        };
        assert!((mean(&|n| n.0) - 0.5).abs() < 4e-3);
        assert!((mean(&|n| n.0 * n.0) - 1.0 / 3.0).abs() < 4e-3);
        assert!(mean(&|n| n.1).abs() < 0.015);
        assert!((mean(&|n| n.1 * n.1) - 1.0).abs() < 0.02);
        assert_eq!(Random::new(5).bits(), Random::new(5).bits());
    }

    /// What the kernels of a density make of a power that is the density times a smooth reflectance.
    #[derive(Debug)]
    struct Row {
        /// Sum of the kernels' powers over the true total.
        total: f64,
        /// The largest power times N over the true total.
        brightest: f64,
        /// Root mean square of N times the density's integral within a kernel, minus 1.
        deviation: f64,
    }

    fn row(
        density: &Pyramid<f64>,
        count: u32,
        kernel: impl Fn([f64; 2], [usize; 2]) -> (f64, f64),
    ) -> Row {
        let size = density.size();
        let angle = |index: usize| 2.0 * core::f64::consts::PI * (index as f64 + 0.5) / size as f64;
        let reflectance =
            |index: usize| 0.6 + 0.1 * (angle(index % size).sin() + angle(index / size).cos());
        let powers =
            density.level(0).iter().enumerate().map(|(index, &mass)| mass * reflectance(index));
        let power = Pyramid::build(size, powers.collect()).unwrap();
        let whole = power.top() * density.texel_count() as f64;
        let n = f64::from(count);
        let kernels: Vec<(f64, f64)> = (0..count)
            .map(|index| {
                let warped = warp(density, lattice::point(index, count));
                let (level, factor) = kernel(warped.centre, warped.texel);
                let share = factor * trilinear(&power, warped.centre, level) / whole;
                (share, n * kernel_mass(density, warped.centre, level))
            })
            .collect();
        let variance = kernels.iter().map(|kernel| (kernel.1 - 1.0).powi(2)).sum::<f64>() / n;
        Row {
            total: kernels.iter().map(|kernel| kernel.0).sum(),
            brightest: kernels.iter().map(|kernel| kernel.0 * n).fold(0.0, f64::max),
            deviation: variance.sqrt(),
        }
    }

    /// The previous kernels, with p of the texel that the warp ended in or interpolated at the centre.
    fn previous(density: &Pyramid<f64>, count: u32, interpolate: bool) -> Row {
        let (top, texels) = (density.top(), density.texel_count());
        row(density, count, |centre, [x, y]| {
            let at =
                if interpolate { trilinear(density, centre, 0.0) } else { density.at(0, x, y) };
            let level = previous_level(at, top, texels, count, 1.0).level;
            (level, previous_factor(at, top, texels, count))
        })
    }

    /// A mistake in the modified kernels.
    #[derive(Clone, Copy, PartialEq)]
    enum Mistake {
        None,
        /// Every kernel counts as one texel: 4^l is forgotten.
        Area,
        /// The kernel is one level too large.
        Level,
    }

    fn modified(density: &Pyramid<f64>, count: u32, mistake: Mistake) -> Row {
        let (top, texels) = (density.top(), density.texel_count());
        row(density, count, |centre, _| {
            let level = modified_level(density, centre, count, 1.0, 12).level;
            let factor = modified_factor(trilinear(density, centre, level), top, texels, count);
            match mistake {
                Mistake::None => (level, factor),
                Mistake::Area => (level, 1.0),
                Mistake::Level => (level + 1.0, factor),
            }
        })
    }

    #[test]
    fn the_modified_kernels_keep_the_total_and_the_previous_ones_do_not() {
        for (name, stress) in Stress::ALL {
            let density = stress.pyramid(256, 2016).unwrap();
            for count in [64, 1024] {
                let before = previous(&density, count, false);
                let interpolated = previous(&density, count, true);
                let after = modified(&density, count, Mistake::None);
                let centres: Vec<[f64; 2]> = (0..count)
                    .map(|index| warp(&density, lattice::point(index, count)).centre)
                    .collect();
                let share = |kinds: &dyn Fn(&[f64; 2]) -> bool| {
                    centres.iter().filter(|centre| kinds(centre)).count() as f64 / f64::from(count)
                };
                let kinked = share(&|&centre| !is_monotone(&density, centre));
                let rootless =
                    share(&|&centre| kernel_mass(&density, centre, 0.0) > 1.0 / f64::from(count));
                let show = |row: &Row| {
                    format!("{:.3} {:.1} {:.4}", row.total, row.brightest, row.deviation)
                };
                println!(
                    "{name:>12} {count:>4}: previous {}, interpolated {}; modified {}; {kinked:.2} {rootless:.2}",
                    show(&before),
                    show(&interpolated),
                    show(&after),
                );
                if stress == Stress::Zero {
                    continue;
                }
                assert!((after.total - 1.0).abs() < 0.03, "{name} {after:?}");
                // The reflectance is between 0.4 and 0.8: no light may be brighter than that allows.
                assert!(after.brightest <= 2.0, "{name} {after:?}");
                assert!(before.brightest > 10.0 || name == "smooth" || name == "checkerboard");
                if count == 1024 && !matches!(stress, Stress::Smooth) {
                    assert!((before.total - 1.0).abs() > 0.03, "{name} {before:?}");
                }
                // Negative controls.
                let forgotten = modified(&density, count, Mistake::Area);
                assert!((forgotten.total - 1.0).abs() > 0.03, "{name} {forgotten:?}");
                if stress == Stress::Smooth {
                    let shifted = modified(&density, count, Mistake::Level);
                    assert!(after.deviation < 2e-3, "{name} {after:?}");
                    assert!(shifted.deviation > 1.0, "{name} {shifted:?}");
                }
            }
        }
    }

    #[test]
    fn no_mass_gives_no_power_and_no_nan() {
        let density = Stress::Zero.pyramid(16, 0).unwrap();
        let centre = warp(&density, lattice::point(3, 8)).centre;
        let level = modified_level(&density, centre, 8, 1.0, 12).level;
        assert!((level - 4.0).abs() < 1e-3);
        assert_eq!(modified_factor(0.0, 0.0, 256, 8), 0.0);
        assert_eq!(previous_factor(0.0, 0.0, 256, 8), 256.0);
    }
}
