//! What configurations are called on a page: a number, and where they differ from what the scene gets; and their
//! errors by one metric.

use std::collections::{BTreeMap, BTreeSet};

use maud::{Markup, html};
use sglow_results::frontier::document::{Configuration, Dominated, Metric};

use crate::page::number::{figure, percent};
use crate::page::report::scene::Scene;
use crate::picture_error;

/// A scene and what its configurations are called.
pub(crate) struct Named<'a> {
    /// The scene.
    pub(crate) scene: &'a Scene<'a>,
    index: usize,
    /// The metric that errors are by.
    pub(crate) metric: Metric,
    /// Axes on which configurations differ, with their values.
    pub(crate) axes: Vec<(&'a str, Vec<&'a str>)>,
    /// Numbers of what is on a frontier by any metric, from 1 at the fastest: the same whatever the metric.
    numbers: BTreeMap<&'a str, usize>,
    /// The configuration to take, of which the page says why.
    pub(crate) taken: Option<&'a str>,
}

impl<'a> Named<'a> {
    pub(crate) fn new(index: usize, scene: &'a Scene<'a>, metric: Metric) -> Self {
        let configurations = &scene.measured.configurations;
        let mut values: BTreeMap<&str, BTreeSet<&str>> = BTreeMap::new();
        for (axis, value) in configurations.iter().flat_map(|configuration| &configuration.axes) {
            values.entry(axis).or_default().insert(value);
        }
        let axes = values
            .into_iter()
            .filter(|(_, values)| values.len() > 1)
            .map(|(axis, values)| (axis, values.into_iter().collect()))
            .collect();
        let mut frontier: Vec<&Configuration> = configurations
            .iter()
            .filter(|configuration| !configuration.frontiers.is_empty())
            .collect();
        frontier.sort_by(|one, other| one.time.median.total_cmp(&other.time.median));
        let numbers = frontier
            .iter()
            .enumerate()
            .map(|(index, configuration)| (configuration.name.as_str(), index + 1))
            .collect();
        Self { scene, index, metric, axes, numbers, taken: None }
    }

    /// What links to the scene.
    pub(crate) fn id(&self) -> String {
        format!("scene-{}", self.index)
    }

    /// Its configurations.
    pub(crate) fn configurations(&self) -> &'a [Configuration] {
        &self.scene.measured.configurations
    }

    /// The configuration of this name.
    pub(crate) fn configuration(&self, name: &str) -> Option<&'a Configuration> {
        self.configurations().iter().find(|configuration| configuration.name == name)
    }

    /// What the scene gets if nobody chooses.
    pub(crate) fn default(&self) -> Option<&'a Configuration> {
        self.configurations().iter().find(|configuration| configuration.default)
    }

    /// What is on a frontier by any metric from its fast end, and the default if it is on none.
    pub(crate) fn shown(&self) -> Vec<&'a Configuration> {
        let mut shown: Vec<&Configuration> = self
            .configurations()
            .iter()
            .filter(|configuration| !configuration.frontiers.is_empty())
            .collect();
        shown.sort_by_key(|configuration| self.number(configuration));
        shown.extend(self.default().filter(|configuration| configuration.frontiers.is_empty()));
        shown
    }

    /// The frontier by the metric from its fast end.
    pub(crate) fn frontier(&self) -> Vec<&'a Configuration> {
        let mut frontier = self.shown();
        frontier.retain(|configuration| configuration.on_frontier(self.metric));
        frontier
    }

    /// What dominates a configuration by the metric.
    pub(crate) fn dominated(&self, configuration: &'a Configuration) -> Option<&'a Dominated> {
        configuration.dominated.get(&self.metric)
    }

    /// The error of a configuration as ranking takes it.
    pub(crate) fn value(&self, configuration: &Configuration) -> f64 {
        configuration.picture.of(self.metric)
    }

    /// The error of a configuration as a person reads it.
    pub(crate) fn cell(&self, configuration: &Configuration) -> String {
        picture_error::cell(&configuration.picture, self.metric).replace(' ', "\u{a0}")
    }

    /// A number of the metric as a person reads it.
    pub(crate) fn text(&self, value: f64) -> String {
        let dark = self.scene.measured.reference.dark;
        picture_error::text(value, self.metric, dark).replace(' ', "\u{a0}")
    }

    /// Errors closer than this count as the same: the uncertainty of the minimum error.
    pub(crate) fn floor(&self) -> f64 {
        self.configurations()
            .iter()
            .min_by(|one, other| self.value(one).total_cmp(&self.value(other)))
            .map_or(0.0, |configuration| configuration.picture.measured(self.metric).uncertainty)
    }

    /// A configuration's number.
    pub(crate) fn number(&self, configuration: &Configuration) -> Option<usize> {
        self.numbers.get(configuration.name.as_str()).copied()
    }

    /// Whether a configuration is at an end of the frontier by the metric.
    pub(crate) fn ends(&self, configuration: &Configuration) -> bool {
        let frontier = self.frontier();
        [frontier.first(), frontier.last()]
            .into_iter()
            .flatten()
            .any(|end| end.name == configuration.name)
    }

    /// Where a configuration differs from another, as axes or parameters and values.
    pub(crate) fn differences(
        &self,
        configuration: &'a Configuration,
        from: &Configuration,
    ) -> Vec<(&'a str, &'a str)> {
        let differ = |ours: &'a BTreeMap<String, String>, theirs: &BTreeMap<String, String>| {
            ours.iter()
                .filter(|(name, value)| theirs.get(*name) != Some(value))
                .map(|(name, value)| (name.as_str(), value.as_str()))
                .collect::<Vec<_>>()
        };
        [
            differ(&configuration.axes, &from.axes),
            differ(&configuration.parameters, &from.parameters),
        ]
        .concat()
    }

    /// Whether it is the one to take.
    pub(crate) fn takes(&self, configuration: &Configuration) -> bool {
        self.taken == Some(configuration.name.as_str())
    }

    /// A few words for a configuration: where it differs from the default.
    pub(crate) fn words(&self, configuration: &'a Configuration) -> String {
        let Some(default) = self.default() else { return configuration.name.clone() };
        if configuration.default {
            return "default".to_owned();
        }
        let differences = self.differences(configuration, default);
        if differences.is_empty() {
            return configuration.name.clone();
        }
        let words: Vec<String> =
            differences.iter().map(|(axis, value)| format!("{axis} {value}")).collect();
        words.join(", ")
    }

    /// Its number as a badge, or what it is instead.
    pub(crate) fn badge(&self, configuration: &Configuration) -> Markup {
        match self.number(configuration) {
            Some(number) => html! { span.badge { (number) } },
            None => html! { span."badge dominated" { "◇" } },
        }
    }

    /// Badge and words.
    pub(crate) fn call(&self, configuration: &'a Configuration) -> Markup {
        html! {
            (self.badge(configuration)) " " (self.words(configuration))
            @if !configuration.complete { " " span.tag { "leaves light out" } }
        }
    }

    /// The same as text.
    pub(crate) fn line(&self, configuration: &'a Configuration) -> String {
        let number =
            self.number(configuration).map_or_else(|| "◇".to_owned(), |number| number.to_string());
        format!("{number} {}", self.words(configuration))
    }

    /// A share of the mean, or an absolute number where there is no light.
    pub(crate) fn error(&self, value: f64) -> String {
        if self.scene.measured.reference.dark { figure(value) } else { percent(value) }
    }

    /// What errors are in.
    pub(crate) fn error_axis(&self) -> String {
        let title = self.metric.title();
        if self.scene.measured.reference.dark {
            format!("error: {title}, absolute, in radiance")
        } else {
            format!("error: {title}")
        }
    }

    /// Bytes of all that a configuration keeps.
    pub(crate) fn bytes(configuration: &Configuration) -> f64 {
        configuration.bytes.values().map(|bytes| *bytes as f64).sum()
    }
}
