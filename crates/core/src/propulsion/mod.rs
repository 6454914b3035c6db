//! Engine chart, propeller map, thrust and what the propellers do to the airflow and to the aircraft's moments.
//!
//! Chart power from engine speed, manifold pressure, pressure altitude and air temperature ([`EngineChart`]); efficiency
//! and thrust coefficient from advance ratio, power coefficient, engine speed and pressure altitude ([`PropellerMap`]);
//! both, placed on an aircraft, are a [`Powerplant`]. Charts and maps are data files, read by `load::propulsion_maps`.

mod chart;
mod comparison;
mod grid;
mod off_range;
mod powerplant;
mod propeller;
mod sensitivity;

pub use chart::{EngineChart, EngineChartData, Power};
pub use comparison::{
    Correlation, PhaseOfFlight, PhaseRow, PowerComparison, compare_power, difference_correlation, phase_table,
};
pub use grid::TableError;
pub use off_range::{MapVariable, OffRange, OffRanges};
pub use powerplant::{
    Ambient, ColumnLengthError, Engine, EngineColumns, EngineHistory, EngineInput, EngineModel, EngineState,
    Powerplant, Rotation, RotorSum,
};
pub use propeller::{PropellerMap, PropellerMapData, PropellerMapTable, PropellerPoint};
pub use sensitivity::{
    DensityRule, EngineOutput, EnginePoint, EngineSensitivities, PointInput, Steps, engine_sensitivities,
};
