//! Files that never end, that nobody writes to, or that stand for more than memory holds:
//! refused with their name, wherever a path may stand.

#![cfg(unix)]

mod cli;

use cli::refuse;
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

/// The search takes only so many samples, and says so before it begins.
#[test]
fn logs_that_are_too_long_to_trace() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("long.csv");
    let mut log = String::from("t,q_j1,q_j2,u_j1,u_j2\n");
    for k in 0..=100_000 {
        writeln!(log, "{},{k},0,0,0", 1e-3 * f64::from(k)).unwrap();
    }
    fs::write(&path, log).unwrap();
    let said = refuse(&["trace", MODEL, path.to_str().unwrap()], "");
    insta::assert_snapshot!(said);
}
