//! `doublet check`: a session or an aircraft file, without running anything.

use doublet_core::airframe::summary;
use doublet_core::load::aircraft as aircraft_file;
use doublet_engine::session::{self, FORMAT};
use doublet_engine::stage;

use crate::arguments::CheckArguments;
use crate::text;

/// Checks a session or an aircraft file and prints what it says.
///
/// # Errors
/// One line per problem.
pub fn check(arguments: &CheckArguments) -> Result<(), String> {
    let path = &arguments.file;
    let content = std::fs::read_to_string(path).map_err(|error| format!("{}: {error}", path.display()))?;
    if content.trim().is_empty() {
        let line =
            "there is nothing in it: an empty session or aircraft file; open another file, or its .bak beside it";
        return Err(format!("{}: {line}", path.display()));
    }
    let is_session = content.lines().any(|line| line.trim_start().starts_with("format") && line.contains(FORMAT));
    let result = if is_session { check_session(arguments) } else { check_aircraft(&content) };
    result.map_err(|error| format!("{}: {error}", path.display()))
}

fn check_session(arguments: &CheckArguments) -> Result<(), String> {
    let opened = session::open(&arguments.file).map_err(|error| error.to_string())?;
    let mut problems: Vec<String> = session::check(&opened.session).iter().map(ToString::to_string).collect();
    session::path_warning(&opened.session).iter().for_each(|line| text::line(line));
    if let Err(error) = stage::load_aircraft(&opened.folder, &opened.session.aircraft) {
        problems.push(format!("aircraft: {error}"));
    }
    for flight in &opened.session.flights {
        match stage::flight(&opened.folder, flight).and_then(|read| stage::aligned(&opened.folder, &read, flight)) {
            Ok(loaded) => {
                loaded.recording.warnings.iter().for_each(|line| text::line(&format!("{}: {line}", flight.name)));
            }
            Err(error) => problems.push(format!("flight '{}': {error}", flight.name)),
        }
    }
    if !problems.is_empty() {
        return Err(problems.join("\nerror: "));
    }
    let session = &opened.session;
    text::line(&format!(
        "{}: {} flights, {} windows, {} coefficients: nothing is wrong",
        if session.title.is_empty() { "session" } else { &session.title },
        session.flights.len(),
        session.windows.len(),
        session.structure.models.len()
    ));
    Ok(())
}

fn check_aircraft(content: &str) -> Result<(), String> {
    let aircraft = aircraft_file::parse(content).map_err(|error| error.to_string())?;
    if let Err(errors) = aircraft.check() {
        return Err(errors.iter().map(ToString::to_string).collect::<Vec<_>>().join("\nerror: "));
    }
    text::line(summary(&aircraft).to_string().trim_end());
    Ok(())
}
