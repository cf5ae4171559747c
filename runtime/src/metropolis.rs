//! Centres that Markov chains draw: a rival of the warped lattice, coherent from frame to frame and not stratified.

use std::sync::atomic::{AtomicU32, Ordering};

use bytemuck::{Pod, Zeroable};
use sglow_shaders::Start;

use crate::package::Package;
use crate::pipeline::{ComputePass, PipelineError, Step, constant, encode_stage, storage};
use crate::timing::Timer;

/// How chains begin and how they move.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MetropolisSettings {
    /// Number of chains, which is the number of centres: 1 to 65536.
    pub count: u32,
    /// Mutations of each chain in a frame, at least 1.
    pub mutations: u32,
    /// Half the side of the square that a small step leads into, 0 to 1; the image's side is 1.
    pub radius: f32,
    /// The share of steps that lead anywhere, 0 to 1.
    pub large_steps: f32,
    /// What the random numbers are made of, with the number of the frame.
    pub seed: u32,
    /// Where chains begin.
    pub start: Start,
}

impl MetropolisSettings {
    /// Settings for a number of chains: 4 mutations of at most a fiftieth of the image, one in ten anywhere, from the
    /// warped lattice.
    pub fn of(count: u32) -> Self {
        let start = Start::Warped;
        Self { count, mutations: 1, radius: 0.01, large_steps: 0.02, seed: 1, start }
    }

    /// The variants that they run.
    pub(crate) fn variants(&self) -> Vec<String> {
        let start = sglow_shaders::metropolis_start::MetropolisStart { start: self.start };
        vec![start.id(), sglow_shaders::metropolis::Metropolis.id()]
    }

    /// The bytes of the chains.
    pub(crate) fn bytes(&self) -> u64 {
        8 * u64::from(self.count)
    }
}

// The layouts of uniforms whose passes are not committed, and so have no structs in the bindings; padded to 16 bytes.

#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct StartParameters {
    count: u32,
    seed: u32,
    padding: [u32; 2],
}

#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct Parameters {
    count: u32,
    mutations: u32,
    frame: u32,
    seed: u32,
    radius: f32,
    large_steps: f32,
    padding: [u32; 2],
}

/// Chains that are kept from frame to frame, and the passes that move them.
pub struct Metropolis {
    settings: MetropolisSettings,
    /// Frames since the chains began; in 0 they begin.
    frame: AtomicU32,
    chains: wgpu::Buffer,
    start_pass: ComputePass,
    pass: ComputePass,
}

impl Metropolis {
    /// Chains that begin with the first frame.
    ///
    /// # Errors
    ///
    /// When the package lacks a variant or the device refuses it.
    pub fn new(
        device: &wgpu::Device,
        package: &Package,
        settings: &MetropolisSettings,
    ) -> Result<Self, PipelineError> {
        let start = sglow_shaders::metropolis_start::MetropolisStart { start: settings.start };
        let pass = sglow_shaders::metropolis::Metropolis.id();
        Ok(Self {
            settings: *settings,
            frame: AtomicU32::new(0),
            chains: storage(device, "sglow chains", 2 * u64::from(settings.count)),
            start_pass: ComputePass::new(device, package, &start.id(), "centres", &[])?,
            pass: ComputePass::new(device, package, &pass, "centres", &[])?,
        })
    }

    /// Encodes one frame's mutations, timed as "centres". In the first frame the chains begin before.
    ///
    /// `density`: a view of all levels of a power-of-two square, r32float, as a texture array.
    pub fn encode(
        &self,
        device: &wgpu::Device,
        encoder: &mut wgpu::CommandEncoder,
        density: &wgpu::TextureView,
        timer: Option<&mut Timer<'_>>,
    ) {
        let MetropolisSettings { count, mutations, radius, large_steps, seed, start } =
            self.settings;
        let frame = self.frame.fetch_add(1, Ordering::Relaxed);
        let padding = [0; 2];
        let begin = StartParameters { count, seed, padding };
        let begin = constant(device, "sglow chains begin", &begin);
        // Of its own for each frame, for several may be encoded before the first of them runs.
        let parameters = Parameters { count, mutations, frame, seed, radius, large_steps, padding };
        let parameters = constant(device, "sglow chains", &parameters);
        let workgroups = [count.div_ceil(64), 1, 1];
        let mut steps = Vec::new();
        if frame == 0 {
            let mut bindings =
                vec![(0, begin.as_entire_binding()), (1, self.chains.as_entire_binding())];
            if start == Start::Warped {
                bindings.push((2, wgpu::BindingResource::TextureView(density)));
            }
            steps.push(Step { pass: &self.start_pass, bindings, workgroups });
        }
        let bindings = vec![
            (0, parameters.as_entire_binding()),
            (1, wgpu::BindingResource::TextureView(density)),
            (2, self.chains.as_entire_binding()),
        ];
        steps.push(Step { pass: &self.pass, bindings, workgroups });
        encode_stage(device, encoder, timer, "centres", &steps);
    }

    /// Lets the chains begin again with the next frame.
    pub fn restart(&self) {
        self.frame.store(0, Ordering::Relaxed);
    }

    /// How chains begin and how they move.
    pub fn settings(&self) -> &MetropolisSettings {
        &self.settings
    }

    /// Where the chains are: two floats each, in \[0, 1\]^2 of the density.
    pub fn chains(&self) -> &wgpu::Buffer {
        &self.chains
    }
}
