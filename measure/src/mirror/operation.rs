//! Operations on scalars, and what each gives under an arithmetic.

use sglow_oracle::tolerance::{
    DIVISION_ULPS, INVERSE_SQRT_ULPS, LOG_NEAR_ONE, LOG_ULPS, ROUNDING_ULPS, SQRT_ULPS, exp_ulps,
};
use sglow_results::arithmetic::Arithmetic;
use sglow_results::error::ulp;

use crate::mirror::chance::chance;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Operation {
    Copy,
    Add,
    Subtract,
    Multiply,
    Divide,
    Negate,
    MultiplyAdd,
    Abs,
    Minimum,
    Maximum,
    Floor,
    Ceil,
    Truncate,
    RoundEven,
    Sign,
    Exp,
    Exp2,
    Log,
    Log2,
    Pow,
    Sqrt,
    InverseSqrt,
    Sin,
    Cos,
    Tan,
    Asin,
    Acos,
    Atan,
    Atan2,
    Tanh,
    Equal,
    NotEqual,
    Less,
    LessEqual,
    IntegerAdd,
    IntegerSubtract,
    IntegerMultiply,
    IntegerEqual,
    IntegerNotEqual,
    SignedLess,
    SignedLessEqual,
    UnsignedLess,
    UnsignedLessEqual,
    SignedMinimum,
    SignedMaximum,
    UnsignedMinimum,
    UnsignedMaximum,
    BitAnd,
    BitOr,
    BitXor,
    BitNot,
    ShiftLeft,
    ShiftRightUnsigned,
    ShiftRightSigned,
    Not,
    Select,
    FloatToSigned,
    FloatToUnsigned,
    SignedToFloat,
    UnsignedToFloat,
    /// To a place in the code.
    Jump,
    /// To a place in the code if the first operand is false.
    JumpUnless,
}

fn flushed(bits: u32) -> u32 {
    if f32::from_bits(bits).is_subnormal() { bits & 0x8000_0000 } else { bits }
}

/// The grant of an operation in ULP, and what it is granted on top, absolute.
fn grant(operation: Operation, a: f64, b: f64) -> (f64, f64) {
    match operation {
        Operation::Add | Operation::Subtract | Operation::Multiply | Operation::MultiplyAdd => {
            (ROUNDING_ULPS, 0.0)
        }
        Operation::Divide => (DIVISION_ULPS, 0.0),
        Operation::Exp | Operation::Exp2 => (exp_ulps(a), 0.0),
        Operation::Log | Operation::Log2 => {
            (LOG_ULPS, if (0.5..=2.0).contains(&a) { LOG_NEAR_ONE } else { 0.0 })
        }
        Operation::Pow => (exp_ulps(b * a.log2()) + (b * a.log2()).abs() * LOG_ULPS, 0.0),
        Operation::Sqrt => (SQRT_ULPS, 0.0),
        Operation::InverseSqrt => (INVERSE_SQRT_ULPS, 0.0),
        Operation::Sin | Operation::Cos => (0.0, 1.0 / 2048.0),
        _ => (0.0, 0.0),
    }
}

pub(super) fn evaluate(
    operation: Operation,
    a: u32,
    b: u32,
    c: u32,
    arithmetic: Arithmetic,
) -> u32 {
    match arithmetic {
        Arithmetic::Written | Arithmetic::Contracted | Arithmetic::Reassociated(_) => {
            exact(operation, a, b, c)
        }
        Arithmetic::Flushed => match kind(operation) {
            Kind::Arithmetic => flushed(exact(operation, flushed(a), flushed(b), flushed(c))),
            Kind::Comparison => exact(operation, flushed(a), flushed(b), c),
            Kind::Other => exact(operation, a, b, c),
        },
        Arithmetic::Granted(seed) => {
            let [x, y, z] = [a, b, c].map(|bits| f64::from(f32::from_bits(bits)));
            let Some(value) = wide(operation, x, y, z) else {
                return exact(operation, a, b, c);
            };
            let key = u64::from(a) ^ u64::from(b).rotate_left(21) ^ u64::from(c).rotate_left(42);
            let draw = 2.0 * chance(seed, key ^ ((operation as u64) << 56)) - 1.0;
            missed(operation, value, grant(operation, x, y), draw).to_bits()
        }
    }
}

/// An f32 that is off the value by up to the grant, in the direction of `draw`, -1 to 1.
#[expect(clippy::cast_possible_truncation, reason = "the rounding is what is wanted")]
fn missed(operation: Operation, value: f64, (ulps, absolute): (f64, f64), draw: f64) -> f32 {
    let nearest = value as f32;
    let exact = f64::from(nearest) == value && ulps <= 1.0 && absolute == 0.0;
    if !nearest.is_finite() || exact || (value == 0.0 && absolute == 0.0) {
        return nearest;
    }
    // One ULP is kept for the rounding itself, which may go either way.
    let perturbed = value + draw * ((ulps - 1.0).max(0.0) * ulp(value) + absolute);
    let nearest = perturbed as f32;
    let rounded = match f64::from(nearest).total_cmp(&perturbed) {
        core::cmp::Ordering::Less if draw > 0.0 => nearest.next_up(),
        core::cmp::Ordering::Greater if draw < 0.0 => nearest.next_down(),
        _ => nearest,
    };
    match operation {
        // No driver was seen to leave the range of these.
        Operation::Sin | Operation::Cos => rounded.clamp(-1.0, 1.0),
        Operation::Log | Operation::Log2 => rounded,
        // Nor to turn the sign of a result.
        _ if value > 0.0 => rounded.max(0.0),
        _ => rounded.min(0.0),
    }
}

/// The result of an operation that is granted an error, before any rounding to f32.
fn wide(operation: Operation, x: f64, y: f64, z: f64) -> Option<f64> {
    use Operation as O;
    Some(match operation {
        O::Add => x + y,
        O::Subtract => x - y,
        O::Multiply => x * y,
        O::MultiplyAdd => x.mul_add(y, z),
        O::Divide => x / y,
        O::Exp => x.exp(),
        O::Exp2 => x.exp2(),
        O::Log => x.ln(),
        O::Log2 => x.log2(),
        O::Pow => x.powf(y),
        O::Sqrt => x.sqrt(),
        O::InverseSqrt => 1.0 / x.sqrt(),
        O::Sin => x.sin(),
        O::Cos => x.cos(),
        _ => return None,
    })
}

/// What becomes of subnormal numbers in an operation.
enum Kind {
    /// Operands and result may be flushed.
    Arithmetic,
    /// Operands may be flushed.
    Comparison,
    /// Bits are bits.
    Other,
}

fn kind(operation: Operation) -> Kind {
    use Operation as O;
    match operation {
        O::Add
        | O::Subtract
        | O::Multiply
        | O::Divide
        | O::MultiplyAdd
        | O::Minimum
        | O::Maximum
        | O::Exp
        | O::Exp2
        | O::Log
        | O::Log2
        | O::Pow
        | O::Sqrt
        | O::InverseSqrt => Kind::Arithmetic,
        O::Less | O::LessEqual | O::Equal | O::NotEqual => Kind::Comparison,
        _ => Kind::Other,
    }
}

#[expect(clippy::cast_possible_truncation, reason = "the rounding is what is wanted")]
fn exact(operation: Operation, a: u32, b: u32, c: u32) -> u32 {
    use Operation as O;
    let [x, y, z] = [a, b, c].map(f32::from_bits);
    let wide = f64::from(x);
    let float = |value: f32| value.to_bits();
    // Rounded from f64: correctly, but for a few arguments in a billion.
    let rounded = |value: f64| (value as f32).to_bits();
    let flag = u32::from;
    match operation {
        O::Copy => a,
        O::Add => float(x + y),
        O::Subtract => float(x - y),
        O::Multiply => float(x * y),
        O::Divide => float(x / y),
        O::Negate => a ^ 0x8000_0000,
        // The product of two f32 is exact in f64.
        O::MultiplyAdd => rounded(f64::from(x).mul_add(f64::from(y), f64::from(z))),
        O::Abs => a & 0x7fff_ffff,
        O::Minimum => float(x.min(y)),
        O::Maximum => float(x.max(y)),
        O::Floor => float(x.floor()),
        O::Ceil => float(x.ceil()),
        O::Truncate => float(x.trunc()),
        O::RoundEven => float(x.round_ties_even()),
        O::Sign => float(if x > 0.0 {
            1.0
        } else if x < 0.0 {
            -1.0
        } else {
            0.0
        }),
        O::Exp => rounded(wide.exp()),
        O::Exp2 => rounded(wide.exp2()),
        O::Log => rounded(wide.ln()),
        O::Log2 => rounded(wide.log2()),
        O::Pow => rounded(wide.powf(f64::from(y))),
        O::Sqrt => float(x.sqrt()),
        O::InverseSqrt => rounded(1.0 / wide.sqrt()),
        O::Sin => rounded(wide.sin()),
        O::Cos => rounded(wide.cos()),
        O::Tan => rounded(wide.tan()),
        O::Asin => rounded(wide.asin()),
        O::Acos => rounded(wide.acos()),
        O::Atan => rounded(wide.atan()),
        O::Atan2 => rounded(wide.atan2(f64::from(y))),
        O::Tanh => rounded(wide.tanh()),
        O::Equal => flag(x == y),
        O::NotEqual => flag(x != y && !x.is_nan() && !y.is_nan()),
        O::Less => flag(x < y),
        O::LessEqual => flag(x <= y),
        O::IntegerAdd => a.wrapping_add(b),
        O::IntegerSubtract => a.wrapping_sub(b),
        O::IntegerMultiply => a.wrapping_mul(b),
        O::IntegerEqual => flag(a == b),
        O::IntegerNotEqual => flag(a != b),
        O::SignedLess => flag(a.cast_signed() < b.cast_signed()),
        O::SignedLessEqual => flag(a.cast_signed() <= b.cast_signed()),
        O::UnsignedLess => flag(a < b),
        O::UnsignedLessEqual => flag(a <= b),
        O::SignedMinimum => a.cast_signed().min(b.cast_signed()).cast_unsigned(),
        O::SignedMaximum => a.cast_signed().max(b.cast_signed()).cast_unsigned(),
        O::UnsignedMinimum => a.min(b),
        O::UnsignedMaximum => a.max(b),
        O::BitAnd => a & b,
        O::BitOr => a | b,
        O::BitXor => a ^ b,
        O::BitNot => !a,
        O::ShiftLeft => a.wrapping_shl(b),
        O::ShiftRightUnsigned => a.wrapping_shr(b),
        O::ShiftRightSigned => a.cast_signed().wrapping_shr(b).cast_unsigned(),
        O::Not => flag(a == 0),
        O::Select => {
            if a != 0 {
                b
            } else {
                c
            }
        }
        O::FloatToSigned => (x as i32).cast_unsigned(),
        O::FloatToUnsigned => x as u32,
        O::SignedToFloat => (a.cast_signed() as f32).to_bits(),
        O::UnsignedToFloat => (a as f32).to_bits(),
        O::Jump | O::JumpUnless => a,
    }
}
