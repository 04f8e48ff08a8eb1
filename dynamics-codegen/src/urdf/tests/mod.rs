//! Tests of the reader as a whole; those of single pieces stand with them.

mod bounds;
mod files;
mod locking;
mod messages;
mod models;
mod reading;
mod structure;
mod welding;

use super::read_with;
use crate::diagnostic::Report;
use crate::robot::{self, Options, Robot};
use crate::source::Sources;

/// Reads a text that messages call `robot.urdf`.
fn read_text(text: &str, options: Options) -> (Option<Robot>, Report) {
    let mut sources = Sources::new();
    let id = sources.add("robot.urdf", text);
    let mut diagnostics = Vec::new();
    let robot = read_with(&sources, id, options, &mut diagnostics);
    let report = Report {
        sources,
        diagnostics,
    };
    assert_eq!(robot.is_none(), report.has_errors(), "{report}");
    (robot, report)
}

/// Reads a text that must be right, warnings allowed.
fn robot(text: &str) -> Robot {
    let (robot, report) = read_text(text, Options::default());
    robot.unwrap_or_else(|| panic!("{report}"))
}

/// The severities and first lines of what is found in a text, in its order.
fn headlines(text: &str) -> Vec<String> {
    robot::headlines::headlines(read_text(text, Options::default()).1)
}

/// An `<inertial>` that a body can have.
const INERTIAL: &str = r#"<inertial>
      <mass value="1"/>
      <inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/>
    </inertial>"#;

/// A base and an arm on a joint; `link` stands in the arm, `joint` in the joint.
fn arm(kind: &str, link: &str, joint: &str) -> String {
    format!(
        r#"<robot name="r">
  <link name="base"/>
  <link name="arm">
    {link}
  </link>
  <joint name="shoulder" type="{kind}">
    <parent link="base"/>
    <child link="arm"/>
    {joint}
  </joint>
</robot>
"#
    )
}
