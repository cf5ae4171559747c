//! One frame of a scene by every method: how evenly the density is shared out, and the error of the light.

use sglow_oracle::metrics;
use sglow_renderer::device::Gpu;
use sglow_renderer::frame::{FrameError, Renderer};
use sglow_renderer::stages::Stages as _;
use sglow_renderer::{readback, reference};
use sglow_results::rivals::method::Method;
use sglow_results::rivals::overlap::Weighted;
use sglow_results::rivals::survey::{Floor, Row, Survey};
use sglow_runtime::indirect::{Indirect, IndirectError, PARTS};
use sglow_runtime::occluders::Occluders;
use sglow_runtime::package::Package;
use sglow_shaders::SglowKernel;

use super::flicker::{indirect_at, of_pixels, some_pixels};
use super::method;
use super::overlap::{of_clusters, of_kernels, weighted};

/// The density and the kernels of a frame, to be drawn.
#[derive(Clone, Debug)]
pub struct Kernels {
    /// The density's side: a power of two.
    pub side: usize,
    /// Its texels.
    pub density: Vec<f32>,
    /// The kernels of `previous` and of `bracketed`.
    pub kernels: [Vec<SglowKernel>; 2],
}

/// Makes lights by every method, for the maps that `renderer` has drawn and with the density that its indirect light has
/// made, and compares them on `count` pixels. `warm_up` frames come before, for chains that need them.
///
/// # Errors
///
/// When a variant or the device does not allow it.
pub fn survey(
    gpu: &Gpu,
    package: &Package,
    renderer: &Renderer<'_>,
    methods: &[(Method, f32)],
    count: usize,
    warm_up: usize,
) -> Result<(Survey, Kernels), FrameError> {
    let own = renderer.indirect();
    let settings = own.settings();
    let inputs = renderer.inputs();
    let gbuffer = renderer.read_gbuffer()?;
    let pixels = some_pixels(&gbuffer, count);
    let surfaces = of_pixels(&gbuffer, &pixels);
    let rsm = renderer.read_rsm()?;
    let (view, eye) = (renderer.light(), renderer.eye());
    let reflected = reference::unshadowed(view, settings, &rsm, &surfaces, eye, |_, _| true);
    let expected: Vec<f64> =
        reflected.unwrap_or_default().iter().flat_map(|one| one.total().to_array()).collect();
    let missing = || IndirectError::Description("the frame has no density".to_owned());
    let texture = own.density().ok_or_else(missing)?;
    let density: Vec<f32> = readback::texture(gpu, &texture, 0)?.iter().map(|one| one[0]).collect();
    let side = texture.width() as usize;
    let moments = reference::moments::<f64>(gpu, own, view, 0)?;
    let photons: f64 = moments.iter().map(|one| one.weight()).sum();
    let mut rows = Vec::new();
    let mut drawn = [Vec::new(), Vec::new()];
    for &(method, size_factor) in methods {
        let mut settings = method::settings(method, settings);
        settings.size_factor = size_factor;
        let indirect =
            Indirect::of_parts(gpu.source(package), &settings, &PARTS, &Occluders::default())?;
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        indirect.encode_moments(&mut encoder, &inputs, None)?;
        indirect.encode_density_of(&mut encoder, own);
        indirect.encode_mips(&mut encoder, None)?;
        for _ in 0..=warm_up {
            indirect.encode_sample(&mut encoder, &inputs, None)?;
        }
        indirect.encode_shade(&mut encoder, &inputs.into(), None, None)?;
        gpu.queue.submit([encoder.finish()]);
        gpu.finish()?;
        let mut counted = None;
        let (overlap, weighted) = match indirect.assignment() {
            Some(assignment) => {
                let assigned: Vec<u32> = readback::buffer(gpu, &assignment)?;
                let map = settings.map as usize;
                let inside: Vec<f32> =
                    (0..map * map).map(|at| density[at / map * side + at % map]).collect();
                let count = settings.lights as usize;
                (of_clusters(&inside, &assigned, count), Weighted::PARTITION)
            }
            None => {
                let kernels = indirect.kernels().map(|kernels| readback::buffer(gpu, &kernels));
                let kernels: Vec<SglowKernel> = kernels.transpose()?.unwrap_or_default();
                let overlap = of_kernels(&density, side, &kernels);
                let (weighted, coverage) = weighted(&density, side, &kernels);
                counted = Some(coverage);
                match method {
                    Method::Previous if drawn[0].is_empty() => drawn[0] = kernels,
                    Method::Bracketed if drawn[1].is_empty() => drawn[1] = kernels,
                    _ => {}
                }
                (overlap, weighted)
            }
        };
        let floor = counted.map(|coverage| {
            let share = |[x, y]: [usize; 2]| coverage.counted()[y * side + x];
            let lights = reference::counted_facets(view, &settings, &rsm, share);
            let receivers = reference::texels(&surfaces);
            let summed = lights.reflect(&receivers, reference::vector(eye), &|_| true);
            let summed = summed.unwrap_or_default();
            let numbers: Vec<[f64; 3]> = summed.iter().map(|one| one.total().to_array()).collect();
            let compared = metrics::compare_exact(&numbers, expected.as_chunks::<3>().0);
            let compared = compared.unwrap_or_default();
            Floor {
                error: compared.rmse_over_mean().value,
                relative_mse: compared.relative_mse.value,
                median: compared.median.value,
            }
        });
        let lights = reference::lights::<f64>(gpu, &indirect)?;
        let powers: Vec<f64> = lights.iter().map(|light| light.power().luminance()).collect();
        let over = |power: f64| if photons > 0.0 { power / photons } else { 0.0 };
        let ours = indirect_at(gpu, &indirect, &pixels)?;
        let compared = metrics::compare_exact(ours.as_chunks::<3>().0, expected.as_chunks::<3>().0);
        let compared = compared.unwrap_or_default();
        rows.push(Row {
            method,
            size_factor,
            overlap,
            weighted,
            power: over(powers.iter().sum()),
            brightest: over(powers.iter().copied().fold(0.0, f64::max) * powers.len() as f64),
            error: compared.rmse_over_mean().value,
            relative_mse: compared.relative_mse.value,
            median: compared.median.value,
            q95: compared.quantile_95.value,
            bias: compared.bias.value,
            floor,
            not_finite: ours.iter().filter(|one| !one.is_finite()).count(),
        });
    }
    let dark = photons == 0.0;
    let survey = Survey { pixels: pixels.len(), dark, rows };
    Ok((survey, Kernels { side, density, kernels: drawn }))
}
