//! Noise settings and initial uncertainty of the filter.

use doublet_core::quantity::Dimension;
use doublet_core::reconstruct::consistency::ChannelConsistency;
use doublet_core::reconstruct::{AirState, FilterSettings, Input, Measurement, State};
use doublet_engine::session::{Edit, FilterEdit, NoiseChannel, NoiseEdit, NoiseEntry};
use doublet_engine::stage::NoiseRow;
use eframe::egui::containers::menu::{MenuButton, MenuConfig};
use eframe::egui::{self, CollapsingHeader, Grid, RichText, ScrollArea, Ui};

use crate::panels::filter::{filter_settings, noise_advice};
use crate::panels::{Panel, PanelContext, caption, consistency_color};
use crate::widgets::quantity_edit::QuantityEdit;
use crate::widgets::term::column_title;
use crate::{notation, theme};

/// Width from which the two tables of noise stand side by side.
const SIDE_BY_SIDE: f32 = 720.0;
/// Factor between a proposal and what the steady parts show beyond which it is marked.
const FAR: f64 = 3.0;

/// Widths of a field, its unit, and a proposal with its warning sign, points.
const FIELD: f32 = 78.0;
const UNIT: f32 = 44.0;
pub(super) const PROPOSAL: f32 = 92.0;

pub struct Noise;

/// One row of a table of deviations.
struct Row<'a> {
    name: String,
    symbol: &'a str,
    about: &'a str,
    dimension: Dimension,
    value: f64,
    usual: f64,
    mark: Option<&'a ChannelConsistency>,
    /// What the steady parts of the recording say.
    recorded: Option<&'a NoiseRow>,
}

impl Panel for Noise {
    fn show(&mut self, ctx: &mut PanelContext<'_>, ui: &mut Ui) {
        ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
            filter_settings::show(ctx, ui);
            observability(ctx, ui);
            nothing_proposed(ctx, ui);
            ui.add_space(6.0);
            let usual = FilterSettings::default();
            if ui.available_width() < SIDE_BY_SIDE {
                inputs(ctx, ui, &usual);
                ui.add_space(8.0);
                measurements(ctx, ui, &usual);
                ui.add_space(8.0);
                initial(ctx, ui, &usual);
                sensors(ctx, ui, &usual);
                return;
            }
            ui.columns(2, |columns| {
                inputs(ctx, &mut columns[0], &usual);
                columns[0].add_space(8.0);
                initial(ctx, &mut columns[0], &usual);
                sensors(ctx, &mut columns[0], &usual);
                measurements(ctx, &mut columns[1], &usual);
            });
        });
    }
}

/// What the columns of the tables of noise are.
fn header(ui: &mut Ui, measured: bool) {
    let titles = ["", "used", "", "proposed", "innovations"];
    let shown = if measured { 5 } else { 4 };
    for (at, title) in titles.into_iter().enumerate().take(shown) {
        column_title(ui, title);
        // The proposal takes two cells: its button and its reason.
        if at == 3 {
            ui.label("");
        }
    }
    ui.end_row();
}

/// Whether the chosen window tells every state, and which it does not.
fn observability(ctx: &PanelContext<'_>, ui: &mut Ui) {
    let (Some(window), Some(results)) = (ctx.window(), ctx.results()) else { return };
    let Some(path) = results.path.latest() else { return };
    let (observability, palette) = (&path.assessment().observability, theme::palette(ui));
    ui.horizontal_wrapped(|ui| {
        let color = if observability.hidden.is_empty() { palette.good } else { palette.warning };
        let text = format!(
            "{}: observability rank {} of {}",
            window.name,
            observability.rank.min(observability.open),
            observability.open
        );
        ui.label(RichText::new(text).color(color))
            .on_hover_text("Number of unknown states that are observable at the middle of this manoeuvre");
        if !observability.hidden.is_empty() {
            let names: Vec<_> = observability.hidden.iter().map(|state| notation::state(*state)).collect();
            let label = ui.label(RichText::new(format!("not observable: {}", names.join(", "))).color(palette.warning));
            label.on_hover_text("Not observable in this manoeuvre: these states keep their initial values");
        }
        for weak in &observability.weak {
            let text = format!("weak: {} {:.0} %", notation::state(weak.state), 100.0 * weak.remaining);
            ui.label(RichText::new(text).color(palette.warning)).on_hover_text(format!(
                "{:.0} % of the initial standard deviation of {} remains; correlated with {} ({})",
                100.0 * weak.remaining,
                notation::state(weak.state),
                notation::state(weak.partner),
                notation::correlation(weak.correlation)
            ));
        }
    });
}

/// Noise of the inertial sensors.
fn inputs(ctx: &mut PanelContext<'_>, ui: &mut Ui, usual: &FilterSettings) {
    caption(ui, "Process noise √Q (inertial sensors)");
    Grid::new("process noise").num_columns(4).spacing([6.0, 3.0]).show(ui, |ui| {
        header(ui, false);
        for input in Input::ALL {
            let values = [&ctx.session.filter.process_noise, &usual.process_noise].map(|all| all[input as usize]);
            let words = [notation::role(input.role()), input.description()];
            let row = Row::new(format!("Q {}", input.name()), words, input.dimension(), values);
            let row = Row { recorded: recorded(ctx, NoiseChannel::Input(input)), ..row };
            row.show(ctx, ui, |value| Edit::noise(NoiseChannel::Input(input), value));
        }
    });
}

/// Noise of the measurements, with what the innovations of the chosen window say about each.
fn measurements(ctx: &mut PanelContext<'_>, ui: &mut Ui, usual: &FilterSettings) {
    caption(ui, "Measurement noise √R");
    let path = ctx.results().and_then(|results| results.path.latest());
    Grid::new("measurement noise").num_columns(5).spacing([6.0, 3.0]).show(ui, |ui| {
        header(ui, true);
        for measurement in Measurement::ALL {
            let index = measurement as usize;
            let channels =
                path.and_then(|path| path.assessment().consistency.as_ref()).map(|consistency| &consistency.channels);
            let channel = channels.into_iter().flatten().find(|channel| channel.measurement == measurement);
            let values = [&ctx.session.filter.measurement_noise, &usual.measurement_noise].map(|all| all[index]);
            let words = [notation::measurement(measurement), measurement.description()];
            let row = Row::new(format!("R {}", measurement.name()), words, measurement.dimension(), values);
            let row = Row { mark: channel, recorded: recorded(ctx, NoiseChannel::Measurement(measurement)), ..row };
            row.show(ctx, ui, |value| Edit::noise(NoiseChannel::Measurement(measurement), value));
        }
    });
}

/// Initial deviations and random walks.
fn initial(ctx: &mut PanelContext<'_>, ui: &mut Ui, usual: &FilterSettings) {
    CollapsingHeader::new("Initial deviation √P₀").show(ui, |ui| {
        Grid::new("initial deviation").num_columns(3).spacing([6.0, 3.0]).show(ui, |ui| {
            for state in State::ALL {
                let all = [&ctx.session.filter.initial_deviation, &usual.initial_deviation];
                let row = Row::of_state(format!("P {}", state.name()), state, all);
                row.show(ctx, ui, |value| Edit::Filter(FilterEdit::InitialDeviation(state, value)));
            }
        });
    });
    CollapsingHeader::new("Random walk, per √s").show(ui, |ui| {
        Grid::new("random walk").num_columns(3).spacing([6.0, 3.0]).show(ui, |ui| {
            for &state in &State::ALL[9..] {
                let all = [&ctx.session.filter.random_walk, &usual.random_walk];
                let row = Row::of_state(format!("walk {}", state.name()), state, all);
                row.show(ctx, ui, |value| Edit::Filter(FilterEdit::RandomWalk(state, value)));
            }
        });
    });
}

/// Errors of the air-data sensors the filter finds, and delays of the measurements.
fn sensors(ctx: &mut PanelContext<'_>, ui: &mut Ui, usual: &FilterSettings) {
    CollapsingHeader::new("Errors of air data, √P₀").show(ui, |ui| {
        ui.weak("Zero: not estimated.");
        Grid::new("air data").num_columns(3).spacing([6.0, 3.0]).show(ui, |ui| {
            for state in AirState::ALL {
                let all = [&ctx.session.filter.air_data_deviation, &usual.air_data_deviation];
                let words = [state.description(), "Constant over a manoeuvre; needs excitation to be observable"];
                let values = all.map(|all| all[state as usize]);
                let row = Row::new(format!("P {}", state.name()), words, state.dimension(), values);
                row.show(ctx, ui, |value| Edit::Filter(FilterEdit::AirDataDeviation(state, value)));
            }
        });
    });
    CollapsingHeader::new("Delays of measurements").show(ui, |ui| {
        Grid::new("delays").num_columns(3).spacing([6.0, 3.0]).show(ui, |ui| {
            for measurement in Measurement::ALL {
                let name = format!("delay {}", measurement.name());
                ui.label(notation::measurement(measurement)).on_hover_text(measurement.description());
                let delay_s = ctx.session.filter.measurement_delay_s[measurement as usize];
                let edited = QuantityEdit::new(&name, delay_s).unit("ms", 1e3).per_point(1e-3).show(ui);
                ctx.edit_quantity(edited, |value| Edit::Filter(FilterEdit::MeasurementDelay(measurement, value)));
                ui.end_row();
            }
        });
    });
}

/// Why the recording of the chosen flight proposes no noise at all.
fn nothing_proposed(ctx: &PanelContext<'_>, ui: &mut Ui) {
    let noise = ctx.selection().flight.as_deref().and_then(|flight| ctx.snapshot.noise.get(flight)?.latest());
    let Some(noise) = noise.filter(|noise| noise.rows.iter().all(|row| row.choice.is_err())) else { return };
    if let Some(Err(reason)) = noise.rows.first().map(|row| &row.choice) {
        ui.label(RichText::new(format!("No proposed noise: {reason}.")).size(11.5).weak());
    }
}

/// What the recording of the chosen flight says about an entry.
fn recorded<'a>(ctx: &PanelContext<'a>, channel: NoiseChannel) -> Option<&'a NoiseRow> {
    let noise = ctx.snapshot.noise.get(ctx.selection().flight.as_deref()?)?.latest()?;
    noise.rows.iter().find(|row| row.channel == channel && row.statistics.is_some() && row.choice.is_ok())
}

/// The recorded deviation as a button that takes it.
fn take_recorded(ctx: &mut PanelContext<'_>, ui: &mut Ui, name: &str, row: &NoiseRow, (unit, scale): (&str, f64)) {
    let now = row.channel.std(ctx.session);
    let Some(proposed) = row.proposed() else { return };
    let measured = row.statistics.map_or(f64::NAN, |found| found.std);
    let apart = |a: f64, b: f64| a > FAR * b || b > FAR * a;
    let (is_far, is_unlike) = (apart(proposed, measured), apart(proposed, now));
    let mark = if is_far || is_unlike { " ⚠" } else { "" };
    let mut text = RichText::new(format!("⇐ {}{mark}", notation::number(scale * proposed))).size(11.0);
    if is_far || is_unlike {
        text = text.color(theme::palette(ui).warning);
    }
    let whiteness = row.statistics.map_or(f64::NAN, |found| found.whiteness);
    let note = match (is_far, is_unlike) {
        (true, _) => ". ⚠ They differ by more than a factor 3: check the steady parts first",
        (false, true) => ". ⚠ The value in use differs by more than a factor 3",
        (false, false) => "",
    };
    let why = format!(
        "Use the proposal: {} {unit}, from {}. The steady parts show {} {unit}, whiteness {}{note}",
        notation::number(scale * proposed),
        row.origin(),
        notation::number(scale * measured),
        notation::fixed(whiteness, 3)
    );
    let take = ui.add_enabled(now != proposed, egui::Button::new(text).small());
    let take = take.on_hover_text(&why).on_disabled_hover_text(why);
    ui.ctx().accesskit_node_builder(take.id, |node| node.set_label(format!("take recorded {name}")));
    if take.clicked() {
        ctx.edit(Edit::noise(row.channel, proposed));
    }
}

/// The button for the reason for another value than the proposed one.
fn reason(ctx: &mut PanelContext<'_>, ui: &mut Ui, name: &str, row: &NoiseRow) {
    let now = row.channel.std(ctx.session);
    let kept = ctx.session.noise_reasons.get(row.channel.name());
    let mark = RichText::new(if kept.is_some() { "✎●" } else { "✎" }).size(11.0);
    let hint = kept.map_or("Reason for another value", String::as_str);
    // A click into the field must not close what holds it.
    let stays = MenuConfig::new().close_behavior(egui::PopupCloseBehavior::CloseOnClickOutside);
    let (menu, _) = MenuButton::new(mark).config(stays).ui(ui, |ui| {
        let id = ui.scope_id().with("reason");
        let mut reason = ui.data(|data| data.get_temp(id)).or(kept.cloned()).unwrap_or_default();
        let field =
            ui.add(egui::TextEdit::singleline(&mut reason).hint_text("why not as proposed").desired_width(180.0));
        ui.ctx().accesskit_node_builder(field.id, |node| node.set_label(format!("reason {name}")));
        if field.changed() {
            ui.data_mut(|data| data.insert_temp(id, reason.clone()));
        }
        if ui.button("Keep").clicked() || (field.lost_focus() && ui.input(|i| i.key_pressed(egui::Key::Enter))) {
            let entry = NoiseEntry { channel: row.channel, std: now };
            ctx.edit(Edit::Noise(NoiseEdit::Set { entries: vec![entry], reason }));
            ui.data_mut(|data| data.remove::<String>(id));
            ui.close();
        }
    });
    let menu = menu.on_hover_text(hint);
    ui.ctx().accesskit_node_builder(menu.id, |node| node.set_label(format!("why {name}")));
}

/// A cell of a grid that is at least so wide, so that the tables of noise have equal columns.
fn fixed_cell<T>(ui: &mut Ui, width: f32, content: impl FnOnce(&mut Ui) -> T) -> T {
    ui.horizontal(|ui| {
        ui.set_min_width(width);
        content(ui)
    })
    .inner
}

impl<'a> Row<'a> {
    /// A row with its symbol and what it is, its value and the usual one.
    fn new(name: String, [symbol, about]: [&'a str; 2], dimension: Dimension, [value, usual]: [f64; 2]) -> Self {
        Self { name, symbol, about, dimension, value, usual, mark: None, recorded: None }
    }

    /// The row of a state among all values and all usual ones.
    fn of_state<const N: usize>(name: String, state: State, all: [&[f64; N]; 2]) -> Self {
        let words = [notation::state(state), state.description()];
        Self::new(name, words, state.dimension(), all.map(|all| all[state as usize]))
    }

    /// Symbol, field, reset, and a mark of consistency.
    fn show(self, ctx: &mut PanelContext<'_>, ui: &mut Ui, edit: impl Fn(f64) -> Edit) {
        let (unit, scale) = ctx.unit(self.dimension);
        ui.label(self.symbol).on_hover_text(self.about);
        let field = QuantityEdit::new(&self.name, self.value).unit(unit, scale).logarithmic();
        let edited = fixed_cell(ui, FIELD + UNIT, |ui| field.show(ui));
        ctx.edit_quantity(edited, &edit);
        let reset = ui
            .add_enabled(self.value != self.usual, egui::Button::new(RichText::new("↺").size(12.0)).frame(false))
            .on_hover_text(format!("Back to {} {unit}", notation::number(scale * self.usual)));
        ui.ctx().accesskit_node_builder(reset.id, |node| node.set_label(format!("reset {}", self.name)));
        if reset.clicked() {
            ctx.edit(edit(self.usual));
        }
        let advice = self.mark.and_then(|channel| noise_advice::find(ctx, channel.measurement));
        match (advice, self.recorded) {
            (Some(advice), recorded) => {
                noise_advice::buttons(ctx, ui, &self.name, advice);
                match recorded {
                    Some(recorded) => reason(ctx, ui, &self.name, recorded),
                    None => drop(ui.label("")),
                }
            }
            (None, Some(recorded)) => {
                fixed_cell(ui, PROPOSAL, |ui| take_recorded(ctx, ui, &self.name, recorded, (unit, scale)));
                reason(ctx, ui, &self.name, recorded);
            }
            (None, None) if self.mark.is_some() => {
                ui.label("");
                ui.label("");
            }
            (None, None) => {}
        }
        if let Some(channel) = self.mark {
            let hover = advice.map_or_else(String::new, |advice| noise_advice::advice_text(ctx, advice));
            let color = consistency_color(ui, channel);
            let wave = if channel.is_correlated() || channel.has_offset() { " ∿" } else { "" };
            let text = format!("×{}{wave}", notation::fixed(channel.deviation_ratio, 2));
            let label = ui.label(RichText::new(text).color(color).size(11.0));
            if !hover.is_empty() {
                label.on_hover_text(hover);
            }
        }
        ui.end_row();
    }
}
