//! Recursive Newton–Euler in link frames.

use super::lumped::Lumped;
use super::mechanism::{Axis, Mechanism};
use super::second::SecondDerivative;
use super::space::Space;
use super::turn::{self, Stage};
use super::vector::{self, Vector};
use crate::graph::{ExprId, Graph};

/// How a link moves, in its own frame.
#[derive(Debug, Clone, Copy)]
pub(super) struct State {
    /// Angular velocity `ω`.
    pub omega: Vector,
    /// Velocity of the origin.
    pub velocity: Vector,
    /// Acceleration of the origin.
    pub acceleration: Vector,
    /// `U = [ω̇]ₓ + [ω]ₓ[ω]ₓ`: a point at `r` accelerates by `U r` against the origin.
    pub second: SecondDerivative,
    pub omega_dot: Vector,
}

/// Force, and moment about the origin, in a link's frame.
#[derive(Debug, Clone, Copy)]
pub(super) struct Wrench {
    pub moment: Vector,
    pub force: Vector,
}

impl Wrench {
    pub fn zero(g: &mut Graph) -> Self {
        let zero = vector::zero(g);
        Self {
            moment: zero,
            force: zero,
        }
    }

    pub fn add(&self, g: &mut Graph, other: &Self) -> Self {
        Self {
            moment: vector::add(g, self.moment, other.moment),
            force: vector::add(g, self.force, other.force),
        }
    }

    /// Seen from a frame in which the old origin lies at `shift`, in the axes before `stages`.
    pub fn seen_before(&self, g: &mut Graph, stages: &[Stage], shift: Vector) -> Self {
        let force = turn::up(g, stages, self.force);
        let moment = turn::up(g, stages, self.moment);
        let lever = vector::cross(g, shift, force);
        Self {
            moment: vector::add(g, moment, lever),
            force,
        }
    }

    /// What the wrench does along a freedom's axis.
    pub fn along(&self, g: &mut Graph, axis: Axis) -> ExprId {
        match axis {
            Axis::Angular(k) => self.moment[k],
            Axis::Linear(a) => {
                let a = vector::constant(g, a);
                vector::dot(g, a, self.force)
            }
        }
    }
}

impl Mechanism {
    /// `Q_C = −(C v + g)`: minus the inverse dynamics at zero acceleration (recursive
    /// Newton–Euler, Featherstone 2008, table 5.1), one entry per coordinate.
    pub fn bias_force(&self, g: &mut Graph) -> Vec<ExprId> {
        let cheapest = self.upright.alone.as_deref().unwrap_or(self);
        cheapest.bias_force_by(g, cheapest.lumped.alone)
    }

    /// The same as [`bias_force`](Self::bias_force) by the operations that are fewest where
    /// the mass matrix is computed as well.
    pub fn bias_force_beside_mass(&self, g: &mut Graph) -> Vec<ExprId> {
        let cheapest = self.upright.beside_mass.as_deref().unwrap_or(self);
        cheapest.bias_force_by(g, cheapest.lumped.beside_mass)
    }

    pub(super) fn bias_force_by(&self, g: &mut Graph, lumped: Lumped) -> Vec<ExprId> {
        let rest = vec![g.zero(); self.coordinates];
        let space = Space::coordinates(self);
        let needed = self.inverse_dynamics_over(g, &space, &rest, lumped);
        needed.into_iter().map(|force| g.neg(force)).collect()
    }

    /// `M a − Q_C`: the generalised force that makes the tree accelerate by `a`.
    ///
    /// # Panics
    /// If `acceleration` does not have one entry per coordinate.
    pub fn inverse_dynamics(&self, g: &mut Graph, acceleration: &[ExprId]) -> Vec<ExprId> {
        assert_eq!(
            acceleration.len(),
            self.coordinates,
            "one acceleration per coordinate"
        );
        let space = Space::coordinates(self);
        self.inverse_dynamics_over(g, &space, acceleration, Lumped::NOTHING)
    }

    /// Inverse dynamics over a choice of velocities.
    pub(super) fn inverse_dynamics_over(
        &self,
        g: &mut Graph,
        space: &Space,
        acceleration: &[ExprId],
        lumped: Lumped,
    ) -> Vec<ExprId> {
        let accelerations = self.freedom_accelerations(g, space, acceleration);
        let states = self.states_at(g, &accelerations, true);
        let forces = match lumped {
            Lumped::NOTHING => {
                let wrenches = self.wrenches(g, &states);
                self.joint_forces(g, &wrenches)
            }
            _ => self.lumped_forces(g, &states, &accelerations, lumped),
        };
        space.force(g, &forces)
    }

    /// How each freedom accelerates, its drift with it.
    fn freedom_accelerations(
        &self,
        g: &mut Graph,
        space: &Space,
        acceleration: &[ExprId],
    ) -> Vec<Vec<ExprId>> {
        let mut accelerations = space.rates(g, acceleration);
        for (own, link) in accelerations.iter_mut().zip(&self.links) {
            for (acceleration, freedom) in own.iter_mut().zip(&link.freedoms) {
                *acceleration = g.add(*acceleration, freedom.drift);
            }
        }
        accelerations
    }

    /// The motion of all links. With `gravity` the world accelerates upwards,
    /// which acts as gravity does, and velocities are those against an inertial
    /// frame that moves along with what slides before anything turns: forces
    /// and their derivatives are the same (Galilei), and cheaper.
    pub(super) fn states(
        &self,
        g: &mut Graph,
        acceleration: &[ExprId],
        gravity: bool,
    ) -> Vec<State> {
        let space = Space::coordinates(self);
        let accelerations = self.freedom_accelerations(g, &space, acceleration);
        self.states_at(g, &accelerations, gravity)
    }

    /// As [`states`](Self::states), with an acceleration per link and freedom.
    pub(super) fn states_at(
        &self,
        g: &mut Graph,
        accelerations: &[Vec<ExprId>],
        gravity: bool,
    ) -> Vec<State> {
        let mut states: Vec<State> = Vec::with_capacity(self.links.len());
        for i in 0..self.links.len() {
            let before = self.before(g, i, &states, gravity);
            states.push(self.step(g, i, &before, &accelerations[i], gravity));
        }
        states
    }

    fn base_state(&self, g: &mut Graph, link: usize, gravity: bool) -> State {
        let zero = vector::zero(g);
        let acceleration = if gravity {
            let up = vector::neg(g, self.gravity);
            let inward = vector::transpose(&self.links[link].base.rotation);
            vector::rotate(g, &inward, up)
        } else {
            zero
        };
        State {
            omega: zero,
            velocity: zero,
            acceleration,
            second: SecondDerivative::new(g, zero, zero),
            omega_dot: zero,
        }
    }

    /// From a link to its child: shift, turn, add the joint's own motion.
    fn step(
        &self,
        g: &mut Graph,
        i: usize,
        before: &State,
        accelerations: &[ExprId],
        relative: bool,
    ) -> State {
        let link = &self.links[i];
        if link.free {
            return self.step_freely(g, i, before, accelerations);
        }
        let (mut velocity, mut acceleration) = shifted(g, before, link.shift);
        for (freedom, &rate_change) in link.freedoms.iter().zip(accelerations) {
            if let Axis::Linear(axis) = freedom.axis {
                // The axis is fixed in the parent: a v, and 2 ω × a v + a v̇.
                let axis = vector::constant(g, axis);
                let sliding = vector::scale(g, freedom.rate, axis);
                // A frame that does not turn may as well move along.
                let rides = relative && before.omega.iter().all(|&x| g.is_zero(x));
                if !rides {
                    velocity = vector::add(g, velocity, sliding);
                }
                let doubled = sliding.map(|x| g.scale(2.0, x));
                let coriolis = vector::cross(g, before.omega, doubled);
                acceleration = vector::add(g, acceleration, coriolis);
                let own = vector::scale(g, rate_change, axis);
                acceleration = vector::add(g, acceleration, own);
            }
        }
        let carried = turn::down(g, &link.stages, before.omega);
        let mut omega = carried;
        let mut omega_dot = turn::down(g, &link.stages, before.omega_dot);
        for (freedom, &rate_change) in link.freedoms.iter().zip(accelerations) {
            if let Axis::Angular(k) = freedom.axis {
                omega[k] = g.add(omega[k], freedom.rate);
                // ω_parent × (axis · v), then the joint's own acceleration.
                let (i, j) = ((k + 1) % 3, (k + 2) % 3);
                let (along_i, along_j) = (
                    g.mul(carried[j], freedom.rate),
                    g.mul(carried[i], freedom.rate),
                );
                omega_dot[i] = g.add(omega_dot[i], along_i);
                omega_dot[j] = g.sub(omega_dot[j], along_j);
                omega_dot[k] = g.add(omega_dot[k], rate_change);
            }
        }
        State {
            omega,
            velocity: turn::down(g, &link.stages, velocity),
            acceleration: turn::down(g, &link.stages, acceleration),
            second: SecondDerivative::new(g, omega, omega_dot),
            omega_dot,
        }
    }

    /// From what carries a free link to that link; its twist `(v, ω)` is in its own frame,
    /// and its origin accelerates against the carrier by `v̇ + (2 ω_carrier + ω) × v`.
    fn step_freely(
        &self,
        g: &mut Graph,
        i: usize,
        before: &State,
        accelerations: &[ExprId],
    ) -> State {
        let carrier = self.carrier(g, i, before);
        let rates: Vec<ExprId> = self.links[i].freedoms.iter().map(|f| f.rate).collect();
        let (v, w) = halves(&rates);
        let (v_dot, w_dot) = halves(accelerations);
        let omega = vector::add(g, carrier.omega, w);
        let turning = vector::add(g, carrier.omega, omega);
        let coriolis = vector::cross(g, turning, v);
        let own = vector::add(g, v_dot, coriolis);
        let spin = vector::cross(g, carrier.omega, w);
        let own_turn = vector::add(g, w_dot, spin);
        let omega_dot = vector::add(g, carrier.omega_dot, own_turn);
        State {
            omega,
            velocity: vector::add(g, carrier.velocity, v),
            acceleration: vector::add(g, carrier.acceleration, own),
            second: SecondDerivative::new(g, omega, omega_dot),
            omega_dot,
        }
    }

    /// The motion of the frame that is fixed in what carries link `i` and coincides with that
    /// link's frame at this instant.
    pub(super) fn carrier(&self, g: &mut Graph, i: usize, before: &State) -> State {
        let link = &self.links[i];
        before.seen_from(g, link.shift, &link.stages)
    }

    /// The motion of what carries link `i`: its parent's, or the world's.
    pub(super) fn before(&self, g: &mut Graph, i: usize, states: &[State], gravity: bool) -> State {
        match self.links[i].parent {
            Some(parent) => states[parent],
            None => self.base_state(g, i, gravity),
        }
    }

    /// The wrench that each link's joint transmits, in that link's frame.
    pub(super) fn wrenches(&self, g: &mut Graph, states: &[State]) -> Vec<Wrench> {
        let mut wrenches: Vec<Wrench> = (self.links.iter().zip(states))
            .map(|(link, state)| state.second.wrench(g, &link.inertia, state.acceleration))
            .collect();
        for i in (0..self.links.len()).rev() {
            if let Some(parent) = self.links[i].parent {
                let carried = self.to_parent(g, i, &wrenches[i]);
                wrenches[parent] = wrenches[parent].add(g, &carried);
            }
        }
        wrenches
    }

    /// What each joint must apply, per freedom.
    pub(super) fn joint_forces(&self, g: &mut Graph, wrenches: &[Wrench]) -> Vec<Vec<ExprId>> {
        (self.links.iter().zip(wrenches))
            .map(|(link, wrench)| {
                let freedoms = link.freedoms.iter();
                freedoms
                    .map(|freedom| wrench.along(g, freedom.axis))
                    .collect()
            })
            .collect()
    }

    /// A wrench on link `i`, seen from its parent's frame.
    pub(super) fn to_parent(&self, g: &mut Graph, i: usize, wrench: &Wrench) -> Wrench {
        let link = &self.links[i];
        wrench.seen_before(g, &link.stages, link.shift)
    }
}

/// The linear and the angular half of six components of a twist.
fn halves(twist: &[ExprId]) -> (Vector, Vector) {
    (
        std::array::from_fn(|k| twist[k]),
        std::array::from_fn(|k| twist[3 + k]),
    )
}

impl State {
    /// The motion of a frame that is fixed in this one, `shift` from its origin and turned by
    /// `stages`.
    pub fn seen_from(&self, g: &mut Graph, shift: Vector, stages: &[Stage]) -> Self {
        let (velocity, acceleration) = shifted(g, self, shift);
        let omega = turn::down(g, stages, self.omega);
        let omega_dot = turn::down(g, stages, self.omega_dot);
        Self {
            omega,
            velocity: turn::down(g, stages, velocity),
            acceleration: turn::down(g, stages, acceleration),
            second: SecondDerivative::new(g, omega, omega_dot),
            omega_dot,
        }
    }
}

/// Velocity and acceleration of a place of a link that is `by` from its origin, in the link's frame.
fn shifted(g: &mut Graph, link: &State, by: Vector) -> (Vector, Vector) {
    let lever = vector::cross(g, link.omega, by);
    let velocity = vector::add(g, link.velocity, lever);
    let swing = link.second.times(g, by);
    (velocity, vector::add(g, link.acceleration, swing))
}
