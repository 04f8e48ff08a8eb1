//! What `#[derive(Dynamics)]` makes of a struct.

use dynamics::{Dual, Dynamics, Point, Scalar, System};

#[derive(Dynamics)]
#[dynamics(model = "tests/models/cart.model")]
struct Cart<T> {
    mc: T,
    l: T,
}

/// Everything folded in.
#[derive(Dynamics)]
#[dynamics(model = "tests/models/cart.model")]
struct Fixed;

#[derive(Dynamics)]
#[dynamics(model = "tests/models/cart.model")]
struct Floats {
    l: f32,
    #[dynamics(parameter = "mc")]
    mass_of_the_cart: f64,
}

/// Names that are hard to spell: keywords, letters that no C compiler knows.
#[derive(Dynamics)]
#[dynamics(
    model = "tests/models/everything.model",
    effects = "tests/models/effects"
)]
#[allow(non_snake_case)]
struct Everything<S> {
    r#fn: S,
    I_G: S,
    ψ__2: S,
}

#[derive(Dynamics)]
#[dynamics(model = "tests/models/damped.model", effects = "tests/models/effects")]
struct Damped<T: Copy = f64>
where
    T: PartialEq,
{
    #[dynamics(parameter = "cubic_drag_x_c")]
    drag: T,
}

/// With functions beside the terms.
#[derive(Dynamics)]
#[dynamics(
    model = "tests/models/cart.model",
    functions = "inverse_dynamics, forward_dynamics_derivatives"
)]
struct WithFunctions<T> {
    mc: T,
}

/// A robot description; the mass of the last link, which carries loads, varies.
#[derive(Dynamics)]
#[dynamics(urdf = "tests/models/arm.urdf")]
struct Arm<T> {
    lower_mass: T,
}

/// The same of MuJoCo's format, whose defaults stand in a file that it includes.
#[derive(Dynamics)]
#[dynamics(mjcf = "tests/models/arm.xml")]
struct Mjcf<T> {
    lower_mass: T,
}

/// A model on top of one.
#[derive(Dynamics)]
#[dynamics(model = "tests/models/held.model")]
struct Held;

fn point<T: Scalar>(theta: T) -> Point<T, 2, 1, 0> {
    let number = T::from_f64;
    Point {
        t: number(0.0),
        q: [number(0.2), theta],
        v: [number(-0.4), number(0.7)],
        u: [number(1.5)],
        z: [],
    }
}

/// `M` and `Q` by hand: q = (x, θ), mp = 0.1, g = 9.81.
fn by_hand(mc: f64, l: f64, x: &Point<f64, 2, 1, 0>) -> ([[f64; 2]; 2], [f64; 2]) {
    let (sin, cos) = x.q[1].sin_cos();
    let coupling = 0.1 * l * cos;
    let mass = [[mc + 0.1, coupling], [coupling, 0.1 * l * l]];
    let force = [
        x.u[0] + 0.1 * l * sin * x.v[1] * x.v[1],
        0.1 * 9.81 * l * sin,
    ];
    (mass, force)
}

fn agrees(system: &impl System<f64, 2, 1, 0, 0>, mc: f64, l: f64) {
    let x = point(0.3);
    let (mass, force) = by_hand(mc, l, &x);
    let terms = system.equation(&x);
    for i in 0..2 {
        assert!((terms.force[i] - force[i]).abs() < 1e-14, "{i}");
        for j in 0..2 {
            assert!((terms.mass_matrix[(i, j)] - mass[i][j]).abs() < 1e-15);
        }
    }
}

#[test]
fn equations_have_the_values_of_the_fields() {
    agrees(&Cart { mc: 2.0, l: 0.3 }, 2.0, 0.3);
    agrees(&Fixed, 1.0, 0.5);
    let floats = Floats {
        l: 0.25,
        mass_of_the_cart: 3.0,
    };
    agrees(&floats, 3.0, 0.25);
}

#[test]
fn nominal_values_come_from_the_file() {
    let cart = Cart::<f64>::nominal();
    assert_eq!((cart.mc, cart.l), (1.0, 0.5));
    let floats = Floats::nominal();
    assert_eq!((floats.l, floats.mass_of_the_cart), (0.5_f32, 1.0));
    assert_eq!(Damped::<f64>::nominal().drag, 3.0);
}

#[test]
fn quantities_are_methods_and_sizes_constants() {
    let x = point(0.3);
    let cart = Cart { mc: 2.0, l: 0.3 };
    assert_eq!(cart.input_matrix(&x), [[1.0], [0.0]]);
    assert_eq!(cart.outputs(&x)[0], 0.2 + 0.3 * 0.3_f64.sin());
    assert_eq!(cart.equation_of_motion(&x).mass_matrix[0][0], 2.1);
    assert_eq!(Fixed.input_matrix(&x), [[1.0], [0.0]]);
    assert_eq!(Cart::<f32>::COORDINATES, 2);
    assert_eq!(Fixed::COORDINATE_NAMES, ["x", "theta"]);
    assert_eq!(Cart::<f64>::PARAMETER_NAMES, ["mc", "l"]);
    assert_eq!(Fixed::PARAMETERS, 0);
}

/// Functions on request are methods: `τ = M a − Q` without inputs, and accelerations that it undoes.
#[test]
fn functions_on_request_are_methods() {
    let (cart, x) = (WithFunctions { mc: 2.0 }, point(0.3));
    let (mass, force) = by_hand(2.0, 0.5, &x);
    let a = [0.7, -1.1];
    let torque = cart.inverse_dynamics(&x, &a);
    let own = |i: usize| mass[i][0] * a[0] + mass[i][1] * a[1] - force[i];
    // What moves it beside the input.
    assert!((torque[0] - own(0) - x.u[0]).abs() < 1e-14, "{torque:?}");
    assert!((torque[1] - own(1)).abs() < 1e-14, "{torque:?}");
    let derivatives = cart.forward_dynamics_derivatives(&x);
    let a = derivatives.forward_dynamics;
    for i in 0..2 {
        let left = mass[i][0] * a[0] + mass[i][1] * a[1] - force[i];
        assert!(left.abs() < 1e-13, "{left}");
        let by_input = derivatives.forward_dynamics_by_input;
        let pushed = mass[i][0] * by_input[0][0] + mass[i][1] * by_input[1][0];
        assert!((pushed - [1.0, 0.0][i]).abs() < 1e-14);
    }
}

#[test]
fn dual_numbers_pass_through() {
    let step = 1e-6;
    let at = |theta: f64, l: f64| {
        let cart = Cart { mc: 2.0, l };
        System::<f64, 2, 1, 0, 0>::force(&cart, &point(theta))[1]
    };
    // By a coordinate, through a struct of plain numbers.
    let x = point(Dual::<f64, 1>::variable(0.3, 0));
    let floats = Floats {
        l: 0.25,
        mass_of_the_cart: 2.0,
    };
    let slope = System::<_, 2, 1, 0, 0>::force(&floats, &x)[1];
    let expected = (at(0.3 + step, 0.25) - at(0.3 - step, 0.25)) / (2.0 * step);
    assert!((slope.eps[0] - expected).abs() < 1e-9);
    // By a parameter.
    let cart = Cart {
        mc: Dual::constant(2.0),
        l: Dual::<f64, 1>::variable(0.25, 0),
    };
    let slope = System::<_, 2, 1, 0, 0>::force(&cart, &point(Dual::constant(0.3)))[1];
    let expected = (at(0.3, 0.25 + step) - at(0.3, 0.25 - step)) / (2.0 * step);
    assert!((slope.eps[0] - expected).abs() < 1e-9);
}

#[test]
fn names_are_kept_and_effects_are_ones_own() {
    let everything = Everything::<f64>::nominal();
    assert_eq!(
        (everything.r#fn, everything.I_G, everything.ψ__2),
        (2.0, 0.3, -0.4)
    );
    let x = Point {
        t: 0.0,
        q: [1.0],
        v: [2.0],
        u: [],
        z: [],
    };
    assert_eq!(Damped { drag: 0.5 }.applied_force(&x), [-4.0]);
}

/// A struct inside a function is seen by what is emitted for it.
#[test]
fn structs_of_a_function() {
    #[derive(Dynamics)]
    #[dynamics(model = "tests/models/cart.model")]
    struct Cart {
        mp: f64,
    }
    let x = point(0.3);
    assert_eq!(Cart { mp: 1.0 }.mass_matrix(&x)[(0, 0)], 2.0);
}

/// The textbook's double pendulum: angles from hanging down, the second relative.
#[test]
fn robot_descriptions_are_models() {
    let (l1, c1, c2, m1, m2) = (0.4, 0.2, 0.15, 2.0, 1.5);
    let (i1, i2) = (0.03, 0.01);
    let x = Point {
        t: 0.0,
        q: [0.3, -0.8],
        v: [0.0; 2],
        u: [0.0; 2],
        z: [],
    };
    let (s1, s12) = (x.q[0].sin(), (x.q[0] + x.q[1]).sin());
    let terms = Arm { lower_mass: m2 }.equation(&x);
    let elbow = i2 + m2 * c2 * c2;
    let coupling = elbow + m2 * l1 * c2 * x.q[1].cos();
    let shoulder = i1 + m1 * c1 * c1 + i2 + m2 * (l1 * l1 + c2 * c2 + 2.0 * l1 * c2 * x.q[1].cos());
    let mass = [[shoulder, coupling], [coupling, elbow]];
    let weight = -9.81 * m2 * c2 * s12;
    let force = [weight - 9.81 * (m1 * c1 + m2 * l1) * s1, weight];
    for i in 0..2 {
        assert!(
            (terms.force[i] - force[i]).abs() < 1e-12,
            "{i}: {}",
            terms.force[i]
        );
        for j in 0..2 {
            assert!((terms.mass_matrix[(i, j)] - mass[i][j]).abs() < 1e-14);
        }
    }
    let same = Mjcf { lower_mass: m2 }.equation(&x);
    assert_eq!(same.mass_matrix, terms.mass_matrix);
    assert_eq!(same.force, terms.force);
    assert_eq!(Arm::<f64>::nominal().lower_mass, 1.0);
    assert_eq!(Held.constraint_jacobian(&x), [[0.0, 1.0]]);
}

/// Cargo learns from the compiler which files to watch: those the models were made from.
#[test]
fn a_change_of_the_model_builds_anew() {
    let test = std::env::current_exe().unwrap();
    let watched = std::fs::read_to_string(test.with_extension("d")).unwrap();
    let files = [
        "cart.model",
        "damped.model",
        "cubic_drag.model",
        "held.model",
        "arm.urdf",
        "arm.xml",
        "arm_defaults.xml",
    ];
    for file in files {
        assert!(watched.contains(file), "{file} is not among {watched}");
    }
}
