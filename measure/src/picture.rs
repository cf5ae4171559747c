//! Frames as pictures, their references, and how far they are from them.

use sglow_oracle::estimate::Estimate;
use sglow_oracle::shade::Reflected;
use sglow_oracle::surface::SceneError;
use sglow_renderer::frame::{Frame, FrameError, Pixels, Renderer};
use sglow_renderer::reference;
use sglow_results::picture::{Image, Layer, LayersError, Picture};
use sglow_results::picture_error::{Display, Pair, PictureError, Radiance, compare};
use sglow_results::progress::Progress;
use sglow_scene::Scene;
use thiserror::Error;

/// The seed of paths: the same line gives the same picture.
pub const SEED: u64 = 2016;

/// Errors of references and of comparisons with them.
#[derive(Debug, Error)]
pub enum CompareError {
    /// The frame does not render.
    #[error(transparent)]
    Frame(#[from] FrameError),
    /// Its triangles cannot be traced.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// It does not become a picture.
    #[error(transparent)]
    Layers(#[from] LayersError),
    /// The reference was interrupted.
    #[error("the reference was not finished")]
    Unfinished,
    /// There is nothing to compare.
    #[error("the camera sees no surface, so there is nothing to compare")]
    NoSurface,
}

/// The same frame with its indirect light by brute force.
///
/// # Errors
///
/// When the map cannot be read back.
pub fn brute_force(
    renderer: &Renderer<'_>,
    frame: &Frame,
    progress: &dyn Progress,
) -> Result<Frame, CompareError> {
    let settings = renderer.indirect().settings();
    let rsm = renderer.read_rsm()?;
    let pixels = frame.gbuffer.position.len();
    progress.start("facets of the map", pixels);
    let reflected = reference::unshadowed(
        renderer.light(),
        settings,
        &rsm,
        &frame.gbuffer,
        renderer.eye(),
        |done, _| {
            progress.done(done);
            true
        },
    )
    .ok_or(CompareError::Unfinished)?;
    progress.end();
    Ok(with_indirect(frame, &reflected))
}

/// A reference of a frame.
pub struct FrameReference {
    /// The frame with the reference's indirect light; all else is ours.
    pub frame: Frame,
    /// The same of two independent halves, if it has noise.
    pub halves: Option<[Frame; 2]>,
    /// How uncertain it is, if it is.
    pub standard_error: Option<Noise>,
}

/// How far the noise of paths may be off, in the unit of the picture.
#[derive(Clone, Copy, Debug)]
pub struct Noise {
    /// Root mean square over the picture's numbers.
    pub pixel: f64,
    /// Of the mean over the whole picture.
    pub mean: f64,
    /// Paths of each pixel, of both halves together.
    pub samples: u32,
}

/// How far a frame's indirect light is from a reference of it, by every metric.
///
/// # Errors
///
/// When the camera sees no surface.
pub fn error(frame: &Frame, reference: &FrameReference) -> Result<PictureError, CompareError> {
    let halves = match &reference.halves {
        Some([one, other]) => [one, other],
        None => [&reference.frame; 2],
    };
    let pixels = |image: Image| -> Radiance { image.pixels().to_vec() };
    let both = |frame: &Frame| -> Result<[Radiance; 2], CompareError> {
        let picture = picture(frame)?;
        Ok([pixels(indirect(&picture)?), pixels(picture.radiance()?)])
    };
    let [light, whole] = both(frame)?;
    let [one, other] = [both(halves[0])?, both(halves[1])?];
    let position = &frame.gbuffer.position;
    let present: Vec<usize> = (0..position.len()).filter(|&at| position[at][3] >= 0.0).collect();
    if present.is_empty() {
        return Err(CompareError::NoSurface);
    }
    Ok(compare(&Pair {
        size: frame.size,
        present: Some(&present),
        picture: &light,
        halves: [&one[0], &other[0]],
        whole: &whole,
        whole_halves: [&one[1], &other[1]],
        display: Display::Automatic,
    }))
}

/// The same frame with its indirect light by paths.
///
/// # Errors
///
/// When the scene cannot be traced.
pub fn paths(
    renderer: &Renderer<'_>,
    scene: &Scene,
    frame: &Frame,
    samples: u32,
    progress: &dyn Progress,
) -> Result<FrameReference, CompareError> {
    progress.start("paths of one bounce", frame.gbuffer.position.len());
    let settings = renderer.indirect().settings();
    let (light, gbuffer, eye) = (renderer.light(), &frame.gbuffer, renderer.eye());
    let report = |done, _| {
        progress.done(done);
        true
    };
    let halves =
        reference::path_halves(light, settings, scene, gbuffer, eye, samples, SEED, report)?
            .ok_or(CompareError::Unfinished)?;
    progress.end();
    let estimates: Vec<Estimate> = halves.iter().map(Estimate::mean_of).collect();
    let squares: f64 = estimates.iter().map(|one| one.standard_error.length_squared()).sum();
    let numbers = 3.0 * estimates.len() as f64;
    let noise =
        Noise { pixel: (squares / numbers).sqrt(), mean: squares.sqrt() / numbers, samples };
    let lit = |estimates: &mut dyn Iterator<Item = &Estimate>| {
        let reflected: Vec<_> = estimates.map(|one| one.mean).collect();
        with_indirect(frame, &reflected)
    };
    Ok(FrameReference {
        frame: lit(&mut estimates.iter()),
        halves: Some([0, 1].map(|half: usize| lit(&mut halves.iter().map(|both| &both[half])))),
        standard_error: Some(noise),
    })
}

/// A frame with other indirect light, of the reflections that it has.
fn with_indirect(frame: &Frame, reflected: &[Reflected]) -> Frame {
    let diffuse = reference::pixels(reflected, |pixel| pixel.diffuse);
    let specular = reference::pixels(reflected, |pixel| pixel.specular);
    Frame {
        indirect_diffuse: frame.indirect_diffuse.is_some().then_some(diffuse),
        indirect_specular: frame.indirect_specular.is_some().then_some(specular),
        ..frame.clone()
    }
}

/// A frame as layers.
///
/// # Errors
///
/// When it has no pixels.
pub fn picture(frame: &Frame) -> Result<Picture, LayersError> {
    let [width, height] = frame.size.map(|side| side as usize);
    let image = |pixels: &Pixels| {
        let pixels = pixels.iter().map(|&[r, g, b, _]| [r, g, b]).collect();
        Image::new(width, height, pixels)
    };
    let mut layers = vec![
        (Layer::Direct, image(&frame.direct)?),
        (Layer::Albedo, image(&frame.gbuffer.base_color)?),
        (Layer::Normal, image(&frame.gbuffer.normal)?),
        (Layer::Position, image(&frame.gbuffer.position)?),
    ];
    let optional = [
        (Layer::IndirectDiffuse, &frame.indirect_diffuse),
        (Layer::IndirectSpecular, &frame.indirect_specular),
        (Layer::Emission, &frame.emission),
    ];
    // What was left out is black: a reader of the file finds every layer.
    let black = vec![[0.0; 4]; frame.direct.len()];
    for (layer, pixels) in optional {
        layers.push((layer, image(pixels.as_ref().unwrap_or(&black))?));
    }
    Picture::new(layers)
}

/// The indirect light of a picture.
///
/// # Errors
///
/// When a layer is missing.
pub fn indirect(picture: &Picture) -> Result<Image, LayersError> {
    let diffuse = picture.layer(Layer::IndirectDiffuse)?;
    let specular = picture.layer(Layer::IndirectSpecular)?;
    let sum = diffuse.pixels().iter().zip(specular.pixels());
    let pixels = sum.map(|(a, b)| std::array::from_fn(|channel| a[channel] + b[channel])).collect();
    Image::new(diffuse.width(), diffuse.height(), pixels)
}
