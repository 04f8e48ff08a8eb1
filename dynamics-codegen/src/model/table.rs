//! Look-up tables: `table drag(speed: m/s): N { 0: 0; 1: 0.3; 2: 1.4; }`.

use super::Library;
use super::builder::Builder;
use super::lower::Lowered;
use super::names::{FUNCTIONS, VECTORS};
use super::quantity::{Measure, Quantity};
use super::table_file::{self, Cell, Rows};
use super::unit::unit_text;
use crate::diagnostic::Diagnostic;
use crate::dimension::Dimension;
use crate::file::Limit;
use crate::source::{SourceId, Sources, Span};
use crate::syntax::{Expr, ExprKind, Name, TableContent, TableStatement, Unit};
use crate::table::Spline;

/// Of how many numbers a table may be a function.
const MAX_ARGUMENTS: usize = 2;
/// Points along one argument.
const MAX_POINTS: usize = 256;
/// Points in all: each is some operations wherever the table is read.
const MAX_ENTRIES: usize = 1024;
/// How large the file of a table may be.
const LIMIT: Limit = Limit {
    what: "a table",
    bytes: 1 << 20,
};

/// A function that is known at points.
#[derive(Debug, Clone)]
pub struct Table {
    /// Its name.
    pub name: String,
    /// What it is a function of: name, unit as written, and the points at which it is known.
    pub arguments: Vec<(String, String, Vec<f64>)>,
    /// The unit of its values as written.
    pub unit: String,
    /// The file with its numbers, as the model names it, and its text.
    pub file: Option<(String, SourceId)>,
    /// What the model says about it.
    pub doc: String,
    pub(super) spline: Spline,
    pub(super) dimensions: Vec<Option<Dimension>>,
    pub(super) dimension: Option<Dimension>,
}

impl Builder<'_> {
    /// Takes up a table. One that is wrong is reported, and its name no further complained about.
    pub(super) fn declare_table(
        &mut self,
        table: &TableStatement,
        doc: &str,
        sources: &mut Sources,
        library: &Library,
    ) {
        let findings = self.finding_count();
        if self.read_table(table, doc, sources, library).is_none() {
            self.scope.unreadable.insert(table.name.text.clone());
        }
        if let TableContent::File(path) = &table.content {
            self.explain(findings, path.span);
        }
    }

    fn read_table(
        &mut self,
        table: &TableStatement,
        doc: &str,
        sources: &mut Sources,
        library: &Library,
    ) -> Option<()> {
        self.check_heading(table)?;
        let mut arguments = Vec::new();
        let mut dimensions = Vec::new();
        for (name, unit) in &table.arguments {
            let text = unit.as_ref().map_or_else(String::new, unit_text);
            arguments.push((name.text.clone(), text, Vec::new()));
            dimensions.push(self.optional_dimension(unit.as_ref())?);
        }
        let dimension = self.optional_dimension(table.unit.as_ref())?;
        let mut file = None;
        let rows = match &table.content {
            TableContent::Rows(rows) => self.rows(table, rows)?,
            TableContent::File(path) => {
                let (source, rows) = self.rows_of_file(table, path, sources, library)?;
                file = Some((path.text.clone(), source));
                rows
            }
        };
        let axes = self.axes(table, &rows)?;
        let values = self.values(table, &rows)?;
        for (argument, points) in arguments.iter_mut().zip(&axes) {
            argument.2.clone_from(points);
        }
        let spline = Spline::through(axes, &values);
        if !spline.is_finite() {
            let message = format!("the numbers of `{}` are too large", table.name.text);
            return self.report(Diagnostic::error(table.name.span, message));
        }
        self.model.tables.push(Table {
            name: table.name.text.clone(),
            arguments,
            unit: table.unit.as_ref().map_or_else(String::new, unit_text),
            file,
            doc: doc.to_string(),
            spline,
            dimensions,
            dimension,
        });
        Some(())
    }

    /// The dimension of a unit that may be left out; `None` if it is wrong.
    fn optional_dimension(&mut self, unit: Option<&Unit>) -> Option<Option<Dimension>> {
        match unit {
            Some(unit) => self.dimension(unit).map(Some),
            None => Some(None),
        }
    }

    fn check_heading(&mut self, table: &TableStatement) -> Option<()> {
        let name = &table.name;
        let function = FUNCTIONS.iter().any(|(known, _)| *known == name.text);
        if function || VECTORS.contains(&name.text.as_str()) {
            let message = format!("`{}` is a function of the language", name.text);
            let error = Diagnostic::error(name.span, message);
            return self.report(error.help("give the table another name"));
        }
        if self.table_named(&name.text).is_some() {
            let message = format!("there are two tables named `{}`", name.text);
            return self.report(Diagnostic::error(name.span, message));
        }
        match &table.arguments[..] {
            [] => {
                let error = Diagnostic::error(name.span, "a table is a function of something");
                self.report(error.help("say of what: `table drag(speed: m/s): N { … }`"))
            }
            [(first, _), (second, _)] if first.text == second.text => {
                let message = format!("`{}` is listed twice", second.text);
                self.report(Diagnostic::error(second.span, message))
            }
            more if more.len() > MAX_ARGUMENTS => {
                let message = "a table is a function of one number or of two";
                self.report(Diagnostic::error(more[MAX_ARGUMENTS].0.span, message))
            }
            _ => Some(()),
        }
    }

    /// The numbers in the braces of the statement.
    fn rows(&mut self, table: &TableStatement, rows: &[(Expr, Vec<Expr>)]) -> Option<Rows> {
        let mut rows = rows.iter();
        let mut heading = None;
        if let [_, (across, _)] = &table.arguments[..] {
            let named = |expr: &Expr| matches!(&expr.kind, ExprKind::Name(n) if *n == across.text);
            match rows.next() {
                Some((name, points)) if named(name) => heading = Some(self.cells(points)?),
                first => {
                    let place = first.map_or(table.name.span, |(name, _)| name.span);
                    let message = format!("the first row has the values of `{}`", across.text);
                    let help = format!("begin with `{}: 0, 1, 2;`", across.text);
                    return self.report(Diagnostic::error(place, message).help(help));
                }
            }
        }
        let mut read = Vec::new();
        for (first, values) in rows {
            read.push((self.cell(first)?, self.cells(values)?));
        }
        Some(Rows {
            heading,
            rows: read,
        })
    }

    fn cells(&mut self, exprs: &[Expr]) -> Option<Vec<Cell>> {
        exprs.iter().map(|expr| self.cell(expr)).collect()
    }

    fn cell(&mut self, expr: &Expr) -> Option<Cell> {
        let value = self.number(expr)?;
        let span = expr.span;
        Some(Cell { value, span })
    }

    fn rows_of_file(
        &mut self,
        table: &TableStatement,
        path: &Name,
        sources: &mut Sources,
        library: &Library,
    ) -> Option<(SourceId, Rows)> {
        let (shown, text) = match library.read(&path.text, LIMIT) {
            Ok(found) => found,
            Err(reason) => {
                let message = format!("cannot read `{}`: {reason}", path.text);
                let error = Diagnostic::error(path.span, message);
                return self
                    .report(error.help("the path starts from the folder of the model file"));
            }
        };
        let source = sources.add(shown, text);
        let text = &sources.get(source).text;
        match table_file::read(text, source, table.arguments.len()) {
            Ok(rows) => Some((source, rows)),
            Err(error) => self.report(*error),
        }
    }

    /// The points along each argument: two or more, and increasing.
    fn axes(&mut self, table: &TableStatement, rows: &Rows) -> Option<Vec<Vec<f64>>> {
        let first: Vec<Cell> = rows.rows.iter().map(|(cell, _)| *cell).collect();
        let all = std::iter::once(&first).chain(&rows.heading);
        let mut axes = Vec::new();
        for (cells, (name, _)) in all.zip(&table.arguments) {
            axes.push(self.axis(name, cells, table.name.span)?);
        }
        let entries: usize = axes.iter().map(Vec::len).product();
        if entries > MAX_ENTRIES {
            let message = format!("a table has at most {MAX_ENTRIES} values, found {entries}");
            return self.report(too_fine(table.name.span, message));
        }
        Some(axes)
    }

    fn axis(&mut self, name: &Name, cells: &[Cell], table: Span) -> Option<Vec<f64>> {
        if cells.len() < 2 {
            let message = format!("a table needs two values of `{}` at least", name.text);
            let place = cells.first().map_or(table, |cell| cell.span);
            return self.report(Diagnostic::error(place, message));
        }
        if cells.len() > MAX_POINTS {
            let message = format!("a table has at most {MAX_POINTS} values of `{}`", name.text);
            return self.report(too_fine(cells[MAX_POINTS].span, message));
        }
        for pair in cells.windows(2) {
            let [before, next] = [pair[0], pair[1]];
            let step = next.value - before.value;
            if step > 0.0 && (1.0 / (6.0 * step)).is_finite() {
                continue;
            }
            let message = format!(
                "the values of `{}` must increase, found {} behind {}",
                name.text, next.value, before.value
            );
            return self.report(Diagnostic::error(next.span, message));
        }
        Some(cells.iter().map(|cell| cell.value).collect())
    }

    /// The values, one per point.
    fn values(&mut self, table: &TableStatement, rows: &Rows) -> Option<Vec<f64>> {
        let width = rows.heading.as_ref().map_or(1, Vec::len);
        let mut values = Vec::new();
        for (first, row) in &rows.rows {
            if row.len() != width {
                let place = row
                    .last()
                    .map_or(first.span, |last| first.span.to(last.span));
                let wanted = match table.arguments.get(1) {
                    Some((across, _)) => format!("there are {width} of `{}`", across.text),
                    None => "a table of one number has one".to_string(),
                };
                let message = format!("{} values in this row, and {wanted}", row.len());
                return self.report(Diagnostic::error(place, message));
            }
            values.extend(row.iter().map(|cell| cell.value));
        }
        Some(values)
    }

    pub(super) fn table_named(&self, name: &str) -> Option<usize> {
        self.model
            .tables
            .iter()
            .position(|table| table.name == name)
    }

    /// `drag(dot(x))`
    pub(super) fn lower_table(&mut self, index: usize, arguments: &[Expr], span: Span) -> Lowered {
        let table = &self.model.tables[index];
        if arguments.len() != table.arguments.len() {
            let names: Vec<&str> = table
                .arguments
                .iter()
                .map(|(name, ..)| name.as_str())
                .collect();
            let message = format!(
                "the table is read as `{}({})`, found {} in the brackets",
                table.name,
                names.join(", "),
                arguments.len()
            );
            return self.report(Diagnostic::error(span, message));
        }
        let wanted: Vec<(String, Option<Dimension>)> = (table.arguments.iter())
            .zip(&table.dimensions)
            .map(|((name, ..), dimension)| (name.clone(), *dimension))
            .collect();
        let (spline, measure) = (table.spline.clone(), Measure::of(table.dimension));
        let name = table.name.clone();
        let mut values = Vec::new();
        for (argument, (role, dimension)) in arguments.iter().zip(wanted) {
            let quantity = self.lower(argument)?;
            if let Some(dimension) = dimension {
                self.expect_dimension(quantity, dimension, argument.span, &format!("`{role}`"))?;
            }
            values.push(quantity.expr);
        }
        let expr = spline.express(&mut self.model.graph, &values);
        if spline.is_straight() {
            self.model.graph.label(expr, &name);
        } else {
            self.model.graph.call(expr, &name, &values);
        }
        Some(Quantity { expr, measure })
    }
}

/// More points than code should be made of.
fn too_fine(place: Span, message: String) -> Diagnostic {
    Diagnostic::error(place, message)
        .help("a spline needs points where the curve bends: leave some out in between")
}
