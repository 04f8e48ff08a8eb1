//! What a joint sends towards the root so that derivatives can be read there
//! (equations: [`sensitivity`](super::sensitivity)).

use super::composite::momentum_along;
use super::inertia::PseudoInertia;
use super::mechanism::{Axis, Mechanism};
use super::newton_euler::{State, Wrench};
use super::turn::{self, Matrix};
use super::vector::{self, Vector};
use crate::graph::{ExprId, Graph};

/// A twist: angular velocity, and velocity of the origin.
#[derive(Debug, Clone, Copy)]
pub(super) struct Twist {
    pub angular: Vector,
    pub linear: Vector,
}

/// A joint's twist and its rates, in its link's frame.
#[derive(Debug, Clone, Copy)]
pub(super) struct AxisMotion {
    /// `E`
    pub twist: Twist,
    /// `2 Ė`
    pub doubled_rate: Twist,
    /// The angular part of `Ė`.
    pub angular_rate: Vector,
    /// `Ë`
    pub second: Twist,
}

/// `2 D = 2 Σ Ẋ P Xᵀ`: its upper left block and its last column.
#[derive(Debug, Clone, Copy)]
pub(super) struct MixedMoment {
    pub block: Matrix,
    pub column: Vector,
}

/// A force of joint `i` as a function of what moves below it.
#[derive(Debug, Clone, Copy)]
pub(super) struct Functional {
    /// `P s_i`
    momentum: Wrench,
    /// `s_i · 2 D` as a function of an angular part.
    mixed: Vector,
}

/// How the wrench of joint `i` changes with a coordinate of that joint.
#[derive(Debug, Clone, Copy)]
pub(super) struct Change {
    /// `∂F/∂q_i`
    pub by_position: Wrench,
    /// `∂F/∂v_i`
    pub by_velocity: Wrench,
}

impl AxisMotion {
    /// Of a translation along `a`, which turns with the link: `Ė = (0; ω × a)`.
    pub fn linear(g: &mut Graph, a: [f64; 3], state: &State) -> Self {
        let zero = vector::zero(g);
        let a = vector::constant(g, a);
        let rate = vector::cross(g, state.omega, a);
        let along = |linear| Twist {
            angular: zero,
            linear,
        };
        Self {
            twist: along(a),
            doubled_rate: along(rate.map(|x| g.scale(2.0, x))),
            angular_rate: zero,
            second: along(state.second.times(g, a)),
        }
    }

    /// Of a rotation `ε` about the origin, with `ε̇` and `ε̈` as seen from the
    /// link. In the world, `d = ε̇ + ω × ε` and `ε̈ + 2 ω × ε̇ + U ε` are its
    /// rates, and with the origin's velocity `v` and acceleration `a`
    /// `Ė = (d; v × ε)`, `Ë = (…; a × ε + 2 v × d)`.
    pub fn angular(g: &mut Graph, [axis, rate, second]: [Vector; 3], state: &State) -> Self {
        let spin = vector::cross(g, state.omega, axis);
        let angular_rate = vector::add(g, spin, rate);
        let doubled_rate = angular_rate.map(|x| g.scale(2.0, x));
        let turned = state.second.times(g, axis);
        let coriolis = vector::cross(g, state.omega, rate);
        let coriolis = coriolis.map(|x| g.scale(2.0, x));
        let relative = vector::add(g, second, coriolis);
        let sweep = vector::cross(g, state.velocity, axis);
        let turning = vector::cross(g, state.velocity, doubled_rate);
        let pushed = vector::cross(g, state.acceleration, axis);
        Self {
            twist: Twist {
                angular: axis,
                linear: vector::zero(g),
            },
            doubled_rate: Twist {
                angular: doubled_rate,
                linear: sweep.map(|x| g.scale(2.0, x)),
            },
            angular_rate,
            second: Twist {
                angular: vector::add(g, turned, relative),
                linear: vector::add(g, pushed, turning),
            },
        }
    }
}

impl AxisMotion {
    /// This motion, but for the mean of both rates where velocities differ.
    pub fn at_rate_between(self, g: &mut Graph, other: &Self) -> Self {
        let mut mean = |x: Vector, y: Vector| {
            let sum = vector::add(g, x, y);
            sum.map(|x| g.scale(0.5, x))
        };
        let (own, others) = (self.doubled_rate, other.doubled_rate);
        let doubled_rate = Twist {
            angular: mean(own.angular, others.angular),
            linear: mean(own.linear, others.linear),
        };
        Self {
            doubled_rate,
            ..self
        }
    }
}

impl MixedMoment {
    /// `2 V P`: block `2 (ω × S + v hᵀ)`, column `2 (ω × h + m v)`.
    pub fn of_link(g: &mut Graph, inertia: &PseudoInertia, state: &State) -> Self {
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

    pub fn add(&self, g: &mut Graph, other: &Self) -> Self {
        Self {
            block: std::array::from_fn(|i| vector::add(g, self.block[i], other.block[i])),
            column: vector::add(g, self.column, other.column),
        }
    }

    /// Seen from a frame in which the old origin lies at `p`.
    pub fn shift(&self, g: &mut Graph, p: Vector) -> Self {
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
    pub fn wrench(&self, g: &mut Graph, x: Vector) -> Wrench {
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
    pub fn covector(&self, g: &mut Graph, i: usize) -> Vector {
        let (j, k) = ((i + 1) % 3, (i + 2) % 3);
        let mut row = self.block[i].map(|x| g.neg(x));
        row[i] = g.add(self.block[j][j], self.block[k][k]);
        row
    }
}

impl Functional {
    pub fn new(g: &mut Graph, axis: Axis, inertia: &PseudoInertia, mixed: &MixedMoment) -> Self {
        Self {
            momentum: momentum_along(g, inertia, axis),
            mixed: match axis {
                Axis::Angular(k) => mixed.covector(g, k),
                Axis::Linear(a) => {
                    let a = vector::constant(g, a);
                    vector::cross(g, mixed.column, a)
                }
            },
        }
    }

    pub fn to_parent(self, g: &mut Graph, mechanism: &Mechanism, link: usize) -> Self {
        Self {
            momentum: mechanism.to_parent(g, link, &self.momentum),
            mixed: turn::up(g, &mechanism.links[link].stages, self.mixed),
        }
    }

    pub fn by_position(&self, g: &mut Graph, motion: &AxisMotion) -> ExprId {
        let second = power(g, &self.momentum, &motion.second);
        let rate = vector::dot(g, self.mixed, motion.angular_rate);
        g.add(second, rate)
    }

    pub fn by_velocity(&self, g: &mut Graph, motion: &AxisMotion) -> ExprId {
        let rate = power(g, &self.momentum, &motion.doubled_rate);
        let own = vector::dot(g, self.mixed, motion.twist.angular);
        g.add(rate, own)
    }
}

impl Change {
    pub fn new(
        g: &mut Graph,
        motion: &AxisMotion,
        inertia: &PseudoInertia,
        mixed: &MixedMoment,
        wrench: &Wrench,
    ) -> Self {
        let by_second = momentum(g, inertia, &motion.second);
        let by_rate = mixed.wrench(g, motion.angular_rate);
        let carried = carried(g, &motion.twist, wrench);
        let by_position = by_second.add(g, &by_rate);
        let rate = momentum(g, inertia, &motion.doubled_rate);
        let own = mixed.wrench(g, motion.twist.angular);
        Self {
            by_position: by_position.add(g, &carried),
            by_velocity: rate.add(g, &own),
        }
    }

    pub fn to_parent(self, g: &mut Graph, mechanism: &Mechanism, link: usize) -> Self {
        Self {
            by_position: mechanism.to_parent(g, link, &self.by_position),
            by_velocity: mechanism.to_parent(g, link, &self.by_velocity),
        }
    }
}

/// `E F`: how a wrench that moves along with a joint changes with it.
fn carried(g: &mut Graph, twist: &Twist, wrench: &Wrench) -> Wrench {
    let turned = vector::cross(g, twist.angular, wrench.moment);
    let lever = vector::cross(g, twist.linear, wrench.force);
    Wrench {
        moment: vector::add(g, turned, lever),
        force: vector::cross(g, twist.angular, wrench.force),
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
        let (first, second) = (
            g.mul(inertia.second[i][j], x[j]),
            g.mul(inertia.second[i][k], x[k]),
        );
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
