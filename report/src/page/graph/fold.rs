//! Repeated steps, listed once: rounds of a mip chain, digits of a sort.

use std::collections::{BTreeMap, BTreeSet};

use crate::page::graph::content::{Step, Work};

/// A step, or the same step of several rounds.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Row {
    /// The number of the first one, from 1 on.
    pub(crate) number: usize,
    /// How many rounds there are, and how many steps each round has.
    pub(crate) rounds: usize,
    /// Steps of a round.
    pub(crate) of: usize,
    /// Which of them this is, from 0 on.
    pub(crate) place: usize,
    /// Its part of the frame.
    pub(crate) part: String,
    /// What its time is called.
    pub(crate) label: String,
    /// The pass, or `clear`.
    pub(crate) pass: String,
    /// Its variants.
    pub(crate) variants: BTreeSet<String>,
    /// What runs in the first round and, if that is something else, in the last one.
    pub(crate) work: Vec<Work>,
    /// Whether it runs in the first frame alone.
    pub(crate) once: bool,
    /// What it reads: levels by resource; none of them for all levels.
    pub(crate) reads: Levels,
    /// What it writes.
    pub(crate) writes: Levels,
}

/// Levels by resource; an empty set means the whole resource.
pub(crate) type Levels = BTreeMap<String, BTreeSet<u64>>;

/// Steps of one round at most.
const MOST: usize = 16;

/// What makes steps of different rounds the same: what is read may differ in the first round.
fn same(one: &Step, other: &Step) -> bool {
    let written = |step: &Step| -> BTreeSet<String> {
        let pair = |name: &str| name.trim_end_matches(".0").trim_end_matches(".1").to_owned();
        step.writes.iter().map(|of| pair(&of.resource)).collect()
    };
    one.place == other.place
        && one.label == other.label
        && one.part == other.part
        && written(one) == written(other)
}

/// The rows of steps in order.
pub(crate) fn rows(steps: &[Step]) -> Vec<Row> {
    let mut rows = Vec::new();
    let mut at = 0;
    while at < steps.len() {
        let (of, rounds) = repeated(&steps[at..]);
        for place in 0..of {
            let all: Vec<&Step> =
                (0..rounds).map(|round| &steps[at + round * of + place]).collect();
            rows.extend(row(&all, at + place + 1, of, place));
        }
        at += of * rounds;
    }
    rows
}

/// How many steps a round has that begins here, and how many rounds follow each other; one of one if none does.
fn repeated(steps: &[Step]) -> (usize, usize) {
    for of in 1..=MOST.min(steps.len() / 2) {
        let round = &steps[..of];
        let more = steps[of..].chunks_exact(of);
        let more = more.take_while(|next| round.iter().zip(*next).all(|(a, b)| same(a, b))).count();
        if more > 0 {
            return (of, more + 1);
        }
    }
    (1, 1)
}

fn row(all: &[&Step], number: usize, of: usize, place: usize) -> Option<Row> {
    let (first, last) = (all.first()?, all.last()?);
    let mut work = vec![first.work.clone()];
    work.extend((last.work != first.work).then(|| last.work.clone()));
    let levels = |writes: bool| {
        let mut levels = Levels::new();
        let of = |step: &&Step| if writes { step.writes.clone() } else { step.reads.clone() };
        let uses: Vec<_> = all.iter().flat_map(of).collect();
        for one in &uses {
            levels.entry(one.resource.clone()).or_default().extend(one.level);
        }
        // The whole is more than any level of it.
        for one in uses.iter().filter(|one| one.level.is_none()) {
            levels.insert(one.resource.clone(), BTreeSet::new());
        }
        levels
    };
    Some(Row {
        number,
        rounds: all.len(),
        of,
        place,
        part: first.part.clone(),
        label: first.label.clone(),
        pass: first.pass.clone().unwrap_or_else(|| "clear".to_owned()),
        variants: all.iter().flat_map(|step| step.variants.iter().cloned()).collect(),
        work,
        once: first.first_frame_of.is_some(),
        reads: levels(false),
        writes: levels(true),
    })
}

impl Row {
    /// What runs, as a person reads it.
    pub(crate) fn work(&self) -> String {
        let text = self.work.iter().map(Work::text).collect::<Vec<_>>().join(" to ");
        if self.once { format!("{text}, first frame alone") } else { text }
    }

    /// What changes from variant to variant in brackets, as in `mip-r32float-{one,three}`.
    pub(crate) fn variant(&self) -> String {
        let split: Vec<Vec<&str>> =
            self.variants.iter().map(|id| id.split('-').collect()).collect();
        let Some(first) = split.first() else { return self.pass.clone() };
        if split.iter().any(|words| words.len() != first.len()) {
            return self.variants.iter().cloned().collect::<Vec<_>>().join(", ");
        }
        let word = |index: usize| {
            let words: BTreeSet<&str> = split.iter().map(|words| words[index]).collect();
            let words: Vec<&str> = words.into_iter().collect();
            if words.len() == 1 { words[0].to_owned() } else { format!("{{{}}}", words.join(",")) }
        };
        (0..first.len()).map(word).collect::<Vec<_>>().join("-")
    }
}

/// Levels as a person reads them: `moments`, `moments@0`, `moments@1..3`, and of pairs `keys.0,1`.
pub(crate) fn levels(levels: &Levels) -> Vec<String> {
    let other = |name: &str, from: &str, to: &str| {
        let other = name.strip_suffix(from).map(|pair| format!("{pair}{to}"))?;
        let same = levels.get(&other).is_some_and(|own| own.is_empty());
        same.then_some(other)
    };
    let text = |(name, levels): (&String, &BTreeSet<u64>)| match (levels.first(), levels.last()) {
        (Some(first), Some(last)) if first == last => format!("{name}@{first}"),
        (Some(first), Some(last)) => format!("{name}@{first}..{last}"),
        _ if other(name, ".0", ".1").is_some() => format!("{name},1"),
        _ => name.clone(),
    };
    let listed = |(name, _): &(&String, &BTreeSet<u64>)| other(name, ".1", ".0").is_none();
    levels.iter().filter(listed).map(text).collect()
}

#[cfg(test)]
mod tests {
    use super::super::content::Use;
    use super::*;

    fn step(place: &str, writes: &str, level: Option<u64>) -> Step {
        Step {
            place: place.to_owned(),
            part: "all".to_owned(),
            label: "mips".to_owned(),
            pass: Some("mip".to_owned()),
            variants: vec![format!("mip-{}", if level == Some(3) { "one" } else { "two" })],
            entry: None,
            work: Work::Dispatch { workgroups: [8 >> level.unwrap_or(0), 1, 1] },
            constants: BTreeMap::new(),
            first_frame_of: None,
            reads: Vec::new(),
            writes: vec![Use { resource: writes.to_owned(), level, by: "out".to_owned() }],
        }
    }

    #[test]
    fn rounds_are_one_row_and_groups_of_steps_one_each() {
        let chain: Vec<_> = (1..=3).map(|level| step("a", "image", Some(level))).collect();
        let found = rows(&chain);
        assert_eq!((found.len(), found[0].rounds, found[0].number), (1, 3, 1));
        assert_eq!(levels(&found[0].writes), ["image@1..3"]);
        assert_eq!(found[0].work(), "4x1x1 to 1x1x1");
        assert_eq!(found[0].variant(), "mip-{one,two}");
        let pair =
            |round: u64| [step("a", "counts", None), step("b", &format!("keys.{round}"), None)];
        let sort: Vec<_> =
            [0, 1, 0].into_iter().flat_map(pair).chain([step("c", "x", None)]).collect();
        let found = rows(&sort);
        let shape: Vec<_> =
            found.iter().map(|row| (row.number, row.rounds, row.of, row.place)).collect();
        assert_eq!(shape, [(1, 3, 2, 0), (2, 3, 2, 1), (7, 1, 1, 0)]);
        assert_eq!(levels(&found[1].writes), ["keys.0,1"]);
    }

    #[test]
    fn what_writes_something_else_is_no_round() {
        let two = [step("a", "one", None), step("a", "two", None)];
        assert_eq!(rows(&two).len(), 2);
        assert!(rows(&[]).is_empty());
    }
}
