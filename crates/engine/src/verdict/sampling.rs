//! Findings about how fast a window was recorded: between two samples of a control nobody knows when it moved.

use doublet_core::message;
use doublet_core::model::Coefficient;
use doublet_core::quantity::Role;
use doublet_core::series::{Recording, Series, TimeRange};
use doublet_core::statistics::{extent, median_step};

use super::judge::Evidence;
use super::{Finding, Level, flight, remedies};
use crate::session::{Manoeuvre, Place};
use crate::stage::WindowAero;

/// Part of its travel in the window that a control moves between two samples before that is sudden.
const SUDDEN: f64 = 0.5;
/// Least travel that counts as an input, rad.
const LEAST_TRAVEL_RAD: f64 = 0.01;
/// Half the time between the two samples over the time constant of the motion that the control starts: derivatives of that motion are
/// wrong by about as much.
const PART_OF_TIME_CONSTANT: f64 = 0.1;
/// Part of its travel that a control moves from one pulse to the next, and half the time between two samples over the shortest pulse.
const PULSE: f64 = 0.3;
const PART_OF_PULSE: f64 = 0.25;

/// A motion that a control starts and that its damping ends.
struct Damped {
    control: Role,
    name: &'static str,
    coefficient: Coefficient,
    damping: &'static str,
    /// Damping of the rate by the derivative, 1/s: its factor.
    factor: fn(&WindowAero) -> Option<f64>,
}

/// `1 / T = -Cl_p (l_p / V) q S l / Ixx` of roll, `-Cm_q (c / V) q S c / Iyy` of pitch; yaw is slow beside both.
const DAMPED: [Damped; 2] = [
    Damped {
        control: Role::Aileron,
        name: "roll",
        coefficient: Coefficient::Cl,
        damping: "Cl_p",
        factor: |aero| {
            let reference = &aero.settings.reference;
            let lengths_m2 = reference.lateral_rate_length_m * reference.lateral_moment_length_m;
            Some(moment_per_rate(aero) * lengths_m2 / aero.data.mass.first()?.inertia.xx)
        },
    },
    Damped {
        control: Role::Elevator,
        name: "pitch",
        coefficient: Coefficient::Cm,
        damping: "Cm_q",
        factor: |aero| {
            let chord_m = aero.settings.reference.chord_m;
            Some(moment_per_rate(aero) * chord_m * chord_m / aero.data.mass.first()?.inertia.yy)
        },
    },
];

/// `q S / V`, N s/m.
fn moment_per_rate(aero: &WindowAero) -> f64 {
    flight::mean_pressure(aero) * aero.settings.reference.area_m2 / flight::mean(&aero.data.airspeed_m_s)
}

/// A control that moves between two samples, in a motion fast enough to make that matter: the worst.
pub(super) fn sudden_control(
    place: &Place,
    evidence: Evidence<'_>,
    manoeuvre: &Manoeuvre,
    aero: &WindowAero,
) -> Option<Finding> {
    let recording = &evidence.snapshot.flights.get(&manoeuvre.flight)?.ready()?.recording;
    let judged = DAMPED.iter().filter_map(|motion| {
        let jump = Jump::find(&recording.role(motion.control)?.series, manoeuvre.window)?;
        let time_constant_s = -1.0 / (damping(evidence, motion)? * (motion.factor)(aero)?);
        (time_constant_s > 0.0).then_some((0.5 * jump.apart_s / time_constant_s, motion, jump, time_constant_s))
    });
    let worst = judged.max_by(|a, b| a.0.total_cmp(&b.0)).filter(|(part, ..)| *part > PART_OF_TIME_CONSTANT);
    let Some((part, motion, jump, time_constant_s)) = worst else {
        return find_coarse_pulse(place, recording, manoeuvre.window);
    };
    let text = message!(
        "{} moves {:.0} % of its travel per {:.3} s sample: timing error {:.3} s, {:.0} % of the {} time constant {:.2} s \
         (limit {:.0} %).",
        motion.control.name(),
        100.0 * jump.part,
        jump.apart_s,
        0.5 * jump.apart_s,
        100.0 * part,
        motion.name,
        time_constant_s,
        100.0 * PART_OF_TIME_CONSTANT
    );
    let finding = Finding::new(Level::Caution, "sampling", place, text).with_figure(part, PART_OF_TIME_CONSTANT);
    let fix_text = format!("Record it faster or move it slower; {} derivatives are biased.", motion.name);
    let fix = remedies::recorded_acceleration(evidence.session, evidence.snapshot, &manoeuvre.flight);
    Some(finding.with_fix_text(fix_text).with_setting("Flight", "").with_fix(fix))
}

/// A control of which a pulse holds hardly more than a sample: when it moved, and so how far it moved the aircraft, is not known.
fn find_coarse_pulse(place: &Place, recording: &Recording, window: TimeRange) -> Option<Finding> {
    let controls = [Role::Aileron, Role::Elevator, Role::Rudder].into_iter();
    let judged = controls.filter_map(|control| {
        let (apart_s, pulse_s) = measure_shortest_pulse(&recording.role(control)?.series, window)?;
        Some((0.5 * apart_s / pulse_s, control, apart_s, pulse_s))
    });
    let (part, control, apart_s, pulse_s) = judged.max_by(|a, b| a.0.total_cmp(&b.0))?;
    if part <= PART_OF_PULSE {
        return None;
    }
    let text = message!(
        "{} is recorded every {:.2} s and its shortest pulse takes {:.2} s: timing error {:.0} % (limit {:.0} %).",
        control.name(),
        apart_s,
        pulse_s,
        100.0 * part,
        100.0 * PART_OF_PULSE
    );
    let finding = Finding::new(Level::Caution, "sampling", place, text).with_figure(part, PART_OF_PULSE);
    let fix_text = "Record it faster or move it slower; control derivatives are biased.";
    Some(finding.with_fix_text(fix_text).with_setting("Flight", ""))
}

/// Median time between samples of a control, and from one of its movements within a sample to the next the other way, s.
fn measure_shortest_pulse(control: &Series, window: TimeRange) -> Option<(f64, f64)> {
    let range = window.indices(&control.time_s);
    let (time_s, values) = (&control.time_s[range.clone()], &control.values[range]);
    let travel = measure_travel(values);
    let steps = values.windows(2).map(|pair| pair[1] - pair[0]).enumerate();
    let sudden: Vec<(usize, f64)> = steps.filter(|(_, step)| step.abs() > PULSE * travel).collect();
    let pulses = sudden.windows(2).filter(|pair| pair[0].1.signum() != pair[1].1.signum());
    let shortest_s = pulses.map(|pair| time_s[pair[1].0] - time_s[pair[0].0]).reduce(f64::min)?;
    (travel > LEAST_TRAVEL_RAD).then_some((median_step(time_s)?, shortest_s))
}

/// Largest less smallest value.
fn measure_travel(values: &[f64]) -> f64 {
    extent(values).map_or(0.0, |[least, greatest]| greatest - least)
}

/// The derivative that damps a motion, as pooled.
fn damping(evidence: Evidence<'_>, motion: &Damped) -> Option<f64> {
    let fits = &evidence.snapshot.pooled.ready()?.fits;
    let fit = fits.iter().find(|fit| fit.coefficient == motion.coefficient)?.fit.as_ref().ok()?;
    Some(fit.estimates[fit.names.iter().position(|name| name == motion.damping)?])
}

/// The largest movement between two samples.
struct Jump {
    /// Part of the travel in the window.
    part: f64,
    /// Time between the samples, s.
    apart_s: f64,
}

impl Jump {
    /// `None` where the control rests or moves over several samples.
    fn find(control: &Series, window: TimeRange) -> Option<Self> {
        let range = window.indices(&control.time_s);
        let (time_s, values) = (&control.time_s[range.clone()], &control.values[range]);
        let travel = measure_travel(values);
        let steps = values.windows(2).map(|pair| (pair[1] - pair[0]).abs()).enumerate();
        let (at, largest) = steps.filter(|(_, step)| step.is_finite()).max_by(|a, b| a.1.total_cmp(&b.1))?;
        let is_sudden = travel > LEAST_TRAVEL_RAD && largest > SUDDEN * travel;
        is_sudden.then(|| Self { part: largest / travel, apart_s: time_s[at + 1] - time_s[at] })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A doublet of two pulses of `pulse_s` from 1 s on.
    fn doublet(step_s: f64, pulse_s: f64) -> Series {
        let time_s: Vec<f64> = (0..150).map(|k| step_s * f64::from(k)).collect();
        let pulse = |t: &f64| match ((t - 1.0) / pulse_s).floor() {
            0.0 => 0.1,
            1.0 => -0.1,
            _ => 0.0,
        };
        Series { values: time_s.iter().map(pulse).collect::<Vec<_>>().into(), time_s: time_s.into() }
    }

    #[test]
    fn a_pulse_is_measured_where_it_takes_one_sample_and_where_it_takes_many() {
        let window = TimeRange { start_s: 0.0, end_s: 10.0 };
        let (apart_s, pulse_s) = measure_shortest_pulse(&doublet(0.25, 0.25), window).unwrap();
        assert!((apart_s - 0.25).abs() < 1e-12 && (pulse_s - 0.25).abs() < 1e-12);
        let (apart_s, pulse_s) = measure_shortest_pulse(&doublet(0.02, 0.3), window).unwrap();
        assert!((apart_s - 0.02).abs() < 1e-12 && (pulse_s - 0.3).abs() < 0.021, "{pulse_s}");
    }
}
