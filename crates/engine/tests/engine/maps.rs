//! Which shipped channel map a recording is taken for: by names, units and ranges, never by the number of columns alone.

use std::path::{Path, PathBuf};

use doublet_core::quantity::Role;
use doublet_engine::begin::{self, Inspected};
use doublet_engine::run::Control;

/// A shared recording beside the project; says so where it is not, and fails where it must be.
fn shared(relative: &str) -> Option<PathBuf> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data").join(relative);
    if path.exists() {
        return Some(path);
    }
    assert!(std::env::var_os("CI").is_none_or(|ci| ci != "true"), "{} is not here", path.display());
    println!("skipped: {} is not here", path.display());
    None
}

fn inspected(path: &Path) -> Inspected {
    begin::inspect(&[path.to_path_buf()], &Control::default(), &|_| {}).unwrap()
}

/// Columns of a matrix as a text file without names, looked at.
fn matrix(columns: &[Vec<f64>]) -> Inspected {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("m.csv");
    let row = |k: usize| columns.iter().map(|column| column[k].to_string()).collect::<Vec<_>>().join(",");
    let text: String = (0..columns[0].len()).map(|k| row(k) + "\n").collect();
    std::fs::write(&path, text).unwrap();
    inspected(&path)
}

/// Mean and amplitude of the 44 columns behind time, in the order and units of the reference recordings.
const COLUMNS: [(f64, f64); 44] = [
    (0.35, 0.5),
    (0.0, 0.2),
    (-9.8, 2.0),
    (0.0, 0.2),
    (-9.8, 2.0),
    (0.0, 5.0),
    (0.2, 5.0),
    (0.1, 3.0),
    (0.0, 10.0),
    (2.0, 4.0),
    (15.0, 3.0),
    (2.2, 1.5),
    (-0.3, 1.0),
    (130.0, 2.0),
    (16000.0, 50.0),
    (0.0, 10.0),
    (0.0, 10.0),
    (0.0, 5.0),
    (2517.0, 0.0),
    (196.0, 2.0),
    (2.0, 2.0),
    (-0.4, 0.1),
    (83.0, 0.2),
    (83.0, 0.2),
    (-0.72, 0.02),
    (-0.92, 0.02),
    (-0.2, -4.0),
    (0.5, 4.0),
    (0.5, 3.0),
    (0.4, 0.01),
    (263.0, 0.2),
    (550.0, 2.0),
    (0.73, 0.001),
    (53.0, 0.01),
    (10.7, 0.01),
    (9200.0, 50.0),
    (9200.0, 50.0),
    (503.0, 5.0),
    (0.0, 1.0),
    (0.0, 0.0),
    (2514.0, 0.0),
    (1.0, 0.0),
    (0.02, 0.01),
    (0.17, 0.01),
];

/// 20 s at 25 Hz of a matrix like the reference recordings.
fn like_attas() -> Vec<Vec<f64>> {
    let time = |k: i32| 0.04 * f64::from(k);
    let column = |&(mean, amplitude): &(f64, f64)| (0..500).map(|k| mean + amplitude * time(k).sin()).collect();
    std::iter::once((0..500).map(time).collect()).chain(COLUMNS.iter().map(column)).collect()
}

fn is_taken_for_attas(found: &Inspected) -> bool {
    found.fitting.iter().any(|map| map.name == "attas")
}

/// What speaks against the map of ATTAS.
fn against(found: &Inspected) -> String {
    assert!(!is_taken_for_attas(found));
    found.refused.iter().find(|(name, _)| *name == "attas").map(|(_, lines)| lines.join("\n")).unwrap_or_default()
}

/// The columns with those of these numbers multiplied.
fn scaled(columns: &[Vec<f64>], which: &[usize], factor: f64) -> Vec<Vec<f64>> {
    let mut columns = columns.to_vec();
    which.iter().for_each(|&index| columns[index].iter_mut().for_each(|value| *value *= factor));
    columns
}

/// Refuses what is not a recording of ATTAS in its units, given the columns of one that is.
fn refuses_other_matrices(columns: &[Vec<f64>]) {
    assert!(is_taken_for_attas(&matrix(columns)), "{}", against(&matrix(columns)));
    let mut shifted = columns.to_vec();
    shifted[1..].rotate_right(1);
    assert!(against(&matrix(&shifted)).contains("of the map"));
    let degrees = [6, 7, 8, 9, 10, 11, 12, 13, 21, 22, 28, 29, 30];
    let radians = against(&matrix(&scaled(columns, &degrees, 1.0_f64.to_radians())));
    assert!(radians.contains("alpha") && radians.contains("deg"), "{radians}");
    let metres = against(&matrix(&scaled(columns, &[15], 0.3048)));
    assert!(metres.lines().count() == 1 && metres.starts_with("altitude (") && metres.contains("ft"), "{metres}");
    let reversed = against(&matrix(&scaled(columns, &[3], -1.0)));
    assert!(reversed.starts_with("az (") && reversed.contains("-14 to -7 m/s"), "{reversed}");
}

#[test]
fn matrix_of_45_columns_is_attas_only_with_its_values() {
    let columns = like_attas();
    refuses_other_matrices(&columns);
    let random: Vec<Vec<f64>> = (0..45)
        .map(|column| {
            (0..500)
                .map(|k| {
                    if column == 0 {
                        f64::from(k)
                    } else {
                        f64::from((k * 7919 + column * 104_729) % 1000) / 500.0 - 1.0
                    }
                })
                .collect()
        })
        .collect();
    assert!(against(&matrix(&random)).lines().count() > 10);
}

#[test]
fn recordings_of_attas_are_taken_for_it_and_for_nothing_else() {
    let Some(folder) = shared("attas") else { return };
    for name in ["fAttasElv1.mat", "fAttasAil1.mat", "fAttasRud1.mat"] {
        let found = inspected(&folder.join(name));
        assert_eq!(found.fitting[0].name, "attas", "{:?}", found.refused);
        assert_eq!(found.fitting[0].aircraft.as_deref(), Some("builtin:attas_vfw614"));
        let channels = &found.probes[0].sources[0].channels;
        let columns: Vec<Vec<f64>> = channels.iter().map(|channel| channel.values().to_vec()).collect();
        assert_eq!(columns.len(), 45);
        refuses_other_matrices(&columns);
    }
}

#[test]
fn every_reference_recording_keeps_its_map() {
    for (path, map, aircraft) in [
        ("citation_simulated/da3211_1.mat", "citation_simulated_clean", Some("builtin:citation_550_simulated")),
        ("citation_simulated/de3211_1.mat", "citation_simulated_clean", Some("builtin:citation_550_simulated")),
        ("citation_simulated/dr3211_1.mat", "citation_simulated_clean", Some("builtin:citation_550_simulated")),
        (
            "citation_simulated/da3211_1_noisy_with_truth.mat",
            "citation_simulated_truth",
            Some("builtin:citation_550_simulated"),
        ),
        ("phlab_citation", "phlab_citation", Some("builtin:citation_phlab")),
        ("uav_oat/ProcessedData_2022_05_07_11_13_57.mat", "uav_oat", None),
    ] {
        let Some(path) = shared(path) else { return };
        let found = inspected(&path);
        let best = found.fitting.first().unwrap_or_else(|| panic!("{}: {:?}", path.display(), found.refused));
        assert_eq!((best.name, best.aircraft.as_deref()), (map, aircraft), "{}", path.display());
    }
}

/// First value that the guess of a text reads for a role, in the unit of its channel, and that unit.
fn first(text: &str, role: Role) -> Option<(f64, &'static str)> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("mine.csv");
    std::fs::write(&path, text).unwrap();
    let found = inspected(&path);
    let values = found.guess.row(role)?.values(&found.probes)?;
    Some((values.first, values.unit.symbol))
}

#[test]
fn local_axes_of_xplane_are_east_up_and_south() {
    let text = "_totl,_time |____X,____m |____Y,____m |____Z,____m |\n\
        0.0 |1.0 |20.0 |300.0 |\n1.0 |2.0 |21.0 |310.0 |\n2.0 |3.0 |22.0 |320.0 |\n";
    assert_eq!(first(text, Role::PositionNorth), Some((-300.0, "m")));
    assert_eq!(first(text, Role::PositionEast), Some((1.0, "m")));
    assert_eq!(first(text, Role::PositionDown), Some((-20.0, "m")));
}

#[test]
fn fixes_sent_as_whole_numbers_are_scaled() {
    let text = "t,lat,lon,alt\n0,423600000,-710900000,4944\n1,423600010,-710900010,4950\n2,423600020,-710900020,4960\n";
    let latitude = first(text, Role::Latitude).unwrap();
    assert!((latitude.0 - 42.36).abs() < 1e-9 && latitude.1 == "deg", "{latitude:?}");
    assert_eq!(first(text, Role::Altitude), Some((4944.0, "mm")));
    let stated = "t,lat_deg,lon_deg,alt_ft\n0,42,-71,4944\n1,42,-71,4950\n";
    assert_eq!(first(stated, Role::Altitude), Some((4944.0, "ft")));
}

#[test]
fn one_aileron_of_a_pair_is_the_right_one_or_the_left_one_turned() {
    let pair = "t,/fcs/left-aileron-pos-deg,/fcs/right-aileron-pos-deg\n0,3,-3\n1,4,-4\n2,3,-3\n";
    assert_eq!(first(pair, Role::Aileron), Some((-3.0, "deg")));
    let left = "t,aileron left [deg],elevator\n0,3,1\n1,4,1\n2,3,1\n";
    assert_eq!(first(left, Role::Aileron), Some((-3.0, "deg")));
    let both = "t,aileron,AileronRight\n0,3,1\n1,4,1\n2,3,1\n";
    assert_eq!(first(both, Role::Aileron).map(|(value, _)| value), Some(3.0));
}

#[test]
fn unit_that_no_channel_states_is_the_one_that_the_motion_tells() {
    let Some(path) = shared("formats/jsbsim_csv/c172p_doublet.csv") else { return };
    let found = inspected(&path);
    for role in [Role::SpecificForceX, Role::SpecificForceY, Role::SpecificForceZ] {
        assert_eq!(found.guess.row(role).unwrap().unit.unwrap().symbol, "ft/s^2", "{}", role.name());
    }
    // Of its latitudes the geodetic one, of its ailerons the right one.
    let channel = |role| found.guess.row(role).unwrap().from.channel.as_str();
    assert_eq!(channel(Role::Latitude), "Latitude Geodetic");
    assert_eq!(channel(Role::Aileron), "/fdm/jsbsim/fcs/right-aileron-pos-deg");
    let plan = begin::plan_by_hand(&found.probes, &found.guess).unwrap();
    let physics = begin::compare(&plan).unwrap();
    let against: Vec<_> = physics.contradictions().map(|row| row.headline.to_string()).collect();
    assert!(against.is_empty(), "{against:?}");
}

/// A flight of 200 s at 60 m/s with a weave and climbs, as a table whose columns besides are made of speed, pitch and time.
fn weave(head: &str, columns: impl Fn(f64, f64, f64) -> Vec<f64>) -> String {
    let (mut heading, mut height) = (0.7_f64, 1000.0_f64);
    let mut text =
        format!("t [s],phi [deg],psi [deg],v_north [m/s],v_east [m/s],v_down [m/s],altitude [m],alpha [deg],{head}\n");
    for k in 0..5000 {
        let t = 0.04 * f64::from(k);
        let (bank, climb) = (0.35 * (0.21 * t).sin(), 0.06 * (0.37 * t).sin());
        let speed = 60.0 + 4.0 * (0.05 * t).sin();
        heading += 0.04 * 9.806_65 / speed * f64::tan(bank);
        let velocity = [speed * climb.cos() * heading.cos(), speed * climb.cos() * heading.sin(), -speed * climb.sin()];
        height -= 0.04 * velocity[2];
        let cells = [t, bank.to_degrees(), heading.to_degrees().rem_euclid(360.0)];
        let own = columns(speed, climb.to_degrees() + 3.0, t);
        let row = cells.into_iter().chain(velocity).chain([height, 3.0]).chain(own);
        text += &(row.map(|cell| format!("{cell:.4}")).collect::<Vec<_>>().join(",") + "\n");
    }
    text
}

#[test]
fn of_two_sensors_the_one_that_the_motion_agrees_with_is_used() {
    let channel = |text: &str, role: Role| {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("mine.csv");
        std::fs::write(&path, text).unwrap();
        let found = inspected(&path);
        let out = found.guess.left_out.iter().map(|(from, _)| from.channel.clone()).collect::<Vec<_>>();
        (found.guess.row(role).unwrap().from.channel.clone(), out)
    };
    let noise = |t: f64| 0.05 * (37.0 * t).sin();
    let small = weave("ADC1 TAS [m/s],ADC2 TAS [m/s],theta [deg]", |v, theta, t| vec![0.75 * v, v + noise(t), theta]);
    assert_eq!(channel(&small, Role::TrueAirspeed), ("ADC2 TAS".to_owned(), vec!["ADC1 TAS".to_owned()]));
    let sound = weave("ADC1 TAS [m/s],ADC2 TAS [m/s],theta [deg]", |v, theta, t| vec![v, v + noise(t), theta]);
    assert_eq!(channel(&sound, Role::TrueAirspeed), ("ADC1 TAS".to_owned(), Vec::new()));
}
