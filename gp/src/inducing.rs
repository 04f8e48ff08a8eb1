//! Inducing inputs by greedy variance.

use crate::error::{Result, finite, shape};
use crate::functional::Functionals;
use crate::gram::{Stack, assemble, variances};
use crate::inputs::Inputs;
use crate::latent::LatentPrior;
use crate::model::Model;
use crate::simd::{axpy, dispatch, dot};

/// Added to every pivot, relative to the prior variance it belongs to.
const JITTER: f64 = 1e-8;
/// A point with less than this fraction of the mean prior variance left is explained.
const SPENT: f64 = 1e-7;

/// Indices of `count` points of `data` whose latent functions explain the data best
/// under `model`: greedy in `Σ_r (k_rr - q_rr)/σ_r²`, which is what the variational
/// bound loses for want of inducing inputs (Burt, Rasmussen and van der Wilk 2020, by
/// a partial Cholesky factorisation with pivots of one point each).
///
/// Unlike [`crate::farthest_points`] it knows the length-scales: no point is spent on
/// an input that does not matter. Train, choose anew, train again. Ends early when
/// the chosen points explain everything. Costs `R q²` operations and `R q` numbers
/// for `R` rows and `q = count · n` latent values: for many points offer a subset,
/// such as the farthest two thousand. Errors: shapes, no data, `count = 0`.
///
/// ```
/// use gp::{Functionals, Inputs, Kernel, LatentPrior, Model};
/// // The second input does not matter: three points at x = 0 are as good as one.
/// let x = Inputs::from_rows(&[[0.0, 0.0], [0.0, 5.0], [0.0, 9.0], [2.0, 4.0]])?;
/// let kernel = Kernel::squared_exponential(&[1.0, 1e6], 1.0);
/// let model = Model::new(LatentPrior::independent(vec![kernel]), &[0.01])?;
/// let data = Functionals::identity(&x, 1);
/// assert_eq!(gp::greedy_points(&model, &data, 2)?, vec![0, 3]);
/// # Ok::<(), gp::GpError>(())
/// ```
pub fn greedy_points(model: &Model, data: &Functionals, count: usize) -> Result<Vec<usize>> {
    if count == 0 || data.n_rows() == 0 {
        return Err(shape(
            "greedy choice of inducing inputs",
            "at least one measured row and at least one point",
            format!("{} rows, {count} points", data.n_rows()),
        ));
    }
    model.check(data)?;
    let noise = model.noise_of(data)?;
    let mut partial = Partial::new(&model.prior, data);
    let lost = |rest: &[f64], i: usize| -> f64 {
        let rows = data.rows_of(i);
        rows.map(|r| rest[r] / noise[r]).sum()
    };
    let all: f64 = (0..data.n_points()).map(|i| lost(&partial.rest, i)).sum();
    finite("prior variance over noise", &[all])?;
    let mean = all / data.n_points() as f64;
    while partial.chosen.len() < count.min(data.n_points()) {
        let open = (0..data.n_points()).filter(|i| !partial.chosen.contains(i));
        let best = open.map(|i| (i, lost(&partial.rest, i))).fold(
            None,
            |best: Option<(usize, f64)>, next| match best {
                Some(best) if best.1 >= next.1 => Some(best),
                _ => Some(next),
            },
        );
        match best {
            Some((i, gain)) if gain > SPENT * mean => partial.add(i),
            _ => break,
        }
    }
    Ok(partial.chosen)
}

/// A Cholesky factor of `K_uu` that grows by one point at a time.
struct Partial<'a> {
    prior: &'a LatentPrior,
    inputs: Inputs,
    stack: Stack,
    chosen: Vec<usize>,
    /// Rows of `L_u`, each ending on its diagonal.
    factor: Vec<Vec<f64>>,
    /// Rows of `L_u⁻¹ K_uf`.
    through: Vec<Vec<f64>>,
    /// `k_rr - q_rr`.
    rest: Vec<f64>,
}

impl<'a> Partial<'a> {
    fn new(prior: &'a LatentPrior, data: &Functionals) -> Self {
        let stack = Stack::new(data, prior);
        Self {
            rest: variances(prior, &stack),
            inputs: data.inputs(),
            prior,
            stack,
            chosen: Vec::new(),
            factor: Vec::new(),
            through: Vec::new(),
        }
    }

    fn latents(&self, points: &[usize]) -> Stack {
        let at = self.inputs.pick(points);
        Stack::new(
            &Functionals::identity(&at, self.prior.n_latent()),
            self.prior,
        )
    }

    fn covariance(&self, left: &Stack, right: &Stack) -> Vec<f64> {
        let mut out = vec![0.0; left.rows * right.rows];
        assemble(self.prior, left, right, false, &mut out, left.rows);
        out
    }

    fn add(&mut self, point: usize) {
        let n = self.prior.n_latent();
        let before = self.factor.len();
        let here = self.latents(&[point]);
        let own = self.covariance(&here, &here);
        let earlier = self.covariance(&self.latents(&self.chosen), &here);
        let data = self.covariance(&self.stack, &here);
        let rows = self.stack.rows;
        for c in 0..n {
            let mut row = Vec::with_capacity(before + c + 1);
            for k in 0..before + c {
                let covariance = match k.checked_sub(before) {
                    None => earlier[c * before + k],
                    Some(d) => own[c * n + d],
                };
                let known = dispatch(|| dot(&row, &self.factor[k][..k]));
                row.push((covariance - known) / self.factor[k][k]);
            }
            let variance = own[c * n + c];
            let left = variance - dispatch(|| dot(&row, &row));
            // A latent function without variance has nothing to pass on.
            let pivot = (left + JITTER * variance).max(f64::MIN_POSITIVE).sqrt();
            let mut column = data[c * rows..(c + 1) * rows].to_vec();
            for (l, through) in row.iter().zip(&self.through) {
                dispatch(|| axpy(-l, through, &mut column));
            }
            column.iter_mut().for_each(|v| *v /= pivot);
            for (rest, v) in self.rest.iter_mut().zip(&column) {
                *rest = (*rest - v * v).max(0.0);
            }
            row.push(pivot);
            self.factor.push(row);
            self.through.push(column);
        }
        self.chosen.push(point);
    }
}
