//! The model's type and its `impl ::dynamics::System`.

use super::Unit;
use super::documentation::Doc;
use super::layout::{Array, Writer};
use crate::emit::axes::inputs;
use crate::model::ConstraintKind;

impl Unit<'_> {
    /// The type, and what makes one.
    pub(super) fn model(&self, w: &mut Writer) {
        let name = &self.type_name;
        w.doc(&Doc::text_or(&self.compiled.model.doc, "The model."));
        w.line("#[derive(Clone, Copy, Debug, PartialEq)]");
        w.block(&format!("pub struct {name}<T> {{"), "}", |w| {
            w.doc(&Doc::of("The values of the model's parameters."));
            w.line("pub parameters: Parameters<T>,");
        });
        w.blank();
        w.block(&format!("impl<T: Scalar> {name}<T> {{"), "}", |w| {
            w.doc(&Doc::of("With the nominal parameters."));
            w.function("pub fn nominal", &[], "Self", |w| {
                w.block("Self {", "}", |w| {
                    w.line("parameters: Parameters::nominal(),")
                });
            });
        });
    }

    /// `impl System<T, n, k, m, s>`.
    pub(super) fn system(&self, w: &mut Writer) {
        let model = &self.compiled.model;
        let (n, k, m) = (
            model.coordinates.len(),
            inputs(model).len(),
            model.constraints.len(),
        );
        let s = model.states.len();
        let name = &self.type_name;
        w.block(
            &format!(
                "impl<T: Scalar> System<T, {n}, {k}, {m}, {s}{}> for {name}<T> {{",
                self.and_positions()
            ),
            "}",
            |w| {
                self.method(
                    w,
                    "mass_matrix",
                    "x",
                    &format!("SMatrix<T, {n}, {n}>"),
                    |w| {
                        w.line("from_rows(&mass_matrix(&self.parameters, x))");
                    },
                );
                w.blank();
                self.method(w, "force", "x", &format!("SVector<T, {n}>"), |w| {
                    w.line("SVector::from(force(&self.parameters, x))");
                });
                w.blank();
                let x = if m == 0 { "_x" } else { "x" };
                self.method(
                    w,
                    "constraint",
                    x,
                    &format!("Constraint<T, {n}, {m}>"),
                    |w| {
                        self.constraint(w, "", "", |name| format!("{name}(&self.parameters, x)"));
                    },
                );
                w.blank();
                self.poses(w);
                if model.uses_multipliers() {
                    w.function(
                        "fn multipliers_at",
                        &["&self".into()],
                        "Option<usize>",
                        |w| {
                            w.line(format!("Some({})", k - m));
                        },
                    );
                    w.blank();
                }
                if s == 0 {
                    self.method(w, "state_rate", "_x", "[T; 0]", |w| w.line("[]"));
                } else {
                    self.method(w, "state_rate", "x", &format!("[T; {s}]"), |w| {
                        w.line("state_rate(&self.parameters, x)");
                    });
                }
                w.blank();
                self.method(w, "equation", "x", &format!("Equation<T, {n}, {m}>"), |w| {
                    w.line("let terms = equation_of_motion(&self.parameters, x);");
                    w.block("Equation {", "}", |w| {
                        w.line("mass_matrix: from_rows(&terms.mass_matrix),");
                        w.line("force: SVector::from(terms.force),");
                        self.constraint(w, "constraint: ", ",", |name| format!("terms.{name}"));
                    });
                });
            },
        );
    }

    /// Where the poses of floating bodies stand, if there are any.
    fn poses(&self, w: &mut Writer) {
        if self.compiled.model.poses.is_empty() {
            return;
        }
        let result = "&'static [::dynamics::Pose]";
        w.function("fn poses", &["&self".into()], result, |w| w.line("&POSES"));
        w.blank();
    }

    fn method(
        &self,
        w: &mut Writer,
        name: &str,
        x: &str,
        result: &str,
        body: impl FnOnce(&mut Writer),
    ) {
        let arguments = ["&self".to_string(), format!("{x}: &{}", self.point())];
        w.function(&format!("fn {name}"), &arguments, result, body);
    }

    /// The value of type `Constraint`; `value` writes where a quantity comes from.
    fn constraint(
        &self,
        w: &mut Writer,
        opening: &str,
        closing: &str,
        value: impl Fn(&str) -> String,
    ) {
        let constraints = &self.compiled.model.constraints;
        if constraints.is_empty() {
            return w.line(format!("{opening}Constraint::none(){closing}"));
        }
        let holonomic = constraints
            .iter()
            .map(|c| (c.kind == ConstraintKind::Holonomic).to_string());
        let holonomic = Array::Row(holonomic.map(Array::Simple).collect());
        w.block(
            &format!("{opening}Constraint {{"),
            &format!("}}{closing}"),
            |w| {
                w.line(format!("a: from_rows(&{}),", value("constraint_jacobian")));
                w.line(format!("b: SVector::from({}),", value("constraint_bias")));
                w.line(format!(
                    "c: SVector::from({}),",
                    value("constraint_residual")
                ));
                w.line(format!(
                    "c_dot: SVector::from({}),",
                    value("constraint_rate")
                ));
                w.array("holonomic: ", &holonomic, ",");
            },
        );
    }
}
