//! Time stepping: contacts open and close without an instant that is looked for.
//!
//! A step of `h` seconds has three parts. Where free motion would enter no plane it is that of a
//! [`Rollout`] (RK4). Else, with `P` what a force does to the acceleration under the constraints,
//!
//! 1. *impact*: `v′ = v + P Jᵀ p`. A contact that would be entered leaves with `wₙ ≥ −e wₙ⁻`
//!    (Newton); one without restitution slows to `wₙ ≥ −g/h`, with which it arrives at the end of
//!    the step. What happens, happens at the beginning: outside of the plane, so that no energy
//!    comes from being inside.
//! 2. *contact*: `v⁺ = v′ + h a + P Jᵀ p` by the midpoint rule: `a`, `P` and `J` are those halfway,
//!    where the same equation over half of the step has led. Positions move with the mean of `v′` and
//!    `v⁺`; normally it is that mean which ends on the plane: `(wₙ′ + wₙ⁺)/2 ≥ −g/h`.
//! 3. *projection*: before the next step, what is inside of a plane by curvature is moved onto it,
//!    and onto the holonomic constraints, by the shortest way in the metric of `M`. Velocities stay.
//!
//! Impulses never give energy: `p·(w⁺ + w⁻)/2 ≤ 0`. Without restitution that follows from the laws
//! for an impact; with it, several contacts with friction could gain (Kane's example), and get back
//! less. Over a step, friction that ends a slip and then holds against forces would push along it
//! on the mean; it is mixed with that of the mean velocities, which cannot.
//!
//! A step in which contacts turn out elsewhere than they were to be is done in shorter ones (`resolved.rs`).
//!
//! Asked for ([`SteppingOptions::exact_impacts`]), an impact that ends free motion happens at its instant.
//!
//! Moreau's method with the projection of Acary (Comput. Methods Appl. Mech. Eng. 256, 2013).

use super::located::Impact;
use super::solve::Problem;
use super::terms::ContactTerms;
use super::view::View;
use crate::machine::{Machine, Rollout, RolloutOptions, Simulated, SolveError};
use nalgebra::DVector;

/// How to step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SteppingOptions {
    /// The largest step, s.
    pub max_step: f64,
    /// Baumgarte's `ω` of the constraints, rad/s.
    pub stabilisation: f64,
    /// Whether an impact that ends free motion is looked for, to round-off of its time
    /// ([`Stepping::take_impacts`]). It costs some ten evaluations of the motion a step.
    pub exact_impacts: bool,
}

impl Default for SteppingOptions {
    fn default() -> Self {
        Self {
            max_step: 1e-3,
            stabilisation: RolloutOptions::default().stabilisation,
            exact_impacts: false,
        }
    }
}

/// Inputs over a stretch of time, linear from one end to the other.
pub(super) struct Drive<'u> {
    start: f64,
    duration: f64,
    from: &'u [Vec<f64>],
    to: &'u [Vec<f64>],
}

impl Drive<'_> {
    /// One column each, at a time.
    pub fn at(&self, t: f64) -> Vec<Vec<f64>> {
        let share = (t - self.start) / self.duration;
        let both = self.from.iter().zip(self.to);
        both.map(|(a, b)| vec![a[0] + share * (b[0] - a[0])])
            .collect()
    }
}

/// A machine with contacts in motion.
pub struct Stepping<'a> {
    pub(super) machine: &'a Machine,
    pub(super) parameters: &'a [f64],
    options: SteppingOptions,
    pub(super) free: Rollout<'a>,
    /// Of the last step, where the next solution is looked for, N s.
    pub(super) pressed: DVector<f64>,
    pub(super) impulse: DVector<f64>,
    pub(super) impacts: Vec<Impact>,
    sweeps: usize,
    relaxed: usize,
}

impl<'a> Stepping<'a> {
    /// Of `machine` with `parameters`.
    pub fn new(machine: &'a Machine, parameters: &'a [f64], options: SteppingOptions) -> Self {
        let nothing = DVector::zeros(3 * machine.contact_count());
        Self {
            machine,
            parameters,
            options,
            free: Rollout::new(
                machine,
                parameters,
                RolloutOptions {
                    max_step: options.max_step,
                    stabilisation: options.stabilisation,
                },
            ),
            pressed: nothing.clone(),
            impulse: nothing,
            impacts: Vec::new(),
            sweeps: 0,
            relaxed: 0,
        }
    }

    /// Impulses of the contacts since they were last taken, N s, `3c`: along each plane's axes, then
    /// its normal.
    pub fn take_impulse(&mut self) -> DVector<f64> {
        let nothing = DVector::zeros(self.impulse.len());
        std::mem::replace(&mut self.impulse, nothing)
    }

    /// Impacts since they were last taken, in the order of time, where
    /// [`SteppingOptions::exact_impacts`] asks for them.
    pub fn take_impacts(&mut self) -> Vec<Impact> {
        std::mem::take(&mut self.impacts)
    }

    /// Moves a state out of planes and onto the holonomic constraints, as before every step. By
    /// how much, in the coordinates' units.
    ///
    /// # Errors
    /// If the equation of motion has no solution there.
    pub fn push_out(
        &mut self,
        state: &mut Simulated,
        t: f64,
        input: &[Vec<f64>],
    ) -> Result<f64, SolveError> {
        let before = state.q.clone();
        self.projected(state, t, input)?;
        let gaps = before.iter().zip(&state.q);
        Ok(gaps.fold(0.0_f64, |most, (a, b)| most.max((a[0] - b[0]).abs())))
    }

    /// Sweeps over the contacts and steps of Newton's method so far: what the solutions cost.
    pub fn sweeps(&self) -> usize {
        self.sweeps
    }

    /// How many solutions are those of the associated law, where none of Coulomb's was found.
    pub fn relaxed(&self) -> usize {
        self.relaxed
    }

    /// Advances one window from `start` by `duration` seconds, with inputs linear between
    /// `u_start` and `u_end`: as [`Rollout::advance`]. It ends outside of all planes.
    ///
    /// # Errors
    /// If the equation of motion, or a contact problem on the way, has no solution.
    pub fn advance(
        &mut self,
        state: &mut Simulated,
        start: f64,
        duration: f64,
        u_start: &[Vec<f64>],
        u_end: &[Vec<f64>],
    ) -> Result<(), SolveError> {
        let steps = (duration / self.options.max_step).ceil().max(1.0) as usize;
        let h = duration / steps as f64;
        let drive = Drive {
            start,
            duration,
            from: u_start,
            to: u_end,
        };
        if state.z.len() != self.machine.state_count() {
            let at = self.free.states(state, vec![start], u_start.to_vec());
            state.z = self.machine.initial_states(&at, self.parameters);
        }
        for step in 0..steps {
            let t = start + step as f64 / steps as f64 * duration;
            match self.options.exact_impacts {
                true => self.step_to_impacts(state, (t, h), &drive)?,
                false => self.resolved_step(state, (t, h), &drive)?,
            }
        }
        if self.pressed.amax() > 0.0 {
            self.projected(state, start + duration, u_end)?;
        }
        Ok(())
    }

    /// One step of `h` s from `t` on. How contacts were before they pressed, if any did.
    pub(super) fn step(
        &mut self,
        state: &mut Simulated,
        (t, h): (f64, f64),
        drive: &Drive<'_>,
    ) -> Result<Option<ContactTerms>, SolveError> {
        let input = drive.at(t);
        let view = self.projected(state, t, &input)?;
        let entered = view.entered(h);
        if !entered.contains(&true) {
            self.fly(state, (t, h), drive)?;
            return Ok(None);
        }
        let view = match self.struck(&view, &entered, h)? {
            None => view,
            Some(impulse) => {
                self.collide(state, &view, &impulse);
                self.view(state, t, &input)?
            }
        };
        let middle = t + h / 2.0;
        self.press(state, &view, h, (middle, &drive.at(middle)))?;
        Ok(Some(view.contacts))
    }

    /// Free motion for `h` s from `t` on.
    pub(super) fn fly(
        &mut self,
        state: &mut Simulated,
        (t, h): (f64, f64),
        drive: &Drive<'_>,
    ) -> Result<(), SolveError> {
        self.pressed.fill(0.0);
        self.free
            .advance(state, &[t], h, &drive.at(t), &drive.at(t + h))
    }

    /// Impulses under which contacts that move with `free` without them move with at least `floor`
    /// along their normals.
    pub(super) fn solve(
        &mut self,
        view: &View,
        free: &DVector<f64>,
        floor: &DVector<f64>,
        guess: DVector<f64>,
    ) -> Result<DVector<f64>, SolveError> {
        let mut velocity = free.clone();
        floor
            .iter()
            .enumerate()
            .for_each(|(i, floor)| velocity[3 * i + 2] -= floor);
        let problem = Problem {
            mobility: &view.mobility,
            velocity: &velocity,
            friction: &view.contacts.friction,
        };
        self.solution(&problem, guess)
    }

    pub(super) fn solution(
        &mut self,
        problem: &Problem<'_>,
        guess: DVector<f64>,
    ) -> Result<DVector<f64>, SolveError> {
        let pinched = SolveError::Pinched { sample: 0 };
        let solution = problem.solve(guess).ok_or(pinched)?;
        self.sweeps += solution.sweeps;
        self.relaxed += usize::from(solution.relaxed);
        Ok(solution.impulse)
    }

    /// Moves the positions of one window by velocities for `h` seconds, or by a displacement.
    pub(super) fn move_by(&self, q: &mut [Vec<f64>], velocities: &DVector<f64>, h: f64) {
        let velocities: Vec<Vec<f64>> = velocities.iter().map(|&v| vec![v]).collect();
        self.machine.move_positions(q, &velocities, h);
    }

    pub(super) fn view(
        &self,
        state: &Simulated,
        t: f64,
        input: &[Vec<f64>],
    ) -> Result<View, SolveError> {
        let states = self.free.states(state, vec![t], input.to_vec());
        let states = self.machine.at_rest(&states, self.parameters);
        let stabilised = |_: usize, terms: &mut _| self.free.stabilise(terms);
        let mut motions = self
            .machine
            .motion_with(&states, self.parameters, stabilised)?;
        let mut contacts = self.machine.contact_terms(&states, self.parameters);
        View::new(states, motions.remove(0), contacts.remove(0))
    }
}

/// One column per value, of one window.
pub(super) fn put(columns: &mut [Vec<f64>], values: &DVector<f64>) {
    let both = columns.iter_mut().zip(values.iter());
    both.for_each(|(column, value)| column[0] = *value);
}
