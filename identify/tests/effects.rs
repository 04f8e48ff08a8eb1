//! Every template of the library: its force by hand, nothing at its defaults, no energy out
//! of friction.

use dynamics_codegen::{Library, compile};
use identify::machine::{Machine, States};

/// Two sliders, a joint, two drives; the sliders' point slides on a hill.
const HOST: &str = "model host;
    coordinate x: m; coordinate z: m; coordinate a: rad; coordinate b: rad;
    input ux: N; input ua: N*m;
    parameter m: kg = 2; parameter j: kg*m^2 = 0.3; constant g: m/s^2 = 9.81;
    constant k: 1/m = 0.4;
    kinetic m/2*(dot(x)^2 + dot(z)^2) + j/2*(dot(a)^2 + dot(b)^2 + dot(a)*dot(b)/2);
    potential m*g*z;
    force x = ux; force a = ua;
    constraint hill: z == k*x^2;";

/// Positions, velocities, inputs and internal states of one place.
#[derive(Debug, Clone)]
struct Place {
    q: [f64; 4],
    v: [f64; 4],
    u: [f64; 2],
    z: Vec<f64>,
}

impl Place {
    /// Fulfils the constraint.
    fn new(x: f64, dx: f64, turn: f64, da: f64, db: f64, u: [f64; 2]) -> Self {
        Self {
            q: [x, 0.4 * x * x, turn, -0.5 * turn],
            v: [dx, 0.8 * x * dx, da, db],
            u,
            z: Vec::new(),
        }
    }

    fn states(&self) -> States {
        let column = |values: &[f64]| values.iter().map(|&x| vec![x]).collect();
        let mut states = States {
            t: vec![0.3],
            q: column(&self.q),
            v: column(&self.v),
            u: column(&self.u),
            ..States::default()
        };
        states.memory.z = column(&self.z);
        states
    }
}

fn places() -> Vec<Place> {
    vec![
        Place::new(0.4, 0.7, 0.2, -0.6, 1.1, [3.0, -0.4]),
        Place::new(-0.8, 0.05, -1.1, 0.3, -0.2, [-1.5, 0.9]),
        Place::new(0.1, -1.3, 0.7, -0.01, 0.4, [0.2, -0.05]),
        Place::new(0.9, -0.4, 2.0, 1.2, 0.8, [-4.0, 1.4]),
    ]
}

fn machine(effects: &str) -> Machine {
    let text = format!("{HOST}\n{effects}");
    let compiled = compile("host.model", &text, &Library::builtin());
    Machine::new(compiled.unwrap_or_else(|report| panic!("{report}")))
}

/// What an effect adds to the forces.
fn added(effect: &str, place: &Place) -> Vec<f64> {
    let force = |effects: &str| {
        let machine = machine(effects);
        let values = machine.nominal_parameters();
        let motion = machine.motion(&place.states(), &values).unwrap();
        motion[0].terms.force.clone()
    };
    (force(effect) - force("")).iter().copied().collect()
}

fn assert_force(effect: &str, by_hand: impl Fn(&Place) -> [f64; 4]) {
    for place in places() {
        let (found, expected) = (added(effect, &place), by_hand(&place));
        for (a, b) in found.iter().zip(expected) {
            assert!(
                (a - b).abs() < 1e-9 * (1.0 + b.abs()),
                "{effect}: {found:?} {expected:?}"
            );
        }
    }
}

#[test]
fn nothing_happens_at_the_defaults() {
    let library = Library::builtin();
    let plain = machine("");
    for name in library.names() {
        let template = library.describe(name).unwrap();
        use dynamics_codegen::syntax::PortKind;
        let mut coordinates = ["a", "b"].into_iter();
        let on: Vec<&str> = template
            .ports
            .iter()
            .map(|port| match port {
                PortKind::Coordinate | PortKind::Reading => coordinates.next().unwrap(),
                PortKind::Coordinates => "x, z",
                PortKind::Input | PortKind::Drive => "ua",
                PortKind::Constraint => "hill",
                PortKind::Body | PortKind::Sensor | PortKind::Frame => "",
            })
            .collect();
        if on.contains(&"") {
            continue; // Of bodies below; of sensors and their frames elsewhere.
        }
        let with = machine(&format!("effect {name}({});", on.join(", ")));
        for place in places() {
            let motion = |machine: &Machine| {
                let values = machine.nominal_parameters();
                machine.motion(&place.states(), &values).unwrap()[0]
                    .acceleration
                    .clone()
            };
            let gap = (motion(&with) - motion(&plain)).amax();
            assert!(gap < 1e-12, "{name}: {gap}");
        }
        assert!(template.doc.contains("In the residual:"), "{name}");
        assert!(template.doc.contains("Confused with:"), "{name}");
    }
}

#[test]
fn joint_forces_are_those_of_the_formulas() {
    assert_force(
        "effect asymmetric_coulomb(a) { f_p = 0.5, f_n = 0.2, v_s = 0.1 }",
        |p| {
            let s = (p.v[2] / 0.1).tanh();
            let height = if p.v[2] > 0.0 { 0.5 } else { 0.2 };
            let smooth = -s * (0.5 * (1.0 + s) + 0.2 * (1.0 - s)) / 2.0;
            assert!(s.abs() < 0.999 || (smooth + height * s.signum()).abs() < 1e-3);
            [0.0, 0.0, smooth, 0.0]
        },
    );
    assert_force("effect cubic_spring(b) { k_3 = 0.7, q_0 = 0.1 }", |p| {
        [0.0, 0.0, 0.0, -0.7 * (p.q[3] - 0.1).powi(3)]
    });
    assert_force("effect cogging(a) { f_s = 0.3, f_c = -0.1, n = 7 }", |p| {
        let phase = 7.0 * p.q[2];
        [0.0, 0.0, 0.3 * phase.sin() - 0.1 * phase.cos(), 0.0]
    });
    assert_force("effect load_friction(a) { mu = 0.3, v_s = 0.1 }", |p| {
        [0.0, 0.0, -0.3 * p.u[1].abs() * (p.v[2] / 0.1).tanh(), 0.0]
    });
    // The load is what arrives, here twice the command and what a spring does is not in it.
    assert_force(
        "effect load_friction(a) { mu = 0.3, v_s = 0.1 } effect input_gain(ua) { gain = 2 }",
        |p| {
            let load = 2.0 * p.u[1];
            [
                0.0,
                0.0,
                p.u[1] - 0.3 * load.abs() * (p.v[2] / 0.1).tanh(),
                0.0,
            ]
        },
    );
    assert_force(
        "effect joint_coupling(a, b) { d = 0.4, f_c = 0.2, v_s = 0.1 }",
        |p| {
            let w = p.v[2] + p.v[3];
            let f = -0.4 * w - 0.2 * (w / 0.1).tanh();
            [0.0, 0.0, f, f]
        },
    );
}

#[test]
fn forces_along_a_velocity_act_on_all_coordinates() {
    assert_force("effect speed_drag(x, z) { c = 0.6 }", |p| {
        let speed = p.v[0].hypot(p.v[1]);
        [-0.6 * speed * p.v[0], -0.6 * speed * p.v[1], 0.0, 0.0]
    });
    assert_force(
        "effect rolling_resistance(x, z) { f = 0.6, v_s = 0.2 }",
        |p| {
            let speed = p.v[0].hypot(p.v[1]);
            let share = -0.6 * (speed / 0.2).tanh() / speed;
            [share * p.v[0], share * p.v[1], 0.0, 0.0]
        },
    );
}

#[test]
fn inertia_is_added_where_it_turns() {
    let mass = |effect: &str| {
        let machine = machine(effect);
        let values = machine.nominal_parameters();
        machine
            .terms(&places()[0].states(), &values)
            .remove(0)
            .mass_matrix
    };
    let armature = mass("effect armature(a) { i = 0.05 }") - mass("");
    assert!((armature[(2, 2)] - 0.05).abs() < 1e-15 && (armature.sum() - 0.05).abs() < 1e-15);
    let coupling = mass("effect joint_coupling(a, b) { i = 0.05 }") - mass("");
    for (i, j) in [(2, 2), (2, 3), (3, 2), (3, 3)] {
        assert!((coupling[(i, j)] - 0.05).abs() < 1e-15);
    }
    assert!((coupling.sum() - 0.2).abs() < 1e-15);
}

#[test]
fn channels_change_what_arrives() {
    let channel = |f: fn(f64) -> f64| move |p: &Place| [0.0, 0.0, f(p.u[1]) - p.u[1], 0.0];
    assert_force(
        "effect dead_band(ua) { w = 0.3 }",
        channel(|u| {
            if u.abs() < 0.3 {
                0.0
            } else {
                u - 0.3 * u.signum()
            }
        }),
    );
    assert_force(
        "effect saturation(ua) { share = 1, limit = 0.5 }",
        channel(|u| u.clamp(-0.5, 0.5)),
    );
    // At the beginning the drive is where it is commanded to be.
    assert_force("effect input_lag(ua) { tau = 0.1 }", channel(|u| u));
    assert_force("effect input_delay(ua) { tau = 0.1 }", channel(|u| u));
    assert_force("effect backlash(ua) { share = 1, w = 0.2 }", channel(|u| u));
}

/// The normal force by Newton's law across the slope.
fn normal_force(p: &Place) -> f64 {
    let slope: f64 = 0.8 * p.q[0];
    let (cos, sin) = (1.0 / slope.hypot(1.0), slope / slope.hypot(1.0));
    let curvature = 0.8 * cos.powi(3);
    let speed2 = p.v[0].powi(2) + p.v[1].powi(2);
    // m v² κ = N − m g cos − ux sin (the normal points up and backwards).
    2.0 * speed2 * curvature + 2.0 * 9.81 * cos + p.u[0] * sin
}

#[test]
fn contact_friction_follows_the_normal_force() {
    assert_force(
        "effect contact_friction(hill) { mu = 0.25, v_s = 0.1 }",
        |p| {
            let speed = p.v[0].hypot(p.v[1]);
            let share = -0.25 * normal_force(p).abs() * (speed / 0.1).tanh() / speed;
            [share * p.v[0], share * p.v[1], 0.0, 0.0]
        },
    );
}

#[test]
fn friction_takes_energy_and_never_gives_any() {
    for effect in [
        "effect asymmetric_coulomb(a) { f_p = 0.5, f_n = 0.2 }",
        "effect load_friction(a) { mu = 0.3 }",
        "effect speed_drag(x, z) { c = 0.6 }",
        "effect rolling_resistance(x, z) { f = 0.6 }",
        "effect joint_coupling(a, b) { d = 0.4, f_c = 0.2 }",
        "effect contact_friction(hill) { mu = 0.25 }",
        "effect viscous(a) { d = 1 }",
        "effect coulomb(b) { f_c = 1 }",
        "effect stribeck(a) { f_c = 1, f_b = 0.5, d = 0.1 }",
        "effect quadratic_drag(b) { c = 1 }",
    ] {
        for place in places() {
            let force = added(effect, &place);
            let power: f64 = force.iter().zip(place.v).map(|(f, v)| f * v).sum();
            assert!(power < 0.0, "{effect}: {power}");
        }
    }
}

#[test]
fn bristles_are_a_spring_before_they_slide() {
    let effect = "effect lugre(a) { f_c = 0.5, d = 0.1, reach = 0.02, rise = 0.4, v_st = 0.3 }";
    for bent in [-0.7, 0.0, 0.9] {
        let machine = machine(effect);
        let values = machine.nominal_parameters();
        for mut place in places() {
            place.z = vec![bent];
            let force = |machine: &Machine, values: &[f64], place: &Place| {
                machine.motion(&place.states(), values).unwrap()[0]
                    .terms
                    .force[2]
            };
            let found = force(&machine, &values, &place) - place.u[1];
            let expected = -0.5 * bent - 0.1 * place.v[2];
            assert!((found - expected).abs() < 1e-12, "{found} {expected}");
        }
    }
}

/// What presses a body into its contact the harder, the harder the contact pushes back:
/// with enough of it there is no motion.
#[test]
fn a_contact_without_a_motion_is_refused() {
    let jam = |mu: f64| {
        let text = format!(
            "model jam; coordinate x: m; coordinate y: m; input u: N;
             parameter m: kg = 1; parameter mu: 1 = {mu};
             kinetic m/2*(dot(x)^2 + dot(y)^2);
             force y = mu*abs(multiplier(wall)) - u;
             constraint wall: y == 0;"
        );
        let machine = Machine::new(compile("jam.model", &text, &Library::empty()).unwrap());
        let states = States {
            t: vec![0.0],
            q: vec![vec![0.0]; 2],
            v: vec![vec![0.0]; 2],
            u: vec![vec![2.0]],
            ..States::default()
        };
        machine.motion(&states, &machine.nominal_parameters())
    };
    // λ + μ|λ| − u = 0 with u = 2: λ = 2/(1 + μ).
    for mu in [0.6, -0.6] {
        let motion = jam(mu).unwrap();
        assert!((motion[0].multiplier[0] - 2.0 / (1.0 + mu)).abs() < 1e-9);
        assert!(motion[0].acceleration[1].abs() < 1e-9);
    }
    for mu in [-1.0, -1.5] {
        let refused = jam(mu).unwrap_err().to_string();
        assert!(refused.contains("do not settle"), "{refused}");
    }
}

/// An arm of two links that swings in a vertical plane, as bodies.
fn arm(upper: &str, lower: &str, gravity: &str, effects: &str) -> Machine {
    let text = format!(
        "model arm; coordinate a: rad; coordinate b: rad;
         body upper {{ frame: rotate_y(a); {upper} }}
         body lower {{ frame: upper * translate(0.5, 0, 0) * rotate_y(b); {lower} }}
         gravity ({gravity});
         {effects}"
    );
    let compiled = compile("arm.model", &text, &Library::builtin());
    Machine::new(compiled.unwrap_or_else(|report| panic!("{report}")))
}

const UPPER: &str = "mass: 2; center: (0.2, 0, 0.1); inertia: diag(0.1, 0.2, 0.3);";
const LOWER: &str = "mass: 1; center: (0.3, 0, 0); inertia: diag(0.01, 0.02, 0.03);";

/// The same accelerations, by statements in place of an effect.
#[test]
fn bodies_carry_shift_and_lean() {
    let states = States {
        t: vec![0.0],
        q: vec![vec![0.4], vec![-1.1]],
        v: vec![vec![0.9], vec![0.3]],
        ..States::default()
    };
    let motion = |machine: Machine| {
        let values = machine.nominal_parameters();
        machine.motion(&states, &values).unwrap()[0]
            .acceleration
            .clone()
    };
    let level = "0, 0, -9.81";
    let plain = motion(arm(UPPER, LOWER, level, ""));
    let same = |effect: &str, other: Machine| {
        let found = motion(arm(UPPER, LOWER, level, effect));
        let expected = motion(other);
        assert!(
            (&found - &expected).amax() < 1e-10,
            "{effect}: {found} {expected}"
        );
        assert!((&found - &plain).amax() > 1e-3, "{effect}");
    };
    for name in ["payload(lower)", "com_offset(upper)", "gravity_tilt()"] {
        let idle = motion(arm(UPPER, LOWER, level, &format!("effect {name};")));
        assert!((idle - &plain).amax() < 1e-12, "{name}");
    }
    // 0.5 kg at (0.4, 0, 0.2): the lower link's centre, mass and moment about y by hand.
    let (m, c, p) = (1.5, [0.5 / 1.5, 0.1 / 1.5], [0.4, 0.2]);
    let square = |x: [f64; 2]| x[0] * x[0] + x[1] * x[1];
    let about = 0.02 + (0.09 - 1.0 * 0.0) + 0.5 * square(p) - m * square(c);
    let carried = format!(
        "mass: {m}; center: ({}, 0, {}); inertia: diag(0.01, {about}, 0.03);",
        c[0], c[1]
    );
    same(
        "effect payload(lower) { m = 0.5, x = 0.4, z = 0.2 }",
        arm(UPPER, &carried, level, ""),
    );
    let moved = UPPER.replace("(0.2, 0, 0.1)", "(0.25, 0, 0.07)");
    same(
        "effect com_offset(upper) { x = 0.05, z = -0.03 }",
        arm(&moved, LOWER, level, ""),
    );
    // 0.1 rad about y turns (0, 0, −9.81) towards −x.
    same(
        "effect gravity_tilt() { phi_y = 0.1 }",
        arm(UPPER, LOWER, "-9.81*sin(0.1), 0, -9.81*cos(0.1)", ""),
    );
}

/// A constraint that is switched off does nothing; switched on, it is as if always there.
#[test]
fn constraints_come_and_go() {
    let model = |constraint: &str| {
        let text = format!(
            "model held; coordinate x: m; coordinate y: m; input closed: 1;
             parameter m: kg = 2; constant g: m/s^2 = 9.81; parameter k: 1/m = 0.3;
             kinetic m/2*(dot(x)^2 + dot(y)^2); potential m*g*y; force x = 3*m*g;
             {constraint}"
        );
        Machine::new(compile("held.model", &text, &Library::builtin()).unwrap())
    };
    let states = |closed: f64| States {
        t: vec![0.0],
        q: vec![vec![0.5], vec![0.075]],
        v: vec![vec![1.0], vec![0.3]],
        u: vec![vec![closed]],
        ..States::default()
    };
    let motion = |machine: &Machine, closed: f64| {
        let values = machine.nominal_parameters();
        machine.motion(&states(closed), &values).unwrap().remove(0)
    };
    let switched = model("constraint rail when closed - 0.5: y == k*x^2;");
    let (on, off) = (motion(&switched, 1.0), motion(&switched, 0.0));
    let always = motion(&model("constraint rail: y == k*x^2;"), 1.0);
    let never = motion(&model(""), 1.0);
    assert_eq!(on.acceleration, always.acceleration);
    assert_eq!(on.multiplier, always.multiplier);
    assert!((&off.acceleration - &never.acceleration).amax() < 1e-12);
    assert_eq!(off.multiplier[0], 0.0);
    assert_eq!(off.terms.constraint_residual[0], 0.0);
    assert!((&on.acceleration - &off.acceleration).amax() > 1.0);
}

/// What sensors show of a motion, and how it follows their faults.
#[test]
fn sensors_read_beside_the_motion() {
    use dynamics_codegen::derive::Variable;
    let mut machine = machine(
        "effect measurement_scale(a) { scale = 1.1 } effect measurement_offset(a) { offset = 0.3 }
         effect time_shift(b) { tau = 0.02 }",
    );
    let values = machine.nominal_parameters();
    let names: Vec<String> = machine
        .compiled
        .model
        .parameters
        .iter()
        .map(|p| p.name.clone())
        .collect();
    let by = |name: &str| names.iter().position(|n| n == name).unwrap();
    let variables = [
        Variable::Parameter(by("measurement_scale_a_scale")),
        Variable::Parameter(by("measurement_offset_a_offset")),
        Variable::Parameter(by("time_shift_b_tau")),
    ];
    let sensors = machine.sensors(&variables);
    assert!(machine.has_sensor_errors());
    for place in places() {
        let a = [0.7, -0.2, 1.3, -2.0].map(|a| vec![a]);
        let read = sensors.read(&place.states(), &a, &values);
        let (q, v) = (&place.q, &place.v);
        // A sample alone is read at its Taylor series.
        let (earlier, rate) = (
            q[3] - 0.02 * v[3] - 0.5 * 0.02 * 0.02 * 2.0,
            v[3] + 0.02 * 2.0,
        );
        let expected_q = [q[0], q[1], 1.1 * q[2] + 0.3, earlier];
        let expected_v = [v[0], v[1], 1.1 * v[2], rate];
        for i in 0..4 {
            assert!((read.q[i][0] - expected_q[i]).abs() < 1e-12);
            assert!((read.v[i][0] - expected_v[i]).abs() < 1e-12);
        }
        assert!(
            (read.q_by[0][2][0] - q[2]).abs() < 1e-12 && (read.v_by[0][2][0] - v[2]).abs() < 1e-12
        );
        assert!((read.q_by[1][2][0] - 1.0).abs() < 1e-12 && read.v_by[1][2][0] == 0.0);
        assert!(
            (read.q_by[2][3][0] + rate).abs() < 1e-12 && (read.v_by[2][3][0] - 2.0).abs() < 1e-12
        );
    }
}
