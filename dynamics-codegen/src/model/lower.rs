//! Syntax trees to graph nodes, with a unit check at every operator.

use super::Coordinate;
use super::builder::Builder;
use super::names::{Binding, FUNCTIONS, Scope, TermState};
use super::quantity::{Measure, Quantity};
use crate::diagnostic::Diagnostic;
use crate::dimension::Dimension;
use crate::graph::{Binary, ExprId, Unary};
use crate::source::Span;
use crate::syntax::{Expr, ExprKind, Name};

/// `None`: the error has been reported.
pub(super) type Lowered = Option<Quantity>;

impl Builder<'_> {
    /// An expression on the graph. `None` if it is wrong; the error is reported.
    pub(super) fn lower(&mut self, expr: &Expr) -> Lowered {
        let quantity = self.lower_kind(expr)?;
        match self.model.graph.as_constant(quantity.expr) {
            Some(value) if !value.is_finite() => {
                let error = Diagnostic::error(expr.span, "this is not a finite number")
                    .label(format!("its value is {value}"));
                self.report(self.with_folding_in_mind(error))
            }
            _ => Some(quantity),
        }
    }

    fn lower_kind(&mut self, expr: &Expr) -> Lowered {
        match &expr.kind {
            ExprKind::Number(value) => {
                let expr = self.model.graph.constant(*value);
                Some(Quantity {
                    expr,
                    measure: Measure::Bare,
                })
            }
            ExprKind::Name(name) => self.lower_name(name, expr.span),
            ExprKind::Negate(inner) => {
                let inner = self.lower(inner)?;
                let expr = self.model.graph.neg(inner.expr);
                Some(Quantity { expr, ..inner })
            }
            ExprKind::Sum(first, rest) => self.lower_sum(first, rest),
            ExprKind::Product(first, rest) => self.lower_product(first, rest),
            ExprKind::Power(base, exponent) => self.lower_power(base, exponent),
            ExprKind::Call(name, arguments) => self.lower_call(name, arguments, expr.span),
            ExprKind::Member(inner, member) => self.lower_member(inner, member),
        }
    }

    /// A `let` or a constant, lowered when first met.
    pub(super) fn lower_term(&mut self, index: usize, name: &str, span: Span) -> Lowered {
        self.resolve_term(index);
        match self.scope.terms[index].state {
            TermState::Done(quantity) => Some(quantity),
            TermState::Lowering => self.report_circle(index, name, span),
            TermState::Waiting | TermState::Failed => None,
        }
    }

    /// Lowers a term and, before it, the terms that it leans on: in a loop, so that a
    /// chain of definitions may be of any length.
    pub(super) fn resolve_term(&mut self, index: usize) {
        let waits =
            |scope: &Scope, index: usize| matches!(scope.terms[index].state, TermState::Waiting);
        if !waits(&self.scope, index) {
            return;
        }
        let outer = self.term_path.len();
        let mut needs = vec![self.begin_term(index)];
        while let (Some(&top), Some(open)) = (self.term_path.last(), needs.last_mut()) {
            if let Some(next) = open.pop() {
                if waits(&self.scope, next) {
                    let more = self.begin_term(next);
                    needs.push(more);
                }
                continue;
            }
            let value = self.scope.terms[top].value.clone();
            // A term stands for the same wherever it is used.
            let member = self.scope.member.take();
            let lowered = self.lower(&value);
            self.scope.member = member;
            let quantity = lowered.and_then(|quantity| self.check_term(top, quantity, &value));
            if let Some(quantity) = quantity {
                let name = &self.scope.terms[top].name.text;
                self.model.graph.label(quantity.expr, name);
            }
            self.scope.terms[top].state = quantity.map_or(TermState::Failed, TermState::Done);
            self.term_path.pop();
            needs.pop();
            if self.term_path.len() == outer {
                return;
            }
        }
    }

    /// Puts a term on the path; returns the terms that it names, last one first.
    fn begin_term(&mut self, index: usize) -> Vec<usize> {
        self.scope.terms[index].state = TermState::Lowering;
        self.term_path.push(index);
        let mut needs = Vec::new();
        self.scope
            .terms_in(&self.scope.terms[index].value, &mut needs);
        needs.reverse();
        needs
    }

    fn report_circle(&mut self, index: usize, name: &str, span: Span) -> Lowered {
        let first = self.term_path.iter().position(|&term| term == index);
        let circle = &self.term_path[first.unwrap_or(0)..];
        let names: Vec<&str> = circle
            .iter()
            .map(|&term| self.scope.terms[term].name.text.as_str())
            .chain([name])
            .collect();
        let mut error = Diagnostic::error(span, format!("`{name}` is defined by itself"))
            .label("the circle closes here");
        if names.len() > 2 {
            error = error.help(format!("each leans on the next: {}", names.join(", ")));
        }
        self.report(error)
    }

    fn check_term(&mut self, index: usize, quantity: Quantity, value: &Expr) -> Lowered {
        let term = &self.scope.terms[index];
        let declared = term.declared;
        if term.constant && self.model.graph.as_constant(quantity.expr).is_none() {
            return self.report(
                Diagnostic::error(
                    value.span,
                    "a constant contains numbers and other constants only",
                )
                .help("use `parameter` for what may vary, `let` for a shared term"),
            );
        }
        let Some(dimension) = declared else {
            return Some(quantity);
        };
        self.expect_dimension(quantity, dimension, value.span, "the declared value")?;
        Some(Quantity {
            measure: Measure::Known(dimension),
            ..quantity
        })
    }

    fn lower_sum(&mut self, first: &Expr, rest: &[(bool, Expr)]) -> Lowered {
        let mut sum = self.lower(first);
        let mut so_far = first.span;
        for (minus, term) in rest {
            let next = self.lower(term);
            sum = match (sum, next) {
                (Some(a), Some(b)) => self.add(a, so_far, b, term.span, *minus),
                _ => None,
            };
            so_far = so_far.to(term.span);
        }
        sum
    }

    fn add(&mut self, a: Quantity, at_a: Span, b: Quantity, at_b: Span, minus: bool) -> Lowered {
        let measure = self.unify(
            a.measure,
            at_a,
            b.measure,
            at_b,
            if minus { "subtracted" } else { "added" },
        )?;
        let graph = &mut self.model.graph;
        let expr = if minus {
            graph.sub(a.expr, b.expr)
        } else {
            graph.add(a.expr, b.expr)
        };
        Some(Quantity { expr, measure })
    }

    /// Both sides of a sum, an equation or a comparison measure the same thing.
    pub(super) fn unify(
        &mut self,
        a: Measure,
        at_a: Span,
        b: Measure,
        at_b: Span,
        done: &str,
    ) -> Option<Measure> {
        if let Some(measure) = a.unify(b) {
            return Some(measure);
        }
        let (a, b) = (a.known().unwrap_or_default(), b.known().unwrap_or_default());
        self.report(
            Diagnostic::error(at_b, format!("`{a}` and `{b}` cannot be {done}"))
                .label(format!("this is in {b}"))
                .also(at_a, format!("this is in {a}")),
        )
    }

    fn lower_product(&mut self, first: &Expr, rest: &[(bool, Expr)]) -> Lowered {
        let mut product = self.lower(first);
        for (divide, factor) in rest {
            let next = self.lower(factor);
            let (Some(a), Some(b)) = (product, next) else {
                product = None;
                continue;
            };
            let graph = &mut self.model.graph;
            if *divide && graph.is_zero(b.expr) {
                let error = Diagnostic::error(factor.span, "division by zero");
                product = self.report(self.with_folding_in_mind(error));
                continue;
            }
            product = Some(if *divide {
                Quantity {
                    expr: graph.div(a.expr, b.expr),
                    measure: a.measure.combine(b.measure, |x, y| x / y),
                }
            } else {
                Quantity {
                    expr: graph.mul(a.expr, b.expr),
                    measure: a.measure.combine(b.measure, |x, y| x * y),
                }
            });
        }
        product
    }

    fn lower_power(&mut self, base: &Expr, exponent: &Expr) -> Lowered {
        let (b, e) = (self.lower(base), self.lower(exponent));
        let (b, e) = (b?, e?);
        self.expect_dimension(e, Dimension::ONE, exponent.span, "an exponent")?;
        let constant = self.model.graph.as_constant(e.expr);
        let measure = match (b.measure, constant) {
            (Measure::Known(dimension), Some(n)) => match dimension.powf(n) {
                Some(power) => Measure::Known(power),
                None => {
                    return self.report(Diagnostic::error(
                        base.span.to(exponent.span),
                        format!("`{dimension}` to the power {n} has no unit"),
                    ));
                }
            },
            (Measure::Known(dimension), None) if dimension != Dimension::ONE => {
                return self.report(
                    Diagnostic::error(base.span, "only a pure number has a variable exponent")
                        .label(format!("this is in {dimension}")),
                );
            }
            (measure, _) => measure,
        };
        Some(Quantity {
            expr: self.model.graph.pow(b.expr, e.expr),
            measure,
        })
    }

    fn lower_call(&mut self, name: &Name, arguments: &[Expr], span: Span) -> Lowered {
        if let Some(table) = self.table_named(&name.text) {
            return self.lower_table(table, arguments, span);
        }
        let Some(&(_, arity)) = FUNCTIONS.iter().find(|(known, _)| *known == name.text) else {
            return self.unknown_function(name);
        };
        if arguments.len() != arity {
            return self.report(Diagnostic::error(
                span,
                format!(
                    "`{}` takes {}, found {}",
                    name.text,
                    if arity == 1 {
                        "one argument"
                    } else {
                        "two arguments"
                    },
                    arguments.len()
                ),
            ));
        }
        match name.text.as_str() {
            "dot" => self.lower_dot(&arguments[0], span),
            "delay" => self.lower_delay(&arguments[0], &arguments[1]),
            "mass" => self.lower_mass(&arguments[0]),
            "norm" => self.lower_norm(&arguments[0], span),
            "multiplier" | "normal_force" | "speed" | "load" => {
                self.lower_contact(&name.text, &arguments[0], span)
            }
            "gap" | "slip_x" | "slip_y" | "slip_z" => {
                self.lower_of_contact(&name.text, &arguments[0], span)
            }
            "encoder_x" | "encoder_y" | "encoder_z" => self.lower_encoder(name, arguments, span),
            "input" | "coordinate" => self.lower_lookup(&name.text, &arguments[0]),
            "atan2" | "min" | "max" => self.lower_two(&name.text, &arguments[0], &arguments[1]),
            function => self.lower_one(function, &arguments[0]),
        }
    }

    /// `input(x)`, `coordinate(x)`: says which of two namesakes is meant.
    fn lower_lookup(&mut self, what: &str, argument: &Expr) -> Lowered {
        let ExprKind::Name(name) = &argument.kind else {
            return self.report(Diagnostic::error(
                argument.span,
                format!("`{what}(…)` takes the name of one {what}"),
            ));
        };
        let found = if what == "input" {
            self.scope
                .inputs
                .get(name)
                .map(|declared| declared.what)
                .map(|i| self.input_symbol(i))
        } else {
            match self.scope.names.get(name).map(|declared| &declared.what) {
                Some(Binding::Coordinate(index)) => Some(self.position(*index)),
                _ => None,
            }
        };
        match found {
            Some(quantity) => quantity,
            None if self.scope.is_unreadable(name) => None,
            None => self.report(Diagnostic::error(
                argument.span,
                format!("there is no {what} named `{name}`"),
            )),
        }
    }

    /// `d/dt` along the motion: `q → v`, `t → 1`.
    fn lower_dot(&mut self, argument: &Expr, span: Span) -> Lowered {
        if let Some(speed) = self.lower_shaft_speed(argument)? {
            return Some(speed);
        }
        let inner = self.lower(argument)?;
        let mut coordinates = self.model.coordinates.iter();
        let same = |c: &&Coordinate| self.model.graph.var(c.position) == inner.expr;
        if let Some(coordinate) = coordinates.find(same) {
            let expr = self.model.graph.var(coordinate.velocity);
            let measure = inner.measure.rate();
            return Some(Quantity { expr, measure });
        }
        if let Some(rate) = self.rate_of_reading(inner, span)? {
            return Some(rate);
        }
        self.refuse_rate_of_multiplier(inner.expr, span)?;
        if self.in_sensor && self.model.is_momentary(inner.expr) {
            return self.lower_acceleration(inner, span);
        }
        for index in 0..self.model.coordinates.len() {
            let velocity = self.model.coordinates[index].velocity;
            if self.model.graph.depends_on(&[inner.expr], velocity) {
                let name = &self.model.coordinates[index].name;
                let message = match self.model.pose_of(index) {
                    Some(_) => format!("`dot` of something that already contains `{name}`"),
                    None => format!("`dot` of something that already contains `dot({name})`"),
                };
                return self.report(Diagnostic::error(span, message).label("an acceleration").help(
                    "energies, forces and constraints depend on positions and velocities only",
                ));
            }
        }
        if self.model.contains_velocity(inner.expr) {
            let message = "`dot` of something that already contains a velocity";
            return self.report(Diagnostic::error(span, message).label("an acceleration"));
        }
        self.refuse_rate_of_input(inner.expr, span)?;
        let seeds = self.model.time_seeds();
        let expr = self.model.graph.directional(&[inner.expr], &seeds)[0];
        if let ExprKind::Name(name) = &argument.kind {
            self.model.graph.label(expr, &format!("dot_{name}"));
        }
        let measure = inner.measure.rate();
        Some(Quantity { expr, measure })
    }

    /// What is commanded, what was and what is remembered have no rate in an expression.
    pub(super) fn refuse_rate_of_input(&mut self, expr: ExprId, span: Span) -> Option<()> {
        let graph = &self.model.graph;
        let mut inputs = self.model.inputs.iter();
        if let Some(input) = inputs.find(|u| graph.depends_on(&[expr], u.symbol)) {
            let name = &input.name;
            let message = format!("`dot` of something that contains the input `{name}`");
            return self.report(
                Diagnostic::error(span, message).help("the rate of an input is not known"),
            );
        }
        self.refuse_memory(expr, span, "the argument of `dot`")
    }

    fn lower_two(&mut self, function: &str, x: &Expr, y: &Expr) -> Lowered {
        let (a, b) = (self.lower(x), self.lower(y));
        let (a, b) = (a?, b?);
        let measure = self.unify(a.measure, x.span, b.measure, y.span, "compared")?;
        let (op, measure) = match function {
            "atan2" => (Binary::Atan2, Measure::Known(Dimension::ANGLE)),
            "min" => (Binary::Min, measure),
            _ => (Binary::Max, measure),
        };
        Some(Quantity {
            expr: self.model.graph.binary(op, a.expr, b.expr),
            measure,
        })
    }

    fn lower_one(&mut self, function: &str, argument: &Expr) -> Lowered {
        let x = self.lower(argument)?;
        let graph = &mut self.model.graph;
        let any_unit = match function {
            "abs" => Some((Unary::Abs, x.measure)),
            "sign" => Some((Unary::Sign, Measure::Known(Dimension::ONE))),
            "step" => Some((Unary::Step, Measure::Known(Dimension::ONE))),
            "sqrt" => match x.measure {
                Measure::Known(dimension) => dimension
                    .powf(0.5)
                    .map(|d| (Unary::Sqrt, Measure::Known(d))),
                other => Some((Unary::Sqrt, other)),
            },
            _ => None,
        };
        if let Some((op, measure)) = any_unit {
            return Some(Quantity {
                expr: graph.unary(op, x.expr),
                measure,
            });
        }
        self.expect_dimension(
            x,
            Dimension::ONE,
            argument.span,
            &format!("the argument of `{function}`"),
        )?;
        let expr = self.elementary(function, x);
        Some(Quantity {
            expr,
            measure: match (x.measure, function) {
                (Measure::Bare, _) => Measure::Bare,
                (_, "asin" | "acos" | "atan") => Measure::Known(Dimension::ANGLE),
                _ => Measure::Known(Dimension::ONE),
            },
        })
    }

    fn elementary(&mut self, function: &str, x: Quantity) -> ExprId {
        let graph = &mut self.model.graph;
        let op = match function {
            "sin" => Unary::Sin,
            "cos" => Unary::Cos,
            "tan" => Unary::Tan,
            "asin" => Unary::Asin,
            "acos" => Unary::Acos,
            "atan" => Unary::Atan,
            "exp" => Unary::Exp,
            "ln" => Unary::Ln,
            "tanh" => Unary::Tanh,
            // sinh and cosh, from exponentials.
            _ => {
                let rise = graph.unary(Unary::Exp, x.expr);
                let minus = graph.neg(x.expr);
                let fall = graph.unary(Unary::Exp, minus);
                let twice = if function == "sinh" {
                    graph.sub(rise, fall)
                } else {
                    graph.add(rise, fall)
                };
                return graph.scale(0.5, twice);
            }
        };
        graph.unary(op, x.expr)
    }

    /// Reports `quantity` unless it measures `expected`.
    pub(super) fn expect_dimension(
        &mut self,
        quantity: Quantity,
        expected: Dimension,
        span: Span,
        role: &str,
    ) -> Option<()> {
        match quantity.measure {
            Measure::Known(found) if found != expected => {
                let expected = if expected == Dimension::ONE {
                    "a pure number".to_string()
                } else {
                    format!("in `{expected}`")
                };
                self.report(
                    Diagnostic::error(span, format!("{role} must be {expected}, found `{found}`"))
                        .label(format!("this is in {found}")),
                )
            }
            _ => Some(()),
        }
    }
}
