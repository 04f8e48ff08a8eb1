//! `dynamics simulate`, against laws and closed forms.

use crate::support::{self, read_log, refuse, succeed};
use std::fs;
use std::path::Path;
use tempfile::TempDir;

/// Runs `simulate` and reads its log and what it said.
fn simulate(folder: &TempDir, model: &str, flags: &[&str]) -> (Vec<String>, Vec<Vec<f64>>, String) {
    let out = folder.path().join("log.csv");
    let arguments = [&["simulate", model, "--out", out.to_str().unwrap()], flags].concat();
    let (stdout, stderr) = succeed(&arguments, "");
    assert_eq!(stdout, "");
    let (heading, rows) = read_log(&out);
    (
        heading,
        rows,
        stderr.replace(folder.path().to_str().unwrap(), "FOLDER"),
    )
}

fn write(folder: &TempDir, name: &str, text: &str) -> String {
    let path = folder.path().join(name);
    fs::write(&path, text).unwrap();
    path.to_str().unwrap().to_string()
}

fn files(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).unwrap();
    let mut names: Vec<String> = entries
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    names
}

/// Kinetic and potential energy of `pendulum2`, from its geometry.
fn pendulum_energy(row: &[f64]) -> f64 {
    let [m1, l1, lc1, i1, m2, lc2, i2, g] = [1.2, 0.45, 0.22, 0.024, 0.8, 0.19, 0.012, 9.81];
    let (q1, phi, v1, rate) = (row[1], row[1] + row[2], row[3], row[3] + row[4]);
    let vx = l1 * v1 * q1.cos() + lc2 * rate * phi.cos();
    let vy = l1 * v1 * q1.sin() + lc2 * rate * phi.sin();
    let kinetic = (m1 * lc1 * lc1 + i1) * v1 * v1 + m2 * (vx * vx + vy * vy) + i2 * rate * rate;
    let height = -m1 * lc1 * q1.cos() - m2 * (l1 * q1.cos() + lc2 * phi.cos());
    0.5 * kinetic + g * height
}

#[test]
fn a_double_pendulum_keeps_its_energy() {
    let folder = tempfile::tempdir().unwrap();
    let flags = [
        "--init",
        r#"{"q": [2, -0.5], "v": [1, 0]}"#,
        "--duration",
        "10",
    ];
    let (heading, rows, stderr) = simulate(&folder, "models/pendulum2.model", &flags);
    assert_eq!(
        heading,
        [
            "t", "q_j1", "q_j2", "dq_j1", "dq_j2", "ddq_j1", "ddq_j2", "u_j1", "u_j2"
        ]
    );
    assert_eq!(rows.len(), 1001);
    assert_eq!(rows[1000][0], 10.0);
    insta::assert_snapshot!(stderr, @"wrote FOLDER/log.csv: 1001 rows at 100 Hz");
    let first = pendulum_energy(&rows[0]);
    let moved = rows
        .iter()
        .map(|row| (row[1] - rows[0][1]).abs())
        .fold(0.0, f64::max);
    assert!(moved > 1.0, "nothing moves");
    for row in &rows {
        let drift = (pendulum_energy(row) - first).abs() / first.abs();
        assert!(drift < 1e-8, "{drift:e} at {} s", row[0]);
    }
}

const BEAD: &str = "\
model bead;
coordinate x: m;
coordinate y: m;
parameter m: kg = 0.7;
parameter r: m = 2;
constant g: m/s^2 = 9.81;
kinetic m/2*(dot(x)^2 + dot(y)^2);
potential m*g*y;
constraint ring: x^2 + y^2 == r^2;
";

#[test]
fn a_bead_stays_on_its_ring_and_keeps_its_energy() {
    let folder = tempfile::tempdir().unwrap();
    let model = write(&folder, "bead.model", BEAD);
    // Off the ring, and not along it.
    let flags = [
        "--init",
        r#"{"q": [1.9, 0.1], "v": [1, 1]}"#,
        "--duration",
        "3",
    ];
    let (_, rows, stderr) = simulate(&folder, &model, &flags);
    insta::assert_snapshot!(stderr);
    let energy = |row: &[f64]| 0.5 * (row[3] * row[3] + row[4] * row[4]) + 9.81 * row[2];
    let first = energy(&rows[0]);
    for row in &rows {
        assert!(
            (row[1].hypot(row[2]) - 2.0).abs() < 1e-10,
            "leaves the ring"
        );
        // Per mass, against the largest difference in height.
        let drift = (energy(row) - first).abs() / (9.81 * 4.0);
        assert!(drift < 1e-8, "{drift:e} at {} s", row[0]);
    }
}

const SLIDER: &str = "\
model slider;
coordinate x: m;
input x: N;
parameter m: kg = 2;
kinetic m/2*dot(x)^2;
force x = input(x);
";

/// A triangle of force on a free mass: velocity and position in closed form. Runge-Kutta is
/// exact here if it stops at the corners, which are not rows of the log.
#[test]
fn inputs_are_followed_to_their_corners() {
    let folder = tempfile::tempdir().unwrap();
    let model = write(&folder, "slider.model", SLIDER);
    let inputs = write(
        &folder,
        "u.csv",
        "t,u_x,remark\n0,0,a\n0.55,5.5,b\n1.1,0,c\n",
    );
    let flags = [
        "--init",
        r#"{"q": [1]}"#,
        "--duration",
        "2",
        "--rate",
        "10",
        "--max-step",
        "1",
        "--inputs",
        &inputs,
    ];
    let (_, rows, stderr) = simulate(&folder, &model, &flags);
    assert!(
        stderr.contains("covers 0 s to 1.1 s, the simulation 0 s to 2 s"),
        "{stderr}"
    );
    let ramp = |t: f64, n: i32| t.max(0.0).powi(n);
    for row in rows {
        let t = row[0];
        let force = 10.0 * (ramp(t, 1) - 2.0 * ramp(t - 0.55, 1) + ramp(t - 1.1, 1));
        let velocity = 2.5 * (ramp(t, 2) - 2.0 * ramp(t - 0.55, 2) + ramp(t - 1.1, 2));
        let position = 1.0 + 2.5 / 3.0 * (ramp(t, 3) - 2.0 * ramp(t - 0.55, 3) + ramp(t - 1.1, 3));
        let expected = [t, position, velocity, force / 2.0, force];
        assert!(
            support::gap(&row, &expected) < 1e-12,
            "{row:?} {expected:?}"
        );
    }
}

#[test]
fn a_constant_input_comes_from_the_initial_state() {
    let folder = tempfile::tempdir().unwrap();
    let model = write(&folder, "slider.model", SLIDER);
    let init = write(
        &folder,
        "init.json",
        "{\n  \"q\": {\"x\": 0},\n  \"u\": [4],\n  \"t\": 3\n}\n",
    );
    let (_, rows, _) = simulate(&folder, &model, &["--init", &init, "--duration", "1"]);
    let last = rows.last().unwrap();
    assert!(
        support::gap(last, &[4.0, 1.0, 2.0, 2.0, 4.0]) < 1e-12,
        "{last:?}"
    );
}

#[test]
fn noise_is_seeded_and_stays_in_its_columns() {
    let folder = tempfile::tempdir().unwrap();
    let base = [
        "--init",
        r#"{"q": [1, 0]}"#,
        "--duration",
        "20",
        "--max-step",
        "0.01",
    ];
    let noisy = |seed| {
        [
            &base[..],
            &["--noise", "q=0.01", "--noise", "dq_j2=0.1", "--seed", seed],
        ]
        .concat()
    };
    let model = "models/pendulum2.model";
    let (_, clean, _) = simulate(&folder, model, &base);
    let (_, first, stderr) = simulate(&folder, model, &noisy("1"));
    let (_, again, _) = simulate(&folder, model, &noisy("1"));
    let (_, other, _) = simulate(&folder, model, &noisy("2"));
    assert!(stderr.contains("noise with seed 1"), "{stderr}");
    assert_eq!(first, again);
    assert_ne!(first, other);
    for (column, sd) in [0.0, 0.01, 0.01, 0.0, 0.1, 0.0, 0.0]
        .into_iter()
        .enumerate()
    {
        let pairs = clean.iter().zip(&first);
        let square: f64 = pairs.map(|(a, b)| (a[column] - b[column]).powi(2)).sum();
        let found = (square / clean.len() as f64).sqrt();
        // Two thousand draws: the spread is known to 1.6 %.
        assert!(
            (found - sd).abs() <= 0.07 * sd,
            "column {column}: {found} for {sd}"
        );
    }
}

#[test]
fn what_fails_on_the_way_leaves_everything_as_it_was() {
    let folder = tempfile::tempdir().unwrap();
    // dv/dt = v², which ends at t = 1.
    let model = write(
        &folder,
        "burst.model",
        "model burst;\ncoordinate x;\nkinetic dot(x)^2/2;\nforce x = dot(x)^2;\n",
    );
    let out = write(&folder, "log.csv", "as it was\n");
    let arguments = [
        "simulate",
        &model,
        "--init",
        r#"{"q": [0], "v": [1]}"#,
        "--duration",
        "2",
        "--out",
        &out,
    ];
    let said = refuse(&arguments, "");
    assert!(said.contains("the motion is not finite"), "{said}");
    assert_eq!(fs::read_to_string(&out).unwrap(), "as it was\n");
    assert_eq!(files(folder.path()), ["burst.model", "log.csv"]);
}

#[test]
fn a_log_can_be_read_by_its_owner_and_replaces_the_old_one() {
    let folder = tempfile::tempdir().unwrap();
    write(&folder, "log.csv", "old\n");
    simulate(
        &folder,
        "models/pendulum.model",
        &["--init", r#"{"q": [1]}"#, "--duration", "0.1"],
    );
    assert_eq!(files(folder.path()), ["log.csv"]);
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        let mode = fs::metadata(folder.path().join("log.csv"))
            .unwrap()
            .permissions()
            .mode();
        assert_eq!(mode & 0o600, 0o600);
        let fresh = folder.path().join("fresh");
        fs::write(&fresh, "").unwrap();
        assert_eq!(mode, fs::metadata(fresh).unwrap().permissions().mode());
    }
}

/// Names that hold what stands between cells: the log is read back as it was written. (What
/// stands between rows is refused in a robot's names.)
#[test]
fn a_log_with_odd_names_can_be_read() {
    let folder = tempfile::tempdir().unwrap();
    let names = ["a,b", "c;d;e;f;g", "\"quoted\""];
    let mut robot = String::from("<robot name=\"odd\"><link name=\"link_0\"/>");
    for (index, name) in names.iter().enumerate() {
        let name = name.replace('"', "&quot;");
        robot.push_str(&format!(
            "<link name=\"link_{next}\"><inertial><mass value=\"1\"/><inertia ixx=\"1\" ixy=\"0\" \
             ixz=\"0\" iyy=\"1\" iyz=\"0\" izz=\"1\"/></inertial></link>\
             <joint name=\"{name}\" type=\"continuous\"><parent link=\"link_{index}\"/>\
             <child link=\"link_{next}\"/><axis xyz=\"0 0 1\"/></joint>",
            next = index + 1
        ));
    }
    let model = write(&folder, "odd.urdf", &(robot + "</robot>"));
    let out = folder.path().join("log.csv");
    let init = r#"{"q": [0, 1, 2]}"#;
    succeed(
        &[
            "simulate",
            &model,
            "--init",
            init,
            "--duration",
            "1",
            "--out",
            out.to_str().unwrap(),
        ],
        "",
    );
    let log = identify::log::Log::read(&out).unwrap();
    let names = names.map(str::to_string);
    let record = log.select(&names, &names).unwrap();
    for (value, column) in (0..).zip(&record.q) {
        assert_eq!(column, &vec![f64::from(value); 101]);
    }
}

#[test]
fn a_name_that_no_log_can_hold_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let text =
        "model m;\ncoordinate \"x \": m;\nparameter m: kg = 1;\nkinetic m/2*dot(\"x \")^2;\n";
    let model = write(&folder, "m.model", text);
    let out = folder.path().join("log.csv");
    let out = out.to_str().unwrap();
    let init = r#"{"q": [0]}"#;
    let said = refuse(
        &[
            "simulate",
            &model,
            "--init",
            init,
            "--duration",
            "1",
            "--out",
            out,
        ],
        "",
    );
    assert!(said.contains("a log cannot have a column `q_x `"), "{said}");
    assert_eq!(files(folder.path()), ["m.model"]);
}

/// What may not be written to is not replaced, and a link is written through, wherever it leads.
#[cfg(unix)]
#[test]
fn access_rights_and_links_are_kept() {
    use std::os::unix::fs::{PermissionsExt, symlink};
    let folder = tempfile::tempdir().unwrap();
    let old = folder.path().join("old.csv");
    fs::write(&old, "old\n").unwrap();
    let flags = ["--init", r#"{"q": [1]}"#, "--duration", "0.1"];
    let run = |out: &str| {
        let out = folder.path().join(out).to_str().unwrap().to_string();
        let arguments = [
            &["simulate", "models/pendulum.model", "--out"][..],
            &[&out[..]],
            &flags[..],
        ];
        support::dynamics(&arguments.concat()).output().unwrap()
    };
    let rights = |mode| fs::set_permissions(&old, fs::Permissions::from_mode(mode)).unwrap();
    rights(0o444);
    let output = run("old.csv");
    assert_eq!(output.status.code(), Some(2));
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(said.contains("old.csv`: it is read-only"), "{said}");
    assert_eq!(fs::read_to_string(&old).unwrap(), "old\n");
    rights(0o600);
    assert!(run("old.csv").status.success());
    assert_eq!(
        fs::metadata(&old).unwrap().permissions().mode() & 0o7777,
        0o600
    );
    symlink("new.csv", folder.path().join("link.csv")).unwrap();
    assert!(run("link.csv").status.success());
    assert!(folder.path().join("link.csv").is_symlink());
    assert_eq!(files(folder.path()), ["link.csv", "new.csv", "old.csv"]);
}

const BALL: &str = "
model ball;
coordinate z: m;
body ball { frame: translate(0, 0, z); mass: 0.4; }
gravity (0, 0, -9.81);
contact floor: sphere(ball, 0.1) on plane_z(world) { restitution: 0.8; }
";

/// The closed form of a ball's bounces, to 1e-12 s, and the impulses both ways.
#[test]
fn impacts_are_listed_at_their_instants() {
    let folder = tempfile::tempdir().unwrap();
    let model = write(&folder, "ball.model", BALL);
    let list = folder.path().join("impacts.csv");
    let flags = [
        "--init",
        r#"{"q": {"z": 1.1}}"#,
        "--duration",
        "4.1",
        "--impulses",
        "--impacts",
        list.to_str().unwrap(),
    ];
    let (heading, rows, _) = simulate(&folder, &model, &flags);
    assert_eq!(
        heading[4..],
        ["impulse_floor_x", "impulse_floor_y", "impulse_floor_z"]
    );
    let text = fs::read_to_string(&list).unwrap();
    let mut lines = text.lines();
    let heading = lines.next().unwrap();
    assert_eq!(heading, "t,contact,approach,impulse_x,impulse_y,impulse_z");
    let impacts: Vec<Vec<&str>> = lines.map(|line| line.split(',').collect()).collect();
    assert!(impacts.len() > 25, "{text}");
    let number = |cell: &str| cell.parse::<f64>().unwrap();
    let mut expected = (2.0_f64 / 9.81).sqrt();
    let mut speed = 9.81 * expected;
    let mut given = 0.0;
    for impact in &impacts {
        assert!(
            (number(impact[0]) - expected).abs() < 1e-12,
            "{impact:?}: {expected}"
        );
        assert_eq!(impact[1], "floor");
        given += if expected < 4.0 {
            number(impact[5])
        } else {
            0.0
        };
        speed *= 0.8;
        expected += 2.0 * speed / 9.81;
    }
    // The log shows as much of them.
    let shown: f64 = rows[..=400].iter().map(|row| row[6]).sum();
    assert!((given - shown).abs() < 1e-9, "{given} N s, {shown} N s");
}

#[test]
fn impacts_need_contacts_and_a_file_of_their_own() {
    let folder = tempfile::tempdir().unwrap();
    let model = write(&folder, "ball.model", BALL);
    let out = folder.path().join("log.csv");
    let out = out.to_str().unwrap();
    let asked = |model: &str| {
        let flags = ["--impacts", out, "--out", out, "--duration", "1"];
        let start = [&["simulate", model, "--init"][..], &[r#"{"q": [1.1]}"#]].concat();
        refuse(&[start, flags.to_vec()].concat(), "")
    };
    insta::assert_snapshot!(asked(&model), @"
    error: `--impacts` and `--out` name the same file
     |
    help: give the impacts a file of their own
    ");
    let free = BALL.split("contact").next().unwrap();
    let free = write(&folder, "free.model", free);
    insta::assert_snapshot!(asked(&free), @"
    error: `--impacts` shows contacts, and the model has none
     |
    help: declare what may touch: `contact`
    ");
}

/// A ball in a slit that is narrower than it is.
#[test]
fn a_contact_without_room_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let roof =
        "contact roof: sphere(ball, 0.1) on plane_z(world * translate(0, 0, 0.19) * rotate_x(pi));";
    let model = write(&folder, "slit.model", &format!("{BALL}{roof}"));
    let out = folder.path().join("log.csv");
    let arguments = [
        "simulate",
        &model,
        "--init",
        r#"{"q": {"z": 0.1}}"#,
        "--duration",
        "1",
        "--out",
        out.to_str().unwrap(),
    ];
    insta::assert_snapshot!(refuse(&arguments, ""), @"
    error: at t = 0 s no motion keeps the contacts out of all planes
     |
    help: make room between planes that touch the same body from two sides
    ");
    assert!(!out.exists());
}
