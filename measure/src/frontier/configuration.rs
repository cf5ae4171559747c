//! A configuration of indirect light: a value on each axis and of each parameter, and what it is called.

use std::collections::{BTreeMap, BTreeSet};

use sglow_runtime::settings::{Settings, SettingsError};

/// The value on each axis that methods are compared by, of those that follow from others as well.
#[must_use]
pub fn axes(settings: &Settings) -> BTreeMap<&'static str, &'static str> {
    let followed = settings.clone().followed();
    Settings::COMPARED.iter().filter_map(|axis| Some((*axis, followed.axis(axis)?))).collect()
}

/// Whether others decide the value on an axis.
fn follows(settings: &Settings, axis: &str) -> bool {
    let with = |value: &&str| {
        let mut other = settings.clone();
        let _ = other.set_axis(axis, value);
        other.followed().axis(axis)
    };
    let mut values = Settings::values(axis).iter().map(with);
    let first = values.next();
    values.all(|value| Some(value) == first)
}

/// The value of each parameter, and of what a library that was laid over this one adds.
pub fn parameters(settings: &Settings) -> impl Iterator<Item = (&str, String)> {
    let own = Settings::PARAMETERS.iter().copied();
    let others = settings.others.iter().filter(|(_, value)| !value.to_string().is_empty());
    own.chain(others.map(|(name, _)| name.as_str()))
        .map(|name| (name, settings.get(name).unwrap_or_default()))
}

/// The value on an axis, or of a parameter; nothing if there is neither.
#[must_use]
pub fn value(settings: &Settings, axis: &str) -> Option<String> {
    let other = settings.others.get(axis).is_some_and(|other| !other.to_string().is_empty());
    let of_axis = axes(settings).get(axis).filter(|_| !other).map(|value| (*value).to_owned());
    of_axis.or_else(|| settings.get(axis))
}

/// Values that one axis or parameter each may have; one that is not named may have any.
pub type Allowed = BTreeMap<String, BTreeSet<String>>;

/// Reads `axis=value`; an axis may be given more than once. `base` knows what a library that was laid over this one
/// adds.
///
/// # Errors
///
/// All that is wrong: an axis or a value that there is not, with those that there are.
pub fn allowed(only: &[String], base: &Settings) -> Result<Allowed, Vec<String>> {
    let mut allowed = Allowed::new();
    let mut wrong = Vec::new();
    for one in only {
        let Some((axis, value)) = one.split_once('=') else {
            wrong.push(format!("`{one}` is not AXIS=VALUE"));
            continue;
        };
        let known = Settings::COMPARED.iter().chain(Settings::PARAMETERS);
        let known = known.map(|name| (*name).to_owned());
        let known: Vec<String> = known.chain(base.others.keys().cloned()).collect();
        if !known.iter().any(|known| known == axis) {
            wrong.push(SettingsError::UnknownAxis { axis: axis.to_owned(), known }.to_string());
        } else if let Err(error) = base.clone().set(axis, value) {
            wrong.push(format!("axis {axis}: {error}"));
        } else {
            allowed.entry(axis.to_owned()).or_default().insert(value.to_owned());
        }
    }
    if wrong.is_empty() { Ok(allowed) } else { Err(wrong) }
}

/// Whether every value is one that its axis may have.
#[must_use]
pub fn fits(settings: &Settings, allowed: &Allowed) -> bool {
    allowed
        .iter()
        .all(|(axis, allowed)| value(settings, axis).is_none_or(|value| allowed.contains(&value)))
}

/// What a configuration is called: the values in which it differs from `base`. `--set` with these alone may give another
/// one, since some defaults do not apply beside values that are set: [`super::case::Case::set`] has them all.
#[must_use]
pub fn name(settings: &Settings, base: &Settings) -> String {
    let (ours, theirs) = (axes(settings), axes(base));
    let differs = |axis: &&str| {
        // What follows from another value is left out.
        ours.get(axis) != theirs.get(axis) && !follows(settings, axis)
    };
    let value = |axis| Some(format!("{axis}={}", ours.get(axis)?));
    let compared = Settings::COMPARED.iter().copied();
    let mut parts: Vec<String> = compared.filter(differs).filter_map(value).collect();
    let numbers = Settings::PARAMETERS.iter().copied();
    let others = settings.others.keys().map(String::as_str);
    for name in numbers.chain(others) {
        let [ours, theirs] = [settings, base].map(|one| self::value(one, name));
        let text = ours.iter().filter(|_| ours != theirs).map(|ours| format!("{name}={ours}"));
        // An axis that has a field is there already if that has changed.
        parts.extend(text.filter(|text| !parts.contains(text)).collect::<Vec<_>>());
    }
    if parts.is_empty() { "default".to_owned() } else { parts.join(",") }
}

#[cfg(test)]
mod tests {
    use sglow_shaders::{Kernel, Solver};

    use super::*;

    #[test]
    fn a_name_has_what_differs() {
        let base = Settings::default();
        assert_eq!(name(&base, &base), "default");
        let few = Settings { lights: 64, size_factor: 0.25, ..base.clone() };
        assert_eq!(name(&few, &base), "lights=64,size_factor=0.25");
        assert!(fits(&few, &allowed(&["lights=64".to_owned()], &base).unwrap()));
        assert!(!fits(&base, &allowed(&["lights=64".to_owned()], &base).unwrap()));
        // The solver follows from the kernel.
        let previous = Settings { kernel: Kernel::Previous, ..base.clone() };
        assert_eq!(name(&previous, &base), "kernel=previous");
        let other = Settings { solver: Solver::Bisection, ..base.clone() };
        assert_eq!(name(&other, &base), "solver=bisection");
    }

    #[test]
    fn what_is_not_an_axis_or_a_value_is_reported_with_what_is() {
        let wrong = ["colour=red", "kernel=cubic", "kernel", "light=spot", "output=rgba16float"];
        let wrong = wrong.map(str::to_owned);
        let text = allowed(&wrong, &Settings::default()).unwrap_err().join("\n");
        let parts = [
            "unknown axis 'colour'",
            "previous, modified",
            "not AXIS=VALUE",
            "unknown axis 'light'",
            "unknown axis 'output'",
        ];
        for part in parts {
            assert!(text.contains(part), "{text}");
        }
        let two = ["kernel=previous", "kernel=modified"].map(str::to_owned);
        let base = Settings::default();
        let allowed = allowed(&two, &base).unwrap();
        assert!(fits(&base, &allowed));
        let one = super::allowed(&two[..1], &base).unwrap();
        assert!(!fits(&base, &one));
    }
}
