//! Stages: pure functions from inputs and parameters to outputs, one file each.
//!
//! Order and reasons: the recording is read first; a window takes its part of it into the filter; coefficients need the
//! reconstructed path; derivatives of one window need its coefficients; the pooled estimate needs those of all windows; the engines over a whole flight need its
//! recording and the aircraft alone; the proof of match flies validation windows again and comes after all estimates.

mod aero;
mod air_data;
mod air_density;
mod aircraft;
mod align;
mod condition;
mod control_delays;
mod delays;
mod delays_and_gusts;
mod detail;
mod engine_charts;
mod engines;
mod expressions;
mod fit;
mod flight_engines;
mod gravity;
mod gusts;
mod held_samples;
mod information;
mod instrumental;
mod instruments;
mod mass;
mod memory;
mod misfit;
mod movement;
mod next_errors;
mod noise;
mod noise_advice;
mod observability;
mod onsets;
mod path;
mod path_errors;
mod phases;
mod physics;
mod placement;
mod prediction;
mod proposals;
mod recording;
mod replay;
mod samples;
mod sensor_errors;
mod signals;
mod stalls;
mod steadiness;
mod structure_scores;
mod tolerances;
mod truth;
mod window_context;
mod window_samples;

pub(crate) use aero::states_of;
pub use aero::{CONTROLS, WindowAero, aero, aero_along, aero_along_from};
pub(crate) use air_data::has_airspeed;
pub use air_density::AirDensity;
pub use aircraft::{
    AircraftData, LoadedAircraft, NO_AIRCRAFT, aircraft_data, aircraft_of, load_aircraft, loading_on_board,
    parse_aircraft,
};
pub use align::{UsedClock, is_stamped_by};
pub(crate) use align::{align, is_of_engine_or_fuel};
pub use condition::{CONDITION_NOTE, FlightCondition, condition_samples, mean_of_finite, measure_condition};
pub use control_delays::{ControlDelay, control_delays};
pub use delays::{SensorDelay, SensorDelays, flow_delay_by_lift};
pub use delays_and_gusts::{DelaysAndGusts, estimate_delays_and_gusts, estimate_in_turn, needs_delays_or_gusts};
pub use detail::{
    BIAS_STATES, BiasTable, CoefficientStudy, Contributions, KindSummary, ResidualStudy, bias_table, contributions,
    kind_summaries, model_study, residual_studies, track_from_velocity,
};
pub use engine_charts::{PropellerCurves, PropellerLine, engine_partials, propeller_curves};
pub use engines::ExtrapolatedThrust;
pub use expressions::{ExpressedChannel, add_expressions, expression_preview};
pub use fit::{
    AeroWindow, CONDITION_LIMIT, CoefficientFit, DroppedTerm, FittedSeries, PooledFits, Regression, VaneScale,
    WindowFits, describe_origin, errors, pooled_fits, pooled_regressions, significance, window_fits,
};
pub(crate) use fit::{applies, constant_name};
pub use flight_engines::{EngineOverFlight, FlightEngines, PowerAgreement, flight_engines};
#[cfg(test)]
pub(crate) use gravity::tests::recording_of;
pub use gravity::{Gravity, gravity, with_gravity};
pub use gusts::SessionGusts;
pub use information::{Information, RegressorCorrelation, information, regressor_correlations};
pub use instrumental::{by_instruments, sample_step_s};
pub use instruments::tank_channel;
pub use mass::{FlownMass, FlownState, FuelRecord, FuelSource};
pub use memory::{fit_in_memory, memory_finding};
pub use misfit::{CoherentChannel, Misfit, MisfitPlace, misfit, observation_bands};
pub(crate) use movement::shortfall;
pub use movement::{Movement, deflection, movement};
pub use next_errors::Instruments;
pub use noise::{FlightNoise, NoiseFlight, NoiseRow, SessionNoise, noise, open_entries};
pub use noise_advice::{NoiseAdvice, NoiseEstimate, NoiseStep, channel_advice, noise_advice, noise_of_all};
pub use observability::Observability;
pub use onsets::{OnsetShift, mean_shift, onset_shifts};
pub(crate) use path::measurements_of;
pub use path::{PathAssessment, PathSeries, SmoothedSeries, WindowPath, paths, reconstructions};
pub(crate) use path_errors::MOST_SAMPLES;
pub use path_errors::{ConstantError, ErrorWindow, PathErrors, WidenedFits, path_errors};
pub use physics::{FlightPhysics, PhysicsRow, physics_of};
pub(crate) use placement::move_accelerometer;
pub use prediction::Prediction;
pub use proposals::{
    Candidate, FlightProposals, LEAST_PRESSURE_SHARE, SignalSpectrum, WindowProposal, find_candidates,
    find_open_candidates, open_windows, proposals, proposals_above,
};
pub use recording::{LoadedFlight, align_flight, describe_change, read_flight, restart_findings};
pub use replay::{
    ProofOfMatch, ReplaySeries, ReplayWindow, StudyWindow, WindowFlight, WindowReplay, bands, model_of_window, replay,
    window_flight,
};
pub(crate) use replay::{fly_window, measured_histories};
pub(crate) use samples::values_at;
pub use sensor_errors::EstimatedSensorErrors;
pub use signals::TreatedSignal;
pub use stalls::Stall;
pub use steadiness::{Steadiness, measure_steadiness};
pub use structure_scores::StructureScore;
pub use tolerances::{
    Certainty, Judgement, ObjectiveTest, OutsideTest, PercentRule, Quantity, Reading, RecordDemand, Tolerances,
    ValueTolerance,
};
pub use truth::TruthError;
pub use window_context::{ANGULAR_ACCELERATIONS, WindowContext};
pub use window_samples::{NO_PATH_MEASUREMENT, Samples, measured_by, partly_outside, samples};
