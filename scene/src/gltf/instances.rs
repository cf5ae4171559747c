//! Copies of a node's mesh. [EXT_mesh_gpu_instancing]

use glam::{DMat4, DQuat, DVec3};

use super::accessor;
use super::buffer::Views;
use crate::SceneError;
use crate::files::Files;

/// The transforms of the copies of a node's mesh, in the node's space; none where the node does not say.
pub(super) fn transforms(
    files: &Files<'_>,
    document: &gltf::Document,
    views: &Views<'_>,
    node: &gltf::Node<'_>,
) -> Result<Option<Vec<DMat4>>, SceneError> {
    let Some(extension) = node.extension_value("EXT_mesh_gpu_instancing") else { return Ok(None) };
    let invalid = |key: &str, reason: String| SceneError::Invalid {
        file: files.scene.into(),
        place: format!("nodes[{}].extensions.EXT_mesh_gpu_instancing.{key}", node.index()),
        reason,
    };
    let attribute = |key: &str| {
        let Some(value) = extension.get("attributes").and_then(|all| all.get(key)) else {
            return Ok(None);
        };
        let index = value.as_u64().and_then(|index| usize::try_from(index).ok());
        let found = index.and_then(|index| document.accessors().nth(index));
        let accessor =
            found.ok_or_else(|| invalid(key, format!("there is no accessor {value}")))?;
        let limit = files.options.limits.triangles;
        if accessor.count() > limit {
            let reason = format!("has {} copies, more than the limit of {limit}", accessor.count());
            return Err(invalid(key, reason));
        }
        Ok(Some(accessor))
    };
    let vectors = |key: &str| -> Result<Option<Vec<[f32; 3]>>, SceneError> {
        let Some(accessor) = attribute(key)? else { return Ok(None) };
        accessor::vectors::<3>(views, &accessor).map(Some).map_err(|reason| invalid(key, reason))
    };
    let translations = vectors("TRANSLATION")?;
    let scales = vectors("SCALE")?;
    let rotations = match attribute("ROTATION")? {
        Some(accessor) => {
            let read = accessor::vectors::<4>(views, &accessor);
            Some(read.map_err(|reason| invalid("ROTATION", reason))?)
        }
        None => None,
    };
    let counts = [
        translations.as_ref().map(Vec::len),
        scales.as_ref().map(Vec::len),
        rotations.as_ref().map(Vec::len),
    ];
    let mut counts = counts.into_iter().flatten();
    // Attributes of one's own alone: as many copies as they say is not known, so there is the one.
    let Some(count) = counts.next() else { return Ok(None) };
    if counts.any(|other| other != count) {
        let reason = "have different numbers of copies".to_owned();
        return Err(invalid("attributes", reason));
    }
    let of = |list: &Option<Vec<[f32; 3]>>, index: usize, default: [f32; 3]| {
        let vector = list.as_ref().map_or(default, |list| list[index]);
        DVec3::from(vector.map(f64::from))
    };
    let transform = |index: usize| {
        let rotation = rotations.as_ref().map_or([0.0, 0.0, 0.0, 1.0], |list| list[index]);
        let rotation = DQuat::from_array(rotation.map(f64::from));
        let length = rotation.length_squared();
        let rotation =
            if length > 0.0 && length.is_finite() { rotation.normalize() } else { DQuat::IDENTITY };
        DMat4::from_scale_rotation_translation(
            of(&scales, index, [1.0; 3]),
            rotation,
            of(&translations, index, [0.0; 3]),
        )
    };
    Ok(Some((0..count).map(transform).collect()))
}
