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

/// Errors of a model: of the blue channel, which reflects everything, and of the red, a dielectric's.
fn errors(model: Specular, ndf: Ndf, alpha: f64, angle: f64, sharpness: f64) -> Vec<[f64; 2]> {
    let view = Vector3::new(angle.sin(), 0.0, angle.cos());
    let material =
        Material { diffuse: Vector3::zero(), specular: Vector3::new(0.04, 0.5, 1.0), alpha };
    let mirror = view.mirrored(NORMAL);
    let (x, y) = mirror.basis();
    let step = 0.5 * (alpha + 1.0 / sharpness.sqrt());
    let pairs: Vec<_> = (0..16)
        .map(|index| {
            let offset = f64::from((index + 2) / 3) * step;
            let axis = mirror + [x, y, -y][index as usize % 3] * offset;
            let coefficient = Vector3::splat(1.0);
            let arriving = Incoming { axis: axis.normalized(), sharpness, coefficient };
            let found = model.reflect(&arriving, &material, ndf, view, NORMAL);
            (found, truth(&arriving, &material, ndf, view, NORMAL))
        })
        .collect();
    let brightest =
        |part: fn(Vector3) -> f64| pairs.iter().map(|&(_, truth)| part(truth)).fold(0.0, f64::max);
    let [white, dielectric] = [brightest(|color| color.z), brightest(|color| color.x)];
    pairs
        .iter()
        .map(|(found, truth)| {
            [(found.z - truth.z).abs() / white, (found.x - truth.x).abs() / dielectric]
        })
        .collect()
}

/// The errors at one roughness, over all angles and sharpnesses.
fn over_angles(model: Specular, ndf: Ndf, alpha: f64) -> Vec<[f64; 2]> {
    let of_angle = |angle| SHARPNESSES.map(|sharpness| errors(model, ndf, alpha, angle, sharpness));
    ANGLES.into_iter().flat_map(of_angle).flatten().collect()
}

fn root_mean_square(errors: &[[f64; 2]]) -> [f64; 2] {
    [0, 1].map(|part| {
        let sum: f64 = errors.iter().map(|error| error[part].powi(2)).sum();
        (sum / errors.len() as f64).sqrt()
    })
}

fn main() {
    println!("{:41} sharpness {SHARPNESSES:?}", "");
    for ndf in [Ndf::Ggx, Ndf::Beckmann] {
        for model in [Specular::Sg, Specular::Asg, Specular::NdfFiltered] {
            if (model, ndf) == (Specular::NdfFiltered, Ndf::Beckmann) {
                continue;
            }
            let mut all = Vec::new();
            for alpha in [0.05, 0.2, 0.5, 1.0] {
                for angle in ANGLES {
                    let each = SHARPNESSES.map(|sharpness| {
                        let errors = errors(model, ndf, alpha, angle, sharpness);
                        all.extend_from_slice(&errors);
                        errors.iter().map(|error| error[0]).fold(0.0, f64::max)
                    });
                    let name = format!("{ndf:?} {model:?} alpha {alpha} angle {angle}");
                    println!("{name:41} {each:.3?}");
                }
            }
            let [white, dielectric] = root_mean_square(&all);
            println!("{ndf:?} {model:?}: white {white:.3}, dielectric {dielectric:.3}");
            for alpha in ALPHAS {
                let [white, dielectric] = root_mean_square(&over_angles(model, ndf, alpha));
                println!(
                    "{ndf:?} {model:?} alpha {alpha}: white {white:.3}, dielectric {dielectric:.3}"
                );
            }
        }
    }
}
