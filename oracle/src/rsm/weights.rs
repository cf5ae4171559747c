//! How finely a sampler holds the weights that it blends texels and mip levels by.

use crate::Real;

/// The weights of a sampler.
///
/// Vulkan calls the bits `subTexelPrecisionBits` and `mipmapPrecisionBits`, and asks for 4 at least. Most hardware has 8 of
/// both; a software driver may blend in full floats, and then does not show what hardware does: it has to be modelled.
// [Vulkan, VkPhysicalDeviceLimits]; [Vulkan, Texel filtering]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Weights {
    /// As they are: what is written out in a shader.
    #[default]
    Exact,
    /// Rounded to the nearest fixed-point number, as the fractions of a coordinate and of a level are held. Which way a
    /// device rounds is its own affair; to nearest is off by the least.
    Fixed {
        /// Fractional bits of the weight between two texels, 0 to 52.
        texel_bits: u32,
        /// Fractional bits of the weight between two mip levels, 0 to 52.
        mip_bits: u32,
    },
}

impl Weights {
    /// What most hardware has.
    pub const HARDWARE: Self = Self::Fixed { texel_bits: 8, mip_bits: 8 };

    /// The weight between two texels, from the fraction 0 to 1 of a coordinate.
    pub fn of_texels<R: Real>(self, fraction: R) -> R {
        match self {
            Self::Exact => fraction,
            Self::Fixed { texel_bits, .. } => rounded(fraction, texel_bits),
        }
    }

    /// The weight between two mip levels, from the fraction 0 to 1 of a level.
    pub fn of_levels<R: Real>(self, fraction: R) -> R {
        match self {
            Self::Exact => fraction,
            Self::Fixed { mip_bits, .. } => rounded(fraction, mip_bits),
        }
    }
}

/// The nearest number of some fractional bits; where the fraction is uncertain, each that it may be rounded to.
fn rounded<R: Real>(fraction: R, bits: u32) -> R {
    let scale = f64::from(bits.min(52)).exp2();
    let nearest = |value: f64| R::constant((value.clamp(0.0, 1.0) * scale).round() / scale);
    let (value, error) = (fraction.value(), fraction.error());
    nearest(value).cover(nearest(value - error)).cover(nearest(value + error))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Bounded;

    #[test]
    fn weights_are_rounded_to_their_bits() {
        let four = Weights::Fixed { texel_bits: 2, mip_bits: 1 };
        assert_eq!(
            [0.0, 0.1, 0.13, 0.6, 0.9, 1.0].map(|at| four.of_texels(at)),
            [0.0, 0.0, 0.25, 0.5, 1.0, 1.0]
        );
        assert_eq!([0.2, 0.3, 0.8].map(|at| four.of_levels(at)), [0.0, 0.5, 1.0]);
        assert_eq!(Weights::Exact.of_texels(0.3), 0.3);
        // A fraction that is uncertain about a boundary may become either; one that is not may not.
        let at = |value: f64| four.of_texels(Bounded::with_error(value, 0.01));
        assert!(at(0.12).admits(0.25) && at(0.12).admits(0.0));
        assert!(at(0.2).admits(0.25) && !at(0.2).admits(0.0));
    }
}
