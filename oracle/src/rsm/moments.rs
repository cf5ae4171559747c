//! What a texel adds to the virtual spherical Gaussian light of its kernel.

use crate::brdf::{Material, albedo, reflection};
use crate::surface::SurfaceTexel;
use crate::vmf::Sharpness;
use crate::{Linear, Real, Vector3};

/// The lobes that a virtual spherical Gaussian light emits.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Lobes {
    /// Diffuse alone: three layers.
    Diffuse,
    /// Diffuse and specular: five layers.
    Both,
}

impl Lobes {
    /// The number of layers of moments.
    #[must_use]
    pub fn layers(self) -> usize {
        match self {
            Self::Diffuse => 3,
            Self::Both => 5,
        }
    }
}

/// The specular power of a virtual light, as a share of the photon's.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum SpecularPower {
    /// The specular reflectance at normal incidence.
    #[default]
    F0,
    /// The directional albedo of GGX with Fresnel's term towards the light.
    Albedo,
}

impl SpecularPower {
    /// The surface with that share, from the unit direction towards the light, as its specular reflectance: what moments and
    /// densities of a light with this power take.
    #[must_use]
    pub fn reflecting<R: Real>(
        self,
        surface: &SurfaceTexel<R>,
        towards_light: Vector3<R>,
    ) -> SurfaceTexel<R> {
        let Material { specular, alpha, .. } = surface.material;
        let specular = match self {
            Self::F0 => specular,
            Self::Albedo => albedo::directional(specular, towards_light.dot(surface.normal), alpha),
        };
        SurfaceTexel { material: Material { specular, ..surface.material }, ..*surface }
    }
}

/// Sharpness of the diffuse lobe: the least-squares fit of the paper.
// [Tokuyoshi 2016, Appendix A.1]
pub const DIFFUSE_SHARPNESS: f64 = 2.0;

/// The variance of a light's positions.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Variance {
    /// The trace of their covariance.
    // [Tokuyoshi 2016, Appendix B.2]
    Trace,
    /// Half of it: the variance along each axis of a plane.
    Planar,
}

/// What a texel emits, and how a light is made of the moments of several.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Emission {
    /// The lobes that are emitted.
    pub lobes: Lobes,
    /// Length of the mean direction of a texel's diffuse emission, 0 to 1: of its lobe, or 1 for the normal itself.
    pub diffuse_mean_length: f64,
    /// How the sharpness of a light's directions follows from their mean.
    pub sharpness: Sharpness,
    /// The variance of a light's positions.
    pub variance: Variance,
}

impl Emission {
    /// As the papers print it: a lobe of sharpness 2, by Toksvig, with the trace of the covariance.
    // [Tokuyoshi 2016, Eq. (6), Appendix B]
    #[must_use]
    pub fn printed(lobes: Lobes) -> Self {
        Self {
            lobes,
            diffuse_mean_length: DIFFUSE_SHARPNESS / (DIFFUSE_SHARPNESS + 1.0),
            sharpness: Sharpness::Toksvig,
            variance: Variance::Trace,
        }
    }

    /// The distribution of normals, for emission by the cosine about them.
    #[must_use]
    pub fn of_normals(lobes: Lobes) -> Self {
        Self {
            lobes,
            diffuse_mean_length: 1.0,
            sharpness: Sharpness::Exact,
            variance: Variance::Trace,
        }
    }
}

/// The moments of a texel, or sums and means of them; layers as in the conventions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Moments<R = f64> {
    /// Position, diffuse power, diffuse direction and its weight, specular power, specular direction; xyzw each. Where powers are held in
    /// halves, the last w is the luminance of the specular power in f32; else it is 0.
    pub layers: [[R; 4]; 5],
}

impl<R: Real> Moments<R> {
    /// The first three numbers of a layer.
    #[must_use]
    pub fn vector(&self, layer: usize) -> Vector3<R> {
        let [x, y, z, _] = self.layers[layer];
        Vector3::new(x, y, z)
    }
    /// Sum of the weights: layer 1's w.
    #[must_use]
    pub fn weight(&self) -> R {
        self.layers[1][3]
    }
    /// Sum of the weights times the squared distance to the origin: layer 0's w.
    #[must_use]
    pub fn squared_position(&self) -> R {
        self.layers[0][3]
    }
    /// The specular power, its luminance mended where halves have rounded it and f32 has kept it.
    #[must_use]
    pub fn specular_power(&self) -> Vector3<R> {
        let (power, weight) = (self.vector(3), self.layers[4][3]);
        if weight.value() == 0.0 {
            return power;
        }
        let luminance = power.luminance();
        if luminance.value() > 0.0 { power * (weight / luminance) } else { Vector3::splat(weight) }
    }
    /// With the luminance of the specular power kept apart, as it is beside halves.
    #[must_use]
    pub fn with_specular_weight(mut self) -> Self {
        self.layers[4][3] = self.vector(3).luminance();
        self
    }
    /// What remains where powers and diffuse directions, in a unit of power, are held in halves.
    #[must_use]
    pub fn to_half(mut self, unit: f64) -> Self {
        for (index, layer) in self.layers.iter_mut().enumerate().take(4).skip(1) {
            // The weight beside the diffuse direction is rounded with it.
            let count = if index == 2 { 4 } else { 3 };
            for value in &mut layer[..count] {
                *value = (*value / R::constant(unit)).to_half() * R::constant(unit);
            }
        }
        self
    }
    /// Read from texels; exact. Absent layers are zero.
    #[must_use]
    pub fn of_texels(texels: &[[f32; 4]]) -> Self {
        let mut moments = Self::nothing();
        for (layer, texel) in moments.layers.iter_mut().zip(texels) {
            *layer = texel.map(|value| R::constant(f64::from(value)));
        }
        moments
    }
}

impl<R: Real> Linear<R> for Moments<R> {
    fn nothing() -> Self {
        Self { layers: [[R::zero(); 4]; 5] }
    }
    fn plus(self, other: Self) -> Self {
        self.zip(other, |a, b| a + b)
    }
    fn scaled(self, factor: R) -> Self {
        Self { layers: self.layers.map(|layer| layer.map(|value| value * factor)) }
    }
    fn covering(self, other: Self) -> Self {
        self.zip(other, R::cover)
    }
}

impl<R: Real> Moments<R> {
    fn zip(mut self, other: Self, join: impl Fn(R, R) -> R) -> Self {
        for (layer, others) in self.layers.iter_mut().zip(other.layers) {
            for (value, right) in layer.iter_mut().zip(others) {
                *value = join(*value, right);
            }
        }
        self
    }
}

/// The moments of a texel: of a surface, the power of its photon, the unit direction towards the light, and the
/// position that positions are relative to. Zero where there is no surface.
// [Tokuyoshi 2016, Appendix B]
pub fn moments<R: Real>(
    surface: &SurfaceTexel<R>,
    power: Vector3<R>,
    towards_light: Vector3<R>,
    origin: Vector3<R>,
    emission: &Emission,
) -> Moments<R> {
    let mut moments = Moments::nothing();
    if !surface.present {
        return moments;
    }
    let Material { diffuse, specular, alpha } = surface.material;
    let texel = |vector: Vector3<R>, w: R| [vector.x, vector.y, vector.z, w];
    let weight = match emission.lobes {
        Lobes::Diffuse => power.times(diffuse).luminance(),
        Lobes::Both => power.times(diffuse + specular).luminance(),
    };
    let position = surface.position - origin;
    moments.layers[0] = texel(position * weight, weight * position.length_squared());

    let diffuse_power = power.times(diffuse);
    moments.layers[1] = texel(diffuse_power, weight);
    let diffuse_length = R::constant(emission.diffuse_mean_length);
    moments.layers[2] = texel(
        surface.normal * (diffuse_power.luminance() * diffuse_length),
        diffuse_power.luminance(),
    );

    if emission.lobes == Lobes::Both {
        let specular_power = power.times(specular);
        let lobe = reflection::mirror(towards_light, surface.normal, alpha);
        let length = emission.sharpness.mean_length(lobe.sharpness);
        moments.layers[3] = texel(specular_power, R::zero());
        moments.layers[4] = texel(lobe.axis * (specular_power.luminance() * length), R::zero());
    }
    moments
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Bounded;

    fn surface<R: Real>(present: f32) -> SurfaceTexel<R> {
        SurfaceTexel::decode([1.0, 0.5, -2.0, present], [0.0, 0.6, 0.8, 0.2], [0.7, 0.4, 0.1, 0.25])
    }

    #[test]
    fn layers_follow_the_conventions() {
        let (power, origin) = (Vector3::new(3.0, 2.0, 1.0), Vector3::new(1.0, 0.0, -2.0));
        let towards = Vector3::new(0.0, 0.0, 1.0);
        let surface = surface::<f64>(0.04);
        let both = moments(&surface, power, towards, origin, &Emission::printed(Lobes::Both));
        let expected =
            power.times(surface.material.diffuse + surface.material.specular).luminance();
        assert!((both.weight() - expected).abs() < 1e-14);
        assert!((both.vector(0) - Vector3::new(0.0, 0.5 * expected, 0.0)).length() < 1e-14);
        assert!((both.squared_position() - 0.25 * expected).abs() < 1e-14);
        // The mirror of +z about (0, .6, .8) is (0, .96, .28); sharpness 50/(4 * .8).
        let length = both.vector(4).length() / both.vector(3).luminance();
        assert!((length - 15.625 / 16.625).abs() < 1e-6);
        assert!((both.vector(4).normalized() - Vector3::new(0.0, 0.96, 0.28)).length() < 1e-6);

        let diffuse = moments(&surface, power, towards, origin, &Emission::printed(Lobes::Diffuse));
        assert_eq!(diffuse.layers[3..], [[0.0; 4]; 2]);
        assert!(diffuse.weight() < both.weight());
        let absent = moments(
            &self::surface::<f64>(-1.0),
            power,
            towards,
            origin,
            &Emission::printed(Lobes::Both),
        );
        assert_eq!(absent, Moments::nothing());
    }

    #[test]
    fn the_albedo_makes_lights_brighter_at_grazing_angles() {
        let (power, origin) = (Vector3::new(3.0, 2.0, 1.0), Vector3::zero());
        let surface = surface::<f64>(0.04);
        let weight = |model: SpecularPower, towards: Vector3| {
            let surface = model.reflecting(&surface, towards);
            let moments =
                moments(&surface, power, towards, origin, &Emission::printed(Lobes::Both));
            let expected = power.times(surface.material.diffuse + surface.material.specular);
            assert!((moments.weight() - expected.luminance()).abs() < 1e-14);
            // The direction is that of the same lobe: only its power is another.
            let mean = moments.vector(4) * (1.0 / moments.vector(3).luminance());
            (moments.vector(3).luminance(), mean)
        };
        let facing = Vector3::new(0.0, 0.6, 0.8);
        let grazing = Vector3::new(0.9997, 0.0, 0.03).normalized();
        for (towards, low, high) in [(facing, 0.9, 1.01), (grazing, 1.2, 2.5)] {
            let [(f0, mean), (albedo, other)] =
                [SpecularPower::F0, SpecularPower::Albedo].map(|model| weight(model, towards));
            assert!((mean - other).length() < 1e-12);
            assert!((low..high).contains(&(albedo / f0)), "{}", albedo / f0);
        }
        // What has no specular reflectance has none at any angle.
        let black = Material { specular: Vector3::zero(), ..surface.material };
        let black = SurfaceTexel { material: black, ..surface };
        assert_eq!(SpecularPower::Albedo.reflecting(&black, grazing), black);
    }

    #[test]
    fn tolerances_are_a_few_ulp() {
        let constant = |x: f64, y: f64, z: f64| Vector3::<Bounded>::constant(Vector3::new(x, y, z));
        let bounded = moments(
            &surface::<Bounded>(0.04),
            constant(3.0, 2.0, 1.0),
            constant(0.0, 0.0, 1.0),
            constant(1.0, 0.0, -2.0),
            &Emission::printed(Lobes::Both),
        );
        for layer in bounded.layers {
            let magnitude: f64 = layer.iter().map(|value| value.value.abs()).sum();
            for value in layer {
                assert!(value.error <= 6e-6 * magnitude, "{value:?}");
            }
        }
    }
}
