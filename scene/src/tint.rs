//! Colours of vertices: the rasteriser's vertices have none, so that a mesh takes one colour for all.

use super::draft::Draft;
use super::mesh::RawMesh;
use super::note::NoteKind;
use glam::Vec3;

/// What a material's base colour is multiplied with.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Tint {
    /// The mean over the mesh's area.
    color: [f32; 3],
    /// Whether the vertices differ.
    varies: bool,
}

impl Tint {
    /// The tint of a mesh whose vertices have these colours; none where all of them are white.
    pub(super) fn of(mesh: &RawMesh, colors: &[[f32; 3]]) -> Option<Self> {
        if colors.len() != mesh.positions.len() || colors.iter().all(|color| *color == [1.0; 3]) {
            return None;
        }
        let first = mesh.indices.first().and_then(|&index| colors.get(index as usize))?;
        let varies = mesh.indices.iter().any(|&index| colors[index as usize] != *first);
        if !varies {
            return Some(Self { color: *first, varies });
        }
        let (mut sum, mut area) = (glam::DVec3::ZERO, 0.0);
        for corners in mesh.indices.as_chunks::<3>().0 {
            let [a, b, c] = corners.map(|index| glam::DVec3::from(mesh.positions[index as usize]));
            let own = (b - a).cross(c - a).length();
            let mean = corners.map(|index| Vec3::from(colors[index as usize]).as_dvec3());
            sum += own * (mean[0] + mean[1] + mean[2]) / 3.0;
            area += own;
        }
        let mean = if area > 0.0 { (sum / area).as_vec3() } else { Vec3::from(*first) };
        Some(Self { color: if mean.is_finite() { mean.into() } else { [1.0; 3] }, varies })
    }
}

/// The index of a mesh's material with the tint, made where it is not there yet.
pub(super) fn apply(draft: &mut Draft, mesh: &RawMesh, tint: Tint) -> usize {
    if tint.varies {
        let text = "vertex colours: each mesh has their mean";
        draft.notes.add(NoteKind::Ignored, text, &mesh.name);
    }
    let Some(source) = draft.materials.get(mesh.material) else { return mesh.material };
    let mut tinted = source.clone();
    for (channel, factor) in tinted.base_color.iter_mut().zip(tint.color) {
        *channel *= factor;
    }
    draft.material(tinted)
}
