//! Forward-mode differentiation and substitution on the graph.

use super::{Binary, ExprId, Graph, Node, SymbolId, Unary};
use std::collections::HashMap;

impl Graph {
    /// `∂ outputs / ∂ symbol`, one tangent sweep. What does not depend on the
    /// symbol has a zero tangent and costs nothing.
    pub fn derivatives(&mut self, outputs: &[ExprId], symbol: SymbolId) -> Vec<ExprId> {
        let one = self.one();
        self.directional(outputs, &[(symbol, one)])
    }

    /// `Σ (∂ outputs / ∂ symbolᵢ) · seedᵢ`: the derivative along a direction
    /// whose entries are themselves expressions, e.g. the time derivative with
    /// seeds `(q, v)`, `(v, a)`, `(t, 1)`.
    pub fn directional(&mut self, outputs: &[ExprId], seeds: &[(SymbolId, ExprId)]) -> Vec<ExprId> {
        let seeds: HashMap<SymbolId, ExprId> = seeds.iter().copied().collect();
        let zero = self.zero();
        let order = self.reachable(outputs);
        let mut tangents = vec![zero; self.len()];
        for expr in order.iter() {
            tangents[expr.index()] = match self.node(expr) {
                Node::Constant(_) => zero,
                Node::Symbol(symbol) => seeds.get(&symbol).copied().unwrap_or(zero),
                Node::Unary(op, x) => self.unary_tangent(op, x, expr, tangents[x.index()]),
                Node::Binary(op, x, y) => {
                    let (dx, dy) = (tangents[x.index()], tangents[y.index()]);
                    self.binary_tangent(op, (x, y), expr, (dx, dy))
                }
            };
        }
        outputs
            .iter()
            .map(|output| tangents[output.index()])
            .collect()
    }

    /// The matrix `∂ outputs / ∂ symbols`, one row per output.
    pub fn jacobian(&mut self, outputs: &[ExprId], symbols: &[SymbolId]) -> Vec<Vec<ExprId>> {
        let columns: Vec<Vec<ExprId>> = symbols
            .iter()
            .map(|&symbol| self.derivatives(outputs, symbol))
            .collect();
        (0..outputs.len())
            .map(|row| columns.iter().map(|column| column[row]).collect())
            .collect()
    }

    /// `outputs` with symbols replaced by expressions.
    pub fn substitute(
        &mut self,
        outputs: &[ExprId],
        replacements: &HashMap<SymbolId, ExprId>,
    ) -> Vec<ExprId> {
        let order = self.reachable(outputs);
        let mut images: HashMap<ExprId, ExprId> = HashMap::new();
        for expr in order.iter() {
            let image = match self.node(expr) {
                Node::Constant(_) => expr,
                Node::Symbol(symbol) => replacements.get(&symbol).copied().unwrap_or(expr),
                Node::Unary(op, x) => {
                    let x = images[&x];
                    self.unary(op, x)
                }
                Node::Binary(op, x, y) => {
                    let (x, y) = (images[&x], images[&y]);
                    self.binary(op, x, y)
                }
            };
            images.insert(expr, image);
        }
        outputs.iter().map(|output| images[output]).collect()
    }

    fn unary_tangent(&mut self, op: Unary, x: ExprId, value: ExprId, dx: ExprId) -> ExprId {
        if self.is_zero(dx) {
            return dx;
        }
        let one = self.one();
        let slope = match op {
            Unary::Neg => return self.neg(dx),
            Unary::Sin => self.unary(Unary::Cos, x),
            Unary::Cos => {
                let sine = self.unary(Unary::Sin, x);
                self.neg(sine)
            }
            Unary::Tan => {
                let square = self.mul(value, value);
                self.add(one, square)
            }
            Unary::Asin | Unary::Acos => {
                let square = self.mul(x, x);
                let inside = self.sub(one, square);
                let root = self.unary(Unary::Sqrt, inside);
                let slope = self.div(one, root);
                if op == Unary::Acos {
                    self.neg(slope)
                } else {
                    slope
                }
            }
            Unary::Atan => {
                let square = self.mul(x, x);
                let below = self.add(one, square);
                self.div(one, below)
            }
            Unary::Exp => value,
            Unary::Ln => return self.div(dx, x),
            Unary::Sqrt => {
                let double = self.scale(2.0, value);
                return self.div(dx, double);
            }
            Unary::Tanh => {
                let square = self.mul(value, value);
                self.sub(one, square)
            }
            Unary::Abs => self.unary(Unary::Sign, x),
            Unary::Sign | Unary::Step => return self.zero(),
        };
        self.mul(slope, dx)
    }

    fn binary_tangent(
        &mut self,
        op: Binary,
        (x, y): (ExprId, ExprId),
        value: ExprId,
        (dx, dy): (ExprId, ExprId),
    ) -> ExprId {
        if self.is_zero(dx) && self.is_zero(dy) {
            return dx;
        }
        match op {
            Binary::Add => self.add(dx, dy),
            Binary::Sub => self.sub(dx, dy),
            Binary::Mul => {
                let left = self.mul(dx, y);
                let right = self.mul(x, dy);
                self.add(left, right)
            }
            Binary::Div => {
                let change = self.mul(value, dy);
                let above = self.sub(dx, change);
                self.div(above, y)
            }
            Binary::Pow => self.pow_tangent((x, y), value, (dx, dy)),
            Binary::Atan2 => {
                let (xx, yy) = (self.mul(x, x), self.mul(y, y));
                let below = self.add(xx, yy);
                let (left, right) = (self.mul(dx, y), self.mul(x, dy));
                let above = self.sub(left, right);
                self.div(above, below)
            }
            Binary::Min | Binary::Max => {
                let gap = if op == Binary::Max {
                    self.sub(x, y)
                } else {
                    self.sub(y, x)
                };
                let first = self.unary(Unary::Step, gap);
                let difference = self.sub(dx, dy);
                let chosen = self.mul(first, difference);
                self.add(chosen, dy)
            }
        }
    }

    fn pow_tangent(
        &mut self,
        (x, y): (ExprId, ExprId),
        value: ExprId,
        (dx, dy): (ExprId, ExprId),
    ) -> ExprId {
        let one = self.one();
        let exponent = self.sub(y, one);
        let power = self.pow(x, exponent);
        let slope = self.mul(y, power);
        let base_part = self.mul(slope, dx);
        if self.is_zero(dy) {
            return base_part;
        }
        let logarithm = self.unary(Unary::Ln, x);
        let growth = self.mul(value, logarithm);
        let exponent_part = self.mul(growth, dy);
        self.add(base_part, exponent_part)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// A random expression of two variables, built from a list of choices.
    fn random_expression(g: &mut Graph, x: ExprId, y: ExprId, choices: &[u8]) -> ExprId {
        let mut stack = vec![x, y];
        for &choice in choices {
            let a = stack[choice as usize % stack.len()];
            let b = stack[(choice as usize / 7) % stack.len()];
            let next = match choice % 11 {
                0 => g.add(a, b),
                1 => g.sub(a, b),
                2 => g.mul(a, b),
                3 => {
                    let square = g.mul(b, b);
                    let one = g.one();
                    let below = g.add(one, square);
                    g.div(a, below)
                }
                4 => g.unary(Unary::Sin, a),
                5 => g.unary(Unary::Cos, a),
                6 => g.unary(Unary::Tanh, a),
                7 => g.unary(Unary::Atan, a),
                8 => g.scale(-0.5, a),
                9 => g.binary(Binary::Atan2, a, b),
                _ => g.neg(a),
            };
            stack.push(next);
        }
        *stack.last().expect("starts with two entries")
    }

    proptest! {
        /// Complex-step-free check: central differences of the plain evaluation.
        #[test]
        fn tangents_agree_with_differences(
            choices in prop::collection::vec(any::<u8>(), 1..25),
            x0 in -1.5f64..1.5, y0 in 0.2f64..1.5,
        ) {
            let mut g = Graph::new();
            let (sx, sy) = (g.symbol("x"), g.symbol("y"));
            let (x, y) = (g.var(sx), g.var(sy));
            let e = random_expression(&mut g, x, y, &choices);
            let slopes = g.derivatives(&[e], sx);
            let exact = g.evaluate(&slopes, &[x0, y0])[0];
            let at = |x: f64| g.evaluate(&[e], &[x, y0])[0];
            let h = 1e-5;
            let difference = (at(x0 + h) - at(x0 - h)) / (2.0 * h);
            let half = (at(x0 + h / 2.0) - at(x0 - h / 2.0)) / h;
            // Skip places where the difference itself has not converged.
            prop_assume!((difference - half).abs() < 1e-6 * (1.0 + exact.abs()));
            prop_assert!((exact - half).abs() < 1e-5 * (1.0 + exact.abs()), "{exact} {half}");
        }
    }
}
