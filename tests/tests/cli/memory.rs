//! `dynamics simulate` and `eval` with delays, internal states, contacts, switched
//! constraints and sensors: closed forms.

use crate::support::{eval, read_log, refuse, succeed, vector};
use std::fs;
use std::path::Path;

/// A mass that a late, lagging drive pushes, seen by a sensor with faults.
const PUSHED: &str = "model pushed; coordinate x: m; input u: N; parameter m: kg = 2;
    state slow: N = u;
    kinetic m/2*dot(x)^2;
    input u = delay(u, 0.25);
    constant tau: s = 0.5; dot(slow) == (u - slow)/tau;
    force x = slow;
    measured x = 2*x + 0.1;
";

fn path(folder: &Path, name: &str, text: &str) -> String {
    let path = folder.join(name);
    fs::write(&path, text).unwrap();
    path.to_str().unwrap().to_string()
}

#[test]
fn a_late_and_lagging_drive_moves_in_closed_form() {
    let folder = tempfile::tempdir().unwrap();
    let model = path(folder.path(), "pushed.model", PUSHED);
    // A ramp to 3 N within a microsecond at t = 0.5 s.
    let inputs = path(
        folder.path(),
        "u.csv",
        "t,u_u\n0,0\n0.5,0\n0.500001,3\n4,3\n",
    );
    let out = folder.path().join("log.csv");
    let flags = [
        "simulate",
        &model,
        "--init",
        r#"{"q": [0]}"#,
        "--duration",
        "3",
    ];
    let more = ["--inputs", &inputs, "--out", out.to_str().unwrap()];
    succeed(&[&flags[..], &more[..]].concat(), "");
    let (heading, rows) = read_log(&out);
    assert_eq!(heading, ["t", "q_x", "dq_x", "ddq_x", "u_u"]);
    for row in rows {
        let s = (row[0] - 0.75).max(0.0);
        let decay = 0.5 * (1.0 - (-s / 0.5).exp());
        let (a, v) = (3.0 * decay, 1.5 * (s - decay));
        let x = 1.5 * (s * s / 2.0 - 0.5 * (s - decay));
        assert!((row[3] - a).abs() < 1e-4, "{row:?} {a}");
        assert!((row[2] - 2.0 * v).abs() < 1e-4, "{row:?} {v}");
        assert!((row[1] - 2.0 * x - 0.1).abs() < 1e-4, "{row:?} {x}");
    }
}

#[test]
fn states_are_given_and_their_rates_answered() {
    let folder = tempfile::tempdir().unwrap();
    let model = path(folder.path(), "pushed.model", PUSHED);
    let states = "{\"q\": [0], \"u\": [3], \"z\": [1]}\n{\"q\": [0], \"u\": [3]}\n";
    let answers = eval(&model, &[], states);
    for (answer, slow) in answers.iter().zip([1.0, 3.0]) {
        assert!((vector(&answer["a"])[0] - slow / 2.0).abs() < 1e-12);
        let rate = answer["z_dot"]["slow"].as_f64().unwrap();
        assert!((rate - (3.0 - slow) / 0.5).abs() < 1e-12);
    }
    let refused = refuse(
        &["eval", &model, "--states", "-"],
        "{\"q\": [0], \"z\": {\"slwo\": 1}}",
    );
    assert!(refused.contains("did you mean `slow`?"), "{refused}");
}

#[test]
fn a_contact_rubs_and_a_jammed_one_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let text = |mu: f64| {
        format!(
            "model block; coordinate x: m; coordinate y: m; input press: N;
             parameter m: kg = 2; parameter mu: 1 = {mu}; constant slow: m/s = 1e-3;
             kinetic m/2*(dot(x)^2 + dot(y)^2);
             constraint floor when press: y == 0;
             force y = -press;
             force floor = -mu*normal_force(floor)*tanh(speed(floor)/slow);
             force y = (mu - 0.25)*abs(multiplier(floor));"
        )
    };
    let model = path(folder.path(), "block.model", &text(0.25));
    let states =
        "{\"q\": [0, 0], \"v\": [1, 0], \"u\": [8]}\n{\"q\": [0, 0], \"v\": [1, 0], \"u\": [0]}\n";
    let answers = eval(&model, &[], states);
    let close = |found: Vec<f64>, expected: &[f64]| {
        for (a, b) in found.iter().zip(expected) {
            assert!((a - b).abs() < 1e-9, "{found:?} {expected:?}");
        }
    };
    close(vector(&answers[0]["lambda"]), &[8.0]);
    close(vector(&answers[0]["a"]), &[-1.0, 0.0]);
    // Switched off: no floor, no friction.
    close(vector(&answers[1]["lambda"]), &[0.0]);
    close(vector(&answers[1]["a"]), &[0.0, 0.0]);
    let jammed = path(folder.path(), "jammed.model", &text(-0.75));
    let refused = refuse(&["eval", &jammed, "--states", "-"], states);
    assert!(
        refused.contains("the forces do not settle here"),
        "{refused}"
    );
}
