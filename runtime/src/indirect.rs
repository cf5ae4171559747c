//! Indirect light on textures that an engine already has.

use std::collections::BTreeSet;
use std::sync::{Mutex, MutexGuard, PoisonError};

use glam::Vec3;
use sglow_graph::Configuration;
use sglow_shaders::Light;
use sglow_shaders::frame::{input, part, resource};
use thiserror::Error;

use crate::execute::{self, Executor, Faults, Lists};
use crate::host;
use crate::light::{self, LightView};
use crate::occluders::Occluders;
use crate::package::Package;
use crate::settings::Settings;
use crate::timing::PassTimer;

/// Errors of [`Indirect`].
#[derive(Debug, Error)]
pub enum IndirectError {
    /// Invalid settings.
    #[error(transparent)]
    Settings(sglow_graph::Errors),
    /// The package describes no frame, or one of which nothing comes.
    #[error("{0}; generate the package again: cargo xtask gen-shaders --out DIR")]
    Description(String),
    /// The frame cannot be executed.
    #[error(transparent)]
    Frame(#[from] Faults),
}

/// The three surface textures of a reflective shadow map or a G-buffer; `docs/conventions.md` says what they hold.
#[derive(Clone, Copy)]
pub struct SurfaceViews<'a> {
    /// Position, relative to [`crate::light::Surroundings::origin`]; dielectric reflectance in w, negative without a surface.
    pub position: &'a wgpu::TextureView,
    /// Unit normal; roughness alpha in w.
    pub normal: &'a wgpu::TextureView,
    /// Base colour; metallic in w.
    pub base_color: &'a wgpu::TextureView,
}

/// What one frame of indirect light reads.
#[derive(Clone, Copy)]
pub struct Inputs<'a> {
    /// The reflective shadow map, [`Settings::map`] squared.
    pub rsm: SurfaceViews<'a>,
    /// The camera's G-buffer, of the picture's size.
    pub gbuffer: SurfaceViews<'a>,
    /// The light and its map; of several lights [`LightView::several`].
    pub light: &'a LightView,
    /// The camera's position, relative to [`crate::light::Surroundings::origin`].
    pub eye: Vec3,
}

/// The parts of a frame that an engine leaves to [`Indirect`].
pub const PARTS: [&str; 3] = [part::LIGHTS, part::VISIBILITY, part::SHADING];

/// A frame, or parts of one, with all that it keeps between its passes.
///
/// Nothing that the settings leave out exists: without specular lobes there are no specular moments, no mips of them,
/// no fields for them in the lights, and no texture for their light; without the bidirectional density the camera has no
/// lights.
pub struct Indirect {
    package: Package,
    settings: Settings,
    /// What the settings are a part of: parts, draws.
    configuration: Configuration,
    occluders: Occluders,
    executor: Mutex<Executor>,
}

/// What a frame is made on and of.
#[derive(Clone, Copy)]
pub struct Source<'a> {
    /// The device.
    pub device: &'a wgpu::Device,
    /// Its queue.
    pub queue: &'a wgpu::Queue,
    /// The shaders and the description of the frame.
    pub package: &'a Package,
}

impl Indirect {
    /// Indirect light by the embedded package. With visibility, [`Self::occlude`] gives it the triangles of the scene.
    ///
    /// # Errors
    ///
    /// All invalid settings at once; or the variant that the device refuses.
    pub fn new(
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        settings: &Settings,
    ) -> Result<Self, IndirectError> {
        let package = &Package::embedded();
        Self::of_parts(Source { device, queue, package }, settings, &PARTS, &Occluders::default())
    }

    /// Parts of a frame. What the others would hold is supplied with each frame, by its name.
    ///
    /// # Errors
    ///
    /// As [`Self::new`].
    pub fn of_parts(
        source: Source<'_>,
        settings: &Settings,
        parts: &[&str],
        occluders: &Occluders,
    ) -> Result<Self, IndirectError> {
        let parts = parts.iter().map(|part| (*part).to_owned()).collect::<BTreeSet<_>>();
        let configuration = Configuration { parts: Some(parts), ..settings.configuration() };
        Self::of_configuration(source, settings, configuration, occluders, &Lists::new())
    }

    /// The frame of a configuration, which is that of the settings with more said: its parts, its draws, and which resources the
    /// engine supplies with each frame in place of those that are made here, such as textures of its own to write to, of the
    /// format that [`Settings::output`] says. The numbers of the occluders are added.
    ///
    /// # Errors
    ///
    /// As [`Self::new`].
    pub fn of_configuration(
        Source { device, queue, package }: Source<'_>,
        settings: &Settings,
        configuration: Configuration,
        occluders: &Occluders,
        lists: &Lists<'_>,
    ) -> Result<Self, IndirectError> {
        let frame = frame(package, configuration.clone(), occluders)?;
        let executor = Mutex::new(Executor::new(device, queue, package, &frame, lists)?);
        let (settings, occluders) = (settings.clone(), occluders.clone());
        Ok(Self { package: package.clone(), settings, configuration, occluders, executor })
    }

    /// Takes other settings: another size, other numbers, other values of axes. Pipelines that serve them stay; what was kept
    /// from frame to frame begins again. Not for a frame with lists of draws.
    ///
    /// # Errors
    ///
    /// As [`Self::new`]; what there was before stays.
    pub fn resize(&mut self, settings: &Settings) -> Result<(), IndirectError> {
        let Configuration { axes, parameters, .. } = settings.configuration();
        let mut configuration = self.configuration.clone();
        configuration.axes.extend(axes);
        configuration.parameters.extend(parameters);
        self.remake(&configuration, &self.occluders)?;
        (self.settings, self.configuration) = (settings.clone(), configuration);
        Ok(())
    }

    /// Takes other triangles that occlude virtual lights. Not for a frame with lists of draws.
    ///
    /// # Errors
    ///
    /// As [`Self::new`]; what there was before stays.
    pub fn occlude(&mut self, occluders: Occluders) -> Result<(), IndirectError> {
        occluders.check(&self.settings)?;
        self.remake(&self.configuration, &occluders)?;
        self.occluders = occluders;
        Ok(())
    }

    fn remake(&self, of: &Configuration, occluders: &Occluders) -> Result<(), IndirectError> {
        let frame = frame(&self.package, of.clone(), occluders)?;
        Ok(self.executor().resize(&self.package, &frame, &Lists::new())?)
    }

    /// What executes the frame, for stages alone, for what they read and leave. Hold it no longer than for one call: encoding
    /// waits for it.
    // What a thread that panicked has left is as good as any.
    pub fn executor(&self) -> MutexGuard<'_, Executor> {
        self.executor.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Encodes one frame: from the reflective shadow map to reflected radiance.
    ///
    /// # Errors
    ///
    /// What of the inputs does not fit.
    pub fn encode(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        inputs: &Inputs<'_>,
        timer: Option<&mut (dyn PassTimer + '_)>,
    ) -> Result<(), IndirectError> {
        self.occluders.check(&self.settings)?;
        let (LightView { kind, map, faces, .. }, settings) = (inputs.light, &self.settings);
        let Settings { light, map: own_map, light_faces, .. } = settings;
        if (kind, map) != (light, own_map) {
            let found = format!("a {kind} light for a map of {map} texels");
            let expected = format!("that of the settings: light={light},map={own_map}");
            return Err(Faults::of("the light", found, expected).into());
        }
        if *kind == Light::Several && faces.len() != *light_faces as usize {
            let found = format!("{} lights with {} faces", inputs.light.lights.len(), faces.len());
            let expected = format!("as many faces as light_faces of the settings: {light_faces}");
            return Err(Faults::of("the lights", found, expected).into());
        }
        Ok(self.executor().encode(encoder, &self.given(inputs), timer)?)
    }

    /// Everything that a host gives for a frame, but for lists of draws.
    pub fn given<'a>(&self, inputs: &Inputs<'_>) -> execute::Inputs<'a> {
        let mut given = self.lit(inputs.light);
        self.seen(&mut given, inputs.gbuffer, inputs.eye);
        let names = [resource::RSM_POSITION, resource::RSM_NORMAL, resource::RSM_BASE_COLOR];
        supply(&mut given, names, inputs.rsm);
        given
    }

    /// What follows from the light and the settings.
    pub fn lit<'a>(&self, light: &LightView) -> execute::Inputs<'a> {
        let mut given = execute::Inputs::new();
        let Settings { bias_scale, tile, .. } = self.settings;
        light.give(&mut given);
        given
            .set(input::LEAST_NEAR, light.least_near)
            .set(input::BIAS, host::bias(bias_scale, tile))
            .set(input::DIFFUSE_MEAN_LENGTH, self.settings.diffuse_mean_length());
        self.occluders.supply(&mut given);
        given
    }

    /// Adds what follows from the camera.
    pub fn seen(&self, given: &mut execute::Inputs<'_>, gbuffer: SurfaceViews<'_>, eye: Vec3) {
        light::eye_at(given, eye);
        supply(
            given,
            [resource::GBUFFER_POSITION, resource::GBUFFER_NORMAL, resource::GBUFFER_BASE_COLOR],
            gbuffer,
        );
    }

    /// Lets Markov chains begin again with the next frame.
    pub fn restart(&self) {
        self.executor().restart();
    }

    /// What it was made with.
    pub fn settings(&self) -> &Settings {
        &self.settings
    }

    /// A texture of the frame by its name; none if the frame has none, or the host supplies it.
    pub fn texture(&self, name: &str) -> Option<wgpu::Texture> {
        self.executor().texture(name).cloned()
    }

    /// A buffer of the frame by its name, of a pair with `.0` or `.1` behind it; none if the frame has none, or the host
    /// supplies it.
    pub fn buffer(&self, name: &str) -> Option<wgpu::Buffer> {
        self.executor().buffer(name).cloned()
    }
}

fn frame(
    package: &Package,
    mut configuration: Configuration,
    occluders: &Occluders,
) -> Result<sglow_graph::Frame, IndirectError> {
    let missing = || format!("the package {} describes no frame", package.origin());
    let description = package.description().ok_or_else(|| IndirectError::Description(missing()))?;
    host::occluder_counts(&mut configuration, occluders.counts().map(u64::from));
    description.evaluate(&configuration).map_err(IndirectError::Settings)
}

fn supply(given: &mut execute::Inputs<'_>, names: [&'static str; 3], views: SurfaceViews<'_>) {
    for (name, view) in names.into_iter().zip([views.position, views.normal, views.base_color]) {
        given.view(name, view);
    }
}
