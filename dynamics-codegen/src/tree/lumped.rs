//! Bias force from composite inertias.
//!
//! If joint `i` stood still, all that hangs on it would move with what carries it: its
//! composite pseudo-inertia `P_i` would feel the carrier's `Ẍ`. The joint's own rate adds
//! `A_i = 2 Ẋ E v + E² v²`, with `E` its unit twist, to the `Ẍ` of all that hangs on it. So
//!
//! `τ_i = s_i · (Ẍ ∘ P_i + A_i ∘ P_i + G)`, and the carrier gets `A_i ∘ P_i + G`,
//!
//! where `P ↦ Ẍ ∘ P` is the wrench of [`SecondDerivative::wrench`] and `G` what the joints
//! further out sent. In the axes before the joint's turn nothing of a last link needs to be
//! turned but its inertia, which the mass matrix does anyway; `A_i` has three entries, and does
//! nothing along `s_i` itself.
//!
//! A link whose inertia is so added to its carrier's is *lumped* with it. Any choice of links
//! gives the same forces, and none is Newton's and Euler's recursion: what is cheapest is tried
//! out ([`Mechanism::with_frames`]).

use super::inertia::PseudoInertia;
use super::mechanism::{Axis, Freedom, Link, Mechanism};
use super::newton_euler::{State, Wrench};
use super::second::SecondDerivative;
use super::vector;
use crate::graph::{ExprId, Graph};

/// How many links of each limb, counted from its end, are lumped with what carries them; those
/// of several axes never are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Lumped(pub usize);

impl Lumped {
    pub const NOTHING: Self = Self(0);
    /// What is tried out.
    pub const CHOICES: [Self; 5] = [Self(0), Self(1), Self(2), Self(3), Self(usize::MAX)];
}

impl Link {
    /// What the joint must apply, and what its carrier feels beside the lumped inertia, in the
    /// carrier's frame. `outer` is what comes from further out, in the link's own frame.
    fn lumped(
        &self,
        g: &mut Graph,
        before: &State,
        inertia: &PseudoInertia,
        outer: &Wrench,
        rate_change: ExprId,
    ) -> (ExprId, Wrench) {
        let (constant, joint) = self.stages.split_at(self.constant_stages);
        // In the axes before the joint turns, at the link's origin.
        let carrier = before.seen_from(g, self.shift, constant);
        let inertia = inertia.turn(g, joint);
        let nowhere = vector::zero(g);
        let outer = outer.seen_before(g, joint, nowhere);
        let own = own_wrench(g, &self.freedoms[0], &carrier, &inertia, rate_change);
        let sent = own.add(g, &outer);
        let rigid = (carrier.second).wrench(g, &inertia, carrier.acceleration);
        let force = rigid.add(g, &sent).along(g, self.freedoms[0].axis);
        (force, sent.seen_before(g, constant, self.shift))
    }
}

impl Mechanism {
    /// What each joint must apply, per freedom, for links in these states; `accelerations` are
    /// those of the freedoms.
    pub(super) fn lumped_forces(
        &self,
        g: &mut Graph,
        states: &[State],
        accelerations: &[Vec<ExprId>],
        lumped: Lumped,
    ) -> Vec<Vec<ExprId>> {
        let lumped = self.are_lumped(lumped);
        let inertias = self.lumped_inertias(g, &lumped);
        let mut wrenches: Vec<Wrench> = (0..self.links.len())
            .map(|i| match lumped[i] {
                true => Wrench::zero(g),
                false => {
                    let state = &states[i];
                    state.second.wrench(g, &inertias[i], state.acceleration)
                }
            })
            .collect();
        let mut forces = vec![Vec::new(); self.links.len()];
        for i in (0..self.links.len()).rev() {
            let (link, outer) = (&self.links[i], wrenches[i]);
            let sent = if lumped[i] {
                let before = self.before(g, i, states, true);
                let rate_change = accelerations[i][0];
                let (force, sent) = link.lumped(g, &before, &inertias[i], &outer, rate_change);
                forces[i] = vec![force];
                sent
            } else {
                let axes = link.freedoms.iter().map(|freedom| freedom.axis);
                forces[i] = axes.map(|axis| outer.along(g, axis)).collect();
                self.to_parent(g, i, &outer)
            };
            if let Some(parent) = link.parent {
                wrenches[parent] = wrenches[parent].add(g, &sent);
            }
        }
        forces
    }

    /// Per link, whether it is lumped with what carries it.
    fn are_lumped(&self, Lumped(most): Lumped) -> Vec<bool> {
        let mut heights = vec![0; self.links.len()];
        for (i, link) in self.links.iter().enumerate().rev() {
            if let Some(parent) = link.parent {
                heights[parent] = heights[parent].max(heights[i] + 1);
            }
        }
        let links = self.links.iter().zip(heights);
        links
            .map(|(link, height)| height < most && link.freedoms.len() == 1)
            .collect()
    }

    /// Each link's own inertia with those of the links that are lumped with it.
    fn lumped_inertias(&self, g: &mut Graph, lumped: &[bool]) -> Vec<PseudoInertia> {
        let mut inertias: Vec<PseudoInertia> = self.links.iter().map(|link| link.inertia).collect();
        for i in (0..self.links.len()).rev() {
            if let Some(parent) = self.links[i].parent.filter(|_| lumped[i]) {
                let turned = inertias[i].turn(g, &self.links[i].stages);
                let moved = turned.shift(g, self.links[i].shift);
                inertias[parent] = inertias[parent].add(g, &moved);
            }
        }
        inertias
    }
}

/// `A ∘ P`: the wrench that the joint's own rate and its change take.
fn own_wrench(
    g: &mut Graph,
    freedom: &Freedom,
    carrier: &State,
    inertia: &PseudoInertia,
    rate_change: ExprId,
) -> Wrench {
    match freedom.axis {
        Axis::Angular(_) => {
            let own = SecondDerivative::of_joint(g, carrier.omega, freedom.rate, rate_change);
            let still = vector::zero(g);
            own.wrench(g, inertia, still)
        }
        Axis::Linear(axis) => {
            let axis = vector::constant(g, axis);
            let doubled = g.scale(2.0, freedom.rate);
            let sliding = vector::scale(g, doubled, axis);
            let coriolis = vector::cross(g, carrier.omega, sliding);
            let along = vector::scale(g, rate_change, axis);
            let acceleration = vector::add(g, coriolis, along);
            SecondDerivative::zero(g).wrench(g, inertia, acceleration)
        }
    }
}
