//! What is read, against what the text says.

use super::{INERTIAL, arm, headlines, read_text, robot};
use crate::robot::{JointKind, Options, Placement, Robot};
use proptest::prelude::*;

fn joint_names(robot: &Robot) -> Vec<&str> {
    let joints = robot.bodies.iter().filter_map(|body| body.joint.as_ref());
    joints.map(|joint| joint.name.as_str()).collect()
}

fn links(robot: &Robot) -> Vec<&str> {
    robot.bodies.iter().map(|body| body.link.as_str()).collect()
}

#[test]
fn what_has_no_name_is_called_after_its_body() {
    let text = format!(
        "<mujoco><worldbody>
           <body><joint/><joint axis=\"1 0 0\"/>{INERTIAL}<body>{INERTIAL}</body></body>
           <body name=\"ball\"><freejoint/>{INERTIAL}</body>
         </worldbody></mujoco>"
    );
    let robot = robot(&text);
    assert_eq!(links(&robot), ["world", "", "body", "body_2", "ball"]);
    // The weld has its body's name.
    let names = ["body", "body_2", "", "ball"];
    assert_eq!(joint_names(&robot)[..2], names[..2]);
    assert_eq!(joint_names(&robot)[3], "ball");
    assert_eq!(robot.degrees_of_freedom(), 8);
    assert_eq!(robot.frames.len(), 4);
}

#[test]
fn an_anchor_beside_the_origin_takes_a_weld() {
    let beside = robot(&arm(
        "",
        &format!("<joint name=\"j\" pos=\"0 0 0.3\"/>{INERTIAL}"),
    ));
    assert_eq!(links(&beside), ["world", "", "arm"]);
    let hinge = beside.bodies[1].joint.as_ref().unwrap();
    assert_eq!(hinge.placement.translation, [0.0, 0.0, 0.3]);
    let weld = beside.bodies[2].joint.as_ref().unwrap();
    assert_eq!((weld.name.as_str(), weld.kind), ("", JointKind::Fixed));
    assert_eq!(weld.placement.translation, [0.0, 0.0, -0.3]);
    let at_origin = robot(&arm("", &format!("<joint name=\"j\"/>{INERTIAL}")));
    assert_eq!(links(&at_origin), ["world", "arm"]);
}

#[test]
fn a_free_joint_counts_from_the_world() {
    let text = "<mujoco><worldbody><body name=\"b\" pos=\"1 2 3\"><freejoint name=\"f\"/><geom size=\"0.1\"/></body></worldbody></mujoco>";
    let robot = robot(text);
    let joint = robot.bodies[1].joint.as_ref().unwrap();
    assert_eq!(joint.placement, Placement::IDENTITY);
    let JointKind::Floating { home } = joint.kind else {
        panic!("{joint:?}")
    };
    assert_eq!(home.translation, [1.0, 2.0, 3.0]);
}

#[test]
fn gravity_is_the_options_unless_it_is_switched_off() {
    let of = |option: &str| {
        let robot = robot(&arm(option, &format!("<joint/>{INERTIAL}")));
        robot.gravity.unwrap()
    };
    assert_eq!(of(""), [0.0, 0.0, -9.81]);
    assert_eq!(of("<option gravity=\"1 2 3\"/>"), [1.0, 2.0, 3.0]);
    let off = "<option gravity=\"1 2 3\"><flag gravity=\"disable\"/></option>";
    assert_eq!(of(off), [0.0; 3]);
}

#[test]
fn a_class_has_what_its_parent_had_when_it_was_read() {
    let of = |defaults: &str| {
        let text = arm(defaults, &format!("<joint class=\"leg\"/>{INERTIAL}"));
        robot(&text).bodies[1].joint.as_ref().unwrap().armature
    };
    let leg = "<default><default class=\"leg\"/></default>";
    let main = "<default><joint armature=\"3\"/></default>";
    assert_eq!(of(&format!("{main}{leg}")), 3.0);
    assert_eq!(of(&format!("{leg}{main}")), 0.0);
    let both = "<default><default class=\"leg\"/><joint armature=\"3\"/></default>";
    assert_eq!(of(both), 3.0);
}

#[test]
fn geoms_are_inertias_where_the_file_says_so() {
    let of = |compiler: &str| {
        let inner =
            format!("<joint/>{INERTIAL}<geom type=\"box\" size=\"0.5 0.5 0.5\" mass=\"7\"/>");
        let robot = robot(&arm(compiler, &inner));
        robot.bodies[1].inertia.mass
    };
    assert_eq!(of(""), 1.0);
    assert_eq!(of("<compiler inertiafromgeom=\"true\"/>"), 7.0);
    // Without any inertia nothing moves.
    let text = arm(
        "<compiler inertiafromgeom=\"false\"/>",
        "<joint name=\"j\"/><geom size=\"1\"/>",
    );
    assert_eq!(
        headlines(&text)[0],
        "error: joint `j` moves nothing that has inertia about its axis"
    );
}

/// A rotor's inertia is something to move.
#[test]
fn armature_alone_can_be_moved() {
    let robot = robot(&arm("", "<joint name=\"j\" armature=\"0.1\"/>"));
    assert_eq!(robot.bodies[1].joint.as_ref().unwrap().armature, 0.1);
}

#[test]
fn what_stands_on_the_world_needs_no_inertia() {
    let text = "<mujoco><worldbody><body name=\"table\"><geom type=\"mesh\" mesh=\"table\"/></body><body><joint/><geom size=\"0.1\"/></body></worldbody></mujoco>";
    assert_eq!(headlines(text), ["warning: ignored in this MJCF: <geom>"]);
}

#[test]
fn an_impossible_inertia_is_used_if_the_model_says_so() {
    let text = arm(
        "",
        "<joint/><inertial pos=\"0 0 0\" mass=\"1\" diaginertia=\"1 1 3\"/>",
    );
    let options = Options {
        impossible: true,
        ..Options::default()
    };
    let (robot, _) = read_text(&text, &[], options);
    assert_eq!(robot.unwrap().bodies[1].inertia.tensor[2][2], 3.0);
    let balanced = text.replace("<mujoco>", "<mujoco><compiler balanceinertia=\"true\"/>");
    let (robot, _) = read_text(&balanced, &[], Options::default());
    let tensor = robot.unwrap().bodies[1].inertia.tensor;
    assert!((tensor[2][2] - 5.0 / 3.0).abs() < 1e-15, "{tensor:?}");
}

#[test]
fn what_is_included_stands_where_the_include_does() {
    let text = "<mujoco><include file=\"a.xml\"/><worldbody><include file=\"b.xml\"/><body name=\"last\"><joint name=\"l\"/><geom size=\"0.1\"/></body></worldbody></mujoco>";
    let files = [
        (
            "a.xml",
            "<x><compiler angle=\"radian\"/><include file=\"c.xml\"/></x>",
        ),
        (
            "b.xml",
            "<x><body name=\"first\"><joint name=\"f\" ref=\"1\" axis=\"1 0 0\"/><geom size=\"0.1\"/></body></x>",
        ),
        ("c.xml", "<x><default><geom density=\"10\"/></default></x>"),
    ];
    let (robot, report) = read_text(text, &files, Options::default());
    let robot = robot.unwrap_or_else(|| panic!("{report}"));
    assert_eq!(links(&robot), ["world", "first", "last"]);
    let ball = 4.0 / 3.0 * std::f64::consts::PI * 1e-3 * 10.0;
    assert!((robot.bodies[1].inertia.mass - ball).abs() < 1e-15);
    // An angle in rad.
    let rotation = robot.bodies[1].joint.as_ref().unwrap().placement.rotation;
    assert!((rotation[1][1] - 1.0_f64.cos()).abs() < 1e-15);
    let included: Vec<&str> = robot
        .included
        .iter()
        .map(|(path, _)| path.as_str())
        .collect();
    assert_eq!(included, ["a.xml", "b.xml", "c.xml"]);
}

/// What is the same without the places in the text.
fn figures(robot: &Robot) -> Vec<f64> {
    let mut all = Vec::new();
    for body in &robot.bodies {
        all.push(body.inertia.mass);
        all.extend(body.inertia.center);
        all.extend(body.inertia.tensor.as_flattened());
        let Some(joint) = &body.joint else { continue };
        all.extend(joint.placement.translation);
        all.extend(joint.placement.rotation.as_flattened());
        all.extend(joint.kind.axis().into_iter().flatten());
        all.push(joint.armature);
        all.extend(joint.losses.map(|losses| losses.damping));
        all.extend(joint.spring.map(|spring| spring.rest));
    }
    all
}

/// Pieces of a class, in any order.
const DEFAULTS: [&str; 5] = [
    "<joint axis=\"0 1 0\" damping=\"0.5\"/>",
    "<geom type=\"box\" size=\"0.1 0.2 0.3\"/>",
    "<default class=\"a\"><joint armature=\"0.1\"/><geom density=\"300\"/></default>",
    "<default class=\"b\"><default class=\"c\"><joint stiffness=\"2\" springref=\"20\"/></default></default>",
    "<motor gear=\"3\"/>",
];

proptest! {
    /// The order of the defaults within a section means nothing.
    #[test]
    fn permuted_defaults_give_the_same(order in Just(DEFAULTS).prop_shuffle()) {
        let read = |defaults: [&str; 5]| {
            let outer = format!("<default>{}</default>", defaults.concat());
            let inner = "<joint/><geom/><body childclass=\"a\" pos=\"0 0 1\"><joint/><geom/><body childclass=\"c\"><joint/><geom/></body></body>";
            figures(&robot(&arm(&outer, inner)))
        };
        prop_assert_eq!(read(order), read(DEFAULTS));
    }

    /// A rotation is the same however it is written: as a quaternion, by axis and angle in either
    /// unit, or by the axes.
    #[test]
    fn a_rotation_is_the_same_in_all_ways(axis in prop::array::uniform3(-1.0..1.0), angle in -3.0..3.0) {
        let (axis, angle): ([f64; 3], f64) = (axis, angle);
        prop_assume!(axis.iter().map(|x| x * x).sum::<f64>() > 0.01);
        let [x, y, z] = crate::mjcf::pose::unit(axis);
        let (s, c) = (0.5 * angle).sin_cos();
        let r = crate::robot::spatial::rotation_about([x, y, z], angle);
        let ways = [
            format!("quat=\"{c} {} {} {}\"", s * x, s * y, s * z),
            format!("axisangle=\"{x} {y} {z} {}\"", angle.to_degrees()),
            format!("xyaxes=\"{} {} {} {} {} {}\"", r[0][0], r[1][0], r[2][0], r[0][1], r[1][1], r[2][1]),
        ];
        for way in ways {
            let text = arm("", &format!("<body name=\"hand\" {way}><joint/>{INERTIAL}</body>"));
            let robot = robot(&text);
            let found = robot.bodies[2].joint.as_ref().unwrap().placement.rotation;
            for (a, b) in found.as_flattened().iter().zip(r.as_flattened()) {
                prop_assert!((a - b).abs() < 1e-8, "{} {:?} {:?}", way, found, r);
            }
        }
    }
}
