//! Meshes from surfaces: patches, boxes, surfaces of revolution.

use std::f32::consts::TAU;

use glam::{DVec3, Vec2, Vec3};

use crate::mesh::RawMesh;

/// A point of a surface.
#[derive(Clone, Copy)]
pub(super) struct Vertex {
    pub(super) position: Vec3,
    pub(super) normal: Vec3,
    /// In metres along the surface, so that textures keep their size.
    pub(super) uv: Vec2,
}

/// A mesh while it is made.
pub(super) struct Shape(RawMesh);

impl Shape {
    pub(super) fn new(name: &str, material: usize) -> Self {
        Self(RawMesh { name: name.to_owned(), material, ..RawMesh::default() })
    }

    pub(super) fn into_mesh(self) -> RawMesh {
        self.0
    }

    pub(super) fn triangle_count(&self) -> usize {
        self.0.indices.len() / 3
    }

    /// A grid of `columns` by `rows` cells over `at(u, v)` with u and v from 0 to 1. Its front is
    /// where u points right and v points up. Cells that shrink to a line lose a triangle.
    pub(super) fn patch(&mut self, columns: u32, rows: u32, at: impl Fn(f32, f32) -> Vertex) {
        let mesh = &mut self.0;
        let first = mesh.positions.len() as u32;
        for row in 0..=rows {
            for column in 0..=columns {
                let vertex = at(column as f32 / columns as f32, row as f32 / rows as f32);
                mesh.positions.push(vertex.position.as_dvec3().into());
                mesh.normals.push(vertex.normal.into());
                mesh.uvs.push(vertex.uv.into());
            }
        }
        let width = columns + 1;
        for row in 0..rows {
            for column in 0..columns {
                let corner = first + row * width + column;
                let [a, b, c, d] = [corner, corner + 1, corner + width + 1, corner + width];
                for triangle in [[a, b, c], [a, c, d]] {
                    let [x, y, z] =
                        triangle.map(|i| DVec3::from(mesh.positions[i as usize]).as_vec3());
                    if (y - x).cross(z - x).length_squared() > 0.0 {
                        mesh.indices.extend(triangle);
                    }
                }
            }
        }
    }

    /// A smooth patch over positions alone: normals and texture coordinates follow from them. `size`
    /// is its extent in metres.
    pub(super) fn sheet(
        &mut self,
        columns: u32,
        rows: u32,
        size: Vec2,
        at: impl Fn(f32, f32) -> Vec3,
    ) {
        const STEP: f32 = 1e-3;
        self.patch(columns, rows, |u, v| {
            let across = at(u + STEP, v) - at(u - STEP, v);
            let along = at(u, v + STEP) - at(u, v - STEP);
            Vertex {
                position: at(u, v),
                normal: across.cross(along).normalize(),
                uv: Vec2::new(u, 1.0 - v) * size,
            }
        });
    }

    /// A flat quadrilateral with the given corners in order, seen from `viewer`.
    pub(super) fn quad(&mut self, mut corners: [Vec3; 4], viewer: Vec3) {
        let facing = |[a, b, c, _]: [Vec3; 4]| (b - a).cross(c - a);
        let middle = corners.iter().sum::<Vec3>() * 0.25;
        if facing(corners).dot(viewer - middle) < 0.0 {
            corners.reverse();
        }
        let normal = facing(corners).normalize();
        let [a, b, c, d] = corners;
        let (width, height) = (a.distance(b), a.distance(d));
        self.patch(1, 1, |u, v| Vertex {
            position: a.lerp(b, u).lerp(d.lerp(c, u), v),
            normal,
            uv: Vec2::new(u * width, (1.0 - v) * height),
        });
    }

    /// A box along the axes, seen from outside.
    pub(super) fn cuboid(&mut self, min: Vec3, max: Vec3) {
        let middle = (min + max) * 0.5;
        let half = (max - min) * 0.5;
        for axis in 0..3 {
            for side in [-1.0, 1.0] {
                let mut normal = Vec3::ZERO;
                normal[axis] = side;
                // Walls have their texture upright, floors along x.
                let up = if axis == 1 { Vec3::NEG_Z * side } else { Vec3::Y };
                let right = up.cross(normal);
                let (across, along) = (right * half, up * half);
                let center = middle + normal * half;
                let (width, height) = (across.length() * 2.0, along.length() * 2.0);
                self.patch(1, 1, |u, v| Vertex {
                    position: center + across * (2.0 * u - 1.0) + along * (2.0 * v - 1.0),
                    normal,
                    uv: Vec2::new(u * width, (1.0 - v) * height),
                });
            }
        }
    }

    /// A surface of revolution around the vertical through `foot`: `profile(t)` with t from 0 to 1
    /// gives radius and height. Seen from outside where the profile rises.
    pub(super) fn lathe(
        &mut self,
        foot: Vec3,
        segments: u32,
        rows: u32,
        profile: impl Fn(f32) -> Vec2,
    ) {
        const STEP: f32 = 1e-3;
        let girth = TAU * profile(0.0).x.max(profile(1.0).x);
        let length = (0..rows)
            .map(|row| {
                let at = |row: u32| profile(row as f32 / rows as f32);
                at(row).distance(at(row + 1))
            })
            .sum::<f32>();
        self.patch(segments, rows, |u, v| {
            let (sin, cos) = (TAU * u).sin_cos();
            let radial = Vec3::new(sin, 0.0, cos);
            let point = profile(v);
            // One-sided at the ends, where the profile may have its edges.
            let tangent = profile((v + STEP).min(1.0)) - profile((v - STEP).max(0.0));
            Vertex {
                position: foot + radial * point.x + Vec3::Y * point.y,
                normal: (radial * tangent.y - Vec3::Y * tangent.x).normalize(),
                uv: Vec2::new(u * girth, (1.0 - v) * length),
            }
        });
    }
}
