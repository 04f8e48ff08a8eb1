//! Gauss' principle at one point: from `M, A, b` to the linear maps of every
//! quantity of constrained dynamics.
//!
//! With `G = A M⁻¹ A^T`, `Γ = G⁺`, `L = M⁻¹ A^T Γ` and
//! `P = M⁻¹ - M⁻¹ A^T Γ A M⁻¹` (thesis 3.38–3.43), the constrained acceleration
//! is `a = L b + P Q̄`, the multipliers `λ = Γ b - L^T Q̄`, `Q_I = +A^T λ`. No
//! robot in here: the matrices come from generated code, a tape, or a hand.

mod dense;
mod inverse;

use self::dense::Dense;
use self::inverse::{consistent, pseudo_inverse, singular_mass, stiffened};
use crate::error::{GpError, Result, finite, shape};
use crate::model::Tangent;

/// Eigenvalues of `G = A M⁻¹ A^T` below this fraction of the largest count as zero,
/// and pivots below this fraction of their diagonal entry as dependent rows.
pub const RANK_TOLERANCE: f64 = 1e-12;

/// A pivot of `M` below this fraction of its diagonal entry makes `M` singular.
pub const PIVOT_TOLERANCE: f64 = 1e-13;

/// `b` may leave the range of `A` by this fraction of `1 + |b|`.
pub const CONSISTENCY_TOLERANCE: f64 = 1e-8;

/// `M` may differ from its transpose by this fraction of its largest entry.
pub const SYMMETRY_TOLERANCE: f64 = 1e-8;

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
            Self::SplitForce | Self::ForceAndOutput => n.saturating_mul(2),
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
    /// `∂M`, `n × n` row-major.
    pub mass: Vec<f64>,
    /// `∂A`, `m × n` row-major.
    pub a: Vec<f64>,
    /// `∂b`, length `m`.
    pub b: Vec<f64>,
    /// `∂Q_K`, length `n`.
    pub known: Vec<f64>,
}

impl PointTangent {
    /// All derivatives zero.
    pub fn zero(n: usize, m: usize) -> Self {
        Self {
            mass: vec![0.0; n * n],
            a: vec![0.0; m * n],
            b: vec![0.0; m],
            known: vec![0.0; n],
        }
    }
}

/// Constrained dynamics at one state: all maps of thesis 3.38–3.43.
///
/// ```
/// use gp::{GaussPoint, Layout, Quantity};
/// // A unit mass in the plane that may only move along x = y.
/// let p = GaussPoint::new(&[1.0, 0.0, 0.0, 1.0], &[1.0, -1.0], &[0.0], &[2.0, 0.0])?;
/// let a = p.rows(Quantity::Acceleration, Layout::Force)?;
/// assert!((a.mean[0] - 1.0).abs() < 1e-14 && (a.mean[1] - 1.0).abs() < 1e-14);
/// # Ok::<(), gp::GpError>(())
/// ```
#[derive(Clone, Debug)]
pub struct GaussPoint {
    mass: Dense,
    a: Dense,
    b: Dense,
    known: Dense,
    p: Dense,
    l: Dense,
    gamma: Dense,
    mass_inv: Option<Dense>,
    full_rank: bool,
}

impl GaussPoint {
    /// From `M` (`n × n` row-major, symmetric to [`SYMMETRY_TOLERANCE`], positive definite or singular
    /// with `rank [M; A] = n`), `A` (`m × n` row-major, `m = 0` allowed, rows may
    /// repeat), `b` (length `m`) and the known force `Q_K` (length `n`).
    ///
    /// Rank of `A` is judged by [`RANK_TOLERANCE`]. A singular `M` is replaced
    /// by `M + s A^T A` (thesis 3.49–3.54), `s = tr M / tr A^T A`. Errors:
    /// shapes, NaN, an `M` that is not symmetric, `b` outside the range of `A`, both matrices
    /// singular, entries so far apart that the maps overflow.
    pub fn new(mass: &[f64], a: &[f64], b: &[f64], known: &[f64]) -> Result<Self> {
        let (n, m) = (known.len(), b.len());
        check_lengths("M and A", n, m, mass, a)?;
        for (what, values) in [("M", mass), ("A", a), ("b", b), ("Q_K", known)] {
            finite(what, values)?;
        }
        symmetric("M", n, mass)?;
        let (mass, a, b) = (
            Dense::new(n, n, mass),
            Dense::new(m, n, a),
            Dense::column(b),
        );
        let mass_inv = mass.inverse_spd(PIVOT_TOLERANCE);
        let (inverse, shift) = match &mass_inv {
            Some(inverse) => (inverse.clone(), 0.0),
            None => stiffened(&mass, &a)?,
        };
        let through = &inverse * &a.t();
        let g = &a * &through;
        let (gamma, rank) = pseudo_inverse(&g)?;
        consistent(&g, &gamma, &b)?;
        let l = &through * &gamma;
        let p = inverse - &(&l * &through.t());
        let gamma = gamma - &Dense::identity(m).scaled(shift);
        for (what, map) in [("P", &p), ("L", &l), ("Γ", &gamma)] {
            finite(&format!("{what} of M and A"), &map.v)?;
        }
        let full_rank = rank == m && shift == 0.0;
        Ok(Self {
            mass,
            a,
            b,
            known: Dense::column(known),
            p,
            l,
            gamma,
            mass_inv,
            full_rank,
        })
    }

    /// `P`, `n × n` row-major, with `A P = 0`.
    pub fn p(&self) -> &[f64] {
        &self.p.v
    }

    /// `L`, `n × m` row-major.
    pub fn l(&self) -> &[f64] {
        &self.l.v
    }

    /// `H` and `m` of a quantity. Errors: the unconstrained acceleration of a
    /// singular `M`; `Q` or `Q_z` without a split prior.
    pub fn rows(&self, quantity: Quantity, layout: Layout) -> Result<Rows> {
        let (s, offset) = self.map(quantity)?;
        let mean = offset + &(&s * &self.known).scaled(known_share(quantity));
        let h = self.over_latents(&s, quantity, layout)?;
        Ok(Rows {
            h: h.v,
            mean: mean.v,
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
        let (n, m) = (self.mass.rows, self.a.rows);
        check_lengths("tangents of M and A", n, m, &d.mass, &d.a)?;
        for (what, values) in [("∂M", &d.mass), ("∂A", &d.a)] {
            finite(what, values)?;
        }
        for (what, values) in [("∂b", &d.b), ("∂Q_K", &d.known)] {
            finite(what, values)?;
        }
        symmetric("∂M", n, &d.mass)?;
        if (d.b.len(), d.known.len()) != (m, n) {
            let found = format!("{} and {}", d.b.len(), d.known.len());
            return Err(shape(
                "tangents of b and Q_K",
                format!("{m} and {n}"),
                found,
            ));
        }
        let d = Tangents {
            mass: Dense::new(n, n, &d.mass),
            a: Dense::new(m, n, &d.a),
            b: Dense::column(&d.b),
            known: Dense::column(&d.known),
        };
        let (s, _) = self.map(quantity)?;
        let (ds, doffset) = self.map_tangent(&d, quantity)?;
        let forced = &ds * &self.known + &(&s * &d.known);
        let mean = doffset + &forced.scaled(known_share(quantity));
        let h = match (layout, quantity) {
            (Layout::Acceleration, _) => &ds * &self.mass + &(&s * &d.mass),
            (Layout::ForceAndOutput, Quantity::Acceleration) => ds.beside(&Dense::zeros(n, n)),
            _ => self.over_latents(&ds, quantity, layout)?,
        };
        Ok(Tangent {
            rows: h.v,
            mean: mean.v,
        })
    }

    /// `s = S Q̄ + offset`: the map of a quantity from all forces but `Q_I`.
    fn map(&self, quantity: Quantity) -> Result<(Dense, Dense)> {
        let n = self.mass.rows;
        let multiplier = || (self.l.t().scaled(-1.0), &self.gamma * &self.b);
        Ok(match quantity {
            Quantity::Acceleration => (self.p.clone(), &self.l * &self.b),
            Quantity::UnconstrainedAcceleration => (
                self.mass_inv.clone().ok_or_else(singular_mass)?,
                Dense::zeros(n, 1),
            ),
            Quantity::Multiplier => multiplier(),
            Quantity::ConstraintForce => {
                let (s, offset) = multiplier();
                (&self.a.t() * &s, &self.a.t() * &offset)
            }
            Quantity::TotalForce | Quantity::Force | Quantity::NonIdealForce => {
                (Dense::identity(n), Dense::zeros(n, 1))
            }
        })
    }

    /// Derivatives of [`GaussPoint::map`], from `∂K⁻¹ = -K⁻¹ ∂K K⁻¹` with
    /// `K = [[M, A^T], [A, 0]]`, `K⁻¹ = [[P, L], [L^T, -Γ]]`.
    fn map_tangent(&self, d: &Tangents, quantity: Quantity) -> Result<(Dense, Dense)> {
        let n = self.mass.rows;
        let (p, l, gamma) = (&self.p, &self.l, &self.gamma);
        let dl = || {
            let bent = &(p * &d.mass) * l + &(&(l * &d.a) * l);
            &(p * &d.a.t()) * gamma - &bent
        };
        let multiplier = || {
            let dgamma = (&(&l.t() * &d.mass) * l).plus_symmetric(-1.0, &(&(gamma * &d.a) * l));
            (dl().t().scaled(-1.0), &dgamma * &self.b + &(gamma * &d.b))
        };
        Ok(match quantity {
            Quantity::Acceleration => {
                let dp = (&(p * &d.mass) * p).scaled(-1.0);
                let dp = dp.plus_symmetric(-1.0, &(&(l * &d.a) * p));
                (dp, &dl() * &self.b + &(l * &d.b))
            }
            Quantity::UnconstrainedAcceleration => {
                let inverse = self.mass_inv.as_ref().ok_or_else(singular_mass)?;
                (
                    (&(inverse * &d.mass) * inverse).scaled(-1.0),
                    Dense::zeros(n, 1),
                )
            }
            Quantity::Multiplier => multiplier(),
            Quantity::ConstraintForce => {
                let (s, offset) = self.map(Quantity::Multiplier)?;
                let (ds, doffset) = multiplier();
                let (at, dat) = (self.a.t(), d.a.t());
                (&dat * &s + &(&at * &ds), &dat * &offset + &(&at * &doffset))
            }
            Quantity::TotalForce | Quantity::Force | Quantity::NonIdealForce => {
                (Dense::zeros(n, n), Dense::zeros(n, 1))
            }
        })
    }

    /// `S` applied to how the latent functions enter `Q̄`.
    fn over_latents(&self, s: &Dense, quantity: Quantity, layout: Layout) -> Result<Dense> {
        let n = self.mass.rows;
        let zero = Dense::zeros(s.rows, n);
        let split = matches!(quantity, Quantity::Force | Quantity::NonIdealForce);
        if split && layout != Layout::SplitForce {
            return Err(shape(
                format!("{quantity:?}"),
                "a prior that tells Q and Q_z apart (Layout::SplitForce)",
                format!("{layout:?}; ask for TotalForce"),
            ));
        }
        Ok(match (layout, quantity) {
            (Layout::Force, _) => s.clone(),
            (Layout::Acceleration, _) => s * &self.mass,
            (Layout::SplitForce, Quantity::Force) => s.beside(&zero),
            (Layout::SplitForce, Quantity::NonIdealForce) => zero.beside(s),
            (Layout::SplitForce, _) => s.beside(s),
            (Layout::ForceAndOutput, Quantity::Acceleration) => s.beside(&Dense::identity(n)),
            (Layout::ForceAndOutput, _) => s.beside(&zero),
        })
    }
}

struct Tangents {
    mass: Dense,
    a: Dense,
    b: Dense,
    known: Dense,
}

/// `Q_z` alone has no known part; everything else sees all of `Q_K`.
fn known_share(quantity: Quantity) -> f64 {
    if quantity == Quantity::NonIdealForce {
        0.0
    } else {
        1.0
    }
}

fn symmetric(what: &str, n: usize, m: &[f64]) -> Result<()> {
    let largest = m.iter().fold(0.0f64, |a, v| a.max(v.abs()));
    for (i, j) in (0..n).flat_map(|i| (0..i).map(move |j| (i, j))) {
        let off = m[i * n + j] - m[j * n + i];
        if off.abs() > SYMMETRY_TOLERANCE * largest {
            return Err(GpError::Parameter {
                name: format!("{what}[{i}][{j}] - {what}[{j}][{i}]"),
                value: off,
                expected: format!("0, within {SYMMETRY_TOLERANCE:e} of the largest entry"),
            });
        }
    }
    Ok(())
}

fn check_lengths(what: &str, n: usize, m: usize, mass: &[f64], a: &[f64]) -> Result<()> {
    if (mass.len(), a.len()) == (n * n, m * n) {
        return Ok(());
    }
    Err(shape(
        what,
        format!("{n} × {n} and {m} × {n} (row-major, from the lengths of Q_K and b)"),
        format!("{} and {} numbers", mass.len(), a.len()),
    ))
}
