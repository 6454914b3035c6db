//! The weaknesses of the thesis's results beside those of the shipped flight treated as in the thesis.

use std::fmt::Write;

use doublet_core::estimate::diagnostics::regressor_correlation;
use doublet_core::model::Variable;
use doublet_engine::report::{PredictionAgreement, Results};
use doublet_engine::run::Snapshot;
use doublet_engine::session::{ClockSetting, Session, Surface, WindowRole};
use nalgebra::DMatrix;

use crate::text::number;

/// Clock of the control sensors, and by how much it is set wrong, s.
pub const SENSORS: &str = "sensor_*";
/// Seconds the control sensors are stamped too early in the second run: within the 1.5 s the thesis moves them by hand (section 4.4.3).
pub const EARLY_S: f64 = 0.2;

/// Mean, least and greatest estimate over the manoeuvres (thesis Tables 6.5 to 6.9).
const ESTIMATES: [(&str, [f64; 3]); 7] = [
    ("Cl_p", [0.001, -0.753, 0.719]),
    ("Cl_delta_a", [-0.001, -0.278, 0.220]),
    ("Cl_beta", [-0.007, -0.098, 0.045]),
    ("Cm_q", [-1.321, -6.455, 2.191]),
    ("Cm_delta_e", [-0.424, -0.977, 0.030]),
    ("CY_p", [0.262, -1.018, 1.404]),
    ("CZ_q", [-18.509, -29.293, -12.735]),
];

/// R2 of the prediction of the validation manoeuvres (thesis Table 7.1).
const VALIDATION: [(&str, f64); 6] =
    [("CX", 0.834), ("CY", 0.939), ("CZ", 0.901), ("Cl", 0.462), ("Cm", 0.585), ("Cn", 0.944)];

/// Correlation of roll rate and aileron deflection over the aileron manoeuvres (thesis section 4.4.3).
const ROLL_AND_AILERON: f64 = -0.92;

/// What is concluded; its numbers are those of the table and held by the tests of the engine (`thesis`).
const CONCLUSION: &str = "\
In both flights single manoeuvres do not determine CY_p, CX_q or Cn_p: the first two change their sign from one to the next, the third
lies between zero and twice the truth. The lateral derivatives scatter by five to fifteen times their standard error for white residuals.
Rudder manoeuvres underestimate the roll damping by up to a tenth.

Other weaknesses do not appear: a roll damping of zero, an R2 of Cl of 0.46, a pitch damping of either sign, a correlation of roll rate and
aileron of -0.92. Every aileron manoeuvre of this flight gives Cl_p and Cl_delta_a within two per cent. Smoothed inputs, splined flow angles
and single manoeuvres are all in the first run and do not cause these weaknesses. A wrong clock of the control sensors causes
most of them: stamped a fifth of a second early, Cl_delta_a loses two fifths, the roll damping a third, Cm_q becomes positive,
and R2 decreases for the moments of the moved surface. The thesis aligned these sensors by hand, up to 1.5 s, and reports an unexplained
delay between fitted and observed Cl (section 4.4.3). A wrong clock is a likely reason, not a proven one. The
shipped session fits this clock to common signals of both recorders and finds it to some milliseconds.

R2 of the validation manoeuvres as in the thesis (7.1, mean parameters and constants) is negative for CX, where the thesis states 0.834:
thrust is inside CX, so its constant varies between manoeuvres by more than CX varies in a manoeuvre. Only with each manoeuvre's
own constant is it 0.94, which does not test the constant. The five others are above those of the thesis either way.";

/// The session with the clock of its control sensors set wrong.
pub fn early_sensors(session: &Session) -> Session {
    let mut session = session.clone();
    for flight in &mut session.flights {
        match flight.clocks.iter_mut().find(|clock| clock.source == SENSORS) {
            Some(clock) => clock.shift_s -= EARLY_S,
            None => flight.clocks.push(ClockSetting { shift_s: -EARLY_S, ..ClockSetting::new(SENSORS) }),
        }
    }
    session
}

/// A session that was run.
pub struct Run {
    pub session: Session,
    /// Its last snapshot.
    pub snapshot: Snapshot,
    pub results: Results,
}

/// The table and what follows from it: as the thesis has it, the flight treated so, and the same with early control sensors.
pub fn weaknesses(out: &mut String, treated: &Run, early: &Run) -> std::fmt::Result {
    writeln!(out, "\n### Weaknesses compared with the thesis\n")?;
    writeln!(
        out,
        "Mean over the identification manoeuvres, smallest and largest; in the last column the control sensors are stamped {EARLY_S} s too early.\n"
    )?;
    writeln!(out, "| what | thesis | this flight | early sensors |\n|---|---|---|---|")?;
    let both = |value: &dyn Fn(&Run) -> String| format!("{} | {}", value(treated), value(early));
    writeln!(
        out,
        "| correlation of p and delta_a | {ROLL_AND_AILERON} | {} |",
        both(&|run| number(roll_and_aileron(run), 2))
    )?;
    for (name, published) in ESTIMATES {
        writeln!(out, "| {name} | {} | {} |", spread(published), both(&|run| spread(estimates(&run.results, name))))?;
    }
    let validation = |run: &Run, coefficient: &str, of: fn(&PredictionAgreement) -> f64| {
        let row = run.results.validation.iter().find(|row| row.coefficient == coefficient);
        row.map_or_else(|| "-".to_owned(), |row| number(of(&row.agreement), 3))
    };
    for (coefficient, published) in VALIDATION {
        let found = both(&|run| validation(run, coefficient, |row| row.r_squared_identified_constants));
        writeln!(out, "| {coefficient}, R2 of the validation manoeuvres | {published} | {found} |")?;
    }
    for (coefficient, _) in VALIDATION {
        let found = both(&|run| validation(run, coefficient, |row| row.r_squared_own_constant));
        writeln!(out, "| {coefficient}, the same with the constant fitted to the manoeuvre predicted | | {found} |")?;
    }
    writeln!(out, "\n{CONCLUSION}")
}

fn spread([mean, least, greatest]: [f64; 3]) -> String {
    format!("{} ({} to {})", number(mean, 3), number(least, 3), number(greatest, 3))
}

/// Mean, least and greatest of the estimates of single identification windows.
fn estimates(results: &Results, name: &str) -> [f64; 3] {
    let row = results.derivative_summary.iter().find(|row| row.name == name);
    row.map_or([f64::NAN; 3], |row| [row.mean, row.minimum, row.maximum])
}

/// Mean correlation of roll rate and aileron deflection over the aileron manoeuvres.
fn roll_and_aileron(run: &Run) -> f64 {
    let windows = run.session.windows.iter();
    let aileron =
        windows.filter(|window| window.role == WindowRole::Identification && window.surface == Some(Surface::Aileron));
    let found = aileron.filter_map(|window| {
        let aero = run.snapshot.windows.get(&window.name)?.aero.ready()?;
        let [rate, deflection] = [Variable::RollRate, Variable::Aileron].map(|variable| aero.variables.get(variable));
        let (rate, deflection) = (rate?, deflection?);
        let both = DMatrix::from_fn(rate.len(), 2, |row, column| if column == 0 { rate[row] } else { deflection[row] });
        Some(regressor_correlation(&both)[(0, 1)])
    });
    let found: Vec<f64> = found.collect();
    found.iter().sum::<f64>() / found.len() as f64
}
