//! Frames that do not turn with their joint.
//!
//! Mass matrix and forces are relations between vectors of one instant, in whatever axes these are
//! written. So a link's frame need not be fixed in it. Where all joints that a link carries are
//! parallel to its own, its frame here keeps the axes from before its joint turns: what comes from
//! further out is turned once, by the sum of the angles, in place of once by each; the link's own
//! inertia is turned, and the places of the joints that it carries. Whether that takes fewer
//! operations is tried out ([`Mechanism::with_frames`](super::Mechanism::with_frames)).

use super::link::joint_turn;
use super::mechanism::{Axis, Link};
use super::turn;
use crate::graph::{ExprId, Graph};

/// What a revolute joint turns by.
#[derive(Debug, Clone, Copy)]
pub(super) struct JointAngle {
    pub angle: ExprId,
    /// Cosine and sine of what is added to it.
    pub offset: (f64, f64),
}

/// The links in frames that keep their axes wherever all that they carry turns about the same
/// direction; `None` if no link is such.
pub(super) fn upright(g: &mut Graph, links: &[Link]) -> Option<Vec<Link>> {
    let mut links = links.to_vec();
    let mut any = false;
    for i in 0..links.len() {
        let carried: Vec<usize> = (i + 1..links.len())
            .filter(|&k| links[k].parent == Some(i))
            .collect();
        let parallel = !carried.is_empty() && carried.iter().all(|&k| links[k].is_parallel());
        let Some(own) = links[i].turns_by.filter(|_| parallel) else {
            continue;
        };
        any = true;
        let constant = links[i].constant_stages;
        let joint = links[i].stages.split_off(constant);
        links[i].inertia = links[i].inertia.turn(g, &joint);
        for k in carried {
            let link = &mut links[k];
            link.shift = turn::up(g, &joint, link.shift);
            if let Some(JointAngle { angle, offset }) = link.turns_by {
                let sum = JointAngle {
                    angle: g.add(own.angle, angle),
                    offset: turn::tidy_pair(turn::compose(own.offset, offset)),
                };
                link.turns_by = Some(sum);
                link.stages = vec![joint_turn(g, sum.angle, sum.offset)];
            }
        }
    }
    any.then_some(links)
}

impl Link {
    /// Whether its joint turns about the direction of the z axis of what carries it.
    fn is_parallel(&self) -> bool {
        let turns = self.freedoms.len() == 1 && matches!(self.freedoms[0].axis, Axis::Angular(2));
        turns && self.constant_stages == 0
    }
}
