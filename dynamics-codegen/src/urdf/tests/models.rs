//! Our own URDFs have the figures of the published ones.

use super::read_text;
use crate::robot::Options;
use crate::robot::{Joint, JointKind, Robot};
use std::path::Path;

/// A file that must be read without a word.
fn read_silently(path: &Path) -> Robot {
    let text = std::fs::read_to_string(path).unwrap();
    let (robot, report) = read_text(
        &text,
        Options {
            snap: None,
            ..Options::default()
        },
    );
    assert_eq!(report.render(), "", "{}", path.display());
    robot.unwrap()
}

/// One of our models, and the published robot with its names mapped to ours.
fn pair(model: &str, published: &str, rename: impl Fn(&str) -> String) -> Option<[Robot; 2]> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../models");
    let ours = read_silently(&folder.join(model));
    let text = std::fs::read_to_string(left_out::shared(published)?).unwrap();
    let (theirs, report) = read_text(
        &text,
        Options {
            snap: None,
            ..Options::default()
        },
    );
    let mut theirs = theirs.unwrap_or_else(|| panic!("{report}"));
    for body in &mut theirs.bodies {
        body.link = rename(&body.link);
        if let Some(joint) = &mut body.joint {
            joint.name = rename(&joint.name);
        }
    }
    Some([ours, theirs])
}

/// What a joint says, places and losses left out.
fn facts(robot: &Robot, joint: &Joint) -> String {
    let link = |body: usize| robot.bodies[body].link.as_str();
    format!(
        "{} on {}: {:?} {:?} limits {:?} mimic {:?}",
        joint.name,
        link(joint.parent),
        joint.kind,
        joint.placement,
        joint
            .limits
            .map(|l| [l.lower, l.upper, l.effort, l.velocity]),
        joint
            .mimic
            .map(|m| (link(m.source), m.multiplier, m.offset)),
    )
}

fn assert_same_figures([ours, theirs]: &[Robot; 2]) {
    assert_eq!(ours.bodies.len(), theirs.bodies.len());
    for body in &ours.bodies {
        let other = theirs.bodies.iter().find(|b| b.link == body.link);
        let other = other.unwrap_or_else(|| panic!("no link {}", body.link));
        assert_eq!(body.inertia, other.inertia, "{}", body.link);
        let joint = body.joint.as_ref().map(|joint| facts(ours, joint));
        assert_eq!(
            joint,
            other.joint.as_ref().map(|joint| facts(theirs, joint))
        );
    }
}

fn masses(robot: &Robot) -> f64 {
    robot.bodies.iter().map(|body| body.inertia.mass).sum()
}

#[test]
fn iiwa7_has_the_figures_of_the_scenarios_and_the_names_of_their_logs() {
    let rename = |name: &str| match name.strip_prefix("lbr_iiwa_joint_") {
        Some(number) => format!("j{number}"),
        None => name.replace("lbr_iiwa_", ""),
    };
    let Some(pair) = pair("iiwa7.urdf", "data/scenarios/assets/iiwa7.urdf", rename) else {
        return;
    };
    assert_same_figures(&pair);
    let [ours, theirs] = &pair;
    for robot in [ours, theirs] {
        assert!(
            robot
                .bodies
                .iter()
                .filter_map(|b| b.joint.as_ref())
                .all(|j| j.losses.is_none())
        );
    }
    let names: Vec<_> = ours.bodies[1..]
        .iter()
        .map(|b| b.joint.as_ref().unwrap().name.as_str())
        .collect();
    assert_eq!(names, ["j1", "j2", "j3", "j4", "j5", "j6", "j7"]);
    let Some(log) = left_out::shared("data/scenarios/o03_iiwa7/test.csv") else {
        return;
    };
    let header = std::fs::read_to_string(log).unwrap();
    let columns: Vec<_> = header.lines().next().unwrap().split(',').collect();
    for name in names {
        assert!(
            columns.contains(&format!("q_{name}").as_str()),
            "{columns:?}"
        );
    }
}

#[test]
fn panda_has_the_published_figures() {
    if let Some(pair) = pair("panda.urdf", "data/urdf/panda.urdf", str::to_string) {
        assert_same_figures(&pair);
        assert_eq!(pair[0].degrees_of_freedom(), 8);
    }
}

#[test]
fn ur5_has_the_published_figures() {
    if let Some(pair) = pair("ur5.urdf", "data/urdf/ur5_robot.urdf", str::to_string) {
        assert_same_figures(&pair);
        assert_eq!(pair[0].degrees_of_freedom(), 6);
    }
}

#[test]
fn solo12_has_the_published_figures() {
    if let Some(pair) = pair("solo12.urdf", "data/urdf/solo12.urdf", str::to_string) {
        assert_same_figures(&pair);
        assert_eq!(pair[0].degrees_of_freedom(), 12);
    }
}

/// Without the shared files these sums still guard the models.
#[test]
fn the_models_are_read_without_a_word() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../models");
    for (model, bodies, moving, mass) in [
        ("iiwa7.urdf", 8, 7, 17.5),
        ("panda.urdf", 13, 9, 17.451901),
        ("solo12.urdf", 17, 12, 2.50000279),
        ("ur5.urdf", 11, 6, 20.9939),
    ] {
        let robot = read_silently(&folder.join(model));
        let joints = robot.bodies.iter().filter_map(|body| body.joint.as_ref());
        let found = joints
            .filter(|joint| joint.kind != JointKind::Fixed)
            .count();
        assert_eq!((robot.bodies.len(), found), (bodies, moving), "{model}");
        assert!(
            (masses(&robot) - mass).abs() < 1e-9,
            "{model}: {}",
            masses(&robot)
        );
    }
}
