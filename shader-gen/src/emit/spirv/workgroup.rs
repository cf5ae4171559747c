//! Types in workgroup memory lose their explicit layout.
//!
//! naga decorates every array with `ArrayStride` and every struct member with `Offset`, also where the type lies in
//! workgroup memory (gfx-rs/wgpu#7696; gfx-rs/wgpu#9295 would mend it). There an explicit layout is illegal
//! (VUID-StandaloneSpirv-None-10684). A type that lies in workgroup memory alone loses its layout; one that lies in a
//! buffer as well gets a twin without layout, and values are taken apart and put together between the two, because
//! SPIR-V 1.3 has no `OpCopyLogical`.

use std::collections::{BTreeMap, BTreeSet};

use rspirv::dr::{Instruction, Module, Operand};
use rspirv::spirv::{Decoration, Op, StorageClass, Word};

use super::error::Error;

/// Takes the explicit layout from every type in workgroup memory.
pub(super) fn without_workgroup_layout(module: &mut Module) -> Result<(), Error> {
    let types = Types::of(module);
    let (stripped, twinned) = types.split();
    module.annotations.retain(|annotation| {
        !(is_layout(annotation) && id(annotation, 0).is_some_and(|id| stripped.contains(&id)))
    });
    if !twinned.is_empty() {
        Twins::declare(module, &types, &twinned).rewrite(module)?;
    }
    Ok(())
}

/// The id that is the operand at `index`.
fn id(instruction: &Instruction, index: usize) -> Option<Word> {
    match instruction.operands.get(index) {
        Some(Operand::IdRef(id)) => Some(*id),
        _ => None,
    }
}

fn is_layout(annotation: &Instruction) -> bool {
    let at = match annotation.class.opcode {
        Op::Decorate => 1,
        Op::MemberDecorate => 2,
        _ => return false,
    };
    matches!(
        annotation.operands.get(at),
        Some(Operand::Decoration(
            Decoration::ArrayStride
                | Decoration::MatrixStride
                | Decoration::Offset
                | Decoration::RowMajor
                | Decoration::ColMajor
        ))
    )
}

/// The storage class and the pointee of an `OpTypePointer`.
pub(super) fn pointer(instruction: &Instruction) -> Option<(StorageClass, Word)> {
    match instruction.operands.as_slice() {
        [Operand::StorageClass(class), Operand::IdRef(pointee)]
            if instruction.class.opcode == Op::TypePointer =>
        {
            Some((*class, *pointee))
        }
        _ => None,
    }
}

/// The arrays and structs of a module.
pub(super) struct Types {
    /// The types of the members, or the one type of the elements `length` times.
    parts: BTreeMap<Word, Parts>,
    /// What has a layout, itself or within.
    pub(super) laid_out: BTreeSet<Word>,
    /// What workgroup pointers point to.
    workgroup: BTreeSet<Word>,
    /// What lies where the layout is needed, itself or within something else.
    needed: BTreeSet<Word>,
}

#[derive(Clone)]
enum Parts {
    Members(Vec<Word>),
    Elements { of: Word, length: u32 },
}

impl Parts {
    fn ids(&self) -> &[Word] {
        match self {
            Self::Members(ids) => ids,
            Self::Elements { of, .. } => std::slice::from_ref(of),
        }
    }

    fn each(&self) -> Box<dyn Iterator<Item = Word> + '_> {
        match self {
            Self::Members(ids) => Box::new(ids.iter().copied()),
            Self::Elements { of, length } => Box::new((0..*length).map(|_| *of)),
        }
    }
}

impl Types {
    pub(super) fn of(module: &Module) -> Self {
        let decorated: BTreeSet<Word> = module
            .annotations
            .iter()
            .filter(|annotation| is_layout(annotation))
            .filter_map(|annotation| id(annotation, 0))
            .collect();
        let mut literals = BTreeMap::new();
        let mut types = Self {
            parts: BTreeMap::new(),
            laid_out: BTreeSet::new(),
            workgroup: BTreeSet::new(),
            needed: BTreeSet::new(),
        };
        // A type is declared after what it is made of, so one sweep is enough.
        for instruction in &module.types_global_values {
            if let Some((class, pointee)) = pointer(instruction) {
                match class {
                    StorageClass::Workgroup => {
                        types.workgroup.insert(pointee);
                    }
                    StorageClass::Function
                    | StorageClass::Private
                    | StorageClass::Input
                    | StorageClass::Output
                    | StorageClass::UniformConstant => {}
                    _ => {
                        let mut needed = std::mem::take(&mut types.needed);
                        types.reach(pointee, &mut needed);
                        types.needed = needed;
                    }
                }
            }
            let Some(result) = instruction.result_id else {
                continue;
            };
            let parts = match (instruction.class.opcode, instruction.operands.as_slice()) {
                (Op::Constant, [Operand::LiteralBit32(value)]) => {
                    literals.insert(result, *value);
                    continue;
                }
                (Op::TypeStruct, members) => {
                    Parts::Members(members.iter().filter_map(Operand::id_ref_any).collect())
                }
                (Op::TypeArray, [Operand::IdRef(of), Operand::IdRef(length)]) => {
                    Parts::Elements { of: *of, length: literals.get(length).copied().unwrap_or(0) }
                }
                (Op::TypeRuntimeArray, [Operand::IdRef(of)]) => {
                    Parts::Elements { of: *of, length: 0 }
                }
                _ => continue,
            };
            if decorated.contains(&result)
                || parts.ids().iter().any(|id| types.laid_out.contains(id))
            {
                types.laid_out.insert(result);
            }
            types.parts.insert(result, parts);
        }
        types
    }

    /// Adds the arrays and structs within `root`, itself included.
    pub(super) fn reach(&self, root: Word, into: &mut BTreeSet<Word>) {
        if let Some(parts) = self.parts.get(&root)
            && into.insert(root)
        {
            for part in parts.ids() {
                self.reach(*part, into);
            }
        }
    }

    /// The types that lose their layout, and those that get a twin without one.
    fn split(&self) -> (BTreeSet<Word>, BTreeSet<Word>) {
        let (mut stripped, mut twinned) = (BTreeSet::new(), BTreeSet::new());
        for root in &self.workgroup {
            let mut reached = BTreeSet::new();
            self.reach(*root, &mut reached);
            reached.retain(|id| self.laid_out.contains(id));
            if reached.is_disjoint(&self.needed) {
                stripped.extend(reached);
            } else {
                twinned.extend(reached);
            }
        }
        // What lies within a twinned type is reached through the twin's part, so it is twinned itself.
        stripped.retain(|id| !twinned.contains(id));
        (stripped, twinned)
    }
}

/// Which way a value is converted.
#[derive(Clone, Copy)]
enum To {
    Original,
    Twin,
}

/// Types without layout that stand in for those of workgroup memory.
struct Twins {
    of: BTreeMap<Word, Word>,
    parts: BTreeMap<Word, Parts>,
    bound: Word,
}

impl Twins {
    /// Declares a twin after each of `twinned` and lets the workgroup pointers point to the twins.
    fn declare(module: &mut Module, types: &Types, twinned: &BTreeSet<Word>) -> Self {
        let mut twins = Self {
            of: BTreeMap::new(),
            parts: types.parts.clone(),
            bound: module.header.as_ref().map_or(0, |header| header.bound),
        };
        let mut declared = Vec::with_capacity(module.types_global_values.len() + twinned.len());
        for mut instruction in std::mem::take(&mut module.types_global_values) {
            if let Some((StorageClass::Workgroup, pointee)) = pointer(&instruction)
                && let Some(twin) = twins.of.get(&pointee)
                && let Some(operand) = instruction.operands.get_mut(1)
            {
                *operand = Operand::IdRef(*twin);
            }
            let twin = instruction.result_id.filter(|id| twinned.contains(id)).map(|original| {
                let mut twin = instruction.clone();
                for operand in &mut twin.operands {
                    if let Operand::IdRef(part) = operand {
                        *part = twins.twin(*part);
                    }
                }
                let fresh = twins.fresh();
                twin.result_id = Some(fresh);
                twins.of.insert(original, fresh);
                twin
            });
            declared.push(instruction);
            declared.extend(twin);
        }
        module.types_global_values = declared;
        twins
    }

    fn fresh(&mut self) -> Word {
        let fresh = self.bound;
        self.bound += 1;
        fresh
    }

    /// The twin of a type, or the type where it needs none.
    fn twin(&self, id: Word) -> Word {
        self.of.get(&id).copied().unwrap_or(id)
    }

    /// Converts the values that functions load from and store to twinned memory.
    fn rewrite(mut self, module: &mut Module) -> Result<(), Error> {
        let original: BTreeMap<Word, Word> = self.of.iter().map(|(o, t)| (*t, *o)).collect();
        // Pointer types whose pointee is a twin, with the type that the pointee stands in for.
        let pointers: BTreeMap<Word, Word> = module
            .types_global_values
            .iter()
            .filter_map(|instruction| {
                let (class, pointee) = pointer(instruction)?;
                let original =
                    original.get(&pointee).filter(|_| class == StorageClass::Workgroup)?;
                Some((instruction.result_id?, *original))
            })
            .collect();
        let places: BTreeMap<Word, Word> = module
            .all_inst_iter()
            .filter_map(|instruction| {
                let original = pointers.get(&instruction.result_type?)?;
                Some((instruction.result_id?, *original))
            })
            .collect();
        let nulls: BTreeSet<Word> = module
            .types_global_values
            .iter()
            .filter(|instruction| instruction.class.opcode == Op::ConstantNull)
            .filter_map(|instruction| instruction.result_id)
            .collect();
        let mut twin_nulls = BTreeMap::new();

        for block in module.functions.iter_mut().flat_map(|function| &mut function.blocks) {
            let mut rewritten = Vec::with_capacity(block.instructions.len());
            for mut instruction in std::mem::take(&mut block.instructions) {
                let Some(&original) = id(&instruction, 0).and_then(|place| places.get(&place))
                else {
                    rewritten.push(instruction);
                    continue;
                };
                match (instruction.class.opcode, instruction.result_id) {
                    (Op::Load, Some(result)) => {
                        let loaded = self.fresh();
                        instruction.result_type = Some(self.twin(original));
                        instruction.result_id = Some(loaded);
                        rewritten.push(instruction);
                        self.convert(loaded, original, To::Original, result, &mut rewritten);
                    }
                    (Op::Store, _) => {
                        let Some(object) = id(&instruction, 1) else {
                            return Err(Error::Copy(Op::Store));
                        };
                        let converted = if nulls.contains(&object) {
                            *twin_nulls.entry(original).or_insert_with(|| self.fresh())
                        } else {
                            let converted = self.fresh();
                            self.convert(object, original, To::Twin, converted, &mut rewritten);
                            converted
                        };
                        if let Some(operand) = instruction.operands.get_mut(1) {
                            *operand = Operand::IdRef(converted);
                        }
                        rewritten.push(instruction);
                    }
                    (opcode @ (Op::CopyMemory | Op::CopyMemorySized), _) => {
                        return Err(Error::Copy(opcode));
                    }
                    _ => rewritten.push(instruction),
                }
            }
            block.instructions = rewritten;
        }
        for (original, null) in twin_nulls {
            let twin = Some(self.twin(original));
            let null = Instruction::new(Op::ConstantNull, twin, Some(null), Vec::new());
            module.types_global_values.push(null);
        }
        if let Some(header) = &mut module.header {
            header.bound = self.bound;
        }
        Ok(())
    }

    /// Makes `result` of `value`, part by part. `original` is the type that has a twin.
    fn convert(
        &mut self,
        value: Word,
        original: Word,
        to: To,
        result: Word,
        into: &mut Vec<Instruction>,
    ) {
        let parts = self.parts.get(&original).cloned();
        let mut made = Vec::new();
        for (index, part) in parts.iter().flat_map(Parts::each).enumerate() {
            let twin = self.twin(part);
            let extracted = self.fresh();
            let from = match to {
                To::Original => twin,
                To::Twin => part,
            };
            into.push(Instruction::new(
                Op::CompositeExtract,
                Some(from),
                Some(extracted),
                vec![Operand::IdRef(value), Operand::LiteralBit32(index as u32)],
            ));
            let converted = if twin == part {
                extracted
            } else {
                let converted = self.fresh();
                self.convert(extracted, part, to, converted, into);
                converted
            };
            made.push(Operand::IdRef(converted));
        }
        let whole = match to {
            To::Original => original,
            To::Twin => self.twin(original),
        };
        into.push(Instruction::new(Op::CompositeConstruct, Some(whole), Some(result), made));
    }
}
