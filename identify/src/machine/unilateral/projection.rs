//! Part 3 of a step: out of planes, onto constraints.

use super::solve::Problem;
use super::step::Stepping;
use super::view::View;
use crate::machine::{Simulated, SolveError};
use nalgebra::{DMatrix, DVector};

/// This far inside of a plane, or off a constraint, is not worth a projection, m.
pub(super) const INSIDE: f64 = 1e-11;
/// A projection that moves a coordinate further is followed by another one.
const FAR: f64 = 1e-8;
/// Projections in one step at most.
const PROJECTIONS: usize = 20;

impl Stepping<'_> {
    /// The state moved out of planes and onto constraints, and what it looks like there.
    pub(super) fn projected(
        &mut self,
        state: &mut Simulated,
        t: f64,
        input: &[Vec<f64>],
    ) -> Result<View, SolveError> {
        let mut view = self.view(state, t, input)?;
        for _ in 0..PROJECTIONS {
            let off = view.off_constraints(self.machine.constraint_kinds());
            let inside = view.contacts.gap.iter().any(|&gap| gap < -INSIDE);
            if !inside && off.amax() <= INSIDE {
                break;
            }
            let shift = self.shift(&view, off)?;
            self.move_by(&mut state.q, &shift, 1.0);
            let gaps = &view.contacts.gap + view.normals() * &shift;
            if shift.amax() <= FAR {
                // What the shift changes in everything else is its square.
                view.contacts.gap = gaps;
                break;
            }
            view = self.view(state, t, input)?;
        }
        Ok(view)
    }

    /// `δq = M⁻¹ (Aᵀ η + Jₙᵀ μ)` with `A δq = −c` and `g + Jₙ δq ≥ 0 ⟂ μ ≥ 0`.
    fn shift(&mut self, view: &View, off: DVector<f64>) -> Result<DVector<f64>, SolveError> {
        let n = view.velocity.len();
        let onto = DMatrix::from_column_slice(off.len(), 1, (-off).as_slice());
        let (onto, _) = view.motion.factorisation.solve(DMatrix::zeros(n, 1), &onto);
        let onto: DVector<f64> = onto.column(0).into_owned();
        let gaps = &view.contacts.gap + view.normals() * &onto;
        let mut distance = DVector::zeros(3 * gaps.len());
        gaps.iter()
            .enumerate()
            .for_each(|(i, gap)| distance[3 * i + 2] = *gap);
        let smooth = DVector::zeros(gaps.len());
        let problem = Problem {
            mobility: &view.mobility,
            velocity: &distance,
            friction: &smooth,
        };
        let out = self.solution(&problem, DVector::zeros(distance.len()))?;
        Ok(onto + &view.response * out)
    }
}
