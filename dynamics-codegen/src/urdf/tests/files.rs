//! Published robots, read where they are.

use super::read_text;
use crate::diagnostic::{Report, Severity};
use crate::robot::Options;
use crate::robot::{Robot, merge_fixed};

fn read_shared(path: &str) -> Option<(Option<Robot>, Report)> {
    let text = std::fs::read_to_string(left_out::shared(path)?).unwrap();
    Some(read_text(&text, Options::default()))
}

/// File, links, bodies after welding, velocities.
const ROBOTS: [(&str, usize, usize, usize); 12] = [
    ("anymal_c", 78, 13, 12),
    ("cartpole", 3, 3, 2),
    ("double_pendulum_ltd", 3, 3, 2),
    ("double_pendulum_simple", 4, 3, 2),
    ("iiwa7", 9, 8, 7),
    ("kuka_iiwa14_pybullet", 8, 8, 7),
    ("panda", 13, 10, 8),
    ("solo12", 17, 13, 12),
    ("trifinger_edu", 17, 10, 9),
    ("two_link_robot", 4, 3, 2),
    ("ur10_robot", 11, 7, 6),
    ("ur5_robot", 11, 7, 6),
];

#[test]
fn every_robot_is_read() {
    let Some(folder) = left_out::shared("data/urdf") else {
        return;
    };
    let mut count = 0;
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_none_or(|e| e != "urdf") {
            continue;
        }
        let stem = path.file_stem().unwrap().to_str().unwrap();
        let (robot, report) = read_shared(&format!("data/urdf/{stem}.urdf")).unwrap();
        let robot = robot.unwrap_or_else(|| panic!("{stem}\n{report}"));
        let merged = merge_fixed(&robot);
        let found = (
            stem,
            robot.bodies.len(),
            merged.bodies.len(),
            robot.degrees_of_freedom(),
        );
        assert!(ROBOTS.contains(&found), "{found:?}");
        let mass = |robot: &Robot| robot.bodies.iter().map(|b| b.inertia.mass).sum::<f64>();
        assert!((mass(&robot) - mass(&merged)).abs() < 1e-12 * mass(&robot));
        count += 1;
    }
    assert_eq!(count, ROBOTS.len());
}

/// What is said about a published file, without the places (they stand in the
/// file, which is not ours to copy).
fn remarks(report: &Report) -> String {
    let mut found: Vec<_> = report.diagnostics.iter().collect();
    found.sort_by_key(|d| d.primary.span.start);
    let line = |d: &&crate::Diagnostic| {
        let (row, column) = report.sources.line_column(d.primary.span);
        let severity = match d.severity {
            Severity::Error => "error",
            Severity::Warning => "warning",
        };
        format!("{row}:{column}: {severity}: {}", d.message)
    };
    found.iter().map(line).collect::<Vec<_>>().join("\n")
}

#[test]
fn published_robots_get_their_remarks() {
    for (stem, ..) in ROBOTS {
        let Some((_, report)) = read_shared(&format!("data/urdf/{stem}.urdf")) else {
            return;
        };
        insta::with_settings!({ omit_expression => true, prepend_module_to_snapshot => false }, {
            insta::assert_snapshot!(format!("remarks_{stem}"), remarks(&report));
        });
    }
}

#[test]
fn robots_on_an_undeclared_link_are_refused_with_the_place() {
    for (file, line, link) in [
        ("acromonk.urdf", 11, "world"),
        ("dfki_double_pendulum_C1_model1.0.urdf", 3, "world"),
    ] {
        let Some((robot, report)) = read_shared(&format!("data/urdf/reject/{file}")) else {
            return;
        };
        assert!(robot.is_none());
        let errors: Vec<_> = report
            .diagnostics
            .iter()
            .filter(|d| d.severity == Severity::Error)
            .collect();
        assert_eq!(errors.len(), 1, "{report}");
        assert_eq!(
            errors[0].message,
            format!("joint `base_weld`: its parent link `{link}` is not declared")
        );
        let span = errors[0].primary.span;
        assert_eq!(
            (
                report.sources.line_column(span).0,
                report.sources.slice(span)
            ),
            (line, link)
        );
    }
}

/// The joints as Pinocchio lists them: placement, mass, centre, tensor.
#[test]
fn placements_and_inertias_are_those_of_pinocchio() {
    for (model, oracle, snap) in [
        ("oracles/iiwa.urdf", "oracles/oracle_iiwa.json", None),
        (
            "oracles/iiwa.urdf",
            "oracles/oracle_iiwa_snap.json",
            Some(1e-9),
        ),
        (
            "oracles/cartpole.urdf",
            "oracles/oracle_cartpole.json",
            None,
        ),
        (
            "oracles/double_pendulum.urdf",
            "oracles/oracle_double_pendulum.json",
            None,
        ),
    ] {
        let (Some(model), Some(oracle)) = (left_out::shared(model), left_out::shared(oracle))
        else {
            return;
        };
        let text = std::fs::read_to_string(model).unwrap();
        let (robot, report) = read_text(
            &text,
            Options {
                snap,
                ..Options::default()
            },
        );
        let robot = merge_fixed(&robot.unwrap_or_else(|| panic!("{report}")));
        let oracle = std::fs::read_to_string(oracle).unwrap();
        let mut joints = Joints(&oracle[oracle.find("\"joints\"").unwrap()..]);
        for body in &robot.bodies[1..] {
            let joint = body.joint.as_ref().unwrap();
            assert_eq!(joints.text("name"), joint.name);
            let mut expected = joints.numbers("R", 9);
            expected.extend(joints.numbers("p", 3));
            expected.extend(joints.numbers("mass", 1));
            expected.extend(joints.numbers("com", 3));
            expected.extend(joints.numbers("Icom", 9));
            let mut found = joint.placement.rotation.as_flattened().to_vec();
            found.extend(joint.placement.translation);
            found.push(body.inertia.mass);
            found.extend(body.inertia.center);
            found.extend(body.inertia.tensor.as_flattened());
            for (a, b) in found.iter().zip(&expected) {
                assert!(
                    (a - b).abs() < 1e-15 * (1.0 + b.abs()),
                    "{}: {found:?} {expected:?}",
                    joint.name
                );
            }
        }
    }
}

/// Reads the few fields needed out of the oracle's JSON, in their order.
struct Joints<'a>(&'a str);

impl Joints<'_> {
    fn after(&mut self, key: &str) {
        let key = format!("\"{key}\":");
        let at = self.0.find(&key).unwrap_or_else(|| panic!("no {key}"));
        self.0 = self.0[at + key.len()..].trim_start();
    }

    fn text(&mut self, key: &str) -> String {
        self.after(key);
        self.0[1..].split('"').next().unwrap().to_string()
    }

    fn numbers(&mut self, key: &str, count: usize) -> Vec<f64> {
        self.after(key);
        let words = self
            .0
            .split([',', '[', ']', ' ', '}'])
            .filter(|w| !w.is_empty());
        words.take(count).map(|w| w.parse().unwrap()).collect()
    }
}
