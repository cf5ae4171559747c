//! The density and both mip chains: `shaders/src/rsm/density.wesl`, `shaders/src/rsm/mip.wesl`.

use sglow_oracle::fis::stress::Random;
use sglow_oracle::rsm::{Moments, mip};
use sglow_oracle::{Bounded, Real};
use sglow_renderer::mips::Pyramid;
use sglow_renderer::stages::Stages as _;
use sglow_renderer::{mips, readback};
use sglow_runtime::package::Package;
use sglow_runtime::settings::Settings;
use sglow_shaders::Precision;

use crate::common::{Comparison, KINDS, Run, broken, gpu, small, whole_space};

fn halves() -> Settings {
    Settings { precision: Precision::F16, ..small() }
}

/// Compares each level of the moments, of the density and of halves with the mean of the level `finer` below it.
fn compare(run: &Run, finer: u32) -> [Comparison; 3] {
    let mut comparisons = [(); 3].map(|()| Comparison::default());
    let textures = [run.indirect.moments().unwrap(), run.indirect.density().unwrap()];
    let textures = textures.into_iter().chain(run.indirect.half_moments());
    for (texture, comparison) in textures.zip(&mut comparisons) {
        let half = texture.format() == wgpu::TextureFormat::Rgba16Float;
        let stored = |value: Bounded| if half { value.to_half() } else { value };
        let layers = texture.depth_or_array_layers() as usize;
        for level in finer..texture.mip_level_count() {
            let below = readback::texture(gpu(), &texture, level - finer).unwrap();
            let measured = readback::texture(gpu(), &texture, level).unwrap();
            let size = (texture.width() >> (level - finer)) as usize;
            for layer in 0..layers {
                let texels = &below[layer * size * size..][..size * size];
                let texels: Vec<_> =
                    texels.iter().map(|&texel| Moments::<Bounded>::of_texels(&[texel])).collect();
                let last = size / 2 - 1;
                let measured_size = (texture.width() >> level) as usize;
                for (index, &measured) in measured[layer * measured_size * measured_size..]
                    [..measured_size * measured_size]
                    .iter()
                    .enumerate()
                {
                    let (x, y) = (index % measured_size, index / measured_size);
                    let expected = mip::mean(&texels, size, x.min(last), y.min(last));
                    let name = format!("level {level} layer {layer} texel {x} {y}");
                    comparison.texel(&name, measured, expected.layers[0].map(stored));
                }
            }
        }
    }
    comparisons
}

#[test]
fn levels_are_means() {
    let run = Run::new(&small(), KINDS[0], &Package::embedded(), 2);
    let [moments, density, _] = compare(&run, 1);
    moments.assert_holds("mips of the moments");
    density.assert_holds("mips of the density");
    let run = Run::new(&halves(), KINDS[0], whole_space(), 2);
    let [moments, density, halves] = compare(&run, 1);
    moments.assert_holds("mips of the moments beside halves");
    density.assert_holds("mips of the density beside halves");
    halves.assert_holds("mips of halves");
}

#[test]
fn a_level_off_by_one_is_noticed() {
    let run = Run::new(&small(), KINDS[0], &Package::embedded(), 2);
    let [moments, density, _] = compare(&run, 2);
    moments.assert_fails("a level of the moments off by one");
    density.assert_fails("a level of the density off by one");
    let run = Run::new(&halves(), KINDS[0], whole_space(), 2);
    compare(&run, 2)[2].assert_fails("a level of halves off by one");
}

#[test]
fn a_broken_shader_is_noticed() {
    for (id, which) in [("mip-rgba32float-three", 0), ("mip-r32float-three", 1)] {
        for (from, to) in
            [("0.25 * (upper", "0.24999 * (upper"), ("vec2<u32>(1u, 1u)", "vec2<u32>(1u, 0u)")]
        {
            let run = Run::new(&small(), KINDS[0], &broken(id, from, to), 2);
            compare(&run, 1)[which].assert_fails(&format!("{id} with {to}"));
        }
    }
    // Halves are rounded by one part in two thousand; without our rounding a device may cut them off, and lavapipe does.
    for (from, to) in [
        ("sglow_half(0.25 * (upper + lower))", "0.25 * (upper + lower)"),
        ("0.25 * (upper", "0.2498 * (upper"),
        ("vec2<u32>(1u, 1u)", "vec2<u32>(1u, 0u)"),
    ] {
        let run = Run::new(&halves(), KINDS[0], &broken("mip-rgba16float-three", from, to), 2);
        compare(&run, 1)[2].assert_fails(&format!("mip-rgba16float with {to}"));
    }
}

#[test]
fn the_density_is_the_weight() {
    let run = Run::new(&small(), KINDS[0], &Package::embedded(), 2);
    let size = small().map as usize;
    let moments = readback::texture(gpu(), &run.indirect.moments().unwrap(), 0).unwrap();
    let density = readback::texture(gpu(), &run.indirect.density().unwrap(), 0).unwrap();
    let compare = |channel: usize| {
        let mut comparison = Comparison::default();
        for (index, texel) in density.iter().enumerate() {
            let expected = Bounded::exact(moments[size * size + index][channel]);
            comparison.number(|| format!("texel {index}"), texel[0], expected);
        }
        comparison
    };
    compare(3).assert_holds("density");
    compare(0).assert_fails("another channel for the density");
}

/// Level 0 of random texels, one channel: `extent` of them.
fn random_texels([width, height]: [u32; 2]) -> Vec<f32> {
    let mut random = Random::new(9);
    (0..width * height).map(|_| (3.0 * random.normal()).exp() as f32).collect()
}

/// The levels in f32, each from the one below it: what one dispatch per level gives.
fn chain(size: usize, [width, height]: [u32; 2], texels: &[f32]) -> Vec<Vec<f32>> {
    let mut level = vec![0.0_f32; size * size];
    for (row, texels) in texels.chunks_exact(width as usize).take(height as usize).enumerate() {
        level[row * size..][..texels.len()].copy_from_slice(texels);
    }
    let mut levels = vec![level];
    for side in (0..size.ilog2()).map(|halvings| size >> (halvings + 1)) {
        let below = &levels[levels.len() - 1];
        let texel = |index: usize| {
            let first = 4 * side * (index / side) + 2 * (index % side);
            let (upper, lower) = (first, first + 2 * side);
            0.25 * ((below[upper] + below[upper + 1]) + (below[lower] + below[lower + 1]))
        };
        levels.push((0..side * side).map(texel).collect());
    }
    levels
}

/// How many texels of the device's chain are not those of [`chain`] to the bit.
fn differing(package: &Package, size: u32, extent: [u32; 2], texels: &[f32]) -> usize {
    let bytes = bytemuck::cast_slice(texels);
    let texture = mips::build(gpu(), package, Pyramid::Density, extent, bytes).unwrap();
    let expected = chain(size as usize, extent, texels);
    let differing = (0..).zip(&expected).map(|(level, expected)| {
        let measured = readback::texture(gpu(), &texture, level).unwrap();
        assert_eq!(measured.len(), expected.len());
        let pairs = measured.iter().zip(expected);
        pairs.filter(|(measured, expected)| measured[0].to_bits() != expected.to_bits()).count()
    });
    differing.sum()
}

/// Three levels at once are what three dispatches would give, to the bit, for each number of levels; and where only a
/// part of the square holds anything, no more than that part is dispatched over.
#[test]
fn levels_are_the_same_to_the_bit() {
    for size in [2_u32, 4, 8, 64, 128] {
        for extent in [[size; 2], [(37 * size).div_ceil(64), (21 * size).div_ceil(64)]] {
            let texels = random_texels(extent);
            assert_eq!(differing(whole_space(), size, extent, &texels), 0, "{size} {extent:?}");
        }
    }
    // Negative controls: a driver that may put sums together in another order; a part that is too small.
    let id = "mip-r32float-three";
    let mean = "min(0.25 * (upper + lower), vec4<f32>(3.4028234e38))";
    let package = broken(id, mean, "0.25 * ((upper + lower) + vec4<f32>(1e-7))");
    assert!(differing(&package, 64, [64; 2], &random_texels([64; 2])) > 0);
    let whole = random_texels([64; 2]);
    let bytes = bytemuck::cast_slice(&whole[..64 * 40]);
    let part = mips::build(gpu(), whole_space(), Pyramid::Density, [64, 40], bytes).unwrap();
    let top = readback::texture(gpu(), &part, 6).unwrap()[0][0];
    assert!(top.to_bits() != chain(64, [64; 2], &whole)[6][0].to_bits());
}

#[test]
fn what_is_no_mip_chain_is_refused() {
    let package = Package::embedded();
    let build = mips::build(gpu(), &package, Pyramid::Density, [4; 2], &[0; 60]);
    assert!(build.unwrap_err().to_string().contains("60 bytes of texels; 64"));
}
