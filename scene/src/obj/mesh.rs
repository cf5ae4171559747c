//! Faces as meshes: triangles, vertices that corners share, normals that are not given.

use std::collections::HashMap;

use glam::DVec3;

use super::geometry::{Corner, Face, Geometry, NONE};
use super::polygon;
use super::text::Faults;
use crate::mesh::RawMesh;

/// A mesh, with the colours of its vertices where the file has any.
#[derive(Debug, Default)]
pub(super) struct Built {
    pub(super) raw: RawMesh,
    pub(super) colors: Vec<[f32; 4]>,
    /// Some corner has texture coordinates, and some has none.
    pub(super) partly_without_uvs: bool,
    /// Some normal is the mean of a smoothing group; some is a face's beside given ones.
    pub(super) smoothed: bool,
    pub(super) partly_without_normals: bool,
}

/// Where a corner's normal comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
enum Normal {
    Given(u32),
    /// The mean over the faces of a smoothing group at a position.
    Smooth(u32),
    /// That of face number.
    Flat(usize),
    /// Made later, of each triangle.
    Later,
}

/// The faces of one group and material, whose numbers come as `(group, material)`.
struct Part {
    built: Built,
    known: HashMap<(u32, u32, Normal), u32>,
    any_uvs: bool,
    any_without_uvs: bool,
}

/// Makes meshes of all faces: one for each group and material, in the order of their first faces.
pub(super) fn build(
    geometry: &Geometry,
    material_of: impl Fn(&Face) -> usize,
    faults: &mut Faults,
) -> Vec<Built> {
    let polygons: Vec<_> = geometry.faces.iter().map(|face| polygon_of(geometry, face)).collect();
    let positions =
        |corners: &[Corner]| corners.iter().map(|corner| position(geometry, corner)).collect();
    let mut smooth: HashMap<(u32, u32), DVec3> = HashMap::new();
    // Whether a mesh has any normals, given or smooth; of one that has none they are made later.
    let mut with_normals: HashMap<(usize, usize), bool> = HashMap::new();
    for (face, corners) in geometry.faces.iter().zip(&polygons) {
        let key = (face.group, material_of(face));
        let smoothed = face.smoothing > 0 && corners.iter().any(|corner| corner[2] == NONE);
        let given = corners.iter().any(|corner| corner[2] != NONE);
        *with_normals.entry(key).or_default() |= smoothed || given;
        if smoothed {
            let places: Vec<_> = positions(corners);
            let normal = polygon::area_normal(&places);
            for corner in corners.iter().filter(|_| normal.is_finite()) {
                *smooth.entry((face.smoothing, corner[0])).or_default() += normal;
            }
        }
    }
    let mut parts: Vec<Part> = Vec::new();
    let mut numbers: HashMap<(usize, usize), usize> = HashMap::new();
    for (number, (face, corners)) in geometry.faces.iter().zip(&polygons).enumerate() {
        let places: Vec<_> = positions(corners);
        if !places.iter().all(|place| place.is_finite()) {
            faults.add(face.place, "the face has a vertex whose line cannot be read");
            continue;
        }
        let Some(triangles) = polygon::triangles(&places) else {
            let most = polygon::MOST_CORNERS;
            let message =
                format!("the face is not convex and has more than {most} corners; split it");
            faults.add(face.place, message);
            continue;
        };
        let key = (face.group, material_of(face));
        let part = *numbers.entry(key).or_insert_with(|| {
            parts.push(Part::new(geometry, key));
            parts.len() - 1
        });
        let any_normals = with_normals.get(&key).copied().unwrap_or_default();
        let part = &mut parts[part];
        let flat = polygon::area_normal(&places);
        let vertices: Vec<u32> = corners
            .iter()
            .map(|corner| {
                let normal = match (corner[2], face.smoothing) {
                    (NONE, _) if !any_normals => Normal::Later,
                    (NONE, 0) => Normal::Flat(number),
                    (NONE, group) => Normal::Smooth(group),
                    (given, _) => Normal::Given(given),
                };
                part.vertex(geometry, corner, normal, flat, &smooth)
            })
            .collect();
        let indices = triangles.iter().flatten().map(|&corner| vertices[corner]);
        part.built.raw.indices.extend(indices);
    }
    parts.into_iter().map(Part::finish).collect()
}

/// The corners of a face without those that repeat the one before.
fn polygon_of(geometry: &Geometry, face: &Face) -> Vec<Corner> {
    let corners = geometry.corners.get(face.first..face.first + face.count).unwrap_or_default();
    let mut kept: Vec<Corner> = corners.to_vec();
    kept.dedup_by_key(|corner| corner[0]);
    while kept.len() > 1
        && kept.first().map(|corner| corner[0]) == kept.last().map(|corner| corner[0])
    {
        kept.pop();
    }
    kept
}

fn position(geometry: &Geometry, corner: &Corner) -> DVec3 {
    geometry.positions.get(corner[0] as usize).map_or(DVec3::NAN, |&position| position.into())
}

impl Part {
    fn new(geometry: &Geometry, (group, material): (usize, usize)) -> Self {
        let name = geometry.groups.get(group).cloned().unwrap_or_default();
        let raw = RawMesh { name, material, ..RawMesh::default() };
        Self {
            built: Built { raw, ..Built::default() },
            known: HashMap::new(),
            any_uvs: false,
            any_without_uvs: false,
        }
    }

    /// The number of a corner's vertex, made where there is none like it.
    fn vertex(
        &mut self,
        geometry: &Geometry,
        corner: &Corner,
        normal: Normal,
        flat: DVec3,
        smooth: &HashMap<(u32, u32), DVec3>,
    ) -> u32 {
        let [place, uv, _] = *corner;
        self.any_uvs |= uv != NONE;
        self.any_without_uvs |= uv == NONE;
        let Built { raw, colors, smoothed, partly_without_normals, .. } = &mut self.built;
        *self.known.entry((place, uv, normal)).or_insert_with(|| {
            raw.positions.push(position(geometry, corner).into());
            let unit = |normal: DVec3| normal.normalize_or_zero().as_vec3().into();
            match normal {
                Normal::Later => {}
                Normal::Given(index) => {
                    let given = geometry.normals.get(index as usize).copied();
                    raw.normals.push(given.unwrap_or_default());
                }
                Normal::Smooth(group) => {
                    *smoothed = true;
                    raw.normals
                        .push(unit(smooth.get(&(group, place)).copied().unwrap_or_default()));
                }
                Normal::Flat(_) => {
                    *partly_without_normals = true;
                    raw.normals.push(unit(flat));
                }
            }
            // The image's first row is at v = 1 in OBJ.
            let [u, v] = geometry.uvs.get(uv as usize).copied().unwrap_or_default();
            raw.uvs.push([u, 1.0 - v]);
            let color = geometry.colors.get(place as usize);
            colors.extend(color.map(|&[r, g, b]| [r, g, b, 1.0]));
            (raw.positions.len() - 1) as u32
        })
    }

    fn finish(mut self) -> Built {
        if !self.any_uvs {
            self.built.raw.uvs.clear();
        }
        self.built.partly_without_uvs = self.any_uvs && self.any_without_uvs;
        self.built
    }
}
