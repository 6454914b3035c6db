//! Aircraft files: TOML text to [`Aircraft`].
//!
//! A file starts with `format = "doublet aircraft"` and `version = 1`. Positions are in datum axes (`_datum_m`: x aft,
//! y right, z up), inertias in body axes with products of positive sign. Unknown keys are refused with their line.
//!
//! | section | keys, optional ones in parentheses |
//! |---|---|
//! | top | `name`, (`notes`) |
//! | `[reference]` | `area_m2`, `span_m`, `chord_m`, (`lateral_moment_length_m`: span, `lateral_rate_length_m`: span / 2, `pitch_rate_length_m`: chord) |
//! | `[mass]` | `mass_kg`, `cg_datum_m` of the empty aircraft, (`max_takeoff_kg`, `max_landing_kg`, `fuel`: "add_all" or "add_usable") |
//! | `[inertia]` | `moments_kg_m2` and (`products_kg_m2`) of the empty aircraft, or `[[inertia.group]]`: `name`, `mass_kg`, `centroid_datum_m`, (`inertia`), with (`products_kg_m2`) the sum of the groups' own products |
//! | `[stall]` | `airspeed_m_s` calibrated, `mass_kg`: without flaps and power |
//! | `[[tank]]` | `name`, `capacity_kg`, `cg_datum_m`, (`unusable_kg`, `inertia`) |
//! | `[[seat]]`, `[[luggage]]` | `name`, `cg_datum_m`, (`capacity_kg`, `inertia`) |
//! | `[[fixed_item]]` | `name`, `mass_kg`, `cg_datum_m` |
//! | `[loading]` | (`fuel_kg`, `seats_kg`, `luggage_kg`: mass by name; `[[loading.added_item]]`) |
//! | `[[envelope]]` | `mass_kg`, `forward_x_m`, `aft_x_m`, lightest first |
//! | `[datum]`, `[mean_chord]`, `[[wing_panel]]`, `[wheels]`, `[sensors]`, `[[engine]]`, `[moment_reference]`, `[gyration_radii]`, `[[component_fraction]]` | all optional, as `[propulsion]` and `[datcom]`, left to their own readers |
//!
//! The shape of a part, `inertia`, is `"point"` (the default), `{ given = { moments_kg_m2, products_kg_m2, at_mass_kg } }`,
//! `{ rod = { length_m, along } }`, `{ cuboid = { length_m, width_m, height_m } }` or `{ propeller = { radius_m } }`.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use serde::Deserialize;
use serde::de::IgnoredAny;
use thiserror::Error;

use super::FileHeader;
use crate::airframe::{
    Aircraft, AircraftError, Axis, ComponentFraction, EngineStation, Envelope, EnvelopeRow, FixedItem, FlightEnvelope,
    FuelBookkeeping, GyrationRadii, InertiaGroup, InertiaModel, InertiaTensor, Loading, MassLimits, MeanChord,
    OwnInertia, ReferenceGeometry, SensorStations, Stall, Station, Tank, WheelStations, WingPanel,
};
use crate::toml_error;

/// First line of every aircraft file.
pub const FORMAT: &str = "doublet aircraft";
/// Version this reads.
const VERSION: u32 = 1;

/// Why an aircraft file cannot be used.
#[derive(Debug, Error)]
#[expect(missing_docs, reason = "the messages say what variants and fields are")]
pub enum AircraftFileError {
    #[error("cannot read {}: {source}", path.display())]
    Unreadable { path: PathBuf, source: std::io::Error },
    #[error("not an aircraft file: format is '{found}', expected '{FORMAT}'")]
    Format { found: String },
    #[error("version of the aircraft file is {found}, this program reads {VERSION}: use a newer program")]
    Version { found: u32 },
    /// A key is unknown, missing or of the wrong kind.
    #[error("line {line}: {message}")]
    Syntax { line: usize, message: String },
    #[error("{}", errors.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n"))]
    Impossible { errors: Vec<AircraftError> },
}

/// Reads and checks an aircraft file.
///
/// # Errors
/// [`AircraftFileError`]: unreadable, not an aircraft file, an unknown or missing key with its line, or impossible data.
pub fn read(path: &Path) -> Result<Aircraft, AircraftFileError> {
    let text = crate::load::read_text(path)
        .map_err(|source| AircraftFileError::Unreadable { path: path.to_owned(), source })?;
    parse(&text)
}

/// Reads and checks the text of an aircraft file.
pub fn parse(text: &str) -> Result<Aircraft, AircraftFileError> {
    let header: FileHeader = toml::from_str(text).map_err(|error| syntax(text, &error))?;
    if header.format != FORMAT {
        return Err(AircraftFileError::Format { found: header.format });
    }
    if header.version != VERSION {
        return Err(AircraftFileError::Version { found: header.version });
    }
    let raw: RawAircraft = toml::from_str(text).map_err(|error| syntax(text, &error))?;
    let aircraft = raw.into_aircraft().map_err(|error| AircraftFileError::Impossible { errors: vec![error] })?;
    aircraft.check().map_err(|errors| AircraftFileError::Impossible { errors })?;
    Ok(aircraft)
}

/// JSON Schema of aircraft files.
pub fn schema() -> Result<serde_json::Value, crate::schema::Refused> {
    crate::schema::schema_of::<RawAircraft>(FORMAT)
}

fn syntax(text: &str, error: &toml::de::Error) -> AircraftFileError {
    let line = toml_error::line(text, error).unwrap_or(1);
    AircraftFileError::Syntax { line, message: toml_error::message(error) }
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawAircraft {
    #[serde(rename = "format")]
    _format: String,
    #[serde(rename = "version")]
    _version: u32,
    name: String,
    #[serde(default)]
    notes: Vec<String>,
    reference: RawReference,
    #[serde(default)]
    datum: RawDatum,
    mean_chord: Option<MeanChord>,
    #[serde(default)]
    wing_panel: Vec<WingPanel>,
    mass: RawMass,
    stall: Option<Stall>,
    #[serde(default)]
    flight_envelope: FlightEnvelope,
    #[serde(default)]
    fixed_item: Vec<RawItem>,
    #[serde(default)]
    tank: Vec<RawTank>,
    #[serde(default)]
    seat: Vec<RawStation>,
    #[serde(default)]
    luggage: Vec<RawStation>,
    #[serde(default)]
    envelope: Vec<EnvelopeRow>,
    inertia: RawInertia,
    #[serde(default)]
    loading: RawLoading,
    wheels: Option<WheelStations>,
    #[serde(default)]
    sensors: SensorStations,
    moment_reference: Option<RawPoint>,
    #[serde(default)]
    component_fraction: Vec<RawFraction>,
    gyration_radii: Option<GyrationRadii>,
    #[serde(default)]
    engine: Vec<RawEngine>,
    #[serde(rename = "propulsion")]
    _propulsion: Option<IgnoredAny>,
    #[serde(rename = "datcom")]
    _datcom: Option<IgnoredAny>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawReference {
    area_m2: f64,
    span_m: f64,
    chord_m: f64,
    lateral_moment_length_m: Option<f64>,
    lateral_rate_length_m: Option<f64>,
    pitch_rate_length_m: Option<f64>,
}

#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields)]
struct RawDatum {
    origin: String,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawMass {
    mass_kg: f64,
    cg_datum_m: [f64; 3],
    max_takeoff_kg: Option<f64>,
    max_landing_kg: Option<f64>,
    #[serde(default)]
    fuel: FuelBookkeeping,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawItem {
    name: String,
    mass_kg: f64,
    cg_datum_m: [f64; 3],
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawTank {
    name: String,
    capacity_kg: f64,
    #[serde(default)]
    unusable_kg: f64,
    cg_datum_m: [f64; 3],
    #[serde(default)]
    inertia: RawShape,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawStation {
    name: String,
    capacity_kg: Option<f64>,
    cg_datum_m: [f64; 3],
    #[serde(default)]
    inertia: RawShape,
}

#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "snake_case")]
enum RawShape {
    #[default]
    Point,
    Given {
        moments_kg_m2: [f64; 3],
        #[serde(default)]
        products_kg_m2: RawProducts,
        at_mass_kg: Option<f64>,
    },
    Rod {
        length_m: f64,
        along: Axis,
    },
    Cuboid {
        length_m: f64,
        width_m: f64,
        height_m: f64,
    },
    Propeller {
        radius_m: f64,
    },
}

#[derive(Clone, Copy, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
struct RawProducts {
    xy: f64,
    xz: f64,
    yz: f64,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawInertia {
    moments_kg_m2: Option<[f64; 3]>,
    #[serde(default)]
    products_kg_m2: RawProducts,
    #[serde(default)]
    group: Vec<RawGroup>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawGroup {
    name: String,
    mass_kg: f64,
    centroid_datum_m: [f64; 3],
    #[serde(default)]
    inertia: RawShape,
}

#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
struct RawLoading {
    fuel_kg: BTreeMap<String, f64>,
    seats_kg: BTreeMap<String, f64>,
    luggage_kg: BTreeMap<String, f64>,
    added_item: Vec<RawItem>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawPoint {
    position_datum_m: [f64; 3],
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawFraction {
    name: String,
    mean_percent: f64,
    deviation_percent: f64,
    attributed_kg: f64,
    #[serde(default)]
    methods_percent: BTreeMap<String, f64>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawEngine {
    name: String,
    position_datum_m: [f64; 3],
    #[serde(default)]
    incidence_deg: f64,
}

impl RawReference {
    fn into_reference(self) -> ReferenceGeometry {
        let usual = ReferenceGeometry::conventional(self.area_m2, self.span_m, self.chord_m);
        ReferenceGeometry {
            lateral_moment_length_m: self.lateral_moment_length_m.unwrap_or(usual.lateral_moment_length_m),
            lateral_rate_length_m: self.lateral_rate_length_m.unwrap_or(usual.lateral_rate_length_m),
            pitch_rate_length_m: self.pitch_rate_length_m.unwrap_or(usual.pitch_rate_length_m),
            ..usual
        }
    }
}

fn tensor([xx, yy, zz]: [f64; 3], products: RawProducts) -> InertiaTensor {
    InertiaTensor { xx, yy, zz, xz: products.xz, xy: products.xy, yz: products.yz }
}

impl RawShape {
    /// The shape of a part called `field`; a stated tensor without a mass belongs to `default_mass_kg`.
    fn into_shape(self, field: &str, default_mass_kg: Option<f64>) -> Result<OwnInertia, AircraftError> {
        Ok(match self {
            Self::Point => OwnInertia::Point,
            Self::Given { moments_kg_m2, products_kg_m2, at_mass_kg } => OwnInertia::Given {
                tensor: tensor(moments_kg_m2, products_kg_m2),
                at_mass_kg: at_mass_kg.or(default_mass_kg).ok_or_else(|| AircraftError::Missing {
                    field: format!("{field}.inertia.given.at_mass_kg"),
                    needed: "the mass the stated moments of inertia belong to",
                })?,
            },
            Self::Rod { length_m, along } => OwnInertia::Rod { length_m, along },
            Self::Cuboid { length_m, width_m, height_m } => OwnInertia::Cuboid { length_m, width_m, height_m },
            Self::Propeller { radius_m } => OwnInertia::Propeller { radius_m },
        })
    }
}

impl RawItem {
    fn into_item(self) -> FixedItem {
        FixedItem { name: self.name, mass_kg: self.mass_kg, cg_from_datum_m: self.cg_datum_m }
    }
}

impl RawTank {
    fn into_tank(self) -> Result<Tank, AircraftError> {
        let inertia = self.inertia.into_shape(&format!("tank.{}", self.name), Some(self.capacity_kg))?;
        Ok(Tank {
            name: self.name,
            capacity_kg: self.capacity_kg,
            unusable_kg: self.unusable_kg,
            cg_from_datum_m: self.cg_datum_m,
            inertia,
        })
    }
}

impl RawStation {
    fn into_station(self, kind: &str) -> Result<Station, AircraftError> {
        let inertia = self.inertia.into_shape(&format!("{kind}.{}", self.name), None)?;
        Ok(Station { name: self.name, capacity_kg: self.capacity_kg, cg_from_datum_m: self.cg_datum_m, inertia })
    }
}

impl RawInertia {
    fn into_model(self) -> Result<InertiaModel, AircraftError> {
        match self.moments_kg_m2 {
            Some(moments) if self.group.is_empty() => Ok(InertiaModel::Constant(tensor(moments, self.products_kg_m2))),
            Some(_) => Err(AircraftError::Missing {
                field: "inertia".to_owned(),
                needed: "either moments_kg_m2 or groups, not both",
            }),
            None => {
                let groups = self.group.into_iter().map(|group| {
                    let field = format!("inertia.group.{}", group.name);
                    Ok(InertiaGroup {
                        inertia: group.inertia.into_shape(&field, Some(group.mass_kg))?,
                        name: group.name,
                        mass_kg: group.mass_kg,
                        centroid_from_datum_m: group.centroid_datum_m,
                    })
                });
                Ok(InertiaModel::Groups {
                    groups: groups.collect::<Result<_, AircraftError>>()?,
                    own_products: tensor([0.0; 3], self.products_kg_m2),
                })
            }
        }
    }
}

impl RawFraction {
    fn into_fraction(self) -> ComponentFraction {
        ComponentFraction {
            name: self.name,
            mean: self.mean_percent / 100.0,
            deviation: self.deviation_percent / 100.0,
            methods: self.methods_percent.into_iter().map(|(name, percent)| (name, percent / 100.0)).collect(),
            attributed_kg: self.attributed_kg,
        }
    }
}

impl RawEngine {
    fn into_station(self) -> EngineStation {
        EngineStation {
            name: self.name,
            position_from_datum_m: self.position_datum_m,
            incidence_rad: self.incidence_deg.to_radians(),
        }
    }
}

impl RawAircraft {
    fn into_aircraft(self) -> Result<Aircraft, AircraftError> {
        Ok(Aircraft {
            name: self.name,
            notes: self.notes,
            reference: self.reference.into_reference(),
            datum: self.datum.origin,
            stated_mean_chord: self.mean_chord,
            wing_panels: self.wing_panel,
            empty: FixedItem {
                name: "empty".to_owned(),
                mass_kg: self.mass.mass_kg,
                cg_from_datum_m: self.mass.cg_datum_m,
            },
            fixed_items: self.fixed_item.into_iter().map(RawItem::into_item).collect(),
            limits: MassLimits { max_takeoff_kg: self.mass.max_takeoff_kg, max_landing_kg: self.mass.max_landing_kg },
            flight_envelope: self.flight_envelope,
            stall: self.stall,
            tanks: self.tank.into_iter().map(RawTank::into_tank).collect::<Result<_, _>>()?,
            fuel_bookkeeping: self.mass.fuel,
            seats: self.seat.into_iter().map(|seat| seat.into_station("seat")).collect::<Result<_, _>>()?,
            luggage: self.luggage.into_iter().map(|bay| bay.into_station("luggage")).collect::<Result<_, _>>()?,
            envelope: (!self.envelope.is_empty()).then_some(Envelope { rows: self.envelope }),
            inertia: self.inertia.into_model()?,
            standard_loading: Loading {
                fuel_kg: self.loading.fuel_kg,
                seats_kg: self.loading.seats_kg,
                luggage_kg: self.loading.luggage_kg,
                added_items: self.loading.added_item.into_iter().map(RawItem::into_item).collect(),
            },
            wheels: self.wheels,
            sensors: self.sensors,
            engines: self.engine.into_iter().map(RawEngine::into_station).collect(),
            moment_reference_from_datum_m: self.moment_reference.map(|point| point.position_datum_m),
            component_fractions: self.component_fraction.into_iter().map(RawFraction::into_fraction).collect(),
            gyration_radii: self.gyration_radii,
        })
    }
}
