//! Impacts of a body that another contact presses on at the same time.

use crate::case::Case;

const G: f64 = 9.81;

/// A point that slides on a rough floor against a wall which gives back `e` of its speed: Coulomb's
/// friction slows it by `μ g`, and the floor, which the wall does not press it on, takes nothing more.
#[test]
fn a_sliding_block_comes_back_from_a_wall() {
    let (mu, e, v, way) = (0.3, 0.6, 2.0_f64, 0.4);
    let case = Case::new(&format!(
        "
        model block;
        coordinate x: m;
        coordinate z: m;
        body block {{ frame: translate(x, 0, z); mass: 1.3; }}
        gravity (0, 0, -9.81);
        contact floor: point(block) on plane_z(world) {{ friction: {mu}; }}
        contact wall: point(block) on plane_x(translate({way}, 0, 0) * rotate_z(pi)) {{ friction: {mu}; restitution: {e}; }}
        "
    ));
    let arrives = (v * v - 2.0 * mu * G * way).sqrt();
    let comes_to_rest = way - (e * arrives).powi(2) / (2.0 * mu * G);
    let miss = |h: f64| {
        let mut lifted = 0.0_f64;
        let steps = (1.5 / h) as usize;
        let end = case.run((&[0.0, 0.0], &[v, 0.0]), h, steps, |_, q, _, _| {
            lifted = lifted.max(q[1].abs());
        });
        assert!(lifted < 1e-9, "leaves the floor by {lifted:e} m");
        (end.q[0] - comes_to_rest).abs()
    };
    let (coarse, fine) = (miss(1e-3), miss(1e-4));
    assert!(
        coarse < 3e-3 && fine < 3e-4,
        "off by {coarse:e} and {fine:e} m"
    );
}

/// A box that slides on a smooth floor is tripped by a kerb at its lower edge. The kerb gives back `e` of
/// the edge's speed, the floor keeps the edge from going down, and neither has a moment about it:
/// with half width `a`, half height `b`, `I = m (a² + b²)/3`,
///
/// ```text
/// ω = 3 (1 + e) b v / (4 (a² + b²))      vx = b ω − e v      vz = a ω
/// ```
#[test]
fn a_sliding_box_is_tripped_by_a_kerb() {
    let (a, b, m, v) = (0.2_f64, 0.3_f64, 2.5, 1.5);
    for (e, friction) in [(0.0, 0.0), (0.5, 0.0), (0.5, 0.4), (1.0, 0.0)] {
        let case = Case::new(&format!(
            "
            model crate_;
            coordinate x: m;
            coordinate z: m;
            coordinate phi: rad;
            body crate_ {{ frame: translate(x, 0, z) * rotate_y(phi); mass: {m}; inertia: diag(0, {inertia}, 0); }}
            gravity (0, 0, -9.81);
            frame rear = crate_ * translate(-{a}, 0, -{b});
            frame edge = crate_ * translate({a}, 0, -{b});
            contact behind: point(rear) on plane_z(world) {{ friction: {friction}; }}
            contact ahead: point(edge) on plane_z(world) {{ friction: {friction}; }}
            contact kerb: point(edge) on plane_x(translate({a} + 0.05, 0, 0) * rotate_z(pi)) {{ restitution: {e}; }}
            ",
            inertia = m * (a * a + b * b) / 3.0
        ));
        let miss = |h: f64| {
            let mut before = v;
            let mut turning = Vec::new();
            case.run(
                (&[0.0, b, 0.0], &[v, 0.0, 0.0]),
                h,
                (0.08 / h) as usize,
                |_, _, v, _| {
                    if !turning.is_empty() || v[2].abs() > 0.1 {
                        turning.push([v[0], v[1], v[2]]);
                    } else {
                        before = v[0];
                    }
                },
            );
            // Without restitution the edge arrives at the end of one step, and is stopped by the next.
            let (v, found) = (before, turning.get(1).expect("the box turns"));
            let turn = 3.0 * (1.0 + e) * b * v / (4.0 * (a * a + b * b));
            let expected = [b * turn - e * v, a * turn, turn];
            let off = found.iter().zip(expected).map(|(f, e)| (f - e).abs());
            off.fold(0.0_f64, f64::max)
        };
        // What weight does within a step.
        let (coarse, fine) = (miss(1e-3), miss(1e-4));
        assert!(
            coarse < 0.05 && fine < 5e-3,
            "e = {e}, friction {friction}: off by {coarse:e} and {fine:e}"
        );
    }
}
