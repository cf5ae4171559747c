//! The whole pipeline in extreme cases, its variants side by side.

mod far;
mod outcome;

use crate::bound;
pub use far::without_origin;
pub use outcome::ExtremeError;
use outcome::{Outcome, render, verdict};
use sglow_oracle::fis::stress::{Random, Stress};
use sglow_renderer::density;
use sglow_renderer::device::Gpu;
use sglow_renderer::variants::Variants as _;
use sglow_results::stability::report::{ExtremeReport, ExtremeVariant};
use sglow_runtime::package::Package;
use sglow_runtime::settings::Settings;
use sglow_scene::{Camera, LightKind, Material, Mesh, Scene};
use sglow_shaders::{
    Diffuse, Filter, Kernel, Lobes, Ndf, Precision, Solver, Specular, SpecularPower,
};

/// What the mean of the picture's indirect light should be.
#[derive(Clone, Copy, Debug)]
enum Expected {
    /// Only finiteness is required.
    Anything,
    /// That of the same variant without the extreme, times this.
    Times(f64),
    /// That of the same variant in another scene, made of the same one.
    Twin(fn(&mut Scene)),
    /// Nothing at all.
    Black,
}

/// A scene made extreme.
struct Case {
    name: &'static str,
    description: &'static str,
    expected: Expected,
    scene: fn(&mut Scene),
    settings: fn(&mut Settings),
}

const fn same_scene(_: &mut Scene) {}
const fn same_settings(_: &mut Settings) {}

const PLAIN: Case = Case {
    name: "",
    description: "",
    expected: Expected::Anything,
    scene: same_scene,
    settings: same_settings,
};

const CASES: &[Case] = &[
    Case {
        name: "far away",
        description: "the scene moved by 1e6 of its units along every axis, and no origin near it given; it is 5.5 wide",
        expected: Expected::Twin(|scene| {
            move_by(scene, 1e6);
            move_by(scene, -1e6);
        }),
        scene: |scene| move_by(scene, 1e6),
        ..PLAIN
    },
    Case {
        name: "dark",
        description: "a light of 1e-20 W/sr",
        expected: Expected::Times(1e-20),
        scene: |scene| scale_light(scene, 1e-20),
        ..PLAIN
    },
    Case {
        name: "bright",
        description: "a light of 1e20 W/sr",
        expected: Expected::Times(1e20),
        scene: |scene| scale_light(scene, 1e20),
        ..PLAIN
    },
    Case {
        name: "mirrors",
        description: "every surface of roughness 0 and half metal",
        scene: |scene| {
            for material in &mut scene.materials {
                material.roughness = 0.0;
                material.metallic = 0.5;
            }
        },
        ..PLAIN
    },
    Case {
        name: "one light",
        description: "one virtual light for the whole map",
        settings: |settings| settings.lights = 1,
        ..PLAIN
    },
    Case {
        name: "65536 lights",
        description: "as many virtual lights as texels of a 256 x 256 map, on a picture of 16 x 9",
        settings: |settings| {
            settings.lights = 65_536;
            settings.map = 256;
            settings.size = [16, 9];
        },
        ..PLAIN
    },
    Case {
        name: "no light arrives",
        description: "the light shines out of the scene: the density is zero everywhere",
        expected: Expected::Black,
        scene: |scene| {
            let light = &mut scene.lights[0];
            light.direction = [0.0, 1.0, 0.0];
            light.position = [0.0, 100.0, 0.0];
        },
        ..PLAIN
    },
    Case {
        name: "lights at the shading points",
        description: "the camera is the light, with its projection, and each texel of the map is one virtual light",
        scene: |scene| {
            let light = &scene.lights[0];
            let fov = match light.kind {
                LightKind::Spot { outer, .. } => 2.0 * outer,
                LightKind::Directional | LightKind::Point => core::f32::consts::FRAC_PI_2,
            };
            let [x, y, z] = light.position;
            let [dx, dy, dz] = light.direction;
            scene.camera =
                Camera::look_at(light.position, [x + dx, y + dy, z + dz], [0.0, 1.0, 0.0], fov);
        },
        settings: |settings| {
            settings.size = [32, 32];
            settings.map = 32;
            settings.lights = 1024;
        },
        ..PLAIN
    },
    Case {
        name: "opposite lobes",
        description: "a plate lit from above; the picture shows another below it, from below",
        scene: opposite_plates,
        ..PLAIN
    },
];

fn move_by(scene: &mut Scene, offset: f32) {
    let moved = |position: [f32; 3]| position.map(|part| part + offset);
    for mesh in &mut scene.meshes {
        for position in &mut mesh.positions {
            *position = moved(*position);
        }
    }
    for light in &mut scene.lights {
        light.position = moved(light.position);
    }
    scene.camera.position = moved(scene.camera.position);
}

fn scale_light(scene: &mut Scene, factor: f32) {
    for light in &mut scene.lights {
        light.intensity = light.intensity.map(|part| part * factor);
    }
}

fn opposite_plates(scene: &mut Scene) {
    let plate = |name: &str, height: f32, up: f32| Mesh {
        name: name.to_owned(),
        positions: [[-1.0, 1.0], [1.0, 1.0], [1.0, -1.0], [-1.0, -1.0]]
            .map(|[x, z]| [x, height, z])
            .to_vec(),
        normals: vec![[0.0, up, 0.0]; 4],
        uvs: vec![[0.0, 0.0]; 4],
        indices: vec![0, 1, 2, 0, 2, 3],
        material: 0,
        detail: sglow_scene::Detail::default(),
    };
    let mut material = Material::diffuse("plate", [0.8; 3]);
    material.double_sided = true;
    material.dielectric = 0.04;
    scene.materials = vec![material];
    scene.images.clear();
    scene.meshes = vec![plate("lit", 0.0, 1.0), plate("seen", -1.0, -1.0)];
    let light = &mut scene.lights[0];
    light.kind = LightKind::Spot { inner: 0.3, outer: 0.7 };
    light.position = [0.0, 2.0, 0.0];
    light.direction = [0.0, -1.0, 0.0];
    scene.camera = Camera::look_at([0.0, -3.0, 0.01], [0.0, -1.0, 0.0], [0.0, 0.0, -1.0], 0.9);
}

/// The default settings, and those with one axis changed at a time.
fn variants(base: &Settings, axes: &[&str], gpu: &Gpu) -> Vec<(String, Settings)> {
    let mut all = vec![("default".to_owned(), base.clone())];
    let mut add = |axis: &str, value: &str| {
        let mut settings = base.clone();
        if settings.set(axis, value).is_err() {
            return;
        }
        match (axis, value) {
            // A distribution goes with specular reflection.
            ("specular", "none") => settings.ndf = Ndf::None,
            ("ndf", "none") => return,
            ("lobes", "diffuse") => settings.lobes = Lobes::Diffuse,
            _ => {}
        }
        let possible = settings.shade().excluded().is_none()
            && (settings.filter == Filter::Exact || gpu.filters_float32());
        if possible && settings != *base {
            all.push((format!("{axis}={value}"), settings));
        }
    };
    for axis in axes {
        for value in values(axis) {
            add(axis, value);
        }
    }
    all
}

/// The values of an axis that [`Settings::set`] knows, but for the light's: that is the scene's.
fn values(axis: &str) -> Vec<&'static str> {
    match axis {
        "lobes" => Lobes::ALL.map(Lobes::name).to_vec(),
        "kernel" => Kernel::ALL.map(Kernel::name).to_vec(),
        // The third one is for previous kernels, which have nothing to solve.
        "solver" => [Solver::Bisection, Solver::Bracketed].map(Solver::name).to_vec(),
        "filter" => Filter::ALL.map(Filter::name).to_vec(),
        "diffuse" => Diffuse::ALL.map(Diffuse::name).to_vec(),
        "specular" => Specular::ALL.map(Specular::name).to_vec(),
        "specular_power" => SpecularPower::ALL.map(SpecularPower::name).to_vec(),
        "ndf" => Ndf::ALL.map(Ndf::name).to_vec(),
        "precision" => Precision::ALL.map(Precision::name).to_vec(),
        _ => Vec::new(),
    }
}

/// The names of all extreme cases: those of scenes, then those of densities.
#[must_use]
pub fn names() -> Vec<&'static str> {
    let scenes = CASES.iter().map(|case| case.name).chain(far::ALL.iter().map(|far| far.name));
    scenes.chain(Stress::ALL.map(|(name, _)| name)).collect()
}

/// What every case starts from.
fn base() -> Settings {
    Settings { size: [48, 27], map: 64, lights: 256, ..Settings::default() }
}

/// Tries the extreme case of this name; nothing if there is none.
///
/// # Errors
///
/// When something does not render; that it renders wrong is in the report.
pub fn attempt(
    gpu: &Gpu,
    package: &Package,
    name: &str,
) -> Result<Option<ExtremeReport>, ExtremeError> {
    if let Some(case) = CASES.iter().find(|case| case.name == name) {
        return in_scene(gpu, package, case).map(Some);
    }
    if let Some(far) = far::ALL.iter().find(|far| far.name == name) {
        return far.attempt(gpu, package).map(Some);
    }
    match Stress::ALL.into_iter().find(|(stress, _)| *stress == name) {
        Some((name, stress)) => of_density(gpu, package, name, stress).map(Some),
        None => Ok(None),
    }
}

fn in_scene(gpu: &Gpu, package: &Package, case: &Case) -> Result<ExtremeReport, ExtremeError> {
    let scene = Scene::load("cornell-glossy")?;
    let bound = bound::extreme(case.name);
    let mut extreme = scene.clone();
    (case.scene)(&mut extreme);
    // What the mean is compared with: the scene as it is, or its twin.
    let mut plain = scene;
    if let Expected::Twin(change) = case.expected {
        change(&mut plain);
    }
    let mut tried = Vec::new();
    for (name, plain_settings) in variants(&base(), Settings::AXES, gpu) {
        let mut settings = plain_settings.clone();
        (case.settings)(&mut settings);
        let expected = match case.expected {
            Expected::Anything => None,
            Expected::Times(factor) => {
                Some(render(gpu, package, &plain, &plain_settings)?.mean * factor)
            }
            Expected::Twin(_) => Some(render(gpu, package, &plain, &settings)?.mean),
            Expected::Black => Some(0.0),
        };
        let outcome = render(gpu, package, &extreme, &settings)?;
        tried.push(verdict(name, &outcome, expected, bound.of(settings.kernel)));
    }
    if case.name == "far away" {
        let (settings, literal) = (base(), about_the_worlds_origin(package)?);
        let expected = render(gpu, package, &plain, &settings)?.mean;
        let outcome = render(gpu, &literal, &extreme, &settings)?;
        // The paper's form, to show what the origin of the moments buys: it has no guarantee.
        let shown = verdict(LITERAL.to_owned(), &outcome, Some(expected), None);
        tried.push(ExtremeVariant { holds: true, ..shown });
    }
    Ok(ExtremeReport {
        name: case.name,
        description: case.description,
        bound: bound.at_most,
        reason: bound.reason,
        variants: tried,
    })
}

/// The name of the default variants with the moments of the paper, about the origin of the world.
pub const LITERAL: &str = "literal: moments about the world's origin";

/// The default variants of the moments and of the lights as [Tokuyoshi 2016, Appendix B.2] has them: the variance is
/// E[y^2] - mean^2 of world positions, which cancels far from the origin.
fn about_the_worlds_origin(package: &Package) -> Result<Package, ExtremeError> {
    let changes = [
        ("moments-spot-both-f0-exact-f32", "surface.position - origin", "surface.position"),
        ("sample-warped-modified-bracketed-exact-trace-exact-both-f32", "origin + mean", "mean"),
    ];
    let mut literal = package.clone();
    for (id, stable, form) in changes {
        let text = package.text(id)?.replace(stable, form);
        literal = literal.with_text(id, text);
    }
    Ok(literal)
}

/// Width and height of the densities, and the number of kernels on them.
const STRESS_SIZE: u32 = 128;
const STRESS_COUNT: u32 = 1024;

/// The sampling pass on a density: finite lights, and for the modified kernels the whole power.
fn of_density(
    gpu: &Gpu,
    package: &Package,
    name: &'static str,
    stress: Stress,
) -> Result<ExtremeReport, ExtremeError> {
    let texels = stress.texels(STRESS_SIZE as usize, 1);
    // With power in proportion to density the modified kernels keep it by construction.
    let mut random = Random::new(2);
    #[expect(clippy::cast_possible_truncation, reason = "power is f32")]
    let power: Vec<f32> =
        texels.iter().map(|weight| weight * (0.4 + 0.4 * random.uniform() as f32)).collect();
    let base = Settings { map: STRESS_SIZE, lights: STRESS_COUNT, ..Settings::default() };
    let bound = bound::extreme("density");
    let mut tried = Vec::new();
    for (variant, settings) in variants(&base, &["kernel", "solver", "filter", "precision"], gpu) {
        let sampled = density::sample(gpu, package, &settings, &texels, &power)?;
        let sum: f64 = sampled.powers.iter().sum();
        let outcome = Outcome {
            not_finite: sampled.powers.iter().filter(|power| !power.is_finite()).count(),
            negative: sampled.powers.iter().filter(|power| **power < 0.0).count(),
            mean: if sampled.total > 0.0 { sum / sampled.total } else { sum },
        };
        let expected = if sampled.total > 0.0 { 1.0 } else { 0.0 };
        tried.push(verdict(variant, &outcome, Some(expected), bound.of(settings.kernel)));
    }
    Ok(ExtremeReport {
        name,
        description: "1024 kernels on a density of 128 x 128: power of the lights over the true total",
        bound: bound.at_most,
        reason: bound.reason,
        variants: tried,
    })
}
