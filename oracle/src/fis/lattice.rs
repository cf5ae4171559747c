//! The lattice of the golden ratio in the unit square.

use crate::Real;

/// 2^32 over the golden ratio.
const STEP: u32 = 2_654_435_769;

/// Point `index` of `count`: `((i + 0.5)/N, frac(i * 2654435769/2^32))`, the second coordinate cut to 24 bits.
// [Tokuyoshi 2016, Section 5], the Fibonacci lattice by an approximation of the golden ratio
pub fn point<R: Real>(index: u32, count: u32) -> [R; 2] {
    let second = index.wrapping_mul(STEP) >> 8;
    [
        (R::constant(f64::from(index)) + R::constant(0.5)) / R::constant(f64::from(count)),
        R::constant(f64::from(second) / f64::from(1 << 24)),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn is_stratified() {
        assert_eq!(point::<f64>(0, 4), [0.125, 0.0]);
        assert!((point::<f64>(1, 4)[1] - 0.618_033_9).abs() < 1e-7);
        // Every one of 32 x 32 cells of the square has close to its share of 32^3 points.
        let mut counts = [0_u32; 1024];
        for index in 0..32_768 {
            let [x, y] = point::<f64>(index, 32_768);
            counts[(y * 32.0) as usize * 32 + (x * 32.0) as usize] += 1;
        }
        assert!(counts.iter().all(|&count| (30..=34).contains(&count)), "{counts:?}");
    }
}
