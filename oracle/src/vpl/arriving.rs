//! What points of light bring to a receiver: the loop that everything waits for.

use core::f64::consts::PI;

use super::lane::{LANES, Lane};
use crate::Vector3;
use crate::brdf::material::MINIMUM_COSINE;
use crate::brdf::{Ndf, fresnel};
use crate::shade::Reflected;
use crate::surface::SurfaceTexel;

/// Squared distance in texels' radii below which a texel is no point.
///
/// At this distance a square as a point is off by at most 0.7 % of what it would bring face to face, where a horizon cuts it,
/// and by 0.02 % root mean square (`the_error_of_points_at_the_switch_is_small`).
const NEAR: f64 = 24.0 * 24.0;
/// The part of a lobe's width, in angles of the half vector, that a texel's radius may take up as a point: squared.
pub(crate) const PART_OF_LOBE: f64 = 1.0 / (6.0 * 6.0);
/// The width that is given to what has no lobe, squared: larger than any angle.
const BROAD: f64 = 1e12;

fn broad(specular: Vector3) -> f64 {
    if specular == Vector3::zero() { BROAD } else { 0.0 }
}

/// What the sum needs of some lights; everything that does not depend on the pixel is done beforehand.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Block {
    pub(crate) position: [Lane; 3],
    pub(crate) normal: [Lane; 3],
    pub(crate) towards: [Lane; 3],
    /// What the squared distance is raised by: area over pi, or 0 where texels that are near are no points.
    pub(crate) disc: Lane,
    /// Squared distance of a texel's furthest corner from its middle; 0 of a point.
    pub(crate) radius: Lane,
    /// 0 of a light with a specular lobe, else large: see [`Arriving::is_near`].
    broad: Lane,
    pub(crate) facet: FixedFacet<Lane>,
    /// `Phi R_d/pi`.
    pub(crate) diffuse: [Lane; 3],
    /// `Phi R_s` and `Phi (1 - R_s)`: the Fresnel term's part without and with Schlick's weight.
    pub(crate) specular: [Lane; 3],
    pub(crate) grazing: [Lane; 3],
}

impl Block {
    /// Lights without power, which the last block is filled up with; finite everywhere.
    pub(crate) fn dark() -> Self {
        let (zero, one) = ([Lane::default(); 3], Lane::all(1.0));
        Self {
            position: zero,
            normal: zero,
            towards: zero,
            disc: one,
            radius: Lane::default(),
            broad: Lane::all(BROAD),
            facet: FixedFacet { cosine: one, width: one, masking: one, kept: one },
            diffuse: zero,
            specular: zero,
            grazing: zero,
        }
    }

    /// Puts the light of a surface into a lane: a photon of some power reaches it against the unit direction `towards`,
    /// and its squared distance is raised by `disc`.
    pub(crate) fn put(
        &mut self,
        ndf: Ndf,
        lane: usize,
        surface: &SurfaceTexel,
        towards: Vector3,
        power: Vector3,
        disc: f64,
    ) {
        let material = surface.material;
        let set = |lanes: &mut [Lane; 3], vector: Vector3| {
            for (lanes, part) in lanes.iter_mut().zip(vector.to_array()) {
                lanes.0[lane] = part;
            }
        };
        set(&mut self.position, surface.position);
        set(&mut self.normal, surface.normal);
        set(&mut self.towards, towards);
        set(&mut self.diffuse, power.times(material.diffuse_brdf()));
        set(&mut self.specular, power.times(material.specular));
        let grazing = Vector3::splat(fresnel::f90(material.specular));
        set(&mut self.grazing, power.times(grazing - material.specular));
        self.disc.0[lane] = disc;
        self.broad.0[lane] = broad(material.specular);
        let facet = FixedFacet::new(ndf, surface.normal.dot(towards), material.alpha);
        self.facet.cosine.0[lane] = facet.cosine;
        self.facet.width.0[lane] = facet.width;
        self.facet.masking.0[lane] = facet.masking;
        self.facet.kept.0[lane] = facet.kept;
    }
}

/// What the specular BRDF needs of a surface and of the direction that is fixed there.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FixedFacet<T = f64> {
    /// Cosine of the normal with the fixed direction.
    cosine: T,
    /// alpha^2.
    width: T,
    /// The fixed direction's masking: the root in GGX's, or all of Beckmann's over the cosine.
    masking: T,
    /// The fixed direction's cosine, kept above 0.
    kept: T,
}

impl FixedFacet {
    pub(crate) fn new(ndf: Ndf, cosine: f64, alpha: f64) -> Self {
        let (width, kept) = (alpha * alpha, cosine.max(MINIMUM_COSINE));
        let masking = match ndf {
            Ndf::Ggx => (kept * kept * (1.0 - width) + width).sqrt(),
            Ndf::Beckmann => g1_smith_beckmann(kept, width),
        };
        Self { cosine, width, masking, kept }
    }

    pub(crate) fn everywhere(self) -> FixedFacet<Lane> {
        FixedFacet {
            cosine: Lane::all(self.cosine),
            width: Lane::all(self.width),
            masking: Lane::all(self.masking),
            kept: Lane::all(self.kept),
        }
    }

    pub(crate) fn beckmann(self, cosine: f64, square: f64) -> f64 {
        let normal_part = cosine + self.cosine;
        // Light along the horizon or from below counts for nothing: the exponential is saved.
        if cosine <= 0.0 || normal_part <= 0.0 {
            return 0.0;
        }
        let cosine_squared = (normal_part * normal_part / square).min(1.0);
        let exponent = (cosine_squared - 1.0) / (cosine_squared * self.width);
        let distribution = exponent.exp() / (PI * self.width * cosine_squared * cosine_squared);
        0.25 * distribution * self.masking * g1_smith_beckmann(cosine, self.width)
    }
}

impl FixedFacet<Lane> {
    /// `D V`, Schlick's weight and the squared width of the lobe as seen along the other direction, from the cosine of
    /// that direction with the normal (at least 0) and with the fixed direction. The half vector enters by its squared
    /// length and its product with the normal alone.
    ///
    /// The width: the half vector turns by an angle over the length |h| of the sum of both directions; D changes over
    /// angles of the root of `sin^2 + alpha^2 cos^2` of the half vector's angle with the normal, at its peak as in its
    /// tails.
    #[inline(always)]
    pub(crate) fn evaluate<const GGX: bool>(
        &self,
        cosine: Lane,
        between: Lane,
    ) -> (Lane, Lane, Lane) {
        let (one, half) = (Lane::all(1.0), Lane::all(0.5));
        let square = (between + one + between + one).at_least(1e-24);
        let rest = (one - half * square.map(f64::sqrt)).at_least(0.0);
        let weight = (rest * rest) * (rest * rest) * rest;
        let normal_part = cosine + self.cosine;
        let denominator = normal_part * normal_part * (self.width - one) + square;
        let value = if GGX {
            let root = (cosine * cosine * (one - self.width) + self.width).map(f64::sqrt);
            let masking = cosine * self.masking + self.kept * root;
            Lane::all(0.5 / PI) * self.width * square * square
                / (denominator * denominator * masking)
        } else {
            let mut value = Lane::default();
            for lane in 0..LANES {
                let facet = FixedFacet {
                    cosine: self.cosine.0[lane],
                    width: self.width.0[lane],
                    masking: self.masking.0[lane],
                    kept: self.kept.0[lane],
                };
                value.0[lane] = facet.beckmann(cosine.0[lane], square.0[lane]);
            }
            value
        };
        (value, weight, denominator)
    }
}

/// Beckmann's `G1/cos`, from alpha^2.
// [Walter 2007, Section 5.2, after Eq. (27)]
pub(crate) fn g1_smith_beckmann(cosine: f64, width: f64) -> f64 {
    let slope = (width * (1.0 - cosine * cosine).max(0.0)).sqrt();
    if cosine >= 1.6 * slope {
        1.0 / cosine
    } else {
        let a = cosine / slope;
        (3.535 + 2.181 * a) / (slope * (1.0 + 2.276 * a + 2.577 * a * a))
    }
}

/// What the sum needs of a pixel, for every lane.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Receiver {
    position: [Lane; 3],
    /// Away from the surface's normal and from the eye: against the light's direction.
    against_normal: [Lane; 3],
    against_view: [Lane; 3],
    facet: FixedFacet<Lane>,
    broad: Lane,
}

impl Receiver {
    pub(crate) fn new(surface: &SurfaceTexel, eye: Vector3, ndf: Ndf) -> Self {
        let view = (eye - surface.position).normalized();
        let everywhere = |vector: Vector3| vector.to_array().map(Lane::all);
        let cosine = surface.normal.dot(view);
        Self {
            position: everywhere(surface.position),
            against_normal: everywhere(-surface.normal),
            against_view: everywhere(-view),
            facet: FixedFacet::new(ndf, cosine, surface.material.alpha).everywhere(),
            broad: Lane::all(broad(surface.material.specular)),
        }
    }
}

/// Irradiance; the same times `D V`; and times Schlick's weight too.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Sums {
    irradiance: [Lane; 3],
    specular: [Lane; 3],
    grazing: [Lane; 3],
}

/// What lights bring to a receiver.
#[derive(Clone, Copy)]
pub(crate) struct Arriving {
    pub(crate) irradiance: [Lane; 3],
    /// `D V` and Schlick's weight at the receiver.
    pub(crate) received: Lane,
    pub(crate) weight: Lane,
    /// Squared distance.
    square: Lane,
    /// Squared width of the narrower lobe of both ends, in angles from the receiver.
    width: Lane,
}

impl Arriving {
    #[inline(always)]
    pub(crate) fn new<const GGX: bool>(block: &Block, receiver: &Receiver) -> Self {
        let path = [0, 1, 2].map(|axis| receiver.position[axis] - block.position[axis]);
        let square = Lane::dot(path, path).at_least(1e-30);
        let inverse = Lane::all(1.0) / square.map(f64::sqrt);
        let direction = path.map(|part| part * inverse);
        let cosine_emitted = Lane::dot(block.normal, direction).at_least(0.0);
        let cosine_received = Lane::dot(receiver.against_normal, direction).at_least(0.0);
        let geometry = cosine_emitted * cosine_received / (square + block.disc);

        let towards = Lane::dot(block.towards, direction);
        let (emitted, emitted_weight, sent_width) =
            block.facet.evaluate::<GGX>(cosine_emitted, towards);
        let back = Lane::dot(receiver.against_view, direction);
        let (received, weight, received_width) =
            receiver.facet.evaluate::<GGX>(cosine_received, back);
        // A loop, not a map, which is not turned into vector instructions here: a third of the time.
        let mut irradiance = [Lane::default(); 3];
        for (channel, irradiance) in irradiance.iter_mut().enumerate() {
            let fresnel = block.specular[channel] + block.grazing[channel] * emitted_weight;
            *irradiance = geometry * (block.diffuse[channel] + emitted * fresnel);
        }
        let width = (sent_width + block.broad).at_most(received_width + receiver.broad);
        Self { irradiance, received, weight, square, width }
    }
}

impl Arriving {
    /// Which texels are too near, or too large for a lobe, to be points; what is said of these counts no longer.
    #[inline(always)]
    pub(crate) fn take_near(&mut self, block: &Block) -> [bool; LANES] {
        let limit = (self.width * Lane::all(PART_OF_LOBE)).at_most(Lane::all(1.0 / NEAR));
        let far = self.square * limit;
        let mut near = [false; LANES];
        for (near, (radius, far)) in near.iter_mut().zip(block.radius.0.iter().zip(far.0)) {
            *near = *radius > far;
        }
        if near.contains(&true) {
            for channel in &mut self.irradiance {
                for (brought, near) in channel.0.iter_mut().zip(near) {
                    if near {
                        *brought = 0.0;
                    }
                }
            }
        }
        near
    }
}

impl Sums {
    #[inline(always)]
    pub(crate) fn add(&mut self, arriving: Arriving) {
        for channel in 0..3 {
            let specular = arriving.irradiance[channel] * arriving.received;
            self.irradiance[channel] = self.irradiance[channel] + arriving.irradiance[channel];
            self.specular[channel] = self.specular[channel] + specular;
            self.grazing[channel] = self.grazing[channel] + specular * arriving.weight;
        }
    }

    pub(crate) fn reflected(&self, surface: &SurfaceTexel) -> Reflected {
        let sum = |lanes: &[Lane; 3]| {
            let [x, y, z] = lanes.map(|lane| lane.0.iter().sum());
            Vector3::new(x, y, z)
        };
        let (specular, grazing) = (sum(&self.specular), sum(&self.grazing));
        Reflected {
            diffuse: sum(&self.irradiance).times(surface.material.diffuse_brdf()),
            specular: specular.times(surface.material.specular)
                + grazing.times(
                    Vector3::splat(fresnel::f90(surface.material.specular))
                        - surface.material.specular,
                ),
        }
    }
}
