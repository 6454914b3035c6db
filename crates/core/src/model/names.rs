//! Names of the aerodynamic coefficients and of the variables they depend on.

use crate::quantity::Role;

/// An aerodynamic coefficient; the first six are those of body axes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Coefficient {
    /// Force along body x.
    CX,
    /// Force along body y.
    CY,
    /// Force along body z.
    CZ,
    /// Rolling moment.
    Cl,
    /// Pitching moment.
    Cm,
    /// Yawing moment.
    Cn,
    /// Drag: opposite to the airspeed in the plane of symmetry (stability axes).
    CD,
    /// Lift: perpendicular to the airspeed in the plane of symmetry (stability axes).
    CL,
}

impl Coefficient {
    crate::named_variants! {
        /// Name as printed, for example `Cm`.
        pub name: CX "CX", CY "CY", CZ "CZ", Cl "Cl", Cm "Cm", Cn "Cn", CD "CD", CL "CL"
    }
}

/// Declares [`Variable`] with its name in terms, its name in derivatives and its description.
macro_rules! variables {
    ($($variant:ident, $name:literal, $suffix:literal, $text:literal;)*) => {
        /// A variable that terms of the aerodynamic model are products of.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
        pub enum Variable { $(#[doc = $text] $variant,)* }

        impl Variable {
            /// All of them.
            pub const ALL: &'static [Self] = &[$(Self::$variant,)*];

            /// Name in terms, for example `qc/V`.
            pub fn name(self) -> &'static str { match self { $(Self::$variant => $name,)* } }

            /// Suffix in derivative names, for example `q` in `Cm_q`.
            pub fn suffix(self) -> &'static str { match self { $(Self::$variant => $suffix,)* } }

            /// One-line description with unit.
            pub fn description(self) -> &'static str { match self { $(Self::$variant => $text,)* } }
        }
    };
}

variables! {
    Alpha, "alpha", "alpha", "angle of attack, rad";
    AlphaDot, "alpha_dot*c/V", "alpha_dot", "rate of angle of attack times chord over airspeed";
    Beta, "beta", "beta", "angle of sideslip, rad";
    BetaDot, "beta_dot*b/2V", "beta_dot", "rate of sideslip times span over twice the airspeed";
    RollRate, "pb/2V", "p", "roll rate times span over twice the airspeed";
    PitchRate, "qc/V", "q", "pitch rate times chord over airspeed";
    YawRate, "rb/2V", "r", "yaw rate times span over twice the airspeed";
    Aileron, "delta_a", "delta_a", "aileron deflection, rad";
    Elevator, "delta_e", "delta_e", "elevator deflection, rad";
    Rudder, "delta_r", "delta_r", "rudder deflection, rad";
    PropellerPressure, "dpt/q", "dpt", "total-pressure rise through the propellers over dynamic pressure";
    ThrustCoefficient, "Tc", "Tc", "thrust over dynamic pressure and reference area";
    Airspeed, "V", "V", "true airspeed, m/s";
    Altitude, "h", "h", "altitude, m";
    Mach, "mach", "mach", "Mach number";
    HalfPitchRate, "qc/2V", "qhat", "pitch rate times chord over twice the airspeed: half of qc/V, its derivative twice that of qc/V";
    Flap, "flap", "flap", "flap deflection, rad";
    ElevatorTrim, "delta_te", "delta_te", "elevator trim tab deflection, rad";
    Stabiliser, "stabiliser", "stabiliser", "incidence of the horizontal stabiliser, rad";
    Other1, "other_1", "other_1", "the channel or expression with the role other_1";
    Other2, "other_2", "other_2", "the channel or expression with the role other_2";
    Other3, "other_3", "other_3", "the channel or expression with the role other_3";
    Other4, "other_4", "other_4", "the channel or expression with the role other_4";
}

/// Variables that are what was recorded, with the role of their channel; the motion does not change them.
pub const RECORDED: [(Variable, Role); 7] = [
    (Variable::Flap, Role::Flap),
    (Variable::ElevatorTrim, Role::ElevatorTrim),
    (Variable::Stabiliser, Role::Stabiliser),
    (Variable::Other1, Role::Other1),
    (Variable::Other2, Role::Other2),
    (Variable::Other3, Role::Other3),
    (Variable::Other4, Role::Other4),
];

/// Values of the [`RECORDED`] variables, in their order.
pub type RecordedValues = [f64; RECORDED.len()];

impl Variable {
    /// The variable with this name in terms, or with this suffix.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.iter().copied().find(|variable| variable.name() == name || variable.suffix() == name)
    }
}
