//! Which coordinates a transmission can couple.

use dynamics_codegen::Model;
use dynamics_codegen::tree::Joint;

/// Pairs of coordinates that a transmission can couple: of joints of which one carries the other
/// with none between, in one unit. Of a model without bodies, all in one unit.
pub(super) fn neighbours(model: &Model) -> Vec<(usize, usize)> {
    let alike =
        |&(i, j): &(usize, usize)| model.coordinates[i].dimension == model.coordinates[j].dimension;
    let bodies = &model.tree.bodies;
    let moved: Vec<Vec<usize>> = bodies.iter().map(|body| moved_by(&body.joint)).collect();
    let mut pairs: Vec<(usize, usize)> = Vec::new();
    if moved.iter().all(Vec::is_empty) {
        let n = model.coordinates.len();
        pairs.extend((0..n).flat_map(|i| (i + 1..n).map(move |j| (i, j))));
    }
    for (body, own) in moved.iter().enumerate() {
        let ancestors = std::iter::successors(bodies[body].parent, |&p| bodies[p].parent);
        let mut ancestors = ancestors.map(|parent| &moved[parent]);
        let nearest = ancestors.find(|theirs| theirs.iter().any(|i| !own.contains(i)));
        for (&i, &j) in own
            .iter()
            .flat_map(|i| nearest.into_iter().flatten().map(move |j| (i, j)))
        {
            if i != j {
                pairs.push((i.min(j), i.max(j)));
            }
        }
    }
    pairs.sort_unstable();
    pairs.dedup();
    pairs.retain(alike);
    pairs
}

/// The coordinates that a joint moves by; of a body that is free or in a ball joint none, as no drive sits there.
fn moved_by(joint: &Joint) -> Vec<usize> {
    match joint {
        Joint::Fixed | Joint::Ball(_) | Joint::Floating(_) | Joint::Free(_) => Vec::new(),
        Joint::Revolute { coordinate, .. } | Joint::Prismatic { coordinate, .. } => {
            vec![coordinate.index]
        }
        Joint::Planar { coordinates, .. } => coordinates.iter().map(|c| c.index).collect(),
        Joint::Driven { displacement, .. } => displacement.map.iter().map(|(i, _)| *i).collect(),
    }
}
