//! Search by words: other forms of a word are found by its stem, other names of a thing by a table of synonyms.

use std::sync::LazyLock;

/// Names of one thing, a group a line.
static SYNONYMS: LazyLock<Vec<Vec<Vec<String>>>> = LazyLock::new(|| {
    let lines = include_str!("synonyms.txt").lines().filter(|line| !line.starts_with('#') && !line.trim().is_empty());
    lines.map(|line| line.split(',').map(stems).collect()).collect()
});

/// Endings that a stem goes without, longer ones first.
const ENDINGS: &[&str] = &[
    "ations", "ation", "ators", "ator", "ating", "ated", "ates", "ate", "ities", "ity", "ions", "ion", "ings", "ing",
    "ers", "er", "ed", "es", "s", "e",
];

/// Letters a stem has at least.
const SHORTEST_STEM: usize = 4;

/// Quality of a match, the best first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Rank {
    /// The words as typed.
    Typed,
    /// Other forms of the words.
    Stems,
    Synonym,
    /// The letters as typed, within a longer word.
    Part,
    /// All words, apart from each other.
    Scattered,
}

/// Words of a question that say nothing of its subject.
const FILLERS: &[&str] =
    &["a", "an", "are", "do", "does", "for", "how", "i", "in", "is", "my", "of", "the", "to", "what", "where", "why"];

/// A text made ready to be searched.
pub struct Prepared {
    lowered: String,
    words: Vec<String>,
}

impl Prepared {
    /// The text with the stems of its words.
    pub fn new(text: &str) -> Self {
        Self { lowered: text.to_lowercase(), words: stems(text) }
    }
}

/// A search for some words.
pub struct Query {
    typed: String,
    stems: Vec<String>,
    synonyms: Vec<Vec<String>>,
}

impl Query {
    /// The search for `typed`, whatever its case.
    pub fn new(typed: &str) -> Self {
        let words = typed.split_whitespace().filter(|word| !FILLERS.contains(&word.to_lowercase().as_str()));
        let words = words.collect::<Vec<_>>().join(" ");
        let typed = if words.is_empty() { typed } else { &words };
        let stems = stems(typed);
        let mut synonyms = Vec::new();
        for group in SYNONYMS.iter() {
            for name in group.iter().filter(|name| contains(&stems, name)) {
                let others = group.iter().filter(|other| *other != name);
                synonyms.extend(others.map(|other| replaced(&stems, name, other)));
            }
        }
        Self { typed: typed.trim().to_lowercase(), stems, synonyms }
    }

    /// How well `text` matches; `None` where it does not.
    pub fn rank(&self, text: &Prepared) -> Option<Rank> {
        if self.typed.is_empty() {
            return None;
        }
        let Prepared { lowered, words } = text;
        let holds_typed = lowered.contains(&self.typed);
        if contains(words, &self.stems) {
            return Some(if holds_typed { Rank::Typed } else { Rank::Stems });
        }
        if self.synonyms.iter().any(|synonym| contains(words, synonym)) {
            return Some(Rank::Synonym);
        }
        if holds_typed {
            return Some(Rank::Part);
        }
        if self.stems.is_empty() {
            return None;
        }
        self.stems.iter().all(|stem| words.contains(stem)).then_some(Rank::Scattered)
    }
}

/// Stems of the words of a text, in order.
fn stems(text: &str) -> Vec<String> {
    let words = text.split(|letter: char| !letter.is_alphanumeric() && letter != '_');
    words.filter(|word| !word.is_empty()).map(stem).collect()
}

/// A word without its endings and without a doubled letter at its end: `damp` of damping, `fit` of fitted.
fn stem(word: &str) -> String {
    let mut stem = word.to_lowercase();
    let mut is_first = true;
    loop {
        let plural =
            is_first && stem.len() > 3 && stem.ends_with('s') && !stem.ends_with("ss") && !stem.ends_with("is");
        let ending = ENDINGS.iter().find(|ending| {
            stem.strip_suffix(**ending).is_some_and(|rest| rest.chars().count() >= SHORTEST_STEM)
                && !stem.ends_with("ss")
        });
        let cut = match ending {
            Some(ending) => ending.len(),
            None if plural => 1,
            None => break,
        };
        stem.truncate(stem.len() - cut);
        is_first = false;
    }
    let mut last = stem.chars().rev();
    if stem.len() > 3 && last.next().is_some_and(|letter| letter.is_alphabetic() && last.next() == Some(letter)) {
        stem.pop();
    }
    stem
}

/// Whether `part` is in `words`, one word behind the other.
fn contains(words: &[String], part: &[String]) -> bool {
    !part.is_empty() && words.windows(part.len()).any(|there| there == part)
}

/// `words` with `other` for every `part`.
fn replaced(words: &[String], part: &[String], other: &[String]) -> Vec<String> {
    let mut new = Vec::new();
    let mut rest = words;
    while let [first, behind @ ..] = rest {
        if rest.starts_with(part) {
            new.extend_from_slice(other);
            rest = &rest[part.len()..];
        } else {
            new.push(first.clone());
            rest = behind;
        }
    }
    new
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn forms_of_a_word_have_one_stem() {
        for forms in [
            &["autocorrelated", "autocorrelation", "autocorrelations"][..],
            &["interval", "intervals"],
            &["mode", "modes"],
            &["damping", "damped", "damp"],
            &["fit", "fits", "fitted", "fitting"],
            &["filter", "filters", "filtering", "filtered"],
            &["estimate", "estimates", "estimated", "estimation", "estimator"],
            &["model", "modelling", "modelled", "models"],
            &["collinear", "collinearity"],
        ] {
            let first = stem(forms[0]);
            assert!(forms.iter().all(|form| stem(form) == first), "{forms:?}: {:?}", forms.map_stems());
        }
        assert_ne!(stem("mode"), stem("model"));
        assert_ne!(stem("correlated"), stem("corrected"));
    }

    trait MapStems {
        fn map_stems(&self) -> Vec<String>;
    }

    impl MapStems for &[&str] {
        fn map_stems(&self) -> Vec<String> {
            self.iter().map(|form| stem(form)).collect()
        }
    }

    #[test]
    fn matches_rank_by_how_near_they_are() {
        let rank = |sought: &str, text: &str| Query::new(sought).rank(&Prepared::new(text));
        let query = "confidence interval";
        assert_eq!(rank(query, "The confidence interval of Cl_p"), Some(Rank::Typed));
        assert_eq!(rank(query, "Confidence intervals"), Some(Rank::Typed), "the plural holds the singular");
        assert_eq!(rank("what is NIS", "NIS: its mean"), Some(Rank::Typed));
        assert_eq!(rank("wind", "the window"), Some(Rank::Part));
        assert_eq!(rank("confidence intervals", "A confidence interval"), Some(Rank::Stems));
        assert_eq!(rank(query, "its standard errors"), Some(Rank::Synonym));
        assert_eq!(rank(query, "confidence of an interval"), Some(Rank::Scattered));
        assert_eq!(rank(query, "an interval"), None);
        assert_eq!(rank("", "anything"), None);
    }
}
