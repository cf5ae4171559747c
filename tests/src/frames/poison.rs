//! Workgroup memory that is not zero when a workgroup begins.

use std::fmt::Write as _;

use naga::{AddressSpace, Handle, Module, ScalarKind, Type, TypeInner};
use sglow_runtime::package::Package;

/// What the bits of a number are that nothing has written: NaN as a float.
const BITS: &str = "0xffffffffu";

/// A package whose entry points begin by filling their workgroup memory with [`BITS`], and the passes that have any.
pub(super) fn poisoned(package: &Package) -> (Package, Vec<String>) {
    let (mut all, mut passes) = (package.clone(), Vec::new());
    let ids: Vec<String> = package.variants().map(str::to_owned).collect();
    for id in ids {
        let text = package.text(&id).unwrap();
        if text.contains("var<workgroup>") {
            all = all.with_text(&id, poison(text));
            passes.extend(id.split('-').next().map(str::to_owned));
        }
    }
    passes.sort();
    passes.dedup();
    (all, passes)
}

/// A text whose entry point fills its workgroup memory first: each invocation all of it, with the same bits.
fn poison(text: &str) -> String {
    let module = naga::front::wgsl::parse_str(text).unwrap();
    let mut body = String::new();
    for (_, variable) in module.global_variables.iter() {
        if variable.space == AddressSpace::WorkGroup {
            fill(&module, variable.ty, variable.name.as_deref().unwrap(), 0, &mut body);
        }
    }
    body.push_str("    workgroupBarrier();\n");
    let head = text.find("@compute").unwrap();
    let begin = head + text[head..].find(") {\n").unwrap() + ") {\n".len();
    format!("{}{body}{}", &text[..begin], &text[begin..])
}

/// Statements that fill what is at a path.
fn fill(module: &Module, ty: Handle<Type>, path: &str, depth: usize, into: &mut String) {
    match &module.types[ty].inner {
        TypeInner::Scalar(scalar) => {
            let value = value(scalar.kind);
            writeln!(into, "    {path} = {value};").unwrap();
        }
        TypeInner::Vector { size, scalar } => {
            for component in ["x", "y", "z", "w"].iter().take(*size as usize) {
                let value = value(scalar.kind);
                writeln!(into, "    {path}.{component} = {value};").unwrap();
            }
        }
        TypeInner::Atomic(_) => writeln!(into, "    atomicStore(&{path}, {BITS});").unwrap(),
        TypeInner::Array { base, size: naga::ArraySize::Constant(count), .. } => {
            let at = format!("poison_{depth}_at");
            let head = format!("for (var {at} = 0u; {at} < {count}u; {at} += 1u) {{");
            writeln!(into, "    {head}").unwrap();
            fill(module, *base, &format!("{path}[{at}]"), depth + 1, into);
            writeln!(into, "    }}").unwrap();
        }
        TypeInner::Struct { members, .. } => {
            for member in members {
                let path = format!("{path}.{}", member.name.as_deref().unwrap());
                fill(module, member.ty, &path, depth, into);
            }
        }
        other => panic!("no poison for {other:?}"),
    }
}

/// The bits as a number, not known before the shader runs: WGSL has no constant that is NaN.
fn value(kind: ScalarKind) -> String {
    match kind {
        ScalarKind::Bool => "true".to_owned(),
        ScalarKind::Float => format!("bitcast<f32>({BITS} ^ (lane & 0u))"),
        _ => BITS.to_owned(),
    }
}
