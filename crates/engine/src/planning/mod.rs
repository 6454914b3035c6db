//! The next flight: inputs designed from what is known, whether what was flown is enough, envelope, test points and cards.

mod basis;
mod campaign;
mod cards;
mod coverage;
mod document;
mod enough;
mod files;
mod recorded_coverage;
mod rows;
mod sheet;

pub use basis::{DesignOptions, FlownWindow, SEARCH_SAMPLES, basis, basis_of, design_basis};
pub use campaign::{Campaign, Flown, FlownPoint, Fuel, Order, PlannedPoint, TestPoint, Tolerance, flown_points};
pub use cards::{campaign_document, envelope_figure};
pub use coverage::{DesignCoverage, DesignedDerivative, DesignedExcursion, design_coverage};
pub use document::{comparison_table, design_document, enough_blocks};
pub use doublet_dynamics::design::{Criterion, DesignKind, SURFACE_NAMES};
pub use enough::{DerivativeRow, Enough, EnoughOptions, EnoughRequest, Goal, NextRow, WindowInformation, enough};
pub use files::{design_csv, design_files};
pub use recorded_coverage::recorded_coverage;
pub use rows::{
    ComparedKind, CorrelationRow, DesignRow, ExcursionRow, ManoeuvreRow, PredictedRow, SignalRow, design_row,
    designed_rows,
};
pub use sheet::{DesignSheet, SheetRequest, design_sheet};
