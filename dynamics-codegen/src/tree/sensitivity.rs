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

use super::composite::momentum_along;
use super::floating;
use super::inertia::PseudoInertia;
use super::mechanism::{Axis, Mechanism};
use super::newton_euler::{State, Wrench};
use super::space::Space;
use super::turn::{self, Matrix};
use super::vector::{self, Vector};
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

/// A twist: angular velocity, and velocity of the origin.
#[derive(Debug, Clone, Copy)]
struct Twist {
    angular: Vector,
    linear: Vector,
}

/// A joint's twist and its rates, in its link's frame.
#[derive(Debug, Clone, Copy)]
struct AxisMotion {
    /// `E`
    twist: Twist,
    /// `2 Ė`
    doubled_rate: Twist,
    /// The angular part of `Ė`.
    angular_rate: Vector,
    /// `Ë`
    second: Twist,
}

/// `2 D = 2 Σ Ẋ P Xᵀ`: its upper left block and its last column.
#[derive(Debug, Clone, Copy)]
struct MixedMoment {
    block: Matrix,
    column: Vector,
}

/// What joint `i` sends towards the root.
struct Messages {
    /// `P s_i`
    momentum: Wrench,
    /// `s_i · 2 D` as a function of an angular part.
    mixed: Vector,
    /// `∂F/∂q_i`
    by_position: Wrench,
    /// `∂F/∂v_i`
    by_velocity: Wrench,
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
            let mut messages =
                Messages::new(g, axis, &motions[i], &composites[i], &mixed[i], &wrenches[i]);
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

/// `Ė = V × E` and `Ë = A × E + V × Ė` with the parent's velocity and
/// acceleration, seen at the joint. The link's own differ from the parent's by
/// multiples of `E`, which drop out for a revolute joint; a prismatic joint's
/// axis changes by rotation alone.
fn axis_motion(g: &mut Graph, axis: Axis, state: &State) -> AxisMotion {
    let zero = vector::zero(g);
    match axis {
        Axis::Linear(a) => {
            let a = vector::constant(g, a);
            let rate = vector::cross(g, state.omega, a);
            AxisMotion {
                twist: Twist {
                    angular: zero,
                    linear: a,
                },
                doubled_rate: Twist {
                    angular: zero,
                    linear: rate.map(|x| g.scale(2.0, x)),
                },
                angular_rate: zero,
                second: Twist {
                    angular: zero,
                    linear: state.second.times(g, a),
                },
            }
        }
        Axis::Angular(k) => {
            let z = vector::constant(g, super::vector::IDENTITY[k]);
            let angular_rate = vector::cross(g, state.omega, z);
            let linear_rate = vector::cross(g, state.velocity, z);
            // Ë's linear part: a × z + 2 v × (ω × z).
            let doubled_angular = angular_rate.map(|x| g.scale(2.0, x));
            let turning = vector::cross(g, state.velocity, doubled_angular);
            let pushed = vector::cross(g, state.acceleration, z);
            AxisMotion {
                twist: Twist {
                    angular: z,
                    linear: zero,
                },
                doubled_rate: Twist {
                    angular: doubled_angular,
                    linear: linear_rate.map(|x| g.scale(2.0, x)),
                },
                angular_rate,
                second: Twist {
                    angular: state.second.times(g, z),
                    linear: vector::add(g, pushed, turning),
                },
            }
        }
    }
}

impl MixedMoment {
    /// `2 V P`: block `2 (ω × S + v hᵀ)`, column `2 (ω × h + m v)`.
    fn of_link(g: &mut Graph, inertia: &PseudoInertia, state: &State) -> Self {
        let (w, v) = (state.omega, state.velocity);
        // The factor goes into the constants.
        let s = inertia.second.map(|row| row.map(|x| g.scale(2.0, x)));
        let h = inertia.first.map(|x| g.scale(2.0, x));
        let mass = g.scale(2.0, inertia.mass);
        let columns: Matrix = std::array::from_fn(|j| {
            let spin = vector::cross(g, w, [s[0][j], s[1][j], s[2][j]]);
            let slide = vector::scale(g, h[j], v);
            vector::add(g, spin, slide)
        });
        let spin = vector::cross(g, w, h);
        let slide = vector::scale(g, mass, v);
        Self {
            block: turn::transpose(&columns),
            column: vector::add(g, spin, slide),
        }
    }

    fn add(&self, g: &mut Graph, other: &Self) -> Self {
        Self {
            block: std::array::from_fn(|i| vector::add(g, self.block[i], other.block[i])),
            column: vector::add(g, self.column, other.column),
        }
    }

    /// Seen from a frame in which the old origin lies at `p`.
    fn shift(&self, g: &mut Graph, p: Vector) -> Self {
        let block = std::array::from_fn(|i| {
            let change = vector::scale(g, self.column[i], p);
            vector::add(g, self.block[i], change)
        });
        Self {
            block,
            column: self.column,
        }
    }

    /// The wrench `[x]ₓ · 2D`: moment `(tr(2D) 1 − 2D) x`, force `x × 2d`.
    fn wrench(&self, g: &mut Graph, x: Vector) -> Wrench {
        let moment = std::array::from_fn(|i| {
            let row = self.covector(g, i);
            vector::dot(g, row, x)
        });
        Wrench {
            moment,
            force: vector::cross(g, x, self.column),
        }
    }

    /// Row `i` of `tr(2D) 1 − 2D`.
    fn covector(&self, g: &mut Graph, i: usize) -> Vector {
        let (j, k) = ((i + 1) % 3, (i + 2) % 3);
        let mut row = self.block[i].map(|x| g.neg(x));
        row[i] = g.add(self.block[j][j], self.block[k][k]);
        row
    }
}

impl Messages {
    fn new(
        g: &mut Graph,
        axis: Axis,
        motion: &AxisMotion,
        inertia: &PseudoInertia,
        mixed: &MixedMoment,
        wrench: &Wrench,
    ) -> Self {
        let by_second = momentum(g, inertia, &motion.second);
        let by_rate = mixed.wrench(g, motion.angular_rate);
        let carried = carried(g, axis, wrench);
        let by_position = by_second.add(g, &by_rate);
        let by_position = by_position.add(g, &carried);
        let rate = momentum(g, inertia, &motion.doubled_rate);
        let own = mixed.wrench(g, motion.twist.angular);
        Self {
            momentum: momentum_along(g, inertia, axis),
            mixed: match axis {
                Axis::Angular(k) => mixed.covector(g, k),
                Axis::Linear(_) => vector::cross(g, mixed.column, motion.twist.linear),
            },
            by_position,
            by_velocity: rate.add(g, &own),
        }
    }

    fn to_parent(&self, g: &mut Graph, mechanism: &Mechanism, link: usize) -> Self {
        Self {
            momentum: mechanism.to_parent(g, link, &self.momentum),
            mixed: turn::up(g, &mechanism.links[link].stages, self.mixed),
            by_position: mechanism.to_parent(g, link, &self.by_position),
            by_velocity: mechanism.to_parent(g, link, &self.by_velocity),
        }
    }

    fn row_by_position(&self, g: &mut Graph, motion: &AxisMotion) -> ExprId {
        let second = power(g, &self.momentum, &motion.second);
        let rate = vector::dot(g, self.mixed, motion.angular_rate);
        g.add(second, rate)
    }

    fn row_by_velocity(&self, g: &mut Graph, motion: &AxisMotion) -> ExprId {
        let rate = power(g, &self.momentum, &motion.doubled_rate);
        let own = vector::dot(g, self.mixed, motion.twist.angular);
        g.add(rate, own)
    }
}

/// `E F`: how a wrench that moves along with a joint changes with it.
fn carried(g: &mut Graph, axis: Axis, wrench: &Wrench) -> Wrench {
    match axis {
        Axis::Angular(k) => {
            let z = vector::constant(g, super::vector::IDENTITY[k]);
            Wrench {
                moment: vector::cross(g, z, wrench.moment),
                force: vector::cross(g, z, wrench.force),
            }
        }
        Axis::Linear(a) => {
            let a = vector::constant(g, a);
            Wrench {
                moment: vector::cross(g, a, wrench.force),
                force: vector::zero(g),
            }
        }
    }
}

/// `P X`: moment `J x + h × y`, force `x × h + m y`.
fn momentum(g: &mut Graph, inertia: &PseudoInertia, twist: &Twist) -> Wrench {
    let (x, y) = (twist.angular, twist.linear);
    let lever = vector::cross(g, inertia.first, y);
    let spin: Vector = std::array::from_fn(|i| {
        let (j, k) = ((i + 1) % 3, (i + 2) % 3);
        let moment = inertia.moment(g, i);
        let own = g.mul(moment, x[i]);
        let (first, second) = (g.mul(inertia.second[i][j], x[j]), g.mul(inertia.second[i][k], x[k]));
        let less = g.sub(own, first);
        g.sub(less, second)
    });
    let turning = vector::cross(g, x, inertia.first);
    let sliding = vector::scale(g, inertia.mass, y);
    Wrench {
        moment: vector::add(g, spin, lever),
        force: vector::add(g, turning, sliding),
    }
}

/// `n · x + f · y`
fn power(g: &mut Graph, wrench: &Wrench, twist: &Twist) -> ExprId {
    let angular = vector::dot(g, wrench.moment, twist.angular);
    let linear = vector::dot(g, wrench.force, twist.linear);
    g.add(angular, linear)
}
