//! Tangents of vertices: where the texture coordinates of a normal map lead on the surface.

use glam::{DVec3, Vec2, Vec3};

use super::mesh::Mesh;
use super::{TextureUse, UvTransform};

/// What is known of a vertex on one side of its texture: the sum of the tangents there.
#[derive(Clone, Copy, Default)]
struct Side {
    sum: DVec3,
    used: bool,
}

impl Mesh {
    /// Makes [`super::Detail::tangents`] for a normal map that is read in this way. Vertices at which a texture and its
    /// mirror image meet become two. Without texture coordinates there are none.
    ///
    /// As in MikkTSpace, without its welding of vertices: of a triangle the direction of rising u, of a vertex the mean over its
    /// triangles, each weighed by its angle there. [Mikkelsen 2008]
    pub fn derive_tangents(&mut self, map: &TextureUse) {
        let uvs = if map.second { &self.detail.uvs } else { &self.uvs };
        self.detail.tangents.clear();
        if uvs.is_empty() {
            return;
        }
        let uvs: Vec<Vec2> = uvs.iter().map(|&uv| transformed(&map.transform, uv)).collect();
        let count = self.positions.len();
        let mut sides = vec![[Side::default(); 2]; count];
        let mut of_triangle = Vec::with_capacity(self.triangle_count());
        for corners in self.indices.as_chunks::<3>().0 {
            let at = corners.map(|index| index as usize);
            let positions = at.map(|index| Vec3::from(self.positions[index]).as_dvec3());
            let normal = at.iter().map(|&index| Vec3::from(self.normals[index]).as_dvec3()).sum();
            let (tangent, mirrored) = of(positions, at.map(|index| uvs[index]), normal);
            of_triangle.push(mirrored);
            for corner in 0..3 {
                let side = &mut sides[at[corner]][usize::from(mirrored)];
                side.used = true;
                let [from, to, other] = [0, 1, 2].map(|step| positions[(corner + step) % 3]);
                let own = Vec3::from(self.normals[at[corner]]).as_dvec3();
                let weight = (to - from).angle_between(other - from);
                let along = (tangent - own * own.dot(tangent)).normalize_or_zero();
                if weight.is_finite() {
                    side.sum += weight * along;
                }
            }
        }
        // Of a vertex with both sides, the mirrored one is a new vertex.
        let mut second = vec![0; count];
        for (vertex, [plain, mirrored]) in sides.iter().enumerate() {
            if plain.used && mirrored.used {
                second[vertex] = self.copy(vertex);
            }
        }
        for (corners, &mirrored) in self.indices.as_chunks_mut::<3>().0.iter_mut().zip(&of_triangle)
        {
            for corner in corners.iter_mut().filter(|_| mirrored) {
                let moved = second[*corner as usize];
                *corner = if moved > 0 { moved } else { *corner };
            }
        }
        let tangent =
            |side: &Side, sign: f32| side.sum.normalize_or_zero().as_vec3().extend(sign).to_array();
        let mut tangents = vec![[0.0; 4]; self.positions.len()];
        for (vertex, [plain, mirrored]) in sides.iter().enumerate() {
            if plain.used || !mirrored.used {
                tangents[vertex] = tangent(plain, 1.0);
            }
            if mirrored.used {
                let own = if second[vertex] > 0 { second[vertex] as usize } else { vertex };
                tangents[own] = tangent(mirrored, -1.0);
            }
        }
        self.detail.tangents = tangents;
    }
}

/// The direction of rising u on a triangle, of unit length, and whether the texture is seen mirrored; none where the texture
/// coordinates lie on a line.
fn of([a, b, c]: [DVec3; 3], [u, v, w]: [Vec2; 3], normal: DVec3) -> (DVec3, bool) {
    let (first, second) = (b - a, c - a);
    let [one, two] = [v - u, w - u].map(|step| step.as_dvec2());
    let area = one.x * two.y - one.y * two.x;
    if !(area.is_finite() && area != 0.0) {
        return (DVec3::ZERO, false);
    }
    let sign = area.signum();
    let along = sign * (first * two.y - second * one.y);
    let down = sign * (second * one.x - first * two.x);
    // v points down, a normal map's green up.
    (along.normalize_or_zero(), normal.cross(along).dot(down) > 0.0)
}

fn transformed(transform: &UvTransform, [u, v]: [f32; 2]) -> Vec2 {
    let [x, y] = transform.rows().map(|[a, b, c]| a * u + b * v + c);
    Vec2::new(x, y)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::Detail;

    /// A square that faces +z, u to the right and v down.
    fn square() -> Mesh {
        Mesh {
            name: "square".to_owned(),
            positions: vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]],
            normals: vec![[0.0, 0.0, 1.0]; 4],
            uvs: vec![[0.0, 1.0], [1.0, 1.0], [1.0, 0.0], [0.0, 0.0]],
            indices: vec![0, 1, 2, 0, 2, 3],
            material: 0,
            detail: Detail::default(),
        }
    }

    #[test]
    fn tangents_follow_u_and_its_mirror_images() {
        let map = TextureUse::repeating(0);
        let mut plain = square();
        plain.derive_tangents(&map);
        assert_eq!(plain.detail.tangents, [[1.0, 0.0, 0.0, 1.0]; 4]);
        let mut mirrored = square();
        mirrored.uvs.iter_mut().for_each(|uv| uv[0] = 1.0 - uv[0]);
        mirrored.derive_tangents(&map);
        assert_eq!(mirrored.detail.tangents, [[-1.0, 0.0, 0.0, -1.0]; 4]);
        // A quarter turn of the texture's coordinates.
        let mut turned = square();
        let transform =
            UvTransform { rotation: std::f32::consts::FRAC_PI_2, ..UvTransform::default() };
        turned.derive_tangents(&TextureUse { transform, ..map });
        for tangent in &turned.detail.tangents {
            let [x, y, z, w] = *tangent;
            assert!(
                x.abs() < 1e-6 && (y + 1.0).abs() < 1e-6 && z == 0.0 && w == 1.0,
                "{tangent:?}"
            );
        }
        // None without texture coordinates, and none in lines.
        let mut bare = Mesh { uvs: Vec::new(), ..square() };
        bare.derive_tangents(&map);
        assert!(bare.detail.tangents.is_empty());
        let mut line = Mesh { uvs: vec![[0.5; 2]; 4], ..square() };
        line.derive_tangents(&map);
        assert_eq!(line.detail.tangents, [[0.0, 0.0, 0.0, 1.0]; 4]);
    }

    #[test]
    fn vertices_between_a_texture_and_its_mirror_image_are_two() {
        // To the left of the square, its mirror image.
        let mut mesh = square();
        mesh.positions.extend([[-1.0, 0.0, 0.0], [-1.0, 1.0, 0.0]]);
        mesh.normals.extend([[0.0, 0.0, 1.0]; 2]);
        mesh.uvs.extend([[1.0, 1.0], [1.0, 0.0]]);
        mesh.indices.extend([4, 0, 3, 4, 3, 5]);
        mesh.derive_tangents(&TextureUse::repeating(0));
        assert_eq!(mesh.positions.len(), 8);
        for (triangle, corners) in mesh.indices.as_chunks::<3>().0.iter().enumerate() {
            let expected = if triangle < 2 { [1.0, 0.0, 0.0, 1.0] } else { [-1.0, 0.0, 0.0, -1.0] };
            for &corner in corners {
                assert_eq!(mesh.detail.tangents[corner as usize], expected, "{triangle}");
            }
        }
        assert_eq!(mesh.triangles().nth(2), Some([[-1.0, 0.0, 0.0], [0.0; 3], [0.0, 1.0, 0.0]]));
    }
}
