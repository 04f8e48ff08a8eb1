//! Open-loop motion of many windows at once, by RK4 with stabilised constraints.

use super::{Machine, SolveError, States};
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
    /// Positions, one column per coordinate.
    pub q: Vec<Vec<f64>>,
    /// Velocities, one column per coordinate.
    pub v: Vec<Vec<f64>>,
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
    /// inputs linear between `u_start` and `u_end` (one column per input).
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
        for step in 0..steps {
            let at = |fraction: f64| (step as f64 + fraction) / steps as f64;
            let slope = |state: &Simulated, fraction: f64| {
                let share = at(fraction);
                let t = start.iter().map(|t| t + share * duration).collect();
                let u = u_start
                    .iter()
                    .zip(u_end)
                    .map(|(a, b)| a.iter().zip(b).map(|(a, b)| a + share * (b - a)).collect())
                    .collect();
                self.accelerations(state, t, u)
            };
            let k1 = slope(state, 0.0)?;
            let s2 = stepped(state, state, &k1, h / 2.0);
            let k2 = slope(&s2, 0.5)?;
            let s3 = stepped(state, &s2, &k2, h / 2.0);
            let k3 = slope(&s3, 0.5)?;
            let s4 = stepped(state, &s3, &k3, h);
            let k4 = slope(&s4, 1.0)?;
            for i in 0..state.q.len() {
                for w in 0..start.len() {
                    let v0 = state.v[i][w];
                    state.q[i][w] +=
                        h / 6.0 * (v0 + 2.0 * s2.v[i][w] + 2.0 * s3.v[i][w] + s4.v[i][w]);
                    state.v[i][w] +=
                        h / 6.0 * (k1[i][w] + 2.0 * k2[i][w] + 2.0 * k3[i][w] + k4[i][w]);
                }
            }
        }
        Ok(())
    }

    fn accelerations(
        &self,
        state: &Simulated,
        t: Vec<f64>,
        u: Vec<Vec<f64>>,
    ) -> Result<Vec<Vec<f64>>, SolveError> {
        let states = States {
            t,
            q: state.q.clone(),
            v: state.v.clone(),
            u,
        };
        let n = self.machine.coordinate_count();
        let mut accelerations = vec![vec![0.0; states.len()]; n];
        for (window, mut terms) in self
            .machine
            .terms(&states, self.parameters)
            .into_iter()
            .enumerate()
        {
            self.stabilise(&mut terms);
            let motion = super::Motion::of(terms, window)?;
            for i in 0..n {
                accelerations[i][window] = motion.acceleration[i];
            }
        }
        Ok(accelerations)
    }

    /// `b̃ = b − 2ζω ċ − ω² c` (holonomic), `b̃ = b − ω c` (nonholonomic).
    fn stabilise(&self, terms: &mut super::Terms) {
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

/// `base + h · (velocity of at, acceleration)`
fn stepped(base: &Simulated, at: &Simulated, acceleration: &[Vec<f64>], h: f64) -> Simulated {
    let add = |x: &[Vec<f64>], dx: &[Vec<f64>]| {
        x.iter()
            .zip(dx)
            .map(|(x, dx)| x.iter().zip(dx).map(|(x, dx)| x + h * dx).collect())
            .collect()
    };
    Simulated {
        q: add(&base.q, &at.v),
        v: add(&base.v, acceleration),
    }
}

impl Machine {
    /// The state nearest to `q, v` that fulfils the constraints at time `t`, in the
    /// least-squares sense of the coordinates: Gauss–Newton on `c`, then the
    /// velocities onto `ċ = 0`.
    pub fn project(&self, t: f64, q: &mut [f64], v: &mut [f64], parameters: &[f64]) {
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
            let column = |values: &[f64]| values.iter().map(|&x| vec![x]).collect();
            let u = vec![vec![0.0]; self.input_count()];
            let states = States {
                t: vec![t],
                q: column(q),
                v: column(v),
                u,
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
            q.iter_mut().zip(step.iter()).for_each(|(q, dq)| *q -= dq);
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
