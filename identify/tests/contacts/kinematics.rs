//! Gaps, velocities, Jacobians and biases against difference quotients along a motion.

use crate::case::Case;

/// Contacts of all kinds: a disc, a sphere and points, on planes that move, tilt and turn.
const TOUCHING: &str = include_str!("../../../tests/data/models/touching.model");

#[test]
fn rates_are_those_of_a_motion() {
    let case = Case::new(TOUCHING);
    let n = case.machine.coordinate_count();
    let number = |i: usize, a: f64| (a * (i as f64 + 1.3)).sin();
    let q: Vec<f64> = (0..n).map(|i| number(i, 0.9)).collect();
    let v: Vec<f64> = (0..n).map(|i| 2.0 * number(i, 1.7)).collect();
    let a: Vec<f64> = (0..n).map(|i| 3.0 * number(i, 2.9)).collect();
    // Along `q + v s + a s²/2`.
    let at = |s: f64| {
        let q: Vec<f64> = (0..n)
            .map(|i| q[i] + s * v[i] + s * s / 2.0 * a[i])
            .collect();
        let v: Vec<f64> = (0..n).map(|i| v[i] + s * a[i]).collect();
        case.contacts(0.4 + s, &q, &v)
    };
    let (here, s) = (at(0.0), 1e-5);
    let (before, after) = (at(-s), at(s));
    assert_eq!(here.len(), 4);
    let a = nalgebra::DVector::from_vec(a);
    let rates = &here.jacobian * a - &here.bias;
    for i in 0..here.len() {
        let rate = (after.gap[i] - before.gap[i]) / (2.0 * s);
        assert!(
            (rate - here.approach(i)).abs() < 1e-8,
            "gap {i}: {rate}, {}",
            here.approach(i)
        );
    }
    for row in 0..12 {
        let rate = (after.velocity[row] - before.velocity[row]) / (2.0 * s);
        assert!(
            (rate - rates[row]).abs() < 1e-7,
            "row {row}: {rate}, {}",
            rates[row]
        );
    }
}

/// The nearest point of a rim is the lowest of all its points.
#[test]
fn a_rim_is_as_far_as_its_nearest_point() {
    let case = Case::new(
        "
        model rim;
        coordinate z: m;
        coordinate tilt: rad;
        coordinate spin: rad;
        body wheel { frame: translate(0, 0, z) * rotate_x(tilt) * rotate_y(spin); mass: 1; inertia: diag(1, 1, 1); }
        contact rim: disc_y(wheel, 0.3) on plane_z(world);
        output rim = position(wheel);
        ",
    );
    for tilt in [0.0, 0.4, -1.2, 1.5] {
        let (z, spin) = (0.7, 0.9);
        let gap = case.contacts(0.0, &[z, tilt, spin], &[0.0; 3]).gap[0];
        let lowest = (0..100_000).map(|k| {
            let phi = f64::from(k) * std::f64::consts::TAU / 1e5;
            // In the disc's plane: x, and z turned about x.
            z + 0.3 * phi.sin() * f64::cos(tilt)
        });
        let lowest = lowest.fold(f64::INFINITY, f64::min);
        assert!((gap - lowest).abs() < 1e-8, "tilt {tilt}: {gap}, {lowest}");
    }
}
