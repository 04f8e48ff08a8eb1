//! Derivatives of inverse and forward dynamics, by recursion.
//!
//! With homogeneous transforms `X`, a link's wrench is the skew part of
//! `Ẍ P Xᵀ`. A displacement of joint `j` below turns it by the joint's twist
//! `E_j`, and `δẌ = Ë_j X + 2 Ė_j Ẋ + E_j Ẍ`. Summed over the subtree of joint
//! `i ≥ j` only three composites remain: the pseudo-inertia `P`, the mixed
//! moment `D = Σ Ẋ P Xᵀ`, and the wrench `F` (compare Carpentier, Mansard 2018;
//! Echeandia, Wensing 2021, whose `B` is the same as `D`):
//!
//! * `∂τ_i/∂q_j = s_i · (Ë_j P + 2 Ė_j D)`, `∂τ_i/∂v_j = s_i · 2 (Ė_j P + E_j D)`
//! * `∂τ_j/∂q_i = s_j · (Ë_i P + 2 Ė_i D + E_i F)`, `∂τ_j/∂v_i = s_j · 2 (Ė_i P + E_i D)`
//!
//! all with the composites of `i`. As everything runs in link frames, each
//! joint sends two wrenches, one covector wrench and one covector towards the
//! root. `D` is linear in the angular part alone: its covector needs no lever.

use super::floating;
use super::mechanism::Mechanism;
use super::message::{AxisMotion, Messages, MixedMoment, axis_motion};
use super::newton_euler::State;
use super::space::Space;
use super::turn;
use crate::graph::{ExprId, Graph};

/// Derivatives of the inverse dynamics `τ(q, v, a)`; rows are forces.
#[derive(Debug, Clone)]
pub struct InverseDerivatives {
    /// `∂τ/∂q`
    pub position: Vec<Vec<ExprId>>,
    /// `∂τ/∂v`
    pub velocity: Vec<Vec<ExprId>>,
}

/// Derivatives of the forward dynamics `a(q, v, Q)`; rows are accelerations.
#[derive(Debug, Clone)]
pub struct ForwardDerivatives {
    /// `a` itself.
    pub acceleration: Vec<ExprId>,
    /// `∂a/∂q`
    pub position: Vec<Vec<ExprId>>,
    /// `∂a/∂v`
    pub velocity: Vec<Vec<ExprId>>,
    /// `∂a/∂Q = M⁻¹`
    pub force: Vec<Vec<ExprId>>,
}

impl Mechanism {
    /// `∂(M a − Q_C)/∂(q, v)` at fixed `a`. For a floating body, whose
    /// quaternion is redundant, by differentiating the graph; they hold along
    /// changes that keep the quaternion a unit.
    ///
    /// # Panics
    /// If `acceleration` does not have one entry per coordinate.
    pub fn inverse_dynamics_derivatives(
        &self,
        g: &mut Graph,
        acceleration: &[ExprId],
    ) -> InverseDerivatives {
        if self.is_floating() {
            return floating::inverse(self, g, acceleration);
        }
        let states = self.states(g, acceleration, true);
        let motions: Vec<AxisMotion> = (0..self.links.len())
            .map(|i| axis_motion(g, self.links[i].freedoms[0].axis, &states[i]))
            .collect();
        let composites = self.composites(g);
        let mixed = self.mixed_moments(g, &states);
        let wrenches = self.wrenches(g, &states);
        let size = self.links.len();
        let zero = g.zero();
        let mut position = vec![vec![zero; size]; size];
        let mut velocity = position.clone();
        for i in 0..size {
            let axis = self.links[i].freedoms[0].axis;
            let mut messages = Messages::new(
                g,
                axis,
                &motions[i],
                &composites[i],
                &mixed[i],
                &wrenches[i],
            );
            position[i][i] = messages.by_position.along(g, axis);
            velocity[i][i] = messages.by_velocity.along(g, axis);
            let mut j = i;
            while let Some(parent) = self.links[j].parent {
                messages = messages.to_parent(g, self, j);
                j = parent;
                let axis = self.links[j].freedoms[0].axis;
                position[i][j] = messages.row_by_position(g, &motions[j]);
                velocity[i][j] = messages.row_by_velocity(g, &motions[j]);
                position[j][i] = messages.by_position.along(g, axis);
                velocity[j][i] = messages.by_velocity.along(g, axis);
            }
        }
        let space = Space::coordinates(self);
        InverseDerivatives {
            position: space.sandwich(g, &position),
            velocity: space.sandwich(g, &velocity),
        }
    }

    /// `∂a/∂(q, v, Q)` through `M ∂a = ∂Q − ∂τ` at the `a` of the forward
    /// dynamics (MATH section 4). For a floating body they hold along changes
    /// that keep its quaternion a unit.
    ///
    /// # Panics
    /// If `force` does not have one entry per coordinate.
    pub fn forward_dynamics_derivatives(
        &self,
        g: &mut Graph,
        force: &[ExprId],
    ) -> ForwardDerivatives {
        if self.is_floating() {
            return floating::forward(self, g, force);
        }
        let acceleration = self.forward_dynamics(g, force);
        let slopes = self.inverse_dynamics_derivatives(g, &acceleration);
        let factor = self.factor(g);
        let mut solve = |slopes: &[Vec<ExprId>]| {
            let columns: Vec<Vec<ExprId>> = (0..slopes.len())
                .map(|j| {
                    let column: Vec<ExprId> = slopes.iter().map(|row| row[j]).collect();
                    factor.solve_negative(g, &column)
                })
                .collect();
            transposed(&columns)
        };
        ForwardDerivatives {
            position: solve(&slopes.position),
            velocity: solve(&slopes.velocity),
            force: factor.inverse(g),
            acceleration,
        }
    }

    fn mixed_moments(&self, g: &mut Graph, states: &[State]) -> Vec<MixedMoment> {
        let mut moments: Vec<MixedMoment> = (self.links.iter().zip(states))
            .map(|(link, state)| MixedMoment::of_link(g, &link.inertia, state))
            .collect();
        for i in (0..self.links.len()).rev() {
            let link = &self.links[i];
            if let Some(parent) = link.parent {
                let column = turn::up(g, &link.stages, moments[i].column);
                let block = turn::up_matrix(g, &link.stages, &moments[i].block);
                let moved = MixedMoment { block, column }.shift(g, link.shift);
                moments[parent] = moments[parent].add(g, &moved);
            }
        }
        moments
    }
}

/// Rows from columns.
pub(super) fn transposed(columns: &[Vec<ExprId>]) -> Vec<Vec<ExprId>> {
    let size = columns.first().map_or(0, Vec::len);
    (0..size)
        .map(|i| columns.iter().map(|column| column[i]).collect())
        .collect()
}
