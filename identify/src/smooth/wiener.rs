//! The motion model: an integrated Wiener process and its measurements.

use nalgebra::{SMatrix, SVector};

/// Highest order N of the model.
pub(super) const HIGHEST: usize = 5;

/// `1/k`; the entry 0 is never used. Division is the slowest step of a filter
/// that otherwise only multiplies.
const RECIPROCAL: [f64; 2 * HIGHEST] = {
    let mut table = [1.0; 2 * HIGHEST];
    let mut k = 1;
    while k < table.len() {
        table[k] = 1.0 / k as f64;
        k += 1;
    }
    table
};

/// `dᴺq/dtᴺ = w(t)`, white noise of intensity `density`, measured with white
/// noise, in units in which all state variances are of order one.
///
/// The state is `x_k = τᵏ q⁽ᵏ⁾`, k = 0 … N-1, with the time unit `τ` the
/// response time of the filter, `(sd_q² h / density)^(1/2N)`: covariances of
/// derivatives that differ by many orders of magnitude in SI units become
/// comparable, and plain covariance recursions are accurate.
#[derive(Debug, Clone, Copy)]
pub(super) struct Wiener<const N: usize> {
    /// Time unit τ \[s\].
    pub unit: f64,
    /// Intensity in scaled units, `density · τ^(2N-1)`.
    pub intensity: f64,
    /// Variance of the measurement of `x_i`, where there is one.
    pub noise: [Option<f64>; 3],
    /// Variances of the initial state.
    pub prior: SVector<f64, N>,
}

/// Hyper-parameters in SI units.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Hyper {
    /// Intensity of the N-th derivative \[unit²/s^(2N-1)\].
    pub density: f64,
    /// Standard deviations of the measured q, dq, ddq.
    pub sd: [Option<f64>; 3],
    /// Standard deviations of q, v, a, jerk, snap before any measurement.
    pub prior_sd: [f64; HIGHEST],
}

impl Hyper {
    /// Response time of the filter of order n on positions `step` apart,
    /// `(sd_q² step / density)^(1/2n)` \[s\].
    pub fn response(&self, n: usize, step: f64) -> f64 {
        let sd_q = self.sd[0].unwrap_or(1.0);
        (sd_q * sd_q * step / self.density).powf(0.5 / n as f64)
    }

    /// The same of each channel on its own: how far around a sample the i-th derivative is
    /// averaged, `(sd_i² step / density)^(1/2(n−i))` \[s\]; infinite where there is none.
    pub fn responses(&self, n: usize, step: f64) -> [f64; 3] {
        std::array::from_fn(|i| {
            let Some(sd) = self.sd[i] else {
                return f64::INFINITY;
            };
            (sd * sd * step / self.density).powf(0.5 / (n - i) as f64)
        })
    }
}

impl<const N: usize> Wiener<N> {
    /// The model with these hyper-parameters for samples `step` apart, in a
    /// log of `duration` seconds.
    pub fn new(hyper: &Hyper, step: f64, duration: f64) -> Self {
        let unit = hyper.response(N, step).clamp(step, duration.max(step));
        let mut noise = [None; 3];
        for (i, (scaled, sd)) in noise.iter_mut().zip(hyper.sd).enumerate() {
            *scaled = sd.map(|sd| (sd * unit.powi(i as i32)).powi(2));
        }
        Wiener {
            unit,
            intensity: hyper.density * unit.powi(2 * N as i32 - 1),
            noise,
            prior: SVector::from_fn(|k, _| (hyper.prior_sd[k] * unit.powi(k as i32)).powi(2)),
        }
    }

    /// Transition over `step` seconds: `F_ij = δ^(j-i)/(j-i)!`, δ = step/τ.
    pub fn transition(&self, step: f64) -> SMatrix<f64, N, N> {
        let d = step / self.unit;
        let mut terms = [1.0; N];
        for k in 1..N {
            terms[k] = terms[k - 1] * d * RECIPROCAL[k];
        }
        SMatrix::from_fn(|i, j| if j < i { 0.0 } else { terms[j - i] })
    }

    /// Covariance gathered over `step` seconds,
    /// `Q_ij = s δ^(m_i+m_j+1) / (m_i! m_j! (m_i+m_j+1))`, m_i = N-1-i.
    pub fn diffusion(&self, step: f64) -> SMatrix<f64, N, N> {
        let d = step / self.unit;
        // s δ^(m+1/2) / m!, so that products of two give the powers above.
        let mut terms = [(self.intensity * d).sqrt(); N];
        for k in 1..N {
            terms[k] = terms[k - 1] * d * RECIPROCAL[k];
        }
        SMatrix::from_fn(|i, j| {
            let (a, b) = (N - 1 - i, N - 1 - j);
            terms[a] * terms[b] * RECIPROCAL[a + b + 1]
        })
    }

    /// `x ← F x` by Horner's rule, without forming F.
    pub fn advance(&self, x: &SVector<f64, N>, step: f64) -> SVector<f64, N> {
        let d = step / self.unit;
        SVector::from_fn(|i, _| {
            let mut sum = 0.0;
            for j in (i..N).rev() {
                sum = x[j] + sum * d * RECIPROCAL[j - i + 1];
            }
            sum
        })
    }

    /// SI value of a scaled k-th derivative per scaled unit, `τ^-k`.
    pub fn si(&self, k: usize) -> f64 {
        self.unit.powi(-(k as i32))
    }
}
