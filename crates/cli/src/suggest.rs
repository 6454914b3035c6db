//! A mistyped command is a session that does not exist: names the nearest command.

use std::path::Path;

/// Letters that may differ between what was typed and a command.
const MOST_DIFFERENCES: usize = 2;

/// The error of a session that looks like a mistyped command; `None` for a file, a shipped session or any other name.
pub fn mistyped<'a>(session: &Path, commands: impl Iterator<Item = &'a str>) -> Option<String> {
    let typed = session.to_str()?;
    if session.exists() || typed.contains(['/', '\\', '.', ':']) {
        return None;
    }
    let differences = |command: &str| strsim::osa_distance(typed, command);
    let nearest = commands.min_by_key(|command| differences(command))?;
    // A short word differs from every other short word by a few letters.
    let is_near = differences(nearest) <= MOST_DIFFERENCES.min(typed.chars().count() / 2);
    is_near.then(|| format!("'{typed}' is neither a command nor a file: did you mean 'doublet {nearest}'?"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn near_commands_are_suggested_and_files_are_not() {
        let suggest = |typed: &str| mistyped(Path::new(typed), ["help", "run", "report"].into_iter());
        let expected = "'hlep' is neither a command nor a file: did you mean 'doublet help'?";
        assert_eq!(suggest("hlep").as_deref(), Some(expected));
        assert_eq!(suggest("rnu").as_deref().map(|text| text.ends_with("'doublet run'?")), Some(true));
        assert_eq!(suggest("flight"), None);
        assert_eq!(suggest("hlep.toml"), None);
        assert_eq!(suggest("builtin:hlep"), None);
    }
}
