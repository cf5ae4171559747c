//! Densities that are hard on filtering kernels; the same for everybody.

use crate::rsm::{Pyramid, PyramidError};

/// A small generator of random numbers: PCG with 64 bits of state and 32 bits of output.
// [O'Neill 2014, PCG: A family of simple fast space-efficient statistically good algorithms], XSH-RR
#[derive(Clone, Debug)]
pub struct Random {
    state: u64,
}

impl Random {
    /// The generator of a seed.
    #[must_use]
    pub fn new(seed: u64) -> Self {
        let mut random = Self { state: seed.wrapping_add(1_442_695_040_888_963_407) };
        random.bits();
        random
    }

    /// The next 32 bits.
    pub fn bits(&mut self) -> u32 {
        let old = self.state;
        self.state =
            old.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        #[expect(
            clippy::cast_possible_truncation,
            reason = "the generator is defined by these truncations"
        )]
        let (shifted, rotation) = ((((old >> 18) ^ old) >> 27) as u32, (old >> 59) as u32);
        shifted.rotate_right(rotation)
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

    /// What the kernels of a density make of it.
    #[derive(Debug)]
    struct Row {
        total: f64,
        brightest: f64,
        variation: f64,
    }

    fn row(
        density: &Pyramid<f64>,
        count: u32,
        kernel: impl Fn([f64; 2], [usize; 2]) -> (f64, f64),
    ) -> Row {
        let whole = density.top() * density.texel_count() as f64;
        let kernels: Vec<(f64, f64)> = (0..count)
            .map(|index| {
                let warped = warp(density, lattice::point(index, count));
                let (level, factor) = kernel(warped.centre, warped.texel);
                let power = factor * trilinear(density, warped.centre, level) / whole;
                (power, f64::from(count) * kernel_mass(density, warped.centre, level))
            })
            .collect();
        let n = f64::from(count);
        let mean = kernels.iter().map(|kernel| kernel.1).sum::<f64>() / n;
        let variance = kernels.iter().map(|kernel| (kernel.1 - mean).powi(2)).sum::<f64>() / n;
        Row {
            total: kernels.iter().map(|kernel| kernel.0).sum(),
            brightest: kernels.iter().map(|kernel| kernel.0 * n).fold(0.0, f64::max),
            variation: variance.sqrt() / mean,
        }
    }

    fn previous(density: &Pyramid<f64>, count: u32) -> Row {
        let (top, texels) = (density.top(), density.texel_count());
        row(density, count, |_, [x, y]| {
            let at = density.at(0, x, y);
            (
                previous_level(at, top, texels, count, 1.0).level,
                previous_factor(at, top, texels, count),
            )
        })
    }

    fn modified(density: &Pyramid<f64>, count: u32, scale_area: bool) -> Row {
        let (top, texels) = (density.top(), density.texel_count());
        row(density, count, |centre, _| {
            let level = modified_level(density, centre, count, 1.0, 12).level;
            let filtered = trilinear(density, centre, level);
            // With `scale_area` off the kernel's area is forgotten: every kernel counts as one texel.
            let factor =
                if scale_area { modified_factor(filtered, top, texels, count) } else { 1.0 };
            (level, factor)
        })
    }

    #[test]
    fn the_modified_kernels_keep_the_total_and_the_previous_ones_do_not() {
        for (name, stress) in Stress::ALL {
            let density = stress.pyramid(256, 2016).unwrap();
            if stress == Stress::Zero {
                continue;
            }
            let (before, after) = (previous(&density, 1024), modified(&density, 1024, true));
            let centres = (0..1024).map(|index| warp(&density, lattice::point(index, 1024)).centre);
            let centres: Vec<[f64; 2]> = centres.collect();
            let kinked = centres.iter().filter(|&&centre| !is_monotone(&density, centre)).count();
            let rootless = centres
                .iter()
                .filter(|&&centre| kernel_mass(&density, centre, 0.0) > 1.0 / 1024.0)
                .count();
            println!(
                "{name:>12}: previous {:.3} {:.1} {:.3}; modified {:.4} {:.2} {:.4}; not monotone {:.2}, no root {:.2}",
                before.total,
                before.brightest,
                before.variation,
                after.total,
                after.brightest,
                after.variation,
                kinked as f64 / 1024.0,
                rootless as f64 / 1024.0,
            );
        }
    }
}
