//! The review sheet: what a model is, on a page that is read when it changes.

use super::axes::{coordinate_unit, positions, text};
use super::counts;
use super::emission::Emission;
use super::text::{decimal, one_line, plain_lines};
use crate::compile::Compiled;
use crate::dimension::shown_unit;
use crate::graph::{Binary, ExprId, Graph, Node, SymbolId};
use crate::model::{ConstraintKind, Model, Parameter};
use std::collections::{BTreeSet, HashMap};
use std::fmt::Write as _;

/// Coordinates, inputs, parameters, energies and forces, constraints as derived,
/// outputs, effects with their provenance, operation counts and code size of a model,
/// as plain text. `source_name` is the model's path.
pub fn review(compiled: &Compiled, source_name: &str) -> String {
    Emission::terms(compiled, source_name).review()
}

impl Emission<'_> {
    /// The review sheet; see [`review`].
    pub fn review(&self) -> String {
        let sheet = Sheet::new(self);
        let mut out = String::new();
        // Writing into a string cannot fail.
        let _ = sheet.write(&mut out, self.source_name);
        out
    }
}

/// More operations than this are not written out; a table is one.
const LONG: usize = 60;

/// What tables are computed with, and which: it shows where a table is not read but its slope is.
fn insides(graph: &Graph) -> HashMap<ExprId, String> {
    let mut insides = HashMap::new();
    for (expr, call) in graph.calls() {
        let computed = graph.reachable_beyond(&[expr], |part| call.arguments.contains(&part));
        for part in computed.iter() {
            // The distance from a point on: nobody else writes that.
            if matches!(graph.node(part), Node::Binary(Binary::Max, ..)) {
                insides.insert(part, call.name.clone());
            }
        }
    }
    insides
}

struct Sheet<'a> {
    emission: &'a Emission<'a>,
    compiled: &'a Compiled,
    model: &'a Model,
    names: HashMap<SymbolId, String>,
    insides: HashMap<ExprId, String>,
}

impl<'a> Sheet<'a> {
    fn new(emission: &'a Emission<'a>) -> Self {
        let compiled = emission.compiled;
        let model = &compiled.model;
        let mut names = HashMap::from([(model.time, "t".to_string())]);
        for c in &model.coordinates {
            names.insert(c.position, one_line(&c.name));
            names.insert(c.velocity, format!("dot({})", one_line(&c.name)));
        }
        for (index, c) in model.coordinates.iter().enumerate() {
            if model.pose_of(index).is_some() {
                names.insert(c.velocity, one_line(&c.name));
            }
        }
        for p in model.positions() {
            names.insert(p.symbol, one_line(&p.name));
        }
        for u in &model.inputs {
            names.insert(u.symbol, format!("input({})", one_line(&u.name)));
        }
        for d in &model.delays {
            let of = one_line(&model.inputs[d.input].name);
            let own = |id| one_line(model.graph.symbol_name(id));
            let by = model.graph.display(d.by, own);
            names.insert(d.symbol, format!("delay({of}, {by})"));
        }
        for z in &model.states {
            names.insert(z.symbol, one_line(&z.name));
        }
        for p in &model.parameters {
            names.insert(p.symbol, one_line(&p.name));
        }
        for c in &model.constraints {
            names.insert(c.multiplier, format!("multiplier({})", one_line(&c.name)));
        }
        for (c, &a) in model.coordinates.iter().zip(&model.accelerations) {
            names.insert(a, format!("dot(dot({}))", one_line(&c.name)));
        }
        for k in &model.kinematics {
            names.insert(k.symbol, one_line(model.graph.symbol_name(k.symbol)));
        }
        Self {
            emission,
            compiled,
            model,
            names,
            insides: insides(&model.graph),
        }
    }

    fn expression(&self, expr: ExprId) -> String {
        let name = |id| {
            self.names
                .get(&id)
                .cloned()
                .unwrap_or_else(|| "?".to_string())
        };
        self.model.graph.display(expr, name).to_string()
    }

    /// What is derived: the expression if it fits on a few lines and the model has words for it,
    /// else how long it is.
    fn short(&self, expr: ExprId) -> String {
        let graph = &self.model.graph;
        let shown = graph.displayed(expr);
        let inside = shown.iter().filter_map(|part| self.insides.get(part));
        let tables: BTreeSet<String> = inside.map(|name| format!("`{}`", one_line(name))).collect();
        let operations = graph.operation_count(&[expr]);
        if !tables.is_empty() {
            let tables: Vec<String> = tables.into_iter().collect();
            format!(
                "({operations} operations, with slopes of {})",
                tables.join(", ")
            )
        } else if shown
            .iter()
            .filter(|&&part| graph.node(part).is_operation())
            .count()
            > LONG
        {
            format!("({operations} operations, too long to write out)")
        } else {
            self.expression(expr)
        }
    }

    fn write(&self, out: &mut String, source_name: &str) -> std::fmt::Result {
        writeln!(
            out,
            "model {} ({})",
            one_line(&self.model.name),
            one_line(source_name)
        )?;
        paragraph(out, &self.model.doc)?;
        self.arguments(out)?;
        self.states(out)?;
        self.parameters(out)?;
        super::review_bodies::bodies(out, self.model)?;
        self.dynamics(out)?;
        self.constraints(out)?;
        self.contacts(out)?;
        self.outputs(out)?;
        self.sensors(out)?;
        self.effects(out)?;
        self.tables(out)?;
        self.uses(out)?;
        self.size(out)
    }

    fn arguments(&self, out: &mut String) -> std::fmt::Result {
        self.moving(out)?;
        heading(out, "inputs", self.model.inputs.len())?;
        let mut rows = Vec::new();
        for u in &self.model.inputs {
            let arrives = self.expression(u.arrives);
            let direct = arrives == self.names[&u.symbol];
            let note = if direct {
                String::new()
            } else {
                format!("arrives as {arrives}")
            };
            let doc = [note, one_line(&u.doc)]
                .into_iter()
                .filter(|s| !s.is_empty());
            rows.push([
                one_line(&u.name),
                shown_unit(&u.unit),
                doc.collect::<Vec<_>>().join("; "),
            ]);
        }
        columns(out, &rows)
    }

    /// Coordinates; where bodies float by their twists, positions and velocities.
    fn moving(&self, out: &mut String) -> std::fmt::Result {
        let order = if self.model.poses.is_empty() {
            heading(out, "coordinates", self.model.coordinates.len())?;
            0
        } else {
            let positions = positions(self.model, 0);
            heading(out, "positions", positions.len())?;
            let rows = positions
                .iter()
                .map(|p| [one_line(&p.name), p.unit.clone()]);
            columns(out, &rows.collect::<Vec<_>>())?;
            heading(out, "velocities", self.model.coordinates.len())?;
            1
        };
        let coordinates = self.model.coordinates.iter();
        let rows = coordinates.map(|c| {
            [
                one_line(&c.name),
                coordinate_unit(c, order),
                one_line(&c.doc),
            ]
        });
        columns(out, &rows.collect::<Vec<_>>())
    }

    /// Only where there are any.
    fn states(&self, out: &mut String) -> std::fmt::Result {
        if self.model.states.is_empty() {
            return Ok(());
        }
        heading(out, "states", self.model.states.len())?;
        for z in &self.model.states {
            writeln!(out, "  {} {}", one_line(&z.name), shown_unit(&z.unit))?;
            for line in plain_lines(&z.doc) {
                writeln!(out, "    {line}")?;
            }
            writeln!(out, "    at first = {}", self.expression(z.initial))?;
            writeln!(out, "    rate = {}", self.expression(z.rate))?;
        }
        Ok(())
    }

    fn parameters(&self, out: &mut String) -> std::fmt::Result {
        heading(out, "parameters", self.model.parameters.len())?;
        let rows = self.model.parameters.iter().map(|p| {
            [
                one_line(&p.name),
                shown_unit(&p.unit),
                decimal(p.nominal),
                bounds(p),
                one_line(&p.doc),
            ]
        });
        columns(out, &rows.collect::<Vec<_>>())
    }

    fn dynamics(&self, out: &mut String) -> std::fmt::Result {
        writeln!(out, "\nenergies and forces")?;
        let mut rows = Vec::new();
        let stated = [
            ("kinetic", self.model.kinetic),
            ("potential", self.model.potential),
            ("dissipation", self.model.dissipation),
        ];
        for (what, expr) in stated {
            if !self.model.graph.is_zero(expr) {
                rows.push([what.to_string(), self.expression(expr)]);
            }
        }
        for (c, &force) in self.model.coordinates.iter().zip(&self.model.forces) {
            if !self.model.graph.is_zero(force) {
                rows.push([
                    format!("force on {}", one_line(&c.name)),
                    self.expression(force),
                ]);
            }
        }
        for force in &self.model.point_forces {
            let what = if force.torque { "torque" } else { "force" };
            let frame = one_line(&self.model.tree.bodies[force.frame].name);
            let value = force.value.map(|component| self.expression(component));
            rows.push([
                format!("{what} at {frame}"),
                format!("({})", value.join(", ")),
            ]);
        }
        columns(out, &rows)
    }

    fn constraints(&self, out: &mut String) -> std::fmt::Result {
        heading(out, "constraints", self.model.constraints.len())?;
        let system = &self.compiled.system;
        for (row, constraint) in self.model.constraints.iter().enumerate() {
            let kind = match constraint.kind {
                ConstraintKind::Holonomic => "holonomic",
                ConstraintKind::Nonholonomic => "nonholonomic",
            };
            let time = if constraint.time_dependent {
                ", depends on time"
            } else {
                ""
            };
            let when = constraint.active.map_or_else(String::new, |active| {
                format!(", where {} > 0", self.expression(active))
            });
            writeln!(out, "  {}: {kind}{time}{when}", one_line(&constraint.name))?;
            for line in plain_lines(&constraint.doc) {
                writeln!(out, "    {line}")?;
            }
            writeln!(out, "    0 = {}", self.expression(constraint.residual))?;
            for (c, &entry) in self
                .model
                .coordinates
                .iter()
                .zip(&system.constraint_matrix[row])
            {
                if !self.model.graph.is_zero(entry) {
                    writeln!(out, "    A[{}] = {}", one_line(&c.name), self.short(entry))?;
                }
            }
            writeln!(out, "    b = {}", self.short(system.constraint_bias[row]))?;
        }
        Ok(())
    }

    /// Models without a contact say nothing of contacts.
    fn contacts(&self, out: &mut String) -> std::fmt::Result {
        if self.model.contacts.is_empty() {
            return Ok(());
        }
        heading(out, "contacts", self.model.contacts.len())?;
        for contact in &self.model.contacts {
            let radius = contact.shape.radius().map(|r| self.expression(r));
            writeln!(
                out,
                "  {}: {}",
                one_line(&contact.name),
                one_line(&self.model.between(contact, radius.as_deref()))
            )?;
            for line in plain_lines(&contact.doc) {
                writeln!(out, "    {line}")?;
            }
            writeln!(out, "    gap = {}", self.short(contact.gap))?;
            writeln!(out, "    friction = {}", self.expression(contact.friction))?;
            let restitution = self.expression(contact.restitution);
            writeln!(out, "    restitution = {restitution}")?;
        }
        Ok(())
    }

    fn outputs(&self, out: &mut String) -> std::fmt::Result {
        heading(out, "outputs", self.model.outputs.len())?;
        let rows = self.model.outputs.iter().map(|output| {
            let unit = text(output.dimension);
            [
                one_line(&output.name),
                unit,
                self.expression(output.value),
                one_line(&output.doc),
            ]
        });
        columns(out, &rows.collect::<Vec<_>>())
    }

    /// Models without a sensor say nothing of sensors.
    fn sensors(&self, out: &mut String) -> std::fmt::Result {
        if self.model.sensors.is_empty() {
            return Ok(());
        }
        heading(out, "sensors", self.model.sensors.len())?;
        let rows = self.model.sensors.iter().map(|sensor| {
            let mut noise = Vec::new();
            if sensor.noise > 0.0 {
                noise.push(format!("noise {}", decimal(sensor.noise)));
            }
            noise.extend(
                sensor
                    .resolution
                    .map(|step| format!("resolution {}", decimal(step))),
            );
            noise.extend(sensor.rate.map(|rate| format!("rate {} Hz", decimal(rate))));
            [
                one_line(&sensor.name),
                text(sensor.dimension),
                self.expression(sensor.value),
                noise.join(", "),
                one_line(&sensor.doc),
            ]
        });
        columns(out, &rows.collect::<Vec<_>>())
    }

    fn effects(&self, out: &mut String) -> std::fmt::Result {
        heading(out, "effects", self.model.effects.len())?;
        for effect in &self.model.effects {
            let places: Vec<String> = effect.on.iter().map(|(_, name)| one_line(name)).collect();
            let values = effect.parameters.iter().map(|&index| {
                let p = &self.model.parameters[index];
                let unit = if p.unit == "1" {
                    String::new()
                } else {
                    shown_unit(&p.unit)
                };
                let text = format!("{} = {} {unit}", one_line(&p.name), decimal(p.nominal));
                text.trim_end().to_string()
            });
            let values = values.collect::<Vec<_>>().join(", ");
            writeln!(
                out,
                "  {}({}): {}",
                one_line(&effect.template),
                places.join(", "),
                values
            )?;
            let what = plain_lines(&effect.doc);
            writeln!(
                out,
                "    what: {}",
                what.first().map_or("not described", String::as_str)
            )?;
            let why = plain_lines(&effect.provenance);
            if why.is_empty() {
                writeln!(out, "    why:  not stated")?;
            }
            for line in why {
                writeln!(out, "    why:  {line}")?;
            }
        }
        Ok(())
    }

    /// Only where there are any.
    fn tables(&self, out: &mut String) -> std::fmt::Result {
        if self.model.tables.is_empty() {
            return Ok(());
        }
        heading(out, "tables", self.model.tables.len())?;
        for table in &self.model.tables {
            let file = table.file.as_ref();
            let from = file.map_or(String::new(), |(file, _)| {
                format!(", from {}", one_line(file))
            });
            let unit = shown_unit(&table.unit);
            writeln!(out, "  {} {unit}{from}", one_line(&table.name))?;
            for line in plain_lines(&table.doc) {
                writeln!(out, "    {line}")?;
            }
            for (name, unit, points) in &table.arguments {
                let (Some(first), Some(last)) = (points.first(), points.last()) else {
                    continue;
                };
                let (first, last) = (decimal(*first), decimal(*last));
                let (name, unit, count) = (one_line(name), shown_unit(unit), points.len());
                let row = format!("    of {name}: {count} points, {first} to {last} {unit}");
                writeln!(out, "{}", row.trim_end())?;
            }
        }
        Ok(())
    }

    /// Only where there are any.
    fn uses(&self, out: &mut String) -> std::fmt::Result {
        if self.model.uses.is_empty() {
            return Ok(());
        }
        heading(out, "uses of parts", self.model.uses.len())?;
        let rows = self.model.uses.iter().map(|used| {
            let given = format!("{}{}", one_line(&used.part), one_line(&used.arguments));
            [one_line(&used.name), given, one_line(&used.doc)]
        });
        columns(out, &rows.collect::<Vec<_>>())
    }

    fn size(&self, out: &mut String) -> std::fmt::Result {
        writeln!(out, "\noperations")?;
        for line in counts::table(&self.emission.plan) {
            writeln!(out, "  {line}")?;
        }
        let code = self.emission.rust();
        writeln!(out, "\ncode size")?;
        writeln!(out, "  Rust: {}", size_of(&code))?;
        for file in self.emission.c() {
            writeln!(out, "  {}: {}", file.name, size_of(&file.text))?;
        }
        Ok(())
    }
}

fn size_of(text: &str) -> String {
    format!("{} lines, {} bytes", text.lines().count(), text.len())
}

fn paragraph(out: &mut String, text: &str) -> std::fmt::Result {
    for line in plain_lines(text) {
        writeln!(out, "{}", format!("  {line}").trim_end())?;
    }
    Ok(())
}

pub(super) fn heading(out: &mut String, title: &str, count: usize) -> std::fmt::Result {
    match count {
        0 => writeln!(out, "\n{title}: none"),
        _ => writeln!(out, "\n{title}: {count}"),
    }
}

fn bounds(p: &Parameter) -> String {
    let bounds = match (p.lower.is_finite(), p.upper.is_finite()) {
        (false, false) => None,
        (lower, upper) => {
            let side = |given: bool, value| if given { decimal(value) } else { String::new() };
            Some(format!(
                "in {}..{}",
                side(lower, p.lower),
                side(upper, p.upper)
            ))
        }
    };
    let belief = p.belief.map(|belief| {
        let (mean, sd) = (decimal(belief.mean), decimal(belief.sd));
        format!("prior normal({mean}, {sd})")
    });
    let parts: Vec<String> = bounds.into_iter().chain(belief).collect();
    parts.join(" ")
}

/// Rows with their cells in columns; a column in which nothing stands is left out.
pub(super) fn columns<const N: usize>(out: &mut String, rows: &[[String; N]]) -> std::fmt::Result {
    let width = |cell: &String| cell.chars().count();
    let widths: [usize; N] =
        std::array::from_fn(|i| rows.iter().map(|row| width(&row[i])).max().unwrap_or(0));
    for row in rows {
        let mut line = String::from(" ");
        for (cell, &wide) in row.iter().zip(&widths).filter(|(_, wide)| **wide > 0) {
            line.push(' ');
            line.push_str(cell);
            line.extend(std::iter::repeat_n(' ', wide - width(cell) + 1));
        }
        writeln!(out, "{}", line.trim_end())?;
    }
    Ok(())
}
