//! Findings of one kind in one line: what differs only in its numbers, in the names it quotes or in its place is said once.

use std::collections::HashMap;
use std::path::Path;

use super::{Finding, Level};
use crate::session::write_fix;

/// Names a line says before it only counts the others.
const NAMED: usize = 3;
/// Numbers of a line that may be ranges: with more of them nobody knows which belong together, and the first message stands for all.
const RANGES: usize = 2;

/// Findings of one kind.
#[derive(Clone, Debug, PartialEq)]
pub struct Folded {
    /// Their level.
    pub level: Level,
    /// Their kind.
    pub code: &'static str,
    /// Where: the place, or how many there are.
    pub place: String,
    /// What was found, numbers from the least to the greatest.
    pub text: String,
    /// What to do.
    pub fix: String,
    /// How many findings it stands for.
    pub count: usize,
}

impl std::fmt::Display for Folded {
    /// Where, what and what to do, in one line.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}: {}", self.place, self.text)?;
        write_fix(f, &self.text, &self.fix)
    }
}

/// Kinds in the order in which one explains the next: what is wrong with channels and settings shows in windows, then in fits.
const CAUSES: [&str; 16] = [
    "physics",
    "accelerometer",
    "gravity",
    "aircraft",
    "timing",
    "saturated",
    "stuck",
    "dynamic-pressure",
    "turn",
    "sampling",
    "loading",
    "propulsion",
    "failed",
    "nis",
    "innovation",
    "smoother",
];

/// Folds findings by level, kind and what they say; the worst first, of one level causes before what follows from them, then those found
/// most often. `paths` are the
/// recordings of the session: a message that begins with the place one was read from calls it as the session does.
pub fn fold(findings: &[Finding], paths: &[&str]) -> Vec<Folded> {
    let mut groups = Groups::default();
    findings.iter().for_each(|finding| groups.note(finding, split(paths, &finding.text)));
    let mut folded: Vec<Folded> = groups.list.iter().map(Group::folded).collect();
    let cause = |code: &str| CAUSES.iter().position(|cause| *cause == code).unwrap_or(CAUSES.len());
    folded.sort_by_key(|line| (std::cmp::Reverse(line.level), cause(line.code), std::cmp::Reverse(line.count)));
    folded
}

/// A part of a message that may differ between messages of one kind.
#[derive(Clone, Debug, PartialEq)]
enum Part {
    Number(f64, String),
    Name(String),
}

/// A message: what is said between its parts, and the parts.
#[derive(Clone, Debug, PartialEq)]
struct Message {
    between: Vec<String>,
    parts: Vec<Part>,
}

/// Cuts a message at its numbers, at what it quotes and at the recording it begins with, which is called as in the session and not by
/// the place it was read from.
fn split(paths: &[&str], text: &str) -> Message {
    let mut message = Message { between: Vec::new(), parts: Vec::new() };
    let mut between = String::new();
    let mut rest = text;
    if let Some((place, behind)) = text.split_once(": ") {
        let tail = |path: &str| path.trim_start_matches("builtin:").trim_start_matches(['.', '/']).to_owned();
        let found = paths.iter().filter(|path| Path::new(place).ends_with(tail(path)));
        if let Some(path) = found.max_by_key(|path| path.len()) {
            message.between.push(String::new());
            message.parts.push(Part::Name((*path).to_owned()));
            (between, rest) = (": ".to_owned(), behind);
        }
    }
    while let Some(first) = rest.chars().next() {
        let at_start = between.is_empty() || between.ends_with([' ', '(']);
        match part(rest).filter(|_| at_start) {
            Some((part, length)) => {
                message.between.push(std::mem::take(&mut between));
                message.parts.push(part);
                rest = &rest[length..];
            }
            None => {
                between.push(first);
                rest = &rest[first.len_utf8()..];
            }
        }
    }
    message.between.push(between);
    message
}

/// The number or quoted name a text begins with, and its length in bytes.
fn part(text: &str) -> Option<(Part, usize)> {
    let ends = |length: usize| {
        !text[length..].starts_with(|c: char| c.is_alphanumeric() || matches!(c, '-' | '_' | '/' | '.'))
    };
    if let Some(quoted) = text.strip_prefix('\'') {
        let name = &quoted[..quoted.find('\'')?];
        return Some((Part::Name(format!("'{name}'")), name.len() + 2));
    }
    let length = text.find(|c: char| !(c.is_ascii_digit() || matches!(c, '.' | '-'))).unwrap_or(text.len());
    let number = text[..length].trim_end_matches('.');
    let value = number.parse().ok().filter(|_| ends(number.len()) || text[number.len()..].starts_with(". "))?;
    Some((Part::Number(value, number.to_owned()), number.len()))
}

/// Messages of one kind.
struct Group<'a> {
    first: &'a Finding,
    between: Vec<String>,
    /// Of each part, every one there was.
    parts: Vec<Vec<Part>>,
    /// Of each message.
    places: Vec<&'a str>,
}

/// What findings that are folded have in common: level, kind and what is said between their numbers and names.
type Kind = (Level, &'static str, Vec<String>);

#[derive(Default)]
struct Groups<'a> {
    list: Vec<Group<'a>>,
    known: HashMap<Kind, usize>,
}

impl<'a> Groups<'a> {
    fn note(&mut self, finding: &'a Finding, message: Message) {
        let same = |parts: &[Vec<Part>]| {
            let kind = |part: &Part| matches!(part, Part::Number(..));
            parts.iter().zip(&message.parts).all(|(all, part)| kind(&all[0]) == kind(part))
        };
        let kind = (finding.level, finding.code, message.between.clone());
        let index = self.known.get(&kind).copied().filter(|&index| same(&self.list[index].parts));
        let index = index.unwrap_or_else(|| {
            let parts = vec![Vec::new(); message.parts.len()];
            self.known.insert(kind, self.list.len());
            self.list.push(Group { first: finding, between: message.between.clone(), parts, places: Vec::new() });
            self.list.len() - 1
        });
        let group = &mut self.list[index];
        group.parts.iter_mut().zip(message.parts).for_each(|(all, part)| all.push(part));
        group.places.push(&finding.place);
    }
}

impl Group<'_> {
    fn folded(&self) -> Folded {
        let ranges = self.parts.iter().filter(|parts| is_range(parts)).count();
        let mut text = self.between[0].clone();
        for (parts, between) in self.parts.iter().zip(&self.between[1..]) {
            text.push_str(&together(if ranges > RANGES { &parts[..1] } else { parts }));
            text.push_str(between);
        }
        if ranges > RANGES {
            text.push_str(&format!(" (first of {} similar)", self.places.len()));
        }
        let mut places: Vec<&str> = Vec::new();
        self.places.iter().for_each(|place| {
            if !places.contains(place) {
                places.push(place);
            }
        });
        if ranges <= RANGES && self.places.len() > places.len() {
            text.push_str(&format!(" ({} times)", self.places.len()));
        }
        Folded {
            level: self.first.level,
            code: self.first.code,
            place: in_words(&places),
            text,
            fix: self.first.fix_text.clone(),
            count: self.places.len(),
        }
    }
}

/// Places in words: one or two by their names, more by their number and what they have in common.
fn in_words(places: &[&str]) -> String {
    let windows: Vec<&str> = places
        .iter()
        .filter_map(|place| place.strip_prefix("manoeuvre '")?.split_once('\'').map(|(name, _)| name))
        .collect();
    // `window 'a', alpha` and `window 'b', alpha`: the channel is the same, or it is left to the text.
    let tails: Vec<&str> = places.iter().filter_map(|place| Some(place.rsplit_once("', ")?.1)).collect();
    let tail = match tails.first() {
        Some(first) if tails.len() == places.len() && tails.iter().all(|tail| tail == first) => format!(", {first}"),
        _ => String::new(),
    };
    // `Cl_r (pooled)` and `Cn_r (pooled)`: derivatives of one fit by their names.
    let pooled: Vec<&str> = places.iter().filter_map(|place| place.strip_suffix(" (pooled)")).collect();
    if places.len() > 1 && pooled.len() == places.len() {
        let named = pooled[..pooled.len().min(2 * NAMED)].join(", ");
        let more = pooled.len().saturating_sub(2 * NAMED);
        return if more > 0 { format!("{named} and {more} more (pooled)") } else { format!("{named} (pooled)") };
    }
    match places {
        [] => String::new(),
        [place] => (*place).to_owned(),
        [first, second] => format!("{first} and {second}"),
        [first, .., last] if windows.len() < places.len() => format!("{first} to {last} ({} in all)", places.len()),
        _ => format!("in {} manoeuvres{tail}", windows.len()),
    }
}

/// Whether the numbers at one place of all messages differ.
fn is_range(parts: &[Part]) -> bool {
    matches!(parts, [first @ Part::Number(..), rest @ ..] if rest.iter().any(|part| part != first))
}

/// The parts at one place of all messages: a number, the least and the greatest, or the names there are.
fn together(parts: &[Part]) -> String {
    let mut names: Vec<&str> = Vec::new();
    let mut ends: Option<[(f64, &str); 2]> = None;
    for part in parts {
        match part {
            Part::Name(name) if names.contains(&name.as_str()) => {}
            Part::Name(name) => names.push(name),
            Part::Number(value, text) => {
                let own = (*value, text.as_str());
                let [least, most] = ends.unwrap_or([own; 2]);
                ends = Some([if own.0 < least.0 { own } else { least }, if own.0 > most.0 { own } else { most }]);
            }
        }
    }
    match ends {
        Some([(least, text), (most, _)]) if least == most => text.to_owned(),
        Some([(_, least), (_, most)]) => format!("{least}–{most}"),
        None if names.len() > NAMED + 1 => format!("{} and {} more", names[..NAMED].join(", "), names.len() - NAMED),
        None => names.join(", "),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn folded_lines(messages: &[(&str, &str)]) -> Vec<String> {
        let findings: Vec<Finding> =
            messages.iter().map(|(place, text)| Finding::new(Level::Good, "note", *place, *text)).collect();
        fold(&findings, &["builtin:flights/a.h5", "../b.csv"]).iter().map(ToString::to_string).collect()
    }

    #[test]
    fn messages_that_differ_in_numbers_and_quoted_names_are_one_line() {
        let engine = |name: &str, speed: &str, by: &str| {
            format!(
                "engine '{name}': speed {speed} rpm is {by} rpm below the range 2400 to 2800 rpm: extrapolated, 648 samples"
            )
        };
        let found = folded_lines(&[
            ("manoeuvre '01 a'", &engine("front", "2344.5", "55.5")),
            ("manoeuvre '01 a'", &engine("rear", "2350", "50")),
            ("manoeuvre '02 b'", &engine("front", "2340.0", "60.0")),
            ("manoeuvre '03 c'", &engine("front", "2340.0", "60.0")),
            ("manoeuvre '02 b'", "alpha pauses for 0.80 s at 2141.05 s; nothing was put in its place"),
        ]);
        assert_eq!(
            found,
            [
                "in 3 manoeuvres: engine 'front', 'rear': speed 2340.0–2350 rpm is 50–60.0 rpm below the range 2400 to 2800 \
                 rpm: extrapolated, 648 samples (4 times)",
                "manoeuvre '02 b': alpha pauses for 0.80 s at 2141.05 s; nothing was put in its place",
            ]
        );
    }

    #[test]
    fn recordings_are_called_as_in_the_session_and_words_with_digits_are_no_numbers() {
        let found = folded_lines(&[
            ("F", "/tmp/x/flights/a.h5: source 'm': 3 gaps"),
            ("F", "/tmp/y/b.csv: source 'n': 4 gaps"),
            ("F", "phi1 is in a_2 and 3-2-1-1"),
            ("F", "phi2 is in a_2 and 3-2-1-1"),
            ("F", "flights/other.h5: source 'm': 3 gaps. 2 more."),
        ]);
        assert_eq!(
            found,
            [
                "F: builtin:flights/a.h5, ../b.csv: source 'm', 'n': 3–4 gaps (2 times)",
                "F: phi1 is in a_2 and 3-2-1-1",
                "F: phi2 is in a_2 and 3-2-1-1",
                "F: flights/other.h5: source 'm': 3 gaps. 2 more.",
            ]
        );
        let many: Vec<(&str, String)> = (0..6).map(|k| ("F", format!("no '{k}'"))).collect();
        let many: Vec<(&str, &str)> = many.iter().map(|(place, text)| (*place, text.as_str())).collect();
        assert_eq!(folded_lines(&many), ["F: no '0', '1', '2' and 3 more (6 times)"]);
    }

    #[test]
    fn numbers_that_belong_together_are_said_of_the_first_and_fits_by_their_names() {
        let scatter = |alone: &str, error: &str, pooled: &str| {
            format!(
                "'a' alone says {alone} ± {error}, pooled {pooled}; their scatter is 3.3 times what their errors explain"
            )
        };
        let found = folded_lines(&[
            ("Cl_r (pooled)", &scatter("-1.4", "0.1", "-0.98")),
            ("Cn_p (pooled)", &scatter("0.75", "0.03", "0.24")),
            ("Cn_r (pooled)", &scatter("0.1", "0.02", "0.2")),
        ]);
        assert_eq!(
            found,
            [
                "Cl_r, Cn_p, Cn_r (pooled): 'a' alone says -1.4 ± 0.1, pooled -0.98; their scatter is 3.3 times what their errors \
              explain (first of 3 similar)"
            ]
        );
    }

    #[test]
    fn the_worst_come_first_then_those_found_most_often_and_levels_are_not_mixed() {
        let finding = |level, place: &str, text: &str| Finding::new(level, "nis", format!("manoeuvre '{place}'"), text);
        let found = fold(
            &[
                finding(Level::Good, "a", "ratio 1.1"),
                finding(Level::Caution, "a", "alone"),
                finding(Level::Caution, "b", "ratio 2.5").with_fix_text("look at the noise"),
                finding(Level::Bad, "c", "ratio 9.0"),
                finding(Level::Caution, "d", "ratio 1.6"),
            ],
            &[],
        );
        let lines: Vec<_> = found.iter().map(|line| (line.level, line.count, line.to_string())).collect();
        assert_eq!(
            lines,
            [
                (Level::Bad, 1, "manoeuvre 'c': ratio 9.0".to_owned()),
                (Level::Caution, 2, "manoeuvre 'b' and manoeuvre 'd': ratio 1.6–2.5: look at the noise".to_owned()),
                (Level::Caution, 1, "manoeuvre 'a': alone".to_owned()),
                (Level::Good, 1, "manoeuvre 'a': ratio 1.1".to_owned()),
            ]
        );
    }
}
