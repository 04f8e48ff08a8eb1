//! Whether a velocity changes as its acceleration says: what a machine was given it keeps.

use super::stretch::Stretch;
use std::ops::Range;

/// Whether the velocity's change across some samples of its acceleration is rather what these samples add
/// up to than what their neighbours would. The stretch is of accelerations, the velocities are of the same
/// samples. Nothing where either cannot be said.
pub(super) fn agrees(
    accelerations: &Stretch<'_>,
    velocities: &[f64],
    group: &Range<usize>,
) -> Option<bool> {
    let (first, last) = (group.start.checked_sub(1)?, group.end);
    let change = velocities.get(last)? - velocities[first];
    let logged = |k: usize| Some(accelerations.values[k]);
    let beside = |k: usize| match group.contains(&k) {
        true => Some(accelerations.said(k, group)?.value),
        false => logged(k),
    };
    let t = accelerations.t;
    let sum = |at: &dyn Fn(usize) -> Option<f64>| {
        (first..last).try_fold(0.0, |sum, k| {
            Some(sum + 0.5 * (t[k + 1] - t[k]) * (at(k)? + at(k + 1)?))
        })
    };
    Some((change - sum(&logged)?).abs() < (change - sum(&beside)?).abs())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_blow_is_kept_by_the_velocity_and_a_broken_cell_is_not() {
        let t: Vec<f64> = (0..20).map(|k| 0.01 * f64::from(k)).collect();
        let mut values = vec![1.0; 20];
        values[10] = 50.0;
        let aside = vec![false; 20];
        let stretch = Stretch {
            t: &t,
            values: &values,
            aside: &aside,
        };
        let velocity = |blow: f64| {
            let at = |(k, t): (usize, &f64)| t + if k > 10 { blow } else { 0.0 };
            t.iter().enumerate().map(at).collect::<Vec<f64>>()
        };
        assert_eq!(agrees(&stretch, &velocity(0.5), &(10..11)), Some(true));
        assert_eq!(agrees(&stretch, &velocity(0.0), &(10..11)), Some(false));
        assert_eq!(agrees(&stretch, &velocity(0.0), &(0..1)), None);
        assert_eq!(agrees(&stretch, &velocity(0.0), &(19..20)), None);
    }
}
