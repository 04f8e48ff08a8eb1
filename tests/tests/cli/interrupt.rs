//! A signal that ends the program leaves no half-written file.

#![cfg(unix)]

use crate::support;
use std::fs;
use std::os::unix::process::ExitStatusExt;
use std::path::Path;
use std::process::{Child, Command, ExitStatus, Stdio};
use std::time::Duration;
use tempfile::TempDir;

fn count(folder: &Path) -> usize {
    fs::read_dir(folder).unwrap().count()
}

/// The program under way, silent.
fn begin(arguments: &[&str]) -> Child {
    let mut command = Command::new(env!("CARGO_BIN_EXE_dynamics_under_test"));
    let command = command.current_dir(support::root()).args(arguments);
    let command = command.stdout(Stdio::null()).stderr(Stdio::null());
    command.spawn().unwrap()
}

/// Sends a signal, and waits for the end.
fn end(child: &mut Child, name: &str) -> ExitStatus {
    let sent = Command::new("kill")
        .args([format!("-{name}"), child.id().to_string()])
        .status();
    assert!(sent.unwrap().success());
    child.wait().unwrap()
}

/// A simulation that would take hours, ended as soon as its log is begun.
#[test]
fn a_signal_leaves_nothing_behind() {
    for (name, number) in [("INT", 2), ("TERM", 15)] {
        let folder = tempfile::tempdir().unwrap();
        let out = folder.path().join("log.csv");
        let mut child = begin(&[
            "simulate",
            "models/pendulum2.model",
            "--init",
            r#"{"q": [1, 0]}"#,
            "--duration",
            "1e5",
            "--rate",
            "1",
            "--out",
            out.to_str().unwrap(),
        ]);
        while count(folder.path()) == 0 {
            assert!(child.try_wait().unwrap().is_none(), "it is over already");
            std::thread::sleep(Duration::from_millis(5));
        }
        let status = end(&mut child, name);
        assert_eq!(status.signal(), Some(number), "{status}");
        assert_eq!(count(folder.path()), 0, "something is left behind");
    }
}

/// Interrupted whenever something appears in its folder, `generate` leaves whole files or none.
#[test]
fn generated_files_are_whole_or_not_there() {
    let whole = tempfile::tempdir().unwrap();
    let place = tempfile::tempdir().unwrap();
    // 15 MB of code: the writing takes long enough to be met.
    let chain = place.path().join("chain.urdf");
    fs::write(&chain, support::chain(60)).unwrap();
    let chain = chain.to_str().unwrap();
    let begun = |out: &TempDir| {
        let flags = "--to c --functions forward_dynamics_derivatives --out";
        let mut all = vec!["generate", chain];
        all.extend(flags.split(' ').chain(out.path().to_str()));
        begin(&all)
    };
    assert!(begun(&whole).wait().unwrap().success());
    let mut interrupted = 0;
    for wait in 0..4 {
        let folder = tempfile::tempdir().unwrap();
        let mut child = begun(&folder);
        // The first to appear is a trial whether the folder can be written to, the last the code.
        while count(folder.path()) == 0 {
            std::thread::sleep(Duration::from_micros(100));
        }
        std::thread::sleep(Duration::from_millis(wait));
        let status = end(&mut child, "INT");
        interrupted += usize::from(status.signal() == Some(2));
        for entry in fs::read_dir(folder.path()).unwrap() {
            let path = entry.unwrap().path();
            let name = path.file_name().unwrap();
            let expected = fs::read(whole.path().join(name));
            assert_eq!(fs::read(&path).ok(), expected.ok(), "{}", path.display());
        }
    }
    assert!(interrupted > 0, "it was over every time");
}
