//! Readings that the machine contradicts: wild samples that their neighbours alone do not show, beside quick
//! motion, or among others.
//!
//! One acceleration in ten thousand that is hundreds of its noise away outweighs all that a model can
//! explain. Each reading is held against what the model as given, beside forces as large as the log says, and
//! all other readings say of it ([`Auxiliary`]). One that is far off there is wild if all is usual without it:
//! beside a law that the model lacks its neighbours are off as well.

use super::dictionary::Dictionary;
use super::estimate::Observed;
use super::linearised::{first_noise, linearised};
use super::settle::{Adapt, settle};
use crate::log::{BESIDE, Log, ORDINARY, RARE, Record, Warning, ordinary_sizes, stands_out};
use crate::machine::SolveError;
use crate::regression::{Auxiliary, Whitener};
use crate::smooth::SmoothError;
use std::collections::BTreeMap;

/// Wild samples hide others: how often the rest is looked at again.
const PASSES: usize = 4;

/// The log without the readings that the machine contradicts, each with a warning that says where it stands
/// in `log`. A log of other sensors than those of coordinates stays as it is, and so does one of which the
/// model as given says nothing.
///
/// # Errors
/// If what is left cannot be smoothed.
pub(super) fn set_aside(
    dictionary: &Dictionary,
    mut observed: Observed,
    log: &Log,
) -> Result<Observed, SmoothError> {
    if !observed.record.is_wholly_measured() {
        return Ok(observed);
    }
    for _ in 0..PASSES {
        let wild = wild(dictionary, &observed).unwrap_or_default();
        if wild.is_empty() {
            break;
        }
        let mut record = observed.record;
        warn(&mut record, &wild, log);
        mark(&mut record, &wild);
        observed = Observed::new(record, observed.hold)?;
    }
    Ok(observed)
}

/// The wild ones among the readings.
fn wild(dictionary: &Dictionary, observed: &Observed) -> Result<Vec<Auxiliary>, SolveError> {
    let found = Channels::of(dictionary, observed)?;
    let suspects = found.suspects();
    if suspects.is_empty() {
        return Ok(suspects);
    }
    let mut without = observed.clone();
    mark(&mut without.record, &suspects);
    let without = Channels::of(dictionary, &without)?;
    let mut wild = suspects;
    wild.retain(|one| stands_out(one.value.abs(), found.ordinary(one), without.beside(one)));
    let few = |one: &Auxiliary| {
        let own = wild.iter().filter(|other| channel(other) == channel(one));
        let known = observed.record.aside.of(one.coordinate)[one.derivative].iter();
        let all = own.count() + known.filter(|&&aside| aside).count();
        all as f64 <= RARE * observed.record.len() as f64
    };
    Ok(wild.iter().copied().filter(few).collect())
}

/// Which column a reading is of: the derivative and the coordinate.
fn channel(reading: &Auxiliary) -> (usize, usize) {
    (reading.derivative, reading.coordinate)
}

/// The residuals of a column by samples, with their ordinary sizes there.
type Column = Vec<(Option<Auxiliary>, f64)>;

/// Those of each column, by derivative and coordinate.
struct Channels(BTreeMap<(usize, usize), Column>);

impl Channels {
    /// Those under the model as given.
    fn of(dictionary: &Dictionary, observed: &Observed) -> Result<Self, SolveError> {
        let (focus, values) = (dictionary.focus(&[]), &dictionary.defaults);
        let mut noise = first_noise(&focus, observed, values)?;
        let dynamics = linearised(&focus, observed, values)?;
        let readings = observed.readings(&focus, values, &dynamics.accelerations());
        settle(&dynamics, &readings, &[], &mut noise, Adapt::ToData);
        let whitener = Whitener::new(&dynamics, &readings, &noise);
        let mut columns: BTreeMap<_, Vec<Option<Auxiliary>>> = BTreeMap::new();
        for reading in whitener.auxiliary() {
            let nothing = || vec![None; observed.record.len()];
            let column = columns.entry(channel(&reading)).or_insert_with(nothing);
            column[reading.sample] = Some(reading);
        }
        let with_sizes = columns.into_iter().map(|(name, column)| {
            let size = |one: &Option<Auxiliary>| one.map_or(0.0, |one| one.value.abs());
            let sizes: Vec<f64> = column.iter().map(size).collect();
            let aside: Vec<bool> = column.iter().map(Option::is_none).collect();
            let ordinary = ordinary_sizes(&sizes, &aside, 1.0);
            (name, column.into_iter().zip(ordinary).collect())
        });
        Ok(Self(with_sizes.collect()))
    }

    /// How large residuals ordinarily are about a reading.
    fn ordinary(&self, reading: &Auxiliary) -> f64 {
        self.0[&channel(reading)][reading.sample].1
    }

    /// Readings that are farther off than is usual there, and than all readings of the machine about them: one
    /// that is wild draws the others with it.
    fn suspects(&self) -> Vec<Auxiliary> {
        let all = self.0.values().flatten();
        let far = all.filter_map(|(one, ordinary)| {
            one.filter(|one| stands_out(one.value.abs(), *ordinary, 0.0))
        });
        let is_farthest = |one: &Auxiliary| {
            let columns = self.0.values();
            let mut near = columns.flat_map(|column| near(column, one.sample));
            near.all(|(other, _)| other.value.abs() <= one.value.abs())
        };
        far.filter(is_farthest).collect()
    }

    /// How far the readings beside one are off, beyond what is ordinary.
    fn beside(&self, reading: &Auxiliary) -> f64 {
        let column = self.0.get(&channel(reading)).into_iter();
        let near = column.flat_map(|column| near(column, reading.sample));
        let others = near.filter(|(other, _)| other.sample != reading.sample);
        let beyond = others.map(|(other, ordinary)| other.value.abs() - ORDINARY * ordinary);
        beyond.fold(0.0, f64::max)
    }
}

/// What a column has about a sample.
fn near(
    column: &[(Option<Auxiliary>, f64)],
    sample: usize,
) -> impl Iterator<Item = (&Auxiliary, f64)> {
    let last = (sample + BESIDE + 1).min(column.len());
    let near = column[sample.saturating_sub(BESIDE)..last].iter();
    near.filter_map(|(one, ordinary)| Some((one.as_ref()?, *ordinary)))
}

/// The values of the column that a reading is of.
fn column<'a>(record: &'a mut Record, reading: &Auxiliary) -> Option<&'a mut Vec<f64>> {
    let i = reading.coordinate;
    match reading.derivative {
        0 => record.q.get_mut(i),
        1 => record.dq[i].as_mut(),
        _ => record.ddq[i].as_mut(),
    }
}

/// Sets readings aside, with what all others say in their place.
fn mark(record: &mut Record, wild: &[Auxiliary]) {
    let samples = record.len();
    for one in wild {
        if let Some(values) = column(record, one) {
            values[one.sample] -= one.apart;
        }
        let aside = &mut record.aside;
        let flags = match one.derivative {
            0 => &mut aside.q,
            1 => &mut aside.dq,
            _ => &mut aside.ddq,
        };
        flags[one.coordinate].resize(samples, false);
        flags[one.coordinate][one.sample] = true;
    }
}

/// Says of each column which readings are set aside.
fn warn(record: &mut Record, wild: &[Auxiliary], log: &Log) {
    let mut columns: BTreeMap<(usize, usize), Vec<&Auxiliary>> = BTreeMap::new();
    for one in wild {
        columns.entry(channel(one)).or_default().push(one);
    }
    for own in columns.into_values() {
        let first = own[0];
        let (file, line) = log.place(record.t[first.sample]);
        let prefix = ["q_", "dq_", "ddq_"][first.derivative];
        let name = log.column(prefix, &record.coordinates[first.coordinate]);
        let Some(values) = column(record, first) else {
            continue;
        };
        let value = values[first.sample];
        record.warnings.push(Warning::Contradicted {
            column: name,
            file,
            line,
            value,
            beside: value - first.apart,
            samples: own.len(),
        });
    }
}

#[cfg(test)]
mod tests {
    use super::super::wheel::{WHEEL, begun, rectangular};
    use super::*;
    use std::fmt::Write;

    /// Ordinary noise of the acceleration, rad/s².
    const NOISE: f64 = 0.3;

    /// A wheel that is shaken so fast that an acceleration between its neighbours can be wrong by half of its
    /// range, read with an acceleration that is off at some samples; it may brake dry, which its model lacks.
    fn shaken(friction: f64, wrong: &[(usize, f64)]) -> (Dictionary, Observed, Log) {
        let step = 0.005;
        let (mut q, mut v) = (0.0, 0.0);
        let mut noise = rectangular(9);
        let mut text = String::from("t,q_angle,dq_angle,ddq_angle,u_motor\n");
        let u = |t: f64| {
            let shakes = [1.0, 2.5, 4.0].map(|at| (-((t - at) / 0.02).powi(2)).exp());
            0.1 * (3.0 * t).sin() + 1.6 * shakes.iter().sum::<f64>() * (190.0 * t).sin()
        };
        let a = |t: f64, v: f64| (u(t) - friction * (v / 0.02).tanh()) / 0.02;
        for k in 0..1200 {
            let t = step * f64::from(k);
            let off = wrong.iter().find(|(at, _)| *at == k as usize);
            let y = a(t, v) + NOISE * noise() + off.map_or(0.0, |(_, by)| *by);
            let [y_q, y_v] = [q + 2e-5 * noise(), v + 2e-3 * noise()];
            writeln!(text, "{t},{y_q},{y_v},{y},{}", u(t)).unwrap();
            let h = step / 50.0;
            for i in 0..50 {
                let now = t + h * f64::from(i);
                // The input as a log has it: straight from sample to sample.
                let share = (now - t) / step + 0.01;
                let drive = (1.0 - share) * u(t) + share * u(t + step);
                let moved = (drive - friction * (v / 0.02).tanh()) / 0.02;
                q += h * v + 0.5 * h * h * moved;
                v += h * moved;
            }
        }
        let (dictionary, start) = begun(WHEEL, &text, ["angle", "motor"]);
        let log = Log::from_bytes("wheel.csv", text.as_bytes()).unwrap();
        (dictionary, start.observed, log)
    }

    /// What is set aside of the accelerations, and what warnings say.
    fn aside(friction: f64, wrong: &[(usize, f64)]) -> (Vec<usize>, Vec<String>) {
        let (dictionary, observed, log) = shaken(friction, wrong);
        let decided = set_aside(&dictionary, observed, &log).unwrap();
        let flags = decided.record.aside.of(0)[2];
        let set: Vec<usize> = (0..flags.len()).filter(|&k| flags[k]).collect();
        let said = decided.record.warnings.iter().map(ToString::to_string);
        (set, said.collect())
    }

    #[test]
    fn a_reading_beside_quick_motion_is_known_to_be_wild_by_the_model() {
        let (set, said) = aside(0.0, &[(500, 40.0)]);
        assert_eq!(set, [500], "{said:?}");
        let [said] = &said[..] else {
            panic!("{said:?}");
        };
        assert!(
            said.starts_with("line 502: `ddq_angle` is ") && said.contains("where model and log"),
            "{said}"
        );
    }

    #[test]
    fn what_the_model_lacks_is_not_wild() {
        for friction in [0.0, 0.02, 0.2] {
            let (set, said) = aside(friction, &[]);
            assert_eq!((set.len(), said.len()), (0, 0), "{friction}: {said:?}");
        }
    }
}
