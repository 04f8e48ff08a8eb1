//! How internal states begin: a machine that moves when its log begins has been there before.
//!
//! No column of a log shows what a drive that lags delivers, or where the bristles of a friction law are. A
//! model says how they begin (a drive with its command, bristles unbent), which is so after a rest. By how much
//! they begin beside that is an unknown of every fit, believed to be as far as the state goes along the log,
//! and integrated over in the evidence.

use super::estimate::Observed;
use super::focus::Focus;
use super::score::deviation;
use crate::machine::SolveError;
use nalgebra::{Cholesky, DMatrix, DVector};
use std::sync::Arc;

/// The internal states of a model that move along a log.
pub(super) struct Beginning {
    /// Per state its place among the model's, its name, and the standard deviation of its beginning.
    states: Vec<(usize, String, f64)>,
}

impl Beginning {
    /// Along a log, with these values of the model's parameters.
    ///
    /// # Errors
    /// If a state's equation has no solution along the curve.
    pub fn along(focus: &Focus, observed: &Observed, values: &[f64]) -> Result<Self, SolveError> {
        if focus.internal_states().next().is_none() {
            return Ok(Self { states: Vec::new() });
        }
        let along = focus
            .machine
            .remember(&observed.curve, observed.hold, values)?;
        let spreads = along.memory.z.iter().map(|z| deviation(z));
        let states = focus.internal_states().map(str::to_string).zip(spreads);
        let states = states
            .enumerate()
            .map(|(place, (name, sd))| (place, name, sd));
        Ok(Self {
            states: states.filter(|(_, _, sd)| *sd > 0.0).collect(),
        })
    }

    /// Whether nothing is unknown of it.
    pub fn is_known(&self) -> bool {
        self.states.is_empty()
    }

    /// The columns of the states where the model's first one is column `first`.
    pub fn columns(&self, first: usize) -> impl Iterator<Item = usize> {
        self.states.iter().map(move |(place, ..)| first + place)
    }

    /// What is believed of how far a fit is from where they began, where they are the columns from `first`
    /// on: column, mean and standard deviation.
    pub fn beliefs(&self, first: usize, observed: &Observed) -> Vec<(usize, f64, f64)> {
        let begun = &observed.curve.begun;
        let states = self.states.iter().enumerate();
        let of = |(place, (_, name, sd)): (usize, &(usize, String, f64))| {
            (first + place, -begun.get(name).unwrap_or(&0.0), *sd)
        };
        states.map(of).collect()
    }

    /// What it costs, nats, that they might have begun otherwise, by the products of their columns:
    /// `½ ln |I + S H S|` with the standard deviations `S`.
    pub fn price(&self, information: &DMatrix<f64>) -> f64 {
        let sd = |i: usize| self.states[i].2;
        let size = self.states.len();
        let scaled = DMatrix::from_fn(size, size, |i, j| {
            f64::from(i == j) + sd(i) * information[(i, j)] * sd(j)
        });
        let factor = Cholesky::new(scaled);
        factor.map_or(0.0, |factor| factor.l_dirty().diagonal().map(f64::ln).sum())
    }

    /// What columns of which the last ones are the states' say of the others, whatever the states
    /// began with: `H_pp − H_pz (H_zz + S⁻²)⁻¹ H_zp`.
    pub fn integrated(&self, information: &DMatrix<f64>) -> DMatrix<f64> {
        let own = self.states.len();
        let others = information.nrows() - own;
        let mut of_states = information.view((others, others), (own, own)).into_owned();
        for (i, (_, _, sd)) in self.states.iter().enumerate() {
            of_states[(i, i)] += sd.powi(-2);
        }
        let cross = information.view((others, 0), (own, others)).into_owned();
        let known = information.view((0, 0), (others, others)).into_owned();
        match Cholesky::new(of_states) {
            Some(factor) => known - cross.transpose() * factor.solve(&cross),
            None => known,
        }
    }

    /// Moves the beginning by steps, one per state.
    pub fn moved(&self, observed: &mut Observed, steps: &DVector<f64>) {
        let begun = Arc::make_mut(&mut observed.curve.begun);
        for ((_, name, _), step) in self.states.iter().zip(steps) {
            *begun.entry(name.clone()).or_default() += step;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::wheel::{WHEEL, begun, named, rectangular, traced};
    use super::*;
    use crate::regression::{ErrorDynamics, Hold};
    use crate::trace::Verdict;
    use std::fmt::Write;

    /// A wheel of 0.02 kg·m² whose motor follows its command by 80 ms, in a log that begins while it turns:
    /// `w = i a` and `u = w + τ dw/dt`, so that at the first sample they differ.
    fn in_motion() -> String {
        let mut text = String::from("t,q_angle,u_motor\n");
        let mut noise = rectangular(5);
        let waves = [(0.9, 3.0, 0.4), (0.4, 7.0, 1.9), (0.1, 13.0, 4.0)];
        for k in 0..2000 {
            let t = 0.005 * f64::from(k);
            let derivative = |of: fn([f64; 3]) -> f64| -> f64 {
                let at = |&(size, w, phase): &(f64, f64, f64)| of([size, w, w * t + phase]);
                waves.iter().map(at).sum()
            };
            let q = derivative(|[size, _, at]| size * at.sin());
            let a = derivative(|[size, w, at]| -size * w * w * at.sin());
            let jerk = derivative(|[size, w, at]| -size * w * w * w * at.cos());
            let command = 0.02 * (a + 0.08 * jerk);
            writeln!(text, "{t},{},{command}", q + 1e-4 * noise()).unwrap();
        }
        text
    }

    #[test]
    fn a_lag_is_found_in_a_log_that_begins_in_motion() {
        let outcome = traced(WHEEL, &in_motion());
        let [found] = &outcome.findings[..] else {
            panic!("{:#?}", outcome.findings);
        };
        assert_eq!(found.effect, "input_lag");
        let tau = &found.parameters["tau"];
        assert!((tau.value - 0.08).abs() < 3.0 * tau.std, "{tau:?}");
        assert_eq!(outcome.verdict, Verdict::Channel);
    }

    #[test]
    fn a_model_with_the_lag_agrees_with_it() {
        let model = format!("{WHEEL}effect input_lag(motor) {{ tau = 0.08 }}");
        let outcome = traced(&model, &in_motion());
        assert_eq!(outcome.verdict, Verdict::None, "{:#?}", outcome.findings);
        assert!((outcome.misfit_before - 1.0).abs() < 0.1, "{outcome:#?}");
    }

    /// The columns of beginnings are what accelerations change by, of a state that fades evenly and of one that
    /// does not.
    #[test]
    fn accelerations_follow_how_states_begin() {
        let (dictionary, start) = begun(WHEEL, &in_motion(), ["angle", "motor"]);
        let terms = ["input_lag(motor)", "lugre(angle)"].map(|name| named(&dictionary, name));
        let focus = dictionary.focus(&terms);
        let mut values = start.values.clone();
        let lugre = &dictionary.candidates[terms[1]].parameters;
        values[dictionary.candidates[terms[0]].parameters[0]] = 0.05;
        values[lugre[0]] = 0.1;
        let values = focus.values(&values);
        let mut observed = start.observed;
        let beginning = Beginning::along(&focus, &observed, &values).unwrap();
        assert_eq!(beginning.columns(7).collect::<Vec<_>>(), [7, 8]);
        let mut accelerations = |steps: [f64; 2]| {
            beginning.moved(&mut observed, &DVector::from(steps.to_vec()));
            let columns = focus.beginnings(&observed, &values).unwrap();
            let mover = focus.mover(&observed, &values);
            let (curve, correlation) = (&observed.curve, &observed.correlation);
            ErrorDynamics::new(mover, &[columns], curve, Hold::Linear, correlation)
                .unwrap()
                .acceleration
        };
        let here = accelerations([0.0, 0.0]);
        for state in 0..2 {
            let mut step = [0.0; 2];
            step[state] = 1e-5;
            let there = accelerations(step);
            let back = accelerations(step.map(|x| -2.0 * x));
            accelerations(step);
            let at = |sample: usize| {
                let apart = there[sample][(0, 0)] - back[sample][(0, 0)];
                (here[sample][(0, 1 + state)], apart / 2e-5)
            };
            let largest = at(0).0.abs();
            assert!(largest > 1.0, "state {state} moves nothing");
            for (column, change) in (0..200).map(at) {
                let miss = (column - change).abs() / largest;
                assert!(miss < 1e-5, "state {state}: {column} {change}");
            }
        }
        // What columns say whatever the states began with is what their inverse says.
        let products =
            DMatrix::from_row_slice(3, 3, &[4.0, 1.0, 0.5, 1.0, 3.0, 0.2, 0.5, 0.2, 2.0]);
        let mut whole = products.clone();
        for (i, (_, _, sd)) in beginning.beliefs(1, &observed).into_iter().enumerate() {
            whole[(1 + i, 1 + i)] += sd.powi(-2);
        }
        let expected = 1.0 / whole.try_inverse().unwrap()[(0, 0)];
        assert!((beginning.integrated(&products)[(0, 0)] - expected).abs() < 1e-12);
    }
}
