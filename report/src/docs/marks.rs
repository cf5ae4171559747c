//! Measured tables within documents that people write: what stands between two marks is replaced, the rest stays.

use textwrap::{Options, WordSeparator, WordSplitter, WrapAlgorithm};

use crate::failure::{Failure, Result};

/// Replaces what stands between `<!-- MARK: begin -->` and `<!-- MARK: end -->`. `name` is that of the document.
///
/// # Errors
///
/// When the document lacks a mark.
pub fn replaced(document: &str, name: &str, mark: &str, text: &str) -> Result<String> {
    let [begin, end] = ["begin", "end"].map(|which| format!("<!-- {mark}: {which} -->"));
    let parts = document.split_once(&begin).and_then(|(before, rest)| {
        let (_, after) = rest.split_once(&end)?;
        Some((before, after))
    });
    let (before, after) = parts
        .ok_or_else(|| Failure::new(format!("{name} lacks the marks `{begin}` and `{end}`")))?;
    Ok(format!("{before}{begin}\n{}{end}{after}", wrapped(text)))
}

/// The same with lines of at most 120 columns, but for rows of tables. Code is not broken.
fn wrapped(text: &str) -> String {
    const WIDTH: usize = 120;
    let options = Options::new(WIDTH)
        .word_separator(WordSeparator::AsciiSpace)
        .word_splitter(WordSplitter::NoHyphenation)
        .wrap_algorithm(WrapAlgorithm::FirstFit)
        .break_words(false);
    let wrapped = |line: &str| {
        if line.starts_with('|') || line.chars().count() <= WIDTH {
            return line.to_owned() + "\n";
        }
        let parts = line.split('`').enumerate();
        let kept =
            parts.map(
                |(at, part)| {
                    if at % 2 == 1 { part.replace(' ', "\u{a0}") } else { part.to_owned() }
                },
            );
        let kept = kept.collect::<Vec<_>>().join("`");
        textwrap::fill(&kept, &options).replace('\u{a0}', " ") + "\n"
    };
    text.lines().map(wrapped).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_between_the_marks_is_replaced_and_the_rest_stays() {
        let document = "one\n<!-- a: begin -->\nold\n<!-- a: end -->\ntwo\n<!-- b: begin -->\n<!-- b: end -->\n";
        let text = replaced(document, "x.md", "a", "new\n").unwrap();
        assert_eq!(text, document.replace("old", "new"));
        assert_eq!(replaced(&text, "x.md", "a", "new\n").unwrap(), text);
        let text = replaced(document, "x.md", "b", "new\n").unwrap();
        assert!(text.contains("old") && text.ends_with("new\n<!-- b: end -->\n"), "{text}");
        let long =
            format!("`{}` {}\n\n| {} |\n", "a b".repeat(30), "word ".repeat(30), "c".repeat(130));
        let text = replaced(document, "x.md", "a", &long).unwrap();
        assert!(text.contains(&"a b".repeat(30)) && text.contains(&"c".repeat(130)));
        assert!(text.lines().all(|line| line.starts_with('|') || line.len() <= 120), "{text}");
        for lacking in ["<!-- a: begin --> <!-- b: end -->", "", "<!-- a: end --><!-- a: begin -->"]
        {
            let error = replaced(lacking, "x.md", "a", "").unwrap_err().to_string();
            assert!(error.contains("x.md lacks the marks"), "{error}");
        }
    }
}
