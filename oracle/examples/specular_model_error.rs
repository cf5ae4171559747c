//! Prints the error of each specular model against quadrature, relative to the brightest of the reflections compared:
//! the largest over incoming lobes at and around the mirror direction, per roughness alpha and angle of the view, for
//! incoming lobes of sharpness 1, 5, 100 and 1000. Then each model's root mean square over everything, for a white
//! metal and, with Fresnel's term, for a dielectric; and last the same for each of more roughness alphas, which says where
//! which model is worth its time.
//!
//! `cargo run --release -p sglow-oracle --example specular_model_error`

use sglow_oracle::brdf::Ndf;
use sglow_oracle::shade::Specular;
use sglow_oracle::shade::specular_error::{
    ALPHAS as FEW_ALPHAS, ANGLES, Case, SHARPNESSES, cases, root_mean_square,
};

const ALPHAS: [f64; 9] = [0.01, 0.02, 0.05, 0.1, 0.2, 0.35, 0.5, 0.7, 1.0];

fn main() {
    println!("{:50} sharpness {SHARPNESSES:?}", "");
    for ndf in [Ndf::Ggx, Ndf::Beckmann] {
        let cases = cases(ndf, &ALPHAS);
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
