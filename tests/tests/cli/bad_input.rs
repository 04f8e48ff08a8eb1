//! Bad input: each gets an error with its place and a mend, exit code 2, and nothing is
//! half-written.

use crate::support::{dynamics, refuse};
use std::fmt::Write;
use std::fs;
use tempfile::TempDir;

/// A folder with the files that the cases name.
fn folder(files: &[(&str, &[u8])]) -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    for (name, bytes) in files {
        fs::write(folder.path().join(name), bytes).unwrap();
    }
    folder
}

/// Runs each case in `folder`; what is said, one under the other. `{M}` is a model that is
/// right, `{F}` the folder.
fn read_aloud(folder: &TempDir, cases: &[(&str, &[&str], &str)]) -> String {
    let place = folder.path().to_str().unwrap();
    let mut page = String::new();
    for (title, arguments, input) in cases {
        let arguments: Vec<String> = arguments
            .iter()
            .map(|a| {
                a.replace("{F}", place)
                    .replace("{M}", "models/pendulum2.model")
            })
            .collect();
        let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
        let said = refuse(&arguments, input).replace(place, "FOLDER");
        write!(page, "── {title}\n{said}\n").unwrap();
    }
    page
}

#[test]
fn models() {
    let deep = format!(
        "model m;\nlet a = {}x{};\n",
        "(".repeat(10_000),
        ")".repeat(10_000)
    );
    let folder = folder(&[
        ("empty.model", b""),
        ("latin.model", b"model m;\n// caf\xe9\n"),
        ("zeros.model", &[0; 100]),
        ("deep.model", deep.as_bytes()),
        ("huge.model", &vec![b' '; 5 << 20]),
        ("arm.urdf", b"<robot name=\"arm\"/>"),
        (
            "arm.txt",
            b"\xef\xbb\xbf\n <?xml version=\"1.0\"?>\n<robot name=\"arm\"/>",
        ),
        (
            "three.model",
            b"model m;\ncoordinate x: m;\ninput x: Newton;\nkinetic dot(y)^2;\nforce z = 1;\n",
        ),
        (
            "user.model",
            b"model m;\ncoordinate x;\nkinetic dot(x)^2;\neffect mine(x);\n",
        ),
    ]);
    fs::create_dir(folder.path().join("effects")).unwrap();
    fs::create_dir(folder.path().join("odd")).unwrap();
    fs::write(
        folder.path().join("odd/latin.model"),
        b"effect m;\n// caf\xe9\n",
    )
    .unwrap();
    let mine = "effect mine(joint);\nforce joint = -d*dot(joint);\n";
    fs::write(folder.path().join("effects/mine.model"), mine).unwrap();
    let said = read_aloud(
        &folder,
        &[
            ("no such file", &["check", "{F}/none.model"], ""),
            (
                "a slip in the path",
                &["check", "models/pendulm2.model"],
                "",
            ),
            ("no such folder", &["check", "{F}/none/m.model"], ""),
            ("a folder", &["check", "{F}"], ""),
            ("empty", &["check", "{F}/empty.model"], ""),
            ("not UTF-8", &["check", "{F}/latin.model"], ""),
            ("NUL bytes", &["check", "{F}/zeros.model"], ""),
            ("deep nesting", &["check", "{F}/deep.model"], ""),
            ("huge", &["check", "{F}/huge.model"], ""),
            ("robot description by name", &["check", "{F}/arm.urdf"], ""),
            (
                "robot description by content",
                &["check", "{F}/arm.txt"],
                "",
            ),
            ("three mistakes", &["check", "{F}/three.model"], ""),
            (
                "no folder of effects",
                &["check", "{M}", "--effects", "{F}/none"],
                "",
            ),
            (
                "an effect that is no text",
                &["check", "{M}", "--effects", "{F}/odd"],
                "",
            ),
            (
                "fault in an effect of the user",
                &["check", "{F}/user.model", "--effects", "{F}/effects"],
                "",
            ),
        ],
    );
    insta::assert_snapshot!(said);
}

#[test]
fn states() {
    let folder = folder(&[
        ("second.jsonl", b"{\"q\": [0, 0]}\n{\"q\": [0, \"x\"]}\n"),
        ("latin.jsonl", b"{\"q\": [0, 0]}\n{\"q\": [0, \xe9]}\n"),
    ]);
    const EVAL: [&str; 4] = ["eval", "{M}", "--states", "-"];
    let cases: Vec<(&str, &[&str], &str)> = vec![
        (
            "no such file",
            &["eval", "{M}", "--states", "{F}/none.jsonl"],
            "",
        ),
        (
            "second line of a file",
            &["eval", "{M}", "--states", "{F}/second.jsonl"],
            "",
        ),
        (
            "not UTF-8",
            &["eval", "{M}", "--states", "{F}/latin.jsonl"],
            "",
        ),
        ("not JSON", &EVAL, "q = [1, 2]\n"),
        ("cut short", &EVAL, "{\"q\": [1, 2\n"),
        ("two objects", &EVAL, "{\"q\": [1, 2]} {\"q\": [1, 2]}\n"),
        ("no object", &EVAL, "[1, 2]\n"),
        ("NaN", &EVAL, "{\"q\": [1, NaN]}\n"),
        ("minus infinity", &EVAL, "{\"q\": [1, -Infinity]}\n"),
        ("too large", &EVAL, "{\"q\": [1, 1e999]}\n"),
        ("null", &EVAL, "{\"q\": [1, null]}\n"),
        ("text", &EVAL, "{\"q\": {\"j1\": 0, \"j2\": \"1\"}}\n"),
        ("too few", &EVAL, "{\"q\": [1]}\n"),
        ("too many", &EVAL, "{\"q\": [1, 2], \"v\": [1, 2, 3]}\n"),
        ("no positions", &EVAL, "{\"v\": [1, 2]}\n"),
        ("one position missing", &EVAL, "{\"q\": {\"j2\": 2}}\n"),
        (
            "unknown coordinate",
            &EVAL,
            "{\"q\": {\"j1\": 1, \"j3\": 2}}\n",
        ),
        (
            "unknown input",
            &EVAL,
            "{\"q\": [1, 2], \"u\": {\"motor\": 2}}\n",
        ),
        (
            "unknown field",
            &EVAL,
            "{\"q\": [1, 2], \"parameter\": {}}\n",
        ),
        (
            "unknown parameter",
            &EVAL,
            "{\"q\": [1, 2], \"parameters\": {\"m3\": 1}}\n",
        ),
        ("given twice", &EVAL, "{\"q\": [1, 2], \"q\": [1, 3]}\n"),
        ("a number for a vector", &EVAL, "{\"q\": 1}\n"),
        (
            "a text for a time",
            &EVAL,
            "{\"q\": [1, 2], \"t\": \"now\"}\n",
        ),
        ("half a character", &EVAL, "{\"q\": {\"j\\ud800\": 1}}\n"),
        (
            "no inertia",
            &EVAL,
            "{\"q\": [1, 2], \"parameters\": {\"I1\": 0, \"m1\": 0, \"m2\": 0, \"I2\": 0}}\n",
        ),
    ];
    let said = read_aloud(&folder, &cases);
    insta::assert_snapshot!(said);
}

#[test]
fn states_that_a_model_cannot_be_in() {
    let folder = folder(&[
        ("root.model", b"model m;\ncoordinate x;\nkinetic dot(x)^2;\npotential sqrt(x)^3;\n"),
        ("edge.model", b"model m;\ncoordinate x;\nkinetic dot(x)^2;\nforce x = sqrt(x);\n"),
        (
            "torn.model",
            b"model m;\ncoordinate x;\nkinetic dot(x)^2;\nconstraint a: x == t^2;\nconstraint b: x^3 == t^4;\n",
        ),
    ]);
    let said = read_aloud(
        &folder,
        &[
            (
                "not finite",
                &["eval", "{F}/root.model", "--states", "-"],
                "{\"q\": [-1]}\n",
            ),
            (
                "derivative not finite",
                &["eval", "{F}/edge.model", "--states", "-", "--derivatives"],
                "{\"q\": [0]}\n",
            ),
            (
                "constraints that contradict each other",
                &["eval", "{F}/torn.model", "--states", "-"],
                "{\"q\": [1], \"t\": 1}\n",
            ),
        ],
    );
    insta::assert_snapshot!(said);
}

#[test]
fn parameters() {
    let folder = folder(&[
        ("unknown.json", b"{\n  \"m1\": 1,\n  \"lc3\": 2\n}\n"),
        ("text.json", b"{\"m1\": \"heavy\"}"),
        ("nan.json", b"{\"m1\": NaN}"),
        ("array.json", b"[1, 2]"),
        ("twice.json", b"{\"m1\": 1, \"m1\": 2}"),
        ("cut.json", b"{\"m1\": 1,\n"),
        ("empty.json", b""),
        ("latin.json", b"{\"m1\": 1}\n\xe9"),
    ]);
    let check =
        |name: &'static str| -> [&'static str; 4] { ["check", "{M}", "--parameters", name] };
    let names = [
        "{F}/none.json",
        "{F}/unknown.json",
        "{F}/text.json",
        "{F}/nan.json",
        "{F}/array.json",
        "{F}/twice.json",
        "{F}/cut.json",
        "{F}/empty.json",
        "{F}/latin.json",
    ];
    let arguments: Vec<[&str; 4]> = names.into_iter().map(check).collect();
    let cases: Vec<(&str, &[&str], &str)> = names
        .iter()
        .zip(&arguments)
        .map(|(name, a)| (*name, &a[..], ""))
        .collect();
    let said = read_aloud(&folder, &cases);
    insta::assert_snapshot!(said);
}

#[test]
fn simulations() {
    let folder = folder(&[
        ("init.json", b"{\"q\": [0, 0],\n \"w\": 1}"),
        ("order.csv", b"t,u_j1,u_j2\n0,0,0\n1,0,0\n0.5,0,0\n"),
        ("nan.csv", b"t,u_j1,u_j2\n0,0,0\n1,NaN,0\n"),
        ("column.csv", b"t,u_j1,u_j3\n0,0,0\n"),
        ("rows.csv", b"t,u_j1,u_j2\n"),
        ("short.csv", b"t,u_j1,u_j2\n0,0\n"),
        ("latin.csv", b"t,u_j1,u_j2\n0,0,\xe9\n"),
        (
            "gap.model",
            b"model m;\ncoordinate x: m;\ncoordinate y: m;\nparameter m: kg = 1;\nkinetic m/2*(dot(x)^2 + dot(y)^2);\nconstraint c: x^2 + y^2 == -1;\n",
        ),
    ]);
    let base = ["simulate", "{M}", "--duration", "1", "--out", "{F}/log.csv"];
    let with = |more: &[&'static str]| -> Vec<&'static str> { [&base[..], more].concat() };
    let init = ["--init", "{\"q\": [0, 0]}"];
    let csv = |name: &'static str| with(&[&init[..], &["--inputs", name]].concat());
    let runs: Vec<(&str, Vec<&str>)> = vec![
        ("no such initial state", with(&["--init", "{F}/none.json"])),
        ("faulty initial state", with(&["--init", "{F}/init.json"])),
        (
            "faulty initial state, inline",
            with(&["--init", "{\"q\": [0]}"]),
        ),
        ("time runs backwards", csv("{F}/order.csv")),
        ("NaN among the inputs", csv("{F}/nan.csv")),
        ("missing column", csv("{F}/column.csv")),
        ("no rows", csv("{F}/rows.csv")),
        ("row cut short", csv("{F}/short.csv")),
        ("inputs not UTF-8", csv("{F}/latin.csv")),
        ("no inputs", csv("{F}/none.csv")),
        (
            "inputs given twice",
            with(&[
                "--init",
                "{\"q\": [0, 0], \"u\": [1, 1]}",
                "--inputs",
                "{F}/order.csv",
            ]),
        ),
        (
            "noise on no column",
            with(&[&init[..], &["--noise", "q_j3=1"]].concat()),
        ),
        (
            "noise that is no number",
            with(&[&init[..], &["--noise", "q=loud"]].concat()),
        ),
        (
            "duration of no length",
            with(&[&init[..], &["--rate", "-5"]].concat()),
        ),
        (
            "too many rows",
            with(&[&init[..], &["--rate", "1e12"]].concat()),
        ),
        (
            "too many steps",
            with(&[&init[..], &["--max-step", "1e-300"]].concat()),
        ),
        (
            "constraint that nothing fulfils",
            vec![
                "simulate",
                "{F}/gap.model",
                "--init",
                "{\"q\": [1, 0]}",
                "--duration",
                "1",
                "--out",
                "{F}/log.csv",
            ],
        ),
        (
            "no such folder",
            vec![
                "simulate",
                "{M}",
                "--init",
                "{\"q\": [0, 0]}",
                "--duration",
                "1",
                "--out",
                "{F}/none/log.csv",
            ],
        ),
        (
            "a folder for a file",
            vec![
                "simulate",
                "{M}",
                "--init",
                "{\"q\": [0, 0]}",
                "--duration",
                "1",
                "--out",
                "{F}",
            ],
        ),
    ];
    let cases: Vec<(&str, &[&str], &str)> = runs
        .iter()
        .map(|(title, arguments)| (*title, &arguments[..], ""))
        .collect();
    let before = fs::read_dir(folder.path()).unwrap().count();
    let said = read_aloud(&folder, &cases);
    insta::assert_snapshot!(said);
    assert_eq!(
        fs::read_dir(folder.path()).unwrap().count(),
        before,
        "something is left behind"
    );
}

#[test]
fn generation() {
    let folder = folder(&[("file", b"")]);
    let said = read_aloud(
        &folder,
        &[
            (
                "no such language",
                &["generate", "{M}", "--to", "fortran", "--out", "{F}"],
                "",
            ),
            (
                "a file for a folder",
                &["generate", "{M}", "--to", "rust", "--out", "{F}/file"],
                "",
            ),
        ],
    );
    insta::assert_snapshot!(said);
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
}

/// A fault in the last line of a file keeps the answers to all lines before it back.
#[test]
fn of_a_faulty_file_nothing_is_answered() {
    let mut lines = "{\"q\": [0, 0]}\n".repeat(3000);
    lines.push_str("{\"q\": [0]}\n");
    let folder = folder(&[("states.jsonl", lines.as_bytes())]);
    let path = folder.path().join("states.jsonl");
    let said = refuse(
        &[
            "eval",
            "models/pendulum2.model",
            "--states",
            path.to_str().unwrap(),
        ],
        "",
    );
    assert!(said.contains("states.jsonl:3001:7"), "{said}");
}

/// Colours are for terminals.
#[test]
fn messages_in_a_file_have_no_colours() {
    let said = refuse(&["check", "none.model"], "");
    assert!(!said.contains('\u{1b}'), "{said:?}");
}

#[cfg(unix)]
#[test]
fn devices_are_no_models_and_no_logs() {
    refuse(&["check", "/dev/zero"], "");
    refuse(&["check", "/dev/null"], "");
    refuse(
        &["eval", "models/pendulum2.model", "--states", "/dev/zero"],
        "",
    );
    let state = "{\"q\": [0, 0]}";
    refuse(
        &[
            "simulate",
            "models/pendulum2.model",
            "--init",
            state,
            "--duration",
            "1",
            "--out",
            "/dev/null",
        ],
        "",
    );
    dynamics(&[
        "check",
        "models/pendulum2.model",
        "--parameters",
        "/dev/zero",
    ])
    .assert()
    .code(2);
}
