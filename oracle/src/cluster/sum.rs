//! The light of each cluster: the sum of its texels.

use crate::light::{FaceTexel, Lights};
use crate::rsm::{Emission, Moments, SpecularPower, moments};
use crate::surface::SurfaceTexel;
use crate::vsgl::Vsgl;
use crate::{Linear, Real, Vector3};

/// A light's map and what its moments are made with.
#[derive(Clone, Copy, Debug)]
pub struct Map<'a, R> {
    /// Its texels, row by row.
    pub texels: &'a [SurfaceTexel<R>],
    /// Its width and height.
    pub size: [usize; 2],
    /// Its light, or its lights.
    pub light: Lights<'a>,
    /// What positions are relative to while they are summed.
    pub origin: Vector3,
    /// The least variance of a light, above 0, in squared units of length.
    pub minimum_variance: f64,
    /// What is emitted.
    pub emission: Emission,
    /// The power of specular lobes.
    pub specular_power: SpecularPower,
}

/// The lights of `count` clusters, where `assignment` has the cluster of each texel; one of a number beyond is left out.
///
/// Each is a sum in the order of its texels. A cluster of none gives a light without power at the origin.
// [Tokuyoshi 2016, Appendix B, Appendix D]
pub fn lights<R: Real>(map: &Map<'_, R>, assignment: &[u32], count: usize) -> Vec<Vsgl<R>> {
    let origin = Vector3::constant(map.origin);
    let mut totals = vec![Moments::nothing(); count];
    for (index, (surface, &cluster)) in map.texels.iter().zip(assignment).enumerate() {
        let Some(total) = totals.get_mut(cluster as usize) else { continue };
        let at = [index % map.size[0], index / map.size[0]];
        let Some(FaceTexel { light, texel, size }) = map.light.at(at, map.size) else { continue };
        let power: Vector3<R> = light.photon_power(texel, size);
        let (towards, _) = light.towards(surface.position);
        let surface = map.specular_power.reflecting(surface, towards);
        *total = total.plus(moments(&surface, power, towards, origin, &map.emission));
    }
    totals
        .iter()
        .map(|total| Vsgl::of_moments(total, origin, map.minimum_variance, &map.emission))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::light::{Light, LightKind};
    use crate::rsm::Lobes;

    #[test]
    fn however_texels_are_clustered_their_power_stays() {
        let light = Light {
            kind: LightKind::Directional { half_extent: 1.0 },
            position: Vector3::new(0.0, 2.0, 0.0),
            right: Vector3::new(1.0, 0.0, 0.0),
            up: Vector3::new(0.0, 0.0, -1.0),
            forward: Vector3::new(0.0, -1.0, 0.0),
            intensity: Vector3::new(3.0, 2.0, 1.0),
        };
        let size = [6, 4];
        let texels: Vec<SurfaceTexel> = (0..24)
            .map(|index| {
                let present = if index % 7 == 3 { -1.0 } else { 0.04 };
                SurfaceTexel::decode(
                    [index as f32, 0.0, (index * index % 5) as f32, present],
                    [0.0, 1.0, 0.0, 0.3],
                    [0.7, 0.4, 0.1, 0.25],
                )
            })
            .collect();
        let origin = Vector3::zero();
        let map = Map {
            texels: &texels,
            size,
            light: (&light).into(),
            origin,
            minimum_variance: 1e-6,
            emission: Emission::printed(Lobes::Both),
            specular_power: SpecularPower::Albedo,
        };
        let power = |assignment: &[u32], count| {
            let sum = |sum, light: &Vsgl| sum + light.power();
            lights(&map, assignment, count).iter().fold(Vector3::zero(), sum)
        };
        let whole = power(&[0; 24], 1);
        assert!(whole.y > 0.1);
        let scattered: Vec<u32> = (0..24).map(|index| index * 7 % 5).collect();
        assert!((power(&scattered, 5) - whole).length() < 1e-12);
        // Negative control: a cluster that is left out.
        assert!((power(&scattered, 4) - whole).length() > 0.01);
        // No texel: no power, and nothing that is not finite.
        let lights = lights(&map, &[0; 24], 2);
        assert_eq!(lights[1].power(), Vector3::zero());
        assert_eq!((lights[1].position, lights[1].variance), (origin, 1e-6));
        // A cluster's mean position is that of its lit texels.
        assert!((lights[0].position.x - 11.5).abs() < 1.0);
    }
}
