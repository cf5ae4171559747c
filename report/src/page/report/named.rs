//! What configurations are called on a page: a number, and where they differ from what the scene gets; and their
//! errors by one metric.

use std::collections::{BTreeMap, BTreeSet};

use maud::{Markup, html};
use sglow_results::frontier::document::{Dominated, Metric, Way};

use crate::page::number::{figure, percent};
use crate::page::report::scene::Scene;
use crate::picture_error;

/// A scene and what its ways are called.
pub(crate) struct Named<'a> {
    /// The scene.
    pub(crate) scene: &'a Scene<'a>,
    index: usize,
    /// The metric that errors are by.
    pub(crate) metric: Metric,
    /// Axes on which ways differ, with their values.
    pub(crate) axes: Vec<(&'a str, Vec<&'a str>)>,
    /// Numbers of what is on a frontier by any metric, from 1 at the fastest: the same whatever the metric.
    numbers: BTreeMap<&'a str, usize>,
    /// The way to take, of which the page says why.
    pub(crate) taken: Option<&'a str>,
}

impl<'a> Named<'a> {
    pub(crate) fn new(index: usize, scene: &'a Scene<'a>, metric: Metric) -> Self {
        let ways = &scene.measured.ways;
        let mut values: BTreeMap<&str, BTreeSet<&str>> = BTreeMap::new();
        for (axis, value) in ways.iter().flat_map(|way| &way.axes) {
            values.entry(axis).or_default().insert(value);
        }
        let axes = values
            .into_iter()
            .filter(|(_, values)| values.len() > 1)
            .map(|(axis, values)| (axis, values.into_iter().collect()))
            .collect();
        let mut frontier: Vec<&Way> = ways.iter().filter(|way| !way.frontiers.is_empty()).collect();
        frontier.sort_by(|one, other| one.time.median.total_cmp(&other.time.median));
        let numbers = frontier
            .iter()
            .enumerate()
            .map(|(index, way)| (way.name.as_str(), index + 1))
            .collect();
        Self { scene, index, metric, axes, numbers, taken: None }
    }

    /// What links to the scene.
    pub(crate) fn id(&self) -> String {
        format!("scene-{}", self.index)
    }

    /// Its ways.
    pub(crate) fn ways(&self) -> &'a [Way] {
        &self.scene.measured.ways
    }

    /// The way of this name.
    pub(crate) fn way(&self, name: &str) -> Option<&'a Way> {
        self.ways().iter().find(|way| way.name == name)
    }

    /// What the scene gets if nobody chooses.
    pub(crate) fn default(&self) -> Option<&'a Way> {
        self.ways().iter().find(|way| way.default)
    }

    /// What is on a frontier by any metric from its fast end, and the default if it is on none.
    pub(crate) fn shown(&self) -> Vec<&'a Way> {
        let mut shown: Vec<&Way> =
            self.ways().iter().filter(|way| !way.frontiers.is_empty()).collect();
        shown.sort_by_key(|way| self.number(way));
        shown.extend(self.default().filter(|way| way.frontiers.is_empty()));
        shown
    }

    /// The frontier by the metric from its fast end.
    pub(crate) fn frontier(&self) -> Vec<&'a Way> {
        let mut frontier = self.shown();
        frontier.retain(|way| way.on_frontier(self.metric));
        frontier
    }

    /// What dominates a configuration by the metric.
    pub(crate) fn dominated(&self, way: &'a Way) -> Option<&'a Dominated> {
        way.dominated.get(&self.metric)
    }

    /// The error of a configuration as ranking takes it.
    pub(crate) fn value(&self, way: &Way) -> f64 {
        way.picture.of(self.metric)
    }

    /// The error of a configuration as a person reads it.
    pub(crate) fn cell(&self, way: &Way) -> String {
        picture_error::cell(&way.picture, self.metric).replace(' ', "\u{a0}")
    }

    /// A number of the metric as a person reads it.
    pub(crate) fn text(&self, value: f64) -> String {
        let dark = self.scene.measured.reference.dark;
        picture_error::text(value, self.metric, dark).replace(' ', "\u{a0}")
    }

    /// Below what an error is not told apart: the uncertainty of the least error.
    pub(crate) fn floor(&self) -> f64 {
        self.ways()
            .iter()
            .min_by(|one, other| self.value(one).total_cmp(&self.value(other)))
            .map_or(0.0, |way| way.picture.measured(self.metric).uncertainty)
    }

    /// A configuration's number.
    pub(crate) fn number(&self, way: &Way) -> Option<usize> {
        self.numbers.get(way.name.as_str()).copied()
    }

    /// Whether a configuration is at an end of the frontier by the metric.
    pub(crate) fn ends(&self, way: &Way) -> bool {
        let frontier = self.frontier();
        [frontier.first(), frontier.last()].into_iter().flatten().any(|end| end.name == way.name)
    }

    /// Where a way differs from another, as axes or parameters and values.
    pub(crate) fn differences(&self, way: &'a Way, from: &Way) -> Vec<(&'a str, &'a str)> {
        let differ = |ours: &'a BTreeMap<String, String>, theirs: &BTreeMap<String, String>| {
            ours.iter()
                .filter(|(name, value)| theirs.get(*name) != Some(value))
                .map(|(name, value)| (name.as_str(), value.as_str()))
                .collect::<Vec<_>>()
        };
        [differ(&way.axes, &from.axes), differ(&way.parameters, &from.parameters)].concat()
    }

    /// Whether it is the one to take.
    pub(crate) fn takes(&self, way: &Way) -> bool {
        self.taken == Some(way.name.as_str())
    }

    /// A few words for a way: where it differs from the default.
    pub(crate) fn words(&self, way: &'a Way) -> String {
        let Some(default) = self.default() else { return way.name.clone() };
        if way.default {
            return "default".to_owned();
        }
        let differences = self.differences(way, default);
        if differences.is_empty() {
            return way.name.clone();
        }
        let words: Vec<String> =
            differences.iter().map(|(axis, value)| format!("{axis} {value}")).collect();
        words.join(", ")
    }

    /// Its number as a badge, or what it is instead.
    pub(crate) fn badge(&self, way: &Way) -> Markup {
        match self.number(way) {
            Some(number) => html! { span.badge { (number) } },
            None => html! { span."badge beaten" { "◇" } },
        }
    }

    /// Badge and words.
    pub(crate) fn call(&self, way: &'a Way) -> Markup {
        html! {
            (self.badge(way)) " " (self.words(way))
            @if !way.complete { " " span.tag { "leaves light out" } }
        }
    }

    /// The same as text.
    pub(crate) fn line(&self, way: &'a Way) -> String {
        let number = self.number(way).map_or_else(|| "◇".to_owned(), |number| number.to_string());
        format!("{number} {}", self.words(way))
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

    /// Bytes of all that a way keeps.
    pub(crate) fn bytes(way: &Way) -> f64 {
        way.bytes.values().map(|bytes| *bytes as f64).sum()
    }
}
