//! Flicker: how much more a picture changes from frame to frame than it has to, while the light moves.
//!
//! The reference are paths of one bounce whose random numbers are the same in every frame: scene and camera stand
//! still, so that each path's two ends do too, and only the light at its second end changes, smoothly but for the edge
//! of a shadow. There, and with the number of paths of a pixel, the estimate changes by chance: the reference comes in
//! two independent halves, and the mean product of the differences to both has no part of that noise. The sum over the
//! texels of a map would not do: the texels move with the light, and the sum flickers itself.

use glam::Vec3;
use sglow_oracle::fis::stress::Random;
use sglow_oracle::path::Paths;
use sglow_oracle::{metrics, surface};
use sglow_renderer::device::{DeviceError, Gpu};
use sglow_renderer::frame::{FrameError, Pixels, Renderer, Surfaces, occluders};
use sglow_renderer::reference::path::{SceneMaterials, facets, of_each_light};
use sglow_renderer::stages::Stages as _;
use sglow_renderer::variants::Variants as _;
use sglow_renderer::{readback, reference};
use sglow_results::rivals::flicker::{Flicker, Flickers, Walk};
use sglow_runtime::indirect::{Indirect, IndirectError, PARTS};
use sglow_runtime::package::Package;
use sglow_runtime::settings::Settings;
use sglow_scene::{Light, LightKind, Scene};
use sglow_shaders::{Density, Space};
use thiserror::Error;

/// Why nothing could be followed.
#[derive(Debug, Error)]
pub enum FlickerError {
    /// The scene does not render.
    #[error(transparent)]
    Frame(#[from] FrameError),
    /// The settings are not possible.
    #[error(transparent)]
    Indirect(#[from] IndirectError),
    /// Its triangles cannot be traced.
    #[error(transparent)]
    Scene(#[from] surface::SceneError),
    /// The device fails.
    #[error(transparent)]
    Device(#[from] DeviceError),
}

/// A configuration, by name.
#[derive(Clone, Debug)]
pub struct Contender {
    /// What it is called.
    pub name: String,
    /// What it is made of; the size of the map, the density and the picture are those of all.
    pub settings: Settings,
}

/// A light after some frames: moved to the side of where it shines, or turned about the vertical.
#[must_use]
pub fn moved(light: &Light, radius: f32, by: f32) -> Light {
    let direction = Vec3::from(light.direction);
    match light.kind {
        LightKind::Directional => {
            let turned = glam::Quat::from_rotation_y(by) * direction;
            Light { direction: turned.normalize().into(), ..light.clone() }
        }
        LightKind::Spot { .. } | LightKind::Point => {
            let side = direction.cross(Vec3::Y).try_normalize().unwrap_or(Vec3::X);
            let position = Vec3::from(light.position) + side * (by * radius);
            Light { position: position.into(), ..light.clone() }
        }
    }
}

/// Some of a picture's pixels that show a surface, by a fixed choice.
#[must_use]
pub fn some_pixels(surfaces: &Surfaces, count: usize) -> Vec<usize> {
    let mut present: Vec<usize> =
        (0..surfaces.position.len()).filter(|&at| surfaces.position[at][3] >= 0.0).collect();
    let mut random = Random::new(4);
    let count = count.min(present.len());
    for at in 0..count {
        let rest = present.len() - at;
        let other = at + ((random.uniform() * rest as f64) as usize).min(rest - 1);
        present.swap(at, other);
    }
    present.truncate(count);
    present.sort_unstable();
    present
}

/// The surfaces of some pixels.
#[must_use]
pub fn of_pixels(surfaces: &Surfaces, pixels: &[usize]) -> Surfaces {
    let take = |all: &Pixels| pixels.iter().map(|&at| all[at]).collect();
    Surfaces {
        position: take(&surfaces.position),
        normal: take(&surfaces.normal),
        base_color: take(&surfaces.base_color),
    }
}

/// Indirect radiance at some pixels, three numbers each.
pub fn indirect_at(
    gpu: &Gpu,
    indirect: &Indirect,
    pixels: &[usize],
) -> Result<Vec<f64>, FrameError> {
    let mut sum = vec![0.0; 3 * pixels.len()];
    for texture in [indirect.diffuse(), indirect.specular()].into_iter().flatten() {
        let picture = readback::texture(gpu, &texture, 0)?;
        for (index, &pixel) in pixels.iter().enumerate() {
            for channel in 0..3 {
                sum[3 * index + channel] += f64::from(picture[pixel][channel]);
            }
        }
    }
    Ok(sum)
}

/// Whether two settings draw by the same density.
fn shares(one: &Settings, other: &Settings) -> bool {
    let drawn_by = |settings: &Settings| {
        let Settings { density, lobes, precision, map, space, .. } = *settings;
        // The camera's lights and their emission are a part of the bidirectional density.
        let bidirectional = density == Density::Bidirectional;
        let camera = bidirectional.then_some((settings.camera_lights, settings.emitter));
        // A tree has no density that another could copy.
        let none = space == Space::Tree;
        (density, lobes, precision, map, settings.specular_power(), camera, none)
    };
    drawn_by(one) == drawn_by(other)
}

/// Moves the first light of a scene, while others stay, and follows every contender. The density of the first one is
/// computed once for all that draw by the same.
///
/// `progress` receives the number of frames that are done.
///
/// # Errors
///
/// When the scene does not render with one of the settings.
pub fn flicker(
    gpu: &Gpu,
    package: &Package,
    scene: &Scene,
    contenders: &[Contender],
    walk: Walk,
    progress: impl Fn(usize),
) -> Result<Flickers, FlickerError> {
    let Some((first, light)) = contenders.first().zip(scene.lights.first()) else {
        return Ok(Flickers { walk, reference_change: 0.0, contenders: Vec::new() });
    };
    let mut renderer = Renderer::new(gpu, package, scene, &first.settings, 0)?;
    let Settings { light: kind, light_faces, .. } = *renderer.indirect().settings();
    let others = contenders
        .iter()
        .map(|contender| {
            let settings = Settings { light: kind, light_faces, ..contender.settings.clone() };
            let occluders = occluders(gpu, scene, &settings).map_err(FrameError::from)?;
            let made = Indirect::of_parts(gpu.source(package), &settings, &PARTS, &occluders);
            Ok(made.map_err(FrameError::from)?)
        })
        .collect::<Result<Vec<_>, FlickerError>>()?;
    let radius = scene.bounds().radius();
    let (traced, materials) = (surface::Scene::new(facets(scene))?, SceneMaterials::new(scene));
    let mut pixels = Vec::new();
    let mut pictures = vec![Vec::new(); contenders.len()];
    let mut references: [Vec<Vec<f64>>; 2] = Default::default();
    for frame in 0..walk.frames {
        let mut lights = scene.lights.clone();
        lights[0] = moved(light, radius, walk.step * frame as f32);
        renderer.move_lights(if kind == sglow_shaders::Light::Several {
            &lights
        } else {
            &lights[..1]
        })?;
        renderer.draw_maps()?;
        let inputs = renderer.inputs();
        let own = renderer.indirect();
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        own.encode_camera(&mut encoder, &inputs, None)?;
        own.encode_moments(&mut encoder, &inputs, None)?;
        own.encode_density(&mut encoder, &inputs, None)?;
        for other in &others {
            if shares(other.settings(), own.settings()) {
                other.encode_moments(&mut encoder, &inputs, None)?;
                other.encode_density_of(&mut encoder, own);
            } else {
                other.encode_camera(&mut encoder, &inputs, None)?;
                other.encode_moments(&mut encoder, &inputs, None)?;
                other.encode_density(&mut encoder, &inputs, None)?;
            }
            other.encode_mips(&mut encoder, None)?;
            other.encode_sample(&mut encoder, &inputs, None)?;
            other.encode_light_maps(&mut encoder, inputs.light, None, None)?;
            other.encode_shade(&mut encoder, &inputs.into(), None, None)?;
        }
        gpu.queue.submit([encoder.finish()]);
        gpu.finish()?;
        let gbuffer = renderer.read_gbuffer()?;
        if frame == 0 {
            pixels = some_pixels(&gbuffer, walk.pixels);
        }
        for (other, pictures) in others.iter().zip(&mut pictures) {
            pictures.push(indirect_at(gpu, other, &pixels)?);
        }
        let receivers = reference::texels(&of_pixels(&gbuffer, &pixels));
        let eye = reference::vector(renderer.eye());
        let of_light = |_, light: &_| {
            let paths = Paths {
                scene: &traced,
                materials: &materials,
                light,
                ndf: reference::ndf(own.settings().ndf),
                samples: walk.samples,
                // Directions do not follow the light: their noise is nearly that of the frame before, and cancels.
                map: 0,
                seed: 1,
            };
            paths.halves(&receivers, eye, &|_| true)
        };
        let halves = of_each_light(renderer.light(), of_light).unwrap_or_default();
        for (at, references) in references.iter_mut().enumerate() {
            let radiance = halves.iter().flat_map(|halves| halves[at].mean.total().to_array());
            references.push(radiance.collect());
        }
        progress(frame + 1);
    }
    let found = contenders.iter().zip(&pictures);
    let mean_of = |(one, other): (&Vec<f64>, &Vec<f64>)| {
        one.iter().zip(other).map(|(one, other)| 0.5 * (one + other)).collect()
    };
    let both: Vec<Vec<f64>> = references[0].iter().zip(&references[1]).map(mean_of).collect();
    // The difference of a still picture is the reference's own change.
    let still: Vec<Vec<f64>> = both.iter().map(|frame| vec![0.0; frame.len()]).collect();
    Ok(Flickers {
        walk,
        reference_change: changes(&still, Some(&references)).0,
        contenders: found
            .map(|(contender, pictures)| {
                let (flicker, worst) = changes(pictures, Some(&references));
                Flicker {
                    name: contender.name.clone(),
                    error: error(pictures, &both),
                    change: changes(pictures, None).0 * mean(pictures) / mean(&both),
                    flicker,
                    trimmed: trimmed(pictures, &references),
                    worst,
                    not_finite: pictures.iter().flatten().filter(|one| !one.is_finite()).count(),
                }
            })
            .collect(),
    })
}

fn mean(frames: &[Vec<f64>]) -> f64 {
    let count = frames.iter().map(Vec::len).sum::<usize>().max(1);
    let mean = frames.iter().flatten().sum::<f64>() / count as f64;
    // Relative to nothing an error is what it is.
    if mean > 0.0 { mean } else { 1.0 }
}

/// The RMSE of all frames together over the mean of the reference.
fn error(frames: &[Vec<f64>], reference: &[Vec<f64>]) -> f64 {
    let [frames, reference] = [frames.concat(), reference.concat()];
    let compared = metrics::compare_exact(frames.as_chunks::<3>().0, reference.as_chunks::<3>().0);
    compared.map_or(0.0, |one| one.rmse_over_mean().value)
}

/// The share of pixels that [`Flicker::trimmed`] leaves out.
const TRIMMED_SHARE: f64 = 0.05;

/// The RMS of the same changes without the few pixels that change most, over the mean of the reference.
fn trimmed(frames: &[Vec<f64>], reference: &[Vec<Vec<f64>>; 2]) -> f64 {
    let pixels = frames.first().map_or(0, |frame| frame.len() / 3);
    let square = |pixel: usize| -> f64 {
        let numbers = || 3 * pixel..3 * pixel + 3;
        let pairs = 1..frames.len();
        pairs
            .flat_map(|frame| numbers().map(move |at| (frame, at)))
            .map(|(frame, at)| product(frames, Some(reference), frame, at))
            .sum()
    };
    let mut squares: Vec<f64> = (0..pixels).map(square).collect();
    squares.sort_by(f64::total_cmp);
    squares.truncate(pixels - (TRIMMED_SHARE * pixels as f64) as usize);
    let count = (3 * squares.len() * frames.len().saturating_sub(1)).max(1);
    let mean_square = squares.iter().sum::<f64>() / count as f64;
    let root = if mean_square < 0.0 { 0.0 } else { mean_square.sqrt() };
    root / (0.5 * (mean(&reference[0]) + mean(&reference[1])))
}

/// The product of what the reference's two halves leave unexplained of one number's change since the frame before.
fn product(
    frames: &[Vec<f64>],
    reference: Option<&[Vec<Vec<f64>>; 2]>,
    frame: usize,
    at: usize,
) -> f64 {
    let change = |frames: &[Vec<f64>]| frames[frame][at] - frames[frame - 1][at];
    let left = |half: usize| change(frames) - reference.map_or(0.0, |halves| change(&halves[half]));
    left(0) * left(1)
}

/// The RMS of changes from frame to frame that the reference's own do not explain, over all pairs and of the worst one,
/// over the mean of the reference; without one of the frames themselves. With the reference's two halves it is the root
/// of the mean product of the differences to both: unbiased before the root, 0 where noise makes it negative; that of
/// the worst pair, a maximum, is biased upwards.
fn changes(frames: &[Vec<f64>], reference: Option<&[Vec<Vec<f64>>; 2]>) -> (f64, f64) {
    let scale = reference
        .map_or_else(|| mean(frames), |halves| 0.5 * (mean(&halves[0]) + mean(&halves[1])));
    let squares: Vec<f64> = (1..frames.len())
        .map(|frame| {
            let count = frames[frame].len();
            let sum: f64 = (0..count).map(|at| product(frames, reference, frame, at)).sum();
            sum / count.max(1) as f64
        })
        .collect();
    let all = squares.iter().sum::<f64>() / squares.len().max(1) as f64;
    // Not by `max`, which takes 0 for what is not a number.
    let root = |square: f64| if square < 0.0 { 0.0 } else { square.sqrt() / scale };
    let worst = |one: f64, other: f64| if one > other || one.is_nan() { one } else { other };
    (root(all), root(squares.iter().copied().fold(0.0, worst)))
}

#[cfg(test)]
mod tests {
    use sglow_shaders::{Lobes, SpecularPower};

    use super::*;

    #[test]
    fn only_equal_densities_are_shared() {
        let base = Settings::default();
        let lights = Settings { lights: 7, camera_lights: 7, ..base.clone() };
        assert!(shares(&base, &lights));
        let albedo = Settings { specular_power: SpecularPower::Albedo, ..base.clone() };
        assert!(!shares(&base, &albedo));
        let tree = Settings { space: Space::Tree, ..base.clone() };
        assert!(!shares(&base, &tree) && !shares(&tree, &base) && shares(&tree, &tree));
        let diffuse = |settings: &Settings| Settings { lobes: Lobes::Diffuse, ..settings.clone() };
        assert!(shares(&diffuse(&base), &diffuse(&albedo)));
        let bidirectional =
            |settings: &Settings| Settings { density: Density::Bidirectional, ..settings.clone() };
        assert!(!shares(&bidirectional(&base), &bidirectional(&lights)));
    }

    #[test]
    fn flicker_is_what_the_reference_does_not_do() {
        let reference = [vec![1.0, 1.0], vec![2.0, 1.0], vec![3.0, 1.0]];
        let halves = [reference.to_vec(), reference.to_vec()];
        // A constant error does not flicker.
        let offset: Vec<_> = reference.iter().map(|one| vec![one[0] + 0.5, one[1]]).collect();
        assert_eq!(changes(&offset, Some(&halves)), (0.0, 0.0));
        assert!(error(&offset, &reference) > 0.1);
        // What stands still while the reference moves does.
        let still = vec![vec![1.0, 1.0]; 3];
        let (flicker, worst) = changes(&still, Some(&halves));
        assert!((flicker - 0.5f64.sqrt() / 1.5).abs() < 1e-12 && (worst - flicker).abs() < 1e-12);
        assert_eq!(changes(&still, None).0, 0.0);
        assert!(changes(&reference, None).0 > 0.0);
        let broken = vec![vec![1.0, f64::NAN]; 3];
        let (flicker, worst) = changes(&broken, Some(&halves));
        assert!(flicker.is_nan() && worst.is_nan());
        // Noise of the halves is no flicker; of the whole reference it would be.
        let mut random = Random::new(1);
        let mut noisy = || -> Vec<Vec<f64>> {
            let frame = |_| (0..4000).map(|_| 1.0 + 0.1 * random.uniform()).collect();
            (0..5).map(frame).collect()
        };
        let [one, other] = [noisy(), noisy()];
        let steady = vec![vec![1.0; 4000]; 5];
        let (free, _) = changes(&steady, Some(&[one.clone(), other]));
        let (noise, _) = changes(&steady, Some(&[one.clone(), one]));
        assert!(free < 0.2 * noise && noise > 0.03, "{free} {noise}");
    }

    #[test]
    fn few_pixels_are_left_out() {
        let steady = vec![vec![1.0; 60]; 3];
        let halves = [steady.clone(), steady.clone()];
        let with = |pixels: usize| {
            let mut frames = steady.clone();
            frames[1][..3 * pixels].fill(2.0);
            trimmed(&frames, &halves)
        };
        assert_eq!(with(1), 0.0);
        assert!((with(2) - (1.0f64 / 19.0).sqrt()).abs() < 1e-12, "{}", with(2));
    }

    #[test]
    fn lights_move_by_as_much_as_they_should() {
        let light = Light {
            name: "test".to_owned(),
            kind: LightKind::Directional,
            position: [0.0; 3],
            direction: [0.6, -0.8, 0.0],
            intensity: [1.0; 3],
            range: None,
            map_share: 1.0,
        };
        let turned = Vec3::from(moved(&light, 3.0, 0.1).direction);
        assert!((turned.x - 0.6 * 0.1f32.cos()).abs() < 1e-6 && turned.is_normalized());
        let spot = Light { kind: LightKind::Spot { inner: 0.1, outer: 0.2 }, ..light };
        let there = Vec3::from(moved(&spot, 3.0, 0.1).position);
        assert!((there.length() - 0.3).abs() < 1e-6 && there.y == 0.0);
        let down = Light { direction: [0.0, -1.0, 0.0], ..spot };
        assert_eq!(moved(&down, 3.0, 0.1).position, [0.3, 0.0, 0.0]);
    }

    #[test]
    fn pixels_are_chosen_once_each_and_show_a_surface() {
        let position = (0..100).map(|at| [0.0, 0.0, 0.0, if at % 4 == 0 { -1.0 } else { 0.0 }]);
        let surfaces = Surfaces {
            position: position.collect(),
            normal: vec![[0.0; 4]; 100],
            base_color: vec![[0.0; 4]; 100],
        };
        for count in [0, 10, 75, 1000] {
            let pixels = some_pixels(&surfaces, count);
            assert_eq!(pixels.len(), count.min(75));
            assert!(pixels.windows(2).all(|pair| pair[0] < pair[1]));
            assert!(pixels.iter().all(|pixel| pixel % 4 != 0));
        }
        assert_eq!(of_pixels(&surfaces, &[3, 5]).position.len(), 2);
    }
}
