//! A signal that ends the program leaves no half-written file.

#![cfg(unix)]

mod cli;

use std::fs;
use std::os::unix::process::ExitStatusExt;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Duration;

fn count(folder: &Path) -> usize {
    fs::read_dir(folder).unwrap().count()
}

/// A simulation that would take hours, ended as soon as its log is begun.
#[test]
fn a_signal_leaves_nothing_behind() {
    for (name, number) in [("INT", 2), ("TERM", 15)] {
        let folder = tempfile::tempdir().unwrap();
        let mut child = Command::new(env!("CARGO_BIN_EXE_dynamics_under_test"))
            .current_dir(cli::root())
            .args([
                "simulate",
                "models/pendulum2.model",
                "--init",
                r#"{"q": [1, 0]}"#,
            ])
            .args(["--duration", "1e5", "--rate", "1", "--out"])
            .arg(folder.path().join("log.csv"))
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        while count(folder.path()) == 0 {
            assert!(child.try_wait().unwrap().is_none(), "it is over already");
            std::thread::sleep(Duration::from_millis(5));
        }
        let signal = format!("-{name}");
        let sent = Command::new("kill")
            .arg(signal)
            .arg(child.id().to_string())
            .status();
        assert!(sent.unwrap().success());
        let status = child.wait().unwrap();
        assert_eq!(status.signal(), Some(number), "{status}");
        assert_eq!(count(folder.path()), 0, "something is left behind");
    }
}
