//! Time histories of a snapshot.

use std::borrow::Cow;

use doublet_core::model::{Coefficient, Variable};
use doublet_core::reconstruct::{Deviations, INPUTS, Input, Measurement, MeasurementSeries, Outlier, State};
use doublet_core::validate::Signal;

use super::{History, HistoryColumn, Names, Values};
use crate::session::Session;
use crate::snapshot::{Snapshot, WindowResults};
use crate::stage::{FlightEngines, LoadedFlight, UsedClock, WindowPath, WindowReplay, is_stamped_by};
use crate::study::{FollowedFlight, WindowContributions};

/// Reconstructed paths, coefficients and fits of all windows that have any, and the engines over the flights.
pub fn collect<'a>(session: &Session, snapshot: &'a Snapshot) -> Vec<History<'a>> {
    let mut histories = Vec::new();
    for window in &session.windows {
        if let Some(results) = snapshot.windows.get(&window.name) {
            window_histories(&mut histories, &plain(&window.name), results);
        }
    }
    if let Some(study) = snapshot.studies.manoeuvres.ready() {
        histories.extend(study.contributions.iter().filter_map(contributions));
    }
    for (window, replay) in snapshot.proof.ready().iter().flat_map(|proof| &proof.windows) {
        if let Ok(replay) = replay {
            histories.push(replayed(plain(window), replay));
        }
    }
    if let Some(study) = snapshot.studies.checks.ready() {
        for window in &study.windows {
            histories.extend(window.flights().filter_map(|flight| output_error(plain(&window.window), flight)));
        }
    }
    for flight in &session.flights {
        if let Some(engines) = snapshot.engines.get(&flight.name).and_then(|slot| slot.ready()) {
            engine_histories(&mut histories, &format!("flights/{}", plain(&flight.name)), engines);
        }
    }
    histories
}

/// Terms of one coefficient over one window.
fn contributions(found: &WindowContributions) -> Option<History<'_>> {
    let first = found.terms.first()?;
    let columns = found.terms.iter().map(|term| {
        let description = "derivative times variable, by the pooled estimate";
        HistoryColumn::new(format!("contributions/{}", term.derivative), "-", description, &term.series.values)
    });
    Some(History {
        group: plain(&found.window),
        kind: format!("contributions {}", found.coefficient.name()),
        time_paths: vec![format!("contributions/{}_time", found.coefficient.name())],
        time_s: Cow::Borrowed(&first.series.time_s),
        columns: columns.collect(),
    })
}

/// A window flown again by the pooled model: measured, simulated, and the widest tolerance band.
fn replayed(group: String, replay: &WindowReplay) -> History<'_> {
    let mut bands = crate::stage::bands(&replay.tests);
    let mut columns = Vec::new();
    for signal in Signal::ALL {
        let (name, unit) = (signal.name(), signal.dimension().si_symbol());
        let mut put = |folder: &str, description: &str, values| {
            let (path, unit, description) = (format!("match/{folder}/{name}"), unit.to_owned(), description.to_owned());
            let values = Values::Numbers(values);
            columns.push(HistoryColumn { path, unit, description, values });
        };
        put("measured", signal.description(), Cow::Borrowed(replay.measured.get(signal)));
        put("simulated", signal.description(), Cow::Borrowed(replay.simulated.get(signal)));
        if let Some(band) = bands.remove(&signal) {
            put("tolerance", "half width of the tolerance band", Cow::Owned(band));
        }
    }
    History {
        group,
        kind: "match".to_owned(),
        time_paths: vec!["match/time".to_owned()],
        time_s: Cow::Borrowed(&replay.measured.time_s),
        columns,
    }
}

/// Outputs of a window as its output-error estimate flies them.
fn output_error(group: String, flight: &FollowedFlight) -> Option<History<'_>> {
    let axis = flight.axis.name();
    let columns = flight.outputs.iter().map(|output| {
        let description = "flown by the output-error estimate";
        HistoryColumn::new(format!("output_error/{}", output.output.name()), "SI", description, &output.flown.values)
    });
    Some(History {
        group,
        kind: format!("output_error {axis}"),
        time_paths: vec![format!("output_error/{axis}_time")],
        time_s: Cow::Borrowed(&flight.outputs.first()?.flown.time_s),
        columns: columns.collect(),
    })
}

/// Every recorded channel of every flight: its values as read, its time on the flight's time line and on the recorder's own clock.
/// Channels with a role have it in their description.
pub fn recordings<'a>(session: &Session, snapshot: &'a Snapshot) -> Vec<History<'a>> {
    let loaded =
        session.flights.iter().filter_map(|flight| Some((flight, snapshot.flights.get(&flight.name)?.ready()?)));
    loaded.flat_map(|(flight, loaded)| flight_channels(&format!("flights/{}", plain(&flight.name)), loaded)).collect()
}

/// Longest name of a channel, bytes.
const LONGEST: usize = 200;

/// A name as one step of a path.
fn plain(name: &str) -> String {
    name.replace('/', "_")
}

/// One history per recorder and time base.
fn flight_channels<'a>(group: &str, loaded: &'a LoadedFlight) -> Vec<History<'a>> {
    let mut histories: Vec<(&'a str, *const f64, Names, History<'a>)> = Vec::new();
    for (index, channel) in loaded.recording.channels.iter().enumerate() {
        let (source, time_s) = (channel.source.as_str(), &channel.series.time_s);
        let known = histories.iter().position(|(other, base, ..)| *other == source && *base == time_s.as_ptr());
        let place = known.unwrap_or_else(|| {
            let number = histories.iter().filter(|(other, ..)| *other == source).count() + 1;
            let folder = format!("channels/{}/{number}", plain(source));
            let clock = loaded.clocks.iter().find(|clock| is_stamped_by(&clock.source, source));
            let history = History {
                group: group.to_owned(),
                kind: format!("channels {} {number}", plain(source)),
                time_paths: vec![format!("{folder}/time")],
                time_s: Cow::Borrowed(time_s),
                columns: vec![HistoryColumn {
                    path: format!("{folder}/recorder_time"),
                    unit: "s".to_owned(),
                    description: "time on the recorder's own clock".to_owned(),
                    values: Values::Numbers(own_time(time_s, clock)),
                }],
            };
            let mut names = Names::default();
            for taken in ["time", "recorder_time"] {
                names.unique(taken.to_owned(), LONGEST);
            }
            histories.push((source, time_s.as_ptr(), names, history));
            histories.len() - 1
        });
        let role = loaded.recording.roles.iter().find(|(_, played)| **played == index);
        let made = loaded.expressions.iter().find(|made| made.channel == index);
        let origin =
            made.map_or_else(|| "recorded".to_owned(), |made| format!("expression {}", made.setting.expression));
        let description = role.map_or_else(|| origin.clone(), |(role, _)| format!("{origin}, {}", role.name()));
        let (.., names, history) = &mut histories[place];
        let folder = history.time_paths[0].trim_end_matches("time");
        history.columns.push(HistoryColumn {
            path: format!("{folder}{}", names.unique(plain(&channel.name), LONGEST)),
            unit: if channel.unit.is_empty() { "-".to_owned() } else { channel.unit.clone() },
            description,
            values: Values::Numbers(Cow::Borrowed(&channel.series.values)),
        });
    }
    histories.into_iter().map(|(.., history)| history).collect()
}

fn own_time<'a>(time_s: &'a [f64], clock: Option<&UsedClock>) -> Cow<'a, [f64]> {
    match clock {
        Some(clock) => Cow::Owned(time_s.iter().map(|&time| clock.model.own_s(time)).collect()),
        None => Cow::Borrowed(time_s),
    }
}

fn window_histories<'a>(histories: &mut Vec<History<'a>>, group: &str, results: &'a WindowResults) {
    if let Some(path) = results.path.ready() {
        path_histories(histories, group, path);
    }
    let Some(aero) = results.aero.ready() else { return };
    let mut columns = Vec::new();
    for coefficient in Coefficient::ALL {
        let path = format!("aero/coefficients/{}", coefficient.name());
        columns.push(HistoryColumn::new(path, "-", "observed coefficient", aero.coefficients.get(coefficient)));
    }
    for &variable in Variable::ALL {
        if let Some(column) = aero.variables.get(variable) {
            let path = format!("aero/variables/{}", variable.name().replace('/', "_over_"));
            columns.push(HistoryColumn::new(path, variable_unit(variable), variable.description(), column));
        }
    }
    columns.push(HistoryColumn {
        path: "aero/air_density".into(),
        unit: "kg/m^3".to_owned(),
        description: "air density".to_owned(),
        values: Values::Numbers(aero.variables.at_rows(&aero.data.density_kg_m3)),
    });
    for fit in results.fits.ready().iter().flat_map(|fits| &fits.fits) {
        if let Some(series) = &fit.series {
            let path = format!("fits/{}", fit.coefficient.name());
            let values = Values::Difference(&series.observed.values, &series.residual.values);
            let (unit, description) = ("-".to_owned(), "fit of this manoeuvre alone".to_owned());
            columns.push(HistoryColumn { path, unit, description, values });
        }
    }
    histories.push(History {
        group: group.to_owned(),
        kind: "aero".to_owned(),
        time_paths: vec!["aero/time".to_owned()],
        time_s: Cow::Borrowed(&aero.coefficients.time_s),
        columns,
    });
}

/// Unit of a variable of the model.
fn variable_unit(variable: Variable) -> &'static str {
    match variable {
        Variable::Alpha | Variable::Beta | Variable::Aileron | Variable::Elevator | Variable::Rudder => "rad",
        Variable::Flap | Variable::ElevatorTrim | Variable::Stabiliser => "rad",
        Variable::Airspeed => "m/s",
        Variable::Altitude => "m",
        _ => "-",
    }
}

fn deviation_column<'a>(path: String, unit: &str, description: &str, values: &'a Deviations) -> HistoryColumn<'a> {
    let (unit, description) = (unit.to_owned(), description.to_owned());
    HistoryColumn { path, unit, description, values: Values::Deviations(values) }
}

fn path_histories<'a>(histories: &mut Vec<History<'a>>, group: &str, path: &'a WindowPath) {
    let reconstruction = &path.reconstruction;
    let mut columns = Vec::new();
    for index in 0..INPUTS {
        let input = Input::ALL[index];
        let unit = input.dimension().si_symbol();
        let at = format!("path/inputs/{}", input.name());
        columns.push(HistoryColumn::new(at, unit, input.description(), &path.data.inputs.columns[index]));
    }
    for state in State::ALL {
        let (index, unit) = (state as usize, state.dimension().si_symbol());
        let at = |folder: &str| format!("path/{folder}/{}", state.name());
        columns.push(HistoryColumn::new(at("states"), unit, state.description(), &reconstruction.states[index]));
        let deviations = &reconstruction.deviations[index];
        columns.push(deviation_column(at("deviations"), unit, "standard deviation of the state", deviations));
        if let Some(smoothed) = &reconstruction.smoothed {
            columns.push(HistoryColumn::new(at("smoothed"), unit, "smoothed state", &smoothed.states[index]));
            let (at, description) = (at("smoothed_deviations"), "standard deviation of the smoothed state");
            columns.push(deviation_column(at, unit, description, &smoothed.deviations[index]));
        }
    }
    let history = |kind: &str, time: &str, time_s: &'a [f64], columns| History {
        group: group.to_owned(),
        kind: kind.to_owned(),
        time_paths: vec![time.to_owned()],
        time_s: Cow::Borrowed(time_s),
        columns,
    };
    histories.push(history("path", "path/time", &reconstruction.time_s, columns));
    let mut columns =
        vec![HistoryColumn::new("path/nis".into(), "-", "normalised innovation squared", &reconstruction.nis)];
    let mut measured: Vec<History<'a>> = Vec::new();
    for measurement in Measurement::ALL {
        let (index, unit) = (measurement as usize, measurement.dimension().si_symbol());
        let series = &path.data.measurements[index];
        if series.time_s.is_empty() {
            continue;
        }
        let name = measurement.name();
        let (innovations, deviations) =
            (&reconstruction.innovations[index], &reconstruction.innovation_deviations[index]);
        // A path as measured has none.
        if !innovations.is_empty() {
            let at = format!("path/innovations/{name}");
            columns.push(HistoryColumn::new(at, unit, "measurement minus prediction", innovations));
            let at = format!("path/innovation_deviations/{name}");
            columns.push(deviation_column(at, unit, "predicted standard deviation", deviations));
        }
        let time = format!("path/measured/{name}/time");
        let value =
            HistoryColumn::new(format!("path/measured/{name}/value"), unit, measurement.description(), &series.values);
        let (value, flags) = with_outliers(value, name, series, &reconstruction.outliers[index]);
        match measured.iter_mut().find(|history| *history.time_s == *series.time_s) {
            Some(history) => {
                history.time_paths.push(time);
                history.columns.push(value);
                history.columns.extend(flags);
            }
            None => {
                let kind = format!("measured {}", measured.len() + 1);
                let columns = std::iter::once(value).chain(flags).collect();
                measured.push(history(&kind, &time, &series.time_s, columns));
            }
        }
    }
    histories.push(history("updates", "path/update_time", &reconstruction.update_time_s, columns));
    histories.extend(measured);
}

/// The samples of a measurement with those left out as outliers, and a column that says which they are, where there are any.
fn with_outliers<'a>(
    mut value: HistoryColumn<'a>,
    name: &str,
    series: &MeasurementSeries,
    outliers: &[Outlier],
) -> (HistoryColumn<'a>, Option<HistoryColumn<'a>>) {
    if outliers.is_empty() {
        return (value, None);
    }
    let mut flags = vec![0.0; series.time_s.len()];
    for outlier in outliers {
        let at = series.time_s.partition_point(|time| *time < outlier.time_s).min(flags.len() - 1);
        flags[at] = 1.0;
        if let Values::Numbers(values) = &mut value.values {
            values.to_mut()[at] = outlier.value;
        }
    }
    let (path, unit) = (format!("path/measured/{name}/outlier"), "-".to_owned());
    let description = "1 where the sample was left out as an outlier".to_owned();
    (value, Some(HistoryColumn { path, unit, description, values: Values::Numbers(flags.into()) }))
}

fn engine_histories<'a>(histories: &mut Vec<History<'a>>, group: &str, found: &'a FlightEngines) {
    for engine in &found.engines {
        let name = plain(&engine.name);
        let folder = format!("engines/{name}");
        let rise = "total-pressure rise over dynamic pressure; not a number below 40 kt";
        let columns = [
            ("speed", "rad/s", "speed of the crankshaft", Some(&engine.speed_rad_s)),
            ("manifold_pressure", "Pa", "manifold pressure", Some(&engine.manifold_pressure_pa)),
            ("power", "W", "power of the engine chart", Some(&engine.power_w)),
            ("monitor_power", "W", "power its monitor reports", engine.monitor_power_w.as_ref()),
            ("thrust", "N", "thrust of the propeller map", Some(&engine.thrust_n)),
            ("efficiency", "-", "efficiency of the propeller", Some(&engine.efficiency)),
            ("total_pressure_rise", "-", rise, Some(&engine.total_pressure_rise)),
        ];
        let columns = columns.into_iter().filter_map(|(column, unit, description, series)| {
            Some(HistoryColumn::new(format!("{folder}/{column}"), unit, description, &series?.values))
        });
        histories.push(History {
            group: group.to_owned(),
            kind: format!("engine {name}"),
            time_paths: vec![format!("{folder}/time")],
            time_s: Cow::Borrowed(&engine.power_w.time_s),
            columns: columns.collect(),
        });
    }
}
