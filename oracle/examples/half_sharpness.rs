//! What halves leave of the sharpness of specular lobes: three ways of storing the moments, compared with f64.
//!
//! A wall is lit at 45 degrees; a kernel covers 8 x 8 photons whose mirror directions span `spread` radians on each side,
//! and its moments go through three mip levels, each rounded. For each roughness alpha: the sharpness of the cluster, and
//! the largest relative error over random positions of
//! - `length`: direction and power in halves, the length kept to 1 - 2^-11, the longest that halves can tell from one;
//! - `complement`: beside them, in the direction's fourth channel, the mean of w/(l + 1); the spread of the axes, which is
//!   what the lengths lack beyond it, counts where it exceeds the steps of halves;
//! - `f32`: direction and weight in f32.
//!
//! `cargo run -p sglow-oracle --example half_sharpness`

use sglow_oracle::fis::stress::Random;
use sglow_oracle::{Real, Vector3};

/// Sums of a cluster: direction, weight, complement.
type Sums = ([f64; 3], f64, f64);

/// Means of four, stored.
fn level(finer: &[Sums], size: usize, store: impl Fn(f64) -> f64) -> Vec<Sums> {
    let half = size / 2;
    (0..half * half)
        .map(|index| {
            let first = 2 * (index / half) * size + 2 * (index % half);
            let mut mean = ([0.0; 3], 0.0, 0.0);
            for (direction, weight, complement) in
                [first, first + 1, first + size, first + size + 1].map(|at| finer[at])
            {
                for (sum, part) in mean.0.iter_mut().zip(direction) {
                    *sum += 0.25 * part;
                }
                mean.1 += 0.25 * weight;
                mean.2 += 0.25 * complement;
            }
            (mean.0.map(&store), store(mean.1), store(mean.2))
        })
        .collect()
}

fn cluster(photons: &[Sums], store: impl Fn(f64) -> f64 + Copy) -> Sums {
    let mut level_texels: Vec<Sums> = photons
        .iter()
        .map(|&(direction, weight, complement)| {
            (direction.map(store), store(weight), store(complement))
        })
        .collect();
    for size in [8, 4, 2] {
        level_texels = level(&level_texels, size, store);
    }
    level_texels[0]
}

fn length((direction, weight, _): Sums) -> f64 {
    direction.iter().map(|part| part * part).sum::<f64>().sqrt() / weight
}

fn main() {
    println!(
        "{:>8} {:>8} {:>12} {:>10} {:>12} {:>10}",
        "spread", "alpha", "sharpness", "length", "complement", "f32"
    );
    let half = |value: f64| value.to_half();
    #[expect(clippy::cast_possible_truncation, reason = "what f32 holds")]
    let single = |value: f64| f64::from(value as f32);
    for spread in [0.003, 0.01, 0.03, 0.1] {
        for alpha in [0.01, 0.02, 0.05, 0.1, 0.2, 0.5] {
            let mut random = Random::new(1);
            let (mut sharpness, mut errors) = (0.0, [0.0_f64; 3]);
            for _ in 0..200 {
                let facing =
                    Vector3::new(random.uniform() - 0.5, random.uniform() - 0.5, 1.0).normalized();
                let (x, y) = facing.basis();
                let photons: Vec<Sums> = (0..64)
                    .map(|index| {
                        let at = |index: usize| (index as f64 - 3.5) / 8.0 * spread;
                        let axis = (facing + x * at(index % 8) + y * at(index / 8)).normalized();
                        let lobe = 0.5 / (alpha * alpha) / core::f64::consts::FRAC_1_SQRT_2;
                        let weight = 1000.0 * (0.5 + random.uniform());
                        let direction = axis * (weight * lobe / (lobe + 1.0));
                        (direction.to_array(), weight, weight / (lobe + 1.0))
                    })
                    .collect();
                let of_length = |length: f64| length / (1.0 - length);
                let exact = of_length(length(cluster(&photons, |value| value)));
                let rounded = cluster(&photons, half);
                let from_length = of_length(length(rounded).min(1.0 - 1.0 / 2048.0));
                let share = rounded.2 / rounded.1;
                let apart = 1.0 - share - length(rounded);
                let apart = if apart > 1.0 / 1024.0 { apart } else { 0.0 };
                let from_complement = (1.0 - share - apart) / (share + apart);
                let from_single = of_length(length(cluster(&photons, single)));
                sharpness = exact;
                for (error, found) in
                    errors.iter_mut().zip([from_length, from_complement, from_single])
                {
                    *error = error.max((found / exact - 1.0).abs());
                }
            }
            let [length, complement, single] =
                errors.map(|error| format!("{:.2} %", 100.0 * error));
            println!(
                "{spread:>8} {alpha:>8} {sharpness:>12.1} {length:>10} {complement:>12} {single:>10}"
            );
        }
    }
}
