//! What the driver needs to know of a module: its entry points, bindings and capabilities.
//!
//! The layout comes from the module and not from the manifest, because the module is what is compiled. A driver does
//! not check a module, so a broken one is refused here.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use ash::vk::DescriptorType;
use rspirv::dr::{Instruction, Operand, load_words};
use rspirv::spirv::{Decoration, Dim, ExecutionModel, Op, StorageClass, Word};

use crate::capability::ZEROED_WORKGROUP;
use crate::error::Error;

/// A checked module.
#[derive(Clone, Debug)]
pub(crate) struct Module {
    pub(crate) words: Vec<u32>,
    /// Names of the compute entry points.
    pub(crate) entry_points: Vec<String>,
    /// By set and binding: what is bound, and how many.
    pub(crate) bindings: BTreeMap<(u32, u32), (DescriptorType, u32)>,
    pub(crate) capabilities: BTreeSet<u32>,
    pub(crate) push_constants: bool,
}

/// No binding of WebGPU is above 1000, and no set above 3; larger ones would make large tables.
const MAXIMUM_BINDINGS: u32 = 4096;
const MAXIMUM_SETS: u32 = 8;
/// The operand of an image's type that says that it is stored to.
const STORED: Operand = Operand::LiteralBit32(2);

/// Reads and checks a module; `path` is for errors.
pub(crate) fn read(bytes: &[u8], path: &Path) -> Result<Module, Error> {
    let wrong = |what: String| Error::Spirv { path: path.to_owned(), what };
    let (whole, rest) = bytes.as_chunks::<4>();
    if !rest.is_empty() {
        return Err(wrong("its length is no multiple of 4".to_owned()));
    }
    let words: Vec<u32> = whole.iter().map(|word| u32::from_le_bytes(*word)).collect();
    // rspirv panics at an instruction that ends behind the file.
    let mut at = 5;
    while let Some(first) = words.get(at) {
        let length = (first >> 16) as usize;
        if length == 0 || words.len() - at < length {
            return Err(wrong(format!("word {at}: an instruction of {length} words")));
        }
        at += length;
    }
    let parsed = load_words(&words).map_err(|state| wrong(state.to_string()))?;
    let functions: BTreeSet<Word> =
        parsed.functions.iter().filter_map(|function| function.def.as_ref()?.result_id).collect();
    let calls = parsed.all_inst_iter().filter(|one| one.class.opcode == Op::FunctionCall);
    let calls = calls.filter_map(|call| id(call.operands.first()?));
    let entered = parsed.entry_points.iter().filter_map(|entry| id(entry.operands.get(1)?));
    if let Some(function) = calls.chain(entered).find(|function| !functions.contains(function)) {
        return Err(wrong(format!("it uses function %{function}, which it does not have")));
    }
    if functions.is_empty() {
        return Err(wrong("it has no functions".to_owned()));
    }
    let capabilities = parsed.capabilities.iter().filter_map(|one| match one.operands[..] {
        [Operand::Capability(capability)] => Some(capability as u32),
        _ => None,
    });
    let entry_points = parsed.entry_points.iter().filter_map(|entry| match &entry.operands[..] {
        [
            Operand::ExecutionModel(ExecutionModel::GLCompute),
            _,
            Operand::LiteralString(name),
            ..,
        ] => Some(name.clone()),
        _ => None,
    });
    let mut module = Module {
        entry_points: entry_points.collect(),
        bindings: BTreeMap::new(),
        capabilities: capabilities.collect(),
        push_constants: false,
        words,
    };
    let globals = parsed.types_global_values.iter();
    let globals: BTreeMap<Word, &Instruction> =
        globals.filter_map(|one| Some((one.result_id?, one))).collect();
    let mut decorations = BTreeMap::new();
    for one in &parsed.annotations {
        if let [Operand::IdRef(target), Operand::Decoration(kind), rest @ ..] = &one.operands[..] {
            let value = rest.first().map_or(Some(1), literal).unwrap_or(1);
            decorations.insert((*target, *kind as u32), value);
        }
    }
    let of = Declared { globals: &globals, decorations: &decorations };
    for variable in globals.values().filter(|one| one.class.opcode == Op::Variable) {
        let storage = match variable.operands.first() {
            Some(Operand::StorageClass(storage)) => *storage,
            _ => continue,
        };
        module.push_constants |= storage == StorageClass::PushConstant;
        if storage == StorageClass::Workgroup && variable.operands.len() > 1 {
            module.capabilities.insert(ZEROED_WORKGROUP);
        }
        if let Some((place, bound)) = of.binding(variable, storage).map_err(wrong)? {
            module.bindings.insert(place, bound);
        }
    }
    Ok(module)
}

fn id(operand: &Operand) -> Option<Word> {
    operand.id_ref_any()
}

fn literal(operand: &Operand) -> Option<u32> {
    match operand {
        Operand::LiteralBit32(value) => Some(*value),
        _ => None,
    }
}

/// What a module declares outside of its functions.
struct Declared<'a> {
    globals: &'a BTreeMap<Word, &'a Instruction>,
    decorations: &'a BTreeMap<(Word, u32), u32>,
}

/// Set and binding, then what is bound and how many of it.
type Bound = ((u32, u32), (DescriptorType, u32));

impl Declared<'_> {
    fn decoration(&self, id: Word, kind: Decoration) -> Option<u32> {
        self.decorations.get(&(id, kind as u32)).copied()
    }

    fn declared(&self, of: Option<Word>) -> Result<&Instruction, String> {
        let found = of.and_then(|id| self.globals.get(&id).copied());
        found.ok_or_else(|| format!("%{} is not declared", of.unwrap_or_default()))
    }

    /// What a variable binds; nothing if it has no binding.
    fn binding(
        &self,
        variable: &Instruction,
        storage: StorageClass,
    ) -> Result<Option<Bound>, String> {
        let own = variable.result_id.unwrap_or_default();
        let Some(binding) = self.decoration(own, Decoration::Binding) else { return Ok(None) };
        let set = self.decoration(own, Decoration::DescriptorSet).unwrap_or(0);
        if binding >= MAXIMUM_BINDINGS || set >= MAXIMUM_SETS {
            return Err(format!(
                "binding {binding} of set {set}; expected below {MAXIMUM_BINDINGS} and {MAXIMUM_SETS}"
            ));
        }
        let operand = |of: &Instruction, index: usize| of.operands.get(index).and_then(id);
        let pointer = self.declared(variable.result_type)?;
        let mut bound = self.declared(operand(pointer, 1))?;
        let mut count = 1;
        if bound.class.opcode == Op::TypeArray {
            let length = self.declared(operand(bound, 1))?;
            count = length.operands.first().and_then(literal).unwrap_or(u32::MAX);
            if count > MAXIMUM_BINDINGS {
                return Err(format!("an array of more than {MAXIMUM_BINDINGS} bindings"));
            }
            bound = self.declared(operand(bound, 0))?;
        }
        let kind = self.kind(bound, storage);
        let kind = kind.ok_or_else(|| format!("%{own} is no buffer, image or sampler"))?;
        Ok(Some(((set, binding), (kind, count))))
    }

    fn kind(&self, bound: &Instruction, storage: StorageClass) -> Option<DescriptorType> {
        // Operands of an image: sampled type, dimension, depth, array, multisample, use.
        let buffer = bound.operands.get(1) == Some(&Operand::Dim(Dim::DimBuffer));
        let stored = bound.operands.get(5) == Some(&STORED);
        let old = bound.result_id.and_then(|id| self.decoration(id, Decoration::BufferBlock));
        Some(match (bound.class.opcode, storage) {
            (Op::TypeStruct, StorageClass::StorageBuffer) => DescriptorType::STORAGE_BUFFER,
            (Op::TypeStruct, StorageClass::Uniform) if old.is_some() => {
                DescriptorType::STORAGE_BUFFER
            }
            (Op::TypeStruct, StorageClass::Uniform) => DescriptorType::UNIFORM_BUFFER,
            (Op::TypeSampler, _) => DescriptorType::SAMPLER,
            (Op::TypeSampledImage, _) => DescriptorType::COMBINED_IMAGE_SAMPLER,
            (Op::TypeImage, _) => match (buffer, stored) {
                (true, true) => DescriptorType::STORAGE_TEXEL_BUFFER,
                (true, false) => DescriptorType::UNIFORM_TEXEL_BUFFER,
                (false, true) => DescriptorType::STORAGE_IMAGE,
                (false, false) => DescriptorType::SAMPLED_IMAGE,
            },
            _ => return None,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PLAIN: &[u8] = include_bytes!("../tests/spirv/plain.spv");

    fn refused(bytes: &[u8]) -> String {
        read(bytes, Path::new("x.spv")).unwrap_err().to_string()
    }

    #[test]
    fn a_module_is_read() {
        let module = read(PLAIN, Path::new("x.spv")).unwrap();
        assert_eq!(module.entry_points, ["main"]);
        assert_eq!(module.bindings[&(0, 0)], (DescriptorType::STORAGE_BUFFER, 1));
        assert!(module.capabilities.contains(&1));
    }

    #[test]
    fn memory_that_starts_at_zero_is_seen() {
        let bytes = include_bytes!("../tests/spirv/zeroed.spv");
        let module = read(bytes, Path::new("x.spv")).unwrap();
        assert!(module.capabilities.contains(&ZEROED_WORKGROUP));
    }

    #[test]
    fn every_truncation_is_refused() {
        for length in 0..PLAIN.len() {
            let text = refused(&PLAIN[..length]);
            assert!(text.starts_with("x.spv: invalid SPIR-V: "), "{length}: {text}");
        }
    }

    #[test]
    fn other_files_are_refused() {
        assert!(refused(b"fn main() {} // WGSL....").contains("invalid SPIR-V"));
        let mut empty = PLAIN.to_vec();
        empty[20..24].fill(0);
        assert!(refused(&empty).contains("invalid SPIR-V"));
    }
}
