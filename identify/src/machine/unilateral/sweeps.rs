//! Contacts in turn: block Gauss–Seidel.
//!
//! Each contact gets the impulse that its own law asks for, with those of the others as they are, until
//! nothing changes. A multiple `ε (p − p_old)` of the change is added to its velocity: it is none
//! where nothing changes, and gives a motion that the machine cannot make (across the plane of a
//! planar model) an impulse that stays what it was.

use super::cone;
use super::solve::Problem;
use nalgebra::{DVector, Matrix3, Vector3};

/// Sweeps at most. What takes more is better solved at once.
const SWEEPS: usize = 100;
/// `ε`, relative to the mobility.
const PROXIMAL: f64 = 1e-9;

/// What sweeps led to.
pub(super) struct Swept {
    /// `p`, `3c`.
    pub impulse: DVector<f64>,
    /// Whether nothing changes any more.
    pub settled: bool,
    pub sweeps: usize,
}

/// Sweeps from `impulse` on until no velocity changes by more than `settled` m/s.
pub(super) fn solve(problem: &Problem<'_>, mut impulse: DVector<f64>, settled: f64) -> Swept {
    let contacts = 0..problem.friction.len();
    let blocks: Vec<Matrix3<f64>> = contacts.map(|i| problem.block(i)).collect();
    for sweep in 1..=SWEEPS {
        let mut change = 0.0_f64;
        for (i, block) in blocks.iter().enumerate() {
            let old: Vector3<f64> = impulse.fixed_rows::<3>(3 * i).into_owned();
            let eased = block + Matrix3::identity() * (PROXIMAL * block.trace());
            let without = problem.moving(i, &impulse) - eased * old;
            let new = cone::impulse(&eased, &without, problem.friction[i]);
            change = change.max(block.trace() * (new - old).amax());
            impulse.fixed_rows_mut::<3>(3 * i).copy_from(&new);
        }
        if change <= settled {
            return Swept {
                impulse,
                settled: true,
                sweeps: sweep,
            };
        }
    }
    Swept {
        impulse,
        settled: false,
        sweeps: SWEEPS,
    }
}
