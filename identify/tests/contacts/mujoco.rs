//! The same machines as MuJoCo moves them (`tests/mujoco/contacts.py`).
//!
//! MuJoCo's contacts are soft, ours are rigid. They differ by how far it sinks in and creeps, and where
//! the laws leave forces open: how a box spreads its weight over four corners decides how friction
//! turns it.

use crate::case::Case;
use crate::robots::{VELOCITIES, in_the_air, quadruped};
use serde_json::Value;

const FIGURES: &str = include_str!("../../../tests/mujoco/contacts.json");

/// Rows of a time and what is seen then.
fn rows(name: &str) -> Vec<Vec<f64>> {
    let figures: Value = serde_json::from_str(FIGURES).unwrap();
    let rows = figures[name].as_array().unwrap().iter();
    let row = |row: &Value| {
        let numbers = row.as_array().unwrap().iter();
        numbers.map(|x| x.as_f64().unwrap()).collect()
    };
    rows.map(row).collect()
}

/// The largest distance from MuJoCo's figures, per number that is seen.
fn apart(
    name: &str,
    case: &Case,
    (q, v): (&[f64], &[f64]),
    h: f64,
    seen: impl Fn(&[f64]) -> Vec<f64>,
) -> Vec<f64> {
    let rows = rows(name);
    let steps = (rows[1][0] / h).round() as usize;
    let mut most = vec![0.0_f64; rows[0].len() - 1];
    let (mut step, mut row) = (0, 1);
    case.run((q, v), h, steps * (rows.len() - 1), |_, q, _, _| {
        step += 1;
        if step % steps == 0 {
            let both = seen(q).into_iter().zip(&rows[row][1..]);
            for (most, (ours, theirs)) in most.iter_mut().zip(both) {
                *most = most.max((ours - theirs).abs());
            }
            row += 1;
        }
    });
    most
}

#[test]
fn a_box_slides_and_turns() {
    let corner = |x: f64, y: f64| {
        format!("point(block * translate({x}, {y}, -0.05)) on plane_z(world) {{ friction: 0.3; }}")
    };
    let case = Case::new(&format!(
        "
        model block;
        coordinate x: m;
        coordinate y: m;
        coordinate z: m;
        coordinate yaw: rad;
        coordinate pitch: rad;
        coordinate roll: rad;
        body block {{
            frame: translate(x, y, z) * rotate_z(yaw) * rotate_y(pitch) * rotate_x(roll);
            mass: 2; inertia: diag(0.02, 0.03, 0.04);
        }}
        gravity (0, 0, -9.81);
        contact a: {}
        contact b: {}
        contact c: {}
        contact d: {}
        ",
        corner(0.2, 0.1),
        corner(0.2, -0.1),
        corner(-0.2, 0.1),
        corner(-0.2, -0.1)
    ));
    let q = [0.0, 0.0, 0.05, 0.0, 0.0, 0.0];
    let v = [1.5, 0.5, 0.0, 4.0, 0.0, 0.0];
    let off = apart("box", &case, (&q, &v), 1e-3, |q| vec![q[0], q[1], q[3]]);
    // 45 cm and 43 degrees on the way.
    assert!(off[0] < 0.01 && off[1] < 0.01 && off[2] < 0.03, "{off:?}");
}

#[test]
fn a_wheel_rolls_on() {
    let case = Case::new(
        "
        model wheel;
        coordinate x: m;
        coordinate y: m;
        coordinate z: m;
        coordinate yaw: rad;
        coordinate tilt: rad;
        coordinate spin: rad;
        body wheel {
            frame: translate(x, y, z) * rotate_z(yaw) * rotate_x(tilt) * rotate_y(spin);
            mass: 1.3; inertia: diag(0.0203125, 0.040625, 0.0203125);
        }
        gravity (0, 0, -9.81);
        contact rim: disc_y(wheel, 0.25) on plane_z(world) { friction: 0.9; }
        ",
    );
    let q = [0.0, 0.0, 0.25 * 0.2_f64.cos(), 0.0, 0.2, 0.0];
    let v = [3.0, 0.0, 0.0, 0.0, 0.0, 12.0];
    let off = apart("wheel", &case, (&q, &v), 1e-3, |q| q[..3].to_vec());
    // 2.9 m on the way.
    assert!(off[0] < 2e-3 && off[1] < 2e-3 && off[2] < 2e-4, "{off:?}");
}

#[test]
fn a_quadruped_lands() {
    for velocities in VELOCITIES {
        let case = quadruped(velocities);
        let q = in_the_air(&case);
        let v = vec![0.0; case.machine.coordinate_count()];
        let names = case.machine.compiled.model.positions();
        let height = names.iter().position(|q| q.name == "base_link_z").unwrap();
        let off = apart("walker", &case, (&q, &v), 1e-3, |q| vec![0.0, q[height]]);
        assert!(off[1] < 2e-3, "{velocities}: {off:?}");
    }
}
