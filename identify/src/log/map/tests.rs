//! Maps: what they compute, and what is said about mistakes in them.

use super::*;
use crate::log::{Axis, Log, Seen, Wanted};

/// A log of a header and rows computed from the sample's number.
fn csv(header: &str, row: impl Fn(usize) -> Vec<f64>) -> String {
    let rows = (0..80).map(|k| {
        let cells: Vec<String> = row(k).iter().map(f64::to_string).collect();
        cells.join(",") + "\n"
    });
    format!("{header}\n{}", rows.collect::<String>())
}

fn mapped(map: &str, text: &str) -> Log {
    let map = Map::parse("arm.toml", map).unwrap();
    Log::from_bytes_with("arm.csv", text.as_bytes(), Some(&map)).unwrap()
}

fn close(found: &[f64], expected: impl Fn(f64) -> f64) {
    for (k, value) in found.iter().enumerate() {
        let expected = expected(k as f64);
        assert!(
            (value - expected).abs() < 1e-12,
            "{k}: {value} for {expected}"
        );
    }
}

fn refused(map: &str) -> String {
    Map::parse("arm.toml", map).unwrap_err().to_string()
}

#[test]
fn units_signs_and_offsets() {
    let text = csv("stamp,a,v,tau,temp", |k| {
        let k = k as f64;
        vec![1.7e12 + 5.0 * k, 2.0 * k, 30.0 + k, 1500.0, 40.0]
    });
    let log = mapped(
        r#"
        time = { column = "stamp", unit = "ms", start = 0 }
        [columns]
        q_arm = { column = "a", unit = "deg", sign = -1, offset = 0.25 }
        dq_arm = { column = "v", unit = "rpm" }
        u_arm = { column = "tau", unit = "mN*m", factor = 2 }
        "#,
        &text,
    );
    close(&log.t, |k| 0.005 * k);
    close(&log.channels["q_arm"], |k| 0.25 - (2.0 * k).to_radians());
    close(&log.channels["dq_arm"], |k| {
        (30.0 + k) * std::f64::consts::PI / 30.0
    });
    close(&log.channels["u_arm"], |_| 3.0);
    // What the map does not mention stays.
    assert_eq!(
        log.columns(),
        ["t", "a", "dq_arm", "q_arm", "tau", "temp", "u_arm", "v"]
    );
}

#[test]
fn columns_add_up() {
    let text = csv("t,m5,m6", |k| {
        vec![0.01 * k as f64, k as f64, 3.0 * k as f64]
    });
    let log = mapped(
        r#"
        [columns]
        q_wrist = { terms = [{ column = "m5", factor = 0.5 }, { column = "m6", factor = -2, unit = "mrad" }], offset = 1 }
        "#,
        &text,
    );
    close(&log.channels["q_wrist"], |k| 1.0 + 0.5 * k - 0.006 * k);
}

/// A wrist whose second motor also turns with the first joint, as in the TX40. Rates are
/// those of the positions, and the power is the same on both sides.
#[test]
fn transmissions_keep_the_power() {
    let joint = |k: f64| [(0.1 * k).sin(), 0.02 * k];
    let rate = |k: f64| [(0.2 * k).cos(), 0.3];
    let torque = |k: f64| [0.4, (0.3 * k).sin()];
    let ratio = [[45.0, 0.0], [32.0, -32.0]];
    let motor = |x: [f64; 2]| ratio.map(|row: [f64; 2]| row[0] * x[0] + row[1] * x[1]);
    let text = csv("t,m1,m2,w1,w2,i1,i2", |k| {
        let k = k as f64;
        let [m1, m2] = motor(joint(k)).map(f64::to_degrees);
        let [w1, w2] = motor(rate(k));
        let [i1, i2] = torque(k);
        vec![0.01 * k, m1, m2, w1, w2, i1, i2]
    });
    let log = mapped(
        r#"
        [[transmission]]
        coordinates = ["j5", "j6"]
        ratio = [[45, 0], [32, -32]]
        position = ["m1", "m2"]
        position_unit = "deg"
        velocity = ["w1", "w2"]
        torque = ["i1", "i2"]
        offset = [0.0, 0.5]
        "#,
        &text,
    );
    close(&log.channels["q_j5"], |k| joint(k)[0]);
    close(&log.channels["q_j6"], |k| joint(k)[1] + 0.5);
    close(&log.channels["dq_j6"], |k| rate(k)[1]);
    let power = |k: usize| {
        let part = |name: &str| {
            log.channels[&format!("dq_{name}")][k] * log.channels[&format!("u_{name}")][k]
        };
        part("j5") + part("j6")
    };
    for k in 0..80 {
        let [w1, w2] = motor(rate(k as f64));
        let [i1, i2] = torque(k as f64);
        assert!((power(k) - (w1 * i1 + w2 * i2)).abs() < 1e-10);
    }
}

#[test]
fn encoders_that_start_anew_are_joined() {
    // Five turns of a motor at 4096 counts behind a gear of ten.
    let counts = |k: usize| ((250 * k) % 4096) as f64;
    let log = mapped(
        r#"[columns]
        q_arm = { column = "enc", factor = 1.5339807878856412e-4, wraps = 4096 }"#,
        &csv("t,enc", |k| vec![0.01 * k as f64, counts(k)]),
    );
    close(&log.channels["q_arm"], |k| {
        250.0 * k * 1.533_980_787_885_641_2e-4
    });
    // Degrees say themselves what a turn is.
    let log = mapped(
        r#"[columns]
        q_arm = { terms = [{ column = "a", factor = 0.1, unit = "deg" }] }"#,
        &csv("t,a", |k| {
            vec![
                0.01 * k as f64,
                (10.0 * k as f64 + 180.0).rem_euclid(360.0) - 180.0,
            ]
        }),
    );
    close(&log.channels["q_arm"], |k| 0.1 * (10.0 * k).to_radians());
    insta::assert_snapshot!(log.warnings[0], @"`a` jumps by a full turn 2 times, first at t = 0.180000 s; it was unwrapped");
}

#[test]
fn cells_without_a_measurement_are_filled_if_asked() {
    let mut text = String::from("t,q_a,load,cmd\n");
    for k in 0..60 {
        let slow = |value: f64| {
            if k % 4 == 0 {
                value.to_string()
            } else {
                String::new()
            }
        };
        let (x, t) = (f64::from(k), 0.01 * f64::from(k));
        text += &format!("{t},{},{},{}\n", x.sin(), slow(x), slow(2.0 * x));
    }
    let log = mapped(
        r#"[columns]
        q_b = { column = "load", fill = "linear" }
        u_a = { column = "cmd", fill = "hold" }"#,
        &text,
    );
    close(&log.channels["q_b"], |k| k.min(56.0));
    close(&log.channels["u_a"], |k| 8.0 * (k / 4.0).floor());
    // The columns with empty cells are used up.
    assert_eq!(log.columns(), ["t", "q_a", "q_b", "u_a"]);
    let said: Vec<String> = log.warnings.iter().map(ToString::to_string).collect();
    insta::assert_snapshot!(said.join("\n"), @r"
    45 cells of `load` hold no measurement and were filled by straight lines
    45 cells of `cmd` hold no measurement and were filled with the value before
    ");
    let map = Map::parse("arm.toml", "columns.q_b = { column = \"load\" }").unwrap();
    let error = Log::from_bytes_with("arm.csv", text.as_bytes(), Some(&map)).unwrap_err();
    let first: Vec<String> = error
        .to_string()
        .lines()
        .take(3)
        .map(str::to_owned)
        .collect();
    insta::assert_snapshot!(first.join("\n"), @r#"
    arm.csv: 45 problems in the log
      line 3, column `load`: the cell is empty; expected a finite number
        mend: delete the rows without a measurement (a gap in time is allowed), or say in the log's map how they are filled: `fill = "hold"` or `"linear"`
    "#);
}

#[test]
fn what_is_no_map_at_all() {
    let controller = "rate = 100\ndelay = 1\n[gain]\nx = [1.0]\n";
    insta::assert_snapshot!(Map::parse("arm.toml", controller).unwrap_err(), @r"
    arm.toml: this is no map of a log's columns: it states `delay`, and none of `time`, `files`, `columns`, `sensors`, `transmission`
      mend: what has a log's name and `.toml` is taken for its map: give the file another name if it is something else, or write `[columns]` (docs/log-format.md)
    ");
}

#[test]
fn columns_that_are_not_there() {
    let map = Map::parse(
        "arm.toml",
        r#"
        time.column = "Stamp"
        [columns]
        q_arm = { column = "angel" }
        "#,
    );
    let text = csv("stamp,angle", |k| vec![0.01 * k as f64, k as f64]);
    let error = Log::from_bytes_with("arm.csv", text.as_bytes(), Some(&map.unwrap())).unwrap_err();
    insta::assert_snapshot!(error, @r"
    arm.csv: 1 problem in the log
      2 columns are missing; the log has `stamp`, `angle`
        `Stamp`, the time stamps (is it `stamp`?)
        `angel`, what `arm.toml` says `q_arm` is (is it `angle`?)
        mend: say in the log's map which columns they are, or add them to the log; a log without stamps has a rate: `[time] rate = 1000` (Hz)
    ");
}

#[test]
fn what_grows_beyond_numbers_is_refused() {
    let map = Map::parse(
        "arm.toml",
        "columns.q_a = { column = \"x\", factor = 1e308 }",
    )
    .unwrap();
    let text = csv("t,x", |k| vec![0.01 * k as f64, k as f64]);
    let error = Log::from_bytes_with("arm.csv", text.as_bytes(), Some(&map)).unwrap_err();
    assert!(
        error
            .to_string()
            .contains("line 4, column `q_a`: found `inf`"),
        "{error}"
    );
}

#[test]
fn mistakes_have_their_line() {
    let cases = [
        "",
        "[columns\nq_a = 1",
        "[columns]\nq_a = { colum = \"x\" }",
        "[columns]\n\narm = { column = \"x\" }",
        "[columns]\nq_a = { unit = \"deg\" }",
        "[columns]\nq_a = { column = 0 }",
        "time = { rate = 1000, unit = \"ms\" }",
        "time.rate = -5",
        "[columns]\nq_a = { column = \"x\", unit = \"degree\" }",
        "[columns]\nq_a = { column = \"x\", sign = 2 }",
        "[columns]\nq_a = { column = \"x\", factor = nan }",
        "[columns]\nq_a = { column = \"x\", wraps = 0 }",
        "[columns]\nq_a = { column = \"x\", fill = \"zero\" }",
        "time.unit = \"fortnight\"\n[columns]\nq_a = { column = \"x\" }",
        "[[transmission]]\ncoordinates = [\"a\", \"b\"]\nratio = [[1, 2], [2, 4]]\nposition = [\"x\", \"y\"]",
        "[[transmission]]\ncoordinates = [\"a\", \"b\"]\nratio = [[1, 2]]\nposition = [\"x\", \"y\"]",
        "[[transmission]]\ncoordinates = [\"a\"]\nratio = [[2]]\nposition = [\"x\", \"y\"]",
        "[[transmission]]\ncoordinates = [\"a\"]\nratio = [[2]]",
        "[columns]\nq_a = { column = \"x\" }\n[[transmission]]\ncoordinates = [\"a\"]\nratio = [[2]]\nposition = [\"x\"]",
    ];
    let shown: Vec<String> = cases
        .iter()
        .map(|case| format!("{case}\n--> {}\n", refused(case)))
        .collect();
    insta::assert_snapshot!(shown.join("\n"));
}

#[test]
fn maps_stand_beside_logs() {
    for log in [
        "run/arm.csv",
        "run/arm.csv.gz",
        "run/arm.parquet",
        "run/arm.mcap",
        "run/arm.db3",
        "run/arm.ulg",
        "run/arm",
    ] {
        assert_eq!(
            Map::beside(Path::new(log)),
            Path::new("run/arm.toml"),
            "{log}"
        );
    }
    assert_eq!(Map::beside(Path::new("a.b.csv")), Path::new("a.b.toml"));
}

fn names(list: &[&str]) -> Vec<String> {
    list.iter().map(|name| (*name).to_owned()).collect()
}

/// A map to start from for columns of these names, and a model of these coordinates and inputs.
fn start(columns: &[&str], coordinates: &[&str], inputs: &[&str]) -> String {
    let seen: Vec<Seen> = columns.iter().map(|name| Seen::named(name)).collect();
    let axes = |names: &[&str], unit: &str| names.iter().map(|name| axis(name, unit)).collect();
    let wanted = Wanted {
        coordinates: axes(coordinates, "rad"),
        inputs: axes(inputs, "N*m"),
        gauges: Vec::new(),
    };
    template(&seen, &wanted)
}

fn axis(name: &str, unit: &str) -> Axis {
    Axis {
        name: name.to_owned(),
        unit: unit.to_owned(),
        assumed: false,
    }
}

#[test]
fn a_template_guesses_what_it_can() {
    let columns = [
        "Timestamp",
        "shoulder_pos",
        "elbow_pos",
        "vel_1",
        "vel_2",
        "motorCurrent1",
        "motorCurrent2",
        "mode",
    ];
    let both = ["shoulder", "elbow"];
    insta::assert_snapshot!(start(&columns, &both, &both));
    insta::assert_snapshot!(start(&["a", "b"], &["joint 1"], &["joint 1"]));
}

/// A column that states no unit has the model's: a cart is in metres and driven by newtons.
#[test]
fn a_template_has_the_units_of_the_model() {
    let columns = [
        "stamp", "position", "velocity", "effort", "pole_deg", "pole_rpm",
    ];
    let columns: Vec<Seen> = columns.iter().map(|name| Seen::named(name)).collect();
    let wanted = Wanted {
        coordinates: vec![axis("cart", "m"), axis("pole", "rad")],
        inputs: vec![axis("cart", "N")],
        gauges: Vec::new(),
    };
    insta::assert_snapshot!(template(&columns, &wanted));
}

/// Without a header, columns have numbers, and what they look like is said.
#[test]
fn a_template_numbers_columns_without_a_header() {
    let text = csv("", |k| vec![5.0 * k as f64, (0.3 * k as f64).sin(), 4.0]);
    let error = Log::from_bytes("arm.csv", text.trim_start().as_bytes()).unwrap_err();
    insta::assert_snapshot!(error);
    let wanted = Wanted {
        coordinates: vec![axis("arm", "rad")],
        inputs: vec![axis("arm", "N*m")],
        gauges: Vec::new(),
    };
    insta::assert_snapshot!(template(error.columns().unwrap(), &wanted));
    let map = r#"
        time = { column = 1, unit = "ms" }
        [columns]
        q_arm = { column = 2 }
        u_arm = { terms = [{ column = 3, factor = 2 }] }
        "#;
    let log = mapped(map, text.trim_start());
    close(&log.t, |k| 0.005 * k);
    close(&log.channels["q_arm"], |k| (0.3 * k).sin());
    close(&log.channels["u_arm"], |_| 8.0);
    let map = Map::parse("arm.toml", "[columns]\nq_arm = { column = 4 }").unwrap();
    let error = Log::from_bytes_with("arm.csv", text.trim_start().as_bytes(), Some(&map));
    insta::assert_snapshot!(error.unwrap_err(), @r"
    arm.csv: 1 problem in the log
      2 columns are missing; the log has `1`, `2`, `3`
        `t`, the time stamps
        `4`, what `arm.toml` says `q_arm` is
        mend: the log has no header: name its columns by their numbers, from 1 on; a log without stamps has a rate: `[time] rate = 1000` (Hz)
    ");
}

#[test]
fn a_rate_stands_for_stamps() {
    let text = csv("a", |k| vec![k as f64]);
    let log = mapped(
        "time = { rate = 5000, start = 1 }\ncolumns.q_a = { column = \"a\" }",
        &text,
    );
    close(&log.t, |k| 1.0 + 0.0002 * k);
}

/// A column in one file, its neighbour in another: by the map, which stands beside the log.
#[test]
fn files_stand_side_by_side() {
    let folder = std::env::temp_dir().join(format!("beside-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let write = |name: &str, text: &str| std::fs::write(folder.join(name), text).unwrap();
    let read = |map: &str| {
        write("run.toml", map);
        let map = Map::read(&folder.join("run.toml")).unwrap();
        let log = Log::read_with(folder.join("run.csv"), Some(&map));
        log.map_err(|error| {
            error
                .to_string()
                .replace(folder.to_str().unwrap(), "FOLDER")
        })
    };
    write("run.csv", &csv("t,a", |k| vec![0.01 * k as f64, k as f64]));
    write(
        "run-torques.csv",
        &csv("t,a,b", |k| vec![0.01 * k as f64, 2.0, 3.0 * k as f64]),
    );
    write(
        "late.csv",
        &csv("t,b", |k| vec![1.0 + 0.01 * k as f64, 3.0]),
    );
    write("short.csv", "b\n1\n2\n");
    write("numbers.csv", csv("", |k| vec![k as f64, 7.0]).trim_start());
    let log = read(
        r#"
        files.beside = ["{log}-torques.csv", "numbers.csv"]
        [columns]
        q_a = { column = "a" }
        u_a = { column = "b" }
        u_b = { column = "run-torques.a" }
        u_c = { column = 6 }
        "#,
    );
    let log = log.unwrap();
    close(&log.channels["u_a"], |k| 3.0 * k);
    close(&log.channels["u_b"], |_| 2.0);
    close(&log.channels["u_c"], |_| 7.0);
    let refused = ["late.csv", "short.csv", "none.csv"].map(|name| {
        let error = read(&format!(
            "files.beside = [\"{name}\"]\ncolumns.q_a = {{ column = \"a\" }}"
        ));
        error.unwrap_err()
    });
    std::fs::remove_dir_all(&folder).unwrap();
    insta::assert_snapshot!(refused.join("\n"));
}

/// A unit in a column's name says what the column is, and goes into the map.
#[test]
fn a_template_takes_units_from_names() {
    let columns = [
        "time_ms",
        "arm_deg",
        "arm_deg_s",
        "wrist_mrad",
        "wrist_rpm",
        "arm_Nm",
        "tau_wrist",
    ];
    let both = ["arm", "wrist"];
    insta::assert_snapshot!(start(&columns, &both, &both));
    let columns = ["t", "cart_mm", "pos_deg_1", "speed_deg_1"];
    let text = start(&columns, &["cart", "pole_1"], &[]);
    insta::assert_snapshot!(text);
}

/// Neither as deep as they are nor with the square of their number: names of twenty thousand
/// numbers, and tables that nobody closes.
#[test]
fn long_names_and_open_tables_take_no_room() {
    let name = format!("arm_deg{}", "^1".repeat(20_000));
    let text = start(&["t", &name], &["arm"], &[]);
    assert!(text.contains("unit = \"deg\""));
    let text = format!("[columns]\n{}", "q_a = { column = \"a\"\n".repeat(20_000));
    insta::assert_snapshot!(Map::parse("arm.toml", &text).unwrap_err(), @r"
    arm.toml:34: brackets nest more than 32 deep
      mend: close each `{` and `[` in the line that opens it
    ");
}

#[test]
fn a_template_is_a_map() {
    let columns = ["time", "pos \"1\"", "pos2", "tau1", "tau2"];
    let both = ["joint 1", "ü"];
    let text = start(&columns, &both, &both);
    let map = Map::parse("arm.toml", &text).unwrap();
    let log = csv("time,\"pos \"\"1\"\"\",pos2,tau1,tau2", |k| {
        vec![0.01 * k as f64, 1.0, 2.0, 3.0, 4.0]
    });
    let log = Log::from_bytes_with("arm.csv", log.as_bytes(), Some(&map)).unwrap();
    let both = names(&both);
    let record = log.select(&both, &both).unwrap();
    assert_eq!((record.q[1][0], record.u[0][0]), (2.0, 3.0));
}

/// Every map in the documentation is one, and every key is documented.
#[test]
fn documented_maps_are_maps() {
    let page = include_str!("../../../../docs/log-format.md");
    let blocks = page.split("```toml\n").skip(1);
    let blocks: Vec<&str> = blocks
        .map(|block| block.split("```").next().unwrap())
        .collect();
    assert_eq!(blocks.len(), 7);
    for block in &blocks {
        Map::parse("docs/log-format.md", block).unwrap();
    }
    for wrong in [
        "[columns]\nq_a = { x = 1 }",
        "[time]\nx = 1",
        "[files]\nx = 1",
        "[[transmission]]\nx = 1",
    ] {
        let known = refused(wrong);
        let (_, known) = known.split_once("expected ").unwrap();
        let known = known.trim_start_matches("one of ");
        let known = known.lines().next().unwrap();
        for key in known.split(", ") {
            let unit = key.ends_with("_unit`");
            assert!(unit || page.contains(key), "{key} is not documented");
        }
    }
}

mod any_text {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(300) })]

        #[test]
        fn templates_are_maps(columns in prop::collection::vec(".{0,8}", 0..6), name in "[^\0]{1,8}") {
            let columns: Vec<&str> = columns.iter().map(String::as_str).collect();
            let text = start(&columns, &[&name], &[&name]);
            prop_assert!(Map::parse("x.toml", &text).is_ok(), "{}", text);
        }
    }
}

/// What a model calls `gyro_z` stands in degrees per second in a column of another name.
#[test]
fn sensors_have_a_table_of_their_own() {
    let text = csv("t,imu.z", |k| vec![0.01 * k as f64, 90.0]);
    let log = mapped(
        "[sensors]\ngyro_z = { column = \"imu.z\", unit = \"deg/s\", sign = -1 }",
        &text,
    );
    close(&log.channels["gyro_z"], |_| -std::f64::consts::FRAC_PI_2);
}

#[test]
fn a_sensor_is_not_the_clock() {
    let said = refused("[sensors]\nt = { column = \"imu.z\" }");
    assert!(said.contains("arm.toml:2: `t` is the time"), "{said}");
}
