//! The loop on logs with an undeclared effect: simulated by others, and measured.

use dynamics_codegen::{Library, compile};
use identify::fit::{Inertia, Request as FitRequest, Source, fit};
use identify::log::{Log, Map};
use identify::trace::{Basis, Finding, Outcome, Request, Score, Verdict, trace};
use std::collections::BTreeMap;
use std::path::PathBuf;

const ROOT: &str = env!("CARGO_MANIFEST_DIR");

fn machine(model: &str, id: &str) -> Outcome {
    let folder = PathBuf::from(ROOT).join("data/scenarios").join(id);
    let text = std::fs::read_to_string(format!("{ROOT}/../models/{model}.model")).unwrap();
    let parameters = std::fs::read_to_string(folder.join("parameters.json")).unwrap();
    let parameters: BTreeMap<String, f64> = serde_json::from_str(&parameters).unwrap();
    let train = Log::read(folder.join("train.csv.gz")).unwrap();
    let test = Log::read(folder.join("test.csv.gz")).unwrap();
    run(model, &text, parameters, &train, Some(&test), 0.5)
}

fn run(
    name: &str,
    text: &str,
    parameters: BTreeMap<String, f64>,
    train: &Log,
    test: Option<&Log>,
    horizon: f64,
) -> Outcome {
    let library = Library::builtin();
    let request = Request {
        parameters,
        test,
        horizon,
        ..Request::new(name, text, &library, train)
    };
    trace(&request).unwrap_or_else(|error| panic!("{error}"))
}

/// One finding, of this name at this place, with these parameters within three
/// standard deviations and 2 %; the error after within 15 % of the floor that the
/// simulator states, and far below the error before.
fn expect(outcome: &Outcome, effect: &str, on: &str, truth: &[(&str, f64)], floor: f64) {
    assert_eq!(outcome.findings.len(), 1, "{:#?}", outcome.findings);
    let finding = &outcome.findings[0];
    assert_eq!(
        (finding.effect.as_str(), finding.on.as_slice()),
        (effect, &[on.to_string()][..])
    );
    for &(name, value) in truth {
        let estimate = &finding.parameters[name];
        let miss = (estimate.value - value).abs();
        assert!(
            miss < 3.0 * estimate.std && miss < 0.02 * value,
            "{name}: {estimate:?}"
        );
    }
    let (before, after) = (
        outcome.before.acceleration.total,
        outcome.after.acceleration.total,
    );
    assert!(after < 1.15 * floor, "{after} against the floor {floor}");
    assert!(after < before / 2.0, "{before} -> {after}");
    assert!(outcome.after.rollout.errors.total < outcome.before.rollout.errors.total / 5.0);
    // The patched model compiles and holds the effect.
    let patched =
        dynamics_codegen::compile("patched", &outcome.patched_model, &Library::builtin()).unwrap();
    assert_eq!(patched.model.effects.len(), 1);
}

#[test]
fn viscous_friction_in_the_second_joint() {
    let outcome = machine("pendulum2", "o01_pendulum2");
    assert_eq!(outcome.verdict, Verdict::Effect);
    expect(&outcome, "viscous", "j2", &[("d", 0.02)], 0.0731);
}

#[test]
fn coulomb_friction_of_a_cart() {
    let outcome = machine("cartpole", "o02_cartpole");
    assert_eq!(outcome.verdict, Verdict::Effect);
    expect(
        &outcome,
        "coulomb",
        "x",
        &[("f_c", 0.8), ("v_s", 0.02)],
        0.0234,
    );
}

#[test]
fn a_spring_from_positions_alone() {
    let outcome = machine("pendulum2", "o05_pendulum2");
    assert_eq!(outcome.verdict, Verdict::Effect);
    expect(
        &outcome,
        "spring",
        "j1",
        &[("k", 0.12), ("q_0", 0.1)],
        0.0151,
    );
}

#[test]
fn a_drive_that_delivers_less_than_commanded() {
    let outcome = machine("unicycle2d", "o07_unicycle2d");
    assert_eq!(outcome.verdict, Verdict::Channel);
    expect(&outcome, "input_gain", "drive", &[("gain", 0.9)], 0.0243);
}

#[test]
fn one_delay_in_front_of_both_drives() {
    if left_out::too_slow() {
        return;
    }
    let outcome = machine("duffing_free", "o08_duffing");
    assert_eq!(outcome.verdict, Verdict::Channel);
    let [finding] = &outcome.findings[..] else {
        panic!("{:#?}", outcome.findings);
    };
    assert_eq!(finding.effect, "input_delay");
    assert_eq!(finding.on, ["x1", "x2"]);
    assert!((finding.parameters.values().next().unwrap().value - 0.04).abs() < 0.002);
    assert!(outcome.after.acceleration.total < 1.1 * 0.0216);
    let patched =
        dynamics_codegen::compile("patched", &outcome.patched_model, &Library::builtin()).unwrap();
    let [effect] = &patched.model.effects[..] else {
        panic!("{:#?}", patched.model.effects);
    };
    let on = effect.on.iter().map(|(_, input)| input.as_str());
    assert!(on.eq(["x1", "x2"]), "one for both inputs: {effect:?}");
}

/// Both effects, within three standard deviations and 2 %.
fn expect_all(outcome: &Outcome, truth: &[(&str, &str, &str, f64)], floor: f64) {
    assert_eq!(
        outcome.findings.len(),
        truth.len(),
        "{:#?}",
        outcome.findings
    );
    for &(effect, on, name, value) in truth {
        let mut findings = outcome.findings.iter();
        let finding = findings.find(|f| f.effect == effect && f.on == [on]);
        let estimate = &finding.unwrap_or_else(|| panic!("{effect}")).parameters[name];
        let miss = (estimate.value - value).abs();
        assert!(
            miss < 3.0 * estimate.std && miss < 0.02 * value.abs(),
            "{name}: {estimate:?}"
        );
    }
    assert_eq!(outcome.verdict, Verdict::Effect);
    let after = outcome.after.acceleration.total;
    assert!(after < 1.15 * floor, "{after} against the floor {floor}");
}

/// Alone neither leaves much less than the model as given.
#[test]
fn drag_and_a_delay_that_only_show_together() {
    if left_out::too_slow() {
        return;
    }
    let outcome = machine("pendulum2", "two_joints_drag_and_delay");
    let truth = [
        ("quadratic_drag", "j2", "c", 0.002_569),
        ("input_delay", "j2", "tau", 0.035_09),
    ];
    expect_all(&outcome, &truth, 0.0181);
}

/// Beside a load that is not found yet, a push looks like a wave along the way.
#[test]
fn a_push_is_no_wave_once_the_load_is_known() {
    if left_out::too_slow() {
        return;
    }
    let outcome = machine("cartpole", "cart_pushed_and_loaded");
    let truth = [
        ("constant_force", "x", "f", -1.627),
        ("payload", "pole", "m", 0.1456),
    ];
    expect_all(&outcome, &truth, 0.0369);
}

/// The balance of forces alone calls this eight things, most of them wrong, and leaves a quarter of what is
/// missing: from there the motion goes on. The rotor of the first joint is an inertia of the first link.
#[test]
fn friction_and_rotors_in_every_joint_and_a_load() {
    if left_out::too_slow() {
        return;
    }
    let folder = PathBuf::from(ROOT).join("data/scenarios/arm_of_seven_effects");
    let text = "model arm;\nurdf \"arm.urdf\" { parameters: all; }\n";
    let mut library = Library::builtin();
    library.look_in(&folder);
    let [train, test] =
        ["train.csv.gz", "test.csv.gz"].map(|log| Log::read(folder.join(log)).unwrap());
    let request = Request {
        test: Some(&test),
        ..Request::new("arm", text, &library, &train)
    };
    let mut outcome = trace(&request).unwrap_or_else(|error| panic!("{error}"));
    let first = outcome.findings.iter_mut();
    for twin in first.filter(|f| f.effect == "parameter" && f.on == ["link1_iyy"]) {
        let mut rivals = twin.confounded_with.iter();
        assert!(rivals.any(|r| r.effect == "armature" && r.on == ["j1"]));
        (twin.effect, twin.on) = ("armature".into(), vec!["j1".into()]);
        let mut rotor = twin.parameters.remove("link1_iyy").unwrap();
        rotor.value -= 0.0408;
        twin.parameters.insert("i".into(), rotor);
    }
    let truth = [
        ("coulomb", "j1", "f_c", 0.665),
        ("coulomb", "j2", "f_c", 0.1529),
        ("coulomb", "j3", "f_c", 0.087_56),
        ("armature", "j1", "i", 0.1196),
        ("armature", "j2", "i", 0.011_52),
        ("armature", "j3", "i", 0.004_813),
        ("payload", "link3", "m", 0.3065),
    ];
    expect_all(&outcome, &truth, 0.0302);
}

#[test]
fn a_hysteresis_that_no_effect_names() {
    if left_out::too_slow() {
        return;
    }
    let outcome = machine("duffing_constrained", "o11_duffing");
    assert_eq!(outcome.verdict, Verdict::Unknown);
    let model = "models/duffing_constrained.model";
    let model = std::fs::read_to_string(format!("{ROOT}/../{model}")).unwrap();
    assert_eq!(outcome.patched_model, model, "no name, no patch");
    assert!(outcome.findings.is_empty(), "{:#?}", outcome.findings);
    assert_eq!(outcome.after, outcome.before, "the model as written");
    if let Some(nearest) = &outcome.nearest {
        assert!(!nearest.findings.is_empty() && nearest.errors != outcome.before);
    }
    let unnamed = outcome.unnamed.expect("a description");
    let [force, ..] = &unnamed.forces[..] else {
        panic!("{unnamed:#?}");
    };
    assert_eq!(force.coordinate, "x2");
    assert!(force.remembers && force.dissipation > 0.3, "{force:#?}");
    assert!(unnamed.recovered > 0.7, "{}", unnamed.recovered);
}

#[test]
fn a_machine_that_is_as_its_model_says() {
    let outcome = machine("cartpole", "o06_cartpole");
    assert_eq!(outcome.verdict, Verdict::None);
    assert!(outcome.findings.is_empty());
    let model = std::fs::read_to_string(format!("{ROOT}/../models/cartpole.model")).unwrap();
    assert_eq!(outcome.patched_model, model);
}

#[test]
fn a_wrong_parameter_is_not_blamed_on_an_effect() {
    // The true machine's log, traced with a cart that is said to be 10 % heavier.
    let folder = PathBuf::from(ROOT).join("data/scenarios/o06_cartpole");
    let text = std::fs::read_to_string(format!("{ROOT}/../models/cartpole.model")).unwrap();
    let parameters = std::fs::read_to_string(folder.join("parameters.json")).unwrap();
    let mut parameters: BTreeMap<String, f64> = serde_json::from_str(&parameters).unwrap();
    let truth = parameters["mc"];
    parameters.insert("mc".into(), 1.1 * truth);
    let train = Log::read(folder.join("train.csv.gz")).unwrap();
    let outcome = run("cartpole", &text, parameters, &train, None, 0.5);
    assert_eq!(
        outcome.verdict,
        Verdict::Parameter,
        "{:#?}",
        outcome.findings
    );
    assert_eq!(outcome.findings[0].on, ["mc"]);
    let estimate = &outcome.findings[0].parameters["mc"];
    assert!(
        (estimate.value - truth).abs() < 3.0 * estimate.std,
        "{estimate:?} {truth}"
    );
}

/// Five forces of a narrow band explain much of it, one number all of it.
#[test]
fn a_lighter_pole_is_no_crowd_of_forces() {
    let outcome = machine("cartpole", "cart_of_a_lighter_pole");
    assert_eq!(
        outcome.verdict,
        Verdict::Parameter,
        "{:#?}",
        outcome.findings
    );
    assert_eq!(outcome.findings.len(), 1, "{:#?}", outcome.findings);
    assert_eq!(outcome.findings[0].on, ["I"]);
    let estimate = &outcome.findings[0].parameters["I"];
    assert!(
        (estimate.value - 0.003072).abs() < 3.0 * estimate.std,
        "{estimate:?}"
    );
    let after = outcome.after.acceleration.total;
    assert!(after < 1.15 * 0.0251, "{after}");
}

#[test]
fn the_same_seed_gives_the_same_outcome() {
    if left_out::too_slow() {
        return;
    }
    let json = || serde_json::to_string(&machine("pendulum2", "o01_pendulum2")).unwrap();
    assert_eq!(json(), json());
}

/// The free swing of a real pendulum, read where it is; the last third is held out.
#[test]
fn friction_of_a_real_pendulum() {
    let Some(path) = left_out::shared("data/measured/pendulum_single/log.csv.gz") else {
        return;
    };
    let text = std::fs::read_to_string(format!("{ROOT}/data/measured/pendulum_single.model"));
    let log = Log::read(&path).unwrap();
    let outcome = run(
        "pendulum_single",
        &text.unwrap(),
        BTreeMap::new(),
        &log,
        None,
        3.0,
    );
    assert_eq!(outcome.verdict, Verdict::Effect);
    assert!(
        outcome
            .findings
            .iter()
            .any(|f| f.effect != "parameter" && f.on == ["q_1"])
    );
    let (before, after) = (&outcome.before.rollout, &outcome.after.rollout);
    assert!(
        after.errors.total < before.errors.total / 3.0,
        "{before:?} {after:?}"
    );
}

/// Effects that are a joint's friction.
const FRICTION: [&str; 4] = ["viscous", "coulomb", "asymmetric_coulomb", "stribeck"];

/// What `trace` found is what `fit` finds by linear regression of the same log: each friction, rotor and coupling
/// at its place, in numbers that differ by no more than three of their standard errors.
fn expect_as_fitted(outcome: &Outcome, (name, text, library): (&str, &str, &Library), log: &Log) {
    let compiled = compile(name, text, library).expect("a model");
    let nominal = compiled.model.nominal_parameters();
    let request = FitRequest {
        inertia: Inertia::Fixed,
        ..FitRequest::new(
            Source {
                name,
                text,
                library,
            },
            &compiled,
            &nominal,
            log,
        )
    };
    let fitted = fit(&request).expect("it can be fitted");
    let mut compared = 0;
    for term in fitted.terms.iter().filter(|t| t.term != "constant_force") {
        let is_same = |f: &&Finding| {
            let effect = f.effect.as_str();
            f.on == term.on
                && match term.term.as_str() {
                    "friction" => FRICTION.contains(&effect),
                    other => effect == other,
                }
        };
        let same: Vec<&Finding> = outcome.findings.iter().filter(is_same).collect();
        for (coefficient, fitted) in &term.coefficients {
            // Dry friction may differ by direction: half of the two is what does not.
            let traced = |names: &[&str]| {
                let all = same.iter().flat_map(|f| &f.parameters);
                let own = all.filter(|(name, _)| names.contains(&name.as_str()));
                let own: Vec<(f64, f64)> = own.map(|(_, p)| (p.value, p.std)).collect();
                let count = own.len() as f64;
                let of = |each: fn(&(f64, f64)) -> f64| own.iter().map(each).sum::<f64>() / count;
                (of(|own| own.0), of(|own| own.1))
            };
            let (value, std) = match coefficient.as_str() {
                "viscous" => traced(&["d"]),
                "coulomb" => traced(&["f_c", "f_p", "f_n"]),
                other => traced(&[other]),
            };
            let apart = (value - fitted.value).abs();
            assert!(
                apart < 3.0 * std.hypot(fitted.std),
                "{coefficient} of {} on {:?}: {value} ± {std} traced, {fitted:?} fitted",
                term.term,
                term.on
            );
            compared += 1;
        }
    }
    assert!(compared >= 2, "{fitted:?}");
}

/// The axis of a machine tool, of which the model has the mass alone. What plain least squares finds in
/// another of its records stands beside its log: 203.5 N·s/m, 20.39 N, and an offset. The rest is
/// ripple, which is no reason to say nothing.
#[test]
fn friction_of_a_real_axis() {
    let Some(model) = left_out::shared("data/measured/emps/emps.model") else {
        return;
    };
    let text = std::fs::read_to_string(&model).expect("a model");
    let map = Map::read(&model.with_file_name("log.toml")).expect("a map");
    let log = Log::read_with(model.with_file_name("log.csv.gz"), Some(&map)).expect("a log");
    let outcome = run("emps", &text, BTreeMap::new(), &log, None, 0.5);
    assert_eq!(outcome.verdict, Verdict::Effect, "{:#?}", outcome.findings);
    let of = |effect: &str| {
        let mut findings = outcome.findings.iter();
        let finding = findings.find(|f| f.effect == effect);
        finding.unwrap_or_else(|| panic!("{effect}: {:#?}", outcome.findings))
    };
    let viscous = of("viscous").parameters["d"].value;
    let dry = &of("asymmetric_coulomb").parameters;
    let dry = (dry["f_p"].value + dry["f_n"].value) / 2.0;
    assert!((viscous / 203.5 - 1.0).abs() < 0.05, "{viscous} N·s/m");
    assert!((dry / 20.39 - 1.0).abs() < 0.05, "{dry} N");
    // `fit`, which is plain least squares, leaves 2.76 N.
    let left = outcome.after.force.per_coordinate["x"];
    assert!(left < 2.76, "{left} N");
    expect_as_fitted(&outcome, ("emps", &text, &Library::builtin()), &log);
}

/// A free double pendulum without friction in its model. Both coefficients of viscous friction, fitted
/// alone, bring predictions over 3 s to 0.19 and 0.13 of their errors; the geometry is not exact
/// either.
#[test]
fn friction_of_a_real_double_pendulum() {
    let Some(model) = left_out::shared("data/measured/multiarm_double/double.model") else {
        return;
    };
    let text = std::fs::read_to_string(&model).expect("a model");
    let map = Map::read(&model.with_file_name("log.toml")).expect("a map");
    let log = Log::read_with(model.with_file_name("log.csv.gz"), Some(&map)).expect("a log");
    let outcome = run("double", &text, BTreeMap::new(), &log, None, 3.0);
    assert_eq!(outcome.verdict, Verdict::Effect, "{:#?}", outcome.findings);
    for joint in ["theta1", "rel"] {
        let brakes = ["viscous", "coulomb", "stribeck", "quadratic_drag"];
        let mut findings = outcome.findings.iter();
        assert!(
            findings.any(|f| f.on == [joint] && brakes.contains(&f.effect.as_str())),
            "{joint}: {:#?}",
            outcome.findings
        );
        let [before, after] = [&outcome.before, &outcome.after]
            .map(|score| score.rollout.errors.per_coordinate[joint]);
        assert!(after < 0.2 * before, "{joint}: {before} -> {after} rad");
    }
}

/// A driven double pendulum near its resonance, whose positions shake by more than its torques could shake it: in
/// the band in which forces tell most dry friction shows in both joints. What an independent look at other runs
/// of the day found is 0.14 and 0.16 N·m of it, and drives that follow late.
#[test]
fn friction_of_a_real_driven_double_pendulum() {
    let Some(model) = left_out::shared("data/measured/dfki_double/dp.model") else {
        return;
    };
    let text = std::fs::read_to_string(&model).expect("a model");
    for name in ["run_143339", "run_144003"] {
        let map = Map::read(&model.with_file_name(format!("{name}.toml"))).expect("a map");
        let log = model.with_file_name(format!("{name}.csv.gz"));
        let log = Log::read_with(log, Some(&map)).expect("a log");
        let outcome = run("dp", &text, BTreeMap::new(), &log, None, 0.5);
        assert_eq!(outcome.verdict, Verdict::Effect, "{:#?}", outcome.findings);
        for joint in ["shoulder", "elbow"] {
            let dry = [
                "coulomb",
                "stribeck",
                "asymmetric_coulomb",
                "joint_coupling",
            ];
            let is_dry = |f: &Finding| dry.contains(&f.effect.as_str());
            let mut findings = outcome.findings.iter();
            assert!(
                findings.any(|f| is_dry(f) && f.on.iter().any(|on| on == joint)),
                "{name}, {joint}: {:#?}",
                outcome.findings
            );
        }
        let [before, after] =
            [&outcome.before, &outcome.after].map(|score| score.rollout.errors.total);
        assert!(after < 0.1 * before, "{name}: {before} -> {after}");
    }
}

/// A real arm with its nominal inertias, of which nothing is known but motor torques: dry and
/// viscous friction, rotors, and two wrist joints that share a drive. Its last link has no
/// inertia, so that the model as given cannot move. The last third is held out.
#[test]
fn everything_that_a_real_arm_lacks() {
    let Some(urdf) = left_out::shared("data/measured/tx40/tx40.urdf") else {
        return;
    };
    let text = "model tx40;\nurdf \"tx40.urdf\";";
    let mut library = Library::builtin();
    library.look_in(urdf.parent().expect("a folder"));
    let log = Log::read(urdf.with_file_name("log.csv.gz")).expect("a log");
    let outcome = trace(&Request::new("tx40", text, &library, &log))
        .unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(
        (outcome.verdict, outcome.basis),
        (Verdict::Effect, Basis::Forces)
    );
    let found = |effects: &[&str], joint: &str| {
        let mut findings = outcome.findings.iter();
        findings.any(|f| effects.contains(&f.effect.as_str()) && f.on.iter().any(|on| on == joint))
    };
    for joint in [
        "joint_1", "joint_2", "joint_3", "joint_4", "joint_5", "joint_6",
    ] {
        assert!(
            found(&["coulomb", "stribeck", "joint_coupling"], joint),
            "{joint}"
        );
    }
    for joint in ["joint_1", "joint_2", "joint_3", "joint_4"] {
        assert!(found(&["armature"], joint), "{joint}");
    }
    let wrist = |f: &&Finding| f.effect == "joint_coupling" && f.on == ["joint_5", "joint_6"];
    assert!(
        outcome.findings.iter().any(|f| wrist(&f)),
        "{:#?}",
        outcome.findings
    );
    let estimates = outcome.findings.iter().flat_map(|f| f.parameters.values());
    assert!(estimates.clone().all(|p| p.std.is_finite() && p.std > 0.0));
    let total = |score: &Score| {
        let squares = score.force.per_coordinate.values().map(|rms| rms * rms);
        (squares.sum::<f64>() / 6.0).sqrt()
    };
    assert!(
        total(&outcome.before) > 10.0 && total(&outcome.after) < 2.2,
        "N*m"
    );
    // A model that cannot move has no accelerations; with what was found it has.
    assert!(outcome.before.acceleration.total.is_infinite());
    assert!(outcome.after.rollout.errors.total < 0.5);
    expect_as_fitted(&outcome, ("tx40", text, &library), &log);
}

/// A real drive that follows its command one and a third samples late. Somebody pushes the
/// pendulum by hand, which no effect is; the delay is found all the same, on the channel.
#[test]
fn the_delay_of_a_real_drive() {
    let Some(log) = left_out::shared("data/measured/dfki_pendulum/log.csv.gz") else {
        return;
    };
    let text = std::fs::read_to_string(format!("{ROOT}/data/measured/dfki_pendulum.model"));
    let log = Log::read(&log).unwrap();
    let (text, parameters) = (text.unwrap(), BTreeMap::new());
    let outcome = run("dfki_pendulum", &text, parameters, &log, None, 0.5);
    let late = |f: &&Finding| f.effect == "input_delay" && f.on == ["u_1"];
    let found = outcome.findings.iter().find(late).expect("a delay");
    let tau = &found.parameters["tau"];
    // Cross-correlation of the two columns: more than one sample of 5 ms, less than two.
    assert!(
        (0.005..0.010).contains(&tau.value) && tau.std < 1e-3,
        "{tau:?}"
    );
    let friction = [
        "coulomb",
        "stribeck",
        "asymmetric_coulomb",
        "viscous",
        "lugre",
    ];
    let mut findings = outcome.findings.iter();
    assert!(!findings.any(|f| friction.contains(&f.effect.as_str())));
    assert!(outcome.patched_model.contains("effect input_delay(u_1)"));
}
