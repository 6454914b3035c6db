//! The recorders of the flight-test installation (thesis Tables 4.13-4.16), as data.
//!
//! Rates and units are those of Table 4.13, noise that of Tables 4.15-4.16 (raw yaw rate 6.15e-4 rad/s, as its printed
//! 6.15e-2 cannot be steady flight) and 4.6; resolutions, biases and the control sensors' clock are doublet's own.

use super::instrument_errors::Recorder;
use super::instruments::{Mount, Quantity as Q};
use super::recorder::{ChannelSpec, Clock, Reading, StreamSpec};

const DEG: f64 = std::f64::consts::PI / 180.0;
const KT: f64 = 1852.0 / 3600.0;
const FT: f64 = 0.3048;
const G: f64 = 9.806_65;
const IN_HG: f64 = 3386.389;
const LB: f64 = 0.453_592_37;
const HP: f64 = 745.699_871_582;
const RPM: f64 = std::f64::consts::TAU / 60.0;

/// Clock of the engine monitor: flight FT1.0 of thesis Table 4.14.
pub(crate) const MONITOR_CLOCK: Clock = Clock { offset_s: -0.734, drift: -4.51e-5 };
/// Clock of the air-data pod: flight FT1.0 of thesis Table 4.14.
pub(crate) const POD_CLOCK: Clock = Clock { offset_s: -258.810, drift: -1.43e-4 };
/// Clock of the control sensors, all five synchronised.
pub(crate) const CONTROL_CLOCK: Clock = Clock { offset_s: -412.370, drift: 2.3e-5 };
/// Age of a control sensor's attitude when it is stamped, s (thesis section 4.1.1).
pub(crate) const CONTROL_DELAY_S: f64 = 0.030;
/// Magnetic declination where the flight takes place, positive east, rad.
pub(crate) const DECLINATION_RAD: f64 = 2.1 * DEG;
/// Accelerometers, m from the datum (thesis section 4.4.3).
pub(crate) const ACCELEROMETER_FROM_DATUM_M: [f64; 3] = [2.03, 0.20, 1.40];
/// Biases of the accelerometers, m/s².
pub(crate) const ACCELEROMETER_BIAS_M_S2: [f64; 3] = [0.030, -0.020, 0.050];
/// Biases of the gyros, rad/s.
pub(crate) const GYRO_BIAS_RAD_S: [f64; 3] = [8e-4, -5e-4, 6e-4];
/// Offset of the pod's sideslip, rad (thesis section 4.4.3).
pub(crate) const SIDESLIP_OFFSET_RAD: f64 = 0.72 * DEG;

/// A channel without bias whose unit has its zero where SI has.
const fn channel(
    name: &'static str,
    (unit, scale): (&'static str, f64),
    reading: Reading,
    noise: f64,
    resolution: f64,
) -> ChannelSpec {
    ChannelSpec { name, unit, scale, origin: 0.0, reading, bias: 0.0, noise, resolution }
}

/// The same with a bias.
const fn biased(spec: ChannelSpec, bias: f64) -> ChannelSpec {
    ChannelSpec { bias, ..spec }
}

const fn plain(quantity: Q) -> Reading {
    Reading::Plain(quantity)
}

const IMU: &[ChannelSpec] = &[
    biased(channel("A_x", ("g", G), plain(Q::SensorForceX), 3.07e-2, 1.0 / 2048.0), ACCELEROMETER_BIAS_M_S2[0]),
    biased(channel("A_y", ("g", G), plain(Q::SensorForceY), 5.61e-3, 1.0 / 2048.0), ACCELEROMETER_BIAS_M_S2[1]),
    biased(channel("A_z", ("g", G), Reading::NormalisedZ, 1.46e-2, 1.0 / 2048.0), ACCELEROMETER_BIAS_M_S2[2]),
    biased(channel("p", ("deg/s", DEG), plain(Q::RollRate), 6.22e-4, 1.0 / 32.0), GYRO_BIAS_RAD_S[0]),
    biased(channel("q", ("deg/s", DEG), plain(Q::PitchRate), 1.20e-3, 1.0 / 32.0), GYRO_BIAS_RAD_S[1]),
    biased(channel("r", ("deg/s", DEG), plain(Q::YawRate), 6.15e-4, 1.0 / 32.0), GYRO_BIAS_RAD_S[2]),
    channel("phi", ("deg", DEG), plain(Q::Bank), 6.25e-4, 1.0 / 64.0),
    channel("theta", ("deg", DEG), plain(Q::Pitch), 3.52e-4, 1.0 / 64.0),
];
const HEADING: &[ChannelSpec] = &[
    channel("psi", ("deg", DEG), Reading::MagneticHeading(DECLINATION_RAD), 2.32e-4, 1.0 / 128.0),
    channel("h_p", ("ft", FT), plain(Q::PressureAltitude), 0.3, 1.0),
];
const AIR_DATA: &[ChannelSpec] = &[
    channel("V_TAS", ("kt", KT), plain(Q::TrueAirspeed), 5.14e-2, 1.0 / 16.0),
    channel("V_IAS", ("kt", KT), plain(Q::CalibratedAirspeed), 5.14e-2, 1.0 / 16.0),
    channel("p_s", ("inHg", IN_HG), plain(Q::StaticPressure), 3.0, 0.001),
];
const TEMPERATURE: &[ChannelSpec] =
    &[ChannelSpec { origin: 273.15, ..channel("OAT", ("degC", 1.0), plain(Q::Temperature), 0.1, 0.25) }];
const NAVIGATION: &[ChannelSpec] = &[
    channel("h_GPS", ("ft", FT), plain(Q::GpsAltitude), 8.65e-2, 1.0 / 8.0),
    channel("v_north", ("kt", KT), plain(Q::VelocityNorth), 1.86e-2, 1.0 / 64.0),
    channel("v_east", ("kt", KT), plain(Q::VelocityEast), 1.70e-2, 1.0 / 64.0),
    channel("v_up", ("kt", KT), plain(Q::VelocityUp), 5.82e-3, 1.0 / 64.0),
];
const MONITOR: &[ChannelSpec] = &[
    channel("m_f_MR", ("lb", LB), Reading::Fuel(0), 0.2, 1.0),
    channel("m_f_ML", ("lb", LB), Reading::Fuel(1), 0.2, 1.0),
    channel("m_f_AR", ("lb", LB), Reading::Fuel(2), 0.2, 1.0),
    channel("m_f_AL", ("lb", LB), Reading::Fuel(3), 0.2, 1.0),
    channel("p_z_f", ("inHg", IN_HG), plain(Q::Manifold1), 100.0, 0.1),
    channel("p_z_r", ("inHg", IN_HG), plain(Q::Manifold2), 100.0, 0.1),
    channel("N_f", ("rpm", RPM), plain(Q::Speed1), 0.3, 1.0),
    channel("N_r", ("rpm", RPM), plain(Q::Speed2), 0.3, 1.0),
    channel("P_f", ("hp", HP), Reading::MonitorPower(0), 400.0, 2.1),
    channel("P_r", ("hp", HP), Reading::MonitorPower(1), 400.0, 2.1),
    channel("n", ("-", 1.0), plain(Q::LoadFactor), 5e-3, 0.01),
    channel("V_IAS", ("kt", KT), plain(Q::CalibratedAirspeed), 5.14e-2, 0.1),
];
const POD: &[ChannelSpec] = &[
    channel("AOA", ("-", 1.0), Reading::Pod, 0.3, 0.1),
    biased(channel("beta", ("deg", DEG), plain(Q::Beta), 1.23e-3, 0.01), SIDESLIP_OFFSET_RAD),
    channel("V_IAS", ("kt", KT), plain(Q::CalibratedAirspeed), 5.14e-2, 0.1),
    channel("phi", ("deg", DEG), plain(Q::Bank), 8.7e-4, 0.1),
    channel("theta", ("deg", DEG), plain(Q::Pitch), 8.7e-4, 0.1),
];

/// Three angles of a control sensor with the noise of a running engine (thesis Table 4.6), deg.
const fn angles(mount: Mount, noise_deg: [f64; 3]) -> [ChannelSpec; 3] {
    [
        channel("phi", ("deg", DEG), Reading::SensorAngle(mount, 0), noise_deg[0] * DEG, 0.01),
        channel("theta", ("deg", DEG), Reading::SensorAngle(mount, 1), noise_deg[1] * DEG, 0.01),
        channel("psi", ("deg", DEG), Reading::SensorAngle(mount, 2), noise_deg[2] * DEG, 0.01),
    ]
}

const YOKE: &[ChannelSpec] = &angles(Mount::YOKE, [0.155, 0.076, 0.155]);
const PANEL: &[ChannelSpec] = &angles(Mount::PANEL, [0.155, 0.076, 0.155]);
const COLUMN: &[ChannelSpec] = &angles(Mount::COLUMN, [0.032, 0.092, 0.295]);
const RIGHT_PEDAL: &[ChannelSpec] = &angles(Mount::RIGHT_PEDAL, [0.051, 0.028, 0.049]);
const LEFT_PEDAL: &[ChannelSpec] = &angles(Mount::LEFT_PEDAL, [0.051, 0.028, 0.049]);

const fn bus(name: &'static str, rate_hz: f64, channels: &'static [ChannelSpec]) -> StreamSpec {
    StreamSpec {
        name,
        clock: Clock::REFERENCE,
        rate_hz,
        delay_s: 0.0,
        stamp_noise_s: 0.0,
        only_manoeuvres: false,
        channels,
    }
}

const fn control(name: &'static str, channels: &'static [ChannelSpec]) -> StreamSpec {
    StreamSpec { clock: CONTROL_CLOCK, delay_s: CONTROL_DELAY_S, only_manoeuvres: true, ..bus(name, 60.0, channels) }
}

/// Recorder of a stream of [`BUS`].
pub(super) fn recorder(spec: &StreamSpec) -> Recorder {
    if spec.clock == MONITOR_CLOCK { Recorder::Monitor } else { Recorder::Bus }
}

/// Streams of the data bus and the engine monitor, which share a file.
pub(crate) const BUS: &[StreamSpec] = &[
    bus("adahrs/inertial", 50.0, IMU),
    bus("adahrs/heading_altitude", 25.0, HEADING),
    bus("adahrs/air_data", 12.5, AIR_DATA),
    bus("adahrs/temperature", 2.5, TEMPERATURE),
    bus("navigation", 5.0, NAVIGATION),
    // 5.56 Hz: one sample every 0.18 s, stamped by software.
    StreamSpec { clock: MONITOR_CLOCK, stamp_noise_s: 0.003, ..bus("engine_monitor", 1.0 / 0.18, MONITOR) },
];

/// Control sensors, a file each.
pub(crate) const CONTROL_SENSORS: &[StreamSpec] = &[
    control("yoke", YOKE),
    control("panel", PANEL),
    control("column", COLUMN),
    control("right_pedal", RIGHT_PEDAL),
    control("left_pedal", LEFT_PEDAL),
];

/// The air-data pod at its rate: 5 Hz, or the 1 Hz it falls back to after a calibration.
pub const fn pod(rate_hz: f64) -> StreamSpec {
    StreamSpec { clock: POD_CLOCK, ..bus("pod", rate_hz, POD) }
}
