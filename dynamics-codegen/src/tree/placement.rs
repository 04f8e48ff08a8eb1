//! From a tree as described to moving joints only: snapping, and fixed joints
//! merged into what carries them.

use super::inertia::PseudoInertia;
use super::mechanism::{Axis, Freedom, Snapped};
use super::turn::Matrix;
use super::vector::{self, IDENTITY, Rotation, Vector};
use super::{Body, Coordinate, Displacement, Floating, Free, Joint, Tree};
use crate::graph::{ExprId, Graph};

/// How a joint moves, in its own frame.
#[derive(Debug, Clone, Copy)]
pub(super) enum Motion {
    Revolute {
        axis: [f64; 3],
        angle: ExprId,
    },
    Prismatic {
        axis: [f64; 3],
        distance: ExprId,
    },
    Spherical {
        rotation: Matrix,
        quaternion: [Coordinate; 4],
    },
    Free {
        rotation: Matrix,
        position: Vector,
    },
}

/// A moving joint with all that is rigidly attached behind it.
#[derive(Debug, Clone)]
pub(super) struct MovingJoint {
    /// The body that it carries.
    pub name: String,
    pub parent: Option<usize>,
    pub rotation: Rotation,
    pub translation: Vector,
    pub motion: Motion,
    pub freedoms: Vec<Freedom>,
    pub inertia: PseudoInertia,
    /// Whether an expression drives it.
    pub driven: bool,
}

/// Where a body sits: on which moving joint's frame (`None`: the world), and
/// its constant pose there.
#[derive(Debug, Clone, Copy)]
pub(super) struct Anchor {
    pub link: Option<usize>,
    pub rotation: Rotation,
    pub translation: Vector,
}

pub(super) struct Skeleton {
    pub joints: Vec<MovingJoint>,
    pub anchors: Vec<Anchor>,
}

impl Skeleton {
    /// Per joint: whether others hang on it, or a body whose pose is asked for.
    pub fn joints_whose_turn_matters(&self, read: &[bool]) -> Vec<bool> {
        let mut matters = vec![false; self.joints.len()];
        for parent in self.joints.iter().filter_map(|joint| joint.parent) {
            matters[parent] = true;
        }
        for (anchor, _) in self.anchors.iter().zip(read).filter(|(_, read)| **read) {
            if let Some(link) = anchor.link {
                matters[link] = true;
            }
        }
        matters
    }
}

/// Merges fixed joints into what carries them; splits planar and floating
/// joints into chains.
pub(super) fn merge_fixed(
    g: &mut Graph,
    tree: &Tree,
    snap: Option<f64>,
    snapped: &mut Vec<Snapped>,
) -> Skeleton {
    let mut skeleton = Skeleton {
        joints: Vec::new(),
        anchors: Vec::new(),
    };
    for body in &tree.bodies {
        let rotation = snap_rotation(body, snap, snapped);
        let outer = body.parent.map_or_else(
            || Anchor {
                link: None,
                rotation: IDENTITY,
                translation: vector::zero(g),
            },
            |parent| skeleton.anchors[parent],
        );
        let offset = vector::rotate(g, &outer.rotation, body.placement.translation);
        let place = Anchor {
            link: outer.link,
            rotation: vector::product(&outer.rotation, &rotation),
            translation: vector::add(g, outer.translation, offset),
        };
        let anchor = attach(g, &mut skeleton.joints, body, place, snap);
        skeleton.anchors.push(anchor);
    }
    skeleton
}

/// Adds the body's joint, if it moves, and the body's inertia.
fn attach(
    g: &mut Graph,
    joints: &mut Vec<MovingJoint>,
    body: &Body,
    place: Anchor,
    snap: Option<f64>,
) -> Anchor {
    let mut chain = Chain {
        g,
        joints,
        name: &body.name,
        place,
        snap,
    };
    match &body.joint {
        Joint::Fixed => {}
        Joint::Revolute { axis, coordinate } => chain.revolute(*axis, *coordinate),
        Joint::Prismatic { axis, coordinate } => chain.prismatic(*axis, *coordinate),
        Joint::Planar {
            normal,
            coordinates: [first, second, angle],
        } => {
            let basis = basis_with_z(chain.unit(*normal));
            chain.prismatic(column(&basis, 0), *first);
            chain.prismatic(column(&basis, 1), *second);
            chain.revolute(*normal, *angle);
        }
        Joint::Ball(quaternion) => chain.ball(*quaternion),
        Joint::Floating(floating) => chain.floating(floating),
        Joint::Free(free) => chain.free(free),
        Joint::Driven {
            axis,
            turns,
            displacement,
        } => chain.driven(*axis, *turns, displacement),
    }
    let place = chain.place;
    let Some(link) = place.link else {
        return place; // Fixed to the world: it never moves.
    };
    let own = PseudoInertia::of_body(g, &body.inertia);
    let turned = own.rotate(g, &place.rotation);
    let placed = turned.shift(g, place.translation);
    joints[link].inertia = joints[link].inertia.add(g, &placed);
    place
}

/// Appends joints one behind the other.
struct Chain<'a> {
    g: &'a mut Graph,
    joints: &'a mut Vec<MovingJoint>,
    name: &'a str,
    place: Anchor,
    snap: Option<f64>,
}

impl Chain<'_> {
    fn unit(&self, axis: [f64; 3]) -> [f64; 3] {
        let length = vector::inner(axis, axis).sqrt();
        axis.map(|x| snap_entry(x / length, self.snap))
    }

    fn push(&mut self, motion: Motion, freedoms: Vec<Freedom>) {
        let joint = MovingJoint {
            name: self.name.to_owned(),
            parent: self.place.link,
            rotation: self.place.rotation,
            translation: self.place.translation,
            motion,
            freedoms,
            inertia: PseudoInertia::zero(self.g),
            driven: false,
        };
        self.joints.push(joint);
        self.place = Anchor {
            link: Some(self.joints.len() - 1),
            rotation: IDENTITY,
            translation: vector::zero(self.g),
        };
    }

    fn revolute(&mut self, axis: [f64; 3], c: Coordinate) {
        let axis = self.unit(axis);
        // Link frames turn about z.
        let freedom = self.freedom(Axis::Angular(2), c);
        self.push(Motion::Revolute { axis, angle: c.q }, vec![freedom]);
    }

    fn prismatic(&mut self, axis: [f64; 3], c: Coordinate) {
        let axis = self.unit(axis);
        // The axis is turned into the link's frame once that is chosen.
        let freedom = self.freedom(Axis::Linear(axis), c);
        self.push(
            Motion::Prismatic {
                axis,
                distance: c.q,
            },
            vec![freedom],
        );
    }

    fn freedom(&mut self, axis: Axis, c: Coordinate) -> Freedom {
        Freedom {
            axis,
            rate: c.v,
            map: vec![(c.index, self.g.constant(c.ratio))],
            map_rate: Vec::new(),
            drift: self.g.zero(),
        }
    }

    fn driven(&mut self, axis: [f64; 3], turns: bool, displacement: &Displacement) {
        let axis = self.unit(axis);
        let freedom = Freedom {
            axis: if turns {
                Axis::Angular(2)
            } else {
                Axis::Linear(axis)
            },
            rate: displacement.rate,
            map: displacement.map.clone(),
            map_rate: displacement.map_rate.clone(),
            drift: displacement.drift,
        };
        let value = displacement.value;
        let motion = if turns {
            Motion::Revolute { axis, angle: value }
        } else {
            Motion::Prismatic {
                axis,
                distance: value,
            }
        };
        self.push(motion, vec![freedom]);
        if let Some(joint) = self.joints.last_mut() {
            joint.driven = true;
        }
    }

    fn floating(&mut self, floating: &Floating) {
        for (axis, &coordinate) in IDENTITY.iter().zip(&floating.position) {
            self.prismatic(*axis, coordinate);
        }
        self.ball(floating.quaternion);
    }

    fn ball(&mut self, quaternion: [Coordinate; 4]) {
        let [x, y, z, w] = quaternion.map(|c| c.q);
        let rotation = quaternion_rotation(self.g, [x, y, z, w]);
        let rows = quaternion_map(self.g, [x, y, z, w]);
        let rates = quaternion.map(|c| c.v);
        let freedoms = rows.into_iter().enumerate().map(|(axis, row)| {
            let half = row.map(|x| self.g.scale(0.5, x));
            let rate = self.g.inner_product(&half, &rates);
            let indices = quaternion.iter().map(|c| c.index);
            Freedom {
                axis: Axis::Angular(axis),
                rate: self.g.scale(2.0, rate),
                map: indices.zip(row).collect(),
                map_rate: Vec::new(),
                drift: self.g.zero(),
            }
        });
        let freedoms = freedoms.collect();
        self.push(
            Motion::Spherical {
                rotation,
                quaternion,
            },
            freedoms,
        );
    }

    fn free(&mut self, free: &Free) {
        let rotation = quaternion_rotation(self.g, free.quaternion);
        let position = free.position;
        let linear = IDENTITY.map(Axis::Linear);
        let angular = [0, 1, 2].map(Axis::Angular);
        let rates = free.twist.into_iter().zip(free.indices);
        let freedoms = (linear.into_iter().chain(angular).zip(rates))
            .map(|(axis, (v, index))| {
                let coordinate = Coordinate {
                    q: v,
                    v,
                    index,
                    ratio: 1.0,
                };
                self.freedom(axis, coordinate)
            })
            .collect();
        self.push(Motion::Free { rotation, position }, freedoms);
    }
}

/// `2 E(η)` in `ω = 2 E(η) η̇`, the angular velocity in the turned frame:
/// `ω = 2 vec(η* ⊗ η̇)`.
pub(super) fn quaternion_map(g: &mut Graph, [x, y, z, w]: [ExprId; 4]) -> [[ExprId; 4]; 3] {
    let (nx, ny, nz) = (g.neg(x), g.neg(y), g.neg(z));
    [[w, z, ny, nx], [nz, w, x, ny], [y, nx, w, nz]].map(|row| row.map(|x| g.scale(2.0, x)))
}

/// What the pose of a free body changes by along its twist `v, ω`: `R(η) v`, then `½ η ⊗ (ω, 0)`.
pub fn pose_rates(g: &mut Graph, quaternion: [ExprId; 4], twist: [ExprId; 6]) -> [ExprId; 7] {
    let [vx, vy, vz, wx, wy, wz] = twist;
    let rotation = quaternion_rotation(g, quaternion);
    let [x, y, z] = rotation.map(|row| vector::dot(g, row, [vx, vy, vz]));
    // `η̇ = ½ Eᵀ ω`, and the map is `2 E`.
    let columns = quaternion_map(g, quaternion);
    let rates = [0, 1, 2, 3].map(|k| {
        let row = columns.map(|row| g.scale(0.25, row[k]));
        vector::dot(g, row, [wx, wy, wz])
    });
    let [qx, qy, qz, qw] = rates;
    [x, y, z, qx, qy, qz, qw]
}

/// The twist `v, ω` of a body along whose pose positions and quaternion change at these rates:
/// `Rᵀ(η) ẋ`, then `2 E(η) η̇`.
pub fn twist_of(
    g: &mut Graph,
    quaternion: [ExprId; 4],
    position_rate: [ExprId; 3],
    quaternion_rate: [ExprId; 4],
) -> [ExprId; 6] {
    let rotation = quaternion_rotation(g, quaternion);
    let [vx, vy, vz] = [0, 1, 2].map(|k| {
        let column = rotation.map(|row| row[k]);
        vector::dot(g, column, position_rate)
    });
    let map = quaternion_map(g, quaternion);
    let [wx, wy, wz] = map.map(|row| {
        let products = [0, 1, 2, 3].map(|k| g.mul(row[k], quaternion_rate[k]));
        g.sum(products)
    });
    [vx, vy, vz, wx, wy, wz]
}

/// The rotation of a unit quaternion `x, y, z, w`.
fn quaternion_rotation(g: &mut Graph, [x, y, z, w]: [ExprId; 4]) -> Matrix {
    let v = [x, y, z];
    let doubled = v.map(|x| g.scale(2.0, x));
    let one = g.one();
    let mut r = [vector::zero(g); 3];
    for i in 0..3 {
        let (j, k) = ((i + 1) % 3, (i + 2) % 3);
        let (jj, kk) = (g.mul(doubled[j], v[j]), g.mul(doubled[k], v[k]));
        let off = g.add(jj, kk);
        r[i][i] = g.sub(one, off);
        let (a, b) = (i.min(j), i.max(j));
        let product = g.mul(doubled[a], v[b]);
        let spin = g.mul(doubled[k], w);
        r[i][j] = g.sub(product, spin);
        r[j][i] = g.add(product, spin);
    }
    r
}

fn snap_entry(x: f64, snap: Option<f64>) -> f64 {
    let nearest = x.round();
    match snap {
        Some(tolerance) if (x - nearest).abs() <= tolerance => nearest,
        _ => x,
    }
}

fn snap_rotation(body: &Body, snap: Option<f64>, snapped: &mut Vec<Snapped>) -> Rotation {
    let given = body.placement.rotation;
    let rotation = given.map(|row| row.map(|x| snap_entry(x, snap)));
    let change = (given.iter().flatten())
        .zip(rotation.iter().flatten())
        .fold(0.0_f64, |largest, (a, b)| largest.max((a - b).abs()));
    if change > 0.0 {
        snapped.push(Snapped {
            body: body.name.clone(),
            change,
        });
    }
    rotation
}

/// A right-handed basis, as columns, whose third column is the unit vector `z`;
/// a cyclic exchange of coordinates where that is enough.
pub(super) fn basis_with_z(z: [f64; 3]) -> Rotation {
    // The largest entry of z is where the cyclic exchange puts the axis.
    let largest = (0..3).fold(
        2,
        |best, i| if z[i].abs() > z[best].abs() { i } else { best },
    );
    let mut x = [0.0; 3];
    x[(largest + 1) % 3] = 1.0;
    let along = vector::inner(x, z);
    for i in 0..3 {
        x[i] -= along * z[i];
    }
    let length = vector::inner(x, x).sqrt();
    let x = x.map(|x| x / length);
    let y = vector::crossed(z, x);
    [[x[0], y[0], z[0]], [x[1], y[1], z[1]], [x[2], y[2], z[2]]]
}

pub(super) fn column(r: &Rotation, j: usize) -> [f64; 3] {
    [r[0][j], r[1][j], r[2][j]]
}
