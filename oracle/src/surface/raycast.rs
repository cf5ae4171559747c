//! The nearest triangle along a ray, by trying all: what a rasteriser has to show.

use rayon::prelude::*;

use crate::Vector3;

/// A half-line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// Where it starts.
    pub origin: Vector3,
    /// Unit direction.
    pub direction: Vector3,
}

/// A triangle with shading normals.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Triangle {
    /// World positions.
    pub positions: [Vector3; 3],
    /// Shading normals at the positions; any length but 0.
    pub normals: [Vector3; 3],
    /// The material's number.
    pub material: u32,
}

/// What a ray meets first.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Distance along the ray, above 0.
    pub distance: f64,
    /// World position.
    pub position: Vector3,
    /// Unit shading normal, facing the ray's origin by the triangle's own side.
    pub normal: Vector3,
    /// Barycentric weights of the three corners.
    pub weights: [f64; 3],
    /// The triangle's number.
    pub triangle: usize,
    /// The material's number.
    pub material: u32,
}

/// A camera that looks along `forward`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// The centre of a perspective image's rays, or of an orthographic image's plane.
    pub position: Vector3,
    /// Unit vector to the right of the image.
    pub right: Vector3,
    /// Unit vector to the top of the image.
    pub up: Vector3,
    /// Unit vector into the image.
    pub forward: Vector3,
    /// Half extents of the image, horizontally and vertically: on the plane at unit distance, or in world units.
    pub half_extent: [f64; 2],
    /// Whether rays start at `position` and spread; otherwise they are parallel.
    pub perspective: bool,
}

impl Camera {
    /// The ray through a point of an image of `width` by `height` texels; texel centres are at half-integers, row 0 is
    /// the top.
    #[must_use]
    pub fn ray(&self, [x, y]: [f64; 2], [width, height]: [usize; 2]) -> Ray {
        let u = self.half_extent[0] * (2.0 * x / width as f64 - 1.0);
        let v = self.half_extent[1] * (1.0 - 2.0 * y / height as f64);
        let offset = self.right * u + self.up * v;
        if self.perspective {
            Ray { origin: self.position, direction: (self.forward + offset).normalized() }
        } else {
            Ray { origin: self.position + offset, direction: self.forward }
        }
    }

    /// What the camera sees through every texel's centre, row by row from the top.
    #[must_use]
    pub fn image(&self, triangles: &[Triangle], size: [usize; 2]) -> Vec<Option<Hit>> {
        (0..size[0] * size[1])
            .into_par_iter()
            .map(|index| {
                let (x, y) = (index % size[0], index / size[0]);
                nearest_hit(triangles, &self.ray([x as f64 + 0.5, y as f64 + 0.5], size))
            })
            .collect()
    }
}

/// The nearest hit of a ray with triangles, from either side.
// [Moller and Trumbore 1997, Fast, minimum storage ray/triangle intersection]
#[must_use]
pub fn nearest_hit(triangles: &[Triangle], ray: &Ray) -> Option<Hit> {
    let mut nearest: Option<(f64, usize, [f64; 3])> = None;
    for (number, triangle) in triangles.iter().enumerate() {
        let [a, b, c] = triangle.positions;
        let (ab, ac) = (b - a, c - a);
        let p = ray.direction.cross(ac);
        let determinant = ab.dot(p);
        if determinant == 0.0 {
            continue;
        }
        let from = ray.origin - a;
        let second = from.dot(p) / determinant;
        let q = from.cross(ab);
        let third = ray.direction.dot(q) / determinant;
        let distance = ac.dot(q) / determinant;
        let first = 1.0 - second - third;
        if first >= 0.0
            && second >= 0.0
            && third >= 0.0
            && distance > 0.0
            && nearest.is_none_or(|hit| distance < hit.0)
        {
            nearest = Some((distance, number, [first, second, third]));
        }
    }
    nearest.map(|(distance, number, weights)| {
        let triangle = &triangles[number];
        let [a, b, c] = triangle.positions;
        let blend = |corners: [Vector3; 3]| {
            corners[0] * weights[0] + corners[1] * weights[1] + corners[2] * weights[2]
        };
        let geometric = (b - a).cross(c - a);
        let shading = blend(triangle.normals).normalized_or(geometric);
        // The shading normal belongs to the side that the geometric normal points to.
        let side = geometric.dot(ray.direction).signum() * geometric.dot(shading).signum();
        Hit {
            distance,
            position: blend(triangle.positions),
            normal: if side > 0.0 { -shading } else { shading },
            weights,
            triangle: number,
            material: triangle.material,
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn wall(z: f64, normal_z: f64, material: u32) -> Triangle {
        Triangle {
            positions: [
                Vector3::new(-9.0, -9.0, z),
                Vector3::new(9.0, -9.0, z),
                Vector3::new(0.0, 9.0, z),
            ],
            normals: [Vector3::new(0.0, 0.0, normal_z); 3],
            material,
        }
    }

    #[test]
    fn the_nearest_wall_is_seen_and_faces_the_viewer() {
        let walls = [wall(-5.0, 1.0, 0), wall(-3.0, -2.0, 1), wall(4.0, 1.0, 2)];
        let camera = Camera {
            position: Vector3::zero(),
            right: Vector3::new(1.0, 0.0, 0.0),
            up: Vector3::new(0.0, 1.0, 0.0),
            forward: Vector3::new(0.0, 0.0, -1.0),
            half_extent: [1.0, 1.0],
            perspective: true,
        };
        let image = camera.image(&walls, [4, 4]);
        let hit = image[4 + 2].unwrap();
        assert_eq!((hit.triangle, hit.material), (1, 1));
        assert!((hit.position - Vector3::new(0.75, 0.75, -3.0)).length() < 1e-14);
        assert!((hit.normal - Vector3::new(0.0, 0.0, 1.0)).length() < 1e-14);
        // The corner of the triangle is cut: the top left texel sees it no longer with a wide image.
        let wide = Camera { half_extent: [9.0, 9.0], ..camera };
        assert!(wide.image(&walls, [4, 4])[0].is_none());
        let parallel = Camera { perspective: false, ..camera };
        assert_eq!(parallel.ray([4.0, 0.0], [4, 4]).origin, Vector3::new(1.0, 1.0, 0.0));
    }
}
