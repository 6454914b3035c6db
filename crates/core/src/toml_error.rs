//! What is wrong with a TOML file, in one line.

use toml::de::Error;

/// Line of `text` (from 1) an error lies in; none where the values do not come from a text.
pub fn line(text: &str, error: &Error) -> Option<usize> {
    let start = error.span()?.start.min(text.len());
    Some(1 + text.as_bytes()[..start].iter().filter(|&&byte| byte == b'\n').count())
}

/// What an error says, in one line.
pub fn message(error: &Error) -> String {
    error.message().trim_end().replace('\n', ", ")
}

/// `line 12: unknown field`, of the error in `text`.
pub fn one_line(text: &str, error: &Error) -> String {
    match line(text, error) {
        Some(line) => format!("line {line}: {}", message(error)),
        None => error.to_string().trim_end().replace('\n', " "),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_name_their_line() {
        let text = "a = 1\nb = [\n";
        let error = toml::from_str::<toml::Table>(text).unwrap_err();
        let said = one_line(text, &error);
        assert!(said.starts_with("line 2") || said.starts_with("line 3"), "{said}");
        assert!(!said.contains('\n'), "{said}");
    }
}
