//! Many states at once: arrays of states, one column per coordinate, in SIMD lanes.
//!
//! [`evaluate`] runs a generated function over all states of [`Columns`]. Every lane holds
//! one state; what is left over at the end of the arrays is computed with its last state
//! repeated, and only what belongs to a state is written.
//!
//! # Choosing the lanes
//!
//! [`WideF64`] and [`WideF32`] are the widest that the target of the compilation has: eight
//! `f64` or sixteen `f32` with AVX-512, else four or eight, which also serve AVX and
//! (two by two) the baseline SSE2 of x86-64 or NEON. The choice is made by the compiler:
//! build with `RUSTFLAGS="-C target-cpu=native"` for this machine, or with the name of the
//! oldest machine that must run the program (`-C target-cpu=x86-64-v3` has AVX2 and fused
//! multiply-add, `x86-64-v4` AVX-512). Nothing is dispatched at run time: a program for
//! several machines is compiled once for each.
//!
//! Results agree with those of single states to round-off: sines and cosines are computed by
//! another algorithm ([`Scalar`] of lanes).
//!
//! Fastest is a call over as many states as stay, with their results, in the first cache: 32
//! for mass matrix and bias force of a seven-joint arm. Columns whose lengths are a large power
//! of two fall into the same sets of the cache: 4096 is slower than some hundred.

#[cfg(doc)]
use crate::Scalar;
use crate::{Entries, Point};

pub use crate::scalar::{Lanes, WideF32, WideF64};

/// States as columns: entry `i` of every column belongs to state `i`.
#[derive(Clone, Copy, Debug)]
pub struct Columns<'a, E, const N: usize, const U: usize, const Z: usize, const Q: usize = N> {
    /// Time `t`, s.
    pub t: &'a [E],
    /// Positions `q`, m or rad.
    pub q: [&'a [E]; Q],
    /// Velocities `v`, m/s or rad/s.
    pub v: [&'a [E]; N],
    /// Inputs `u`.
    pub u: [&'a [E]; U],
    /// Internal states `z`.
    pub z: [&'a [E]; Z],
}

/// Columns that do not fit together.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum ColumnError {
    /// A column of the states is not as long as that of time.
    State {
        /// `"q"`, `"v"`, `"u"` or `"z"`.
        array: &'static str,
        /// Which of its columns.
        column: usize,
        /// Its length.
        found: usize,
        /// The number of states.
        expected: usize,
    },
    /// A column of the result is not as long as those of the states.
    Result {
        /// Which column.
        column: usize,
        /// Its length.
        found: usize,
        /// The number of states.
        expected: usize,
    },
    /// There are not as many columns as the function has results.
    Width {
        /// How many columns there are.
        found: usize,
        /// How many results.
        expected: usize,
    },
}

impl core::fmt::Display for ColumnError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::State {
                array,
                column,
                found,
                expected,
            } => write!(
                f,
                "column {column} of `{array}` has {found} entries for {expected} states; make all columns as long as `t`"
            ),
            Self::Result {
                column,
                found,
                expected,
            } => write!(
                f,
                "column {column} of the result has {found} entries for {expected} states; make it as long as `t`"
            ),
            Self::Width { found, expected } => write!(
                f,
                "there are {found} columns for {expected} results per state; give one column per result"
            ),
        }
    }
}

impl core::error::Error for ColumnError {}

/// Computes `function` at every state; result `k` of state `i` goes to `out[k][i]`.
///
/// # Errors
///
/// [`ColumnError`]; then nothing is written.
///
/// ```
/// use dynamics::batch::{Columns, WideF64, evaluate};
/// use dynamics::{Point, Scalar};
///
/// // As generated code writes it: a pendulum's energy and torque.
/// fn terms<T: Scalar>(x: &Point<T, 1, 0, 0>) -> [T; 2] {
///     let (s, c) = x.q[0].sin_cos();
///     [T::from_f64(0.5) * x.v[0] * x.v[0] - c, -s]
/// }
///
/// let (t, q, v) = ([0.0; 11], [0.3; 11], [2.0; 11]);
/// let states = Columns { t: &t, q: [&q], v: [&v], u: [], z: [] };
/// let (mut energy, mut torque) = ([0.0; 11], [0.0; 11]);
/// evaluate(&states, &mut [&mut energy, &mut torque], |x: &Point<WideF64, 1, 0, 0>| terms(x))?;
/// assert!((energy[10] - (2.0 - 0.3_f64.cos())).abs() < 1e-15);
/// # Ok::<(), dynamics::batch::ColumnError>(())
/// ```
pub fn evaluate<L, R, const N: usize, const U: usize, const Z: usize, const Q: usize>(
    states: &Columns<'_, L::Element, N, U, Z, Q>,
    out: &mut [&mut [L::Element]],
    function: impl Fn(&Point<L, N, U, Z, Q>) -> R,
) -> Result<(), ColumnError>
where
    L: Lanes,
    R: Entries<L>,
{
    states.check::<R, L>(out)?;
    let samples = states.t.len();
    let mut start = 0;
    if R::LENGTH <= MANY {
        let mut x = [Point::zero(); 2];
        while start + 2 * L::LANES <= samples {
            states.take::<L, 2>(&mut x, start);
            // By themselves: an array of results would be put together by copying.
            let (a, b) = (&function(&x[0]), &function(&x[1]));
            write(out, start, [a, b]);
            start += 2 * L::LANES;
        }
    }
    let mut x = [Point::zero()];
    while start + L::LANES <= samples {
        states.take::<L, 1>(&mut x, start);
        write(out, start, [&function(&x[0])]);
        start += L::LANES;
    }
    if start < samples {
        states.take_padded(&mut x[0], start);
        let mut columns = out.iter_mut();
        function(&x[0]).each(&mut |value: L| {
            if let Some(column) = columns.next() {
                value.store_part(&mut column[start..]);
            }
        });
    }
    Ok(())
}

/// Of results with more entries than this, two vectors of lanes would not stay in the first
/// cache beside what they are computed from.
const MANY: usize = 128;

/// Writes the results of `B` vectors of lanes from state `start` on. Looking up a column and
/// its bounds costs as much as several vectors: it is done once for all of them.
#[inline(always)]
fn write<const B: usize, L: Lanes, R: Entries<L>>(
    out: &mut [&mut [L::Element]],
    start: usize,
    results: [&R; B],
) {
    let mut columns = out.iter_mut();
    R::each_of(results, &mut |values: [&L; B]| {
        let column = columns.next();
        let column = column.and_then(|column| column.get_mut(start..start + B * L::LANES));
        if let Some(column) = column {
            for (b, value) in values.into_iter().enumerate() {
                value.store(&mut column[b * L::LANES..]);
            }
        }
    });
}

/// Sets every number of the points `$x` to what `$load` makes of its column and the point's
/// place among them.
macro_rules! fill {
    ($states:ident, $x:ident: |$column:ident, $b:ident| $load:expr) => {
        fill!($states, $x: |$column, $b| $load; q, v, u, z);
        let $column = $states.t;
        for ($b, x) in $x.iter_mut().enumerate() {
            x.t = $load;
        }
    };
    ($states:ident, $x:ident: |$column:ident, $b:ident| $load:expr; $($array:ident),*) => {$(
        for (i, $column) in $states.$array.iter().enumerate() {
            for ($b, x) in $x.iter_mut().enumerate() {
                x.$array[i] = $load;
            }
        }
    )*};
}

impl<E: Copy, const N: usize, const U: usize, const Z: usize, const Q: usize>
    Columns<'_, E, N, U, Z, Q>
{
    /// Fills the points `x` with the states from `start` on.
    #[inline(always)]
    fn take<L: Lanes<Element = E>, const B: usize>(
        &self,
        x: &mut [Point<L, N, U, Z, Q>; B],
        start: usize,
    ) {
        let block = start..start + B * L::LANES;
        fill!(self, x: |column, b| {
            L::load(&column[block.clone()][b * L::LANES..])
        });
    }

    /// Fills `x` with the last states, which are less than lanes.
    fn take_padded<L: Lanes<Element = E>>(&self, x: &mut Point<L, N, U, Z, Q>, start: usize) {
        let x = core::slice::from_mut(x);
        fill!(self, x: |column, _b| L::load_padded(&column[start..]));
    }

    fn check<R: Entries<L>, L>(&self, out: &[&mut [E]]) -> Result<(), ColumnError> {
        let expected = self.t.len();
        let (q, v) = (self.q.as_slice(), self.v.as_slice());
        let arrays = [("q", q), ("v", v), ("u", &self.u), ("z", &self.z)];
        for (array, columns) in arrays {
            for (column, values) in columns.iter().enumerate() {
                if values.len() != expected {
                    return Err(ColumnError::State {
                        array,
                        column,
                        found: values.len(),
                        expected,
                    });
                }
            }
        }
        if out.len() != R::LENGTH {
            return Err(ColumnError::Width {
                found: out.len(),
                expected: R::LENGTH,
            });
        }
        let wrong = out.iter().position(|column| column.len() != expected);
        wrong.map_or(Ok(()), |column| {
            Err(ColumnError::Result {
                column,
                found: out[column].len(),
                expected,
            })
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Scalar;
    use std::vec;
    use std::vec::Vec;

    fn terms<T: Scalar>(x: &Point<T, 2, 1, 0>) -> ([[T; 2]; 2], [T; 1]) {
        let (s, c) = (x.q[0] - x.q[1]).sin_cos();
        let below = T::one() + s * s;
        (
            [[x.v[0] * c, x.t * s], [x.v[1] / below, x.u[0]]],
            [x.q[0].mul_add(x.v[1], c.sqrt())],
        )
    }

    /// Every number of states, so that every remainder occurs.
    fn agrees<L: Lanes>(tolerance: f64) {
        for samples in 0..40_usize {
            let column = |seed: usize| -> Vec<L::Element> {
                let value = |i: usize| ((seed * 31 + i * 17) % 29) as f64 / 40.0;
                (0..samples)
                    .map(|i| L::Element::from_f64(value(i)))
                    .collect()
            };
            let columns: [Vec<L::Element>; 6] = core::array::from_fn(column);
            let states = Columns {
                t: &columns[0],
                q: [&columns[1], &columns[2]],
                v: [&columns[3], &columns[4]],
                u: [&columns[5]],
                z: [],
            };
            let mut results = vec![vec![L::Element::zero(); samples]; 5];
            let mut out: Vec<&mut [L::Element]> =
                results.iter_mut().map(Vec::as_mut_slice).collect();
            evaluate(&states, &mut out, |x: &Point<L, 2, 1, 0>| terms(x)).unwrap();
            for i in 0..samples {
                let x = Point {
                    t: states.t[i],
                    q: states.q.map(|column| column[i]),
                    v: states.v.map(|column| column[i]),
                    u: states.u.map(|column| column[i]),
                    z: [],
                };
                let (matrix, vector) = terms(&x);
                let expected = [
                    matrix[0][0],
                    matrix[0][1],
                    matrix[1][0],
                    matrix[1][1],
                    vector[0],
                ];
                for (k, expected) in expected.into_iter().enumerate() {
                    let gap = (results[k][i] - expected).abs();
                    assert!(
                        crate::Real::to_f64(gap) <= tolerance,
                        "state {i} of {samples}"
                    );
                }
            }
        }
    }

    #[test]
    fn lanes_agree_with_single_states() {
        agrees::<wide::f64x4>(1e-15);
        agrees::<wide::f64x8>(1e-15);
        agrees::<wide::f32x8>(1e-6);
        agrees::<wide::f32x16>(1e-6);
    }

    /// As many results as are computed one vector at a time.
    #[test]
    fn many_results_come_in_order() {
        const RESULTS: usize = MANY + 2;
        let q: Vec<f64> = (0..37).map(f64::from).collect();
        let states = Columns {
            t: &q,
            q: [&q],
            v: [&q],
            u: [],
            z: [],
        };
        let mut results = vec![vec![0.0; q.len()]; RESULTS];
        let mut out: Vec<&mut [f64]> = results.iter_mut().map(Vec::as_mut_slice).collect();
        let multiples = |x: &Point<wide::f64x4, 1, 0, 0>| -> [wide::f64x4; RESULTS] {
            core::array::from_fn(|k| x.q[0] * wide::f64x4::from_f64(k as f64))
        };
        assert_eq!(evaluate(&states, &mut out, multiples), Ok(()));
        for (k, column) in results.iter().enumerate() {
            for (found, q) in column.iter().zip(&q) {
                assert_eq!(*found, q * k as f64);
            }
        }
    }

    #[test]
    fn columns_that_do_not_fit_are_named() {
        let states = |v: [&'static [f64]; 2]| Columns::<f64, 2, 1, 0> {
            t: &[0.0; 9],
            q: [&[0.0; 9], &[0.0; 9]],
            v,
            u: [&[0.0; 9]],
            z: [],
        };
        let full: [&'static [f64]; 2] = [&[0.0; 9], &[0.0; 9]];
        let run = |states: &Columns<'_, f64, 2, 1, 0>, lengths: &[usize]| {
            let mut results: Vec<Vec<f64>> = lengths.iter().map(|&n| vec![7.0; n]).collect();
            let mut out: Vec<&mut [f64]> = results.iter_mut().map(Vec::as_mut_slice).collect();
            let outcome = evaluate(states, &mut out, |x: &Point<WideF64, 2, 1, 0>| terms(x));
            assert!(outcome.is_ok() || results.concat().iter().all(|&x| x == 7.0));
            outcome
        };
        assert_eq!(run(&states(full), &[9; 5]), Ok(()));
        let error = run(&states([&[0.0; 9], &[0.0; 8]]), &[9; 5]);
        let expected = ColumnError::State {
            array: "v",
            column: 1,
            found: 8,
            expected: 9,
        };
        assert_eq!(error, Err(expected));
        let error = run(&states(full), &[9; 4]);
        assert_eq!(
            error,
            Err(ColumnError::Width {
                found: 4,
                expected: 5
            })
        );
        let error = run(&states(full), &[9, 9, 10, 9, 9]);
        let expected = ColumnError::Result {
            column: 2,
            found: 10,
            expected: 9,
        };
        assert_eq!(error, Err(expected));
    }
}
