//! Input deck of Digital DATCOM from the data of an aircraft file.

use std::path::Path;

use serde::Deserialize;
use thiserror::Error;

use super::DatcomError;
use crate::airframe::{Aircraft, MassProperties};
use crate::atmos::STANDARD_GRAVITY_M_S2;
use crate::toml_error;

/// Longest card the program reads, characters.
const CARD_LENGTH: usize = 80;
/// Largest number of angles of attack and of body stations the program takes.
const MAX_STATIONS: usize = 20;
/// Largest number of control deflections the program takes.
const MAX_DEFLECTIONS: usize = 9;

/// Section `[datcom]` of an aircraft file: the simplified shape the program is given. Lengths in m from the deck's
/// origin (x aft, z up), angles in deg as the program takes them.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DatcomSection {
    /// Name of the configuration.
    pub title: String,
    /// Height of the deck's origin above the origin of the datum axes, m; both have x aft from one plane.
    pub origin_above_datum_m: f64,
    /// Surface roughness height (`ROUGFC`), m.
    pub roughness_m: f64,
    /// Wing.
    pub wing: DeckPlanform,
    /// Horizontal tail.
    pub horizontal_tail: DeckPlanform,
    /// Fuselage.
    pub body: DeckBody,
    /// Twin vertical panels.
    pub twin_vertical: Option<DeckTwinVertical>,
    /// Elevator.
    pub elevator: Option<DeckElevator>,
    /// Ailerons.
    pub aileron: Option<DeckAileron>,
}

/// A wing or horizontal tail of one or two panels per side.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DeckPlanform {
    /// Apex (root leading edge) aft of the origin (`XW`, `XH`), m.
    pub apex_x_m: f64,
    /// Apex above the origin (`ZW`, `ZH`), m.
    pub apex_z_m: f64,
    /// Root incidence (`ALIW`, `ALIH`), deg.
    pub incidence_deg: f64,
    /// Section, a NACA control card.
    pub airfoil: String,
    /// Tip chord (`CHRDTP`), m.
    pub tip_chord_m: f64,
    /// Root chord (`CHRDR`), m.
    pub root_chord_m: f64,
    /// Semispan from the centre line (`SSPN`), m.
    pub semispan_m: f64,
    /// Exposed semispan (`SSPNE`), m.
    pub exposed_semispan_m: f64,
    /// Chord at the break between two panels (`CHRDBP`), m.
    pub break_chord_m: Option<f64>,
    /// Semispan of the outboard panel (`SSPNOP`), m.
    pub outboard_semispan_m: Option<f64>,
    /// Semispan of the outboard panel with dihedral (`SSPNDD`), m.
    pub outboard_dihedral_semispan_m: Option<f64>,
    /// Twist, negative for washout (`TWISTA`), deg.
    pub twist_deg: f64,
    /// Sweep of the inboard panel (`SAVSI`), deg.
    pub inboard_sweep_deg: f64,
    /// Sweep of the outboard panel (`SAVSO`), deg.
    pub outboard_sweep_deg: f64,
    /// Chord fraction the sweeps are given at (`CHSTAT`).
    pub sweep_chord_fraction: f64,
    /// Dihedral of the inboard panel (`DHDADI`), deg.
    pub dihedral_deg: f64,
}

/// A fuselage at stations along x.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DeckBody {
    /// Stations (`X`), m.
    pub x_m: Vec<f64>,
    /// Perimeters (`P`), m.
    pub perimeter_m: Vec<f64>,
    /// Cross-section areas (`S`), m².
    pub area_m2: Vec<f64>,
    /// Half widths (`R`), m.
    pub half_width_m: Vec<f64>,
    /// Heights of the upper contour (`ZU`), m.
    pub upper_z_m: Vec<f64>,
    /// Heights of the lower contour (`ZL`), m.
    pub lower_z_m: Vec<f64>,
}

/// Twin vertical panels (`TVTPAN`).
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DeckTwinVertical {
    /// Span above the lifting surface (`BVP`), m.
    pub span_above_surface_m: f64,
    /// Span (`BV`), m.
    pub span_m: f64,
    /// Body depth at the quarter chord (`BDV`), m.
    pub body_depth_m: f64,
    /// Distance between the panels (`BH`), m.
    pub separation_m: f64,
    /// Area of one panel (`SV`), m².
    pub area_m2: f64,
    /// Trailing-edge angle (`VPHITE`), deg.
    pub trailing_edge_angle_deg: f64,
    /// Quarter chord aft of the moment reference (`VLP`), m.
    pub arm_x_m: f64,
    /// Centroid above the moment reference (`ZP`), m.
    pub arm_z_m: f64,
}

/// A plain elevator (`SYMFLP`); deflections trailing edge down positive.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DeckElevator {
    /// Deflections (`DELTA`), deg.
    pub deflection_deg: Vec<f64>,
    /// Chord at the inboard end (`CHRDFI`), m.
    pub inboard_chord_m: f64,
    /// Chord at the outboard end (`CHRDFO`), m.
    pub outboard_chord_m: f64,
    /// Inboard end (`SPANFI`), m from the centre line.
    pub inboard_span_m: f64,
    /// Outboard end (`SPANFO`), m.
    pub outboard_span_m: f64,
}

/// Plain ailerons (`ASYFLP`); deflections trailing edge down positive.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DeckAileron {
    /// Left aileron (`DELTAL`), deg.
    pub left_deg: Vec<f64>,
    /// Right aileron (`DELTAR`), deg.
    pub right_deg: Vec<f64>,
    /// Chord at the inboard end (`CHRDFI`), m.
    pub inboard_chord_m: f64,
    /// Chord at the outboard end (`CHRDFO`), m.
    pub outboard_chord_m: f64,
    /// Inboard end (`SPANFI`), m from the centre line.
    pub inboard_span_m: f64,
    /// Outboard end (`SPANFO`), m.
    pub outboard_span_m: f64,
}

/// What the aircraft and its loading give: SI.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DeckReference {
    /// Reference area, m².
    pub area_m2: f64,
    /// Reference chord, m.
    pub chord_m: f64,
    /// Reference span, m.
    pub span_m: f64,
    /// Centre of gravity in datum axes, m: the moment reference.
    pub cg_from_datum_m: [f64; 3],
    /// Weight, N.
    pub weight_n: f64,
}

/// Flight condition of a deck.
#[derive(Clone, Debug, PartialEq)]
pub struct DeckCondition {
    /// Mach number.
    pub mach: f64,
    /// Altitude, m.
    pub altitude_m: f64,
    /// Angles of attack, deg, increasing.
    pub alpha_deg: Vec<f64>,
}

/// A deck: one case with the elevator and, where the section has ailerons, a second with these.
#[derive(Clone, Debug, PartialEq)]
pub struct DatcomDeck {
    /// From the aircraft and its loading.
    pub reference: DeckReference,
    /// Flight condition.
    pub condition: DeckCondition,
    /// From the aircraft file.
    pub section: DatcomSection,
}

/// A deck the program would not accept.
#[derive(Clone, Debug, PartialEq, Error)]
#[expect(missing_docs, reason = "the messages say what variants and fields are")]
pub enum DeckError {
    #[error("datcom.{field} has {found} values, allowed are 1 to {most}")]
    Length { field: &'static str, found: usize, most: usize },
    #[error("datcom.{field} has {found} values where its stations have {expected}")]
    Mismatch { field: &'static str, found: usize, expected: usize },
    #[error("datcom: {card} is {value}, allowed is a finite number")]
    Value { card: String, value: f64 },
    #[error("datcom: '{text}' does not fit on a card of 80 ASCII characters without '$'")]
    Text { text: String },
}

/// The cards written so far.
struct Cards(String);

impl DeckReference {
    /// Reference dimensions of `aircraft`, with the centre of gravity and the weight `m g` (standard gravity) of its
    /// loading.
    pub fn from_aircraft(aircraft: &Aircraft, properties: &MassProperties) -> Self {
        Self {
            area_m2: aircraft.reference.area_m2,
            chord_m: aircraft.reference.chord_m,
            span_m: aircraft.reference.span_m,
            cg_from_datum_m: properties.cg_from_datum_m,
            weight_n: properties.mass_kg * STANDARD_GRAVITY_M_S2,
        }
    }
}

impl DatcomSection {
    /// Reads the `[datcom]` section of an aircraft file, `None` where it has none.
    ///
    /// # Errors
    /// [`DatcomError`] naming the file and, for syntax, the line.
    pub fn read(aircraft: &Path) -> Result<Option<Self>, DatcomError> {
        #[derive(Deserialize)]
        struct AircraftFile {
            datcom: Option<DatcomSection>,
        }
        let path = || aircraft.to_owned();
        let text = crate::load::read_text(aircraft).map_err(|source| DatcomError::Read { path: path(), source })?;
        let file: AircraftFile = toml::from_str(&text).map_err(|error| DatcomError::Section {
            path: path(),
            line: toml_error::line(&text, &error).unwrap_or(1),
            message: toml_error::message(&error),
        })?;
        Ok(file.datcom)
    }
}

impl DatcomDeck {
    /// The deck as text: metric, derivatives per radian, with the component build-up and the damping derivatives.
    ///
    /// The centre of gravity goes in as the moment reference, `XCG = x`, `ZCG = z` less the height of the deck's
    /// origin. Numbers are written with all their digits.
    ///
    /// # Errors
    /// [`DeckError`] naming the field or card.
    pub fn to_text(&self) -> Result<String, DeckError> {
        self.check()?;
        let section = &self.section;
        let mut cards = Cards(String::new());
        cards.control(&format!("CASEID ----- {}, elevator -----", section.title))?;
        for card in ["DIM M", "DERIV RAD", "BUILD"] {
            cards.control(card)?;
        }
        self.flight_condition(&mut cards)?;
        section.body.write(&mut cards)?;
        section.wing.write("WGPLNF", &mut cards)?;
        section.horizontal_tail.write("HTPLNF", &mut cards)?;
        if let Some(panels) = &section.twin_vertical {
            panels.write(&mut cards)?;
        }
        if let Some(elevator) = &section.elevator {
            cards.list(
                "SYMFLP",
                &[
                    ("FTYPE", &[1.0]),
                    ("NTYPE", &[1.0]),
                    ("NDELTA", &[elevator.deflection_deg.len() as f64]),
                    ("DELTA(1)", &elevator.deflection_deg),
                    ("CHRDFI", &[elevator.inboard_chord_m]),
                    ("CHRDFO", &[elevator.outboard_chord_m]),
                    ("SPANFI", &[elevator.inboard_span_m]),
                    ("SPANFO", &[elevator.outboard_span_m]),
                ],
            )?;
        }
        cards.control(&section.wing.airfoil)?;
        cards.control(&section.horizontal_tail.airfoil)?;
        if let Some(aileron) = &section.aileron {
            for card in ["SAVE", "NEXT CASE"] {
                cards.control(card)?;
            }
            cards.control(&format!("CASEID ----- {}, aileron -----", section.title))?;
            cards.list(
                "ASYFLP",
                &[
                    ("STYPE", &[4.0]),
                    ("NDELTA", &[aileron.left_deg.len() as f64]),
                    ("DELTAL", &aileron.left_deg),
                    ("DELTAR", &aileron.right_deg),
                    ("CHRDFI", &[aileron.inboard_chord_m]),
                    ("CHRDFO", &[aileron.outboard_chord_m]),
                    ("SPANFI", &[aileron.inboard_span_m]),
                    ("SPANFO", &[aileron.outboard_span_m]),
                ],
            )?;
        }
        cards.control("DAMP")?;
        Ok(cards.0)
    }

    /// Flight condition, reference dimensions and positions.
    fn flight_condition(&self, cards: &mut Cards) -> Result<(), DeckError> {
        let (reference, condition, section) = (&self.reference, &self.condition, &self.section);
        cards.list(
            "FLTCON",
            &[
                ("NMACH", &[1.0]),
                ("MACH(1)", &[condition.mach]),
                ("NALT", &[1.0]),
                ("ALT(1)", &[condition.altitude_m]),
                ("NALPHA", &[condition.alpha_deg.len() as f64]),
                ("ALSCHD", &condition.alpha_deg),
                ("WT", &[reference.weight_n]),
                ("GAMMA", &[0.0]),
                ("LOOP", &[2.0]),
            ],
        )?;
        cards.list(
            "OPTINS",
            &[
                ("SREF", &[reference.area_m2]),
                ("CBARR", &[reference.chord_m]),
                ("BLREF", &[reference.span_m]),
                ("ROUGFC", &[section.roughness_m]),
            ],
        )?;
        let [x, _, z] = reference.cg_from_datum_m;
        cards.list(
            "SYNTHS",
            &[
                ("XCG", &[x]),
                ("ZCG", &[without_round_off(z - section.origin_above_datum_m)]),
                ("XW", &[section.wing.apex_x_m]),
                ("ZW", &[section.wing.apex_z_m]),
                ("ALIW", &[section.wing.incidence_deg]),
                ("ALIH", &[section.horizontal_tail.incidence_deg]),
                ("XH", &[section.horizontal_tail.apex_x_m]),
                ("ZH", &[section.horizontal_tail.apex_z_m]),
            ],
        )
    }

    /// Checks the lengths of all lists.
    fn check(&self) -> Result<(), DeckError> {
        length("condition.alpha_deg", &self.condition.alpha_deg, MAX_STATIONS)?;
        let body = &self.section.body;
        length("body.x_m", &body.x_m, MAX_STATIONS)?;
        for (field, list) in [
            ("body.perimeter_m", &body.perimeter_m),
            ("body.area_m2", &body.area_m2),
            ("body.half_width_m", &body.half_width_m),
            ("body.upper_z_m", &body.upper_z_m),
            ("body.lower_z_m", &body.lower_z_m),
        ] {
            same_length(field, list, &body.x_m)?;
        }
        if let Some(elevator) = &self.section.elevator {
            length("elevator.deflection_deg", &elevator.deflection_deg, MAX_DEFLECTIONS)?;
        }
        if let Some(aileron) = &self.section.aileron {
            length("aileron.left_deg", &aileron.left_deg, MAX_DEFLECTIONS)?;
            same_length("aileron.right_deg", &aileron.right_deg, &aileron.left_deg)?;
        }
        Ok(())
    }
}

impl DeckPlanform {
    fn write(&self, name: &str, cards: &mut Cards) -> Result<(), DeckError> {
        let straight_tapered = 1.0;
        let optional = [
            ("CHRDBP", self.break_chord_m),
            ("SSPNOP", self.outboard_semispan_m),
            ("SSPNDD", self.outboard_dihedral_semispan_m),
        ]
        .map(|(card, value)| (card, value.map(|v| [v])));
        let mut list: Vec<(&str, &[f64])> = Vec::new();
        let chord = [self.tip_chord_m];
        list.push(("CHRDTP", &chord));
        for (card, value) in &optional[..2] {
            list.extend(value.as_ref().map(|v| (*card, v.as_slice())));
        }
        let root = [self.root_chord_m];
        list.push(("CHRDR", &root));
        list.extend(optional[2].1.as_ref().map(|v| (optional[2].0, v.as_slice())));
        let rest = [
            ("TWISTA", [self.twist_deg]),
            ("SSPNE", [self.exposed_semispan_m]),
            ("SSPN", [self.semispan_m]),
            ("SAVSO", [self.outboard_sweep_deg]),
            ("DHDADI", [self.dihedral_deg]),
            ("CHSTAT", [self.sweep_chord_fraction]),
            ("SAVSI", [self.inboard_sweep_deg]),
            ("TYPE", [straight_tapered]),
        ];
        list.extend(rest.iter().map(|(card, value)| (*card, value.as_slice())));
        cards.list(name, &list)
    }
}

impl DeckBody {
    fn write(&self, cards: &mut Cards) -> Result<(), DeckError> {
        cards.list(
            "BODY",
            &[
                ("NX", &[self.x_m.len() as f64]),
                ("ITYPE", &[1.0]),
                ("METHOD", &[1.0]),
                ("X(1)", &self.x_m),
                ("P(1)", &self.perimeter_m),
                ("S(1)", &self.area_m2),
                ("R(1)", &self.half_width_m),
                ("ZU(1)", &self.upper_z_m),
                ("ZL(1)", &self.lower_z_m),
            ],
        )
    }
}

impl DeckTwinVertical {
    fn write(&self, cards: &mut Cards) -> Result<(), DeckError> {
        cards.list(
            "TVTPAN",
            &[
                ("BVP", &[self.span_above_surface_m]),
                ("BH", &[self.separation_m]),
                ("VLP", &[self.arm_x_m]),
                ("BV", &[self.span_m]),
                ("SV", &[self.area_m2]),
                ("ZP", &[self.arm_z_m]),
                ("BDV", &[self.body_depth_m]),
                ("VPHITE", &[self.trailing_edge_angle_deg]),
            ],
        )
    }
}

impl Cards {
    fn control(&mut self, text: &str) -> Result<(), DeckError> {
        if text.len() > CARD_LENGTH || text.contains('$') || !text.chars().all(|c| matches!(c, ' '..='~')) {
            return Err(DeckError::Text { text: text.chars().take(CARD_LENGTH).collect() });
        }
        self.0.push_str(text);
        self.0.push('\n');
        Ok(())
    }

    /// A namelist, one variable per card; a list too long for a card continues on the next.
    fn list(&mut self, name: &str, variables: &[(&str, &[f64])]) -> Result<(), DeckError> {
        self.0.push_str(&format!(" ${name}\n"));
        for (index, (variable, values)) in variables.iter().enumerate() {
            let mut card = format!("  {variable}=");
            for (k, &value) in values.iter().enumerate() {
                if !value.is_finite() {
                    return Err(DeckError::Value { card: (*variable).to_owned(), value });
                }
                let last = index + 1 == variables.len() && k + 1 == values.len();
                let text = format!("{value:?}{}", if last { "$" } else { "," }).replace('e', "E");
                if card.len() + text.len() > CARD_LENGTH {
                    self.0.push_str(&card);
                    self.0.push('\n');
                    card = "    ".to_owned();
                }
                card.push_str(&text);
            }
            self.0.push_str(&card);
            self.0.push('\n');
        }
        Ok(())
    }
}

/// A difference of two lengths without the digits below 0.001 mm that subtraction leaves.
fn without_round_off(length_m: f64) -> f64 {
    (length_m * 1e6).round() / 1e6
}

/// Checks that `list` has 1 to `most` values.
fn length(field: &'static str, list: &[f64], most: usize) -> Result<(), DeckError> {
    if (1..=most).contains(&list.len()) {
        return Ok(());
    }
    Err(DeckError::Length { field, found: list.len(), most })
}

/// Checks that `list` is as long as `stations`.
fn same_length(field: &'static str, list: &[f64], stations: &[f64]) -> Result<(), DeckError> {
    if list.len() == stations.len() {
        return Ok(());
    }
    Err(DeckError::Mismatch { field, found: list.len(), expected: stations.len() })
}
