//! Indirect light on surfaces of one's own: here a floor that a spot light shines on.

use glam::{DVec3, Vec3};
use sglow_runtime::indirect::{Indirect, Inputs, SurfaceViews};
use sglow_runtime::light::{LightView, Surroundings};
use sglow_runtime::settings::Settings;
use wgpu::util::{DeviceExt, TextureDataOrder};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let adapter = wgpu::Instance::default().request_adapter(&Default::default());
    let device = pollster::block_on(adapter)?.request_device(&Default::default());
    let (device, queue) = pollster::block_on(device)?;
    // Once; `resize` takes other settings.
    let settings = Settings { size: [320, 180], map: 128, lights: 256, ..Settings::default() };
    let indirect = Indirect::new(&device, &queue, &settings)?;
    // Yours: what the light and the camera see. Position and dielectric reflectance (negative where there is no surface),
    // normal and roughness alpha, base color and metallic.
    let floor = |[width, height]: [u32; 2]| {
        let at = |index: u32, side: u32| 4.0 * (index as f32 + 0.5) / side as f32 - 2.0;
        let texels =
            (0..width * height).map(|i| [at(i % width, width), 0.0, at(i / width, height)]);
        let position: Vec<_> = texels.map(|[x, y, z]| [x, y, z, 0.04]).collect();
        let count = position.len();
        [position, vec![[0.0, 1.0, 0.0, 0.5]; count], vec![[0.8, 0.4, 0.2, 0.0]; count]].map(
            |texels| {
                let (size, format) = ([width, height], wgpu::TextureFormat::Rgba32Float);
                let descriptor = texture(size, format);
                let data = bytemuck::cast_slice(&texels);
                let made = device.create_texture_with_data(
                    &queue,
                    &descriptor,
                    TextureDataOrder::LayerMajor,
                    data,
                );
                made.create_view(&Default::default())
            },
        )
    };
    let (rsm, gbuffer) = (floor([settings.map; 2]), floor(settings.size));
    // Each frame: the light, the camera's position and these textures give reflected radiance.
    let around =
        Surroundings { origin: DVec3::ZERO, center: DVec3::ZERO, radius: 3.0, map: settings.map };
    let above = DVec3::new(0.0, 3.0, 0.0);
    let light = LightView::spot(&around, above, Vec3::NEG_Y, [0.4, 0.6], [50.0, 45.0, 40.0]);
    let eye = Vec3::new(0.0, 2.0, 4.0);
    let inputs = Inputs { rsm: views(&rsm), gbuffer: views(&gbuffer), light: &light, eye };
    let mut encoder = device.create_command_encoder(&Default::default());
    indirect.encode(&mut encoder, &inputs, None)?;
    queue.submit([encoder.finish()]);
    device.poll(wgpu::PollType::wait_indefinitely())?;
    let diffuse = indirect.texture("diffuse").ok_or("there is no diffuse reflection")?;
    println!("{} x {} pixels of reflected radiance", diffuse.width(), diffuse.height());
    Ok(())
}

fn views(textures: &[wgpu::TextureView; 3]) -> SurfaceViews<'_> {
    let [position, normal, base_color] = textures;
    SurfaceViews { position, normal, base_color }
}

fn texture(size: [u32; 2], format: wgpu::TextureFormat) -> wgpu::TextureDescriptor<'static> {
    wgpu::TextureDescriptor {
        label: None,
        size: wgpu::Extent3d { width: size[0], height: size[1], depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage: wgpu::TextureUsages::TEXTURE_BINDING,
        view_formats: &[],
    }
}
