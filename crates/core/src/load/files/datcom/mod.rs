//! USAF Digital DATCOM: its output listing read into derivatives, and its input deck written.
//!
//! The listing gives coefficients in stability axes, rates against `q c / (2 V)` and angles in degrees; everything
//! behind this file is SI, and [`DatcomListing::derivatives`] converts axes and normalisation to those of
//! `docs/conventions.md`. Source: AFFDL-TR-79-3032, The USAF Stability and Control Digital DATCOM, vol. I.

mod cards;
mod deck;
mod derivatives;
mod listing;

use std::path::{Path, PathBuf};

use thiserror::Error;

pub use deck::{
    DatcomDeck, DatcomSection, DeckAileron, DeckBody, DeckCondition, DeckElevator, DeckError, DeckPlanform,
    DeckReference, DeckTwinVertical,
};
pub use derivatives::{
    AileronMeasure, AlphaOutsideError, DatcomAxes, DerivativeComparison, PredictedDerivative, PredictionOptions, beside,
};

/// A listing that cannot be used.
#[derive(Debug, Error)]
#[expect(missing_docs, reason = "the messages say what the fields are")]
pub enum DatcomError {
    /// The file cannot be read.
    #[error("{}: {source}", path.display())]
    Read { path: PathBuf, source: std::io::Error },
    /// The `[datcom]` section of an aircraft file cannot be used.
    #[error("{}, line {line}: {message}", path.display())]
    Section { path: PathBuf, line: usize, message: String },
    /// The file is no usable listing.
    #[error("{}: {source}", path.display())]
    Listing { path: PathBuf, source: ListingError },
}

/// What is wrong with a listing. Lines count from 1.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[expect(missing_docs, reason = "the messages say what variants and fields are")]
pub enum ListingError {
    /// A line that should hold numbers does not.
    #[error("line {line}: {table}: {reason}")]
    Row { line: usize, table: &'static str, reason: String },
    #[error("line {line}: lengths are in '{unit}', only M and FT are read: run the deck with DIM M")]
    Units { line: usize, unit: String },
    #[error("line {line}: {table} without a heading PER RADIAN or PER DEGREE before it")]
    AngleUnit { line: usize, table: &'static str },
    #[error("line {line} is the last and no END OF JOB came: the listing is cut off")]
    Truncated { line: usize },
    #[error("no {table} in the listing: is it the output of Digital DATCOM?")]
    Missing { table: &'static str },
}

/// Flight condition and reference dimensions at the head of a page.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DatcomConditions {
    /// Mach number.
    pub mach: f64,
    /// Altitude, m; this and the next three are not numbers where the listing leaves them out.
    pub altitude_m: f64,
    /// Airspeed, m/s.
    pub airspeed_m_s: f64,
    /// Static pressure, Pa.
    pub pressure_pa: f64,
    /// Static temperature, K.
    pub temperature_k: f64,
    /// Reynolds number per metre.
    pub reynolds_per_m: f64,
    /// Reference area, m².
    pub area_m2: f64,
    /// Reference chord, m.
    pub chord_m: f64,
    /// Reference span, m.
    pub span_m: f64,
    /// Moment reference point aft of the deck's origin, m.
    pub reference_x_m: f64,
    /// Moment reference point above the deck's origin, m.
    pub reference_z_m: f64,
}

/// Static characteristics in stability axes against [`DatcomListing::alpha_rad`]; not a number where the program prints
/// none.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct StaticTable {
    /// Drag coefficient.
    pub cd: Vec<f64>,
    /// Lift coefficient.
    pub cl: Vec<f64>,
    /// Pitching moment coefficient.
    pub cm: Vec<f64>,
    /// Normal force coefficient, body axes, positive up.
    pub cn: Vec<f64>,
    /// Axial force coefficient, body axes, positive aft.
    pub ca: Vec<f64>,
    /// d CL / d alpha, 1/rad.
    pub cl_alpha: Vec<f64>,
    /// d Cm / d alpha, 1/rad.
    pub cm_alpha: Vec<f64>,
    /// d CY / d beta, 1/rad; a value printed once holds for all angles.
    pub cy_beta: Vec<f64>,
    /// d Cn / d beta (yaw), 1/rad.
    pub cn_beta: Vec<f64>,
    /// d Cl / d beta (roll), 1/rad.
    pub cl_beta: Vec<f64>,
}

/// Flow at the horizontal tail.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct DownwashTable {
    /// Dynamic pressure at the tail over that of the free stream.
    pub pressure_ratio: Vec<f64>,
    /// Downwash angle, rad.
    pub downwash_rad: Vec<f64>,
    /// d downwash / d alpha.
    pub gradient: Vec<f64>,
}

/// Dynamic derivatives, 1/rad, against `q c/(2V)`, `alpha_dot c/(2V)`, `p b/(2V)`, `r b/(2V)` in stability axes.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct DynamicTable {
    /// CL to pitch rate.
    pub cl_q: Vec<f64>,
    /// Cm to pitch rate.
    pub cm_q: Vec<f64>,
    /// CL to rate of angle of attack.
    pub cl_alpha_dot: Vec<f64>,
    /// Cm to rate of angle of attack.
    pub cm_alpha_dot: Vec<f64>,
    /// Cl to roll rate.
    pub cl_p: Vec<f64>,
    /// CY to roll rate.
    pub cy_p: Vec<f64>,
    /// Cn to roll rate.
    pub cn_p: Vec<f64>,
    /// Cn to yaw rate.
    pub cn_r: Vec<f64>,
    /// Cl to yaw rate.
    pub cl_r: Vec<f64>,
}

/// Increments of a symmetric control on the horizontal tail.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ElevatorTable {
    /// Deflection, trailing edge down positive, rad.
    pub deflection_rad: Vec<f64>,
    /// Increment of CL.
    pub cl: Vec<f64>,
    /// Increment of Cm.
    pub cm: Vec<f64>,
    /// Increment of the minimum of CD.
    pub cd_min: Vec<f64>,
    /// Increment of the induced drag: `[alpha][deflection]`; empty where not printed.
    pub cd_induced: Vec<Vec<f64>>,
}

/// Increments of a pair of ailerons.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct AileronTable {
    /// Left aileron, trailing edge down positive, rad.
    pub left_rad: Vec<f64>,
    /// Right aileron, trailing edge down positive, rad.
    pub right_rad: Vec<f64>,
    /// Rolling moment coefficient, stability axes.
    pub roll: Vec<f64>,
    /// Yawing moment coefficient, stability axes: `[alpha][deflection]`; empty where not printed.
    pub yaw: Vec<Vec<f64>>,
}

/// What a listing says about one configuration at one flight condition. Where pages repeat a table the first counts.
#[derive(Clone, Debug, PartialEq)]
#[expect(missing_docs, reason = "names say it")]
pub struct DatcomListing {
    /// Name of the case, without ornament.
    pub title: String,
    /// Flight condition and reference dimensions of the first page.
    pub conditions: DatcomConditions,
    /// Angles of attack of all tables, rad.
    pub alpha_rad: Vec<f64>,
    /// Static characteristics.
    pub statics: StaticTable,
    /// Flow at the tail.
    pub downwash: Option<DownwashTable>,
    /// Dynamic derivatives.
    pub dynamic: Option<DynamicTable>,
    pub elevator: Option<ElevatorTable>,
    pub aileron: Option<AileronTable>,
    /// Lift coefficient of level flight, `W / (q S)`, from the weight and the first page's air.
    pub level_flight_cl: Option<f64>,
    /// What does not agree within the listing, one line each.
    pub warnings: Vec<String>,
}

impl DatcomListing {
    /// Reads the listing at `path`.
    ///
    /// # Errors
    /// [`DatcomError`] with file, line and reason.
    pub fn read(path: &Path) -> Result<Self, DatcomError> {
        let bytes =
            crate::load::read_bytes(path).map_err(|source| DatcomError::Read { path: path.to_owned(), source })?;
        Self::parse(&String::from_utf8_lossy(&bytes))
            .map_err(|source| DatcomError::Listing { path: path.to_owned(), source })
    }
}
