//! Channels by expression in the list of channels: the dialog that makes and changes one, and the menu of one.

use doublet_core::quantity::{Role, Unit};
use doublet_engine::session::{EXPRESSION_SOURCE, Edit, ExpressionEdit, ExpressionSetting};
use doublet_engine::stage::{LoadedFlight, expression_preview};
use eframe::egui::{self, ComboBox, Grid, Id, Key, Popup, Response, RichText, TextEdit, Ui};

use crate::panels::PanelContext;
use crate::{notation, theme};

/// What can be written, in short.
const HINT: &str = "Roles by name (alpha, v_north), channels in quotes (\"source/name\"), + - * / ^, sin cos tan asin acos atan atan2 \
                    sqrt abs exp ln min max, pi, g0. Roles are in SI and radians.";

/// A channel being written.
pub struct Draft {
    flight: String,
    /// Present name of the one being changed.
    from: Option<String>,
    setting: ExpressionSetting,
    /// Its first value, or what is wrong, as of the last letter; `None` while it was not looked at.
    preview: Option<Result<Option<f64>, String>>,
}

impl Draft {
    /// A new channel of a flight.
    pub fn new(flight: &str) -> Self {
        Self { flight: flight.to_owned(), from: None, setting: ExpressionSetting::default(), preview: None }
    }

    fn from_setting(flight: &str, setting: &ExpressionSetting) -> Self {
        Self { from: Some(setting.name.clone()), setting: setting.clone(), ..Self::new(flight) }
    }

    fn edit(&self) -> Edit {
        let (flight, from) = (self.flight.clone(), self.from.clone());
        Edit::Expression(ExpressionEdit { flight, from, to: Some(self.setting.clone()) })
    }

    /// Whether the session would take it, and its first value in what is loaded.
    fn look(&self, ctx: &PanelContext<'_>, loaded: Option<&LoadedFlight>) -> Result<Option<f64>, String> {
        self.edit().apply(ctx.session).map_err(|error| error.to_string())?;
        loaded.map_or(Ok(None), |loaded| Ok(expression_preview(loaded, self.from.as_deref(), &self.setting)?))
    }
}

/// Name by which plots remember a channel by expression.
fn key(setting: &ExpressionSetting) -> String {
    setting.role.map_or_else(|| format!("{EXPRESSION_SOURCE}/{}", setting.name), |role| role.name().to_owned())
}

/// Edit and remove, on a secondary click on a channel by expression.
pub fn menu(
    ctx: &mut PanelContext<'_>,
    row: &Response,
    flight: &str,
    made: &ExpressionSetting,
    draft: &mut Option<Draft>,
) {
    Popup::context_menu(row).show(|ui| choices(ctx, ui, flight, made, draft));
}

fn choices(ctx: &mut PanelContext<'_>, ui: &mut Ui, flight: &str, made: &ExpressionSetting, draft: &mut Option<Draft>) {
    if ui.button(format!("Edit {}…", made.name)).clicked() {
        *draft = Some(Draft::from_setting(flight, made));
        ui.close();
    }
    if ui.button(format!("Remove {}", made.name)).clicked() {
        ctx.edit(Edit::Expression(ExpressionEdit {
            flight: flight.to_owned(),
            from: Some(made.name.clone()),
            to: None,
        }));
        ui.close();
    }
}

/// Edit and remove for every expression of a flight that could not be computed.
pub fn mend(ctx: &mut PanelContext<'_>, ui: &mut Ui, flight: &str, draft: &mut Option<Draft>) {
    let session = ctx.session;
    for made in session.flight(flight).iter().flat_map(|flight| &flight.expressions) {
        ui.horizontal(|ui| choices(ctx, ui, flight, made, draft));
    }
}

/// The dialog, while there is a draft. What is added is plotted.
pub fn dialog(
    ctx: &mut PanelContext<'_>,
    ui: &Ui,
    loaded: Option<&LoadedFlight>,
    draft: &mut Option<Draft>,
    plots: &mut Vec<Vec<String>>,
) {
    let Some(open) = draft else { return };
    let (mut taken, mut closed) = (false, false);
    let modal = egui::Modal::new(Id::unique("expression")).show(ui.ctx(), |ui| {
        ui.set_width(520.0);
        ui.heading(if open.from.is_some() { "Channel by expression" } else { "New channel by expression" });
        let before = open.setting.clone();
        let grid = Grid::new("expression").num_columns(2).spacing([12.0, 6.0]);
        let confirmed = grid.show(ui, |ui| fields(ui, &mut open.setting)).inner;
        if open.preview.is_none() || open.setting != before {
            open.preview = Some(open.look(ctx, loaded));
        }
        ui.add_space(4.0);
        let untouched = open.setting == ExpressionSetting::default();
        let fits = matches!(open.preview, Some(Ok(_)));
        let unit = &open.setting.unit;
        let line = match &open.preview {
            _ if untouched => RichText::new(HINT).weak(),
            Some(Ok(Some(value))) => RichText::new(format!("first value {} {unit}", notation::number(*value))),
            Some(Err(line)) => RichText::new(line).color(theme::palette(ui).error),
            _ => RichText::new("all samples are empty").color(theme::palette(ui).warning),
        };
        ui.add(egui::Label::new(line).wrap());
        ui.add_space(6.0);
        ui.horizontal(|ui| {
            let name = if open.from.is_some() { "Change channel" } else { "Add channel" };
            taken = ui.add_enabled(fits, egui::Button::new(name)).clicked();
            taken |= fits && confirmed;
            closed = ui.button("Cancel").clicked();
        });
    });
    if taken {
        let (was, now) = (open.from.as_ref().map(|name| format!("{EXPRESSION_SOURCE}/{name}")), key(&open.setting));
        ctx.edit(open.edit());
        plots
            .iter_mut()
            .flatten()
            .filter(|other| Some(&**other) == was.as_ref())
            .for_each(|other| other.clone_from(&now));
        if !plots.iter().flatten().any(|other| *other == now) {
            plots.push(vec![now]);
        }
    }
    if taken || closed || modal.should_close() {
        *draft = None;
    }
}

/// Name, unit, expression, role; whether Enter was pressed in a text.
fn fields(ui: &mut Ui, setting: &mut ExpressionSetting) -> bool {
    let mut confirmed = false;
    let rows = [
        ("Name", "channel name", "ground speed", &mut setting.name),
        ("Unit", "channel unit", "m/s", &mut setting.unit),
        ("Expression", "channel expression", "sqrt(v_north^2 + v_east^2)", &mut setting.expression),
    ];
    for (title, label, hint, text) in rows {
        ui.weak(title);
        let field = ui.add(TextEdit::singleline(text).hint_text(hint).desired_width(400.0));
        ui.ctx().accesskit_node_builder(field.id, |node| node.set_label(label));
        confirmed |= field.lost_focus() && ui.input(|input| input.key_pressed(Key::Enter));
        ui.end_row();
    }
    ui.weak("Role").on_hover_text("Replaces the recorded channel of this role");
    let name = |role: Option<Role>| role.map_or("none", |role| notation::role(role));
    let dimension = Unit::parse(&setting.unit).ok().map(|unit| unit.dimension);
    let combo = ComboBox::from_id_salt("role").selected_text(name(setting.role)).width(180.0).show_ui(ui, |ui| {
        ui.selectable_value(&mut setting.role, None, name(None));
        for role in Role::ALL.iter().copied().filter(|role| Some(role.dimension()) == dimension) {
            ui.selectable_value(&mut setting.role, Some(role), name(Some(role))).on_hover_text(role.description());
        }
    });
    ui.ctx().accesskit_node_builder(combo.response.id, |node| node.set_label("channel role"));
    ui.end_row();
    confirmed
}
