//! Base parameters (Gautier, Khalil 1990): inertia that a joint cannot see.
//!
//! A mass on the axis of a revolute joint acts the same whether it belongs to
//! the link or to its parent. In pseudo-inertias these are the entries `m`,
//! `h_z` and `S_zz`; behind a prismatic joint all second moments are, behind a
//! spherical one the mass at its centre. They are moved to the parent, leaves
//! first, until they reach the world and vanish. Nothing else changes: the
//! equations of motion are the same functions.

use super::inertia::PseudoInertia;
use super::mechanism::{Axis, Link, Regrouped};
use super::placement::MovingJoint;
use crate::graph::Graph;

/// Moves what can be moved exactly, at no cost at run time: constant inertia
/// onto constant inertia.
pub(super) fn regroup(g: &mut Graph, links: &mut [Link], joints: &[MovingJoint]) -> Vec<Regrouped> {
    let mut report = Vec::new();
    for i in (0..links.len()).rev() {
        let own = links[i].inertia;
        let parent = links[i].parent;
        let movable = own.is_constant(g)
            && parent.is_none_or(|p| links[p].inertia.is_constant(g))
            && links[i].shift_is_constant(g);
        if !movable {
            continue;
        }
        let invisible = invisible(g, &links[i]);
        let less = invisible.neg(g);
        links[i].inertia = own.add(g, &less);
        if let Some(p) = parent {
            let link = &links[i];
            let constant = &link.stages[..link.constant_stages];
            let turned = invisible.turn(g, constant);
            let moved = turned.shift(g, link.shift);
            let sum = links[p].inertia.add(g, &moved);
            let magnitude = links[p].inertia.magnitude(g).max(moved.magnitude(g));
            links[p].inertia = sum.tidy(g, magnitude);
        }
        let constants = nonzero(g, &own) - nonzero(g, &links[i].inertia);
        if constants > 0 {
            report.push(Regrouped {
                body: joints[i].name.clone(),
                constants,
            });
        }
    }
    report.reverse();
    report
}

impl Link {
    /// Whether what is moved meets a constant displacement; behind a prismatic
    /// joint only second moments are moved, which no displacement changes.
    fn shift_is_constant(&self, g: &Graph) -> bool {
        matches!(self.freedoms[0].axis, Axis::Linear(_))
            || self.shift.iter().all(|&x| g.as_constant(x).is_some())
    }
}

/// The part of a link's inertia that its own joint cannot see.
fn invisible(g: &mut Graph, link: &Link) -> PseudoInertia {
    let own = &link.inertia;
    let mut part = PseudoInertia::zero(g);
    if link.spherical.is_some() {
        part.mass = own.mass;
        return part;
    }
    if link.free {
        return part;
    }
    match link.freedoms[0].axis {
        Axis::Angular(axis) => {
            part.mass = own.mass;
            part.first[axis] = own.first[axis];
            part.second[axis][axis] = own.second[axis][axis];
        }
        Axis::Linear(_) => part.second = own.second,
    }
    part
}

fn nonzero(g: &Graph, inertia: &PseudoInertia) -> usize {
    let upper = (0..3).flat_map(|i| (i..3).map(move |j| (i, j)));
    upper
        .filter(|&(i, j)| !g.is_zero(inertia.second[i][j]))
        .count()
        + inertia.first.iter().filter(|&&x| !g.is_zero(x)).count()
        + usize::from(!g.is_zero(inertia.mass))
}
