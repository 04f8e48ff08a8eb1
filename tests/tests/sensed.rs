//! Logs without coordinates: gyroscopes, accelerometers, encoders and load cells, simulated by others.

use dynamics_codegen::Library;
use identify::log::Log;
use identify::trace::{Outcome, Request, Verdict, trace};
use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;
use std::collections::BTreeMap;
use std::fmt::Write;

const ROOT: &str = env!("CARGO_MANIFEST_DIR");

/// The only finding, of this name, with this parameter within three standard errors and 2 %.
fn expect(outcome: &Outcome, effect: &str, on: &str, (name, value): (&str, f64)) {
    let [finding] = &outcome.findings[..] else {
        panic!("{:#?}", outcome.findings);
    };
    assert_eq!(
        (finding.effect.as_str(), &finding.on[..]),
        (effect, &[on.to_string()][..])
    );
    let estimate = &finding.parameters[name];
    let miss = (estimate.value - value).abs();
    assert!(
        miss < 3.0 * estimate.std && miss < 0.02 * value,
        "{estimate:?}"
    );
    let total = |score: &identify::trace::Score| score.acceleration.total;
    assert!(total(&outcome.after) < 1.5 * total(&outcome.noise_floor));
    assert!(total(&outcome.after) < 0.5 * total(&outcome.before));
}

#[test]
fn a_cart_pole_by_an_inertial_sensor_and_a_slow_encoder() {
    let folder = format!("{ROOT}/data/scenarios/sensed_cartpole");
    let model = std::fs::read_to_string(format!("{ROOT}/../models/cartpole.model")).unwrap();
    let text = format!(
        "{model}\nframe imu = pole * translate(0.3072, 0, 0);\n\
         sensor imu_gyro: rad/s = gyroscope(imu);\nsensor imu_felt: m/s^2 = accelerometer(imu);\n\
         constant wheel_radius: m = 0.03;\nsensor wheel: rad = x/wheel_radius {{ rate: 40; }}\n"
    );
    let parameters = std::fs::read_to_string(format!("{folder}/parameters.json")).unwrap();
    let parameters: BTreeMap<String, f64> = serde_json::from_str(&parameters).unwrap();
    let [train, test] =
        ["train", "test"].map(|log| Log::read(format!("{folder}/{log}.csv.gz")).unwrap());
    let library = Library::builtin();
    let outcome = trace(&Request {
        parameters,
        test: Some(&test),
        ..Request::new("cartpole", &text, &library, &train)
    });
    expect(&outcome.unwrap(), "viscous", "theta", ("d", 0.004473));
}

/// Of a crank's and a rocker's inertial sensor one gyroscope is late. Positions that are estimated from all of
/// them do not close the linkage; the search finds why.
#[test]
fn a_late_gyroscope_keeps_a_four_bar_open() {
    let folder = format!("{ROOT}/data/scenarios/sensed_fourbar");
    let model = std::fs::read_to_string(format!("{ROOT}/../models/fourbar.model")).unwrap();
    let boards = [("imu1", "link1", 0.0918), ("imu3", "link3", 0.2088)];
    let boards = boards.map(|(imu, link, at)| {
        format!(
            "frame {imu} = {link} * translate({at}, 0, 0);\n\
             sensor {imu}_gyro: rad/s = gyroscope({imu});\n\
             sensor {imu}_felt: m/s^2 = accelerometer({imu});\n"
        )
    });
    let parameters = std::fs::read_to_string(format!("{folder}/parameters.json")).unwrap();
    let train = Log::read(format!("{folder}/train.csv.gz")).unwrap();
    let (text, library) = (format!("{model}\n{}", boards.concat()), Library::builtin());
    let outcome = trace(&Request {
        parameters: serde_json::from_str(&parameters).unwrap(),
        ..Request::new("fourbar", &text, &library, &train)
    });
    let outcome = outcome.unwrap();
    assert_eq!(outcome.verdict, Verdict::Channel);
    let [finding] = &outcome.findings[..] else {
        panic!("{:#?}", outcome.findings);
    };
    assert_eq!(
        (finding.effect.as_str(), &finding.on[0][..]),
        ("time_shift", "imu1_gyro_z")
    );
    let tau = &finding.parameters["tau"];
    assert!((tau.value - 0.012).abs() < 1e-4, "{tau:?}");
}

/// A quadrotor in a plane, with drag of its rotors.
const QUADROTOR: &str = "\
model quadrotor;
coordinate x: m;
coordinate z: m;
coordinate theta: rad;
input left: N;
input right: N;
parameter m: kg = 0.6;
parameter arm: m = 0.18;
parameter j: kg*m^2 = 0.008;
body hull { frame: translate(x, z, 0) * rotate_z(theta); mass: m; inertia: diag(0, 0, j); }
gravity (0, -9.81, 0);
force x = -(left + right)*sin(theta);
force z = (left + right)*cos(theta);
force theta = arm*(right - left);
effect viscous(x) { d = 0.35 }
effect viscous(z) { d = 0.35 }
sensor gyro: rad/s = gyroscope(hull);
sensor felt: m/s^2 = accelerometer(hull) { rate: 50; }
";

/// `(ẋ, ż, θ̇, ẍ, z̈, θ̈)` of the quadrotor whose left rotor gives `gain` of what is commanded.
fn rates(s: &[f64; 6], [left, right]: [f64; 2], gain: f64) -> [f64; 6] {
    let (m, arm, j, drag, g) = (0.6, 0.18, 0.008, 0.35, 9.81);
    let [_, _, theta, vx, vz, w] = *s;
    let thrust = gain * left + right;
    [
        vx,
        vz,
        w,
        (-thrust * theta.sin() - drag * vx) / m,
        (thrust * theta.cos() - drag * vz) / m - g,
        arm * (right - gain * left) / j,
    ]
}

/// One classical Runge–Kutta step.
fn stepped(s: [f64; 6], h: f64, rate: impl Fn(&[f64; 6]) -> [f64; 6]) -> [f64; 6] {
    let moved = |by: &[f64; 6], h: f64| std::array::from_fn(|i| s[i] + h * by[i]);
    let a = rate(&s);
    let b = rate(&moved(&a, h / 2.0));
    let c = rate(&moved(&b, h / 2.0));
    let d = rate(&moved(&c, h));
    std::array::from_fn(|i| s[i] + h / 6.0 * (a[i] + 2.0 * b[i] + 2.0 * c[i] + d[i]))
}

/// Twenty seconds of a flight along waves, as its inertial sensor shows it: the gyroscope at 100 Hz,
/// the accelerometer at 50 Hz.
fn flight(gain: f64) -> String {
    let (m, arm, j, g) = (0.6, 0.18, 0.008, 9.81);
    let mut random = ChaCha8Rng::seed_from_u64(4);
    let mut text = String::from("t,u_left,u_right,gyro_z,felt_x,felt_y\n");
    let (mut s, mut felt) = ([0.0; 6], [0.0; 2]);
    for k in 0..2000 {
        let t = 0.01 * f64::from(k);
        let [x, z, theta, vx, vz, w] = s;
        let (to_x, to_z) = (
            1.5 * (0.9 * t).sin() + 0.5 * (2.1 * t).sin(),
            0.8 * (0.7 * t).sin(),
        );
        let tilt = ((1.5 * vx - 2.0 * (to_x - x)) / g).clamp(-0.6, 0.6);
        let thrust =
            (m * (g + 3.0 * (to_z - z) - 2.5 * vz) / theta.cos().max(0.5)).clamp(1.0, 14.0);
        let torque = j * (60.0 * (tilt - theta) - 12.0 * w) + 0.002 * (11.0 * t).sin();
        let u = [-1.0, 1.0].map(|side| thrust / 2.0 + side * torque / (2.0 * arm));
        let a = rates(&s, u, gain);
        let mut noisy = |value: f64, sd: f64| value + sd * random.sample::<f64, _>(StandardNormal);
        let (sin, cos) = theta.sin_cos();
        let gyro = noisy(w, 3e-3);
        if k % 2 == 0 {
            felt = [
                noisy(cos * a[3] + sin * (a[4] + g), 0.03),
                noisy(-sin * a[3] + cos * (a[4] + g), 0.03),
            ];
        }
        writeln!(text, "{t},{},{},{gyro},{},{}", u[0], u[1], felt[0], felt[1]).unwrap();
        for _ in 0..10 {
            s = stepped(s, 1e-3, |s| rates(s, u, gain));
        }
    }
    text
}

fn flown(gain: f64) -> Outcome {
    let log = Log::from_bytes("flight.csv", flight(gain).as_bytes()).unwrap();
    let library = Library::builtin();
    trace(&Request::new("quadrotor", QUADROTOR, &library, &log)).unwrap()
}

/// Where it flies is in no column, nor is which way it points.
#[test]
fn a_weak_rotor_of_a_quadrotor_by_its_inertial_sensor_alone() {
    if left_out::too_slow() {
        return;
    }
    let outcome = flown(0.92);
    assert_eq!(outcome.verdict, Verdict::Channel);
    expect(&outcome, "input_gain", "left", ("gain", 0.92));
}

#[test]
fn a_sound_quadrotor_lacks_nothing() {
    let outcome = flown(1.0);
    assert_eq!(outcome.verdict, Verdict::None, "{:#?}", outcome.findings);
}
