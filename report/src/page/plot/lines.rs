//! Measured points along a number, joined, over two logarithmic axes; small, to stand beside others of the same lines.

use maud::{Markup, html};

use crate::page::plot::{Area, Drawing, LOOKS, px};
use crate::page::scale::Scale;

/// Some points with a name.
#[derive(Clone, Debug)]
pub(crate) struct Line {
    /// Its name.
    pub(crate) name: String,
    /// Its points in ascending order; what is not finite is left out, what is 0 lies at the lower end.
    pub(crate) points: Vec<[f64; 2]>,
    /// The number that is ringed.
    pub(crate) ringed: Option<f64>,
}

const SMALL_WIDTH: f64 = 430.0;
const SMALL_HEIGHT: f64 = 330.0;

/// The lines; none if no point has a place. `floor` is a height below which nothing is claimed.
pub(crate) fn lines(
    title: &str,
    x_label: &str,
    y_label: &str,
    lines: &[Line],
    floor: Option<f64>,
) -> Option<Drawing> {
    let points = || lines.iter().flat_map(|line| &line.points);
    let x = Scale::around(points().map(|point| point[0]))?;
    let y = Scale::around(points().map(|point| point[1]).chain(floor))?;
    let area =
        Area { left: 58.0, right: SMALL_WIDTH - 12.0, top: 12.0, bottom: SMALL_HEIGHT - 50.0 };
    let at = |point: &[f64; 2]| [area.x(&x, point[0]), area.y(&y, point[1])];
    let body = html! {
        (area.axes(&x, x_label, &y, y_label))
        @if let Some(floor) = floor {
            @let height = px(area.y(&y, floor));
            line.floor x1=(px(area.left)) x2=(px(area.right)) y1=(height) y2=(height) { title { "the reference's own noise" } }
        }
        @for (index, line) in lines.iter().enumerate() {
            @let drawn: Vec<&[f64; 2]> = line.points.iter().filter(|point| point[1].is_finite()).collect();
            polyline class={ "curve c" (index % LOOKS) } points=(joined(drawn.iter().map(|point| at(point)))) {}
            @for point in &drawn {
                @let [left, top] = at(point);
                (symbol(index, left, top, &format!("{}, {x_label} {}: {:.3e}", line.name, point[0], point[1])))
                @if line.ringed.is_some_and(|ringed| (ringed - point[0]).abs() < 1e-9 * ringed.abs().max(1.0)) {
                    circle.ring cx=(px(left)) cy=(px(top)) r="9" {}
                }
            }
        }
    };
    Some(Drawing { title: title.to_owned(), width: SMALL_WIDTH, height: SMALL_HEIGHT, body })
}

impl Drawing {
    /// One of several small drawings.
    pub(crate) fn small(&self, caption: &str) -> Markup {
        html! {
            figure.small {
                (self.drawn("plot", "img"))
                figcaption { (caption) }
            }
        }
    }
}

fn joined(points: impl Iterator<Item = [f64; 2]>) -> String {
    points.map(|[x, y]| format!("{},{}", px(x), px(y))).collect::<Vec<_>>().join(" ")
}

/// The mark of a line: shapes differ as colours do.
fn symbol(index: usize, x: f64, y: f64, says: &str) -> Markup {
    let class = format!("mark-of p{}", index % LOOKS);
    html! {
        @match index % 4 {
            0 => circle class=(class) cx=(px(x)) cy=(px(y)) r="3.5" { title { (says) } },
            1 => rect class=(class) x=(px(x - 3.2)) y=(px(y - 3.2)) width="6.4" height="6.4" { title { (says) } },
            2 => polygon class=(class) points=(joined([[x, y - 4.5], [x + 4.5, y + 3.5], [x - 4.5, y + 3.5]].into_iter())) { title { (says) } },
            _ => polygon class=(class) points=(joined([[x, y - 4.8], [x + 4.8, y], [x, y + 4.8], [x - 4.8, y]].into_iter())) { title { (says) } },
        }
    }
}

/// What the lines stand for.
pub(crate) fn legend(names: &[String]) -> Markup {
    html! {
        ul.legend {
            @for (index, name) in names.iter().enumerate() {
                li {
                    svg.plot.sample viewBox="0 0 40 14" aria-hidden="true" {
                        line class={ "curve c" (index % LOOKS) } x1="1" x2="39" y1="7" y2="7" {}
                        (symbol(index, 20.0, 7.0, name))
                    }
                    " " (name)
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_has_its_points_and_a_ring_and_nothing_odd() {
        let line = Line {
            name: "exact <".to_owned(),
            points: vec![[1.0, 0.5], [2.0, f64::NAN], [4.0, 0.25], [8.0, 0.0]],
            ringed: Some(4.0),
        };
        let drawn = lines("t", "x", "y", &[line], Some(0.2)).unwrap().file();
        assert_eq!(
            (
                drawn.matches("mark-of").count() - style_mentions(),
                drawn.matches("class=\"ring\"").count()
            ),
            (3, 1)
        );
        assert!(!drawn.contains("NaN") && drawn.contains("exact &lt;"), "{drawn}");
        assert!(lines("t", "x", "y", &[], None).is_none());
    }

    /// How often the style itself names the class.
    fn style_mentions() -> usize {
        include_str!("../plot.css").matches("mark-of").count()
    }
}
