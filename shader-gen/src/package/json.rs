//! JSON as people read it: what fits a line stands in one.

use serde::Serialize;

/// The maximum length of a line in characters, unless a single key or value has more.
const WIDTH: usize = 120;

/// A value as JSON, with a space for each level and a newline at the end.
///
/// # Errors
///
/// What JSON cannot hold.
pub fn json(value: &impl Serialize) -> Result<Vec<u8>, serde_json::Error> {
    let mut lines: Vec<String> = Vec::new();
    let mut open = Vec::new();
    let formatter = serde_json::ser::PrettyFormatter::with_indent(b" ");
    let mut pretty = Vec::new();
    value.serialize(&mut serde_json::Serializer::with_formatter(&mut pretty, formatter))?;
    for line in String::from_utf8_lossy(&pretty).lines() {
        lines.push(line.to_owned());
        // No line of a text begins or ends with a bracket: it has quotes around it.
        if line.ends_with(['{', '[']) {
            open.push(lines.len() - 1);
        } else if line.trim_start().starts_with(['}', ']'])
            && let Some(start) = open.pop()
        {
            let length: usize = lines[start..].iter().map(|line| line.trim_start().len() + 1).sum();
            let indentation = lines[start].len() - lines[start].trim_start().len();
            if indentation + length <= WIDTH + 1 {
                let space = if line.contains('}') { " " } else { "" };
                let parts: Vec<_> = lines.drain(start..).collect();
                lines.push(joined(&parts, space));
            }
        }
    }
    lines.push(String::new());
    Ok(lines.join("\n").into_bytes())
}

/// A bracket, what stands in it, and its end in one line.
fn joined(lines: &[String], space: &str) -> String {
    let [first, inner @ .., last] = lines else { return lines.concat() };
    let inner: Vec<&str> = inner.iter().map(|line| line.trim_start()).collect();
    format!("{first}{space}{}{space}{}", inner.join(" "), last.trim_start())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_fits_a_line_stands_in_one_and_nothing_else_changes() {
        let long = "x".repeat(WIDTH);
        let value = serde_json::json!({
            "brackets": ["{", "[", "}", "]", { "a": [1, 2, []] }, {}],
            "long": [long, 1],
            "table": { "key": { "letter": "}", "numbers": [1.5, null, true] } },
        });
        let text = String::from_utf8(json(&value).unwrap()).unwrap();
        let expected = format!(
            "{{\n \"brackets\": [\"{{\", \"[\", \"}}\", \"]\", {{ \"a\": [1, 2, []] }}, {{}}],\n \"long\": [\n  \"{long}\",\n  1\n ],\n \"table\": {{ \"key\": {{ \"letter\": \"}}\", \"numbers\": [1.5, null, true] }} }}\n}}\n"
        );
        assert_eq!(text, expected);
        assert_eq!(serde_json::from_str::<serde_json::Value>(&text).unwrap(), value);
        assert!(text.lines().filter(|line| !line.contains(&long)).all(|line| line.len() <= WIDTH));
    }
}
