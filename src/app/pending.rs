//! What waits for an answer: a file asked for, a step that would lose unsaved changes.

use std::collections::BTreeSet;
use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use doublet_core::load::FORMATS;
use doublet_engine::export::{self, Format, IdentifiedModel};
use doublet_engine::keep::{self, Put};
use doublet_engine::report::{self, Outputs};
use doublet_engine::run::{Control, Job};
use doublet_engine::session::{AircraftEdit, Edit, ReportFigure, ReportFigureEdit, Session, SignalEdit};
use doublet_engine::{aircraft, builtin, calibrate};
use doublet_report::Order;
use eframe::egui::{self, ViewportCommand, vec2};

use super::files::{FileQuestion, Purpose, file_stem, with_ending};
use super::{Document, Workbench, public};
use crate::command::FileField;
use crate::widgets::figure::{self, FigureForm, FigureRequest};

/// Folders of sessions opened last that a dialog offers.
const MOST_PLACES: usize = 4;

/// Endings of the recordings that a dialog offers, telemetry logs among them; what a file is, its contents show.
fn recordings() -> Vec<String> {
    let endings = FORMATS.iter().flat_map(|format| format.endings).copied().chain(["tlog"]);
    endings.collect::<BTreeSet<_>>().into_iter().map(str::to_owned).collect()
}

/// A step that leaves the present session.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Pending {
    /// Ask for a session and open it.
    AskOpen,
    /// Open this session.
    Open(PathBuf),
    /// Open this one of the sessions that come with the program.
    Shipped(&'static str),
    /// Open the shipped flight and begin the tour.
    Tour,
    /// Ask for the files of the public recording and open its worked case.
    AskPublic,
    /// Ask for a recording and make a session of it.
    AskRecording,
    /// Ask for a folder that is a recording and make a session of it.
    AskFolder,
    /// Make a session of these recordings of one flight.
    Begin(Vec<PathBuf>),
    /// Close the window.
    Quit,
}

/// What a file was asked for.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Asked {
    Open,
    /// To open it beside the present session.
    OpenBeside,
    /// To make a session of it, a recording: a file, or a folder.
    Recording(Purpose),
    /// To open the worked case of the public recording with it and others.
    Public,
    /// To read it along with the recordings of the session being made.
    Beside,
    /// To use it as the aircraft of the session being made.
    Aircraft,
    /// To write an aircraft to it that was described.
    NewAircraft,
    /// To use it as the aircraft of the session.
    OtherAircraft,
    /// To write the aircraft to it that was described for a session without one.
    DescribedAircraft,
    /// To put it into a field of a panel.
    Field(FileField),
    /// To write the edited aircraft of the session to it.
    OwnAircraft,
    /// To write the instruments with what was fitted to it.
    Instruments,
    /// To save the session to it, and go on with a step afterwards.
    Save(Option<Pending>),
    /// To write results into it.
    Export,
    /// To write the report into it.
    Report,
    /// To read derivatives to mark beside the estimates.
    Reference,
    /// To write a figure to it: the form, and the name proposed.
    Figure(FigureForm, String),
    /// To write the identified model into it.
    ExportModel,
    /// To read a recording of a flight from it that is no longer where it was: name of the flight, place of the recording.
    Missing(String, usize),
}

/// Title, purpose, endings and proposed name of the dialog of a field.
fn question_of(field: FileField) -> (&'static str, Purpose, Vec<String>, String) {
    let folder = |title, name: &str| (title, Purpose::Save, Vec::new(), name.to_owned());
    let file = |title, endings| (title, Purpose::Open, endings, String::new());
    match field {
        FileField::Tests => file("A file of objective tests", vec!["toml".to_owned()]),
        FileField::Guide => folder("Folder for the guide", "guide"),
        FileField::Card => folder("Folder for card and files", "card"),
        FileField::LiveSource => file("A recording or a growing file", recordings()),
        FileField::LiveCampaign => file("A campaign file", vec!["toml".to_owned()]),
        FileField::LiveRecord => folder("Folder for the recording", "recorded"),
    }
}

/// Writes the text of an aircraft that was described; where it is.
pub(super) fn save_aircraft_text(path: &Path, text: &str) -> Result<PathBuf, String> {
    let path = with_ending(path);
    keep::replace(&path, text.as_bytes()).map_err(|error| format!("{}: {error}", path.display()))?;
    Ok(path)
}

impl Workbench {
    /// Leaves the present session, after asking where changes would be lost.
    pub fn leave(&mut self, pending: Pending, ctx: &egui::Context) {
        if self.document.history.is_modified() {
            self.guarded = Some(pending);
        } else {
            self.proceed(pending, ctx);
        }
    }

    /// Takes the step that waited.
    fn proceed(&mut self, pending: Pending, ctx: &egui::Context) {
        match pending {
            Pending::AskOpen => self.ask(Asked::Open, ctx),
            Pending::Open(path) => self.enter_document(Document::open(&path)),
            Pending::Shipped(name) => self.enter_document(Document::open_shipped(name)),
            Pending::Tour => {
                if self.document.shipped != Some(Document::SHIPPED) || self.document.history.is_modified() {
                    self.enter_document(Document::open_demo());
                }
                self.begin_tour();
            }
            Pending::AskPublic => self.ask(Asked::Public, ctx),
            Pending::AskRecording => self.ask(Asked::Recording(Purpose::Several), ctx),
            Pending::AskFolder => self.ask(Asked::Recording(Purpose::Folder), ctx),
            Pending::Begin(paths) => self.begin_with(paths, ctx),
            Pending::Quit => {
                self.document.give_up();
                self.leaving = true;
                ctx.send_viewport_cmd(ViewportCommand::Close);
            }
        }
    }

    pub(super) fn enter_document(&mut self, document: Result<Document, String>) {
        match document {
            Ok(document) => {
                self.keep_thumbnail();
                self.document.give_up();
                self.document = document;
                self.tour = None;
                self.message = None;
                self.enter();
                self.look_for_its_work();
            }
            Err(line) => self.complain(line),
        }
    }

    /// Asks for a file.
    pub fn ask(&mut self, asked: Asked, ctx: &egui::Context) {
        let toml = || vec!["toml".to_owned()];
        let (title, purpose, extensions, name) = match &asked {
            Asked::Open => ("Open a session", Purpose::Open, toml(), String::new()),
            Asked::OpenBeside => ("Open a second session", Purpose::Open, toml(), String::new()),
            Asked::Recording(Purpose::Folder) => ("A folder of CSV files", Purpose::Folder, Vec::new(), String::new()),
            Asked::Recording(purpose) => ("A recording", *purpose, recordings(), String::new()),
            Asked::Beside => ("A recording of the same flight", Purpose::Several, recordings(), String::new()),
            Asked::Public => ("The files of the public recording", Purpose::Several, recordings(), String::new()),
            Asked::Aircraft | Asked::OtherAircraft => ("An aircraft file", Purpose::Open, toml(), String::new()),
            Asked::Field(field) => question_of(*field),
            Asked::NewAircraft | Asked::DescribedAircraft => {
                let of_session = || self.state.described_aircraft.as_ref().map(|(name, _)| name.as_str());
                let described = if asked == Asked::NewAircraft { self.described_aircraft() } else { of_session() };
                let name = file_stem(described.unwrap_or_default(), "aircraft");
                ("Save the aircraft", Purpose::Save, toml(), format!("{name}.toml"))
            }
            Asked::OwnAircraft => {
                let name = self.proposed_name();
                let stem = name.strip_suffix(".toml").unwrap_or(&name);
                ("Save the aircraft", Purpose::Save, toml(), format!("{stem}_aircraft.toml"))
            }
            Asked::Instruments => ("Save the instruments", Purpose::Save, toml(), "instruments.toml".to_owned()),
            Asked::Save(_) => ("Save the session", Purpose::Save, toml(), self.proposed_name()),
            Asked::Export => ("Folder for the results", Purpose::Save, Vec::new(), "results".to_owned()),
            Asked::Report => ("Folder for the report", Purpose::Save, Vec::new(), "report".to_owned()),
            Asked::ExportModel => ("Folder for the model", Purpose::Save, Vec::new(), "model".to_owned()),
            Asked::Missing(..) => ("Find the missing recording", Purpose::Open, recordings(), String::new()),
            Asked::Reference => ("Results, a table or a DATCOM listing", Purpose::Open, Vec::new(), String::new()),
            Asked::Figure(form, name) => {
                let extension = form.extension();
                let title = if *form == FigureForm::Csv { "Save the data" } else { "Save the figure" };
                (title, Purpose::Save, vec![extension.to_owned()], format!("{name}.{extension}"))
            }
        };
        let folder = self.start_folder();
        let title = title.to_owned();
        let mut places: Vec<PathBuf> = Vec::new();
        for place in self.state.recent.iter().filter_map(|path| path.parent()).filter(|place| place.is_dir()) {
            if places.len() < MOST_PLACES && !places.iter().any(|known| known == place) {
                places.push(place.to_path_buf());
            }
        }
        self.files.ask(FileQuestion { title, purpose, extensions, folder, name, places }, ctx);
        self.asked = Some(asked);
    }

    /// The folder in which a file is looked for first: that of the new session's recording, of the session, of a session not saved yet
    /// that of its recording, otherwise of the session opened last.
    fn start_folder(&self) -> PathBuf {
        let folder_of = |path: &Path| path.parent().map(Path::to_path_buf).filter(|folder| folder.is_dir());
        let begun = self.begun_from().filter(|_| self.is_beginning());
        let of_session = || self.document.path.is_some().then(|| self.document.folder.clone());
        let recordings = self.document.session().flights.iter().flat_map(|flight| &flight.recordings);
        let recorded = || recordings.map(|recording| Path::new(&recording.path)).find(|path| path.is_absolute());
        begun
            .and_then(folder_of)
            .or_else(of_session)
            .or_else(|| recorded().and_then(folder_of))
            .or_else(|| self.state.recent.iter().find_map(|path| folder_of(path)))
            .unwrap_or_else(|| std::env::current_dir().unwrap_or_default())
    }

    /// Asks where the first recording of the chosen flight is that is not found.
    pub fn ask_missing(&mut self, ctx: &egui::Context) {
        match self.missing_recording() {
            Some((name, index)) => self.ask(Asked::Missing(name, index), ctx),
            None => self.complain("no recording of this flight is missing"),
        }
    }

    /// The first recording of the chosen flight that is not found: name of the flight, place of the recording.
    pub(super) fn missing_recording(&self) -> Option<(String, usize)> {
        let flight = self.document.session().flight(self.state.selection.flight.as_deref()?)?;
        let is_missing = |path: &str| !path.starts_with(builtin::PREFIX) && !self.document.folder.join(path).exists();
        let index = flight.recordings.iter().position(|recording| is_missing(&recording.path))?;
        Some((flight.name.clone(), index))
    }

    /// Name proposed for the file of the session: its own, or its title in letters and digits.
    fn proposed_name(&self) -> String {
        if let Some(name) = self.document.path.as_deref().and_then(Path::file_name) {
            return name.to_string_lossy().into_owned();
        }
        format!("{}.toml", file_stem(&self.document.session().title, "session"))
    }

    /// Goes on once a file was chosen.
    pub(super) fn take_files(&mut self, paths: &[PathBuf], ctx: &egui::Context) {
        let Some(path) = paths.first() else { return };
        match self.asked.take() {
            Some(Asked::Beside) => self.begin_with_more(paths, ctx),
            Some(Asked::Open) => self.proceed(Pending::Open(path.to_path_buf()), ctx),
            Some(Asked::Public) => self.enter_document(public::session(paths).map(Document::start)),
            Some(Asked::OpenBeside) => self.open_beside(path, ctx),
            Some(Asked::Recording(_)) => self.begin_with(paths.to_vec(), ctx),
            Some(Asked::Aircraft) => self.begin_with_aircraft(path),
            Some(Asked::NewAircraft) => self.begin_with_new_aircraft(path),
            Some(Asked::OtherAircraft) => {
                let own = self.as_named(path);
                self.apply(&Edit::Aircraft(AircraftEdit::Use(own)));
            }
            Some(Asked::DescribedAircraft) => self.save_described_aircraft(path),
            Some(Asked::Field(field)) => self.state.picked = Some((field, path.to_path_buf())),
            Some(Asked::OwnAircraft) => self.save_aircraft(path),
            Some(Asked::Instruments) => self.save_instruments(path),
            Some(Asked::Save(after)) => self.save_to(path, after, ctx),
            Some(Asked::Report) => self.report(path, ctx),
            Some(Asked::Export) => self.export(path, ctx),
            Some(Asked::Reference) => match report::reference(path) {
                Ok(reference) => self.references.push(reference),
                Err(line) => self.complain(line),
            },
            Some(Asked::Figure(form, _)) => self.save_figure(form, path),
            Some(Asked::Missing(flight, index)) => {
                let path = path.canonicalize().unwrap_or_else(|_| path.to_path_buf()).display().to_string();
                self.apply(&Edit::RecordingPath { flight, index, path });
            }
            Some(Asked::ExportModel) => self.export_model(path, ctx),
            None => {}
        }
    }

    /// Saves to the session's file, or asks for one; then goes on.
    pub fn save_then(&mut self, after: Option<Pending>, ctx: &egui::Context) {
        match self.document.path.clone().filter(|_| self.document.held_by().is_none()) {
            Some(path) => self.save_to(&path, after, ctx),
            None => self.ask(Asked::Save(after), ctx),
        }
    }

    fn save_to(&mut self, path: &Path, after: Option<Pending>, ctx: &egui::Context) {
        let path = with_ending(path);
        if self.document.path.as_deref() == Some(&path) && self.ask_about_change(after.clone()) {
            return;
        }
        let before = Arc::clone(self.document.history.present());
        match self.document.save(&path) {
            Ok(()) => {
                self.keep_results(&before);
                self.state.remember(&path);
                self.set_message(format!("Saved {}", path.display()));
                if let Some(pending) = after {
                    self.proceed(pending, ctx);
                }
            }
            Err(line) => self.complain(line),
        }
    }

    /// Keeps the results of `before` where saving has changed no path of the session.
    fn keep_results(&mut self, before: &Arc<Session>) {
        let present = self.document.history.present();
        if Arc::ptr_eq(before, present) {
            return;
        }
        "save as".clone_into(&mut self.cause);
        if before == present && self.requested.as_ref().is_some_and(|requested| Arc::ptr_eq(requested, before)) {
            self.requested = Some(Arc::clone(present));
            if self.written.as_ref().is_some_and(|written| Arc::ptr_eq(written, before)) {
                self.written = Some(Arc::clone(present));
            }
        }
    }

    /// Writes the edited aircraft to its own file, which the session uses from then on: one step of undo.
    fn save_aircraft(&mut self, path: &Path) {
        let path = with_ending(path);
        let saved = aircraft::save(self.document.session(), &self.document.folder, &path);
        self.use_saved_aircraft(saved.map(|()| path));
    }

    /// Writes the aircraft that was described, which the session uses from then on: one step of undo.
    fn save_described_aircraft(&mut self, path: &Path) {
        let Some((_, text)) = self.state.described_aircraft.take() else { return };
        self.use_saved_aircraft(save_aircraft_text(path, &text));
    }

    /// The session uses the aircraft that was written, or the window says why it was not.
    fn use_saved_aircraft(&mut self, saved: Result<PathBuf, String>) {
        let path = match saved {
            Ok(path) => path,
            Err(line) => return self.complain(line),
        };
        let own = self.as_named(&path);
        self.apply(&Edit::Aircraft(AircraftEdit::Use(own)));
        self.set_message(format!("Saved {}", path.display()));
    }

    /// Writes the instruments with what was fitted, which the flight on screen uses from then on: one step of undo.
    fn save_instruments(&mut self, path: &Path) {
        let path = with_ending(path);
        let (Some(text), Some(flight)) = (self.state.instruments.take(), self.state.selection.flight.clone()) else {
            return;
        };
        if let Err(line) = calibrate::save(&text, &path) {
            return self.complain(line);
        }
        let file = self.as_named(&path);
        self.apply(&Edit::Signal(SignalEdit::Instruments { flight, file }));
        self.set_message(format!("Saved {}", path.display()));
    }

    /// How the session names a file: from its own folder where that is known, otherwise in full.
    fn as_named(&self, path: &Path) -> String {
        let full = path.canonicalize().unwrap_or_else(|_| path.to_path_buf());
        let folder = self.document.folder.canonicalize().ok().filter(|_| self.document.path.is_some());
        let own = folder.and_then(|folder| full.strip_prefix(folder).map(Path::to_path_buf).ok()).unwrap_or(full);
        own.to_string_lossy().into_owned()
    }

    /// Starts writing what is computed now; what changes meanwhile is not part of it.
    fn export(&mut self, folder: &Path, ctx: &egui::Context) {
        if let Err(error) = report::check_target(folder) {
            return self.complain(error.to_string());
        }
        let (session, snapshot) = (Arc::clone(self.document.history.present()), Arc::clone(&self.snapshot));
        let folder = folder.to_path_buf();
        let work = move |control: &Control, progress: &(dyn Fn(f32) + Sync)| {
            report::write(&session, &snapshot, &folder, &Outputs::default(), control, progress)
                .map_err(|error| error.to_string())
        };
        self.start("doublet-export", work, ctx);
    }

    /// Starts writing the report on what is computed now, under the name of the session's file.
    fn report(&mut self, folder: &Path, ctx: &egui::Context) {
        let (session, snapshot) = (Arc::clone(self.document.history.present()), Arc::clone(&self.snapshot));
        let choice = &self.state.report;
        let name = self.document.path.as_deref().and_then(Path::file_stem).unwrap_or(OsStr::new("report"));
        let style = match self.state.house.style() {
            Ok(style) => style,
            Err(error) => return self.complain(error),
        };
        let sections = self.state.house.sections();
        let order = Order {
            folder: folder.to_path_buf(),
            name: name.to_string_lossy().into_owned(),
            formats: choice.formats.clone(),
            sections: sections.into_iter().filter(|kind| !choice.left_out.contains(kind)).collect(),
            style,
            ..Order::default()
        };
        self.writing = Some(Arc::clone(&session));
        let work = move |control: &Control, progress: &(dyn Fn(f32) + Sync)| {
            doublet_report::write(&session, &snapshot, &order, control, progress)
        };
        self.start("doublet-report", work, ctx);
    }

    /// Starts writing in the background.
    fn start(
        &mut self,
        name: &str,
        work: impl FnOnce(&Control, &(dyn Fn(f32) + Sync)) -> Result<Put, String> + Send + 'static,
        ctx: &egui::Context,
    ) {
        let ctx = ctx.clone();
        match Job::start(name, move || ctx.request_repaint(), work) {
            Ok(job) => self.exporting = Some(job),
            Err(error) => self.complain(format!("nothing can be written: {error}")),
        }
    }

    /// Starts writing the model identified by now.
    fn export_model(&mut self, folder: &Path, ctx: &egui::Context) {
        let (session, snapshot) = (Arc::clone(self.document.history.present()), Arc::clone(&self.snapshot));
        let folder = folder.to_path_buf();
        let work = move |_: &Control, _: &(dyn Fn(f32) + Sync)| {
            let model = IdentifiedModel::new(&session, &snapshot).map_err(|error| error.to_string())?;
            export::write(&model, &Format::ALL, &folder).map_err(|error| error.to_string())
        };
        self.start("doublet-model", work, ctx);
    }

    /// Copies the numbers of figures that were asked for; asks for the file of the last that is to be saved, which waits.
    pub(super) fn take_figures(&mut self, ctx: &egui::Context) {
        let asked = std::mem::take(&mut self.figures).into_iter();
        let (added, others): (Vec<_>, Vec<_>) = asked.partition(|request| request.form == FigureForm::Report);
        let (copied, saved): (Vec<_>, Vec<_>) = others.into_iter().partition(|request| request.form.is_copy());
        for FigureRequest { figure, .. } in added {
            match ReportFigure::from_figure(&figure) {
                Ok(figure) => {
                    self.apply(&Edit::ReportFigure(ReportFigureEdit::Add(figure)));
                    self.set_message("Added to the report: see the panel Report");
                }
                Err(line) => self.complain(line),
            }
        }
        match copied.last() {
            Some(FigureRequest { figure, form: FigureForm::Copy }) => {
                ctx.copy_text(figure::csv(figure));
                self.set_message("Copied the data of the plot");
            }
            Some(FigureRequest { figure, .. }) => match figure::picture(figure) {
                Ok(picture) => {
                    ctx.copy_image(picture);
                    self.set_message("Copied the picture of the plot; Ctrl+Shift+C copies its data");
                }
                Err(line) => self.complain(line),
            },
            None => {}
        }
        if let Some(FigureRequest { figure, form }) = saved.into_iter().next_back() {
            self.ask(Asked::Figure(form, figure.name.clone()), ctx);
            self.figure = Some(figure);
        }
    }

    /// Writes the figure that waits.
    fn save_figure(&mut self, form: FigureForm, path: &Path) {
        let Some(asked) = self.figure.take() else { return };
        let path = if path.extension().is_some() { path.to_path_buf() } else { path.with_extension(form.extension()) };
        let bytes = match form {
            FigureForm::Png | FigureForm::CopyPicture => figure::png(&asked),
            FigureForm::Svg | FigureForm::Report => Ok(doublet_report::svg::svg(&asked, "p").into_bytes()),
            FigureForm::Csv | FigureForm::Copy => Ok(figure::csv(&asked).into_bytes()),
        };
        let place = path.display();
        match bytes.and_then(|bytes| std::fs::write(&path, bytes).map_err(|error| format!("{place}: {error}"))) {
            Ok(()) => self.set_message(format!("Saved {place}")),
            Err(line) => self.complain(line),
        }
    }

    /// Says how writing results ended, once it has.
    pub(super) fn take_export(&mut self) {
        let Some(export) = self.exporting.take_if(|export| export.is_finished()) else { return };
        let written = self.writing.take();
        match export.finish().map_err(String::from) {
            Ok(put) => {
                self.written = written.or(self.written.take());
                let notes: String = put.notes().map(|note| format!("; {note}")).collect();
                self.set_message(format!("Written to {}{notes}", put.folder.display()));
                if let Some(message) = &mut self.message {
                    message.written = Some(put.folder.canonicalize().unwrap_or_else(|_| put.folder.clone()));
                }
            }
            Err(line) => self.complain(line),
        }
    }

    /// Says why the desktop did not open what was written, once it has tried.
    pub(super) fn take_opening(&mut self, ctx: &egui::Context) {
        let Some((path, opening)) = self.opening.take_if(|(_, opening)| opening.is_finished()) else {
            if self.opening.is_some() {
                ctx.request_repaint_after(std::time::Duration::from_millis(200));
            }
            return;
        };
        if !matches!(opening.join(), Ok(Ok(()))) {
            self.complain(format!("No program found for {}: open it yourself", path.display()));
        }
    }

    /// Draws the question for unsaved changes.
    pub(super) fn guard(&mut self, ctx: &egui::Context) {
        let Some(pending) = self.guarded.clone() else { return };
        let mut answer = None;
        egui::Modal::new(egui::Id::unique("unsaved")).show(ctx, |ui| {
            ui.set_width(340.0);
            ui.heading("Save the changes to this session?");
            ui.add_space(4.0);
            ui.label("Otherwise they are lost.");
            ui.add_space(10.0);
            ui.horizontal(|ui| {
                for (name, choice) in [("Save", Some(true)), ("Discard", Some(false)), ("Stay", None)] {
                    // The one that Enter takes is filled.
                    let fill = ui.visuals().selection.bg_fill;
                    let button = egui::Button::new(name);
                    let button = if choice == Some(true) { button.fill(fill) } else { button };
                    if ui.add_sized(vec2(84.0, 26.0), button).clicked() {
                        answer = Some(choice);
                    }
                }
            });
        });
        if ctx.input(|i| i.key_pressed(egui::Key::Escape)) {
            answer = Some(None);
        }
        // Enter saves: nothing is lost by it.
        if ctx.input(|i| i.key_pressed(egui::Key::Enter)) {
            answer = answer.or(Some(Some(true)));
        }
        let Some(answer) = answer else { return };
        self.guarded = None;
        match answer {
            Some(true) => self.save_then(Some(pending), ctx),
            Some(false) => self.proceed(pending, ctx),
            None => {}
        }
    }
}
