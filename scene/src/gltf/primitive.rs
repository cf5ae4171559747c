//! Primitives of meshes: what their accessors hold, and which textures can be read at their texture coordinates.

use std::cell::OnceCell;

use glam::{DMat3, DMat4, DVec3};
use gltf::accessor::DataType;
use gltf::mesh::{Mode, Semantic};

use super::accessor;
use super::buffer::Views;
use super::material::{self, Converted};
use crate::draft::Draft;
use crate::files::Files;
use crate::mesh::RawMesh;
use crate::note::NoteKind;
use crate::origin::power_of_two;
use crate::tint;
use crate::{Detail, Material, SceneError, TextureUse, UvTransform};

/// How far texture coordinates may lie from a scaled and moved other set, in image sizes: a hundredth of a texel of the
/// largest textures.
const SAME_PLACE: f32 = 1e-6;

/// Reads a primitive, to be placed by a transform. None where there is nothing to draw. `copies` is how often it will
/// be placed.
pub(super) fn read(
    files: &Files<'_>,
    views: &Views<'_>,
    materials: &[Converted],
    name: String,
    primitive: &gltf::Primitive<'_>,
    copies: usize,
    draft: &mut Draft,
) -> Result<Option<RawMesh>, SceneError> {
    if matches!(primitive.mode(), Mode::Points | Mode::Lines | Mode::LineLoop | Mode::LineStrip) {
        draft.notes.add(NoteKind::Ignored, "points and lines", name);
        return Ok(None);
    }
    let Some(positions) = primitive.get(&Semantic::Positions) else {
        draft.notes.add(NoteKind::Ignored, "mesh without positions", name);
        return Ok(None);
    };
    if primitive.morph_targets().len() > 0 {
        draft.notes.add(NoteKind::Ignored, "morph targets: the mesh keeps its shape", &name);
    }
    let count = positions.count();
    let corners = primitive.indices().map_or(count, |indices| indices.count());
    let triangles = match primitive.mode() {
        Mode::TriangleStrip | Mode::TriangleFan => corners.saturating_sub(2),
        _ => corners / 3,
    };
    let limits = &files.options.limits;
    let [vertices, triangles] = [count, triangles].map(|number| number.saturating_mul(copies));
    draft.taken.take(files.scene, limits, vertices, triangles)?;

    let fault = |accessor: usize, semantic: &str, reason: String| SceneError::Accessor {
        file: files.scene.into(),
        mesh: name.clone(),
        accessor,
        semantic: semantic.to_owned(),
        reason,
    };
    let floats = positions.data_type() == DataType::F32;
    let positions = accessor::vectors::<3>(views, &positions)
        .map_err(|reason| fault(positions.index(), "POSITION", reason))?;
    let positions: Vec<_> = positions.into_iter().map(|position| position.map(f64::from)).collect();
    // Quantized positions are exact: what was lost before is not known here.
    let rounding = if floats { rounding(&positions) } else { 0.0 };
    let source = |semantic: &Semantic, label: &str| match primitive.get(semantic) {
        Some(source) if source.count() != count => {
            let reason = format!("has {} elements for {count} positions", source.count());
            Err(fault(source.index(), label, reason))
        }
        source => Ok(source),
    };
    let normals = match source(&Semantic::Normals, "NORMAL")? {
        Some(source) => accessor::vectors::<3>(views, &source)
            .map_err(|reason| fault(source.index(), "NORMAL", reason))?,
        None => Vec::new(),
    };
    let uvs_of = |set: u32| {
        let label = format!("TEXCOORD_{set}");
        match source(&Semantic::TexCoords(set), &label)? {
            Some(source) => accessor::vectors::<2>(views, &source)
                .map_err(|reason| fault(source.index(), &label, reason)),
            None => Ok(Vec::new()),
        }
    };
    let indices = match primitive.indices() {
        Some(source) => {
            let indices = accessor::indices(views, &source)
                .map_err(|reason| fault(source.index(), "indices", reason))?;
            // The largest number restarts strips elsewhere; here it is out of range like any other.
            if let Some(&index) = indices.iter().find(|&&index| index as usize >= count) {
                let reason = format!("vertex {index} is out of range; there are {count}");
                return Err(fault(source.index(), "indices", reason));
            }
            indices
        }
        None => (0..count as u32).collect(),
    };
    let index = primitive.material().index();
    let material = index.unwrap_or_else(|| draft.material(default_material()));
    let converted = index.and_then(|index| materials.get(index));
    let uvs = uvs_of(converted.map_or(0, Converted::main_set))?;
    let textured = draft.materials.get(material).is_some_and(|m| m.textures().next().is_some());
    if textured && uvs.is_empty() {
        let text = "textures of a mesh without texture coordinates are read at (0, 0)";
        draft.notes.add(NoteKind::Assumed, text, &name);
    }
    let colors = match source(&Semantic::Colors(0), "COLOR_0")? {
        Some(source) => {
            colors(views, &source).map_err(|reason| fault(source.index(), "COLOR_0", reason))?
        }
        None => Vec::new(),
    };
    // Of no use without a normal map, nor without normals.
    let mapped = draft.materials.get(material).is_some_and(|of| of.normal_texture.is_some());
    let tangents = match source(&Semantic::Tangents, "TANGENT")? {
        Some(source) if mapped && !normals.is_empty() => {
            let read = accessor::vectors::<4>(views, &source);
            read.map_err(|reason| fault(source.index(), "TANGENT", reason))?
        }
        _ => Vec::new(),
    };
    let indices = into_list(primitive.mode(), indices);
    let detail = Detail { tangents, ..Detail::default() };
    let mut raw = RawMesh {
        name: name.clone(),
        positions,
        normals,
        uvs,
        indices,
        material,
        detail,
        rounding,
    };
    if let Some(converted) = converted {
        raw.material = other_sets(draft, &mut raw, converted, uvs_of)?;
    }
    tint::apply(draft, &mut raw, colors);
    Ok(Some(raw))
}

/// Colours with an opacity, of 1 where the file has none.
fn colors(views: &Views<'_>, source: &gltf::Accessor<'_>) -> Result<Vec<[f32; 4]>, String> {
    if source.dimensions().multiplicity() == 4 {
        return accessor::vectors::<4>(views, source);
    }
    let colors = accessor::vectors::<3>(views, source)?;
    Ok(colors.into_iter().map(|[r, g, b]| [r, g, b, 1.0]).collect())
}

/// The material of a mesh some of whose textures are read at another set of texture coordinates than the mesh's: where
/// that is the mesh's, scaled and moved, the texture's transform takes it in; where it is not, the mesh gets a second set. A
/// texture at a third one is left out.
fn other_sets(
    draft: &mut Draft,
    mesh: &mut RawMesh,
    converted: &Converted,
    uvs_of: impl Fn(u32) -> Result<Vec<[f32; 2]>, SceneError>,
) -> Result<usize, SceneError> {
    let main = converted.main_set();
    let mut own = OnceCell::new();
    let mut second = None;
    for (slot, (texture, set)) in converted.textures().into_iter().zip(converted.sets).enumerate() {
        let Some(texture) = texture.filter(|_| set != main) else { continue };
        let other = uvs_of(set)?;
        own.get_or_init(|| converted.material.clone());
        let Some(material) = own.get_mut() else { continue };
        let transform = if other.is_empty() {
            // It is read at one place, as without any texture coordinates.
            Some(UvTransform { scale: [0.0; 2], ..texture.transform })
        } else {
            same_places(&mesh.uvs, &other).map(|by| after(texture.transform, by))
        };
        let moved = match transform {
            Some(transform) => TextureUse { transform, ..texture },
            None if second.is_none_or(|second| second == set) => {
                second = Some(set);
                mesh.detail.uvs = other;
                TextureUse { second: true, ..texture }
            }
            None => {
                let lacks = material::neutral(material, slot);
                let text = format!("texture at a third set of texture coordinates; {lacks}");
                draft.notes.add(NoteKind::Ignored, text, &material.name);
                continue;
            }
        };
        if let Some(texture) = material::slots(material).into_iter().nth(slot) {
            *texture = Some(moved);
        }
    }
    Ok(own.into_inner().map_or(mesh.material, |material| draft.material(material)))
}

/// Scale and offset of the second texture coordinates in terms of the first; none where they are something else.
fn same_places(first: &[[f32; 2]], second: &[[f32; 2]]) -> Option<[[f32; 2]; 2]> {
    let mut by = [[0.0; 2]; 2];
    if first.len() != second.len() {
        return None;
    }
    for (axis, [scale, offset]) in by.iter_mut().enumerate() {
        let at = |list: &[[f32; 2]], index: usize| list[index][axis];
        let numbers = || 0..first.len();
        let least = numbers().min_by(|&a, &b| at(first, a).total_cmp(&at(first, b)))?;
        let most = numbers().max_by(|&a, &b| at(first, a).total_cmp(&at(first, b)))?;
        let extent = at(first, most) - at(first, least);
        *scale = if extent > 0.0 { (at(second, most) - at(second, least)) / extent } else { 0.0 };
        *offset = at(second, least) - *scale * at(first, least);
        let error =
            |index: usize| (at(second, index) - (*scale * at(first, index) + *offset)).abs();
        let size = numbers().map(|index| at(second, index).abs()).fold(1.0, f32::max);
        // Written so that what is not a number is not the same.
        if !numbers().all(|index| error(index) <= SAME_PLACE * size) {
            return None;
        }
    }
    Some(by)
}

/// The transform that scales and moves first.
fn after(transform: UvTransform, [[su, ou], [sv, ov]]: [[f32; 2]; 2]) -> UvTransform {
    let offset = transform.rows().map(|[a, b, c]| a * ou + b * ov + c);
    let scale = [transform.scale[0] * su, transform.scale[1] * sv];
    UvTransform { offset, scale, ..transform }
}

/// What meshes without a material are made of. [glTF 2.0, section 3.9.2: white, metallic 1, roughness 1]
fn default_material() -> Material {
    Material { metallic: 1.0, dielectric: 0.04, ..Material::diffuse("default", [1.0; 3]) }
}

/// How far the largest of some coordinates may be off that was rounded to 32 bits.
fn rounding(positions: &[[f64; 3]]) -> f64 {
    let largest = positions.iter().flatten().map(|one| one.abs()).fold(0.0, f64::max);
    // Half a step, of which 2^23 are between two powers of two. [IEEE 754 binary32]
    power_of_two(largest) * 0.5 * f64::from(f32::EPSILON)
}

/// Copies of a mesh in another space, as one mesh.
pub(super) fn placed(mesh: &RawMesh, world: DMat4, copies: &[DMat4]) -> RawMesh {
    let mut placed =
        RawMesh { name: mesh.name.clone(), material: mesh.material, ..RawMesh::default() };
    for &copy in copies {
        let world = world * copy;
        let linear = DMat3::from_mat4(world);
        let turned = linear.determinant() < 0.0;
        // The limit of a scene's vertices is one of u32.
        let first = placed.positions.len() as u32;
        placed.indices.extend(mesh.indices.as_chunks::<3>().0.iter().flat_map(|&[a, b, c]| {
            let corners = if turned { [a, c, b] } else { [a, b, c] };
            corners.map(|corner| first.wrapping_add(corner))
        }));
        // The cofactors: the inverse transpose times the determinant, which does not need to exist.
        let [x, y, z] = [linear.x_axis, linear.y_axis, linear.z_axis];
        let cofactors =
            DMat3::from_cols(y.cross(z), z.cross(x), x.cross(y)) * linear.determinant().signum();
        let longest = [x, y, z].map(|axis| axis.length()).into_iter().fold(0.0, f64::max);
        placed.rounding = placed.rounding.max(mesh.rounding * longest);
        let point =
            |&position: &[f64; 3]| -> [f64; 3] { world.transform_point3(position.into()).into() };
        placed.positions.extend(mesh.positions.iter().map(point));
        let normal = |&normal: &[f32; 3]| -> [f32; 3] {
            let normal = cofactors * DVec3::from(normal.map(f64::from));
            // Of unit length, for cofactors of small or large scales leave the range of 32 bits.
            normal.normalize_or_zero().as_vec3().into()
        };
        placed.normals.extend(mesh.normals.iter().map(normal));
        placed.uvs.extend(&mesh.uvs);
        placed.detail.uvs.extend(&mesh.detail.uvs);
        placed.detail.colors.extend(&mesh.detail.colors);
        let sign = if turned { -1.0 } else { 1.0 };
        let tangent = |&[x, y, z, w]: &[f32; 4]| {
            let along = linear * DVec3::new(x.into(), y.into(), z.into());
            along.normalize_or_zero().as_vec3().extend(sign * w).to_array()
        };
        placed.detail.tangents.extend(mesh.detail.tangents.iter().map(tangent));
    }
    placed
}

/// Strips and fans as lists. [glTF 2.0, section 3.7.2.1]
fn into_list(mode: Mode, indices: Vec<u32>) -> Vec<u32> {
    let pairs = || indices.windows(2).skip(1);
    match mode {
        Mode::TriangleStrip => indices
            .windows(3)
            .enumerate()
            .flat_map(|(i, corners)| match i % 2 {
                0 => [corners[0], corners[1], corners[2]],
                _ => [corners[0], corners[2], corners[1]],
            })
            .collect(),
        Mode::TriangleFan => pairs().flat_map(|pair| [indices[0], pair[0], pair[1]]).collect(),
        _ => indices,
    }
}
