//! Delays and internal states: roll-outs, motion along a curve, and derivatives.

use dynamics_codegen::derive::Variable;
use dynamics_codegen::{Library, compile};
use identify::machine::{Hold, Machine, Rollout, RolloutOptions, Simulated, States};

const STEP: f64 = 0.01;

fn machine(text: &str) -> Machine {
    let compiled = compile("m.model", text, &Library::builtin());
    Machine::new(compiled.unwrap_or_else(|report| panic!("{report}")))
}

/// A log of a mass on a line that is pushed by `u`.
fn log(u: impl Fn(f64) -> f64, samples: usize) -> States {
    let t: Vec<f64> = (0..samples).map(|k| k as f64 * STEP).collect();
    States {
        u: vec![t.iter().map(|&t| u(t)).collect()],
        q: vec![t.iter().map(|&t| t.sin()).collect()],
        v: vec![t.iter().map(|&t| t.cos()).collect()],
        t,
        ..States::default()
    }
}

/// Positions along a roll-out from rest over the log's inputs.
fn roll(machine: &Machine, log: &States, hold: Hold, values: &[f64], step: f64) -> Vec<f64> {
    let options = RolloutOptions {
        max_step: step,
        ..RolloutOptions::default()
    };
    let rollout = Rollout::new(machine, values, options);
    let [starts, ends] = machine.inputs_over(&log.t, &log.u, hold, values);
    let mut state = Simulated {
        q: vec![vec![0.0]],
        v: vec![vec![0.0]],
        z: Vec::new(),
    };
    let mut positions = vec![0.0];
    for k in 0..log.len() - 1 {
        let at = |columns: &[Vec<f64>]| columns.iter().map(|u| vec![u[k]]).collect::<Vec<_>>();
        rollout
            .advance(&mut state, &[log.t[k]], STEP, &at(&starts), &at(&ends))
            .unwrap();
        positions.push(state.q[0][0]);
    }
    positions
}

const PUSHED: &str = "model pushed; coordinate x: m; input u: N; parameter m: kg = 2;
    kinetic m/2*dot(x)^2; force x = u;";

#[test]
fn a_delayed_ramp_moves_in_closed_form() {
    let machine = machine(&format!("{PUSHED} effect input_delay(u) {{ tau = 0.137 }}"));
    let values = machine.nominal_parameters();
    let log = log(|t| 3.0 * t, 200);
    let found = roll(&machine, &log, Hold::Linear, &values, 1e-3);
    for (k, &x) in found.iter().enumerate() {
        // m x¨ = 3 (t − τ) once the ramp has arrived.
        let exact = 3.0 / 2.0 * (log.t[k] - 0.137).max(0.0).powi(3) / 6.0;
        assert!((x - exact).abs() < 5e-5 * (1.0 + exact), "{k}: {x} {exact}");
    }
    // A step that is held arrives after the delay to the last bit of its impulse.
    let step = self::log(|t| if t >= 0.1 { 1.0 } else { 0.0 }, 200);
    let found = roll(&machine, &step, Hold::Previous, &values, 1e-3);
    let end = log.t[199];
    let exact = 0.25 * (end - 0.237).powi(2);
    assert!((found[199] - exact).abs() < 1e-5, "{} {exact}", found[199]);
}

#[test]
fn a_lagging_step_moves_in_closed_form() {
    // At a fortieth of the time constant, and at fourteen times of it.
    for (tau, max_step, tolerance) in [(0.4, 0.01, 2e-4), (7e-4, 0.01, 1e-3)] {
        let machine = machine(&format!("{PUSHED} effect input_lag(u) {{ tau = {tau} }}"));
        let values = machine.nominal_parameters();
        let log = log(|t| if t > 0.0 { 4.0 } else { 0.0 }, 200);
        let found = roll(&machine, &log, Hold::Linear, &values, max_step);
        let step = |s: f64| {
            // The command rises over the first interval: its mean delay is half of it.
            let s = s - 0.5 * STEP;
            2.0 * (s * s / 2.0 - tau * s + tau * tau * (1.0 - (-s / tau).exp()))
        };
        let (x, exact) = (found[199], step(log.t[199]));
        assert!((x - exact).abs() < 1e-3 * exact, "{tau}: {x} {exact}");
        // Against itself with small steps.
        let fine = roll(&machine, &log, Hold::Linear, &values, 5e-4);
        assert!(
            (x - fine[199]).abs() < tolerance,
            "{tau}: {x} {}",
            fine[199]
        );
    }
}

/// A friction law that remembers, fast where the machine is fast.
const BRISTLE: &str = "model bristles; coordinate x: m; input u: N; parameter m: kg = 1;
    parameter f: N = 2; parameter reach: m = REACH; parameter late: s = 0.033;
    constant unit_reach: m = 0.001; state z: 1 = 0.2*reach/unit_reach;
    kinetic m/2*dot(x)^2; dot(z) == (dot(x) - abs(dot(x))*z)/reach;
    force x = delay(u, late) - f*z;";

#[test]
fn states_follow_a_known_curve_as_a_fine_integration_does() {
    let machine = machine(&BRISTLE.replace("REACH", "0.001"));
    let values = machine.nominal_parameters();
    let curve = log(f64::sin, 700);
    let along = machine.remember(&curve, Hold::Linear, &values).unwrap();
    // dz/dt = (v − |v| z)/reach with v = cos t is linear between reversals:
    // z = ±1 − (±1 − z₀) exp(−way/reach), way = ∫|v|.
    let (mut z, mut worst) = (0.2, 0.0_f64);
    for k in 0..699 {
        let fine = 200;
        for i in 0..fine {
            let (a, b) = (i as f64 / fine as f64, (i + 1) as f64 / fine as f64);
            let at = |share: f64| (curve.t[k] + share * STEP).sin();
            let way = at(b) - at(a);
            z = way.signum() - (way.signum() - z) * (-way.abs() / 0.001).exp();
        }
        worst = worst.max((along.memory.z[0][k + 1] - z).abs());
    }
    assert!(worst < 2e-2, "{worst}");
    let u = &along.memory.delayed[0];
    for k in 10..700 {
        assert!((u[k] - (curve.t[k] - 0.033).sin()).abs() < 2e-5);
    }
}

#[test]
fn accelerations_follow_parameters_through_memory() {
    for hold in [Hold::Linear, Hold::Previous] {
        // The slopes are integrated beside the states: exact where steps are fine.
        let mut machine = machine(&BRISTLE.replace("REACH", "0.2"));
        let values = machine.nominal_parameters();
        let curve = log(|t| (3.0 * t).sin(), 300);
        let all: Vec<Variable> = (0..4).map(Variable::Parameter).collect();
        let tape = machine.sensitivity(&all);
        let acceleration = |values: &[f64]| -> Vec<f64> {
            let along = machine.remember(&curve, hold, values).unwrap();
            let motions = machine.motion(&along, values).unwrap();
            motions.iter().map(|m| m.acceleration[0]).collect()
        };
        let trail = machine.trail(&curve, hold, &values, Some(&tape)).unwrap();
        let mut at = curve.slice(0..299);
        at.memory = trail.nodes[0].clone();
        let motions = machine.motion(&at, &values).unwrap();
        let slopes = tape.evaluate(&at, &values, &motions);
        for p in 0..4 {
            let h = 1e-6 * values[p];
            let shifted = |h: f64| {
                let mut values = values.clone();
                values[p] += h;
                acceleration(&values)
            };
            let (up, down) = (shifted(h), shifted(-h));
            for k in 0..299 {
                let difference = (up[k] - down[k]) / (2.0 * h);
                let exact = slopes[k].0[(0, p)];
                let scale = 1e-3 * (1.0 + difference.abs()) / values[p].min(1.0);
                assert!(
                    (exact - difference).abs() < scale,
                    "{hold:?} {p} {k}: {exact} {difference}"
                );
            }
        }
    }
}
