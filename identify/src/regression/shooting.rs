//! Intervals that a quadrature along the curve does not resolve: shot through in short steps.
//!
//! Where dry friction holds a light joint, the acceleration changes within one interval by
//! more than three places on it can tell, and the curve's own defect says nothing about where
//! the machine would go. There the machine itself is moved from the curve's state at the
//! beginning of the interval to its end, by an exponential Rosenbrock method of third order
//! (`exprb32` of Hochbruck and Ostermann, "Exponential integrators", 2010, section 2.4) with
//! the stiff part `V = ∂a/∂v` in the exponential, and what else changes the acceleration steadily,
//! `s = ∂a/∂q v + ∂a/∂u u̇`, beside it, in steps as long as their error allows:
//!
//! ```text
//! q ← q + h v + h² φ₂(hV) a + h³ φ₃(hV) s        φ₁(z) = (eᶻ − 1)/z
//! v ← v + h φ₁(hV) a + h² φ₂(hV) s + 2 h φ₃(hV) d     φₖ₊₁(z) = (φₖ(z) − 1/k!)/z
//! ```
//!
//! where `d` is the acceleration at the end of the step less `a + V Δv + h s`; what `d` adds is
//! also taken for the error, and a quarter of it, times `h`, for what it adds to `q`.
//!
//! The departure's transition, and what each column adds, go through the same steps, with the
//! mean of `V` and `∂a/∂q` at both ends, and what they add going straight from one end to the other.

use super::local::Local;
use super::transition::decay;
use crate::machine::{Motion, SolveError, States};
use nalgebra::{DMatrix, DVector};
use std::ops::Range;

/// The departure's equation over one interval.
pub(super) struct Shot {
    /// `Φ`, `2n×2n`.
    pub motion: DMatrix<f64>,
    /// What a force that falls off from 1 adds, `2n×n`.
    pub pushed: DMatrix<f64>,
    /// Where the machine goes, less where the curve does, and what each column adds,
    /// `2n×(1+p)`.
    pub forcing: DMatrix<f64>,
}

/// `h ‖∂a/∂v‖` beyond which an interval is stiff.
const STIFF: f64 = 1.0;
/// A quadrature is off, or a step too long, if its error is this share of what the accelerations usually do in
/// the interval.
const ROUGH: f64 = 5e-4;
const TOLERANCE: f64 = 3e-4;
/// The shortest step, as a share of the interval.
const SHORTEST: f64 = 1.0 / 64.0;

/// The intervals in `range` that a quadrature along the curve does not resolve.
pub(super) fn unresolved(
    curve: &States,
    range: Range<usize>,
    longest: f64,
    [starts, middles, ends]: [&[Local]; 3],
) -> Vec<usize> {
    let usual = usual_accelerations(curve);
    let is_so = |&(i, k): &(usize, usize)| {
        let h = curve.t[k + 1] - curve.t[k];
        let places = [&starts[i], &middles[i], &ends[i]];
        h <= longest && is_unresolved(places, &ends_of(curve, k), h, &usual)
    };
    range.enumerate().filter(is_so).map(|(_, k)| k).collect()
}

/// How the curve moves at one end of an interval.
struct End {
    velocity: DVector<f64>,
    acceleration: DVector<f64>,
}

/// How the curve moves at both ends of the interval after sample `k`, on its cubics.
fn ends_of(curve: &States, k: usize) -> [End; 2] {
    let n = curve.q.len();
    let h = curve.t[k + 1] - curve.t[k];
    let end = |at: usize, far: usize, sign: f64| End {
        velocity: DVector::from_fn(n, |j, _| curve.v[j][at]),
        acceleration: DVector::from_fn(n, |j, _| {
            let (q, v) = (&curve.q[j], &curve.v[j]);
            sign * (6.0 * (q[k + 1] - q[k]) / h - 4.0 * v[at] - 2.0 * v[far]) / h
        }),
    };
    [end(k, k + 1, 1.0), end(k + 1, k, -1.0)]
}

/// Root mean squares of the curve's accelerations.
pub(super) fn usual_accelerations(curve: &States) -> Vec<f64> {
    let change = |v: &Vec<f64>| {
        let squares = v.windows(2).zip(curve.t.windows(2));
        let squares = squares.map(|(v, t)| ((v[1] - v[0]) / (t[1] - t[0])).powi(2));
        (squares.sum::<f64>() / v.len() as f64).sqrt()
    };
    curve.v.iter().map(change).collect()
}

/// Whether an interval of `h` seconds must be shot through, by what is seen at its beginning, middle and end, and
/// how the curve moves at both ends; `usual` are the accelerations' root mean squares.
///
/// A cubic goes from the acceleration at the beginning, `a₀`, to that at the end, `a₁`, with the slopes that these
/// have along the curve, `ȧ = ∂a/∂q q̇ + ∂a/∂v q̈` (what inputs that go straight add is the same at both ends). Where
/// the acceleration in the middle is not the cubic's, `½ (a₀ + a₁) + ⅛ h (ȧ₀ − ȧ₁)`, Simpson's rule is off by ²⁄₁₅ of
/// the difference, to the next order.
fn is_unresolved(
    [start, middle, end]: [&Local; 3],
    [first, last]: &[End; 2],
    h: f64,
    usual: &[f64],
) -> bool {
    let n = usual.len();
    let rate = |local: &Local| local.slope.columns(n, n).amax();
    if [start, middle, end]
        .iter()
        .any(|local| h * rate(local) > STIFF)
    {
        return true;
    }
    let slope = |local: &Local, end: &End| {
        local.slope.columns(0, n) * &end.velocity + local.slope.columns(n, n) * &end.acceleration
    };
    let turned = slope(start, first) - slope(end, last);
    usual.iter().enumerate().any(|(i, &usual)| {
        let at = |local: &Local| local.acceleration[(i, 0)];
        let cubic = 0.5 * (at(start) + at(end)) + 0.125 * h * turned[i];
        2.0 / 15.0 * (cubic - at(middle)).abs() > ROUGH * usual
    })
}

/// A machine on its way through an interval.
struct Way {
    shot: Shot,
    /// How far it is, as a share of the interval, and the next step.
    share: f64,
    step: f64,
    here: Local,
}

/// Shoots from the curve's states at `from` (one per interval, in columns) to those at `to`.
/// `local(intervals, states, shares)` says what the machine does in these states, these
/// shares of the way into the intervals with these numbers. `usual` are the accelerations'
/// root mean squares, `rates` how fast inputs, then late ones, change in each interval, one
/// column per interval.
///
/// # Errors
/// If the equation of motion has no unique solution on the way.
pub(super) fn shoot(
    from: &States,
    to: &States,
    rates: &DMatrix<f64>,
    (usual, correlation): (&[f64], &DVector<f64>),
    local: impl Fn(&[usize], &States, &[f64]) -> Result<Vec<Local>, SolveError>,
) -> Result<Vec<Shot>, SolveError> {
    let (n, count) = (from.q.len(), from.len());
    let mut now = from.clone();
    let mut active: Vec<usize> = (0..count).collect();
    let starts = local(&active, from, &vec![0.0; count])?;
    let mut ways: Vec<Way> = starts.into_iter().map(Way::new).collect();
    while !active.is_empty() {
        let ahead = active.iter().map(|&i| {
            let (here, h) = (&ways[i].here, ways[i].step * (to.t[i] - from.t[i]));
            let v = DVector::from_fn(n, |j, _| now.v[j][i]);
            let steady = steady(here, &v, rates.column(i).into_owned()) * h;
            (Short::new(&here.slope, h), steady)
        });
        let ahead: Vec<(Short, DVector<f64>)> = ahead.collect();
        let mut there = now.pick(&active);
        for (place, (&i, (short, steady))) in active.iter().zip(&ahead).enumerate() {
            let added = &short.reach * ways[i].here.acceleration.column(0) + &short.bend * steady;
            for j in 0..n {
                there.q[j][place] += short.h * now.v[j][i] + added[j];
                there.v[j][place] += added[n + j];
            }
        }
        let shares: Vec<f64> = active
            .iter()
            .map(|&i| ways[i].share + ways[i].step)
            .collect();
        let found = local(&active, &there, &shares)?;
        for (place, (local, (short, steady))) in found.into_iter().zip(&ahead).enumerate() {
            let i = active[place];
            let moved = DVector::from_fn(n, |j, _| there.v[j][place] - now.v[j][i]);
            let way = &mut ways[i];
            let correction = short.correction(&way.here, &local, (&moved, steady));
            let whole = to.t[i] - from.t[i];
            let rough = (0..n)
                .map(|j| {
                    correction[j].abs() / (TOLERANCE * usual[j] * whole).max(f64::MIN_POSITIVE)
                })
                .fold(0.0, f64::max);
            let next = way.step * 0.8 / rough.cbrt();
            if rough > 1.0 && way.step > SHORTEST {
                way.step = next.max(0.1 * way.step).max(SHORTEST);
                continue;
            }
            way.go(short.h, local, (&correction, correlation));
            way.step = next.clamp(0.5 * way.step, 4.0 * way.step).max(SHORTEST);
            way.step = way.step.min(1.0 - way.share);
            for j in 0..n {
                now.q[j][i] = there.q[j][place] + 0.25 * short.h * correction[j];
                now.v[j][i] = there.v[j][place] + correction[j];
            }
        }
        active.retain(|&i| ways[i].step > 1e-9);
    }
    let mut shots: Vec<Shot> = ways.into_iter().map(|way| way.shot).collect();
    for (i, shot) in shots.iter_mut().enumerate() {
        for j in 0..n {
            shot.forcing[(j, 0)] = now.q[j][i] - to.q[j][i];
            shot.forcing[(n + j, 0)] = now.v[j][i] - to.v[j][i];
        }
    }
    Ok(shots)
}

impl Way {
    fn new(here: Local) -> Self {
        let n = here.slope.nrows();
        Self {
            shot: Shot {
                motion: DMatrix::identity(2 * n, 2 * n),
                pushed: DMatrix::zeros(2 * n, n),
                forcing: DMatrix::zeros(2 * n, here.acceleration.ncols()),
            },
            share: 0.0,
            step: 1.0,
            here,
        }
    }

    /// Takes a step of `h` seconds that ends at `there`, with the velocity corrected.
    fn go(
        &mut self,
        h: f64,
        mut there: Local,
        (correction, correlation): (&DVector<f64>, &DVector<f64>),
    ) {
        let Self { shot, here, .. } = self;
        let mean = Short::new(&((&here.slope + &there.slope) * 0.5), h);
        let gone = self.share / self.step * h;
        let force = |local: &Local, gone: f64| {
            let left = correlation.map(|tau| decay(gone, tau));
            local.mobility() * DMatrix::from_diagonal(&left)
        };
        let (first, last) = (force(here, gone), force(&there, gone + h));
        shot.pushed = &mean.motion * &shot.pushed + mean.added(&first, &last);
        shot.motion = &mean.motion * &shot.motion;
        shot.forcing = &mean.motion * &shot.forcing;
        let width = here.acceleration.ncols() - 1;
        let [first, last] =
            [&*here, &there].map(|local| local.acceleration.columns(1, width).into_owned());
        let mut columns = shot.forcing.columns_mut(1, width);
        columns += mean.added(&first, &last);
        let n = correction.len();
        let corrected = there.slope.columns(n, n) * correction;
        let mut acceleration = there.acceleration.column_mut(0);
        acceleration += corrected;
        self.share += self.step;
        self.here = there;
    }
}

/// How fast the acceleration changes otherwise than by the velocity, `∂a/∂q v + P B u̇`.
fn steady(local: &Local, velocity: &DVector<f64>, rates: DVector<f64>) -> DVector<f64> {
    let Motion {
        terms,
        factorisation,
        ..
    } = &local.motion;
    let pushed = DMatrix::from_columns(&[&terms.input_matrix * rates]);
    let unmoved = DMatrix::zeros(terms.constraint_matrix.nrows(), 1);
    let (by_inputs, _) = factorisation.solve(pushed, &unmoved);
    local.slope.columns(0, velocity.len()) * velocity + by_inputs.column(0)
}

/// One short step.
struct Short {
    /// Its length, s.
    h: f64,
    /// `Φ`, `2n×2n`.
    motion: DMatrix<f64>,
    /// What an acceleration adds, `[h² φ₂; h φ₁]`, `2n×n`.
    reach: DMatrix<f64>,
    /// What one adds that grows from nothing to 1, `[h² φ₃; h φ₂]`, `2n×n`.
    bend: DMatrix<f64>,
}

impl Short {
    /// A step of `h` seconds where `slope` is `[∂a/∂q, ∂a/∂v]`.
    fn new(slope: &DMatrix<f64>, h: f64) -> Self {
        let n = slope.nrows();
        let [phi_0, phi_1, phi_2, phi_3] = phi(&(slope.columns(n, n) * h));
        let stacked = |upper: &DMatrix<f64>, lower: &DMatrix<f64>| {
            let mut both = DMatrix::zeros(2 * n, n);
            both.rows_mut(0, n).copy_from(&(upper * (h * h)));
            both.rows_mut(n, n).copy_from(&(lower * h));
            both
        };
        let (reach, bend) = (stacked(&phi_2, &phi_1), stacked(&phi_3, &phi_2));
        let mut motion = DMatrix::identity(2 * n, 2 * n);
        motion.view_mut((0, n), (n, n)).copy_from(&(phi_1 * h));
        motion.view_mut((n, n), (n, n)).copy_from(&phi_0);
        let by_position = &reach * slope.columns(0, n);
        let mut first = motion.columns_mut(0, n);
        first += by_position;
        Self {
            h,
            motion,
            reach,
            bend,
        }
    }

    /// What accelerations add that go straight from the `first` to the `last`.
    fn added(&self, first: &DMatrix<f64>, last: &DMatrix<f64>) -> DMatrix<f64> {
        &self.reach * first + &self.bend * (last - first)
    }

    /// What the acceleration at the end of a step is beside its tangent adds to the velocity,
    /// `2 h φ₃(hV) d`, where velocities `moved` by so much and the acceleration was to grow by `steady`.
    fn correction(
        &self,
        here: &Local,
        there: &Local,
        (moved, steady): (&DVector<f64>, &DVector<f64>),
    ) -> DVector<f64> {
        let n = here.slope.nrows();
        let tangent = here.acceleration.column(0) + here.slope.columns(n, n) * moved + steady;
        let bent = there.acceleration.column(0) - tangent;
        self.bend.rows(0, n) * bent * (2.0 / self.h)
    }
}

/// `φ₀ = exp`, `φ₁`, `φ₂` and `φ₃` of a matrix: their series for a part of it, doubled by
/// `φ₃(2z) = (φ₁ φ₂ + φ₂ + 2 φ₃)/8`, `φ₂(2z) = (φ₁² + 2 φ₂)/4`, `φ₁(2z) = (φ₀ + 1) φ₁/2` and
/// `φ₀(2z) = φ₀²`.
fn phi(matrix: &DMatrix<f64>) -> [DMatrix<f64>; 4] {
    let n = matrix.nrows();
    let one = DMatrix::<f64>::identity(n, n);
    let size = matrix.amax() * n as f64;
    let doublings = (size / SERIES).log2().ceil().clamp(0.0, MOST_DOUBLINGS) as i32;
    let part = matrix * 0.5_f64.powi(doublings);
    let mut phi_3 = &one / factorial(TERMS + 3);
    for power in (0..TERMS).rev() {
        phi_3 = &part * phi_3 + &one / factorial(power + 3);
    }
    let mut phi_2 = &part * &phi_3 + &one * 0.5;
    let mut phi_1 = &part * &phi_2 + &one;
    let mut phi_0 = &part * &phi_1 + &one;
    for _ in 0..doublings {
        phi_3 = (&phi_1 * &phi_2 + &phi_2 + phi_3 * 2.0) * 0.125;
        phi_2 = (&phi_1 * &phi_1 + phi_2 * 2.0) * 0.25;
        phi_1 = (&phi_0 + &one) * phi_1 * 0.5;
        phi_0 = &phi_0 * &phi_0;
    }
    [phi_0, phi_1, phi_2, phi_3]
}

fn factorial(n: usize) -> f64 {
    (1..=n).map(|k| k as f64).product()
}

/// Size for which the series is summed, its last power, and the most doublings.
const SERIES: f64 = 0.5;
const TERMS: usize = 8;
const MOST_DOUBLINGS: f64 = 40.0;

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::machine::Terms;
    use crate::regression::{CORRELATION, Hold};

    #[test]
    fn phi_functions_are_those_of_the_exponential() {
        let matrix = DMatrix::from_row_slice(2, 2, &[-40.0, 3.0, 1.0, -0.2]);
        let [phi_0, phi_1, phi_2, phi_3] = phi(&matrix);
        let one = DMatrix::identity(2, 2);
        assert!((&phi_0 - matrix.exp()).amax() < 1e-12);
        assert!((&matrix * &phi_1 - (&phi_0 - &one)).amax() < 1e-12);
        assert!((&matrix * &phi_2 - (&phi_1 - &one)).amax() < 1e-12);
        assert!((&matrix * &phi_3 - (&phi_2 - &one * 0.5)).amax() < 1e-12);
    }

    const U: f64 = 0.3;
    const F: f64 = 0.5;
    const V_S: f64 = 0.02;
    const MASS: f64 = 0.004;

    fn acceleration(v: f64) -> f64 {
        (U - F * (v / V_S).tanh()) / MASS
    }

    /// The terms of a body with nothing in its way that a force pushes.
    pub fn free(mass: f64, force: f64) -> Terms {
        let (none, no_row) = (DVector::zeros(0), DMatrix::zeros(0, 1));
        Terms {
            mass_matrix: DMatrix::from_element(1, 1, mass),
            bias_force: DVector::zeros(1),
            applied_force: DVector::zeros(1),
            input_matrix: DMatrix::zeros(1, 0),
            force: DVector::from_element(1, force),
            multiplier_slope: DMatrix::zeros(1, 0),
            constraint_matrix: no_row,
            constraint_bias: none.clone(),
            constraint_residual: none.clone(),
            constraint_rate: none,
        }
    }

    /// A light body that dry friction brings to a stop within one interval of 5 ms.
    fn shot_from(q: f64, v: f64) -> Shot {
        let states = |t: f64, q: f64, v: f64| States {
            t: vec![t],
            q: vec![vec![q]],
            v: vec![vec![v]],
            ..States::default()
        };
        let local = |_: &[usize], states: &States, _: &[f64]| {
            let v = states.v[0][0];
            let slope = -F / (MASS * V_S) * (1.0 - (v / V_S).tanh().powi(2));
            Ok(vec![Local {
                acceleration: DMatrix::from_row_slice(1, 2, &[acceleration(v), 1.0 / MASS]),
                slope: DMatrix::from_row_slice(1, 2, &[0.0, slope]),
                motion: Motion::of(free(MASS, MASS * acceleration(v)), &[], 0)?,
                shown: None,
            }])
        };
        let (from, to) = (states(0.0, q, v), states(5e-3, 0.0, 0.0));
        shoot(
            &from,
            &to,
            &DMatrix::zeros(0, 1),
            (&[50.0], &DVector::from_element(1, CORRELATION)),
            local,
        )
        .unwrap()
        .remove(0)
    }

    /// Friction whose smooth sign turns over a few intervals is resolved, over one it is not; and neither is a
    /// force that only grows taken for one that turns.
    #[test]
    fn what_bends_within_an_interval_is_unresolved() {
        let h = 5e-3;
        let (pushed, mass) = (8.0, 1.0);
        let is_so = |width: f64, middle: f64| {
            let local = |share: f64| {
                let v = middle + (share - 0.5) * h * pushed;
                let sign = (v / width).tanh();
                Local {
                    acceleration: DMatrix::from_element(1, 1, pushed - F * sign),
                    slope: DMatrix::from_row_slice(1, 2, &[0.0, -F / width * (1.0 - sign * sign)]),
                    motion: Motion::of(free(mass, pushed - F * sign), &[], 0).unwrap(),
                    shown: None,
                }
            };
            let end = |share: f64| End {
                velocity: DVector::from_element(1, middle + (share - 0.5) * h * pushed),
                acceleration: DVector::from_element(1, pushed),
            };
            let places = [local(0.0), local(0.5), local(1.0)];
            is_unresolved(places.each_ref(), &[end(0.0), end(1.0)], h, &[pushed])
        };
        assert!(!is_so(0.3, 0.05));
        assert!(is_so(0.01, 0.005));
        assert!(!is_so(0.01, 1.0));
    }

    /// A curve whose velocities do not fit its positions bends within an interval; what is proportional to its
    /// velocity bends with it, and the quadrature is as good as ever.
    #[test]
    fn a_rough_curve_is_resolved() {
        let (h, damping) = (5e-3, 1.0);
        let curve = States {
            t: vec![0.0, h],
            q: vec![vec![0.0, 0.0]],
            v: vec![vec![0.1, -0.05]],
            ..States::default()
        };
        let middle = curve.between(0..1, 0.5, Hold::Linear, h).v[0][0];
        let local = |v: f64| Local {
            acceleration: DMatrix::from_element(1, 1, -damping * v),
            slope: DMatrix::from_row_slice(1, 2, &[0.0, -damping]),
            motion: Motion::of(free(1.0, -damping * v), &[], 0).unwrap(),
            shown: None,
        };
        let places = [0.1, middle, -0.05].map(local);
        assert!(!is_unresolved(
            places.each_ref(),
            &ends_of(&curve, 0),
            h,
            &[1.0]
        ));
    }

    /// What an input that grows evenly does is passed in one step, whose end says that it was one.
    #[test]
    fn an_input_that_grows_evenly_is_one_step() {
        let (h, rate, mass) = (5e-3, 40.0, 0.5);
        let states = |t: f64| States {
            t: vec![t],
            q: vec![vec![0.0]],
            v: vec![vec![0.0]],
            ..States::default()
        };
        let seen = std::cell::Cell::new(0);
        let local = |_: &[usize], _: &States, shares: &[f64]| {
            seen.set(seen.get() + 1);
            let force = F + rate * h * shares[0];
            let mut terms = free(mass, force);
            terms.input_matrix = DMatrix::from_element(1, 1, 1.0);
            Ok(vec![Local {
                acceleration: DMatrix::from_row_slice(1, 2, &[force / mass, force]),
                slope: DMatrix::zeros(1, 2),
                motion: Motion::of(terms, &[], 0)?,
                shown: None,
            }])
        };
        let usual = (&[1.0][..], &DVector::from_element(1, CORRELATION));
        let rates = DMatrix::from_element(1, 1, rate);
        let shot = shoot(&states(0.0), &states(h), &rates, usual, local)
            .unwrap()
            .remove(0);
        assert_eq!(seen.get(), 2);
        let (moved, faster) = (
            F * h * h / 2.0 + rate * h.powi(3) / 6.0,
            F * h + rate * h * h / 2.0,
        );
        for (place, expected) in [
            ((0, 0), moved / mass),
            ((1, 0), faster / mass),
            ((0, 1), moved),
            ((1, 1), faster),
        ] {
            let found = shot.forcing[place];
            assert!((found / expected - 1.0).abs() < 1e-12, "{found} {expected}");
        }
    }

    #[test]
    fn a_body_that_friction_stops_ends_where_short_steps_take_it() {
        let (mut q, mut v) = (0.1, 0.15);
        let h = 5e-3 / 100_000.0;
        for _ in 0..100_000 {
            let middle = v + 0.5 * h * acceleration(v);
            q += h * middle;
            v += h * acceleration(middle);
        }
        let shot = shot_from(0.1, 0.15);
        assert!(
            (shot.forcing[(0, 0)] - q).abs() < 2e-6,
            "{} {q}",
            shot.forcing[(0, 0)]
        );
        assert!(
            (shot.forcing[(1, 0)] - v).abs() < 1e-4,
            "{} {v}",
            shot.forcing[(1, 0)]
        );
    }

    #[test]
    fn its_transition_is_the_slope_of_where_it_ends() {
        let shot = shot_from(0.1, 0.15);
        let ends = [1e-4, -1e-4].map(|change| shot_from(0.1, 0.15 + change).forcing);
        let slope = (&ends[0] - &ends[1]) / 2e-4;
        assert!((slope[(0, 0)] - shot.motion[(0, 1)]).abs() < 0.05 * shot.motion[(0, 1)].abs());
        assert!((slope[(1, 0)] - shot.motion[(1, 1)]).abs() < 0.01);
    }
}
