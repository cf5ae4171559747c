//! Time to an equal error: how much less time the best configuration takes to be as good as another.

use crate::frontier::document::Metric;
use crate::picture_error::PictureError;

/// A configuration with what it takes and how far it is off.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Candidate<T> {
    /// What it is.
    pub which: T,
    /// How long it takes, in milliseconds: of shading, if shading is what is compared.
    pub milliseconds: f64,
    /// Its error by one metric, at least 0.
    pub error: f64,
    /// How far noise may have moved that error.
    pub uncertainty: f64,
}

impl<T> Candidate<T> {
    /// A candidate by a metric of its picture.
    pub fn new(which: T, milliseconds: f64, picture: &PictureError, metric: Metric) -> Self {
        let uncertainty = picture.measured(metric).uncertainty;
        Self { which, milliseconds, error: picture.of(metric), uncertainty }
    }
}

/// The cheapest configuration that is at least as good as another.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Equal<'a, T> {
    /// The configuration.
    pub cheapest: &'a Candidate<T>,
    /// The other one's time over its time: how many times less it takes.
    pub ratio: f64,
    /// Whether its error is less by more than noise; if not, it may be more.
    pub clear: bool,
}

/// The cheapest of `candidates` whose error is at most that of `printed`, as a configuration with the papers' values;
/// none if no candidate is as good, or an error or a time of `printed` is not finite and above 0. `printed` itself may
/// be among them.
#[must_use]
pub fn time_to_equal<'a, T>(
    candidates: &'a [Candidate<T>],
    printed: &Candidate<T>,
) -> Option<Equal<'a, T>> {
    let sound = |one: &Candidate<T>| {
        one.error.is_finite() && one.milliseconds.is_finite() && one.milliseconds > 0.0
    };
    if !sound(printed) {
        return None;
    }
    let as_good = candidates.iter().filter(|one| sound(one) && one.error <= printed.error);
    let cheapest = as_good.min_by(|one, other| {
        one.milliseconds.total_cmp(&other.milliseconds).then(one.error.total_cmp(&other.error))
    })?;
    Some(Equal {
        cheapest,
        ratio: printed.milliseconds / cheapest.milliseconds,
        clear: printed.error - cheapest.error > printed.uncertainty.hypot(cheapest.uncertainty),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn candidate(which: &str, milliseconds: f64, error: f64) -> Candidate<&str> {
        Candidate { which, milliseconds, error, uncertainty: 0.0 }
    }

    #[test]
    fn the_cheapest_that_is_as_good_is_found() {
        let printed = candidate("printed", 8.0, 0.2);
        let all = [
            candidate("rough", 0.5, 0.3),
            candidate("few lights", 1.0, 0.2),
            candidate("many lights", 8.0, 0.01),
            candidate("broken", 0.1, f64::NAN),
            printed,
        ];
        let equal = time_to_equal(&all, &printed).unwrap();
        assert_eq!((equal.cheapest.which, equal.ratio, equal.clear), ("few lights", 8.0, false));
        let equal = time_to_equal(&all[2..], &printed).unwrap();
        assert_eq!((equal.ratio, equal.clear), (1.0, true));
        assert_eq!(time_to_equal(&all[..1], &printed), None, "nothing is as good");
        assert_eq!(time_to_equal(&all, &candidate("lost", 1.0, f64::INFINITY)), None);
        let picture = PictureError { relative_mse: -1e-4, ..PictureError::default() };
        assert_eq!(Candidate::new((), 1.0, &picture, Metric::RelativeMse).error, 0.0);
    }
}
