//! Joints that are locked.

use super::read_text;
use crate::robot::{JointKind, Lock, Options, Robot, merge_fixed};
use crate::source::Span;

/// Three rods; the finger follows the wrist.
fn arm(wrist: &str) -> String {
    let link = |name: &str| {
        format!(
            "<link name='{name}'><inertial><origin xyz='0.1 0.02 -0.2'/><mass value='1.5'/>
             <inertia ixx='0.02' ixy='0.001' ixz='0' iyy='0.03' iyz='0' izz='0.025'/></inertial></link>"
        )
    };
    format!(
        "<robot name='arm'><link name='base'/>{}{}{}
         <joint name='shoulder' type='continuous'><parent link='base'/><child link='upper'/>
           <origin xyz='0 0 0.3' rpy='0.1 0 0'/><axis xyz='0 1 0'/></joint>
         {wrist}
         <joint name='finger' type='prismatic'><parent link='hand'/><child link='tip'/>
           <origin xyz='0 0.05 0'/><axis xyz='1 0 0'/>
           <limit lower='0' upper='1' effort='1' velocity='1'/>
           <mimic joint='wrist' multiplier='0.5' offset='0.01'/></joint></robot>",
        link("upper"),
        link("hand"),
        link("tip")
    )
}

const MOVES: &str =
    "<joint name='wrist' type='continuous'><parent link='upper'/><child link='hand'/>
    <origin xyz='0 0 0.4' rpy='0 0 0.2'/><axis xyz='0 0 1'/></joint>";

fn locked(joint: &str, at: f64) -> Lock {
    Lock {
        joint: joint.into(),
        at,
        span: Span {
            source: crate::source::Sources::new().add("model", ""),
            start: 0,
            end: 0,
        },
    }
}

fn read(text: &str, locks: &[Lock]) -> Result<Robot, String> {
    let options = Options {
        locked: locks,
        ..Options::default()
    };
    let (robot, report) = read_text(text, options);
    robot.ok_or_else(|| {
        report
            .diagnostics
            .iter()
            .map(|d| d.message.clone())
            .collect()
    })
}

/// The same as a fixed joint that was turned there in the file.
#[test]
fn a_locked_joint_is_a_fixed_one() {
    let text = arm(MOVES);
    let robot = merge_fixed(&read(&text, &[locked("wrist", 0.3)]).unwrap());
    let fixed = MOVES
        .replace("continuous", "fixed")
        .replace("0 0 0.2", "0 0 0.5")
        .replace("<axis xyz='0 0 1'/>", "");
    let fixed = arm(&fixed)
        .replace("prismatic", "fixed")
        .replace("xyz='0 0.05 0'", "xyz='0.16 0.05 0'");
    let cut = fixed.find("<axis xyz='1 0 0'/>").unwrap();
    let fixed = format!("{}</joint></robot>", &fixed[..cut]);
    let expected = merge_fixed(&read(&fixed, &[]).unwrap());
    assert_eq!((robot.bodies.len(), expected.bodies.len()), (2, 2));
    let [own, theirs] = [&robot, &expected].map(|robot| robot.bodies[1].inertia);
    assert!((own.mass - theirs.mass).abs() < 1e-12);
    for i in 0..3 {
        assert!((own.center[i] - theirs.center[i]).abs() < 1e-12, "{own:?}");
        for j in 0..3 {
            let off = own.tensor[i][j] - theirs.tensor[i][j];
            assert!(off.abs() < 1e-12, "{own:?} {theirs:?}");
        }
    }
}

#[test]
fn what_follows_a_locked_joint_stands_still() {
    let robot = read(&arm(MOVES), &[locked("wrist", 0.0)]).unwrap();
    let joints = robot.bodies.iter().filter_map(|body| body.joint.as_ref());
    let kinds: Vec<JointKind> = joints.map(|joint| joint.kind).collect();
    assert!(matches!(kinds[0], JointKind::Revolute { .. }));
    assert_eq!(kinds[1..], [JointKind::Fixed, JointKind::Fixed]);
    let tip = robot.bodies[3].joint.as_ref().unwrap();
    assert_eq!(tip.placement.translation, [0.01, 0.05, 0.0]);
}

#[test]
fn what_cannot_be_locked_is_said() {
    let text = arm(MOVES);
    let cases = [
        (vec![locked("finger", 0.0)], "follows another joint"),
        (vec![locked("wirst", 0.0)], "no joint named `wirst`"),
        (
            vec![locked("wrist", 0.0), locked("wrist", 1.0)],
            "locked twice",
        ),
    ];
    for (locks, expected) in cases {
        let said = read(&text, &locks).unwrap_err();
        assert!(said.contains(expected), "{said}");
    }
    let fixed = arm(&MOVES.replace("continuous", "fixed"));
    let said = read(&fixed, &[locked("wrist", 0.0)]).unwrap_err();
    assert!(said.contains("it is fixed"), "{said}");
}

/// A tensor that no body has: refused, or used as it stands where that is asked for.
#[test]
fn impossible_inertias_can_be_used_as_they_stand() {
    let text = arm(MOVES).replace("izz='0.025'", "izz='0.9'");
    assert!(read(&text, &[]).unwrap_err().contains("no body has this"));
    let options = Options {
        impossible: true,
        ..Options::default()
    };
    let (robot, report) = read_text(&text, options);
    assert_eq!(robot.unwrap().bodies[1].inertia.tensor[2][2], 0.9);
    let said = format!("{report}");
    assert!(said.contains("used as they stand"), "{said}");
}
