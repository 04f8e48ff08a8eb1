//! Intervals on which the machine is stiff: shot through in short steps.
//!
//! Where dry friction holds a light joint, the acceleration changes within one interval by
//! more than a quadrature along the curve can see, and the curve's own defect says nothing
//! about where the machine would go. There the machine itself is moved from the curve's state
//! at the beginning of the interval to its end, by the exponential Rosenbrock–Euler method
//! (Hochbruck and Ostermann, "Exponential integrators", 2010, section 2.4) with the stiff
//! part `V = ∂a/∂v` in the exponential:
//!
//! ```text
//! q ← q + h v + h² φ₂(hV) a        φ₁(z) = (eᶻ − 1)/z
//! v ← v + h φ₁(hV) a               φ₂(z) = (eᶻ − 1 − z)/z²
//! ```
//!
//! The departure's transition, and what each column adds, go through the same steps.

use super::error_dynamics::{CORRELATION, Local};
use crate::machine::{SolveError, States};
use nalgebra::DMatrix;

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

/// `h ‖∂a/∂v‖` beyond which an interval is stiff, and that of one step.
const STIFF: f64 = 1.0;
/// Steps per interval at most.
const MOST_STEPS: usize = 16;

/// How many steps an interval of `h` seconds needs by what is seen at some of its places;
/// none if it is not stiff.
pub(super) fn steps(places: [&Local; 3], h: f64) -> Option<usize> {
    let rate = |local: &Local| {
        let n = local.slope.nrows();
        local.slope.columns(n, n).amax()
    };
    let stiffness = h * places.into_iter().map(rate).fold(0.0, f64::max);
    (stiffness > STIFF).then(|| {
        let steps = (stiffness / STIFF).min(MOST_STEPS as f64) as usize;
        steps.next_power_of_two().clamp(2, MOST_STEPS)
    })
}

/// Shoots from the curve's states at `from` (one per interval, in columns) over the
/// intervals of `h` seconds each, in `steps` steps. `local(states, share)` is told states some
/// share of the way into the intervals, and says what the machine does there.
///
/// # Errors
/// If the equation of motion has no unique solution on the way.
pub(super) fn shoot(
    from: &States,
    to: &States,
    steps: usize,
    local: impl Fn(&States, f64) -> Result<Vec<Local>, SolveError>,
) -> Result<Vec<Shot>, SolveError> {
    let n = from.q.len();
    let mut now = from.clone();
    let mut shots: Vec<Shot> = Vec::with_capacity(from.len());
    for step in 0..steps {
        let share = step as f64 / steps as f64;
        for (i, local) in local(&now, share)?.iter().enumerate() {
            let h = (to.t[i] - from.t[i]) / steps as f64;
            let force = (-(step as f64) * h / CORRELATION).exp();
            if step == 0 {
                shots.push(Shot {
                    motion: DMatrix::identity(2 * n, 2 * n),
                    pushed: DMatrix::zeros(2 * n, n),
                    forcing: DMatrix::zeros(2 * n, local.acceleration.ncols()),
                });
            }
            let shot = &mut shots[i];
            let short = Short::new(local, h);
            let width = local.acceleration.ncols();
            shot.motion = &short.motion * &shot.motion;
            shot.pushed = &short.motion * &shot.pushed;
            shot.pushed += &short.reach * &local.mobility * force;
            shot.forcing = &short.motion * &shot.forcing;
            let added = &short.reach * &local.acceleration;
            let mut columns = shot.forcing.columns_mut(1, width - 1);
            columns += added.columns(1, width - 1);
            for j in 0..n {
                now.q[j][i] += h * now.v[j][i] + added[(j, 0)];
                now.v[j][i] += added[(n + j, 0)];
            }
        }
    }
    for (i, shot) in shots.iter_mut().enumerate() {
        for j in 0..n {
            shot.forcing[(j, 0)] = now.q[j][i] - to.q[j][i];
            shot.forcing[(n + j, 0)] = now.v[j][i] - to.v[j][i];
        }
    }
    Ok(shots)
}

/// One short step.
struct Short {
    /// `Φ`, `2n×2n`.
    motion: DMatrix<f64>,
    /// What an acceleration adds, `[h² φ₂; h φ₁]`, `2n×n`.
    reach: DMatrix<f64>,
}

impl Short {
    fn new(local: &Local, h: f64) -> Self {
        let n = local.slope.nrows();
        let [phi_0, phi_1, phi_2] = phi(&(local.slope.columns(n, n) * h));
        let mut reach = DMatrix::zeros(2 * n, n);
        reach.rows_mut(0, n).copy_from(&(phi_2 * (h * h)));
        reach.rows_mut(n, n).copy_from(&(&phi_1 * h));
        let mut motion = DMatrix::identity(2 * n, 2 * n);
        motion.view_mut((0, n), (n, n)).copy_from(&(phi_1 * h));
        motion.view_mut((n, n), (n, n)).copy_from(&phi_0);
        let by_position = &reach * local.slope.columns(0, n);
        let mut first = motion.columns_mut(0, n);
        first += by_position;
        Self { motion, reach }
    }
}

/// `φ₀ = exp`, `φ₁` and `φ₂` of a matrix: their series for a part of it, doubled by
/// `φ₂(2z) = (φ₁² + 2 φ₂)/4`, `φ₁(2z) = (φ₀ + 1) φ₁/2`, `φ₀(2z) = φ₀²`.
fn phi(matrix: &DMatrix<f64>) -> [DMatrix<f64>; 3] {
    let n = matrix.nrows();
    let one = DMatrix::<f64>::identity(n, n);
    let size = matrix.amax() * n as f64;
    let doublings = (size / SERIES).log2().ceil().clamp(0.0, MOST_DOUBLINGS) as i32;
    let part = matrix * 0.5_f64.powi(doublings);
    let mut phi_2 = &one / factorial(TERMS + 2);
    for power in (0..TERMS).rev() {
        phi_2 = &part * phi_2 + &one / factorial(power + 2);
    }
    let mut phi_1 = &part * &phi_2 + &one;
    let mut phi_0 = &part * &phi_1 + &one;
    for _ in 0..doublings {
        phi_2 = (&phi_1 * &phi_1 + phi_2 * 2.0) * 0.25;
        phi_1 = (&phi_0 + &one) * phi_1 * 0.5;
        phi_0 = &phi_0 * &phi_0;
    }
    [phi_0, phi_1, phi_2]
}

fn factorial(n: usize) -> f64 {
    (1..=n).map(|k| k as f64).product()
}

/// Size for which the series is summed, its last power, and the most doublings.
const SERIES: f64 = 0.5;
const TERMS: usize = 8;
const MOST_DOUBLINGS: f64 = 40.0;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn phi_functions_are_those_of_the_exponential() {
        let matrix = DMatrix::from_row_slice(2, 2, &[-40.0, 3.0, 1.0, -0.2]);
        let [phi_0, phi_1, phi_2] = phi(&matrix);
        let one = DMatrix::identity(2, 2);
        assert!((&phi_0 - matrix.exp()).amax() < 1e-12);
        assert!((&matrix * &phi_1 - (&phi_0 - &one)).amax() < 1e-12);
        assert!((&matrix * &phi_2 - (&phi_1 - &one)).amax() < 1e-12);
    }
}
