//! Tests of the reader as a whole; those of single pieces stand with them.

mod bounds;
mod files;
mod locking;
mod messages;
mod models;
mod reading;
mod structure;
mod welding;

use super::{Options, Robot, read_with};
use crate::diagnostic::{Report, Severity};
use crate::source::Sources;
use std::path::PathBuf;

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
    let (_, report) = read_text(text, Options::default());
    let mut found = report.diagnostics;
    found.sort_by_key(|d| d.primary.span.start);
    let line = |d: &crate::Diagnostic| match d.severity {
        Severity::Error => format!("error: {}", d.message),
        Severity::Warning => format!("warning: {}", d.message),
    };
    found.iter().map(line).collect()
}

/// A file in the folder of shared data; `None` if that folder is not there,
/// which is a failure where `CI` is set.
fn shared(path: &str) -> Option<PathBuf> {
    found(path, std::env::var_os("CI").is_some())
}

fn found(path: &str, must_be_there: bool) -> Option<PathBuf> {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR"))
        .join("../../shared")
        .join(path);
    if path.exists() {
        return Some(path);
    }
    assert!(
        !must_be_there,
        "{} is missing, and CI is set",
        path.display()
    );
    println!("skipped: {} is missing", path.display());
    None
}

#[test]
#[should_panic(expected = "is missing, and CI is set")]
fn missing_data_is_a_failure_in_ci() {
    found("no/such/file", true);
}

#[test]
fn missing_data_skips_elsewhere() {
    assert_eq!(found("no/such/file", false), None);
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
