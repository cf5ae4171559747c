//! Runs a configuration and keeps what every frame of it came to.

use std::collections::BTreeSet;

use sglow_graph::formula::evaluated;
use sglow_oracle::vsgl::Vsgl;
use sglow_renderer::check::Check;
use sglow_renderer::frame::{self, Frame, Pixels, Renderer, Surfaces};
use sglow_renderer::stages::Stages as _;
use sglow_renderer::{readback, reference};
use sglow_runtime::indirect::{Indirect, Inputs, PARTS};
use sglow_runtime::package::Package;
use sglow_runtime::settings::Settings;
use sglow_scene::{Light, Scene};

use super::list::Case;
use super::record::Entry;
use super::scenes;
use crate::common::{gpu, plan};
use crate::part::chains::{ChainSettings, Chains};

impl Case {
    /// The scene with its light in the first frame.
    pub(super) fn scene(&self) -> Scene {
        self.lamp.lit(self.place.scene())
    }

    pub(super) fn lights(&self, frame: u32) -> Vec<Light> {
        self.lamp.lights(self.place.scene(), frame, self.nudged)
    }

    /// The settings with the kind of the lights.
    pub(super) fn settled(&self) -> Settings {
        let lights = self.lights(0);
        let light = sglow_renderer::light::kind_of_all(&lights);
        let light_faces = sglow_renderer::light::faces(&lights);
        Settings { light, light_faces, ..self.settings.clone() }
    }

    fn own_chains(&self) -> Option<ChainSettings> {
        let start = self.chains?;
        Some(ChainSettings { start, ..ChainSettings::of(self.settings.lights) })
    }

    /// The variants that it runs.
    pub(super) fn variants(&self) -> BTreeSet<String> {
        let settings = self.settled();
        let mut variants = plan(&settings, self.place.scene()).variants;
        if let Some(ChainSettings { start, .. }) = self.own_chains() {
            variants.insert(sglow_shaders::metropolis_start::MetropolisStart { start }.id());
            variants.insert(sglow_shaders::metropolis::Metropolis.id());
        }
        if self.checks {
            let Settings { lobes, precision, .. } = settings;
            variants.insert(sglow_shaders::check::Check { lobes, precision }.id());
        }
        variants
    }

    fn own_indirect(&self, package: &Package) -> Indirect {
        let settings = self.settled();
        let occluders = frame::occluders(gpu(), self.place.scene(), &settings).unwrap();
        Indirect::of_parts(gpu().source(package), &settings, &PARTS, &occluders).unwrap()
    }

    /// What the first frame is made from: the same for many configurations, and so kept once.
    fn maps(&self) -> String {
        let Settings { size: [width, height], map: rsm_size, complete, .. } = self.settings;
        let (place, lamp) = (self.place.name(), self.lamp.name());
        let complete = if complete { ", complete" } else { "" };
        format!("maps of {place}, light {lamp}, map {rsm_size}, picture {width}x{height}{complete}")
    }

    /// Runs it. Everything that it asks its package for is what was planned.
    pub(super) fn run(&self, package: &Package) -> Vec<Entry> {
        let scene = self.scene();
        let package = package.clone();
        let (mut entries, mut made) = (Vec::new(), None);
        let mut renderer = Renderer::new(gpu(), &package, &scene, &self.settled(), 0).unwrap();
        let moving = self.eye_moves.then(|| self.own_indirect(&package));
        let mut chains = self.own_chains().map(|settings| {
            let side = renderer.indirect().density().unwrap().width();
            Chains::new(&package, &settings, side)
        });
        for number in 0..self.frames {
            renderer.move_lights(&self.lights(number)).unwrap();
            if self.restarts && number + 1 == self.frames {
                renderer.indirect().restart();
            }
            let formulas = evaluated();
            renderer.render().unwrap();
            // Formulas are evaluated and pipelines made at creation alone.
            let now = renderer.indirect().executor().made();
            assert!(made.is_none_or(|made| made == now), "{}: {made:?}, {now:?}", self.name);
            assert_eq!(evaluated(), formulas, "{}", self.name);
            made = Some(now);
            let mut recorded = Recorder { case: self, number, entries: &mut entries };
            if let Some(chains) = &mut chains {
                recorded.move_chains(chains, &renderer);
                continue;
            }
            if number == 0 {
                recorded.maps(&renderer);
            }
            match &moving {
                Some(indirect) => recorded.move_eye(indirect, &renderer),
                None => recorded.frame(&renderer),
            }
            if self.checks {
                recorded.check(&renderer, &package);
            }
        }
        // Of chains all lengths are planned.
        let (requested, mut planned) = (package.requested_variants(), self.variants());
        planned.retain(|id| requested.contains(id) || !id.starts_with("mip-"));
        assert_eq!(requested, planned, "{}", self.name);
        entries
    }
}

/// Submits what is encoded and waits for it.
fn submit(encode: impl FnOnce(&mut wgpu::CommandEncoder)) {
    let mut encoder = gpu().device.create_command_encoder(&Default::default());
    encode(&mut encoder);
    gpu().queue.submit([encoder.finish()]);
    gpu().finish().unwrap();
}

/// Takes down one frame.
struct Recorder<'a> {
    case: &'a Case,
    number: u32,
    entries: &'a mut Vec<Entry>,
}

impl Recorder<'_> {
    fn keep(&mut self, output: &'static str, bytes: &[u8], numbers: Vec<(&'static str, f64)>) {
        let Self { case, number, .. } = self;
        let entry = Entry::new(&case.name, *number, output, bytes, numbers);
        self.entries.push(entry);
    }

    fn picture(&mut self, output: &'static str, pixels: &Pixels) {
        let width = self.case.settings.size[0] as usize;
        self.keep(output, bytemuck::cast_slice(pixels), means(pixels, width));
    }

    /// The textures that the first frame is made from.
    fn maps(&mut self, renderer: &Renderer<'_>) {
        let [rsm, gbuffer] = [renderer.read_rsm().unwrap(), renderer.read_gbuffer().unwrap()];
        let Settings { size, map: rsm_size, .. } = self.case.settings;
        for (output, surfaces, width) in
            [("light map", rsm, rsm_size), ("G-buffer", gbuffer, size[0])]
        {
            let Surfaces { position, normal, base_color } = surfaces;
            let bytes =
                [&position, &normal, &base_color].map(|pixels| bytemuck::cast_slice(pixels));
            let numbers = means(&base_color, width as usize);
            self.entries.push(Entry::new(&self.case.maps(), 0, output, &bytes.concat(), numbers));
        }
    }

    /// A whole frame.
    fn frame(&mut self, renderer: &Renderer<'_>) {
        self.indirect(renderer.indirect());
        let Frame { radiance, direct, emission, .. } = renderer.read().unwrap();
        self.picture("direct", &direct);
        if let Some(emission) = emission {
            self.picture("emission", &emission);
        }
        self.picture("radiance", &radiance);
    }

    /// Indirect light of the maps of the frame for an eye that has moved on: what an engine runs.
    fn move_eye(&mut self, indirect: &Indirect, renderer: &Renderer<'_>) {
        let eye = scenes::eye(renderer.eye(), self.case.place.scene(), self.number);
        let inputs = Inputs { eye, ..renderer.inputs() };
        submit(|encoder| indirect.encode(encoder, &inputs, None).unwrap());
        self.indirect(indirect);
    }

    /// Chains of their own by the density of the frame.
    fn move_chains(&mut self, chains: &mut Chains, renderer: &Renderer<'_>) {
        chains.advance(&renderer.indirect().density().unwrap());
        self.chains(chains.buffer());
    }

    fn chains(&mut self, chains: &wgpu::Buffer) {
        let chains: Vec<[f32; 2]> = readback::buffer(gpu(), chains).unwrap();
        let mean =
            |of: fn(&[f32; 2]) -> f64| chains.iter().map(of).sum::<f64>() / chains.len() as f64;
        let numbers = vec![
            ("x", mean(|chain| f64::from(chain[0]))),
            ("y", mean(|chain| f64::from(chain[1]))),
            ("xy", mean(|chain| f64::from(chain[0]) * f64::from(chain[1]))),
        ];
        self.keep("chains", bytemuck::cast_slice(&chains), numbers);
    }

    fn indirect(&mut self, indirect: &Indirect) {
        if let Some(chains) = indirect.chains() {
            self.chains(&chains);
        }
        self.lights(indirect);
        if let Some(maps) = indirect.light_maps() {
            let atlas = readback::texture(gpu(), &maps, 0).unwrap();
            let numbers = means(&atlas, maps.width() as usize);
            let [near, left, upper] = [numbers[0], numbers[3], numbers[4]];
            self.keep("light maps", bytemuck::cast_slice(&atlas), vec![near, left, upper]);
        }
        for (output, texture) in
            [("diffuse", indirect.diffuse()), ("specular", indirect.specular())]
        {
            if let Some(texture) = texture {
                self.picture(output, &readback::texture(gpu(), &texture, 0).unwrap());
            }
        }
    }

    fn lights(&mut self, indirect: &Indirect) {
        let bytes: Vec<u8> = readback::buffer(gpu(), &indirect.vsgls().unwrap()).unwrap();
        let lights: Vec<Vsgl> = reference::lights(gpu(), indirect).unwrap();
        let power = |light: &Vsgl| light.power().luminance();
        let total: f64 = lights.iter().map(power).sum();
        // By power: lights without any are at no place.
        let mean = |of: &dyn Fn(&Vsgl) -> f64| {
            let sum = lights.iter().filter(|light| power(light) > 0.0);
            sum.fold(0.0, |sum, light| sum + power(light) * of(light))
                / total.max(f64::MIN_POSITIVE)
        };
        let numbers = vec![
            ("power", total),
            ("x", mean(&|light| light.position.x)),
            ("y", mean(&|light| light.position.y)),
            ("z", mean(&|light| light.position.z)),
            ("deviation", mean(&|light| light.variance.sqrt())),
        ];
        self.keep("lights", &bytes, numbers);
    }

    /// Lights and surfaces against the contract of the shading pass.
    fn check(&mut self, renderer: &Renderer<'_>, package: &Package) {
        let Settings { lobes, precision, lights: count, size, .. } = self.case.settings;
        let check = Check::new(&gpu().device, &gpu().queue, package, lobes, precision).unwrap();
        let lights = renderer.indirect().vsgls().unwrap();
        let surfaces = renderer.inputs().gbuffer;
        submit(|encoder| check.encode(encoder, surfaces, &lights, count, size));
        let found = check.read(gpu()).unwrap();
        assert!(found.is_empty(), "{}: {found}", self.case.name);
        let counts = [found.not_finite, found.out_of_range, found.not_unit];
        let names = ["not_finite", "out_of_range", "not_unit"];
        let numbers = names.into_iter().zip(counts.map(f64::from)).collect();
        self.keep("violations", bytemuck::cast_slice(&counts), numbers);
    }
}

/// Means over a picture: of each channel, and of all three over the left and over the upper half.
fn means(pixels: &Pixels, width: usize) -> Vec<(&'static str, f64)> {
    let height = pixels.len() / width;
    let mut sums = [0.0; 5];
    for (index, pixel) in pixels.iter().enumerate() {
        let [r, g, b, _] = pixel.map(f64::from);
        let third = (r + g + b) / 3.0;
        let left = if 2 * (index % width) < width { third } else { 0.0 };
        let upper = if 2 * (index / width) < height { third } else { 0.0 };
        for (sum, value) in sums.iter_mut().zip([r, g, b, left, upper]) {
            *sum += value;
        }
    }
    let names = ["red", "green", "blue", "left", "upper"];
    names.into_iter().zip(sums.map(|sum| sum / pixels.len() as f64)).collect()
}
