//! `dynamics simulate --control`: closed loops against closed forms, and what is said of files
//! that are wrong.

use crate::support::{read_log, refuse, root, succeed};
use std::f64::consts::PI;
use std::fs;
use tempfile::TempDir;

type Log = (Vec<String>, Vec<Vec<f64>>);

fn write(folder: &TempDir, name: &str, text: &str) -> String {
    let path = folder.path().join(name);
    fs::write(&path, text).unwrap();
    path.to_str().unwrap().to_string()
}

fn simulate(folder: &TempDir, model: &str, control: &str, flags: &[&str]) -> Log {
    let control = write(folder, "control.toml", control);
    let out = folder.path().join("log.csv");
    let arguments = [
        "simulate",
        model,
        "--control",
        &control,
        "--out",
        out.to_str().unwrap(),
    ];
    succeed(&[&arguments, flags].concat(), "");
    read_log(&out)
}

fn column(log: &Log, name: &str) -> Vec<f64> {
    let place = log.0.iter().position(|column| column == name).unwrap();
    log.1.iter().map(|row| row[place]).collect()
}

/// The controller that `docs/control.md` shows.
fn of_the_guide() -> String {
    let page = fs::read_to_string(root().join("docs/control.md")).unwrap();
    let (_, block) = page.split_once("```toml\n").unwrap();
    block.split_once("```").unwrap().0.to_string()
}

const UP: &str = r#"{"q": {"x": 0.2, "theta": 3.0}}"#;

/// Sampled state feedback on encoders, one tick of delay.
#[test]
fn a_cart_pole_balances() {
    let folder = tempfile::tempdir().unwrap();
    let flags = ["--init", UP, "--duration", "10", "--rate", "1000"];
    let log = simulate(&folder, "models/cartpole.model", &of_the_guide(), &flags);
    let (angle, place, force) = (
        column(&log, "q_theta"),
        column(&log, "q_x"),
        column(&log, "u_x"),
    );
    let upright = |theta: &f64| (theta - PI).abs() < 1e-3;
    assert!(angle[8000..].iter().all(upright), "{:?}", angle.last());
    assert!(
        place[8000..].iter().all(|x| x.abs() < 0.02),
        "{:?}",
        place.last()
    );
    assert!(force.iter().all(|u| u.abs() <= 15.0));
    // Nothing arrives in the first tick; then a command is held from tick to tick.
    assert!(force[..10].iter().all(|&u| u == 0.0));
    assert!(
        force
            .windows(2)
            .enumerate()
            .all(|(k, u)| u[0] == u[1] || (k + 1) % 10 == 0)
    );
    assert!(force.windows(2).filter(|u| u[0] != u[1]).count() > 500);
    // Without it the pole falls.
    let idle = of_the_guide().replace("59.9", "0").replace("11.9", "0");
    let log = simulate(&folder, "models/cartpole.model", &idle, &flags);
    assert!(
        !column(&log, "q_theta")
            .iter()
            .all(|theta| (theta - PI).abs() < 1.0)
    );
}

/// The same on encoders that count: 8192 steps a turn, 20 µm along the rail. The controller forms its
/// rates from counts.
#[test]
fn a_cart_pole_balances_on_encoders_that_count() {
    let folder = tempfile::tempdir().unwrap();
    let model = fs::read_to_string(root().join("models/cartpole.model")).unwrap();
    let encoders = "sensor place: m = x { resolution: 2e-5; }\n\
        sensor angle: rad = theta { resolution: 2*pi/8192; rate: 100; }\n";
    let model = write(&folder, "cartpole.model", &(model + encoders));
    let control = of_the_guide()
        .replace("q_x", "place")
        .replace("q_theta", "angle");
    let flags = ["--init", UP, "--duration", "10", "--rate", "100"];
    let log = simulate(&folder, &model, &control, &flags);
    let (angle, force) = (column(&log, "q_theta"), column(&log, "u_x"));
    assert!(angle[800..].iter().all(|theta| (theta - PI).abs() < 5e-3));
    let (place, seen) = (column(&log, "place"), column(&log, "angle"));
    let step = 2.0 * PI / 8192.0;
    for k in 2..1000 {
        let counts = seen[k] / step;
        assert!((counts - counts.round()).abs() < 1e-6);
        assert!((seen[k] - angle[k]).abs() <= step / 2.0 + 1e-12);
        // What acts now was read one sample ago.
        let (x, dx) = (place[k - 1], (place[k - 1] - place[k - 2]) * 100.0);
        let (phi, w) = (seen[k - 1], (seen[k - 1] - seen[k - 2]) * 100.0);
        let command = -9.2 * -x + 59.9 * (PI - phi) - 9.7 * -dx + 11.9 * -w;
        assert!(
            (force[k] - command.clamp(-15.0, 15.0)).abs() < 1e-9,
            "row {k}"
        );
    }
}

const SLIDER: &str = "model slider;\ncoordinate x: m;\ninput drive: N;\nparameter m: kg = 2;\n\
    parameter late: s = 0.025;\nkinetic m/2*dot(x)^2;\nforce x = delay(drive, late);\n\
    output twice = 2*x;\n";

/// A mass that a command pushes after a delay of two and a half samples of its own: between
/// arrivals the force is constant and the motion a parabola.
#[test]
fn commands_arrive_when_they_should() {
    let folder = tempfile::tempdir().unwrap();
    let model = write(&folder, "slider.model", SLIDER);
    write(
        &folder,
        "path.csv",
        "t,q_x,rate(twice)\n0,1,0\n0.5,2,0\n9,2,0\n",
    );
    write(&folder, "push.csv", "t,u_drive\n0,0.25\n10,0.25\n");
    let control = "rate = 100\ndelay = 2\nfeedback = [\"q_x\", \"rate(twice)\"]\n\
        reference = \"path.csv\"\n[gain]\ndrive = [6, 1.5]\n[limits]\ndrive = [-3, 4]\n";
    let push = folder.path().join("push.csv");
    let flags = [
        "--init",
        r#"{"q": [0.5]}"#,
        "--duration",
        "2",
        "--rate",
        "200",
        "--inputs",
        push.to_str().unwrap(),
    ];
    let log = simulate(&folder, &model, control, &flags);
    let (x, u) = (column(&log, "q_x"), column(&log, "u_drive"));

    // By hand, in half samples of 5 ms, which the delay of the model is five of.
    let h: f64 = 0.005;
    let (mut q, mut v, mut before) = (0.5_f64, 0.0_f64, None::<f64>);
    let mut held = vec![0.25; 5];
    let mut pending = Vec::new();
    let mut command = 0.25;
    for k in 0..400 {
        let t = k as f64 * h;
        if k % 2 == 0 {
            let reference = (1.0 + 2.0 * t).min(2.0);
            let rate = before.map_or(0.0, |b| 2.0 * (q - b) / 0.01);
            before = Some(q);
            pending.push((0.25 + 6.0 * (reference - q) - 1.5 * rate).clamp(-3.0, 4.0));
            if pending.len() > 2 {
                command = pending.remove(0);
            }
        }
        assert!((x[k] - q).abs() < 1e-12, "t = {t}: {} against {q}", x[k]);
        assert!(
            (u[k] - command).abs() < 1e-9,
            "t = {t}: {} against {command}",
            u[k]
        );
        held.push(command);
        let force = held.remove(0);
        (q, v) = (q + h * v + h * h / 4.0 * force, v + h * force / 2.0);
    }
    assert!(u.contains(&4.0), "the limit is reached");
}

/// The log shows what the controller read.
#[test]
fn a_controller_reads_what_the_log_shows() {
    let folder = tempfile::tempdir().unwrap();
    let control = "rate = 50\nfeedback = [\"q_x\", \"q_theta\", \"dq_theta\"]\n\
        reference = [0.1, 0, 0]\n[gain]\nx = [30, 2, 4]\n";
    let flags = [
        "--init",
        r#"{"q": [0, 0.3]}"#,
        "--duration",
        "3",
        "--rate",
        "100",
        "--noise",
        "q=0.01",
        "--noise",
        "dq=0.1",
        "--seed",
        "3",
    ];
    let log = simulate(&folder, "models/cartpole.model", control, &flags);
    let of = |name: &str| column(&log, name);
    let (x, theta, rate, u) = (of("q_x"), of("q_theta"), of("dq_theta"), of("u_x"));
    for k in (0..300).step_by(2) {
        let expected = 30.0 * (0.1 - x[k]) - 2.0 * theta[k] - 4.0 * rate[k];
        assert!((u[k] - expected).abs() < 1e-12, "row {k}");
        assert_eq!(u[k + 1], u[k]);
    }
}

#[test]
fn mistakes_have_a_place_and_a_mend() {
    let right = of_the_guide();
    let wrong: [(&str, String); 13] = [
        ("no such key", right.replace("delay", "late")),
        ("not TOML", right.replace("[gain]", "[gain")),
        ("no rate", right.replace("rate = 100", "rate = 0")),
        ("negative delay", right.replace("delay = 1", "delay = -1")),
        (
            "no such reading",
            right.replace("\"q_theta\"", "\"q_thta\""),
        ),
        (
            "no such reading in a rate",
            right.replace("rate(q_x)", "rate(x)"),
        ),
        ("short row", right.replace(", 11.9]", "]")),
        ("no such input", right.replace("x = [-9.2", "cart = [-9.2")),
        ("short reference", right.replace(", 0, 0]", "]")),
        (
            "odd reference",
            right.replace("reference = [0, 3.141592653589793, 0, 0]", "reference = 3"),
        ),
        (
            "no reference",
            right.replace(
                "reference = [0, 3.141592653589793, 0, 0]",
                "reference = \"no.csv\"",
            ),
        ),
        ("limits reversed", right.replace("[-15, 15]", "[15, -15]")),
        (
            "no gains",
            right
                .replace("x = [-9.2, 59.9, -9.7, 11.9]", "")
                .replace("x = [-15, 15]", ""),
        ),
    ];
    let folder = tempfile::tempdir().unwrap();
    let place = folder.path().to_str().unwrap().to_string();
    let mut page = String::new();
    for (title, text) in wrong {
        assert_ne!(text, right, "{title}");
        let control = write(&folder, "control.toml", &text);
        let out = format!("{place}/log.csv");
        let said = refuse(
            &[
                "simulate",
                "models/cartpole.model",
                "--init",
                UP,
                "--duration",
                "1",
                "--control",
                &control,
                "--out",
                &out,
            ],
            "",
        );
        page += &format!("── {title}\n{}\n", said.replace(&place, "FOLDER"));
        assert!(!folder.path().join("log.csv").exists());
    }
    insta::assert_snapshot!(page);
}
