//! Linearisation by the chain rule over the terms of a model.

use doublet_core::model::{Axes, Variable, VariableValues};
use doublet_core::replay::Instant;
use nalgebra::{Matrix3, SMatrix, Vector3};

use super::LinearError;
use super::flight::{Equations, INPUTS, InputVector, STATES, StateVector, body_from_ned};

/// Independent columns: states, inputs, and the rates of the flow angles, rad/s.
const COLUMNS: usize = STATES + INPUTS + 2;
/// Column of the thrust.
const THRUST: usize = STATES + 3;
/// Column of the rate of the angle of attack; that of sideslip follows.
const ALPHA_RATE: usize = STATES + INPUTS;

/// Slope of a scalar over every column.
type Row = SMatrix<f64, 1, COLUMNS>;
/// Slopes of a vector over every column.
type Rows = SMatrix<f64, 3, COLUMNS>;
/// Slopes of the rates of the states over the states, then the inputs.
pub(super) type Slopes = SMatrix<f64, STATES, { STATES + INPUTS }>;

/// Slopes of quantities of the flow.
struct Flow {
    speed: Row,
    alpha: Row,
    beta: Row,
    /// Dynamic pressure.
    pressure: Row,
    thrust: Row,
}

fn unit(column: usize) -> Row {
    let mut row = Row::zeros();
    row[column] = 1.0;
    row
}

/// Slopes of the rates of the states at a trim, `x' = f(x, u, alpha', beta')` solved for `x'` with `alpha' = (u w' - w u') / (u^2 + w^2)`
/// and `beta' = v' / V` (no sideslip in trim): `(I - G S) x' = J (x, u)`.
///
/// # Errors
/// [`LinearError::Singular`] where those terms cancel the mass.
pub(super) fn slopes(
    equations: &Equations<'_>,
    state: &StateVector,
    input: &InputVector,
) -> Result<Slopes, LinearError> {
    let all = rates(equations, state, input);
    let (u, w) = (state[0], state[2]);
    let in_plane = u * u + w * w;
    let mut flow_rates = SMatrix::<f64, 2, STATES>::zeros();
    flow_rates[(0, 0)] = -w / in_plane;
    flow_rates[(0, 2)] = u / in_plane;
    flow_rates[(1, 1)] = 1.0 / in_plane.sqrt();
    let by_flow_rates = all.fixed_columns::<2>(ALPHA_RATE).into_owned();
    let left = SMatrix::<f64, STATES, STATES>::identity() - by_flow_rates * flow_rates;
    let right = all.fixed_columns::<{ STATES + INPUTS }>(0).into_owned();
    left.lu().solve(&right).ok_or(LinearError::Singular)
}

/// Slopes of the rates with the rates of the flow angles as columns of their own.
fn rates(equations: &Equations<'_>, state: &StateVector, input: &InputVector) -> SMatrix<f64, STATES, COLUMNS> {
    let condition = equations.condition;
    let velocity = Vector3::new(state[0], state[1], state[2]);
    let omega = Vector3::new(state[3], state[4], state[5]);
    let body = body_from_ned([state[6], state[7], state[8]]);
    let (force, moment) = loads(equations, state, input);
    let mut all = SMatrix::<f64, STATES, COLUMNS>::zeros();

    // Turning of the attitude by each Euler angle, as a rotation vector in body axes.
    let [(sin_phi, cos_phi), (sin_theta, cos_theta)] = [state[6], state[7]].map(f64::sin_cos);
    let turns = [
        Vector3::x(),
        Vector3::new(0.0, cos_phi, -sin_phi),
        Vector3::new(-sin_theta, sin_phi * cos_theta, cos_phi * cos_theta),
    ];
    // A vector fixed in local Earth axes turns back in body axes: d(R g) = -turn x R g.
    let gravity = body.column(2) * condition.gravity_m_s2;
    let mut acceleration = force / condition.mass.mass_kg;
    let mut add = |column: usize, change: Vector3<f64>| {
        let mut place = acceleration.column_mut(column);
        place += change;
    };
    for axis in 0..3 {
        let mut step = Vector3::zeros();
        step[axis] = 1.0;
        add(axis, -omega.cross(&step));
        add(3 + axis, -step.cross(&velocity));
        add(6 + axis, -turns[axis].cross(&gravity));
    }
    all.fixed_rows_mut::<3>(0).copy_from(&acceleration);

    // I w' = M - w x (I w + h).
    let tensor = equations.inertia.tensor();
    let momentum = tensor * omega + Vector3::new(condition.rotor_momentum_n_m_s, 0.0, 0.0);
    let mut torque = moment;
    let gyroscopic: Matrix3<f64> = momentum.cross_matrix() - omega.cross_matrix() * tensor;
    for axis in 0..3 {
        let mut place = torque.column_mut(3 + axis);
        place += gyroscopic.column(axis);
    }
    let inverse = tensor.cholesky().map_or_else(Matrix3::zeros, |factor| factor.inverse());
    all.fixed_rows_mut::<3>(3).copy_from(&(inverse * torque));

    // Attitude.
    let (q, r) = (omega.y, omega.z);
    let (turning, across) = (q * sin_phi + r * cos_phi, q * cos_phi - r * sin_phi);
    let tan = sin_theta / cos_theta;
    all[(6, 3)] = 1.0;
    for (row, factor) in [(6, tan), (8, 1.0 / cos_theta)] {
        all[(row, 4)] = sin_phi * factor;
        all[(row, 5)] = cos_phi * factor;
        all[(row, 6)] = across * factor;
    }
    all[(6, 7)] = turning / (cos_theta * cos_theta);
    all[(8, 7)] = turning * tan / cos_theta;
    all[(7, 4)] = cos_phi;
    all[(7, 5)] = -sin_phi;
    all[(7, 6)] = -turning;

    // Path over the ground: a vector fixed in body axes turns forward in local Earth axes.
    let ned_from_body = body.transpose();
    for axis in 0..3 {
        let along = ned_from_body.column(axis).into_owned();
        let turned = ned_from_body * turns[axis].cross(&velocity);
        for (row, sign) in [(0, 1.0), (1, 1.0), (2, -1.0)] {
            all[(9 + row, axis)] = sign * along[row];
            all[(9 + row, 6 + axis)] = sign * turned[row];
        }
    }
    all
}

/// Slopes of the force and of the moment about the centre of gravity in body axes, N and N m.
fn loads(equations: &Equations<'_>, state: &StateVector, input: &InputVector) -> (Rows, Rows) {
    let velocity = Vector3::new(state[0], state[1], state[2]);
    let (airspeed, altitude) = (velocity.norm(), state[11]);
    let sample = equations.sample(airspeed, altitude, input);
    let instant = Instant {
        velocity_body_m_s: velocity,
        rates_rad_s: Vector3::new(state[3], state[4], state[5]),
        body_from_ned: body_from_ned([state[6], state[7], state[8]]),
        altitude_m: altitude,
    };
    let current = equations.forces.loads(&instant, &sample, [None; 3]);
    let values = equations.forces.variables(&instant, &current.air, &sample);
    let flow = flow(equations, &velocity, altitude);
    let variables = variables(equations, state, &flow, &values);
    let by_variable = equations.model.derivatives.body_slopes(&values);
    let coefficient = |index: usize| -> Row {
        by_variable[index].iter().zip(&variables).fold(Row::zeros(), |sum, (slope, row)| sum + row * *slope)
    };
    let reference = equations.forces.reference();
    let scale = current.air.dynamic_pressure_pa * reference.area_m2;
    // Of dynamic pressure times area times a coefficient.
    let dimensional = |index: usize| -> Row {
        coefficient(index) * scale + flow.pressure * (reference.area_m2 * current.coefficients[index])
    };
    let aerodynamic = Rows::from_rows(&[dimensional(0), dimensional(1), dimensional(2)]);
    let lengths = [reference.lateral_moment_length_m, reference.chord_m, reference.lateral_moment_length_m];
    let [l, m, n] = [0, 1, 2].map(|axis| dimensional(3 + axis) * lengths[axis]);
    let about_reference = match equations.model.axes {
        Axes::Body => Rows::from_rows(&[l, m, n]),
        Axes::Stability => {
            let (sin, cos) = current.air.alpha_rad.sin_cos();
            let [roll, yaw] = [3, 5].map(|index| scale * current.coefficients[index] * lengths[0]);
            let x = l * cos - n * sin - flow.alpha * (roll * sin + yaw * cos);
            let z = l * sin + n * cos + flow.alpha * (roll * cos - yaw * sin);
            Rows::from_rows(&[x, m, z])
        }
    };
    let force = aerodynamic + equations.thrust_force * flow.thrust;
    let transfer = equations.arm_m.cross_matrix() * aerodynamic;
    (force, about_reference + transfer + equations.thrust_moment_m * flow.thrust)
}

fn flow(equations: &Equations<'_>, velocity: &Vector3<f64>, altitude_m: f64) -> Flow {
    let airspeed = velocity.norm();
    let (u, v, w) = (velocity.x, velocity.y, velocity.z);
    let in_plane = u * u + w * w;
    let root = in_plane.sqrt();
    let mut speed = Row::zeros();
    (0..3).for_each(|axis| speed[axis] = velocity[axis] / airspeed);
    let mut alpha = Row::zeros();
    (alpha[0], alpha[2]) = (-w / in_plane, u / in_plane);
    let mut beta = Row::zeros();
    let square = airspeed * airspeed;
    (beta[0], beta[1], beta[2]) = (-v * u / (root * square), root / square, -v * w / (root * square));
    let (density, slope) = equations.density(altitude_m);
    let mut pressure = speed * (density * airspeed);
    pressure[11] += 0.5 * slope * square;
    let thrust = unit(THRUST) + speed * equations.condition.thrust_slope_n_s_m;
    Flow { speed, alpha, beta, pressure, thrust }
}

/// Slopes of every variable of the model.
fn variables(equations: &Equations<'_>, state: &StateVector, flow: &Flow, values: &VariableValues) -> Vec<Row> {
    let reference = equations.forces.reference();
    let airspeed = (state[0] * state[0] + state[1] * state[1] + state[2] * state[2]).sqrt();
    let variable_value = |variable: Variable| values[variable as usize];
    let pressure = 0.5 * equations.density(state[11]).0 * airspeed * airspeed;
    // A rate times a length over the airspeed.
    let scaled = |rate: Row, length_m: f64, value: f64| rate * (length_m / airspeed) - flow.speed * (value / airspeed);
    // Something over the dynamic pressure.
    let over_pressure = |value: f64| flow.pressure * (-value / pressure);
    let (mut roll, mut yaw) = (unit(3), unit(5));
    if equations.model.axes == Axes::Stability {
        let alpha = state[2].atan2(state[0]);
        let (sin, cos) = alpha.sin_cos();
        let (p, r) = (state[3], state[5]);
        (roll, yaw) = (
            unit(3) * cos + unit(5) * sin + flow.alpha * (r * cos - p * sin),
            unit(5) * cos - unit(3) * sin - flow.alpha * (r * sin + p * cos),
        );
    }
    let (lateral, pitch) = (reference.lateral_rate_length_m, reference.pitch_rate_length_m);
    let one = |&variable: &Variable| match variable {
        Variable::Alpha => flow.alpha,
        Variable::AlphaDot => unit(ALPHA_RATE) * (pitch / airspeed),
        Variable::Beta => flow.beta,
        Variable::BetaDot => unit(ALPHA_RATE + 1) * (lateral / airspeed),
        Variable::RollRate => scaled(roll, lateral, variable_value(variable)),
        Variable::PitchRate => scaled(unit(4), pitch, variable_value(variable)),
        Variable::HalfPitchRate => scaled(unit(4), reference.chord_m / 2.0, variable_value(variable)),
        Variable::YawRate => scaled(yaw, lateral, variable_value(variable)),
        Variable::Aileron => unit(STATES),
        Variable::Elevator => unit(STATES + 1),
        Variable::Rudder => unit(STATES + 2),
        Variable::PropellerPressure => over_pressure(variable_value(variable)),
        Variable::ThrustCoefficient => {
            flow.thrust * (1.0 / (pressure * reference.area_m2)) + over_pressure(variable_value(variable))
        }
        Variable::Airspeed => flow.speed,
        Variable::Altitude => unit(11),
        Variable::Flap
        | Variable::ElevatorTrim
        | Variable::Stabiliser
        | Variable::Other1
        | Variable::Other2
        | Variable::Other3
        | Variable::Other4 => Row::zeros(),
        Variable::Mach => {
            let (sound, slope) = equations.speed_of_sound(state[11]);
            flow.speed * (1.0 / sound) - unit(11) * (airspeed / (sound * sound) * slope)
        }
    };
    Variable::ALL.iter().map(one).collect()
}
