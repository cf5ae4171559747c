//! A court between two storeys of arcades, open to the sun: tiles and brick, drapes, balustrades,
//! a basin, and plants cut out of cards. It stands in for the papers' large scenes.
//!
//! x runs along the court, z across it; metres.

use std::f32::consts::{PI, TAU};
use std::ops::RangeInclusive;

use glam::{Vec2, Vec3};

use super::paint;
use super::shape::{Shape, Vertex};
use crate::draft::Draft;
use crate::{Camera, Light, LightKind, Material, TextureUse, UvTransform, Wrap};

/// The numbers of triangles that can be requested.
pub(super) const RANGE: RangeInclusive<usize> = 15_000..=2_000_000;

/// Half the court's length and width, to the axes of its columns.
const COURT: Vec2 = Vec2::new(9.0, 3.5);
/// From the axes of the columns to the outer walls.
const AISLE: f32 = 3.5;
const WALL: f32 = 0.3;
/// Half the thickness of the arcades.
const ARCADE: f32 = 0.28;

/// One storey of arcades.
struct Storey {
    floor: f32,
    /// Where the capitals end and the arches spring.
    spring: f32,
    /// The lower edge of the slab above.
    top: f32,
    column_radius: f32,
}

const STOREYS: [Storey; 2] = [
    Storey { floor: 0.0, spring: 2.75, top: 4.2, column_radius: 0.24 },
    Storey { floor: 4.6, spring: 7.0, top: 8.4, column_radius: 0.19 },
];

/// Upper face of the roof.
const ROOF: f32 = 8.8;

/// Number of bays along and across the court.
const BAYS: [u32; 2] = [6, 3];

/// The atrium with about `triangles` triangles, within one part in a hundred.
pub(super) fn with_triangles(triangles: usize) -> Draft {
    let mut detail = 1.0_f32;
    let mut made = Atrium::new(detail);
    // Triangles grow with the square of the detail, but for what is flat and for rounding.
    for _ in 0..12 {
        let ratio = triangles as f32 / made.triangle_count() as f32;
        if (ratio - 1.0).abs() < 0.005 {
            break;
        }
        detail *= ratio.sqrt();
        made = Atrium::new(detail);
    }
    made.into_draft()
}

/// The atrium with few triangles, about 26 thousand.
pub(super) fn small() -> Draft {
    Atrium::new(0.5).into_draft()
}

const MATERIALS: usize = 12;

/// One mesh for each material.
struct Atrium {
    shapes: [Shape; MATERIALS],
    detail: f32,
    /// Where [`Atrium::pieces`] rounds up.
    turn: f32,
}

/// Indices of the materials, in the order of [`materials`].
#[derive(Clone, Copy)]
enum Is {
    Tiles,
    Brick,
    Stone,
    Plaster,
    Wood,
    RedDrape,
    GreenDrape,
    BlueDrape,
    Leaf,
    Terracotta,
    Bronze,
    Soil,
}

/// The images, in the order of [`Atrium::into_draft`].
enum Picture {
    Tiles,
    Bricks,
    Stone,
    Fabric,
    Leaf,
}

fn materials() -> [Material; MATERIALS] {
    let solid = |name: &str, color: [f32; 3], roughness: f32| Material {
        roughness,
        dielectric: 0.04,
        ..Material::diffuse(name, color)
    };
    let textured = |material: Material, picture: Picture, metres: f32| Material {
        base_color_texture: Some(TextureUse {
            transform: UvTransform { scale: [1.0 / metres; 2], ..UvTransform::default() },
            ..TextureUse::repeating(picture as usize)
        }),
        ..material
    };
    let drape = |name: &str, color: [f32; 3]| {
        let cloth = Material { double_sided: true, ..solid(name, color, 0.95) };
        textured(cloth, Picture::Fabric, 0.4)
    };
    [
        textured(solid("tiles", [1.0; 3], 0.25), Picture::Tiles, 1.6),
        textured(solid("brick", [1.0; 3], 0.9), Picture::Bricks, 1.2),
        textured(solid("stone", [1.0; 3], 0.7), Picture::Stone, 2.0),
        textured(solid("plaster", [1.0, 0.93, 0.8], 0.85), Picture::Stone, 3.0),
        solid("wood", [0.24, 0.13, 0.07], 0.5),
        drape("red drape", [0.72, 0.06, 0.05]),
        drape("green drape", [0.08, 0.42, 0.1]),
        drape("blue drape", [0.06, 0.16, 0.6]),
        Material {
            base_color_texture: Some(TextureUse {
                wrap: [Wrap::Clamp; 2],
                ..TextureUse::repeating(Picture::Leaf as usize)
            }),
            alpha_cutoff: Some(0.5),
            double_sided: true,
            ..solid("leaf", [1.0; 3], 0.6)
        },
        solid("terracotta", [0.5, 0.2, 0.1], 0.8),
        Material { metallic: 1.0, ..solid("bronze", [0.68, 0.48, 0.24], 0.35) },
        solid("soil", [0.06, 0.04, 0.03], 1.0),
    ]
}

impl Atrium {
    fn new(detail: f32) -> Self {
        let materials = materials();
        let shapes = std::array::from_fn(|i| Shape::new(&materials[i].name, i));
        let mut atrium = Self { shapes, detail, turn: 0.0 };
        atrium.masonry();
        for storey in &STOREYS {
            atrium.arcades(storey);
        }
        atrium.balustrades();
        atrium.drapes();
        atrium.basin();
        atrium.plants();
        atrium
    }

    fn triangle_count(&self) -> usize {
        self.shapes.iter().map(Shape::triangle_count).sum()
    }

    fn into_draft(self) -> Draft {
        let direction = Vec3::new(0.3, -1.0, 0.42).normalize();
        Draft {
            meshes: self.shapes.into_iter().map(Shape::into_mesh).collect(),
            materials: materials().into(),
            images: vec![
                paint::tiles(),
                paint::bricks(),
                paint::stone(),
                paint::fabric(),
                paint::leaf(),
            ],
            lights: vec![
                Light {
                    name: "sun".to_owned(),
                    kind: LightKind::Directional,
                    position: [0.0, ROOF, 0.0],
                    direction: direction.into(),
                    intensity: [16.0, 14.6, 12.4],
                    range: None,
                    map_share: 1.0,
                }
                .into(),
            ],
            camera: Some(
                Camera::look_at(
                    [-8.2, 2.1, -0.9],
                    [2.0, 3.3, 0.5],
                    [0.0, 1.0, 0.0],
                    62_f32.to_radians(),
                )
                .into(),
            ),
            ..Draft::default()
        }
    }

    fn shape(&mut self, is: Is) -> &mut Shape {
        &mut self.shapes[is as usize]
    }

    /// How many pieces a curve gets that has `pieces` at a detail of 1. What is left of a piece is
    /// rounded up and down by turns, so that the number of triangles grows without jumps.
    fn pieces(&mut self, pieces: u32) -> u32 {
        const GOLDEN: f32 = 0.618_034;
        self.turn = (self.turn + GOLDEN).fract();
        ((pieces as f32 * self.detail + self.turn) as u32).max(3)
    }

    /// Floors, roof and outer walls.
    fn masonry(&mut self) {
        let outer = COURT + Vec2::splat(AISLE);
        let floor = self.shape(Is::Tiles);
        floor.cuboid(Vec3::new(-outer.x, -0.3, -outer.y), Vec3::new(outer.x, 0.0, outer.y));
        // Around the court: the gallery and the roof.
        for (bottom, top) in [(STOREYS[0].top, STOREYS[1].floor), (STOREYS[1].top, ROOF)] {
            self.ring(Is::Plaster, COURT - Vec2::splat(ARCADE), outer, bottom, top);
        }
        // A ledge over each storey, and the parapet.
        let edge = COURT - Vec2::splat(ARCADE);
        for (bottom, top, out) in [(4.32, 4.46, 0.1), (ROOF, 9.0, 0.12), (9.0, 9.4, 0.0)] {
            self.ring(Is::Stone, edge - Vec2::splat(out), edge + Vec2::splat(0.3), bottom, top);
        }
        self.ring(Is::Brick, outer, outer + Vec2::splat(WALL), -0.3, ROOF);
        // A plinth along the walls.
        self.ring(Is::Stone, outer - Vec2::splat(0.06), outer, 0.0, 0.5);
        for storey in &STOREYS {
            self.doors(storey, outer);
        }
    }

    /// Wooden doors in stone frames, one in every other bay of the long walls.
    fn doors(&mut self, storey: &Storey, outer: Vec2) {
        for side in [-1.0, 1.0] {
            for bay in (0..BAYS[0]).step_by(2) {
                let x = -COURT.x + (bay as f32 + 0.5) * COURT.x * 2.0 / BAYS[0] as f32;
                let mut slab = |is: Is, half_width: f32, height: f32, depth: f32| {
                    let near = side * (outer.y - depth);
                    let far = side * outer.y;
                    self.shape(is).cuboid(
                        Vec3::new(x - half_width, storey.floor, near.min(far)),
                        Vec3::new(x + half_width, storey.floor + height, near.max(far)),
                    );
                };
                slab(Is::Stone, 0.75, 2.45, 0.08);
                slab(Is::Wood, 0.6, 2.3, 0.1);
            }
        }
    }

    /// Four boxes around a rectangle.
    fn ring(&mut self, is: Is, inner: Vec2, outer: Vec2, bottom: f32, top: f32) {
        let shape = self.shape(is);
        for side in [-1.0, 1.0] {
            let sorted = |a: f32, b: f32| (a.min(b), a.max(b));
            let (near, far) = sorted(side * inner.y, side * outer.y);
            shape.cuboid(Vec3::new(-outer.x, bottom, near), Vec3::new(outer.x, top, far));
            let (near, far) = sorted(side * inner.x, side * outer.x);
            shape.cuboid(Vec3::new(near, bottom, -inner.y), Vec3::new(far, top, inner.y));
        }
    }

    fn arcades(&mut self, storey: &Storey) {
        for bay in bays() {
            self.column(bay.start, storey);
            self.arch(&bay, storey);
        }
    }

    /// A column on a plinth, with a capital.
    fn column(&mut self, at: Vec3, storey: &Storey) {
        let (segments, shaft_rows, ring_rows) = (self.pieces(16), self.pieces(5), self.pieces(5));
        let radius = storey.column_radius;
        let foot = at + Vec3::Y * storey.floor;
        let height = storey.spring - storey.floor;
        let shape = self.shape(Is::Stone);
        let slab = |bottom: f32, top: f32, half: f32| {
            let half = Vec3::new(half, 0.0, half);
            (foot - half + Vec3::Y * bottom, foot + half + Vec3::Y * top)
        };
        for (min, max) in [slab(0.0, 0.18, radius * 1.5), slab(height - 0.16, height, radius * 1.5)]
        {
            shape.cuboid(min, max);
        }
        // Two round mouldings, the shaft with its swelling, and the bell of the capital.
        let moulding = |bottom: f32, width: f32| {
            move |t: f32| {
                let (sin, cos) = (PI * (t - 0.5)).sin_cos();
                Vec2::new(width + 0.06 * cos, bottom + 0.06 * (1.0 + sin))
            }
        };
        shape.lathe(foot, segments, ring_rows, moulding(0.18, radius * 1.18));
        shape.lathe(foot, segments, ring_rows, moulding(0.3, radius * 1.04));
        let (bottom, top) = (0.42, height - 0.55);
        shape.lathe(foot, segments, shaft_rows, |t| {
            let swell = (PI * (0.25 + 0.75 * t)).sin();
            Vec2::new(radius * (0.82 + 0.18 * swell), bottom + (top - bottom) * t)
        });
        shape.lathe(foot, segments, ring_rows, moulding(top, radius * 0.86));
        let bell = top + 0.12;
        shape.lathe(foot, segments, ring_rows, |t| {
            let flare = t * t * (3.0 - 2.0 * t);
            Vec2::new(radius * (0.82 + 0.6 * flare), bell + (height - 0.16 - bell) * t)
        });
    }

    /// The arch of a bay and the wall above it up to the slab, and the pier over its first column.
    fn arch(&mut self, bay: &Bay, storey: &Storey) {
        let pieces = self.pieces(14);
        let shape = self.shape(Is::Plaster);
        let pier = storey.column_radius * 1.3;
        let half = bay.length * 0.5 - pier;
        let rise = (storey.top - storey.spring - 0.25).min(half);
        let curve = |u: f32| {
            let (sin, cos) = (PI * (1.0 - u)).sin_cos();
            Vec2::new(bay.length * 0.5 + half * cos, storey.spring + rise * sin)
        };
        let place = |along: f32, height: f32, across: f32| {
            bay.start + bay.along * along + bay.across * across + Vec3::Y * height
        };
        for side in [-1.0, 1.0] {
            let normal = bay.across * side;
            let uv = |along: f32, height: f32| Vec2::new(along * side, -height);
            // u runs to the right seen from this side.
            let turn = |u: f32| if side > 0.0 { u } else { 1.0 - u };
            shape.patch(pieces, 1, |u, v| {
                let point = curve(turn(u));
                let height = point.y + (storey.top - point.y) * v;
                Vertex {
                    position: place(point.x, height, ARCADE * side),
                    normal,
                    uv: uv(point.x, height),
                }
            });
            shape.patch(1, 1, |u, v| {
                let along = pier * (2.0 * turn(u) - 1.0);
                let height = storey.spring + (storey.top - storey.spring) * v;
                Vertex {
                    position: place(along, height, ARCADE * side),
                    normal,
                    uv: uv(along, height),
                }
            });
        }
        // The underside of the arch, seen from below.
        shape.patch(pieces, 1, |u, v| {
            let point = curve(u);
            let (sin, cos) = (PI * (1.0 - u)).sin_cos();
            let outward = Vec2::new(cos / half, sin / rise).normalize();
            let across = ARCADE * (2.0 * v - 1.0);
            Vertex {
                position: place(point.x, point.y, across),
                normal: -(bay.along * outward.x + Vec3::Y * outward.y),
                uv: Vec2::new(u * PI * half, across),
            }
        });
        // The underside of the pier shows around the capital.
        let capital = storey.spring - 0.001;
        shape.quad(
            [(-pier, -ARCADE), (pier, -ARCADE), (pier, ARCADE), (-pier, ARCADE)]
                .map(|(along, across)| place(along, capital, across)),
            place(0.0, 0.0, 0.0),
        );
    }

    /// Between the columns of the upper storey.
    fn balustrades(&mut self) {
        let floor = STOREYS[1].floor;
        for bay in bays() {
            let count = (bay.length / 0.3).round() as u32;
            for index in 1..count {
                let (segments, rows) = (self.pieces(7), self.pieces(7));
                let foot = bay.start
                    + bay.along * (bay.length * index as f32 / count as f32)
                    + Vec3::Y * (floor + 0.1);
                self.shape(Is::Stone).lathe(foot, segments, rows, |t| {
                    let belly = (PI * (t * 0.9 + 0.1)).sin().powi(2);
                    let neck = 0.03 + 0.05 * belly * (1.3 - t);
                    Vec2::new(neck, 0.72 * t)
                });
            }
            let end = bay.start + bay.along * bay.length;
            let (low, high) = (bay.start.min(end), bay.start.max(end));
            let bar = |bottom: f32, top: f32, half: f32| {
                let half = bay.across.abs() * half;
                (low - half + Vec3::Y * (floor + bottom), high + half + Vec3::Y * (floor + top))
            };
            let (min, max) = bar(0.0, 0.1, 0.12);
            self.shape(Is::Stone).cuboid(min, max);
            let (min, max) = bar(0.82, 0.92, 0.1);
            self.shape(Is::Wood).cuboid(min, max);
        }
    }

    /// Cloth that hangs in the arches: in every other one above, at the ends also below.
    fn drapes(&mut self) {
        let colors = [Is::RedDrape, Is::GreenDrape, Is::BlueDrape];
        for (index, bay) in bays().into_iter().enumerate() {
            let color = colors[index / 2 % colors.len()];
            let lengthwise = bay.along.x.abs() > 0.5;
            if lengthwise && index.is_multiple_of(2) {
                self.drape(&bay, color, 7.75, 5.1);
            } else if lengthwise {
                self.drape(&bay, color, 3.7, 1.5);
            } else if index.is_multiple_of(3) {
                self.drape(&bay, Is::RedDrape, 7.6, 2.9);
            }
        }
    }

    fn drape(&mut self, bay: &Bay, color: Is, top: f32, bottom: f32) {
        // Fewer columns would not show the folds.
        let (columns, rows) = (self.pieces(44).max(42), self.pieces(12));
        let width = bay.length * 0.62;
        let inward = ARCADE + 0.16;
        let size = Vec2::new(width * 1.3, top - bottom);
        let (start, along, across) = (bay.start, bay.along, bay.across);
        let middle = bay.length * 0.5;
        let shape = self.shape(color);
        // A rod to hang from would be hidden by the folds.
        shape.sheet(columns, rows, size, |u, v| {
            let fall = 1.0 - v;
            // Gathered in the upper part, wider and with deeper folds below.
            let gather = 0.82 + 0.18 * fall;
            let folds = (TAU * 6.0 * u + 0.6 * (3.0 * fall).sin()).sin();
            let depth = (0.035 + 0.06 * fall) * folds + 0.05 * (TAU * u + 2.0 * fall).cos();
            let hem = 0.1 * (PI * u).sin() * fall;
            start
                + along * (middle + width * (u - 0.5) * gather)
                + across * (inward + depth)
                + Vec3::Y * (bottom - hem + (top - bottom + hem) * v)
        });
    }

    /// A round basin with a bowl on a stem, in the middle of the court.
    fn basin(&mut self) {
        let (segments, rows) = (self.pieces(36), self.pieces(6));
        let foot = Vec3::new(2.2, 0.0, 0.0);
        let stone = self.shape(Is::Stone);
        stone.lathe(foot, segments, rows, |t| {
            Vec2::new(1.25 + 0.12 * (PI * t).sin() - 0.05 * t, 0.5 * t)
        });
        stone.lathe(foot, segments, 1, |t| Vec2::new(1.2 - 0.15 * t, 0.5));
        stone.lathe(foot, segments, rows, |t| Vec2::new(1.05, 0.5 - 0.35 * t));
        stone.lathe(foot, segments, 1, |t| Vec2::new(1.05 * (1.0 - t), 0.15));
        let bronze = self.shape(Is::Bronze);
        bronze.lathe(foot, segments, rows * 2, |t| {
            Vec2::new(0.09 + 0.12 * (1.0 - t).powi(3) + 0.1 * t.powi(6), 0.15 + 0.9 * t)
        });
        bronze.lathe(foot, segments, rows * 2, |t| {
            Vec2::new(0.19 + 0.45 * (0.5 * PI * t).sin(), 1.05 + 0.22 * t * t)
        });
        bronze.lathe(foot, segments, rows * 2, |t| {
            let t = 1.0 - t;
            Vec2::new(0.62 * (0.5 * PI * t).sin(), 1.12 + 0.15 * t * t)
        });
    }

    /// Pots with plants along both sides of the court.
    fn plants(&mut self) {
        for (number, x) in [-6.0, -3.0, 0.0, 3.0, 6.0].into_iter().enumerate() {
            for (side, z) in [-2.75, 2.75].into_iter().enumerate() {
                let (segments, rows) = (self.pieces(20), self.pieces(5));
                let leaves = self.pieces(26);
                let foot = Vec3::new(x, 0.0, z);
                let pot = self.shape(Is::Terracotta);
                pot.lathe(foot, segments, rows, |t| Vec2::new(0.22 + 0.1 * t.sqrt(), 0.45 * t));
                pot.lathe(foot, segments, 1, |t| Vec2::new(0.32 - 0.04 * t, 0.45));
                pot.lathe(foot, segments, 1, |t| Vec2::new(0.28, 0.45 - 0.05 * t));
                let soil = self.shape(Is::Soil);
                soil.lathe(foot, segments, 1, |t| Vec2::new(0.28 * (1.0 - t), 0.4));
                let phase = (number * 2 + side) as f32 * 0.7;
                for leaf in 0..leaves {
                    self.leaf(foot + Vec3::Y * 0.4, leaf, leaves, phase);
                }
            }
        }
    }

    /// One card that rises from `root` and bends outwards.
    fn leaf(&mut self, root: Vec3, index: u32, count: u32, phase: f32) {
        let rows = self.pieces(4);
        // The golden angle spreads any number of leaves evenly.
        let angle = phase + index as f32 * 2.399_963;
        let (sin, cos) = angle.sin_cos();
        let (out, side) = (Vec3::new(cos, 0.0, sin), Vec3::new(-sin, 0.0, cos));
        let inner = index as f32 / count as f32;
        let length = 0.75 + 0.5 * inner;
        let lean = 1.25 - 0.95 * inner;
        let width = 0.3;
        let shape = self.shape(Is::Leaf);
        shape.patch(2, rows, |u, v| {
            let bend = lean * (0.35 + 0.65 * v);
            let (sin, cos) = bend.sin_cos();
            let across = (u - 0.5) * width;
            let position = root
                + out * (0.04 + length * v * sin)
                + Vec3::Y * (length * v * cos)
                + side * across;
            // Along the leaf the position also turns with the bend.
            let turn = lean * 0.65 * v;
            let along = out * (sin + turn * cos) + Vec3::Y * (cos - turn * sin);
            Vertex { position, normal: side.cross(along).normalize(), uv: Vec2::new(u, 1.0 - v) }
        });
    }
}

/// From one column to the next.
struct Bay {
    /// The axis of the first column, at height 0.
    start: Vec3,
    /// Towards the next column.
    along: Vec3,
    /// Towards the court.
    across: Vec3,
    length: f32,
}

/// All bays around the court, so that each column starts one.
fn bays() -> Vec<Bay> {
    let Vec2 { x, y } = COURT;
    let corners = [
        Vec3::new(-x, 0.0, y),
        Vec3::new(-x, 0.0, -y),
        Vec3::new(x, 0.0, -y),
        Vec3::new(x, 0.0, y),
    ];
    let mut bays = Vec::new();
    for side in 0..4 {
        let (from, to) = (corners[side], corners[(side + 1) % 4]);
        let count = BAYS[(side + 1) % 2];
        let along = (to - from).normalize();
        let length = from.distance(to) / count as f32;
        bays.extend((0..count).map(|index| Bay {
            start: from + along * (length * index as f32),
            along,
            across: along.cross(Vec3::Y),
            length,
        }));
    }
    bays
}
