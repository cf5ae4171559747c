//! The error of specular models against quadrature, over roughness, angle of the view and sharpness.

use super::Incoming;
use super::specular::{Specular, quadrature};
use crate::Vector3;
use crate::brdf::{Material, Ndf};

const NORMAL: Vector3 = Vector3::new(0.0, 0.0, 1.0);
/// Sharpnesses of the incoming lobes.
pub const SHARPNESSES: [f64; 4] = [1.0, 5.0, 100.0, 1000.0];
/// Angles between view and normal, in radians.
pub const ANGLES: [f64; 4] = [0.2, 0.8, 1.3, 1.5];
/// Roughness alphas that the models are compared at.
pub const ALPHAS: [f64; 4] = [0.05, 0.2, 0.5, 1.0];

/// Incoming lobes at and around the mirror direction, and what is reflected of them.
#[derive(Clone, Debug)]
pub struct Case {
    /// Distribution of the facets.
    pub ndf: Ndf,
    /// Roughness alpha.
    pub alpha: f64,
    /// Angle between view and normal, in radians.
    pub angle: f64,
    /// Sharpness of the incoming lobes.
    pub sharpness: f64,
    reflected: Vec<(Incoming, Vector3)>,
}

/// A dielectric in the red channel, white metal in the blue.
fn material(alpha: f64) -> Material {
    Material { diffuse: Vector3::zero(), specular: Vector3::new(0.04, 0.5, 1.0), alpha }
}

fn view(angle: f64) -> Vector3 {
    Vector3::new(angle.sin(), 0.0, angle.cos())
}

impl Case {
    /// By quadrature: 16 lobes whose axes lie up to five widths from the mirror direction.
    #[must_use]
    pub fn new(ndf: Ndf, alpha: f64, angle: f64, sharpness: f64) -> Self {
        let view = view(angle);
        let mirror = view.mirrored(NORMAL);
        let (x, y) = mirror.basis();
        let step = 0.5 * (alpha + 1.0 / sharpness.sqrt());
        let reflected = (0..16)
            .map(|index| {
                let offset = f64::from((index + 2) / 3) * step;
                let axis = mirror + [x, y, -y][index as usize % 3] * offset;
                let coefficient = Vector3::splat(1.0);
                let arriving = Incoming { axis: axis.normalized(), sharpness, coefficient };
                (arriving, quadrature(&arriving, &material(alpha), ndf, view, NORMAL))
            })
            .collect();
        Self { ndf, alpha, angle, sharpness, reflected }
    }

    /// Errors of a model over the brightest reflection: of white metal and of a dielectric of reflectance 0.04.
    #[must_use]
    pub fn errors(&self, model: Specular) -> Vec<[f64; 2]> {
        let brightest = |part: fn(Vector3) -> f64| {
            self.reflected.iter().map(|&(_, quadrature)| part(quadrature)).fold(0.0, f64::max)
        };
        let [white, dielectric] = [brightest(|color| color.z), brightest(|color| color.x)];
        let (material, view) = (material(self.alpha), view(self.angle));
        self.reflected
            .iter()
            .map(|(arriving, quadrature)| {
                let found = model.reflect(arriving, &material, self.ndf, view, NORMAL);
                [
                    (found.z - quadrature.z).abs() / white,
                    (found.x - quadrature.x).abs() / dielectric,
                ]
            })
            .collect()
    }
}

/// Root mean square of the errors of a model over cases: of white metal and of a dielectric.
#[must_use]
pub fn root_mean_square<'a>(cases: impl Iterator<Item = &'a Case>, model: Specular) -> [f64; 2] {
    let errors: Vec<[f64; 2]> = cases.flat_map(|case| case.errors(model)).collect();
    [0, 1].map(|part| {
        let sum: f64 = errors.iter().map(|error| error[part].powi(2)).sum();
        (sum / errors.len() as f64).sqrt()
    })
}

/// The cases of some roughness alphas, all angles and sharpnesses.
#[must_use]
pub fn cases(ndf: Ndf, alphas: &[f64]) -> Vec<Case> {
    let angles = alphas.iter().flat_map(|&alpha| ANGLES.map(|angle| (alpha, angle)));
    angles
        .flat_map(|(alpha, angle)| {
            SHARPNESSES.map(|sharpness| Case::new(ndf, alpha, angle, sharpness))
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_wider_filter_is_seen_and_nothing_has_no_error() {
        let cases = cases(Ndf::Ggx, &[0.5]);
        assert_eq!(cases.len(), ANGLES.len() * SHARPNESSES.len());
        let filtered = root_mean_square(cases.iter(), Specular::NdfFiltered);
        let lobe = root_mean_square(cases.iter(), Specular::Sg);
        assert!(filtered[0] > 0.0 && lobe[0] > 2.0 * filtered[0], "{filtered:?} {lobe:?}");
    }
}
