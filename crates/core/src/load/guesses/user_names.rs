//! Names that a user gives in a file beside recording or session: words of roles with their units, signs and weights, and tokens that
//! forbid a role or no longer do.

use std::path::{Path, PathBuf};

use serde::Deserialize;
use toml::Spanned;

use crate::load::contents::Probe;
use crate::load::error::LoadError;
use crate::load::file::read_text;
use crate::load::guesses::candidates;
use crate::load::guesses::candidates::{Candidate, row};
use crate::load::maps::by_hand::{By, ManualChannel, ManualChannelMap};
use crate::load::names::tokens::{OF_SOURCES, forbidden, tokens};
use crate::load::names::words::plain_letters;
use crate::quantity::{Role, Unit};

/// Name of the file.
pub const NAMES_FILE: &str = "doublet-names.toml";
/// First line of the file.
const FORMAT: &str = "doublet names";
/// Version of the form this reads.
const VERSION: u32 = 1;
/// Weight of a name that states none; that of the program's own names.
const WEIGHT: f64 = 2.0;
const OWN_WEIGHT: f64 = 1.0;

/// Names of roles, and tokens that forbid one, beyond those of the program.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct UserNames {
    /// Files they are from.
    pub files: Vec<PathBuf>,
    names: Vec<UserName>,
    forbidden: Vec<String>,
    allowed: Vec<String>,
}

/// Words of one role.
#[derive(Clone, Debug, PartialEq)]
struct UserName {
    role: Role,
    /// Each in tokens.
    words: Vec<Vec<String>>,
    unit: Option<Unit>,
    turned: Option<bool>,
    weight: f64,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawNames {
    format: Spanned<String>,
    version: Spanned<u32>,
    #[serde(default)]
    forbidden: Vec<Spanned<String>>,
    #[serde(default)]
    allowed: Vec<Spanned<String>>,
    #[serde(default)]
    names: Vec<RawName>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawName {
    role: Spanned<String>,
    words: Vec<Spanned<String>>,
    unit: Option<Spanned<String>>,
    sign: Option<Spanned<f64>>,
    weight: Option<Spanned<f64>>,
}

impl UserNames {
    /// Names of a text.
    ///
    /// # Errors
    /// [`LoadError::Names`] with the line: not TOML, an unknown key or role, a unit of another dimension, a sign other than 1 and -1, a
    /// weight that is not above zero, a word without letters, a token of several words.
    pub fn parse(text: &str) -> Result<Self, LoadError> {
        let refused = |at: usize, what: String| LoadError::Names {
            path: None,
            line: text[..at.min(text.len())].matches('\n').count() + 1,
            what,
        };
        let raw: RawNames = toml::from_str(text)
            .map_err(|error| refused(error.span().map_or(0, |span| span.start), error.message().to_owned()))?;
        if raw.format.as_ref() != FORMAT || *raw.version.as_ref() != VERSION {
            return Err(refused(0, format!("format must be \"{FORMAT}\" and version {VERSION}")));
        }
        let token = |word: Spanned<String>| match &tokens(word.as_ref())[..] {
            [one] => Ok(one.clone()),
            _ => Err(refused(word.span().start, format!("'{}' must be one word", word.as_ref()))),
        };
        let forbidden = raw.forbidden.into_iter().map(token).collect::<Result<_, _>>()?;
        let allowed = raw.allowed.into_iter().map(token).collect::<Result<_, _>>()?;
        let names = raw.names.into_iter().map(|name| read_name(name, &refused)).collect::<Result<_, _>>()?;
        Ok(Self { files: Vec::new(), names, forbidden, allowed })
    }

    /// Names of the files called [`NAMES_FILE`] in folders, the first of which weighs most where two give a word the same weight.
    ///
    /// # Errors
    /// [`LoadError::Open`], or [`LoadError::Names`] with file and line.
    pub fn read(folders: &[PathBuf]) -> Result<Self, LoadError> {
        let mut all = Self::default();
        for folder in folders {
            let path = folder.join(NAMES_FILE);
            if all.files.contains(&path) || !path.is_file() {
                continue;
            }
            let text = read_text(&path).map_err(|cause| LoadError::Open { path: path.clone(), cause })?;
            let found = Self::parse(&text).map_err(|error| match error {
                LoadError::Names { line, what, .. } => LoadError::Names { path: Some(path.clone()), line, what },
                other => other,
            })?;
            all.files.push(path);
            all.names.extend(found.names);
            all.forbidden.extend(found.forbidden);
            all.allowed.extend(found.allowed);
        }
        Ok(all)
    }

    /// Folders in which the names of recordings are looked for: the one that a recording is in, and itself where it is a folder.
    pub fn folders(paths: &[PathBuf]) -> Vec<PathBuf> {
        let own_folders = |path: &PathBuf| {
            let parent = path.parent().map(Path::to_owned);
            path.is_dir().then(|| path.clone()).into_iter().chain(parent)
        };
        paths.iter().flat_map(own_folders).collect()
    }

    /// The token of a channel's name that forbids it every role.
    pub(crate) fn forbidden(&self, name: &str) -> Option<String> {
        self.forbidden_beside(name, &[])
    }

    /// The token of a source's name that forbids its channels every role.
    pub(crate) fn forbidden_source(&self, name: &str) -> Option<String> {
        self.forbidden_beside(name, &OF_SOURCES)
    }

    fn forbidden_beside(&self, name: &str, allowed: &[&str]) -> Option<String> {
        let all = tokens(name);
        let own = all.iter().find(|token| self.forbidden.contains(token)).cloned();
        let is_allowed = |token: &String| self.allowed.contains(token) || allowed.contains(&token.as_str());
        own.or_else(|| {
            let rest = all.iter().filter(|token| !is_allowed(token)).map(String::as_str).collect::<Vec<_>>();
            let plain = if rest.len() == all.len() { name.to_owned() } else { rest.join(" ") };
            forbidden(&plain).map(str::to_owned)
        })
    }

    /// Gives roles the channels that go by these names, in the order of weight times the part of the name that a word covers: before the
    /// program's own names where that is 1 or more, else the roles that those leave open.
    pub(crate) fn add(&self, map: &mut ManualChannelMap, probes: &[Probe], before: bool) {
        let candidates = candidates::all(probes);
        let mut fitting: Vec<(f64, usize, &UserName)> = Vec::new();
        for name in &self.names {
            for (index, candidate) in candidates.iter().enumerate() {
                let score = name.weight * self.coverage(name, candidate);
                if score > 0.0 && (score >= OWN_WEIGHT) == before {
                    fitting.push((score, index, name));
                }
            }
        }
        fitting.sort_by(|a, b| b.0.total_cmp(&a.0));
        let mut given: Vec<Role> = Vec::new();
        for (_, index, name) in fitting {
            let candidate = &candidates[index];
            let is_used = |row: &ManualChannel| row.from == candidate.from && (!before || row.by == By::File);
            let is_taken = map.rows.iter().any(|(_, row)| is_used(row))
                || given.contains(&name.role)
                || (!before && map.row(name.role).is_some());
            if !is_taken {
                // A channel has one meaning, whatever words of the program say.
                map.rows.retain(|(_, row)| row.from != candidate.from);
                given.push(name.role);
                map.set(name.role, Some(name.row(candidate)));
            }
        }
    }

    /// Gives the rows of these names back the units and signs that they state.
    pub(crate) fn restore(&self, map: &mut ManualChannelMap, probes: &[Probe]) {
        let candidates = candidates::all(probes);
        for (role, row) in map.rows.iter_mut().filter(|(_, row)| row.by == By::File) {
            let Some(candidate) = candidates.iter().find(|candidate| candidate.from == row.from) else { continue };
            let of_role = self.names.iter().filter(|name| name.role == *role);
            let best = of_role.max_by(|a, b| {
                let score = |name: &UserName| name.weight * self.coverage(name, candidate);
                score(a).total_cmp(&score(b))
            });
            if let Some(name) = best {
                row.unit = name.unit.or(row.unit);
                row.turned = name.turned.unwrap_or(row.turned);
                (row.scale, row.offset) = (1.0, 0.0);
            }
        }
    }

    /// Part of the tokens of a channel's name that a word covers.
    fn word_coverage(&self, word: &[String], candidate: &Candidate<'_>) -> f64 {
        if word.concat() == candidate.plain || word.concat() == plain_letters(&candidate.channel.name) {
            return 1.0;
        }
        let all = &candidate.tokens;
        let Some(at) = all.windows(word.len()).position(|part| *part == *word) else { return 0.0 };
        let rest: Vec<&str> = all[..at].iter().chain(&all[at + word.len()..]).map(String::as_str).collect();
        if self.forbidden(&rest.join(" ")).is_some() { 0.0 } else { word.len() as f64 / all.len() as f64 }
    }

    /// Part of the tokens of a channel's name that one of the words covers; none where another token forbids it.
    fn coverage(&self, name: &UserName, candidate: &Candidate<'_>) -> f64 {
        let fits_unit =
            name.unit.is_some() || candidate.unit.is_none_or(|unit| unit.dimension == name.role.dimension());
        if !fits_unit {
            return 0.0;
        }
        name.words.iter().map(|word| self.word_coverage(word, candidate)).fold(0.0, f64::max)
    }
}

impl UserName {
    fn row(&self, candidate: &Candidate<'_>) -> ManualChannel {
        let start = row(candidate, self.role);
        ManualChannel {
            by: By::File,
            unit: self.unit.or(start.unit),
            is_unit_known: self.unit.is_some(),
            turned: self.turned.unwrap_or(start.turned),
            ..start
        }
    }
}

fn read_name(raw: RawName, refused: &dyn Fn(usize, String) -> LoadError) -> Result<UserName, LoadError> {
    let role = Role::from_name(raw.role.as_ref())
        .ok_or_else(|| refused(raw.role.span().start, format!("role '{}' not found", raw.role.as_ref())))?;
    let unit = raw.unit.map(|unit| {
        let at = unit.span().start;
        let parsed = Unit::parse(unit.as_ref()).map_err(|error| refused(at, error.to_string()))?;
        if parsed.dimension == role.dimension() {
            return Ok(parsed);
        }
        let (name, si) = (role.name(), role.dimension().si_symbol());
        Err(refused(at, format!("{name} is in {si}, not in {}", unit.as_ref())))
    });
    let turned = raw.sign.map(|sign| match *sign.as_ref() {
        1.0 => Ok(false),
        -1.0 => Ok(true),
        other => Err(refused(sign.span().start, format!("sign {other} must be 1 or -1"))),
    });
    let weight = match raw.weight {
        Some(weight) if !(*weight.as_ref() > 0.0 && weight.as_ref().is_finite()) => {
            return Err(refused(weight.span().start, format!("weight {} must be above zero", weight.as_ref())));
        }
        Some(weight) => weight.into_inner(),
        None => WEIGHT,
    };
    let words = raw.words.into_iter().map(|word| match tokens(word.as_ref()) {
        none if none.is_empty() => {
            Err(refused(word.span().start, format!("'{}' has neither letters nor digits", word.as_ref())))
        }
        all => Ok(all),
    });
    Ok(UserName {
        role,
        words: words.collect::<Result<_, _>>()?,
        unit: unit.transpose()?,
        turned: turned.transpose()?,
        weight,
    })
}
