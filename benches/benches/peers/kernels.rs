//! Our side: what is called, with what, and whether the results are CasADi's.

use crate::driver::Driver;
use benches::iiwa7::{self, Parameters};
use dynamics::batch::{Columns, Lanes, evaluate};
use dynamics::{Point, Real, Scalar};
use std::hint::black_box;
use std::time::Instant;

/// How many states take turns.
pub const STATES: usize = 64;

/// A state, and an acceleration where one is stated.
#[derive(Debug, Clone, Copy)]
pub struct State<T> {
    /// Where the model is evaluated.
    pub x: Point<T, 7, 7, 0>,
    /// The acceleration.
    pub a: [T; 7],
}

/// The states, the same on every run: multiples of an irrational number.
pub fn states<T: Scalar>() -> Vec<State<T>> {
    let mut phase = 0.0_f64;
    let mut next = |size: f64| {
        phase = (phase + 0.618_033_988_749_895) % 1.0;
        // Exact in f32, so that both precisions compute at the same states.
        T::from_f64(f64::from(((2.0 * phase - 1.0) * size) as f32))
    };
    let mut array = |size: f64| std::array::from_fn(|_| next(size));
    let states = (0..STATES).map(|_| State {
        x: Point {
            t: T::zero(),
            q: array(3.0),
            v: array(2.0),
            u: array(20.0),
            z: [],
        },
        a: array(5.0),
    });
    states.collect()
}

/// A function of ours with CasADi's.
pub struct Kernel<T> {
    /// The row of the table.
    pub name: &'static str,
    /// CasADi's function.
    pub casadi: &'static str,
    /// Ours in C.
    pub ours: &'static str,
    /// The ratio of times that is to be reached.
    pub goal: f64,
    states: Vec<State<T>>,
    /// Runs through so many states.
    run: fn(&[State<T>], usize),
    /// Results in the order of CasADi's outputs, each column by column, at most 128 numbers.
    value: fn(&State<T>) -> Vec<Vec<T>>,
}

impl<T: Real> Kernel<T> {
    /// Nanoseconds per evaluation.
    pub fn time(&self, count: usize) -> f64 {
        let start = Instant::now();
        (self.run)(black_box(&self.states), count);
        start.elapsed().as_nanos() as f64 / count as f64
    }

    /// Compares all results with those of CasADi's function `casadi`.
    pub fn compare(&self, driver: &mut Driver, casadi: &str) -> Result<(), String> {
        let tolerance = if T::epsilon().to_f64() < 1e-10 {
            1e-9
        } else {
            2e-3
        };
        for (index, state) in self.states.iter().enumerate() {
            let theirs = driver.values(casadi, index)?;
            for (place, ours) in (self.value)(state).iter().enumerate() {
                let theirs = &theirs[128 * place..][..ours.len()];
                let size = theirs.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
                let gaps = ours.iter().zip(theirs).map(|(x, y)| (x.to_f64() - y).abs());
                let gap = gaps.fold(0.0, f64::max) / size;
                if gap.is_nan() || gap > tolerance {
                    return Err(format!(
                        "{}: result {place} at state {index} is {gap:.1e} off CasADi's {casadi}\n{ours:?}\n{theirs:?}",
                        self.name
                    ));
                }
            }
        }
        Ok(())
    }
}

/// One call per state, results to memory.
macro_rules! run {
    (|$p:ident, $state:ident| $call:expr) => {{
        #[inline(never)]
        fn run<T: Scalar>(states: &[State<T>], count: usize) {
            let nominal = Parameters::<T>::nominal();
            let $p = black_box(&nominal);
            for k in 0..count {
                let $state = &states[k % STATES];
                let result = $call;
                black_box(&result);
            }
        }
        run::<T>
    }};
}

fn by_columns<T: Copy, const R: usize, const C: usize>(rows: [[T; C]; R]) -> Vec<T> {
    (0..C).flat_map(|j| rows.map(|row| row[j])).collect()
}

/// All rows of the table.
pub fn kernels<T: Real>() -> Vec<Kernel<T>> {
    let kernel = |(name, casadi, ours, goal), run, value| Kernel {
        name,
        casadi,
        ours,
        goal,
        states: states(),
        run,
        value,
    };
    fn p<T: Scalar>() -> Parameters<T> {
        Parameters::nominal()
    }
    vec![
        kernel(
            ("mass matrix", "M_local_cse", "mass_matrix", 0.64),
            run!(|p, s| iiwa7::mass_matrix(p, &s.x)),
            |s| vec![by_columns(iiwa7::mass_matrix(&p(), &s.x))],
        ),
        kernel(
            ("bias force", "bias_cse", "bias_force", 0.73),
            run!(|p, s| iiwa7::bias_force(p, &s.x)),
            |s| vec![iiwa7::bias_force(&p(), &s.x).map(|x| -x).to_vec()],
        ),
        kernel(
            ("both", "Mbias_cse", "mass_matrix_and_bias_force", 0.62),
            run!(|p, s| iiwa7::mass_matrix_and_bias_force(p, &s.x)),
            |s| {
                let r = iiwa7::mass_matrix_and_bias_force(&p(), &s.x);
                vec![by_columns(r.mass_matrix), r.bias_force.map(|x| -x).to_vec()]
            },
        ),
        kernel(
            ("forward dynamics", "fd_ldl_cse", "forward_dynamics", 0.70),
            run!(|p, s| iiwa7::forward_dynamics(p, &s.x)),
            |s| vec![iiwa7::forward_dynamics(&p(), &s.x).to_vec()],
        ),
        kernel(
            ("… and one contact", "cfd1_cse", "contact", 0.67),
            run!(|p, s| iiwa7::contact(p, &s.x)),
            |s| {
                let r = iiwa7::contact(&p(), &s.x);
                vec![r.acceleration.to_vec(), r.multiplier.to_vec()]
            },
        ),
        kernel(
            (
                "∂ inverse dynamics",
                "drnea_ana_cse",
                "inverse_dynamics_derivatives",
                0.30,
            ),
            run!(|p, s| iiwa7::inverse_dynamics_derivatives(p, &s.x, &s.a)),
            |s| {
                let r = iiwa7::inverse_dynamics_derivatives(&p(), &s.x, &s.a);
                vec![
                    by_columns(r.inverse_dynamics_by_position),
                    by_columns(r.inverse_dynamics_by_velocity),
                ]
            },
        ),
        kernel(
            (
                "∂ forward dynamics",
                "daba_ana_cse",
                "forward_dynamics_derivatives",
                0.48,
            ),
            run!(|p, s| iiwa7::forward_dynamics_derivatives(p, &s.x)),
            |s| {
                let r = iiwa7::forward_dynamics_derivatives(&p(), &s.x);
                vec![
                    by_columns(r.forward_dynamics_by_position),
                    by_columns(r.forward_dynamics_by_velocity),
                ]
            },
        ),
        kernel(
            ("Jacobian", "J_cse", "jacobian", 0.76),
            run!(|p, s| iiwa7::jacobian(p, &s.x)),
            |s| vec![by_columns(iiwa7::jacobian(&p(), &s.x))],
        ),
        kernel(
            ("… with its rate", "JJdot_cse", "jacobian_and_rate", 0.76),
            run!(|p, s| iiwa7::jacobian_and_rate(p, &s.x)),
            |s| {
                let r = iiwa7::jacobian_and_rate(&p(), &s.x);
                vec![by_columns(r.jacobian), by_columns(r.rate)]
            },
        ),
    ]
}

/// Columns of equal length that begin at multiples of 64 bytes.
struct Table<E> {
    numbers: Vec<E>,
    first: usize,
    length: usize,
}

impl<E: Real> Table<E> {
    fn new(columns: usize, length: usize, entry: impl Fn(usize, usize) -> E) -> Self {
        let line = 64 / size_of::<E>();
        let mut numbers = vec![E::zero(); columns * length + line];
        let first = (0..line).find(|&i| (&raw const numbers[i]).addr() % 64 == 0);
        let first = first.expect("one of the numbers in a line is its first");
        for column in 0..columns {
            for i in 0..length {
                numbers[first + column * length + i] = entry(column, i);
            }
        }
        Self {
            numbers,
            first,
            length,
        }
    }

    fn columns(&self) -> impl Iterator<Item = &[E]> {
        self.numbers[self.first..].chunks_exact(self.length)
    }

    fn columns_mut(&mut self) -> impl Iterator<Item = &mut [E]> {
        self.numbers[self.first..].chunks_exact_mut(self.length)
    }
}

/// States in columns for the batched call.
pub struct Batch<L: Lanes> {
    states: Table<L::Element>,
    results: Table<L::Element>,
}

/// States per call, whole lines of the cache: as many as stay in the first cache with their
/// results, and as many as stay in the second.
pub const SAMPLES: [usize; 2] = [32, 240];
/// Mass matrix and bias force.
const RESULTS: usize = 56;

impl<L: Lanes> Batch<L> {
    /// So many of the states of [`states`], over and over: `q`, `v`, and a column of zeros.
    pub fn new(samples: usize) -> Self {
        let states = states::<L::Element>();
        let entry = |column: usize, i: usize| {
            let x = &states[i % STATES].x;
            let numbers = x.q.iter().chain(&x.v);
            numbers.copied().nth(column).unwrap_or(L::Element::zero())
        };
        Self {
            states: Table::new(15, samples, entry),
            results: Table::new(RESULTS, samples, |_, _| L::Element::zero()),
        }
    }

    /// Nanoseconds per state over about 10 000 states.
    pub fn time(&mut self) -> f64 {
        let calls = 10_000 / self.states.length;
        let start = Instant::now();
        for _ in 0..calls {
            self.run();
        }
        start.elapsed().as_nanos() as f64 / (calls * self.states.length) as f64
    }

    /// Compares with one state after another.
    pub fn compare(&mut self) -> Result<(), String> {
        self.run();
        let states = states::<L::Element>();
        let tolerance = 100.0 * L::Element::epsilon().to_f64();
        for i in 0..self.states.length {
            let r =
                iiwa7::mass_matrix_and_bias_force(&Parameters::nominal(), &states[i % STATES].x);
            let expected = r.mass_matrix.concat().into_iter().chain(r.bias_force);
            for (k, expected) in expected.enumerate() {
                let found = self
                    .results
                    .columns()
                    .nth(k)
                    .map_or(&[][..], |column| column);
                let gap = (found[i] - expected).abs().to_f64();
                if gap.is_nan() || gap > tolerance * expected.abs().to_f64().max(10.0) {
                    return Err(format!("batched: result {k} of state {i} is {gap:e} off"));
                }
            }
        }
        Ok(())
    }

    #[inline(never)]
    fn run(&mut self) {
        let mut columns = self.states.columns();
        let mut take = || columns.next().unwrap_or(&[]);
        let states = Columns {
            q: std::array::from_fn(|_| take()),
            v: std::array::from_fn(|_| take()),
            u: [&[] as &[L::Element]; 7],
            t: take(),
            z: [],
        };
        let states = Columns {
            u: [states.t; 7],
            ..states
        };
        let mut out: Vec<&mut [L::Element]> = self.results.columns_mut().take(RESULTS).collect();
        let p = Parameters::<L>::nominal();
        let done = evaluate(&states, &mut out, |x: &Point<L, 7, 7, 0>| {
            iiwa7::mass_matrix_and_bias_force(&p, x)
        });
        assert_eq!(done, Ok(()));
        black_box(&out);
    }
}
