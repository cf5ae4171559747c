//! The numbers that a host computes.

use sglow_graph::Configuration;
use sglow_graph::description::Number;
use sglow_shaders::frame::parameter;

/// The smallest positional variance of a virtual light: that of a square as large as a texel of the map, `texel` wide, at the
/// distance of the scene's radius. In squared world units.
pub fn minimum_variance(texel: f32) -> f32 {
    // The trace of the variance of a uniform square of side s is s^2 / 6.
    (texel * texel / 6.0).max(1e-12)
}

/// The power that a stored one stands for where moments are kept in halves: the power of two that is 2^15 times less than
/// that of the brightest photon, rounded up; its inverse is as exact.
pub fn power_unit(brightest: f64) -> f32 {
    if !(brightest > 0.0 && brightest.is_finite()) {
        return 1.0;
    }
    (brightest.log2().ceil() - 15.0).clamp(-126.0, 126.0).exp2() as f32
}

/// Length of the mean direction of a lobe of a sharpness above 0.
pub fn mean_length(sharpness: f64) -> f64 {
    // The Langevin function [Banerjee 2005]; by its series where the difference cancels.
    if sharpness < 1e-2 { sharpness / 3.0 } else { 1.0 / sharpness.tanh() - 1.0 / sharpness }
}

/// The same by the approximation that turns it back into a sharpness by s = r / (1 - r). [Toksvig 2005]
pub fn mean_length_toksvig(sharpness: f64) -> f64 {
    sharpness / (sharpness + 1.0)
}

/// What lies within this distance of a virtual light does not occlude it, in a scene of a radius; in world units.
pub fn least_near(radius: f32) -> f32 {
    1e-4 * radius
}

/// How far a receiver is moved along its normal, over its distance to the virtual light along |x| + |y| + |z|.
///
/// A texel's half diagonal is sqrt(2) h on the octahedron, h one over the tile's width; moving the receiver changes its
/// distance by sqrt(3) times as much at most, hence the denominator. Rasterisers may snap vertices to a sixteenth of a texel
/// (Vulkan's least subPixelPrecisionBits is 4), by a thirty-second either way, which counts as a texel that is wider by a
/// sixteenth.
pub fn bias(scale: f32, tile: u32) -> f32 {
    let half = (1.0 + 1.0 / 16.0) / tile as f32;
    scale * std::f32::consts::SQRT_2 * half / (1.0 - 6f32.sqrt() * half)
}

/// Adds the numbers of the vertices and indices of what occludes virtual lights.
pub fn occluder_counts(configuration: &mut Configuration, counts: [u64; 2]) {
    for (name, count) in
        [parameter::OCCLUDER_VERTEX_COUNT, parameter::OCCLUDER_INDEX_COUNT].into_iter().zip(counts)
    {
        configuration.parameters.insert(name.to_owned(), Number::Whole(count));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_are_powers_of_two_whose_inverses_are_finite() {
        for brightest in [1e-300, 1e-38, 1e-20, 0.3, 1.0, 5e3, 1e20, 3e38, 1e300] {
            let unit = power_unit(brightest);
            assert!(unit.is_normal() && (1.0 / unit).is_normal(), "{brightest}: {unit}");
            assert_eq!(unit.to_bits() & 0x7f_ffff, 0, "{brightest}: {unit}");
            let stored = brightest / f64::from(unit);
            let bounded = !(1e-33..1e38).contains(&brightest);
            assert!(bounded || (16384.0..=32768.0).contains(&stored), "{brightest}: {stored}");
        }
        assert_eq!(
            (power_unit(0.0), power_unit(f64::INFINITY), power_unit(f64::NAN)),
            (1.0, 1.0, 1.0)
        );
    }
}
