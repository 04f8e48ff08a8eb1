//! Accelerations without constraints, `a = M⁻¹ Q`, at many states.
//!
//! As `identify`'s solve has them, operation by operation, four states side by side. Where that would do anything
//! but factorise `M` and solve, it is asked itself.

use nalgebra::allocator::Allocator;
use nalgebra::{Cholesky, Const, DefaultAllocator, Dim, Dyn, OMatrix, OVector, U1};
use simba::simd::{SimdValue, WideF64x4};

/// A square of a pivot below this share of the largest diagonal entry is none.
const REGULAR: f64 = 1e-13;

/// Of pairs of an `M`, row by row, and a `Q` of `n` numbers, puts `M⁻¹ Q` in the place of every `Q`; says
/// whether it could at all states.
pub fn solve<'a>(n: usize, states: impl Iterator<Item = (&'a [f64], &'a mut [f64])>) -> bool {
    // Loops of a length that is known are several times as fast.
    match n {
        1 => solve_all(Const::<1>, states),
        2 => solve_all(Const::<2>, states),
        3 => solve_all(Const::<3>, states),
        4 => solve_all(Const::<4>, states),
        5 => solve_all(Const::<5>, states),
        6 => solve_all(Const::<6>, states),
        7 => solve_all(Const::<7>, states),
        8 => solve_all(Const::<8>, states),
        n => solve_all(Dyn(n), states),
    }
}

fn solve_all<'a, D: Dim>(
    size: D,
    mut states: impl Iterator<Item = (&'a [f64], &'a mut [f64])>,
) -> bool
where
    DefaultAllocator: Allocator<D, D> + Allocator<D, U1>,
{
    while let Some(first) = states.next() {
        let rest = [(); LANES - 1].map(|()| states.next());
        if !solve_lanes(size, first, rest) {
            return false;
        }
    }
    true
}

/// States that are solved side by side.
const LANES: usize = 4;

/// A state and others beside it, where there are any; lanes that have none do what the first one does.
fn solve_lanes<D: Dim>(
    size: D,
    (mass, force): (&[f64], &mut [f64]),
    mut rest: [Option<(&[f64], &mut [f64])>; LANES - 1],
) -> bool
where
    DefaultAllocator: Allocator<D, D> + Allocator<D, U1>,
{
    let n = size.value();
    let [b, c, d] = [0, 1, 2].map(|lane| rest[lane].as_ref().map_or(mass, |(mass, _)| *mass));
    // It is symmetric: rows are columns.
    let entries = (0..n * n).map(|i| WideF64x4::from([mass[i], b[i], c[i], d[i]]));
    let matrix = OMatrix::from_iterator_generic(size, size, entries);
    let [b, c, d] = [0, 1, 2].map(|lane| rest[lane].as_ref().map_or(&*force, |(_, force)| force));
    let entries = (0..n).map(|i| WideF64x4::from([force[i], b[i], c[i], d[i]]));
    let mut vector = OVector::from_iterator_generic(size, U1, entries);
    let diagonal: OVector<WideF64x4, D> = matrix.diagonal();
    let cholesky = Cholesky::new_unchecked(matrix);
    cholesky.solve_mut(&mut vector);
    let lower = cholesky.l_dirty();
    let finish = |lane: usize, force: &mut [f64]| {
        let (mut scale, mut pivot) = (0.0_f64, f64::INFINITY);
        for i in 0..n {
            scale = scale.max(diagonal[i].extract(lane).abs());
            pivot = pivot.min(lower[(i, i)].extract(lane).abs());
            force[i] = vector[i].extract(lane);
        }
        // Whatever else is no number comes out in the solution.
        pivot * pivot > REGULAR * scale && force.iter().all(|x| x.is_finite())
    };
    let first = finish(0, force);
    let others = rest.iter_mut().enumerate().map(|(k, state)| match state {
        Some((_, force)) => finish(k + 1, force),
        None => true,
    });
    others.fold(first, |all, one| all && one)
}
