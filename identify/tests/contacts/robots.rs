//! Many contacts at once: a quadruped that is dropped.

use crate::case::Case;

/// A quadruped of twelve joints on its feet, with springs and dampers for motors.
pub fn quadruped() -> Case {
    Case::new(&text())
}

/// The same that may land on its back, its hips and its knees, too.
pub fn tumbling() -> Case {
    let mut text = text();
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

fn text() -> String {
    let mut text = "
        model standing;
        urdf \"solo12.urdf\" { base: floating; inputs: none; }
        constant stiff: N*m = 15;
        constant slow: N*m*s = 0.3;
    "
    .to_string();
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
    let coordinates = &case.machine.compiled.model.coordinates;
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
    coordinates.iter().map(|c| start(&c.name)).collect()
}

#[test]
fn a_quadruped_lands_on_its_feet_and_stands() {
    let case = quadruped();
    let q = in_the_air(&case);
    let v = vec![0.0; q.len()];
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
