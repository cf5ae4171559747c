//! What maps of virtual lights bring to a picture, and what each of their parameters does: pictures with visibility and
//! without, compared with paths. `docs/numerics.md` shows them.

use sglow_oracle::estimate::Estimate;
use sglow_oracle::surface::SceneError;
use sglow_renderer::device::Gpu;
use sglow_renderer::frame::{Frame, FrameError, Renderer};
use sglow_renderer::reference;
use sglow_results::light_maps::{OnScene, PATHS};
use sglow_results::picture_error::{Display, Pair, PictureError, Radiance, compare};
use sglow_results::progress::Progress;
use sglow_runtime::package::Package;
use sglow_runtime::settings::Settings;
use sglow_scene::Scene;
use sglow_shaders::Visibility;
use thiserror::Error;

/// Errors of comparing pictures with paths.
#[derive(Debug, Error)]
pub enum LightMapsError {
    /// The scene does not render.
    #[error(transparent)]
    Frame(#[from] FrameError),
    /// Its triangles cannot be traced.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// A scene cannot be loaded.
    #[error(transparent)]
    Load(#[from] sglow_scene::SceneError),
}

/// The built-in scenes with occluders that are measured.
pub const SCENES: [&str; 5] = ["cornell", "columns", "cornell-glossy", "caustic", "atrium"];
/// The settings that the parameters are varied from: small pictures without visibility, kernels of a quarter of their share
/// of the map.
#[must_use]
pub fn base() -> Settings {
    Settings { size: [48, 27], size_factor: 0.25, ..Settings::default() }
}

/// A scene with its reference of paths.
pub struct Case {
    scene: Scene,
    base: Settings,
    /// Indirect light of both halves.
    halves: [Radiance; 2],
    /// Pixels that show a surface.
    present: Vec<usize>,
    /// Direct and emitted radiance.
    fixed: Radiance,
}

fn sum(one: &Radiance, other: &Radiance) -> Radiance {
    let both = one.iter().zip(other);
    both.map(|(one, other)| core::array::from_fn(|at| one[at] + other[at])).collect()
}

/// Some layers of a frame together.
fn layers(layers: &[Option<&Vec<[f32; 4]>>], pixels: usize) -> Radiance {
    layers.iter().flatten().fold(vec![[0.0; 3]; pixels], |found, layer| {
        sum(&found, &layer.iter().map(|&[r, g, b, _]| [r, g, b]).collect())
    })
}

/// The indirect light of a frame.
pub(crate) fn indirect(frame: &Frame) -> Radiance {
    let parts = [frame.indirect_diffuse.as_ref(), frame.indirect_specular.as_ref()];
    layers(&parts, frame.direct.len())
}

impl Case {
    /// Draws the reference of a scene, with `paths` for each pixel.
    ///
    /// # Errors
    /// [`LightMapsError`] when the scene does not render or cannot be traced.
    pub fn new(
        gpu: &Gpu,
        package: &Package,
        scene: Scene,
        base: Settings,
        paths: u32,
    ) -> Result<Self, LightMapsError> {
        let renderer = Renderer::new(gpu, package, &scene, &base, 0)?;
        renderer.render()?;
        let frame = renderer.read()?;
        let (light, eye) = (renderer.light(), renderer.eye());
        let settings = renderer.indirect().settings();
        let surfaces = &frame.gbuffer;
        let go_on = |_, _| true;
        let estimates =
            reference::path_halves(light, settings, &scene, surfaces, eye, paths, 2016, go_on)?;
        // Nothing comes back of paths that are interrupted, and these are not.
        let estimates: Vec<[Estimate; 2]> = estimates.unwrap_or_default();
        let pixels = surfaces.position.len();
        #[expect(clippy::cast_possible_truncation, reason = "pictures are f32")]
        let halves = [0, 1].map(|half: usize| {
            let light = estimates.iter().map(|both| both[half].mean.total().to_array());
            light.map(|pixel| pixel.map(|value| value as f32)).collect()
        });
        let present = (0..pixels).filter(|&at| surfaces.position[at][3] >= 0.0).collect();
        let fixed = layers(&[Some(&frame.direct), frame.emission.as_ref()], pixels);
        drop(renderer);
        Ok(Self { scene, base, halves, present, fixed })
    }

    /// The error of the picture with a change of the settings, against paths.
    ///
    /// # Errors
    /// [`FrameError`] when it does not render.
    pub fn error(
        &self,
        gpu: &Gpu,
        package: &Package,
        change: impl FnOnce(&mut Settings),
    ) -> Result<PictureError, FrameError> {
        let mut settings = self.base.clone();
        change(&mut settings);
        let renderer = Renderer::new(gpu, package, &self.scene, &settings, 0)?;
        renderer.render()?;
        let frame: Frame = renderer.read()?;
        let picture = indirect(&frame);
        let whole = self.halves.each_ref().map(|half| sum(&self.fixed, half));
        Ok(compare(&Pair {
            size: settings.size,
            present: Some(&self.present),
            picture: &picture,
            halves: self.halves.each_ref(),
            whole: &sum(&self.fixed, &picture),
            whole_halves: whole.each_ref(),
            display: Display::Automatic,
        }))
    }
}

/// One setting of the maps, by what `--set` takes.
#[derive(Clone, Debug)]
pub struct Choice {
    /// Its name.
    pub name: String,
    /// Whether it is the default of all parameters.
    pub default: bool,
    change: Settings,
}

/// Near distances that are measured beside the default's.
const NEAR_SCALES: [f32; 5] = [0.0, 1.0, 2.0, 4.0, 8.0];
/// Factors on the bias that are measured beside 1.
const BIAS_SCALES: [f32; 2] = [0.5, 2.0];
/// Texels on a side of a light's map that are measured beside the default's.
const TILES: [u32; 2] = [32, 128];

/// No maps; rasterised maps with each parameter varied; imperfect maps with each near distance.
#[must_use]
pub fn choices() -> Vec<Choice> {
    let base = base();
    let mut all = vec![Choice { name: "no maps".to_owned(), default: false, change: base.clone() }];
    let mut add = |name: String, default: bool, change: Settings| {
        all.push(Choice { name, default, change });
    };
    for visibility in [Visibility::ShadowMap, Visibility::Imperfect] {
        let with = Settings { visibility, ..base.clone() };
        let mut near_scales = NEAR_SCALES.to_vec();
        near_scales.push(base.near_scale);
        near_scales.sort_by(f32::total_cmp);
        near_scales.dedup();
        for near_scale in near_scales {
            let default = near_scale == base.near_scale;
            let name = format!("`visibility={visibility},near_scale={near_scale}`");
            add(name, default, Settings { near_scale, ..with.clone() });
        }
        if visibility == Visibility::Imperfect {
            continue;
        }
        for bias_scale in BIAS_SCALES {
            let name = format!("`visibility={visibility},bias_scale={bias_scale}`");
            add(name, false, Settings { bias_scale, ..with.clone() });
        }
        for light_tile in TILES {
            let name = format!("`visibility={visibility},tile={light_tile}`");
            add(name, false, Settings { tile: light_tile, ..with.clone() });
        }
    }
    all
}

/// Measures every choice on one scene.
///
/// # Errors
/// [`LightMapsError`] when the scene does not render or cannot be traced.
pub fn measure(gpu: &Gpu, package: &Package, scene: Scene) -> Result<Vec<OnScene>, LightMapsError> {
    let case = Case::new(gpu, package, scene, base(), PATHS)?;
    let mut all = Vec::new();
    for Choice { name, default, change } in choices() {
        let error = case.error(gpu, package, |settings| *settings = change)?;
        all.push(OnScene { name, default, error });
    }
    Ok(all)
}

/// Measures every choice on all of [`SCENES`].
///
/// # Errors
/// [`LightMapsError`] when a scene does not render or cannot be traced.
pub fn all(
    gpu: &Gpu,
    package: &Package,
    progress: &dyn Progress,
) -> Result<Vec<(&'static str, Vec<OnScene>)>, LightMapsError> {
    progress.start("maps of lights", SCENES.len());
    let mut all = Vec::new();
    for name in SCENES {
        all.push((name, measure(gpu, package, Scene::load(name)?)?));
        progress.done(all.len());
    }
    progress.end();
    Ok(all)
}
