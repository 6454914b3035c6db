//! Attitude as a quaternion, velocity as ground speed and track, axes up: read by a guess of their names, and compared with the flight
//! that they are recordings of.

use std::collections::BTreeMap;

use doublet_core::load::{ChannelMap, guess, inspect, plan, read};
use doublet_core::quantity::Role;
use doublet_core::reconstruct::{
    FilterData, FilterSettings, Input, InputSeries, Measurement, MeasurementSeries, Reconstruction, State, reconstruct,
};
use doublet_core::series::Recording;

use super::written;
use crate::shared::shared;

/// The recording as a guess reads it.
fn read_by_guess(path: &std::path::Path) -> Recording {
    let probe = inspect(path).unwrap();
    let map = ChannelMap::parse(&guess(std::slice::from_ref(&probe)).text().unwrap()).unwrap();
    let plan = plan(&probe, &map);
    assert!(!plan.has_errors(), "{:?}", plan.problems);
    read(&plan).unwrap()
}

/// Columns of the known flight, SI, by name.
fn truth() -> Option<BTreeMap<String, Vec<f64>>> {
    let text = std::fs::read_to_string(shared("data/formats/truth/flight_100hz.csv")?).unwrap();
    let mut lines = text.lines();
    let names: Vec<String> = lines.next().unwrap().split(',').map(str::to_owned).collect();
    let mut columns: BTreeMap<String, Vec<f64>> = BTreeMap::new();
    for line in lines {
        for (name, cell) in names.iter().zip(line.split(',')) {
            columns.entry(name.clone()).or_default().push(cell.parse().unwrap());
        }
    }
    Some(columns)
}

/// Name of a role's column in the known flight.
fn column(role: Role) -> &'static str {
    match role {
        Role::SpecificForceX => "ax_m_s2",
        Role::SpecificForceY => "ay_m_s2",
        Role::SpecificForceZ => "az_m_s2",
        Role::RollRate => "p_rad_s",
        Role::PitchRate => "q_rad_s",
        Role::YawRate => "r_rad_s",
        Role::BankAngle => "phi_rad",
        Role::PitchAngle => "theta_rad",
        Role::HeadingAngle => "psi_rad",
        Role::PositionNorth => "x_m",
        Role::PositionEast => "y_m",
        Role::PositionDown => "z_m",
        Role::VelocityNorth => "v_north_m_s",
        Role::VelocityEast => "v_east_m_s",
        Role::VelocityDown => "v_down_m_s",
        other => panic!("{} is not compared", other.name()),
    }
}

/// Largest difference of a role from the truth, and the truth's range.
fn worst(recording: &Recording, role: Role, truth: &BTreeMap<String, Vec<f64>>) -> (f64, f64) {
    let channel = recording.role(role).unwrap_or_else(|| panic!("no {}", role.name()));
    let column = &truth[column(role)];
    let turn = |difference: f64| match role {
        Role::HeadingAngle => difference.sin(),
        _ => difference,
    };
    let series = &channel.series;
    let finite = series.time_s.iter().zip(&*series.values).filter(|(_, value)| value.is_finite());
    let differences = finite.map(|(time_s, value)| turn(value - column[(100.0 * time_s).round() as usize]).abs());
    let range =
        column.iter().copied().fold(f64::NEG_INFINITY, f64::max) - column.iter().copied().fold(f64::INFINITY, f64::min);
    (differences.fold(0.0, f64::max), range)
}

#[test]
fn attitude_velocity_and_position_in_other_forms_are_those_of_the_flight() {
    let Some(truth) = truth() else { return };
    let attitude = [Role::BankAngle, Role::PitchAngle, Role::HeadingAngle];
    let rates = [Role::RollRate, Role::PitchRate, Role::YawRate];
    let forces = [Role::SpecificForceX, Role::SpecificForceY, Role::SpecificForceZ];
    let velocity = [Role::VelocityNorth, Role::VelocityEast, Role::VelocityDown];
    let position = [Role::PositionNorth, Role::PositionEast, Role::PositionDown];
    for (file, roles) in [
        ("generic_csv/15_lat_lon_alt_track.csv", [velocity, position, rates].concat()),
        ("generic_csv/16_quaternion.csv", [attitude, rates, forces].concat()),
        ("tdms/groups_waveform.tdms", [attitude, rates, forces].concat()),
        ("mcap/ros2_cdr_imu_odometry.mcap", [attitude, rates, forces].concat()),
        ("mcap/json_lz4.mcap", [rates, forces].concat()),
    ] {
        let recording = read_by_guess(&shared("data/formats").unwrap().join(file));
        for role in roles {
            let (worst, range) = worst(&recording, role, &truth);
            assert!(worst < 2e-3 * range, "{file} {}: {worst} off in a range of {range}", role.name());
        }
    }
}

#[test]
fn attitude_and_velocity_are_mapped_or_derived_never_both() {
    let folder = shared("data/formats").unwrap();
    let mut files = 0;
    for format in std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).filter(|path| path.is_dir()) {
        for path in std::fs::read_dir(format).unwrap().map(|entry| entry.unwrap().path()) {
            let Ok(probe) = inspect(&path) else { continue };
            let Ok(text) = guess(std::slice::from_ref(&probe)).text() else { continue };
            let problems = plan(&probe, &ChannelMap::parse(&text).unwrap()).problems;
            assert!(problems.iter().all(|problem| !problem.text.contains("derived")), "{path:?}: {problems:?}");
            files += 1;
        }
    }
    assert!(files >= 20, "{files}");
}

/// The path of a recording by the filter as it is by default, over the time from its first sample on.
fn path(recording: &Recording) -> Reconstruction {
    let start_s = recording.role(Role::RollRate).unwrap().series.time_s[0];
    let of = |role: Role| {
        let series = &recording.role(role).unwrap_or_else(|| panic!("no {}", role.name())).series;
        (series.time_s.iter().map(|time_s| time_s - start_s).collect::<Vec<_>>(), series.values.to_vec())
    };
    let columns = Input::ALL.map(|input| of(input.role()).1.into());
    let measurements = Measurement::ALL.map(|measurement| {
        let (time_s, values) = of(measurement.role());
        MeasurementSeries { time_s: time_s.into(), values: values.into() }
    });
    let data = FilterData { inputs: InputSeries { time_s: of(Role::RollRate).0.into(), columns }, measurements };
    let settings = FilterSettings { smooth: true, ..FilterSettings::default() }.check().unwrap();
    reconstruct(&data, &settings, &mut |_| std::ops::ControlFlow::Continue(())).unwrap()
}

#[test]
fn tables_of_one_flight_in_twelve_forms_give_one_reconstruction() {
    let Some(folder) = shared("data/formats/generic_csv") else { return };
    let reference = path(&read_by_guess(&folder.join("05_units_row.csv")));
    let mut compared = 0;
    for file in [
        "01_ms_integer.csv",
        "02_us_integer.csv",
        "03_ns_since_1970.csv",
        "04_date_time_utcoffset.csv",
        "06_semicolon_decimal_comma.csv",
        "07_utf8_bom_degree_sign.csv",
        "08_utf16le_tab.txt",
        "09_two_header_lines.csv",
        "10_quoted_commas_in_names.csv",
        "18_time_of_day_over_midnight.csv",
        "23_gps_week_tow_ms.csv",
    ] {
        let found = path(&read_by_guess(&folder.join(file)));
        for state in State::ALL {
            let k = state as usize;
            // Of biases and wind, which are next to nothing here, the deviation is the measure.
            let size = reference.states[k].iter().zip(&reference.deviations[k]);
            let size = size.map(|(value, deviation)| value.abs().max(deviation)).fold(0.0, f64::max);
            let apart = found.states[k].iter().zip(&reference.states[k]).map(|(a, b)| (a - b).abs());
            let apart = apart.fold(0.0, f64::max) / size;
            assert!(apart < 1e-6, "{file}: {} {apart:.1e}", state.name());
        }
        assert_eq!(found.states[0].len(), reference.states[0].len());
        compared += 1;
    }
    assert_eq!(compared, 11);
}

#[test]
fn speed_and_track_of_two_clocks_are_refused_by_name() {
    let text = "t,gs,course\n0,50,90\n1,50,90\n2,50,90\n";
    let (_folder, path) = written("slow.csv", text);
    let recording = read_by_guess(&path);
    let east = recording.role(Role::VelocityEast).unwrap();
    assert!(east.series.values.iter().all(|value| (value - 50.0).abs() < 1e-9), "{:?}", east.series.values);
    let map = "format = \"doublet channel map\"\nversion = 1\nname = \"two\"\n[derive.velocity]\n\
               ground_speed = { source = \"slow\", channel = \"gs\", unit = \"m/s\" }\n\
               track = { source = \"fast\", channel = \"course\", unit = \"deg\" }\n";
    let (_folder, other) = written("fast.csv", text);
    let probes = [inspect(&path).unwrap(), inspect(&other).unwrap()];
    let plan = doublet_core::load::plan_all(&probes, &ChannelMap::parse(map).unwrap());
    let told = plan.problems.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n");
    assert!(
        told.contains("[derive.velocity] track: its clock is not that of [derive.velocity] ground_speed"),
        "{told}"
    );
}

#[test]
fn maps_that_derive_attitude_say_what_is_wrong_with_their_axes() {
    let map = "format = \"doublet channel map\"\nversion = 1\nname = \"two\"\n[derive.attitude]\n\
               quaternion = [\"a\", \"b\", \"c\", \"d\"]\naxes = \"nwu\"\n";
    let refused = ChannelMap::parse(map).unwrap_err().to_string();
    assert!(refused.contains("line 6") && refused.contains("use \"ned\" or \"enu\""), "{refused}");
}
