//! An aircraft described in the few numbers derivatives need.

use doublet_core::airframe::AircraftClass;
use doublet_engine::begin::PlainAircraft;
use eframe::egui::{ComboBox, DragValue, Grid, TextEdit, Ui, vec2};

/// The numbers being typed.
pub struct AircraftForm {
    aircraft: PlainAircraft,
    /// The class whose radii of gyration give the inertia, where it is not typed; and the length they need, m.
    class: Option<AircraftClass>,
    length_m: f64,
    /// Whether it has been drawn.
    has_begun: bool,
}

impl Default for AircraftForm {
    fn default() -> Self {
        let aircraft = PlainAircraft {
            name: "my aircraft".to_owned(),
            area_m2: 16.0,
            span_m: 11.0,
            chord_m: 1.5,
            mass_kg: 1000.0,
            moments_kg_m2: [1300.0, 1800.0, 2700.0],
            xz_kg_m2: 0.0,
            note: None,
        };
        Self { aircraft, class: None, length_m: 8.0, has_begun: false }
    }
}

impl AircraftForm {
    pub fn name(&self) -> &str {
        &self.aircraft.name
    }

    /// The aircraft as the text of its file.
    pub fn text(&self) -> Result<String, String> {
        self.aircraft.text()
    }

    pub fn show(&mut self, ui: &mut Ui) {
        let aircraft = &mut self.aircraft;
        Grid::new("own aircraft").num_columns(8).spacing([8.0, 3.0]).show(ui, |ui| {
            ui.label("Name");
            let name = ui.add(TextEdit::singleline(&mut aircraft.name).desired_width(110.0).min_size(vec2(118.0, 0.0)));
            ui.ctx().accesskit_node_builder(name.id, |node| node.set_label("name of the aircraft"));
            if !std::mem::replace(&mut self.has_begun, true) {
                name.request_focus();
            }
            number(ui, "Reference area", "m²", &mut aircraft.area_m2);
            number(ui, "Span", "m", &mut aircraft.span_m);
            number(ui, "Mean chord", "m", &mut aircraft.chord_m);
            ui.end_row();
            number(ui, "Mass", "kg", &mut aircraft.mass_kg);
            if self.class.is_some() {
                number(ui, "Length", "m", &mut self.length_m);
            } else {
                inertia(ui, aircraft);
            }
            ui.end_row();
        });
        ui.horizontal(|ui| {
            ui.label("Inertia");
            let words = |class: Option<AircraftClass>| class.map_or("as typed", AircraftClass::name);
            ComboBox::from_id_salt("class of the aircraft").selected_text(words(self.class)).show_ui(ui, |ui| {
                for class in std::iter::once(None).chain(AircraftClass::ALL.map(Some)) {
                    ui.selectable_value(&mut self.class, class, words(class));
                }
            });
            match self.class {
                None => self.aircraft.note = None,
                Some(class) => {
                    self.aircraft.set_inertia(class, self.length_m);
                    let [xx, yy, zz] = self.aircraft.moments_kg_m2;
                    ui.weak(format!("from radii of gyration: {xx:.0}, {yy:.0}, {zz:.0} kg m² (rough); enter measured values if known"));
                }
            }
        });
        ui.weak("Mass and inertia are those of the flight. Stations, fuel and engines can be added to the file later.");
    }
}

/// The moments and the product of inertia, typed.
fn inertia(ui: &mut Ui, aircraft: &mut PlainAircraft) {
    let [xx, yy, zz] = &mut aircraft.moments_kg_m2;
    number(ui, "Ixx", "kg m²", xx);
    number(ui, "Iyy", "kg m²", yy);
    number(ui, "Izz", "kg m²", zz);
    ui.end_row();
    number(ui, "Ixz", "kg m²", &mut aircraft.xz_kg_m2);
}

fn number(ui: &mut Ui, name: &str, unit: &str, value: &mut f64) {
    ui.label(name);
    let field = ui.add(DragValue::new(value).speed(0.1).max_decimals(4).suffix(format!(" {unit}")));
    ui.ctx().accesskit_node_builder(field.id, |node| node.set_label(name));
}
