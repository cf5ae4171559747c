//! The error of specular models against quadrature.

use serde::Serialize;

/// Root mean square of a model's error over the brightest of the reflections compared.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SpecularError {
    /// The model, as on the axis `specular`.
    pub model: String,
    /// Of white metal.
    pub white: f64,
    /// Of a dielectric of reflectance 0.04.
    pub dielectric: f64,
}
