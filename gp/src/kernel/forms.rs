//! The leaves of the kernel algebra: values and log-scale gradients.

use crate::simd::{TILE, axpy, dispatch, exp, sum, weighted_square};

/// A leaf kernel with its parameters in natural scale.
pub(crate) enum Form {
    SquaredExponential {
        inverse_lengths: Vec<f64>,
        variance: f64,
    },
    Matern32 {
        inverse_lengths: Vec<f64>,
        variance: f64,
    },
    Matern52 {
        inverse_lengths: Vec<f64>,
        variance: f64,
    },
    Linear {
        variances: Vec<f64>,
    },
    Bias {
        variance: f64,
    },
    White {
        variance: f64,
    },
    Periodic {
        frequencies: Vec<f64>,
        inverse_lengths: Vec<f64>,
        variance: f64,
    },
}

/// A leaf with the columns of inputs it reads and the place of its parameters.
pub(crate) struct Leaf<'a> {
    pub(super) form: Form,
    pub(super) rows: Vec<&'a [f64]>,
    pub(super) cols: Vec<&'a [f64]>,
    pub(super) at: usize,
}

const SQRT_3: f64 = 1.732_050_807_568_877_2;
const SQRT_5: f64 = 2.236_067_977_499_79;

/// `exp(-r)` is 0 from here on, whatever it is multiplied by; without the cap the
/// product with an overflowed `r` would be NaN.
#[inline(always)]
fn far(r: f64) -> f64 {
    const FAR: f64 = 1e3;
    if r > FAR { FAR } else { r }
}

impl Leaf<'_> {
    /// `out[i] = Σ_d ((x_d - z_d)/l_d)²`.
    #[inline(always)]
    fn squared_distance(&self, inverse_lengths: &[f64], col: usize, start: usize, out: &mut [f64]) {
        out.fill(0.0);
        for ((rows, cols), s) in self.rows.iter().zip(&self.cols).zip(inverse_lengths) {
            let c = cols[col];
            for (o, x) in out.iter_mut().zip(&rows[start..]) {
                let t = (x - c) * s;
                *o += t * t;
            }
        }
    }

    /// See [`super::Bound::values`].
    pub(super) fn values(&self, col: usize, start: usize, out: &mut [f64]) {
        match &self.form {
            Form::SquaredExponential {
                inverse_lengths,
                variance,
            } => dispatch(|| {
                self.squared_distance(inverse_lengths, col, start, out);
                out.iter_mut().for_each(|o| *o = variance * exp(-0.5 * *o));
            }),
            Form::Matern32 {
                inverse_lengths,
                variance,
            } => dispatch(|| {
                self.squared_distance(inverse_lengths, col, start, out);
                for o in out.iter_mut() {
                    let r = far(SQRT_3 * o.sqrt());
                    *o = variance * (1.0 + r) * exp(-r);
                }
            }),
            Form::Matern52 {
                inverse_lengths,
                variance,
            } => dispatch(|| {
                self.squared_distance(inverse_lengths, col, start, out);
                for o in out.iter_mut() {
                    let r = far(SQRT_5 * o.sqrt());
                    *o = variance * (1.0 + r + r * r / 3.0) * exp(-r);
                }
            }),
            Form::Linear { variances } => dispatch(|| {
                out.fill(0.0);
                for ((rows, cols), v) in self.rows.iter().zip(&self.cols).zip(variances) {
                    axpy(v * cols[col], &rows[start..], out);
                }
            }),
            Form::Bias { variance } => out.fill(*variance),
            Form::White { variance } => {
                for (i, o) in out.iter_mut().enumerate() {
                    let equal = self
                        .rows
                        .iter()
                        .zip(&self.cols)
                        .all(|(r, c)| r[start + i] == c[col]);
                    *o = if equal { *variance } else { 0.0 };
                }
            }
            Form::Periodic {
                frequencies,
                inverse_lengths,
                variance,
            } => {
                out.fill(0.0);
                for (d, (rows, cols)) in self.rows.iter().zip(&self.cols).enumerate() {
                    for (o, x) in out.iter_mut().zip(&rows[start..]) {
                        let s = ((x - cols[col]) * frequencies[d]).sin() * inverse_lengths[d];
                        *o += s * s;
                    }
                }
                dispatch(|| out.iter_mut().for_each(|o| *o = variance * exp(-2.0 * *o)));
            }
        }
    }

    /// See [`super::Bound::accumulate`].
    pub(super) fn accumulate(&self, col: usize, start: usize, w: &[f64], grad: &mut [f64]) {
        match &self.form {
            Form::SquaredExponential {
                inverse_lengths,
                variance,
            } => {
                self.stationary(inverse_lengths, *variance, col, start, w, grad, |r2| {
                    let e = exp(-0.5 * r2);
                    (e, e)
                });
            }
            Form::Matern32 {
                inverse_lengths,
                variance,
            } => {
                self.stationary(inverse_lengths, *variance, col, start, w, grad, |r2| {
                    let r = far(SQRT_3 * r2.sqrt());
                    let e = exp(-r);
                    ((1.0 + r) * e, 3.0 * e)
                });
            }
            Form::Matern52 {
                inverse_lengths,
                variance,
            } => {
                self.stationary(inverse_lengths, *variance, col, start, w, grad, |r2| {
                    let r = far(SQRT_5 * r2.sqrt());
                    let e = exp(-r);
                    ((1.0 + r + r * r / 3.0) * e, 5.0 / 3.0 * (1.0 + r) * e)
                });
            }
            Form::Linear { variances } => {
                for (d, (rows, cols)) in self.rows.iter().zip(&self.cols).enumerate() {
                    let c = variances[d] * cols[col];
                    grad[self.at + d] += c * dispatch(|| crate::simd::dot(w, &rows[start..]));
                }
            }
            Form::Bias { variance } => grad[self.at] += variance * dispatch(|| sum(w)),
            Form::White { .. } => {
                let mut tile = [0.0; TILE];
                self.values(col, start, &mut tile[..w.len()]);
                grad[self.at] += crate::simd::dot(w, &tile);
            }
            Form::Periodic {
                frequencies,
                inverse_lengths,
                ..
            } => {
                self.periodic(frequencies, inverse_lengths, col, start, w, grad);
            }
        }
    }

    /// Stationary kernels: `parts(r²) = (k/σ², g)` with `∂k/∂ln l_d = σ² g t_d²`,
    /// `t_d = (x_d - z_d)/l_d`.
    #[inline(always)]
    #[allow(clippy::too_many_arguments)]
    fn stationary(
        &self,
        inverse_lengths: &[f64],
        variance: f64,
        col: usize,
        start: usize,
        w: &[f64],
        grad: &mut [f64],
        parts: impl Fn(f64) -> (f64, f64),
    ) {
        dispatch(|| {
            let (mut s, mut k) = ([0.0; TILE], [0.0; TILE]);
            let (s, k) = (&mut s[..w.len()], &mut k[..w.len()]);
            self.squared_distance(inverse_lengths, col, start, s);
            for ((s, k), w) in s.iter_mut().zip(&mut *k).zip(w) {
                let (value, slope) = parts(*s);
                *k = w * variance * value;
                *s = w * variance * slope;
            }
            for (d, (rows, cols)) in self.rows.iter().zip(&self.cols).enumerate() {
                grad[self.at + d] +=
                    weighted_square(s, &rows[start..], cols[col], inverse_lengths[d]);
            }
            grad[self.at + self.rows.len()] += sum(k);
        });
    }

    /// With `u = π Δ/p`: `∂k/∂ln p = k (4/l²) u sin u cos u`, `∂k/∂ln l = k (4/l²) sin² u`.
    fn periodic(
        &self,
        frequencies: &[f64],
        inverse_lengths: &[f64],
        col: usize,
        start: usize,
        w: &[f64],
        grad: &mut [f64],
    ) {
        let mut k = [0.0; TILE];
        let k = &mut k[..w.len()];
        self.values(col, start, k);
        k.iter_mut().zip(w).for_each(|(k, w)| *k *= w);
        let n = self.rows.len();
        for (d, (rows, cols)) in self.rows.iter().zip(&self.cols).enumerate() {
            let f = 4.0 * inverse_lengths[d] * inverse_lengths[d];
            for (k, x) in k.iter().zip(&rows[start..]) {
                let u = (x - cols[col]) * frequencies[d];
                let (sin, cos) = u.sin_cos();
                grad[self.at + d] += k * f * u * sin * cos;
                grad[self.at + n + d] += k * f * sin * sin;
            }
        }
        grad[self.at + 2 * n] += sum(k);
    }
}
