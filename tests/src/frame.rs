//! Whole frames: the oracle goes through all stages by itself, from the surface textures to reflected radiance.

use sglow_oracle::rsm::{self, Moments, Pyramid};
use sglow_oracle::surface::SurfaceTexel;
use sglow_oracle::vsgl::{Lobe, PackedLobe, Vsgl, sample};
use sglow_oracle::{Vector3, metrics, shade};
use sglow_renderer::frame::{Frame, Renderer};
use sglow_renderer::reference;
use sglow_renderer::variants::Variants as _;
use sglow_runtime::package::Package;
use sglow_runtime::settings::Settings;
use sglow_scene::Scene;
use sglow_shaders::{Diffuse, Emitter, Kernel, Precision, Specular};

use crate::common::{broken, gpu, whole_space};

fn settings() -> Settings {
    Settings { size: [48, 32], map: 64, lights: 128, ..Settings::default() }
}

/// Relative difference of indirect light, root mean square over mean, between a frame and the oracle's.
fn difference(name: &str, settings: &Settings, package: &Package) -> f64 {
    let scene = Scene::builtin(name).unwrap();
    let renderer = Renderer::new(gpu(), package, &scene, settings, 0).unwrap();
    renderer.render().unwrap();
    let frame: Frame = renderer.read().unwrap();
    let settings = renderer.indirect().settings();
    let view = renderer.light();

    let size = settings.map as usize;
    let light = reference::light(view, settings.light);
    let origin = reference::vector(view.origin);
    let texels: Vec<SurfaceTexel> = reference::texels(&renderer.read_rsm().unwrap());
    let moments: Vec<Moments> = texels
        .iter()
        .enumerate()
        .map(|(index, texel)| {
            let power = light.photon_power([index % size, index / size], [size; 2]);
            let (towards, _) = light.towards(texel.position);
            let texel =
                reference::specular_power(settings.specular_power()).reflecting(texel, towards);
            rsm::moments(&texel, power, towards, origin, &reference::emission(settings))
        })
        .collect();
    let density: Vec<f64> = moments.iter().map(sglow_oracle::density::power).collect();
    let half = settings.precision == Precision::F16;
    let unit = f64::from(view.power_unit);
    let moments = if half {
        let moments = moments.into_iter().map(Moments::with_specular_weight).collect();
        Pyramid::build_stored::<f64>(size, moments, |texel| texel.to_half(unit)).unwrap()
    } else {
        Pyramid::build::<f64>(size, moments).unwrap()
    };
    let density = Pyramid::build::<f64>(size, density).unwrap();
    let sampling = reference::sample_settings(settings, view);
    let lights: Vec<Vsgl> = (0..settings.lights)
        .map(|index| sample(index, &density, &moments, &sampling).light)
        .map(|light| {
            let stored = |lobe: Lobe| if half { PackedLobe::of_lobe(&lobe).lobe() } else { lobe };
            let diffuse = stored(light.diffuse);
            let diffuse_mean_length = sglow_oracle::vmf::mean_length(diffuse.sharpness);
            let specular = light.specular.map(stored);
            Vsgl { diffuse, diffuse_mean_length, specular, ..light }
        })
        .collect();
    let model = reference::model(settings);
    let eye = reference::vector(renderer.eye());
    let mut expected = Vec::new();
    for surface in reference::texels(&frame.gbuffer) {
        let reflected: Vector3 =
            shade::shade(&surface, eye, lights.iter().copied(), &model).total();
        expected.extend(reflected.to_array());
    }
    let nothing = vec![[0.0; 4]; frame.direct.len()];
    let diffuse = frame.indirect_diffuse.as_ref().unwrap_or(&nothing);
    let specular = frame.indirect_specular.as_ref().unwrap_or(&nothing);
    let measured: Vec<f64> = diffuse
        .iter()
        .zip(specular)
        .flat_map(|(diffuse, specular)| {
            (0..3).map(move |channel| f64::from(diffuse[channel]) + f64::from(specular[channel]))
        })
        .collect();
    let metrics =
        metrics::compare_exact(measured.as_chunks::<3>().0, expected.as_chunks::<3>().0).unwrap();
    assert_eq!(metrics.not_finite, 0);
    assert!(metrics.reference_mean > 0.0, "{name} has no indirect light");
    metrics.rmse_over_mean().value
}

/// A kernel's level is found to one part in 2^12 of the range, and rounding may turn a bisection at its last step or
/// carry a centre over a texel's edge: a share of kernels below one in a hundred then moves by that much. Everything
/// else is a matter of a few ULP.
const TOLERANCE: f64 = 1e-3;

#[test]
fn agree_with_the_oracle() {
    for name in ["cornell", "cornell-glossy", "caustic", "columns", "atrium"] {
        for kernel in [Kernel::Previous, Kernel::Modified] {
            for precision in Precision::ALL {
                let settings = Settings { kernel, precision, ..settings() };
                let difference = difference(name, &settings, whole_space());
                println!("{name}, {kernel}, {precision}: {difference:e}");
                assert!(difference < TOLERANCE, "{name}, {kernel}, {precision}: {difference}");
            }
        }
    }
}

#[test]
fn other_reflections_agree_with_the_oracle() {
    for (diffuse, specular) in [
        (Diffuse::Gaussian, Specular::Sg),
        (Diffuse::None, Specular::Asg),
        (Diffuse::Constant, Specular::Sg),
    ] {
        // The papers' reflections go with the papers' emission.
        let settings = Settings { emitter: Emitter::Lobe, diffuse, specular, ..settings() };
        let difference = difference("cornell-glossy", &settings, whole_space());
        println!("{diffuse}, {specular}: {difference:e}");
        assert!(difference < TOLERANCE, "{diffuse}, {specular}: {difference}");
    }
}

#[test]
fn a_broken_stage_is_noticed() {
    let breaks = [
        (
            "sample-warped-modified-bracketed-exact-trace-exact-both-f32",
            "position.w / weight - dot(mean, mean)",
            "position.w / weight",
            "a variance around the origin",
        ),
        (
            "sample-warped-modified-bracketed-exact-trace-exact-both-f32",
            "var level = top - 1;",
            "var level = top - 2;",
            "a warp that starts a level too low",
        ),
        (
            "sample-warped-modified-bracketed-exact-trace-exact-both-f16",
            "sglow_filter(sglow_half_moments_texture, 2",
            "sglow_filter(sglow_half_moments_texture, 1",
            "another layer of halves",
        ),
        ("mip-rgba32float-three", "0.25 * (upper", "0.251 * (upper", "mips that gain"),
        (
            "shade-cosine-fitted-asg-ggx-both-f32-none",
            "reflected.diffuse *= surface.diffuse;",
            "",
            "a dropped reflectance",
        ),
    ];
    for (id, from, to, what) in breaks {
        let precision = if id.ends_with("f16") { Precision::F16 } else { Precision::F32 };
        let settings = Settings { precision, ..settings() };
        let difference = difference("cornell-glossy", &settings, &broken(id, from, to));
        println!("{what}: {difference:e}");
        assert!(difference > TOLERANCE, "{what} went unnoticed: {difference}");
    }
}

/// Times are of the work: on lavapipe the device's own stamps would show a thousandth of it.
#[test]
fn the_times_of_the_passes_add_up_to_the_frame() {
    let scene = Scene::builtin("cornell-glossy").unwrap();
    let settings = Settings { size: [256, 192], lights: 512, ..settings() };
    let renderer = Renderer::new(gpu(), &Package::embedded(), &scene, &settings, 0).unwrap();
    renderer.render().unwrap();
    let start = std::time::Instant::now();
    let times = renderer.render().unwrap();
    let whole = start.elapsed();
    let sum: std::time::Duration = times.passes.iter().map(|pass| pass.1).sum();
    println!("{sum:?} of {whole:?} by {}", times.clock);
    let labels: Vec<_> = times.passes.iter().map(|pass| pass.0.as_str()).collect();
    assert_eq!(
        labels,
        [
            "surface light",
            "surface camera",
            "shadow",
            "moments",
            "density",
            "mip moments",
            "mip density",
            "sample",
            "shade",
            "direct",
            "compose"
        ]
    );
    assert!(sum <= whole, "{sum:?} of {whole:?}");
    assert!(2 * sum >= whole, "{sum:?} of {whole:?}");
    // The negative control: without its longest pass the sum no longer does.
    let longest = times.passes.iter().map(|pass| pass.1).max().unwrap();
    assert!(2 * (sum - longest) < whole, "{longest:?} of {whole:?}");
}
