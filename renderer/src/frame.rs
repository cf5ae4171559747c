//! A whole frame of a scene: rasterised, lit directly and indirectly, composed.

use std::time::Duration;

use glam::Vec3;
use glam::camera::rh::view::look_to_mat4;
use sglow_shaders::frame::resource;
use sglow_shaders::{Light, SglowView};
use thiserror::Error;

use crate::device::{DeviceError, Gpu};
use crate::host;
use crate::light;
use crate::limits::{self, LimitError};
use crate::needs::{self, MissingNeed};
use crate::plan;
use crate::raster::Raster;
use crate::readback;
use crate::timing::{Clock, Timer};
use sglow_runtime::execute::{self, DrawList, Lists};
use sglow_runtime::indirect::{Indirect, IndirectError, Inputs, SurfaceViews};
use sglow_runtime::light::{LightView, LightsError, perspective};
use sglow_runtime::occluders::Occluders;
use sglow_runtime::package::Package;
use sglow_runtime::points::{Geometry, GeometryError};
use sglow_runtime::settings::Settings;
use sglow_scene::{Bounds, Scene};

/// Errors of [`Renderer`].
#[derive(Debug, Error)]
pub enum FrameError {
    /// No indirect light.
    #[error(transparent)]
    Indirect(#[from] IndirectError),
    /// The device fails.
    #[error(transparent)]
    Device(#[from] DeviceError),
    /// The device or the machine cannot hold it.
    #[error(transparent)]
    Limit(#[from] LimitError),
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
    /// The lights cannot share a map.
    #[error(transparent)]
    Lights(#[from] LightsError),
    /// The lights have another number of faces than the renderer was made for.
    #[error(
        "the renderer was made for lights with {was} faces and cannot take lights with {is}, 6 of a point light and 1 of another; \
         make another one"
    )]
    OtherFaces {
        /// What it was made for.
        was: u32,
        /// What was given.
        is: u32,
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
    /// The scene's triangles cannot occlude virtual lights.
    #[error(transparent)]
    Occluders(#[from] GeometryError),
    /// The scene has no such light.
    #[error("the scene has no light {index}; it has {count}, counted from 0")]
    NoSuchLight {
        /// The number requested.
        index: usize,
        /// How many there are.
        count: usize,
    },
}

/// The triangles of a scene that occlude virtual lights, as far as the settings need them.
///
/// # Errors
///
/// The first index or position at fault.
pub fn occluders(
    gpu: &Gpu,
    scene: &Scene,
    settings: &Settings,
) -> Result<Occluders, GeometryError> {
    let (mut positions, mut indices) = (Vec::new(), Vec::new());
    for mesh in &scene.meshes {
        let first = positions.len() as u32;
        positions.extend_from_slice(&mesh.positions);
        indices.extend(mesh.indices.iter().map(|index| first + index));
    }
    Occluders::new(&gpu.device, settings, Geometry { positions: &positions, indices: &indices })
}

/// The biases of a shadow map.
#[derive(Clone, Debug, PartialEq)]
pub struct ShadowBias {
    /// Subtracted from the depth that is compared, in units of depth.
    pub depth: f32,
    /// How far a position is moved along its normal, in world units; that of the first face.
    pub normal: f32,
    /// The same of each face.
    pub faces: Vec<f32>,
}

/// The biases of a shadow map of a width that is drawn by the lights' view.
fn shadow_bias(view: &LightView, shadow_size: u32) -> ShadowBias {
    let faces = host::normal_offsets(view, shadow_size);
    ShadowBias { depth: host::DEPTH_BIAS, normal: faces.first().copied().unwrap_or(0.0), faces }
}

/// The lights of a scene that settings take: all of them with several, else one by its number.
fn lights_of<'s>(
    scene: &'s Scene,
    settings: &Settings,
    index: usize,
) -> Result<&'s [sglow_scene::Light], FrameError> {
    if settings.light == Light::Several {
        return Ok(&scene.lights);
    }
    let none = FrameError::NoSuchLight { index, count: scene.lights.len() };
    scene.lights.get(index..=index).ok_or(none)
}

/// The view of lights for the map of settings.
fn view_of(
    lights: &[sglow_scene::Light],
    bounds: &Bounds,
    settings: &Settings,
) -> Result<LightView, FrameError> {
    match lights {
        [light] if settings.light != Light::Several => Ok(light::view(light, bounds, settings.map)),
        _ => Ok(light::view_of_all(lights, bounds, settings.map)?),
    }
}

/// Whether a package and settings leave in what a scene needs.
fn check_requirements(
    package: &Package,
    settings: &Settings,
    scene: &Scene,
    light: usize,
) -> Result<(), FrameError> {
    if package.assumed().is_empty() && settings.assumed.is_empty() {
        return Ok(());
    }
    let several = settings.light == Light::Several;
    let facts = if several { scene.facts() } else { scene.facts_lit_by(light) };
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

/// The surface textures of a view, with their views.
struct SurfaceTextures {
    textures: [wgpu::Texture; 3],
    views: [wgpu::TextureView; 3],
}

impl SurfaceTextures {
    /// Those that an executor has drawn to.
    fn of(indirect: &Indirect, names: [&str; 3]) -> Option<Self> {
        let [position, normal, base_color] = names.map(|name| indirect.texture(name));
        let textures = [position?, normal?, base_color?];
        let views = textures.each_ref().map(|texture| texture.create_view(&Default::default()));
        Some(Self { textures, views })
    }

    fn views(&self) -> SurfaceViews<'_> {
        let [position, normal, base_color] = &self.views;
        SurfaceViews { position, normal, base_color }
    }

    fn read(&self, gpu: &Gpu) -> Result<Surfaces, FrameError> {
        let [position, normal, base_color] = &self.textures;
        let read = |texture| readback::texture(gpu, texture, 0);
        Ok(Surfaces {
            position: read(position)?,
            normal: read(normal)?,
            base_color: read(base_color)?,
        })
    }
}

/// Renders a scene with one set of settings.
pub struct Renderer<'a> {
    gpu: &'a Gpu,
    raster: Raster,
    view: SglowView,
    eye: Vec3,
    bounds: Bounds,
    light: LightView,
    shadow_bias: ShadowBias,
    rsm: SurfaceTextures,
    gbuffer: SurfaceTextures,
    /// The whole frame.
    frame: Indirect,
    occluder_bytes: Vec<(String, u64)>,
}

/// Width and height of the shadow map of direct light, with up to eight faces.
pub const SHADOW_SIZE: u32 = 2048;

/// The width of a frame's shadow map.
fn shadow_size(frame: &Indirect) -> u32 {
    frame.texture(resource::SHADOW_MAP).map_or(SHADOW_SIZE, |texture| texture.width())
}

impl<'a> Renderer<'a> {
    /// A renderer of `scene`, lit by its light number `light_index`, whose kind overrides that of the settings; or, if that is
    /// several, by all of its lights.
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
        let lights = lights_of(scene, settings, light_index)?;
        check_requirements(package, settings, scene, light_index)?;
        limits::frame(gpu, package, scene, settings)?;
        let mut settings = settings.clone();
        if settings.light != Light::Several {
            settings.light = light::kind_of_all(lights);
        }
        settings.light_faces = light::faces(lights);
        let bounds = scene.bounds();
        let size = settings.size;
        let view_of_light = view_of(lights, &bounds, &settings)?;
        let (near, far) = scene.camera.planes(&bounds);
        let eye = Vec3::from(scene.camera.position);
        let aspect = size[0] as f32 / size[1] as f32;
        let projection = perspective((0.5 * scene.camera.vertical_fov).tan(), aspect, near, far);
        let look = look_to_mat4(Vec3::ZERO, scene.camera.forward.into(), scene.camera.up.into());
        let raster = Raster::new(gpu, scene, settings.complete);
        let occluders = occluders(gpu, scene, &settings)?;
        let mut configuration = settings.configuration();
        plan::Surfaces::of(scene, settings.complete).describe(&mut configuration);
        let (surfaces, emitters) = (raster.surfaces(), raster.emitters());
        let lists: [(_, &dyn DrawList); 2] = [("surfaces", &surfaces), ("emitters", &emitters)];
        let frame = Indirect::of_configuration(
            gpu.source(package),
            &settings,
            configuration,
            &occluders,
            &Lists::from(lists),
        )?;
        let surfaces = |names| {
            let missing = || IndirectError::Description(format!("the frame has no {names:?}"));
            SurfaceTextures::of(&frame, names).ok_or_else(missing)
        };
        Ok(Self {
            view: SglowView {
                clip_from_view: (projection * look).to_cols_array_2d(),
                eye: eye.extend(1.0).into(),
                origin: eye.into(),
                ..bytemuck::Zeroable::zeroed()
            },
            eye,
            rsm: surfaces(["rsm_position", "rsm_normal", "rsm_base_color"])?,
            gbuffer: surfaces(["gbuffer_position", "gbuffer_normal", "gbuffer_base_color"])?,
            shadow_bias: shadow_bias(&view_of_light, shadow_size(&frame)),
            bounds,
            light: view_of_light,
            occluder_bytes: occluders
                .buffers()
                .map(|(name, buffer)| (name.to_owned(), buffer.size()))
                .collect(),
            frame,
            raster,
            gpu,
        })
    }

    /// Moves the light, or turns it, or gives it another power, for the frames that follow.
    ///
    /// # Errors
    ///
    /// When it is of another kind: the shaders were chosen for the kind.
    pub fn move_light(&mut self, light: &sglow_scene::Light) -> Result<(), FrameError> {
        self.move_lights(std::slice::from_ref(light))
    }

    /// The same of all lights.
    ///
    /// # Errors
    ///
    /// When one light is of another kind, or several have another number of faces.
    pub fn move_lights(&mut self, lights: &[sglow_scene::Light]) -> Result<(), FrameError> {
        let settings = self.frame.settings();
        let (was, is) = (settings.light, light::kind_of_all(lights));
        if was != is && was != Light::Several {
            return Err(FrameError::AnotherLight { was, is });
        }
        let (was, is) = (settings.light_faces, light::faces(lights));
        if was != is {
            return Err(FrameError::OtherFaces { was, is });
        }
        self.light = view_of(lights, &self.bounds, settings)?;
        self.shadow_bias = shadow_bias(&self.light, shadow_size(&self.frame));
        Ok(())
    }

    /// Draws the light's map and the camera's G-buffer alone, and waits for them: what an [`Indirect`] of one's own then
    /// reads by [`Self::inputs`].
    ///
    /// # Errors
    ///
    /// When the device fails.
    pub fn draw_maps(&self) -> Result<(), FrameError> {
        self.submit(|stage| stage.part == "surfaces" && stage.label != "shadow", None)?;
        Ok(self.gpu.finish()?)
    }

    /// What indirect light reads.
    pub fn inputs(&self) -> Inputs<'_> {
        let (rsm, gbuffer) = (self.rsm.views(), self.gbuffer.views());
        Inputs { rsm, gbuffer, light: &self.light, eye: self.eye }
    }

    /// Renders one frame and waits for it. Returns the time of each pass and how it was taken.
    ///
    /// # Errors
    ///
    /// When the device fails.
    pub fn render(&self) -> Result<Times, FrameError> {
        let mut timer = Timer::new(self.gpu);
        let clock = timer.clock();
        self.submit(|_| true, Some(&mut timer))?;
        let passes = timer.finish()?;
        self.gpu.finish()?;
        Ok(Times { passes, clock })
    }

    fn submit(
        &self,
        selected: impl Fn(execute::Stage<'_>) -> bool,
        timer: Option<&mut Timer<'_>>,
    ) -> Result<(), FrameError> {
        let mut given = self.frame.given(&self.inputs());
        host::camera(&mut given, &self.view);
        host::shadow(&mut given, self.shadow_bias.depth, &self.shadow_bias.faces);
        let (surfaces, emitters) = (self.raster.surfaces(), self.raster.emitters());
        given.draws("surfaces", &surfaces).draws("emitters", &emitters);
        let mut encoder = self.gpu.device.create_command_encoder(&Default::default());
        let timer = timer.map(|timer| timer as _);
        let encoded = self.frame.executor().encode_where(selected, &mut encoder, &given, timer);
        encoded.map_err(IndirectError::Frame)?;
        self.gpu.queue.submit([encoder.finish()]);
        Ok(())
    }

    /// The last frame, read back.
    ///
    /// # Errors
    ///
    /// When the device fails.
    pub fn read(&self) -> Result<Frame, FrameError> {
        let read = |name: &str| {
            let texture = self.frame.texture(name);
            texture.map(|texture| readback::texture(self.gpu, &texture, 0)).transpose()
        };
        Ok(Frame {
            size: self.frame.settings().size,
            radiance: read("radiance")?.unwrap_or_default(),
            direct: read("direct")?.unwrap_or_default(),
            indirect_diffuse: read("diffuse")?,
            indirect_specular: read("specular")?,
            emission: read("emission")?,
            gbuffer: self.read_gbuffer()?,
        })
    }

    /// The bytes of each texture and buffer that it keeps between frames, but for the scene itself and parameters: what
    /// [`crate::plan::Plan`] foresees, by the same names.
    pub fn bytes(&self) -> Vec<(String, u64)> {
        let all = [readback::bytes(&self.frame), self.occluder_bytes.clone()].concat();
        // A sampler has none.
        all.into_iter().filter(|(_, bytes)| *bytes > 0).collect()
    }

    /// The camera's G-buffer of the last frame, read back.
    pub fn read_gbuffer(&self) -> Result<Surfaces, FrameError> {
        self.gbuffer.read(self.gpu)
    }

    /// The reflective shadow map of the last frame, read back.
    pub fn read_rsm(&self) -> Result<Surfaces, FrameError> {
        self.rsm.read(self.gpu)
    }

    /// The shadow map of the last frame, read back: depth in x.
    pub fn read_shadow_map(&self) -> Result<Pixels, FrameError> {
        let texture = self.frame.texture("shadow_map");
        let read = texture.map(|texture| readback::texture(self.gpu, &texture, 0)).transpose()?;
        Ok(read.unwrap_or_default())
    }

    /// The whole frame: its settings and what it keeps.
    pub fn indirect(&self) -> &Indirect {
        &self.frame
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
    pub fn shadow_bias(&self) -> &ShadowBias {
        &self.shadow_bias
    }

    /// The scene on the device.
    pub fn raster(&self) -> &Raster {
        &self.raster
    }

    /// The camera's view.
    pub fn view(&self) -> &SglowView {
        &self.view
    }
}
