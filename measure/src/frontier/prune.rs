//! What leaving out saves: a frame with everything against a frame with what the scene needs.

use sglow_renderer::frame::Renderer;
use sglow_renderer::plan::Storage;
use sglow_renderer::variants::Variants as _;
use sglow_results::frontier::document::{Pruned, Side};
use sglow_results::progress::Progress;
use sglow_runtime::settings::Settings;
use sglow_shaders::{Lobes, Ndf, Specular};

use super::bench::Runs;
use super::depends;
use super::subject::{FrontierError, Subject};
use crate::cache::Cache;

/// The least picture that it is measured on: what is saved of maps does not grow with the picture, what is saved of
/// pictures does.
const SIZE: [u32; 2] = [320, 180];

/// Frames of each: more than of a configuration, for a promise is made of their ratio.
const FRAMES: usize = 9;

/// The settings that offer everything.
fn everything(base: &Settings) -> Settings {
    let Settings { specular, ndf, .. } = Settings::default();
    let specular = if base.specular == Specular::None { specular } else { base.specular };
    let ndf = if base.ndf == Ndf::None { ndf } else { base.ndf };
    let assumed = Vec::new();
    Settings { complete: true, lobes: Lobes::Both, specular, ndf, assumed, ..base.clone() }
}

/// Measures both in turns; nothing where the scene needs every lobe there is.
pub(super) fn pruned(
    subject: &Subject<'_>,
    cache: &Cache,
    progress: &dyn Progress,
) -> Result<Option<Pruned>, FrontierError> {
    let area = |[width, height]: [u32; 2]| width * height;
    let size = if area(subject.base.size) < area(SIZE) { SIZE } else { subject.base.size };
    let needed = Settings { size, ..subject.base.clone() };
    let full = everything(&needed);
    if full.lobes == needed.lobes && full.shade() == needed.shade() {
        return Ok(None);
    }
    progress.start(&format!("{}: with everything, and without", subject.scene.name), 0);
    let key = subject
        .scene_key("pruned")?
        .on("full", format!("{:?}", subject.key("full", "everything", &full)?))
        .on("needed", format!("{:?}", subject.key("needed", "default", &needed)?));
    cache.get(&key, || in_turns(subject, [&full, &needed]).map(Some))
}

fn in_turns(subject: &Subject<'_>, both: [&Settings; 2]) -> Result<Pruned, FrontierError> {
    let renderer =
        |settings| Renderer::new(subject.gpu, subject.package, subject.scene, settings, 0);
    let made = [renderer(both[0])?, renderer(both[1])?];
    let mut runs = [Runs::default(), Runs::default()];
    for run in 0..=FRAMES {
        for (renderer, runs) in made.iter().zip(&mut runs) {
            let times = renderer.render()?;
            runs.clock = Some(times.clock);
            if run > 0 {
                runs.add(times.passes);
            }
        }
    }
    let [full, needed] = [made[0].read()?.radiance, made[1].read()?.radiance];
    let numbers = full.iter().flatten().zip(needed.iter().flatten());
    let differing = numbers.filter(|(one, other)| one.to_bits() != other.to_bits()).count();
    let side = |at: usize| {
        let settings = both[at];
        let plan = subject.plan(settings)?;
        let bytes = |storage| plan.bytes(storage, &["lights", "shading"]);
        let passes = runs[at].passes();
        let shade = passes.iter().find(|pass| pass.name == "shade");
        Ok::<_, FrontierError>(Side {
            shade: settings.shade().id().to_string(),
            texture_bytes: bytes(Storage::Texture),
            buffer_bytes: bytes(Storage::Buffer),
            shade_time: shade.map(|pass| pass.time).unwrap_or_default(),
            time: runs[at].whole(),
            passes,
        })
    };
    let [full_axes, needed_axes] = [subject.axes(both[0]), subject.axes(both[1])];
    let differ = full_axes.into_iter().filter(|(axis, value)| needed_axes.get(axis) != Some(value));
    let description = subject.package.description();
    let axes = differ
        .map(|(axis, _)| {
            let passes = description.map(|description| depends::labels(description, &axis));
            (axis, passes.unwrap_or_default())
        })
        .collect();
    Ok(Pruned { full: side(0)?, needed: side(1)?, size: both[0].size, differing, axes })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn everything_is_more_than_a_diffuse_scene_needs() {
        let diffuse = Settings {
            lobes: Lobes::Diffuse,
            specular: Specular::None,
            ndf: Ndf::None,
            ..Settings::default()
        };
        let full = everything(&diffuse);
        assert!(full.shade().excluded().is_none() && full.complete);
        assert_ne!(full.shade(), diffuse.shade());
        let glossy = Settings { specular: Specular::Sg, ..Settings::default() };
        assert_eq!(everything(&glossy).shade(), glossy.shade());
    }
}
