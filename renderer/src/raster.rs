//! A scene on the device: its triangles and materials, as the draws of a frame take them.

mod filled;
mod list;
mod textures;

use std::collections::BTreeMap;

use sglow_shaders::{Material as MaterialAxis, Opacity};

use crate::device::Gpu;
use filled::filled;
pub use list::SceneDraws;
use sglow_scene::{Scene, Traits};
use textures::Textures;

/// Position, normal, texture coordinates.
#[repr(C)]
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
struct Vertex {
    position: [f32; 3],
    normal: [f32; 3],
    uv: [f32; 2],
}

/// Which pipelines a material is drawn with.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Kind {
    textured: bool,
    cutout: bool,
    double_sided: bool,
}

impl Kind {
    /// The least that a material needs.
    fn of(material: &sglow_scene::Material, traits: &Traits) -> Self {
        let Traits { textured, cutout, .. } = *traits;
        Self { textured, cutout, double_sided: material.double_sided }
    }

    fn axes(self) -> (MaterialAxis, Opacity) {
        axes(self.textured, self.cutout)
    }
}

/// The values of the axes that a material is drawn with.
pub(crate) fn axes(textured: bool, cutout: bool) -> (MaterialAxis, Opacity) {
    (
        if textured { MaterialAxis::Textured } else { MaterialAxis::Constant },
        if cutout { Opacity::Cutout } else { Opacity::Opaque },
    )
}

/// What each material needs of the passes that draw it; or everything, if `complete`.
pub(crate) fn traits(scene: &Scene, complete: bool) -> Vec<Traits> {
    let mut traits = scene.traits();
    for one in traits.iter_mut().filter(|_| complete) {
        *one = Traits { textured: true, cutout: true, ..*one };
    }
    traits
}

struct Draw {
    kind: Kind,
    material: usize,
    indices: std::ops::Range<u32>,
    emits: bool,
}

/// A scene on the device.
pub struct Raster {
    device: wgpu::Device,
    vertices: wgpu::Buffer,
    indices: wgpu::Buffer,
    draws: Vec<Draw>,
    materials: Vec<wgpu::BindGroup>,
}

impl Raster {
    /// Uploads a scene; what its materials read is the least that they need or, if `complete`, everything.
    pub fn new(gpu: &Gpu, scene: &Scene, complete: bool) -> Self {
        let mut vertices = Vec::new();
        let mut indices = Vec::new();
        let mut draws = Vec::new();
        let traits = traits(scene, complete);
        for mesh in &scene.meshes {
            let first_vertex = vertices.len() as u32;
            let first_index = indices.len() as u32;
            vertices.extend(mesh.positions.iter().zip(&mesh.normals).enumerate().map(
                |(index, (&position, &normal))| Vertex {
                    position,
                    normal,
                    uv: mesh.uvs.get(index).copied().unwrap_or_default(),
                },
            ));
            indices.extend(mesh.indices.iter().map(|index| first_vertex + index));
            let traits = &traits[mesh.material];
            draws.push(Draw {
                kind: Kind::of(&scene.materials[mesh.material], traits),
                material: mesh.material,
                indices: first_index..indices.len() as u32,
                emits: traits.emits,
            });
        }
        draws.sort_by_key(|draw| (draw.kind, draw.material));
        let layouts = [false, true].map(|textured| shared_layout(&gpu.device, &[textured], 1));
        let textures = Textures::new(gpu, scene, &traits);
        let materials = scene.materials.iter().zip(&traits);
        let materials = materials.map(|(material, &Traits { textured, .. })| {
            textures.bind(gpu, &layouts[usize::from(textured)], material, textured)
        });
        Self {
            vertices: filled(gpu, bytemuck::cast_slice(&vertices), wgpu::BufferUsages::VERTEX),
            indices: filled(gpu, bytemuck::cast_slice(&indices), wgpu::BufferUsages::INDEX),
            device: gpu.device.clone(),
            materials: materials.collect(),
            draws,
        }
    }
}

/// A bind group layout that serves a group of every raster pass: what any of them binds there, for every stage that
/// any of them binds it in. Passes leave out what they do not read, and a material is bound once for all of them.
fn shared_layout(device: &wgpu::Device, textured: &[bool], group: usize) -> wgpu::BindGroupLayout {
    let mut entries: BTreeMap<u32, wgpu::BindGroupLayoutEntry> = BTreeMap::new();
    for &textured in textured {
        for cutout in [false, true] {
            for id in ids(Kind { textured, cutout, double_sided: false }) {
                let groups = sglow_shaders::bind_groups(&id).unwrap_or(&[]);
                for entry in groups.get(group).copied().unwrap_or(&[]) {
                    let merged = entries.entry(entry.binding).or_insert(*entry);
                    merged.visibility |= entry.visibility;
                }
            }
        }
    }
    device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
        label: Some("sglow raster"),
        entries: &entries.into_values().collect::<Vec<_>>(),
    })
}

/// The variants that draw a kind of material: surface, shadow, emission.
fn ids(kind: Kind) -> [String; 3] {
    let (material, opacity) = kind.axes();
    [
        sglow_shaders::surface::Surface { material, opacity }.id(),
        sglow_shaders::shadow::Shadow { material, opacity }.id(),
        sglow_shaders::emission::Emission { material, opacity }.id(),
    ]
}
