//! The numbers of one part of the aircraft, each typed or dragged with its unit.

use doublet_core::airframe::AircraftError;
use doublet_core::quantity::Dimension;
use doublet_engine::aircraft::{AircraftField, ChangedValue, FieldUnit, PlaceKind, Section};
use doublet_engine::session::{AircraftEdit, Edit};
use eframe::egui::{self, Align, Grid, Layout, RichText, ScrollArea, TextEdit, Ui};

use crate::panels::{PanelContext, caption};
use crate::widgets::EditPhase;
use crate::widgets::quantity_edit::QuantityEdit;
use crate::{notation, theme};

/// Keys with their first values.
type FirstValues = &'static [(&'static str, f64)];

/// What can be made new in a part, and the keys beside its place that it cannot do without.
const NEW: [(Section, PlaceKind, FirstValues); 4] = [
    (Section::Stations, PlaceKind::Tank, &[("capacity_kg", 50.0)]),
    (Section::Stations, PlaceKind::Seat, &[]),
    (Section::Stations, PlaceKind::Luggage, &[]),
    (Section::Mass, PlaceKind::Fixed, &[("mass_kg", 1.0)]),
];

/// Draws the fields of a part, with what can be made new below them.
pub(crate) fn show(
    ctx: &mut PanelContext<'_>,
    ui: &mut Ui,
    (section, fields): (Section, &[&AircraftField]),
    (chosen, reveal): (Option<&str>, bool),
    new_name: &mut String,
) {
    ScrollArea::vertical().id_salt("numbers of the aircraft").auto_shrink(false).show(ui, |ui| {
        ui.spacing_mut().item_spacing.y = 3.0;
        let mut owner = None;
        for (at, field) in fields.iter().enumerate() {
            if owner.replace(field.owner.as_str()) != Some(field.owner.as_str()) {
                heading(ctx, ui, field, &fields[at..]);
            }
            let is_chosen = chosen == Some(field.key.as_str());
            let row = row(ctx, ui, field, is_chosen);
            if is_chosen && reveal {
                row.scroll_to_me(Some(Align::Center));
            }
        }
        add_new(ctx, ui, section, fields, new_name);
    });
}

/// What has the fields below, and a way to leave it out.
fn heading(ctx: &mut PanelContext<'_>, ui: &mut Ui, field: &AircraftField, rest: &[&AircraftField]) {
    if field.owner.is_empty() {
        return;
    }
    let of_owner = rest.iter().take_while(|other| other.owner == field.owner);
    let key = of_owner.into_iter().find_map(|other| other.owner_key());
    ui.add_space(3.0);
    ui.horizontal(|ui| {
        caption(ui, &field.owner.replace('_', " "));
        let Some(key) = key else { return };
        let name = format!("leave out {}", field.owner);
        let out = ui.small_button("×").on_hover_text(format!("Leave out {}", field.owner.replace('_', " ")));
        ui.ctx().accesskit_node_builder(out.id, |node| node.set_label(name.as_str()));
        if out.clicked() {
            ctx.edit(Edit::Aircraft(AircraftEdit::set(field.owner.clone(), key, ChangedValue::Removed)));
        }
    });
}

fn row(ctx: &mut PanelContext<'_>, ui: &mut Ui, field: &AircraftField, is_chosen: bool) -> egui::Response {
    let problem = problem(ctx, field);
    ui.horizontal_wrapped(|ui| {
        let name = if field.name == "place" { "place, datum axes" } else { field.name };
        let color = if is_chosen { theme::palette(ui).accent } else { egui::Color32::PLACEHOLDER };
        let text = notation::typeset_in(name, 12.0, color);
        let size = egui::vec2(150.0, ui.spacing().interact_size.y);
        ui.allocate_ui_with_layout(size, Layout::left_to_right(Align::Center), |ui| {
            ui.set_width(size.x);
            ui.add(egui::Label::new(text).truncate());
        });
        match &field.value {
            Some(value) => values(ctx, ui, field, value, problem.as_deref()),
            None => {
                let name = format!("state {}", field.title());
                let state = ui.small_button("state").on_hover_text("Not in the file");
                ui.ctx().accesskit_node_builder(state.id, |node| node.set_label(name.as_str()));
                if state.clicked() {
                    let edit = AircraftEdit::set(field.title(), &field.key, field.proposal.clone());
                    ctx.edit(Edit::Aircraft(edit));
                }
            }
        }
        if field.changed {
            let name = format!("restore {}", field.title());
            let back = ui.small_button("↺").on_hover_text("Changed in the session: return to the file value");
            ui.ctx().accesskit_node_builder(back.id, |node| node.set_label(name.as_str()));
            if back.clicked() {
                ctx.edit(Edit::Aircraft(AircraftEdit::Restore(field.key.clone())));
            }
        }
    })
    .response
}

/// What the check of the aircraft says of a field: the range that is allowed.
fn problem(ctx: &PanelContext<'_>, field: &AircraftField) -> Option<String> {
    let is_of_field = |error: &&AircraftError| {
        let rest = error.field().strip_prefix(&field.key);
        rest.is_some_and(|rest| rest.is_empty() || rest.starts_with(['.', '[']))
    };
    Some(match ctx.snapshot.aircraft_errors.iter().find(is_of_field)? {
        AircraftError::OutOfRange { allowed, .. } => format!("must be {allowed}"),
        _ => "see above".to_owned(),
    })
}

/// Unit and factor of a field on screen.
fn unit(ctx: &PanelContext<'_>, unit: FieldUnit) -> (&'static str, f64) {
    match unit {
        FieldUnit::Of(Dimension::Dimensionless) => ("", 1.0),
        FieldUnit::Of(dimension) => ctx.unit(dimension),
        FieldUnit::Area => ("m²", 1.0),
        FieldUnit::Inertia => ("kg m²", 1.0),
        FieldUnit::Degrees => ("deg", 1.0),
    }
}

/// One field, or one beside the other.
fn values(ctx: &mut PanelContext<'_>, ui: &mut Ui, field: &AircraftField, value: &ChangedValue, problem: Option<&str>) {
    let (symbol, scale) = unit(ctx, field.unit);
    let one = |name: &str, value: f64, unit: (&'static str, f64), problem: Option<&str>, ui: &mut Ui| {
        let per_point = if matches!(field.unit, FieldUnit::Of(Dimension::Length)) { 0.005 } else { 0.1 };
        QuantityEdit::new(name, value).unit(unit.0, unit.1).per_point(per_point).problem(problem).show(ui)
    };
    let title = field.title();
    let edit = |value: ChangedValue| Edit::Aircraft(AircraftEdit::set(title.clone(), &field.key, value));
    match value {
        ChangedValue::Number(number) => {
            let edited = one(&title, *number, (symbol, scale), problem, ui);
            ctx.edit_quantity(edited, |value| edit(ChangedValue::Number(value)));
        }
        ChangedValue::Triple(triple) => {
            for (axis, letter) in ["x", "y", "z"].into_iter().enumerate() {
                ui.label(RichText::new(letter).size(11.0).weak());
                let unit = (if axis == 2 { symbol } else { "" }, scale);
                let problem = problem.filter(|_| axis == 2);
                let edited = one(&format!("{title} {letter}"), triple[axis], unit, problem, ui);
                let mut next = *triple;
                edited.iter().for_each(|edited| next[axis] = edited.value);
                ctx.edit_quantity(edited, |_| edit(ChangedValue::Triple(next)));
            }
        }
        ChangedValue::Rows(rows) => envelope(ctx, ui, field, rows),
        ChangedValue::Removed => {}
    }
}

/// Rows of the envelope: mass, forward and aft limit.
fn envelope(ctx: &mut PanelContext<'_>, ui: &mut Ui, field: &AircraftField, rows: &[[f64; 3]]) {
    let (length, scale) = ctx.unit(Dimension::Length);
    let mut asked: Option<(EditPhase, Vec<[f64; 3]>)> = None;
    ui.vertical(|ui| {
        Grid::new("rows of the envelope").num_columns(4).spacing([6.0, 3.0]).show(ui, |ui| {
            for title in ["mass".to_owned(), "forward x".to_owned(), "aft x".to_owned()] {
                ui.label(RichText::new(title).size(11.0).weak());
            }
            ui.end_row();
            for (at, row) in rows.iter().enumerate() {
                let columns =
                    [("mass", "kg", 1.0, 0.5), ("forward x", length, scale, 0.002), ("aft x", length, scale, 0.002)];
                for (column, (name, unit, scale, per_point)) in columns.into_iter().enumerate() {
                    let name = format!("envelope {} {name}", at + 1);
                    let field = QuantityEdit::new(&name, row[column]).unit(unit, scale).per_point(per_point);
                    if let Some(edited) = field.show(ui) {
                        let mut next = rows.to_vec();
                        next[at][column] = edited.value;
                        asked = Some((edited.phase, next));
                    }
                }
                let out = ui.add_enabled(rows.len() > 1, egui::Button::new("×").small());
                if out.on_hover_text("Remove this row").clicked() {
                    let next = rows.iter().enumerate().filter(|(other, _)| *other != at).map(|(_, row)| *row);
                    asked = Some((EditPhase::Commit, next.collect()));
                }
                ui.end_row();
            }
        });
        if ui.small_button("Add row").clicked()
            && let Some(last) = rows.last()
        {
            let next = rows.iter().copied().chain([[1.1 * last[0], last[1], last[2]]]);
            asked = Some((EditPhase::Commit, next.collect()));
        }
    });
    if let Some((phase, rows)) = asked {
        ctx.edit_phase(phase, Edit::Aircraft(AircraftEdit::set(field.title(), &field.key, ChangedValue::Rows(rows))));
    }
}

/// A name and the kinds of what can be made under it.
fn add_new(ctx: &mut PanelContext<'_>, ui: &mut Ui, section: Section, fields: &[&AircraftField], name: &mut String) {
    let kinds: Vec<_> = NEW.into_iter().filter(|(own, ..)| *own == section).collect();
    if kinds.is_empty() {
        return;
    }
    ui.add_space(6.0);
    ui.horizontal_wrapped(|ui| {
        let typed = ui.add(TextEdit::singleline(name).hint_text("name of a new one").desired_width(130.0));
        ui.ctx().accesskit_node_builder(typed.id, |node| node.set_label("name of a new part"));
        for (_, kind, needed) in kinds {
            let Some(list) = kind.list() else { continue };
            let key = format!("{list}.{}", name.trim());
            let is_free = !fields.iter().any(|field| field.owner_key() == Some(key.as_str()));
            let usable = !name.trim().is_empty() && !name.contains('.') && is_free;
            let button = ui.add_enabled(usable, egui::Button::new(format!("Add {}", kind.name())));
            let hint = "Type a unique name without a dot";
            if !button.on_disabled_hover_text(hint).clicked() {
                continue;
            }
            let middle = ctx.snapshot.loaded.latest().map_or([0.0; 3], |loaded| loaded.properties.cg_from_datum_m);
            let middle = middle.map(|value| crate::widgets::quantity_edit::to_decimals(value, 2));
            let mut values = vec![(format!("{key}.cg_datum_m"), ChangedValue::Triple(middle))];
            values.extend(needed.iter().map(|(own, value)| (format!("{key}.{own}"), ChangedValue::Number(*value))));
            let what = format!("{} {}", kind.name(), name.trim());
            ctx.edit(Edit::Aircraft(AircraftEdit::Set { what, values }));
            name.clear();
        }
    });
}
