//! The manoeuvre looked at is published before the others, and the results are those of any other order.

use std::path::Path;
use std::sync::Mutex;

use doublet_core::reconstruct::Input;
use doublet_engine::graph::{Cache, Control, Keyed};
use doublet_engine::report;
use doublet_engine::run::{Scope, Slot, Snapshot, run};
use doublet_engine::session::{self, Edit, NoiseChannel, Session, WindowRole};

/// The shipped flight with ten of its manoeuvres.
fn demo() -> Session {
    let mut session = session::parse(doublet_engine::builtin::session("demo").unwrap()).unwrap();
    session.windows.truncate(10);
    session.windows.iter_mut().for_each(|window| window.role = WindowRole::Identification);
    session
}

/// Runs a session after `previous`; the last snapshot and all that were published.
fn published(session: &Session, first: Option<&str>, previous: &Snapshot, cache: &Cache) -> (Snapshot, Vec<Snapshot>) {
    let all = Mutex::new(Vec::new());
    let generation = previous.generation + 1;
    let scope = Scope { session, folder: Path::new("."), first, studies: &[], cause: "test", generation };
    let last = run(&scope, previous, cache, &Control::default(), &|snapshot| all.lock().unwrap().push(snapshot));
    (last, all.into_inner().unwrap())
}

fn edited(session: &Session) -> Session {
    Edit::noise(NoiseChannel::Input(Input::PitchRate), 2e-3).apply(session).unwrap()
}

#[test]
fn the_manoeuvre_looked_at_is_published_first_and_nothing_else_is_greyed_for_it() {
    let session = demo();
    let name = session.windows[6].name.as_str();
    let cache = Cache::new(1 << 30);
    let (before, _) = published(&session, Some(name), &Snapshot::default(), &cache);
    let changed = edited(&session);
    let (after, all) = published(&changed, Some(name), &before, &cache);
    let keys = |of: &Snapshot, name: &str| {
        let results = &of.windows[name];
        (
            results.path.keyed().map(Keyed::key).unwrap(),
            results.aero.keyed().map(Keyed::key).unwrap(),
            results.fits.keyed().map(Keyed::key).unwrap(),
        )
    };
    assert_ne!(keys(&after, name), keys(&before, name));
    let is_new =
        |shown: &&Snapshot| shown.windows[name].fits.ready().is_some() && keys(shown, name) == keys(&after, name);
    let early = all.iter().find(is_new).expect("it is published");
    let pooled = |of: &Snapshot| of.pooled.ready().and_then(|_| of.pooled.keyed().map(Keyed::key));
    assert_ne!(pooled(early), pooled(&after), "it does not wait for the others");
    // On a slow machine the run is shown as it goes; until then what is on screen stays.
    if early.generation == before.generation {
        for window in session.windows.iter().filter(|window| window.name != name) {
            assert_eq!(keys(early, &window.name), keys(&before, &window.name));
        }
        let is_ready = early.windows.values().all(|window| window.fits.ready().is_some());
        assert!(is_ready && matches!(early.pooled, Slot::Ready(_)) && early.verdicts.ready().is_some());
    }
    // Nothing new of it: nothing is published before the rest.
    let (_, all) = published(&changed, Some(name), &after, &cache);
    assert!(all.iter().all(|snapshot| snapshot.generation == after.generation + 1));
}

#[test]
fn results_do_not_depend_on_what_is_looked_at() {
    let session = edited(&demo());
    let results = |first: Option<&str>| {
        let (snapshot, _) = published(&session, first, &Snapshot::default(), &Cache::new(1 << 30));
        serde_json::to_string(&report::build(&session, &snapshot)).unwrap()
    };
    let without = results(None);
    for at in [0, 9] {
        assert_eq!(results(Some(&session.windows[at].name)), without);
    }
}
