//! A machine with contacts at one state.

use super::terms::ContactTerms;
use crate::machine::{Motion, SolveError, States};
use dynamics_codegen::model::ConstraintKind;
use nalgebra::{DMatrix, DVector};

/// Work below this share of what impulses do by themselves is rounding.
const GAIN: f64 = 1e-9;

/// What a step needs to know of a state.
pub(super) struct View {
    pub states: States,
    /// `v`, `n`.
    pub velocity: DVector<f64>,
    /// The motion without contact forces.
    pub motion: Motion,
    pub contacts: ContactTerms,
    /// `P Jᵀ`, `n×3c`: what impulses do to the velocities, under the constraints.
    pub response: DMatrix<f64>,
    /// `W = J P Jᵀ`, `3c×3c`.
    pub mobility: DMatrix<f64>,
}

impl View {
    pub fn new(states: States, motion: Motion, contacts: ContactTerms) -> Result<Self, SolveError> {
        let rows = motion.terms.constraint_bias.len();
        let nothing = DMatrix::zeros(rows, contacts.jacobian.nrows());
        let (response, _) = motion
            .factorisation
            .solve(contacts.jacobian.transpose(), &nothing);
        let mobility = &contacts.jacobian * &response;
        let known = contacts.gap.iter().chain(contacts.velocity.iter());
        if mobility.iter().chain(known).any(|x| !x.is_finite()) {
            return Err(SolveError::NotFinite { sample: 0 });
        }
        Ok(Self {
            velocity: DVector::from_iterator(states.v.len(), states.v.iter().map(|v| v[0])),
            states,
            motion,
            contacts,
            response,
            mobility,
        })
    }

    /// `ẇ = J a − b` without contact forces, `3c`.
    pub fn contact_acceleration(&self) -> DVector<f64> {
        &self.contacts.jacobian * &self.motion.acceleration - &self.contacts.bias
    }

    /// Which planes would be entered within `h` seconds without contact forces.
    pub fn entered(&self, h: f64) -> Vec<bool> {
        let acceleration = self.contact_acceleration();
        let ahead = |i: usize| {
            let (gap, approach) = (self.contacts.gap[i], self.contacts.approach(i));
            gap + h * approach + h * h / 2.0 * acceleration[3 * i + 2]
        };
        (0..self.contacts.len()).map(|i| ahead(i) <= 0.0).collect()
    }

    /// `Jₙ`, `c×n`: how gaps change.
    pub fn normals(&self) -> DMatrix<f64> {
        let rows: Vec<usize> = (0..self.contacts.len()).map(|i| 3 * i + 2).collect();
        self.contacts.jacobian.select_rows(&rows)
    }

    /// `c` of the holonomic constraints, zero for the others, `m`.
    pub fn off_constraints(&self, kinds: &[ConstraintKind]) -> DVector<f64> {
        let mut off = self.motion.terms.constraint_residual.clone();
        for (row, kind) in kinds.iter().enumerate() {
            if *kind == ConstraintKind::Nonholonomic {
                off[row] = 0.0;
            }
        }
        off
    }

    /// `p·(w⁺ + w⁻)/2`: what impulses do to the energy, as seen from the planes, J. Without them
    /// the mean of `w⁺` and `w⁻` would be `mean`.
    pub fn work(&self, impulse: &DVector<f64>, mean: &DVector<f64>) -> f64 {
        impulse.dot(mean) + impulse.dot(&(&self.mobility * impulse)) / 2.0
    }

    /// Whether impulses give energy, rounding aside.
    pub fn gains(&self, impulse: &DVector<f64>, mean: &DVector<f64>) -> bool {
        let size = impulse.dot(&(&self.mobility * impulse));
        self.work(impulse, mean) > GAIN * size
    }

    /// On the way from `soft` impulses, which take energy, to `hard` ones, which give some: the last
    /// that give none. The laws' cone is convex, and the work a parabola.
    pub fn without_gain(
        &self,
        soft: DVector<f64>,
        hard: &DVector<f64>,
        mean: &DVector<f64>,
    ) -> DVector<f64> {
        let way = hard - &soft;
        let there = &self.mobility * &way;
        let square = way.dot(&there) / 2.0;
        let slope = way.dot(mean) + soft.dot(&there);
        let taken = self.work(&soft, mean).min(0.0);
        let root = (slope * slope - 4.0 * square * taken).max(0.0).sqrt();
        let share = (root - slope) / (2.0 * square);
        let share = if share.is_finite() {
            share.clamp(0.0, 1.0)
        } else {
            0.0
        };
        soft + way * share
    }
}
