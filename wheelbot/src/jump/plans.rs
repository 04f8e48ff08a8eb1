//! The feed-forward of both ways up, in a few numbers each.

use super::floor::Way;
use std::f64::consts::{FRAC_PI_2, FRAC_PI_6};
use wheelbot_firmware::Plan;
use wheelbot_firmware::jump::{HandOver, Segment};

/// The wheel is brought to this rate before a strong pulse, against its direction, rad/s (6.4.2),
pub const SPUN: f64 = 290.0;
/// with so much current, A (the robot's own).
const SPINNING: f64 = 5.0;

/// A strong pulse.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pulse {
    /// A.
    pub current: f64,
    /// s.
    pub seconds: f64,
    /// Its end falls to nothing over this time, s.
    pub easing: f64,
}

/// What a plan is made from.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Steps {
    /// By which angle.
    pub way: Way,
    /// The pulse of either step.
    pub pulses: [Pulse; 2],
    /// Current that brakes the wheel behind the first pulse, A: before a rolling wheel lands.
    pub brake: f64,
    /// Within which angles of the way's the controllers of roll and pitch take over, rad.
    pub hand_over: [f64; 2],
}

/// When the first pulse begins, s.
pub const FIRST: f64 = 0.8;
/// From there to the pause, s.
const STEP: f64 = 0.9;
/// How long the reaction wheel is brought to its rate again, s.
const SPIN: f64 = 0.9;
/// How long the robot pauses before it rolls up, s: until its estimate settles (6.4.2).
const PAUSE: f64 = 1.5;

impl Steps {
    /// When the second pulse begins, s.
    pub fn second(&self) -> f64 {
        FIRST
            + STEP
            + match self.way {
                Way::Roll => SPIN,
                Way::Pitch => PAUSE,
            }
    }

    /// The plan of the robot's controller.
    pub fn plan(&self) -> Plan<f64> {
        let [first, second] = self.pulses;
        let by_rolling = self.way == Way::Pitch;
        let paused = FIRST + STEP;
        let none = |until| segment(until, 0.0, 0.0, f64::INFINITY);
        let spin = |until| segment(until, -SPINNING, 0.0, SPUN);
        let pulse = |from: f64, pulse: Pulse| {
            segment(
                from + pulse.seconds,
                pulse.current,
                pulse.easing,
                f64::INFINITY,
            )
        };
        let between = match self.way {
            // Spun again, against the edge that it rests on.
            Way::Roll => [none(paused), spin(self.second())],
            Way::Pitch => [segment(paused, -self.brake, 0.0, 0.0), none(self.second())],
        };
        Plan {
            by_rolling,
            segments: [
                spin(FIRST - 0.1),
                none(FIRST),
                pulse(FIRST, first),
                between[0],
                between[1],
                pulse(self.second(), second),
            ],
            begin: match self.way {
                Way::Roll => paused,
                Way::Pitch => 0.0,
            },
            first: match self.way {
                Way::Roll => FRAC_PI_6,
                Way::Pitch => FRAC_PI_2,
            },
            second: self.second(),
            hand_over: self.hand_over.map(|within| HandOver {
                by_pitch: by_rolling,
                within,
            }),
        }
    }
}

fn segment(until: f64, current: f64, easing: f64, fastest: f64) -> Segment<f64> {
    Segment {
        until,
        current,
        easing,
        fastest,
    }
}

/// Currents and times as the robot has them (wheelbot-v2.5, e8aebc5), without the second quarter sine.
pub fn published(way: Way) -> Steps {
    let pulse = |current, seconds, easing| Pulse {
        current,
        seconds,
        easing,
    };
    match way {
        Way::Roll => Steps {
            way,
            pulses: [pulse(15.56, 0.30, 0.05), pulse(14.53, 0.30, 0.10)],
            brake: 0.0,
            hand_over: [0.1, 0.3],
        },
        Way::Pitch => Steps {
            way,
            pulses: [pulse(14.93, 0.35, 0.10), pulse(6.0, 0.10, 0.0)],
            brake: 5.6,
            hand_over: [0.3, 0.05],
        },
    }
}

/// With pulses that the robot gets up by: found by optimisation over the simulation, from [`published`] on. The programs
/// `plan-stand-up` and `plan-roll-up` print them.
pub fn found(way: Way) -> Steps {
    let start = published(way);
    let [first, second] = start.pulses;
    let pulse = |pulse: Pulse, current, seconds| Pulse {
        current,
        seconds,
        ..pulse
    };
    match way {
        Way::Roll => Steps {
            pulses: [pulse(first, 12.21, 0.2212), pulse(second, 13.39, 0.2075)],
            ..start
        },
        Way::Pitch => Steps {
            pulses: [pulse(first, 14.26, 0.2218), pulse(second, 7.077, 0.0659)],
            brake: 13.68,
            ..start
        },
    }
}
