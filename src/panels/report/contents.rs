//! The report: its printed pages or one section, the sections it has, and the button that writes it.

use doublet_core::model::{Coefficient, Term};
use doublet_engine::report::document::{Document, Section, SectionKind, build, chosen};
use doublet_engine::session::{Edit, ReportFigure, ReportFigureEdit, Session};
use doublet_engine::{date, report};
use doublet_report::ReportFormat;
use eframe::egui::{self, CollapsingHeader, RichText, ScrollArea, TextEdit, Ui};

use crate::command::{FileCommand, UiCommand};
use crate::notation;
use crate::panels::report::pages::Pages;
use crate::panels::{Panel, PanelContext, caption, choices, text_field};
use crate::ui_state::{HouseStyle, ReportChoice};

/// Width of the list of sections: that of its longest title.
const SECTIONS_WIDTH: f32 = 344.0;
/// Colour of headings unless another is chosen.
const USUAL_ACCENT: [u8; 3] = [0x00, 0x68, 0xb4];
/// Width and height of the name of a flight, and of the fields for its day and crew.
const FLIGHT_NAME: [f32; 2] = [72.0, 22.0];
const LOG_FIELD: [f32; 2] = [92.0, 22.0];

/// How a text is entered: into a flight's log, one line, or several, with a hint.
enum FieldKind<'a> {
    Log(&'a str),
    Line,
    Lines(&'a str),
}

#[derive(Default)]
pub struct Report {
    shown: Option<Shown>,
    /// The text being typed, and the name of its field.
    typed: Option<(String, String)>,
    chosen: Chosen,
    pages: Pages,
}

/// Notes and chosen figures as they are drawn, and what they were made from.
#[derive(Default)]
struct Chosen {
    notes: String,
    figures: Vec<ReportFigure>,
    section: Option<Section>,
}

impl Chosen {
    /// Makes the section anew where the session has another.
    fn keep(&mut self, session: &Session) -> Option<&Section> {
        if self.notes != session.report_notes || self.figures != session.report_figures {
            let (notes, figures) = (session.report_notes.clone(), session.report_figures.clone());
            *self = Self { notes, figures, section: chosen(session) };
        }
        self.section.as_ref()
    }
}

/// The section on screen and what it was made from.
struct Shown {
    generation: u64,
    steps: usize,
    kind: SectionKind,
    document: Document,
}

impl Panel for Report {
    fn show(&mut self, ctx: &mut PanelContext<'_>, ui: &mut Ui) {
        let mut choice = ctx.state.report.clone();
        egui::Panel::left("report sections").resizable(false).exact_size(SECTIONS_WIDTH).show(ui, |ui| {
            if writing(&mut choice, ui) {
                ctx.commands.push(UiCommand::File(FileCommand::Report));
            }
            ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
                sections(&mut choice, &mut ctx.state.house, &self.pages, ui);
                ui.separator();
                house_style(&mut ctx.state.house, ui);
                self.purpose(ctx, ui);
                self.logs(ctx, ui);
                self.notes(ctx, ui);
                self.figures(ctx, ui);
            });
        });
        if !choice.as_pages {
            self.keep(ctx, choice.shown);
        }
        ctx.state.report = choice;
        egui::CentralPanel::default().frame(egui::Frame::NONE.inner_margin(8)).show(ui, |ui| {
            ui.horizontal(|ui| {
                choices(ui, &mut ctx.state.report.as_pages, &[(true, "Pages"), (false, "Contents")]);
                if ctx.state.report.as_pages {
                    self.pages.status(ui);
                }
            });
            if ctx.state.report.as_pages {
                return self.pages.show(ctx, ui);
            }
            let Some(shown) = &self.shown else { return };
            ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
                let chosen = self.chosen.keep(ctx.session).filter(|_| shown.kind == SectionKind::Overview);
                if shown.document.sections.is_empty() {
                    ui.weak("Empty: the report omits this section.");
                }
                for section in chosen.into_iter().chain(&shown.document.sections) {
                    ui.heading(section.title.as_str());
                    ui.push_id(&section.name, |ui| ctx.document(ui, &section.blocks));
                }
            });
        });
    }
}

impl Report {
    /// Day and crew of each flight; a change is one step of undo once the field is left.
    fn logs(&mut self, ctx: &mut PanelContext<'_>, ui: &mut Ui) {
        caption(ui, "Flights");
        for flight in &ctx.session.flights {
            ui.horizontal(|ui| {
                ui.add_sized(FLIGHT_NAME, egui::Label::new(flight.name.as_str()).truncate());
                let recorded = ctx.snapshot.flights.get(&flight.name).and_then(|slot| slot.ready());
                let recorded = recorded.and_then(|loaded| loaded.utc_start_s).and_then(date::format_instant);
                let hint = recorded.as_deref().unwrap_or("date flown");
                let date =
                    self.field(ui, &format!("date of flight {}", flight.name), &flight.date, FieldKind::Log(hint));
                let crew =
                    self.field(ui, &format!("crew of flight {}", flight.name), &flight.crew, FieldKind::Log("crew"));
                if date.is_some() || crew.is_some() {
                    let date = date.unwrap_or_else(|| flight.date.clone());
                    let crew = crew.unwrap_or_else(|| flight.crew.clone());
                    ctx.edit(Edit::FlightLog { flight: flight.name.clone(), date, crew });
                }
            });
        }
    }

    /// A field for a text that is stated; what it says otherwise once it is left: one step of undo.
    fn field(&mut self, ui: &mut Ui, name: &str, stated: &str, kind: FieldKind<'_>) -> Option<String> {
        let typed = self.typed.take_if(|(of, _)| of == name).map(|(_, typed)| typed);
        let mut text = typed.unwrap_or_else(|| stated.to_owned());
        let field = match kind {
            FieldKind::Log(hint) => ui.add_sized(LOG_FIELD, TextEdit::singleline(&mut text).hint_text(hint)),
            FieldKind::Line => ui.add(TextEdit::singleline(&mut text).desired_width(SECTIONS_WIDTH - 72.0)),
            FieldKind::Lines(hint) => {
                let lines = TextEdit::multiline(&mut text).hint_text(hint).desired_rows(3);
                ui.add(lines.desired_width(SECTIONS_WIDTH - 36.0))
            }
        };
        ui.ctx().accesskit_node_builder(field.id, |node| node.set_label(name));
        if field.lost_focus() {
            return (text != stated).then_some(text);
        }
        if field.has_focus() {
            self.typed = Some((name.to_owned(), text));
        }
        None
    }

    /// What the flights were for, and the derivatives that the report answers.
    fn purpose(&mut self, ctx: &mut PanelContext<'_>, ui: &mut Ui) {
        caption(ui, "Purpose");
        let session = ctx.session;
        let hint = FieldKind::Lines("Purpose of the flights: on the first page");
        if let Some(purpose) = self.field(ui, "purpose of the report", &session.report_purpose, hint) {
            ctx.edit(Edit::ReportPurpose(purpose));
        }
        let asked = &session.report_asked;
        let title = format!("Derivatives asked for: {}", asked.len());
        CollapsingHeader::new(title).id_salt("derivatives asked for").show(ui, |ui| {
            let of_model = |(coefficient, terms): &(Coefficient, Vec<Term>)| {
                let moving = terms.iter().filter(|term| !term.is_constant());
                moving.map(|term| term.derivative_name(*coefficient)).collect::<Vec<_>>()
            };
            let model: Vec<Vec<String>> = session.structure.models.iter().map(of_model).collect();
            // A derivative that the model has no longer can be taken back.
            let others = asked.iter().filter(|name| model.iter().flatten().all(|known| known != *name));
            let others: Vec<String> = others.cloned().collect();
            for names in model.iter().chain([&others]) {
                ui.horizontal_wrapped(|ui| names.iter().for_each(|name| ask_for(ctx, ui, name)));
            }
        });
    }

    /// What the author has to say.
    fn notes(&mut self, ctx: &mut PanelContext<'_>, ui: &mut Ui) {
        caption(ui, "Notes");
        let hint = FieldKind::Lines("Notes for the reader");
        if let Some(notes) = self.field(ui, "notes of the report", &ctx.session.report_notes, hint) {
            ctx.edit(Edit::ReportNotes(notes));
        }
    }

    /// The figures that were added, each with its caption, which is one step of undo once it is left.
    fn figures(&mut self, ctx: &mut PanelContext<'_>, ui: &mut Ui) {
        caption(ui, "Chosen figures");
        let session = ctx.session;
        if session.report_figures.is_empty() {
            ui.add(egui::Label::new(RichText::new("Right click on a plot to add it to the report.").weak()).wrap());
        }
        for (at, figure) in session.report_figures.iter().enumerate() {
            ui.horizontal(|ui| {
                if ui.small_button("✖").on_hover_text("Leave it out").clicked() {
                    ctx.edit(Edit::ReportFigure(ReportFigureEdit::Remove(at)));
                }
                let name = format!("caption of figure {}", at + 1);
                if let Some(words) = self.field(ui, &name, &figure.caption, FieldKind::Line) {
                    ctx.edit(Edit::ReportFigure(ReportFigureEdit::Caption(at, words)));
                }
            });
        }
    }

    /// Makes the contents anew when the results or the section have changed.
    fn keep(&mut self, ctx: &PanelContext<'_>, kind: SectionKind) {
        let (generation, steps) = (ctx.snapshot.generation, ctx.snapshot.log.len());
        let current = |shown: &Shown| shown.generation == generation && shown.steps == steps && shown.kind == kind;
        // While results are coming in the last ones stay: they change several times a second.
        if self.shown.as_ref().is_some_and(|shown| current(shown) || (ctx.snapshot.busy && shown.kind == kind)) {
            return;
        }
        let results = report::build(ctx.session, ctx.snapshot);
        let document = build(ctx.session, ctx.snapshot, &results, &[kind], None);
        self.shown = Some(Shown { generation, steps, kind, document });
    }
}

/// The tick of a derivative that may be asked for.
fn ask_for(ctx: &mut PanelContext<'_>, ui: &mut Ui, name: &String) {
    let asked = &ctx.session.report_asked;
    let is_asked = asked.contains(name);
    let label = ui.selectable_label(is_asked, notation::derivative_job(ui, name));
    ui.ctx().accesskit_node_builder(label.id, |node| node.set_label(format!("ask for {name}")));
    if label.clicked() {
        let others = asked.iter().filter(|other| *other != name);
        let added = (!is_asked).then_some(name);
        ctx.edit(Edit::ReportAsked(others.chain(added).cloned().collect()));
    }
}

/// Forms to tick; whether the report is to be written.
fn writing(choice: &mut ReportChoice, ui: &mut Ui) -> bool {
    ui.horizontal(|ui| {
        for format in ReportFormat::ALL {
            let mut wanted = choice.formats.contains(&format);
            if ui.checkbox(&mut wanted, format.name().to_uppercase()).changed() {
                choice.formats.retain(|other| *other != format);
                choice.formats.extend(wanted.then_some(format));
            }
        }
        let possible = !choice.formats.is_empty() && choice.left_out.len() < SectionKind::ALL.len();
        ui.add_enabled(possible, egui::Button::new("Write report…")).clicked()
    })
    .inner
}

/// Logo, words at head and foot, colour, units and signatures.
fn house_style(house: &mut HouseStyle, ui: &mut Ui) {
    CollapsingHeader::new("House style").id_salt("house style").show(ui, |ui| {
        let width = SECTIONS_WIDTH - 72.0;
        text_field(ui, "header of the report", &mut house.header, "Header of every page", width);
        text_field(ui, "footer of the report", &mut house.footer, "Footer of every page", width);
        text_field(ui, "logo of the report", &mut house.logo, "Logo: path of an SVG or PNG file", width);
        choices(ui, &mut house.in_knots_and_feet, &[(false, "m/s and m"), (true, "kt and ft")]);
        ui.horizontal(|ui| {
            ui.label("Colour of headings");
            let mut accent = house.accent.unwrap_or(USUAL_ACCENT);
            if ui.color_edit_button_srgb(&mut accent).changed() {
                house.accent = Some(accent);
            }
            if house.accent.is_some() && ui.small_button("Default").clicked() {
                house.accent = None;
            }
        });
        let lines = TextEdit::multiline(&mut house.signatures).hint_text("Signatures, one per line").desired_rows(2);
        let field = ui.add(lines.desired_width(width));
        ui.ctx().accesskit_node_builder(field.id, |node| node.set_label("signatures of the report"));
    });
}

/// Sections to tick and to move, and the one that is shown.
fn sections(choice: &mut ReportChoice, house: &mut HouseStyle, pages: &Pages, ui: &mut Ui) {
    for kind in house.sections() {
        ui.horizontal(|ui| {
            let up = ui.small_button("↑").on_hover_text("Move up");
            ui.ctx().accesskit_node_builder(up.id, |node| node.set_label(format!("move {} up", kind.name())));
            if up.clicked() {
                house.move_up(kind);
            }
            let mut wanted = !choice.left_out.contains(&kind);
            let tick = ui.checkbox(&mut wanted, "");
            ui.ctx().accesskit_node_builder(tick.id, |node| node.set_label(format!("report {}", kind.name())));
            if tick.changed() {
                if wanted {
                    choice.left_out.remove(&kind)
                } else {
                    choice.left_out.insert(kind)
                };
            }
            let is_empty = pages.is_empty(kind);
            let title = RichText::new(kind.title());
            let title = if is_empty { title.weak().italics() } else { title };
            let mut label = ui.selectable_label(!choice.as_pages && choice.shown == kind, title);
            if is_empty {
                label = label.on_hover_text("Empty: the report omits this section");
            }
            if label.clicked() {
                (choice.shown, choice.as_pages) = (kind, false);
            }
        });
    }
}
