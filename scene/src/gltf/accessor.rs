//! Accessors: typed elements from the bytes of buffer views.

use gltf::accessor::DataType;
use gltf::accessor::sparse::IndexType;

use super::buffer::Views;

/// The most elements of an accessor without data, which would cost memory for nothing.
const MOST_ZEROS: usize = 1 << 24;

/// Vectors of `N` components, or of more, of which the first `N` are taken. Normalised integers are
/// unpacked; other integers are converted (`KHR_mesh_quantization`).
pub(super) fn vectors<const N: usize>(
    views: &Views<'_>,
    accessor: &gltf::Accessor<'_>,
) -> Result<Vec<[f32; N]>, String> {
    let components = accessor.dimensions().multiplicity();
    if components != N {
        return Err(format!("has {components} components, not {N}"));
    }
    let bytes = elements(views, accessor)?;
    let kind = accessor.data_type();
    let size = kind.size();
    let normalized = accessor.normalized();
    let read = |at: usize| component(kind, normalized, &bytes[at..at + size]);
    Ok((0..accessor.count())
        .map(|element| std::array::from_fn(|i| read((element * N + i) * size)))
        .collect())
}

/// Indices of vertices.
pub(super) fn indices(
    views: &Views<'_>,
    accessor: &gltf::Accessor<'_>,
) -> Result<Vec<u32>, String> {
    if accessor.dimensions() != gltf::accessor::Dimensions::Scalar {
        return Err("indices must be scalars".to_owned());
    }
    let kind = accessor.data_type();
    if !matches!(kind, DataType::U8 | DataType::U16 | DataType::U32) {
        return Err(format!("indices must be unsigned, not {kind:?}"));
    }
    let bytes = elements(views, accessor)?;
    Ok(bytes.chunks_exact(kind.size()).map(unsigned).collect())
}

/// The elements without gaps, with sparse ones put in.
fn elements(views: &Views<'_>, accessor: &gltf::Accessor<'_>) -> Result<Vec<u8>, String> {
    let (count, size) = (accessor.count(), accessor.size());
    let mut elements = match accessor.view() {
        Some(view) => {
            let stride = view.stride().unwrap_or(size);
            gather(views.get(view.index())?, accessor.offset(), count, size, stride)?
        }
        None if count <= MOST_ZEROS => vec![0; count * size],
        None => return Err(format!("has {count} elements without data")),
    };
    if let Some(sparse) = accessor.sparse() {
        let (indices, values) = (sparse.indices(), sparse.values());
        let width = match indices.index_type() {
            IndexType::U8 => 1,
            IndexType::U16 => 2,
            IndexType::U32 => 4,
        };
        let replaced = gather(
            views.get(indices.view().index())?,
            indices.offset(),
            sparse.count(),
            width,
            width,
        )?;
        let values =
            gather(views.get(values.view().index())?, values.offset(), sparse.count(), size, size)?;
        for (index, value) in replaced.chunks_exact(width).zip(values.chunks_exact(size)) {
            let at = unsigned(index) as usize * size;
            elements
                .get_mut(at..at + size)
                .ok_or_else(|| format!("sparse element {} is out of range", at / size))?
                .copy_from_slice(value);
        }
    }
    Ok(elements)
}

/// `count` elements of `size` bytes that lie `stride` apart.
fn gather(
    bytes: &[u8],
    offset: usize,
    count: usize,
    size: usize,
    stride: usize,
) -> Result<Vec<u8>, String> {
    if count == 0 {
        return Ok(Vec::new());
    }
    let end = (count - 1)
        .checked_mul(stride)
        .and_then(|start| start.checked_add(offset))
        .and_then(|start| start.checked_add(size));
    match end {
        Some(end) if end <= bytes.len() && stride >= size => {
            let starts = (0..count).map(|i| offset + i * stride);
            Ok(starts.flat_map(|at| &bytes[at..at + size]).copied().collect())
        }
        _ if stride < size => Err(format!("the stride of {stride} is below {size} bytes")),
        _ => Err(format!(
            "{count} elements of {size} bytes from byte {offset} do not fit in the {} bytes of the \
             buffer view",
            bytes.len()
        )),
    }
}

/// A little-endian unsigned number of up to 4 bytes.
fn unsigned(bytes: &[u8]) -> u32 {
    bytes.iter().rev().fold(0, |value, &byte| value << 8 | u32::from(byte))
}

/// One component. [glTF 2.0, section 3.11 on normalised integers]
fn component(kind: DataType, normalized: bool, bytes: &[u8]) -> f32 {
    let bits = unsigned(bytes);
    let (value, largest) = match kind {
        DataType::I8 => (f32::from(bits as i8), 127.0),
        DataType::U8 => (f32::from(bits as u8), 255.0),
        DataType::I16 => (f32::from(bits as i16), 32767.0),
        DataType::U16 => (f32::from(bits as u16), 65535.0),
        DataType::U32 => return bits as f32,
        DataType::F32 => return f32::from_bits(bits),
    };
    if normalized { (value / largest).max(-1.0) } else { value }
}
