//! A lobe of a virtual light in 16 bytes.

use crate::vsgl::Lobe;
use crate::{Bounded, Real, Vector3};

/// How far a packed axis may be from the unit vector, at most.
///
/// Half a step of 1/32767 in both coordinates moves the point on the octahedron by up to sqrt(6) of it, and the division
/// by a length of at least 1/sqrt(3) by sqrt(3) times that: 6.5e-5, and some f32 rounding.
pub const AXIS_ERROR: f64 = 7e-5;

/// What a stored sharpness is multiplied with, so that 2^20 is within the range of halves.
pub const SHARPNESS_UNIT: f64 = 32.0;

/// A share of 65535 steps that packing may be off by: half a step and the rounding of f32 at 65535.
const HALF_STEP: f64 = 0.51 / 65535.0;

/// What is stored of a lobe.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PackedLobe {
    /// Octahedral coordinates of the axis times 32767.
    pub axis: [i16; 2],
    /// The coefficient's channels over the largest, times 65535.
    pub color: [u16; 3],
    /// The sharpness over [`SHARPNESS_UNIT`]: a half.
    pub sharpness: f64,
    /// The coefficient's largest channel.
    pub scale: f32,
}

impl PackedLobe {
    /// Packs a lobe.
    // [Cigolle 2014, Section 3.2]
    #[must_use]
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "rounded and in range"
    )]
    pub fn of_lobe(lobe: &Lobe) -> Self {
        let Vector3 { x, y, z } = lobe.axis;
        let norm = x.abs() + y.abs() + z.abs();
        let upper = [x / norm, y / norm];
        let point = if z >= 0.0 {
            upper
        } else {
            [(1.0 - upper[1].abs()).copysign(x), (1.0 - upper[0].abs()).copysign(y)]
        };
        let [r, g, b] = lobe.coefficient.to_array();
        let scale = r.max(g).max(b);
        let share =
            |channel: f64| if scale > 0.0 { (65535.0 * channel / scale).round() } else { 0.0 };
        Self {
            axis: point.map(|coordinate| (32767.0 * coordinate).round() as i16),
            color: [r, g, b].map(|channel| share(channel) as u16),
            sharpness: (lobe.sharpness / SHARPNESS_UNIT).min(crate::half::LARGEST).to_half(),
            scale: scale as f32,
        }
    }

    /// Unpacks it.
    // [Cigolle 2014, Section 3.2]
    #[must_use]
    pub fn lobe<R: Real>(&self) -> Lobe<R> {
        let [x, y] =
            self.axis.map(|step| R::constant(f64::from(step.max(-32767))) / R::constant(32767.0));
        let height = R::one() - x.abs() - y.abs();
        let fold = (-height).max(R::zero());
        let folded = |coordinate: R| {
            if coordinate.value() >= 0.0 { coordinate - fold } else { coordinate + fold }
        };
        let [r, g, b] = self.color.map(|step| {
            R::constant(f64::from(self.scale))
                * (R::constant(f64::from(step)) / R::constant(65535.0))
        });
        Lobe {
            axis: Vector3::new(folded(x), folded(y), height).normalized(),
            sharpness: R::constant(SHARPNESS_UNIT * self.sharpness),
            coefficient: Vector3::new(r, g, b),
        }
    }
}

/// The lobe with the tolerance of what is unpacked after it was packed.
#[must_use]
pub fn packed(lobe: &Lobe<Bounded>) -> Lobe<Bounded> {
    let [r, g, b] = lobe.coefficient.to_array();
    let scale = r.max(g).max(b);
    let unit = Bounded::constant(SHARPNESS_UNIT);
    Lobe {
        axis: lobe.axis.map(|part| Bounded::with_error(part.value, part.error + AXIS_ERROR)),
        sharpness: (lobe.sharpness / unit).min(Bounded::constant(crate::half::LARGEST)).to_half()
            * unit,
        coefficient: lobe.coefficient.map(|part| {
            let step = HALF_STEP * (scale.value + scale.error);
            // The quotient by the scale and the product with it round, too.
            let back = part / scale * scale;
            if scale.value > 0.0 {
                Bounded::with_error(part.value, back.error + step)
            } else {
                part
            }
        }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fis::stress::Random;

    fn lobe(random: &mut Random) -> Lobe {
        let mut signed = || 2.0 * random.uniform() - 1.0;
        let axis = Vector3::new(signed(), signed(), signed()).normalized();
        let (sharpness, power) = ((20.0 * signed()).exp2(), (60.0 * signed()).exp2());
        let coefficient = Vector3::new(signed().abs(), signed().abs(), signed().abs()) * power;
        Lobe { axis, sharpness, coefficient }
    }

    #[test]
    fn what_is_unpacked_is_within_the_tolerance() {
        let mut random = Random::new(3);
        let mut largest = 0.0_f64;
        for _ in 0..50_000 {
            let lobe = lobe(&mut random);
            let bounded: Lobe<Bounded> = Lobe {
                axis: Vector3::constant(lobe.axis),
                sharpness: Bounded::constant(lobe.sharpness),
                coefficient: Vector3::constant(lobe.coefficient),
            };
            let expected = packed(&bounded);
            let found: Lobe = PackedLobe::of_lobe(&lobe).lobe();
            let within =
                |found: f64, expected: Bounded| (found - expected.value).abs() <= expected.error;
            assert!((found.axis - lobe.axis).length() <= AXIS_ERROR, "{lobe:?} {found:?}");
            largest = largest.max((found.axis - lobe.axis).length());
            assert!(within(found.sharpness, expected.sharpness), "{lobe:?} {found:?}");
            for (found, expected) in
                found.coefficient.to_array().into_iter().zip(expected.coefficient.to_array())
            {
                assert!(within(found, expected), "{lobe:?} {found} {expected:?}");
            }
        }
        // The bound is a bound and not a blank cheque.
        assert!(largest > 0.5 * AXIS_ERROR, "{largest}");
    }

    #[test]
    fn extremes_stay() {
        for axis in [
            Vector3::new(0.0, 0.0, 1.0),
            Vector3::new(0.0, 0.0, -1.0),
            Vector3::new(-1.0, 0.0, 0.0),
        ] {
            let dark = Lobe { axis, sharpness: 0.0, coefficient: Vector3::zero() };
            assert_eq!(PackedLobe::of_lobe(&dark).lobe::<f64>(), dark);
            let sharp = Lobe { sharpness: 1_048_575.0, ..dark };
            let back: Lobe = PackedLobe::of_lobe(&sharp).lobe();
            assert!((back.sharpness / sharp.sharpness - 1.0).abs() <= crate::half::ULP);
            let sharper = Lobe { sharpness: f64::from(f32::MAX), ..dark };
            assert_eq!(PackedLobe::of_lobe(&sharper).lobe::<f64>().sharpness, 2_096_128.0);
        }
    }
}
