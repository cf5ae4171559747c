//! From a variant that is finished to what a manifest says of it.

use std::collections::BTreeMap;

use super::layout::structs;
use super::{Binding, Cost, EntryPoint, File, Override, Reflection, Requires, Struct};
use crate::library::Library;
use crate::validate::Validated;

/// All that a manifest says of a variant, before what it shares with others is put in one place.
#[derive(Clone, Debug, PartialEq)]
pub struct Described {
    /// Pass and values joined by `-`.
    pub id: String,
    /// Name of its pass.
    pub pass: String,
    /// The value on each axis.
    pub axes: BTreeMap<String, String>,
    /// Its entry points.
    pub entry_points: Vec<EntryPoint>,
    /// The static operations that each of them reaches, by its name.
    pub cost: BTreeMap<String, Cost>,
    /// What it binds, by group and number.
    pub bindings: Vec<Binding>,
    /// The structs in its buffers, each after those within it.
    pub structs: Vec<Struct>,
    /// Numbers that may be set when a pipeline is made.
    pub overrides: Vec<Override>,
    /// What a device must have.
    pub requires: Requires,
    /// Units and ranges of its inputs, one `name: text` each.
    pub contract: Vec<String>,
    /// Where it is written.
    pub files: Vec<File>,
}

/// Describes a variant. Its files are those of `files`.
///
/// # Errors
///
/// When it binds a resource of a kind that the manifest cannot describe.
pub fn variant(
    library: &Library,
    validated: &Validated,
    reflection: &Reflection,
    files: Vec<File>,
) -> Described {
    let variant = &validated.variant;
    let values = variant.values.iter().filter_map(|(axis, value)| {
        library.axis.get(axis)?.value.iter().find(|known| known.name == *value)
    });
    let mut features = reflection.features.clone();
    features.extend(values.flat_map(|value| value.requires.iter().cloned()));
    Described {
        id: variant.id(),
        pass: variant.pass.clone(),
        axes: variant.values.iter().cloned().collect(),
        entry_points: reflection.entry_points.clone(),
        cost: reflection.cost.clone(),
        bindings: reflection.bindings.clone(),
        structs: structs(&reflection.layouts),
        overrides: overrides(library, validated),
        requires: Requires {
            features,
            limits_beyond_default: reflection
                .limits
                .iter()
                .filter(|(name, needed)| default_limit(name).is_some_and(|limit| **needed > limit))
                .map(|(name, _)| name.clone())
                .collect(),
            limits: reflection.limits.clone(),
        },
        contract: library.contract_of(variant),
        files,
    }
}

/// What every WebGPU device grants. [WebGPU, Section 3.6.2]
fn default_limit(name: &str) -> Option<u64> {
    Some(match name {
        "maxBindGroups" => 4,
        "maxUniformBuffersPerShaderStage" => 12,
        "maxStorageBuffersPerShaderStage" => 8,
        "maxSampledTexturesPerShaderStage" | "maxSamplersPerShaderStage" => 16,
        "maxStorageTexturesPerShaderStage" => 4,
        "maxComputeWorkgroupStorageSize" => 16384,
        "maxComputeInvocationsPerWorkgroup"
        | "maxComputeWorkgroupSizeX"
        | "maxComputeWorkgroupSizeY" => 256,
        "maxComputeWorkgroupSizeZ" => 64,
        _ => return None,
    })
}

fn overrides(library: &Library, validated: &Validated) -> Vec<Override> {
    use naga::common::wgsl::TryToWgsl;
    let module = &validated.module;
    let declared = library
        .pass
        .iter()
        .filter(|pass| pass.name == validated.variant.pass)
        .flat_map(|pass| &pass.overrides);
    let declared: Vec<_> = declared.collect();
    let mut overrides: Vec<_> = module
        .overrides
        .iter()
        .map(|(_, found)| {
            let name = found.name.clone().unwrap_or_default();
            let bare = name.strip_prefix(&library.library.prefix).unwrap_or(&name);
            let declared = declared.iter().find(|known| known.name == name || known.name == bare);
            let literal = found.init.and_then(|init| literal(module, init));
            Override {
                // A pipeline's constants go by `@id` where there is one.
                name: found.id.map_or(name, |id| id.to_string()),
                r#type: module.types[found.ty]
                    .inner
                    .scalar()
                    .and_then(TryToWgsl::try_to_wgsl)
                    .unwrap_or("unknown")
                    .to_owned(),
                default: literal.and_then(number),
                minimum: declared.and_then(|known| tidy(known.minimum)),
                maximum: declared.and_then(|known| tidy(known.maximum)),
                description: declared.map(|known| known.description.clone()).unwrap_or_default(),
            }
        })
        .collect();
    overrides.sort_by(|a, b| a.name.cmp(&b.name));
    overrides
}

/// The value of an expression at module scope; none where it depends on another override.
fn literal(module: &naga::Module, init: naga::Handle<naga::Expression>) -> Option<naga::Literal> {
    match module.global_expressions[init] {
        naga::Expression::Literal(literal) => Some(literal),
        naga::Expression::Constant(constant) => literal(module, module.constants[constant].init),
        naga::Expression::ZeroValue(ty) => naga::Literal::zero(module.types[ty].inner.scalar()?),
        _ => None,
    }
}

fn number(literal: naga::Literal) -> Option<serde_json::Number> {
    use naga::Literal;
    match literal {
        Literal::F64(value) => tidy(value),
        // The shortest decimal that reads back as the same f32.
        Literal::F32(value) => value.to_string().parse().ok().and_then(tidy),
        Literal::F16(value) => tidy(f64::from(value.to_f32())),
        Literal::U16(value) => Some(value.into()),
        Literal::I16(value) => Some(value.into()),
        Literal::U32(value) => Some(value.into()),
        Literal::I32(value) => Some(value.into()),
        Literal::U64(value) => Some(value.into()),
        Literal::I64(value) | Literal::AbstractInt(value) => Some(value.into()),
        Literal::AbstractFloat(value) => tidy(value),
        Literal::Bool(value) => Some(u32::from(value).into()),
    }
}

/// A number without a fraction is written without one.
fn tidy(value: f64) -> Option<serde_json::Number> {
    const EXACT: f64 = 9_007_199_254_740_992.0;
    if value.fract() == 0.0 && value.abs() <= EXACT {
        Some((value as i64).into())
    } else {
        serde_json::Number::from_f64(value)
    }
}
