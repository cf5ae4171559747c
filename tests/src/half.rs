//! Precision f16 as a whole: any power, what it saves, what it costs.

use sglow_measure::halves::{Halved, measure};
use sglow_oracle::{Vector3, metrics};
use sglow_renderer::frame::Renderer;
use sglow_renderer::reference;
use sglow_runtime::package::Package;
use sglow_runtime::settings::Settings;
use sglow_scene::{LightKind, Scene};
use sglow_shaders::{Lobes, Precision};

use crate::common::{KINDS, broken, gpu, light};

fn run(name: &str, settings: &Settings) -> Halved {
    measure(gpu(), &Package::embedded(), &Scene::builtin(name).unwrap(), settings, 1).unwrap()
}

fn settings() -> Settings {
    Settings { size: [48, 32], rsm_size: 64, count: 128, ..Settings::default() }
}

/// Indirect light of a scene whose lights are `factor` times as strong, over that factor.
fn picture(name: &str, factor: f32, precision: Precision, package: &Package) -> Vec<f64> {
    let mut scene = Scene::builtin(name).unwrap();
    for light in &mut scene.lights {
        light.intensity = light.intensity.map(|channel| channel * factor);
    }
    let settings = Settings { precision, ..settings() };
    let renderer = Renderer::new(gpu(), package, &scene, &settings, 0).unwrap();
    renderer.render().unwrap();
    let frame = renderer.read().unwrap();
    let pixels = [frame.indirect_diffuse.unwrap(), frame.indirect_specular.unwrap()];
    pixels
        .iter()
        .flatten()
        .flat_map(|pixel| &pixel[..3])
        .map(|&part| f64::from(part / factor))
        .collect()
}

/// How far f16 with lights of a strength is from f32 with the scene's own: RMSE over mean, infinite if anything is not
/// finite.
fn difference(name: &str, factor: f32, package: &Package) -> f64 {
    let full = picture(name, 1.0, Precision::F32, &Package::embedded());
    let halved = picture(name, factor, Precision::F16, package);
    let metrics =
        metrics::compare_exact(halved.as_chunks::<3>().0, full.as_chunks::<3>().0).unwrap();
    if metrics.not_finite > 0 { f64::INFINITY } else { metrics.rmse_over_mean().value }
}

/// The share that halves may move the picture by: each power and each diffuse direction is rounded by up to one part in
/// two thousand at a few levels. The roundings of texels, lights and channels are independent; two of the largest, all to
/// one side, are more than they come to.
const PICTURE: f64 = 1e-3;

#[test]
fn any_power_goes_through_halves() {
    for name in ["cornell", "cornell-glossy", "atrium"] {
        for factor in [1e-20, 1.0, 1e20] {
            let difference = difference(name, factor, &Package::embedded());
            println!("{name} times {factor:e}: {difference:e}");
            assert!(difference < PICTURE, "{name} times {factor:e}: {difference}");
        }
    }
}

#[test]
fn powers_that_are_not_scaled_are_noticed() {
    let id = "moments-spot-both-f0-exact-f16";
    let package =
        broken(id, "let scale = sglow_moments_parameters.power_scale;", "let scale = 1.0;");
    for factor in [1e-20, 1e20] {
        let difference = difference("cornell-glossy", factor, &package);
        println!("unscaled, times {factor:e}: {difference:e}");
        assert!(difference > PICTURE, "{difference}");
    }
}

/// A power and a direction are rounded by up to one part in two thousand at each of a few levels, but not all to one
/// side. A sharpness of 2 of a mean length of 2/3 feels that threefold, and is a half itself.
#[test]
fn lights_keep_their_lobes() {
    for name in ["cornell", "cornell-glossy", "caustic", "columns", "atrium"] {
        let halved = run(name, &settings());
        println!("{name}: {halved:?}");
        assert!(halved.power < 2e-3, "{name}: {halved:?}");
        assert!(halved.direction < 1e-3, "{name}: {halved:?}");
        assert!(halved.mean_length < 2.2e-3, "{name}: {halved:?}");
    }
}

#[test]
fn halves_save_bytes() {
    let size = 256;
    for (lobes, expected) in [(Lobes::Both, [84, 60]), (Lobes::Diffuse, [52, 36])] {
        let mut settings =
            Settings { size: [8, 8], rsm_size: size, count: 1024, lobes, ..settings() };
        if lobes == Lobes::Diffuse {
            settings.set("specular", "none").unwrap();
            settings.set("ndf", "none").unwrap();
        }
        let halved = run("cornell", &settings);
        let texels: u64 = (0..=8).map(|level| u64::from(size >> level).pow(2)).sum();
        let lights = if lobes == Lobes::Both { [80, 48] } else { [48, 32] };
        for index in 0..2 {
            assert_eq!(
                halved.bytes[index],
                expected[index] * texels + 1024 * lights[index],
                "{lobes}"
            );
        }
        println!("{lobes}: {:?} bytes", halved.bytes);
    }
}

/// The unit of power brings the brightest photon of every kind of light below the largest half, and not far below.
#[test]
fn the_brightest_photon_is_near_the_largest_half() {
    for kind in KINDS {
        let view = light(kind, 64);
        let axis = match kind {
            LightKind::Spot { .. } => sglow_shaders::Light::Spot,
            LightKind::Directional => sglow_shaders::Light::Directional,
            LightKind::Point => sglow_shaders::Light::Point,
        };
        let light = reference::light(&view, axis);
        let powers =
            (0..64 * 64).map(|index| light.photon_power([index % 64, index / 64], [64; 2]));
        let brightest = powers.flat_map(Vector3::<f64>::to_array).fold(0.0, f64::max);
        let stored = |unit: f32| brightest / f64::from(unit);
        let fits = |stored: f64| stored > 8192.0 && stored <= 32768.0;
        assert!(fits(stored(view.power_unit)), "{kind:?}: {}", stored(view.power_unit));
        // Negative control: a unit two binades off.
        assert!(!fits(stored(view.power_unit / 4.0)) && !fits(stored(view.power_unit * 4.0)));
    }
}
