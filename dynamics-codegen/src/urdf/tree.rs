//! The shape of the file: whether links and joints form one tree.

use super::records::{JointRecord, LinkRecord, Reference};
use crate::diagnostic::Diagnostic;
use crate::robot::MAX_FINDINGS;
use crate::robot::text::{shown, suggest};
use std::collections::BTreeMap;

/// One body of the tree.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Place {
    /// Index of the link in the file.
    pub link: usize,
    /// Index of the joint in the file, and of the parent body among the places
    /// before this one; `None` for the root.
    pub joint: Option<(usize, usize)>,
}

/// The bodies, depth first, parents before children, siblings in the order of
/// the joints in the file; `None` if it is no tree, with the reasons reported.
pub(super) fn order(
    links: &[LinkRecord],
    joints: &[JointRecord],
    findings: &mut Vec<Diagnostic>,
) -> Option<Vec<Place>> {
    let before = findings.len();
    let by_name = index_links(links, findings);
    let unique = findings.len() == before;
    check_joint_names(joints, findings);
    let ends: Vec<Ends> = joints
        .iter()
        .map(|joint| resolve(joint, &by_name, links, findings))
        .collect();
    let carriers = carriers(links, joints, &ends, findings);
    let resolved = ends.iter().all(|e| e.parent.is_some() && e.child.is_some());
    if !resolved {
        return None;
    }
    check_cycles(joints, &ends, &carriers, findings);
    let roots: Vec<usize> = (0..links.len())
        .filter(|&l| carriers[l].is_none())
        .collect();
    if unique {
        check_roots(links, &roots, findings);
    }
    match roots[..] {
        [root] if findings.len() == before => Some(depth_first(root, links.len(), &ends)),
        _ => None,
    }
}

/// The links at both ends of a joint, as far as they exist.
#[derive(Debug, Clone, Copy)]
struct Ends {
    parent: Option<usize>,
    child: Option<usize>,
}

fn index_links<'a>(
    links: &[LinkRecord<'a, '_>],
    findings: &mut Vec<Diagnostic>,
) -> BTreeMap<&'a str, usize> {
    let mut by_name = BTreeMap::new();
    for (i, link) in links.iter().enumerate() {
        if link.name.is_empty() {
            continue;
        }
        match by_name.get(link.name) {
            None => {
                by_name.insert(link.name, i);
            }
            Some(&first) => {
                findings.push(duplicate("link", link.name, links[first].span, link.span))
            }
        }
    }
    by_name
}

fn check_joint_names(joints: &[JointRecord], findings: &mut Vec<Diagnostic>) {
    let mut seen = BTreeMap::new();
    for joint in joints.iter().filter(|joint| !joint.name.is_empty()) {
        if let Some(first) = seen.insert(joint.name, joint.span) {
            findings.push(duplicate("joint", joint.name, first, joint.span));
        }
    }
}

fn duplicate(
    what: &str,
    name: &str,
    first: crate::source::Span,
    second: crate::source::Span,
) -> Diagnostic {
    Diagnostic::error(second, format!("two {what}s are called `{}`", shown(name)))
        .label("the second")
        .also(first, "the first")
        .help("rename one of them")
}

fn resolve(
    joint: &JointRecord,
    by_name: &BTreeMap<&str, usize>,
    links: &[LinkRecord],
    findings: &mut Vec<Diagnostic>,
) -> Ends {
    let mut find = |end: Option<Reference>, word: &str| {
        let end = end.filter(|end| !end.name.trim().is_empty())?;
        let found = by_name.get(end.name).copied();
        if found.is_none() {
            // Only so many findings are shown: beyond that, look for no likely name.
            let known = if findings.len() < MAX_FINDINGS {
                links
            } else {
                &[]
            };
            findings.push(dangling(joint, end, word, known));
        }
        found
    };
    Ends {
        parent: find(joint.parent, "parent"),
        child: find(joint.child, "child"),
    }
}

fn dangling(joint: &JointRecord, end: Reference, word: &str, links: &[LinkRecord]) -> Diagnostic {
    let error = Diagnostic::error(
        end.span,
        format!(
            "joint `{}`: its {word} link `{}` is not declared",
            shown(joint.name),
            shown(end.name)
        ),
    )
    .label("no <link> has this name");
    match suggest(end.name, links.iter().map(|link| link.name)) {
        Some(near) => error.help(format!("did you mean `{}`?", shown(near))),
        None => error.help(format!(
            "declare it: <link name=\"{}\"/> (a link without <inertial> has no mass)",
            shown(end.name)
        )),
    }
}

/// For each link the joint that carries it.
fn carriers(
    links: &[LinkRecord],
    joints: &[JointRecord],
    ends: &[Ends],
    findings: &mut Vec<Diagnostic>,
) -> Vec<Option<usize>> {
    let mut carriers: Vec<Option<usize>> = vec![None; links.len()];
    for (j, end) in ends.iter().enumerate() {
        let Some(child) = end.child else { continue };
        let Some(first) = carriers[child] else {
            carriers[child] = Some(j);
            continue;
        };
        // Both joints resolved their child, so both state one.
        let span = |j: usize| joints[j].child.map_or(joints[j].span, |child| child.span);
        findings.push(
            Diagnostic::error(
                span(j),
                format!(
                    "link `{}` is the child of two joints: `{}` and `{}`",
                    shown(links[child].name),
                    shown(joints[first].name),
                    shown(joints[j].name)
                ),
            )
            .label("the second")
            .also(span(first), "the first")
            .help(
                "a URDF is a tree: cut the loop here, and close it with a constraint in the model",
            ),
        );
    }
    carriers
}

/// Reports every ring of joints once.
fn check_cycles(
    joints: &[JointRecord],
    ends: &[Ends],
    carriers: &[Option<usize>],
    findings: &mut Vec<Diagnostic>,
) {
    // Which walk first came by; walks go from child to parent and end at the
    // root, at a link seen by an earlier walk, or at one of their own: a ring.
    let mut walk: Vec<Option<usize>> = vec![None; carriers.len()];
    for start in 0..carriers.len() {
        let mut link = start;
        loop {
            if let Some(earlier) = walk[link] {
                if earlier == start {
                    findings.push(ring(link, joints, ends, carriers));
                }
                break;
            }
            walk[link] = Some(start);
            let parent = carriers[link].and_then(|joint| ends[joint].parent);
            match parent {
                Some(parent) => link = parent,
                None => break,
            }
        }
    }
}

/// The message about the ring through `link`.
fn ring(
    link: usize,
    joints: &[JointRecord],
    ends: &[Ends],
    carriers: &[Option<usize>],
) -> Diagnostic {
    let mut ring = Vec::new();
    let mut at = link;
    while let Some(joint) = carriers[at] {
        ring.push(joint);
        match ends[joint].parent {
            Some(parent) if parent != link => at = parent,
            _ => break,
        }
    }
    // From parent to child, beginning with the joint that comes first in the file.
    ring.reverse();
    let first = (0..ring.len()).min_by_key(|&k| ring[k]).unwrap_or(0);
    ring.rotate_left(first);
    let [head, rest @ ..] = &ring[..] else {
        // `link` lies on a ring, so it has a carrier.
        unreachable!("a ring has a joint")
    };
    let name = |joint: &usize| format!("`{}`", shown(joints[*joint].name));
    if rest.is_empty() {
        return Diagnostic::error(
            joints[*head].span,
            format!("joint {} connects a link with itself", name(head)),
        )
        .help("<parent> and <child> must name two different links");
    }
    let names: Vec<String> = ring.iter().take(6).map(name).collect();
    let more = if ring.len() > 6 { " → …" } else { "" };
    let mut error = Diagnostic::error(
        joints[*head].span,
        format!("the joints {}{more} form a ring", names.join(" → ")),
    )
    .help("a URDF is a tree: leave out one joint of the ring, and close it with a constraint in the model");
    for joint in rest.iter().take(5) {
        error = error.also(joints[*joint].span, "");
    }
    error
}

fn check_roots(links: &[LinkRecord], roots: &[usize], findings: &mut Vec<Diagnostic>) {
    let [first, rest @ ..] = roots else {
        // No root: there is a ring, which has been reported, or no link at all.
        return;
    };
    if rest.is_empty() {
        return;
    }
    let names: Vec<String> = roots
        .iter()
        .take(6)
        .map(|&l| format!("`{}`", shown(links[l].name)))
        .collect();
    let more = if roots.len() > 6 { ", …" } else { "" };
    let mut error = Diagnostic::error(
        links[rest[0]].span,
        format!(
            "{} links are the child of no joint, but a robot has one root: {}{more}",
            roots.len(),
            names.join(", ")
        ),
    )
    .also(links[*first].span, "a root")
    .help("connect the parts by joints (type=\"fixed\", or \"floating\" for a free body), or delete what is not used");
    error = error.label("another root");
    for &link in rest[1..].iter().take(4) {
        error = error.also(links[link].span, "another root");
    }
    findings.push(error);
}

/// The order of the bodies, with a stack of our own.
fn depth_first(root: usize, count: usize, ends: &[Ends]) -> Vec<Place> {
    let mut joints_of: Vec<Vec<usize>> = vec![Vec::new(); count];
    for (j, end) in ends.iter().enumerate() {
        if let Some(parent) = end.parent {
            joints_of[parent].push(j);
        }
    }
    let mut order = Vec::with_capacity(count);
    let mut stack = vec![Place {
        link: root,
        joint: None,
    }];
    while let Some(place) = stack.pop() {
        let own = order.len();
        order.push(place);
        for &joint in joints_of[place.link].iter().rev() {
            // The caller has checked that every joint has both ends.
            if let Some(link) = ends[joint].child {
                stack.push(Place {
                    link,
                    joint: Some((joint, own)),
                });
            }
        }
    }
    order
}
