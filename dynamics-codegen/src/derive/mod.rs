//! From a model to the terms of the constrained equation of motion.

mod constraint;
mod expansion;
mod force;
mod inertial;
mod lagrange;
mod measured;
mod output;
mod reading;
mod regressor;
mod sensitivity;
mod term;
mod unilateral;

pub use expansion::{Expansion, ItemError};
pub use regressor::{InertialRegressor, STANDARD};
pub use sensitivity::{Sensitivity, StateSlope, Variable};
pub use term::{Group, Item, Term};

use crate::graph::{ExprId, SymbolId};
use crate::model::{ConstraintKind, Model};
use reading::Readings;

/// The terms of `M a = Q + Aᵀλ`, `A a = b` [3.17, 3.38] on the model's graph.
/// With `n` coordinates, `m` constraints and `k` inputs:
#[derive(Debug, Clone)]
pub struct System {
    /// Generalised inertia `M(q)`, `n×n`, symmetric.
    pub mass_matrix: Vec<Vec<ExprId>>,
    /// `Q_C`, `n`: fictitious and conservative forces, on the right-hand side.
    pub bias_force: Vec<ExprId>,
    /// `Q_C`, `n`, by the operations that are fewest where `M` is computed as well.
    pub bias_force_beside_mass: Vec<ExprId>,
    /// `Q_D`, `n`: what is left of the stated forces at zero input.
    pub applied_force: Vec<ExprId>,
    /// `B = ∂Q/∂u`, `n×(k+d)`: the inputs, then the `d` delayed ones.
    pub input_matrix: Vec<Vec<ExprId>>,
    /// `Q = Q_C + Q_D + Q_u`, `n`.
    pub force: Vec<ExprId>,
    /// `Q`, `n`, by the operations that are fewest where `M` is computed as well.
    pub force_beside_mass: Vec<ExprId>,
    /// `∂Q/∂λ`, `n×m`: what multipliers do to the forces. Empty if nothing: then `Q`
    /// contains no multiplier.
    pub multiplier_slope: Vec<Vec<ExprId>>,
    /// `A`, `m×n`.
    pub constraint_matrix: Vec<Vec<ExprId>>,
    /// `b`, `m`.
    pub constraint_bias: Vec<ExprId>,
    /// `c`, `m`: what the constraint demands to be zero.
    pub constraint_residual: Vec<ExprId>,
    /// `ċ`, `m`, for holonomic constraints; `c` itself for nonholonomic ones.
    pub constraint_rate: Vec<ExprId>,
    /// Per constraint: differentiated twice or once.
    pub constraint_kinds: Vec<ConstraintKind>,
    /// Per contact, its distance from the plane.
    pub contact_gap: Vec<ExprId>,
    /// Velocities `w` of the contacts, `3c`: of each along the plane's axes, then its normal.
    pub contact_velocity: Vec<ExprId>,
    /// `J = ∂w/∂v`, `3c×n`.
    pub contact_jacobian: Vec<Vec<ExprId>>,
    /// `b` of `ẇ = J a − b`, `3c`.
    pub contact_bias: Vec<ExprId>,
    /// Coefficients of friction and of restitution, `c×2`.
    pub contact_coefficients: Vec<Vec<ExprId>>,
    /// `dz/dt` of the states.
    pub state_rates: Vec<ExprId>,
    /// `z` at the beginning.
    pub initial_states: Vec<ExprId>,
    /// The symbols that stand for `a` in `measured_rates`.
    pub acceleration: Vec<SymbolId>,
    /// What sensors read of the positions, `n`.
    pub measured: Vec<ExprId>,
    /// `d/dt` of that, as a function of `a`, too.
    pub measured_rates: Vec<ExprId>,
    /// Named outputs.
    pub outputs: Vec<ExprId>,
    /// Per output: its derivative along the motion, without acceleration.
    pub output_rates: Vec<ExprId>,
    /// Which outputs `y` depend on positions and time alone.
    pub positional_outputs: Vec<usize>,
    /// Of these, `J = ∂y/∂q`, one row each.
    pub output_jacobian: Vec<Vec<ExprId>>,
    /// Of these, `J̇ v` (with what time adds): `ÿ = J a + J̇ v`.
    pub output_bias: Vec<ExprId>,
    /// What the sensors show without noise, as functions of [`System::arguments_of_sensors`].
    pub sensors: Vec<ExprId>,
    /// By how much later than a reading what it shows is, s: of parameters.
    pub sensor_leads: Vec<ExprId>,
    /// Kinetic energy `T(q, v, t)` of all that the model states.
    pub kinetic_energy: ExprId,
    /// Potential energy `V(q, t)`; of bodies, that of gravity.
    pub potential_energy: ExprId,
}

/// Derives the system. The graph grows; nothing in it changes.
pub fn derive(model: &mut Model) -> System {
    let readings = Readings::new(model);
    let inertial::Inertial {
        mass_matrix,
        bias_force,
        bias_force_beside_mass,
        kinetic_energy,
        potential_energy,
    } = inertial::terms(model, &readings);
    let force::Forces {
        applied_force,
        input_matrix,
        total,
    } = force::forces(model, &readings);
    let mut with = |bias: &[ExprId]| -> Vec<ExprId> {
        let parts = bias.iter().zip(&total);
        parts.map(|(&x, &y)| model.graph.add(x, y)).collect()
    };
    let (force, force_beside_mass) = (with(&bias_force), with(&bias_force_beside_mass));
    let multiplier_slope = if model.uses_multipliers() {
        let multipliers = model.multiplier_symbols();
        model.graph.jacobian(&force, &multipliers)
    } else {
        Vec::new()
    };
    let constraints: Vec<_> = (model.constraints.iter())
        .map(|c| (c.residual, c.kind, c.active))
        .collect();
    let rows: Vec<constraint::Row> = (constraints.into_iter())
        .map(|(residual, kind, active)| {
            let row = constraint::row(model, &readings, residual, kind);
            match active {
                Some(active) => constraint::switched(model, &readings, row, active),
                None => row,
            }
        })
        .collect();
    let contacts = unilateral::contacts(model, &readings);
    let outputs = output::outputs(model, &readings);
    let sensors: Vec<ExprId> = model.sensors.iter().map(|sensor| sensor.value).collect();
    let sensors = readings.resolve(model, &sensors);
    let readings_of = measured::sensors(model, &readings);
    let rates: Vec<ExprId> = model.states.iter().map(|z| z.rate).collect();
    let state_rates = readings.resolve(model, &rates);
    let initial: Vec<ExprId> = model.states.iter().map(|z| z.initial).collect();
    let initial_states = readings.resolve(model, &initial);
    System {
        mass_matrix,
        bias_force,
        bias_force_beside_mass,
        applied_force,
        input_matrix,
        force,
        force_beside_mass,
        multiplier_slope,
        constraint_matrix: rows.iter().map(|row| row.jacobian.clone()).collect(),
        constraint_bias: rows.iter().map(|row| row.bias).collect(),
        constraint_residual: rows.iter().map(|row| row.residual).collect(),
        constraint_rate: rows.iter().map(|row| row.rate).collect(),
        constraint_kinds: model.constraints.iter().map(|c| c.kind).collect(),
        contact_gap: contacts.gap,
        contact_velocity: contacts.velocity,
        contact_jacobian: contacts.jacobian,
        contact_bias: contacts.bias,
        contact_coefficients: contacts.coefficients,
        state_rates,
        initial_states,
        acceleration: readings_of.acceleration,
        measured: readings_of.positions,
        measured_rates: readings_of.rates,
        outputs: outputs.values,
        output_rates: outputs.rates,
        positional_outputs: outputs.positional,
        output_jacobian: outputs.jacobian,
        output_bias: outputs.bias,
        sensors,
        sensor_leads: model.sensors.iter().map(|sensor| sensor.lead).collect(),
        kinetic_energy,
        potential_energy,
    }
}

impl System {
    /// The symbols that the system's functions depend on, in the order
    /// `t, q, v, u, delayed u, z, parameters`.
    pub fn arguments(model: &Model) -> Vec<SymbolId> {
        let mut arguments = vec![model.time];
        arguments.extend(model.position_symbols());
        arguments.extend(model.coordinates.iter().map(|c| c.velocity));
        arguments.extend(model.input_symbols());
        arguments.extend(model.states.iter().map(|z| z.symbol));
        arguments.extend(model.parameters.iter().map(|p| p.symbol));
        arguments
    }

    /// The symbols that sensors depend on: those of [`arguments`](Self::arguments), then the
    /// accelerations, then the multipliers.
    pub fn arguments_of_sensors(model: &Model) -> Vec<SymbolId> {
        let mut arguments = Self::arguments(model);
        arguments.extend(&model.accelerations);
        arguments.extend(model.multiplier_symbols());
        arguments
    }

    /// The same, then the multipliers if a force depends on one.
    pub fn arguments_of_forces(&self, model: &Model) -> Vec<SymbolId> {
        let mut arguments = Self::arguments(model);
        if !self.multiplier_slope.is_empty() {
            arguments.extend(model.multiplier_symbols());
        }
        arguments
    }
}
