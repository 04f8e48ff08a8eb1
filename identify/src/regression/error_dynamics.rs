//! The linear equation of the departure from the logged curve.

use super::closed::{Closed, Missed};
use super::in_time::in_time;
use super::local::{Local, Looked, locals};
use super::moments::Moments;
use super::mover::{Columns, Mover};
use super::sensed::Sensed;
use super::shooting::{Shot, shoot, unresolved, usual_accelerations};
use super::shown::Shown;
use super::trails::Trails;
use super::transition::{decay, transition};
use super::unseen::{bends, forces};
use crate::log::longest_step;
use crate::machine::{SolveError, States};
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;
use std::ops::Range;

pub use crate::machine::Hold;

/// `δ_{k+1} = Φ_k δ_k + d_k + Γ_k c + w_k`, per interval; readings of acceleration
/// are `y = a + F δ + G c`, per sample. `δ = (δq, δv, f)` has `3n` entries: the
/// departure, and a generalised force that nothing explains, an Ornstein–Uhlenbeck
/// process `ḟ = −f/τ + w`.
#[derive(Debug, Clone)]
pub struct ErrorDynamics {
    /// Sampling instants.
    pub t: Vec<f64>,
    /// `Φ_k`, `3n×3n`, one fewer than samples.
    pub transition: Vec<DMatrix<f64>>,
    /// `d_k | Γ_k`, `2n×(1+p)`: what the model misses, and what each column adds to
    /// position and velocity.
    pub forcing: Vec<DMatrix<f64>>,
    /// `F = [∂a/∂q, ∂a/∂v, P]`, `n×3n`, per sample.
    pub slope: Vec<DMatrix<f64>>,
    /// `a | G`, `n×(1+p)`, per sample.
    pub acceleration: Vec<DMatrix<f64>>,
    /// `I − P M`, `n×n`, per interval: the accelerations that constraints forbid. Empty
    /// without constraints.
    pub forbidden: Vec<DMatrix<f64>>,
    /// What inputs may exert on each coordinate beside what is drawn between samples, per interval and for a
    /// share of one of [`ProcessNoise::unseen`](super::ProcessNoise::unseen).
    pub unseen: Vec<DVector<f64>>,
    /// Root mean square of each acceleration along the curve: a scale.
    pub acceleration_scale: DVector<f64>,
    /// Root mean square of each generalised force along the curve: a scale.
    pub force_scale: DVector<f64>,
    /// Root mean square of what a unit of each generalised force accelerates its own coordinate
    /// by, `P_ii`, along the curve.
    pub mobility_scale: DVector<f64>,
    /// How long unexplained forces last, `τ` per coordinate, s.
    pub correlation: DVector<f64>,
    /// Number of columns `p`.
    pub columns: usize,
    /// What columns change in readings alone.
    pub sensed: Sensed,
    /// What the model's sensors show, per sample; empty if a log has none of them.
    pub shown: Vec<Shown>,
    /// When each of the model's sensors was read, or nothing: at the stamps.
    pub moments: Vec<Option<Moments>>,
    /// What holonomic constraints say about the curve.
    pub closed: Closed,
}

/// How long a force that nothing explains is thought to last before the log says otherwise, s.
pub const CORRELATION: f64 = 0.1;

/// Samples handled at once.
const CHUNK: usize = 256;

impl ErrorDynamics {
    /// Linearises the motion of `mover` along `curve`.
    ///
    /// # Errors
    /// If the equation of motion has no unique solution somewhere on the curve.
    pub fn new(
        mover: Mover<'_>,
        columns: &[Columns<'_>],
        curve: &States,
        hold: Hold,
        correlation: &DVector<f64>,
    ) -> Result<Self, SolveError> {
        let chunks: Vec<Range<usize>> = (0..curve.len() - 1)
            .step_by(CHUNK)
            .map(|start| start..(start + CHUNK).min(curve.len() - 1))
            .collect();
        let longest = longest_step(&curve.t);
        let holonomic = mover.machine.holonomic_rows();
        let trails = Trails::new(mover, columns, curve, hold)?;
        let bends = bends(curve);
        let pieces: Vec<Piece> = chunks
            .into_par_iter()
            .map(|range| {
                let visited = [(0, 0.0), (1, 0.5), (2, 1.0)].map(|(node, share)| {
                    let states = curve.between(range.clone(), share, hold, longest);
                    trails.visit(states, node, range.clone())
                });
                let looked = Looked::new(mover, columns, &visited);
                let looked = looked.map_err(|error| error.offset(range.start))?;
                let nodes = looked.nodes();
                let forces = (correlation, &holonomic[..]);
                let mut piece = piece(curve, range.clone(), longest, forces, nodes);
                piece.unseen = forces_unseen(&bends, range.clone(), nodes[0]);
                let unresolved = unresolved(curve, range.clone(), longest, nodes);
                if !unresolved.is_empty() {
                    let on_the_way = |places: &[usize], states: &mut States, shares: &[f64]| {
                        let intervals: Vec<usize> = places.iter().map(|&i| unresolved[i]).collect();
                        let memories = trails.within(states, &intervals, shares);
                        let found = locals(mover.unseen(), columns, states, &memories);
                        found.map_err(|error| error.renumbered(|place| intervals[place]))
                    };
                    let rates = trails.input_rates(curve, &unresolved, hold);
                    let over = (&unresolved[..], &rates);
                    let shots = shots(curve, over, hold, correlation, on_the_way)?;
                    piece.shoot(range.start, &unresolved, shots, (curve, correlation));
                }
                for start in looked.into_beginnings() {
                    piece.acceleration.push(start.acceleration);
                    piece.shown.extend(start.shown);
                }
                Ok(piece)
            })
            .collect::<Result<_, SolveError>>()?;
        let (mut all, mut missed) = Self::join(curve, pieces);
        all.correlation.clone_from(correlation);
        let end = curve.len() - 1;
        let last = trails.visit(curve.slice(end..end + 1), 2, end - 1..end);
        let mut last = locals(mover, columns, &last.states, &last.memories)?.remove(0);
        all.slope.push(last.slope_and_mobility());
        all.shown.extend(last.shown.take());
        missed.push(last.missed(&holonomic));
        all.acceleration.push(last.acceleration);
        if let Some((states, memories)) = trails.at_jumps(curve) {
            let felt = locals(mover, columns, &states, &memories)?.into_iter();
            let (accelerations, shown): (_, Vec<_>) =
                felt.map(|l| (l.acceleration, l.shown)).unzip();
            all.acceleration = accelerations;
            all.shown = shown.into_iter().flatten().collect();
        }
        all.moments = in_time(&mut all.shown, &curve.t, mover, columns);
        all.closed = Closed::new(columns, curve, missed);
        all.sensed = Sensed::new(columns, curve, &all.accelerations());
        Ok(all)
    }

    /// Pieces put together, and how far off constraints are along them.
    fn join(curve: &States, pieces: Vec<Piece>) -> (Self, Vec<Missed>) {
        let samples = curve.len();
        let columns = pieces.first().map_or(0, |p| p.forcing[0].ncols() - 1);
        let mut all = Self {
            t: curve.t.clone(),
            transition: Vec::with_capacity(samples),
            forcing: Vec::with_capacity(samples),
            slope: Vec::with_capacity(samples),
            acceleration: Vec::with_capacity(samples),
            forbidden: Vec::new(),
            unseen: Vec::with_capacity(samples),
            acceleration_scale: DVector::zeros(curve.q.len()),
            force_scale: DVector::zeros(curve.q.len()),
            mobility_scale: DVector::zeros(curve.q.len()),
            correlation: DVector::zeros(curve.q.len()),
            columns,
            sensed: Sensed::default(),
            shown: Vec::new(),
            moments: Vec::new(),
            closed: Closed::default(),
        };
        let mut missed = Vec::with_capacity(samples);
        for piece in pieces {
            missed.extend(piece.missed);
            all.transition.extend(piece.transition);
            all.forcing.extend(piece.forcing);
            all.slope.extend(piece.slope);
            all.acceleration.extend(piece.acceleration);
            all.shown.extend(piece.shown);
            all.forbidden.extend(piece.forbidden);
            all.unseen.extend(piece.unseen);
            all.force_scale += piece.force;
        }
        for acceleration in &all.acceleration {
            all.acceleration_scale += acceleration.column(0).map(|a| a * a);
        }
        all.acceleration_scale
            .apply(|x| *x = (*x / samples as f64).sqrt());
        all.force_scale.apply(|x| *x = (*x / samples as f64).sqrt());
        let n = curve.q.len();
        all.mobility_scale = DVector::from_fn(n, |i, _| {
            let own = all.slope.iter().map(|slope| slope[(i, 2 * n + i)].powi(2));
            (own.sum::<f64>() / samples as f64).sqrt()
        });
        (all, missed)
    }

    /// Accelerations along the curve, one column per coordinate.
    pub fn accelerations(&self) -> Vec<Vec<f64>> {
        let column = |i: usize| self.acceleration.iter().map(|a| a[(i, 0)]).collect();
        (0..self.coordinate_count()).map(column).collect()
    }

    /// Number of coordinates.
    pub fn coordinate_count(&self) -> usize {
        self.slope[0].nrows()
    }
}

/// A run of intervals.
struct Piece {
    transition: Vec<DMatrix<f64>>,
    forcing: Vec<DMatrix<f64>>,
    slope: Vec<DMatrix<f64>>,
    acceleration: Vec<DMatrix<f64>>,
    shown: Vec<Shown>,
    forbidden: Vec<DMatrix<f64>>,
    unseen: Vec<DVector<f64>>,
    force: DVector<f64>,
    missed: Vec<Missed>,
}

impl Piece {
    /// Puts shots in the place of what was seen from the curve.
    fn shoot(
        &mut self,
        first: usize,
        intervals: &[usize],
        shots: Vec<Shot>,
        (curve, correlation): (&States, &DVector<f64>),
    ) {
        let n = curve.q.len();
        for (&k, shot) in intervals.iter().zip(shots) {
            let decay = correlation.map(|tau| decay(curve.t[k + 1] - curve.t[k], tau));
            let whole = &mut self.transition[k - first];
            whole
                .view_mut((0, 0), (2 * n, 2 * n))
                .copy_from(&shot.motion);
            whole
                .view_mut((0, 2 * n), (2 * n, n))
                .copy_from(&shot.pushed);
            whole.view_mut((2 * n, 2 * n), (n, n)).set_diagonal(&decay);
            self.forcing[k - first] = shot.forcing;
        }
    }
}

/// Shots over some intervals of the curve.
fn shots(
    curve: &States,
    (intervals, rates): (&[usize], &DMatrix<f64>),
    hold: Hold,
    correlation: &DVector<f64>,
    local: impl Fn(&[usize], &mut States, &[f64]) -> Result<Vec<Local>, SolveError>,
) -> Result<Vec<Shot>, SolveError> {
    let from = curve.pick(intervals);
    let next: Vec<usize> = intervals.iter().map(|k| k + 1).collect();
    let to = curve.pick(&next);
    shoot(
        &from,
        &to,
        rates,
        (&usual_accelerations(curve), correlation),
        |places, states, shares| {
            let mut states = states.clone();
            for (at, (&i, &share)) in places.iter().zip(shares).enumerate() {
                states.t[at] = from.t[i] + share * (to.t[i] - from.t[i]);
                for (u, (a, b)) in states.u.iter_mut().zip(from.u.iter().zip(&to.u)) {
                    u[at] = match hold {
                        Hold::Linear => a[i] + share * (b[i] - a[i]),
                        Hold::Previous => a[i],
                    };
                }
            }
            local(places, &mut states, shares)
        },
    )
}

fn piece(
    curve: &States,
    range: Range<usize>,
    longest: f64,
    (correlation, holonomic): (&DVector<f64>, &[usize]),
    [starts, middles, ends]: [&[Local]; 3],
) -> Piece {
    let n = curve.q.len();
    let mut piece = Piece {
        transition: Vec::new(),
        forcing: Vec::new(),
        slope: Vec::new(),
        acceleration: Vec::new(),
        shown: Vec::new(),
        forbidden: Vec::new(),
        unseen: Vec::new(),
        force: DVector::zeros(n),
        missed: Vec::new(),
    };
    for (i, k) in range.enumerate() {
        let h = curve.t[k + 1] - curve.t[k];
        let (start, middle, end) = (&starts[i], &middles[i], &ends[i]);
        let mobility = middle.mobility();
        // Across a gap nothing is predicted.
        if h > longest {
            let width = start.acceleration.ncols();
            piece.transition.push(DMatrix::zeros(3 * n, 3 * n));
            piece.forcing.push(DMatrix::zeros(2 * n, width));
        } else {
            let transition = transition(&middle.slope, &mobility, h, correlation);
            let mut forcing = forcing(curve, k, start, middle, end);
            // What the curve misses pushes all along the interval, through half of it on average, as
            // the forces of `transition` do that make up for it. Were it given at the end instead, the
            // two would differ by `½ h² ∂a/∂v P f`, against constraints first of all.
            let onwards = transition.view((n, n), (n, n)) + DMatrix::identity(n, n);
            let pushed = onwards * forcing.rows(n, n) * 0.5;
            forcing.rows_mut(n, n).copy_from(&pushed);
            piece.transition.push(transition);
            piece.forcing.push(forcing);
        }
        piece.slope.push(start.slope_and_mobility());
        piece.forbidden.extend(middle.forbidden(&mobility));
        piece.force += &start.force_size();
        piece.missed.push(start.missed(holonomic));
    }
    piece
}

/// [`ErrorDynamics::unseen`] of some intervals.
fn forces_unseen(bends: &DMatrix<f64>, range: Range<usize>, starts: &[Local]) -> Vec<DVector<f64>> {
    let each = range.zip(starts);
    let of_one = |(k, start): (usize, &Local)| {
        forces(&start.motion.terms.input_matrix, bends.column(k).as_slice())
    };
    each.map(of_one).collect()
}

/// `∫ a` and `∫ (h−τ) a` by Simpson's rule, minus what the curve does itself.
fn forcing(curve: &States, k: usize, start: &Local, middle: &Local, end: &Local) -> DMatrix<f64> {
    let h = curve.t[k + 1] - curve.t[k];
    let n = curve.q.len();
    let mut forcing = DMatrix::zeros(2 * n, start.acceleration.ncols());
    let [starts, middles, ends] =
        [start, middle, end].map(|local| local.acceleration.as_slice().chunks_exact(n));
    let columns = forcing.as_mut_slice().chunks_exact_mut(2 * n);
    for (column, ((start, middle), end)) in columns.zip(starts.zip(middles).zip(ends)) {
        let (position, velocity) = column.split_at_mut(n);
        let places = start.iter().zip(middle).zip(end);
        let both = position.iter_mut().zip(velocity);
        for ((position, velocity), ((a, b), c)) in both.zip(places) {
            *position = h * h / 6.0 * (a + 2.0 * b);
            *velocity = h / 6.0 * (a + 4.0 * b + c);
        }
    }
    for i in 0..n {
        let (q, v) = (&curve.q[i], &curve.v[i]);
        forcing[(i, 0)] += q[k] + h * v[k] - q[k + 1];
        forcing[(n + i, 0)] += v[k] - v[k + 1];
    }
    forcing
}

#[cfg(test)]
mod tests {
    use super::super::shooting::tests::free;
    use super::*;
    use crate::machine::Motion;

    const MASS: f64 = 2.0;
    const DAMPING: f64 = 40.0;
    const FORCE: f64 = 0.7;

    /// What a force does that no model holds, a curve misses: `m v̇ = f − d v` along its exact
    /// solution, beside `m v̇ = −d v`.
    #[test]
    fn a_force_makes_up_for_what_the_curve_misses() {
        let h = 5e-3;
        let position = |t: f64| {
            let time = MASS / DAMPING;
            FORCE / DAMPING * (t - time * (1.0 - (-t / time).exp()))
        };
        let velocity = |t: f64| FORCE / DAMPING * (1.0 - (-t * DAMPING / MASS).exp());
        let t: Vec<f64> = (0..9).map(|k| h * f64::from(k)).collect();
        let curve = States {
            q: vec![t.iter().map(|&t| position(t)).collect()],
            v: vec![t.iter().map(|&t| velocity(t)).collect()],
            t: t.clone(),
            ..States::default()
        };
        let local = |t: f64| {
            let force = -DAMPING * velocity(t);
            Local {
                acceleration: DMatrix::from_element(1, 1, force / MASS),
                slope: DMatrix::from_row_slice(1, 2, &[0.0, -DAMPING / MASS]),
                motion: Motion::of(free(MASS, force), &[], 0).unwrap(),
                shown: None,
            }
        };
        let at = |share: f64| -> Vec<Local> { t.iter().map(|t| local(t + share * h)).collect() };
        let lasting = DVector::from_element(1, 1e6);
        let places = [at(0.0), at(0.5), at(1.0)];
        let places = [&places[0][..], &places[1][..], &places[2][..]];
        let piece = piece(&curve, 0..8, 1.0, (&lasting, &[]), places);
        for (transition, missed) in piece.transition.iter().zip(&piece.forcing) {
            let left = missed[(1, 0)] + transition[(1, 2)] * FORCE;
            // Given at once at the end, five per cent of what the force does in that time.
            assert!(left.abs() < 2e-3 * h * FORCE / MASS, "{left}");
        }
    }
}
