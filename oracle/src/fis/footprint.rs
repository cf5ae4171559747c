//! What lies within a kernel, by summing it: the reference that filtering approximates.

/// Sums of a density from its corner, in f64.
// [Crow 1984, Summed-area tables for texture mapping]
#[derive(Clone, Debug)]
pub struct Footprints {
    size: [usize; 2],
    /// Sums of everything left of a column and above a row; one more of each than texels.
    sums: Vec<f64>,
}

impl Footprints {
    /// The sums of an image of `size` texels, row by row from the top; texels that are missing are 0.
    #[must_use]
    pub fn new(size: [usize; 2], texels: &[f32]) -> Self {
        let [width, height] = size;
        let stride = width + 1;
        let mut sums = vec![0.0; stride * (height + 1)];
        for y in 0..height {
            let mut row = 0.0;
            for x in 0..width {
                row += texels.get(y * width + x).copied().map_or(0.0, f64::from);
                sums[(y + 1) * stride + x + 1] = sums[y * stride + x + 1] + row;
            }
        }
        Self { size, sums }
    }

    /// The sum of all texels.
    #[must_use]
    pub fn total(&self) -> f64 {
        self.sums.last().copied().unwrap_or(0.0)
    }

    /// The sum within a square of a side in texels around a centre in texels from the top left corner; what is beyond
    /// the image is 0, and a texel that is partly within counts by its area.
    #[must_use]
    pub fn mass(&self, centre: [f64; 2], side: f64) -> f64 {
        let [left, top] = centre.map(|part| part - 0.5 * side);
        let [right, bottom] = centre.map(|part| part + 0.5 * side);
        let sum = self.corner(right, bottom) - self.corner(left, bottom) - self.corner(right, top)
            + self.corner(left, top);
        // Rounding may leave less than nothing.
        sum.max(0.0)
    }

    /// The sum of what is left of and above a point: bilinear between the sums, which is exact, since the density is
    /// constant within a texel.
    fn corner(&self, x: f64, y: f64) -> f64 {
        let [width, height] = self.size;
        let split = |part: f64, last: usize| {
            let inside = part.clamp(0.0, last as f64);
            let low = (inside.floor() as usize).min(last);
            (low, (low + 1).min(last), inside - low as f64)
        };
        let ((x0, x1, right), (y0, y1, down)) = (split(x, width), split(y, height));
        let at = |x: usize, y: usize| self.sums[y * (width + 1) + x];
        let row = |y: usize| at(x0, y) * (1.0 - right) + at(x1, y) * right;
        row(y0) * (1.0 - down) + row(y1) * down
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fis::stress::Random;

    /// The same by the overlap of every texel.
    fn plainly(size: [usize; 2], texels: &[f32], centre: [f64; 2], side: f64) -> f64 {
        let overlap = |index: usize, centre: f64| {
            let (low, high) = (centre - 0.5 * side, centre + 0.5 * side);
            (high.min(index as f64 + 1.0) - low.max(index as f64)).max(0.0)
        };
        let of = |(index, &texel): (usize, &f32)| {
            let (x, y) = (index % size[0], index / size[0]);
            f64::from(texel) * overlap(x, centre[0]) * overlap(y, centre[1])
        };
        texels.iter().enumerate().map(of).sum()
    }

    #[test]
    fn is_the_sum_of_overlaps() {
        let mut random = Random::new(1);
        let size = [13, 7];
        let texels: Vec<f32> = (0..91).map(|_| random.uniform() as f32).collect();
        let footprints = Footprints::new(size, &texels);
        assert!((footprints.total() - plainly(size, &texels, [6.5, 3.5], 26.0)).abs() < 1e-12);
        let mut noticed = 0;
        for _ in 0..1000 {
            let centre = [13.0 * random.uniform(), 7.0 * random.uniform()];
            let side = (4.0 * random.uniform()).exp2();
            let expected = plainly(size, &texels, centre, side);
            assert!((footprints.mass(centre, side) - expected).abs() < 1e-12);
            // Negative control: half a texel aside.
            let aside = footprints.mass([centre[0] + 0.5, centre[1]], side);
            noticed += usize::from((aside - expected).abs() > 1e-3);
        }
        assert!(noticed > 800, "{noticed}");
        // One texel exactly; nothing; everything.
        assert!((footprints.mass([3.5, 2.5], 1.0) - f64::from(texels[2 * 13 + 3])).abs() < 1e-12);
        assert_eq!(footprints.mass([-9.0, 3.0], 2.0), 0.0);
        assert_eq!(footprints.mass([6.0, 3.0], 1e9), footprints.total());
        assert_eq!(Footprints::new([4, 4], &[]).mass([2.0, 2.0], 2.0), 0.0);
    }
}
