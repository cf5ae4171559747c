//! The memory layout of what lies in buffers.

use std::fmt;
use std::sync::Arc;

use naga::common::wgsl::TryToWgsl;
use naga::{Scalar, VectorSize};

use super::{Field, Struct};

/// The memory layout of a struct.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Layout {
    /// Its name in the text.
    pub name: String,
    /// What it is, from its doc comment.
    pub description: String,
    /// Bytes, its padding included; with one element of a runtime-sized array.
    pub size: u32,
    /// Alignment in bytes.
    pub align: u32,
    /// Its fields.
    pub fields: Vec<LayoutField>,
}

/// A field of a [`Layout`].
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct LayoutField {
    /// Its name in the text.
    pub name: String,
    /// What it is, from its doc comment.
    pub description: String,
    /// Bytes from the start of the struct.
    pub offset: u32,
    /// Bytes; those of one element for a runtime-sized array.
    pub size: u32,
    /// Its type.
    pub r#type: FieldType,
}

/// The type of something in a buffer.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum FieldType {
    /// A number.
    Scalar(Scalar),
    /// A number that is changed atomically.
    Atomic(Scalar),
    /// Two to four numbers.
    Vector(VectorSize, Scalar),
    /// Columns of vectors.
    Matrix {
        /// How many columns.
        columns: VectorSize,
        /// How many numbers each has.
        rows: VectorSize,
        /// Of which kind.
        scalar: Scalar,
    },
    /// Elements of one type.
    Array {
        /// Their type.
        element: Box<Self>,
        /// How many; as many as the buffer holds if absent.
        length: Option<u32>,
        /// Bytes from one to the next.
        stride: u32,
    },
    /// A struct.
    Struct(Arc<Layout>),
}

impl FieldType {
    /// The layouts of the structs within, the innermost first.
    pub fn layouts(&self, into: &mut Vec<Arc<Layout>>) {
        match self {
            Self::Array { element, .. } => element.layouts(into),
            Self::Struct(layout) if !into.contains(layout) => {
                for field in &layout.fields {
                    field.r#type.layouts(into);
                }
                into.push(Arc::clone(layout));
            }
            _ => {}
        }
    }

    /// Bytes from one element to the next of an array.
    #[must_use]
    pub fn stride(&self) -> Option<u32> {
        match self {
            Self::Array { stride, .. } => Some(*stride),
            _ => None,
        }
    }
}

/// As WGSL spells it.
impl fmt::Display for FieldType {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let name = |scalar: &Scalar| scalar.try_to_wgsl().unwrap_or("unknown");
        match self {
            Self::Scalar(scalar) => f.write_str(name(scalar)),
            Self::Atomic(scalar) => write!(f, "atomic<{}>", name(scalar)),
            Self::Vector(size, scalar) => write!(f, "vec{}<{}>", *size as u8, name(scalar)),
            Self::Matrix { columns, rows, scalar } => {
                write!(f, "mat{}x{}<{}>", *columns as u8, *rows as u8, name(scalar))
            }
            Self::Array { element, length: Some(length), .. } => {
                write!(f, "array<{element}, {length}>")
            }
            Self::Array { element, length: None, .. } => write!(f, "array<{element}>"),
            Self::Struct(layout) => f.write_str(&layout.name),
        }
    }
}

/// The structs of a [`super::Reflection`] as a manifest names them.
pub(super) fn structs(layouts: &[Arc<Layout>]) -> Vec<Struct> {
    layouts
        .iter()
        .map(|layout| Struct {
            name: layout.name.clone(),
            description: layout.description.clone(),
            size: layout.size,
            align: layout.align,
            fields: layout
                .fields
                .iter()
                .map(|field| Field {
                    name: field.name.clone(),
                    description: field.description.clone(),
                    r#type: field.r#type.to_string(),
                    offset: field.offset,
                    size: field.size,
                    stride: field.r#type.stride(),
                })
                .collect(),
        })
        .collect()
}
