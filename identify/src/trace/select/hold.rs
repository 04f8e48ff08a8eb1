//! What inputs do between samples.

use super::fitting::{first_noise, fit};
use super::search::{Attempt, Search, reset};
use super::{TIE, search_samples};
use crate::log::median_step;
use crate::machine::SolveError;
use crate::regression::Hold;
use crate::trace::dictionary::Dictionary;
use crate::trace::estimate::Observed;
use crate::trace::refine::Explanation;
use dynamics_codegen::dimension::Dimension;
use dynamics_codegen::syntax::PortKind;
use nalgebra::{DMatrix, DVector};

/// Nats by which inputs that stay must be likelier, once delays are known: where stamps are even
/// the log hardly tells, where they jitter it does.
const DRAWN: f64 = 2.0;

/// What inputs most likely do between samples: the assumption under which the log
/// is more likely, with as much force unexplained as each demands.
///
/// # Errors
/// If the equation of motion cannot be solved along the curve.
pub fn likelier_hold(dictionary: &Dictionary, observed: &Observed) -> Result<Hold, SolveError> {
    if observed.record.u.is_empty() {
        return Ok(Hold::Linear);
    }
    let part = observed.excerpt(search_samples(dictionary));
    let observed = part.as_ref().unwrap_or(observed);
    let cost = |hold: Hold| -> Result<f64, SolveError> {
        let observed = Observed {
            hold,
            ..observed.clone()
        };
        let explanation = Explanation {
            noise: first_noise(dictionary, &observed)?,
            values: dictionary.defaults.clone(),
            observed,
        };
        Ok(fit(dictionary, &[], explanation)?.cost)
    };
    let (linear, previous) = (cost(Hold::Linear)?, cost(Hold::Previous)?);
    Ok(if previous < linear - TIE {
        Hold::Previous
    } else {
        Hold::Linear
    })
}

fn other(hold: Hold) -> Hold {
    match hold {
        Hold::Linear => Hold::Previous,
        Hold::Previous => Hold::Linear,
    }
}

impl Search<'_> {
    /// The explanation with the other assumption about inputs, and one term gone. An input that
    /// is held is half a sample later than it is drawn: so much less is what is left to its
    /// delay, and a fit that began with all of it might not find the way.
    fn otherwise(&self, without: Option<usize>) -> Explanation {
        let mut explanation = self.current.explanation.clone();
        let hold = other(explanation.observed.hold);
        explanation.observed.hold = hold;
        let half = 0.5 * median_step(&explanation.observed.record.t);
        let later = match hold {
            Hold::Linear => half,
            Hold::Previous => -half,
        };
        let bounds = &self.dictionary.machine.compiled.model.parameters;
        for &term in &self.accepted {
            if let Some(((PortKind::Input, _), unit)) = self.number_of_channel(term)
                && unit == Dimension::TIME
            {
                let parameter = self.dictionary.candidates[term].parameters[0];
                let time = &mut explanation.values[parameter];
                *time = (*time + later).clamp(bounds[parameter].lower, bounds[parameter].upper);
            }
        }
        if let Some(term) = without {
            reset(self.dictionary, &mut explanation, term);
        }
        explanation
    }

    /// What a doubt about inputs between samples adds to the covariance of accepted times and
    /// all else, where the log is about as likely under the other assumption: `½ Δ Δᵀ`, with how
    /// far `Δ` the estimate moves under it. An input that is held is as late as one that is drawn
    /// straight and half a sample later.
    pub(super) fn doubt_about_hold(&self) -> Option<DMatrix<f64>> {
        let times = &self.dictionary.machine.compiled.model.parameters;
        let parameters = &self.current.estimate.parameters;
        let is_time = |&&p: &&usize| times[p].dimension == Some(Dimension::TIME);
        parameters.iter().find(is_time)?;
        let explanation = &self.current.explanation;
        if explanation.observed.record.u.is_empty() {
            return None;
        }
        let otherwise = self.otherwise(None);
        let otherwise = self.converged(fit(self.dictionary, &self.accepted, otherwise).ok()?);
        if otherwise.cost > self.current.cost + TIE {
            return None;
        }
        let moved = parameters
            .iter()
            .map(|&p| otherwise.explanation.values[p] - explanation.values[p]);
        let moved = DVector::from_iterator(parameters.len(), moved);
        Some(0.5 * &moved * moved.transpose())
    }

    /// The accepted terms less one that is a time, under the other assumption about inputs, if
    /// that explains the log about as well: all sensors early by half a sample are inputs late
    /// by as much.
    pub(super) fn hold_for_a_time(&self) -> Option<Attempt> {
        let parameters = &self.dictionary.machine.compiled.model.parameters;
        let is_time = |c: &usize| match self.dictionary.candidates[*c].parameters[..] {
            [only] => parameters[only].dimension == Some(Dimension::TIME),
            _ => false,
        };
        let times: Vec<usize> = self.accepted.iter().copied().filter(is_time).collect();
        let tried = times.into_iter().filter_map(|time| {
            let explanation = self.otherwise(Some(time));
            let rest = self.accepted.iter().copied().filter(|&c| c != time);
            let rest: Vec<usize> = rest.collect();
            Some(self.sharpened(fit(self.dictionary, &rest, explanation).ok()?))
        });
        let best = tried.min_by(|a, b| a.cost.total_cmp(&b.cost))?;
        (best.cost < self.current.cost + TIE).then_some(best)
    }

    /// Takes the other assumption about inputs if the log is more likely under it.
    pub(super) fn ask_about_hold(&mut self) {
        if self.current.explanation.observed.record.u.is_empty() {
            return;
        }
        let explanation = self.otherwise(None);
        // An assumption under which the machine cannot move is none.
        let Ok(other) = fit(self.dictionary, &self.accepted, explanation) else {
            return;
        };
        let other = self.sharpened(other);
        // In doubt inputs are as they are drawn: straight from sample to sample. To stay,
        // and to be later by half a sample, is nearly the same.
        let margin = match other.explanation.observed.hold {
            Hold::Linear => DRAWN,
            Hold::Previous => -DRAWN,
        };
        if other.cost < self.current.cost + margin {
            self.current = other;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::wheel::{WHEEL, rectangular, traced};
    use crate::trace::Outcome;
    use std::fmt::Write;

    const STEP: f64 = 0.005;
    const TICKS: i32 = 10;

    /// What a log says of a wheel whose motor holds each value for a sample and gets it `late`
    /// tenths of a sample later: between jumps the angle is a parabola.
    fn held(late: i32, noise: f64) -> Outcome {
        let motor = |t: f64| 0.04 * (3.0 * t).sin() + 0.06 * (7.0 * t).cos();
        let mut text = String::from("t,q_angle,u_motor\n");
        let mut random = rectangular(5);
        let (mut q, mut v) = (0.3, 0.0);
        let tick = STEP / f64::from(TICKS);
        for k in 0..2000 {
            let t = STEP * f64::from(k);
            writeln!(text, "{t},{},{}", q + noise * random(), motor(t)).unwrap();
            for i in 0..TICKS {
                let sent = (k * TICKS + i - late).max(0) / TICKS;
                let a = motor(STEP * f64::from(sent)) / 0.02;
                q += v * tick + 0.5 * a * tick * tick;
                v += a * tick;
            }
        }
        traced(WHEEL, &text)
    }

    /// Of two motors on one shaft, both held, the left one gets its values 2.4 samples late.
    #[test]
    fn one_of_two_held_inputs_is_late() {
        const SHAFT: &str = "\
model shaft;
coordinate angle: rad;
input left: N*m;
input right: N*m;
parameter i: kg*m^2 = 0.02;
kinetic i/2*dot(angle)^2;
force angle = input(left) + input(right);
";
        let late = 24;
        let left = |t: f64| 0.04 * (3.0 * t).sin() + 0.06 * (7.0 * t).cos();
        let right = |t: f64| 0.05 * (4.0 * t).cos() - 0.03 * (11.0 * t).sin();
        let mut text = String::from("t,q_angle,u_left,u_right\n");
        let mut random = rectangular(6);
        let (mut q, mut v) = (0.3, 0.0);
        let tick = STEP / f64::from(TICKS);
        for k in 0..2000 {
            let t = STEP * f64::from(k);
            let read = q + 2e-4 * random();
            writeln!(text, "{t},{read},{},{}", left(t), right(t)).unwrap();
            for i in 0..TICKS {
                let sent = (k * TICKS + i - late).max(0) / TICKS;
                let a = (left(STEP * f64::from(sent)) + right(t)) / 0.02;
                q += v * tick + 0.5 * a * tick * tick;
                v += a * tick;
            }
        }
        let findings = traced(SHAFT, &text).findings;
        let found: Vec<_> = findings.iter().map(|f| (&f.effect[..], &f.on)).collect();
        assert_eq!(found, [("input_delay", &vec!["left".to_string()])]);
        let tau = &findings[0].parameters["tau"];
        assert!((tau.value - 2.4 * STEP).abs() < 3.0 * tau.std, "{tau:?}");
    }

    #[test]
    fn an_input_that_is_held_is_not_late() {
        let findings = held(0, 2e-4).findings;
        assert!(findings.is_empty(), "{findings:#?}");
    }

    #[test]
    fn a_delay_is_as_uncertain_as_what_inputs_do_between_samples() {
        let findings = held(24, 1e-3).findings;
        assert_eq!(findings.len(), 1, "{findings:#?}");
        let tau = &findings[0].parameters["tau"];
        let late = 2.4 * STEP;
        // Were the input drawn straight it would be half a sample later.
        let [held, straight] = [late, late + 0.5 * STEP].map(|t| (tau.value - t).abs());
        assert!(held < 2.0 * tau.std && straight < 2.0 * tau.std, "{tau:?}");
        assert!(tau.std < STEP, "{tau:?}");
    }
}
