//! Recordings nobody here wrote: held samples, steady parts, noise and manoeuvres of theirs.

use std::path::Path;

use doublet_core::load::{ChannelMap, read_all};
use doublet_core::model::Coefficient;
use doublet_core::prep::held_samples;
use doublet_core::quantity::Role;
use doublet_core::series::{Recording, TimeRange};
use doublet_engine::session;
use doublet_engine::stage::{self, FlightProposals, LoadedFlight, NoiseFlight};
use doublet_engine::verdict::Level;

use crate::compute;
use crate::shared::shared;

/// A recording of the shared folder by a shipped map.
fn recording(paths: &[&str], map: &str) -> Option<Recording> {
    let paths: Vec<_> = paths.iter().map(|path| shared(&format!("data/{path}"))).collect::<Option<_>>()?;
    let (_, text) = ChannelMap::shipped().iter().find(|(name, _)| *name == map).unwrap();
    Some(read_all(&paths, &ChannelMap::parse(text).unwrap()).unwrap())
}

fn phlab() -> Option<Recording> {
    recording(&["phlab_citation"], "phlab_citation")
}

fn uav() -> Option<Recording> {
    recording(&["uav_oat/ProcessedData_2022_05_07_11_13_57.mat"], "uav_oat")
}

fn attas() -> Option<Recording> {
    recording(&["attas/fAttasElv1.mat", "attas/fAttasAil1.mat", "attas/fAttasRud1.mat"], "attas")
}

fn citation() -> Option<Recording> {
    let folder = "citation_simulated";
    let paths = ["da3211_1_noisy_with_truth.mat", "da3211_1.mat"].map(|name| format!("{folder}/{name}"));
    recording(&[&paths[0], &paths[1]], "citation_simulated_truth")
}

fn proposed(recording: Recording) -> (LoadedFlight, FlightProposals) {
    let loaded = LoadedFlight { recording, ..LoadedFlight::default() };
    let proposals = stage::proposals("f", &loaded);
    (loaded, proposals)
}

#[test]
fn no_manoeuvre_is_proposed_on_the_ground_of_a_flight_from_gate_to_gate() {
    let Some(recording) = phlab() else { return };
    let (loaded, proposals) = proposed(recording);
    let airspeed = &loaded.recording.role(Role::TrueAirspeed).unwrap().series;
    let slowest = |window: TimeRange| airspeed.statistics(window).unwrap().min;
    let lowest = proposals.windows.iter().map(|one| slowest(one.manoeuvre.window)).fold(f64::INFINITY, f64::min);
    println!("PH-LAB: {} manoeuvres, the slowest sample {lowest:.1} m/s", proposals.windows.len());
    assert!(proposals.windows.len() > 20 && lowest > 40.0, "{lowest}");
    // Its signals were interpolated to their rate: nothing of them is white, so nothing is called noise.
    assert!(proposals.steady.is_empty(), "{:?}", proposals.steady);
    let text = proposals.findings.join("\n");
    assert!(text.contains("no steady part: steady signals are not white noise"), "{text}");
    let noise = stage::noise(&[NoiseFlight { name: "f", loaded: &loaded, proposals: &proposals }], &[]).remove(0);
    assert!(noise.rows.iter().all(|row| row.choice.is_err()));
}

#[test]
fn every_cut_of_a_recording_of_cuts_is_a_window_of_its_own() {
    let Some(recording) = uav() else { return };
    let (loaded, proposals) = proposed(recording);
    let time = &loaded.recording.role(Role::RollRate).unwrap().series.time_s;
    let cuts = doublet_core::prep::stretches(time, 1.0);
    assert_eq!(cuts.len(), 9);
    for proposal in &proposals.windows {
        let window = proposal.manoeuvre.window;
        println!("{} {window:?} {:.2}", proposal.manoeuvre.name, proposal.confidence);
        // Times are rounded to a tenth of a second.
        let inside = |cut: &&std::ops::Range<usize>| {
            window.start_s >= time[cut.start] - 0.05 && window.end_s <= time[cut.end - 1] + 0.05
        };
        assert_eq!(cuts.iter().filter(inside).count(), 1, "{window:?}");
    }
    let surfaces: Vec<_> = proposals.windows.iter().map(|one| one.manoeuvre.surface.map(|it| it.name())).collect();
    let expected = [["aileron"; 4], ["elevator"; 4]].concat().into_iter().chain(["rudder"]).map(Some);
    assert_eq!(surfaces, expected.collect::<Vec<_>>());
    assert!(proposals.steady.is_empty() && proposals.no_steady.is_some());
}

#[test]
fn windows_of_manoeuvres_are_no_steady_flight() {
    let Some(recording) = attas() else { return };
    let (_, proposals) = proposed(recording);
    println!("{:?} {:?}", proposals.steady, proposals.no_steady);
    assert!(proposals.steady.is_empty());
}

#[test]
fn noise_of_a_simulated_recording_is_what_was_put_in() {
    let Some(recording) = citation() else { return };
    // The aileron moves all the time: the steady parts are marked by hand, before it and after.
    let (loaded, proposals) = proposed(recording);
    let window = TimeRange { start_s: 0.0, end_s: 10.0 };
    let steady = session::SteadyWindow { flight: "f".to_owned(), window, roles: Vec::new() };
    let noise = stage::noise(&[NoiseFlight { name: "f", loaded: &loaded, proposals: &proposals }], &[steady]).remove(0);
    let degree = std::f64::consts::PI / 180.0;
    for (name, truth) in [("alpha", 0.1 * degree), ("beta", 0.25 * degree), ("airspeed", 0.2), ("p", 0.005 * degree)] {
        let row = noise.rows.iter().find(|row| row.channel.name() == name).unwrap();
        println!("{name}: {:?} for {truth}", row.choice);
        // Four standard errors over 1,000 samples.
        assert!((row.proposed().unwrap() / truth - 1.0).abs() < 0.09, "{name}: {row:?}");
    }
}

#[test]
fn held_samples_are_found_where_they_are_and_nowhere_else() {
    let held = |recording: Option<Recording>| -> Option<Vec<String>> {
        let recording = recording?;
        let found = recording.roles.keys().filter_map(|role| {
            let found = held_samples(&recording.role(*role)?.series)?;
            Some(format!("{} {:.2}", role.name(), found.period))
        });
        Some(found.collect())
    };
    for recording in [phlab(), citation()] {
        let Some(found) = held(recording) else { return };
        assert_eq!(found, Vec::<String>::new());
    }
    let Some(found) = held(attas()) else { return };
    println!("attas: {found:?}");
    assert!(found.iter().all(|line| line.starts_with("mach") || line.starts_with("calibrated_airspeed")), "{found:?}");
    let Some(found) = held(uav()) else { return };
    println!("uav: {found:?}");
    for line in ["z 4.99", "v_north 2.50", "v_down 2.50", "phi 2.5", "airspeed 5.00", "alpha 3.0", "beta 3.0"] {
        assert!(found.iter().any(|found| found.starts_with(line)), "{line} in {found:?}");
    }
    assert!(!found.iter().any(|line| line.starts_with("p ") || line.starts_with("ax ")), "{found:?}");
}

/// A single-engine aircraft of a tonne, reference and inertia near those of the flight behind the samples.
const AIRCRAFT: &str = "format = \"doublet aircraft\"\nversion = 1\nname = \"single\"\n\n[datum]\norigin = \"centre of gravity\"\n\n\
    [reference]\narea_m2 = 16.17\nspan_m = 10.91\nchord_m = 1.494\n\n[mass]\nmass_kg = 1000.0\ncg_datum_m = [0.0, 0.0, 0.0]\n\n\
    [inertia]\nmoments_kg_m2 = [1285.0, 1825.0, 2667.0]\nproducts_kg_m2 = { xz = 0.0 }\n";

/// The elevator derivative of pitch from one of the generic files, and the findings of its flight.
fn pitch_control(file: &Path, signals: &str) -> (f64, Vec<(Level, String)>) {
    let folder = tempfile::tempdir().unwrap();
    let roles = [
        "ax", "ay", "az", "p", "q", "r", "phi", "theta", "psi", "x", "y", "z", "v_north", "v_east", "v_down",
        "airspeed", "alpha", "beta", "delta_a", "delta_e", "delta_r",
    ];
    let roles: String = roles.iter().map(|role| format!("{role} = {{ channel = \"{role}\" }}\n")).collect();
    let map = format!("format = \"doublet channel map\"\nversion = 1\nname = \"m\"\n[roles]\n{roles}");
    std::fs::write(folder.path().join("a.toml"), AIRCRAFT).unwrap();
    std::fs::write(folder.path().join("m.toml"), map).unwrap();
    let text = format!(
        "format = \"doublet session\"\nversion = {}\ntitle = \"t\"\naircraft = \"a.toml\"\n[filter]\ngravity_m_s2 = 9.7946\n\
         [preparation]\ndifferentiation_half_width_s = 0.1\n[model]\nCm = [\"1\", \"alpha\", \"qc/V\", \"delta_e\"]\n\
         [[flight]]\nname = \"f\"\n{signals}\n[[flight.recording]]\npath = \"{}\"\nchannel_map = \"m.toml\"\n\
         [[manoeuvre]]\nname = \"w\"\nflight = \"f\"\nstart_s = 2.0\nend_s = 24.0\nsurface = \"elevator\"\n",
        session::VERSION,
        file.canonicalize().unwrap().display()
    );
    let session = session::parse(&text).unwrap();
    let snapshot = compute(&session, folder.path());
    let pooled = snapshot.pooled.ready().unwrap();
    let fit = pooled.fits.iter().find(|fit| fit.coefficient == Coefficient::Cm).unwrap();
    let fit = fit.fit.as_ref().unwrap();
    let control = fit.estimates[fit.names.iter().position(|name| name.ends_with("delta_e")).unwrap()];
    let findings = snapshot.flights["f"].ready().unwrap().findings.iter();
    (control, findings.map(|it| (it.level, format!("{} {}", it.code, it.text))).collect())
}

#[test]
fn held_samples_used_once_give_the_derivatives_of_blank_places() {
    let Some(folder) = shared("data/formats/generic_csv") else { return };
    let of = |name: &str, signals: &str| pitch_control(&folder.join(name), signals);
    let keep = "[flight.signals]\nheld_samples = \"keep\"\n";
    let ((full, none), (blank, _)) = (of("05_units_row.csv", ""), of("13_mixed_rates_blanks.csv", ""));
    let ((kept, silent), (once, findings)) = (of("14_held_samples.csv", keep), of("14_held_samples.csv", ""));
    let percent = |value: f64| 100.0 * (value / full - 1.0);
    println!(
        "Cm_delta_e {full:.4}; held and kept {:+.2} %, used once {:+.2} %, blank {:+.2} %",
        percent(kept),
        percent(once),
        percent(blank)
    );
    println!("{findings:#?}");
    assert!(none.is_empty() && silent.is_empty(), "{none:?} {silent:?}");
    assert_eq!(findings.len(), 9, "three of position, three of velocity, airspeed, alpha and beta");
    assert!(findings.iter().all(|(level, text)| *level == Level::Good && text.starts_with("held-samples")));
    assert!(percent(kept).abs() > 4.0 * percent(once).abs(), "{kept} {once}");
    assert!((percent(once) - percent(blank)).abs() < 0.5 && percent(once).abs() < 2.0, "{once} {blank}");
}

#[test]
fn derivatives_of_attas_hang_on_none_of_its_held_channels() {
    if shared("data/attas").is_none() {
        return;
    }
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../sessions/reference/attas.toml");
    let opened = session::open(&path).unwrap();
    let estimates = |held: session::HeldSampleUse| {
        let mut session = opened.session.clone();
        session.flights[0].signals.held_samples = held;
        let snapshot = compute(&session, &opened.folder);
        let pooled = snapshot.pooled.ready().unwrap();
        pooled.fits.iter().map(|fit| fit.fit.as_ref().unwrap().estimates.clone()).collect::<Vec<_>>()
    };
    assert_eq!(estimates(session::HeldSampleUse::Once), estimates(session::HeldSampleUse::Every));
}
