//! Colours of vertices, which a material's base colour and opacity are multiplied with.

use super::draft::Draft;
use super::mesh::RawMesh;
use super::note::NoteKind;

/// Gives a mesh the colours of its vertices. Where all are alike they go into its material, and nothing is read for each.
pub(super) fn apply(draft: &mut Draft, mesh: &mut RawMesh, mut colors: Vec<[f32; 4]>) {
    if colors.len() != mesh.positions.len() {
        return;
    }
    let mut moved = false;
    for channel in colors.iter_mut().flatten() {
        let inside = if channel.is_nan() { 0.0 } else { channel.clamp(0.0, 1.0) };
        moved |= inside != *channel;
        *channel = inside;
    }
    if moved {
        draft.notes.add(NoteKind::Assumed, "vertex colours clamped to their range", &mesh.name);
    }
    let mut used = mesh.indices.iter().filter_map(|&index| colors.get(index as usize));
    let Some(&first) = used.next() else { return };
    if used.any(|color| *color != first) {
        mesh.detail.colors = colors;
        return;
    }
    if first == [1.0; 4] {
        return;
    }
    let Some(source) = draft.materials.get(mesh.material) else { return };
    let mut tinted = source.clone();
    for (channel, factor) in tinted.base_color.iter_mut().zip(first) {
        *channel *= factor;
    }
    mesh.material = draft.material(tinted);
}
