//! The next flight: inputs designed from what is known, whether what was flown is enough, envelope, test points and cards.

mod basis;
mod campaign;
mod card;
mod card_flight;
mod cards;
mod coverage;
mod debrief;
mod designed_errors;
mod designed_session;
mod document;
mod enough;
mod evaluation;
mod files;
mod path_share;
mod rows;
mod safety;
mod sheet;
mod watched;

pub use crate::snapshot::{DerivativeRow, Enough, NextRow, WindowInformation};
pub use basis::{DesignOptions, FlownWindow, SEARCH_SAMPLES, basis, basis_of, design_basis};
pub use campaign::{Campaign, Flown, FlownPoint, Fuel, Order, PlannedPoint, TestPoint, Tolerance, flown_points};
pub(crate) use campaign::{FORMAT as CAMPAIGN_FORMAT, VERSION as CAMPAIGN_VERSION};
pub use card_flight::{CampaignFlight, campaign_flight};
pub use cards::{campaign_document, envelope_figure};
pub use coverage::{DesignCoverage, DesignedDerivative, DesignedExcursion, design_coverage, design_coverage_tables};
pub use debrief::{Debrief, DebriefRow, Promise, debrief, debrief_document, debrief_table, true_derivatives};
pub use designed_session::{FLIGHT_FOLDER, designed_session, loading_of_mass, with_recordings_in};
pub use document::{design_document, design_tables, enough_blocks, enough_tables};
pub use doublet_dynamics::design::{Criterion, DesignKind, SURFACE_NAMES, THROTTLE};
pub use enough::{EnoughOptions, EnoughRequest, Goal, enough};
pub use evaluation::SlopeRow;
pub use files::{design_csv, design_files};
pub use path_share::PathShare;
pub use rows::{
    ComparedKind, CorrelationRow, DesignRow, ExcursionRow, ManoeuvreRow, PredictedRow, SignalRow, design_row,
    designed_rows,
};
pub use safety::{EntryGate, HazardLevel, OnLimit, Risk, WindBox};
pub use sheet::{DesignSheet, SheetRequest, design_sheet};
pub use watched::open_flight;
