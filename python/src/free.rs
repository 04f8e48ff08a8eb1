//! Accelerations without constraints, `a = M⁻¹ Q`, at many states.
//!
//! As `identify`'s solve has them, operation by operation. Where that would do anything but
//! factorise `M` and solve, it is asked itself.

use nalgebra::allocator::Allocator;
use nalgebra::{Cholesky, Const, DefaultAllocator, Dim, Dyn, OMatrix, U1};

/// A square of a pivot below this share of the largest diagonal entry is none.
const REGULAR: f64 = 1e-13;

/// Puts `M⁻¹ Q` in the place of every `Q`, `n` numbers each, `M` row by row in `masses`; says whether
/// it could at all states.
pub fn solve(n: usize, masses: &[f64], forces: &mut [f64]) -> bool {
    // Loops of a length that is known are several times as fast.
    match n {
        1 => solve_each(Const::<1>, masses, forces),
        2 => solve_each(Const::<2>, masses, forces),
        3 => solve_each(Const::<3>, masses, forces),
        4 => solve_each(Const::<4>, masses, forces),
        5 => solve_each(Const::<5>, masses, forces),
        6 => solve_each(Const::<6>, masses, forces),
        7 => solve_each(Const::<7>, masses, forces),
        8 => solve_each(Const::<8>, masses, forces),
        n => solve_each(Dyn(n), masses, forces),
    }
}

fn solve_each<D: Dim>(size: D, masses: &[f64], forces: &mut [f64]) -> bool
where
    DefaultAllocator: Allocator<D, D> + Allocator<D, U1>,
{
    let n = size.value();
    let mut states = masses.chunks(n * n).zip(forces.chunks_mut(n));
    let mut matrix = OMatrix::zeros_generic(size, size);
    let mut vector = OMatrix::zeros_generic(size, U1);
    states.all(|(mass, force)| {
        if mass.iter().any(|x| !x.is_finite()) {
            return false;
        }
        for (i, row) in mass.chunks(n).enumerate() {
            for (j, &entry) in row.iter().enumerate() {
                matrix[(i, j)] = entry;
            }
        }
        let scale = (0..n).fold(0.0_f64, |m, i| m.max(matrix[(i, i)].abs()));
        let Some(cholesky) = Cholesky::new(matrix.clone()) else {
            return false;
        };
        let lower = cholesky.l_dirty();
        let pivot = (0..n).fold(f64::INFINITY, |m, i| m.min(lower[(i, i)].abs()));
        vector.copy_from_slice(force);
        cholesky.solve_mut(&mut vector);
        force.copy_from_slice(vector.as_slice());
        pivot * pivot > REGULAR * scale && force.iter().all(|x| x.is_finite())
    })
}
