//! Prediction of any quantity from measurements of any other (thesis 2.79, 5.11, 5.25).

use crate::contract::Sources;
use crate::error::{Result, finite, shape};
use crate::evidence::{checked, factorise};
use crate::functional::Functionals;
use crate::gram::{Stack, assemble, bind, variances};
use crate::inputs::Inputs;
use crate::latent::LatentPrior;
use crate::linalg::{Square, solve_lower};
use crate::model::Model;
use crate::simd::{TILE, axpy, dispatch, dot};
use faer::{Mat, MatMut};
use rayon::prelude::*;

/// Mean and variance of every predicted row.
#[derive(Clone, Debug, PartialEq)]
pub struct Prediction {
    /// Posterior mean, one per row.
    pub mean: Vec<f64>,
    /// Posterior variance of the noise-free quantity, one per row, at least 0.
    pub variance: Vec<f64>,
}

impl Prediction {
    /// Errors: a mean or variance that is not finite. Round-off below 0 becomes 0.
    pub(crate) fn checked(mean: Vec<f64>, mut variance: Vec<f64>) -> Result<Self> {
        finite("predicted mean", &mean)?;
        finite("predicted variance", &variance)?;
        variance.iter_mut().for_each(|v| *v = v.max(0.0));
        Ok(Self { mean, variance })
    }

    /// Lower and upper end of the central 95 % interval of every row.
    pub fn band95(&self) -> (Vec<f64>, Vec<f64>) {
        let half = self
            .variance
            .iter()
            .map(|v| 1.959_963_984_540_054 * v.sqrt());
        let ends: Vec<(f64, f64)> = self
            .mean
            .iter()
            .zip(half)
            .map(|(m, h)| (m - h, m + h))
            .collect();
        ends.into_iter().unzip()
    }
}

/// A model conditioned on measurements.
///
/// The functionals asked for may be any quantity at any point, under the
/// constraint of the data or another one (transfer, thesis 5.25): only their
/// `H` and `m` matter. Means are formed as `m + H f̂` from the posterior of the
/// latent functions, so `A a = b` holds to round-off.
pub struct Posterior {
    model: Model,
    data: Functionals,
    y: Vec<f64>,
    stack: Stack,
    factor: Square,
    alpha: Vec<f64>,
    /// `β = H^T α`, one column of length `N` per latent function.
    beta: Vec<Vec<f64>>,
    nll: f64,
    jitter: f64,
    coincident: Vec<(usize, usize)>,
}

impl Posterior {
    /// Condition `model` on measurements `y` of `data`.
    ///
    /// Errors: no data, shapes, NaN, a covariance that cannot be factorised.
    pub fn new(model: &Model, data: &Functionals, y: &[f64]) -> Result<Self> {
        let stack = checked(model, data, y)?;
        let mut factor = Square::default();
        let fit = factorise(model, data, &stack, y, &mut factor)?;
        let flat = Sources {
            prior: &model.prior,
            stack: &stack,
            alpha: &fit.alpha,
        }
        .beta();
        let n = stack.n_latent;
        let beta = (0..n)
            .map(|d| flat.iter().skip(d).step_by(n).copied().collect())
            .collect();
        Ok(Self {
            model: model.clone(),
            data: data.clone(),
            y: y.to_vec(),
            stack,
            factor,
            alpha: fit.alpha,
            beta,
            nll: fit.nll,
            jitter: fit.jitter,
            coincident: fit.coincident,
        })
    }

    /// The model that was conditioned.
    pub fn model(&self) -> &Model {
        &self.model
    }

    /// The functionals that were measured.
    pub fn data(&self) -> &Functionals {
        &self.data
    }

    /// The measurements.
    pub fn y(&self) -> &[f64] {
        &self.y
    }

    /// `α = Σ⁻¹ (y - m)`.
    pub fn alpha(&self) -> &[f64] {
        &self.alpha
    }

    /// Negative log evidence of the data.
    pub fn nll(&self) -> f64 {
        self.nll
    }

    /// What had to be added to the diagonal of the covariance; 0 as a rule.
    pub fn jitter(&self) -> f64 {
        self.jitter
    }

    /// Pairs of data points with the same input, when jitter was needed; empty otherwise.
    pub fn coincident(&self) -> &[(usize, usize)] {
        &self.coincident
    }

    fn stack_of(&self, at: &Functionals) -> Result<Stack> {
        stack_for(&self.model, at, self.data.dims())
    }

    /// Posterior mean of the latent functions, point-major, `n_latent` per point.
    pub fn latent_mean(&self, at: &Inputs) -> Result<Vec<f64>> {
        latent_mean(&self.model.prior, &self.stack, &self.beta, at)
    }

    /// Posterior mean of the rows of `at`; cheap, `O(N)` per point.
    pub fn mean(&self, at: &Functionals) -> Result<Vec<f64>> {
        self.stack_of(at)?;
        apply(at, &self.latent_mean(&at.inputs())?)
    }

    /// Posterior mean at one kernel input of rows `H` (row-major) and means `m`:
    /// the hook for integrators, which ask for `a(x)` state by state. With the
    /// mean made from Baumgarte's `b̃` trajectories stay on the constraint
    /// (thesis 5.32); `P`, and so `H`, does not contain `b`.
    pub fn mean_at(&self, x: &[f64], h: &[f64], mean: &[f64]) -> Result<Vec<f64>> {
        let mut at = Functionals::new(self.data.dims(), self.data.n_latent());
        at.push(x, h, mean)?;
        self.mean(&at)
    }

    /// Posterior mean and variance of the rows of `at`.
    pub fn predict(&self, at: &Functionals) -> Result<Prediction> {
        let mean = self.mean(at)?;
        const CHUNK: usize = 64;
        let indices: Vec<usize> = (0..at.n_points()).collect();
        let chunks: Vec<Vec<f64>> = indices
            .par_chunks(CHUNK)
            .map(|chunk| {
                let stack = Stack::new(&at.pick(chunk), &self.model.prior);
                let explained = self.explained(&stack);
                let mut v = variances(&self.model.prior, &stack);
                for (j, v) in v.iter_mut().enumerate() {
                    let column = &explained[j * self.stack.rows..(j + 1) * self.stack.rows];
                    *v -= dispatch(|| dot(column, column));
                }
                v
            })
            .collect();
        Prediction::checked(mean, chunks.concat())
    }

    /// As [`Posterior::predict`], with the noise of each row's channel added to
    /// the variance: what a measurement is expected to show.
    pub fn predict_measured(&self, at: &Functionals) -> Result<Prediction> {
        let mut out = self.predict(at)?;
        out.variance
            .iter_mut()
            .zip(self.model.noise_of(at)?)
            .for_each(|(v, n)| *v += n);
        Ok(out)
    }

    /// `C⁻¹ K(X, x*)`, column-major with `R` rows.
    fn explained(&self, at: &Stack) -> Vec<f64> {
        let mut cross = vec![0.0; self.stack.rows * at.rows];
        assemble(
            &self.model.prior,
            &self.stack,
            at,
            false,
            &mut cross,
            self.stack.rows,
        );
        solve_lower(
            self.factor.view(),
            MatMut::from_column_major_slice_mut(&mut cross, self.stack.rows, at.rows),
        );
        cross
    }

    /// Posterior covariance of all rows of `at`, noise-free.
    pub fn covariance(&self, at: &Functionals) -> Result<Mat<f64>> {
        let stack = self.stack_of(at)?;
        let v = self.explained(&stack);
        let v = faer::MatRef::from_column_major_slice(&v, self.stack.rows, stack.rows);
        checked_matrix(prior_matrix(&self.model, &stack) - v.transpose() * v)
    }

    /// Draws from the joint posterior of the latent functions at `at`.
    ///
    /// One draw gives consistent samples of every quantity at these points,
    /// see [`LatentSamples::quantity`]; samples of `a` obey `A a = b`.
    pub fn sample(&self, at: &Inputs, count: usize, seed: u64) -> Result<LatentSamples> {
        let f = Functionals::identity(at, self.model.prior.n_latent());
        let covariance = self.covariance(&f)?;
        draw(self.mean(&f)?, &covariance, at.len(), count, seed)
    }
}

/// `Σ_t B_t Σ_j k_t(x, z_j) β_j` at every point `x` of `at`; `beta` holds one
/// column over the points of `stack` per latent function.
pub(crate) fn latent_mean(
    prior: &LatentPrior,
    stack: &Stack,
    beta: &[Vec<f64>],
    at: &Inputs,
) -> Result<Vec<f64>> {
    if at.dims() != stack.inputs.dims() {
        return Err(shape(
            "inputs to predict at",
            stack.inputs.dims(),
            at.dims(),
        ));
    }
    let kernels = bind(prior, &stack.inputs, at);
    let mixings: Vec<Mat<f64>> = prior.terms().iter().map(|t| t.mixing.matrix()).collect();
    let (n, points) = (stack.n_latent, stack.n_points());
    let mut out = vec![0.0; at.len() * n];
    out.par_chunks_mut(n).enumerate().for_each(|(i, out)| {
        let mut k = [0.0; TILE];
        for (t, term) in prior.terms().iter().enumerate() {
            let dims = term.mixing.dims();
            let mut sums = vec![0.0; dims.len()];
            for start in (0..points).step_by(TILE) {
                let len = TILE.min(points - start);
                kernels[t].values(i, start, &mut k[..len]);
                for (s, &d) in sums.iter_mut().zip(dims) {
                    *s += dispatch(|| dot(&k[..len], &beta[d][start..start + len]));
                }
            }
            for (a, &c) in dims.iter().enumerate() {
                out[c] += (0..dims.len())
                    .map(|b| mixings[t][(a, b)] * sums[b])
                    .sum::<f64>();
            }
        }
    });
    finite("posterior mean of the latent functions", &out)?;
    Ok(out)
}

pub(crate) fn stack_for(model: &Model, at: &Functionals, dims: usize) -> Result<Stack> {
    if at.dims() != dims {
        return Err(shape(
            "input dimensions of the points to predict at",
            dims,
            at.dims(),
        ));
    }
    model.check(at)?;
    Ok(Stack::new(at, &model.prior))
}

/// `m + H f` for latent values `f`, `n_latent` per point.
pub(crate) fn apply(at: &Functionals, latent: &[f64]) -> Result<Vec<f64>> {
    let n = at.n_latent();
    let mut out = Vec::with_capacity(at.n_rows());
    for i in 0..at.n_points() {
        let f = &latent[i * n..(i + 1) * n];
        for r in at.rows_of(i) {
            let h: f64 = at.row(r).iter().zip(f).map(|(h, f)| h * f).sum();
            out.push(at.mean()[r] + h);
        }
    }
    finite("m + H f of a row", &out)?;
    Ok(out)
}

/// A covariance without NaN and infinity.
pub(crate) fn checked_matrix(covariance: Mat<f64>) -> Result<Mat<f64>> {
    for j in 0..covariance.ncols() {
        for i in 0..covariance.nrows() {
            finite(
                &format!("covariance of rows {i} and {j}"),
                &[covariance[(i, j)]],
            )?;
        }
    }
    Ok(covariance)
}

pub(crate) fn prior_matrix(model: &Model, stack: &Stack) -> Mat<f64> {
    let mut out = vec![0.0; stack.rows * stack.rows];
    assemble(&model.prior, stack, stack, false, &mut out, stack.rows);
    Mat::from_fn(stack.rows, stack.rows, |i, j| out[j * stack.rows + i])
}

/// Prior covariance of all rows of `at`, noise-free.
pub fn prior_covariance(model: &Model, at: &Functionals) -> Result<Mat<f64>> {
    let stack = stack_for(model, at, at.dims())?;
    checked_matrix(prior_matrix(model, &stack))
}

/// Draws from the joint prior of the latent functions at `at`.
pub fn sample_prior(model: &Model, at: &Inputs, count: usize, seed: u64) -> Result<LatentSamples> {
    let f = Functionals::identity(at, model.prior.n_latent());
    let covariance = prior_covariance(model, &f)?;
    draw(vec![0.0; f.n_rows()], &covariance, at.len(), count, seed)
}

/// Joint samples of the latent functions at a set of points.
#[derive(Clone, Debug, PartialEq)]
pub struct LatentSamples {
    points: usize,
    /// One vector per draw: point-major, `n_latent` per point.
    pub draws: Vec<Vec<f64>>,
}

impl LatentSamples {
    /// Samples of the rows of `at`, whose points must be the sampled ones.
    pub fn quantity(&self, at: &Functionals) -> Result<Vec<Vec<f64>>> {
        let len = self.draws.first().map_or(0, Vec::len);
        let fits = |f: &Vec<f64>| f.len() == at.n_points() * at.n_latent();
        if at.n_points() != self.points || !self.draws.iter().all(fits) {
            return Err(shape(
                "points of the quantity",
                format!(
                    "the {} sampled ones, {len} latent values a draw",
                    self.points
                ),
                format!("{} with {} latent functions", at.n_points(), at.n_latent()),
            ));
        }
        self.draws.iter().map(|f| apply(at, f)).collect()
    }
}

fn draw(
    mean: Vec<f64>,
    covariance: &Mat<f64>,
    points: usize,
    count: usize,
    seed: u64,
) -> Result<LatentSamples> {
    use rand::SeedableRng;
    use rand_distr::{Distribution, StandardNormal};
    if mean.is_empty() {
        return Ok(LatentSamples {
            points,
            draws: vec![mean; count],
        });
    }
    let eigen = covariance
        .self_adjoint_eigen(faer::Side::Lower)
        .map_err(|_| crate::GpError::Singular {
            what: "covariance to sample from".into(),
            mend: "its eigenvalues did not converge; sample at fewer points".into(),
        })?;
    let (u, s) = (eigen.U(), eigen.S().column_vector());
    let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(seed);
    let draws = (0..count)
        .map(|_| {
            let mut out = mean.clone();
            for j in 0..s.nrows() {
                let z: f64 = StandardNormal.sample(&mut rng);
                let scale = z * s[j].max(0.0).sqrt();
                let column: Vec<f64> = u.col(j).iter().copied().collect();
                axpy(scale, &column, &mut out);
            }
            out
        })
        .collect();
    Ok(LatentSamples { points, draws })
}
