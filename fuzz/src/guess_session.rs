//! The session that `new --guess` makes of a recording.

use doublet_core::load::{ChannelMap, plan_all};
use doublet_engine::begin::{self, Inspected};
use doublet_engine::run::Control;
use doublet_engine::session::{Flight, MapRef, Session};

/// Makes the session; its manoeuvre is the whole recording where none is found.
pub fn guess_session(inspected: &Inspected) -> Result<Session, String> {
    let text = inspected.guess.text().map_err(|error| error.to_string())?;
    let map = ChannelMap::parse(&text).map_err(|error| error.to_string())?;
    let plan = plan_all(&inspected.probes, &map);
    if plan.all_roles().is_empty() {
        return Err("no channel has a role".to_owned());
    }
    // What cannot be compared is refused by what needs it.
    let _ = begin::compare(&plan);
    let own = MapRef::Own(text.into());
    let mut session = begin::empty_session("a", Some("builtin:attas_vfw614"));
    let added = begin::add_flight(&mut session, ("a", &own), inspected, &plan, &Control::default(), &|_| {});
    if added.is_err() {
        let recordings = inspected.paths.iter().map(|path| begin::reference(path, own.clone()));
        session.flights = vec![Flight::new("a".to_owned(), recordings.collect::<Result<_, _>>()?)];
    }
    if session.windows.is_empty() {
        session.windows.extend(begin::whole_window("a", &inspected.probes));
    }
    Ok(session)
}
