//! The sharpness of a von Mises-Fisher distribution from the mean length of its directions, and back.
//!
//! The exact relation is `r = L(l) = coth l - 1/l`, the Langevin function. A mean length comes with its complement
//! `1 - r`: near 1 all digits are in the complement.

use crate::Real;

/// The least complement that counts, 2^-41: the greatest sharpness is about its inverse.
pub const MINIMUM_COMPLEMENT: f64 = 1.0 / 2_199_023_255_552.0;
/// Where the two forms of the Langevin function meet.
const MEETING: f64 = 2.0;
/// Terms of the continued fraction; enough for f64 at [`MEETING`].
const TERMS: i32 = 14;
/// The greatest sharpness whose inverse is a normal f32 number: 2^126.
const GREATEST: f64 = 1.0 / crate::tolerance::SMALLEST_NORMAL;

/// How a sharpness follows from a mean length.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Sharpness {
    /// [`toksvig`], and [`mean_length_toksvig`] back.
    Toksvig,
    /// [`banerjee`], and [`mean_length`] back.
    Banerjee,
    /// [`exact`], and [`mean_length`] back.
    Exact,
}

impl Sharpness {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Toksvig, Self::Banerjee, Self::Exact];

    /// The sharpness of directions of a mean length, which comes with its complement.
    pub fn of<R: Real>(self, mean_length: R, complement: R) -> R {
        match self {
            Self::Toksvig => toksvig(mean_length, complement),
            Self::Banerjee => banerjee(mean_length, complement),
            Self::Exact => exact(mean_length, complement),
        }
    }

    /// The mean length that gives back a sharpness above 0.
    pub fn mean_length<R: Real>(self, sharpness: R) -> R {
        match self {
            // l/(l + 1) in the form that shows how little the sharpness's own error matters.
            Self::Toksvig => R::one() / (R::one() + R::one() / sharpness),
            Self::Banerjee | Self::Exact => mean_length(sharpness),
        }
    }
}

fn clamped<R: Real>(mean_length: R, complement: R) -> [R; 2] {
    let complement = complement.max(R::constant(MINIMUM_COMPLEMENT)).min(R::one());
    [mean_length.clamp(0.0, 1.0), complement]
}

/// `r/(1 - r)`.
// [Toksvig 2005]
pub fn toksvig<R: Real>(mean_length: R, complement: R) -> R {
    let [length, complement] = clamped(mean_length, complement);
    length / complement
}

/// `(3 r - r^3)/(1 - r^2)`.
// [Banerjee 2005, Eq. (4.4)]
pub fn banerjee<R: Real>(mean_length: R, complement: R) -> R {
    let [length, complement] = clamped(mean_length, complement);
    let numerator = R::constant(3.0) - length.squared();
    length * numerator / (complement * (R::one() + length))
}

/// `(3 r - (r/5) (6 r^2 + r^4 - 2 r^6))/(1 - r^2)`.
// [Kroeger 2015]
pub fn kroeger<R: Real>(mean_length: R, complement: R) -> R {
    let [length, complement] = clamped(mean_length, complement);
    let square = length.squared();
    let series = R::constant(6.0) + square * (R::one() - R::constant(2.0) * square);
    let numerator = R::constant(3.0) - R::constant(0.2) * square * series;
    length * numerator / (complement * (R::one() + length))
}

/// `L(l)/l` by a continued fraction whose terms are all positive: `1/(3 + l^2/(5 + l^2/(7 + ...)))`.
// [DLMF, 10.33.1], the quotient of the modified spherical Bessel functions of order 1 and 0
fn langevin_over<R: Real>(sharpness: R) -> R {
    let square = sharpness.squared();
    let mut tail = R::constant(f64::from(2 * TERMS + 1));
    for term in (1..TERMS).rev() {
        tail = R::constant(f64::from(2 * term + 1)) + square / tail;
    }
    R::one() / tail
}

/// `1 - L(l) = 1/l - 2/(e^(2l) - 1)` for a sharpness of at least [`MEETING`], where the difference keeps its digits.
fn sharp_complement<R: Real>(sharpness: R) -> R {
    let decay = (R::constant(-2.0) * sharpness.min(R::constant(64.0))).exp();
    R::one() / sharpness - R::constant(2.0) * decay / (R::one() - decay)
}

/// The solution of `L(l) = r` to a relative 4e-7: [`kroeger`]'s, after one step of Newton's method on `1/(1 - L(l))`.
///
/// That function is nearly a straight line where `L` bends most, so that the step leaves a twentieth of the error of
/// a step on `L` (7e-6).
pub fn exact<R: Real>(mean_length: R, complement: R) -> R {
    let start = kroeger(mean_length, complement);
    let [length, complement] = clamped(mean_length, complement);
    if start.value() < MEETING {
        let over = langevin_over(start);
        let found = over * start;
        // L' = 1 - 2 L/l - L^2, the derivative of coth written with L itself.
        let slope = R::one() - R::constant(2.0) * over - found.squared();
        let ratio = (R::one() - found) / complement;
        return start - ratio * (found - length) / slope;
    }
    let found = sharp_complement(start);
    // l^2 L' = 1 - (l/sinh l)^2.
    let decay = (-start.min(R::constant(64.0))).exp();
    let sine = R::constant(2.0) * start * decay / (R::one() - decay.squared());
    let slope = R::one() - sine.squared();
    start - start * (start * (complement - found)) * (found / complement) / slope
}

/// `l/(l + 1)`.
// [Toksvig 2005]
pub fn mean_length_toksvig<R: Real>(sharpness: R) -> R {
    let sharpness = sharpness.min(R::constant(1e30));
    sharpness / (sharpness + R::one())
}

/// `L(l)`, exact; 0 to 1.
// [Banerjee 2005]
pub fn mean_length<R: Real>(sharpness: R) -> R {
    if sharpness.value() < MEETING {
        return sharpness * langevin_over(sharpness);
    }
    R::one() - sharp_complement(sharpness.min(R::constant(GREATEST)))
}

/// `1 - L(l)`, exact; the inverse of the sharpness where that is large. Sharpness counts up to 2^126.
pub fn mean_length_complement<R: Real>(sharpness: R) -> R {
    if sharpness.value() < MEETING {
        return R::one() - sharpness * langevin_over(sharpness);
    }
    sharp_complement(sharpness.min(R::constant(GREATEST)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::quadrature::SphereRule;
    use crate::sg::{evaluate, integral};
    use crate::{Bounded, Vector3};

    /// Sharpness from 1e-6 to 1e12.
    fn sharpnesses() -> impl Iterator<Item = f64> {
        (0..=1800).map(|step| 10f64.powf(f64::from(step) * 0.01 - 6.0))
    }

    /// The largest relative error of a form.
    fn worst(form: fn(f64, f64) -> f64) -> (f64, f64) {
        sharpnesses()
            .map(|l| ((form(mean_length(l), mean_length_complement(l)) / l - 1.0).abs(), l))
            .fold((0.0, 0.0), |worst, next| if next.0 > worst.0 { next } else { worst })
    }

    #[test]
    fn the_mean_length_equals_the_quadrature() {
        let axis = Vector3::new(0.0, 0.6, 0.8);
        for l in [0.0, 1e-6, 0.1, 1.0, 1.999_999, 2.0, 7.0, 1e3, 1e8] {
            let rule = SphereRule::around(axis, l);
            let lobe = |at| evaluate(at, axis, l) / integral(l);
            let mean = rule.integrate(|at: Vector3| at.dot(axis) * lobe(at));
            // 1 - w . x as half the squared chord.
            let rest = rule.integrate(|at| 0.5 * (at - axis).length_squared() * lobe(at));
            assert!((mean_length(l) - mean).abs() < 1e-12, "{l}");
            assert!((mean_length_complement(l) / rest - 1.0).abs() < 1e-11, "{l}");
            // Negative control: another sharpness.
            assert!((mean_length_complement(1.01 * l + 1e-3) / rest - 1.0).abs() > 1e-4);
        }
    }

    #[test]
    fn errors_of_the_forms() {
        let tables = [
            ("toksvig", worst(toksvig), 0.667),
            ("banerjee", worst(banerjee), 0.0495),
            ("kroeger", worst(kroeger), 0.0028),
            ("exact", worst(exact), 4e-7),
        ];
        for (name, (error, at), bound) in tables {
            println!("{name}: {error:.3e} at sharpness {at:.3e}");
            // The bound is the stated error: it holds, and not by far.
            assert!(error < bound && error > 0.5 * bound, "{name} {error} {at}");
        }
    }

    #[test]
    fn exact_holds_in_f32() {
        // Model and rounding together, when every operation errs by all that it may.
        let mut largest = 0.0_f64;
        for l in sharpnesses() {
            let bounded: Bounded = exact(
                Bounded::constant(mean_length(l)),
                Bounded::constant(mean_length_complement(l)),
            );
            let back: Bounded = mean_length(Bounded::constant(l));
            let rest: Bounded = mean_length_complement(Bounded::constant(l));
            assert!(back.error < 2e-6 * back.value && rest.error < 4e-6 * rest.value, "{l}");
            largest = largest.max((bounded.error + (bounded.value - l).abs()) / l);
        }
        println!("exact, in f32: {largest:.2e}");
        assert!(largest < 1e-5, "{largest}");
        // Negative control: without the complement, f32 cannot know a large sharpness.
        let r = Bounded::constant(mean_length(1e6));
        let lost: Bounded = exact(r, Bounded::one() - r);
        assert!(lost.error > 1e-2 * lost.value, "{lost:?}");
    }

    #[test]
    fn everything_is_finite_and_monotone() {
        let forms = [toksvig::<f64>, banerjee, kroeger, exact];
        for form in forms {
            assert_eq!(form(0.0, 1.0), 0.0);
            let most = form(1.0, 0.0);
            assert!(most.is_finite() && (most * MINIMUM_COMPLEMENT - 1.0).abs() < 1e-9, "{most}");
            let mut last = -1.0;
            for l in core::iter::once(0.0).chain(sharpnesses()) {
                let next = form(mean_length(l), mean_length_complement(l));
                assert!(next >= last, "{l} {next} {last}");
                last = next;
            }
            assert!(most >= last);
        }
        let extremes = [0.0, 1e-38, 1e-30, 2f64.powi(-24), 1.0, 1e2, 1e5, 2f64.powi(41)];
        let extremes = extremes.into_iter().chain([f64::from(f32::MAX)]);
        for lengths in
            [mean_length::<f64>, mean_length_toksvig, |l| 1.0 - mean_length_complement(l)]
        {
            let mut last = 0.0;
            for l in extremes.clone() {
                let next = lengths(l);
                assert!(next >= last && next <= 1.0, "{l} {next}");
                last = next;
            }
            assert_eq!(last, 1.0);
        }
        let greatest = mean_length_complement(f64::from(f32::MAX));
        assert!(greatest >= crate::tolerance::SMALLEST_NORMAL, "{greatest}");
    }
}
