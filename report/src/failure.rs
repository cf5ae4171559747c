//! What a command says when it cannot go on.

use std::fmt;

/// Why a command ends without success, in words for a person, and what that person can do about it.
#[derive(Debug)]
pub struct Failure {
    message: String,
    help: Vec<String>,
    /// Whether `message` says of itself that it is an error.
    rendered: bool,
}

/// What a command returns.
pub type Result<T = (), E = Failure> = std::result::Result<T, E>;

impl Failure {
    /// A failure that says `message`.
    pub fn new(message: impl Into<String>) -> Self {
        Self { message: message.into(), help: Vec::new(), rendered: false }
    }

    /// Adds a line that says what would do.
    pub fn help(mut self, line: impl Into<String>) -> Self {
        self.help.push(line.into());
        self
    }
}

/// What both gave, or all that went wrong.
pub fn both<A, B>(one: Result<A>, other: Result<B>) -> Result<(A, B)> {
    match (one, other) {
        (Ok(one), Ok(other)) => Ok((one, other)),
        (Err(mut all), Err(next)) => {
            all.message = format!("{}\n{}", all.message.trim_end(), next.message);
            all.help.extend(next.help);
            Err(all)
        }
        (Err(wrong), _) | (_, Err(wrong)) => Err(wrong),
    }
}

/// What each gave, or all that went wrong.
pub fn all<T>(results: Vec<Result<T>>) -> Result<Vec<T>> {
    // Not `try_fold`, which would stop at the first that went wrong.
    let mut all = Ok(Vec::new());
    for next in results {
        all = both(all, next).map(|(mut all, next)| {
            all.push(next);
            all
        });
    }
    all
}

/// The report of a library, which shows the author's own lines.
pub fn rendered(report: sglow_shader_gen::error::Report) -> Failure {
    let coloured = std::io::IsTerminal::is_terminal(&std::io::stderr());
    Failure { message: report.render(coloured), help: Vec::new(), rendered: true }
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        // What a library says of its own texts begins so already.
        let own = self.rendered || self.message.starts_with("error");
        let prefix = if own { "" } else { "error: " };
        write!(f, "{prefix}{}", self.message.trim_end())?;
        self.help.iter().try_for_each(|line| write!(f, "\nhelp: {line}"))
    }
}

/// An error message of a device as one line; a message that shows code stays as it is.
fn one_line(text: String) -> String {
    if !text.contains("Caused by:") || text.contains('┌') {
        return text;
    }
    let lines = text.lines().map(|line| line.trim().trim_end_matches(':'));
    let lines = lines.filter(|line| !line.is_empty() && *line != "Caused by");
    lines.collect::<Vec<_>>().join(": ")
}

impl<E: std::error::Error> From<E> for Failure {
    fn from(error: E) -> Self {
        let mut message = one_line(error.to_string());
        let mut source = error.source();
        while let Some(cause) = source {
            let cause_text = cause.to_string();
            // Many errors already quote their cause.
            if !message.contains(&cause_text) {
                message.push_str(": ");
                message.push_str(&cause_text);
            }
            source = cause.source();
        }
        Self::new(message)
    }
}

/// Says what was being done when an error came up.
pub trait Context<T> {
    /// Puts `doing` before the error's own words.
    fn context(self, doing: impl fmt::Display) -> Result<T>;
}

impl<T, E: Into<Failure>> Context<T> for Result<T, E> {
    fn context(self, doing: impl fmt::Display) -> Result<T> {
        self.map_err(|error| {
            let failure = error.into();
            Failure { message: format!("{doing}: {}", failure.message), ..failure }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_that_went_wrong_is_told() {
        assert_eq!(all(vec![Ok(1), Ok(2)]).unwrap(), [1, 2]);
        let wrong = |text: &str| Err(Failure::new(text).help(format!("mend {text}")));
        let text = all(vec![wrong("one"), Ok(1), wrong("two")]).unwrap_err().to_string();
        assert_eq!(text, "error: one\ntwo\nhelp: mend one\nhelp: mend two");
    }

    #[test]
    fn errors_of_a_device_are_one_line_unless_they_show_code() {
        let wall =
            "refused: Validation Error\n\nCaused by:\n  In Device::create_texture\n    too wide\n";
        let line = "error: refused: Validation Error: In Device::create_texture: too wide";
        assert_eq!(Failure::from(std::io::Error::other(wall)).to_string(), line);
        let code = "Shader error\n\nCaused by:\n  ┌─ wgsl:1:1\n  │ fn";
        assert_eq!(Failure::from(std::io::Error::other(code)).to_string().lines().count(), 5);
    }

    #[test]
    fn a_failure_names_what_was_done_and_what_would_do() {
        let missing = std::fs::read("/no/such/file").context("/no/such/file");
        let text = missing.unwrap_err().help("look elsewhere").to_string();
        assert!(text.starts_with("error: /no/such/file: No such file"), "{text}");
        assert!(text.ends_with("\nhelp: look elsewhere"), "{text}");
    }
}
