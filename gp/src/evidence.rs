//! Negative logarithm of the evidence and its exact gradient.
//!
//! `NLL = ½ (y - m)^T α + Σ ln C_ii + R/2 ln 2π` with `Σ = C C^T`, `α = Σ⁻¹ (y - m)`
//! and `R` the number of measured rows (thesis 2.95; the printed constant is
//! wrong), `∂NLL = ½ tr((Σ⁻¹ - α α^T) ∂Σ) - α^T ∂m`.

use crate::contract::{Contraction, Sources, factor_suffices, with_factor, with_inverse};
use crate::error::{GpError, Result, finite, shape};
use crate::functional::Functionals;
use crate::gram::{Stack, assemble};
use crate::linalg::{Square, cholesky, inverse_from_factor, invert_lower, solve_vector};
use crate::model::{Model, Tangent};

/// Buffers an evaluation needs, `2 (R × R)` numbers; reuse them between evaluations.
#[derive(Default)]
pub struct Workspace {
    factor: Square,
    inverse: Square,
    weights: Square,
}

/// Value and gradient of the negative log evidence.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Evidence {
    /// `-ln p(y)`, nats.
    pub nll: f64,
    /// Gradient in [`Model::params`]: prior, then `ln σ_c²`.
    pub gradient: Vec<f64>,
    /// Gradient in the model parameters `θ`, one per [`Tangent`].
    pub theta: Vec<f64>,
    /// What had to be added to the diagonal for the factorisation to succeed; 0 as a rule.
    pub jitter: f64,
    /// Pairs of points with the same input, when the exact covariance needed jitter; empty
    /// otherwise.
    pub coincident: Vec<(usize, usize)>,
}

/// The factorised covariance of a data set.
pub(crate) struct Fit {
    pub(crate) alpha: Vec<f64>,
    pub(crate) nll: f64,
    pub(crate) jitter: f64,
    pub(crate) coincident: Vec<(usize, usize)>,
}

/// Negative log evidence of measurements `y` of the functionals `f` (length `R`).
///
/// Errors: no data, shapes, NaN, a covariance that cannot be factorised.
pub fn nll(model: &Model, f: &Functionals, y: &[f64], work: &mut Workspace) -> Result<f64> {
    let stack = checked(model, f, y)?;
    Ok(factorise(model, f, &stack, y, &mut work.factor)?.nll)
}

/// Negative log evidence with its gradient in every parameter of the model and
/// in the model parameters behind `tangents`.
///
/// ```
/// use gp::{Functionals, Inputs, Kernel, LatentPrior, Model, Workspace};
/// let x = Inputs::from_rows(&[[0.0], [1.0], [2.5]])?;
/// let f = Functionals::identity(&x, 1);
/// let prior = LatentPrior::independent(vec![Kernel::squared_exponential(&[1.0], 1.0)]);
/// let model = Model::new(prior, &[0.01])?;
/// let e = gp::evidence(&model, &f, &[0.1, 0.7, -0.2], &[], &mut Workspace::default())?;
/// assert_eq!(e.gradient.len(), 3); // ln l, ln σ², ln σ_n²
/// assert_eq!(e.jitter, 0.0);
/// # Ok::<(), gp::GpError>(())
/// ```
pub fn evidence(
    model: &Model,
    f: &Functionals,
    y: &[f64],
    tangents: &[Tangent],
    work: &mut Workspace,
) -> Result<Evidence> {
    let stack = checked(model, f, y)?;
    check_tangents(f, tangents)?;
    let fit = factorise(model, f, &stack, y, &mut work.factor)?;
    let src = Sources {
        prior: &model.prior,
        stack: &stack,
        alpha: &fit.alpha,
    };
    let (diagonal, parts) = contract(&src, work, tangents);
    let mut gradient = model
        .prior
        .assemble_gradient(&parts.kernels, &parts.mixings);
    gradient.extend(noise_gradient(model, f, &diagonal, &fit.alpha));
    let theta: Vec<f64> = tangents
        .iter()
        .map(|t| along(t, &parts, &fit.alpha, f.n_latent()))
        .collect();
    finite("gradient of the evidence in θ", &theta)?;
    finite("gradient of the evidence", &gradient)?;
    Ok(Evidence {
        nll: fit.nll,
        gradient,
        theta,
        jitter: fit.jitter,
        coincident: fit.coincident,
    })
}

pub(crate) fn check_tangents(f: &Functionals, tangents: &[Tangent]) -> Result<()> {
    for (p, t) in tangents.iter().enumerate() {
        if t.mean.len() != f.n_rows() || t.rows.len() != f.n_rows() * f.n_latent() {
            return Err(shape(
                format!("tangent of model parameter {p}"),
                format!(
                    "{} means and {} entries of H",
                    f.n_rows(),
                    f.n_rows() * f.n_latent()
                ),
                format!("{} and {}", t.mean.len(), t.rows.len()),
            ));
        }
        finite(&format!("∂H/∂θ of model parameter {p}"), &t.rows)?;
        finite(&format!("∂m/∂θ of model parameter {p}"), &t.mean)?;
    }
    Ok(())
}

/// The diagonal of `Σ⁻¹` and the contracted traces.
fn contract(
    src: &Sources<'_>,
    work: &mut Workspace,
    tangents: &[Tangent],
) -> (Vec<f64>, Contraction) {
    work.inverse.resize(src.stack.rows);
    invert_lower(&mut work.inverse, &work.factor);
    if tangents.is_empty() && factor_suffices(src.prior, src.stack) {
        let parts = with_factor(src, &work.inverse, &mut work.factor, &mut work.weights);
        let diagonal = (0..src.stack.rows)
            .map(|j| {
                let tail = &work.inverse.col(j)[j..];
                crate::simd::dispatch(|| crate::simd::dot(tail, tail))
            })
            .collect();
        return (diagonal, parts);
    }
    inverse_from_factor(&mut work.factor, &work.inverse);
    let diagonal = work.factor.diagonal().collect();
    let parts = with_inverse(src, &mut work.factor, !tangents.is_empty());
    (diagonal, parts)
}

/// `½ σ_c² Σ_{r in c} (Σ⁻¹_rr - α_r²)`.
fn noise_gradient(model: &Model, f: &Functionals, diagonal: &[f64], alpha: &[f64]) -> Vec<f64> {
    let mut out = vec![0.0; model.log_noise.len()];
    for (r, &c) in f.channels().iter().enumerate() {
        out[c] += 0.5 * (diagonal[r] - alpha[r] * alpha[r]);
    }
    out.iter_mut()
        .zip(&model.log_noise)
        .for_each(|(g, l)| *g *= l.exp());
    out
}

/// `Σ <∂H, M> - α^T ∂m`.
pub(crate) fn along(t: &Tangent, parts: &Contraction, alpha: &[f64], n_latent: usize) -> f64 {
    let rows = alpha.len();
    let mean: f64 = alpha.iter().zip(&t.mean).map(|(a, m)| a * m).sum();
    let maps: f64 = parts.maps.as_ref().map_or(0.0, |m| {
        (0..rows)
            .flat_map(|r| (0..n_latent).map(move |d| (r, d)))
            .map(|(r, d)| m[d * rows + r] * t.rows[r * n_latent + d])
            .sum()
    });
    maps - mean
}

pub(crate) fn checked(model: &Model, f: &Functionals, y: &[f64]) -> Result<Stack> {
    if f.n_rows() == 0 {
        return Err(shape("training data", "at least one measured row", 0));
    }
    if y.len() != f.n_rows() {
        return Err(shape(
            "measurements y",
            format!("{} (rows of the functionals)", f.n_rows()),
            y.len(),
        ));
    }
    finite("measurements y", y)?;
    model.check(f)?;
    f.check_channels(model.log_noise.len())?;
    Ok(Stack::new(f, &model.prior))
}

/// Relative jitters tried after the plain matrix, times the mean of its diagonal.
const JITTERS: [f64; 6] = [0.0, 1e-14, 1e-12, 1e-10, 1e-8, 1e-6];

/// Assemble `Σ` and overwrite it by its factor `C`.
pub(crate) fn factorise(
    model: &Model,
    f: &Functionals,
    stack: &Stack,
    y: &[f64],
    a: &mut Square,
) -> Result<Fit> {
    let noise = model.noise_of(f)?;
    let (mut row, mut jitter) = (0, 0.0);
    for relative in JITTERS {
        a.resize(stack.rows);
        let stride = a.stride();
        assemble(&model.prior, stack, stack, true, a.data_mut(), stride);
        a.add_diagonal(&noise);
        finite(
            "variance of a measured row",
            &a.diagonal().collect::<Vec<_>>(),
        )?;
        jitter = relative * a.diagonal().sum::<f64>() / stack.rows as f64;
        a.add_diagonal(&vec![jitter; stack.rows]);
        match cholesky(a) {
            Ok(()) => {
                let residual: Vec<f64> = y.iter().zip(f.mean()).map(|(y, m)| y - m).collect();
                let mut alpha = residual.clone();
                solve_vector(a.view(), &mut alpha);
                let quadratic: f64 = residual.iter().zip(&alpha).map(|(r, a)| r * a).sum();
                let log_det: f64 = a.diagonal().map(f64::ln).sum();
                let constant = 0.5 * stack.rows as f64 * (2.0 * std::f64::consts::PI).ln();
                let nll = 0.5 * quadratic + log_det + constant;
                finite("negative log evidence", &[nll])?;
                let coincident = if jitter > 0.0 {
                    stack.inputs.coincident()
                } else {
                    Vec::new()
                };
                return Ok(Fit {
                    alpha,
                    nll,
                    jitter,
                    coincident,
                });
            }
            Err(at) => row = at,
        }
    }
    let point = stack.starts.partition_point(|&s| s <= row) - 1;
    Err(GpError::NotPositiveDefinite {
        row,
        point,
        jitter,
        coincident: stack.inputs.coincident(),
    })
}
