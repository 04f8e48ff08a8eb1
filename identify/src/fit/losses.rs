//! What a robot description says of friction: where the effects begin that do the same.

use super::extended::Extended;
use super::groups::Group;
use crate::machine::States;
use dynamics_codegen::Model;
use dynamics_codegen::model::FRICTION_SPEED;

/// Where two laws are compared, in units of the speed over which dry friction changes its sign.
const SPEEDS: [f64; 6] = [-150.0, -3.0, -0.6, 0.3, 1.2, 40.0];
/// Relative difference of two laws that are one.
const ROUND_OFF: f64 = 1e-9;

/// Two laws of friction that a description may state of a joint.
type Law = fn(f64) -> f64;

/// States what the model's robot description says of joints, `damping v + friction tanh(v/v_s)`,
/// for the first coefficient whose column is that law; the columns of the groups begin at `first`.
pub(super) fn state_losses(model: &Model, extended: &Extended, groups: &mut [Group], first: usize) {
    let losses = model.robot.iter().flat_map(|robot| &robot.losses);
    let losses: Vec<_> = losses.filter(|losses| !losses.follows).collect();
    if losses.is_empty() {
        return;
    }
    let columns = along_speeds(model, extended, groups);
    for losses in losses {
        let friction: [(Law, f64); 2] = [
            (|v| v, losses.damping),
            (|v| (v / FRICTION_SPEED).tanh(), losses.friction),
        ];
        for (law, stated) in friction {
            let own = groups.iter_mut();
            let mut own = own.filter(|group| group.places == [losses.coordinate]);
            let found = own.find_map(|group| {
                let begin = group.columns.start - first;
                let mut all = 0..group.coefficients.len();
                let position = all.find(|k| is(law, &columns[begin + k][losses.coordinate]))?;
                Some((group, position))
            });
            if let Some((group, position)) = found {
                state(group, position, stated);
            }
        }
    }
}

/// What the model states of an effect stands beside the description, not in its place.
fn state(group: &mut Group, position: usize, stated: f64) {
    let coefficient = &mut group.coefficients[position];
    if coefficient.holder.is_some() {
        return;
    }
    coefficient.stated += stated;
    if stated != 0.0 {
        let effect = &coefficient.effect;
        let own = group.shapes.iter_mut();
        let own = own.filter(|shape| shape.effect == *effect);
        own.for_each(|shape| shape.stated = Some(FRICTION_SPEED));
    }
}

/// The columns of all groups, where every coordinate moves at each of the speeds.
fn along_speeds(model: &Model, extended: &Extended, groups: &[Group]) -> Vec<Vec<Vec<f64>>> {
    let (n, samples) = (model.coordinates.len(), SPEEDS.len());
    let nothing = |count: usize| vec![vec![0.0; samples]; count];
    let states = States {
        t: vec![0.0; samples],
        q: nothing(n),
        v: vec![SPEEDS.map(|v| v * FRICTION_SPEED).to_vec(); n],
        u: nothing(model.inputs.len()),
        ..States::default()
    };
    let shapes = groups.iter().flat_map(|group| &group.shapes);
    let shapes: Vec<(usize, f64)> = shapes.map(|shape| (shape.index, FRICTION_SPEED)).collect();
    extended.columns(&states, &nothing(n), &shapes)
}

fn is(law: Law, column: &[f64]) -> bool {
    let mut pairs = SPEEDS.iter().zip(column);
    pairs.all(|(v, found)| {
        let expected = law(v * FRICTION_SPEED);
        (found - expected).abs() <= ROUND_OFF * expected.abs()
    })
}
