//! Where a step stands that is laid over a template: before or behind another one, instead of it, or as a part of it.

use std::borrow::Cow;
use std::ops::Range;

use toml::de::{DeArray, DeTable, DeValue};

use super::value::{Lay, Value, text};
use crate::error::Code;
use crate::frame::Text;

/// What a step says of its place.
enum Place {
    End,
    Before,
    After,
    Instead,
    Part,
}

/// Lays a step over the steps of a template. A part of one of these is not laid over it yet: it is returned with the place of
/// that step.
pub(super) fn lay<'a>(
    lay: &mut Lay<'_>,
    own: &mut DeArray<'a>,
    step: Value<'a>,
) -> Option<(Vec<usize>, DeTable<'a>)> {
    let range = step.span();
    let DeValue::Table(mut step) = step.into_inner() else {
        lay.wrong(Code::Declaration, "a step is a table", &[(range, "here")], "");
        return None;
    };
    let mut said = Vec::new();
    for (key, place) in [
        ("before", Place::Before),
        ("after", Place::After),
        ("replace", Place::Instead),
        ("extend", Place::Part),
    ] {
        // `replace = true` lets a part take the place of what is there.
        let flag = |value: &Value<'_>| matches!(value.get_ref(), DeValue::Boolean(_));
        if step.get(key).is_some_and(|value| !flag(value))
            && let Some(value) = step.remove(key)
        {
            said.push((key, place, value));
        }
    }
    if said.len() > 1 {
        let keys: Vec<String> = said.iter().map(|(key, ..)| format!("`{key}`")).collect();
        let places: Vec<_> = said.iter().map(|(.., value)| (value.span(), "here")).collect();
        let message = format!("a step has one place, not {}", keys.join(" and "));
        lay.wrong(Code::Declaration, message, &places, "");
        return None;
    }
    let (place, targets) = match said.pop() {
        None => (Place::End, Vec::new()),
        Some((key, place, value)) => (place, found(lay, own, key, &value)?),
    };
    if !matches!(place, Place::Part)
        && !step.contains_key("part")
        && let Some(DeValue::Table(target)) =
            targets.first().and_then(|first| at(own, first)).map(Value::get_mut)
        && let Some((key, part)) = target.iter().find(|(key, _)| **key.get_ref() == *"part")
    {
        // A step is of the part of the frame that it stands in.
        step.insert(key.clone(), part.clone());
    }
    let whole = |step| Value::new(range.clone(), DeValue::Table(step));
    match (place, targets.first().cloned(), targets.last().cloned()) {
        (Place::Before, Some(first), _) => insert(own, &first, 0, whole(step)),
        (Place::After, _, Some(last)) => {
            let target = at(own, &last).map_or(0..0, |target| target.span());
            lay.behind.push((range.clone(), target.clone()));
            insert_behind(lay, own, &last, &target, whole(step));
        }
        (Place::Part, Some(first), _) => return Some((first, step)),
        (Place::Instead, Some(first), _) => {
            let when = step.get("when").map(|when| (condition(when), when.span()));
            // From the end on, so that the paths of those before stay what they are.
            for target in targets.iter().rev() {
                match &when {
                    None => remove(own, target),
                    Some((Some(when), range)) => unless(own, target, when, range),
                    // The step's own condition is complained of.
                    Some((None, _)) => {}
                }
            }
            insert(own, &first, 0, whole(step));
        }
        _ => own.push(whole(step)),
    }
    None
}

/// The paths of the steps of these names, in their order; nothing if there are none, which is an error in `lay`.
fn found(
    lay: &mut Lay<'_>,
    own: &DeArray<'_>,
    key: &str,
    value: &Value<'_>,
) -> Option<Vec<Vec<usize>>> {
    let one = |value: &Value<'_>| {
        let name = value.get_ref().as_str()?;
        Some((name.to_owned(), value.span()))
    };
    let names: Option<Vec<(String, Range<usize>)>> = match value.get_ref() {
        DeValue::Array(list) if key == "replace" => list.iter().map(one).collect(),
        _ => one(value).map(|one| vec![one]),
    };
    let Some(names) = names.filter(|names| !names.is_empty()) else {
        let message = format!("`{key}` names a step by its label");
        lay.wrong(Code::Declaration, message, &[(value.span(), "here")], "");
        return None;
    };
    let mut all = Vec::new();
    for (name, range) in names {
        let (mut targets, mut known) = (Vec::new(), Vec::new());
        for by in [label, work] {
            if targets.is_empty() {
                search(own, &mut Vec::new(), &mut |step, path| {
                    let own = by(step);
                    if own.as_deref() == Some(&*name) {
                        targets.push(path.to_vec());
                    }
                    known.extend(own);
                });
            }
        }
        if targets.is_empty() {
            known.sort();
            known.dedup();
            let message = format!("`{name}` is no known step of this template");
            let help = format!("known: {}", known.join(", "));
            lay.wrong(Code::Unknown, message, &[(range, "here")], &help);
            return None;
        }
        if key == "extend" && targets.len() > 1 {
            let message = format!("{} steps are called `{name}`", targets.len());
            lay.wrong(Code::Declaration, message, &[(range, "here")], "replace them instead");
            return None;
        }
        all.extend(targets);
    }
    all.sort();
    all.dedup();
    Some(all)
}

fn string(step: &DeTable<'_>, key: &str) -> Option<String> {
    step.get(key).and_then(|value| value.get_ref().as_str()).map(str::to_owned)
}

fn label(step: &DeTable<'_>) -> Option<String> {
    string(step, "label")
}

/// The pass that a step runs, or the template that it uses.
fn work(step: &DeTable<'_>) -> Option<String> {
    let used = || Some(string(step, "prefix").unwrap_or_default() + &string(step, "use")?);
    string(step, "pass").or_else(used)
}

/// Visits every step with its path: its number, and that in the group of the step before it.
fn search(
    steps: &DeArray<'_>,
    path: &mut Vec<usize>,
    visit: &mut impl FnMut(&DeTable<'_>, &[usize]),
) {
    for (index, step) in steps.iter().enumerate() {
        let DeValue::Table(step) = step.get_ref() else { continue };
        path.push(index);
        visit(step, path);
        if let Some(DeValue::Array(group)) = step.get("steps").map(Value::get_ref) {
            search(group, path, visit);
        }
        path.pop();
    }
}

pub(super) fn at<'s, 'a>(steps: &'s mut DeArray<'a>, path: &[usize]) -> Option<&'s mut Value<'a>> {
    let (index, rest) = path.split_first()?;
    let step = steps.get_mut(*index)?;
    if rest.is_empty() {
        return Some(step);
    }
    match step.get_mut() {
        DeValue::Table(step) => match step.get_mut("steps")?.get_mut() {
            DeValue::Array(group) => at(group, rest),
            _ => None,
        },
        _ => None,
    }
}

/// Changes the list in which a path ends.
fn in_list<'a>(
    steps: &mut DeArray<'a>,
    path: &[usize],
    change: impl FnOnce(&mut Vec<Value<'a>>, usize),
) {
    let Some((index, rest)) = path.split_last() else { return };
    let list = if rest.is_empty() {
        Some(steps)
    } else {
        match at(steps, rest).map(Value::get_mut) {
            Some(DeValue::Table(group)) => match group.get_mut("steps").map(Value::get_mut) {
                Some(DeValue::Array(group)) => Some(group),
                _ => None,
            },
            _ => None,
        }
    };
    if let Some(list) = list {
        let mut steps: Vec<Value<'a>> =
            std::mem::replace(list, DeArray::new()).into_iter().collect();
        change(&mut steps, *index);
        *list = steps.into_iter().collect();
    }
}

fn insert<'a>(steps: &mut DeArray<'a>, path: &[usize], by: usize, step: Value<'a>) {
    in_list(steps, path, |list, index| list.insert((index + by).min(list.len()), step));
}

/// Inserts behind a step and those that were laid behind it before.
fn insert_behind<'a>(
    lay: &Lay<'_>,
    steps: &mut DeArray<'a>,
    path: &[usize],
    target: &Range<usize>,
    step: Value<'a>,
) {
    let is_behind = |step: &Value<'_>| {
        let mut place = step.span();
        // One is behind another one that was laid before it: the chain ends.
        while let Some((_, before)) = lay.behind.iter().find(|(own, _)| *own == place) {
            if before == target {
                return true;
            }
            place = before.clone();
        }
        false
    };
    in_list(steps, path, |list, index| {
        let behind = list.iter().skip(index + 1).take_while(|step| is_behind(step)).count();
        list.insert((index + 1 + behind).min(list.len()), step);
    });
}

fn remove(steps: &mut DeArray<'_>, path: &[usize]) {
    in_list(steps, path, |list, index| {
        list.remove(index);
    });
}

/// The text of a condition; nothing if it is none.
fn condition(when: &Value<'_>) -> Option<String> {
    let text = match when.get_ref() {
        DeValue::String(text) => text.to_string(),
        DeValue::Integer(number) => number.to_string(),
        _ => return None,
    };
    Text(text.clone()).parse().is_ok().then_some(text)
}

/// Lets a step run in its configurations without those of a condition.
fn unless<'a>(steps: &mut DeArray<'a>, path: &[usize], when: &str, range: &Range<usize>) {
    let Some(DeValue::Table(step)) = at(steps, path).map(Value::get_mut) else { return };
    let own = step.get("when").and_then(condition);
    let both = own.map_or_else(|| format!("!({when})"), |own| format!("({own}) && !({when})"));
    match step.get_mut("when") {
        Some(before) => *before = text(both, range.clone()),
        None => {
            let key = toml::Spanned::new(range.clone(), Cow::Borrowed("when"));
            step.insert(key, text(both, range.clone()));
        }
    }
}
