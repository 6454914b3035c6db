//! Every manoeuvre and candidate plotted over any two of flight condition, input, fit and consistency; select by click, lasso or keys.

use std::collections::BTreeSet;
use std::sync::Arc;

use doublet_engine::report::document::{Axis, Figure, LineStyle, Mark, Panel as FigurePanel, Plot};
use doublet_engine::report::{MapOf, MapQuantity, MapRow, manoeuvre_map};
use doublet_engine::session::{CandidateEdit, Edit, Manoeuvre, WindowEdit, WindowRole};
use doublet_engine::stage::{FlightProposals, open_windows};
use doublet_engine::verdict::{Level, Verdicts};
use eframe::egui::{self, ComboBox, Key, Modifiers, RichText, Sense, Ui, vec2};

use crate::command::{EditCommand, UiCommand};
use crate::notation;
use crate::panels::manoeuvres::manoeuvre_list::{bulk_buttons, menu};
use crate::panels::{Panel, PanelContext, awaiting, empty, select};
use crate::ui_state::{CandidateKey, key_of};
use crate::widgets::chart::figure_menu;
use crate::widgets::figure::{FigureRequest, printed};
use crate::widgets::level_mark;
use crate::widgets::scatter::{Scatter, ScatterDone, ScatterMark, ScatterPlot, hollow};

/// Half the size of a mark: usual, least and most.
const RADIUS: [f32; 3] = [5.5, 3.5, 11.0];
/// Width of the choices of quantities.
const CHOICE: f32 = 176.0;
/// Width of the choice of the size of marks: all three stand in one row of a narrow window.
const SIZE_CHOICE: f32 = 132.0;
/// Height of the plot over its width in a figure.
const SHAPE: f64 = 0.6;
/// Width of a figure, mm.
const WIDTH_MM: f64 = 160.0;

/// What the rows follow from; they are formed again where it differs.
#[derive(Clone)]
struct Source {
    windows: Vec<Manoeuvre>,
    verdicts: Option<Arc<Verdicts>>,
    proposals: Vec<Arc<FlightProposals>>,
    run: (u64, bool),
}

impl Source {
    fn from_panel(ctx: &PanelContext<'_>) -> Self {
        let snapshot = ctx.snapshot;
        Self {
            windows: ctx.session.windows.clone(),
            verdicts: snapshot.verdicts.latest().cloned(),
            proposals: snapshot.proposals.values().filter_map(|slot| slot.latest().cloned()).collect(),
            run: (snapshot.generation, snapshot.busy),
        }
    }

    fn is_same(&self, ctx: &PanelContext<'_>) -> bool {
        let snapshot = ctx.snapshot;
        let verdicts = match (&self.verdicts, snapshot.verdicts.latest()) {
            (Some(own), Some(now)) => Arc::ptr_eq(own, now),
            (own, now) => own.is_none() && now.is_none(),
        };
        let mut now = snapshot.proposals.values().filter_map(|slot| slot.latest());
        let proposals = self.proposals.iter().all(|own| now.next().is_some_and(|now| Arc::ptr_eq(own, now)));
        let run = (snapshot.generation, snapshot.busy);
        verdicts && proposals && now.next().is_none() && self.run == run && self.windows == ctx.session.windows
    }
}

/// Rows with the candidates they are of.
struct Rows {
    source: Source,
    rows: Vec<MapRow>,
    /// Candidate of each row; none of a manoeuvre of the session.
    candidates: Vec<Option<Manoeuvre>>,
    /// Quantities that any row has.
    quantities: Vec<MapQuantity>,
}

pub struct ManoeuvreMap {
    axes: [MapQuantity; 2],
    size: Option<MapQuantity>,
    rows: Option<Rows>,
    scatter: Scatter,
}

impl Default for ManoeuvreMap {
    fn default() -> Self {
        Self {
            axes: [MapQuantity::Airspeed, MapQuantity::AngleOfAttack],
            size: None,
            rows: None,
            scatter: Scatter::default(),
        }
    }
}

impl Panel for ManoeuvreMap {
    fn show(&mut self, ctx: &mut PanelContext<'_>, ui: &mut Ui) {
        if ctx.session.flights.is_empty() {
            return empty(ui, "The session has no flight.");
        }
        let rows = match self.rows.take().filter(|rows| rows.source.is_same(ctx)) {
            Some(rows) => rows,
            None => Rows::collect(ctx),
        };
        if rows.rows.is_empty() {
            self.rows = Some(rows);
            return awaiting(ctx, ui, "manoeuvres", "No manoeuvre: drag with Ctrl in a plot of the flight to add one.");
        }
        self.choices(ui, &rows);
        let is_open = |one: &&Manoeuvre| !ctx.session.has_refused(one);
        let open: BTreeSet<CandidateKey> = rows.candidates.iter().flatten().filter(is_open).map(key_of).collect();
        ctx.state.selection.candidates.retain(|key| open.contains(key));
        Self::actions(ctx, ui, &rows);
        self.plot(ctx, ui, &rows);
        self.rows = Some(rows);
    }
}

impl Rows {
    fn collect(ctx: &PanelContext<'_>) -> Self {
        let (session, snapshot) = (ctx.session, ctx.snapshot);
        let rows = manoeuvre_map(session, snapshot, MapOf::Latest);
        let proposals = session.flights.iter().filter_map(|flight| snapshot.proposals.get(&flight.name)?.latest());
        let open: Vec<Manoeuvre> = proposals.flat_map(|found| open_windows(session, found)).collect();
        let candidate = |row: &MapRow| {
            let is_it = |one: &&Manoeuvre| one.flight == row.flight && one.name == row.name;
            open.iter().filter(|_| row.is_candidate()).find(is_it).cloned()
        };
        let candidates = rows.iter().map(candidate).collect();
        let is_known = |quantity: &MapQuantity| rows.iter().any(|row| quantity.value(row).is_some());
        let quantities = MapQuantity::all().into_iter().filter(is_known).collect();
        Self { source: Source::from_panel(ctx), rows, candidates, quantities }
    }

    /// The selected candidates.
    fn chosen(&self, ctx: &PanelContext<'_>) -> Vec<Manoeuvre> {
        self.candidates.iter().flatten().filter(|one| ctx.selection().has_candidate(one)).cloned().collect()
    }
}

/// A quantity with its unit.
fn title(ctx: &PanelContext<'_>, quantity: MapQuantity) -> String {
    match ctx.unit(quantity.dimension()).0 {
        "" => quantity.title(),
        unit => format!("{} [{unit}]", quantity.title()),
    }
}

/// A value in the unit it is shown in.
fn shown_value(ctx: &PanelContext<'_>, quantity: MapQuantity, value: f64) -> String {
    let (unit, scale) = ctx.unit(quantity.dimension());
    let gap = if unit.is_empty() { "" } else { " " };
    format!("{}: {}{gap}{unit}", quantity.title(), notation::number(scale * value))
}

/// What a mark is called.
fn label(row: &MapRow) -> String {
    match (row.is_candidate(), row.level) {
        (true, _) => format!("candidate {}", row.name),
        (false, level) => format!("mark {}: {}", row.name, level.map_or("not judged", Level::name)),
    }
}

impl ManoeuvreMap {
    /// The quantities drawn, and what the marks mean.
    fn choices(&mut self, ui: &mut Ui, rows: &Rows) {
        ui.horizontal_wrapped(|ui| {
            let [across, up] = &mut self.axes;
            for (name, quantity) in [("x axis", across), ("y axis", up)] {
                ui.label(name);
                let combo =
                    ComboBox::from_id_salt(("map", name)).selected_text(quantity.title()).width(CHOICE).truncate();
                let combo = combo.show_ui(ui, |ui| {
                    for choice in &rows.quantities {
                        ui.selectable_value(quantity, *choice, choice.title());
                    }
                });
                ui.ctx().accesskit_node_builder(combo.response.id, |node| node.set_label(format!("map {name}")));
            }
            ui.label("Size");
            let shown = self.size.map_or("equal".to_owned(), MapQuantity::title);
            let combo = ComboBox::from_id_salt(("map", "size")).selected_text(shown).width(SIZE_CHOICE).truncate();
            let combo = combo.show_ui(ui, |ui| {
                ui.selectable_value(&mut self.size, None, "equal");
                for choice in &rows.quantities {
                    ui.selectable_value(&mut self.size, Some(*choice), choice.title());
                }
            });
            ui.ctx().accesskit_node_builder(combo.response.id, |node| node.set_label("map size of marks"));
        });
        ui.horizontal_wrapped(|ui| {
            for level in [Some(Level::Good), Some(Level::Caution), Some(Level::Bad), None] {
                level_mark::level_mark(ui, level);
                ui.weak(level.map_or("not judged", Level::name));
            }
            let (rect, _) = ui.allocate_exact_size(vec2(14.0, 14.0), Sense::hover());
            hollow(ui.painter(), rect.center(), 5.0, ui.visuals().text_color());
            ui.weak("candidate");
            ui.separator();
            ui.weak("Drag around marks to select them");
        });
    }

    /// What is done to everything selected.
    fn actions(ctx: &mut PanelContext<'_>, ui: &mut Ui, rows: &Rows) {
        let count = ctx.selection().windows(ctx.session).count();
        ui.add_enabled_ui(count > 0, |ui| {
            ui.horizontal_wrapped(|ui| {
                bulk_buttons(ctx, ui, count);
                if count == 1 && ui.button("rename").on_hover_text("F2").clicked() {
                    ctx.commands.push(UiCommand::Edit(EditCommand::RenameWindow));
                }
            });
        });
        let open = rows.candidates.iter().flatten().filter(|one| !ctx.session.has_refused(one)).count();
        if open == 0 {
            return;
        }
        let count = ctx.state.selection.candidates.len();
        ui.horizontal_wrapped(|ui| {
            ui.weak(format!("{count} of {open} candidates selected:"));
            ui.add_enabled_ui(count > 0, |ui| {
                if ui.button("accept").on_hover_text("Y").clicked() {
                    Self::accept(ctx, rows);
                }
                if ui.button("refuse").on_hover_text("N").clicked() {
                    Self::refuse(ctx, rows);
                }
            });
        });
    }

    /// Adds the selected candidates to the session in one step of undo, and selects them.
    fn accept(ctx: &mut PanelContext<'_>, rows: &Rows) {
        let added: Vec<Manoeuvre> = rows.chosen(ctx);
        let Some(first) = added.first() else { return };
        ctx.state.selection.window = Some(first.name.clone());
        ctx.state.selection.flight = Some(first.flight.clone());
        ctx.state.selection.others = added[1..].iter().map(|one| one.name.clone()).collect();
        ctx.edit(Edit::Window(WindowEdit::AddAll(added)));
        ctx.state.selection.candidates.clear();
    }

    /// Refuses the selected candidates.
    fn refuse(ctx: &mut PanelContext<'_>, rows: &Rows) {
        let refused: Vec<Manoeuvre> = rows.chosen(ctx);
        if !refused.is_empty() {
            ctx.edit(Edit::Candidate(CandidateEdit::Refuse(refused)));
        }
        ctx.state.selection.candidates.clear();
    }

    fn plot(&mut self, ctx: &mut PanelContext<'_>, ui: &mut Ui, rows: &Rows) {
        let is_shown = |at: usize| rows.candidates[at].as_ref().is_none_or(|one| !ctx.session.has_refused(one));
        let known: Vec<(usize, [f64; 2])> = (0..rows.rows.len())
            .filter(|&at| is_shown(at))
            .filter_map(|at| {
                let [x, y] = self.axes.map(|quantity| quantity.value(&rows.rows[at]));
                let [across, up] = self.axes.map(|quantity| ctx.unit(quantity.dimension()).1);
                Some((at, [across * x?, up * y?]))
            })
            .collect();
        let missing = (0..rows.rows.len()).filter(|&at| is_shown(at)).count() - known.len();
        let marks = self.marks(ctx, rows, &known);
        let titles = self.axes.map(|quantity| title(ctx, quantity));
        let note = if missing > 0 { 20.0 } else { 0.0 };
        let plot = ScatterPlot {
            name: "manoeuvre map",
            titles: titles.each_ref().map(String::as_str),
            marks: &marks,
            height: ui.available_height() - note,
        };
        let mut done = self.scatter.show(ui, &plot);
        if missing > 0 {
            ui.weak(format!("{missing} without a value on these axes"));
        }
        for (at, response) in std::mem::take(&mut done.pointed) {
            let (row, candidate) = (&rows.rows[known[at].0], rows.candidates[known[at].0].as_ref());
            Self::mark_menu(ctx, &response, (row, candidate), rows);
            response.on_hover_ui(|ui| self.describe(ctx, ui, row));
        }
        let of_marks: Vec<usize> = known.iter().map(|(at, _)| *at).collect();
        Self::follow(ctx, rows, &of_marks, &done);
        if done.has_focus {
            Self::keys(ctx, ui, rows);
            self.draw_focus_line(ctx, ui, &done, self.scatter.at().and_then(|at| rows.rows.get(*of_marks.get(at)?)));
        }
        if let Some(form) = figure_menu(&done.response) {
            ctx.figures.push(FigureRequest { figure: figure(ui, &titles, &marks, &done), form });
        }
    }

    /// The marks of the rows that are known.
    fn marks(&self, ctx: &PanelContext<'_>, rows: &Rows, known: &[(usize, [f64; 2])]) -> Vec<ScatterMark> {
        let [usual, least, most] = RADIUS;
        let size = |at: usize| self.size?.value(&rows.rows[at]).filter(|size| size.is_finite());
        let sizes = || known.iter().filter_map(|(at, _)| size(*at));
        let (low, high) = (sizes().fold(f64::INFINITY, f64::min), sizes().fold(f64::NEG_INFINITY, f64::max));
        let radius = |at: usize| match self.size {
            None => usual,
            Some(_) => size(at).filter(|_| high > low).map_or(least, |size| {
                // Areas are compared, not widths.
                least + (most - least) * ((size - low) / (high - low)).sqrt() as f32
            }),
        };
        let mark = |&(at, place): &(usize, [f64; 2])| {
            let row = &rows.rows[at];
            let is_selected = match &rows.candidates[at] {
                Some(candidate) => ctx.selection().has_candidate(candidate),
                None => ctx.selection().is_selected(&row.name),
            };
            ScatterMark {
                at: place,
                level: row.level,
                is_hollow: row.is_candidate(),
                is_selected,
                radius: radius(at),
                label: label(row),
                value: self.coordinates(ctx, row),
            }
        };
        known.iter().map(mark).collect()
    }

    /// What a pause over a mark shows.
    fn describe(&self, ctx: &PanelContext<'_>, ui: &mut Ui, row: &MapRow) {
        ui.label(RichText::new(&row.name).strong());
        let level = row.level.map_or("not judged", Level::name);
        let input = [row.surface.unwrap_or_default(), row.kind.as_str()].join(" ");
        ui.label(match row.is_candidate() {
            true => format!("candidate, {}", input.trim()),
            false => format!("{}, {level}, {}", row.role, input.trim()).trim_end_matches(", ").to_owned(),
        });
        let also = [MapQuantity::Confidence, MapQuantity::Start, MapQuantity::Duration];
        let mut named: Vec<MapQuantity> = self.axes.into_iter().chain(self.size).collect();
        named.extend(also.into_iter().filter(|also| !self.axes.contains(also) && self.size != Some(*also)));
        for quantity in named {
            if let Some(value) = quantity.value(row) {
                ui.label(shown_value(ctx, quantity, value));
            }
        }
    }

    /// The values of a mark along both axes, with their units.
    fn coordinates(&self, ctx: &PanelContext<'_>, row: &MapRow) -> String {
        let values = self.axes.into_iter().filter_map(|axis| Some(shown_value(ctx, axis, axis.value(row)?)));
        values.collect::<Vec<_>>().join(", ")
    }

    /// The mark the arrow keys are at, in a line at the foot of the plot.
    fn draw_focus_line(&self, ctx: &PanelContext<'_>, ui: &Ui, done: &ScatterDone, row: Option<&MapRow>) {
        let text = row.map_or("Arrow keys: go to a mark".to_owned(), |row| {
            format!("{}: {}. Space selects, Shift+Space adds", label(row), self.coordinates(ctx, row))
        });
        let (at, color) = (done.frame.left_bottom() + vec2(6.0, -4.0), ui.visuals().strong_text_color());
        ui.painter().text(at, egui::Align2::LEFT_BOTTOM, text, egui::FontId::proportional(11.0), color);
    }

    /// The menu of a mark: that of its manoeuvre, or the two answers to a candidate.
    fn mark_menu(
        ctx: &mut PanelContext<'_>,
        response: &egui::Response,
        (row, candidate): (&MapRow, Option<&Manoeuvre>),
        rows: &Rows,
    ) {
        response.context_menu(|ui| match candidate {
            None => {
                if let Some(window) = ctx.session.window(&row.name) {
                    menu(ctx, ui, window);
                }
            }
            Some(candidate) => {
                if !ctx.selection().has_candidate(candidate) {
                    ctx.state.selection.candidates = BTreeSet::from([key_of(candidate)]);
                }
                ui.weak(notation::plural(ctx.state.selection.candidates.len(), "candidate"));
                if ui.button("Accept").clicked() {
                    Self::accept(ctx, rows);
                    ui.close();
                }
                if ui.button("Refuse").clicked() {
                    Self::refuse(ctx, rows);
                    ui.close();
                }
            }
        });
    }

    /// Selects what was clicked or enclosed.
    fn follow(ctx: &mut PanelContext<'_>, rows: &Rows, of_marks: &[usize], done: &ScatterDone) {
        if let Some((at, modifiers)) = done.clicked {
            Self::click(ctx, rows, of_marks[at], modifiers);
        }
        let Some((enclosed, modifiers)) = &done.enclosed else { return };
        let adds = modifiers.shift || modifiers.command;
        if !adds {
            ctx.state.selection.candidates.clear();
        }
        let all: Vec<usize> = enclosed.iter().map(|&at| of_marks[at]).collect();
        ctx.state.selection.candidates.extend(all.iter().filter_map(|&at| rows.candidates[at].as_ref().map(key_of)));
        let mut names = all.iter().filter(|&&at| rows.candidates[at].is_none()).map(|&at| rows.rows[at].name.clone());
        if !adds || ctx.selection().window.is_none() {
            let Some(first) = names.next() else { return };
            ctx.choose(&first);
        }
        let chosen = ctx.selection().window.clone();
        ctx.state.selection.others.extend(names.filter(|name| Some(name) != chosen.as_ref()));
    }

    /// Selects one mark alone, or beside the others with Shift or Ctrl; once more takes it out.
    fn click(ctx: &mut PanelContext<'_>, rows: &Rows, at: usize, modifiers: Modifiers) {
        let adds = modifiers.shift || modifiers.command;
        match &rows.candidates[at] {
            None => {
                if !adds {
                    ctx.state.selection.candidates.clear();
                }
                // On a map there is no order that Shift could go along.
                let modifiers = if adds { Modifiers::COMMAND } else { Modifiers::NONE };
                select(ctx.state, ctx.session, &rows.rows[at].name, modifiers);
            }
            Some(candidate) => {
                let key = key_of(candidate);
                if adds {
                    if !ctx.state.selection.candidates.remove(&key) {
                        ctx.state.selection.candidates.insert(key);
                    }
                } else {
                    ctx.state.selection.candidates = BTreeSet::from([key]);
                }
                ctx.state.selection.flight = Some(candidate.flight.clone());
                ctx.state.candidate_s = Some(candidate.window.start_s);
                ctx.state.time.reveal(candidate.window);
            }
        }
    }

    /// The keys of manoeuvres and candidates while the keyboard is at the plot, where the program's own shortcuts rest.
    fn keys(ctx: &mut PanelContext<'_>, ui: &Ui, rows: &Rows) {
        let edits = [
            (Key::I, EditCommand::UseWindows(WindowRole::Identification)),
            (Key::V, EditCommand::UseWindows(WindowRole::Validation)),
            (Key::X, EditCommand::UseWindows(WindowRole::Ignored)),
            (Key::Delete, EditCommand::RemoveWindow),
        ];
        let pressed = |key: Key| ui.input(|input| input.modifiers.is_none() && input.key_pressed(key));
        let asked = edits.into_iter().filter(|(key, _)| pressed(*key));
        ctx.commands.extend(asked.map(|(_, command)| UiCommand::Edit(command)));
        if pressed(Key::Y) {
            Self::accept(ctx, rows);
        }
        if pressed(Key::N) {
            Self::refuse(ctx, rows);
        }
    }
}

/// What is on screen as a figure.
fn figure(ui: &Ui, titles: &[String; 2], marks: &[ScatterMark], done: &ScatterDone) -> Figure {
    let points = |label: &str, colour: egui::Color32, holds: &dyn Fn(&ScatterMark) -> bool| Mark::Points {
        label: label.to_owned().into(),
        colour: printed(colour),
        style: LineStyle::Dots,
        points: marks.iter().filter(|mark| holds(mark)).map(|mark| [mark.at[0], mark.at[1], f64::NAN]).collect(),
    };
    let levels = [Some(Level::Good), Some(Level::Caution), Some(Level::Bad), None];
    let of_level = |level: Option<Level>| {
        let name = level.map_or("not judged", Level::name);
        points(name, level_mark::color(ui, level), &move |mark| !mark.is_hollow && mark.level == level)
    };
    let candidates = points("candidate", ui.visuals().text_color(), &|mark| mark.is_hollow);
    let is_drawn = |mark: &Mark| matches!(mark, Mark::Points { points, .. } if !points.is_empty());
    let axis = |at: usize| Axis { range: Some([done.range[0][at], done.range[1][at]]), ..Axis::new(&titles[at], "") };
    let marks = levels.into_iter().map(of_level).chain([candidates]).filter(is_drawn).collect();
    Figure::new(
        "manoeuvre_map",
        format!("{} over {}", titles[1], titles[0]),
        (1, SHAPE * WIDTH_MM),
        vec![FigurePanel::Plot(Plot { x: axis(0), y: axis(1), marks })],
    )
}
