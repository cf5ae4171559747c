//! Arguments of functions: random ones over every regime, and those that are meant to break something.

use sglow_oracle::fis::stress::Random;
use sglow_renderer::function::Arguments;
use sglow_results::stability::regime::{REGIMES, Regime};

/// What an argument is, and with it how it is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// A sharpness, at least 0, of the regime's magnitude.
    Sharpness,
    /// A sharpness of any magnitude, so that ratios reach 1e+-12 and beyond.
    OtherSharpness,
    /// A power or a distance in a scene's units, of the regime's magnitude as far as that is 0 or 1e-20 to 1e15.
    Magnitude,
    /// A positional variance, 1e-12 to 1e30, of any magnitude.
    Variance,
    /// Three components: a unit vector.
    Axis,
    /// Three components: a unit vector, often close to the first axis, or opposite, or across.
    OtherAxis,
    /// Three components: a unit vector of any of these kinds, in the hemisphere of the first axis.
    FacingAxis,
    /// The cosine of an angle, -1 to 1, often at the horizon or at a pole.
    Cosine,
    /// The cosine of an angle above the horizon, from 1e-3 to 1.
    UpperCosine,
    /// Roughness alpha, 1e-4 to 1.
    Alpha,
    /// Any number of the regime's magnitude, of either sign.
    Number,
    /// Any number up to 88, beyond which an exponential overflows.
    Exponent,
    /// Two components: a mean length from 0 to 1 and its complement to 1, both rounded from the same number.
    MeanLength,
}

impl Kind {
    /// How many components it has.
    #[must_use]
    pub const fn width(self) -> usize {
        match self {
            Self::Axis | Self::OtherAxis | Self::FacingAxis => 3,
            Self::MeanLength => 2,
            _ => 1,
        }
    }
}

/// An argument and the component that it starts at, of the twelve that a function is handed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Argument {
    /// What it is.
    pub kind: Kind,
    /// Its first component.
    pub at: usize,
}

/// Shorthand for a table of functions.
#[must_use]
pub const fn argument(kind: Kind, at: usize) -> Argument {
    Argument { kind, at }
}

/// Magnitudes that the design names, and those at which common shortcuts give out.
const MAGNITUDES: [f32; 28] = [
    0.0,
    1e-45,
    1e-38,
    f32::MIN_POSITIVE,
    1e-30,
    1e-20,
    5.960_464_5e-8,
    1e-4,
    3.452_669_8e-4,
    0.01,
    0.25,
    0.5,
    1.0,
    2.0,
    4.0,
    8.0,
    10.0,
    16.0,
    88.0,
    88.722_84,
    103.972_08,
    1e2,
    1e5,
    1e9,
    2.199_023_3e12,
    1e19,
    1.8e19,
    f32::MAX,
];

/// Draws the arguments of one function.
#[derive(Debug)]
pub struct Inputs<'a> {
    arguments: &'a [Argument],
    /// Literals of the function's own text: where it branches, among others.
    literals: Vec<f32>,
    random: Random,
}

#[expect(clippy::cast_possible_truncation, reason = "inputs are f32")]
fn rounded(value: f64) -> f32 {
    value.clamp(-f64::from(f32::MAX), f64::from(f32::MAX)) as f32
}

impl<'a> Inputs<'a> {
    /// Inputs for a function with these arguments, whose text has these literals.
    #[must_use]
    pub fn new(arguments: &'a [Argument], literals: Vec<f32>, seed: u64) -> Self {
        Self { arguments, literals, random: Random::new(seed) }
    }

    /// The next arguments of a regime.
    pub fn draw(&mut self, regime: &Regime) -> Arguments {
        let mut drawn = [0.0; 12];
        let mut axis = [0.0, 0.0, 1.0];
        for argument in self.arguments {
            // By convention of the table the sharpness that other arguments are drawn around stands here, and is drawn
            // before them.
            let sharpness = drawn[3];
            let place = &mut drawn[argument.at..argument.at + argument.kind.width()];
            match argument.kind {
                Kind::Sharpness => place[0] = self.magnitude(regime).abs(),
                Kind::OtherSharpness => place[0] = self.other_magnitude(regime),
                Kind::Number => {
                    let sign = if self.random.uniform() < 0.5 { -1.0 } else { 1.0 };
                    place[0] = sign * self.magnitude(regime);
                }
                Kind::Magnitude => {
                    let magnitude = self.magnitude(regime).min(1e15);
                    place[0] = if magnitude < 1e-20 { 0.0 } else { magnitude };
                }
                Kind::Variance => {
                    let (low, high) = (1e-12_f64.ln(), 1e30_f64.ln());
                    place[0] = rounded((low + (high - low) * self.random.uniform()).exp());
                }
                Kind::Exponent => {
                    let magnitude = self.magnitude(regime);
                    let positive = magnitude <= 88.0 && self.random.uniform() < 0.5;
                    place[0] = if positive { magnitude } else { -magnitude };
                }
                Kind::Axis => {
                    axis = self.axis();
                    place.copy_from_slice(&axis);
                }
                Kind::OtherAxis => {
                    let spread = self.spread(sharpness);
                    place.copy_from_slice(&self.other_axis(axis, spread));
                }
                Kind::FacingAxis => {
                    let spread = self.spread(sharpness);
                    let other = self.other_axis(axis, spread);
                    let cosine: f64 =
                        axis.iter().zip(other).map(|(a, b)| f64::from(*a) * f64::from(b)).sum();
                    place.copy_from_slice(
                        &other.map(|part| if cosine < 0.0 { -part } else { part }),
                    );
                }
                Kind::Cosine => place[0] = self.cosine(sharpness),
                Kind::UpperCosine => place[0] = self.cosine(sharpness).abs().max(1e-3),
                Kind::Alpha => place[0] = self.alpha(),
                Kind::MeanLength => place.copy_from_slice(&self.mean_length(regime)),
            }
        }
        drawn
    }

    fn pick<T: Copy>(&mut self, from: &[T]) -> T {
        from[(self.random.uniform() * from.len() as f64) as usize % from.len()]
    }

    /// Log-uniform in the regime; adversarial: something special, or up to three ULP from it.
    fn magnitude(&mut self, regime: &Regime) -> f32 {
        if regime.is_adversarial() {
            return self.special();
        }
        let (low, high) = (regime.low.ln(), regime.high.ln());
        rounded((low + (high - low) * self.random.uniform()).exp())
    }

    fn special(&mut self) -> f32 {
        let literal = !self.literals.is_empty() && self.random.uniform() < 0.5;
        let mut value = if literal {
            let literals = std::mem::take(&mut self.literals);
            let value = self.pick(&literals).abs();
            self.literals = literals;
            // A literal may be what a multiple of the argument is compared with.
            value * self.pick(&[1.0, 0.5, 2.0])
        } else {
            self.pick(&MAGNITUDES)
        };
        for _ in 0..self.random.bits() % 4 {
            value = if self.random.uniform() < 0.5 { value.next_up() } else { value.next_down() };
        }
        if value.is_finite() { value.abs() } else { f32::MAX }
    }

    fn other_magnitude(&mut self, regime: &Regime) -> f32 {
        let other = if regime.is_adversarial() || self.random.uniform() < 0.1 {
            REGIMES[REGIMES.len() - 1]
        } else if self.random.uniform() < 0.5 {
            *regime
        } else {
            self.pick(&REGIMES[..REGIMES.len() - 1])
        };
        self.magnitude(&other)
    }

    /// Uniform on the sphere, or one of its poles.
    fn axis(&mut self) -> [f32; 3] {
        if self.random.uniform() < 0.02 {
            let mut axis = [0.0; 3];
            axis[self.random.bits() as usize % 3] = self.pick(&[-1.0, 1.0]);
            return axis;
        }
        let z = 2.0 * self.random.uniform() - 1.0;
        let (sine, cosine) = (2.0 * core::f64::consts::PI * self.random.uniform()).sin_cos();
        let radius = (1.0 - z * z).max(0.0).sqrt();
        [rounded(radius * cosine), rounded(radius * sine), rounded(z)]
    }

    /// How far another axis lies: within a lobe of this sharpness, or at any distance down to 1e-6, where the lobes of
    /// smooth surfaces have their shape.
    fn spread(&mut self, sharpness: f32) -> f64 {
        if self.random.uniform() < 0.5 {
            return 1.0 / (1.0 + f64::from(sharpness).max(0.0)).sqrt();
        }
        (1e-6_f64.ln() * self.random.uniform()).exp()
    }

    /// Equal, opposite, across, one ULP apart, at a distance drawn around `spread`, or anywhere.
    fn other_axis(&mut self, [x, y, z]: [f32; 3], spread: f64) -> [f32; 3] {
        match self.random.bits() % 16 {
            0 => [x, y, z],
            1 => [-x, -y, -z],
            2 => {
                let [x, y] = [x, y].map(f64::from);
                normalized([-y, x, 0.0], [1.0, 0.0, 0.0])
            }
            3 => [x.next_up(), y, z],
            4 => [-x, -y.next_down(), -z],
            5..=11 => {
                let distance = spread * (4.0 * self.random.uniform());
                let near: [f64; 3] =
                    [x, y, z].map(|part| f64::from(part) + distance * self.random.normal());
                normalized(near, [x, y, z])
            }
            _ => self.axis(),
        }
    }

    fn cosine(&mut self, sharpness: f32) -> f32 {
        let width = 1.0 / (1.0 + f64::from(sharpness).max(0.0)).sqrt();
        match self.random.bits() % 16 {
            0 => self.pick(&[-1.0, 1.0, 0.0, -0.0]),
            1 => self.pick(&[1e-45, -1e-45, 1e-38, -1e-38, 1e-8, -1e-8]),
            2 => 1.0_f32.next_down() * self.pick(&[-1.0, 1.0]),
            3..=8 => rounded((8.0 * width * (2.0 * self.random.uniform() - 1.0)).clamp(-1.0, 1.0)),
            // Uniform in angle, as surfaces are.
            _ => rounded((core::f64::consts::PI * self.random.uniform()).cos()),
        }
    }

    fn alpha(&mut self) -> f32 {
        match self.random.bits() % 16 {
            0 => self.pick(&[1e-4, 0.01, 1.0, 1.0_f32.next_down(), 0.5]),
            1..=5 => rounded((1e-4_f64.ln() * self.random.uniform()).exp()),
            _ => rounded(0.01 + 0.99 * self.random.uniform()),
        }
    }

    /// That of a lobe of the regime's sharpness, or something special.
    fn mean_length(&mut self, regime: &Regime) -> [f32; 2] {
        // Toksvig's: any lobe will do, and both numbers keep all their digits.
        let sharpness = f64::from(self.magnitude(regime));
        [rounded(sharpness / (sharpness + 1.0)), rounded(1.0 / (sharpness + 1.0))]
    }
}

fn normalized(vector: [f64; 3], fallback: [f32; 3]) -> [f32; 3] {
    let length = vector.iter().map(|part| part * part).sum::<f64>().sqrt();
    if length > 0.0 { vector.map(|part| rounded(part / length)) } else { fallback }
}
