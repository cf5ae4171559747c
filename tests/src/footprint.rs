//! Kernels on a density of any size.

use sglow_oracle::fis::Footprints;
use sglow_oracle::fis::stress::Random;
use sglow_renderer::density::{Sampled, padded, sample};
use sglow_runtime::settings::Settings;
use sglow_shaders::Kernel;

use crate::common::{gpu, whole_space};

fn run(kernel: Kernel, count: u32, size: [usize; 2], texels: &[f32]) -> (f64, Sampled) {
    let (side, square) = padded(size, texels);
    let settings = Settings { kernel, count, rsm_size: side as u32, ..Settings::default() };
    (side as f64, sample(gpu(), whole_space(), &settings, &square, &square).unwrap())
}

/// The image is wide and smooth, and padded to a square: all kernels lie in it, and those of the modified method hold
/// the same mass, but for the difference between a square and the filter.
#[test]
fn kernels_on_a_padded_image_hold_equal_masses() {
    let size = [100, 40];
    let texels: Vec<f32> =
        (0..size[0] * size[1]).map(|index| 1.0 + (index % size[0]) as f32 / 50.0).collect();
    let footprints = Footprints::new(size, &texels);
    let (side, sampled) = run(Kernel::Modified, 64, size, &texels);
    assert_eq!(side, 128.0);
    let mut masses = Vec::new();
    for kernel in &sampled.kernels {
        let [x, y] = kernel.centre.map(|part| f64::from(part) * side);
        assert!(x < 100.0 && y < 40.0, "({x}, {y}) is outside of the image");
        let mass = footprints.mass([x, y], f64::from(kernel.level).exp2());
        masses.push(64.0 * mass / footprints.total());
    }
    let mean = masses.iter().sum::<f64>() / 64.0;
    println!("mean mass times N: {mean:.3}");
    assert!((mean - 1.0).abs() < 0.25, "{mean}");
    assert!((sampled.powers.iter().sum::<f64>() / sampled.total - 1.0).abs() < 0.01);
    // Negative control: read without the padding's factor, centres and masses are others.
    let wrong: f64 = sampled
        .kernels
        .iter()
        .map(|kernel| {
            let place = kernel.centre.map(|part| f64::from(part) * 100.0);
            footprints.mass(place, f64::from(kernel.level).exp2() * 100.0 / side)
        })
        .sum();
    assert!((wrong / footprints.total() - 1.0).abs() > 0.25, "{wrong}");
}

#[test]
fn one_kernel_more_kernels_than_texels_and_no_density_work() {
    let mut random = Random::new(3);
    let texels: Vec<f32> = (0..15).map(|_| random.uniform() as f32).collect();
    for kernel in [Kernel::Previous, Kernel::Modified] {
        for (count, texels) in [(1, texels.clone()), (1000, texels.clone()), (16, vec![0.0; 15])] {
            let (_, sampled) = run(kernel, count, [5, 3], &texels);
            assert_eq!(sampled.kernels.len(), count as usize);
            let numbers = sampled.kernels.iter().flat_map(|kernel| {
                [kernel.centre[0], kernel.centre[1], kernel.level, kernel.scale].map(f64::from)
            });
            assert!(numbers.chain(sampled.powers.iter().copied()).all(f64::is_finite));
            let power: f64 = sampled.powers.iter().sum();
            if sampled.total == 0.0 {
                assert_eq!(power, 0.0);
            } else if kernel == Kernel::Modified {
                assert!((power / sampled.total - 1.0).abs() < 0.01, "{power}");
            }
        }
    }
}
