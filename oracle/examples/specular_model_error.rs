//! Prints the error of each specular model against quadrature, relative to the reflection of the same lobe from the
//! mirror direction: per roughness alpha and angle of the view, for incoming lobes of sharpness 5 and 100.
//!
//! `cargo run --release -p sglow-oracle --example specular_model_error`

use sglow_oracle::Vector3;
use sglow_oracle::brdf::{Material, Ndf};
use sglow_oracle::shade::specular::truth;
use sglow_oracle::shade::{Incoming, Specular};

const NORMAL: Vector3 = Vector3::new(0.0, 0.0, 1.0);

fn error(model: Specular, ndf: Ndf, alpha: f64, angle: f64, sharpness: f64) -> f64 {
    let view = Vector3::new(angle.sin(), 0.0, angle.cos());
    let material =
        Material { diffuse: Vector3::zero(), specular: Vector3::new(0.04, 0.5, 1.0), alpha };
    let arriving = |axis: Vector3| Incoming { axis, sharpness, coefficient: Vector3::splat(1.0) };
    let mirror = view.mirrored(NORMAL);
    let peak = truth(&arriving(mirror), &material, ndf, view, NORMAL).z;
    let (x, y) = mirror.basis();
    let offsets = (0..6).flat_map(|step| {
        let offset = f64::from(step) * 0.5 * (alpha + 1.0 / sharpness.sqrt());
        [x * offset, y * offset, y * -offset]
    });
    offsets
        .map(|offset| {
            let arriving = arriving((mirror + offset).normalized());
            let expected = truth(&arriving, &material, ndf, view, NORMAL).z;
            let found = model.reflect(&arriving, &material, ndf, view, NORMAL).z;
            (found - expected).abs() / peak
        })
        .fold(0.0, f64::max)
}

fn main() {
    for ndf in [Ndf::Ggx, Ndf::Beckmann] {
        for model in [Specular::Sg, Specular::Asg] {
            for alpha in [0.05, 0.2, 0.5] {
                for angle in [0.2, 0.8, 1.3] {
                    let errors =
                        [5.0, 100.0].map(|sharpness| error(model, ndf, alpha, angle, sharpness));
                    println!("{ndf:?} {model:?} alpha {alpha} angle {angle}: {errors:.3?}");
                }
            }
        }
    }
}
