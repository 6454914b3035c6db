//! What is flown: segments of a flight and the manoeuvres in them.

use std::sync::Arc;

use rand_chacha::ChaCha8Rng;

use super::inputs::{Hand, InputKind, InputSignal};
use super::vehicle::Surface;
use crate::propulsion::EngineInput;

/// A stretch of flight.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Segment {
    /// Start, s.
    pub start_s: f64,
    /// Phase of flight it belongs to.
    pub phase: &'static str,
    /// What the pilot does.
    pub task: Task,
    /// Heading to hold, rad.
    pub heading_rad: f64,
}

/// What the pilot does.
#[derive(Clone, Copy, Debug, PartialEq)]
#[expect(missing_docs, reason = "names say it")]
pub enum Task {
    /// Rolls at a speed, or stands on the brakes at zero.
    Ground {
        /// Speed over the ground, m/s.
        speed_m_s: f64,
        /// Engine inputs.
        engines: [EngineInput; 2],
    },
    /// Accelerates and lifts off.
    TakeOff {
        /// Engine inputs.
        engines: [EngineInput; 2],
        /// Airspeed of rotation, m/s.
        rotate_m_s: f64,
    },
    /// Climbs, pitch holding the airspeed, until the altitude is near; then levels.
    Climb {
        altitude_m: f64,
        /// True airspeed, m/s.
        airspeed_m_s: f64,
        /// Engine inputs.
        engines: [EngineInput; 2],
    },
    /// Holds an altitude, or goes to it.
    Level {
        altitude_m: f64,
        /// Greatest rate of climb or descent, m/s.
        rate_m_s: f64,
        power: Power,
    },
    /// Comes down to the ground, flares, brakes.
    Land {
        /// True airspeed of the approach, m/s.
        airspeed_m_s: f64,
        /// Rate of descent, m/s.
        rate_m_s: f64,
        /// Engine inputs once over the threshold.
        engines: [EngineInput; 2],
    },
}

/// How power is set.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Power {
    /// At given inputs; airspeed follows.
    Fixed([EngineInput; 2]),
    /// Manifold pressure so that a true airspeed (m/s) is held, at a given engine speed (rad/s).
    Airspeed {
        /// True airspeed, m/s.
        airspeed_m_s: f64,
        /// Engine speed, rad/s.
        speed_rad_s: f64,
    },
}

/// Who moves the flight controls during a designed input.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Hands {
    /// Nobody: they are held where they were, and the deflections of the input are added.
    #[default]
    Held,
    /// The pilot, who holds altitude and heading.
    Level,
    /// The pilot, who holds airspeed and heading at the angles of sideslip of the input.
    Sideslip,
    /// The pilot, who holds the airspeed at the bank angles of the input.
    Turn,
}

/// An input on any controls at once, given node by node.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct DesignedInput {
    /// Name of its window.
    pub name: String,
    /// Times of the nodes after the onset, s, in order.
    pub time_s: Vec<f64>,
    /// Deflections of aileron, elevator and rudder about where the controls are held, rad, straight lines from node to node.
    pub deflections_rad: Vec<[f64; 3]>,
    /// Manifold pressure of all engines about that of the steady flight before it, Pa; empty where power stays.
    pub manifold_pa: Vec<f64>,
    /// Who moves the flight controls.
    pub hands: Hands,
    /// Angle the pilot brings about, rad: of sideslip or of bank; empty where the controls are held or the flight is level.
    pub angle_rad: Vec<f64>,
    /// Controls held from the onset on, s.
    pub held_s: f64,
}

impl DesignedInput {
    /// Controls it moves.
    pub fn surfaces(&self) -> impl Iterator<Item = Surface> + '_ {
        let moves = |surface: &Surface| self.deflections_rad.iter().any(|node| node[*surface as usize] != 0.0);
        Surface::ALL.into_iter().filter(moves)
    }
}

/// A manoeuvre to fly.
#[derive(Clone, Debug, PartialEq)]
pub struct Manoeuvre {
    /// Control; a multisine moves all three.
    pub surface: Surface,
    /// Shape.
    pub kind: InputKind,
    /// Amplitude of the first pulse, rad.
    pub amplitude_rad: f64,
    /// Base time, s.
    pub dt_s: f64,
    /// Onset of the input, s.
    pub onset_s: f64,
    /// Hand that flies it.
    pub hand: Hand,
    /// Flown badly on purpose: to be discarded.
    pub spoilt: bool,
    /// Test point it belongs to.
    pub test_point: u8,
    /// The input where it is given node by node: kind [`InputKind::Designed`].
    pub designed: Option<Arc<DesignedInput>>,
}

/// A manoeuvre with its input as the hand flies it.
#[derive(Clone, Debug, PartialEq)]
pub struct Flown {
    /// What was to be flown.
    pub manoeuvre: Manoeuvre,
    /// What is flown on aileron, elevator and rudder.
    pub signals: [InputSignal; 3],
    /// Change of the manifold pressure, Pa.
    pub manifold_pa: InputSignal,
    /// Angle the pilot brings about, rad.
    pub angle_rad: InputSignal,
}

impl Flown {
    /// What is flown on one control.
    pub fn signal(&self, surface: Surface) -> &InputSignal {
        &self.signals[surface as usize]
    }

    /// Who moves the flight controls.
    pub fn hands(&self) -> Hands {
        self.manoeuvre.designed.as_ref().map_or(Hands::Held, |input| input.hands)
    }

    /// Time of the return to zero after the onset, s.
    pub fn duration_s(&self) -> f64 {
        let all = self.signals.iter().chain([&self.manifold_pa, &self.angle_rad]);
        all.map(InputSignal::duration_s).fold(0.0, f64::max)
    }
}

impl Manoeuvre {
    /// Steady flight, controls held, before the onset, s (thesis section 4.4.1: 2 to 3 s).
    pub const RUN_IN_S: f64 = 3.0;
    /// Controls held from the onset of a hand-flown input on, s: input and free response.
    pub const FREE_S: f64 = 9.5;
    /// The same of a multisine, s.
    pub(crate) const MULTISINE_FREE_S: f64 = 27.0;
    /// Controls held behind the end of a sweep, s.
    pub(crate) const SWEEP_REST_S: f64 = 6.0;
    /// What the control sensors record before the controls are held, and after they are released, s.
    pub const MARGIN_S: f64 = 0.5;

    /// Start of the held controls, s. A designed input has its steady flight in itself: its controls are held from its onset on.
    pub fn held_from_s(&self) -> f64 {
        match self.kind {
            InputKind::Designed => self.onset_s,
            _ => self.onset_s - Self::RUN_IN_S,
        }
    }

    /// End of the held controls, s.
    pub fn held_to_s(&self) -> f64 {
        let free_s = match self.kind {
            InputKind::Designed => self.designed.as_ref().map_or(0.0, |input| input.held_s),
            InputKind::Multisine => Self::MULTISINE_FREE_S,
            kind if kind.is_sweep() => InputSignal::sweep_length_s(self.dt_s) + Self::SWEEP_REST_S,
            _ => Self::FREE_S,
        };
        self.onset_s + free_s
    }

    /// Interval the control sensors record, s.
    pub fn recorded_s(&self) -> (f64, f64) {
        (self.held_from_s() - Self::MARGIN_S, self.held_to_s() + Self::MARGIN_S)
    }

    /// The input as the hand flies it.
    pub fn fly(&self, rng: &mut ChaCha8Rng) -> Flown {
        let mut signals = [InputSignal::NONE; 3];
        let (mut manifold_pa, mut angle_rad) = (InputSignal::NONE, InputSignal::NONE);
        if let Some(input) = &self.designed {
            let signal =
                |values: &[f64]| InputSignal::from_nodes(input.time_s.iter().copied().zip(values.iter().copied()));
            (manifold_pa, angle_rad) = (signal(&input.manifold_pa), signal(&input.angle_rad));
            for surface in Surface::ALL {
                let nodes = input.time_s.iter().zip(&input.deflections_rad);
                let nodes = nodes.map(|(time_s, deflections)| (*time_s, deflections[surface as usize]));
                signals[surface as usize] = InputSignal::from_nodes(nodes);
            }
        } else if self.kind == InputKind::Multisine {
            signals = InputSignal::multisines(self.dt_s, self.amplitude_rad);
        } else {
            signals[self.surface as usize] = InputSignal::new(self.kind, self.dt_s, self.amplitude_rad, self.hand, rng);
        }
        Flown { manoeuvre: self.clone(), signals, manifold_pa, angle_rad }
    }
}
