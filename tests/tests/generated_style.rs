//! Generated text is what rustfmt would make of it, for models of any size.

use dynamics_codegen::emit::{Emission, Functions};
use dynamics_codegen::{Library, compile, emit};
use integration_tests::models;
use std::fmt::Write as _;
use std::io::Write as _;
use std::process::{Command, Stdio};

/// rustfmt's own version of a text.
fn formatted(text: &str) -> String {
    let mut child = Command::new("rustfmt")
        .args(["--edition", "2024", "--emit", "stdout"])
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .expect("rustfmt is installed (`rustup component add rustfmt`)");
    let mut input = child.stdin.take().expect("piped");
    input.write_all(text.as_bytes()).expect("rustfmt reads");
    drop(input);
    let output = child.wait_with_output().expect("rustfmt ends");
    assert!(output.status.success());
    String::from_utf8(output.stdout).expect("rustfmt writes text")
}

/// `n` masses in a row on springs, with `m` rods between them and names of a given
/// length: every width of array there is.
fn chain(n: usize, m: usize, prefix: &str) -> String {
    let mut text = String::from("model chain; parameter rate = 2;\n");
    let (mut kinetic, mut potential) = (String::new(), String::new());
    for i in 0..n {
        let _ = writeln!(
            text,
            "coordinate {prefix}{i}; parameter m{prefix}{i} = {i}.5;"
        );
        let _ = writeln!(
            text,
            "input {prefix}{i}; force {prefix}{i} = sin({prefix}{i})*input({prefix}{i});"
        );
        let _ = write!(
            kinetic,
            "m{prefix}{i}*dot({prefix}{i} + {prefix}0*{prefix}{i})^2 + "
        );
        let _ = write!(
            potential,
            "cos({prefix}{i} - {prefix}0)*m{prefix}{i}*{prefix}{i} + "
        );
    }
    let _ = writeln!(text, "kinetic {kinetic}0;\npotential {potential}0;");
    for i in 1..=m {
        let _ = writeln!(
            text,
            "constraint rod{i}: {prefix}{i}*{prefix}0 == cos(rate*t)*{i};"
        );
    }
    text
}

#[test]
fn rustfmt_changes_nothing() {
    let mut texts: Vec<String> = models::all()
        .iter()
        .map(|(p, c)| emit::rust(c, p))
        .collect();
    let everything = models::read(models::EVERYTHING);
    texts.push(emit::rust(&everything, models::EVERYTHING));
    let mut all = models::all();
    all.push((models::EVERYTHING.to_string(), everything));
    all.push((models::MANY.to_string(), models::read(models::MANY)));
    for (path, compiled) in &all {
        let emission = Emission::new(compiled, path, &Functions::full());
        texts.push(emission.unwrap_or_else(|e| panic!("{e}")).rust());
    }
    for n in 1..=13 {
        for (m, prefix) in [
            (0, "q"),
            (1, "x"),
            (n - 1, "joint_"),
            ((n - 1) / 2, "left_front_"),
        ] {
            let m = m.min(n - 1);
            let model = chain(n, m, prefix);
            let compiled = compile("chain.model", &model, &Library::empty())
                .unwrap_or_else(|report| panic!("{report}"));
            texts.push(emit::rust(&compiled, "chain.model"));
            if n % 4 == 1 {
                let functions = "inverse_dynamics_derivatives,residual_derivatives,residual_by_parameters,mass_matrix_by_position";
                let functions = functions.parse().unwrap_or_else(|e| panic!("{e}"));
                let emission = Emission::new(&compiled, "chain.model", &functions);
                texts.push(emission.unwrap_or_else(|e| panic!("{e}")).rust());
            }
        }
    }
    for text in texts {
        let expected = formatted(&text);
        for (number, (ours, theirs)) in text.lines().zip(expected.lines()).enumerate() {
            assert_eq!(ours, theirs, "line {}\n{text}", number + 1);
        }
        assert_eq!(text, expected);
    }
}
