//! Exact facts, held on the device: `oracle/src/sg/identities.rs` has them in f64, where they came from.

use sglow_oracle::fis::stress::Random;
use sglow_oracle::math::bessel_i_scaled;
use sglow_oracle::quadrature::gauss_legendre;
use sglow_oracle::sg::{self, Cosine};
use sglow_renderer::function::{Arguments, Function};

use crate::common::{gpu, whole_space};

/// A function of the library on the device.
fn on_device(name: &str, arguments: &[Arguments]) -> Vec<[f32; 4]> {
    let function = Function::new(gpu(), whole_space(), &format!("function-{name}")).unwrap();
    function.evaluate(arguments).unwrap()
}

/// A cosine and a sharpness, where functions of both expect them.
fn at(cosine: f64, sharpness: f64) -> Arguments {
    let mut arguments = [0.0; 12];
    (arguments[0], arguments[3]) = (cosine as f32, sharpness as f32);
    arguments
}

const FORMS: [(&str, Cosine); 7] = [
    ("constant", Cosine::Constant),
    ("gaussian", Cosine::Gaussian),
    ("logistic", Cosine::Logistic),
    ("erf", Cosine::Erf),
    ("quartic", Cosine::Quartic),
    ("fitted", Cosine::Fitted),
    ("fitted_fine", Cosine::FittedFine),
];

/// Sharpnesses from 1e-3 to 1e6.
fn sharpnesses() -> impl Iterator<Item = f64> {
    (0..91).map(|step| 10.0_f64.powf(-3.0 + f64::from(step) / 10.0))
}

/// The largest residual of an identity over A_u, from the values that a form has at the arguments of each sharpness.
fn residual(
    form: &str,
    arguments: impl Fn(f64) -> Vec<Arguments>,
    identity: impl Fn(f64, &[Arguments], &[f64]) -> f64,
) -> f64 {
    let sharpnesses: Vec<f64> = sharpnesses().map(|value| f64::from(value as f32)).collect();
    let all: Vec<Vec<Arguments>> = sharpnesses.iter().map(|value| arguments(*value)).collect();
    let values = on_device(&format!("sg_cosine_{form}"), &all.concat());
    let mut values = values.iter().map(|result| f64::from(result[0]));
    let residuals = sharpnesses.iter().zip(&all).map(|(&sharpness, arguments)| {
        let values: Vec<f64> = values.by_ref().take(arguments.len()).collect();
        identity(sharpness, arguments, &values).abs() / sg::upper_cosine_integral(sharpness)
    });
    residuals.fold(0.0, f64::max)
}

/// Roundings of a handful of operations and of an exponential, over A_u.
const ROUNDING: f64 = 2e-6;

#[test]
fn the_odd_part_is_exact() {
    let both = |sharpness: f64| {
        let cosines = (0..=64).map(|step| f64::from(step) / 64.0);
        cosines.flat_map(|cosine| [at(cosine, sharpness), at(-cosine, sharpness)]).collect()
    };
    let odd = |sharpness: f64, arguments: &[Arguments], values: &[f64]| {
        let difference =
            sg::upper_cosine_integral(sharpness) - sg::lower_cosine_integral(sharpness);
        let residuals = arguments.chunks(2).zip(values.chunks(2)).map(|(arguments, values)| {
            (values[0] - values[1] - difference * f64::from(arguments[0][0])).abs()
        });
        residuals.fold(0.0, f64::max)
    };
    // Forms that are built on it keep it; the others are the negative control.
    for (form, keeps) in [
        ("logistic", true),
        ("erf", true),
        ("fitted", true),
        ("fitted_fine", true),
        ("quartic", false),
        ("constant", false),
        ("gaussian", false),
    ] {
        let found = residual(form, both, odd);
        println!("odd part of {form}: {found:.1e}");
        assert_eq!(found < ROUNDING, keeps, "{form}: {found}");
    }
}

#[test]
fn horizon_ends_and_energy_are_within_the_error_of_each_form() {
    // What `cargo xtask stability` holds each form to.
    let error = |form: Cosine| match form {
        Cosine::Constant => 3.0,
        Cosine::Gaussian => 0.15,
        Cosine::Logistic => 8.8e-3,
        Cosine::Erf | Cosine::Quartic => 1.6e-3,
        Cosine::Fitted => 6.2e-5,
        Cosine::FittedFine => 1.7e-5,
    };
    for (name, form) in FORMS {
        let allowed = error(form) + ROUNDING;
        // I(0) = 2 pi exp(-l) I_1(l)/l.
        let horizon = residual(
            name,
            |sharpness| vec![at(0.0, sharpness)],
            |sharpness, _, values| {
                let exact = 2.0 * core::f64::consts::PI * bessel_i_scaled(1, sharpness) / sharpness;
                values[0] - exact
            },
        );
        // I(1) = A_u and I(-1) = A_b.
        let ends = residual(
            name,
            |sharpness| vec![at(1.0, sharpness), at(-1.0, sharpness)],
            |sharpness, _, values| {
                let upper = values[0] - sg::upper_cosine_integral(sharpness);
                let lower = values[1] - sg::lower_cosine_integral(sharpness);
                upper.abs().max(lower.abs())
            },
        );
        // The integral over all cosines is A/2, to the error of each, twice the width of the range.
        let rule = gauss_legendre(24);
        let panels = |sharpness: f64| {
            let width = (1.0 / (1.0 + sharpness)).sqrt().min(0.25);
            let mut edges = vec![0.0, width, 2.0 * width, 4.0 * width, 8.0 * width];
            edges.retain(|edge| *edge < 1.0);
            edges.push(1.0);
            let up: Vec<(f64, f64)> = edges.windows(2).map(|pair| (pair[0], pair[1])).collect();
            up.iter().map(|(low, high)| (-high, -low)).chain(up.clone()).collect::<Vec<_>>()
        };
        let nodes = |sharpness: f64| -> Vec<(f64, f64)> {
            let panel = |(low, high): (f64, f64)| {
                let half = 0.5 * (high - low);
                rule.iter().map(move |(node, weight)| (low + half * (1.0 + node), half * weight))
            };
            panels(sharpness).into_iter().flat_map(panel).collect()
        };
        let energy = residual(
            name,
            |sharpness| nodes(sharpness).into_iter().map(|(z, _)| at(z, sharpness)).collect(),
            |sharpness, _, values| {
                let terms = nodes(sharpness).into_iter().zip(values);
                terms.map(|((_, weight), value)| weight * value).sum::<f64>()
                    - 0.5 * sg::integral(sharpness)
            },
        );
        println!("{name}: horizon {horizon:.1e}, ends {ends:.1e}, energy {energy:.1e}");
        assert!(horizon <= allowed && ends <= allowed, "{name}: {horizon} {ends}");
        assert!(energy <= 2.0 * allowed, "{name}: {energy}");
        if form == Cosine::Constant {
            // The negative control: a form that is only good for sharp lobes fails what the others are held to.
            assert!(ends > 0.15, "{ends}");
        }
    }
}

#[test]
fn fitted_forms_grow_with_the_cosine_and_are_never_negative() {
    const STEPS: usize = 2001;
    let grid = |sharpness: f64| -> Vec<Arguments> {
        (0..STEPS).map(|step| at(step as f64 / 1000.0 - 1.0, sharpness)).collect()
    };
    let arguments: Vec<Arguments> =
        sharpnesses().chain([0.0, 1e-30, 1e9, f64::from(f32::MAX)]).flat_map(grid).collect();
    let wrong = |name: &str| -> (usize, usize) {
        let values = on_device(name, &arguments);
        let curves = values.chunks(STEPS);
        let steps =
            curves.flat_map(|curve| curve.windows(2)).filter(|pair| pair[1][0] < pair[0][0]);
        let bad = values.iter().filter(|value| !(value[0] >= 0.0 && value[0].is_finite()));
        (steps.count(), bad.count())
    };
    assert_eq!(wrong("sg_cosine_quartic"), (0, 0));
    assert_eq!(wrong("sg_cosine_fitted"), (0, 0));
    assert_eq!(wrong("sg_cosine_fitted_fine"), (0, 0));
    // The negative control: the literal form is neither.
    let (steps, bad) = wrong("sg_cosine_logistic_literal");
    assert!(steps > 100 && bad > 1000, "{steps} {bad}");
}

#[test]
fn a_product_is_the_same_from_both_sides() {
    let mut random = Random::new(11);
    let mut pairs = Vec::new();
    for _ in 0..4096 {
        let mut axis = || {
            let parts = [random.normal(), random.normal(), random.normal()];
            let length = parts.iter().map(|part| part * part).sum::<f64>().sqrt();
            parts.map(|part| (part / length) as f32)
        };
        let ([ax, ay, az], [bx, by, bz]) = (axis(), axis());
        let mut sharpness = || 10.0_f64.powf(9.0 * random.uniform() - 3.0) as f32;
        let (a, b) = (sharpness(), sharpness());
        pairs.push([ax, ay, az, a, bx, by, bz, b, 0.0, 0.0, 0.0, 0.0]);
        pairs.push([bx, by, bz, b, ax, ay, az, a, 0.0, 0.0, 0.0, 0.0]);
    }
    let asymmetry = |name: &str| {
        let results = on_device(name, &pairs);
        let each = results.chunks(2).map(|pair| {
            // Of both, the sharpness and the exponent.
            (0..2)
                .map(|part| {
                    let [one, other] = [pair[0][part], pair[1][part]].map(f64::from);
                    (one - other).abs() / one.abs().max(f64::MIN_POSITIVE)
                })
                .fold(0.0, f64::max)
        });
        each.fold(0.0, f64::max)
    };
    assert!(asymmetry("sg_product") < 2e-6, "{}", asymmetry("sg_product"));
    // The negative control: the literal exponent l3 - l1 - l2 depends on which is subtracted first.
    assert!(asymmetry("sg_product_literal") > 1e-3, "{}", asymmetry("sg_product_literal"));
}

#[test]
fn facets_cover_the_plane_once() {
    // The integral of D(h) n.h over the hemisphere is 1: of GGX and of Beckmann, in u = sin^2, where h.n dw = pi du.
    for name in ["d_ggx", "d_beckmann"] {
        for alpha in [0.05_f32, 0.2, 0.5, 1.0] {
            let mut nodes = Vec::new();
            let mut low = 0.0_f64;
            while low < 1.0 {
                let high = if low == 0.0 { f64::from(alpha * alpha) / 64.0 } else { 2.0 * low };
                let (high, half) = (high.min(1.0), 0.5 * (high.min(1.0) - low));
                nodes.extend(
                    gauss_legendre(24)
                        .iter()
                        .map(|(node, weight)| (low + half * (1.0 + node), half * weight)),
                );
                low = high;
            }
            let arguments: Vec<Arguments> = nodes
                .iter()
                .map(|(squared, _)| {
                    let (sine, cosine) = (squared.sqrt() as f32, (1.0 - squared).sqrt() as f32);
                    [0.0, 0.0, 1.0, 0.0, sine, 0.0, cosine, 0.0, 0.0, 0.0, 0.0, alpha]
                })
                .collect();
            let values = on_device(name, &arguments);
            // h.n dw = pi du; without the projection it is pi du/(n.h).
            let sum = |projected: bool| -> f64 {
                let terms = nodes.iter().zip(&values).map(|((squared, weight), value)| {
                    let projection = if projected { 1.0 } else { (1.0 - squared).sqrt() };
                    core::f64::consts::PI * weight * f64::from(value[0]) / projection
                });
                terms.sum()
            };
            assert!((sum(true) - 1.0).abs() < 1e-4, "{name} {alpha}: {}", sum(true));
            // The negative control: the facets themselves are more than the plane.
            assert!(sum(false) > 1.0 + 1e-3, "{name} {alpha}: {}", sum(false));
        }
    }
}

#[test]
fn mean_length_and_sharpness_are_inverse() {
    let sharpnesses: Vec<f64> = sharpnesses().collect();
    let there: Vec<Arguments> = sharpnesses.iter().map(|value| at(0.0, *value)).collect();
    let lengths = on_device("vmf_mean_length_exact", &there);
    let complements = on_device("vmf_mean_length_complement", &there);
    let back: Vec<Arguments> = lengths
        .iter()
        .zip(&complements)
        .map(|(length, complement)| {
            let mut arguments = [0.0; 12];
            (arguments[0], arguments[1]) = (length[0], complement[0]);
            arguments
        })
        .collect();
    let error = |name: &str| {
        let found = on_device(name, &back);
        let each = found
            .iter()
            .zip(&there)
            .map(|(found, expected)| (f64::from(found[0]) / f64::from(expected[3]) - 1.0).abs());
        each.fold(0.0, f64::max)
    };
    assert!(error("vmf_sharpness_exact") < 1e-5, "{}", error("vmf_sharpness_exact"));
    // The negative control: an approximation is none.
    assert!(error("vmf_sharpness_banerjee") > 1e-2, "{}", error("vmf_sharpness_banerjee"));
}
