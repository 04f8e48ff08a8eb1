//! What a terminal gets to see of names that hold control characters.

use crate::support::{dynamics, refuse, succeed};
use std::fs;

/// The terminal's title, its colours (twice: eight bits suffice), and a change of direction.
const NAME: &str = "a\u{1b}]0;title\u{7}\u{9b}31m\u{202e}";

fn is_shown(text: &[u8]) -> bool {
    let text = std::str::from_utf8(text).unwrap();
    let hidden = |c: char| (c.is_control() && c != '\n' && c != '\t') || c == '\u{202e}';
    !text.contains(hidden)
}

#[test]
fn names_do_not_steer_the_terminal() {
    let folder = tempfile::tempdir().unwrap();
    let place = folder.path().to_str().unwrap();
    let model = format!("{place}/{NAME}.model");
    let text = format!(
        "/// {NAME}\nmodel m;\ncoordinate \"{NAME}\": m;\nparameter m: kg = 1; // {NAME}\n\
         kinetic m/2*dot(\"{NAME}\")^2;\n"
    );
    fs::write(&model, &text).unwrap();
    fs::write(
        folder.path().join("wrong.model"),
        format!("{text}effect \"{NAME}\"(x);"),
    )
    .unwrap();
    fs::write(
        folder.path().join("log.csv"),
        format!("t,q_{NAME}\n0,{NAME}\n"),
    )
    .unwrap();
    let (wrong, log) = (format!("{place}/wrong.model"), format!("{place}/log.csv"));
    let out = format!("{place}/{NAME}.csv");
    let none = format!("{place}/none/{NAME}");
    let runs: [&[&str]; 9] = [
        &["check", &model],
        &["check", &model, "--json"],
        &["eval", &model, "--states", "-"],
        &["generate", &model, "--to", "c", "--out", place],
        &[
            "simulate",
            &model,
            "--init",
            r#"{"q": [0]}"#,
            "--duration",
            "1",
            "--out",
            &out,
        ],
        &["check", &wrong],
        &["check", &none],
        &["trace", &model, &log],
        &["trace", &model, &none],
    ];
    for arguments in runs {
        let mut command = dynamics(arguments);
        let output = command.write_stdin("{\"q\": [1]}\n").output().unwrap();
        assert!(
            !(output.stdout.is_empty() && output.stderr.is_empty()),
            "{arguments:?}"
        );
        for said in [&output.stdout, &output.stderr] {
            assert!(
                is_shown(said),
                "{arguments:?}\n{}",
                String::from_utf8_lossy(said).escape_debug()
            );
        }
    }
    // Shown, not taken away; and JSON means what it meant.
    assert!(refuse(&["check", &wrong], "").contains(r"a\u001b]0;title\u0007\u009b31m\u202e"));
    let (json, _) = succeed(&["check", &model, "--json"], "");
    let json: serde_json::Value = serde_json::from_str(&json).unwrap();
    assert_eq!(json["coordinates"][0]["name"], NAME);
}
