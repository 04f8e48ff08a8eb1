//! Dual numbers: a value and its derivatives in `D` directions, exact to round-off.

use core::ops::{Add, AddAssign, Div, DivAssign, Mul, MulAssign, Neg, Sub, SubAssign};

use crate::Scalar;

/// Forward-mode dual number `re + Σ_d eps[d] ε_d` with `ε_i ε_j = 0`.
///
/// Every generated function evaluated on duals returns its value in `re` and its
/// derivative along direction `d` in `eps[d]`. Duals nest: `Dual<Dual<f64, 1>, 1>`
/// carries second derivatives.
///
/// Equality compares values and derivatives. Where a function has no derivative
/// (`abs`, `sign`, `step` at 0; `sqrt` at 0) the convention of [`Scalar`] holds: 0 for
/// the first three, infinite or NaN for `sqrt`.
///
/// ```
/// use dynamics::{Dual, Scalar};
///
/// let [x, y] = Dual::variables([2.0_f64, 3.0]);
/// let f = x * x * y;
/// assert_eq!((f.re, f.eps), (12.0, [12.0, 4.0]));
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dual<T, const D: usize> {
    /// The value.
    pub re: T,
    /// The derivative in each direction.
    pub eps: [T; D],
}

impl<T: Scalar, const D: usize> Dual<T, D> {
    /// A number that depends on nothing: all derivatives 0.
    #[inline]
    pub fn constant(re: T) -> Self {
        Self {
            re,
            eps: [T::zero(); D],
        }
    }

    /// The variable of direction `direction`: derivative 1 there, 0 elsewhere. A
    /// `direction` of `D` or more gives a constant.
    #[inline]
    pub fn variable(re: T, direction: usize) -> Self {
        let eps = core::array::from_fn(|d| if d == direction { T::one() } else { T::zero() });
        Self { re, eps }
    }

    /// `D` variables, the d-th seeded in direction d.
    #[inline]
    pub fn variables(values: [T; D]) -> [Self; D] {
        core::array::from_fn(|d| Self::variable(values[d], d))
    }

    /// Chain rule: value `f`, derivatives `df` times the own ones.
    #[inline]
    fn chain(self, f: T, df: T) -> Self {
        Self {
            re: f,
            eps: self.eps.map(|e| df * e),
        }
    }

    /// Chain rule in two arguments: value `f`, derivatives `dx·x' + dy·y'`.
    #[inline]
    fn chain2(self, other: Self, f: T, dx: T, dy: T) -> Self {
        Self {
            re: f,
            eps: core::array::from_fn(|d| dx * self.eps[d] + dy * other.eps[d]),
        }
    }
}

impl<T: Scalar, const D: usize> Add for Dual<T, D> {
    type Output = Self;
    #[inline]
    fn add(self, other: Self) -> Self {
        Self {
            re: self.re + other.re,
            eps: core::array::from_fn(|d| self.eps[d] + other.eps[d]),
        }
    }
}

impl<T: Scalar, const D: usize> Sub for Dual<T, D> {
    type Output = Self;
    #[inline]
    fn sub(self, other: Self) -> Self {
        Self {
            re: self.re - other.re,
            eps: core::array::from_fn(|d| self.eps[d] - other.eps[d]),
        }
    }
}

impl<T: Scalar, const D: usize> Mul for Dual<T, D> {
    type Output = Self;
    #[inline]
    fn mul(self, other: Self) -> Self {
        self.chain2(other, self.re * other.re, other.re, self.re)
    }
}

impl<T: Scalar, const D: usize> Div for Dual<T, D> {
    type Output = Self;
    #[inline]
    fn div(self, other: Self) -> Self {
        let quotient = self.re / other.re;
        let inverse = other.re.recip();
        self.chain2(other, quotient, inverse, -quotient * inverse)
    }
}

impl<T: Scalar, const D: usize> Neg for Dual<T, D> {
    type Output = Self;
    #[inline]
    fn neg(self) -> Self {
        Self {
            re: -self.re,
            eps: self.eps.map(|e| -e),
        }
    }
}

macro_rules! assign {
    ($($op:ident $method:ident $symbol:tt;)*) => {$(
        impl<T: Scalar, const D: usize> $op for Dual<T, D> {
            #[inline]
            fn $method(&mut self, other: Self) {
                *self = *self $symbol other;
            }
        }
    )*};
}

assign! {
    AddAssign add_assign +;
    SubAssign sub_assign -;
    MulAssign mul_assign *;
    DivAssign div_assign /;
}

impl<T: Scalar, const D: usize> Scalar for Dual<T, D> {
    #[inline]
    fn from_f64(x: f64) -> Self {
        Self::constant(T::from_f64(x))
    }

    #[inline]
    fn sqrt(self) -> Self {
        let root = self.re.sqrt();
        self.chain(root, T::from_f64(0.5) / root)
    }

    #[inline]
    fn sin_cos(self) -> (Self, Self) {
        let (s, c) = self.re.sin_cos();
        (self.chain(s, c), self.chain(c, -s))
    }

    #[inline]
    fn tan(self) -> Self {
        let tan = self.re.tan();
        self.chain(tan, tan.mul_add(tan, T::one()))
    }

    #[inline]
    fn asin(self) -> Self {
        let cosine = (T::one() - self.re * self.re).sqrt();
        self.chain(self.re.asin(), cosine.recip())
    }

    #[inline]
    fn acos(self) -> Self {
        let sine = (T::one() - self.re * self.re).sqrt();
        self.chain(self.re.acos(), -sine.recip())
    }

    #[inline]
    fn atan(self) -> Self {
        self.chain(self.re.atan(), (T::one() + self.re * self.re).recip())
    }

    #[inline]
    fn atan2(self, x: Self) -> Self {
        let square = self.re * self.re + x.re * x.re;
        self.chain2(x, self.re.atan2(x.re), x.re / square, -self.re / square)
    }

    #[inline]
    fn exp(self) -> Self {
        let exp = self.re.exp();
        self.chain(exp, exp)
    }

    #[inline]
    fn ln(self) -> Self {
        self.chain(self.re.ln(), self.re.recip())
    }

    /// For a base that is not positive only the derivative with respect to the base
    /// is carried (the other, xʸ ln x, does not exist there).
    #[inline]
    fn powf(self, y: Self) -> Self {
        let power = self.re.powf(y.re);
        let by_base = y.re * self.re.powf(y.re - T::one());
        let ln = self.re.select_positive(self.re, T::one()).ln();
        self.chain2(y, power, by_base, power * ln)
    }

    #[inline]
    fn powi(self, n: i32) -> Self {
        let slope = if n == 0 {
            T::zero()
        } else {
            // n − 1 cannot overflow to a wrong power: i32::MIN saturates, where xⁿ
            // is 0, 1 or infinite anyway.
            T::from_f64(f64::from(n)) * self.re.powi(n.saturating_sub(1))
        };
        self.chain(self.re.powi(n), slope)
    }

    #[inline]
    fn tanh(self) -> Self {
        let tanh = self.re.tanh();
        self.chain(tanh, T::one() - tanh * tanh)
    }

    #[inline]
    fn abs(self) -> Self {
        self.chain(self.re.abs(), self.re.sign())
    }

    #[inline]
    fn sign(self) -> Self {
        Self::constant(self.re.sign())
    }

    #[inline]
    fn min(self, other: Self) -> Self {
        let chosen = select(other.re - self.re, self, other);
        Self {
            re: self.re.min(other.re),
            eps: chosen,
        }
    }

    #[inline]
    fn max(self, other: Self) -> Self {
        let chosen = select(self.re - other.re, self, other);
        Self {
            re: self.re.max(other.re),
            eps: chosen,
        }
    }

    #[inline]
    fn select_positive(self, if_positive: Self, otherwise: Self) -> Self {
        Self {
            re: self.re.select_positive(if_positive.re, otherwise.re),
            eps: select(self.re, if_positive, otherwise),
        }
    }

    #[inline]
    fn step(self) -> Self {
        Self::constant(self.re.step())
    }

    #[inline]
    fn mul_add(self, a: Self, b: Self) -> Self {
        Self {
            re: self.re.mul_add(a.re, b.re),
            eps: core::array::from_fn(|d| {
                self.re
                    .mul_add(a.eps[d], a.re.mul_add(self.eps[d], b.eps[d]))
            }),
        }
    }
}

/// The derivatives of `if_positive` where `condition > 0`, else those of `otherwise`.
#[inline]
fn select<T: Scalar, const D: usize>(
    condition: T,
    if_positive: Dual<T, D>,
    otherwise: Dual<T, D>,
) -> [T; D] {
    core::array::from_fn(|d| condition.select_positive(if_positive.eps[d], otherwise.eps[d]))
}

#[cfg(test)]
mod tests;
