//! What hides virtual lights from shading points: a map of each light in an atlas, rasterised or drawn from points.

use sglow_shaders::{
    Lobes, Precision, SglowLightMaps, SglowShadowPoint, Visibility as Axis, light_fill,
    light_points, light_shadow,
};
use thiserror::Error;

use crate::host;
use crate::package::Package;
use crate::pipeline::{ComputePass, Dispatch, PipelineError, compile, guarded, timed, uniform};
use crate::points::{Geometry, GeometryError};
use crate::settings::SettingsError;
use crate::timing::Timer;

/// Subsets of points; lights that are neighbours see different ones, so that their errors average out.
pub const SUBSETS: u32 = 16;

/// Width and height of a light's tile where nobody says otherwise. 128 takes 1 to 8 % off the relative MSE against paths for
/// four times the texels.
pub const TILE: u32 = 64;
/// The points that each light sees with `imperfect` where nobody says otherwise.
pub const POINTS: u32 = 8192;
/// The near distance where nobody says otherwise. Chosen from 0, 1, 1.25, 1.5, 1.75, 2, 3, 4, 8 for the least geometric mean
/// of the relative MSE against paths on cornell, columns and atrium, K = 0.25, by
/// `what_each_parameter_of_maps_brings` of `tests/src/visibility/picture.rs`; `docs/numerics.md` has its numbers.
pub const NEAR_SCALE: f32 = 1.5;
/// The bias where nobody says otherwise: the least one without acne.
pub const BIAS_SCALE: f32 = 1.0;

/// Why there are no maps.
#[derive(Debug, Error)]
pub enum VisibilityError {
    /// The settings cannot be.
    #[error("{}", .0.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n"))]
    Settings(Vec<SettingsError>),
    /// The triangles are none.
    #[error(transparent)]
    Geometry(#[from] GeometryError),
    /// A variant does not become a pipeline.
    #[error(transparent)]
    Pipeline(#[from] PipelineError),
}

/// What the maps are made of.
#[derive(Clone, Debug, PartialEq)]
pub struct Config {
    /// How they are made: `shadow_map` or `imperfect`.
    pub visibility: Axis,
    /// The lobes of the lights.
    pub lobes: Lobes,
    /// Their precision in memory.
    pub precision: Precision,
    /// The most lights there are, 1 to 65536.
    pub count: u32,
    /// Width and height of a light's tile in texels: a power of two, 8 to 256, with `imperfect` at most 64.
    pub tile: u32,
    /// Points that each light sees, with `imperfect`: 1 to 1048576.
    pub points: u32,
    /// How many texels a point's disc may reach from the texel of its centre, with `imperfect`: 0 to 8.
    pub reach: u32,
    /// How many times holes are filled from texels twice as wide, with `imperfect`: 0 to the tile's logarithm to base 2.
    pub levels: u32,
    /// What lies within this many standard deviations of a light's positions does not hide it: at least 0.
    pub near_scale: f32,
    /// What lies within this distance of a light does not hide it either, in world units: above 0.
    pub least_near: f32,
    /// The bias, in units of the least one that keeps a plane from shadowing itself in a rasterised map: 0 to 4.
    pub bias_scale: f32,
}

impl Config {
    /// The settings that measured best, for lights of a kind.
    pub fn new(visibility: Axis, lobes: Lobes, precision: Precision, count: u32) -> Self {
        Self {
            visibility,
            lobes,
            precision,
            count,
            tile: TILE,
            points: POINTS,
            reach: 2,
            // Discs leave few holes that are none; filling them was measured to darken more than it mends.
            levels: 0,
            near_scale: NEAR_SCALE,
            least_near: 1e-3,
            bias_scale: BIAS_SCALE,
        }
    }

    /// How far a receiver is moved along its normal, over its distance to the light along |x| + |y| + |z|.
    pub fn bias(&self) -> f32 {
        host::bias(self.bias_scale, self.tile)
    }

    /// Columns and rows of the atlas, in tiles: as near to a square as powers of two allow.
    pub fn tiles(&self) -> [u32; 2] {
        let bits = self.count.max(1).next_power_of_two().ilog2();
        [1 << bits.div_ceil(2), 1 << (bits / 2)]
    }

    /// Width and height of the atlas in texels.
    pub fn atlas_size(&self) -> [u64; 2] {
        self.tiles().map(|tiles| u64::from(tiles) * u64::from(self.tile))
    }

    /// Everything that is wrong with these settings on this device.
    pub fn faults(&self, device: &wgpu::Device) -> Vec<SettingsError> {
        let limits = device.limits();
        let mut faults = Vec::new();
        let mut range = |holds: bool, name: &'static str, value: String, range: String| {
            if !holds {
                faults.push(SettingsError::Range { name, value, range });
            }
        };
        let imperfect = self.visibility == Axis::Imperfect;
        range(
            self.visibility != Axis::None,
            "the visibility of lights with maps",
            self.visibility.to_string(),
            "shadow_map or imperfect; none has no maps".to_owned(),
        );
        range(
            (1..=65536).contains(&self.count),
            "the number of lights",
            self.count.to_string(),
            "1 to 65536".to_owned(),
        );
        let widest = if imperfect { 64 } else { 256 };
        range(
            self.tile.is_power_of_two() && (8..=widest).contains(&self.tile),
            "the size of a light's map",
            self.tile.to_string(),
            format!("a power of two between 8 and {widest}"),
        );
        let [width, height] = self.atlas_size();
        let most = u64::from(limits.max_texture_dimension_2d);
        range(
            width <= most && height <= most,
            "the atlas of the lights' maps",
            format!("{width} x {height} texels"),
            format!(
                "at most {most} wide and high on this device: fewer lights or smaller maps would do"
            ),
        );
        if imperfect {
            range(
                (1..=1 << 20).contains(&self.points),
                "the number of points that a light sees",
                self.points.to_string(),
                "1 to 1048576".to_owned(),
            );
            let binding = limits.max_storage_buffer_binding_size.min(limits.max_buffer_size);
            let bytes = self.splat_bytes();
            range(
                bytes <= binding,
                "the buffer of the lights' maps",
                format!("{bytes} bytes"),
                format!("at most {binding} on this device: fewer lights or smaller maps would do"),
            );
            let bytes = self.point_bytes();
            range(
                bytes <= binding,
                "the buffer of points",
                format!("{bytes} bytes"),
                format!("at most {binding} on this device: fewer points would do"),
            );
            range(
                self.reach <= 8,
                "the reach of a point's disc",
                self.reach.to_string(),
                "0 to 8".to_owned(),
            );
            let most = self.tile.max(1).ilog2();
            range(
                self.levels <= most,
                "the number of levels that holes are filled from",
                self.levels.to_string(),
                format!("0 to {most}"),
            );
        }
        range(
            self.near_scale >= 0.0 && self.near_scale.is_finite(),
            "the scale of the near distance",
            self.near_scale.to_string(),
            "at least 0 and finite".to_owned(),
        );
        range(
            self.least_near > 0.0 && self.least_near.is_finite(),
            "the least near distance",
            self.least_near.to_string(),
            "above 0 and finite".to_owned(),
        );
        range(
            (0.0..=4.0).contains(&self.bias_scale),
            "the scale of the bias",
            self.bias_scale.to_string(),
            "0 to 4".to_owned(),
        );
        faults
    }

    /// The variants that make the maps.
    pub(crate) fn variants(&self) -> Vec<String> {
        let Self { lobes, precision, .. } = *self;
        match self.visibility {
            Axis::None => Vec::new(),
            Axis::ShadowMap => vec![light_shadow::LightShadow { lobes, precision }.id()],
            Axis::Imperfect => vec![
                light_points::LightPoints { lobes, precision }.id(),
                light_fill::LightFill.id(),
            ],
        }
    }

    /// The bytes of the atlas, and of each buffer behind it, among so many positions and indices of triangles.
    pub(crate) fn bytes(&self, positions: u64, indices: u64) -> (u64, Vec<(&'static str, u64)>) {
        let [width, height] = self.atlas_size();
        let buffers = match self.visibility {
            Axis::None => return (0, Vec::new()),
            Axis::ShadowMap => {
                vec![("light occluders", 12 * positions.max(1) + 4 * indices.max(1))]
            }
            Axis::Imperfect => {
                vec![("shadow points", self.point_bytes()), ("light splats", self.splat_bytes())]
            }
        };
        (4 * width * height, buffers)
    }

    pub(crate) fn point_bytes(&self) -> u64 {
        u64::from(self.points) * u64::from(SUBSETS) * size_of::<SglowShadowPoint>() as u64
    }

    pub(crate) fn splat_bytes(&self) -> u64 {
        4 * u64::from(self.count) * u64::from(self.tile) * u64::from(self.tile)
    }

    fn parameters(&self, count: u32) -> SglowLightMaps {
        SglowLightMaps {
            tile: self.tile,
            columns: self.tiles()[0],
            count: count.min(self.count),
            points: self.points,
            subsets: SUBSETS,
            reach: self.reach,
            levels: self.levels,
            near_scale: self.near_scale,
            least_near: self.least_near,
            bias: self.bias(),
        }
    }
}

/// What rasterised maps are made with.
struct Rasterised {
    pipeline: wgpu::RenderPipeline,
    group: wgpu::BindGroupLayout,
    positions: wgpu::Buffer,
    indices: wgpu::Buffer,
    index_count: u32,
}

/// What maps of points are made with.
struct Splatted {
    points_pass: ComputePass,
    fill_pass: ComputePass,
    points: wgpu::Buffer,
    /// Whether there is any point.
    any: bool,
    splats: wgpu::Buffer,
}

enum Method {
    Rasterised(Rasterised),
    Splatted(Splatted),
}

/// The maps of all lights, and the passes that make them.
pub struct Visibility {
    device: wgpu::Device,
    queue: wgpu::Queue,
    config: Config,
    parameters: wgpu::Buffer,
    atlas: wgpu::Texture,
    view: wgpu::TextureView,
    method: Method,
}

impl Visibility {
    /// Maps of lights among these triangles. All of them count as opaque, cutouts as well, and from both sides.
    ///
    /// # Errors
    ///
    /// All the settings that cannot be, at once; or what is wrong with the triangles; or the variant that the device
    /// refuses.
    pub fn new(
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        package: &Package,
        config: &Config,
        geometry: Geometry<'_>,
    ) -> Result<Self, VisibilityError> {
        let faults = config.faults(device);
        if !faults.is_empty() {
            return Err(VisibilityError::Settings(faults));
        }
        geometry.check()?;
        let Config { lobes, precision, .. } = *config;
        let rasterised = config.visibility == Axis::ShadowMap;
        let [width, height] = config.atlas_size().map(|side| side as u32);
        let (format, usage) = if rasterised {
            (wgpu::TextureFormat::Depth32Float, wgpu::TextureUsages::RENDER_ATTACHMENT)
        } else {
            (wgpu::TextureFormat::R32Float, wgpu::TextureUsages::STORAGE_BINDING)
        };
        let atlas = device.create_texture(&wgpu::TextureDescriptor {
            label: Some("sglow light maps"),
            size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format,
            usage: usage | wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_SRC,
            view_formats: &[],
        });
        let method = if rasterised {
            let id = light_shadow::LightShadow { lobes, precision }.id();
            Method::Rasterised(Rasterised::new(device, queue, package, &id, geometry)?)
        } else {
            let points = geometry.points(config.points, SUBSETS);
            let any = !points.is_empty();
            // A buffer of no bytes cannot be bound.
            let points = if any { points } else { vec![SglowShadowPoint::default()] };
            let id = light_points::LightPoints { lobes, precision }.id();
            let fill = light_fill::LightFill.id();
            Method::Splatted(Splatted {
                points_pass: ComputePass::new(device, package, &id, "light points", &[])?,
                fill_pass: ComputePass::new(device, package, &fill, "light fill", &[])?,
                points: filled(
                    device,
                    queue,
                    "sglow shadow points",
                    bytemuck::cast_slice(&points),
                    wgpu::BufferUsages::STORAGE,
                ),
                any,
                splats: device.create_buffer(&wgpu::BufferDescriptor {
                    label: Some("sglow light splats"),
                    size: config.splat_bytes(),
                    usage: wgpu::BufferUsages::STORAGE
                        | wgpu::BufferUsages::COPY_DST
                        | wgpu::BufferUsages::COPY_SRC,
                    mapped_at_creation: false,
                }),
            })
        };
        Ok(Self {
            view: atlas.create_view(&Default::default()),
            atlas,
            parameters: uniform::<SglowLightMaps>(device, "sglow light maps"),
            device: device.clone(),
            queue: queue.clone(),
            config: config.clone(),
            method,
        })
    }

    /// Encodes the maps of the first `count` lights of a buffer, as the sample pass writes it; at most as many as the
    /// configuration has room for.
    pub fn encode(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        vsgls: &wgpu::Buffer,
        count: u32,
        mut timer: Option<&mut Timer<'_>>,
    ) {
        let count = count.min(self.config.count);
        let parameters = self.config.parameters(count);
        self.queue.write_buffer(&self.parameters, 0, bytemuck::bytes_of(&parameters));
        match &self.method {
            Method::Rasterised(rasterised) => {
                self.encode_rasterised(rasterised, encoder, vsgls, count, timer);
            }
            Method::Splatted(splatted) => {
                let tile = u64::from(self.config.tile);
                encoder.clear_buffer(&splatted.splats, 0, Some(4 * u64::from(count) * tile * tile));
                let columns = self.config.tiles()[0];
                let rows = count.div_ceil(columns);
                if splatted.any {
                    splatted.points_pass.encode(
                        &self.device,
                        encoder,
                        timer.as_deref_mut(),
                        &[Dispatch {
                            bindings: &[
                                (0, self.parameters.as_entire_binding()),
                                (1, vsgls.as_entire_binding()),
                                (2, splatted.points.as_entire_binding()),
                                (3, splatted.splats.as_entire_binding()),
                            ],
                            workgroups: [self.config.points.div_ceil(64), columns, rows],
                        }],
                    );
                }
                splatted.fill_pass.encode(
                    &self.device,
                    encoder,
                    timer,
                    &[Dispatch {
                        bindings: &[
                            (0, self.parameters.as_entire_binding()),
                            (1, splatted.splats.as_entire_binding()),
                            (2, wgpu::BindingResource::TextureView(&self.view)),
                        ],
                        workgroups: [columns, rows, 1],
                    }],
                );
            }
        }
    }

    fn encode_rasterised(
        &self,
        rasterised: &Rasterised,
        encoder: &mut wgpu::CommandEncoder,
        vsgls: &wgpu::Buffer,
        count: u32,
        timer: Option<&mut Timer<'_>>,
    ) {
        let group = self.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("light shadow maps"),
            layout: &rasterised.group,
            entries: &[
                wgpu::BindGroupEntry { binding: 0, resource: self.parameters.as_entire_binding() },
                wgpu::BindGroupEntry { binding: 1, resource: vsgls.as_entire_binding() },
            ],
        });
        timed(encoder, timer, "light shadow maps", |encoder, stamps| {
            let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                label: Some("light shadow maps"),
                color_attachments: &[],
                depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                    view: &self.view,
                    depth_ops: Some(wgpu::Operations {
                        load: wgpu::LoadOp::Clear(0.0),
                        store: wgpu::StoreOp::Store,
                    }),
                    stencil_ops: None,
                }),
                timestamp_writes: stamps.map(|stamps| stamps.render()),
                ..Default::default()
            });
            if rasterised.index_count == 0 {
                return;
            }
            pass.set_pipeline(&rasterised.pipeline);
            pass.set_bind_group(0, &group, &[]);
            pass.set_vertex_buffer(0, rasterised.positions.slice(..));
            pass.set_index_buffer(rasterised.indices.slice(..), wgpu::IndexFormat::Uint32);
            let (tile, columns) = (self.config.tile, self.config.tiles()[0]);
            for light in 0..count {
                let [x, y] = [light % columns, light / columns].map(|at| (at * tile) as f32);
                pass.set_viewport(x, y, tile as f32, tile as f32, 0.0, 1.0);
                pass.draw_indexed(0..rasterised.index_count, 0, 4 * light..4 * light + 4);
            }
        });
    }

    /// What it was made with.
    pub fn config(&self) -> &Config {
        &self.config
    }

    /// The atlas, for each direction the light's near distance over that of what is met first, 0 where there is nothing:
    /// depth32float with `shadow_map`, r32float with `imperfect`. Light i has tile i, in rows.
    pub fn atlas(&self) -> &wgpu::Texture {
        &self.atlas
    }

    /// A view of the atlas.
    pub fn view(&self) -> &wgpu::TextureView {
        &self.view
    }

    /// What the shading pass binds beside its own: the parameters at 7, the atlas at 8.
    pub fn shade_bindings(&self) -> [(u32, wgpu::BindingResource<'_>); 2] {
        [
            (7, self.parameters.as_entire_binding()),
            (8, wgpu::BindingResource::TextureView(&self.view)),
        ]
    }

    /// The points, set by set: `SglowShadowPoint`. None with `shadow_map`.
    pub fn points(&self) -> Option<&wgpu::Buffer> {
        match &self.method {
            Method::Rasterised(_) => None,
            Method::Splatted(splatted) => Some(&splatted.points),
        }
    }

    /// What the points left in the maps before holes were filled, tile by tile: the bits of f32 numbers. None with
    /// `shadow_map`.
    pub fn splats(&self) -> Option<&wgpu::Buffer> {
        match &self.method {
            Method::Rasterised(_) => None,
            Method::Splatted(splatted) => Some(&splatted.splats),
        }
    }

    /// The bytes of the atlas and of the buffers behind it.
    pub fn bytes(&self) -> Vec<(&'static str, u64)> {
        let [width, height] = self.config.atlas_size();
        let mut bytes = vec![("light maps", 4 * width * height)];
        match &self.method {
            Method::Rasterised(rasterised) => bytes
                .push(("light occluders", rasterised.positions.size() + rasterised.indices.size())),
            Method::Splatted(splatted) => bytes.extend([
                ("shadow points", splatted.points.size()),
                ("light splats", splatted.splats.size()),
            ]),
        }
        bytes
    }
}

impl Rasterised {
    fn new(
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        package: &Package,
        id: &str,
        geometry: Geometry<'_>,
    ) -> Result<Self, PipelineError> {
        let compiled = compile(device, package, id)?;
        let pipeline = guarded(device, id, || {
            device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
                label: Some(id),
                layout: Some(&compiled.layout),
                vertex: wgpu::VertexState {
                    module: &compiled.module,
                    entry_point: None,
                    compilation_options: Default::default(),
                    buffers: &[Some(wgpu::VertexBufferLayout {
                        array_stride: size_of::<[f32; 3]>() as u64,
                        step_mode: wgpu::VertexStepMode::Vertex,
                        attributes: &wgpu::vertex_attr_array![0 => Float32x3],
                    })],
                },
                // Both sides of a triangle cast shadows.
                primitive: wgpu::PrimitiveState::default(),
                depth_stencil: Some(wgpu::DepthStencilState {
                    format: wgpu::TextureFormat::Depth32Float,
                    depth_write_enabled: Some(true),
                    // Greater is nearer.
                    depth_compare: Some(wgpu::CompareFunction::GreaterEqual),
                    stencil: Default::default(),
                    bias: Default::default(),
                }),
                multisample: Default::default(),
                fragment: Some(wgpu::FragmentState {
                    module: &compiled.module,
                    entry_point: None,
                    compilation_options: Default::default(),
                    targets: &[],
                }),
                multiview_mask: None,
                cache: None,
            })
        })?;
        let Some(group) = compiled.groups.into_iter().next() else {
            return Err(PipelineError::NoBindings { id: id.to_owned() });
        };
        // Buffers of no bytes cannot be bound; nothing is drawn of these.
        let positions: &[[f32; 3]] =
            if geometry.positions.is_empty() { &[[0.0; 3]] } else { geometry.positions };
        let indices: &[u32] = if geometry.indices.is_empty() { &[0] } else { geometry.indices };
        Ok(Self {
            pipeline,
            group,
            positions: filled(
                device,
                queue,
                "sglow light occluders",
                bytemuck::cast_slice(positions),
                wgpu::BufferUsages::VERTEX,
            ),
            indices: filled(
                device,
                queue,
                "sglow light occluders",
                bytemuck::cast_slice(indices),
                wgpu::BufferUsages::INDEX,
            ),
            index_count: geometry.indices.len() as u32,
        })
    }
}

fn filled(
    device: &wgpu::Device,
    queue: &wgpu::Queue,
    label: &str,
    bytes: &[u8],
    usage: wgpu::BufferUsages,
) -> wgpu::Buffer {
    let buffer = device.create_buffer(&wgpu::BufferDescriptor {
        label: Some(label),
        size: bytes.len() as u64,
        usage: usage | wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::COPY_SRC,
        mapped_at_creation: false,
    });
    queue.write_buffer(&buffer, 0, bytes);
    buffer
}
