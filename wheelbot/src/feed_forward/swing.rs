//! The pirouette's swing, on robots that stand and know their bias.

use super::search::{Effort, Least, Variable, least};
use super::together;
use crate::excitation::Excitation;
use crate::motors::STALL_TORQUE;
use crate::robot::{PITCH, ROLL, YAW};
use crate::sensing::Sensing;
use crate::studies::StudyError;
use crate::studies::pirouette::{ASIDE, TIME, turned};
use crate::trial::{FALLEN, Outcome, Trial};
use dynamics::constrained::SolveError;
use rayon::prelude::*;
use std::f64::consts::{FRAC_PI_2, TAU};
use wheelbot_firmware::{Gains, INTERVAL};

/// How many robots each swing is tried on.
const ROBOTS: u64 = 2;
/// Added to the seed of each one's noise and biases: far from those of any study.
const NOISE: u64 = 1 << 40;
/// Turns that are wanted: some more than three.
const WANTED: f64 = 3.2;
/// What is left of the turn in the end costs so much, per rad/s,
const LEFT: f64 = 0.1;
/// the largest tilt per rad,
const TILT: f64 = 0.5;
/// and the torque of two stalled motors per second.
const TORQUE: f64 = 0.1;

/// What is looked for, with where it begins: both wheels in quadrature at a moderate rate, and the turn stopped late.
pub const VARIABLES: [Variable; 5] = [
    Variable {
        name: "frequency, Hz",
        start: 2.0,
        within: [0.5, 4.0],
    },
    Variable {
        name: "phase, rad",
        start: FRAC_PI_2,
        within: [0.0, TAU],
    },
    Variable {
        name: "torque of the reaction wheel, N·m",
        start: 0.2,
        within: [0.05, 0.8],
    },
    Variable {
        name: "torque of the rolling wheel, N·m",
        start: 0.1,
        within: [0.02, 0.6],
    },
    Variable {
        name: "turning point, share of the time",
        start: 0.6,
        within: [0.4, 0.9],
    },
];

/// A swing of values of [`VARIABLES`].
fn swing(values: &[f64]) -> Excitation {
    Excitation {
        at: ASIDE,
        seconds: TIME,
        frequency: values[0],
        phase: values[1],
        torque: [values[2], values[3]],
        turning_point: values[4],
    }
}

/// Standing robots that know their bias, with their noise to come.
pub struct Scenes {
    robots: Vec<(Trial, Sensing)>,
}

impl Scenes {
    /// With other noise and biases each.
    ///
    /// # Errors
    /// [`StudyError`].
    pub fn new(gains: Gains<f64>, seed: u64) -> Result<Self, StudyError> {
        let noise = NOISE.wrapping_add(seed.wrapping_mul(100));
        let robot = |k| -> Result<(Trial, Sensing), StudyError> {
            let mut sensing = Sensing::new(noise.wrapping_add(k))?;
            let trial = Trial::new(TIME + 2.0 * ASIDE, gains);
            Ok((trial.calibrated(&mut sensing)?, sensing))
        };
        Ok(Self {
            robots: (0..ROBOTS).map(robot).collect::<Result<_, _>>()?,
        })
    }

    /// The first robot's motion by a swing.
    ///
    /// # Errors
    /// [`StudyError`], if it comes to a state without a motion.
    pub fn shown(&self, swing: Excitation) -> Result<Outcome, StudyError> {
        let (trial, sensing) = &self.robots[0];
        Ok(moved(trial, sensing, swing)?)
    }

    /// What a swing costs.
    ///
    /// # Errors
    /// [`StudyError`], if a run comes to a state without a motion.
    pub fn cost(&self, swing: Excitation) -> Result<f64, StudyError> {
        let cost = |(trial, sensing): &(Trial, Sensing)| -> Result<f64, StudyError> {
            Ok(cost(&moved(trial, sensing, swing)?, trial.seconds))
        };
        let costs: Result<Vec<f64>, _> = self.robots.par_iter().map(cost).collect();
        Ok(together(&costs?))
    }

    /// Looks for it.
    ///
    /// # Errors
    /// As [`Scenes::cost`].
    pub fn least(&self, effort: Effort) -> Result<(Excitation, Least), StudyError> {
        let found = least(&VARIABLES, effort, &|values| self.cost(swing(values)))?;
        Ok((swing(&found.values), found))
    }
}

fn moved(trial: &Trial, sensing: &Sensing, swing: Excitation) -> Result<Outcome, SolveError> {
    let trial = Trial {
        excitations: vec![swing],
        ..trial.clone()
    };
    trial.run(&mut sensing.clone())
}

/// Of who falls: more than of any who stands, by how soon. Of who stands: turns that lack, what is left of the turn, tilt
/// and torque.
fn cost(outcome: &Outcome, seconds: f64) -> f64 {
    let rows = &outcome.rows;
    let stood = rows.len() as f64 * INTERVAL;
    if outcome.fell {
        return WANTED + 2.0 + seconds - stood;
    }
    let lack = (WANTED - turned(outcome, TIME).abs()).max(0.0);
    let left = rows.last().map_or(0.0, |row| row.state.v[YAW].abs());
    let tilts = rows
        .iter()
        .map(|row| row.state.q[ROLL].abs().max(row.state.q[PITCH].abs()));
    let tilt = tilts.fold(0.0, f64::max).min(FALLEN);
    let torques = rows.iter().flat_map(|row| [row.inputs[0], row.inputs[1]]);
    let torque: f64 = torques.map(|u| (u / STALL_TORQUE).powi(2) * INTERVAL).sum();
    lack + LEFT * left + TILT * tilt + TORQUE * torque
}
