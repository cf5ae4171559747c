//! Hundreds of points over two logarithmic axes: the few that matter by number and name, the others faint.

use maud::{Markup, html};

use crate::page::plot::{Area, Drawing, HEIGHT, Hull, WIDTH, around, px, steps, width_of};
use crate::page::scale::Scale;

/// A point.
#[derive(Clone, Debug)]
pub(crate) struct Dot {
    /// Where it is.
    pub(crate) x: f64,
    /// From where to where it was measured to be; drawn of those with a name.
    pub(crate) spread: [f64; 2],
    /// How high; not finite goes to a band above the plot.
    pub(crate) y: f64,
    /// What it is.
    pub(crate) kind: Kind,
    /// What it says when it is pointed at, line by line.
    pub(crate) says: String,
    /// What a script finds it by.
    pub(crate) key: String,
}

/// What a point is: shown by shape and size first, by colour second.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    /// A disc with its number and its name.
    Frontier {
        /// From 1 on.
        number: usize,
        /// May be empty.
        name: String,
        /// Whether it has a ring around it.
        ringed: bool,
    },
    /// A diamond with a name.
    Named(String),
    /// A small ring.
    Dominated,
    /// A small cross.
    Lacking,
}

/// A height below which nothing is claimed.
#[derive(Clone, Debug)]
pub(crate) struct Floor {
    /// Where.
    pub(crate) at: f64,
    /// What stands at it.
    pub(crate) says: String,
}

/// Height of the band of what is not finite.
const BAND: f64 = 40.0;
/// Radius of a numbered disc.
const RADIUS: f64 = 9.0;

/// The points, those of the frontier joined by what is reached at each cost; none if no point has a place.
pub(crate) fn cloud(
    title: &str,
    x_label: &str,
    y_label: &str,
    dots: &[Dot],
    floor: Option<&Floor>,
) -> Option<Drawing> {
    let spreads = dots.iter().filter(|dot| named(dot)).flat_map(|dot| dot.spread);
    let x = Scale::around(dots.iter().map(|dot| dot.x).chain(spreads))?;
    let least = dots.iter().map(|dot| dot.y).filter(|y| *y > 0.0).fold(f64::INFINITY, f64::min);
    // A floor far below would leave no height to the points.
    let shown = floor.map(|floor| floor.at).filter(|at| *at >= least / 20.0);
    let y = Scale::around(dots.iter().map(|dot| dot.y).chain(shown))?;
    let lost = dots.iter().any(|dot| !dot.y.is_finite());
    let top = if lost { 24.0 + BAND } else { 16.0 };
    let area = Area { left: 76.0, right: WIDTH - 20.0, top, bottom: HEIGHT - 52.0 };
    let at = |dot: &Dot| {
        let height =
            if dot.y.is_finite() { area.y(&y, dot.y) } else { area.top - 8.0 - BAND / 2.0 };
        [area.x(&x, dot.x), height]
    };
    let mut frontier: Vec<&Dot> = dots
        .iter()
        .filter(|dot| matches!(dot.kind, Kind::Frontier { .. }) && dot.y.is_finite())
        .collect();
    frontier.sort_by(|one, other| one.x.total_cmp(&other.x));
    let body = html! {
        @if lost {
            rect.band x=(px(area.left)) y="8" width=(px(area.right - area.left)) height=(px(BAND)) {}
            text.tick x=(px(area.left + 6.0)) y="22" { "error not finite" }
        }
        (area.axes(&x, x_label, &y, y_label))
        @if let Some(floor) = floor { (floor_band(&area, &y, floor)) }
        @if frontier.len() > 1 {
            polyline.frontier points=(steps(&frontier.iter().map(|dot| at(dot)).collect::<Vec<_>>())) {}
        }
        @for dot in dots.iter().filter(|dot| !named(dot)) { (point(dot, at(dot))) }
        @for dot in dots.iter().filter(|dot| named(dot)) {
            @let [_, height] = at(dot).map(px);
            @let [low, high] = dot.spread.map(|value| px(area.x(&x, value)));
            line.spread x1=(low) x2=(high) y1=(height) y2=(height) {}
        }
        @for dot in dots.iter().filter(|dot| named(dot) && !ringed(dot)) { (point(dot, at(dot))) }
        // The one that matters most covers the others.
        @for dot in dots.iter().filter(|dot| ringed(dot)) { (point(dot, at(dot))) }
        @if let Some(floor) = floor { (floor_line(&area, &y, floor)) }
        (names(dots, &at, &area))
    };
    Some(Drawing { title: title.to_owned(), width: WIDTH, height: HEIGHT, body })
}

impl Drawing {
    /// The drawing as a group of points that the keyboard can reach.
    pub(crate) fn points(&self) -> Markup {
        html! {
            div.scroll role="region" aria-label=(self.title) { (self.drawn("plot cloud", "group")) }
        }
    }
}

fn named(dot: &Dot) -> bool {
    matches!(dot.kind, Kind::Frontier { .. } | Kind::Named(_))
}

fn ringed(dot: &Dot) -> bool {
    matches!(dot.kind, Kind::Frontier { ringed: true, .. })
}

fn floor_band(area: &Area, y: &Scale, floor: &Floor) -> Markup {
    let height = area.y(y, floor.at);
    html! {
        rect.below x=(px(area.left)) y=(px(height)) width=(px(area.right - area.left)) height=(px(area.bottom - height)) {}
    }
}

fn floor_line(area: &Area, y: &Scale, floor: &Floor) -> Markup {
    let height = area.y(y, floor.at);
    // At the lower end of the axis the words stand above it.
    let words = if area.bottom - height < 20.0 { height - 6.0 } else { height + 15.0 };
    html! {
        line.floor x1=(px(area.left)) x2=(px(area.right)) y1=(px(height)) y2=(px(height)) {}
        text.aside x=(px(area.right - 6.0)) y=(px(words)) text-anchor="end" { (floor.says) }
    }
}

fn point(dot: &Dot, [x, y]: [f64; 2]) -> Markup {
    let class = match dot.kind {
        Kind::Frontier { .. } => "dot best",
        Kind::Named(_) => "dot named",
        Kind::Dominated => "dot dominated",
        Kind::Lacking => "dot lacking",
    };
    let tab = if named(dot) { "0" } else { "-1" };
    html! {
        g class=(class) tabindex=(tab) role="img" aria-label=(dot.says) data-key=(dot.key) {
            title { (dot.says) }
            @match &dot.kind {
                Kind::Frontier { number, ringed, .. } => {
                    @if *ringed { circle.ring cx=(px(x)) cy=(px(y)) r=(RADIUS + 4.0) {} }
                    circle.disc cx=(px(x)) cy=(px(y)) r=(RADIUS) {}
                    text.number x=(px(x)) y=(px(y)) dy="0.36em" text-anchor="middle" { (number) }
                }
                Kind::Named(_) => polygon points=(corners(x, y, 8.0)) {},
                Kind::Dominated => circle cx=(px(x)) cy=(px(y)) r="3.5" {},
                Kind::Lacking => path d={
                    "M" (px(x - 3.0)) " " (px(y - 3.0)) "l6 6m0-6l-6 6"
                } {},
            }
        }
    }
}

fn corners(x: f64, y: f64, size: f64) -> String {
    let corners = [(x, y - size), (x + size, y), (x, y + size), (x - size, y)];
    corners.map(|(x, y)| format!("{},{}", px(x), px(y))).join(" ")
}

/// Names beside the points that have one, kept apart from each other and from other such points.
fn names(dots: &[Dot], at: &dyn Fn(&Dot) -> [f64; 2], area: &Area) -> Markup {
    let mut taken: Vec<Hull> =
        dots.iter().filter(|dot| named(dot)).map(|dot| around(at(dot), RADIUS + 1.0)).collect();
    let labels: Vec<(&str, f64, f64, &'static str)> = dots
        .iter()
        .filter_map(|dot| match &dot.kind {
            Kind::Frontier { name, .. } | Kind::Named(name) if !name.is_empty() => {
                Some((dot, name))
            }
            _ => None,
        })
        .filter_map(|(dot, name)| {
            let (hull, x, anchor) = free(name, at(dot), &taken, area)?;
            taken.push(hull);
            Some((name.as_str(), x, hull.top + 11.0, anchor))
        })
        .collect();
    html! {
        @for (name, x, y, anchor) in labels {
            text.name x=(px(x)) y=(px(y)) text-anchor=(anchor) { (name) }
        }
    }
}

/// A place for a name that covers nothing; none if there is none, for each name stands in the table too.
fn free(
    name: &str,
    [x, y]: [f64; 2],
    taken: &[Hull],
    area: &Area,
) -> Option<(Hull, f64, &'static str)> {
    let width = width_of(name, 12.0);
    let away = RADIUS + 4.0;
    // What is dominated lies above and to the right of the frontier, so names go below it first.
    [13.0, 26.0, 39.0, 0.0, -13.0, -26.0]
        .into_iter()
        .flat_map(|offset| {
            [(x - away - width, x - away, "end"), (x + away, x + away, "start")]
                .map(|(left, at, anchor)| (left, at, anchor, y + offset - 7.0))
        })
        .map(|(left, at, anchor, top)| {
            (Hull { left, right: left + width, top, bottom: top + 14.0 }, at, anchor)
        })
        .find(|(hull, _, _)| {
            hull.outside(area) == 0.0 && taken.iter().all(|other| hull.overlap(other) == 0.0)
        })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn dot(x: f64, y: f64, kind: Kind) -> Dot {
        Dot {
            x,
            spread: [0.8 * x, 1.3 * x],
            y,
            kind,
            says: "<says> &".to_owned(),
            key: "0,1".to_owned(),
        }
    }

    fn frontier(number: usize) -> Kind {
        Kind::Frontier { number, name: format!("configuration {number}"), ringed: number == 2 }
    }

    #[test]
    fn points_say_what_they_are_and_escape_it() {
        let dots = [
            dot(1.0, 0.1, frontier(1)),
            dot(2.0, 0.05, frontier(2)),
            dot(3.0, 0.2, Kind::Dominated),
        ];
        let floor = Floor { at: 0.04, says: "no claim below".to_owned() };
        let drawn = cloud("t", "x", "y", &dots, Some(&floor)).unwrap().points().into_string();
        assert_eq!(drawn.matches("<title>&lt;says&gt; &amp;</title>").count(), 3);
        assert_eq!(
            drawn.matches("tabindex=\"0\"").count(),
            2,
            "hundreds of stops would be too many"
        );
        assert_eq!(drawn.matches("class=\"ring\"").count(), 1);
        assert!(drawn.contains("no claim below") && drawn.contains("configuration 2"), "{drawn}");
    }

    #[test]
    fn what_is_not_finite_has_a_band_and_no_coordinate_is_odd() {
        let dots = [
            dot(1.0, 0.1, frontier(1)),
            dot(2.0, f64::NAN, Kind::Dominated),
            dot(2.0, f64::INFINITY, Kind::Lacking),
            dot(3.0, 0.0, Kind::Named("default".to_owned())),
        ];
        let drawn = cloud("t", "x", "y", &dots, None).unwrap().points().into_string();
        assert!(drawn.contains("error not finite"));
        for word in ["NaN", "inf\"", "inf,"] {
            assert!(!drawn.contains(word), "{word}: {drawn}");
        }
        assert!(cloud("t", "x", "y", &[], None).is_none());
        assert!(
            cloud("t", "x", "y", &[dot(1.0, 0.0, Kind::Dominated)], None).is_none(),
            "no height"
        );
    }

    #[test]
    fn names_that_find_no_place_are_left_out_and_none_covers_another() {
        let area = Area { left: 76.0, right: 840.0, top: 16.0, bottom: 428.0 };
        let mut taken = Vec::new();
        for _ in 0..30 {
            if let Some((hull, _, _)) = free("a name", [400.0, 200.0], &taken, &area) {
                assert!(taken.iter().all(|other| hull.overlap(other) == 0.0));
                taken.push(hull);
            }
        }
        assert!((2..30).contains(&taken.len()), "{}", taken.len());
        let outside = free(&"long ".repeat(100), [400.0, 200.0], &[], &area);
        assert!(outside.is_none(), "a name stays within the plot");
    }

    #[test]
    fn a_floor_far_below_leaves_the_points_their_height() {
        let dots = [dot(1.0, 0.2, frontier(1)), dot(2.0, 0.1, frontier(2))];
        let height = |at: f64| {
            let floor = Floor { at, says: String::new() };
            let drawn = cloud("t", "x", "y", &dots, Some(&floor)).unwrap().points().into_string();
            drawn.matches("<line class=\"rule\"").count()
        };
        assert_eq!(height(1e-9), height(1e-12), "it is drawn at the lower end");
    }
}
