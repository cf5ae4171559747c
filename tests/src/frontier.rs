//! Error against time: what is measured of every configuration, that it is kept, and that what is wrong shows.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::sync::OnceLock;

use sglow_measure::cache::Cache;
use sglow_measure::frontier::configuration::{Allowed, allowed};
use sglow_measure::frontier::references::references;
use sglow_measure::frontier::space::Space;
use sglow_measure::frontier::subject::{FrontierError, Subject};
use sglow_measure::frontier::{buy, scene};
use sglow_results::frontier::choose::Budget;
use sglow_results::frontier::document::{Configuration, Metric, SceneReport};
use sglow_results::progress::Progress;
use sglow_runtime::package::Package;
use sglow_runtime::settings::Settings;
use sglow_scene::Scene;
use sglow_shaders::{Emitter, Lobes, Ndf, Specular};
use tempfile::TempDir;

use crate::common::gpu;

pub(crate) struct Silent;

impl Progress for Silent {
    fn start(&self, _: &str, _: usize) {}
    fn done(&self, _: usize) {}
}

fn base() -> Settings {
    Settings {
        size: [24, 18],
        map: 32,
        lights: 16,
        lobes: Lobes::Diffuse,
        specular: Specular::None,
        ndf: Ndf::None,
        emitter: Emitter::Lobe,
        ..Settings::default()
    }
}

/// Some diffuse configurations: two kernels, two forms of the cosine.
fn configurations() -> Vec<Settings> {
    let only = [
        "lobes=diffuse",
        "specular=none",
        "visibility=none",
        "draw=warped",
        "space=none",
        "precision=f32",
        "density=power",
        "filter=exact",
        "kernel=previous",
        "solver=none",
        "solver=bracketed",
        "kernel=modified",
        "diffuse=constant",
        "diffuse=fitted",
        "emitter=lobe",
        "variance=trace",
        "sharpness=exact",
    ];
    let only: Allowed = allowed(&only.map(str::to_owned), &base()).unwrap();
    let (package, facts) = (Package::embedded(), BTreeMap::new());
    Space::new(package.description().unwrap(), &facts).every(&base(), &only, &|_, _| true)
}

fn measure(package: &Package, folder: &Path) -> (SceneReport, [usize; 3]) {
    let scene = Scene::builtin("cornell").unwrap();
    let subject = Subject::new(gpu(), package, &scene, base());
    let cache = Cache::new(folder, false);
    let (report, pictures) =
        scene::scene(&subject, &configurations(), &BTreeSet::new(), &cache, &Silent).unwrap();
    for configuration in
        report.configurations.iter().filter(|configuration| configuration.is_shown())
    {
        assert_eq!(
            pictures.configurations[&configuration.name].len(),
            24 * 18,
            "{}",
            configuration.name
        );
        assert!(
            configuration.whole.is_some() && configuration.flicker.is_some(),
            "{}",
            configuration.name
        );
    }
    (report, cache.counts())
}

/// The first measurement, with the folder that keeps it.
fn first() -> &'static (SceneReport, [usize; 3], TempDir) {
    static FIRST: OnceLock<(SceneReport, [usize; 3], TempDir)> = OnceLock::new();
    FIRST.get_or_init(|| {
        let folder = tempfile::tempdir().unwrap();
        let (report, counts) = measure(&Package::embedded(), folder.path());
        (report, counts, folder)
    })
}

fn configuration<'a>(report: &'a SceneReport, name: &str) -> &'a Configuration {
    report.configurations.iter().find(|configuration| configuration.name == name).unwrap()
}

#[test]
fn every_configuration_is_measured_kept_and_measured_again_if_its_shader_changes() {
    let (report, [found, made, _], folder) = first();
    assert_eq!(report.configurations.len(), 4);
    assert!(found < made && *made > 10, "{found} {made}");
    assert_eq!(report.not_finite, 0);
    let default = configuration(report, "default");
    assert!(default.default && default.complete && default.passes.len() > 4);
    for configuration in &report.configurations {
        let sum: f64 = configuration.passes.iter().map(|pass| pass.time.median).sum();
        assert!(
            (configuration.time.median - sum).abs() < 1e-9 && sum > 0.0,
            "{}",
            configuration.name
        );
        assert!(
            configuration.picture.rmse_over_mean > 0.0
                && configuration.picture.rmse_over_mean < 10.0
        );
        // The device agrees with the oracle far better than the method with its reference.
        let rounding = configuration.rounding.as_ref().unwrap().rms_over_mean;
        let model = configuration.model_rms_over_mean.unwrap();
        assert!(
            rounding < 1e-4 && model > 100.0 * rounding,
            "{} {rounding} {model}",
            configuration.name
        );
        for metric in Metric::ALL {
            assert_ne!(
                configuration.on_frontier(metric),
                configuration.dominated.contains_key(&metric),
                "{metric}"
            );
        }
    }
    assert!(
        report
            .configurations
            .iter()
            .any(|configuration| configuration.on_frontier(Metric::default()))
    );

    // Nothing has changed: nothing is measured, and the numbers are the same.
    let (again, [found, made, outdated]) = measure(&Package::embedded(), folder.path());
    assert_eq!((again, made, outdated), (report.clone(), 0, 0));
    assert!(found > 10);

    // One shading variant is another text: what it takes part in is measured again, and its error shows.
    let id = default.variants.iter().find(|id| id.starts_with("shade-")).unwrap();
    let text = Package::embedded().text(id).unwrap().to_owned();
    let brighter = text.replace("diffuse *= surface.diffuse;", "diffuse *= 1.5 * surface.diffuse;");
    assert_ne!(text, brighter);
    let package = Package::embedded().with_text(id, brighter);
    let (wrong, [found, made, outdated]) = measure(&package, folder.path());
    // The reference, the maps, both kinds of lights, the other shading and its two verdicts stand.
    assert!(found >= 7 && outdated > 0 && outdated <= made, "{found} {made} {outdated}");
    let rounding = |report: &SceneReport, name| {
        configuration(report, name).rounding.as_ref().unwrap().rms_over_mean
    };
    assert!(rounding(&wrong, "default") > 0.1);
    assert_eq!(rounding(&wrong, "diffuse=constant"), rounding(report, "diffuse=constant"));
    assert!((configuration(&wrong, "default").picture.bias - default.picture.bias) > 0.3);
}

#[test]
fn maps_that_are_drawn_otherwise_have_another_reference() {
    let (scene, folder) = (Scene::builtin("cornell").unwrap(), tempfile::tempdir().unwrap());
    let reference = |package: &Package| {
        let subject = Subject::new(gpu(), package, &scene, base());
        let cache = Cache::new(folder.path(), false);
        let found = references(&subject, &cache, &Silent).unwrap();
        (found.reference.mean, cache.counts()[1])
    };
    let (mean, made) = reference(&Package::embedded());
    assert_eq!(made, 1);
    assert_eq!(reference(&Package::embedded()), (mean, 0));
    // Darker surfaces: the reference that was kept is that of others.
    let id = "surface-constant-opaque";
    let text = Package::embedded().text(id).unwrap().to_owned();
    let darker = text.replace("vec4<f32>(base_color.rgb,", "vec4<f32>(0.5 * base_color.rgb,");
    assert_ne!(text, darker);
    let (dark, made) = reference(&Package::embedded().with_text(id, darker));
    assert_eq!(made, 1);
    assert!(dark < 0.8 * mean, "{dark} {mean}");
}

#[test]
fn leaving_out_saves_what_it_should_and_changes_no_bit() {
    let pruned = first().0.pruned.as_ref().unwrap();
    assert_eq!(pruned.differing, 0);
    // Two of five layers of moments, and one of two pictures.
    let pyramid =
        |layers: u64| (0..6).map(|level| (32_u64 >> level).pow(2) * 16 * layers).sum::<u64>();
    // Measured on more pixels than the configurations.
    let [width, height] = pruned.size.map(u64::from);
    assert_eq!([width, height], [320, 180]);
    let picture = width * height * 16;
    let saved = pruned.full.texture_bytes - pruned.needed.texture_bytes;
    assert_eq!(saved, pyramid(2) + picture);
    assert!(pruned.full.buffer_bytes > pruned.needed.buffer_bytes);
}

#[test]
fn more_iterations_come_closer_to_the_root() {
    let iterations = &first().0.sweeps[0];
    let own = |at: usize| -> Vec<f64> {
        iterations.series[at].points.iter().map(|point| point.own_rms_over_mean.unwrap()).collect()
    };
    let modelled = iterations.series.len() - 1;
    for at in 0..modelled {
        assert!(own(at)[0] > 1e-3, "one step is not enough: {:?}", own(at));
        assert!(own(at).last().unwrap() < &1e-4, "24 steps are: {:?}", own(at));
    }
    // Weights of 8 bits leave an error that no step takes away.
    let last = *own(modelled).last().unwrap();
    assert!(last > 3.0 * own(0).last().unwrap() && last < 1e-2, "{last}");
    assert!(iterations.series[modelled].name.contains("modelled"));
    assert!(iterations.series[modelled].points.iter().all(|point| point.time.is_none()));
}

/// The flicker of each size of kernels is its own: at the size of the default it is what is measured of the default
/// apart.
#[test]
fn each_size_of_kernels_has_its_flicker_and_texels_summed_exactly_are_the_better_lights() {
    let report = &first().0;
    let sizes = &report.sweeps[1].series[0].points;
    assert_eq!((sizes[0].at, sizes[sizes.len() - 1].at), (0.125, 16.0));
    let own = configuration(report, "default").flicker.unwrap();
    let size = f64::from(base().size_factor);
    for point in sizes {
        let flicker = point.flicker.unwrap();
        println!("K = {}: flicker {flicker:.4}; the default {own:.4}", point.at);
        // Negative control: kernels of other sizes flicker otherwise.
        assert_eq!((flicker / own - 1.0).abs() < 1e-6, point.at == size, "K = {}", point.at);
    }
    assert!(sizes.iter().any(|point| point.at == size));
    // Narrow kernels flicker most: between two frames they move to other texels.
    let of = |at: usize| sizes[at].flicker.unwrap();
    assert!(of(0) > 1.3 * of(sizes.len() - 1), "{} {}", of(0), of(sizes.len() - 1));
    let straddling = &report.straddling;
    assert!(
        straddling.texels_relative_mse < 0.5 * straddling.lights_relative_mse,
        "{straddling:?}"
    );
    assert!(straddling.texels_median < straddling.lights_median, "{straddling:?}");
    assert_eq!(straddling.size_factor, report.size_factor);
}

#[test]
fn a_budget_buys_a_configuration_that_keeps_it_or_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let (scene, package) = (Scene::builtin("cornell").unwrap(), Package::embedded());
    let subject = Subject::new(gpu(), &package, &scene, base());
    let cache = Cache::new(folder.path(), false);
    let buy = |budget| {
        buy::buy(&subject, &configurations(), Metric::Rmse, budget, &cache, &Silent).unwrap()
    };
    let all = buy(Budget::Error(f64::MAX));
    let errors: Vec<f64> = all
        .configurations
        .iter()
        .map(|configuration| configuration.picture.rmse_over_mean)
        .collect();
    let least = errors.iter().copied().fold(f64::INFINITY, f64::min);
    let best = buy(Budget::Error(least));
    let first = best
        .configurations
        .iter()
        .find(|configuration| configuration.name == best.order[0])
        .unwrap();
    assert!(first.picture.rmse_over_mean <= least && first.whole.is_some());
    assert!(buy(Budget::Error(0.5 * least)).order.is_empty());
    assert!(buy(Budget::Milliseconds(1e-6)).order.is_empty());
    assert_eq!(buy(Budget::Milliseconds(1e9)).order[0], first.name);
}

#[test]
fn without_configurations_there_is_nothing_to_measure() {
    let folder = tempfile::tempdir().unwrap();
    let (scene, package) = (Scene::builtin("cornell").unwrap(), Package::embedded());
    let subject = Subject::new(gpu(), &package, &scene, base());
    let cache = Cache::new(folder.path(), false);
    let error = scene::scene(&subject, &[], &BTreeSet::new(), &cache, &Silent).err().unwrap();
    assert!(matches!(error, FrontierError::Nothing { .. }));
    // A variant that the package lacks is named, and none takes its place.
    let lacking = [Settings { diffuse: sglow_shaders::Diffuse::Erf, ..base() }];
    let error = scene::scene(&subject, &lacking, &BTreeSet::new(), &cache, &Silent)
        .err()
        .unwrap()
        .to_string();
    assert!(error.contains("shade-lobe-erf-none-none-diffuse-f32-none"), "{error}");
}
