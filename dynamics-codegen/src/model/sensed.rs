//! Sensors that read wrongly: `measured gyro_z = gyro_z + offset;`.
//!
//! What a sensor shows is known when all else is. Until then a variable stands for what it
//! shows rightly, and another for the rate of that.

use super::builder::Builder;
use super::names::VECTORS;
use super::quantity::{Measure, Quantity};
use super::sensor::MOMENTARY_VECTORS;
use crate::diagnostic::Diagnostic;
use crate::dimension::Dimension;
use crate::graph::{ExprId, Node, SymbolId};
use crate::source::Span;
use crate::syntax::{Expr, ExprKind, Name, PortKind, SensorStatement, Statement, StatementKind};
use std::collections::HashMap;

/// A sensor, or a component of one, of which something is said beside what it shows.
#[derive(Debug, Clone)]
pub(super) struct WrongSensor {
    pub name: String,
    pub dimension: Option<Dimension>,
    pub unit: String,
    /// What it shows rightly.
    symbol: SymbolId,
    /// The rate of that.
    rate: SymbolId,
    /// What it reads, of these two.
    reads: ExprId,
}

/// The sensors of a model, and what is said of those that read wrongly.
#[derive(Debug, Clone, Default)]
pub(super) struct WrongSensors {
    stated: Vec<SensorStatement>,
    pub known: Vec<WrongSensor>,
    /// The one whose reading a statement is about.
    measuring: Option<usize>,
}

/// What a sensor's components are called.
pub(crate) fn component_names(sensor: &SensorStatement) -> Vec<String> {
    let name = &sensor.name.text;
    match &sensor.value.kind {
        ExprKind::Call(function, _)
            if VECTORS.contains(&function.text.as_str())
                || MOMENTARY_VECTORS.contains(&function.text.as_str()) =>
        {
            ["x", "y", "z"].map(|axis| format!("{name}_{axis}")).into()
        }
        _ => vec![name.clone()],
    }
}

impl WrongSensors {
    /// Takes note of the sensors of a model.
    pub fn note(&mut self, statements: &[&Statement]) {
        let sensors = statements
            .iter()
            .filter_map(|statement| match &statement.kind {
                StatementKind::Sensor(sensor) => Some((**sensor).clone()),
                _ => None,
            });
        self.stated = sensors.collect();
    }
}

impl Builder<'_> {
    /// The names of all sensors, vectors by components: a template sees its ports instead.
    pub(super) fn visible_sensors(&self) -> Vec<String> {
        match self.effect {
            Some(_) => Vec::new(),
            None => self.wrong.stated.iter().flat_map(component_names).collect(),
        }
    }

    /// Whether a sensor, or a component of one, goes by this name here.
    pub(super) fn sees_sensor(&self, name: &str) -> bool {
        self.visible_sensors().iter().any(|known| known == name)
    }

    /// The place of a sensor among those of which something is said.
    pub(super) fn note_sensor(&mut self, name: &str) -> usize {
        let mut known = self.wrong.known.iter();
        if let Some(place) = known.position(|sensor| sensor.name == name) {
            return place;
        }
        let (dimension, unit) = self.sensor_unit(name);
        let graph = &mut self.model.graph;
        let symbol = graph.symbol(format!("shown_{name}"));
        let rate = graph.symbol(format!("dshown_{name}"));
        self.wrong.known.push(WrongSensor {
            name: name.to_string(),
            dimension,
            unit,
            symbol,
            rate,
            reads: graph.var(symbol),
        });
        self.wrong.known.len() - 1
    }

    /// The unit of a sensor: as it is declared, or else that of what it shows.
    fn sensor_unit(&mut self, name: &str) -> (Option<Dimension>, String) {
        let is_own = |sensor: &&SensorStatement| component_names(sensor).iter().any(|n| n == name);
        let Some(sensor) = self.wrong.stated.iter().find(is_own).cloned() else {
            return (None, String::new());
        };
        // What is wrong with the sensor is said where it is lowered.
        let findings = self.finding_count();
        let dimension = match &sensor.unit {
            Some(unit) => self.dimension(unit),
            None => {
                let components = self.sensor_components(&sensor);
                components.and_then(|all| all[0].1.measure.known())
            }
        };
        self.forget(findings);
        let text = sensor.unit.as_ref().map(super::unit::unit_text);
        let derived = || dimension.map_or_else(String::new, |dimension| dimension.to_string());
        (dimension, text.unwrap_or_else(derived))
    }

    /// What stands for the reading of the sensor that a statement is about.
    pub(super) fn reading(&self, name: &str) -> Option<Quantity> {
        let measuring = self.wrong.measuring?;
        let sensor = &self.wrong.known[measuring];
        let is_own = match self.scope.ports.get(name) {
            Some((_, index)) => *index == measuring && self.is_sensor_port(name),
            // In a template the name may be that of its own parameter.
            None => self.effect.is_none() && sensor.name == name,
        };
        is_own.then(|| Quantity {
            expr: self.model.graph.var(sensor.symbol),
            measure: Measure::of(sensor.dimension),
        })
    }

    fn is_sensor_port(&self, name: &str) -> bool {
        matches!(self.scope.ports.get(name), Some((PortKind::Sensor, _)))
    }

    /// Nothing but the statement about it sees a sensor's reading.
    pub(super) fn refuse_reading(&mut self, name: &str, span: Span) -> Option<Quantity> {
        let message = format!("what the sensor `{name}` shows is seen by `measured {name}` alone");
        self.report(Diagnostic::error(span, message))
    }

    /// Of a sensor that shows a vector, a component has to be named.
    pub(super) fn refuse_vector(&mut self, name: &Name) -> Option<()> {
        let mut stated = self.wrong.stated.iter();
        let sensor = match stated.find(|sensor| sensor.name.text == name.text) {
            Some(sensor) if self.effect.is_none() => sensor,
            _ => return Some(()),
        };
        let quoted = component_names(sensor).into_iter();
        let quoted: Vec<String> = quoted.map(|component| format!("`{component}`")).collect();
        let message = format!("the sensor `{}` shows a vector", name.text);
        let help = format!("name a component of it: {}", quoted.join(", "));
        self.report(Diagnostic::error(name.span, message).help(help))
    }

    /// `dot` of what stands for a reading; the inner `None` if it is of something else.
    pub(super) fn rate_of_reading(
        &mut self,
        inner: Quantity,
        span: Span,
    ) -> Option<Option<Quantity>> {
        let Some(measuring) = self.wrong.measuring else {
            return Some(None);
        };
        let WrongSensor { symbol, rate, .. } = self.wrong.known[measuring];
        let graph = &self.model.graph;
        if inner.expr == graph.var(symbol) {
            return Some(Some(Quantity {
                expr: graph.var(rate),
                measure: inner.measure.rate(),
            }));
        }
        if graph.depends_on(&[inner.expr], symbol) || graph.depends_on(&[inner.expr], rate) {
            let message = "`dot` of something that contains what a sensor shows";
            let help = "take the rate of the reading itself: `dot(name)`";
            return self.report(Diagnostic::error(span, message).help(help));
        }
        Some(None)
    }

    /// `measured s = value` of a sensor: what it read so far becomes the argument.
    pub(super) fn lower_reading(&mut self, index: usize, value: &Expr) -> Option<()> {
        self.wrong.measuring = Some(index);
        let lowered = self.lower(value);
        self.wrong.measuring = None;
        let quantity = lowered?;
        let sensor = self.wrong.known[index].clone();
        if let Some(dimension) = sensor.dimension {
            let role = format!("what is measured of `{}`", sensor.name);
            self.expect_dimension(quantity, dimension, value.span, &role)?;
        }
        self.refuse_inputs(quantity.expr, value.span, "a measurement")?;
        let graph = &mut self.model.graph;
        // d(so far)/dt, where a rate of the rate is left out: times add up to first order.
        let slope = graph.derivatives(&[sensor.reads], sensor.symbol)[0];
        let rate = graph.var(sensor.rate);
        let rate = graph.mul(slope, rate);
        let so_far = HashMap::from([(sensor.symbol, sensor.reads), (sensor.rate, rate)]);
        let reads = graph.substitute(&[quantity.expr], &so_far)[0];
        self.wrong.known[index].reads = reads;
        let lead = self.lead(index, reads);
        let graph = &self.model.graph;
        let parameters: Vec<SymbolId> = self.model.parameters.iter().map(|p| p.symbol).collect();
        let changes = graph.reachable(&[lead]).iter().any(|expr| {
            let is_other = |symbol| !parameters.contains(&symbol);
            matches!(graph.node(expr), Node::Symbol(symbol) if is_other(symbol))
        });
        if changes {
            let message = "the time of a reading depends on parameters only";
            let error = Diagnostic::error(value.span, message).label("this changes");
            let help = "multiply the rate by a parameter, in seconds: `late*dot(name)`";
            return self.report(error.help(help));
        }
        Some(())
    }

    /// `y + s ẏ` is `y`, `s` seconds later.
    fn lead(&mut self, index: usize, reads: ExprId) -> ExprId {
        let WrongSensor { symbol, rate, .. } = self.wrong.known[index];
        let graph = &mut self.model.graph;
        let owed = graph.derivatives(&[reads], rate)[0];
        if graph.is_zero(owed) {
            return owed;
        }
        let slope = graph.derivatives(&[reads], symbol)[0];
        graph.div(owed, slope)
    }

    /// What a sensor reads that shows `shown` rightly, and how much later that is.
    pub(super) fn read_of(&mut self, name: &str, shown: ExprId) -> (ExprId, ExprId) {
        let zero = self.model.graph.zero();
        let mut known = self.wrong.known.iter();
        let Some(index) = known.position(|sensor| sensor.name == name) else {
            return (shown, zero);
        };
        let WrongSensor {
            symbol,
            rate,
            reads,
            ..
        } = self.wrong.known[index];
        let lead = self.lead(index, reads);
        let at_once = HashMap::from([(symbol, shown), (rate, zero)]);
        let read = self.model.graph.substitute(&[reads], &at_once)[0];
        (read, lead)
    }
}
