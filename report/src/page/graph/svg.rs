//! A layout as SVG: legible by day and by night, and where no style is known to the program that shows it.

use maud::{Markup, PreEscaped, html};

use crate::page::frame::{DAY, NIGHT};
use crate::page::graph::layout::{ANGLE, Box, Fill, LARGE, Layout, Mark, Shape, Text, Tone};

/// Half the side of what writes, and the radius of what reads.
const MARK: f64 = 4.5;
/// How many colours of parts there are.
const COLOURS: usize = 8;

/// The drawing as a file.
pub(super) fn file(drawing: &Layout) -> String {
    let (width, height) = (px(drawing.width), px(drawing.height));
    let view = format!("0 0 {width} {height}");
    let markup = html! {
        svg xmlns="http://www.w3.org/2000/svg" viewBox=(view) width=(width) height=(height) role="img" {
            title { (drawing.title) }
            style { (PreEscaped(style())) }
            rect.paper x="0" y="0" width=(width) height=(height) {}
            @for shape in &drawing.shapes { (shaped(shape)) }
            @for mark in &drawing.marks { (marked(mark)) }
            @for text in &drawing.texts { (set(text)) }
        }
    };
    markup.into_string() + "\n"
}

fn style() -> String {
    let night: String = NIGHT.iter().map(|(name, colour)| format!("--{name}:{colour};")).collect();
    // Some programs that draw SVG know no variables: by day there are none.
    let by = |colour: &dyn Fn(&str) -> String| {
        let mut style = include_str!("../graph.css").to_owned();
        for (name, _) in DAY {
            style = style.replace(&format!("var(--{name})"), &colour(name));
        }
        style
    };
    let day = by(&|name| {
        let found = DAY.iter().find(|(known, _)| *known == name);
        found.map_or_else(String::new, |(_, colour)| (*colour).to_owned())
    });
    let dark = include_str!("../graph.css");
    format!("{day}@media (prefers-color-scheme: dark) {{ svg {{ {night} }} {dark} }}")
}

fn px(value: f64) -> String {
    format!("{value:.1}")
}

fn shaped(shape: &Shape) -> Markup {
    let Box { x, y, width, height } = shape.place;
    let kind = match shape.fill {
        Fill::Stripe => "stripe",
        Fill::Band => "band",
        Fill::Life => "life",
        Fill::Beyond => "beyond",
        Fill::Bytes => "bytes",
        Fill::Part => "part",
        Fill::Rounds => "rounds",
    };
    let class = format!("{kind} p{}", shape.part % COLOURS);
    html! { rect class=(class) x=(px(x)) y=(px(y)) width=(px(width)) height=(px(height)) {} }
}

fn marked(mark: &Mark) -> Markup {
    let (x, y) = (px(mark.x), px(mark.y));
    let (left, top, side) = (px(mark.x - MARK), px(mark.y - MARK), px(2.0 * MARK));
    html! {
        g {
            @if !mark.title.is_empty() { title { (mark.title) } }
            @if mark.writes { rect.writes x=(left) y=(top) width=(side) height=(side) {} }
            @if mark.reads && mark.writes { circle.inner cx=(x) cy=(y) r="2.4" {} }
            @if mark.reads && !mark.writes { circle.reads cx=(x) cy=(y) r=(px(MARK - 0.75)) {} }
        }
    }
}

fn set(text: &Text) -> Markup {
    let mut class = match text.tone {
        Tone::Plain => "plain".to_owned(),
        Tone::Quiet => "quiet".to_owned(),
        Tone::Strong => "strong".to_owned(),
        Tone::Part(part) => format!("strong p{}", part % COLOURS),
    };
    if text.size >= LARGE {
        class.push_str(" large");
    }
    let (x, y) = (px(text.x), px(text.y));
    let turn = text.slanted.then(|| format!("rotate(-{ANGLE} {x} {y})"));
    html! {
        text class=(class) x=(x) y=(y) text-anchor=[text.right.then_some("end")] transform=[turn]
            xml:space="preserve" {
            @if !text.title.is_empty() { title { (text.title) } }
            (text.text)
        }
    }
}
