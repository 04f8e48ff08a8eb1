//! `dynamics linearise`, against closed forms.

use crate::support::{gap, matrix, refuse, succeed, vector};
use serde_json::Value;

fn linearise(model: &str, flags: &[&str]) -> Value {
    let (stdout, _) = succeed(&[&["linearise", model, "--json"], flags].concat(), "");
    serde_json::from_str(&stdout).unwrap()
}

const PENDULUM: &str = "models/pendulum.model";

/// `φ̈ = −(m g l/(I + m l²)) φ + u/(I + m l²)`, and its transition over an interval.
#[test]
fn a_pendulum_is_that_of_the_textbook() {
    let (m, l, i, g) = (0.5, 0.5, 0.01, 9.81);
    let inertia: f64 = i + m * l * l;
    let w2 = m * g * l / inertia;
    let found = linearise(PENDULUM, &[]);
    let expected = [0.0, 1.0, -w2, 0.0];
    assert!(
        gap(&matrix(&found["A"]).concat(), &expected) < 1e-14,
        "{found}"
    );
    assert!(gap(&matrix(&found["B"]).concat(), &[0.0, 1.0 / inertia]) < 1e-14);
    assert_eq!(vector(&found["drift"]), [0.0, 0.0]);
    let (h, w) = (0.1, w2.sqrt());
    let found = linearise(PENDULUM, &["--hold", "0.1"]);
    let (s, c) = (w * h).sin_cos();
    let expected = [c, s / w, -w * s, c];
    assert!(
        gap(&matrix(&found["A"]).concat(), &expected) < 1e-13,
        "{found}"
    );
    let expected = [(1.0 - c) / w2 / inertia, s / w / inertia];
    assert!(
        gap(&matrix(&found["B"]).concat(), &expected) < 1e-13,
        "{found}"
    );
}

#[test]
fn text_for_people() {
    let state = r#"{"q": [0, 0, 0.5], "v": [0, 1, 0]}"#;
    let flags = ["linearise", "models/unicycle2d.model", "--state", state];
    let (page, said) = succeed(&flags, "");
    insta::assert_snapshot!(format!("{page}\n{said}"));
}

#[test]
fn mistakes_have_a_place_and_a_mend() {
    let said = [
        refuse(&["linearise", PENDULUM, "--state", r#"{"q": [0, 1]}"#], ""),
        refuse(&["linearise", PENDULUM, "--state", "nowhere.json"], ""),
        refuse(&["linearise", PENDULUM, "--hold", "0"], ""),
        refuse(&["linearise", PENDULUM, "--hold", "1e300"], ""),
    ];
    insta::assert_snapshot!(said.join("\n"));
}
