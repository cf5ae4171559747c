//! One kernel's light: lattice, warp, level, filter, moments.

use crate::fis::{self, Level, Warped, lattice, trilinear, warp};
use crate::rsm::{Emission, Moments, Pyramid};
use crate::vsgl::Vsgl;
use crate::{Linear, Real, Vector3};

/// How the size of a kernel is found.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Kernel {
    /// From the density at the centre: Eq. (1) and Eq. (4).
    Previous,
    /// From the density's integral within the kernel: Eq. (3) and Eq. (5).
    Modified(Solver),
}

/// How Eq. (3) is solved.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Solver {
    /// By bisection.
    Bisection {
        /// Number of bisections of Algorithm 1; 12 in the paper.
        iterations: u32,
    },
    /// Between two integer levels around the root.
    Bracketed,
}

/// The level of a modified kernel.
pub fn level_by<R: Real>(
    solver: Solver,
    density: &Pyramid<R>,
    centre: [R; 2],
    texel: [usize; 2],
    settings: &Settings,
) -> Level<R> {
    let Settings { count, scale, .. } = *settings;
    match solver {
        Solver::Bisection { iterations } => {
            fis::modified_level(density, centre, count, scale, iterations)
        }
        Solver::Bracketed => fis::bracketed_level(density, centre, texel, count, scale).level,
    }
}

/// What a set of kernels has in common.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Number of kernels N, at least 1.
    pub count: u32,
    /// How the size of a kernel is found.
    pub kernel: Kernel,
    /// The parameter K, above 0; 1 in the paper.
    pub scale: f64,
    /// What positions in the moments are relative to.
    pub origin: Vector3,
    /// The least variance of a light, above 0, in squared units of length.
    pub minimum_variance: f64,
    /// What is emitted.
    pub emission: Emission,
}

/// A kernel and its light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample<R = f64> {
    /// Where the kernel lies.
    pub warped: Warped<R>,
    /// How large it is.
    pub level: Level<R>,
    /// The light.
    pub light: Vsgl<R>,
}

/// The kernel and light of an index below `settings.count`.
pub fn sample<R: Real>(
    index: u32,
    density: &Pyramid<R>,
    moments: &Pyramid<Moments<R>>,
    settings: &Settings,
) -> Sample<R> {
    let warped = warp(density, lattice::point(index, settings.count));
    let [x, y] = warped.texel;
    let level = match settings.kernel {
        Kernel::Previous => {
            let texels = density.texel_count();
            fis::previous_level(
                density.at(0, x, y),
                density.top(),
                texels,
                settings.count,
                settings.scale,
            )
        }
        Kernel::Modified(solver) => {
            level_by(solver, density, warped.centre, warped.texel, settings)
        }
    };
    let light =
        light_of_kernel(density, moments, warped.centre, warped.texel, level.level, settings);
    Sample { warped, level, light }
}

/// The light of a kernel whose centre, texel and level are given, such as read back from a GPU.
pub fn light_of_kernel<R: Real>(
    density: &Pyramid<R>,
    moments: &Pyramid<Moments<R>>,
    centre: [R; 2],
    [x, y]: [usize; 2],
    level: R,
    settings: &Settings,
) -> Vsgl<R> {
    let (top, texels) = (density.top(), density.texel_count());
    let factor = match settings.kernel {
        Kernel::Previous => fis::previous_factor(density.at(0, x, y), top, texels, settings.count),
        Kernel::Modified(_) => {
            fis::modified_factor(trilinear(density, centre, level), top, texels, settings.count)
        }
    };
    let total = trilinear(moments, centre, level).scaled(factor);
    Vsgl::of_moments(
        &total,
        Vector3::constant(settings.origin),
        settings.minimum_variance,
        &settings.emission,
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::brdf::Material;
    use crate::fis::stress::Stress;
    use crate::rsm::{self, Lobes, Weights};
    use crate::surface::SurfaceTexel;

    /// A wall whose photons follow a stress density.
    fn wall(stress: Stress, size: usize) -> Pyramid<Moments> {
        let material = Material {
            diffuse: Vector3::new(0.6, 0.5, 0.4),
            specular: Vector3::splat(0.1),
            alpha: 0.2,
        };
        let texels = stress.texels(size, 11).into_iter().enumerate().map(|(index, power)| {
            let position = Vector3::new((index % size) as f64, (index / size) as f64, 0.0)
                * (1.0 / size as f64);
            let normal = Vector3::new(0.0, 0.0, 1.0);
            let surface = SurfaceTexel { position, normal, material, present: true };
            let towards = Vector3::new(0.3, 0.2, 1.0).normalized();
            rsm::moments(
                &surface,
                Vector3::splat(f64::from(power)),
                towards,
                Vector3::zero(),
                &Emission::printed(Lobes::Both),
            )
        });
        Pyramid::build(size, texels.collect()).unwrap()
    }

    fn relative_power(stress: Stress, kernel: Kernel, break_factor: bool) -> f64 {
        let moments = wall(stress, 128);
        let density =
            Pyramid::build(128, moments.level(0).iter().map(crate::density::power).collect())
                .unwrap();
        let settings = Settings {
            count: 256,
            kernel,
            scale: 1.0,
            origin: Vector3::zero(),
            minimum_variance: 1e-8,
            emission: Emission::printed(Lobes::Both),
        };
        let total: f64 = (0..settings.count)
            .map(|index| {
                let sample = sample(index, &density, &moments, &settings);
                let factor = if break_factor { 0.25_f64.powf(sample.level.level) } else { 1.0 };
                sample.light.power().y * factor
            })
            .sum();
        let expected: f64 =
            moments.level(0).iter().map(|texel| texel.layers[1][1] + texel.layers[3][1]).sum();
        total / expected
    }

    #[test]
    fn the_lights_of_a_smooth_density_carry_its_power() {
        for kernel in [
            Kernel::Previous,
            Kernel::Modified(Solver::Bisection { iterations: 12 }),
            Kernel::Modified(Solver::Bracketed),
        ] {
            let power = relative_power(Stress::Smooth, kernel, false);
            assert!((power - 1.0).abs() < 5e-3, "{kernel:?} {power}");
            // Negative control: without the factor 4^l.
            assert!((relative_power(Stress::Smooth, kernel, true) - 1.0).abs() > 0.5);
        }
    }

    #[test]
    fn the_modified_lights_of_a_ring_carry_its_power() {
        for solver in [Solver::Bisection { iterations: 12 }, Solver::Bracketed] {
            let modified = relative_power(Stress::Ring, Kernel::Modified(solver), false);
            assert!(
                (modified - 1.0).abs() < 1e-9,
                "density and power share the kernel: {modified}"
            );
        }
    }

    /// What a sampler's weights do to lights: as bits are added they come to those of exact weights.
    #[test]
    fn lights_of_hardware_s_weights_are_near_those_of_exact_ones() {
        let moments = wall(Stress::Noise { sigma: 2.0 }, 64);
        let density =
            Pyramid::build(64, moments.level(0).iter().map(crate::density::power).collect())
                .unwrap();
        let settings = Settings {
            count: 64,
            kernel: Kernel::Modified(Solver::Bracketed),
            scale: 1.0,
            origin: Vector3::zero(),
            minimum_variance: 1e-8,
            emission: Emission::printed(Lobes::Both),
        };
        // Root mean square over the kernels: of the level, and of the position on the wall, which is 1 wide.
        let off = |weights: Weights| {
            let (coarse_density, coarse_moments) =
                (density.clone().sampled_by(weights), moments.clone().sampled_by(weights));
            let mut squares = [0.0; 2];
            for index in 0..settings.count {
                let one = sample(index, &density, &moments, &settings);
                let other = sample(index, &coarse_density, &coarse_moments, &settings);
                let place = (other.light.position - one.light.position).length();
                // Density and power are read by the same weights, so that what a light carries stays.
                assert!((other.light.power().y / one.light.power().y - 1.0).abs() < 1e-12);
                let level = other.level.level - one.level.level;
                squares = [squares[0] + level * level, squares[1] + place * place];
            }
            squares.map(|square| (square / f64::from(settings.count)).sqrt())
        };
        assert_eq!(off(Weights::Exact), [0.0; 2]);
        let bits = |bits: u32| off(Weights::Fixed { texel_bits: bits, mip_bits: bits });
        let found = [4, 8, 12, 23].map(bits);
        println!("off by {found:?}");
        assert_eq!(bits(8), off(Weights::HARDWARE));
        for pair in found.windows(2) {
            assert!(pair[1][0] < pair[0][0] && pair[1][1] < pair[0][1], "{found:?}");
        }
        // 8 bits are off by a half of 2^-8 of neighbouring texels, which differ by about themselves.
        assert!(found[1][0] > 1e-4 && found[1][0] < 0.02, "{found:?}");
        assert!(found[3][0] < 1e-6 && found[3][1] < 1e-6, "{found:?}");
    }
}
