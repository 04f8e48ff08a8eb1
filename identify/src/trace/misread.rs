//! Columns that are not what they are taken for.
//!
//! A sensor that counts the other way, degrees in place of radians, two cables swapped: such a
//! log is far from any model, and no force explains it. Each of these mistakes is tried on the
//! smoothed log, to see whether the model explains it without.

use super::dictionary::Dictionary;
use super::score::deviation;
use crate::log::{Record, rms};
use crate::machine::States;
use crate::smooth::{SgStates, savgol_states};
use dynamics_codegen::dimension::Dimension;

/// The model's accelerations are far off beyond this share of the measured ones.
const FAR_OFF: f64 = 0.5;
/// A mistake must explain the log this many times as well.
const TELLING: f64 = 3.0;
/// Mistakes at most.
const MOST: usize = 4;
/// Samples that are looked at.
const LOOKED_AT: usize = 400;
/// A velocity that follows the positions this closely but for a factor is in another unit,
const FOLLOWS: f64 = 0.9;
/// if the factor is at least this far from one.
const ANOTHER_UNIT: f64 = 0.2;

/// What may be wrong with one or two columns.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Mistake {
    Reversed(usize),
    ReversedInput(usize),
    Degrees(usize),
    AllDegrees,
    Swapped(usize, usize),
    SwappedInputs(usize, usize),
}

/// States with the accelerations that were measured there.
#[derive(Clone)]
struct Seen {
    states: States,
    a: Vec<Vec<f64>>,
}

/// What seems to be wrong with the columns of `record`, as advice.
pub(super) fn misread(dictionary: &Dictionary, record: &Record) -> Vec<String> {
    let Ok(smoothed) = savgol_states(record) else {
        return Vec::new();
    };
    let mut advice = odd_velocities(record);
    let (first, mistakes) = mistakes(dictionary, Seen::of(record, &smoothed));
    let (Some(&(_, last)), true) = (mistakes.last(), advice.is_empty()) else {
        return advice;
    };
    let each = mistakes.iter().map(|(mistake, _)| mistake.describe(record));
    let each: Vec<String> = each.collect();
    advice.push(format!(
        "the log is far from the model, but would not be if {}: the accelerations would be off by \
         {last:.2} of their size in place of {first:.2}; if that is so, a map of the log says it \
         (`sign`, `unit`, `column`: docs/log-format.md)",
        each.join(" and if ")
    ));
    advice
}

/// The mistakes that explain the log, one after the other, each with the error that remains;
/// before them the error of the log as it is.
fn mistakes(dictionary: &Dictionary, seen: Seen) -> (f64, Vec<(Mistake, f64)>) {
    let focus = dictionary.focus(&[]);
    let values = focus.values(&dictionary.defaults);
    let model = &focus.machine.compiled.model;
    let error = |seen: &Seen| -> f64 {
        let Ok(motions) = focus.machine.motion(&seen.states, &values) else {
            return f64::INFINITY;
        };
        let shares = seen.a.iter().enumerate().map(|(i, a)| {
            let misses = motions.iter().zip(a).map(|(m, a)| m.acceleration[i] - a);
            let misses: Vec<f64> = misses.collect();
            match deviation(a) {
                size if size > 0.0 => rms(&misses) / size,
                _ => 0.0,
            }
        });
        rms(&shares.collect::<Vec<f64>>())
    };
    let is_angle = |i: usize| model.coordinates[i].dimension == Some(Dimension::ONE);
    let possible = Mistake::all(seen.a.len(), seen.states.u.len(), is_angle);
    let first = error(&seen);
    let (mut known, mut now) = (Vec::new(), (first, seen));
    while now.0 > FAR_OFF && known.len() < MOST {
        let tried = possible.iter().map(|&mistake| {
            let mended = mistake.mended(&now.1);
            (error(&mended), mistake, mended)
        });
        let best = tried.min_by(|a, b| a.0.total_cmp(&b.0));
        match best {
            Some((error, mistake, mended)) if error * TELLING < now.0 => {
                known.push((mistake, error));
                now = (error, mended);
            }
            _ => break,
        }
    }
    // Half an explanation is none.
    if now.0 > FAR_OFF {
        known.clear();
    }
    (first, known)
}

/// Velocities that are the positions' rates but for a factor.
fn odd_velocities(record: &Record) -> Vec<String> {
    let positions_alone = Record {
        dq: vec![None; record.dq.len()],
        ddq: vec![None; record.ddq.len()],
        ..record.clone()
    };
    let Ok(from_positions) = savgol_states(&positions_alone) else {
        return Vec::new();
    };
    let each = record.dq.iter().enumerate().filter_map(|(i, logged)| {
        let (logged, rate) = (logged.as_ref()?, &from_positions.v[i]);
        let product = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let (both, own) = (product(logged, rate), product(rate, rate));
        let factor = both / own;
        let likeness = both / (own * product(logged, logged)).sqrt();
        let name = &record.coordinates[i];
        (likeness.abs() > FOLLOWS && (factor - 1.0).abs() > ANOTHER_UNIT).then(|| {
            format!(
                "`dq_{name}` is {factor:.4} times the rate of `q_{name}`: are both of one sign and \
                 in one unit? A map of the log says what they are (docs/log-format.md)"
            )
        })
    });
    each.collect()
}

impl Seen {
    /// Samples evenly spread over a record.
    fn of(record: &Record, smoothed: &SgStates) -> Self {
        let whole = States::filtered(record, smoothed);
        let stride = whole.len().div_ceil(LOOKED_AT).max(1);
        let thin = |a: &Vec<f64>| a.iter().step_by(stride).copied().collect();
        Self {
            states: whole.spread(LOOKED_AT),
            a: smoothed.a.iter().map(thin).collect(),
        }
    }
}

impl Mistake {
    fn all(coordinates: usize, inputs: usize, is_angle: impl Fn(usize) -> bool) -> Vec<Self> {
        let pairs = |n: usize| (0..n).flat_map(move |i| (i + 1..n).map(move |k| (i, k)));
        let angles: Vec<usize> = (0..coordinates).filter(|&i| is_angle(i)).collect();
        let mut all: Vec<Self> = Vec::new();
        if angles.len() == coordinates {
            all.push(Self::AllDegrees);
        }
        all.extend(angles.into_iter().map(Self::Degrees));
        all.extend((0..coordinates).map(Self::Reversed));
        all.extend((0..inputs).map(Self::ReversedInput));
        all.extend(pairs(coordinates).map(|(i, k)| Self::Swapped(i, k)));
        all.extend(pairs(inputs).map(|(i, k)| Self::SwappedInputs(i, k)));
        all
    }

    /// What was seen, if this mistake was made.
    fn mended(self, seen: &Seen) -> Seen {
        let mut seen = seen.clone();
        let Seen {
            states: States { q, v, u, .. },
            a,
        } = &mut seen;
        let all = 0..a.len();
        let mut scale = |i: usize, by: f64| {
            for columns in [&mut *q, &mut *v, &mut *a] {
                columns[i].iter_mut().for_each(|x| *x *= by);
            }
        };
        match self {
            Self::Reversed(i) => scale(i, -1.0),
            Self::Degrees(i) => scale(i, 1_f64.to_radians()),
            Self::AllDegrees => all.into_iter().for_each(|i| scale(i, 1_f64.to_radians())),
            Self::ReversedInput(i) => u[i].iter_mut().for_each(|u| *u = -*u),
            Self::Swapped(i, k) => [q, v, a].into_iter().for_each(|c| c.swap(i, k)),
            Self::SwappedInputs(i, k) => u.swap(i, k),
        }
        seen
    }

    /// In words, behind "if".
    fn describe(self, record: &Record) -> String {
        let (q, u) = (&record.coordinates, &record.inputs);
        match self {
            Self::Reversed(i) => format!("`q_{}` counted the other way", q[i]),
            Self::ReversedInput(i) => format!("`u_{}` acted the other way", u[i]),
            Self::Degrees(i) => format!("`q_{}` were in degrees", q[i]),
            Self::AllDegrees => "all angles were in degrees".to_string(),
            Self::Swapped(i, k) => format!("`q_{}` and `q_{}` were each other", q[i], q[k]),
            Self::SwappedInputs(i, k) => {
                format!("`u_{}` and `u_{}` were each other", u[i], u[k])
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::log::Log;
    use crate::trace::{Observed, Ranges, Source};
    use dynamics_codegen::Library;
    use std::collections::BTreeMap;

    /// A double pendulum with friction that the model lacks.
    fn log() -> (Record, Dictionary) {
        let root = concat!(env!("CARGO_MANIFEST_DIR"), "/..");
        let folder = format!("{root}/tests/data/scenarios/o01_pendulum2");
        let text = std::fs::read_to_string(format!("{root}/models/pendulum2.model")).unwrap();
        let values = std::fs::read_to_string(format!("{folder}/parameters.json")).unwrap();
        let values: BTreeMap<String, f64> = serde_json::from_str(&values).unwrap();
        let joints = ["j1".to_string(), "j2".to_string()];
        let log = Log::read(format!("{folder}/train.csv.gz")).unwrap();
        let record = log.select(&joints, &joints).unwrap();
        let observed = Observed::new(record, crate::regression::Hold::Linear).unwrap();
        let ranges: Ranges = observed.ranges();
        let nothing = Library::empty();
        let source = Source {
            name: "pendulum2",
            text: &text,
            library: &nothing,
            parameters: &values,
        };
        let dictionary = Dictionary::new(&source, &ranges).unwrap();
        (observed.record, dictionary)
    }

    #[test]
    fn mistakes_are_told() {
        let (record, dictionary) = log();
        assert_eq!(misread(&dictionary, &record), Vec::<String>::new());
        let told = |change: &dyn Fn(&mut Record)| {
            let mut record = record.clone();
            change(&mut record);
            misread(&dictionary, &record).join("\n")
        };
        let scale = |column: &mut Vec<f64>, by: f64| column.iter_mut().for_each(|x| *x *= by);
        let each = |i: usize, by: f64| {
            move |record: &mut Record| {
                scale(&mut record.q[i], by);
                record.dq[i].iter_mut().for_each(|dq| scale(dq, by));
            }
        };
        let reversed = told(&each(1, -1.0));
        assert!(
            reversed.contains("if `q_j2` counted the other way:"),
            "{reversed}"
        );
        let swapped = told(&|record| record.u.swap(0, 1));
        assert!(
            swapped.contains("if `u_j1` and `u_j2` were each other:"),
            "{swapped}"
        );
        let degrees = told(&|record| {
            (0..2).for_each(|i| each(i, 1_f64.to_degrees())(record));
        });
        assert!(
            degrees.contains("if all angles were in degrees:"),
            "{degrees}"
        );
        let two = told(&|record| {
            each(1, -1.0)(record);
            scale(&mut record.u[0], -1.0);
        });
        assert!(
            two.contains("counted the other way") && two.contains(" and if "),
            "{two}"
        );
        let rate = told(&|record| record.dq[0].iter_mut().for_each(|dq| scale(dq, 57.3)));
        assert!(rate.starts_with("`dq_j1` is 57."), "{rate}");
    }
}
