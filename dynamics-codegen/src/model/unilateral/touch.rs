//! Where a shape touches a plane, how it moves there, and what forces there do.
//!
//! With the plane's normal `n` and a point `o` on it, a shape about the point `x` whose axis is `e`
//! has its nearest point to the plane at `x + ρ`:
//!
//! ```text
//! point    ρ = 0
//! sphere   ρ = −r n
//! disc     ρ = −r (n − (n·e) e)/max(s, ε),   s = √(1 − (n·e)²)
//! ```
//!
//! The lowest point of a disc that lies flat is nowhere, and nearly flat it leaps across the disc. Within `ε` of flat a
//! disc is domed instead: its lowest point wanders from the rim to the centre, where it reaches `r (s² + ε²)/(2ε)` down in place
//! of `r s`, `r ε/2` too far at most. Gap and velocity are continuous, and accelerations bounded by `r ω²/ε`.
//!
//! The gap is `n·(x − o)` less that reach, and the contact velocity that of the body there against that of the
//! plane there, along the plane's axes. Its normal component is the rate of the gap: the nearest
//! point wanders along the shape, tangentially.

use super::{Contact, Plane, Shape};
use crate::graph::{Binary, ExprId, Graph, Unary};
use crate::model::{Model, PointForce, Reading};

/// `ε`: a disc that is nearer to flat than this, rad, is domed.
const FLAT: f64 = 1e-2;

impl Model {
    /// The position of a frame's origin, along the world's axes.
    fn origin(&mut self, frame: usize) -> [ExprId; 3] {
        match frame {
            0 => [self.graph.zero(); 3],
            _ => [0, 1, 2].map(|k| self.reading(frame, Reading::Position(k))),
        }
    }

    /// The direction of a frame's axis, along the world's axes.
    fn direction(&mut self, frame: usize, axis: usize) -> [ExprId; 3] {
        match frame {
            0 => [0, 1, 2].map(|k| self.graph.constant(if k == axis { 1.0 } else { 0.0 })),
            _ => [0, 1, 2].map(|k| self.reading(frame, Reading::Axis(axis, k))),
        }
    }

    /// `v + ω × ρ`: the velocity of what is at `arm` from a frame's origin and moves with it.
    fn velocity_at(&mut self, frame: usize, arm: [ExprId; 3]) -> [ExprId; 3] {
        if frame == 0 {
            return [self.graph.zero(); 3];
        }
        let own = [0, 1, 2].map(|k| self.reading(frame, Reading::Velocity(k)));
        if arm.iter().all(|&part| self.graph.is_zero(part)) {
            return own;
        }
        let turn = [0, 1, 2].map(|k| self.reading(frame, Reading::AngularVelocity(k)));
        let turned = cross(&mut self.graph, turn, arm);
        [0, 1, 2].map(|k| self.graph.add(own[k], turned[k]))
    }

    /// `ρ`: from the origin of the shape's frame to its point nearest to a plane.
    fn arm(&mut self, shape: Shape, normal: [ExprId; 3]) -> [ExprId; 3] {
        match shape {
            Shape::Point { .. } => [self.graph.zero(); 3],
            Shape::Sphere { radius, .. } => {
                let graph = &mut self.graph;
                let back = graph.neg(radius);
                normal.map(|part| graph.mul(back, part))
            }
            Shape::Disc {
                frame,
                axis,
                radius,
            } => {
                let (in_disc, _, length) = self.down_the_disc(frame, axis, normal);
                let graph = &mut self.graph;
                let reach = graph.div(radius, length);
                let back = graph.neg(reach);
                in_disc.map(|part| graph.mul(back, part))
            }
        }
    }

    /// `n − (n·e) e`, the square of its length `s`, and `max(s, ε)`.
    fn down_the_disc(
        &mut self,
        frame: usize,
        axis: usize,
        normal: [ExprId; 3],
    ) -> ([ExprId; 3], ExprId, ExprId) {
        let axle = self.direction(frame, axis);
        let graph = &mut self.graph;
        let tilt = graph.inner_product(&normal, &axle);
        let in_disc = [0, 1, 2].map(|k| {
            let along = graph.mul(tilt, axle[k]);
            graph.sub(normal[k], along)
        });
        let square = graph.inner_product(&in_disc, &in_disc);
        let flat = graph.constant(FLAT * FLAT);
        let bounded = graph.binary(Binary::Max, square, flat);
        (in_disc, square, graph.unary(Unary::Sqrt, bounded))
    }

    /// How far a shape reaches below the origin of its frame.
    fn reach(&mut self, shape: Shape, normal: [ExprId; 3]) -> ExprId {
        match shape {
            Shape::Point { .. } => self.graph.zero(),
            Shape::Sphere { radius, .. } => radius,
            Shape::Disc {
                frame,
                axis,
                radius,
            } => {
                let (_, square, length) = self.down_the_disc(frame, axis, normal);
                let graph = &mut self.graph;
                let share = graph.div(square, length);
                let sum = graph.add(length, share);
                let half = graph.constant(0.5);
                let reach = graph.mul(half, radius);
                graph.mul(reach, sum)
            }
        }
    }

    /// Where a shape touches a plane, and how it moves there.
    pub(super) fn touch(
        &mut self,
        shape: Shape,
        plane: Plane,
    ) -> ([ExprId; 3], ExprId, [ExprId; 3]) {
        let normal = self.direction(plane.frame, plane.normal);
        let center = self.origin(shape.frame());
        let origin = self.origin(plane.frame);
        let arm = self.arm(shape, normal);
        let reach = self.reach(shape, normal);
        let graph = &mut self.graph;
        let apart = [0, 1, 2].map(|k| graph.sub(center[k], origin[k]));
        let height = graph.inner_product(&normal, &apart);
        let gap = graph.sub(height, reach);
        let arm_of_plane = [0, 1, 2].map(|k| graph.add(apart[k], arm[k]));
        let own = self.velocity_at(shape.frame(), arm);
        let theirs = self.velocity_at(plane.frame, arm_of_plane);
        let graph = &mut self.graph;
        let against = [0, 1, 2].map(|k| graph.sub(own[k], theirs[k]));
        let velocity = plane.axes().map(|axis| {
            let along = self.direction(plane.frame, axis);
            self.graph.inner_product(&along, &against)
        });
        (arm, gap, velocity)
    }
}

impl Model {
    /// A force along the plane of a contact, on the shape where it touches, and back on the plane.
    pub(in crate::model) fn rub(&mut self, contact: usize, along: [ExprId; 2]) {
        let Contact {
            shape, plane, arm, ..
        } = self.contacts[contact];
        let axes = plane.axes();
        let [first, second] = [axes[0], axes[1]].map(|axis| self.direction(plane.frame, axis));
        let graph = &mut self.graph;
        let force = [0, 1, 2].map(|k| graph.inner_product(&along, &[first[k], second[k]]));
        let back = force.map(|part| graph.neg(part));
        self.push_at(shape.frame(), arm, force);
        let (center, origin) = (self.origin(shape.frame()), self.origin(plane.frame));
        let graph = &mut self.graph;
        let arm = [0, 1, 2].map(|k| {
            let apart = graph.sub(center[k], origin[k]);
            graph.add(apart, arm[k])
        });
        self.push_at(plane.frame, arm, back);
    }

    /// A force at `arm` from a frame's origin, as force and torque there.
    fn push_at(&mut self, frame: usize, arm: [ExprId; 3], force: [ExprId; 3]) {
        if frame == 0 {
            return;
        }
        let torque = cross(&mut self.graph, arm, force);
        let parts = [(force, false), (torque, true)];
        let parts = parts.map(|(value, torque)| PointForce {
            frame,
            value,
            torque,
        });
        self.point_forces.extend(parts);
    }
}

fn cross(graph: &mut Graph, a: [ExprId; 3], b: [ExprId; 3]) -> [ExprId; 3] {
    [0, 1, 2].map(|k| {
        let (i, j) = ((k + 1) % 3, (k + 2) % 3);
        let (plus, minus) = (graph.mul(a[i], b[j]), graph.mul(a[j], b[i]));
        graph.sub(plus, minus)
    })
}
