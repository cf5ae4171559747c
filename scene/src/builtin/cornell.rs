//! The Cornell box, with the published measurements.
//!
//! [Goral et al. 1984], measured again by the Cornell Program of Computer Graphics ("Cornell box
//! data"). A millimetre there is a centimetre here, so that the box is 5.5 m wide.

use glam::Vec3;

use super::shape::Shape;
use crate::draft::Draft;
use crate::{Camera, Light, LightKind, Material};

/// A published millimetre, in metres.
const MILLIMETRE: f32 = 0.01;

/// The spectra of the paints, as customarily rounded to linear Rec. 709.
const WHITE: [f32; 3] = [0.725, 0.71, 0.68];
const RED: [f32; 3] = [0.63, 0.065, 0.05];
const GREEN: [f32; 3] = [0.14, 0.45, 0.091];

/// The footprints of the two blocks, x and z.
const SHORT: [[f32; 2]; 4] = [[130.0, 65.0], [82.0, 225.0], [240.0, 272.0], [290.0, 114.0]];
const TALL: [[f32; 2]; 4] = [[423.0, 247.0], [265.0, 296.0], [314.0, 456.0], [472.0, 406.0]];

/// The box as published: diffuse throughout.
pub(super) fn diffuse() -> Draft {
    let white = Material::diffuse("white", WHITE);
    make(Material { name: "floor".to_owned(), ..white.clone() }, white)
}

/// The box with a polished floor and a tall block of metal.
pub(super) fn glossy() -> Draft {
    let floor = Material {
        roughness: 0.35,
        dielectric: 0.04,
        ..Material::diffuse("polished floor", WHITE)
    };
    let metal = Material {
        roughness: 0.3,
        metallic: 1.0,
        ..Material::diffuse("metal", [0.95, 0.93, 0.88])
    };
    make(floor, metal)
}

fn make(floor: Material, tall: Material) -> Draft {
    let middle = point([278.0, 273.0, 279.6]);
    let materials = vec![
        Material::diffuse("white", WHITE),
        Material::diffuse("red", RED),
        Material::diffuse("green", GREEN),
        floor,
        tall,
    ];
    let wall = |name: &str, material: usize, corners: [[f32; 3]; 4]| {
        let mut shape = Shape::new(name, material);
        shape.quad(corners.map(point), middle);
        shape.into_mesh()
    };
    let meshes = vec![
        wall(
            "floor",
            3,
            [[552.8, 0.0, 0.0], [0.0, 0.0, 0.0], [0.0, 0.0, 559.2], [549.6, 0.0, 559.2]],
        ),
        wall(
            "ceiling",
            0,
            [[556.0, 548.8, 0.0], [556.0, 548.8, 559.2], [0.0, 548.8, 559.2], [0.0, 548.8, 0.0]],
        ),
        wall(
            "back wall",
            0,
            [[549.6, 0.0, 559.2], [0.0, 0.0, 559.2], [0.0, 548.8, 559.2], [556.0, 548.8, 559.2]],
        ),
        wall(
            "right wall",
            2,
            [[0.0, 0.0, 559.2], [0.0, 0.0, 0.0], [0.0, 548.8, 0.0], [0.0, 548.8, 559.2]],
        ),
        wall(
            "left wall",
            1,
            [[552.8, 0.0, 0.0], [549.6, 0.0, 559.2], [556.0, 548.8, 559.2], [556.0, 548.8, 0.0]],
        ),
        block("short block", 0, SHORT, 165.0),
        block("tall block", 4, TALL, 330.0),
    ];
    Draft {
        meshes,
        materials,
        lights: vec![
            Light {
                name: "ceiling light".to_owned(),
                kind: LightKind::Spot { inner: 45_f32.to_radians(), outer: 75_f32.to_radians() },
                position: point([278.0, 548.0, 279.5]).into(),
                direction: [0.0, -1.0, 0.0],
                // The hue of the published light; its strength gives the floor a radiance near 1.
                intensity: [135.0, 95.0, 50.0],
                range: None,
                map_share: 1.0,
            }
            .into(),
        ],
        // [Cornell box data: focal length 35 mm, film 25 mm x 25 mm]
        camera: Some(
            Camera::look_at(
                point([278.0, 273.0, -800.0]).into(),
                middle.into(),
                [0.0, 1.0, 0.0],
                2.0 * (12.5_f32 / 35.0).atan(),
            )
            .into(),
        ),
        ..Draft::default()
    }
}

fn point([x, y, z]: [f32; 3]) -> Vec3 {
    Vec3::new(x, y, z) * MILLIMETRE
}

/// The top and the four sides of a block that stands on the floor.
fn block(
    name: &str,
    material: usize,
    footprint: [[f32; 2]; 4],
    height: f32,
) -> crate::mesh::RawMesh {
    let mut shape = Shape::new(name, material);
    let at = |corner: usize, y: f32| {
        let [x, z] = footprint[corner % 4];
        point([x, y, z])
    };
    let middle = (0..4).map(|corner| at(corner, height * 0.5)).sum::<Vec3>() * 0.25;
    // From outside is from the other side of the face than the middle.
    let mut outside = |corners: [Vec3; 4]| {
        let center = corners.iter().sum::<Vec3>() * 0.25;
        shape.quad(corners, center * 2.0 - middle);
    };
    outside([0, 1, 2, 3].map(|corner| at(corner, height)));
    for side in 0..4 {
        outside([at(side, 0.0), at(side, height), at(side + 1, height), at(side + 1, 0.0)]);
    }
    shape.into_mesh()
}
