//! What bad input gets: an error that names the thing and what would be right, and no panic.

use sglow_renderer::device::{DeviceError, Gpu};
use sglow_renderer::frame::{FrameError, Renderer};
use sglow_runtime::execute::{Fault, Faults};
use sglow_runtime::indirect::{Indirect, IndirectError, PARTS};
use sglow_runtime::occluders::Occluders;
use sglow_runtime::package::{Package, PackageError};
use sglow_runtime::pipeline::PipelineError;
use sglow_runtime::settings::Settings;
use sglow_scene::Scene;
use sglow_shaders::{Cut, Emitter, Light, Ndf, Space, Specular, Visibility};

use crate::common::{broken, gpu, small};

fn refused(settings: &Settings) -> String {
    match Indirect::new(&gpu().device, &gpu().queue, settings) {
        Err(error @ IndirectError::Settings(_)) => error.to_string(),
        Err(error) => panic!("refused for another reason: {error}"),
        Ok(_) => panic!("{settings:?} went through"),
    }
}

#[test]
fn settings_that_cannot_be_are_told_all_at_once() {
    let settings = Settings {
        size: [0, 1_000_000],
        map: 0,
        camera_lights: 0,
        light: Light::Camera,
        lights: 0,
        size_factor: f32::NAN,
        iterations: 25,
        specular: Specular::None,
        ndf: Ndf::Ggx,
        ..small()
    };
    let text = refused(&settings);
    for part in [
        "`width` is 0",
        "`height` is 1000000",
        "`map` is 0; expected a whole number, at least 1",
        "`camera_lights` is 0",
        "light: spot, directional, point or several",
        "`lights` is 0",
        "`size_factor` is NaN",
        "`iterations` is 25; expected a whole number, at least 1, at most 24",
        "distribution-without-specular",
    ] {
        assert!(text.contains(part), "'{part}' is missing in: {text}");
    }
    assert_eq!(text.lines().count(), 9, "{text}");
}

#[test]
fn unknown_axes_and_values_list_the_known_ones() {
    let mut settings = small();
    let text = settings.set("colour", "red").unwrap_err().to_string();
    assert!(text.contains("'colour'") && text.contains("filter, kernel, light"), "{text}");
    let text = settings.set("kernel", "cubic").unwrap_err().to_string();
    assert!(text.contains("'cubic'") && text.contains("previous, modified"), "{text}");
    settings.set("kernel", "previous").unwrap();
}

#[test]
fn a_package_advises_settings_by_the_class_of_a_scene() {
    let package = Package::embedded();
    let description = package.description().unwrap();
    let advised = |occluders: bool, preset: Option<&str>| {
        let facts = [("occluders".to_owned(), occluders)].into();
        Settings::advised(description, &facts, preset)
    };
    let (open, closed) = (advised(false, None).unwrap(), advised(true, None).unwrap());
    assert_eq!((open.visibility, open.space), (Visibility::None, Space::None));
    assert_eq!((closed.visibility, closed.space), (Visibility::ShadowMap, Space::Tree));
    assert_eq!((closed.cut, closed.lights), (Cut::Tile, 256));
    let printed = advised(true, Some("tokuyoshi2016")).unwrap();
    assert_eq!((printed.emitter, printed.size_factor), (Emitter::Lobe, 1.0));
    let text = advised(true, Some("best")).unwrap_err().to_string();
    assert!(text.contains("`best`") && text.contains("tokuyoshi2016"), "{text}");
    // What is advised runs; a preset may need variants that the committed package has not.
    let made = |settings: Settings| {
        let small = Settings { size: [8, 8], map: 8, lights: 4, camera_lights: 4, ..settings };
        Indirect::new(&gpu().device, &gpu().queue, &small).map(drop)
    };
    made(open).unwrap();
    made(closed).unwrap();
    let text = made(printed).unwrap_err().to_string();
    assert!(
        text.contains("make it by: cargo xtask gen-shaders --out DIR --set emitter=lobe"),
        "{text}"
    );
}

#[test]
fn an_unknown_adapter_lists_the_known_ones() {
    let error = Gpu::open(Some("no such GPU")).err().unwrap();
    assert!(matches!(&error, DeviceError::UnknownAdapter { known, .. } if !known.is_empty()));
    assert!(error.to_string().contains(&gpu().adapter.name), "{error}");
}

#[test]
fn a_light_that_is_not_there_is_named() {
    let scene = Scene::builtin("cornell").unwrap();
    let error = Renderer::new(gpu(), &Package::embedded(), &scene, &small(), 3).err().unwrap();
    assert!(matches!(error, FrameError::NoSuchLight { index: 3, count: 1 }), "{error}");
}

#[test]
fn a_missing_variant_is_an_error_and_never_a_similar_one() {
    let error = Package::embedded()
        .text("sample-warped-modified-bracketed-exact-trace-exact-none")
        .unwrap_err();
    assert!(
        matches!(&error, PackageError::Missing { similar, .. } if similar.len() == 18),
        "{error}"
    );
    assert!(
        error.to_string().contains("sample-warped-modified-bracketed-exact-trace-exact-both-f32"),
        "{error}"
    );
}

#[test]
fn a_shader_that_does_not_compile_is_named() {
    let package = broken("mip-r32float-three", "0.25", "nonsense");
    let made = Indirect::of_parts(gpu().source(&package), &small(), &PARTS, &Occluders::default());
    let Err(IndirectError::Frame(Faults(faults))) = made else { panic!("it was not refused") };
    let [Fault::Pipeline(PipelineError::Refused { id, message })] = &faults[..] else {
        panic!("{faults:?}")
    };
    assert_eq!(id, "mip-r32float-three");
    assert!(message.contains("nonsense"), "{message}");
}

#[test]
fn a_lost_device_is_an_error() {
    let own = Gpu::open(None).unwrap();
    let scene = Scene::builtin("cornell").unwrap();
    let renderer = Renderer::new(&own, &Package::embedded(), &scene, &small(), 0).unwrap();
    renderer.render().unwrap();
    own.device.destroy();
    let error = renderer.render().err().unwrap();
    assert!(matches!(error, FrameError::Device(DeviceError::Lost { .. })), "{error}");
    assert!(error.to_string().contains("open a new one"), "{error}");
}

#[test]
fn a_point_light_needs_a_map_of_tiles() {
    let text = refused(&Settings { map: 33, light: Light::Point, ..small() });
    assert!(text.contains("map: a multiple of 4 with a point light"), "{text}");
}
