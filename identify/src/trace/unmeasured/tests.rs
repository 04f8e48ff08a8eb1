//! Against motions in closed form, whose inputs and readings follow by hand.

use super::*;
use crate::log::Log;
use crate::trace::swing::{SWING, motion, read_as, shown, swing};
use crate::trace::wheel::{named, rectangular, traced};
use crate::trace::{Finding, Outcome, Request, Verdict, trace};
use dynamics_codegen::{Library, compile};
use std::collections::BTreeMap;
use std::fmt::Write;

fn with_source<T>(model: &str, then: impl FnOnce(&Source<'_>) -> T) -> T {
    then(&Source {
        name: "swing",
        text: model,
        library: &Library::builtin(),
        parameters: &BTreeMap::new(),
    })
}

fn record(model: &str, log: &str) -> Result<Record, TraceError> {
    let library = Library::builtin();
    let compiled = compile("swing", model, &library).unwrap().model;
    let names = |all: Vec<&String>| all.into_iter().cloned().collect::<Vec<String>>();
    let coordinates = names(compiled.coordinates.iter().map(|c| &c.name).collect());
    let inputs = names(compiled.inputs.iter().map(|u| &u.name).collect());
    let log = Log::from_bytes("swing.csv", log.as_bytes())?;
    let record = log.select_sensed(&coordinates, &inputs, &crate::log::Gauge::of(&compiled))?;
    with_source(model, |source| estimated(source, record, Hold::Linear))
}

fn only(outcome: &Outcome) -> &Finding {
    let [finding] = &outcome.findings[..] else {
        panic!("{:#?}", outcome.findings);
    };
    finding
}

/// Errors of the estimates in units of their standard deviation are about one, although the model
/// lacks a friction of a third of the driving torque.
#[test]
fn the_motion_is_found_beside_a_wrong_model() {
    let record = record(SWING, &swing(0.8, &[])).unwrap();
    let sensed = record.sensed.as_ref().unwrap();
    let rate = record.dq[0].as_ref().unwrap();
    let error = |derivative: usize, values: &[f64]| {
        let each = record.t.iter().zip(values);
        let errors: Vec<f64> = each.map(|(&t, x)| x - motion(t)[derivative]).collect();
        crate::log::rms(&errors)
    };
    let [position, velocity] = sensed.sd[0];
    let errors = [error(0, &record.q[0]) / position, error(1, rate) / velocity];
    assert!(position < 2e-3 && velocity < 3e-3, "{:?}", sensed.sd);
    assert!(errors.iter().all(|e| (0.2..2.5).contains(e)), "{errors:?}");
    let noise: Vec<f64> = sensed.readings.iter().map(|reading| reading.sd).collect();
    for (found, expected) in noise.iter().zip([3e-3, 0.03, 0.03]) {
        assert!((found / expected - 1.0).abs() < 0.1, "{noise:?}");
    }
}

/// An accelerometer that is early by six samples shows another motion, and the right one once that is said.
#[test]
fn a_motion_begins_anew_under_sensors_that_misread() {
    let early = |t: f64| shown(t + 0.06);
    let record = record(SWING, &read_as(0.0, &["gyro_z", "felt_x"], early)).unwrap();
    let observed = Observed::new(record, Hold::Linear).unwrap();
    let dictionary = with_source(SWING, |source| {
        Dictionary::new(source, &observed.ranges()).unwrap()
    });
    let time = named(&dictionary, "time_shift(felt_y)");
    let mut values = dictionary.defaults.clone();
    values[dictionary.candidates[time].parameters[0]] = -0.06;
    let anew = begun_anew(&dictionary.focus(&[time]), &values, &observed).unwrap();
    let error = |observed: &Observed| {
        let each = observed.curve.t.iter().zip(&observed.curve.q[0]);
        let errors: Vec<f64> = each.map(|(&t, x)| x - motion(t)[0]).collect();
        crate::log::rms(&errors)
    };
    let errors = [error(&observed), error(&anew)];
    assert!(errors[1] < 0.3 * errors[0], "{errors:?}");
}

#[test]
fn friction_is_found_without_a_position() {
    for without in [&[][..], &["felt_x", "felt_y"], &["gyro_z"]] {
        let outcome = traced(SWING, &swing(0.05, without));
        let found = only(&outcome);
        assert_eq!(
            (found.effect.as_str(), &found.on[0][..]),
            ("viscous", "phi")
        );
        let estimate = &found.parameters["d"];
        let miss = (estimate.value - 0.05).abs();
        assert!(
            miss < 3.5 * estimate.std && estimate.std < 2e-3,
            "{estimate:?}"
        );
        assert!(
            outcome
                .sensor_noise
                .keys()
                .all(|name| !name.starts_with("q_"))
        );
    }
}

#[test]
fn nothing_is_found_where_nothing_is_missing() {
    let outcome = traced(SWING, &swing(0.0, &[]));
    assert_eq!(outcome.verdict, Verdict::None, "{:#?}", outcome.findings);
}

/// The only finding of a log whose sensors read this: a channel, of this name and place.
fn misread(reading: impl Fn(f64) -> [f64; 3], (effect, on): (&str, &str), truth: (&str, f64)) {
    let outcome = traced(SWING, &read_as(0.0, &[], reading));
    let found = only(&outcome);
    assert_eq!(
        (found.effect.as_str(), &found.on[0][..]),
        (effect, on),
        "{found:#?}"
    );
    assert_eq!(outcome.verdict, Verdict::Channel);
    let (name, value) = truth;
    let estimate = &found.parameters[name];
    let miss = (estimate.value - value).abs();
    let small = 0.05 * (value - if name == "scale" { 1.0 } else { 0.0 }).abs();
    assert!(
        miss < 3.5 * estimate.std && estimate.std < small,
        "{estimate:?}"
    );
}

#[test]
fn a_gyroscope_with_an_offset_is_named() {
    let reading = |t: f64| {
        let [gyro, along, across] = shown(t);
        [gyro + 0.03, along, across]
    };
    misread(reading, ("measurement_offset", "gyro_z"), ("offset", 0.03));
}

#[test]
fn an_accelerometer_with_a_wrong_scale_is_named() {
    let reading = |t: f64| {
        let [gyro, along, across] = shown(t);
        [gyro, along, 1.06 * across]
    };
    misread(reading, ("measurement_scale", "felt_y"), ("scale", 1.06));
}

/// By no whole number of samples.
#[test]
fn a_late_gyroscope_is_named() {
    let reading = |t: f64| {
        let [_, along, across] = shown(t);
        [shown(t - 0.0237)[0], along, across]
    };
    misread(reading, ("time_shift", "gyro_z"), ("tau", 0.0237));
}

/// Axes that are turned against those of the board, in the plane of the motion.
#[test]
fn a_board_that_is_mounted_askew_is_named() {
    let reading = |t: f64| {
        let ([gyro, along, across], (sin, cos)) = (shown(t), 0.08_f64.sin_cos());
        [gyro, cos * along + sin * across, cos * across - sin * along]
    };
    misread(reading, ("mounting_tilt", "board"), ("phi_z", 0.08));
}

/// What the model states of its sensors is taken at its word.
#[test]
fn errors_that_the_model_states_are_believed() {
    let reading = |t: f64| {
        let [_, along, across] = shown(t);
        [shown(t - 0.03)[0] + 0.1, along, across]
    };
    let model = format!(
        "{SWING}effect time_shift(gyro_z) {{ tau = 0.03 }}\nmeasured gyro_z = gyro_z + 0.1;\n"
    );
    let outcome = traced(&model, &read_as(0.0, &[], reading));
    assert_eq!(outcome.verdict, Verdict::None, "{:#?}", outcome.findings);
}

/// A gyroscope that is off by a constant is a parameter of what it shows.
#[test]
fn an_offset_of_a_sensor_is_a_parameter() {
    let stated = "sensor gyro: rad/s = gyroscope(board);";
    let model = SWING.replace(stated, "sensor gyro_z: rad/s = gyroscope(board).z + bias;");
    let model = format!("{model}parameter bias: rad/s = 0;\n");
    let log = swing(0.0, &[]);
    let shifted = log.lines().enumerate().map(|(k, line)| {
        let mut cells: Vec<String> = line.split(',').map(String::from).collect();
        if let (true, Ok(gyro)) = (k > 0, cells[2].parse::<f64>()) {
            cells[2] = (gyro + 0.02).to_string();
        }
        cells.join(",")
    });
    let shifted: Vec<String> = shifted.collect();
    let outcome = traced(&model, &shifted.join("\n"));
    let found = only(&outcome);
    assert_eq!(
        (outcome.verdict, &found.on[0][..]),
        (Verdict::Parameter, "bias")
    );
    let estimate = &found.parameters["bias"];
    let miss = (estimate.value - 0.02).abs();
    assert!(
        miss < 3.5 * estimate.std && estimate.std < 1e-3,
        "{estimate:?}"
    );
}

/// A wheel turns alike wherever it stands: where it began nobody knows, nor has to.
#[test]
fn where_nothing_depends_on_a_position_none_is_needed() {
    let model = "model wheel; coordinate angle: rad; input motor: N*m;\n\
        parameter i: kg*m^2 = 0.02; kinetic i/2*dot(angle)^2; force angle = motor;\n\
        sensor rate: rad/s = dot(angle);";
    let mut text = String::from("t,u_motor,rate\n");
    let mut noise = rectangular(5);
    for k in 0..1500 {
        let t = 0.01 * f64::from(k);
        let [_, v, a] = motion(t);
        writeln!(text, "{t},{},{}", 0.02 * a + 0.003 * v, v + 1e-3 * noise()).unwrap();
    }
    let outcome = traced(model, &text);
    assert_eq!(only(&outcome).effect, "viscous");
    let said = |w: &String| w.contains("nothing that is measured depends on it");
    assert!(outcome.warnings.iter().any(said), "{:?}", outcome.warnings);
}

/// A cart on one driven wheel that steers about it: place and heading change nothing that encoder and
/// gyroscope show, though heading decides where it goes.
const CART: &str = "model cart; coordinate x: m; coordinate y: m; coordinate yaw: rad; coordinate wheel: rad;\n\
    input drive: N*m; input turn: N*m;\n\
    parameter m: kg = 2; parameter r: m = 0.1; parameter i: kg*m^2 = 0.01; parameter j: kg*m^2 = 0.05;\n\
    kinetic m/2*(dot(x)^2 + dot(y)^2) + i/2*dot(wheel)^2 + j/2*dot(yaw)^2;\n\
    force wheel = drive; force yaw = turn;\n\
    constraint along: dot(x) == r*dot(wheel)*cos(yaw);\n\
    constraint across: dot(y) == r*dot(wheel)*sin(yaw);\n\
    sensor encoder: rad = wheel; sensor gyro: rad/s = dot(yaw);";

/// Its log, with friction of 0.02 N·m·s in the wheel; it steers half as quickly as its wheel turns.
fn driven() -> String {
    let mut text = String::from("t,u_drive,u_turn,encoder,gyro\n");
    let mut noise = rectangular(5);
    for k in 0..1000 {
        let t = 0.01 * f64::from(k);
        let [q, v, a] = motion(t);
        let (drive, turn) = (0.03 * a + 0.02 * v, 0.05 * 0.5 * a);
        let (encoder, gyro) = (q + 1e-4 * noise(), 0.5 * v + 1e-3 * noise());
        writeln!(text, "{t},{drive},{turn},{encoder},{gyro}").unwrap();
    }
    text
}

#[test]
fn a_cart_is_traced_that_nobody_locates() {
    let outcome = traced(CART, &driven());
    let found = only(&outcome);
    assert_eq!(
        (found.effect.as_str(), &found.on[0][..]),
        ("viscous", "wheel")
    );
    let estimate = &found.parameters["d"];
    assert!(
        (estimate.value - 0.02).abs() < 3.5 * estimate.std,
        "{estimate:?}"
    );
    for coordinate in ["x", "y", "yaw"] {
        let said = format!("where coordinate `{coordinate}` is");
        assert!(
            outcome.warnings.iter().any(|w| w.contains(&said)),
            "{coordinate}"
        );
    }
    assert!(
        !outcome
            .warnings
            .iter()
            .any(|w| w.contains("where coordinate `wheel`"))
    );
}

/// On a slope heading is felt, and place still is not.
#[test]
fn what_reaches_a_sensor_does_not_begin_anywhere() {
    let text = |potential: &str| format!("{CART}\nparameter k: N = 1; {potential}");
    let cyclic = |model: &str| {
        let library = Library::builtin();
        let compiled = compile("cart", model, &library).unwrap();
        let coordinates = ["x", "y", "yaw", "wheel"].map(String::from);
        let inputs = ["drive", "turn"].map(String::from);
        let log = Log::from_bytes("cart.csv", driven().as_bytes()).unwrap();
        let gauge = crate::log::Gauge::of(&compiled.model);
        let record = log.select_sensed(&coordinates, &inputs, &gauge).unwrap();
        let mut machine = crate::machine::Machine::new(compiled);
        let values = machine.nominal_parameters();
        cyclic::cyclic(&mut machine, &values, &record)
    };
    assert_eq!(cyclic(&text("")), [true, true, true, false]);
    assert_eq!(cyclic(&text("potential k*x;")), [true, true, false, false]);
    assert_eq!(
        cyclic(&text("parameter c: 1/m = 1; potential k*c*x^2/2;")),
        [false, true, false, false]
    );
}

/// Two pendulums that know nothing of each other, one of them without a sensor.
#[test]
fn what_no_sensor_shows_is_refused() {
    let model = format!(
        "{SWING}coordinate other: rad;\nparameter j: kg*m^2 = 0.2;\nparameter k: N*m = 2;\n\
         kinetic j/2*dot(other)^2;\nforce other = k*cos(other);\n"
    );
    let refused = record(&model, &swing(0.0, &[])).unwrap_err();
    insta::assert_snapshot!(refused);
}

#[test]
fn neither_position_nor_sensor_is_refused() {
    let library = Library::builtin();
    let text = swing(0.0, &["gyro_z", "felt_x", "felt_y"]);
    let log = Log::from_bytes("swing.csv", text.as_bytes()).unwrap();
    let refused = trace(&Request::new("swing", SWING, &library, &log)).unwrap_err();
    insta::assert_snapshot!(refused);
}

/// A bob on a rod, of which a log shows how far it is to the side, and the rod's force: height and depth
/// fit as well, and the search begins between them.
#[test]
fn where_no_motion_is_found_it_is_said_of_what() {
    let model = "\
model bob;
coordinate x: m;
coordinate y: m;
parameter m: kg = 0.5;
constant l: m = 0.8;
body bob { frame: translate(x, y, 0); mass: m; }
gravity (0, -9.81, 0);
constraint rod: x^2 + y^2 == l^2;
sensor cell: N = -2*l*multiplier(rod);
";
    let mut text = String::from("t,q_x,cell\n");
    let mut noise = rectangular(3);
    for k in 0..400 {
        let t = 0.01 * f64::from(k);
        let (angle, rate) = (0.9 + 0.3 * (2.0 * t).sin(), 0.6 * (2.0 * t).cos());
        let force = 0.5 * (0.8 * rate * rate + 9.81 * angle.cos());
        let x = 0.8 * angle.sin() + 1e-3 * noise();
        writeln!(text, "{t},{x},{}", force + 0.01 * noise()).unwrap();
    }
    let error = record(model, &text).unwrap_err().to_string();
    insta::assert_snapshot!(error, @"no column shows `y`, and no motion was found on which the model agrees with the sensors that the log has (`cell`): the best one fails at t = 0 s. Log the positions as well, or sensors that show where each is, such as an encoder or the position of a point; a search begins near zero");
}
