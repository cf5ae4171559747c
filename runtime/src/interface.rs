//! What a package says of a variant beside its text: bindings, the layout of structs, overrides.

use std::collections::BTreeMap;

use serde::Deserialize;

use crate::names;

/// What the variants of a manifest refer to by key.
#[derive(Debug, Default, Deserialize)]
pub(crate) struct Shared {
    bindings: BTreeMap<String, Binding>,
    structs: BTreeMap<String, Struct>,
}

/// The keys by which a variant refers to what is shared, and what it has of its own.
#[derive(Debug, Deserialize)]
pub(crate) struct Keys {
    #[serde(default)]
    entry_points: Vec<String>,
    bindings: Vec<String>,
    structs: Vec<String>,
    #[serde(default)]
    overrides: Vec<Override>,
}

impl Shared {
    /// What a variant refers to; the first key that nothing has is the error.
    pub(crate) fn interface(&self, keys: Keys) -> Result<Interface, String> {
        fn all<T: Clone>(table: &BTreeMap<String, T>, keys: Vec<String>) -> Result<Vec<T>, String> {
            let find = |key: String| table.get(&key).cloned().ok_or(key);
            keys.into_iter().map(find).collect()
        }
        Ok(Interface {
            entry_points: keys.entry_points,
            bindings: all(&self.bindings, keys.bindings)?,
            structs: all(&self.structs, keys.structs)?,
            overrides: keys.overrides,
        })
    }
}

/// What a host has to know of a variant to run it: a part of what a package's manifest says of it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Interface {
    /// Names of its entry points.
    pub entry_points: Vec<String>,
    /// What is bound, by group and number.
    pub bindings: Vec<Binding>,
    /// The structs in buffers.
    pub structs: Vec<Struct>,
    /// Numbers that may be set when a pipeline is made.
    pub overrides: Vec<Override>,
}

/// A number that may be set when a pipeline is made.
#[derive(Clone, Debug, PartialEq, Deserialize)]
pub struct Override {
    /// Its name.
    pub name: String,
}

/// What is bound.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(try_from = "Described")]
pub struct Binding {
    /// Number of its bind group.
    pub group: u32,
    /// Its name.
    pub name: String,
    /// Its entry in the layout of the group.
    pub entry: wgpu::BindGroupLayoutEntry,
    /// Of a uniform, the name of its struct.
    pub r#struct: Option<String>,
}

/// A binding as a manifest has it.
#[derive(Deserialize)]
struct Described {
    group: u32,
    binding: u32,
    name: String,
    visibility: Vec<String>,
    #[serde(flatten)]
    kind: Kind,
}

#[derive(Deserialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
enum Kind {
    Uniform { r#type: String, min_size: u64 },
    Storage { access: String, min_size: u64 },
    Texture { dimension: String, sample_type: String, multisampled: bool },
    StorageTexture { dimension: String, format: String, access: String },
    Sampler { sampler_type: String },
}

impl TryFrom<Described> for Binding {
    type Error = String;

    fn try_from(of: Described) -> Result<Self, String> {
        let buffer = |ty, size: u64| wgpu::BindingType::Buffer {
            ty,
            has_dynamic_offset: false,
            min_binding_size: size.try_into().ok(),
        };
        let (mut r#struct, Described { group, binding, name, visibility, kind }) = (None, of);
        let ty = match kind {
            Kind::Uniform { r#type, min_size } => {
                r#struct = Some(r#type);
                buffer(wgpu::BufferBindingType::Uniform, min_size)
            }
            Kind::Storage { access, min_size } => {
                let read_only = access == "read";
                buffer(wgpu::BufferBindingType::Storage { read_only }, min_size)
            }
            Kind::Texture { dimension, sample_type, multisampled } => wgpu::BindingType::Texture {
                sample_type: names::sample_type(&sample_type)?,
                view_dimension: names::dimension(&dimension)?,
                multisampled,
            },
            Kind::StorageTexture { dimension, format, access } => {
                wgpu::BindingType::StorageTexture {
                    access: names::access(&access)?,
                    format: names::texture(&format)?,
                    view_dimension: names::dimension(&dimension)?,
                }
            }
            Kind::Sampler { sampler_type } => {
                wgpu::BindingType::Sampler(names::sampler(&sampler_type)?)
            }
        };
        let visibility = visibility.iter().map(|stage| names::stage(stage)).collect();
        let entry = wgpu::BindGroupLayoutEntry { binding, visibility, ty, count: None };
        Ok(Self { group, name, entry, r#struct })
    }
}
/// A struct in a buffer.
#[derive(Clone, Debug, PartialEq, Deserialize)]
pub struct Struct {
    /// Its name.
    pub name: String,
    /// Bytes, its padding included.
    pub size: u32,
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
    /// The first entry point or binding that a text in WGSL lacks.
    pub(crate) fn missing(&self, text: &str) -> Option<String> {
        let bound = self.bindings.iter().map(|of| (of.group, of.entry.binding, of.name.as_str()));
        sglow_seal::missing(text, &self.entry_points, bound)
    }

    pub(crate) fn find_struct(&self, name: &str) -> Option<&Struct> {
        self.structs.iter().find(|known| known.name == name)
    }

    /// The numbers that a type of a uniform consists of, from a byte on, with its size. Nothing for what a uniform does not
    /// have: halves, atomics, arrays without a length.
    // [WGSL, Section 14.4]: three components are aligned like four, elements of a uniform's arrays to 16 bytes.
    pub(crate) fn places(&self, of: &str, at: u32) -> Option<(Vec<Place>, u32)> {
        if let Some(scalar) = scalar(of) {
            return Some((vec![(at, scalar)], 4));
        }
        if let Some(known) = self.find_struct(of) {
            let mut places = Vec::new();
            for field in &known.fields {
                places.extend(self.places(&field.r#type, at + field.offset)?.0);
            }
            return Some((places, known.size));
        }
        let (name, inner) = of.strip_suffix('>')?.split_once('<')?;
        let (element, count, align) = if let Some(length) = name.strip_prefix("vec") {
            (inner.to_owned(), length.parse().ok().filter(|length| *length <= 4)?, 4)
        } else if let Some(sizes) = name.strip_prefix("mat") {
            let (columns, rows) = sizes.split_once('x')?;
            (format!("vec{rows}<{inner}>"), columns.parse().ok()?, if rows == "2" { 8 } else { 16 })
        } else {
            let (element, length) = inner.rsplit_once(',').filter(|_| name == "array")?;
            (element.trim().to_owned(), length.trim().parse().ok()?, 16)
        };
        let (mut places, mut size) = (Vec::new(), 0);
        for _ in 0..count {
            let (of_element, bytes) = self.places(&element, at + size)?;
            places.extend(of_element);
            size += bytes.next_multiple_of(align);
        }
        Some((places, size))
    }
}

fn scalar(name: &str) -> Option<Scalar> {
    names::find("scalar", &[Scalar::F32, Scalar::U32, Scalar::I32], name).ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_lie_where_wgsl_puts_them() {
        let field =
            |name: &str, of: &str, offset| Field { name: name.into(), r#type: of.into(), offset };
        let fields = vec![field("a", "vec3<f32>", 0), field("b", "u32", 12)];
        let structs = vec![Struct { name: "Pair".to_owned(), size: 16, fields }];
        let interface = Interface { structs, ..Interface::default() };
        let offsets = |of: &str| {
            let (places, size) = interface.places(of, 32).unwrap();
            (places.into_iter().map(|place| place.0).collect::<Vec<_>>(), size)
        };
        assert_eq!(offsets("f32"), (vec![32], 4));
        assert_eq!(offsets("vec3<u32>"), (vec![32, 36, 40], 12));
        assert_eq!(offsets("mat2x3<f32>"), (vec![32, 36, 40, 48, 52, 56], 32));
        assert_eq!(offsets("array<vec3<f32>, 2>"), (vec![32, 36, 40, 48, 52, 56], 32));
        assert_eq!(offsets("array<mat2x2<f32>, 2>").0, [32, 36, 40, 44, 48, 52, 56, 60]);
        assert_eq!(offsets("array<Pair, 2>").0, [32, 36, 40, 44, 48, 52, 56, 60]);
        assert_eq!(interface.places("Pair", 0).unwrap().0[3], (12, Scalar::U32));
        for unknown in ["f16", "array<f32>", "vec5<f32>", "Other", "atomic<u32>"] {
            assert_eq!(interface.places(unknown, 0), None, "{unknown}");
        }
    }
}
