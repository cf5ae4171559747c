//! naga's verdict on a finished text.

use std::collections::BTreeSet;
use std::error::Error;

use naga::front::wgsl::{Frontend, Options};
use naga::valid::{
    Capabilities, ModuleInfo, ShaderStages, SubgroupOperationSet, ValidationFlags, Validator,
};

use crate::assemble::{Omitted, Text};
use crate::error::{Code, Diagnostic};
use crate::matrix::Variant;

/// A variant that is finished: pruned, proved equal to what it was pruned from, and valid.
#[derive(Clone, Debug)]
pub struct Validated {
    /// What it is.
    pub variant: Variant,
    /// The final WGSL, whole and commented.
    pub text: String,
    /// naga's representation of [`Validated::text`].
    pub module: naga::Module,
    /// naga's analysis of [`Validated::module`].
    pub info: ModuleInfo,
    /// Declarations of the library's modules that the text lacks, sorted by name.
    pub omitted: Vec<Omitted>,
}

/// WebGPU's features, with what each lets a shader do; most concern the host alone.
const FEATURES: [(&str, Capabilities); 22] = [
    ("bgra8unorm-storage", Capabilities::empty()),
    ("clip-distances", Capabilities::CLIP_DISTANCES),
    ("core-features-and-limits", Capabilities::empty()),
    ("depth-clip-control", Capabilities::empty()),
    ("depth32float-stencil8", Capabilities::empty()),
    ("dual-source-blending", Capabilities::DUAL_SOURCE_BLENDING),
    ("float32-blendable", Capabilities::empty()),
    ("float32-filterable", Capabilities::empty()),
    ("indirect-first-instance", Capabilities::empty()),
    ("primitive-index", Capabilities::PRIMITIVE_INDEX),
    ("rg11b10ufloat-renderable", Capabilities::empty()),
    ("shader-f16", Capabilities::SHADER_FLOAT16),
    ("subgroups", Capabilities::SUBGROUP.union(Capabilities::SUBGROUP_BARRIER)),
    ("texture-component-swizzle", Capabilities::empty()),
    ("texture-compression-astc", Capabilities::empty()),
    ("texture-compression-astc-sliced-3d", Capabilities::empty()),
    ("texture-compression-bc", Capabilities::empty()),
    ("texture-compression-bc-sliced-3d", Capabilities::empty()),
    ("texture-compression-etc2", Capabilities::empty()),
    ("texture-formats-tier1", Capabilities::STORAGE_TEXTURE_16BIT_NORM_FORMATS),
    ("texture-formats-tier2", Capabilities::empty()),
    ("timestamp-query", Capabilities::empty()),
];

/// What every WebGPU device lets a shader do.
const CORE: Capabilities = Capabilities::CUBE_ARRAY_TEXTURES
    .union(Capabilities::MULTISAMPLED_SHADING)
    .union(Capabilities::SHADER_FLOAT16_IN_FLOAT32);

/// Names of WebGPU's features, sorted.
pub fn features() -> impl Iterator<Item = &'static str> {
    FEATURES.iter().map(|(name, _)| *name)
}

pub(crate) fn is_feature(name: &str) -> bool {
    features().any(|known| known == name)
}

/// What shaders may do on devices that have WebGPU's features `requires`.
fn capabilities(requires: &BTreeSet<&str>) -> Capabilities {
    let required = FEATURES.iter().filter(|(name, _)| requires.contains(name));
    required.fold(CORE, |all, (_, one)| all | *one)
}

/// A validator for devices that have WebGPU's features `requires`.
#[must_use]
pub fn validator(requires: &BTreeSet<&str>) -> Validator {
    let mut validator = Validator::new(ValidationFlags::all(), capabilities(requires));
    if requires.contains("subgroups") {
        validator
            .subgroup_stages(ShaderStages::FRAGMENT | ShaderStages::COMPUTE)
            .subgroup_operations(SubgroupOperationSet::all());
    }
    validator
}

/// Reads `text` and validates it.
pub(crate) fn validate(
    text: &Text,
    requires: &BTreeSet<&str>,
) -> Result<(naga::Module, ModuleInfo), Box<Diagnostic>> {
    let options = Options { capabilities: capabilities(requires), ..Options::new() };
    let mut frontend = Frontend::new_with_options(options);
    let module = frontend.parse(&text.text).map_err(|error| {
        let mut diagnostic = Diagnostic::new(Code::Wgsl, error.message());
        for (span, label) in error.labels() {
            mark(&mut diagnostic, text, span, label);
        }
        diagnostic.help.extend(error.notes().map(str::to_owned));
        Box::new(diagnostic)
    })?;
    let info = validator(requires).validate(&module).map_err(|error| {
        let mut diagnostic = Diagnostic::new(Code::Invalid, error.as_inner().to_string());
        for (span, label) in error.spans() {
            mark(&mut diagnostic, text, *span, label);
        }
        // The innermost place first.
        diagnostic.labels.sort_by_key(|(span, _)| span.end - span.start);
        let mut source = error.as_inner().source();
        while let Some(cause) = source {
            diagnostic.help.push(cause.to_string());
            source = cause.source();
        }
        Box::new(diagnostic)
    })?;
    Ok((module, info))
}

fn mark(diagnostic: &mut Diagnostic, text: &Text, span: naga::Span, label: &str) {
    if let Some(origin) = span.to_range().and_then(|range| text.origin(range)) {
        diagnostic.labels.push((origin, label.to_owned()));
    }
}
