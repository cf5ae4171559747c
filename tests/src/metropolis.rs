//! Centres that Markov chains draw: `shaders/src/fis/metropolis.wesl`.

use sglow_oracle::fis::metropolis::{Steps, advance, anywhere};
use sglow_oracle::fis::stress::Stress;
use sglow_oracle::fis::{lattice, warp};
use sglow_oracle::vsgl::Vsgl;
use sglow_oracle::{Bounded, Real};
use sglow_renderer::stages::Stages as _;
use sglow_renderer::{readback, reference};
use sglow_runtime::package::Package;
use sglow_runtime::settings::Settings;
use sglow_shaders::{
    Draw, Light, Lobes, SglowKernel, Sharpness, Space, SpecularPower, Start, Variance,
};

use crate::common::{
    Comparison, DensityTexture, KINDS, Run, Uploaded, broken, gpu, light, random_surfaces, small,
    whole_space,
};
use crate::part::chains::{ChainSettings, Chains};
use crate::part::clusters::{ClusterInputs, ClusterSettings, Clusters};

const SIZE: u32 = 64;
const COUNT: u32 = 500;

/// Where chains are before the first frame's mutations, and after each of some frames.
fn run(
    settings: &ChainSettings,
    stress: Stress,
    package: &Package,
    frames: u32,
) -> Vec<Vec<[f32; 2]>> {
    let density = DensityTexture::new([SIZE; 2], stress, 9);
    let mut chains = Chains::new(package, settings, SIZE);
    let read = (0..frames).map(|_| {
        chains.advance(density.view.texture());
        chains.read()
    });
    read.collect()
}

/// Compares every chain after every frame with the oracle's, from where the device had it the frame before.
fn compare(settings: &ChainSettings, stress: Stress, package: &Package) -> Comparison {
    let frames = run(settings, stress, package, 4);
    let density = DensityTexture::new([SIZE; 2], stress, 9).pyramid;
    let mut comparison = Comparison::default();
    let mut doubtful = 0;
    for (frame, chains) in frames.iter().enumerate() {
        let steps = Steps {
            mutations: settings.mutations,
            frame: frame as u32,
            seed: settings.seed,
            radius: f64::from(settings.radius),
            large_steps: f64::from(settings.large_steps),
        };
        for (index, measured) in chains.iter().enumerate() {
            let chain = index as u32;
            let (start, certain) = match frame.checked_sub(1) {
                Some(before) => (frames[before][index].map(Bounded::exact), true),
                None if settings.start == Start::Uniform => {
                    (anywhere(chain, settings.seed).map(Bounded::constant), true)
                }
                None => {
                    let warped = warp(&density, lattice::point::<Bounded>(chain, settings.count));
                    (warped.centre, warped.certain)
                }
            };
            let moved = advance(&density, chain, start, &steps);
            if !(certain && moved.certain) {
                doubtful += 1;
                continue;
            }
            for (axis, (&measured, expected)) in measured.iter().zip(moved.position).enumerate() {
                let name = || format!("coordinate {axis} of chain {index} after frame {frame}");
                comparison.number(name, measured, expected);
            }
        }
    }
    println!("{doubtful} of {} in doubt", 4 * COUNT);
    assert!(doubtful * 10 < 4 * COUNT, "{doubtful} in doubt");
    comparison
}

#[test]
fn agree_with_the_oracle() {
    for start in Start::ALL {
        for stress in [Stress::Smooth, Stress::Noise { sigma: 2.0 }, Stress::Ring, Stress::Zero] {
            let settings = ChainSettings { start, ..ChainSettings::of(COUNT) };
            let comparison = compare(&settings, stress, whole_space());
            comparison.assert_holds(&format!("chains of {stress:?} from {start}"));
        }
    }
}

/// Chains that move far enough for a break to show.
fn lively() -> ChainSettings {
    ChainSettings { mutations: 4, large_steps: 0.1, ..ChainSettings::of(COUNT) }
}

#[test]
fn broken_chains_are_noticed() {
    let breaks = [
        ("metropolis", "<= proposed_density", "<= 1.1 * proposed_density"),
        ("metropolis", "2.0 * place - 1.0", "2.0 * place"),
        ("metropolis", "1.0 - abs(1.0 - moved)", "moved"),
        ("metropolis", "density = proposed_density;", ""),
        ("metropolis", "kind < parameters.large_steps", "kind > parameters.large_steps"),
        ("metropolis", "v.w += v.y * v.z;", "v.w += v.y * v.x;"),
    ];
    for (id, from, to) in breaks {
        // A large radius, for reflections.
        let settings = ChainSettings { radius: 0.5, ..lively() };
        compare(&settings, Stress::Smooth, &broken(id, from, to)).assert_fails(to);
    }
    let settings = ChainSettings { start: Start::Uniform, ..lively() };
    let package = broken("metropolis_start-uniform", "0xffffffffu", "0u");
    compare(&settings, Stress::Smooth, &package).assert_fails("another start");
}

/// The chi-square over its degrees of freedom of the counts of points in 64 blocks of the image: 1 of points that know
/// nothing of each other.
fn chi_square(points: &[[f32; 2]], density: &DensityTexture) -> f64 {
    let pyramid = &density.pyramid;
    let level = pyramid.top_level() - 3;
    let blocks = pyramid.size_at(level);
    let whole: f64 = pyramid.level(level).iter().map(|mass| mass.value).sum();
    let mut counts = vec![0.0; blocks * blocks];
    for point in points {
        let [x, y] = point.map(|part| ((part * blocks as f32) as usize).min(blocks - 1));
        counts[y * blocks + x] += 1.0;
    }
    let pairs = counts.iter().zip(pyramid.level(level));
    pairs
        .map(|(count, mass)| {
            let expected = mass.value / whole * points.len() as f64;
            (count - expected).powi(2) / expected
        })
        .sum::<f64>()
        / (counts.len() - 1) as f64
}

/// What the lattice has and the chains lose: the device's own points, in 64 blocks of the image.
#[test]
fn chains_follow_the_density_and_are_not_stratified() {
    let settings =
        ChainSettings { large_steps: 0.25, start: Start::Uniform, ..ChainSettings::of(4096) };
    let density = DensityTexture::new([SIZE; 2], Stress::Smooth, 9);
    let stratified: Vec<[f32; 2]> = (0..4096)
        .map(|index| warp(&density.pyramid, lattice::point::<Bounded>(index, 4096)).centre)
        .map(|centre| centre.map(|part| part.value() as f32))
        .collect();
    let frames = run(&settings, Stress::Smooth, whole_space(), 30);
    let [lattice, first, last] =
        [&stratified, &frames[0], &frames[29]].map(|points| chi_square(points, &density));
    println!(
        "chi-square over degrees of freedom: lattice {lattice:.4}, chains {first:.2}, then {last:.3}"
    );
    assert!((0.3..1.7).contains(&last) && lattice < 0.1 * last, "{lattice} {last}");
    // Negative control: chains that take every step forget the density.
    let package = broken("metropolis", "* density <= proposed_density", "<= 1.0");
    let frames = run(&settings, Stress::Smooth, &package, 30);
    assert!(chi_square(&frames[29], &density) > 3.0);
}

/// The same kernels and the same clusters follow, whatever draws the centres.
#[test]
fn kernels_and_clusters_take_their_centres_from_the_chains() {
    let settings = Settings { draw: Draw::Metropolis, ..small() };
    let centres = |package: &Package| {
        let run = Run::new(&settings, KINDS[0], package, 3);
        let kernels: Vec<SglowKernel> =
            readback::buffer(gpu(), &run.indirect.kernels().unwrap()).unwrap();
        let chains: Vec<[f32; 2]> =
            readback::buffer(gpu(), &run.indirect.chains().unwrap()).unwrap();
        let lights: Vec<Vsgl> = reference::lights(gpu(), &run.indirect).unwrap();
        assert!(lights.iter().all(|light| light.power().luminance().is_finite()));
        assert!(lights.iter().any(|light| light.power().luminance() > 0.0));
        (kernels.iter().map(|kernel| kernel.centre).collect::<Vec<_>>(), chains)
    };
    let (kernels, chains) = centres(whole_space());
    assert_eq!(kernels, chains);
    let id = "sample-metropolis-modified-bracketed-exact-trace-exact-both-f32";
    let (kernels, chains) = centres(&broken(id, "sglow_chains[id.x]", "sglow_chains[id.x / 2u]"));
    assert_ne!(kernels, chains, "other chains go unnoticed");

    let size = [SIZE; 2];
    let mut chains = Chains::new(whole_space(), &ChainSettings::of(90), SIZE);
    let settings = ClusterSettings {
        size,
        count: 90,
        draw: Draw::Metropolis,
        space: Space::Image,
        light: Light::Spot,
        grid: [1, 1],
        variance: Variance::Trace,
        sharpness: Sharpness::Exact,
        lobes: Lobes::Both,
        specular_power: SpecularPower::F0,
        diffuse_mean_length: 1.0,
    };
    let mut clusters = Clusters::new(whole_space(), &settings).unwrap();
    let density = DensityTexture::new(size, Stress::Ring, 9);
    let map = Uploaded::new(&random_surfaces(size, 1), size);
    let light = light(KINDS[0], SIZE);
    chains.advance(density.view.texture());
    let inputs = ClusterInputs {
        map: map.views(),
        light: &light,
        density: &density.view,
        chains: Some(chains.buffer()),
    };
    clusters.run(&inputs).unwrap();
    for (centre, chain) in clusters.centres().into_iter().zip(chains.read()) {
        // A power of two rounds nothing.
        assert_eq!(centre, [chain[0] * 64.0, chain[1] * 64.0, 0.0, 0.0]);
    }
}
