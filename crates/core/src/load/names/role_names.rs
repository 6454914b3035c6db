//! Names that recorders give the channels of each role, from `assets/channel_names`.

use std::sync::LazyLock;

use crate::quantity::Role;

/// Names of a role, best first.
pub(crate) type RoleNames = (Role, &'static [&'static str]);

/// Names a role goes by, in small letters without separators, best first.
pub(crate) static NAMES: LazyLock<Vec<RoleNames>> =
    LazyLock::new(|| read_names(include_str!("../../../../../assets/channel_names/english.txt")));

/// Words of a text by what they stand for: `ax: accx accelx`, further ones indented on the lines below; `#` begins a comment.
pub(super) fn read_words(text: &'static str) -> Vec<(&'static str, Vec<&'static str>)> {
    let mut all: Vec<(&str, Vec<&str>)> = Vec::new();
    for line in text.lines().filter(|line| !line.starts_with('#')) {
        let (head, words) = line.split_once(':').unwrap_or(("", line));
        all.extend((!head.is_empty()).then(|| (head, Vec::new())));
        if let Some((_, known)) = all.last_mut() {
            known.extend(words.split_whitespace());
        }
    }
    all
}

/// Names of a text, each line beginning with a role.
pub(super) fn read_names(text: &'static str) -> Vec<RoleNames> {
    let all = read_words(text).into_iter();
    all.filter_map(|(role, names)| Some((Role::from_name(role)?, &*names.leak()))).collect()
}

/// Names of a role among `all`.
pub(crate) fn names_of(all: &[RoleNames], role: Role) -> &'static [&'static str] {
    all.iter().find(|(other, _)| *other == role).map_or(&[], |(_, names)| names)
}

/// Whether small letters without separators are a name of a role.
pub(crate) fn is_known(plain: &str) -> bool {
    NAMES.iter().any(|(_, names)| names.contains(&plain))
}

#[cfg(test)]
mod tests {
    use super::NAMES;

    #[test]
    fn every_line_of_names_begins_with_a_role() {
        let text = include_str!("../../../../../assets/channel_names/english.txt");
        assert_eq!(NAMES.len(), text.lines().filter(|line| !line.starts_with(['#', ' '])).count());
        assert!(NAMES.iter().all(|(_, names)| !names.is_empty()));
    }
}
