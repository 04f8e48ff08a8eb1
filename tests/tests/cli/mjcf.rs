//! MuJoCo's files wherever a URDF may be given.

use crate::support::{refuse, succeed};
use integration_tests::swing::{ROD, swing};
use std::fs;
use tempfile::TempDir;

/// The rod of [`ROD`].
const SAME: &str = r#"<mujoco model="arm"><worldbody>
  <body name="rod"><joint name="j" axis="0 1 0"/>
    <inertial pos="0 0 -0.3" mass="1" diaginertia="0.02 0.02 0.01"/></body>
</worldbody></mujoco>"#;

/// The rod in both formats, and a log of it with friction.
fn folder() -> (TempDir, impl Fn(&str) -> String + use<>) {
    let folder = tempfile::tempdir().unwrap();
    let log = format!("t,q_j,u_j\n{}", swing(100, 0, 700));
    for (name, text) in [("a.urdf", ROD), ("b.xml", SAME), ("log.csv", &log)] {
        fs::write(folder.path().join(name), text).unwrap();
    }
    let place = folder.path().to_path_buf();
    (folder, move |name: &str| {
        place.join(name).to_str().unwrap().to_owned()
    })
}

#[test]
fn the_same_robot_is_the_same_in_both_formats() {
    let (_folder, path) = folder();
    let fitted = |robot: &str| succeed(&["fit", &path(robot), &path("log.csv"), "--json"], "").0;
    let as_mjcf = |text: String| text.replace("urdf \\\"a.urdf\\\"", "mjcf \\\"b.xml\\\"");
    let (urdf, mjcf) = (fitted("a.urdf"), fitted("b.xml"));
    let names = |text: String| {
        text.replace("a.urdf", "b.xml")
            .replace("a.model", "b.model")
    };
    assert_eq!(names(as_mjcf(urdf)), mjcf);
    let state = r#"{"q": [0.4], "v": [1.5], "u": [0.2]}"#;
    let told = |robot: &str| {
        let arguments = ["eval", &path(robot), "--states", "-", "--json"];
        succeed(&arguments, state).0
    };
    assert_eq!(told("a.urdf"), told("b.xml"));
}

/// What is found goes into a new model that stands on the file.
#[test]
fn what_is_found_is_written_on_top_of_it() {
    let (_folder, path) = folder();
    succeed(&["fit", &path("b.xml"), &path("log.csv"), "--apply"], "");
    let model = fs::read_to_string(path("b.model")).unwrap();
    assert!(model.starts_with("model b;\n\nmjcf \"b.xml\""), "{model}");
    assert!(model.contains("effect viscous(j)"), "{model}");
    succeed(&["check", &path("b.model")], "");
}

#[test]
fn a_mistake_has_its_place_in_the_file() {
    let (_folder, path) = folder();
    fs::write(path("b.xml"), SAME.replace("axis", "axes")).unwrap();
    let said = refuse(&["check", &path("b.xml")], "");
    assert!(said.contains("b.xml:2:36"), "{said}");
    assert!(said.contains("did you mean `axis`?"), "{said}");
    // Each format says which statement takes the other.
    for (statement, other) in [("mjcf \"a.urdf\"", "urdf"), ("urdf \"b.xml\"", "mjcf")] {
        fs::write(path("on.model"), format!("model on;\n{statement};\n")).unwrap();
        let said = refuse(&["check", &path("on.model")], "");
        assert!(said.contains(&format!("write `{other} \"…\";`")), "{said}");
    }
}
