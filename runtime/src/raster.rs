//! Draws a scene's surfaces: reflective shadow maps, G-buffers, shadow maps, emitters.

mod list;

use std::collections::btree_map::Entry;
use std::collections::{BTreeMap, BTreeSet};

use sglow_shaders::{Material as MaterialAxis, Opacity, SglowMaterialTextured, SglowView};

use crate::device::Gpu;
use crate::indirect::{SurfaceViews, picture};
use crate::light::Face;
use crate::package::Package;
use crate::pipeline::{PipelineError, compile, guarded, timed, uniform};
use crate::pyramid::texture_bytes;
use crate::scene::{self, Filter, Scene, TextureUse, Traits, Wrap};
use crate::timing::Timer;
pub use list::SceneDraws;

/// The format of depth maps.
const DEPTH: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;

/// Position, normal, texture coordinates.
#[repr(C)]
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
struct Vertex {
    position: [f32; 3],
    normal: [f32; 3],
    uv: [f32; 2],
}

const VERTEX: wgpu::VertexBufferLayout<'static> = wgpu::VertexBufferLayout {
    array_stride: size_of::<Vertex>() as u64,
    step_mode: wgpu::VertexStepMode::Vertex,
    attributes: &wgpu::vertex_attr_array![0 => Float32x3, 1 => Float32x3, 2 => Float32x2],
};

/// Which pipelines a material is drawn with.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Kind {
    textured: bool,
    cutout: bool,
    double_sided: bool,
}

impl Kind {
    /// The least that a material needs.
    fn of(material: &scene::Material, traits: &Traits) -> Self {
        let Traits { textured, cutout, .. } = *traits;
        Self { textured, cutout, double_sided: material.double_sided }
    }

    fn axes(self) -> (MaterialAxis, Opacity) {
        (
            if self.textured { MaterialAxis::Textured } else { MaterialAxis::Constant },
            if self.cutout { Opacity::Cutout } else { Opacity::Opaque },
        )
    }
}

/// What each material asks of the passes that draw it; or everything, if `complete`.
pub(crate) fn traits(scene: &Scene, complete: bool) -> Vec<Traits> {
    let mut traits = scene.traits();
    for one in traits.iter_mut().filter(|_| complete) {
        *one = Traits { textured: true, cutout: true, ..*one };
    }
    traits
}

struct Pipelines {
    surface: wgpu::RenderPipeline,
    shadow: wgpu::RenderPipeline,
    /// Where something of the kind emits.
    emission: Option<wgpu::RenderPipeline>,
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
    queue: wgpu::Queue,
    vertices: wgpu::Buffer,
    indices: wgpu::Buffer,
    draws: Vec<Draw>,
    materials: Vec<wgpu::BindGroup>,
    views: Vec<(wgpu::Buffer, wgpu::BindGroup)>,
    pipelines: BTreeMap<Kind, Pipelines>,
}

/// The surface textures of one view, with their depth.
pub struct SurfaceTargets {
    /// World position, rgba32float.
    pub position: wgpu::Texture,
    /// Normal, rgba16float.
    pub normal: wgpu::Texture,
    /// Base colour, rgba16float.
    pub base_color: wgpu::Texture,
    depth: wgpu::Texture,
    depth_view: wgpu::TextureView,
    views: [wgpu::TextureView; 3],
}

impl SurfaceTargets {
    /// The bytes of a texel of all four.
    pub(crate) const TEXEL: u64 = 16 + 8 + 8 + 4;

    /// Targets of a size in pixels.
    pub fn new(device: &wgpu::Device, label: &str, size: [u32; 2]) -> Self {
        let position = picture(device, label, size, wgpu::TextureFormat::Rgba32Float);
        let normal = picture(device, label, size, wgpu::TextureFormat::Rgba16Float);
        let base_color = picture(device, label, size, wgpu::TextureFormat::Rgba16Float);
        let depth = picture(device, label, size, DEPTH);
        let depth_view = depth.create_view(&Default::default());
        let views = [&position, &normal, &base_color]
            .map(|texture| texture.create_view(&Default::default()));
        Self { position, normal, base_color, depth, depth_view, views }
    }

    /// The bytes of all four.
    pub fn bytes(&self) -> u64 {
        let textures = [&self.position, &self.normal, &self.base_color, &self.depth];
        textures.into_iter().map(texture_bytes).sum()
    }

    /// The textures as passes read them.
    pub fn views(&self) -> SurfaceViews<'_> {
        let [position, normal, base_color] = &self.views;
        SurfaceViews { position, normal, base_color }
    }
}

/// The slot of a view's uniform: passes of one frame must not share one, for writes come before all of them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Slot {
    /// The camera.
    Camera,
    /// A face of the light's map.
    Light(usize),
}

impl Slot {
    const COUNT: usize = 7;

    fn index(self) -> usize {
        match self {
            Self::Camera => 0,
            Self::Light(face) => 1 + face,
        }
    }
}

impl Raster {
    /// Uploads a scene, and makes the pipelines that its materials need and no others; or, if `complete`, those that
    /// can do everything.
    pub fn new(
        gpu: &Gpu,
        package: &Package,
        scene: &Scene,
        complete: bool,
    ) -> Result<Self, PipelineError> {
        let device = &gpu.device;
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
        let view_layout = shared_layout(device, &[false, true], 0);
        let material_layouts = [false, true].map(|textured| shared_layout(device, &[textured], 1));
        let mut pipelines = BTreeMap::new();
        for draw in &draws {
            if let Entry::Vacant(entry) = pipelines.entry(draw.kind) {
                let layouts = [&view_layout, &material_layouts[usize::from(draw.kind.textured)]];
                let emits = |other: &Draw| other.kind == draw.kind && other.emits;
                let emits = complete || draws.iter().any(emits);
                entry.insert(Pipelines::new(device, package, draw.kind, emits, layouts)?);
            }
        }
        let views = (0..Slot::COUNT)
            .map(|_| {
                let buffer = uniform::<SglowView>(device, "sglow view");
                let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
                    label: Some("sglow view"),
                    layout: &view_layout,
                    entries: &[wgpu::BindGroupEntry {
                        binding: 0,
                        resource: buffer.as_entire_binding(),
                    }],
                });
                (buffer, group)
            })
            .collect();
        let textures = Textures::new(gpu, scene, &traits);
        let materials = scene
            .materials
            .iter()
            .zip(&traits)
            .map(|(material, &Traits { textured, .. })| {
                textures.bind(gpu, &material_layouts[usize::from(textured)], material, textured)
            })
            .collect();
        Ok(Self {
            vertices: filled(gpu, bytemuck::cast_slice(&vertices), wgpu::BufferUsages::VERTEX),
            indices: filled(gpu, bytemuck::cast_slice(&indices), wgpu::BufferUsages::INDEX),
            device: device.clone(),
            queue: gpu.queue.clone(),
            draws,
            materials,
            views,
            pipelines,
        })
    }

    /// Draws the camera's G-buffer.
    pub fn encode_gbuffer(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        targets: &SurfaceTargets,
        view: &SglowView,
        timer: Option<&mut Timer<'_>>,
    ) {
        self.set_view(Slot::Camera, view);
        self.encode_surface(
            encoder,
            targets,
            &[(Slot::Camera, [0.0, 0.0, 1.0, 1.0])],
            "surface camera",
            timer,
        );
    }

    /// Draws a light's reflective shadow map, all of its faces.
    pub fn encode_rsm(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        targets: &SurfaceTargets,
        faces: &[Face],
        timer: Option<&mut Timer<'_>>,
    ) {
        self.encode_surface(encoder, targets, &self.set_faces(faces), "surface light", timer);
    }

    /// Draws a light's shadow map, all of its faces.
    pub fn encode_shadow(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        depth: &wgpu::TextureView,
        size: u32,
        faces: &[Face],
        timer: Option<&mut Timer<'_>>,
    ) {
        let slots = self.set_faces(faces);
        timed(encoder, timer, "shadow", |encoder, stamps| {
            let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                label: Some("shadow"),
                color_attachments: &[],
                depth_stencil_attachment: Some(depth_attachment(depth, wgpu::LoadOp::Clear(1.0))),
                timestamp_writes: stamps.map(|stamps| stamps.render()),
                ..Default::default()
            });
            self.draw(
                &mut pass,
                &slots,
                [size, size],
                |pipelines| Some(&pipelines.shadow),
                |_| true,
            );
        });
    }

    /// Draws what the camera sees of emitting surfaces, over the depth of a G-buffer drawn before.
    pub fn encode_emission(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        output: &wgpu::TextureView,
        gbuffer: &SurfaceTargets,
        timer: Option<&mut Timer<'_>>,
    ) {
        timed(encoder, timer, "emission", |encoder, stamps| {
            let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                label: Some("emission"),
                color_attachments: &[Some(color_attachment(output, wgpu::Color::TRANSPARENT))],
                depth_stencil_attachment: Some(depth_attachment(
                    &gbuffer.depth_view,
                    wgpu::LoadOp::Load,
                )),
                timestamp_writes: stamps.map(|stamps| stamps.render()),
                ..Default::default()
            });
            let size = [gbuffer.position.width(), gbuffer.position.height()];
            let slots = [(Slot::Camera, [0.0, 0.0, 1.0, 1.0])];
            self.draw(
                &mut pass,
                &slots,
                size,
                |pipelines| pipelines.emission.as_ref(),
                |draw| draw.emits,
            );
        });
    }

    fn set_view(&self, slot: Slot, view: &SglowView) {
        self.queue.write_buffer(&self.views[slot.index()].0, 0, bytemuck::bytes_of(view));
    }

    fn set_faces(&self, faces: &[Face]) -> Vec<(Slot, [f32; 4])> {
        faces
            .iter()
            .enumerate()
            .map(|(index, face)| {
                let view = SglowView {
                    clip_from_view: face.clip_from_light.to_cols_array_2d(),
                    eye: face.eye.into(),
                    origin: face.position.into(),
                    ..bytemuck::Zeroable::zeroed()
                };
                self.set_view(Slot::Light(index), &view);
                (Slot::Light(index), face.tile)
            })
            .collect()
    }

    fn encode_surface(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        targets: &SurfaceTargets,
        slots: &[(Slot, [f32; 4])],
        label: &'static str,
        timer: Option<&mut Timer<'_>>,
    ) {
        timed(encoder, timer, label, |encoder, stamps| {
            let [position, normal, base_color] = &targets.views;
            let nothing = wgpu::Color { r: 0.0, g: 0.0, b: 0.0, a: -1.0 };
            let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                label: Some(label),
                color_attachments: &[
                    Some(color_attachment(position, nothing)),
                    Some(color_attachment(normal, wgpu::Color::TRANSPARENT)),
                    Some(color_attachment(base_color, wgpu::Color::TRANSPARENT)),
                ],
                depth_stencil_attachment: Some(depth_attachment(
                    &targets.depth_view,
                    wgpu::LoadOp::Clear(1.0),
                )),
                timestamp_writes: stamps.map(|stamps| stamps.render()),
                ..Default::default()
            });
            let size = [targets.position.width(), targets.position.height()];
            self.draw(&mut pass, slots, size, |pipelines| Some(&pipelines.surface), |_| true);
        });
    }

    fn draw(
        &self,
        pass: &mut wgpu::RenderPass<'_>,
        slots: &[(Slot, [f32; 4])],
        [width, height]: [u32; 2],
        pipeline: impl Fn(&Pipelines) -> Option<&wgpu::RenderPipeline>,
        wanted: impl Fn(&Draw) -> bool,
    ) {
        pass.set_vertex_buffer(0, self.vertices.slice(..));
        pass.set_index_buffer(self.indices.slice(..), wgpu::IndexFormat::Uint32);
        for &(slot, [left, top, across, down]) in slots {
            let (width, height) = (width as f32, height as f32);
            pass.set_viewport(left * width, top * height, across * width, down * height, 0.0, 1.0);
            pass.set_bind_group(0, &self.views[slot.index()].1, &[]);
            let mut current = None;
            for draw in self.draws.iter().filter(|draw| wanted(draw)) {
                if current != Some(draw.kind) {
                    let Some(pipeline) = self.pipelines.get(&draw.kind).and_then(&pipeline) else {
                        continue;
                    };
                    pass.set_pipeline(pipeline);
                    current = Some(draw.kind);
                }
                pass.set_bind_group(1, &self.materials[draw.material], &[]);
                pass.draw_indexed(draw.indices.clone(), 0, 0..1);
            }
        }
    }

    /// The device that holds it.
    pub fn device(&self) -> &wgpu::Device {
        &self.device
    }
}

fn color_attachment(
    view: &wgpu::TextureView,
    clear: wgpu::Color,
) -> wgpu::RenderPassColorAttachment<'_> {
    wgpu::RenderPassColorAttachment {
        view,
        depth_slice: None,
        resolve_target: None,
        ops: wgpu::Operations { load: wgpu::LoadOp::Clear(clear), store: wgpu::StoreOp::Store },
    }
}

fn depth_attachment(
    view: &wgpu::TextureView,
    load: wgpu::LoadOp<f32>,
) -> wgpu::RenderPassDepthStencilAttachment<'_> {
    wgpu::RenderPassDepthStencilAttachment {
        view,
        depth_ops: Some(wgpu::Operations { load, store: wgpu::StoreOp::Store }),
        stencil_ops: None,
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
    drawing(material, opacity)
}

/// The variants that draw a material: surface, shadow, emission.
pub(crate) fn drawing(material: MaterialAxis, opacity: Opacity) -> [String; 3] {
    [
        sglow_shaders::surface::Surface { material, opacity }.id(),
        sglow_shaders::shadow::Shadow { material, opacity }.id(),
        sglow_shaders::emission::Emission { material, opacity }.id(),
    ]
}

impl Pipelines {
    fn new(
        device: &wgpu::Device,
        package: &Package,
        kind: Kind,
        emits: bool,
        layouts: [&wgpu::BindGroupLayout; 2],
    ) -> Result<Self, PipelineError> {
        let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some("sglow raster"),
            bind_group_layouts: &layouts.map(Some),
            immediate_size: 0,
        });
        let [surface, shadow, emission] = ids(kind);
        let make =
            |id: &str, formats: &[wgpu::TextureFormat], fragment: bool, writes_depth: bool| {
                let compiled = compile(device, package, id)?;
                let targets: Vec<_> = formats.iter().map(|&format| Some(format.into())).collect();
                guarded(device, id, || {
                    device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
                        label: Some(id),
                        layout: Some(&layout),
                        vertex: wgpu::VertexState {
                            module: &compiled.module,
                            entry_point: None,
                            compilation_options: Default::default(),
                            buffers: &[Some(VERTEX)],
                        },
                        primitive: wgpu::PrimitiveState {
                            cull_mode: (!kind.double_sided).then_some(wgpu::Face::Back),
                            ..Default::default()
                        },
                        depth_stencil: Some(wgpu::DepthStencilState {
                            format: DEPTH,
                            depth_write_enabled: Some(writes_depth),
                            depth_compare: Some(wgpu::CompareFunction::LessEqual),
                            stencil: Default::default(),
                            bias: Default::default(),
                        }),
                        multisample: Default::default(),
                        fragment: fragment.then_some(wgpu::FragmentState {
                            module: &compiled.module,
                            entry_point: None,
                            compilation_options: Default::default(),
                            targets: &targets,
                        }),
                        multiview_mask: None,
                        cache: None,
                    })
                })
            };
        let half = wgpu::TextureFormat::Rgba16Float;
        Ok(Self {
            surface: make(&surface, &[wgpu::TextureFormat::Rgba32Float, half, half], true, true)?,
            // What has no holes casts its shadow without a fragment stage.
            shadow: make(&shadow, &[], kind.cutout, true)?,
            emission: if emits { Some(make(&emission, &[half], true, false)?) } else { None },
        })
    }
}

fn filled(gpu: &Gpu, bytes: &[u8], usage: wgpu::BufferUsages) -> wgpu::Buffer {
    let buffer = gpu.device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("sglow scene"),
        size: (bytes.len() as u64).next_multiple_of(wgpu::COPY_BUFFER_ALIGNMENT),
        usage: usage | wgpu::BufferUsages::COPY_DST,
        mapped_at_creation: false,
    });
    gpu.queue.write_buffer(&buffer, 0, bytes);
    buffer
}

/// The images that a scene's textured materials read, on the device, and a white one for what has no texture.
struct Textures {
    images: BTreeMap<usize, wgpu::TextureView>,
    white: Option<wgpu::TextureView>,
}

impl Textures {
    fn new(gpu: &Gpu, scene: &Scene, traits: &[Traits]) -> Self {
        let textured = || scene.materials.iter().zip(traits).filter(|(_, traits)| traits.textured);
        let read: BTreeSet<usize> = textured()
            .flat_map(|(material, _)| material.textures().map(|texture| texture.image))
            .collect();
        let white = scene::Image {
            name: "white".to_owned(),
            width: 1,
            height: 1,
            rgba8: vec![255; 4],
            srgb: false,
        };
        Self {
            images: read
                .into_iter()
                .filter_map(|index| Some((index, upload(gpu, scene.images.get(index)?))))
                .collect(),
            white: textured().next().map(|_| upload(gpu, &white)),
        }
    }

    fn bind(
        &self,
        gpu: &Gpu,
        layout: &wgpu::BindGroupLayout,
        material: &scene::Material,
        textured: bool,
    ) -> wgpu::BindGroup {
        let rows = |texture: &Option<TextureUse>| {
            let rows = texture.map_or_else(Default::default, |texture| texture.transform).rows();
            rows.map(|[a, b, c]| [a, b, c, 0.0])
        };
        let uniform = SglowMaterialTextured {
            base_color: material.base_color,
            emission: material.emission,
            roughness: material.roughness,
            metallic: material.metallic,
            dielectric: material.dielectric,
            alpha_cutoff: material.alpha_cutoff.unwrap_or(0.0),
            base_color_coordinates: rows(&material.base_color_texture),
            metallic_roughness_coordinates: rows(&material.metallic_roughness_texture),
            emission_coordinates: rows(&material.emission_texture),
            ..bytemuck::Zeroable::zeroed()
        };
        let uniform = filled(gpu, bytemuck::bytes_of(&uniform), wgpu::BufferUsages::UNIFORM);
        let mut entries =
            vec![wgpu::BindGroupEntry { binding: 0, resource: uniform.as_entire_binding() }];
        let sampler = sampler(gpu, material.textures().next());
        if textured {
            entries.push(wgpu::BindGroupEntry {
                binding: 1,
                resource: wgpu::BindingResource::Sampler(&sampler),
            });
            let textures = [
                (2, &material.base_color_texture),
                (3, &material.metallic_roughness_texture),
                (4, &material.emission_texture),
            ];
            for (binding, texture) in textures {
                let image = texture.and_then(|texture| self.images.get(&texture.image));
                entries.extend(image.or(self.white.as_ref()).map(|view| wgpu::BindGroupEntry {
                    binding,
                    resource: wgpu::BindingResource::TextureView(view),
                }));
            }
        }
        gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some(&material.name),
            layout,
            entries: &entries,
        })
    }
}

fn sampler(gpu: &Gpu, texture: Option<&TextureUse>) -> wgpu::Sampler {
    let wrap = |wrap| match wrap {
        Wrap::Repeat => wgpu::AddressMode::Repeat,
        Wrap::Mirror => wgpu::AddressMode::MirrorRepeat,
        Wrap::Clamp => wgpu::AddressMode::ClampToEdge,
    };
    let filter = |filter| match filter {
        Filter::Nearest => wgpu::FilterMode::Nearest,
        Filter::Linear => wgpu::FilterMode::Linear,
    };
    let texture = texture.copied().unwrap_or_else(|| TextureUse::repeating(0));
    gpu.device.create_sampler(&wgpu::SamplerDescriptor {
        label: Some("sglow material"),
        address_mode_u: wrap(texture.wrap[0]),
        address_mode_v: wrap(texture.wrap[1]),
        mag_filter: filter(texture.magnify),
        min_filter: filter(texture.minify),
        mipmap_filter: match texture.mip {
            Some(Filter::Linear) => wgpu::MipmapFilterMode::Linear,
            Some(Filter::Nearest) | None => wgpu::MipmapFilterMode::Nearest,
        },
        lod_max_clamp: if texture.mip.is_some() { 32.0 } else { 0.0 },
        ..Default::default()
    })
}

/// Uploads an image with a full mip chain.
fn upload(gpu: &Gpu, image: &scene::Image) -> wgpu::TextureView {
    let levels = image.width.max(image.height).ilog2() + 1;
    let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some(&image.name),
        size: wgpu::Extent3d { width: image.width, height: image.height, depth_or_array_layers: 1 },
        mip_level_count: levels,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: if image.srgb {
            wgpu::TextureFormat::Rgba8UnormSrgb
        } else {
            wgpu::TextureFormat::Rgba8Unorm
        },
        usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
        view_formats: &[],
    });
    let (mut width, mut height, mut texels) = (image.width, image.height, image.rgba8.clone());
    for mip_level in 0..levels {
        if mip_level > 0 {
            (width, height, texels) = halved(width, height, &texels, image.srgb);
        }
        gpu.queue.write_texture(
            wgpu::TexelCopyTextureInfo {
                texture: &texture,
                mip_level,
                origin: wgpu::Origin3d::ZERO,
                aspect: wgpu::TextureAspect::All,
            },
            &texels,
            wgpu::TexelCopyBufferLayout {
                offset: 0,
                bytes_per_row: Some(4 * width),
                rows_per_image: Some(height),
            },
            wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
        );
    }
    texture.create_view(&Default::default())
}

/// The next mip level: the mean of two by two texels, of linear light where the image is sRGB.
fn halved(width: u32, height: u32, texels: &[u8], srgb: bool) -> (u32, u32, Vec<u8>) {
    let decode = |channel: usize, value: u8| {
        let value = f32::from(value) / 255.0;
        if !srgb || channel == 3 {
            value
        } else if value <= 0.04045 {
            value / 12.92
        } else {
            ((value + 0.055) / 1.055).powf(2.4)
        }
    };
    let encode = |channel: usize, value: f32| {
        let value = if !srgb || channel == 3 {
            value
        } else if value <= 0.003_130_8 {
            12.92 * value
        } else {
            1.055 * value.powf(1.0 / 2.4) - 0.055
        };
        (255.0 * value + 0.5) as u8
    };
    let table: Vec<[f32; 2]> =
        (0..=255).map(|value| [decode(0, value), decode(3, value)]).collect();
    let (half_width, half_height) = ((width / 2).max(1), (height / 2).max(1));
    let mut half = Vec::with_capacity(4 * (half_width * half_height) as usize);
    for y in 0..half_height {
        for x in 0..half_width {
            for channel in 0..4 {
                let mut sum = 0.0;
                for (dx, dy) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
                    let x = (2 * x + dx).min(width - 1);
                    let y = (2 * y + dy).min(height - 1);
                    let value = texels[(4 * (y * width + x)) as usize + channel];
                    sum += table[usize::from(value)][usize::from(channel == 3)];
                }
                half.push(encode(channel, 0.25 * sum));
            }
        }
    }
    (half_width, half_height, half)
}
