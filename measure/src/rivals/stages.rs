//! What each stage costs, from the maps to the virtual lights: Tables 1 to 3 of [Tokuyoshi 2016].

use std::collections::BTreeMap;
use std::time::Duration;

use sglow_renderer::device::Gpu;
use sglow_renderer::frame::{FrameError, Renderer};
use sglow_renderer::stages::Stages as _;
use sglow_renderer::timing::Timer;
use sglow_renderer::variants::Variants as _;
use sglow_results::rivals::method::Method;
use sglow_results::rivals::stages::{Code, Stage, Stages};
use sglow_results::time::Time;
use sglow_runtime::indirect::Indirect;
use sglow_runtime::occluders::Occluders;
use sglow_runtime::package::Package;
use sglow_runtime::settings::Settings;
use sglow_shaders::{
    Density, Kernel, Levels, Solver, Texel, centres, cluster_assign, cluster_boxes, cluster_codes,
    cluster_starts, cluster_sum, cluster_tree, mip, moments, sort_count, sort_scan, sort_scatter,
};

use super::method;

/// The name of a stage of this method, or nothing of what all share.
fn stage(method: Method, label: &str) -> Option<&'static str> {
    match label.strip_prefix("camera ").unwrap_or(label) {
        // Clusters sum the surfaces themselves; moments then only hold the weight that the density is made of.
        "moments" | "mip moments" if method.clusters() => None,
        "moments" => Some("moments"),
        "mip moments" => Some("mip moments"),
        "sample" => Some("sample"),
        "centres" => Some("centres"),
        "cluster assignment" => Some("cluster assignment"),
        "cluster sort" => Some("cluster sort"),
        "cluster sum" => Some("cluster sum"),
        _ => None,
    }
}

/// Times the stages of methods on the maps that `renderer` has drawn and with the density that its indirect light has
/// made, `runs` times in turns after a warm-up.
///
/// # Errors
///
/// When a variant or the device does not allow it.
pub fn stages(
    gpu: &Gpu,
    package: &Package,
    renderer: &Renderer<'_>,
    methods: &[Method],
    runs: usize,
) -> Result<Vec<Stages>, FrameError> {
    let own = renderer.indirect();
    let inputs = renderer.inputs();
    let mut made = Vec::new();
    for &method in methods {
        let settings = method::settings(method, own.settings());
        let occluders = Occluders::default();
        made.push(Indirect::of_parts(gpu.source(package), &settings, &["lights"], &occluders)?);
    }
    type Key = (bool, &'static str);
    let mut order: Vec<Vec<Key>> = vec![Vec::new(); methods.len()];
    let mut times: Vec<BTreeMap<Key, (Vec<Duration>, usize)>> =
        vec![BTreeMap::new(); methods.len()];
    for run in 0..=runs {
        for (index, (indirect, &method)) in made.iter().zip(methods).enumerate() {
            let mut encoder = gpu.device.create_command_encoder(&Default::default());
            let mut camera = Timer::new(gpu);
            indirect.encode_camera(&mut encoder, &inputs, Some(&mut camera))?;
            gpu.queue.submit([encoder.finish()]);
            let mut encoder = gpu.device.create_command_encoder(&Default::default());
            let mut light = Timer::new(gpu);
            indirect.encode_moments(&mut encoder, &inputs, Some(&mut light))?;
            indirect.encode_density_of(&mut encoder, own);
            indirect.encode_mips(&mut encoder, Some(&mut light))?;
            indirect.encode_sample(&mut encoder, &inputs, Some(&mut light))?;
            gpu.queue.submit([encoder.finish()]);
            let dispatches = [camera.dispatches(), light.dispatches()];
            let passes = [camera.finish()?, light.finish()?];
            gpu.finish()?;
            for ((camera, passes), dispatches) in
                [true, false].into_iter().zip(passes).zip(dispatches)
            {
                for ((label, time), dispatches) in passes.into_iter().zip(dispatches) {
                    let Some(name) = stage(method, &label) else { continue };
                    let key = (camera, name);
                    if run == 0 {
                        if !order[index].contains(&key) {
                            order[index].push(key);
                        }
                        // The first run compiles.
                        continue;
                    }
                    let entry = times[index].entry(key).or_default();
                    entry.0.push(time);
                    entry.1 = dispatches;
                }
            }
        }
    }
    let found = methods.iter().zip(order).zip(times);
    Ok(found
        .map(|((&method, order), mut times)| Stages {
            method,
            stages: order
                .into_iter()
                .map(|key| {
                    let (times, dispatches) = times.remove(&key).unwrap_or_default();
                    Stage { name: key.1, camera: key.0, time: Time::of(times), dispatches }
                })
                .collect(),
        })
        .collect())
}

/// The size of a method on one map with these settings, by the texts of a package.
///
/// # Errors
///
/// When the package lacks a variant.
pub fn code(
    package: &Package,
    method: Method,
    settings: &Settings,
) -> Result<Code, sglow_runtime::package::PackageError> {
    let settings = method::settings(method, settings);
    let shaders: Vec<String> = if method.clusters() {
        cluster_variants(&settings)
    } else {
        vec![moments_variant(&settings), settings.sample().id().to_string()]
    };
    let mips: Vec<String> = if method.clusters() {
        Vec::new()
    } else {
        Levels::ALL
            .map(|levels| mip::Mip { texel: Texel::Rgba32float, levels }.id().to_string())
            .into()
    };
    let count = |ids: &[String]| -> Result<usize, _> {
        ids.iter().map(|id| package.text(id).map(lines)).sum()
    };
    let lines = [count(&shaders)?, count(&mips)?];
    Ok(Code { method, shaders, mips, lines })
}

fn moments_variant(settings: &Settings) -> String {
    let Settings { light, lobes, sharpness, precision, .. } = *settings;
    let specular_power = settings.specular_power();
    moments::Moments { light, lobes, specular_power, sharpness, precision }.id().to_string()
}

fn cluster_variants(settings: &Settings) -> Vec<String> {
    let Settings { draw, space, light, lobes, variance, sharpness, .. } = *settings;
    let specular_power = settings.specular_power();
    vec![
        centres::Centres { draw, space }.id().to_string(),
        cluster_codes::ClusterCodes { space }.id().to_string(),
        sort_count::SortCount.id().to_string(),
        sort_scan::SortScan.id().to_string(),
        sort_scatter::SortScatter.id().to_string(),
        cluster_tree::ClusterTree.id().to_string(),
        cluster_boxes::ClusterBoxes.id().to_string(),
        cluster_assign::ClusterAssign { space }.id().to_string(),
        cluster_starts::ClusterStarts.id().to_string(),
        cluster_sum::ClusterSum { light, variance, sharpness, lobes, specular_power }
            .id()
            .to_string(),
    ]
}

/// Lines that are neither blank nor a comment.
fn lines(text: &str) -> usize {
    text.lines().map(str::trim).filter(|line| !line.is_empty() && !line.starts_with("//")).count()
}

/// The time of the sampling pass alone on a density, kernels of three kinds in turns within one run: the ratios of
/// `modified` by bisection and by the bracketed solver over `previous`.
///
/// # Errors
///
/// When a variant or the device does not allow it.
pub fn sampling_ratios(
    gpu: &Gpu,
    package: &Package,
    base: &Settings,
    density: &[f32],
    power: &[f32],
) -> Result<[f64; 2], FrameError> {
    let base = Settings { density: Density::Power, ..base.clone() };
    let candidates = [
        (Kernel::Previous, Solver::Bracketed),
        (Kernel::Modified, Solver::Bisection),
        (Kernel::Modified, Solver::Bracketed),
    ]
    .map(|(kernel, solver)| Settings { kernel, solver, ..base.clone() });
    let times = sglow_renderer::density::times(gpu, package, &candidates, density, power)?;
    let over = |index: usize| {
        let [of, by] = [index, 0].map(|at| times.get(at).map_or(0.0, Duration::as_secs_f64));
        if by > 0.0 { of / by } else { f64::NAN }
    };
    Ok([over(1), over(2)])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn comments_and_blank_lines_do_not_count() {
        assert_eq!(lines("// a\n\n  /// b\nfn c() {\n    let d = 1; // e\n}\n"), 3);
        assert_eq!(lines(""), 0);
    }

    #[test]
    fn what_all_methods_share_is_no_stage() {
        assert_eq!(stage(Method::Modified, "camera moments"), Some("moments"));
        assert_eq!(stage(Method::Image, "moments"), None);
        assert_eq!(stage(Method::Modified, "camera density"), None);
        assert_eq!(stage(Method::Modified, "mip density"), None);
        assert_eq!(stage(Method::World, "cluster sum"), Some("cluster sum"));
    }
}
