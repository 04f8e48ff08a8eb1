//! What sensors show at the times that their readings are of.
//!
//! A reading in a row of a log may be of another time than the row, if the model says that the sensor
//! is late.

use super::moments::Moments;
use super::mover::{Columns, Mover};
use super::sensed::derivative;
use super::shown::Shown;
use crate::log::{rms, segments};

/// Moves what is shown along a curve to the times that readings are of: values, what a departure
/// changes of them, and what columns do, those among them that say how late a sensor is. Says when each
/// sensor was read.
pub(super) fn in_time(
    shown: &mut [Shown],
    t: &[f64],
    mover: Mover<'_>,
    columns: &[Columns<'_>],
) -> Vec<Option<Moments>> {
    let Some(instruments) = mover.instruments.filter(|_| !shown.is_empty()) else {
        return Vec::new();
    };
    let mut moments = vec![None; instruments.count()];
    let leads = instruments.leads(mover.parameters);
    let told = told_by(columns);
    for sensor in 0..instruments.count() {
        let lead = leads.as_ref().map_or(0.0, |(leads, _)| leads[sensor]);
        let rates = told
            .iter()
            .map(|(column, slopes)| (*column, slopes[sensor]))
            .filter(|(_, slope)| *slope != 0.0);
        let rates: Vec<(usize, f64)> = rates.collect();
        if lead == 0.0 && rates.is_empty() {
            continue;
        }
        let values: Vec<f64> = shown.iter().map(|s| s.values[(sensor, 0)]).collect();
        let rate_of_value = derivative(t, &values);
        let (nodes, doubt) = beyond(t, lead, &rate_of_value);
        let weights = weights(t, lead, nodes);
        let then = |column: &[f64]| mixed(&weights, column);
        if lead != 0.0 {
            move_rows(shown, sensor, &then);
            moments[sensor] = Some(Moments::new(t, &vec![lead; t.len()]).with_doubt(doubt));
        }
        for (shown, rate) in shown.iter_mut().zip(then(&rate_of_value)) {
            for (column, by) in &rates {
                shown.values[(sensor, *column)] += rate * by;
            }
        }
    }
    moments
}

/// The columns, counted behind the values, that say how late sensors are, with what they change of
/// each sensor's time.
fn told_by(columns: &[Columns<'_>]) -> Vec<(usize, Vec<f64>)> {
    let mut first = 1;
    let mut told = Vec::new();
    for block in columns {
        let leads = block
            .instruments
            .and_then(|instruments| instruments.leads(block.parameters));
        if let Some((_, slopes)) = leads {
            let each = slopes.column_iter().enumerate();
            told.extend(
                each.map(|(column, slopes)| (first + column, slopes.iter().copied().collect())),
            );
        }
        first += block.tape.variable_count();
    }
    told
}

/// A column whose entries are made up of others with some weights.
fn mixed(weights: &[Vec<(usize, f64)>], column: &[f64]) -> Vec<f64> {
    let sum = |weights: &Vec<(usize, f64)>| weights.iter().map(|(k, w)| w * column[*k]).sum();
    weights.iter().map(sum).collect()
}

/// The rows of one sensor, entry by entry, at other times.
fn move_rows(shown: &mut [Shown], sensor: usize, then: &dyn Fn(&[f64]) -> Vec<f64>) {
    let (states, columns) = (shown[0].slope.ncols(), shown[0].values.ncols());
    for column in 0..states {
        let old: Vec<f64> = shown.iter().map(|s| s.slope[(sensor, column)]).collect();
        for (shown, new) in shown.iter_mut().zip(then(&old)) {
            shown.slope[(sensor, column)] = new;
        }
    }
    for column in 0..columns {
        let old: Vec<f64> = shown.iter().map(|s| s.values[(sensor, column)]).collect();
        for (shown, new) in shown.iter_mut().zip(then(&old)) {
            shown.values[(sensor, column)] = new;
        }
    }
}

/// Through how many of the last samples a column of this `rate` goes on beyond them, two or three, whichever leaves
/// out less; and what that leaves out `by` seconds later, sample by sample, which is not known. With samples every
/// `h` seconds it is `½ f″ d (d + h)` or `⅙ f‴ d (d + h) (d + 2 h)` at `d` seconds from the last of them, with
/// derivatives of their usual sizes.
fn beyond(t: &[f64], by: f64, rate: &[f64]) -> (usize, Vec<f64>) {
    let second = derivative(t, rate);
    let (bend, turn) = (rms(&second), rms(&derivative(t, &second)));
    let mut outside = vec![(0.0, 0.0); t.len()];
    for range in segments(t).into_iter().filter(|range| range.len() > 3) {
        let stamps = &t[range.clone()];
        let last = stamps.len() - 1;
        for k in range {
            let when = t[k] + by;
            let (early, late) = (stamps[0] - when, when - stamps[last]);
            if early > 0.0 {
                outside[k] = (early, stamps[1] - stamps[0]);
            } else if late > 0.0 {
                outside[k] = (late, stamps[last] - stamps[last - 1]);
            }
        }
    }
    let straight = |(d, h): (f64, f64)| bend * d * (d + h) / 2.0;
    let curved = |(d, h): (f64, f64)| turn * d * (d + h) * (d + 2.0 * h) / 6.0;
    let farthest = outside.iter().copied().max_by(|a, b| a.0.total_cmp(&b.0));
    let most = farthest.unwrap_or_default();
    match curved(most) < straight(most) {
        true => (3, outside.into_iter().map(curved).collect()),
        false => (2, outside.into_iter().map(straight).collect()),
    }
}

/// Samples and their weights that make up a column `by` seconds later, sample by sample: by the cubic
/// through four samples without a gap, beyond the last of them through so many.
fn weights(t: &[f64], by: f64, beyond: usize) -> Vec<Vec<(usize, f64)>> {
    let mut all = Vec::with_capacity(t.len());
    for range in segments(t) {
        for k in range.clone() {
            let when = t[k] + by;
            let stamps = &t[range.clone()];
            let last = stamps.len() - 1;
            let nodes = if last < 3 || by == 0.0 {
                k - range.start..k - range.start + 1
            } else if when < stamps[0] {
                0..beyond
            } else if when > stamps[last] {
                last + 1 - beyond..last + 1
            } else {
                let after = stamps.partition_point(|&stamp| stamp <= when);
                let first = after.saturating_sub(2).min(last - 3);
                first..first + 4
            };
            let weight = |i: usize| -> f64 {
                let others = nodes.clone().filter(|&j| j != i);
                let factors = others.map(|j| (when - stamps[j]) / (stamps[i] - stamps[j]));
                factors.product()
            };
            let each = nodes.clone().map(|i| (range.start + i, weight(i)));
            all.push(each.collect());
        }
    }
    all
}

#[cfg(test)]
mod tests {
    use super::{beyond, derivative, mixed, weights};

    #[test]
    fn a_column_is_moved_in_time() {
        let t: Vec<f64> = (0..200).map(|k| 0.005 * f64::from(k)).collect();
        let motion = |t: f64| (20.0 * t).sin();
        let column: Vec<f64> = t.iter().map(|&t| motion(t)).collect();
        for by in [0.0123, -0.0071, 0.005, 0.0] {
            let found = mixed(&weights(&t, by, 2), &column);
            for (k, found) in found.iter().enumerate().take(197).skip(3) {
                assert!((found - motion(t[k] + by)).abs() < 2e-5, "{k}");
            }
            // Beyond the ends along a straight line.
            assert!((found[0] - motion(by)).abs() < 0.05, "{by}");
            assert!((found[199] - motion(t[199] + by)).abs() < 0.05, "{by}");
        }
    }

    /// What either way leaves out is known in size, and the better one is taken.
    #[test]
    fn beyond_the_ends_there_is_doubt() {
        let t: Vec<f64> = (0..200).map(|k| 0.005 * f64::from(k)).collect();
        let motion = |t: f64| (20.0 * t).sin();
        let column: Vec<f64> = t.iter().map(|&t| motion(t)).collect();
        for by in [0.02, -0.02] {
            let (nodes, doubt) = beyond(&t, by, &derivative(&t, &column));
            assert_eq!(nodes, 3);
            let found = mixed(&weights(&t, by, nodes), &column);
            for k in 0..200 {
                let is_outside = !(0.0..=t[199]).contains(&(t[k] + by));
                assert_eq!(doubt[k] > 0.0, is_outside, "{k}");
                let miss = (found[k] - motion(t[k] + by)).abs();
                assert!(miss < 2.0 * doubt[k] + 1e-4, "{k}: {miss} {}", doubt[k]);
            }
        }
        let shaken: Vec<f64> = (0..200).map(|k| f64::from(k % 2)).collect();
        assert_eq!(beyond(&t, 0.02, &derivative(&t, &shaken)).0, 2);
    }

    /// On the other side of a gap nothing is known.
    #[test]
    fn nothing_is_taken_from_beyond_a_gap() {
        let t = [0.0, 0.01, 0.02, 0.03, 1.03, 1.04, 1.05, 1.06];
        let column = [1.0, 1.0, 1.0, 1.0, 5.0, 5.0, 5.0, 5.0];
        let found = mixed(&weights(&t, 0.1, 2), &column);
        let apart = found.iter().zip(&column).map(|(x, y)| (x - y).abs());
        assert!(apart.fold(0.0, f64::max) < 1e-12, "{found:?}");
    }
}
