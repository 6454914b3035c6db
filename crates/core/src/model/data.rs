//! What one window offers to the aerodynamic model, and how it is to be read.

use std::collections::BTreeMap;
use std::ops::Range;
use std::sync::Arc;

use serde::{Deserialize, Serialize};

use crate::airframe::{MassHistory, ReferenceGeometry};
use crate::prep::Differentiation;
use crate::quantity::Role;
use crate::series::TimeRange;

/// A point of the aircraft.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Position {
    /// Body axes from the centre of gravity, m: it moves with the centre of gravity.
    #[serde(rename = "body_from_cg_m")]
    BodyFromCg([f64; 3]),
    /// Datum axes (x aft, y right, z up), m: fixed to the aircraft.
    #[serde(rename = "datum_m")]
    Datum([f64; 3]),
}

impl Position {
    /// Body axes from the centre of gravity `cg_from_datum_m`, m: `x = -(x - x_cg)`, `y = y - y_cg`, `z = -(z - z_cg)`.
    pub fn body_from_cg_m(self, cg_from_datum_m: [f64; 3]) -> [f64; 3] {
        match self {
            Self::BodyFromCg(position) => position,
            Self::Datum([x, y, z]) => [cg_from_datum_m[0] - x, y - cg_from_datum_m[1], cg_from_datum_m[2] - z],
        }
    }
}

/// An engine as a force and a rotating mass.
#[derive(Clone, Debug, PartialEq)]
pub struct Engine {
    /// Thrust at each sample, N.
    pub thrust_n: Arc<[f64]>,
    /// A point of the line of action.
    pub position: Position,
    /// Unit vector of the thrust in body axes; `[1, 0, 0]` for no incidence.
    pub direction_body: [f64; 3],
    /// Inertia of everything that rotates with the propeller, kg m².
    pub rotor_inertia_kg_m2: f64,
    /// Rotational speed at each sample, rad/s, positive about body x (clockwise seen from behind); empty where unknown.
    pub speed_rad_s: Arc<[f64]>,
}

/// Input columns over one window, all of the length of `time_s`; SI, body axes. What the variables of terms take over as it is, is
/// shared.
#[derive(Clone, Debug, PartialEq)]
pub struct AeroData {
    /// Time, s, strictly increasing.
    pub time_s: Arc<[f64]>,
    /// True airspeed, m/s.
    pub airspeed_m_s: Arc<[f64]>,
    /// Angle of attack at the centre of gravity, rad.
    pub alpha_rad: Arc<[f64]>,
    /// Angle of sideslip at the centre of gravity, rad.
    pub beta_rad: Arc<[f64]>,
    /// Roll, pitch and yaw rate without bias, rad/s.
    pub rates_rad_s: [Vec<f64>; 3],
    /// Specific force without bias where the accelerometers are, m/s².
    pub specific_force_m_s2: [Vec<f64>; 3],
    /// Place of the accelerometers; `None` where the specific force is that at the centre of gravity.
    pub accelerometer: Option<Position>,
    /// Angular acceleration, rad/s²; `None` to differentiate the rates.
    pub angular_acceleration_rad_s2: Option<[Vec<f64>; 3]>,
    /// Air density, kg/m³.
    pub density_kg_m3: Arc<[f64]>,
    /// Deflections by role, rad, and what else is recorded of the configuration ([`super::RECORDED`]).
    pub controls: BTreeMap<Role, Arc<[f64]>>,
    /// Mass properties.
    pub mass: MassHistory,
    /// Engines; empty where thrust is unknown.
    pub engines: Vec<Engine>,
    /// Total-pressure rise through the propellers over dynamic pressure.
    pub propeller_pressure: Option<Arc<[f64]>>,
    /// Altitude, m.
    pub altitude_m: Option<Arc<[f64]>>,
    /// Mach number.
    pub mach: Option<Arc<[f64]>>,
}

/// Axes of the moment coefficients and of the rates among the variables.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Axes {
    /// Body axes.
    Body,
    /// Body axes turned about y by alpha: `L_s = L cos(alpha) + N sin(alpha)`, `N_s = N cos(alpha) - L sin(alpha)`.
    Stability,
}

/// Whether thrust belongs to the coefficients.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ThrustTreatment {
    /// Force and moment of the thrust stay inside the coefficients (thesis Eq. 3.23-3.24).
    Included,
    /// The force of the thrust is taken out, its moment stays.
    ForceRemoved,
    /// Force and moment are taken out: the coefficients are aerodynamic.
    Removed,
}

/// Gyroscopic moment of the propellers, `M = r sum(h)`, `N = -q sum(h)` with `h = I_p omega` along body x.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Gyroscopic {
    /// Not accounted for.
    Ignored,
    /// Each propeller with its sense of rotation: about zero for counter-rotating ones.
    Signed,
    /// All propellers as if they turned the same way, the printed form of thesis Eq. 3.24.
    Summed,
}

/// What the deflection that acts does after the recorded one.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Lag {
    /// Time constant of a first-order lag, s; zero for none.
    pub time_constant_s: f64,
    /// Pure delay, s; zero for none, negative where the deflection was recorded late.
    pub delay_s: f64,
}

crate::hash_fields!(Lag { ; time_constant_s, delay_s });

/// How coefficients and variables are formed.
#[derive(Clone, Debug, PartialEq)]
pub struct CoefficientSettings {
    /// Reference area, lengths and normalisation.
    pub reference: ReferenceGeometry,
    /// Point the moments are about; `None` for the centre of gravity.
    pub moment_reference: Option<Position>,
    /// Axes of moments and rates.
    pub axes: Axes,
    /// Thrust in or out.
    pub thrust: ThrustTreatment,
    /// Gyroscopic moment of the propellers.
    pub gyroscopic: Gyroscopic,
    /// Differentiation of rates (where no angular acceleration is given) and of flow angles.
    pub differentiation: Differentiation,
    /// Smooths everything else as the differentiation smooths the angular acceleration, regressors included
    /// ([`crate::prep::MatchedSmoothing`]), so that both sides of the regression lose the same. Coefficients and regressors then
    /// leave out the ends of the window. Without effect where the angular acceleration is given.
    pub matched: bool,
    /// Lag of each control; controls not named act at once.
    pub control_lags: BTreeMap<Role, Lag>,
    /// Stretches of time that coefficients and regressors have no rows for, nor for the samples beside them whose derivative reaches in.
    pub excluded: Vec<TimeRange>,
}

impl CoefficientSettings {
    /// Settings of the thesis: moments about the centre of gravity in body axes, thrust included, gyroscopic moment
    /// left out, differentiation by Eq. D.1, nothing smoothed to match it.
    pub fn new(reference: ReferenceGeometry) -> Self {
        Self {
            reference,
            moment_reference: None,
            axes: Axes::Body,
            thrust: ThrustTreatment::Included,
            gyroscopic: Gyroscopic::Ignored,
            differentiation: Differentiation::Central4,
            matched: false,
            control_lags: BTreeMap::new(),
            excluded: Vec::new(),
        }
    }

    /// Which of `rows` of `time_s` are left where stretches are excluded, smoothed over `reach` samples; `None` where all are.
    pub(super) fn rows_left(&self, time_s: &[f64], rows: Range<usize>, reach: usize) -> Option<Vec<usize>> {
        // What is smoothed was differentiated over two samples before.
        let reach = self.differentiation.half_width().max(reach + 2);
        let widened = |stretch: &TimeRange| {
            let inside = stretch.indices(time_s);
            (!inside.is_empty()).then(|| inside.start.saturating_sub(reach)..inside.end.saturating_add(reach))
        };
        let excluded: Vec<Range<usize>> = self.excluded.iter().filter_map(widened).collect();
        let is_left = |row: &usize| !excluded.iter().any(|stretch| stretch.contains(row));
        (!excluded.is_empty()).then(|| rows.filter(is_left).collect())
    }
}
