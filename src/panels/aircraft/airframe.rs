//! The aircraft to scale from above and from the side, with all masses and sensors to drag or type; and the weighing for its centre of
//! gravity.

use doublet_engine::builtin;
use doublet_engine::session::{AircraftEdit, Edit};
use eframe::egui::{Button, ComboBox, Label, RichText, Ui};

use crate::command::{FileCommand, UiCommand};
use crate::panels::aircraft::aircraft_editor::{self, AircraftEditor};
use crate::panels::aircraft::weighing::Weighing;
use crate::panels::{NO_AIRCRAFT, Panel, PanelContext, awaiting, choices, trouble};
use crate::widgets::aircraft_form::{AircraftForm, shipped_name};

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Aspect {
    #[default]
    Editor,
    Weighing,
}

#[derive(Default)]
pub struct Airframe {
    aspect: Aspect,
    editor: AircraftEditor,
    weighing: Weighing,
    /// The aircraft being described for a session without one.
    form: Option<AircraftForm>,
}

impl Panel for Airframe {
    fn show(&mut self, ctx: &mut PanelContext<'_>, ui: &mut Ui) {
        let snapshot = ctx.snapshot;
        let (Some(read), Some(loaded)) = (snapshot.aircraft.latest(), snapshot.loaded.latest()) else {
            trouble(ui, snapshot.aircraft.error());
            aircraft_editor::way_back(ctx, ui);
            if ctx.session.aircraft.is_none() {
                return self.choose(ctx, ui);
            }
            if snapshot.aircraft.error().is_some() {
                ask_file(ctx, ui);
            }
            return awaiting(ctx, ui, "the aircraft", "The aircraft could not be read.");
        };
        let aircraft = &read.aircraft;
        ui.horizontal_wrapped(|ui| {
            choices(ui, &mut self.aspect, &[(Aspect::Editor, "Editor"), (Aspect::Weighing, "Weighing")]);
            ui.add(Label::new(RichText::new(&aircraft.name).strong()).truncate());
        });
        match self.aspect {
            Aspect::Editor => self.editor.show(ctx, ui, aircraft, loaded),
            Aspect::Weighing => self.weighing.show(ctx, ui, aircraft),
        }
    }
}

impl Airframe {
    /// The aircraft of a session without one: shipped, a file, or a few numbers.
    fn choose(&mut self, ctx: &mut PanelContext<'_>, ui: &mut Ui) {
        ui.label(NO_AIRCRAFT);
        ui.weak("Derivatives need its mass, inertia and reference area.");
        ui.add_space(6.0);
        ui.horizontal_wrapped(|ui| {
            let combo =
                ComboBox::from_id_salt("aircraft of the session").selected_text("Shipped aircraft…").width(220.0);
            let combo = combo.show_ui(ui, |ui| {
                for name in builtin::aircraft() {
                    if ui.selectable_label(false, shipped_name(name)).clicked() {
                        ctx.edit(Edit::Aircraft(AircraftEdit::Use(format!("{}{name}", builtin::PREFIX))));
                    }
                }
            });
            ui.ctx().accesskit_node_builder(combo.response.id, |node| node.set_label("shipped aircraft"));
            ask_file(ctx, ui);
            let own = ui.button("Describe aircraft…");
            if own.on_hover_text("Area, span, chord, mass and inertia make an aircraft file").clicked() {
                self.form = Some(AircraftForm::default());
            }
        });
        let Some(form) = &mut self.form else { return };
        ui.add_space(6.0);
        form.show(ui);
        let mut is_given_up = false;
        ui.horizontal(|ui| {
            let text = form.text();
            if ui.add_enabled(text.is_ok(), Button::new("Save the aircraft…")).clicked()
                && let Ok(text) = text
            {
                ctx.state.described_aircraft = Some((form.name().to_owned(), text));
                ctx.commands.push(UiCommand::File(FileCommand::SaveDescribedAircraft));
            }
            is_given_up = ui.button("Not now").clicked();
        });
        if is_given_up {
            self.form = None;
        }
    }
}

/// The button that asks for an aircraft file.
fn ask_file(ctx: &mut PanelContext<'_>, ui: &mut Ui) {
    if ui.button("Aircraft file…").on_hover_text("An aircraft file of your own").clicked() {
        ctx.commands.push(UiCommand::File(FileCommand::UseAircraft));
    }
}
