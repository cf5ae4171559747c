//! Triangle meshes.

use std::path::Path;

use glam::{DVec3, Vec3};

use super::SceneError;
use super::note::{NoteKind, Notes};
use super::origin;

/// Triangles of one material in world space. No triangle is degenerate.
#[derive(Clone, Debug, PartialEq)]
pub struct Mesh {
    /// Its name, or `mesh` and its number.
    pub name: String,
    /// World positions, finite.
    pub positions: Vec<[f32; 3]>,
    /// Unit shading normals, one for each position.
    pub normals: Vec<[f32; 3]>,
    /// Texture coordinates, one for each position, v pointing down; empty where there are none.
    pub uvs: Vec<[f32; 2]>,
    /// Three for each triangle, counter-clockwise seen from the front.
    pub indices: Vec<u32>,
    /// Index into [`super::Scene::materials`].
    pub material: usize,
    /// What few meshes have.
    pub detail: Detail,
}

/// What few meshes have of each vertex; each list is as long as the positions, or empty.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Detail {
    /// A second set of texture coordinates, v pointing down.
    pub uvs: Vec<[f32; 2]>,
    /// Linear Rec. 709 and opacity, each 0 to 1: what the base colour is multiplied with.
    pub colors: Vec<[f32; 4]>,
    /// Where the u of the normal map rises, of unit length or 0, and in w the sign of the bitangent, which is that times
    /// `cross(normal, tangent)`. [glTF 2.0, section 3.7.2.1]
    pub tangents: Vec<[f32; 4]>,
}

impl Detail {
    /// The same of some vertices, by their numbers.
    fn take(&self, vertices: impl Iterator<Item = usize> + Clone) -> Self {
        Self {
            uvs: taken(&self.uvs, vertices.clone()),
            colors: taken(&self.colors, vertices.clone()),
            tangents: taken(&self.tangents, vertices),
        }
    }
}

/// The elements of some numbers, of a list that may be empty.
fn taken<T: Copy>(list: &[T], numbers: impl Iterator<Item = usize>) -> Vec<T> {
    numbers.filter_map(|number| list.get(number).copied()).collect()
}

impl Mesh {
    /// The number of triangles.
    pub fn triangle_count(&self) -> usize {
        self.indices.len() / 3
    }

    /// The corners of each triangle.
    pub fn triangles(&self) -> impl Iterator<Item = [[f32; 3]; 3]> + '_ {
        self.indices
            .as_chunks::<3>()
            .0
            .iter()
            .map(|corners| corners.map(|index| self.positions[index as usize]))
    }
}

/// A mesh as a loader found it. Every index is in range; `normals` is as long as `positions` or
/// empty, and so is `uvs`.
#[derive(Debug, Default)]
pub(super) struct RawMesh {
    pub(super) name: String,
    /// In the file's space, before an origin is subtracted.
    pub(super) positions: Vec<[f64; 3]>,
    pub(super) normals: Vec<[f32; 3]>,
    pub(super) uvs: Vec<[f32; 2]>,
    pub(super) indices: Vec<u32>,
    pub(super) material: usize,
    pub(super) detail: Detail,
    /// How far positions may be off that were rounded when the file was written; 0 where that is not known.
    pub(super) rounding: f64,
}

impl RawMesh {
    /// The positions that triangles have, but for those that are not finite.
    pub(super) fn corners(&self) -> impl Iterator<Item = DVec3> + '_ {
        let corners = self.indices.iter().map(|&index| self.positions[index as usize].into());
        corners.filter(|corner: &DVec3| corner.is_finite())
    }

    /// Takes positions relative to an origin, checks them, drops degenerate triangles and mends normals; `None` where no
    /// triangle is left.
    pub(super) fn clean(
        self,
        file: &Path,
        origin: DVec3,
        notes: &mut Notes,
    ) -> Result<Option<Mesh>, SceneError> {
        let relative = |&position: &[f64; 3]| origin::relative(position.into(), origin);
        let positions: Vec<_> = self.positions.iter().map(relative).collect();
        if let Some(vertex) = positions.iter().position(|&p| !Vec3::from(p).is_finite()) {
            return Err(SceneError::NonFinite {
                file: file.into(),
                mesh: self.name,
                vertex,
                position: self.positions[vertex],
            });
        }
        let Self { name, normals, uvs, indices, material, detail, .. } = self;
        let mut mesh = Mesh { name, positions, normals, uvs, indices, material, detail };
        let found = mesh.triangle_count();
        let (kept, face_normals) = mesh.sound_triangles();
        mesh.indices = kept;
        let dropped = found - mesh.triangle_count();
        if dropped > 0 {
            let text = "degenerate triangles dropped";
            notes.add(NoteKind::Ignored, text, format!("{}: {dropped}", mesh.name));
        }
        if mesh.indices.is_empty() {
            return Ok(None);
        }
        if mesh.normals.is_empty() {
            notes.add(NoteKind::Derived, "no normals: flat ones made", &mesh.name);
            mesh.flatten(&face_normals);
        } else if mesh.mend_normals(&face_normals) {
            let text = "normals without a direction replaced by the triangles'";
            notes.add(NoteKind::Derived, text, &mesh.name);
        }
        let coordinates = mesh.uvs.iter_mut().chain(&mut mesh.detail.uvs).flatten();
        let mut wrong = coordinates.filter(|coordinate| !coordinate.is_finite()).peekable();
        if wrong.peek().is_some() {
            let text = "texture coordinates that are not finite set to 0";
            notes.add(NoteKind::Assumed, text, &mesh.name);
            wrong.for_each(|coordinate| *coordinate = 0.0);
        }
        Ok(Some(mesh))
    }
}

impl Mesh {
    /// The indices of the triangles that have an area, and for each the normal times twice its area.
    fn sound_triangles(&self) -> (Vec<u32>, Vec<DVec3>) {
        let corner = |index: u32| Vec3::from(self.positions[index as usize]).as_dvec3();
        let mut kept = Vec::with_capacity(self.indices.len());
        let mut normals = Vec::with_capacity(self.indices.len() / 3);
        for &[a, b, c] in self.indices.as_chunks::<3>().0 {
            // In f64 the product of f32 edges neither overflows nor cancels to zero by rounding.
            let normal = (corner(b) - corner(a)).cross(corner(c) - corner(a));
            if normal.length_squared() > 0.0 {
                kept.extend([a, b, c]);
                normals.push(normal);
            }
        }
        (kept, normals)
    }

    /// Gives each triangle its own vertices, with the triangle's normal.
    fn flatten(&mut self, face_normals: &[DVec3]) {
        let corners = self.indices.iter().map(|index| *index as usize);
        self.positions = taken(&self.positions, corners.clone());
        self.uvs = taken(&self.uvs, corners.clone());
        self.detail = self.detail.take(corners);
        // Tangents are of the normals that are not there. [glTF 2.0, section 3.7.2.1]
        self.detail.tangents.clear();
        self.normals = face_normals
            .iter()
            .flat_map(|normal| [normal.normalize().as_vec3().into(); 3])
            .collect();
        self.indices = (0..).take(self.indices.len()).collect();
    }

    /// The number of a vertex that is the same as another.
    pub(super) fn copy(&mut self, vertex: usize) -> u32 {
        let number = self.positions.len() as u32;
        let one = std::iter::once(vertex);
        self.positions.extend(taken(&self.positions, one.clone()));
        self.normals.extend(taken(&self.normals, one.clone()));
        self.uvs.extend(taken(&self.uvs, one.clone()));
        let Detail { uvs, colors, tangents } = self.detail.take(one);
        self.detail.uvs.extend(uvs);
        self.detail.colors.extend(colors);
        self.detail.tangents.extend(tangents);
        number
    }

    /// Makes normals unit vectors; those that have no direction get the mean of their triangles'.
    /// Whether there were any.
    fn mend_normals(&mut self, face_normals: &[DVec3]) -> bool {
        let mut missing = vec![false; self.normals.len()];
        for (normal, missing) in self.normals.iter_mut().zip(&mut missing) {
            match Vec3::from(*normal).try_normalize() {
                Some(unit) => *normal = unit.into(),
                None => *missing = true,
            }
        }
        // A vertex that no triangle uses needs no note.
        if !self.indices.iter().any(|&index| missing[index as usize]) {
            return false;
        }
        let mut sums = vec![DVec3::ZERO; self.normals.len()];
        for (corners, normal) in self.indices.as_chunks::<3>().0.iter().zip(face_normals) {
            corners.iter().for_each(|&index| sums[index as usize] += *normal);
        }
        for ((normal, sum), missing) in self.normals.iter_mut().zip(sums).zip(missing) {
            if missing {
                *normal = sum.normalize_or(DVec3::Y).as_vec3().into();
            }
        }
        true
    }
}
