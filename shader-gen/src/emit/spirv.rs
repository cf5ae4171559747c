//! SPIR-V 1.3 of a validated module, in a form that recent validators accept too.
//!
//! naga decorates every array with `ArrayStride` and every struct member with `Offset`, also where the
//! type lies in workgroup memory. There an explicit layout is illegal (VUID-StandaloneSpirv-None-10684).
//! A type that lies in workgroup memory alone loses its layout; one that lies in a buffer as well
//! gets a twin without layout, and values are taken apart and put together between the two, because
//! SPIR-V 1.3 has no `OpCopyLogical`.
//!
//! Where a texel is loaded at unsigned coordinates, naga keeps them in range with a vector of unsigned type that it
//! makes of signed ones. Those become unsigned.

use std::collections::{BTreeMap, BTreeSet};

use naga::back::pipeline_constants::{PipelineConstantError, process_overrides};
use naga::back::spv;
use naga::proc::{BoundsCheckPolicies, BoundsCheckPolicy};
use naga::valid::{Capabilities, ModuleInfo, ValidationFlags, Validator};
use rspirv::binary::Assemble;
use rspirv::dr::{Instruction, Module, Operand};
use rspirv::spirv::{Decoration, Op, StorageClass, Word};

/// Why a module has no SPIR-V.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// An override has no default, or its default does not fit.
    #[error("the overrides cannot be baked with their defaults: {0}")]
    Overrides(#[from] Box<PipelineConstantError>),
    /// naga refuses the module that it has made of a valid one.
    #[error("naga refuses the module after baking its overrides: {0}")]
    Baked(#[from] Box<naga::WithSpan<naga::valid::ValidationError>>),
    /// The back end cannot express the module.
    #[error("naga's SPIR-V back end: {0}")]
    BackEnd(#[from] spv::Error),
    /// naga's words could not be read back.
    #[error("naga's SPIR-V cannot be read back: {0}")]
    ReadBack(String),
    /// An instruction that copies workgroup memory in a way that is not known here.
    #[error(
        "{0:?} copies workgroup memory whose type also lies in a buffer; only OpLoad and OpStore are known to"
    )]
    Copy(Op),
}

/// The version of SPIR-V that is written: Vulkan 1.1 and later read it.
pub const VERSION: (u8, u8) = (1, 3);

/// The name and version of what writes the words, for the manifest.
pub const TOOL: &str = concat!("naga ", env!("SGLOW_NAGA_VERSION"), ", SPIR-V 1.3");

/// Every option of the back end, pinned: naga's defaults follow the build profile.
///
/// - No debug names: the WGSL beside it is the readable form.
/// - Clip space stays WebGPU's (y up): a Vulkan host gives its viewport a negative height.
/// - Indices out of range stay within bounds, as WGSL demands of every device.
/// - Loops are not bounded by a counter: a library's loops end.
fn options() -> spv::Options<'static> {
    spv::Options {
        lang_version: VERSION,
        flags: spv::WriterFlags::LABEL_VARYINGS | spv::WriterFlags::CLAMP_FRAG_DEPTH,
        fake_missing_bindings: true,
        binding_map: spv::BindingMap::default(),
        capabilities: None,
        bounds_check_policies: BoundsCheckPolicies {
            index: BoundsCheckPolicy::Restrict,
            buffer: BoundsCheckPolicy::Restrict,
            image_load: BoundsCheckPolicy::Restrict,
            binding_array: BoundsCheckPolicy::Restrict,
        },
        zero_initialize_workgroup_memory: spv::ZeroInitializeWorkgroupMemoryMode::Polyfill,
        force_loop_bounding: false,
        ray_query_initialization_tracking: true,
        trace_ray_argument_validation: true,
        use_storage_input_output_16: true,
        debug_info: None,
        task_dispatch_limits: None,
        mesh_shader_primitive_indices_clamp: true,
        emit_int_div_checks: true,
    }
}

/// The SPIR-V words of all entry points of `module`, its overrides baked with their defaults.
///
/// # Errors
///
/// When an override has no default, or naga or the reading back of its words fails.
pub fn write(module: &naga::Module, info: &ModuleInfo) -> Result<Vec<u32>, Error> {
    let words = if module.overrides.is_empty() {
        spv::write_vec(module, info, &options(), None)?
    } else {
        let none = naga::back::PipelineConstants::default();
        let (baked, _) = process_overrides(module, info, None, &none).map_err(Box::new)?;
        let mut baked = baked.into_owned();
        naga::compact::compact(&mut baked, naga::compact::KeepUnused::No);
        let info = Validator::new(ValidationFlags::all(), Capabilities::all())
            .validate(&baked)
            .map_err(Box::new)?;
        spv::write_vec(&baked, &info, &options(), None)?
    };
    let mut module =
        rspirv::dr::load_words(&words).map_err(|error| Error::ReadBack(error.to_string()))?;
    // rspirv names itself as the generator of what it reads.
    if let (Some(header), Some(generator)) = (&mut module.header, words.get(2)) {
        header.generator = *generator;
    }
    agree_on_signs(&mut module);
    without_workgroup_layout(&mut module)?;
    Ok(module.assemble())
}

/// The words as they lie in a `.spv` file: little endian.
pub fn bytes(words: &[u32]) -> Vec<u8> {
    words.iter().flat_map(|word| word.to_le_bytes()).collect()
}

/// Gives the integers of a constant vector the sign of its type.
fn agree_on_signs(module: &mut Module) {
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

/// Takes the explicit layout from every type in workgroup memory.
fn without_workgroup_layout(module: &mut Module) -> Result<(), Error> {
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
fn pointer(instruction: &Instruction) -> Option<(StorageClass, Word)> {
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
struct Types {
    /// The types of the members, or the one type of the elements `length` times.
    parts: BTreeMap<Word, Parts>,
    /// What has a layout, itself or within.
    laid_out: BTreeSet<Word>,
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
    fn of(module: &Module) -> Self {
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
    fn reach(&self, root: Word, into: &mut BTreeSet<Word>) {
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

#[cfg(test)]
mod tests {
    use super::*;

    /// `Light` lies in a buffer and in workgroup memory, within an array; `Alone` in workgroup memory alone.
    const WGSL: &str = "
struct Inner { d: vec3<f32>, e: array<vec4<f32>, 2> }
struct Light { a: vec3<f32>, b: f32, m: mat3x3<f32>, i: Inner, k: array<Inner, 2> }
struct Alone { a: array<f32, 4>, m: mat2x2<f32> }
override steps: u32 = 8;
@group(0) @binding(0) var<storage, read> lights: array<Light>;
@group(0) @binding(1) var<storage, read_write> result: array<f32>;
var<workgroup> tile: array<Light, 16>;
var<workgroup> alone: Alone;
var<workgroup> counts: array<atomic<u32>, 4>;
@compute @workgroup_size(16)
fn main(@builtin(local_invocation_index) i: u32) {
    tile[i] = lights[i];
    alone.a[i] = 1.0;
    atomicAdd(&counts[i % 4u], steps);
    workgroupBarrier();
    let one = tile[i ^ 1u];
    let all = tile;
    result[i] = one.b + all[i].k[1].e[0].x + alone.a[i];
}";

    fn parse(wgsl: &str) -> (naga::Module, ModuleInfo) {
        let module = naga::front::wgsl::parse_str(wgsl).unwrap();
        let info =
            Validator::new(ValidationFlags::all(), Capabilities::all()).validate(&module).unwrap();
        (module, info)
    }

    /// The types with a layout that `class` pointers reach.
    fn laid_out(words: &[u32], class: StorageClass) -> BTreeSet<Word> {
        let module = rspirv::dr::load_words(words).unwrap();
        let types = Types::of(&module);
        let mut reached = BTreeSet::new();
        for (_, pointee) in
            module.types_global_values.iter().filter_map(pointer).filter(|(of, _)| *of == class)
        {
            types.reach(pointee, &mut reached);
        }
        reached.retain(|id| types.laid_out.contains(id));
        reached
    }

    #[test]
    fn workgroup_memory_has_no_layout_and_buffers_keep_theirs() {
        let (module, info) = parse(WGSL);
        let words = write(&module, &info).unwrap();
        assert_eq!(laid_out(&words, StorageClass::Workgroup), BTreeSet::new());
        // array<Light>, Light, Inner, array<Inner, 2>, array<vec4, 2>, array<f32> and two blocks.
        assert_eq!(laid_out(&words, StorageClass::StorageBuffer).len(), 8);
        // Negative control: naga alone lays workgroup memory out.
        let (module, info) = parse(&WGSL.replace("override", "const"));
        let raw = spv::write_vec(&module, &info, &options(), None).unwrap();
        assert!(!laid_out(&raw, StorageClass::Workgroup).is_empty());
    }

    #[test]
    fn writing_is_deterministic() {
        let (module, info) = parse(WGSL);
        let (again, again_info) = parse(WGSL);
        assert_eq!(write(&module, &info).unwrap(), write(&again, &again_info).unwrap());
        assert_ne!(
            write(&module, &info).unwrap(),
            {
                let (other, other_info) = parse(&WGSL.replace("= 8", "= 9"));
                write(&other, &other_info).unwrap()
            },
            "the default of an override shows"
        );
    }

    #[test]
    fn unsigned_coordinates_are_kept_in_range_by_unsigned_limits() {
        let (module, info) = parse(
            "@group(0) @binding(0) var<storage, read_write> r: array<f32>;
            @group(0) @binding(1) var t: texture_2d<f32>;
            @compute @workgroup_size(1) fn main(@builtin(global_invocation_id) id: vec3<u32>) {
                r[0] = textureLoad(t, id.xy, 0).x;
            }",
        );
        let disagreeing = |words: &[u32]| {
            let module = rspirv::dr::load_words(words).unwrap();
            let types: BTreeMap<_, _> = module
                .types_global_values
                .iter()
                .map(|of| (of.result_id, (of.class.opcode, of.result_type, of.operands.clone())))
                .collect();
            let vectors = types.values().filter(|(opcode, ..)| *opcode == Op::ConstantComposite);
            vectors
                .flat_map(|(_, ty, parts)| parts.iter().map(move |part| (ty, part)))
                .filter(|(ty, part)| types[&part.id_ref_any()].1 != types[ty].2[0].id_ref_any())
                .count()
        };
        assert_eq!(disagreeing(&write(&module, &info).unwrap()), 0);
        // Negative control: naga alone mixes them.
        assert_ne!(disagreeing(&spv::write_vec(&module, &info, &options(), None).unwrap()), 0);
    }

    #[test]
    fn a_module_that_is_valid_is_left_as_it_is() {
        let (module, info) = parse(
            "@group(0) @binding(0) var<storage, read_write> r: array<f32>;
            @compute @workgroup_size(1) fn main() { r[0] = 1.0; }",
        );
        let raw = spv::write_vec(&module, &info, &options(), None).unwrap();
        assert_eq!(write(&module, &info).unwrap(), raw);
    }

    #[test]
    fn an_override_without_default_is_named() {
        let (module, info) = parse(
            "override steps: u32;
            @group(0) @binding(0) var<storage, read_write> r: array<u32>;
            @compute @workgroup_size(1) fn main() { r[0] = steps; }",
        );
        let error = write(&module, &info).unwrap_err();
        assert!(error.to_string().contains("steps"), "{error}");
    }

    #[test]
    fn spirv_val_accepts_it() {
        let (module, info) = parse(WGSL);
        let file = tempfile::NamedTempFile::new().unwrap();
        std::fs::write(file.path(), bytes(&write(&module, &info).unwrap())).unwrap();
        let validated = std::process::Command::new("spirv-val")
            .args(["--target-env", "vulkan1.1"])
            .arg(file.path())
            .output();
        match validated {
            Ok(output) => assert!(output.status.success(), "{output:?}"),
            Err(_) => eprintln!("skipped: spirv-val is not on PATH"),
        }
    }
}
