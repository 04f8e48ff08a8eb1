//! From parts in the order of the file to a robot in the order of the tree.

use super::joint::Part;
use super::mimic::relations;
use super::records::{JointRecord, LinkRecord};
use super::tree::Place;
use crate::diagnostic::Diagnostic;
use crate::robot::text::shown;
use crate::robot::xml::Places;
use crate::robot::{Body, Format, Frame, Inertia, Joint, Mimic, Placement, Robot, Snapped};
use roxmltree::Document;

/// Everything that has been read, in the order of the file.
pub(super) struct Parts<'a, 'd> {
    pub links: &'a [LinkRecord<'a, 'd>],
    pub inertias: &'a [Inertia],
    pub joints: &'a [JointRecord<'a, 'd>],
    pub parts: &'a [Part],
    /// For each joint the joint that it follows, free of rings.
    pub mimics: &'a [Option<usize>],
    pub values: &'a [urdf_rs::Joint],
    pub snapped: Snapped,
}

/// Puts the robot together.
pub(super) fn assemble(
    places: Places,
    document: &Document,
    parts: &Parts,
    order: &[Place],
) -> Robot {
    let root = document.root_element();
    let mimics = follow(places, parts, order);
    let bodies: Vec<Body> = order
        .iter()
        .map(|place| body(places, parts, place, &mimics))
        .collect();
    let frames = bodies.iter().enumerate().map(|(i, body)| Frame {
        link: body.link.clone(),
        joint: body.joint.as_ref().map(|joint| joint.name.clone()),
        span: body.span,
        body: i,
        placement: Placement::IDENTITY,
    });
    Robot {
        format: Format::Urdf,
        name: root.attribute("name").unwrap_or("").to_string(),
        span: places.tag(root),
        frames: frames.collect(),
        bodies,
        snapped: parts.snapped,
        gravity: None,
        actuators: Vec::new(),
        closures: Vec::new(),
        included: Vec::new(),
    }
}

fn body(places: Places, parts: &Parts, place: &Place, mimics: &[Option<Mimic>]) -> Body {
    let link = &parts.links[place.link];
    Body {
        link: link.name.to_string(),
        span: link.span,
        joint: place.joint.map(|(index, parent)| {
            let record = &parts.joints[index];
            let part = &parts.parts[index];
            Joint {
                name: record.name.to_string(),
                span: record.span,
                parent,
                kind: part.kind,
                placement: part.placement,
                limits: part.limits,
                mimic: mimics[index],
                losses: part.losses,
                armature: 0.0,
                spring: None,
            }
        }),
        inertia: parts.inertias[place.link],
        inertial: link.inertial.map(|node| places.tag(node)),
    }
}

/// A chain of mimics whose ratios multiply up beyond all numbers.
pub(super) fn check_mimics(robot: &Robot, findings: &mut Vec<Diagnostic>) {
    for joint in robot.bodies.iter().filter_map(|body| body.joint.as_ref()) {
        let Some(mimic) = joint.mimic else { continue };
        if mimic.multiplier.is_finite() && mimic.offset.is_finite() {
            continue;
        }
        findings.push(Diagnostic::error(
            mimic.span,
            format!(
                "joint `{}`: the multipliers of the chain of mimics overflow",
                shown(&joint.name)
            ),
        ));
    }
}

/// For each joint of the file what it follows, as an index of a body.
fn follow(places: Places, parts: &Parts, order: &[Place]) -> Vec<Option<Mimic>> {
    let mut carried = vec![0; parts.joints.len()];
    for (body, place) in order.iter().enumerate() {
        if let Some((joint, _)) = place.joint {
            carried[joint] = body;
        }
    }
    let stated = |joint: usize| {
        let mimic = parts.values[joint].mimic.as_ref();
        (
            mimic.and_then(|m| m.multiplier).unwrap_or(1.0),
            mimic.and_then(|m| m.offset).unwrap_or(0.0),
        )
    };
    let relations = relations(parts.mimics, stated);
    let mimic = |(joint, relation): (&JointRecord, Option<super::mimic::Relation>)| {
        let relation = relation?;
        Some(Mimic {
            source: carried[relation.source],
            multiplier: relation.multiplier,
            offset: relation.offset,
            span: places.tag(joint.element("mimic")?),
        })
    };
    parts.joints.iter().zip(relations).map(mimic).collect()
}
