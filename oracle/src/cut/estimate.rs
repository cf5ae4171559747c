//! The estimated error of a node as one light, at a receiver.

use core::f64::consts::{PI, TAU};

use crate::Vector3;
use crate::brdf::Material;
use crate::brdf::fresnel::f_schlick;
use crate::brdf::reflection::mirror;
use crate::surface::SurfaceTexel;
use crate::vsgl::Vsgl;

/// By how many standard deviations of its positions a node reaches at least beyond its own plane and that of the receiver. A
/// vote stands for the pixels around it, which see the node from other places.
pub const SLACK: f64 = 2.5;

/// What a cut reads of a node besides its light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Branch {
    /// Its children; none of a leaf.
    pub children: Option<[usize; 2]>,
    /// Luminance of the power that is reflected diffusely.
    pub power: f64,
    /// Luminance of the power that is reflected specularly.
    pub specular_power: f64,
    /// Variance of its children's mean normals about its own, 0 to 1.
    pub spread: f64,
    /// The lowest and the highest corner of the box around its leaves, relative to its mean position.
    pub bounds: [Vector3; 2],
}

impl Branch {
    /// The place within its box, relative to its mean position, that is nearest to a receiver whose offset to that position
    /// is given.
    fn nearest(&self, offset: Vector3) -> Vector3 {
        let [low, high] = self.bounds.map(Vector3::to_array);
        let at = offset.to_array();
        let [x, y, z] = [0, 1, 2].map(|axis| (-at[axis]).max(low[axis]).min(high[axis]));
        Vector3::new(x, y, z)
    }
}

/// The specular reflection of a receiver, as a lobe.
#[derive(Clone, Copy, Debug)]
pub struct Glossy {
    /// Its axis.
    pub axis: Vector3,
    /// Its sharpness.
    pub sharpness: f64,
    /// Luminance of the Fresnel term.
    pub reflectance: f64,
}

/// A pixel that nodes are estimated at.
#[derive(Clone, Copy, Debug)]
pub struct Receiver {
    /// Its position.
    pub position: Vector3,
    /// Its unit normal.
    pub normal: Vector3,
    /// Luminance of the diffuse reflectance over pi.
    pub diffuse: f64,
    /// Its specular reflection, if it counts.
    pub glossy: Option<Glossy>,
}

impl Receiver {
    /// That of a surface seen from `eye`, with the reflections that count.
    #[must_use]
    pub fn of(surface: &SurfaceTexel, eye: Vector3, diffuse: bool, specular: bool) -> Self {
        let Material { alpha, .. } = surface.material;
        let view = (eye - surface.position).normalized();
        let glossy = || {
            let lobe = mirror(view, surface.normal, alpha);
            let cosine = view.dot(surface.normal).max(0.0);
            let reflectance = f_schlick(surface.material.specular, cosine).luminance();
            Glossy { axis: lobe.axis, sharpness: lobe.sharpness, reflectance }
        };
        Self {
            position: surface.position,
            normal: surface.normal,
            diffuse: if diffuse { surface.material.diffuse.luminance() / PI } else { 0.0 },
            glossy: specular.then(glossy),
        }
    }
}

/// The mean of `max(x - u, 0)` over a standard normal distribution of x, phi(u) - u Q(u), u at least 0. Fitted by its values at
/// 0, 1 and 2; relative error below 4 % up to 2.5, where it is 1/200 of its value at 0 (the test
/// `the_tail_is_that_of_a_normal_distribution`).
#[must_use]
pub fn tail(u: f64) -> f64 {
    0.398_942_28 * (-u * (1.207 + 0.359 * u)).exp()
}

/// A normalised lobe convolved with the extent of a light, where the cosine to its axis is given.
fn blurred(cosine: f64, sharpness: f64, extent: f64) -> f64 {
    let wide = sharpness * extent / (sharpness + extent).max(1e-30);
    let far = sharpness * extent / (3.0 * sharpness + extent).max(1e-30);
    wide.max(0.5) / TAU * (-far * (1.0 - cosine)).exp()
}

/// The estimate, in luminance of radiance; `slack`: [`SLACK`].
#[must_use]
pub fn estimate(light: &Vsgl, branch: &Branch, receiver: &Receiver, slack: f64) -> f64 {
    let offset = light.position - receiver.position;
    let squared = offset.length_squared();
    let towards = offset * (1.0 / squared.max(1e-30).sqrt());
    let extent = squared / light.variance;
    let inverse = 1.0 / extent.max(1e-20);
    let nearest = branch.nearest(offset);
    let gap = (offset + nearest).length_squared();
    let aside = (nearest.length_squared() / gap.max(1e-30)).sqrt();
    let slack = (slack / (1.0 + extent).sqrt()).max(aside.min(1.0));
    let r = light.diffuse_mean_length;
    let directions = (2.0 * (1.0 - r)).max(0.0).sqrt().min(1.0);
    let height = towards.dot(receiver.normal);
    let facing = -towards.dot(light.diffuse.axis);
    let front = (height + slack).clamp(0.0, 1.0);
    let back = (facing + slack + directions).clamp(0.0, 1.0);
    let wide = squared + 0.5 * light.variance;
    let falloff = 1.0 / wide;
    let closer = wide / gap.max(1e-6 * wide).min(wide);
    let emitted = branch.power / PI * back * falloff;
    let share = (inverse + branch.spread).min(1.0);
    let tilt = r * light.diffuse.axis.dot(receiver.normal);
    let across = ((1.0 - tilt * tilt).max(0.0) * inverse).sqrt().min(1.0);
    let horizon = across * tail(height.abs() / across.max(1e-10));
    let lit = f64::from(u8::from(front > 0.0));
    // Both cosines' product is largest towards the bisector of n_r and -n, (1 - n . n_r)/2: its mean over the normals.
    let product = front.min(0.5 * (1.0 - tilt).max(0.0) / back.max(1e-10));
    let mut error = emitted * receiver.diffuse * (product * share * closer + horizon);
    let width = |sharpness: f64| (sharpness * inverse).powf(1.5);
    let reflected = |glossy: &Glossy| {
        glossy.reflectance * blurred(towards.dot(glossy.axis), glossy.sharpness, extent) * lit
    };
    if let Some(glossy) = &receiver.glossy {
        let blur = (inverse + branch.spread + width(glossy.sharpness)).min(1.0);
        error += emitted * reflected(glossy) * blur;
    }
    if let Some(lobe) = light.specular {
        let cosine = -towards.dot(lobe.axis);
        let intensity = branch.specular_power * falloff * blurred(cosine, lobe.sharpness, extent);
        let blur = (inverse + width(lobe.sharpness)).min(1.0);
        error += intensity * receiver.diffuse * front * blur;
        if let Some(glossy) = &receiver.glossy {
            error += intensity * reflected(glossy) * (blur + width(glossy.sharpness)).min(1.0);
        }
    }
    error
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_tail_is_that_of_a_normal_distribution() {
        // The mean of max(x - u, 0) over a normal distribution, by a sum.
        let mean = |u: f64| {
            let step = 1e-4;
            let at = |index: u32| u + (f64::from(index) + 0.5) * step;
            let density = |x: f64| (-0.5 * x * x).exp() / TAU.sqrt();
            (0..80_000).map(|index| (at(index) - u) * density(at(index)) * step).sum::<f64>()
        };
        for step in 0..=25 {
            let u = 0.1 * f64::from(step);
            let error = tail(u) / mean(u) - 1.0;
            assert!(error.abs() < 0.04, "{u}: {error}");
        }
        assert!((tail(1.0) / mean(1.1) - 1.0).abs() > 0.1, "another place goes unnoticed");
    }
}
