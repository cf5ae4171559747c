//! The shading pass by itself: virtual lights of any maker, reflected towards the camera.

use glam::Vec3;
use sglow_shaders::{Diffuse, SglowShadeParameters, Specular};

use crate::indirect::{SurfaceViews, picture};
use crate::package::Package;
use crate::pipeline::{ComputePass, Dispatch, PipelineError, uniform};
use crate::settings::Settings;
use crate::timing::Timer;
use crate::visibility::Visibility;

/// The shading pass with the pictures that it writes.
pub struct Shading {
    device: wgpu::Device,
    queue: wgpu::Queue,
    size: [u32; 2],
    diffuse: Option<(wgpu::Texture, wgpu::TextureView)>,
    specular: Option<(wgpu::Texture, wgpu::TextureView)>,
    parameters: wgpu::Buffer,
    pass: ComputePass,
}

/// What one frame of shading reads.
#[derive(Clone, Copy)]
pub struct ShadingInputs<'a> {
    /// The camera's G-buffer, of the picture's size.
    pub gbuffer: SurfaceViews<'a>,
    /// The camera's position.
    pub eye: Vec3,
    /// The virtual lights, of the lobes and the precision that the settings name.
    pub vsgls: &'a wgpu::Buffer,
    /// How many of them.
    pub count: u32,
    /// Their maps, of the kind that the settings name; none where lights shine through walls.
    pub visibility: Option<&'a Visibility>,
}

impl Shading {
    /// The variant of the settings; of these, those of making lights are of no account.
    ///
    /// # Errors
    ///
    /// Names the variant that the package lacks or the device refuses.
    pub fn new(
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        settings: &Settings,
        package: &Package,
    ) -> Result<Self, PipelineError> {
        let output = |label| {
            let texture = picture(device, label, settings.size, wgpu::TextureFormat::Rgba32Float);
            let view = texture.create_view(&wgpu::TextureViewDescriptor::default());
            (texture, view)
        };
        Ok(Self {
            diffuse: (settings.diffuse != Diffuse::None).then(|| output("sglow indirect diffuse")),
            specular: (settings.specular != Specular::None)
                .then(|| output("sglow indirect specular")),
            parameters: uniform::<SglowShadeParameters>(device, "sglow shade parameters"),
            pass: ComputePass::new(device, package, &settings.shade().id(), "shade", &[])?,
            device: device.clone(),
            queue: queue.clone(),
            size: settings.size,
        })
    }

    /// Encodes one frame of reflected radiance, into [`Self::diffuse`] and [`Self::specular`].
    pub fn encode(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        inputs: &ShadingInputs<'_>,
        timer: Option<&mut Timer<'_>>,
    ) {
        let parameters = SglowShadeParameters { eye: inputs.eye.into(), count: inputs.count };
        self.queue.write_buffer(&self.parameters, 0, bytemuck::bytes_of(&parameters));
        let mut bindings = vec![
            (0, self.parameters.as_entire_binding()),
            (1, wgpu::BindingResource::TextureView(inputs.gbuffer.position)),
            (2, wgpu::BindingResource::TextureView(inputs.gbuffer.normal)),
            (3, wgpu::BindingResource::TextureView(inputs.gbuffer.base_color)),
            (4, inputs.vsgls.as_entire_binding()),
        ];
        for (binding, output) in [(5, &self.diffuse), (6, &self.specular)] {
            if let Some((_, view)) = output {
                bindings.push((binding, wgpu::BindingResource::TextureView(view)));
            }
        }
        if let Some(visibility) = inputs.visibility {
            bindings.extend(visibility.shade_bindings());
        }
        let [width, height] = self.size;
        let workgroups = [width.div_ceil(8), height.div_ceil(8), 1];
        let dispatch = Dispatch { bindings: &bindings, workgroups };
        self.pass.encode(&self.device, encoder, timer, &[dispatch]);
    }

    /// Diffusely reflected radiance, rgba32float; nothing without diffuse reflection.
    pub fn diffuse(&self) -> Option<&wgpu::Texture> {
        self.diffuse.as_ref().map(|(texture, _)| texture)
    }

    /// Specularly reflected radiance, rgba32float; nothing without specular reflection.
    pub fn specular(&self) -> Option<&wgpu::Texture> {
        self.specular.as_ref().map(|(texture, _)| texture)
    }
}
