//! Open-loop motion of many windows at once, by RK4 with stabilised constraints.

use super::{Machine, Memory, SolveError, States, exponential};
use dynamics_codegen::model::ConstraintKind;
use nalgebra::{DMatrix, DVector};

/// How to integrate.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RolloutOptions {
    /// The largest step, s.
    pub max_step: f64,
    /// Baumgarte's `ω` [5.32, corrected], rad/s, with `ζ = 1`.
    pub stabilisation: f64,
}

impl Default for RolloutOptions {
    fn default() -> Self {
        Self {
            max_step: 2e-3,
            stabilisation: 20.0,
        }
    }
}

/// What moves, in columns: one entry per window.
pub struct Rollout<'a> {
    machine: &'a Machine,
    parameters: &'a [f64],
    options: RolloutOptions,
}

/// A state of all windows.
#[derive(Debug, Clone)]
pub struct Simulated {
    /// Positions, one column each.
    pub q: Vec<Vec<f64>>,
    /// Velocities, one column per coordinate.
    pub v: Vec<Vec<f64>>,
    /// Internal states, one column per state; empty before the first step: as at the
    /// beginning.
    pub z: Vec<Vec<f64>>,
}

/// How internal states change.
pub(super) struct Rates {
    /// `dz/dt`.
    rates: Vec<Vec<f64>>,
    /// `∂(dz/dt)/∂z` of each state by itself.
    jacobians: Vec<Vec<f64>>,
}

impl<'a> Rollout<'a> {
    /// A roll-out of `machine` with `parameters`.
    pub fn new(machine: &'a Machine, parameters: &'a [f64], options: RolloutOptions) -> Self {
        Self {
            machine,
            parameters,
            options,
        }
    }

    /// Advances all windows from `start` (their times) by `duration` seconds, with
    /// inputs linear between `u_start` and `u_end`: one column per input, then one per
    /// delayed input ([`Machine::inputs_over`]); where those are left out, the inputs have
    /// always been what they are.
    ///
    /// Positions and velocities by RK4; states by an exponential integrator of the second
    /// order, so that fast ones need no smaller step.
    ///
    /// # Errors
    /// If the equation of motion has no solution on the way.
    pub fn advance(
        &self,
        state: &mut Simulated,
        start: &[f64],
        duration: f64,
        u_start: &[Vec<f64>],
        u_end: &[Vec<f64>],
    ) -> Result<(), SolveError> {
        let steps = (duration / self.options.max_step).ceil().max(1.0) as usize;
        let h = duration / steps as f64;
        if state.z.len() != self.machine.state_count() {
            let at = self.states(state, start.to_vec(), u_start.to_vec());
            state.z = self.machine.initial_states(&at, self.parameters);
        }
        for step in 0..steps {
            let at = |state: &Simulated, fraction: f64| {
                let share = (step as f64 + fraction) / steps as f64;
                let t = start.iter().map(|t| t + share * duration).collect();
                let u = u_start
                    .iter()
                    .zip(u_end)
                    .map(|(a, b)| a.iter().zip(b).map(|(a, b)| a + share * (b - a)).collect())
                    .collect();
                self.states(state, t, u)
            };
            self.step(state, h, at)?;
        }
        Ok(())
    }

    /// One step of `h` seconds; `at` tells what else holds a share of the way.
    fn step(
        &self,
        state: &mut Simulated,
        h: f64,
        at: impl Fn(&Simulated, f64) -> States,
    ) -> Result<(), SolveError> {
        let slope = |state: &Simulated, share: f64| self.accelerations(&at(state, share));
        let rates = |state: &Simulated, share: f64| self.rates(&at(state, share));
        let moving = |state: &Simulated| {
            let rates = self.machine.position_rates(&state.q, &state.v);
            rates.into_owned()
        };
        let (k1, r1) = (slope(state, 0.0)?, rates(state, 0.0));
        // What is remembered halfway depends on the motion there, and the reverse: states
        // follow the motion, stage by stage.
        let q1 = moving(state);
        let mut s2 = stepped(state, state, (&q1, &k1), h / 2.0);
        let r2 = rates(&s2, 0.5);
        s2.z = remembered(&state.z, [(&state.z, &r1), (&s2.z, &r2)], h / 2.0);
        let k2 = slope(&s2, 0.5)?;
        let q2 = moving(&s2);
        let mut s3 = stepped(state, &s2, (&q2, &k2), h / 2.0);
        let r3 = rates(&s3, 0.5);
        let old = std::mem::take(&mut s3.z);
        s3.z = remembered(&state.z, [(&state.z, &r1), (&old, &r3)], h / 2.0);
        let k3 = slope(&s3, 0.5)?;
        let q3 = moving(&s3);
        let mut s4 = stepped(state, &s3, (&q3, &k3), h);
        let r4 = rates(&s4, 1.0);
        s4.z = remembered(&s3.z, [(&old, &r3), (&s4.z, &r4)], h / 2.0);
        let k4 = slope(&s4, 1.0)?;
        let add = |x: &mut [Vec<f64>], slopes: [&[Vec<f64>]; 4]| {
            let [k1, k2, k3, k4] = slopes;
            for i in 0..x.len() {
                for w in 0..x[i].len() {
                    x[i][w] += h / 6.0 * (k1[i][w] + 2.0 * k2[i][w] + 2.0 * k3[i][w] + k4[i][w]);
                }
            }
        };
        let q4 = moving(&s4);
        add(&mut state.q, [&q1, &q2, &q3, &q4]);
        add(&mut state.v, [&k1, &k2, &k3, &k4]);
        self.machine.normalise(&mut state.q);
        state.z = s4.z;
        Ok(())
    }

    pub(super) fn states(&self, state: &Simulated, t: Vec<f64>, mut u: Vec<Vec<f64>>) -> States {
        let delayed = if u.len() > self.machine.input_count() {
            u.split_off(self.machine.input_count())
        } else {
            Vec::new()
        };
        let memory = Memory {
            delay_rate: vec![vec![0.0; t.len()]; delayed.len()],
            delayed,
            z: state.z.clone(),
            slopes: Vec::new(),
        };
        States {
            t,
            q: state.q.clone(),
            v: state.v.clone(),
            u,
            memory,
            ..States::default()
        }
    }

    fn accelerations(&self, states: &States) -> Result<Vec<Vec<f64>>, SolveError> {
        let states = &self.machine.at_rest(states, self.parameters);
        let n = self.machine.coordinate_count();
        let mut accelerations = vec![vec![0.0; states.len()]; n];
        let motions = self
            .machine
            .motion_with(states, self.parameters, |_, terms| self.stabilise(terms))?;
        for (window, motion) in motions.iter().enumerate() {
            for i in 0..n {
                accelerations[i][window] = motion.acceleration[i];
            }
        }
        Ok(accelerations)
    }

    pub(super) fn rates(&self, states: &States) -> Rates {
        let states = &self.machine.at_rest(states, self.parameters);
        let mut rates = self.machine.state_rates(states, self.parameters);
        let jacobians = rates.split_off(self.machine.state_count());
        Rates { rates, jacobians }
    }

    /// `b̃ = b − 2ζω ċ − ω² c` (holonomic), `b̃ = b − ω c` (nonholonomic).
    pub(super) fn stabilise(&self, terms: &mut super::Terms) {
        let omega = self.options.stabilisation;
        for (row, kind) in self.machine.constraint_kinds().iter().enumerate() {
            let c = terms.constraint_residual[row];
            terms.constraint_bias[row] -= match kind {
                ConstraintKind::Holonomic => {
                    2.0 * omega * terms.constraint_rate[row] + omega * omega * c
                }
                ConstraintKind::Nonholonomic => omega * c,
            };
        }
    }
}

/// `base + h · (rate of positions, acceleration)`, with the internal states of `at`.
fn stepped(
    base: &Simulated,
    at: &Simulated,
    (rates, acceleration): (&[Vec<f64>], &[Vec<f64>]),
    h: f64,
) -> Simulated {
    let add = |x: &[Vec<f64>], dx: &[Vec<f64>]| {
        x.iter()
            .zip(dx)
            .map(|(x, dx)| x.iter().zip(dx).map(|(x, dx)| x + h * dx).collect())
            .collect()
    };
    Simulated {
        q: add(&base.q, rates),
        v: add(&base.v, acceleration),
        z: at.z.clone(),
    }
}

/// Internal states `h` seconds after `start`, with their equations as they are linearised
/// at the two ends: about which values, and with which rates.
pub(super) fn remembered(
    start: &[Vec<f64>],
    ends: [(&Vec<Vec<f64>>, &Rates); 2],
    h: f64,
) -> Vec<Vec<f64>> {
    let advance = |state: usize, window: usize| {
        let slope = |end: usize| ends[end].1.jacobians[state][window];
        let jacobian = (slope(0) + slope(1)) / 2.0;
        let rest = |end: usize| {
            let (about, Rates { rates, .. }) = ends[end];
            let z = about[state][window];
            rates[state][window] - slope(end) * z + (slope(end) - jacobian) * start[state][window]
        };
        exponential::step(start[state][window], jacobian, rest(0), rest(1), h)
    };
    (0..start.len())
        .map(|state| (0..start[state].len()).map(|w| advance(state, w)).collect())
        .collect()
}

impl Machine {
    /// The state nearest to `q, v` that fulfils the constraints at time `t`, in the
    /// least-squares sense of the coordinates: Gauss–Newton on `c`, then the
    /// velocities onto `ċ = 0`.
    pub fn project(&self, t: f64, q: &mut [f64], v: &mut [f64], parameters: &[f64]) {
        let column =
            |values: &[f64]| -> Vec<Vec<f64>> { values.iter().map(|&x| vec![x]).collect() };
        let shift = |q: &mut [f64], step: &[f64]| {
            let mut columns = column(q);
            self.move_positions(&mut columns, &column(step), -1.0);
            q.iter_mut()
                .zip(columns)
                .for_each(|(q, moved)| *q = moved[0]);
        };
        if self.poses.is_some() {
            shift(q, &vec![0.0; self.coordinate_count()]);
        }
        if self.constraint_count() == 0 {
            return;
        }
        let rows = |holonomic: bool| -> Vec<usize> {
            let kind = if holonomic {
                ConstraintKind::Holonomic
            } else {
                ConstraintKind::Nonholonomic
            };
            (0..self.constraint_count())
                .filter(|&r| self.constraint_kinds()[r] == kind)
                .collect()
        };
        let at = |q: &[f64], v: &[f64]| {
            let u = vec![vec![0.0]; self.input_count()];
            let states = States {
                t: vec![t],
                q: column(q),
                v: column(v),
                u,
                ..States::default()
            };
            self.terms(&states, parameters).remove(0)
        };
        let correct = |a: &DMatrix<f64>, c: &DVector<f64>| {
            // The shortest step that removes the violation.
            a.clone().svd(true, true).solve(c, 1e-10).ok()
        };
        let holonomic = rows(true);
        for _ in 0..5 {
            let terms = at(q, v);
            let a = terms.constraint_matrix.select_rows(&holonomic);
            let c = terms.constraint_residual.select_rows(&holonomic);
            if c.is_empty() || c.amax() < 1e-14 {
                break;
            }
            let Some(step) = correct(&a, &c) else { break };
            shift(q, step.as_slice());
        }
        for _ in 0..3 {
            let terms = at(q, v);
            let Some(step) = correct(&terms.constraint_matrix, &terms.constraint_rate) else {
                break;
            };
            v.iter_mut().zip(step.iter()).for_each(|(v, dv)| *v -= dv);
        }
    }
}
