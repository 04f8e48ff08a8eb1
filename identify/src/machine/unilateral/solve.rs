//! All contacts together: `u = W p + q` with every contact's law, by block Gauss–Seidel.
//!
//! Each contact in turn gets the impulse that its own law asks for, with those of the others as they
//! are, until nothing changes. A multiple `ε (p − p_old)` of the change is added to its velocity: it is
//! none where nothing changes, and gives a motion that the machine cannot make (across the plane of
//! a planar model) an impulse that stays what it was.
//!
//! Where more contacts press than a body can move (four corners of a box), sweeps may shift force
//! from one to the other by the same little amount each time, until one of them lifts. Now and then
//! the shift is continued to where it leads (Aitken), at most until a contact lifts.
//!
//! Coulomb's law with several contacts need not attract: sweeps may go round in circles. Then the
//! associated law is solved in its place (Anitescu, Math. Program. 105, 2006): a contact that slides lifts by `μ`
//! times its slip. That problem is convex, sweeps of it end, and its impulses take energy, too.

use super::cone;
use nalgebra::{DMatrix, DVector, Matrix3, Vector3};

/// Sweeps at most.
const SWEEPS: usize = 20_000;
/// A change of the velocities that is none, relative to the largest of what approaches.
const SETTLED: f64 = 1e-12;
/// What is left of the laws, relative to the same, that an answer may have if sweeps run out.
const TOLERABLE: f64 = 1e-7;
/// `ε`, relative to the mobility.
const PROXIMAL: f64 = 1e-9;
/// A contact whose normal cannot move by this share of the most mobile one's is held by something
/// else.
const HELD: f64 = 1e-12;

/// So many sweeps lie between two attempts to see where they lead.
const LEAP: usize = 20;

/// The contact problem.
pub(super) struct Problem<'a> {
    /// `W = J P Jᵀ`, `3c×3c`.
    pub mobility: &'a DMatrix<f64>,
    /// `q`, `3c`: velocities without impulses, less what they are held to.
    pub velocity: &'a DVector<f64>,
    /// Coefficients of friction, `c`.
    pub friction: &'a DVector<f64>,
}

/// One contact's impulse from its mobility, its velocity without it, its friction and what the impulse
/// was before.
type Law = fn(&Matrix3<f64>, &Vector3<f64>, f64, &Vector3<f64>) -> Vector3<f64>;

/// What solves it.
#[derive(Debug)]
pub(super) struct Solution {
    /// `p`, `3c`.
    pub impulse: DVector<f64>,
    /// How many sweeps it took.
    pub sweeps: usize,
    /// Whether it solves the associated law.
    pub relaxed: bool,
}

impl Problem<'_> {
    /// Solves it, beginning from `guess`. `None` if nothing fulfils the laws that was found.
    pub fn solve(&self, guess: DVector<f64>) -> Option<Solution> {
        let nothing = DVector::zeros(guess.len());
        self.swept(guess, cone::impulse).or_else(|| {
            let solution = self.swept(nothing, cone::associated)?;
            let relaxed = true;
            Some(Solution {
                relaxed,
                ..solution
            })
        })
    }

    /// Sweeps under one law.
    fn swept(&self, guess: DVector<f64>, law: Law) -> Option<Solution> {
        let solution = |impulse, sweeps| Solution {
            impulse,
            sweeps,
            relaxed: false,
        };
        let contacts = self.friction.len();
        let blocks: Vec<Matrix3<f64>> = (0..contacts).map(|i| self.block(i, i)).collect();
        let most = blocks.iter().fold(0.0_f64, |most, w| most.max(w.m33));
        let Some(scale) = self.scale() else {
            // Nothing approaches: no impulse fulfils every law.
            return Some(solution(DVector::zeros(guess.len()), 0));
        };
        let mut impulse = guess;
        for (i, block) in blocks.iter().enumerate() {
            if block.m33 <= HELD * most {
                impulse.rows_mut(3 * i, 3).fill(0.0);
            }
        }
        let mut before = DVector::zeros(impulse.len());
        for sweep in 0..SWEEPS {
            let (mut change, start) = (0.0_f64, impulse.clone());
            for (i, block) in blocks.iter().enumerate() {
                if block.m33 <= HELD * most {
                    continue;
                }
                let old: Vector3<f64> = impulse.fixed_rows::<3>(3 * i).into_owned();
                let new = self.improved(i, block, &impulse, law);
                change = change.max(block.trace() * (new - old).amax());
                impulse.fixed_rows_mut::<3>(3 * i).copy_from(&new);
            }
            if !change.is_finite() {
                return None;
            }
            if change <= SETTLED * scale {
                return Some(solution(impulse, sweep + 1));
            }
            let drift = &impulse - start;
            if sweep % LEAP == LEAP - 1 {
                leap(&mut impulse, &drift, &before);
            }
            before = drift;
        }
        let tolerable = self.violation(&impulse, &blocks, law) <= TOLERABLE * scale;
        tolerable.then(|| solution(impulse, SWEEPS))
    }

    /// The largest velocity of what approaches; `None` if nothing does.
    fn scale(&self) -> Option<f64> {
        let contacts = (0..self.friction.len()).filter(|i| self.velocity[3 * i + 2] < 0.0);
        contacts
            .map(|i| self.velocity.rows(3 * i, 3).amax())
            .reduce(f64::max)
    }

    fn block(&self, i: usize, j: usize) -> Matrix3<f64> {
        self.mobility.fixed_view::<3, 3>(3 * i, 3 * j).into_owned()
    }

    /// `W p + q` of one contact.
    fn moving(&self, i: usize, impulse: &DVector<f64>) -> Vector3<f64> {
        let rows = self.mobility.rows(3 * i, 3);
        let own: Vector3<f64> = self.velocity.fixed_rows::<3>(3 * i).into_owned();
        own + rows * impulse
    }

    /// The impulse of contact `i` with those of the others as they are.
    fn improved(
        &self,
        i: usize,
        block: &Matrix3<f64>,
        impulse: &DVector<f64>,
        law: Law,
    ) -> Vector3<f64> {
        let old: Vector3<f64> = impulse.fixed_rows::<3>(3 * i).into_owned();
        let epsilon = PROXIMAL * block.trace();
        let eased = block + Matrix3::identity() * epsilon;
        let without = self.moving(i, impulse) - eased * old;
        law(&eased, &without, self.friction[i], &old)
    }

    /// How far impulses are from the laws, as a velocity, m/s.
    fn violation(&self, impulse: &DVector<f64>, blocks: &[Matrix3<f64>], law: Law) -> f64 {
        let miss = |(i, block): (usize, &Matrix3<f64>)| {
            let old: Vector3<f64> = impulse.fixed_rows::<3>(3 * i).into_owned();
            let new = self.improved(i, block, impulse, law);
            block.trace() * (new - old).amax()
        };
        blocks.iter().enumerate().map(miss).fold(0.0_f64, f64::max)
    }
}

/// Goes on along the last `drift`, as the two last ones foretell: by `ρ + ρ² + …` times it.
fn leap(impulse: &mut DVector<f64>, drift: &DVector<f64>, before: &DVector<f64>) {
    let ratio = drift.dot(before) / before.norm_squared();
    // What turns, or grows, foretells nothing.
    let straight = (drift - before * ratio).norm() <= 0.1 * drift.norm();
    if !straight || !(0.5..=1.0 + 1e-6).contains(&ratio) {
        return;
    }
    let foretold = if ratio < 1.0 {
        ratio / (1.0 - ratio)
    } else {
        f64::INFINITY
    };
    let lifts = (0..impulse.len() / 3).filter(|i| drift[3 * i + 2] < 0.0);
    let until = lifts.map(|i| -impulse[3 * i + 2] / drift[3 * i + 2]);
    let way = until.fold(foretold, f64::min);
    if way.is_finite() {
        impulse.axpy(way, drift, 1.0);
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
            prop_assert!(sweeps < 5000, "{sweeps} sweeps");
            let moving = &mobility * &impulse + &velocity;
            for i in 0..4 {
                let (p, u) = (impulse.rows(3 * i, 3), moving.rows(3 * i, 3));
                prop_assert!(p[2] >= 0.0 && u[2] > -1e-8 && p[2] * u[2] < 1e-8);
                let (friction, slip) = (p.rows(0, 2), u.rows(0, 2));
                prop_assert!(friction.norm() <= mu * p[2] + 1e-12);
                let power = slip.dot(&friction) + mu * p[2] * slip.norm();
                prop_assert!(power.abs() < 1e-8, "slips by {slip} under {friction}");
            }
        }
    }
}
