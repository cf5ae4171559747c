//! Indirect light on textures that an engine already has.

use std::collections::BTreeSet;
use std::sync::{Mutex, MutexGuard, PoisonError};

use glam::Vec3;
use sglow_graph::Configuration;
use sglow_shaders::frame::{input, part, resource};
use thiserror::Error;

use crate::execute::{self, Executor, Fault, Faults, Lists};
use crate::host;
use crate::light::LightView;
use crate::occluders::Occluders;
use crate::package::Package;
use crate::pipeline::PipelineError;
use crate::settings::Settings;
use crate::timing::PassTimer;

/// Errors of [`Indirect`].
#[derive(Debug, Error)]
pub enum IndirectError {
    /// Invalid settings.
    #[error(transparent)]
    Settings(sglow_graph::Errors),
    /// A variant does not become a pipeline.
    #[error(transparent)]
    Pipeline(#[from] PipelineError),
    /// The package describes no frame, or one of which nothing comes.
    #[error("{0}; generate the package again: cargo xtask gen-shaders --out DIR")]
    Description(String),
    /// The frame cannot be executed.
    #[error(transparent)]
    Frame(Faults),
}

impl From<Faults> for IndirectError {
    /// A single variant that is at fault stands for itself.
    fn from(Faults(mut faults): Faults) -> Self {
        match (faults.pop(), faults.is_empty()) {
            (Some(Fault::Pipeline(error)), true) => Self::Pipeline(error),
            (Some(Fault::Variant { error, .. }), true) => Self::Pipeline(error.into()),
            (last, _) => {
                faults.extend(last);
                Self::Frame(Faults(faults))
            }
        }
    }
}

/// The three surface textures of a reflective shadow map or a G-buffer; what they hold stands in ARCHITECTURE.md.
#[derive(Clone, Copy)]
pub struct SurfaceViews<'a> {
    /// World position; dielectric reflectance in w, negative without a surface.
    pub position: &'a wgpu::TextureView,
    /// Unit normal; roughness alpha in w.
    pub normal: &'a wgpu::TextureView,
    /// Base colour; metallic in w.
    pub base_color: &'a wgpu::TextureView,
}

/// What one frame of indirect light reads.
#[derive(Clone, Copy)]
pub struct Inputs<'a> {
    /// The reflective shadow map, `rsm_size` squared.
    pub rsm: SurfaceViews<'a>,
    /// The camera's G-buffer, of the picture's size.
    pub gbuffer: SurfaceViews<'a>,
    /// The light and its map.
    pub light: &'a LightView,
    /// The camera's position.
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
    /// Indirect light by the embedded package, in a scene without occluders or with visibility `none`.
    ///
    /// # Errors
    ///
    /// All the settings that cannot be, at once; or the variant that the device refuses.
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
    /// engine supplies with each frame in place of those that are made here, such as textures of its own to write to. The
    /// numbers of the occluders are added.
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
    /// from frame to frame begins again.
    ///
    /// # Errors
    ///
    /// As [`Self::new`]; what there was before stays.
    pub fn resize(&mut self, settings: &Settings) -> Result<(), IndirectError> {
        let Configuration { axes, parameters, .. } = settings.configuration();
        let configuration = Configuration { axes, parameters, ..self.configuration.clone() };
        let frame = frame(&self.package, configuration, &self.occluders)?;
        self.executor().resize(&self.package, &frame, &Lists::new())?;
        self.settings = settings.clone();
        Ok(())
    }

    /// Takes other triangles that occlude virtual lights.
    ///
    /// # Errors
    ///
    /// As [`Self::new`]; what there was before stays.
    pub fn occlude(&mut self, occluders: Occluders) -> Result<(), IndirectError> {
        let frame = frame(&self.package, self.configuration.clone(), &occluders)?;
        self.executor().resize(&self.package, &frame, &Lists::new())?;
        self.occluders = occluders;
        Ok(())
    }

    /// What a thread that panicked has left is as good as any.
    fn executor(&self) -> MutexGuard<'_, Executor> {
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
        Ok(self.executor().encode(encoder, &self.given(inputs), timer)?)
    }

    /// Encodes some stages alone, with everything that a host gives for them.
    ///
    /// # Errors
    ///
    /// What is left out or does not fit.
    pub fn encode_where(
        &self,
        wanted: impl Fn(execute::Stage<'_>) -> bool,
        encoder: &mut wgpu::CommandEncoder,
        inputs: &execute::Inputs<'_>,
        timer: Option<&mut (dyn PassTimer + '_)>,
    ) -> Result<(), IndirectError> {
        Ok(self.executor().encode_where(wanted, encoder, inputs, timer)?)
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
        host::light(&mut given, light);
        host::light_maps(&mut given, light.least_near, host::bias(bias_scale, tile));
        given.set(input::DIFFUSE_MEAN_LENGTH, self.settings.diffuse_mean_length());
        self.occluders.supply(&mut given);
        given
    }

    /// Adds what follows from the camera.
    pub fn seen(&self, given: &mut execute::Inputs<'_>, gbuffer: SurfaceViews<'_>, eye: Vec3) {
        host::eye_at(given, eye);
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

    /// The bytes of each texture, with its mips, and of each buffer that it keeps between its passes; those of the
    /// parameters are left out.
    pub fn bytes(&self) -> Vec<(String, u64)> {
        self.executor().bytes().map(|(name, bytes)| (name.to_owned(), bytes)).collect()
    }

    /// How many pipelines and bind groups were made.
    pub fn made(&self) -> execute::Made {
        self.executor().made()
    }
}

fn frame(
    package: &Package,
    mut configuration: Configuration,
    occluders: &Occluders,
) -> Result<sglow_graph::Frame, IndirectError> {
    let Some(description) = package.description() else {
        let text = format!("the package {} describes no frame", package.origin());
        return Err(IndirectError::Description(text));
    };
    host::occluder_counts(&mut configuration, occluders.counts().map(u64::from));
    description.evaluate(&configuration).map_err(IndirectError::Settings)
}

fn supply(given: &mut execute::Inputs<'_>, names: [&'static str; 3], views: SurfaceViews<'_>) {
    for (name, view) in names.into_iter().zip([views.position, views.normal, views.base_color]) {
        given.view(name, view);
    }
}
