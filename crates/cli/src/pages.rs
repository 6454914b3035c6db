//! The files of the manual, as they are.

/// Path below `docs/` and text of every page.
pub static PAGES: &[(&str, &str)] = include!(concat!(env!("OUT_DIR"), "/pages.rs"));

/// The file at a path below `docs/`, empty where there is none.
pub fn source(path: &str) -> &'static str {
    PAGES.iter().find(|(name, _)| *name == path).map_or("", |(_, text)| text)
}
