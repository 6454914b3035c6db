//! The table of roles on the page of a new session.

use doublet_core::load::{ChannelName, ManualChannel, ManualTime, QuaternionAxes, RowValues, Source, guess_row};
use doublet_core::quantity::{Dimension, Role, Unit};
use doublet_core::reconstruct::{Input, Measurement};
use doublet_engine::begin::unit_reason;
use doublet_engine::confidence::WeighedRole;
use eframe::egui::{self, CollapsingHeader, ComboBox, DragValue, Grid, RichText, ScrollArea, Ui};

use super::{Choice, Choosing, channel_choice, travel};
use crate::notation::Units;
use crate::widgets::level_mark::{channel_words, level_mark};
use crate::widgets::term::column_title;
use crate::{notation, theme};

/// Confidence below which a row asks to be looked at.
const DOUBTFUL: f64 = 0.8;
/// Rate offered first for a source without time, Hz.
const USUAL_RATE_HZ: f64 = 50.0;

/// Widths of the columns with what a role is, and with the evidence for its channel.
const MEANING: std::ops::RangeInclusive<f32> = 152.0..=236.0;
/// Width of the other columns.
const OTHERS: f32 = 1020.0;
const EVIDENCE: f32 = 118.0;

/// Title of the column with the travel of controls.
const TRAVEL: &str = "travel";
/// Controls, after what the filter needs.
const CONTROLS: [Role; 3] = [Role::Elevator, Role::Aileron, Role::Rudder];
/// What latitude, longitude and altitude give where it is not recorded.
const POSITION: [Role; 3] = [Role::PositionNorth, Role::PositionEast, Role::PositionDown];
const POSITION_HINT: &str = "Position north, east and down from latitude, longitude and altitude";
/// What density and speed come from where they are not measured.
const AIR: [Role; 8] = [
    Role::Altitude,
    Role::StaticPressure,
    Role::AirTemperature,
    Role::CalibratedAirspeed,
    Role::EquivalentAirspeed,
    Role::ImpactPressure,
    Role::Latitude,
    Role::Longitude,
];

impl Choosing {
    /// What the row of `role` reads, looked through again only when it changed.
    fn values(&mut self, role: Role, row: &ManualChannel) -> Option<RowValues> {
        if self.values.get(&role).is_none_or(|(of, _)| of != row) {
            let values = row.values(&self.inspected.probes);
            self.values.insert(role, (row.clone(), values));
        }
        self.values.get(&role).and_then(|(_, values)| *values)
    }

    /// Whether position comes from latitude and longitude.
    pub(super) fn derives_position(&self) -> bool {
        match self.choice {
            Choice::ByHand => self.hand.position_from_fixes,
            Choice::Shipped(index) => self.inspected.fitting.get(index).is_some_and(|map| map.plan.derives_position()),
        }
    }
}

/// Draws the roles of the chosen map, `room` points high; those made by hand can be changed.
pub fn show(choosing: &mut Choosing, ui: &mut Ui, room: f32) {
    ScrollArea::both().id_salt("roles").max_height(room).min_scrolled_height(room).auto_shrink(false).show(ui, |ui| {
        match choosing.choice {
            Choice::Shipped(index) => planned(choosing, index, ui),
            Choice::ByHand => by_hand(choosing, ui),
        }
    });
}

/// What a shipped map gives.
fn planned(choosing: &Choosing, index: usize, ui: &mut Ui) {
    let Some(map) = choosing.inspected.fitting.get(index) else { return };
    ui.add(egui::Label::new(RichText::new(&map.description).weak()).wrap());
    Grid::new("planned").num_columns(8).striped(true).spacing([14.0, 2.0]).show(ui, |ui| {
        header(ui, &["", "role", "what it is", "channel", "unit", "shape", "smallest", "largest"]);
        for (role, assignment) in &map.plan.roles {
            mark(choosing, *role, ui);
            ui.label(notation::role(*role));
            ui.weak(role.description());
            ui.label(&assignment.channels).on_hover_text(&assignment.description);
            ui.label(notation::raise_powers(assignment.unit.symbol));
            if let Some(shape) = choosing.comparison.shape(*role) {
                shape.show(ui, *role);
                for value in shape.range().into_iter().flatten() {
                    let (unit, scale) = Units::default().of_role(*role);
                    let recorded = notation::number(assignment.unit.from_si(value));
                    let text = RichText::new(recorded).font(theme::figures(ui));
                    ui.label(text).on_hover_text(format!("{} {unit}", notation::number(scale * value)));
                }
            }
            ui.end_row();
        }
    });
}

/// What the other channels say of that of `role`.
fn mark(choosing: &Choosing, role: Role, ui: &mut Ui) {
    let level = choosing.comparison.level(role);
    let text = format!("{}: {}", role.name(), channel_words(level));
    level_mark(ui, level).on_hover_text(text);
}

fn header(ui: &mut Ui, names: &[&str]) {
    names.iter().for_each(|name| drop(column_title(ui, name)));
    ui.end_row();
}

/// The table made by hand: what is needed first, the rest when asked for.
fn by_hand(choosing: &mut Choosing, ui: &mut Ui) {
    let before = choosing.hand.clone();
    times(choosing, ui);
    let names = channels(choosing);
    let needed: Vec<Role> = Input::ALL.into_iter().map(Input::role).chain(CONTROLS).collect();
    let measured: Vec<Role> = Measurement::ALL.into_iter().map(Measurement::role).collect();
    let known = |role: &Role| needed.contains(role) || measured.contains(role) || AIR.contains(role);
    let rest: Vec<Role> = Role::ALL.iter().copied().filter(|role| !known(role)).collect();
    for (title, roles, open) in [
        ("Inertial unit and controls", &needed, true),
        ("Measurements of the filter", &measured, true),
        ("Air and position", &AIR.to_vec(), true),
        ("Engines, fuel, others", &rest, false),
    ] {
        let count = roles.iter().filter(|role| choosing.hand.row(**role).is_some()).count();
        let open = open || count > 0;
        let title = format!("{title} – {count} of {}", roles.len());
        CollapsingHeader::new(title).id_salt(roles.first()).default_open(open).show(ui, |ui| {
            table(choosing, &names, roles, ui);
        });
    }
    let fixes = [Role::Latitude, Role::Longitude].iter().all(|role| choosing.hand.row(*role).is_some());
    if fixes {
        ui.checkbox(&mut choosing.hand.position_from_fixes, POSITION_HINT);
    } else {
        choosing.hand.position_from_fixes = false;
    }
    derivations(choosing, ui);
    if choosing.hand != before {
        choosing.plan_again();
    }
}

/// Attitude and velocity in other forms than the roles, where the recording has them.
fn derivations(choosing: &mut Choosing, ui: &mut Ui) {
    let guess = &choosing.inspected.guess;
    if let Some(guessed) = &guess.attitude {
        let hand = &mut choosing.hand.attitude;
        let mut is_used = hand.is_some();
        ui.horizontal(|ui| {
            ui.checkbox(&mut is_used, format!("Attitude from the quaternion {}", guessed.parts.join(", ")));
            if let Some(attitude) = hand {
                ComboBox::from_id_salt("axes of the quaternion").selected_text(attitude.axes.description()).show_ui(
                    ui,
                    |ui| {
                        for axes in QuaternionAxes::ALL {
                            ui.selectable_value(&mut attitude.axes, axes, axes.description());
                        }
                    },
                );
            }
        });
        if is_used != hand.is_some() {
            *hand = is_used.then(|| guessed.clone());
        }
    }
    if let Some([speed, track]) = &guess.velocity {
        let mut is_used = choosing.hand.velocity.is_some();
        let (speed, track) = (&speed.from.channel, &track.from.channel);
        if ui.checkbox(&mut is_used, format!("Velocity north and east from {speed} along {track}")).changed() {
            choosing.hand.velocity = if is_used { guess.velocity.clone() } else { None };
        }
    }
}

/// Channels that can play a role.
fn channels(choosing: &Choosing) -> Vec<ChannelName> {
    let sources = choosing.inspected.probes.iter().flat_map(|probe| &probe.sources);
    let all = sources.flat_map(|source| source.channels.iter().map(move |channel| (source, channel)));
    all.filter(|(_, channel)| !channel.is_time && channel.samples > 1)
        .map(|(source, channel)| ChannelName { source: source.name.clone(), channel: channel.name.clone() })
        .collect()
}

fn table(choosing: &mut Choosing, names: &[ChannelName], roles: &[Role], ui: &mut Ui) {
    let single = choosing.inspected.probes.iter().map(|probe| probe.sources.len()).sum::<usize>() == 1;
    let names_of_columns = [
        "", "role", "what it is", "channel", "evidence", "unit", "sign", "scale", "added", TRAVEL, "first", "smallest",
        "largest", "shape",
    ];
    // Tables without controls keep the column, so that all tables align.
    let has_travel = roles.iter().any(|role| CONTROLS.contains(role));
    let meaning = (ui.available_width() - OTHERS).clamp(*MEANING.start(), *MEANING.end());
    let columns = names_of_columns.map(|name| if has_travel || name != TRAVEL { name } else { "" });
    Grid::new(("by hand", roles.first())).num_columns(columns.len()).striped(true).spacing([10.0, 2.0]).show(
        ui,
        |ui| {
            header(ui, &columns);
            for &role in roles {
                mark(choosing, role, ui);
                ui.label(notation::role(role));
                cell(ui, meaning, RichText::new(role.description()).weak(), role.description());
                row(choosing, names, (role, single), ui);
                ui.end_row();
            }
        },
    );
}

/// One role: its channel, and what is done with its numbers. `SI = sign * scale * to_si(raw + added)`.
fn row(choosing: &mut Choosing, names: &[ChannelName], (role, single): (Role, bool), ui: &mut Ui) {
    let shown = |name: &ChannelName| match single || name.source.is_empty() {
        true => name.channel.clone(),
        false => format!("{}/{}", name.source, name.channel),
    };
    let key = role.name();
    let now = choosing.hand.row(role).map(|row| row.from.clone());
    let other_side = choosing.hand.row(role).and_then(|row| row.other_side.as_ref());
    let other_side = other_side.map(|other| format!("{} {}", if other.sign < 0.0 { "−" } else { "+" }, other.channel));
    let chosen = channel_choice::show(ui, key, (now.as_ref(), other_side.as_deref()), names, shown)
        .filter(|chosen| *chosen != now);
    if let Some(chosen) = chosen {
        let row = chosen.map(|from| guess_row(&choosing.inspected.probes, role, &from));
        choosing.hand.set(role, row);
    }
    let Some(mut row) = choosing.hand.row(role).cloned() else {
        if choosing.hand.position_from_fixes && POSITION.contains(&role) {
            cell(ui, EVIDENCE, RichText::new("from GPS fixes").small().weak(), POSITION_HINT);
        }
        return;
    };
    reason(choosing, (role, &row), ui);
    unit(&mut row, role, ui);
    let sign = ui.selectable_label(row.turned, if row.turned { "−" } else { "+" });
    ui.ctx().accesskit_node_builder(sign.id, |node| node.set_label(format!("sign of {key}")));
    if sign.on_hover_text("Click to reverse the sign").clicked() {
        row.turned = !row.turned;
    }
    for (value, name, about) in [
        (&mut row.scale, "scale", "Factor on the value"),
        (&mut row.offset, "added", "Added to the recorded number, before its unit, sign and scale"),
    ] {
        let field = ui.add(DragValue::new(value).speed(0.01).max_decimals(6));
        ui.ctx().accesskit_node_builder(field.id, |node| node.set_label(format!("{name} of {key}")));
        field.on_hover_text(about);
    }
    if CONTROLS.contains(&role) {
        travel::show(ui, key, &mut row, &choosing.inspected.probes);
    } else {
        travel::room(ui);
    }
    if let Some(RowValues { unit, first, least, greatest }) = choosing.values(role, &row) {
        for value in [first, least, greatest] {
            let shown = ui.label(RichText::new(notation::number(value)).font(theme::figures(ui)));
            let recorded = format!("{} {}", notation::number(value), unit.symbol);
            let si = format!("{} {}", notation::number(unit.to_si(value)), role.dimension().si_symbol());
            shown.on_hover_text(notation::raise_powers(&format!("{recorded}, with sign, scale and offset: {si}")));
        }
    }
    if let Some(shape) = choosing.comparison.shape(role) {
        shape.show(ui, role);
    }
    if choosing.hand.row(role) != Some(&row) {
        choosing.hand.set(role, Some(row));
    }
}

/// A text of at most that width; all of it, or more, under the pointer.
fn cell(ui: &mut Ui, width: f32, text: RichText, about: &str) {
    ui.scope(|ui| {
        ui.set_width(width);
        ui.add(egui::Label::new(text).truncate()).on_hover_text(about);
    });
}

/// What a row rests on: the evidence of the guess, or the user's own choice. Marked where the unit is open.
fn reason(choosing: &Choosing, (role, row): (Role, &ManualChannel), ui: &mut Ui) {
    let guessed = choosing.inspected.guess.row(role);
    let probes = &choosing.inspected.probes;
    let is_open = row.is_unit_open(probes);
    let weighed = choosing.comparison.weighed(role).filter(|_| guessed == Some(row));
    let (text, about) = match guessed {
        Some(guess) if guess == row => {
            let words = if is_open { "unit?" } else { row.by.description() };
            match weighed {
                Some(weighed) => (format!("{:.0} %, {words}", percent(weighed)), certainty(weighed)),
                None => (words.to_owned(), format!("Unit {}", unit_reason(row, probes))),
            }
        }
        Some(guess) if guess.from == row.from => ("changed".to_owned(), "Guessed channel with your changes".to_owned()),
        _ => ("by hand".to_owned(), "Chosen by hand".to_owned()),
    };
    let text = RichText::new(text).small();
    let is_asked = is_open && guessed == Some(row);
    let is_doubtful = weighed.is_some_and(|weighed| weighed.confidence < DOUBTFUL);
    let text = if is_asked || is_doubtful { text.color(theme::palette(ui).warning) } else { text.weak() };
    cell(ui, EVIDENCE, text, &about);
}

/// Confidence in whole per cent; 100 only where it is certain.
fn percent(weighed: &WeighedRole) -> f64 {
    (100.0 * weighed.confidence).floor()
}

/// How certain a row of the guess is, what speaks for it and which channel comes next.
fn certainty(weighed: &WeighedRole) -> String {
    let other = weighed
        .runner_up
        .as_ref()
        .map_or_else(String::new, |other| format!("\nNext: '{}' ({})", other.from.channel, other.reason));
    format!("{:.0} % confidence\n{}{other}", percent(weighed), weighed.evidence.replace("; ", "\n"))
}

fn unit(row: &mut ManualChannel, role: Role, ui: &mut Ui) {
    let symbol = notation::raise_powers(row.unit.map_or("–", |unit| unit.symbol));
    let combo = ComboBox::from_id_salt(("unit", role.name())).selected_text(symbol).width(64.0);
    let combo = combo.show_ui(ui, |ui| {
        for unit in Unit::all().filter(|unit| unit.dimension == role.dimension()) {
            if ui.selectable_value(&mut row.unit, Some(unit), notation::raise_powers(unit.symbol)).clicked() {
                row.is_unit_known = true;
            }
        }
    });
    ui.ctx().accesskit_node_builder(combo.response.id, |node| node.set_label(format!("unit of {}", role.name())));
}

/// Where time comes from, for every source that has none of a known name.
fn times(choosing: &mut Choosing, ui: &mut Ui) {
    let inspected = std::sync::Arc::clone(&choosing.inspected);
    // A source of single values needs no time.
    let is_series = |source: &&Source| source.channels.iter().any(|channel| channel.samples > 1);
    let sources = inspected.probes.iter().flat_map(|probe| &probe.sources).filter(is_series);
    let without = sources.filter(|source| source.clocks.is_empty());
    for source in without {
        let at = choosing.hand.time.iter().position(|(name, _)| *name == source.name);
        let mut time = at.map(|at| choosing.hand.time[at].1.clone());
        ui.horizontal(|ui| {
            ui.label(format!("Time of {}", source.name));
            let text = match &time {
                None => "none: choose it".to_owned(),
                Some(ManualTime::Channel(name, _)) => name.clone(),
                Some(ManualTime::Rate(_) | ManualTime::Even { .. }) => "evenly spaced".to_owned(),
            };
            let combo = ComboBox::from_id_salt(("time", &source.name)).selected_text(text).width(190.0);
            let combo = combo.show_ui(ui, |ui| {
                ui.selectable_value(&mut time, Some(ManualTime::Rate(USUAL_RATE_HZ)), "evenly spaced");
                for channel in &source.channels {
                    let value = ManualTime::Channel(channel.name.clone(), Unit::si(Dimension::Time));
                    ui.selectable_value(&mut time, Some(value), &channel.name);
                }
            });
            let label = format!("time of {}", source.name);
            ui.ctx().accesskit_node_builder(combo.response.id, |node| node.set_label(label.as_str()));
            match &mut time {
                Some(ManualTime::Rate(rate_hz) | ManualTime::Even { rate_hz, .. }) => {
                    let field = ui.add(DragValue::new(rate_hz).range(1e-3..=1e6).suffix(" Hz"));
                    ui.ctx()
                        .accesskit_node_builder(field.id, |node| node.set_label(format!("rate of {}", source.name)));
                }
                Some(ManualTime::Channel(_, unit)) => {
                    ComboBox::from_id_salt(("time unit", &source.name)).selected_text(unit.symbol).width(60.0).show_ui(
                        ui,
                        |ui| {
                            for other in Unit::all().filter(|unit| unit.dimension == Dimension::Time) {
                                ui.selectable_value(unit, other, other.symbol);
                            }
                        },
                    );
                }
                None => {}
            }
        });
        if let (None, Some(time)) = (at, &time) {
            choosing.hand.time.push((source.name.clone(), time.clone()));
        } else if let (Some(at), Some(time)) = (at, time) {
            choosing.hand.time[at].1 = time;
        }
    }
}
