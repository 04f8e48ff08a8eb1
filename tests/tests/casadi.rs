//! The terms of the equation of motion, the motion and its derivatives are those that
//! CasADi derives from energies and constraints stated apart from the models.

use dynamics::constrained::Tolerance;
use dynamics::nalgebra::{DMatrix, DVector};
use dynamics::{Point, System as _};
use dynamics_codegen::derive::Variable;
use dynamics_codegen::model::ConstraintKind;
use identify::machine::{Machine, Motion, States, Terms};
use integration_tests::models;
use integration_tests::reference::{Case, Deviations, Reference};

/// Fewest states of a model: a big one has few.
const STATES: usize = 10;
/// Relative to the largest entry of the quantity.
const VALUES: f64 = 1e-10;
const DERIVATIVES: f64 = 1e-8;
/// Some derivatives are zero (`∂a/∂v` of the pendulum, some of the unicycle's on the
/// constraint) and come out as rounding here or there. A derivative counts as at least
/// this share of what is differentiated: 1e-13 of it is the least that is allowed.
const FLOOR: f64 = 1e-5;

/// A model's machine, with the file's order of names checked against it.
fn machine(reference: &Reference) -> Machine {
    let compiled = models::one(&format!("{}.model", reference.model));
    let model = &compiled.model;
    let names: Vec<&str> = model.coordinates.iter().map(|c| c.name.as_str()).collect();
    assert_eq!(names, reference.coordinates);
    let names: Vec<&str> = model.inputs.iter().map(|u| u.name.as_str()).collect();
    assert_eq!(names, reference.inputs);
    let names: Vec<&str> = model.parameters.iter().map(|p| p.name.as_str()).collect();
    assert_eq!(names, reference.parameters);
    assert!(reference.cases.len() >= STATES);
    Machine::new(compiled)
}

fn parameters(reference: &Reference, case: &Case) -> Vec<f64> {
    let names = reference.parameters.iter();
    names.map(|name| case.parameter(name)).collect()
}

fn states(case: &Case) -> States {
    let columns = |key: &str| case.numbers(key).into_iter().map(|x| vec![x]).collect();
    States {
        t: vec![case.time()],
        q: columns("q"),
        v: columns("v"),
        u: columns("u"),
        ..States::default()
    }
}

fn by_rows(matrix: &DMatrix<f64>) -> Vec<f64> {
    matrix.transpose().as_slice().to_vec()
}

/// `ċ` of the holonomic rows; the others have none.
fn rates(terms: &Terms, case: &Case, kinds: &[ConstraintKind]) -> (Vec<f64>, Vec<f64>) {
    let (mut found, mut expected) = (Vec::new(), Vec::new());
    for (row, rate) in case.entries("c_dot").into_iter().enumerate() {
        let holonomic = kinds[row] == ConstraintKind::Holonomic;
        assert_eq!(rate.is_some(), holonomic, "{}: row {row}", case.place());
        if let Some(rate) = rate {
            found.push(terms.constraint_rate[row]);
            expected.push(rate);
        }
    }
    (found, expected)
}

/// A quantity that is zero but for rounding at some states counts as at least `floor`.
fn check_above(
    worst: &mut Deviations,
    at: (&str, &str),
    found: &[f64],
    expected: &[f64],
    (tolerance, floor): (f64, f64),
) {
    let with_floor = |values: &[f64]| [values, &[floor]].concat();
    worst.check(at, &with_floor(found), &with_floor(expected), tolerance);
}

/// The largest entry of a quantity in the whole file.
fn size(reference: &Reference, key: &str) -> f64 {
    let entries = reference.cases.iter().flat_map(|case| case.entries(key));
    entries.flatten().fold(0.0, |m: f64, x| m.max(x.abs()))
}

fn check_terms(worst: &mut Deviations, case: &Case, terms: &Terms) {
    let mut check = |name, found: &[f64]| {
        worst.check((case.place(), name), found, &case.numbers(name), VALUES);
    };
    check("M", &by_rows(&terms.mass_matrix));
    check("bias", terms.bias_force.as_slice());
    check("Q", terms.force.as_slice());
    check("B", &by_rows(&terms.input_matrix));
    check("A", &by_rows(&terms.constraint_matrix));
    check("b", terms.constraint_bias.as_slice());
    // Q_C + Q_D + B u = Q: these three are what the file tells apart.
    let input = DVector::from_vec(case.numbers("u"));
    let sum = &terms.bias_force + &terms.applied_force + &terms.input_matrix * input;
    check("Q", sum.as_slice());
}

/// `(∂a/∂s, ∂λ/∂s)` against the file, for each group of variables.
fn check_derivatives(
    worst: &mut Deviations,
    machine: &mut Machine,
    reference: &Reference,
    motions: &[Motion],
) {
    let (n, k) = (machine.coordinate_count(), machine.input_count());
    let groups: [(&str, Vec<Variable>); 5] = [
        ("q", (0..n).map(Variable::Position).collect()),
        ("v", (0..n).map(Variable::Velocity).collect()),
        ("u", (0..k).map(Variable::Input).collect()),
        ("t", vec![Variable::Time]),
        (
            "p",
            (0..reference.parameters.len())
                .map(Variable::Parameter)
                .collect(),
        ),
    ];
    for (group, variables) in groups {
        let tape = machine.sensitivity(&variables);
        let keys = [format!("da_d{group}"), format!("dlambda_d{group}")];
        for (case, motion) in reference.cases.iter().zip(motions) {
            let motion = std::slice::from_ref(motion);
            let found = tape.evaluate(&states(case), &parameters(reference, case), motion);
            for (key, found) in keys.iter().zip([&found[0].0, &found[0].1]) {
                let expected = case.numbers(key);
                let of = case.numbers(if key.starts_with("da") { "a" } else { "lambda" });
                let floor = FLOOR * of.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
                let allowed = (DERIVATIVES, floor);
                let at = (case.place(), key.as_str());
                check_above(worst, at, &by_rows(found), &expected, allowed);
            }
        }
    }
}

/// The in-process back end.
fn tape_agrees(name: &str) {
    let reference = Reference::read(name);
    let mut machine = machine(&reference);
    let kinds = machine.constraint_kinds().to_vec();
    // On the constraint these are rounding: the size that they have off it counts.
    let floors = ["c", "c_dot"].map(|key| size(&reference, key));
    let mut worst = Deviations::default();
    let mut motions = Vec::new();
    for case in &reference.cases {
        let at = states(case);
        let motion = machine.motion(&at, &parameters(&reference, case));
        let motion = motion.unwrap_or_else(|e| panic!("{}: {e}", case.place()));
        let motion = motion.into_iter().next().expect("one state, one motion");
        let terms = &motion.terms;
        check_terms(&mut worst, case, terms);
        let (c, expected) = (terms.constraint_residual.as_slice(), case.numbers("c"));
        let allowed = (VALUES, floors[0]);
        check_above(&mut worst, (case.place(), "c"), c, &expected, allowed);
        let (rate, expected) = rates(terms, case, &kinds);
        let allowed = (VALUES, floors[1]);
        check_above(
            &mut worst,
            (case.place(), "c_dot"),
            &rate,
            &expected,
            allowed,
        );
        let (a, lambda) = (&motion.acceleration, &motion.multiplier);
        let mut check = |name, found: &[f64]| {
            worst.check((case.place(), name), found, &case.numbers(name), VALUES);
        };
        check("a", a.as_slice());
        check("lambda", lambda.as_slice());
        motions.push(motion);
    }
    check_derivatives(&mut worst, &mut machine, &reference, &motions);
    println!("{name}, tape: {}", worst.summary());
}

fn array<const N: usize>(values: &[f64]) -> [f64; N] {
    values.try_into().expect("as many as the model has")
}

macro_rules! agree {
    ($($module:ident $model:ident;)*) => {
        /// The models that are compared.
        const COMPARED: &[&str] = &[$(stringify!($module)),*];

        $(mod $module {
            use super::*;
            use generated::$module::{
                self as module, CONSTRAINTS, COORDINATES, INPUTS, Parameters,
            };

            #[test]
            fn tape() {
                tape_agrees(stringify!($module));
            }

            #[test]
            fn generated_code() {
                let reference = Reference::read(stringify!($module));
                assert!(reference.cases.len() >= STATES);
                assert_eq!(module::COORDINATE_NAMES.as_slice(), reference.coordinates);
                assert_eq!(module::INPUT_NAMES.as_slice(), reference.inputs);
                assert_eq!(module::PARAMETER_NAMES.as_slice(), reference.parameters);
                let mut worst = Deviations::default();
                for case in &reference.cases {
                    let model = module::$model {
                        parameters: Parameters::from_array(array(&parameters(&reference, case))),
                    };
                    let x = Point::<f64, COORDINATES, INPUTS, 0> {
                        t: case.time(),
                        q: array(&case.numbers("q")),
                        v: array(&case.numbers("v")),
                        u: array(&case.numbers("u")),
                        z: [],
                    };
                    let mut check = |name, found: &[f64]| {
                        worst.check((case.place(), name), found, &case.numbers(name), VALUES);
                    };
                    check("M", &module::mass_matrix(&model.parameters, &x).concat());
                    check("bias", &module::bias_force(&model.parameters, &x));
                    check("Q", &module::force(&model.parameters, &x));
                    check("B", &module::input_matrix(&model.parameters, &x).concat());
                    let constraint: dynamics::Constraint<f64, COORDINATES, CONSTRAINTS> =
                        model.constraint(&x);
                    check("A", constraint.a.transpose().as_slice());
                    check("b", constraint.b.as_slice());
                    let motion = dynamics::acceleration(&model, &x, None, &Tolerance::default());
                    let motion = motion.unwrap_or_else(|e| panic!("{}: {e}", case.place()));
                    check("a", motion.a.as_slice());
                    check("lambda", motion.lambda.as_slice());
                }
                println!("{}, generated: {}", stringify!($module), worst.summary());
            }
        })*
    };
}

agree! {
    cartpole Cartpole;
    delta Delta;
    duffing_constrained DuffingConstrained;
    duffing_free DuffingFree;
    fourbar Fourbar;
    pendulum Pendulum;
    pendulum2 Pendulum2;
    surface_particle SurfaceParticle;
    unicycle2d Unicycle2d;
}

/// Every model that is a text by itself has a file and is compared. `tests/robots.rs`
/// compares robot descriptions with Pinocchio, and the Wheelbot with a derivation of its
/// own; `tests/bead.rs` the bead, which remembers and rubs, with its file.
#[test]
fn no_model_is_left_out() {
    let names: Vec<String> = models::all()
        .into_iter()
        .filter(|(_, compiled)| compiled.model.robot.is_none())
        .filter(|(_, compiled)| !["wheelbot", "bead"].contains(&compiled.model.name.as_str()))
        .map(|(_, compiled)| compiled.model.name)
        .collect();
    assert_eq!(names, COMPARED);
}
