//! Constructors that simplify on the spot.
//!
//! The rules are directional and local, so building never loops and never
//! multiplies terms out (flattening a recursion into sums of products makes it
//! several times larger):
//!
//! * constants are folded; `0`, `1` and `-1` disappear;
//! * signs move outwards: `(-x)·y = -(x·y)`, `x + (-y) = x - y`;
//! * constant factors meet: `(c·x)·(d·y) = (c·d)·(x·y)`, `c·x + d·x = (c+d)·x`;
//! * arguments of commutative operations are ordered, constants first;
//! * `sin²x + cos²x = 1`, also with one common factor.

use super::{Binary, ExprId, Graph, Node, Unary};

impl Graph {
    /// The constant `value`. Negative zero becomes zero.
    pub fn constant(&mut self, value: f64) -> ExprId {
        let value = if value == 0.0 { 0.0 } else { value };
        self.intern(Node::Constant(value.to_bits()))
    }

    /// The constant zero.
    pub fn zero(&mut self) -> ExprId {
        self.constant(0.0)
    }

    /// The constant one.
    pub fn one(&mut self) -> ExprId {
        self.constant(1.0)
    }

    /// `-x`
    pub fn neg(&mut self, x: ExprId) -> ExprId {
        match self.node(x) {
            Node::Constant(bits) => self.constant(-f64::from_bits(bits)),
            Node::Unary(Unary::Neg, inner) => inner,
            // What has a name of its own keeps it.
            Node::Binary(Binary::Sub, a, b) if self.call_of(x).is_none() => self.sub(b, a),
            _ => match self.split_factor(x) {
                (factor, rest) if factor != 1.0 => self.scale(-factor, rest),
                _ => self.intern(Node::Unary(Unary::Neg, x)),
            },
        }
    }

    /// `x + y`
    pub fn add(&mut self, x: ExprId, y: ExprId) -> ExprId {
        if self.is_zero(x) {
            return y;
        }
        if self.is_zero(y) {
            return x;
        }
        if let (Some(a), Some(b)) = (self.as_constant(x), self.as_constant(y)) {
            return self.constant(a + b);
        }
        if let Node::Unary(Unary::Neg, inner) = self.node(y) {
            return self.sub(x, inner);
        }
        if let Node::Unary(Unary::Neg, inner) = self.node(x) {
            return self.sub(y, inner);
        }
        if let Some(merged) = self.merge_like_terms(x, y, 1.0) {
            return merged;
        }
        if let Some(merged) = self.merge_pythagoras(x, y) {
            return merged;
        }
        self.commutative(Binary::Add, x, y)
    }

    /// `x - y`
    pub fn sub(&mut self, x: ExprId, y: ExprId) -> ExprId {
        if self.is_zero(y) {
            return x;
        }
        if self.is_zero(x) {
            return self.neg(y);
        }
        if let (Some(a), Some(b)) = (self.as_constant(x), self.as_constant(y)) {
            return self.constant(a - b);
        }
        if let Node::Unary(Unary::Neg, inner) = self.node(y) {
            return self.add(x, inner);
        }
        if let Node::Unary(Unary::Neg, inner) = self.node(x) {
            let sum = self.add(inner, y);
            return self.neg(sum);
        }
        if let Some(merged) = self.merge_like_terms(x, y, -1.0) {
            return merged;
        }
        // (a + b) - a = b: the pieces of a sum that a caller takes back.
        if let Node::Binary(Binary::Add, a, b) = self.node(x) {
            if a == y {
                return b;
            }
            if b == y {
                return a;
            }
        }
        self.intern(Node::Binary(Binary::Sub, x, y))
    }

    /// `x · y`
    pub fn mul(&mut self, x: ExprId, y: ExprId) -> ExprId {
        if self.is_zero(x) || self.is_zero(y) {
            return self.zero();
        }
        let (sign_x, x) = self.split_sign(x);
        let (sign_y, y) = self.split_sign(y);
        let product = self.mul_unsigned(x, y);
        if sign_x * sign_y < 0.0 {
            self.neg(product)
        } else {
            product
        }
    }

    fn mul_unsigned(&mut self, x: ExprId, y: ExprId) -> ExprId {
        match (self.as_constant(x), self.as_constant(y)) {
            (Some(a), Some(b)) => return self.constant(a * b),
            (Some(a), None) => return self.scale(a, y),
            (None, Some(b)) => return self.scale(b, x),
            (None, None) => {}
        }
        let (c, a) = self.split_factor(x);
        let (d, b) = self.split_factor(y);
        if c != 1.0 && d != 1.0 {
            let product = self.mul(a, b);
            return self.scale(c * d, product);
        }
        if let Some(quotient) = self.mul_quotients(x, y) {
            return quotient;
        }
        if let (Node::Unary(Unary::Sqrt, inner), true) = (self.node(x), x == y) {
            return inner;
        }
        self.commutative(Binary::Mul, x, y)
    }

    /// `(a/b)·b = a`.
    fn mul_quotients(&mut self, x: ExprId, y: ExprId) -> Option<ExprId> {
        match (self.node(x), self.node(y)) {
            (Node::Binary(Binary::Div, a, b), _) if b == y => Some(a),
            (_, Node::Binary(Binary::Div, a, b)) if b == x => Some(a),
            _ => None,
        }
    }

    /// `c · x` with a constant `c`.
    pub fn scale(&mut self, c: f64, x: ExprId) -> ExprId {
        if c == 0.0 {
            return self.zero();
        }
        if let Some(value) = self.as_constant(x) {
            return self.constant(c * value);
        }
        let (factor, rest) = self.split_factor(x);
        let total = c * factor;
        if total == 1.0 {
            rest
        } else if total == -1.0 {
            self.intern_negated(rest)
        } else {
            let total = self.constant(total);
            self.intern(Node::Binary(Binary::Mul, total, rest))
        }
    }

    /// `-x` for an `x` that carries no constant factor.
    fn intern_negated(&mut self, x: ExprId) -> ExprId {
        match self.node(x) {
            Node::Binary(Binary::Sub, a, b) if self.call_of(x).is_none() => self.sub(b, a),
            _ => self.intern(Node::Unary(Unary::Neg, x)),
        }
    }

    /// `x / y`. Division by the constant zero is kept: it is the caller's to report.
    pub fn div(&mut self, x: ExprId, y: ExprId) -> ExprId {
        if let Some(d) = self.as_constant(y) {
            if d == 1.0 {
                return x;
            }
            if let Some(n) = self.as_constant(x) {
                return self.constant(n / d);
            }
            if d != 0.0 && d.is_normal() {
                return self.scale(1.0 / d, x);
            }
        }
        if self.is_zero(x) {
            return x;
        }
        if x == y {
            return self.one();
        }
        let (sign_x, x) = self.split_sign(x);
        let (sign_y, y) = self.split_sign(y);
        let (c, a) = self.split_factor(x);
        let (d, b) = self.split_factor(y);
        let core = match self.node(a) {
            Node::Binary(Binary::Mul, p, q) if p == b => q,
            Node::Binary(Binary::Mul, p, q) if q == b => p,
            _ if a == b => self.one(),
            _ => self.intern(Node::Binary(Binary::Div, a, b)),
        };
        let quotient = self.scale(c / d, core);
        if sign_x * sign_y < 0.0 {
            self.neg(quotient)
        } else {
            quotient
        }
    }

    /// `x^n` for an integer, by repeated squaring.
    pub fn powi(&mut self, x: ExprId, n: i32) -> ExprId {
        if n < 0 {
            let positive = self.powi(x, -n);
            let one = self.one();
            return self.div(one, positive);
        }
        let mut result = self.one();
        let mut square = x;
        let mut rest = n;
        while rest > 0 {
            if rest & 1 == 1 {
                result = self.mul(result, square);
            }
            rest >>= 1;
            if rest > 0 {
                square = self.mul(square, square);
            }
        }
        result
    }

    /// `x^y`. Small integer exponents become products, one half a square root.
    pub fn pow(&mut self, x: ExprId, y: ExprId) -> ExprId {
        if let Some(exponent) = self.as_constant(y) {
            if exponent.fract() == 0.0 && exponent.abs() <= 16.0 {
                return self.powi(x, exponent as i32);
            }
            if exponent == 0.5 {
                return self.unary(Unary::Sqrt, x);
            }
            if let Some(base) = self.as_constant(x) {
                return self.constant(base.powf(exponent));
            }
        }
        self.intern(Node::Binary(Binary::Pow, x, y))
    }

    /// A function of one argument.
    pub fn unary(&mut self, op: Unary, x: ExprId) -> ExprId {
        if op == Unary::Neg {
            return self.neg(x);
        }
        if let Some(value) = self.as_constant(x) {
            return self.constant(op.apply(value));
        }
        // Odd and even functions give their argument's sign away.
        let (sign, inner) = self.split_sign(x);
        if sign < 0.0 {
            match op {
                Unary::Cos | Unary::Abs => return self.unary(op, inner),
                Unary::Sin | Unary::Tan | Unary::Asin | Unary::Atan | Unary::Tanh | Unary::Sign => {
                    let positive = self.unary(op, inner);
                    return self.neg(positive);
                }
                _ => {}
            }
        }
        self.intern(Node::Unary(op, x))
    }

    /// A function of two arguments.
    pub fn binary(&mut self, op: Binary, x: ExprId, y: ExprId) -> ExprId {
        match op {
            Binary::Add => self.add(x, y),
            Binary::Sub => self.sub(x, y),
            Binary::Mul => self.mul(x, y),
            Binary::Div => self.div(x, y),
            Binary::Pow => self.pow(x, y),
            Binary::Min | Binary::Max if x == y => x,
            _ => match (self.as_constant(x), self.as_constant(y)) {
                (Some(a), Some(b)) => self.constant(op.apply(a, b)),
                _ if op.is_commutative() => self.commutative(op, x, y),
                _ => self.intern(Node::Binary(op, x, y)),
            },
        }
    }

    /// `Σ terms`, added from the left.
    pub fn sum(&mut self, terms: impl IntoIterator<Item = ExprId>) -> ExprId {
        let mut total = self.zero();
        for term in terms {
            total = self.add(total, term);
        }
        total
    }

    /// `Σ xᵢ yᵢ`
    pub fn inner_product(&mut self, x: &[ExprId], y: &[ExprId]) -> ExprId {
        let mut total = self.zero();
        for (&a, &b) in x.iter().zip(y) {
            let product = self.mul(a, b);
            total = self.add(total, product);
        }
        total
    }

    fn commutative(&mut self, op: Binary, x: ExprId, y: ExprId) -> ExprId {
        let constant_first =
            (self.as_constant(x).is_none(), x) > (self.as_constant(y).is_none(), y);
        let (x, y) = if constant_first { (y, x) } else { (x, y) };
        self.intern(Node::Binary(op, x, y))
    }

    /// `x = sign · rest`, with `rest` free of an outer minus sign.
    fn split_sign(&mut self, x: ExprId) -> (f64, ExprId) {
        match self.node(x) {
            Node::Unary(Unary::Neg, inner) => (-1.0, inner),
            Node::Constant(bits) if f64::from_bits(bits) < 0.0 => {
                (-1.0, self.constant(-f64::from_bits(bits)))
            }
            Node::Binary(Binary::Mul, c, rest) => match self.as_constant(c) {
                Some(value) if value < 0.0 => (-1.0, self.scale(-value, rest)),
                _ => (1.0, x),
            },
            _ => (1.0, x),
        }
    }

    /// `x = factor · rest`, with `rest` free of an outer constant factor.
    fn split_factor(&self, x: ExprId) -> (f64, ExprId) {
        match self.node(x) {
            Node::Unary(Unary::Neg, inner) => (-1.0, inner),
            Node::Binary(Binary::Mul, c, rest) => match self.as_constant(c) {
                Some(value) => (value, rest),
                None => (1.0, x),
            },
            _ => (1.0, x),
        }
    }

    /// `c·r ± d·r = (c ± d)·r`.
    fn merge_like_terms(&mut self, x: ExprId, y: ExprId, sign: f64) -> Option<ExprId> {
        let (c, a) = self.split_factor(x);
        let (d, b) = self.split_factor(y);
        (a == b && self.as_constant(a).is_none()).then(|| self.scale(c + sign * d, a))
    }

    /// `k·sin²x + k·cos²x = k`.
    fn merge_pythagoras(&mut self, x: ExprId, y: ExprId) -> Option<ExprId> {
        let (factor_x, square_x) = self.split_square(x)?;
        let (factor_y, square_y) = self.split_square(y)?;
        let angles = match (self.node(square_x), self.node(square_y)) {
            (Node::Unary(Unary::Sin, a), Node::Unary(Unary::Cos, b))
            | (Node::Unary(Unary::Cos, a), Node::Unary(Unary::Sin, b)) => Some((a, b)),
            _ => None,
        };
        let (a, b) = angles?;
        (a == b && factor_x == factor_y).then_some(factor_x)
    }

    /// `x = factor · root²`, if that can be read off the outermost product.
    fn split_square(&mut self, x: ExprId) -> Option<(ExprId, ExprId)> {
        let Node::Binary(Binary::Mul, a, b) = self.node(x) else {
            return None;
        };
        if a == b {
            return Some((self.one(), a));
        }
        for (factor, other) in [(a, b), (b, a)] {
            if let Node::Binary(Binary::Mul, c, d) = self.node(other)
                && c == d
            {
                return Some((factor, c));
            }
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn xy() -> (Graph, ExprId, ExprId) {
        let mut g = Graph::new();
        let x = g.symbol("x");
        let y = g.symbol("y");
        let (x, y) = (g.var(x), g.var(y));
        (g, x, y)
    }

    #[test]
    fn zeros_and_ones_disappear() {
        let (mut g, x, _) = xy();
        let (zero, one) = (g.zero(), g.one());
        assert_eq!(g.add(x, zero), x);
        assert_eq!(g.mul(one, x), x);
        assert_eq!(g.mul(x, zero), zero);
        assert_eq!(g.sub(x, x), zero);
        assert_eq!(g.div(x, x), one);
    }

    #[test]
    fn order_of_commutative_arguments_does_not_matter() {
        let (mut g, x, y) = xy();
        assert_eq!(g.add(x, y), g.add(y, x));
        assert_eq!(g.mul(x, y), g.mul(y, x));
    }

    #[test]
    fn signs_move_outwards() {
        let (mut g, x, y) = xy();
        let minus_x = g.neg(x);
        let product = g.mul(x, y);
        let expected = g.neg(product);
        assert_eq!(g.mul(minus_x, y), expected);
        let difference = g.sub(y, x);
        assert_eq!(g.add(minus_x, y), difference);
        let back = g.sub(x, y);
        assert_eq!(g.neg(difference), back);
    }

    #[test]
    fn half_of_a_square_differentiates_without_a_factor() {
        let (mut g, x, m) = xy();
        let square = g.mul(x, x);
        let half = g.scale(0.5, m);
        let energy = g.mul(half, square);
        let Node::Symbol(symbol) = g.node(x) else {
            unreachable!()
        };
        let momentum = g.derivatives(&[energy], symbol)[0];
        assert_eq!(momentum, g.mul(m, x));
    }

    #[test]
    fn pythagoras_with_a_common_factor() {
        let (mut g, x, k) = xy();
        let (s, c) = (g.unary(Unary::Sin, x), g.unary(Unary::Cos, x));
        let (s2, c2) = (g.mul(s, s), g.mul(c, c));
        let (ks2, kc2) = (g.mul(k, s2), g.mul(k, c2));
        assert_eq!(g.add(ks2, kc2), k);
        assert_eq!(g.add(c2, s2), g.one());
    }
}
