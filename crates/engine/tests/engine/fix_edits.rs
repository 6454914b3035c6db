//! Fixes of findings, one by one: applied, each removes its finding or changes the setting that the finding is about.

#![allow(clippy::panic, clippy::unwrap_used, reason = "helpers of tests are not marked as tests")]

use std::path::Path;
use std::sync::Arc;

use doublet_core::estimate::{Dependence, EstimateError};
use doublet_core::model::{Coefficient, Term, Variable};
use doublet_core::quantity::Role;
use doublet_core::reconstruct::consistency::ChannelConsistency;
use doublet_core::reconstruct::{AirState, Input, Measurement, State};
use doublet_core::series::{Channel, Recording, Series, TimeRange};
use doublet_core::simulate::scenario;
use doublet_engine::graph::{Context, StageError};
use doublet_engine::run::{Slot, Snapshot, WindowResults};
use doublet_engine::session::{
    self, AngularAcceleration, DelaySource, Edit, Fix, GustSource, PathSource, Place, PlausibleRange, Session, Surface,
    WindowEdit, WindowRole,
};
use doublet_engine::stage::{self, CoefficientFit, ConstantError, SensorDelay, SensorDelays};
use doublet_engine::verdict::{self, Finding, Level, fly_and_judge, judge};

use crate::verdict_causes::{changed, consistency};

/// A flight with which nothing is wrong, to change one thing of.
fn flown() -> (Session, Snapshot) {
    let session = session::parse(doublet_engine::builtin::session("demo").unwrap()).unwrap();
    let scenario = scenario::build("test-point").unwrap();
    let context = Context::new(Path::new("."));
    let (mut session, snapshot) = fly_and_judge(&session, &scenario, 1, &|_| (), &context).unwrap();
    session.flights.truncate(1);
    session.steady.clear();
    session.flights[0].name.clone_from(&session.windows[0].flight);
    (session, snapshot)
}

/// All findings of a code: of the session, of manoeuvres, of pooled fits and of their derivatives.
fn found(session: &Session, snapshot: &Snapshot, code: &str) -> Vec<Finding> {
    let verdicts = judge(session, snapshot);
    let derivatives = verdicts.pooled.iter().flat_map(|fit| &fit.derivatives).map(|one| &one.verdict);
    let all = [&verdicts.session].into_iter().chain(verdicts.windows.values().map(|window| &window.verdict));
    let all = all.chain(verdicts.pooled.iter().map(|fit| &fit.verdict)).chain(derivatives);
    all.flat_map(|verdict| &verdict.reasons).filter(|finding| finding.code == code).cloned().collect()
}

/// The first fix among the findings of a code.
fn fix_of(session: &Session, snapshot: &Snapshot, code: &str) -> Fix {
    let found = found(session, snapshot, code);
    found.iter().find_map(|finding| finding.fix.clone()).unwrap_or_else(|| panic!("{code} has a fix: {found:?}"))
}

/// Place of the first manoeuvre of the elevator in the session.
fn elevator(session: &Session) -> usize {
    session.windows.iter().position(|window| window.surface == Some(Surface::Elevator)).unwrap()
}

fn results<'a>(session: &Session, snapshot: &'a mut Snapshot) -> &'a mut WindowResults {
    snapshot.windows.get_mut(&session.windows[elevator(session)].name).unwrap()
}

fn change_channels(snapshot: &mut Snapshot, change: impl Fn(&mut ChannelConsistency)) {
    for results in snapshot.windows.values_mut() {
        changed(&mut results.path, |path| {
            consistency(path).channels.iter_mut().for_each(&change);
        });
    }
}

fn change_cm(snapshot: &mut Snapshot, change: impl FnOnce(&mut CoefficientFit)) {
    changed(&mut snapshot.pooled, |fits| {
        change(fits.fits.iter_mut().find(|fit| fit.coefficient == Coefficient::Cm).unwrap());
    });
}

fn index_of(fit: &CoefficientFit, name: &str) -> usize {
    fit.fit.as_ref().unwrap().names.iter().position(|other| other == name).unwrap()
}

/// The terms of Cm of a session by the names of their derivatives.
fn terms_of_cm(session: &Session) -> Vec<String> {
    session.structure.derivative_names(Coefficient::Cm)
}

fn add_channel(snapshot: &mut Snapshot, role: Role, series: Series) {
    changed(snapshot.flights.values_mut().next().unwrap(), |flight| {
        let (source, name, unit) = (String::new(), role.name().to_owned(), String::new());
        flight.recording.roles.insert(role, flight.recording.channels.len());
        flight.recording.channels.push(Channel { source, name, unit, series });
    });
}

#[test]
fn measured_path_is_replaced_by_the_smoothed_one() {
    let (mut session, snapshot) = flown();
    session.preparation.path = PathSource::Measured;
    let fixed = fix_of(&session, &snapshot, "as-measured").apply(&session).unwrap();
    assert_eq!(fixed.preparation.path, PathSource::Smoothed);
    assert_eq!(found(&fixed, &snapshot, "as-measured"), []);
}

#[test]
fn manoeuvre_that_cannot_be_computed_is_ignored() {
    let (session, mut snapshot) = flown();
    results(&session, &mut snapshot).path = Slot::Failed { error: "the filter failed".to_owned(), last: None };
    let fixed = fix_of(&session, &snapshot, "failed").apply(&session).unwrap();
    let at = elevator(&session);
    assert_eq!(fixed.windows[at].role, WindowRole::Ignored);
    let name = format!("'{}'", session.windows[at].name);
    assert!(
        found(&fixed, &snapshot, "failed").iter().all(|finding| finding.place.manoeuvre_name() != Some(name.as_str()))
    );
}

#[test]
fn coefficient_without_a_manoeuvre_is_removed() {
    let (session, mut snapshot) = flown();
    changed(&mut snapshot.pooled, |fits| fits.fits.retain(|fit| fit.coefficient != Coefficient::CY));
    let fixed = fix_of(&session, &snapshot, "failed").apply(&session).unwrap();
    assert!(fixed.structure.terms(Coefficient::CY).is_none());
    assert_eq!(fixed.structure.models.len() + 1, session.structure.models.len());
    assert_eq!(found(&fixed, &snapshot, "failed"), []);
}

/// Filter and smoother 30 standard errors apart over 40 samples; by 4 over 100 samples, as in gusts.
#[test]
fn part_where_filter_and_smoother_disagree_is_excluded_or_gusts_are_estimated_or_the_smoother_is_iterated() {
    let (session, sound) = flown();
    assert_eq!(session.gusts, GustSource::Stated, "as the shipped session has it");
    let apart = |by: f64, samples: usize| {
        let mut snapshot = sound.clone();
        changed(&mut results(&session, &mut snapshot).path, |path| {
            let (run, k) = (&mut path.reconstruction, State::VelocityW as usize);
            let smoothed = run.smoothed.as_mut().unwrap();
            for index in 200..200 + samples {
                smoothed.states[k][index] = run.states[k][index] + by * run.deviations[k].at(index);
            }
        });
        snapshot
    };
    let snapshot = apart(30.0, 40);
    let fixed = fix_of(&session, &snapshot, "smoother").apply(&session).unwrap();
    let window = &session.windows[elevator(&session)];
    let time_s = snapshot.windows[&window.name].path.ready().unwrap().reconstruction.time_s.clone();
    let excluded = TimeRange { start_s: time_s[200], end_s: time_s[239] };
    assert_eq!(fixed.windows[elevator(&session)].excluded, [excluded]);
    assert_eq!(found(&fixed, &snapshot, "smoother"), []);
    let fixed = fix_of(&session, &apart(4.0, 100), "smoother").apply(&session).unwrap();
    assert_eq!(fixed.gusts, GustSource::Estimated);
    // With these the smoother is iterated.
    assert_eq!(fixed.filter.smoother_passes, 1);
    let iterated = fix_of(&fixed, &apart(4.0, 100), "smoother").apply(&fixed).unwrap();
    assert_eq!(iterated.filter.smoother_passes, 3);
}

#[test]
fn manoeuvre_with_a_turn_is_shortened_to_the_part_beside_it() {
    let (session, mut snapshot) = flown();
    changed(&mut results(&session, &mut snapshot).path, |path| {
        let heading = &mut path.reconstruction.smoothed.as_mut().unwrap().states[State::HeadingAngle as usize];
        let step = 90.0_f64.to_radians() / heading.len() as f64;
        heading.iter_mut().enumerate().for_each(|(k, angle)| *angle += step * k as f64);
    });
    let fixed = fix_of(&session, &snapshot, "turn").apply(&session).unwrap();
    let at = elevator(&session);
    let (before, after) = (session.windows[at].window, fixed.windows[at].window);
    let part = (after.end_s - after.start_s) / (before.end_s - before.start_s);
    assert!((0.4..0.65).contains(&part), "45 of 90 deg: {part}");
    assert!(after.start_s == before.start_s || after.end_s == before.end_s, "{after:?} of {before:?}");
}

#[test]
fn samples_on_the_wheels_are_excluded_and_a_manoeuvre_that_is_mostly_on_them_is_ignored() {
    let (session, sound) = flown();
    let TimeRange { start_s, end_s } = session.windows[0].window;
    let on_wheels = |part: f64| {
        let mut snapshot = sound.clone();
        let time_s: Vec<f64> = (0..1000).map(|k| start_s + 0.001 * f64::from(k) * (end_s - start_s)).collect();
        let values = (0..1000).map(|k| f64::from(u8::from(f64::from(k) < 1000.0 * part))).collect();
        add_channel(&mut snapshot, Role::WeightOnWheels, Series { time_s: time_s.into(), values });
        snapshot
    };
    let snapshot = on_wheels(0.05);
    let fixed = fix_of(&session, &snapshot, "dynamic-pressure").apply(&session).unwrap();
    let [excluded] = fixed.windows[0].excluded[..] else { panic!("{:?}", fixed.windows[0].excluded) };
    assert_eq!(excluded.start_s, start_s);
    assert!((excluded.end_s - start_s - 0.05 * (end_s - start_s)).abs() < 1e-6, "{excluded:?}");
    assert_eq!(found(&fixed, &snapshot, "dynamic-pressure"), []);
    let fixed = fix_of(&session, &on_wheels(0.7), "dynamic-pressure").apply(&session).unwrap();
    assert_eq!((fixed.windows[0].role, fixed.windows[0].excluded.len()), (WindowRole::Ignored, 0));
}

#[test]
fn correlated_innovations_lead_to_estimated_delays_where_the_session_states_them() {
    let (mut session, mut snapshot) = flown();
    change_channels(&mut snapshot, |channel| {
        (channel.deviation_ratio, channel.autocorrelation[0], channel.is_white) = (1.4, 0.8, false);
    });
    session.delays = DelaySource::Estimated;
    assert!(found(&session, &snapshot, "innovation").iter().all(|finding| finding.fix.is_none()));
    session.delays = DelaySource::Stated;
    let fixed = fix_of(&session, &snapshot, "innovation").apply(&session).unwrap();
    assert_eq!(fixed, Session { delays: DelaySource::Estimated, ..session });
}

#[test]
fn late_gyros_lead_to_a_shift_of_their_recorder_where_it_records_nothing_else() {
    let (session, mut snapshot) = flown();
    let delay = SensorDelay { kind: ConstantError::AttitudeDelay, delay_s: -0.08, standard_error_s: 0.002 };
    snapshot.delays_and_gusts.delays = Some(SensorDelays(vec![delay]));
    let gyros = |snapshot: &Snapshot| -> Vec<Finding> {
        found(&session, snapshot, "timing").into_iter().filter(|finding| finding.place.is_named("gyros")).collect()
    };
    let recorded_by = |snapshot: &mut Snapshot, roles: &[Role]| {
        changed(snapshot.flights.values_mut().next().unwrap(), |flight| {
            for role in roles {
                let channel = &mut flight.recording.channels[flight.recording.roles[role]];
                channel.source = "imu".to_owned();
            }
        });
    };
    recorded_by(&mut snapshot, &Input::ALL.map(Input::role));
    let alone = gyros(&snapshot);
    let late_s = alone[0].figure.unwrap();
    let fixed = alone[0].fix.as_ref().unwrap().apply(&session).unwrap();
    let clock = fixed.flights[0].clocks.iter().find(|clock| clock.source == "imu").unwrap();
    assert!(late_s > 0.05 && (clock.shift_s + late_s).abs() < 1e-9, "{} {late_s}", clock.shift_s);
    recorded_by(&mut snapshot, &[Role::AngleOfAttack]);
    assert!(gyros(&snapshot).iter().all(|finding| finding.fix.is_none()));
}

#[test]
fn offset_of_a_vane_is_estimated_by_the_filter() {
    let (session, mut snapshot) = flown();
    change_channels(&mut snapshot, |channel| {
        if channel.measurement == Measurement::AngleOfAttack {
            channel.mean = 6.0;
        }
    });
    let fixed = fix_of(&session, &snapshot, "innovation").apply(&session).unwrap();
    let deviation_rad = fixed.filter.air_data_deviation[AirState::AlphaOffset as usize];
    assert!((deviation_rad.to_degrees() - 2.0).abs() < 1e-9, "{deviation_rad}");
    assert!(found(&fixed, &snapshot, "innovation").iter().all(|finding| finding.fix.is_none()));
}

#[test]
fn advice_on_innovations_sets_the_noise_that_explains_them() {
    let (session, mut snapshot) = flown();
    change_channels(&mut snapshot, |channel| {
        (channel.deviation_ratio, channel.mean) = (1.5, 0.0);
        (channel.autocorrelation[0], channel.is_white) = (0.0, true);
    });
    let advice = verdict::findings(&session, &snapshot).into_iter().filter(|one| one.code == "innovation-advice");
    let fixes: Vec<Fix> = advice.filter_map(|finding| finding.fix).collect();
    assert!(!fixes.is_empty());
    for fix in fixes {
        let fixed = fix.apply(&session).unwrap();
        let before = session.filter.measurement_noise.iter().zip(&fixed.filter.measurement_noise);
        let factors: Vec<f64> =
            before.map(|(before, after)| after / before).filter(|factor| (factor - 1.0).abs() > 1e-9).collect();
        // R + (1.5^2 - 1) S with S at least R.
        assert!(matches!(factors[..], [factor] if factor >= 1.49), "{}: {factors:?}", fix.label);
    }
}

#[test]
fn noise_of_a_vane_that_is_far_too_high_is_one_hint_whose_fix_is_bounded_by_the_innovations() {
    let (session, mut snapshot) = flown();
    let alpha = "filter.measurement_noise.alpha";
    let hints = |session: &Session, snapshot: &Snapshot| -> Vec<Finding> {
        let all = verdict::findings(session, snapshot).into_iter().filter(|one| one.code == "innovation-advice");
        all.filter(|one| one.setting.as_deref() == Some(alpha) && one.place == Place::from("session")).collect()
    };
    assert!(hints(&session, &snapshot).is_empty(), "the noise is right");
    change_channels(&mut snapshot, |channel| {
        if channel.measurement == Measurement::AngleOfAttack {
            (channel.deviation_ratio, channel.mean) = (0.1, 0.0);
        }
    });
    let found = hints(&session, &snapshot);
    let [hint] = &found[..] else { panic!("{found:?}") };
    assert_eq!((hint.level, hint.figure), (Level::Good, Some(0.1)));
    let others = verdict::findings(&session, &snapshot);
    let others = others.iter().filter(|one| one.code == "innovation-advice" && one.setting.as_deref() == Some(alpha));
    assert_eq!(others.count(), 1, "said once");
    let fixed = hint.fix.as_ref().expect("it has a fix").apply(&session).unwrap();
    let index = Measurement::AngleOfAttack as usize;
    let factor = fixed.filter.measurement_noise[index] / session.filter.measurement_noise[index];
    // A tenth of the predicted deviation, which is that of the noise or more.
    assert!((0.01..0.67).contains(&factor), "{factor}");
}

#[test]
fn collinear_and_undetermined_terms_are_removed_the_worst_first() {
    let (session, mut sound) = flown();
    let part = |fit: &mut CoefficientFit, part: f64| {
        fit.corrected_errors = fit.fit.as_ref().unwrap().estimates.iter().map(|value| part * value.abs()).collect();
    };
    change_cm(&mut sound, |fit| part(fit, 0.1));
    let open = |of_rate: f64, of_alpha: f64| {
        let mut snapshot = sound.clone();
        change_cm(&mut snapshot, |fit| {
            for (name, part) in [("Cm_q", of_rate), ("Cm_alpha", of_alpha)] {
                let index = index_of(fit, name);
                fit.corrected_errors[index] = part * fit.fit.as_ref().unwrap().estimates[index].abs();
            }
        });
        snapshot
    };
    for (of_rate, of_alpha, removed) in [(0.6, 0.1, "Cm_q"), (0.6, 0.8, "Cm_alpha"), (0.9, 0.8, "Cm_q")] {
        let all = found(&session, &open(of_rate, of_alpha), "determined");
        let fixes: Vec<&Finding> = all
            .iter()
            .filter(|one| one.place.pooled().is_some_and(|name| name.starts_with("Cm_")) && one.fix.is_some())
            .collect();
        assert!(
            !fixes.is_empty()
                && fixes.iter().all(|one| one.place.pooled().is_some_and(|name| name.starts_with(removed))),
            "{removed}: {all:?}"
        );
        let fixed = fixes[0].fix.as_ref().unwrap().apply(&session).unwrap();
        let kept: Vec<String> = terms_of_cm(&session).into_iter().filter(|name| name != removed).collect();
        assert_eq!(terms_of_cm(&fixed), kept);
    }
    let mut snapshot = sound;
    change_cm(&mut snapshot, |fit| {
        part(fit, 0.6);
        let estimate = fit.fit.as_mut().unwrap();
        estimate.condition_number = 150.0;
        estimate.unit_covariance *= 1e4;
    });
    let fix = |code| {
        let all = found(&session, &snapshot, code);
        let of_cm = all.into_iter().find(|finding| finding.place.pooled() == Some("Cm")).unwrap();
        of_cm.fix.unwrap()
    };
    assert_eq!(fix("condition"), fix("vif"));
    assert_eq!(terms_of_cm(&fix("condition").apply(&session).unwrap()).len() + 1, terms_of_cm(&session).len());
}

#[test]
fn dependent_terms_and_a_coefficient_with_no_excited_term_are_removed() {
    let (session, sound) = flown();
    let mut snapshot = sound.clone();
    let dependent = vec![Dependence { name: "Cm_q".to_owned(), on: vec!["Cm_alpha".to_owned()] }];
    change_cm(&mut snapshot, |fit| {
        let error = EstimateError::RankDeficient { rank: 3, parameters: 4, dependent };
        fit.fit = Err(StageError::Estimate(error));
    });
    let fixed = fix_of(&session, &snapshot, "rank").apply(&session).unwrap();
    let kept: Vec<String> = terms_of_cm(&session).into_iter().filter(|name| name != "Cm_q").collect();
    assert_eq!(terms_of_cm(&fixed), kept);
    let mut resting = session.clone();
    resting.structure.models.iter_mut().filter(|(one, _)| *one == Coefficient::Cm).for_each(|(_, terms)| {
        terms.retain(Term::is_constant);
    });
    let found = found(&resting, &sound, "excitation");
    let of_cm = found.iter().find(|finding| finding.place.pooled() == Some("Cm")).unwrap();
    let fixed = of_cm.fix.as_ref().unwrap().apply(&resting).unwrap();
    assert!(fixed.structure.terms(Coefficient::Cm).is_none());
}

#[test]
fn derivative_of_a_control_with_the_wrong_sign_leads_to_its_reversed_channel() {
    let (mut session, mut snapshot) = flown();
    let range = PlausibleRange { low: -4.0, high: -0.1, sign_certain: true };
    session.plausible.insert("Cm_delta_e".to_owned(), range);
    // Channels that agree with the stated sign would speak against it.
    snapshot.physics.clear();
    change_cm(&mut snapshot, |fit| {
        let index = index_of(fit, "Cm_delta_e");
        fit.fit.as_mut().unwrap().estimates[index] = 1.0;
        fit.corrected_errors[index] = 0.01;
    });
    // The other derivatives of the elevator are as bad, those of the motion are not.
    let places: Vec<Place> = found(&session, &snapshot, "plausible").into_iter().map(|finding| finding.place).collect();
    assert!(places.contains(&Place::derivative("CZ_delta_e", None)), "{places:?}");
    let of_alpha = |place: &Place| place.pooled().is_some_and(|name| name.starts_with("CZ_alpha"));
    assert!(!places.iter().any(of_alpha), "{places:?}");
    let fixed = fix_of(&session, &snapshot, "plausible").apply(&session).unwrap();
    let [expression] = &fixed.flights[0].expressions[..] else { panic!("{:?}", fixed.flights[0].expressions) };
    assert_eq!((expression.role, expression.expression.as_str()), (Some(Role::Elevator), "-delta_e"));
}

#[test]
fn control_between_two_samples_leads_to_recorded_angular_accelerations_where_there_are_some() {
    let (session, mut snapshot) = flown();
    let apart_s = 0.2;
    changed(snapshot.flights.values_mut().next().unwrap(), |flight| {
        let channel = &mut flight.recording.channels[flight.recording.roles[&Role::Elevator]];
        let time_s: Arc<[f64]> = (0..25_000).map(|k| apart_s * f64::from(k)).collect();
        let values = time_s.iter().map(|t| 0.05 * (0.5 * t).floor().rem_euclid(2.0)).collect();
        channel.series = Series { time_s, values };
    });
    assert!(found(&session, &snapshot, "sampling").iter().all(|finding| finding.fix.is_none()));
    for role in [Role::RollAcceleration, Role::PitchAcceleration, Role::YawAcceleration] {
        add_channel(&mut snapshot, role, Series { time_s: [0.0, 5000.0].into(), values: [0.0, 0.0].into() });
    }
    let fixed = fix_of(&session, &snapshot, "sampling").apply(&session).unwrap();
    assert_eq!(fixed.preparation.angular_acceleration, AngularAcceleration::Recorded);
}

#[test]
fn offset_of_the_sideslip_is_added_to_its_channel() {
    let (session, mut snapshot) = flown();
    // The constants that 4 deg of the vane give; -C_0 / C_beta alike in CY and Cn.
    let offset = 4.0_f64.to_radians();
    changed(&mut snapshot.pooled, |fits| {
        for fit in &mut fits.fits {
            let slope = Term::product([(Variable::Beta, 1)]).derivative_name(fit.coefficient);
            let constant = Term::product([]).derivative_name(fit.coefficient);
            let Ok(estimate) = &mut fit.fit else { continue };
            let Some((slope, _)) = estimate.parameter(&slope) else { continue };
            let is_constant = |name: &String| *name == constant || name.starts_with(&format!("{constant}["));
            for (name, value) in estimate.names.iter().zip(&mut estimate.estimates) {
                if is_constant(name) {
                    *value = -slope * offset;
                }
            }
        }
    });
    let finding = verdict::findings(&session, &snapshot).into_iter().find(|one| one.code == "sideslip-offset").unwrap();
    assert!((finding.figure.unwrap() - offset).abs() < 1e-9);
    let fixed = finding.fix.unwrap().apply(&session).unwrap();
    let [expression] = &fixed.flights[0].expressions[..] else { panic!("{:?}", fixed.flights[0].expressions) };
    assert_eq!((expression.role, expression.expression.as_str()), (Some(Role::Sideslip), "beta - 0.06981"));
}

#[test]
fn intervals_without_length_are_turned_or_removed() {
    let (mut session, _) = flown();
    let TimeRange { start_s, end_s } = session.windows[0].window;
    let empty = TimeRange { start_s: start_s + 2.0, end_s: start_s + 1.0 };
    let usable = TimeRange { start_s: start_s + 3.0, end_s: start_s + 4.0 };
    let right = session.windows[0].clone();
    session.windows[0].window = TimeRange { start_s: end_s, end_s: start_s };
    session.windows[0].excluded = vec![empty, usable];
    let of_windows = |session: &Session| -> Vec<Finding> {
        session::check(session).into_iter().filter(|finding| finding.code == "window").collect()
    };
    let fixes: Vec<Fix> = of_windows(&session).into_iter().filter_map(|finding| finding.fix).collect();
    assert_eq!(fixes.len(), 2);
    let fixed = fixes.iter().fold(session.clone(), |session, fix| fix.apply(&session).unwrap());
    assert_eq!(fixed.windows[0], session::Manoeuvre { excluded: vec![usable], ..right });
    assert_eq!(of_windows(&fixed), []);
}

#[test]
fn manoeuvre_beyond_the_recording_is_shortened_to_it() {
    let mut recording = Recording::default();
    recording.roles.insert(Role::RollRate, 0);
    let (source, name, unit) = (String::new(), "p".to_owned(), "rad/s".to_owned());
    let series = Series { time_s: [10.0, 15.0, 20.0].into(), values: [0.0, 0.0, 0.0].into() };
    recording.channels.push(Channel { source, name, unit, series });
    let range = |start_s, end_s| TimeRange { start_s, end_s };
    let inside = |window| stage::partly_outside(&recording, window).map(|(_, inside)| inside);
    assert_eq!(inside(range(12.0, 25.0)), Some(range(12.0, 20.0)));
    assert_eq!(inside(range(5.0, 15.0)), Some(range(10.0, 15.0)));
    assert_eq!(inside(range(12.0, 20.3)), None);
    let edit = WindowEdit::Place { name: "m".to_owned(), window: range(10.0, 15.0) };
    assert!(Fix::new("shorten", Edit::Window(edit)).is_of_configuration());
}

#[test]
fn findings_on_the_innovations_of_a_measurement_give_one_action() {
    let (session, mut snapshot) = flown();
    let actions = |snapshot: &Snapshot| {
        let found = verdict::findings(&session, snapshot).into_iter().filter(|one| one.code == "innovation-advice");
        let alpha = found.filter(|one| one.setting.as_deref() == Some("filter.measurement_noise.alpha"));
        alpha.map(|one| (one.fix_text, one.fix.map(|fix| fix.label))).collect::<Vec<_>>()
    };
    // Some manoeuvres ask for less noise, in others the innovations are correlated.
    let count = std::cell::Cell::new(0);
    change_channels(&mut snapshot, |channel| {
        if channel.measurement == Measurement::AngleOfAttack {
            count.set(count.get() + 1);
            channel.mean = 0.0;
            (channel.deviation_ratio, channel.is_white) = if count.get() % 3 == 0 { (1.6, false) } else { (1.5, true) };
            channel.autocorrelation[0] = if count.get() % 3 == 0 { 0.8 } else { 0.0 };
        }
    });
    let found = actions(&snapshot);
    assert!(!found.is_empty());
    assert!(found.iter().all(|one| *one == found[0]), "{found:?}");
    let (text, fix) = &found[0];
    assert!(text.ends_with("(all manoeuvres)."), "{text}");
    assert!(fix.as_ref().is_some_and(|label| label.ends_with("(all manoeuvres)")), "{fix:?}");
    // Correlated in all of them: one action, and nothing to apply.
    change_channels(&mut snapshot, |channel| {
        if channel.measurement == Measurement::AngleOfAttack {
            (channel.deviation_ratio, channel.is_white, channel.autocorrelation[0]) = (1.6, false, 0.8);
        }
    });
    let found = actions(&snapshot);
    assert!(found.iter().all(|one| *one == found[0] && one.1.is_none()), "{found:?}");
    assert_eq!(found[0].0, "Check for a delay, a filter in the sensor or too little process noise.");
}

#[test]
fn results_advise_on_noise_as_the_panels_do() {
    let (session, snapshot) = flown();
    let results = doublet_engine::report::build(&session, &snapshot);
    let mut seen = 0;
    for row in &results.windows {
        let window = session.window(&row.name).expect("it is in the session");
        let path = snapshot.windows[&row.name].path.ready().expect("it has a path");
        let noise = snapshot.noise.get(&window.flight).and_then(|slot| slot.ready());
        let advice = stage::noise_advice(path, &session.filter.measurement_noise, noise.map(|noise| &**noise));
        for row in &row.innovations {
            let advice = advice.iter().find(|one| one.measurement.name() == row.measurement).expect("it is advised");
            let step = row.advice.split([' ', ':']).next();
            let expected = match advice.step {
                stage::NoiseStep::Keep if advice.action.is_empty() => "Consistent",
                stage::NoiseStep::Set => "Set",
                _ => "Innovations",
            };
            let is_offset = row.advice.starts_with("Mean innovation");
            assert!(step == Some(expected) || is_offset, "{}: {:?}", row.advice, advice.step);
            seen += 1;
        }
    }
    assert!(seen > 5);
}
