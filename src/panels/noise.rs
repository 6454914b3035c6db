//! Settings of the filter: what it believes about noise, where it starts, how it works.

use doublet_core::quantity::Dimension;
use doublet_core::reconstruct::{FilterSettings, Input, InputHold, Measurement, Method, State};
use doublet_engine::session::{Edit, EstimationEdit, FilterEdit, NoiseChannel, NoiseEdit, NoiseEntry, PathSource};
use doublet_engine::stage::NoiseRow;
use eframe::egui::{self, CollapsingHeader, Grid, RichText, ScrollArea, Ui};

use super::{Panel, PanelContext, caption, choices, consistency_color};
use crate::notation;
use crate::widgets::quantity_edit::QuantityEdit;

/// Iterations and tolerance of an iterated filter that is switched on.
const ITERATED: Method = Method::Iekf { max_iterations: 10, tolerance: 1e-3 };

/// The panel.
pub struct Noise;

/// One row of a table of deviations.
struct Row<'a> {
    name: String,
    symbol: &'a str,
    about: &'a str,
    dimension: Dimension,
    value: f64,
    usual: f64,
    mark: Option<(f64, &'a str)>,
    /// What the steady windows of the recording say.
    recorded: Option<&'a NoiseRow>,
}

impl Panel for Noise {
    fn show(&mut self, ctx: &mut PanelContext<'_>, ui: &mut Ui) {
        ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
            filter(ctx, ui);
            ui.add_space(6.0);
            let usual = FilterSettings::default();
            let now = &ctx.session.filter;
            ui.columns(2, |columns| {
                let ui = &mut columns[0];
                caption(ui, "Process noise √Q (inertial sensors)");
                Grid::new("process noise").num_columns(4).spacing([6.0, 3.0]).show(ui, |ui| {
                    for input in Input::ALL {
                        let row = Row {
                            name: format!("Q {}", input.name()),
                            symbol: notation::role(input.role()),
                            about: input.description(),
                            dimension: input.dimension(),
                            value: now.process_noise[input as usize],
                            usual: usual.process_noise[input as usize],
                            mark: None,
                            recorded: recorded(ctx, NoiseChannel::Input(input)),
                        };
                        row.show(ctx, ui, |value| FilterEdit::ProcessNoise(input, value));
                    }
                });
                ui.add_space(8.0);
                initial(ctx, ui, &usual);
                let ui = &mut columns[1];
                caption(ui, "Measurement noise √R");
                measurements(ctx, ui, &usual);
            });
        });
    }
}

/// How the filter works.
fn filter(ctx: &mut PanelContext<'_>, ui: &mut Ui) {
    let filter = &ctx.session.filter;
    Grid::new("filter").num_columns(4).spacing([10.0, 4.0]).show(ui, |ui| {
        ui.weak("Filter");
        let mut method = matches!(filter.method, Method::Iekf { .. });
        if choices(ui, &mut method, &[(false, "EKF"), (true, "Iterated")]) {
            ctx.edit(Edit::Filter(FilterEdit::Method(if method { ITERATED } else { Method::Ekf })));
        }
        ui.weak("Input between samples");
        let mut hold = filter.hold;
        if choices(ui, &mut hold, &[(InputHold::FirstOrder, "Linear"), (InputHold::ZeroOrder, "Held")]) {
            ctx.edit(Edit::Filter(FilterEdit::Hold(hold)));
        }
        ui.end_row();
        ui.weak("Path used");
        let mut path = ctx.session.preparation.path;
        if choices(ui, &mut path, &[(PathSource::Filtered, "Filtered"), (PathSource::Smoothed, "Smoothed")]) {
            ctx.edit(Edit::Estimation(EstimationEdit::Path(path)));
        }
        ui.weak("Gravity");
        let gravity =
            QuantityEdit::new("gravity", filter.gravity_m_s2).unit("m/s²", 1.0).per_point(1e-4).allowed(9.7..=9.9);
        let edited = gravity.show(ui);
        ctx.edit_quantity(edited, |value| Edit::Filter(FilterEdit::Gravity(value)));
        ui.end_row();
        if let Method::Iekf { max_iterations, tolerance } = filter.method {
            ui.weak("Iterations at most");
            let edited =
                QuantityEdit::new("iterations", max_iterations as f64).per_point(0.1).allowed(1.0..=100.0).show(ui);
            ctx.edit_quantity(edited, |value| {
                let max_iterations = value.round().clamp(1.0, 100.0) as usize;
                Edit::Filter(FilterEdit::Method(Method::Iekf { max_iterations, tolerance }))
            });
            ui.weak("Tolerance");
            let edited =
                QuantityEdit::new("tolerance", tolerance).unit("σ", 1.0).logarithmic().allowed(1e-12..=1.0).show(ui);
            ctx.edit_quantity(edited, |tolerance| {
                Edit::Filter(FilterEdit::Method(Method::Iekf { max_iterations, tolerance }))
            });
            ui.end_row();
        }
    });
}

/// Noise of the measurements, with what the innovations of the chosen window say about each.
fn measurements(ctx: &mut PanelContext<'_>, ui: &mut Ui, usual: &FilterSettings) {
    let path = ctx.results().and_then(|results| results.path.latest());
    Grid::new("measurement noise").num_columns(5).spacing([6.0, 3.0]).show(ui, |ui| {
        for measurement in Measurement::ALL {
            let index = measurement as usize;
            let channels = path.and_then(|path| path.consistency.as_ref()).map(|consistency| &consistency.channels);
            let channel = channels.into_iter().flatten().find(|channel| channel.measurement == measurement);
            let row = Row {
                name: format!("R {}", measurement.name()),
                symbol: notation::measurement(measurement),
                about: measurement.description(),
                dimension: measurement.dimension(),
                value: ctx.session.filter.measurement_noise[index],
                usual: usual.measurement_noise[index],
                mark: channel.map(|channel| (channel.deviation_ratio, channel.advice.as_str())),
                recorded: recorded(ctx, NoiseChannel::Measurement(measurement)),
            };
            row.show(ctx, ui, |value| FilterEdit::MeasurementNoise(measurement, value));
        }
    });
}

/// Initial deviations and random walks.
fn initial(ctx: &mut PanelContext<'_>, ui: &mut Ui, usual: &FilterSettings) {
    CollapsingHeader::new("Initial deviation √P₀").show(ui, |ui| {
        Grid::new("initial deviation").num_columns(3).spacing([6.0, 3.0]).show(ui, |ui| {
            for state in State::ALL {
                let row = Row {
                    name: format!("P {}", state.name()),
                    symbol: notation::state(state),
                    about: state.description(),
                    dimension: state.dimension(),
                    value: ctx.session.filter.initial_deviation[state as usize],
                    usual: usual.initial_deviation[state as usize],
                    mark: None,
                    recorded: None,
                };
                row.show(ctx, ui, |value| FilterEdit::InitialDeviation(state, value));
            }
        });
    });
    CollapsingHeader::new("Random walk, per √s").show(ui, |ui| {
        Grid::new("random walk").num_columns(3).spacing([6.0, 3.0]).show(ui, |ui| {
            for state in &State::ALL[9..] {
                let row = Row {
                    name: format!("walk {}", state.name()),
                    symbol: notation::state(*state),
                    about: state.description(),
                    dimension: state.dimension(),
                    value: ctx.session.filter.random_walk[*state as usize],
                    usual: usual.random_walk[*state as usize],
                    mark: None,
                    recorded: None,
                };
                row.show(ctx, ui, |value| FilterEdit::RandomWalk(*state, value));
            }
        });
    });
}

/// What the recording of the chosen flight says about an entry.
fn recorded<'a>(ctx: &PanelContext<'a>, channel: NoiseChannel) -> Option<&'a NoiseRow> {
    let noise = ctx.snapshot.noise.get(ctx.selection().flight.as_deref()?)?.latest()?;
    noise.rows.iter().find(|row| row.channel == channel && row.statistics.is_some())
}

/// The recorded deviation as a button that takes it, and the reason for another value.
fn take_recorded(ctx: &mut PanelContext<'_>, ui: &mut Ui, name: &str, row: &NoiseRow, (unit, scale): (&str, f64)) {
    let now = row.channel.std(ctx.session);
    let proposed = row.choice.proposed;
    let text = RichText::new(format!("⇐ {}", notation::number(scale * proposed))).size(11.0);
    let origin = row.origin();
    let whiteness = row.statistics.map_or(f64::NAN, |found| found.whiteness);
    let take = ui.add_enabled(now != proposed, egui::Button::new(text).small()).on_hover_text(format!(
        "Take what the recording says: {} {unit}, {origin}, whiteness {}",
        notation::number(scale * proposed),
        notation::fixed(whiteness, 3)
    ));
    ui.ctx().accesskit_node_builder(take.id, |node| node.set_label(format!("take recorded {name}")));
    if take.clicked() {
        ctx.edit(Edit::Noise(NoiseEdit::Take(vec![NoiseEntry { channel: row.channel, std: proposed }])));
    }
    let kept = ctx.session.noise_reasons.get(row.channel.name());
    let mark = RichText::new(if kept.is_some() { "✎●" } else { "✎" }).size(11.0);
    let hint = kept.map_or("Why it is not what the recording says", String::as_str);
    let menu = ui.menu_button(mark, |ui| {
        let id = ui.scope_id().with("reason");
        let mut reason = ui.data(|data| data.get_temp(id)).or(kept.cloned()).unwrap_or_default();
        let field =
            ui.add(egui::TextEdit::singleline(&mut reason).hint_text("why not as recorded").desired_width(180.0));
        ui.ctx().accesskit_node_builder(field.id, |node| node.set_label(format!("reason {name}")));
        if field.changed() {
            ui.data_mut(|data| data.insert_temp(id, reason.clone()));
        }
        if ui.button("Keep").clicked() || (field.lost_focus() && ui.input(|i| i.key_pressed(egui::Key::Enter))) {
            let entry = NoiseEntry { channel: row.channel, std: now };
            ctx.edit(Edit::Noise(NoiseEdit::Override { entry, reason }));
            ui.data_mut(|data| data.remove::<String>(id));
            ui.close();
        }
    });
    let menu = menu.response.on_hover_text(hint);
    ui.ctx().accesskit_node_builder(menu.id, |node| node.set_label(format!("why {name}")));
}

impl Row<'_> {
    /// Symbol, field, reset, and a mark of consistency.
    fn show(self, ctx: &mut PanelContext<'_>, ui: &mut Ui, edit: impl Fn(f64) -> FilterEdit) {
        let (unit, scale) = ctx.unit(self.dimension);
        ui.label(self.symbol).on_hover_text(self.about);
        let edited = QuantityEdit::new(&self.name, self.value).unit(unit, scale).logarithmic().show(ui);
        ctx.edit_quantity(edited, |value| Edit::Filter(edit(value)));
        let reset = ui
            .add_enabled(self.value != self.usual, egui::Button::new(RichText::new("↺").size(12.0)).frame(false))
            .on_hover_text(format!("Back to {} {unit}", notation::number(scale * self.usual)));
        ui.ctx().accesskit_node_builder(reset.id, |node| node.set_label(format!("reset {}", self.name)));
        if reset.clicked() {
            ctx.edit(Edit::Filter(edit(self.usual)));
        }
        if let Some(recorded) = self.recorded {
            take_recorded(ctx, ui, &self.name, recorded, (unit, scale));
        }
        if let Some((ratio, advice)) = self.mark {
            let color = consistency_color(ui, ratio);
            let text = RichText::new(format!("×{}", notation::fixed(ratio, 2))).color(color).size(11.0);
            ui.label(text).on_hover_text(format!("innovations over their predicted deviation: {advice}"));
        }
        ui.end_row();
    }
}
