//! Integers of constant vectors get the sign of the vector's type.
//!
//! naga lets `textureLoad` have unsigned coordinates (gfx-rs/wgpu#9978) and keeps them in range with a vector of unsigned
//! type whose components are signed constants.

use std::collections::{BTreeMap, BTreeSet};

use rspirv::dr::{Instruction, Module, Operand};
use rspirv::spirv::{Op, Word};

/// Gives the integers of a constant vector the sign of its type.
pub(super) fn agree_on_signs(module: &mut Module) {
    let mut integers = BTreeSet::new();
    let mut components = BTreeMap::new();
    // Type and value of an integer by its id, and the other way round.
    let mut values: BTreeMap<Word, (Word, Word)> = BTreeMap::new();
    let mut constants: BTreeMap<(Word, Word), Word> = BTreeMap::new();
    let mut bound = module.header.as_ref().map_or(0, |header| header.bound);
    let mut agreed = Vec::with_capacity(module.types_global_values.len());
    for mut instruction in std::mem::take(&mut module.types_global_values) {
        let operands = instruction.operands.as_slice();
        match (instruction.class.opcode, instruction.result_id, instruction.result_type, operands) {
            (Op::TypeInt, Some(ty), ..) => {
                integers.insert(ty);
            }
            (Op::TypeVector, Some(ty), _, [Operand::IdRef(component), ..]) => {
                components.insert(ty, *component);
            }
            (Op::Constant, Some(constant), Some(ty), [Operand::LiteralBit32(value)])
                if integers.contains(&ty) =>
            {
                values.insert(constant, (ty, *value));
                constants.insert((ty, *value), constant);
            }
            (Op::ConstantComposite, _, Some(ty), _) => {
                let component =
                    components.get(&ty).filter(|component| integers.contains(component));
                for operand in &mut instruction.operands {
                    let (Some(&component), Operand::IdRef(part)) = (component, operand) else {
                        continue;
                    };
                    let Some(&(_, value)) = values.get(part).filter(|(ty, _)| *ty != component)
                    else {
                        continue;
                    };
                    *part = *constants.entry((component, value)).or_insert_with(|| {
                        let fresh = bound;
                        bound += 1;
                        let value = vec![Operand::LiteralBit32(value)];
                        let ty = Some(component);
                        agreed.push(Instruction::new(Op::Constant, ty, Some(fresh), value));
                        fresh
                    });
                }
            }
            _ => {}
        }
        agreed.push(instruction);
    }
    module.types_global_values = agreed;
    if let Some(header) = &mut module.header {
        header.bound = bound;
    }
}
