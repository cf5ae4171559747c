//! SPIR-V 1.3 of a validated module, in a form that recent validators accept too.
//!
//! Two mistakes of naga's back end are repaired in its words, each in a file of its own that names the issue.

mod error;
mod signs;
mod workgroup;

use naga::back::pipeline_constants::process_overrides;
use naga::back::spv;
use naga::proc::{BoundsCheckPolicies, BoundsCheckPolicy};
use naga::valid::{Capabilities, ModuleInfo, ValidationFlags, Validator};
use rspirv::binary::Assemble;

pub use self::error::Error;
use self::signs::agree_on_signs;
use self::workgroup::without_workgroup_layout;

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
/// - Workgroup memory is not zeroed, which naga has one invocation do for whole arrays: entry points write what they read.
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
        zero_initialize_workgroup_memory: spv::ZeroInitializeWorkgroupMemoryMode::None,
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

#[cfg(test)]
mod tests {
    use std::collections::{BTreeMap, BTreeSet};

    use rspirv::spirv::{StorageClass, Word};

    use rspirv::dr::Operand;
    use rspirv::spirv::Op;

    use super::workgroup::{Types, pointer};
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
    fn workgroup_memory_is_not_zeroed() {
        // Stores of a constant of zeros to a variable of workgroup memory.
        let zeroed = |words: &[u32]| {
            let module = rspirv::dr::load_words(words).unwrap();
            let of = |opcode: Op| {
                let all = module.types_global_values.iter();
                all.filter(move |one| one.class.opcode == opcode)
            };
            let nulls: BTreeSet<_> = of(Op::ConstantNull).filter_map(|one| one.result_id).collect();
            let class = Operand::StorageClass(StorageClass::Workgroup);
            let variables = of(Op::Variable).filter(|one| one.operands.contains(&class));
            let variables: BTreeSet<_> = variables.filter_map(|one| one.result_id).collect();
            let stores = module.all_inst_iter().filter(|one| one.class.opcode == Op::Store);
            stores
                .filter(|one| {
                    variables.contains(&one.operands[0].unwrap_id_ref())
                        && nulls.contains(&one.operands[1].unwrap_id_ref())
                })
                .count()
        };
        let (module, info) = parse(WGSL);
        assert_eq!(zeroed(&write(&module, &info).unwrap()), 0);
        // Negative control: the back end's default.
        let (module, info) = parse(&WGSL.replace("override", "const"));
        let zeroing = spv::Options {
            zero_initialize_workgroup_memory: spv::ZeroInitializeWorkgroupMemoryMode::Polyfill,
            ..options()
        };
        assert_eq!(zeroed(&spv::write_vec(&module, &info, &zeroing, None).unwrap()), 3);
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
