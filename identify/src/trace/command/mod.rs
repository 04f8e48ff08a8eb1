//! What a drive makes of its commands, where a log has both: `u(t)` beside `c(t)`.
//!
//! Two measured columns tell a delay between them far more exactly than the motion does, and
//! no friction can be mistaken for it. The drive is thought to be
//!
//! ```text
//! u(t) = b + g y(t − τ),    T ẏ = c − y
//! ```
//!
//! with any of gain `g`, bias `b`, delay `τ` and lag `T`; which of them are needed is decided
//! by what they take from `u − c`, less the price of each. Which effects of the library these four
//! are is told by what the effects make of a test signal.

mod parts;

use super::dictionary::Dictionary;
use super::finding::{Finding, ParameterEstimate};
use crate::log::{Record, median_step, rms, share_of_news};
use crate::machine::{Hold, Signal};
use nalgebra::{DMatrix, DVector};
use parts::parts;
use std::collections::BTreeMap;

/// Longest delay or lag looked for, s.
const LATEST: f64 = 0.5;
/// Delays and lags tried, in steps of half a sample, then finer.
const TRIED: usize = 60;
const ROUNDS: usize = 40;
/// Nats that a part must bring beyond its price.
const MARGIN: f64 = 3.0;
/// A part must remove this share of the squares that are left.
const LEAST_REMOVED: f64 = 0.05;

/// A command with the drive's answer.
struct Drive<'a> {
    t: &'a [f64],
    command: &'a [f64],
    answer: &'a [f64],
}

/// Delay, lag, gain and bias, and the squares that they leave.
#[derive(Debug, Clone)]
struct Fitted {
    values: [f64; 4],
    squares: f64,
}

/// What the drives of a record do to their commands.
pub(super) fn drives(dictionary: &Dictionary, record: &Record) -> Vec<Finding> {
    let inputs = record.inputs.iter().enumerate();
    inputs
        .filter_map(|(i, name)| Some((i, name, record.commanded[i].as_ref()?)))
        .flat_map(|(i, name, command)| {
            let drive = Drive {
                t: &record.t,
                command,
                answer: &record.u[i],
            };
            let (used, fitted) = drive.look();
            drive.findings(dictionary, name, used, &fitted)
        })
        .collect()
}

impl Drive<'_> {
    /// The command through delay and lag.
    fn through(&self, delay: f64, lag: f64) -> Vec<f64> {
        // At the samples, where a value that stays and one that goes straight agree.
        let signal = Signal {
            t: self.t,
            u: self.command,
            hold: Hold::Linear,
        };
        let mut late: Vec<f64> = Vec::with_capacity(self.t.len());
        for ends in self.t.windows(2) {
            late.push(signal.delayed(ends[0], ends[1], delay)[0].0);
        }
        late.extend(
            self.t
                .last()
                .map(|&t| signal.delayed(t, t + 1.0, delay)[0].0),
        );
        if lag > 0.0 {
            let mut y = late.first().copied().unwrap_or(0.0);
            for k in 0..late.len() {
                let before = late[k];
                late[k] = y;
                if k + 1 < self.t.len() {
                    y = before + (y - before) * (-(self.t[k + 1] - self.t[k]) / lag).exp();
                }
            }
        }
        late
    }

    fn left(&self, [delay, lag, gain, bias]: [f64; 4]) -> Vec<f64> {
        let through = self.through(delay, lag);
        let pairs = self.answer.iter().zip(through);
        pairs.map(|(u, y)| u - bias - gain * y).collect()
    }

    /// The best gain and bias, where asked for, for a delay and a lag.
    fn at(&self, delay: f64, lag: f64, used: [bool; 4]) -> Fitted {
        let y = self.through(delay, lag);
        let n = y.len() as f64;
        let mean = |x: &[f64]| x.iter().sum::<f64>() / n;
        let (mean_y, mean_u) = match used[3] {
            true => (mean(&y), mean(self.answer)),
            false => (0.0, 0.0),
        };
        let mut gain = 1.0;
        if used[2] {
            let pairs = y.iter().zip(self.answer);
            let product: f64 = pairs.map(|(y, u)| (y - mean_y) * (u - mean_u)).sum();
            let square: f64 = y.iter().map(|y| (y - mean_y).powi(2)).sum();
            if square > 0.0 {
                gain = product / square;
            }
        }
        let values = [delay, lag, gain, mean_u - gain * mean_y];
        let squares = self.left(values).iter().map(|x| x * x).sum();
        Fitted { values, squares }
    }

    /// The best of all four, where asked for.
    fn fit(&self, used: [bool; 4]) -> Fitted {
        let step = median_step(self.t);
        let most = (LATEST / step / 0.5).min(TRIED as f64) as usize;
        let mut best = self.at(0.0, 0.0, used);
        for k in (0..=most).filter(|_| used[0]) {
            let tried = self.at(0.5 * step * k as f64, 0.0, used);
            best = better(best, tried);
        }
        let mut width = if used[0] || used[1] { step } else { 0.0 };
        for _ in 0..ROUNDS {
            let from = best.values;
            for which in [0, 1].into_iter().filter(|&which| used[which]) {
                for change in [-width, width] {
                    let mut there = [best.values[0], best.values[1]];
                    there[which] = (there[which] + change).clamp(0.0, LATEST);
                    best = better(best, self.at(there[0], there[1], used));
                    // A lag is a delay in the first place: one grows as the other shrinks.
                    if used[0] && used[1] {
                        let mut traded = there;
                        traded[1 - which] = (traded[1 - which] - change).clamp(0.0, LATEST);
                        best = better(best, self.at(traded[0], traded[1], used));
                    }
                }
            }
            if best.values == from {
                width /= 2.0;
            }
        }
        best
    }

    /// Which parts are needed, and their values.
    fn look(&self) -> ([bool; 4], Fitted) {
        let mut used = [false; 4];
        let mut now = self.fit(used);
        loop {
            let free = (0..4).filter(|&part| !used[part]);
            let trials = free.map(|part| {
                let mut more = used;
                more[part] = true;
                (more, self.fit(more))
            });
            let best = trials.min_by(|a, b| a.1.squares.total_cmp(&b.1.squares));
            let Some((more, fitted)) = best else {
                return (used, now);
            };
            if self.nats(&now, &fitted) < MARGIN
                || fitted.squares > (1.0 - LEAST_REMOVED) * now.squares
            {
                return (used, now);
            }
            (used, now) = (more, fitted);
        }
    }

    /// Nats by which the answer is more likely after one more parameter, less its price.
    fn nats(&self, before: &Fitted, after: &Fitted) -> f64 {
        let left = self.left(after.values);
        let count = left.len() as f64 * share_of_news(&left);
        let tiny = f64::MIN_POSITIVE;
        let ratio = before.squares.max(tiny) / after.squares.max(tiny);
        0.5 * count * ratio.ln() - 0.5 * count.max(1.0).ln()
    }

    fn findings(
        &self,
        dictionary: &Dictionary,
        input: &str,
        used: [bool; 4],
        fitted: &Fitted,
    ) -> Vec<Finding> {
        if used == [false; 4] {
            return Vec::new();
        }
        let known = parts(dictionary, input);
        let parts: Vec<usize> = (0..4).filter(|&part| used[part]).collect();
        let covariance = self.covariance(&parts, fitted);
        let each = parts.iter().enumerate().filter_map(|(position, &part)| {
            // What the model says of a drive already is not said again.
            let index = known[part]?;
            let parameter = dictionary.candidates[index].parameters.first()?;
            let unit = &dictionary.machine.compiled.model.parameters[*parameter].unit;
            let mut fewer = used;
            fewer[part] = false;
            let estimate = ParameterEstimate {
                value: fitted.values[part],
                std: covariance[(position, position)].max(0.0).sqrt(),
                unit: unit.clone(),
            };
            let name = dictionary.short_names(index).first()?.to_string();
            Some(Finding {
                effect: dictionary.candidates[index].subject.name().to_string(),
                on: vec![input.to_string()],
                places: vec![vec![input.to_string()]],
                parameters: BTreeMap::from([(name, estimate)]),
                evidence: self.nats(&self.fit(fewer), fitted),
                confounded_with: Vec::new(),
                same_on: Vec::new(),
                is_measured: true,
            })
        });
        each.collect()
    }

    /// Of the parts in use, by how the residual answers to each.
    fn covariance(&self, parts: &[usize], fitted: &Fitted) -> DMatrix<f64> {
        let left = self.left(fitted.values);
        let columns: Vec<DVector<f64>> = parts
            .iter()
            .map(|&part| {
                // Wide enough to smooth over the corners of a command that stays.
                let width = if part < 2 {
                    0.25 * (self.t[1] - self.t[0])
                } else {
                    1e-4
                };
                let at = |by: f64| {
                    let mut values = fitted.values;
                    values[part] = (values[part] + by).max(if part < 2 { 0.0 } else { f64::MIN });
                    (values[part], self.left(values))
                };
                let ((low, before), (high, after)) = (at(-width), at(width));
                let slope = before
                    .iter()
                    .zip(&after)
                    .map(|(a, b)| (b - a) / (high - low));
                DVector::from_vec(slope.collect())
            })
            .collect();
        let variance = rms(&left).powi(2);
        let share = share_of_news(&left);
        let normal = DMatrix::from_fn(parts.len(), parts.len(), |i, j| {
            share * columns[i].dot(&columns[j])
        });
        let none = DMatrix::from_element(parts.len(), parts.len(), f64::NAN);
        normal
            .try_inverse()
            .map_or(none, |inverse| inverse * variance)
    }
}

fn better(a: Fitted, b: Fitted) -> Fitted {
    if b.squares < a.squares { b } else { a }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt as _, SeedableRng};

    /// A command that steps now and then, and what a drive makes of it, with noise.
    fn log(delay: f64, lag: f64, gain: f64) -> (Vec<f64>, Vec<f64>, Vec<f64>) {
        let mut random = rand_chacha::ChaCha8Rng::seed_from_u64(7);
        let t: Vec<f64> = (0..2000).map(|k| 0.005 * f64::from(k)).collect();
        let mut command = vec![0.0; t.len()];
        for k in 1..t.len() {
            let steps = random.random_range(0.0..1.0) < 0.05;
            command[k] = if steps {
                random.random_range(-1.0..1.0)
            } else {
                command[k - 1]
            };
        }
        let drive = Drive {
            t: &t,
            command: &command,
            answer: &command,
        };
        let through = drive.through(delay, lag);
        let noisy = |y: &f64| gain * y + 0.01 * random.random_range(-1.0..1.0);
        let answer = through.iter().map(noisy).collect();
        (t, command, answer)
    }

    fn look(delay: f64, lag: f64, gain: f64) -> ([bool; 4], Fitted) {
        let (t, command, answer) = log(delay, lag, gain);
        let drive = Drive {
            t: &t,
            command: &command,
            answer: &answer,
        };
        drive.look()
    }

    #[test]
    fn a_drive_that_obeys_has_nothing() {
        assert_eq!(look(0.0, 0.0, 1.0).0, [false; 4]);
    }

    #[test]
    fn a_delay_between_two_columns_is_one() {
        let (used, fitted) = look(0.0123, 0.0, 1.0);
        assert_eq!(used, [true, false, false, false]);
        assert!((fitted.values[0] - 0.0123).abs() < 2e-4, "{fitted:?}");
    }

    #[test]
    fn a_delay_a_lag_and_a_gain_are_told_apart() {
        let (used, fitted) = look(0.02, 0.015, 0.8);
        assert_eq!(used, [true, true, true, false]);
        for (value, truth) in fitted.values.iter().zip([0.02, 0.015, 0.8]) {
            assert!((value / truth - 1.0).abs() < 0.05, "{fitted:?}");
        }
    }
}
