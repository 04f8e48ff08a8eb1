//! Sensors against closed forms: what `eval` says of them and their derivatives, and what
//! `simulate` makes of them.

use crate::support::{self, eval, gap, matrix, read_log, refuse, root, succeed};
use dynamics_codegen::Tape;
use dynamics_codegen::emit::Emission;
use integration_tests::models;
use serde_json::{Value, json};
use std::fs;
use tempfile::TempDir;

/// A pendulum with an inertial sensor on its rod at `r`, whose x axis points along the rod, an
/// encoder on its pivot, and a load cell at a stop that pushes along a rail.
const SWING: &str = "model swing;\n\
    coordinate phi: rad;\ninput motor: N*m;\n\
    parameter m: kg = 2;\nparameter r: m = 0.3;\nparameter k: N*m/A = 0.05;\n\
    constant g: m/s^2 = 9.81;\n\
    body rod { frame: rotate_z(-pi/2) * rotate_z(phi); mass: m; center: (0.5, 0, 0); }\n\
    gravity (0, -g, 0);\nforce phi = motor;\n\
    frame board = rod * translate(r, 0, 0);\n\
    sensor gyro: rad/s = gyroscope(board) { noise: 1e-3; }\n\
    sensor felt: m/s^2 = accelerometer(board);\n\
    sensor moved = acceleration(board);\n\
    sensor crank: rad = encoder_z(rod, world) { resolution: pi/512; rate: 50; }\n\
    sensor place = position(board);\n\
    sensor turn: rad/s^2 = dot(dot(phi));\n\
    sensor current: A = motor/k;\n";

/// Values by name, and the slopes by q, v and u.
fn by_hand(phi: f64, w: f64, u: f64) -> Vec<(&'static str, f64, [f64; 3])> {
    let (m, l, r, g, k) = (2.0, 0.5, 0.3, 9.81, 0.05);
    let (s, c) = phi.sin_cos();
    let inertia = m * l * l;
    let a = (u - m * g * l * s) / inertia;
    let (a_q, a_u) = (-m * g * l * c / inertia, 1.0 / inertia);
    vec![
        ("gyro_x", 0.0, [0.0; 3]),
        ("gyro_y", 0.0, [0.0; 3]),
        ("gyro_z", w, [0.0, 1.0, 0.0]),
        // Along the rod (outwards) and across it; gravity points down.
        ("felt_x", -r * w * w - g * c, [g * s, -2.0 * r * w, 0.0]),
        ("felt_y", r * a + g * s, [r * a_q + g * c, 0.0, r * a_u]),
        ("felt_z", 0.0, [0.0; 3]),
        (
            "moved_x",
            r * (c * a - s * w * w),
            [
                r * (-s * a + c * a_q - c * w * w),
                -2.0 * r * s * w,
                r * c * a_u,
            ],
        ),
        (
            "moved_y",
            r * (s * a + c * w * w),
            [
                r * (c * a + s * a_q - s * w * w),
                2.0 * r * c * w,
                r * s * a_u,
            ],
        ),
        ("moved_z", 0.0, [0.0; 3]),
        (
            "crank",
            (phi - std::f64::consts::FRAC_PI_2)
                .sin()
                .atan2((phi - std::f64::consts::FRAC_PI_2).cos()),
            [1.0, 0.0, 0.0],
        ),
        ("place_x", r * s, [r * c, 0.0, 0.0]),
        ("place_y", -r * c, [r * s, 0.0, 0.0]),
        ("place_z", 0.0, [0.0; 3]),
        ("turn", a, [a_q, 0.0, a_u]),
        ("current", u / k, [0.0, 0.0, 1.0 / k]),
    ]
}

fn file(folder: &TempDir, name: &str, text: &str) -> String {
    let path = folder.path().join(name);
    fs::write(&path, text).unwrap();
    path.to_str().unwrap().to_string()
}

#[test]
fn sensors_show_what_the_textbook_says() {
    let folder = tempfile::tempdir().unwrap();
    let model = file(&folder, "swing.model", SWING);
    for (phi, w, u) in [(0.4, 1.5, 3.0), (2.9, -4.0, -1.0), (-7.0, 0.0, 0.0)] {
        let state = json!({"q": [phi], "v": [w], "u": [u]}).to_string();
        let answer = &eval(&model, &["--derivatives"], &state)[0];
        let expected = by_hand(phi, w, u);
        let names: Vec<&String> = answer["sensors"].as_object().unwrap().keys().collect();
        assert_eq!(names.len(), expected.len());
        let slopes: Vec<Vec<Vec<f64>>> = ["q", "v", "u"]
            .iter()
            .map(|by| matrix(&answer[format!("dsensors_d{by}")]))
            .collect();
        // Objects of the reader are in alphabetical order; rows are in the model's.
        for (row, (name, value, by)) in expected.into_iter().enumerate() {
            let found = answer["sensors"][name].as_f64().unwrap();
            assert!(
                gap(&[found], &[value]) < 1e-12,
                "{name}: {found} against {value}"
            );
            let found = [slopes[0][row][0], slopes[1][row][0], slopes[2][row][0]];
            assert!(gap(&found, &by) < 1e-12, "{name}: {found:?} against {by:?}");
        }
    }
}

/// A mass held on a slope by a constraint: the load cell shows its multiplier, by parameters, too.
#[test]
fn a_load_cell_shows_a_multiplier() {
    let folder = tempfile::tempdir().unwrap();
    let text = "model held;\ncoordinate x: m;\ncoordinate y: m;\ninput push: N;\n\
        parameter m: kg = 3;\nkinetic m/2*(dot(x)^2 + dot(y)^2);\nconstant g: m/s^2 = 9.81;\n\
        potential m*g*y;\nforce y = -push;\nconstraint table: y == 0;\n\
        sensor cell: N = multiplier(table) { noise: 0.5; rate: 10; }\n";
    let model = file(&folder, "held.model", text);
    let answer = &eval(&model, &["--derivatives"], r#"{"q": [1, 0], "u": [4]}"#)[0];
    let force = answer["sensors"]["cell"].as_f64().unwrap();
    assert!((force - (3.0 * 9.81 + 4.0)).abs() < 1e-12, "{force}");
    let slope = |key: &str| matrix(&answer[key])[0][0];
    assert!((slope("dsensors_du") - 1.0).abs() < 1e-14);
    let by_mass = answer["dsensors_dparameters"]["m"][0].as_f64().unwrap();
    assert!((by_mass - 9.81).abs() < 1e-13, "{by_mass}");
}

/// Steps, noise of the stated size, and readings that are held until the next one.
#[test]
fn a_log_shows_noise_steps_and_rates() {
    let folder = tempfile::tempdir().unwrap();
    let model = file(&folder, "swing.model", SWING);
    let out = folder.path().join("log.csv");
    let run = |seed: &str| {
        let flags = [
            "simulate",
            &model,
            "--init",
            r#"{"q": [1.2]}"#,
            "--duration",
            "4",
            "--rate",
            "200",
            "--seed",
            seed,
            "--out",
            out.to_str().unwrap(),
        ];
        let (_, said) = succeed(&flags, "");
        assert!(said.contains(&format!("noise with seed {seed}")), "{said}");
        read_log(&out)
    };
    let (heading, rows) = run("1");
    let place = |name: &str| heading.iter().position(|column| column == name).unwrap();
    let column = |name: &str| -> Vec<f64> { rows.iter().map(|row| row[place(name)]).collect() };
    let (phi, w, a) = (column("q_phi"), column("dq_phi"), column("ddq_phi"));
    // Without noise, rate or steps: what the state says.
    let (felt, turn) = (column("felt_x"), column("turn"));
    for k in 0..rows.len() {
        let expected = -0.3 * w[k] * w[k] - 9.81 * phi[k].cos();
        assert!((felt[k] - expected).abs() < 1e-12);
        assert!((turn[k] - a[k]).abs() < 1e-12);
    }
    let noise: Vec<f64> = column("gyro_z")
        .iter()
        .zip(&w)
        .map(|(g, w)| g - w)
        .collect();
    let sd = (noise.iter().map(|e| e * e).sum::<f64>() / noise.len() as f64).sqrt();
    assert!((sd / 1e-3 - 1.0).abs() < 0.1, "{sd}");
    // Every fourth row has a new reading, in steps.
    let step = std::f64::consts::PI / 512.0;
    let crank = column("crank");
    for k in 0..rows.len() {
        let read = phi[k - k % 4] - std::f64::consts::FRAC_PI_2;
        assert!(
            (crank[k] - (read / step).round() * step).abs() < 1e-12,
            "row {k}"
        );
    }
    // The same seed gives the same log, another one another.
    assert_eq!(run("1").1, rows);
    let other = run("2").1;
    assert_eq!(other[7][place("felt_x")], rows[7][place("felt_x")]);
    assert_ne!(other[7][place("gyro_z")], rows[7][place("gyro_z")]);
}

/// The columns that `simulate` makes of a model at this many rows per second, by name.
fn simulated(folder: &TempDir, text: &str, rate: &str) -> impl Fn(&str) -> Vec<f64> + use<> {
    let model = file(folder, "swing.model", text);
    let out = folder.path().join("log.csv");
    let flags = [
        "--init",
        r#"{"q": [1.2]}"#,
        "--duration",
        "2",
        "--rate",
        rate,
    ];
    let begin = ["simulate", &model, "--out", out.to_str().unwrap()];
    succeed(&[&begin[..], &flags].concat(), "");
    let (heading, rows) = read_log(&out);
    move |name| {
        let place = heading.iter().position(|column| column == name).unwrap();
        rows.iter().map(|row| row[place]).collect()
    }
}

/// Offsets, scales, times and a board that is mounted askew: what a log shows beside that of a
/// faultless machine, and the motion as it is.
#[test]
fn a_log_shows_what_sensors_get_wrong() {
    let folder = tempfile::tempdir().unwrap();
    let right = SWING
        .replace("{ noise: 1e-3; }", ";")
        .replace("rate: 50; ", "");
    let wrong = "effect measurement_offset(moved_x) { offset = 0.25 }\n\
        effect measurement_scale(turn) { scale = 0.9 }\n\
        effect mounting_tilt(board) { phi_z = 0.1 }\n\
        effect time_shift(place_x) { tau = 0.0125 }\n\
        effect time_shift(place_y) { tau = -0.0075 }\n\
        measured current = current + 2;\nmeasured current = 3*current;\n";
    let wrong = simulated(&folder, &format!("{right}{wrong}"), "100");
    // Every row of the other log, and what lies between.
    let fine = simulated(&folder, &right, "400");
    let right = simulated(&folder, &right, "100");
    let near = |found: &[f64], expected: &dyn Fn(usize) -> f64| {
        for (k, found) in found.iter().enumerate() {
            let expected = expected(k);
            assert!(
                (found - expected).abs() < 1e-9,
                "row {k}: {found}, {expected}"
            );
        }
    };
    for same in ["q_phi", "ddq_phi", "gyro_z", "crank", "moved_y"] {
        near(&wrong(same), &|k| right(same)[k]);
    }
    near(&wrong("moved_x"), &|k| right("moved_x")[k] + 0.25);
    near(&wrong("turn"), &|k| 0.9 * right("turn")[k]);
    near(&wrong("current"), &|k| 3.0 * (right("current")[k] + 2.0));
    let (x, y, (sin, cos)) = (right("felt_x"), right("felt_y"), 0.1_f64.sin_cos());
    near(&wrong("felt_x"), &|k| cos * x[k] + sin * y[k]);
    near(&wrong("felt_y"), &|k| cos * y[k] - sin * x[k]);
    // Before it began the machine stood as it did then.
    let at = |name: &str, row: usize, by: isize| fine(name)[(4 * row).saturating_add_signed(by)];
    near(&wrong("place_x"), &|k| at("place_x", k, -5));
    let early = wrong("place_y");
    near(&early[..early.len() - 1], &|k| at("place_y", k, 3));
}

/// No controller sees what is to come.
#[test]
fn a_controller_reads_late_sensors_and_no_early_ones() {
    let folder = tempfile::tempdir().unwrap();
    let control = "rate = 100\nfeedback = [\"turn\"]\n[gain]\nmotor = [0.1]\n";
    let control = file(&folder, "control.toml", control);
    let out = folder.path().join("log.csv");
    let flags = |model: &str| -> Vec<String> {
        let flags = [
            "simulate",
            model,
            "--init",
            r#"{"q": [0.2]}"#,
            "--duration",
            "1",
            "--rate",
        ];
        let rest = ["100", "--control", &control, "--out", out.to_str().unwrap()];
        flags.into_iter().chain(rest).map(String::from).collect()
    };
    let shifted = |tau: &str| {
        let text = format!("{SWING}effect time_shift(turn) {{ tau = {tau} }}\n");
        file(&folder, "swing.model", &text)
    };
    let late = flags(&shifted("0.02"));
    succeed(&late.iter().map(String::as_str).collect::<Vec<_>>(), "");
    let (heading, rows) = read_log(&out);
    let place = |name: &str| heading.iter().position(|column| column == name).unwrap();
    let (turn, u, a) = (place("turn"), place("u_motor"), place("ddq_phi"));
    for k in 2..rows.len() {
        // The command of a row arrives in it, behind what the sensor saw.
        assert!((rows[k][u] + 0.1 * rows[k][turn]).abs() < 1e-12, "row {k}");
        let before = rows[k - 2][a] - (rows[k - 2][u] - rows[k.saturating_sub(3)][u]) / 0.5;
        assert!(k < 3 || (rows[k][turn] - before).abs() < 1e-9, "row {k}");
    }
    let early = flags(&shifted("-0.02"));
    let said = refuse(&early.iter().map(String::as_str).collect::<Vec<_>>(), "");
    assert!(
        said.contains("the sensor `turn` shows what comes 0.02 s later"),
        "{said}"
    );
}

/// A controller reads sensors at their own rate.
#[test]
fn a_controller_feeds_on_sensors() {
    let folder = tempfile::tempdir().unwrap();
    let model = file(&folder, "swing.model", SWING);
    let control = "rate = 100\nfeedback = [\"crank\", \"gyro_z\"]\nreference = [-1, 0]\n\
        [gain]\nmotor = [40, 6]\n";
    let control = file(&folder, "control.toml", control);
    let out = folder.path().join("log.csv");
    let flags = [
        "simulate",
        &model,
        "--init",
        r#"{"q": [0.2]}"#,
        "--duration",
        "3",
        "--rate",
        "100",
        "--control",
        &control,
        "--out",
        out.to_str().unwrap(),
    ];
    succeed(&flags, "");
    let (heading, rows) = read_log(&out);
    let place = |name: &str| heading.iter().position(|column| column == name).unwrap();
    let (crank, gyro, u) = (place("crank"), place("gyro_z"), place("u_motor"));
    for (k, row) in rows.iter().enumerate() {
        let expected = 40.0 * (-1.0 - row[crank]) - 6.0 * row[gyro];
        assert!((row[u] - expected).abs() < 1e-12, "row {k}");
    }
}

/// `C` and `D` of sensors are what `eval` says of their derivatives.
#[test]
fn linearise_has_rows_of_sensors() {
    let folder = tempfile::tempdir().unwrap();
    let model = file(&folder, "swing.model", SWING);
    let state = r#"{"q": [0.4], "v": [1.5], "u": [3]}"#;
    let (answer, _) = succeed(&["linearise", &model, "--state", state, "--json"], "");
    let answer: Value = serde_json::from_str(&answer).unwrap();
    for (name, value, by) in by_hand(0.4, 1.5, 3.0) {
        let row = support::vector(&answer["C"][name]);
        assert!(gap(&row, &by[..2]) < 1e-12, "{name}");
        assert!(
            gap(&support::vector(&answer["D"][name]), &by[2..]) < 1e-12,
            "{name}"
        );
        assert!(
            gap(&[answer["y"][name].as_f64().unwrap()], &[value]) < 1e-12,
            "{name}"
        );
    }
}

#[test]
fn check_lists_sensors() {
    let folder = tempfile::tempdir().unwrap();
    let model = file(&folder, "swing.model", SWING);
    let (page, _) = succeed(&["check", &model], "");
    let (_, sensors) = page.split_once("sensors\n").unwrap();
    let (sensors, _) = sensors.split_once("\n\n").unwrap();
    insta::assert_snapshot!(sensors);
    let model = file(
        &folder,
        "odd.model",
        &SWING.replace("noise: 1e-3", "noise: m"),
    );
    let said = refuse(&["check", &model], "");
    insta::assert_snapshot!(said.replace(folder.path().to_str().unwrap(), "FOLDER"));
}

/// An inertial sensor on the last link of a robot, with the accelerations that its torques make,
/// against Pinocchio (`pinocchio/sensors.py`).
#[test]
fn inertial_sensors_agree_with_pinocchio() {
    let path = root().join("tests/pinocchio/sensors.json");
    let file: Value = serde_json::from_str(&fs::read_to_string(path).unwrap()).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let robots = file["robots"].as_array().unwrap();
    assert_eq!(robots.len(), 2);
    for robot in robots {
        let urdf = robot["urdf"].as_str().unwrap();
        fs::copy(root().join("models").join(urdf), folder.path().join(urdf)).unwrap();
        let offset = support::vector(&file["translate"]);
        let text = format!(
            "model robot;\nurdf {urdf:?} {{ losses: ignore; }}\n\
            frame board = {} * translate({:?}, {:?}, {:?}) * rotate_x({}) * rotate_z({});\n\
            sensor gyro = gyroscope(board);\nsensor felt = accelerometer(board);\n",
            robot["link"].as_str().unwrap(),
            offset[0],
            offset[1],
            offset[2],
            file["rotate_x"],
            file["rotate_z"],
        );
        let model = self::file(&folder, "robot.model", &text);
        let joints = robot["joints"].as_array().unwrap();
        let by_name = |values: &Value| -> Value {
            let names = joints.iter().map(|name| name.as_str().unwrap().to_string());
            let pairs = names
                .zip(support::vector(values))
                .map(|(k, x)| (k, json!(x)));
            Value::Object(pairs.collect())
        };
        let states = robot["states"].as_array().unwrap();
        assert_eq!(states.len(), 10);
        let lines: String = states
            .iter()
            .map(|s| {
                let (q, v, u) = (by_name(&s["q"]), by_name(&s["v"]), by_name(&s["tau"]));
                format!("{}\n", json!({"q": q, "v": v, "u": u}))
            })
            .collect();
        for (answer, state) in eval(&model, &[], &lines).iter().zip(states) {
            for sensor in ["gyro", "felt"] {
                let shown = ["x", "y", "z"].map(|axis| {
                    let name = format!("{sensor}_{axis}");
                    answer["sensors"][name].as_f64().unwrap()
                });
                let expected = support::vector(&state[sensor]);
                let size = expected.iter().fold(1.0_f64, |m, x| m.max(x.abs()));
                for (shown, expected) in shown.iter().zip(&expected) {
                    let off = (shown - expected).abs() / size;
                    assert!(off < 1e-10, "{urdf}: {sensor} off by {off:.1e}");
                }
            }
        }
    }
}

/// Of a machine with a constraint: what generated code predicts, with its slopes, and what `eval`
/// solves at run time.
#[test]
fn generated_code_and_eval_agree() {
    let compiled = models::read(models::SENSED);
    let functions = "sensor_derivatives".parse().unwrap();
    let emission = Emission::new(&compiled, models::SENSED, &functions).unwrap();
    let mut functions = emission.functions();
    let (_, quantities) = functions
        .find(|(name, _)| *name == "sensor_derivatives")
        .unwrap();
    let names: Vec<&str> = quantities.iter().map(|q| q.name.as_str()).collect();
    let expected = ["", "_by_position", "_by_velocity", "_by_input"];
    assert_eq!(names, expected.map(|by| format!("predicted_sensors{by}")));
    let wave = |k: usize, i: usize| ((7 * k + i) as f64).sin();
    for k in 0..20 {
        let state: Vec<f64> = (0..9).map(|i| wave(k, i)).collect();
        let (t, q, v, u) = (state[0], &state[1..4], &state[4..7], &state[7..9]);
        let line = json!({"t": t, "q": q, "v": v, "u": u}).to_string();
        let answer = &eval(models::SENSED, &["--derivatives"], &line)[0];
        let shown = compiled.model.sensors.iter().map(|sensor| {
            let value = &answer["sensors"][&sensor.name];
            value.as_f64().unwrap()
        });
        let slopes =
            ["dq", "dv", "du"].map(|by| matrix(&answer[format!("dsensors_{by}")]).concat());
        let expected = [vec![shown.collect::<Vec<f64>>()], slopes.to_vec()].concat();
        let mut arguments = state;
        arguments.extend(compiled.model.nominal_parameters());
        // Stated accelerations and multipliers, which nothing here reads.
        arguments.extend([f64::NAN; 4]);
        for (quantity, expected) in quantities.iter().zip(expected) {
            let tape = Tape::new(emission.graph(), &quantity.entries, &emission.arguments());
            let found = tape.evaluate(&arguments);
            assert!(
                gap(&found, &expected) < 1e-9,
                "{}, state {k}",
                quantity.name
            );
        }
    }
}
