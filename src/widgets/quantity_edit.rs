//! A number with its unit: typed, or dragged linearly or logarithmically; its problem is said beside it.

use std::cell::Cell;
use std::ops::RangeInclusive;
use std::time::Duration;

use eframe::egui::{self, DragValue, Id, Key, Stroke, Ui, UiBuilder, vec2};

use super::EditPhase;
use crate::notation::{concise, rounded};
use crate::theme;

/// Decades per point of a logarithmic drag.
const DECADES_PER_POINT: f64 = 0.01;
/// Significant digits of a dragged value.
const DRAG_DIGITS: i32 = 3;
const FIELD_WIDTH: f32 = 78.0;

/// A numeric field.
#[derive(Clone, Debug)]
pub struct QuantityEdit<'a> {
    name: &'a str,
    value: f64,
    unit: &'a str,
    scale: f64,
    logarithmic: bool,
    per_point: f64,
    decimals: Option<usize>,
    allowed: Option<RangeInclusive<f64>>,
    problem: Option<&'a str>,
    width: f32,
}

/// What the user did to a field this frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct QuantityEdited {
    /// Where the edit stands.
    pub phase: EditPhase,
    /// The value in SI; what it was before for `Begin` and `Cancel`.
    pub value: f64,
}

/// How long a field that is sought stays marked, s.
const MARKED_S: f64 = 3.0;

/// A field that is sought.
#[derive(Clone)]
struct Sought {
    name: String,
    until_s: f64,
    is_shown: bool,
}

impl Sought {
    fn id() -> Id {
        Id::unique("sought field")
    }
}

/// Has the field called `name` scrolled to and marked for some seconds where it is drawn.
pub fn seek(context: &egui::Context, name: String) {
    let until_s = context.input(|input| input.time) + MARKED_S;
    context.data_mut(|data| data.insert_temp(Sought::id(), Sought { name, until_s, is_shown: false }));
}

/// A drag under way.
#[derive(Clone, Copy)]
struct Held {
    origin: f64,
    now: f64,
}

impl<'a> QuantityEdit<'a> {
    /// A field for `value` in SI called `name`, for tests and screen readers. The name is also its identity, whatever is drawn
    /// before it: text that comes or goes above a field does not end its drag. No two fields on screen share one.
    pub fn new(name: &'a str, value: f64) -> Self {
        Self {
            name,
            value,
            unit: "",
            scale: 1.0,
            logarithmic: false,
            per_point: 0.01,
            decimals: None,
            allowed: None,
            problem: None,
            width: FIELD_WIDTH,
        }
    }

    /// Shows the value in `unit`, which is SI times `scale`.
    #[must_use]
    pub fn unit(mut self, unit: &'a str, scale: f64) -> Self {
        self.unit = unit;
        self.scale = scale;
        self
    }

    /// Drags in decades: for quantities that are positive and span orders of magnitude.
    #[must_use]
    pub fn logarithmic(mut self) -> Self {
        self.logarithmic = true;
        self
    }

    /// Change of the shown value per point of a linear drag.
    #[must_use]
    pub fn per_point(mut self, per_point: f64) -> Self {
        self.per_point = per_point;
        self
    }

    /// Shows and drags this many decimals, whatever the size of the value: for places on a long axis.
    #[must_use]
    pub fn decimals(mut self, decimals: usize) -> Self {
        self.decimals = Some(decimals);
        self
    }

    /// Makes the field this wide, points.
    #[must_use]
    pub fn wide(mut self, width: f32) -> Self {
        self.width = width;
        self
    }

    /// Values in SI that make sense; others are taken, marked and explained.
    #[must_use]
    pub fn allowed(mut self, allowed: RangeInclusive<f64>) -> Self {
        self.allowed = Some(allowed);
        self
    }

    /// What a check of the whole entry says about this field; comes before the field's own range.
    #[must_use]
    pub fn problem(mut self, problem: Option<&'a str>) -> Self {
        self.problem = problem;
        self
    }

    /// Draws the field, its unit and its problem.
    pub fn show(self, ui: &mut Ui) -> Option<QuantityEdited> {
        let complaint = self.refused(ui).or_else(|| self.problem.map(str::to_owned)).or_else(|| {
            let range = self.allowed.as_ref()?;
            range_message(self.value, range, self.unit, self.scale)
        });
        ui.horizontal(|ui| {
            ui.spacing_mut().item_spacing.x = 4.0;
            let edited = self.field(ui, complaint.is_some());
            if !self.unit.is_empty() {
                ui.weak(self.unit);
            }
            if let Some(complaint) = complaint {
                ui.colored_label(theme::palette(ui).error, complaint);
            }
            edited
        })
        .inner
    }

    fn refused_id(&self) -> Id {
        Id::unique(("refused", self.name))
    }

    /// What was typed last and is not a number, for some seconds.
    fn refused(&self, ui: &Ui) -> Option<String> {
        let (text, until_s) = ui.data(|data| data.get_temp::<(String, f64)>(self.refused_id()))?;
        let left_s = until_s - ui.input(|input| input.time);
        if left_s <= 0.0 {
            ui.data_mut(|data| data.remove::<(String, f64)>(self.refused_id()));
            return None;
        }
        ui.ctx().request_repaint_after(Duration::from_secs_f64(left_s));
        Some(format!("'{text}' is not a number"))
    }

    /// The field itself.
    fn field(&self, ui: &mut Ui, wrong: bool) -> Option<QuantityEdited> {
        let shown = self.value * self.scale;
        let logarithmic = self.logarithmic && shown > 0.0;
        let before = if logarithmic { shown.log10() } else { shown };
        let after = Cell::new(before);
        let typed: Cell<Option<f64>> = Cell::new(None);
        let refused: Cell<Option<String>> = Cell::new(None);
        let decimals = self.decimals;
        let text = move |value: f64| decimals.map_or_else(|| short(value), |decimals| fixed(value, decimals));
        let text_before = text(shown);
        let field = DragValue::from_get_set(|new| {
            new.inspect(|&new| after.set(new));
            after.get()
        })
        .speed(if logarithmic { DECADES_PER_POINT } else { self.per_point })
        .update_while_editing(false)
        .min_size(vec2(self.width, ui.spacing().interact_size.y))
        .custom_formatter(move |at, _| text(if logarithmic { 10f64.powf(at) } else { at }))
        .custom_parser(|text| {
            let text = text.trim().replace('\u{2212}', "-");
            if text == text_before {
                return Some(before);
            }
            let value = parse_typed(&text);
            typed.set(value);
            if value.is_none() {
                refused.set(Some(text));
            }
            value.map(|_| before + 1.0)
        });
        let steady = UiBuilder::new().scope_id(Id::unique(("quantity", self.name)));
        let response = ui
            .scope_builder(steady, |ui| {
                if wrong {
                    let stroke = Stroke::new(1.5, theme::palette(ui).error);
                    ui.visuals_mut().widgets.inactive.bg_stroke = stroke;
                    ui.visuals_mut().widgets.hovered.bg_stroke = stroke;
                }
                ui.add(field)
            })
            .inner;
        ui.ctx().accesskit_node_builder(response.id, |node| {
            node.set_label(self.name);
            if !self.unit.is_empty() {
                node.set_description(self.unit);
            }
        });
        self.mark_sought(ui, &response);
        let is_given_up = ui.data(|data| data.get_temp::<()>(response.id.with("given up"))).is_some();
        if let Some(text) = refused.take().filter(|_| !is_given_up) {
            let until_s = ui.input(|input| input.time) + MARKED_S;
            ui.data_mut(|data| data.insert_temp(self.refused_id(), (text, until_s)));
        }
        self.outcome(ui, &response, typed.get(), before, after.get(), logarithmic)
    }

    /// Marks the field while it is sought, and scrolls to it once.
    fn mark_sought(&self, ui: &Ui, response: &egui::Response) {
        let sought = ui.data(|data| data.get_temp::<Sought>(Sought::id()));
        let Some(sought) = sought.filter(|sought| sought.name == self.name) else { return };
        let left_s = sought.until_s - ui.input(|input| input.time);
        if left_s <= 0.0 {
            return ui.data_mut(|data| data.remove::<Sought>(Sought::id()));
        }
        if !sought.is_shown {
            response.scroll_to_me(Some(egui::Align::Center));
            ui.data_mut(|data| data.insert_temp(Sought::id(), Sought { is_shown: true, ..sought }));
        }
        let stroke = Stroke::new(2.0, theme::palette(ui).accent);
        ui.painter().rect_stroke(response.rect.expand(2.0), 3.0, stroke, egui::StrokeKind::Outside);
        ui.ctx().request_repaint_after(Duration::from_secs_f64(left_s));
    }

    /// Turns what the field did into a phase and a value in SI.
    fn outcome(
        &self,
        ui: &Ui,
        response: &egui::Response,
        typed: Option<f64>,
        before: f64,
        after: f64,
        logarithmic: bool,
    ) -> Option<QuantityEdited> {
        let report = |phase, value| Some(QuantityEdited { phase, value });
        let id = response.id.with("held");
        // egui takes the text in the frame after the one in which Escape gave it up.
        let given_up = response.id.with("given up");
        if response.lost_focus() && ui.input(|i| i.key_pressed(Key::Escape)) {
            ui.data_mut(|data| data.insert_temp(given_up, ()));
            return None;
        }
        let was_given_up = ui.data_mut(|data| data.remove_temp::<()>(given_up)).is_some();
        if let Some(typed) = typed {
            if was_given_up {
                return None;
            }
            let value = typed / self.scale;
            return if value == self.value { None } else { report(EditPhase::Commit, value) };
        }
        if response.drag_started() {
            ui.data_mut(|data| data.insert_temp(id, Held { origin: self.value, now: self.value }));
            return report(EditPhase::Begin, self.value);
        }
        let held = ui.data_mut(|data| data.get_temp::<Held>(id));
        if let Some(held) = held {
            let forget = || ui.data_mut(|data| data.remove::<Held>(id));
            if ui.input(|i| i.key_pressed(Key::Escape)) {
                forget();
                ui.ctx().stop_dragging();
                return report(EditPhase::Cancel, held.origin);
            }
            if response.drag_stopped() || !response.dragged() {
                forget();
                return report(EditPhase::Commit, held.now);
            }
        }
        if after == before {
            return None;
        }
        let moved = if logarithmic { 10f64.powf(after) } else { after };
        let now = match self.decimals {
            Some(decimals) => to_decimals(moved, decimals),
            None => rounded(moved, DRAG_DIGITS),
        } / self.scale;
        match held {
            Some(held) => {
                ui.data_mut(|data| data.insert_temp(id, Held { now, ..held }));
                (now != held.now).then_some(QuantityEdited { phase: EditPhase::Change, value: now })
            }
            None => report(EditPhase::Commit, now),
        }
    }
}

/// A number as typed, with a point or one comma before its decimals. A comma before three digits may be one of thousands: no number.
pub fn parse_typed(text: &str) -> Option<f64> {
    let is_clear =
        text.split_once(',').is_some_and(|(before, after)| after.len() != 3 || before.trim_start_matches('-') == "0");
    let is_comma = is_clear && !text.contains('.') && text.matches(',').count() == 1;
    let value: f64 = if is_comma { text.replace(',', ".").parse() } else { text.parse() }.ok()?;
    Some(value).filter(|value| value.is_finite())
}

pub fn to_decimals(value: f64, decimals: usize) -> f64 {
    fixed(value, decimals).parse().unwrap_or(value)
}

/// `value` with as many decimals as its neighbours in a column.
fn fixed(value: f64, decimals: usize) -> String {
    format!("{value:.decimals$}")
}

/// What a field shows: four digits of what is below one, five of the rest.
fn short(value: f64) -> String {
    concise(if value.abs() < 1.0 { rounded(value, 4) } else { value })
}

/// What to say when `value` (SI) is not in `allowed` (SI), in a unit of SI times `scale`.
pub fn range_message(value: f64, allowed: &RangeInclusive<f64>, unit: &str, scale: f64) -> Option<String> {
    if allowed.contains(&value) {
        return None;
    }
    let [low, high] = [*allowed.start(), *allowed.end()].map(|edge| concise(rounded(edge * scale, 4)));
    let unit = if unit.is_empty() { String::new() } else { format!(" {unit}") };
    Some(match (allowed.start().is_finite(), allowed.end().is_finite()) {
        (true, false) => format!("must be at least {low}{unit}"),
        (false, true) => format!("must be at most {high}{unit}"),
        _ => format!("must be {low} to {high}{unit}"),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn range_message_names_the_limits_in_the_unit_shown() {
        let degrees = 180.0 / std::f64::consts::PI;
        let allowed = 0.0..=std::f64::consts::FRAC_PI_2;
        assert_eq!(range_message(0.5, &allowed, "deg", degrees), None);
        assert_eq!(range_message(2.0, &allowed, "deg", degrees).unwrap(), "must be 0 to 90 deg");
        assert_eq!(range_message(-1.0, &(0.0..=f64::INFINITY), "", 1.0).unwrap(), "must be at least 0");
        assert!(range_message(f64::NAN, &allowed, "", 1.0).is_some());
    }

    #[test]
    fn shown_numbers_carry_no_idle_zeros() {
        assert_eq!(concise(0.01), "0.01");
        assert_eq!(concise(1200.0), "1200");
        assert_eq!(concise(5.73e-5), "5.73e-5");
        assert_eq!(concise(-2.0), "-2");
        assert_eq!(concise(0.0), "0");
    }

    #[test]
    fn typed_numbers_have_a_point_or_a_comma() {
        for (text, value) in [
            ("0,05", Some(0.05)),
            ("-1.5e-3", Some(-1.5e-3)),
            ("1,000,000", None),
            ("1,000.5", None),
            ("1,000", None),
            ("0,125", Some(0.125)),
        ] {
            assert_eq!(parse_typed(text), value, "{text}");
        }
        assert_eq!(["abc", "", "inf"].map(parse_typed), [None; 3]);
    }

    #[test]
    fn places_on_a_long_axis_keep_their_decimals() {
        assert_eq!(fixed(1056.8, 3), "1056.800");
        assert_eq!(fixed(123_456.789_4, 3), "123456.789");
        assert_eq!(fixed(300.0, 3), "300.000");
    }

    #[test]
    fn rounding_keeps_significant_digits_exactly() {
        assert_eq!(rounded(0.0123456, 3), 0.0123);
        assert_eq!(rounded(-98765.0, 2), -99000.0);
        assert_eq!(rounded(0.0, 3), 0.0);
    }
}
