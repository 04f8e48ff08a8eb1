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
//! Moreau's method with the projection of Acary (Comput. Methods Appl. Mech. Eng. 256, 2013).

use super::solve::Problem;
use super::terms::ContactTerms;
use super::view::View;
use crate::machine::rollout::remembered;
use crate::machine::{Machine, Rollout, RolloutOptions, Simulated, SolveError};
use nalgebra::{DMatrix, DVector};

/// How to step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SteppingOptions {
    /// The largest step, s.
    pub max_step: f64,
    /// Baumgarte's `ω` of the constraints, rad/s.
    pub stabilisation: f64,
}

impl Default for SteppingOptions {
    fn default() -> Self {
        Self {
            max_step: 1e-3,
            stabilisation: RolloutOptions::default().stabilisation,
        }
    }
}

/// A contact that approaches slower than this is pressed, not hit, m/s.
const RESTING: f64 = 1e-6;
/// This far inside of a plane, or off a constraint, is not worth a projection, m.
const INSIDE: f64 = 1e-11;
/// A projection that moves a coordinate further is followed by another one.
const FAR: f64 = 1e-8;
/// Projections in one step at most.
const PROJECTIONS: usize = 20;

/// A machine with contacts in motion.
pub struct Stepping<'a> {
    machine: &'a Machine,
    parameters: &'a [f64],
    options: SteppingOptions,
    free: Rollout<'a>,
    /// Of the last step, where the next solution is looked for, N s.
    pressed: DVector<f64>,
    impulse: DVector<f64>,
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
    /// `u_start` and `u_end`: as [`Rollout::advance`].
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
        let input = |share: f64| -> Vec<Vec<f64>> {
            let both = u_start.iter().zip(u_end);
            both.map(|(a, b)| vec![a[0] + share * (b[0] - a[0])])
                .collect()
        };
        if state.z.len() != self.machine.state_count() {
            let at = self.free.states(state, vec![start], u_start.to_vec());
            state.z = self.machine.initial_states(&at, self.parameters);
        }
        for step in 0..steps {
            let shares = [0.0, 0.5, 1.0].map(|part| (step as f64 + part) / steps as f64);
            let times = shares.map(|share| start + share * duration);
            self.step(state, h, times, &shares.map(input))?;
        }
        Ok(())
    }

    /// One step; times and inputs at its beginning, middle and end.
    fn step(
        &mut self,
        state: &mut Simulated,
        h: f64,
        times: [f64; 3],
        inputs: &[Vec<Vec<f64>>; 3],
    ) -> Result<(), SolveError> {
        let view = self.projected(state, times[0], &inputs[0])?;
        let entered = view.entered(h);
        if !entered.contains(&true) {
            self.pressed.fill(0.0);
            let at = [times[0]];
            return self.free.advance(state, &at, h, &inputs[0], &inputs[2]);
        }
        let view = match self.struck(&view, &entered, h)? {
            None => view,
            Some(velocity) => {
                put(&mut state.v, &velocity);
                self.view(state, times[0], &inputs[0])?
            }
        };
        self.press(state, &view, h, times[1], &inputs[1])
    }

    /// Part 1: velocities behind the impact, if there is one.
    fn struck(
        &mut self,
        view: &View,
        entered: &[bool],
        h: f64,
    ) -> Result<Option<DVector<f64>>, SolveError> {
        let contacts = &view.contacts;
        let floors = |bounce: f64| -> DVector<f64> {
            let floor = |i: usize| {
                let (approach, e) = (contacts.approach(i), contacts.restitution[i]);
                let bounces = bounce * e > 0.0 && entered[i] && approach < -RESTING;
                if bounces {
                    -bounce * e * approach
                } else {
                    -contacts.gap[i] / h
                }
            };
            DVector::from_fn(contacts.len(), |i, _| floor(i))
        };
        let floor = floors(1.0);
        let hit = |i: usize| contacts.approach(i) < floor[i] - RESTING;
        if !(0..contacts.len()).any(hit) {
            return Ok(None);
        }
        let nothing = DVector::zeros(3 * contacts.len());
        let before = &contacts.velocity;
        let mut impulse = self.solve(view, before, &floor, nothing.clone())?;
        if view.gains(&impulse, before) {
            let soft = self.solve(view, before, &floors(0.0), nothing)?;
            impulse = view.without_gain(soft, &impulse, before);
        }
        self.impulse += &impulse;
        let velocity = &view.response * impulse;
        Ok(Some(velocity + &view.velocity))
    }

    /// Part 2: the rest of the step, under forces and contact forces.
    fn press(
        &mut self,
        state: &mut Simulated,
        view: &View,
        h: f64,
        middle: f64,
        input: &[Vec<f64>],
    ) -> Result<(), SolveError> {
        let floor = -&view.contacts.gap / h;
        let free = &view.contacts.velocity + view.contact_acceleration() * (h / 2.0);
        let guess = &self.pressed / 2.0;
        let impulse = self.solve(view, &free, &floor, guess)?;
        let halfway = &view.velocity + &view.motion.acceleration * (h / 2.0);
        let halfway = halfway + &view.response * &impulse;
        let mut half = state.clone();
        move_by(&mut half.q, &(&view.velocity + &halfway), h / 4.0);
        put(&mut half.v, &halfway);
        let rates = self.free.rates(&view.states);
        half.z = remembered(&state.z, [(&state.z, &rates); 2], h / 2.0);

        let there = self.view(&half, middle, input)?;
        let free = &view.velocity + &there.motion.acceleration * h;
        let moved = &there.contacts.jacobian * (&free - &halfway);
        // At the end `J` has turned on by half of the step: `J̇ v = −b`.
        let turned = &there.contacts.bias * (-h / 2.0);
        let free_contacts = &there.contacts.velocity + moved + turned;
        let impulse = self.held(
            &there,
            &view.contacts,
            &free_contacts,
            (&floor, impulse * 2.0),
        )?;
        let velocity = free + &there.response * &impulse;
        move_by(&mut state.q, &(&view.velocity + &velocity), h / 2.0);
        put(&mut state.v, &velocity);
        let rates = self.free.rates(&there.states);
        state.z = remembered(&state.z, [(&half.z, &rates); 2], h);
        self.impulse += &impulse;
        self.pressed = impulse;
        Ok(())
    }

    /// Impulses over a step in which contacts that moved as in `before` would move with `free`, and may
    /// move with `floor` along their normals on the mean.
    fn held(
        &mut self,
        there: &View,
        before: &ContactTerms,
        free: &DVector<f64>,
        (floor, guess): (&DVector<f64>, DVector<f64>),
    ) -> Result<DVector<f64>, SolveError> {
        // What approached faster than that does not come back.
        let end = |i: usize| floor[i] - (before.approach(i) - floor[i]).max(0.0);
        let end = DVector::from_fn(floor.len(), |i, _| end(i));
        let impulse = self.solve(there, free, &end, guess)?;
        let mean = (free + &before.velocity) / 2.0;
        if !there.gains(&impulse, &mean) {
            return Ok(impulse);
        }
        let both = DVector::from_fn(floor.len(), |i, _| end[i] + before.approach(i));
        let soft = self.solve(there, &(&mean * 2.0), &both, impulse.clone())?;
        Ok(there.without_gain(soft, &impulse, &mean))
    }

    /// Part 3: the state moved out of planes and onto constraints, and what it looks like there.
    fn projected(
        &mut self,
        state: &mut Simulated,
        t: f64,
        input: &[Vec<f64>],
    ) -> Result<View, SolveError> {
        let mut view = self.view(state, t, input)?;
        for _ in 0..PROJECTIONS {
            let off = view.off_constraints(self.machine.constraint_kinds());
            let inside = view.contacts.gap.iter().any(|&gap| gap < -INSIDE);
            if !inside && off.amax() <= INSIDE {
                break;
            }
            let shift = self.shift(&view, off)?;
            move_by(&mut state.q, &shift, 1.0);
            let gaps = &view.contacts.gap + view.normals() * &shift;
            if shift.amax() <= FAR {
                // What the shift changes in everything else is its square.
                view.contacts.gap = gaps;
                break;
            }
            view = self.view(state, t, input)?;
        }
        Ok(view)
    }

    /// `δq = M⁻¹ (Aᵀ η + Jₙᵀ μ)` with `A δq = −c` and `g + Jₙ δq ≥ 0 ⟂ μ ≥ 0`.
    fn shift(&mut self, view: &View, off: DVector<f64>) -> Result<DVector<f64>, SolveError> {
        let n = view.velocity.len();
        let onto = DMatrix::from_column_slice(off.len(), 1, (-off).as_slice());
        let (onto, _) = view.motion.factorisation.solve(DMatrix::zeros(n, 1), &onto);
        let onto: DVector<f64> = onto.column(0).into_owned();
        let gaps = &view.contacts.gap + view.normals() * &onto;
        let mut distance = DVector::zeros(3 * gaps.len());
        gaps.iter()
            .enumerate()
            .for_each(|(i, gap)| distance[3 * i + 2] = *gap);
        let smooth = DVector::zeros(gaps.len());
        let problem = Problem {
            mobility: &view.mobility,
            velocity: &distance,
            friction: &smooth,
        };
        let out = self.solution(&problem, DVector::zeros(distance.len()))?;
        Ok(onto + &view.response * out)
    }

    /// Impulses under which contacts that move with `free` without them move with at least `floor`
    /// along their normals.
    fn solve(
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

    fn solution(
        &mut self,
        problem: &Problem<'_>,
        guess: DVector<f64>,
    ) -> Result<DVector<f64>, SolveError> {
        let unsettled = SolveError::Unsettled { sample: 0 };
        let solution = problem.solve(guess).ok_or(unsettled)?;
        self.sweeps += solution.sweeps;
        self.relaxed += usize::from(solution.relaxed);
        Ok(solution.impulse)
    }

    fn view(&self, state: &Simulated, t: f64, input: &[Vec<f64>]) -> Result<View, SolveError> {
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
fn put(columns: &mut [Vec<f64>], values: &DVector<f64>) {
    let both = columns.iter_mut().zip(values.iter());
    both.for_each(|(column, value)| column[0] = *value);
}

/// Adds `h` times the values.
fn move_by(columns: &mut [Vec<f64>], values: &DVector<f64>, h: f64) {
    let both = columns.iter_mut().zip(values.iter());
    both.for_each(|(column, value)| column[0] += h * value);
}
