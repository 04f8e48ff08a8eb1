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
/// cubics between samples, and by [Taylor's series](Beyond) where there is no sample on the other side.
pub(crate) fn shifted(states: &States, i: usize, a: &[f64], by: &[f64]) -> Shifted {
    let (t, q, v) = (&states.t, &states.q[i], &states.v[i]);
    let longest = longest_step(t);
    let mut result = Shifted {
        q: Vec::with_capacity(t.len()),
        v: Vec::with_capacity(t.len()),
        a: Vec::with_capacity(t.len()),
        doubt: [0, 1, 2].map(|_| vec![0.0; t.len()]),
    };
    let beyond = Beyond::new(t, a, longest);
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
            let (jerk, doubt) = beyond.at(near, h);
            for (all, own) in result.doubt.iter_mut().zip(doubt) {
                all[k] = own;
            }
            let curvature = a[near] + h * jerk;
            let rate = v[near] + h * (a[near] + 0.5 * h * jerk);
            let x = q[near] + h * (v[near] + 0.5 * h * (a[near] + h / 3.0 * jerk));
            (x, rate, curvature)
        };
        result.q.push(x);
        result.v.push(rate);
        result.a.push(curvature);
    }
    result
}

/// How a motion goes on beyond its first and its last sample: by Taylor's series up to the jerk there or without
/// it, whichever leaves out less. What is left out is not known: of a position `s h⁴/24` or `j h³/6` with the usual
/// snap `s` and the usual jerk `j`, and the derivatives of these of velocities and accelerations.
struct Beyond {
    /// Per interval, nothing across a gap.
    jerk: Vec<Option<f64>>,
    usual_jerk: f64,
    usual_snap: f64,
}

impl Beyond {
    fn new(t: &[f64], a: &[f64], longest: f64) -> Self {
        let steps = t.windows(2).zip(a.windows(2));
        let of_step = |(t, a): (&[f64], &[f64])| {
            let h = t[1] - t[0];
            (h <= longest).then(|| (a[1] - a[0]) / h)
        };
        let jerk: Vec<Option<f64>> = steps.map(of_step).collect();
        let snaps = jerk.windows(2).zip(t.windows(3)).filter_map(|(pair, t)| {
            let [before, after] = [pair[0]?, pair[1]?];
            Some(2.0 * (after - before) / (t[2] - t[0]))
        });
        let known: Vec<f64> = jerk.iter().flatten().copied().collect();
        Self {
            usual_jerk: rms(&known),
            usual_snap: rms(&snaps.collect::<Vec<_>>()),
            jerk,
        }
    }

    /// The jerk that counts `h` seconds from a sample at either end, and by how much the position, the velocity
    /// and the acceleration there may be off.
    fn at(&self, near: usize, h: f64) -> (f64, [f64; 3]) {
        let inward = if h < 0.0 {
            Some(near)
        } else {
            near.checked_sub(1)
        };
        let there = inward.and_then(|step| *self.jerk.get(step)?);
        let by_jerk = [h.abs().powi(3) / 6.0, h * h / 2.0, h.abs()].map(|x| self.usual_jerk * x);
        let by_snap = [h.powi(4) / 24.0, h.abs().powi(3) / 6.0, h * h / 2.0];
        let by_snap = by_snap.map(|x| self.usual_snap * x);
        match there {
            Some(jerk) if by_snap[2] < by_jerk[2] => (jerk, by_snap),
            _ => (0.0, by_jerk),
        }
    }
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

    /// Where a motion is smooth its jerk goes on, too; where it jumps from sample to sample that says nothing.
    #[test]
    fn the_jerk_goes_on_where_that_leaves_out_less() {
        let t: Vec<f64> = (0..200).map(|k| 0.01 * f64::from(k)).collect();
        let smooth: Vec<f64> = t.iter().map(|t| (5.0 * t).sin()).collect();
        let shaken: Vec<f64> = (0..200).map(|k| f64::from(k % 2)).collect();
        let [smooth, shaken] = [smooth, shaken].map(|a| Beyond::new(&t, &a, 0.02).at(0, -0.05));
        assert!((smooth.0 - 5.0).abs() < 0.01, "{smooth:?}");
        assert!(smooth.1[2] < 25.0 * 0.05 * 0.05 / 2.0, "{smooth:?}");
        assert_eq!(shaken.0, 0.0);
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
