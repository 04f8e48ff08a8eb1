//! Functions that solve in loops: calls of the others and of the runtime.

use super::documentation::Doc;
use super::{Unit, result_name};
use crate::derive::{Group, Term};
use crate::emit::axes::inputs;
use crate::emit::plan::{Function, Quantity};
use crate::emit::rust::layout::{Array, Writer};
use crate::emit::solved::{SLOPES, Solved, Unknown, slope_of};

impl Unit<'_> {
    /// The table of which coordinate carries which, if any function solves in loops.
    pub(super) fn carries(&self, w: &mut Writer) {
        if !self.plan.solves() {
            return;
        }
        let n = self.plan.parents.len();
        w.doc(&Doc::of(
            "For each coordinate the one that carries it, or itself.",
        ));
        let parents = self.plan.parents.iter();
        let parents = parents.map(|parent| Array::Simple(parent.to_string()));
        let opening = format!("const PARENTS: [usize; {n}] =");
        w.constant(&opening, &Array::Row(parents.collect()));
        w.blank();
        w.doc(&Doc::of(
            "Which coordinate carries which: where `M` has entries.",
        ));
        w.line(format!(
            "static CARRIES: [[bool; {n}]; {n}] = ::dynamics::linalg::ancestors(PARENTS);"
        ));
        w.blank();
    }

    /// The body: terms, factors, motion, and each group of derivatives.
    pub(super) fn solution(&self, w: &mut Writer, function: &Function, solved: &Solved) {
        let constraints = self.plan.model.constraints.len();
        let own = if solved.constrained { constraints } else { 0 };
        let rows = if own > 0 {
            "&terms.constraint_jacobian"
        } else {
            "&[]"
        };
        let bias = if own > 0 {
            "&terms.constraint_bias"
        } else {
            "&[]"
        };
        let differentiates = !solved.groups.is_empty();
        w.line("let terms = equation_of_motion(p, x);");
        let arguments = ["&terms.mass_matrix", rows, "&CARRIES"].map(String::from);
        w.call(
            "let factors = ",
            "::dynamics::constrained::Branched::new",
            &arguments,
            ";",
        );
        let reads = |unknown| {
            let mut items = function.quantities.iter().filter_map(|q| q.item);
            items.any(|item| item.by.is_none() && Unknown::of(item) == Some(unknown))
        };
        let named = |name: &str, read: bool| {
            if read {
                name.into()
            } else {
                format!("_{name}")
            }
        };
        let a = named("a", differentiates || reads(Unknown::Acceleration));
        let lambda = named(
            "lambda",
            (differentiates && own > 0) || reads(Unknown::Multipliers),
        );
        w.line(format!(
            "let ({a}, {lambda}) = factors.motion(&terms.force, {bias});"
        ));
        if differentiates {
            let lambda = match own {
                0 => format!("[T::zero(); {constraints}]"),
                _ => lambda,
            };
            w.line(format!("let slopes = {SLOPES}(p, x, &a, &{lambda});"));
        }
        for &group in &solved.groups {
            self.group(w, group, own);
        }
        self.answer(w, function);
    }

    /// `let by_position = factors.derivatives(…);`
    fn group(&self, w: &mut Writer, group: Group, constraints: usize) {
        let acceleration = slope_of(Term::AccelerationResidual, group);
        let rows = if constraints == 0 {
            "&[]".to_string()
        } else if self.plan.has_slope(&acceleration) {
            format!("&slopes.{acceleration}")
        } else {
            let columns = inputs(&self.plan.model).len();
            format!("&[[T::zero(); {columns}]; {constraints}]")
        };
        let force = format!("&slopes.{}", slope_of(Term::ForceResidual, group));
        let opening = format!("let by_{} = ", group.name());
        w.call(&opening, "factors.derivatives", &[force, rows], ";");
    }

    fn answer(&self, w: &mut Writer, function: &Function) {
        if !function.fused {
            return w.line(value(&function.quantities[0]));
        }
        w.block(&format!("{} {{", result_name(function)), "}", |w| {
            for quantity in &function.quantities {
                w.line(format!("{}: {},", quantity.name, value(quantity)));
            }
        });
    }
}

/// Where a quantity stands after the solve.
fn value(quantity: &Quantity) -> String {
    let unknown = quantity.item.and_then(Unknown::of);
    let group = quantity.item.and_then(|item| item.by);
    match (group, unknown) {
        (None, Some(Unknown::Multipliers)) => "lambda".to_string(),
        (None, _) => "a".to_string(),
        (Some(group), Some(Unknown::Multipliers)) => format!("by_{}.1", group.name()),
        (Some(group), _) => format!("by_{}.0", group.name()),
    }
}
