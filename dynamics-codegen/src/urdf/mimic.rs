//! Joints that follow other joints.

use super::records::{JointRecord, Reference};
use crate::diagnostic::Diagnostic;
use crate::robot::MAX_FINDINGS;
use crate::robot::text::{shown, suggest};
use std::collections::BTreeMap;

/// For each joint the joint that its `<mimic>` names, as far as it may.
pub(super) fn sources(
    joints: &[JointRecord],
    findings: &mut Vec<Diagnostic>,
) -> Vec<Option<usize>> {
    let before = findings.len();
    let by_name: BTreeMap<&str, usize> = joints.iter().map(|j| j.name).zip(0..).collect();
    let mut sources: Vec<Option<usize>> = joints
        .iter()
        .enumerate()
        .map(|(own, joint)| source(own, joint, joints, &by_name, findings))
        .collect();
    break_rings(joints, &mut sources, findings);
    if findings.len() == before {
        warn_of_chains(joints, &sources, findings);
    }
    sources
}

fn warn_of_chains(
    joints: &[JointRecord],
    sources: &[Option<usize>],
    findings: &mut Vec<Diagnostic>,
) {
    for (own, source) in sources.iter().enumerate() {
        let (Some(reference), Some(next)) = (joints[own].mimic, source.and_then(|s| sources[s]))
        else {
            continue;
        };
        findings.push(
            Diagnostic::warning(
                reference.span,
                format!(
                    "joint `{}` mimics `{}`, which itself mimics `{}`",
                    shown(joints[own].name),
                    shown(reference.name),
                    shown(joints[next].name)
                ),
            )
            .label("the chain is followed to its end")
            .help("name the joint at the end of the chain: other tools read one step only"),
        );
    }
}

fn source(
    own: usize,
    joint: &JointRecord,
    joints: &[JointRecord],
    by_name: &BTreeMap<&str, usize>,
    findings: &mut Vec<Diagnostic>,
) -> Option<usize> {
    let reference = joint.mimic.filter(|m| !m.name.trim().is_empty())?;
    let name = shown(joint.name);
    let other = shown(reference.name);
    if joint.kind == "fixed" {
        findings.push(
            Diagnostic::warning(
                reference.span,
                format!("joint `{name}` is fixed and mimics `{other}`"),
            )
            .label("ignored: a fixed joint does not move"),
        );
        return None;
    }
    if !joint.has_one_coordinate() {
        findings.push(
            Diagnostic::error(
                reference.span,
                format!("joint `{name}` is {} and cannot mimic", shown(joint.kind)),
            )
            .label("only a revolute, continuous or prismatic joint has the one coordinate that can follow another"),
        );
        return None;
    }
    let Some(&found) = by_name.get(reference.name) else {
        // Only so many findings are shown: beyond that, look for no likely name.
        let known = if findings.len() < MAX_FINDINGS {
            joints
        } else {
            &[]
        };
        findings.push(unknown(&name, reference, known));
        return None;
    };
    if found == own {
        findings.push(
            Diagnostic::error(reference.span, format!("joint `{name}` mimics itself"))
                .help("name another joint, or delete <mimic>"),
        );
        return None;
    }
    if !joints[found].has_one_coordinate() {
        findings.push(
            Diagnostic::error(
                reference.span,
                format!(
                    "joint `{name}` mimics `{other}`, which is {}",
                    shown(joints[found].kind)
                ),
            )
            .label("expected a revolute, continuous or prismatic joint")
            .also(joints[found].span, ""),
        );
        return None;
    }
    Some(found)
}

fn unknown(name: &str, reference: Reference, joints: &[JointRecord]) -> Diagnostic {
    let error = Diagnostic::error(
        reference.span,
        format!(
            "joint `{name}` mimics `{}`, which does not exist",
            shown(reference.name)
        ),
    );
    match suggest(reference.name, joints.iter().map(|joint| joint.name)) {
        Some(near) => error.help(format!("did you mean `{}`?", shown(near))),
        None => error.label("no <joint> has this name"),
    }
}

/// Reports every ring of mimics once and cuts it.
fn break_rings(
    joints: &[JointRecord],
    sources: &mut [Option<usize>],
    findings: &mut Vec<Diagnostic>,
) {
    let mut walk: Vec<Option<usize>> = vec![None; sources.len()];
    for start in 0..sources.len() {
        let mut at = start;
        while walk[at].is_none() {
            walk[at] = Some(start);
            match sources[at] {
                Some(next) => at = next,
                None => break,
            }
        }
        if walk[at] != Some(start) || sources[at].is_none() {
            continue;
        }
        let other = sources[at].take().unwrap_or(at);
        findings.push(
            Diagnostic::error(
                joints[at].mimic.map_or(joints[at].span, |m| m.span),
                format!(
                    "joint `{}` mimics `{}`, which in the end mimics `{0}`",
                    shown(joints[at].name),
                    shown(joints[other].name)
                ),
            )
            .help("one joint of the ring must move by itself: delete its <mimic>"),
        );
    }
}

/// `q = multiplier·q_source + offset`, with `source` a joint that follows none.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Relation {
    pub source: usize,
    pub multiplier: f64,
    pub offset: f64,
}

/// The relations with all chains followed to their ends. `own` gives multiplier
/// and offset as the file states them; `sources` is free of rings.
pub(super) fn relations(
    sources: &[Option<usize>],
    own: impl Fn(usize) -> (f64, f64),
) -> Vec<Option<Relation>> {
    let mut relations: Vec<Option<Relation>> = vec![None; sources.len()];
    let mut chain = Vec::new();
    for start in 0..sources.len() {
        let mut at = start;
        while let (None, Some(next)) = (relations[at], sources[at]) {
            chain.push(at);
            at = next;
        }
        // From the end of the chain back to its start.
        let mut end = relations[at].unwrap_or(Relation {
            source: at,
            multiplier: 1.0,
            offset: 0.0,
        });
        while let Some(joint) = chain.pop() {
            let (multiplier, offset) = own(joint);
            end = Relation {
                source: end.source,
                multiplier: multiplier * end.multiplier,
                offset: multiplier * end.offset + offset,
            };
            relations[joint] = Some(end);
        }
    }
    relations
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn chains_are_composed() {
        // q2 = 2 q1 + 1, q0 = 3 q2 + 5 = 6 q1 + 8.
        let own = [(3.0, 5.0), (1.0, 0.0), (2.0, 1.0)];
        let relations = relations(&[Some(2), None, Some(1)], |j| own[j]);
        let relation = |multiplier, offset| {
            Some(Relation {
                source: 1,
                multiplier,
                offset,
            })
        };
        assert_eq!(relations, [relation(6.0, 8.0), None, relation(2.0, 1.0)]);
    }

    #[test]
    fn a_long_chain_is_followed() {
        let count = 100_000;
        let sources: Vec<_> = (0..count).map(|i: usize| i.checked_sub(1)).collect();
        let relations = relations(&sources, |_| (1.0, 0.5));
        let last = relations[count - 1].unwrap();
        assert_eq!((last.source, last.offset), (0, 0.5 * (count - 1) as f64));
    }
}
