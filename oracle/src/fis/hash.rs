//! Random bits of four numbers.

/// Four words of random bits: the permuted congruential generator in four dimensions, `pcg4d`.
// [Jarzynski and Olano 2020]
#[must_use]
pub fn hash(words: [u32; 4]) -> [u32; 4] {
    let mut v = words.map(|word| word.wrapping_mul(1_664_525).wrapping_add(1_013_904_223));
    let mix = |v: &mut [u32; 4]| {
        for (target, a, b) in [(0, 1, 3), (1, 2, 0), (2, 0, 1), (3, 1, 2)] {
            v[target] = v[target].wrapping_add(v[a].wrapping_mul(v[b]));
        }
    };
    mix(&mut v);
    v = v.map(|word| word ^ (word >> 16));
    mix(&mut v);
    v
}

/// A number above 0 and at most 1 of random bits: a multiple of 2^-24, which f32 holds.
#[must_use]
pub fn unit_number(word: u32) -> f64 {
    f64::from((word >> 8) + 1) / f64::from(1 << 24)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn neighbours_have_nothing_in_common() {
        // Means, and products of neighbours in every argument and in every result.
        let number = |words: [u32; 4], part: usize| unit_number(hash(words)[part]) - 0.5;
        let count = 20_000;
        for part in 0..4 {
            let mean =
                |value: &dyn Fn(u32) -> f64| (0..count).map(value).sum::<f64>() / f64::from(count);
            // Five standard deviations: sqrt(1/12/count) of a mean, 1/12/sqrt(count) of a product's.
            assert!(mean(&|i| number([i, 2, 3, 4], part)).abs() < 0.0103);
            for argument in 0..4 {
                let product = |i: u32| {
                    let mut words = [i % 100, i / 100, 3, 4];
                    let one = number(words, part);
                    words[argument] += 1;
                    one * number(words, part)
                };
                assert!(mean(&product).abs() < 0.003, "{part} {argument}");
            }
            let other = (part + 1) % 4;
            let across = |i: u32| number([i, 0, 0, 1], part) * number([i, 0, 0, 1], other);
            assert!(mean(&across).abs() < 0.003, "{part}");
        }
    }
}
