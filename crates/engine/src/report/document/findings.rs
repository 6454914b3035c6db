//! Everything found on the way: what differs only in numbers and names is one line.

use std::collections::HashMap;
use std::path::Path;

use super::{Block, Contents, paragraph};

/// Names a line says before it only counts the others.
const NAMED: usize = 3;

/// The section.
pub fn warnings(contents: &Contents<'_>) -> Vec<Block> {
    let lines = lines(contents);
    if lines.is_empty() {
        return vec![paragraph("Nothing was found that wants attention.")];
    }
    vec![
        paragraph(
            "What differs only in its numbers or in the name of an engine, a source or a file is one line, from the least number to the greatest.",
        ),
        Block::List(lines),
    ]
}

/// One line per kind of finding, with its places.
pub fn lines(contents: &Contents<'_>) -> Vec<String> {
    let results = contents.results;
    let mut groups = Groups::default();
    let paths: Vec<&str> = results.recordings.iter().map(|row| row.path.as_str()).collect();
    let mut note = |place: &str, text: &str| groups.note(place, split(&paths, text));
    results.warnings.iter().for_each(|text| note("session", text));
    for flight in &results.flights {
        flight.warnings.iter().for_each(|text| note(&flight.name, text));
    }
    for engine in &results.engines {
        engine.warnings.iter().for_each(|text| note(&engine.flight, text));
    }
    for window in &results.windows {
        window.warnings.iter().for_each(|text| note(&window.name, text));
    }
    contents.snapshot.failures().iter().for_each(|(place, text)| note(place, text));
    groups.list.iter().map(Group::line).collect()
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
    let mut said = String::new();
    let mut rest = text;
    if let Some((place, behind)) = text.split_once(": ") {
        let tail = |path: &str| path.trim_start_matches("builtin:").trim_start_matches(['.', '/']).to_owned();
        let found = paths.iter().filter(|path| Path::new(place).ends_with(tail(path)));
        if let Some(path) = found.max_by_key(|path| path.len()) {
            message.between.push(String::new());
            message.parts.push(Part::Name((*path).to_owned()));
            (said, rest) = (": ".to_owned(), behind);
        }
    }
    while let Some(first) = rest.chars().next() {
        let at_start = said.is_empty() || said.ends_with([' ', '(']);
        match part(rest).filter(|_| at_start) {
            Some((part, length)) => {
                message.between.push(std::mem::take(&mut said));
                message.parts.push(part);
                rest = &rest[length..];
            }
            None => {
                said.push(first);
                rest = &rest[first.len_utf8()..];
            }
        }
    }
    message.between.push(said);
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
struct Group {
    between: Vec<String>,
    /// Of each part, every one there was.
    parts: Vec<Vec<Part>>,
    /// Of each message.
    places: Vec<String>,
}

#[derive(Default)]
struct Groups {
    list: Vec<Group>,
    known: HashMap<Vec<String>, usize>,
}

impl Groups {
    fn note(&mut self, place: &str, message: Message) {
        let same = |parts: &[Vec<Part>]| {
            let kind = |part: &Part| matches!(part, Part::Number(..));
            parts.iter().zip(&message.parts).all(|(all, part)| kind(&all[0]) == kind(part))
        };
        let index = self.known.get(&message.between).copied().filter(|&index| same(&self.list[index].parts));
        let index = index.unwrap_or_else(|| {
            let parts = vec![Vec::new(); message.parts.len()];
            self.known.insert(message.between.clone(), self.list.len());
            self.list.push(Group { between: message.between.clone(), parts, places: Vec::new() });
            self.list.len() - 1
        });
        let group = &mut self.list[index];
        group.parts.iter_mut().zip(message.parts).for_each(|(all, part)| all.push(part));
        group.places.push(place.to_owned());
    }
}

impl Group {
    fn line(&self) -> String {
        let mut text = self.between[0].clone();
        for (parts, between) in self.parts.iter().zip(&self.between[1..]) {
            text.push_str(&together(parts));
            text.push_str(between);
        }
        let mut places: Vec<&str> = self.places.iter().map(String::as_str).collect();
        places.dedup();
        let times = match (self.places.len(), places.len()) {
            (all, distinct) if all > distinct => format!(" ({all} times)"),
            _ => String::new(),
        };
        match places[..] {
            [place] => format!("{place}: {text}{times}"),
            [first, .., last] => format!("{first} to {last} ({} places): {text}{times}", places.len()),
            [] => text,
        }
    }
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

    fn said(messages: &[(&str, &str)]) -> Vec<String> {
        let mut groups = Groups::default();
        messages
            .iter()
            .for_each(|(place, text)| groups.note(place, split(&["builtin:flights/a.h5", "../b.csv"], text)));
        groups.list.iter().map(Group::line).collect()
    }

    #[test]
    fn messages_that_differ_in_numbers_and_quoted_names_are_one_line() {
        let engine = |name: &str, speed: &str, by: &str| {
            format!(
                "engine '{name}': speed {speed} rpm is {by} rpm below the range 2400 to 2800 rpm: extrapolated, 648 samples"
            )
        };
        let found = said(&[
            ("01 a", &engine("front", "2344.5", "55.5")),
            ("01 a", &engine("rear", "2350", "50")),
            ("02 b", &engine("front", "2340.0", "60.0")),
            ("02 b", "alpha pauses for 0.80 s at 2141.05 s; nothing was put in its place"),
        ]);
        assert_eq!(
            found,
            [
                "01 a to 02 b (2 places): engine 'front', 'rear': speed 2340.0–2350 rpm is 50–60.0 rpm below the range 2400 to 2800 \
                 rpm: extrapolated, 648 samples (3 times)",
                "02 b: alpha pauses for 0.80 s at 2141.05 s; nothing was put in its place",
            ]
        );
    }

    #[test]
    fn recordings_are_called_as_in_the_session_and_words_with_digits_are_no_numbers() {
        let found = said(&[
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
        assert_eq!(said(&many), ["F: no '0', '1', '2' and 3 more (6 times)"]);
    }
}
