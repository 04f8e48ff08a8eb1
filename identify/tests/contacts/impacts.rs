//! Bouncing, rocking and falling: what impacts do.

use crate::case::Case;

const G: f64 = 9.81;

const BALL: &str = "
model ball;
coordinate z: m;
parameter e: 1 = 0.8 in 0..1;
body ball { frame: translate(0, 0, z); mass: 0.4; }
gravity (0, 0, -9.81);
contact floor: sphere(ball, 0.1) on plane_z(world) { restitution: e; }
";

/// Dropped from `height` above the floor it bounces at `t₀ (1 + 2 (e + e² + …))`, and lies
/// still from `t₀ (1 + e)/(1 − e)` on, `t₀ = √(2 height/g)`.
#[test]
fn a_ball_bounces_when_it_should_and_stops() {
    let height = 1.0_f64;
    let t0 = (2.0 * height / G).sqrt();
    let case = Case::new(BALL).with("e", 0.5);
    let limit = t0 * 1.5 / 0.5;
    for h in [1e-3, 1e-4] {
        let mut bounces = Vec::new();
        let steps = (2.0 * limit / h) as usize;
        let mut last_moving = 0.0;
        let end = case.run((&[height + 0.1], &[0.0]), h, steps, |t, q, v, p| {
            if p[2] > 0.4 * G * h * 1.5 {
                bounces.push(t);
            }
            if v[0].abs() > 2.0 * G * h || (q[0] - 0.1).abs() > 1e-5 {
                last_moving = t;
            }
        });
        let mut expected = t0;
        for (n, found) in bounces.iter().take(5).enumerate() {
            let n = n as i32;
            // Each bounce is at most a step early.
            assert!(
                (found - expected).abs() < 3.0 * f64::from(n + 1) * h,
                "bounce {n} at {found}, not {expected}"
            );
            expected += 2.0 * t0 * 0.5_f64.powi(n + 1);
        }
        assert!(
            (last_moving - limit).abs() < 20.0 * h,
            "still at {last_moving}, not {limit}"
        );
        assert!((end.q[0] - 0.1).abs() < 1e-9 && end.v[0].abs() < 1e-12);
    }
}

#[test]
fn an_elastic_ball_keeps_its_energy_for_ever() {
    let case = Case::new(BALL).with("e", 1.0);
    let start = ([0.6], [0.0]);
    let before = case.energy(&start.0, &start.1);
    let mut most = 0.0_f64;
    let end = case.run((&start.0, &start.1), 1e-3, 100_000, |_, q, v, _| {
        most = most.max(case.energy(q, v) - before);
    });
    let after = case.energy(&end.q, &end.v);
    assert!(most < 1e-9, "gains {most:e} J");
    assert!(
        (after - before).abs() < 1e-9,
        "{after} J in place of {before} J"
    );
}

/// A homogeneous block that rocks from corner to corner keeps of its rate, at each impact,
/// `1 − 3/2 sin²α` (Housner, Bull. Seism. Soc. Am. 53, 1963), `tan α = width/height`.
#[test]
fn a_rocking_block_loses_what_housner_says() {
    let (b, h) = (0.05_f64, 0.2_f64);
    let case = Case::new(&format!(
        "
        model tower;
        coordinate x: m;
        coordinate z: m;
        coordinate phi: rad;
        body tower {{ frame: translate(x, 0, z) * rotate_y(phi); mass: 1.7; inertia: diag(0, {inertia}, 0); }}
        gravity (0, 0, -9.81);
        contact left:  point(tower * translate(-{b}, 0, -{h})) on plane_z(world) {{ friction: 2; }}
        contact right: point(tower * translate({b}, 0, -{h})) on plane_z(world) {{ friction: 2; }}
        ",
        inertia = 1.7 * (b * b + h * h) / 3.0
    ));
    // Tilted about the right corner, which is at the origin.
    let tilt = 0.1_f64;
    let (sin, cos) = tilt.sin_cos();
    let q = [-b * cos + h * sin, b * sin + h * cos, tilt];
    let mut rates: Vec<f64> = Vec::new();
    let mut tilts = Vec::new();
    case.run((&q, &[0.0; 3]), 1e-4, 8000, |_, q, v, _| {
        rates.push(v[2]);
        tilts.push(q[2]);
    });
    let crosses = |&n: &usize| tilts[n] * tilts[n - 1] < 0.0;
    let impacts = (8..rates.len() - 8).filter(crosses);
    // Gravity slows it by as much behind the impact as it sped it up before.
    let kept: Vec<f64> = impacts.map(|n| rates[n + 3] / rates[n - 4]).collect();
    let alpha = (b / h).atan();
    let expected = 1.0 - 1.5 * alpha.sin().powi(2);
    assert!(kept.len() >= 2, "rocks {} times", kept.len());
    for ratio in &kept[..2] {
        assert!(
            (ratio - expected).abs() < 5e-3,
            "keeps {ratio}, not {expected}"
        );
    }
}

/// A slender rod on a smooth floor: its centre falls straight down, and
/// `ω² = g L (cos θ₀ − cos θ)/(L²/4 sin²θ + L²/12)`.
#[test]
fn a_rod_falls_on_a_smooth_floor() {
    let case = Case::new(
        "
        model rod;
        coordinate x: m;
        coordinate z: m;
        coordinate theta: rad;
        body rod { frame: translate(x, 0, z) * rotate_y(theta); mass: 1; inertia: diag(0, 0.0833333333333333333, 0); }
        gravity (0, 0, -9.81);
        contact foot: point(rod * translate(0, 0, -0.5)) on plane_z(world);
        ",
    );
    let theta = 0.3_f64;
    let start = ([0.0, 0.5 * theta.cos(), theta], [0.0; 3]);
    let miss = |h: f64| {
        let mut worst = 0.0_f64;
        let mut gap = 0.0_f64;
        let steps = (0.5 / h) as usize;
        case.run((&start.0, &start.1), h, steps, |t, q, v, _| {
            let (s, c) = q[2].sin_cos();
            let square = G * (theta.cos() - c) / (s * s / 4.0 + 1.0 / 12.0);
            worst = worst
                .max((v[2] - square.max(0.0).sqrt()).abs())
                .max(q[0].abs());
            gap = gap.max(case.contacts(t, q, v).gap[0].abs());
        });
        assert!(gap < 1e-6, "the foot leaves by {gap:e} m");
        worst
    };
    let (coarse, fine) = (miss(1e-3), miss(5e-4));
    assert!(coarse < 1e-4, "off by {coarse:e} rad/s");
    assert!(fine < coarse / 2.5, "no second order: {coarse:e}, {fine:e}");
}

/// Restitution after Newton with friction may give energy to linked bodies (Kane); not here.
#[test]
fn no_impact_gives_energy() {
    let case = Case::new(
        "
        model pair;
        coordinate x: m;
        coordinate z: m;
        coordinate a: rad;
        coordinate b: rad;
        body upper { frame: translate(x, 0, z) * rotate_y(a); mass: 1; center: (0, 0, -0.5); inertia: diag(0, 0.08, 0); }
        body lower { frame: upper * translate(0, 0, -1) * rotate_y(b); mass: 1; center: (0, 0, -0.5); inertia: diag(0, 0.08, 0); }
        contact foot: point(lower * translate(0, 0, -1)) on plane_z(world) { friction: 0.9; restitution: 0.9; }
        ",
    );
    for (a, b, va, vb) in [
        (0.3, 0.5, -2.0, 3.0),
        (0.7, -1.0, 4.0, -1.0),
        (-0.4, 1.2, 2.5, 2.5),
    ] {
        let mut q = [0.0, 0.0, a, b];
        q[1] = 1e-5 - case.contacts(0.0, &q, &[0.0; 4]).gap[0];
        let mut v = [0.5, 0.0, va, vb];
        v[1] = -2.0 - case.contacts(0.0, &q, &v).approach(0);
        let before = case.energy(&q, &v);
        let mut hit = false;
        case.run((&q, &v), 1e-4, 50, |_, q, v, p| {
            hit |= p[2] > 0.0;
            let gain = case.energy(q, v) - before;
            assert!(gain < 1e-9, "gains {gain:e} J");
        });
        assert!(hit, "nothing was hit");
    }
}

/// The `n`th of its bounces comes at `t₀ (1 + 2 (e + … + eⁿ))`, to the last digits, and so long as it flies
/// for longer than a step every one is listed.
#[test]
fn bounces_are_found_at_their_instants() {
    let (height, e) = (1.0_f64, 0.8_f64);
    let t0 = (2.0 * height / G).sqrt();
    let case = Case::new(BALL).with("e", e);
    let impacts = case.impacts((&[height + 0.1], &[0.0]), 1e-3, 4100);
    assert!(impacts.len() >= 25, "only {} bounces", impacts.len());
    let (mut expected, mut speed) = (t0, G * t0);
    for (n, impact) in impacts.iter().take(25).enumerate() {
        assert!(
            (impact.t - expected).abs() < 1e-12 && (impact.approach + speed).abs() < 1e-11,
            "bounce {n}: {impact:?} in place of {speed} m/s at {expected} s"
        );
        let given = 0.4 * speed * (1.0 + e);
        assert!((impact.impulse[2] - given).abs() < 1e-11 && impact.contact == 0);
        speed *= e;
        expected += 2.0 * speed / G;
    }
}

/// A rod that falls flat hits with both ends at once, and each takes half.
#[test]
fn what_touches_together_hits_together() {
    let case = Case::new(
        "
        model rod;
        coordinate z: m;
        coordinate phi: rad;
        body rod { frame: translate(0, 0, z) * rotate_y(phi); mass: 1; inertia: diag(0, 0.1, 0); }
        gravity (0, 0, -9.81);
        contact left:  point(rod * translate(-0.5, 0, 0)) on plane_z(world);
        contact right: point(rod * translate(0.5, 0, 0)) on plane_z(world);
        ",
    );
    let impacts = case.impacts((&[0.3, 0.0], &[0.0, 0.0]), 1e-3, 1000);
    let (t, speed) = ((0.6 / G).sqrt(), (0.6 * G).sqrt());
    assert_eq!(impacts.len(), 2, "{impacts:?}");
    for impact in &impacts {
        assert!((impact.t - t).abs() < 1e-12 && (impact.impulse[2] - speed / 2.0).abs() < 1e-9);
    }
}

/// Between steep walls with friction nothing bounces, whatever the restitution: it jams.
#[test]
fn a_ball_jams_in_a_wedge() {
    let case = Case::new(
        "
        model wedge;
        coordinate x: m;
        coordinate z: m;
        coordinate a: rad;
        body ball { frame: translate(x, 0, z) * rotate_y(a); mass: 0.4; inertia: diag(1e-3, 1e-3, 1e-3); }
        gravity (0, 0, -9.81);
        contact left:  sphere(ball, 0.1) on plane_z(world * rotate_y(1.4)) { friction: 1.5; restitution: 0.5; }
        contact right: sphere(ball, 0.1) on plane_z(world * rotate_y(-1.4)) { friction: 1.5; restitution: 0.5; }
        ",
    );
    let start = ([0.0, 1.0, 0.0], [0.3, -2.0, 5.0]);
    let mut before = case.energy(&start.0, &start.1);
    let end = case.run((&start.0, &start.1), 1e-3, 1000, |_, q, v, _| {
        let energy = case.energy(q, v);
        assert!(energy < before + 1e-7, "gains {:e} J", energy - before);
        before = energy;
    });
    assert!(end.v.iter().all(|v| v.abs() < 1e-9), "moves: {:?}", end.v);
}
