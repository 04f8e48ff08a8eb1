//! What moves the machine: free motion, or time stepping where planes push.

use super::signal::{Side, Signal};
use crate::mistake::Mistake;
use crate::start::stopped;
use identify::machine::{
    Impact, Machine, Rollout, RolloutOptions, Simulated, SolveError, Stepping, SteppingOptions,
};

/// A machine in motion.
pub(super) enum Mover<'a> {
    /// No contact: RK4.
    Free(Rollout<'a>),
    /// Contacts open and close.
    Touching(Box<Stepping<'a>>),
}

impl<'a> Mover<'a> {
    /// With steps of at most `max_step` s, and impacts at their instants if they shall be exact.
    pub fn new(
        machine: &'a Machine,
        parameters: &'a [f64],
        max_step: f64,
        exact_impacts: bool,
    ) -> Self {
        if machine.contact_count() > 0 {
            let options = SteppingOptions {
                max_step,
                exact_impacts,
                ..SteppingOptions::default()
            };
            return Self::Touching(Box::new(Stepping::new(machine, parameters, options)));
        }
        let options = RolloutOptions {
            max_step,
            ..RolloutOptions::default()
        };
        Self::Free(Rollout::new(machine, parameters, options))
    }

    /// From `t` to `end`, with a stop at every corner of the inputs on the way.
    pub fn advance(
        &mut self,
        simulated: &mut Simulated,
        signal: &Signal,
        mut t: f64,
        end: f64,
    ) -> Result<(), Mistake> {
        let column = |values: Vec<f64>| values.into_iter().map(|value| vec![value]).collect();
        while t < end {
            let next = signal.next_corner(t).min(end);
            let from: Vec<Vec<f64>> = column(signal.all(t, Side::After));
            let to: Vec<Vec<f64>> = column(signal.all(next, Side::Before));
            self.straight(simulated, t, next - t, (&from, &to))
                .map_err(|error| stopped(error, t))?;
            t = next;
        }
        Ok(())
    }

    fn straight(
        &mut self,
        simulated: &mut Simulated,
        t: f64,
        duration: f64,
        (from, to): (&[Vec<f64>], &[Vec<f64>]),
    ) -> Result<(), SolveError> {
        match self {
            Self::Free(rollout) => rollout.advance(simulated, &[t], duration, from, to),
            Self::Touching(stepping) => stepping.advance(simulated, t, duration, from, to),
        }
    }

    /// Impacts since they were last taken, if they are exact.
    pub fn take_impacts(&mut self) -> Vec<Impact> {
        match self {
            Self::Free(_) => Vec::new(),
            Self::Touching(stepping) => stepping.take_impacts(),
        }
    }

    /// Impulses of the contacts since they were last taken, N s.
    pub fn take_impulses(&mut self) -> Vec<f64> {
        match self {
            Self::Free(_) => Vec::new(),
            Self::Touching(stepping) => stepping.take_impulse().as_slice().to_vec(),
        }
    }
}
