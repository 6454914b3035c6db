//! Whole flights: truth found again, recordings against truth, the shipped demo.

use std::path::Path;
use std::sync::OnceLock;

use doublet_core::airframe::frames;
use doublet_core::estimate::least_squares;
use doublet_core::load::{self, ChannelMap};
use doublet_core::model::{Coefficient, Term, Variable};
use doublet_core::quantity::Role;
use doublet_core::simulate::{
    Flight, InputKind, RecordedFile, Scenario, SimulateError, Stream, Surface, run, scenario,
};
use nalgebra::{DMatrix, Vector3};

/// Seed of the shipped demo.
const DEMO_SEED: u64 = 1;
/// Largest size of the shipped demo, bytes.
const DEMO_LIMIT: usize = 12_000_000;
/// Derivatives found again from noise-free coefficients, relative.
const RECOVERY: f64 = 1e-3;

fn fly(scenario: &Scenario, seed: u64) -> Flight {
    run(scenario, seed, &mut |_| true).unwrap()
}

/// The short flight with perfect instruments.
fn exact_flight() -> &'static Flight {
    static FLIGHT: OnceLock<Flight> = OnceLock::new();
    FLIGHT.get_or_init(|| {
        let mut scenario = scenario::build("test-point").unwrap();
        scenario.exact_instruments = true;
        fly(&scenario, 5)
    })
}

fn demo() -> &'static (Flight, Vec<RecordedFile>) {
    static DEMO: OnceLock<(Flight, Vec<RecordedFile>)> = OnceLock::new();
    DEMO.get_or_init(|| {
        let flight = fly(&scenario::build("demo").unwrap(), DEMO_SEED);
        let files = flight.files().unwrap();
        (flight, files)
    })
}

fn column<'a>(flight: &'a Flight, name: &str) -> &'a [f32] {
    flight.truth.column(name).unwrap()
}

/// Value of a true history at a time, linear between samples.
fn truth_at(flight: &Flight, name: &str, time_s: f64) -> f64 {
    let time = &flight.truth.time_s;
    let after = time.partition_point(|&t| t < time_s).clamp(1, time.len() - 1);
    let values = column(flight, name);
    let (from, to) = (f64::from(values[after - 1]), f64::from(values[after]));
    from + (to - from) * (time_s - time[after - 1]) / (time[after] - time[after - 1])
}

#[test]
fn least_squares_on_simulated_coefficients_recovers_truth_derivatives() {
    let flight = exact_flight();
    let reference = *flight.scenario.vehicle.reference();
    let samples = flight.truth.time_s.len();
    let value = |variable: Variable, k: usize| {
        let of = |name: &str| f64::from(column(flight, name)[k]);
        let lateral = reference.lateral_rate_length_m / of("airspeed");
        match variable {
            Variable::Alpha => of("alpha"),
            Variable::Beta => of("beta"),
            Variable::RollRate => of("p") * lateral,
            Variable::PitchRate => of("q") * reference.pitch_rate_length_m / of("airspeed"),
            Variable::YawRate => of("r") * lateral,
            Variable::Aileron => of("delta_a"),
            Variable::Elevator => of("delta_e"),
            Variable::Rudder => of("delta_r"),
            other => panic!("the truth does not depend on {}", other.name()),
        }
    };
    let derivatives = flight.scenario.vehicle.aero.derivatives();
    let mut found = 0;
    for coefficient in &Coefficient::ALL[..6] {
        let of_it: Vec<_> = derivatives.iter().filter(|derivative| derivative.coefficient == *coefficient).collect();
        let names: Vec<String> = of_it.iter().map(|derivative| derivative.name.clone()).collect();
        let terms: Vec<&Term> = of_it.iter().map(|derivative| &derivative.term).collect();
        let x = DMatrix::from_fn(samples, terms.len(), |k, j| terms[j].value(|variable| value(variable, k)));
        let z: Vec<f64> = column(flight, coefficient.name()).iter().map(|&c| f64::from(c)).collect();
        let fit = least_squares(&names, &x, &z).unwrap();
        for (derivative, estimate) in of_it.iter().zip(&fit.estimates) {
            let error = estimate / derivative.value - 1.0;
            println!("{:<12} {:9.4} {:+.1e}", derivative.name, derivative.value, error);
            assert!(error.abs() < RECOVERY, "{}: {estimate} for {}", derivative.name, derivative.value);
            found += 1;
        }
    }
    assert_eq!(found, derivatives.len());
}

#[test]
fn same_seed_gives_same_bytes_and_another_seed_does_not() {
    let mut scenario = scenario::build("test-point").unwrap();
    scenario.duration_s = 40.0;
    let files = |seed| fly(&scenario, seed).files().unwrap();
    assert_eq!(files(3), files(3));
    assert_ne!(files(3), files(4));
}

/// Source, channel and values, bit by bit, of an HDF5 file.
fn channels(bytes: &[u8]) -> Vec<(String, String, Vec<u64>)> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("flight.h5");
    std::fs::write(&path, bytes).unwrap();
    let mut probe = doublet_core::load::probe(&path).unwrap();
    probe.complete().unwrap();
    let bits = |values: &[f64]| values.iter().map(|value| value.to_bits()).collect::<Vec<_>>();
    let all: Vec<_> = probe
        .sources
        .iter()
        .flat_map(|source| source.channels.iter().map(|c| (source.name.clone(), c.name.clone(), bits(c.values()))))
        .collect();
    assert!(!all.is_empty());
    all
}

#[test]
fn shipped_demo_is_what_the_simulator_makes() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../assets/flights/demo");
    let (_, files) = demo();
    // DOUBLET_WRITE_DEMO=1 writes the demo instead of comparing it, for a change that is meant.
    if std::env::var_os("DOUBLET_WRITE_DEMO").is_some() {
        demo().0.write(&folder).unwrap();
    }
    let mut total = 0;
    for file in files {
        let shipped = std::fs::read(folder.join(&file.path)).unwrap();
        total += shipped.len();
        // Packed bytes depend on the compressor; what is in them does not.
        let same = match Path::new(&file.path).extension().is_some_and(|extension| extension == "h5") {
            true => channels(&shipped) == channels(&file.bytes),
            false => shipped == file.bytes,
        };
        assert!(same, "{} differs from what the simulator makes", file.path);
    }
    assert_eq!(std::fs::read_dir(&folder).unwrap().count(), files.len());
    println!("{total} bytes");
    assert!(total < DEMO_LIMIT);
}

#[test]
fn demo_flies_the_manoeuvres_of_the_published_flight() {
    let (flight, _) = demo();
    let at_main_point: Vec<_> = flight.manoeuvres.iter().filter(|flown| flown.manoeuvre.test_point == 1).collect();
    assert_eq!(at_main_point.len(), 23);
    assert_eq!(at_main_point.iter().filter(|flown| flown.manoeuvre.spoilt).count(), 1);
    assert_eq!(flight.manoeuvres.len(), 35);
    for flown in &flight.manoeuvres {
        let manoeuvre = &flown.manoeuvre;
        let label = format!("{} {} at {} s", manoeuvre.surface.name(), manoeuvre.kind.name(), manoeuvre.onset_s);
        let before = manoeuvre.onset_s - 0.1;
        let at = |name: &str, time_s: f64| truth_at(flight, name, time_s);
        // Run-in: controls still, wings nearly level, vertical speed within about 1 m/s (thesis section 4.4.1).
        for name in ["delta_a", "delta_e", "delta_r"] {
            assert!((at(name, before) - at(name, before - 2.0)).abs() < 1e-5, "{label}: {name} moves in the run-in");
        }
        assert!(at("phi", before).abs() < 0.05 && at("v_down", before).abs() < 1.3, "{label}: not steady");
        let (speed, altitude) = match manoeuvre.test_point {
            1 => (46.3, 1219.2),
            2 => (60.2, 1981.2),
            _ => (52.0, 762.0),
        };
        assert!((at("airspeed", before) - speed).abs() < 2.0, "{label}: {} m/s", at("airspeed", before));
        assert!((at("z", before) + altitude).abs() < 25.0, "{label}: {} m", -at("z", before));
    }
}

/// Stream of a flight by name.
fn stream<'a>(flight: &'a Flight, name: &str) -> &'a Stream {
    let all = flight.bus.iter().chain([&flight.pod]).chain(&flight.control_sensors);
    all.into_iter().find(|stream| stream.spec.name == name).unwrap()
}

/// Samples of a channel with the bus time each belongs to.
fn samples(stream: &Stream, channel: &str) -> Vec<(f64, f64)> {
    let index = stream.spec.channels.iter().position(|spec| spec.name == channel).unwrap();
    let stamps = stream.time_s.iter().map(|&own| stream.spec.clock.bus_s(own));
    stamps.zip(stream.values[index].iter().map(|&value| f64::from(value))).collect()
}

#[test]
fn exact_instruments_record_the_truth_on_their_own_clocks() {
    let flight = exact_flight();
    /// Interpolation between 100 Hz samples and single precision, rad.
    const ANGLE_RAD: f64 = 2e-4;
    /// The same, m/s.
    const SPEED_M_S: f64 = 1e-2;
    for (source, channel, truth, unit, tolerance) in [
        ("adahrs/inertial", "theta", "theta", 1f64.to_radians(), ANGLE_RAD),
        ("adahrs/inertial", "q", "q", 1f64.to_radians(), 1e-6),
        ("adahrs/air_data", "V_TAS", "airspeed", 1852.0 / 3600.0, 1e-4),
        ("navigation", "v_up", "v_down", -1852.0 / 3600.0, 1e-4),
        ("pod", "phi", "phi", 1f64.to_radians(), ANGLE_RAD),
        ("pod", "beta", "beta", 1f64.to_radians(), ANGLE_RAD),
    ] {
        let samples = samples(stream(flight, source), channel);
        assert!(samples.len() > 300);
        for (time_s, value) in samples {
            let error = (value * unit - truth_at(flight, truth, time_s)).abs();
            assert!(error < tolerance, "{source} {channel} at {time_s} s: {error:e}");
        }
    }
    // The monitor shares the load factor with the bus, each on its own clock.
    for (time_s, n) in samples(stream(flight, "engine_monitor"), "n") {
        let error = (n + truth_at(flight, "az", time_s) / 9.80665).abs();
        assert!(error < SPEED_M_S, "load factor at {time_s} s: {error}");
    }
}

#[test]
fn accelerometers_feel_their_lever_arm() {
    let flight = exact_flight();
    let body = flight.scenario.vehicle.body(&flight.scenario.loading).unwrap();
    let arm = Vector3::from(frames::body_from_datum([2.03, 0.20, 1.40], body.properties.cg_from_datum_m));
    /// Movement of the centre of gravity with the fuel burnt, and single precision, m/s².
    const TOLERANCE: f64 = 1e-3;
    let bus = stream(flight, "adahrs/inertial");
    let [ax, ay, az] = ["A_x", "A_y", "A_z"].map(|channel| samples(bus, channel));
    for k in 0..ax.len() {
        let of = |name: &str| truth_at(flight, name, ax[k].0);
        let vector = |names: [&str; 3]| Vector3::from(names.map(of));
        let (w, dw) = (vector(["p", "q", "r"]), vector(["p_dot", "q_dot", "r_dot"]));
        let expected = vector(["ax", "ay", "az"]) + dw.cross(&arm) + w.cross(&w.cross(&arm));
        let recorded = Vector3::new(ax[k].1, ay[k].1, az[k].1 - 1.0) * 9.80665;
        assert!((recorded - expected).norm() < TOLERANCE, "at {} s: {recorded} for {expected}", ax[k].0);
    }
}

/// Rotation about the sensor's z from its Euler angles: thesis Eq. 4.3 by central differences, then trapezoids; deg.
fn rotation_deg(angles: [&[(f64, f64)]; 3]) -> Vec<(f64, f64)> {
    let rad = |axis: usize, k: usize| angles[axis][k].1.to_radians();
    let wrapped = |d: f64| (d + std::f64::consts::PI).rem_euclid(std::f64::consts::TAU) - std::f64::consts::PI;
    let rate = |k: usize| {
        let dt = angles[0][k + 1].0 - angles[0][k - 1].0;
        let theta_dot = wrapped(rad(1, k + 1) - rad(1, k - 1)) / dt;
        let psi_dot = wrapped(rad(2, k + 1) - rad(2, k - 1)) / dt;
        -rad(0, k).sin() * theta_dot + rad(0, k).cos() * psi_dot * rad(1, k).cos()
    };
    let mut sum = 0.0;
    let mut out = vec![(angles[0][1].0, 0.0)];
    for k in 2..angles[0].len() - 1 {
        sum += 0.5 * (rate(k) + rate(k - 1)) * (angles[0][k].0 - angles[0][k - 1].0);
        out.push((angles[0][k].0, sum.to_degrees()));
    }
    out
}

#[test]
fn deflections_come_back_from_the_raw_attitudes_of_the_control_sensors() {
    let flight = exact_flight();
    /// Second-order differences at 60 Hz, and pitch and roll that a tilted pulley feels, deg.
    const DEFLECTION_DEG: f64 = 0.15;
    let within = |sensor: &str, number: usize| {
        let (from, to) = flight.manoeuvres[number].manoeuvre.recorded_s();
        let all = ["phi", "theta", "psi"].map(|channel| samples(stream(flight, sensor), channel));
        let cut = all.map(|samples| samples.into_iter().filter(|(t, _)| (from..to).contains(t)).collect::<Vec<_>>());
        rotation_deg([&cut[0], &cut[1], &cut[2]])
    };
    let check = |name: &str, found: Vec<(f64, f64)>| {
        // Attitudes are 30 ms old when they are stamped.
        let truth = |time_s: f64| truth_at(flight, name, time_s - 0.03).to_degrees();
        let start = truth(found[0].0);
        let square: f64 = found.iter().map(|&(time_s, deg)| (deg - (truth(time_s) - start)).powi(2)).sum();
        let rms = (square / found.len() as f64).sqrt();
        println!("{name}: {rms:.4} deg rms over {} samples", found.len());
        assert!(rms < DEFLECTION_DEG, "{name}: {rms} deg");
    };
    let (yoke, panel) = (within("yoke", 0), within("panel", 0));
    check("delta_a", yoke.iter().zip(&panel).map(|(y, p)| (y.0, 0.162 * (y.1 - p.1))).collect());
    // Column: drum radius 12.45 mm, thesis slope 2.386 deg/cm, its geometry linearised about the start.
    let column = within("column", 3);
    check("delta_e", column.iter().map(|c| (c.0, 2.386 * 1.245 * c.1.to_radians() * 20.9 / 20.75)).collect());
    // Rudder by the published polynomial from the neutral start of the pedal.
    let pedal = within("right_pedal", 4);
    let polynomial = |s: f64| {
        [1.207e-1, -3.155e2, -1.098e3, -3.074e4, -8.065e4, 9.752e6].iter().rev().fold(0.0, |sum, a| sum * s + a)
    };
    let scaled = |d: f64| if d < 0.0 { 0.596 * d } else { d };
    let start = doublet_core::simulate::ControlLinkage::positions(&doublet_core::simulate::Controls {
        rudder: truth_at(flight, "delta_r", pedal[0].0),
        ..Default::default()
    });
    let zero = start.right_pedal_drum_rad;
    let rudder = |drum: f64| scaled(polynomial(drum * 0.01245));
    check("delta_r", pedal.iter().map(|c| (c.0, rudder(zero + c.1.to_radians()) - rudder(zero))).collect());
}

#[test]
fn run_refuses_an_input_past_the_stop_and_unknown_scenarios() {
    let mut scenario = scenario::build("test-point").unwrap();
    scenario.manoeuvres[2].amplitude_rad = 0.5;
    let error = run(&scenario, 1, &mut |_| true).unwrap_err();
    let SimulateError::PastStop { surface, past_deg, .. } = &error else { panic!("{error}") };
    assert!(*surface == "elevator" && *past_deg > 3.0, "{error}");
    let error = scenario::build("ft9").unwrap_err().to_string();
    assert!(error.contains("'ft9'") && error.contains("demo"), "{error}");
    let stopped = run(&scenario::build("test-point").unwrap(), 1, &mut |fraction| fraction < 0.1);
    assert!(matches!(stopped, Err(SimulateError::Cancelled { .. })));
}

#[test]
fn every_shape_and_the_multisine_fly_and_return() {
    let flight = fly(&scenario::build("inputs").unwrap(), 1);
    assert_eq!(flight.manoeuvres.len(), 7);
    let flight_of_all = fly(&scenario::build("multisine").unwrap(), 1);
    for flown in flight.manoeuvres.iter().chain(&flight_of_all.manoeuvres) {
        let onset = flown.manoeuvre.onset_s;
        let flight = if flown.manoeuvre.kind == InputKind::Multisine { &flight_of_all } else { &flight };
        for (surface, name) in Surface::ALL.into_iter().zip(["delta_a", "delta_e", "delta_r"]) {
            let held = truth_at(flight, name, onset - 1.0);
            let moved = |time_s: f64| truth_at(flight, name, time_s) - held;
            let input = flown.duration_s();
            let peak = (1..200).map(|k| moved(onset + input * f64::from(k) / 200.0).abs()).fold(0.0, f64::max);
            let wanted = flown.signal(surface).peak_rad();
            assert!((peak - wanted).abs() < 0.05 * flown.manoeuvre.amplitude_rad.abs(), "{name}: {peak} for {wanted}");
            assert!(moved((onset + input + 0.1).min(flown.manoeuvre.held_to_s() - 0.05)).abs() < 1e-6, "{name} stays");
        }
    }
}

#[test]
fn sweeps_move_the_controls_over_their_whole_length_and_stay_near_trim() {
    let flight = fly(&scenario::build("sweeps").unwrap(), 1);
    assert_eq!(flight.manoeuvres.len(), 4);
    for flown in &flight.manoeuvres {
        let (onset, name) =
            (flown.manoeuvre.onset_s, ["delta_a", "delta_e", "delta_r"][flown.manoeuvre.surface as usize]);
        assert!(flown.manoeuvre.kind.is_sweep() && flown.duration_s() == 60.0);
        let held = truth_at(&flight, name, onset - 1.0);
        for part in 0..6 {
            let moved =
                (0..1000).map(|k| truth_at(&flight, name, onset + 10.0 * f64::from(part) + 0.01 * f64::from(k)) - held);
            let reach = moved.fold(0.0, |reach: f64, moved| reach.max(moved.abs()));
            assert!((reach / flown.manoeuvre.amplitude_rad - 1.0).abs() < 0.05, "{name}, part {part}: {reach}");
        }
        let tilt = (0..600).map(|k| truth_at(&flight, "phi", onset + 0.1 * f64::from(k)).abs());
        assert!(tilt.fold(0.0, f64::max) < 0.6, "{name}");
    }
}

#[test]
fn hands_let_go_of_controls_and_take_them_over_in_their_own_time() {
    /// Twice the fastest of a half cosine over 0.1 rad in 0.5 s; a jump within one step of 0.01 s is ten times that.
    const FASTEST_RAD_S: f64 = 0.6;
    let flight = fly(&scenario::build("coverage").unwrap(), 1);
    let mut corrected: f64 = 0.0;
    for flown in &flight.manoeuvres {
        let moves = [flown.manoeuvre.held_from_s(), flown.manoeuvre.held_to_s()];
        for (name, moment) in ["delta_a", "delta_e", "delta_r"].into_iter().flat_map(|name| moves.map(|at| (name, at)))
        {
            for k in -10..45 {
                let time_s = moment + 0.01 * f64::from(k);
                let moved = truth_at(&flight, name, time_s + 0.01) - truth_at(&flight, name, time_s);
                assert!(moved.abs() < 0.01 * FASTEST_RAD_S, "{name} moves by {moved} rad at {time_s} s");
            }
            corrected = corrected.max((truth_at(&flight, name, moment + 0.5) - truth_at(&flight, name, moment)).abs());
        }
    }
    // There is something to correct.
    assert!(corrected > 0.03, "{corrected} rad");
}

#[test]
fn pod_falls_back_to_one_sample_a_second_when_asked() {
    let mut scenario = scenario::build("test-point-1hz").unwrap();
    scenario.duration_s = 20.0;
    let flight = fly(&scenario, 1);
    assert!((20..=22).contains(&flight.pod.time_s.len()), "{}", flight.pod.time_s.len());
}

#[test]
fn shipped_channel_map_reads_the_demo_in_si() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../assets/flights/demo");
    let map = ChannelMap::shipped().iter().find(|(name, _)| *name == "demo_flight").unwrap();
    let map = ChannelMap::parse(map.1).unwrap();
    let paths = ["bus.h5", "pod.csv", "truth.h5"].map(|file| folder.join(file));
    let recording = load::read_all(&paths, &map).unwrap();
    assert_eq!(recording.roles.len(), map.roles.len(), "{:?}", recording.warnings);
    let (flight, _) = demo();
    let onset = flight.manoeuvres[2].manoeuvre.onset_s;
    let near = |role: Role, time_s: f64| {
        let series = &recording.role(role).unwrap().series;
        series.values[series.time_s.partition_point(|&t| t < time_s)]
    };
    for (role, name, tolerance) in [
        // Five sigma of the noise of thesis Tables 4.15-4.16 with resolution, plus the bias.
        (Role::SpecificForceX, "ax", 0.25),
        (Role::SpecificForceZ, "az", 0.25),
        (Role::PitchRate, "q", 0.01),
        (Role::PitchAngle, "theta", 0.004),
        (Role::HeadingAngle, "psi", 0.004),
        (Role::TrueAirspeed, "airspeed", 0.5),
        (Role::VelocityDown, "v_down", 0.1),
    ] {
        let truth = truth_at(flight, name, onset);
        let error =
            (near(role, onset) - truth + std::f64::consts::PI).rem_euclid(std::f64::consts::TAU) - std::f64::consts::PI;
        assert!(error.abs() < tolerance, "{}: {error} off {truth}", role.name());
    }
    let bias = &recording.truth["bias_ax"];
    assert_eq!((bias.values.len(), bias.values[0]), (2, 0.030));
    let u = &recording.truth["u"];
    assert_eq!(u.values.len(), flight.truth.time_s.len());
}
