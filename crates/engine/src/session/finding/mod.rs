//! What was found, of a recording, a session or its results, and how far it may be believed.

use serde::{Deserialize, Serialize};

use doublet_core::message::Message;

use crate::session::Fix;

mod place;

pub use place::Place;

/// What a derivative may be, as stated in a session or a file.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PlausibleRange {
    /// Least plausible value.
    pub low: f64,
    /// Greatest plausible value.
    pub high: f64,
    /// Whether a value of the other sign is wrong whatever the aircraft.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub sign_certain: bool,
}

/// How far something may be believed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Level {
    /// Nothing speaks against it.
    #[default]
    Good,
    /// It may be used by someone who knows the reason given.
    Caution,
    /// It must not be used.
    Bad,
}

impl Level {
    doublet_core::variant_texts! {
        /// Name as in the results.
        pub name: Good "good", Caution "caution", Bad "bad"
    }
}

/// Something found in a session, its recordings or its results: what, where, by how much, and what to do.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Finding {
    pub level: Level,
    /// Kind, for example `nis` or `held-samples`; findings of one kind are folded into one line.
    pub code: &'static str,
    /// Its object, for example `manoeuvre '03 elevator'`, `flight 'demo', az` or `Cm_q (pooled)`.
    #[serde(rename = "where")]
    pub place: Place,
    /// One sentence: the finding with its value.
    pub text: Message,
    /// The judged value.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub figure: Option<f64>,
    /// The limit exceeded.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub limit: Option<f64>,
    /// What to do, one sentence; empty without a remedy.
    #[serde(rename = "fix")]
    pub fix_text: String,
    /// Panel of the workbench to do it in.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub panel: Option<&'static str>,
    /// Dotted key of the session's setting that fixes it, for example `filter.measurement_noise.alpha`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub setting: Option<String>,
    /// Value of that key that fixes it, as TOML; absent if you must choose.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub value: Option<String>,
    /// Edits that fix it, as `doublet fix` lists them; absent if you must choose.
    #[serde(rename = "edits", skip_serializing_if = "Option::is_none")]
    pub fix: Option<Fix>,
}

impl Finding {
    /// A finding without figure and fix.
    pub fn new(level: Level, code: &'static str, place: impl Into<Place>, text: impl Into<Message>) -> Self {
        Self {
            level,
            code,
            place: place.into(),
            text: text.into(),
            figure: None,
            limit: None,
            fix_text: String::new(),
            panel: None,
            setting: None,
            value: None,
            fix: None,
        }
    }

    /// The same with the number that was judged and the limit it passed.
    #[must_use]
    pub(crate) fn with_figure(mut self, figure: f64, limit: f64) -> Self {
        self.figure = figure.is_finite().then_some(figure);
        self.limit = limit.is_finite().then_some(limit);
        self
    }

    /// The same with what to do.
    #[must_use]
    pub(crate) fn with_fix_text(mut self, fix_text: impl Into<String>) -> Self {
        self.fix_text = fix_text.into();
        self
    }

    /// The same with the value of the setting that is the fix, as TOML.
    #[must_use]
    pub(crate) fn with_value(mut self, value: impl Into<String>) -> Self {
        self.value = Some(value.into());
        self
    }

    /// The same with the edits that remove it.
    #[must_use]
    pub(crate) fn with_fix(mut self, fix: impl Into<Option<Fix>>) -> Self {
        self.fix = fix.into();
        self
    }

    /// The same with the panel of the workbench and the key of the setting that fix it.
    #[must_use]
    pub(crate) fn with_setting(mut self, panel: &'static str, setting: impl Into<String>) -> Self {
        self.panel = Some(panel);
        self.setting = Some(setting.into()).filter(|key: &String| !key.is_empty());
        self
    }
}

impl std::fmt::Display for Finding {
    /// Where, what and what to do, in one line.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}: {}", self.place, self.text)?;
        write_fix(f, &self.text.to_string(), &self.fix_text)
    }
}

/// What to do behind what was found: two sentences, or two parts of one.
pub(crate) fn write_fix(f: &mut std::fmt::Formatter<'_>, text: &str, fix: &str) -> std::fmt::Result {
    match fix {
        "" => Ok(()),
        _ => write!(f, "{}{fix}", if text.ends_with('.') { " " } else { ": " }),
    }
}

/// Whether something may be believed, and why not.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Verdict {
    /// The worst level of its reasons; good without any.
    pub level: Level,
    /// Findings, worst first.
    pub reasons: Vec<Finding>,
}

impl Verdict {
    /// The verdict that follows from findings: its level is that of the worst, good ones are no reason.
    pub fn from_findings(findings: impl IntoIterator<Item = Finding>) -> Self {
        let mut reasons: Vec<_> = findings.into_iter().filter(|finding| finding.level > Level::Good).collect();
        reasons.sort_by_key(|finding| std::cmp::Reverse(finding.level));
        Self { level: reasons.first().map_or(Level::Good, |worst| worst.level), reasons }
    }
}

#[cfg(test)]
mod tests {
    use super::{Finding, Level, Place, Verdict};

    #[test]
    fn verdict_is_the_worst_of_its_findings_and_names_it_first() {
        let finding = |level, text: &str| Finding::new(level, "nis", Place::manoeuvre("a"), text);
        let verdict = Verdict::from_findings([
            finding(Level::Good, "fine"),
            finding(Level::Caution, "high"),
            finding(Level::Bad, "far too high"),
            finding(Level::Caution, "low"),
        ]);
        assert_eq!(verdict.level, Level::Bad);
        let texts: Vec<_> = verdict.reasons.iter().map(|reason| reason.text.to_string()).collect();
        assert_eq!(texts, ["far too high", "high", "low"]);
        assert_eq!(Verdict::from_findings([finding(Level::Good, "fine")]), Verdict::default());
    }

    #[test]
    fn finding_serialises_by_the_documented_keys() {
        let finding = Finding::new(Level::Bad, "nis", Place::manoeuvre("a"), "mean NIS 40")
            .with_figure(40.0, f64::INFINITY)
            .with_fix_text("raise the noise of alpha")
            .with_setting("Noise and filter", "filter.measurement_noise.alpha");
        let text = serde_json::to_string(&finding).unwrap();
        let expected = "{\"level\":\"bad\",\"code\":\"nis\",\"where\":\"manoeuvre 'a'\",\"text\":\"mean NIS 40\",\"figure\":40.0,\
                        \"fix\":\"raise the noise of alpha\",\"panel\":\"Noise and filter\",\"setting\":\"filter.measurement_noise.alpha\"}";
        assert_eq!(text, expected);
    }
}
