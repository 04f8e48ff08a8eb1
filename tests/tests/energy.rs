//! Generated code keeps what the models keep: energy where nothing dissipates, and the
//! constraints. Energies and violations are evaluated on the tape, from the models.

use dynamics::Simulation;
use dynamics::constrained::Baumgarte;
use dynamics::integrate::{DormandPrince, State};
use dynamics_codegen::{System, Tape};
use identify::machine::{Machine, States};
use integration_tests::models;
use std::ops::ControlFlow;

const DURATION: f64 = 10.0;
/// Relative to the total energy at the start.
const ENERGY: f64 = 1e-8;
/// Of `c`, in the constraint's unit.
const VIOLATION: f64 = 1e-10;

/// A model, the values of its parameters, and the tape of its energies.
struct Observed {
    machine: Machine,
    parameters: Vec<f64>,
    energies: Tape,
}

impl Observed {
    /// The nominal model with some parameters changed.
    fn new(name: &str, changes: &[(&str, f64)]) -> Self {
        let compiled = models::one(&format!("{name}.model"));
        let model = &compiled.model;
        let mut parameters = model.nominal_parameters();
        for (name, value) in changes {
            let index = model.parameters.iter().position(|p| p.name == *name);
            parameters[index.unwrap_or_else(|| panic!("no parameter {name}"))] = *value;
        }
        let system = &compiled.system;
        let outputs = [system.kinetic_energy, system.potential_energy];
        let energies = Tape::new(&model.graph, &outputs, &System::arguments(model));
        Self {
            machine: Machine::new(compiled),
            parameters,
            energies,
        }
    }

    /// `(T, V)`, J.
    fn energies(&self, t: f64, q: &[f64], v: &[f64]) -> (f64, f64) {
        let input = vec![0.0; self.machine.input_count()];
        let arguments = [&[t], q, v, &input, &self.parameters].concat();
        let values = self.energies.evaluate(&arguments);
        (values[0], values[1])
    }

    /// `max |c|` and `max |ċ|` (nonholonomic rows count as `c` in both).
    fn violation(&self, t: f64, q: &[f64], v: &[f64]) -> (f64, f64) {
        let column = |values: &[f64]| values.iter().map(|&x| vec![x]).collect();
        let states = States {
            t: vec![t],
            q: column(q),
            v: column(v),
            u: vec![vec![0.0]; self.machine.input_count()],
            ..States::default()
        };
        let terms = self.machine.terms(&states, &self.parameters).remove(0);
        (
            terms.constraint_residual.amax(),
            terms.constraint_rate.amax(),
        )
    }
}

/// What a run did, at its worst.
#[derive(Debug, Default)]
struct Kept {
    /// `|T + V − (T + V)₀| / |T + V|₀`.
    drift: f64,
    /// `max |c|`.
    violation: f64,
    /// `max |ċ|`.
    rate: f64,
    /// Largest change of `T`, relative to the total energy.
    exchange: f64,
    /// Largest way that a coordinate went.
    way: f64,
    /// Accepted steps.
    steps: usize,
}

/// The larger, or not-a-number if either is.
fn worse(a: f64, b: f64) -> f64 {
    if a.is_nan() || b.is_nan() {
        f64::NAN
    } else {
        a.max(b)
    }
}

macro_rules! run {
    ($module:ident $model:ident, $changes:expr, $q:expr, $v:expr) => {{
        use generated::$module::{INPUTS, Parameters, $model};
        let observed = Observed::new(stringify!($module), &$changes);
        let values = observed.parameters.as_slice().try_into();
        let model = $model {
            parameters: Parameters::from_array(values.expect("as many as the model has")),
        };
        let (mut q, mut v) = ($q, $v);
        observed
            .machine
            .project(0.0, &mut q, &mut v, &observed.parameters);
        let (c, rate) = observed.violation(0.0, &q, &v);
        assert!(c < 1e-13 && rate < 1e-13, "start: c {c:e}, rate {rate:e}");
        let (kinetic, potential) = observed.energies(0.0, &q, &v);
        let total = kinetic + potential;
        let mut kept = Kept::default();
        let solver = DormandPrince {
            relative: 1e-12,
            absolute: 1e-12,
            ..Default::default()
        };
        let simulation = Simulation::new(&model).with_baumgarte(Baumgarte::critical(10.0));
        let start = State { q, v, z: [] };
        let (end, _, _) = simulation
            .integrate(
                &solver,
                (0.0, &start),
                DURATION,
                |_, _| [0.0; INPUTS],
                |segment| {
                    let (t, y) = (segment.end_time(), segment.end());
                    let (now, height) = observed.energies(t, &y.q, &y.v);
                    let (c, rate) = observed.violation(t, &y.q, &y.v);
                    kept.drift = worse(kept.drift, (now + height - total).abs() / total.abs());
                    kept.exchange = worse(kept.exchange, (now - kinetic).abs() / total.abs());
                    kept.violation = worse(kept.violation, c);
                    kept.rate = worse(kept.rate, rate);
                    let way = y.q.iter().zip(&start.q).map(|(a, b)| (a - b).abs());
                    kept.way = way.fold(kept.way, worse);
                    kept.steps += 1;
                    ControlFlow::Continue(())
                },
            )
            .unwrap_or_else(|e| panic!("{e}"));
        assert_eq!(end, DURATION);
        println!("{}: {kept:?}", stringify!($module));
        kept
    }};
}

/// Energy is kept while it goes back and forth between its two forms.
fn keeps_energy(kept: &Kept) {
    assert!(kept.drift <= ENERGY, "{kept:?}");
    assert!(kept.exchange > 0.1, "nothing goes on: {kept:?}");
}

fn keeps_constraints(kept: &Kept) {
    assert!(kept.violation <= VIOLATION, "{kept:?}");
    assert!(kept.way > 0.1, "nothing moves: {kept:?}");
}

#[test]
fn pendulum() {
    keeps_energy(&run!(pendulum Pendulum, [], [2.5], [1.0]));
}

#[test]
fn pendulum2() {
    keeps_energy(&run!(pendulum2 Pendulum2, [], [2.0, -0.5], [1.0, 0.5]));
}

#[test]
fn cartpole() {
    keeps_energy(&run!(cartpole Cartpole, [], [0.2, 2.0], [0.5, 1.0]));
}

#[test]
fn duffing_free_without_dampers() {
    let undamped = [("c1", 0.0), ("c2", 0.0)];
    keeps_energy(&run!(duffing_free DuffingFree, undamped, [1.0, -0.4], [0.3, 0.8]));
}

/// The dampers of the nominal model take energy out: the measure above sees it.
#[test]
fn duffing_free_with_dampers_loses_energy() {
    let kept = run!(duffing_free DuffingFree, [], [1.0, -0.4], [0.3, 0.8]);
    assert!(kept.drift > 0.1, "{kept:?}");
}

#[test]
fn surface_particle() {
    let kept = run!(surface_particle SurfaceParticle, [], [2.0, -1.5, 0.5], [0.5, 1.0, 0.0]);
    keeps_energy(&kept);
    keeps_constraints(&kept);
}

#[test]
fn fourbar() {
    let kept = run!(fourbar Fourbar, [], [0.8, -0.2, -2.3], [3.0, -1.0, 0.0]);
    keeps_energy(&kept);
    keeps_constraints(&kept);
}

/// Without a potential the kinetic energy itself is constant.
#[test]
fn unicycle2d() {
    let kept = run!(unicycle2d Unicycle2d, [], [0.0, 0.0, 0.3], [0.5, 0.2, 2.0]);
    assert!(kept.drift <= ENERGY, "{kept:?}");
    keeps_constraints(&kept);
}

/// The law in time does work: only the constraint is kept.
#[test]
fn duffing_constrained() {
    let kept = run!(duffing_constrained DuffingConstrained, [], [0.5, 0.5], [1.0, 0.0]);
    assert!(kept.drift > 0.01, "the law in time does no work: {kept:?}");
    keeps_constraints(&kept);
}

/// At the tolerance above constraints hardly drift by themselves; that stabilisation
/// works shows on a start beside the constraint, which it leaves only with it.
#[test]
fn stabilisation_returns_to_the_constraint() {
    let observed = Observed::new("fourbar", &[]);
    let model = generated::fourbar::Fourbar::<f64>::nominal();
    let (mut q, mut v) = ([0.8, -0.2, -2.3], [3.0, -1.0, 0.0]);
    observed
        .machine
        .project(0.0, &mut q, &mut v, &observed.parameters);
    q[2] += 1e-3;
    let start = State { q, v, z: [] };
    let solver = DormandPrince {
        relative: 1e-12,
        absolute: 1e-12,
        ..Default::default()
    };
    let left = |simulation: Simulation<'_, _, f64, 3, 1, 2, 0>| {
        let on = |_: &_| ControlFlow::Continue(());
        let run = simulation.integrate(&solver, (0.0, &start), DURATION, |_, _| [0.0], on);
        let (_, end, _) = run.unwrap_or_else(|e| panic!("{e}"));
        observed.violation(DURATION, &end.q, &end.v).0
    };
    let free = left(Simulation::new(&model));
    let held = left(Simulation::new(&model).with_baumgarte(Baumgarte::critical(10.0)));
    println!(
        "1e-3 rad beside the constraint, {DURATION} s later: {free:e} m, stabilised {held:e} m"
    );
    assert!(free > 1e-5, "the start is on the constraint: {free:e}");
    assert!(held <= VIOLATION, "{held:e}");
}
