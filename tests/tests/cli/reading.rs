//! Files that never end, that nobody writes to, or that stand for more than memory holds:
//! refused with their name, wherever a path may stand.

#![cfg(unix)]

use crate::support::{refuse, succeed};
use integration_tests::swing::{ROD, swing};
use std::fmt::Write;
use std::fs;
use std::path::Path;
use std::process::Command;
use tempfile::TempDir;

const MODEL: &str = "models/pendulum2.model";
const STATE: &str = r#"{"q": [0, 0]}"#;

/// A folder with a pipe that nobody writes to.
fn with_pipe() -> (TempDir, String) {
    let folder = tempfile::tempdir().unwrap();
    let pipe = folder.path().join("pipe");
    assert!(
        Command::new("mkfifo")
            .arg(&pipe)
            .status()
            .unwrap()
            .success()
    );
    let pipe = pipe.to_str().unwrap().to_string();
    (folder, pipe)
}

fn model_on(folder: &Path, robot: &str) -> String {
    let path = folder.join("on.model");
    fs::write(&path, format!("model on;\nurdf {robot:?};\n")).unwrap();
    path.to_str().unwrap().to_string()
}

#[test]
fn pipes_and_devices() {
    let (folder, pipe) = with_pipe();
    let mut page = String::new();
    for place in [pipe.as_str(), "/dev/zero"] {
        let model = model_on(folder.path(), place);
        let simulate = ["simulate", MODEL, "--duration", "1", "--out", "never.csv"];
        let trace = ["trace", MODEL];
        let cases: [(&str, Vec<&str>); 10] = [
            ("model", vec!["check", place]),
            ("urdf", vec!["check", &model]),
            ("parameters", vec!["check", MODEL, "--parameters", place]),
            ("init", [&simulate[..], &["--init", place]].concat()),
            (
                "inputs",
                [&simulate[..], &["--init", STATE, "--inputs", place]].concat(),
            ),
            ("states", vec!["eval", MODEL, "--states", place]),
            ("log", [&trace[..], &[place]].concat()),
            (
                "test log",
                [
                    &trace[..],
                    &[
                        "tests/data/scenarios/o01_pendulum2/train.csv.gz",
                        "--test",
                        place,
                    ],
                ]
                .concat(),
            ),
            ("map", [&trace[..], &["log.csv", "--map", place]].concat()),
            ("log of fit", vec!["fit", MODEL, place]),
        ];
        for (title, arguments) in cases {
            let said = refuse(&arguments, "");
            let said = said.replace(folder.path().to_str().unwrap(), "FOLDER");
            writeln!(page, "── {title}\n{said}").unwrap();
        }
    }
    insta::assert_snapshot!(page);
}

#[test]
fn effects_that_are_no_files() {
    let (folder, _) = with_pipe();
    let template = folder.path().join("mine.model");
    fs::rename(folder.path().join("pipe"), &template).unwrap();
    let effects = folder.path().to_str().unwrap();
    let said = refuse(&["check", MODEL, "--effects", effects], "");
    assert!(
        said.contains("mine.model`: it is a pipe, not a file"),
        "{said}"
    );
    fs::remove_file(&template).unwrap();
    std::os::unix::fs::symlink("/dev/zero", &template).unwrap();
    let said = refuse(&["check", MODEL, "--effects", effects], "");
    assert!(
        said.contains("mine.model`: it is a device, not a file"),
        "{said}"
    );
}

/// A file with a hole takes no room, but says that it is large.
#[test]
fn files_that_are_too_large() {
    let folder = tempfile::tempdir().unwrap();
    let huge = folder.path().join("huge");
    fs::File::create(&huge).unwrap().set_len(2 << 30).unwrap();
    let huge = huge.to_str().unwrap();
    for (arguments, most) in [
        (
            vec!["check", &model_on(folder.path(), huge)],
            "a robot description may be (16 MiB)",
        ),
        (vec!["trace", MODEL, huge], "a log may be (1024 MiB)"),
        (
            vec!["trace", MODEL, "log.csv", "--map", huge],
            "a map may be (1 MiB)",
        ),
    ] {
        let said = refuse(&arguments, "");
        assert!(
            said.contains(&format!("it is larger than {most}")),
            "{said}"
        );
        assert!(said.contains("huge"), "{said}");
    }
}

/// A folder with these files and the rod, and the path of each.
fn folder_with(files: &[(&str, String)]) -> (TempDir, impl Fn(&str) -> String + use<>) {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("rod.urdf"), ROD).unwrap();
    for (name, text) in files {
        fs::write(folder.path().join(name), text).unwrap();
    }
    let place = folder.path().to_path_buf();
    (folder, move |name: &str| {
        place.join(name).to_str().unwrap().to_owned()
    })
}

/// Without a header, refused with a map to start from; with that map, completed, read.
#[test]
fn a_log_without_a_header() {
    let (folder, path) = folder_with(&[("swing.csv", swing(100, 0, 700))]);
    let (rod, log) = (path("rod.urdf"), path("swing.csv"));
    let said = refuse(&["fit", &rod, &log], "");
    insta::assert_snapshot!(said.replace(folder.path().to_str().unwrap(), "FOLDER"));
    let map = "time.rate = 100\n[columns]\nq_j = { column = 2 }\nu_j = { column = 3 }\n";
    fs::write(path("swing.toml"), map).unwrap();
    let (said, _) = succeed(&["fit", &rod, &log], "");
    assert!(said.contains("friction(j)"), "{said}");
}

/// Several recordings to learn from and to judge by: errors are over all of them.
#[test]
fn recordings_one_after_the_other() {
    let part = |first| format!("t,q_j,u_j\n{}", swing(100, first, 150));
    let names = ["a.csv", "b.csv", "c.csv", "d.csv"];
    let files: Vec<(&str, String)> = (0..4).map(|k| (names[k], part(200 * k as u32))).collect();
    let (_folder, path) = folder_with(&files);
    let [rod, a, b, c, d] = ["rod.urdf", "a.csv", "b.csv", "c.csv", "d.csv"].map(&path);
    let arguments = ["fit", &rod, &a, &b, "--test", &d, "--test", &c, "--json"];
    let (said, warned) = succeed(&arguments, "");
    let found: serde_json::Value = serde_json::from_str(&said).unwrap();
    assert_eq!(found["samples"], serde_json::json!([300, 300]), "{said}");
    // The fourth ends after the third begins.
    assert!(warned.contains("c.csv` start anew"), "{warned}");
    let said = refuse(&["fit", &rod, &a, &a], "");
    assert!(said.contains("a.csv` is given twice"), "{said}");
}

/// A map for several logs may put a file beside each, but not one beside all.
#[test]
fn one_map_and_files_side_by_side() {
    let rows = swing(100, 0, 450);
    let column = |keep: &[usize]| -> String {
        let cells = |line: &str| -> String {
            let cells: Vec<&str> = line.split(',').collect();
            let kept: Vec<&str> = keep.iter().map(|&k| cells[k]).collect();
            kept.join(",") + "\n"
        };
        rows.lines().map(cells).collect()
    };
    let motion = format!("t,q_j\n{}", column(&[0, 1]));
    let forces = format!("tau\n{}", column(&[2]));
    let (_folder, path) = folder_with(&[
        ("a.csv", motion.clone()),
        ("b.csv", motion),
        ("a-tau.csv", forces.clone()),
        ("b-tau.csv", forces),
        (
            "each.toml",
            "files.beside = [\"{log}-tau.csv\"]\ncolumns.u_j = { column = \"tau\" }".to_owned(),
        ),
        (
            "one.toml",
            "files.beside = [\"a-tau.csv\"]\ncolumns.u_j = { column = \"tau\" }".to_owned(),
        ),
    ]);
    let [rod, a, b, each, one] = ["rod.urdf", "a.csv", "b.csv", "each.toml", "one.toml"].map(&path);
    let (said, _) = succeed(&["fit", &rod, &a, "--test", &b, "--map", &each], "");
    assert!(said.contains("friction(j)"), "{said}");
    let said = refuse(&["fit", &rod, &a, "--test", &b, "--map", &one], "");
    assert!(
        said.contains("puts the one file `a-tau.csv` beside all of them"),
        "{said}"
    );
}

/// What a recording of ROS 2 has, for a model that calls its joints otherwise.
#[test]
fn a_recording_with_other_joints() {
    let said = refuse(&["trace", MODEL, "tests/tests/fixtures/logs/jazzy.db3"], "");
    insta::assert_snapshot!(said);
    let said = refuse(
        &["trace", MODEL, "tests/tests/fixtures/logs/flight.ulg"],
        "",
    );
    insta::assert_snapshot!(said);
}
