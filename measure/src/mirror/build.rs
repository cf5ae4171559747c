//! Takes a function's naga IR apart into operations on scalars, with every call inlined, as drivers do.

use std::collections::HashMap;

use naga::valid::{FunctionInfo, ModuleInfo};
use naga::{Block, Expression, Function, Handle, LocalVariable, Module, Statement, TypeInner};
use sglow_results::arithmetic::Arithmetic;

use super::operation::Operation;
use super::step::{MirrorError, Register, Step};

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
pub(super) struct Frame<'a> {
    pub(super) function: &'a Function,
    pub(super) info: &'a FunctionInfo,
    pub(super) arguments: Vec<Vec<Register>>,
    pub(super) values: HashMap<Handle<Expression>, Vec<Register>>,
    pub(super) variables: HashMap<Handle<LocalVariable>, Vec<Register>>,
    /// What a variable's register is known to hold, until control flow parts.
    pub(super) known: HashMap<Register, Register>,
    pub(super) returned: Vec<Register>,
    /// Whether the only return is the last statement, so that its value needs no copy.
    pub(super) returns_at_end: bool,
    /// Jumps to the end of the function.
    pub(super) leaving: Vec<usize>,
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

    pub(super) fn constant(&mut self, bits: u32) -> Register {
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

    pub(super) fn step_to(&mut self, operation: Operation, to: Register, operands: &[Register]) {
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
    pub(super) fn part(&self, inner: &TypeInner, index: usize) -> Option<(usize, usize)> {
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
    pub(super) fn place(
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

    pub(super) fn pointee(
        &self,
        frame: &Frame<'a>,
        pointer: Handle<Expression>,
    ) -> Option<&'a TypeInner> {
        match *frame.info[pointer].ty.inner_with(&self.module.types) {
            TypeInner::Pointer { base, .. } => Some(&self.module.types[base].inner),
            _ => None,
        }
    }

    /// The value of an expression that was evaluated, or that needs no evaluation.
    pub(super) fn value(
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
}
