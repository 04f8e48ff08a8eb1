//! Waves along the way in the force that a model lacks.
//!
//! A ripple of a motor that turns many times fits only where its number of waves per radian is
//! known to a part of the inverse of all the radians: no grid of a few values comes near. What
//! the model as given lacks, beside the position, tells where to look.

use super::estimate::Observed;
use crate::machine::Machine;
use crate::regression::derivative;
use nalgebra::{DMatrix, DVector, Matrix2, Vector2};
use rayon::prelude::*;

/// Samples that are looked at, and wave numbers that are tried.
const LOOKED_AT: usize = 2000;
const TRIED: usize = 8000;

/// Where a coordinate was, how fast, and what generalised force the model lacked there, one entry
/// per sample that is looked at, in the coordinate's units.
#[derive(Debug, Clone, Default)]
pub struct Missing {
    q: Vec<f64>,
    v: Vec<f64>,
    force: Vec<f64>,
}

/// What `machine`, with these values, lacks per coordinate: `M (a − a_model)`. Nothing where
/// its equation of motion has no solution.
pub(super) fn missing(machine: &Machine, values: &[f64], observed: &Observed) -> Vec<Missing> {
    let curve = &observed.curve;
    let Ok(along) = machine.remember(curve, observed.hold, values) else {
        return Vec::new();
    };
    let Ok(motions) = machine.motion(&along, values) else {
        return Vec::new();
    };
    let rates: Vec<Vec<f64>> = curve.v.iter().map(|v| derivative(&curve.t, v)).collect();
    let stride = curve.len().div_ceil(LOOKED_AT).max(1);
    let mut missing = vec![Missing::default(); curve.q.len()];
    for (k, motion) in motions.iter().enumerate().step_by(stride) {
        let apart = DVector::from_fn(rates.len(), |i, _| rates[i][k] - motion.acceleration[i]);
        let force = &motion.terms.mass_matrix * apart;
        for (i, own) in missing.iter_mut().enumerate() {
            own.q.push(curve.q[i][k]);
            own.v.push(curve.v[i][k]);
            own.force.push(force[i]);
        }
    }
    missing
}

impl Missing {
    /// The `count` wave numbers below `most` that explain most of the force, by a sine and a
    /// cosine beside what dry and viscous friction and a spring would take.
    pub(super) fn waves(&self, most: f64, count: usize) -> Vec<f64> {
        let bounds = |values: &[f64]| {
            let start = (f64::INFINITY, f64::NEG_INFINITY);
            (values.iter()).fold(start, |(least, most), &x| (least.min(x), most.max(x)))
        };
        let (begin, end) = bounds(&self.q);
        let way = end - begin;
        // A wave is one if it comes back.
        let longest = std::f64::consts::TAU / way;
        if !(way > 0.0 && longest < most) {
            return Vec::new();
        }
        let force = self.without_friction();
        let step = (1.0 / way).max((most - longest) / TRIED as f64);
        let tried: Vec<f64> = (0..TRIED)
            .map(|i| longest + i as f64 * step)
            .take_while(|&n| n < most)
            .collect();
        let explained: Vec<f64> = tried
            .par_iter()
            .map(|n| self.explained(&force, *n))
            .collect();
        let mut peaks: Vec<usize> = (0..tried.len())
            .filter(|&i| {
                let beside = |j: Option<usize>| j.and_then(|j| explained.get(j));
                let around = [beside(i.checked_sub(1)), beside(Some(i + 1))];
                around.into_iter().flatten().all(|&e| e <= explained[i])
            })
            .collect();
        peaks.sort_by(|&a, &b| explained[b].total_cmp(&explained[a]));
        peaks.truncate(count);
        peaks.into_iter().map(|i| tried[i]).collect()
    }

    /// The force less the nearest sum of a constant, a spring, dry and viscous friction.
    fn without_friction(&self) -> Vec<f64> {
        let force = DVector::from_column_slice(&self.force);
        let columns = DMatrix::from_fn(self.q.len(), 4, |k, column| match column {
            0 => 1.0,
            1 => self.q[k],
            2 => self.v[k],
            _ => self.v[k].signum(),
        });
        let nearest = columns.clone().svd(true, true).solve(&force, 1e-12);
        let left = nearest.map_or(force.clone(), |x| force - columns * x);
        left.as_slice().to_vec()
    }

    /// How much of the squares of `force` goes with a wave.
    fn explained(&self, force: &[f64], n: f64) -> f64 {
        let (mut squares, mut products) = (Matrix2::zeros(), Vector2::zeros());
        for (q, force) in self.q.iter().zip(force) {
            let (sine, cosine) = (n * q).sin_cos();
            let wave = Vector2::new(sine, cosine);
            squares += wave * wave.transpose();
            products += wave * *force;
        }
        let inverse = squares.try_inverse();
        inverse.map_or(0.0, |inverse| products.dot(&(inverse * products)))
    }
}

#[cfg(test)]
mod tests {
    use super::Missing;

    #[test]
    fn a_wave_stands_out_of_friction() {
        // Ten turns there and back.
        let places = (0..1500).map(|k| f64::from(k) / 1500.0 * std::f64::consts::TAU);
        let (q, v): (Vec<f64>, Vec<f64>) = places.map(|x| (31.0 * x.sin(), 31.0 * x.cos())).unzip();
        let force = q.iter().zip(&v);
        let force = force.map(|(q, v)| 0.1 * (7.3 * q + 0.4).sin() - 0.3 * v.signum() - 0.01 * v);
        let missing = Missing {
            force: force.collect(),
            q,
            v,
        };
        let waves = missing.waves(40.0, 3);
        assert_eq!(waves.len(), 3);
        assert!((waves[0] - 7.3).abs() < 0.01, "{waves:?}");
        assert!(missing.waves(0.05, 3).is_empty());
        assert!(Missing::default().waves(40.0, 3).is_empty());
    }
}
