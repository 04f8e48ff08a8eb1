//! Whether the measured positions are those of the machine.

use super::dictionary::Dictionary;
use super::error::TraceError;
use super::estimate::Observed;
use crate::machine::States;
use dynamics_codegen::model::ConstraintKind;

/// A violation below this share of the coordinates' travel (a turn counts as 1 rad) may be a geometry that
/// is a little off; above, it is another machine.
const GROSS_VIOLATION: f64 = 0.05;

/// Holonomic constraints must hold in the measured positions themselves.
pub(super) fn check_constraints(
    dictionary: &Dictionary,
    observed: &Observed,
) -> Result<(), TraceError> {
    let focus = dictionary.focus(&[]);
    let machine = &focus.machine;
    let measured = States {
        q: observed.record.q.clone(),
        ..observed.curve.clone()
    };
    let terms = machine.terms(&measured, &focus.values(&dictionary.defaults));
    let travel: Vec<f64> = observed
        .ranges()
        .positions
        .iter()
        .map(|sorted| sorted[sorted.len() - 1] - sorted[0])
        .collect();
    for (row, constraint) in machine.compiled.model.constraints.iter().enumerate() {
        if constraint.kind != ConstraintKind::Holonomic {
            continue;
        }
        let (mut square, mut noise, mut scale, mut worst) = (0.0, 0.0, 0.0_f64, (0.0, 0.0));
        for (sample, at) in terms.iter().enumerate() {
            let c = at.constraint_residual[row];
            square += c * c;
            if c.abs() > worst.0 {
                worst = (c.abs(), measured.t[sample]);
            }
            for i in 0..travel.len() {
                let slope = at.constraint_matrix[(row, i)];
                noise += (slope * observed.position_sd[i]).powi(2);
                scale = scale.max((slope * travel[i].min(1.0)).abs());
            }
        }
        let violation = (square / terms.len() as f64).sqrt();
        let expected = (noise / terms.len() as f64).sqrt();
        if !(violation <= 20.0 * expected || violation <= GROSS_VIOLATION * scale) {
            return Err(TraceError::Constraint {
                constraint: constraint.name.clone(),
                violation,
                expected,
                time: worst.1,
                worst: worst.0,
            });
        }
    }
    Ok(())
}
