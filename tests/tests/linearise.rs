//! Linearisations agree with CasADi's, projected on the constraint manifold by another route
//! (`casadi/linearised.py`), in the form that does not depend on the basis: `T A L`, `T B`, `T f₀`.

use dynamics::nalgebra::{DMatrix, DVector};
use identify::machine::{Lineariser, Memory, States};
use integration_tests::files::root;
use integration_tests::floating::Floating;
use integration_tests::models;
use serde_json::Value;

/// Of the largest entry of a quantity, or of one.
const TOLERANCE: f64 = 1e-10;

fn numbers(value: &Value) -> Vec<f64> {
    let entries = value.as_array().unwrap().iter();
    entries.map(|x| x.as_f64().unwrap()).collect()
}

fn columns(value: &Value) -> Vec<Vec<f64>> {
    let entries = value.as_array().map(|_| numbers(value)).unwrap_or_default();
    entries.into_iter().map(|x| vec![x]).collect()
}

fn matrix(value: &Value) -> DMatrix<f64> {
    let rows: Vec<Vec<f64>> = value.as_array().unwrap().iter().map(numbers).collect();
    let width = rows.first().map_or(0, Vec::len);
    DMatrix::from_row_iterator(rows.len(), width, rows.into_iter().flatten())
}

fn check(place: &str, found: &DMatrix<f64>, expected: &DMatrix<f64>) {
    assert_eq!(found.shape(), expected.shape(), "{place}");
    if found.is_empty() {
        return;
    }
    let off = (found - expected).amax() / expected.amax().max(1.0);
    assert!(off <= TOLERANCE, "{place}: off by {off:.1e}");
}

fn agrees(name: &str) {
    let path = root().join(format!("tests/casadi/expected/linearised_{name}.json"));
    let file: Value = serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap();
    let lineariser = Lineariser::new(models::one(&format!("{name}.model")));
    let cases = file["cases"].as_array().unwrap();
    assert_eq!(cases.len(), 10);
    for (k, case) in cases.iter().enumerate() {
        let state = States {
            t: vec![case["t"].as_f64().unwrap()],
            q: columns(&case["q"]),
            v: columns(&case["v"]),
            u: columns(&case["u"]),
            memory: Memory {
                z: columns(&case["z"]),
                delayed: columns(&case["late"]),
                delay_rate: vec![vec![0.0]; columns(&case["late"]).len()],
                ..Memory::default()
            },
            ..States::default()
        };
        let parameters: Vec<f64> = file["parameters"]
            .as_array()
            .unwrap()
            .iter()
            .map(|name| case["parameters"][name.as_str().unwrap()].as_f64().unwrap())
            .collect();
        let found = lineariser.at(&state, &parameters).unwrap();
        let r = case["free"].as_u64().unwrap() as usize;
        assert_eq!(found.a.shape(), (r, r), "{name} {k}");
        let (t, l) = (&found.basis, &found.chart);
        let column = |v: &DVector<f64>| DMatrix::from_column_slice(v.len(), 1, v.as_slice());
        let vector = |key: &str| column(&DVector::from_vec(numbers(&case[key])));
        let place = |what: &str| format!("{name}, state {k}, {what}");
        check(&place("L T"), &(l * t), &DMatrix::identity(r, r));
        check(&place("T L"), &(t * l), &matrix(&case["P"]));
        check(&place("A"), &(t * &found.a * l), &matrix(&case["PFP"]));
        check(&place("B"), &(t * &found.b), &matrix(&case["PG"]));
        check(&place("f"), &(t * column(&found.drift)), &vector("Pf"));
        let sampled = found.sampled(file["hold"].as_f64().unwrap()).unwrap();
        let place = |what: &str| place(&format!("sampled {what}"));
        check(
            &place("A"),
            &(t * &sampled.a * l),
            &matrix(&case["sampled_A"]),
        );
        check(&place("B"), &(t * &sampled.b), &matrix(&case["sampled_B"]));
        check(
            &place("f"),
            &(t * column(&sampled.drift)),
            &vector("sampled_f"),
        );
    }
}

#[test]
fn a_free_machine_agrees_with_casadi() {
    agrees("cartpole");
}

#[test]
fn a_closed_chain_agrees_with_casadi() {
    agrees("fourbar");
}

#[test]
fn rolling_machines_agree_with_casadi() {
    agrees("unicycle2d");
    agrees("wheelbot");
}

/// An internal state, a delayed input and friction that depends on the multiplier.
#[test]
fn a_machine_that_remembers_agrees_with_casadi() {
    agrees("bead");
}

/// A quadruped that floats by its twist: displacements are seen from its base, which moves on.
#[test]
fn a_robot_that_floats_agrees_with_pinocchio() {
    let mut robot = Floating::read("solo12");
    let lineariser = Lineariser::new(robot.compiled.clone());
    let n = robot.compiled.model.coordinates.len();
    let columns = |values: Vec<f64>| values.into_iter().map(|x| vec![x]).collect();
    for state in robot.states() {
        let found = States {
            t: vec![0.0],
            q: columns(robot.positions(&state, "q")),
            v: columns(robot.velocities(&state, "v")),
            u: columns(robot.inputs(&state)),
            ..States::default()
        };
        let found = lineariser.at(&found, &[]).unwrap();
        assert_eq!(found.basis, DMatrix::identity(2 * n, 2 * n));
        let block = |matrix: &DMatrix<f64>, place: (usize, usize), size: (usize, usize)| {
            matrix.view(place, size).into_owned()
        };
        let rows = |matrix: DMatrix<f64>| matrix.transpose().as_slice().to_vec();
        let mut carried = DMatrix::zeros(n, n);
        carried
            .view_mut((0, 0), (6, 6))
            .copy_from(&matrix(&state["carried"]));
        check("carried", &block(&found.a, (0, 0), (n, n)), &carried);
        let still = DMatrix::identity(n, n);
        check("moved", &block(&found.a, (0, n), (n, n)), &still);
        let inputs = found.b.ncols();
        let none = DMatrix::zeros(n, inputs);
        check(
            "displaced by inputs",
            &block(&found.b, (0, 0), (n, inputs)),
            &none,
        );
        robot.check(&state, "da_dq", &rows(block(&found.a, (n, 0), (n, n))));
        robot.check(&state, "da_dv", &rows(block(&found.a, (n, n), (n, n))));
        robot.check_by_input(&state, &rows(block(&found.b, (n, 0), (n, inputs))));
        robot.check(&state, "v", &found.drift.as_slice()[..n]);
        robot.check(&state, "a", &found.drift.as_slice()[n..]);
        // The foot's position by displacements, its velocity by velocities.
        let place = rows(block(&found.c, (0, 0), (3, n)));
        robot.check_jacobian(&state, "FL_FOOT", &place);
        let velocity = rows(block(&found.c, (3, n), (3, n)));
        robot.check_jacobian(&state, "FL_FOOT", &velocity);
    }
    println!("{}", robot.summary());
}

/// Outputs of position, velocity, input and state, against derivatives by hand.
#[test]
fn outputs_of_a_pendulum_are_those_of_the_textbook() {
    let text = "model m;\ncoordinate phi: rad;\ninput u: N*m;\nstate z: 1 = 0.3;\n\
        parameter l: m = 0.5;\nkinetic dot(phi)^2/2*kilo;\nconstant kilo: kg*m^2 = 2;\n\
        force phi = input(u);\ndot(z) == -z*rate;\nconstant rate: 1/s = 4;\n\
        output height = -l*cos(phi);\noutput speed = l*dot(phi)*cos(phi);\noutput mixed = z*u;\n";
    let library = dynamics_codegen::Library::builtin();
    let compiled = dynamics_codegen::compile_bytes("m.model", text.as_bytes(), &library).unwrap();
    let lineariser = Lineariser::new(compiled);
    let (phi, rate, u, z) = (0.4_f64, 1.5, 7.0, 0.3);
    let state = States {
        t: vec![0.0],
        q: vec![vec![phi]],
        v: vec![vec![rate]],
        u: vec![vec![u]],
        ..States::default()
    };
    let found = lineariser.at(&state, &[0.5]).unwrap();
    let (s, c) = phi.sin_cos();
    check(
        "A",
        &found.a,
        &matrix(&serde_json::json!([[0, 1, 0], [0, 0, 0], [0, 0, -4]])),
    );
    check(
        "B",
        &found.b,
        &matrix(&serde_json::json!([[0], [0.5], [0]])),
    );
    let slopes = [
        [0.5 * s, 0.0, 0.0],
        [-0.5 * rate * s, 0.5 * c, 0.0],
        [0.0, 0.0, u],
    ];
    check("C", &found.c, &matrix(&serde_json::json!(slopes)));
    check(
        "D",
        &found.d,
        &matrix(&serde_json::json!([[0.0], [0.0], [z]])),
    );
    let values = [-0.5 * c, 0.5 * rate * c, z * u];
    assert!(
        found
            .outputs
            .iter()
            .zip(values)
            .all(|(y, expected)| (y - expected).abs() < 1e-15)
    );
}
