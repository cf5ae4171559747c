//! Rooms for tests: a map, receivers, the reference and kernels, all made by the oracle.

use crate::brdf::{Material, Ndf};
use crate::cluster::Map;
use crate::light::{Light, LightKind};
use crate::metrics::{Metrics, compare_exact};
use crate::rsm::{Emission, Lobes, Moments, Pyramid, SpecularPower, moments};
use crate::scenery::diffuse;
use crate::shade::{Diffuse, Emitter, Model, shade};
use crate::surface::{Camera, Facet, SurfaceTexel, Triangle};
use crate::vpl::TexelFacets;
use crate::vsgl::{Kernel, Settings, Solver, Vsgl, sample};
use crate::{Vector3, density};

/// A room of two by two by two with something in it, and a spot light below its ceiling.
pub(crate) struct Room {
    triangles: Vec<Triangle>,
    materials: Vec<Material>,
    pub(crate) light: Light,
    pub(crate) size: [usize; 2],
    pub(crate) texels: Vec<SurfaceTexel>,
    pub(crate) receivers: Vec<SurfaceTexel>,
    /// Width and height of the image that they are the pixels of.
    pub(crate) image: [usize; 2],
    pub(crate) eye: Vector3,
}

const EYE: Vector3 = Vector3::new(0.1, 1.0, 0.95);

fn quad(corners: [Vector3; 4], material: u32) -> [Triangle; 2] {
    let [a, b, c, d] = corners;
    [[a, b, c], [a, c, d]].map(|positions| {
        let facet: Facet = crate::scenery::facet(positions, None, material);
        facet.triangle
    })
}

/// A box about its middle, turned about y.
fn block(middle: Vector3, half: Vector3, angle: f64, material: u32) -> Vec<Triangle> {
    let (x, z) = (
        Vector3::new(angle.cos(), 0.0, -angle.sin()) * half.x,
        Vector3::new(angle.sin(), 0.0, angle.cos()) * half.z,
    );
    let y = Vector3::new(0.0, half.y, 0.0);
    let sides = [(x, y, z), (-x, z, y), (y, z, x), (-y, x, z), (z, x, y), (-z, y, x)];
    let of = |(out, a, b): (Vector3, Vector3, Vector3)| {
        let at = middle + out;
        quad([at - a - b, at + a - b, at + a + b, at - a + b], material)
    };
    sides.into_iter().flat_map(of).collect()
}

impl Room {
    /// With two boxes of grey among coloured walls.
    pub(crate) fn boxes(map: usize) -> Self {
        let mut things =
            block(Vector3::new(-0.4, 0.6, -0.35), Vector3::new(0.28, 0.6, 0.28), 0.3, 1);
        things.extend(block(Vector3::new(0.35, 0.3, 0.3), Vector3::new(0.3, 0.3, 0.3), -0.3, 1));
        Self::with(things, map)
    }

    /// With twenty thin columns: full of depth edges.
    pub(crate) fn columns(map: usize) -> Self {
        let column = |index: usize| {
            let at = |step: usize| -0.8 + 0.4 * step as f64;
            let middle = Vector3::new(at(index % 5), 0.8, at(index / 5) + 0.1);
            block(middle, Vector3::new(0.05, 0.8, 0.05), 0.2, 1)
        };
        Self::with((0..20).flat_map(column).collect(), map)
    }

    fn with(mut triangles: Vec<Triangle>, map: usize) -> Self {
        triangles.extend(block(Vector3::new(0.0, 1.0, 0.0), Vector3::splat(1.0), 0.0, 0));
        // The walls to the left and right.
        triangles.extend(block(
            Vector3::new(-1.05, 1.0, 0.0),
            Vector3::new(0.0501, 0.9, 0.9),
            0.0,
            2,
        ));
        triangles.extend(block(
            Vector3::new(1.05, 1.0, 0.0),
            Vector3::new(0.0501, 0.9, 0.9),
            0.0,
            3,
        ));
        let mut materials = vec![diffuse(0.7), diffuse(0.6), diffuse(0.5), diffuse(0.5)];
        materials[2].diffuse = Vector3::new(0.6, 0.1, 0.1);
        materials[3].diffuse = Vector3::new(0.1, 0.5, 0.1);
        let mut room = Self {
            triangles,
            materials,
            light: light(Vector3::new(0.15, 1.9, 0.2)),
            size: [map; 2],
            texels: Vec::new(),
            receivers: Vec::new(),
            image: [42, 28],
            eye: EYE,
        };
        room.draw_map();
        room.receivers = room.seen(&room.camera(), room.image);
        room
    }

    fn camera(&self) -> Camera {
        let forward = Vector3::new(0.0, -0.15, -1.0).normalized();
        let right = Vector3::new(1.0, 0.0, 0.0);
        Camera {
            position: self.eye,
            right,
            up: right.cross(forward),
            forward,
            half_extent: [0.9, 0.6],
            perspective: true,
        }
    }

    /// The same room seen in so many times as many pixels along each axis.
    pub(crate) fn finely(mut self, scale: usize) -> Self {
        self.image = self.image.map(|side| side * scale);
        self.receivers = self.seen(&self.camera(), self.image);
        self
    }

    fn seen(&self, camera: &Camera, size: [usize; 2]) -> Vec<SurfaceTexel> {
        let texel = |hit: Option<crate::surface::Hit>| {
            let nothing = SurfaceTexel {
                position: Vector3::zero(),
                normal: Vector3::new(0.0, 1.0, 0.0),
                material: self.materials[0],
                present: false,
            };
            hit.map_or(nothing, |hit| SurfaceTexel {
                position: hit.position,
                normal: hit.normal,
                material: self.materials[hit.material as usize],
                present: true,
            })
        };
        camera.image(&self.triangles, size).into_iter().map(texel).collect()
    }

    fn draw_map(&mut self) {
        self.texels =
            self.light.cameras().iter().flat_map(|one| self.seen(one, self.size)).collect();
    }

    /// The same room with the light moved.
    pub(crate) fn lit_from(&mut self, position: Vector3) {
        self.light.position = position;
        self.draw_map();
    }

    pub(crate) fn map(&self) -> Map<'_, f64> {
        Map {
            texels: &self.texels,
            size: self.size,
            light: (&self.light).into(),
            origin: self.light.position,
            minimum_variance: crate::cut::sum::LEAST_VARIANCE,
            emission: Emission::of_normals(Lobes::Diffuse),
            specular_power: SpecularPower::F0,
        }
    }

    /// The reference: all texels as facets.
    pub(crate) fn reference(&self) -> Vec<[f64; 3]> {
        self.reference_at(&self.receivers)
    }

    /// The reference at some receivers.
    pub(crate) fn reference_at(&self, receivers: &[SurfaceTexel]) -> Vec<[f64; 3]> {
        let facets = TexelFacets::of_map(&self.light, &self.texels, self.size, Ndf::Ggx);
        let reflected = facets.reflect(receivers, self.eye, &|_| true).unwrap();
        reflected.iter().map(|one| one.diffuse.to_array()).collect()
    }

    /// The picture of some lights.
    pub(crate) fn picture(&self, lights: &[Vsgl], emitter: Emitter) -> Vec<[f64; 3]> {
        use rayon::prelude::*;
        let model =
            Model { emitter, diffuse: Some(Diffuse::Fitted), specular: None, ndf: Ndf::Ggx };
        let of = |receiver: &SurfaceTexel| {
            shade(receiver, self.eye, lights.iter().copied(), &model).diffuse.to_array()
        };
        self.receivers.par_iter().map(of).collect()
    }

    pub(crate) fn errors(
        &self,
        lights: &[Vsgl],
        emitter: Emitter,
        reference: &[[f64; 3]],
    ) -> Metrics {
        compare_exact(&self.picture(lights, emitter), reference).unwrap()
    }

    /// Kernels drawn by power.
    pub(crate) fn kernels(&self, count: usize, scale: f64) -> Vec<Vsgl> {
        let map = self.map();
        let texels = (0..self.texels.len()).map(|index| {
            let power = self
                .light
                .photon_power::<f64>([index % self.size[0], index / self.size[0]], self.size);
            let surface = &self.texels[index];
            let (towards, _) = self.light.towards(surface.position);
            moments(surface, power, towards, map.origin, &map.emission)
        });
        let moments: Pyramid<Moments> = Pyramid::build(self.size[0], texels.collect()).unwrap();
        let weights = moments.level(0).iter().map(density::power).collect();
        let density = Pyramid::build(self.size[0], weights).unwrap();
        let texel = 2.0 * 1.4 / self.size[0] as f64;
        let settings = Settings {
            count: count as u32,
            kernel: Kernel::Modified(Solver::Bracketed),
            scale,
            origin: map.origin,
            // As the renderer: a texel at the distance of the scene's radius.
            minimum_variance: 3.0 * texel * texel / 6.0,
            emission: map.emission,
        };
        (0..settings.count)
            .map(|index| sample(index, &density, &moments, &settings).light)
            .collect()
    }
}

/// A spot light that looks downwards and to the back.
fn light(position: Vector3) -> Light {
    let forward = Vector3::new(-0.15, -0.9, -0.35).normalized();
    let right = forward.cross(Vector3::new(0.0, 0.0, 1.0)).normalized();
    let outer = 0.95_f64;
    let scale = 1.0 / (0.6_f64.cos() - outer.cos());
    Light {
        kind: LightKind::Spot {
            tan_half_angle: outer.tan(),
            cone_scale: scale,
            cone_offset: -outer.cos() * scale,
        },
        position,
        right,
        up: right.cross(forward),
        forward,
        intensity: Vector3::new(3.0, 2.5, 2.0),
    }
}
