//! What ways are called on a page: a number on the frontier, and where they differ from what the scene gets.

use std::collections::{BTreeMap, BTreeSet};

use maud::{Markup, html};
use sglow_measure::frontier::document::Way;

use super::Scene;
use crate::page::number::{figure, percent};

/// A scene and what its ways are called.
pub(crate) struct Named<'a> {
    /// The scene.
    pub(crate) scene: &'a Scene<'a>,
    index: usize,
    /// Axes on which ways differ, with their values.
    pub(crate) axes: Vec<(&'a str, Vec<&'a str>)>,
    /// Numbers of the frontier, from 1 at the fastest.
    numbers: BTreeMap<&'a str, usize>,
    /// The way to take, of which the page says why.
    pub(crate) taken: Option<&'a str>,
}

impl<'a> Named<'a> {
    pub(crate) fn new(index: usize, scene: &'a Scene<'a>) -> Self {
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
        let mut frontier: Vec<&Way> = ways.iter().filter(|way| way.frontier).collect();
        frontier.sort_by(|one, other| one.time.median.total_cmp(&other.time.median));
        let numbers = frontier
            .iter()
            .enumerate()
            .map(|(index, way)| (way.name.as_str(), index + 1))
            .collect();
        Self { scene, index, axes, numbers, taken: None }
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

    /// The frontier from its fast end, and the default if it is not on it.
    pub(crate) fn shown(&self) -> Vec<&'a Way> {
        let mut shown: Vec<&Way> = self.ways().iter().filter(|way| way.frontier).collect();
        shown.sort_by_key(|way| self.number(way));
        shown.extend(self.default().filter(|way| !way.frontier));
        shown
    }

    /// A way's number on the frontier.
    pub(crate) fn number(&self, way: &Way) -> Option<usize> {
        self.numbers.get(way.name.as_str()).copied()
    }

    /// The number of the most accurate of the frontier.
    pub(crate) fn last(&self) -> Option<usize> {
        self.numbers.values().max().copied()
    }

    /// Where a way differs from another, as axes and values.
    pub(crate) fn differences(&self, way: &'a Way, from: &Way) -> Vec<(&'a str, &'a str)> {
        way.axes
            .iter()
            .filter(|(axis, value)| from.axes.get(*axis) != Some(value))
            .map(|(axis, value)| (axis.as_str(), value.as_str()))
            .collect()
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

    /// An error over the mean, or an absolute one where there is no light.
    pub(crate) fn error(&self, value: f64) -> String {
        if self.scene.measured.reference.dark { figure(value) } else { percent(value) }
    }

    /// What errors are in.
    pub(crate) fn error_axis(&self) -> &'static str {
        if self.scene.measured.reference.dark {
            "error: RMSE, radiance"
        } else {
            "error: RMSE over the reference's mean"
        }
    }

    /// Bytes of all that a way keeps.
    pub(crate) fn bytes(way: &Way) -> f64 {
        way.bytes.values().map(|bytes| *bytes as f64).sum()
    }
}
