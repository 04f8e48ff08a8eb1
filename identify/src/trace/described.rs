//! The numbers of a robot description as parameters.
//!
//! What a description says of its links and joints may be as wrong as any parameter. Where the model
//! leaves open whether they are parameters (`urdf "arm.urdf";`), they are where effects do not
//! explain the log; in the model that is written only those are that have another value.

use crate::robot_options::{description, with_choice, with_option};
use dynamics_codegen::Model;
use dynamics_codegen::model::{Described, StatedLosses};
use dynamics_codegen::syntax::{RobotOption, written_name};

/// The options that make parameters of a description's numbers.
const OPTIONS: [&str; 2] = ["parameters", "origins"];

/// The option that says which stated losses act.
const LOSSES: &str = "losses";

/// The option that makes parameters of stated losses.
const FRICTION: &str = "friction";

/// The model with all losses that its description states as parameters; nothing if it states none, or if the model says that
/// none is.
pub(super) fn with_open_losses(text: &str, model: &Model) -> Option<String> {
    let robot = model.robot.as_ref()?;
    let states = |losses: &StatedLosses| losses.damping != 0.0 || losses.friction != 0.0;
    let (_, options) = description(text)?;
    let of_losses = options.iter().find(|given| given.name.text == FRICTION);
    let are_given = of_losses.is_some_and(|given| given.values.iter().any(|v| v.text == "none"));
    let is_open = robot.losses.iter().any(states) && !are_given;
    is_open.then(|| with_choice(text, FRICTION, "all"))
}

/// The parameters that are losses which the model's description states, and that may not be there: of each less may act
/// than by default, and more is a law beside it. A log may say less than none, by chance; see
/// [`Selection::keep_losses_possible`](super::selection::Selection::keep_losses_possible).
pub(super) fn limited_losses(model: &mut Model, defaults: &[f64]) -> Vec<usize> {
    let described = model.robot.iter().flat_map(|robot| &robot.described);
    let losses = described.filter(|number| number.option == FRICTION);
    let index = |number: &Described| {
        let mut parameters = model.parameters.iter();
        parameters.position(|p| p.name == number.parameter)
    };
    let losses: Vec<usize> = losses.filter_map(index).collect();
    for &index in losses.iter().filter(|&&index| defaults[index] > 0.0) {
        let parameter = &mut model.parameters[index];
        (parameter.lower, parameter.upper) = (-defaults[index], defaults[index]);
    }
    losses
}

/// The model with all of its description's numbers as parameters, but where it says itself
/// which are; nothing if it says all.
pub(super) fn opened(text: &str) -> Option<String> {
    let mut opened: Option<String> = None;
    for option in OPTIONS {
        let text = opened.as_deref().unwrap_or(text);
        let (statement, options) = description(text)?;
        if !options.iter().any(|given| given.name.text == option) {
            opened = Some(with_option(text, &statement, option, "all"));
        }
    }
    opened
}

/// The model with one of its description's numbers as a parameter.
pub(super) fn with_described(text: &str, number: &Described) -> String {
    let Some((statement, options)) = description(text) else {
        return text.to_string();
    };
    let of = written_name(&number.of);
    let given = options.iter().find(|o| o.name.text == number.option);
    let Some(RobotOption { values, .. }) = given else {
        return with_option(text, &statement, number.option, &of);
    };
    let known = |value: &str| value == number.of || value == "all";
    match values.last() {
        Some(last) if !values.iter().any(|value| known(&value.text)) => {
            let (before, after) = text.split_at(last.span.end);
            format!("{before}, {of}{after}")
        }
        _ => text.to_string(),
    }
}

/// The model in which the losses that its description states act in these joints only.
pub(crate) fn with_losses(text: &str, joints: &[String]) -> String {
    let names: Vec<String> = joints.iter().map(|name| written_name(name)).collect();
    match names.is_empty() {
        true => with_choice(text, LOSSES, "ignore"),
        false => with_choice(text, LOSSES, &names.join(", ")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::log::Log;
    use crate::trace::{Ended, Progress, Request, Stage, Verdict, trace};
    use dynamics_codegen::{Library, compile};
    use std::fmt::Write;
    use std::sync::Mutex;

    const ARM: &str = r#"<robot name="arm">
  <link name="base"/>
  <link name="upper"><inertial><origin xyz="0 0 -0.2"/><mass value="1.1"/>
    <inertia ixx="0.01" ixy="0" ixz="0" iyy="0.012" iyz="0" izz="0.002"/></inertial></link>
  <link name="lower"><inertial><origin xyz="0 0 -0.15"/><mass value="0.8"/>
    <inertia ixx="0.006" ixy="0" ixz="0" iyy="0.007" iyz="0" izz="0.002"/></inertial></link>
  <joint name="shoulder" type="continuous"><parent link="base"/><child link="upper"/>
    <axis xyz="0 1 0"/></joint>
  <joint name="elbow" type="continuous"><parent link="upper"/><child link="lower"/>
    <origin xyz="0 0 -0.4"/><axis xyz="0 1 0"/></joint>
</robot>"#;

    /// Torques that swing that arm along two sums of sines, were its upper link `length` long:
    /// the equations of a double pendulum, written out. Positions with rectangular noise.
    fn log(length: f64) -> Log {
        let mut text = String::from("t,q_shoulder,q_elbow,u_shoulder,u_elbow\n");
        let mut random = 7_u64;
        let mut noise = || {
            random = random
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1);
            1e-4 * ((random >> 11) as f64 / (1_u64 << 53) as f64 - 0.5)
        };
        // Position, velocity and acceleration of the sum.
        let along = |t: f64, sines: [(f64, f64); 2]| -> [f64; 3] {
            let sum = |f: &dyn Fn(f64, f64) -> f64| sines.iter().map(|&(a, w)| f(a, w)).sum();
            [
                sum(&|a, w| a * (w * t).sin()),
                sum(&|a, w| a * w * (w * t).cos()),
                sum(&|a, w| -a * w * w * (w * t).sin()),
            ]
        };
        let (m1, c1, i1, m2, c2, i2, g) = (1.1, 0.2, 0.012, 0.8, 0.15, 0.007, 9.81);
        for k in 0..1000 {
            let t = 0.004 * f64::from(k);
            let [q1, v1, a1] = along(t, [(0.8, 3.0), (0.3, 7.1)]);
            let [q2, v2, a2] = along(t, [(0.9, 4.3), (0.2, 9.7)]);
            let coupled = m2 * length * c2 * q2.cos();
            let m11 = i1 + i2 + m1 * c1 * c1 + m2 * (length * length + c2 * c2) + 2.0 * coupled;
            let m22 = i2 + m2 * c2 * c2;
            let m12 = m22 + coupled;
            let h = -m2 * length * c2 * q2.sin();
            let gravity = m2 * c2 * g * (q1 + q2).sin();
            let u1 = m11 * a1
                + m12 * a2
                + h * (2.0 * v1 + v2) * v2
                + (m1 * c1 + m2 * length) * g * q1.sin()
                + gravity;
            let u2 = m12 * a1 + m22 * a2 - h * v1 * v1 + gravity;
            let (q1, q2) = (q1 + noise(), q2 + noise());
            writeln!(text, "{t},{q1},{q2},{u1},{u2}").unwrap();
        }
        Log::from_bytes("arm.csv", text.as_bytes()).unwrap()
    }

    /// What the search looked at, with the terms that were accepted then.
    #[derive(Debug, Default)]
    struct Stages(Mutex<Vec<(Stage, usize)>>);

    impl Progress for Stages {
        fn enter(&self, stage: Stage, found: &[String]) {
            self.0.lock().unwrap().push((stage, found.len()));
        }

        fn notice(&self, _: &str) {}
    }

    /// The log of that arm, whose joints do not rub, and a description that states otherwise.
    #[test]
    fn a_loss_that_does_not_act_is_named() {
        let joints = ARM.split("<axis xyz=\"0 1 0\"/>").collect::<Vec<_>>();
        let stated = [
            "<dynamics damping=\"0.1\"/>",
            "<dynamics friction=\"0.3\"/>",
        ];
        let [base, shoulder, elbow] = joints[..] else {
            panic!("two joints");
        };
        let axis = "<axis xyz=\"0 1 0\"/>";
        let rubbing = [base, stated[0], shoulder, stated[1], elbow];
        let rubbing = rubbing
            .join("")
            .replace("<dynamics", &format!("{axis}<dynamics"));
        let mut library = Library::builtin();
        library.add_file("arm.urdf", "arm.urdf", &rubbing);
        let log = log(0.4);
        let model = "model arm;\n\nurdf \"arm.urdf\" { base: fixed; }\n";
        let outcome = trace(&Request::new("arm", model, &library, &log)).unwrap();
        assert_eq!(outcome.verdict, Verdict::Parameter);
        let mut found: Vec<&str> = Vec::new();
        for finding in &outcome.findings {
            assert_eq!(finding.effect, "parameter", "{finding:?}");
            let (name, loss) = finding.parameters.first_key_value().unwrap();
            assert!(
                (0.0..3.0 * loss.std).contains(&loss.value),
                "{name}: {loss:?}"
            );
            found.push(name);
        }
        found.sort_unstable();
        assert_eq!(found, ["elbow_friction", "shoulder_damping"]);
        let patched = &outcome.patched_model;
        for line in [
            "base: fixed; friction: ",
            "parameter elbow_friction = ",
            "shoulder_damping = ",
        ] {
            assert!(patched.contains(line), "{patched}");
        }
        compile("arm.model", patched, &library).unwrap();
    }

    #[test]
    fn losses_are_open_where_a_description_states_some() {
        let opened = |description: &str, text: &str| {
            let mut library = Library::empty();
            library.add_file("arm.urdf", "arm.urdf", description);
            let model = compile("arm.model", text, &library).unwrap().model;
            with_open_losses(text, &model)
        };
        let rubbing = ARM.replace("</joint>", "<dynamics damping=\"0.1\"/></joint>");
        let text = "model a; urdf \"arm.urdf\";";
        assert_eq!(opened(ARM, text), None);
        assert_eq!(
            opened(&rubbing, text).unwrap(),
            "model a; urdf \"arm.urdf\" { friction: all; }"
        );
        // Those that were found before stay open, and so do the others.
        assert_eq!(
            opened(&rubbing, "model a; urdf \"arm.urdf\" { friction: elbow; }").unwrap(),
            "model a; urdf \"arm.urdf\" { friction: all; }"
        );
        // Who says that none is a parameter means it.
        let given = "model a; urdf \"arm.urdf\" { friction: none; }";
        assert_eq!(opened(&rubbing, given), None);
        let ignored = "model a; urdf \"arm.urdf\" { losses: ignore; }";
        assert_eq!(opened(&rubbing, ignored), None);
        assert_eq!(
            opened(
                &rubbing,
                "model a; coordinate x: m; parameter m: kg = 1; kinetic m*dot(x)^2;"
            ),
            None
        );
    }

    #[test]
    fn a_wrong_length_is_named_and_no_effects_in_its_stead() {
        let mut library = Library::builtin();
        library.add_file("arm.urdf", "arm.urdf", ARM);
        let model = "model arm;\n\nurdf \"arm.urdf\";\n";
        let (log, stages) = (log(0.37), Stages::default());
        let request = Request {
            progress: &stages,
            ..Request::new("arm", model, &library, &log)
        };
        let outcome = trace(&request).unwrap();
        // Many effects take long, and are not asked where one number explains the log.
        let most = |stages: &[(Stage, usize)]| stages.iter().map(|(_, terms)| *terms).max();
        let looked_at = stages.0.lock().unwrap();
        assert!(most(&looked_at) <= Some(2), "{looked_at:?}");
        let findings = &outcome.findings;
        assert_eq!(outcome.verdict, Verdict::Parameter, "{findings:#?}");
        assert_eq!(findings.len(), 1, "{findings:#?}");
        assert_eq!(findings[0].on, ["elbow_origin_z"]);
        let length = &findings[0].parameters["elbow_origin_z"];
        assert!((length.value + 0.37).abs() < 1e-3, "{length:?}");
        let patched = &outcome.patched_model;
        assert!(
            patched.starts_with("model arm;\n\nurdf \"arm.urdf\" { origins: elbow; }\n"),
            "{patched}"
        );
        let compiled = dynamics_codegen::compile("arm", patched, &library).unwrap();
        assert_eq!(compiled.model.parameters.len(), 3);
    }

    /// A search without time. Each begins with fits of the model as given, of which no robot has many to spare.
    #[derive(Debug)]
    struct Over(Stages);

    impl Progress for Over {
        fn enter(&self, stage: Stage, found: &[String]) {
            self.0.enter(stage, found);
        }

        fn notice(&self, _: &str) {}

        fn ended(&self) -> Option<Ended> {
            Some(Ended::TimeLimit)
        }
    }

    #[test]
    fn a_search_that_is_over_is_not_begun_anew() {
        let mut library = Library::builtin();
        library.add_file("arm.urdf", "arm.urdf", ARM);
        let (log, over) = (log(0.37), Over(Stages::default()));
        let request = Request {
            progress: &over,
            ..Request::new("arm", "model arm; urdf \"arm.urdf\";", &library, &log)
        };
        let outcome = trace(&request).unwrap();
        assert_eq!(outcome.unfinished, Some(Ended::TimeLimit));
        let stages = over.0.0.lock().unwrap();
        let fits = stages.iter().filter(|(stage, _)| *stage == Stage::Fit);
        // What inputs carry, and one search.
        assert_eq!(fits.count(), 2, "{stages:?}");
    }

    #[test]
    fn numbers_are_open_unless_the_model_says_which_are() {
        let cases = [
            (
                "model a;\nurdf \"a.urdf\";\n",
                "model a;\nurdf \"a.urdf\" { parameters: all; origins: all; }\n",
            ),
            (
                "model a; urdf \"a.urdf\" { base: fixed } gravity (0, 0, 0);",
                "model a; urdf \"a.urdf\" { base: fixed; parameters: all; origins: all; } gravity (0, 0, 0);",
            ),
            (
                "model a; urdf \"a.urdf\" { parameters: none; }",
                "model a; urdf \"a.urdf\" { parameters: none; origins: all; }",
            ),
        ];
        for (given, expected) in cases {
            assert_eq!(opened(given).as_deref(), Some(expected));
        }
        assert_eq!(opened("model a;"), None);
        assert_eq!(
            opened("model a; urdf \"a.urdf\" { origins: j1; parameters: none; }"),
            None
        );
    }

    #[test]
    fn one_number_opens_its_link_or_joint() {
        let of = |option, of: &str| Described {
            parameter: "any".into(),
            option,
            of: of.into(),
        };
        let rod = with_described("model a; urdf \"a.urdf\";", &of("parameters", "rod"));
        assert_eq!(rod, "model a; urdf \"a.urdf\" { parameters: rod; }");
        assert_eq!(with_described(&rod, &of("parameters", "rod")), rod);
        let both = with_described(&rod, &of("parameters", "hub"));
        assert_eq!(both, "model a; urdf \"a.urdf\" { parameters: rod, hub; }");
        let all = with_described(&both, &of("origins", "j1"));
        assert_eq!(
            all,
            "model a; urdf \"a.urdf\" { parameters: rod, hub; origins: j1; }"
        );
    }
}
