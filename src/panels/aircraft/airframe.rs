//! The aircraft to scale from above and from the side, with all masses and sensors to drag or type; and the weighing for its centre of
//! gravity.

use eframe::egui::{Label, RichText, Ui};

use crate::panels::aircraft::aircraft_editor::{self, AircraftEditor};
use crate::panels::aircraft::weighing::Weighing;
use crate::panels::{Panel, PanelContext, awaiting, choices, trouble};

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
}

impl Panel for Airframe {
    fn show(&mut self, ctx: &mut PanelContext<'_>, ui: &mut Ui) {
        let snapshot = ctx.snapshot;
        let (Some(read), Some(loaded)) = (snapshot.aircraft.latest(), snapshot.loaded.latest()) else {
            trouble(ui, snapshot.aircraft.error());
            aircraft_editor::way_back(ctx, ui);
            let why = match ctx.session.aircraft {
                Some(_) => "The aircraft could not be read.",
                None => "No aircraft is chosen: only flight paths are computed.",
            };
            return awaiting(ctx, ui, "the aircraft", why);
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
