//! Products of the filter's small square matrices. There is one for each interval of the log, so
//! that a general product would spend its time on packing and allocation.

use nalgebra::DMatrix;

/// `m ← a m aᵀ` for a symmetric `m`, and symmetric again whatever round-off says.
pub(super) fn congruence(a: &DMatrix<f64>, m: &mut DMatrix<f64>) {
    with_size(a, m, Side::Left);
}

/// `m ← aᵀ m a`, as [`congruence`].
pub(super) fn congruence_transposed(a: &DMatrix<f64>, m: &mut DMatrix<f64>) {
    with_size(a, m, Side::Right);
}

/// On which side of the middle `a` stands as it is.
#[derive(Clone, Copy, PartialEq)]
enum Side {
    Left,
    Right,
}

/// Three states for each coordinate: the sizes of machines with one to seven of them.
fn with_size(a: &DMatrix<f64>, m: &mut DMatrix<f64>, side: Side) {
    match m.nrows() {
        3 => sized::<3>(a, m, side),
        6 => sized::<6>(a, m, side),
        9 => sized::<9>(a, m, side),
        12 => sized::<12>(a, m, side),
        15 => sized::<15>(a, m, side),
        18 => sized::<18>(a, m, side),
        21 => sized::<21>(a, m, side),
        _ => general(a, m, side),
    }
}

fn general(a: &DMatrix<f64>, m: &mut DMatrix<f64>, side: Side) {
    let product = match side {
        Side::Left => a * &*m * a.transpose(),
        Side::Right => a.tr_mul(&(&*m * a)),
    };
    *m = (&product + product.transpose()) * 0.5;
}

/// Columns of `S` numbers each.
type Square<const S: usize> = [[f64; S]; S];

fn sized<const S: usize>(a: &DMatrix<f64>, m: &mut DMatrix<f64>, side: Side) {
    let (columns, _) = a.as_slice().as_chunks::<S>();
    let (middle, _) = m.as_mut_slice().as_chunks_mut::<S>();
    let rows: Square<S> = std::array::from_fn(|i| std::array::from_fn(|j| columns[j][i]));
    let product = match side {
        Side::Left => times(&times(columns, middle), &rows),
        Side::Right => times(&times(&rows, middle), columns),
    };
    for (j, column) in middle.iter_mut().enumerate() {
        for (i, entry) in column.iter_mut().enumerate() {
            *entry = 0.5 * (product[j][i] + product[i][j]);
        }
    }
}

fn times<const S: usize>(a: &[[f64; S]], b: &[[f64; S]]) -> Square<S> {
    let mut product = [[0.0; S]; S];
    for (column, weights) in product.iter_mut().zip(b) {
        for (own, weight) in a.iter().zip(weights) {
            for (sum, entry) in column.iter_mut().zip(own) {
                *sum += weight * entry;
            }
        }
    }
    product
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The sizes that are known, and one that is not, against the general product.
    #[test]
    fn products_are_those_of_the_general_case() {
        for size in [3, 6, 9, 12, 15, 18, 21, 24] {
            let a = DMatrix::from_fn(size, size, |i, j| (1.0 + 3.0 * i as f64 + j as f64).sin());
            let root = DMatrix::from_fn(size, size, |i, j| (2.0 + i as f64 - 5.0 * j as f64).cos());
            let symmetric = &root * root.transpose();
            for (side, whole) in [
                (Side::Left, &a * &symmetric * a.transpose()),
                (Side::Right, a.transpose() * &symmetric * &a),
            ] {
                let mut found = symmetric.clone();
                with_size(&a, &mut found, side);
                let scale = whole.amax();
                assert!((&found - &whole).amax() < 1e-13 * scale, "{size}");
                assert_eq!(found, found.transpose());
            }
        }
    }
}
