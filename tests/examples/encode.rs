//! What it costs the CPU to encode a frame of indirect light: medians of 9 samples, for several configurations.
//!
//! Nothing is submitted, so that the device does nothing meanwhile. To compare two checkouts, build both and run them in
//! turns on a machine that does nothing else:
//! `for turn in 1 2 3; do for tree in A B; do (cd $tree && cargo run --release -p sglow-tests --example encode); done; done`

use std::time::{Duration, Instant};

use sglow_renderer::device::Gpu;
use sglow_renderer::frame::{Renderer, occluders};
use sglow_renderer::plan::{Plan, Surfaces};
use sglow_runtime::indirect::{Indirect, IndirectError, PARTS};
use sglow_runtime::package::Package;
use sglow_runtime::settings::Settings;
use sglow_scene::Scene;
use sglow_shader_gen::library::Library;
use sglow_shader_gen::package::{InMemory, in_memory};

/// Every axis and parameter, so that a change of defaults changes nothing here.
const ALL: &str = "light=spot lobes=both specular_power=f0 precision=f32 density=power draw=warped kernel=modified \
    solver=bracketed filter=exact space=none emitter=cosine variance=trace sharpness=exact visibility=none \
    diffuse=fitted specular=asg ndf=ggx lights=1024 map=256 camera_lights=2048 iterations=12 tile=64 \
    shadow_points=8192 size_factor=0.25 emission_sharpness=2 near_scale=1.5 bias_scale=1";

/// Configurations, and what each has in place of [`ALL`].
const CONFIGURATIONS: [(&str, &str); 4] = [
    ("kernels", ""),
    ("kernels with visibility", "visibility=shadow_map"),
    ("clusters with visibility", "space=world emitter=disc visibility=shadow_map"),
    (
        "everything",
        "density=bidirectional draw=metropolis space=world visibility=shadow_map lights=4096 tile=32",
    ),
];

const SAMPLES: usize = 9;

fn settings(changes: &str) -> Result<Settings, Box<dyn std::error::Error>> {
    let mut settings = Settings { size: [640, 360], ..Settings::default() };
    for pair in ALL.split_whitespace().chain(changes.split_whitespace()) {
        let (name, value) = pair.split_once('=').ok_or("name=value")?;
        settings.set(name, value)?;
    }
    Ok(settings)
}

/// The variants that a configuration runs.
fn package(settings: &Settings, scene: &Scene) -> Result<Package, Box<dyn std::error::Error>> {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../shaders");
    let library = Library::load(folder.as_ref()).map_err(|report| report.to_string())?;
    let frame = library.frame().ok_or("the library describes no frame")?;
    let surfaces = Surfaces::of(scene, settings.complete);
    let wanted = Plan::new(&frame.description, settings, &surfaces)?.variants;
    let mut variants = library.variants();
    variants.retain(|variant| wanted.contains(&variant.id()));
    let InMemory { texts, manifest } = in_memory(&library, &variants)?;
    Ok(Package::generated("the variants of one configuration", texts).with_manifest(&manifest)?)
}

/// The time that this thread has run for on a processor, where the system says so.
fn processor_time() -> Option<Duration> {
    let text = std::fs::read_to_string("/proc/thread-self/schedstat").ok()?;
    text.split_whitespace().next()?.parse().ok().map(Duration::from_nanos)
}

fn median(mut times: Vec<Duration>) -> Duration {
    times.sort_unstable();
    times.get(times.len() / 2).copied().unwrap_or_default()
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let gpu = Gpu::open(None)?;
    let scene = Scene::builtin("cornell-glossy")?;
    println!("{}, {}", gpu.adapter.name, gpu.adapter.driver);
    println!(
        "microseconds to encode and finish a frame, medians of {SAMPLES}: wall clock, this thread's processor time"
    );
    for (name, changes) in CONFIGURATIONS {
        let settings = settings(changes)?;
        let package = package(&settings, &scene)?;
        let renderer = Renderer::new(&gpu, &package, &scene, &settings, 0)?;
        let occluders = occluders(&gpu, &scene, &settings)?;
        let indirect = Indirect::of_parts(gpu.source(&package), &settings, &PARTS, &occluders)?;
        let encode = || {
            let mut encoder = gpu.device.create_command_encoder(&Default::default());
            indirect.encode(&mut encoder, &renderer.inputs(), None)?;
            Ok::<_, IndirectError>(encoder.finish())
        };
        // As many at a time as take a tenth of a second: processor time is counted in milliseconds.
        let warm_up = Instant::now();
        drop((0..4).map(|_| encode()).collect::<Result<Vec<_>, _>>()?);
        let one = warm_up.elapsed().max(Duration::from_nanos(1)) / 4;
        let frames = (100_000_000 / one.as_nanos()).clamp(4, 1000) as u32;
        let (mut wall, mut processor) = (Vec::new(), Vec::new());
        for _ in 0..SAMPLES {
            let (start, before) = (Instant::now(), processor_time());
            for _ in 0..frames {
                drop(encode()?);
            }
            wall.push(start.elapsed() / frames);
            let spent =
                processor_time().zip(before).map(|(after, before)| (after - before) / frames);
            processor.extend(spent);
            // What was written for frames that nobody submits.
            gpu.queue.submit([]);
            gpu.finish()?;
        }
        let microseconds = |times| median(times).as_nanos() as f64 * 1e-3;
        println!("{name}: {:.1}, {:.1}", microseconds(wall), microseconds(processor));
    }
    Ok(())
}
