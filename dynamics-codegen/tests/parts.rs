//! A mechanism that is written once and used several times is what it would be written out.

use dynamics_codegen::{Compiled, Library, compile, compile_keeping, emit};
use dynamics_codegen::{Variables, graph::ExprId};

const DELTA: &str = include_str!("../../models/delta.model");
const WRITTEN_OUT: &str = include_str!("data/delta_written_out.model");

fn compiled(text: &str) -> Compiled {
    let compiled = compile("m.model", text, &Library::builtin());
    let compiled = compiled.unwrap_or_else(|report| panic!("{report}"));
    let said = compiled.warnings.render();
    assert!(said.is_empty(), "{said}");
    compiled
}

/// `M`, bias force, `Q`, `A` and `b` at a state that is drawn from `seed`.
fn terms(compiled: &Compiled, seed: usize) -> Vec<Vec<f64>> {
    let (model, system) = (&compiled.model, &compiled.system);
    let mut symbols = vec![0.0; model.graph.symbol_count()];
    let draw = |name: &str| {
        let sum: usize = name.bytes().map(usize::from).sum();
        (1.3 * (sum + 17 * seed) as f64 + name.len() as f64).sin()
    };
    for c in &model.coordinates {
        symbols[c.position.index()] = draw(&c.name);
        symbols[c.velocity.index()] = 2.0 * draw(&format!("v{}", c.name));
    }
    for u in &model.inputs {
        symbols[u.symbol.index()] = draw(&format!("u{}", u.name));
    }
    for p in &model.parameters {
        symbols[p.symbol.index()] = p.nominal * (1.0 + 0.2 * draw(&p.name));
    }
    let of = |entries: &[ExprId]| model.graph.evaluate(entries, &symbols);
    vec![
        of(&system.mass_matrix.concat()),
        of(&system.bias_force),
        of(&system.force),
        of(&system.constraint_matrix.concat()),
        of(&system.constraint_bias),
    ]
}

#[test]
fn a_delta_robot_is_a_page() {
    assert!(DELTA.lines().count() <= 40);
    let (parts, written) = (compiled(DELTA), compiled(WRITTEN_OUT));
    let names = |compiled: &Compiled| -> Vec<String> {
        let model = &compiled.model;
        let coordinates = model.coordinates.iter().map(|c| c.name.clone());
        let inputs = model.inputs.iter().map(|u| u.name.clone());
        let constraints = model.constraints.iter().map(|c| c.name.clone());
        coordinates.chain(inputs).chain(constraints).collect()
    };
    assert_eq!(names(&parts), names(&written));
    assert_eq!(names(&parts)[3], "front_q");
    for seed in 0..20 {
        for (found, expected) in terms(&parts, seed).iter().zip(terms(&written, seed)) {
            let scale = expected.iter().fold(1.0_f64, |l, x| l.max(x.abs()));
            for (f, e) in found.iter().zip(&expected) {
                assert!((f - e).abs() <= 1e-12 * scale, "{f} {e}");
            }
        }
    }
}

/// Parameters that the model states are shared, those of the part are own to each use; a part
/// may use parts, and what is in a use is reached by its path.
const LEGGED: &str = "
model legged;
coordinate x: m;
parameter m: kg = 2;
parameter grip: N*m = 5 in 0..;
kinetic m/2*dot(x)^2;
part knee(above) {
    coordinate q: rad;
    parameter m: kg = 0.5 in 0.1..;
    body shin { frame: above * rotate_y(q); mass: m; center: (0, 0, -0.1); }
    effect viscous(q) { d = 0.1 }
    force q = -grip*q;
}
part leg(hip, side) {
    input lift: N*m;
    use knee = knee(hip * translate(0, side*0.1, 0)) { m = 0.25 * 2 }
    force knee.q = lift;
    frame foot = knee.shin * translate(0, 0, -0.3);
}
frame trunk = translate(x, 0, 1);
/// The one that limps.
use left = leg(trunk, 1) { knee.m = 0.75; knee.viscous_q_d = 0.3 }
use right = leg(trunk, -1);
input left.lift = 0.9*left.lift;
constraint together: left.knee.q == right.knee.q;
output stride = position(left.foot).x - position(right.foot).x;
effect spring(right.knee.q) { k = 2 }
force x = -left.knee.m*dot(x)*0.1;
";

#[test]
fn names_lead_into_uses() {
    let text = LEGGED.replace("*dot(x)*0.1", "*dot(x)/slow");
    let text = format!("{text}parameter slow: s = 1;");
    let model = compiled(&text).model;
    let value = |name: &str| {
        let found = model.parameters.iter().find(|p| p.name == name);
        found.unwrap_or_else(|| panic!("no {name}")).nominal
    };
    assert_eq!(value("left_knee_m"), 0.75);
    assert_eq!(value("right_knee_m"), 0.5);
    assert_eq!(value("viscous_left_knee_q_d"), 0.3);
    assert_eq!(value("viscous_right_knee_q_d"), 0.1);
    assert_eq!(value("spring_right_knee_q_k"), 2.0);
    assert_eq!(
        model
            .parameters
            .iter()
            .filter(|p| p.name.contains("grip"))
            .count(),
        1
    );
    let coordinates: Vec<&str> = model.coordinates.iter().map(|c| c.name.as_str()).collect();
    assert_eq!(coordinates, ["x", "left_knee_q", "right_knee_q"]);
    let uses: Vec<(&str, &str)> = (model.uses.iter())
        .map(|used| (used.name.as_str(), used.arguments.as_str()))
        .collect();
    let inner = "(hip * translate(0, side*0.1, 0))";
    let all = [
        ("left", "(trunk, 1)"),
        ("left_knee", inner),
        ("right", "(trunk, -1)"),
        ("right_knee", inner),
    ];
    assert_eq!(uses, all);
}

/// A board of sensors that is in two places: what its sensors read wrongly, and where they are in truth,
/// stands in the part, or beside its use by a path.
const BOARDS: &str = "
model boards;
coordinate a: rad;
parameter m: kg = 2;
part board(of) {
    parameter zero: rad/s = 0.1;
    parameter askew: rad = 0.02;
    frame chip = of * translate(0.3, 0, 0);
    sensor gyro: rad/s = gyroscope(chip);
    sensor felt: m/s^2 = accelerometer(chip) { rate: 50; }
    measured gyro_z = gyro_z + zero;
    mounted chip = chip * rotate_y(askew);
}
body arm { frame: rotate_z(a); mass: m; center: (0.2, 0, 0); }
gravity (0, -9.81, 0);
use near = board(arm);
use far = board(arm * translate(1, 0, 0)) { zero = 0.3 }
parameter bias: m/s^2 = 0.5;
measured far.felt_x = far.felt_x + bias;
";

const BOARDS_WRITTEN_OUT: &str = "
model boards;
coordinate a: rad;
parameter m: kg = 2;
body arm { frame: rotate_z(a); mass: m; center: (0.2, 0, 0); }
gravity (0, -9.81, 0);
parameter near_zero: rad/s = 0.1;
parameter near_askew: rad = 0.02;
frame near_chip = arm * translate(0.3, 0, 0);
sensor near_gyro: rad/s = gyroscope(near_chip);
sensor near_felt: m/s^2 = accelerometer(near_chip) { rate: 50; }
measured near_gyro_z = near_gyro_z + near_zero;
mounted near_chip = near_chip * rotate_y(near_askew);
parameter far_zero: rad/s = 0.3;
parameter far_askew: rad = 0.02;
frame far_chip = arm * translate(1.3, 0, 0);
sensor far_gyro: rad/s = gyroscope(far_chip);
sensor far_felt: m/s^2 = accelerometer(far_chip) { rate: 50; }
measured far_gyro_z = far_gyro_z + far_zero;
mounted far_chip = far_chip * rotate_y(far_askew);
parameter bias: m/s^2 = 0.5;
measured far_felt_x = far_felt_x + bias;
";

#[test]
fn sensors_of_uses_err_as_they_say() {
    let shown = |text: &str| -> Vec<(String, Option<f64>, f64)> {
        let Compiled { model, system, .. } = compiled(text);
        let mut symbols = vec![0.0; model.graph.symbol_count()];
        symbols[model.coordinates[0].position.index()] = 0.7;
        symbols[model.coordinates[0].velocity.index()] = 1.9;
        symbols[model.accelerations[0].index()] = -2.3;
        for p in &model.parameters {
            symbols[p.symbol.index()] = p.nominal;
        }
        let of = |value| model.graph.evaluate(&[value], &symbols)[0];
        let sensors = model.sensors.iter().zip(&system.sensors);
        sensors
            .map(|(s, &value)| (s.name.clone(), s.rate, of(value)))
            .collect()
    };
    let (found, expected) = (shown(BOARDS), shown(BOARDS_WRITTEN_OUT));
    assert_eq!(found.len(), 12);
    for (found, expected) in found.iter().zip(&expected) {
        assert_eq!((&found.0, found.1), (&expected.0, expected.1));
        assert!(
            (found.2 - expected.2).abs() < 1e-12,
            "{found:?} {expected:?}"
        );
    }
    // `ω = 1.9`, seen askew, and the zero of the use.
    let gyro = found
        .iter()
        .find(|(name, ..)| name == "far_gyro_z")
        .unwrap();
    let turned = 1.9 * 0.02_f64.cos() + 0.3;
    assert!((gyro.2 - turned).abs() < 1e-12, "{gyro:?} {turned}");
}

/// Parameters of uses are kept variable or folded in by their names like any others.
#[test]
fn parameters_of_uses_may_be_folded() {
    let variables = Variables::only(["left_knee_m"]);
    let text = LEGGED.replace("*dot(x)*0.1", "*dot(x)/slow");
    let text = format!("{text}parameter slow: s = 1;");
    let compiled = compile_keeping("m.model", &text, &Library::builtin(), &variables).unwrap();
    assert_eq!(compiled.model.parameters.len(), 1);
    assert!(emit::rust(&compiled, "m.model").contains("left_knee_m"));
}

/// Twenty parts, each with two uses of the next, would be a million statements.
#[test]
fn what_grows_beyond_measure_is_refused() {
    let mut text =
        "model m;\ncoordinate x: m;\nkinetic dot(x)^2/2*heavy;\nconstant heavy: kg = 1;\n"
            .to_string();
    for level in 0..20 {
        let next = level + 1;
        text += &format!("part p{level}() {{ use a = p{next}(); use b = p{next}(); }}\n");
    }
    text += "part p20() { parameter k: kg = 1; let twice = 2*k; }\nuse all = p0();\n";
    let report = compile("m.model", &text, &Library::empty()).unwrap_err();
    let said = report.render();
    assert!(
        said.contains("the model is larger than a model may be"),
        "{said}"
    );
}
