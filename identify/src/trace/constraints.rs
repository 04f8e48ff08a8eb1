//! Whether the measured positions are those of the machine.
//!
//! A linkage whose log does not close has a sensor that misreads, or lengths that are wrong: both
//! can be found. Where nothing that the dictionary knows makes it close, the log is another
//! machine's.

use super::corrected::corrected;
use super::dictionary::Dictionary;
use super::error::TraceError;
use super::estimate::Observed;
use super::selection::Selection;
use super::settings::SHORTLISTED;
use crate::log::Record;
use crate::machine::{Machine, Measured, States, Terms};
use nalgebra::{DMatrix, DVector};

/// A violation below this share of the coordinates' travel (a turn counts as 1 rad) may be a
/// geometry that is a little off; above, something is wrong.
const GROSS_VIOLATION: f64 = 0.05;
/// It is not gross either below this many times what sensor noise explains.
const NOISES: f64 = 20.0;
/// Share of the squares of a gross violation that one candidate must explain, to first order, for
/// the log to be this machine's.
const EXPLAINED: f64 = 0.75;
/// Steps in which a candidate is brought to close a linkage.
const STEPS: usize = 6;

/// Shares by which a length is changed, up and down, where no small change closes a linkage, and
/// the samples that are looked at.
const SHARES: std::ops::RangeInclusive<i32> = 1..=50;
const PERCENT: f64 = 0.01;
const SAMPLES: usize = 500;

/// Holonomic constraints must hold in the measured positions themselves, or with one of the
/// dictionary's sensors' errors or lengths. Positions that were estimated from other sensors say nothing yet: one
/// of those that is late keeps a linkage open, until it is found.
///
/// # Errors
/// If one is grossly missed, and nothing known mends that.
pub(super) fn check_measured(
    dictionary: &Dictionary,
    observed: &Observed,
) -> Result<(), TraceError> {
    if !observed.record.is_wholly_measured() {
        return Ok(());
    }
    let focus = dictionary.focus(&[]);
    let values = focus.values(&dictionary.defaults);
    let found = gross_violation(&focus.machine, &values, &observed.record, observed);
    match found {
        Some(found)
            if closers(dictionary, observed).is_empty()
                && !another_length_closes(dictionary, observed) =>
        {
            Err(found)
        }
        _ => Ok(()),
    }
}

/// The same of the positions that the accepted terms make of the measured ones.
///
/// # Errors
/// If a holonomic constraint is still grossly missed, or the log cannot be filtered.
pub(super) fn check_corrected(
    dictionary: &Dictionary,
    selection: &Selection,
) -> Result<(), TraceError> {
    let focus = dictionary.focus(&selection.accepted());
    if focus.machine.holonomic_rows().is_empty() {
        return Ok(());
    }
    let values = focus.values(&selection.values);
    let observed = &selection.observed;
    let mut record = corrected(&observed.record, &focus, &values)?;
    let estimated = (0..record.q.len()).filter(|&i| !observed.record.is_measured(i));
    estimated.for_each(|i| record.q[i].clone_from(&observed.curve.q[i]));
    gross_violation(&focus.machine, &values, &record, observed).map_or(Ok(()), Err)
}

/// States with the positions as they were measured.
fn as_measured(record: &Record, observed: &Observed) -> States {
    States {
        q: record.q.clone(),
        ..observed.curve.clone()
    }
}

/// The first holonomic constraint that the positions of `record` grossly miss.
fn gross_violation(
    machine: &Machine,
    values: &[f64],
    record: &Record,
    observed: &Observed,
) -> Option<TraceError> {
    let terms = machine.terms(&as_measured(record, observed), values);
    let travel: Vec<f64> = observed
        .ranges()
        .positions
        .iter()
        .map(|sorted| sorted[sorted.len() - 1] - sorted[0])
        .collect();
    for row in machine.holonomic_rows() {
        let (mut square, mut noise, mut scale, mut worst) = (0.0, 0.0, 0.0_f64, (0.0, 0.0));
        for (sample, at) in terms.iter().enumerate() {
            let c = at.constraint_residual[row];
            square += c * c;
            if c.abs() > worst.1 {
                worst = (record.t[sample], c.abs());
            }
            for i in 0..travel.len() {
                let slope = at.constraint_matrix[(row, i)];
                noise += (slope * observed.position_sd[i]).powi(2);
                scale = scale.max((slope * travel[i].min(1.0)).abs());
            }
        }
        let violation = (square / terms.len() as f64).sqrt();
        let expected = (noise / terms.len() as f64).sqrt();
        if !(violation <= NOISES * expected || violation <= GROSS_VIOLATION * scale) {
            let (time, worst) = worst;
            return Some(TraceError::Constraint {
                constraint: machine.compiled.model.constraints[row].name.clone(),
                violation,
                expected,
                time,
                worst,
            });
        }
    }
    None
}

/// Which candidates, with which values of all parameters, make positions fulfil holonomic constraints
/// that are grossly missed as they were measured: the best first, and none where the constraints hold.
pub(super) fn closing(dictionary: &Dictionary, observed: &Observed) -> Vec<(usize, Vec<f64>)> {
    let focus = dictionary.focus(&[]);
    let values = focus.values(&dictionary.defaults);
    if gross_violation(&focus.machine, &values, &observed.record, observed).is_none() {
        return Vec::new();
    }
    let first = closers(dictionary, observed).into_iter().take(SHORTLISTED);
    let mut closing: Vec<Closer> = first.map(|one| one.closed(dictionary, observed)).collect();
    closing.sort_by(|a, b| a.left.total_cmp(&b.left));
    let closing = closing.into_iter();
    closing.map(|one| (one.candidate, one.values)).collect()
}

/// A candidate, a sensor's or a length, with the values of all parameters with which it explains most of
/// what constraints are missed by.
#[derive(Debug, Clone)]
struct Closer {
    candidate: usize,
    values: Vec<f64>,
    /// Sum of squares of what constraints are missed by then, to first order.
    left: f64,
}

impl Closer {
    /// Brought to close as well as it can, by Gauss's and Newton's method: a sensor that is late by more than
    /// the motion is slow is far from what first order says.
    fn closed(self, dictionary: &Dictionary, observed: &Observed) -> Self {
        let focus = dictionary.focus(&[self.candidate]);
        let mut best = self;
        for _ in 0..STEPS {
            let read = corrected(&observed.record, &focus, &focus.values(&best.values));
            let next = read.ok().and_then(|record| {
                let missed = Missed::new(dictionary, observed, (&record, &best.values));
                missed.closer(best.candidate)
            });
            match next {
                Some(next) if next.left < best.left => best = next,
                _ => break,
            }
        }
        best
    }
}

/// Candidates that by themselves explain most of what the constraints are missed by, to first order; the
/// best first.
fn closers(dictionary: &Dictionary, observed: &Observed) -> Vec<Closer> {
    let start = (&observed.record, &dictionary.defaults[..]);
    let missed = Missed::new(dictionary, observed, start);
    let all = 0..dictionary.candidates.len();
    let closers = all.filter_map(|candidate| missed.closer(candidate));
    let most = (1.0 - EXPLAINED) * missed.missed.norm_squared();
    let mut closers: Vec<Closer> = closers.filter(|closer| closer.left < most).collect();
    closers.sort_by(|a, b| a.left.total_cmp(&b.left));
    closers
}

/// What constraints are missed by along positions, and what parameters change of it.
struct Missed<'a> {
    dictionary: &'a Dictionary,
    values: &'a [f64],
    terms: Vec<Terms>,
    rows: Vec<usize>,
    /// What sensors read of these positions, with slopes.
    read: Measured,
    /// Per parameter that constraints hold, row and sample what it changes.
    slopes: Vec<Vec<Vec<f64>>>,
    /// Row after row, sample by sample.
    missed: DVector<f64>,
}

impl<'a> Missed<'a> {
    fn new(
        dictionary: &'a Dictionary,
        observed: &Observed,
        (record, values): (&Record, &'a [f64]),
    ) -> Self {
        let machine = &dictionary.machine;
        let states = as_measured(record, observed);
        let states = machine.at_rest(&states, values);
        let terms = machine.terms(&states, values);
        let rows = machine.holonomic_rows();
        let sensors = &dictionary.sensors;
        let still = vec![vec![0.0; states.len()]; machine.coordinate_count()];
        let missed = rows.iter().flat_map(|&row| {
            let each = terms.iter();
            each.map(move |at| at.constraint_residual[row])
        });
        Self {
            missed: DVector::from_iterator(rows.len() * states.len(), missed),
            read: sensors.read(&states, &still, values),
            slopes: sensors.closure.slopes(&states, values),
            dictionary,
            values,
            terms,
            rows,
        }
    }

    /// What a unit of a parameter adds to all constraints at all samples: directly, and by moving
    /// the positions that were read; `None` if it does neither.
    fn column(&self, parameter: usize) -> Option<DVector<f64>> {
        let sensors = &self.dictionary.sensors;
        let length = sensors.closure.closing.iter().position(|&p| p == parameter);
        let sensor = sensors.sensing.iter().position(|&p| p == parameter);
        if length.is_none() && sensor.is_none() {
            return None;
        }
        let at = |sample: usize, place: usize| {
            let direct = length.map_or(0.0, |length| self.slopes[length][place][sample]);
            let moved = sensor.map_or(0.0, |sensor| {
                let gradient = self.terms[sample].constraint_matrix.row(self.rows[place]);
                let each = gradient.iter().zip(&self.read.q_by[sensor]);
                each.map(|(a, by)| a * by[sample]).sum()
            });
            direct - moved
        };
        let places = 0..self.rows.len();
        let all = places.flat_map(|place| (0..self.terms.len()).map(move |s| at(s, place)));
        Some(DVector::from_iterator(self.missed.len(), all))
    }

    /// A candidate as it closes best, to first order; `None` if it closes nothing.
    fn closer(&self, candidate: usize) -> Option<Closer> {
        let bounds = &self.dictionary.machine.compiled.model.parameters;
        let parameters = self.dictionary.candidates[candidate].parameters.iter();
        let known = parameters.filter_map(|&p| Some((p, self.column(p)?)));
        let (parameters, columns): (Vec<usize>, Vec<DVector<f64>>) = known.unzip();
        if columns.is_empty() {
            return None;
        }
        let columns = DMatrix::from_columns(&columns);
        let fitted = columns.clone().svd(true, true);
        let fitted = fitted.solve(&self.missed, f64::EPSILON).ok()?;
        let mut values = self.values.to_vec();
        for (&p, step) in parameters.iter().zip(fitted.iter()) {
            values[p] = (values[p] - step).clamp(bounds[p].lower, bounds[p].upper);
        }
        Some(Closer {
            candidate,
            values,
            left: (&self.missed - &columns * &fitted).norm_squared(),
        })
    }
}

/// Whether another value of a single parameter explains most of what the constraints are missed
/// by. A demanded motion whose rate is a little off is soon out of step, and first order says
/// nothing of that.
fn another_length_closes(dictionary: &Dictionary, observed: &Observed) -> bool {
    let machine = &dictionary.machine;
    let states = as_measured(&observed.record, observed).spread(SAMPLES);
    let states = machine.at_rest(&states, &dictionary.defaults);
    let rows = machine.holonomic_rows();
    let missed = |values: &[f64]| -> f64 {
        let terms = machine.terms(&states, values);
        let residual = |at: &Terms| at.constraint_residual.select_rows(&rows).norm_squared();
        terms.iter().map(residual).sum()
    };
    let now = missed(&dictionary.defaults);
    let closes = |(parameter, share): (usize, f64)| {
        let mut values = dictionary.defaults.clone();
        values[parameter] *= 1.0 + share;
        let bounds = &machine.compiled.model.parameters[parameter];
        (bounds.lower..=bounds.upper).contains(&values[parameter])
            && missed(&values) < (1.0 - EXPLAINED) * now
    };
    let closing = dictionary.sensors.closure.closing.iter();
    let mut tried = closing.flat_map(|&parameter| {
        let shares = SHARES.map(|share| PERCENT * f64::from(share));
        shares.flat_map(move |share| [(parameter, share), (parameter, -share)])
    });
    tried.any(closes)
}

#[cfg(test)]
mod tests {
    use crate::trace::wheel::{rectangular, traced};
    use crate::trace::{Finding, Outcome, Verdict};
    use std::fmt::Write;

    /// A cam and its follower.
    const CAM: &str = "\
model cam;
coordinate angle: rad;
coordinate height: m;
input angle: N*m;
parameter i: kg*m^2 = 0.02;
parameter m: kg = 0.5;
parameter lift: m = 0.1;
kinetic i/2*dot(angle)^2 + m/2*dot(height)^2;
force angle = input(angle);
constraint cam: height == lift*(angle^2 + angle);
";

    /// A log of a cam with this lift, whose angle is read with an offset: `a = 0.5 sin 2t + 0.3 sin 5t`,
    /// `b = l (a² + a)`, and by d'Alembert `u = i a″ + m b″ ∂b/∂a`.
    fn log(lift: f64, offset: f64) -> String {
        let mut text = String::from("t,q_angle,q_height,u_angle\n");
        let waves = [(0.5_f64, 2.0_f64), (0.3, 5.0)];
        let mut noise = rectangular(9);
        for k in 0..2000 {
            let t = 0.005 * f64::from(k);
            let a: f64 = waves.iter().map(|(x, w)| x * (w * t).sin()).sum();
            let v: f64 = waves.iter().map(|(x, w)| x * w * (w * t).cos()).sum();
            let acceleration: f64 = waves.iter().map(|(x, w)| -x * w * w * (w * t).sin()).sum();
            let slope = lift * (2.0 * a + 1.0);
            let rise = slope * acceleration + 2.0 * lift * v * v;
            let u = 0.02 * acceleration + 0.5 * rise * slope;
            let read = [
                a + offset + 4e-4 * noise(),
                lift * (a * a + a) + 1e-4 * noise(),
            ];
            writeln!(text, "{t},{},{},{u}", read[0], read[1]).unwrap();
        }
        text
    }

    fn only(outcome: &Outcome) -> &Finding {
        let [finding] = &outcome.findings[..] else {
            panic!("{:#?}", outcome.findings);
        };
        finding
    }

    #[test]
    fn what_closes_is_the_machine() {
        assert_eq!(traced(CAM, &log(0.1, 0.0)).verdict, Verdict::None);
    }

    /// Also one that no geometry a little off explains.
    #[test]
    fn an_offset_breaks_the_constraint() {
        for offset in [0.02, -0.3] {
            let outcome = traced(CAM, &log(0.1, offset));
            let found = only(&outcome);
            assert_eq!(outcome.verdict, Verdict::Channel);
            assert_eq!(
                (found.effect.as_str(), &found.on[0][..]),
                ("measurement_offset", "angle")
            );
            let estimate = &found.parameters["offset"];
            let miss = (estimate.value - offset).abs();
            assert!(
                miss < 3.0 * estimate.std + 1e-6 && miss < 1e-4,
                "{estimate:?}"
            );
        }
    }

    /// An encoder that is so late that the cam does not close is found by what closes it.
    #[test]
    fn a_late_encoder_breaks_the_constraint() {
        if left_out::too_slow() {
            return;
        }
        let (mut text, mut noise) = (String::from("t,q_angle,q_height,u_angle\n"), rectangular(9));
        let angle = |t: f64| 0.5 * (2.0 * t).sin() + 0.3 * (5.0 * t).sin();
        for (k, line) in log(0.1, 0.0).lines().skip(1).enumerate() {
            let cells: Vec<&str> = line.split(',').collect();
            let late = angle(0.005 * k as f64 - 0.08) + 4e-4 * noise();
            writeln!(text, "{},{late},{},{}", cells[0], cells[2], cells[3]).unwrap();
        }
        let outcome = traced(CAM, &text);
        let found = only(&outcome);
        assert_eq!(
            (found.effect.as_str(), &found.on[0][..]),
            ("time_shift", "angle")
        );
        let estimate = &found.parameters["tau"];
        assert!(
            (estimate.value - 0.08).abs() < 3.0 * estimate.std + 1e-4,
            "{estimate:?}"
        );
    }

    #[test]
    fn a_length_that_is_wrong_is_a_parameter() {
        let outcome = traced(CAM, &log(0.104, 0.0));
        let found = only(&outcome);
        assert_eq!(outcome.verdict, Verdict::Parameter);
        assert_eq!(found.on, ["lift"]);
        let estimate = &found.parameters["lift"];
        assert!((estimate.value - 0.104).abs() < 1e-5, "{estimate:?}");
    }

    /// A piston that is driven up and down, beside a wheel.
    const PISTON: &str = "\
model piston;
coordinate angle: rad;
coordinate height: m;
input angle: N*m;
parameter i: kg*m^2 = 0.02;
parameter m: kg = 0.5;
parameter lift: m = 0.1;
parameter rate: rad/s = 4;
kinetic i/2*dot(angle)^2 + m/2*dot(height)^2;
force angle = input(angle);
constraint stroke: height == lift*sin(rate*t);
";

    /// Ten seconds at a rate that is 7 % off end most of half a turn out of step.
    #[test]
    fn a_rate_that_runs_out_of_step_is_a_parameter() {
        let mut text = String::from("t,q_angle,q_height,u_angle\n");
        let mut noise = rectangular(5);
        for k in 0..2000 {
            let t = 0.005 * f64::from(k);
            let (a, height) = (0.5 * (2.0 * t).sin(), 0.1 * (4.28 * t).sin());
            let u = -0.02 * 4.0 * a;
            let read = [a + 4e-4 * noise(), height + 1e-4 * noise()];
            writeln!(text, "{t},{},{},{u}", read[0], read[1]).unwrap();
        }
        let outcome = traced(PISTON, &text);
        let found = only(&outcome);
        assert_eq!(outcome.verdict, Verdict::Parameter);
        assert_eq!(found.on, ["rate"]);
        let estimate = &found.parameters["rate"];
        assert!((estimate.value - 4.28).abs() < 1e-4, "{estimate:?}");
    }
}
