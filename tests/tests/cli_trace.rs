//! `dynamics trace` with logs that cannot be used: the place, the mend, exit code 2, and
//! the model file left as it was.

mod cli;

use cli::refuse;
use identify::log::Log;
use std::fmt::Write;
use std::fs;

/// A machine's log as text, line by line.
fn log_lines() -> Vec<String> {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/data/scenarios/o01_pendulum2");
    let log = Log::read(format!("{folder}/train.csv.gz")).unwrap();
    let columns = ["q_j1", "q_j2", "dq_j1", "dq_j2", "u_j1", "u_j2"];
    let mut lines = vec![format!("t,{}", columns.join(","))];
    for (sample, t) in log.t.iter().enumerate() {
        let values = columns
            .iter()
            .map(|column| log.channels[*column][sample].to_string());
        lines.push(format!("{t},{}", values.collect::<Vec<_>>().join(",")));
    }
    lines
}

#[test]
fn logs_that_cannot_be_used() {
    let lines = log_lines();
    let change = |index: usize, to: &dyn Fn(&str) -> String| {
        let mut changed = lines.clone();
        changed[index] = to(&lines[index]);
        changed.join("\n")
    };
    let second_field = |word: &'static str| {
        move |line: &str| {
            let mut fields: Vec<&str> = line.split(',').collect();
            fields[1] = word;
            fields.join(",")
        }
    };
    let mut backwards = lines.clone();
    backwards.insert(100, lines[50].clone());
    let cases = [
        (
            "missing column",
            change(0, &|line| line.replace("q_j2", "q_elbow")),
        ),
        ("not a number", change(100, &second_field("NaN"))),
        ("infinity", change(100, &second_field("inf"))),
        ("time runs backwards", backwards.join("\n")),
        ("too short", lines[..40].join("\n")),
        ("too short to split", lines[..100].join("\n")),
    ];
    let folder = tempfile::tempdir().unwrap();
    let model = folder.path().join("pendulum2.model");
    let text = include_str!("../../models/pendulum2.model");
    fs::write(&model, text).unwrap();
    let mut page = String::new();
    for (title, log) in cases {
        let path = folder.path().join("log.csv");
        fs::write(&path, log).unwrap();
        let said = refuse(
            &[
                "trace",
                model.to_str().unwrap(),
                path.to_str().unwrap(),
                "--apply",
            ],
            "",
        );
        let place = folder.path().to_str().unwrap();
        write!(page, "── {title}\n{}\n", said.replace(place, "FOLDER")).unwrap();
        assert_eq!(
            fs::read_to_string(&model).unwrap(),
            text,
            "{title}: the model has changed"
        );
    }
    insta::assert_snapshot!(page);
}

/// A linkage whose angles do not close is another machine.
#[test]
fn a_log_that_breaks_the_constraint() {
    let mut log = String::from("t,q_j1,q_j2,q_j3,u_j1\n");
    for k in 0..400 {
        let t = 0.01 * f64::from(k);
        let swing = (2.0 * t).sin();
        writeln!(
            log,
            "{t},{},{},{},0",
            0.3 * swing,
            0.5 + 0.2 * swing,
            0.1 * swing
        )
        .unwrap();
    }
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("log.csv");
    fs::write(&path, log).unwrap();
    let said = refuse(
        &["trace", "models/fourbar.model", path.to_str().unwrap()],
        "",
    );
    // Digits behind the third hang on the machine's sine.
    assert!(
        said.starts_with("error: the log does not fulfil constraint `closure_"),
        "{said}"
    );
    assert!(
        said.contains("check that the columns, signs and geometry"),
        "{said}"
    );
}
