//! Findings of one kind in one line: those that differ only in the numbers and names of their sentence or in their place.

use std::path::Path;

use doublet_core::message::Part;

use super::{Finding, Level};
use crate::session::{Place, write_fix};

/// Names a line says before it only counts the others.
const NAMED: usize = 3;
/// Numbers of a line that may be ranges: with more of them it is not clear which belong together, and the first finding represents all.
const RANGES: usize = 2;

/// Findings of one kind.
#[derive(Clone, Debug, PartialEq)]
pub struct Folded {
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
    "physics", "accelerometer", "gravity", "aircraft", "timing", "saturated", "stuck", "dynamic-pressure", "turn",
    "sampling", "loading", "propulsion", "failed", "nis", "innovation", "smoother",
];

/// Folds findings by level, kind and sentence; the worst first, of one level causes before what follows from them, then those found
/// most often. `paths` are the recordings of the session: a file that was read is called as the session calls it.
pub fn fold(findings: &[Finding], paths: &[&str]) -> Vec<Folded> {
    let mut groups: Vec<Vec<&Finding>> = Vec::new();
    for finding in findings {
        let is_alike = |group: &&mut Vec<&Finding>| {
            let first = group[0];
            (first.level, first.code) == (finding.level, finding.code) && first.text.is_alike(&finding.text)
        };
        match groups.iter_mut().find(is_alike) {
            Some(group) => group.push(finding),
            None => groups.push(vec![finding]),
        }
    }
    let mut folded: Vec<Folded> = groups.iter().map(|group| fold_group(group, paths)).collect();
    let cause = |code: &str| CAUSES.iter().position(|cause| *cause == code).unwrap_or(CAUSES.len());
    folded.sort_by_key(|line| (std::cmp::Reverse(line.level), cause(line.code), std::cmp::Reverse(line.count)));
    folded
}

/// One line for findings whose sentences are alike.
fn fold_group(group: &[&Finding], paths: &[&str]) -> Folded {
    let (first, count) = (group[0], group.len());
    let columns: Vec<Vec<&Part>> = (0..first.text.parts().len())
        .map(|index| group.iter().filter_map(|finding| finding.text.parts().get(index)).collect())
        .collect();
    let differs = |parts: &[&Part]| parts.iter().any(|part| *part != parts[0]);
    let ranges = columns.iter().filter(|parts| matches!(parts[0], Part::Number(..)) && differs(parts)).count();
    let has_details = columns.iter().any(|parts| matches!(parts[0], Part::Detail(_)) && differs(parts));
    let is_first_alone = ranges > RANGES || has_details;
    let shown = |parts: &Vec<&Part>| together(if is_first_alone { &parts[..1] } else { parts }, paths);
    let mut text: String = columns.iter().map(shown).collect();
    let mut places: Vec<&Place> = Vec::new();
    for finding in group {
        if !places.contains(&&finding.place) {
            places.push(&finding.place);
        }
    }
    if is_first_alone {
        text.push_str(&format!(
            " ({}, first of {count} similar)",
            first.place.pooled().unwrap_or(&first.place.to_string())
        ));
    } else if count > places.len() {
        text.push_str(&format!(" ({count} times)"));
    }
    let place = in_words(&places);
    Folded { level: first.level, code: first.code, place, text, fix: join_fixes(group), count }
}

/// What to do: each different fix once; beyond a few only how many more there are.
fn join_fixes(group: &[&Finding]) -> String {
    let mut fixes: Vec<&str> = Vec::new();
    for finding in group.iter().filter(|finding| !finding.fix_text.is_empty()) {
        if !fixes.contains(&finding.fix_text.as_str()) {
            fixes.push(&finding.fix_text);
        }
    }
    let shown = &fixes[..fixes.len().min(NAMED)];
    let separator = if shown.iter().all(|fix| fix.ends_with('.')) { " " } else { "; " };
    let shown = shown.join(separator);
    let more = fixes.len().saturating_sub(NAMED);
    if more > 0 { format!("{shown}{separator}{more} more alike.") } else { shown }
}

/// Places in words: one or two by their names, more by their number and what they have in common.
fn in_words(places: &[&Place]) -> String {
    match places {
        [] => String::new(),
        [place] => place.to_string(),
        _ => pooled_in_words(places)
            .or_else(|| manoeuvres_in_words(places))
            .unwrap_or_else(|| format!("{} and {} more", places[0], places.len() - 1)),
    }
}

/// Places that share a sentence, by their names: `manoeuvres '01 a', '02 b'`, `CX, CY (pooled)`; beyond a few, how many more there are.
pub fn list_places(places: &[&Place]) -> String {
    const LISTED: usize = 6;
    if let [place] = places {
        return place.to_string();
    }
    if let Some(names) = pooled_in_words(places) {
        return names;
    }
    let name = |place: &&Place| match place {
        Place::Manoeuvre { name, part: None } => Some(format!("'{name}'")),
        _ => None,
    };
    let manoeuvres: Option<Vec<String>> = places.iter().map(name).collect();
    let (head, names) = match manoeuvres {
        Some(names) => ("manoeuvres ", names),
        None => ("", places.iter().map(ToString::to_string).collect()),
    };
    let more = names.len().saturating_sub(LISTED);
    let more = if more > 0 { format!(" and {more} more") } else { String::new() };
    format!("{head}{}{more}", names[..names.len().min(LISTED)].join(", "))
}

/// Failures, each sentence once with the places it concerns, in the order in which they were met.
pub fn list_failures(failures: &[(Place, String)]) -> Vec<String> {
    let mut groups: Vec<(&str, Vec<&Place>)> = Vec::new();
    for (place, error) in failures {
        match groups.iter_mut().find(|(known, _)| known == error) {
            Some((_, places)) => places.push(place),
            None => groups.push((error, vec![place])),
        }
    }
    groups.iter().map(|(error, places)| format!("{}: {error}", list_places(places))).collect()
}

/// Derivatives of pooled estimates by their names.
fn pooled_in_words(places: &[&Place]) -> Option<String> {
    let names: Vec<&str> = places.iter().map(|place| place.pooled()).collect::<Option<_>>()?;
    let named = names[..names.len().min(2 * NAMED)].join(", ");
    let more = names.len().saturating_sub(2 * NAMED);
    Some(if more > 0 { format!("{named} and {more} more (pooled)") } else { format!("{named} (pooled)") })
}

/// Two places by their names; manoeuvres by their number, with the channel that they share.
fn manoeuvres_in_words(places: &[&Place]) -> Option<String> {
    if let [first, second] = places {
        return Some(format!("{first} and {second}"));
    }
    let part = |place: &&Place| match place {
        Place::Manoeuvre { part, .. } => Some(part.clone()),
        _ => None,
    };
    let parts: Vec<Option<String>> = places.iter().map(part).collect::<Option<_>>()?;
    let shared = parts[0].as_ref().filter(|first| parts.iter().all(|part| part.as_ref() == Some(*first)));
    let shared = shared.map_or_else(String::new, |part| format!(", {part}"));
    Some(format!("in {} manoeuvres{shared}", places.len()))
}

/// The parts at one place of all sentences: a number, the least and the greatest, or the names there are.
fn together(parts: &[&Part], paths: &[&str]) -> String {
    if let Part::Number(..) = parts[0] {
        return range(parts);
    }
    let mut names: Vec<String> = Vec::new();
    for part in parts {
        let name = match part {
            Part::File(path) => called_in_session(path, paths),
            _ => part.to_string(),
        };
        if !names.contains(&name) {
            names.push(name);
        }
    }
    match names.len() {
        count if count > NAMED + 1 => format!("{} and {} more", names[..NAMED].join(", "), count - NAMED),
        _ => names.join(", "),
    }
}

/// A number, or the least and the greatest.
fn range(parts: &[&Part]) -> String {
    let number = |part: &&Part| match part {
        Part::Number(value, text) => Some((*value, text.clone())),
        _ => None,
    };
    let numbers = || parts.iter().filter_map(number);
    let (Some(least), Some(most)) =
        (numbers().min_by(|a, b| a.0.total_cmp(&b.0)), numbers().max_by(|a, b| a.0.total_cmp(&b.0)))
    else {
        return String::new();
    };
    if least.1 == most.1 { least.1 } else { format!("{}–{}", least.1, most.1) }
}

/// The path by which the session calls a file that was read.
fn called_in_session(file: &Path, paths: &[&str]) -> String {
    let tail = |path: &str| path.trim_start_matches("builtin:").trim_start_matches(['.', '/']).to_owned();
    let called = paths.iter().filter(|path| file.ends_with(tail(path))).max_by_key(|path| path.len());
    called.map_or_else(|| file.display().to_string(), |path| (*path).to_owned())
}

#[cfg(test)]
mod tests {
    use doublet_core::message;
    use doublet_core::message::{Message, file, quoted};

    use super::*;

    fn folded(findings: Vec<(Place, Message)>) -> Vec<Folded> {
        let findings: Vec<Finding> =
            findings.into_iter().map(|(place, text)| Finding::new(Level::Good, "note", place, text)).collect();
        fold(&findings, &["builtin:flights/a.h5", "../b.csv"])
    }

    fn lines(folded: &[Folded]) -> Vec<String> {
        folded.iter().map(ToString::to_string).collect()
    }

    fn engine(manoeuvre: &str, name: &str, speed: f64) -> (Place, Message) {
        let text = message!(
            "engine {}: speed {:.0} rpm is {:.0} rpm below 2400 rpm, {} samples",
            quoted(name),
            speed,
            2400.0 - speed,
            648_usize
        );
        (Place::manoeuvre(manoeuvre), text)
    }

    #[test]
    fn findings_that_differ_in_numbers_and_names_are_one_line() {
        let found = folded(vec![
            engine("01 a", "front", 2344.0),
            engine("01 a", "rear", 2350.0),
            engine("02 b", "front", 2340.0),
            engine("03 c", "front", 2340.0),
            (Place::manoeuvre("02 b"), message!("alpha pauses for {:.2} s", 0.8)),
        ]);
        assert_eq!(
            lines(&found),
            [
                "in 3 manoeuvres: engine 'front', 'rear': speed 2340–2350 rpm is 50–60 rpm below 2400 rpm, 648 samples (4 times)",
                "manoeuvre '02 b': alpha pauses for 0.80 s",
            ]
        );
        assert_eq!(found.iter().map(|line| line.count).collect::<Vec<_>>(), [4, 1]);
    }

    #[test]
    fn files_are_called_as_in_the_session_and_words_keep_findings_apart() {
        let gaps = |path: &str, source: &str, count: usize| {
            (Place::flight("F"), message!("{}: source {}: {} gaps", file(Path::new(path)), quoted(source), count))
        };
        let channel = |name: &str| (Place::flight("F"), message!("{} is in a_2 and 3-2-1-1", name));
        let found = folded(vec![
            gaps("/tmp/x/flights/a.h5", "m", 3),
            gaps("/tmp/y/b.csv", "n", 4),
            channel("phi1"),
            channel("phi2"),
        ]);
        assert_eq!(
            lines(&found),
            [
                "flight 'F': builtin:flights/a.h5, ../b.csv: source 'm', 'n': 3–4 gaps (2 times)",
                "flight 'F': phi1 is in a_2 and 3-2-1-1",
                "flight 'F': phi2 is in a_2 and 3-2-1-1",
            ]
        );
        let many = folded((0..6).map(|k| (Place::flight("F"), message!("no {}", quoted(k.to_string())))).collect());
        assert_eq!(lines(&many), ["flight 'F': no '0', '1', '2' and 3 more (6 times)"]);
    }

    #[test]
    fn numbers_that_belong_together_are_those_of_the_first_and_derivatives_keep_their_names() {
        let scatter = |derivative: &str, [alone, error, pooled]: [f64; 3]| {
            let text = message!("{} gives {:.2} ± {:.2}, together {:.2}", quoted("a"), alone, error, pooled);
            (Place::derivative(derivative, None), text)
        };
        let found = folded(vec![
            scatter("Cl_r", [-1.4, 0.1, -0.98]),
            scatter("Cn_p", [0.75, 0.03, 0.24]),
            scatter("Cn_r", [0.1, 0.02, 0.2]),
        ]);
        let expected = "Cl_r, Cn_p, Cn_r (pooled): 'a' gives -1.40 ± 0.10, together -0.98 (Cl_r, first of 3 similar)";
        assert_eq!(lines(&found), [expected]);
    }

    #[test]
    fn different_fixes_of_one_kind_are_all_said() {
        let fixed = |derivative: &str, fix: &str| {
            let text = message!("{} is nearly collinear", quoted(derivative));
            Finding::new(Level::Caution, "vif", Place::derivative(derivative, None), text).with_fix_text(fix)
        };
        let names = ["a", "b", "c", "d"];
        for (count, expected) in [(1, "a."), (2, "a. b."), (4, "a. b. c. 1 more alike.")] {
            let found: Vec<Finding> = names[..count].iter().map(|name| fixed(name, &format!("{name}."))).collect();
            assert_eq!(fold(&found, &[])[0].fix, expected);
        }
        let same = [fixed("a", "Remove a term."), fixed("b", "Remove a term.")];
        assert_eq!(fold(&same, &[])[0].fix, "Remove a term.");
    }

    #[test]
    fn manoeuvres_share_their_channel_and_other_places_are_counted() {
        let offset = |name: &str| (Place::in_manoeuvre(name, "alpha"), message!("offset"));
        assert_eq!(lines(&folded(["a", "b", "c"].map(offset).into())), ["in 3 manoeuvres, alpha: offset"]);
        let flight = |name: &str| (Place::flight(name), message!("late"));
        assert_eq!(lines(&folded(["a", "b", "c"].map(flight).into())), ["flight 'a' and 2 more: late"]);
    }

    #[test]
    fn failures_that_share_a_sentence_are_one_line_with_their_places() {
        let manoeuvres = (1..9).map(|k| (Place::manoeuvre(&format!("0{k}")), "too short".to_owned()));
        let others = [
            (Place::flight("F"), "no file".to_owned()),
            (Place::derivative("CX", None), "no data".to_owned()),
            (Place::derivative("CY", None), "no data".to_owned()),
            (Place::in_manoeuvre("01", "alpha"), "no file".to_owned()),
        ];
        assert_eq!(
            list_failures(&manoeuvres.chain(others).collect::<Vec<_>>()),
            [
                "manoeuvres '01', '02', '03', '04', '05', '06' and 2 more: too short",
                "flight 'F', manoeuvre '01', alpha: no file",
                "CX, CY (pooled): no data",
            ]
        );
    }

    #[test]
    fn the_worst_come_first_then_those_found_most_often_and_levels_are_not_mixed() {
        let finding = |level, place: &str, ratio: f64| {
            Finding::new(level, "nis", Place::manoeuvre(place), message!("ratio {:.1}", ratio))
        };
        let found = fold(
            &[
                finding(Level::Good, "a", 1.1),
                Finding::new(Level::Caution, "nis", Place::manoeuvre("a"), "alone"),
                finding(Level::Caution, "b", 2.5).with_fix_text("look at the noise"),
                finding(Level::Bad, "c", 9.0),
                finding(Level::Caution, "d", 1.6),
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
