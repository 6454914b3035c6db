//! From a flight on its time line to signals as the filter gets them, noise and proposed windows: the shipped flight.

use std::collections::BTreeSet;
use std::path::Path;
use std::sync::OnceLock;

use doublet_core::prep::{Interpolation, NoiseOrigin, Smoothing, resample, smooth};
use doublet_core::quantity::Role;
use doublet_core::reconstruct::{Input, Measurement};
use doublet_core::series::{Series, TimeRange};
use doublet_engine::graph::{Context, StageError};
use doublet_engine::session::{
    self, ClockPairSetting, ClockSetting, Edit, EditError, ExpressionSetting, LevelFlight, NoiseChannel, NoiseEdit,
    NoiseEntry, Opened, SignalEdit, SignalPreset, SignalSetting, SteadyWindow, Surface, WindowEdit,
};
use doublet_engine::stage::{self, FlightNoise, FlightProposals, LoadedFlight, NoiseFlight};

fn demo() -> &'static Opened {
    static DEMO: OnceLock<Opened> = OnceLock::new();
    DEMO.get_or_init(|| {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../sessions/demo.toml");
        session::open(&path).unwrap()
    })
}

fn read() -> &'static LoadedFlight {
    static READ: OnceLock<LoadedFlight> = OnceLock::new();
    READ.get_or_init(|| {
        stage::read_flight(&Context::new(&demo().folder), &demo().session.flights[0].recordings).unwrap()
    })
}

/// The shipped recording with all that `flight` makes of it.
fn aligned(flight: &session::Flight) -> Result<LoadedFlight, StageError> {
    let aligned = stage::align_flight(&Context::new(&demo().folder), read(), flight)?;
    stage::add_expressions(&aligned, &flight.expressions)
}

/// The flight on its time line, nothing smoothed.
fn recorded() -> &'static LoadedFlight {
    static RECORDED: OnceLock<LoadedFlight> = OnceLock::new();
    RECORDED.get_or_init(|| aligned(&demo().session.flights[0]).unwrap())
}

fn proposals() -> &'static FlightProposals {
    static PROPOSALS: OnceLock<FlightProposals> = OnceLock::new();
    PROPOSALS.get_or_init(|| stage::proposals("FT1", recorded()))
}

/// Its noise over marked windows, or those found.
fn noise_of(marked: &[SteadyWindow]) -> FlightNoise {
    let flight = NoiseFlight { name: "FT1", loaded: recorded(), proposals: proposals() };
    stage::noise(&[flight], marked).remove(0)
}

#[test]
fn a_clock_that_cannot_be_fitted_stops_the_flight_only_where_path_or_controls_need_it() {
    // The engine monitor, which is not in the time line of the others but for its clock; the pod gives the flow angles.
    let missing = ClockPairSetting { reference: "bus/none".to_owned(), other: "none/none".to_owned(), inverted: false };
    let with = |source: &str| {
        let mut flight = demo().session.flights[0].clone();
        flight.clocks.retain(|clock| clock.source != source);
        flight.clocks.push(ClockSetting { fit: vec![missing.clone()], ..ClockSetting::new(source) });
        aligned(&flight)
    };
    let engines = &recorded().recording;
    let source = engines.role(Role::ManifoldPressure1).unwrap().source.clone();
    let loaded = with(&source).unwrap();
    let finding = loaded.findings.iter().find(|finding| finding.code == "clock").unwrap();
    assert!(finding.place.to_string().contains(&source) && finding.text.to_string().contains("not found"), "{finding}");
    for role in [Role::SpecificForceZ, Role::AngleOfAttack, Role::Elevator] {
        let [found, expected] =
            [&loaded.recording, engines].map(|recording| recording.role(role).unwrap().series.finite());
        assert!(found == expected && !found.time_s.is_empty(), "{}", role.name());
    }
    // The pod's channels have no roles of their own: the instruments make the angle of attack of them.
    let error = with("pod").unwrap_err().to_string();
    assert!(error.starts_with("clock of pod: ") && error.contains("'bus/none'"), "{error}");
}

/// The bus with nothing on other clocks, so that no clock is fitted.
fn bus(setting: SignalSetting, shift_s: f64) -> LoadedFlight {
    let mut flight = demo().session.flights[0].clone();
    flight.instruments = None;
    flight.clocks.clear();
    flight.signals = setting;
    let session = session::Session { flights: vec![flight], ..demo().session.clone() };
    let shift = SignalEdit::Shift { flight: "FT1".into(), source: "navigation".into(), shift_s };
    let shifted = Edit::Signal(shift).apply(&session).unwrap();
    aligned(&shifted.flights[0]).unwrap()
}

#[test]
fn the_thesis_preset_is_moving_average_polynomial_and_spline_to_100_hz() {
    let preset = SignalSetting::default().with_preset(SignalPreset::Thesis);
    assert_eq!(preset.preset(), Some(SignalPreset::Thesis));
    let treated = bus(preset, 0.0);
    let roll = &treated.recording.role(Role::RollRate).unwrap().series;
    let raw = &bus(SignalSetting::default(), 0.0).recording.role(Role::RollRate).unwrap().series.clone();
    // Independently, over a stretch away from its ends: the thesis's three steps one by one.
    let range = TimeRange { start_s: 1050.0, end_s: 1075.0 }.indices(&raw.time_s);
    let (time, values) = (&raw.time_s[range.clone()], &raw.values[range]);
    let averaged = smooth(time, values, Smoothing::MovingAverage { width: 4 }).unwrap();
    let polynomial = Smoothing::LocalPolynomial { degree: 2, half_width: 5 };
    let smoothed = smooth(time, &averaged, polynomial).unwrap();
    let inside = TimeRange { start_s: 1055.0, end_s: 1070.0 }.indices(&roll.time_s);
    let at = &roll.time_s[inside.clone()];
    assert_eq!(at.len(), 1501);
    let expected = resample(time, &smoothed, at, Interpolation::QuadraticSpline).unwrap();
    for (found, expected) in roll.values[inside].iter().zip(&expected) {
        // The spline forgets its ends by a factor of about six per sample; 250 samples leave rounding only.
        assert!((found - expected).abs() < 1e-12, "{found} for {expected}");
    }
    let row = treated.treated.iter().find(|signal| signal.role == Role::RollRate).unwrap();
    assert_eq!(
        row.steps,
        ["moving average of 4", "polynomial of degree 2 over 11 samples", "quadratic spline to 100 Hz"]
    );
    assert_eq!(treated.recording.channels[row.recorded].series.time_s, raw.time_s);
    assert_eq!(row.samples[0], raw.values.len());
    // Straight lines for the rest, which share the stamps of the inertial samples.
    let bank = &treated.recording.role(Role::BankAngle).unwrap().series;
    let inside = TimeRange { start_s: 1055.0, end_s: 1070.0 }.indices(&bank.time_s);
    assert_eq!(bank.time_s[inside], *at);
}

#[test]
fn signals_are_left_as_recorded_by_default_and_a_shift_moves_stamps_only() {
    /// Rounding of stamps of a few thousand seconds.
    const ROUNDING_S: f64 = 1e-11;
    let plain = bus(SignalSetting::default(), 0.0);
    assert!(plain.treated.is_empty() && recorded().treated.is_empty());
    let shifted = bus(SignalSetting::default(), 0.25);
    let of = |flight: &LoadedFlight, role| flight.recording.role(role).unwrap().series.clone();
    let (before, after) = (of(&plain, Role::VelocityNorth), of(&shifted, Role::VelocityNorth));
    assert_eq!(before.values, after.values);
    assert!(before.time_s.iter().zip(&*after.time_s).all(|(a, b)| (b - a - 0.25).abs() < ROUNDING_S));
    assert_eq!(of(&plain, Role::RollRate).time_s, of(&shifted, Role::RollRate).time_s);
}

#[test]
fn a_stated_gap_is_never_bridged() {
    // The heading comes at 25 Hz: its samples are further apart than 0.03 s, so nothing may be put between them.
    let torn =
        bus(SignalSetting { max_gap_s: Some(0.03), rules: SignalPreset::Thesis.rules(), ..Default::default() }, 0.0);
    let row = torn.treated.iter().find(|signal| signal.role == Role::HeadingAngle).unwrap();
    assert_eq!(row.stretches, row.samples[0]);
    assert!(
        torn.recording
            .warnings
            .iter()
            .any(|warning| warning.to_string().contains("psi") && warning.to_string().contains("too short"))
    );
    let roll = torn.treated.iter().find(|signal| signal.role == Role::RollRate).unwrap();
    assert!(roll.stretches < 10 && roll.samples[1] > roll.samples[0]);
}

#[test]
fn the_position_is_the_integral_of_the_velocity_and_begins_anew_after_a_gap() {
    let integrated = SignalSetting { position_from_velocity: true, ..Default::default() };
    assert_eq!(integrated.preset(), None);
    let flight = bus(integrated.clone(), 0.0);
    let of = |flight: &LoadedFlight, role| flight.recording.role(role).unwrap().series.clone();
    let (velocity, position) = (of(&flight, Role::VelocityNorth), of(&flight, Role::PositionNorth));
    assert_eq!(velocity.time_s, position.time_s);
    // Between two instants: the area under straight lines, summed backwards and by rectangles about the middles.
    let range = TimeRange { start_s: 1050.0, end_s: 1075.0 }.indices(&velocity.time_s);
    let (time, value) = (&velocity.time_s[range.clone()], &velocity.values[range.clone()]);
    let area: f64 =
        (1..time.len()).rev().map(|k| (value[k - 1] + (value[k] - value[k - 1]) / 2.0) * (time[k] - time[k - 1])).sum();
    let moved = position.values[range.end - 1] - position.values[range.start];
    assert!((moved - area).abs() < 1e-8 * area.abs(), "{moved} against {area}");
    // And what the aircraft truly flew: a velocity of 0.02 m/s noise, 5 times a second over 25 s, is good for some centimetres.
    let truth = &flight.recording.truth["x"];
    let at = |time: f64| resample(&truth.time_s, &truth.values, &[time], Interpolation::Linear).unwrap()[0];
    let window = TimeRange { start_s: 1058.0, end_s: 1069.0 }.indices(&velocity.time_s);
    let (first, last) = (window.start, window.end - 1);
    let flown = at(velocity.time_s[last]) - at(velocity.time_s[first]);
    let found = position.values[last] - position.values[first];
    assert!((found - flown).abs() < 0.1, "{found} against {flown}");
    // The thesis integrates what it has resampled.
    let thesis = bus(SignalSetting::default().with_preset(SignalPreset::Thesis), 0.0);
    let row = thesis.treated.iter().find(|signal| signal.role == Role::PositionEast).unwrap();
    assert_eq!(row.steps, ["trapezoids of v_east"]);
    assert_eq!(of(&thesis, Role::PositionEast).time_s, of(&thesis, Role::VelocityEast).time_s);
    // A gap ends the integral: the velocity comes every 0.2 s, so that nothing may be summed over 0.1 s.
    let torn = bus(SignalSetting { max_gap_s: Some(0.1), ..integrated }, 0.0);
    assert!(of(&torn, Role::PositionNorth).values.iter().all(|&value| value == 0.0));
    assert!(torn.recording.warnings.iter().any(|line| line.to_string().contains("x and y restart")));
}

#[test]
fn level_flight_calibrates_the_pod_by_the_lift_curve() {
    /// Thesis sections 4.3.2 and 4.3.3, flight FT1.0: mass, pressure altitude of its test points, lift curve, wing area.
    const MASS_KG: f64 = 2044.0;
    const ALTITUDE_M: f64 = 4000.0 * 0.3048;
    const LIFT: [f64; 2] = [0.333, 0.086];
    const AREA_M2: f64 = 18.7;
    // Standard atmosphere at 4,000 ft, by its formula.
    let density = 1.225 * (1.0 - 0.0065 * ALTITUDE_M / 288.15f64).powf(9.806_65 / (287.052_87 * 0.0065) - 1.0);
    // Airspeeds at which level flight has the three angles of Table 4.11; that of the number 0 is the 101 kt the thesis states.
    let published = [4.754f64, 8.05, 11.45];
    let airspeed =
        |alpha_deg: f64| (2.0 * MASS_KG * 9.806_65 / (density * AREA_M2 * (LIFT[0] + LIFT[1] * alpha_deg))).sqrt();
    assert!((airspeed(published[0]) * 3600.0 / 1852.0 - 101.0).abs() < 1.5, "{}", airspeed(published[0]));
    let mut flight = demo().session.flights[0].clone();
    let instruments = flight.instruments.as_mut().unwrap();
    let level = LevelFlight {
        mass_kg: MASS_KG,
        airspeed_m_s: published.map(airspeed),
        altitude_m: Some(ALTITUDE_M),
        density_kg_m3: None,
    };
    instruments.level_flight = Some(level.clone());
    let refused = aligned(&flight).unwrap_err().to_string();
    assert!(refused.contains("calibrated twice"), "{refused}");
    let with = |level: LevelFlight| {
        let mut flight = flight.clone();
        let instruments = flight.instruments.as_mut().unwrap();
        (instruments.pod_calibration, instruments.level_flight) = (String::new(), Some(level));
        let session = session::Session { flights: vec![flight], ..demo().session.clone() };
        let session = session::parse(&session::print(&session).unwrap()).unwrap();
        aligned(&session.flights[0])
    };
    let alpha = |flight: &LoadedFlight| flight.recording.role(Role::AngleOfAttack).unwrap().series.clone();
    let (made, table) = (alpha(&with(level.clone()).unwrap()), alpha(recorded()));
    let pairs = made.values.iter().zip(&*table.values);
    let apart = pairs.filter(|(a, b)| a.is_finite() && b.is_finite()).map(|(a, b)| (a - b).abs().to_degrees());
    let apart: Vec<f64> = apart.collect();
    // Two curves through the same three points.
    let most = apart.iter().copied().fold(0.0, f64::max);
    assert!(apart.len() > 5000 && most > 0.0 && most < 0.15, "{most} deg over {} samples", apart.len());
    // The density may be stated instead; a lighter aircraft flies at less.
    let dense = LevelFlight { altitude_m: None, density_kg_m3: Some(density), ..level.clone() };
    let same = alpha(&with(dense).unwrap());
    let differ = same.values.iter().zip(&*made.values).filter(|(a, b)| (*a - *b).abs() > 1e-6).count();
    assert_eq!(differ, 0);
    let lighter = alpha(&with(LevelFlight { mass_kg: 1900.0, ..level.clone() }).unwrap());
    assert!(lighter.values.iter().zip(&*made.values).filter(|(a, _)| a.is_finite()).all(|(a, b)| a < b));
    for (wrong, expected) in [
        (LevelFlight { altitude_m: None, ..level.clone() }, "either altitude_m or density_kg_m3"),
        (LevelFlight { density_kg_m3: Some(1.0), ..level.clone() }, "either altitude_m or density_kg_m3"),
        (LevelFlight { airspeed_m_s: [40.0, 45.0, 50.0], ..level.clone() }, "fall from reading 0"),
        (LevelFlight { mass_kg: -1.0, ..level }, "above zero"),
    ] {
        let refused = with(wrong).unwrap_err();
        assert!(refused.to_string().contains(expected), "{refused}");
    }
}

#[test]
fn control_sensors_that_record_quaternions_give_the_same_deflections() {
    /// Rounding of the quaternion's text to twelve digits, rad.
    const ROUNDING_RAD: f64 = 1e-9;
    let folder = tempfile::tempdir().unwrap();
    let shipped = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../assets/flights/demo");
    let mut flight = demo().session.flights[0].clone();
    for entry in flight.recordings.iter_mut().filter(|entry| entry.path.contains("/sensor_")) {
        let name = entry.path.rsplit('/').next().unwrap().to_owned();
        std::fs::write(folder.path().join(&name), quaternions(&std::fs::read_to_string(shipped.join(&name)).unwrap()))
            .unwrap();
        (entry.path, entry.sha256) = (name, None);
    }
    // The clock was fitted to a pitch angle, which is not recorded now.
    let clock = flight.clocks.iter_mut().find(|clock| clock.source == "sensor_*").unwrap();
    let fitted = recorded().clocks.iter().find(|clock| clock.source == "sensor_*").unwrap();
    (clock.offset_s, clock.drift) = (fitted.model.offset_s, fitted.model.drift);
    clock.fit.clear();
    let found = Context::new(folder.path()).get::<LoadedFlight>(&flight, ()).unwrap();
    for role in [Role::Aileron, Role::Elevator, Role::Rudder] {
        let of = |flight: &LoadedFlight| flight.recording.role(role).unwrap().series.values.clone();
        let (expected, found) = (of(recorded()), of(&found));
        let worst = expected.iter().zip(&*found).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(expected.len() == found.len() && worst < ROUNDING_RAD, "{role:?}: {worst}");
    }
    // The rates the thesis integrates come from quaternions as well.
    flight.instruments.as_mut().unwrap().thesis_controls = true;
    let thesis = Context::new(folder.path()).get::<LoadedFlight>(&flight, ()).unwrap();
    assert!(thesis.recording.role(Role::Rudder).unwrap().series.values.iter().all(|value| value.is_finite()));
}

/// The recording of a control sensor with its attitude as a quaternion, every other one with the other sign.
fn quaternions(text: &str) -> String {
    let mut out = String::new();
    let mut places: Option<[usize; 3]> = None;
    for (number, line) in text.lines().enumerate() {
        let cells: Vec<&str> = line.split(',').map(str::trim).collect();
        let Some([phi, theta, psi]) = places else {
            let place = |name: &str| cells.iter().position(|cell| *cell == name);
            places = place("phi").and_then(|phi| Some([phi, place("theta")?, place("psi")?]));
            out.push_str(&if places.is_some() {
                format!("{},Quat_W,Quat_X,Quat_Y,Quat_Z\n", cells[0])
            } else {
                format!("{line}\n")
            });
            continue;
        };
        let Ok(angles) =
            [phi, theta, psi].map(|place| cells[place].parse::<f64>()).into_iter().collect::<Result<Vec<f64>, _>>()
        else {
            out.push_str(&format!("{},,,,\n", cells[0]));
            continue;
        };
        let [[sp, cp], [st, ct], [ss, cs]] = [angles[0], angles[1], angles[2]].map(|angle| {
            let (sin, cos) = (angle.to_radians() / 2.0).sin_cos();
            [sin, cos]
        });
        // Heading, pitch, bank (Stevens and Lewis, "Aircraft Control and Simulation", 1.8).
        let parts = [
            cp * ct * cs + sp * st * ss,
            sp * ct * cs - cp * st * ss,
            cp * st * cs + sp * ct * ss,
            cp * ct * ss - sp * st * cs,
        ];
        let sign = if number % 2 == 0 { 1.0 } else { -1.0 };
        let parts: Vec<String> = parts.iter().map(|part| format!("{:.12}", sign * part)).collect();
        out.push_str(&format!("{},{}\n", cells[0], parts.join(",")));
    }
    out
}

#[test]
fn edits_of_signals_refuse_what_cannot_be() {
    let session = &demo().session;
    let mut rules = SignalPreset::Thesis.rules();
    rules[0].polynomial = Some((2, 10));
    let setting = SignalSetting { rules, ..Default::default() };
    let edit = Edit::Signal(SignalEdit::Setting { flight: "FT1".into(), setting });
    assert!(matches!(edit.apply(session), Err(EditError::Signals(text)) if text.contains("odd")));
    let mut rules = SignalPreset::Thesis.rules();
    rules[2].roles.push(Role::RollRate);
    let twice = SignalSetting { max_gap_s: Some(0.0), rules, ..Default::default() };
    assert_eq!(twice.problems().len(), 2, "{:?}", twice.problems());
}

#[test]
fn every_manoeuvre_is_proposed_with_its_surface_and_shape() {
    let proposals = proposals();
    let session = &demo().session;
    // The shipped session was made from what was flown; window 10 is the spoilt one.
    assert_eq!(proposals.windows.len(), session.windows.len());
    for (proposal, flown) in proposals.windows.iter().zip(&session.windows) {
        assert_eq!(proposal.covering_window(session).map(|window| &window.name), Some(&flown.name));
        assert_eq!(proposal.manoeuvre.surface, flown.surface);
        if !flown.name.starts_with("10 ") {
            assert_eq!(proposal.manoeuvre.kind, flown.kind, "{}", flown.name);
            assert!(proposal.confidence > 0.8, "{}: {}", flown.name, proposal.confidence);
        } else {
            assert!(proposal.confidence < 0.5);
        }
    }
    assert!(stage::open_windows(session, proposals).is_empty());
    // Of a session with one window, all but that one are added, in one step and under free names.
    let mut session = session.clone();
    session.windows.truncate(1);
    session.windows[0].name = "02 aileron doublet".to_owned();
    let open = stage::open_windows(&session, proposals);
    let all = Edit::Window(WindowEdit::AddAll(open)).apply(&session).unwrap();
    assert_eq!(all.windows.len(), proposals.windows.len());
    let names: BTreeSet<_> = all.windows.iter().map(|window| &window.name).collect();
    assert!(names.len() == all.windows.len() && names.contains(&"02 aileron doublet (2)".to_owned()));
    assert!(session::check(&all).is_empty());
}

#[test]
fn noise_over_found_windows_is_that_of_the_instruments() {
    let noise = noise_of(&[]);
    assert!(!noise.marked && noise.windows.len() >= 20);
    let row = |name: &str| noise.rows.iter().find(|row| row.channel.name() == name).unwrap();
    // What the simulated instruments add: thesis Tables 4.15-4.16 (yaw rate 6.15e-4) and the recorder's step over the root of 12.
    let truth = [
        ("ax", 3.07e-2),
        ("az", 1.46e-2),
        ("p", 6.22e-4),
        ("q", 1.20e-3),
        ("r", 6.15e-4),
        ("v_north", 1.86e-2),
        ("v_east", 1.70e-2),
        ("v_down", 5.82e-3),
        ("phi", 6.25e-4),
        ("theta", 3.52e-4),
        ("psi", 2.32e-4),
        ("airspeed", 5.14e-2),
    ];
    for (name, sigma) in truth {
        let found = row(name).statistics.unwrap();
        let expected = f64::hypot(sigma, found.resolution / 12f64.sqrt());
        println!("{name}: {:.3e} for {expected:.3e}", found.std);
        // A standard deviation over 600 samples scatters by 3 %, doubled where the samples are few; in flight what is left of
        // the aircraft's own motion in the gusts adds up to a fifth.
        assert!((0.9..1.2).contains(&(found.std / expected)), "{name}: {found:?} for {expected}");
        assert!(row(name).is_measured());
    }
    assert!(row("x").statistics.is_none() && !row("x").is_measured());
}

#[test]
fn airspeed_without_a_flow_vane_has_gusts_along_the_path_as_noise() {
    let row_of = |loaded: &LoadedFlight| {
        let flight = NoiseFlight { name: "FT1", loaded, proposals: proposals() };
        let noise = stage::noise(&[flight], &[]).remove(0);
        let row = noise.rows.into_iter().find(|row| row.channel.name() == "airspeed").unwrap();
        row.choice
    };
    let mut loaded = recorded().clone();
    let index = loaded.recording.roles[&Role::TrueAirspeed];
    let airspeed = loaded.recording.channels[index].series.clone();
    // Three sines of different periods: deviation 1.5 m/s.
    let gust =
        |time_s: f64| [1.1, 1.9, 3.1].iter().map(|rate| (rate * time_s).sin()).sum::<f64>() * 1.5 / 1.5_f64.sqrt();
    let gusty = airspeed.time_s.iter().zip(&*airspeed.values).map(|(time_s, value)| value + gust(*time_s));
    loaded.recording.channels[index].series.values = gusty.collect();
    let is_gusts = |loaded: &LoadedFlight| row_of(loaded).is_ok_and(|choice| choice.origin == NoiseOrigin::Gusts);
    let without_vane = |loaded: &mut LoadedFlight| loaded.recording.roles.remove(&Role::Sideslip);
    let mut stated = loaded.clone();
    without_vane(&mut stated);
    assert!(!is_gusts(&stated), "what the instruments file states counts");
    loaded.stated_noise.clear();
    assert!(!is_gusts(&loaded), "both vanes are recorded");
    without_vane(&mut loaded);
    let choice = row_of(&loaded).unwrap();
    assert_eq!(choice.origin, NoiseOrigin::Gusts);
    assert!((2.7..3.6).contains(&choice.proposed), "twice the gusts: {}", choice.proposed);
}

#[test]
fn marked_windows_and_reasons_come_before_what_is_found() {
    let steady = SteadyWindow {
        flight: "FT1".into(),
        window: TimeRange { start_s: 928.0, end_s: 938.0 },
        roles: vec![Role::PitchRate],
    };
    let edit = NoiseEdit::Steady { flight: "FT1".into(), windows: vec![steady] };
    let session = Edit::Noise(edit).apply(&demo().session).unwrap();
    let noise = noise_of(&session.steady);
    assert!(noise.marked);
    let measured: Vec<_> = noise.rows.iter().filter(|row| row.statistics.is_some()).collect();
    assert_eq!(measured.len(), 1);
    assert_eq!(measured[0].statistics.unwrap().samples, 501);
    // An entry set for a reason stays when the rest is taken.
    let pitch = NoiseChannel::Input(Input::PitchRate);
    let entry = NoiseEntry { channel: pitch, std: 4e-3 };
    let reason = "engine vibration".to_owned();
    let set = Edit::Noise(NoiseEdit::Set { entries: vec![entry], reason }).apply(&session).unwrap();
    assert_eq!((pitch.std(&set), set.noise_reasons["q"].as_str()), (4e-3, "engine vibration"));
    assert!(stage::open_entries(&set, &noise).is_empty());
    let back = session::parse(&session::print(&set).unwrap()).unwrap();
    assert_eq!(back, set);
    let open = stage::open_entries(&session, &noise);
    let taken = Edit::Noise(NoiseEdit::Set { entries: open, reason: String::new() }).apply(&set).unwrap();
    assert_eq!(Some(pitch.std(&taken)), measured[0].proposed());
    assert!(taken.noise_reasons.is_empty());
    let alpha = Measurement::AngleOfAttack;
    assert_eq!(taken.filter.measurement_noise[alpha as usize], demo().session.filter.measurement_noise[alpha as usize]);
    assert_eq!(proposals().windows[0].manoeuvre.surface, Some(Surface::Aileron));
}

fn expression(name: &str, unit: &str, text: &str, role: Option<Role>) -> ExpressionSetting {
    ExpressionSetting { name: name.to_owned(), unit: unit.to_owned(), expression: text.to_owned(), role }
}

/// The last channel that these expressions make of the shipped flight.
fn made_of(expressions: &[ExpressionSetting]) -> Result<(LoadedFlight, Series), String> {
    let flight = stage::add_expressions(&bus(SignalSetting::default(), 0.0), expressions)?;
    let last = flight.expressions.last().map(|made| flight.recording.channels[made.channel].series.clone());
    Ok((flight, last.unwrap()))
}

#[test]
fn expressions_are_evaluated_sample_by_sample_on_the_stamps_of_the_first_channel() {
    let plain = bus(SignalSetting::default(), 0.0);
    let of = |role| plain.recording.role(role).unwrap().series.clone();
    // One time base: the two components of the velocity.
    let speed = expression("ground speed", "m/s", "sqrt(v_north^2 + v_east^2)", None);
    let (flight, found) = made_of(std::slice::from_ref(&speed)).unwrap();
    let (north, east) = (of(Role::VelocityNorth), of(Role::VelocityEast));
    assert_eq!(north.time_s, east.time_s);
    assert_eq!(found.time_s, north.time_s);
    for ((found, north), east) in found.values.iter().zip(&*north.values).zip(&*east.values) {
        assert!((found - north.hypot(*east)).abs() < 1e-12, "{found}");
    }
    let channel = flight.recording.channels.last().unwrap();
    assert_eq!(
        (channel.source.as_str(), channel.name.as_str(), channel.unit.as_str()),
        ("expression", "ground speed", "m/s")
    );
    // Two time bases: the airspeed enters at the stamps of the roll rate by straight lines, one expression in another.
    let (rate, airspeed) = (of(Role::RollRate), of(Role::TrueAirspeed));
    assert_ne!(rate.time_s, airspeed.time_s);
    let lifted = expression("rate", "deg/s", "180 / pi * p", None);
    let both = expression("both", "-", "\"expression/rate\" * 0 + airspeed", None);
    let (_, found) = made_of(&[speed, lifted, both]).unwrap();
    assert_eq!(found.time_s, rate.time_s);
    let inside = TimeRange { start_s: 1055.0, end_s: 1070.0 }.indices(&rate.time_s);
    let expected =
        resample(&airspeed.time_s, &airspeed.values, &rate.time_s[inside.clone()], Interpolation::Linear).unwrap();
    assert!(expected.len() > 700);
    for (found, expected) in found.values[inside].iter().zip(expected) {
        assert!((found - expected).abs() < 1e-12, "{found} for {expected}");
    }
}

#[test]
fn an_expression_has_no_values_in_the_gaps_of_what_it_names() {
    let mut plain = bus(SignalSetting::default(), 0.0);
    // Five seconds without an airspeed.
    let place = plain.recording.roles[&Role::TrueAirspeed];
    let airspeed = &mut plain.recording.channels[place].series;
    let kept = |t: &f64| !(1060.0..1065.0).contains(t);
    let pairs = airspeed.time_s.iter().zip(&*airspeed.values).filter(|(t, _)| kept(t));
    let (time, values): (Vec<f64>, Vec<f64>) = pairs.map(|(t, value)| (*t, *value)).unzip();
    let before = time[time.partition_point(|t| *t < 1060.0) - 1];
    let after = time[time.partition_point(|t| *t < 1065.0)];
    *airspeed = Series { time_s: time.into(), values: values.into() };
    let torn = stage::add_expressions(&plain, &[expression("torn", "-", "q * 0 + airspeed", None)]).unwrap();
    let found = torn.recording.channels.last().unwrap().series.clone();
    let near = TimeRange { start_s: 1055.0, end_s: 1070.0 }.indices(&found.time_s);
    let (mut inside, mut outside) = (0, 0);
    for (t, value) in found.time_s[near.clone()].iter().zip(&found.values[near]) {
        let gap = *t > before && *t < after;
        assert_eq!(value.is_nan(), gap, "{value} at {t}");
        *(if gap { &mut inside } else { &mut outside }) += 1;
    }
    assert!(inside > 240 && outside > 480, "{inside} {outside}");
}

#[test]
fn an_expression_takes_its_role_in_si_and_its_preview_is_of_what_was_there_before() {
    let plain = bus(SignalSetting::default(), 0.0);
    let recorded = plain.recording.role(Role::TrueAirspeed).unwrap().clone();
    let corrected = expression("corrected", "km/h", "1.05 * 3.6 * airspeed + 1", Some(Role::TrueAirspeed));
    let (flight, found) = made_of(std::slice::from_ref(&corrected)).unwrap();
    let playing = flight.recording.role(Role::TrueAirspeed).unwrap();
    assert_eq!((playing.source.as_str(), playing.unit.as_str()), ("expression", "m/s"));
    assert!(
        flight
            .recording
            .warnings
            .iter()
            .any(|line| line.to_string().starts_with("airspeed is the expression 'corrected', not "))
    );
    for (found, recorded) in found.values.iter().zip(&*recorded.series.values) {
        assert!((found - 1.05 * recorded - 1.0 / 3.6).abs() < 1e-12, "{found} for {recorded}");
    }
    let first = recorded.series.values.iter().find(|value| value.is_finite()).unwrap();
    let shown = stage::expression_preview(&flight, Some("corrected"), &corrected).unwrap().unwrap();
    assert!((shown - (1.05 * 3.6 * first + 1.0)).abs() < 1e-10, "{shown}: not corrected twice");
    let beside = stage::expression_preview(&flight, None, &expression("x", "m/s", "airspeed", None)).unwrap().unwrap();
    assert!((beside - (1.05 * first + 1.0 / 3.6)).abs() < 1e-12);
}

#[test]
fn an_expression_that_names_what_is_not_there_says_what_is_near() {
    let line = |text: &str| made_of(&[expression("a", "-", text, None)]).unwrap_err();
    assert!(
        line("q + {navigaton/v_n}").starts_with("expression 'a': at character 5: no channel is called 'navigaton/v_n'")
    );
    assert!(line("mach").starts_with("expression 'a': at character 1: mach is not recorded"));
    assert!(line("{expression/a}").contains("no channel is called 'expression/a'"), "it cannot hang on itself");
    let name = &bus(SignalSetting::default(), 0.0).recording.role(Role::PitchRate).unwrap().clone();
    let full = format!("{{{}/{}}}", name.source, name.name);
    assert_eq!(made_of(&[expression("a", "rad/s", &full, None)]).unwrap().1, name.series);
    assert!(
        line(&format!("{{{}/{}x}}", name.source, name.name))
            .contains(&format!("did you mean {}/{}", name.source, name.name))
    );
}
