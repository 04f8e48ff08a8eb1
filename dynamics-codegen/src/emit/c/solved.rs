//! Functions that solve in loops: calls of the others and of the static ones.

use super::{Lines, Unit};
use crate::derive::{Group, Term};
use crate::emit::axes::inputs;
use crate::emit::plan::{Function, Quantity};
use crate::emit::solved::{SLOPES, Solved, Unknown, slope_of};

impl Unit<'_> {
    /// The whole function.
    pub(super) fn solved_definition(&self, w: &mut Lines, function: &Function, solved: &Solved) {
        let holds = solved.constrained;
        let (kind, free) = if holds {
            ("held", "w.free")
        } else {
            ("motion", "w")
        };
        let prefix = &self.prefix;
        self.signature(w, function, "");
        w.line("{");
        w.line(&format!("    {prefix}_{kind} w;"));
        let differentiates = !solved.groups.is_empty();
        if differentiates {
            w.line(&format!("    {prefix}_{SLOPES}_result slopes;"));
        }
        let constraints = self.plan.model.constraints.len();
        if differentiates && constraints > 0 && !holds {
            w.line(&format!(
                "    const {prefix}_real lambda[{constraints}] = {{REAL(0.0)}};"
            ));
        }
        for &group in solved
            .groups
            .iter()
            .filter(|&&group| holds && !self.moves_rows(group))
        {
            let (name, columns) = (group.name(), self.columns(group));
            let zeros = format!("rows_by_{name}[{constraints}][{columns}] = {{{{REAL(0.0)}}}}");
            w.line(&format!("    {prefix}_real {zeros};"));
        }
        let how = if holds { "held" } else { "freely" };
        w.line(&format!("    {prefix}_move_{how}(p, x, &w);"));
        if differentiates {
            let lambda = match (constraints, holds) {
                (0, _) => "",
                (_, true) => " w.lambda,",
                (_, false) => " lambda,",
            };
            w.line(&format!(
                "    {prefix}_{SLOPES}(p, x, {free}.a,{lambda} &slopes);"
            ));
        }
        for &group in &solved.groups {
            self.solve_group(w, group, (holds, free));
        }
        for quantity in &function.quantities {
            self.take(w, function, quantity, free);
        }
        w.line("}");
        w.blank();
    }

    /// Whether the rows of the constraints change with a group.
    fn moves_rows(&self, group: Group) -> bool {
        self.plan
            .has_slope(&slope_of(Term::AccelerationResidual, group))
    }

    fn columns(&self, group: Group) -> usize {
        match group {
            Group::Input => inputs(&self.plan.model).len(),
            _ => self.plan.model.coordinates.len(),
        }
    }

    /// Where the derivatives of `R` and of `S` stand, and later the negative solution.
    fn places(&self, group: Group) -> [String; 2] {
        let slope = |term| format!("&slopes.{}[0][0]", slope_of(term, group));
        let rows = if self.moves_rows(group) {
            slope(Term::AccelerationResidual)
        } else {
            format!("&rows_by_{}[0][0]", group.name())
        };
        [slope(Term::ForceResidual), rows]
    }

    fn solve_group(&self, w: &mut Lines, group: Group, (holds, free): (bool, &str)) {
        let (prefix, n, columns) = (
            &self.prefix,
            self.plan.model.coordinates.len(),
            self.columns(group),
        );
        let [force, rows] = self.places(group);
        let factors = format!("&{free}.terms.mass_matrix[0][0], {free}.inverse");
        w.line(&format!(
            "    {prefix}_divide({n}, {prefix}_parents, {factors}, {columns}, {force});"
        ));
        if holds {
            w.line(&format!(
                "    {prefix}_hold(&w, {columns}, {force}, {rows});"
            ));
        }
    }

    /// Copies a quantity out of the solution.
    fn take(&self, w: &mut Lines, function: &Function, quantity: &Quantity, free: &str) {
        let field = match function.fused {
            true => format!("out->{}", quantity.name),
            false => "out".to_string(),
        };
        let unknown = quantity.item.and_then(Unknown::of);
        let multipliers = unknown == Some(Unknown::Multipliers);
        let (sign, from, to) = match quantity.item.and_then(|item| item.by) {
            None if multipliers => ("1.0", "w.lambda".to_string(), field),
            None => ("1.0", format!("{free}.a"), field),
            Some(group) => {
                let [force, rows] = self.places(group);
                let from = if multipliers { rows } else { force };
                ("-1.0", from, format!("&{field}[0][0]"))
            }
        };
        let (prefix, length) = (&self.prefix, quantity.len());
        w.line(&format!(
            "    {prefix}_scale({length}, REAL({sign}), {from}, {to});"
        ));
    }
}
