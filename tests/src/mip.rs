//! The density and both mip chains: `shaders/src/rsm/density.wesl`, `shaders/src/rsm/mip.wesl`.

use sglow_oracle::Bounded;
use sglow_oracle::rsm::{Moments, mip};
use sglow_runtime::package::Package;
use sglow_runtime::readback;

use crate::common::{Comparison, KINDS, Run, broken, gpu, small};

/// Compares each level with the mean of the level `finer` below it.
fn compare(run: &Run, finer: u32) -> [Comparison; 2] {
    let mut comparisons = [Comparison::default(), Comparison::default()];
    let textures = [run.indirect.moments(), run.indirect.density()];
    for (texture, comparison) in textures.into_iter().zip(&mut comparisons) {
        let layers = texture.depth_or_array_layers() as usize;
        for level in finer..texture.mip_level_count() {
            let below = readback::texture(gpu(), texture, level - finer).unwrap();
            let measured = readback::texture(gpu(), texture, level).unwrap();
            let size = (texture.width() >> (level - finer)) as usize;
            for layer in 0..layers {
                let texels = &below[layer * size * size..][..size * size];
                let texels: Vec<_> =
                    texels.iter().map(|&texel| Moments::<Bounded>::of_texels(&[texel])).collect();
                let half = size / 2;
                let measured_size = (texture.width() >> level) as usize;
                for (index, &measured) in measured[layer * measured_size * measured_size..]
                    [..measured_size * measured_size]
                    .iter()
                    .enumerate()
                {
                    let (x, y) = (index % measured_size, index / measured_size);
                    let expected = mip::mean(&texels, size, x.min(half - 1), y.min(half - 1));
                    let name = format!("level {level} layer {layer} texel {x} {y}");
                    comparison.texel(&name, measured, expected.layers[0]);
                }
            }
        }
    }
    comparisons
}

#[test]
fn levels_are_means() {
    let run = Run::new(&small(), KINDS[0], &Package::embedded(), 2);
    let [moments, density] = compare(&run, 1);
    moments.assert_holds("mips of the moments");
    density.assert_holds("mips of the density");
}

#[test]
fn a_level_off_by_one_is_noticed() {
    let run = Run::new(&small(), KINDS[0], &Package::embedded(), 2);
    let [moments, density] = compare(&run, 2);
    moments.assert_fails("a level of the moments off by one");
    density.assert_fails("a level of the density off by one");
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
