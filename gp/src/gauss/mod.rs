//! Gauss' principle at one point: from `M, A, b` to the linear maps of every
//! quantity of constrained dynamics.
//!
//! With `G = A M⁻¹ A^T`, `Γ = G⁺`, `L = M⁻¹ A^T Γ` and
//! `P = M⁻¹ - M⁻¹ A^T Γ A M⁻¹` (thesis 3.38–3.43), the constrained acceleration
//! is `a = L b + P Q̄`, the multipliers `λ = Γ b - L^T Q̄`, `Q_I = +A^T λ`. No
//! robot in here: the matrices come from generated code, a tape, or a hand.

mod inverse;

use self::inverse::{consistent, pseudo_inverse, singular_mass, stiffened};
use crate::error::{GpError, Result, finite, shape};
use crate::model::Tangent;
use faer::linalg::solvers::Solve;
use faer::{Mat, Side};

/// Eigenvalues of `G` below this fraction of the largest count as zero.
pub const RANK_TOLERANCE: f64 = 1e-12;

/// `b` may leave the range of `A` by this fraction of `1 + |b|`.
pub const CONSISTENCY_TOLERANCE: f64 = 1e-8;

/// A quantity of the dynamics that can be measured or predicted (thesis 5.11).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Quantity {
    /// Constrained acceleration `a`, `n` rows.
    Acceleration,
    /// Acceleration `M⁻¹ Q̄` the system would have without constraint, `n` rows.
    UnconstrainedAcceleration,
    /// Multipliers `λ` with `Q_I = A^T λ`, `m` rows.
    Multiplier,
    /// Ideal constraint force `Q_I = A^T λ`, `n` rows.
    ConstraintForce,
    /// All other generalised forces, `Q̄ = Q + Q_z`, `n` rows.
    TotalForce,
    /// `Q` alone; only with [`Layout::SplitForce`].
    Force,
    /// Non-ideal constraint force `Q_z` alone; only with [`Layout::SplitForce`].
    NonIdealForce,
}

/// What the latent functions stand for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Layout {
    /// `Q̄ = Q_K + f`, `n` latent forces (thesis 5.6).
    Force,
    /// `Q = Q_K + f_1`, `Q_z = f_2`, `2n` latent forces (thesis 5.7).
    SplitForce,
    /// `ā = M⁻¹ Q_K + f`, `n` latent accelerations (thesis 5.14).
    Acceleration,
    /// As [`Layout::Force`], and `n` more latent functions added to `a` alone:
    /// what no force inside the model can express (`k_A` of thesis 5.6). These
    /// need not obey the constraint.
    ForceAndOutput,
}

impl Layout {
    /// Number of latent functions for `n` coordinates.
    pub fn n_latent(self, n: usize) -> usize {
        match self {
            Self::Force | Self::Acceleration => n,
            Self::SplitForce | Self::ForceAndOutput => 2 * n,
        }
    }
}

/// Rows of `H` (row-major) and means of one quantity at one point.
#[derive(Clone, Debug, PartialEq)]
pub struct Rows {
    /// `H`, rows × latent functions, row-major.
    pub h: Vec<f64>,
    /// `m`, one per row.
    pub mean: Vec<f64>,
}

/// Derivatives of what defines a point in one model parameter.
#[derive(Clone, Debug, PartialEq)]
pub struct PointTangent {
    /// `∂M`, `n × n`.
    pub mass: Mat<f64>,
    /// `∂A`, `m × n`.
    pub a: Mat<f64>,
    /// `∂b`, length `m`.
    pub b: Vec<f64>,
    /// `∂Q_K`, length `n`.
    pub known: Vec<f64>,
}

impl PointTangent {
    /// All derivatives zero.
    pub fn zero(n: usize, m: usize) -> Self {
        Self {
            mass: Mat::zeros(n, n),
            a: Mat::zeros(m, n),
            b: vec![0.0; m],
            known: vec![0.0; n],
        }
    }
}

/// Constrained dynamics at one state: all maps of thesis 3.38–3.43.
///
/// ```
/// use faer::mat;
/// use gp::{GaussPoint, Layout, Quantity};
/// // A unit mass in the plane that may only move along x = y.
/// let p = GaussPoint::new(&mat![[1.0, 0.0], [0.0, 1.0]], &mat![[1.0, -1.0]], &[0.0], &[2.0, 0.0])?;
/// let a = p.rows(Quantity::Acceleration, Layout::Force)?;
/// assert!((a.mean[0] - 1.0).abs() < 1e-14 && (a.mean[1] - 1.0).abs() < 1e-14);
/// # Ok::<(), gp::GpError>(())
/// ```
#[derive(Clone, Debug)]
pub struct GaussPoint {
    mass: Mat<f64>,
    a: Mat<f64>,
    b: Mat<f64>,
    known: Mat<f64>,
    p: Mat<f64>,
    l: Mat<f64>,
    gamma: Mat<f64>,
    mass_inv: Option<Mat<f64>>,
    full_rank: bool,
}

fn column(v: &[f64]) -> Mat<f64> {
    Mat::from_fn(v.len(), 1, |i, _| v[i])
}

fn entries(m: &Mat<f64>) -> Vec<f64> {
    (0..m.nrows())
        .flat_map(|i| (0..m.ncols()).map(move |j| (i, j)))
        .map(|(i, j)| m[(i, j)])
        .collect()
}

fn beside(left: Mat<f64>, right: &Mat<f64>) -> Mat<f64> {
    let n = left.ncols();
    Mat::from_fn(left.nrows(), n + right.ncols(), |i, j| {
        if j < n {
            left[(i, j)]
        } else {
            right[(i, j - n)]
        }
    })
}

impl GaussPoint {
    /// From `M` (`n × n`, symmetric, positive definite or singular with
    /// `rank [M; A] = n`), `A` (`m × n`, `m = 0` allowed, rows may repeat),
    /// `b` (length `m`) and the known force `Q_K` (length `n`).
    ///
    /// Rank of `A` is judged by [`RANK_TOLERANCE`]. A singular `M` is replaced
    /// by `M + s A^T A` (thesis 3.49–3.54), `s = tr M / tr A^T A`. Errors:
    /// shapes, NaN, `b` outside the range of `A`, both matrices singular.
    pub fn new(mass: &Mat<f64>, a: &Mat<f64>, b: &[f64], known: &[f64]) -> Result<Self> {
        let (n, m) = (known.len(), b.len());
        if (mass.nrows(), mass.ncols()) != (n, n) || (a.nrows(), a.ncols()) != (m, n) {
            return Err(shape(
                "M and A",
                format!("{n} × {n} and {m} × {n}"),
                format!(
                    "{} × {} and {} × {}",
                    mass.nrows(),
                    mass.ncols(),
                    a.nrows(),
                    a.ncols()
                ),
            ));
        }
        for (what, values) in [
            ("M", entries(mass)),
            ("A", entries(a)),
            ("b", b.to_vec()),
            ("Q_K", known.to_vec()),
        ] {
            finite(what, &values)?;
        }
        let eye = Mat::<f64>::identity(n, n);
        let mass_inv = mass.llt(Side::Lower).ok().map(|c| c.solve(&eye));
        let (inverse, shift) = match &mass_inv {
            Some(inverse) => (inverse.clone(), 0.0),
            None => stiffened(mass, a)?,
        };
        let at = a.transpose().to_owned();
        let g = a * &inverse * &at;
        let (gamma, rank) = pseudo_inverse(&g)?;
        let b = column(b);
        consistent(&g, &gamma, &b)?;
        let l = &inverse * &at * &gamma;
        let p = &inverse - &l * a * &inverse;
        let gamma = if shift == 0.0 {
            gamma
        } else {
            gamma - Mat::<f64>::identity(m, m) * faer::Scale(shift)
        };
        Ok(Self {
            mass: mass.clone(),
            a: a.clone(),
            b,
            known: column(known),
            p,
            l,
            gamma,
            mass_inv,
            full_rank: rank == m && shift == 0.0,
        })
    }

    /// `P`, `n × n`, with `A P = 0`.
    pub fn p(&self) -> &Mat<f64> {
        &self.p
    }

    /// `L`, `n × m`.
    pub fn l(&self) -> &Mat<f64> {
        &self.l
    }

    /// `H` and `m` of a quantity. Errors: the unconstrained acceleration of a
    /// singular `M`; `Q` or `Q_z` without a split prior.
    pub fn rows(&self, quantity: Quantity, layout: Layout) -> Result<Rows> {
        let (s, offset) = self.map(quantity)?;
        let mean = offset + &s * &self.known * faer::Scale(self.known_share(quantity));
        let h = self.over_latents(&s, quantity, layout)?;
        Ok(Rows {
            h: entries(&h),
            mean: entries(&mean),
        })
    }

    /// Derivative of [`GaussPoint::rows`] in one model parameter.
    ///
    /// Errors: as there, and redundant constraints or a singular `M`, where
    /// the maps are not differentiable in general.
    pub fn tangent(&self, d: &PointTangent, quantity: Quantity, layout: Layout) -> Result<Tangent> {
        if !self.full_rank {
            return Err(GpError::Singular {
                what: "A M⁻¹ A^T".into(),
                mend: "derivatives in model parameters need independent constraint rows and an invertible M; drop the redundant rows".into(),
            });
        }
        let (n, m) = (self.mass.nrows(), self.a.nrows());
        let sizes = |m: &Mat<f64>| (m.nrows(), m.ncols());
        let found = (sizes(&d.mass), sizes(&d.a), d.b.len(), d.known.len());
        if found != ((n, n), (m, n), m, n) {
            return Err(shape(
                "tangents of M, A, b, Q_K",
                format!("{:?}", ((n, n), (m, n), m, n)),
                format!("{found:?}"),
            ));
        }
        let (s, _) = self.map(quantity)?;
        let (ds, doffset) = self.map_tangent(d, quantity)?;
        let share = faer::Scale(self.known_share(quantity));
        let mean = doffset + (&ds * &self.known + &s * column(&d.known)) * share;
        let mut h = self.over_latents(&ds, quantity, layout)?;
        if layout == Layout::Acceleration {
            h += &s * &d.mass;
        }
        if layout == Layout::ForceAndOutput && quantity == Quantity::Acceleration {
            h = beside(ds, &Mat::zeros(n, n));
        }
        Ok(Tangent {
            rows: entries(&h),
            mean: entries(&mean),
        })
    }

    /// `Q_z` alone has no known part; everything else sees all of `Q_K`.
    fn known_share(&self, quantity: Quantity) -> f64 {
        if quantity == Quantity::NonIdealForce {
            0.0
        } else {
            1.0
        }
    }

    /// `s = S Q̄ + offset`: the map of a quantity from all forces but `Q_I`.
    fn map(&self, quantity: Quantity) -> Result<(Mat<f64>, Mat<f64>)> {
        let n = self.mass.nrows();
        let eye = || Mat::<f64>::identity(n, n);
        let none = || Mat::<f64>::zeros(n, 1);
        let multiplier = || (-self.l.transpose().to_owned(), &self.gamma * &self.b);
        Ok(match quantity {
            Quantity::Acceleration => (self.p.clone(), &self.l * &self.b),
            Quantity::UnconstrainedAcceleration => {
                (self.mass_inv.clone().ok_or_else(singular_mass)?, none())
            }
            Quantity::Multiplier => multiplier(),
            Quantity::ConstraintForce => {
                let (s, offset) = multiplier();
                (self.a.transpose() * s, self.a.transpose() * offset)
            }
            Quantity::TotalForce | Quantity::Force | Quantity::NonIdealForce => (eye(), none()),
        })
    }

    /// Derivatives of [`GaussPoint::map`], from `∂K⁻¹ = -K⁻¹ ∂K K⁻¹` with
    /// `K = [[M, A^T], [A, 0]]`, `K⁻¹ = [[P, L], [L^T, -Γ]]`.
    fn map_tangent(&self, d: &PointTangent, quantity: Quantity) -> Result<(Mat<f64>, Mat<f64>)> {
        let n = self.mass.nrows();
        let (p, l, gamma) = (&self.p, &self.l, &self.gamma);
        let db = column(&d.b);
        let dat = d.a.transpose();
        let dl = || p * dat * gamma - p * &d.mass * l - l * &d.a * l;
        let multiplier = || {
            let turn = gamma * &d.a * l;
            let dgamma = l.transpose() * &d.mass * l - &turn - turn.transpose();
            (-dl().transpose().to_owned(), dgamma * &self.b + gamma * &db)
        };
        Ok(match quantity {
            Quantity::Acceleration => {
                let turn = l * &d.a * p;
                let dp = -(p * &d.mass * p) - &turn - turn.transpose();
                (dp, dl() * &self.b + l * &db)
            }
            Quantity::UnconstrainedAcceleration => {
                let inverse = self.mass_inv.as_ref().ok_or_else(singular_mass)?;
                (-(inverse * &d.mass * inverse), Mat::zeros(n, 1))
            }
            Quantity::Multiplier => multiplier(),
            Quantity::ConstraintForce => {
                let (s, offset) = self.map(Quantity::Multiplier)?;
                let (ds, doffset) = multiplier();
                (
                    dat * s + self.a.transpose() * ds,
                    dat * offset + self.a.transpose() * doffset,
                )
            }
            Quantity::TotalForce | Quantity::Force | Quantity::NonIdealForce => {
                (Mat::zeros(n, n), Mat::zeros(n, 1))
            }
        })
    }

    /// `S` applied to how the latent functions enter `Q̄`.
    fn over_latents(&self, s: &Mat<f64>, quantity: Quantity, layout: Layout) -> Result<Mat<f64>> {
        let n = self.mass.nrows();
        let zero = Mat::<f64>::zeros(s.nrows(), n);
        let split = matches!(quantity, Quantity::Force | Quantity::NonIdealForce);
        if split && layout != Layout::SplitForce {
            return Err(GpError::Shape {
                what: format!("{quantity:?}"),
                expected: "a prior that tells Q and Q_z apart (Layout::SplitForce)".into(),
                found: format!("{layout:?}; ask for TotalForce"),
            });
        }
        Ok(match (layout, quantity) {
            (Layout::Force, _) => s.clone(),
            (Layout::Acceleration, _) => s * &self.mass,
            (Layout::SplitForce, Quantity::Force) => beside(s.clone(), &zero),
            (Layout::SplitForce, Quantity::NonIdealForce) => beside(zero, s),
            (Layout::SplitForce, _) => beside(s.clone(), s),
            (Layout::ForceAndOutput, Quantity::Acceleration) => {
                beside(s.clone(), &Mat::identity(n, n))
            }
            (Layout::ForceAndOutput, _) => beside(s.clone(), &zero),
        })
    }
}
