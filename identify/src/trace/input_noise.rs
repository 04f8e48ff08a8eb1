//! Noise of logged inputs that the machine never felt.
//!
//! A torque is measured, too: its column carries the noise of a current sensor. Taken for torque it
//! shakes the model, and whatever evens it out looks as if it were missing: a lag, a delay, a load.
//! What is smooth of a column is estimated as a motion is ([`smooth`](crate::smooth)), without the
//! model. Whether the machine felt the rest, its motion says: what was felt and is taken off leaves
//! forces that nothing explains, what was not leaves them if it is taken for torque. Both answers are
//! free to say how strong these forces are. The least that noise of an input leaves is asked of the
//! search alone ([`Observed::bear_inputs`]): where a light link's torque is lost in its sensor's noise, that
//! would be far more than the motion shows, and the noise the likelier answer.

use super::dictionary::Dictionary;
use super::estimate::Observed;
use super::progress::Progress;
use super::refine::Effort;
use super::score::deviation;
use super::search::{Fitted, as_given};
use super::settings::{MARGIN, SEARCHED, UNUSUAL};
use crate::log::{Record, Warning, median_step, rms};
use crate::machine::{Machine, SolveError};
use crate::regression::{Hold, ProcessNoise};
use crate::smooth::{Channels, SmoothError, Smoother, high_frequency};
use rayon::prelude::*;

/// Noise below this share of an input's deviation moves nothing that is worth a name.
const VISIBLE: f64 = 1e-3;

/// Where fifth differences show less than this share of visible noise, there is none: the share is for their own chance.
const CERTAINLY: f64 = 0.5;

/// Noise of a logged input, as standard deviations.
#[derive(Debug, Clone, Copy, Default)]
pub struct InputNoise {
    /// Of what was taken off.
    pub taken: f64,
    /// Of what is left of it in the input as it is taken.
    pub left: f64,
}

/// An input without its noise.
struct Quiet {
    input: usize,
    values: Vec<f64>,
    noise: InputNoise,
}

/// Some inputs of a log without white noise; those that cannot be smoothed stay as they are.
fn quiet(record: &Record, inputs: impl Iterator<Item = usize>) -> Vec<Quiet> {
    let each: Vec<usize> = inputs.collect();
    let each = each.into_par_iter().map(|input| {
        let channels = Channels::new(&record.t, &record.u[input], None, None)?;
        let smoothed = Smoother::fit(&channels)?.apply(&channels)?;
        let taken = smoothed.noise.sd_q;
        // Where noise is larger than all that is left, nobody knows what of that is the input.
        let left = match taken > deviation(&smoothed.q) {
            true => taken,
            false => rms(&smoothed.sd_q),
        };
        Ok(Quiet {
            input,
            noise: InputNoise { taken, left },
            values: smoothed.q,
        })
    });
    let each: Vec<Result<Quiet, SmoothError>> = each.collect();
    each.into_iter().flatten().collect()
}

impl Observed {
    /// The same log with some inputs as they are without noise.
    fn with_inputs(&self, quiet: &[&Quiet]) -> Self {
        let mut observed = self.clone();
        for quiet in quiet {
            observed.record.u[quiet.input].clone_from(&quiet.values);
            observed.curve.u[quiet.input].clone_from(&quiet.values);
            observed.input_noise[quiet.input] = quiet.noise;
        }
        observed
    }

    /// The same log where what is left of the noise of inputs is all that they carry.
    pub(super) fn with_quiet_inputs(&self) -> Self {
        let mut observed = self.clone();
        for noise in &mut observed.input_noise {
            noise.taken = noise.left;
        }
        observed
    }

    /// The same log without noise of its inputs that the machine did not feel: of all that have
    /// noise, or else of one after the other, where the model as given says so, and time is left to ask.
    /// Whatever forces the motion shows are allowed in either case.
    ///
    /// # Errors
    /// If the equation of motion cannot be solved along the curve.
    pub(super) fn as_felt(
        &self,
        dictionary: &Dictionary,
        free_hold: bool,
        progress: &dyn Progress,
    ) -> Result<Self, SolveError> {
        let record = &self.record;
        let may_be_noisy = |input: &usize| {
            let u = &record.u[*input];
            let most = high_frequency(u);
            most == 0.0 || most > CERTAINLY * VISIBLE * deviation(u)
        };
        let mut noisy = quiet(record, (0..record.u.len()).filter(may_be_noisy));
        noisy.retain(|quiet| quiet.noise.taken > VISIBLE * deviation(&record.u[quiet.input]));
        if noisy.is_empty() {
            return Ok(self.clone());
        }
        // What cannot come below a known score need not be fitted to the end, nor what comes far enough below it.
        let score = |quiet: &[&Quiet], known: f64, enough: f64| -> Result<f64, SolveError> {
            let mut felt = self.with_inputs(quiet);
            felt.input_noise.fill(InputNoise::default());
            let felt = felt.excerpt(SEARCHED).unwrap_or(felt);
            let holds = match free_hold {
                true => &[Hold::Linear, Hold::Previous][..],
                false => &[self.hold],
            };
            let mut least = f64::INFINITY;
            for &hold in holds {
                let effort = Effort {
                    bar: known.min(least),
                    // Inputs that are held cost so much.
                    enough: enough - UNUSUAL,
                    ..Effort::FULL
                };
                let Fitted { score, .. } = as_given(dictionary, &felt, hold, effort)?;
                least = least.min(score);
                if least < enough {
                    break;
                }
            }
            Ok(least)
        };
        let to_the_end = f64::NEG_INFINITY;
        let as_logged = score(&[], f64::INFINITY, to_the_end)?;
        let all: Vec<&Quiet> = noisy.iter().collect();
        let is_over = || progress.ended().is_some();
        if is_over() {
            return Ok(self.clone());
        }
        let likelier = as_logged - MARGIN;
        if score(&all, as_logged, likelier)? < likelier {
            return Ok(self.with_inputs(&all));
        }
        let (mut felt, mut best) = (Vec::new(), as_logged);
        for &one in all.iter().filter(|_| all.len() > 1) {
            if is_over() {
                break;
            }
            felt.push(one);
            match score(&felt, best, to_the_end)? {
                better if better < best - MARGIN => best = better,
                _ => drop(felt.pop()),
            }
        }
        Ok(self.with_inputs(&felt))
    }

    /// Takes the noise of the inputs for the least of the white forces that nothing explains:
    /// `σ √Δt`. Evening out takes none of it at the frequencies that move a machine. Of the model
    /// `focus` with these values of its own parameters.
    ///
    /// # Errors
    /// If the equation of motion cannot be solved along the curve.
    pub(super) fn bear_inputs(
        &self,
        noise: &mut ProcessNoise,
        machine: &Machine,
        values: &[f64],
    ) -> Result<(), SolveError> {
        if self.noisy_inputs().next().is_none() {
            return Ok(());
        }
        let taken = self.forces_of_noise((machine, values), |noise| noise.taken)?;
        let root = median_step(&self.record.t).sqrt();
        for (smallest, taken) in noise.smallest_jitter.iter_mut().zip(taken) {
            *smallest = smallest.hypot(taken * root);
        }
        noise.jitter = noise.jitter.sup(&noise.smallest_jitter);
        Ok(())
    }

    /// What some noise of the inputs exerts on each coordinate, root mean square along the curve.
    ///
    /// # Errors
    /// If the equation of motion cannot be solved along the curve.
    pub(super) fn forces_of_noise(
        &self,
        (machine, values): (&Machine, &[f64]),
        sd: impl Fn(&InputNoise) -> f64,
    ) -> Result<Vec<f64>, SolveError> {
        let along = machine.remember(&self.curve, self.hold, values)?;
        let terms = machine.terms(&along, values);
        let of_coordinate = |i: usize| {
            let of_input = |(j, noise): (usize, &InputNoise)| {
                let squares = terms.iter().map(|terms| terms.input_matrix[(i, j)].powi(2));
                squares.sum::<f64>() / terms.len() as f64 * sd(noise).powi(2)
            };
            let each = self.input_noise.iter().enumerate();
            each.map(of_input).sum::<f64>().sqrt()
        };
        Ok((0..machine.coordinate_count()).map(of_coordinate).collect())
    }

    /// Another log of the same machine, without noise of the same inputs.
    pub(super) fn felt_in(&self, other: &Record) -> Record {
        let mut felt = other.clone();
        for quiet in quiet(other, self.noisy_inputs().map(|(input, _)| input)) {
            felt.u[quiet.input] = quiet.values;
        }
        felt
    }

    /// Inputs that are taken without their noise, with its standard deviation.
    pub(super) fn noisy_inputs(&self) -> impl Iterator<Item = (usize, f64)> {
        let each = self.input_noise.iter().map(|noise| noise.taken).enumerate();
        each.filter(|(_, taken)| *taken > 0.0)
    }

    /// What a reader should know of inputs that were taken otherwise than logged.
    pub(super) fn said_of_inputs(&self) -> impl Iterator<Item = Warning> {
        let record = &self.record;
        self.noisy_inputs()
            .map(|(input, noise)| Warning::InputNoise {
                column: format!("u_{}", record.inputs[input]),
                noise,
                share: noise / deviation(&record.u[input]),
            })
    }
}

#[cfg(test)]
mod tests {
    use crate::trace::Verdict;
    use crate::trace::progress::Silent;
    use crate::trace::wheel::{WHEEL, begun, rectangular, traced};
    use std::fmt::Write;

    /// A wheel that is turned by a motor of these torques, each felt with as much `felt` noise and
    /// logged with as much `read` noise.
    fn log(felt: f64, read: f64) -> String {
        let mut text = String::from("t,q_angle,u_motor\n");
        let (mut noise, mut error) = (rectangular(8), rectangular(9));
        let (mut q, mut v, step) = (0.0, 0.0, 0.0004);
        let wave = |t: f64| 0.06 * (3.0 * t).cos() + 0.15 * (7.0 * t).cos();
        for k in 0..2000 {
            let t = 0.004 * f64::from(k);
            let shaken = felt * error();
            let u = wave(t) + shaken + read * error();
            writeln!(text, "{t},{},{u}", q + 2e-5 * noise()).unwrap();
            for part in 0..10 {
                let middle = t + step * (f64::from(part) + 0.5);
                let a = (wave(middle) + shaken - 0.01 * v) / 0.02;
                q += v * step + 0.5 * a * step * step;
                v += a * step;
            }
        }
        text
    }

    fn sd_of_input(log: &str) -> f64 {
        let (dictionary, start) = begun(WHEEL, log, ["angle", "motor"]);
        let felt = start.observed.as_felt(&dictionary, true, &Silent).unwrap();
        felt.input_noise[0].taken
    }

    #[test]
    fn the_motion_says_whose_noise_it_is() {
        let read = sd_of_input(&log(0.0, 0.02));
        let expected = 0.02 / 12.0_f64.sqrt();
        assert!((read / expected - 1.0).abs() < 0.05, "{read} {expected}");
        assert_eq!(sd_of_input(&log(0.02, 0.0)), 0.0);
        assert_eq!(sd_of_input(&log(0.0, 0.0)), 0.0);
    }

    /// A wheel that little turns, whose torque is lost in the noise of its sensor.
    #[test]
    fn a_torque_that_is_all_noise_was_not_felt() {
        let mut text = String::from("t,q_angle,dq_angle,u_motor\n");
        let (mut noise, mut other, mut error) = (rectangular(8), rectangular(9), rectangular(10));
        for k in 0..2000 {
            let t = 0.004 * f64::from(k);
            let (q, v, a) = (
                0.9 * (3.0 * t).sin(),
                2.7 * (3.0 * t).cos(),
                -8.1 * (3.0 * t).sin(),
            );
            let (q, v, u) = (
                q + 2e-5 * noise(),
                v + 2e-3 * other(),
                0.02 * a + 4.0 * error(),
            );
            writeln!(text, "{t},{q},{v},{u}").unwrap();
        }
        let (read, expected) = (sd_of_input(&text), 4.0 / 12.0_f64.sqrt());
        assert!((read / expected - 1.0).abs() < 0.05, "{read} {expected}");
    }

    #[test]
    fn noise_in_a_torque_is_no_lag_of_it() {
        let outcome = traced(WHEEL, &log(0.0, 0.04));
        assert_eq!(outcome.verdict, Verdict::Effect, "{:#?}", outcome.findings);
        let [friction] = &outcome.findings[..] else {
            panic!("{:#?}", outcome.findings);
        };
        assert_eq!(friction.effect, "viscous");
        let d = &friction.parameters["d"];
        assert!((d.value - 0.01).abs() < 3.0 * d.std, "{d:?}");
    }
}
