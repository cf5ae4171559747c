//! The root of Eq. (3) between two integer levels, from few look-ups of the density.

use core::f64::consts::LN_2;

use crate::Real;
use crate::fis::Level;
use crate::fis::filter::bilinear;
use crate::rsm::Pyramid;

/// The most look-ups of the density.
pub const LOOK_UPS: u32 = 5;

/// What [`bracketed_level`] found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bracketed<R = f64> {
    /// The level.
    pub level: Level<R>,
    /// Look-ups of the density: bilinear ones at an integer level.
    pub look_ups: u32,
    /// Whether the level is that of a root; if not, it is an end of the range.
    pub root: bool,
}

/// Keeps count of comparisons, and of whether rounding may have turned one.
struct Judge {
    margin: f64,
    certain: bool,
}

impl Judge {
    fn less<R: Real>(&mut self, mass: R, wanted: R) -> bool {
        let difference = mass - wanted;
        self.margin = self.margin.min(difference.value().abs() / wanted.value());
        self.certain &= difference.sign_is_certain() || difference.error() == 0.0;
        difference.value() < 0.0
    }
}

/// The level from the density's integral within the kernel, solved for between two integer levels that bracket it.
///
/// `texel` is that of level 0 that the warp ended in. The look-ups begin at the highest level at which the mass of the
/// texel that holds the centre, which never falls with the level, is less than the wanted one.
///
/// - That exists: the search goes towards a level with less mass whose next has no less. With several roots that gives
///   one where the mass grows with the level.
/// - The texel of level 0 has the wanted mass by itself but its filtered value has not: the same, from level 0 upwards.
/// - Both have: the lowest root, where the mass first falls below, if that is within the levels 0 to 4.
/// - No root found: level 0, or the top level where the whole image has less than the wanted mass.
///
/// Without mass the level is 0.
// [Tokuyoshi 2016, Eq. (3)]
pub fn bracketed_level<R: Real>(
    density: &Pyramid<R>,
    centre: [R; 2],
    texel: [usize; 2],
    count: u32,
    scale: f64,
) -> Bracketed<R> {
    let top = density.top_level();
    let mut judge = Judge { margin: f64::INFINITY, certain: true };
    let mut look_ups = 0;
    let whole = |level: usize| Bracketed {
        level: Level {
            level: R::constant(level as f64),
            margin: f64::INFINITY,
            certain: [level as f64; 2],
        },
        look_ups: 0,
        root: false,
    };
    // A map of one texel has no two levels that could bracket anything.
    if top == 0 || density.top().value() <= 0.0 {
        return whole(0);
    }
    let wanted = R::constant(scale) * R::constant(density.texel_count() as f64)
        / R::constant(f64::from(count));
    let area = |level: usize| R::constant(4f64.powi(level as i32));
    if judge.less(area(top), wanted) {
        return Bracketed {
            level: Level { certain: doubt(&judge, top, top as f64), ..whole(top).level },
            ..whole(top)
        };
    }
    // The texel's own mass, from the top down, as the warp sees it.
    let (mut crossing, mut ample) = (None, top);
    for level in (0..top).rev() {
        let own = density.at(level, texel[0] >> level, texel[1] >> level) / density.top();
        if judge.less(own * area(level), wanted) && crossing.is_none() {
            crossing = Some(level);
        }
        if (own * area(level)).value() > 4.0 * wanted.value() {
            ample = level;
        }
    }
    let mut look_up = |level: usize, judge: &mut Judge| {
        look_ups += 1;
        let filtered = bilinear(density, centre, level) / density.top();
        let mass = filtered * area(level);
        (judge.less(mass, wanted), mass / wanted)
    };
    // The bracket: levels with less than the wanted mass and with no less, each with its mass over the wanted one.
    let found =
        search(crossing, ample, top, area(top) / wanted, &mut |level| look_up(level, &mut judge));
    let Some([(less_level, less), (more_level, more)]) = found else {
        return Bracketed {
            level: Level {
                margin: judge.margin,
                certain: doubt(&judge, top, 0.0),
                ..whole(0).level
            },
            look_ups,
            root: false,
        };
    };
    let rising = less_level < more_level;
    let lower_level = less_level.min(more_level);
    let (lower, upper) = if rising { (less, more) } else { (more, less) };
    let upper = upper * R::constant(0.25);
    let t = solve_between(lower.value(), upper.value(), rising, STEPS);
    // What rounding may do to the difference whose zero is sought moves the zero between those of its two extremes.
    let excess =
        lower + (upper - lower) * R::constant(t) - (R::constant(-2.0) * R::constant(t)).exp2();
    let ends = [-excess.error(), excess.error()]
        .map(|shift| zero_between(lower.value() + shift, upper.value() + shift, rising));
    // Adding the level rounds as well.
    let own = R::constant(lower_level as f64) + R::constant(t);
    let certain = if judge.certain {
        let low = ends[0].min(ends[1]).min(t) + lower_level as f64 - own.error();
        let high = ends[0].max(ends[1]).max(t) + lower_level as f64 + own.error();
        [low, high]
    } else {
        [0.0, top as f64]
    };
    Bracketed {
        level: Level { level: R::constant(lower_level as f64 + t), margin: judge.margin, certain },
        look_ups,
        root: true,
    }
}

/// The interval of a level that no arithmetic went into but comparisons.
fn doubt(judge: &Judge, top: usize, level: f64) -> [f64; 2] {
    if judge.certain { [level; 2] } else { [0.0, top as f64] }
}

/// Two neighbouring levels, the first with less than the wanted mass, the second with no less; each with what `look_up`
/// gave beside its answer; `whole` is that of the top level, which has no less and needs no look-up.
fn search<R: Real>(
    crossing: Option<usize>,
    ample: usize,
    top: usize,
    whole: R,
    look_up: &mut impl FnMut(usize) -> (bool, R),
) -> Option<[(usize, R); 2]> {
    let (top, ample) = (top as i32, ample as i32);
    let mut less: (i32, Option<R>) = (-1, None);
    // An ample level has no less than the wanted mass: a quarter of its texel's counts at least.
    let mut more: (i32, Option<R>) =
        if ample + 1 < top { (ample + 1, None) } else { (top, Some(whole)) };
    let mut level = crossing.map_or(0, |level| level as i32);
    for left in (0..LOOK_UPS).rev() {
        if less.0 > more.0 {
            level = more.0 + 1;
        } else {
            // The levels in question are few enough for halving with the look-ups that are left.
            let reach = 1 << left;
            level = level.max(less.0 + 1).max(more.0 - reach).min(more.0 - 1).min(less.0 + reach);
        }
        let (is_less, mass) = look_up(level as usize);
        if is_less {
            less = (level, Some(mass));
            level += 1;
        } else {
            more = (level, Some(mass));
            level -= 1;
            if crossing.is_none() && less.1.is_none() && more.0 == 0 {
                less.0 = ample.min(LOOK_UPS as i32);
            }
        }
        if (more.0 - less.0).abs() <= 1 {
            break;
        }
    }
    let found = [(less.0, less.1?), (more.0, more.1?)];
    Some(found.map(|(level, mass)| (level as usize, mass)))
}

/// The steps after the first guess.
const STEPS: u32 = 2;

/// The t between 0 and 1 with `4^t (lower + (upper - lower) t) = 1`, by steps to zeros of osculating parabolas.
fn solve_between(lower: f64, upper: f64, rising: bool, steps: u32) -> f64 {
    let side = if rising { 1.0 } else { -1.0 };
    let parabola = |value: f64, slope: f64, curvature: f64| {
        let root = (slope * slope - 2.0 * value * curvature).max(0.0).sqrt();
        -2.0 * value / (side * (side * slope + root).max(1e-20))
    };
    let slope = upper - lower;
    let mut t = parabola(lower - 1.0, slope + 1.25, -1.0).clamp(0.0, 1.0);
    for _ in 0..steps {
        let area = (-2.0 * t).exp2();
        let value = lower + slope * t - area;
        let step = parabola(value, slope + 2.0 * LN_2 * area, -4.0 * LN_2 * LN_2 * area);
        t = (t + step).clamp(0.0, 1.0);
    }
    t
}

/// The same by halving, to the last digit; the nearer end where there is none.
fn zero_between(lower: f64, upper: f64, rising: bool) -> f64 {
    let value = |t: f64| lower + (upper - lower) * t - (-2.0 * t).exp2();
    // Where the difference is least at both ends, its greatest lies at the zero of its slope.
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if (value(middle) < 0.0) == rising { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fis::stress::{Random, Stress};
    use crate::fis::{all_roots, lattice, modified_level, warp};

    /// What one solver does on one density.
    #[derive(Clone, Copy, Debug, Default)]
    struct Row {
        kernels: usize,
        rootless: usize,
        several: usize,
        same: usize,
        missed: [usize; 2],
        furthest: [f64; 2],
        look_ups: [usize; 7],
    }

    /// The finest step of 12 bisections, halved as their result is.
    fn resolution(density: &Pyramid<f64>) -> f64 {
        density.top_level() as f64 / f64::from(1 << 13)
    }

    fn row(density: &Pyramid<f64>, count: u32, spoil: impl Fn(f64) -> f64) -> Row {
        let mut row = Row { kernels: count as usize, ..Row::default() };
        for index in 0..count {
            let warped = warp(density, lattice::point(index, count));
            let roots = all_roots(density, warped.centre, count, 1.0);
            let bracketed = bracketed_level(density, warped.centre, warped.texel, count, 1.0);
            let bisected = modified_level(density, warped.centre, count, 1.0, 12).level;
            row.look_ups[bracketed.look_ups as usize] += 1;
            row.several += usize::from(roots.len() > 1);
            let levels = [bisected, spoil(bracketed.level.level)];
            if roots.is_empty() {
                row.rootless += 1;
                assert!(!bracketed.root);
                assert_eq!(bracketed.level.level, 0.0);
                continue;
            }
            let nearest = |level: f64| {
                let distance = |root: &f64| (root - level).abs();
                let near = |a: &&f64, b: &&f64| distance(a).total_cmp(&distance(b));
                let root = *roots.iter().min_by(near).unwrap();
                (root, (root - level).abs())
            };
            for (solver, level) in levels.into_iter().enumerate() {
                let (_, distance) = nearest(level);
                if distance > resolution(density) {
                    row.missed[solver] += 1;
                } else {
                    row.furthest[solver] = row.furthest[solver].max(distance);
                }
            }
            row.same += usize::from(nearest(levels[0]).0 == nearest(levels[1]).0);
        }
        row
    }

    #[test]
    fn a_single_texel_has_one_level() {
        let density = Pyramid::of_levels(1, vec![vec![3.0]]).unwrap();
        for (count, scale) in [(1, 1.0), (16, 1.0), (1, 16.0)] {
            let found = bracketed_level::<f64>(&density, [0.5, 0.5], [0, 0], count, scale);
            assert_eq!((found.level.level, found.look_ups), (0.0, 0), "{count} {scale}");
        }
    }

    #[test]
    fn a_root_is_found_wherever_there_is_one() {
        for (name, stress) in Stress::ALL {
            if stress == Stress::Zero {
                continue;
            }
            for size in [64, 256, 512] {
                let density = stress.pyramid(size, 2016).unwrap();
                for count in [64, 1024] {
                    let row = row(&density, count, |level| level);
                    println!("{name:>12} {size} {count:>4}: {row:?}");
                    assert_eq!(row.missed[1], 0, "{name} {size} {count}: {row:?}");
                    assert_eq!(row.look_ups[6], 0);
                    assert!(row.furthest[1] < 1e-4, "{row:?}");
                    // Negative control: a level that is off by two of bisection's steps.
                    let step = 4.0 * resolution(&density);
                    let spoilt = self::row(&density, count, |level| level + step);
                    assert_eq!(spoilt.missed[1] > 0, row.rootless < row.kernels);
                }
            }
        }
    }

    /// Densities of 16 levels would not fit; the search alone does, over any answers.
    #[test]
    fn five_look_ups_are_enough_for_sixteen_levels() {
        let mut random = Random::new(3);
        let mut most = 0;
        for top in 1..16_usize {
            for _ in 0..20_000 {
                let answers: Vec<bool> = (0..top).map(|_| random.uniform() < 0.5).collect();
                let level = |random: &mut Random| (random.uniform() * top as f64) as usize;
                let crossing = (random.uniform() < 0.9).then(|| level(&mut random));
                // At an ample level the answer is given.
                let ample = crossing.map_or(0, |level| level + 1)
                    + (random.uniform() * (top as f64 + 1.0)) as usize;
                let ample = ample.min(top);
                let answer = |level: usize| level < ample && level < top && answers[level];
                let mut seen = Vec::new();
                let found = search(crossing, ample, top, 0.0, &mut |level| {
                    seen.push(level);
                    (answer(level), 0.0)
                });
                most = most.max(seen.len());
                assert!(seen.len() <= 5);
                if let Some([(less, _), (more, _)]) = found {
                    let bracketed = answer(less) && !answer(more);
                    assert!(
                        bracketed && less.abs_diff(more) == 1,
                        "{top} {crossing:?} {answers:?}"
                    );
                } else {
                    assert!(
                        !answer(0) || top == 0,
                        "{top} {crossing:?} {ample} {answers:?} {seen:?}"
                    );
                }
            }
        }
        assert_eq!(most, 5);
    }

    #[test]
    fn two_steps_are_enough_and_one_is_not() {
        let mut random = Random::new(4);
        let (mut worst, mut one) = ([0.0_f64; 2], 0.0_f64);
        for _ in 0..100_000 {
            let many = 10f64.powf(12.0 * random.uniform() - 8.0);
            let share = random.uniform().powi(3);
            for (side, (lower, upper)) in
                [(1.0 - share, 0.25 + many), (1.0 + many, 0.25 * (1.0 - share))]
                    .into_iter()
                    .enumerate()
            {
                let rising = side == 0;
                let expected = zero_between(lower, upper, rising);
                let error = |steps| (solve_between(lower, upper, rising, steps) - expected).abs();
                worst[side] = worst[side].max(error(2));
                one = one.max(error(1));
            }
        }
        println!("{worst:?}, after one step {one}");
        assert!(worst[0] < 5e-4 && worst[1] < 1e-6, "{worst:?}");
        assert!(one > 1e-2);
    }
}
