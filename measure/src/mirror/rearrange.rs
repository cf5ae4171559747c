//! Sums and products as an arithmetic has them: contracted, or taken apart and put together in another order.

use sglow_results::arithmetic::Arithmetic;

use super::build::{Builder, Definition};
use super::operation::Operation;
use super::step::Register;
use crate::mirror::chance::chance;

impl Builder<'_> {
    pub(super) fn negate(&mut self, a: Register) -> Register {
        self.defined(Definition::Negation(a), Operation::Negate, &[a])
    }

    pub(super) fn sum(&mut self, a: Register, b: Register) -> Register {
        self.combine(Definition::Sum(a, b), Operation::Add, a, b)
    }

    pub(super) fn difference(&mut self, a: Register, b: Register) -> Register {
        self.combine(Definition::Difference(a, b), Operation::Subtract, a, b)
    }

    pub(super) fn product(&mut self, a: Register, b: Register) -> Register {
        self.combine(Definition::Product(a, b), Operation::Multiply, a, b)
    }

    pub(super) fn quotient(&mut self, a: Register, b: Register) -> Register {
        self.combine(Definition::Quotient(a, b), Operation::Divide, a, b)
    }

    fn combine(
        &mut self,
        definition: Definition,
        operation: Operation,
        a: Register,
        b: Register,
    ) -> Register {
        let rearranged = match (self.arithmetic, definition) {
            (Arithmetic::Reassociated(seed), Definition::Sum(..) | Definition::Difference(..)) => {
                Some(self.reassociated_sum(definition, seed))
            }
            (
                Arithmetic::Reassociated(seed),
                Definition::Product(..) | Definition::Quotient(..),
            ) => Some(self.reassociated_product(definition, seed)),
            (Arithmetic::Contracted, Definition::Sum(..) | Definition::Difference(..)) => {
                self.contracted(operation, a, b)
            }
            _ => None,
        };
        let register = rearranged.unwrap_or_else(|| self.step(operation, &[a, b]));
        // A register that stands for something else keeps its own history.
        if self.definitions[register as usize] == Definition::Opaque {
            self.definitions[register as usize] = definition;
        }
        register
    }

    fn contracted(&mut self, operation: Operation, a: Register, b: Register) -> Option<Register> {
        let subtract = operation == Operation::Subtract;
        if let Definition::Product(x, y) = self.definitions[a as usize] {
            let addend = if subtract { self.step(Operation::Negate, &[b]) } else { b };
            return Some(self.step(Operation::MultiplyAdd, &[x, y, addend]));
        }
        if let Definition::Product(x, y) = self.definitions[b as usize] {
            let x = if subtract { self.step(Operation::Negate, &[x]) } else { x };
            return Some(self.step(Operation::MultiplyAdd, &[x, y, a]));
        }
        None
    }

    /// The terms of a sum, each with its sign.
    fn terms(&self, definition: Definition, positive: bool, terms: &mut Vec<(Register, bool)>) {
        let mut part = |register: Register, positive: bool| match self.definitions
            [register as usize]
        {
            inner
            @ (Definition::Sum(..) | Definition::Difference(..) | Definition::Negation(_)) => {
                self.terms(inner, positive, terms);
            }
            _ => terms.push((register, positive)),
        };
        match definition {
            Definition::Sum(a, b) => {
                part(a, positive);
                part(b, positive);
            }
            Definition::Difference(a, b) => {
                part(a, positive);
                part(b, !positive);
            }
            Definition::Negation(a) => part(a, !positive),
            _ => {}
        }
    }

    /// The factors of a product; false for those it is divided by.
    fn factors(&self, definition: Definition, above: bool, factors: &mut Vec<(Register, bool)>) {
        let mut part = |register: Register, above: bool| match self.definitions[register as usize] {
            inner @ (Definition::Product(..) | Definition::Quotient(..)) => {
                self.factors(inner, above, factors);
            }
            _ => factors.push((register, above)),
        };
        match definition {
            Definition::Product(a, b) => {
                part(a, above);
                part(b, above);
            }
            Definition::Quotient(a, b) => {
                part(a, above);
                part(b, !above);
            }
            _ => {}
        }
    }

    fn reassociated_sum(&mut self, definition: Definition, seed: u64) -> Register {
        let mut terms = Vec::new();
        self.terms(definition, true, &mut terms);
        cancel(&mut terms);
        let constants = self.constants_of(&mut terms);
        if let Some(sum) = constants
            .into_iter()
            .map(
                |(bits, positive)| {
                    if positive { f32::from_bits(bits) } else { -f32::from_bits(bits) }
                },
            )
            .reduce(|a, b| a + b)
        {
            terms.push((self.float(sum), true));
        }
        self.shuffle(&mut terms, seed);
        // A term that is added comes first, if there is one.
        if let Some(first) = terms.iter().position(|(_, positive)| *positive) {
            terms.swap(0, first);
        }
        let mut terms = terms.into_iter();
        let Some((first, positive)) = terms.next() else {
            return self.float(0.0);
        };
        let first = if positive { first } else { self.step(Operation::Negate, &[first]) };
        terms.fold(first, |sum, (term, positive)| {
            self.step(if positive { Operation::Add } else { Operation::Subtract }, &[sum, term])
        })
    }

    fn reassociated_product(&mut self, definition: Definition, seed: u64) -> Register {
        let mut factors = Vec::new();
        self.factors(definition, true, &mut factors);
        cancel(&mut factors);
        let one = self.float(1.0);
        let mut all: Vec<(Register, bool)> = Vec::new();
        for (factor, above) in factors {
            all.push(if above {
                (factor, true)
            } else {
                (self.step(Operation::Divide, &[one, factor]), true)
            });
        }
        let constants = self.constants_of(&mut all);
        if let Some(product) =
            constants.into_iter().map(|(bits, _)| f32::from_bits(bits)).reduce(|a, b| a * b)
        {
            all.push((self.float(product), true));
        }
        self.shuffle(&mut all, seed);
        let first = all.first().map_or(one, |first| first.0);
        all.into_iter()
            .skip(1)
            .fold(first, |product, (factor, _)| self.step(Operation::Multiply, &[product, factor]))
    }

    /// Takes the constants out of terms or factors.
    fn constants_of(&self, parts: &mut Vec<(Register, bool)>) -> Vec<(u32, bool)> {
        let mut constants = Vec::new();
        parts.retain(|(register, sign)| match self.definitions[*register as usize] {
            Definition::Constant(bits) => {
                constants.push((bits, *sign));
                false
            }
            _ => true,
        });
        constants
    }

    fn shuffle(&self, parts: &mut [(Register, bool)], seed: u64) {
        for index in (1..parts.len()).rev() {
            let draw = chance(seed, (self.steps.len() * 64 + index) as u64);
            parts.swap(index, (draw * (index + 1) as f64) as usize);
        }
    }

    pub(super) fn dot(&mut self, a: &[Register], b: &[Register]) -> Register {
        let products: Vec<_> = a.iter().zip(b).map(|(a, b)| self.product(*a, *b)).collect();
        let first = products[0];
        products[1..].iter().fold(first, |sum, product| self.sum(sum, *product))
    }
}

/// Removes pairs of the same register with opposite signs.
fn cancel(parts: &mut Vec<(Register, bool)>) {
    let mut index = 0;
    while index < parts.len() {
        let (register, sign) = parts[index];
        match parts[index + 1..].iter().position(|other| *other == (register, !sign)) {
            Some(other) => {
                parts.remove(index + 1 + other);
                parts.remove(index);
            }
            None => index += 1,
        }
    }
}
