//! Words in the names of channels, whatever their language writes accents, articles and capitals.

/// Words without a meaning of their own.
const ARTICLES: [&str; 11] = ["de", "du", "des", "d", "la", "le", "les", "l", "der", "die", "das"];

/// A name in small letters without accents, articles and what parts its words: `vitesseroulis` of `Vitesse de roulis`.
pub(crate) fn join_words(name: &str) -> String {
    split_words(name).into_iter().filter(|word| !ARTICLES.contains(&word.as_str())).collect()
}

/// Whether a name says that it is commanded, not measured.
pub(crate) fn is_commanded(name: &str) -> bool {
    split_words(name).iter().any(|word| word.starts_with("soll") || word == "consigne" || word == "cible")
}

/// Words of a name, in small letters without accents: what other signs or a change to capitals part.
fn split_words(name: &str) -> Vec<String> {
    let mut words = vec![String::new()];
    let mut is_after_small = false;
    for letter in name.chars().filter(|letter| !is_accent(*letter)) {
        if !letter.is_alphanumeric() || (is_after_small && letter.is_uppercase()) {
            words.push(String::new());
        }
        if let Some(word) = words.last_mut() {
            push_plain(word, letter);
        }
        is_after_small = letter.is_lowercase();
    }
    words
}

/// Letters and digits of a name, small and without accents.
pub(crate) fn plain_letters(name: &str) -> String {
    let mut plain = String::with_capacity(name.len());
    name.chars().for_each(|letter| push_plain(&mut plain, letter));
    plain
}

/// Whether it is an accent that follows its letter (Unicode, combining diacritical marks).
fn is_accent(letter: char) -> bool {
    ('\u{300}'..='\u{36f}').contains(&letter)
}

/// Adds a letter or digit, small and without its accent; nothing of any other sign.
fn push_plain(text: &mut String, letter: char) {
    for small in letter.to_lowercase().filter(|letter| letter.is_alphanumeric()) {
        match small {
            'à' | 'á' | 'â' | 'ã' | 'ä' | 'å' => text.push('a'),
            'ç' => text.push('c'),
            'è' | 'é' | 'ê' | 'ë' => text.push('e'),
            'ì' | 'í' | 'î' | 'ï' => text.push('i'),
            'ò' | 'ó' | 'ô' | 'õ' | 'ö' => text.push('o'),
            'ù' | 'ú' | 'û' | 'ü' => text.push('u'),
            'ñ' => text.push('n'),
            'ß' => text.push_str("ss"),
            'œ' => text.push_str("oe"),
            'æ' => text.push_str("ae"),
            other => text.push(other),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_joined_without_accents_articles_and_signs() {
        for (name, joined) in [
            ("Vitesse de roulis", "vitesseroulis"),
            ("Vitesse de l'incidence", "vitesseincidence"),
            ("Dérapage", "derapage"),
            ("De\u{301}rapage", "derapage"),
            ("GouverneDeProfondeur", "gouverneprofondeur"),
            ("Höhe_MSL", "hohemsl"),
            ("Ho\u{308}henruder", "hohenruder"),
            ("Außentemperatur", "aussentemperatur"),
            ("Fluggeschw. (wahr)", "fluggeschwwahr"),
            ("dr", "dr"),
        ] {
            assert_eq!(join_words(name), joined, "{name}");
        }
        assert!(is_commanded("Soll-Kurs") && is_commanded("Cap consigne") && !is_commanded("Kurs"));
    }
}
