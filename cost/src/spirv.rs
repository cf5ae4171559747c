//! What the driver has to be told of a module: its entry points, bindings and capabilities.
//!
//! The layout comes from the module and not from the manifest, because the module is what is compiled. A driver does
//! not check a module, so a broken one is refused here.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use ash::vk::DescriptorType;

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

const MAGIC: u32 = 0x0723_0203;
/// SPIR-V 1.6, the newest that Vulkan 1.3 takes.
const NEWEST: u32 = 0x0001_0600;
/// No binding of WebGPU is above 1000, and no set above 3; larger ones would make large tables.
const MOST_BINDINGS: u32 = 4096;
const MOST_SETS: u32 = 8;

mod op {
    pub(super) const ENTRY_POINT: u32 = 15;
    pub(super) const CAPABILITY: u32 = 17;
    pub(super) const FIRST_TYPE: u32 = 19;
    pub(super) const TYPE_IMAGE: u32 = 25;
    pub(super) const TYPE_SAMPLER: u32 = 26;
    pub(super) const TYPE_SAMPLED_IMAGE: u32 = 27;
    pub(super) const TYPE_ARRAY: u32 = 28;
    pub(super) const TYPE_STRUCT: u32 = 30;
    pub(super) const TYPE_POINTER: u32 = 32;
    pub(super) const LAST_TYPE: u32 = 33;
    pub(super) const CONSTANT: u32 = 43;
    pub(super) const FUNCTION: u32 = 54;
    pub(super) const FUNCTION_END: u32 = 56;
    pub(super) const FUNCTION_CALL: u32 = 57;
    pub(super) const VARIABLE: u32 = 59;
    pub(super) const DECORATE: u32 = 71;
}

const COMPUTE: u32 = 5;
const STORAGE_CLASS_UNIFORM: u32 = 2;
const STORAGE_CLASS_WORKGROUP: u32 = 4;
const STORAGE_CLASS_PUSH_CONSTANT: u32 = 9;
const STORAGE_CLASS_STORAGE_BUFFER: u32 = 12;
const BUFFER_BLOCK: u32 = 3;
const BINDING: u32 = 33;
const SET: u32 = 34;

/// Instructions by what they declare.
#[derive(Default)]
struct Parts<'a> {
    types: BTreeMap<u32, (u32, &'a [u32])>,
    constants: BTreeMap<u32, u32>,
    decorations: BTreeMap<(u32, u32), u32>,
    variables: Vec<Variable>,
    functions: BTreeSet<u32>,
    /// Functions that are entered or called, and where.
    used: Vec<(usize, u32)>,
}

/// A variable of the module, and where its instruction is.
struct Variable {
    place: usize,
    kind: u32,
    id: u32,
    storage: u32,
}

/// Reads and checks a module; `path` is for errors.
pub(crate) fn read(bytes: &[u8], path: &Path) -> Result<Module, Error> {
    let wrong = |word, what: &str| wrong(path, word, what);
    let (whole, rest) = bytes.as_chunks::<4>();
    if !rest.is_empty() {
        return Err(wrong(
            whole.len(),
            "the file ends within a word; its length is a multiple of 4",
        ));
    }
    let words: Vec<u32> = whole.iter().map(|word| u32::from_le_bytes(*word)).collect();
    match words.get(..5) {
        None => return Err(wrong(words.len(), "it is shorter than a header of 5 words")),
        Some(head) if head[0] != MAGIC => {
            return Err(wrong(0, "the first word is not 0x07230203, little-endian"));
        }
        Some(head) if head[1] > NEWEST => {
            return Err(wrong(1, "its version is above 1.6"));
        }
        Some(_) => {}
    }
    let mut module = Module {
        words: Vec::new(),
        entry_points: Vec::new(),
        bindings: BTreeMap::new(),
        capabilities: BTreeSet::new(),
        push_constants: false,
    };
    let mut parts = Parts::default();
    let (mut at, mut open) = (5, false);
    while let Some(&first) = words.get(at) {
        let (code, length) = (first & 0xffff, (first >> 16) as usize);
        if length == 0 {
            return Err(wrong(at, "an instruction of no words"));
        }
        let Some(operands) = words.get(at + 1..at + length) else {
            return Err(wrong(at, "the file ends within an instruction"));
        };
        match (code, operands) {
            (op::CAPABILITY, &[number]) => {
                module.capabilities.insert(number);
            }
            (op::ENTRY_POINT, &[COMPUTE, function, ref name @ ..]) => {
                parts.used.push((at, function));
                module
                    .entry_points
                    .push(text(name).ok_or_else(|| wrong(at, "a name without end"))?);
            }
            (op::DECORATE, &[id, what, ref rest @ ..]) => {
                parts.decorations.insert((id, what), rest.first().copied().unwrap_or(1));
            }
            (op::CONSTANT, &[_, id, value, ..]) => {
                parts.constants.insert(id, value);
            }
            (op::VARIABLE, &[kind, id, storage, ref initial @ ..]) if !open => {
                if storage == STORAGE_CLASS_WORKGROUP && !initial.is_empty() {
                    module.capabilities.insert(ZEROED_WORKGROUP);
                }
                parts.variables.push(Variable { place: at, kind, id, storage });
            }
            (op::FIRST_TYPE..=op::LAST_TYPE, &[id, ref rest @ ..]) => {
                parts.types.insert(id, (code, rest));
            }
            (op::FUNCTION, &[_, id, ..]) => {
                open = true;
                parts.functions.insert(id);
            }
            (op::FUNCTION_CALL, &[_, _, function, ..]) => parts.used.push((at, function)),
            (op::FUNCTION_END, _) => open = false,
            _ => {}
        }
        at += length;
    }
    if open || parts.functions.is_empty() {
        return Err(wrong(words.len(), "the file ends before the end of a function"));
    }
    if let Some((at, _)) = parts.used.iter().find(|(_, id)| !parts.functions.contains(id)) {
        return Err(wrong(*at, "it uses a function that the file does not have"));
    }
    for variable in &parts.variables {
        module.push_constants |= variable.storage == STORAGE_CLASS_PUSH_CONSTANT;
        bind(&mut module.bindings, variable, &parts).map_err(|what| wrong(variable.place, what))?;
    }
    module.words = words;
    Ok(module)
}

fn wrong(path: &Path, word: usize, what: &str) -> Error {
    Error::Spirv { path: PathBuf::from(path), word, what: what.to_owned() }
}

/// A name of SPIR-V: bytes up to a zero.
fn text(words: &[u32]) -> Option<String> {
    let bytes: Vec<u8> = words.iter().flat_map(|word| word.to_le_bytes()).collect();
    let end = bytes.iter().position(|byte| *byte == 0)?;
    String::from_utf8(bytes[..end].to_vec()).ok()
}

fn bind(
    bindings: &mut BTreeMap<(u32, u32), (DescriptorType, u32)>,
    variable: &Variable,
    parts: &Parts<'_>,
) -> Result<(), &'static str> {
    let Some(&binding) = parts.decorations.get(&(variable.id, BINDING)) else { return Ok(()) };
    let set = parts.decorations.get(&(variable.id, SET)).copied().unwrap_or(0);
    if binding >= MOST_BINDINGS || set >= MOST_SETS {
        return Err("a binding of 4096 or above, or a set of 8 or above");
    }
    let Some(&(op::TYPE_POINTER, &[_, mut id])) = parts.types.get(&variable.kind) else {
        return Err("a variable whose type is no pointer");
    };
    let mut count = 1;
    if let Some(&(op::TYPE_ARRAY, &[element, length])) = parts.types.get(&id) {
        count = *parts.constants.get(&length).ok_or("an array whose length is no constant")?;
        if count > MOST_BINDINGS {
            return Err("an array of more than 4096 bindings");
        }
        id = element;
    }
    let descriptor = match (parts.types.get(&id).copied(), variable.storage) {
        (Some((op::TYPE_STRUCT, _)), STORAGE_CLASS_STORAGE_BUFFER) => {
            DescriptorType::STORAGE_BUFFER
        }
        (Some((op::TYPE_STRUCT, _)), STORAGE_CLASS_UNIFORM) => {
            if parts.decorations.contains_key(&(id, BUFFER_BLOCK)) {
                DescriptorType::STORAGE_BUFFER
            } else {
                DescriptorType::UNIFORM_BUFFER
            }
        }
        (Some((op::TYPE_SAMPLER, _)), _) => DescriptorType::SAMPLER,
        (Some((op::TYPE_SAMPLED_IMAGE, _)), _) => DescriptorType::COMBINED_IMAGE_SAMPLER,
        // Operands of an image: sampled type, dimension (5 is a buffer), depth, array, multisample, use (2 is storage).
        (Some((op::TYPE_IMAGE, &[_, 5, _, _, _, 2, ..])), _) => {
            DescriptorType::STORAGE_TEXEL_BUFFER
        }
        (Some((op::TYPE_IMAGE, &[_, 5, ..])), _) => DescriptorType::UNIFORM_TEXEL_BUFFER,
        (Some((op::TYPE_IMAGE, &[_, _, _, _, _, 2, ..])), _) => DescriptorType::STORAGE_IMAGE,
        (Some((op::TYPE_IMAGE, _)), _) => DescriptorType::SAMPLED_IMAGE,
        _ => return Err("a binding that is no buffer, image or sampler"),
    };
    bindings.insert((set, binding), (descriptor, count));
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    const PLAIN: &[u8] = include_bytes!("../tests/package/spirv/plain.spv");

    fn place(bytes: &[u8]) -> usize {
        match read(bytes, Path::new("x.spv")) {
            Err(Error::Spirv { word, .. }) => word,
            other => panic!("{other:?}"),
        }
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
        let bytes = include_bytes!("../tests/package/spirv/zeroed.spv");
        let module = read(bytes, Path::new("x.spv")).unwrap();
        assert!(module.capabilities.contains(&ZEROED_WORKGROUP));
    }

    #[test]
    fn every_truncation_is_refused_with_its_place() {
        for length in 0..PLAIN.len() {
            let word = place(&PLAIN[..length]);
            assert!(word <= length / 4, "{length}: {word}");
        }
    }

    #[test]
    fn other_files_are_refused() {
        assert_eq!(place(b"fn main() {} // WGSL...."), 0);
        let mut newer = PLAIN.to_vec();
        newer[6] = 9;
        assert_eq!(place(&newer), 1);
        let mut empty = PLAIN.to_vec();
        empty[20..24].fill(0);
        assert_eq!(place(&empty), 5);
    }
}
