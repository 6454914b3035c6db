//! A new session from a recording: looked at in the background, its channels given roles, an aircraft chosen, then made.

mod channel_choice;
mod page;
mod physics;
mod recording;
mod roles;
mod travel;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use doublet_cli::questions::{Question, list_questions};
use doublet_core::load::{ManualChannel, ManualChannelMap, Plan, RowValues};
use doublet_core::quantity::{Role, Unit};
use doublet_engine::begin::{self, Inspected, Order};
use doublet_engine::run::{Control, Job};
use doublet_engine::session::{MapRef, Session};
use doublet_engine::verdict::Level;
use eframe::egui;

use super::pending::save_aircraft_text;
use super::{Asked, Document, Workbench};
use crate::notation;
use crate::widgets::aircraft_form::AircraftForm;
use page::{Answer, Page, missing_roles};
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
    /// What the recordings leave open by the map made by hand.
    questions: Vec<Question>,
    page: Page,
    /// Whether the page has been drawn, and the field that had the keyboard then.
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
    /// Whether the user has left the page; the draft is kept.
    is_left: bool,
    /// Whether the user is asked what becomes of the draft.
    is_asked: bool,
    /// Whether that was asked in the frame before: the Escape that asks is not the answer.
    was_asked: bool,
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
            questions: questions(&inspected, &inspected.guess),
            page: Page::default(),
            has_begun: false,
            first_field: None,
            focused: None,
            inspected: Arc::new(inspected),
        }
    }

    /// With what was chosen before further recordings came.
    fn continuing(mut self, before: Self) -> Self {
        self.name = before.name;
        self.page = before.page;
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
        self.lacks_aircraft_or_name().or(self.lacks_roles()).or(self.lacks_units())
    }

    /// The channels without which there is no flight path: the session shows the recording alone.
    fn describe_missing_inputs(&self) -> Option<String> {
        let lack = missing_roles(self).into_iter().find(|lack| lack.level == Level::Bad)?;
        let names: Vec<_> = lack.roles.iter().map(|role| notation::role(*role)).collect();
        Some(format!("{} {}", lack.means, names.join("  ")))
    }

    /// A control whose values can be read in two units: nothing in the motion shows which.
    fn lacks_units(&self) -> Option<&'static str> {
        let is_asked = |question: &Question| question.must_be_answered && self.open_unit(question).is_some();
        self.questions().iter().any(is_asked).then_some("confirm the unit of each control in step Check")
    }

    /// The role and the unit that a question asks for, where a click can confirm it.
    fn open_unit(&self, question: &Question) -> Option<(Role, Unit)> {
        let role = question.role?;
        Some((role, self.hand.row(role)?.unit?))
    }

    fn lacks_aircraft_or_name(&self) -> Option<&'static str> {
        let is_open = self.aircraft == AircraftChoice::Open;
        match () {
            () if self.name.trim().is_empty() => Some("give the session a name"),
            () if is_open && self.aircraft_form.is_some() => Some("save the aircraft described above"),
            () if is_open => Some("choose the aircraft: mass, inertia and reference area come from it"),
            () => None,
        }
    }

    fn lacks_roles(&self) -> Option<&'static str> {
        match self.plan() {
            Err(_) => Some("choose a channel map"),
            Ok(plan) if plan.roles.is_empty() => Some("give a role to a channel"),
            Ok(plan) if plan.has_errors() => Some("correct the roles marked as wrong"),
            Ok(_) => None,
        }
    }

    /// What the recordings leave open; nothing by a map that comes with the program.
    fn questions(&self) -> &[Question] {
        if self.choice == Choice::ByHand { &self.questions } else { &[] }
    }

    /// Whether anything was chosen by hand that would be lost.
    fn is_touched(&self) -> bool {
        self.hand != self.inspected.guess || self.aircraft_form.is_some()
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

    /// Takes the units of `roles` in the map made by hand for known.
    fn confirm_units(&mut self, roles: &[Role]) {
        for role in roles {
            if let Some(mut row) = self.hand.row(*role).cloned() {
                row.is_unit_known = true;
                self.hand.set(*role, Some(row));
            }
        }
        if !roles.is_empty() {
            self.plan_again();
        }
    }

    /// Plans again after a change of the map made by hand.
    fn plan_again(&mut self) {
        self.hand_plan = begin::plan_by_hand(&self.inspected.probes, &self.hand);
        self.questions = questions(&self.inspected, &self.hand);
    }
}

/// What recordings leave open by a map.
fn questions(inspected: &Inspected, map: &ManualChannelMap) -> Vec<Question> {
    inspected.probes.iter().flat_map(|probe| list_questions(probe, map)).collect()
}

impl Workbench {
    /// Whether a session is being made of a recording, and on screen.
    pub fn is_beginning(&self) -> bool {
        self.beginning.step.is_some() && !self.beginning.is_left
    }

    /// Name of the session being made that was left.
    pub fn draft_name(&self) -> Option<&str> {
        match &self.beginning.step {
            Some(Step::Choosing(choosing)) if self.beginning.is_left => Some(&choosing.name),
            _ => None,
        }
    }

    /// The first recording of the session being made.
    pub(super) fn begun_from(&self) -> Option<&Path> {
        match &self.beginning.step {
            Some(Step::Choosing(choosing)) => choosing.inspected.paths.first().map(PathBuf::as_path),
            _ => None,
        }
    }

    /// Whether the page of a new session takes the place of the panels.
    pub(super) fn is_on_beginning_page(&self) -> bool {
        self.is_beginning() && matches!(self.beginning.step, Some(Step::Choosing(_)))
    }

    /// Leaves the page of a new session; its draft is kept.
    pub(super) fn leave_beginning(&mut self) {
        self.beginning.is_left = true;
    }

    /// Goes on with the new session that was left.
    pub fn continue_beginning(&mut self) {
        match self.beginning.step {
            Some(_) => self.beginning.is_left = false,
            None => self.complain("No draft of a new session: choose a recording first."),
        }
    }

    pub(super) fn described_aircraft(&self) -> Option<&str> {
        match &self.beginning.step {
            Some(Step::Choosing(choosing)) => choosing.aircraft_form.as_ref().map(AircraftForm::name),
            _ => None,
        }
    }

    /// Looks at the recordings at `paths`, all of one flight, in the background, then asks what they mean.
    pub(super) fn begin_with(&mut self, paths: Vec<PathBuf>, ctx: &egui::Context) {
        if let Some(Step::Choosing(choosing)) = &self.beginning.step
            && choosing.is_touched()
        {
            let line = format!("The new session {} is not finished: create or cancel it first.", choosing.name);
            self.beginning.is_left = false;
            return self.complain(line);
        }
        self.give_up_beginning();
        self.beginning.is_left = false;
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
                self.complain(format!("{}: cannot be read: {error}", first.display()));
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

    /// Looks again without the recording at a place; what was chosen of the others stays.
    fn begin_without(&mut self, at: usize, ctx: &egui::Context) {
        let Some(Step::Choosing(mut choosing)) = self.beginning.step.take() else { return };
        let gone = choosing.inspected.probes.get(at).map_or(&[][..], |probe| &probe.sources);
        let gone: Vec<String> = gone.iter().map(|source| source.name.clone()).collect();
        let inspected = Arc::make_mut(&mut choosing.inspected);
        for map in [&mut choosing.hand, &mut inspected.guess] {
            map.rows.retain(|(_, row)| !gone.contains(&row.from.source));
            map.time.retain(|(source, _)| !gone.contains(source));
        }
        let others = inspected.paths.iter().enumerate().filter(|(index, _)| *index != at);
        let paths = others.map(|(_, path)| path.clone()).collect();
        self.inspect(paths, Some(choosing), ctx);
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
        match form.text().and_then(|text| save_aircraft_text(path, &text)) {
            Ok(path) => {
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
        self.state.show_layout(crate::layouts::LayoutKey::Step(crate::step::Step::Manoeuvres));
        self.set_message(if found {
            let found = notation::plural(windows, "manoeuvre");
            format!("New session: {found} found. Save it with Ctrl+S")
        } else {
            "New session: no manoeuvre found; one covers the whole recording. Draw others above the plots".to_owned()
        });
    }

    /// Draws the page in the place of the panels.
    pub(super) fn show_beginning_page(&mut self, ui: &mut egui::Ui) {
        let below = self.files.is_shown() || self.files.is_asking() || self.beginning.is_asked;
        let Some(Step::Choosing(choosing)) = &mut self.beginning.step else { return };
        let answer = page::show(choosing, below, ui);
        let is_touched = choosing.is_touched();
        match answer {
            Answer::GivenUp if is_touched => self.beginning.is_asked = true,
            answer => self.follow_beginning(answer, ui.ctx()),
        }
    }

    /// Draws what is waited for, and asks before a draft is lost.
    pub(super) fn show_beginning(&mut self, ctx: &egui::Context) {
        if self.beginning.is_asked {
            return self.ask_about_draft(ctx);
        }
        if self.beginning.is_left || self.files.is_shown() {
            return;
        }
        let below = self.files.is_asking();
        let Some(step) = &self.beginning.step else { return };
        let answer = page::wait(step, below, ctx);
        self.follow_beginning(answer, ctx);
    }

    fn follow_beginning(&mut self, answer: Answer, ctx: &egui::Context) {
        match answer {
            Answer::Open => {}
            Answer::Left => self.leave_beginning(),
            Answer::GivenUp => self.give_up_beginning(),
            Answer::AskBeside => self.ask(Asked::Beside, ctx),
            Answer::Remove(at) => self.begin_without(at, ctx),
            Answer::AskAircraft => self.ask(Asked::Aircraft, ctx),
            Answer::SaveAircraft => self.ask(Asked::NewAircraft, ctx),
            Answer::Make => self.make(ctx),
        }
    }

    /// Asks what becomes of a draft with choices made by hand.
    fn ask_about_draft(&mut self, ctx: &egui::Context) {
        let mut is_asked = true;
        egui::Modal::new(egui::Id::unique("draft of a new session")).show(ctx, |ui| {
            ui.set_width(380.0);
            ui.heading("Cancel the new session?");
            ui.label("Channels or an aircraft were chosen by hand.");
            ui.add_space(8.0);
            ui.horizontal(|ui| {
                if ui.button("Go on").clicked() {
                    is_asked = false;
                }
                if ui.button("Leave and keep the draft").clicked() {
                    is_asked = false;
                    self.beginning.is_left = true;
                }
                if ui.button("Discard the draft").clicked() {
                    is_asked = false;
                    self.give_up_beginning();
                }
            });
        });
        let escaped = ctx.input(|input| input.key_pressed(egui::Key::Escape)) && self.beginning.was_asked;
        self.beginning.was_asked = is_asked && !escaped;
        self.beginning.is_asked = is_asked && !escaped;
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
