//! Poses, Jacobians and their rates, in world axes.

use super::mechanism::{Axis, Mechanism};
use super::turn;
use super::vector::{self, IDENTITY, Rotation, Vector};
use crate::graph::{ExprId, Graph};

/// A frame fixed to a body: `x_body = rotation · x_frame + translation`.
#[derive(Debug, Clone, Copy)]
pub struct Frame {
    /// Index into [`Tree::bodies`](super::Tree::bodies).
    pub body: usize,
    /// Row by row.
    pub rotation: [[f64; 3]; 3],
    /// In metres, in the body's frame.
    pub translation: [ExprId; 3],
}

impl Frame {
    /// The frame of the body itself.
    pub fn of_body(g: &mut Graph, body: usize) -> Self {
        Self {
            body,
            rotation: IDENTITY,
            translation: vector::zero(g),
        }
    }
}

/// Where a frame is: `x_world = rotation · x_frame + position`.
#[derive(Debug, Clone, Copy)]
pub struct Pose {
    /// Row by row.
    pub rotation: [[ExprId; 3]; 3],
    /// In the world frame, m.
    pub position: [ExprId; 3],
}

/// A link's pose in the world; the rotation by columns.
#[derive(Debug, Clone, Copy)]
pub(super) struct Place {
    pub columns: [Vector; 3],
    pub origin: Vector,
    /// From the parent's origin to this one.
    step: Vector,
}

/// A link's motion in world axes.
#[derive(Debug, Clone, Copy)]
struct Flow {
    omega: Vector,
    /// Angular velocity of the parent: an axis fixed there turns by it alone.
    omega_parent: Vector,
    velocity: Vector,
}

/// A velocity (or a part of an acceleration): of a point, and of its body.
#[derive(Debug, Clone, Copy)]
struct Twist {
    linear: Vector,
    angular: Vector,
}

impl Mechanism {
    /// Forward kinematics of a frame.
    pub fn pose(&self, g: &mut Graph, frame: &Frame) -> Pose {
        let places = self.places(g);
        let (link, rotation, point) = self.attachment(g, frame);
        let columns = match link {
            Some(link) => rotate_columns(g, &places[link].columns, &rotation),
            None => vector::transpose(&rotation).map(|column| vector::constant(g, column)),
        };
        Pose {
            rotation: turn::transpose(&columns),
            position: self.position(g, &places, link, point),
        }
    }

    /// The Jacobian of a frame: rows 0–2 give the velocity of its origin, rows
    /// 3–5 its angular velocity, both in world axes; one column per coordinate.
    pub fn jacobian(&self, g: &mut Graph, frame: &Frame) -> Vec<Vec<ExprId>> {
        let columns = self.freedom_columns(g, frame, false);
        self.columns_to_matrix(g, &columns)
    }

    /// The time derivative of the [`jacobian`](Self::jacobian) along the motion.
    pub fn jacobian_rate(&self, g: &mut Graph, frame: &Frame) -> Vec<Vec<ExprId>> {
        let columns = self.freedom_columns(g, frame, true);
        let mut rate = self.columns_to_matrix(g, &columns);
        // Columns also change with the map of their freedom: a quaternion's is
        // ω = 2 E(η) η̇, whose rate is that map at η̇.
        let still = self.freedom_columns(g, frame, false);
        for (link, freedom, twist) in still {
            for (index, change) in self.map_rate(g, link, freedom) {
                self.add_column(g, &mut rate, twist, index, change);
            }
        }
        rate
    }

    /// The velocity of a frame's origin, then its angular velocity, in world
    /// axes: `J v` and what time alone drives.
    pub fn velocity(&self, g: &mut Graph, frame: &Frame) -> [ExprId; 6] {
        let zero = g.zero();
        let (Some(carrier), _, point) = self.attachment(g, frame) else {
            return [zero; 6];
        };
        let places = self.places(g);
        let flow = self.flows(g, &places)[carrier];
        let lever = turn::times(g, &turn::transpose(&places[carrier].columns), point);
        let spin = vector::cross(g, flow.omega, lever);
        let [x, y, z] = vector::add(g, flow.velocity, spin);
        let [wx, wy, wz] = flow.omega;
        [x, y, z, wx, wy, wz]
    }

    /// `J̇ v`: the acceleration of a frame's origin and its angular acceleration
    /// in world axes at `a = 0`, without gravity.
    pub fn jacobian_rate_times_velocity(&self, g: &mut Graph, frame: &Frame) -> [ExprId; 6] {
        let rest = vec![g.zero(); self.coordinates];
        let (link, _, point) = self.attachment(g, frame);
        let zero = g.zero();
        let Some(link) = link else { return [zero; 6] };
        let states = self.states(g, &rest, false);
        let swing = states[link].second.times(g, point);
        let linear = vector::add(g, states[link].acceleration, swing);
        let columns = self.places(g)[link].columns;
        let rows = turn::transpose(&columns);
        let [x, y, z] = turn::times(g, &rows, linear);
        let [rx, ry, rz] = turn::times(g, &rows, states[link].omega_dot);
        [x, y, z, rx, ry, rz]
    }

    /// Link (if it moves), rotation and origin of a frame there.
    fn attachment(&self, g: &mut Graph, frame: &Frame) -> (Option<usize>, Rotation, Vector) {
        let anchor = self.anchors[frame.body];
        let offset = vector::rotate(g, &anchor.rotation, frame.translation);
        let point = vector::add(g, anchor.translation, offset);
        (
            anchor.link,
            vector::product(&anchor.rotation, &frame.rotation),
            point,
        )
    }

    pub(super) fn places(&self, g: &mut Graph) -> Vec<Place> {
        let mut places: Vec<Place> = Vec::with_capacity(self.links.len());
        for link in &self.links {
            let before = match link.parent {
                Some(parent) => places[parent],
                None => {
                    let columns = vector::transpose(&link.base.rotation);
                    Place {
                        columns: columns.map(|column| vector::constant(g, column)),
                        origin: link.base.translation,
                        step: vector::zero(g),
                    }
                }
            };
            let step = turn::times(g, &turn::transpose(&before.columns), link.shift);
            places.push(Place {
                columns: turn::turn_columns(g, &link.stages, &before.columns),
                origin: vector::add(g, before.origin, step),
                step,
            });
        }
        places
    }

    fn position(
        &self,
        g: &mut Graph,
        places: &[Place],
        link: Option<usize>,
        point: Vector,
    ) -> Vector {
        let Some(link) = link else { return point };
        let turned = turn::times(g, &turn::transpose(&places[link].columns), point);
        vector::add(g, places[link].origin, turned)
    }

    /// Per freedom between the world and the frame: link, freedom, and its
    /// column of the Jacobian, or that column's rate.
    fn freedom_columns(
        &self,
        g: &mut Graph,
        frame: &Frame,
        rate: bool,
    ) -> Vec<(usize, usize, Twist)> {
        let (Some(carrier), _, point) = self.attachment(g, frame) else {
            return Vec::new();
        };
        let places = self.places(g);
        let flows = self.flows(g, &places);
        let lever = turn::times(g, &turn::transpose(&places[carrier].columns), point);
        let end = vector::add(g, places[carrier].origin, lever);
        let spin = vector::cross(g, flows[carrier].omega, lever);
        let end_velocity = vector::add(g, flows[carrier].velocity, spin);
        let mut columns = Vec::new();
        let mut next = Some(carrier);
        while let Some(i) = next {
            let arm = Arm {
                place: places[i],
                flow: flows[i],
                point: if i == carrier { Some(point) } else { None },
                end,
                end_velocity,
                own_axes: self.links[i].spherical.is_some() || self.links[i].free,
            };
            for (k, freedom) in self.links[i].freedoms.iter().enumerate() {
                let twist = if rate {
                    arm.rate(g, freedom.axis)
                } else {
                    arm.column(g, freedom.axis)
                };
                columns.push((i, k, twist));
            }
            next = self.links[i].parent;
        }
        columns
    }

    fn flows(&self, g: &mut Graph, places: &[Place]) -> Vec<Flow> {
        let zero = vector::zero(g);
        let mut flows: Vec<Flow> = Vec::with_capacity(self.links.len());
        for (i, link) in self.links.iter().enumerate() {
            let (mut omega, mut velocity) = match link.parent {
                Some(parent) => (flows[parent].omega, flows[parent].velocity),
                None => (zero, zero),
            };
            let omega_parent = omega;
            let lever = vector::cross(g, omega, places[i].step);
            velocity = vector::add(g, velocity, lever);
            for freedom in &link.freedoms {
                match freedom.axis {
                    Axis::Angular(k) => {
                        let own = vector::scale(g, freedom.rate, places[i].columns[k]);
                        omega = vector::add(g, omega, own);
                    }
                    Axis::Linear(a) => {
                        let a = vector::constant(g, a);
                        let axis = turn::times(g, &turn::transpose(&places[i].columns), a);
                        let own = vector::scale(g, freedom.rate, axis);
                        velocity = vector::add(g, velocity, own);
                    }
                }
            }
            flows.push(Flow {
                omega,
                omega_parent,
                velocity,
            });
        }
        flows
    }

    fn columns_to_matrix(
        &self,
        g: &mut Graph,
        columns: &[(usize, usize, Twist)],
    ) -> Vec<Vec<ExprId>> {
        let mut matrix = vec![vec![g.zero(); self.coordinates]; 6];
        for &(link, freedom, twist) in columns {
            for &(index, coefficient) in &self.links[link].freedoms[freedom].map {
                self.add_column(g, &mut matrix, twist, index, coefficient);
            }
        }
        matrix
    }

    fn add_column(
        &self,
        g: &mut Graph,
        matrix: &mut [Vec<ExprId>],
        twist: Twist,
        index: usize,
        coefficient: ExprId,
    ) {
        for row in 0..3 {
            let linear = g.mul(twist.linear[row], coefficient);
            matrix[row][index] = g.add(matrix[row][index], linear);
            let angular = g.mul(twist.angular[row], coefficient);
            matrix[row + 3][index] = g.add(matrix[row + 3][index], angular);
        }
    }

    /// The time derivative of a freedom's map; empty unless it is a quaternion's.
    fn map_rate(&self, g: &mut Graph, link: usize, freedom: usize) -> Vec<(usize, ExprId)> {
        let link = &self.links[link];
        let Some(rates) = link.quaternion_rates else {
            return link.freedoms[freedom].map_rate.clone();
        };
        let Some(places) = link.spherical else {
            return Vec::new();
        };
        let rows = super::placement::quaternion_map(g, rates);
        places.into_iter().zip(rows[freedom]).collect()
    }
}

/// One link on the way to a frame whose origin is at `end`.
struct Arm {
    place: Place,
    flow: Flow,
    /// The frame's origin in the link's own frame, if it is fixed there.
    point: Option<Vector>,
    end: Vector,
    end_velocity: Vector,
    /// Whether the link's axes are fixed in itself but not in its parent.
    own_axes: bool,
}

impl Arm {
    /// `(z × (x − o); z)` of an axis `z` through `o`, or `(a; 0)`.
    fn column(&self, g: &mut Graph, axis: Axis) -> Twist {
        let direction = self.direction(g, axis);
        let Axis::Angular(k) = axis else {
            return Twist {
                linear: direction,
                angular: vector::zero(g),
            };
        };
        let linear = match self.point {
            Some(point) => self.local_lever(g, k, point),
            None => {
                let gap = vector::sub(g, self.end, self.place.origin);
                vector::cross(g, direction, gap)
            }
        };
        Twist {
            linear,
            angular: direction,
        }
    }

    /// The rate of [`column`](Self::column): `ż = ω × z`.
    fn rate(&self, g: &mut Graph, axis: Axis) -> Twist {
        let direction = self.direction(g, axis);
        let omega = if self.own_axes {
            self.flow.omega
        } else {
            self.flow.omega_parent
        };
        let change = vector::cross(g, omega, direction);
        let Axis::Angular(k) = axis else {
            return Twist {
                linear: change,
                angular: vector::zero(g),
            };
        };
        let linear = match self.point {
            // The lever turns with the link.
            Some(point) => {
                let lever = self.local_lever(g, k, point);
                vector::cross(g, self.flow.omega, lever)
            }
            None => {
                let gap = vector::sub(g, self.end, self.place.origin);
                let gap_change = vector::sub(g, self.end_velocity, self.flow.velocity);
                let turning = vector::cross(g, change, gap);
                let moving = vector::cross(g, direction, gap_change);
                vector::add(g, turning, moving)
            }
        };
        Twist {
            linear,
            angular: change,
        }
    }

    /// `R (e_k × point)`: what is zero in the link's frame stays zero.
    fn local_lever(&self, g: &mut Graph, k: usize, point: Vector) -> Vector {
        let axis = vector::constant(g, IDENTITY[k]);
        let local = vector::cross(g, axis, point);
        turn::times(g, &turn::transpose(&self.place.columns), local)
    }

    fn direction(&self, g: &mut Graph, axis: Axis) -> Vector {
        match axis {
            Axis::Angular(k) => self.place.columns[k],
            Axis::Linear(a) => {
                let a = vector::constant(g, a);
                turn::times(g, &turn::transpose(&self.place.columns), a)
            }
        }
    }
}

/// `B R` for a constant `R`; columns in, columns out.
fn rotate_columns(g: &mut Graph, columns: &[Vector; 3], r: &Rotation) -> [Vector; 3] {
    let rows = turn::transpose(columns);
    vector::transpose(r).map(|column| {
        let column = vector::constant(g, column);
        turn::times(g, &rows, column)
    })
}
