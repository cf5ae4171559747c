//! Fits the directional albedo of GGX: what white facets lose between them, and what Schlick's term adds. Both are rational
//! functions of the cosine c of the light and the roughness alpha a; the errors are printed for a finer grid than that of
//! the fit, with the constants as printed.
//!
//! `cargo run --release -p sglow-oracle --example fit_albedo`

mod minimax;

use sglow_oracle::brdf::albedo::quadrature;

/// Powers of c and a.
type Powers = &'static [(i32, i32)];

/// 1 - E of white facets: `a c` times the numerator over the denominator, the first of which has the coefficient 1.
const LOST: [Powers; 2] = [
    &[(0, 0), (0, 1), (1, 0), (0, 2)],
    &[(0, 1), (0, 2), (0, 3), (1, 0), (2, 0), (3, 0), (1, 1), (1, 2), (2, 1)],
];
/// E of Schlick's weight: `(1 - c)^4` times the numerator over the denominator.
const SCHLICK: [Powers; 2] =
    [&[(0, 0), (1, 0), (0, 1), (1, 1)], &[(0, 0), (1, 0), (0, 1), (2, 0), (1, 1), (0, 2)]];

struct Point {
    cosine: f64,
    alpha: f64,
    albedo: [f64; 2],
}

/// Cosines 0.001 to 1 and alphas 0.01 to 1, closer to each other where both are small.
fn points(cosines: u32, alphas: u32) -> Vec<Point> {
    let steps = |count: u32| (0..count).map(move |i| (f64::from(i) / f64::from(count - 1)).powi(2));
    steps(alphas)
        .flat_map(|alpha| steps(cosines).map(move |cosine| (cosine.max(1e-3), 0.01 + 0.99 * alpha)))
        .map(|(cosine, alpha)| Point { cosine, alpha, albedo: quadrature(cosine, alpha) })
        .collect()
}

fn polynomial(powers: Powers, coefficients: &[f64], point: &Point) -> f64 {
    let terms = powers.iter().map(|&(c, a)| point.cosine.powi(c) * point.alpha.powi(a));
    terms.zip(coefficients).map(|(term, coefficient)| term * coefficient).sum()
}

/// The errors: absolute of white facets, relative to a dielectric's albedo of Schlick's weight.
fn errors(part: usize, coefficients: &[f64], points: &[Point]) -> Vec<f64> {
    let [above, below] = [LOST, SCHLICK][part];
    let (numerator, denominator) = coefficients.split_at(above.len());
    let denominator: Vec<f64> = core::iter::once(1.0).chain(denominator.iter().copied()).collect();
    points
        .iter()
        .map(|point| {
            let quotient =
                polynomial(above, numerator, point) / polynomial(below, &denominator, point);
            if part == 0 {
                1.0 - point.cosine * point.alpha * quotient - point.albedo[0]
            } else {
                let found = (1.0 - point.cosine).powi(4) * quotient;
                (found - point.albedo[1]) / (0.04 + 0.96 * point.albedo[1])
            }
        })
        .collect()
}

fn main() {
    let (coarse, fine) = (points(28, 24), points(67, 53));
    for (part, name) in ["lost", "schlick"].into_iter().enumerate() {
        let [above, below] = [LOST, SCHLICK][part];
        let mut start = vec![0.1; above.len()];
        start.extend(vec![1.0; below.len() - 1]);
        let (found, _) =
            minimax::fit(|coefficients| errors(part, coefficients, &coarse), &start, 150);
        let rounded: Vec<f64> =
            found.iter().map(|value| format!("{value:.5e}").parse().unwrap_or(f64::NAN)).collect();
        let error = minimax::largest(&errors(part, &rounded, &fine));
        println!("{name}: {:?} over 1, {:?}", &rounded[..above.len()], &rounded[above.len()..]);
        println!("{name}: error at most {error:.5}");
    }
}
