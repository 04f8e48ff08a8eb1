//! Tape, generated Rust, and its evaluation on `f32` and on dual numbers give the same
//! numbers for every model.

use dynamics::{Dual, Point, Scalar, System as _};
use dynamics_codegen::emit::{self, Quantity, quantities};
use dynamics_codegen::{Compiled, Tape};
use integration_tests::{models, random};

/// And of one with contacts.
#[path = "fixtures/touching.rs"]
pub mod contacts;
/// The generated module of a model that has everything.
#[path = "fixtures/type__.rs"]
pub mod fixture;

const STATES: usize = 60;
/// Relative to the largest entry of the quantity.
const TOLERANCE: f64 = 1e-12;

/// The entries of a vector or matrix, row by row.
trait Flat<T> {
    fn flat(self) -> Vec<T>;
}

impl<T, const N: usize> Flat<T> for [T; N]
where
    T: Scalar,
{
    fn flat(self) -> Vec<T> {
        self.to_vec()
    }
}

impl<T, const N: usize, const M: usize> Flat<T> for [[T; N]; M]
where
    T: Scalar,
{
    fn flat(self) -> Vec<T> {
        self.concat()
    }
}

/// A model's truth: the tape of each quantity, and of its derivatives.
struct Reference {
    compiled: Compiled,
    quantities: Vec<Quantity>,
    values: Vec<Tape>,
    /// Per quantity, per argument: its partial derivatives.
    derivatives: Vec<Vec<Tape>>,
}

impl Reference {
    fn new(mut compiled: Compiled) -> Self {
        let quantities = quantities(&compiled);
        let arguments = emit::arguments(&compiled.model);
        let graph = &mut compiled.model.graph;
        let (mut values, mut derivatives) = (Vec::new(), Vec::new());
        for quantity in &quantities {
            values.push(Tape::new(graph, &quantity.entries, &arguments));
            let by_each = arguments.iter().map(|&argument| {
                let slopes = graph.derivatives(&quantity.entries, argument);
                Tape::new(graph, &slopes, &arguments)
            });
            derivatives.push(by_each.collect());
        }
        Self {
            compiled,
            quantities,
            values,
            derivatives,
        }
    }

    fn index(&self, name: &str) -> usize {
        let found = self.quantities.iter().position(|q| q.name == name);
        found.unwrap_or_else(|| panic!("the model has no {name}"))
    }
}

/// What is this small is the rounding of a zero.
const NOTHING: f64 = 1e-5;

/// The largest difference, relative to the largest entry.
fn deviation(found: &[f64], expected: &[f64]) -> f64 {
    assert_eq!(found.len(), expected.len());
    let scale = expected.iter().fold(NOTHING, |m, x| m.max(x.abs()));
    let differences = found.iter().zip(expected).map(|(a, b)| (a - b).abs());
    let largest = differences.fold(
        0.0,
        |m: f64, d| if d.is_nan() { f64::NAN } else { m.max(d) },
    );
    assert!(expected.iter().all(|x| x.is_finite()), "{expected:?}");
    largest / scale
}

/// Asserts that two ways to the same numbers differ by rounding only.
fn near(found: &[f64], expected: &[f64]) {
    let deviation = deviation(found, expected);
    assert!(
        deviation <= TOLERANCE,
        "{deviation:e}\n{found:?}\n{expected:?}"
    );
}

/// Asserts a deviation and remembers the largest.
fn check(worst: &mut f64, found: &[f64], expected: &[f64], tolerance: f64, what: &str) {
    let deviation = deviation(found, expected);
    assert!(
        deviation <= tolerance,
        "{what}: {deviation:e}\n{found:?}\n{expected:?}"
    );
    *worst = worst.max(deviation);
}

/// `arguments` of a model as what its generated functions take.
macro_rules! point {
    ($module:ident, $arguments:expr) => {{
        let (n, k) = ($module::COORDINATES, $module::INPUTS);
        let values = $arguments;
        let take = |start: usize| move |i: usize| values[start + i];
        let first = values.len() - $module::PARAMETERS;
        let x = Point {
            t: values[0],
            q: core::array::from_fn(take(1)),
            v: core::array::from_fn(take(1 + n)),
            u: core::array::from_fn(take(1 + 2 * n)),
            z: core::array::from_fn(take(1 + 2 * n + k)),
        };
        let p = core::array::from_fn(take(first));
        ($module::Parameters::from_array(p), x)
    }};
}

macro_rules! agree {
    ($($module:ident ($model:ident) from $path:expr => $($quantity:ident)*;)*) => {$(
        mod $module {
            use super::*;
            use super::modules::$module;

            #[test]
            fn values_and_derivatives() {
                let reference = Reference::new(models::read($path));
                let names: Vec<&str> = reference.quantities.iter().map(|q| q.name.as_str()).collect();
                assert_eq!(names, [$(stringify!($quantity)),*], "a quantity is not tested");
                let mut rng = random::generator(7);
                let (mut worst, mut worst_single, mut worst_dual) = (0.0, 0.0, 0.0);
                for _ in 0..STATES {
                    let arguments = random::arguments(&reference.compiled.model, &mut rng);
                    $({
                        let name = stringify!($quantity);
                        let index = reference.index(name);
                        let expected = reference.values[index].evaluate(&arguments);

                        let (p, x) = point!($module, arguments.as_slice());
                        let found = $module::$quantity(&p, &x).flat();
                        check(&mut worst, &found, &expected, TOLERANCE, name);

                        let single: Vec<f32> = arguments.iter().map(|&a| a as f32).collect();
                        let (p, x) = point!($module, single.as_slice());
                        let found: Vec<f64> =
                            $module::$quantity(&p, &x).flat().into_iter().map(f64::from).collect();
                        check(&mut worst_single, &found, &expected, 2e-4, name);

                        for (direction, tape) in reference.derivatives[index].iter().enumerate() {
                            let seeded = |(i, &a): (usize, &f64)| Dual::<f64, 1>::variable(
                                a, if i == direction { 0 } else { 1 });
                            let dual: Vec<_> = arguments.iter().enumerate().map(seeded).collect();
                            let (p, x) = point!($module, dual.as_slice());
                            let found = $module::$quantity(&p, &x).flat();
                            let found: Vec<f64> = found.iter().map(|d| d.eps[0]).collect();
                            let slopes = tape.evaluate(&arguments);
                            let what = format!("d {name} / d argument {direction}");
                            check(&mut worst_dual, &found, &slopes, 1e-10, &what);
                        }
                    })*
                }
                println!(
                    "{}: f64 {worst:.1e}, f32 {worst_single:.1e}, dual {worst_dual:.1e}",
                    stringify!($module)
                );
            }

            /// The fused function and the trait give what the single functions give.
            #[test]
            fn fused_and_trait() {
                let compiled = models::read($path);
                let mut rng = random::generator(8);
                for _ in 0..STATES {
                    let arguments = random::arguments(&compiled.model, &mut rng);
                    let (p, x) = point!($module, arguments.as_slice());
                    let model = $module::$model { parameters: p };
                    let fused = $module::equation_of_motion(&p, &x);
                    // Another function may fuse other products: equal to round-off.
                    near(&fused.mass_matrix.concat(), &$module::mass_matrix(&p, &x).concat());
                    near(&fused.force, &$module::force(&p, &x));
                    let equation = model.equation(&x);
                    near(equation.mass_matrix.as_slice(), model.mass_matrix(&x).as_slice());
                    near(equation.force.as_slice(), model.force(&x).as_slice());
                    near(model.mass_matrix(&x).transpose().as_slice(), &fused.mass_matrix.concat());
                    near(model.force(&x).as_slice(), &fused.force);
                    let constraint = model.constraint(&x);
                    near(equation.constraint.a.as_slice(), constraint.a.as_slice());
                    near(equation.constraint.b.as_slice(), constraint.b.as_slice());
                    near(equation.constraint.c.as_slice(), constraint.c.as_slice());
                    near(equation.constraint.c_dot.as_slice(), constraint.c_dot.as_slice());
                    assert_eq!(equation.constraint.holonomic, constraint.holonomic);
                    for (row, kind) in compiled.system.constraint_kinds.iter().enumerate() {
                        let holonomic = *kind == dynamics_codegen::model::ConstraintKind::Holonomic;
                        assert_eq!(constraint.holonomic[row], holonomic);
                    }
                }
            }

            #[test]
            fn names_and_nominal_values() {
                let compiled = models::read($path);
                let model = &compiled.model;
                let names: Vec<&str> = model.parameters.iter().map(|p| p.name.as_str()).collect();
                assert_eq!($module::PARAMETER_NAMES.as_slice(), names);
                let names: Vec<&str> = model.coordinates.iter().map(|c| c.name.as_str()).collect();
                assert_eq!($module::COORDINATE_NAMES.as_slice(), names);
                let nominal = $module::$model::<f64>::nominal().parameters;
                assert_eq!(nominal.to_array().as_slice(), model.nominal_parameters());
                assert_eq!($module::Parameters::from_array(nominal.to_array()), nominal);
                assert_eq!(nominal.map(|x| x as f32).map(f64::from).to_array().len(), names_len(model));
            }
        }
    )*};
}

fn names_len(model: &dynamics_codegen::Model) -> usize {
    model.parameters.len()
}

mod modules {
    pub use super::contacts as touching;
    pub use super::fixture as everything;
    pub use generated::*;
}

agree! {
    everything (Type) from models::EVERYTHING =>
        mass_matrix bias_force applied_force input_matrix force
        constraint_jacobian constraint_bias constraint_residual constraint_rate
        outputs output_rates output_jacobian output_bias;
    touching (Touching) from models::TOUCHING =>
        mass_matrix bias_force applied_force input_matrix force
        constraint_jacobian constraint_bias constraint_residual constraint_rate
        contact_gap contact_velocity contact_jacobian contact_bias contact_coefficients
        outputs output_rates output_jacobian output_bias;
    bead (Bead) from "models/bead.model" =>
        mass_matrix bias_force applied_force input_matrix force
        constraint_jacobian constraint_bias constraint_residual constraint_rate
        state_rate initial_state;
    cartpole (Cartpole) from "models/cartpole.model" =>
        mass_matrix bias_force applied_force input_matrix force;
    duffing_free (DuffingFree) from "models/duffing_free.model" =>
        mass_matrix bias_force applied_force input_matrix force;
    duffing_constrained (DuffingConstrained) from "models/duffing_constrained.model" =>
        mass_matrix bias_force applied_force input_matrix force
        constraint_jacobian constraint_bias constraint_residual constraint_rate;
    delta (Delta) from "models/delta.model" =>
        mass_matrix bias_force applied_force input_matrix force
        constraint_jacobian constraint_bias constraint_residual constraint_rate;
    fourbar (Fourbar) from "models/fourbar.model" =>
        mass_matrix bias_force applied_force input_matrix force
        constraint_jacobian constraint_bias constraint_residual constraint_rate;
    iiwa7 (Iiwa7) from "models/iiwa7.urdf" =>
        mass_matrix bias_force applied_force input_matrix force;
    iiwa7_plane (Iiwa7Plane) from "models/iiwa7_plane.model" =>
        mass_matrix bias_force applied_force input_matrix force
        constraint_jacobian constraint_bias constraint_residual constraint_rate
        outputs output_rates output_jacobian output_bias;
    panda (Panda) from "models/panda.urdf" =>
        mass_matrix bias_force applied_force input_matrix force;
    pendulum (Pendulum) from "models/pendulum.model" =>
        mass_matrix bias_force applied_force input_matrix force;
    pendulum2 (Pendulum2) from "models/pendulum2.model" =>
        mass_matrix bias_force applied_force input_matrix force;
    solo12 (Solo12) from "models/solo12.urdf" =>
        mass_matrix bias_force applied_force input_matrix force;
    surface_particle (SurfaceParticle) from "models/surface_particle.model" =>
        mass_matrix bias_force applied_force input_matrix force
        constraint_jacobian constraint_bias constraint_residual constraint_rate;
    unicycle2d (Unicycle2d) from "models/unicycle2d.model" =>
        mass_matrix bias_force applied_force input_matrix force
        constraint_jacobian constraint_bias constraint_residual constraint_rate;
    ur5 (Ur5) from "models/ur5.urdf" =>
        mass_matrix bias_force applied_force input_matrix force;
    wheelbot (Wheelbot) from "models/wheelbot.model" =>
        mass_matrix bias_force applied_force input_matrix force
        constraint_jacobian constraint_bias constraint_residual constraint_rate;
}

/// Every model under `models/` has its line above.
#[test]
fn no_model_is_left_out() {
    let source = include_str!("back_ends_agree.rs");
    for (path, _) in models::all() {
        assert!(
            source.contains(&format!("from \"{path}\"")),
            "{path} is not tested"
        );
    }
}
