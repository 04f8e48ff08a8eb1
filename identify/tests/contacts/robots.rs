//! Many contacts at once: a quadruped that is dropped.

use crate::case::Case;

/// How a body may float: by the rates of its seven coordinates, and by its twist.
pub const VELOCITIES: [&str; 2] = ["rates", "twist"];

/// A quadruped of twelve joints on its feet, with springs and dampers for motors, that floats by one of
/// [`VELOCITIES`].
pub fn quadruped(velocities: &str) -> Case {
    Case::new(&text(velocities))
}

/// The same that may land on its back, its hips and its knees, too.
pub fn tumbling(velocities: &str) -> Case {
    let mut text = text(velocities);
    for leg in ["FL", "FR", "HL", "HR"] {
        text += &format!(
            "contact knee_{leg}: sphere({leg}_LOWER_LEG, 0.02) on plane_z(world) {{ friction: 0.8; }}\n"
        );
    }
    for corner in 0..8 {
        let side = |bit: usize, half: f64| if corner & bit == 0 { half } else { -half };
        let (x, y, z) = (side(1, 0.2), side(2, 0.1), side(4, 0.03));
        text += &format!(
            "contact base_{corner}: point(base_link * translate({x}, {y}, {z})) on plane_z(world) {{ friction: 0.5; }}\n"
        );
    }
    Case::new(&text)
}

fn text(velocities: &str) -> String {
    let mut text = format!(
        "
        model standing;
        urdf \"solo12.urdf\" {{ base: floating; velocities: {velocities}; inputs: none; }}
        constant stiff: N*m = 15;
        constant slow: N*m*s = 0.3;
    "
    );
    for leg in ["FL", "FR", "HL", "HR"] {
        let back = if leg.starts_with('H') { -1.0 } else { 1.0 };
        for (joint, rest) in [("HAA", 0.0), ("HFE", 0.7 * back), ("KFE", -1.4 * back)] {
            text += &format!(
                "potential stiff/2*({leg}_{joint} - ({rest}))^2;\nforce {leg}_{joint} = -slow*dot({leg}_{joint});\n"
            );
        }
        text += &format!(
            "contact foot_{leg}: sphere({leg}_FOOT, 0.016) on plane_z(world) {{ friction: 0.8; }}\n"
        );
    }
    text
}

/// Where it is dropped from.
pub fn in_the_air(case: &Case) -> Vec<f64> {
    let positions = case.machine.compiled.model.positions();
    let start = |name: &str| match name {
        "base_link_z" => 0.35,
        "base_link_qw" => 1.0,
        _ => {
            let back = if name.starts_with('H') { -1.0 } else { 1.0 };
            match name.split_once('_') {
                Some((_, "HFE")) => 0.7 * back,
                Some((_, "KFE")) => -1.4 * back,
                _ => 0.0,
            }
        }
    };
    positions.iter().map(|q| start(&q.name)).collect()
}

#[test]
fn a_quadruped_lands_on_its_feet_and_stands() {
    VELOCITIES.into_iter().for_each(lands_and_stands);
}

fn lands_and_stands(velocities: &str) {
    let case = quadruped(velocities);
    let q = in_the_air(&case);
    let v = vec![0.0; case.machine.coordinate_count()];
    let mut lowest = 0.0_f64;
    let end = case.run((&q, &v), 1e-3, 3000, |t, q, v, _| {
        lowest = lowest.min(case.contacts(t, q, v).gap.min());
    });
    assert!(lowest > -1e-6, "{lowest:e} m inside");
    let contacts = case.contacts(0.0, &end.q, &end.v);
    assert!(contacts.gap.amax() < 1e-6, "feet at {}", contacts.gap);
    assert!(end.v.iter().all(|v| v.abs() < 1e-3), "moves: {:?}", end.v);
    let states = case.states(0.0, &end.q, &end.v);
    let pressed = case
        .machine
        .pressed(&states, &case.parameters)
        .unwrap()
        .remove(0);
    let carried: f64 = (0..4).map(|i| pressed.force[3 * i + 2]).sum();
    let masses = case
        .machine
        .terms(&states, &case.parameters)
        .remove(0)
        .mass_matrix;
    assert!(
        (carried - 9.81 * masses[(0, 0)]).abs() < 0.05,
        "carries {carried} N"
    );
    assert!(end.sweeps < 3000 * 200, "{} sweeps", end.sweeps);
}
