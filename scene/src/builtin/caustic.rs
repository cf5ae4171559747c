//! A ring of polished metal on a diffuse floor, lit from the side: light that the inside of the ring
//! reflects gathers in a cardioid on the floor.

use std::f32::consts::PI;

use glam::{Vec2, Vec3};

use super::shape::Shape;
use crate::draft::Draft;
use crate::{Camera, Light, LightKind, Material};

const RADIUS: f32 = 1.0;
const THICKNESS: f32 = 0.03;
const HEIGHT: f32 = 0.6;

/// Half of the floor's side.
const FLOOR: f32 = 5.0;

pub(super) fn make() -> Draft {
    const SEGMENTS: u32 = 192;
    let mut floor = Shape::new("floor", 0);
    floor.quad(
        [[-FLOOR, FLOOR], [FLOOR, FLOOR], [FLOOR, -FLOOR], [-FLOOR, -FLOOR]]
            .map(|[x, z]| Vec3::new(x, 0.0, z)),
        Vec3::Y,
    );
    let mut ring = Shape::new("ring", 1);
    let outer = RADIUS + THICKNESS;
    // Outside, the rim, and inside, where the profile falls.
    ring.lathe(Vec3::ZERO, SEGMENTS, 6, |t| Vec2::new(outer, HEIGHT * t));
    ring.lathe(Vec3::ZERO, SEGMENTS, 1, |t| Vec2::new(outer - THICKNESS * t, HEIGHT));
    ring.lathe(Vec3::ZERO, SEGMENTS, 6, |t| Vec2::new(RADIUS, HEIGHT * (1.0 - t)));

    let position = Vec3::new(-4.6, 3.3, -0.8);
    let distance = position.length();
    Draft {
        meshes: vec![floor.into_mesh(), ring.into_mesh()],
        materials: vec![
            Material::diffuse("floor", [0.6, 0.6, 0.6]),
            Material {
                roughness: 0.2,
                metallic: 1.0,
                ..Material::diffuse("brass", [0.91, 0.78, 0.42])
            },
        ],
        lights: vec![
            Light {
                name: "spot".to_owned(),
                kind: LightKind::Spot { inner: 18_f32.to_radians(), outer: 26_f32.to_radians() },
                position: position.into(),
                direction: (-position / distance).into(),
                // An irradiance of pi at right angles to the light, at the ring.
                intensity: [PI * distance * distance; 3],
                range: None,
                map_share: 1.0,
            }
            .into(),
        ],
        camera: Some(
            Camera::look_at([0.6, 3.2, 3.4], [0.0, 0.1, 0.0], [0.0, 1.0, 0.0], 42_f32.to_radians())
                .into(),
        ),
        ..Draft::default()
    }
}
