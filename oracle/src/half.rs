//! Storage in 16 bits, as half floats: what a texture or a packed light leaves of a number.
//!
//! With `f64` a number is rounded to the nearest half, ties to even. With [`Bounded`](crate::Bounded) it keeps its value
//! and its tolerance admits the nearest half of whatever it admitted, and of subnormal halves any, zero too. Devices may
//! round stored halves in any direction, and Mesa's software driver cuts them off, so that shaders have to round them to
//! the nearest by themselves.

/// The distance of neighbouring halves, relative to the lower end of their binade: 2^-10.
pub const ULP: f64 = 1.0 / 1024.0;
/// The smallest normal half, 2^-14: what flushing a subnormal half can cost.
pub const SMALLEST_NORMAL: f64 = 1.0 / 16384.0;
/// The largest half.
pub const LARGEST: f64 = 65504.0;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fis::stress::Random;
    use crate::{Bounded, Real};

    #[test]
    #[expect(clippy::cast_possible_truncation, reason = "inputs are f32")]
    fn the_tolerance_admits_the_nearest_half_and_no_other() {
        let mut random = Random::new(5);
        let mut largest = 0.0_f64;
        for _ in 0..20_000 {
            let x = f64::from(((random.uniform() * 45.0 - 29.0).exp2() * 0.999) as f32);
            let bounded = Bounded::exact(x as f32).to_half();
            let nearest = x.to_half();
            assert!(bounded.admits(nearest as f32), "{x} {nearest}");
            if x > SMALLEST_NORMAL {
                largest = largest.max((nearest - x).abs() / bounded.error);
            }
            // Negative control: two halves beyond, where halves are normal.
            let bits = half::f16::from_bits(half::f16::from_f64(nearest).to_bits() + 2);
            assert!(x < 2.0 * SMALLEST_NORMAL || !bounded.admits(bits.to_f32()), "{x} {bits}");
            assert!(x > SMALLEST_NORMAL || bounded.admits(0.0), "{x}");
        }
        assert!(largest > 0.9, "{largest}");
    }

    #[test]
    fn nothing_is_promised_beyond_the_largest_half() {
        assert!(Bounded::exact(65000.0).to_half().promises());
        assert!(!Bounded::exact(65505.0).to_half().promises());
        assert_eq!(1e20_f64.to_half(), f64::INFINITY);
        assert_eq!(Bounded::exact(0.0).to_half().error, 0.0);
        assert_eq!((LARGEST.to_half(), 0.1_f64.to_half()), (LARGEST, 0.099_975_585_937_5));
    }
}
