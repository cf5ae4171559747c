//! The picture: what arrives directly and what arrives after one reflection.

use crate::shade::Reflected;
use crate::{Real, Vector3};

/// The radiance of a pixel.
pub fn compose<R: Real>(direct: &Reflected<R>, indirect: &Reflected<R>) -> Vector3<R> {
    direct.total() + indirect.total()
}
