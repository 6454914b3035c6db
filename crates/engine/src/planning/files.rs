//! A design as files: nodes as CSV, a scenario of the simulator, a script for ArduPilot, parameters for PX4.

use std::collections::BTreeMap;
use std::fmt::Write;

use doublet_core::airframe::{Aircraft, Loading};
use doublet_core::atmos::Atmosphere;
use doublet_core::propulsion::{Ambient, EngineInput};
use doublet_core::simulate::scenario::{self, FILE_FORMAT, FILE_VERSION, Start};
use doublet_core::simulate::{self, Scenario};
use doublet_dynamics::design::{Designed, SURFACE_NAMES, THROTTLE};

use super::designed_session::{FLIGHT_FOLDER, designed_session, loading_of_mass};
use super::rows::{DesignRow, SignalRow};
use crate::builtin::PREFIX;
use crate::graph::StageResult;
use crate::session::{self, Session};
use crate::stage::Instruments;

/// Nodes of all manoeuvres, straight lines between them: number of the window, time since its start, deflections about the trim.
pub fn design_csv(row: &DesignRow) -> String {
    let mut text = "manoeuvre,time_s,aileron_rad,elevator_rad,rudder_rad,thrust_n\n".to_owned();
    for node in &row.signal {
        let SignalRow { manoeuvre, time_s, aileron, elevator, rudder, thrust_n } = node;
        let _ = writeln!(text, "{manoeuvre},{time_s},{aileron},{elevator},{rudder},{thrust_n}");
    }
    text
}

/// Name of a session's aircraft as a scenario file has it; its path where it does not come with the program.
pub(super) fn aircraft_name(session: &Session) -> &str {
    let aircraft = session.aircraft.as_deref().unwrap_or_default();
    aircraft.strip_prefix(PREFIX).unwrap_or(aircraft)
}

/// Everything that goes with the card of a design, by file name; `full_travel_rad` is that of the surfaces to either side. The session is
/// that of a simulated flight of the scenario whose files are in `flight` beside it: only for aircraft that the simulator knows.
pub fn design_files(
    session: &Session,
    aircraft: Option<&Aircraft>,
    row: &DesignRow,
    designed: &Designed,
    full_travel_rad: [f64; 3],
) -> Result<Vec<(String, Vec<u8>)>, String> {
    // Without tanks there is no fuel to choose: the scenario then states no loading.
    let loading = aircraft.and_then(|own| loading_of_mass(own, session.loading.as_ref(), row.trim["mass_kg"]).ok());
    let scenario_text = design_scenario(row, designed, aircraft_name(session), loading.as_ref());
    let scenario_text = scenario_text.map_err(|error| error.to_string())?;
    let mut files = vec![
        ("design.json", serde_json::to_string_pretty(row).map_err(|error| error.to_string())?),
        ("design.csv", design_csv(row)),
        ("design_ardupilot.lua", design_lua(designed, full_travel_rad)),
        ("design_px4.params", design_px4(designed, row.band_hz)),
    ];
    if scenario::aircraft().contains(&aircraft_name(session)) {
        let flown = scenario::parse(&scenario_text).map_err(|error| error.to_string())?;
        let mut own = designed_session(session, &flown, FLIGHT_FOLDER).map_err(|error| error.to_string())?;
        own.title = format!("{}: designed {}", session.title, row.kind);
        own.preparation.accuracy.0.extend(Instruments::stated(&row.sensor_accuracy));
        files.push(("design_session.toml", session::print(&own).map_err(|error| error.to_string())?));
    }
    files.push(("design_scenario.toml", scenario_text));
    Ok(files.into_iter().map(|(name, text)| (name.to_owned(), text.into_bytes())).collect())
}

/// A loading as a section of a scenario file.
pub(super) fn loading_text(loading: &Loading) -> String {
    let table = BTreeMap::from([("loading", loading)]);
    // Numbers by names: TOML has all of them.
    format!("\n{}", toml::to_string(&table).unwrap_or_default())
}

/// A scenario file for `doublet simulate`: the manoeuvres one after the other from the design's trim, in its gusts, with a loading, and with
/// instruments as accurate as the session shows them. Changes of
/// the thrust are those of the manifold pressure at the trim of the simulator's aircraft, none for others.
pub(super) fn design_scenario(
    row: &DesignRow,
    designed: &Designed,
    aircraft: &str,
    loading: Option<&Loading>,
) -> StageResult<String> {
    let mut text = format!(
        "format = \"{FILE_FORMAT}\"\nversion = {FILE_VERSION}\naircraft = {aircraft:?}\nairspeed_m_s = {:?}\naltitude_m = {:?}\n\
         gust_m_s = {:?}\n",
        row.trim["airspeed_m_s"], row.trim["altitude_m"], row.gust_m_s
    );
    text += &loading.map_or_else(String::new, loading_text);
    if !row.sensor_accuracy.is_empty() && scenario::aircraft().contains(&aircraft) {
        text += "\n[sensor_accuracy]\n";
        for (error, deviation) in &row.sensor_accuracy {
            let _ = writeln!(text, "{} = {deviation:?}", error.name());
        }
    }
    let moves_thrust = designed.manoeuvres.iter().any(|manoeuvre| manoeuvre.surfaces.contains(&THROTTLE));
    let head = (moves_thrust && scenario::aircraft().contains(&aircraft))
        .then(|| scenario::parse(&text).map_err(|error| error.to_string()))
        .transpose()?;
    for (index, manoeuvre) in designed.manoeuvres.iter().enumerate() {
        let _ = write!(
            text,
            "\n[[manoeuvre]]\nname = \"{:02} {}\"\nduration_s = {:?}\n",
            index + 1,
            manoeuvre.name,
            manoeuvre.duration_s
        );
        let _ = writeln!(text, "time_s = {:?}", manoeuvre.input.times_s());
        for &surface in &manoeuvre.surfaces {
            let values: Vec<f64> = manoeuvre.input.nodes().map(|node| node.1[surface]).collect();
            if surface != THROTTLE {
                let _ = writeln!(text, "{}_rad = {values:?}", SURFACE_NAMES[surface]);
            } else if let Some(head) = &head {
                let _ = writeln!(text, "manifold_pa = {:?}", manifold_of_thrust(head, &values)?);
            }
        }
    }
    Ok(text)
}

/// Changes of the manifold pressure (Pa) of all engines that change the sum of their thrusts by so much (N), at the trim in which a scenario
/// begins: the thrust of charts and propeller maps at its airspeed, by bisection, within the pressures of the engine.
fn manifold_of_thrust(scenario: &Scenario, changes_n: &[f64]) -> StageResult<Vec<f64>> {
    /// Halvings: an atmosphere to 1e-7 Pa.
    const HALVINGS: usize = 40;
    let vehicle = &scenario.vehicle;
    let body = vehicle.body(&scenario.loading).map_err(|error| error.to_string())?;
    let Start::Trimmed(condition) = scenario.start else { return Err("the scenario does not begin in a trim".into()) };
    let trim = simulate::trim(vehicle, &body, &scenario.atmosphere, &condition).map_err(|error| error.to_string())?;
    let altitude_m = condition.altitude_m;
    let pressure_pa = scenario.atmosphere.pressure_pa(altitude_m)?;
    let air = Ambient {
        airspeed_m_s: condition.airspeed_m_s,
        pressure_altitude_m: Atmosphere::STANDARD.altitude_m(pressure_pa)?,
        air_temperature_k: scenario.atmosphere.temperature_k(altitude_m)?,
        density_kg_m3: scenario.atmosphere.density_kg_m3(altitude_m)?,
    };
    let thrust_n = |manifold_pressure_pa: f64| -> f64 {
        let models = vehicle.powerplant.engines.iter().filter_map(|engine| engine.model.as_ref());
        let input = EngineInput { speed_rad_s: condition.engine_speed_rad_s, manifold_pressure_pa };
        models.map(|model| model.state(input, &air).thrust_n).sum()
    };
    let about_pa = trim.engines[0].manifold_pressure_pa;
    let about_n = thrust_n(about_pa);
    let change = |change_n: &f64| {
        let (mut low, mut high) = (0.3 * about_pa, pressure_pa.max(about_pa));
        for _ in 0..HALVINGS {
            let middle = 0.5 * (low + high);
            if thrust_n(middle) < about_n + change_n { low = middle } else { high = middle }
        }
        if *change_n == 0.0 { 0.0 } else { 0.5 * (low + high) - about_pa }
    };
    Ok(changes_n.iter().map(change).collect())
}

/// Servo functions of ArduPilot: aileron, elevator, rudder.
const FUNCTIONS: [u32; 3] = [4, 19, 21];

/// A script for ArduPilot's scripting engine that flies the first manoeuvre when a switch goes high: the servos that move are taken over for
/// the length of the window, each about the output it had then, straight lines between the nodes; the switch going low ends it.
///
/// Full travel of each servo is `full_travel_rad` to either side; the servo's own minimum, maximum and reversal are read from its
/// parameters.
fn design_lua(designed: &Designed, full_travel_rad: [f64; 3]) -> String {
    let Some(manoeuvre) = designed.manoeuvres.first() else { return String::new() };
    let mut text = String::from(
        "-- Designed input, written by doublet. Deflections are parts of full travel about the output at the start.\n\
         -- Check signs and travel of every servo on the ground first.\n\
         local SWITCH_CHANNEL = 6   -- RC input that starts it when high and ends it when low\n\
         local STEP_MS = 10\n\
         local OVERRIDE_MS = 60     -- a servo goes back to the autopilot when the script falls silent for this long\n",
    );
    let _ = writeln!(text, "local DURATION_S = {:.3}", manoeuvre.duration_s);
    text.push_str("local SURFACES = {\n");
    for &surface in manoeuvre.surfaces.iter().filter(|&&control| control != THROTTLE) {
        let _ = writeln!(
            text,
            "  {{ name = \"{}\", servo_function = {}, nodes = {{",
            SURFACE_NAMES[surface], FUNCTIONS[surface]
        );
        for (time_s, deflections) in manoeuvre.input.nodes() {
            let part = (deflections[surface] / full_travel_rad[surface]).clamp(-1.0, 1.0);
            let _ = writeln!(text, "    {{ {time_s:.4}, {part:.5} }},");
        }
        text.push_str("  } },\n");
    }
    text.push_str(LUA_BODY);
    text
}

const LUA_BODY: &str = r#"}

local started_ms = nil
local was_high = true          -- a switch that is high at boot starts nothing

local function value(nodes, time_s)
  for index = 2, #nodes do
    local t0, v0, t1, v1 = nodes[index - 1][1], nodes[index - 1][2], nodes[index][1], nodes[index][2]
    if time_s >= t0 and time_s < t1 then
      return v0 + (v1 - v0) * (time_s - t0) / (t1 - t0)
    end
  end
  return 0.0
end

local function begin()
  for _, surface in ipairs(SURFACES) do
    surface.channel = SRV_Channels:find_channel(surface.servo_function)
    surface.start_pwm = SRV_Channels:get_output_pwm(surface.servo_function)
    if not surface.channel or not surface.start_pwm then
      gcs:send_text(4, "input: no servo for " .. surface.name)
      return false
    end
    local servo = "SERVO" .. tostring(surface.channel + 1)
    surface.low, surface.high = param:get(servo .. "_MIN"), param:get(servo .. "_MAX")
    local reversed = param:get(servo .. "_REVERSED")
    surface.sign = (reversed == 1) and -1 or 1
  end
  return true
end

function update()
  local pwm = rc:get_pwm(SWITCH_CHANNEL)
  local high = pwm ~= nil and pwm > 1700
  if high and not was_high and begin() then
    started_ms = millis()
    gcs:send_text(6, "input: started")
  end
  was_high = high
  if started_ms then
    local time_s = (millis() - started_ms):tofloat() / 1000.0
    if not high or time_s >= DURATION_S then
      started_ms = nil
      gcs:send_text(6, high and "input: finished" or "input: stopped")
    else
      for _, surface in ipairs(SURFACES) do
        local half = (surface.high - surface.low) / 2
        local output = surface.start_pwm + surface.sign * half * value(surface.nodes, time_s)
        output = math.max(surface.low, math.min(surface.high, output))
        SRV_Channels:set_output_pwm_chan_timeout(surface.channel, math.floor(output + 0.5), OVERRIDE_MS)
      end
    end
  end
  return update, STEP_MS
end

return update()
"#;

/// Parameters of PX4's own signal injection for fixed-wing aircraft: a sweep by factors over the band and the time of the design. PX4 knows no
/// inputs node by node, and adds what it injects to the rate setpoints, so that this is the nearest it flies by itself.
fn design_px4(designed: &Designed, band_hz: [f64; 2]) -> String {
    let longest_s = designed.manoeuvres.iter().map(|manoeuvre| manoeuvre.duration_s).fold(0.0, f64::max);
    let axes: i32 = {
        let mut axes = 0;
        let moved = designed.manoeuvres.iter().flat_map(|manoeuvre| &manoeuvre.surfaces);
        for surface in moved.filter(|&&control| control != THROTTLE) {
            axes |= 1 << surface;
        }
        axes
    };
    // Types of the file: 6 a 32-bit integer, 9 a 32-bit number.
    format!(
        "# Written by doublet. PX4's injection adds to the rate setpoints of one axis after the other; it flies no designed signal as it is.\n\
         # Vehicle-Id Component-Id Name Value Type\n\
         1\t1\tFW_AT_AXES\t{axes}\t6\n\
         1\t1\tFW_AT_APPLY\t0\t6\n\
         1\t1\tFW_AT_SYSID_TYPE\t2\t6\n\
         1\t1\tFW_AT_SYSID_F0\t{:.3}\t9\n\
         1\t1\tFW_AT_SYSID_F1\t{:.3}\t9\n\
         1\t1\tFW_AT_SYSID_TIME\t{longest_s:.1}\t9\n",
        band_hz[0], band_hz[1]
    )
}
