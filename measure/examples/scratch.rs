use sglow_measure::rivals::flicker::*;
use sglow_runtime::{device::Gpu, package::Package, scene::Scene, settings::Settings};
use sglow_shaders::*;
fn main() {
    let gpu = Gpu::open(None).unwrap();
    let a: Vec<String> = std::env::args().collect();
    let scene = Scene::builtin(&a[1]).unwrap();
    let density: Density = a[2].parse().unwrap();
    let rsm: u32 = a[3].parse().unwrap();
    let both = scene.facts()["specular"];
    let base = Settings {
        size: [160, 90],
        rsm_size: rsm,
        density,
        lobes: if both { Lobes::Both } else { Lobes::Diffuse },
        specular: if both { Specular::Asg } else { Specular::None },
        ndf: if both { Ndf::Ggx } else { Ndf::None },
        ..Settings::default()
    };
    let c = |name: &str, kernel, k| Contender {
        name: name.into(),
        settings: Settings { kernel, size_factor: k, ..base.clone() },
    };
    let walk =
        Walk { frames: a[4].parse().unwrap(), step: a[5].parse().unwrap(), ..Walk::default() };
    let f = flicker(
        &gpu,
        &Package::embedded(),
        &scene,
        &[
            c("previous", Kernel::Previous, 1.0),
            c("modified", Kernel::Modified, 1.0),
            c("modified 4", Kernel::Modified, 4.0),
            c("modified 16", Kernel::Modified, 16.0),
        ],
        walk,
        |n| eprint!("{n} "),
    )
    .unwrap();
    println!("{:#?}", f);
}
