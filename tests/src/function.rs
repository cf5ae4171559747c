//! Functions of the library on the device and on the CPU, against their oracles: what the axis `function` calls.

use std::sync::OnceLock;

use sglow_measure::bound::judge;
use sglow_measure::function::Function;
use sglow_measure::functions;
use sglow_measure::hold::{Extent, Subject, hold, mirrored};
use sglow_oracle::{Bounded, Real};
use sglow_results::arithmetic::Arithmetic;
use sglow_results::stability::held::Held;
use sglow_results::stability::quantity::Quantity;
use sglow_runtime::package::Package;
use sglow_shader_gen::generate;
use sglow_shader_gen::library::Library;
use sglow_shader_gen::validate::Validated;

use crate::common::gpu;

/// The variants of all functions.
pub(crate) fn variants() -> &'static [Validated] {
    static VARIANTS: OnceLock<Vec<Validated>> = OnceLock::new();
    VARIANTS.get_or_init(|| {
        let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../shaders");
        let library = Library::load(folder.as_ref()).unwrap();
        let of_functions =
            library.variants().into_iter().filter(|variant| variant.pass == "function");
        generate::variants(&library, &of_functions.collect::<Vec<_>>()).unwrap()
    })
}

fn held(function: &Function, variant: &Validated, extent: &Extent) -> Vec<Held> {
    let text = (variant.variant.id(), variant.text.clone());
    let package = Package::generated("one variant", [text]);
    hold(gpu(), &package, &Subject { function, variant }, extent).unwrap()
}

fn variant(function: &Function) -> &'static Validated {
    variants().iter().find(|one| one.variant.id() == function.id()).unwrap()
}

/// The same variant with its function wrapped in something wrong: `wrong` makes of `right` what is returned.
fn broken(function: &Function, wrong: &str) -> Validated {
    let whole = variant(function);
    let head = "fn sglow_function(";
    assert_eq!(whole.text.matches(head).count(), 1);
    let text = whole.text.replace(head, "fn sglow_right_function(")
        + &format!(
            "\nfn sglow_function(arguments: SglowArguments) -> vec4<f32> {{\n    \
             let right = sglow_right_function(arguments);\n    return {wrong};\n}}\n"
        );
    validated(whole, text)
}

/// A variant with another text.
fn validated(whole: &Validated, text: String) -> Validated {
    let module = naga::front::wgsl::parse_str(&text).unwrap();
    let mut validator = naga::valid::Validator::new(
        naga::valid::ValidationFlags::all(),
        naga::valid::Capabilities::all(),
    );
    let info = validator.validate(&module).unwrap();
    Validated { text, module, info, ..whole.clone() }
}

#[test]
fn every_function_keeps_every_bound() {
    let mut failures = Vec::new();
    for function in functions::all() {
        let held = held(&function, variant(&function), &Extent::QUICK);
        let verdicts = judge(&function, &held);
        assert!(function.literal || verdicts.len() >= 3, "{} has no guarantee", function.name);
        for verdict in verdicts.into_iter().filter(|verdict| !verdict.holds) {
            failures.push(format!("{verdict:?}"));
        }
    }
    assert!(failures.is_empty(), "{}", failures.join("\n"));
}

#[test]
fn every_value_of_the_axis_is_held() {
    let held: Vec<_> = functions::all().iter().map(|function| function.name).collect();
    for variant in variants() {
        let name = variant.variant.value("function").unwrap();
        assert!(name == "none" || held.contains(&name), "{name} has no oracle in the table");
    }
    assert_eq!(variants().len(), held.len() + 1);
}

/// Each bound's negative control: what is broken in that way must fail it.
#[test]
fn every_bound_notices_what_it_is_for() {
    let extent = Extent { inputs: 256, references: 64, neighbours: 32 };
    for function in functions::all().iter().filter(|function| !function.literal) {
        // A percent off, not finite, of the wrong sign; and in every second number lower by a tenth.
        let component = function.monotone.map_or(0, |monotone| monotone.component);
        let vector = ["a", "b", "c"][component / 4];
        let alternating = format!(
            "right * select(1.0, 0.9, (bitcast<u32>(arguments.{vector}[{}]) & 1u) == 1u)",
            component % 4
        );
        let off = held(function, &broken(function, "right * 1.01"), &extent);
        let infinite =
            held(function, &broken(function, "right + exp(100.0 + abs(arguments.c))"), &extent);
        let opposite = held(function, &broken(function, "-right"), &extent);
        let stepping = held(function, &broken(function, &alternating), &extent);
        for verdict in judge(function, &held(function, variant(function), &extent)) {
            let broken = match verdict.quantity {
                Quantity::NotFinite => &infinite,
                Quantity::Negative => &opposite,
                Quantity::NotMonotone => &stepping,
                Quantity::RoundingShare
                | Quantity::ArithmeticShare
                | Quantity::TotalOverPeak
                | Quantity::RoundingOverPeak => &off,
                // Those of the oracle: no shader can break them. See the next test.
                Quantity::ModelOverPeak | Quantity::WithoutPromise => continue,
            };
            let noticed = judge(function, broken)
                .into_iter()
                .find(|other| {
                    other.quantity == verdict.quantity && other.at_most == verdict.at_most
                })
                .unwrap();
            assert!(!noticed.holds, "a broken {} goes unnoticed: {noticed:?}", function.name);
        }
    }
}

/// The negative control of the bounds that only an oracle can break.
#[test]
fn a_broken_oracle_is_noticed() {
    let extent = Extent { inputs: 256, references: 64, neighbours: 0 };
    let quantities = |function: &Function| -> Vec<Quantity> {
        let held = held(function, variant(function), &extent);
        let failing = judge(function, &held).into_iter().filter(|verdict| !verdict.holds);
        failing.map(|verdict| verdict.quantity).collect()
    };
    let named = |name: &str| functions::all().into_iter().find(|one| one.name == name).unwrap();
    // A millionth off: far below what the device's rounding could show.
    let off = Function {
        bounded: |x| {
            let area = sglow_oracle::sg::integral(x[3]);
            [area * Real::constant(1.0 + 1e-6), Real::zero(), Real::zero(), Real::zero()]
        },
        monotone: None,
        ..named("sg_integral")
    };
    assert!(quantities(&off).contains(&Quantity::ModelOverPeak));
    // A tolerance without end admits everything, and has to be noticed itself.
    let vacuous = Function {
        bounded: |_| [Bounded::with_error(1.0, f64::INFINITY); 4],
        monotone: None,
        reference: None,
        ..named("sg_evaluate")
    };
    assert_eq!(quantities(&vacuous), [Quantity::WithoutPromise]);
}

/// What stability buys: the papers' literal forms do not keep the bounds that the stable ones keep. They are the negative
/// control of the bounds on inputs that are right.
#[test]
fn literal_forms_fail_what_the_stable_ones_are_held_to() {
    let literal: Vec<_> =
        functions::all().into_iter().filter(|function| function.literal).collect();
    assert!(literal.len() >= 6, "{}", literal.len());
    for function in literal {
        let held = held(&function, variant(&function), &Extent::QUICK);
        let as_if_stable = Function { literal: false, ..function };
        let failing: Vec<_> =
            judge(&as_if_stable, &held).into_iter().filter(|verdict| !verdict.holds).collect();
        let fails = |quantity| failing.iter().any(|verdict| verdict.quantity == quantity);
        assert!(fails(Quantity::RoundingShare), "{}: {failing:?}", function.name);
        assert!(fails(Quantity::ArithmeticShare), "{}: {failing:?}", function.name);
    }
}

/// A disc 4e5 times wider than it is far from a facing receiver. Where a compiler takes the share of the radius apart, its
/// factors overflow and the light is lost; the negative control is the text without what prevents that.
#[test]
fn a_wide_disc_in_contact_lights_in_every_order_of_operations() {
    let normal: [f32; 3] = [0.747_499_8, 0.015_285_205, -0.664_086_16];
    let [x, y, z] = normal;
    let mut arguments = [x, y, z, 1.305_252_9e9, -x, -y, -z, 6.949_353e9, 1.435_498_7e29, x, y, z];
    arguments[5] = arguments[5].next_up();
    let function = functions::all().into_iter().find(|one| one.name == "disc_irradiance").unwrap();
    let expected = (function.bounded)(Function::buffered(&arguments))[0];
    let off = |variant: &Validated| -> f64 {
        let subject = Subject { function: &function, variant };
        let orders = (1..=64).map(Arithmetic::Reassociated);
        let found = Arithmetic::ALL.into_iter().chain(orders).map(|arithmetic| {
            let mirror = subject.mirror(arithmetic).unwrap();
            (f64::from(mirrored(&mirror, &[arguments])[0][0]) - expected.value).abs()
        });
        found.fold(0.0, f64::max)
    };
    let whole = variant(&function);
    assert!(off(whole) < 1e-5 * expected.value, "{} of {expected:?}", off(whole));
    let text = whole.text.replace("min(radius * unit * unit, 1.0)", "radius * unit * unit");
    assert_ne!(text, whole.text);
    let apart = off(&validated(whole, text));
    assert!(apart > expected.error && apart > 0.9 * expected.value, "{apart} of {expected:?}");
}
