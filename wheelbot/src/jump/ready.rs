//! A robot that lies on a floor and knows its bias.

use super::floor::{Conditions, Floor};
use super::plans::Steps;
use super::run::{Jumped, Jumper};
use crate::sensing::Sensing;
use crate::trial::Trial;
use dynamics::constrained;
use identify::machine::SolveError;
use wheelbot_firmware::Gains;

/// It has balanced for ten seconds, as the robot does before it is laid down.
#[derive(Debug, Clone)]
pub struct Ready {
    /// Where it lies, and what it weighs.
    pub conditions: Conditions,
    gains: Gains<f64>,
    bias: [f64; 2],
    /// With the noise to come.
    sensing: Sensing,
}

impl Ready {
    /// Finds the bias.
    ///
    /// # Errors
    /// If the equation of motion has no solution while it balances.
    pub fn new(
        conditions: Conditions,
        gains: Gains<f64>,
        mut sensing: Sensing,
    ) -> Result<Self, constrained::SolveError> {
        let calm = Trial::new(0.0, gains).calibrated(&mut sensing)?;
        Ok(Self {
            conditions,
            gains,
            bias: calm.bias,
            sensing,
        })
    }

    /// Its way up, for some seconds; the same whenever it is asked for.
    ///
    /// # Errors
    /// If the equation of motion or the contacts have no solution on the way.
    pub fn run(&self, floor: &Floor, steps: &Steps, seconds: f64) -> Result<Jumped, SolveError> {
        let jumper = Jumper {
            way: steps.way,
            conditions: self.conditions.clone(),
            plan: steps.plan(),
            gains: self.gains,
            bias: self.bias,
            seconds,
        };
        jumper.run(floor, &mut self.sensing.clone())
    }
}
