//! `dynamics generate`.

use crate::support::{refuse, root, succeed};
use std::fs;

#[test]
fn the_module_is_the_one_under_review() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("new/folder");
    let arguments = [
        "generate",
        "models/cartpole.model",
        "--to",
        "rust",
        "--out",
        out.to_str().unwrap(),
    ];
    let short = |text: String| text.replace(out.to_str().unwrap(), "OUT");
    let (stdout, stderr) = succeed(&arguments, "");
    assert_eq!(
        (short(stdout).as_str(), stderr.as_str()),
        ("wrote OUT/cartpole.rs\n", "")
    );
    let written = fs::read_to_string(out.join("cartpole.rs")).unwrap();
    let reviewed = fs::read_to_string(root().join("generated/src/cartpole.rs")).unwrap();
    assert_eq!(written, reviewed);

    let before = fs::metadata(out.join("cartpole.rs"))
        .unwrap()
        .modified()
        .unwrap();
    let (stdout, _) = succeed(&arguments, "");
    assert_eq!(short(stdout), "unchanged OUT/cartpole.rs\n");
    assert_eq!(
        before,
        fs::metadata(out.join("cartpole.rs"))
            .unwrap()
            .modified()
            .unwrap()
    );
    assert_eq!(fs::read_dir(&out).unwrap().count(), 1);
}

#[test]
fn overridden_parameters_become_the_nominal_ones() {
    let folder = tempfile::tempdir().unwrap();
    let parameters = folder.path().join("p.json");
    fs::write(&parameters, "{\"mc\": 7.25}").unwrap();
    let out = folder.path().to_str().unwrap();
    succeed(
        &[
            "generate",
            "models/cartpole.model",
            "--to",
            "rust",
            "--out",
            out,
            "--parameters",
            parameters.to_str().unwrap(),
        ],
        "",
    );
    let written = fs::read_to_string(folder.path().join("cartpole.rs")).unwrap();
    assert!(written.contains("7.25"), "the value is not in the module");
}

#[test]
fn c_comes_as_header_and_source() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().to_str().unwrap();
    let arguments = [
        "generate",
        "models/fourbar.model",
        "--to",
        "c",
        "--out",
        out,
    ];
    let (stdout, _) = succeed(&arguments, "");
    assert_eq!(
        stdout.replace(out, "OUT"),
        "wrote OUT/fourbar.h\nwrote OUT/fourbar.c\n"
    );
    for name in ["fourbar.h", "fourbar.c"] {
        let written = fs::read_to_string(folder.path().join(name)).unwrap();
        let reviewed = fs::read_to_string(root().join("generated/c").join(name)).unwrap();
        assert_eq!(written, reviewed, "{name}");
    }
}

#[test]
fn functions_come_on_request() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().to_str().unwrap();
    let request = |model: &'static str, to: &'static str, functions: &'static str| {
        [
            "generate",
            model,
            "--to",
            to,
            "--out",
            out,
            "--functions",
            functions,
        ]
        .map(str::to_string)
    };
    let arguments = request(
        "models/cartpole.model",
        "rust",
        "mass_matrix+bias_force, inverse_dynamics",
    );
    succeed(&arguments.each_ref().map(String::as_str), "");
    let written = fs::read_to_string(folder.path().join("cartpole.rs")).unwrap();
    for line in [
        "--functions mass_matrix+bias_force,inverse_dynamics --out",
        "pub fn mass_matrix_and_bias_force<T: Scalar>(",
        "pub fn inverse_dynamics<T: Scalar>(",
    ] {
        assert!(written.contains(line), "{line}");
    }
    let mistakes = [
        ("inverse_dynamic", "did you mean `inverse_dynamics`?"),
        (
            "foo",
            "the functions are full; inverse_dynamics_derivatives, ",
        ),
        ("foo", "mass_matrix, bias_force, "),
        ("constrained_dynamics", "the model has no constraint"),
        ("force,force_by_time,force_by_time", "asked for twice"),
    ];
    for (functions, message) in mistakes {
        let arguments = request("models/cartpole.model", "c", functions);
        let stderr = refuse(&arguments.each_ref().map(String::as_str), "");
        assert!(stderr.contains(message), "{stderr}");
    }
}

/// What is generated does not say where on whose machine the model lay.
#[test]
fn headers_do_not_hold_absolute_paths() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().to_str().unwrap();
    let within = root().canonicalize().unwrap();
    let within = within.join("models/pendulum.model");
    let elsewhere = folder.path().join("elsewhere.model");
    fs::copy(&within, &elsewhere).unwrap();
    for (model, shown) in [
        (within, "models/pendulum.model"),
        (elsewhere, "elsewhere.model"),
    ] {
        let model = model.to_str().unwrap();
        succeed(&["generate", model, "--to", "c", "--out", out], "");
        for name in ["pendulum.h", "pendulum.c"] {
            let text = fs::read_to_string(folder.path().join(name)).unwrap();
            assert!(
                text.contains(&format!(" * Model:      {shown}\n")),
                "{text}"
            );
            assert!(!text.contains(out) && !text.contains(model), "{text}");
        }
    }
}

/// Of parameters that are constant on this machine only what they do is left.
#[test]
fn constant_parameters_become_numbers() {
    let folder = tempfile::tempdir().unwrap();
    let (out, heavier) = (folder.path(), folder.path().join("p.json"));
    fs::write(&heavier, "{\"mc\": 7.25}").unwrap();
    let generate = |model: &'static str, more: &[&str]| {
        let out = ["--to", "rust", "--out", out.to_str().unwrap()];
        [&["generate", model], &out[..], more].concat().join("\n")
    };
    let run = |arguments: &str| succeed(&arguments.lines().collect::<Vec<_>>(), "");
    let read = |name: &str| fs::read_to_string(out.join(name)).unwrap();
    let operations = |text: &str| -> usize {
        let line = text
            .lines()
            .find(|line| line.contains("  equation_of_motion "));
        let count = line.unwrap().split_whitespace().nth(2).unwrap();
        count.parse().unwrap()
    };

    run(&generate("models/wheelbot.model", &[]));
    assert_eq!(operations(&read("wheelbot.rs")), 268);
    run(&generate("models/wheelbot.model", &["--fold", "all"]));
    assert_eq!(operations(&read("wheelbot.rs")), 174);

    let parameters = heavier.to_str().unwrap();
    let some = ["--fold", "mc, l", "--parameters", parameters];
    run(&generate("models/cartpole.model", &some));
    let text = read("cartpole.rs");
    assert!(text.contains("// Folded in:  mc = 7.25, l = "), "{text}");
    assert!(text.contains(" --fold mc,l --out "), "{text}");
    assert!(!text.contains("p.mc") && text.contains("p.mp"), "{text}");

    let mistakes = [
        ("models/cartpole.model", "mk", "did you mean `mc`?"),
        (
            "models/iiwa7.urdf",
            "all",
            "the model has no parameter to fold in",
        ),
    ];
    for (model, fold, message) in mistakes {
        let arguments = generate(model, &["--fold", fold]);
        let stderr = refuse(&arguments.lines().collect::<Vec<_>>(), "");
        assert!(stderr.contains(message), "{stderr}");
    }
}
