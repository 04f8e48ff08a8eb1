//! `impl ::dynamics::Differentiable` and `::dynamics::ParameterDerivatives`.

use super::Unit;
use super::layout::Writer;
use crate::emit::axes::inputs;

/// Fields of `::dynamics::ResidualDerivatives`, with the quantities they hold.
const FIELDS: [(&str, &str); 7] = [
    ("force_by_position", "force_residual_by_position"),
    ("force_by_velocity", "force_residual_by_velocity"),
    ("force_by_input", "force_residual_by_input"),
    ("force_by_time", "force_residual_by_time"),
    (
        "acceleration_by_position",
        "acceleration_residual_by_position",
    ),
    (
        "acceleration_by_velocity",
        "acceleration_residual_by_velocity",
    ),
    ("acceleration_by_time", "acceleration_residual_by_time"),
];

impl Unit<'_> {
    /// The traits of those functions that are emitted.
    pub(super) fn derivative_traits(&self, w: &mut Writer) {
        if self.has("residual_derivatives") {
            w.blank();
            self.differentiable(w);
        }
        if self.has("residual_by_parameters") {
            w.blank();
            self.parameter_derivatives(w);
        }
    }

    /// Whether a function computes a quantity.
    fn computes(&self, function: &str, quantity: &str) -> bool {
        let functions = self.plan.functions.iter().filter(|f| f.name == function);
        functions
            .flat_map(|f| &f.quantities)
            .any(|q| q.name == quantity)
    }

    fn differentiable(&self, w: &mut Writer) {
        let [n, k, m] = self.lengths();
        let s = self.plan.model.states.len();
        let name = &self.type_name;
        let positions = self.and_positions();
        let of = format!("::dynamics::Differentiable<T, {n}, {k}, {m}, {s}{positions}>");
        let result = format!("::dynamics::ResidualDerivatives<T, {n}, {k}, {m}>");
        w.implementation(&of, &format!("{name}<T>"), |w| {
            let arguments = self.stated(n, m);
            w.function("fn residual_derivatives", &arguments, &result, |w| {
                w.line("let slopes = residual_derivatives(&self.parameters, x, a, lambda);");
                w.block("::dynamics::ResidualDerivatives {", "}", |w| {
                    let (mut there, mut missing) = (Vec::new(), false);
                    for (field, quantity) in FIELDS {
                        if self.computes("residual_derivatives", quantity) {
                            there.push((field, quantity));
                        } else {
                            missing = true;
                        }
                    }
                    for (field, quantity) in there {
                        let value = if field.ends_with("_by_time") {
                            format!("SVector::from(slopes.{quantity})")
                        } else {
                            format!("from_rows(&slopes.{quantity})")
                        };
                        w.line(format!("{field}: {value},"));
                    }
                    if missing {
                        w.line("..::dynamics::ResidualDerivatives::zero()");
                    }
                });
            });
        });
    }

    fn parameter_derivatives(&self, w: &mut Writer) {
        let ([n, k, m], name) = (self.lengths(), &self.type_name);
        let (p, s) = (
            self.plan.model.parameters.len(),
            self.plan.model.states.len(),
        );
        let sizes = format!("{n}, {k}, {m}, {s}, {p}{}", self.and_positions());
        let of = format!("::dynamics::ParameterDerivatives<T, {sizes}>");
        let result = format!("(SMatrix<T, {n}, {p}>, SMatrix<T, {m}, {p}>)");
        w.implementation(&of, &format!("{name}<T>"), |w| {
            let arguments = self.stated(n, m);
            w.function("fn residual_by_parameters", &arguments, &result, |w| {
                w.line("let slopes = residual_by_parameters(&self.parameters, x, a, lambda);");
                w.line("let force = from_rows(&slopes.force_residual_by_parameters);");
                let quantity = "acceleration_residual_by_parameters";
                if self.computes("residual_by_parameters", quantity) {
                    w.line(format!("let acceleration = from_rows(&slopes.{quantity});"));
                } else {
                    w.line("let acceleration = from_rows(&[]);");
                }
                w.line("(force, acceleration)");
            });
        });
    }

    /// Numbers of coordinates, inputs and constraints.
    fn lengths(&self) -> [usize; 3] {
        let model = &self.plan.model;
        [
            model.coordinates.len(),
            inputs(model).len(),
            model.constraints.len(),
        ]
    }

    /// `&self, x, a, lambda`
    fn stated(&self, n: usize, m: usize) -> [String; 4] {
        [
            "&self".to_string(),
            format!("x: &{}", self.point()),
            format!("a: &[T; {n}]"),
            format!("lambda: &[T; {m}]"),
        ]
    }
}
