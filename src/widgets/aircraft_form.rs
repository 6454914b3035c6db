//! An aircraft described in the few numbers derivatives need.

use doublet_core::airframe::AircraftClass;
use doublet_engine::begin::PlainAircraft;
use doublet_engine::builtin;
use eframe::egui::{ComboBox, Grid, RichText, TextEdit, Ui, vec2};

use super::quantity_edit::parse_typed;
use crate::{notation, theme};

/// Width of a number, points.
const NUMBER: f32 = 92.0;
/// Numbers of the form: name, unit, and the guess where none is typed.
const NUMBERS: [(&str, &str, f64); 9] = [
    ("Reference area", "m²", 16.0),
    ("Span", "m", 11.0),
    ("Mean chord", "m", 1.5),
    ("Mass", "kg", 1000.0),
    ("Length", "m", 8.0),
    ("Ixx", "kg m²", 1300.0),
    ("Iyy", "kg m²", 1800.0),
    ("Izz", "kg m²", 2700.0),
    ("Ixz", "kg m²", 0.0),
];
/// Places of the numbers: reference, mass, length, inertia.
const REFERENCE: std::ops::Range<usize> = 0..3;
const MASS: usize = 3;
const LENGTH: usize = 4;
const INERTIA: std::ops::Range<usize> = 5..9;

/// What the file of a shipped aircraft calls it.
pub fn shipped_name(file: &str) -> &str {
    builtin::text("aircraft", file).and_then(stated_name).unwrap_or(file)
}

/// The name that the text of an aircraft file states.
pub fn stated_name(text: &str) -> Option<&str> {
    text.lines().find_map(|line| line.strip_prefix("name = \"")?.strip_suffix('"'))
}

/// The numbers being typed.
#[derive(Default)]
pub struct AircraftForm {
    name: String,
    typed: [String; NUMBERS.len()],
    /// The class whose radii of gyration give the inertia, where it is not typed.
    class: Option<AircraftClass>,
    /// Whether it has been drawn.
    has_begun: bool,
}

impl AircraftForm {
    pub fn name(&self) -> &str {
        if self.name.trim().is_empty() { "my aircraft" } else { self.name.trim() }
    }

    /// The aircraft as the text of its file.
    pub fn text(&self) -> Result<String, String> {
        self.aircraft()?.text()
    }

    /// The aircraft of what is typed and of guesses.
    fn aircraft(&self) -> Result<PlainAircraft, String> {
        let mut values = [0.0; NUMBERS.len()];
        for (at, value) in values.iter_mut().enumerate() {
            *value = self.value(at)?;
        }
        let [area_m2, span_m, chord_m, mass_kg, length_m, xx, yy, zz, xz_kg_m2] = values;
        let name = self.name().to_owned();
        let moments_kg_m2 = [xx, yy, zz];
        let mut aircraft =
            PlainAircraft { name, area_m2, span_m, chord_m, mass_kg, moments_kg_m2, xz_kg_m2, note: None };
        if let Some(class) = self.class {
            aircraft.set_inertia(class, length_m);
        }
        let guessed = self.guessed();
        if !guessed.is_empty() {
            let guessed = format!("Guessed, not measured: {}. Enter the real values.", guessed.join(", "));
            aircraft.note = Some(aircraft.note.map_or(guessed.clone(), |note| format!("{note} {guessed}")));
        }
        Ok(aircraft)
    }

    /// A number as typed; its guess where nothing is.
    fn value(&self, at: usize) -> Result<f64, String> {
        let (name, unit, guess) = NUMBERS[at];
        match self.typed[at].trim() {
            "" => Ok(guess),
            text => parse_typed(text).ok_or_else(|| format!("{name}: '{text}' is not a number: enter it in {unit}")),
        }
    }

    /// Names of the numbers in use that are guesses.
    fn guessed(&self) -> Vec<&'static str> {
        let is_used = |at: &usize| match self.class {
            Some(_) => !INERTIA.contains(at),
            None => *at != LENGTH,
        };
        let open = (0..NUMBERS.len()).filter(is_used).filter(|at| self.typed[*at].trim().is_empty());
        open.map(|at| NUMBERS[at].0).collect()
    }

    pub fn show(&mut self, ui: &mut Ui) {
        Grid::new("own aircraft").num_columns(8).spacing([8.0, 3.0]).show(ui, |ui| {
            ui.label("Name");
            let name = TextEdit::singleline(&mut self.name).hint_text("my aircraft").desired_width(110.0);
            let name = ui.add(name.min_size(vec2(118.0, 0.0)));
            ui.ctx().accesskit_node_builder(name.id, |node| node.set_label("name of the aircraft"));
            if !std::mem::replace(&mut self.has_begun, true) {
                name.request_focus();
            }
            REFERENCE.for_each(|at| self.number(ui, at));
            ui.end_row();
            self.number(ui, MASS);
            if self.class.is_some() {
                self.number(ui, LENGTH);
            } else {
                for at in INERTIA {
                    // The product of inertia is in a row of its own.
                    if at + 1 == INERTIA.end {
                        ui.end_row();
                    }
                    self.number(ui, at);
                }
            }
            ui.end_row();
        });
        self.inertia_source(ui);
        self.state(ui);
    }

    /// Where the inertia comes from.
    fn inertia_source(&mut self, ui: &mut Ui) {
        ui.horizontal(|ui| {
            ui.label("Inertia");
            let words = |class: Option<AircraftClass>| class.map_or("as typed", AircraftClass::name);
            ComboBox::from_id_salt("class of the aircraft").selected_text(words(self.class)).show_ui(ui, |ui| {
                for class in std::iter::once(None).chain(AircraftClass::ALL.map(Some)) {
                    ui.selectable_value(&mut self.class, class, words(class));
                }
            });
            if self.class.is_some()
                && let Ok(aircraft) = self.aircraft()
            {
                let [xx, yy, zz] = aircraft.moments_kg_m2;
                ui.weak(format!(
                    "from radii of gyration: {xx:.0}, {yy:.0}, {zz:.0} kg m² (rough); enter measured values if known"
                ));
            }
        });
    }

    /// What is wrong or guessed, and what the numbers are.
    fn state(&self, ui: &mut Ui) {
        let palette = theme::palette(ui);
        let guessed = self.guessed();
        ui.weak("Mass and inertia are those of the flight. Stations, fuel and engines can be added to the file later.");
        let (text, color) = match self.aircraft() {
            Err(line) => (line, palette.error),
            Ok(_) if guessed.is_empty() => (String::new(), palette.warning),
            Ok(_) => (format!("Guesses, not values of your aircraft: {}", guessed.join(", ")), palette.warning),
        };
        // Its line is kept where it says nothing: the buttons below do not move while numbers are typed.
        ui.label(RichText::new(text).color(color));
    }

    /// A field for a number, with its guess as a hint.
    fn number(&mut self, ui: &mut Ui, at: usize) {
        let (name, unit, guess) = NUMBERS[at];
        ui.label(name);
        ui.horizontal(|ui| {
            ui.spacing_mut().item_spacing.x = 4.0;
            let hint = format!("guess {}", notation::number(guess));
            let field = TextEdit::singleline(&mut self.typed[at]).hint_text(hint).desired_width(NUMBER);
            let field = ui.add(field);
            ui.ctx().accesskit_node_builder(field.id, |node| node.set_label(name));
            ui.weak(unit);
        });
    }
}
