//! Each configuration of the frontier beside the reference, and where a person sees the difference.

use std::collections::BTreeMap;

use image::RgbImage;
use maud::{Markup, html};
use sglow_results::frontier::document::{Configuration, Radiance};

use crate::failure::Result;
use crate::page::number::figure;
use crate::page::report::named::Named;
use crate::picture::tone::{Exposure, radiance};
use crate::picture::{Image, false_colour, png};
use crate::picture_error;

pub(crate) fn section(named: &Named<'_>) -> Markup {
    let pictures = named.scene.pictures;
    let reference = match image(named, &pictures.reference) {
        Ok(reference) => reference,
        Err(why) => return html! { p.quiet { "There is no picture of the reference: " (why) } },
    };
    let exposure = Exposure::automatic(reference.pixels());
    let top = scale_end(named.scene.flip);
    let reference = png::data(&radiance(&reference, exposure));
    html! {
        p.quiet {
            "Whole pictures, direct light and all, with one exposure (" (figure(f64::from(exposure.stops()))) " stops); magenta is not finite. "
            "The right-hand map is FLIP: how much a person sees who switches between both."
        }
        (legend("FLIP 0", &html! { (top) @if top < 1.0 { " of 1" } }))
        div.strip {
            @for configuration in named.shown() {
                (strip(named, configuration, &reference, exposure, top))
            }
        }
    }
}

fn image(named: &Named<'_>, pixels: &Radiance) -> Result<Image> {
    let [width, height] = named.scene.measured.size;
    Ok(Image::new(width as usize, height as usize, pixels.clone())?)
}

/// The end of the colour scale: a round number at or above the greatest of all maps, the same for all.
fn scale_end(maps: &BTreeMap<String, Vec<f32>>) -> f32 {
    let most =
        maps.values().flatten().copied().filter(|value| value.is_finite()).fold(0.0, f32::max);
    [0.05, 0.1, 0.2, 0.5].into_iter().find(|end| most <= *end).unwrap_or(1.0)
}

/// The scale of a map in false colours, from 0 to its end.
pub(crate) fn legend(zero: &str, end: &Markup) -> Markup {
    let stops: Vec<String> = (0..=8_u8)
        .map(|step| {
            let [r, g, b] = false_colour::colour(f64::from(step) / 8.0);
            format!("#{r:02x}{g:02x}{b:02x}")
        })
        .collect();
    html! {
        div.scale {
            span { (zero) }
            span.ramp role="img" aria-label="from black over purple to pale yellow" style={ "background:linear-gradient(90deg," (stops.join(",")) ")" } {}
            span { (end) }
        }
    }
}

fn strip<'a>(
    named: &Named<'a>,
    configuration: &'a Configuration,
    reference: &Result<String>,
    exposure: Exposure,
    top: f32,
) -> Markup {
    let pictures = named.scene.pictures;
    let ours = pictures
        .configurations
        .get(&configuration.name)
        .map(|pixels| image(named, pixels).and_then(|ours| png::data(&radiance(&ours, exposure))));
    let [width, height] = named.scene.measured.size;
    let flip = named.scene.flip.get(&configuration.name).map(|values| {
        false_colour::map(width, height, values, top).and_then(|map: RgbImage| png::data(&map))
    });
    let name = named.line(configuration);
    html! {
        figure.compare {
            figcaption {
                (named.call(configuration)) br;
                span.quiet {
                    @for (name, error) in picture_error::HEADINGS.iter().zip(picture_error::cells(&configuration.picture)) { (name) " " (error.replace(' ', "\u{a0}")) ", " }
                    (figure(configuration.time.median)) " ms"
                }
            }
            div.both {
                div {
                    div.pair style="--at:50%" {
                        (picture("this configuration", &name, width, height, ours.as_ref().map(Result::as_ref)))
                        (picture("reference", "reference", width, height, Some(reference.as_ref())))
                    }
                    input.slide hidden type="range" min="0" max="100" step="0.5" value="50" aria-label={ "Share of the picture that shows " (name) "; the rest shows the reference" };
                }
                (picture("FLIP", &format!("FLIP map of {name}"), width, height, flip.as_ref().map(Result::as_ref)))
            }
        }
    }
}

/// A picture, or why there is none.
pub(crate) fn picture(
    label: &str,
    says: &str,
    width: u32,
    height: u32,
    data: Option<Result<&String, &crate::failure::Failure>>,
) -> Markup {
    html! {
        div.view {
            @match data {
                Some(Ok(data)) => img src=(data) alt=(says) width=(width) height=(height);
                Some(Err(why)) => p.quiet { "no picture: " (why) }
                None => p.quiet { "no picture was kept" }
            }
            span.of { (label) }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_scale_holds_every_map() {
        let map = |most: f32| BTreeMap::from([("a".to_owned(), vec![0.0, most, f32::NAN])]);
        for (most, end) in [(0.0, 0.05), (0.05, 0.05), (0.06, 0.1), (0.3, 0.5), (0.7, 1.0)] {
            assert_eq!(scale_end(&map(most)), end);
        }
    }
}
