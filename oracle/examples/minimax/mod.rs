//! Minimax fits: least squares whose weights grow where the error is largest [Lawson 1961], for functions that are
//! linear in their coefficients, rational, or anything else.

#![allow(dead_code, reason = "each of the programs that include this uses a part")]

/// A dense linear least-squares problem `rows x = right`, solved by Householder reflections with scaled columns.
fn least_squares(mut rows: Vec<Vec<f64>>, mut right: Vec<f64>, damping: f64) -> Option<Vec<f64>> {
    let count = rows.first()?.len();
    let scales: Vec<f64> = (0..count)
        .map(|column| rows.iter().map(|row| row[column].powi(2)).sum::<f64>().sqrt().max(1e-300))
        .collect();
    for row in &mut rows {
        row.iter_mut().zip(&scales).for_each(|(value, scale)| *value /= scale);
    }
    if damping > 0.0 {
        for column in 0..count {
            let mut row = vec![0.0; count];
            row[column] = damping;
            rows.push(row);
            right.push(0.0);
        }
    }
    let height = rows.len();
    for column in 0..count {
        let norm = (column..height).map(|i| rows[i][column].powi(2)).sum::<f64>().sqrt();
        if norm <= 0.0 || !norm.is_finite() {
            return None;
        }
        let alpha = if rows[column][column] > 0.0 { -norm } else { norm };
        let mut reflector: Vec<f64> = (column..height).map(|i| rows[i][column]).collect();
        reflector[0] -= alpha;
        let square: f64 = reflector.iter().map(|v| v * v).sum();
        for other in column..count {
            let dot: f64 =
                reflector.iter().zip(&rows[column..]).map(|(v, row)| v * row[other]).sum();
            for (v, row) in reflector.iter().zip(&mut rows[column..]) {
                row[other] -= 2.0 * dot / square * v;
            }
        }
        let dot: f64 = reflector.iter().zip(column..).map(|(v, i)| v * right[i]).sum();
        for (v, i) in reflector.iter().zip(column..) {
            right[i] -= 2.0 * dot / square * v;
        }
    }
    let mut solution = vec![0.0; count];
    for row in (0..count).rev() {
        let known: f64 = (row + 1..count).map(|i| rows[row][i] * solution[i]).sum();
        solution[row] = (right[row] - known) / rows[row][row];
    }
    solution.iter_mut().zip(&scales).for_each(|(value, scale)| *value /= scale);
    Some(solution)
}

/// The largest magnitude.
pub(crate) fn largest(errors: &[f64]) -> f64 {
    errors.iter().fold(0.0, |most, error| most.max(error.abs()))
}

/// Lawson's step: a point's weight is multiplied by a power of its error.
fn reweigh(weights: &mut [f64], errors: &[f64], power: f64) {
    let most = largest(errors);
    for (weight, error) in weights.iter_mut().zip(errors) {
        *weight *= (error.abs() / most + 1e-3).powf(power);
    }
    let mean = weights.iter().sum::<f64>() / weights.len() as f64;
    weights.iter_mut().for_each(|weight| *weight /= mean);
}

/// The rational function `sum n_i x^i / (1 + sum d_i x^i)` of least largest relative error: numerator, denominator
/// (its 1 included), error.
pub(crate) fn rational(
    points: &[f64],
    target: impl Fn(f64) -> f64,
    numerator: usize,
    denominator: usize,
) -> (Vec<f64>, Vec<f64>, f64) {
    let values: Vec<f64> = points.iter().map(|&x| target(x)).collect();
    let mut weights = vec![1.0_f64; points.len()];
    let mut last = vec![1.0_f64; points.len()];
    let mut best = (Vec::new(), Vec::new(), f64::INFINITY);
    for _ in 0..600 {
        // Linearised with the last denominator [Sanathanan and Koerner 1963].
        let rows = points
            .iter()
            .zip(&values)
            .zip(weights.iter().zip(&last))
            .map(|((&x, &value), (weight, last))| {
                let scale = weight.sqrt() / (last * value);
                let top = (0..=numerator).map(|i| scale * x.powi(i as i32));
                let bottom = (1..=denominator).map(|i| -scale * value * x.powi(i as i32));
                top.chain(bottom).collect()
            })
            .collect();
        let right = weights.iter().zip(&last).map(|(weight, last)| weight.sqrt() / last).collect();
        let Some(solution) = least_squares(rows, right, 0.0) else { break };
        let (top, bottom) = solution.split_at(numerator + 1);
        let bottom: Vec<f64> = core::iter::once(1.0).chain(bottom.iter().copied()).collect();
        last = points.iter().map(|&x| horner(&bottom, x).abs().max(1e-6)).collect();
        let errors: Vec<f64> = points
            .iter()
            .zip(&values)
            .map(|(&x, value)| horner(top, x) / horner(&bottom, x) / value - 1.0)
            .collect();
        let error = largest(&errors);
        if error < best.2 && last.iter().all(|&value| value > 1e-6) {
            best = (top.to_vec(), bottom, error);
        }
        reweigh(&mut weights, &errors, 0.5);
    }
    best
}

/// A polynomial, lowest coefficient first.
pub(crate) fn horner(coefficients: &[f64], x: f64) -> f64 {
    coefficients.iter().rev().fold(0.0, |sum, coefficient| sum * x + coefficient)
}

/// Parameters of least largest residual near a start: Lawson's weights around Levenberg-Marquardt steps.
pub(crate) fn fit(
    residuals: impl Fn(&[f64]) -> Vec<f64>,
    start: &[f64],
    rounds: usize,
) -> (Vec<f64>, f64) {
    let mut now = start.to_vec();
    let mut errors = residuals(&now);
    let mut weights = vec![1.0_f64; errors.len()];
    let mut best = (now.clone(), largest(&errors));
    let mut damping: f64 = 1e-2;
    let cost = |errors: &[f64], weights: &[f64]| -> f64 {
        errors.iter().zip(weights).map(|(error, weight)| weight * error * error).sum()
    };
    for _ in 0..rounds {
        for _ in 0..4 {
            let columns: Vec<Vec<f64>> = (0..now.len())
                .map(|i| {
                    let step = 1e-6 * now[i].abs().max(1e-2);
                    let mut moved = now.clone();
                    moved[i] += step;
                    residuals(&moved).iter().zip(&errors).map(|(a, b)| (a - b) / step).collect()
                })
                .collect();
            let mut moved = false;
            for _ in 0..10 {
                let rows = (0..errors.len())
                    .map(|i| columns.iter().map(|column| column[i] * weights[i].sqrt()).collect())
                    .collect();
                let right = errors.iter().zip(&weights).map(|(e, w)| -e * w.sqrt()).collect();
                let Some(step) = least_squares(rows, right, damping) else { break };
                let next: Vec<f64> = now.iter().zip(&step).map(|(a, b)| a + b).collect();
                let found = residuals(&next);
                if cost(&found, &weights) < cost(&errors, &weights) {
                    (now, errors, moved) = (next, found, true);
                    damping = (damping * 0.4).max(1e-8);
                    break;
                }
                damping *= 3.0;
            }
            if !moved {
                damping = 1e-2;
                break;
            }
            if largest(&errors) < best.1 {
                best = (now.clone(), largest(&errors));
            }
        }
        reweigh(&mut weights, &errors, 0.6);
    }
    best
}
