//! Blocks on planes: Coulomb's law as it is written.

use crate::case::Case;

/// A block on an incline of 0.4 rad: four corners, so that its forces are not unique.
const BLOCK: &str = "
model block;
coordinate x: m;
coordinate y: m;
coordinate z: m;
coordinate roll: rad;
coordinate pitch: rad;
coordinate yaw: rad;
parameter mu: 1 = 0.3 in 0..;
body block {
    frame: translate(x, y, z) * rotate_y(0.4) * rotate_z(yaw) * rotate_y(pitch) * rotate_x(roll);
    mass: 2; inertia: diag(0.02, 0.03, 0.04);
}
gravity (0, 0, -9.81);
contact a: point(block * translate( 0.2,  0.1, -0.05)) on plane_z(world * rotate_y(0.4)) { friction: mu; }
contact b: point(block * translate( 0.2, -0.1, -0.05)) on plane_z(world * rotate_y(0.4)) { friction: mu; }
contact c: point(block * translate(-0.2,  0.1, -0.05)) on plane_z(world * rotate_y(0.4)) { friction: mu; }
contact d: point(block * translate(-0.2, -0.1, -0.05)) on plane_z(world * rotate_y(0.4)) { friction: mu; }
";

const SLOPE: f64 = 0.4;
const G: f64 = 9.81;

/// Its place on the incline: centre 0.05 above the plane.
fn lying() -> ([f64; 6], [f64; 6]) {
    let q = [0.05 * SLOPE.sin(), 0.0, 0.05 * SLOPE.cos(), 0.0, 0.0, 0.0];
    (q, [0.0; 6])
}

#[test]
fn a_block_stays_below_the_friction_angle_and_slides_above_it() {
    let (q, v) = lying();
    // tan(0.4) = 0.42279: a thousandth above it, the block stays.
    let case = Case::new(BLOCK).with("mu", SLOPE.tan() * 1.001);
    let end = case.run((&q, &v), 1e-3, 1000, |_, _, _, _| ());
    let drift = q
        .iter()
        .zip(&end.q)
        .map(|(a, b)| (a - b).abs())
        .fold(0.0, f64::max);
    assert!(drift < 1e-9, "drifts by {drift:e} m");
    for mu in [SLOPE.tan() * 0.99, 0.3, 0.0] {
        let case = Case::new(BLOCK).with("mu", mu);
        let end = case.run((&q, &v), 1e-3, 1000, |_, _, _, _| ());
        let a = G * (SLOPE.sin() - mu * SLOPE.cos());
        let way = (end.q[0] - q[0]) * SLOPE.cos() - (end.q[2] - q[2]) * SLOPE.sin();
        // The acceleration is constant: the midpoint rule makes no error.
        assert!(
            (way - a / 2.0).abs() < 1e-8,
            "mu {mu}: {way} in place of {}",
            a / 2.0
        );
        let turned = end.q[3..].iter().fold(0.0_f64, |most, x| most.max(x.abs()));
        assert!(turned < 1e-8, "turns by {turned:e}");
    }
}

#[test]
fn forces_carry_the_weight() {
    let (q, v) = lying();
    let case = Case::new(BLOCK).with("mu", 0.5);
    let pressed = case
        .machine
        .pressed(&case.states(0.0, &q, &v), &case.parameters);
    let pressed = pressed.unwrap().remove(0);
    let total = |axis: usize| -> f64 { (0..4).map(|i| pressed.force[3 * i + axis]).sum() };
    let weight = 2.0 * G;
    assert!((total(0) + weight * SLOPE.sin()).abs() < 1e-8);
    assert!(total(1).abs() < 1e-8);
    assert!((total(2) - weight * SLOPE.cos()).abs() < 1e-8);
    assert!(pressed.motion.acceleration.amax() < 1e-8);
}

/// What is thrown along a floor comes to rest after v²/(2 μ g), and stays.
#[test]
fn sliding_ends_where_it_must() {
    let case = Case::new(
        "
        model puck;
        coordinate x: m;
        coordinate y: m;
        coordinate z: m;
        body puck { frame: translate(x, y, z); mass: 0.3; }
        gravity (0, 0, -9.81);
        contact floor: sphere(puck, 0.02) on plane_z(world) { friction: 0.25; }
        ",
    );
    let (vx, vy) = (0.8, -0.6);
    let far = 1.0 / (2.0 * 0.25 * G);
    let miss = |h: f64| {
        let steps = (1.0 / h) as usize;
        let end = case.run(
            (&[0.0, 0.0, 0.02], &[vx, vy, 0.0]),
            h,
            steps,
            |_, _, _, _| (),
        );
        assert!(
            end.v.iter().all(|v| v.abs() < 1e-12),
            "moves with {:?}",
            end.v
        );
        (end.q[0] - far * vx).abs().max((end.q[1] - far * vy).abs())
    };
    // It stops inside of a step: the error is of the second order.
    assert!(miss(1e-3) < 1e-6, "{:e}", miss(1e-3));
    assert!(miss(1e-4) < 1e-8, "{:e}", miss(1e-4));
}

/// A belt that moves, and one that lifts: planes may move as frames do.
#[test]
fn planes_move() {
    let case = Case::new(
        "
        model parcel;
        coordinate x: m;
        coordinate z: m;
        constant speed: m/s = 1.5;
        constant lift: m/s^2 = 2;
        body parcel { frame: translate(x, 0, z); mass: 3; }
        frame belt = translate(speed*t, 0, lift*t^2/2);
        gravity (0, 0, -9.81);
        contact belt: point(parcel) on plane_z(belt) { friction: 0.4; }
        ",
    );
    let h = 1e-3;
    let mut gap = 0.0_f64;
    let end = case.run((&[0.0, 0.0], &[0.0, 0.0]), h, 500, |t, q, v, _| {
        gap = gap.max(case.contacts(t, q, v).gap[0].abs());
    });
    // Heavier by what the belt lifts, the parcel takes the belt's speed after 1.5/(0.4 (g + 2)) s.
    let a = 0.4 * (G + 2.0);
    let slips = 1.5 / a;
    let expected = 1.5 * 0.5 - 1.5 * slips / 2.0;
    assert!((end.v[0] - 1.5).abs() < 1e-10);
    assert!(
        (end.q[0] - expected).abs() < 2e-6,
        "{} {expected}",
        end.q[0]
    );
    assert!(
        (end.v[1] - 1.0).abs() < 1e-6 && gap < 1e-6,
        "{} {gap:e}",
        end.v[1]
    );
}

/// A ball that cannot turn, on a floor: a contact, or the constraint that comes and goes in its place, with
/// friction as an effect.
fn puck(held: &str) -> Case {
    Case::new(&format!(
        "
        model puck;
        coordinate x: m;
        coordinate z: m;
        input stance: 1;
        body puck {{ frame: translate(x, 0, z); mass: 0.7; }}
        gravity (0, 0, -9.81);
        contact foot: sphere(puck, 0.05) on plane_z(world) {{ friction: 0.3; }}
        {held}
        "
    ))
}

#[test]
fn friction_of_a_held_contact_is_an_effect() {
    let held = puck(
        "constraint down when stance - 0.5: gap(foot) == 0;
        effect contact_friction(down) { mu = 0.3, v_s = 1e-3 }",
    );
    let motion = |stance: f64| {
        let mut states = held.states(0.0, &[0.0, 0.05], &[0.8, 0.0]);
        states.u = vec![vec![stance]];
        let motion = held.machine.motion(&states, &held.parameters);
        motion.unwrap().remove(0)
    };
    // The floor carries the weight, and friction is in proportion.
    let down = motion(1.0);
    assert!((down.multiplier[0] - 0.7 * G).abs() < 1e-12);
    assert!((down.acceleration[0] + 0.3 * G).abs() < 1e-12);
    assert!(down.acceleration[1].abs() < 1e-12);
    // Lifted, it falls.
    let up = motion(0.0);
    assert_eq!(up.multiplier[0], 0.0);
    assert!(up.acceleration[0].abs() < 1e-12 && (up.acceleration[1] + G).abs() < 1e-12);
    // So long as it slides, the contact by itself does the same.
    let (q, v) = ([0.0, 0.05], [0.8, 0.0]);
    let (mut worst, free) = (0.0_f64, puck(""));
    free.run((&q, &v), 1e-3, 200, |t, q, v, _| {
        let (x, speed) = (0.8 * t - 0.15 * G * t * t, 0.8 - 0.3 * G * t);
        worst = worst.max((q[0] - x).abs()).max((v[0] - speed).abs());
    });
    assert!(worst < 1e-9, "off by {worst:e}");
}

/// A box that floats by its twist, along axes that are not the world's: it slides straight on,
/// `v²/(2 μ g)` far, and rests.
#[test]
fn a_box_with_a_heading_slides_straight_on() {
    const MU: f64 = 0.3;
    let mut text = "model sliding; urdf \"../tests/data/models/box.urdf\" \
                    { base: floating; velocities: twist; }"
        .to_string();
    for (corner, x, y) in [
        ("a", 0.2, 0.1),
        ("b", 0.2, -0.1),
        ("c", -0.2, 0.1),
        ("d", -0.2, -0.1),
    ] {
        text += &format!(
            "contact {corner}: point(box * translate({x}, {y}, -0.05)) on plane_z(world) \
             {{ friction: {MU}; }}"
        );
    }
    let case = Case::new(&text);
    let heading = 0.7_f64;
    let (s, c) = (heading / 2.0).sin_cos();
    let q = [0.0, 0.0, 0.05, 0.0, 0.0, s, c];
    let v = [1.2, 0.5, 0.0, 0.0, 0.0, 0.0];
    let end = case.run((&q, &v), 1e-3, 600, |_, _, _, _| ());
    let way = 1.3_f64.powi(2) / (2.0 * MU * G);
    let (y, x) = (heading + 0.5_f64.atan2(1.2)).sin_cos();
    let expected = [way * x, way * y, 0.05, 0.0, 0.0, s, c];
    for (found, expected) in end.q.iter().zip(expected) {
        // It stops within a step, whose middle the rule takes.
        assert!((found - expected).abs() < 1e-6, "{:?}", end.q);
    }
    assert!(end.v.iter().all(|v| v.abs() < 1e-9), "moves: {:?}", end.v);
}
