//! Roles that no recorder gives: deflections from sensors on the controls, flow angles from the pod, fuel from its probes.

use std::collections::BTreeMap;
use std::sync::Arc;

use doublet_core::airframe::instruments::{
    AirDataCalibration, ControlLinkage, Instruments, PodCalibration, StatedNoise,
};
use doublet_core::atmos::{Atmosphere, STANDARD_GRAVITY_M_S2};
use doublet_core::load::instruments as file;
use doublet_core::message;
use doublet_core::message::Message;
use doublet_core::prep::{
    ColumnFormula, DeflectionSettings, Differentiation, FuelSettings, Interpolation, SensorAttitude, SensorReference,
    aileron_deflection, attitude_turn, deflection_noise, elevator_deflection, fuel_history, integrated_turn,
    integrated_turn_noise, level_flight_angle_of_attack, pod_calibration, pod_history, resample, rudder_deflection,
    rudder_history, sideslip, stretches,
};
use doublet_core::quantity::{Role, Unit};
use doublet_core::series::{Channel, Recording, Series};
use rayon::prelude::*;

use super::align::channel;
use crate::graph::{Context, StageResult};
use crate::keep::hash_bytes;
use crate::session::InstrumentSetting;

/// A pause between samples of a control sensor that ends a stretch, s: it records around each manoeuvre only.
const PAUSE_S: f64 = 0.5;
/// Numbers of the pod this close to an end of its scale tell nothing.
const POD_MARGIN: f64 = 1.0;
/// Sensors of the linkage by what they tell.
const YOKE: &str = "yoke";
const COLUMN: &str = "column";

/// Adds every role the instruments give to a recording on the flight's time line, and returns the SHA-256 of their file with the noise it states. A role the
/// recording has is kept, and said.
pub fn derive(
    recording: &mut Recording,
    context: &Context<'_>,
    setting: &InstrumentSetting,
) -> StageResult<(String, BTreeMap<Role, StatedNoise>)> {
    let content = context.text(&setting.file, "aircraft")?;
    let instruments = file::parse(&content).map_err(|error| format!("{}: {error}", setting.file))?;
    let mut derived = Vec::new();
    let mut warnings = Vec::new();
    if let Some(pattern) = &setting.control_sensors {
        derived.extend(deflections(recording, pattern, setting.thesis_controls, &instruments.control, &mut warnings)?);
    }
    if let Some(pod) = &setting.pod {
        derived.extend(flow_angles(recording, pod, setting, &instruments, &mut warnings)?);
    }
    if !setting.fuel.is_empty() {
        let fuel = fuel(recording, setting, &instruments, &mut warnings)?;
        for (tank, series) in fuel.tanks {
            let (source, unit) = (instruments.name.clone(), Role::FuelMass.dimension().si_symbol().to_owned());
            recording.channels.push(Channel { source, name: tank_channel(&tank), unit, series });
        }
        derived.push((Role::FuelMass, fuel.total));
    }
    for (role, series) in derived {
        if let Some(recorded) = recording.role(role) {
            warnings.push(message!(
                "{} is recorded in {}; the recorded channel is used, not the computed one",
                role.name(),
                &recorded.source
            ));
            continue;
        }
        recording.roles.insert(role, recording.channels.len());
        recording.channels.push(Channel {
            source: instruments.name.clone(),
            name: role.name().to_owned(),
            unit: role.dimension().si_symbol().to_owned(),
            series,
        });
    }
    recording.warnings.extend(warnings);
    Ok((hash_bytes(content.as_bytes()), instruments.noise))
}

/// Samples of a channel in SI, whatever unit it was recorded in.
fn si(channel: &Channel) -> StageResult<Series> {
    let unit = Unit::parse(&channel.unit).map_err(|error| format!("{}: {error}", channel.full_name()))?;
    let values = channel.series.values.iter().map(|&value| unit.to_si(value)).collect();
    Ok(Series { time_s: Arc::clone(&channel.series.time_s), values })
}

/// Attitude of a control sensor on one time base: bank, pitch and heading, or a quaternion.
struct Attitude {
    time_s: Arc<[f64]>,
    columns: Vec<Arc<[f64]>>,
}

/// Names of the columns of an attitude: angles, then quaternions, the scalar part first.
const COLUMNS: [&[&str]; 4] = [
    &["phi", "theta", "psi"],
    &["e0", "ex", "ey", "ez"],
    &["q0", "q1", "q2", "q3"],
    &["Quat_W", "Quat_X", "Quat_Y", "Quat_Z"],
];

impl Attitude {
    fn read(recording: &Recording, source: &str) -> StageResult<Self> {
        let read = |name: &&str| channel(recording, &format!("{source}/{name}"));
        let there = COLUMNS.into_iter().find(|names| names.iter().all(|name| read(name).is_ok()));
        // Without any, the message is that of the angles.
        let names = there.unwrap_or(COLUMNS[0]);
        let is_angle = names.len() == 3;
        let columns = names.iter().map(|name| {
            let channel = read(name)?;
            if is_angle { si(channel) } else { Ok(channel.series.clone()) }
        });
        let columns = columns.collect::<StageResult<Vec<Series>>>()?;
        let time_s = Arc::clone(&columns[0].time_s);
        if columns.iter().any(|column| column.time_s != time_s) {
            return Err(format!("{source}: attitude angles have different time stamps").into());
        }
        Ok(Self { time_s, columns: columns.into_iter().map(|column| column.values).collect() })
    }

    fn borrow(&self) -> SensorAttitude<'_> {
        match &self.columns[..] {
            [e0, ex, ey, ez] => SensorAttitude::Quaternion { e0, ex, ey, ez },
            [phi, theta, psi] => SensorAttitude::Euler { phi, theta, psi },
            _ => SensorAttitude::Euler { phi: &[], theta: &[], psi: &[] },
        }
    }
}

fn deflections(
    recording: &Recording,
    pattern: &str,
    thesis: bool,
    linkage: &ControlLinkage,
    warnings: &mut Vec<Message>,
) -> StageResult<Vec<(Role, Series)>> {
    let source = |sensor: &str| pattern.replace('*', sensor);
    let panel = Attitude::read(recording, &source(&linkage.reference_sensor))?;
    let turn = |sensor: &str| turn(&Attitude::read(recording, &source(sensor))?, &panel, linkage, sensor, thesis);
    let map = |turn: &Series, deflect: &dyn Fn(f64) -> f64| Series {
        time_s: Arc::clone(&turn.time_s),
        values: turn.values.iter().map(|&angle| deflect(angle)).collect(),
    };
    let pedal = linkage.pedals.first();
    let sensors: Vec<&str> = [YOKE, COLUMN].into_iter().chain(pedal.map(|pedal| pedal.sensor.as_str())).collect();
    let turns: Vec<StageResult<Series>> = sensors.into_par_iter().map(turn).collect();
    let turns = turns.into_iter().collect::<StageResult<Vec<Series>>>()?;
    let [yoke, column, turned @ ..] = &turns[..] else { return Ok(Vec::new()) };
    let formula = if thesis { ColumnFormula::Thesis } else { ColumnFormula::Exact };
    let settings = DeflectionSettings { column: formula, ..DeflectionSettings::default() };
    let [_, _, heading] = linkage.attitude_noise_rad;
    // Two attitudes make a turn; differences and trapezoids telescope to five samples of one (Eq. 4.6-4.7 and D.3).
    let noise_rad = match thesis {
        true => integrated_turn_noise([0.0; 3], linkage.attitude_noise_rad),
        false => heading.hypot(heading),
    };
    let of_turn = |deflect: &dyn Fn(f64) -> f64| deflection_noise(deflect, 0.0, noise_rad).to_degrees();
    let mut noise = vec![
        ("aileron", of_turn(&|angle| aileron_deflection(linkage, angle))),
        ("elevator", of_turn(&|angle| elevator_deflection(linkage, angle, settings))),
    ];
    let mut derived = vec![
        (Role::Aileron, map(yoke, &|angle| aileron_deflection(linkage, angle))),
        (Role::Elevator, map(column, &|angle| elevator_deflection(linkage, angle, settings))),
    ];
    if let (Some(pedal), [turned]) = (pedal, turned) {
        let (values, warning) = rudder_history(linkage, pedal, &turned.values);
        warnings.extend(warning);
        noise.push(("rudder", of_turn(&|angle| rudder_deflection(linkage, pedal, angle).0)));
        derived.push((Role::Rudder, Series { time_s: Arc::clone(&turned.time_s), values: values.into() }));
    }
    let stated = Message::join(noise.iter().map(|(surface, deg)| message!("{} {:.3} deg", *surface, *deg)), ", ");
    warnings.push(message!("1-sigma deflection error near neutral: {} (Eq. 4.6-4.7)", stated));
    Ok(derived)
}

/// Turn of a sensor against the one fixed to the aircraft, from its rest; stretch by stretch, since the turn is followed without
/// jumps only inside one.
///
/// As the thesis does it, the turn is the integrated rate about z since the beginning of the stretch, for the yoke alone less that of
/// the aircraft (section 4.1.2).
fn turn(
    sensor: &Attitude,
    panel: &Attitude,
    linkage: &ControlLinkage,
    name: &str,
    thesis: bool,
) -> StageResult<Series> {
    let mount =
        linkage.mount(name).ok_or_else(|| format!("mount of sensor '{name}' not found in the instruments file"))?;
    if sensor.time_s != panel.time_s {
        return Err(format!("sensors '{name}' and '{}' have different time stamps", linkage.reference_sensor).into());
    }
    let mut values = Vec::with_capacity(sensor.time_s.len());
    for range in stretches(&sensor.time_s, PAUSE_S) {
        let (Some(turning), Some(fixed)) =
            (sensor.borrow().within(range.clone()), panel.borrow().within(range.clone()))
        else {
            continue;
        };
        let reference = SensorReference { attitude: fixed, sensor_from_reference: mount.sensor_from_reference };
        let with_sensor_name = |error| format!("sensor '{name}': {error}");
        if thesis {
            let reference = Some(&reference).filter(|_| name == YOKE);
            let own_s = &sensor.time_s[range];
            values.extend(
                integrated_turn(own_s, &turning, reference, Differentiation::Central4).map_err(with_sensor_name)?,
            );
        } else {
            let turned = attitude_turn(&turning, &reference).map_err(with_sensor_name)?;
            values.extend(turned.into_iter().map(|angle| angle - mount.rest_rad));
        }
    }
    Ok(Series { time_s: Arc::clone(&sensor.time_s), values: values.into() })
}

fn flow_angles(
    recording: &Recording,
    pod: &str,
    setting: &InstrumentSetting,
    instruments: &Instruments,
    warnings: &mut Vec<Message>,
) -> StageResult<Vec<(Role, Series)>> {
    let air_data = &instruments.air_data;
    let calibration = &calibration(air_data, setting)?;
    let number = channel(recording, &format!("{pod}/AOA"))?;
    let history = pod_history(calibration, &number.series.values, POD_MARGIN);
    warnings.extend(history.warnings.into_iter().map(|warning| message!("angle of attack: {}", warning)));
    let alpha = Series { time_s: Arc::clone(&number.series.time_s), values: history.alpha_rad.into() };
    let measured = si(channel(recording, &format!("{pod}/beta"))?)?;
    let offset = air_data.sideslip_offset_rad;
    let values = measured.values.iter().map(|&beta| sideslip(beta, offset)).collect();
    Ok(vec![(Role::AngleOfAttack, alpha), (Role::Sideslip, Series { time_s: measured.time_s, values })])
}

/// The calibration of the pod: one of the file's, or a new one from level flight.
fn calibration(air_data: &AirDataCalibration, setting: &InstrumentSetting) -> StageResult<PodCalibration> {
    let Some(flight) = &setting.level_flight else {
        let found = air_data.pods.iter().find(|pod| pod.flight == setting.pod_calibration);
        return found.cloned().ok_or_else(|| {
            let known: Vec<_> = air_data.pods.iter().map(|pod| pod.flight.as_str()).collect();
            format!("pod calibration '{}' not found: use one of {}", setting.pod_calibration, known.join(", ")).into()
        });
    };
    if !setting.pod_calibration.is_empty() {
        return Err(format!(
            "pod is calibrated twice (level_flight, pod_calibration '{}'): remove one",
            setting.pod_calibration
        )
        .into());
    }
    let curve = &air_data.lift_curve;
    let area_m2 = curve
        .area_m2
        .ok_or("the lift curve has no area: add area_m2 to air_data.lift_curve of the instruments file")?;
    let density_kg_m3 = match (flight.density_kg_m3, flight.altitude_m) {
        (Some(density), None) => density,
        (None, Some(altitude)) => {
            Atmosphere::STANDARD.density_kg_m3(altitude).map_err(|error| format!("level_flight.altitude_m: {error}"))?
        }
        _ => return Err("level_flight needs either altitude_m or density_kg_m3".into()),
    };
    let [zero, middle, stall] = flight.airspeed_m_s;
    let usable = [flight.mass_kg, density_kg_m3, stall].iter().all(|value| *value > 0.0 && value.is_finite());
    if !(usable && stall < middle && middle < zero && zero.is_finite()) {
        return Err(
            "level_flight: mass and density must be above zero, airspeeds must fall from reading 0 over 85 to 100"
                .into(),
        );
    }
    let alpha = |speed| {
        level_flight_angle_of_attack(curve, flight.mass_kg, STANDARD_GRAVITY_M_S2, speed, density_kg_m3, area_m2)
    };
    pod_calibration("level flight", flight.airspeed_m_s.map(alpha))
        .map_err(|error| format!("level_flight: {error}").into())
}

/// Name of the channel that holds the fuel mass of one tank.
pub fn tank_channel(tank: &str) -> String {
    format!("fuel mass, {tank}")
}

/// Fuel mass against time, in all and of each tank.
struct Fuel {
    total: Series,
    tanks: Vec<(String, Series)>,
}

fn fuel(
    recording: &Recording,
    setting: &InstrumentSetting,
    instruments: &Instruments,
    warnings: &mut Vec<Message>,
) -> StageResult<Fuel> {
    let mut shown = Vec::new();
    for (tank, path) in &setting.fuel {
        let probe = instruments
            .fuel_probes
            .iter()
            .find(|probe| probe.tank == *tank)
            .ok_or_else(|| format!("fuel probe of tank '{tank}' not found in the instruments file"))?;
        shown.push((probe, si(channel(recording, path)?)?));
    }
    let Some(time_s) = shown.first().map(|(_, series)| Arc::clone(&series.time_s)) else {
        return Err("fuel probes missing: state at least one".into());
    };
    // Every tank by its own stamps; the sum at those of the first.
    let mut total = vec![0.0; time_s.len()];
    let (mut blind, mut tanks) = (Vec::new(), Vec::new());
    for (probe, series) in &shown {
        let history = fuel_history(&series.time_s, &[(probe, &series.values)], &FuelSettings::default())
            .map_err(|error| format!("fuel of {}: {error}", probe.tank))?;
        let (Some(&first), Some(&last)) = (series.time_s.first(), series.time_s.last()) else { continue };
        let at: Vec<f64> = time_s.iter().map(|time| time.clamp(first, last)).collect();
        let mass = resample(&series.time_s, &history.total_kg, &at, Interpolation::Linear)
            .map_err(|error| format!("fuel of {}: {error}", probe.tank))?;
        total.iter_mut().zip(mass).for_each(|(sum, mass)| *sum += mass);
        blind.extend(history.blind);
        let own = Series { time_s: Arc::clone(&series.time_s), values: history.total_kg.into() };
        tanks.push((probe.tank.clone(), own));
    }
    for (probe, _) in &shown {
        let zones = blind.iter().filter(|zone| zone.tank == probe.tank);
        let blind_s: f64 = zones.clone().map(|zone| zone.window.end_s - zone.window.start_s).sum();
        let width_kg = zones.map(|zone| zone.most_kg - zone.least_kg).fold(0.0, f64::max);
        if blind_s > 0.0 {
            // A reading above the last point of the calibration is that of a full tank.
            let effect = if width_kg < 0.5 {
                message!("its last calibrated point is used")
            } else {
                message!("fuel there is uncertain by up to {:.0} kg", width_kg)
            };
            let tank = &probe.tank;
            warnings.push(message!(
                "{} fuel probe outside its calibrated range for {:.0} s; {}",
                tank,
                blind_s,
                effect
            ));
        }
    }
    Ok(Fuel { total: Series { time_s, values: total.into() }, tanks })
}
