//! Fits the one constant of the NDF filter: how wide a GGX distribution has to be for its peak to be that of a GGX
//! distribution convolved with a Gaussian, `1 + x + k log2(1 + x)` in units of the former's width, x the Gaussian's.
//!
//! `cargo run --release -p sglow-oracle --example ndf_filter_fit`

use sglow_oracle::quadrature::gauss_legendre;

/// The width over that of the distribution itself: GGX is a mixture of Gaussians of the widths 1/t, by exp(-t), so that
/// the peak of the convolution is the integral of t exp(-t) / (1 + x t).
fn width(x: f64) -> f64 {
    let rule = gauss_legendre(32);
    let peak: f64 = (0..64)
        .flat_map(|panel| rule.iter().map(move |&(node, weight)| (panel, node, weight)))
        .map(|(panel, node, weight)| {
            // Panels that shrink towards 0, where the integrand bends for large x.
            let edge = |index: i32| 40.0 * (f64::from(index) / 64.0).powi(4);
            let (low, high) = (edge(panel), edge(panel + 1));
            let t = 0.5 * (low + high) + 0.5 * (high - low) * node;
            0.5 * (high - low) * weight * t * (-t).exp() / (1.0 + x * t)
        })
        .sum();
    1.0 / peak
}

fn main() {
    let points: Vec<(f64, f64)> =
        (-60..=60).map(|step| 10f64.powf(f64::from(step) * 0.1)).map(|x| (x, width(x))).collect();
    let error = |k: f64| {
        points
            .iter()
            .map(|&(x, quadrature)| ((1.0 + x + k * (1.0 + x).log2()) / quadrature - 1.0).abs())
            .fold(0.0, f64::max)
    };
    let best = (0..=1000)
        .map(|step| f64::from(step) * 1e-3)
        .min_by(|a, b| error(*a).total_cmp(&error(*b)))
        .unwrap_or_default();
    println!("k = {best:.3}: relative error of the peak at most {:.4}", error(best));
    println!("k = 0: {:.4}", error(0.0));
}
