//! Functions on request: values as the tape gives them, derivatives as central
//! differences, the same functions on dual numbers, and CasADi give them.

use dynamics::constrained::Tolerance;
use dynamics::{Dual, Point, motion_by_parameters, motion_derivatives};
use dynamics_codegen::derive::{Expansion, Group, Item};
use dynamics_codegen::emit::Emission;
use dynamics_codegen::{Compiled, Tape};
use integration_tests::reference::{Case, Deviations, Reference};
use integration_tests::{models, random};
use rand::RngExt;
use std::collections::BTreeMap;

/// Every model with functions on request, made by the build script.
#[allow(dead_code, non_snake_case, clippy::all)]
mod full {
    include!(concat!(env!("OUT_DIR"), "/full.rs"));
}

#[path = "derivatives/oracles.rs"]
mod oracles;

const STATES: usize = 20;
/// Relative to the largest entry.
const VALUES: f64 = 1e-11;
const DUAL: f64 = 1e-10;
const DIFFERENCES: f64 = 1e-6;
const CASADI: f64 = 1e-8;
/// A derivative counts as at least this share of what is differentiated: some are zero,
/// and come out as rounding here or there.
const FLOOR: f64 = 1e-4;

fn largest(values: &[f64]) -> f64 {
    values.iter().fold(0.0, |m: f64, x| m.max(x.abs()))
}

/// The largest difference, relative to the largest entry or `floor`.
fn deviation(found: &[f64], expected: &[f64], floor: f64) -> f64 {
    assert_eq!(found.len(), expected.len());
    let size = largest(expected).max(floor).max(f64::MIN_POSITIVE);
    let gaps = found
        .iter()
        .zip(expected)
        .map(|(a, b)| (a - b).abs() / size);
    let worst = |worst: f64, gap: f64| {
        if gap.is_finite() {
            worst.max(gap)
        } else {
            f64::NAN
        }
    };
    gaps.fold(0.0, worst)
}

/// Calls a generated function by name: its quantities, each as a list.
type Call<T> = fn(&str, &[T]) -> Vec<Vec<T>>;

/// A model's generated functions beside its graph.
struct Subject<'a> {
    emission: Emission<'a>,
    compiled: &'a Compiled,
    call: Call<f64>,
    dual: Call<Dual<f64, 1>>,
    /// Where each item stands: a function, and the place in its result.
    places: BTreeMap<Item, (String, usize)>,
}

impl<'a> Subject<'a> {
    fn new(
        compiled: &'a Compiled,
        functions: &str,
        call: Call<f64>,
        dual: Call<Dual<f64, 1>>,
    ) -> Self {
        let functions = functions.parse().expect("the build script's own list");
        let emission = Emission::new(compiled, "m", &functions).expect("as the build script");
        let mut places = BTreeMap::new();
        for (name, quantities) in emission.functions() {
            for (index, quantity) in quantities.iter().enumerate() {
                let item = quantity.item.expect("none is our own");
                places.entry(item).or_insert((name.to_string(), index));
            }
        }
        Self {
            emission,
            compiled,
            call,
            dual,
            places,
        }
    }

    /// Random values of `t, q, v, u, parameters, a, λ`.
    fn sample(&self, rng: &mut rand_chacha::ChaCha8Rng) -> Vec<f64> {
        let model = &self.compiled.model;
        let mut values = random::arguments(model, rng);
        let stated = model.coordinates.len() + model.constraints.len();
        values.extend((0..stated).map(|_| rng.random_range(-2.0..2.0)));
        values
    }

    /// The places of a group's variables among the arguments.
    fn columns(&self, group: Group) -> std::ops::Range<usize> {
        let model = &self.compiled.model;
        let (n, k) = (model.coordinates.len(), model.inputs.len());
        let parameters = 1 + 2 * n + k;
        match group {
            Group::Time => 0..1,
            Group::Position => 1..1 + n,
            Group::Velocity => 1 + n..1 + 2 * n,
            Group::Input => 1 + 2 * n..parameters,
            Group::Parameters => parameters..parameters + model.parameters.len(),
        }
    }

    /// Every quantity of every function against the tape.
    fn check_values(&self, samples: &[Vec<f64>]) -> f64 {
        let (graph, arguments) = (self.emission.graph(), self.emission.arguments());
        // What is solved for in loops, in straight lines.
        let mut straight = Expansion::new(self.compiled);
        let mut worst: f64 = 0.0;
        for (name, quantities) in self.emission.functions() {
            let tapes: Vec<Tape> = quantities
                .iter()
                .map(|q| {
                    if q.entries.is_empty() {
                        let entries = straight.entries(q.item.expect("none is our own"));
                        return Tape::new(&straight.model.graph, &entries.unwrap(), &arguments);
                    }
                    Tape::new(graph, &q.entries, &arguments)
                })
                .collect();
            for sample in samples {
                let found = (self.call)(name, sample);
                assert_eq!(found.len(), tapes.len(), "{name}");
                for (found, tape) in found.iter().zip(&tapes) {
                    let off = deviation(found, &tape.evaluate(sample), 0.0);
                    assert!(off <= VALUES, "{name}: {off:e}");
                    worst = worst.max(off);
                }
            }
        }
        worst
    }

    /// Every derivative against dual numbers and differences of what is differentiated.
    fn check_slopes(&self, samples: &[Vec<f64>]) -> (f64, f64, usize) {
        let (mut dual, mut difference, mut count) = (0.0_f64, 0.0_f64, 0);
        for (item, (function, index)) in &self.places {
            let Some(group) = item.by else { continue };
            let Some((of, place)) = self.places.get(&Item::of(item.term)) else {
                panic!("{item}: nothing to compare with");
            };
            count += 1;
            for sample in samples {
                let found = &(self.call)(function, sample)[*index];
                let value = &(self.call)(of, sample)[*place];
                let floor = FLOOR * largest(value);
                let width = self.columns(group).len();
                assert_eq!(found.len(), value.len() * width, "{item}");
                for (column, variable) in self.columns(group).enumerate() {
                    let found: Vec<f64> =
                        found.iter().skip(column).step_by(width).copied().collect();
                    let expected = self.by_dual(of, *place, sample, variable);
                    let scale = largest(&expected).max(floor);
                    let off = deviation(&found, &expected, floor);
                    assert!(
                        off <= DUAL,
                        "{item}, column {column}: {off:e} from dual numbers"
                    );
                    dual = dual.max(off);
                    let (expected, step) = self.by_differences(of, *place, sample, variable);
                    // Rounding of the values, over the step.
                    let noise = 1e-12 * largest(value) / step;
                    let off = deviation(&found, &expected, scale.max(noise / DIFFERENCES));
                    assert!(
                        off <= DIFFERENCES,
                        "{item}, column {column}: {off:e} from differences"
                    );
                    difference = difference.max(off);
                }
            }
        }
        (dual, difference, count)
    }

    fn by_dual(&self, name: &str, place: usize, sample: &[f64], variable: usize) -> Vec<f64> {
        let seeded = sample.iter().enumerate();
        let seeded: Vec<Dual<f64, 1>> = seeded
            .map(|(i, &x)| Dual::variable(x, usize::from(i != variable)))
            .collect();
        let values = (self.dual)(name, &seeded);
        values[place].iter().map(|x| x.eps[0]).collect()
    }

    /// Central differences of fourth order.
    fn by_differences(
        &self,
        name: &str,
        place: usize,
        sample: &[f64],
        variable: usize,
    ) -> (Vec<f64>, f64) {
        // A parameter may be as small as a wheel's moment of inertia.
        let parameter = self.columns(Group::Parameters).contains(&variable);
        let least = if parameter { 1e-6 } else { 0.1 };
        let step = 1e-3 * sample[variable].abs().max(least);
        let at = |shift: f64| {
            let mut moved = sample.to_vec();
            moved[variable] += shift * step;
            (self.call)(name, &moved)[place].clone()
        };
        let (near, far) = ([at(-1.0), at(1.0)], [at(-2.0), at(2.0)]);
        let slopes: Vec<f64> = (0..near[0].len())
            .map(|i| {
                let (near, far) = (near[1][i] - near[0][i], far[1][i] - far[0][i]);
                (8.0 * near - far) / (12.0 * step)
            })
            .collect();
        (slopes, step)
    }
}

/// Compares `(∂a/∂s, ∂λ/∂s)`, each row by row, with what the file says.
fn check_motion(worst: &mut Deviations, case: &Case, group: &str, found: (Vec<f64>, Vec<f64>)) {
    for (what, found) in [("a", found.0), ("lambda", found.1)] {
        let key = format!("d{what}_d{group}");
        let floor = FLOOR * largest(&case.numbers(what));
        let with_floor = |values: &[f64]| [values, &[floor]].concat();
        let expected = case.numbers(&key);
        let at = (case.place(), key.as_str());
        worst.check(at, &with_floor(&found), &with_floor(&expected), CASADI);
    }
}

fn array<const N: usize>(values: &[f64]) -> [f64; N] {
    values.try_into().expect("as many as the model has")
}

/// A matrix of nalgebra, row by row.
macro_rules! rows {
    ($pair:expr) => {
        (
            $pair.0.transpose().as_slice().to_vec(),
            $pair.1.transpose().as_slice().to_vec(),
        )
    };
}

macro_rules! agree {
    ($($module:ident $calls:ident from $path:expr;)*) => {$(
        mod $module {
            use super::*;
            use super::full::$calls as calls;

            #[test]
            fn values_and_slopes() {
                let compiled = models::read($path);
                let subject = Subject::new(
                    &compiled, calls::FUNCTIONS, calls::call::<f64>, calls::call::<Dual<f64, 1>>,
                );
                let mut rng = random::generator(11);
                let samples: Vec<Vec<f64>> = (0..STATES).map(|_| subject.sample(&mut rng)).collect();
                let values = subject.check_values(&samples);
                let (dual, difference, count) = subject.check_slopes(&samples);
                assert!(count >= 9, "only {count} derivatives");
                println!(
                    "{}: {count} derivatives; tape {values:.1e}, dual {dual:.1e}, differences {difference:.1e}",
                    stringify!($module),
                );
            }
        }
    )*};
}

agree! {
    r#type__ call_type__ from models::EVERYTHING;
    sensed call_sensed from models::SENSED;
    cartpole call_cartpole from "models/cartpole.model";
    delta call_delta from "models/delta.model";
    duffing_constrained call_duffing_constrained from "models/duffing_constrained.model";
    duffing_free call_duffing_free from "models/duffing_free.model";
    limbs call_limbs from models::MANY;
    fourbar call_fourbar from "models/fourbar.model";
    pendulum call_pendulum from "models/pendulum.model";
    pendulum2 call_pendulum2 from "models/pendulum2.model";
    surface_particle call_surface_particle from "models/surface_particle.model";
    unicycle2d call_unicycle2d from "models/unicycle2d.model";
    iiwa7 call_iiwa7 from "models/iiwa7.urdf";
    iiwa7_plane call_iiwa7_plane from "models/iiwa7_plane.model";
    panda call_panda from "models/panda.urdf";
    wheelbot call_wheelbot from "models/wheelbot.model";
}

/// Models that CasADi derives too.
mod casadi {
    use super::*;

    /// Derivatives of the terms, each a function.
    const TERMS: [(&str, &str); 6] = [
        ("dM_dq", "mass_matrix_by_position"),
        ("dbias_dq", "bias_force_by_position"),
        ("dbias_dv", "bias_force_by_velocity"),
        ("dA_dq", "constraint_jacobian_by_position"),
        ("db_dq", "constraint_bias_by_position"),
        ("db_dv", "constraint_bias_by_velocity"),
    ];

    macro_rules! agree {
    ($($module:ident $calls:ident $model:ident from $path:expr;)*) => {$(
            /// The motion's derivatives by the implicit route, and written out.
            #[test]
            fn $module() {
                use super::full::{$calls as calls, $module as module};
                let reference = Reference::read(stringify!($module));
                let compiled = models::read($path);
                let constrained = !compiled.model.constraints.is_empty();
                let mut worst = Deviations::default();
                for case in &reference.cases {
                    let names = reference.parameters.iter();
                    let parameters: Vec<f64> = names.map(|name| case.parameter(name)).collect();
                    let x = Point::<f64, { module::COORDINATES }, { module::INPUTS }, 0> {
                        t: case.time(),
                        q: array(&case.numbers("q")),
                        v: array(&case.numbers("v")),
                        u: array(&case.numbers("u")),
                        z: [],
                    };
                    let system = module::$model {
                        parameters: module::Parameters::from_array(array(&parameters)),
                    };
                    let tolerance = Tolerance::default();
                    let slopes = motion_derivatives(&system, &x, &tolerance).unwrap();
                    check_motion(&mut worst, case, "q", rows!(slopes.by_position));
                    check_motion(&mut worst, case, "v", rows!(slopes.by_velocity));
                    check_motion(&mut worst, case, "u", rows!(slopes.by_input));
                    check_motion(&mut worst, case, "t", rows!(slopes.by_time));
                    let (_, slopes) = motion_by_parameters(&system, &x, &tolerance).unwrap();
                    check_motion(&mut worst, case, "p", rows!(slopes));

                    let state = [&[x.t], x.q.as_slice(), &x.v, &x.u, &parameters].concat();
                    let stated = [vec![0.0; module::COORDINATES], vec![0.0; module::CONSTRAINTS]];
                    let arguments = [state, stated.concat()].concat();
                    let name = if constrained { "constrained" } else { "forward" };
                    let written = calls::call(&format!("{name}_dynamics_derivatives"), &arguments);
                    let groups = ["q", "v", "u"].into_iter().take(if module::INPUTS == 0 { 2 } else { 3 });
                    for (index, group) in groups.clone().enumerate() {
                        let (a, lambda) = if constrained {
                            let lambda = 2 + groups.clone().count() + index;
                            (written[2 + index].clone(), written[lambda].clone())
                        } else {
                            (written[1 + index].clone(), Vec::new())
                        };
                        check_motion(&mut worst, case, group, (a, lambda));
                    }
                    for (key, function) in TERMS {
                        let expected = case.numbers(key);
                        if expected.is_empty() {
                            continue;
                        }
                        let found = calls::call(function, &arguments).concat();
                        // What is zero comes out as rounding of what it is a difference of.
                        let with_floor = |values: &[f64]| [values, &[1e-3]].concat();
                        let (found, expected) = (with_floor(&found), with_floor(&expected));
                        worst.check((case.place(), key), &found, &expected, CASADI);
                    }
                }
                println!("{}: {}", stringify!($module), worst.summary());
            }
    )*};
}

    agree! {
        cartpole call_cartpole Cartpole from "models/cartpole.model";
        delta call_delta Delta from "models/delta.model";
        duffing_constrained call_duffing_constrained DuffingConstrained
            from "models/duffing_constrained.model";
        duffing_free call_duffing_free DuffingFree from "models/duffing_free.model";
        fourbar call_fourbar Fourbar from "models/fourbar.model";
        pendulum call_pendulum Pendulum from "models/pendulum.model";
        pendulum2 call_pendulum2 Pendulum2 from "models/pendulum2.model";
        surface_particle call_surface_particle SurfaceParticle from "models/surface_particle.model";
        unicycle2d call_unicycle2d Unicycle2d from "models/unicycle2d.model";
    }
}

/// Every model in our language has its line above; of robot descriptions, which differ in
/// figures alone, two.
#[test]
fn no_model_is_left_out() {
    let source = include_str!("derivatives.rs");
    let models = models::all().into_iter().map(|(path, _)| path);
    // `bead.rs` calls functions of what remembers.
    let models = models.filter(|path| path != "models/bead.model");
    for path in models.filter(|path| path.ends_with(".model")) {
        assert!(
            source.contains(&format!("from \"{path}\"")),
            "{path} is not tested"
        );
    }
}
