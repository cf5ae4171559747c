//! Every configuration measured: the times of its passes, and what its picture is evaluated to be.
//!
//! Configurations have most of what they do in common: maps, lights and what reflects them are timed once each.

use std::cell::OnceCell;
use std::collections::{BTreeMap, BTreeSet};

use sglow_results::frontier::document::Configuration;
use sglow_results::progress::Progress;
use sglow_runtime::indirect::PARTS;
use sglow_runtime::settings::Settings;
use sglow_shaders::{Diffuse, Lobes, Specular};

use super::bench::Timed;
use super::configuration;
use super::evaluate::{Evaluation, Evaluator};
use super::references::References;
use super::shadings::time_shadings;
use super::shared::{Lights, Shared, Step};
use super::subject::{Drawn, FrontierError, Subject};
use crate::cache::Cache;

/// What was found of every configuration.
#[derive(Default)]
pub(super) struct Measured {
    pub(super) configurations: Vec<Configuration>,
    /// How times were taken.
    pub(super) clock: String,
    /// Numbers that are not finite, in all pictures.
    pub(super) not_finite: usize,
}

/// Times and errors of every configuration, in the order of `configurations`.
pub(super) fn every(
    subject: &Subject<'_>,
    configurations: &[Settings],
    references: &References,
    cache: &Cache,
    progress: &dyn Progress,
) -> Result<Measured, FrontierError> {
    let context = Context {
        shared: Shared::new(subject),
        subject,
        references,
        cache,
        evaluator: OnceCell::new(),
    };
    let shadings = time_shadings(&context.shared, configurations, cache, progress)?;
    progress.start(
        &format!("{}: {} configurations", subject.scene.name, configurations.len()),
        configurations.len(),
    );
    let mut measured = Measured::default();
    // Configurations that share a step follow each other.
    let depends = &subject.depends;
    let maps_alike =
        |one: &Settings, next: &Settings| depends.of_maps(one) == depends.of_maps(next);
    let lights_alike =
        |one: &Settings, next: &Settings| depends.of_lights(one) == depends.of_lights(next);
    for configurations in configurations.chunk_by(maps_alike) {
        let Some(first) = configurations.first() else { continue };
        let maps = Step::maps(subject, first, cache)?;
        measured.clock.clone_from(&maps.timed.clock);
        for configurations in configurations.chunk_by(lights_alike) {
            let Some(first) = configurations.first() else { continue };
            let lights = Lights::new(subject, first, &maps, cache)?;
            for settings in configurations {
                let evaluation = context.evaluation(settings, &lights)?;
                measured.not_finite += evaluation.not_finite;
                let reflected = &shadings[&depends.shading_id(settings)];
                let parts = [&maps.timed, &lights.step.timed, reflected];
                measured
                    .configurations
                    .push(configuration_of(subject, settings, parts, evaluation)?);
                progress.done(measured.configurations.len());
            }
        }
    }
    Ok(measured)
}

/// What evaluating configurations takes.
struct Context<'a, 's> {
    shared: Shared<'a, 's>,
    subject: &'a Subject<'s>,
    references: &'a References,
    cache: &'a Cache,
    evaluator: OnceCell<Evaluator<'a>>,
}

impl<'a> Context<'a, '_> {
    /// What is found of a configuration's picture.
    fn evaluation(
        &self,
        settings: &Settings,
        lights: &Lights<'_>,
    ) -> Result<Evaluation, FrontierError> {
        let Self { shared, subject, .. } = self;
        let key =
            subject.key("evaluation", &configuration::name(settings, &subject.base), settings)?;
        self.cache.get(&key, || {
            let visibility = shared.visibility(settings)?;
            let lights = lights.shadowed(subject, visibility.as_deref(), settings)?;
            let shading = shared.shading(settings)?;
            let indirect = subject.reflect(lights, visibility.as_deref(), &shading)?;
            let oracle = subject.read_lights(lights)?;
            Ok(self.evaluator()?.evaluate(settings, &indirect, &oracle))
        })
    }

    /// The evaluator, made only if something was not evaluated before.
    fn evaluator(&self) -> Result<&Evaluator<'a>, FrontierError> {
        if let Some(evaluator) = self.evaluator.get() {
            return Ok(evaluator);
        }
        let Drawn { renderer, frame, .. } = self.subject.drawn()?;
        let evaluator = Evaluator::new(self.subject, self.references, frame, renderer.eye());
        Ok(self.evaluator.get_or_init(|| evaluator))
    }
}

/// A configuration of which these parts were timed and the picture was evaluated.
fn configuration_of(
    subject: &Subject<'_>,
    settings: &Settings,
    parts: [&Timed; 3],
    evaluation: Evaluation,
) -> Result<Configuration, FrontierError> {
    let base = &subject.base;
    let name = configuration::name(settings, base);
    let axes = configuration::axes(settings).into_iter();
    let passes = || parts.iter().flat_map(|timed| &timed.passes);
    Ok(Configuration {
        axes: axes.map(|(axis, value)| (axis.to_owned(), value.to_owned())).collect(),
        parameters: configuration::parameters(settings)
            .map(|(name, value)| (name.to_owned(), value))
            .collect(),
        variants: subject.variants(settings)?,
        default: name == "default",
        name,
        complete: complete(settings, base),
        passes: passes().cloned().collect(),
        time: passes().map(|pass| pass.time).sum(),
        whole: None,
        bytes: bytes(subject, settings)?,
        picture: evaluation.picture,
        unshadowed: evaluation.unshadowed,
        worst: evaluation.worst,
        model_rms_over_mean: evaluation.model_rms_over_mean,
        rounding: evaluation.rounding,
        flicker: None,
        frontiers: BTreeSet::new(),
        dominated: BTreeMap::new(),
    })
}

/// What a configuration keeps beside the surfaces that it reads.
fn bytes(
    subject: &Subject<'_>,
    settings: &Settings,
) -> Result<BTreeMap<String, u64>, FrontierError> {
    let resources = subject.plan(settings)?.resources;
    let own = resources.iter().filter(|one| PARTS.contains(&one.part.as_str()));
    Ok(own.map(|one| (one.name.clone(), one.bytes)).collect())
}

/// Whether settings have all that the scene needs, which `base` has.
fn complete(settings: &Settings, base: &Settings) -> bool {
    let specular = settings.specular != Specular::None && settings.lobes == Lobes::Both;
    settings.diffuse != Diffuse::None && (base.specular == Specular::None || specular)
}

#[cfg(test)]
mod tests {
    use sglow_shaders::Ndf;

    use super::*;

    #[test]
    fn a_configuration_without_what_the_scene_reflects_is_not_complete() {
        let glossy = Settings::default();
        let diffuse = Settings {
            lobes: Lobes::Diffuse,
            specular: Specular::None,
            ndf: Ndf::None,
            ..glossy.clone()
        };
        assert!(complete(&glossy, &glossy) && complete(&diffuse, &diffuse));
        assert!(!complete(&diffuse, &glossy));
        let specular = Settings { diffuse: Diffuse::None, ..glossy.clone() };
        assert!(!complete(&specular, &glossy));
    }
}
