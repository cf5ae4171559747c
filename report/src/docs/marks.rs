//! Measured tables within documents that people write: what stands between two marks is replaced, the rest stays.

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
    Ok(format!("{before}{begin}\n{text}{end}{after}"))
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
        for lacking in ["<!-- a: begin --> <!-- b: end -->", "", "<!-- a: end --><!-- a: begin -->"]
        {
            let error = replaced(lacking, "x.md", "a", "").unwrap_err().to_string();
            assert!(error.contains("x.md lacks the marks"), "{error}");
        }
    }
}
