//! Emitted derivatives, function by function, against programs that share no code with ours:
//! Pinocchio for three arms, an independent derivation for the Wheelbot.
//!
//! Neither gives `∂M, ∂Q_C, ∂A, ∂b` by themselves. They are put into the derivative of the
//! equation of motion, where everything else is theirs:
//! `∂τ/∂q = (∂M/∂q) a − ∂Q_C/∂q` and `∂τ/∂v = −∂Q_C/∂v` at an acceleration that has nothing to
//! do with the state, and `M ∂a + ∂M a = ∂Q_C + ∂Aᵀ λ + Aᵀ ∂λ`, `A ∂a + ∂A a = ∂b`.

use super::full::{call_iiwa7, call_iiwa7_plane, call_panda, call_wheelbot};
use super::{Call, largest};
use dynamics::nalgebra::{DMatrix, DVector, Matrix3, Vector3};
use integration_tests::reference::Deviations;
use integration_tests::{files::root, models};
use serde_json::Value;
use std::path::Path;

/// Where nothing is differentiated, less what inverting `M` costs.
const VALUES: f64 = 1e-10;
const ARMS: f64 = 1e-8;
const WHEELBOT: f64 = 1e-7;

fn numbers(value: &Value) -> Vec<f64> {
    match value {
        Value::Array(items) => items.iter().flat_map(numbers).collect(),
        number => vec![number.as_f64().expect("a number")],
    }
}

fn read(path: &Path) -> Value {
    let text = std::fs::read_to_string(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    serde_json::from_str(&text).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}

/// `Σ_j slopes[i][j][k] factor[j]`, row by row: a derivative of a matrix times a vector.
fn contracted(slopes: &[f64], factor: &[f64], variables: usize) -> DMatrix<f64> {
    let rows = slopes.len() / (factor.len() * variables);
    DMatrix::from_fn(rows, variables, |i, k| {
        let entry = |j: usize| slopes[(i * factor.len() + j) * variables + k];
        (0..factor.len()).map(|j| entry(j) * factor[j]).sum()
    })
}

fn by_rows(matrix: &DMatrix<f64>) -> Vec<f64> {
    matrix.transpose().as_slice().to_vec()
}

/// Their names of an arm's quantities: `v`, the stated acceleration, forward dynamics, and the
/// derivatives of both.
struct Names {
    velocity: &'static str,
    stated: &'static str,
    by_velocity: &'static str,
    motion: [&'static str; 4],
}

fn check_arm(name: &str, call: Call<f64>, expected: &Value, names: &Names) {
    let states = expected["states"].as_array().expect("states");
    let mut worst = Deviations::default();
    for (index, state) in states.iter().enumerate() {
        let of = |key: &str| numbers(&state[key]);
        let (q, v, a) = (of("q"), of(names.velocity), of(names.stated));
        let n = q.len();
        let arguments = [vec![0.0], q, v, of("tau"), a.clone()].concat();
        let call = |function: &str| call(function, &arguments);
        let place = format!("{name}, state {index}");
        let mut check = |key: &str, what: &str, found: &[f64]| {
            worst.check((&place, what), found, &of(key), ARMS);
        };
        let (by_position, by_velocity) = ("dtau_dq", names.by_velocity);
        let inverse = call("inverse_dynamics_derivatives");
        check(by_position, "∂ID/∂q", &inverse[0]);
        check(by_velocity, "∂ID/∂v", &inverse[1]);
        check("tau_id", "ID", &call("inverse_dynamics")[0]);
        let both = call("mass_matrix_and_bias_force");
        check("M", "M", &both[0]);
        let forward = call("forward_dynamics_derivatives");
        for (place, (key, what)) in names
            .motion
            .iter()
            .zip(["a", "∂FD/∂q", "∂FD/∂v", "∂FD/∂u"])
            .enumerate()
        {
            check(key, what, &forward[place]);
        }
        check(names.motion[0], "FD", &call("forward_dynamics")[0]);
        // R = M a − Q.
        let residual = call("residual_derivatives");
        check(by_position, "∂R/∂q", &residual[0]);
        check(by_velocity, "∂R/∂v", &residual[1]);
        let moved = contracted(&call("mass_matrix_by_position")[0], &a, n);
        let bias = &call("bias_force_by_position")[0];
        let bias = DMatrix::from_row_slice(n, n, bias);
        check(by_position, "∂M a − ∂Q_C/∂q", &by_rows(&(moved - bias)));
        let bias = &call("bias_force_by_velocity")[0];
        let bias: Vec<f64> = bias.iter().map(|x| -x).collect();
        check(by_velocity, "−∂Q_C/∂v", &bias);
    }
    assert!(states.len() >= 20, "only {} states", states.len());
    println!("{name}, emitted: {}", worst.summary());
}

#[test]
fn iiwa7_agrees_with_pinocchio() {
    // The model rounds what the oracle of this name has rounded.
    let Some(path) = left_out::shared("oracles/oracle_iiwa_snap.json") else {
        return;
    };
    let names = Names {
        velocity: "qd",
        stated: "qdd_in",
        by_velocity: "dtau_dqd",
        motion: ["qdd", "dqdd_dq", "dqdd_dqd", "Minv"],
    };
    check_arm("iiwa7", call_iiwa7::call, &read(&path), &names);
}

#[test]
fn panda_agrees_with_pinocchio() {
    let expected = read(&root().join("tests/pinocchio/expected/panda.json"));
    let names = Names {
        velocity: "v",
        stated: "a_in",
        by_velocity: "dtau_dv",
        motion: ["a", "da_dq", "da_dv", "da_dtau"],
    };
    check_arm("panda", call_panda::call, &expected, &names);
}

/// The arm on a plane: its constraint made of Pinocchio's frame, Jacobian and drift of the
/// flange, and the motion solved from Pinocchio's `M` and bias.
#[test]
fn an_arm_on_a_plane_agrees_with_pinocchio() {
    const TOOL: f64 = 0.12;
    let Some(path) = left_out::shared("oracles/oracle_iiwa_snap.json") else {
        return;
    };
    let oracle = read(&path);
    let normal = Vector3::new(0.3, -0.2, 0.9);
    let parameters = [TOOL, normal.x, normal.y, normal.z, 0.5];
    let mut worst = Deviations::default();
    let states = oracle["states"].as_array().expect("states");
    for (index, state) in states.iter().enumerate() {
        let of = |key: &str| numbers(&state[key]);
        let flange = DMatrix::from_row_slice(6, 7, &of("J"));
        let (linear, angular) = (flange.rows(0, 3), flange.rows(3, 3));
        let tool = Matrix3::from_row_slice(&of("ee_R")) * Vector3::new(0.0, 0.0, TOOL);
        let jacobian = linear - tool.cross_matrix() * angular;
        let velocity = DVector::from_vec(of("qd"));
        let turn: Vector3<f64> = (angular * &velocity).fixed_rows::<3>(0).into_owned();
        let drift = of("Jdot_qd");
        let drift = Vector3::from_column_slice(&drift[..3])
            + Vector3::from_column_slice(&drift[3..]).cross(&tool)
            + turn.cross(&turn.cross(&tool));
        let row = normal.transpose() * jacobian;
        let b = -normal.dot(&drift);
        let inverse = DMatrix::from_row_slice(7, 7, &of("Minv"));
        let force = DVector::from_vec(of("tau")) - DVector::from_vec(of("bias"));
        let mobility = (&row * &inverse * row.transpose())[(0, 0)];
        let lambda = (b - (&row * &inverse * &force)[(0, 0)]) / mobility;
        let a = &inverse * (force + row.transpose() * lambda);
        let by_input = &inverse - &inverse * row.transpose() * &row * &inverse / mobility;

        let own = [vec![0.0], of("q"), of("qd"), of("tau"), parameters.to_vec()].concat();
        let arguments = [own, vec![0.0; 8]].concat();
        let call = |function: &str| call_iiwa7_plane::call(function, &arguments);
        let place = format!("iiwa7_plane, state {index}");
        let mut check = |what: &str, found: &[f64], expected: &[f64]| {
            worst.check((&place, what), found, expected, VALUES);
        };
        check("A", &call("constraint_jacobian")[0], row.as_slice());
        check("b", &call("constraint_bias")[0], &[b]);
        let motion = call("constrained_dynamics_derivatives");
        check("a", &motion[0], a.as_slice());
        check("λ", &motion[1], &[lambda]);
        check("∂a/∂u", &motion[4], &by_rows(&by_input));
        let motion = call("constrained_dynamics");
        check("a", &motion[0], a.as_slice());
        check("λ", &motion[1], &[lambda]);
    }
    println!("iiwa7_plane, emitted: {}", worst.summary());
}

/// One case of the Wheelbot: their figures, and our functions there.
struct Wheelbot<'a> {
    case: &'a Value,
    arguments: Vec<f64>,
}

impl Wheelbot<'_> {
    fn theirs(&self, key: &str, rows: usize) -> DMatrix<f64> {
        let values = numbers(&self.case[key]);
        DMatrix::from_row_slice(rows, values.len() / rows, &values)
    }

    fn ours(&self, function: &str) -> Vec<f64> {
        let found = call_wheelbot::call(function, &self.arguments);
        let [only] = &found[..] else {
            panic!("{function} gives {} quantities", found.len())
        };
        only.clone()
    }

    /// How the equation of motion changes with the state, ours where a term is
    /// differentiated, theirs elsewhere: what the multipliers' derivative has to balance,
    /// and what has to vanish. Each with the size of what it is a difference of.
    fn equation(&self, by: &str, slope: &str) -> [(DMatrix<f64>, f64); 2] {
        let (a, lambda) = (self.theirs("qdd", 7), self.theirs("lambda_", 1));
        let (m, jacobian) = (self.theirs("M", 7), self.theirs("A", lambda.len()));
        let slope = self.theirs(slope, 7);
        let bias = DMatrix::from_row_slice(7, 7, &self.ours(&format!("bias_force_by_{by}")));
        let drift = self.ours(&format!("constraint_bias_by_{by}"));
        let drift = DMatrix::from_row_slice(lambda.len(), 7, &drift);
        let size = |summands: &[&DMatrix<f64>]| {
            let sizes = summands.iter().map(|m| largest(m.as_slice()));
            // One case is at rest, where nothing changes.
            sizes.fold(1e-6, f64::max)
        };
        let mut force = &m * &slope - &bias;
        let mut motion = &jacobian * &slope - &drift;
        let sizes = [
            size(&[&(&m * &slope), &bias]),
            size(&[&(&jacobian * &slope), &drift]),
        ];
        if by == "position" {
            force += contracted(&self.ours("mass_matrix_by_position"), a.as_slice(), 7);
            let slopes = self.ours("constraint_jacobian_by_position");
            motion += contracted(&slopes, a.as_slice(), 7);
            force -= DMatrix::from_fn(7, 7, |j, k| {
                let entry = |i: usize| slopes[(i * 7 + j) * 7 + k];
                (0..lambda.len()).map(|i| entry(i) * lambda[i]).sum()
            });
        }
        [(force, sizes[0]), (motion, sizes[1])]
    }
}

#[test]
fn the_wheelbot_agrees_with_an_independent_derivation() {
    let Some(path) = left_out::shared("oracles/wheelbot.json") else {
        return;
    };
    let oracle = read(&path);
    let compiled = models::one("wheelbot.model");
    let parameters = &compiled.model.parameters;
    let mut worst = Deviations::default();
    let cases = oracle["cases"].as_array().expect("cases");
    assert_eq!(cases.len(), 20);
    for case in cases {
        let of = |key: &str| numbers(&case[key]);
        let set = &oracle["param_sets"][case["params"].as_str().expect("a name")];
        let values = parameters.iter().map(|p| numbers(&set[&p.name])[0]);
        let multipliers = of("lambda_");
        let state = [vec![0.0], of("q"), of("qd"), of("u"), values.collect()];
        let arguments = [state.concat(), of("qdd"), multipliers.clone()].concat();
        let bot = Wheelbot { case, arguments };
        let place = format!("wheelbot, case {}", case["id"]);
        // What is zero comes out as rounding of what it is a difference of.
        let mut check = |what: &str, found: &[f64], expected: &[f64], floor: f64| {
            let with_floor = |values: &[f64]| [values, &[floor]].concat();
            let (found, expected) = (with_floor(found), with_floor(expected));
            worst.check((&place, what), &found, &expected, WHEELBOT);
        };
        let motion = call_wheelbot::call("constrained_dynamics_derivatives", &bot.arguments);
        let floor = (1e-3 * largest(&of("qdd"))).max(1e-6);
        check("a", &motion[0], &of("qdd"), floor);
        check("λ", &motion[1], &multipliers, 1e-3 * largest(&multipliers));
        for (index, key) in ["dqdd_dq", "dqdd_dqd", "dqdd_du"].into_iter().enumerate() {
            check(key, &motion[2 + index], &of(key), floor);
        }
        let m = multipliers.len();
        let transposed = bot.theirs("A", m).transpose();
        let groups = [
            ("position", "dqdd_dq", "∂q"),
            ("velocity", "dqdd_dqd", "∂v"),
        ];
        for (index, (by, slope, name)) in groups.into_iter().enumerate() {
            let [(force, force_size), (motion_rows, motion_size)] = bot.equation(by, slope);
            let zero = vec![0.0; motion_rows.len()];
            check(
                &format!("A ∂a + ∂A a − ∂b, {name}"),
                motion_rows.as_slice(),
                &zero,
                motion_size,
            );
            let slope = DMatrix::from_row_slice(m, 7, &motion[5 + index]);
            let balance = &transposed * slope;
            check(
                &format!("M ∂a + ∂M a − ∂Q_C − ∂Aᵀ λ = Aᵀ ∂λ, {name}"),
                &by_rows(&balance),
                &by_rows(&force),
                force_size,
            );
            // The same without our derivative of the multipliers.
            let gram = transposed.transpose() * &transposed;
            let gram = gram.lu();
            for column in force.column_iter() {
                let column: DVector<f64> = column.into_owned();
                let fitted = gram
                    .solve(&(transposed.transpose() * &column))
                    .expect("full rank");
                let left = &column - &transposed * fitted;
                let zero = vec![0.0; 7];
                check(
                    &format!("its part without λ, {name}"),
                    left.as_slice(),
                    &zero,
                    force_size,
                );
            }
        }
    }
    println!("wheelbot, emitted: {}", worst.summary());
}
