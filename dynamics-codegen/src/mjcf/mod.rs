//! MJCF, MuJoCo's own format: from the text of a description to a [`Robot`].
//!
//! ```text
//! text ──document──▶ elements ──schema──▶ settings, classes ──tree──▶ Robot
//!        (includes)                       (compiler, defaults)  (pose, joint, inertia, actuator)
//! ```
//!
//! Read are the bodies with their joints and inertias (stated, or of geoms as MuJoCo computes
//! them), damping, dry friction, armature and springs of joints, gravity, and what actuators
//! drive by which gear. Everything else is ignored, and one warning says what that was.
//!
//! A coordinate is MuJoCo's `qpos`: a hinge's angle and a slide's displacement count from
//! `ref`, a free joint's pose is that in the world. A body with several joints becomes as many
//! bodies, all but the last without a mass; so does one whose joint is anchored beside its
//! origin. These have no names.
//!
//! Errors: text that is no XML or no MJCF, files that cannot be included, misspelt elements and
//! attributes, values that are not what they must be, names that are doubled or point nowhere,
//! joints that cannot be expressed (`ball`), inertias that no body can have or that only a mesh
//! knows, elements that write bodies by themselves (`<replicate>`), and joints that move nothing.

mod actuator;
mod defaults;
mod document;
mod equality;
mod geom;
mod ignored;
mod inertia;
mod joint;
mod naming;
mod pose;
mod reader;
mod schema;
mod settings;
#[cfg(test)]
mod tests;
mod tree;

pub use document::Beside;

use crate::diagnostic::{Diagnostic, Severity};
use crate::robot::{Format, Options, Robot, check_mobility, lock, shorten};
use crate::source::{SourceId, Sources};
use document::{Element, Files};
use reader::Reader;

/// Reads an MJCF that includes no others, with the default [`Options`].
///
/// What is wrong or worth knowing is added to `diagnostics`; the result is
/// `None` if any of it is an error.
///
/// ```
/// use dynamics_codegen::mjcf;
/// use dynamics_codegen::source::Sources;
///
/// let mut sources = Sources::new();
/// let id = sources.add("pendulum.xml", r#"
///     <mujoco model="pendulum">
///       <worldbody>
///         <body name="rod">
///           <joint name="hinge" axis="0 1 0"/>
///           <inertial pos="0 0 -0.5" mass="2" diaginertia="0.1 0.1 0.001"/>
///         </body>
///       </worldbody>
///     </mujoco>"#);
/// let mut diagnostics = Vec::new();
/// let robot = mjcf::read(&mut sources, id, &mut diagnostics).unwrap();
/// assert_eq!(robot.bodies[1].link, "rod");
/// assert_eq!(robot.bodies[1].inertia.mass, 2.0);
/// assert!(diagnostics.is_empty());
/// ```
pub fn read(
    sources: &mut Sources,
    id: SourceId,
    diagnostics: &mut Vec<Diagnostic>,
) -> Option<Robot> {
    let alone = |_: &str| Err(std::io::ErrorKind::NotFound.into());
    read_with(sources, id, Options::default(), &alone, diagnostics)
}

/// Reads an MJCF. As [`read`], with options and the files that it may include; those that it
/// does are added to `sources`.
pub fn read_with(
    sources: &mut Sources,
    id: SourceId,
    options: Options<'_>,
    beside: &Beside<'_>,
    diagnostics: &mut Vec<Diagnostic>,
) -> Option<Robot> {
    let mut findings = Vec::new();
    let included = document::load(sources, id, beside, &mut findings);
    let robot = match Files::parse(sources, id, &included) {
        Err(error) => {
            // An included file that is no XML says so here, and need not do so twice.
            findings = vec![*error];
            None
        }
        Ok(files) => read_files(&files, options, &mut findings),
    };
    let robot = robot.map(|mut robot| {
        let named = included.into_iter().map(|file| (file.path, file.source));
        robot.included = named.collect();
        robot
    });
    let failed = findings.iter().any(|f| f.severity == Severity::Error);
    diagnostics.extend(shorten(findings));
    robot.filter(|_| !failed)
}

fn read_files(
    files: &Files<'_>,
    options: Options<'_>,
    findings: &mut Vec<Diagnostic>,
) -> Option<Robot> {
    let root = files.root();
    is_mjcf(root).map_err(|error| findings.push(*error)).ok()?;
    let mut reader = Reader::new(files, options, findings);
    let mut robot = tree::read(&mut reader, root);
    reader.report_ignored();
    lock(&mut robot, options.locked, findings);
    if findings.iter().all(|f| f.severity == Severity::Warning) {
        check_mobility(&robot, findings);
    }
    Some(robot)
}

/// Whether the document is an MJCF at all.
fn is_mjcf(root: Element) -> Result<(), Box<Diagnostic>> {
    let help = match root.name() {
        "mujoco" => return Ok(()),
        "robot" => "this is a URDF: write `urdf \"…\";` in place of `mjcf \"…\";`",
        "mujocoinclude" => "this is part of an MJCF: take the file that includes it",
        _ => Format::Mjcf.shape(),
    };
    let name = crate::robot::text::shown(root.name());
    let message = format!("the outermost element is <{name}>, not <mujoco>");
    Err(Diagnostic::error(root.tag(), message).help(help).into())
}
