//! Mistakes that were made on purpose, and logs that are strange for other reasons.

use super::*;
use crate::trace::dictionary::Source;
use crate::trace::wheel::{WHEEL, rectangular};
use crate::trace::{Request, Silent, Verdict, trace};
use dynamics_codegen::Library;
use std::collections::BTreeMap;

/// A machine's log and its model; of a double pendulum with friction that the model lacks, if
/// nothing else is said.
struct Case {
    machine: Machine,
    values: Vec<f64>,
    record: Record,
    log: Log,
}

impl Case {
    fn new() -> Self {
        Self::machine("pendulum2", "o01_pendulum2")
    }

    /// Another machine of the scenarios.
    fn machine(model: &str, scenario: &str) -> Self {
        let root = concat!(env!("CARGO_MANIFEST_DIR"), "/..");
        let folder = format!("{root}/tests/data/scenarios/{scenario}");
        let text = std::fs::read_to_string(format!("{root}/models/{model}.model")).unwrap();
        let values = std::fs::read_to_string(format!("{folder}/parameters.json")).unwrap();
        let values: BTreeMap<String, f64> = serde_json::from_str(&values).unwrap();
        let nothing = Library::empty();
        let source = Source {
            name: model,
            text: &text,
            library: &nothing,
            parameters: &values,
        };
        let machine = Machine::new(source.compile().unwrap());
        let own = &machine.compiled.model;
        let coordinates: Vec<String> = own.coordinates.iter().map(|c| c.name.clone()).collect();
        let inputs: Vec<String> = own.inputs.iter().map(|u| u.name.clone()).collect();
        let log = Log::read(format!("{folder}/train.csv.gz")).unwrap();
        let record = log.select(&coordinates, &inputs).unwrap();
        Self {
            values: source.values(&machine),
            machine,
            record,
            log,
        }
    }

    /// What is said of its log with a change; `values` replace the model's.
    fn told_by(&self, values: &[f64], change: impl Fn(&mut Record)) -> Option<Misread> {
        let mut record = self.record.clone();
        change(&mut record);
        misread(Look {
            machine: &self.machine,
            values,
            record: &record,
            log: &self.log,
        })
    }

    /// What is beyond doubt, each mistake in a line, then the lines of a map.
    fn told(&self, change: impl Fn(&mut Record)) -> String {
        let told = self.told_by(&self.values, change).expect("a mistake");
        assert!(told.is_decisive, "{told:?}");
        assert!(told.error_otherwise < FAR_OFF, "{told:?}");
        let each = told.mistakes.iter().map(|m| {
            let or = m.or.iter().map(|or| format!(" or {or}"));
            format!(
                "{}{}\n{}",
                m.mistake,
                or.collect::<String>(),
                m.map.join("\n")
            )
        });
        each.collect::<Vec<_>>().join("\n")
    }
}

fn scale(column: &mut [f64], by: f64) {
    column.iter_mut().for_each(|x| *x *= by);
}

/// Position and velocity of a joint.
fn joint(record: &mut Record, i: usize, by: f64) {
    scale(&mut record.q[i], by);
    record.dq[i].iter_mut().for_each(|dq| scale(dq, by));
}

#[test]
fn signs_are_told() {
    let pendulum = Case::new();
    let both = pendulum.told(|record| joint(record, 1, -1.0));
    insta::assert_snapshot!(both, @r#"
`q_j2` and `dq_j2` have the opposite sign
"q_j2" = { column = "q_j2", sign = -1 }
"dq_j2" = { column = "dq_j2", sign = -1 }
"#);
    let position = pendulum.told(|record| scale(&mut record.q[1], -1.0));
    insta::assert_snapshot!(position, @r#"
`q_j2` has the opposite sign
"q_j2" = { column = "q_j2", sign = -1 }
"#);
    let velocity = pendulum.told(|record| record.dq[0].iter_mut().for_each(|dq| scale(dq, -1.0)));
    insta::assert_snapshot!(velocity, @r#"
`dq_j1` has the opposite sign
"dq_j1" = { column = "dq_j1", sign = -1 }
"#);
    let input = pendulum.told(|record| scale(&mut record.u[0], -1.0));
    insta::assert_snapshot!(input, @r#"
`u_j1` has the opposite sign
"u_j1" = { column = "u_j1", sign = -1 }
"#);
}

#[test]
fn units_are_told() {
    let pendulum = Case::new();
    let degrees = 1_f64.to_degrees();
    let all = pendulum.told(|record| (0..2).for_each(|i| joint(record, i, degrees)));
    insta::assert_snapshot!(all, @r#"
`q_j1`, `dq_j1`, `q_j2` and `dq_j2` are in deg
"q_j1" = { column = "q_j1", unit = "deg" }
"dq_j1" = { column = "dq_j1", unit = "deg/s" }
"q_j2" = { column = "q_j2", unit = "deg" }
"dq_j2" = { column = "dq_j2", unit = "deg/s" }
"#);
    let one = pendulum.told(|record| joint(record, 0, degrees));
    insta::assert_snapshot!(one, @r#"
`q_j1` and `dq_j1` are in deg
"q_j1" = { column = "q_j1", unit = "deg" }
"dq_j1" = { column = "dq_j1", unit = "deg/s" }
"#);
    let position = pendulum.told(|record| scale(&mut record.q[0], degrees));
    insta::assert_snapshot!(position, @r#"
`q_j1` is in deg
"q_j1" = { column = "q_j1", unit = "deg" }
"#);
    let rpm = pendulum.told(|record| {
        let dq = record.dq[1].iter_mut();
        dq.for_each(|dq| scale(dq, -60.0 / std::f64::consts::TAU));
    });
    insta::assert_snapshot!(rpm, @r#"
`dq_j2` is in rpm and has the opposite sign
"dq_j2" = { column = "dq_j2", unit = "rpm", sign = -1 }
"#);
}

#[test]
fn swapped_columns_are_told() {
    let pendulum = Case::new();
    let inputs = pendulum.told(|record| record.u.swap(0, 1));
    insta::assert_snapshot!(inputs, @r#"
`u_j1` and `u_j2` stand in each other's place
"u_j1" = { column = "u_j2" }
"u_j2" = { column = "u_j1" }
"#);
    let joints = pendulum.told(|record| {
        record.q.swap(0, 1);
        record.dq.swap(0, 1);
    });
    insta::assert_snapshot!(joints, @r#"
`q_j1` and `q_j2`, `dq_j1` and `dq_j2` stand in each other's place
"q_j1" = { column = "q_j2" }
"q_j2" = { column = "q_j1" }
"dq_j1" = { column = "dq_j2" }
"dq_j2" = { column = "dq_j1" }
"#);
    let positions = pendulum.told(|record| record.q.swap(0, 1));
    insta::assert_snapshot!(positions, @r#"
`q_j1` and `q_j2` stand in each other's place
"q_j1" = { column = "q_j2" }
"q_j2" = { column = "q_j1" }
"#);
}

#[test]
fn two_mistakes_are_told() {
    let pendulum = Case::new();
    let two = pendulum.told(|record| {
        joint(record, 1, -1.0);
        scale(&mut record.u[0], -1.0);
    });
    insta::assert_snapshot!(two, @r#"
`u_j2` has the opposite sign
"u_j2" = { column = "u_j2", sign = -1 }
`q_j1` and `dq_j1` have the opposite sign
"q_j1" = { column = "q_j1", sign = -1 }
"dq_j1" = { column = "dq_j1", sign = -1 }
"#);
}

/// The record without the mistakes is the one before they were made.
#[test]
fn what_is_mended_is_as_before() {
    let pendulum = Case::new();
    let wrong = |record: &mut Record| {
        joint(record, 1, -1.0);
        record.u.swap(0, 1);
    };
    let told = pendulum.told_by(&pendulum.values, wrong).unwrap();
    let mut record = pendulum.record.clone();
    wrong(&mut record);
    assert_eq!(told.mended(&record), pendulum.record);
}

/// A velocity that is off by no unit's factor is a question, not an answer.
#[test]
fn an_odd_factor_is_asked_about() {
    let pendulum = Case::new();
    let told = pendulum.told_by(&pendulum.values, |record| {
        record.dq[0].iter_mut().for_each(|dq| scale(dq, 1.4));
    });
    let told = told.unwrap();
    assert!(
        !told.is_decisive && told.mistakes[0].map.is_empty(),
        "{told:?}"
    );
    assert!(
        told.mistakes[0].mistake.starts_with("`dq_j1` is 1."),
        "{told:?}"
    );
}

/// A machine that its model does not describe is not a log that is read wrongly: friction alone,
/// a weak drive, a load, and far more of each than any machine has.
#[test]
fn strong_effects_are_no_mistakes() {
    let pendulum = Case::new();
    let silent = |values: &[f64], change: &dyn Fn(&mut Record)| {
        assert_eq!(pendulum.told_by(values, change), None);
    };
    silent(&pendulum.values, &|_| {});
    for gain in [0.3, 0.7, 1.5, 3.0] {
        silent(&pendulum.values, &|record| scale(&mut record.u[0], gain));
    }
    let parameters = &pendulum.machine.compiled.model.parameters;
    for factor in [0.2, 0.5, 2.0, 5.0] {
        let place = parameters.iter().position(|p| p.name == "m2").unwrap();
        let mut values = pendulum.values.clone();
        values[place] *= factor;
        silent(&values, &|_| {});
    }
    // A spring and a brake, as large as what the drives exert.
    silent(&pendulum.values, &|record| {
        for k in 0..record.len() {
            let v = record.dq[1].as_ref().unwrap()[k];
            record.u[1][k] += 0.5 * record.q[1][k] + 0.1 * v;
        }
    });
}

/// Machines that lack what their models do not say, each read as it should be.
#[test]
fn logs_of_known_machines_are_read_rightly() {
    for (model, scenario) in [
        ("cartpole", "cart_pushed_and_loaded"),
        ("cartpole", "o02_cartpole"),
        ("pendulum2", "o05_pendulum2"),
        ("cartpole", "o06_cartpole"),
        ("unicycle2d", "o07_unicycle2d"),
        ("duffing_free", "o08_duffing"),
        ("duffing_constrained", "o11_duffing"),
        ("pendulum2", "two_joints_drag_and_delay"),
    ] {
        let case = Case::machine(model, scenario);
        assert_eq!(case.told_by(&case.values, |_| {}), None, "{scenario}");
    }
}

/// A wheel whose motor is connected the other way round: the whole command says so and searches for
/// nothing, unless it is told that the columns are right.
#[test]
fn trusted_columns_are_searched() {
    if left_out::too_slow() {
        return;
    }
    let mut text = String::from("t,q_angle,u_motor\n");
    let mut noise = rectangular(9);
    for k in 0..600 {
        let t = 0.01 * f64::from(k);
        let q = 0.6 * (2.0 * t).sin() + 0.2 * (5.0 * t).sin() + 1e-4 * noise();
        let a = -2.4 * (2.0 * t).sin() - 5.0 * (5.0 * t).sin();
        text += &format!("{t},{q},{}\n", -0.02 * a);
    }
    let log = Log::from_bytes("wheel.csv", text.as_bytes()).unwrap();
    let outcome = |trust_columns: bool| {
        let outcome = trace(&Request {
            model_name: "wheel",
            model_text: WHEEL,
            library: &Library::builtin(),
            parameters: BTreeMap::new(),
            train: &log,
            test: None,
            hold: None,
            horizon: 0.5,
            seed: 1,
            trust_columns,
            progress: &Silent,
        });
        outcome.unwrap()
    };
    let stopped = outcome(false);
    let misread = stopped.misread.expect("a mistake");
    insta::assert_snapshot!(misread.to_string(), @"The columns of the log are not what they are taken for: `q_angle` has the opposite sign, or `u_motor` has the opposite sign.");
    assert_eq!(stopped.verdict, Verdict::Channel);
    assert!(stopped.findings.is_empty() && stopped.details.considered.is_empty());
    assert_eq!(stopped.patched_model, WHEEL);
    let [before, after] = [stopped.before, stopped.after].map(|score| score.acceleration.total);
    assert!(before > 1.9 && after < 0.2, "{before} -> {after}");
    let searched = outcome(true);
    assert!(searched.misread.is_some(), "it is said all the same");
    assert!(!searched.details.considered.is_empty());
}
