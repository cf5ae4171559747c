//! The page of the papers' tables and figures.

use maud::{Markup, html};
use sglow_results::reproduction::{DOES_NOT_SHOW, Figure, Findings, TimeTable};
use sglow_results::rivals::method::Method;
use sglow_results::rivals::stages::Stages;
use sglow_results::rivals::survey::Row;

use crate::json::Report;
use crate::page::frame::{Section, page as whole};
use crate::page::number::figure as digits;
use crate::page::table::{mark, number, table, text};
use crate::picture_error::{HEADINGS, cells};

/// Stages of [Tokuyoshi 2016, Tab. 1, Tab. 2] in milliseconds on a GeForce GTX 970: table, method, map (the camera's is
/// the upper row), stage as we call it, time.
const PAPER: [(&str, Method, bool, &str, f64); 48] = [
    ("Table 1", Method::Previous, true, "moments", 0.816),
    ("Table 1", Method::Previous, true, "mip moments", 0.968),
    ("Table 1", Method::Previous, true, "sample", 0.090),
    ("Table 1", Method::Previous, false, "moments", 0.165),
    ("Table 1", Method::Previous, false, "mip moments", 0.201),
    ("Table 1", Method::Previous, false, "sample", 0.084),
    ("Table 1", Method::Modified, true, "moments", 0.816),
    ("Table 1", Method::Modified, true, "mip moments", 0.968),
    ("Table 1", Method::Modified, true, "sample", 0.092),
    ("Table 1", Method::Modified, false, "moments", 0.165),
    ("Table 1", Method::Modified, false, "mip moments", 0.201),
    ("Table 1", Method::Modified, false, "sample", 0.088),
    ("Table 1", Method::Image, true, "cluster assignment", 3.004),
    ("Table 1", Method::Image, true, "cluster sort", 1.541),
    ("Table 1", Method::Image, true, "cluster sum", 9.096),
    ("Table 1", Method::Image, false, "cluster assignment", 0.619),
    ("Table 1", Method::Image, false, "cluster sort", 0.306),
    ("Table 1", Method::Image, false, "cluster sum", 1.995),
    ("Table 1", Method::World, true, "cluster assignment", 5.009),
    ("Table 1", Method::World, true, "cluster sort", 1.517),
    ("Table 1", Method::World, true, "cluster sum", 9.856),
    ("Table 1", Method::World, false, "cluster assignment", 0.860),
    ("Table 1", Method::World, false, "cluster sort", 0.299),
    ("Table 1", Method::World, false, "cluster sum", 4.231),
    ("Table 2", Method::Previous, true, "moments", 0.752),
    ("Table 2", Method::Previous, true, "mip moments", 0.985),
    ("Table 2", Method::Previous, true, "sample", 0.087),
    ("Table 2", Method::Previous, false, "moments", 0.154),
    ("Table 2", Method::Previous, false, "mip moments", 0.199),
    ("Table 2", Method::Previous, false, "sample", 0.065),
    ("Table 2", Method::Modified, true, "moments", 0.752),
    ("Table 2", Method::Modified, true, "mip moments", 0.985),
    ("Table 2", Method::Modified, true, "sample", 0.089),
    ("Table 2", Method::Modified, false, "moments", 0.154),
    ("Table 2", Method::Modified, false, "mip moments", 0.199),
    ("Table 2", Method::Modified, false, "sample", 0.067),
    ("Table 2", Method::Image, true, "cluster assignment", 3.262),
    ("Table 2", Method::Image, true, "cluster sort", 1.523),
    ("Table 2", Method::Image, true, "cluster sum", 8.850),
    ("Table 2", Method::Image, false, "cluster assignment", 1.172),
    ("Table 2", Method::Image, false, "cluster sort", 0.306),
    ("Table 2", Method::Image, false, "cluster sum", 5.275),
    ("Table 2", Method::World, true, "cluster assignment", 5.756),
    ("Table 2", Method::World, true, "cluster sort", 1.499),
    ("Table 2", Method::World, true, "cluster sum", 8.735),
    ("Table 2", Method::World, false, "cluster assignment", 0.899),
    ("Table 2", Method::World, false, "cluster sort", 0.305),
    ("Table 2", Method::World, false, "cluster sum", 20.489),
];

/// [Tokuyoshi 2016, Tab. 3]: shaders, dispatches, lines.
fn paper_code(method: Method) -> Option<[usize; 3]> {
    match method {
        Method::Previous => Some([2, 2, 222]),
        Method::Modified => Some([2, 2, 232]),
        Method::Image => Some([9, 39, 1143]),
        Method::World => Some([9, 39, 1172]),
        Method::Bracketed | Method::Metropolis => None,
    }
}

fn paper_time(table: &str, method: Method, camera: bool, stage: &str) -> Option<f64> {
    let wanted = (table, method, camera, stage);
    PAPER.iter().find(|one| (one.0, one.1, one.2, one.3) == wanted).map(|one| one.4)
}

/// The sum of all stages of a method in one of the paper's tables, in milliseconds.
pub fn paper_total(table: &str, method: Method) -> Option<f64> {
    let stages = PAPER.iter().filter(|one| (one.0, one.1) == (table, method));
    stages.map(|one| one.4).reduce(|sum, one| sum + one)
}

/// The page.
pub fn page(found: &Findings, report: &Report) -> String {
    let mut sections = Vec::new();
    if !found.requested.is_empty() {
        sections.push(Section {
            id: "requested",
            title: "What was requested",
            body: requested(found),
        });
    }
    sections.push(Section { id: "figures", title: "Figures", body: figures(&found.figures) });
    sections.push(Section { id: "times", title: "Times of each stage", body: times(&found.times) });
    if !found.code.is_empty() {
        sections.push(Section {
            id: "code",
            title: "Table 3: size of the code",
            body: code(found),
        });
        sections.push(Section {
            id: "sampling",
            title: "The sampling pass and the mips",
            body: sampling(found),
        });
    }
    sections.push(Section {
        id: "overlaps",
        title: "Overlaps, gaps and error",
        body: surveys(found),
    });
    sections.push(Section { id: "flicker", title: "Flicker", body: flickers(found) });
    sections.push(Section {
        id: "limits",
        title: "What this does not show",
        body: html! { ul { @for line in DOES_NOT_SHOW { li { (line) } } } },
    });
    whole("sglow: Tokuyoshi 2016 reproduced", &lead(found, report), &sections)
}

fn lead(found: &Findings, report: &Report) -> Markup {
    let versions: Vec<String> =
        report.versions.iter().map(|(name, version)| format!("{name} {version}")).collect();
    let met = found.requested.iter().filter(|one| one.met).count();
    html! {
        p {
            "Modified filtered importance sampling against its rivals on its own pipeline: ours beside the numbers of "
            "Y. Tokuyoshi, Modified filtered importance sampling for virtual spherical Gaussian lights, Computational "
            "Visual Media 2(4), 2016, which were measured on a GeForce GTX 970."
        }
        @if !found.requested.is_empty() {
            p { strong { (met) " of " (found.requested.len()) } " requested numbers are met here." }
        }
        dl.facts {
            dt { "adapter" } dd { (report.adapter) }
            dt { "driver" } dd { (report.driver) }
            dt { "versions" } dd { (versions.join(", ")) }
            dt { "date" } dd { (report.date) }
            dt { "command" } dd { code { (report.command) } }
        }
    }
}

fn requested(found: &Findings) -> Markup {
    let rows: Vec<Markup> = found
        .requested
        .iter()
        .map(|one| {
            html! {
                tr {
                    td { (one.name) }
                    td.n { (digits(one.value)) }
                    td.n { (one.relation.sign()) " " (digits(one.bound)) }
                    td { (mark(one.met)) }
                    td { (one.note) }
                }
            }
        })
        .collect();
    let columns =
        [text("number"), number("measured"), number("requested"), text("verdict"), text("on what")];
    table("Requested numbers", "", &columns, &rows)
}

fn figures(figures: &[Figure]) -> Markup {
    html! {
        @for one in figures {
            h3 { (one.name) }
            p { (one.about) }
            div.figures {
                @for picture in &one.pictures {
                    figure {
                        a href=(picture.file) {
                            img src=(picture.file) alt={ (one.name) ": " (picture.name) } loading="lazy";
                        }
                        figcaption {
                            (picture.name)
                            @if let Some(error) = &picture.error {
                                @for (name, error) in HEADINGS.iter().zip(cells(error)) {
                                    "; " (name) " " (error)
                                }
                            }
                        }
                    }
                }
            }
            @if let Some(error) = one.standard_error {
                p.quiet {
                    "Errors are those of indirect light against paths with exact visibility, whose own standard error is "
                    (digits(100.0 * error)) " % of the mean per pixel."
                }
            }
        }
    }
}

fn times(tables: &[TimeTable]) -> Markup {
    html! {
        p {
            "Median milliseconds with their spread, all methods in turns in one run. The density and its mips, which all "
            "methods share, are left out, as in the paper."
        }
        @for one in tables {
            h3 { (one.name) ": " (one.scene) ", density " (one.density) }
            @let rows: Vec<Markup> = one.methods.iter().flat_map(|method| stage_rows(one.name, method)).collect();
            (table(
                one.name,
                "",
                &[text("method"), text("map"), text("stage"), number("ms"), number("spread"), number("dispatches"), number("paper, ms")],
                &rows,
            ))
        }
    }
}

fn stage_rows(name: &str, one: &Stages) -> Vec<Markup> {
    let dash = || "–".to_owned();
    let mut rows: Vec<Markup> = one
        .stages
        .iter()
        .map(|stage| {
            let paper = paper_time(name, one.method, stage.camera, stage.name);
            html! {
                tr {
                    td { (one.method.name()) }
                    td { (if stage.camera { "camera" } else { "light" }) }
                    td { (stage.name) }
                    td.n { (digits(stage.time.median)) }
                    td.n { (digits(stage.time.minimum)) " to " (digits(stage.time.maximum)) }
                    td.n { (stage.dispatches) }
                    td.n { (paper.map_or_else(dash, |time| format!("{time:.3}"))) }
                }
            }
        })
        .collect();
    let total = paper_total(name, one.method);
    rows.push(html! {
        tr {
            td { strong { (one.method.name()) } }
            td { "both" }
            td { strong { "total" } }
            td.n { strong { (digits(one.total(None))) } }
            td {} td {}
            td.n { (total.map_or_else(dash, |time| format!("{time:.3}"))) }
        }
    });
    rows
}

fn code(found: &Findings) -> Markup {
    let rows: Vec<Markup> = found
        .code
        .iter()
        .map(|one| {
            let paper = paper_code(one.method).map_or_else(
                || "–".to_owned(),
                |[shaders, dispatches, lines]| format!("{shaders}, {dispatches}, {lines}"),
            );
            let counted = found.dispatches.iter().find(|dispatches| dispatches.0 == one.method);
            html! {
                tr {
                    td { (one.method.name()) }
                    td.n { (one.shaders.len()) }
                    td.n { @if let Some(counted) = counted { (counted.1) } @else { "–" } }
                    td.n { (one.lines[0]) }
                    td.n { (one.mips.len()) }
                    td.n { @if let Some(counted) = counted { (counted.2) } @else { "–" } }
                    td.n { (one.lines[1]) }
                    td.n { (paper) }
                }
            }
        })
        .collect();
    html! {
        p {
            "Of one map, from the textures of its surfaces to the lights. Lines are those of the generated WGSL, without "
            "blank lines and comments; each shader is whole, so that a function which two of them use counts twice, and "
            "what the host does is not counted. The paper counts C++ and HLSL, and leaves its mips to the graphics API."
        }
        (table(
            "Size of the code",
            "",
            &[text("method"), number("shaders"), number("dispatches"), number("lines"), number("mip shaders"), number("mip dispatches"), number("mip lines"), number("paper: shaders, dispatches, lines")],
            &rows,
        ))
    }
}

fn sampling(found: &Findings) -> Markup {
    let rows: Vec<Markup> = found
        .sampling
        .iter()
        .map(|(name, [bisection, bracketed])| {
            html! { tr { td { (name) } td.n { (digits(*bisection)) } td.n { (digits(*bracketed)) } } }
        })
        .collect();
    let mips: Vec<Markup> = found
        .mips
        .iter()
        .map(|row| {
            html! {
                tr {
                    td { (row.name) }
                    td.n { (digits(row.mips)) }
                    td.n { (digits(row.copy)) }
                    td.n { (digits(row.ratio)) }
                }
            }
        })
        .collect();
    html! {
        p { "The time of the sampling pass over that of previous kernels; on the paper's GPU modified is 1.02 to 1.05." }
        (table("Sampling pass", "", &[text("density"), number("12 bisections"), number("bracketed")], &rows))
        p { "A mip chain against a copy of the same bytes, all levels and layers, by the queue." }
        (table("Mip chains", "", &[text("chain"), number("mips, ms"), number("copy, ms"), number("ratio")], &mips))
    }
}

/// What kernels cost by the texels that they put together, in words.
fn straddling(rows: &[Row]) -> Option<String> {
    let own = rows.iter().find(|row| row.method == Method::Bracketed && row.size_factor == 1.0)?;
    let floor = own.floor?;
    Some(format!(
        "Modified kernels, K = 1: the relative MSE of the lights is {}, that of their texels summed exactly {}. The \
         second is what kernels cost by where they lie and how large they are; the rest is the form of a light, which \
         knows only the mean of what its kernel holds, across edges of depth and of normals.",
        digits(own.relative_mse),
        digits(floor.relative_mse)
    ))
}

fn surveys(found: &Findings) -> Markup {
    html! {
        p {
            "Nominal: kernels as squares of 4^level texels. Variation is the coefficient of variation of the density's "
            "integral within each square or cluster; gaps are the share of the density that lies in none; covered is the "
            "sum of all integrals over the whole. By weights: kernels as the filter sums them. Gaps are the share of the "
            "density that is not counted, excess what is counted beyond once, sharing the number of kernels that share a "
            "texel, width the variance of a kernel over that of its nominal square. Power is that of all lights over that "
            "of the photons, brightest the brightest light's times their number. Errors are against a sum over all texels "
            "of the map, both without visibility, on a sample of pixels: RMSE and bias over the mean, relative MSE, and "
            "the median of the relative error. Floor: the relative MSE and the median when each light is replaced by the "
            "texels of its kernel, summed exactly with their weights."
        }
        @for surveyed in &found.surveys {
            h3 { (surveyed.scene) ", density " (surveyed.density) }
            @if surveyed.found.dark {
                p { "The light reaches nothing: indirect light is black by every method." }
            }
            @if let Some(line) = straddling(&surveyed.found.rows) { p { (line) } }
            @let rows: Vec<Markup> = surveyed.found.rows.iter().map(|row| html! {
                tr {
                    td { (row.method.name()) }
                    td.n { (row.size_factor) }
                    td.n { (digits(row.overlap.variation)) }
                    td.n { (digits(row.overlap.gaps)) }
                    td.n { (digits(row.overlap.covered)) }
                    td.n { (digits(row.weighted.gaps)) }
                    td.n { (digits(row.weighted.excess)) }
                    td.n { (digits(row.weighted.sharing)) }
                    td.n { (digits(row.weighted.widening)) }
                    td.n { (digits(row.power)) }
                    td.n { (digits(row.brightest)) }
                    td.n { (digits(row.relative_mse)) }
                    td.n { (digits(row.error)) }
                    td.n { (digits(row.median)) }
                    td.n { (digits(row.q95)) }
                    td.n { (digits(row.bias)) }
                    td.n { (row.floor.map_or_else(|| "–".to_owned(), |floor| digits(floor.relative_mse))) }
                    td.n { (row.floor.map_or_else(|| "–".to_owned(), |floor| digits(floor.median))) }
                }
            }).collect();
            (table(
                &surveyed.scene,
                "",
                &[text("method"), number("K"), number("variation, nominal"), number("gaps, nominal"), number("covered, nominal"), number("gaps, by weights"), number("excess, by weights"), number("sharing"), number("width"), number("power"), number("brightest × N"), number("relMSE"), number("RMSE"), number("median"), number("95 %"), number("bias"), number("floor, relMSE"), number("floor, median")],
                &rows,
            ))
        }
    }
}

fn flickers(found: &Findings) -> Markup {
    html! {
        p {
            "A light that moves a little from frame to frame. Flicker is the root mean square of the difference between a "
            "method's change from one frame to the next and the reference's own, over the reference's mean; error is the "
            "RMSE over the same."
        }
        @for (scene, flickers) in &found.flickers {
            h3 { (scene) }
            p.quiet {
                (flickers.walk.frames) " frames, " (flickers.walk.pixels) " pixels, " (flickers.walk.samples)
                " paths for each; the reference changes by " (digits(flickers.reference_change)) " a frame."
            }
            @let rows: Vec<Markup> = flickers.contenders.iter().map(|one| html! {
                tr {
                    td { (one.name) }
                    td.n { (digits(one.error)) }
                    td.n { (digits(one.flicker)) }
                    td.n { (digits(one.worst)) }
                    td.n { (digits(one.change)) }
                }
            }).collect();
            (table(scene, "", &[text("method"), number("error"), number("flicker"), number("worst pair"), number("own change")], &rows))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_papers_totals_are_the_papers() {
        // [Tokuyoshi 2016, Tab. 1, Tab. 2], as printed; parts are rounded to a microsecond.
        for (table, method, total) in [
            ("Table 1", Method::Previous, 2.324),
            ("Table 1", Method::Modified, 2.330),
            ("Table 1", Method::Image, 16.561),
            ("Table 1", Method::World, 21.772),
            ("Table 2", Method::Previous, 2.242),
            ("Table 2", Method::Modified, 2.246),
            ("Table 2", Method::Image, 20.388),
            ("Table 2", Method::World, 37.683),
        ] {
            let sum = paper_total(table, method).unwrap();
            assert!((sum - total).abs() < 2.5e-3, "{table}, {method:?}: {sum}");
        }
        assert_eq!(paper_total("Table 4", Method::World), None);
    }

    #[test]
    fn an_empty_run_makes_a_page() {
        let page = page(&Findings::default(), &Report::new());
        assert!(page.contains("What this does not show") && !page.contains("What was requested"));
    }
}
