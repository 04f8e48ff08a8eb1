//! Gauss–Newton on the accepted terms: parameters, curve and the size of the forces
//! that nothing explains, together.

use super::beginning::Beginning;
use super::bounds::{free_places, limited};
use super::dictionary::Dictionary;
use super::estimate::Observed;
use super::score::{NEGLIGIBLE, deviation};
use super::settings::NO_EXCESS;
use super::settle::{Adapt, SMALLEST_SHARE, beyond_inputs, settle, unexplained};
use crate::machine::{SolveError, States};
use crate::regression::{Columns, ErrorDynamics, Gram, ProcessNoise, Readings, Smoothing};
use nalgebra::{DMatrix, DVector};

/// An explanation of the log: parameters, the motion that goes with them, and the
/// forces that they leave unexplained.
#[derive(Debug, Clone)]
pub struct Explanation {
    /// The log and the curve through it.
    pub observed: Observed,
    /// Values of all parameters of the extended model.
    pub values: Vec<f64>,
    /// The size of what is unexplained.
    pub noise: ProcessNoise,
}

/// Estimates of some parameters.
#[derive(Debug, Clone)]
pub struct Estimate {
    /// Which parameters of the extended model.
    pub parameters: Vec<usize>,
    /// Their covariance for sensors as noisy as thought.
    pub covariance: DMatrix<f64>,
    /// Negative log likelihood up to a constant of the log, and half the squares by which parameters
    /// miss what is believed of them, nats.
    pub cost: f64,
    /// Number of readings.
    pub rows: usize,
    /// Mean square of the accelerations that the unexplained forces make, as a share of
    /// the machine's own.
    pub unexplained: f64,
    /// The same of those among them that are plainly stronger than the noise of the inputs.
    pub beyond_inputs: f64,
}

impl Estimate {
    /// The parameters with their covariance.
    pub fn known(&self) -> (&[usize], &DMatrix<f64>) {
        (&self.parameters, &self.covariance)
    }

    /// Whether more than the noise of sensors remains, those of inputs among them.
    pub fn leaves_forces(&self) -> bool {
        self.beyond_inputs > NO_EXCESS * SMALLEST_SHARE * SMALLEST_SHARE
    }
}

/// Estimates with what the evidence for them is taken from.
#[derive(Debug, Clone)]
pub struct Refined {
    /// The estimates.
    pub estimate: Estimate,
    /// Whether no further step makes the log likelier; a fit may be given up before, or run out of steps.
    pub has_arrived: bool,
    /// Products of the parameters' whitened columns: the Hessian of the negative log likelihood
    /// (Gauss–Newton), without what is believed beforehand.
    pub information: DMatrix<f64>,
    /// Per parameter the change that moves the machine, or what its sensors read, as much as it
    /// moves; infinite where nothing of that is seen.
    pub reach: Vec<f64>,
}

/// Steps at most.
const STEPS: usize = 12;
/// Steps that every fit may take.
const LEAST_STEPS: usize = 2;
/// A fit is given up that would have to gain more than this many times what its last step gained,
/// or what the next one promises.
const PATIENCE: f64 = 5.0;
/// Nats; a smaller improvement ends the iteration.
const SMALL_IMPROVEMENT: f64 = 0.5;
/// How much a fit is worth.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Effort {
    /// Steps before the noise is adapted.
    pub held: usize,
    /// A fit that cannot come below this cost is given up.
    pub bar: f64,
    /// One that has come below this cost needs no better.
    pub enough: f64,
}

impl Effort {
    /// Whatever it takes.
    pub const FULL: Self = Self {
        held: 0,
        bar: f64::INFINITY,
        enough: f64::NEG_INFINITY,
    };

    /// Whether a fit at `cost`, which gained some nats at last, ends above the bar even if all that
    /// comes gains several times as much.
    pub fn is_hopeless(&self, cost: f64, gained: f64) -> bool {
        cost - PATIENCE * gained > self.bar
    }
}

/// Fits the parameters of `candidates`, starting at and writing to `explanation`, and
/// moves the curve to where the model and the sensors agree best. The noise is adapted on
/// the way.
///
/// # Errors
/// If the equation of motion cannot be solved along the curve.
pub fn refine(
    dictionary: &Dictionary,
    candidates: &[usize],
    explanation: &mut Explanation,
    effort: Effort,
) -> Result<Refined, SolveError> {
    let parameters = dictionary.parameters_of(candidates);
    refine_some(dictionary, candidates, &parameters, explanation, effort)
}

/// As [`refine`], with all parameters as they are: only the curve and the noise move.
///
/// # Errors
/// If the equation of motion cannot be solved along the curve.
pub fn refine_curve(
    dictionary: &Dictionary,
    candidates: &[usize],
    explanation: &mut Explanation,
) -> Result<Refined, SolveError> {
    refine_some(dictionary, candidates, &[], explanation, Effort::FULL)
}

/// `parameters`: those of `candidates`, or none.
fn refine_some(
    dictionary: &Dictionary,
    candidates: &[usize],
    parameters: &[usize],
    explanation: &mut Explanation,
    effort: Effort,
) -> Result<Refined, SolveError> {
    let held = effort.held;
    let focus = dictionary.focus(candidates);
    let count = parameters.len();
    let values = focus.values(&explanation.values);
    let beginning = Beginning::along(&focus, &explanation.observed, &values)?;
    let fitted: Vec<usize> = (0..count).chain(beginning.columns(count)).collect();
    let all: Vec<usize> = (0..fitted.len()).collect();
    let mut best: Option<Step> = None;
    let (mut firmness, mut detour) = (0_usize, false);
    let mut has_arrived = false;
    for step in 1..=STEPS {
        let values = focus.values(&explanation.values);
        let observed = &explanation.observed;
        let of_parameters = (count > 0).then(|| focus.columns(observed, &values));
        let of_states = focus.beginnings(observed, &values);
        let of_states = of_states.filter(|_| !beginning.is_known());
        let columns: Vec<Columns<'_>> = of_parameters.into_iter().chain(of_states).collect();
        let dynamics = ErrorDynamics::new(
            focus.mover(observed, &values),
            &columns,
            &observed.curve,
            observed.hold,
            &observed.correlation,
        );
        // Where a step leads to a place that cannot be, a shorter one may do.
        let dynamics = match (dynamics, &best) {
            (Ok(dynamics), _) => Some(dynamics),
            (Err(_), Some(_)) => None,
            (Err(error), None) => return Err(error),
        };
        let next = dynamics.and_then(|dynamics| {
            let accelerations = dynamics.accelerations();
            let observed = &explanation.observed;
            let readings = observed.readings(&focus, &explanation.values, &accelerations);
            let noise = &mut explanation.noise;
            noise.suit(&dynamics.mobility_scale);
            let adapt = if step > held {
                Adapt::ToData
            } else {
                Adapt::Not
            };
            let settled = settle(&dynamics, &readings, &fitted, noise, adapt);
            let mut beliefs = dictionary.beliefs(parameters, &explanation.values);
            beliefs.extend(beginning.beliefs(count, observed));
            let gram = settled.gram.believing(&beliefs);
            let fit = gram.fit(&all);
            let missed = 0.5 * (gram.data_misfit() - settled.gram.data_misfit());
            let price = beginning.price(&settled.gram.information(&all[count..]));
            let cost = settled.cost() + missed + price;
            let free = free_places(dictionary, (parameters, &explanation.values), (&gram, &all));
            let promised = 0.5 * (gram.data_misfit() - gram.fit(&free).misfit);
            let finite = cost.is_finite() && fit.coefficients.iter().all(|x| x.is_finite());
            let estimate = Estimate {
                parameters: parameters.to_vec(),
                covariance: fit.covariance.view((0, 0), (count, count)).into_owned(),
                cost,
                rows: gram.readings(),
                unexplained: unexplained(&dynamics, &explanation.noise),
                beyond_inputs: beyond_inputs(&dynamics, &explanation.noise),
            };
            // Without a finite solution there is no step from here.
            finite.then(|| Step {
                from: explanation.clone(),
                fitted: fitted.clone(),
                free,
                estimate,
                information: beginning.integrated(&settled.gram.information(&all)),
                dynamics,
                readings,
                gram,
                promised,
            })
        });
        let known = best
            .as_ref()
            .map_or(f64::INFINITY, |best| best.estimate.cost);
        match next {
            Some(next) if next.estimate.cost < known => {
                let improvement = known - next.estimate.cost;
                let (cost, gained) = (next.estimate.cost, improvement.max(next.promised));
                best = Some(next);
                let is_small = improvement < SMALL_IMPROVEMENT;
                has_arrived = step > 1 + held && firmness == 0 && is_small;
                if has_arrived
                    || step > held + LEAST_STEPS && effort.is_hopeless(cost, gained)
                    || cost < effort.enough
                {
                    break;
                }
                // Where a valley is narrow, it mostly is so a step farther on, too.
                firmness = match is_small {
                    true => 0,
                    false => firmness.saturating_sub(1),
                };
                detour = false;
            }
            // A valley that bends: where the way straight ahead leads uphill, the next step from
            // there may lead back to the ground, farther on.
            Some(next) if firmness == 0 && !detour && count > 0 => {
                detour = true;
                *explanation = next.next(dictionary, candidates, &beginning, DAMPING[0]);
                continue;
            }
            _ => firmness += 1,
        }
        let Some(best) = &best else { break };
        let choices = if count == 0 { 1 } else { DAMPING.len() };
        let Some(&damping) = DAMPING[..choices].get(firmness) else {
            has_arrived = true;
            break;
        };
        *explanation = best.next(dictionary, candidates, &beginning, damping);
    }
    // The best state seen, not the last one: a linearisation may mislead.
    match best {
        Some(best) => {
            let curve = &best.from.observed.curve;
            let refined = Refined {
                has_arrived,
                information: best.information,
                reach: reach(&best.dynamics, parameters.len(), curve),
                estimate: best.estimate,
            };
            *explanation = best.from;
            Ok(refined)
        }
        None => Err(SolveError::NotFinite { sample: 0 }),
    }
}

/// Damping of the steps that are tried one after the other where one leads uphill: the first shorten steps along a narrow
/// valley, the last ones all. After one that leads downhill it is the next weaker (Levenberg, Marquardt).
const DAMPING: [f64; 5] = [0.0, 1e-6, 1e-4, 1e-2, 1.0];

/// A place, and the linear equation there.
struct Step {
    from: Explanation,
    /// Which columns are fitted: those of the parameters, then of how states begin.
    fitted: Vec<usize>,
    /// Places among these of those that a step moves.
    free: Vec<usize>,
    estimate: Estimate,
    dynamics: ErrorDynamics,
    readings: Readings,
    gram: Gram,
    /// Of the readings alone.
    information: DMatrix<f64>,
    /// Nats that the linear equation promises.
    promised: f64,
}

impl Step {
    /// The place that the linear equation leads to, with some damping.
    fn next(
        &self,
        dictionary: &Dictionary,
        candidates: &[usize],
        beginning: &Beginning,
        damping: f64,
    ) -> Explanation {
        let parameters = &self.estimate.parameters;
        let count = parameters.len();
        let mut there = self.from.clone();
        let fit = self.gram.damped_fit(&self.free, damping);
        let mut steps = DVector::zeros(self.fitted.len());
        let moved = self.free.iter().zip(fit.coefficients.iter());
        moved.for_each(|(&place, step)| steps[place] = *step);
        let mut step = steps.rows(0, count).into_owned();
        dictionary.bend(candidates, &there.values, step.as_mut_slice());
        let change = limited(dictionary, parameters, &there.values, &step);
        let begun = steps.rows(count, steps.len() - count).into_owned();
        let mut whole = DVector::zeros(self.dynamics.columns);
        let columns = self.fitted.iter().zip(change.iter().chain(begun.iter()));
        columns.for_each(|(&column, step)| whole[column] = *step);
        let smoothing = Smoothing::new(&self.dynamics, &self.readings, &self.from.noise);
        there.observed.move_by(&smoothing.smooth(&whole));
        beginning.moved(&mut there.observed, &begun);
        let model = &dictionary.machine.compiled.model;
        for (i, &index) in parameters.iter().enumerate() {
            let parameter = &model.parameters[index];
            there.values[index] =
                (there.values[index] + change[i]).clamp(parameter.lower, parameter.upper);
        }
        there
    }
}

/// Per parameter the change that moves some coordinate, or what is read of it, as much as it
/// moves itself.
fn reach(dynamics: &ErrorDynamics, count: usize, curve: &States) -> Vec<f64> {
    let samples = dynamics.acceleration.len() as f64;
    let largest = dynamics.acceleration_scale.max();
    let spreads: Vec<f64> = curve.q.iter().map(|q| deviation(q)).collect();
    let read = dynamics.sensed.sizes();
    let instruments = shown_spreads(dynamics);
    let reach = |column: usize| {
        let accelerated = (0..dynamics.coordinate_count()).map(|i| {
            let own = dynamics.acceleration_scale[i];
            if own <= NEGLIGIBLE * largest {
                return 0.0;
            }
            let squares = dynamics
                .acceleration
                .iter()
                .map(|a| a[(i, column + 1)].powi(2));
            (squares.sum::<f64>() / samples).sqrt() / own
        });
        let shown = read.iter().filter(|(known, _)| *known == column);
        let shown = shown.flat_map(|(_, sizes)| {
            let each = sizes
                .iter()
                .zip(&spreads)
                .filter(|(_, spread)| **spread > 0.0);
            each.map(|(size, spread)| size / spread)
        });
        let moving = instruments.iter().filter(|(_, spread)| *spread > 0.0);
        let by_instrument = moving.map(|&(sensor, spread)| {
            let shown = dynamics.shown.iter();
            let squares = shown.map(|shown| shown.values[(sensor, column + 1)].powi(2));
            (squares.sum::<f64>() / samples).sqrt() / spread
        });
        let all = accelerated.chain(shown).chain(by_instrument);
        1.0 / all.fold(0.0, f64::max)
    };
    (0..count).map(reach).collect()
}

/// Per sensor of the model that the log may have, its place and by how much it changes along the
/// curve.
fn shown_spreads(dynamics: &ErrorDynamics) -> Vec<(usize, f64)> {
    let count = dynamics
        .shown
        .first()
        .map_or(0, |shown| shown.values.nrows());
    let along = |sensor: usize| {
        let shown = dynamics.shown.iter();
        let values: Vec<f64> = shown.map(|shown| shown.values[(sensor, 0)]).collect();
        (sensor, deviation(&values))
    };
    (0..count).map(along).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::trace::wheel::{WHEEL, begun, named, rectangular, traced};
    use std::fmt::Write;

    /// A spring that is far stiffer than where its fit begins, about another place: `i a = u − 0.8 (q − 0.7)`.
    #[test]
    fn a_spring_is_found_from_afar() {
        let mut text = String::from("t,q_angle,u_motor\n");
        let mut noise = rectangular(4);
        for k in 0..1000 {
            let t = 0.004 * f64::from(k);
            let q = 0.4 * (3.0 * t).sin() + 0.2 * (7.0 * t).sin();
            let a = -3.6 * (3.0 * t).sin() - 9.8 * (7.0 * t).sin();
            let u = 0.02 * a + 0.8 * (q - 0.7);
            writeln!(text, "{t},{},{u}", q + 1e-4 * noise()).unwrap();
        }
        let (dictionary, mut start) = begun(WHEEL, &text, ["angle", "motor"]);
        let spring = named(&dictionary, "spring(angle)");
        let [k, place] = dictionary.parameters_of(&[spring])[..] else {
            panic!("a stiffness and a place");
        };
        (start.values[k], start.values[place]) = (0.001, -0.9);
        let refined = refine(&dictionary, &[spring], &mut start, Effort::FULL).unwrap();
        assert!(refined.has_arrived);
        let found = [k, place].map(|parameter| start.values[parameter]);
        assert!((found[0] - 0.8).abs() < 2e-3, "{found:?}");
        assert!((found[1] - 0.7).abs() < 2e-3, "{found:?}");
    }

    /// Seen far from zero and over hardly more than one wave, another number of waves turns the
    /// phase: a narrow valley that bends. `i a = u + 0.2 sin(9 q) + 0.3 cos(9 q)`.
    #[test]
    fn one_wave_far_from_zero_is_found() {
        let mut text = String::from("t,q_angle,u_motor\n");
        let mut noise = rectangular(8);
        let waves = [(0.3, 3.0), (0.1, 7.0)];
        for k in 0..2500 {
            let t = 0.004 * f64::from(k);
            let q: f64 = 1.65 + waves.iter().map(|(a, w)| a * (w * t).sin()).sum::<f64>();
            let a: f64 = waves.iter().map(|(a, w)| -a * w * w * (w * t).sin()).sum();
            let force = 0.2 * (9.0 * q).sin() + 0.3 * (9.0 * q).cos();
            writeln!(text, "{t},{},{}", q + 1e-4 * noise(), 0.02 * a - force).unwrap();
        }
        let outcome = traced(WHEEL, &text);
        let [found] = &outcome.findings[..] else {
            panic!("{:#?}", outcome.findings);
        };
        assert_eq!(found.effect, "cogging");
        for (name, truth) in [("f_s", 0.2), ("f_c", 0.3), ("n", 9.0)] {
            let estimate = &found.parameters[name];
            let miss = (estimate.value - truth).abs();
            assert!(
                miss < 3.0 * estimate.std && miss < 0.05 * truth,
                "{name}: {estimate:?}"
            );
        }
    }

    /// A late sensor shows the motion some samples before, and not between these: `y(t) = q(t - τ)` with
    /// `τ` of 2.46 samples. Its readings move the curve there; where they moved it at the samples of
    /// their stamps, each step made it rougher and less likely.
    #[test]
    fn readings_of_a_late_sensor_move_the_curve_where_they_were_made() {
        const LATE: f64 = 0.0123;
        let mut text = String::from("t,q_angle,dq_angle,ddq_angle,u_motor\n");
        let mut noise = rectangular(6);
        let waves = [(0.5, 4.0), (0.1, 11.0)];
        let motion = |t: f64| {
            let each = waves.iter().map(|(a, w)| {
                let (sine, cosine) = (w * t).sin_cos();
                [a * sine, a * w * cosine, -a * w * w * sine]
            });
            each.fold([0.0; 3], |sum, wave| [0, 1, 2].map(|i| sum[i] + wave[i]))
        };
        for k in 0..1500 {
            let t = 0.005 * f64::from(k);
            let [q, v, a] = motion(t - LATE);
            let read = [q + 4e-4 * noise(), v + 4e-3 * noise(), a + 0.4 * noise()];
            let torque = 0.02 * motion(t)[2];
            writeln!(text, "{t},{},{},{},{torque}", read[0], read[1], read[2]).unwrap();
        }
        let columns: Vec<Vec<&str>> = text.lines().map(|line| line.split(',').collect()).collect();
        // With positions alone, with velocities, and with accelerations.
        for channels in 1..=3 {
            let row = |row: &Vec<&str>| [&row[..=channels], &row[4..]].concat().join(",");
            let log: Vec<String> = columns.iter().map(row).collect();
            let (dictionary, start) = begun(WHEEL, &log.join("\n"), ["angle", "motor"]);
            let late = [named(&dictionary, "time_shift(angle)")];
            let parameter = dictionary.candidates[late[0]].parameters[0];
            let mut there = start;
            there.values[parameter] = 0.011;
            let count = there.observed.curve.len();
            there.observed.move_in_time(0, &vec![0.011; count]);
            let found = refine(&dictionary, &late, &mut there, Effort::FULL).unwrap();
            let (tau, sd) = (
                there.values[parameter],
                found.estimate.covariance[(0, 0)].sqrt(),
            );
            assert!(
                sd < 1e-4 && (tau - LATE).abs() < 3.0 * sd,
                "{channels}: {tau} ± {sd}"
            );
            let mut moved = there.clone();
            let kept = refine_curve(&dictionary, &late, &mut moved).unwrap();
            let apart = kept.estimate.cost - found.estimate.cost;
            assert!(apart.abs() < SMALL_IMPROVEMENT, "{channels}: {apart}");
        }
    }
}
