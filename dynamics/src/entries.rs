//! Results of functions, entry by entry.

use crate::Scalar;

/// What generated functions return, as one list of numbers: a number, arrays of such,
/// pairs, and the structs of functions that compute several quantities.
///
/// ```
/// use dynamics::Entries;
///
/// let mut found = Vec::new();
/// ([[1.0, 2.0], [3.0, 4.0]], [5.0]).each(&mut |x: f64| found.push(x));
/// assert_eq!(found, [1.0, 2.0, 3.0, 4.0, 5.0]);
/// assert_eq!(<[[f64; 3]; 2] as Entries<f64>>::LENGTH, 6);
/// ```
pub trait Entries<T> {
    /// How many numbers.
    const LENGTH: usize;

    /// Hands on every entry of several results, the same entry of all of them at a time; the
    /// last index of arrays fastest.
    fn each_of<const R: usize>(results: [&Self; R], take: &mut impl FnMut([&T; R]));

    /// Hands on every entry, the last index of arrays fastest.
    #[inline(always)]
    fn each(&self, take: &mut impl FnMut(T))
    where
        T: Copy,
    {
        Self::each_of([self], &mut |[entry]| take(*entry));
    }
}

impl<T: Scalar> Entries<T> for T {
    const LENGTH: usize = 1;

    #[inline(always)]
    fn each_of<const R: usize>(results: [&Self; R], take: &mut impl FnMut([&T; R])) {
        take(results);
    }
}

impl<T: Scalar, A: Entries<T>, const K: usize> Entries<T> for [A; K] {
    const LENGTH: usize = K * A::LENGTH;

    #[inline(always)]
    fn each_of<const R: usize>(results: [&Self; R], take: &mut impl FnMut([&T; R])) {
        for i in 0..K {
            A::each_of(results.map(|array| &array[i]), take);
        }
    }
}

impl<T: Scalar, A: Entries<T>, B: Entries<T>> Entries<T> for (A, B) {
    const LENGTH: usize = A::LENGTH + B::LENGTH;

    #[inline(always)]
    fn each_of<const R: usize>(results: [&Self; R], take: &mut impl FnMut([&T; R])) {
        A::each_of(results.map(|pair| &pair.0), take);
        B::each_of(results.map(|pair| &pair.1), take);
    }
}
