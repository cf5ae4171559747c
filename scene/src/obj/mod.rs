//! OBJ with MTL, for the classic scenes: as files have it, not as a grammar would.
//!
//! A line that cannot be read costs that line alone and gives a note with its place. Files are read as bytes (`text`),
//! statement by statement (`geometry`, `mtl`), then faces become triangles (`polygon`, `mesh`) and materials ours
//! (`material`).

use std::collections::HashMap;

use super::files::Files;
use super::note::NoteKind;
use super::tint;
use super::{Material, SceneError};
use crate::draft::Draft;
use geometry::{Face, Geometry, Name};
use library::{Finder, Found};
use material::Images;
use text::Faults;

mod geometry;
mod library;
mod material;
mod mesh;
mod mtl;
mod polygon;
mod text;

/// The most lines whose material libraries are read; programs write one.
const MOST_LIBRARIES: usize = 256;

/// Reads an `.obj` file, its materials and their textures.
pub(super) fn load(files: &Files<'_>, bytes: &[u8]) -> Result<Draft, SceneError> {
    let (file, limits) = (files.scene, &files.options.limits);
    let mut draft = Draft::default();
    let mut faults = Faults::new(file);
    let geometry =
        geometry::read(file, &text::decode(bytes), limits, &mut faults, &mut draft.notes)?;
    let finder = Finder::new(*files);
    let definitions = libraries(&finder, &geometry, &mut faults, &mut draft);
    let used = materials(&finder, &geometry, &definitions, &mut draft);

    let grey = draft.materials.len();
    if geometry.faces.iter().any(|face| face.material.and_then(|name| used[name]).is_none()) {
        draft.materials.push(Material::diffuse("grey", [0.5; 3]));
    }
    let material_of = |face: &Face| face.material.and_then(|name| used[name]).unwrap_or(grey);
    for built in mesh::build(&geometry, material_of, &mut faults) {
        let mut raw = built.raw;
        draft.taken.take(file, limits, raw.positions.len(), raw.indices.len() / 3)?;
        if raw.material == grey {
            draft.notes.add(NoteKind::Assumed, "mesh without a material is grey", &raw.name);
        }
        let textured =
            draft.materials.get(raw.material).is_some_and(|m| m.textures().next().is_some());
        if textured && (raw.uvs.is_empty() || built.partly_without_uvs) {
            let text = "textures of a mesh without texture coordinates are read at (0, 0)";
            draft.notes.add(NoteKind::Assumed, text, &raw.name);
        }
        if built.smoothed {
            let text = "no normals: means over smoothing groups made";
            draft.notes.add(NoteKind::Derived, text, &raw.name);
        }
        if built.partly_without_normals {
            let text = "some faces have no normals: flat ones made";
            draft.notes.add(NoteKind::Derived, text, &raw.name);
        }
        tint::apply(&mut draft, &mut raw, built.colors);
        draft.meshes.push(raw);
    }
    if draft.meshes.is_empty() {
        let errors = faults.into_errors();
        if !errors.is_empty() {
            return Err(SceneError::of(errors));
        }
    } else {
        faults.note(&mut draft.notes);
    }
    Ok(draft)
}

/// All definitions of the libraries that the file names, in their order.
fn libraries(
    finder: &Finder<'_>,
    geometry: &Geometry,
    faults: &mut Faults,
    draft: &mut Draft,
) -> Vec<mtl::Definition> {
    let mut definitions = Vec::new();
    let mut read = Vec::new();
    for line in geometry.libraries.iter().take(MOST_LIBRARIES) {
        if line.words.is_empty() {
            faults.add(line.place, "the name of a material library is missing");
        }
        for name in finder.names(line) {
            match finder.read(&name) {
                // One that many lines name is read once.
                Ok(found) if read.contains(&found.path) => {}
                Ok(Found { path, alike, bytes }) => {
                    if alike {
                        let text = "material library of the same name in the scene's folder";
                        draft.notes.add(NoteKind::Assumed, text, &name);
                    }
                    let mut own = Faults::new(&path);
                    let text = text::decode(&bytes);
                    definitions.extend(mtl::read(&path, &text, &mut own, &mut draft.notes));
                    own.note(&mut draft.notes);
                    read.push(path);
                }
                Err(fault) => {
                    let message =
                        format!("material library `{name}`: {fault}; its materials are grey");
                    faults.add(line.place, message);
                }
            }
        }
    }
    for line in geometry.libraries.iter().skip(MOST_LIBRARIES) {
        let message = format!("more than {MOST_LIBRARIES} lines name material libraries");
        faults.add(line.place, message);
    }
    definitions
}

/// Converts the materials that faces name, and says which each name means; none where no library defines it.
fn materials(
    finder: &Finder<'_>,
    geometry: &Geometry,
    definitions: &[mtl::Definition],
    draft: &mut Draft,
) -> Vec<Option<usize>> {
    let mut by_whole: HashMap<&str, usize> = HashMap::new();
    let mut by_cut: HashMap<&str, usize> = HashMap::new();
    for (index, definition) in definitions.iter().enumerate() {
        let Name { cut, whole } = &definition.name;
        // Of several with the same name the last one counts.
        if by_whole.insert(whole, index).is_some() {
            draft.notes.add(NoteKind::Assumed, "of several definitions the last one counts", cut);
        }
        by_cut.insert(cut, index);
    }
    let find = |name: &Name| {
        let Name { cut, whole } = name;
        let (whole, cut) = (whole.as_str(), cut.as_str());
        by_whole.get(whole).or_else(|| by_whole.get(cut)).or_else(|| by_cut.get(cut)).copied()
    };
    let mut images = Images::new(finder);
    let mut converted: HashMap<usize, usize> = HashMap::new();
    let used = geometry.materials.iter().map(|name| {
        let Some(definition) = find(name) else {
            draft.notes.add(NoteKind::Ignored, "material that no library defines", &name.whole);
            return None;
        };
        let materials = &mut draft.materials;
        Some(*converted.entry(definition).or_insert_with(|| {
            materials.push(material::convert(
                &definitions[definition],
                &mut images,
                &mut draft.notes,
            ));
            materials.len() - 1
        }))
    });
    let used = used.collect();
    draft.images = images.images;
    used
}
