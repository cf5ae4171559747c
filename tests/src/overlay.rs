//! A method that is laid over the library renders: three passes on an axis and a parameter of their own, without Rust.

use std::path::PathBuf;

use sglow_graph::description::{Number, Setting};
use sglow_renderer::frame::{Frame, Pixels, Renderer};
use sglow_renderer::plan::{Plan, Surfaces};
use sglow_runtime::settings::Settings;
use sglow_scene::Scene;
use sglow_shader_gen::library::Library;

use crate::common::{gpu, packaged};

fn folder(path: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join(path)
}

fn library() -> Library {
    Library::load_with(&folder("../shaders"), &[folder("overlays/blur")])
        .unwrap_or_else(|report| panic!("{}", report.render(false)))
}

fn settings(denoise: &str, radius: u64) -> Settings {
    let denoise = Setting::Name(denoise.to_owned());
    let others = [("denoise", denoise), ("blur_radius", Setting::Number(Number::Whole(radius)))];
    let others = others.map(|(name, value)| (name.to_owned(), value)).into();
    Settings { size: [41, 27], map: 32, lights: 64, others, ..Settings::default() }
}

fn render(settings: &Settings) -> Frame {
    let (library, scene) = (library(), Scene::builtin("cornell").unwrap());
    let description = &library.frame().unwrap().description;
    let plan = Plan::new(description, settings, &Surfaces::of(&scene, false)).unwrap();
    let mut variants = library.variants();
    variants.retain(|variant| plan.variants.contains(&variant.id()));
    let package = packaged("the library with what is laid over it", &library, &variants);
    let renderer = Renderer::new(gpu(), &package, &scene, settings, 0).unwrap();
    renderer.render().unwrap();
    renderer.read().unwrap()
}

/// The mean along rows, then along columns, of what lies on the same smooth surface.
fn blurred(frame: &Frame, radius: usize) -> Pixels {
    let [width, height] = frame.size.map(|side| side as usize);
    let dot = |a: [f64; 3], b: [f64; 3]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let goes_on = |at: usize, other: usize| {
        let wide = |pixel: [f32; 4]| [0, 1, 2].map(|channel| f64::from(pixel[channel]));
        let (here, there) = (frame.gbuffer.position[at], frame.gbuffer.position[other]);
        let normals = [at, other].map(|at| wide(frame.gbuffer.normal[at]));
        let offset: [f64; 3] = std::array::from_fn(|i| wide(there)[i] - wide(here)[i]);
        here[3] >= 0.0
            && there[3] >= 0.0
            && dot(normals[0], normals[1]) >= 0.95
            && dot(normals[0], offset).abs() <= 0.25 * dot(offset, offset).sqrt()
    };
    let mask: Vec<bool> = (0..width * height)
        .map(|at| {
            let (x, y) = (at % width, at / width);
            let columns = [x.saturating_sub(1), (x + 1).min(width - 1)].map(|x| y * width + x);
            let rows = [y.saturating_sub(1), (y + 1).min(height - 1)].map(|y| y * width + x);
            columns.into_iter().chain(rows).all(|other| goes_on(at, other))
        })
        .collect();
    let along = |pixels: &Pixels, stride: usize, place: &dyn Fn(usize) -> usize, end: usize| {
        let mean = |at: usize| {
            if !mask[at] {
                return pixels[at];
            }
            let (own, mut all) = (place(at), vec![at]);
            let before = (1..=radius.min(own)).map(|far| at - far * stride);
            all.extend(before.take_while(|other| mask[*other]));
            let behind = (1..=radius.min(end - 1 - own)).map(|far| at + far * stride);
            all.extend(behind.take_while(|other| mask[*other]));
            std::array::from_fn(|channel| {
                let sum: f64 = all.iter().map(|other| f64::from(pixels[*other][channel])).sum();
                (sum / all.len() as f64) as f32
            })
        };
        (0..pixels.len()).map(mean).collect::<Pixels>()
    };
    let sharp = frame.indirect_diffuse.as_ref().unwrap();
    let rows = along(sharp, 1, &|at| at % width, width);
    along(&rows, width, &|at| at / width, height)
}

/// The largest difference over the largest value.
fn difference(one: &Pixels, other: &Pixels) -> f32 {
    let largest = one.iter().flatten().fold(0.0_f32, |most, value| most.max(value.abs()));
    let apart = one.iter().flatten().zip(other.iter().flatten());
    apart.fold(0.0_f32, |most, (a, b)| most.max((a - b).abs())) / largest
}

#[test]
fn a_method_that_is_laid_over_the_library_renders() {
    let sharp = render(&settings("none", 3));
    let own = Settings { others: Default::default(), ..settings("none", 3) };
    let diffuse = |frame: &Frame| frame.indirect_diffuse.clone().unwrap();
    assert_eq!(diffuse(&sharp), diffuse(&render(&own)), "its default changes nothing");
    let smooth = render(&settings("blur", 3));
    // Two means of seven numbers each.
    let tolerance = 16.0 * f32::EPSILON;
    let found = difference(&diffuse(&smooth), &blurred(&sharp, 3));
    assert!(found <= tolerance, "{found} > {tolerance}");
    // The parameter counts, and so does the method.
    for other in [blurred(&sharp, 2), diffuse(&sharp)] {
        assert!(difference(&diffuse(&smooth), &other) > 0.01);
    }
    // What is composed is what was smoothed.
    assert_ne!(sharp.radiance, smooth.radiance);
}

#[test]
fn settings_hold_what_they_have_no_field_for() {
    let mut settings = settings("none", 3);
    // An axis that has a field, and a value more in the library.
    settings.others.insert("space".to_owned(), Setting::Name(String::new()));
    settings.set("denoise", "blur").unwrap();
    settings.set("space", "tiles").unwrap();
    let configuration = settings.configuration();
    let axis = |name: &str| configuration.axes[name].as_str();
    assert_eq!((axis("denoise"), axis("space")), ("blur", "tiles"));
    assert_eq!(configuration.parameters["blur_radius"].real(), 3.0);
    assert_eq!(settings.get("space").as_deref(), Some("tiles"));
    settings.set("space", "world").unwrap();
    assert_eq!(settings.space, sglow_shaders::Space::World);
    assert_eq!(settings.configuration().axes["space"], "world");
    assert!(settings.set("denose", "blur").is_err());
    // Without a library that has the value it is none.
    assert!(Settings::default().set("space", "tiles").is_err());
}

/// An overlay may name the values of its axes by numbers: they are no parameters.
#[test]
fn a_value_that_is_a_number_stays_a_value() {
    let overlay = std::fs::read_to_string(folder("overlays/blur/library.toml")).unwrap();
    let made = tempfile::tempdir().unwrap();
    // The axis gets a value more, which is called 2.
    let more = "[[axis.denoise.value]]\nname = \"2\"\ndescription = \"two times\"\n\n[[pass]]";
    std::fs::write(made.path().join("library.toml"), overlay.replacen("[[pass]]", more, 1))
        .unwrap();
    std::fs::copy(folder("overlays/blur/frame.toml"), made.path().join("frame.toml")).unwrap();
    let sources = made.path().join("src/blur");
    std::fs::create_dir_all(&sources).unwrap();
    for entry in std::fs::read_dir(folder("overlays/blur/src/blur")).unwrap() {
        let entry = entry.unwrap();
        std::fs::copy(entry.path(), sources.join(entry.file_name())).unwrap();
    }
    let library = Library::load_with(&folder("../shaders"), &[made.path().to_owned()])
        .unwrap_or_else(|report| panic!("{}", report.render(false)));
    let mut settings = settings("none", 3);
    settings.set("denoise", "2").unwrap();
    settings.set("blur_radius", "4").unwrap();
    assert_eq!(settings.get("denoise").as_deref(), Some("2"));
    let configuration = settings.configuration();
    assert_eq!(configuration.axes["denoise"], "2");
    assert_eq!(configuration.parameters["blur_radius"], Number::Whole(4));
    assert!(!configuration.parameters.contains_key("denoise"));
    let description = &library.frame().unwrap().description;
    let scene = Scene::builtin("cornell").unwrap();
    Plan::new(description, &settings, &Surfaces::of(&scene, false)).unwrap();
    // A parameter takes numbers alone; what is advised keeps what is which.
    assert!(settings.set("blur_radius", "wide").is_err());
    let mut advising = description.clone();
    advising.preset.get_mut("tokuyoshi2016").unwrap().set.extend([
        ("denoise".to_owned(), Setting::Number(Number::Whole(2))),
        ("blur_radius".to_owned(), Setting::Number(Number::Whole(5))),
    ]);
    let advised = Settings::advised(&advising, &Default::default(), Some("tokuyoshi2016")).unwrap();
    assert_eq!(advised.others["denoise"], Setting::Name("2".to_owned()));
    assert_eq!(advised.others["blur_radius"], Setting::Number(Number::Whole(5)));
}

#[test]
fn what_it_does_not_know_is_refused() {
    let (library, scene) = (library(), Scene::builtin("cornell").unwrap());
    let description = &library.frame().unwrap().description;
    let surfaces = Surfaces::of(&scene, false);
    for (settings, wanted) in [
        (settings("sharpen", 3), "unknown value `sharpen`; expected one of none, blur"),
        (settings("blur", 17), "parameter `blur_radius` is 17"),
    ] {
        let text = Plan::new(description, &settings, &surfaces).unwrap_err().to_string();
        assert!(text.contains(wanted), "{text}");
    }
}
