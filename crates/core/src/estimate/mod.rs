//! Least-squares estimation of derivatives, its covariance and diagnostics.

mod between_windows;
mod conditions;
mod constant_errors;
mod constrained;
mod covariance;
pub mod diagnostics;
mod disturbance;
mod equations;
mod error;
mod errors_in_variables;
mod fit;
mod flight_filter_error;
mod flight_output_error;
mod frequency;
mod input_kinds;
mod instrumental;
mod least_squares;
mod nonlinear;
mod orthogonal;
mod output_covariance;
mod output_error;
mod pooled;
mod predicted;
mod prior;
mod recursive;
mod recursive_frequency;
mod robust;
mod search;
mod sensor_errors;
mod steady_filter;
mod stepwise;
mod summary;
mod term_study;
mod transform_length;
mod triangle;
mod weighted;

pub use conditions::{ConditionFit, ConditionPoint, condition_regression};
pub use constant_errors::{ConstantErrors, InnovationEvidence, constant_errors};
pub use constrained::{Constraint, constrained_least_squares};
pub use covariance::{Coloured, Taper, Transforms, autocorrelation, coloured_covariance, coloured_covariances};
pub use disturbance::{Unexplained, disturbance_covariance};
pub use equations::{
    EquationFault, EquationFit, EquationFunction, EquationModel, EquationNames, EquationPoints, EquationRecord,
    EquationSettings, EquationText, FilterErrorFit, equation_error_of, filter_error_of, output_error_of,
};
pub use error::{Dependence, EstimateError};
pub use errors_in_variables::{errors_in_variables, total_least_squares};
pub use fit::{Fit, FitQuality, Origin};
pub use flight_filter_error::{FlightFilterFit, flight_filter_error};
pub use flight_output_error::{
    FlightFitError, FlightFreedom, FlightOutput, FlightOutputFit, FlightWindow, InitialState, flight_output_error,
};
pub use frequency::{
    Detrend, FrequencySettings, FrequencyWindow, correct_ends, finite_fourier_transform, frequency_equation_error,
};
pub use input_kinds::{KindDifference, compare_kinds};
pub use instrumental::{InstrumentalFit, instrumental_variables};
pub use least_squares::least_squares;
pub use nonlinear::{NonlinearSearch, search_nonlinear};
pub use orthogonal::{OrthogonalRecord, OrthogonalSelection, OrthogonalSettings, orthogonal};
pub use output_covariance::joint_coloured_covariance;
pub use output_error::{OutputErrorFit, OutputErrorSettings, OutputParameter, output_error};
pub use pooled::{PooledFit, PooledRegression, PooledWindow, Stacked, pooled, stacked};
pub use predicted::{ExpectedErrors, ResidualNoise};
pub use prior::{Known, Posterior, combine};
pub use recursive::{RecursiveEstimate, RecursiveLeastSquares};
pub use recursive_frequency::RecursiveFourier;
pub use robust::HUBER_LIMIT;
pub use sensor_errors::{
    ErrorTerm, EstimatedError, Freedom, NoiseModel, OutputResidual, Sensor, SensorError, SensorErrorFault,
    SensorErrorFit, SensorErrorSettings, SensorErrorWindow, WindowShare, sensor_errors,
};
pub use steady_filter::ProcessNoise;
pub use stepwise::{Selection, StepAction, StepRecord, StepwiseSettings, stepwise};
pub use summary::{ParameterSummary, summarise};
pub use term_study::{TermEffect, TermStudy, term_study};
pub use weighted::{GeneralisedFit, generalised_least_squares, weighted_coloured_covariance, weighted_least_squares};
