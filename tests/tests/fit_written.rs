//! What `fit` writes into a model: it explains the forces as well as was said, a load is called a
//! load, and what the model states already competes.

use dynamics_codegen::robot::Format;
use dynamics_codegen::{Compiled, Library, compile, model_of_description};
use identify::fit::{Fit, Inertia, Request, Source, Unwritable, fit, written};
use identify::log::Log;
use identify::machine::{Machine, States};
use integration_tests::random;
use rand::RngExt as _;
use std::fmt::Write;
use std::path::Path;

/// The inverse dynamics of a model along sums of sines, 20 s at 100 Hz, with noise of positions
/// (2e-5 rad) and torques (a thousandth of each joint's largest).
fn log_of(compiled: &Compiled, seed: u64) -> Log {
    let machine = Machine::new(compiled.clone());
    let model = &compiled.model;
    let n = model.coordinates.len();
    let mut rng = random::generator(seed);
    let mut draw = |low: f64, high: f64| rng.random_range(low..high);
    let waves: Vec<Vec<[f64; 3]>> = (0..n)
        .map(|_| {
            let wave = |size: f64, slow: f64, fast: f64, draw: &mut dyn FnMut(f64, f64) -> f64| {
                [size, draw(slow, fast), draw(0.0, 6.0)]
            };
            vec![
                wave(0.6, 0.7, 1.6, &mut draw),
                wave(0.3, 1.7, 3.0, &mut draw),
                wave(0.1, 3.5, 6.0, &mut draw),
            ]
        })
        .collect();
    let along = |i: usize, t: f64| -> [f64; 3] {
        waves[i].iter().fold([0.0; 3], |[q, v, a], [s, w, p]| {
            let (sin, cos) = (w * t + p).sin_cos();
            [q + s * sin, v + s * w * cos, a - s * w * w * sin]
        })
    };
    let mut rows: Vec<(f64, Vec<f64>, Vec<f64>)> = Vec::new();
    for k in 0..2000 {
        let t = 0.01 * f64::from(k);
        let motion: Vec<[f64; 3]> = (0..n).map(|i| along(i, t)).collect();
        let column = |k: usize| motion.iter().map(|m| vec![m[k]]).collect::<Vec<Vec<f64>>>();
        let states = States {
            t: vec![t],
            q: column(0),
            v: column(1),
            u: vec![vec![0.0]; n],
            ..States::default()
        };
        let terms = &machine.terms(&states, &model.nominal_parameters())[0];
        let needed = (0..n).map(|i| {
            let inertia: f64 = (0..n)
                .map(|j| terms.mass_matrix[(i, j)] * motion[j][2])
                .sum();
            inertia - terms.force[i]
        });
        rows.push((t, motion.iter().map(|m| m[0]).collect(), needed.collect()));
    }
    let largest = |i: usize| {
        rows.iter()
            .fold(0.0_f64, |most, row| most.max(row.2[i].abs()))
    };
    let largest: Vec<f64> = (0..n).map(largest).collect();
    let mut csv = String::from("t");
    for prefix in ["q", "u"] {
        for coordinate in &model.coordinates {
            write!(csv, ",{prefix}_{}", coordinate.name).unwrap();
        }
    }
    for (t, q, u) in &rows {
        write!(csv, "\n{t}").unwrap();
        for q in q {
            write!(csv, ",{}", q + draw(-4e-5, 4e-5)).unwrap();
        }
        for (u, largest) in u.iter().zip(&largest) {
            write!(csv, ",{}", u + 1e-3 * largest * draw(-1.7, 1.7)).unwrap();
        }
    }
    csv.push('\n');
    Log::from_bytes("log.csv", csv.as_bytes()).expect("a log")
}

fn library() -> Library {
    let mut library = Library::builtin();
    library.look_in(concat!(env!("CARGO_MANIFEST_DIR"), "/../models"));
    library
}

fn model(text: &str, library: &Library) -> Compiled {
    compile("arm.model", text, library).unwrap_or_else(|report| panic!("{report}\n{text}"))
}

/// What a log says of a model, and the model with that written in.
fn fitted(text: &str, log: &Log, inertia: Inertia, library: &Library) -> (Fit, String) {
    let compiled = model(text, library);
    let nominal = compiled.model.nominal_parameters();
    let request = Request {
        inertia,
        ..Request::new(
            Source {
                name: "arm.model",
                text,
                library,
            },
            &compiled,
            &nominal,
            log,
        )
    };
    let found = fit(&request).expect("it can be fitted");
    let text = written(&found, &request).expect("it can be written");
    (found, text)
}

/// Loads what was written and judges it on the same data: the error is the one that was printed.
fn check_round_trip(found: &Fit, text: &str, log: &Log, library: &Library) -> Fit {
    let (again, _) = fitted(text, log, Inertia::Fixed, library);
    for (name, after) in &found.after.by_coordinate {
        let loaded = again.before.by_coordinate[name];
        assert!(
            (loaded / after - 1.0).abs() < 2e-3,
            "{name}: {after} was said, {loaded} is it\n{text}"
        );
    }
    again
}

const ARM: &str = "model arm; coordinate a: rad; coordinate b: rad; input a: N*m; input b: N*m;
parameter l: m = 0.4 in 0.01..;
body upper { frame: rotate_z(a); mass: 2; center: (0.2, 0, 0); inertia: diag(0.02, 0.02, 0.02); }
body lower { frame: upper * translate(l, 0, 0) * rotate_z(b); mass: 1; center: (0.15, 0, 0);
    inertia: diag(0.01, 0.01, 0.01); }
gravity (0, -9.81, 0);
force a = input(a); force b = input(b);
";

#[test]
fn a_measured_arm_is_written_as_it_was_said() {
    let Some(urdf) = left_out::shared("data/measured/tx40/tx40.urdf") else {
        return;
    };
    let mut library = Library::builtin();
    library.look_in(urdf.parent().expect("a folder"));
    let text = std::fs::read_to_string(&urdf).unwrap();
    assert_eq!(Format::of(&text), Some(Format::Urdf));
    let log = Log::read(urdf.with_file_name("log.csv.gz")).expect("a log");
    let name = |path: &Path| path.file_name().unwrap().to_string_lossy().into_owned();
    let text = model_of_description(Format::Urdf, &name(&urdf));
    let (found, text) = fitted(&text, &log, Inertia::Consistent, &library);
    assert!(found.after.total < 2.093, "{}", found.after.total);
    assert!(
        text.contains("effect joint_coupling(joint_5, joint_6)"),
        "{text}"
    );
    let again = check_round_trip(&found, &text, &log, &library);
    assert!(again.terms.is_empty(), "{again:?}");
}

/// Wrong masses in `body` statements, friction that the model states too high, and a rotor that it
/// does not state.
#[test]
fn a_model_of_bodies_is_written_as_it_was_said() {
    let library = library();
    let true_text = ARM.replace("mass: 1;", "mass: 0.8;")
        + "effect viscous(a) { d = 0.4 }\neffect armature(b) { i = 0.06 }\n";
    let log = log_of(&model(&true_text, &library), 1);
    let given = format!("{ARM}effect viscous(a) {{ d = 0.9 }}\n");
    let (found, text) = fitted(&given, &log, Inertia::Consistent, &library);
    assert!(!found.inertial.is_empty(), "{found:?}");
    assert!(text.contains("inertia: full("), "{text}");
    assert_eq!(text.matches("effect viscous").count(), 1, "{text}");
    let again = check_round_trip(&found, &text, &log, &library);
    assert!(again.before.total < 0.05 * found.before.total, "{again:?}");
}

/// The links of a robot description become parameters.
#[test]
fn corrected_links_are_written_as_they_were_said() {
    let library = library();
    let open = "model arm;\nurdf \"ur5.urdf\" { parameters: all; }\n";
    let compiled = model(open, &library);
    let parameters = compiled.model.parameters.iter();
    let heavier = parameters.filter(|p| p.name.ends_with("_mass") && p.nominal > 1.0);
    let heavier = heavier.map(|p| format!("parameter {} = {};\n", p.name, 1.25 * p.nominal));
    let log = log_of(
        &model(&(open.to_string() + &heavier.collect::<String>()), &library),
        2,
    );
    let given = "model arm;\nurdf \"ur5.urdf\";\n";
    let (found, text) = fitted(given, &log, Inertia::Consistent, &library);
    assert!(!found.inertial.is_empty(), "{found:?}");
    check_round_trip(&found, &text, &log, &library);
}

/// An arm with friction, and on it a load that the model does not have.
#[test]
fn a_load_is_called_a_load() {
    let library = library();
    let unloaded = "model arm;\nurdf \"ur5.urdf\";\n".to_string()
        + &compile("arm", "model arm; urdf \"ur5.urdf\";", &library)
            .unwrap()
            .model
            .coordinates
            .iter()
            .map(|c| format!("effect viscous({}) {{ d = 1.5 }}\n", c.name))
            .collect::<String>();
    let bodies = model(&unloaded, &library).model;
    // Of what stands on the flange alone `tool0`, which has no mass, is farther.
    let last = "wrist_3_link".to_string();
    assert!(bodies.moving_bodies().any(|body| body.name == last));
    let load = format!("effect payload({last}) {{ m = 1.3, x = 0.02, y = 0.05, z = 0.12 }}\n");
    let loaded = model(&format!("{unloaded}{load}"), &library);
    for inertia in [Inertia::Fixed, Inertia::Consistent] {
        let log = log_of(&loaded, 3);
        let (found, text) = fitted(&unloaded, &log, inertia, &library);
        let terms: Vec<&str> = found.terms.iter().map(|t| t.term.as_str()).collect();
        assert_eq!(terms, ["payload"], "{found:?}");
        assert!(found.inertial.is_empty(), "{found:?}");
        let payload = &found.terms[0];
        assert_eq!(payload.on, [last.as_str()]);
        let truth = [("m", 1.3), ("x", 0.02), ("y", 0.05), ("z", 0.12)];
        for (name, truth) in truth {
            let value = payload.coefficients[name];
            let off = (value.value - truth).abs();
            assert!(
                off < 4.0 * value.std + 1e-4,
                "{name}: {value:?}, not {truth}"
            );
            assert!(value.std > 0.0 && value.std < 0.02, "{name}: {value:?}");
        }
        assert!(!payload.may_be_body, "{found:?}");
        let again = check_round_trip(&found, &text, &log, &library);
        assert!(again.terms.is_empty(), "{again:?}");
    }
    // The unloaded robot's next log adds nothing.
    let log = log_of(&model(&unloaded, &library), 4);
    let (found, text) = fitted(&unloaded, &log, Inertia::Consistent, &library);
    assert!(
        found.terms.is_empty() && found.inertial.is_empty(),
        "{found:?}"
    );
    assert_eq!(text, unloaded);
    // With the loaded one's model the load is gone.
    let (found, _) = fitted(&format!("{unloaded}{load}"), &log, Inertia::Fixed, &library);
    let payload = found.terms.iter().find(|t| t.term == "payload");
    let mass = payload.expect("a payload").coefficients["m"];
    assert!(mass.value.abs() < 0.05, "{found:?}");
}

/// A description whose losses are placeholders, in joints that hardly rub.
#[test]
fn stated_losses_compete() {
    let mut library = library();
    let urdf = std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/../models/ur5.urdf"))
        .unwrap();
    let end = "</joint>";
    let dynamics = "<dynamics damping=\"0.5\" friction=\"10.0\"/></joint>";
    library.add_file(
        "placeholder.urdf",
        "placeholder.urdf",
        urdf.replace(end, dynamics),
    );
    let joints = model("model a; urdf \"ur5.urdf\";", &library)
        .model
        .coordinates;
    let mut truth = "model arm;\nurdf \"ur5.urdf\" { losses: ignore; }\n".to_string();
    for (index, joint) in joints.iter().enumerate().skip(1) {
        let (name, friction) = (&joint.name, 1.0 + index as f64);
        writeln!(
            truth,
            "effect coulomb({name}) {{ f_c = {friction}, v_s = 0.01 }}"
        )
        .unwrap();
    }
    let log = log_of(&model(&truth, &library), 5);
    let given = "model arm;\nurdf \"placeholder.urdf\";\n";
    let (found, text) = fitted(given, &log, Inertia::Fixed, &library);
    for (index, joint) in joints.iter().enumerate() {
        let own = |t: &&identify::fit::Term| t.term == "friction" && t.on == [joint.name.as_str()];
        let term = found.terms.iter().find(own);
        let term = term.unwrap_or_else(|| panic!("{}: {found:?}", joint.name));
        let truth = if index == 0 { 0.0 } else { 1.0 + index as f64 };
        let coulomb = term.coefficients["coulomb"].value;
        assert!((coulomb - truth).abs() < 0.1, "{term:?}, not {truth}");
        assert!(coulomb >= 0.0 && term.stated["coulomb"] == 10.0, "{term:?}");
    }
    assert!(
        found.terms.iter().all(|t| t.term == "friction"),
        "{found:?}"
    );
    assert!(
        text.contains("urdf \"placeholder.urdf\" { losses: ignore; }"),
        "{text}"
    );
    check_round_trip(&found, &text, &log, &library);
}

/// A body that is heavier than stated is as good as a load in its centre: that is said.
#[test]
fn a_load_in_the_centre_may_be_the_body() {
    let library = library();
    let log = log_of(&model(&ARM.replace("mass: 1;", "mass: 1.3;"), &library), 8);
    let (found, _) = fitted(ARM, &log, Inertia::Consistent, &library);
    assert_eq!(found.terms.len(), 1, "{found:?}");
    let term = &found.terms[0];
    assert!(term.term == "payload" && term.may_be_body, "{found:?}");
    let page = identify::fit::page(&found);
    assert!(page.contains("or the body itself is heavier"), "{page}");
    // Along the axes of all joints nothing tells where it is.
    assert!(page.contains("z is not determined"), "{page}");
}

/// Inertias of no body, and what makes a model worse, are not written.
#[test]
fn what_should_not_be_written_is_not() {
    let library = library();
    let text = ARM.to_string();
    let lighter = ARM.replace("mass: 1;", "mass: 0.7;");
    let log = log_of(&model(&lighter, &library), 6);
    let compiled = model(&text, &library);
    let nominal = compiled.model.nominal_parameters();
    let request = Request::new(
        Source {
            name: "arm.model",
            text: &text,
            library: &library,
        },
        &compiled,
        &nominal,
        &log,
    );
    let mut found = fit(&request).unwrap();
    let refused = written(&found, &request);
    assert!(matches!(refused, Err(Unwritable::Linear)), "{refused:?}");
    found.worse = true;
    let refused = written(&found, &request);
    assert!(matches!(refused, Err(Unwritable::Worse)), "{refused:?}");
}

/// A part states the bodies of all its uses: those of one use have no place of their own.
#[test]
fn inertias_of_one_use_are_not_written_into_its_part() {
    let library = library();
    let text = "model arm;
gravity (0, -9.81, 0);
part link(base) {
    coordinate j: rad;
    input j: N*m;
    body bone { frame: base * rotate_z(j); mass: 2; center: (0.2, 0, 0); inertia: diag(0.02, 0.02, 0.02); }
    frame end = bone * translate(0.4, 0, 0);
    force j = input(j);
}
use upper = link(world);
use lower = link(upper.end);
";
    let log = log_of(&model(&text.replace("mass: 2;", "mass: 1.5;"), &library), 6);
    let compiled = model(text, &library);
    let nominal = compiled.model.nominal_parameters();
    let mut request = Request {
        inertia: Inertia::Consistent,
        ..Request::new(
            Source {
                name: "arm.model",
                text,
                library: &library,
            },
            &compiled,
            &nominal,
            &log,
        )
    };
    let found = fit(&request).unwrap();
    assert!(!found.inertial.is_empty(), "{found:?}");
    let refused = written(&found, &request);
    assert!(
        matches!(&refused, Err(Unwritable::Part(body)) if body.ends_with("_bone")),
        "{refused:?}"
    );
    request.inertia = Inertia::Fixed;
    let found = fit(&request).unwrap();
    assert!(written(&found, &request).is_ok());
}

/// A drive of one joint that rubs with the sum of two is no coupling: it does not push the other,
/// in which something acts that nothing explains.
#[test]
fn what_helps_one_joint_must_not_hurt_another() {
    let library = library();
    let truth = format!(
        "{ARM}parameter d: N*m*s = 3; parameter k: N*m = 4;
         force a = -d*(dot(a) + dot(b)); force b = k*cos(9*b);\n"
    );
    let log = log_of(&model(&truth, &library), 7);
    let (found, _) = fitted(ARM, &log, Inertia::Fixed, &library);
    let coupled = found.terms.iter().any(|t| t.term == "joint_coupling");
    assert!(!coupled, "{found:?}");
    let error = |fit: &identify::fit::Error| fit.by_coordinate["b"];
    assert!(
        error(&found.after) < 1.05 * error(&found.before),
        "{found:?}"
    );
    assert!(found.after.total < found.before.total, "{found:?}");
}
