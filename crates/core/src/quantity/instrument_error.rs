//! Constant errors of instruments that neither a filter nor a calibration of one flight determines exactly.

use super::named_quantities;

named_quantities! {
    /// A constant error of an instrument: offset and scale of the vanes, delay of what a recorder writes.
    InstrumentError;
    AlphaOffset, "alpha_offset_rad", Angle, "Offset of the recorded angle of attack.";
    BetaOffset, "beta_offset_rad", Angle, "Offset of the recorded sideslip.";
    AlphaScale, "alpha_scale", Dimensionless, "Scale error of the recorded angle of attack, upwash included.";
    BetaScale, "beta_scale", Dimensionless, "Scale error of the recorded sideslip, sidewash included.";
    GroundDelay, "ground_delay_s", Time, "Delay of horizontal position and of velocity over ground.";
    AltitudeDelay, "altitude_delay_s", Time, "Delay of the altitude.";
    FlowDelay, "flow_delay_s", Time, "Delay of both flow angles.";
    AirspeedDelay, "airspeed_delay_s", Time, "Delay of the airspeed.";
    AttitudeDelay, "attitude_delay_s", Time, "Delay of the attitude.";
    AileronDelay, "aileron_delay_s", Time, "Delay of the recorded aileron.";
    ElevatorDelay, "elevator_delay_s", Time, "Delay of the recorded elevator.";
    RudderDelay, "rudder_delay_s", Time, "Delay of the recorded rudder.";
}

impl InstrumentError {
    /// Largest standard deviation that makes sense: 6 deg of a vane, half of its scale, 0.1 s of a recorder.
    pub fn greatest_deviation(self) -> f64 {
        match self {
            Self::AlphaScale | Self::BetaScale => 0.5,
            _ => 0.1,
        }
    }

    /// Checks a standard deviation.
    ///
    /// # Errors
    /// A sentence with the range.
    pub fn check_deviation(self, deviation: f64) -> Result<(), String> {
        let greatest = self.greatest_deviation();
        match deviation > 0.0 && deviation <= greatest {
            true => Ok(()),
            false => Err(format!("{} = {deviation} must be above 0, up to {greatest}", self.name())),
        }
    }
}
