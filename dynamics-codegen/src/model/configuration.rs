//! What the positions of a model are, where there is not one for every velocity.
//!
//! A body that floats by its twist has six velocities and seven positions, its pose. All else
//! is a coordinate with one of each.

use super::Model;
use crate::graph::{ExprId, SymbolId};
use crate::tree;

/// The seven positions of a body that floats by its twist.
#[derive(Debug, Clone)]
pub struct Pose {
    /// The name in front of theirs: the joint's, or that of the link that floats.
    pub name: String,
    /// The first of its six [coordinates](Model::coordinates): its linear velocity, then its
    /// angular velocity, in the body's own frame.
    pub first: usize,
    /// Its origin in the frame that it floats in, m.
    pub position: [SymbolId; 3],
    /// Its orientation there, a unit quaternion `x, y, z, w`.
    pub quaternion: [SymbolId; 4],
}

/// Endings of the names of a pose's positions, with their units.
pub const POSE: [(&str, &str); 7] = [
    ("x", "m"),
    ("y", "m"),
    ("z", "m"),
    ("qx", "1"),
    ("qy", "1"),
    ("qz", "1"),
    ("qw", "1"),
];

/// Endings of the names of a twist's coordinates, with the units of what they are the rates of.
pub const TWIST: [(&str, &str); 6] = [
    ("vx", "m"),
    ("vy", "m"),
    ("vz", "m"),
    ("wx", "rad"),
    ("wy", "rad"),
    ("wz", "rad"),
];

impl Pose {
    /// Its symbols, the origin's first.
    pub fn symbols(&self) -> impl Iterator<Item = SymbolId> {
        self.position.into_iter().chain(self.quaternion)
    }

    /// Whether a coordinate is of its twist.
    pub fn moves_by(&self, coordinate: usize) -> bool {
        (self.first..self.first + 6).contains(&coordinate)
    }
}

/// One entry of `q`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Position {
    /// Its name; log columns are `q_<name>`.
    pub name: String,
    /// Its unit, as a model writes it.
    pub unit: String,
    /// Its symbol.
    pub symbol: SymbolId,
}

impl Model {
    /// The entries of `q` in order: of each coordinate its position, of a twist's six
    /// coordinates the seven of the pose.
    pub fn positions(&self) -> Vec<Position> {
        let mut positions = Vec::new();
        for (index, coordinate) in self.coordinates.iter().enumerate() {
            match self.pose_of(index) {
                None => positions.push(Position {
                    name: coordinate.name.clone(),
                    unit: coordinate.unit.clone(),
                    symbol: coordinate.position,
                }),
                Some(pose) if pose.first == index => {
                    let entries = POSE.iter().zip(pose.symbols());
                    positions.extend(entries.map(|((ending, unit), symbol)| Position {
                        name: format!("{}_{ending}", pose.name),
                        unit: unit.to_string(),
                        symbol,
                    }));
                }
                Some(_) => {}
            }
        }
        positions
    }

    /// The symbols of the entries of `q`, in order.
    pub fn position_symbols(&self) -> Vec<SymbolId> {
        self.positions().into_iter().map(|p| p.symbol).collect()
    }

    /// The pose that a coordinate's twist moves; `None` if the coordinate has a position.
    pub fn pose_of(&self, coordinate: usize) -> Option<&Pose> {
        self.poses.iter().find(|pose| pose.moves_by(coordinate))
    }

    /// Whether a coordinate is a component of a unit quaternion, along which alone nothing moves.
    pub fn is_of_quaternion(&self, coordinate: usize) -> bool {
        let mut joints = self.tree.bodies.iter().map(|body| &body.joint);
        joints.any(|joint| {
            let quaternion = match joint {
                tree::Joint::Ball(quaternion) => quaternion,
                tree::Joint::Floating(floating) => &floating.quaternion,
                _ => return false,
            };
            quaternion.iter().any(|c| c.index == coordinate)
        })
    }

    /// Where each pose's seven positions begin in `q`, and its six velocities in `v`.
    pub fn pose_places(&self) -> Vec<[usize; 2]> {
        let before = self.poses.iter().enumerate();
        before
            .map(|(k, pose)| [pose.first + k, pose.first])
            .collect()
    }

    /// `q̇`, as functions of `q` and `v`: velocities, and of a pose `R v` and `½ η ⊗ (ω, 0)`.
    pub fn position_rates(&mut self) -> Vec<ExprId> {
        let mut rates = Vec::new();
        for index in 0..self.coordinates.len() {
            match self.pose_of(index).cloned() {
                None => rates.push(self.graph.var(self.coordinates[index].velocity)),
                Some(pose) if pose.first == index => {
                    let velocities = self.coordinates[index..index + 6].iter();
                    let twist: Vec<ExprId> =
                        velocities.map(|c| self.graph.var(c.velocity)).collect();
                    rates.extend(self.pose_rates(&pose, &twist));
                }
                Some(_) => {}
            }
        }
        rates
    }

    /// What a pose's positions change by along a twist.
    fn pose_rates(&mut self, pose: &Pose, twist: &[ExprId]) -> [ExprId; 7] {
        let graph = &mut self.graph;
        let quaternion = pose.quaternion.map(|symbol| graph.var(symbol));
        let twist = std::array::from_fn(|k| twist[k]);
        tree::pose_rates(graph, quaternion, twist)
    }

    /// A small displacement along a coordinate, as what positions change by: its own position
    /// by one; along a component of a twist, a pose by that twist.
    pub(crate) fn displacement(&mut self, coordinate: usize) -> Vec<(SymbolId, ExprId)> {
        let one = self.graph.one();
        let Some(pose) = self.pose_of(coordinate).cloned() else {
            return vec![(self.coordinates[coordinate].position, one)];
        };
        let zero = self.graph.zero();
        let mut twist = [zero; 6];
        twist[coordinate - pose.first] = one;
        let rates = self.pose_rates(&pose, &twist);
        pose.symbols().zip(rates).collect()
    }
}
