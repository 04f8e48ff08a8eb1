//! `dynamics check` and the help texts.

use crate::support::{self, dynamics, succeed};
use serde_json::Value;
use std::collections::BTreeSet;

#[test]
fn page() {
    let (page, stderr) = succeed(&["check", "models/pendulum2.model"], "");
    assert_eq!(stderr, "");
    insta::assert_snapshot!(page);
}

#[test]
fn page_of_a_constrained_model() {
    let (page, _) = succeed(&["check", "models/duffing_constrained.model"], "");
    insta::assert_snapshot!(page);
}

#[test]
fn json() {
    let (json, _) = succeed(&["check", "models/unicycle2d.model", "--json"], "");
    insta::assert_snapshot!(json);
}

/// Everything that a model can contain.
const WHOLE: &str = "\
/// Everything at once.
model whole;
coordinate x: m;
/// Turns without inertia.
coordinate phi: rad;
input x: N;
parameter m: kg = 2 in 1..3;
kinetic m/2*dot(x)^2;
force x = input(x);
constraint rolling: dot(x) == x*dot(phi);
/// How fast.
output speed = dot(x);
effect viscous(x) { d = 0.5 }
/// What the air takes.
table air(v: m/s): N { -10: -7; 0: 0; 10: 7; }
force x = -air(dot(x));
part lump(at, kg) { body lead { frame: at; mass: kg; } }
/// Keeps it down.
use ballast = lump(translate(x, 0, 0), 0.5);
";

#[test]
fn everything_a_model_can_contain() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("whole.model");
    std::fs::write(&path, WHOLE).unwrap();
    let parameters = folder.path().join("parameters.json");
    std::fs::write(&parameters, r#"{"m": 4, "viscous_x_d": 0.25}"#).unwrap();
    let arguments = [
        "check",
        path.to_str().unwrap(),
        "--parameters",
        parameters.to_str().unwrap(),
    ];
    let (page, stderr) = succeed(&arguments, "");
    let short = |text: &str| text.replace(folder.path().to_str().unwrap(), "FOLDER");
    insta::assert_snapshot!(format!("{}\n{}", short(&page), short(&stderr)));

    let (json, _) = succeed(&[&arguments[..], &["--json"]].concat(), "");
    let json: Value = serde_json::from_str(&json).unwrap();
    assert_eq!(json["parameters"][0]["value"], 4.0);
    assert_eq!(json["parameters"][0]["nominal"], 2.0);
    assert_eq!(json["parameters"][1]["effect"], "viscous(x)");
    assert_eq!(json["constraints"][0]["kind"], "nonholonomic");
    let warnings = json["warnings"].as_array().unwrap().iter();
    let lines: BTreeSet<_> = warnings.filter_map(|w| w["line"].as_u64()).collect();
    assert_eq!(lines, BTreeSet::from([5]));
    assert_eq!(json["outputs"][0]["unit"], "m/s");
}

/// The counts are those of the header of the generated code, which counts for itself.
#[test]
fn operation_counts_agree_with_the_generated_code() {
    let (json, _) = succeed(&["check", "models/fourbar.model", "--json"], "");
    let json: Value = serde_json::from_str(&json).unwrap();
    let generated =
        std::fs::read_to_string(support::root().join("generated/src/fourbar.rs")).unwrap();
    let total = |function: &str| -> u64 {
        let line = generated
            .lines()
            .find(|line| line.split_whitespace().nth(1) == Some(function));
        line.unwrap()
            .split_whitespace()
            .nth(2)
            .unwrap()
            .parse()
            .unwrap()
    };
    assert_eq!(json["operations"]["mass_matrix"], total("mass_matrix"));
    assert_eq!(json["operations"]["bias_force"], total("bias_force"));
    assert_eq!(json["operations"]["force"], total("force"));
}

#[test]
fn help() {
    for command in [
        "check",
        "eval",
        "generate",
        "simulate",
        "completions",
        "man",
    ] {
        let (help, _) = succeed(&[command, "--help"], "");
        assert!(help.contains("Examples:"), "{command} shows no example");
        let long = help.lines().map(|line| line.chars().count()).max().unwrap();
        assert!(long <= 100, "{command}: a line of {long} characters");
    }
    let (help, _) = succeed(&["--help"], "");
    insta::assert_snapshot!(help);
}

/// The commands that the help lists, but for `help` itself.
fn commands() -> BTreeSet<String> {
    let (help, _) = succeed(&["--help"], "");
    let (_, list) = help.split_once("Commands:\n").unwrap();
    let (list, _) = list.split_once("\n\n").unwrap();
    let names = list
        .lines()
        .filter_map(|line| line.split_whitespace().next());
    names.filter(|n| *n != "help").map(str::to_owned).collect()
}

#[test]
fn every_command_has_a_manual_page() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("man1");
    succeed(&["man", "--out", out.to_str().unwrap()], "");
    let names = std::fs::read_dir(&out).unwrap();
    let written: BTreeSet<String> = names
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    let mut expected: BTreeSet<String> = commands();
    assert!(expected.len() >= 9, "{expected:?}");
    expected = expected.iter().map(|c| format!("dynamics-{c}.1")).collect();
    expected.insert("dynamics.1".to_owned());
    assert_eq!(written, expected);
    let page = std::fs::read_to_string(out.join("dynamics-trace.1")).unwrap();
    assert!(page.contains(r"\-\-time\-limit"), "{page}");
    assert!(page.contains("dynamics\\-trace"), "{page}");
}

#[test]
fn a_shell_reads_the_completions() {
    let (script, _) = succeed(&["completions", "bash"], "");
    for command in commands() {
        assert!(
            script.contains(&format!("dynamics,{command})")),
            "{command}"
        );
    }
    let file = tempfile::NamedTempFile::new().unwrap();
    std::fs::write(file.path(), &script).unwrap();
    let line = "source \"$1\"; COMP_WORDS=(dynamics trace --time); COMP_CWORD=2; COMPREPLY=(); \
                _dynamics dynamics --time trace; echo \"${COMPREPLY[@]}\"";
    let shell = std::process::Command::new("bash")
        .args(["--norc", "-c", line, "bash"])
        .arg(file.path())
        .output();
    let answer = shell.expect("bash");
    let said = String::from_utf8_lossy(&answer.stderr);
    assert_eq!(
        String::from_utf8_lossy(&answer.stdout).trim(),
        "--time-limit",
        "{said}"
    );
}

#[test]
fn wrong_usage_is_bad_input() {
    for arguments in [
        &["chek"][..],
        &["check"],
        &["eval", "x.model"],
        &["check", "x", "--jsn"],
    ] {
        dynamics(arguments).assert().code(2);
    }
}
