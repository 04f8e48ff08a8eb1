//! What a tree must be before anything is derived from it.

use super::vector::{self, IDENTITY};
use super::{Body, Coordinate, Joint, Tree, TreeError};
use crate::graph::{ExprId, Graph};

/// The mass matrix of a chain is full: above this, straight-line code of it is
/// of no use to anyone.
const MOST_COORDINATES: usize = 500;

/// The matrix over all joints is full on the way, also where an expression moves them.
const MOST_JOINTS: usize = 1000;

/// Everything that would make a later step meaningless.
pub(super) fn tree(g: &Graph, tree: &Tree) -> Result<(), TreeError> {
    if tree.coordinates > MOST_COORDINATES {
        return Err(TreeError::TooLarge {
            coordinates: tree.coordinates,
            most: MOST_COORDINATES,
        });
    }
    let moves = |body: &&Body| !matches!(body.joint, Joint::Fixed);
    let joints = tree.bodies.iter().filter(moves).count();
    if joints > MOST_JOINTS {
        return Err(TreeError::TooManyJoints {
            joints,
            most: MOST_JOINTS,
        });
    }
    for (position, body) in tree.bodies.iter().enumerate() {
        if let Some(parent) = body.parent.filter(|&parent| parent >= position) {
            let body = body.name.clone();
            return Err(TreeError::Order { body, parent });
        }
        check_rotation(body)?;
        check_constants(g, body)?;
        if let Joint::Driven { displacement, .. } = &body.joint {
            let map = displacement.map.iter().chain(&displacement.map_rate);
            check_map(body, map.map(|entry| entry.0), tree.coordinates)?;
        }
        if let Joint::Free(free) = &body.joint {
            check_map(body, free.indices.into_iter(), tree.coordinates)?;
        }
        for coordinate in coordinates(&body.joint) {
            check_coordinate(body, coordinate, tree.coordinates)?;
        }
        if let Joint::Revolute { axis, .. }
        | Joint::Prismatic { axis, .. }
        | Joint::Planar { normal: axis, .. }
        | Joint::Driven { axis, .. } = body.joint
        {
            let length = vector::inner(axis, axis).sqrt();
            if !length.is_finite() || length < 1e-12 {
                let body = body.name.clone();
                return Err(TreeError::Axis { body, axis });
            }
        }
    }
    Ok(())
}

fn check_map(
    body: &Body,
    mut indices: impl Iterator<Item = usize>,
    coordinates: usize,
) -> Result<(), TreeError> {
    match indices.find(|&index| index >= coordinates) {
        None => Ok(()),
        Some(index) => Err(TreeError::Coordinate {
            body: body.name.clone(),
            index,
            coordinates,
        }),
    }
}

fn check_rotation(body: &Body) -> Result<(), TreeError> {
    let r = &body.placement.rotation;
    let gram = vector::product(&vector::transpose(r), r);
    let mut error = 0.0_f64;
    for i in 0..3 {
        for j in 0..3 {
            let difference = (gram[i][j] - IDENTITY[i][j]).abs();
            error = if difference.is_nan() {
                f64::NAN
            } else {
                error.max(difference)
            };
        }
    }
    let determinant = vector::inner(r[0], vector::crossed(r[1], r[2]));
    if error <= 1e-6 && determinant > 0.0 {
        return Ok(());
    }
    Err(TreeError::Rotation {
        body: body.name.clone(),
        error,
        determinant,
    })
}

fn check_constants(g: &Graph, body: &Body) -> Result<(), TreeError> {
    let finite = |x: &ExprId| g.as_constant(*x).is_none_or(f64::is_finite);
    let inertia = &body.inertia;
    let what = if !body.placement.translation.iter().all(finite) {
        "translation"
    } else if !finite(&inertia.mass) {
        "mass"
    } else if !inertia.center.iter().all(finite) {
        "centre of mass"
    } else if !inertia.tensor.iter().flatten().all(finite) {
        "inertia tensor"
    } else {
        return Ok(());
    };
    let body = body.name.clone();
    Err(TreeError::NotFinite { body, what })
}

fn check_coordinate(body: &Body, c: Coordinate, coordinates: usize) -> Result<(), TreeError> {
    check_map(body, std::iter::once(c.index), coordinates)?;
    if c.ratio.is_finite() && c.ratio != 0.0 {
        return Ok(());
    }
    Err(TreeError::Ratio {
        body: body.name.clone(),
        ratio: c.ratio,
    })
}

fn coordinates(joint: &Joint) -> Vec<Coordinate> {
    match joint {
        Joint::Fixed => Vec::new(),
        Joint::Revolute { coordinate, .. } | Joint::Prismatic { coordinate, .. } => {
            vec![*coordinate]
        }
        Joint::Planar { coordinates, .. } => coordinates.to_vec(),
        Joint::Ball(quaternion) => quaternion.to_vec(),
        Joint::Floating(floating) => {
            let mut all = floating.position.to_vec();
            all.extend(floating.quaternion);
            all
        }
        Joint::Free(_) | Joint::Driven { .. } => Vec::new(),
    }
}
