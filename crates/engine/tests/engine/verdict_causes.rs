//! The verdict names what is wrong with recordings and aircraft of others: late controls, figures in other units, channels that others
//! contradict; and a fit is not called better than what it is made of.

#![allow(clippy::unwrap_used, clippy::print_stdout, reason = "helpers of tests are not marked as tests")]

use std::collections::BTreeMap;
use std::path::Path;

use doublet_core::model::{Coefficient, Lag, is_constant_name};
use doublet_core::prep::first_order_lag;
use doublet_core::quantity::Role;
use doublet_core::reconstruct::consistency::Consistency;
use doublet_core::series::{Recording, Series};
use doublet_core::simulate::scenario;
use doublet_engine::graph::Context;
use doublet_engine::run::{Slot, Snapshot};
use doublet_engine::session::{self, GustSource, Place, Session, Surface};
use doublet_engine::stage::{LoadedAircraft, WindowPath};
use doublet_engine::verdict::{self, Finding, Level, Verdicts, fly_and_judge, judge};

/// The content of a slot, changed.
pub fn changed<T: Clone>(slot: &mut Slot<T>, change: impl FnOnce(&mut T)) {
    let mut content = T::clone(slot.ready().unwrap());
    change(&mut content);
    *slot = content.into();
}

/// Consistency of a path, to be changed.
pub fn consistency(path: &mut WindowPath) -> &mut Consistency {
    path.assessment();
    path.assessment.get_mut().unwrap().consistency.as_mut().unwrap()
}

/// The manoeuvres of a test point of the shipped flight with a recording that `spoil` changed, and a session that `change` did.
fn flown(spoil: &(dyn Fn(&mut Recording) + Sync), change: impl Fn(&mut Session)) -> (Session, Snapshot) {
    let mut session = session::parse(doublet_engine::builtin::session("demo").unwrap()).unwrap();
    change(&mut session);
    let scenario = scenario::build("test-point").unwrap();
    fly_and_judge(&session, &scenario, 1, spoil, &Context::new(Path::new("."))).unwrap()
}

fn reasons<'a>(verdicts: &'a Verdicts, code: &str) -> Vec<&'a Finding> {
    verdicts.session.reasons.iter().filter(|reason| reason.code == code).collect()
}

fn level(verdicts: &Verdicts, coefficient: Coefficient) -> Level {
    verdicts.fit(None, coefficient).unwrap().verdict.level
}

fn has(verdicts: &Verdicts, coefficient: Coefficient, code: &str) -> bool {
    verdicts.fit(None, coefficient).unwrap().verdict.reasons.iter().any(|reason| reason.code == code)
}

/// The recording with the stamps of a role later by a time.
fn later(recording: &mut Recording, role: Role, by_s: f64) {
    let channel = &mut recording.channels[recording.roles[&role]];
    let time_s = channel.series.time_s.iter().map(|time_s| time_s + by_s).collect();
    channel.series = Series { time_s, values: channel.series.values.clone() };
}

/// The recording with an offset of a role.
fn shift(recording: &mut Recording, role: Role, offset: f64) {
    let channel = &mut recording.channels[recording.roles[&role]];
    let values = channel.series.values.iter().map(|value| value + offset).collect();
    channel.series = Series { time_s: channel.series.time_s.clone(), values };
}

#[test]
fn late_control_is_told_with_its_delay_and_the_delay_cures_it() {
    for (surface, role, coefficient) in [
        (Surface::Elevator, Role::Elevator, Coefficient::Cm),
        (Surface::Aileron, Role::Aileron, Coefficient::Cl),
        (Surface::Rudder, Role::Rudder, Coefficient::Cn),
    ] {
        let late = |recording: &mut Recording| later(recording, role, 0.12);
        let (_, snapshot) = flown(&late, |_| ());
        let verdicts = snapshot.verdicts.ready().unwrap();
        let found = reasons(verdicts, "timing");
        println!("{found:?}");
        // Said of the moment, and of the other coefficients the control moves where their derivatives change by as much.
        assert!((1..=3).contains(&found.len()), "{surface:?}");
        let bad = found.iter().filter(|finding| finding.level == Level::Bad);
        assert!(bad.count() <= 2, "{surface:?}: only the moment and the force it moves");
        let delay_s = found[0].figure.unwrap();
        assert!((delay_s + 0.12).abs() < 0.02, "{surface:?}: {delay_s}");
        assert!(found.iter().all(|found| found.place.is_named(surface.name()) && found.figure == Some(delay_s)));
        assert!(level(verdicts, coefficient) >= Level::Caution);

        let (_, snapshot) = flown(&late, |session| {
            let lag = Lag { delay_s, ..Lag::default() };
            session.preparation.control_lags = session.preparation.control_lags.with(surface, lag);
        });
        let verdicts = snapshot.verdicts.ready().unwrap();
        assert_eq!(reasons(verdicts, "timing").len(), 0, "{surface:?}");
        assert_eq!(level(verdicts, coefficient), Level::Good, "{:?}", verdicts.fit(None, coefficient));
    }
}

/// The vanes record 5 samples a second; the ground velocity shows that the specific forces are late.
#[test]
fn accelerometers_behind_a_filter_are_named_where_only_the_ground_velocity_shows_it() {
    const FORCES: [Role; 3] = [Role::SpecificForceX, Role::SpecificForceY, Role::SpecificForceZ];
    let filter = |recording: &mut Recording| {
        for role in FORCES {
            let channel = &mut recording.channels[recording.roles[&role]];
            let Series { time_s, values } = &channel.series;
            let values = first_order_lag(time_s, values, 0.053).unwrap().into();
            channel.series = Series { time_s: time_s.clone(), values };
        }
    };
    let session = session::parse(doublet_engine::builtin::session("demo").unwrap()).unwrap();
    let session = Session { gusts: GustSource::Estimated, ..session };
    let scenario = scenario::build("coverage").unwrap();
    for (spoil, expected) in [(&filter as &(dyn Fn(&mut Recording) + Sync), 3), (&|_| (), 0)] {
        let (_, snapshot) = fly_and_judge(&session, &scenario, 1, spoil, &Context::new(Path::new("."))).unwrap();
        let verdicts = snapshot.verdicts.ready().unwrap();
        let fits = [Coefficient::CX, Coefficient::CY, Coefficient::CZ].map(|force| verdicts.fit(None, force).unwrap());
        let named =
            fits.iter().flat_map(|fit| &fit.verdict.reasons).filter(|reason| reason.place.is_named("accelerometers"));
        assert_eq!(named.filter(|reason| reason.code == "timing").count(), expected);
    }
}

#[test]
fn control_on_its_clock_has_no_delay() {
    let (_, snapshot) = flown(&|_| (), |_| ());
    assert_eq!(reasons(snapshot.verdicts.ready().unwrap(), "timing").len(), 0);
}

/// A bad flight path makes a fit bad where the path as measured gives other derivatives, and is a caution of the session alone where not.
#[test]
fn bad_flight_path_counts_by_what_it_changes_of_the_derivatives() {
    let (session, mut snapshot) = flown(&|_| (), |_| ());
    assert_eq!(level(&judge(&session, &snapshot), Coefficient::Cm), Level::Good);
    let of_elevator = session.windows.iter().filter(|window| window.surface == Some(Surface::Elevator));
    let of_elevator: Vec<&str> = of_elevator.map(|window| window.name.as_str()).collect();
    for name in &of_elevator {
        changed(&mut snapshot.windows.get_mut(*name).unwrap().path, |path| {
            let found = consistency(path);
            (found.nis_mean, found.nis_ratio) = (4.0 * found.nis_mean / found.nis_ratio, 4.0);
        });
    }
    let verdicts = judge(&session, &snapshot);
    assert_eq!(reasons(&verdicts, "nis").len(), of_elevator.len());
    assert_eq!((verdicts.session.level, level(&verdicts, Coefficient::Cm)), (Level::Caution, Level::Good));

    // The pooled estimate of a path that has the angle of attack too small by a third.
    changed(&mut snapshot.pooled, |pooled| {
        let fit = pooled.fits.iter_mut().find(|fit| fit.coefficient == Coefficient::Cm).unwrap();
        let fit = fit.fit.as_mut().unwrap();
        let index = fit.names.iter().position(|name| name == "Cm_alpha").unwrap();
        fit.estimates[index] *= 1.5;
    });
    let verdicts = judge(&session, &snapshot);
    assert_eq!(level(&verdicts, Coefficient::Cm), Level::Bad);
    assert!(has(&verdicts, Coefficient::Cm, "path") && !has(&verdicts, Coefficient::Cl, "path"));
}

#[test]
fn channel_that_others_contradict_makes_the_fits_bad_whose_derivatives_it_changes() {
    let turn = |recording: &mut Recording| {
        let channel = &mut recording.channels[recording.roles[&Role::PitchRate]];
        let values = channel.series.values.iter().map(|value| -value).collect();
        channel.series = Series { time_s: channel.series.time_s.clone(), values };
    };
    let (_, snapshot) = flown(&turn, |_| ());
    let verdicts = snapshot.verdicts.ready().unwrap();
    assert_eq!(verdicts.session.level, Level::Bad);
    for coefficient in [Coefficient::CX, Coefficient::CZ, Coefficient::Cm] {
        assert!(has(verdicts, coefficient, "physics"), "{}", coefficient.name());
        assert_eq!(level(verdicts, coefficient), Level::Bad);
    }
}

#[test]
fn aircraft_in_other_units_is_told_and_no_fit_with_it_is_good() {
    let (session, snapshot) = flown(&|_| (), |_| ());
    let with = |change: fn(&mut LoadedAircraft)| {
        let mut snapshot = snapshot.clone();
        changed(&mut snapshot.aircraft, change);
        judge(&session, &snapshot)
    };
    assert_eq!(reasons(&with(|_| ()), "aircraft").len(), 0);
    let area = with(|loaded| loaded.aircraft.reference.area_m2 *= 10.764);
    let chord = with(|loaded| loaded.aircraft.reference.chord_m *= 3.2808);
    for (name, verdicts) in [("area", area), ("chord", chord)] {
        let found = reasons(&verdicts, "aircraft");
        println!("{name}: {found:?}");
        assert_eq!((found.len(), found[0].level), (1, Level::Bad), "{name}");
        assert!(verdicts.pooled.iter().all(|fit| fit.verdict.level == Level::Bad), "{name}");
    }
}

#[test]
fn speeds_in_knots_that_agree_with_each_other_are_told_by_the_climb() {
    let in_knots = |recording: &mut Recording| {
        for role in [Role::TrueAirspeed, Role::VelocityNorth, Role::VelocityEast] {
            let Some(index) = recording.roles.get(&role) else { continue };
            let series = &mut recording.channels[*index].series;
            let values = series.values.iter().map(|value| value / 0.514_444).collect();
            *series = Series { time_s: series.time_s.clone(), values };
        }
    };
    let (_, snapshot) = flown(&in_knots, |_| ());
    let rows = snapshot.physics.values().flat_map(|slot| slot.ready().unwrap().contradictions());
    let headlines: Vec<String> = rows.map(|row| row.headline.to_string()).collect();
    assert!(headlines.iter().any(|line| line.starts_with("airspeed: knots")), "{headlines:?}");
}

#[test]
fn sideslip_offset_is_found_by_the_constants_and_changes_no_derivative() {
    let found = |offset_rad: f64| {
        let (session, snapshot) = flown(&|recording| shift(recording, Role::Sideslip, offset_rad), |_| ());
        let found =
            verdict::findings(&session, &snapshot).into_iter().find(|finding| finding.code == "sideslip-offset");
        let fit = &snapshot.pooled.ready().unwrap().fits[Coefficient::Cn as usize];
        (found, fit.fit.as_ref().unwrap().parameter("Cn_beta").unwrap().0)
    };
    // The constants of this aircraft in CY and Cn are those of 0.1 and 1.4 deg: at 2 deg of the vane the two do not agree.
    let (_, stability) = found(0.0);
    assert_eq!(found(2.0_f64.to_radians()).0, None);
    for offset_deg in [-6.0_f64, 6.0] {
        let (finding, with_offset) = found(offset_deg.to_radians());
        let finding = finding.unwrap();
        println!("{finding:?}");
        assert_eq!(finding.level, Level::Good);
        assert!((finding.figure.unwrap().to_degrees() - offset_deg).abs() < 1.0, "{finding:?}");
        assert!((with_offset / stability - 1.0).abs() < 0.02, "{with_offset} {stability}");
    }
}

/// The samples of a role, changed by their time and value.
fn map_samples(recording: &mut Recording, role: Role, change: impl Fn(f64, f64) -> f64) {
    let series = &mut recording.channels[recording.roles[&role]].series;
    let values =
        series.time_s.iter().zip(series.values.iter()).map(|(time_s, value)| change(*time_s, *value)).collect();
    *series = Series { time_s: series.time_s.clone(), values };
}

/// The gyroscope of `role` at the ends of its range, at this part of its largest rates.
fn saturate(recording: &mut Recording, role: Role, part: f64) {
    let values = &recording.channels[recording.roles[&role]].series.values;
    let (low, high) = values.iter().fold((0.0_f64, 0.0_f64), |(low, high), value| (low.min(*value), high.max(*value)));
    map_samples(recording, role, |_, value| value.clamp(part * low, part * high));
}

/// Pooled estimates of a coefficient, by name.
fn estimates(snapshot: &Snapshot, coefficient: Coefficient) -> Vec<(String, f64)> {
    let fit = &snapshot.pooled.ready().unwrap().fits[coefficient as usize];
    let fit = fit.fit.as_ref().unwrap();
    fit.names.iter().cloned().zip(fit.estimates.iter().copied()).collect()
}

/// Saturated in every manoeuvre that moves the axis: no other manoeuvre shows what that changes, and the samples that are left do.
#[test]
fn saturated_gyroscope_in_all_manoeuvres_leaves_no_wrong_derivative_good() {
    let (_, sound) = flown(&|_| (), |_| ());
    let part = 0.35;
    let (session, snapshot) = flown(
        &|recording| [Role::RollRate, Role::PitchRate].into_iter().for_each(|role| saturate(recording, role, part)),
        |_| (),
    );
    let verdicts = snapshot.verdicts.ready().unwrap();
    assert!(!reasons(verdicts, "saturated").is_empty());
    let mut wrong = 0;
    for coefficient in [Coefficient::Cl, Coefficient::Cm] {
        let fit = verdicts.fit(None, coefficient).unwrap();
        println!("{} {:?}", coefficient.name(), fit.verdict);
        assert!(fit.verdict.level >= Level::Caution);
        for ((name, now), (_, was)) in estimates(&snapshot, coefficient).iter().zip(estimates(&sound, coefficient)) {
            let level = fit.derivative(name).unwrap().level.max(fit.verdict.level);
            let share = fit.consequence(name).map_or(0.0, |found| found.share);
            println!("{name}: {was:.4} becomes {now:.4}, share {share:.2}, {}", level.name());
            if share > 0.1 && (now / was - 1.0).abs() > 0.3 {
                wrong += 1;
                assert_eq!(level, Level::Bad, "{name}");
            }
        }
    }
    assert!(wrong > 0);
    // What is offered leaves no saturated sample.
    let fixes: Vec<_> = reasons(verdicts, "saturated").iter().filter_map(|found| found.fix.clone()).collect();
    let fixed = fixes.iter().fold(session, |session, fix| fix.apply(&session).unwrap());
    assert!(fixed.windows.iter().any(|window| !window.excluded.is_empty()));
    let verdicts = judge(&fixed, &snapshot);
    let saturated =
        |finding: &&Finding| finding.code == "saturated" && matches!(finding.place, Place::Manoeuvre { .. });
    let left = verdicts.windows.values().flat_map(|window| &window.verdict.reasons).filter(saturated);
    assert_eq!(left.count(), 0);
}

#[test]
fn stalls_of_the_recorder_are_told_and_no_delay_is_proposed_for_them() {
    let (session, _) = flown(&|_| (), |_| ());
    // Inside the motion that follows the input.
    let starts_s: Vec<f64> = session.windows.iter().map(|window| window.window.start_s + 3.2).collect();
    let hold = |recording: &mut Recording| {
        let roles: Vec<Role> = recording.roles.keys().copied().collect();
        for role in roles {
            let series = recording.channels[recording.roles[&role]].series.clone();
            map_samples(recording, role, |time_s, value| {
                let Some(start_s) = starts_s.iter().find(|start_s| (**start_s..**start_s + 0.4).contains(&time_s))
                else {
                    return value;
                };
                series.values[series.time_s.partition_point(|time_s| time_s < start_s)]
            });
        }
    };
    let (session, snapshot) = flown(&hold, |_| ());
    let verdicts = snapshot.verdicts.ready().unwrap();
    verdicts.session.reasons.iter().for_each(|reason| println!("{} {}: {reason}", reason.level.name(), reason.code));
    let of_windows: Vec<&Finding> = verdicts.windows.values().flat_map(|window| &window.verdict.reasons).collect();
    let stalls: Vec<&&Finding> =
        of_windows.iter().filter(|finding| finding.text.to_string().starts_with("Recording stalls")).collect();
    assert_eq!(stalls.len(), session.windows.len(), "{stalls:?}");
    assert!(stalls.iter().all(|stall| (stall.figure.unwrap() - 0.4).abs() < 0.05 && stall.fix.is_some()));
    assert_eq!(reasons(verdicts, "timing").len(), 0);
    assert!(of_windows.iter().all(|finding| !finding.fix_text.contains("delay")), "{of_windows:?}");
}

#[test]
fn flow_angles_without_vanes_are_said_to_have_none() {
    let without = |recording: &mut Recording| {
        [Role::AngleOfAttack, Role::Sideslip].iter().for_each(|role| {
            recording.roles.remove(role);
        });
    };
    let (_, snapshot) = flown(&without, |_| ());
    let verdicts = snapshot.verdicts.ready().unwrap();
    let of_angles = reasons(verdicts, "vane");
    assert!(!of_angles.is_empty());
    assert!(
        of_angles.iter().all(|found| found.text.to_string().starts_with("No vane recorded") && found.fix.is_none())
    );
    let fit =
        verdicts.pooled.iter().find(|fit| fit.verdict.reasons.iter().any(|reason| reason.code == "vane")).unwrap();
    let mut derivatives = fit.derivatives.iter().filter(|derivative| !is_constant_name(&derivative.name));
    assert!(derivatives.all(|derivative| derivative.verdict.level >= Level::Caution), "{fit:?}");
}

/// An airspeed that is too small changes every derivative with the dynamic pressure: what stays good contains the change in its error.
#[test]
fn no_derivative_is_good_that_a_wrong_airspeed_changes_beyond_its_error() {
    let small = |recording: &mut Recording| {
        let channel = &mut recording.channels[recording.roles[&Role::TrueAirspeed]];
        let values = channel.series.values.iter().map(|value| 0.8 * value).collect();
        channel.series = Series { time_s: channel.series.time_s.clone(), values };
    };
    let good = |spoil: &(dyn Fn(&mut Recording) + Sync)| -> BTreeMap<String, (f64, f64)> {
        let (_, snapshot) = flown(spoil, |_| ());
        let verdicts = snapshot.verdicts.ready().unwrap();
        let derivatives = verdicts.pooled.iter().flat_map(|fit| &fit.derivatives);
        let is_good = |name: &str| derivatives.clone().any(|one| one.name == name && one.verdict.level == Level::Good);
        let fits = &snapshot.pooled.ready().unwrap().fits;
        let fits = fits.iter().filter_map(|fit| Some((fit.fit.as_ref().ok()?, &fit.corrected_errors)));
        let rows = fits.flat_map(|(fit, errors)| fit.names.iter().zip(fit.estimates.iter().zip(errors)));
        let rows = rows.filter(|(name, _)| !is_constant_name(name) && is_good(name));
        rows.map(|(name, (estimate, error))| (name.clone(), (*estimate, *error))).collect()
    };
    let (sound, wrong) = (good(&|_| ()), good(&small));
    assert!(sound.len() > 8 && wrong.len() < sound.len() / 2, "{sound:?} {wrong:?}");
    for (name, (estimate, error)) in &wrong {
        let right = sound.get(name).map_or(f64::NAN, |(estimate, _)| *estimate);
        assert!(right.is_nan() || (estimate - right).abs() < 3.0 * error, "{name}: {estimate} ± {error}, {right}");
    }
}
