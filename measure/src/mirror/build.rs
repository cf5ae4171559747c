//! Takes a function's naga IR apart into operations on scalars, with every call inlined, as drivers do.

use std::collections::HashMap;

use naga::valid::{FunctionInfo, ModuleInfo};
use naga::{
    BinaryOperator, Block, Expression, Function, Handle, Literal, LocalVariable, MathFunction,
    Module, RelationalFunction, ScalarKind, Statement, SwizzleComponent, TypeInner, UnaryOperator,
};
use sglow_results::arithmetic::Arithmetic;

use super::operation::Operation;
use super::{MirrorError, Register, Step};

pub(super) fn unsupported(function: &Function, what: impl Into<String>) -> MirrorError {
    MirrorError::Unsupported {
        function: function.name.clone().unwrap_or_default(),
        what: what.into(),
    }
}

/// How the value of a register came about, as far as rearranging needs it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Definition {
    Opaque,
    Constant(u32),
    Sum(Register, Register),
    Difference(Register, Register),
    Negation(Register),
    Product(Register, Register),
    Quotient(Register, Register),
}

pub(super) struct Builder<'a> {
    pub(super) module: &'a Module,
    pub(super) info: &'a ModuleInfo,
    pub(super) arithmetic: Arithmetic,
    pub(super) steps: Vec<Step>,
    pub(super) constants: Vec<(Register, u32)>,
    pub(super) constant_of: HashMap<u32, Register>,
    pub(super) definitions: Vec<Definition>,
}

/// One inlined call.
struct Frame<'a> {
    function: &'a Function,
    info: &'a FunctionInfo,
    arguments: Vec<Vec<Register>>,
    values: HashMap<Handle<Expression>, Vec<Register>>,
    variables: HashMap<Handle<LocalVariable>, Vec<Register>>,
    /// What a variable's register is known to hold, until control flow parts.
    known: HashMap<Register, Register>,
    returned: Vec<Register>,
    /// Whether the only return is the last statement, so that its value needs no copy.
    returns_at_end: bool,
    /// Jumps to the end of the function.
    leaving: Vec<usize>,
}

fn count_returns(block: &Block) -> usize {
    block
        .iter()
        .map(|statement| match statement {
            Statement::Return { .. } => 1,
            Statement::Block(inner) => count_returns(inner),
            Statement::If { accept, reject, .. } => count_returns(accept) + count_returns(reject),
            Statement::Switch { cases, .. } => {
                cases.iter().map(|case| count_returns(&case.body)).sum()
            }
            _ => 0,
        })
        .sum()
}

impl<'a> Builder<'a> {
    pub(super) fn register(&mut self) -> Register {
        self.definitions.push(Definition::Opaque);
        self.definitions.len() as Register - 1
    }

    fn constant(&mut self, bits: u32) -> Register {
        if let Some(&register) = self.constant_of.get(&bits) {
            return register;
        }
        let register = self.register();
        self.definitions[register as usize] = Definition::Constant(bits);
        self.constants.push((register, bits));
        self.constant_of.insert(bits, register);
        register
    }

    pub(super) fn float(&mut self, value: f32) -> Register {
        self.constant(value.to_bits())
    }

    pub(super) fn step(&mut self, operation: Operation, operands: &[Register]) -> Register {
        let to = self.register();
        self.step_to(operation, to, operands);
        to
    }

    fn step_to(&mut self, operation: Operation, to: Register, operands: &[Register]) {
        let mut all = [operands.first().copied().unwrap_or(0); 3];
        all[..operands.len()].copy_from_slice(operands);
        self.steps.push(Step { operation, to, operands: all });
    }

    pub(super) fn defined(
        &mut self,
        definition: Definition,
        operation: Operation,
        operands: &[Register],
    ) -> Register {
        let register = self.step(operation, operands);
        self.definitions[register as usize] = definition;
        register
    }

    pub(super) fn width(&self, inner: &TypeInner) -> Option<usize> {
        let types = &self.module.types;
        Some(match *inner {
            TypeInner::Scalar(_) => 1,
            TypeInner::Vector { size, .. } => size as usize,
            TypeInner::Matrix { columns, rows, .. } => columns as usize * rows as usize,
            TypeInner::Struct { ref members, .. } => members
                .iter()
                .map(|member| self.width(&types[member.ty].inner))
                .sum::<Option<usize>>()?,
            TypeInner::Array { base, size: naga::ArraySize::Constant(count), .. } => {
                count.get() as usize * self.width(&types[base].inner)?
            }
            _ => return None,
        })
    }

    /// Where the part number `index` of a value lies, and how many scalars it has.
    fn part(&self, inner: &TypeInner, index: usize) -> Option<(usize, usize)> {
        let types = &self.module.types;
        Some(match *inner {
            TypeInner::Vector { .. } => (index, 1),
            TypeInner::Matrix { rows, .. } => (index * rows as usize, rows as usize),
            TypeInner::Array { base, .. } => {
                let width = self.width(&types[base].inner)?;
                (index * width, width)
            }
            TypeInner::Struct { ref members, .. } => {
                let mut offset = 0;
                for member in &members[..index] {
                    offset += self.width(&types[member.ty].inner)?;
                }
                (offset, self.width(&types[members.get(index)?.ty].inner)?)
            }
            _ => return None,
        })
    }

    pub(super) fn call(
        &mut self,
        handle: Handle<Function>,
        arguments: Vec<Vec<Register>>,
    ) -> Result<Vec<Register>, MirrorError> {
        let function = &self.module.functions[handle];
        let body = &function.body;
        let returned = match &function.result {
            None => Vec::new(),
            Some(result) => {
                let width = self.width(&self.module.types[result.ty].inner);
                let width = width.ok_or_else(|| unsupported(function, "an unsized result"))?;
                (0..width).map(|_| self.register()).collect()
            }
        };
        let mut frame = Frame {
            function,
            info: &self.info[handle],
            arguments,
            values: HashMap::new(),
            variables: HashMap::new(),
            known: HashMap::new(),
            returned,
            returns_at_end: count_returns(body) == 1
                && matches!(body.last(), Some(Statement::Return { .. })),
            leaving: Vec::new(),
        };
        for (variable, declared) in function.local_variables.iter() {
            let inner = &self.module.types[declared.ty].inner;
            let width =
                self.width(inner).ok_or_else(|| unsupported(function, "an unsized variable"))?;
            let registers: Vec<_> = (0..width).map(|_| self.register()).collect();
            frame.variables.insert(variable, registers.clone());
            let initial = match declared.init {
                Some(expression) => self.value(&mut frame, expression)?,
                None => vec![self.constant(0); width],
            };
            for (to, from) in registers.into_iter().zip(initial) {
                self.step_to(Operation::Copy, to, &[from]);
                frame.known.insert(to, from);
            }
        }
        self.block(&mut frame, body)?;
        let end = self.steps.len() as Register;
        for jump in &frame.leaving {
            self.steps[*jump].to = end;
        }
        Ok(frame.returned)
    }

    fn block(&mut self, frame: &mut Frame<'a>, block: &'a Block) -> Result<(), MirrorError> {
        for statement in block {
            match statement {
                Statement::Emit(range) => {
                    for handle in range.clone() {
                        let value = self.expression(frame, handle)?;
                        frame.values.insert(handle, value);
                    }
                }
                Statement::Block(inner) => self.block(frame, inner)?,
                Statement::If { condition, accept, reject } => {
                    let condition = self.value(frame, *condition)?[0];
                    let around = self.steps.len();
                    self.step_to(Operation::JumpUnless, 0, &[condition]);
                    let before = frame.known.clone();
                    self.block(frame, accept)?;
                    let over = self.steps.len();
                    self.step_to(Operation::Jump, 0, &[]);
                    self.steps[around].to = self.steps.len() as Register;
                    let accepted = std::mem::replace(&mut frame.known, before);
                    self.block(frame, reject)?;
                    self.steps[over].to = self.steps.len() as Register;
                    frame.known.retain(|register, value| accepted.get(register) == Some(value));
                }
                Statement::Switch { selector, cases } => self.switch(frame, *selector, cases)?,
                Statement::Return { value } => {
                    if let Some(value) = value {
                        let value = self.value(frame, *value)?;
                        if frame.returns_at_end {
                            frame.returned = value;
                            continue;
                        }
                        for (to, from) in frame.returned.clone().into_iter().zip(value) {
                            self.step_to(Operation::Copy, to, &[from]);
                        }
                    }
                    frame.leaving.push(self.steps.len());
                    self.step_to(Operation::Jump, 0, &[]);
                }
                Statement::Store { pointer, value } => {
                    let value = self.value(frame, *value)?;
                    let place = self.place(frame, *pointer)?;
                    for (to, from) in place.into_iter().zip(value) {
                        self.step_to(Operation::Copy, to, &[from]);
                        frame.known.insert(to, from);
                    }
                }
                Statement::Call { function, arguments, result } => {
                    let arguments = arguments
                        .iter()
                        .map(|argument| self.value(frame, *argument))
                        .collect::<Result<Vec<_>, _>>()?;
                    let returned = self.call(*function, arguments)?;
                    if let Some(result) = result {
                        frame.values.insert(*result, returned);
                    }
                }
                other => {
                    let text = format!("{other:?}");
                    let word =
                        text.split(|c: char| !c.is_alphanumeric()).next().unwrap_or_default();
                    return Err(unsupported(frame.function, format!("the statement {word}")));
                }
            }
        }
        Ok(())
    }

    fn switch(
        &mut self,
        frame: &mut Frame<'a>,
        selector: Handle<Expression>,
        cases: &'a [naga::SwitchCase],
    ) -> Result<(), MirrorError> {
        let selector = self.value(frame, selector)?[0];
        let before = frame.known.clone();
        let mut ends = Vec::new();
        for case in cases {
            if case.fall_through {
                return Err(unsupported(frame.function, "cases that share a body"));
            }
            let value = match case.value {
                naga::SwitchValue::I32(value) => Some(value.cast_unsigned()),
                naga::SwitchValue::U32(value) => Some(value),
                naga::SwitchValue::Default => None,
            };
            let around = match value {
                Some(value) => {
                    let value = self.constant(value);
                    let same = self.step(Operation::IntegerEqual, &[selector, value]);
                    self.step_to(Operation::JumpUnless, 0, &[same]);
                    Some(self.steps.len() - 1)
                }
                None => None,
            };
            frame.known.clone_from(&before);
            self.block(frame, &case.body)?;
            ends.push(self.steps.len());
            self.step_to(Operation::Jump, 0, &[]);
            if let Some(around) = around {
                self.steps[around].to = self.steps.len() as Register;
            }
        }
        for end in ends {
            self.steps[end].to = self.steps.len() as Register;
        }
        frame.known.clear();
        Ok(())
    }

    /// The registers that a pointer into a local variable means.
    fn place(
        &self,
        frame: &Frame<'a>,
        pointer: Handle<Expression>,
    ) -> Result<Vec<Register>, MirrorError> {
        match frame.function.expressions[pointer] {
            Expression::LocalVariable(variable) => Ok(frame.variables[&variable].clone()),
            Expression::AccessIndex { base, index } => {
                let whole = self.place(frame, base)?;
                let inner = self.pointee(frame, base);
                let (offset, width) = inner
                    .and_then(|inner| self.part(inner, index as usize))
                    .ok_or_else(|| unsupported(frame.function, "a part of an unknown type"))?;
                Ok(whole[offset..offset + width].to_vec())
            }
            _ => Err(unsupported(frame.function, "a pointer that is no local variable's")),
        }
    }

    fn pointee(&self, frame: &Frame<'a>, pointer: Handle<Expression>) -> Option<&'a TypeInner> {
        match *frame.info[pointer].ty.inner_with(&self.module.types) {
            TypeInner::Pointer { base, .. } => Some(&self.module.types[base].inner),
            _ => None,
        }
    }

    /// The value of an expression that was evaluated, or that needs no evaluation.
    fn value(
        &mut self,
        frame: &mut Frame<'a>,
        handle: Handle<Expression>,
    ) -> Result<Vec<Register>, MirrorError> {
        if let Some(value) = frame.values.get(&handle) {
            return Ok(value.clone());
        }
        if frame.function.expressions[handle].needs_pre_emit() {
            let value = self.expression(frame, handle)?;
            frame.values.insert(handle, value.clone());
            return Ok(value);
        }
        // A constant expression may stand outside of every emitted range.
        self.expression(frame, handle)
    }

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

    fn zero(
        &mut self,
        function: &Function,
        ty: Handle<naga::Type>,
    ) -> Result<Vec<Register>, MirrorError> {
        let width = self.width(&self.module.types[ty].inner);
        let width = width.ok_or_else(|| unsupported(function, "an unsized zero"))?;
        Ok(vec![self.constant(0); width])
    }

    fn literal(
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

    fn kind(&self, frame: &Frame<'a>, handle: Handle<Expression>) -> Option<ScalarKind> {
        frame.info[handle].ty.inner_with(&self.module.types).scalar_kind()
    }

    fn expression(
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
