//! The table of functions: what each takes, its oracle and its reference. One file per folder of `shaders/src`.

mod asg;
mod brdf;
mod entry;
mod math;
mod sg;
mod vmf;
mod vsgl;

use thiserror::Error;

use crate::function::Function;

/// Every function of the library.
#[must_use]
pub fn all() -> Vec<Function> {
    [
        math::FUNCTIONS,
        sg::FUNCTIONS,
        vmf::FUNCTIONS,
        asg::FUNCTIONS,
        brdf::FUNCTIONS,
        vsgl::FUNCTIONS,
    ]
    .concat()
}

/// A function that there is not.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("no function '{}'; known: {}", unknown.join("', '"), known.join(", "))]
pub struct UnknownFunction {
    /// The given names.
    pub unknown: Vec<String>,
    /// The functions that there are.
    pub known: Vec<&'static str>,
}

/// The requested functions: all, or those of these names.
///
/// # Errors
///
/// Every name that no function has, with the known ones.
pub fn chosen(only: &[String]) -> Result<Vec<Function>, UnknownFunction> {
    let mut all = all();
    let known: Vec<&str> = all.iter().map(|function| function.name).collect();
    let is_known = |name: &&String| known.contains(&name.as_str());
    let unknown: Vec<String> = only.iter().filter(|name| !is_known(name)).cloned().collect();
    if !unknown.is_empty() {
        return Err(UnknownFunction { unknown, known });
    }
    all.retain(|one| only.is_empty() || only.iter().any(|name| name == one.name));
    Ok(all)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn functions_are_chosen_by_name_and_unknown_ones_are_reported_with_those_that_are_known() {
        assert_eq!(chosen(&[]).unwrap().len(), all().len());
        let one = chosen(&["sg_integral".to_owned()]).unwrap();
        assert_eq!(one.iter().map(|function| function.name).collect::<Vec<_>>(), ["sg_integral"]);
        let wrong = ["sg_integral", "sg_colour", "light"].map(str::to_owned);
        let text = chosen(&wrong).unwrap_err().to_string();
        assert!(text.contains("'sg_colour', 'light'") && text.contains("sg_evaluate"), "{text}");
    }
}
