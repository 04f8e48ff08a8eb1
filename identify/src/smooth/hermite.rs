//! The state between two samples.

use super::wiener::HIGHEST;

/// Position, velocity and acceleration at one time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct State {
    /// Position.
    pub q: f64,
    /// Velocity \[per s\].
    pub v: f64,
    /// Acceleration \[per s²\].
    pub a: f64,
}

/// Coefficients of `s³ … s⁵` that bring value, slope and curvature at s = 1
/// from zero to given values, when they vanish at s = 0.
const QUINTIC: [[f64; 3]; 3] = [[10.0, -4.0, 0.5], [-15.0, 7.0, -1.0], [6.0, -3.0, 0.5]];

/// The same with the third derivative, coefficients of `s⁴ … s⁷`.
const SEPTIC: [[f64; 4]; 4] = [
    [35.0, -15.0, 2.5, -1.0 / 6.0],
    [-84.0, 39.0, -7.0, 0.5],
    [70.0, -34.0, 6.5, -0.5],
    [-20.0, 10.0, -2.0, 1.0 / 6.0],
];

/// The same with the fourth derivative, coefficients of `s⁵ … s⁹`.
const NONIC: [[f64; 5]; 5] = [
    [126.0, -56.0, 10.5, -1.0, 1.0 / 24.0],
    [-420.0, 196.0, -38.5, 23.0 / 6.0, -1.0 / 6.0],
    [540.0, -260.0, 53.0, -5.5, 0.25],
    [-315.0, 155.0, -32.5, 3.5, -1.0 / 6.0],
    [70.0, -35.0, 7.5, -5.0 / 6.0, 1.0 / 24.0],
];

/// The mean at `s` in \[0, 1\] of the way of a process whose N-th derivative is
/// white noise, given its state at both ends of a step of `h` seconds: the
/// polynomial of degree 2N-1 through both states.
///
/// The states are (q, v, a, jerk, snap); N of them are used.
pub(super) fn between(
    start: &[f64; HIGHEST],
    end: &[f64; HIGHEST],
    order: usize,
    h: f64,
    s: f64,
) -> State {
    let n = order.clamp(3, HIGHEST);
    // Derivatives with respect to s.
    let scaled = |state: &[f64; HIGHEST]| -> [f64; HIGHEST] {
        std::array::from_fn(|k| state[k] * h.powi(k as i32))
    };
    let (a, b) = (scaled(start), scaled(end));
    let mut polynomial = [0.0; 2 * HIGHEST];
    let mut factorial = 1.0;
    for k in 0..n {
        polynomial[k] = a[k] / factorial;
        factorial *= (k + 1) as f64;
    }
    let taylor = polynomial;
    for j in 0..n {
        let row: &[f64] = match n {
            3 => &QUINTIC[j],
            4 => &SEPTIC[j],
            _ => &NONIC[j],
        };
        let terms = row.iter().enumerate();
        polynomial[n + j] = terms
            .map(|(k, weight)| weight * (b[k] - derivative(&taylor, k, 1.0)))
            .sum();
    }
    State {
        q: derivative(&polynomial, 0, s),
        v: derivative(&polynomial, 1, s) / h,
        a: derivative(&polynomial, 2, s) / (h * h),
    }
}

/// The `k`-th derivative of `Σ c_j sʲ`.
fn derivative(coefficients: &[f64; 2 * HIGHEST], k: usize, s: f64) -> f64 {
    (k..2 * HIGHEST).rev().fold(0.0, |sum, j| {
        let falling: f64 = (j + 1 - k..=j).map(|factor| factor as f64).product();
        sum * s + falling * coefficients[j]
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A polynomial of degree 2N-1 is its own interpolant.
    #[test]
    fn polynomials_are_reproduced() {
        for (order, degree) in [(3, 5), (4, 7), (5, 9)] {
            let mut c = [0.0; 2 * HIGHEST];
            for (j, c) in c.iter_mut().take(degree + 1).enumerate() {
                *c = 0.7 - 0.3 * j as f64;
            }
            let at = |t: f64| std::array::from_fn(|k| derivative(&c, k, t));
            let (t, h) = (0.4, 0.2);
            for s in [0.0, 0.3, 0.5, 1.0] {
                let state = between(&at(t), &at(t + h), order, h, s);
                let time = t + s * h;
                assert!((state.q - derivative(&c, 0, time)).abs() < 1e-12);
                assert!((state.v - derivative(&c, 1, time)).abs() < 1e-11);
                assert!((state.a - derivative(&c, 2, time)).abs() < 1e-9);
            }
        }
    }
}
