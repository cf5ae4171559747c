//! Radiance in 16 bits, in textures of an engine's own: axis `output`.

use half::f16;
use sglow_graph::Configuration;
use sglow_graph::description::Table;
use sglow_oracle::half::{LARGEST, SMALLEST_NORMAL};
use sglow_renderer::frame::{Frame, Pixels, Renderer};
use sglow_renderer::readback;
use sglow_runtime::execute::Lists;
use sglow_runtime::indirect::{Indirect, PARTS};
use sglow_runtime::occluders::Occluders;
use sglow_runtime::package::Package;
use sglow_runtime::settings::Settings;
use sglow_scene::Scene;
use sglow_shaders::{Emitter, Output, Precision};

use crate::common::{gpu, package_of, plan};
use crate::execute::submit;

/// The distance of neighbouring subnormal halves, 2^-24.
const STEP: f64 = SMALLEST_NORMAL / 1024.0;

fn settings(output: Output) -> Settings {
    Settings { size: [37, 23], map: 48, lights: 60, output, ..Settings::default() }
}

/// The glossy box, its light so many times as strong.
fn scene(factor: f32) -> Scene {
    let mut scene = Scene::builtin("cornell-glossy").unwrap();
    for light in &mut scene.lights {
        light.intensity = light.intensity.map(|channel| channel * factor);
    }
    scene
}

fn package(scene: &Scene) -> Package {
    let [mut ids, more] = Output::ALL.map(|output| plan(&settings(output), scene).variants);
    ids.extend(more);
    package_of(&ids)
}

/// A package whose rounding to halves is another.
fn rounding(package: &Package, from: &str, to: &str) -> Package {
    let ids: Vec<String> =
        package.variants().filter(|id| id.ends_with("16float")).map(str::to_owned).collect();
    let mut changed = package.clone();
    for id in ids.iter().filter(|id| !id.starts_with("mip-")) {
        let text = package.text(id).unwrap();
        assert!(text.contains(from), "{id} has no '{from}' to break");
        changed = changed.with_text(id, text.replace(from, to));
    }
    changed
}

fn frame(package: &Package, scene: &Scene, output: Output) -> Frame {
    let renderer = Renderer::new(gpu(), package, scene, &settings(output), 0).unwrap();
    renderer.render().unwrap();
    renderer.read().unwrap()
}

/// What rounding has done to numbers.
#[derive(Debug, Default)]
struct Rounded {
    count: usize,
    /// Those that are not the nearest half, where halves are normal, or more than a step off, where they are not.
    violations: usize,
    not_finite: usize,
    /// Those that are the largest half.
    largest: usize,
    /// Those where halves are normal.
    normal: usize,
    /// The mean of their relative error, with its sign.
    bias: f64,
}

/// How halves differ from numbers of 32 bits.
///
/// A half has 11 bits, so that the nearest one is within 2^-11 of its number's size. Below 2^-14 halves are 2^-24 apart, and a
/// device stores either neighbour of a number, or 0, as WGSL grants it; before that the shader has rounded to 11 bits.
fn rounded(halves: &Pixels, numbers: &Pixels) -> Rounded {
    let mut found = Rounded::default();
    let channels = |pixels: &Pixels| -> Vec<f64> {
        pixels.iter().flat_map(|pixel| &pixel[..3]).map(|channel| f64::from(*channel)).collect()
    };
    for (half, number) in channels(halves).into_iter().zip(channels(numbers)) {
        let (error, size) = ((half - number).abs(), number.abs());
        let own = size / 2048.0;
        let fits = if size >= LARGEST {
            half.abs() == LARGEST && half.signum() == number.signum()
        } else if size >= SMALLEST_NORMAL {
            error <= own
        } else {
            error <= STEP + own || half == 0.0
        };
        if (SMALLEST_NORMAL..LARGEST).contains(&size) {
            found.bias += (half - number) / number;
            found.normal += 1;
        }
        found.count += 1;
        found.violations += usize::from(!fits);
        found.not_finite += usize::from(!half.is_finite());
        found.largest += usize::from(half == LARGEST);
    }
    found.bias /= found.normal.max(1) as f64;
    found.violations += halves.iter().filter(|pixel| pixel[3] != 1.0).count();
    found
}

/// Each texture that shading and direct light write, of a frame in halves, against the same of one in 32 bits.
fn compare(package: &Package, scene: &Scene) -> Vec<(&'static str, Rounded)> {
    let [numbers, halves] = Output::ALL.map(|output| frame(package, scene, output));
    let textures = |frame: &Frame| {
        let [diffuse, specular] = [&frame.indirect_diffuse, &frame.indirect_specular];
        [frame.direct.clone(), diffuse.clone().unwrap(), specular.clone().unwrap()]
    };
    // What is added up is what was stored: the sum of halves, as the pass adds them, is rounded once more.
    let [direct, diffuse, specular] = textures(&halves);
    let sum = |index: usize| {
        let part = |channel: usize| {
            direct[index][channel] + diffuse[index][channel] + specular[index][channel]
        };
        [part(0), part(1), part(2), 1.0]
    };
    let sums: Pixels = (0..direct.len()).map(sum).collect();
    let pairs = textures(&halves).into_iter().zip(textures(&numbers));
    let names = ["direct", "diffuse", "specular"].into_iter();
    let mut found: Vec<_> = names
        .zip(pairs)
        .map(|(name, (halves, numbers))| (name, rounded(&halves, &numbers)))
        .collect();
    found.push(("radiance", rounded(&halves.radiance, &sums)));
    found
}

#[test]
fn halves_are_the_nearest_to_what_32_bits_hold() {
    let scene = scene(1.0);
    let package = package(&scene);
    let all = compare(&package, &scene);
    for (name, found) in &all {
        println!("{name}: {found:?}");
        assert!(found.count == 3 * 37 * 23 && found.violations == 0, "{name}: {found:?}");
        // Errors go to both sides: five times the standard deviation of a mean of so many that are uniform.
        let five = 5.0 / 2048.0 / (3.0 * found.normal as f64).sqrt();
        assert!(found.normal > 200 && found.bias.abs() < five, "{name}: {found:?}");
    }
    // Negative controls: what is cut off is darker, and light that is a thousandth brighter is another.
    for (from, to) in [
        ("(bits + half_step)", "bits"),
        (
            "let bits = bitcast<vec4<u32>>(clamp(value,",
            "let bits = bitcast<vec4<u32>>(clamp(1.001 * value,",
        ),
    ] {
        for (name, found) in compare(&rounding(&package, from, to), &scene) {
            println!("{to}, {name}: {found:?}");
            assert!(20 * found.violations > found.normal, "{to} goes unnoticed in {name}");
            assert!(found.bias.abs() > 1e-4, "{to}: {name} is not biased");
        }
    }
    // What the device makes of it by itself: shaders round because it may be either.
    let alone = rounding(
        &package,
        "return bitcast<vec4<f32>>((bits + half_step) & vec4<u32>(0xffffe000u));",
        "return value;",
    );
    for (name, found) in compare(&alone, &scene) {
        println!("by the device, {name}: {found:?}");
    }
}

#[test]
fn what_exceeds_halves_stays_finite() {
    for factor in [1e6, 1e15, 1e30] {
        let scene = scene(factor);
        let package = package(&scene);
        for (name, found) in compare(&package, &scene) {
            println!("{factor:e} {name}: {found:?}");
            let bright = found.largest > 50;
            assert!(found.violations == 0 && found.not_finite == 0 && bright, "{name}: {found:?}");
        }
        // Negative control: infinity, which devices store without the clamp that round to the nearest half.
        let clamp = "clamp(value, vec4<f32>(-65504.0), vec4<f32>(65504.0))";
        let infinite = "select(value, value * 1e38 * 1e38, abs(value) > vec4<f32>(65504.0))";
        for (name, found) in compare(&rounding(&package, clamp, infinite), &scene) {
            assert!(found.not_finite > 50 && found.violations > 50, "{name}: {found:?}");
        }
    }
}

/// A texture of an engine's own, as it stores to it and samples it.
fn own(format: wgpu::TextureFormat, [width, height]: [u32; 2]) -> wgpu::Texture {
    gpu().device.create_texture(&wgpu::TextureDescriptor {
        label: None,
        size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage: wgpu::TextureUsages::STORAGE_BINDING
            | wgpu::TextureUsages::TEXTURE_BINDING
            | wgpu::TextureUsages::COPY_SRC,
        view_formats: &[],
    })
}

/// Indirect light by the committed package that writes to textures of an engine's own.
fn embedded(settings: &Settings) -> Result<Indirect, String> {
    let configuration = Configuration {
        parts: Some(PARTS.map(str::to_owned).into()),
        supplied: ["diffuse", "specular"].map(str::to_owned).into(),
        ..settings.configuration()
    };
    let (package, nothing) = (Package::embedded(), Occluders::default());
    let source = gpu().source(&package);
    Indirect::of_configuration(source, settings, configuration, &nothing, &Lists::new())
        .map_err(|error| error.to_string())
}

/// Runs a frame; the textures go by their views, as an engine has them.
fn run(
    indirect: &Indirect,
    maps: &Renderer<'_>,
    textures: &[wgpu::Texture; 2],
) -> Result<(), String> {
    let mut given = indirect.given(&maps.inputs());
    for (name, texture) in ["diffuse", "specular"].into_iter().zip(textures) {
        given.view(name, &texture.create_view(&wgpu::TextureViewDescriptor::default()));
    }
    let mut encoder = gpu().device.create_command_encoder(&Default::default());
    let encoded = indirect.executor().encode(&mut encoder, &given, None);
    gpu().queue.submit([encoder.finish()]);
    gpu().finish().unwrap();
    encoded.map_err(|error| error.to_string())
}

fn read(texture: &wgpu::Texture) -> Pixels {
    readback::texture(gpu(), texture, 0).unwrap()
}

/// A renderer whose maps are given to what an engine embeds.
fn maps(package: &Package, settings: &Settings) -> Renderer<'static> {
    let renderer = Renderer::new(gpu(), package, &scene(1.0), settings, 0).unwrap();
    renderer.render().unwrap();
    renderer
}

const F16: wgpu::TextureFormat = wgpu::TextureFormat::Rgba16Float;
const F32: wgpu::TextureFormat = wgpu::TextureFormat::Rgba32Float;

#[test]
fn an_engine_has_its_own_halves_written_to() {
    let package = package(&scene(1.0));
    for precision in Precision::ALL {
        let [wide, narrow] = Output::ALL.map(|output| Settings { precision, ..settings(output) });
        let renderer = maps(&package, &Settings { precision: Precision::F32, ..wide.clone() });
        let [numbers, halves] = [(&wide, F32), (&narrow, F16)].map(|(settings, format)| {
            let textures = [own(format, settings.size), own(format, settings.size)];
            run(&embedded(settings).unwrap(), &renderer, &textures).unwrap();
            textures.map(|texture| read(&texture))
        });
        for (halves, numbers) in halves.iter().zip(&numbers) {
            let found = rounded(halves, numbers);
            assert!(found.count == 3 * 37 * 23 && found.violations == 0, "{precision}: {found:?}");
            assert!(halves.iter().any(|pixel| pixel[0] > 0.0) && halves != numbers);
            assert!(halves.iter().flatten().all(|&half| f16::from_f32(half).to_f32() == half));
        }
        // Textures that are not supplied are of the same format and hold the same.
        let (device, queue) = (&gpu().device, &gpu().queue);
        let indirect = Indirect::new(device, queue, &narrow).unwrap();
        submit(|encoder| indirect.encode(encoder, &renderer.inputs(), None).unwrap());
        for (name, halves) in ["diffuse", "specular"].into_iter().zip(&halves) {
            let texture = indirect.texture(name).unwrap();
            assert!(texture.format() == F16 && read(&texture) == *halves, "{precision} {name}");
        }
    }
}

#[test]
fn a_resize_takes_other_textures_and_another_format() {
    let package = package(&scene(1.0));
    let [wide, narrow] = Output::ALL.map(settings);
    let renderer = maps(&package, &wide);
    let mut indirect = embedded(&narrow).unwrap();
    let (narrow_textures, wide_textures) =
        ([own(F16, [37, 23]), own(F16, [37, 23])], [own(F32, [37, 23]), own(F32, [37, 23])]);
    run(&indirect, &renderer, &narrow_textures).unwrap();
    // Each texture that does not fit is named, with the setting that it goes with.
    let text = run(&indirect, &renderer, &wide_textures).unwrap_err();
    let line = |name: &str, found: &str, wanted: &str, set: &str| {
        format!(
            "resource `{name}` is a texture of format {found}; it has to be a texture of 37 x 23 texels, {wanted}{set}"
        )
    };
    let (to_wide, to_narrow) = (
        "; rgba32float where output == 'rgba32float'",
        "; rgba16float where output == 'rgba16float'",
    );
    let lines =
        ["diffuse", "specular"].map(|name| line(name, "Rgba32Float", "rgba16float", to_wide));
    assert_eq!(text, lines.join("\n"));
    indirect.resize(&wide).unwrap();
    let text = run(&indirect, &renderer, &narrow_textures).unwrap_err();
    let lines =
        ["diffuse", "specular"].map(|name| line(name, "Rgba16Float", "rgba32float", to_narrow));
    assert_eq!(text, lines.join("\n"));
    run(&indirect, &renderer, &wide_textures).unwrap();
    // A format that no setting has.
    let other = [own(wgpu::TextureFormat::Rgba8Unorm, [37, 23]), wide_textures[1].clone()];
    let text = run(&indirect, &renderer, &other).unwrap_err();
    assert_eq!(text, line("diffuse", "Rgba8Unorm", "rgba32float", to_narrow));

    // What the committed package lacks is an error that names the command.
    let emitter = Emitter::Lobe;
    let text = embedded(&Settings { emitter, ..narrow }).err().unwrap();
    for part in ["shade-lobe-", "-rgba16float", "--set emitter=lobe,", ",output=rgba16float"] {
        assert!(text.contains(part), "{part}: {text}");
    }
    assert!(embedded(&Settings { emitter, ..wide }).is_ok());
}

/// The committed package has what an engine runs by default that writes halves.
#[test]
fn the_package_has_the_defaults_in_halves() {
    let package = Package::embedded();
    let (description, known) =
        (package.description().unwrap(), package.variants().collect::<Vec<_>>());
    for occluders in [false, true] {
        let facts = Table::from([("occluders".to_owned(), occluders)]);
        let advised = Settings::advised(description, &facts, None).unwrap();
        let settings = Settings { output: Output::Rgba16float, ..advised };
        let configuration = Configuration {
            parts: Some(PARTS.map(str::to_owned).into()),
            ..settings.configuration()
        };
        let frame = description.evaluate(&configuration).unwrap();
        let ids: Vec<String> =
            frame.variants().into_iter().map(|variant| variant.id.clone()).collect();
        assert!(ids.iter().any(|id| id.contains("-rgba16float")), "{ids:?}");
        for id in ids {
            assert!(known.contains(&id.as_str()), "{id}");
        }
    }
}
