//! The state between two samples.

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

/// The mean at `s` in \[0, 1\] of the way of a process whose N-th derivative is
/// white noise, given its state at both ends of a step of `h` seconds: the
/// polynomial of degree 2N-1 through both states.
///
/// `start` and `end` are (q, v, a) or (q, v, a, jerk): N = 3 or 4, the shorter
/// of the two.
pub(super) fn between(start: &[f64], end: &[f64], h: f64, s: f64) -> State {
    let order = if start.len() >= 4 && end.len() >= 4 {
        4
    } else {
        3
    };
    // Derivatives with respect to s.
    let scaled = |state: &[f64]| -> [f64; 4] {
        std::array::from_fn(|k| state.get(k).map_or(0.0, |x| x * h.powi(k as i32)))
    };
    let (a, b) = (scaled(start), scaled(end));
    let mut polynomial = [0.0; 8];
    let mut factorial = 1.0;
    for k in 0..order {
        polynomial[k] = a[k] / factorial;
        factorial *= (k + 1) as f64;
    }
    let taylor = polynomial;
    let remainder: [f64; 4] = std::array::from_fn(|k| b[k] - derivative(&taylor, k, 1.0));
    for j in 0..order {
        polynomial[order + j] = (0..order)
            .map(|k| {
                remainder[k]
                    * if order == 3 {
                        QUINTIC[j][k]
                    } else {
                        SEPTIC[j][k]
                    }
            })
            .sum();
    }
    State {
        q: derivative(&polynomial, 0, s),
        v: derivative(&polynomial, 1, s) / h,
        a: derivative(&polynomial, 2, s) / (h * h),
    }
}

/// The `k`-th derivative of `Σ c_j sʲ`.
fn derivative(coefficients: &[f64; 8], k: usize, s: f64) -> f64 {
    (k..8).rev().fold(0.0, |sum, j| {
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
        for (order, degree) in [(3, 5), (4, 7)] {
            let mut c = [0.0; 8];
            for (j, c) in c.iter_mut().take(degree + 1).enumerate() {
                *c = 0.7 - 0.3 * j as f64;
            }
            let at = |t: f64| -> Vec<f64> { (0..order).map(|k| derivative(&c, k, t)).collect() };
            let (t, h) = (0.4, 0.2);
            for s in [0.0, 0.3, 0.5, 1.0] {
                let state = between(&at(t), &at(t + h), h, s);
                let time = t + s * h;
                assert!((state.q - derivative(&c, 0, time)).abs() < 1e-12);
                assert!((state.v - derivative(&c, 1, time)).abs() < 1e-11);
                assert!((state.a - derivative(&c, 2, time)).abs() < 1e-9);
            }
        }
    }
}
