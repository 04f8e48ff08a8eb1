//! Positions that move: by their velocities, and poses of floating bodies by their twists.

use super::Machine;
use dynamics_codegen::graph::SymbolId;
use dynamics_codegen::{Column, Model, Tape};
use std::borrow::Cow;

/// What moves the positions where there are more of them than velocities.
#[derive(Debug, Clone)]
pub(super) struct Poses {
    /// `q̇` of positions and velocities.
    rates: Tape,
    /// Where each quaternion begins among the positions.
    quaternions: Vec<usize>,
}

impl Poses {
    /// Of a model; `None` if every velocity has one position.
    pub fn of(model: &mut Model) -> Option<Self> {
        if model.poses.is_empty() {
            return None;
        }
        let rates = model.position_rates();
        let velocities = model.coordinates.iter().map(|c| c.velocity);
        let arguments: Vec<SymbolId> = model
            .position_symbols()
            .into_iter()
            .chain(velocities)
            .collect();
        let places = model.pose_places().into_iter();
        Some(Self {
            rates: Tape::new(&model.graph, &rates, &arguments),
            quaternions: places.map(|[position, _]| position + 3).collect(),
        })
    }

    fn normalise(&self, q: &mut [Vec<f64>]) {
        let samples = q.first().map_or(0, Vec::len);
        for &first in &self.quaternions {
            for sample in 0..samples {
                let square: f64 = q[first..first + 4]
                    .iter()
                    .map(|x| x[sample] * x[sample])
                    .sum();
                let length = square.sqrt();
                if length > 0.0 {
                    q[first..first + 4]
                        .iter_mut()
                        .for_each(|x| x[sample] /= length);
                }
            }
        }
    }
}

impl Machine {
    /// `q̇` where positions and velocities have these values, one column each.
    pub(super) fn position_rates<'v>(
        &self,
        q: &[Vec<f64>],
        v: &'v [Vec<f64>],
    ) -> Cow<'v, [Vec<f64>]> {
        let Some(poses) = &self.poses else {
            return Cow::Borrowed(v);
        };
        let columns: Vec<Column<'_>> = q.iter().chain(v).map(|x| Column::Each(x)).collect();
        let samples = v.first().map_or(0, Vec::len);
        Cow::Owned(poses.rates.evaluate_all(&columns, samples))
    }

    /// Makes the quaternions among positions units.
    pub(super) fn normalise(&self, q: &mut [Vec<f64>]) {
        if let Some(poses) = &self.poses {
            poses.normalise(q);
        }
    }

    /// Moves positions by velocities for `h` seconds, or by a displacement; poses by the midpoint
    /// rule.
    pub(super) fn move_positions(&self, q: &mut [Vec<f64>], v: &[Vec<f64>], h: f64) {
        let step = |q: &mut [Vec<f64>], rates: &[Vec<f64>], h: f64| {
            for (q, rates) in q.iter_mut().zip(rates) {
                q.iter_mut().zip(rates).for_each(|(q, rate)| *q += h * rate);
            }
        };
        if self.poses.is_none() {
            return step(q, v, h);
        }
        let mut halfway = q.to_vec();
        step(&mut halfway, &self.position_rates(q, v), h / 2.0);
        self.normalise(&mut halfway);
        step(q, &self.position_rates(&halfway, v), h);
        self.normalise(q);
    }
}
