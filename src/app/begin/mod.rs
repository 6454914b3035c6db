//! A new session from a recording: looked at in the background, its channels given roles, an aircraft chosen, then made.

mod aircraft;
mod channel_choice;
mod form;
mod physics;
mod roles;
mod travel;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use doublet_core::load::{ManualChannel, ManualChannelMap, Plan, RowValues};
use doublet_core::quantity::Role;
use doublet_engine::begin::{self, Inspected, Order};
use doublet_engine::run::{Control, Job};
use doublet_engine::session::{MapRef, Session};
use eframe::egui;

use super::{Asked, Document, Workbench};
use aircraft::AircraftForm;
use form::Answer;
use physics::Comparison;

/// Roles from which a shipped map that fits is taken to be the recorder's own.
const LEAST_ROLES: usize = 10;

/// Which channel map is used.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Choice {
    /// One of the maps that fit.
    Shipped(usize),
    /// The one made by hand.
    ByHand,
}

/// Whose recording it is.
#[derive(Clone, Debug, PartialEq, Eq)]
enum AircraftChoice {
    /// Not chosen yet: nothing tells of it but a map that names one.
    Open,
    /// Of none: the flight path alone is wanted.
    Without,
    /// Of this one: a file, or one that comes with the program.
    Of(String),
}

/// What the user has chosen so far.
struct Choosing {
    inspected: Arc<Inspected>,
    name: String,
    aircraft: AircraftChoice,
    choice: Choice,
    hand: ManualChannelMap,
    /// What reading by the map made by hand would do; kept until that changes.
    hand_plan: Result<Plan, String>,
    /// What the rows of that map read.
    values: BTreeMap<Role, (ManualChannel, Option<RowValues>)>,
    comparison: Comparison,
    aircraft_form: Option<AircraftForm>,
    complaint: Option<String>,
    /// Whether the dialog has been drawn, and the field that had the keyboard then.
    has_begun: bool,
    first_field: Option<egui::Id>,
    /// The field that had the keyboard in the frame before: Escape has taken it from there when this frame begins.
    focused: Option<egui::Id>,
}

/// How far it is.
enum Step {
    /// What was chosen of the recordings so far comes back with the further ones.
    Looking(PathBuf, Job<Inspected>, Option<Box<Choosing>>),
    Choosing(Box<Choosing>),
    Making(Box<Choosing>, Job<Session>),
}

/// At most one session being made.
#[derive(Default)]
pub struct Beginning {
    step: Option<Step>,
}

impl Choosing {
    fn new(inspected: Inspected) -> Self {
        let best = inspected.fitting.first();
        // A map made for another recorder fits by chance with the few roles whose names are everywhere.
        let choice = match best {
            Some(map) if map.plan.roles.len() >= LEAST_ROLES.min(inspected.guess.rows.len()) => Choice::Shipped(0),
            _ => Choice::ByHand,
        };
        let hand = inspected.guess.clone();
        let of_map = best.filter(|_| choice == Choice::Shipped(0)).and_then(|map| map.aircraft.clone());
        Self {
            name: inspected.paths.first().map(|path| begin::name_of(path)).unwrap_or_default(),
            aircraft: of_map.map_or(AircraftChoice::Open, AircraftChoice::Of),
            choice,
            hand_plan: begin::plan_by_hand(&inspected.probes, &hand),
            hand,
            values: BTreeMap::new(),
            comparison: Comparison::default(),
            aircraft_form: None,
            complaint: None,
            has_begun: false,
            first_field: None,
            focused: None,
            inspected: Arc::new(inspected),
        }
    }

    /// With what was chosen before further recordings came.
    fn continuing(mut self, before: Self) -> Self {
        self.name = before.name;
        self.aircraft_form = before.aircraft_form;
        if before.aircraft != AircraftChoice::Open {
            self.aircraft = before.aircraft;
        }
        if before.choice == Choice::ByHand {
            self.choice = Choice::ByHand;
        }
        let guess = &before.inspected.guess;
        if before.hand != *guess {
            let of_new =
                self.hand.rows.into_iter().filter(|(role, _)| !guess.rows.iter().any(|(known, _)| known == role));
            let rows: BTreeMap<Role, ManualChannel> = of_new.chain(before.hand.rows).collect();
            let known = |source: &str| before.hand.time.iter().any(|(other, _)| other == source);
            let time = self.hand.time.into_iter().filter(|(source, _)| !known(source));
            self.hand = ManualChannelMap {
                time: before.hand.time.iter().cloned().chain(time).collect(),
                rows: Role::ALL.into_iter().filter_map(|role| Some((role, rows.get(&role)?.clone()))).collect(),
                ..before.hand
            };
            self.plan_again();
        }
        self
    }

    /// What reading will do.
    fn plan(&self) -> Result<&Plan, &str> {
        match self.choice {
            Choice::Shipped(index) => self.inspected.fitting.get(index).map(|map| &map.plan).ok_or("choose a map"),
            Choice::ByHand => self.hand_plan.as_ref().map_err(String::as_str),
        }
    }

    /// What is still to be done before the session can be made.
    fn lacks(&self) -> Option<&'static str> {
        match self.plan() {
            _ if self.name.trim().is_empty() => Some("give the session a name"),
            _ if self.aircraft == AircraftChoice::Open && self.aircraft_form.is_some() => {
                Some("save the aircraft described above")
            }
            _ if self.aircraft == AircraftChoice::Open => {
                Some("choose the aircraft: mass, inertia and reference area come from it")
            }
            Err(_) => Some("choose a channel map"),
            Ok(plan) if plan.roles.is_empty() => Some("give a role to a channel"),
            Ok(plan) if plan.has_errors() => Some("mend the roles marked as wrong"),
            Ok(_) => None,
        }
    }

    /// The map as the session is to refer to it.
    fn map(&self) -> Result<MapRef, String> {
        match self.choice {
            Choice::Shipped(index) => {
                self.inspected.fitting.get(index).map(|map| map.reference()).ok_or_else(String::new)
            }
            Choice::ByHand => Ok(MapRef::Own(self.hand.text().map_err(|error| error.to_string())?.into())),
        }
    }

    /// Plans again after a change of the map made by hand.
    fn plan_again(&mut self) {
        self.hand_plan = begin::plan_by_hand(&self.inspected.probes, &self.hand);
    }
}

impl Workbench {
    /// Whether a session is being made of a recording.
    pub fn is_beginning(&self) -> bool {
        self.beginning.step.is_some()
    }

    /// Looks at the recordings at `paths`, all of one flight, in the background, then asks what they mean.
    pub(super) fn begin_with(&mut self, paths: Vec<PathBuf>, ctx: &egui::Context) {
        self.give_up_beginning();
        self.inspect(paths, None, ctx);
    }

    fn inspect(&mut self, paths: Vec<PathBuf>, before: Option<Box<Choosing>>, ctx: &egui::Context) {
        let Some(first) = paths.first().cloned() else { return };
        let ctx = ctx.clone();
        let work = move |control: &Control, progress: &(dyn Fn(f32) + Sync)| begin::inspect(&paths, control, progress);
        match Job::start("doublet-inspect", move || ctx.request_repaint(), work) {
            Ok(job) => self.beginning.step = Some(Step::Looking(first, job, before)),
            Err(error) => {
                self.beginning.step = before.map(Step::Choosing);
                self.complain(format!("{}: it cannot be looked at: {error}", first.display()));
            }
        }
    }

    /// Looks again with further recordings of the same flight.
    pub(super) fn begin_with_more(&mut self, more: &[PathBuf], ctx: &egui::Context) {
        match self.beginning.step.take() {
            Some(Step::Choosing(choosing)) => {
                let mut paths = choosing.inspected.paths.clone();
                paths.extend(more.iter().filter(|path| !choosing.inspected.paths.contains(path)).cloned());
                self.inspect(paths, Some(choosing), ctx);
            }
            other => self.beginning.step = other,
        }
    }

    /// Uses the aircraft file at `path` for the session being made.
    pub(super) fn begin_with_aircraft(&mut self, path: &Path) {
        if let Some(Step::Choosing(choosing)) = &mut self.beginning.step {
            let full = path.canonicalize().unwrap_or_else(|_| path.to_path_buf());
            choosing.aircraft = AircraftChoice::Of(full.display().to_string());
        }
    }

    /// Writes the aircraft that was described to `path` and uses it.
    pub(super) fn begin_with_new_aircraft(&mut self, path: &Path) {
        let Some(Step::Choosing(choosing)) = &mut self.beginning.step else { return };
        let Some(form) = &choosing.aircraft_form else { return };
        let path = if path.extension().is_some() { path.to_path_buf() } else { path.with_extension("toml") };
        let place = path.display();
        match form.text().and_then(|text| std::fs::write(&path, text).map_err(|error| format!("{place}: {error}"))) {
            Ok(()) => {
                choosing.aircraft_form = None;
                choosing.complaint = None;
                self.begin_with_aircraft(&path);
            }
            Err(line) => choosing.complaint = Some(line),
        }
    }

    /// Gives up what is under way; what was chosen before further recordings were looked at stays.
    fn give_up_beginning(&mut self) {
        match self.beginning.step.take() {
            Some(Step::Looking(_, job, before)) => {
                job.abandon();
                self.beginning.step = before.map(Step::Choosing);
            }
            Some(Step::Making(_, job)) => job.abandon(),
            Some(Step::Choosing(_)) | None => {}
        }
    }

    /// Takes in what the background came to.
    pub(super) fn take_beginning(&mut self) {
        match self.beginning.step.take() {
            Some(Step::Looking(path, job, before)) if job.is_finished() => {
                let found = job.finish().map_err(String::from);
                let place = path.display().to_string();
                let placed = |line: String| if line.contains(&place) { line } else { format!("{place}: {line}") };
                let choosing = match (found, before) {
                    (Ok(inspected), None) => Choosing::new(inspected),
                    (Ok(inspected), Some(before)) => Choosing::new(inspected).continuing(*before),
                    (Err(line), None) => return self.complain(placed(line)),
                    (Err(line), Some(before)) => Choosing { complaint: Some(line), ..*before },
                };
                self.beginning.step = Some(Step::Choosing(Box::new(choosing)));
            }
            Some(Step::Making(mut choosing, job)) if job.is_finished() => match job.finish().map_err(String::from) {
                Ok(session) => self.enter_begun(session),
                Err(line) => {
                    choosing.complaint = Some(line);
                    self.beginning.step = Some(Step::Choosing(choosing));
                }
            },
            other => self.beginning.step = other,
        }
    }

    /// Shows the session that was made, with a word on what to do next.
    fn enter_begun(&mut self, session: Session) {
        let windows = session.windows.len();
        let found = session.windows.iter().any(|window| window.surface.is_some());
        self.enter_document(Ok(Document::start(session)));
        // Plots chosen for another recording name channels this one does not have.
        self.state.flight_plots = None;
        self.state.show_layout(crate::layouts::LayoutKey::Step(crate::layouts::Step::Manoeuvres));
        self.say(if found {
            let found = crate::notation::plural(windows, "manoeuvre");
            format!("New session: {found} of its controls found as windows. Save it with Ctrl+S")
        } else {
            "New session: no manoeuvre was found, one window holds the whole recording. Draw others above the plots"
                .to_owned()
        });
    }

    /// Draws the dialog and carries out what it asks for.
    pub(super) fn show_beginning(&mut self, ctx: &egui::Context) {
        // One of two dialogs would hide the other.
        if self.files.is_shown() {
            return;
        }
        let below = self.files.is_asking();
        let Some(step) = &mut self.beginning.step else { return };
        let answer = form::show(step, below, ctx);
        match answer {
            Answer::Open => {}
            Answer::GivenUp => self.give_up_beginning(),
            Answer::AskBeside => self.ask(Asked::Beside, ctx),
            Answer::AskAircraft => self.ask(Asked::Aircraft, ctx),
            Answer::SaveAircraft => self.ask(Asked::NewAircraft, ctx),
            Answer::Make => self.make(ctx),
        }
    }

    /// Starts making the session.
    fn make(&mut self, ctx: &egui::Context) {
        let Some(Step::Choosing(mut choosing)) = self.beginning.step.take() else { return };
        // What was still being compared is not waited for.
        choosing.comparison = Comparison::default();
        let started = choosing.map().and_then(|map| {
            let plan = choosing.plan().map_err(str::to_owned)?.clone();
            let aircraft = match &choosing.aircraft {
                AircraftChoice::Open => return Err("choose the aircraft".to_owned()),
                AircraftChoice::Without => None,
                AircraftChoice::Of(reference) => Some(reference.clone()),
            };
            let order = Order { name: choosing.name.trim().to_owned(), aircraft, map };
            let (inspected, wake) = (Arc::clone(&choosing.inspected), ctx.clone());
            let work = move |control: &Control, progress: &(dyn Fn(f32) + Sync)| {
                begin::begin(&order, &inspected, &plan, control, progress)
            };
            Job::start("doublet-begin", move || wake.request_repaint(), work).map_err(|error| error.to_string())
        });
        self.beginning.step = Some(match started {
            Ok(job) => Step::Making(choosing, job),
            Err(line) => {
                choosing.complaint = Some(line);
                Step::Choosing(choosing)
            }
        });
    }
}
