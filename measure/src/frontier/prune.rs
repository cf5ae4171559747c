//! What leaving out saves: a frame with everything against a frame with what the scene needs.

use sglow_runtime::frame::Renderer;
use sglow_runtime::settings::Settings;
use sglow_shaders::{Lobes, Ndf, Specular};

use super::document::{Pruned, Side, Time};
use super::scene::{Progress, RUNS, one_frame};
use super::subject::{FrontierError, Subject};
use crate::cache::Cache;

/// The settings that offer everything.
fn everything(base: &Settings) -> Settings {
    let Settings { specular, ndf, .. } = Settings::default();
    let specular = if base.specular == Specular::None { specular } else { base.specular };
    let ndf = if base.ndf == Ndf::None { ndf } else { base.ndf };
    Settings { complete: true, lobes: Lobes::Both, specular, ndf, ..base.clone() }
}

/// Measures both in turns; nothing where the scene needs everything.
pub(super) fn pruned(
    subject: &Subject<'_>,
    cache: &Cache,
    progress: &dyn Progress,
) -> Result<Option<Pruned>, FrontierError> {
    let base = &subject.base;
    let full = everything(base);
    if full.lobes == base.lobes && full.shade() == base.shade() {
        return Ok(None);
    }
    progress.start(&format!("{}: with everything, and without", subject.scene.name), 0);
    let key = subject
        .scene_key("pruned")
        .on("full", format!("{:?}", subject.key("full", "everything", &full)?))
        .on("needed", format!("{:?}", subject.key("needed", "default", base)?));
    cache.get(&key, || in_turns(subject, &full).map(Some))
}

fn in_turns(subject: &Subject<'_>, full: &Settings) -> Result<Pruned, FrontierError> {
    let made = [full, &subject.base]
        .map(|settings| Renderer::new(subject.gpu, subject.package, subject.scene, settings, 0));
    let [full, needed] = made;
    let made = [full?, needed?];
    let mut times: [[Vec<_>; 2]; 2] = Default::default();
    for renderer in &made {
        renderer.render()?;
    }
    for run in 0..=RUNS {
        for (renderer, [all, shade]) in made.iter().zip(&mut times) {
            let inputs = renderer.inputs();
            let passes = one_frame(renderer, renderer.indirect(), inputs.visibility, subject.gpu)?;
            if run > 0 {
                all.push(passes.iter().map(|pass| pass.1).sum());
                shade.push(passes.iter().filter(|pass| pass.0 == "shade").map(|pass| pass.1).sum());
            }
        }
    }
    let [full, needed] = [made[0].read()?.radiance, made[1].read()?.radiance];
    let numbers = full.iter().flatten().zip(needed.iter().flatten());
    let differing = numbers.filter(|(one, other)| one.to_bits() != other.to_bits()).count();
    let mut sides = made.iter().zip(times).map(|(renderer, [all, shade])| {
        let indirect = renderer.indirect();
        let buffer = |name: &str| ["vsgls", "kernels"].contains(&name);
        let bytes = indirect.bytes();
        let sum = |buffers: bool| {
            bytes.iter().filter(|(name, _)| buffer(name) == buffers).map(|one| one.1).sum()
        };
        Side {
            shade: indirect.settings().shade().id().to_string(),
            texture_bytes: sum(false),
            buffer_bytes: sum(true),
            shade_time: Time::of(shade),
            time: Time::of(all),
        }
    });
    let (Some(full), Some(needed)) = (sides.next(), sides.next()) else {
        return Err(FrontierError::NoSurface { scene: subject.scene.name.clone() });
    };
    Ok(Pruned { full, needed, size: subject.base.size, differing })
}
