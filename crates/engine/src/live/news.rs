//! Findings that an update states: those that are new, not those that every update would repeat.

use std::collections::BTreeMap;

/// Time of flight after which one that was gone is new again, s.
const FORGOTTEN_S: f64 = 60.0;
/// Time of flight after which one is stated again with its present numbers, s.
const RENEWED_S: f64 = 60.0;

/// What was stated so far.
#[derive(Debug, Default)]
pub struct News {
    /// By their text without numbers.
    stated: BTreeMap<String, Stated>,
}

#[derive(Debug)]
struct Stated {
    text: String,
    stated_s: f64,
    seen_s: f64,
}

impl News {
    /// The lines that are new at this time of flight.
    pub fn take_new(&mut self, lines: Vec<String>, time_s: f64) -> Vec<String> {
        self.stated.retain(|_, known| time_s - known.seen_s < FORGOTTEN_S);
        lines.into_iter().filter(|line| self.is_new(line, time_s)).collect()
    }

    fn is_new(&mut self, line: &str, time_s: f64) -> bool {
        let is_number =
            |word: &&str| word.trim_start_matches(['(', '-', '+']).starts_with(|first: char| first.is_ascii_digit());
        let key = line.split_whitespace().filter(|word| !is_number(word)).collect::<Vec<_>>().join(" ");
        let stated = self.stated.get(&key);
        let is_new = stated.is_none_or(|known| known.text != line && time_s - known.stated_s >= RENEWED_S);
        let known = stated.filter(|_| !is_new);
        let text = known.map_or_else(|| line.to_owned(), |known| known.text.clone());
        let stated_s = known.map_or(time_s, |known| known.stated_s);
        self.stated.insert(key, Stated { text, stated_s, seen_s: time_s });
        is_new
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_is_stated_once_its_numbers_once_a_minute_and_again_after_it_was_gone() {
        let mut news = News::default();
        let mut at = |time_s: f64, line: &str| news.take_new(vec![line.to_owned()], time_s).len();
        assert_eq!([at(0.0, "3 lost"), at(0.5, "3 lost"), at(1.0, "4 lost"), at(60.0, "9 lost")], [1, 0, 0, 1]);
        assert_eq!([at(61.0, "no power_1"), at(61.0, "no power_2")], [1, 1]);
        assert_eq!([at(61.0, "9 lost"), at(200.0, "9 lost"), at(200.0, "no alpha")], [0, 1, 1]);
    }
}
