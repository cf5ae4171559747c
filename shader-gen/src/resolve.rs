//! What conditions leave of a declaration: the bytes that stay, laid out as a person would have written them.
//!
//! Bytes are only ever taken away. The braces of a block that a condition was about go where no name changes its meaning
//! by that; the lines within lose the block's indentation; runs of blank lines collapse.

use std::collections::{BTreeMap, BTreeSet, HashSet};
use std::ops::Range;

use crate::parse::{Block, Item};

/// The bytes of `item` in `source` that stay when `flags` hold. `words` are those of its declaration, with their places.
pub(crate) fn resolve(
    source: &str,
    item: &Item,
    words: &[(String, Range<usize>)],
    flags: &BTreeSet<&str>,
) -> Vec<Range<usize>> {
    let conditional = item
        .edits
        .iter()
        .filter(|edit| !edit.keep_if.as_ref().is_some_and(|condition| condition.holds(flags)));
    let mut removed: Vec<_> = conditional.map(|edit| edit.range.clone()).collect();
    let kept = without(&item.whole, &mut removed.clone());
    let kept_words: Vec<_> =
        words.iter().filter(|(_, at)| kept.iter().any(|range| range.contains(&at.start))).collect();
    let mut indents: BTreeMap<usize, usize> = BTreeMap::new();
    for block in needless(&item.blocks, &kept_words, flags) {
        removed.extend(block.braces.iter().cloned());
        for line in &block.lines {
            *indents.entry(*line).or_default() += block.indent;
        }
    }
    removed.extend(indents.into_iter().map(|(line, indent)| {
        let rest = &source[line..];
        let spaces = rest.len() - rest.trim_start_matches(' ').len();
        line..line + indent.min(spaces)
    }));
    tidy(source, without(&item.whole, &mut removed))
}

/// `whole` without what `removed` holds.
fn without(whole: &Range<usize>, removed: &mut [Range<usize>]) -> Vec<Range<usize>> {
    removed.sort_by_key(|range| (range.start, range.end));
    let mut ranges = Vec::new();
    let mut at = whole.start;
    for range in removed {
        if at < range.start {
            ranges.push(at..range.start);
        }
        at = at.max(range.end);
    }
    if at < whole.end {
        ranges.push(at..whole.end);
    }
    ranges
}

/// The blocks whose braces may go: no name that they declare stands anywhere else in the block around them, where it
/// would be declared twice or mean something else.
fn needless<'a>(
    blocks: &'a [Block],
    words: &[&(String, Range<usize>)],
    flags: &BTreeSet<&str>,
) -> Vec<&'a Block> {
    let mut found: Vec<(&Block, HashSet<&str>)> = Vec::new();
    for block in blocks.iter().filter(|block| block.condition.holds(flags)) {
        let within = |range: &Range<usize>, at: &Range<usize>| {
            range.start <= at.start && at.end <= range.end
        };
        // What blocks within declare is declared here once their braces are gone.
        let own = block.declares.iter().map(|(name, at)| (name.as_str(), at));
        let kept = |at: &Range<usize>| words.iter().any(|(_, word)| word.start == at.start);
        let mut names: HashSet<&str> =
            own.filter(|(_, at)| kept(at)).map(|(name, _)| name).collect();
        for (inner, inner_names) in &found {
            if inner.around == block.range {
                names.extend(inner_names);
            }
        }
        let elsewhere = words.iter().any(|(word, at)| {
            names.contains(word.as_str()) && within(&block.around, at) && !within(&block.range, at)
        });
        if !elsewhere {
            found.push((block, names));
        }
    }
    found.into_iter().map(|(block, _)| block).collect()
}

/// `ranges` without space at the end of lines, and with one blank line where there were several, none behind an opening
/// brace and none before a closing one.
fn tidy(source: &str, ranges: Vec<Range<usize>>) -> Vec<Range<usize>> {
    let mut lines: Vec<Vec<Range<usize>>> = vec![Vec::new()];
    for range in ranges {
        let mut start = range.start;
        for (newline, _) in source[range.clone()].match_indices('\n') {
            let end = range.start + newline + 1;
            if let Some(line) = lines.last_mut() {
                line.push(start..end);
            }
            lines.push(Vec::new());
            start = end;
        }
        if let Some(line) = lines.last_mut()
            && start < range.end
        {
            line.push(start..range.end);
        }
    }
    let text = |line: &[Range<usize>]| -> String {
        line.iter().map(|range| &source[range.clone()]).collect::<String>().trim().to_owned()
    };
    let texts: Vec<_> = lines.iter().map(|line| text(line)).collect();
    let mut tidied: Vec<Range<usize>> = Vec::new();
    let mut above = "{";
    for (index, line) in lines.iter().enumerate() {
        let is_last = index + 1 == lines.len();
        let below = texts[index + 1..].iter().find(|text| !text.is_empty());
        let blank = texts[index].is_empty() && !is_last;
        if blank
            && (above.is_empty()
                || above.ends_with('{')
                || below.is_none_or(|below| below.starts_with('}')))
        {
            continue;
        }
        above = texts[index].as_str();
        for range in trimmed(source, line) {
            match tidied.last_mut() {
                Some(last) if last.end == range.start => last.end = range.end,
                _ => tidied.push(range),
            }
        }
    }
    tidied
}

/// A line without the space before its line break.
fn trimmed(source: &str, line: &[Range<usize>]) -> Vec<Range<usize>> {
    let mut kept = Vec::new();
    let mut in_space = true;
    for range in line.iter().rev() {
        let text = &source[range.clone()];
        let (body, newline) = match text.strip_suffix('\n') {
            Some(body) => (body, 1),
            None => (text, 0),
        };
        if newline == 1 {
            kept.push(range.end - 1..range.end);
        }
        let length = if in_space { body.trim_end_matches([' ', '\t']).len() } else { body.len() };
        in_space &= length == 0;
        if length > 0 {
            kept.push(range.start..range.start + length);
        }
    }
    kept.reverse();
    kept
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::parse::parse;

    /// What the flags leave of the only declaration of `text`.
    fn left(text: &str, flags: &[&str]) -> String {
        let mut errors = Vec::new();
        let module = parse(0, "", text, &mut errors);
        assert_eq!(errors, []);
        let declaration = &module.declarations[0];
        let flags = flags.iter().copied().collect();
        let ranges = resolve(text, &declaration.item, &declaration.references, &flags);
        ranges.into_iter().map(|range| &text[range]).collect()
    }

    #[test]
    fn braces_of_a_condition_go_with_their_indentation() {
        let text = "fn f() {
    let x = 1;
    // Why.
    @if(a) {
        let y = 2;

        @if(b) {
            g(
                y,
            );
        }
        if y > x {
            g(x);
        }
    }
    @else {
        g(3);
    }
    @if(b) { g(4); }
}";
        assert_eq!(
            left(text, &["a", "b"]),
            "fn f() {
    let x = 1;
    // Why.
    let y = 2;

    g(
        y,
    );
    if y > x {
        g(x);
    }
    g(4);
}"
        );
        assert_eq!(left(text, &[]), "fn f() {\n    let x = 1;\n    g(3);\n}");
    }

    #[test]
    fn braces_stay_where_a_name_would_change_its_meaning() {
        for text in [
            "fn f() {\n    @if(a) {\n        let x = 1;\n        g(x);\n    }\n    let x = 2;\n}",
            "fn f(x: f32) {\n    @if(a) {\n        let x = 1;\n        g(x);\n    }\n}",
            "fn f() -> i32 {\n    @if(a) {\n        let X = 1;\n        g(X);\n    }\n    return X;\n}",
            "fn f() {\n    @if(a) {\n        let x = 1;\n    }\n    @if(a) {\n        let x = 1;\n    }\n}",
            "fn f() {\n    for (var x = 0; x < 2; x++) {\n        @if(a) {\n            let x = 1;\n        }\n    }\n}",
        ] {
            assert_eq!(left(text, &["a"]), text.replace("@if(a) ", ""));
        }
        // A name behind a `.` is another one, and what another condition leaves out is not there.
        let text = "fn f() {
    @if(a) {
        let x = g.x;
        @if(b) {
            let y = 1;
        }
    }
    @if(!a) {
        let x = 2;
    }
    h(g.x);
}";
        let unwrapped = "fn f() {\n    let x = g.x;\n    let y = 1;\n    h(g.x);\n}";
        assert_eq!(left(text, &["a", "b"]), unwrapped);
        // What an inner block declares is declared by the outer one, once it is unwrapped.
        let clash = text.replace("h(g.x)", "let y = 3");
        let kept =
            "fn f() {\n    {\n        let x = g.x;\n        let y = 1;\n    }\n    let y = 3;\n}";
        assert_eq!(left(&clash, &["a", "b"]), kept);
    }

    #[test]
    fn what_goes_leaves_no_holes() {
        let text = "fn f() {
    @if(a) g(1);

    @if(a)
    g(2);

    g(
        1,  @if(a) 2,
    );

    // Gone with it.
    @if(a) g(3);
}";
        let text = text.replace("1,  @if(a) 2,", "1,");
        assert_eq!(left(&text, &[]), "fn f() {\n    g(\n        1,\n    );\n}");
        let kept = text.replace("@if(a) ", "").replace("@if(a)\n    ", "");
        assert_eq!(left(&text, &["a"]), kept);
        let text = "struct S {\n    @if(a) x: f32,\n\n    y: f32, @if(a) z: f32,\n}";
        assert_eq!(left(text, &[]), "struct S {\n    y: f32,\n}");
    }
}
