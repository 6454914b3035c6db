//! The truth of a flight: what no instrument sees, without error.

use super::boxes;
use super::instruments::Instant;
use super::scenario::{Scenario, TruthExtent};
use super::vehicle::Body;

/// Declares the columns of the truth with their units.
macro_rules! columns {
    ($($name:literal, $unit:literal;)*) => {
        /// Name and SI unit of each column, in their order.
        pub const COLUMNS: [(&str, &str); [$($name,)*].len()] = [$(($name, $unit),)*];
    };
}

columns! {
    "x", "m"; "y", "m"; "z", "m";
    "v_north", "m/s"; "v_east", "m/s"; "v_down", "m/s";
    "u", "m/s"; "v", "m/s"; "w", "m/s";
    "phi", "rad"; "theta", "rad"; "psi", "rad";
    "p", "rad/s"; "q", "rad/s"; "r", "rad/s";
    "p_dot", "rad/s^2"; "q_dot", "rad/s^2"; "r_dot", "rad/s^2";
    "airspeed", "m/s"; "alpha", "rad"; "beta", "rad";
    "ax", "m/s^2"; "ay", "m/s^2"; "az", "m/s^2";
    "delta_a", "rad"; "delta_e", "rad"; "delta_r", "rad";
    "CX", "-"; "CY", "-"; "CZ", "-"; "Cl", "-"; "Cm", "-"; "Cn", "-";
    "force_x", "N"; "force_y", "N"; "force_z", "N";
    "moment_x", "N m"; "moment_y", "N m"; "moment_z", "N m";
    "thrust_1", "N"; "thrust_2", "N";
    "wind_north", "m/s"; "wind_east", "m/s"; "wind_down", "m/s";
    "air_density", "kg/m^3";
}

/// Leading columns that hold positions, which need all digits.
const POSITIONS: usize = 3;

/// The nearest number of 16 significant bits, 8e-6 relative: the rest of a truth's digits only fill its file.
fn sixteen_bits(value: f32) -> f32 {
    const DROPPED: u32 = 8;
    let rounded = value.to_bits().wrapping_add(1 << (DROPPED - 1)) & !((1 << DROPPED) - 1);
    f32::from_bits(rounded)
}

/// Columns of the loading, once a second.
pub(crate) const LOADING_COLUMNS: [(&str, &str); 12] = [
    ("mass", "kg"),
    ("cg_x", "m"),
    ("cg_y", "m"),
    ("cg_z", "m"),
    ("Ixx", "kg m^2"),
    ("Iyy", "kg m^2"),
    ("Izz", "kg m^2"),
    ("Ixz", "kg m^2"),
    ("fuel_main_right", "kg"),
    ("fuel_main_left", "kg"),
    ("fuel_aux_right", "kg"),
    ("fuel_aux_left", "kg"),
];

/// First of them that is the fuel of a tank; the tanks follow in the order of the aircraft.
pub(crate) const FIRST_TANK: usize = 8;

/// True histories.
#[derive(Clone, Debug, PartialEq)]
pub struct Truth {
    extent: TruthExtent,
    loading_steps: usize,
    /// Time of each sample, s.
    pub time_s: Vec<f64>,
    /// Columns in the order of `COLUMNS`, SI, single precision as in the file.
    pub columns: Vec<Vec<f32>>,
    /// Time of each sample of the loading, s.
    pub loading_time_s: Vec<f64>,
    /// Columns in the order of `LOADING_COLUMNS`, SI.
    pub loading: Vec<Vec<f64>>,
}

impl Truth {
    /// Room for the truth of a scenario.
    pub fn new(scenario: &Scenario) -> Self {
        let samples = match scenario.truth {
            TruthExtent::Whole => scenario.duration_s / scenario.step_s,
            TruthExtent::Manoeuvres { every } => {
                let each = scenario.manoeuvres.first().map_or(0.0, |first| first.recorded_s().1 - first.recorded_s().0);
                each * scenario.manoeuvres.len() as f64 / scenario.step_s / every as f64
            }
        } as usize
            + 64;
        let seconds = scenario.duration_s as usize + 2;
        Self {
            extent: scenario.truth,
            loading_steps: (1.0 / scenario.step_s).round().max(1.0) as usize,
            time_s: Vec::with_capacity(samples),
            columns: COLUMNS.iter().map(|_| Vec::with_capacity(samples)).collect(),
            loading_time_s: Vec::with_capacity(seconds),
            loading: LOADING_COLUMNS.iter().map(|_| Vec::with_capacity(seconds)).collect(),
        }
    }

    /// Centre of gravity at the start, m from the datum.
    pub fn loading_cg_at_start(&self) -> [f64; 3] {
        [1, 2, 3].map(|column| self.loading[column].first().copied().unwrap_or(0.0))
    }

    /// The column called `name`.
    pub fn column(&self, name: &str) -> Option<&[f32]> {
        let index = COLUMNS.iter().position(|(column, _)| *column == name)?;
        self.columns.get(index).map(Vec::as_slice)
    }

    /// Constant errors of the instruments: name, value, SI unit.
    pub fn biases() -> [(&'static str, f64, &'static str); 8] {
        let [ax, ay, az] = boxes::ACCELEROMETER_BIAS_M_S2;
        let [p, q, r] = boxes::GYRO_BIAS_RAD_S;
        [
            ("bias_ax", ax, "m/s^2"),
            ("bias_ay", ay, "m/s^2"),
            ("bias_az", az, "m/s^2"),
            ("bias_p", p, "rad/s"),
            ("bias_q", q, "rad/s"),
            ("bias_r", r, "rad/s"),
            ("bias_beta", boxes::SIDESLIP_OFFSET_RAD, "rad"),
            ("declination", boxes::DECLINATION_RAD, "rad"),
        ]
    }

    /// Takes an instant if it belongs to what is kept.
    pub fn record(&mut self, step: usize, instant: &Instant, body: &Body, in_manoeuvre: bool) {
        if step.is_multiple_of(self.loading_steps) {
            self.record_loading(instant, body);
        }
        match self.extent {
            TruthExtent::Manoeuvres { every } if !in_manoeuvre || !step.is_multiple_of(every) => return,
            _ => {}
        }
        let Instant { state, loads, controls, wind_ned_m_s: wind, .. } = instant;
        let (position, ground) = (state.position_ned_m, state.velocity_ned_m_s);
        let (air, flow) = (&loads.air, loads.air.velocity_body_m_s);
        let [phi, theta, psi] = state.euler_rad();
        let (rates, angular) = (state.rates_rad_s, loads.angular_acceleration_rad_s2);
        let specific = loads.specific_force_m_s2;
        let force = specific * body.properties.mass_kg;
        let moment = loads.aero_moment_n_m + loads.thrust_moment_n_m + loads.ground_moment_n_m;
        let [cx, cy, cz, cl, cm, cn] = loads.coefficients;
        let density = 2.0 * air.dynamic_pressure_pa / (air.airspeed_m_s * air.airspeed_m_s).max(1e-6);
        let row: [f64; COLUMNS.len()] = [
            position.x, position.y, position.z, ground.x, ground.y, ground.z, flow.x, flow.y, flow.z, phi, theta, psi,
            rates.x, rates.y, rates.z, angular.x, angular.y, angular.z, air.airspeed_m_s, air.alpha_rad, air.beta_rad,
            specific.x, specific.y, specific.z, controls.aileron, controls.elevator, controls.rudder, cx, cy, cz, cl,
            cm, cn, force.x, force.y, force.z, moment.x, moment.y, moment.z, loads.thrust_n[0], loads.thrust_n[1],
            wind.x, wind.y, wind.z, density,
        ];
        self.time_s.push(instant.time_s);
        let shorten = self.extent != TruthExtent::Whole;
        for (index, (column, value)) in self.columns.iter_mut().zip(row).enumerate() {
            let value = value as f32;
            column.push(if shorten && index >= POSITIONS { sixteen_bits(value) } else { value });
        }
    }

    fn record_loading(&mut self, instant: &Instant, body: &Body) {
        let properties = &body.properties;
        let [x, y, z] = properties.cg_from_datum_m;
        let inertia = &properties.inertia;
        let [a, b, c, d] = instant.fuel_kg;
        let row = [properties.mass_kg, x, y, z, inertia.xx, inertia.yy, inertia.zz, inertia.xz, a, b, c, d];
        self.loading_time_s.push(instant.time_s);
        self.loading.iter_mut().zip(row).for_each(|(column, value)| column.push(value));
    }
}
