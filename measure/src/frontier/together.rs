//! What is measured of a few configurations together: whole frames in turns, and flicker. Among others all is measured
//! again.

use sglow_renderer::device::Gpu;
use sglow_renderer::frame::Renderer;
use sglow_renderer::timing::Timer;
use sglow_results::rivals::flicker::Walk;
use sglow_results::time::Time;
use sglow_runtime::indirect::Indirect;
use sglow_runtime::settings::Settings;

use super::bench::RUNS;
use super::subject::{Drawn, FrontierError, Subject};
use crate::cache::{Cache, Key};
use crate::rivals::flicker::{self, Contender};

/// How the light moves while flicker is followed.
const WALK: Walk = Walk { frames: 5, pixels: 400, samples: 128, step: 0.002 };

/// Configurations by their names.
pub(super) type Named<'a> = [(String, &'a Settings)];

/// Times of whole frames of indirect light of each configuration, in turns.
pub(super) fn whole_frames(
    subject: &Subject<'_>,
    named: &Named<'_>,
    cache: &Cache,
) -> Result<Vec<Time>, FrontierError> {
    cache.get(&key(subject, "frontier in turns", named)?, || in_turns(subject, named))
}

/// How much each configuration flickers while the light moves.
pub(super) fn flicker(
    subject: &Subject<'_>,
    named: &Named<'_>,
    cache: &Cache,
) -> Result<Vec<f64>, FrontierError> {
    let key = key(subject, "flicker", named)?.on("walk", format!("{WALK:?}"));
    cache.get(&key, || {
        let contender = |(name, settings): &(String, &Settings)| Contender {
            name: name.clone(),
            settings: (*settings).clone(),
        };
        let contenders: Vec<Contender> = named.iter().map(contender).collect();
        let Subject { gpu, package, scene, .. } = *subject;
        let found = flicker::flicker(gpu, package, scene, &contenders, WALK, |_| {})?;
        Ok(found.contenders.into_iter().map(|one| one.flicker).collect())
    })
}

fn key(subject: &Subject<'_>, what: &str, named: &Named<'_>) -> Result<Key, FrontierError> {
    let names: Vec<&str> = named.iter().map(|one| one.0.as_str()).collect();
    let mut key = subject.scene_key(&format!("{what} of {}", names.join(" ")))?;
    for (name, settings) in named {
        key = key.on(name, format!("{:?}", subject.key(what, name, settings)?));
    }
    Ok(key)
}

fn in_turns(subject: &Subject<'_>, named: &Named<'_>) -> Result<Vec<Time>, FrontierError> {
    let Drawn { renderer, .. } = subject.drawn()?;
    let gpu = subject.gpu;
    let made = named.iter().map(|(_, settings)| subject.indirect(settings));
    let made = made.collect::<Result<Vec<_>, _>>()?;
    let mut runs = vec![Vec::new(); named.len()];
    for run in 0..=RUNS {
        for (indirect, runs) in made.iter().zip(&mut runs) {
            let time = one_frame(renderer, indirect, gpu)?;
            // The first run compiles.
            if run > 0 {
                runs.push(time);
            }
        }
    }
    Ok(runs.into_iter().map(Time::of).collect())
}

/// The time of one frame of indirect light.
fn one_frame(
    renderer: &Renderer<'_>,
    indirect: &Indirect,
    gpu: &Gpu,
) -> Result<std::time::Duration, FrontierError> {
    let inputs = renderer.inputs();
    let mut timer = Timer::new(gpu);
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    indirect.encode(&mut encoder, &inputs, Some(&mut timer))?;
    gpu.queue.submit([encoder.finish()]);
    let passes = timer.finish()?;
    gpu.finish()?;
    Ok(passes.iter().map(|pass| pass.1).sum())
}
