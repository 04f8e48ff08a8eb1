//! What sensors read of positions and velocities.

use super::reading::Readings;
use crate::graph::{ExprId, SymbolId};
use crate::model::Model;

pub(super) struct Sensors {
    pub acceleration: Vec<SymbolId>,
    pub positions: Vec<ExprId>,
    pub rates: Vec<ExprId>,
}

/// The readings of positions, and their time derivatives along the motion.
pub(super) fn sensors(model: &mut Model, readings: &Readings) -> Sensors {
    let acceleration: Vec<SymbolId> = (0..model.coordinates.len())
        .map(|i| {
            let name = format!("ddq_{}", model.coordinates[i].name);
            model.graph.symbol(name)
        })
        .collect();
    let positions: Vec<ExprId> = (0..model.coordinates.len())
        .map(|i| model.measured_position(i))
        .collect();
    let mut seeds = model.time_seeds();
    for (coordinate, &a) in model.coordinates.iter().zip(&acceleration) {
        seeds.push((coordinate.velocity, model.graph.var(a)));
    }
    let rates = model.graph.directional(&positions, &seeds);
    Sensors {
        positions: readings.resolve(model, &positions),
        rates: readings.resolve(model, &rates),
        acceleration,
    }
}
