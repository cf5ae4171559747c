//! What a report measured, as the tables of `README.md` and `docs/results.md`.

use std::collections::BTreeSet;

use sglow_results::check::Check;
use sglow_results::frontier::document::{Configuration, Metric, SceneReport};
use sglow_results::frontier::promise::named;

use crate::docs::marks;
use crate::failure::Result;
use crate::picture_error;

/// Columns of the table of errors against facets.
const BARE: [(&str, &str); 6] = [
    ("papers, 1024 lights", named::OLD),
    ("64 flat lights", named::BARE_64),
    ("256", named::BARE_256),
    ("1024", named::BARE_1024),
    ("16384", named::BARE_16384),
    ("cut for each tile", named::BARE),
];

/// Errors against facets by the number of flat lights, and of a cut for each tile: the mark `lights`.
///
/// # Errors
///
/// When the document lacks the mark.
pub fn by_lights(document: &str, name: &str, scenes: &[SceneReport], how: &str) -> Result<String> {
    let mut text = String::new();
    for metric in [Metric::RelativeMse, Metric::Median] {
        let headings = BARE.map(|(heading, _)| heading).join(" | ");
        text.push_str(&format!(
            "| {} | {headings} |\n|---|{}\n",
            metric.title(),
            "---|".repeat(BARE.len())
        ));
        for scene in scenes {
            let cells = BARE.map(|(_, what)| {
                let error =
                    named(scene, what).and_then(|configuration| configuration.unshadowed.as_ref());
                error.map_or("–".to_owned(), |error| picture_error::cell(error, metric))
            });
            text.push_str(&format!("| `{}` | {} |\n", scene.scene, cells.join(" | ")));
        }
        text.push('\n');
    }
    text.push_str(&format!(
        "Measured by `{how}`, without visibility, against the sum over the facets of the map. The papers' emission comes \
         from kernels of K = 1, the flat lights from clusters.\n"
    ));
    marks::replaced(document, name, "lights", &text)
}

fn named<'a>(scene: &'a SceneReport, name: &str) -> Option<&'a Configuration> {
    let name = scene.screening.as_ref()?.named.get(name)?;
    scene.configurations.iter().find(|configuration| configuration.name == *name)
}

/// The frontier of each scene by relative MSE with its default, the papers' configuration, and the checks that fail:
/// the mark `frontier`.
///
/// # Errors
///
/// When the document lacks the mark.
pub fn frontier(
    document: &str,
    name: &str,
    scenes: &[SceneReport],
    checks: &[Check],
    how: &str,
) -> Result<String> {
    let mut text = format!("Measured by `{how}`.\n\n");
    for scene in scenes {
        let headings = picture_error::HEADINGS;
        text.push_str(&format!(
            "`{}`:\n\n| configuration, where it differs from the default | ms | {} | flicker |\n|---|---|{}---|\n",
            scene.scene,
            headings.join(" | "),
            "---|".repeat(headings.len())
        ));
        let printed = named(scene, named::PRINTED).map(|configuration| configuration.name.as_str());
        let shown = |configuration: &&Configuration| {
            configuration.complete && configuration.on_frontier(Metric::RelativeMse)
                || configuration.default
                || Some(configuration.name.as_str()) == printed
        };
        let mut rows: Vec<&Configuration> = scene.configurations.iter().filter(shown).collect();
        let time = |configuration: &Configuration| {
            configuration.whole.unwrap_or(configuration.time).median
        };
        rows.sort_by(|one, other| time(one).total_cmp(&time(other)));
        let mut seen = BTreeSet::new();
        for configuration in
            rows.into_iter().filter(|configuration| seen.insert(&configuration.name))
        {
            let mut label = format!("`{}`", configuration.name);
            if Some(configuration.name.as_str()) == printed {
                label = format!("`--preset {}`", named::PRINTED);
            }
            if let Some(by) = configuration.dominated.get(&Metric::RelativeMse) {
                label.push_str(&format!(" (dominated by `{}`)", by.by));
            }
            let flicker = configuration
                .flicker
                .map_or("–".to_owned(), |one| format!("{:.1} %", 100.0 * one));
            let cells = picture_error::cells(&configuration.picture).join(" | ");
            let ms = time(configuration);
            let decimals = usize::from(ms < 100.0);
            text.push_str(&format!("| {label} | {ms:.decimals$} | {cells} | {flicker} |\n"));
        }
        text.push('\n');
    }
    let failing: Vec<&Check> = checks.iter().filter(|check| !check.holds).collect();
    text.push_str(&format!("{} of {} checks fail:\n\n", failing.len(), checks.len()));
    if !failing.is_empty() {
        text.push_str("| check | measured | bound |\n|---|---|---|\n");
    }
    for check in failing {
        text.push_str(&format!(
            "| {} | {:.4} {} | {} |\n",
            check.name, check.value, check.unit, check.bound
        ));
    }
    marks::replaced(document, name, "frontier", &text)
}

#[cfg(test)]
mod tests {
    use sglow_results::check::Relation;
    use sglow_results::frontier::document::Screening;

    use super::*;
    use crate::page::report::made_up;

    #[test]
    fn tables_have_what_was_measured_and_the_prose_stays() {
        let mut scene = made_up::scenes().remove(0).measured;
        let default =
            scene.configurations.iter().position(|configuration| configuration.default).unwrap();
        let (name, configurations) = (scene.scene.clone(), scene.configurations.len());
        let checks = [
            Check::new("flicker", 1.5, "times", Relation::AtMost, 1.0),
            Check::new("time", 0.5, "", Relation::AtMost, 1.0),
        ];
        let document = "# T\n<!-- frontier: begin -->\nold\n<!-- frontier: end -->\nprose\n";
        let text =
            frontier(document, "T.md", &[scene.clone()], &checks, "cargo xtask report").unwrap();
        assert!(text.contains(&format!("`{name}`:")) && text.ends_with("\nprose\n"), "{text}");
        assert!(
            text.contains("1 of 2 checks fail") && text.contains("| flicker | 1.5000 times | 1 |")
        );
        assert!(!text.contains("| time |") && !text.contains("\nold\n"));
        let rows = text.lines().filter(|line| line.starts_with("| `")).count();
        assert!((2..=configurations).contains(&rows), "{rows} of {configurations}");
        assert!(text.contains(&format!("`{}`", scene.configurations[default].name)));
        // What was not measured is a dash.
        scene.configurations[default].unshadowed = Some(scene.configurations[default].picture);
        let own =
            [(named::BARE_1024.to_owned(), scene.configurations[default].name.clone())].into();
        scene.screening = Some(Screening { single: 0, crossed: 0, axes: Vec::new(), named: own });
        let document = "<!-- lights: begin -->\n<!-- lights: end -->\n";
        let text = by_lights(document, "T.md", &[scene], "cargo xtask report").unwrap();
        let row = text.lines().find(|line| line.starts_with(&format!("| `{name}` |"))).unwrap();
        let cells: Vec<_> = row.split(" | ").collect();
        assert_eq!((cells[1], cells[2], cells[3]), ("–", "–", "–"), "{row}");
        assert!(cells[4] != "–", "{row}");
        for lacking in ["", "<!-- lights: end -->"] {
            assert!(by_lights(lacking, "T.md", &[], "").is_err());
        }
        for own in [include_str!("../../../README.md"), include_str!("../../../docs/results.md")] {
            let written = by_lights(own, "", &[], "").or_else(|_| frontier(own, "", &[], &[], ""));
            assert!(written.is_ok());
        }
    }
}
