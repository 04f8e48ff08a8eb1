//! The summary as text for people.

use super::{Operations, Summary, Variables};
use crate::page::{Table, count, first_line};
use crate::parameters::{bounds, number};
use dynamics_codegen::dimension::shown_unit;

impl Summary {
    /// As text for people.
    pub fn page(&self) -> String {
        let mut page = format!("{}  {}\n", self.model, self.file);
        for line in self.description.lines() {
            page.push_str(format!("  {line}").trim_end());
            page.push('\n');
        }
        for (title, rows, required) in [
            (
                count(self.positions.len(), "position"),
                variables(&self.positions),
                false,
            ),
            (
                count(self.coordinates.len(), "coordinate"),
                variables(&self.coordinates),
                true,
            ),
            (
                count(self.inputs.len(), "input"),
                variables(&self.inputs),
                true,
            ),
            (
                count(self.parameters.len(), "parameter"),
                self.parameter_rows(),
                true,
            ),
            (
                count(self.constraints.len(), "constraint"),
                self.constraint_rows(),
                true,
            ),
            (
                count(self.contacts.len(), "contact"),
                self.contact_rows(),
                false,
            ),
            (
                count(self.effects.len(), "effect"),
                self.effect_rows(),
                false,
            ),
            (
                count(self.outputs.len(), "output"),
                variables(&self.outputs),
                false,
            ),
            (
                count(self.sensors.len(), "sensor"),
                self.sensor_rows(),
                false,
            ),
            (count(self.tables.len(), "table"), self.table_rows(), false),
            (
                format!("{} of parts", count(self.uses.len(), "use")),
                self.use_rows(),
                false,
            ),
            (
                "operations per state".to_string(),
                self.operations.rows(),
                true,
            ),
        ] {
            let rows = rows.render();
            if required || !rows.is_empty() {
                page.push_str(&format!("\n{title}\n{rows}"));
            }
        }
        page
    }

    fn parameter_rows(&self) -> Table {
        let mut table = Table::new("<><<<<");
        for p in &self.parameters {
            let bounds = bounds(
                p.lower.unwrap_or(f64::NEG_INFINITY),
                p.upper.unwrap_or(f64::INFINITY),
            );
            let bounds = if bounds.is_empty() {
                bounds
            } else {
                format!("in {bounds}")
            };
            let remark = if p.value == p.nominal {
                String::new()
            } else {
                format!("nominal {}", number(p.nominal))
            };
            table.row([
                &p.name,
                &number(p.value),
                &shown_unit(&p.unit),
                &bounds,
                &remark,
                first_line(&p.description),
            ]);
        }
        table
    }

    fn constraint_rows(&self) -> Table {
        let mut table = Table::new("<<<<");
        for c in &self.constraints {
            let time = if c.time_dependent {
                "depends on time"
            } else {
                ""
            };
            table.row([c.name.as_str(), c.kind, time, first_line(&c.description)]);
        }
        table
    }

    fn contact_rows(&self) -> Table {
        let mut table = Table::new("<<<");
        for c in &self.contacts {
            table.row([c.name.as_str(), &c.between, first_line(&c.description)]);
        }
        table
    }

    fn sensor_rows(&self) -> Table {
        let mut table = Table::new("<<<<<<");
        for s in &self.sensors {
            let noise = match s.noise {
                0.0 => String::new(),
                sd => format!("noise {}", number(sd)),
            };
            let stated = |word: &str, value: Option<f64>, unit: &str| {
                value.map_or_else(String::new, |value| {
                    format!("{word} {}{unit}", number(value))
                })
            };
            table.row([
                s.name.as_str(),
                &shown_unit(&s.unit),
                &noise,
                &stated("resolution", s.resolution, ""),
                &stated("rate", s.rate, " Hz"),
                first_line(&s.description),
            ]);
        }
        table
    }

    fn table_rows(&self) -> Table {
        let mut table = Table::new("<<<<");
        for t in &self.tables {
            let arguments = t.arguments.iter().map(|a| {
                let ends = [a.points.first(), a.points.last()];
                let [first, last] = ends.map(|end| end.map_or_else(String::new, |x| number(*x)));
                let range = format!("{} {first}..{last} {}", a.name, shown_unit(&a.unit));
                range.trim_end().to_string()
            });
            let arguments: Vec<String> = arguments.collect();
            table.row([
                format!("{}({})", t.name, arguments.join(", ")).as_str(),
                &shown_unit(&t.unit),
                t.file.as_deref().unwrap_or_default(),
                first_line(&t.description),
            ]);
        }
        table
    }

    fn use_rows(&self) -> Table {
        let mut table = Table::new("<<<");
        for u in &self.uses {
            let given = format!("{}{}", u.part, u.arguments);
            table.row([u.name.as_str(), &given, first_line(&u.description)]);
        }
        table
    }

    fn effect_rows(&self) -> Table {
        let mut table = Table::new("<<<");
        for e in &self.effects {
            let call = format!("{}({})", e.effect, e.on.join(", "));
            let term = e.term.as_ref().map(|term| format!("term {term}"));
            table.row([
                call.as_str(),
                term.as_deref().unwrap_or_default(),
                first_line(&e.description),
            ]);
        }
        table
    }
}

fn variables(variables: &[Variables]) -> Table {
    let mut table = Table::new("<<<");
    for v in variables {
        table.row([
            v.name.as_str(),
            &shown_unit(&v.unit),
            first_line(&v.description),
        ]);
    }
    table
}

impl Operations {
    fn rows(&self) -> Table {
        let mut table = Table::new("<><");
        for (name, count, symbol) in [
            ("mass_matrix", self.mass_matrix, "M"),
            (
                "bias_force",
                self.bias_force,
                "Q_C: fictitious and conservative forces",
            ),
            (
                "applied_force",
                self.applied_force,
                "Q_D: stated forces at zero input",
            ),
            ("input_matrix", self.input_matrix, "B"),
            ("force", self.force, "Q = Q_C + Q_D + B u"),
            ("constraint_jacobian", self.constraint_jacobian, "A"),
            ("constraint_bias", self.constraint_bias, "b"),
            ("constraint_residual", self.constraint_residual, "c"),
            ("constraint_rate", self.constraint_rate, "dc/dt"),
            ("outputs", self.outputs, "outputs"),
            ("dynamics", self.dynamics, "M, Q, A, b together"),
            (
                "derivatives",
                self.derivatives,
                "their derivatives by q, v, u",
            ),
        ] {
            if count > 0 {
                table.row([name, &count.to_string(), symbol]);
            }
        }
        table
    }
}
