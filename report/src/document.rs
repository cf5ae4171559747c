//! `report.json` as a whole, and its schema.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use schemars::JsonSchema;
use serde::Serialize;
use sglow_results::densities::OnDensity;
use sglow_results::frontier::document::SceneReport;
use sglow_results::static_cost::StaticCost;

use crate::docs::deviations::Deviation;
use crate::failure::Result;
use crate::json::Report;
use crate::page::report::LeftOut;
use crate::write;

/// The form of the file; it grows when a reader of the form before would misread it.
pub const VERSION: u32 = 6;

/// What `report` found: error against run time of every configuration of each scene's indirect light.
#[derive(Serialize, JsonSchema)]
pub struct Document<'a> {
    /// The form of this file.
    pub schema_version: u32,
    /// What every command reports.
    #[serde(flatten)]
    pub report: &'a Report,
    /// Each scene.
    pub scenes: Vec<SceneReport>,
    /// What the package of each scene has not, and what that saves.
    pub left_out: BTreeMap<String, Vec<LeftOut>>,
    /// What each deviation from the papers is worth: the default beside the same with one value as printed.
    pub deviations: Vec<Deviation>,
    /// Densities that stress the sampling pass.
    pub densities: Vec<OnDensity>,
    /// What compilers of GPUs make of the shading passes, without a GPU.
    pub static_costs: Vec<StaticCost>,
    /// What must not be concluded.
    pub does_not_show: Vec<String>,
}

impl Document<'_> {
    /// Writes the page, the numbers and what they mean into a folder, all or none, and returns the places of page and
    /// numbers.
    ///
    /// # Errors
    ///
    /// When a file cannot be written.
    pub fn write(&self, folder: &Path, page: &str) -> Result<[PathBuf; 2]> {
        let [index, json, schema] =
            ["index.html", "report.json", "report.schema.json"].map(|name| folder.join(name));
        write::texts(&[
            (&index, page),
            (&json, &(serde_json::to_string_pretty(self)? + "\n")),
            (&schema, &(self::schema()? + "\n")),
        ])?;
        Ok([index, json])
    }
}

/// The JSON schema of [`Document`].
pub fn schema() -> Result<String> {
    Ok(serde_json::to_string_pretty(&schemars::schema_for!(Document<'_>))?)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::page::report::made_up;

    #[test]
    fn the_published_schema_is_that_of_the_file() {
        let published = include_str!("../../docs/report.schema.json");
        let hint = "cargo xtask report --schema > docs/report.schema.json";
        assert_eq!(published.trim_end(), schema().unwrap(), "{hint}");
    }

    #[test]
    fn a_report_has_the_form_that_its_schema_says() {
        let mut report = Report::new();
        report.check(sglow_results::check::Check::new(
            "odd",
            f64::NAN,
            "ULP",
            sglow_results::check::Relation::AtMost,
            1.0,
        ));
        let document = Document {
            schema_version: VERSION,
            report: &report,
            scenes: made_up::scenes().into_iter().map(|scene| scene.measured).collect(),
            left_out: BTreeMap::new(),
            deviations: Vec::new(),
            densities: Vec::new(),
            static_costs: Vec::new(),
            does_not_show: Vec::new(),
        };
        let value = serde_json::to_value(&document).unwrap();
        let schema = serde_json::from_str(&schema().unwrap()).unwrap();
        let validator = jsonschema::validator_for(&schema).unwrap();
        let errors: Vec<String> =
            validator.iter_errors(&value).map(|error| error.to_string()).collect();
        assert!(errors.is_empty(), "{errors:#?}");
        let mut wrong = value;
        wrong["scenes"][0]["configurations"][0]["time"]["median"] = "fast".into();
        assert!(!validator.is_valid(&wrong));
    }
}
