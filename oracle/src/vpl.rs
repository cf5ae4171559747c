//! The reference of a picture's indirect light without visibility: every texel of the light's map is a facet that light
//! falls on.
//!
//! Brute force in f64, with the real BRDF at both ends of every path and without visibility: what the virtual spherical
//! Gaussian lights approximate. A texel is the piece of its surface's plane that the light's rays through its corners
//! cut out ([`crate::light::Light::quad`]); what falls on it is spread evenly, and its front reflects it. Far from a
//! receiver it is a point, and the sum is that over virtual point lights [Keller 1997, Dachsbacher 2005]. The inverse
//! square of the distance has no finite integral over the surface, so that near a receiver points are bright spots:
//! there a texel is a flat quadrilateral of even radiance, whose irradiance is exact, cut off at the receiver's
//! horizon. Where a lobe is narrower than a texel, it is cut into pieces.
//!
//! What remains is the map itself: one position, normal and material for each texel. So the error is that of the map's
//! resolution, and it is found by comparing maps.

use crate::Vector3;
use crate::brdf::Ndf;
use crate::groups::in_groups;
use crate::light::Lights;
use crate::shade::Reflected;
use crate::surface::SurfaceTexel;

pub(crate) mod arriving;
pub(crate) mod lane;
mod near;
mod polygon;

use arriving::{Arriving, Block, Receiver, Sums};
use lane::LANES;
use near::{Facet, Receiving};

/// Blocks of lights that stay in the cache while a group of pixels uses them.
const BLOCKS_AT_ONCE: usize = 192;
/// Pixels that one task works on.
const PIXELS_AT_ONCE: usize = 64;

/// A texel of the light's map: a piece of a surface that light falls on.
#[derive(Clone, Copy, Debug)]
struct Lit {
    /// The surface in its middle.
    surface: SurfaceTexel,
    /// The unit direction to the light.
    towards: Vector3,
    /// Arriving power.
    power: Vector3,
    corners: [Vector3; 4],
}

/// The lit facets of a light's map.
#[derive(Clone, Debug)]
pub struct TexelFacets {
    blocks: Vec<Block>,
    /// Those of every block, where there are any.
    facets: Vec<[Option<Facet>; LANES]>,
    count: usize,
    ndf: Ndf,
}

impl TexelFacets {
    /// The facets of a map of `size` texels, row by row from the top; texels without surface or power are left out.
    #[must_use]
    pub fn of_map<'a>(
        light: impl Into<Lights<'a>>,
        texels: &[SurfaceTexel],
        size: [usize; 2],
        ndf: Ndf,
    ) -> Self {
        Self::of_counted_map(light, texels, size, ndf, |_| 1.0)
    }

    /// The same with the power of each texel times how often it counts: what filtering kernels hold, summed exactly.
    #[must_use]
    pub fn of_counted_map<'a>(
        light: impl Into<Lights<'a>>,
        texels: &[SurfaceTexel],
        size: [usize; 2],
        ndf: Ndf,
        counted: impl Fn([usize; 2]) -> f64,
    ) -> Self {
        let (mut facets, lights) = (Self::none(ndf), light.into());
        let mut squares: Vec<[usize; 2]> = (0..size[1].div_ceil(2))
            .flat_map(|y| (0..size[0].div_ceil(2)).map(move |x| [2 * x, 2 * y]))
            .collect();
        // Neighbours stay neighbours: near blocks then follow each other.
        squares.sort_by_key(|&square| along_the_curve(square));
        for [x, y] in squares {
            let lanes = [0, 1, 2, 3].map(|lane: usize| {
                let texel = [x + lane % 2, y + lane / 2];
                if texel[0] >= size[0] || texel[1] >= size[1] {
                    return None;
                }
                let surface = texels.get(texel[1] * size[0] + texel[0])?;
                let of = lights.at(texel, size)?;
                let power = of.light.photon_power::<f64>(of.texel, of.size) * counted(texel);
                if !surface.present || power == Vector3::zero() {
                    return None;
                }
                let (towards, _) = of.light.towards(surface.position);
                let corners = of.light.quad(of.texel, of.size, surface.position, surface.normal)?;
                Some(Lit { surface: *surface, towards, power, corners })
            });
            facets.add(lanes);
        }
        facets
    }

    /// Without facets.
    #[must_use]
    pub fn none(ndf: Ndf) -> Self {
        Self { blocks: Vec::new(), facets: Vec::new(), count: 0, ndf }
    }

    /// Adds the facets of a square of texels.
    fn add(&mut self, lanes: [Option<Lit>; LANES]) {
        if lanes.iter().all(Option::is_none) {
            return;
        }
        let (mut block, mut facets) = (Block::dark(), [None; LANES]);
        for (lane, texel) in lanes.iter().enumerate() {
            let Some(Lit { surface, towards, power, corners }) = *texel else { continue };
            block.put(self.ndf, lane, &surface, towards, power, 0.0);
            let (area, radius) = Facet::measures(&corners);
            self.count += 1;
            // What has no area stays a point.
            if area > 0.0 && area.is_finite() {
                block.radius.0[lane] = radius;
                facets[lane] = Some(Facet {
                    corners,
                    normal: surface.normal,
                    towards,
                    irradiance: power * (1.0 / area),
                    material: surface.material,
                });
            }
        }
        self.blocks.push(block);
        self.facets.push(facets);
    }

    /// The number of facets.
    #[must_use]
    pub fn len(&self) -> usize {
        self.count
    }

    /// Whether there are no facets.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.count == 0
    }

    /// The radiance that surfaces reflect towards an eye, in the order of the surfaces; none where there is no surface.
    ///
    /// `progress` is called from several threads with the number of surfaces done so far, and says whether to go on;
    /// `None` if it said no.
    pub fn reflect(
        &self,
        surfaces: &[SurfaceTexel],
        eye: Vector3,
        // Not a type parameter: the hot loop is then compiled here, as optimised as this crate is.
        progress: &(dyn Fn(usize) -> bool + Sync),
    ) -> Option<Vec<Reflected>> {
        in_groups(surfaces, PIXELS_AT_ONCE, progress, |_, group| match self.ndf {
            Ndf::Ggx => self.reflect_group::<true>(group, eye),
            Ndf::Beckmann => self.reflect_group::<false>(group, eye),
        })
    }

    fn reflect_group<const GGX: bool>(
        &self,
        group: &[SurfaceTexel],
        eye: Vector3,
    ) -> Vec<Reflected> {
        let receivers: Vec<Receiver> =
            group.iter().map(|surface| Receiver::new(surface, eye, self.ndf)).collect();
        let mut sums = vec![(Sums::default(), Reflected::none()); group.len()];
        for start in (0..self.blocks.len()).step_by(BLOCKS_AT_ONCE) {
            let end = self.blocks.len().min(start + BLOCKS_AT_ONCE);
            for ((surface, receiver), (far, near)) in group.iter().zip(&receivers).zip(&mut sums) {
                if !surface.present {
                    continue;
                }
                for (number, block) in (start..end).zip(&self.blocks[start..end]) {
                    let mut arriving = Arriving::new::<GGX>(block, receiver);
                    let taken = arriving.take_near(block);
                    far.add(arriving);
                    if taken.contains(&true) {
                        self.add_near(number, taken, surface, eye, near);
                    }
                }
            }
        }
        let both = |(surface, (far, near)): (&SurfaceTexel, (Sums, Reflected))| {
            let far = far.reflected(surface);
            Reflected {
                diffuse: far.diffuse + near.diffuse,
                specular: far.specular + near.specular,
            }
        };
        group.iter().zip(sums).map(both).collect()
    }

    /// Adds what near facets of a block bring.
    #[cold]
    fn add_near(
        &self,
        block: usize,
        near: [bool; LANES],
        surface: &SurfaceTexel,
        eye: Vector3,
        sum: &mut Reflected,
    ) {
        let view = (eye - surface.position).normalized();
        let receiving = Receiving { surface, view, ndf: self.ndf };
        for (facet, near) in self.facets[block].iter().zip(near) {
            if let Some(facet) = facet.as_ref().filter(|_| near) {
                let reflected = facet.reflected(&receiving);
                sum.diffuse = sum.diffuse + reflected.diffuse;
                sum.specular = sum.specular + reflected.specular;
            }
        }
    }
}

/// The place of a texel on a curve through the map, whose pieces are compact.
// [Morton 1966, A computer oriented geodetic data base and a new technique in file sequencing]
pub(crate) fn along_the_curve(texel: [usize; 2]) -> u64 {
    let spread = |number: usize| {
        (0..32).fold(0, |spread, bit| spread | ((number as u64 >> bit & 1) << (2 * bit)))
    };
    spread(texel[0]) | spread(texel[1]) << 1
}

#[cfg(test)]
#[path = "vpl/tests.rs"]
mod tests;
