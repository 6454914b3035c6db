//! Edits of the manoeuvre windows.

use doublet_core::series::TimeRange;

use super::edit::check_interval;
use super::excluded::apart;
use super::{EditError, Manoeuvre, Session, Surface, WindowFlag, WindowRole};

/// A change of the manoeuvre windows.
#[derive(Clone, Debug, PartialEq)]
pub enum WindowEdit {
    Add(Manoeuvre),
    /// Adds several windows in one step.
    AddAll(Vec<Manoeuvre>),
    /// Removes the window of this name.
    Remove(String),
    Rename {
        /// Present name.
        from: String,
        /// New name.
        to: String,
    },
    /// Moves or resizes a window.
    Place {
        name: String,
        /// New interval.
        window: TimeRange,
    },
    /// Changes the use of a window.
    Role {
        name: String,
        /// New use.
        role: WindowRole,
    },
    /// States the surface a window's manoeuvre moves.
    Surface {
        name: String,
        /// Surface, or `None` for several or unknown.
        surface: Option<Surface>,
    },
    /// Says something about a window.
    Note {
        name: String,
        /// New note; empty for none.
        note: String,
    },
    /// Divides a window: it ends at one instant, a second one like it starts at another and stands behind it.
    Split {
        name: String,
        /// New end, s.
        end_s: f64,
        /// Start of the second window, s.
        start_s: f64,
        second: String,
    },
    /// Leaves these parts of a window out, and no others.
    Exclude {
        name: String,
        /// Parts.
        excluded: Vec<TimeRange>,
    },
    /// Sets a flag of a window, or takes it back.
    Flag {
        name: String,
        flag: WindowFlag,
        /// Whether it is set.
        on: bool,
    },
}

/// A manoeuvre with its name; one that is called `manoeuvre 1` by that alone.
fn called(name: &str) -> String {
    if name.starts_with("manoeuvre ") { name.to_owned() } else { format!("manoeuvre {name}") }
}

impl WindowEdit {
    pub(super) fn label(&self) -> String {
        match self {
            Self::Add(window) => format!("add {}", called(&window.name)),
            Self::AddAll(windows) => format!("add {} manoeuvres", windows.len()),
            Self::Remove(name) => format!("remove {}", called(name)),
            Self::Rename { from, to } => format!("rename {} to {to}", called(from)),
            Self::Place { name, .. } => format!("move {}", called(name)),
            Self::Role { name, role: WindowRole::Ignored } => format!("ignore {}", called(name)),
            Self::Role { name, role } => format!("use {} for {}", called(name), role.name()),
            Self::Surface { name, surface } => {
                format!("set surface of {} to {}", called(name), surface.map_or("any", Surface::name))
            }
            Self::Note { name, .. } => format!("change note on {}", called(name)),
            Self::Split { name, .. } => format!("split {name}"),
            Self::Exclude { name, .. } => format!("change excluded parts of {name}"),
            Self::Flag { name, flag, on } => format!("{} {}", flag.verb(*on), called(name)),
        }
    }

    pub(super) fn apply(&self, session: &mut Session) -> Result<(), EditError> {
        match self {
            Self::Add(window) => add(session, window)?,
            Self::AddAll(windows) => windows.iter().try_for_each(|window| add(session, window))?,
            Self::Remove(name) => {
                find(session, name)?;
                session.windows.retain(|window| window.name != *name);
            }
            Self::Rename { from, to } => {
                if from != to && session.window(to).is_some() {
                    return Err(EditError::WindowExists(to.clone()));
                }
                if from != to {
                    usable("window", to)?;
                }
                find(session, from)?.name.clone_from(to);
                session.rename_in_experiments(from, to);
            }
            Self::Place { name, window } => {
                check_interval(*window)?;
                find(session, name)?.window = *window;
            }
            Self::Role { name, role } => find(session, name)?.role = *role,
            Self::Surface { name, surface } => {
                let window = find(session, name)?;
                (window.surface, window.also) = (*surface, None);
            }
            Self::Note { name, note } => find(session, name)?.note.clone_from(note),
            Self::Split { name, end_s, start_s, second } => split(session, name, (*end_s, *start_s), second)?,
            Self::Exclude { name, excluded } => {
                let parts = |part: &TimeRange| check_interval(*part).map_err(|_| empty_part(*part));
                excluded.iter().try_for_each(parts)?;
                find(session, name)?.excluded = apart(excluded.clone());
            }
            Self::Flag { name, flag, on } => *flag.among(&mut find(session, name)?.flags) = *on,
        }
        if matches!(self, Self::Add(_) | Self::AddAll(_) | Self::Remove(_) | Self::Split { .. }) {
            session.follow_manoeuvres();
        }
        Ok(())
    }
}

/// Refuses a name that is empty or too long.
fn usable(kind: &str, name: &str) -> Result<(), EditError> {
    if name.trim().is_empty() {
        return Err(EditError::Name(format!("the name of a {kind} cannot be empty: enter one")));
    }
    super::check::name_fits(kind, name).map_err(EditError::Name)
}

fn add(session: &mut Session, window: &Manoeuvre) -> Result<(), EditError> {
    if session.window(&window.name).is_some() {
        return Err(EditError::WindowExists(window.name.clone()));
    }
    usable("window", &window.name)?;
    if session.flight(&window.flight).is_none() {
        return Err(EditError::NoFlight(window.flight.clone()));
    }
    check_interval(window.window)?;
    session.windows.push(window.clone());
    Ok(())
}

/// Divides the window called `name` before `start_s`.
fn split(session: &mut Session, name: &str, (end_s, start_s): (f64, f64), second: &str) -> Result<(), EditError> {
    if session.window(second).is_some() {
        return Err(EditError::WindowExists(second.to_owned()));
    }
    usable("window", second)?;
    let first = find(session, name)?;
    let parts = [TimeRange { end_s, ..first.window }, TimeRange { start_s, ..first.window }];
    parts.into_iter().try_for_each(check_interval)?;
    let mut behind = Manoeuvre { name: second.to_owned(), window: parts[1], ..first.clone() };
    first.window = parts[0];
    for window in [first, &mut behind] {
        let inside = |part: &TimeRange| part.start_s < window.window.end_s && part.end_s > window.window.start_s;
        window.excluded = window.excluded.iter().filter(|part| inside(part)).copied().collect();
    }
    let at = session.windows.iter().position(|window| window.name == name).unwrap_or(session.windows.len() - 1);
    session.windows.insert(at + 1, behind);
    Ok(())
}

fn find<'a>(session: &'a mut Session, name: &str) -> Result<&'a mut Manoeuvre, EditError> {
    session.windows.iter_mut().find(|window| window.name == name).ok_or_else(|| EditError::NoWindow(name.to_owned()))
}

fn empty_part(TimeRange { start_s, end_s }: TimeRange) -> EditError {
    EditError::EmptyPart { start_s, end_s }
}
