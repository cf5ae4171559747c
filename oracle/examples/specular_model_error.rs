//! Prints the error of each specular model against quadrature, relative to the brightest of the reflections compared:
//! the largest over incoming lobes at and around the mirror direction, per roughness alpha and angle of the view, for
//! incoming lobes of sharpness 1, 5, 100 and 1000. Then each model's root mean square over everything, for a white
//! metal and, with Fresnel's term, for a dielectric; and last the same for each of more roughness alphas, which says where
//! which model is worth its time.
//!
//! `cargo run --release -p sglow-oracle --example specular_model_error`

use sglow_oracle::Vector3;
use sglow_oracle::brdf::{Material, Ndf};
use sglow_oracle::shade::specular::truth;
use sglow_oracle::shade::{Incoming, Specular};

const NORMAL: Vector3 = Vector3::new(0.0, 0.0, 1.0);
const SHARPNESSES: [f64; 4] = [1.0, 5.0, 100.0, 1000.0];
const ANGLES: [f64; 4] = [0.2, 0.8, 1.3, 1.5];
const ALPHAS: [f64; 9] = [0.01, 0.02, 0.05, 0.1, 0.2, 0.35, 0.5, 0.7, 1.0];
/// What the figures of the papers' forms are for.
const FEW_ALPHAS: [f64; 4] = [0.05, 0.2, 0.5, 1.0];

/// Incoming lobes at and around the mirror direction, and what is reflected of them.
struct Case {
    ndf: Ndf,
    alpha: f64,
    angle: f64,
    sharpness: f64,
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
    fn new(ndf: Ndf, alpha: f64, angle: f64, sharpness: f64) -> Self {
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
                (arriving, truth(&arriving, &material(alpha), ndf, view, NORMAL))
            })
            .collect();
        Self { ndf, alpha, angle, sharpness, reflected }
    }

    /// Errors of a model: of white metal and of a dielectric.
    fn errors(&self, model: Specular) -> Vec<[f64; 2]> {
        let brightest = |part: fn(Vector3) -> f64| {
            self.reflected.iter().map(|&(_, truth)| part(truth)).fold(0.0, f64::max)
        };
        let [white, dielectric] = [brightest(|color| color.z), brightest(|color| color.x)];
        let (material, view) = (material(self.alpha), view(self.angle));
        self.reflected
            .iter()
            .map(|(arriving, truth)| {
                let found = model.reflect(arriving, &material, self.ndf, view, NORMAL);
                [(found.z - truth.z).abs() / white, (found.x - truth.x).abs() / dielectric]
            })
            .collect()
    }
}

fn root_mean_square<'a>(cases: impl Iterator<Item = &'a Case>, model: Specular) -> [f64; 2] {
    let errors: Vec<[f64; 2]> = cases.flat_map(|case| case.errors(model)).collect();
    [0, 1].map(|part| {
        let sum: f64 = errors.iter().map(|error| error[part].powi(2)).sum();
        (sum / errors.len() as f64).sqrt()
    })
}

fn main() {
    println!("{:50} sharpness {SHARPNESSES:?}", "");
    for ndf in [Ndf::Ggx, Ndf::Beckmann] {
        let cases: Vec<Case> = ALPHAS
            .into_iter()
            .flat_map(|alpha| ANGLES.map(|angle| (alpha, angle)))
            .flat_map(|(alpha, angle)| {
                SHARPNESSES.map(|sharpness| Case::new(ndf, alpha, angle, sharpness))
            })
            .collect();
        let models = Specular::ALL.into_iter();
        for model in models.filter(|model| ndf == Ndf::Ggx || model.takes_any_distribution()) {
            for alpha in FEW_ALPHAS {
                for angle in ANGLES {
                    let at = |case: &&Case| case.alpha == alpha && case.angle == angle;
                    let each: Vec<f64> = cases
                        .iter()
                        .filter(at)
                        .map(|case| {
                            case.errors(model).iter().map(|error| error[0]).fold(0.0, f64::max)
                        })
                        .collect();
                    let name = format!("{ndf:?} {model:?} alpha {alpha} angle {angle}");
                    println!("{name:50} {each:.3?}");
                }
            }
            let few = cases.iter().filter(|case| FEW_ALPHAS.contains(&case.alpha));
            let [white, dielectric] = root_mean_square(few, model);
            println!("{ndf:?} {model:?}: white {white:.3}, dielectric {dielectric:.3}");
            for alpha in ALPHAS {
                let at = cases.iter().filter(|case| case.alpha == alpha);
                let [white, dielectric] = root_mean_square(at, model);
                println!(
                    "{ndf:?} {model:?} alpha {alpha}: white {white:.3}, dielectric {dielectric:.3}"
                );
            }
            for sharpness in SHARPNESSES {
                let at = cases.iter().filter(|case| case.sharpness == sharpness);
                let [white, dielectric] = root_mean_square(at, model);
                println!(
                    "{ndf:?} {model:?} sharpness {sharpness}: white {white:.3}, dielectric {dielectric:.3}"
                );
            }
        }
    }
}
