//! Products of the filter's small square matrices. There is one for each interval of the log, so
//! that a general product would spend its time on packing and allocation.
//!
//! A transition of `n` coordinates moves `2n` positions and velocities, and `n` forces that only fall off,
//! each by itself: `Φ = [A B; 0 D]` with a diagonal `D`. What it leaves alone is not multiplied.

use nalgebra::DMatrix;

/// `m ← Φ m Φᵀ` for a symmetric `m`, and symmetric again whatever round-off says.
pub(super) fn congruence(phi: &DMatrix<f64>, m: &mut DMatrix<f64>) {
    with_size(phi, m, Side::Left);
}

/// `m ← Φᵀ m Φ`, as [`congruence`].
pub(super) fn congruence_transposed(phi: &DMatrix<f64>, m: &mut DMatrix<f64>) {
    with_size(phi, m, Side::Right);
}

/// On which side of the middle `Φ` stands as it is.
#[derive(Clone, Copy, PartialEq)]
enum Side {
    Left,
    Right,
}

/// Three states for each coordinate: the sizes of machines with one to seven of them.
fn with_size(phi: &DMatrix<f64>, m: &mut DMatrix<f64>, side: Side) {
    match m.nrows() {
        3 => sized::<3, 2>(phi, m, side),
        6 => sized::<6, 4>(phi, m, side),
        9 => sized::<9, 6>(phi, m, side),
        12 => sized::<12, 8>(phi, m, side),
        15 => sized::<15, 10>(phi, m, side),
        18 => sized::<18, 12>(phi, m, side),
        21 => sized::<21, 14>(phi, m, side),
        _ => general(phi, m, side),
    }
}

fn general(phi: &DMatrix<f64>, m: &mut DMatrix<f64>, side: Side) {
    let product = match side {
        Side::Left => phi * &*m * phi.transpose(),
        Side::Right => phi.tr_mul(&(&*m * phi)),
    };
    *m = (&product + product.transpose()) * 0.5;
}

/// Columns of `S` numbers each.
type Square<const S: usize> = [[f64; S]; S];

/// `S` states, `M` of which are positions and velocities.
fn sized<const S: usize, const M: usize>(phi: &DMatrix<f64>, m: &mut DMatrix<f64>, side: Side) {
    let (phi, _) = phi.as_slice().as_chunks::<S>();
    let (middle, _) = m.as_mut_slice().as_chunks_mut::<S>();
    let product = match side {
        Side::Left => forwards::<S, M>(phi, middle),
        Side::Right => backwards::<S, M>(phi, middle),
    };
    for (j, column) in middle.iter_mut().enumerate() {
        for (i, entry) in column.iter_mut().enumerate() {
            *entry = 0.5 * (product[j][i] + product[i][j]);
        }
    }
}

/// `Φ m Φᵀ`
fn forwards<const S: usize, const M: usize>(phi: &[[f64; S]], m: &[[f64; S]]) -> Square<S> {
    // [A B], its columns and its rows.
    let columns: [[f64; M]; S] = std::array::from_fn(|j| std::array::from_fn(|i| phi[j][i]));
    let rows: [[f64; S]; M] = std::array::from_fn(|i| std::array::from_fn(|j| phi[j][i]));
    let mut moved = [[0.0; M]; S];
    add_products(&columns, m, &mut moved);
    let mut both = [[0.0; M]; M];
    add_products(&moved, &rows, &mut both);
    let mut product = [[0.0; S]; S];
    for (whole, both) in product.iter_mut().zip(&both) {
        whole[..M].copy_from_slice(both);
    }
    for j in M..S {
        let decay = phi[j][j];
        for i in 0..M {
            product[j][i] = decay * moved[j][i];
            product[i][j] = product[j][i];
        }
        for i in M..S {
            product[j][i] = decay * phi[i][i] * m[j][i];
        }
    }
    product
}

/// `Φᵀ m Φ`
fn backwards<const S: usize, const M: usize>(phi: &[[f64; S]], m: &[[f64; S]]) -> Square<S> {
    let weights: [[f64; M]; S] = std::array::from_fn(|j| std::array::from_fn(|i| phi[j][i]));
    let rows: [[f64; S]; M] = std::array::from_fn(|i| std::array::from_fn(|j| phi[j][i]));
    let mut product = [[0.0; S]; S];
    // m [A B; 0 D]
    let mut moved = [[0.0; S]; S];
    add_products(&m[..M], &weights, &mut moved);
    for j in M..S {
        for i in 0..S {
            moved[j][i] += phi[j][j] * m[j][i];
        }
    }
    // [A B; 0 D]ᵀ of that.
    let upper: [[f64; M]; S] = std::array::from_fn(|j| std::array::from_fn(|i| moved[j][i]));
    add_products(&rows, &upper, &mut product);
    for j in 0..S {
        for i in M..S {
            product[j][i] += phi[i][i] * moved[j][i];
        }
    }
    product
}

/// Adds `a b` to `sums`, all by columns.
fn add_products<const R: usize, const C: usize>(
    a: &[[f64; R]],
    b: &[[f64; C]],
    sums: &mut [[f64; R]],
) {
    for (column, weights) in sums.iter_mut().zip(b) {
        for (own, weight) in a.iter().zip(weights) {
            for (sum, entry) in column.iter_mut().zip(own) {
                *sum += weight * entry;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The sizes that are known, and one that is not, against the general product.
    #[test]
    fn products_are_those_of_the_general_case() {
        for size in [3, 6, 9, 12, 15, 18, 21, 24] {
            let moved = size / 3 * 2;
            let phi = DMatrix::from_fn(size, size, |i, j| match i < moved || i == j {
                true => (1.0 + 3.0 * i as f64 + j as f64).sin(),
                false => 0.0,
            });
            let root = DMatrix::from_fn(size, size, |i, j| (2.0 + i as f64 - 5.0 * j as f64).cos());
            let symmetric = &root * root.transpose();
            for (side, whole) in [
                (Side::Left, &phi * &symmetric * phi.transpose()),
                (Side::Right, phi.transpose() * &symmetric * &phi),
            ] {
                let mut found = symmetric.clone();
                with_size(&phi, &mut found, side);
                let scale = whole.amax();
                assert!((&found - &whole).amax() < 1e-13 * scale, "{size}");
                assert_eq!(found, found.transpose());
            }
        }
    }
}
