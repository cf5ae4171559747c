//! The value of an expression as operations on scalars.

use naga::{
    BinaryOperator, Expression, Function, Handle, Literal, MathFunction, RelationalFunction,
    ScalarKind, SwizzleComponent, TypeInner, UnaryOperator,
};

use super::build::{Builder, Frame, unsupported};
use super::operation::Operation;
use super::step::{MirrorError, Register};

impl<'a> Builder<'a> {
    fn global(
        &mut self,
        function: &Function,
        handle: Handle<Expression>,
    ) -> Result<Vec<Register>, MirrorError> {
        match &self.module.global_expressions[handle] {
            Expression::Literal(literal) => self.literal(function, *literal),
            Expression::Constant(constant) => {
                let init = self.module.constants[*constant].init;
                self.global(function, init)
            }
            Expression::ZeroValue(ty) => self.zero(function, *ty),
            Expression::Compose { components, .. } => {
                let parts: Result<Vec<_>, _> =
                    components.iter().map(|part| self.global(function, *part)).collect();
                Ok(parts?.concat())
            }
            Expression::Splat { size, value } => {
                let value = self.global(function, *value)?[0];
                Ok(vec![value; *size as usize])
            }
            _ => Err(unsupported(function, "a constant that is computed")),
        }
    }

    pub(super) fn zero(
        &mut self,
        function: &Function,
        ty: Handle<naga::Type>,
    ) -> Result<Vec<Register>, MirrorError> {
        let width = self.width(&self.module.types[ty].inner);
        let width = width.ok_or_else(|| unsupported(function, "an unsized zero"))?;
        Ok(vec![self.constant(0); width])
    }

    pub(super) fn literal(
        &mut self,
        function: &Function,
        literal: Literal,
    ) -> Result<Vec<Register>, MirrorError> {
        let bits = match literal {
            Literal::F32(value) => value.to_bits(),
            Literal::U32(value) => value,
            Literal::I32(value) => value.cast_unsigned(),
            Literal::Bool(value) => u32::from(value),
            other => return Err(unsupported(function, format!("the literal {other:?}"))),
        };
        Ok(vec![self.constant(bits)])
    }

    pub(super) fn kind(&self, frame: &Frame<'a>, handle: Handle<Expression>) -> Option<ScalarKind> {
        frame.info[handle].ty.inner_with(&self.module.types).scalar_kind()
    }

    pub(super) fn expression(
        &mut self,
        frame: &mut Frame<'a>,
        handle: Handle<Expression>,
    ) -> Result<Vec<Register>, MirrorError> {
        let function = frame.function;
        Ok(match &function.expressions[handle] {
            Expression::Literal(literal) => self.literal(function, *literal)?,
            Expression::Constant(constant) => {
                self.global(function, self.module.constants[*constant].init)?
            }
            Expression::ZeroValue(ty) => self.zero(function, *ty)?,
            Expression::Compose { components, .. } => {
                let parts: Result<Vec<_>, _> =
                    components.iter().map(|part| self.value(frame, *part)).collect();
                parts?.concat()
            }
            Expression::Splat { size, value } => {
                let value = self.value(frame, *value)?[0];
                vec![value; *size as usize]
            }
            Expression::Swizzle { size, vector, pattern } => {
                let vector = self.value(frame, *vector)?;
                let component = |part: &SwizzleComponent| vector[part.index() as usize];
                pattern[..*size as usize].iter().map(component).collect()
            }
            Expression::FunctionArgument(index) => frame.arguments[*index as usize].clone(),
            // Pointers are followed where they are loaded from or stored to.
            Expression::LocalVariable(_) => Vec::new(),
            Expression::AccessIndex { base, index } => {
                if self.pointee(frame, *base).is_some() {
                    return Ok(Vec::new());
                }
                let inner = frame.info[*base].ty.inner_with(&self.module.types);
                let (offset, width) = self
                    .part(inner, *index as usize)
                    .ok_or_else(|| unsupported(function, "a part of an unknown type"))?;
                self.value(frame, *base)?[offset..offset + width].to_vec()
            }
            Expression::Load { pointer } => {
                let place = self.place(frame, *pointer)?;
                place
                    .into_iter()
                    .map(|register| match frame.known.get(&register) {
                        Some(value) => *value,
                        None => self.step(Operation::Copy, &[register]),
                    })
                    .collect()
            }
            Expression::Unary { op, expr } => {
                let kind = self.kind(frame, *expr);
                let value = self.value(frame, *expr)?;
                value
                    .into_iter()
                    .map(|one| match (op, kind) {
                        (UnaryOperator::Negate, Some(ScalarKind::Float)) => Ok(self.negate(one)),
                        (UnaryOperator::Negate, _) => {
                            let zero = self.constant(0);
                            Ok(self.step(Operation::IntegerSubtract, &[zero, one]))
                        }
                        (UnaryOperator::LogicalNot, _) => Ok(self.step(Operation::Not, &[one])),
                        (UnaryOperator::BitwiseNot, _) => Ok(self.step(Operation::BitNot, &[one])),
                    })
                    .collect::<Result<_, MirrorError>>()?
            }
            Expression::Binary { op, left, right } => {
                let kind = self.kind(frame, *left).unwrap_or(ScalarKind::Float);
                let inner = |handle: Handle<Expression>| {
                    frame.info[handle].ty.inner_with(&self.module.types)
                };
                if matches!(inner(*left), TypeInner::Matrix { .. })
                    || matches!(inner(*right), TypeInner::Matrix { .. })
                {
                    return Err(unsupported(function, "arithmetic of matrices"));
                }
                let (left, right) = (self.value(frame, *left)?, self.value(frame, *right)?);
                let count = left.len().max(right.len());
                (0..count)
                    .map(|index| {
                        let (a, b) = (left[index % left.len()], right[index % right.len()]);
                        self.binary(function, *op, kind, a, b)
                    })
                    .collect::<Result<_, _>>()?
            }
            Expression::Select { condition, accept, reject } => {
                let condition = self.value(frame, *condition)?;
                let (accept, reject) = (self.value(frame, *accept)?, self.value(frame, *reject)?);
                (0..accept.len())
                    .map(|index| {
                        let condition = condition[index % condition.len()];
                        self.step(Operation::Select, &[condition, accept[index], reject[index]])
                    })
                    .collect()
            }
            Expression::Relational { fun, argument } => {
                let value = self.value(frame, *argument)?;
                let operation = match fun {
                    RelationalFunction::All => Operation::BitAnd,
                    RelationalFunction::Any => Operation::BitOr,
                    _ => return Err(unsupported(function, "a test for NaN or infinity")),
                };
                let first = value[0];
                vec![
                    value[1..]
                        .iter()
                        .fold(first, |whole, part| self.step(operation, &[whole, *part])),
                ]
            }
            Expression::As { expr, kind, convert } => {
                let from = self.kind(frame, *expr);
                let value = self.value(frame, *expr)?;
                let operation = match (convert, from, kind) {
                    (None, ..) => None,
                    (Some(_), Some(from), to) if from == *to => None,
                    (Some(_), Some(ScalarKind::Float), ScalarKind::Sint) => {
                        Some(Operation::FloatToSigned)
                    }
                    (Some(_), Some(ScalarKind::Float), ScalarKind::Uint) => {
                        Some(Operation::FloatToUnsigned)
                    }
                    (Some(_), Some(ScalarKind::Sint), ScalarKind::Float) => {
                        Some(Operation::SignedToFloat)
                    }
                    (Some(_), Some(ScalarKind::Uint | ScalarKind::Bool), ScalarKind::Float) => {
                        Some(Operation::UnsignedToFloat)
                    }
                    (Some(_), _, ScalarKind::Sint | ScalarKind::Uint) => None,
                    _ => return Err(unsupported(function, "a conversion to bool")),
                };
                match operation {
                    None => value,
                    Some(operation) => {
                        value.into_iter().map(|one| self.step(operation, &[one])).collect()
                    }
                }
            }
            Expression::Math { fun, arg, arg1, arg2, .. } => {
                let kind = self.kind(frame, *arg).unwrap_or(ScalarKind::Float);
                let mut operands = vec![self.value(frame, *arg)?];
                for operand in [arg1, arg2].into_iter().flatten() {
                    operands.push(self.value(frame, *operand)?);
                }
                self.math(function, *fun, kind, &operands)?
            }
            other => {
                let text = format!("{other:?}");
                let word = text.split(|c: char| !c.is_alphanumeric()).next().unwrap_or_default();
                return Err(unsupported(function, format!("the expression {word}")));
            }
        })
    }

    fn binary(
        &mut self,
        function: &Function,
        operator: BinaryOperator,
        kind: ScalarKind,
        a: Register,
        b: Register,
    ) -> Result<Register, MirrorError> {
        use BinaryOperator as B;
        let float = kind == ScalarKind::Float;
        let signed = kind == ScalarKind::Sint;
        let of = |float_one, signed_one, unsigned_one| {
            if float {
                float_one
            } else if signed {
                signed_one
            } else {
                unsigned_one
            }
        };
        let less = of(Operation::Less, Operation::SignedLess, Operation::UnsignedLess);
        let less_equal =
            of(Operation::LessEqual, Operation::SignedLessEqual, Operation::UnsignedLessEqual);
        let integer = |operation| of(operation, operation, operation);
        let operation = match operator {
            B::Add if float => return Ok(self.sum(a, b)),
            B::Subtract if float => return Ok(self.difference(a, b)),
            B::Multiply if float => return Ok(self.product(a, b)),
            B::Divide if float => return Ok(self.quotient(a, b)),
            B::Less => less,
            B::LessEqual => less_equal,
            B::Greater => return Ok(self.step(less, &[b, a])),
            B::GreaterEqual => return Ok(self.step(less_equal, &[b, a])),
            B::Equal => of(Operation::Equal, Operation::IntegerEqual, Operation::IntegerEqual),
            B::NotEqual => {
                of(Operation::NotEqual, Operation::IntegerNotEqual, Operation::IntegerNotEqual)
            }
            B::Add => Operation::IntegerAdd,
            B::Subtract => Operation::IntegerSubtract,
            B::Multiply => Operation::IntegerMultiply,
            B::And | B::LogicalAnd => integer(Operation::BitAnd),
            B::InclusiveOr | B::LogicalOr => integer(Operation::BitOr),
            B::ExclusiveOr => integer(Operation::BitXor),
            B::ShiftLeft => Operation::ShiftLeft,
            B::ShiftRight if signed => Operation::ShiftRightSigned,
            B::ShiftRight => Operation::ShiftRightUnsigned,
            B::Divide | B::Modulo => {
                return Err(unsupported(function, format!("the operator {operator:?}")));
            }
        };
        Ok(self.step(operation, &[a, b]))
    }

    fn math(
        &mut self,
        function: &Function,
        fun: MathFunction,
        kind: ScalarKind,
        operands: &[Vec<Register>],
    ) -> Result<Vec<Register>, MirrorError> {
        use MathFunction as M;
        let float = kind == ScalarKind::Float;
        let signed = kind == ScalarKind::Sint;
        let pick = |float_one, signed_one, unsigned_one| {
            if float {
                float_one
            } else if signed {
                signed_one
            } else {
                unsigned_one
            }
        };
        let minimum =
            pick(Operation::Minimum, Operation::SignedMinimum, Operation::UnsignedMinimum);
        let maximum =
            pick(Operation::Maximum, Operation::SignedMaximum, Operation::UnsignedMaximum);
        let a = &operands[0];
        let count = operands.iter().map(Vec::len).max().unwrap_or(0);
        let at = |which: usize, index: usize| operands[which][index % operands[which].len()];
        let unary = |this: &mut Self, operation| {
            a.iter().map(|one| this.step(operation, &[*one])).collect()
        };
        let binary = |this: &mut Self, operation| {
            (0..count).map(|index| this.step(operation, &[at(0, index), at(1, index)])).collect()
        };
        Ok(match fun {
            M::Abs if float => unary(self, Operation::Abs),
            M::Min => binary(self, minimum),
            M::Max => binary(self, maximum),
            M::Clamp => (0..count)
                .map(|index| {
                    let low = self.step(maximum, &[at(0, index), at(1, index)]);
                    self.step(minimum, &[low, at(2, index)])
                })
                .collect(),
            M::Saturate => {
                let (zero, one) = (self.float(0.0), self.float(1.0));
                a.iter()
                    .map(|value| {
                        let low = self.step(Operation::Maximum, &[*value, zero]);
                        self.step(Operation::Minimum, &[low, one])
                    })
                    .collect()
            }
            M::Sin => unary(self, Operation::Sin),
            M::Cos => unary(self, Operation::Cos),
            M::Tan => unary(self, Operation::Tan),
            M::Asin => unary(self, Operation::Asin),
            M::Acos => unary(self, Operation::Acos),
            M::Atan => unary(self, Operation::Atan),
            M::Atan2 => binary(self, Operation::Atan2),
            M::Tanh => unary(self, Operation::Tanh),
            M::Ceil => unary(self, Operation::Ceil),
            M::Floor => unary(self, Operation::Floor),
            M::Round => unary(self, Operation::RoundEven),
            M::Trunc => unary(self, Operation::Truncate),
            M::Fract => a
                .iter()
                .map(|value| {
                    let floor = self.step(Operation::Floor, &[*value]);
                    self.difference(*value, floor)
                })
                .collect(),
            M::Exp => unary(self, Operation::Exp),
            M::Exp2 => unary(self, Operation::Exp2),
            M::Log => unary(self, Operation::Log),
            M::Log2 => unary(self, Operation::Log2),
            M::Pow => binary(self, Operation::Pow),
            M::Sqrt => unary(self, Operation::Sqrt),
            M::InverseSqrt => unary(self, Operation::InverseSqrt),
            M::Sign => unary(self, Operation::Sign),
            M::Dot if float => vec![self.dot(a, &operands[1])],
            M::Length => {
                let squared = self.dot(a, a);
                vec![self.step(Operation::Sqrt, &[squared])]
            }
            M::Distance => {
                let offset: Vec<_> =
                    a.iter().zip(&operands[1]).map(|(a, b)| self.difference(*a, *b)).collect();
                let squared = self.dot(&offset, &offset);
                vec![self.step(Operation::Sqrt, &[squared])]
            }
            M::Normalize => {
                let squared = self.dot(a, a);
                let scale = self.step(Operation::InverseSqrt, &[squared]);
                a.iter().map(|value| self.product(*value, scale)).collect()
            }
            M::Cross => {
                let b = &operands[1];
                [(1, 2), (2, 0), (0, 1)]
                    .into_iter()
                    .map(|(i, j)| {
                        let (plus, minus) = (self.product(a[i], b[j]), self.product(a[j], b[i]));
                        self.difference(plus, minus)
                    })
                    .collect()
            }
            M::Fma => (0..count)
                .map(|index| {
                    // Not fused where it is not contracted, as on lavapipe.
                    let product = self.product(at(0, index), at(1, index));
                    self.sum(product, at(2, index))
                })
                .collect(),
            M::Mix => (0..count)
                .map(|index| {
                    let one = self.float(1.0);
                    let rest = self.difference(one, at(2, index));
                    let (low, high) = (
                        self.product(at(0, index), rest),
                        self.product(at(1, index), at(2, index)),
                    );
                    self.sum(low, high)
                })
                .collect(),
            M::Step => (0..count)
                .map(|index| {
                    let reached = self.step(Operation::LessEqual, &[at(0, index), at(1, index)]);
                    let (one, zero) = (self.float(1.0), self.float(0.0));
                    self.step(Operation::Select, &[reached, one, zero])
                })
                .collect(),
            _ => return Err(unsupported(function, format!("the built-in {fun:?} of {kind:?}"))),
        })
    }
}
