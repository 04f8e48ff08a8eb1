//! What the rows and columns of quantities belong to, with units.

use super::plan::Entry;
use crate::derive::{Expansion, Group, Term};
use crate::dimension::{Dimension, shown_unit};
use crate::graph::SymbolId;
use crate::model::{AXES, Constraint, ConstraintKind, Coordinate, Model, Position};

/// Everything that a row or column can belong to.
pub(super) struct Axes {
    force: Vec<Entry>,
    acceleration: Vec<Entry>,
    input: Vec<Entry>,
    state: Vec<Entry>,
    state_rate: Vec<Entry>,
    constraint: Vec<Entry>,
    constraint_rate: Vec<Entry>,
    constraint_acceleration: Vec<Entry>,
    contact: Vec<Entry>,
    contact_velocity: Vec<Entry>,
    contact_acceleration: Vec<Entry>,
    coefficient: Vec<Entry>,
    output: Vec<Entry>,
    output_rate: Vec<Entry>,
    sensor: Vec<Entry>,
    positional_output_acceleration: Vec<Entry>,
    multiplier: Vec<Entry>,
    position: Vec<Entry>,
    velocity: Vec<Entry>,
    position_rate: Vec<Entry>,
    parameter: Vec<Entry>,
}

impl Axes {
    /// Those of a model.
    pub fn new(expansion: &Expansion) -> Self {
        let model = &expansion.model;
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
                unit: match order {
                    0 => shown_unit(&z.unit),
                    _ => text(z.dimension.map(|d| over_time(d, order))),
                },
            });
            entries.collect()
        };
        let multipliers = model.constraints.iter().map(|c| Entry {
            name: c.name.clone(),
            unit: text(multiplier_unit(c)),
        });
        let contact_rates = |order: i32| -> Vec<Entry> {
            let entries = model.contacts.iter().flat_map(|contact| {
                contact.plane.axes().map(|axis| Entry {
                    name: format!("{}_{}", contact.name, AXES[axis]),
                    unit: text(Some(over_time(Dimension::LENGTH, order))),
                })
            });
            entries.collect()
        };
        let contacts = model.contacts.iter().map(|contact| Entry {
            name: contact.name.clone(),
            unit: text(Some(Dimension::LENGTH)),
        });
        let coefficients = ["friction", "restitution"].map(|name| Entry {
            name: name.to_string(),
            unit: "1".to_string(),
        });
        let sensors = model.sensors.iter().map(|sensor| Entry {
            name: sensor.name.clone(),
            unit: text(sensor.dimension),
        });
        let parameters = model.parameters.iter().map(|p| Entry {
            name: p.name.clone(),
            unit: shown_unit(&p.unit),
        });
        Self {
            force: coordinates(&|c| text(c.dimension.map(|d| Dimension::ENERGY / d))),
            acceleration: coordinates(&|c| coordinate_unit(c, 2)),
            input: driving(model),
            state: states(0),
            state_rate: states(1),
            constraint: holonomic_rates(0),
            constraint_rate: holonomic_rates(1),
            constraint_acceleration: holonomic_rates(2),
            contact: contacts.collect(),
            contact_velocity: contact_rates(1),
            contact_acceleration: contact_rates(2),
            coefficient: coefficients.to_vec(),
            output: outputs(0),
            output_rate: outputs(1),
            sensor: sensors.collect(),
            positional_output_acceleration: (expansion.system().positional_outputs.iter())
                .map(|&index| outputs(2)[index].clone())
                .collect(),
            multiplier: multipliers.collect(),
            position: coordinates(&|c| coordinate_unit(c, 0)),
            velocity: coordinates(&|c| coordinate_unit(c, 1)),
            position_rate: positions(model, 1),
            parameter: parameters.collect(),
        }
    }

    /// The axes of a term.
    pub fn of(&self, term: Term) -> Vec<Vec<Entry>> {
        let axes: &[&Vec<Entry>] = match term {
            Term::MassMatrix => &[&self.force, &self.acceleration],
            Term::BiasForce
            | Term::AppliedForce
            | Term::Force
            | Term::InverseDynamics
            | Term::ForceResidual => &[&self.force],
            Term::InputMatrix => &[&self.force, &self.input],
            Term::ConstraintJacobian => &[&self.constraint_acceleration, &self.acceleration],
            Term::ConstraintBias | Term::AccelerationResidual => &[&self.constraint_acceleration],
            Term::ConstraintResidual => &[&self.constraint],
            Term::ConstraintRate => &[&self.constraint_rate],
            Term::ContactGap => &[&self.contact],
            Term::ContactVelocity => &[&self.contact_velocity],
            Term::ContactJacobian => &[&self.contact_acceleration, &self.acceleration],
            Term::ContactBias => &[&self.contact_acceleration],
            Term::ContactCoefficients => &[&self.contact, &self.coefficient],
            Term::PositionRate => &[&self.position_rate],
            Term::StateRate => &[&self.state_rate],
            Term::InitialState => &[&self.state],
            Term::Outputs => &[&self.output],
            Term::OutputRates => &[&self.output_rate],
            Term::Sensors | Term::PredictedSensors => &[&self.sensor],
            Term::OutputJacobian => &[&self.positional_output_acceleration, &self.acceleration],
            Term::OutputBias => &[&self.positional_output_acceleration],
            Term::ForwardDynamics | Term::ConstrainedAcceleration => &[&self.acceleration],
            Term::ConstrainedMultipliers => &[&self.multiplier],
        };
        axes.iter().map(|axis| axis.to_vec()).collect()
    }

    /// The axis that differentiation adds; time adds none.
    pub fn of_group(&self, group: Group) -> Option<Vec<Entry>> {
        match group {
            Group::Position => Some(self.position.clone()),
            Group::Velocity => Some(self.velocity.clone()),
            Group::Input => Some(self.input.clone()),
            Group::Parameters => Some(self.parameter.clone()),
            Group::Time => None,
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

/// `Q = Aᵀ λ`: energy over the constraint's unit.
fn multiplier_unit(constraint: &Constraint) -> Option<Dimension> {
    let order = match constraint.kind {
        ConstraintKind::Holonomic => 0,
        ConstraintKind::Nonholonomic => -1,
    };
    let unit = constraint.dimension?;
    Some(Dimension::ENERGY / over_time(unit, order))
}

/// The symbols that generated functions take, in the order of their point and parameters:
/// `t, q, v, u` (inputs, delayed inputs, then multipliers if a force depends on one), `z`,
/// parameters.
pub fn arguments(model: &Model) -> Vec<SymbolId> {
    let mut arguments = vec![model.time];
    arguments.extend(model.position_symbols());
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
        unit: shown_unit(&u.unit),
    });
    let delayed = model.delays.iter().map(|d| Entry {
        name: d.name.clone(),
        unit: shown_unit(&model.inputs[d.input].unit),
    });
    commanded.chain(delayed).collect()
}

/// The unit of a coordinate's `order`-th derivative, as the model names it.
pub(super) fn coordinate_unit(coordinate: &Coordinate, order: i32) -> String {
    unit_over_time(&coordinate.unit, coordinate.dimension, order)
}

fn unit_over_time(unit: &str, dimension: Option<Dimension>, order: i32) -> String {
    let simple = !unit.is_empty() && !unit.contains(['/', '^', '*']);
    match order {
        0 => shown_unit(unit),
        1 if simple => format!("{unit}/s"),
        n if simple => format!("{unit}/s^{n}"),
        n => text(dimension.map(|d| over_time(d, n))),
    }
}

/// The entries of `q`, or of its `order`-th derivative.
pub(super) fn positions(model: &Model, order: i32) -> Vec<Entry> {
    let entry = |p: Position| Entry {
        unit: match (order, p.unit.as_str()) {
            (0, unit) => shown_unit(unit),
            (_, "1") => text(Some(over_time(Dimension::ONE, order))),
            (_, unit) => unit_over_time(unit, Dimension::of_unit(unit), order),
        },
        name: p.name,
    };
    model.positions().into_iter().map(entry).collect()
}

fn over_time(dimension: Dimension, order: i32) -> Dimension {
    dimension / Dimension::TIME.powi(order)
}

/// A unit for whoever reads what was generated; nothing where there is none.
pub(super) fn text(dimension: Option<Dimension>) -> String {
    dimension.map_or_else(String::new, |d| shown_unit(&d.to_string()))
}
