//! The tables and figures of [Tokuyoshi 2016], measured.

use sglow_oracle::fis::stress::Stress;
use sglow_renderer::device::Gpu;
use sglow_renderer::frame::{Frame, Renderer};
use sglow_renderer::mips;
use sglow_renderer::request::derivation::Request;
use sglow_renderer::request::shot::{Shot, load};
use sglow_renderer::stages::Stages as _;
use sglow_results::display::Exposure;
use sglow_results::kernels::Square;
use sglow_results::picture_error::PictureError;
use sglow_results::progress::Progress;
use sglow_results::reproduction::{
    Drawing, Drawn, Figure, Findings, MipRow, Shown, Surveyed, TimeTable, requested,
};
use sglow_results::rivals::flicker::Walk;
use sglow_results::rivals::method::{Method, SIZE_FACTORS};
use sglow_runtime::package::Package;
use sglow_runtime::settings::Settings;
use sglow_shader_gen::library::Library;
use sglow_shader_gen::matrix::Facts;
use sglow_shaders::{Density, SglowKernel, Visibility};
use thiserror::Error;

use crate::picture::{CompareError, FrameReference, brute_force, error, paths, picture};
use crate::rivals::flicker::{Contender, flicker};
use crate::rivals::method;
use crate::rivals::stages::{code, sampling_ratios, stages};
use crate::rivals::survey::{Kernels, survey};

/// Runs of everything that is timed, after one that compiles.
const RUNS: usize = 5;
/// Pixels with a sum over all texels as reference.
const PIXELS: usize = 1500;
/// Frames before the one that counts, for chains that move from frame to frame.
const WARM_UP: usize = 16;

/// Errors of a reproduction.
#[derive(Debug, Error)]
pub enum ReproduceError {
    /// A scene or a setting is not possible.
    #[error(transparent)]
    Request(#[from] sglow_renderer::request::RequestError),
    /// A frame does not render.
    #[error(transparent)]
    Frame(#[from] sglow_renderer::frame::FrameError),
    /// A stage cannot be encoded.
    #[error(transparent)]
    Indirect(#[from] sglow_runtime::indirect::IndirectError),
    /// A variant is missing.
    #[error(transparent)]
    Package(#[from] sglow_runtime::package::PackageError),
    /// The device fails.
    #[error(transparent)]
    Device(#[from] sglow_renderer::device::DeviceError),
    /// Mips cannot be made.
    #[error(transparent)]
    Mips(#[from] mips::MipsError),
    /// The flicker cannot be measured.
    #[error(transparent)]
    Flicker(#[from] crate::rivals::flicker::FlickerError),
    /// A picture has no reference.
    #[error(transparent)]
    Compare(#[from] CompareError),
    /// A frame does not become a picture.
    #[error(transparent)]
    Layers(#[from] sglow_results::picture::LayersError),
}

/// What is seen of a frame.
fn radiance(frame: &Frame, exposure: Exposure) -> Result<Drawn, ReproduceError> {
    let pixels = picture(frame)?.radiance()?.pixels().to_vec();
    Ok(Drawn::Radiance { size: frame.size, pixels, exposure })
}

/// Keeps a picture under a plain file name.
fn keep(
    stem: &str,
    name: &str,
    drawn: Drawn,
    error: Option<PictureError>,
    found: &mut Found,
) -> Shown {
    let plain = |c: char| if c.is_ascii_alphanumeric() || c == '-' { c } else { '-' };
    let file = format!("{}.png", stem.chars().map(plain).collect::<String>());
    found.drawings.push(Drawing { file: file.clone(), drawn });
    Shown { name: name.to_owned(), file, error }
}

/// The sizes of kernels beside K = 1.
fn other_sizes() -> impl Iterator<Item = f32> {
    SIZE_FACTORS.into_iter().filter(|&factor| factor != 1.0)
}

/// What is reproduced, and how large.
#[derive(Clone, Debug)]
pub struct Options {
    /// Pixels of the pictures.
    pub size: [u32; 2],
    /// Pixels of the camera's map whose stages are timed.
    pub timed_size: [u32; 2],
    /// Paths per pixel of the reference, half of them in each of two independent halves.
    pub samples: u32,
    /// Frames of the moving light.
    pub frames: usize,
    /// Virtual lights of the camera.
    pub camera_lights: u32,
    /// Width and height of the light's map.
    pub map: u32,
    /// The light that is used, counted from 0; the one with the most power if there is no number.
    pub light: Option<usize>,
    /// How scenes of files are read.
    pub reading: sglow_scene::Options,
    /// The preset and the numbers that are requested beside it.
    pub request: Request,
}

/// What reproduces.
pub struct Work<'a> {
    /// What, and how large.
    pub options: &'a Options,
    /// The library with the preset.
    pub library: &'a Library,
    /// The shaders.
    pub package: &'a Package,
    /// The device.
    pub gpu: &'a Gpu,
    /// What is reported while it lasts.
    pub progress: &'a dyn Progress,
}

/// What was found, with its pictures.
#[derive(Debug, Default)]
pub struct Found {
    /// The numbers.
    pub findings: Findings,
    /// The pictures of figures.
    pub drawings: Vec<Drawing>,
}

impl Work<'_> {
    /// A scene with the bidirectional density of the paper, or another.
    fn shot(&self, scene: &str, size: [u32; 2], density: Density) -> Result<Shot, ReproduceError> {
        let (scene, notes) = load(scene, self.options.light, &self.options.reading)?;
        let request = Request { size, ..self.options.request.clone() };
        let mut shot = Shot::new(self.library, scene, &[], &request)?;
        notes.iter().chain(&shot.notes).for_each(|note| self.progress.note(note));
        // What is compared are the methods that make lights; where maps hide them, a figure says so itself.
        shot.settings.visibility = Visibility::None;
        shot.settings.map = self.options.map;
        shot.settings.density = density;
        shot.settings.camera_lights = self.options.camera_lights;
        Ok(shot)
    }

    /// A renderer that has drawn its maps and made its density.
    fn prepared(&self, shot: &Shot) -> Result<Renderer<'_>, ReproduceError> {
        self.progress.start(
            &format!("{}: maps and the {} density", shot.scene.name, shot.settings.density),
            0,
        );
        let renderer = Renderer::new(self.gpu, self.package, &shot.scene, &shot.settings, 0)?;
        renderer.draw_maps()?;
        let inputs = renderer.inputs();
        let mut encoder = self.gpu.device.create_command_encoder(&Default::default());
        let indirect = renderer.indirect();
        indirect.encode_camera(&mut encoder, &inputs, None)?;
        indirect.encode_moments(&mut encoder, &inputs, None)?;
        indirect.encode_density(&mut encoder, &inputs, None)?;
        self.gpu.queue.submit([encoder.finish()]);
        self.gpu.finish()?;
        self.progress.end();
        Ok(renderer)
    }

    /// Tables 1 to 3 and Figs. 1, 5, 6, 7 and 8 on the built-in scenes.
    ///
    /// # Errors
    ///
    /// When a scene or the device does not allow it.
    pub fn built_in(&self, found: &mut Found) -> Result<(), ReproduceError> {
        // The fastest first; what takes long last.
        self.mips(found)?;
        self.code(found)?;
        self.time_table("Table 1", "atrium:75k", Density::Bidirectional, found)?;
        self.time_table("Table 2", "atrium:75k", Density::Power, found)?;
        self.sampling(found)?;
        self.survey("atrium:75k", Density::Power, false, found)?;
        self.survey("atrium:75k", Density::Bidirectional, true, found)?;
        self.survey("atrium:262k", Density::Bidirectional, false, found)?;
        self.survey("atrium:331k", Density::Bidirectional, false, found)?;
        let four = [Method::Previous, Method::Bracketed, Method::Image, Method::World];
        self.figure(
            "Fig. 5, upper row",
            "Pictures by each method, 331k triangles; imperfect shadow maps.",
            "atrium:331k",
            &four.map(|method| (method, 1.0)),
            found,
        )?;
        self.figure(
            "Fig. 5, lower row",
            "Pictures by each method, 75k triangles; imperfect shadow maps.",
            "atrium:75k",
            &four.map(|method| (method, 1.0)),
            found,
        )?;
        self.figure(
            "Fig. 6",
            "The size of kernels: K = 1, 4, 16 as in the paper, and smaller; what it does to flicker stands in the table of flicker.",
            "atrium:262k",
            &[0.125, 0.25, 0.5, 1.0, 4.0, 16.0].map(|factor| (Method::Bracketed, factor)),
            found,
        )?;
        self.figure(
            "Fig. 7",
            "Light occluded by columns: what clusters in the world keep apart.",
            "columns",
            &four.map(|method| (method, 1.0)),
            found,
        )?;
        self.figure(
            "Fig. 8",
            "A caustic, with the same density: stratified kernels, and those of Markov chains. Without visibility on \
             either side, and against the facets of the light's map.",
            "caustic",
            &[(Method::Bracketed, 1.0), (Method::Metropolis, 1.0)],
            found,
        )?;
        self.survey("caustic", Density::Bidirectional, false, found)?;
        self.flicker("atrium:75k", found)?;
        found.findings.requested = requested(&found.findings);
        Ok(())
    }

    /// The methods on one scene.
    ///
    /// # Errors
    ///
    /// When the scene or the device does not allow it.
    pub fn one_scene(&self, scene: &str, found: &mut Found) -> Result<(), ReproduceError> {
        self.time_table("Stages", scene, Density::Bidirectional, found)?;
        self.survey(scene, Density::Bidirectional, true, found)?;
        let methods = [Method::Previous, Method::Bracketed, Method::Image, Method::World];
        let about = "Pictures by each method; imperfect shadow maps.";
        self.figure(scene, about, scene, &methods.map(|method| (method, 1.0)), found)?;
        self.flicker(scene, found)
    }

    fn mips(&self, found: &mut Found) -> Result<(), ReproduceError> {
        let size = self.options.map;
        for (name, pyramid) in [
            ("moments, rgba32float, 5 layers", mips::Pyramid::Moments),
            ("density, r32float", mips::Pyramid::Density),
        ] {
            let times = mips::measure(self.gpu, self.package, pyramid, size)?;
            let milliseconds = |time: std::time::Duration| time.as_secs_f64() * 1e3;
            found.findings.mips.push(MipRow {
                name,
                mips: milliseconds(times.mips),
                copy: milliseconds(times.copy),
                ratio: times.ratio,
            });
        }
        Ok(())
    }

    fn code(&self, found: &mut Found) -> Result<(), ReproduceError> {
        for method in
            [Method::Previous, Method::Modified, Method::Bracketed, Method::Image, Method::World]
        {
            found.findings.code.push(code(self.package, method, &Settings::default())?);
        }
        Ok(())
    }

    fn time_table(
        &self,
        name: &'static str,
        scene: &str,
        density: Density,
        found: &mut Found,
    ) -> Result<(), ReproduceError> {
        let shot = self.shot(scene, self.options.timed_size, density)?;
        let renderer = self.prepared(&shot)?;
        let methods =
            [Method::Previous, Method::Modified, Method::Bracketed, Method::Image, Method::World];
        self.progress.start(&format!("{name}: {RUNS} runs in turns"), 0);
        let measured = stages(self.gpu, self.package, &renderer, &methods, RUNS)?;
        self.progress.end();
        if found.findings.dispatches.is_empty() {
            for one in &measured {
                let light = one.stages.iter().filter(|stage| !stage.camera);
                let all: usize = light.clone().map(|stage| stage.dispatches).sum();
                let mips: usize = light
                    .filter(|stage| stage.name.starts_with("mip"))
                    .map(|stage| stage.dispatches)
                    .sum();
                found.findings.dispatches.push((one.method, all - mips, mips));
            }
        }
        found.findings.times.push(TimeTable {
            name,
            scene: shot.scene.name,
            density: density.name(),
            methods: measured,
        });
        Ok(())
    }

    fn sampling(&self, found: &mut Found) -> Result<(), ReproduceError> {
        let size = self.options.map;
        let base = Settings {
            map: size,
            ..Request { size: [1, 1], ..self.options.request.clone() }.settings(
                self.library,
                &Facts::new(),
                &[],
            )?
        };
        let mut densities: Vec<(String, Vec<f32>)> = Stress::ALL
            .into_iter()
            .filter(|(name, _)| ["smooth", "noise-2", "ring"].contains(name))
            .map(|(name, stress)| (name.to_owned(), stress.texels(size as usize, 1)))
            .collect();
        let stress = densities.len();
        for (scene, density) in [
            ("atrium:75k", Density::Power),
            ("atrium:75k", Density::Bidirectional),
            ("atrium:262k", Density::Bidirectional),
            ("atrium:331k", Density::Bidirectional),
        ] {
            // The sampling pass alone is given texels, which have to be a power-of-two square.
            if !size.is_power_of_two() {
                break;
            }
            let shot = self.shot(scene, [320, 180], density)?;
            let renderer = self.prepared(&shot)?;
            let Some(texture) = renderer.indirect().density() else { continue };
            let texels = sglow_renderer::readback::texture(self.gpu, &texture, 0)?;
            densities.push((
                format!("{scene}, {density}"),
                texels.iter().map(|texel| texel[0]).collect(),
            ));
        }
        densities.rotate_left(stress);
        for (name, texels) in densities {
            self.progress.start(&format!("sampling pass on {name}"), 0);
            let ratios = sampling_ratios(self.gpu, self.package, &base, &texels, &texels)?;
            self.progress.end();
            found.findings.sampling.push((name, ratios));
        }
        Ok(())
    }

    fn survey(
        &self,
        scene: &str,
        density: Density,
        draw: bool,
        found: &mut Found,
    ) -> Result<(), ReproduceError> {
        let shot = self.shot(scene, self.options.size, density)?;
        let renderer = self.prepared(&shot)?;
        self.progress.start(&format!("{scene}, {density}: every method on one frame"), 0);
        let methods: Vec<_> = Method::ALL
            .map(|method| (method, 1.0))
            .into_iter()
            .chain(other_sizes().map(|factor| (Method::Bracketed, factor)))
            .collect();
        let (surveyed, drawn) =
            survey(self.gpu, self.package, &renderer, &methods, PIXELS, WARM_UP)?;
        self.progress.end();
        if draw {
            self.kernels(&shot, &drawn, found);
        }
        if surveyed.dark {
            self.progress
                .note(&format!("{scene}: the light reaches nothing; its indirect light is black"));
        }
        let name = density.name();
        found.findings.surveys.push(Surveyed {
            scene: scene.to_owned(),
            density: name,
            found: surveyed,
        });
        Ok(())
    }

    /// Fig. 1: kernels over the density.
    fn kernels(&self, shot: &Shot, drawn: &Kernels, found: &mut Found) {
        let side = drawn.side;
        let mut pictures = Vec::new();
        for (name, kernels) in ["previous", "modified"].into_iter().zip(&drawn.kernels) {
            let square = |kernel: &SglowKernel| Square {
                centre: kernel.centre.map(|part| f64::from(part) * side as f64),
                side: f64::from(kernel.level).exp2(),
            };
            let what = Drawn::Kernels {
                side,
                density: drawn.density.clone(),
                squares: kernels.iter().map(square).collect(),
            };
            let stem = format!("kernels-{}-{name}", shot.scene.name);
            pictures.push(keep(&stem, name, what, None, found));
        }
        let about = format!(
            "{} kernels over the bidirectional density of {}: centres red, squares of 4^level texels orange.",
            drawn.kernels[0].len(),
            shot.scene.name
        );
        let name = "Fig. 1".to_owned();
        found.findings.figures.insert(0, Figure { name, about, standard_error: None, pictures });
    }

    fn figure(
        &self,
        name: &str,
        about: &str,
        scene: &str,
        methods: &[(Method, f32)],
        found: &mut Found,
    ) -> Result<(), ReproduceError> {
        let mut shot = self.shot(scene, self.options.size, Density::Bidirectional)?;
        // From the camera, paths do not find what a small mirror sends somewhere.
        let caustic = shot.scene.name == "caustic";
        if !caustic {
            shot.settings.visibility = Visibility::Imperfect;
        }
        let mut figure = Figure {
            name: name.to_owned(),
            about: about.to_owned(),
            standard_error: None,
            pictures: Vec::new(),
        };
        let stem = name.to_lowercase().replace("fig. ", "figure-").replace(", ", "-");
        let mut reference: Option<(FrameReference, Exposure)> = None;
        for &(method, size_factor) in methods {
            let mut settings = method::settings(method, &shot.settings);
            settings.size_factor = size_factor;
            let label = if methods.iter().all(|one| one.0 == method) {
                format!("K = {size_factor}")
            } else {
                method.name().to_owned()
            };
            self.progress.start(&format!("{name}: {label}"), 0);
            let renderer = Renderer::new(self.gpu, self.package, &shot.scene, &settings, 0)?;
            let frames = if method == Method::Metropolis { WARM_UP } else { 0 };
            for _ in 0..=frames.min(2) {
                renderer.render()?;
            }
            let frame = renderer.read()?;
            self.progress.end();
            if reference.is_none() {
                let samples = self.options.samples;
                let new = if caustic {
                    let frame = brute_force(&renderer, &frame, self.progress)?;
                    FrameReference { frame, halves: None, standard_error: None }
                } else {
                    paths(&renderer, &shot.scene, &frame, samples, self.progress)?
                };
                let exposure = Exposure::automatic(picture(&new.frame)?.radiance()?.pixels());
                reference = Some((new, exposure));
            }
            let Some((reference, exposure)) = &reference else { continue };
            let error = error(&frame, reference)?;
            let shown = radiance(&frame, *exposure)?;
            figure.standard_error = reference
                .standard_error
                .filter(|_| error.reference_mean > 0.0)
                .map(|noise| noise.pixel / error.reference_mean);
            let stem = format!("{stem}-{label}");
            figure.pictures.push(keep(&stem, &label, shown, Some(error), found));
        }
        if let Some((reference, exposure)) = &reference {
            let shown = radiance(&reference.frame, *exposure)?;
            let label = if caustic {
                "reference, facets of the map".to_owned()
            } else {
                format!("reference, {} paths per pixel", self.options.samples)
            };
            let stem = format!("{stem}-reference");
            figure.pictures.push(keep(&stem, &label, shown, None, found));
        }
        found.findings.figures.push(figure);
        Ok(())
    }

    fn flicker(&self, scene: &str, found: &mut Found) -> Result<(), ReproduceError> {
        let shot = self.shot(scene, [160, 90], Density::Bidirectional)?;
        let mut contenders: Vec<Contender> = Method::ALL
            .into_iter()
            .filter(|method| *method != Method::Modified)
            .map(|method| Contender {
                name: format!("{}, K = 1", method.name()),
                settings: method::settings(method, &shot.settings),
            })
            .collect();
        for factor in other_sizes() {
            let mut settings = method::settings(Method::Bracketed, &shot.settings);
            settings.size_factor = factor;
            contenders.push(Contender {
                name: format!("{}, K = {factor}", Method::Bracketed.name()),
                settings,
            });
        }
        let frames = self.options.frames;
        self.progress.start(&format!("{scene}: frames of a moving light"), frames);
        let walk = Walk { frames, ..Walk::default() };
        let flickers = flicker(self.gpu, self.package, &shot.scene, &contenders, walk, |done| {
            self.progress.done(done);
        })?;
        self.progress.end();
        found.findings.flickers.push((scene.to_owned(), flickers));
        Ok(())
    }
}
