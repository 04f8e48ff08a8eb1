//! Fixed joints welded away.

use super::reading::{Z, close};
use super::{INERTIAL, robot};
use crate::robot::{IDENTITY, Inertia, JointKind, Placement, Robot, merge_fixed};
use std::f64::consts::{FRAC_PI_2, FRAC_PI_4};

/// base ─fixed─ plate ─continuous─ arm ─fixed─ tool ─continuous─ tip, the last
/// following the first.
fn chain() -> Robot {
    let link = |name| format!("<link name=\"{name}\">{INERTIAL}</link>");
    let joint = |name: &str, parent, child, rest: &str| {
        format!(
            "<joint name=\"{name}\" {rest}<parent link=\"{parent}\"/><child link=\"{child}\"/></joint>"
        )
    };
    let links: String = ["base", "plate", "arm", "tool", "tip"].map(link).concat();
    robot(&format!(
        "<robot name=\"r\">{links}{}{}{}{}</robot>",
        joint(
            "f1",
            "base",
            "plate",
            "type=\"fixed\"><origin xyz=\"1 0 0\" rpy=\"0 0 1.57079632679\"/>"
        ),
        joint(
            "j1",
            "plate",
            "arm",
            &format!("type=\"continuous\"><origin xyz=\"1 0 0\"/>{Z}")
        ),
        joint(
            "f2",
            "arm",
            "tool",
            &format!("type=\"fixed\"><origin xyz=\"0 0 2\" rpy=\"{FRAC_PI_4} 0 0\"/>")
        ),
        joint(
            "j2",
            "tool",
            "tip",
            &format!(
                "type=\"continuous\"><origin rpy=\"{FRAC_PI_4} 0 0\"/>{Z}<mimic joint=\"j1\" multiplier=\"-2\" offset=\"0.5\"/>"
            )
        ),
    ))
}

#[test]
fn fixed_joints_are_welded_and_their_frames_stay() {
    let robot = chain();
    let merged = merge_fixed(&robot);
    let names: Vec<_> = merged.bodies.iter().map(|b| b.link.as_str()).collect();
    assert_eq!(names, ["base", "arm", "tip"]);
    let quarter = [[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]];
    let j1 = merged.bodies[1].joint.as_ref().unwrap();
    assert_eq!((j1.name.as_str(), j1.parent), ("j1", 0));
    assert_eq!(
        j1.placement,
        Placement {
            rotation: quarter,
            translation: [1.0, 1.0, 0.0]
        }
    );
    // Two eighths of a turn make a quarter, rounded to be exactly that.
    let j2 = merged.bodies[2].joint.as_ref().unwrap();
    assert_eq!(
        j2.placement.rotation,
        [[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]]
    );
    assert_eq!(j2.placement.translation, [0.0, 0.0, 2.0]);
    let mimic = j2.mimic.unwrap();
    assert_eq!(
        (mimic.source, mimic.multiplier, mimic.offset),
        (1, -2.0, 0.5)
    );
    // Two unit bodies, 2 m apart: the reduced mass is 1/2 kg.
    assert_eq!(merged.bodies[1].inertia.mass, 2.0);
    assert_eq!(merged.bodies[1].inertia.center, [0.0, 0.0, 1.0]);
    for (i, expected) in [4.0, 4.0, 2.0].into_iter().enumerate() {
        close(merged.bodies[1].inertia.tensor[i][i], expected);
    }
    let links: Vec<_> = merged
        .frames
        .iter()
        .map(|f| (f.link.as_str(), f.body))
        .collect();
    assert_eq!(
        links,
        [
            ("base", 0),
            ("plate", 0),
            ("arm", 1),
            ("tool", 1),
            ("tip", 2)
        ]
    );
    let tool = merged.frame("tool").unwrap();
    assert_eq!(tool.placement.translation, [0.0, 0.0, 2.0]);
    close(tool.placement.rotation[1][1], FRAC_PI_4.cos());
    assert_eq!(tool.joint.as_deref(), Some("f2"));
    assert_eq!(merged.frame("base").unwrap().placement.rotation, IDENTITY);
    assert_eq!(
        merge_fixed(&merged).bodies,
        merged.bodies,
        "nothing is left to weld"
    );
    assert_eq!(merged.degrees_of_freedom(), robot.degrees_of_freedom());
}

#[test]
fn welding_keeps_what_moves() {
    // Mass and first moment at a pose of the joints do not change by welding.
    let robot = chain();
    let merged = merge_fixed(&robot);
    let moment = |robot: &Robot| {
        let mut frames: Vec<Placement> = Vec::new();
        let mut whole = Inertia::ZERO;
        for body in &robot.bodies {
            let own = body.joint.as_ref().map_or(Placement::IDENTITY, |joint| {
                let turn = match joint.kind {
                    JointKind::Revolute { .. } => FRAC_PI_2 / 3.0,
                    _ => 0.0,
                };
                let (s, c) = turn.sin_cos();
                let moved = Placement {
                    rotation: [[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]],
                    translation: [0.0; 3],
                };
                frames[joint.parent].then(&joint.placement).then(&moved)
            });
            frames.push(own);
            whole = whole.plus(&body.inertia.placed(&own));
        }
        whole
    };
    let (a, b) = (moment(&robot), moment(&merged));
    assert_eq!(a.mass, b.mass);
    for i in 0..3 {
        assert!((a.center[i] - b.center[i]).abs() < 1e-11);
        for j in 0..3 {
            assert!((a.tensor[i][j] - b.tensor[i][j]).abs() < 1e-10);
        }
    }
}

/// Mass, centre, and `ixx ixy ixz iyy iyz izz` of a welded body in a file.
fn welded(text: &str, link: &str) -> [f64; 10] {
    let merged = merge_fixed(&robot(text));
    let body = merged.bodies.iter().find(|body| body.link == link).unwrap();
    let Inertia {
        mass,
        center: [x, y, z],
        tensor: t,
    } = body.inertia;
    [
        mass, x, y, z, t[0][0], t[0][1], t[0][2], t[1][1], t[1][2], t[2][2],
    ]
}

fn assert_close(found: [f64; 10], expected: [f64; 10]) {
    for (a, b) in found.iter().zip(&expected) {
        assert!(
            (a - b).abs() < 1e-11 * expected[4],
            "{found:?} {expected:?}"
        );
    }
}

/// The expected figures come from NumPy by another road: homogeneous 4×4
/// transforms of pseudo-inertias, `P = ∫ (p, 1)(p, 1)ᵀ dm`, `P' = T P Tᵀ`.
#[test]
fn the_hand_of_the_panda_is_welded_to_its_wrist() {
    let text = include_str!("../../../../models/panda.urdf");
    assert_close(
        welded(text, "panda_link7"),
        [
            1.465522,
            0.0017561014923953397,
            0.001388201581867619,
            0.09915644298345572,
            0.01639604160286676,
            0.00039496396473184266,
            -0.0007101156156541,
            0.013973402524880914,
            -0.0010538087685085856,
            0.006675308242358676,
        ],
    );
}

#[test]
fn sixty_links_of_the_anymal_are_welded_to_its_trunk() {
    let Some(path) = left_out::shared("data/urdf/anymal_c.urdf") else {
        return;
    };
    let text = std::fs::read_to_string(path).unwrap();
    assert_close(
        welded(&text, "base"),
        [
            26.37317,
            -0.01779394314373471,
            -0.0001781696132874158,
            0.008504339015646213,
            0.21671174330797904,
            0.009223811307350827,
            0.05893318870478474,
            1.7851616886173065,
            -0.00016377801729266383,
            1.8336994495846777,
        ],
    );
}
