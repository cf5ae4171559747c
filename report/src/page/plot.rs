//! Plots with logarithmic axes, as SVG whose colours follow the page.
//!
//! Written by hand: plotters' SVG has its colours as attributes, so that it could not follow the scheme of the screen,
//! and no crate was found that keeps free labels from covering each other. What is needed of a plot is little.

use maud::{Markup, PreEscaped, html};

use crate::page::frame::DAY;
use crate::page::scale::Scale;

pub mod bars;
pub mod cloud;
pub mod lines;

/// Where the axes lie, in pixels of the drawing.
#[derive(Clone, Copy, Debug)]
struct Area {
    left: f64,
    right: f64,
    top: f64,
    bottom: f64,
}

const WIDTH: f64 = 860.0;
const HEIGHT: f64 = 480.0;

/// A finished drawing.
pub struct Drawing {
    /// What it shows, in a sentence, for who does not see it.
    title: String,
    width: f64,
    height: f64,
    body: Markup,
}

impl Drawing {
    /// As a part of a page, under whose style it comes.
    pub fn figure(&self, caption: &Markup) -> Markup {
        html! {
            figure {
                div.scroll tabindex="0" role="region" aria-label=(self.title) { (self.drawn("plot", "img")) }
                figcaption { (caption) }
            }
        }
    }

    /// The drawing alone; `role` is `img`, or `group` where its parts speak for themselves.
    fn drawn(&self, class: &str, role: &str) -> Markup {
        let view = format!("0 0 {} {}", self.width, self.height);
        html! { svg class=(class) viewBox=(view) role=(role) aria-label=(self.title) { (self.body) } }
    }

    /// As a file of its own, on white.
    pub fn file(&self) -> String {
        // Some programs that draw SVG know no variables.
        let style =
            DAY.iter().fold(include_str!("plot.css").to_owned(), |style, (name, colour)| {
                style.replace(&format!("var(--{name})"), colour)
            });
        let (width, height) = (self.width, self.height);
        let view = format!("0 0 {width} {height}");
        let drawing = html! {
            svg.plot xmlns="http://www.w3.org/2000/svg" viewBox=(view) width=(width) height=(height) role="img" {
                title { (self.title) }
                style { (PreEscaped(style)) }
                rect x="0" y="0" width=(width) height=(height) fill="#ffffff" {}
                (self.body)
            }
        };
        drawing.into_string() + "\n"
    }
}

/// Pixels to a tenth.
fn px(value: f64) -> String {
    format!("{:.1}", value)
}

impl Area {
    fn x(&self, scale: &Scale, value: f64) -> f64 {
        self.left + scale.place(value) * (self.right - self.left)
    }

    fn y(&self, scale: &Scale, value: f64) -> f64 {
        self.bottom - scale.place(value) * (self.bottom - self.top)
    }

    fn axes(&self, x: &Scale, x_label: &str, y: &Scale, y_label: &str) -> Markup {
        let Self { left, right, top, bottom } = *self;
        let middle = px((top + bottom) / 2.0);
        html! {
            @for tick in y.ticks() {
                @let at = px(self.y(y, tick.value));
                line class=(rule(&tick.label)) x1=(px(left)) x2=(px(right)) y1=(at) y2=(at) {}
                @if let Some(label) = &tick.label {
                    text.tick x=(px(left - 8.0)) y=(at) dy="0.35em" text-anchor="end" { (label) }
                }
            }
            @for tick in x.ticks() {
                @let at = px(self.x(x, tick.value));
                line class=(rule(&tick.label)) x1=(at) x2=(at) y1=(px(top)) y2=(px(bottom)) {}
                @if let Some(label) = &tick.label {
                    text.tick x=(at) y=(px(bottom + 18.0)) text-anchor="middle" { (label) }
                }
            }
            rect.frame x=(px(left)) y=(px(top)) width=(px(right - left)) height=(px(bottom - top)) {}
            text.axis x=(px((left + right) / 2.0)) y=(px(bottom + 40.0)) text-anchor="middle" { (x_label) }
            text.axis x="16" y=(middle) text-anchor="middle" transform={ "rotate(-90 16 " (middle) ")" } { (y_label) }
        }
    }
}

fn rule(label: &Option<String>) -> &'static str {
    if label.is_some() { "rule" } else { "fine" }
}

/// A point with a name.
#[derive(Clone, Debug)]
pub struct Spot {
    /// Its name.
    pub label: String,
    /// What stands below the name, smaller; may be empty.
    pub aside: String,
    /// Where it is.
    pub x: f64,
    /// From where to where it was measured to be.
    pub spread: [f64; 2],
    /// How high; not finite goes to a band above the plot.
    pub y: f64,
    /// Whether it is on the frontier, dominated by another, or something else altogether.
    pub rank: Rank,
}

/// How a point is drawn: by its shape first, by colour second.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rank {
    /// A full disc.
    Best,
    /// A ring.
    Dominated,
    /// A triangle.
    Literal,
}

/// A box that holds something, to keep labels apart.
#[derive(Clone, Copy, Debug)]
struct Hull {
    left: f64,
    right: f64,
    top: f64,
    bottom: f64,
}

impl Hull {
    fn overlap(&self, other: &Self) -> f64 {
        let width = self.right.min(other.right) - self.left.max(other.left);
        let height = self.bottom.min(other.bottom) - self.top.max(other.top);
        width.max(0.0) * height.max(0.0)
    }

    fn outside(&self, area: &Area) -> f64 {
        let out = (area.left - self.left).max(0.0)
            + (self.right - area.right).max(0.0)
            + (area.top - self.top).max(0.0)
            + (self.bottom - area.bottom).max(0.0);
        // Beyond the edge is worse than on something.
        out * 100.0
    }
}

/// A generous width of text in a font that is not known.
fn width_of(text: &str, size: f64) -> f64 {
    text.chars().count() as f64 * size * 0.62
}

/// A label's place: its hull, and whether its text ends there, starts there or is centred.
fn place(spot: &Spot, at: [f64; 2], taken: &[Hull], area: &Area) -> (Hull, &'static str, f64) {
    let width = width_of(&spot.label, 13.0).max(width_of(&spot.aside, 11.0));
    let height = if spot.aside.is_empty() { 16.0 } else { 29.0 };
    let mut best: Option<(f64, Hull, &'static str, f64)> = None;
    let offsets = [0.0, -1.0, 1.0, -1.8, 1.8, -2.6, 2.6];
    for (distance, offset) in [10.0, 22.0].into_iter().flat_map(|d| offsets.map(|o| (d, o))) {
        for anchor in ["start", "end", "middle"] {
            let (left, x) = match anchor {
                "start" => (at[0] + distance, at[0] + distance),
                "end" => (at[0] - distance - width, at[0] - distance),
                _ => (at[0] - width / 2.0, at[0]),
            };
            let top = at[1] + offset * 16.0 - height / 2.0;
            let hull = Hull { left, right: left + width, top, bottom: top + height };
            let cost: f64 =
                taken.iter().map(|other| hull.overlap(other)).sum::<f64>() + hull.outside(area);
            if best.as_ref().is_none_or(|best| cost < best.0) {
                best = Some((cost, hull, anchor, x));
            }
        }
    }
    best.map_or((around(at, 0.0), "start", at[0]), |(_, hull, anchor, x)| (hull, anchor, x))
}

fn around([x, y]: [f64; 2], radius: f64) -> Hull {
    Hull { left: x - radius, right: x + radius, top: y - radius, bottom: y + radius }
}

/// Points over two logarithmic axes, with a faint line along those that no other dominates.
pub fn scatter(title: &str, x_label: &str, y_label: &str, spots: &[Spot]) -> Option<Drawing> {
    let x = Scale::around(spots.iter().flat_map(|spot| [spot.x, spot.spread[0], spot.spread[1]]))?;
    let y = Scale::decades(spots.iter().map(|spot| spot.y))?;
    let lost = spots.iter().any(|spot| !spot.y.is_finite());
    let area = Area {
        left: 76.0,
        right: WIDTH - 20.0,
        top: if lost { 68.0 } else { 16.0 },
        bottom: HEIGHT - 52.0,
    };
    let room = Area { top: 8.0, ..area };
    let at = |spot: &Spot| {
        [area.x(&x, spot.x), if spot.y.is_finite() { area.y(&y, spot.y) } else { area.top - 24.0 }]
    };
    let mut taken: Vec<Hull> = Vec::new();
    for spot in spots {
        taken.push(around(at(spot), 8.0));
        let [low, high] = spot.spread.map(|value| area.x(&x, value));
        let bar = around(at(spot), 3.0);
        taken.push(Hull { left: low, right: high, ..bar });
    }
    if lost {
        let [left, top] = [area.left, area.top - 52.0];
        taken.push(Hull { left, right: left + 80.0, top, bottom: top + 48.0 });
    }
    let labels: Vec<_> = spots
        .iter()
        .map(|spot| {
            let placed = place(spot, at(spot), &taken, &room);
            taken.push(placed.0);
            placed
        })
        .collect();
    let mut best: Vec<&Spot> =
        spots.iter().filter(|spot| spot.rank == Rank::Best && spot.y.is_finite()).collect();
    best.sort_by(|one, other| one.x.total_cmp(&other.x));
    let body = html! {
        @if lost {
            rect.band x=(px(area.left)) y=(px(area.top - 52.0)) width=(px(area.right - area.left)) height="48" {}
            text.tick x=(px(area.left + 6.0)) y=(px(area.top - 20.0)) { "not finite" }
        }
        (area.axes(&x, x_label, &y, y_label))
        @if best.len() > 1 {
            polyline.frontier points=(steps(&best.iter().map(|spot| at(spot)).collect::<Vec<_>>())) {}
        }
        @for spot in spots {
            @let [_, height] = at(spot);
            @let [low, high] = spot.spread.map(|value| px(area.x(&x, value)));
            line.spread x1=(low) x2=(high) y1=(px(height)) y2=(px(height)) {}
        }
        @for (spot, (hull, anchor, left)) in spots.iter().zip(&labels) {
            (symbol(spot, at(spot)))
            text x=(px(*left)) y=(px(hull.top + 12.0)) text-anchor=(anchor) { (spot.label) }
            @if !spot.aside.is_empty() {
                text.aside x=(px(*left)) y=(px(hull.top + 25.0)) text-anchor=(anchor) { (spot.aside) }
            }
        }
    };
    Some(Drawing { title: title.to_owned(), width: WIDTH, height: HEIGHT, body })
}

/// From point to point along the axes: what is reached at each cost.
fn steps(points: &[[f64; 2]]) -> String {
    let mut text = Vec::new();
    let mut height = None;
    for [x, y] in points {
        if let Some(height) = height {
            text.push(format!("{},{}", px(*x), px(height)));
        }
        text.push(format!("{},{}", px(*x), px(*y)));
        height = Some(*y);
    }
    text.join(" ")
}

fn symbol(spot: &Spot, [x, y]: [f64; 2]) -> Markup {
    match spot.rank {
        Rank::Best => html! { circle.spot cx=(px(x)) cy=(px(y)) r="6.5" {} },
        Rank::Dominated => html! { circle."spot dominated" cx=(px(x)) cy=(px(y)) r="5" {} },
        Rank::Literal => {
            let corners = [(x, y - 8.0), (x - 8.0, y + 6.0), (x + 8.0, y + 6.0)];
            let corners = corners.map(|(x, y)| format!("{},{}", px(x), px(y))).join(" ");
            html! { polygon."spot literal" points=(corners) {} }
        }
    }
}

/// A curve with a name.
#[derive(Clone, Debug)]
pub struct Curve {
    /// Its name.
    pub label: String,
    /// Its points; where the second number is not finite, there is a block above the plot instead.
    pub points: Vec<[f64; 2]>,
    /// Whether it is the one that shows what goes wrong.
    pub literal: bool,
}

/// How many looks of a curve there are.
const LOOKS: usize = 8;

/// Curves over two logarithmic axes; what lies below `least` is drawn at it.
pub fn curves(
    title: &str,
    x_label: &str,
    y_label: &str,
    curves: &[Curve],
    least: f64,
) -> Option<Drawing> {
    let points = || curves.iter().flat_map(|curve| &curve.points);
    let x = Scale::around(points().map(|point| point[0]))?;
    let y = Scale::decades(points().map(|point| point[1]))?.not_below(least);
    let lost: Vec<usize> = (0..curves.len())
        .filter(|&index| curves[index].points.iter().any(|point| !point[1].is_finite()))
        .collect();
    /// Height of the row of one curve that is not finite somewhere.
    const ROW: f64 = 18.0;
    let top = if lost.is_empty() { 16.0 } else { 26.0 + ROW * lost.len() as f64 };
    let longest = curves.iter().map(|curve| width_of(&curve.label, 13.0)).fold(0.0, f64::max);
    let area = Area { left: 76.0, right: WIDTH - longest - 40.0, top, bottom: top + 412.0 };
    let look = |index: usize| {
        if curves[index].literal {
            "literal-curve".to_owned()
        } else {
            // Literal ones have a look of their own.
            let number = curves[..index].iter().filter(|curve| !curve.literal).count();
            format!("c{}", number % LOOKS)
        }
    };
    let drawn = |point: &[f64; 2]| [area.x(&x, point[0]), area.y(&y, point[1])];
    // Names stand at the right, each as near as may be to where its curve ends.
    let mut ends: Vec<(usize, [f64; 2], f64)> = curves
        .iter()
        .enumerate()
        .filter_map(|(index, curve)| {
            let last = curve.points.iter().rfind(|point| point[1].is_finite())?;
            let at = drawn(last);
            Some((index, at, at[1]))
        })
        .collect();
    ends.sort_by(|one, other| one.2.total_cmp(&other.2).then(one.0.cmp(&other.0)));
    spread(&mut ends, area.top + 6.0, area.bottom - 6.0);
    let body = html! {
        @if !lost.is_empty() {
            rect.band x=(px(area.left)) y="8" width=(px(area.right - area.left)) height=(px(top - 16.0)) {}
            @for (row, &index) in lost.iter().enumerate() {
                @let middle = 17.0 + ROW * row as f64;
                @for [first, last] in gaps(&curves[index].points) {
                    line class={ "block " (look(index)) } x1=(px(area.x(&x, first) - 2.0)) x2=(px(area.x(&x, last) + 2.0)) y1=(px(middle)) y2=(px(middle)) {}
                }
                text.tick x=(px(area.right + 10.0)) y=(px(middle)) dy="0.35em" { "not finite" }
                text.tick x=(px(area.left + 6.0)) y=(px(middle)) dy="0.35em" { (curves[index].label) }
            }
        }
        (area.axes(&x, x_label, &y, y_label))
        @for (index, curve) in curves.iter().enumerate() {
            @for piece in pieces(&curve.points) {
                @let corners = piece.iter().map(|point| { let [x, y] = drawn(point); format!("{},{}", px(x), px(y)) });
                polyline class={ "curve " (look(index)) } points=(corners.collect::<Vec<_>>().join(" ")) { title { (curve.label) } }
            }
        }
        @for (index, [right, end], height) in &ends {
            // From a curve that ends earlier the way would be across the plot.
            @if area.right - right < 60.0 {
                line.leader x1=(px(*right)) y1=(px(*end)) x2=(px(area.right + 8.0)) y2=(px(*height)) {}
            }
            line class={ "curve " (look(*index)) } x1=(px(area.right + 8.0)) x2=(px(area.right + 28.0)) y1=(px(*height)) y2=(px(*height)) {}
            text x=(px(area.right + 34.0)) y=(px(*height)) dy="0.35em" { (curves[*index].label) }
        }
    };
    Some(Drawing { title: title.to_owned(), width: WIDTH, height: area.bottom + 52.0, body })
}

/// Moves heights, which grow, apart so that a name fits between each two, within these limits.
fn spread(ends: &mut [(usize, [f64; 2], f64)], top: f64, bottom: f64) {
    const APART: f64 = 17.0;
    let mut least = top;
    for end in ends.iter_mut() {
        end.2 = end.2.max(least);
        least = end.2 + APART;
    }
    let mut most = bottom;
    for end in ends.iter_mut().rev() {
        end.2 = end.2.min(most);
        most = end.2 - APART;
    }
}

/// Runs of points that can be drawn.
fn pieces(points: &[[f64; 2]]) -> Vec<&[[f64; 2]]> {
    points.split(|point| !point[1].is_finite()).filter(|piece| !piece.is_empty()).collect()
}

/// From where to where points cannot be drawn.
fn gaps(points: &[[f64; 2]]) -> Vec<[f64; 2]> {
    points
        .chunk_by(|one, other| one[1].is_finite() == other[1].is_finite())
        .filter_map(|run| match run {
            [first, .., last] if !first[1].is_finite() => Some([first[0], last[0]]),
            [only] if !only[1].is_finite() => Some([only[0]; 2]),
            _ => None,
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn spot(label: &str, x: f64, y: f64, rank: Rank) -> Spot {
        let aside =
            if rank == Rank::Dominated { "dominated by another".to_owned() } else { String::new() };
        Spot { label: label.to_owned(), aside, x, spread: [x * 0.9, x * 1.2], y, rank }
    }

    #[test]
    fn without_data_there_is_no_plot() {
        assert!(scatter("t", "x", "y", &[]).is_none());
        assert!(scatter("t", "x", "y", &[spot("a", f64::NAN, f64::NAN, Rank::Best)]).is_none());
        assert!(curves("t", "x", "y", &[], 1e-9).is_none());
    }

    #[test]
    fn what_is_not_finite_is_said_and_no_coordinate_is_odd() {
        let spots = [
            spot("good", 1.0, 1e-3, Rank::Best),
            spot("lost", 1.5, f64::INFINITY, Rank::Literal),
            spot("zero", 2.0, 0.0, Rank::Dominated),
        ];
        let file = scatter("t", "x", "y", &spots).unwrap().file();
        assert!(file.contains("not finite") && file.contains("<polygon"), "{file}");
        for word in ["NaN", "inf\"", "var(", "\"-0.0\""] {
            assert!(!file.contains(word), "{word}: {file}");
        }
        let points = vec![[1.0, 1e-3], [2.0, f64::INFINITY], [4.0, f64::NAN], [8.0, 0.0]];
        let curve = Curve { label: "literal".to_owned(), points, literal: true };
        let file = curves("t", "x", "y", &[curve], 1e-9).unwrap().file();
        assert!(file.contains("not finite") && !file.contains("NaN"), "{file}");
    }

    #[test]
    fn gaps_and_pieces_make_up_a_curve() {
        let points =
            [[1.0, f64::NAN], [2.0, 1.0], [3.0, f64::INFINITY], [4.0, f64::NAN], [5.0, 1.0]];
        assert_eq!(gaps(&points), [[1.0, 1.0], [3.0, 4.0]]);
        let pieces = pieces(&points);
        assert_eq!(pieces, [[[2.0, 1.0]], [[5.0, 1.0]]]);
    }

    #[test]
    fn names_do_not_cover_each_other() {
        // Worse than what is drawn: eight points within a few pixels.
        let area = Area { left: 76.0, right: 840.0, top: 16.0, bottom: 428.0 };
        let mut taken = Vec::new();
        let spots: Vec<Spot> =
            (0..8).map(|index| spot(&format!("sg_cosine_{index}"), 1.0, 1.0, Rank::Best)).collect();
        for (index, spot) in spots.iter().enumerate() {
            let at = [400.0 + 5.0 * index as f64, 200.0 + 3.0 * index as f64];
            let (hull, _, _) = place(spot, at, &taken, &area);
            let covered: f64 = taken.iter().map(|other: &Hull| hull.overlap(other)).sum();
            assert_eq!(covered, 0.0, "{}", spot.label);
            taken.push(hull);
        }
        let same = Hull { left: 0.0, right: 10.0, top: 0.0, bottom: 10.0 };
        assert!(same.overlap(&same) > 0.0, "an overlap is seen");
    }

    #[test]
    fn names_at_the_right_are_apart_and_within() {
        let mut ends: Vec<_> = (0..10).map(|index| (index, [0.0, 390.0], 390.0)).collect();
        spread(&mut ends, 20.0, 400.0);
        assert!(ends.windows(2).all(|pair| pair[1].2 - pair[0].2 >= 16.9));
        assert!(ends.iter().all(|end| (20.0..=400.0).contains(&end.2)));
    }

    #[test]
    fn the_same_data_give_the_same_bytes() {
        let spots = [spot("a", 1.0, 1e-3, Rank::Best), spot("b", 3.0, 1e-5, Rank::Best)];
        let draw = || scatter("t", "x", "y", &spots).unwrap().file();
        assert_eq!(draw(), draw());
    }
}
