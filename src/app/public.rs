//! A public recording of a real flight with its worked case: fetched by the user, recognised by its SHA-256.

use std::path::PathBuf;

use doublet_engine::session::{self, Session};

/// The page that offers the files.
pub(super) const PAGE: &str = "https://doi.org/10.2514/4.102790";
/// What it is called, and what it holds.
pub(super) const TITLE: &str = "DLR ATTAS (VFW 614)";
pub(super) const ABOUT: &str = "Elevator 3-2-1-1, bank to bank and rudder doublet, 85 s at 25 Hz. The recordings belong to the publisher of \
    Jategaonkar, Flight Vehicle System Identification (2015), and are not part of doublet, which downloads nothing. With \
    internet access, open the page, save three files of the supplement, then choose them here. Their SHA-256 is checked.";
/// The session of the worked case.
const SESSION: &str = include_str!("../../sessions/reference/attas.toml");
/// Its files, as the session names them, and what they are recognised by.
const FILES: [(&str, &str); 3] = [
    ("fAttasElv1.mat", "2e406739e16ac3dc46f244578b027703d1d84431da947d264735fc1318161e09"),
    ("fAttasAil1.mat", "591f1eb5830ba1962029c197942b25c3cc84c8b9eb3d43b8e3c381347531d561"),
    ("fAttasRud1.mat", "b173e46cb2b6714fdd9bd9aee719335478a0012d1890b8c4a67609915957ce86"),
];
/// Digits of a SHA-256 that a message shows.
const DIGITS: usize = 8;

/// The worked case on the files at `paths`, whatever they are called.
pub(super) fn session(paths: &[PathBuf]) -> Result<Session, String> {
    let hashes: Result<Vec<String>, _> = paths.iter().map(|path| session::content_hash(path)).collect();
    let hashes = hashes.map_err(|error| error.to_string())?;
    let mut session = session::parse(SESSION).map_err(|error| error.to_string())?;
    for recording in session.flights.iter_mut().flat_map(|flight| &mut flight.recordings) {
        let Some((name, expected)) = FILES.iter().find(|(name, _)| recording.path.ends_with(name)) else { continue };
        let Some((found, path)) = hashes.iter().zip(paths).find(|(found, _)| found == expected) else {
            return Err(format!("{name} is missing: no chosen file has SHA-256 {}….", &expected[..DIGITS]));
        };
        recording.path = path.canonicalize().unwrap_or_else(|_| path.clone()).display().to_string();
        recording.sha256 = Some(found.clone());
    }
    Ok(session)
}
