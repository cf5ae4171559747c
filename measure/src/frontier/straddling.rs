//! What kernels cost by straddling edges of depth and of normals: their texels summed exactly beside their lights.
//!
//! A light knows the means of what its kernel holds. With each light replaced by the texels of its kernel, by their
//! weights, what remains is the error of where kernels lie and how large they are; the rest is the form of a light.

use sglow_oracle::metrics::{self, Metrics};
use sglow_renderer::stages::Stages as _;
use sglow_renderer::{readback, reference};
use sglow_results::frontier::document::Straddling;
use sglow_shaders::SglowKernel;

use super::bench::no_density;
use super::evaluate::Evaluator;
use super::named;
use super::references::References;
use super::subject::{Drawn, FrontierError, Subject};
use crate::cache::Cache;
use crate::rivals::flicker::of_pixels;
use crate::rivals::overlap::weighted;

/// Lights and their kernels' texels against the sum over all texels, on the sample of pixels of `references`.
pub(super) fn straddling(
    subject: &Subject<'_>,
    references: &References,
    cache: &Cache,
) -> Result<Straddling, FrontierError> {
    let settings = named::kernels(&subject.base);
    cache.get(&subject.key("straddling", "default", &settings)?, || {
        let Drawn { renderer, frame, rsm } = subject.drawn()?;
        let (maps, _) = subject.maps(&settings, 0)?;
        let (lights, _) = subject.lights(&settings, &maps, 0)?;
        let made = reference::lights(subject.gpu, &lights)?;
        let evaluator = Evaluator::new(subject, references, frame, renderer.eye());
        let own = compared(&evaluator.by_oracle(&settings, &made), references);
        let texture = lights.density().ok_or_else(no_density)?;
        let side = texture.width() as usize;
        let density: Vec<f32> =
            readback::texture(subject.gpu, &texture, 0)?.iter().map(|one| one[0]).collect();
        let kernels = lights.kernels().map(|kernels| readback::buffer(subject.gpu, &kernels));
        let kernels: Vec<SglowKernel> = kernels.transpose()?.unwrap_or_default();
        let (_, coverage) = weighted(&density, side, &kernels);
        let counted = |[x, y]: [usize; 2]| coverage.counted()[y * side + x];
        let light = renderer.light();
        let texels = reference::counted_facets(light, renderer.indirect().settings(), rsm, counted);
        let receivers = reference::texels(&of_pixels(&frame.gbuffer, &references.sample));
        let eye = reference::vector(renderer.eye());
        let summed = texels.reflect(&receivers, eye, &|_| true).unwrap_or_default();
        let summed: Vec<[f64; 3]> = summed.iter().map(|one| one.total().to_array()).collect();
        let floor = compared(&summed, references);
        Ok(Straddling {
            size_factor: f64::from(settings.size_factor),
            lights_relative_mse: own.relative_mse.value,
            lights_median: own.median.value,
            texels_relative_mse: floor.relative_mse.value,
            texels_median: floor.median.value,
        })
    })
}

fn compared(found: &[[f64; 3]], references: &References) -> Metrics {
    metrics::compare_exact(found, &references.points).unwrap_or_default()
}
