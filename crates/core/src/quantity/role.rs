//! Roles: what a recorded channel means to the analysis.

use super::named_quantities;

named_quantities! {
    /// What a channel means to the analysis. Axes, signs and references are those of `docs/conventions.md`.
    Role;
    SpecificForceX, "ax", Acceleration, "specific force along body x (forward), measured";
    SpecificForceY, "ay", Acceleration, "specific force along body y (right), measured";
    SpecificForceZ, "az", Acceleration, "specific force along body z (down), measured";
    RollRate, "p", AngularRate, "roll rate about body x";
    PitchRate, "q", AngularRate, "pitch rate about body y";
    YawRate, "r", AngularRate, "yaw rate about body z";
    RollAcceleration, "p_dot", AngularAcceleration, "roll acceleration";
    PitchAcceleration, "q_dot", AngularAcceleration, "pitch acceleration";
    YawAcceleration, "r_dot", AngularAcceleration, "yaw acceleration";
    PositionNorth, "x", Length, "position north of the local origin";
    PositionEast, "y", Length, "position east of the local origin";
    PositionDown, "z", Length, "position below the local origin";
    VelocityNorth, "v_north", Speed, "ground velocity, north component";
    VelocityEast, "v_east", Speed, "ground velocity, east component";
    VelocityDown, "v_down", Speed, "ground velocity, down component";
    BankAngle, "phi", Angle, "bank angle";
    PitchAngle, "theta", Angle, "pitch angle";
    HeadingAngle, "psi", Angle, "heading angle";
    TrueAirspeed, "airspeed", Speed, "true airspeed";
    AngleOfAttack, "alpha", Angle, "angle of attack";
    Sideslip, "beta", Angle, "angle of sideslip";
    Aileron, "delta_a", Angle, "aileron deflection";
    Elevator, "delta_e", Angle, "elevator deflection";
    Rudder, "delta_r", Angle, "rudder deflection";
    ElevatorTrim, "delta_te", Angle, "elevator trim tab deflection";
    Stabiliser, "stabiliser", Angle, "incidence of the horizontal stabiliser";
    Flap, "flap", Angle, "flap deflection";
    StaticPressure, "static_pressure", Pressure, "static pressure";
    AirTemperature, "air_temperature", Temperature, "static air temperature";
    TotalTemperature, "total_temperature", Temperature, "total air temperature";
    AirDensity, "air_density", Density, "air density";
    Mach, "mach", Dimensionless, "Mach number";
    CalibratedAirspeed, "calibrated_airspeed", Speed, "calibrated or indicated airspeed";
    EquivalentAirspeed, "equivalent_airspeed", Speed, "equivalent airspeed: the true one times the root of the density ratio";
    ImpactPressure, "impact_pressure", Pressure, "impact pressure: total less static pressure";
    Altitude, "altitude", Length, "pressure altitude";
    Latitude, "latitude", Angle, "geodetic latitude";
    Longitude, "longitude", Angle, "geodetic longitude";
    GpsAltitude, "gps_altitude", Length, "altitude from satellite navigation";
    FuelMass, "fuel_mass", Mass, "fuel mass on board";
    FuelFlow, "fuel_flow", MassFlow, "fuel flow, all engines";
    Thrust1, "thrust_1", Force, "thrust of engine 1 (left or front)";
    Thrust2, "thrust_2", Force, "thrust of engine 2 (right or rear)";
    ThrustCoefficient, "thrust_coefficient", Dimensionless, "thrust of all engines over dynamic pressure and reference area";
    EngineSpeed1, "engine_speed_1", AngularRate, "rotational speed of engine 1 (left or front)";
    EngineSpeed2, "engine_speed_2", AngularRate, "rotational speed of engine 2 (right or rear)";
    ManifoldPressure1, "manifold_pressure_1", Pressure, "manifold pressure of engine 1 (left or front)";
    ManifoldPressure2, "manifold_pressure_2", Pressure, "manifold pressure of engine 2 (right or rear)";
    Power1, "power_1", Power, "power of engine 1 (left or front) as its monitor reports it";
    Power2, "power_2", Power, "power of engine 2 (right or rear) as its monitor reports it";
    Other1, "other_1", Dimensionless, "any quantity, taken as it is: a term of the model by this name";
    Other2, "other_2", Dimensionless, "any second quantity, taken as it is";
    Other3, "other_3", Dimensionless, "any third quantity, taken as it is";
    Other4, "other_4", Dimensionless, "any fourth quantity, taken as it is";
    WeightOnWheels, "weight_on_wheels", Dimensionless, "above one half while the weight is on the wheels";
}

impl Role {
    /// Speeds through the air, the one that needs no other quantity first.
    pub const AIRSPEEDS: [Self; 3] = [Self::TrueAirspeed, Self::CalibratedAirspeed, Self::EquivalentAirspeed];
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_role_is_found_again_by_its_name() {
        for role in Role::ALL {
            assert_eq!(Role::from_name(role.name()), Some(role));
        }
    }
}
