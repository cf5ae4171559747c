//! The value of an anisotropic spherical Gaussian.

use crate::{Real, Vector3};

/// An anisotropic spherical Gaussian of amplitude 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Asg<R = f64> {
    /// Orthonormal axes: x and y of the bandwidths, z of the lobe.
    pub axes: [Vector3<R>; 3],
    /// Bandwidths along x and y, at least 0.
    pub bandwidths: [R; 2],
}

/// The value at a unit direction; 0 to 1.
// [Xu 2013, Eq. (1)]
pub fn evaluate<R: Real>(direction: Vector3<R>, asg: &Asg<R>) -> R {
    let [x, y, z] = asg.axes.map(|axis| direction.dot(axis));
    let exponent = asg.bandwidths[0] * x.squared() + asg.bandwidths[1] * y.squared();
    z.max(R::zero()) * (-exponent).exp()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sg;

    #[test]
    fn equal_bandwidths_are_a_spherical_gaussian_near_the_axis() {
        let z = Vector3::new(0.48, -0.6, 0.64);
        let (x, y) = z.basis();
        let asg = Asg { axes: [x, y, z], bandwidths: [200.0; 2] };
        let near = (z + x * 0.05 + y * 0.03).normalized();
        // exp(-b sin^2) and exp(l (cos - 1)) agree to second order for l = 2 b. [Xu 2013, Section 3]
        let gaussian = sg::evaluate(near, z, 400.0);
        assert!((evaluate(near, &asg) / gaussian - 1.0).abs() < 5e-3);
        assert_eq!(evaluate(z, &asg), 1.0);
        assert_eq!(evaluate(-z, &asg), 0.0);
        // Negative control: l = b.
        assert!((evaluate(near, &asg) / sg::evaluate(near, z, 200.0) - 1.0).abs() > 0.1);
    }
}
