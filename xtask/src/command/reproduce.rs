//! `reproduce`: the tables and figures of the papers, ours beside theirs.

use std::path::PathBuf;

use clap::Args;
use image::RgbImage;
use sglow_measure::rivals::flicker::{Contender, flicker};
use sglow_measure::rivals::method;
use sglow_measure::rivals::stages::{code, sampling_ratios, stages};
use sglow_measure::rivals::survey::{Kernels, survey};
use sglow_oracle::fis::stress::Stress;
use sglow_renderer::device::Gpu;
use sglow_renderer::frame::Renderer;
use sglow_renderer::mips;
use sglow_renderer::stages::Stages as _;
use sglow_report::failure::{Failure, Result};
use sglow_report::json::Report;
use sglow_report::page::reproduce as page;
use sglow_report::picture::density::Density as DensityImage;
use sglow_report::picture::kernels::Square;
use sglow_report::picture::{compare, kernels, png, tone};
use sglow_report::{terminal, write};
use sglow_results::picture_error::PictureError;
use sglow_results::reproduction::{
    DOES_NOT_SHOW, Figure, Findings, MipRow, Shown, Surveyed, TimeTable, checks, requested,
};
use sglow_results::rivals::flicker::Walk;
use sglow_results::rivals::method::{Method, SIZE_FACTORS};
use sglow_runtime::package::Package;
use sglow_runtime::settings::Settings;
use sglow_shader_gen::matrix::Facts;
use sglow_shaders::{Density, Texel, Visibility};

use crate::command::render::{self, package};
use crate::shot::{self, Numbers, Shot};
use crate::{progress, say};

/// What `--help` shows below the options.
pub(crate) const EXAMPLES: &str = "\
Examples:
  cargo xtask reproduce --out out/reproduce
  cargo xtask reproduce --scene chair.gltf --size 160x90 --samples 128 --out out/chair

Without --scene: Tables 1 to 3 and Figs. 1, 5, 6, 7 and 8 of Tokuyoshi 2016 on the built-in scenes, beside the paper's
own numbers. All forms are those of the preset tokuyoshi2016 (--preset takes another). With --scene: the same methods on those scenes. Everything also stands in reproduce.json. Build with
--release first; a whole run takes about ten minutes on two cores.";

/// Options of `reproduce`.
#[derive(Debug, Args)]
pub(crate) struct Arguments {
    /// Scenes to show the methods on instead: built-in names or files
    #[arg(long, value_name = "FILE|NAME")]
    scene: Vec<String>,
    /// Pixels of the pictures
    #[arg(long, value_name = "WxH", default_value = "240x136", value_parser = shot::size)]
    size: [u32; 2],
    /// Pixels of the camera's map whose stages are timed; the paper's are the default
    #[arg(long, value_name = "WxH", default_value = "1920x1088", value_parser = shot::size)]
    timed_size: [u32; 2],
    /// Paths per pixel of the reference, half of them in each of two independent halves
    #[arg(long, value_name = "N", default_value_t = 256, value_parser = clap::value_parser!(u32).range(4..))]
    samples: u32,
    /// Frames of the moving light
    #[arg(long, value_name = "N", default_value_t = 17, value_parser = clap::value_parser!(u32).range(2..))]
    frames: u32,
    /// Virtual lights of the camera
    #[arg(long, value_name = "N", default_value_t = 2048)]
    camera_lights: u32,
    /// The folder to write: index.html, reproduce.json, pictures
    #[arg(long, value_name = "DIR", default_value = "out/reproduce")]
    out: PathBuf,
    #[command(flatten)]
    numbers: Numbers,
}

/// Runs of everything that is timed, after one that compiles.
const RUNS: usize = 5;
/// Pixels with a sum over all texels as reference.
const PIXELS: usize = 1500;
/// Frames before the one that counts, for chains that move from frame to frame.
const WARM_UP: usize = 16;

/// The preset whose forms are the papers' own.
pub(crate) const PRINTED: &str = "tokuyoshi2016";

/// Reproduces.
///
/// # Errors
///
/// When a scene or the device does not allow it, or a promise is not kept.
pub(crate) fn run(arguments: &Arguments) -> Result {
    let package = package(None, &arguments.numbers.over)?;
    let gpu = shot::gpu(&arguments.numbers)?;
    std::fs::create_dir_all(&arguments.out)
        .map_err(|error| Failure::new(format!("{}: {error}", arguments.out.display())))?;
    let work = Work { arguments, package: &package, gpu: &gpu };
    let mut found = Findings::default();
    if arguments.scene.is_empty() {
        work.built_in(&mut found)?;
    } else {
        for scene in &arguments.scene {
            work.one_scene(scene, &mut found)?;
        }
    }
    let mut report = Report::new();
    report.adapter.clone_from(&gpu.adapter.name);
    report.driver.clone_from(&gpu.adapter.driver);
    checks(&found).into_iter().for_each(|check| report.check(check));
    report.detail("asked", &found.asked)?;
    report.detail("times", &found.times)?;
    report.detail("code", &found.code)?;
    report.detail("sampling_over_previous", &found.sampling)?;
    report.detail("mips", &found.mips)?;
    report.detail("surveys", &found.surveys)?;
    report.detail("flicker", &found.flickers)?;
    report.detail("figures", &found.figures)?;
    report.detail("does_not_show", DOES_NOT_SHOW)?;
    say::line(terminal::reproduce::show(&found));
    say::line(format!("\n{}", report.table()));
    write::text(&arguments.out.join("index.html"), &page::page(&found, &report))?;
    let path = arguments.out.join("reproduce.json");
    report.write(&path)?;
    say::line(format!("{}\n{}", path.display(), arguments.out.join("index.html").display()));
    report.verdict()
}

/// The sizes of kernels beside K = 1.
fn other_sizes() -> impl Iterator<Item = f32> {
    SIZE_FACTORS.into_iter().filter(|&factor| factor != 1.0)
}

struct Work<'a> {
    arguments: &'a Arguments,
    package: &'a Package,
    gpu: &'a Gpu,
}

impl Work<'_> {
    /// Width and height of the light's map; the paper's if nothing else is asked for.
    fn rsm(&self) -> u32 {
        self.arguments.numbers.rsm.unwrap_or(512)
    }

    /// The numbers, by default those of the paper's configuration.
    fn numbers(&self) -> Numbers {
        let numbers = self.arguments.numbers.clone();
        let preset = numbers.preset.clone().or_else(|| Some(PRINTED.to_owned()));
        Numbers { preset, ..numbers }
    }

    /// A scene with the bidirectional density of the paper, or another.
    fn shot(&self, scene: &str, size: [u32; 2], density: Density) -> Result<Shot> {
        let mut shot = Shot::new(scene, &[], size, &self.numbers())?;
        // What is compared are the methods that make lights; where maps hide them, a figure says so itself.
        shot.settings.visibility = Visibility::None;
        shot.settings.map = self.rsm();
        shot.settings.density = density;
        shot.settings.camera_lights = self.arguments.camera_lights;
        Ok(shot)
    }

    /// A renderer that has drawn its maps and made its density.
    fn prepared(&self, shot: &Shot) -> Result<Renderer<'_>> {
        let bar = progress::spinner(format!(
            "{}: maps and the {} density",
            shot.scene.name, shot.settings.density
        ));
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
        bar.finish_and_clear();
        Ok(renderer)
    }

    fn built_in(&self, found: &mut Findings) -> Result {
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
        found.asked = requested(found);
        Ok(())
    }

    fn one_scene(&self, scene: &str, found: &mut Findings) -> Result {
        self.time_table("Stages", scene, Density::Bidirectional, found)?;
        self.survey(scene, Density::Bidirectional, true, found)?;
        let methods = [Method::Previous, Method::Bracketed, Method::Image, Method::World];
        let about = "Pictures by each method; imperfect shadow maps.";
        self.figure(scene, about, scene, &methods.map(|method| (method, 1.0)), found)?;
        self.flicker(scene, found)
    }

    fn mips(&self, found: &mut Findings) -> Result {
        let size = self.rsm();
        for (name, texel, layers) in [
            ("moments, rgba32float, 5 layers", Texel::Rgba32float, 5),
            ("density, r32float", Texel::R32float, 1),
        ] {
            let times = mips::measure(self.gpu, self.package, texel, size, layers)?;
            let milliseconds = |time: std::time::Duration| time.as_secs_f64() * 1e3;
            found.mips.push(MipRow {
                name,
                mips: milliseconds(times.mips),
                copy: milliseconds(times.copy),
                ratio: times.ratio,
            });
        }
        Ok(())
    }

    fn code(&self, found: &mut Findings) -> Result {
        for method in
            [Method::Previous, Method::Modified, Method::Bracketed, Method::Image, Method::World]
        {
            found.code.push(code(self.package, method, &Settings::default())?);
        }
        Ok(())
    }

    fn time_table(
        &self,
        name: &'static str,
        scene: &str,
        density: Density,
        found: &mut Findings,
    ) -> Result {
        let shot = self.shot(scene, self.arguments.timed_size, density)?;
        let renderer = self.prepared(&shot)?;
        let methods =
            [Method::Previous, Method::Modified, Method::Bracketed, Method::Image, Method::World];
        let bar = progress::spinner(format!("{name}: {RUNS} runs in turns"));
        let measured = stages(self.gpu, self.package, &renderer, &methods, RUNS)?;
        bar.finish_and_clear();
        if found.dispatches.is_empty() {
            for one in &measured {
                let light = one.stages.iter().filter(|stage| !stage.camera);
                let all: usize = light.clone().map(|stage| stage.dispatches).sum();
                let mips: usize = light
                    .filter(|stage| stage.name.starts_with("mip"))
                    .map(|stage| stage.dispatches)
                    .sum();
                found.dispatches.push((one.method, all - mips, mips));
            }
        }
        found.times.push(TimeTable {
            name,
            scene: shot.scene.name,
            density: density.name(),
            methods: measured,
        });
        Ok(())
    }

    fn sampling(&self, found: &mut Findings) -> Result {
        let size = self.rsm();
        let base = Settings {
            map: size,
            ..self.numbers().request([1, 1]).settings(
                &self.arguments.numbers.over.library()?,
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
            let bar = progress::spinner(format!("sampling pass on {name}"));
            let ratios = sampling_ratios(self.gpu, self.package, &base, &texels, &texels)?;
            bar.finish_and_clear();
            found.sampling.push((name, ratios));
        }
        Ok(())
    }

    fn survey(&self, scene: &str, density: Density, draw: bool, found: &mut Findings) -> Result {
        let shot = self.shot(scene, self.arguments.size, density)?;
        let renderer = self.prepared(&shot)?;
        let bar = progress::spinner(format!("{scene}, {density}: every method on one frame"));
        let methods: Vec<_> = Method::ALL
            .map(|method| (method, 1.0))
            .into_iter()
            .chain(other_sizes().map(|factor| (Method::Bracketed, factor)))
            .collect();
        let (surveyed, drawn) =
            survey(self.gpu, self.package, &renderer, &methods, PIXELS, WARM_UP)?;
        bar.finish_and_clear();
        if draw {
            self.kernels(&shot, &drawn, found)?;
        }
        if surveyed.dark {
            say::line(format!("{scene}: the light reaches nothing; its indirect light is black"));
        }
        let name = density.name();
        found.surveys.push(Surveyed { scene: scene.to_owned(), density: name, found: surveyed });
        Ok(())
    }

    /// Fig. 1: kernels over the density.
    fn kernels(&self, shot: &Shot, drawn: &Kernels, found: &mut Findings) -> Result {
        let side = drawn.side;
        let density = DensityImage {
            name: shot.scene.name.clone(),
            size: [side; 2],
            texels: drawn.density.clone(),
        };
        let mut pictures = Vec::new();
        let names = ["previous", "modified"];
        let mut sheets = Vec::new();
        for (name, kernels) in names.into_iter().zip(&drawn.kernels) {
            let squares: Vec<Square> = kernels
                .iter()
                .map(|kernel| Square {
                    centre: kernel.centre.map(|part| f64::from(part) * side as f64),
                    side: f64::from(kernel.level).exp2(),
                })
                .collect();
            let picture = kernels::draw(&density, &squares)?;
            pictures.push(self.picture(
                &format!("kernels-{}-{name}", shot.scene.name),
                name,
                &picture,
                None,
            )?);
            sheets.push(picture);
        }
        let sheet = compare::side_by_side(&sheets.iter().collect::<Vec<_>>());
        png::write(&self.arguments.out.join("kernels.png"), &sheet)?;
        found.figures.insert(
            0,
            Figure {
                name: "Fig. 1".to_owned(),
                about: format!(
                    "{} kernels over the bidirectional density of {}: centres red, squares of 4^level texels orange.",
                    drawn.kernels[0].len(),
                    shot.scene.name
                ),
                standard_error: None,
                pictures,
            },
        );
        Ok(())
    }

    fn picture(
        &self,
        stem: &str,
        name: &str,
        picture: &RgbImage,
        error: Option<PictureError>,
    ) -> Result<Shown> {
        let plain: String = stem
            .chars()
            .map(|c| if c.is_ascii_alphanumeric() || c == '-' { c } else { '-' })
            .collect();
        let file = format!("{plain}.png");
        png::write(&self.arguments.out.join(&file), picture)?;
        Ok(Shown { name: name.to_owned(), file, error })
    }

    fn figure(
        &self,
        name: &str,
        about: &str,
        scene: &str,
        methods: &[(Method, f32)],
        found: &mut Findings,
    ) -> Result {
        let mut shot = self.shot(scene, self.arguments.size, Density::Bidirectional)?;
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
        let mut truth: Option<(render::Truth, tone::Exposure)> = None;
        for &(method, size_factor) in methods {
            let mut settings = method::settings(method, &shot.settings);
            settings.size_factor = size_factor;
            let label = if methods.iter().all(|one| one.0 == method) {
                format!("K = {size_factor}")
            } else {
                method.name().to_owned()
            };
            let bar = progress::spinner(format!("{name}: {label}"));
            let renderer = Renderer::new(self.gpu, self.package, &shot.scene, &settings, 0)?;
            let frames = if method == Method::Metropolis { WARM_UP } else { 0 };
            for _ in 0..=frames.min(2) {
                renderer.render()?;
            }
            let frame = renderer.read()?;
            bar.finish_and_clear();
            if truth.is_none() {
                let found = if caustic {
                    let frame = render::brute_force(&renderer, &frame)?;
                    render::Truth { frame, halves: None, standard_error: None }
                } else {
                    render::paths(&renderer, &shot.scene, &frame, self.arguments.samples)?
                };
                let picture = render::picture(&found.frame)?;
                let exposure = tone::Exposure::automatic(picture.radiance()?.pixels());
                truth = Some((found, exposure));
            }
            let Some((reference, exposure)) = &truth else { continue };
            let ours = render::picture(&frame)?;
            let error = render::error(&frame, reference)?;
            let shown = tone::radiance(&ours.radiance()?, *exposure);
            figure.standard_error = reference
                .standard_error
                .filter(|_| error.reference_mean > 0.0)
                .map(|noise| noise.pixel / error.reference_mean);
            figure.pictures.push(self.picture(
                &format!("{stem}-{label}"),
                &label,
                &shown,
                Some(error),
            )?);
        }
        if let Some((reference, exposure)) = &truth {
            let picture = render::picture(&reference.frame)?;
            let shown = tone::radiance(&picture.radiance()?, *exposure);
            let label = if caustic {
                "reference, facets of the map".to_owned()
            } else {
                format!("reference, {} paths per pixel", self.arguments.samples)
            };
            figure.pictures.push(self.picture(
                &format!("{stem}-reference"),
                &label,
                &shown,
                None,
            )?);
        }
        found.figures.push(figure);
        Ok(())
    }

    fn flicker(&self, scene: &str, found: &mut Findings) -> Result {
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
        let frames = self.arguments.frames as usize;
        let bar = progress::bar(format!("{scene}: frames of a moving light"), frames);
        let walk = Walk { frames, ..Walk::default() };
        let flickers = flicker(self.gpu, self.package, &shot.scene, &contenders, walk, |done| {
            bar.set_position(done as u64);
        })?;
        bar.finish_and_clear();
        found.flickers.push((scene.to_owned(), flickers));
        Ok(())
    }
}
