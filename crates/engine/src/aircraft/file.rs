//! An edited aircraft in a file of its own.

use std::path::Path;

use doublet_core::load::aircraft as aircraft_file;
use doublet_core::load::propulsion_maps::parse_propulsion_section;

use crate::graph::Context;
use crate::session::Session;
use crate::{builtin, keep};

/// Writes the aircraft of a session with its changes to `path`, and beside it the charts and maps of its engines. Relative paths of the
/// session start from `folder`. Comments and order of the file stay.
pub fn save(session: &Session, folder: &Path, path: &Path) -> Result<(), String> {
    let named = session.aircraft.as_deref().ok_or(crate::stage::NO_AIRCRAFT)?;
    let context = Context::new(folder);
    let text = session.aircraft_changes.apply(&context.text(named, "aircraft").map_err(String::from)?)?;
    aircraft_file::parse(&text).map_err(|error| format!("the aircraft is not saved: {error}").replace('\n', "; "))?;
    let maps = match named.strip_prefix(builtin::PREFIX) {
        Some(_) => builtin::on_disk("propulsion")?,
        None => context.locate(named).map_err(String::from)?.parent().unwrap_or(Path::new(".")).to_path_buf(),
    };
    let section = parse_propulsion_section(&text, path).map_err(|error| error.to_string())?;
    let beside = path.parent().unwrap_or(Path::new("."));
    let files = section.engine.iter().flat_map(|engine| [&engine.chart, &engine.propeller]).flatten();
    for file in files {
        let (from, to) = (maps.join(file), beside.join(file));
        if to.exists() {
            continue;
        }
        let bytes = std::fs::read(&from).map_err(|error| format!("{}: {error}", from.display()))?;
        keep::replace(&to, &bytes).map_err(|error| format!("{}: {error}", to.display()))?;
    }
    keep::replace(path, text.as_bytes()).map_err(|error| format!("{}: {error}", path.display()))
}
