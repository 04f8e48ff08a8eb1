//! Least squares in which some coefficients are not below a bound.
//!
//! Source: C. L. Lawson, R. J. Hanson, *Solving Least Squares Problems* (1974), chapter 23, on
//! the normal equations; it begins with everything free, as few coefficients are ever held.

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

/// A gradient at a held coefficient counts as pulling it back inside if it is this share of the
/// moments that cancel in it: below is round-off of the normal equations.
const PULLS: f64 = 1e-9;
/// So often per coefficient one is set free again at most: the method ends by itself, but for
/// round-off, which must not let one go in and out for ever.
const TURNS: usize = 3;

/// A solution within the signs.
#[derive(Debug, Clone)]
pub(super) struct Bounded {
    /// The coefficients; exactly at the bound where held.
    pub x: DVector<f64>,
    /// Which of them are not held, ascending.
    pub free: Vec<usize>,
    /// Of the normal equations of the free ones.
    pub cholesky: Cholesky<f64, Dyn>,
}

/// Minimises `½ xᵀ G x − mᵀ x` for a positive definite `G` (n×n) with `x_i ≥ lower_i` (n; `-∞` for
/// none). `None` if `G` is not positive definite.
pub(super) fn bounded(
    gram: &DMatrix<f64>,
    moment: &DVector<f64>,
    lower: &[f64],
) -> Option<Bounded> {
    // In what each is above its bound.
    let floor = DVector::from_fn(lower.len(), |i, _| match lower[i].is_finite() {
        true => lower[i],
        false => 0.0,
    });
    let signed: Vec<bool> = lower.iter().map(|bound| bound.is_finite()).collect();
    let mut found = positive(gram, &(moment - gram * &floor), &signed)?;
    found.x += floor;
    Some(found)
}

/// The same with zero for every bound, where `signed` says that there is one.
fn positive(gram: &DMatrix<f64>, moment: &DVector<f64>, signed: &[bool]) -> Option<Bounded> {
    let mut held = vec![false; signed.len()];
    let mut best = solved(gram, moment, &held)?;
    let mut releases = TURNS * signed.len();
    loop {
        let negative = (0..signed.len()).filter(|&i| signed[i] && best.x[i] < 0.0);
        let negative: Vec<usize> = negative.collect();
        if !negative.is_empty() {
            negative.into_iter().for_each(|i| held[i] = true);
        } else if releases > 0
            && let Some(inside) = pulled_back(gram, moment, &best.x, &held)
        {
            held[inside] = false;
            releases -= 1;
        } else {
            return Some(best);
        }
        best = solved(gram, moment, &held)?;
    }
}

/// The solution with some coefficients at zero.
fn solved(gram: &DMatrix<f64>, moment: &DVector<f64>, held: &[bool]) -> Option<Bounded> {
    let free: Vec<usize> = (0..held.len()).filter(|&i| !held[i]).collect();
    let part = DMatrix::from_fn(free.len(), free.len(), |i, j| gram[(free[i], free[j])]);
    let right = DVector::from_fn(free.len(), |i, _| moment[free[i]]);
    let cholesky = part.cholesky()?;
    let own = cholesky.solve(&right);
    let mut x = DVector::zeros(held.len());
    free.iter()
        .zip(own.iter())
        .for_each(|(&i, &own)| x[i] = own);
    Some(Bounded { x, free, cholesky })
}

/// The held coefficient that the equations pull inside most, in units of its own column.
fn pulled_back(
    gram: &DMatrix<f64>,
    moment: &DVector<f64>,
    x: &DVector<f64>,
    held: &[bool],
) -> Option<usize> {
    let pull = |i: usize| {
        let pushed: f64 = gram.row(i).iter().zip(x.iter()).map(|(g, x)| g * x).sum();
        let size = moment[i].abs() + pushed.abs();
        let force = moment[i] - pushed;
        (force > PULLS * size).then(|| (i, force / gram[(i, i)].sqrt()))
    };
    let pulls = (0..held.len()).filter(|&i| held[i]).filter_map(pull);
    pulls.max_by(|a, b| a.1.total_cmp(&b.1)).map(|(i, _)| i)
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{dmatrix, dvector};

    #[test]
    fn without_signs_it_is_least_squares() {
        let gram = dmatrix![4.0, 1.0; 1.0, 3.0];
        let found = bounded(&gram, &dvector![1.0, -2.0], &[f64::NEG_INFINITY; 2]).unwrap();
        assert!((&gram * &found.x - dvector![1.0, -2.0]).amax() < 1e-14);
        assert_eq!(found.free, [0, 1]);
    }

    /// One that is held changes what the others are.
    #[test]
    fn what_would_be_negative_is_held_at_zero() {
        let gram = dmatrix![4.0, 1.0; 1.0, 3.0];
        let found = bounded(&gram, &dvector![1.0, -2.0], &[0.0; 2]).unwrap();
        assert_eq!(found.x, dvector![0.25, 0.0]);
        assert_eq!(found.free, [0]);
    }

    /// What the model states of a coefficient may be taken away, no more.
    #[test]
    fn a_bound_below_zero_is_kept() {
        let gram = dmatrix![4.0, 1.0; 1.0, 3.0];
        let found = bounded(&gram, &dvector![1.0, -2.0], &[0.0, -0.5]).unwrap();
        assert_eq!(found.x, dvector![0.375, -0.5]);
        let free = bounded(&gram, &dvector![1.0, -2.0], &[0.0, -1.0]).unwrap();
        assert!((&gram * &free.x - dvector![1.0, -2.0]).amax() < 1e-14);
    }

    /// Both are negative at first, but only one has to be held.
    #[test]
    fn what_was_held_too_soon_is_set_free() {
        let gram = dmatrix![1.0, 0.0, 0.9; 0.0, 1.0, 0.9; 0.9, 0.9, 1.8];
        let moment = dvector![0.2, 0.6, 1.0];
        let all = [0.0; 3];
        let found = bounded(&gram, &moment, &all).unwrap();
        let slope = &gram * &found.x - &moment;
        for i in 0..3 {
            assert!(found.x[i] >= 0.0 && slope[i] >= -1e-12, "{found:?} {slope}");
            assert!(found.x[i] * slope[i] < 1e-12, "{found:?} {slope}");
        }
    }
}
