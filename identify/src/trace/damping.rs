//! Shorter steps, where one has led uphill (Levenberg, Marquardt).

use crate::regression::Gram;

/// Damping of the steps that are tried one after the other where one leads uphill: the first
/// shorten steps along a narrow valley, the last ones all.
pub(super) const DAMPING: [f64; 5] = [0.0, 1e-6, 1e-4, 1e-2, 1.0];

/// Steps that differ by no more than this share are one.
const SAME_STEP: f64 = 0.1;

/// Which damping comes next where the one of number `tried` led uphill, of a linear equation in so many
/// columns: nearly the same step would lead uphill, too. The number of all of them if no other is left.
pub(super) fn more_damping(gram: &Gram, columns: usize, tried: usize) -> usize {
    let all: Vec<usize> = (0..columns).collect();
    // Along each column in units in which its squares sum to one.
    let scaled = |damping: f64| {
        let mut step = gram.damped_fit(&all, damping).coefficients;
        for (column, change) in step.iter_mut().enumerate() {
            *change *= gram.size(column).sqrt();
        }
        step
    };
    let last = scaled(DAMPING[tried]);
    let is_another = |&next: &usize| {
        let apart = (scaled(DAMPING[next]) - &last).amax();
        apart > SAME_STEP * last.amax()
    };
    let mut stronger = tried + 1..DAMPING.len();
    stronger.find(is_another).unwrap_or(DAMPING.len())
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::DMatrix;

    /// Of data and two columns with an angle between them.
    fn gram(angle: f64) -> Gram {
        let (sine, cosine) = f64::sin_cos(angle);
        let rows = [0.3, 1.0, cosine, 0.8, 0.0, sine];
        Gram::new(
            &DMatrix::from_row_slice(2, 3, &rows),
            std::slice::from_ref(&(0..2)),
            2,
        )
    }

    fn tried(gram: &Gram) -> Vec<f64> {
        let next =
            |&tried: &usize| Some(more_damping(gram, 2, tried)).filter(|&i| i < DAMPING.len());
        let each = std::iter::successors(Some(0), next);
        each.map(|i| DAMPING[i]).collect()
    }

    #[test]
    fn a_valley_is_narrow_where_little_damping_shortens_the_step() {
        // Columns that are far from alike: only the last shortens it.
        assert_eq!(tried(&gram(1.5)), [0.0, 1.0]);
        // An angle of 1e-2 is felt from a damping of about its square on.
        assert_eq!(tried(&gram(1e-2)), [0.0, 1e-4, 1e-2, 1.0]);
        assert_eq!(tried(&gram(1e-3)), DAMPING);
    }
}
