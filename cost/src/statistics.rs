//! ACO's statistics, as figures.

use crate::cost::Cost;
use crate::error::Error;

/// A statistic's name in the driver, and where its value goes.
type Place = fn(&mut Cost) -> &mut u64;

const WANTED: [(&str, Place); 10] = [
    ("Instructions", |cost| &mut cost.instructions),
    ("Code size", |cost| &mut cost.code_bytes),
    ("VGPRs", |cost| &mut cost.vgprs),
    ("SGPRs", |cost| &mut cost.sgprs),
    ("Spilled VGPRs", |cost| &mut cost.spilled_vgprs),
    ("Spilled SGPRs", |cost| &mut cost.spilled_sgprs),
    ("Scratch size", |cost| &mut cost.scratch_bytes),
    ("LDS size", |cost| &mut cost.lds_bytes),
    ("Subgroups per SIMD", |cost| &mut cost.subgroups_per_simd),
    ("Inverse Throughput", |cost| &mut cost.inverse_throughput),
];

/// What is left out: hashes, parts of other figures, guesses (latency), and what newer versions add.
const LEFT_OUT: [&str; 17] = [
    "Driver pipeline hash",
    "Hash",
    "Copies",
    "Branches",
    "Latency",
    "VMEM Clause",
    "SMEM Clause",
    "Pre-Sched SGPRs",
    "Pre-Sched VGPRs",
    "VALU",
    "SALU",
    "VMEM",
    "SMEM",
    "VOPD",
    "PSGPRs",
    "Combined inputs",
    "Combined outputs",
];

/// A statistic of the driver; no value if it is not a whole number of at least 0.
#[derive(Clone, Debug)]
pub(crate) struct Statistic {
    pub(crate) name: String,
    pub(crate) value: Option<u64>,
}

/// Writes the statistics into `cost`. A name that is unknown here is an error, since it can be a wanted one renamed.
pub(crate) fn fill(cost: &mut Cost, statistics: &[Statistic]) -> Result<(), Error> {
    let wrong = |id: &str, what: String| Error::Statistics {
        id: id.to_owned(),
        what,
        there: statistics.iter().map(|statistic| statistic.name.clone()).collect(),
    };
    for Statistic { name, .. } in statistics {
        let known = WANTED.iter().any(|(wanted, _)| wanted == name);
        if !known && !LEFT_OUT.contains(&name.as_str()) {
            return Err(wrong(&cost.id, format!("have an unknown `{name}`")));
        }
    }
    for (name, place) in WANTED {
        let mut found = statistics.iter().filter(|statistic| statistic.name == name);
        match (found.next().map(|statistic| statistic.value), found.next()) {
            (Some(Some(value)), None) => *place(cost) = value,
            (Some(None), _) => return Err(wrong(&cost.id, format!("have no number as `{name}`"))),
            (Some(_), Some(_)) => return Err(wrong(&cost.id, format!("have `{name}` twice"))),
            (None, _) => return Err(wrong(&cost.id, format!("lack `{name}`"))),
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn all() -> Vec<Statistic> {
        WANTED
            .iter()
            .zip(1..)
            .map(|((name, _), value)| Statistic { name: (*name).to_owned(), value: Some(value) })
            .collect()
    }

    fn error(statistics: &[Statistic]) -> String {
        let mut cost = Cost { id: "x".to_owned(), ..Cost::default() };
        fill(&mut cost, statistics).unwrap_err().to_string()
    }

    #[test]
    fn each_has_its_place() {
        let mut cost = Cost::default();
        fill(&mut cost, &all()).unwrap();
        let mut found = WANTED.map(|(_, place)| *place(&mut cost));
        found.sort_unstable();
        assert_eq!(found, std::array::from_fn(|index| index as u64 + 1));
        assert_eq!((cost.instructions, cost.inverse_throughput, cost.loops), (1, 10, 0));
    }

    #[test]
    fn renamed_missing_and_double_ones_are_named() {
        let mut renamed = all();
        renamed[2].name = "Vector registers".to_owned();
        assert!(error(&renamed).contains("unknown `Vector registers`"));
        assert!(error(&all()[1..]).contains("lack `Instructions`; there are: Code size"));
        let mut double = all();
        double.push(double[0].clone());
        assert!(error(&double).contains("`Instructions` twice"));
        let mut text = all();
        text[0].value = None;
        assert!(error(&text).contains("no number as `Instructions`"));
    }
}
