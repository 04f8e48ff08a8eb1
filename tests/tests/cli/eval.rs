//! `dynamics eval`, against formulas that share nothing with it.

use crate::support::{eval, gap, matrix, root, succeed, vector};
use serde_json::{Value, json};
use std::io::{BufRead, BufReader, Write};
use std::process::{Command, Stdio};

const PENDULUM: &str = "models/pendulum2.model";

#[test]
fn text_for_people() {
    let states = "{\"q\": [0.1, 0.2]}\n\n{\"q\": {\"j1\": 1, \"j2\": 0}, \"v\": {\"j2\": 2}}\n";
    let (page, _) = succeed(&["eval", PENDULUM, "--states", "-"], states);
    insta::assert_snapshot!(page);
}

#[test]
fn json_of_a_constrained_model() {
    let states = "{\"q\": [0.3, 0.1], \"v\": [1, -1], \"t\": 0.5}\n";
    let flags = ["--states", "-", "--json", "--derivatives"];
    let (line, _) = succeed(
        &[&["eval", "models/duffing_constrained.model"], &flags[..]].concat(),
        states,
    );
    let answer: Value = serde_json::from_str(&line).unwrap();
    let names: Vec<&String> = answer.as_object().unwrap().keys().collect();
    insta::assert_snapshot!(format!("{names:?}"));
}

/// The textbook's double pendulum: `M`, `Q_C` and `a`.
fn textbook(
    p: &[f64; 9],
    q: [f64; 2],
    v: [f64; 2],
    u: [f64; 2],
) -> ([[f64; 2]; 2], [f64; 2], [f64; 2]) {
    let [m1, l1, lc1, i1, m2, _, lc2, i2, g] = *p;
    let (c2, s2) = (q[1].cos(), q[1].sin());
    let coupling = m2 * l1 * lc2;
    let m22 = i2 + m2 * lc2 * lc2;
    let m12 = m22 + coupling * c2;
    let m11 = i1 + m1 * lc1 * lc1 + m22 + m2 * l1 * l1 + 2.0 * coupling * c2;
    let tip = m2 * g * lc2 * (q[0] + q[1]).sin();
    let bias = [
        coupling * s2 * (2.0 * v[0] * v[1] + v[1] * v[1])
            - (m1 * lc1 + m2 * l1) * g * q[0].sin()
            - tip,
        -coupling * s2 * v[0] * v[0] - tip,
    ];
    let (f0, f1) = (bias[0] + u[0], bias[1] + u[1]);
    let determinant = m11 * m22 - m12 * m12;
    let a = [
        (m22 * f0 - m12 * f1) / determinant,
        (m11 * f1 - m12 * f0) / determinant,
    ];
    ([[m11, m12], [m12, m22]], bias, a)
}

const NOMINAL: [f64; 9] = [1.2, 0.45, 0.22, 0.024, 0.8, 0.4, 0.19, 0.012, 9.81];
const NAMES: [&str; 9] = ["m1", "l1", "lc1", "I1", "m2", "l2", "lc2", "I2", "g"];

/// States that go round, more than one batch of them.
fn states() -> Vec<([f64; 2], [f64; 2], [f64; 2])> {
    let wave = |i: usize, k: f64| (i as f64 * k).sin();
    (0..2500)
        .map(|i| {
            let q = [3.0 * wave(i, 0.7), 2.0 * wave(i, 1.3)];
            let v = [5.0 * wave(i, 1.7), 4.0 * wave(i, 2.1)];
            (q, v, [wave(i, 0.3), 2.0 * wave(i, 0.9)])
        })
        .collect()
}

#[test]
fn a_double_pendulum_is_that_of_the_textbook() {
    let lines: String = states()
        .iter()
        .map(|(q, v, u)| format!("{}\n", json!({"q": q, "v": v, "u": u})))
        .collect();
    let answers = eval(PENDULUM, &[], &lines);
    assert_eq!(answers.len(), 2500);
    for (answer, (q, v, u)) in answers.iter().zip(states()) {
        let (m, bias, a) = textbook(&NOMINAL, q, v, u);
        assert!(gap(&matrix(&answer["M"]).concat(), &m.concat()) < 1e-13);
        assert!(gap(&vector(&answer["bias"]), &bias) < 1e-12);
        assert!(gap(&vector(&answer["a"]), &a) < 1e-11);
        assert_eq!(matrix(&answer["B"]), [[1.0, 0.0], [0.0, 1.0]]);
        assert_eq!(vector(&answer["applied"]), [0.0, 0.0]);
        assert!(gap(&vector(&answer["Q"]), &[bias[0] + u[0], bias[1] + u[1]]) < 1e-12);
        assert_eq!(answer["A"], json!([]));
        assert_eq!(answer["lambda"], json!([]));
    }
}

#[test]
fn derivatives_are_those_of_the_textbook() {
    let h = 1e-6;
    let sample: Vec<_> = states().into_iter().step_by(100).collect();
    let lines: String = sample
        .iter()
        .map(|(q, v, u)| format!("{}\n", json!({"q": q, "v": v, "u": u})))
        .collect();
    for (answer, (q, v, u)) in eval(PENDULUM, &["--derivatives"], &lines)
        .iter()
        .zip(sample)
    {
        let close = |column: Vec<f64>, plus: [f64; 2], minus: [f64; 2]| {
            let slope = [
                (plus[0] - minus[0]) / (2.0 * h),
                (plus[1] - minus[1]) / (2.0 * h),
            ];
            assert!(gap(&column, &slope) < 1e-5, "{column:?} {slope:?}");
        };
        let column =
            |name: &str, j: usize| matrix(&answer[name]).iter().map(|row| row[j]).collect();
        let moved = |x: [f64; 2], j: usize, by: f64| {
            let mut x = x;
            x[j] += by;
            x
        };
        for j in 0..2 {
            let at = |by| textbook(&NOMINAL, moved(q, j, by), v, u).2;
            close(column("da_dq", j), at(h), at(-h));
            let at = |by| textbook(&NOMINAL, q, moved(v, j, by), u).2;
            close(column("da_dv", j), at(h), at(-h));
            let at = |by| textbook(&NOMINAL, q, v, moved(u, j, by)).2;
            close(column("da_du", j), at(h), at(-h));
        }
        for (j, name) in NAMES.iter().enumerate() {
            let at = |by| {
                let mut p = NOMINAL;
                p[j] += by;
                textbook(&p, q, v, u).2
            };
            close(vector(&answer["da_dparameters"][name]), at(h), at(-h));
        }
        assert_eq!(vector(&answer["da_dt"]), [0.0, 0.0]);
    }
}

/// A bead on a ring in Cartesian coordinates: `λ = m (2 g y − 2 v²)/(4 r²)`.
const BEAD: &str = "\
model bead;
coordinate x: m;
coordinate y: m;
parameter m: kg = 0.7;
parameter r: m = 2;
constant g: m/s^2 = 9.81;
kinetic m/2*(dot(x)^2 + dot(y)^2);
potential m*g*y;
constraint ring: x^2 + y^2 == r^2;
output height = y + r;
";

fn bead(folder: &tempfile::TempDir) -> String {
    let path = folder.path().join("bead.model");
    std::fs::write(&path, BEAD).unwrap();
    path.to_str().unwrap().to_string()
}

#[test]
fn multipliers_are_those_of_a_bead_on_a_ring() {
    let folder = tempfile::tempdir().unwrap();
    let angles: Vec<f64> = (0..50).map(|i| 0.13 * f64::from(i)).collect();
    let lines: String = angles
        .iter()
        .map(|phi| {
            let q = [2.0 * phi.sin(), -2.0 * phi.cos()];
            let v = [6.0 * phi.cos(), 6.0 * phi.sin()];
            format!("{}\n", json!({"q": q, "v": v}))
        })
        .collect();
    let answers = eval(&bead(&folder), &["--derivatives"], &lines);
    for (answer, phi) in answers.iter().zip(angles) {
        let y = -2.0 * phi.cos();
        let lambda = 0.7 * (2.0 * 9.81 * y - 2.0 * 36.0) / 16.0;
        assert!(gap(&vector(&answer["lambda"]), &[lambda]) < 1e-12);
        assert!(gap(&vector(&answer["b"]), &[-72.0]) < 1e-12);
        assert!(gap(&vector(&answer["c"]), &[0.0]) < 1e-12);
        assert!(gap(&vector(&answer["c_dot"]), &[0.0]) < 1e-12);
        // The multiplier is linear in the mass.
        let slope = vector(&answer["dlambda_dparameters"]["m"]);
        assert!(gap(&slope, &[lambda / 0.7]) < 1e-11);
        assert!(gap(&[answer["outputs"]["height"].as_f64().unwrap()], &[y + 2.0]) < 1e-14);
    }
}

#[test]
fn lines_with_parameters_of_their_own_keep_their_order() {
    let masses: Vec<f64> = (0..40).map(|i| 1.0 + f64::from(i % 7)).collect();
    let lines: String = masses
        .iter()
        .map(|m2| format!("{}\n", json!({"q": [0.3, 0.4], "parameters": {"m2": m2}})))
        .collect();
    for (answer, m2) in eval(PENDULUM, &[], &lines).iter().zip(masses) {
        let mut p = NOMINAL;
        p[4] = m2;
        let (m, _, a) = textbook(&p, [0.3, 0.4], [0.0; 2], [0.0; 2]);
        assert!(gap(&matrix(&answer["M"]).concat(), &m.concat()) < 1e-13);
        assert!(gap(&vector(&answer["a"]), &a) < 1e-12);
    }
}

#[test]
fn a_file_of_parameters_replaces_the_nominal_values() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("p.json");
    let described = r#"{"id": "second", "nominal": {"g": 0}, "rate_hz": 200}"#;
    for file in [r#"{"g": 0}"#, described] {
        std::fs::write(&path, file).unwrap();
        let flags = ["--parameters", path.to_str().unwrap()];
        let answers = eval(PENDULUM, &flags, "{\"q\": [0.3, 0.4]}");
        assert_eq!(vector(&answers[0]["bias"]), [0.0, 0.0]);
    }
}

#[test]
fn no_state_is_no_mistake() {
    let (stdout, stderr) = succeed(&["eval", PENDULUM, "--states", "-"], "\n  \n");
    assert_eq!(stdout, "");
    insta::assert_snapshot!(stderr);
}

/// Whoever feeds us a state gets the answer before he goes on.
#[test]
fn standard_input_is_answered_line_by_line() {
    let mut child = Command::new(env!("CARGO_BIN_EXE_dynamics_under_test"))
        .current_dir(root())
        .args(["eval", PENDULUM, "--states", "-", "--json"])
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    let mut input = child.stdin.take().unwrap();
    let mut output = BufReader::new(child.stdout.take().unwrap());
    for i in 0..3 {
        writeln!(input, "{{\"q\": [{i}, 0]}}").unwrap();
        let mut answer = String::new();
        output.read_line(&mut answer).unwrap();
        let answer: Value = serde_json::from_str(&answer).unwrap();
        let (_, bias, _) = textbook(&NOMINAL, [f64::from(i), 0.0], [0.0; 2], [0.0; 2]);
        assert!(gap(&vector(&answer["bias"]), &bias) < 1e-12);
    }
    drop(input);
    assert!(child.wait().unwrap().success());
}

#[test]
fn a_closed_pipe_is_quiet() {
    let mut child = Command::new(env!("CARGO_BIN_EXE_dynamics_under_test"))
        .current_dir(root())
        .args(["eval", PENDULUM, "--states", "-", "--json"])
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    drop(child.stdout.take());
    let mut input = child.stdin.take().unwrap();
    // Writing ends when the program has ended; that is what is being tested.
    input
        .write_all("{\"q\": [0, 0]}\n".repeat(5000).as_bytes())
        .ok();
    drop(input);
    let output = child.wait_with_output().unwrap();
    assert_eq!(String::from_utf8_lossy(&output.stderr), "");
    assert_eq!(output.status.code(), Some(0));
}
