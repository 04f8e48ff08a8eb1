//! A motion some time earlier or later, sample by sample.

use super::States;
use crate::log::{longest_step, rms};

/// Positions, velocities and accelerations of one coordinate.
pub(crate) struct Shifted {
    pub q: Vec<f64>,
    pub v: Vec<f64>,
    pub a: Vec<f64>,
    /// By how much positions, velocities and accelerations may be off where there is no sample on the other
    /// side; zero between samples.
    pub doubt: [Vec<f64>; 3],
}

/// Coordinate `i` of `states`, whose accelerations are `a`, at `t + by`, sample by sample: by
/// cubics between samples, and by Taylor's series where there is no sample on the other side: what that
/// leaves out, `j h³/6`, `j h²/2` and `j h` with the usual jerk `j`, is not known.
pub(crate) fn shifted(states: &States, i: usize, a: &[f64], by: &[f64]) -> Shifted {
    let (t, q, v) = (&states.t, &states.q[i], &states.v[i]);
    let longest = longest_step(t);
    let mut result = Shifted {
        q: Vec::with_capacity(t.len()),
        v: Vec::with_capacity(t.len()),
        a: Vec::with_capacity(t.len()),
        doubt: [0, 1, 2].map(|_| vec![0.0; t.len()]),
    };
    let steps = t.windows(2).zip(a.windows(2));
    let within = steps.filter(|(t, _)| t[1] - t[0] <= longest);
    let jerk = rms(&within
        .map(|(t, a)| (a[1] - a[0]) / (t[1] - t[0]))
        .collect::<Vec<_>>());
    for (k, by) in by.iter().enumerate() {
        let when = t[k] + by;
        let after = t.partition_point(|&stamp| stamp <= when);
        let joined = after > 0 && after < t.len() && t[after] - t[after - 1] <= longest;
        let (x, rate, curvature) = if joined {
            let before = after - 1;
            let h = t[after] - t[before];
            let s = (when - t[before]) / h;
            let x = cubic([q[before], q[after]], [v[before], v[after]], h, s);
            let rate = cubic([v[before], v[after]], [a[before], a[after]], h, s);
            (x, rate, a[before] + s * (a[after] - a[before]))
        } else {
            // Of two samples beside a gap the nearer one.
            let before = after.saturating_sub(1);
            let late = after < t.len() && t[after] - when < when - t[before];
            let near = if late { after } else { before };
            let h = when - t[near];
            let x = q[near] + h * (v[near] + 0.5 * h * a[near]);
            result.doubt[0][k] = jerk * h.abs().powi(3) / 6.0;
            result.doubt[1][k] = jerk * h * h / 2.0;
            result.doubt[2][k] = jerk * h.abs();
            (x, v[near] + h * a[near], a[near])
        };
        result.q.push(x);
        result.v.push(rate);
        result.a.push(curvature);
    }
    result
}

/// The cubic through two values with given rates, a share `s` of the way of `h` seconds.
fn cubic(x: [f64; 2], rate: [f64; 2], h: f64, s: f64) -> f64 {
    let rest = 1.0 - s;
    let (ends, slopes) = (
        x[0] * rest * rest * (1.0 + 2.0 * s) + x[1] * s * s * (1.0 + 2.0 * rest),
        rate[0] * s * rest * rest - rate[1] * s * s * rest,
    );
    ends + h * slopes
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What Taylor's series leaves out at either end is known in size.
    #[test]
    fn beyond_the_ends_there_is_doubt() {
        let t: Vec<f64> = (0..200).map(|k| 0.01 * f64::from(k)).collect();
        let of = |f: fn(f64) -> f64| -> Vec<f64> { t.iter().map(|t| f(5.0 * t)).collect() };
        let a: Vec<f64> = of(f64::sin).iter().map(|x| -25.0 * x).collect();
        let states = States {
            q: vec![of(f64::sin)],
            v: vec![of(f64::cos).iter().map(|x| 5.0 * x).collect()],
            t: t.clone(),
            ..States::default()
        };
        for by in [-0.08, 0.08] {
            let moved = shifted(&states, 0, &a, &vec![by; 200]);
            for k in 0..200 {
                let miss = (moved.q[k] - (5.0 * (t[k] + by)).sin()).abs();
                let is_outside = !(0.0..=t[199]).contains(&(t[k] + by));
                assert_eq!(moved.doubt[0][k] > 0.0, is_outside, "{k}");
                assert!(miss < 2.0 * moved.doubt[0][k] + 1e-6, "{k}: {miss}");
                let miss = (moved.a[k] + 25.0 * (5.0 * (t[k] + by)).sin()).abs();
                assert!(miss < 2.0 * moved.doubt[2][k] + 1e-2, "{k}: {miss}");
            }
        }
    }

    #[test]
    fn a_sine_is_a_sine_later() {
        let t: Vec<f64> = (0..200).map(|k| 0.01 * f64::from(k)).collect();
        let of = |f: fn(f64) -> f64| -> Vec<f64> { t.iter().map(|t| f(5.0 * t)).collect() };
        let a: Vec<f64> = of(f64::sin).iter().map(|x| -25.0 * x).collect();
        let states = States {
            q: vec![of(f64::sin)],
            v: vec![of(f64::cos).iter().map(|x| 5.0 * x).collect()],
            t: t.clone(),
            ..States::default()
        };
        let by = vec![-0.0137; 200];
        let late = shifted(&states, 0, &a, &by);
        for k in 0..200 {
            let phase = 5.0 * (t[k] - 0.0137);
            // In front of the first sample there is only its Taylor series.
            let (of_q, of_v) = if k < 2 { (1e-4, 0.02) } else { (1e-7, 1e-5) };
            assert!((late.q[k] - phase.sin()).abs() < of_q, "{k}");
            assert!((late.v[k] - 5.0 * phase.cos()).abs() < of_v, "{k}");
        }
    }
}
