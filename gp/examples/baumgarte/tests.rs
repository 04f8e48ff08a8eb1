//! Trajectories of a trained GP²: the constraint drifts without stabilisation and
//! decays by its own law with it (thesis 5.28–5.32).

use super::{dormand_prince, euler, trained};
use dynamics::constrained::Baumgarte;

#[test]
fn violation_decays_as_the_damped_oscillator_it_is_made_to_be() {
    let model = trained().unwrap();
    // c̈ + 2ζω ċ + ω² c = 0 from c = c0, ċ = 0, whatever was learnt.
    let (omega, offset) = (8.0, 0.02);
    let critical = |t: f64| offset * (1.0 + omega * t) * (-omega * t).exp();
    let light = |t: f64| {
        let damped = omega * (1.0f64 - 0.25).sqrt();
        let (sin, cos) = (damped * t).sin_cos();
        offset * (-0.5 * omega * t).exp() * (cos + 0.5 * omega / damped * sin)
    };
    let run = |zeta| {
        let how = Baumgarte { omega, zeta };
        dormand_prince(&model, Some(&how), 2.0, offset).unwrap()
    };
    for ((t, c), (_, d)) in run(1.0).into_iter().zip(run(0.5)) {
        assert!((c - critical(t)).abs() < 1e-8, "{t}: {c} {}", critical(t));
        assert!((d - light(t)).abs() < 1e-8, "{t}: {d} {}", light(t));
    }
    // Without it c̈ = 0: the offset stays.
    for (t, c) in dormand_prince(&model, None, 2.0, offset).unwrap() {
        assert!((c - offset).abs() < 1e-8, "{t}: {c}");
    }
}

#[test]
fn integration_drifts_unless_stabilised() {
    let model = trained().unwrap();
    let largest = |c: &[f64]| c.iter().fold(0.0, |m: f64, c| m.max(c.abs()));
    let plain = euler(&model, None, 5.0, 0.0).unwrap();
    let stable = euler(&model, Some(&Baumgarte::critical(10.0)), 5.0, 0.0).unwrap();
    let (plain, stable) = (largest(&plain), largest(&stable));
    println!("largest violation {plain:.2e} m, stabilised {stable:.2e} m");
    assert!(plain > 10.0 * stable, "{plain} {stable}");
    assert!(stable < 1e-3, "{stable}");
}
