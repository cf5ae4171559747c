//! What a host computes, against the examples that a package has for hosts in other languages.

use std::collections::BTreeMap;

use glam::{DVec3, Vec3};
use serde_json::Value;
use sglow_renderer::host as of_surfaces;
use sglow_runtime::host;
use sglow_runtime::light::{LightView, Surroundings};
use sglow_scene::{Bounds, Light, LightKind};

use crate::common::library;

/// Arguments of an example.
struct Given<'a>(&'a BTreeMap<String, Value>);

impl Given<'_> {
    fn number(&self, name: &str) -> f32 {
        self.0[name].as_f64().unwrap() as f32
    }

    fn whole(&self, name: &str) -> u32 {
        self.0[name].as_u64().unwrap() as u32
    }

    fn is(&self, name: &str, value: &str) -> bool {
        self.0[name] == value
    }

    /// The view of the light; what an example leaves out does not count for its result.
    fn lit(&self) -> LightView {
        let number = |name: &str| self.0.get(name).and_then(Value::as_f64);
        // A directional light's image is a little larger than the scene.
        let radius = number("radius").or(number("half_extent").map(|extent| extent / 1.001));
        let around = Surroundings {
            origin: DVec3::ZERO,
            center: DVec3::ZERO,
            radius: radius.unwrap_or(1.0) as f32,
            map: self.whole("map"),
        };
        let intensity = self.0.get("intensity").and_then(Value::as_array);
        let intensity = intensity.map_or([1.0; 3], |all| {
            std::array::from_fn(|index| all[index].as_f64().unwrap() as f32)
        });
        let at = DVec3::new(0.0, 2.0, 0.0);
        match () {
            () if self.is("light", "directional") => {
                LightView::directional(&around, Vec3::NEG_Z, intensity)
            }
            () if self.is("light", "point") => LightView::point(&around, at, intensity),
            () => {
                let outer = self.number("tan_half_angle").atan();
                LightView::spot(&around, at, Vec3::NEG_Z, [0.0, outer], intensity)
            }
        }
    }

    fn view(&self) -> LightView {
        let kind = match () {
            () if self.is("light", "directional") => LightKind::Directional,
            () if self.is("light", "point") => LightKind::Point,
            () => LightKind::Spot { inner: self.number("inner"), outer: self.number("outer") },
        };
        let light = Light {
            name: String::new(),
            kind,
            position: [0.0, 2.0, 0.0],
            direction: [0.0, 0.0, -1.0],
            intensity: [1.0; 3],
            range: None,
            map_share: 1.0,
        };
        sglow_renderer::light::view(&light, &Bounds { min: [-1.0; 3], max: [1.0; 3] }, 16)
    }
}

/// An input as the runtime computes it.
fn computed(name: &str, given: &Given<'_>) -> f64 {
    let lobe = || given.is("emitter", "lobe");
    let sharpness = || f64::from(given.number("emission_sharpness"));
    f64::from(match name {
        "minimum_variance" => given.lit().minimum_variance,
        "power_unit" => given.lit().power_unit,
        "power_scale" => 1.0 / given.lit().power_unit,
        "diffuse_mean_length" if !lobe() => 1.0,
        "diffuse_mean_length" if given.is("sharpness", "toksvig") => {
            return host::mean_length_toksvig(sharpness());
        }
        "diffuse_mean_length" => return host::mean_length(sharpness()),
        "least_near" => host::least_near(given.number("radius")),
        "bias" => host::bias(given.number("bias_scale"), given.whole("tile")),
        "depth_bias" => of_surfaces::DEPTH_BIAS,
        "normal_offset" => {
            of_surfaces::normal_offset(given.number("minimum_variance"), given.whole("map"), 2048)
        }
        "light.cone_scale" => given.view().uniform.cone_scale,
        "light.cone_offset" => given.view().uniform.cone_offset,
        _ => panic!("the runtime computes no input `{name}`"),
    })
}

/// Whether a result is that of an example, within what 32 bits and a few operations leave.
fn agrees(result: f64, expected: f64) -> bool {
    (result - expected).abs() <= 4e-6 * expected.abs()
}

#[test]
fn inputs_are_what_the_examples_say() {
    let library = library();
    let names: Vec<_> = library.examples.keys().map(String::as_str).collect();
    assert!(names.len() >= 9, "{names:?}");
    for (name, examples) in &library.examples {
        for (index, example) in examples.iter().enumerate() {
            let result = computed(name, &Given(&example.given));
            assert!(agrees(result, example.result), "{name}, {index}: {result}, {example:?}");
            // A term too many is seen.
            assert!(example.result == 0.0 || !agrees(1.0001 * result, example.result), "{name}");
        }
    }
}

#[test]
fn a_package_has_the_examples() {
    let library = library();
    let text = include_str!("../../shaders/packages/sglow/inputs.json");
    let file: Value = serde_json::from_str(text).unwrap();
    assert_eq!(file["inputs"], serde_json::to_value(&library.examples).unwrap());
    let words = |name: &str| {
        let input = &library.frame().unwrap().description.input[name.split('.').next().unwrap()];
        input.description.clone()
    };
    assert!(library.examples.keys().all(|name| !words(name).is_empty()));
}
