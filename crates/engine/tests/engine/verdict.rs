//! The verdict: good on flights with which nothing is wrong, with the right cause on others.

#![allow(clippy::unwrap_used, clippy::print_stdout, reason = "helpers of tests are not marked as tests")]

use std::path::Path;
use std::sync::Arc;

use doublet_core::airframe::{MassHistory, MassProperties, Stall};
use doublet_core::estimate::NonlinearSearch;
use doublet_core::model::{Coefficient, Term, ThrustTreatment};
use doublet_core::propulsion::{MapVariable, OffRange};
use doublet_core::quantity::Role;
use doublet_core::reconstruct::{Input, State};
use doublet_core::series::{Channel, Recording, Series};
use doublet_core::simulate::scenario;
use doublet_core::validate::{BandResult, Histories, Signal, TestResult, Tolerance};
use doublet_engine::graph::Context;
use doublet_engine::run::{Slot, Snapshot, WindowResults};
use doublet_engine::session::{self, Session, Surface, WindowRole};
use doublet_engine::stage::{self, AeroWindow, CoefficientFit, ExtrapolatedThrust, PooledFits};
use doublet_engine::study::{
    CheckStudy, CheckedDerivative, ControlLag, ESTIMATORS, LagKind, LagStudy, MethodChecks, MethodEstimates, ModelPart,
    PartEstimates, WindowChecks,
};
use doublet_engine::verdict::{Finding, Level, PlausibleRange, Verdicts, fly_and_judge, judge, judged_flights};

use crate::verdict_causes::{changed, consistency};

fn builtin(name: &str) -> Session {
    session::parse(doublet_engine::builtin::session(name).unwrap()).unwrap()
}

fn show(verdicts: &Verdicts) {
    println!("{}", verdicts.headline());
    verdicts.session.reasons.iter().for_each(|reason| println!("{} {}: {reason}", reason.level.name(), reason.code));
}

/// Verdicts on the six manoeuvres of a test point with a recording that `spoil` changed, and a session that `change` did.
fn judged(seed: u64, spoil: &(dyn Fn(&mut Recording) + Sync), change: impl Fn(&mut Session)) -> Arc<Verdicts> {
    let mut session = builtin("demo");
    change(&mut session);
    let scenario = scenario::build("test-point").unwrap();
    let (_, snapshot) = fly_and_judge(&session, &scenario, seed, spoil, &Context::new(Path::new("."))).unwrap();
    let verdicts = Arc::clone(snapshot.verdicts.ready().unwrap());
    show(&verdicts);
    verdicts
}

/// A flight with which nothing is wrong, to change one thing of.
struct Sound {
    session: Session,
    snapshot: Snapshot,
}

impl Sound {
    fn new() -> Self {
        let scenario = scenario::build("test-point").unwrap();
        let context = Context::new(Path::new("."));
        let (session, snapshot) = fly_and_judge(&builtin("demo"), &scenario, 1, &|_| (), &context).unwrap();
        Self { session, snapshot }
    }

    /// The worst finding with `code` once `change` is made, of the session, of windows as found, of fits or of derivatives.
    fn fires(&self, code: &str, change: impl Fn(&mut Session, &mut Snapshot)) -> Option<Finding> {
        let (mut session, mut snapshot) = (self.session.clone(), self.snapshot.clone());
        change(&mut session, &mut snapshot);
        let verdicts = judge(&session, &snapshot);
        let derivatives = verdicts.pooled.iter().flat_map(|fit| &fit.derivatives).map(|derivative| &derivative.verdict);
        let mut all: Vec<Finding> = verdicts.session.reasons.clone();
        all.extend(verdicts.windows.values().flat_map(|window| window.verdict.reasons.iter().cloned()));
        all.extend(derivatives.flat_map(|verdict| verdict.reasons.iter().cloned()));
        all.extend(verdicts.pooled.iter().flat_map(|fit| fit.verdict.reasons.iter().cloned()));
        all.sort_by_key(|finding| std::cmp::Reverse(finding.level));
        all.into_iter().find(|finding| finding.code == code)
    }

    /// Asserts that `code` fires with each level for the figures beside it.
    fn expect<T: Copy>(
        &self,
        code: &str,
        cases: &[(T, Option<Level>)],
        change: impl Fn(&mut Session, &mut Snapshot, T),
    ) {
        for (index, &(figure, level)) in cases.iter().enumerate() {
            let found = self.fires(code, |session, snapshot| change(session, snapshot, figure));
            println!("{code} {index}: {found:?}");
            assert_eq!(found.as_ref().map(|finding| finding.level), level, "{code}, case {index}: {found:?}");
            let is_explained = found
                .is_none_or(|finding| code == "failed" || (!finding.fix_text.is_empty() && finding.panel.is_some()));
            assert!(is_explained, "{code} says what to do and where");
        }
    }
}

/// The window that moves the elevator first.
fn elevator<'a>(session: &Session, snapshot: &'a mut Snapshot) -> &'a mut WindowResults {
    let window = session.windows.iter().find(|window| window.surface == Some(Surface::Elevator)).unwrap();
    snapshot.windows.get_mut(&window.name).unwrap()
}

fn pooled(fits: &mut PooledFits, coefficient: Coefficient) -> &mut CoefficientFit {
    fits.fits.iter_mut().find(|fit| fit.coefficient == coefficient).unwrap()
}

fn index_of(fit: &CoefficientFit, name: &str) -> usize {
    fit.fit.as_ref().unwrap().names.iter().position(|other| other == name).unwrap()
}

const NONE: Option<Level> = None;
const CAUTION: Option<Level> = Some(Level::Caution);
const BAD: Option<Level> = Some(Level::Bad);

#[test]
fn reasons_about_the_flight_path_fire_beyond_their_limits_only() {
    let sound = Sound::new();
    sound.expect(
        "nis",
        &[(1.2, NONE), (0.5, NONE), (1.7, CAUTION), (0.2, CAUTION), (3.5, BAD), (0.05, CAUTION)],
        |s, snapshot, ratio| {
            changed(&mut elevator(s, snapshot).path, |path| {
                let found = consistency(path);
                let expected = found.nis_mean / found.nis_ratio;
                (found.nis_ratio, found.nis_mean) = (ratio, ratio * expected);
            });
        },
    );
    sound.expect("innovation", &[(0.4, NONE), (-0.9, CAUTION), (6.0, BAD)], |s, snapshot, mean| {
        let path = &mut elevator(s, snapshot).path;
        changed(path, |path| consistency(path).channels[0].mean = mean);
    });
    sound.expect(
        "innovation",
        &[((0.9, 0.8), NONE), ((1.4, 0.2), NONE), ((1.4, 0.8), CAUTION)],
        |s, snapshot, (ratio, lag_one)| {
            changed(&mut elevator(s, snapshot).path, |path| {
                let channel = &mut consistency(path).channels[0];
                (channel.deviation_ratio, channel.autocorrelation[0], channel.is_white) = (ratio, lag_one, false);
            });
        },
    );
    sound.expect(
        "smoother",
        &[((4.0, 10), NONE), ((4.0, 100), CAUTION), ((30.0, 10), NONE), ((30.0, 40), BAD)],
        |s, snapshot, (by, samples)| {
            changed(&mut elevator(s, snapshot).path, |path| {
                let run = &mut path.reconstruction;
                let k = State::VelocityW as usize;
                let smoothed = run.smoothed.as_mut().unwrap();
                for index in 200..200 + samples {
                    smoothed.states[k][index] = run.states[k][index] + by * run.deviations[k].at(index);
                }
            });
        },
    );
    sound.expect("dynamic-pressure", &[(0.8, NONE), (0.4, CAUTION), (0.05, BAD)], |s, snapshot, part| {
        changed(&mut elevator(s, snapshot).aero, |aero| {
            Arc::make_mut(&mut aero.data.density_kg_m3).iter_mut().for_each(|rho| *rho *= part)
        });
    });
    let with_mass = |s: &Session, snapshot: &mut Snapshot, change: &dyn Fn(&mut MassProperties)| {
        changed(&mut elevator(s, snapshot).aero, |aero| {
            if let MassHistory::PerSample(all) = &mut aero.data.mass {
                Arc::make_mut(all).iter_mut().for_each(change);
            }
        });
    };
    sound.expect("loading", &[(0.0, NONE), (1.0, CAUTION)], |s, snapshot, aft_m| {
        with_mass(s, snapshot, &|mass| mass.cg_from_datum_m[0] += aft_m);
    });
    sound.expect("loading", &[(1.0, NONE), (-1.0, BAD), (9.0, BAD)], |s, snapshot, times| {
        with_mass(s, snapshot, &|mass| mass.inertia.yy *= times);
    });
    sound.expect("turn", &[(30.0_f64, NONE), (90.0, CAUTION)], |s, snapshot, degrees| {
        changed(&mut elevator(s, snapshot).path, |path| {
            let heading = &mut path.reconstruction.smoothed.as_mut().unwrap().states[State::HeadingAngle as usize];
            let step = degrees.to_radians() / heading.len() as f64;
            heading.iter_mut().enumerate().for_each(|(k, angle)| *angle += step * k as f64);
        });
    });
    sound.expect("sampling", &[(0.02, NONE), (0.2, CAUTION)], |_, snapshot, apart_s: f64| {
        changed(snapshot.flights.values_mut().next().unwrap(), |flight| {
            let channel = &mut flight.recording.channels[flight.recording.roles[&Role::Elevator]];
            let time_s: Arc<[f64]> = (0..(5000.0 / apart_s) as usize).map(|k| apart_s * k as f64).collect();
            let values = time_s.iter().map(|t| 0.05 * (0.5 * t).floor().rem_euclid(2.0)).collect();
            channel.series = Series { time_s, values };
        });
    });
    sound.expect("failed", &[((), BAD)], |s, snapshot, ()| {
        elevator(s, snapshot).path = Slot::Failed { error: "the filter failed".to_owned(), last: None };
    });
}

#[test]
fn flight_too_slow_for_the_wing_and_weight_on_the_wheels_are_told() {
    let sound = Sound::new();
    // The test point is flown at 43.6 m/s calibrated.
    sound.expect("dynamic-pressure", &[(35.0, NONE), (41.5, CAUTION), (50.0, BAD)], |s, snapshot, stall_m_s| {
        let mass_kg = elevator(s, snapshot).aero.ready().unwrap().data.mass.at(0).mass_kg;
        let stall = Stall { calibrated_airspeed_m_s: stall_m_s, mass_kg };
        changed(&mut snapshot.aircraft, |loaded| loaded.aircraft.stall = Some(stall));
    });
    // The whole flight is slow, and all windows with it.
    sound.expect("dynamic-pressure", &[(1.5, NONE), (2.5, CAUTION), (4.0, BAD)], |_, snapshot, times| {
        let flight = snapshot.flights.values_mut().next().unwrap();
        changed(flight, |flight| with_values(&mut flight.recording, Role::TrueAirspeed, |value| times * value));
        let physics = stage::physics_of(&flight.ready().unwrap().recording, "as flown");
        *snapshot.physics.values_mut().next().unwrap() = physics.into();
    });
    sound.expect("dynamic-pressure", &[(0.0, NONE), (0.05, CAUTION), (0.5, BAD)], |s, snapshot, part| {
        let window = s.windows[0].window;
        changed(snapshot.flights.values_mut().next().unwrap(), |flight| {
            let time_s: Vec<f64> =
                (0..1000).map(|k| window.start_s + 0.001 * f64::from(k) * (window.end_s - window.start_s)).collect();
            let values = (0..1000).map(|k| f64::from(u8::from(f64::from(k) < 1000.0 * part))).collect();
            let recording = &mut flight.recording;
            recording.roles.insert(Role::WeightOnWheels, recording.channels.len());
            recording.channels.push(Channel {
                source: String::new(),
                name: "wheels".to_owned(),
                unit: String::new(),
                series: Series { time_s: time_s.into(), values },
            });
        });
    });
}

#[test]
fn thrust_extrapolated_or_not_known_is_told_where_it_enters() {
    let sound = Sound::new();
    let along = |snapshot: &mut Snapshot, change: &dyn Fn(&mut stage::WindowAero)| {
        snapshot.windows.values_mut().for_each(|window| changed(&mut window.aero, change));
    };
    // By a residual of CX of some thousandths, 46 kPa m2: 1 N is nothing, 1 kN is.
    sound.expect("propulsion", &[(0.0, NONE), (1.0, NONE), (1000.0, CAUTION)], |_, snapshot, added_n| {
        along(snapshot, &|aero| {
            let off_range = OffRange { variable: MapVariable::AdvanceRatio, value: 1.5, low: 0.2, high: 1.2 };
            aero.extrapolated_thrust = vec![ExtrapolatedThrust {
                engine: "front".to_owned(),
                off_range: vec![(off_range, 9)],
                added_n: vec![added_n; aero.data.time_s.len()],
            }];
        });
    });
    sound.expect("propulsion", &[((), BAD)], |_, snapshot, ()| {
        along(snapshot, &|aero| aero.unknown_thrust = vec!["rear".to_owned()]);
    });
    // A thrust that CX contains is told where a term of airspeed changes the derivatives.
    let included = [((false, 0.0), NONE), ((true, 0.0), NONE), ((true, 0.5), CAUTION)];
    sound.expect("propulsion", &included, |_, snapshot, (is_unknown, of_airspeed)| {
        along(snapshot, &|aero| {
            aero.settings.thrust = ThrustTreatment::Included;
            if is_unknown {
                aero.data.engines.clear();
            }
            let start_m_s = aero.data.airspeed_m_s[0];
            let added = aero.data.airspeed_m_s.iter().map(|airspeed| of_airspeed * (airspeed / start_m_s - 1.0));
            let column = &mut aero.coefficients.columns[Coefficient::CX as usize];
            *column = column.iter().zip(added).map(|(cx, added)| cx + added).collect();
        });
        let windows: Vec<AeroWindow<'_>> = sound
            .session
            .windows
            .iter()
            .filter(|window| window.role == WindowRole::Identification)
            .map(|window| (window, Arc::clone(snapshot.windows[&window.name].aero.ready().unwrap())))
            .collect();
        let mut fits = stage::pooled_fits(&windows, &sound.session.structure, &sound.session.estimation);
        let refitted = pooled(&mut fits, Coefficient::CX).clone();
        changed(&mut snapshot.pooled, |fits| *pooled(fits, Coefficient::CX) = refitted.clone());
    });
}

#[test]
fn coefficient_that_no_window_is_used_for_has_a_verdict() {
    let sound = Sound::new();
    sound.expect("failed", &[(false, NONE), (true, CAUTION)], |_, snapshot, unused| {
        changed(&mut snapshot.pooled, |fits| fits.fits.retain(|fit| !unused || fit.coefficient != Coefficient::CY));
    });
}

#[test]
fn predictions_that_fail_are_told_and_bad_only_where_the_manoeuvre_tells() {
    let sound = Sound::new();
    let of_cm = |snapshot: &mut Snapshot, r_squared: f64, residual: f64| {
        let mut window = String::new();
        changed(&mut snapshot.pooled, |fits| {
            let predicted = fits.predictions.iter_mut().find(|one| one.coefficient == Coefficient::Cm).unwrap();
            predicted.role = WindowRole::Validation;
            predicted.quality_identified.r_squared = r_squared;
            window.clone_from(&predicted.window);
        });
        changed(&mut snapshot.windows.get_mut(&window).unwrap().fits, |fits| {
            let own = fits.fits.iter_mut().find(|fit| fit.coefficient == Coefficient::Cm).unwrap();
            own.fit.as_mut().unwrap().residual_std *= residual;
        });
    };
    let cases = [((0.9, 1.0), NONE), ((0.7, 1.0), CAUTION), ((0.4, 1.0), BAD), ((0.4, 100.0), CAUTION)];
    sound.expect("r2", &cases, |_, snapshot, (r_squared, residual)| of_cm(snapshot, r_squared, residual));
    sound.expect("r2", &[(0.6, NONE), (0.4, CAUTION)], |_, snapshot, r_squared| {
        changed(&mut snapshot.pooled, |fits| {
            pooled(fits, Coefficient::Cm).fit.as_mut().unwrap().quality.r_squared = r_squared;
        });
    });
}

#[test]
fn twins_apart_late_controls_and_missed_bands_are_told() {
    let sound = Sound::new();
    let window = sound.session.windows.iter().find(|window| window.surface == Some(Surface::Elevator)).unwrap();
    let name = window.name.clone();
    // Apart by joint errors, and by a part of the estimate.
    for (apart, level) in [(2.0, NONE), (5.0, CAUTION), (10.0, BAD)] {
        let mut snapshot = sound.snapshot.clone();
        changed(&mut snapshot.windows.get_mut(&name).unwrap().fits, |fits| {
            let fit = fits.fits.iter_mut().find(|fit| fit.coefficient == Coefficient::Cm).unwrap();
            let index = index_of(fit, "Cm_q");
            fit.fit.as_mut().unwrap().estimates[index] = -5.0;
            fit.corrected_errors[index] = 0.3;
        });
        let twin = CheckedDerivative { name: "Cm_q".to_owned(), estimate: -5.0 - 0.5 * apart, standard_error: 0.4 };
        let result = Ok(MethodEstimates { derivatives: vec![twin], ..MethodEstimates::default() });
        let parts = vec![PartEstimates { part: ModelPart::Coefficient(Coefficient::Cm), result }];
        let methods = vec![MethodChecks { method: &ESTIMATORS[0], parts }];
        let windows = vec![WindowChecks { window: name.clone(), methods }];
        snapshot.studies.checks = CheckStudy { windows, ..CheckStudy::default() }.into();
        let verdicts = judge(&sound.session, &snapshot);
        let derivative = verdicts.fit(Some(&name), Coefficient::Cm).unwrap().derivative("Cm_q").unwrap();
        let found = derivative.reasons.iter().find(|reason| reason.code == "twin");
        assert_eq!(found.map(|reason| reason.level), level, "{apart}: {found:?}");
    }
    // Within 1.5 samples of 0.02 s; not significant; one that the pooled fit of the moment does not need, however large.
    let cases = [((0.02, 0.001), NONE), ((0.1, 0.05), NONE), ((0.1, 0.01), NONE), ((0.4, 0.01), NONE)];
    sound.expect("timing", &cases, |_, snapshot, (value, standard_error)| {
        let search = NonlinearSearch {
            value,
            standard_error,
            by_regression: vec![(value, standard_error)],
            profile: Vec::new(),
            fits: Vec::new(),
        };
        let coefficients = vec![Coefficient::Cm];
        let lag = ControlLag { surface: Surface::Elevator, kind: LagKind::Delay, coefficients, result: Ok(search) };
        snapshot.studies.lags = LagStudy { lags: vec![lag] }.into();
    });
    sound.expect("match", &[(0.9, NONE), (1.4, CAUTION)], |_, snapshot, ratio| {
        let tolerance = Tolerance { signal: Signal::ALL[0], absolute: 1.0, of_value: 0.0, of_peak: 0.0 };
        let band = BandResult {
            tolerance,
            half_width: Vec::new(),
            worst_ratio: ratio,
            worst_error: ratio,
            worst_time_s: 0.0,
            share_inside: 0.5,
        };
        let test = TestResult { id: "2.c.10".to_owned(), name: String::new(), requirements: vec![vec![band]] };
        let histories = Histories { time_s: Vec::new(), columns: Default::default() };
        let replay = stage::WindowReplay {
            measured: histories.clone(),
            simulated: histories,
            series: Vec::new(),
            theil: Vec::new(),
            tests: vec![test],
        };
        let proof =
            stage::ProofOfMatch { tolerances: "t".to_owned(), windows: vec![(name.clone(), Ok(Arc::new(replay)))] };
        snapshot.proof = proof.into();
    });
}

#[test]
fn reasons_about_fits_and_derivatives_fire_beyond_their_limits_only() {
    let sound = Sound::new();
    sound.expect("rank", &[(false, NONE), (true, BAD)], |_, snapshot, fails| {
        changed(&mut snapshot.pooled, |fits| {
            if fails {
                pooled(fits, Coefficient::Cm).fit = Err("rank 3 of 4".into());
            }
        });
    });
    let cm = |snapshot: &mut Snapshot, change: &dyn Fn(&mut CoefficientFit)| {
        changed(&mut snapshot.pooled, |fits| change(pooled(fits, Coefficient::Cm)));
    };
    let cm_alone = |session: &mut Session, snapshot: &mut Snapshot| {
        changed(&mut snapshot.pooled, |fits| fits.fits.retain(|fit| fit.coefficient == Coefficient::Cm));
        session.structure.models.retain(|(coefficient, _)| *coefficient == Coefficient::Cm);
    };
    // Dependent regressors are told where they leave a derivative open.
    let open = |fit: &mut CoefficientFit, is_open: bool| {
        let part = if is_open { 0.6 } else { 0.1 };
        fit.corrected_errors = fit.fit.as_ref().unwrap().estimates.iter().map(|value| part * value.abs()).collect();
    };
    let conditions = [((90.0, true), NONE), ((150.0, false), NONE), ((150.0, true), CAUTION)];
    sound.expect("condition", &conditions, |session, snapshot, (number, is_open)| {
        cm_alone(session, snapshot);
        cm(snapshot, &|fit| {
            fit.fit.as_mut().unwrap().condition_number = number;
            open(fit, is_open);
        });
    });
    let factors = [((1.0, true), NONE), ((1e4, false), NONE), ((1e4, true), CAUTION)];
    sound.expect("vif", &factors, |session, snapshot, (times, is_open)| {
        cm_alone(session, snapshot);
        cm(snapshot, &|fit| {
            fit.fit.as_mut().unwrap().unit_covariance *= times;
            open(fit, is_open);
        });
    });
    sound.expect("excitation", &[(1e-3, NONE), (1.0, CAUTION)], |session, snapshot, noise| {
        cm_alone(session, snapshot);
        session.filter.process_noise[Input::PitchRate as usize] = noise;
    });
    sound.expect("excitation", &[((), BAD)], |session, snapshot, ()| {
        cm_alone(session, snapshot);
        session.structure.models[0].1.retain(Term::is_constant);
    });
    sound.expect("determined", &[(0.3, NONE), (0.6, CAUTION)], |session, snapshot, part| {
        cm_alone(session, snapshot);
        cm(snapshot, &|fit| {
            let index = index_of(fit, "Cm_q");
            fit.corrected_errors[index] = part * fit.fit.as_ref().unwrap().estimates[index].abs();
        });
    });
    // Outside by more than three errors and three tenths of the range; beyond by more than a width; of the wrong sign; absurd.
    let plausible = [
        ((-30.0, 0.1), NONE),
        ((-41.0, 0.5), NONE),
        ((-51.0, 0.2), NONE),
        ((-53.0, 0.2), CAUTION),
        ((-90.0, 1.0), BAD),
        ((2.0, 0.1), BAD),
        ((-900.0, 1e4), CAUTION),
        ((-900.0, 200.0), BAD),
    ];
    let with_damping = |snapshot: &mut Snapshot, (value, error): (f64, f64)| {
        cm(snapshot, &|fit| {
            let index = index_of(fit, "Cm_q");
            fit.corrected_errors[index] = error;
            fit.fit.as_mut().unwrap().estimates[index] = value;
        });
    };
    sound.expect("plausible", &plausible, |_, snapshot, figures| with_damping(snapshot, figures));
    sound.expect("plausible", &[((-90.0, 1.0), NONE)], |session, snapshot, figures| {
        session.plausible.insert("Cm_q".to_owned(), PlausibleRange { low: -100.0, high: 0.0, sign_certain: true });
        with_damping(snapshot, figures);
    });
    // A range that the session states is kept to.
    sound.expect("plausible", &[((-41.0, 0.2), CAUTION)], |session, snapshot, figures| {
        session.plausible.insert("Cm_q".to_owned(), PlausibleRange { low: -40.0, high: 0.0, sign_certain: true });
        with_damping(snapshot, figures);
    });
}

#[test]
fn windows_that_contradict_each_other_are_named() {
    let sound = Sound::new();
    let contradicting = |apart: f64, is_felt: bool| {
        sound.fires("scatter", |session, snapshot| {
            // As in the ATTAS recordings: one window is certain of what the others deny.
            let windows: Vec<String> = snapshot.windows.keys().cloned().collect();
            let mut first = true;
            for name in windows.iter().filter(|name| name.contains("elevator")) {
                changed(&mut snapshot.windows.get_mut(name).unwrap().fits, |fits| {
                    let fit = fits.fits.iter_mut().find(|fit| fit.coefficient == Coefficient::Cm).unwrap();
                    let index = index_of(fit, "Cm_q");
                    fit.fit.as_mut().unwrap().estimates[index] = if first { -5.0 - apart } else { -5.0 };
                    fit.corrected_errors[index] = if first { 0.4 } else { 2.0 };
                });
                first = false;
            }
            changed(&mut snapshot.pooled, |fits| {
                let fit = pooled(fits, Coefficient::Cm);
                let index = index_of(fit, "Cm_q");
                fit.fit.as_mut().unwrap().estimates[index] = -5.5;
                (fit.corrected_errors[index], fit.noise_errors[index]) = (1.5, 1.5);
            });
            // Its samples as well: leaving it out changes the pooled estimate.
            if is_felt {
                changed(&mut elevator(session, snapshot).aero, |aero| {
                    let chord_m = aero.settings.reference.chord_m;
                    let rates = aero.data.rates_rad_s[1].iter().zip(aero.data.airspeed_m_s.iter());
                    let added = rates.map(|(q, airspeed)| -20.0 * q * chord_m / airspeed);
                    let column = &mut aero.coefficients.columns[Coefficient::Cm as usize];
                    *column = column.iter().zip(added).map(|(cm, added)| cm + added).collect();
                });
            }
        })
    };
    assert_eq!(contradicting(1.0, true), None);
    assert_eq!(contradicting(9.0, false), None, "a manoeuvre that changes nothing when it is left out");
    let found = contradicting(6.0, true).unwrap();
    assert_eq!(found.level, Level::Caution, "{found:?}");
    assert!(found.place.pooled() == Some("Cm_q") && found.text.to_string().contains("03 elevator"), "{found:?}");
    assert_eq!(contradicting(9.0, true).unwrap().level, Level::Bad);
}

#[test]
fn terms_that_rest_in_every_window_are_dropped_and_dependent_ones_are_the_error_of_their_fit() {
    let sound = Sound::new();
    let Sound { session, snapshot } = &sound;
    let rests = |surface: Surface| {
        let rudder_only: Vec<_> = session.windows.iter().filter(|window| window.surface == Some(surface)).collect();
        let windows: Vec<AeroWindow<'_>> = rudder_only
            .into_iter()
            .map(|window| {
                let mut aero = stage::WindowAero::clone(snapshot.windows[&window.name].aero.ready().unwrap());
                Arc::make_mut(aero.data.controls.get_mut(&Role::Aileron).unwrap()).fill(0.01);
                let aero = stage::WindowAero::form(aero.data, aero.settings, aero.air_density).unwrap();
                (window, Arc::new(aero))
            })
            .collect();
        stage::pooled_fits(&windows, &session.structure, &session.estimation)
    };
    let fits = rests(Surface::Rudder);
    let side = fits.fits.iter().find(|fit| fit.coefficient == Coefficient::CY).unwrap();
    assert!(side.fit.is_ok(), "{:?}", side.fit);
    let dropped: Vec<&str> = side.dropped.iter().map(|term| term.derivative.as_str()).collect();
    assert_eq!(dropped, ["CY_delta_a"]);
    assert!(!side.fit.as_ref().unwrap().names.iter().any(|name| name == "CY_delta_a"));

    // Regressors that move together are not dropped: that fit fails, the others do not.
    let windows: Vec<AeroWindow<'_>> = session
        .windows
        .iter()
        .map(|window| (window, Arc::clone(snapshot.windows[&window.name].aero.ready().unwrap())))
        .collect();
    let mut structure = session.structure.clone();
    let twice = Term::parse("qc/2V").unwrap();
    structure.models.iter_mut().filter(|(c, _)| *c == Coefficient::Cm).for_each(|(_, terms)| terms.push(twice.clone()));
    let fits = stage::pooled_fits(&windows, &structure, &session.estimation);
    for fit in &fits.fits {
        assert_eq!(fit.fit.is_err(), fit.coefficient == Coefficient::Cm, "{}", fit.coefficient.name());
    }
}

fn reasons<'a>(verdicts: &'a Verdicts, code: &str) -> Vec<&'a Finding> {
    verdicts.session.reasons.iter().filter(|reason| reason.code == code).collect()
}

/// The recording with the values of a role changed.
fn with_values(recording: &mut Recording, role: Role, change: impl Fn(f64) -> f64) {
    let channel = &mut recording.channels[recording.roles[&role]];
    let values = channel.series.values.iter().map(|&value| change(value)).collect();
    channel.series = Series { time_s: Arc::clone(&channel.series.time_s), values };
}

/// The recording with the clock of a role changed.
fn with_times(recording: &mut Recording, role: Role, change: impl Fn(f64) -> f64) {
    let channel = &mut recording.channels[recording.roles[&role]];
    let time_s = channel.series.time_s.iter().map(|&time| change(time)).collect();
    channel.series = Series { time_s, values: Arc::clone(&channel.series.values) };
}

#[test]
fn consistent_flights_get_no_bad_reason_anywhere() {
    let scenario = scenario::build("test-point").unwrap();
    let context = Context::new(Path::new("."));
    let found = judged_flights(&builtin("demo"), &scenario, (6, 11), &context).unwrap();
    assert_eq!((found.flights, found.bad_anywhere, found.sessions[2]), (6, 0, 0), "{:?}", found.examples);
}

#[test]
fn a_consistent_flight_has_no_bad_reason_and_each_fault_has_its_cause() {
    let sound = judged(1, &|_| (), |_| ());
    assert!(sound.session.level < Level::Bad);
    assert!(sound.windows.values().all(|window| window.verdict.level == Level::Good));

    let turned = judged(1, &|recording| with_values(recording, Role::AngleOfAttack, |value| -value), |_| ());
    assert_eq!(turned.session.level, Level::Bad);
    assert!(reasons(&turned, "nis").iter().any(|reason| reason.text.to_string().contains("alpha")), "alpha turned");

    let turned = judged(1, &|recording| with_values(recording, Role::PitchRate, |value| -value), |_| ());
    assert_eq!(turned.session.level, Level::Bad);
    assert!(
        reasons(&turned, "physics").iter().any(|reason| reason.text.to_string().contains("q: sign reversed")),
        "q turned"
    );

    let turned = judged(1, &|recording| with_values(recording, Role::Elevator, |value| -value), |_| ());
    assert_eq!(turned.session.level, Level::Bad);
    assert!(
        reasons(&turned, "plausible").iter().any(|reason| reason.place.pooled() == Some("Cm_delta_e")),
        "elevator turned"
    );

    let clock = judged(1, &|recording| with_times(recording, Role::AngleOfAttack, |time| 1.02 * time), |_| ());
    assert!(reasons(&clock, "nis").iter().any(|reason| reason.text.to_string().contains("alpha")), "clock of alpha");

    let gravity = judged(1, &|_| (), |session| session.filter.gravity_m_s2 += 0.05);
    // It is in the constant of CZ, and in no derivative.
    assert_eq!(gravity.session.level, Level::Good, "{:?}", gravity.session.reasons);
}
