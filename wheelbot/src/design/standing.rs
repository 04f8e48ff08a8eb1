//! Where a model of the robot stands still: the tilt at which nothing pulls it over.

use super::plane::DesignError;
use crate::robot::{self, PITCH, ROLL};
use dynamics_codegen::Compiled;
use identify::machine::{Lineariser, States};
use nalgebra::{Matrix2, Vector2};

/// Newton's steps at most, and the tilt that one changes by at the end, rad.
const STEPS: usize = 20;
const SETTLED: f64 = 1e-12;
/// By which slopes are taken, rad.
const PROBE: f64 = 1e-6;

/// A model of the robot at rest in balance.
#[derive(Debug, Clone)]
pub struct Standing {
    /// The model.
    pub lineariser: Lineariser,
    /// Its roll and pitch, rad.
    pub tilt: [f64; 2],
}

impl Standing {
    /// Where the accelerations of roll and pitch vanish, near upright.
    ///
    /// # Errors
    /// If the equation of motion has no solution there, or the robot stands nowhere.
    pub fn of(compiled: Compiled) -> Result<Self, DesignError> {
        let mut standing = Self {
            lineariser: Lineariser::new(compiled),
            tilt: [0.0; 2],
        };
        for _ in 0..STEPS {
            let pulled = standing.pulled(standing.tilt)?;
            let slope = |k: usize| -> Result<Vector2<f64>, DesignError> {
                let mut aside = standing.tilt;
                aside[k] += PROBE;
                Ok((standing.pulled(aside)? - pulled) / PROBE)
            };
            let slopes = Matrix2::from_columns(&[slope(0)?, slope(1)?]);
            let step = slopes.lu().solve(&pulled).ok_or(DesignError::Nowhere)?;
            standing.tilt[0] -= step[0];
            standing.tilt[1] -= step[1];
            if step.amax() < SETTLED {
                return Ok(standing);
            }
        }
        Err(DesignError::Nowhere)
    }

    /// The state at rest at a tilt.
    pub fn states(&self, [roll, pitch]: [f64; 2]) -> States {
        let state = robot::leaning(roll, pitch);
        let column = |values: &[f64]| values.iter().map(|&x| vec![x]).collect();
        States {
            t: vec![0.0],
            q: column(&state.q),
            v: column(&state.v),
            u: vec![vec![0.0]; self.lineariser.machine().input_count()],
            ..States::default()
        }
    }

    /// Accelerations of roll and pitch at rest, rad/s².
    fn pulled(&self, tilt: [f64; 2]) -> Result<Vector2<f64>, DesignError> {
        let machine = self.lineariser.machine();
        let states = machine.at_rest(&self.states(tilt), &machine.nominal_parameters());
        let motion = &machine.motion(&states, &machine.nominal_parameters())?[0];
        Ok(Vector2::new(
            motion.acceleration[ROLL],
            motion.acceleration[PITCH],
        ))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use dynamics_codegen::{Library, compile};

    /// Of plane statics: the centre of mass of all that pitches stands above the axle.
    #[test]
    fn it_leans_so_that_its_centre_of_mass_is_above_the_axle() {
        let text = include_str!("../../../models/wheelbot.model");
        let text = text.replace("parameter b_x: m = 0;", "parameter b_x: m = 0.005;");
        let compiled = compile("wheelbot.model", &text, &Library::builtin()).unwrap();
        let [roll, pitch] = Standing::of(compiled).unwrap().tilt;
        let (body, reaction) = (0.75, 0.3);
        let up = body * 0.055 + reaction * 0.11;
        assert!(
            (pitch + (body * 0.005_f64).atan2(up)).abs() < 1e-9,
            "{pitch}"
        );
        assert!(roll.abs() < 1e-12, "{roll}");
    }
}
