//! A force without a name, in words.

use super::figures::force_unit;
use super::stated_unit;
use crate::number::short;
use crate::trace::{Unnamed, UnnamedForce};
use dynamics_codegen::Model;

/// What the microscope saw, a sentence or two per coordinate, and what its terms gain. Beside what was
/// found if that `is_left` by it, else beside the model as given.
pub(super) fn sentences(unnamed: &Unnamed, is_left: bool, model: &Model) -> Vec<String> {
    let forces = unnamed.forces.iter().map(|force| sentence(force, model));
    let beside = match is_left {
        true => "the patched model",
        false => "the model as given",
    };
    forces.chain([gain(unnamed, beside)]).collect()
}

fn sentence(force: &UnnamedForce, model: &Model) -> String {
    let unit = |name: &str| {
        let mut positions = model.positions().into_iter();
        let unit = positions.find(|c| c.name == name).map(|c| c.unit);
        force_unit(&stated_unit(&unit.unwrap_or_default()))
    };
    // A past may stand there several times, forgotten over different ways.
    let mut on: Vec<&str> = Vec::new();
    for variable in force.depends_on.iter().map(|d| &d.variable[..]) {
        if !on.contains(&variable) {
            on.push(variable);
        }
    }
    let kind = match (force.dissipation, force.odd_in_velocity) {
        (d, odd) if d > DISTINCT && odd > DISTINCT => "it brakes, and turns with the velocity",
        (d, _) if d > DISTINCT => "it brakes",
        (d, _) if d < -DISTINCT => "it drives",
        (_, odd) if odd < -DISTINCT => "it neither brakes nor drives, as a spring's",
        _ => "it neither clearly brakes nor drives",
    };
    let past = if force.remembers {
        "; it remembers where the coordinate has come from"
    } else {
        ""
    };
    let depends = if force.explained > 0.0 {
        format!(
            "depends on {}, which explain {} % of it in runs of the log not fitted",
            on.join(", "),
            short(100.0 * force.explained)
        )
    } else {
        "depends on nothing that was measured, as far as runs of the log not fitted tell"
            .to_string()
    };
    format!(
        "A force on {}, {} {} (root mean square), lasts {} s and {depends}; {kind}{past}.",
        force.coordinate,
        short(force.size),
        unit(&force.coordinate),
        short(force.lasts),
    )
}

/// From here on a correlation is called distinct.
const DISTINCT: f64 = 0.3;

fn gain(unnamed: &Unnamed, beside: &str) -> String {
    if unnamed.recovered.is_nan() {
        return format!(
            "In the accelerations of the log that is judged by {beside} misses nothing beyond sensor \
             noise: there Gaussian-process terms have nothing to gain."
        );
    }
    if unnamed.recovered <= 0.0 {
        return format!(
            "As Gaussian-process terms beside {beside}, these predict the log that is judged by no \
             better: they are of no use for prediction."
        );
    }
    format!(
        "As Gaussian-process terms beside {beside}, these bring the acceleration error to {} \
         of its scale: {} % of what sensor noise does not explain is gone.",
        short(unnamed.acceleration_after.total),
        short(100.0 * unnamed.recovered),
    )
}
