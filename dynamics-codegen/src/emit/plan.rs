//! What is emitted for a model: quantities, and the functions that compute them.

use super::body::Body;
use super::symbols::Symbols;
use crate::compile::Compiled;
use crate::dimension::Dimension;
use crate::graph::{ExprId, SymbolId};
use crate::model::{Constraint, ConstraintKind, Coordinate, Model};

/// A row or column of a quantity.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Entry {
    /// The coordinate, input, constraint or output it belongs to.
    pub name: String,
    /// Its unit; empty if the model does not say.
    pub unit: String,
}

/// A vector or matrix of the equation of motion.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Quantity {
    /// The emitted function's name.
    pub name: &'static str,
    /// What it is, with its symbol in the thesis.
    pub meaning: &'static str,
    /// What each row belongs to. A matrix entry's unit is its row's over its column's.
    pub rows: Vec<Entry>,
    /// What each column belongs to; `None` for a vector.
    pub columns: Option<Vec<Entry>>,
    /// The entries, row by row.
    pub entries: Vec<ExprId>,
    /// How temporaries that hold an entry are called.
    pub(super) prefix: &'static str,
}

impl Quantity {
    /// A wish for the name of the temporary that holds entry `index`.
    pub(super) fn entry_name(&self, index: usize) -> String {
        match &self.columns {
            None => format!("{}_{}", self.prefix, self.rows[index].name),
            Some(columns) => {
                let (row, column) = (index / columns.len(), index % columns.len());
                format!(
                    "{}_{}_{}",
                    self.prefix, self.rows[row].name, columns[column].name
                )
            }
        }
    }
}

/// The quantities of a model that have any entry, in the order of emission.
pub fn quantities(compiled: &Compiled) -> Vec<Quantity> {
    let system = &compiled.system;
    let axes = Axes::new(compiled);
    let flat = |rows: &[Vec<ExprId>]| rows.concat();
    let all = [
        matrix(
            "mass_matrix",
            "Generalised inertia `M(q)`, symmetric",
            "m",
            (&axes.force, &axes.acceleration),
            flat(&system.mass_matrix),
        ),
        vector(
            "bias_force",
            "Bias force `Q_C`: fictitious and conservative forces, on the right-hand side",
            "bias",
            &axes.force,
            &system.bias_force,
        ),
        vector(
            "applied_force",
            "Stated and dissipative forces `Q_D` at zero input",
            "applied",
            &axes.force,
            &system.applied_force,
        ),
        matrix(
            "input_matrix",
            "Input matrix `B = ∂Q/∂u`",
            "b",
            (&axes.force, &axes.input),
            flat(&system.input_matrix),
        ),
        vector(
            "force",
            "Total generalised force `Q = Q_C + Q_D + Q_u`",
            "force",
            &axes.force,
            &system.force,
        ),
        matrix(
            "constraint_jacobian",
            "Constraint matrix `A` of `A a = b`",
            "a",
            (&axes.constraint_acceleration, &axes.acceleration),
            flat(&system.constraint_matrix),
        ),
        vector(
            "constraint_bias",
            "Right-hand side `b` of `A a = b`, without stabilisation",
            "b",
            &axes.constraint_acceleration,
            &system.constraint_bias,
        ),
        vector(
            "constraint_residual",
            "Constraint violation `c`, zero where the constraint holds",
            "c",
            &axes.constraint,
            &system.constraint_residual,
        ),
        vector(
            "constraint_rate",
            "Rate `ċ` of a holonomic constraint; `c` itself of a nonholonomic one",
            "c_dot",
            &axes.constraint_rate,
            &system.constraint_rate,
        ),
        vector(
            "state_rate",
            "Rates `dz/dt` of the internal states",
            "z_rate",
            &axes.state_rate,
            &system.state_rates,
        ),
        vector(
            "initial_state",
            "Values of the internal states at the beginning",
            "z_start",
            &axes.state,
            &system.initial_states,
        ),
        vector(
            "outputs",
            "Values of the model's outputs",
            "out",
            &axes.output,
            &system.outputs,
        ),
        vector(
            "output_rates",
            "Rates of the outputs along the motion, without the acceleration's part",
            "out_rate",
            &axes.output_rate,
            &system.output_rates,
        ),
        matrix(
            "output_jacobian",
            "Jacobian `J = ∂y/∂q` of the outputs that depend on positions alone",
            "jacobian",
            (&axes.positional_output_acceleration, &axes.acceleration),
            flat(&system.output_jacobian),
        ),
        vector(
            "output_bias",
            "`J̇ v` of the outputs that depend on positions alone: `ÿ = J a + J̇ v`",
            "out_bias",
            &axes.positional_output_acceleration,
            &system.output_bias,
        ),
    ];
    all.into_iter().filter(|q| !q.entries.is_empty()).collect()
}

/// The name of the fused function.
const EQUATION_OF_MOTION: &str = "equation_of_motion";

/// What the fused function `equation_of_motion` computes.
const FUSED: [&str; 6] = [
    "mass_matrix",
    "force",
    "constraint_jacobian",
    "constraint_bias",
    "constraint_residual",
    "constraint_rate",
];

/// One emitted function: a single quantity, or several that share their temporaries.
#[derive(Debug, Clone)]
pub(super) struct Function<'a> {
    pub name: &'static str,
    pub quantities: Vec<&'a Quantity>,
}

/// One function per quantity, then the fused one.
pub(super) fn functions(quantities: &[Quantity]) -> Vec<Function<'_>> {
    let single = quantities.iter().map(|quantity| Function {
        name: quantity.name,
        quantities: vec![quantity],
    });
    let fused = Function {
        name: EQUATION_OF_MOTION,
        quantities: quantities
            .iter()
            .filter(|q| FUSED.contains(&q.name))
            .collect(),
    };
    single.chain([fused]).collect()
}

impl Function<'_> {
    pub fn entries(&self) -> Vec<ExprId> {
        let entries = self.quantities.iter().flat_map(|q| &q.entries);
        entries.copied().collect()
    }

    /// Whether it computes several quantities.
    pub fn is_fused(&self) -> bool {
        self.name == EQUATION_OF_MOTION
    }

    /// The straight lines that compute it.
    pub fn body(&self, compiled: &Compiled, symbols: &Symbols) -> Body {
        let mut outputs = Vec::new();
        for quantity in &self.quantities {
            let wishes = (0..quantity.entries.len()).map(|i| quantity.entry_name(i));
            outputs.extend(quantity.entries.iter().copied().zip(wishes));
        }
        Body::new(&compiled.model.graph, symbols, &outputs)
    }
}

fn vector(
    name: &'static str,
    meaning: &'static str,
    prefix: &'static str,
    rows: &[Entry],
    entries: &[ExprId],
) -> Quantity {
    Quantity {
        name,
        meaning,
        rows: rows.to_vec(),
        columns: None,
        entries: entries.to_vec(),
        prefix,
    }
}

fn matrix(
    name: &'static str,
    meaning: &'static str,
    prefix: &'static str,
    (rows, columns): (&[Entry], &[Entry]),
    entries: Vec<ExprId>,
) -> Quantity {
    Quantity {
        name,
        meaning,
        rows: rows.to_vec(),
        columns: Some(columns.to_vec()),
        entries,
        prefix,
    }
}

/// Everything that a row or column can belong to.
struct Axes {
    force: Vec<Entry>,
    acceleration: Vec<Entry>,
    input: Vec<Entry>,
    state: Vec<Entry>,
    state_rate: Vec<Entry>,
    constraint: Vec<Entry>,
    constraint_rate: Vec<Entry>,
    constraint_acceleration: Vec<Entry>,
    output: Vec<Entry>,
    output_rate: Vec<Entry>,
    positional_output_acceleration: Vec<Entry>,
}

impl Axes {
    fn new(compiled: &Compiled) -> Self {
        let model = &compiled.model;
        let coordinates = |unit: &dyn Fn(&Coordinate) -> String| -> Vec<Entry> {
            let entry = |c: &Coordinate| Entry {
                name: c.name.clone(),
                unit: unit(c),
            };
            model.coordinates.iter().map(entry).collect()
        };
        let holonomic_rates = |extra: i32| -> Vec<Entry> {
            let entries = model.constraints.iter().map(|c| {
                let order = match c.kind {
                    ConstraintKind::Holonomic => extra,
                    ConstraintKind::Nonholonomic => extra.saturating_sub(1),
                };
                Entry {
                    name: c.name.clone(),
                    unit: text(c.dimension.map(|d| over_time(d, order))),
                }
            });
            entries.collect()
        };
        let outputs = |order: i32| -> Vec<Entry> {
            let entries = model.outputs.iter().map(|o| Entry {
                name: o.name.clone(),
                unit: text(o.dimension.map(|d| over_time(d, order))),
            });
            entries.collect()
        };
        let states = |order: i32| -> Vec<Entry> {
            let entries = model.states.iter().map(|z| Entry {
                name: z.name.clone(),
                unit: text(z.dimension.map(|d| over_time(d, order))),
            });
            entries.collect()
        };
        Self {
            force: coordinates(&|c| text(c.dimension.map(|d| Dimension::ENERGY / d))),
            acceleration: coordinates(&|c| coordinate_unit(c, 2)),
            input: driving(model),
            state: states(0),
            state_rate: states(1),
            constraint: holonomic_rates(0),
            constraint_rate: holonomic_rates(1),
            constraint_acceleration: holonomic_rates(2),
            output: outputs(0),
            output_rate: outputs(1),
            positional_output_acceleration: (compiled.system.positional_outputs.iter())
                .map(|&index| outputs(2)[index].clone())
                .collect(),
        }
    }
}

/// The inputs as generated code has them: those of the model, the delayed ones, then the
/// multipliers if a force depends on one.
pub(super) fn inputs(model: &Model) -> Vec<Entry> {
    let mut inputs = driving(model);
    if model.uses_multipliers() {
        inputs.extend(model.constraints.iter().map(|c| Entry {
            name: format!("lambda_{}", c.name),
            unit: text(multiplier_unit(c)),
        }));
    }
    inputs
}

/// That of a force that works along the constraint.
fn multiplier_unit(constraint: &Constraint) -> Option<Dimension> {
    let unit = constraint.dimension?;
    Some(match constraint.kind {
        ConstraintKind::Holonomic => Dimension::ENERGY / unit,
        ConstraintKind::Nonholonomic => Dimension::ENERGY / (unit * Dimension::TIME),
    })
}

/// The symbols that generated functions take, in the order of their point and parameters:
/// `t, q, v, u` (inputs, delayed inputs, then multipliers if a force depends on one), `z`,
/// parameters.
pub fn arguments(model: &Model) -> Vec<SymbolId> {
    let mut arguments = vec![model.time];
    arguments.extend(model.coordinates.iter().map(|c| c.position));
    arguments.extend(model.coordinates.iter().map(|c| c.velocity));
    arguments.extend(model.input_symbols());
    if model.uses_multipliers() {
        arguments.extend(model.multiplier_symbols());
    }
    arguments.extend(model.states.iter().map(|z| z.symbol));
    arguments.extend(model.parameters.iter().map(|p| p.symbol));
    arguments
}

/// What drives the model: its inputs, then the delayed ones.
fn driving(model: &Model) -> Vec<Entry> {
    let commanded = model.inputs.iter().map(|u| Entry {
        name: u.name.clone(),
        unit: u.unit.clone(),
    });
    let delayed = model.delays.iter().map(|d| Entry {
        name: d.name.clone(),
        unit: model.inputs[d.input].unit.clone(),
    });
    commanded.chain(delayed).collect()
}

/// The unit of a coordinate's `order`-th derivative, in the words of the model.
pub(super) fn coordinate_unit(coordinate: &Coordinate, order: i32) -> String {
    let simple = !coordinate.unit.is_empty() && !coordinate.unit.contains(['/', '^', '*']);
    match order {
        0 => coordinate.unit.clone(),
        1 if simple => format!("{}/s", coordinate.unit),
        n if simple => format!("{}/s^{n}", coordinate.unit),
        n => text(coordinate.dimension.map(|d| over_time(d, n))),
    }
}

fn over_time(dimension: Dimension, order: i32) -> Dimension {
    dimension / Dimension::TIME.powi(order)
}

fn text(dimension: Option<Dimension>) -> String {
    dimension.map_or_else(String::new, |d| d.to_string())
}
