//! What a package says of a variant beside its text: entry points, bindings, the layout of structs, overrides.

use std::collections::BTreeMap;

use serde::Deserialize;

/// What the variants of a manifest refer to by key.
#[derive(Debug, Default, Deserialize)]
pub(crate) struct Shared {
    entry_points: BTreeMap<String, EntryPoint>,
    bindings: BTreeMap<String, Binding>,
    structs: BTreeMap<String, Struct>,
}

/// The keys by which a variant refers to what is shared, and what it has of its own.
#[derive(Debug, Deserialize)]
pub(crate) struct Keys {
    entry_points: Vec<String>,
    bindings: Vec<String>,
    structs: Vec<String>,
    #[serde(default)]
    overrides: Vec<Named>,
}

impl Shared {
    /// What a variant refers to; the first key that nothing has is the error.
    pub(crate) fn interface(&self, keys: Keys) -> Result<Interface, String> {
        fn all<T: Clone>(table: &BTreeMap<String, T>, keys: Vec<String>) -> Result<Vec<T>, String> {
            let find = |key: String| table.get(&key).cloned().ok_or(key);
            keys.into_iter().map(find).collect()
        }
        Ok(Interface {
            entry_points: all(&self.entry_points, keys.entry_points)?,
            bindings: all(&self.bindings, keys.bindings)?,
            structs: all(&self.structs, keys.structs)?,
            overrides: keys.overrides,
        })
    }
}

/// What a host has to know of a variant to run it: a part of what a package's manifest says of it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Interface {
    /// Functions that pipelines start in.
    pub entry_points: Vec<EntryPoint>,
    /// What is bound, by group and number.
    pub bindings: Vec<Binding>,
    /// The structs in buffers.
    pub structs: Vec<Struct>,
    /// Numbers that may be set when a pipeline is made.
    pub overrides: Vec<Named>,
}

/// A function that a pipeline starts in.
#[derive(Clone, Debug, PartialEq, Deserialize)]
pub struct EntryPoint {
    /// Its name.
    pub name: String,
    /// Its stage.
    pub stage: Stage,
}

/// A stage of a pipeline.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
#[expect(missing_docs, reason = "the stages of WebGPU")]
pub enum Stage {
    Vertex,
    Fragment,
    Compute,
    Other,
}

/// Something that has a name.
#[derive(Clone, Debug, PartialEq, Deserialize)]
pub struct Named {
    /// The name.
    pub name: String,
}

/// What is bound.
#[derive(Clone, Debug, PartialEq, Deserialize)]
pub struct Binding {
    /// Number of its bind group.
    pub group: u32,
    /// Its number within the group.
    pub binding: u32,
    /// Its name.
    pub name: String,
    /// The stages that use it.
    pub visibility: Vec<Stage>,
    /// What it is.
    #[serde(flatten)]
    pub kind: Kind,
}

/// What a binding is, in the words of WebGPU.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
#[expect(missing_docs, reason = "the members are those of WebGPU's layouts")]
pub enum Kind {
    Uniform { r#type: String, min_size: u64 },
    Storage { access: Access, min_size: u64 },
    Texture { dimension: String, sample_type: SampleType, multisampled: bool },
    StorageTexture { dimension: String, format: String, access: Access },
    Sampler { sampler_type: SamplerType },
}

/// What is done with a buffer or a texture.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
#[expect(missing_docs, reason = "said by the names")]
pub enum Access {
    Read,
    Write,
    ReadWrite,
}

/// What the texels of a texture give.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[expect(missing_docs, reason = "the types of WebGPU")]
pub enum SampleType {
    Float,
    UnfilterableFloat,
    Depth,
    Sint,
    Uint,
}

/// What a sampler does.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[expect(missing_docs, reason = "the types of WebGPU")]
pub enum SamplerType {
    Filtering,
    Comparison,
}

/// A struct in a buffer.
#[derive(Clone, Debug, PartialEq, Deserialize)]
pub struct Struct {
    /// Its name.
    pub name: String,
    /// Bytes, its padding included.
    pub size: u32,
    /// Alignment in bytes.
    pub align: u32,
    /// Its members.
    pub fields: Vec<Field>,
}

/// A member of a struct.
#[derive(Clone, Debug, PartialEq, Deserialize)]
pub struct Field {
    /// Its name.
    pub name: String,
    /// Its type in WGSL.
    pub r#type: String,
    /// Bytes from the start of the struct.
    pub offset: u32,
}

/// A number of 32 bits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[expect(missing_docs, reason = "the types of WGSL")]
pub enum Scalar {
    F32,
    U32,
    I32,
}

/// Where a number lies: bytes from the start of a uniform, and its type.
pub(crate) type Place = (u32, Scalar);

impl Interface {
    pub(crate) fn find_struct(&self, name: &str) -> Option<&Struct> {
        self.structs.iter().find(|known| known.name == name)
    }

    /// The numbers that a type consists of, from a byte on, with its size and its alignment. Nothing for what a uniform
    /// does not have: halves, atomics, arrays without a length.
    pub(crate) fn places(&self, of: &str, at: u32) -> Option<(Vec<Place>, u32, u32)> {
        if let Some(scalar) = scalar(of) {
            return Some((vec![(at, scalar)], 4, 4));
        }
        if let Some(known) = self.find_struct(of) {
            let mut places = Vec::new();
            for field in &known.fields {
                places.extend(self.places(&field.r#type, at + field.offset)?.0);
            }
            return Some((places, known.size, known.align));
        }
        let (name, inner) = of.strip_suffix('>')?.split_once('<')?;
        if let Some(length) = name.strip_prefix("vec") {
            return vector(length.parse().ok()?, scalar(inner)?, at);
        }
        let (element, count) = if let Some(sizes) = name.strip_prefix("mat") {
            let (columns, rows) = sizes.split_once('x')?;
            (format!("vec{rows}<{inner}>"), columns.parse().ok()?)
        } else if name == "array" {
            let (element, length) = inner.rsplit_once(',')?;
            (element.trim().to_owned(), length.trim().parse().ok()?)
        } else {
            return None;
        };
        let (mut places, mut stride, mut align) = (Vec::new(), 0, 4);
        for index in 0..count {
            let size;
            let of_element;
            (of_element, size, align) = self.places(&element, at + index * stride)?;
            // The first element is at 0 whatever the stride is.
            stride = size.next_multiple_of(align);
            places.extend(of_element);
        }
        Some((places, count * stride, align))
    }
}

/// [WGSL, Section 14.4.1]: three components are aligned like four.
fn vector(length: u32, scalar: Scalar, at: u32) -> Option<(Vec<Place>, u32, u32)> {
    let align = match length {
        2 => 8,
        3 | 4 => 16,
        _ => return None,
    };
    Some(((0..length).map(|index| (at + 4 * index, scalar)).collect(), 4 * length, align))
}

fn scalar(name: &str) -> Option<Scalar> {
    Some(match name {
        "f32" => Scalar::F32,
        "u32" => Scalar::U32,
        "i32" => Scalar::I32,
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_lie_where_wgsl_puts_them() {
        let field =
            |name: &str, of: &str, offset| Field { name: name.into(), r#type: of.into(), offset };
        let fields = vec![field("a", "vec3<f32>", 0), field("b", "u32", 12)];
        let structs = vec![Struct { name: "Pair".to_owned(), size: 16, align: 16, fields }];
        let interface = Interface { structs, ..Interface::default() };
        let offsets = |of: &str| {
            let (places, size, align) = interface.places(of, 32).unwrap();
            (places.into_iter().map(|place| place.0).collect::<Vec<_>>(), size, align)
        };
        assert_eq!(offsets("f32"), (vec![32], 4, 4));
        assert_eq!(offsets("vec3<u32>"), (vec![32, 36, 40], 12, 16));
        assert_eq!(offsets("mat2x3<f32>"), (vec![32, 36, 40, 48, 52, 56], 32, 16));
        assert_eq!(offsets("array<vec3<f32>, 2>"), (vec![32, 36, 40, 48, 52, 56], 32, 16));
        assert_eq!(offsets("array<mat2x2<f32>, 2>").0, [32, 36, 40, 44, 48, 52, 56, 60]);
        assert_eq!(offsets("array<Pair, 2>").0, [32, 36, 40, 44, 48, 52, 56, 60]);
        assert_eq!(interface.places("Pair", 0).unwrap().0[3], (12, Scalar::U32));
        for unknown in ["f16", "array<f32>", "vec5<f32>", "Other", "atomic<u32>"] {
            assert_eq!(interface.places(unknown, 0), None, "{unknown}");
        }
    }
}
