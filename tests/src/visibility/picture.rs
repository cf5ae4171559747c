//! What maps of lights bring to a picture: its distance from paths with them and without, by every metric.

use sglow_measure::picture_error::{Display, Metric, Pair, PictureError, Radiance, compare};
use sglow_oracle::estimate::Estimate;
use sglow_runtime::frame::{Frame, Renderer};
use sglow_runtime::package::Package;
use sglow_runtime::reference;
use sglow_runtime::scene::Scene;
use sglow_runtime::settings::Settings;
use sglow_shaders::{Emitter, Visibility};

use crate::common::{broken, gpu, whole_space};

/// The built-in scenes in which something hides light.
const SCENES: [&str; 5] = ["cornell", "columns", "cornell-glossy", "caustic", "atrium"];

/// A scene with its reference of paths.
struct Case {
    name: &'static str,
    scene: Scene,
    base: Settings,
    /// Indirect light of both halves.
    halves: [Radiance; 2],
    /// Pixels that show a surface.
    present: Vec<usize>,
    /// Direct and emitted radiance.
    fixed: Radiance,
}

fn sum(one: &Radiance, other: &Radiance) -> Radiance {
    let both = one.iter().zip(other);
    both.map(|(one, other)| core::array::from_fn(|at| one[at] + other[at])).collect()
}

/// Some layers of a frame together.
fn layers(layers: &[Option<&Vec<[f32; 4]>>], pixels: usize) -> Radiance {
    layers.iter().flatten().fold(vec![[0.0; 3]; pixels], |found, layer| {
        sum(&found, &layer.iter().map(|&[r, g, b, _]| [r, g, b]).collect())
    })
}

impl Case {
    fn new(name: &'static str, base: Settings, paths: u32) -> Self {
        let scene = Scene::builtin(name).unwrap();
        let renderer = Renderer::new(gpu(), whole_space(), &scene, &base, 0).unwrap();
        renderer.render().unwrap();
        let frame = renderer.read().unwrap();
        let (light, eye) = (renderer.light(), renderer.eye());
        let settings = renderer.indirect().settings();
        let surfaces = &frame.gbuffer;
        let go_on = |_, _| true;
        let estimates =
            reference::path_halves(light, settings, &scene, surfaces, eye, paths, 2016, go_on);
        let estimates: Vec<[Estimate; 2]> = estimates.unwrap().unwrap();
        let pixels = surfaces.position.len();
        Self {
            halves: [0, 1].map(|half: usize| {
                let light = estimates.iter().map(|both| both[half].mean.total().to_array());
                light.map(|pixel| pixel.map(|value| value as f32)).collect()
            }),
            present: (0..pixels).filter(|&at| surfaces.position[at][3] >= 0.0).collect(),
            fixed: layers(&[Some(&frame.direct), frame.emission.as_ref()], pixels),
            name,
            scene,
            base,
        }
    }

    fn frame(&self, settings: &Settings, package: &Package) -> Frame {
        let renderer = Renderer::new(gpu(), package, &self.scene, settings, 0).unwrap();
        renderer.render().unwrap();
        renderer.read().unwrap()
    }

    /// How far the picture with a change of the settings is from paths.
    fn error(&self, change: impl FnOnce(&mut Settings)) -> PictureError {
        self.error_with(whole_space(), change)
    }

    fn error_with(&self, package: &Package, change: impl FnOnce(&mut Settings)) -> PictureError {
        let mut settings = self.base.clone();
        change(&mut settings);
        let frame = self.frame(&settings, package);
        let parts = [frame.indirect_diffuse.as_ref(), frame.indirect_specular.as_ref()];
        let picture = layers(&parts, self.fixed.len());
        let whole = self.halves.each_ref().map(|half| sum(&self.fixed, half));
        compare(&Pair {
            size: settings.size,
            present: Some(&self.present),
            picture: &picture,
            halves: self.halves.each_ref(),
            whole: &sum(&self.fixed, &picture),
            whole_halves: whole.each_ref(),
            display: Display::Automatic,
        })
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

/// Kernels of a quarter of their share of the map, which were measured to be the better ones.
fn base() -> Settings {
    Settings { size: [48, 27], size_factor: 0.25, ..Settings::default() }
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
    for (name, bias) in [("cornell", 0.035), ("columns", 0.045), ("cornell-glossy", 0.08)] {
        let case = Case::new(name, base(), 256);
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
    let cases = ["cornell", "columns", "atrium"].map(|name| Case::new(name, base(), 256));
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

/// Every parameter of lights' maps against paths, on all scenes or those named in `SGLOW_SCENES`, with commas.
#[test]
#[ignore = "prints tables, for minutes"]
fn what_each_parameter_of_maps_brings() {
    let chosen = std::env::var("SGLOW_SCENES").unwrap_or_else(|_| SCENES.join(","));
    for name in SCENES.into_iter().filter(|name| chosen.split(',').any(|one| one == *name)) {
        let case = Case::new(name, base(), 1024);
        case.print("none", &case.error(|_| ()));
        for visibility in [Visibility::ShadowMap, Visibility::Imperfect] {
            let print = |what: &str, change: &dyn Fn(&mut Settings)| {
                let error = case.error(|settings| {
                    settings.visibility = visibility;
                    change(settings);
                });
                case.print(&format!("{visibility}{what}"), &error);
            };
            print("", &|_| ());
            for near_scale in [0.0, 1.0, 1.25, 1.75, 2.0, 3.0, 4.0, 8.0] {
                print(&format!(", near_scale {near_scale}"), &|settings| {
                    settings.near_scale = near_scale;
                });
            }
            for bias_scale in [0.5, 2.0] {
                print(&format!(", bias_scale {bias_scale}"), &|settings| {
                    settings.bias_scale = bias_scale;
                });
            }
            // Imperfect maps have 64 texels at most.
            let widest = if visibility == Visibility::Imperfect { 64 } else { 128 };
            for light_tile in [32, 128].into_iter().filter(|&tile| tile <= widest) {
                print(&format!(", tile {light_tile}"), &|settings| {
                    settings.light_tile = light_tile
                });
            }
        }
    }
}
