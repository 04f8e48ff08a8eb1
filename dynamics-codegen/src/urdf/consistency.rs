//! Whether a body with these masses and inertias can exist, and can be moved.

use super::impossible::{Impossible, MEND};
use super::merge::merge_fixed;
use super::records::{LinkRecord, child};
use super::robot::{JointKind, Robot};
use super::spatial::{Inertia, Matrix3, apply, dot};
use super::text::shown;
use super::tree::Place;
use super::xml::Places;
use crate::diagnostic::{Diagnostic, Severity};
use crate::source::Span;

/// The tree, as far as this check needs it.
pub(super) struct Tree {
    /// Index of the root link in the file.
    pub root: usize,
    /// For each link of the file the whole body that fixed joints make of it.
    pub wholes: Vec<Inertia>,
}

/// Checks the inertia of every link. A link that no body can have is an error,
/// unless fixed joints weld it to others and the whole is a possible body: only
/// the whole enters the equations. The root may be a mere frame, or have the mass
/// 0 that says in Bullet that it stands still: neither is worth a word.
pub(super) fn check_links(
    places: Places,
    links: &[LinkRecord],
    inertias: &[Inertia],
    tree: Option<&Tree>,
    findings: &mut Vec<Diagnostic>,
) {
    let root = tree.map(|tree| tree.root);
    if let Some(root) = root {
        report_massless(links, root, findings);
    }
    for (index, (link, inertia)) in links.iter().zip(inertias).enumerate() {
        let Some(element) = link
            .inertial
            .and_then(|inertial| child(inertial, "inertia"))
        else {
            continue;
        };
        let at = places.tag(element);
        let name = shown(link.name);
        if inertia.mass == 0.0 && !inertia.is_zero() && root != Some(index) {
            findings.push(
                Diagnostic::warning(
                    at,
                    format!("link `{name}` has rotational inertia but no mass"),
                )
                .label("no body is like that; the figures are used as they stand"),
            );
        }
        let Some(impossible) = Impossible::of(&inertia.tensor) else {
            continue;
        };
        let possible = |whole: &&Inertia| {
            Impossible::of(&whole.tensor).is_none_or(|found| found.rounding().is_some())
        };
        let whole = tree
            .map(|tree| &tree.wholes[index])
            .filter(|whole| *whole != inertia)
            .filter(possible);
        findings.push(finding(at, &name, &impossible, whole.is_some()));
    }
}

/// The finding about an inertia that no body has.
fn finding(at: Span, name: &str, impossible: &Impossible, welded: bool) -> Diagnostic {
    let what = format!("link `{name}`: {}", impossible.what);
    if let Some(rounding) = impossible.rounding() {
        return Diagnostic::warning(at, what)
            .label(impossible.why)
            .help(rounding);
    }
    if welded {
        return Diagnostic::warning(at, what).label(impossible.why).help(
            "fixed joints weld this link to others, and the whole is a possible body: the figures are used as they stand",
        );
    }
    Diagnostic::error(at, what).label(impossible.why).help(MEND)
}

/// Makes warnings of errors about inertias: whoever published them may have no better ones.
pub(super) fn excuse(findings: &mut [Diagnostic]) {
    for finding in findings
        .iter_mut()
        .filter(|f| f.severity == Severity::Error)
    {
        finding.severity = Severity::Warning;
        finding.help = vec![
            "the figures are used as they stand: energy may become negative, and then no motion \
             can be predicted; `dynamics fit --inertia consistent` finds ones that a body can have"
                .to_string(),
        ];
    }
}

/// One warning about all links without `<inertial>` but the root.
fn report_massless(links: &[LinkRecord], root: usize, findings: &mut Vec<Diagnostic>) {
    let massless: Vec<&LinkRecord> = links
        .iter()
        .enumerate()
        .filter(|(index, link)| link.inertial.is_none() && root != *index)
        .map(|(_, link)| link)
        .collect();
    let [first, rest @ ..] = &massless[..] else {
        return;
    };
    let message = match rest.len() {
        0 => format!(
            "link `{}` has no <inertial>: it counts as massless",
            shown(first.name)
        ),
        more => format!(
            "{} links have no <inertial>: they count as massless",
            more + 1
        ),
    };
    let mut warning = Diagnostic::warning(first.span, message);
    for link in rest.iter().take(4) {
        warning = warning.also(link.span, "");
    }
    if rest.len() > 4 {
        warning = warning.help(format!("{} more are not shown", rest.len() - 4));
    }
    findings.push(warning);
}

/// What [`check_links`] needs of the tree. `order` gives the links of the file in
/// the order of the robot's bodies.
pub(super) fn tree(robot: &Robot, order: &[Place]) -> Option<Tree> {
    let merged = merge_fixed(robot);
    let mut wholes = vec![Inertia::ZERO; order.len()];
    for (place, frame) in order.iter().zip(&merged.frames) {
        wholes[place.link] = merged.bodies[frame.body].inertia;
    }
    let root = order.first()?.link;
    Some(Tree { root, wholes })
}

/// Every independent coordinate must move something.
pub(super) fn check_mobility(robot: &Robot, findings: &mut Vec<Diagnostic>) {
    let merged = merge_fixed(robot);
    let bodies = &merged.bodies;
    let distal = distal(&merged);
    let mut moves: Vec<bool> = vec![false; bodies.len()];
    let mut carries: Vec<bool> = vec![false; bodies.len()];
    for (i, body) in bodies.iter().enumerate() {
        let Some(joint) = &body.joint else { continue };
        let leaf = distal[i].bodies == 1;
        let something = match joint.kind {
            JointKind::Fixed => true,
            JointKind::Prismatic { .. } | JointKind::Planar { .. } | JointKind::Floating => {
                distal[i].mass > 0.0
            }
            JointKind::Revolute { axis } if leaf => about(&body.inertia, axis) > 0.0,
            JointKind::Revolute { .. } => distal[i].mass > 0.0 || distal[i].rotational,
        };
        // A joint that follows moves its inertia with the joint it follows.
        let coordinate = joint.mimic.filter(|m| m.multiplier != 0.0);
        moves[i] |= something;
        carries[i] |= distal[i].mass > 0.0;
        if let Some(mimic) = coordinate {
            moves[mimic.source] |= something;
            carries[mimic.source] |= distal[i].mass > 0.0;
        }
    }
    for ((body, moves), carries) in bodies.iter().zip(moves).zip(carries) {
        let Some(joint) = &body.joint else { continue };
        if joint.mimic.is_none() && !moves {
            findings.push(immobile(&joint.name, joint.span, joint.kind, carries));
        }
    }
}

fn immobile(name: &str, span: Span, kind: JointKind, carries: bool) -> Diagnostic {
    let lacks = match kind {
        JointKind::Revolute { .. } => "inertia about its axis",
        _ => "mass",
    };
    let message = format!("joint `{}` moves nothing that has {lacks}", shown(name));
    if carries {
        // A design without the rotor: forces follow from motion, motion not from forces.
        return Diagnostic::warning(span, message)
            .label("its acceleration is undetermined")
            .help("give a link beyond it its inertia, or add that of the rotor to the model: `effect armature(joint) { … }`");
    }
    Diagnostic::error(span, message)
        .label("its acceleration would be undetermined")
        .help("give a link beyond it an <inertial>, or make the joint type=\"fixed\"")
}

/// What hangs on a joint.
#[derive(Debug, Clone, Copy)]
struct Distal {
    mass: f64,
    rotational: bool,
    bodies: usize,
}

/// Sums from the leaves to the root: children stand after their parents.
fn distal(robot: &Robot) -> Vec<Distal> {
    let mut sums: Vec<Distal> = robot
        .bodies
        .iter()
        .map(|body| Distal {
            mass: body.inertia.mass,
            rotational: body.inertia.tensor.iter().flatten().any(|&x| x != 0.0),
            bodies: 1,
        })
        .collect();
    for i in (0..sums.len()).rev() {
        if let Some(joint) = &robot.bodies[i].joint {
            let own = sums[i];
            let parent = &mut sums[joint.parent];
            parent.mass += own.mass;
            parent.rotational |= own.rotational;
            parent.bodies += own.bodies;
        }
    }
    sums
}

/// The moment of inertia about an axis through the origin, `aᵀ I a`.
fn about(inertia: &Inertia, axis: [f64; 3]) -> f64 {
    let tensor: Matrix3 = inertia.about_origin();
    dot(axis, apply(&tensor, axis))
}
