//! Forces that nothing explains: as large as the log says, beside a model and its columns.

use super::score::NEGLIGIBLE;
use super::settings::NO_EXCESS;
use crate::log::median_step;
use crate::regression::{ErrorDynamics, Fit, Gram, ProcessNoise, Readings, Whitener};
use nalgebra::DVector;

/// A force error below this share of a coordinate's forces is not worth a name: what no
/// rigid-body model of a machine is claimed to reach.
pub const SMALLEST_SHARE: f64 = 1e-3;
/// Forces that change from sample to sample are at least this share of a coordinate's forces.
const SMALLEST_JITTER: f64 = 1e-4;
/// A constraint that is missed by this share of its reach is not worth a name: what no
/// machine's lengths are claimed to be known to.
const SMALLEST_CLOSURE: f64 = 1e-4;
/// Where nothing moves a constraint, it is known to this many of its units.
const ROUND_OFF: f64 = 1e-12;
/// How often the noise is adapted per linearisation.
const NOISE_ROUNDS: usize = 3;
/// The most that one adaptation changes a variance by.
const NOISE_FACTOR: f64 = 30.0;

/// Unexplained forces of a `share` of those of the model as given.
pub fn noise(dynamics: &ErrorDynamics, share: f64) -> ProcessNoise {
    let closed = &dynamics.closed;
    let least = |reach: f64| (reach * SMALLEST_CLOSURE).max(ROUND_OFF);
    let smallest_closure = closed.reach.map(least);
    let smallest_jitter = smallest_jitter(dynamics);
    ProcessNoise {
        force_sd: &dynamics.force_scale * share,
        smallest: &dynamics.force_scale * SMALLEST_SHARE,
        mobility: dynamics.mobility_scale.clone(),
        jitter: &smallest_jitter * FIRST_JITTER,
        smallest_jitter,
        unseen: FIRST_UNSEEN,
        closure_sd: closed.violation().sup(&smallest_closure),
        smallest_closure,
    }
}

/// A whitener whose noise suits the log, and the fit under it.
pub struct Settled<'a> {
    /// The filter.
    pub whitener: Whitener<'a>,
    /// Products of data and columns.
    pub gram: Gram,
    /// The columns' fit.
    pub fit: Fit,
}

impl Settled<'_> {
    /// Negative log likelihood of the data as they stand, nats.
    pub fn cost(&self) -> f64 {
        self.whitener.log_sd() + 0.5 * self.gram.data_misfit()
    }

    /// The same after the fit.
    pub fn cost_of_fit(&self) -> f64 {
        self.whitener.log_sd() + 0.5 * self.fit.misfit
    }
}

/// What noise is adapted to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Adapt {
    /// To nothing: it stays as it is.
    Not,
    /// To the data as they stand.
    ToData,
    /// To what the columns leave of the data.
    ToFit,
}

/// Fits `columns` and adapts `noise` in turn: `σ² ← σ² · Σλ²/ΣΛ`, which is stationary
/// where the likelihood is.
pub fn settle<'a>(
    dynamics: &'a ErrorDynamics,
    readings: &'a Readings,
    columns: &[usize],
    noise: &mut ProcessNoise,
    adapt: Adapt,
) -> Settled<'a> {
    let smallest = noise.smallest.clone();
    let largest_jitter = smallest_jitter(dynamics) * LARGEST_JITTER;
    let own: Vec<usize> = (0..columns.len()).collect();
    let fitted = |whitener: &Whitener<'_>| {
        let gram = whitener.gram(columns);
        let fit = gram.fit(&own);
        (gram, fit)
    };
    for round in 0.. {
        let whitener = Whitener::new(dynamics, readings, noise);
        let mut known = None;
        if adapt != Adapt::Not && round < NOISE_ROUNDS {
            let mut coefficients = DVector::zeros(dynamics.columns);
            if adapt == Adapt::ToFit {
                let (_, fit) = known.insert(fitted(&whitener));
                for (&column, &value) in columns.iter().zip(fit.coefficients.iter()) {
                    coefficients[column] = value;
                }
            }
            let evidence = whitener.noise_evidence(&coefficients);
            let mut change: f64 = 0.0;
            let mut adapt = |old: &mut f64, ratio: f64, smallest: f64, largest: f64| {
                let factor = ratio.clamp(1.0 / NOISE_FACTOR, NOISE_FACTOR).sqrt();
                let new = (*old * factor).clamp(smallest, largest.max(smallest));
                let (new, known) = (new.max(f64::MIN_POSITIVE), old.max(f64::MIN_POSITIVE));
                change = change.max((new / known).ln().abs());
                *old = new;
            };
            for i in 0..smallest.len() {
                let old = noise.force_sd[i];
                let ratio = if evidence.information[i] * old * old > INVISIBLE_FORCE {
                    evidence.score[i] / evidence.information[i]
                } else {
                    0.0
                };
                adapt(
                    &mut noise.force_sd[i],
                    ratio,
                    smallest[i],
                    smallest[i] * LARGEST,
                );
            }
            for i in 0..noise.jitter.len() {
                let (old, least) = (noise.jitter[i], noise.smallest_jitter[i]);
                let ratio = match evidence.jitter_information[i] * old * old > INVISIBLE_FORCE {
                    true => evidence.jitter_score[i] / evidence.jitter_information[i],
                    false => 0.0,
                };
                adapt(&mut noise.jitter[i], ratio, least, largest_jitter[i]);
            }
            let (score, information) = (evidence.unseen_score, evidence.unseen_information);
            if score.max(information) * noise.unseen.powi(2) > INDIFFERENT {
                let ratio = score / information;
                adapt(&mut noise.unseen, ratio, SMALLEST_UNSEEN, LARGEST_UNSEEN);
            }
            for row in 0..noise.closure_sd.len() {
                let ratio = evidence.closure_score[row] / evidence.closure_information[row];
                let least = noise.smallest_closure[row];
                adapt(&mut noise.closure_sd[row], ratio, least, f64::INFINITY);
            }
            if change > SETTLED {
                continue;
            }
        }
        let (gram, fit) = known.unwrap_or_else(|| fitted(&whitener));
        return Settled {
            whitener,
            gram,
            fit,
        };
    }
    unreachable!("the loop ends by returning")
}

/// `σ²Λ` below which a force is hidden by constraints.
const INVISIBLE_FORCE: f64 = 1e-9;
/// Largest unexplained force, in units of the smallest: three times the scale.
const LARGEST: f64 = 3.0 / SMALLEST_SHARE;
/// White forces to begin with, in units of the smallest: a hundredth of the scale.
const FIRST_JITTER: f64 = 0.01 / SMALLEST_JITTER;
/// Largest white force, in units of the smallest beside inputs without noise: a tenth of the scale, more
/// than the noise of a torque that was measured; where that is known to be larger, as large as it is.
const LARGEST_JITTER: f64 = 0.1 / SMALLEST_JITTER;
/// Nats that what inputs do between samples may be worth before it is adapted: of smooth inputs nothing depends on it.
const INDIFFERENT: f64 = 0.5;
/// What inputs do between samples to begin with, at least and at most, as shares of how much they bend. What
/// bends smoothly leaves a straight line by a twelfth.
const FIRST_UNSEEN: f64 = 0.03;
const SMALLEST_UNSEEN: f64 = 1e-4;
const LARGEST_UNSEEN: f64 = 1.0;
/// Change of `ln σ` below which nothing is adapted further.
const SETTLED: f64 = 0.03;

/// Mean square of the accelerations that forces beyond the smallest make, each as a share of the
/// coordinate's own.
pub fn unexplained(dynamics: &ErrorDynamics, noise: &ProcessNoise) -> f64 {
    share_of_accelerations(dynamics, &excess(noise))
}

/// The same of those forces that are plainly stronger than the known noise of the inputs.
pub fn beyond_inputs(dynamics: &ErrorDynamics, noise: &ProcessNoise) -> f64 {
    let known = strength_of_inputs(dynamics, noise);
    let beyond = excess(noise).zip_map(&known, |excess, known| match excess > NO_EXCESS * known {
        true => excess,
        false => 0.0,
    });
    share_of_accelerations(dynamics, &beyond)
}

/// Variance of forces beyond the smallest.
fn excess(noise: &ProcessNoise) -> DVector<f64> {
    let squares = |x: &DVector<f64>| x.component_mul(x);
    squares(&noise.force_sd) - squares(&noise.smallest)
}

/// Variance of lasting forces that are at low frequencies as strong as the known noise of inputs,
/// `σ √Δt`: `σ² Δt/2τ`.
fn strength_of_inputs(dynamics: &ErrorDynamics, noise: &ProcessNoise) -> DVector<f64> {
    let least = smallest_jitter(dynamics);
    DVector::from_fn(dynamics.coordinate_count(), |j, _| {
        let known = noise.smallest_jitter[j].powi(2) - least[j].powi(2);
        known.max(0.0) / (2.0 * dynamics.correlation[j])
    })
}

/// White forces of the smallest share.
fn smallest_jitter(dynamics: &ErrorDynamics) -> DVector<f64> {
    &dynamics.force_scale * (SMALLEST_JITTER * median_step(&dynamics.t).sqrt())
}

/// Mean square of the accelerations `P f` of forces of some variances, each as a share of the
/// coordinate's own.
fn share_of_accelerations(dynamics: &ErrorDynamics, variance: &DVector<f64>) -> f64 {
    let n = dynamics.coordinate_count();
    let mut forced = DVector::<f64>::zeros(n);
    let mut own = DVector::<f64>::zeros(n);
    for (slope, acceleration) in dynamics.slope.iter().zip(&dynamics.acceleration) {
        for i in 0..n {
            own[i] += acceleration[(i, 0)].powi(2);
            for j in 0..n {
                forced[i] += slope[(i, 2 * n + j)].powi(2) * variance[j];
            }
        }
    }
    let moving = NEGLIGIBLE.powi(2) * own.iter().copied().fold(0.0, f64::max);
    let shares = (0..n).map(|i| {
        // What moves by round-off alone has no size to take a share of.
        if own[i] > moving {
            forced[i] / own[i]
        } else {
            0.0
        }
    });
    shares.sum::<f64>() / n as f64
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::trace::Verdict;
    use crate::trace::linearised::{first_noise, linearised};
    use crate::trace::progress::Silent;
    use crate::trace::wheel::{WHEEL, begun, rectangular, traced};
    use std::fmt::Write;

    /// The log of a wheel whose torque was measured with noise of 3 % that it never felt.
    fn noisy_torque() -> String {
        let mut text = String::from("t,q_angle,u_motor\n");
        let (mut noise, mut error) = (rectangular(8), rectangular(9));
        let waves = [(0.9, 3.0), (0.5, 7.0)];
        for k in 0..2000 {
            let t = 0.004 * f64::from(k);
            let q: f64 = waves.iter().map(|(a, w)| a * (w * t).sin()).sum();
            let a: f64 = waves.iter().map(|(a, w)| -a * w * w * (w * t).sin()).sum();
            let u = 0.02 * a + 0.03 * 0.3 * 12.0_f64.sqrt() * error();
            writeln!(text, "{t},{},{u}", q + 2e-5 * noise()).unwrap();
        }
        text
    }

    #[test]
    fn noise_in_a_torque_is_no_missing_force() {
        let outcome = traced(WHEEL, &noisy_torque());
        assert_eq!(outcome.verdict, Verdict::None, "{:#?}", outcome.findings);
        assert!(outcome.findings.is_empty());
    }

    /// A lasting force is as strong as white noise where `2 τ σ_force² = σ² Δt`; it accelerates the wheel
    /// by as much over its inertia.
    #[test]
    fn forces_weaker_than_a_torques_noise_are_not_searched_for() {
        let (dictionary, start) = begun(WHEEL, &noisy_torque(), ["angle", "motor"]);
        let felt = start.observed.as_felt(&dictionary, false, &Silent).unwrap();
        let taken = felt.input_noise[0].taken;
        assert!(taken > 0.0);
        let dynamics = linearised(&dictionary.focus(&[]), &felt, &start.values).unwrap();
        let mut noise = first_noise(&dictionary.focus(&[]), &felt, &start.values).unwrap();
        let variance = taken.powi(2) * 0.004 / (2.0 * 0.1);
        let mut beyond = |factor: f64| {
            noise.force_sd[0] = (factor * variance + noise.smallest[0].powi(2)).sqrt();
            beyond_inputs(&dynamics, &noise)
        };
        assert_eq!(beyond(2.9), 0.0);
        let squares = felt.curve.t.iter().map(|t| {
            let a = -8.1 * (3.0 * t).sin() - 24.5 * (7.0 * t).sin();
            a * a
        });
        let mean = squares.sum::<f64>() / felt.curve.t.len() as f64;
        let share = 3.1 * variance / 0.02_f64.powi(2) / mean;
        let found = beyond(3.1);
        assert!((found / share - 1.0).abs() < 0.05, "{found} {share}");
    }

    /// A torque that is mostly noise which the machine did not feel, of which a part is known: white forces are
    /// no larger than a tenth of what acts, and no smaller than what is known of them.
    #[test]
    fn white_forces_are_bounded_by_what_acts_and_not_by_known_noise() {
        let mut text = String::from("t,q_angle,u_motor\n");
        let (mut read, mut error) = (rectangular(8), rectangular(9));
        for k in 0..2000 {
            let t = 0.004 * f64::from(k);
            let u = -0.18 * (3.0 * t).sin() + 3.0 * error();
            writeln!(text, "{t},{},{u}", (3.0 * t).sin() + 2e-5 * read()).unwrap();
        }
        let (dictionary, start) = begun(WHEEL, &text, ["angle", "motor"]);
        let focus = dictionary.focus(&[]);
        let dynamics = linearised(&focus, &start.observed, &start.values).unwrap();
        let accelerations = dynamics.accelerations();
        let readings = start
            .observed
            .readings(&focus, &start.values, &accelerations);
        let tenth = 0.1 * dynamics.force_scale[0] * 0.004_f64.sqrt();
        for known in [0.2, 3.0] {
            let mut own = noise(&dynamics, 0.01);
            own.smallest_jitter[0] = known * tenth;
            own.jitter[0] = known * tenth;
            settle(&dynamics, &readings, &[], &mut own, Adapt::ToData);
            let expected = known.max(1.0) * tenth;
            let jitter = own.jitter[0];
            assert!(
                (jitter / expected - 1.0).abs() < 1e-9,
                "{jitter} {expected}"
            );
        }
    }

    /// An encoder whose errors last for 20 ms, four samples, looks like a faint force to a filter that
    /// takes them for white.
    #[test]
    fn errors_that_last_are_no_missing_force() {
        if left_out::too_slow() {
            return;
        }
        let mut text = String::from("t,q_angle,u_motor\n");
        let (mut white, mut error) = (rectangular(8), 0.0);
        let kept = (-0.25_f64).exp();
        for k in 0..3000 {
            let t = 0.005 * f64::from(k);
            error = kept * error + (1.0 - kept * kept).sqrt() * white();
            let q = (3.0 * t).sin() + 2e-3 * error;
            writeln!(text, "{t},{q},{}", -0.18 * (3.0 * t).sin()).unwrap();
        }
        let outcome = traced(WHEEL, &text);
        assert_eq!(outcome.verdict, Verdict::None, "{:#?}", outcome.remaining);
        assert!(outcome.remaining.forces.is_empty());
        assert!((outcome.misfit_after - 1.0).abs() < 0.2, "{outcome:#?}");
        insta::assert_snapshot!(outcome.warnings.join("\n"), @"the errors of `q_angle` follow one another, each 73 % like the one before: its samples are given as much less weight");
    }

    /// `∂ ln L/∂ ln s = s² (score − information)`, by the likelihood itself, of white forces and of what inputs
    /// do between samples.
    #[test]
    fn the_likelihood_rises_with_quick_forces_as_their_evidence_says() {
        let (dictionary, start) = begun(WHEEL, &noisy_torque(), ["angle", "motor"]);
        let dynamics = linearised(&dictionary.focus(&[]), &start.observed, &start.values).unwrap();
        let focus = dictionary.focus(&[]);
        let accelerations = dynamics.accelerations();
        let readings = start
            .observed
            .readings(&focus, &start.values, &accelerations);
        for (share, unseen) in [(0.01, 0.01), (0.1, 0.3)] {
            let mut noise = noise(&dynamics, 0.01);
            noise.jitter = &noise.smallest_jitter * (share / SMALLEST_JITTER);
            noise.unseen = unseen;
            let cost = |noise: &ProcessNoise| {
                settle(&dynamics, &readings, &[], &mut noise.clone(), Adapt::Not).cost()
            };
            let whitener = Whitener::new(&dynamics, &readings, &noise);
            let evidence = whitener.noise_evidence(&DVector::zeros(0));
            let step = 1e-4_f64;
            let slope = |scaled: fn(&mut ProcessNoise) -> &mut f64| {
                let [less, more] = [-step, step].map(|step| {
                    let mut other = noise.clone();
                    *scaled(&mut other) *= step.exp();
                    cost(&other)
                });
                (less - more) / (2.0 * step)
            };
            let of_white = evidence.jitter_score[0] - evidence.jitter_information[0];
            let of_unseen = evidence.unseen_score - evidence.unseen_information;
            let pairs = [
                (
                    slope(|n| &mut n.jitter[0]),
                    noise.jitter[0].powi(2) * of_white,
                ),
                (slope(|n| &mut n.unseen), noise.unseen.powi(2) * of_unseen),
            ];
            for (slope, expected) in pairs {
                assert!(
                    (slope - expected).abs() < 1e-3 * expected.abs() + 0.1,
                    "{slope} {expected}"
                );
            }
        }
    }
}
