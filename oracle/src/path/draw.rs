//! Directions drawn by what a surface reflects.

use core::f64::consts::PI;

use crate::Vector3;
use crate::brdf::Ndf;
use crate::brdf::material::MINIMUM_COSINE;
use crate::fis::stress::Random;
use crate::surface::SurfaceTexel;

/// The least probability of drawing by a lobe that exists: the other one's tails then stay bounded.
const LEAST_SHARE: f64 = 0.25;

/// How directions are drawn at a surface: by the cosine, or by the specular lobe; their density is that of the mixture,
/// which is the balance heuristic for one sample.
// [Veach 1997, Robust Monte Carlo methods for light transport simulation, Section 9.2.4]
pub(super) struct Draw {
    normal: Vector3,
    across: [Vector3; 2],
    /// The direction to the viewer in the surface's own axes, turned above the horizon where it is below.
    view: Vector3,
    alpha: f64,
    ndf: Ndf,
    specular_share: f64,
}

impl Draw {
    pub(super) fn new(surface: &SurfaceTexel, view: Vector3, ndf: Ndf) -> Self {
        let normal = surface.normal;
        let (x, y) = normal.basis();
        let local = Vector3::new(x.dot(view), y.dot(view), normal.dot(view).max(MINIMUM_COSINE))
            .normalized();
        let diffuse = surface.material.diffuse.luminance();
        let specular = surface.material.specular.luminance();
        let specular_share = if specular <= 0.0 {
            0.0
        } else if diffuse <= 0.0 {
            // The lobe of facets leaves out directions of light that several facets would be needed for.
            1.0 - LEAST_SHARE
        } else {
            (specular / (specular + diffuse)).clamp(LEAST_SHARE, 1.0 - LEAST_SHARE)
        };
        let alpha = surface.material.alpha;
        Self { normal, across: [x, y], view: local, alpha, ndf, specular_share }
    }

    /// A unit direction above the horizon and its density per steradian; `None` where the draw fell below.
    pub(super) fn direction(&self, random: &mut Random) -> Option<(Vector3, f64)> {
        let (choice, u, v) = (random.uniform(), random.uniform(), random.uniform());
        let local = if choice < self.specular_share {
            let facet = self.facet(u, v);
            if facet.dot(self.view) <= 0.0 {
                return None;
            }
            self.view.mirrored(facet)
        } else {
            polar(u.sqrt(), v, (1.0 - u).sqrt())
        };
        if local.z <= 0.0 {
            return None;
        }
        let density = self.density(local);
        let direction = self.across[0] * local.x + self.across[1] * local.y + self.normal * local.z;
        let direction = direction.normalized();
        let above = self.normal.dot(direction) > 0.0;
        (above && density > 0.0 && density.is_finite()).then_some((direction, density))
    }

    /// The density per steradian with which [`Self::direction`] draws a unit direction; 0 below the horizon.
    pub(super) fn density_of(&self, direction: Vector3) -> f64 {
        let [x, y] = self.across;
        let local = Vector3::new(x.dot(direction), y.dot(direction), self.normal.dot(direction));
        let density = if local.z > 0.0 { self.density(local) } else { 0.0 };
        if density.is_finite() { density } else { 0.0 }
    }

    fn density(&self, light: Vector3) -> f64 {
        let half = (self.view + light).normalized();
        let facets = self.ndf.distribution(half.z, self.alpha);
        let specular = match self.ndf {
            // Visible normals: G1 D (v.h)/(n.v), over the Jacobian 4 (v.h). [Heitz 2014, Eq. (17)]
            Ndf::Ggx => {
                let (cosine, width) = (self.view.z, self.alpha * self.alpha);
                let root = (width + (1.0 - width) * cosine * cosine).sqrt();
                0.5 * facets / (cosine + root)
            }
            // All normals: D (n.h), over the Jacobian 4 (v.h). [Walter 2007, Eq. (24), Eq. (38)]
            Ndf::Beckmann => facets * half.z / (4.0 * self.view.dot(half)),
        };
        self.specular_share * specular + (1.0 - self.specular_share) * light.z / PI
    }

    /// A facet's normal.
    fn facet(&self, u: f64, v: f64) -> Vector3 {
        match self.ndf {
            // [Dupuy and Benyoub 2023, Sampling visible GGX normals with spherical caps, Listing 3]
            Ndf::Ggx => {
                let stretched = |vector: Vector3| {
                    Vector3::new(self.alpha * vector.x, self.alpha * vector.y, vector.z)
                };
                let view = stretched(self.view).normalized();
                let height = (1.0 - u) * (1.0 + view.z) - view.z;
                let cap = polar((1.0 - height * height).max(0.0).sqrt(), v, height);
                stretched(cap + view).normalized()
            }
            // [Walter 2007, Eq. (28)]
            Ndf::Beckmann => {
                let tangent = self.alpha * (-u.ln()).sqrt();
                let cosine = 1.0 / (1.0 + tangent * tangent).sqrt();
                polar(tangent * cosine, v, cosine)
            }
        }
    }
}

/// The vector at a radius and a share of the full turn around z, and a height.
pub(super) fn polar(radius: f64, turn: f64, height: f64) -> Vector3 {
    let (sine, cosine) = (2.0 * PI * turn).sin_cos();
    Vector3::new(radius * cosine, radius * sine, height)
}
