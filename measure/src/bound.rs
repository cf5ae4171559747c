//! Every bound that the stability run holds, with its reason. Nothing else decides whether it passes.

use sglow_oracle::brdf::albedo::WHITE_ERROR;
use sglow_results::stability::halves::HalfCheck;
use sglow_results::stability::held::Held;
use sglow_results::stability::quantity::{Quantity, Verdict};
use sglow_shaders::Kernel;

use crate::function::Function;

/// A promise about functions.
#[derive(Clone, Copy, Debug)]
pub struct Bound {
    /// The functions it is about: all that are not literal if empty.
    pub functions: &'static [&'static str],
    /// The regimes it holds in: all if empty.
    pub regimes: &'static [&'static str],
    /// What is held.
    pub quantity: Quantity,
    /// The most that it may be.
    pub at_most: f64,
    /// Why this much and no more.
    pub reason: &'static str,
}

/// Sharpness from 1e-3 to 1e6: the range of virtual lights from a whole wall to a mirror.
const USUAL: &[&str] = &["soft", "medium", "sharp"];

/// The bounds of functions.
pub const FUNCTIONS: &[Bound] = &[
    Bound {
        functions: &[],
        regimes: &[],
        quantity: Quantity::NotFinite,
        at_most: 0.0,
        reason: "finite input in range gives finite output, whatever the driver makes of the arithmetic",
    },
    Bound {
        functions: &[],
        regimes: &[],
        quantity: Quantity::Negative,
        at_most: 0.0,
        reason: "light is not negative; functions that can be negative have no such bound",
    },
    Bound {
        functions: &[],
        regimes: &[],
        quantity: Quantity::RoundingShare,
        at_most: 1.0,
        reason: "a device that keeps to the language keeps within the derived tolerance",
    },
    Bound {
        functions: &[],
        regimes: &[],
        quantity: Quantity::ArithmeticShare,
        at_most: 1.0,
        reason: "so does every order of operations, contraction, flushing and granted error: \
                 the function does not depend on them",
    },
    Bound {
        functions: &[],
        regimes: &[],
        quantity: Quantity::NotMonotone,
        at_most: 0.0,
        reason: "no step the wrong way beyond what both results may be off",
    },
    Bound {
        functions: &[],
        regimes: USUAL,
        quantity: Quantity::WithoutPromise,
        at_most: 0.01,
        reason: "a tolerance without end holds nothing: only where directions are parallel to rounding may one be",
    },
    Bound {
        functions: &["sg_product", "sg_product_moderate"],
        regimes: USUAL,
        quantity: Quantity::RoundingOverPeak,
        at_most: 1e-5,
        reason: "the exponent of a product above e^-20 is right to 1e-5, so that its amplitude is to 2e-4",
    },
    Bound {
        functions: &["sg_cosine_fitted", "cosine_fitted_mean"],
        regimes: USUAL,
        quantity: Quantity::TotalOverPeak,
        at_most: 6.2e-5,
        reason: "5.8e-5 is the fit's own largest error over sharpness 0.01 to 1e5, and 6e-7 roundings; \
                 a twenty-fifth of the best closed form that was published",
    },
    Bound {
        functions: &["sg_cosine_fitted_fine", "cosine_fitted_fine_mean"],
        regimes: USUAL,
        quantity: Quantity::TotalOverPeak,
        at_most: 1.7e-5,
        reason: "1.6e-5 is the fit's own largest error, and 6e-7 roundings; \
                 a ninetieth of the best closed form that was published",
    },
    Bound {
        functions: &["sg_cosine_quartic", "cosine_quartic_mean"],
        regimes: USUAL,
        quantity: Quantity::TotalOverPeak,
        at_most: 1.6e-3,
        reason: "1.45e-3 is the fit's own largest error over sharpness 0.01 to 1e5, 1.57e-3 between its samples, and \
                 roundings; as much as the best closed form that was published",
    },
    Bound {
        functions: &["sg_cosine_erf"],
        regimes: USUAL,
        quantity: Quantity::TotalOverPeak,
        at_most: 1.6e-3,
        reason: "what the published form was measured to have in f64, 1.55e-3, and roundings",
    },
    Bound {
        functions: &["sg_cosine_logistic"],
        regimes: USUAL,
        quantity: Quantity::TotalOverPeak,
        at_most: 8.8e-3,
        reason: "what the published form was measured to have in f64, 8.73e-3, and roundings",
    },
    Bound {
        functions: &["sg_hemisphere_integral"],
        regimes: USUAL,
        quantity: Quantity::TotalOverPeak,
        at_most: 5e-3,
        reason: "what the published form was measured to have in f64, 4.92e-3, and roundings",
    },
    Bound {
        functions: &["vmf_sharpness_exact"],
        regimes: USUAL,
        quantity: Quantity::TotalOverPeak,
        at_most: 1e-5,
        reason: "4e-7 is the step's own error, 4e-6 the worst that f32 is granted; the rest is that of the inputs",
    },
    Bound {
        functions: &["vmf_mean_length_exact", "vmf_mean_length_complement"],
        regimes: &["tiny", "soft", "medium", "sharp"],
        quantity: Quantity::TotalOverPeak,
        at_most: 2e-6,
        reason: "exact but for roundings: sixteen of them",
    },
    Bound {
        functions: &["erf", "erfc", "erfc_scaled", "erfc_integral_scaled", "expm1", "expm1_over_x"],
        regimes: &[],
        quantity: Quantity::ModelOverPeak,
        at_most: 1e-14,
        reason: "the oracle's own are compared with quadrature and series: 64 roundings of f64",
    },
    Bound {
        functions: &["g1_smith_beckmann"],
        regimes: &[],
        quantity: Quantity::ModelOverPeak,
        at_most: 3.5e-3,
        reason: "what Walter et al. promise of their rational function",
    },
    Bound {
        functions: &["v_smith_beckmann"],
        regimes: &[],
        quantity: Quantity::ModelOverPeak,
        at_most: 7.1e-3,
        reason: "two of them, each off by up to 3.5e-3",
    },
    Bound {
        functions: &["ggx_albedo"],
        regimes: &[],
        quantity: Quantity::ModelOverPeak,
        at_most: WHITE_ERROR,
        reason: "the fit's own error (oracle/src/brdf/albedo.rs); of a dielectric and of what fades by their peaks",
    },
    Bound {
        functions: &["sg_integral", "sg_upper_cosine_integral", "sg_lower_cosine_integral"],
        regimes: &[],
        quantity: Quantity::ModelOverPeak,
        at_most: 1e-12,
        reason: "these closed forms are exact, and the quadrature is to 1e-13",
    },
];

/// How far the mean of a picture may be from what it should be in an extreme case of the pipeline. That everything is
/// finite and not negative is required in each.
#[derive(Clone, Copy, Debug)]
pub struct Extreme {
    /// The case.
    pub name: &'static str,
    /// As a share of what it should be; nothing where nobody knows what that is.
    pub at_most: Option<f64>,
    /// Why this much and no more.
    pub reason: &'static str,
    /// Whether the previous kernels are held to it too.
    pub previous_too: bool,
}

impl Extreme {
    /// What a kernel is held to.
    #[must_use]
    pub fn of(&self, kernel: Kernel) -> Option<f64> {
        self.at_most.filter(|_| self.previous_too || kernel == Kernel::Modified)
    }
}

/// The share of the peak below which an error of `ndf_filtered_reflection` is nothing, whatever the grant says: half an
/// ULP of the peak. Light from behind the view leaves 1e-20 of it, whose digits hang on the order in which the half
/// vector, itself a rounding error, is projected. Added to a pixel it is lost.
pub const FILTERED_FLOOR: f64 = 1.0 / 16_777_216.0;

/// The most that the fitted cosine integral may take of the time of the published one it replaces.
pub const FITTED_OVER_ERF: f64 = 1.3;

/// The bounds of extreme cases.
pub const EXTREMES: &[Extreme] = &[
    Extreme {
        name: "far away",
        at_most: Some(0.02),
        reason: "compared with the scene whose vertices are rounded likewise, to 1/16: what is left is the rounding of \
                 each pixel's and each light's position by up to 1/32, a hundredth of half the scene's width, and light \
                 falls with the square of the distance",
        previous_too: true,
    },
    Extreme {
        name: "far with an origin",
        at_most: Some(1e-5),
        reason: "compared with the scene whose vertices are rounded likewise: the origin is subtracted exactly, and what is \
                 left are roundings of positions that are relative to another point nearby; but in the world, texels at \
                 equal distances of two clusters go to either",
        previous_too: true,
    },
    Extreme {
        name: "dark",
        at_most: Some(1e-4),
        reason: "reflection is linear; what is lost are subnormal numbers, all below 1e-18 of the picture's mean",
        previous_too: true,
    },
    Extreme {
        name: "bright",
        at_most: Some(1e-4),
        reason: "reflection is linear; what is left are roundings",
        previous_too: true,
    },
    Extreme {
        name: "mirrors",
        at_most: None,
        reason: "lobes as sharp as they can be; what such a picture should be only the path tracer knows",
        previous_too: true,
    },
    Extreme {
        name: "one light",
        at_most: None,
        reason: "one lobe cannot be right, but it is finite and not negative",
        previous_too: true,
    },
    Extreme {
        name: "65536 lights",
        at_most: None,
        reason: "kernels of one texel: the floor of the variance is reached",
        previous_too: true,
    },
    Extreme {
        name: "no light arrives",
        at_most: Some(0.0),
        reason: "nothing reflects nothing",
        previous_too: true,
    },
    Extreme {
        name: "lights at the shading points",
        at_most: None,
        reason: "every pixel has a light at distance 0, where direction and Gaussian of its position degenerate",
        previous_too: true,
    },
    Extreme {
        name: "opposite lobes",
        at_most: None,
        reason: "the emitted lobe points away from the receiver, and the receiver's normal away from the light",
        previous_too: true,
    },
    Extreme {
        name: "density",
        at_most: Some(0.03),
        reason: "Eq. (5) keeps the total to a few percent on any density; `previous` loses or invents power on all but \
                 smooth ones, which is what it is shown for",
        previous_too: false,
    },
];

/// The bound of an extreme case. One that is not in the table may not be off at all.
#[must_use]
pub fn extreme(name: &str) -> Extreme {
    let none =
        Extreme { name: "", at_most: Some(0.0), reason: "no bound is known", previous_too: true };
    EXTREMES.iter().copied().find(|bound| bound.name == name).unwrap_or(none)
}

/// RMSE of the indirect light in f16 over its mean in f32.
pub const HALF_PICTURE: HalfCheck = HalfCheck {
    name: "picture, RMSE over mean",
    value: f64::NAN,
    at_most: 4.9e-4,
    reason: "half an ULP of a half is 2^-11; errors of many lights are independent and cancel in part",
};
/// The largest relative error of a light's power.
pub const HALF_POWER: HalfCheck = HalfCheck {
    name: "power of a lobe, relative",
    value: f64::NAN,
    at_most: 3.9e-3,
    reason: "each of up to eight mips is rounded by 2^-11",
};
/// The largest error of the mean length of a light's directions.
pub const HALF_MEAN_LENGTH: HalfCheck = HalfCheck {
    name: "mean length of a light's directions",
    value: f64::NAN,
    at_most: 2.2e-3,
    reason: "direction and weight are each off by 2^-11 times the root of eight independent mips, three, and the two are \
             independent",
};
/// Numbers that are not finite.
pub const HALF_NOT_FINITE: HalfCheck = HalfCheck {
    name: "numbers that are not finite",
    value: f64::NAN,
    at_most: 0.0,
    reason: "powers are stored in a unit that the brightest photon fits",
};

/// Holds every bound that is about a function.
///
/// A bound whose quantity was not measured in any of its regimes fails: an empty comparison is no comparison. Only that
/// a function is monotone, or never negative, is required of those alone that say so.
#[must_use]
pub fn judge(function: &Function, held: &[Held]) -> Vec<Verdict> {
    FUNCTIONS.iter().filter_map(|bound| verdict(bound, function, held)).collect()
}

fn verdict(bound: &Bound, function: &Function, held: &[Held]) -> Option<Verdict> {
    let general = bound.functions.is_empty();
    let about = if general { !function.literal } else { bound.functions.contains(&function.name) };
    let applies = match bound.quantity {
        Quantity::Negative => function.never_negative,
        Quantity::NotMonotone => function.monotone.is_some(),
        _ => true,
    };
    if !about || !applies {
        return None;
    }
    let measured = held
        .iter()
        .filter(|held| bound.regimes.is_empty() || bound.regimes.contains(&held.regime))
        .filter_map(|held| Some((held.regime, bound.quantity.of(held)?)));
    let (regime, value) = measured
        .reduce(|worst, one| if one.1 > worst.1 || one.1.is_nan() { one } else { worst })
        .unwrap_or(("none", f64::NAN));
    Some(Verdict {
        function: function.name,
        regime,
        quantity: bound.quantity,
        value,
        at_most: bound.at_most,
        holds: value <= bound.at_most,
        reason: bound.reason,
    })
}
