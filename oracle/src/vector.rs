//! Vectors and colours of three numbers.

use core::ops::{Add, Mul, Neg, Sub};

use glam::DVec3;

use crate::real::{Linear, Real};

/// A vector or a linear Rec. 709 colour.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Vector3<R = f64> {
    /// First coordinate, or red.
    pub x: R,
    /// Second coordinate, or green.
    pub y: R,
    /// Third coordinate, or blue.
    pub z: R,
}

impl<R> Vector3<R> {
    /// A vector of its coordinates.
    pub const fn new(x: R, y: R, z: R) -> Self {
        Self { x, y, z }
    }
}

impl<R: Real> Vector3<R> {
    /// The same number three times.
    #[must_use]
    pub fn splat(value: R) -> Self {
        Self::new(value, value, value)
    }
    /// The vector of zeros.
    #[must_use]
    pub fn zero() -> Self {
        Self::splat(R::zero())
    }
    /// Numbers that the GPU holds rounded to f32.
    #[must_use]
    pub fn constant(value: Vector3) -> Self {
        Self::new(R::constant(value.x), R::constant(value.y), R::constant(value.z))
    }
    /// The first three of an f32 texel, exact.
    #[must_use]
    pub fn of_texel(texel: [f32; 4]) -> Self {
        Self::constant(Vector3::new(f64::from(texel[0]), f64::from(texel[1]), f64::from(texel[2])))
    }
    /// The three numbers.
    #[must_use]
    pub fn to_array(self) -> [R; 3] {
        [self.x, self.y, self.z]
    }
    /// The values in f64.
    #[must_use]
    pub fn value(self) -> Vector3 {
        Vector3::new(self.x.value(), self.y.value(), self.z.value())
    }
    /// A function of every number.
    #[must_use]
    pub fn map(self, function: impl Fn(R) -> R) -> Self {
        Self::new(function(self.x), function(self.y), function(self.z))
    }
    /// The product number by number, as of colours.
    #[must_use]
    pub fn times(self, other: Self) -> Self {
        Self::new(self.x * other.x, self.y * other.y, self.z * other.z)
    }
    /// The scalar product.
    #[must_use]
    pub fn dot(self, other: Self) -> R {
        R::dot(self.to_array(), other.to_array())
    }
    /// The vector product, right-handed.
    #[must_use]
    pub fn cross(self, other: Self) -> Self {
        Self::new(
            self.y * other.z - self.z * other.y,
            self.z * other.x - self.x * other.z,
            self.x * other.y - self.y * other.x,
        )
    }
    /// The squared Euclidean length.
    #[must_use]
    pub fn length_squared(self) -> R {
        self.dot(self)
    }
    /// The Euclidean length.
    #[must_use]
    pub fn length(self) -> R {
        self.length_squared().sqrt()
    }
    /// The unit vector of the same direction, or `fallback` of a vector of length 0.
    #[must_use]
    pub fn normalized_or(self, fallback: Self) -> Self {
        let length = self.length();
        if length.value() > 0.0 { self.map(|part| part / length) } else { fallback }
    }
    /// The unit vector of the same direction; +z of a vector of length 0.
    #[must_use]
    pub fn normalized(self) -> Self {
        self.normalized_or(Self::constant(Vector3::new(0.0, 0.0, 1.0)))
    }
    /// This direction mirrored about a unit vector `about`: `2 (v . a) a - v`.
    #[must_use]
    pub fn mirrored(self, about: Self) -> Self {
        about * (R::constant(2.0) * self.dot(about)) - self
    }
    /// The luminance of a linear Rec. 709 colour.
    #[must_use]
    pub fn luminance(self) -> R {
        self.dot(Self::constant(Vector3::new(0.2126, 0.7152, 0.0722)))
    }
}

impl Vector3 {
    /// Two unit vectors that complete a unit vector to a right-handed orthonormal basis `(x, y, self)`.
    #[must_use]
    pub fn basis(self) -> (Self, Self) {
        let away =
            if self.x.abs() < 0.6 { Self::new(1.0, 0.0, 0.0) } else { Self::new(0.0, 1.0, 0.0) };
        let x = away.cross(self).normalized();
        (x, self.cross(x))
    }
}

impl<R: Real> Add for Vector3<R> {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self::new(self.x + other.x, self.y + other.y, self.z + other.z)
    }
}

impl<R: Real> Sub for Vector3<R> {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        Self::new(self.x - other.x, self.y - other.y, self.z - other.z)
    }
}

impl<R: Real> Neg for Vector3<R> {
    type Output = Self;
    fn neg(self) -> Self {
        Self::new(-self.x, -self.y, -self.z)
    }
}

impl<R: Real> Mul<R> for Vector3<R> {
    type Output = Self;
    fn mul(self, factor: R) -> Self {
        self.map(|part| part * factor)
    }
}

impl<R: Real> Linear<R> for Vector3<R> {
    fn nothing() -> Self {
        Self::zero()
    }
    fn plus(self, other: Self) -> Self {
        self + other
    }
    fn scaled(self, factor: R) -> Self {
        self * factor
    }
    fn covering(self, other: Self) -> Self {
        Self::new(self.x.cover(other.x), self.y.cover(other.y), self.z.cover(other.z))
    }
}

impl From<DVec3> for Vector3 {
    fn from(vector: DVec3) -> Self {
        Self::new(vector.x, vector.y, vector.z)
    }
}

impl From<Vector3> for DVec3 {
    fn from(vector: Vector3) -> Self {
        Self::new(vector.x, vector.y, vector.z)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bases_are_orthonormal_and_right_handed() {
        for z in [Vector3::new(1.0, 0.0, 0.0), Vector3::new(0.3, -0.7, 0.2).normalized()] {
            let (x, y) = z.basis();
            assert!((x.cross(y) - z).length() < 1e-15);
            assert!((x.length() - 1.0).abs() < 1e-15);
        }
    }

    #[test]
    fn mirroring_keeps_the_normal_part() {
        let normal = Vector3::new(0.0, 1.0, 0.0);
        let direction = Vector3::new(0.6, 0.8, 0.0);
        assert!((direction.mirrored(normal) - Vector3::new(-0.6, 0.8, 0.0)).length() < 1e-15);
    }
}
