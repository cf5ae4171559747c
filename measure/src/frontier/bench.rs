//! Configurations on a device: what makes the lights of several, their shadow maps and what reflects them, each made once.

use std::time::Duration;

use serde::{Deserialize, Serialize};
use sglow_oracle::vsgl::Vsgl;
use sglow_renderer::frame::occluders;
use sglow_renderer::stages::Stages as _;
use sglow_renderer::timing::{Clock, Timer};
use sglow_renderer::{readback, reference};
use sglow_results::frontier::document::{Pass, Radiance};
use sglow_results::time::Time;
use sglow_runtime::indirect::{Indirect, IndirectError, PARTS};
use sglow_runtime::occluders::Occluders;
use sglow_runtime::settings::Settings;
use sglow_shaders::Visibility as VisibilityAxis;

use super::subject::{FrontierError, Subject};

/// Timed runs of each pass, after one that compiles.
pub const RUNS: usize = 5;

/// The times of passes by name, in the order in which they ran.
pub(super) type PassTimes = Vec<(String, Duration)>;

/// What comes of encoding.
type Encoded = Result<(), IndirectError>;

/// Passes by name with the times of each run.
#[derive(Clone, Debug, Default)]
pub(super) struct Runs {
    passes: Vec<(String, Vec<Duration>)>,
    pub(super) clock: Option<Clock>,
}

impl Runs {
    /// Adds a run: passes of the same name count as one.
    pub(super) fn add(&mut self, times: PassTimes) {
        let mut sums = PassTimes::new();
        for (name, time) in times {
            match sums.iter_mut().find(|sum| sum.0 == name) {
                Some(sum) => sum.1 += time,
                None => sums.push((name, time)),
            }
        }
        for (name, time) in sums {
            match self.passes.iter_mut().find(|pass| pass.0 == name) {
                Some(pass) => pass.1.push(time),
                None => self.passes.push((name, vec![time])),
            }
        }
    }

    /// Each pass.
    pub(super) fn passes(&self) -> Vec<Pass> {
        let pass = |(name, times): &(String, Vec<Duration>)| Pass {
            name: name.clone(),
            time: Time::of(times.clone()),
        };
        self.passes.iter().map(pass).collect()
    }

    /// All passes of each run together.
    pub(super) fn whole(&self) -> Time {
        let runs = self.passes.iter().map(|pass| pass.1.len()).max().unwrap_or(0);
        let sum = |run: usize| self.passes.iter().filter_map(|pass| pass.1.get(run)).sum();
        Time::of((0..runs).map(sum).collect())
    }
}

/// Passes that were timed, as they are kept.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(super) struct Timed {
    pub(super) passes: Vec<Pass>,
    /// How times were taken.
    pub(super) clock: String,
}

impl Timed {
    pub(super) fn of(runs: &Runs) -> Self {
        Self { passes: runs.passes(), clock: runs.clock.unwrap_or(Clock::Wall).to_string() }
    }
}

impl Subject<'_> {
    fn lights_alone(&self, settings: &Settings) -> Result<Indirect, FrontierError> {
        Ok(Indirect::of_parts(
            self.gpu.source(self.package),
            settings,
            &["lights"],
            &Occluders::default(),
        )?)
    }

    /// Whole indirect light for the light that shines here.
    pub(super) fn indirect(&self, settings: &Settings) -> Result<Indirect, FrontierError> {
        let occluders = occluders(self.gpu, self.scene, settings)?;
        Ok(Indirect::of_parts(
            self.gpu.source(self.package),
            &self.here(settings)?,
            &PARTS,
            &occluders,
        )?)
    }

    /// Level 0 of moments and density, once if `runs` is 0 or timed after a warm-up.
    pub(super) fn maps(
        &self,
        settings: &Settings,
        runs: usize,
    ) -> Result<(Indirect, Runs), FrontierError> {
        let inputs = self.drawn()?.renderer.inputs();
        let maps = self.lights_alone(&self.here(&self.depends.of_maps(settings))?)?;
        let timed = self.timed(runs, |encoder, timer| {
            let mut timer = Some(timer);
            maps.encode_camera(encoder, &inputs, timer.as_deref_mut())?;
            maps.encode_moments(encoder, &inputs, timer.as_deref_mut())?;
            maps.encode_density(encoder, &inputs, timer)
        })?;
        Ok((maps, timed))
    }

    /// Lights from maps that are there: mips, kernels or clusters.
    pub(super) fn lights(
        &self,
        settings: &Settings,
        maps: &Indirect,
        runs: usize,
    ) -> Result<(Indirect, Runs), FrontierError> {
        let inputs = self.drawn()?.renderer.inputs();
        let lights = self.lights_alone(&self.here(&self.depends.of_lights(settings))?)?;
        self.untimed(|encoder| {
            lights.encode_moments(encoder, &inputs, None)?;
            lights.encode_density_of(encoder, maps);
            Ok(())
        })?;
        let timed = self.timed(runs, |encoder, timer| {
            lights.encode_mips(encoder, Some(&mut *timer))?;
            lights.encode_sample(encoder, &inputs, Some(timer))
        })?;
        Ok((lights, timed))
    }

    /// The shadow maps of lights, if the settings have any.
    pub(super) fn visibility(
        &self,
        settings: &Settings,
    ) -> Result<Option<Indirect>, FrontierError> {
        if settings.visibility == VisibilityAxis::None {
            return Ok(None);
        }
        let occluders = occluders(self.gpu, self.scene, settings)?;
        Ok(Some(Indirect::of_parts(
            self.gpu.source(self.package),
            settings,
            &["visibility"],
            &occluders,
        )?))
    }

    /// What reflects lights.
    pub(super) fn shading(&self, settings: &Settings) -> Result<Indirect, FrontierError> {
        Ok(Indirect::of_parts(
            self.gpu.source(self.package),
            settings,
            &["shading"],
            &Occluders::default(),
        )?)
    }

    /// Draws the shadow maps of lights.
    pub(super) fn shadow(
        &self,
        visibility: &Indirect,
        lights: &Indirect,
    ) -> Result<(), FrontierError> {
        let (light, vsgls) = (self.drawn()?.renderer.light(), held(lights)?);
        self.untimed(|encoder| visibility.encode_light_maps(encoder, light, Some(&vsgls), None))
    }

    /// Draws the maps of lights once: the times of its passes.
    pub(super) fn time_visibility(
        &self,
        lights: &Indirect,
        visibility: &Indirect,
    ) -> Result<PassTimes, FrontierError> {
        let (light, vsgls) = (self.drawn()?.renderer.light(), held(lights)?);
        let (_, times) = self.once(|encoder, timer| {
            visibility.encode_light_maps(encoder, light, Some(&vsgls), Some(timer))
        })?;
        Ok(times)
    }

    /// Reflects lights whose maps are drawn once, timed; `maps` are the times of drawing them, which count with it.
    pub(super) fn time_shading(
        &self,
        lights: &Indirect,
        visibility: Option<&Indirect>,
        shading: &Indirect,
        maps: &[(String, Duration)],
        runs: &mut Runs,
    ) -> Result<(), FrontierError> {
        let (clock, times) = self.once_shaded(lights, visibility, shading)?;
        runs.clock = Some(clock);
        runs.add([maps, &times].concat());
        Ok(())
    }

    /// Reflects unshadowed lights, timed after a warm-up.
    pub(super) fn time_reflecting(
        &self,
        lights: &Indirect,
        shading: &Indirect,
        runs: usize,
    ) -> Result<Runs, FrontierError> {
        let mut found = Runs::default();
        // The first run compiles.
        for run in 0..=runs {
            let (clock, times) = self.once_shaded(lights, None, shading)?;
            found.clock = Some(clock);
            if run > 0 {
                found.add(times);
            }
        }
        Ok(found)
    }

    /// The indirect light of lights whose shadow maps are drawn.
    pub(super) fn reflect(
        &self,
        lights: &Indirect,
        visibility: Option<&Indirect>,
        shading: &Indirect,
    ) -> Result<Radiance, FrontierError> {
        self.once_shaded(lights, visibility, shading)?;
        let [width, height] = lights.settings().size;
        let mut sum = vec![[0.0; 3]; width as usize * height as usize];
        for texture in [shading.diffuse(), shading.specular()].into_iter().flatten() {
            for (sum, texel) in sum.iter_mut().zip(readback::texture(self.gpu, &texture, 0)?) {
                for (sum, value) in sum.iter_mut().zip(texel) {
                    *sum += value;
                }
            }
        }
        Ok(sum)
    }

    /// The lights, as the oracle takes them.
    pub(super) fn read_lights(&self, lights: &Indirect) -> Result<Vec<Vsgl<f64>>, FrontierError> {
        Ok(reference::lights(self.gpu, lights)?)
    }

    fn once_shaded(
        &self,
        lights: &Indirect,
        visibility: Option<&Indirect>,
        shading: &Indirect,
    ) -> Result<(Clock, PassTimes), FrontierError> {
        let seen = self.drawn()?.renderer.inputs().into();
        let maps = visibility.and_then(|visibility| visibility.light_maps());
        let maps = maps.map(|maps| maps.create_view(&Default::default()));
        let lights = Some((lights, maps.as_ref()));
        self.once(|encoder, timer| shading.encode_shade(encoder, &seen, lights, Some(timer)))
    }

    /// Settings for the light that shines here.
    fn here(&self, settings: &Settings) -> Result<Settings, FrontierError> {
        let light = self.drawn()?.renderer.indirect().settings().light;
        Ok(Settings { light, ..settings.clone() })
    }

    fn untimed(
        &self,
        encode: impl Fn(&mut wgpu::CommandEncoder) -> Encoded,
    ) -> Result<(), FrontierError> {
        let mut encoder = self.gpu.device.create_command_encoder(&Default::default());
        encode(&mut encoder)?;
        self.gpu.queue.submit([encoder.finish()]);
        Ok(self.gpu.finish()?)
    }

    /// Once to compile, then `runs` times.
    fn timed(
        &self,
        runs: usize,
        encode: impl Fn(&mut wgpu::CommandEncoder, &mut Timer<'_>) -> Encoded,
    ) -> Result<Runs, FrontierError> {
        let mut found = Runs::default();
        for run in 0..=runs {
            self.one_run(&mut found, run > 0, &encode)?;
        }
        Ok(found)
    }

    /// Once; what is not counted is the clock's name alone.
    fn one_run(
        &self,
        runs: &mut Runs,
        counts: bool,
        encode: impl Fn(&mut wgpu::CommandEncoder, &mut Timer<'_>) -> Encoded,
    ) -> Result<(), FrontierError> {
        let (clock, times) = self.once(encode)?;
        runs.clock = Some(clock);
        if counts {
            runs.add(times);
        }
        Ok(())
    }

    /// The clock and the passes' times of one submission.
    fn once(
        &self,
        encode: impl FnOnce(&mut wgpu::CommandEncoder, &mut Timer<'_>) -> Encoded,
    ) -> Result<(Clock, PassTimes), FrontierError> {
        let mut timer = Timer::new(self.gpu);
        let clock = timer.clock();
        let mut encoder = self.gpu.device.create_command_encoder(&Default::default());
        encode(&mut encoder, &mut timer)?;
        self.gpu.queue.submit([encoder.finish()]);
        let times = timer.finish()?;
        self.gpu.finish()?;
        Ok((clock, times))
    }
}

/// The buffer of lights.
fn held(lights: &Indirect) -> Result<wgpu::Buffer, IndirectError> {
    lights.vsgls().ok_or_else(|| IndirectError::Description("the frame has no lights".to_owned()))
}

/// The error of a frame that draws its lights by no density.
pub(super) fn no_density() -> FrontierError {
    IndirectError::Description("the frame has no density".to_owned()).into()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn passes_of_one_name_are_one_and_runs_stay_apart() {
        let mut runs = Runs::default();
        for passes in
            [[("mip", 1), ("sample", 5), ("mip", 2)], [("mip", 1), ("sample", 9), ("mip", 1)]]
        {
            runs.add(passes.map(|(name, ms)| (name.to_owned(), Duration::from_millis(ms))).into());
        }
        let passes = runs.passes();
        assert_eq!(passes.len(), 2);
        assert_eq!((passes[0].time.minimum, passes[0].time.maximum), (2.0, 3.0));
        assert_eq!((runs.whole().minimum, runs.whole().maximum), (8.0, 11.0));
        assert_eq!(Runs::default().whole(), Time::default());
    }
}
