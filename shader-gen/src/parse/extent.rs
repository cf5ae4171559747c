//! The bytes that belong to a node: its comments, and its lines where nothing else stands on them.

use std::ops::Range;

use super::Parser;

impl Parser<'_> {
    /// Where the comments begin that stand directly before `start`, each at the beginning of its line.
    pub(super) fn leading(&self, mut start: usize) -> usize {
        let before = self.comments.partition_point(|comment| comment.start < start);
        for comment in self.comments[..before].iter().rev() {
            if !self.is_next_line(comment.end..start) || !self.begins_line(comment.start) {
                break;
            }
            start = comment.start;
        }
        start
    }

    /// Where the comment ends that stands behind `end` on the same line, as the last thing on it.
    pub(super) fn trailing(&self, end: usize) -> usize {
        let next = self.comments.partition_point(|comment| comment.start < end);
        match self.comments.get(next) {
            Some(comment)
                if self.text[end..comment.start].chars().all(|c| matches!(c, ' ' | '\t'))
                    && self.text[comment.end..]
                        .trim_start_matches([' ', '\t', '\r'])
                        .starts_with('\n') =>
            {
                comment.end
            }
            _ => end,
        }
    }

    /// Whether `gap` is white space with exactly one line break.
    pub(super) fn is_next_line(&self, gap: Range<usize>) -> bool {
        let gap = &self.text[gap];
        gap.trim().is_empty() && gap.bytes().filter(|byte| *byte == b'\n').count() == 1
    }

    pub(super) fn begins_line(&self, start: usize) -> bool {
        let line = self.text[..start].rfind('\n').map_or(0, |newline| newline + 1);
        self.text[line..start].trim().is_empty()
    }

    /// `range` with its indentation and line break if nothing else stands on its lines; otherwise with the space
    /// behind it.
    pub(super) fn lines(&self, range: Range<usize>) -> Range<usize> {
        let rest = &self.text[range.end..];
        let space = rest.len() - rest.trim_start_matches([' ', '\t', '\r']).len();
        let after = range.end + space;
        if self.begins_line(range.start) && self.text[after..].starts_with('\n') {
            let line = self.text[..range.start].rfind('\n').map_or(0, |newline| newline + 1);
            return line..after + 1;
        }
        range.start..after
    }

    /// As [`Self::lines`], with the space before `range` instead of the space behind it.
    pub(super) fn lines_before(&self, range: Range<usize>) -> Range<usize> {
        let whole = self.lines(range.clone());
        if whole.start < range.start {
            return whole;
        }
        self.text[..range.start].trim_end_matches([' ', '\t', '\r']).len()..range.end
    }
}
