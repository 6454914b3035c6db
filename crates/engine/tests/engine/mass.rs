//! Mass properties shown are those flown: against the truth of the shipped flight, and after a tank is touched.

use std::collections::BTreeMap;
use std::path::Path;

use doublet_core::airframe::Loading;
use doublet_engine::report::{self, MassRow, Results};
use doublet_engine::run::Snapshot;
use doublet_engine::session::{self, Edit, Flight, LoadingEdit, Manoeuvre, Place, Session, WindowRole};
use doublet_engine::verdict::Finding;

use crate::compute;

/// The shipped flight with three windows of the elevator only.
fn demo() -> Session {
    let mut session = session::parse(doublet_engine::builtin::session("demo").unwrap()).unwrap();
    for (at, window) in session.windows.iter_mut().enumerate() {
        window.role = if matches!(at, 2 | 3 | 18) { WindowRole::Identification } else { WindowRole::Ignored };
    }
    session
}

fn computed(session: &Session) -> (Snapshot, Results) {
    let folder = Path::new(".");
    let snapshot = compute(session, folder);
    let results = report::build(session, &snapshot);
    (snapshot, results)
}

/// A true quantity of the loading at a time.
fn truth(snapshot: &Snapshot, name: &str, time_s: f64) -> f64 {
    let flight = snapshot.flights["FT1"].ready().unwrap();
    let channel = flight.recording.channels.iter().find(|channel| channel.name == name).unwrap();
    let series = &channel.series;
    series.values[series.time_s.partition_point(|&t| t < time_s).min(series.values.len() - 1)]
}

#[test]
fn mass_properties_are_those_flown_at_the_start_in_each_window_and_at_the_end() {
    /// Probes with blind zones tell four tanks to some pounds each, kg.
    const MASS_KG: f64 = 10.0;
    /// The same of the moment of inertia about x, to which the fuel in the wings adds most, kg m².
    const IXX_KG_M2: f64 = 80.0;
    let (snapshot, results) = computed(&demo());
    let flown = results.flights[0].mass_properties.as_ref().unwrap();
    let check = |what: &str, time_s: f64, mass: &MassRow| {
        let (true_mass, true_ixx) = (truth(&snapshot, "mass", time_s), truth(&snapshot, "Ixx", time_s));
        println!(
            "{what}: {:.1} kg for {true_mass:.1}, Ixx {:.0} for {true_ixx:.0}",
            mass.properties.mass_kg, mass.properties.inertia.xx
        );
        assert!((mass.properties.mass_kg - true_mass).abs() < MASS_KG, "{what}");
        assert!((mass.properties.inertia.xx - true_ixx).abs() < IXX_KG_M2, "{what}");
    };
    check("start", flown.start_s, &flown.start);
    check("end", flown.end_s, &flown.end);
    /// Fuel of one sample to the next, as the probes step, kg.
    const SAMPLE_KG: f64 = 0.01;
    assert_eq!(results.windows.len(), 3);
    for window in &results.windows {
        let mass = window.mass_properties.as_ref().unwrap();
        check(&window.name, 0.5 * (window.start_s + window.end_s), mass);
        // What the coefficients were formed with.
        let aero = snapshot.windows[&window.name].aero.ready().unwrap();
        let middle = aero.data.time_s.partition_point(|&t| t < 0.5 * (window.start_s + window.end_s));
        let used = aero.data.mass.at(middle);
        assert!(
            (used.mass_kg - mass.properties.mass_kg).abs() < SAMPLE_KG,
            "{} {}",
            used.mass_kg,
            mass.properties.mass_kg
        );
        assert!(
            (used.inertia.xx - mass.properties.inertia.xx).abs() < 0.1
                && (used.inertia.xy - mass.properties.inertia.xy).abs() < 0.1
        );
    }
    assert!(flown.start.properties.mass_kg > flown.end.properties.mass_kg + 40.0, "fuel is burnt");
    assert_eq!(results.mass_kg, flown.start.properties.mass_kg);
    assert_eq!(results.mass_properties.unwrap().properties, flown.start.properties);
}

/// Two flights, the second with a loading of its own: it has the mass, and its windows the coefficients, that a session has whose
/// only flight is loaded so; the first keeps those of the session.
#[test]
fn a_flight_with_a_loading_of_its_own_is_as_heavy_as_a_session_loaded_so() {
    let common = demo();
    let mut own = common.loading.clone().unwrap();
    own.seats_kg.insert("passenger left".to_owned(), 0.0);
    let mut both = common.clone();
    both.flights.push(Flight { name: "FT2".to_owned(), loading: Some(own.clone()), ..common.flights[0].clone() });
    let again = |window: &Manoeuvre| Manoeuvre {
        name: format!("{} of FT2", window.name),
        flight: "FT2".to_owned(),
        ..window.clone()
    };
    both.windows.extend(common.active_windows().map(again));
    // What is tested is what a saved session says.
    let both = session::parse(&session::print(&both).unwrap()).unwrap();
    let lighter = computed(&Session { loading: Some(own), ..common.clone() }).0;
    let (heavier, found) = (computed(&common).0, computed(&both).0);
    for window in common.active_windows() {
        let aero = |snapshot: &Snapshot, name: &str| snapshot.windows[name].aero.ready().unwrap().clone();
        let expected = [aero(&heavier, &window.name), aero(&lighter, &window.name)];
        let of_second = format!("{} of FT2", window.name);
        for (expected, name) in expected.iter().zip([&window.name, &of_second]) {
            let aero = aero(&found, name);
            assert_eq!(aero.data.mass, expected.data.mass, "{name}");
            assert_eq!(aero.coefficients, expected.coefficients, "{name}");
        }
        let [with, without] = expected.map(|aero| aero.data.mass.at(0).mass_kg);
        assert!((with - without - 74.7).abs() < 1e-9, "{with} {without}");
    }
    assert_eq!(
        found.flown["FT2"].ready().unwrap().start.state.properties.mass_kg,
        lighter.flown["FT1"].ready().unwrap().start.state.properties.mass_kg
    );
    // Given up, the flight has the loading of all.
    let edit = Edit::Loading(LoadingEdit::OfFlight { flight: "FT2".to_owned(), loading: None });
    let given_up = edit.apply(&both).unwrap();
    assert_eq!(given_up.loading_in("FT2"), common.loading.as_ref());
}

#[test]
fn touched_tank_shifts_its_own_record_and_no_others() {
    const LESS_KG: f64 = 20.0;
    let plain = demo();
    let (before, _) = computed(&plain);
    let flown = before.flown["FT1"].ready().unwrap();
    let recorded: BTreeMap<String, f64> = flown.start.loading.fuel_kg.clone();
    let stating = |fuel_kg: BTreeMap<String, f64>| {
        let loading = Some(Loading { fuel_kg, ..plain.loading.clone().unwrap() });
        computed(&Session { loading, ..plain.clone() }).0
    };
    let windows = |snapshot: &Snapshot| -> Vec<(f64, BTreeMap<String, f64>)> {
        let flown = snapshot.flown["FT1"].ready().unwrap();
        let states = flown.windows.iter().map(|(_, state)| state);
        states.map(|state| (state.state.properties.mass_kg, state.loading.fuel_kg.clone())).collect()
    };
    // What was recorded, stated by hand, changes nothing.
    let same = windows(&stating(recorded.clone()));
    assert_eq!(same, windows(&before));
    let mut less = recorded.clone();
    *less.get_mut("main right").unwrap() -= LESS_KG;
    let touched = stating(less);
    for ((mass, fuel), (own_mass, own_fuel)) in windows(&touched).iter().zip(&same) {
        assert!((own_mass - mass - LESS_KG).abs() < 1e-9, "{own_mass} {mass}");
        for (tank, kg) in fuel {
            let shift = if tank == "main right" { LESS_KG } else { 0.0 };
            assert!((own_fuel[tank] - kg - shift).abs() < 1e-9, "{tank}");
        }
    }
    assert!(touched.flown["FT1"].ready().unwrap().fuel.description().contains("shifted to the stated fuel"));
    // The coefficients see it.
    let used =
        |snapshot: &Snapshot| snapshot.windows["03 elevator doublet"].aero.ready().unwrap().data.mass.at(0).mass_kg;
    assert!((used(&before) - used(&touched) - LESS_KG).abs() < 1e-9);
    // And so does the verdict: of every window, with the tank and what was changed.
    let loading = |snapshot: &Snapshot| -> Vec<Finding> {
        let verdicts = snapshot.verdicts.ready().unwrap();
        let reasons = verdicts.windows.values().flat_map(|window| window.verdict.reasons.clone());
        reasons.filter(|reason| reason.code == "loading").collect()
    };
    assert_eq!(loading(&before), []);
    let told = loading(&touched);
    assert_eq!(told.len(), 3);
    assert!(told.iter().all(|finding| finding.text.to_string().contains("'main right' by -20.0 kg")), "{told:?}");
    assert!(told.iter().all(|finding| (finding.figure.unwrap() + LESS_KG).abs() < 1e-9));
}

#[test]
fn mass_that_nobody_stated_and_nothing_recorded_is_called_assumed() {
    let assumed = |session: &Session| -> Vec<String> {
        let (snapshot, _) = computed(session);
        let reasons = &snapshot.verdicts.ready().unwrap().session.reasons;
        let told = reasons.iter().filter(|reason| reason.code == "loading" && reason.place == Place::flight("FT1"));
        told.map(|reason| reason.text.to_string()).collect()
    };
    let plain = demo();
    assert_eq!(assumed(&plain), Vec::<String>::new());
    // Four seats of 74.7 kg and 45.9 kg of luggage.
    let standard = Session { loading: None, ..plain.clone() };
    let told = assumed(&standard);
    assert!(told.len() == 1 && told[0].contains("standard seats and luggage of 345 kg"), "{told:?}");
    assert!(!told[0].contains("fuel"), "the probes tell it: {told:?}");
    let mut without_probes = plain;
    without_probes.flights[0].instruments.as_mut().unwrap().fuel.clear();
    let told = assumed(&without_probes);
    assert!(told.len() == 1 && told[0].contains("standard fuel of 373 kg, all tanks full"), "{told:?}");
    without_probes.loading.as_mut().unwrap().fuel_kg.insert("main right".to_owned(), 100.0);
    let told = assumed(&without_probes);
    assert!(told.len() == 1 && told[0].contains("fuel of 100 kg, constant (burn not recorded)"), "{told:?}");
}
