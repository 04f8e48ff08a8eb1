//! URDF: from the text of a robot description to a [`Robot`], a tree of bodies.
//!
//! ```text
//! text ──xml──▶ document ──check──▶ records ──tree──▶ order ──assemble──▶ Robot
//!                  │    (schema)                        ▲
//!                  └──values (urdf-rs)──▶ numbers ──────┘
//! ```
//!
//! [`urdf_rs`] reads the numbers; it says nothing about places and lets much
//! pass (a missing inertial is a mass of zero, a misspelt attribute is skipped),
//! so that every file passes our own checks first. Each of them has a place and
//! a mend. All that is wrong is reported at once.
//!
//! Errors: text that is no XML or no URDF, unexpanded xacro, a document type
//! declaration, missing, misspelt or repeated elements and attributes, values
//! that are not what they must be, names that are missing, doubled or point
//! nowhere, links and joints that do not form one tree, a zero axis, mimics of
//! nothing or in rings, inertias that no body can have, and joints that move
//! nothing.
//!
//! Warnings, where there is a plain reading: links without `<inertial>` (they
//! count as massless; the root may well be), joints without `<axis>` (URDF's default) or `<limit>`
//! (unlimited), axes that are not of unit length (only the direction counts),
//! elements and attributes that URDF does not know and that resemble nothing it
//! knows (ignored), inertias off by a rounding.

mod assemble;
mod check;
mod consistency;
mod joint;
mod mimic;
mod records;
mod schema;
#[cfg(test)]
mod tests;
mod tree;
mod values;

use crate::diagnostic::{Diagnostic, Severity};
use crate::robot::text::shown;
use crate::robot::xml::{self, Places};
use crate::robot::{Format, Inertia, Options, Robot, check_mobility, excuse, lock, shorten};
use crate::source::{SourceId, Sources};
use assemble::{Parts, assemble, check_mimics};
use consistency::{check_links, tree};
use joint::PartReader;
use records::{JointRecord, LinkRecord};
use roxmltree::Document;
use tree::Place;

/// Reads a URDF with the default [`Options`].
///
/// What is wrong or worth knowing is added to `diagnostics`; the result is
/// `None` if any of it is an error.
///
/// ```
/// use dynamics_codegen::source::Sources;
/// use dynamics_codegen::urdf;
///
/// let mut sources = Sources::new();
/// let id = sources.add("pendulum.urdf", r#"
///     <robot name="pendulum">
///       <link name="world"/>
///       <link name="rod">
///         <inertial>
///           <origin xyz="0 0 -0.5"/>
///           <mass value="2"/>
///           <inertia ixx="0.1" ixy="0" ixz="0" iyy="0.1" iyz="0" izz="0.001"/>
///         </inertial>
///       </link>
///       <joint name="hinge" type="continuous">
///         <parent link="world"/>
///         <child link="rod"/>
///         <axis xyz="0 1 0"/>
///       </joint>
///     </robot>"#);
/// let mut diagnostics = Vec::new();
/// let robot = urdf::read(&sources, id, &mut diagnostics).unwrap();
/// assert_eq!(robot.bodies[1].link, "rod");
/// assert_eq!(robot.bodies[1].inertia.mass, 2.0);
/// assert!(diagnostics.is_empty());
/// ```
pub fn read(sources: &Sources, id: SourceId, diagnostics: &mut Vec<Diagnostic>) -> Option<Robot> {
    read_with(sources, id, Options::default(), diagnostics)
}

/// Reads a URDF. As [`read`], with options.
pub fn read_with(
    sources: &Sources,
    id: SourceId,
    options: Options<'_>,
    diagnostics: &mut Vec<Diagnostic>,
) -> Option<Robot> {
    let places = Places {
        source: id,
        text: &sources.get(id).text,
    };
    let mut findings = Vec::new();
    let robot = read_text(places, options, &mut findings);
    let failed = findings.iter().any(|f| f.severity == Severity::Error);
    diagnostics.extend(shorten(findings));
    robot.filter(|_| !failed)
}

fn read_text(
    places: Places,
    options: Options<'_>,
    findings: &mut Vec<Diagnostic>,
) -> Option<Robot> {
    let document = xml::parse(places, Format::Urdf)
        .and_then(|document| check::is_urdf(places, &document).map(|()| document))
        .map_err(|error| findings.push(*error))
        .ok()?;
    check::check(places, &document, findings);
    let well_formed = findings.iter().all(|f| f.severity == Severity::Warning);
    let (links, joints) = records::collect(places, &document);
    if links.is_empty() {
        findings.push(no_link(places, &document));
    }
    let order = tree::order(&links, &joints, findings);
    let mimics = mimic::sources(&joints, findings);
    if !well_formed {
        return None;
    }
    let values = values::read(&document)
        .map_err(|error| findings.push(objection(places, &document, &error)))
        .ok()?;
    let file = File {
        places,
        document: &document,
        links,
        joints,
        mimics,
        values,
    };
    file.assemble(order.as_deref(), options, findings)
}

/// A file whose form is right.
struct File<'a, 'd> {
    places: Places<'a>,
    document: &'a Document<'d>,
    links: Vec<LinkRecord<'a, 'd>>,
    joints: Vec<JointRecord<'a, 'd>>,
    mimics: Vec<Option<usize>>,
    values: urdf_rs::Robot,
}

impl File<'_, '_> {
    /// Reads the parts, and puts them together if there is an order.
    fn assemble(
        &self,
        order: Option<&[Place]>,
        options: Options<'_>,
        findings: &mut Vec<Diagnostic>,
    ) -> Option<Robot> {
        let mut reader = PartReader::new(self.places, options, findings);
        let links = self.links.iter().zip(&self.values.links);
        let inertias: Vec<Inertia> = links
            .map(|(link, value)| reader.inertia(link, &value.inertial))
            .collect();
        let joints = self.joints.iter().zip(&self.values.joints);
        let parts: Vec<_> = joints
            .map(|(joint, value)| reader.joint(joint, value))
            .collect();
        let snapped = reader.snapped;
        let mut robot = order.map(|order| {
            let parts = Parts {
                links: &self.links,
                inertias: &inertias,
                joints: &self.joints,
                parts: &parts,
                mimics: &self.mimics,
                values: &self.values.joints,
                snapped,
            };
            assemble(self.places, self.document, &parts, order)
        });
        if let Some(robot) = &mut robot {
            lock(robot, options.locked, findings);
        }
        let tree = robot
            .as_ref()
            .zip(order)
            .and_then(|(r, order)| tree(r, order));
        let first = findings.len();
        check_links(self.places, &self.links, &inertias, tree.as_ref(), findings);
        if options.impossible {
            excuse(&mut findings[first..]);
        }
        if let Some(robot) = &robot {
            check_mimics(robot, findings);
            check_mobility(robot, findings);
        }
        robot
    }
}

fn no_link(places: Places, document: &Document) -> Diagnostic {
    Diagnostic::error(
        places.tag(document.root_element()),
        "the robot has no <link>",
    )
    .help("a robot is at least one link: write <link name=\"base\"> … </link>")
}

/// urdf-rs objects to what our checks let pass. It knows no places.
fn objection(places: Places, document: &Document, error: &str) -> Diagnostic {
    Diagnostic::error(
        places.tag(document.root_element()),
        format!("urdf-rs cannot read this robot: {}", shown(error)),
    )
}
