//! `dynamics fit --apply --report`: what is written where, and what is not.

use crate::support::{refuse, succeed};
use std::fmt::Write;
use std::fs;
use std::path::Path;

const PENDULUM: &str = "model pendulum;
coordinate j: rad;
input j: N*m;
parameter m: kg = 0.5 in 1e-4..;
body rod { frame: rotate_z(-pi/2) * rotate_z(j); mass: m; center: (0.4, 0, 0); }
gravity (0, -9.81, 0);
force j = input(j);
";

/// Torques along sums of sines of that pendulum with viscous friction of 0.3 N·m·s.
fn log() -> String {
    let (m, l, g, d) = (0.5, 0.4, 9.81, 0.3);
    let mut text = String::from("t,q_j,u_j\n");
    for k in 0..1500 {
        let t = 0.01 * f64::from(k);
        let waves = [(0.9, 1.3), (0.4, 2.9), (0.1, 5.3)];
        let sum = |f: &dyn Fn(f64, f64) -> f64| waves.iter().map(|&(s, w)| f(s, w)).sum::<f64>();
        let q = sum(&|s, w| s * (w * t).sin());
        let v = sum(&|s, w| s * w * (w * t).cos());
        let a = sum(&|s, w| -s * w * w * (w * t).sin());
        let u = m * l * l * a + m * g * l * q.sin() + d * v;
        // A little of what is no physics: the digits.
        writeln!(text, "{t:.2},{q:.6},{u:.4}").unwrap();
    }
    text
}

fn folder() -> (tempfile::TempDir, String, String) {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).display().to_string();
    let (model, log) = (path("pendulum.model"), path("log.csv"));
    fs::write(&model, PENDULUM).unwrap();
    fs::write(&log, self::log()).unwrap();
    (folder, model, log)
}

/// The line of a table that begins with a name: its numbers.
fn row(page: &str, name: &str) -> Vec<f64> {
    let start = format!("  {name} ");
    let line = page
        .lines()
        .find(|line| line.starts_with(&start))
        .expect(page);
    let words = line.split_whitespace().skip(1);
    words.filter_map(|word| word.parse().ok()).collect()
}

#[test]
fn what_was_found_is_written_and_reported() {
    let (folder, model, log) = folder();
    let report = folder.path().join("report");
    let arguments = ["fit", &model, &log];
    let (said, _) = succeed(&arguments, "");
    assert!(said.contains("Patch (--apply writes it) for"), "{said}");
    assert_eq!(fs::read_to_string(&model).unwrap(), PENDULUM);
    let flags = ["--apply", "--report", report.to_str().unwrap()];
    let (said, _) = succeed(&[&arguments[..], &flags].concat(), "");
    assert!(said.contains("Written into"), "{said}");
    let written = fs::read_to_string(&model).unwrap();
    assert!(written.starts_with(PENDULUM), "{written}");
    assert!(written.contains("effect viscous(j) { d = 0.3"), "{written}");
    assert!(
        written.contains("// dynamics fit, log.csv: held-out force error"),
        "{written}"
    );
    // Loaded again, the model has the errors that were said.
    let (again, _) = succeed(&arguments, "");
    let (after, before) = (row(&said, "j")[2], row(&again, "j")[0]);
    assert!((before / after - 1.0).abs() < 1e-2, "{said}{again}");
    assert!(!again.contains("Patch"), "{again}");
    let read = |name: &str| fs::read_to_string(report.join(name)).unwrap();
    assert_eq!(read("pendulum.model"), written);
    assert!(read("summary.txt").contains("friction(j)"));
    assert!(read("model.diff").contains("+effect viscous(j)"));
    let json: serde_json::Value = serde_json::from_str(&read("report.json")).unwrap();
    assert!(
        json["noise_floor"]["total"].as_f64().unwrap() > 0.0,
        "{json}"
    );
    let series: serde_json::Value = serde_json::from_str(&read("series.json")).unwrap();
    assert_eq!(series["coordinates"][0]["name"], "j");
    let page = read("report.html");
    for section in ["errors", "findings", "forces", "speeds", "change", "run"] {
        assert!(
            page.contains(&format!("<section id=\"{section}\">")),
            "{section}"
        );
    }
    assert_eq!(page.matches("<svg ").count(), 2);
    for axis in ["force, j [N·m]", "velocity of j [rad/s]", "time [s]"] {
        assert!(page.contains(axis), "{axis}");
    }
    for outside in [
        "src=", "href=", "<script", "<link", "@import", "url(", "NaN",
    ] {
        assert!(!page.contains(outside), "{outside}");
    }
    let numbers = said.lines().find(|line| line.starts_with("  j ")).unwrap();
    for number in numbers.split_whitespace() {
        assert!(page.contains(number), "{number}");
    }
}

#[test]
fn what_cannot_be_written_is_said_at_the_start() {
    let (folder, model, log) = folder();
    let said = refuse(&["fit", &model, &log, "--apply", "--inertia", "linear"], "");
    assert!(said.contains("no model is written with them"), "{said}");
    // A robot description: the new model is in the way of nothing.
    let urdf = folder.path().join("arm.urdf");
    fs::write(&urdf, include_str!("../../../models/ur5.urdf")).unwrap();
    fs::write(folder.path().join("arm.model"), "model mine;").unwrap();
    let said = refuse(&["fit", urdf.to_str().unwrap(), &log, "--apply"], "");
    assert!(said.contains("which exists already"), "{said}");
    assert_eq!(read(folder.path(), "arm.model"), "model mine;");
}

fn read(folder: &Path, name: &str) -> String {
    fs::read_to_string(folder.join(name)).unwrap()
}

/// A log without some joints of a robot: lock them.
#[test]
fn joints_that_a_log_lacks_can_be_locked() {
    let (folder, _, _) = folder();
    let urdf = folder.path().join("arm.urdf");
    let text = include_str!("../../../models/iiwa7.urdf");
    fs::write(&urdf, text).unwrap();
    let mut log = String::from("t,q_j1,q_j2,q_j3,q_j4,q_j5,u_j1,u_j2,u_j3,u_j4,u_j5\n");
    for k in 0..600 {
        let t = 0.01 * f64::from(k);
        let q: Vec<String> = (1..=5)
            .map(|j| format!("{}", (f64::from(j) * t).sin()))
            .collect();
        writeln!(log, "{t},{},1,2,3,4,5", q.join(",")).unwrap();
    }
    let path = folder.path().join("part.csv");
    fs::write(&path, log).unwrap();
    let (urdf, path) = (urdf.to_str().unwrap(), path.to_str().unwrap());
    let said = refuse(&["fit", urdf, path], "");
    let mend = "urdf \"arm.urdf\" { lock: j6, j7; }";
    assert!(said.contains(mend), "{said}");
    let model = folder.path().join("part.model");
    fs::write(&model, format!("model part;\n{mend}\n")).unwrap();
    let (said, _) = succeed(&["fit", model.to_str().unwrap(), path], "");
    assert!(row(&said, "j5").len() > 2, "{said}");
    assert!(!said.contains("j6 "), "{said}");
}
