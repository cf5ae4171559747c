//! OBJ with MTL, for the classic scenes.
//!
//! `Kd` and `map_Kd` are the base colour, the mean of `Ks` the dielectric's reflectance, `Ns` the
//! exponent of a Blinn lobe, `Ke` the emission; colours are taken as linear.

use std::cell::RefCell;
use std::path::{Path, PathBuf};

use super::mesh::RawMesh;
use super::note::{NoteKind, Notes};
use super::{Image, Material, SceneError, TextureUse, error};
use crate::draft::Draft;

/// Reads an `.obj` file, its materials and their textures.
pub(super) fn load(file: &Path, bytes: &[u8]) -> Result<Draft, SceneError> {
    let folder = file.parent().unwrap_or(Path::new(""));
    let options = tobj::LoadOptions {
        triangulate: true,
        single_index: true,
        ignore_points: true,
        ignore_lines: true,
    };
    let lost: RefCell<Vec<PathBuf>> = RefCell::default();
    let (models, loaded) = tobj::load_obj_buf(&mut &*bytes, &options, |name| {
        let found = error::read(&folder.join(name)).ok();
        let read = found.and_then(|bytes| tobj::load_mtl_buf(&mut &*bytes).ok());
        read.ok_or_else(|| {
            lost.borrow_mut().push(name.into());
            tobj::LoadError::OpenFileFailed
        })
    })
    .map_err(|error| SceneError::Obj { file: file.into(), reason: error.to_string() })?;
    let mut draft = Draft::default();
    for name in lost.into_inner() {
        let text = "material library that cannot be read";
        draft.notes.add(NoteKind::Ignored, text, name.display().to_string());
    }
    for source in loaded.unwrap_or_default() {
        let material = convert(file, source, &mut draft.images, &mut draft.notes)?;
        draft.materials.push(material);
    }
    let grey = draft.materials.len();
    for model in models {
        let mesh = model.mesh;
        let material = mesh.material_id.unwrap_or(grey);
        if material == grey {
            draft.notes.add(NoteKind::Assumed, "mesh without a material is grey", &model.name);
            if draft.materials.len() == grey {
                draft.materials.push(Material::diffuse("grey", [0.5; 3]));
            }
        }
        if !mesh.vertex_color.is_empty() {
            draft.notes.add(NoteKind::Ignored, "vertex colours", &model.name);
        }
        let positions = mesh.positions.as_chunks::<3>().0.to_vec();
        // Normals and texture coordinates that only some faces have cannot be told apart.
        let whole = |length: usize, components: usize| length == positions.len() * components;
        let normals = if whole(mesh.normals.len(), 3) { mesh.normals } else { Vec::new() };
        let uvs = if whole(mesh.texcoords.len(), 2) { mesh.texcoords } else { Vec::new() };
        draft.meshes.push(RawMesh {
            name: model.name,
            normals: normals.as_chunks::<3>().0.to_vec(),
            // The image's first row is at v = 1 in OBJ.
            uvs: uvs.as_chunks::<2>().0.iter().map(|&[u, v]| [u, 1.0 - v]).collect(),
            indices: mesh.indices,
            positions,
            material,
        });
    }
    Ok(draft)
}

fn convert(
    file: &Path,
    source: tobj::Material,
    images: &mut Vec<Image>,
    notes: &mut Notes,
) -> Result<Material, SceneError> {
    let name = source.name;
    let mut material = Material::diffuse(&name, source.diffuse.unwrap_or([1.0; 3]));
    if let Some(specular) = source.specular {
        material.dielectric = (specular.iter().sum::<f32>() / 3.0).clamp(0.0, 1.0);
    }
    // [Walter et al. 2007, section 5.2: alpha = sqrt(2 / (n + 2))]; roughness is its square root.
    let exponent = source.shininess.unwrap_or(0.0).max(0.0);
    material.roughness = (2.0 / (exponent + 2.0)).powf(0.25);
    if let Some(ambient) = source.ambient
        && ambient.iter().any(|&channel| channel > 0.0)
    {
        let text = "ambient colour Ka; a surface emits by Ke";
        notes.add(NoteKind::Ignored, text, format!("{name}: Ka {ambient:?}"));
    }
    if let Some(emission) = source.emissive {
        material.emission = emission;
    }
    if let Some(alpha) = source.dissolve
        && alpha < 1.0
    {
        notes.add(NoteKind::Assumed, "blended alpha is cut off at 0.5", &name);
        material.base_color[3] = alpha;
        material.alpha_cutoff = Some(0.5);
    }
    for (kind, map) in [
        ("map_Ka", &source.ambient_texture),
        ("map_Ks", &source.specular_texture),
        ("map_Ns", &source.shininess_texture),
        ("map_Bump", &source.normal_texture),
        ("map_d", &source.dissolve_texture),
    ] {
        if map.is_some() {
            notes.add(NoteKind::Ignored, kind, &name);
        }
    }
    if let Some(texture) = source.diffuse_texture {
        // Files written on Windows; options before the name are not read.
        let texture = texture.replace('\\', "/");
        let known = images.iter().position(|image| image.name == texture);
        let image = match known {
            Some(image) => image,
            None => {
                let bytes = error::read(&file.parent().unwrap_or(Path::new("")).join(&texture))?;
                let image = Image::decode(&texture, &bytes, true).map_err(|reason| {
                    SceneError::Image { file: file.into(), image: texture.clone(), reason }
                })?;
                images.push(image);
                images.len() - 1
            }
        };
        material.base_color_texture = Some(TextureUse::repeating(image));
    }
    Ok(material)
}
