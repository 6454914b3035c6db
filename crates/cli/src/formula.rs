//! Formulas of the manual in letters that every screen has: Greek, raised and lowered characters, fractions in one line.

use std::iter::Peekable;
use std::str::Chars;

/// Names of TeX that stand for a letter or sign.
const SIGNS: &[(&str, &str)] = &[
    ("alpha", "α"),
    ("beta", "β"),
    ("gamma", "γ"),
    ("delta", "δ"),
    ("eta", "η"),
    ("theta", "θ"),
    ("lambda", "λ"),
    ("mu", "μ"),
    ("nu", "ν"),
    ("pi", "π"),
    ("rho", "ρ"),
    ("sigma", "σ"),
    ("tau", "τ"),
    ("phi", "φ"),
    ("psi", "ψ"),
    ("omega", "ω"),
    ("Gamma", "Γ"),
    ("Delta", "Δ"),
    ("Theta", "Θ"),
    ("Sigma", "Σ"),
    ("Phi", "Φ"),
    ("Psi", "Ψ"),
    ("Omega", "Ω"),
    ("sum", "Σ"),
    ("int", "∫"),
    ("partial", "∂"),
    ("infty", "∞"),
    ("times", " × "),
    ("cdot", "·"),
    ("pm", " ± "),
    ("le", " ≤ "),
    ("ge", " ≥ "),
    ("approx", " ≈ "),
    ("quad", "\u{2003}"),
    ("qquad", "\u{2003}\u{2003}"),
    (",", " "),
    (";", " "),
    (":", " "),
    (" ", " "),
    ("!", ""),
    ("{", "{"),
    ("}", "}"),
    ("%", "%"),
    ("_", "_"),
];

/// Names that only size or set what follows.
const SETTINGS: &[&str] =
    &["left", "right", "big", "Big", "bigl", "bigr", "Bigl", "Bigr", "mathrm", "mathbf", "text", "displaystyle"];

/// Marks over the letter before them.
const ACCENTS: &[(&str, char)] =
    &[("dot", '\u{307}'), ("ddot", '\u{308}'), ("hat", '\u{302}'), ("bar", '\u{304}'), ("tilde", '\u{303}')];

/// Characters with a raised form.
const RAISED: &[(char, char)] = &[
    ('0', '⁰'),
    ('1', '¹'),
    ('2', '²'),
    ('3', '³'),
    ('4', '⁴'),
    ('5', '⁵'),
    ('6', '⁶'),
    ('7', '⁷'),
    ('8', '⁸'),
    ('9', '⁹'),
    ('+', '⁺'),
    ('-', '⁻'),
    ('T', 'ᵀ'),
    ('n', 'ⁿ'),
];

/// Characters with a lowered form.
const LOWERED: &[(char, char)] = &[
    ('0', '₀'),
    ('1', '₁'),
    ('2', '₂'),
    ('3', '₃'),
    ('4', '₄'),
    ('5', '₅'),
    ('6', '₆'),
    ('7', '₇'),
    ('8', '₈'),
    ('9', '₉'),
    ('a', 'ₐ'),
    ('e', 'ₑ'),
    ('h', 'ₕ'),
    ('i', 'ᵢ'),
    ('j', 'ⱼ'),
    ('k', 'ₖ'),
    ('l', 'ₗ'),
    ('m', 'ₘ'),
    ('n', 'ₙ'),
    ('o', 'ₒ'),
    ('p', 'ₚ'),
    ('r', 'ᵣ'),
    ('s', 'ₛ'),
    ('t', 'ₜ'),
    ('u', 'ᵤ'),
    ('v', 'ᵥ'),
    ('x', 'ₓ'),
];

/// A page with its formulas made readable: those in a line where they stand, those of their own line set in from the margin.
pub fn readable_page(text: &str) -> String {
    let mut page = String::with_capacity(text.len());
    let mut rest = text;
    while let Some(at) = rest.find("\\\\(").into_iter().chain(rest.find("\\\\[")).min() {
        page.push_str(&rest[..at]);
        let (opening, formula) = rest[at..].split_at(3);
        let is_own_line = opening.ends_with('[');
        let end = formula.find(if is_own_line { "\\\\]" } else { "\\\\)" });
        let (formula, after) = end.map_or((formula, ""), |end| (&formula[..end], &formula[end + 3..]));
        let formula = readable(formula.trim());
        // Set in as words are: letters of one width have no marks over them. Two spaces end the line there.
        page.push_str(&if is_own_line { format!("> {formula}  ") } else { formula });
        rest = after;
    }
    page.push_str(rest);
    page
}

/// One formula of TeX.
pub fn readable(formula: &str) -> String {
    let mut left = formula.chars().peekable();
    let text = until(&mut left, None);
    // Signs bring room of their own.
    text.split(' ').filter(|part| !part.is_empty()).collect::<Vec<_>>().join(" ")
}

/// Everything up to `end`, which is taken too.
fn until(left: &mut Peekable<Chars<'_>>, end: Option<char>) -> String {
    let mut text = String::new();
    while let Some(letter) = left.next() {
        match letter {
            letter if Some(letter) == end => break,
            '\\' => command(left, &mut text),
            '{' => text.push_str(&until(left, Some('}'))),
            '^' => script(left, RAISED, "^", &mut text),
            '_' => script(left, LOWERED, "", &mut text),
            '&' => {}
            '-' => text.push('\u{2212}'),
            letter => text.push(letter),
        }
    }
    text
}

/// What a command takes: a group in braces, a command, or one character.
fn argument(left: &mut Peekable<Chars<'_>>) -> String {
    while left.next_if(|letter| *letter == ' ').is_some() {}
    let mut text = String::new();
    match left.next() {
        Some('{') => return until(left, Some('}')),
        Some('\\') => command(left, &mut text),
        Some(letter) => text.push(letter),
        None => {}
    }
    text
}

/// The command behind a backslash.
fn command(left: &mut Peekable<Chars<'_>>, text: &mut String) {
    let mut name = String::new();
    while let Some(letter) = left.next_if(char::is_ascii_alphabetic) {
        name.push(letter);
    }
    if name.is_empty() {
        name.extend(left.next());
    }
    let name = name.as_str();
    if let Some((_, sign)) = SIGNS.iter().find(|(known, _)| *known == name) {
        text.push_str(sign);
    } else if let Some((_, mark)) = ACCENTS.iter().find(|(known, _)| *known == name) {
        text.push_str(&argument(left));
        text.push(*mark);
    } else if name == "frac" {
        let (above, below) = (grouped(argument(left)), grouped(argument(left)));
        text.push_str(&format!("{above}/{below}"));
    } else if name == "sqrt" {
        let under = argument(left);
        let is_one = under.chars().count() == 1;
        text.push_str(&if is_one { format!("√{under}") } else { format!("√({under})") });
    } else if !SETTINGS.contains(&name) {
        // Names of functions stand as they are, apart from what is beside them.
        let joined = text.is_empty() || text.ends_with([' ', '(', '[']);
        text.push_str(if joined { "" } else { " " });
        text.push_str(name);
        text.push_str(if left.peek().is_some_and(|next| next.is_alphanumeric() || *next == '\\') { " " } else { "" });
    }
}

/// What stands above or below the line of a fraction, in brackets where it is a sum or a product.
fn grouped(part: String) -> String {
    let is_root = part.starts_with("√(") && part.ends_with(')') && part.matches('(').count() == 1;
    let is_one = is_root || !part.trim().contains([' ', '+', '\u{2212}', '·', '/']);
    if is_one { part.trim().to_owned() } else { format!("({})", part.trim()) }
}

/// A raised or lowered part: in such characters where all of it has them, else behind `sign`.
fn script(left: &mut Peekable<Chars<'_>>, forms: &[(char, char)], sign: &str, text: &mut String) {
    let part = argument(left).replace('\u{2212}', "-");
    let form = |letter: char| forms.iter().find(|(plain, _)| *plain == letter).map(|(_, form)| *form);
    match part.chars().map(form).collect::<Option<String>>() {
        Some(formed) => text.push_str(&formed),
        None if part.chars().count() > 1 && !sign.is_empty() => text.push_str(&format!("{sign}({part})")),
        None => text.push_str(&format!("{sign}{part}")),
    }
}
