//! Fixes: edits that remove what a finding is about, in one step.

use doublet_core::compatibility::ChannelFix;
use doublet_core::model::{Coefficient, Lag, Term};
use doublet_core::quantity::Role;
use serde::{Serialize, Serializer};

use super::{
    Configuration, Edit, EditError, EstimationEdit, Experiment, ExpressionEdit, ExpressionSetting, Flight, ModelEdit,
    Session, SignalEdit, Surface, WindowEdit, WindowRole,
};

/// Manoeuvres that a label names before it counts them.
const NAMED: usize = 2;

/// Edits that remove what a finding is about: one step of undo.
#[derive(Clone, Debug, PartialEq)]
pub struct Fix {
    /// What it does, an order of few words.
    pub label: String,
    /// The edits, in order.
    pub edits: Vec<Edit>,
}

impl Serialize for Fix {
    /// As its label.
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(&self.label)
    }
}

impl std::fmt::Display for Fix {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.label)
    }
}

impl Fix {
    pub fn new(label: impl Into<String>, edit: Edit) -> Self {
        Self { label: label.into(), edits: vec![edit] }
    }

    /// Uses manoeuvres no longer.
    pub fn ignore<'a>(manoeuvres: impl IntoIterator<Item = &'a str>) -> Self {
        let names: Vec<&str> = manoeuvres.into_iter().collect();
        let edit = |name: &&str| Edit::Window(WindowEdit::Role { name: (*name).to_owned(), role: WindowRole::Ignored });
        let label = if names.len() > NAMED {
            format!("ignore {} manoeuvres", names.len())
        } else {
            format!("ignore {}", names.iter().map(|name| format!("'{name}'")).collect::<Vec<_>>().join(" and "))
        };
        Self { label, edits: names.iter().map(edit).collect() }
    }

    /// Joins several fixes to one.
    pub fn join(fixes: &[&Self]) -> Option<Self> {
        let (first, more) = fixes.split_first()?;
        let edits = fixes.iter().flat_map(|fix| fix.edits.iter().cloned());
        let ignored = |edit: &Edit| match edit {
            Edit::Window(WindowEdit::Role { name, role: WindowRole::Ignored }) => Some(name.clone()),
            _ => None,
        };
        let names: Option<Vec<String>> = edits.clone().map(|edit| ignored(&edit)).collect();
        match names {
            Some(names) => Some(Self::ignore(names.iter().map(String::as_str))),
            None if more.is_empty() => Some(Self::clone(first)),
            None => Some(Self { label: format!("{} and {} more", first.label, more.len()), edits: edits.collect() }),
        }
    }

    /// Whether it changes nothing but the configuration: no recording, channel, clock or aircraft.
    pub fn is_of_configuration(&self) -> bool {
        self.edits.iter().all(Self::is_configuration)
    }

    fn is_configuration(edit: &Edit) -> bool {
        match edit {
            Edit::Window(edit) => {
                matches!(edit, WindowEdit::Role { .. } | WindowEdit::Place { .. } | WindowEdit::Exclude { .. })
            }
            Edit::Noise(_) | Edit::Filter(_) | Edit::Estimation(_) => true,
            Edit::Model(edit) => matches!(edit, ModelEdit::SetTerm { .. } | ModelEdit::Structure(_)),
            _ => false,
        }
    }

    /// The fixed session as an experiment called by the label.
    pub fn to_experiment(&self, session: &Session) -> Option<Experiment> {
        let configuration = Configuration::from_session(&self.apply(session).ok()?);
        Some(Experiment { name: self.label.clone(), configuration: configuration.into() })
    }

    /// Adds a term to the model of a coefficient, or leaves it out.
    pub fn set_term(coefficient: Coefficient, term: &Term, on: bool) -> Self {
        let name = term.derivative_name(coefficient);
        let label = if on { format!("add the term {name}") } else { format!("remove the term {name}") };
        Self::new(label, Edit::Model(ModelEdit::SetTerm { coefficient, term: term.clone(), on }))
    }

    /// States the delay of a control, s.
    pub fn control_delay(session: &Session, surface: Surface, delay_s: f64) -> Self {
        // Milliseconds are what a delay is known to.
        let delay_s = (1000.0 * delay_s).round() / 1000.0;
        let lag = Lag { delay_s, ..session.preparation.control_lags.get(surface) };
        let label = format!("set a delay of {delay_s:.3} s for the {}", surface.name());
        Self::new(label, Edit::Estimation(EstimationEdit::ControlLag(surface, lag)))
    }

    /// Applies the fix of a channel: a channel by expression takes its role, or its source is shifted. None for what only the channel
    /// map can state, and where an expression plays the role already. `with_down` for an altitude that is the position down as well.
    pub fn channel(flight: &Flight, fix: &ChannelFix, with_down: bool) -> Option<Self> {
        let corrected = match fix {
            ChannelFix::Scale { role, factor, offset, .. } => {
                let down = (with_down && *role == Role::Altitude).then_some((Role::PositionDown, *factor, -offset));
                let scaled = |(role, factor, offset): (Role, f64, f64)| (role, scaled(role, factor, offset));
                std::iter::once((*role, *factor, *offset)).chain(down).map(scaled).collect()
            }
            ChannelFix::Swap { one, other } => vec![(*one, other.name().to_owned()), (*other, one.name().to_owned())],
            ChannelFix::Shift { source, late_s } => return Some(Self::shift(flight, source, *late_s)),
            ChannelFix::Reassign { .. } | ChannelFix::Clock { .. } | ChannelFix::Travel { .. } => return None,
        };
        let is_free = |role: Role| flight.expressions.iter().all(|expression| expression.role != Some(role));
        if !corrected.iter().all(|(role, _)| is_free(*role)) {
            return None;
        }
        // What is added is in SI, which an angle does not show by itself.
        let has_offset = matches!(fix, ChannelFix::Scale { offset, .. } if *offset != 0.0);
        let part = |(role, text): &(Role, String)| {
            let unit = if has_offset { format!(" [{}]", role.dimension().si_symbol()) } else { String::new() };
            format!("{} = {text}{unit}", role.name())
        };
        let parts: Vec<String> = corrected.iter().map(part).collect();
        let edit = |(role, expression): (Role, String)| {
            let (name, unit) = (format!("{} corrected", role.name()), role.dimension().si_symbol().to_owned());
            let to = Some(ExpressionSetting { name, unit, expression, role: Some(role) });
            Edit::Expression(ExpressionEdit { flight: flight.name.clone(), from: None, to })
        };
        Some(Self { label: format!("use {}", parts.join(", ")), edits: corrected.into_iter().map(edit).collect() })
    }

    fn shift(flight: &Flight, source: &str, late_s: f64) -> Self {
        let clock = flight.clocks.iter().find(|clock| clock.source == source);
        let shift_s = clock.map_or(0.0, |clock| clock.shift_s) - late_s;
        let edit = SignalEdit::Shift { flight: flight.name.clone(), source: source.to_owned(), shift_s };
        Self::new(format!("shift {source} by {:.3} s", -late_s), Edit::Signal(edit))
    }

    /// The session after all its edits.
    pub fn apply(&self, session: &Session) -> Result<Session, EditError> {
        self.edits.iter().try_fold(session.clone(), |session, edit| edit.apply(&session))
    }
}

/// `factor * role + offset`, four figures of each.
fn scaled(role: Role, factor: f64, offset: f64) -> String {
    let name = role.name();
    let product = match factor {
        1.0 => name.to_owned(),
        -1.0 => format!("-{name}"),
        _ => format!("{} * {name}", rounded(factor)),
    };
    match offset {
        0.0 => product,
        _ if offset < 0.0 => format!("{product} - {}", rounded(-offset)),
        _ => format!("{product} + {}", rounded(offset)),
    }
}

/// A number of four figures.
fn rounded(value: f64) -> f64 {
    format!("{value:.3e}").parse().unwrap_or(value)
}
