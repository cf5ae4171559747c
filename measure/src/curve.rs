//! Error along sharpness: what a plot shows that a maximum hides.

use rayon::prelude::*;
use sglow_renderer::device::Gpu;
use sglow_renderer::function::{Arguments, Function as Pipeline};
use sglow_results::stability::report::Point;
use sglow_runtime::package::Package;

use crate::function::Function;
use crate::hold::HoldError;

/// Sharpnesses of a curve, from 1e-6 to 1e9.
const SHARPNESSES: usize = 121;
/// Cosines at each: uniform in angle, and as many around the horizon.
const COSINES: usize = 96;

/// Follows a function of a cosine (component 0) and a sharpness (component 3) that has a reference.
///
/// # Errors
///
/// When the function cannot be run.
pub fn follow(
    gpu: &Gpu,
    package: &Package,
    function: &Function,
) -> Result<Option<Vec<Point>>, HoldError> {
    let Some(reference) = function.reference else {
        return Ok(None);
    };
    let mut inputs: Vec<Arguments> = Vec::with_capacity(SHARPNESSES * COSINES);
    for step in 0..SHARPNESSES {
        let sharpness = 10.0_f64.powf(-6.0 + 15.0 * step as f64 / (SHARPNESSES - 1) as f64);
        for index in 0..COSINES {
            let share = (index / 2) as f64 / (COSINES / 2 - 1) as f64;
            let cosine = if index % 2 == 0 {
                (core::f64::consts::PI * share).cos()
            } else {
                (8.0 / (1.0 + sharpness).sqrt() * (2.0 * share - 1.0)).clamp(-1.0, 1.0)
            };
            let mut arguments = [0.0; 12];
            #[expect(clippy::cast_possible_truncation, reason = "inputs are f32")]
            {
                arguments[0] = cosine as f32;
                arguments[3] = sharpness as f32;
            }
            inputs.push(arguments);
        }
    }
    let pipeline = Pipeline::new(gpu, package, &function.id())?;
    let measured = pipeline.evaluate(&inputs)?;
    let points = inputs
        .par_chunks(COSINES)
        .zip(measured.par_chunks(COSINES))
        .map(|(inputs, measured)| {
            let (mut model, mut total) = (0.0_f64, 0.0_f64);
            for (input, measured) in inputs.iter().zip(measured) {
                let exact = Function::exact(input);
                let (reference, peak) = (reference(exact)[0], (function.peak)(exact)[0]);
                let over = |value: f64| {
                    let error = (value - reference).abs() / peak.max(f64::MIN_POSITIVE);
                    if error.is_nan() { f64::INFINITY } else { error }
                };
                model = model.max(over((function.oracle)(exact)[0]));
                total = total.max(over(f64::from(measured[0])));
            }
            Point { sharpness: f64::from(inputs[0][3]), model, total }
        })
        .collect();
    Ok(Some(points))
}
