//! From a snapshot to the results that leave the program.

use std::collections::BTreeMap;

use doublet_core::airframe::instruments::StatedNoise;
use doublet_core::quantity::Role;
use doublet_core::reconstruct::{AirData, AirState, Measurement, Method, State};
use doublet_core::series::{LONG_WINDOW, Recording, TimeRange};
use doublet_core::statistics::{NORMAL_95, sample_rate_hz};

use super::manoeuvre_map::{MapOf, manoeuvre_map};
use super::prediction::{PredictionAgreement, PredictionRow};
use super::results::{
    ChannelRow, ClockRow, DerivativeRow, DroppedRow, ExpressionRow, FORMAT, FitRow, FlightRow, InnovationRow,
    RecordingRow, RegressorRow, Results, StateRow, VERSION, WindowRow,
};
use super::setup::FileRow;
use super::{gusts, mass, setup, signals, summary};
use crate::session::{Manoeuvre, STEADY, Session, path_warning};
use crate::snapshot::{FitVerdict, Slot, Snapshot};
use crate::stage::{
    self, CoefficientFit, ExpressedChannel, FlightNoise, RegressorCorrelation, UsedClock, WindowPath,
    measure_steadiness,
};
use crate::verdict::{self, NO_WINDOW};
use crate::{date, notation};

/// Collects everything a snapshot says about a session.
pub fn build(session: &Session, snapshot: &Snapshot) -> Results {
    let aircraft = snapshot.aircraft.ready();
    let aircraft = aircraft.map(|loaded| &loaded.aircraft);
    let at_start = mass::mass_properties(session, snapshot);
    let active = session.active_windows();
    let pooled = snapshot.pooled.ready();
    let verdicts = snapshot.verdicts.ready();
    let mut results = Results {
        format: FORMAT,
        version: VERSION,
        app: crate::PROGRAM.to_owned(),
        title: session.title.clone(),
        session_sha256: setup::session_sha256(session),
        aircraft: aircraft.map(|aircraft| aircraft.name.clone()).unwrap_or_default(),
        rate_normalisation: aircraft.map(|aircraft| aircraft.reference.rate_normalisation()).unwrap_or_default(),
        mass_kg: at_start.as_ref().map_or(f64::NAN, |mass| mass.properties.mass_kg),
        mass_properties: at_start,
        reference: aircraft.map(|aircraft| setup::reference(aircraft, &session.preparation)),
        gravity_m_s2: snapshot.gravity_m_s2(session),
        gravity_origin: snapshot.gravity.as_ref().map(|used| used.origin.clone()).unwrap_or_default(),
        sensor_delays: gusts::delays(snapshot),
        gusts: gusts::gusts(snapshot),
        differentiation: signals::differentiation(&session.preparation),
        filter: match session.filter.method {
            Method::Ekf => "extended",
            Method::Iekf { .. } => "iterated extended",
            Method::Ukf { .. } => "unscented",
        },
        verdict: verdicts.map(|found| found.session.clone()),
        warnings: warnings(session),
        recordings: recordings(session, snapshot),
        files: files(session, snapshot),
        flights: flights(session, snapshot),
        engines: super::engines::rows(session, snapshot),
        windows: active.filter_map(|window| window_row(window, session, snapshot)).collect(),
        manoeuvre_map: manoeuvre_map(session, snapshot, MapOf::Ready),
        pooled: pooled
            .iter()
            .flat_map(|pooled| pooled.fits.iter().map(|fit| pooled_row(session, snapshot, fit)))
            .chain(verdicts.into_iter().flat_map(|found| found.unused().map(unused_row)))
            .collect(),
        regressor_correlation: regressor_correlation(session, snapshot),
        predictions: pooled
            .iter()
            .flat_map(|pooled| &pooled.predictions)
            .map(|prediction| PredictionRow {
                window: prediction.window.clone(),
                role: prediction.role.name(),
                coefficient: prediction.coefficient.name(),
                agreement: PredictionAgreement::compare(
                    &prediction.quality_identified,
                    &prediction.quality_own_constant,
                ),
            })
            .collect(),
        wind_and_bias: Vec::new(),
        innovation_summary: Vec::new(),
        residual_summary: Vec::new(),
        derivative_summary: Vec::new(),
        validation: Vec::new(),
        sensor_errors: snapshot.sensor_errors.ready().map(|found| super::sensor_errors::rows(&found.0)),
        studies: super::studies::build(snapshot),
        dynamics: snapshot.dynamics().ready().map(|study| super::dynamics_row(study)),
        proof_of_match: snapshot.proof.ready().map(|proof| super::proof::rows(proof)).unwrap_or_default(),
    };
    summary::complete(&mut results);
    results
}

fn pooled_row(session: &Session, snapshot: &Snapshot, fit: &CoefficientFit) -> FitRow {
    let verdicts = snapshot.verdicts.ready();
    let mut row = fit_row(fit, verdicts.and_then(|found| found.fit(None, fit.coefficient)));
    row.follows = verdict::stated_quantity(snapshot, fit);
    for derivative in &mut row.derivatives {
        derivative.depends_on = verdict::dependences(session, snapshot, fit, &derivative.name);
    }
    row
}

/// What there is to say of the session itself.
fn warnings(session: &Session) -> Vec<String> {
    let none = session.aircraft.is_none().then(|| stage::NO_AIRCRAFT.to_owned());
    let problems = crate::session::check(session);
    let beside = problems.iter().filter(|finding| finding.place.is_named(STEADY)).map(ToString::to_string);
    none.into_iter().chain(path_warning(session)).chain(beside).collect()
}

/// Aircraft and instruments files.
fn files(session: &Session, snapshot: &Snapshot) -> Vec<FileRow> {
    let aircraft = session.aircraft.iter().zip(snapshot.aircraft.ready()).map(|(path, loaded)| FileRow {
        kind: "aircraft",
        flight: String::new(),
        path: path.clone(),
        sha256: loaded.sha256.clone(),
    });
    let instruments = session.flights.iter().filter_map(|flight| {
        let loaded = snapshot.flights.get(&flight.name)?.ready()?;
        Some(FileRow {
            kind: "instruments",
            flight: flight.name.clone(),
            path: flight.instruments.as_ref()?.file.clone(),
            sha256: loaded.instruments_sha256.clone()?,
        })
    });
    aircraft.chain(instruments).collect()
}

fn recordings(session: &Session, snapshot: &Snapshot) -> Vec<RecordingRow> {
    let mut rows = Vec::new();
    for flight in &session.flights {
        let Some(loaded) = snapshot.flights.get(&flight.name).and_then(|slot| slot.ready()) else { continue };
        for (entry, hash) in flight.recordings.iter().zip(&loaded.hashes) {
            rows.push(RecordingRow { flight: flight.name.clone(), path: entry.path.clone(), sha256: hash.clone() });
        }
    }
    rows
}

fn flights(session: &Session, snapshot: &Snapshot) -> Vec<FlightRow> {
    let loaded =
        session.flights.iter().filter_map(|flight| Some((flight, snapshot.flights.get(&flight.name)?.ready()?)));
    let rows = loaded.map(|(flight, loaded)| {
        let (noise, proposals) = signals::rows(session, snapshot, &flight.name);
        let physics = snapshot.physics.get(&flight.name).and_then(|slot| slot.ready());
        FlightRow {
            name: flight.name.clone(),
            date: Some(flight.date.clone())
                .filter(|stated| !stated.is_empty())
                .or_else(|| loaded.utc_start_s.and_then(date::format_instant)),
            crew: flight.crew.clone(),
            roles: loaded.recording.roles.keys().map(|role| role.name().to_owned()).collect(),
            channels: channels(&loaded.recording, &loaded.stated_noise),
            clocks: loaded.clocks.iter().map(clock_row).collect(),
            mass_properties: snapshot
                .flown
                .get(&flight.name)
                .and_then(Slot::ready)
                .map(|flown| mass::flown_masses(flown)),
            max_gap_s: loaded.recording.max_gap_s,
            signals: signals::signal_rows(loaded),
            expressions: loaded.expressions.iter().map(|made| expression_row(&loaded.recording, made)).collect(),
            noise,
            proposals,
            physics: physics.map(|physics| physics.rows.clone()).unwrap_or_default(),
            warnings: loaded.recording.warnings.iter().map(ToString::to_string).collect(),
        }
    });
    rows.collect()
}

fn channels(recording: &Recording, stated: &BTreeMap<Role, StatedNoise>) -> Vec<ChannelRow> {
    let playing = Role::ALL.iter().filter_map(|&role| Some((role, recording.role(role)?)));
    let rows = playing.map(|(role, channel)| {
        let time_s = &channel.series.time_s;
        let found = channel.series.statistics(TimeRange { start_s: f64::NEG_INFINITY, end_s: f64::INFINITY });
        ChannelRow {
            role: role.name(),
            source: channel.source.clone(),
            name: channel.name.clone(),
            unit: channel.unit.clone(),
            samples: time_s.len(),
            rate_hz: sample_rate_hz(time_s).unwrap_or(f64::NAN),
            minimum: found.map(|found| found.min),
            maximum: found.map(|found| found.max),
            accuracy: stated.get(&role).map(|noise| noise.std),
            accuracy_source: stated.get(&role).map(|noise| noise.source.clone()),
        }
    });
    rows.collect()
}

fn expression_row(recording: &Recording, made: &ExpressedChannel) -> ExpressionRow {
    let channel = &recording.channels[made.channel];
    let all = TimeRange { start_s: f64::NEG_INFINITY, end_s: f64::INFINITY };
    let found = channel.series.statistics(all);
    ExpressionRow {
        name: channel.name.clone(),
        unit: channel.unit.clone(),
        expression: made.setting.expression.clone(),
        role: made.setting.role.map(Role::name),
        samples: channel.series.values.len(),
        values: found.map_or(0, |found| found.samples),
        min_mean_max: found.map(|found| [found.min, found.mean, found.max]),
    }
}

fn clock_row(clock: &UsedClock) -> ClockRow {
    ClockRow {
        source: clock.source.clone(),
        offset_s: clock.model.offset_s,
        drift: clock.model.drift,
        shift_s: clock.shift_s,
        standard_error_s: clock.estimate.as_ref().map(|estimate| estimate.best_known.1),
        drift_standard_error: clock.estimate.as_ref().map(|estimate| estimate.drift_sd),
    }
}

fn window_row(window: &Manoeuvre, session: &Session, snapshot: &Snapshot) -> Option<WindowRow> {
    let results = snapshot.windows.get(&window.name)?;
    let noise = snapshot.noise.get(&window.flight).and_then(|slot| slot.ready()).map(|noise| &**noise);
    let path = results.path.ready();
    let of_path = path.iter().flat_map(|path| &path.assessment().warnings);
    let of_aero = results.aero.ready().into_iter().flat_map(|aero| &aero.warnings);
    let warnings = of_path.chain(of_aero).map(ToString::to_string).collect();
    let consistency = path.and_then(|path| path.assessment().consistency.as_ref());
    let verdicts = snapshot.verdicts.ready();
    let own_row = |fit: &CoefficientFit| {
        fit_row(fit, verdicts.and_then(|found| found.fit(Some(window.name.as_str()), fit.coefficient)))
    };
    Some(WindowRow {
        name: window.name.clone(),
        flight: window.flight.clone(),
        start_s: window.window.start_s,
        end_s: window.window.end_s,
        role: window.role.name(),
        surface: window.surface_name(),
        kind: window.kind.clone(),
        note: window.note.clone(),
        excluded: window.excluded.clone(),
        mass_properties: mass::window_mass(window, snapshot),
        verdict: verdicts.and_then(|found| Some(found.windows.get(&window.name)?.verdict.clone())),
        error: results.error().map(str::to_owned),
        samples: path.map_or(0, |path| path.reconstruction.time_s.len()),
        air_density: results.aero.ready().map(|aero| aero.air_density.name()),
        before_input: results.aero.ready().and_then(|aero| measure_steadiness(aero)),
        mean_nis: consistency.map_or(f64::NAN, |c| c.nis_mean),
        expected_nis: consistency.map_or(f64::NAN, |c| c.nis_mean / c.nis_ratio),
        nis_band: consistency.map_or([f64::NAN; 2], |c| c.nis_band),
        nis_band_correlated: consistency.map_or([f64::NAN; 2], |c| c.nis_band_correlated),
        missing_measurements: path.iter().flat_map(|path| &path.missing).map(|m| m.name()).collect(),
        states: path.map(|path| state_rows(path)).unwrap_or_default(),
        innovations: path.map(|path| innovation_rows(path, session, noise)).unwrap_or_default(),
        fits: results.fits.ready().iter().flat_map(|fits| fits.fits.iter().map(own_row)).collect(),
        warnings,
    })
}

fn state_rows(path: &WindowPath) -> Vec<StateRow> {
    State::ALL.into_iter().filter_map(|state| state_row(state, path)).chain(air_data_rows(path)).collect()
}

fn state_row(state: State, path: &WindowPath) -> Option<StateRow> {
    let reconstruction = &path.reconstruction;
    let truth = path.assessment().truth.get(&state);
    Some(StateRow {
        state: state.name(),
        unit: state.dimension().si_symbol(),
        estimate: *reconstruction.states[state as usize].last()?,
        deviation: reconstruction.deviations[state as usize].last()?,
        last_second_mean: last_second_mean(&reconstruction.time_s, &reconstruction.states[state as usize]),
        truth: truth.map(|truth| truth.last),
        mean_squared_normalised_error: truth.map(|truth| truth.mean_squared_normalised_error),
    })
}

/// Mean of the samples of the last second; not a number where there are none.
fn last_second_mean(time_s: &[f64], values: &[f64]) -> f64 {
    let last_s = time_s.last().copied().unwrap_or_default();
    let tail = &values[time_s.partition_point(|&time| time < last_s - 1.0)..];
    tail.iter().sum::<f64>() / tail.len() as f64
}

/// The air-data states, smoothed where the path is: a filter linearised once can be far too certain of them.
fn air_data_rows(path: &WindowPath) -> Vec<StateRow> {
    let reconstruction = &path.reconstruction;
    let smoothed = reconstruction.smoothed.as_ref().map(|smoothed| &smoothed.air_data);
    let Some(air_data) = smoothed.unwrap_or(&reconstruction.air_data) else { return Vec::new() };
    AirState::ALL.into_iter().filter_map(|state| air_data_row(state, air_data, &reconstruction.time_s)).collect()
}

fn air_data_row(state: AirState, air_data: &AirData, time_s: &[f64]) -> Option<StateRow> {
    let (estimate, deviation) =
        (*air_data.states[state as usize].last()?, *air_data.deviations[state as usize].last()?);
    let unit = state.dimension().si_symbol();
    let row = StateRow {
        state: state.name(),
        unit,
        estimate,
        deviation,
        last_second_mean: last_second_mean(time_s, &air_data.states[state as usize]),
        truth: None,
        mean_squared_normalised_error: None,
    };
    (deviation > 0.0).then_some(row)
}

fn innovation_rows(path: &WindowPath, session: &Session, noise: Option<&FlightNoise>) -> Vec<InnovationRow> {
    let advice = stage::noise_advice(path, &session.filter.measurement_noise, noise);
    let advice_on = |measurement: Measurement| {
        let found = advice.iter().find(|advice| advice.measurement == measurement);
        let (unit, scale) = notation::unit(measurement.dimension());
        let show = |std: f64| format!("{} {unit}", notation::significant(scale * std, 3));
        found.map_or_else(String::new, |advice| advice.text(&show))
    };
    let channels = path.assessment().consistency.iter().flat_map(|consistency| &consistency.channels);
    let rows = channels.map(|channel| InnovationRow {
        measurement: channel.measurement.name(),
        samples: channel.samples,
        outliers: path.reconstruction.outliers[channel.measurement as usize].len(),
        mean: channel.mean,
        ratio: channel.deviation_ratio,
        is_white: channel.is_white,
        advice: advice_on(channel.measurement),
    });
    rows.collect()
}

/// A coefficient of the model that no window is used for.
fn unused_row(judged: &FitVerdict) -> FitRow {
    let fit = CoefficientFit {
        coefficient: judged.coefficient,
        windows: Vec::new(),
        fit: Err(NO_WINDOW.into()),
        corrected_errors: Vec::new(),
        noise_errors: Vec::new(),
        series: None,
        dropped: Vec::new(),
    };
    fit_row(&fit, Some(judged))
}

fn fit_row(fit: &CoefficientFit, judged: Option<&FitVerdict>) -> FitRow {
    let dropped =
        fit.dropped.iter().map(|term| DroppedRow { name: term.derivative.clone(), reason: term.reason.clone() });
    let mut row = FitRow {
        coefficient: fit.coefficient.name(),
        windows: fit.windows.iter().map(|(name, _)| name.clone()).collect(),
        verdict: judged.map(|judged| judged.verdict.clone()),
        error: None,
        samples: fit.windows.iter().map(|(_, samples)| samples).sum(),
        r_squared: f64::NAN,
        rms_relative_percent: f64::NAN,
        residual_deviation: f64::NAN,
        condition_number: f64::NAN,
        follows: None,
        derivatives: Vec::new(),
        parameter_correlation: Vec::new(),
        dropped: dropped.collect(),
    };
    match &fit.fit {
        Err(error) => row.error = Some(error.to_string()),
        Ok(estimate) => {
            row.r_squared = estimate.quality.r_squared;
            row.rms_relative_percent = estimate.quality.rms_relative_percent;
            row.residual_deviation = estimate.residual_std;
            row.condition_number = estimate.condition_number;
            row.parameter_correlation =
                estimate.correlation.row_iter().map(|row| row.iter().copied().collect()).collect();
            row.derivatives = (0..estimate.parameters())
                .map(|index| (index, stage::significance(estimate, &fit.corrected_errors, index)))
                .map(|(index, significance)| {
                    (index, significance, stage::errors(estimate, &fit.corrected_errors, index))
                })
                .map(|(index, (relative_error_percent, t), (standard_error, corrected_standard_error))| DerivativeRow {
                    name: estimate.names[index].clone(),
                    verdict: judged.and_then(|judged| judged.derivative(&estimate.names[index]).cloned()),
                    consequence: judged.and_then(|judged| judged.consequence(&estimate.names[index]).cloned()),
                    depends_on: Vec::new(),
                    estimate: estimate.estimates[index],
                    held: stage::describe_origin(estimate.origins[index]),
                    standard_error,
                    corrected_standard_error,
                    interval_95: interval_95(estimate.estimates[index], corrected_standard_error),
                    relative_error_percent,
                    t,
                })
                .collect();
        }
    }
    row
}

/// 95 % interval of an estimate; none without a standard error.
fn interval_95(estimate: f64, standard_error: f64) -> Option<[f64; 2]> {
    let half = NORMAL_95 * standard_error;
    half.is_finite().then_some([estimate - half, estimate + half])
}

/// Correlation of the regressors over the identification manoeuvres; none with a long one, where its samples would be held twice.
fn regressor_correlation(session: &Session, snapshot: &Snapshot) -> Vec<RegressorRow> {
    let windows = snapshot.aero(session);
    if windows.iter().any(|(_, aero)| aero.data.time_s.len() > LONG_WINDOW) {
        return Vec::new();
    }
    let found = stage::regressor_correlations(&windows, None, &session.structure, &session.estimation);
    found.into_iter().map(correlation_row).collect()
}

fn correlation_row(found: RegressorCorrelation) -> RegressorRow {
    RegressorRow {
        coefficient: found.coefficient.name(),
        correlation: found.correlation.row_iter().map(|row| row.iter().copied().collect()).collect(),
        derivatives: found.derivatives,
    }
}
