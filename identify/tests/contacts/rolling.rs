//! Discs that roll: the rim of a wheel on a plane.

use crate::case::Case;
use identify::machine::{Rollout, RolloutOptions, Simulated};

const G: f64 = 9.81;

/// Pushed without turning, a homogeneous disc slides for `v₀/(3 μ g)` and then rolls with ⅔ `v₀`.
#[test]
fn a_disc_that_slides_comes_to_roll() {
    let case = Case::new(
        "
        model disc;
        coordinate x: m;
        coordinate z: m;
        coordinate spin: rad;
        body disc { frame: translate(x, 0, z) * rotate_y(spin); mass: 2; inertia: diag(0, 0.01, 0); }
        gravity (0, 0, -9.81);
        contact rim: disc_y(disc, 0.1) on plane_z(world) { friction: 0.2; }
        ",
    );
    let (v0, mu, h) = (1.2, 0.2, 1e-3);
    let until = v0 / (3.0 * mu * G);
    let mut gap = 0.0_f64;
    let end = case.run(
        (&[0.0, 0.1, 0.0], &[v0, 0.0, 0.0]),
        h,
        1000,
        |t, q, v, p| {
            gap = gap.max(case.contacts(t, q, v).gap[0].abs());
            if t < until - h {
                assert!((p[0] + mu * p[2]).abs() < 1e-9, "slides, with {p:?}");
            } else if t > until + 2.0 * h {
                assert!(p[0].abs() < 1e-9, "rolls by itself, with {p:?}");
            }
        },
    );
    let rolls = 2.0 / 3.0 * v0;
    assert!((end.v[0] - rolls).abs() < 1e-9 && (end.v[2] - rolls / 0.1).abs() < 1e-8);
    let way = until * (v0 + rolls) / 2.0 + rolls * (1.0 - until);
    assert!(
        (end.q[0] - way).abs() < 1e-6,
        "{} in place of {way}",
        end.q[0]
    );
    assert!(gap < 1e-12, "leaves by {gap:e} m");
}

/// A thin disc of mass 1.3 kg and radius 0.25 m; with `held`, its rim is tied to the plane by constraints.
fn coin(held: bool) -> Case {
    let ties = "
        constraint on_plane: gap(rim) == 0;
        constraint along_x: slip_x(rim) == 0;
        constraint along_y: slip_y(rim) == 0;
    ";
    Case::new(&format!(
        "
        model coin;
        coordinate x: m;
        coordinate y: m;
        coordinate z: m;
        coordinate yaw: rad;
        coordinate tilt: rad;
        coordinate spin: rad;
        constant m: kg = 1.3;
        constant r: m = 0.25;
        body coin {{
            frame: translate(x, y, z) * rotate_z(yaw) * rotate_x(tilt) * rotate_y(spin);
            mass: m; inertia: diag(m*r^2/4, m*r^2/2, m*r^2/4);
        }}
        gravity (0, 0, -9.81);
        contact rim: disc_y(coin, r) on plane_z(world) {{ friction: 0.9; }}
        {}
        ",
        if held { ties } else { "" }
    ))
}

/// A disc that rolls on a circle with tilt `τ` and rate `Ω` turns about its axis with `ω`:
/// `¼ Ω² sin τ cos τ − 3/2 Ω ω cos τ = (g/r) sin τ`.
#[test]
fn a_tilted_disc_rolls_on_a_circle() {
    let (r, tilt, circle) = (0.25, 0.3_f64, 2.0);
    let (s, c) = tilt.sin_cos();
    let turn = (circle * circle * s * c / 4.0 - G / r * s) / (1.5 * circle * c);
    let q = [0.0, 0.0, r * c, 0.0, tilt, 0.0];
    let v = [r * turn, 0.0, 0.0, circle, 0.0, turn - circle * s];
    let case = coin(false);
    let before = case.energy(&q, &v);
    let miss = |h: f64| {
        let (mut off, mut gap, mut gain) = (0.0_f64, 0.0_f64, 0.0_f64);
        let steps = (1.0 / h).round() as usize;
        let end = case.run((&q, &v), h, steps, |t, q, v, _| {
            off = off.max((q[4] - tilt).abs());
            gap = gap.max(case.contacts(t, q, v).gap[0].abs());
            gain = gain.max(case.energy(q, v) - before);
        });
        assert!(gap < 1e-6, "leaves the plane by {gap:e} m");
        assert!(gain < 1e-4 * before, "gains {gain:e} J of {before} J");
        off.max((end.q[3] - circle).abs())
    };
    let (coarse, fine) = (miss(1e-3), miss(5e-4));
    assert!(coarse < 1e-4, "off by {coarse:e} rad");
    assert!(fine < coarse / 3.0, "no second order: {coarse:e}, {fine:e}");
}

/// Where it neither slips nor lifts, a contact is the constraints that say so.
#[test]
fn a_contact_that_holds_is_a_constraint() {
    let (free, held) = (coin(false), coin(true));
    let mut q = [0.1, -0.2, 0.25 * 0.2_f64.cos(), 0.5, 0.2, 0.0];
    let mut v = [0.0, 0.0, 0.0, 0.4, -0.3, 8.0];
    held.machine.project(0.0, &mut q, &mut v, &held.parameters);
    let end = free.run((&q, &v), 2e-4, 5000, |_, _, _, _| ());
    let column = |values: &[f64]| values.iter().map(|&x| vec![x]).collect();
    let mut state = Simulated {
        q: column(&q),
        v: column(&v),
        z: Vec::new(),
    };
    let options = RolloutOptions {
        max_step: 2e-4,
        ..RolloutOptions::default()
    };
    let exact = Rollout::new(&held.machine, &held.parameters, options);
    exact.advance(&mut state, &[0.0], 1.0, &[], &[]).unwrap();
    for (i, (a, b)) in end.q.iter().zip(&state.q).enumerate() {
        assert!((a - b[0]).abs() < 1e-5, "coordinate {i}: {a}, {}", b[0]);
    }
    // And the forces are the multipliers.
    let states = |case: &Case| case.states(0.0, &q, &v);
    let pressed = free
        .machine
        .pressed(&states(&free), &free.parameters)
        .unwrap()
        .remove(0);
    let motion = held
        .machine
        .motion(&states(&held), &held.parameters)
        .unwrap()
        .remove(0);
    let multiplier = &motion.multiplier;
    assert!(
        (pressed.force[2] - multiplier[0]).abs() < 1e-6,
        "{} {multiplier}",
        pressed.force
    );
    assert!((pressed.force[0] - multiplier[1]).abs() < 1e-6);
    assert!((pressed.force[1] - multiplier[2]).abs() < 1e-6);
}
