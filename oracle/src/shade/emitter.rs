//! What arrives of a light's diffuse emission, and its diffuse reflection.

use core::f64::consts::PI;

use crate::shade::diffuse::clamped;
use crate::shade::incoming::{extent, variance_at};
use crate::shade::quadratic::cosine_quadratic;
use crate::shade::{Diffuse, Incoming, disc, incoming};
use crate::vsgl::Vsgl;
use crate::{Real, Vector3};

/// How a virtual light emits what its texels reflect diffusely.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Emitter {
    /// As a spherical Gaussian.
    // [Tokuyoshi 2016, Eq. (6)]
    Lobe,
    /// By the mean clamped cosine over its normals; the receiver's cosine is clamped.
    Cosine,
    /// By the mean clamped cosine over its normals; the receiver's cosine is convolved with the light's extent.
    CosineConvolved,
    /// By the mean clamped cosine as a parabola; the receiver's cosine is clamped.
    CosineQuadratic,
    /// By the mean clamped cosine over its normals, from a uniform disc.
    Disc,
}

impl Emitter {
    /// All of them.
    pub const ALL: [Self; 5] =
        [Self::Lobe, Self::Cosine, Self::CosineConvolved, Self::CosineQuadratic, Self::Disc];

    /// The radiance that arrives at a point, without visibility. `diffuse`: the form of the mean cosine; the fitted one
    /// where nothing is reflected diffusely.
    pub fn emitted<R: Real>(
        self,
        point: Vector3<R>,
        light: &Vsgl<R>,
        diffuse: Option<Diffuse>,
    ) -> Incoming<R> {
        if self == Self::Lobe {
            return incoming(point, light.position, light.variance, &light.diffuse);
        }
        let (towards, spread) = extent(light.position - point, light.variance);
        let emission = &light.diffuse;
        let cosine = -towards.dot(emission.axis);
        let integral = if self == Self::CosineQuadratic {
            cosine_quadratic(cosine, emission.sharpness, light.diffuse_mean_length)
        } else {
            diffuse.unwrap_or(Diffuse::Fitted).cosine_integral_mean(
                cosine,
                emission.sharpness,
                light.diffuse_mean_length,
            )
        };
        // 1/pi of a Lambertian emitter, 1/(2 pi variance) of the distribution of positions.
        let squared = (light.position - point).length_squared();
        let scale = R::constant(0.5 / (PI * PI)) * integral / variance_at(squared, light.variance);
        Incoming { axis: towards, sharpness: spread, coefficient: emission.coefficient * scale }
    }

    /// The diffuse reflection per unit reflectance of what [`Self::emitted`] gives of a light; `path`: from the receiver to
    /// the light's position.
    pub fn reflect<R: Real>(
        self,
        diffuse: Diffuse,
        emitted: &Incoming<R>,
        path: Vector3<R>,
        light: &Vsgl<R>,
        normal: Vector3<R>,
    ) -> Vector3<R> {
        let white = Vector3::splat(R::one());
        match self {
            Self::Lobe | Self::CosineConvolved => diffuse.reflect(emitted, white, normal),
            Self::Cosine | Self::CosineQuadratic => clamped(emitted, white, normal),
            Self::Disc => {
                let Vsgl { variance, diffuse_mean_length, .. } = *light;
                let irradiance = disc::irradiance(
                    path,
                    variance,
                    light.diffuse.axis,
                    diffuse_mean_length,
                    normal,
                );
                let variance = variance_at(path.length_squared(), variance);
                emitted.coefficient * (R::constant(2.0) * variance * irradiance)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Linear;
    use crate::brdf::Material;
    use crate::rsm::{Emission, Lobes, Moments, moments};
    use crate::surface::SurfaceTexel;

    fn texel(position: Vector3, normal: Vector3) -> SurfaceTexel {
        let material =
            Material { diffuse: Vector3::splat(1.0), specular: Vector3::zero(), alpha: 1.0 };
        SurfaceTexel { position, normal, material, present: true }
    }

    /// Lights of clusters of texels that emit a power of one in all.
    fn lights(clusters: &[Vec<SurfaceTexel>], emission: &Emission) -> Vec<Vsgl> {
        let count: usize = clusters.iter().map(Vec::len).sum();
        let power = Vector3::splat(1.0 / count as f64);
        let light = |cluster: &Vec<SurfaceTexel>| {
            let texels = cluster
                .iter()
                .map(|surface| moments(surface, power, surface.normal, Vector3::zero(), emission));
            let sum = texels.fold(Moments::nothing(), Moments::plus);
            Vsgl::of_moments(&sum, Vector3::zero(), 1e-9, emission)
        };
        clusters.iter().map(light).collect()
    }

    /// Irradiance over the radiosity of the emitting surface of this area, whose power is one.
    fn received(emitter: Emitter, lights: &[Vsgl], at: &SurfaceTexel, area: f64) -> f64 {
        let sum: f64 = lights
            .iter()
            .map(|light| {
                let emitted = emitter.emitted(at.position, light, Some(Diffuse::Fitted));
                let path = light.position - at.position;
                emitter.reflect(Diffuse::Fitted, &emitted, path, light, at.normal).x
            })
            .sum();
        PI * sum * area
    }

    fn emission(emitter: Emitter) -> Emission {
        match emitter {
            Emitter::Lobe => Emission::printed(Lobes::Diffuse),
            _ => Emission::of_normals(Lobes::Diffuse),
        }
    }

    /// A square of two by two, tilted, in 16 x 16 clusters of 4 x 4 texels.
    fn plane() -> Vec<Vec<SurfaceTexel>> {
        let normal = Vector3::new(0.36, 0.48, 0.8);
        let u = Vector3::new(0.8, -0.6, 0.0);
        let v = normal.cross(u);
        let at = |x: usize, y: usize| {
            let [x, y] = [x, y].map(|step| (step as f64 + 0.5) / 32.0 - 1.0);
            texel(u * x + v * y, normal)
        };
        let cluster = |index: usize| {
            let [x, y] = [4 * (index % 16), 4 * (index / 16)];
            (0..16).map(|inner| at(x + inner % 4, y + inner / 4)).collect()
        };
        (0..256).map(cluster).collect()
    }

    /// The unit sphere, its texels in clusters about the points of a lattice.
    fn sphere(count: usize) -> Vec<Vec<SurfaceTexel>> {
        let lattice = |index: usize, count: usize| {
            let z = 1.0 - 2.0 * (index as f64 + 0.5) / count as f64;
            let angle = 2.399_963_229_728_653 * index as f64;
            let radius = (1.0 - z * z).sqrt();
            Vector3::new(radius * angle.cos(), radius * angle.sin(), z)
        };
        let centres: Vec<Vector3> = (0..count).map(|index| lattice(index, count)).collect();
        let mut clusters = vec![Vec::new(); count];
        for index in 0..16 * count {
            let point = lattice(index, 16 * count);
            let closest =
                (0..count).max_by(|&a, &b| centres[a].dot(point).total_cmp(&centres[b].dot(point)));
            clusters[closest.unwrap()].push(texel(point, point));
        }
        clusters
    }

    #[test]
    fn a_plane_does_not_light_itself() {
        let clusters = plane();
        let worst = |emitter| {
            let lights = lights(&clusters, &emission(emitter));
            let receivers = clusters.iter().flat_map(|cluster| [cluster[0], cluster[5]]);
            receivers.map(|at| received(emitter, &lights, &at, 4.0)).fold(0.0, f64::max)
        };
        for emitter in [Emitter::Cosine, Emitter::CosineQuadratic, Emitter::Disc] {
            assert!(worst(emitter) <= 1e-5, "{emitter:?} {}", worst(emitter));
        }
        // Negative controls: a lobe has its share behind its surface, and a convolved cosine sees a light that lies in
        // its own plane.
        for emitter in [Emitter::Lobe, Emitter::CosineConvolved] {
            println!("{emitter:?} {}", worst(emitter));
            assert!(worst(emitter) > 1e-4, "{emitter:?} {}", worst(emitter));
        }
    }

    #[test]
    fn a_sphere_does_not_light_itself() {
        let clusters = sphere(1024);
        let mean = |received: &dyn Fn(&SurfaceTexel) -> f64| {
            let receivers: Vec<SurfaceTexel> =
                clusters.iter().filter_map(|cluster| cluster.last().copied()).step_by(4).collect();
            receivers.iter().map(received).sum::<f64>() / receivers.len() as f64
        };
        let of = |emitter| {
            let lights = lights(&clusters, &emission(emitter));
            mean(&|at| received(emitter, &lights, at, 4.0 * PI))
        };
        for emitter in [Emitter::Cosine, Emitter::CosineQuadratic, Emitter::Disc] {
            assert!(of(emitter) <= 1e-4, "{emitter:?} {}", of(emitter));
        }
        println!("{} {}", of(Emitter::Lobe), of(Emitter::CosineConvolved));
        // Negative controls: the lobe, and a cluster taken as a ball of normals, whose normals spread with the angle that
        // it is seen under: it converges to nothing.
        assert!(of(Emitter::Lobe) > 0.025);
        let lights = lights(&clusters, &emission(Emitter::Cosine));
        let ball = mean(&|at| {
            let sum: f64 = lights
                .iter()
                .map(|light| {
                    let mut light = *light;
                    let squared = (light.position - at.position).length_squared();
                    let (k, s) = (light.diffuse.sharpness, squared / light.variance);
                    let power = light.diffuse.power();
                    light.diffuse.sharpness = k * s / (k + s + 1.0);
                    light.diffuse.coefficient =
                        power * (1.0 / crate::sg::integral(light.diffuse.sharpness));
                    received(Emitter::CosineConvolved, &[light], at, 4.0 * PI)
                })
                .sum();
            sum
        });
        println!("{ball}");
        assert!(ball > 0.1, "{ball}");
    }

    #[test]
    fn far_away_it_is_a_point_light_with_the_cosine() {
        // Of one normal, at a distance of many radii, on a receiver that is tilted.
        let clusters = vec![plane().concat()];
        let at = texel(Vector3::new(90.0, 10.0, -20.0), Vector3::new(-0.8, 0.0, 0.6));
        let normal = clusters[0][0].normal;
        let towards = (-at.position).normalized();
        let expected = -towards.dot(normal) * towards.dot(at.normal) / at.position.length_squared();
        for emitter in [Emitter::Cosine, Emitter::CosineQuadratic, Emitter::Disc] {
            let lights = lights(&clusters, &emission(emitter));
            let found = received(emitter, &lights, &at, 1.0);
            assert!((found * PI / expected - 1.0).abs() < 2e-3, "{emitter:?} {found} {expected}");
        }
        let lobe = received(Emitter::Lobe, &lights(&clusters, &emission(Emitter::Lobe)), &at, 1.0);
        assert!((lobe * PI / expected - 1.0).abs() > 0.02, "{lobe}");
    }
}
