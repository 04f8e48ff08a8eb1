//! Logs held against models whose bodies float by their twists.

use dynamics_codegen::model::{POSE, TWIST};
use dynamics_codegen::{Library, compile};
use identify::fit::{Inertia, Request, Source, fit, written};
use identify::log::Log;
use identify::trace::{self, Verdict};
use std::fmt::Write;

const HULL: &str = include_str!("floating/hull.urdf");
const MODEL: &str = include_str!("floating/hull.model");

fn library() -> Library {
    let mut library = Library::builtin();
    library.add_file("hull.urdf", "hull.urdf", HULL);
    library
}

/// A hull that floats straight on and turns against its wheel, `ψ = −I_w/(I_h + I_w) θ`, whose bearing brakes
/// by 0.03 N·m·s: in closed form, by its twist.
fn log() -> Log {
    let (of_hull, of_wheel) = (0.1, 0.02);
    let share = -of_wheel / (of_hull + of_wheel);
    let mut text = String::from("t");
    for (ending, _) in POSE {
        write!(text, ",q_hull_{ending}").unwrap();
    }
    text.push_str(",q_wheel");
    for (ending, _) in TWIST {
        write!(text, ",dq_hull_{ending}").unwrap();
    }
    text.push_str(",u_wheel\n");
    // Rectangular, of a linear congruential generator.
    let mut random = {
        let mut state = 4_u64;
        move || {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
        }
    };
    for k in 0..1200 {
        let t = 0.01 * f64::from(k);
        let wheel = 3.0 * (1.1 * t).sin() + (3.7 * t).sin();
        let rate = 3.3 * (1.1 * t).cos() + 3.7 * (3.7 * t).cos();
        let change = -3.63 * (1.1 * t).sin() - 13.69 * (3.7 * t).sin();
        let (turn, spin) = (share * wheel, share * rate);
        let motor = of_wheel * (1.0 + share) * change + 0.03 * rate;
        let (sine, cosine) = (0.5 * turn).sin_cos();
        let pose = [0.2 * t, -0.1 * t, 0.05 * t, 0.0, 0.0, sine, cosine, wheel];
        let (x, y) = (0.2, -0.1);
        let forward = x * turn.cos() + y * turn.sin();
        let left = y * turn.cos() - x * turn.sin();
        let twist = [forward, left, 0.05, 0.0, 0.0, spin];
        write!(text, "{t}").unwrap();
        for x in pose.into_iter().chain(twist) {
            write!(text, ",{}", x + 1e-4 * random()).unwrap();
        }
        writeln!(text, ",{motor}").unwrap();
    }
    Log::from_bytes("hull.csv", text.as_bytes()).unwrap()
}

#[test]
fn friction_is_fitted_where_a_body_floats_by_its_twist() {
    let (library, log) = (library(), log());
    let compiled = compile("hull.model", MODEL, &library).unwrap();
    let source = Source {
        name: "hull.model",
        text: MODEL,
        library: &library,
    };
    let request = Request {
        inertia: Inertia::Fixed,
        ..Request::new(source, &compiled, &[], &log)
    };
    let found = fit(&request).unwrap();
    assert_eq!(found.terms.len(), 1, "{:?}", found.terms);
    assert_eq!(found.terms[0].on, ["wheel"]);
    let viscous = found.terms[0].coefficients["viscous"];
    assert!(
        (viscous.value - 0.03).abs() < 3.0 * viscous.std,
        "{viscous:?}"
    );
    let text = written(&found, &request).unwrap();
    assert!(
        text.starts_with(MODEL) && text.contains("effect viscous(wheel)"),
        "{text}"
    );
}

#[test]
fn friction_is_found_where_a_body_floats_by_its_twist() {
    if left_out::too_slow() {
        return;
    }
    let (library, log) = (library(), log());
    let outcome = trace::trace(&trace::Request::new("hull.model", MODEL, &library, &log)).unwrap();
    assert_eq!(outcome.verdict, Verdict::Effect);
    let [finding] = &outcome.findings[..] else {
        panic!("{:?}", outcome.findings);
    };
    assert_eq!(
        (&finding.effect[..], &finding.on[..]),
        ("viscous", &["wheel".to_string()][..])
    );
    let d = &finding.parameters["d"];
    assert!((d.value - 0.03).abs() < 3.0 * d.std, "{d:?}");
    assert!(
        outcome.patched_model.starts_with(MODEL),
        "{}",
        outcome.patched_model
    );
}

#[test]
fn what_acts_on_a_twist_is_refused() {
    let (library, log) = (library(), log());
    let text = format!("{MODEL}force hull_wz = 0.1;\n");
    let error =
        trace::trace(&trace::Request::new("hull.model", &text, &library, &log)).unwrap_err();
    insta::assert_snapshot!(error.to_string(), @r"
    `hull` floats by its twist, and logs are held against the rates of its pose (`velocities: rates`), of which the model cannot say the same:
    error: there is no coordinate named `hull_wz`
     --> hull.model:5:7
      |
    5 | force hull_wz = 0.1;
      |       ^^^^^^^
      |
    help: did you mean `hull_qz`?
    ");
}
