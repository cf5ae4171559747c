//! A hall with a row of columns between the lamp and the far wall: direct and indirect light, both
//! occluded.

use glam::{Vec2, Vec3};

use super::shape::Shape;
use crate::draft::Draft;
use crate::{Camera, Light, LightKind, Material};

/// Half the width, the height, and half the depth of the hall in metres.
const HALF: Vec3 = Vec3::new(7.0, 4.5, 4.0);

const COLUMNS: u32 = 6;
const SPACING: f32 = 2.0;

pub(super) fn make() -> Draft {
    let Vec3 { x, y, z } = HALF;
    let inside = Vec3::new(0.0, y * 0.5, 0.0);
    let mut meshes = Vec::new();
    for (name, material, corners) in [
        ("floor", 0, [[-x, 0.0, z], [x, 0.0, z], [x, 0.0, -z], [-x, 0.0, -z]]),
        ("ceiling", 0, [[-x, y, z], [x, y, z], [x, y, -z], [-x, y, -z]]),
        ("far wall", 0, [[-x, 0.0, -z], [x, 0.0, -z], [x, y, -z], [-x, y, -z]]),
        ("left wall", 1, [[-x, 0.0, z], [-x, 0.0, -z], [-x, y, -z], [-x, y, z]]),
        ("right wall", 2, [[x, 0.0, z], [x, 0.0, -z], [x, y, -z], [x, y, z]]),
    ] {
        let mut shape = Shape::new(name, material);
        shape.quad(corners.map(Vec3::from), inside);
        meshes.push(shape.into_mesh());
    }
    let first = -SPACING * (COLUMNS - 1) as f32 * 0.5;
    for index in 0..COLUMNS {
        let mut shape = Shape::new(&format!("column {index}"), 3);
        let foot = Vec3::new(first + SPACING * index as f32, 0.0, -0.4);
        for (bottom, top) in [(0.0, 0.25), (y - 0.25, y)] {
            let half = Vec3::new(0.42, 0.0, 0.42);
            shape.cuboid(foot - half + Vec3::Y * bottom, foot + half + Vec3::Y * top);
        }
        // A shaft that tapers a little.
        shape.lathe(foot, 48, 8, |t| Vec2::new(0.32 - 0.05 * t, 0.25 + (y - 0.5) * t));
        meshes.push(shape.into_mesh());
    }
    let position = Vec3::new(-6.2, 3.4, 2.8);
    let direction = (Vec3::new(2.5, 0.9, -2.5) - position).normalize();
    Draft {
        meshes,
        materials: vec![
            Material::diffuse("plaster", [0.75, 0.73, 0.7]),
            Material::diffuse("blue wall", [0.16, 0.3, 0.6]),
            Material::diffuse("orange wall", [0.75, 0.36, 0.1]),
            Material::diffuse("stone", [0.6, 0.58, 0.52]),
        ],
        lights: vec![
            Light {
                name: "lamp".to_owned(),
                kind: LightKind::Spot { inner: 30_f32.to_radians(), outer: 45_f32.to_radians() },
                position: position.into(),
                direction: direction.into(),
                intensity: [280.0, 262.0, 230.0],
                range: None,
                map_share: 1.0,
            }
            .into(),
        ],
        camera: Some(
            Camera::look_at([0.8, 2.0, 8.1], [0.0, 2.0, 0.0], [0.0, 1.0, 0.0], 45_f32.to_radians())
                .into(),
        ),
        ..Draft::default()
    }
}
