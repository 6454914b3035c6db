//! Travel of a control: its deflection from what the recorder writes for its servo or lever, said by neutral and one other position.

use doublet_core::load::{ManualChannel, Probe};
use doublet_core::quantity::{Dimension, Unit};
use eframe::egui::{DragValue, Grid, Id, Key, Popup, PopupCloseBehavior, RichText, Sense, TextStyle, Ui, vec2};

use crate::theme;

/// Frames after opening in which the first field asks for the keyboard: in the first nothing can have it yet.
const FRAMES_TO_FOCUS: u8 = 3;

const BUTTON: &str = "travel…";

/// Two positions of a control.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Travel {
    /// Recorded where the deflection is zero.
    neutral: f64,
    /// Recorded at another position.
    at: f64,
    /// Deflection there, deg.
    deflection_deg: f64,
}

impl Travel {
    /// What `row` says now; where nobody has said anything, its first and its greatest value with no deflection yet.
    fn measure(row: &ManualChannel, probes: &[Probe]) -> Self {
        let finite = row.from.find(probes).map_or(&[][..], |channel| channel.values()).iter();
        let finite = finite.copied().filter(|value| value.is_finite());
        let (first, greatest) = finite.fold((None, f64::NEG_INFINITY), |(first, greatest), value| {
            (first.or(Some(value)), f64::max(greatest, value))
        });
        let is_said = row.scale != 1.0 || row.offset != 0.0;
        let neutral = if is_said { -row.offset } else { first.unwrap_or_default() };
        let at = if greatest > neutral { greatest } else { neutral + 1.0 };
        let sign = if row.turned { -1.0 } else { 1.0 };
        let unit = row.unit.filter(|unit| unit.dimension == Dimension::Angle);
        let deflection = unit.map_or(0.0, |unit| (sign * row.scale * unit.to_si(at + row.offset)).to_degrees());
        Self { neutral, at, deflection_deg: if is_said { deflection } else { 0.0 } }
    }

    /// Puts it into `row`, where the two positions differ and the deflection is none of zero.
    fn apply_to(self, row: &mut ManualChannel, deg: Unit) {
        let per_unit = self.deflection_deg / (self.at - self.neutral);
        if per_unit.is_finite() && per_unit != 0.0 {
            row.unit = Some(deg);
            row.is_unit_known = true;
            row.turned = false;
            row.scale = per_unit;
            row.offset = 0.0 - self.neutral;
        }
    }
}

/// A cell as wide as the button.
pub(super) fn room(ui: &mut Ui) {
    let font = TextStyle::Button.resolve(ui.style());
    let galley = ui.painter().layout_no_wrap(BUTTON.to_owned(), font, ui.visuals().text_color());
    ui.allocate_exact_size(vec2(galley.size().x + 2.0 * ui.spacing().button_padding.x, 0.0), Sense::hover());
}

/// The button and, once it is clicked, the two positions.
pub(super) fn show(ui: &mut Ui, key: &str, row: &mut ManualChannel, probes: &[Probe]) {
    let Ok(deg) = Unit::parse("deg") else { return };
    // A channel that is no deflection says nothing without its travel.
    let unit = row.from.find(probes).and_then(|channel| Unit::parse(channel.unit.as_deref()?).ok());
    let is_open = row.scale == 1.0 && row.offset == 0.0 && unit.is_none_or(|unit| unit.dimension != Dimension::Angle);
    let text = RichText::new(BUTTON);
    let text = if is_open { text.color(theme::palette(ui).warning) } else { text };
    let button = ui.small_button(text).on_hover_text(
        "For a servo pulse or a lever position instead of a deflection: enter the recorded value at neutral and at another position, \
         and the deflection there. They give unit, scale and offset",
    );
    ui.ctx().accesskit_node_builder(button.id, |node| node.set_label(format!("travel of {key}")));
    let id = Id::unique(("travel", key));
    Popup::from_toggle_button_response(&button).close_behavior(PopupCloseBehavior::CloseOnClickOutside).show(|ui| {
        let frame = ui.ctx().cumulative_frame_nr();
        let kept = ui.data(|data| data.get_temp::<(u64, u8, Travel)>(id)).filter(|(last, ..)| last + 1 >= frame);
        let (age, mut travel) =
            kept.map_or_else(|| (0, Travel::measure(row, probes)), |(_, age, travel)| (age, travel));
        let before = travel;
        let mut is_entered = false;
        Grid::new(id).num_columns(2).spacing([10.0, 4.0]).show(ui, |ui| {
            let fields = [
                ("recorded at neutral", &mut travel.neutral, ""),
                ("recorded at another position", &mut travel.at, ""),
                ("deflection there", &mut travel.deflection_deg, " deg"),
            ];
            for (index, (name, value, unit)) in fields.into_iter().enumerate() {
                ui.label(name);
                // Before it is drawn, so that what is typed replaces what stands in it.
                if age < FRAMES_TO_FOCUS && index == 0 {
                    let first = ui.next_auto_id();
                    ui.memory_mut(|memory| memory.request_focus(first));
                }
                let field = ui.add(DragValue::new(value).speed(0.1).max_decimals(4).suffix(unit));
                ui.ctx().accesskit_node_builder(field.id, |node| node.set_label(format!("{name} of {key}")));
                // Return in the last field ends it.
                let is_last = index == 2;
                is_entered |= is_last && field.lost_focus() && ui.input(|input| input.key_pressed(Key::Enter));
                ui.end_row();
            }
        });
        ui.weak("Positive: elevator trailing edge down, right aileron down, rudder trailing edge left.");
        if travel != before {
            travel.apply_to(row, deg);
        }
        ui.data_mut(|data| data.insert_temp(id, (frame, age.saturating_add(1), travel)));
        if is_entered {
            ui.close();
        }
    });
}

#[cfg(test)]
mod tests {
    use doublet_core::load::ChannelName;

    use super::*;

    #[test]
    fn travel_of_a_servo_gives_the_deflection_and_is_read_back() {
        let deg = Unit::parse("deg").expect("degrees are a unit");
        let from = ChannelName { source: "RCOU".to_owned(), channel: "C2".to_owned() };
        let mut row = ManualChannel::new(from, None);
        assert_eq!(Travel::measure(&row, &[]).deflection_deg, 0.0, "nothing is said yet");
        Travel { neutral: 1500.0, at: 2000.0, deflection_deg: 0.0 }.apply_to(&mut row, deg);
        assert_eq!((row.scale, row.offset), (1.0, 0.0), "no deflection says nothing");
        Travel { neutral: 1500.0, at: 2000.0, deflection_deg: -35.0 }.apply_to(&mut row, deg);
        assert_eq!((row.scale, row.offset, row.turned), (-0.07, -1500.0, false));
        assert_eq!(row.unit.map(|unit| unit.symbol), Some("deg"));
        let back = Travel::measure(&row, &[]);
        assert_eq!(back.neutral, 1500.0);
        assert!((back.deflection_deg / (back.at - back.neutral) + 0.07).abs() < 1e-12, "{back:?}");
    }
}
