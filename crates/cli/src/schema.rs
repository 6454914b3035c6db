//! `doublet schema`: JSON Schemas of the files doublet reads.

use clap::{Args, ValueEnum};
use doublet_core::load::{ChannelMap, aircraft, instruments};
use doublet_engine::batch::Sweep;
use doublet_engine::session;
use doublet_engine::study::equation_schema;

use crate::text;

#[derive(Debug, Args)]
pub struct SchemaArguments {
    /// Kind of file.
    #[arg(value_enum)]
    pub file: FileKind,
}

/// Kinds of files.
#[derive(Clone, Copy, Debug, ValueEnum)]
pub enum FileKind {
    /// Session: recordings, manoeuvres and settings.
    Session,
    /// Channel map: the channel of each role.
    ChannelMap,
    /// Geometry, mass, inertia, engines.
    Aircraft,
    /// Instruments: raw signals converted to roles.
    Instruments,
    /// Batch: settings to sweep and their values.
    Sweep,
    /// Equations of motion.
    Equations,
}

/// Prints a schema.
pub fn schema(arguments: &SchemaArguments) -> Result<(), String> {
    let schema = match arguments.file {
        FileKind::Session => session::json_schema(),
        FileKind::ChannelMap => ChannelMap::schema(),
        FileKind::Aircraft => aircraft::schema(),
        FileKind::Instruments => instruments::schema(),
        FileKind::Sweep => Sweep::schema(),
        FileKind::Equations => equation_schema(),
    };
    let schema = schema.map_err(|error| format!("{:?}: {error}", arguments.file))?;
    text::document(&serde_json::to_string_pretty(&schema).map_err(|error| error.to_string())?);
    Ok(())
}
