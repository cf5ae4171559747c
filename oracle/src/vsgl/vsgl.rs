//! A virtual spherical Gaussian light of a cluster's moments.

use crate::rsm::{Emission, Lobes, Moments, Variance};
use crate::sg::integral;
use crate::vmf::{Sharpness, mean_length};
use crate::{Real, Vector3};

/// The greatest mean length of directions: 1 - 2^-20.
pub const MAXIMUM_MEAN_LENGTH: f64 = 1.0 - 1.0 / 1_048_576.0;

/// The luminance of the power below which a cluster has no direction.
pub const LEAST_WEIGHT: f64 = 1e-37;
/// The mean length below which directions cancel.
pub const LEAST_MEAN_LENGTH: f64 = 1e-18;

/// The directions of what a light emits, a spherical Gaussian `coefficient G(w, axis, sharpness)`: of a lobe its radiant
/// intensity, of an emitter by the cosine the power by normals.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lobe<R = f64> {
    /// Unit axis; +z where the directions cancel.
    pub axis: Vector3<R>,
    /// Sharpness, 0 to 2^20 - 1.
    pub sharpness: R,
    /// The power over the integral of a lobe of this sharpness, at least 0: of a lobe the radiant intensity along the
    /// axis.
    pub coefficient: Vector3<R>,
}

/// A virtual spherical Gaussian light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Vsgl<R = f64> {
    /// Mean position in the world.
    pub position: Vector3<R>,
    /// Variance of the positions, at least the minimum.
    pub variance: R,
    /// The diffuse emission.
    pub diffuse: Lobe<R>,
    /// The mean length of directions of the diffuse emission's sharpness.
    pub diffuse_mean_length: R,
    /// The specular lobe, with [`Lobes::Both`].
    pub specular: Option<Lobe<R>>,
}

impl<R: Real> Lobe<R> {
    /// Of a power and the sum of mean directions times weights, which are the power's luminance, and of the weights.
    // [Tokuyoshi 2016, Appendix B.1]
    #[must_use]
    pub fn of_moments(
        power: Vector3<R>,
        direction: Vector3<R>,
        weight: R,
        sharpness: Sharpness,
    ) -> Self {
        // Before the length is taken, whose square would leave the range of f32 for weak and strong lights.
        let mut mean = Vector3::zero();
        if weight.value() > LEAST_WEIGHT {
            mean = direction.map(|part| part / weight);
        }
        if mean.length().value() <= LEAST_MEAN_LENGTH {
            mean = Vector3::zero();
        }
        let length = mean.length().min(R::constant(MAXIMUM_MEAN_LENGTH));
        let [sharpness, share] = Self::of_length(length, sharpness);
        Self { axis: mean.normalized(), sharpness, coefficient: power * share }
    }

    /// The sharpness of a mean length and one over the integral of a lobe of it. Where rounding decides whether the length
    /// is above the greatest one, the tolerances are those of both ends: an interval about the greatest one would reach
    /// beyond it, where sharpness has no end.
    fn of_length(length: R, form: Sharpness) -> [R; 2] {
        let of = |length: R| {
            let sharpness = form.of(length, R::one() - length);
            [sharpness, R::one() / integral(sharpness)]
        };
        if length.value() + length.error() <= MAXIMUM_MEAN_LENGTH {
            return of(length);
        }
        let [lowest, length, greatest] =
            [(length.value() - length.error()).max(0.0), length.value(), MAXIMUM_MEAN_LENGTH]
                .map(|length| of(R::constant(length)));
        core::array::from_fn(|at| length[at].cover(lowest[at]).cover(greatest[at]))
    }

    /// The power that the lobe emits: `c A(l)`.
    #[must_use]
    pub fn power(&self) -> Vector3<R> {
        self.coefficient * integral(self.sharpness)
    }
}

impl<R: Real> Vsgl<R> {
    /// Of the summed moments of a cluster. A cluster without weight gives a light without power at `origin`.
    // [Tokuyoshi 2016, Appendix B]
    #[must_use]
    pub fn of_moments(
        total: &Moments<R>,
        origin: Vector3<R>,
        minimum_variance: f64,
        emission: &Emission,
    ) -> Self {
        let weight = total.weight();
        let (mean, square) = if weight.value() > 0.0 {
            (total.vector(0).map(|part| part / weight), total.squared_position() / weight)
        } else {
            (Vector3::zero(), R::zero())
        };
        let part = match emission.variance {
            Variance::Trace => R::one(),
            Variance::Planar => R::constant(0.5),
        };
        let variance = (square - mean.length_squared()) * part;
        let lobe = |power, direction, weight| {
            Lobe::of_moments(power, direction, weight, emission.sharpness)
        };
        let diffuse = lobe(total.vector(1), total.vector(2), total.layers[2][3]);
        Self {
            position: origin + mean,
            variance: variance.max(R::constant(minimum_variance)),
            diffuse,
            diffuse_mean_length: mean_length(diffuse.sharpness),
            specular: (emission.lobes == Lobes::Both).then(|| {
                let power = total.specular_power();
                lobe(power, total.vector(4), power.luminance())
            }),
        }
    }

    /// The power of all its lobes.
    #[must_use]
    pub fn power(&self) -> Vector3<R> {
        self.specular.iter().fold(self.diffuse.power(), |sum, lobe| sum + lobe.power())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::brdf::Material;
    use crate::rsm::moments;
    use crate::surface::SurfaceTexel;
    use crate::{Bounded, Linear};

    fn texel(position: Vector3, normal: Vector3) -> Moments {
        let material = Material {
            diffuse: Vector3::new(0.5, 0.4, 0.3),
            specular: Vector3::splat(0.04),
            alpha: 0.1,
        };
        let surface =
            SurfaceTexel { position, normal: normal.normalized(), material, present: true };
        let towards = Vector3::new(0.0, 1.0, 0.2).normalized();
        moments(
            &surface,
            Vector3::new(1.0, 2.0, 3.0),
            towards,
            Vector3::zero(),
            &Emission::printed(Lobes::Both),
        )
    }

    #[test]
    fn one_texel_gives_back_its_lobes() {
        let normal = Vector3::new(0.0, 0.8, 0.6);
        let light = Vsgl::of_moments(
            &texel(Vector3::new(1.0, 2.0, 3.0), normal),
            Vector3::zero(),
            1e-8,
            &Emission::printed(Lobes::Both),
        );
        assert!((light.position - Vector3::new(1.0, 2.0, 3.0)).length() < 1e-14);
        assert_eq!(light.variance, 1e-8);
        assert!((light.diffuse.axis - normal).length() < 1e-14);
        assert!((light.diffuse.sharpness - 2.0).abs() < 1e-13);
        let specular = light.specular.unwrap();
        let towards = Vector3::new(0.0, 1.0, 0.2).normalized();
        assert!((specular.axis - towards.mirrored(normal)).length() < 1e-14);
        assert!((specular.sharpness / (50.0 / towards.dot(normal)) - 1.0).abs() < 1e-9);
        // c A = Phi R, for each channel.
        let power = Vector3::new(0.5 + 0.04, 2.0 * 0.44, 3.0 * 0.34);
        assert!((light.power() - power).length() < 1e-13);
    }

    #[test]
    fn a_lobe_does_not_depend_on_the_unit_of_power() {
        let power = Vector3::new(1.0, 2.0, 3.0);
        let direction = Vector3::new(0.3, -0.6, 0.9);
        let expected = Lobe::of_moments(power, direction, power.luminance(), Sharpness::Toksvig);
        for scale in [1e-30, 1e-20, 1e20, 1e35] {
            let bounded = |vector: Vector3| Vector3::constant(vector * scale);
            let (power, direction) = (bounded(power), bounded(direction));
            let weight: Bounded = power.luminance();
            let lobe = Lobe::of_moments(power, direction, weight, Sharpness::Toksvig);
            assert!((lobe.sharpness.value / expected.sharpness - 1.0).abs() < 1e-12);
            // The promise is that of f32: finite and as narrow as at the scale 1.
            assert!(lobe.sharpness.error < 1e-5 * lobe.sharpness.value, "{scale} {lobe:?}");
            assert!(lobe.axis.y.error < 1e-5 && lobe.coefficient.x.promises());
        }
        // Negative control: the length of the sum itself leaves f32.
        assert!(Vector3::<Bounded>::constant(direction * 1e-20).length().error > 1e-21);
        assert!(!Vector3::<Bounded>::constant(direction * 1e20).length().promises());
    }

    #[test]
    fn clusters_add_up() {
        let (a, b) = (Vector3::new(1.0, 0.0, 0.0), Vector3::new(-1.0, 0.0, 0.0));
        let normals = [Vector3::new(0.0, 1.0, 0.3), Vector3::new(0.0, 1.0, -0.3)];
        let total = texel(a, normals[0]).plus(texel(b, normals[1]));
        let light =
            Vsgl::of_moments(&total, Vector3::zero(), 1e-8, &Emission::printed(Lobes::Both));
        assert!(light.position.length() < 1e-15 && (light.variance - 1.0).abs() < 1e-14);
        assert!((light.diffuse.axis - Vector3::new(0.0, 1.0, 0.0)).length() < 1e-14);
        assert!(light.diffuse.sharpness < 2.0);
        let apart = [texel(a, normals[0]), texel(b, normals[1])].map(|texel| {
            Vsgl::of_moments(&texel, Vector3::zero(), 1e-8, &Emission::printed(Lobes::Both)).power()
        });
        assert!((light.power() - apart[0] - apart[1]).length() < 1e-13);
    }

    #[test]
    fn nothing_gives_a_dark_light() {
        let light = Vsgl::of_moments(
            &Moments::<f64>::nothing(),
            Vector3::splat(5.0),
            1e-6,
            &Emission::printed(Lobes::Diffuse),
        );
        assert_eq!(light.power(), Vector3::zero());
        assert_eq!(
            (light.position, light.variance, light.specular),
            (Vector3::splat(5.0), 1e-6, None)
        );
    }

    #[test]
    fn the_tolerance_knows_of_a_variance_that_cancels() {
        // A cluster of the size 1e-2 at a distance from the origin.
        let light = |distance: f64| {
            let total = texel(Vector3::new(distance, 0.0, 0.0), Vector3::splat(1.0))
                .plus(texel(Vector3::new(distance + 0.01, 0.0, 0.0), Vector3::splat(1.0)));
            let rounded =
                Moments { layers: total.layers.map(|layer| layer.map(Bounded::constant)) };
            Vsgl::of_moments(&rounded, Vector3::zero(), 1e-8, &Emission::printed(Lobes::Both))
                .variance
        };
        assert!(light(0.1).error < 1e-3 * light(0.1).value);
        assert!(light(1000.0).error > light(1000.0).value);
    }
}
