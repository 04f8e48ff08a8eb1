//! The inverse dynamics of bodies, linear in their standard inertial parameters.
//!
//! `M a − Q_C = Y(q, v, a) φ + …` with `φ` per body `m, h = m c, I_o`: mass, first
//! moment and inertia tensor about the body's origin, in the body's axes (Atkeson, An,
//! Hollerbach 1986). The columns of `Y` follow from Newton–Euler with symbols in place
//! of the inertias; what remains, of energies stated outright, is not part of it.

use crate::graph::{ExprId, SymbolId};
use crate::model::Model;
use crate::tree::{Inertia, Layout, Mechanism, Options, TreeError};
use std::collections::HashMap;

/// Entry `k` of a body's parameters, as it is written.
pub const STANDARD: [&str; 10] = [
    "m", "hx", "hy", "hz", "Ixx", "Iyy", "Izz", "Ixy", "Ixz", "Iyz",
];

/// Where each moment of inertia stands in the tensor.
const MOMENTS: [(usize, usize); 6] = [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)];

/// `Y`, column by column, on the model's graph.
#[derive(Debug, Clone)]
pub struct InertialRegressor {
    /// The symbols that stand for `a`, `n`.
    pub acceleration: Vec<SymbolId>,
    /// The bodies, as indices into [`Model::bodies`].
    pub bodies: Vec<usize>,
    /// Ten columns per body in the order of [`STANDARD`], `n` entries each.
    pub columns: Vec<Vec<ExprId>>,
    /// `φ` as the model states it, expressions of its parameters.
    pub stated: Vec<[ExprId; 10]>,
}

impl InertialRegressor {
    /// For all bodies that move and have a name.
    ///
    /// # Errors
    /// If the bodies do not form a tree; the model's own have been checked.
    pub fn new(model: &mut Model) -> Result<Self, TreeError> {
        let moving: Vec<usize> = model.moving_bodies().map(|body| body.massive).collect();
        let bodies: Vec<usize> = (0..model.bodies.len())
            .filter(|&body| moving.contains(&model.bodies[body].massive))
            .collect();
        let acceleration: Vec<SymbolId> = (0..model.coordinates.len())
            .map(|i| {
                let name = format!("ddq_{}", model.coordinates[i].name);
                model.graph.symbol(name)
            })
            .collect();
        if bodies.is_empty() {
            // Energies alone: there is no tree to walk.
            return Ok(Self {
                acceleration,
                bodies,
                columns: Vec::new(),
                stated: Vec::new(),
            });
        }
        let zero = model.graph.zero();
        let nothing = Inertia {
            mass: zero,
            center: [zero; 3],
            tensor: [[zero; 3]; 3],
        };
        let mut tree = model.tree.clone();
        for body in &mut tree.bodies {
            body.inertia = nothing;
        }
        let mut symbols = Vec::new();
        for &body in &bodies {
            let massive = model.bodies[body].massive;
            let name = &model.bodies[body].name;
            let own = STANDARD.map(|what| model.graph.symbol(format!("{name}.{what}")));
            tree.bodies[massive].inertia = inertia_of(model, own);
            symbols.push(own);
        }
        // Nothing to regroup, and no layout to choose: it is not emitted.
        let options = Options {
            snap: None,
            regroup: false,
            layout: Layout::Distal,
        };
        let graph = &mut model.graph;
        let mechanism = Mechanism::new(graph, &tree, options)?;
        let a: Vec<ExprId> = acceleration.iter().map(|&s| graph.var(s)).collect();
        let needed = mechanism.inverse_dynamics(graph, &a);
        // Linear: any point will do to differentiate at, and this one is the simplest.
        let one = graph.one();
        let mut point = HashMap::new();
        for own in &symbols {
            for (entry, &symbol) in own.iter().enumerate() {
                point.insert(symbol, if entry == 0 { one } else { zero });
            }
        }
        let columns = (symbols.iter().flatten())
            .map(|&symbol| {
                let slope = graph.derivatives(&needed, symbol);
                graph.substitute(&slope, &point)
            })
            .collect();
        let stated = (bodies.iter())
            .map(|&body| stated(model, model.bodies[body].massive))
            .collect();
        Ok(Self {
            acceleration,
            bodies,
            columns,
            stated,
        })
    }
}

/// A body's inertia from the symbols of its standard parameters.
fn inertia_of(model: &mut Model, own: [SymbolId; 10]) -> Inertia {
    let graph = &mut model.graph;
    let entry = own.map(|symbol| graph.var(symbol));
    let mass = entry[0];
    let first = [entry[1], entry[2], entry[3]];
    let center = first.map(|h| graph.div(h, mass));
    // I_c = I_o − m (cᵀc 1 − c cᵀ)
    let mut tensor = [[mass; 3]; 3];
    for (&(i, j), &moment) in MOMENTS.iter().zip(&entry[4..]) {
        let about = steiner(graph, first, center, i, j);
        tensor[i][j] = graph.sub(moment, about);
        tensor[j][i] = tensor[i][j];
    }
    Inertia {
        mass,
        center,
        tensor,
    }
}

/// `φ` of a body as the model states it.
fn stated(model: &mut Model, massive: usize) -> [ExprId; 10] {
    let inertia = model.tree.bodies[massive].inertia;
    let graph = &mut model.graph;
    let first = inertia.center.map(|c| graph.mul(inertia.mass, c));
    let mut standard = [inertia.mass; 10];
    standard[1..4].copy_from_slice(&first);
    for (entry, &(i, j)) in standard[4..].iter_mut().zip(&MOMENTS) {
        let about = steiner(graph, first, inertia.center, i, j);
        *entry = graph.add(inertia.tensor[i][j], about);
    }
    standard
}

/// Entry `(i, j)` of `m (cᵀc 1 − c cᵀ)`, with `h = m c`.
fn steiner(
    graph: &mut crate::graph::Graph,
    first: [ExprId; 3],
    center: [ExprId; 3],
    i: usize,
    j: usize,
) -> ExprId {
    if i != j {
        let product = graph.mul(first[i], center[j]);
        return graph.neg(product);
    }
    let (k, l) = ((i + 1) % 3, (i + 2) % 3);
    let (a, b) = (
        graph.mul(first[k], center[k]),
        graph.mul(first[l], center[l]),
    );
    graph.add(a, b)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Library, compile};

    /// `Y φ` is the inverse dynamics, whatever the state.
    #[test]
    fn the_columns_add_up_to_the_inverse_dynamics() {
        let text = "
            model arm; coordinate a: rad; coordinate b: m;
            parameter m: kg = 2; parameter l: m = 0.3;
            body upper { frame: rotate_x(a); mass: m; center: (0.1, l, -0.2);
                         inertia: full(0.3, 0.2, 0.25, 0.01, -0.02, 0.03); }
            body lower { frame: upper * rotate_y(0.4) * translate(0, 1, b);
                         mass: 1.5; center: (0, 0.2, 0); inertia: diag(0.1, 0.2, 0.15); }
            gravity (0.1, 0, -9.81);
        ";
        let mut compiled = compile("arm.model", text, &Library::empty()).unwrap();
        let regressor = InertialRegressor::new(&mut compiled.model).unwrap();
        assert_eq!(regressor.columns.len(), 20);
        let model = &mut compiled.model;
        let a: Vec<ExprId> = (regressor.acceleration.iter())
            .map(|&s| model.graph.var(s))
            .collect();
        let mechanism = model.mechanism.clone().unwrap();
        let mut outputs = mechanism.inverse_dynamics(&mut model.graph, &a);
        outputs.extend(regressor.columns.iter().flatten());
        outputs.extend(regressor.stated.iter().flatten());
        let mut values = vec![0.0; model.graph.symbol_count()];
        for (index, value) in values.iter_mut().enumerate() {
            *value = 0.3 + 0.17 * index as f64;
        }
        for p in &model.parameters {
            values[p.symbol.index()] = p.nominal;
        }
        let found = model.graph.evaluate(&outputs, &values);
        let (needed, rest) = found.split_at(2);
        let (columns, stated) = rest.split_at(40);
        for row in 0..2 {
            let sum: f64 = (0..20).map(|k| columns[2 * k + row] * stated[k]).sum();
            assert!((sum - needed[row]).abs() < 1e-10, "{sum} {}", needed[row]);
        }
    }
}
