//! The density and both mip chains: `shaders/src/rsm/density.wesl`, `shaders/src/rsm/mip.wesl`.

use sglow_oracle::rsm::{Moments, mip};
use sglow_oracle::{Bounded, Real};
use sglow_runtime::package::Package;
use sglow_runtime::readback;
use sglow_runtime::settings::Settings;
use sglow_shaders::Precision;

use crate::common::{Comparison, KINDS, Run, broken, gpu, small, whole_space};

fn halves() -> Settings {
    Settings { precision: Precision::F16, ..small() }
}

/// Compares each level of the moments, of the density and of halves with the mean of the level `finer` below it.
fn compare(run: &Run, finer: u32) -> [Comparison; 3] {
    let mut comparisons = [(); 3].map(|()| Comparison::default());
    let textures = [run.indirect.moments(), run.indirect.density()];
    let textures = textures.into_iter().chain(run.indirect.half_moments());
    for (texture, comparison) in textures.zip(&mut comparisons) {
        let half = texture.format() == wgpu::TextureFormat::Rgba16Float;
        let stored = |value: Bounded| if half { value.to_half() } else { value };
        let layers = texture.depth_or_array_layers() as usize;
        for level in finer..texture.mip_level_count() {
            let below = readback::texture(gpu(), texture, level - finer).unwrap();
            let measured = readback::texture(gpu(), texture, level).unwrap();
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
    for (id, which) in [("mip-rgba32float", 0), ("mip-r32float", 1)] {
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
        let run = Run::new(&halves(), KINDS[0], &broken("mip-rgba16float", from, to), 2);
        compare(&run, 1)[2].assert_fails(&format!("mip-rgba16float with {to}"));
    }
}

#[test]
fn the_density_is_the_weight() {
    let run = Run::new(&small(), KINDS[0], &Package::embedded(), 2);
    let size = small().rsm_size as usize;
    let moments = readback::texture(gpu(), run.indirect.moments(), 0).unwrap();
    let density = readback::texture(gpu(), run.indirect.density(), 0).unwrap();
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
