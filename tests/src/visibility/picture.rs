//! What maps of lights bring to a picture: its distance from paths with them and without, by every metric.

use sglow_measure::light_maps::{self, base};
use sglow_results::picture_error::{Metric, PictureError};
use sglow_runtime::package::Package;
use sglow_runtime::settings::Settings;
use sglow_scene::Scene;
use sglow_shaders::{Emitter, Visibility};

use crate::common::{broken, gpu, whole_space};

/// A built-in scene with its reference of paths.
struct Case {
    name: &'static str,
    pictures: light_maps::Case,
}

impl Case {
    fn new(name: &'static str, paths: u32) -> Self {
        let scene = Scene::builtin(name).unwrap();
        let pictures = light_maps::Case::new(gpu(), whole_space(), scene, base(), paths).unwrap();
        Self { name, pictures }
    }

    /// How far the picture with a change of the settings is from paths.
    fn error(&self, change: impl FnOnce(&mut Settings)) -> PictureError {
        self.error_with(whole_space(), change)
    }

    fn error_with(&self, package: &Package, change: impl FnOnce(&mut Settings)) -> PictureError {
        self.pictures.error(gpu(), package, change).unwrap()
    }

    fn print(&self, what: &str, error: &PictureError) {
        let numbers = Metric::ALL.map(|metric| {
            let found = error.measured(metric);
            if metric.is_share() {
                format!("{metric} {:.1} ± {:.1} %", 100.0 * found.value, 100.0 * found.uncertainty)
            } else {
                format!("{metric} {:.4} ± {:.4}", found.value, found.uncertainty)
            }
        });
        println!("{} {what}: {}", self.name, numbers.join(", "));
    }
}

/// The metrics by which a picture is no closer to the reference than another.
fn lost(found: &PictureError, other: &PictureError) -> Vec<Metric> {
    Metric::ALL.into_iter().filter(|&metric| found.of(metric) >= other.of(metric)).collect()
}

/// By every metric. Negative controls, each by some metric further away than without maps: lights that their own texels hide;
/// lobes that lose light behind their surfaces, which without maps makes up for the shadows; metals whose hemisphere is about
/// the axis of a diffuse emission that they do not have.
#[test]
fn with_maps_a_picture_is_closer_to_paths() {
    let shadowed = |settings: &mut Settings| settings.visibility = Visibility::ShadowMap;
    // Of these small pictures 3.1, 4.0 and 7.5 % were measured (docs/numerics.md), and some room. The promised 3 % is that of the
    // report's larger pictures and is checked there (measure/src/frontier/promise.rs).
    for (name, bias) in [("cornell", 0.035), ("columns", 0.045), ("cornell-glossy", 0.08)] {
        let case = Case::new(name, 256);
        let none = case.error(|_| ());
        case.print("none", &none);
        for visibility in [Visibility::ShadowMap, Visibility::Imperfect] {
            let error = case.error(|settings| settings.visibility = visibility);
            case.print(&visibility.to_string(), &error);
            assert_eq!(lost(&error, &none), [], "{name}, {visibility}");
            let exact = visibility == Visibility::ShadowMap;
            assert!(!exact || error.bias.abs() < bias, "{name}: {}", error.bias);
        }
        match name {
            "columns" => {
                let error = case.error(|settings| {
                    shadowed(settings);
                    settings.near_scale = 0.0;
                });
                case.print("near_scale 0", &error);
                assert!(lost(&error, &none).contains(&Metric::Rmse));
            }
            "cornell" => {
                let lobe = |settings: &mut Settings| settings.emitter = Emitter::Lobe;
                let none = case.error(lobe);
                let error = case.error(|settings| {
                    shadowed(settings);
                    lobe(settings);
                });
                case.print("emitter lobe, none", &none);
                case.print("emitter lobe, shadow_map", &error);
                assert!(lost(&error, &none).contains(&Metric::Bias));
            }
            _ => {
                let metal = "select(vsgl.diffuse_axis, vsgl.specular_axis, metal)";
                let shade = "shade-cosine-fitted-asg-ggx-both-f32-shadow_map";
                let package = broken(shade, metal, "vsgl.diffuse_axis");
                let map = "light_shadow-both-f32";
                let text = package.text(map).unwrap().replace(metal, "vsgl.diffuse_axis");
                let error = case.error_with(&package.with_text(map, text), shadowed);
                case.print("the diffuse axis of metals", &error);
                assert!(lost(&error, &none).contains(&Metric::Rmse));
            }
        }
    }
}

/// The near distance: the least geometric mean of the relative MSE over three scenes. On the first two alone the error
/// falls with it; among many normals it lets light through what stands close.
#[test]
fn the_near_distance_is_better_than_what_else_was_tried() {
    let cases = ["cornell", "columns", "atrium"].map(|name| Case::new(name, 256));
    let mean = |near_scale: f32| {
        let logarithms = cases.iter().map(|case| {
            let error = case.error(|settings| {
                settings.visibility = Visibility::ShadowMap;
                settings.near_scale = near_scale;
            });
            error.relative_mse.ln()
        });
        let mean = (logarithms.sum::<f64>() / cases.len() as f64).exp();
        println!("near_scale {near_scale}: relative MSE {mean:.5}");
        mean
    };
    let best = mean(Settings::default().near_scale);
    for near_scale in [0.0, 1.0, 4.0, 8.0] {
        assert!(mean(near_scale) > best, "{near_scale} is no worse");
    }
}
