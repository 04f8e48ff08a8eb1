//! What a user reads when frames, bodies or a robot description are wrong.

use dynamics_codegen::{Library, Variables, compile, compile_keeping};
use std::collections::BTreeSet;
use std::fmt::Write;

const HEAD: &str = "\
model arm;
coordinate phi: rad;
input motor: N*m;
parameter m: kg = 1;
parameter l: m = 0.5;
body link { frame: rotate_z(phi); mass: m; center: (l, 0, 0); }
force phi = motor;
";

const ROBOT: &str = r#"<robot name="lever">
  <link name="base"/>
  <link name="lever">
    <inertial>
      <origin xyz="0.1 0 0"/>
      <mass value="2"/>
      <inertia ixx="0.01" ixy="0" ixz="0" iyy="0.01" iyz="0" izz="0.01"/>
    </inertial>
  </link>
  <joint name="hinge" type="revolute">
    <parent link="base"/>
    <child link="lever"/>
    <axis xyz="0 1 0"/>
    <limit lower="-1" upper="1" effort="10" velocity="1"/>
    <dynamics damping="0.3" friction="0.1"/>
  </joint>
</robot>
"#;

/// Two links that hang in a row.
const ARM: &str = r#"<robot name="arm">
  <link name="base"/>
  <link name="upper"><inertial><origin xyz="0 0 -0.2"/><mass value="1"/>
    <inertia ixx="0.01" ixy="0" ixz="0" iyy="0.01" iyz="0" izz="0.01"/></inertial></link>
  <link name="lower"><inertial><origin xyz="0 0 -0.1"/><mass value="2"/>
    <inertia ixx="0.01" ixy="0" ixz="0" iyy="0.01" iyz="0" izz="0.01"/></inertial></link>
  <joint name="shoulder" type="continuous"><parent link="base"/><child link="upper"/>
    <axis xyz="0 1 0"/></joint>
  <joint name="elbow" type="continuous"><parent link="upper"/><child link="lower"/>
    <origin xyz="0 0 -0.4"/><axis xyz="0 1 0"/></joint>
</robot>"#;

/// A single body.
const BRICK: &str = r#"<robot name="brick">
  <link name="brick"><inertial><mass value="1"/>
    <inertia ixx="0.01" ixy="0" ixz="0" iyy="0.01" iyz="0" izz="0.01"/></inertial></link>
</robot>"#;

fn library() -> Library {
    let mut library = Library::builtin();
    library.add_file("lever.urdf", "robots/lever.urdf", ROBOT);
    library.add_file("arm.urdf", "robots/arm.urdf", ARM);
    library.add_file("brick.urdf", "robots/brick.urdf", BRICK);
    library
}

fn read_aloud(head: &str, cases: &[(&str, &str)]) -> String {
    let mut page = String::new();
    for (title, addition) in cases {
        let text = format!("{head}{addition}\n");
        match compile("arm.model", &text, &library()) {
            Ok(_) => panic!("this compiles:\n{text}"),
            Err(report) => write!(page, "── {title}\n{report}\n\n").unwrap(),
        }
    }
    page
}

#[test]
fn frames() {
    insta::assert_snapshot!(read_aloud(
        HEAD,
        &[
            ("unknown transform", "frame a = rotate_w(phi);"),
            ("too few arguments", "frame a = translate(1, 2);"),
            ("an angle in metres", "frame a = rotate_x(l);"),
            ("a quotient", "frame a = link / rotate_x(1);"),
            (
                "a frame behind a transform",
                "frame a = rotate_x(1) * link;"
            ),
            ("a number", "frame a = 2;"),
            ("unknown frame", "frame a = lnk * rotate_x(1);"),
            (
                "a circle",
                "frame a = b * rotate_x(1); frame b = a * rotate_y(1);"
            ),
            ("the world", "frame world = link;"),
            ("defined twice", "frame link = rotate_x(1);"),
            ("a velocity", "frame a = translate(l*dot(phi), 0, 0);"),
            (
                "another frame's place",
                "frame a = translate(position(link).x, 0, 0);"
            ),
            ("unknown component", "let a = position(link).w;"),
            ("a vector as a number", "let a = position(link)*2;"),
            ("components of a number", "let a = l.x;"),
            (
                "two frames too many",
                "let a = velocity(link, world, world).x;"
            ),
            ("not a frame", "let a = position(l + 1).x;"),
            ("an acceleration", "let a = dot(velocity(link).x);"),
            (
                "energy of a moving frame",
                "potential m*velocity(link).x*9.81*1;"
            ),
        ]
    ));
}

#[test]
fn bodies() {
    insta::assert_snapshot!(read_aloud(
        HEAD,
        &[
            ("no frame", "body a { mass: 1; }"),
            ("no brace", "body a;"),
            ("unknown entry", "body a { frame: link; weight: 2; }"),
            ("given twice", "body a { frame: link; mass: 1; mass: 2; }"),
            ("a negative mass", "body a { frame: link; mass: -1; }"),
            ("a mass that moves", "body a { frame: link; mass: m*phi; }"),
            ("mass in metres", "body a { frame: link; mass: l; }"),
            ("no tensor", "body a { frame: link; inertia: 3; }"),
            (
                "entries of a tensor",
                "body a { frame: link; inertia: diag(1, 2); }"
            ),
            (
                "a negative moment",
                "body a { frame: link; inertia: diag(1, 2, -3); }"
            ),
            (
                "centre of two numbers",
                "body a { frame: link; center: (1, 2); }"
            ),
            ("gravity that moves", "gravity (0, 0, 9.81*phi);"),
            (
                "gravity in newtons",
                "parameter w: N = 1; gravity (0, 0, w);"
            ),
            ("force at nothing", "force at(tip) = (1, 0, 0);"),
            ("force along nothing", "force at(link) in tip = (1, 0, 0);"),
            ("torque without a place", "torque phi = 1;"),
            ("force in kilograms", "force at(link) = (m, 0, 0);"),
            ("mass of nothing", "let a = mass(tip);"),
            ("a body without effect", "effect viscous(link);"),
        ]
    ));
}

#[test]
fn robot_descriptions() {
    insta::assert_snapshot!(read_aloud(
        "model arm;\n",
        &[
            ("no file", "urdf \"missing.urdf\";"),
            ("no text", "urdf lever;"),
            ("two of them", "urdf \"lever.urdf\"; urdf \"lever.urdf\";"),
            ("nothing that moves", "urdf \"brick.urdf\";"),
            ("unknown option", "urdf \"lever.urdf\" { bases: floating; }"),
            ("unknown base", "urdf \"lever.urdf\" { base: flying; }"),
            ("unknown link", "urdf \"lever.urdf\" { parameters: levr; }"),
            ("unknown origin", "urdf \"lever.urdf\" { origins: hing; }"),
            (
                "friction of an unknown joint",
                "urdf \"lever.urdf\" { friction: hing; }"
            ),
            (
                "a taken name",
                "urdf \"lever.urdf\"; coordinate hinge: rad;"
            ),
            (
                "unknown joint",
                "urdf \"lever.urdf\"; effect viscous(hing);"
            ),
            (
                "a link that weighs less than nothing",
                "urdf \"lever.urdf\" { parameters: all; } parameter lever_mass = -1;"
            ),
            (
                "a mass stated twice",
                "urdf \"lever.urdf\" { parameters: all; } parameter lever_mass = 1; parameter lever_mass = 2;"
            ),
        ]
    ));
}

/// What the message about a body that does not move asks for is a machine.
#[test]
fn a_single_body_floats() {
    let said = compile("brick.urdf", BRICK, &library()).unwrap_err();
    insta::assert_snapshot!(said);
    let text = "model free;\nurdf \"brick.urdf\" { base: floating; }";
    let compiled = compile("free.model", text, &library()).unwrap();
    assert_eq!(compiled.model.coordinates.len(), 7);
}

/// A robot description says more than the model asks for; what it says counts.
#[test]
fn losses_act_unless_they_are_ignored() {
    let force = |text: &str| {
        let compiled = compile("arm.model", text, &library()).unwrap();
        let applied = compiled.system.applied_force[0];
        let graph = &compiled.model.graph;
        // t, q, v, u
        let velocity = compiled.model.coordinates[0].velocity;
        let mut values = vec![0.0; graph.symbol_count()];
        values[velocity.index()] = 2.0;
        graph.evaluate(&[applied], &values)[0]
    };
    let acting = force("model arm; urdf \"lever.urdf\";");
    assert!((acting + 0.3 * 2.0 + 0.1).abs() < 1e-12, "{acting}");
    let ignored = force("model arm; urdf \"lever.urdf\" { losses: ignore }");
    assert_eq!(ignored, 0.0);
}

/// The drive of a described joint is a load as any other.
#[test]
fn friction_grows_with_the_load_of_a_described_joint() {
    let text = "model arm; urdf \"lever.urdf\" { losses: ignore } \
                effect load_friction(hinge) { mu = 0.2, v_s = 0.01 }";
    let compiled = compile("arm.model", text, &library()).unwrap();
    let graph = &compiled.model.graph;
    let mut values = vec![0.0; graph.symbol_count()];
    for parameter in &compiled.model.parameters {
        values[parameter.symbol.index()] = parameter.nominal;
    }
    values[compiled.model.coordinates[0].velocity.index()] = 1.0;
    let mut under = |input: f64| {
        values[compiled.model.inputs[0].symbol.index()] = input;
        graph.evaluate(&[compiled.system.force[0]], &values)[0]
    };
    let force = under(-3.0) - under(0.0);
    assert!((force - (-3.0 - 0.2 * 3.0)).abs() < 1e-12, "{force}");
}

/// `parameters: …` frees the inertia of a link, at the values of the file.
#[test]
fn inertia_becomes_parameters() {
    let text = "model arm; urdf \"lever.urdf\" { parameters: all }";
    let compiled = compile("arm.model", text, &library()).unwrap();
    let names: Vec<(&str, f64)> = (compiled.model.parameters.iter())
        .map(|p| (p.name.as_str(), p.nominal))
        .collect();
    assert_eq!(names.len(), 10);
    assert_eq!(names[..2], [("lever_mass", 2.0), ("lever_cx", 0.1)]);
}

/// A model may say another mass than the description, also where parameters are folded in.
#[test]
fn a_description_is_corrected_by_the_model() {
    let text = "model arm; urdf \"lever.urdf\" { parameters: all } parameter lever_mass = 3;";
    for variables in [Variables::All, Variables::Only(BTreeSet::new())] {
        let compiled = compile_keeping("arm.model", text, &library(), &variables).unwrap();
        let graph = &compiled.model.graph;
        let mut values = vec![0.0; graph.symbol_count()];
        for parameter in &compiled.model.parameters {
            values[parameter.symbol.index()] = parameter.nominal;
        }
        let inertia = graph.evaluate(&[compiled.system.mass_matrix[0][0]], &values)[0];
        // Iyy about the centre and the mass off the axis, m cx².
        assert!((inertia - 0.01 - 3.0 * 0.01).abs() < 1e-12, "{inertia}");
    }
}

/// `origins: …` frees where joints stand: `all` the lengths that the description has, a joint's
/// name all of its.
#[test]
fn origins_become_parameters() {
    let names = |origins: &str| -> Vec<(String, f64)> {
        let text = format!("model arm; urdf \"arm.urdf\" {{ origins: {origins} }}");
        let compiled = compile("arm.model", &text, &library()).unwrap();
        let parameters = compiled.model.parameters.iter();
        parameters.map(|p| (p.name.clone(), p.nominal)).collect()
    };
    assert_eq!(names("none"), []);
    assert_eq!(names("all"), [("elbow_origin_z".to_string(), -0.4)]);
    let [x, y, z] = ["x", "y", "z"].map(|axis| format!("elbow_origin_{axis}"));
    assert_eq!(names("elbow"), [(x, 0.0), (y, 0.0), (z, -0.4)]);
}

/// A length stated anew moves all that hangs on it.
#[test]
fn a_length_is_corrected_by_the_model() {
    let inertia = |text: &str| {
        let compiled = compile("arm.model", text, &library()).unwrap();
        let graph = &compiled.model.graph;
        let mut values = vec![0.0; graph.symbol_count()];
        for parameter in &compiled.model.parameters {
            values[parameter.symbol.index()] = parameter.nominal;
        }
        graph.evaluate(&[compiled.system.mass_matrix[0][0]], &values)[0]
    };
    let given = inertia("model arm; urdf \"arm.urdf\";");
    let longer =
        inertia("model arm; urdf \"arm.urdf\" { origins: all; } parameter elbow_origin_z = -0.5;");
    // The lower link stretched: its mass at 0.4 + 0.1 and at 0.5 + 0.1 from the shoulder.
    let expected = 2.0 * (0.6_f64.powi(2) - 0.5_f64.powi(2));
    assert!(
        (longer - given - expected).abs() < 1e-12,
        "{longer} {given}"
    );
}

/// A joint that turns and rubs, one that slides, and one of which nothing is stated.
const RUBBING: &str = r#"<robot name="rubbing"><link name="base"/>
  <link name="a"><inertial><mass value="1"/>
    <inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial></link>
  <link name="b"><inertial><mass value="1"/>
    <inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial></link>
  <link name="c"><inertial><mass value="1"/>
    <inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial></link>
  <joint name="turn" type="continuous"><parent link="base"/><child link="a"/><axis xyz="0 0 1"/>
    <dynamics damping="0.5" friction="0.2"/></joint>
  <joint name="slide" type="prismatic"><parent link="a"/><child link="b"/><axis xyz="0 0 1"/>
    <limit lower="-1" upper="1" effort="1" velocity="1"/><dynamics damping="3"/></joint>
  <joint name="free" type="continuous"><parent link="b"/><child link="c"/><axis xyz="0 0 1"/></joint>
</robot>"#;

/// `friction: …` frees what the description states of losses, where these act.
#[test]
fn losses_become_parameters() {
    let mut library = Library::empty();
    library.add_file("rubbing.urdf", "rubbing.urdf", RUBBING);
    let compiled = |rest: &str| {
        let text = format!("model arm; urdf \"rubbing.urdf\" {rest}");
        compile("arm.model", &text, &library).unwrap()
    };
    let parameters = |options: &str| -> Vec<(String, f64, String)> {
        let model = compiled(&format!("{{ {options} }}")).model;
        let each = model.parameters.into_iter();
        each.map(|p| (p.name, p.nominal, p.unit)).collect()
    };
    let named = |name: &str, value: f64, unit: &str| (name.to_string(), value, unit.to_string());
    let turn = [
        named("turn_damping", 0.5, "N*m*s"),
        named("turn_friction", 0.2, "N*m"),
    ];
    let slide = named("slide_damping", 3.0, "N*s/m");
    assert_eq!(parameters("friction: none"), []);
    assert_eq!(parameters("friction: turn"), turn);
    assert_eq!(
        parameters("friction: all"),
        [&turn[..], std::slice::from_ref(&slide)].concat()
    );
    assert_eq!(parameters("friction: all; losses: slide"), [slide]);
    assert_eq!(parameters("friction: free"), []);

    // Stated anew, it is what acts, and what is known to.
    let model = compiled("{ friction: turn } parameter turn_damping = 0.1;").model;
    let losses = &model.robot.as_ref().unwrap().losses;
    assert_eq!((losses[0].damping, losses[0].friction), (0.1, 0.2));
    assert_eq!((losses[1].damping, losses[1].friction), (3.0, 0.0));
    let mut values = vec![0.0; model.graph.symbol_count()];
    for parameter in &model.parameters {
        values[parameter.symbol.index()] = parameter.nominal;
    }
    values[model.coordinates[0].velocity.index()] = 2.0;
    let power = model.graph.evaluate(&[model.dissipation], &values)[0];
    assert!((power - 0.5 * 0.1 * 4.0).abs() < 1e-12, "{power}");
}

/// A chain of ten thousand links is refused in good order.
#[test]
fn a_very_long_chain_is_refused() {
    let mut text = String::from("<robot name=\"chain\"><link name=\"l0\"/>");
    for i in 1..=10_000 {
        write!(
            text,
            "<link name=\"l{i}\"><inertial><mass value=\"1\"/><inertia ixx=\"1\" ixy=\"0\" ixz=\"0\" \
             iyy=\"1\" iyz=\"0\" izz=\"1\"/></inertial></link><joint name=\"j{i}\" type=\"continuous\">\
             <parent link=\"l{}\"/><child link=\"l{i}\"/><axis xyz=\"0 0 1\"/></joint>",
            i - 1
        )
        .unwrap();
    }
    text.push_str("</robot>");
    let report = compile("chain.urdf", &text, &Library::empty()).expect_err("too long");
    let said = report.to_string();
    assert!(
        said.contains("10000 moving joints; a model may have 256"),
        "{said}"
    );
}

/// A robot description by itself is all that its author knows of: no finding points
/// elsewhere.
#[test]
fn findings_about_a_robot_alone_point_into_it() {
    let stiff = "<?xml version=\"1.0\"?>\n<robot name=\"post\">\n<link name=\"l0\"/>\n</robot>\n";
    let wobbly = "<robot name=\"arm\"><link name=\"a\"/><link name=\"b\"/><joint name=\"j\" \
        type=\"continuous\"><parent link=\"a\"/><child link=\"b\"/><axis xyz=\"0 0 1\"/></joint></robot>";
    for (text, place) in [(stiff, "post.urdf:2:1"), (wobbly, "post.urdf:1:64")] {
        let said = match compile("post.urdf", text, &Library::empty()) {
            Ok(compiled) => compiled.warnings.render(),
            Err(report) => report.to_string(),
        };
        println!("{said}");
        assert!(said.contains(place), "{said}");
        assert!(!said.contains("robot.urdf"), "{said}");
    }
}

/// Frames may lean on each other in any order, but not without end.
#[test]
fn a_very_long_chain_of_frames_is_refused() {
    let mut text = String::from(HEAD);
    for i in 0..5_000 {
        writeln!(text, "frame f{i} = f{} * rotate_x(0.1);", i + 1).unwrap();
    }
    text.push_str("frame f5000 = link;");
    let report = compile("arm.model", &text, &library()).expect_err("too deep");
    assert!(report.to_string().contains("deep"));
}

/// Valid, but `M` is singular: it compiles, and says so where it is evaluated.
#[test]
fn a_robot_without_mass_compiles() {
    let text = "model m; coordinate a: rad; body b { frame: rotate_z(a); }";
    let compiled = compile("m.model", text, &Library::empty()).unwrap();
    assert!(
        compiled
            .model
            .graph
            .is_zero(compiled.system.mass_matrix[0][0])
    );
}
