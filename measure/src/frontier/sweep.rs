//! Error and time against one number: bisection steps, K, the number of virtual lights, the size of the light's map.

use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use sglow_oracle::rsm::{Moments, Pyramid, Weights};
use sglow_oracle::vsgl::{self, Vsgl};
use sglow_renderer::plan::Storage;
use sglow_renderer::stages::Stages as _;
use sglow_renderer::{readback, reference};
use sglow_results::frontier::document::{
    PictureError, Radiance, Series, Sweep, SweepOver, SweepPoint,
};
use sglow_results::frontier::promise;
use sglow_results::progress::Progress;
use sglow_results::rivals::method::SIZE_FACTORS;
use sglow_runtime::indirect::Indirect;
use sglow_runtime::light::LightView;
use sglow_runtime::settings::Settings;
use sglow_shaders::{Filter, Solver};

use super::bench::{RUNS, Timed, no_density};
use super::evaluate::{Evaluator, apart, over_mean};
use super::named;
use super::references::References;
use super::subject::{Drawn, FrontierError, Subject};
use super::together;
use crate::cache::Cache;

/// Bisection steps that are measured.
const ITERATIONS: [u32; 13] = [1, 2, 3, 4, 5, 6, 7, 8, 10, 12, 16, 20, 24];
/// Numbers of lights.
const LIGHTS: [u32; 7] = [16, 64, 128, 256, 512, 1024, 2048];

/// Numbers of a cut's roots.
const ROOTS: [u32; 4] = [16, 64, 256, 1024];
/// Widths and heights of the map in texels.
const MAPS: [u32; 6] = [64, 128, 256, 512, 1024, 2048];

/// What is found at one number.
#[derive(Clone, Serialize, Deserialize)]
struct At {
    timed: Timed,
    picture: PictureError,
    /// Indirect light of pixels that show a surface.
    indirect: Vec<[f64; 3]>,
}

/// All sweeps of a subject, without visibility: about kernels, and of lights and maps also about clusters and cuts.
pub(super) fn sweeps(
    subject: &Subject<'_>,
    references: &References,
    cache: &Cache,
    progress: &dyn Progress,
) -> Result<Vec<Sweep>, FrontierError> {
    let base = named::kernels(&subject.base);
    let filters: Vec<Filter> = Filter::ALL
        .into_iter()
        .filter(|&filter| filter == Filter::Exact || subject.gpu.filters_float32())
        .collect();
    let steps = filters.len() * (ITERATIONS.len() + 1)
        + SIZE_FACTORS.len()
        + 2 * LIGHTS.len()
        + ROOTS.len()
        + 2 * MAPS.len();
    progress.start(&format!("{}: iterations, K, lights, maps", subject.scene.name), steps);
    let mut done = 0;
    let mut of = |subject: &Subject<'_>, settings: &Settings| {
        let found = at(subject, references, cache, settings);
        done += 1;
        progress.done(done);
        found
    };
    let mut at = |settings: &Settings| of(subject, settings);
    let mut iterations = Vec::new();
    for filter in filters {
        // The bracketed solver finds the root that bisection comes closer to with each step.
        let base = Settings { filter, ..base.clone() };
        let limit = at(&base)?.indirect;
        let mut points = Vec::new();
        for steps in ITERATIONS {
            let settings =
                Settings { solver: Solver::Bisection, iterations: steps, ..base.clone() };
            points.push(point(f64::from(steps), &at(&settings)?, "sample", Some(&limit)));
        }
        iterations.push(series(filter.name().to_owned(), points));
    }
    iterations.push(modelled(subject, references, cache, &base)?);
    let mut sizes = Vec::new();
    let sized = SIZE_FACTORS.map(|size_factor| Settings { size_factor, ..base.clone() });
    for settings in &sized {
        sizes.push(point(f64::from(settings.size_factor), &at(settings)?, "sample", None));
    }
    // Smaller kernels flicker more: without it the smallest would always seem the best.
    let named: Vec<(String, &Settings)> =
        sized.iter().map(|one| (format!("K = {}", one.size_factor), one)).collect();
    for (point, flicker) in sizes.iter_mut().zip(together::flicker(subject, &named, cache)?) {
        point.flicker = Some(flicker);
    }
    let (clusters, cut) = bare(&subject.base);
    let mut lights = Vec::new();
    for (name, base, counts) in [
        ("kernels", &base, &LIGHTS[..]),
        ("clusters", &clusters, &LIGHTS),
        ("cut, by its roots", &cut, &ROOTS),
    ] {
        let mut points = Vec::new();
        for &count in counts {
            let settings = Settings { lights: count, ..base.clone() };
            points.push(point(f64::from(count), &at(&settings)?, "", None));
        }
        lights.push(series(name.to_owned(), points));
    }
    let mut maps = [("1024 clusters", clusters, Vec::new()), ("cut", cut, Vec::new())];
    for map in MAPS {
        let own = maps.each_ref().map(|(_, base, _)| Settings { map, ..base.clone() });
        // Clusters have the least buffers, so that their frame can be drawn wherever any can.
        let other = Subject::new(subject.gpu, subject.package, subject.scene, own[0].clone());
        for ((.., points), settings) in maps.iter_mut().zip(own) {
            if !binds(&other, &settings)? {
                continue;
            }
            points.push(point(f64::from(map), &of(&other, &settings)?, "", None));
        }
    }
    let maps = maps.map(|(name, _, points)| series(name.to_owned(), points));
    Ok(vec![
        Sweep {
            over: SweepOver::Iterations,
            limit: "the bracketed solver".to_owned(),
            series: iterations,
        },
        Sweep {
            over: SweepOver::SizeFactor,
            limit: String::new(),
            series: vec![series("exact".to_owned(), sizes)],
        },
        Sweep { over: SweepOver::Lights, limit: String::new(), series: lights },
        Sweep { over: SweepOver::Map, limit: String::new(), series: Vec::from(maps) },
    ])
}

/// Whether the device binds each buffer of a frame: the tree over a large map may be too large.
fn binds(subject: &Subject<'_>, settings: &Settings) -> Result<bool, FrontierError> {
    let limit = subject.gpu.device.limits().max_storage_buffer_binding_size;
    let plan = subject.plan(settings)?;
    let mut buffers = plan.resources.iter().filter(|one| one.storage == Storage::Buffer);
    Ok(buffers.all(|one| one.bytes <= limit))
}

/// 1024 clusters and a cut for each tile, without visibility.
fn bare(base: &Settings) -> (Settings, Settings) {
    let of = |wanted| {
        let all = named::configurations(base, base).into_iter();
        all.filter(|(name, _)| *name == wanted).map(|(_, one)| one).next().unwrap_or_default()
    };
    (of(promise::named::BARE_1024), of(promise::named::BARE))
}

fn at(
    subject: &Subject<'_>,
    references: &References,
    cache: &Cache,
    settings: &Settings,
) -> Result<At, FrontierError> {
    let name = format!("{} {} {}", settings.solver, settings.iterations, settings.size_factor);
    let name =
        format!("{} {name} {} {} {}", settings.filter, settings.space, settings.cut, settings.map);
    cache.get(&subject.key("sweep", &name, settings)?, || {
        let Drawn { renderer, frame, .. } = subject.drawn()?;
        let (maps, _) = subject.maps(settings, 0)?;
        let (lights, runs) = subject.lights(settings, &maps, RUNS)?;
        let shading = subject.shading(settings)?;
        let mut timed = Timed::of(&runs);
        timed.passes.extend(Timed::of(&subject.time_reflecting(&lights, &shading, RUNS)?).passes);
        let indirect = subject.reflect(&lights, None, &shading)?;
        let picture = Evaluator::new(subject, references, frame, renderer.eye()).picture(&indirect);
        let indirect = present(&indirect, references);
        Ok(At { timed, picture, indirect })
    })
}

/// What the weights of a hardware sampler do to the picture, by the oracle's sampling pass on the device's maps: a
/// software driver has no such weights. The limit is the same pass with exact weights and the bracketed solver, the
/// picture is that of the oracle on a sample of pixels.
fn modelled(
    subject: &Subject<'_>,
    references: &References,
    cache: &Cache,
    base: &Settings,
) -> Result<Series, FrontierError> {
    let key = subject.key("sweep of modelled weights", "default", base)?;
    let own: Vec<f64> = cache.get(&key, || {
        let Drawn { renderer, frame, .. } = subject.drawn()?;
        let (maps, _) = subject.maps(base, 0)?;
        let (lights, _) = subject.lights(base, &maps, 0)?;
        let evaluator = Evaluator::new(subject, references, frame, renderer.eye());
        let pyramids = Pyramids::read(subject, &lights, renderer.light())?;
        let picture = |weights, solver, iterations| {
            let settings = Settings { solver, iterations, ..base.clone() };
            evaluator.by_oracle(&settings, &pyramids.lights(weights, &settings, renderer.light()))
        };
        let limit = picture(Weights::Exact, Solver::Bracketed, 1);
        let own = |steps| {
            over_mean(
                apart(&picture(Weights::HARDWARE, Solver::Bisection, steps), &limit).0,
                &limit,
            )
        };
        Ok::<_, FrontierError>(ITERATIONS.map(own).to_vec())
    })?;
    let points = ITERATIONS.iter().zip(own).map(|(&steps, own)| SweepPoint {
        at: f64::from(steps),
        time: None,
        picture: None,
        own_rms_over_mean: Some(own),
        flicker: None,
    });
    let name = "hardware, weights of 8 bits (modelled)".to_owned();
    Ok(Series { name, points: points.collect(), pays_until: None })
}

/// Density and moments as the oracle takes them.
struct Pyramids {
    density: Pyramid<f64>,
    moments: Pyramid<Moments<f64>>,
}

impl Pyramids {
    fn read(
        subject: &Subject<'_>,
        lights: &Indirect,
        view: &LightView,
    ) -> Result<Self, FrontierError> {
        let Some(texture) = lights.density() else {
            return Err(no_density());
        };
        let (mut density, mut moments) = (Vec::new(), Vec::new());
        for level in 0..texture.mip_level_count() {
            let texels = readback::texture(subject.gpu, &texture, level)?;
            density.push(texels.iter().map(|texel| f64::from(texel[0])).collect());
            moments.push(reference::moments(subject.gpu, lights, view, level)?);
        }
        let size = texture.width() as usize;
        Ok(Self {
            density: Pyramid::of_levels(size, density)?,
            moments: Pyramid::of_levels(size, moments)?,
        })
    }

    fn lights(&self, weights: Weights, settings: &Settings, view: &LightView) -> Vec<Vsgl<f64>> {
        let density = self.density.clone().sampled_by(weights);
        let moments = self.moments.clone().sampled_by(weights);
        let how = reference::sample_settings(settings, view);
        (0..settings.lights)
            .into_par_iter()
            .map(|index| vsgl::sample(index, &density, &moments, &how).light)
            .collect()
    }
}

fn present(indirect: &Radiance, references: &References) -> Vec<[f64; 3]> {
    references.present.iter().map(|&at| indirect[at].map(f64::from)).collect()
}

/// A point of a line. Its time is that of one pass, or of all that make and reflect lights.
fn point(at: f64, found: &At, pass: &str, limit: Option<&Vec<[f64; 3]>>) -> SweepPoint {
    let counts = |name: &str| pass.is_empty() || name == pass;
    let passes = found.timed.passes.iter().filter(|pass| counts(&pass.name));
    SweepPoint {
        at,
        time: Some(passes.map(|pass| pass.time).sum()),
        picture: Some(found.picture),
        own_rms_over_mean: limit.map(|limit| over_mean(apart(&found.indirect, limit).0, limit)),
        flicker: None,
    }
}

/// A line, with where it stops paying: the least number from which on the error stays within 1 % of the least.
fn series(name: String, points: Vec<SweepPoint>) -> Series {
    let errors: Vec<f64> = points
        .iter()
        .map(|point| point.picture.map_or(f64::NAN, |one| one.rmse_over_mean))
        .collect();
    let least = errors.iter().copied().fold(f64::INFINITY, f64::min);
    let from = errors.iter().rposition(|&error| error.is_nan() || error > 1.01 * least);
    let from = from.map_or(0, |last| last + 1);
    // The last number has none after it that could show it to be enough.
    let pays_until = points.get(from).filter(|_| from + 1 < points.len()).map(|point| point.at);
    Series { name, points, pays_until }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_stops_paying_where_its_error_stays_low() {
        let line = |errors: &[f64]| {
            let point = |(at, &error): (usize, &f64)| SweepPoint {
                at: at as f64,
                time: None,
                picture: Some(PictureError { rmse_over_mean: error, ..PictureError::default() }),
                own_rms_over_mean: None,
                flicker: None,
            };
            series(String::new(), errors.iter().enumerate().map(point).collect()).pays_until
        };
        assert_eq!(line(&[3.0, 1.5, 1.0, 1.005, 1.0]), Some(2.0));
        assert_eq!(line(&[1.0, 2.0, 1.0, 1.0]), Some(2.0), "it has to stay low");
        assert_eq!(line(&[3.0, 2.0, 1.0]), None, "no end is seen");
        assert_eq!(line(&[1.0, 1.0]), Some(0.0));
        assert_eq!(line(&[1.0, f64::NAN]), None);
        assert_eq!(line(&[]), None);
    }
}
