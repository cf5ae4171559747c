//! A whole frame of a scene: rasterised, lit directly and indirectly, composed.

use std::time::Duration;

use glam::Vec3;
use glam::camera::rh::view::look_to_mat4;
use sglow_shaders::{
    Diffuse, Emission, Indirect as IndirectAxis, Light, SglowView, Specular,
    Visibility as VisibilityAxis,
};
use thiserror::Error;

use crate::device::{DeviceError, Gpu};
use crate::direct::{Compose, Direct, DirectInputs, ShadowBias, Terms};
use crate::host;
use crate::indirect::{Indirect, IndirectError, Inputs, picture};
use crate::light::{LightView, perspective};
use crate::needs::{self, MissingNeed};
use crate::package::Package;
use crate::pipeline::PipelineError;
use crate::points::Geometry;
use crate::pyramid::texture_bytes;
use crate::raster::{Raster, SurfaceTargets, traits};
use crate::readback;
use crate::scene::{self, Bounds, LightKind, Scene};
use crate::settings::Settings;
use crate::timing::{Clock, Timer};
use crate::visibility::{Config, Visibility, VisibilityError};

/// Why there is no frame.
#[derive(Debug, Error)]
pub enum FrameError {
    /// No indirect light.
    #[error(transparent)]
    Indirect(#[from] IndirectError),
    /// A variant does not become a pipeline.
    #[error(transparent)]
    Pipeline(#[from] PipelineError),
    /// The device fails.
    #[error(transparent)]
    Device(#[from] DeviceError),
    /// The light is of another kind than the renderer was made for.
    #[error(
        "the renderer was made for a {was} light and cannot take a {is} light; make another one"
    )]
    AnotherLight {
        /// What it was made for.
        was: Light,
        /// What was given.
        is: Light,
    },
    /// The scene needs more than what was left for it. Never in silence: what is missing would be missing in the picture.
    #[error(
        "{origin} left out what this scene needs:\n{}\nderive it again{}",
        missing.iter().map(|need| format!("  {need}")).collect::<Vec<_>>().join("\n"),
        if *package { ": cargo xtask gen-shaders --scene SCENE --out DIR" } else { " from the scene as it is" }
    )]
    NeedsMore {
        /// What left it out: a package or settings.
        origin: String,
        /// Whether it is the package.
        package: bool,
        /// Everything that is missing.
        missing: Vec<MissingNeed>,
    },
    /// There are no maps of the virtual lights.
    #[error(transparent)]
    Visibility(#[from] VisibilityError),
    /// The scene has no such light.
    #[error("the scene has no light {index}; it has {count}, counted from 0")]
    NoSuchLight {
        /// The number asked for.
        index: usize,
        /// How many there are.
        count: usize,
    },
}

/// The kind of a light as an axis has it.
pub fn kind(light: &scene::Light) -> Light {
    match light.kind {
        LightKind::Spot { .. } => Light::Spot,
        LightKind::Directional => Light::Directional,
        LightKind::Point => Light::Point,
    }
}

/// The maps of the virtual lights of a scene, if the settings have visibility.
///
/// # Errors
///
/// When the settings or the device do not allow them.
pub fn light_maps(
    gpu: &Gpu,
    package: &Package,
    scene: &Scene,
    settings: &Settings,
) -> Result<Option<Visibility>, VisibilityError> {
    if settings.visibility == VisibilityAxis::None {
        return Ok(None);
    }
    let (mut positions, mut indices) = (Vec::new(), Vec::new());
    for mesh in &scene.meshes {
        let first = positions.len() as u32;
        positions.extend_from_slice(&mesh.positions);
        indices.extend(mesh.indices.iter().map(|index| first + index));
    }
    let config = Config {
        least_near: host::least_near(scene.bounds().radius()),
        ..light_map_config(settings)
    };
    let geometry = Geometry { positions: &positions, indices: &indices };
    Visibility::new(&gpu.device, &gpu.queue, package, &config, geometry).map(Some)
}

/// What the maps of the virtual lights are made of, but for the scene's size.
pub(crate) fn light_map_config(settings: &Settings) -> Config {
    let Settings { visibility, lobes, precision, count, .. } = *settings;
    Config {
        points: settings.shadow_points,
        tile: settings.light_tile,
        near_scale: settings.near_scale,
        bias_scale: settings.bias_scale,
        ..Config::new(visibility, lobes, precision, count)
    }
}

/// The terms of indirect light that there are.
pub(crate) fn terms(settings: &Settings) -> IndirectAxis {
    match (settings.diffuse, settings.specular) {
        (Diffuse::None, _) => IndirectAxis::Specular,
        (_, Specular::None) => IndirectAxis::Diffuse,
        _ => IndirectAxis::Both,
    }
}

/// The biases of a shadow map that is drawn by the light's view.
fn shadow_bias(view: &LightView, rsm_size: u32) -> ShadowBias {
    let normal = host::normal_offset(view.minimum_variance, rsm_size, SHADOW_SIZE);
    ShadowBias { depth: host::DEPTH_BIAS, normal }
}

/// Whether a package and settings leave in what a scene needs.
fn suits(
    package: &Package,
    settings: &Settings,
    scene: &Scene,
    light: usize,
) -> Result<(), FrameError> {
    if package.assumed().is_empty() && settings.assumed.is_empty() {
        return Ok(());
    }
    let facts = scene.facts_lit_by(light);
    let found = needs::missing(&facts, package.assumed());
    if !found.is_empty() {
        let origin = format!("the package {}", package.origin());
        return Err(FrameError::NeedsMore { origin, package: true, missing: found });
    }
    let missing = needs::missing(&facts, &settings.assumed);
    if missing.is_empty() {
        return Ok(());
    }
    let origin = "the settings".to_owned();
    Err(FrameError::NeedsMore { origin, package: false, missing })
}

/// Pixels of a picture, row by row from the top; four floats each.
pub type Pixels = Vec<[f32; 4]>;

/// A frame on the CPU: linear radiance, and what the camera sees of the surfaces.
#[derive(Clone, Debug)]
pub struct Frame {
    /// Width and height.
    pub size: [u32; 2],
    /// Everything added up.
    pub radiance: Pixels,
    /// Directly reflected radiance.
    pub direct: Pixels,
    /// Diffusely reflected indirect radiance.
    pub indirect_diffuse: Option<Pixels>,
    /// Specularly reflected indirect radiance.
    pub indirect_specular: Option<Pixels>,
    /// Emitted radiance.
    pub emission: Option<Pixels>,
    /// The G-buffer's textures.
    pub gbuffer: Surfaces,
}

/// Surface textures on the CPU.
#[derive(Clone, Debug)]
pub struct Surfaces {
    /// World position; dielectric reflectance in w, negative without a surface.
    pub position: Pixels,
    /// Normal; roughness alpha in w.
    pub normal: Pixels,
    /// Base colour; metallic in w.
    pub base_color: Pixels,
}

/// How long a frame took.
#[derive(Clone, Debug)]
pub struct Times {
    /// Each pass in the order of the pipeline.
    pub passes: Vec<(String, Duration)>,
    /// How the times were taken.
    pub clock: Clock,
}

/// Renders a scene with one set of settings.
pub struct Renderer<'a> {
    gpu: &'a Gpu,
    raster: Raster,
    view: SglowView,
    eye: Vec3,
    bounds: Bounds,
    light: LightView,
    rsm: SurfaceTargets,
    gbuffer: SurfaceTargets,
    shadow_map: wgpu::Texture,
    shadow_bias: ShadowBias,
    indirect: Indirect,
    visibility: Option<Visibility>,
    direct: Direct,
    emission: Option<wgpu::Texture>,
    compose: Compose,
}

/// Width and height of the shadow map of direct light.
pub const SHADOW_SIZE: u32 = 2048;

impl<'a> Renderer<'a> {
    /// A renderer of `scene`, lit by its light number `light_index`. The light's kind overrides that of the settings.
    ///
    /// # Errors
    ///
    /// [`FrameError`] names the setting, the variant or the device at fault.
    pub fn new(
        gpu: &'a Gpu,
        package: &Package,
        scene: &Scene,
        settings: &Settings,
        light_index: usize,
    ) -> Result<Self, FrameError> {
        let Some(light) = scene.lights.get(light_index) else {
            return Err(FrameError::NoSuchLight { index: light_index, count: scene.lights.len() });
        };
        suits(package, settings, scene, light_index)?;
        let mut settings = settings.clone();
        settings.light = kind(light);
        let device = &gpu.device;
        let indirect = Indirect::with_package(device, &gpu.queue, &settings, package)?;
        let bounds = scene.bounds();
        let size = settings.size;
        let view_of_light = LightView::new(light, &bounds, settings.rsm_size);
        let traits = traits(scene, settings.complete);
        let emits =
            settings.complete || scene.meshes.iter().any(|mesh| traits[mesh.material].emits);
        let (near, far) = scene.camera.planes(&bounds);
        let eye = Vec3::from(scene.camera.position);
        let aspect = size[0] as f32 / size[1] as f32;
        let projection = perspective((0.5 * scene.camera.vertical_fov).tan(), aspect, near, far);
        let look = look_to_mat4(Vec3::ZERO, scene.camera.forward.into(), scene.camera.up.into());
        Ok(Self {
            raster: Raster::new(gpu, package, scene, settings.complete)?,
            view: SglowView {
                clip_from_view: (projection * look).to_cols_array_2d(),
                eye: eye.extend(1.0).into(),
                origin: eye.into(),
                ..bytemuck::Zeroable::zeroed()
            },
            eye,
            rsm: SurfaceTargets::new(device, "sglow reflective shadow map", [settings.rsm_size; 2]),
            gbuffer: SurfaceTargets::new(device, "sglow G-buffer", size),
            shadow_map: picture(
                device,
                "sglow shadow map",
                [SHADOW_SIZE; 2],
                wgpu::TextureFormat::Depth32Float,
            ),
            shadow_bias: shadow_bias(&view_of_light, settings.rsm_size),
            direct: Direct::new(device, &gpu.queue, package, settings.light, settings.ndf, size)?,
            emission: emits
                .then(|| picture(device, "sglow emission", size, wgpu::TextureFormat::Rgba16Float)),
            compose: Compose::new(
                device,
                package,
                terms(&settings),
                if emits { Emission::Seen } else { Emission::None },
                size,
            )?,
            bounds,
            light: view_of_light,
            visibility: light_maps(gpu, package, scene, &settings)?,
            indirect,
            gpu,
        })
    }

    /// Moves the light, or turns it, or gives it another power, for the frames that follow.
    ///
    /// # Errors
    ///
    /// When it is of another kind: the shaders were chosen for the kind.
    pub fn move_light(&mut self, light: &scene::Light) -> Result<(), FrameError> {
        let (was, is) = (self.indirect.settings().light, kind(light));
        if was != is {
            return Err(FrameError::AnotherLight { was, is });
        }
        let size = self.indirect.settings().rsm_size;
        self.light = LightView::new(light, &self.bounds, size);
        self.shadow_bias = shadow_bias(&self.light, size);
        Ok(())
    }

    /// Draws the light's map and the camera's G-buffer alone, and waits for them: what an [`Indirect`] of one's own then
    /// reads by [`Self::inputs`].
    pub fn draw_maps(&self) -> Result<(), FrameError> {
        let mut encoder = self.gpu.device.create_command_encoder(&Default::default());
        self.raster.encode_rsm(&mut encoder, &self.rsm, &self.light.faces, None);
        self.raster.encode_gbuffer(&mut encoder, &self.gbuffer, &self.view, None);
        self.gpu.queue.submit([encoder.finish()]);
        Ok(self.gpu.finish()?)
    }

    /// What indirect light reads.
    pub fn inputs(&self) -> Inputs<'_> {
        Inputs {
            rsm: self.rsm.views(),
            gbuffer: self.gbuffer.views(),
            light: &self.light,
            eye: self.eye,
            visibility: self.visibility.as_ref(),
        }
    }

    /// Renders one frame and waits for it. Returns the time of each pass and how it was taken.
    pub fn render(&self) -> Result<Times, FrameError> {
        let mut timer = Timer::new(self.gpu);
        let clock = timer.clock();
        let mut encoder = self.gpu.device.create_command_encoder(&Default::default());
        self.encode(&mut encoder, &mut timer)?;
        self.gpu.queue.submit([encoder.finish()]);
        let passes = timer.finish()?;
        self.gpu.finish()?;
        Ok(Times { passes, clock })
    }

    fn encode(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        timer: &mut Timer<'_>,
    ) -> Result<(), FrameError> {
        let faces = &self.light.faces;
        self.raster.encode_rsm(encoder, &self.rsm, faces, Some(timer));
        self.raster.encode_gbuffer(encoder, &self.gbuffer, &self.view, Some(timer));
        let depth = self.shadow_map.create_view(&Default::default());
        self.raster.encode_shadow(encoder, &depth, SHADOW_SIZE, faces, Some(timer));
        self.indirect.encode(encoder, &self.inputs(), Some(timer))?;
        let direct = DirectInputs {
            gbuffer: self.gbuffer.views(),
            light: &self.light,
            shadow_map: &depth,
            bias: self.shadow_bias,
            eye: self.eye,
        };
        self.direct.encode(encoder, &direct, Some(timer));
        if let Some(emission) = &self.emission {
            let view = emission.create_view(&Default::default());
            self.raster.encode_emission(encoder, &view, &self.gbuffer, Some(timer));
        }
        let terms = Terms {
            direct: self.direct.output(),
            diffuse: self.indirect.diffuse(),
            specular: self.indirect.specular(),
            emission: self.emission.as_ref(),
        };
        self.compose.encode(encoder, terms, Some(timer));
        Ok(())
    }

    /// The last frame, read back.
    pub fn read(&self) -> Result<Frame, FrameError> {
        let read = |texture: &wgpu::Texture| readback::texture(self.gpu, texture, 0);
        let optional = |texture: Option<&wgpu::Texture>| texture.map(read).transpose();
        Ok(Frame {
            size: self.indirect.settings().size,
            radiance: read(self.compose.output())?,
            direct: read(self.direct.output())?,
            indirect_diffuse: optional(self.indirect.diffuse())?,
            indirect_specular: optional(self.indirect.specular())?,
            emission: optional(self.emission.as_ref())?,
            gbuffer: self.read_surfaces(&self.gbuffer)?,
        })
    }

    /// The bytes of each texture and buffer that it keeps between frames, but for the scene itself and parameters: what
    /// [`crate::plan::Plan`] foresees, by the same names.
    pub fn bytes(&self) -> Vec<(&'static str, u64)> {
        let mut bytes = vec![
            ("reflective shadow map", self.rsm.bytes()),
            ("G-buffer", self.gbuffer.bytes()),
            ("shadow map", texture_bytes(&self.shadow_map)),
        ];
        bytes.extend(self.indirect.bytes());
        bytes.extend(self.visibility.iter().flat_map(Visibility::bytes));
        bytes.push(("direct", texture_bytes(self.direct.output())));
        bytes.extend(self.emission.as_ref().map(|texture| ("emission", texture_bytes(texture))));
        bytes.push(("radiance", texture_bytes(self.compose.output())));
        bytes
    }

    /// The camera's G-buffer of the last frame, read back.
    pub fn read_gbuffer(&self) -> Result<Surfaces, FrameError> {
        self.read_surfaces(&self.gbuffer)
    }

    /// The reflective shadow map of the last frame, read back.
    pub fn read_rsm(&self) -> Result<Surfaces, FrameError> {
        self.read_surfaces(&self.rsm)
    }

    /// The shadow map of the last frame, read back: depth in x.
    pub fn read_shadow_map(&self) -> Result<Pixels, FrameError> {
        Ok(readback::texture(self.gpu, &self.shadow_map, 0)?)
    }

    fn read_surfaces(&self, targets: &SurfaceTargets) -> Result<Surfaces, FrameError> {
        Ok(Surfaces {
            position: readback::texture(self.gpu, &targets.position, 0)?,
            normal: readback::texture(self.gpu, &targets.normal, 0)?,
            base_color: readback::texture(self.gpu, &targets.base_color, 0)?,
        })
    }

    /// The indirect light.
    pub fn indirect(&self) -> &Indirect {
        &self.indirect
    }

    /// The light's view.
    pub fn light(&self) -> &LightView {
        &self.light
    }

    /// The camera's position.
    pub fn eye(&self) -> Vec3 {
        self.eye
    }

    /// The biases of the shadow map.
    pub fn shadow_bias(&self) -> ShadowBias {
        self.shadow_bias
    }

    /// The scene on the device.
    pub fn raster(&self) -> &Raster {
        &self.raster
    }

    /// The maps of the virtual lights, where they have some.
    pub fn visibility(&self) -> Option<&Visibility> {
        self.visibility.as_ref()
    }

    /// The camera's view.
    pub fn view(&self) -> &SglowView {
        &self.view
    }
}
