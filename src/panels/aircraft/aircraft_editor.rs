//! The aircraft as it is edited: two views to scale, what follows, and the numbers of one part below.

use doublet_core::airframe::frames::datum_from_body;
use doublet_core::airframe::{Aircraft, LoadedState};
use doublet_core::quantity::Dimension;
use doublet_engine::aircraft::{AircraftField, ChangedValue, PlaceKind, Section, ShapePart, fields, shape};
use doublet_engine::session::{AircraftEdit, Edit};
use eframe::egui::text::{LayoutJob, TextFormat};
use eframe::egui::{self, Color32, FontId, Label, RichText, Ui, vec2};

use crate::command::{FileCommand, UiCommand};
use crate::notation;
use crate::panels::aircraft::aircraft_numbers;
use crate::panels::aircraft::loading::{selected_mass, station};
use crate::panels::{PanelContext, choices, trouble};
use crate::theme::{self, Palette};
use crate::widgets::scale_view::{Handle, Outline, ScaleView, Symbol, Touched};

/// Part of the height that the views have.
const VIEWS: f32 = 0.46;

/// The parts and their names.
const SECTIONS: [(Section, &str); 6] = [
    (Section::Geometry, "Geometry"),
    (Section::Mass, "Mass"),
    (Section::Inertia, "Inertia"),
    (Section::Stations, "Tanks and seats"),
    (Section::Places, "Sensors"),
    (Section::Limits, "Limits"),
];

#[derive(Default)]
pub(crate) struct AircraftEditor {
    section: Section,
    /// Key of the field that was pointed at.
    chosen: Option<String>,
    /// Whether its row is still to be brought on screen.
    reveal: bool,
    /// Name typed for a new part.
    new_name: String,
}

/// Offers the aircraft as its file says, where it cannot be read with the session's changes.
pub(crate) fn way_back(ctx: &mut PanelContext<'_>, ui: &mut Ui) {
    let changes = &ctx.session.aircraft_changes;
    if changes.is_empty() {
        return;
    }
    let name = match changes.len() {
        1 => "Take back 1 change".to_owned(),
        count => format!("Undo {count} edits"),
    };
    let back = ui.button(name).on_hover_text("Return to the aircraft file; Undo restores the edits");
    if back.clicked() {
        ctx.edit(Edit::Aircraft(AircraftEdit::RestoreAll));
    }
}

impl AircraftEditor {
    pub(crate) fn show(&mut self, ctx: &mut PanelContext<'_>, ui: &mut Ui, aircraft: &Aircraft, loaded: &LoadedState) {
        let fields = fields(aircraft, &ctx.session.aircraft_changes);
        ui.horizontal_wrapped(|ui| {
            let save = ui.button("Save aircraft as…").on_hover_text("Save to a new file and use it in the session");
            if save.clicked() {
                ctx.commands.push(UiCommand::File(FileCommand::SaveAircraft));
            }
            way_back(ctx, ui);
        });
        trouble(ui, ctx.snapshot.aircraft.error());
        // As the panel Loading has it: with the fuel of the first record, where a flight is read.
        let flown = selected_mass(ctx);
        let loaded = flown.map_or(loaded, |flown| &flown.start.state);
        follows(ctx, ui, loaded, if flown.is_some() { "at the start" } else { "as loaded" });
        self.views(ctx, ui, aircraft, (loaded, &fields));
        if choices(ui, &mut self.section, &SECTIONS) {
            self.chosen = None;
        }
        let own: Vec<&AircraftField> = fields.iter().filter(|field| field.section == self.section).collect();
        let chosen = self.chosen.as_deref();
        let reveal = std::mem::take(&mut self.reveal);
        aircraft_numbers::show(ctx, ui, (self.section, &own), (chosen, reveal), &mut self.new_name);
    }

    /// From above and from the side.
    fn views(
        &mut self,
        ctx: &mut PanelContext<'_>,
        ui: &mut Ui,
        aircraft: &Aircraft,
        (loaded, fields): (&LoadedState, &[AircraftField]),
    ) {
        let palette = theme::palette(ui);
        let (unit, scale) = ctx.unit(Dimension::Length);
        let height = (VIEWS * ui.available_height()).max(120.0);
        let placed: Vec<(&AircraftField, [f64; 3])> = fields.iter().filter_map(placed).collect();
        legend(ui, &placed, palette);
        ui.columns(2, |columns| {
            for (ui, (name, axis, up)) in
                columns.iter_mut().zip([("from above", 1, "y right"), ("from the side", 2, "z up")])
            {
                let flat = |at: &[f64; 3]| [at[0], at[axis]];
                let mut handles: Vec<Handle> =
                    placed.iter().map(|(field, at)| handle(field, flat(at), palette)).collect();
                handles.extend(fixed(aircraft, loaded, palette).into_iter().map(|(name, at, symbol, color)| Handle {
                    name: name.to_owned(),
                    at: flat(&at),
                    symbol,
                    color,
                    movable: false,
                }));
                let chosen = self.chosen.as_deref();
                let view = ScaleView {
                    name,
                    labels: [format!("x aft [{unit}]"), format!("{up} [{unit}]")],
                    scale,
                    outlines: &outlines(aircraft, loaded, axis, palette),
                    handles: &handles,
                    selected: placed.iter().position(|(field, _)| Some(field.key.as_str()) == chosen),
                };
                let (touched, figure) = view.show(ui, vec2(ui.available_width(), height));
                ctx.figures.extend(figure);
                self.take(ctx, touched, &placed, axis);
            }
        });
    }

    /// Turns what was done in a view into edits; one drag is one step of undo.
    fn take(
        &mut self,
        ctx: &mut PanelContext<'_>,
        touched: Option<Touched>,
        placed: &[(&AircraftField, [f64; 3])],
        axis: usize,
    ) {
        let (Some(Touched::Chosen(index)) | Some(Touched::Dragged(index, ..))) = touched else { return };
        let Some((field, at)) = placed.get(index) else { return };
        self.reveal = self.chosen.as_ref() != Some(&field.key);
        self.chosen = Some(field.key.clone());
        self.section = field.section;
        if let Some(Touched::Dragged(_, phase, [x, other])) = touched {
            let mut to = *at;
            (to[0], to[axis]) = (x, other);
            let edit = AircraftEdit::set(field.title(), &field.key, ChangedValue::Triple(to));
            ctx.edit_phase(phase, Edit::Aircraft(edit));
        }
    }
}

/// A field that is a place, with where it is.
fn placed(field: &AircraftField) -> Option<(&AircraftField, [f64; 3])> {
    match (field.place, &field.value) {
        (Some(_), Some(ChangedValue::Triple(at))) => Some((field, *at)),
        _ => None,
    }
}

/// Symbol and colour of a kind of place.
fn look(kind: PlaceKind, palette: &Palette) -> (Symbol, Color32) {
    match kind {
        PlaceKind::Empty => (Symbol::Ring, palette.cursor),
        PlaceKind::Fixed => (Symbol::Square, palette.ignored),
        PlaceKind::Group => (Symbol::Disc, palette.ignored),
        PlaceKind::Tank => (Symbol::Square, palette.series[1]),
        PlaceKind::Seat => (Symbol::Disc, palette.series[0]),
        PlaceKind::Luggage => (Symbol::Square, palette.series[6]),
        PlaceKind::Engine => (Symbol::Diamond, palette.series[5]),
        PlaceKind::Sensor => (Symbol::Triangle, palette.series[2]),
        PlaceKind::Reference => (Symbol::Ring, palette.series[3]),
    }
}

fn handle(field: &AircraftField, at: [f64; 2], palette: &Palette) -> Handle {
    let (symbol, color) = field.place.map_or((Symbol::Disc, palette.ignored), |kind| look(kind, palette));
    Handle { name: field.owner.clone(), at, symbol, color, movable: true }
}

/// What follows or stands for itself: the centre of gravity on board, the wheels.
fn fixed(
    aircraft: &Aircraft,
    loaded: &LoadedState,
    palette: &Palette,
) -> Vec<(&'static str, [f64; 3], Symbol, Color32)> {
    let mut all = Vec::new();
    if let Some(wheels) = &aircraft.wheels {
        let ink = palette.series[7];
        all.push(("nose wheel", [wheels.nose_x_m, 0.0, 0.0], Symbol::Disc, ink));
        all.push(("right wheel", [wheels.main_x_m, wheels.main_y_m, 0.0], Symbol::Disc, ink));
        all.push(("left wheel", [wheels.main_x_m, -wheels.main_y_m, 0.0], Symbol::Disc, ink));
    }
    all.push(("CG on board", loaded.properties.cg_from_datum_m, Symbol::Quartered, palette.error));
    all
}

/// The kinds of places there are, each with its symbol's colour.
fn legend(ui: &mut Ui, placed: &[(&AircraftField, [f64; 3])], palette: &Palette) {
    let mut kinds: Vec<PlaceKind> = placed.iter().filter_map(|(field, _)| field.place).collect();
    kinds.sort_unstable();
    kinds.dedup();
    ui.horizontal_wrapped(|ui| {
        ui.spacing_mut().item_spacing.x = 8.0;
        let mut entry = |name: &str, color: Color32| {
            ui.label(RichText::new(format!("● {name}")).size(11.0).color(color));
        };
        entry("CG on board", palette.error);
        for kind in kinds {
            entry(kind.name(), look(kind, palette).1);
        }
    });
}

/// Fuselage and tail, drawn from span, chord and length alone.
fn sketch(aircraft: &Aircraft, axis: usize, palette: &Palette) -> Vec<Outline> {
    let cg = aircraft.empty.cg_from_datum_m;
    let parts = shape(aircraft, cg, [0.0; 3]).into_iter();
    let parts = parts.filter(|outline| matches!(outline.part, ShapePart::Body | ShapePart::Tail));
    let flat = |corner: [f64; 3]| {
        let at = datum_from_body(corner, cg);
        [at[0], at[axis]]
    };
    let outline =
        |corners: Vec<[f64; 3]>| Outline { corners: corners.into_iter().map(flat).collect(), color: palette.grid };
    parts.map(|part| outline(part.corners)).collect()
}

/// The wing from above, and the limits of the centre of gravity at the mass on board, in either view.
fn outlines(aircraft: &Aircraft, loaded: &LoadedState, axis: usize, palette: &Palette) -> Vec<Outline> {
    let mut outlines = sketch(aircraft, axis, palette);
    let wing = if axis == 1 { wing(aircraft) } else { Vec::new() };
    if !wing.is_empty() {
        outlines.push(Outline { corners: wing, color: palette.ignored });
    }
    if let Some(margin) = &loaded.envelope {
        let at = loaded.properties.cg_from_datum_m;
        let (forward, aft) = (at[0] - margin.forward_m, at[0] + margin.aft_m);
        let half = 0.05 * aircraft.reference.span_m;
        let color = if margin.inside() { palette.good } else { palette.error };
        let [low, high] = [at[axis] - half, at[axis] + half];
        outlines.push(Outline { corners: vec![[forward, low], [aft, low], [aft, high], [forward, high]], color });
    }
    outlines
}

/// Corners of the wing as seen from above: along the leading edges of both halves and back along the trailing edges. Without panels a
/// rectangle of span and chord, a quarter of it ahead of the empty centre of gravity.
fn wing(aircraft: &Aircraft) -> Vec<[f64; 2]> {
    let reference = &aircraft.reference;
    if aircraft.wing_panels.is_empty() {
        let leading = aircraft.empty.cg_from_datum_m[0] - 0.25 * reference.chord_m;
        let (half, trailing) = (0.5 * reference.span_m, leading + reference.chord_m);
        return vec![[leading, -half], [leading, half], [trailing, half], [trailing, -half]];
    }
    let (mut leading, mut trailing) = (Vec::new(), Vec::new());
    for panel in &aircraft.wing_panels {
        let tip = panel.root_y_m + panel.semispan_m;
        leading.extend([[panel.root_leading_edge_x_m, panel.root_y_m], [panel.tip_leading_edge_x_m, tip]]);
        trailing.extend([
            [panel.root_leading_edge_x_m + panel.root_chord_m, panel.root_y_m],
            [panel.tip_leading_edge_x_m + panel.taper * panel.root_chord_m, tip],
        ]);
    }
    let mirrored = |corner: &[f64; 2]| [corner[0], -corner[1]];
    let right = leading.iter().copied().chain(trailing.iter().rev().copied());
    right.chain(trailing.iter().map(mirrored)).chain(leading.iter().rev().map(mirrored)).collect()
}

/// Unit of moments of inertia, which no line breaks.
const INERTIA: &str = "kg\u{a0}m²";

/// Mass, centre of gravity and inertia, and when that is.
fn follows(ctx: &PanelContext<'_>, ui: &mut Ui, loaded: &LoadedState, when: &str) {
    let (unit, scale) = ctx.unit(Dimension::Length);
    let properties = &loaded.properties;
    let [x, z] = [0, 2].map(|axis| station(loaded, axis, scale));
    let chord = loaded
        .mean_chord_fraction
        .map_or(String::new(), |part| format!(" ({} % MAC)", notation::fixed(100.0 * part, 1)));
    let inertia = &properties.inertia;
    let [xx, yy, zz, xz] =
        [inertia.xx, inertia.yy, inertia.zz, inertia.xz].map(|value| notation::four_digits(value, 0));
    ui.horizontal_wrapped(|ui| {
        if ctx.snapshot.loaded.is_stale() {
            ui.multiply_opacity(0.5);
        }
        ui.spacing_mut().item_spacing.x = 4.0;
        let figures = theme::figures(ui);
        for (name, value, unit) in [
            (when, notation::four_digits(properties.mass_kg, 1), "kg".to_owned()),
            ("CG x", x, format!("{unit}{chord}")),
            ("CG z", z, unit.to_owned()),
            ("Ixx", xx, INERTIA.to_owned()),
            ("Iyy", yy, INERTIA.to_owned()),
            ("Izz", zz, INERTIA.to_owned()),
            ("Ixz", xz, INERTIA.to_owned()),
        ] {
            // One label, so that a line does not end between a name and its value.
            let mut job = LayoutJob::default();
            let small = TextFormat::simple(FontId::proportional(11.5), ui.visuals().weak_text_color());
            let figure = TextFormat::simple(FontId::new(12.0, figures.family.clone()), ui.visuals().text_color());
            job.append(name, 0.0, small.clone());
            job.append(&value, 4.0, figure);
            job.append(&unit, 4.0, small);
            ui.add(Label::new(job).extend());
            ui.add_space(4.0);
        }
    })
    .response
    .on_hover_text("At the fuel of the first record; the derivatives update");
    let inside = loaded.envelope.is_none_or(|margin| margin.inside());
    if !inside {
        ui.colored_label(
            theme::palette(ui).error,
            egui::RichText::new("The loaded CG is outside the envelope.").size(11.5),
        );
    }
}
