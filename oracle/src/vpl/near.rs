//! A texel of the light's map as a facet: what is near is no point.

use super::arriving::PART_OF_LOBE;
use super::polygon::irradiance;
use crate::Vector3;
use crate::brdf::material::MINIMUM_ALPHA;
use crate::brdf::{Directions, Material, Ndf};
use crate::shade::Reflected;
use crate::surface::SurfaceTexel;

/// How often a facet is cut in four at most: into pieces of a hundredth of its width.
const LEVELS: u32 = 7;
/// The cosine that a direction from below the horizon is raised to, of a piece of which some is above.
const RAISED: f64 = 1e-3;

/// A flat piece of a surface that light falls on evenly from one direction, and that reflects it to its front.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Facet {
    pub(crate) corners: [Vector3; 4],
    pub(crate) normal: Vector3,
    /// The unit direction that light comes from.
    pub(crate) towards: Vector3,
    /// Arriving power over area.
    pub(crate) irradiance: Vector3,
    pub(crate) material: Material,
}

/// A surface that receives, and the direction that it is seen from.
pub(crate) struct Receiving<'a> {
    pub(crate) surface: &'a SurfaceTexel,
    pub(crate) view: Vector3,
    pub(crate) ndf: Ndf,
}

impl Facet {
    /// The area of a quadrilateral, and the squared distance of its furthest corner from its middle.
    pub(crate) fn measures(corners: &[Vector3; 4]) -> (f64, f64) {
        let [a, b, c, d] = *corners;
        let middle = middle(corners);
        let square = |corner: &Vector3| (*corner - middle).length_squared();
        (0.5 * (c - a).cross(d - b).length(), corners.iter().map(square).fold(0.0, f64::max))
    }

    /// What the receiver reflects of the facet towards its viewer.
    ///
    /// The cosines at both ends and the distance are integrated exactly. A lobe of either end is taken at the middle of
    /// a piece: the facet is cut in four until a piece's radius takes up at most a sixth of the lobe's width there.
    pub(crate) fn reflected(&self, receiving: &Receiving<'_>) -> Reflected {
        let mut sum = Reflected::none();
        // The back is dark; a surface does not light its own plane.
        let front = (receiving.surface.position - self.corners[0]).dot(self.normal) > 0.0;
        if front {
            self.add(&self.corners, LEVELS, receiving, &mut sum);
        }
        sum
    }

    fn add(
        &self,
        piece: &[Vector3; 4],
        levels: u32,
        receiving: &Receiving<'_>,
        sum: &mut Reflected,
    ) {
        let Receiving { surface, view, ndf } = *receiving;
        let path = middle(piece) - surface.position;
        let direction = path.normalized();
        if levels > 0 {
            let width = self.width(direction, receiving);
            let (_, radius) = Self::measures(piece);
            if radius > PART_OF_LOBE * width * path.length_squared() {
                for quarter in quarters(piece) {
                    self.add(&quarter, levels - 1, receiving, sum);
                }
                return;
            }
        }
        let seen = irradiance(piece, self.normal, surface.position, surface.normal);
        if seen <= 0.0 {
            return;
        }
        let at_facet = Directions { normal: self.normal, view: self.towards, light: -direction };
        let brdf = self.material.diffuse_brdf() + self.material.specular_brdf(ndf, &at_facet);
        let arriving = self.irradiance.times(brdf) * seen;
        let cosine = surface.normal.dot(direction);
        let light = if cosine > 0.0 {
            direction
        } else {
            (direction + surface.normal * (RAISED - cosine)).normalized()
        };
        let at_receiver = Directions { normal: surface.normal, view, light };
        sum.diffuse = sum.diffuse + arriving.times(surface.material.diffuse_brdf());
        sum.specular =
            sum.specular + arriving.times(surface.material.specular_brdf(ndf, &at_receiver));
    }

    /// The squared width of the narrower lobe, in angles from the receiver; infinite without lobes.
    fn width(&self, direction: Vector3, receiving: &Receiving<'_>) -> f64 {
        let Receiving { surface, view, .. } = *receiving;
        let of = |material: &Material, normal: Vector3, fixed: Vector3, other: Vector3| {
            if material.specular == Vector3::zero() {
                return f64::INFINITY;
            }
            // See `FixedFacet::evaluate`.
            let half = fixed + other;
            let along = half.dot(normal);
            let narrow = 1.0 - material.alpha * material.alpha;
            half.length_squared() - along * along * narrow
        };
        let sent = of(&self.material, self.normal, self.towards, -direction);
        let received = of(&surface.material, surface.normal, view, direction);
        // Along the horizon lobes narrow without bounds.
        sent.min(received).max(4.0 * MINIMUM_ALPHA * MINIMUM_ALPHA)
    }
}

fn middle(corners: &[Vector3; 4]) -> Vector3 {
    (corners[0] + corners[1] + corners[2] + corners[3]) * 0.25
}

/// The four parts of a quadrilateral between its middle and the middles of its edges.
fn quarters(corners: &[Vector3; 4]) -> [[Vector3; 4]; 4] {
    let [a, b, c, d] = *corners;
    let between = |one: Vector3, other: Vector3| (one + other) * 0.5;
    let [ab, bc, cd, da] = [between(a, b), between(b, c), between(c, d), between(d, a)];
    let centre = middle(corners);
    [[a, ab, centre, da], [ab, b, bc, centre], [centre, bc, c, cd], [da, centre, cd, d]]
}
