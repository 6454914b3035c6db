//! How a test of a rule is flown: hazard, power, height, room in airspeed, what it moves.

use super::units::{FOOT_M, FOOT_PER_MINUTE_M_S};
use crate::planning::{HazardLevel, Risk};
use crate::session::Surface;
use crate::stage::ObjectiveTest;

/// What is moved besides the controls.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Moved {
    Flaps,
    Gear,
    Spoilers,
}

impl Moved {
    /// Key of its greatest airspeed in a test file, and its name.
    pub(super) fn names(self) -> (&'static str, &'static str) {
        match self {
            Self::Flaps => ("flaps_m_s", "flaps"),
            Self::Gear => ("gear_m_s", "retractable gear"),
            Self::Spoilers => ("spoilers_m_s", "spoilers or speedbrakes"),
        }
    }
}

/// How a kind of test is flown.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Profile {
    /// Word of its kinds of input.
    word: &'static str,
    /// Surface it moves.
    pub surface: Option<Surface>,
    /// Hazard category.
    pub hazard: &'static str,
    /// Hazard and mitigation.
    risk: (&'static str, &'static str),
    /// Power in words, where it is not that of steady level flight.
    pub power: &'static str,
    /// Airspeed it may lose, m/s.
    pub loss_m_s: f64,
    /// Airspeed over the stall at which it ends, where it is not 1.2.
    pub stall_ratio: Option<f64>,
    /// Bank it holds in cruise and elsewhere, deg.
    banks_deg: Option<[f64; 2]>,
    /// Height it climbs through, m; negative in a descent.
    pub climb_m: f64,
    /// Rate that is planned for, m/s.
    pub rate_m_s: f64,
    /// Least altitude at its end, m.
    pub floor_m: f64,
    /// Engines it needs.
    pub engines: usize,
    /// Whether a failed engine must leave a yawing moment.
    pub is_asymmetric: bool,
    /// Whether it is flown at the manoeuvring airspeed, not at that of the manoeuvres.
    pub is_fast: bool,
    /// What it moves besides the controls.
    pub moved: Option<Moved>,
}

/// A short input from steady flight.
const PLAIN: Profile = Profile {
    word: "",
    surface: None,
    hazard: "low",
    risk: (
        "Stall after the input at low airspeed",
        "Entry above the knock-off airspeed with tolerance and loss; smallest amplitude first; recovery by releasing the controls.",
    ),
    power: "",
    loss_m_s: 1.0,
    stall_ratio: None,
    banks_deg: None,
    climb_m: 0.0,
    rate_m_s: 0.0,
    floor_m: LOW_M,
    engines: 1,
    is_asymmetric: false,
    is_fast: false,
    moved: None,
};
/// Least altitudes, m: 2,000 ft, and 5,000 ft where control may be lost.
const LOW_M: f64 = 2000.0 * FOOT_M;
const HIGH_M: f64 = 5000.0 * FOOT_M;

/// A test with an engine at idle.
const ONE_ENGINE: Profile = Profile { hazard: "high", engines: 2, ..PLAIN };
/// A change of configuration.
const CHANGE: Profile = Profile {
    hazard: "medium",
    risk: (
        "Overspeed of what is extended",
        "Moved below the greatest airspeed of the card only; airspeed called before each movement.",
    ),
    loss_m_s: 3.0,
    ..PLAIN
};

/// Controls free in a bank.
const FREE_IN_BANK: Profile = Profile {
    surface: Some(Surface::Aileron),
    risk: ("Unusual attitude with the controls free", "Bank called; controls taken at 45 deg of bank."),
    banks_deg: Some([30.0, 30.0]),
    ..PLAIN
};

/// Profiles by the words of kinds of input; the first that fits holds.
const PROFILES: [Profile; 20] = [
    Profile {
        word: "engine failure",
        risk: (
            "Loss of control after the failure, or an engine that does not restart",
            "Throttle to idle instead of a shut-down; 5,000 ft above the ground at least; controls taken at 45 deg of bank.",
        ),
        power: "take-off power; one engine to idle at the start of the record",
        loss_m_s: 5.0,
        floor_m: HIGH_M,
        ..ONE_ENGINE
    },
    Profile {
        word: "minimum control speed",
        surface: Some(Surface::Rudder),
        risk: (
            "Stall or spin with asymmetric thrust",
            "5,000 ft above the ground at least; ends at lost heading, stall warning or the knock-off airspeed, whichever is first; power of the operating engine back, then nose down.",
        ),
        power: "take-off power on the operating engine, the other at idle",
        loss_m_s: 8.0,
        stall_ratio: Some(1.1),
        floor_m: HIGH_M,
        is_asymmetric: true,
        ..ONE_ENGINE
    },
    Profile {
        word: "climb, one engine",
        hazard: "medium",
        risk: (
            "Low airspeed and no climb with an engine at idle",
            "Idle instead of a shut-down; both engines available; ends at the knock-off airspeed.",
        ),
        power: "climb power on the operating engine, the other at idle",
        climb_m: 1000.0 * FOOT_M,
        rate_m_s: 200.0 * FOOT_PER_MINUTE_M_S,
        ..ONE_ENGINE
    },
    Profile {
        word: "climb, all engines",
        power: "climb power",
        climb_m: 1000.0 * FOOT_M,
        rate_m_s: 500.0 * FOOT_PER_MINUTE_M_S,
        ..PLAIN
    },
    Profile {
        word: "emergency descent",
        hazard: "high",
        risk: (
            "Overspeed, or recovery too close to the ground",
            "Smooth air; airspeed called; recovery begun 500 ft above the least altitude; VA until the emergency procedure states the airspeed.",
        ),
        power: "idle, as the emergency procedure states",
        climb_m: -3000.0 * FOOT_M,
        rate_m_s: 1500.0 * FOOT_PER_MINUTE_M_S,
        is_fast: true,
        ..PLAIN
    },
    Profile {
        word: "idle descent",
        risk: ("Shock cooling of the engines", "Power reduced in steps; engine temperatures called."),
        power: "idle",
        climb_m: -1000.0 * FOOT_M,
        rate_m_s: 500.0 * FOOT_PER_MINUTE_M_S,
        ..PLAIN
    },
    Profile { word: "power change", power: "that of the approach to climb or go-around power", loss_m_s: 3.0, ..PLAIN },
    Profile { word: "flap change", moved: Some(Moved::Flaps), ..CHANGE },
    Profile { word: "gear change", moved: Some(Moved::Gear), ..CHANGE },
    Profile { word: "spoiler change", moved: Some(Moved::Spoilers), ..CHANGE },
    Profile {
        word: "manoeuvring stability",
        surface: Some(Surface::Elevator),
        hazard: "medium",
        risk: (
            "Stall or overstress at high load factor",
            "Bank and load factor called; recovery by releasing the column.",
        ),
        banks_deg: Some([45.0, 30.0]),
        ..PLAIN
    },
    Profile {
        word: "static stability",
        surface: Some(Surface::Elevator),
        risk: ("Stall at the slowest speed held", "Slowest speed above the knock-off airspeed; approached in steps."),
        loss_m_s: 5.0,
        ..PLAIN
    },
    Profile {
        word: "phugoid",
        surface: Some(Surface::Elevator),
        risk: (
            "Airspeed beyond its limits",
            "Controls taken at the knock-off airspeed, at 60 deg of bank, or before VNE is reached.",
        ),
        loss_m_s: 5.0,
        ..PLAIN
    },
    Profile {
        word: "sideslip",
        surface: Some(Surface::Rudder),
        hazard: "medium",
        risk: ("Stall or departure at high sideslip", "Smallest deflection first; recovery by releasing the controls."),
        ..PLAIN
    },
    Profile { word: "spiral", ..FREE_IN_BANK },
    Profile { word: "roll step", ..FREE_IN_BANK },
    Profile { word: "dutch", surface: Some(Surface::Rudder), ..PLAIN },
    Profile { word: "pitch", surface: Some(Surface::Elevator), ..PLAIN },
    Profile { word: "roll", surface: Some(Surface::Aileron), ..PLAIN },
    Profile { word: "yaw", surface: Some(Surface::Rudder), ..PLAIN },
];

impl Profile {
    pub(super) fn of_test(test: &ObjectiveTest) -> Self {
        let kind = test.kinds.first().map_or("", String::as_str);
        let found = PROFILES.iter().find(|profile| kind.contains(profile.word)).unwrap_or(&PLAIN);
        Self { surface: test.surface.or(found.surface), ..*found }
    }

    /// Its hazard and mitigation.
    pub(super) fn risk(&self) -> Risk {
        Risk {
            hazard: self.risk.0.to_owned(),
            mitigation: self.risk.1.to_owned(),
            level: HazardLevel::from_name(self.hazard),
        }
    }

    /// Greatest bank it holds in a condition, deg.
    pub(super) fn bank_deg(&self, is_cruise: bool) -> Option<f64> {
        self.banks_deg.map(|[cruise, other]| if is_cruise { cruise } else { other })
    }

    /// Time of the climb or descent at the planned rate, s.
    pub(super) fn height_s(&self) -> f64 {
        if self.climb_m == 0.0 { 0.0 } else { self.climb_m.abs() / self.rate_m_s }
    }

    /// Time of the way back to the altitude of the entry, at 500 ft/min, s.
    pub(super) fn back_s(&self) -> f64 {
        self.climb_m.abs() / (500.0 * FOOT_PER_MINUTE_M_S)
    }

    /// Least altitude of the entry, m, from which a descent ends above its floor.
    pub(super) fn least_entry_m(&self) -> f64 {
        self.floor_m + (-self.climb_m).max(0.0) + RECOVERY_M * f64::from(self.climb_m < 0.0)
    }
}

/// Height for the recovery from a descent, m: 500 ft.
const RECOVERY_M: f64 = 500.0 * FOOT_M;
