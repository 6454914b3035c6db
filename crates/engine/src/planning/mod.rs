//! The next flight: inputs designed from what is known, whether what was flown is enough, envelope, test points and cards.

mod basis;
mod campaign;
mod cards;
mod coverage;
mod document;
mod enough;
mod files;
mod rows;

pub use basis::{DesignOptions, FlownWindow, SEARCH_SAMPLES, basis, design_basis};
pub use campaign::{Campaign, Flown, FlownPoint, Fuel, Order, PlannedPoint, TestPoint, Tolerance, flown_points};
pub use cards::{campaign_document, envelope_figure};
pub use coverage::{DesignCoverage, DesignedDerivative, DesignedExcursion, design_coverage};
pub use document::design_document;
pub use enough::{DerivativeRow, Enough, EnoughOptions, Goal, NextRow, WindowInformation, enough};
pub use files::{aircraft_name, design_csv, design_lua, design_px4, design_scenario};
pub use rows::{
    ComparedKind, CorrelationRow, DesignRow, ExcursionRow, ManoeuvreRow, PredictedRow, SignalRow, design_row,
};
