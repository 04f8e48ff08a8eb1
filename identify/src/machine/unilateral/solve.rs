//! All contacts together: `u = W p + q` with every contact's law.
//!
//! Three ways, each where the one before does not end:
//!
//! 1. [`sweeps`](super::sweeps): each contact in turn gets the impulse that its own law asks for. For
//!    few contacts that is exact after some sweeps. Where more of them press than a body can move (four
//!    corners of a box), it shifts force from one to the other by the same little amount each time.
//! 2. [`newton`](super::newton): all laws at once, of the ways to share a force one.
//! 3. [`associated`](super::associated): a convex problem next to this one, which always has a solution;
//!    from there Newton's method again. Coulomb's law may have no solution nearby; then the associated
//!    one is taken, whose impulses take energy, too.
//!
//! An answer misses no law by more than [`TOLERABLE`] of the fastest approach, the associated one by
//! [`ASSOCIATED`] at most.

use super::law::Law;
use super::{associated, newton, sweeps};
use nalgebra::{DMatrix, DVector, Matrix3, Vector3};

/// What is left of the laws, relative to the largest velocity of what approaches, where one looks no
/// further.
const SETTLED: f64 = 1e-11;
/// The same of an answer.
const TOLERABLE: f64 = 1e-7;
/// The same of the associated law: where Newton's method comes no closer, as far as the convex problem's
/// solver does.
const ASSOCIATED: f64 = 1e-5;
/// A contact whose normal cannot move by this share of the most mobile one's is held by something
/// else.
const HELD: f64 = 1e-12;

/// The contact problem.
pub(super) struct Problem<'a> {
    /// `W = J P Jᵀ`, `3c×3c`.
    pub mobility: &'a DMatrix<f64>,
    /// `q`, `3c`: velocities without impulses, less what they are held to.
    pub velocity: &'a DVector<f64>,
    /// Coefficients of friction, `c`.
    pub friction: &'a DVector<f64>,
}

/// What solves it.
#[derive(Debug)]
pub(super) struct Solution {
    /// `p`, `3c`.
    pub impulse: DVector<f64>,
    /// How many sweeps and steps of Newton's method it took.
    pub sweeps: usize,
    /// Whether it solves the associated law.
    pub relaxed: bool,
}

impl Problem<'_> {
    /// Solves it, beginning from `guess`. `None` if nothing fulfils the laws that was found.
    pub fn solve(&self, guess: DVector<f64>) -> Option<Solution> {
        let movable = self.movable();
        if movable.len() == self.friction.len() {
            return self.solve_movable(guess);
        }
        let rows: Vec<usize> = movable.iter().flat_map(|&i| 3 * i..3 * i + 3).collect();
        let part = Problem {
            mobility: &self.mobility.select_rows(&rows).select_columns(&rows),
            velocity: &self.velocity.select_rows(&rows),
            friction: &self.friction.select_rows(&movable),
        };
        let solution = part.solve_movable(guess.select_rows(&rows))?;
        let mut impulse = DVector::zeros(guess.len());
        let both = rows.iter().zip(solution.impulse.iter());
        both.for_each(|(&row, p)| impulse[row] = *p);
        Some(Solution {
            impulse,
            ..solution
        })
    }

    fn solve_movable(&self, guess: DVector<f64>) -> Option<Solution> {
        let Some(scale) = self.scale() else {
            // Nothing approaches: no impulse fulfils every law.
            return Some(Solution::of(DVector::zeros(guess.len()), 0));
        };
        let (settled, tolerable) = (SETTLED * scale, TOLERABLE * scale);
        let swept = sweeps::solve(self, guess, settled);
        if swept.settled {
            return Some(Solution::of(swept.impulse, swept.sweeps));
        }
        let found = newton::solve(self, Law::Coulomb, swept.impulse, settled);
        let cost = swept.sweeps + found.steps;
        if found.residual <= tolerable {
            return Some(Solution::of(found.impulse, cost));
        }
        let convex = associated::solve(self, scale, settled)?;
        let found = newton::solve(self, Law::Coulomb, convex.impulse.clone(), settled);
        let cost = cost + convex.steps + found.steps;
        if found.residual <= tolerable {
            return Some(Solution::of(found.impulse, cost));
        }
        let relaxed = Solution {
            relaxed: true,
            ..Solution::of(convex.impulse, cost)
        };
        (convex.residual <= ASSOCIATED * scale).then_some(relaxed)
    }

    /// Contacts that an impulse can move.
    fn movable(&self) -> Vec<usize> {
        let normal = |i: usize| self.mobility[(3 * i + 2, 3 * i + 2)];
        let contacts = 0..self.friction.len();
        let most = contacts.clone().map(normal).fold(0.0_f64, f64::max);
        contacts.filter(|&i| normal(i) > HELD * most).collect()
    }

    /// The largest velocity of what approaches; `None` if nothing does.
    fn scale(&self) -> Option<f64> {
        let contacts = (0..self.friction.len()).filter(|i| self.velocity[3 * i + 2] < 0.0);
        contacts
            .map(|i| self.velocity.rows(3 * i, 3).amax())
            .reduce(f64::max)
    }

    /// The mobility of one contact.
    pub fn block(&self, i: usize) -> Matrix3<f64> {
        self.mobility.fixed_view::<3, 3>(3 * i, 3 * i).into_owned()
    }

    /// `W p + q` of one contact.
    pub fn moving(&self, i: usize, impulse: &DVector<f64>) -> Vector3<f64> {
        let rows = self.mobility.rows(3 * i, 3);
        let own: Vector3<f64> = self.velocity.fixed_rows::<3>(3 * i).into_owned();
        own + rows * impulse
    }
}

impl Solution {
    /// Of Coulomb's law.
    fn of(impulse: DVector<f64>, sweeps: usize) -> Self {
        Self {
            impulse,
            sweeps,
            relaxed: false,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::matrix;
    use proptest::prelude::*;

    /// `J M⁻¹ Jᵀ` of a box that lies on four corners: rank six of twelve.
    fn lying_box() -> DMatrix<f64> {
        let (mass, inertia) = (1.2, [0.005, 0.01, 0.013]);
        let mut jacobian = DMatrix::zeros(12, 6);
        for corner in 0..4 {
            let x = if corner & 1 == 0 { 0.15 } else { -0.15 };
            let y = if corner & 2 == 0 { 0.1 } else { -0.1 };
            let z = -0.05;
            let turns = matrix![0.0, z, -y; -z, 0.0, x; y, -x, 0.0];
            let rows = 3 * corner;
            jacobian.view_mut((rows, 0), (3, 3)).fill_with_identity();
            jacobian.view_mut((rows, 3), (3, 3)).copy_from(&turns);
        }
        let inverse = [mass, mass, mass, inertia[0], inertia[1], inertia[2]].map(|m| 1.0 / m);
        let inverse = DMatrix::from_diagonal(&DVector::from_row_slice(&inverse));
        &jacobian * inverse * jacobian.transpose()
    }

    /// What impulses miss of the laws as they are written, m/s and W.
    fn misses(problem: &Problem<'_>, impulse: &DVector<f64>) -> f64 {
        let moving = problem.mobility * impulse + problem.velocity;
        let of = |i: usize| {
            let (p, u) = (impulse.rows(3 * i, 3), moving.rows(3 * i, 3));
            let (friction, slip) = (p.rows(0, 2), u.rows(0, 2));
            let most = problem.friction[i] * p[2];
            let power = slip.dot(&friction) + most * slip.norm();
            let lifts = [-p[2], -u[2], (p[2] * u[2]).abs(), friction.norm() - most];
            lifts.into_iter().fold(power.abs(), f64::max)
        };
        (0..problem.friction.len()).map(of).fold(0.0, f64::max)
    }

    proptest! {
        /// Four corners are one more than a box needs, whatever each of them asks for.
        #[test]
        fn corners_come_to_terms(
            velocity in prop::collection::vec(-2.0..1.0_f64, 12),
            mu in 0.0..1.0_f64,
        ) {
            let (mobility, friction) = (lying_box(), DVector::from_element(4, mu));
            let velocity = DVector::from_vec(velocity);
            let problem = Problem { mobility: &mobility, velocity: &velocity, friction: &friction };
            let solution = problem.solve(DVector::zeros(12));
            prop_assert!(solution.is_some());
            let Solution { impulse, sweeps, relaxed } = solution.unwrap();
            prop_assert!(!relaxed);
            prop_assert!(sweeps < 1000, "{sweeps} sweeps");
            prop_assert!(misses(&problem, &impulse) < 1e-6);
        }

        /// A face that lands flat: all corners ask for the same, but for what rounding left of their
        /// gaps. Sweeps alone shift force for tens of thousands of rounds.
        #[test]
        fn a_face_lands(
            motion in prop::array::uniform3(-1e-2..1e-2_f64),
            gaps in prop::collection::vec(-1e-8..1e-8_f64, 4),
            mu in 0.1..1.0_f64,
        ) {
            let (mobility, friction) = (lying_box(), DVector::from_element(4, mu));
            let [x, y, z] = motion;
            let row = |i: usize| [x, y, gaps[i] - z.abs() - 1e-3];
            let velocity = DVector::from_iterator(12, (0..4).flat_map(row));
            let problem = Problem { mobility: &mobility, velocity: &velocity, friction: &friction };
            let solution = problem.solve(DVector::zeros(12));
            prop_assert!(solution.is_some());
            let Solution { impulse, sweeps, relaxed } = solution.unwrap();
            prop_assert!(!relaxed);
            prop_assert!(sweeps < 1000, "{sweeps} sweeps");
            prop_assert!(misses(&problem, &impulse) < 1e-8);
        }

        /// The associated law has a solution whatever is asked for, and its impulses take energy.
        #[test]
        fn the_convex_problem_has_a_solution(
            velocity in prop::collection::vec(-2.0..1.0_f64, 12),
            mu in 0.0..1.5_f64,
        ) {
            let (mobility, friction) = (lying_box(), DVector::from_element(4, mu));
            let velocity = DVector::from_vec(velocity);
            let problem = Problem { mobility: &mobility, velocity: &velocity, friction: &friction };
            let scale = velocity.amax();
            let found = associated::solve(&problem, scale, SETTLED * scale).unwrap();
            prop_assert!(found.residual < TOLERABLE * scale, "misses it by {:e}", found.residual);
            let moving = &mobility * &found.impulse + &velocity;
            prop_assert!(found.impulse.dot(&moving) < 1e-6);
        }
    }
}
