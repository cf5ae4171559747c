//! No light: a map that shows nothing, a camera that sees nothing, a light without a photon that reflects. By every
//! density and every method indirect light is black, and nothing is NaN.

use sglow_renderer::frame::Surfaces;
use sglow_renderer::readback;
use sglow_renderer::stages::Stages as _;
use sglow_runtime::indirect::Inputs;
use sglow_runtime::settings::Settings;
use sglow_shaders::{Density, Draw, Kernel, Solver, Space};

use crate::common::{KINDS, Uploaded, gpu, indirect, light, random_surfaces, small, whole_space};

/// The indirect light of a frame, diffuse and specular, and whether its lights are all numbers.
fn run(settings: &Settings, rsm: &Surfaces, gbuffer: &Surfaces) -> (Vec<[f32; 4]>, bool) {
    let gpu = gpu();
    let indirect = indirect(settings, whole_space());
    let view = light(KINDS[0], settings.rsm_size);
    let (rsm, gbuffer) =
        (Uploaded::new(rsm, [settings.rsm_size; 2]), Uploaded::new(gbuffer, settings.size));
    let inputs = Inputs {
        rsm: rsm.views(),
        gbuffer: gbuffer.views(),
        light: &view,
        eye: glam::Vec3::new(0.5, 1.8, 3.0),
    };
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    indirect.encode(&mut encoder, &inputs, None).unwrap();
    gpu.queue.submit([encoder.finish()]);
    gpu.finish().unwrap();
    let words: Vec<f32> = readback::buffer(gpu, &indirect.vsgls().unwrap()).unwrap();
    let pixels = [indirect.diffuse(), indirect.specular()]
        .into_iter()
        .flatten()
        .flat_map(|texture| readback::texture(gpu, &texture, 0).unwrap())
        .collect();
    (pixels, words.iter().all(|word| word.is_finite()))
}

/// Every way to make lights.
fn methods() -> Vec<Settings> {
    let mut all = Vec::new();
    for density in Density::ALL {
        let base = Settings { density, count: 40, ..small() };
        all.push(Settings { kernel: Kernel::Previous, ..base.clone() });
        all.push(Settings { solver: Solver::Bisection, ..base.clone() });
        all.push(Settings { draw: Draw::Metropolis, ..base.clone() });
        all.push(Settings { space: Space::Image, ..base.clone() });
        all.push(Settings { space: Space::World, ..base.clone() });
        all.push(base);
    }
    all
}

fn absent(mut surfaces: Surfaces) -> Surfaces {
    surfaces.position.iter_mut().for_each(|position| position[3] = -1.0);
    surfaces
}

fn black(mut surfaces: Surfaces) -> Surfaces {
    surfaces.position.iter_mut().for_each(|position| position[3] = 0.0);
    surfaces.base_color.iter_mut().for_each(|color| *color = [0.0; 4]);
    surfaces
}

fn is_black(pixels: &[[f32; 4]]) -> bool {
    pixels.iter().all(|pixel| pixel[..3] == [0.0; 3])
}

#[test]
fn what_has_no_light_is_black() {
    for settings in methods() {
        let what = format!(
            "{}, {}, {}, {}",
            settings.density, settings.kernel, settings.draw, settings.space
        );
        let rsm = random_surfaces([settings.rsm_size; 2], 11);
        let gbuffer = random_surfaces(settings.size, 12);
        // Negative control: with light it is not.
        let (lit, finite) = run(&settings, &rsm, &gbuffer);
        assert!(finite && !is_black(&lit), "{what}: lit");
        assert!(lit.iter().flatten().all(|value| value.is_finite()), "{what}: lit");
        for (case, rsm) in
            [("a light that sees nothing", absent(rsm.clone())), ("black walls", black(rsm))]
        {
            let (dark, finite) = run(&settings, &rsm, &gbuffer);
            assert!(finite && is_black(&dark), "{what}: {case}");
        }
    }
}

/// Then no density is worth anything to the camera, and there is nothing to light.
#[test]
fn a_camera_that_sees_nothing_shows_black() {
    for settings in methods() {
        let rsm = random_surfaces([settings.rsm_size; 2], 13);
        let gbuffer = absent(random_surfaces(settings.size, 14));
        let (dark, finite) = run(&settings, &rsm, &gbuffer);
        assert!(finite && is_black(&dark), "{}, {}", settings.density, settings.space);
    }
}

/// One light, and more of them than texels.
#[test]
fn any_number_of_lights_keeps_the_picture_finite() {
    for settings in methods() {
        for (count, camera_count, rsm_size) in [(1, 1, 32), (500, 700, 8)] {
            let settings = Settings { count, camera_count, rsm_size, ..settings.clone() };
            let rsm = random_surfaces([rsm_size; 2], 15);
            let (lit, finite) = run(&settings, &rsm, &random_surfaces(settings.size, 16));
            let what = format!("{count} lights, {}, {}", settings.density, settings.space);
            assert!(finite && !is_black(&lit), "{what}");
            assert!(lit.iter().flatten().all(|value| value.is_finite() && *value >= 0.0), "{what}");
        }
    }
}
