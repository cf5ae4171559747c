//! A scene on the device: its triangles and materials, as the draws of a frame take them.

mod detail;
mod filled;
mod kind;
mod list;
mod textures;

use std::collections::BTreeMap;

use sglow_shaders::{Material as MaterialAxis, Opacity};

use crate::device::Gpu;
use filled::filled;
use kind::Kind;
pub(crate) use kind::axes;
pub use list::SceneDraws;
use sglow_scene::{Scene, Traits};
use textures::{Reads, Textures};

/// Position, normal, texture coordinates.
#[repr(C)]
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
pub(crate) struct Vertex {
    position: [f32; 3],
    normal: [f32; 3],
    uv: [f32; 2],
}

/// What each material needs of the passes that draw it; or everything, if `complete`.
pub(crate) fn traits(scene: &Scene, complete: bool) -> Vec<Traits> {
    let mut traits = scene.traits();
    for one in traits.iter_mut().filter(|_| complete) {
        *one = Traits { textured: true, cutout: true, detailed: true, ..*one };
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
    /// The bytes of the details of vertices, and the maximum of a buffer that holds them.
    pub fn detail_bytes(gpu: &Gpu, scene: &Scene, complete: bool) -> (u64, u64) {
        let traits = traits(scene, complete);
        let detailed = scene.meshes.iter().filter(|mesh| traits[mesh.material].detailed);
        let vertices: usize = detailed.map(|mesh| mesh.positions.len()).sum();
        let limits = gpu.device.limits();
        let limit = limits.max_buffer_size.min(limits.max_storage_buffer_binding_size);
        ((vertices * size_of::<sglow_shaders::SglowVertexDetail>()) as u64, limit)
    }

    /// Uploads a scene; what its materials read is the least that they need or, if `complete`, everything.
    pub fn new(gpu: &Gpu, scene: &Scene, complete: bool) -> Self {
        let mut vertices = Vec::new();
        let mut indices = Vec::new();
        let mut draws = Vec::new();
        let traits = traits(scene, complete);
        // Those with details first, so that nothing is kept for the others' vertices.
        let mut meshes: Vec<_> = scene.meshes.iter().collect();
        meshes.sort_by_key(|mesh| !traits[mesh.material].detailed);
        let mut details = Vec::new();
        for mesh in meshes {
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
            if traits.detailed {
                details.extend(detail::of(mesh));
            }
            draws.push(Draw {
                kind: Kind::of(&scene.materials[mesh.material], traits),
                material: mesh.material,
                indices: first_index..indices.len() as u32,
                emits: traits.emits,
            });
        }
        draws.sort_by_key(|draw| (draw.kind, draw.material));
        let layouts = MaterialAxis::ALL.map(|read| (read, shared_layout(&gpu.device, read, 1)));
        let layouts = BTreeMap::from(layouts);
        let details = traits.iter().any(|traits| traits.detailed).then(|| {
            // A binding has at least one element, also where no mesh has a material with details.
            details.resize(details.len().max(1), bytemuck::Zeroable::zeroed());
            filled(gpu, bytemuck::cast_slice(&details), wgpu::BufferUsages::STORAGE)
        });
        let textures = Textures::new(gpu, scene, &traits, details);
        let materials = scene.materials.iter().zip(&traits).map(|(material, traits)| {
            let (read, _) = axes(traits);
            let reads = Reads { material: read, colored: traits.colored };
            textures.bind(gpu, &layouts[&read], material, reads)
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
fn shared_layout(
    device: &wgpu::Device,
    material: MaterialAxis,
    group: usize,
) -> wgpu::BindGroupLayout {
    let mut entries: BTreeMap<u32, wgpu::BindGroupLayoutEntry> = BTreeMap::new();
    for opacity in Opacity::ALL {
        for id in ids(material, opacity) {
            let groups = sglow_shaders::bind_groups(&id).unwrap_or(&[]);
            for entry in groups.get(group).copied().unwrap_or(&[]) {
                let merged = entries.entry(entry.binding).or_insert(*entry);
                merged.visibility |= entry.visibility;
            }
        }
    }
    device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
        label: Some("sglow raster"),
        entries: &entries.into_values().collect::<Vec<_>>(),
    })
}

/// The variants that draw a kind of material: surface, shadow, emission.
fn ids(material: MaterialAxis, opacity: Opacity) -> [String; 3] {
    [
        sglow_shaders::surface::Surface { material, opacity }.id(),
        sglow_shaders::shadow::Shadow { material, opacity }.id(),
        sglow_shaders::emission::Emission { material, opacity }.id(),
    ]
}
