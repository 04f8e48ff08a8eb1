//! Tests of the reader as a whole; those of single pieces stand with them. Its figures are
//! compared with MuJoCo's in `dynamics-codegen/tests/mjcf.rs`.

mod bounds;
mod messages;
mod reading;

use super::read_with;
use crate::diagnostic::Report;
use crate::robot::{self, Options, Robot};
use crate::source::Sources;

/// Reads a text that messages call `robot.xml`, with the files that it may include.
fn read_text(text: &str, files: &[(&str, &str)], options: Options) -> (Option<Robot>, Report) {
    let mut sources = Sources::new();
    let id = sources.add("robot.xml", text);
    let mut diagnostics = Vec::new();
    let beside = |path: &str| {
        let found = files.iter().find(|(name, _)| *name == path);
        let found = found.ok_or(std::io::ErrorKind::NotFound)?;
        Ok((path.to_string(), found.1.to_string()))
    };
    let robot = read_with(&mut sources, id, options, &beside, &mut diagnostics);
    let report = Report {
        sources,
        diagnostics,
    };
    assert_eq!(robot.is_none(), report.has_errors(), "{report}");
    (robot, report)
}

/// Reads a text that must be right, warnings allowed.
fn robot(text: &str) -> Robot {
    let (robot, report) = read_text(text, &[], Options::default());
    robot.unwrap_or_else(|| panic!("{report}"))
}

/// The severities and first lines of what is found in a text, in its order.
fn headlines(text: &str) -> Vec<String> {
    robot::headlines::headlines(read_text(text, &[], Options::default()).1)
}

/// An `<inertial>` that a body can have.
const INERTIAL: &str = r#"<inertial pos="0 0 -0.1" mass="1" diaginertia="1 1 1"/>"#;

/// An arm on the world; `inner` stands in it, `outer` in front of `<worldbody>`.
fn arm(outer: &str, inner: &str) -> String {
    format!(
        r#"<mujoco>
  {outer}
  <worldbody>
    <body name="arm">
      {inner}
    </body>
  </worldbody>
</mujoco>
"#
    )
}
