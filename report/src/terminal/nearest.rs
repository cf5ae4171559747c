//! The known name that an unknown one is probably a misspelling of.

/// What errors have before the list of known names.
const BEFORE_NAMES: [&str; 6] = [
    "expected one of:",
    "expected one of",
    "known values:",
    "known targets:",
    "known:",
    "scenes are",
];

/// The minimum Jaro-Winkler similarity: one letter added, removed or replaced is above it.
const ALIKE: f64 = 0.85;

/// The known name that is most like the unknown one, if any is. An error quotes the unknown name first and lists the known ones
/// behind `expected one of` or `known:`; one that lists none has none.
#[must_use]
pub fn nearest(error: &str) -> Option<&str> {
    let unknown = error.split(['`', '\'']).nth(1)?;
    let list = |before: &&str| error.split_once(*before).map(|(_, list)| list);
    let list = BEFORE_NAMES.iter().find_map(list)?;
    let names = list.split(|mark: char| mark.is_whitespace() || ",;`'".contains(mark));
    let names = names.filter(|name| !name.is_empty() && *name != unknown);
    let likeness = |name: &&str| strsim::jaro_winkler(name, unknown);
    let found = names.max_by(|one, other| likeness(one).total_cmp(&likeness(other)))?;
    (likeness(&found) >= ALIKE).then_some(found)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_mistyped_name_gets_the_nearest_one() {
        for (error, name) in [
            ("unknown axis 'emiter'; expected one of: density, emitter, draw", "emitter"),
            ("unknown value 'disk' of axis 'emitter'; known values: lobe, cosine, disc", "disc"),
            ("`tokuyoshi2015` is no known preset\n = known: fast, tokuyoshi2016", "tokuyoshi2016"),
            (
                "no scene is named `cornel`; the built-in scenes are atrium, cornell; more",
                "cornell",
            ),
            ("'spriv' for '--target': unknown target `spriv`; known targets: wgsl, spirv", "spirv"),
            ("unknown metric 'rmes'; expected one of relative_mse, rmse, flip", "rmse"),
        ] {
            assert_eq!(nearest(error), Some(name), "{error}");
        }
        // Nothing is like it, or nothing is listed.
        assert_eq!(nearest("unknown axis 'colour'; expected one of: density, draw"), None);
        assert_eq!(nearest("cannot read `colour`"), None);
    }
}
