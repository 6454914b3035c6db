//! Delays of the measurements are found from one recording, and none where there is none.

use std::path::Path;

use doublet_core::quantity::Role;
use doublet_core::series::{Recording, Series};
use doublet_core::simulate::scenario;
use doublet_engine::graph::Context;
use doublet_engine::session::{self, GustSource, Session};
use doublet_engine::stage::{ConstantError, SensorDelay};
use doublet_engine::verdict::fly_and_judge;

const GROUND: [Role; 5] =
    [Role::PositionNorth, Role::PositionEast, Role::VelocityNorth, Role::VelocityEast, Role::VelocityDown];
const FLOW: [Role; 2] = [Role::AngleOfAttack, Role::Sideslip];

fn session() -> Session {
    let demo = session::parse(doublet_engine::builtin::session("demo").unwrap()).unwrap();
    Session { gusts: GustSource::Estimated, ..demo }
}

fn late(recording: &mut Recording, roles: &[Role], by_s: f64) {
    for role in roles {
        let Some(&index) = recording.roles.get(role) else { continue };
        let series = &mut recording.channels[index].series;
        let time_s = series.time_s.iter().map(|time| time + by_s).collect();
        *series = Series { time_s, values: series.values.clone() };
    }
}

/// Delays found in a test point whose `roles` are `by_s` late, in gusts of `gust_m_s`.
fn delays(roles: &[Role], by_s: f64, gust_m_s: f64) -> Vec<SensorDelay> {
    let mut scenario = scenario::build("test-point").unwrap();
    scenario.gust_m_s = gust_m_s;
    let spoil = |recording: &mut Recording| late(recording, roles, by_s);
    let (_, snapshot) = fly_and_judge(&session(), &scenario, 1, &spoil, &Context::new(Path::new("."))).unwrap();
    let found = snapshot.delays_and_gusts.delays.unwrap().0;
    println!("{by_s} s, gusts {gust_m_s} m/s: {found:?}");
    found
}

fn of(found: &[SensorDelay], kind: ConstantError) -> &SensorDelay {
    found.iter().find(|delay| delay.kind == kind).unwrap()
}

#[test]
fn late_ground_velocity_is_found_within_ten_milliseconds_in_calm_air_and_gusts() {
    for (by_s, gust_m_s) in [(0.05, 0.0), (0.1, 0.0), (0.3, 0.0), (0.1, 0.7)] {
        let found = delays(&GROUND, by_s, gust_m_s);
        let ground = of(&found, ConstantError::GroundDelay);
        assert!(ground.is_significant() && (ground.delay_s - by_s).abs() < 0.01, "{ground:?}");
        let others = found.iter().filter(|delay| delay.kind != ConstantError::GroundDelay);
        assert!(others.into_iter().all(|delay| !delay.is_significant()), "{found:?}");
    }
}

#[test]
fn late_vanes_are_found_within_ten_milliseconds_in_calm_air_and_gusts() {
    for gust_m_s in [0.0, 0.7, 1.5] {
        let found = delays(&FLOW, 0.04, gust_m_s);
        let flow = of(&found, ConstantError::FlowDelay);
        assert!(flow.is_significant() && (flow.delay_s - 0.04).abs() < 0.01, "gusts {gust_m_s} m/s: {flow:?}");
    }
}

#[test]
fn punctual_sensors_have_no_delay() {
    for gust_m_s in [0.0, 0.7] {
        let found = delays(&[], 0.0, gust_m_s);
        assert!(found.iter().all(|delay| !delay.is_significant()), "{found:?}");
    }
}
