//! What a right file is read as.

use super::{INERTIAL, arm, headlines, read_text, robot};
use crate::robot::{Inertia, JointKind, Limits, Options, Placement, Robot};
use crate::source::Sources;
use crate::urdf::read;

pub(super) const Z: &str = r#"<axis xyz="0 0 1"/>"#;

pub(super) fn close(a: f64, b: f64) {
    assert!((a - b).abs() <= 1e-14 * (1.0 + b.abs()), "{a} {b}");
}

/// The joint of the arm.
fn shoulder(kind: &str, joint: &str) -> crate::robot::Joint {
    let robot = robot(&arm(kind, INERTIAL, joint));
    robot.bodies[1].joint.clone().unwrap()
}

/// A tree whose links stand in an order of their own:
/// base ─┬─ right ── hand
///       └─ left
fn tree() -> Robot {
    let link = |name| format!("<link name=\"{name}\">{INERTIAL}</link>");
    let joint = |name, parent, child, kind| {
        format!(
            "<joint name=\"{name}\" type=\"{kind}\"><parent link=\"{parent}\"/><child link=\"{child}\"/>{Z}</joint>"
        )
    };
    robot(&format!(
        "<robot name=\"r\">{}{}{}{}{}{}{}</robot>",
        joint("z", "base", "right", "continuous"),
        link("hand"),
        link("left"),
        joint("a", "base", "left", "fixed"),
        joint("w", "right", "hand", "continuous"),
        link("base"),
        link("right"),
    ))
}

#[test]
fn bodies_stand_depth_first_in_the_order_of_the_joints() {
    let robot = tree();
    let names: Vec<_> = robot.bodies.iter().map(|b| b.link.as_str()).collect();
    assert_eq!(names, ["base", "right", "hand", "left"]);
    let parents: Vec<_> = robot
        .bodies
        .iter()
        .map(|b| b.joint.as_ref().map(|j| j.parent))
        .collect();
    assert_eq!(parents, [None, Some(0), Some(1), Some(0)]);
    assert_eq!(robot.joint("w"), Some(2));
    assert_eq!(robot.joint("nothing"), None);
    assert_eq!(robot.degrees_of_freedom(), 2);
    assert_eq!(robot.frame("left").unwrap().body, 3);
}

#[test]
fn every_joint_type_is_read() {
    let axis = [0.0, 0.0, 1.0];
    let range = r#"<limit lower="-1" upper="2" effort="3" velocity="4"/>"#;
    let both = format!("{Z}{range}");
    for (kind, expected, freedom) in [
        ("revolute", JointKind::Revolute { axis }, 1),
        ("continuous", JointKind::Revolute { axis }, 1),
        ("prismatic", JointKind::Prismatic { axis }, 1),
        ("planar", JointKind::Planar { axis }, 3),
        (
            "floating",
            JointKind::Floating {
                home: Placement::IDENTITY,
            },
            6,
        ),
        ("spherical", JointKind::Ball, 3),
        ("fixed", JointKind::Fixed, 0),
    ] {
        let joint = shoulder(kind, &both);
        assert_eq!(joint.kind, expected, "{kind}");
        assert_eq!(joint.kind.degrees_of_freedom(), freedom);
        let limits = joint.limits.map(
            |Limits {
                 lower,
                 upper,
                 effort,
                 velocity,
                 ..
             }| [lower, upper, effort, velocity],
        );
        let endless = [f64::NEG_INFINITY, f64::INFINITY, 3.0, 4.0];
        assert_eq!(
            limits,
            match kind {
                "revolute" | "prismatic" => Some([-1.0, 2.0, 3.0, 4.0]),
                "continuous" => Some(endless),
                _ => None,
            },
            "{kind}"
        );
    }
}

#[test]
fn a_right_file_gives_no_word() {
    let text = arm(
        "revolute",
        INERTIAL,
        r#"<axis xyz="0 0 1"/><limit lower="-1" upper="1" effort="1" velocity="1"/>
        <dynamics damping="0.1" friction="0.2"/><calibration rising="0"/>
        <safety_controller k_velocity="1"/>"#,
    )
    .replace("<link name=\"base\"/>", &format!("<link name=\"base\">{INERTIAL}<visual><geometry><nonsense/></geometry></visual></link><gazebo reference=\"base\"><a><b/></a></gazebo>"));
    assert_eq!(headlines(&text), [] as [&str; 0]);
}

#[test]
fn losses_are_kept() {
    let joint = shoulder(
        "continuous",
        &format!("{Z}<dynamics damping=\"0.5\" friction=\"0.25\"/>"),
    );
    let losses = joint.losses.unwrap();
    assert_eq!((losses.damping, losses.friction), (0.5, 0.25));
    let joint = shoulder("continuous", &format!("{Z}<dynamics friction=\"1\"/>"));
    assert_eq!(joint.losses.unwrap().damping, 0.0);
    assert_eq!(shoulder("continuous", Z).losses, None);
}

#[test]
fn limits_follow_the_version() {
    let partial = format!("{Z}<limit upper=\"1\"/>");
    let limits = shoulder("revolute", &partial).limits.unwrap();
    assert_eq!((limits.lower, limits.upper), (0.0, 1.0));
    assert_eq!(
        (limits.effort, limits.velocity),
        (f64::INFINITY, f64::INFINITY)
    );
    let newer =
        arm("revolute", INERTIAL, &partial).replace("name=\"r\"", "name=\"r\" version=\"1.2\"");
    let limits = robot(&newer).bodies[1]
        .joint
        .as_ref()
        .unwrap()
        .limits
        .unwrap();
    assert_eq!((limits.lower, limits.upper), (f64::NEG_INFINITY, 1.0));
}

#[test]
fn axes_are_unit_vectors() {
    let JointKind::Revolute { axis } = shoulder("continuous", "<axis xyz=\"0 3e-20 4e-20\"/>").kind
    else {
        panic!()
    };
    close(axis[1], 0.6);
    close(axis[2], 0.8);
    assert_eq!(axis[0], 0.0);
    let JointKind::Prismatic { axis } = shoulder("prismatic", "<axis xyz=\"1e-12 0 -1\"/>").kind
    else {
        panic!()
    };
    assert_eq!(axis, [0.0, 0.0, -1.0]);
}

#[test]
#[expect(clippy::approx_constant, reason = "an angle as files write it")]
fn origins_are_read_exactly_or_rounded() {
    let text = arm(
        "continuous",
        INERTIAL,
        &format!("{Z}<origin xyz=\"1 2 3\" rpy=\"1.57079632679 0 0\"/>"),
    );
    let (exact, _) = read_text(
        &text,
        Options {
            snap: None,
            ..Options::default()
        },
    );
    let exact = exact.unwrap();
    let placement = exact.bodies[1].joint.as_ref().unwrap().placement;
    assert_eq!(placement.translation, [1.0, 2.0, 3.0]);
    assert_eq!(placement.rotation[1][1], 1.57079632679_f64.cos());
    assert_eq!((exact.snapped.count, exact.snapped.tolerance), (0, 0.0));
    let rounded = robot(&text);
    let placement = rounded.bodies[1].joint.as_ref().unwrap().placement;
    assert_eq!(
        placement.rotation,
        [[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]]
    );
    assert_eq!(rounded.snapped.tolerance, 1e-9);
    // cos twice; the sine of this angle is 1 to the last bit.
    assert_eq!(rounded.snapped.count, 2);
    close(rounded.snapped.largest, 4.896619e-12);
    let (coarse, _) = read_text(
        &text.replace("1.57079632679", "1.570796"),
        Options {
            snap: Some(1e-6),
            ..Options::default()
        },
    );
    assert_eq!(
        coarse.unwrap().bodies[1]
            .joint
            .as_ref()
            .unwrap()
            .placement
            .rotation,
        placement.rotation
    );
}

#[test]
fn quaternions_are_read() {
    let s = 0.5_f64.sqrt();
    let text = arm(
        "continuous",
        INERTIAL,
        &format!("{Z}<origin quat_xyzw=\"0 {s} 0 {s}\"/>"),
    )
    .replace("name=\"r\"", "name=\"r\" version=\"1.1\"");
    let rotation = robot(&text).bodies[1]
        .joint
        .as_ref()
        .unwrap()
        .placement
        .rotation;
    assert_eq!(
        rotation,
        [[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]]
    );
}

#[test]
fn inertias_are_turned_into_the_axes_of_the_link() {
    let inertial = |rpy: &str| {
        format!(
            r#"<inertial><origin xyz="0 0 0.5" rpy="{rpy}"/><mass value="2"/>
        <inertia ixx="1" ixy="0.25" ixz="0" iyy="2" iyz="0" izz="2.5"/></inertial>"#
        )
    };
    let inertia = |rpy: &str| robot(&arm("continuous", &inertial(rpy), Z)).bodies[1].inertia;
    let plain = inertia("0 0 0");
    assert_eq!(
        plain,
        Inertia {
            mass: 2.0,
            center: [0.0, 0.0, 0.5],
            tensor: [[1.0, 0.25, 0.0], [0.25, 2.0, 0.0], [0.0, 0.0, 2.5]]
        }
    );
    // A quarter turn about z: the body's x is the link's y.
    let turned = inertia("0 0 1.5707963267948966");
    assert_eq!(turned.center, plain.center);
    assert_eq!(
        turned.tensor,
        [[2.0, -0.25, 0.0], [-0.25, 1.0, 0.0], [0.0, 0.0, 2.5]]
    );
    // A body seen along a skew axis keeps trace and determinant.
    let skew = inertia("0.3 -1.1 2").tensor;
    close(skew[0][0] + skew[1][1] + skew[2][2], 5.5);
    assert_eq!(skew[0][1], skew[1][0]);
}

#[test]
fn a_chain_of_mimics_is_followed_to_its_end() {
    let finger = |i: usize, mimic: &str| {
        format!(
            "<link name=\"l{i}\">{INERTIAL}</link><joint name=\"f{i}\" type=\"continuous\"><parent link=\"base\"/><child link=\"l{i}\"/>{Z}{mimic}</joint>"
        )
    };
    let robot = robot(&format!(
        "<robot name=\"r\"><link name=\"base\"/>{}{}{}</robot>",
        finger(0, "<mimic joint=\"f1\" multiplier=\"3\" offset=\"5\"/>"),
        finger(1, "<mimic joint=\"f2\" multiplier=\"2\" offset=\"1\"/>"),
        finger(2, "")
    ));
    let mimic = robot.bodies[1].joint.as_ref().unwrap().mimic.unwrap();
    assert_eq!(
        (mimic.source, mimic.multiplier, mimic.offset),
        (3, 6.0, 8.0)
    );
    assert_eq!(robot.degrees_of_freedom(), 1);
}

#[test]
fn a_massless_follower_is_carried_by_what_it_follows() {
    let text = |mimic: &str| {
        format!(
            "<robot name=\"r\"><link name=\"base\"/><link name=\"a\">{INERTIAL}</link><link name=\"b\"/>
            <joint name=\"ja\" type=\"continuous\"><parent link=\"base\"/><child link=\"a\"/>{Z}</joint>
            <joint name=\"jb\" type=\"continuous\"><parent link=\"base\"/><child link=\"b\"/>{Z}{mimic}</joint></robot>"
        )
    };
    assert!(
        headlines(&text(""))
            .iter()
            .any(|h| h.contains("moves nothing"))
    );
    robot(&text("<mimic joint=\"ja\"/>"));
}

#[test]
fn names_are_kept_as_they_are_and_point_at_their_place() {
    for name in [
        "x; unsafe { }",
        "*/",
        "../../etc/passwd",
        "fn",
        "größe µ",
        "a\u{202e}b",
        "a.b/c",
    ] {
        let text = arm("continuous", INERTIAL, Z).replace("\"arm\"", &format!("\"{name}\""));
        let mut sources = Sources::new();
        let id = sources.add("robot.urdf", text);
        let robot = read(&sources, id, &mut Vec::new()).unwrap();
        assert_eq!(robot.bodies[1].link, name);
        assert_eq!(sources.slice(robot.bodies[1].span), name);
        let joint = robot.bodies[1].joint.as_ref().unwrap();
        assert_eq!(sources.slice(joint.span), "shoulder");
        assert_eq!(
            sources.slice(robot.bodies[1].inertial.unwrap()),
            "<inertial>"
        );
        assert_eq!(sources.slice(robot.span), "<robot name=\"r\">");
    }
    let escaped = arm("continuous", INERTIAL, Z).replace("\"arm\"", "\"a&lt;&#98;\"");
    assert_eq!(robot(&escaped).bodies[1].link, "a<b");
}
