//! `dynamics trace` with logs that cannot be used: the place, the mend, exit code 2, and
//! the model file left as it was.

use crate::support::{self, refuse};
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
    let text = include_str!("../../../models/pendulum2.model");
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

/// Degrees instead of radians: said at once and first of all, with the line that mends it, and
/// nothing is searched for.
#[test]
fn mistaken_columns_come_first() {
    let folder = tempfile::tempdir().unwrap();
    let mut lines = log_lines();
    for line in &mut lines[1..] {
        let mut cells: Vec<String> = line.split(',').map(str::to_owned).collect();
        cells[1] = cells[1].parse::<f64>().unwrap().to_degrees().to_string();
        *line = cells.join(",");
    }
    let [log, model] = ["log.csv", "pendulum2.model"].map(|name| folder.path().join(name));
    fs::write(&log, lines.join("\n")).unwrap();
    let text = include_str!("../../../models/pendulum2.model");
    fs::write(&model, text).unwrap();
    let [log, model] = [&log, &model].map(|path| path.to_str().unwrap());
    let (said, warned) = support::succeed(&["trace", model, log, "--apply"], "");
    let (said, took) = said.rsplit_once("\nTook ").expect("the time that it took");
    insta::assert_snapshot!("mistaken_columns", format!("{warned}──\n{said}"));
    assert!(took.contains("columns") && !took.contains("fit"), "{took}");
    assert_eq!(
        fs::read_to_string(model).unwrap(),
        text,
        "nothing is written"
    );
}

/// A search keeps to a parameter's bounds, so that it cannot begin outside of them.
#[test]
fn a_value_out_of_bounds() {
    let folder = tempfile::tempdir().unwrap();
    let [log, values] = ["log.csv", "values.json"].map(|name| folder.path().join(name));
    fs::write(&log, log_lines().join("\n")).unwrap();
    fs::write(&values, r#"{"m2": -0.8}"#).unwrap();
    let [log, values] = [&log, &values].map(|path| path.to_str().unwrap());
    let model = "models/pendulum2.model";
    let said = refuse(&["trace", model, log, "--parameters", values], "");
    insta::assert_snapshot!(said.replace(folder.path().to_str().unwrap(), "FOLDER"));
}

/// A linkage of which each joint turns as it likes is another machine: no sensor's error and no
/// length closes it, so that nothing is searched for.
#[test]
fn a_log_that_breaks_the_constraint() {
    let mut log = String::from("t,q_j1,q_j2,q_j3,u_j1\n");
    for k in 0..400 {
        let t = 0.01 * f64::from(k);
        let swings = [2.0, 3.1].map(|rate: f64| 0.3 * (rate * t).sin());
        let [first, second] = [5.0 * t + swings[0], 0.5 + 3.3 * t + swings[1]];
        writeln!(log, "{t},{first},{second},{},0", -7.1 * t).unwrap();
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

/// A follower that is read with an offset, which can be found, and moves besides as no cam makes
/// it: what is found leaves another machine's log.
#[test]
fn a_log_that_breaks_the_constraint_behind_its_offset() {
    if left_out::too_slow() {
        return;
    }
    const CAM: &str = "model cam; coordinate angle: rad; coordinate height: m; input angle: N*m;
        parameter i: kg*m^2 = 0.02; parameter m: kg = 0.5; parameter lift: m = 0.1;
        kinetic i/2*dot(angle)^2 + m/2*dot(height)^2; force angle = input(angle);
        constraint cam: height == lift*(angle^2 + angle);";
    let mut log = String::from("t,q_angle,q_height,u_angle\n");
    for k in 0..300 {
        let t = 0.01 * f64::from(k);
        let (mut angle, mut v, mut a) = (0.0, 0.0, 0.0);
        for (size, rate) in [(0.5, 2.0_f64), (0.3, 5.0)] {
            let (sin, cos) = (rate * t).sin_cos();
            angle += size * sin;
            v += size * rate * cos;
            a -= size * rate * rate * sin;
        }
        let slope = 0.1 * (2.0 * angle + 1.0);
        let u = 0.02 * a + 0.5 * (slope * a + 0.2 * v * v) * slope;
        let height = 0.1 * (angle * angle + angle) + 0.2 + 0.06 * (9.0 * t).sin();
        writeln!(log, "{t:.2},{angle:.4},{height:.4},{u:.6}").unwrap();
    }
    let folder = tempfile::tempdir().unwrap();
    let [model, path] = ["cam.model", "log.csv"].map(|name| folder.path().join(name));
    fs::write(&model, CAM).unwrap();
    fs::write(&path, log).unwrap();
    let [model, path] = [&model, &path].map(|path| path.to_str().unwrap());
    let said = refuse(&["trace", model, path], "");
    let expected = "error: the log does not fulfil constraint `cam`";
    assert!(said.starts_with(expected), "{said}");
}

/// Columns with names of their own, in degrees and milliseconds: refused with a map to start
/// from, and with that map the same log.
#[test]
fn a_log_with_columns_of_its_own_gets_a_map() {
    let folder = tempfile::tempdir().unwrap();
    let lines = log_lines();
    let mut text = String::from("stamp,pos_1,pos_2,tau_1,tau_2\n");
    for line in &lines[1..1200] {
        let cells: Vec<f64> = line.split(',').map(|cell| cell.parse().unwrap()).collect();
        let (t, q, u) = (cells[0], &cells[1..3], &cells[5..7]);
        let [a, b] = [-q[0], q[1]].map(f64::to_degrees);
        writeln!(text, "{},{a},{b},{},{}", 1e3 * t, u[0], 1e3 * u[1]).unwrap();
    }
    let log = folder.path().join("swing.csv");
    fs::write(&log, text).unwrap();
    let log = log.to_str().unwrap();
    let shown = |text: String| text.replace(folder.path().to_str().unwrap(), "FOLDER");
    let arguments = ["trace", "models/pendulum2.model", log, "--json"];
    insta::assert_snapshot!("a_map_to_start_from", shown(refuse(&arguments, "")));

    let map = folder.path().join("swing.toml");
    fs::write(
        &map,
        "time = { column = \"stamp\", unit = \"ms\" }
        [columns]
        q_j1 = { column = \"pos_1\", unit = \"deg\", sign = -1 }
        q_j2 = { column = \"pos_2\", unit = \"deg\" }
        u_j1 = { column = \"tau_1\" }
        u_j2 = { column = \"tau_2\", unit = \"mN*m\" }",
    )
    .unwrap();
    let (with_map, said) = support::succeed(&arguments, "");
    assert!(
        shown(said).starts_with(
            "note: the columns of FOLDER/swing.csv are read as FOLDER/swing.toml says"
        )
    );

    let plain: Vec<String> = lines[..1200]
        .iter()
        .map(|line| {
            let cells: Vec<&str> = line.split(',').collect();
            [cells[0], cells[1], cells[2], cells[5], cells[6]].join(",")
        })
        .collect();
    let plain_log = folder.path().join("plain.csv");
    fs::write(&plain_log, plain.join("\n")).unwrap();
    let (plain, _) = support::succeed(
        &[
            "trace",
            "models/pendulum2.model",
            plain_log.to_str().unwrap(),
            "--json",
        ],
        "",
    );
    let first = |text: &str| {
        let value: serde_json::Value = serde_json::from_str(text).unwrap();
        (
            value["verdict"].clone(),
            value["findings"][0]["effect"].clone(),
        )
    };
    assert_eq!(first(&with_map), first(&plain));
    assert_eq!(first(&plain), ("effect".into(), "viscous".into()));

    fs::write(
        &map,
        "[columns]\nq_j1 = { column = \"pos_1\", unit = \"degrees\" }",
    )
    .unwrap();
    insta::assert_snapshot!("a_map_with_a_mistake", shown(refuse(&arguments, "")));
}
