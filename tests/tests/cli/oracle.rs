//! `dynamics eval` against an independent derivation: CasADi, with the script and its
//! results under `tests/casadi`.

use crate::support::{eval, root};
use serde_json::Value;

/// What both call by one name.
const SAME: [&str; 18] = [
    "M",
    "bias",
    "Q",
    "B",
    "A",
    "b",
    "c",
    "c_dot",
    "a",
    "lambda",
    "da_dq",
    "da_dv",
    "da_du",
    "da_dt",
    "dlambda_dq",
    "dlambda_dv",
    "dlambda_du",
    "dlambda_dt",
];

/// All numbers, row by row; `None` where the oracle has no opinion.
fn entries(value: &Value) -> Vec<Option<f64>> {
    match value {
        Value::Array(values) => values.iter().flat_map(entries).collect(),
        Value::Null => vec![None],
        number => vec![Some(
            number
                .as_f64()
                .unwrap_or_else(|| panic!("{number} is no number")),
        )],
    }
}

/// `max |a − b|`, as a share of the largest entry or of one.
fn difference(ours: &[Option<f64>], theirs: &[Option<f64>]) -> f64 {
    assert_eq!(ours.len(), theirs.len());
    let scale = theirs
        .iter()
        .flatten()
        .fold(1.0_f64, |largest, x| largest.max(x.abs()));
    let pairs = ours.iter().zip(theirs);
    let gaps = pairs.filter_map(|(a, b)| Some((a.unwrap_or(f64::NAN) - (*b)?).abs()));
    gaps.fold(
        0.0,
        |largest, gap| if gap <= largest { largest } else { gap },
    ) / scale
}

/// The matrix with these columns, row by row.
fn transposed(columns: &[Vec<Option<f64>>]) -> Vec<Option<f64>> {
    let rows = columns.first().map_or(0, Vec::len);
    (0..rows)
        .flat_map(|row| columns.iter().map(move |column| column[row]))
        .collect()
}

fn compare(model: &str) -> usize {
    let path = root().join(format!("tests/casadi/expected/{model}.json"));
    let oracle: Value = serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap();
    let cases = oracle["cases"].as_array().unwrap();
    let state = |case: &Value| {
        let fields = ["q", "v", "u", "t", "parameters"];
        let object: serde_json::Map<String, Value> = fields
            .iter()
            .map(|name| (name.to_string(), case[name].clone()))
            .collect();
        format!("{}\n", Value::from(object))
    };
    let lines: String = cases.iter().map(state).collect();
    let answers = eval(&format!("models/{model}.model"), &["--derivatives"], &lines);
    assert_eq!(answers.len(), cases.len());
    for (index, (answer, case)) in answers.iter().zip(cases).enumerate() {
        for name in SAME {
            let gap = difference(&entries(&answer[name]), &entries(&case[name]));
            // Near a singular position the derivatives lose digits on both sides.
            let limit = if name.contains("_d") && name != "c_dot" {
                1e-8
            } else {
                1e-10
            };
            assert!(
                gap < limit,
                "{model}, case {index}: `{name}` is off by {gap:e}"
            );
        }
        let names: Vec<&str> = oracle["parameters"]
            .as_array()
            .unwrap()
            .iter()
            .map(|n| n.as_str().unwrap())
            .collect();
        for of in ["da", "dlambda"] {
            let ours = &answer[format!("{of}_dparameters")];
            let columns: Vec<_> = names.iter().map(|name| entries(&ours[name])).collect();
            let gap = difference(&transposed(&columns), &entries(&case[format!("{of}_dp")]));
            assert!(
                gap < 1e-8,
                "{model}, case {index}: `{of}_dparameters` is off by {gap:e}"
            );
        }
    }
    cases.len()
}

#[test]
fn every_model_agrees_with_casadi() {
    for model in [
        "cartpole",
        "delta",
        "duffing_constrained",
        "duffing_free",
        "fourbar",
        "pendulum",
        "pendulum2",
        "surface_particle",
        "unicycle2d",
    ] {
        assert!(compare(model) >= 10, "{model} has too few cases");
    }
}
