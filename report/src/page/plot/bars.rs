//! Bars made of parts, from left to right, over one linear axis from 0.

use maud::{Markup, html};

use crate::page::plot::{Area, Drawing, LOOKS, WIDTH, px, width_of};
use crate::page::scale::linear;

/// A bar.
#[derive(Clone, Debug)]
pub(crate) struct Bar {
    /// What stands before it.
    pub(crate) label: String,
    /// Index of what each part is, and its length.
    pub(crate) parts: Vec<(usize, f64)>,
    /// A length that is marked across it: the same measured in another way.
    pub(crate) mark: Option<f64>,
}

const ROW: f64 = 28.0;
const LEFT: f64 = 250.0;

/// What a part is called where there is room for a letter only.
pub(crate) fn letter(index: usize) -> String {
    const LETTERS: usize = 26;
    let last = char::from(b'a' + u8::try_from(index % LETTERS).unwrap_or(0));
    match index / LETTERS {
        0 => last.to_string(),
        more => format!("{}{last}", letter(more - 1)),
    }
}

/// Bars whose parts are of `kinds`; `amount` writes a length. None without a length above 0.
pub(crate) fn bars(
    title: &str,
    axis: &str,
    kinds: &[String],
    bars: &[Bar],
    amount: &dyn Fn(f64) -> String,
) -> Option<Drawing> {
    let length = |bar: &Bar| bar.parts.iter().map(|part| part.1).sum::<f64>();
    let most = bars
        .iter()
        .flat_map(|bar| [Some(length(bar)), bar.mark])
        .flatten()
        .filter(|length| length.is_finite())
        .fold(0.0, f64::max);
    if most <= 0.0 {
        return None;
    }
    let bottom = 8.0 + ROW * bars.len() as f64;
    let area = Area { left: LEFT, right: WIDTH - 90.0, top: 8.0, bottom };
    let x = |value: f64| area.left + (value / most).clamp(0.0, 1.0) * (area.right - area.left);
    let body = html! {
        @for tick in linear(most) {
            line.rule x1=(px(x(tick))) x2=(px(x(tick))) y1=(px(area.top)) y2=(px(area.bottom)) {}
            text.tick x=(px(x(tick))) y=(px(area.bottom + 16.0)) text-anchor="middle" { (amount(tick)) }
        }
        text.axis x=(px((area.left + area.right) / 2.0)) y=(px(area.bottom + 36.0)) text-anchor="middle" { (axis) }
        @for (row, bar) in bars.iter().enumerate() {
            @let top = area.top + ROW * row as f64 + 4.0;
            text x=(px(area.left - 8.0)) y=(px(top + 10.0)) dy="0.35em" text-anchor="end" { (fitting(&bar.label)) }
            (parts(bar, kinds, top, &x, amount))
            text.tick x=(px(x(length(bar).max(bar.mark.unwrap_or(0.0))) + 6.0)) y=(px(top + 10.0)) dy="0.35em" {
                @if bar.parts.is_empty() { "not measured" } @else { (amount(length(bar))) }
            }
        }
    };
    Some(Drawing { title: title.to_owned(), width: WIDTH, height: bottom + 44.0, body })
}

fn parts(
    bar: &Bar,
    kinds: &[String],
    top: f64,
    x: &dyn Fn(f64) -> f64,
    amount: &dyn Fn(f64) -> String,
) -> Markup {
    let mut from = 0.0;
    let placed: Vec<(usize, f64, f64, f64)> = bar
        .parts
        .iter()
        .filter(|part| part.1.is_finite() && part.1 > 0.0)
        .map(|&(kind, length)| {
            let left = x(from);
            from += length;
            (kind, length, left, x(from) - left)
        })
        .collect();
    html! {
        @for (kind, length, left, width) in placed {
            @let name = kinds.get(kind).map_or("", String::as_str);
            g {
                title { (name) ": " (amount(length)) }
                rect class={ "part p" (kind % LOOKS) } x=(px(left)) y=(px(top)) width=(px(width)) height="20" {}
                @if kinds.len() > 1 && width >= width_of(&letter(kind), 12.0) + 4.0 {
                    text.in x=(px(left + width / 2.0)) y=(px(top + 10.0)) dy="0.35em" text-anchor="middle" { (letter(kind)) }
                }
            }
        }
        @if let Some(mark) = bar.mark.filter(|mark| mark.is_finite()) {
            line.mark x1=(px(x(mark))) x2=(px(x(mark))) y1=(px(top - 3.0)) y2=(px(top + 23.0)) { title { (amount(mark)) } }
        }
    }
}

/// As much of a name as there is room for.
fn fitting(name: &str) -> String {
    let most = 32;
    if name.chars().count() <= most {
        return name.to_owned();
    }
    name.chars().take(most - 1).chain(['…']).collect()
}

/// What the letters stand for.
pub(crate) fn legend(kinds: &[String]) -> Markup {
    html! {
        ul.legend {
            @for (index, kind) in kinds.iter().enumerate() {
                li { span class={ "swatch p" (index % LOOKS) } { (letter(index)) } " " (kind) }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_add_up_and_what_is_odd_is_not_drawn() {
        let kinds = ["one <".to_owned(), "two".to_owned()];
        let bar =
            |parts: Vec<(usize, f64)>| Bar { label: "a & b".to_owned(), parts, mark: Some(4.0) };
        let all = [bar(vec![(0, 1.0), (1, 3.0)]), bar(vec![(0, f64::NAN), (1, 0.0)]), bar(vec![])];
        let drawn = bars("t", "ms", &kinds, &all, &|value| format!("{value}")).unwrap().file();
        assert_eq!(drawn.matches("class=\"part").count(), 2);
        assert!(drawn.contains("one &lt;: 1") && drawn.contains("a &amp; b"), "{drawn}");
        assert_eq!(drawn.matches("not measured").count(), 1, "nothing is not 0");
        let widths: Vec<f64> = drawn
            .split("class=\"part")
            .skip(1)
            .map(|rest| {
                rest.split("width=\"").nth(1).unwrap().split('"').next().unwrap().parse().unwrap()
            })
            .collect();
        assert!((widths[1] / widths[0] - 3.0).abs() < 0.01, "{widths:?}");
        assert!(bars("t", "ms", &kinds, &[], &|value| format!("{value}")).is_none());
    }

    #[test]
    fn every_part_has_a_letter_of_its_own() {
        let letters: std::collections::BTreeSet<String> = (0..100).map(letter).collect();
        assert_eq!(letters.len(), 100);
        assert_eq!([letter(0), letter(25), letter(26)], ["a", "z", "aa"]);
    }
}
