//! What `dynamics trace` writes: into the model's own file, and into the report's folder.

#![cfg(unix)]

use crate::support::{self, refuse, succeed};
use std::fmt::Write;
use std::fs;
use std::os::unix::fs::{MetadataExt, PermissionsExt, chown, symlink};
use std::os::unix::process::ExitStatusExt;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::time::Duration;
use tempfile::TempDir;

/// One link on a hinge.
const ARM: &str = r#"<robot name="arm"><link name="base"/>
  <link name="rod"><inertial><origin xyz="0 0 -0.3"/><mass value="1"/>
    <inertia ixx="0.02" ixy="0" ixz="0" iyy="0.02" iyz="0" izz="0.01"/></inertial></link>
  <joint name="j" type="continuous"><parent link="base"/><child link="rod"/>
    <axis xyz="0 1 0"/></joint>
</robot>"#;

/// An effect that is not built in.
const MINE: &str = "/// A spring of one's own.\neffect mine(joint: coordinate);\n\
                    parameter k: N*m/rad = 0.4;\nforce joint = -k*joint;\n";

/// A model with Windows line ends on that link and that effect, and a log of a machine that has
/// viscous friction besides.
struct Bench {
    folder: TempDir,
}

impl Bench {
    fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        let bench = Self { folder };
        for name in ["robots", "effects"] {
            fs::create_dir(bench.path(name)).unwrap();
        }
        let model = "model arm;\r\nurdf \"robots/arm.urdf\";\r\neffect mine(j);\r\n";
        let mut inputs = String::from("t,u_j\n");
        for k in 0..=600 {
            let t = 0.01 * f64::from(k);
            let u = 1.5 * (1.3 * t).sin() + (3.7 * t).sin();
            writeln!(inputs, "{t},{u}").unwrap();
        }
        bench.write("robots/arm.urdf", ARM);
        bench.write("effects/mine.model", MINE);
        bench.write("arm.model", model);
        bench.write(
            "truth.model",
            &format!("{model}effect viscous(j) {{ d = 0.05 }}\n"),
        );
        bench.write("inputs.csv", &inputs);
        let [truth, effects, inputs, log] =
            ["truth.model", "effects", "inputs.csv", "log.csv"].map(|name| bench.text(name));
        let arguments = [
            &[
                "simulate",
                &truth,
                "--effects",
                &effects,
                "--inputs",
                &inputs,
            ][..],
            &[
                "--init",
                r#"{"q": [0.5]}"#,
                "--duration",
                "6",
                "--noise",
                "q=1e-4",
            ],
            &["--seed", "3", "--out", &log],
        ];
        succeed(&arguments.concat(), "");
        bench
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn text(&self, name: &str) -> String {
        self.path(name).to_str().unwrap().to_string()
    }

    fn write(&self, name: &str, text: &str) {
        fs::write(self.path(name), text).unwrap();
    }

    fn read(&self, name: &str) -> String {
        fs::read_to_string(self.path(name)).unwrap()
    }

    /// The arguments of a trace of the model `model` that writes all it can.
    fn trace(&self, model: &str) -> Vec<String> {
        let [model, log, effects, report] =
            [model, "log.csv", "effects", "report"].map(|name| self.text(name));
        [
            "trace",
            &model,
            &log,
            "--effects",
            &effects,
            "--apply",
            "--report",
            &report,
        ]
        .map(str::to_string)
        .to_vec()
    }

    fn leftovers(&self) -> usize {
        let entries = fs::read_dir(self.folder.path()).unwrap();
        let names = entries.map(|entry| entry.unwrap().file_name().into_string().unwrap());
        names.filter(|name| name.starts_with('.')).count()
    }
}

fn mode(path: &Path) -> u32 {
    fs::metadata(path).unwrap().permissions().mode() & 0o7777
}

fn owner(path: &Path) -> (u32, u32) {
    let found = fs::metadata(path).unwrap();
    (found.uid(), found.gid())
}

/// Through a link, with the owner and the rights that the file had; and a report whose folder can be moved.
#[test]
fn a_model_keeps_its_rights_and_a_report_holds_what_its_model_needs() {
    let bench = Bench::new();
    let model = bench.path("arm.model");
    // Nobody but the system's administrator can give a file away.
    if owner(&model).0 == 0 {
        chown(&model, Some(54_321), Some(12_345)).unwrap();
    }
    let owned = owner(&model);
    fs::set_permissions(&model, fs::Permissions::from_mode(0o640)).unwrap();
    symlink("arm.model", bench.path("link.model")).unwrap();
    let arguments = bench.trace("link.model");
    let (said, _) = succeed(
        &arguments.iter().map(String::as_str).collect::<Vec<_>>(),
        "",
    );
    assert!(said.starts_with("The model lacks viscous (j)."), "{said}");
    assert!(said.contains("\nWritten into "), "{said}");
    assert!(bench.path("link.model").is_symlink());
    assert_eq!((mode(&model), owner(&model)), (0o640, owned));
    let text = bench.read("arm.model");
    assert!(text.contains("effect viscous(j)"), "{text}");
    assert_eq!(
        text.matches('\n').count(),
        text.matches("\r\n").count(),
        "{text:?}"
    );
    assert_eq!(bench.leftovers(), 0);

    let moved = tempfile::tempdir().unwrap();
    let report = moved.path().join("report");
    fs::rename(bench.path("report"), &report).unwrap();
    drop(bench);
    let [model, effects] = ["link.model", "effects"].map(|name| report.join(name));
    let [model, effects] = [&model, &effects].map(|path| path.to_str().unwrap());
    succeed(&["check", model, "--effects", effects], "");
    let said = refuse(&["check", model], "");
    assert!(said.contains("its folder: `--effects DIR`"), "{said}");
    let page = fs::read_to_string(report.join("report.html")).unwrap();
    assert!(
        page.contains("dynamics check link.model --effects effects"),
        "{page}"
    );
}

/// The model's file is edited while the trace runs, and there is no room for the report: the
/// edit stays, and what was found is told all the same.
#[test]
fn what_was_found_is_told_though_nothing_can_be_written() {
    let bench = Bench::new();
    // A signal would end what writes more than eight blocks, were it not ignored.
    let shell = r#"trap '' XFSZ; ulimit -f 8; exec "$0" "$@""#;
    let child = Command::new("sh")
        .current_dir(support::root())
        .args(["-c", shell, env!("CARGO_BIN_EXE_dynamics_under_test")])
        .args(bench.trace("arm.model"))
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    // The folder is made when the model has been read, long before the search.
    while !bench.path("report").exists() {
        std::thread::sleep(Duration::from_millis(5));
    }
    let edited = format!("{}// A note.\r\n", bench.read("arm.model"));
    bench.write("arm.model", &edited);
    let output = child.wait_with_output().unwrap();
    let [stdout, stderr] =
        [output.stdout, output.stderr].map(|bytes| String::from_utf8(bytes).unwrap());
    assert_eq!(output.status.code(), Some(2), "{stderr}");
    assert!(
        stdout.starts_with("The model lacks viscous (j)."),
        "{stdout}"
    );
    assert!(
        stdout.contains("\nPatch (--apply writes it) for "),
        "{stdout}"
    );
    let [model, report] = ["arm.model", "report"].map(|name| bench.text(name));
    for expected in [
        format!("cannot write `{model}`: it has changed since it was read"),
        format!("cannot write `{report}/"),
    ] {
        assert!(stderr.contains(&expected), "{stderr}");
    }
    assert_eq!(bench.read("arm.model"), edited);
    assert_eq!(bench.leftovers(), 0);
}

/// A trace that writes into its model, interrupted so many times once its report has a folder.
fn interrupted(bench: &Bench, times: usize) -> Output {
    let mut child = Command::new(env!("CARGO_BIN_EXE_dynamics_under_test"))
        .current_dir(support::root())
        .args(bench.trace("arm.model"))
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    // The folder is made when the model has been read, long before the search is over.
    while !bench.path("report").exists() {
        assert!(child.try_wait().unwrap().is_none(), "it is over already");
        std::thread::sleep(Duration::from_millis(5));
    }
    for _ in 0..times {
        std::thread::sleep(Duration::from_millis(100));
        let sent = Command::new("kill")
            .args(["-INT", &child.id().to_string()])
            .status();
        assert!(sent.unwrap().success());
    }
    child.wait_with_output().unwrap()
}

/// Interrupted twice while it searches, a trace leaves the model as it was, and no part of a report.
#[test]
fn a_trace_that_is_stopped_writes_nothing() {
    let bench = Bench::new();
    let before = bench.read("arm.model");
    let output = interrupted(&bench, 2);
    assert_eq!(output.status.signal(), Some(2), "{}", output.status);
    assert!(output.stdout.is_empty());
    assert_eq!(bench.read("arm.model"), before);
    assert_eq!(fs::read_dir(bench.path("report")).unwrap().count(), 0);
    assert_eq!(bench.leftovers(), 0);
}

/// Interrupted once, it says what it had, and writes nothing into the model.
#[test]
fn an_interrupted_trace_tells_what_it_had() {
    let bench = Bench::new();
    let before = bench.read("arm.model");
    let output = interrupted(&bench, 1);
    let [stdout, stderr] =
        [output.stdout, output.stderr].map(|bytes| String::from_utf8(bytes).unwrap());
    assert_eq!(output.status.code(), Some(130), "{stderr}");
    assert!(
        stdout.starts_with("Unfinished: an interrupt ended the search. Until then: "),
        "{stdout}"
    );
    assert!(
        stderr.contains("interrupt again to end at once"),
        "{stderr}"
    );
    let report: serde_json::Value =
        serde_json::from_str(&bench.read("report/report.json")).unwrap();
    assert_eq!(report["unfinished"], "interrupt");
    assert_eq!(bench.read("arm.model"), before);
    assert_eq!(bench.leftovers(), 0);
}

/// Without any time there is only what the balance of forces says at once.
#[test]
fn a_search_without_time_says_that_it_is_unfinished() {
    let bench = Bench::new();
    let [model, log, effects] = ["arm.model", "log.csv", "effects"].map(|name| bench.text(name));
    let trace = ["trace", &model, &log, "--effects", &effects, "--json"];
    let (json, _) = succeed(&[&trace[..], &["--time-limit", "0"]].concat(), "");
    let outcome: serde_json::Value = serde_json::from_str(&json).unwrap();
    assert_eq!(outcome["unfinished"], "time_limit");
    assert_eq!(outcome["basis"], "forces");
    let said = refuse(&[&trace[..], &["--time-limit=-1"]].concat(), "");
    assert!(
        said.contains("`--time-limit -1` is not a duration"),
        "{said}"
    );
}

/// Before the log is read: it is not even there.
#[test]
fn what_cannot_be_written_is_said_at_the_start() {
    let folder = tempfile::tempdir().unwrap();
    let place = folder.path();
    let model = place.join("arm.model");
    fs::copy(support::root().join("models/pendulum2.model"), &model).unwrap();
    fs::set_permissions(&model, fs::Permissions::from_mode(0o444)).unwrap();
    fs::write(place.join("file"), "").unwrap();
    fs::create_dir_all(place.join("old/report.json")).unwrap();
    let model = model.to_str().unwrap();
    let in_place = |name: &str| place.join(name).to_str().unwrap().to_string();
    let runs = [
        vec!["--apply".to_string()],
        vec!["--report".into(), "/proc/x".into()],
        vec!["--report".into(), in_place("file")],
        vec!["--report".into(), in_place("old")],
    ];
    let mut page = String::new();
    for flags in runs {
        let flags: Vec<&str> = flags.iter().map(String::as_str).collect();
        let said = refuse(&[&["trace", model, "none.csv"], &flags[..]].concat(), "");
        writeln!(page, "{}", said.replace(place.to_str().unwrap(), "FOLDER")).unwrap();
    }
    insta::assert_snapshot!(page);
    assert_eq!(
        fs::read_dir(place).unwrap().count(),
        3,
        "something is left behind"
    );
}
