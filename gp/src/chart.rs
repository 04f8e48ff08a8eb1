//! Parametrisations of physical parameters that cannot leave what is possible.

use crate::error::{GpError, Result, finite, shape};
use serde::{Deserialize, Serialize};

/// Map from unconstrained numbers `φ` to some consecutive model parameters `θ`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Chart {
    /// `θ = φ` (bounds, if any, are kept by the optimiser).
    Free,
    /// `θ = e^φ > 0`.
    Positive,
    /// `θ = lower + (upper - lower)/(1 + e^{-φ})`.
    Interval {
        /// Lower end, never reached.
        lower: f64,
        /// Upper end, never reached.
        upper: f64,
    },
    /// Ten inertial parameters of a body,
    /// `θ = (m, h_x, h_y, h_z, I_xx, I_xy, I_xz, I_yy, I_yz, I_zz)` with `h = m c` and
    /// `I` about the link origin, from the log-Cholesky factor of the pseudo-inertia
    /// `J = [[½ tr(I) 1 - I, h], [h^T, m]] = U U^T`, `U` upper triangular with
    /// diagonal `e^{φ_0..3}` (Rucker and Wensing 2022). Every `φ` gives a
    /// positive mass and a physically possible inertia.
    Inertia,
}

/// Places of `φ_4..10` in the upper factor.
const OFF: [(usize, usize); 6] = [(0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3)];

impl Chart {
    /// How many parameters it maps.
    pub fn len(self) -> usize {
        if self == Self::Inertia { 10 } else { 1 }
    }

    /// Never: every chart maps at least one parameter.
    pub fn is_empty(self) -> bool {
        false
    }

    /// `θ(φ)`; the caller hands over [`Chart::len`] numbers.
    fn forward(self, phi: &[f64], theta: &mut Vec<f64>) {
        match self {
            Self::Free => theta.push(phi[0]),
            Self::Positive => theta.push(phi[0].exp()),
            Self::Interval { lower, upper } => {
                theta.push(lower + (upper - lower) * logistic(phi[0]))
            }
            Self::Inertia => theta.extend(inertia(&gram(&factor(phi)))),
        }
    }

    /// `φ(θ)` of [`Chart::len`] numbers. Errors: a value outside what the chart can express.
    fn inverse(self, theta: &[f64], phi: &mut Vec<f64>) -> Result<()> {
        let outside = |value: f64, expected: &str| GpError::Parameter {
            name: "theta".into(),
            value,
            expected: expected.into(),
        };
        let v = theta[0];
        match self {
            Self::Free => phi.push(v),
            Self::Positive if v > 0.0 => phi.push(v.ln()),
            Self::Positive => return Err(outside(v, "a positive number")),
            Self::Interval { lower, upper }
                if lower < v && v < upper && (upper - lower).is_finite() =>
            {
                phi.push(((v - lower) / (upper - v)).ln());
            }
            Self::Interval { lower, upper } => {
                let inside = format!("a number inside the finite interval ({lower}, {upper})");
                return Err(outside(v, &inside));
            }
            Self::Inertia => phi.extend(log_cholesky(&pseudo(theta)).ok_or_else(|| {
                outside(
                    v,
                    "a positive mass and an inertia that a body of positive density can have",
                )
            })?),
        }
        Ok(())
    }

    /// `out = (∂θ/∂φ)^T g`.
    fn pull_back(self, phi: &[f64], g: &[f64], out: &mut Vec<f64>) {
        match self {
            Self::Free => out.push(g[0]),
            Self::Positive => out.push(g[0] * phi[0].exp()),
            Self::Interval { lower, upper } => {
                let s = logistic(phi[0]);
                out.push(g[0] * (upper - lower) * s * (1.0 - s));
            }
            Self::Inertia => {
                for k in 0..10 {
                    let (u, du) = (factor(phi), factor_tangent(phi, k));
                    let mut dj = [[0.0; 4]; 4];
                    for (i, j) in (0..16).map(|e| (e / 4, e % 4)) {
                        dj[i][j] = (0..4)
                            .map(|l| du[i][l] * u[j][l] + u[i][l] * du[j][l])
                            .sum();
                    }
                    out.push(inertia(&dj).iter().zip(g).map(|(d, g)| d * g).sum());
                }
            }
        }
    }
}

fn logistic(x: f64) -> f64 {
    1.0 / (1.0 + (-x).exp())
}

type M4 = [[f64; 4]; 4];

fn factor(phi: &[f64]) -> M4 {
    let mut u = [[0.0; 4]; 4];
    for i in 0..4 {
        u[i][i] = phi[i].exp();
    }
    for (k, (i, j)) in OFF.into_iter().enumerate() {
        u[i][j] = phi[4 + k];
    }
    u
}

fn factor_tangent(phi: &[f64], k: usize) -> M4 {
    let mut u = [[0.0; 4]; 4];
    if k < 4 {
        u[k][k] = phi[k].exp();
    } else {
        let (i, j) = OFF[k - 4];
        u[i][j] = 1.0;
    }
    u
}

fn gram(u: &M4) -> M4 {
    let mut j = [[0.0; 4]; 4];
    for (r, c) in (0..16).map(|e| (e / 4, e % 4)) {
        j[r][c] = (0..4).map(|l| u[r][l] * u[c][l]).sum();
    }
    j
}

/// `(m, h, I)` of a pseudo-inertia; linear in `J`. `I = tr(S) 1 - S` with `S` its 3×3 block.
fn inertia(j: &M4) -> [f64; 10] {
    let t = j[0][0] + j[1][1] + j[2][2];
    [
        j[3][3],
        j[0][3],
        j[1][3],
        j[2][3],
        t - j[0][0],
        -j[0][1],
        -j[0][2],
        t - j[1][1],
        -j[1][2],
        t - j[2][2],
    ]
}

fn pseudo(theta: &[f64]) -> M4 {
    let half = 0.5 * (theta[4] + theta[7] + theta[9]);
    [
        [half - theta[4], -theta[5], -theta[6], theta[1]],
        [-theta[5], half - theta[7], -theta[8], theta[2]],
        [-theta[6], -theta[8], half - theta[9], theta[3]],
        [theta[1], theta[2], theta[3], theta[0]],
    ]
}

/// `J = U U^T` from the last row upwards; `None` when `J` is not positive definite.
fn log_cholesky(j: &M4) -> Option<Vec<f64>> {
    let mut u = [[0.0; 4]; 4];
    for c in (0..4).rev() {
        let d = j[c][c] - (c + 1..4).map(|l| u[c][l] * u[c][l]).sum::<f64>();
        if d.is_nan() || d <= 0.0 {
            return None;
        }
        u[c][c] = d.sqrt();
        for r in 0..c {
            u[r][c] = (j[r][c] - (c + 1..4).map(|l| u[r][l] * u[c][l]).sum::<f64>()) / u[c][c];
        }
    }
    let mut out: Vec<f64> = (0..4).map(|i| u[i][i].ln()).collect();
    out.extend(OFF.map(|(i, j)| u[i][j]));
    Some(out)
}

/// Charts of all model parameters, in order.
#[derive(Clone, Debug, PartialEq, Default, Serialize, Deserialize)]
pub struct Atlas {
    charts: Vec<Chart>,
}

impl Atlas {
    /// One chart after the other; their lengths must add up to `n_theta`.
    pub fn new(charts: Vec<Chart>, n_theta: usize) -> Result<Self> {
        let total: usize = charts.iter().map(|c| c.len()).sum();
        if total != n_theta {
            return Err(shape("parameters of the charts", n_theta, total));
        }
        Ok(Self { charts })
    }

    /// `θ = φ`.
    pub fn free(n_theta: usize) -> Self {
        Self {
            charts: vec![Chart::Free; n_theta],
        }
    }

    /// Number of model parameters.
    pub fn n_theta(&self) -> usize {
        self.charts.iter().map(|c| c.len()).sum()
    }

    fn sized(&self, what: &str, values: &[f64]) -> Result<()> {
        if values.len() == self.n_theta() {
            return Ok(());
        }
        Err(shape(what, self.n_theta(), values.len()))
    }

    /// `θ(φ)`. Errors: shape, a `φ` so large that `θ` is not finite.
    pub fn forward(&self, phi: &[f64]) -> Result<Vec<f64>> {
        self.sized("coordinates φ of the model parameters", phi)?;
        let (mut theta, mut at) = (Vec::with_capacity(phi.len()), 0);
        for c in &self.charts {
            c.forward(&phi[at..at + c.len()], &mut theta);
            at += c.len();
        }
        finite("model parameters θ", &theta)?;
        Ok(theta)
    }

    /// `φ(θ)`. Errors: shape, a value the chart cannot express.
    pub fn inverse(&self, theta: &[f64]) -> Result<Vec<f64>> {
        self.sized("model parameters θ", theta)?;
        finite("model parameters θ", theta)?;
        let (mut phi, mut at) = (Vec::with_capacity(theta.len()), 0);
        for c in &self.charts {
            c.inverse(&theta[at..at + c.len()], &mut phi)?;
            at += c.len();
        }
        Ok(phi)
    }

    /// `(∂θ/∂φ)^T g`. Errors: shape.
    pub fn pull_back(&self, phi: &[f64], g: &[f64]) -> Result<Vec<f64>> {
        self.sized("coordinates φ of the model parameters", phi)?;
        self.sized("gradient in the model parameters θ", g)?;
        let (mut out, mut at) = (Vec::with_capacity(phi.len()), 0);
        for c in &self.charts {
            let r = at..at + c.len();
            c.pull_back(&phi[r.clone()], &g[r], &mut out);
            at += c.len();
        }
        Ok(out)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn inertia_round_trips_and_its_gradient_is_exact() {
        // A solid box of mass 2, sides 0.1, 0.2, 0.3, centre at (0.01, -0.02, 0.05).
        let (m, c, s) = (2.0, [0.01, -0.02, 0.05], [0.1, 0.2, 0.3]);
        let own = |i: usize, j: usize| m / 12.0 * (s[i] * s[i] + s[j] * s[j]);
        let theta = [
            m,
            m * c[0],
            m * c[1],
            m * c[2],
            own(1, 2) + m * (c[1] * c[1] + c[2] * c[2]),
            -m * c[0] * c[1],
            -m * c[0] * c[2],
            own(0, 2) + m * (c[0] * c[0] + c[2] * c[2]),
            -m * c[1] * c[2],
            own(0, 1) + m * (c[0] * c[0] + c[1] * c[1]),
        ];
        let atlas = Atlas::new(
            vec![
                Chart::Inertia,
                Chart::Positive,
                Chart::Interval {
                    lower: -1.0,
                    upper: 2.0,
                },
            ],
            12,
        )
        .unwrap();
        let all = [&theta[..], &[0.3, 1.5]].concat();
        let phi = atlas.inverse(&all).unwrap();
        for (a, b) in atlas.forward(&phi).unwrap().iter().zip(&all) {
            assert!((a - b).abs() < 1e-14, "{a} {b}");
        }
        let g: Vec<f64> = (0..12).map(|i| (i as f64 * 1.3).cos()).collect();
        let pulled = atlas.pull_back(&phi, &g).unwrap();
        for k in 0..12 {
            let at = |h: f64| {
                let mut p = phi.clone();
                p[k] += h;
                atlas
                    .forward(&p)
                    .unwrap()
                    .iter()
                    .zip(&g)
                    .map(|(t, g)| t * g)
                    .sum::<f64>()
            };
            let numeric = (at(1e-6) - at(-1e-6)) / 2e-6;
            assert!(
                (pulled[k] - numeric).abs() < 1e-8 * (1.0 + numeric.abs()),
                "{k}: {} {numeric}",
                pulled[k]
            );
        }
    }

    #[test]
    fn impossible_bodies_are_refused() {
        let mut theta = [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 0.0, 5.0];
        assert!(
            Chart::Inertia.inverse(&theta, &mut Vec::new()).is_err(),
            "triangle inequality"
        );
        theta[0] = -1.0;
        assert!(
            Chart::Inertia.inverse(&theta, &mut Vec::new()).is_err(),
            "negative mass"
        );
        assert!(Chart::Positive.inverse(&[0.0], &mut Vec::new()).is_err());
        assert!(
            Chart::Interval {
                lower: 0.0,
                upper: 1.0
            }
            .inverse(&[1.0], &mut Vec::new())
            .is_err()
        );
    }
}
