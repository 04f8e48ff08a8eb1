//! What a model contains, for `check`: as JSON, or as a page.

mod page;

use crate::model::Loaded;
use dynamics_codegen::derive::{Sensitivity, Variable};
use dynamics_codegen::dimension::Dimension;
use dynamics_codegen::graph::{ExprId, Graph};
use dynamics_codegen::model::{ConstraintKind, Effect, Position};
use dynamics_codegen::{Model, Severity};
use serde::Serialize;

/// What a model contains.
#[derive(Debug, Clone, Serialize)]
pub struct Summary {
    model: String,
    file: String,
    description: String,
    sizes: Sizes,
    /// Where there is not one for every velocity.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    positions: Vec<Variables>,
    /// Of a twist, its components.
    coordinates: Vec<Variables>,
    inputs: Vec<Variables>,
    parameters: Vec<ParameterSummary>,
    constraints: Vec<ConstraintSummary>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    contacts: Vec<ContactSummary>,
    effects: Vec<EffectSummary>,
    outputs: Vec<Variables>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    sensors: Vec<SensorSummary>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    tables: Vec<TableSummary>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    uses: Vec<UseSummary>,
    operations: Operations,
    warnings: Vec<Warning>,
}

#[derive(Debug, Clone, Serialize)]
struct Sizes {
    coordinates: usize,
    inputs: usize,
    parameters: usize,
    constraints: usize,
    effects: usize,
    outputs: usize,
}

/// What may touch a plane.
#[derive(Debug, Clone, Serialize)]
struct ContactSummary {
    name: String,
    /// As a model says it, without the radius.
    between: String,
    description: String,
}

/// A sensor, or a component of one.
#[derive(Debug, Clone, Serialize)]
struct SensorSummary {
    name: String,
    unit: String,
    /// Standard deviation.
    noise: f64,
    resolution: Option<f64>,
    /// Hz.
    rate: Option<f64>,
    description: String,
}

/// A look-up table.
#[derive(Debug, Clone, Serialize)]
struct TableSummary {
    name: String,
    unit: String,
    arguments: Vec<ArgumentSummary>,
    /// Where its numbers stand, if not in the model.
    file: Option<String>,
    description: String,
}

/// What a table is a function of.
#[derive(Debug, Clone, Serialize)]
struct ArgumentSummary {
    name: String,
    unit: String,
    /// Where the table is known, upwards.
    points: Vec<f64>,
}

/// A part under a name of its own.
#[derive(Debug, Clone, Serialize)]
struct UseSummary {
    name: String,
    part: String,
    /// In brackets, as a model says it.
    arguments: String,
    description: String,
}

/// A coordinate, an input or an output.
#[derive(Debug, Clone, Serialize)]
struct Variables {
    name: String,
    unit: String,
    description: String,
}

#[derive(Debug, Clone, Serialize)]
struct ParameterSummary {
    name: String,
    unit: String,
    /// What the model states.
    nominal: f64,
    /// What is used: `nominal` unless overridden.
    value: f64,
    lower: Option<f64>,
    upper: Option<f64>,
    effect: Option<String>,
    description: String,
}

#[derive(Debug, Clone, Serialize)]
struct ConstraintSummary {
    name: String,
    kind: &'static str,
    time_dependent: bool,
    unit: String,
    description: String,
}

#[derive(Debug, Clone, Serialize)]
struct EffectSummary {
    effect: String,
    on: Vec<String>,
    /// The term of a fit that it is part of.
    #[serde(skip_serializing_if = "Option::is_none")]
    term: Option<String>,
    parameters: Vec<String>,
    description: String,
}

/// Operations per state. A subexpression that several entries of one function share is
/// counted once.
#[derive(Debug, Clone, Serialize)]
struct Operations {
    mass_matrix: usize,
    bias_force: usize,
    applied_force: usize,
    input_matrix: usize,
    force: usize,
    constraint_jacobian: usize,
    constraint_bias: usize,
    constraint_residual: usize,
    constraint_rate: usize,
    outputs: usize,
    /// `M, Q, A, b` together: what the accelerations follow from.
    dynamics: usize,
    /// What the derivatives of the accelerations by `q, v, u` take besides.
    derivatives: usize,
}

#[derive(Debug, Clone, Serialize)]
struct Warning {
    message: String,
    file: String,
    line: usize,
    column: usize,
    help: Vec<String>,
}

impl Summary {
    /// Looks at a model.
    pub fn of(loaded: &Loaded) -> Self {
        let model = &loaded.compiled.model;
        Self {
            model: model.name.clone(),
            file: loaded.path.display().to_string(),
            description: model.doc.clone(),
            sizes: Sizes {
                coordinates: model.coordinates.len(),
                inputs: model.inputs.len(),
                parameters: model.parameters.len(),
                constraints: model.constraints.len(),
                effects: model.effects.len(),
                outputs: model.outputs.len(),
            },
            positions: positions(model),
            coordinates: (model.coordinates.iter().enumerate())
                .map(|(index, c)| {
                    let rate = if model.pose_of(index).is_some() {
                        "/s"
                    } else {
                        ""
                    };
                    Variables::new(&c.name, format!("{}{rate}", c.unit), &c.doc)
                })
                .collect(),
            inputs: (model.inputs.iter())
                .map(|u| Variables::new(&u.name, u.unit.clone(), &u.doc))
                .collect(),
            parameters: parameters(model, &loaded.parameters),
            constraints: constraints(model),
            contacts: contacts(model),
            effects: effects(model),
            outputs: (model.outputs.iter())
                .map(|y| Variables::new(&y.name, unit(y.dimension), &y.doc))
                .collect(),
            sensors: sensors(model),
            tables: tables(model),
            uses: uses(model),
            operations: Operations::of(loaded),
            warnings: warnings(loaded),
        }
    }
}

impl Variables {
    fn new(name: &str, unit: String, doc: &str) -> Self {
        Self {
            name: name.to_string(),
            unit,
            description: doc.to_string(),
        }
    }
}

fn unit(dimension: Option<Dimension>) -> String {
    dimension.map(|d| d.to_string()).unwrap_or_default()
}

/// The positions, if bodies float by their twists.
fn positions(model: &Model) -> Vec<Variables> {
    let positions = match model.poses.is_empty() {
        true => Vec::new(),
        false => model.positions(),
    };
    let position = |p: Position| Variables::new(&p.name, p.unit, "");
    positions.into_iter().map(position).collect()
}

fn parameters(model: &Model, values: &[f64]) -> Vec<ParameterSummary> {
    let finite = |value: f64| value.is_finite().then_some(value);
    let effect = |index: usize| {
        let effect = &model.effects[index];
        format!("{}({})", effect.template, places(effect).join(", "))
    };
    let summary = |(p, &value): (&dynamics_codegen::model::Parameter, &f64)| ParameterSummary {
        name: p.name.clone(),
        unit: p.unit.clone(),
        nominal: p.nominal,
        value,
        lower: finite(p.lower),
        upper: finite(p.upper),
        effect: p.effect.map(effect),
        description: p.doc.clone(),
    };
    model.parameters.iter().zip(values).map(summary).collect()
}

fn constraints(model: &Model) -> Vec<ConstraintSummary> {
    let summary = |c: &dynamics_codegen::model::Constraint| ConstraintSummary {
        name: c.name.clone(),
        kind: match c.kind {
            ConstraintKind::Holonomic => "holonomic",
            ConstraintKind::Nonholonomic => "nonholonomic",
        },
        time_dependent: c.time_dependent,
        unit: unit(c.dimension),
        description: c.doc.clone(),
    };
    model.constraints.iter().map(summary).collect()
}

fn contacts(model: &Model) -> Vec<ContactSummary> {
    let summary = |contact: &dynamics_codegen::model::Contact| ContactSummary {
        name: contact.name.clone(),
        between: model.between(contact, None),
        description: contact.doc.clone(),
    };
    model.contacts.iter().map(summary).collect()
}

fn effects(model: &Model) -> Vec<EffectSummary> {
    let name = |&index: &usize| model.parameters[index].name.clone();
    let summary = |e: &Effect| EffectSummary {
        effect: e.template.clone(),
        on: places(e),
        term: e.term.as_ref().map(|term| term.name.clone()),
        parameters: e.parameters.iter().map(name).collect(),
        description: e.doc.clone(),
    };
    model.effects.iter().map(summary).collect()
}

fn sensors(model: &Model) -> Vec<SensorSummary> {
    let summary = |sensor: &dynamics_codegen::model::Sensor| SensorSummary {
        name: sensor.name.clone(),
        unit: unit(sensor.dimension),
        noise: sensor.noise,
        resolution: sensor.resolution,
        rate: sensor.rate,
        description: sensor.doc.clone(),
    };
    model.sensors.iter().map(summary).collect()
}

fn tables(model: &Model) -> Vec<TableSummary> {
    let argument = |(name, unit, points): &(String, String, Vec<f64>)| ArgumentSummary {
        name: name.clone(),
        unit: unit.clone(),
        points: points.clone(),
    };
    let summary = |table: &dynamics_codegen::model::Table| TableSummary {
        name: table.name.clone(),
        unit: table.unit.clone(),
        arguments: table.arguments.iter().map(argument).collect(),
        file: table.file.as_ref().map(|(name, _)| name.clone()),
        description: table.doc.clone(),
    };
    model.tables.iter().map(summary).collect()
}

fn uses(model: &Model) -> Vec<UseSummary> {
    let summary = |used: &dynamics_codegen::model::PartUse| UseSummary {
        name: used.name.clone(),
        part: used.part.clone(),
        arguments: used.arguments.clone(),
        description: used.doc.clone(),
    };
    model.uses.iter().map(summary).collect()
}

fn places(effect: &Effect) -> Vec<String> {
    effect.on.iter().map(|(_, name)| name.clone()).collect()
}

fn warnings(loaded: &Loaded) -> Vec<Warning> {
    let report = &loaded.compiled.warnings;
    let warnings = report.diagnostics.iter();
    warnings
        .filter(|d| d.severity == Severity::Warning)
        .map(|d| {
            let (line, column) = report.sources.line_column(d.primary.span);
            Warning {
                message: d.message.clone(),
                file: report.sources.get(d.primary.span.source).name.clone(),
                line,
                column,
                help: d.help.clone(),
            }
        })
        .collect()
}

impl Operations {
    fn of(loaded: &Loaded) -> Self {
        let of = &loaded.compiled.system;
        let (mass, rows) = (of.mass_matrix.concat(), of.constraint_matrix.concat());
        let force = &of.force_beside_mass;
        let motion = [&mass[..], force, &rows, &of.constraint_bias].concat();
        let mut graph = loaded.compiled.model.graph.clone();
        let mut count = |expressions: &[ExprId]| as_emitted(&mut graph, expressions);
        Self {
            mass_matrix: count(&mass),
            bias_force: count(&of.bias_force),
            applied_force: count(&of.applied_force),
            input_matrix: count(&of.input_matrix.concat()),
            force: count(&of.force),
            constraint_jacobian: count(&rows),
            constraint_bias: count(&of.constraint_bias),
            constraint_residual: count(&of.constraint_residual),
            constraint_rate: count(&of.constraint_rate),
            outputs: count(&of.outputs),
            dynamics: count(&motion),
            derivatives: derivative_count(loaded),
        }
    }
}

fn derivative_count(loaded: &Loaded) -> usize {
    let (mut model, system) = (loaded.compiled.model.clone(), &loaded.compiled.system);
    let (n, k) = (model.coordinates.len(), model.inputs.len());
    let variables: Vec<Variable> = (0..n)
        .map(Variable::Position)
        .chain((0..n).map(Variable::Velocity))
        .chain((0..k).map(Variable::Input))
        .collect();
    let columns = Sensitivity::new(&mut model, system, &variables).columns;
    as_emitted(&mut model.graph, &columns.concat())
}

/// How many operations code that is generated takes for these.
fn as_emitted(graph: &mut Graph, expressions: &[ExprId]) -> usize {
    let settled = graph.settle_signs(expressions, |_| false);
    graph.operation_count(&settled)
}
