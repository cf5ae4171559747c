//! A function of the library, its oracle, its reference, and what is known of it.

use sglow_oracle::{Bounded, Real};
use sglow_renderer::function::Arguments;

use crate::input::{Argument, Kind};

/// The twelve components that a function reads, as numbers of the oracle.
pub type Numbers<R> = [R; 12];
/// The four components that it may write; those that it does not are 0.
pub type Results<R> = [R; 4];

/// How a function has to run as one of its components grows, the others held.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Monotone {
    /// The component.
    pub component: usize,
    /// Whether the first result grows with it, or falls.
    pub grows: bool,
}

/// A function of the library. Its name is the value on the axis `function`.
#[derive(Clone, Copy, Debug)]
pub struct Function {
    /// As on the axis `function`.
    pub name: &'static str,
    /// What its results are called, as many as there are.
    pub results: &'static [&'static str],
    /// What it takes.
    pub arguments: &'static [Argument],
    /// The same formula in f64.
    pub oracle: fn(Numbers<f64>) -> Results<f64>,
    /// The same formula with the error that GPU languages allow.
    pub bounded: fn(Numbers<Bounded>) -> Results<Bounded>,
    /// What the formula approximates or equals, by quadrature or by another exact way; not cheap.
    pub reference: Option<fn(Numbers<f64>) -> Results<f64>>,
    /// Whether the reference takes milliseconds: then it is known of few inputs.
    pub slow_reference: bool,
    /// The largest value that each result can have at these arguments: what errors are seen against.
    pub peak: fn(Numbers<f64>) -> Results<f64>,
    /// The share of the peak below which an error is nothing whatever the grant says: 0 for nearly all.
    pub floor: f64,
    /// Whether its results can never be below 0.
    pub never_negative: bool,
    /// How it has to run.
    pub monotone: Option<Monotone>,
    /// Whether it is the paper's literal form, kept to show what stability buys.
    pub literal: bool,
}

impl Function {
    /// The identifier of its variant.
    #[must_use]
    pub fn id(&self) -> String {
        format!("function-{}", self.name)
    }

    /// The components that it reads.
    #[must_use]
    pub fn components(&self) -> Vec<usize> {
        let of = |argument: &Argument| argument.at..argument.at + argument.kind.width();
        self.arguments.iter().flat_map(of).collect()
    }

    /// Whether it is a function of a cosine (component 0) and a sharpness (component 3) alone.
    #[must_use]
    pub fn is_of_cosine_and_sharpness(&self) -> bool {
        matches!(
            self.arguments,
            [Argument { kind: Kind::Sharpness, at: 3 }, Argument { kind: Kind::Cosine, at: 0 }]
        )
    }

    /// Whether a component is a cosine or a length, and so at most 1.
    #[must_use]
    pub fn is_bounded_by_one(&self, component: usize) -> bool {
        let bounded = [Kind::Cosine, Kind::UpperCosine, Kind::Alpha, Kind::MeanLength];
        self.arguments.iter().any(|one| {
            bounded.contains(&one.kind) && (one.at..one.at + one.kind.width()).contains(&component)
        })
    }

    /// Its arguments as the oracle takes them.
    #[must_use]
    pub fn exact(arguments: &Arguments) -> Numbers<f64> {
        arguments.map(f64::from)
    }

    /// Its arguments as they lie in a buffer.
    #[must_use]
    pub fn buffered(arguments: &Arguments) -> Numbers<Bounded> {
        arguments.map(Bounded::exact)
    }
}

/// Three components as a vector.
pub(crate) fn vector<R: Real>(numbers: &Numbers<R>, at: usize) -> sglow_oracle::Vector3<R> {
    sglow_oracle::Vector3::new(numbers[at], numbers[at + 1], numbers[at + 2])
}

/// One result.
pub(crate) fn one<R: Real>(value: R) -> Results<R> {
    [value, R::zero(), R::zero(), R::zero()]
}

/// The peak of a function that is at most 1.
pub(crate) fn unit(_: Numbers<f64>) -> Results<f64> {
    [1.0; 4]
}
