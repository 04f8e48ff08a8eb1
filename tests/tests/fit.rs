//! `fit` on a real arm, and on a machine whose forces are known.

use dynamics_codegen::robot::Format;
use dynamics_codegen::{Library, compile, compile_bytes, model_of_description};
use identify::fit::{Doubt, Fit, FitError, Inertia, Reason, Request, Source, Term, fit, written};
use identify::log::{Log, Map};
use identify::machine::{Machine, States};
use integration_tests::random;
use rand::RngExt as _;
use std::fmt::Write;
use std::path::Path;

fn library(path: &Path) -> Library {
    let mut library = Library::builtin();
    library.look_in(path.parent().expect("a folder"));
    library
}

/// Stäubli TX40, motor torques: friction in every joint, rotors, and the two joints of
/// the wrist that one motor drives together. Judged by the last third of the log.
#[test]
fn a_measured_arm_gives_away_friction_rotors_and_coupling() {
    let Some(urdf) = left_out::shared("data/measured/tx40/tx40.urdf") else {
        return;
    };
    let (text, library) = (
        model_of_description(Format::Urdf, "tx40.urdf"),
        library(&urdf),
    );
    let compiled = compile("tx40.model", &text, &library).expect("a robot");
    let log = Log::read(urdf.with_file_name("log.csv.gz")).expect("a log");
    let source = Source {
        name: "tx40.model",
        text: &text,
        library: &library,
    };
    let request = Request::new(source, &compiled, &[], &log);
    let found = fit(&request).expect("it can be fitted");
    let has = |term: &str, on: &[&str]| found.terms.iter().any(|t| t.term == term && t.on == on);
    for joint in 1..=5 {
        let joint = format!("joint_{joint}");
        assert!(has("friction", &[&joint]), "friction in {joint}: {found:?}");
    }
    // What turns joint 6 turns with joint 5, too: all its friction is there.
    assert!(has("joint_coupling", &["joint_5", "joint_6"]));
    let couplings = found.terms.iter().filter(|t| t.term == "joint_coupling");
    assert_eq!(couplings.count(), 1, "{found:?}");
    let rotors = found.terms.iter().filter(|t| t.term == "armature").count();
    assert!(rotors >= 4, "{rotors} rotors");
    for term in &found.terms {
        for (name, value) in &term.coefficients {
            assert!(value.std.is_finite() && value.std > 0.0);
            let dissipates = term.term == "friction" || term.term == "armature";
            assert!(!dissipates || value.value > 0.0, "{term:?}: {name}");
        }
    }
    println!("{:.2} -> {:.2} N·m", found.before.total, found.after.total);
    assert!(found.before.total > 10.0);
    assert!(found.after.total < 2.09, "{}", found.after.total);
    // What an earlier rule left of each joint.
    for (joint, most) in (1..).zip([3.32, 3.05, 1.45, 0.70, 1.74, 0.71]) {
        let error = found.after.by_coordinate[&format!("joint_{joint}")];
        assert!(error < most, "joint_{joint}: {error}");
    }
}

const ARM: &str = "
    model arm; coordinate a: rad; coordinate b: rad; input a: N*m; input b: N*m;
    body upper { frame: rotate_z(a); mass: 2; center: (0.2, 0, 0); inertia: diag(0.02, 0.02, 0.02); }
    body lower { frame: upper * translate(0.4, 0, 0) * rotate_z(b); mass: 1;
                 center: (0.15, 0, 0); inertia: diag(0.01, 0.01, 0.01); }
    gravity (0, -9.81, 0);
    force a = input(a); force b = input(b);
";

/// A motion on which everything shows, with torques that follow from it: those of the
/// model, `d v + f tanh(v/0.05)` in joint a, and a rotor at joint b.
fn log(seed: u64, rotor: f64, viscous: f64, coulomb: f64, heavier: f64) -> Log {
    log_with(seed, heavier, |_, [v_a, _], [_, a_b]| {
        [viscous * v_a + coulomb * (v_a / 0.05).tanh(), rotor * a_b]
    })
}

/// The same with further torques that the motion takes, by time, velocities and accelerations.
fn log_with(seed: u64, heavier: f64, more: impl Fn(f64, [f64; 2], [f64; 2]) -> [f64; 2]) -> Log {
    log_as(seed, heavier, more, |u| u)
}

/// The same with efforts that a driver logs in place of the torques.
fn log_as(
    seed: u64,
    heavier: f64,
    more: impl Fn(f64, [f64; 2], [f64; 2]) -> [f64; 2],
    mut logged: impl FnMut([f64; 2]) -> [f64; 2],
) -> Log {
    let text = ARM.replace("mass: 1;", &format!("mass: {};", 1.0 + heavier));
    let compiled = compile_bytes("arm.model", text.as_bytes(), &Library::empty()).expect("a model");
    let machine = Machine::new(compiled);
    let mut csv = String::from("t,q_a,q_b,u_a,u_b\n");
    let mut rng = random::generator(seed);
    for k in 0..4000 {
        let t = 0.005 * f64::from(k);
        let wave = |w: &[(f64, f64)]| -> [f64; 3] {
            let sum = |f: fn(f64, f64, f64) -> f64| w.iter().map(|&(s, o)| f(s, o, t)).sum::<f64>();
            [
                sum(|s, o, t| s * (o * t).sin()),
                sum(|s, o, t| s * o * (o * t).cos()),
                sum(|s, o, t| -s * o * o * (o * t).sin()),
            ]
        };
        let a = wave(&[(0.8, 1.3), (0.3, 3.1), (0.1, 5.7)]);
        let b = wave(&[(0.7, 1.7), (0.4, 2.6), (0.1, 6.3)]);
        let states = States {
            t: vec![t],
            q: vec![vec![a[0]], vec![b[0]]],
            v: vec![vec![a[1]], vec![b[1]]],
            u: vec![vec![0.0], vec![0.0]],
            ..States::default()
        };
        let terms = &machine.terms(&states, &[])[0];
        let m = &terms.mass_matrix;
        let needed = |i: usize| m[(i, 0)] * a[2] + m[(i, 1)] * b[2] - terms.force[i];
        let [more_a, more_b] = more(t, [a[1], b[1]], [a[2], b[2]]);
        let [u_a, u_b] = logged([needed(0) + more_a, needed(1) + more_b]);
        let n = 0.02 * rng.random_range(-0.5..0.5);
        let noise = 0.02 * rng.random_range(-0.5..0.5);
        writeln!(
            csv,
            "{t},{},{},{},{}",
            a[0] + 1e-5 * n,
            b[0] + 1e-5 * noise,
            u_a + n,
            u_b + noise
        )
        .unwrap();
    }
    Log::from_bytes("arm.csv", csv.as_bytes()).expect("a log")
}

fn fit_arm(log: &Log, inertia: Inertia) -> Fit {
    try_arm(log, inertia, &[], false).expect("it can be fitted")
}

fn try_arm(
    log: &Log,
    inertia: Inertia,
    leave_out: &[String],
    trust_columns: bool,
) -> Result<Fit, FitError> {
    let library = Library::builtin();
    let compiled = compile("arm.model", ARM, &library).expect("a model");
    let source = Source {
        name: "arm.model",
        text: ARM,
        library: &library,
    };
    fit(&Request {
        inertia,
        leave_out,
        trust_columns,
        ..Request::new(source, &compiled, &[], log)
    })
}

/// Efforts that are no torques are left out by themselves, and pull no other joint away.
#[test]
fn efforts_that_are_no_torques_are_left_out() {
    let friction =
        |_: f64, [v_a, _]: [f64; 2], _: [f64; 2]| [0.4 * v_a + 0.6 * (v_a / 0.05).tanh(), 0.0];
    let true_one = fit_arm(&log_as(6, 0.0, friction, |u| u), Inertia::Consistent);
    assert!(true_one.left_out.is_empty(), "{true_one:?}");

    // What wanders by itself, as a temperature does.
    let (mut rng, mut wanders) = (random::generator(7), 0.0);
    let wandering = log_as(6, 0.0, friction, |[u_a, _]| {
        wanders = 0.99 * wanders + rng.random_range(-0.5..0.5);
        [u_a, wanders]
    });
    let found = fit_arm(&wandering, Inertia::Consistent);
    let [told] = &found.left_out[..] else {
        panic!("{found:?}");
    };
    assert!(
        matches!(told.reason, Reason::Unrelated { .. }) && told.coordinate == "b",
        "{told:?}"
    );
    assert!(found.after.by_coordinate["b"].is_nan());
    let after = |fit: &Fit| fit.after.by_coordinate["a"];
    assert!(after(&found) < 1.1 * after(&true_one), "{found:?}");
    let trusting = try_arm(&wandering, Inertia::Consistent, &[], true).unwrap();
    assert!(trusting.left_out.is_empty(), "{trusting:?}");

    // A current.
    let current = log_as(6, 0.0, friction, |[u_a, u_b]| [0.05 * u_a, u_b]);
    let found = fit_arm(&current, Inertia::Consistent);
    let [told] = &found.left_out[..] else {
        panic!("{found:?}");
    };
    let Reason::Scaled { factor } = told.reason else {
        panic!("{told:?}");
    };
    assert!(
        told.coordinate == "a" && (factor - 0.05).abs() < 0.005,
        "{told:?}"
    );

    let asked = try_arm(&current, Inertia::Consistent, &["b".to_string()], false);
    let said = asked.unwrap_err().to_string();
    assert!(said.contains("no effort of the log is a force"), "{said}");
    let mistyped = try_arm(&current, Inertia::Consistent, &["c".to_string()], false);
    let said = mistyped.unwrap_err().to_string();
    assert_eq!(said, "`c` is no coordinate of the model; there are a, b");
}

#[test]
fn what_was_put_in_comes_out() {
    let found = fit_arm(&log(1, 0.05, 0.4, 0.6, 0.0), Inertia::Fixed);
    let value = |term: &str, on: &str, name: &str| {
        let found = found.terms.iter().find(|t| t.term == term && t.on == [on]);
        found.unwrap_or_else(|| panic!("{term}({on})")).coefficients[name].value
    };
    assert!((value("friction", "a", "viscous") - 0.4).abs() < 0.02);
    assert!((value("friction", "a", "coulomb") - 0.6).abs() < 0.03);
    assert!((value("armature", "b", "i") - 0.05).abs() < 0.001);
    assert!(found.after.total < 0.05 * found.before.total, "{found:?}");
}

/// The torques of a measured double pendulum near its resonance, in which the noise of accelerations is larger than
/// friction: what an independent look at other runs of the day found is 0.14 and 0.16 N·m of it.
#[test]
fn friction_of_a_double_pendulum_near_resonance() {
    let Some(model) = left_out::shared("data/measured/dfki_double/dp.model") else {
        return;
    };
    let text = std::fs::read_to_string(&model).expect("a model");
    let library = Library::builtin();
    let compiled = compile("dp.model", &text, &library).expect("a model");
    let parameters: Vec<f64> = compiled
        .model
        .parameters
        .iter()
        .map(|p| p.default)
        .collect();
    for name in ["run_143339", "run_144003"] {
        let map = Map::read(&model.with_file_name(format!("{name}.toml"))).expect("a map");
        let log = model.with_file_name(format!("{name}.csv.gz"));
        let log = Log::read_with(log, Some(&map)).expect("a log");
        let found = fit(&Request {
            inertia: Inertia::Consistent,
            ..Request::new(
                Source {
                    name: "dp.model",
                    text: &text,
                    library: &library,
                },
                &compiled,
                &parameters,
                &log,
            )
        });
        let found = found.expect("it can be fitted");
        for joint in ["shoulder", "elbow"] {
            let dry = |t: &&Term| t.term == "friction" && t.on == [joint];
            let dry = found.terms.iter().find(dry).expect(joint);
            let dry = &dry.coefficients["coulomb"];
            assert!((0.1..0.25).contains(&dry.value), "{name}, {joint}: {dry:?}");
        }
        let [before, after] = [&found.before, &found.after].map(|error| error.total);
        assert!(after < 0.15 * before, "{name}: {before} -> {after} N·m");
    }
}

/// An encoder before an elastic gear shakes as no torque could shake the wheel behind it: forces are compared
/// in the band in which the model moves.
#[test]
fn a_shaking_encoder_hides_no_friction() {
    const WHEEL: &str = "model wheel; coordinate a: rad; input a: N*m;
        parameter i: kg*m^2 = 0.02; kinetic i/2*dot(a)^2; force a = input(a);";
    let library = Library::builtin();
    let compiled = compile("wheel.model", WHEEL, &library).expect("a model");
    let after = |shake: f64| {
        let mut csv = String::from("t,q_a,u_a\n");
        let mut rng = random::generator(5);
        for k in 0..6000 {
            let t = 0.005 * f64::from(k);
            let [q, v, a] = [(0.8, 1.3), (0.5, 3.1)]
                .iter()
                .fold([0.0; 3], |sum, &(s, w)| {
                    let (sin, cos) = f64::sin_cos(w * t);
                    [
                        sum[0] + s * sin,
                        sum[1] + s * w * cos,
                        sum[2] - s * w * w * sin,
                    ]
                });
            let u =
                0.02 * a + 0.1 * v + 0.2 * (v / 0.05).tanh() + 0.01 * rng.random_range(-0.5..0.5);
            let shaken = q + shake * (28.0 * std::f64::consts::TAU * t).sin();
            writeln!(
                csv,
                "{t},{},{u}",
                shaken + 1e-5 * rng.random_range(-0.5..0.5)
            )
            .unwrap();
        }
        let log = Log::from_bytes("wheel.csv", csv.as_bytes()).expect("a log");
        let source = Source {
            name: "wheel.model",
            text: WHEEL,
            library: &library,
        };
        let found = fit(&Request {
            inertia: Inertia::Consistent,
            ..Request::new(source, &compiled, &[0.02], &log)
        });
        found.expect("it can be fitted")
    };
    let narrower = |found: &Fit| {
        found
            .warnings
            .iter()
            .any(|w| w.contains("forces are compared below"))
    };
    // 186 rad/s^2, or 3.7 N·m for the wheel.
    assert!(narrower(&after(6e-3)));
    for (shake, known) in [(0.0, [1e-3, 1e-3]), (6e-3, [0.06, 0.04])] {
        let found = after(shake);
        let friction = found.terms.iter().find(|t| t.term == "friction");
        let friction = &friction.unwrap_or_else(|| panic!("{found:?}")).coefficients;
        for ((name, truth), known) in [("coulomb", 0.2), ("viscous", 0.1)].into_iter().zip(known) {
            let of = &friction[name];
            let miss = (of.value - truth).abs();
            assert!(miss < known && of.std < known, "{shake}, {name}: {of:?}");
        }
    }
}

/// An effect that somebody else wrote is tried, printed and written like those of the library; one
/// that is not linear in its strength is refused.
#[test]
fn an_effect_of_ones_own_takes_part() {
    let oil = |unit: &str, force: &str| {
        let mut library = Library::builtin();
        let text = format!(
            "/// Oil.\neffect oil(joint); term oil;\n\
             parameter c{unit} = 0 in 0..; force joint = {force};"
        );
        library.add("oil", "oil.model", text);
        library
    };
    let log = log_with(8, 0.0, |_, [v_a, _], _| [0.3 * v_a * v_a.abs(), 0.0]);
    let fitted = |library: &Library| {
        let compiled = compile("arm.model", ARM, library).expect("a model");
        let request = Request {
            inertia: Inertia::Fixed,
            ..Request::new(
                Source {
                    name: "arm.model",
                    text: ARM,
                    library,
                },
                &compiled,
                &[],
                &log,
            )
        };
        fit(&request).map(|found| {
            let text = written(&found, &request).expect("it can be written");
            (found, text)
        })
    };
    let found = fitted(&oil(
        ": torque(joint)/rate(joint)^2",
        "-c*dot(joint)*abs(dot(joint))",
    ));
    let (found, text) = found.expect("it can be fitted");
    let own = found.terms.iter().find(|t| t.term == "oil");
    let own = own.unwrap_or_else(|| panic!("{found:?}"));
    assert_eq!(own.on, ["a"]);
    let c = own.coefficients["c"];
    assert!((c.value - 0.3).abs() < 4.0 * c.std + 1e-3, "{c:?}");
    assert!(text.contains("effect oil(a) { c = 0."), "{text}");
    let refused = fitted(&oil("", "-c^2*dot(joint)")).unwrap_err().to_string();
    let expected = "`oil` cannot be fitted: no parameter of it changes a force from where it does \
                    nothing; without `term …;` in its file `dynamics fit` leaves it alone";
    assert_eq!(refused, expected);
    let refused = fitted(&oil("", "-(c + c^2)*dot(joint)"))
        .unwrap_err()
        .to_string();
    assert!(refused.contains("not linear in its strengths"), "{refused}");
}

/// A body that is lighter than stated carries no load: inertias are corrected where that predicts.
#[test]
fn wrong_inertias_are_corrected() {
    for inertia in [Inertia::Linear, Inertia::Consistent] {
        let found = fit_arm(&log(2, 0.0, 0.0, 0.0, -0.25), inertia);
        assert_eq!(found.inertia, inertia, "{found:?}");
        assert!(found.after.total < 0.1 * found.before.total, "{found:?}");
        assert!(
            found.terms.is_empty(),
            "no friction in its place: {found:?}"
        );
        assert!(found.base_parameters < found.inertial.len());
        if inertia == Inertia::Consistent {
            for body in found.inertial.chunks(10) {
                let [x, y, z] = [4, 5, 6].map(|k| body[k].estimate.value);
                assert!(body[0].estimate.value > 0.0 && x + y > z && y + z > x && z + x > y);
            }
        }
    }
}

/// Where nothing is missing, nothing is found.
#[test]
fn a_right_model_is_left_alone() {
    let found = fit_arm(&log(3, 0.0, 0.0, 0.0, 0.0), Inertia::Linear);
    assert!(found.terms.is_empty(), "{found:?}");
    assert!(found.inertial.is_empty(), "{found:?}");
}

/// A coupling that drives and a rotor of negative inertia do not exist: what looks like them is
/// not called so, however well it fits, and whatever is done about inertias.
#[test]
fn no_coefficient_is_below_what_can_be() {
    let driving = log_with(4, 0.0, |_, [v_a, v_b], [a_a, a_b]| {
        let viscous = -0.3;
        [viscous * v_b - 0.02 * a_a, viscous * v_a - 0.02 * a_b]
    });
    // In one joint the speed brakes and the sign drives, as friction that falls with speed does.
    let falling = log_with(5, 0.0, |_, [v_a, _], _| {
        [0.5 * v_a - 0.04 * (v_a / 0.05).tanh(), 0.0]
    });
    for log in [driving, falling] {
        for inertia in [Inertia::Fixed, Inertia::Linear, Inertia::Consistent] {
            let found = fit_arm(&log, inertia);
            let terms = found.terms.iter().filter(|t| t.term != "constant_force");
            for (name, value) in terms.flat_map(|t| &t.coefficients) {
                assert!(value.value >= 0.0, "{name} with {inertia:?}: {found:?}");
                let held = value.value == 0.0;
                assert_eq!(
                    held,
                    value.std.is_nan(),
                    "{name} with {inertia:?}: {found:?}"
                );
            }
        }
    }
}

/// A drive that rubs in the part to learn from, and not in the part to judge by.
#[test]
fn a_fit_that_makes_it_worse_says_so() {
    let log = log_with(6, 0.0, |t, [v_a, _], _| {
        [if t < 13.0 { 0.4 * v_a } else { 0.0 }, 0.0]
    });
    let found = fit_arm(&log, Inertia::Fixed);
    assert!(
        found.worse && found.after.total > found.before.total,
        "{found:?}"
    );
    let mut warnings = found.warnings.iter();
    let said = warnings.find(|w| w.contains("makes the model worse"));
    let said = said.expect("a warning");
    assert!(
        said.contains("the error rises from") && said.contains(" %)"),
        "{said}"
    );
    let page = identify::fit::page(&found);
    assert!(!page.contains("the model lacks"), "{page}");
    let good = fit_arm(&self::log(1, 0.05, 0.4, 0.6, 0.0), Inertia::Fixed);
    assert!(!good.worse && good.warnings.is_empty(), "{good:?}");
}

/// A mass that is a tenth of what the model states may be right; that it is known to 100 % is
/// not to be said.
#[test]
fn an_inertia_far_from_what_is_stated_is_doubted() {
    for inertia in [Inertia::Linear, Inertia::Consistent] {
        let found = fit_arm(&log(2, 0.0, 0.0, 0.0, -0.9), inertia);
        let far = found
            .inertial
            .iter()
            .filter(|p| p.doubt == Some(Doubt::FarFromStated));
        assert!(far.clone().count() > 0, "{found:?}");
        assert!(
            found
                .inertial
                .iter()
                .all(|p| p.doubt.is_none() || p.determined == 0.0)
        );
        let page = identify::fit::page(&found);
        assert!(page.contains("far from what the model states"), "{page}");
    }
}

/// The numbers of a small machine are numbers, too.
#[test]
fn a_small_machine_has_digits() {
    let mut found = fit_arm(&log(1, 0.05, 0.4, 0.6, 0.0), Inertia::Fixed);
    for term in &mut found.terms {
        for value in term.coefficients.values_mut() {
            (value.value, value.std) = (1e-7 * value.value, 1e-7 * value.std);
        }
    }
    for error in [&mut found.before, &mut found.after] {
        error.total *= 1e-7;
        error.by_coordinate.values_mut().for_each(|e| *e *= 1e-7);
    }
    let page = identify::fit::page(&found);
    assert!(!page.contains("0.0000") && page.contains("e-8"), "{page}");
}
