//! The page around what a command shows: head, colours for day and night, a list of its sections.

use maud::{DOCTYPE, Markup, PreEscaped, html};

/// A part of a page.
pub struct Section<'a> {
    /// What links to it.
    pub id: &'a str,
    /// Its heading.
    pub title: &'a str,
    /// What is below it.
    pub body: Markup,
}

/// Colours by day; every one has a contrast of at least 4.5 to the paper where text is set in it.
pub const DAY: &[(&str, &str)] = &[
    ("paper", "#ffffff"),
    ("ink", "#1b1b1b"),
    ("quiet", "#5c5c5c"),
    ("line", "#d6d6d6"),
    ("band", "#f3f3f1"),
    ("good", "#00658a"),
    ("bad", "#b13c00"),
    ("s0", "#005fa8"),
    ("s1", "#00785a"),
    ("s2", "#8a4a9e"),
    ("s3", "#8a6a00"),
    ("s4", "#46566b"),
    ("s5", "#c2317a"),
    ("s6", "#3a7d1e"),
    ("s7", "#6b4a2a"),
    ("h0", "#f1f6fb"),
    ("h1", "#d3e4f3"),
    ("h2", "#a5c8e6"),
    ("h3", "#f6b678"),
    ("h3-ink", "#1b1b1b"),
    ("h4", "#dd6a1f"),
    ("h4-ink", "#000000"),
    ("h5", "#7f1d00"),
    ("h5-ink", "#ffffff"),
];

/// Colours by night.
pub const NIGHT: &[(&str, &str)] = &[
    ("paper", "#16181b"),
    ("ink", "#e8e8e6"),
    ("quiet", "#a3a7ad"),
    ("line", "#3a3e44"),
    ("band", "#22262b"),
    ("good", "#6cc3ea"),
    ("bad", "#ff9a5c"),
    ("s0", "#6db4f2"),
    ("s1", "#4fd0a5"),
    ("s2", "#cf9ae0"),
    ("s3", "#e0c04a"),
    ("s4", "#a9bad0"),
    ("s5", "#ff8fc0"),
    ("s6", "#9adf6f"),
    ("s7", "#d8b48e"),
    ("h0", "#1b222a"),
    ("h1", "#1f3448"),
    ("h2", "#28507a"),
    ("h3", "#8a5416"),
    ("h3-ink", "#ffffff"),
    ("h4", "#d9731f"),
    ("h4-ink", "#000000"),
    ("h5", "#ffc9a3"),
    ("h5-ink", "#000000"),
];

fn variables(colours: &[(&str, &str)]) -> String {
    colours.iter().map(|(name, colour)| format!("--{name}:{colour};")).collect()
}

/// What a page has beyond the common style: both are raw text to a browser, so they must not hold `</`.
#[derive(Clone, Copy, Debug, Default)]
pub struct Extras<'a> {
    /// More style.
    pub style: &'a str,
    /// A script, without which the page has to be whole too.
    pub script: &'a str,
}

/// What a browser lets a page with a script do: nothing but what lies in the page.
const POLICY: &str =
    "default-src 'none'; style-src 'unsafe-inline'; script-src 'unsafe-inline'; img-src data:";

/// A whole page. `lead` stands above the list of sections.
pub fn page(title: &str, lead: &Markup, sections: &[Section<'_>]) -> String {
    page_with(title, lead, sections, Extras::default())
}

/// The same with a style and a script of its own, and shut off from everything else.
pub fn page_with(
    title: &str,
    lead: &Markup,
    sections: &[Section<'_>],
    extras: Extras<'_>,
) -> String {
    // Paper is white whatever the screen is.
    let style = format!(
        ":root{{color-scheme:light dark;{}}}\n\
         @media screen and (prefers-color-scheme: dark){{:root{{{}}}}}\n{}{}{}",
        variables(DAY),
        variables(NIGHT),
        include_str!("style.css"),
        include_str!("plot.css"),
        extras.style,
    );
    let page = html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                @if !extras.script.is_empty() {
                    meta http-equiv="Content-Security-Policy" content=(POLICY);
                }
                title { (title) }
                // A style sheet is raw text to a browser; ours has no `</`.
                style { (PreEscaped(style)) }
            }
            body {
                header {
                    h1 { (title) }
                    (lead)
                    nav aria-label="Sections" {
                        ul {
                            @for section in sections {
                                li { a href={ "#" (section.id) } { (section.title) } }
                            }
                        }
                    }
                }
                main {
                    @for section in sections {
                        section id=(section.id) {
                            h2 { (section.title) }
                            (section.body)
                        }
                    }
                }
                @if !extras.script.is_empty() { script { (PreEscaped(extras.script)) } }
            }
        }
    };
    page.into_string()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_others_wrote_is_text() {
        let section =
            Section { id: "one", title: "<b>&", body: html! { p { ("</p><script>alert(1)") } } };
        let page = page("\"quoted\" <title>", &html! {}, &[section]);
        assert!(!page.contains("<script") && !page.contains("<b>"), "{page}");
        assert!(page.contains("&lt;b&gt;&amp;") && page.contains("href=\"#one\""));
        assert!(page.contains("&lt;title&gt;"));
    }

    #[test]
    fn a_page_needs_nothing_from_elsewhere() {
        let page = page("nothing", &html! {}, &[]);
        for word in ["http:", "https:", "@import", "url(", "<link", "src="] {
            assert!(!page.contains(word), "{word}");
        }
        assert!(!page.contains("<script") && !page.contains("Content-Security-Policy"));
        let extras = Extras { style: "p{}", script: "let one = 1 < 2;" };
        let scripted = page_with("nothing", &html! {}, &[], extras);
        assert!(scripted.contains("<script>let one = 1 < 2;</script>"), "{scripted}");
        assert!(
            scripted.contains("default-src &#39;none&#39;")
                || scripted.contains("default-src 'none'")
        );
    }

    /// Relative luminance. [WCAG 2.1, relative luminance]
    fn luminance(colour: &str) -> f64 {
        let part = |at: usize| {
            let part = f64::from(u8::from_str_radix(&colour[at..at + 2], 16).unwrap()) / 255.0;
            if part <= 0.039_28 { part / 12.92 } else { ((part + 0.055) / 1.055).powf(2.4) }
        };
        0.2126 * part(1) + 0.7152 * part(3) + 0.0722 * part(5)
    }

    fn contrast(colours: &[(&str, &str)], one: &str, other: &str) -> f64 {
        let of = |name| luminance(colours.iter().find(|colour| colour.0 == name).unwrap().1);
        let (one, other) = (of(one), of(other));
        (one.max(other) + 0.05) / (one.min(other) + 0.05)
    }

    #[test]
    fn text_can_be_read_by_day_and_by_night() {
        for colours in [DAY, NIGHT] {
            assert_eq!(
                colours.iter().map(|colour| colour.0).collect::<Vec<_>>(),
                DAY.iter().map(|colour| colour.0).collect::<Vec<_>>()
            );
            for (text, paper) in [
                ("ink", "paper"),
                ("quiet", "paper"),
                ("good", "paper"),
                ("bad", "paper"),
                ("s0", "paper"),
                ("ink", "band"),
                ("ink", "h0"),
                ("ink", "h1"),
                ("ink", "h2"),
                ("h3-ink", "h3"),
                ("h4-ink", "h4"),
                ("h5-ink", "h5"),
            ] {
                assert!(contrast(colours, text, paper) >= 4.5, "{text} on {paper}");
            }
        }
        for colours in [DAY, NIGHT] {
            for part in ["s0", "s1", "s2", "s3", "s4", "s5", "s6", "s7"] {
                assert!(contrast(colours, part, "paper") >= 4.5, "{part}: letters stand in it");
            }
        }
        assert!(contrast(DAY, "line", "paper") < 4.5, "a colour that is too pale is seen to be");
    }
}
