//! Nothing in this crate allocates: a counting allocator watches every public path.
//!
//! The only unsafe code of the crate: `GlobalAlloc` is an unsafe trait. Both functions
//! hand their arguments on to the system allocator unchanged.
#![allow(unsafe_code)]

mod common;

use std::alloc::{GlobalAlloc, Layout, System as SystemAllocator};
use std::cell::Cell;
use std::fmt::Write;
use std::hint::black_box;
use std::ops::ControlFlow;

use common::{CartesianPendulum, Unicycle};
use dynamics::constrained::{
    Baumgarte, FullRank, RankRevealing, SolveError, Tolerance, solve, solve_arrays,
};
use dynamics::integrate::{Direction, DormandPrince, Events, State};
use dynamics::{Control, Dual, Point, Simulation, acceleration_full_rank};
use nalgebra::{SMatrix, SVector};

struct Counting;

thread_local! {
    static ALLOCATIONS: Cell<usize> = const { Cell::new(0) };
}

// SAFETY: every call is answered by the system allocator with the same arguments.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        ALLOCATIONS.with(|count| count.set(count.get() + 1));
        unsafe { SystemAllocator.alloc(layout) }
    }
    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        unsafe { SystemAllocator.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// Number of allocations of this thread while `f` runs.
fn allocations<R>(f: impl FnOnce() -> R) -> usize {
    let before = ALLOCATIONS.with(Cell::get);
    black_box(f());
    ALLOCATIONS.with(Cell::get) - before
}

#[test]
fn the_counter_counts() {
    assert_eq!(allocations(|| Vec::<u8>::with_capacity(black_box(8))), 1);
}

#[test]
fn solves_do_not_allocate() {
    let mass = SMatrix::<f64, 4, 4>::from_diagonal_element(2.0);
    let force = SVector::<f64, 4>::repeat(1.0);
    let a = SMatrix::<f64, 2, 4>::from_fn(|i, j| (i + j) as f64);
    let doubled = SMatrix::<f64, 2, 4>::from_fn(|i, j| (i + 1) as f64 * (j + 1) as f64);
    let b = SVector::<f64, 2>::zeros();
    let tolerance = Tolerance::default();
    assert_eq!(
        allocations(|| solve(&mass, &force, &a, &b, &tolerance).unwrap()),
        0
    );
    assert_eq!(
        allocations(|| solve(&mass, &force, &doubled, &b, &tolerance).unwrap()),
        0
    );
    assert_eq!(allocations(|| FullRank::new(&mass, &a).projectors()), 0);
    assert_eq!(
        allocations(|| FullRank::new(&mass, &a).derivatives(&mass, &a)),
        0
    );
    let revealing = || RankRevealing::new(&mass, &doubled, &tolerance).unwrap();
    assert_eq!(allocations(|| revealing().projectors()), 0);
    assert_eq!(allocations(|| revealing().derivatives(&mass, &a)), 0);
    let singular = SMatrix::<f64, 4, 4>::from_diagonal(&SVector::from([0.0, 1.0, 1.0, 1.0]));
    assert_eq!(
        allocations(|| solve(&singular, &force, &a, &b, &tolerance).unwrap()),
        0
    );
    assert_eq!(
        allocations(|| solve_arrays(&[[1.0]], &[1.0], &[[1.0]], &[0.0]).unwrap()),
        0
    );
}

#[test]
fn errors_do_not_allocate() {
    struct Sink(usize);
    impl Write for Sink {
        fn write_str(&mut self, text: &str) -> std::fmt::Result {
            self.0 += text.len();
            Ok(())
        }
    }
    let run = || {
        let error: SolveError = solve_arrays(&[[0.0]], &[1.0], &[], &[]).unwrap_err();
        let mut sink = Sink(0);
        write!(sink, "{error}").unwrap();
        assert!(sink.0 > 40);
    };
    assert_eq!(allocations(run), 0);
}

#[test]
fn systems_and_integrators_do_not_allocate() {
    let solver = DormandPrince::<f64>::default();
    let pendulum =
        Simulation::new(&CartesianPendulum::<2>).with_baumgarte(Baumgarte::critical(9.0));
    let start = State {
        q: [1.0, 0.0],
        v: [0.0, 0.0],
        z: [],
    };
    let sampled = || {
        let mut sum = 0.0;
        pendulum
            .sample(
                &solver,
                (0.0, &start),
                (1.0, 0.1),
                |_, _| [],
                |_, y| sum += y.q[0],
            )
            .unwrap();
        sum
    };
    assert_eq!(allocations(sampled), 0);

    let unicycle = Simulation::new(&Unicycle);
    let start = State {
        q: [0.0; 3],
        v: [0.0; 3],
        z: [0.0],
    };
    let input = |t: f64, _: &State<f64, 3, 1>| [1.0, t];
    let go = || {
        unicycle
            .integrate(&solver, (0.0, &start), 1.0, input, |_| {
                ControlFlow::Continue(())
            })
            .unwrap();
        let y = unicycle.rk4_step(0.0, &start, 0.01, input).unwrap();
        unicycle
            .symplectic_euler_step(0.0, &y, 0.01, input)
            .unwrap()
    };
    assert_eq!(allocations(go), 0);

    let looped = || {
        let mut control = Control::new(0.05, |_: f64, y: &State<f64, 3, 1>| [1.0 - y.v[0], 0.5])
            .with_delay([[0.0; 2]; 2])
            .with_limits([-1.0; 2], [1.0; 2]);
        let on = |_: &_, _: &[f64; 2]| ControlFlow::Continue(());
        unicycle
            .integrate_controlled(&solver, (0.0, &start), 1.0, &mut control, on)
            .unwrap();
        let events = Events {
            directions: [Direction::Rising],
            functions: |_: f64, y: &State<f64, 3, 1>| [y.q[0] - 0.1],
            action: |_: usize, _: f64, _: &mut State<f64, 3, 1>| ControlFlow::Break(()),
        };
        let on = |_: &_| ControlFlow::Continue(());
        unicycle
            .integrate_with_events(&solver, (0.0, &start), 1.0, input, events, on)
            .unwrap()
    };
    assert_eq!(allocations(looped), 0);

    let dual = || {
        let [x, y] = Dual::variables([0.6, 0.8]);
        let zero = Dual::constant(0.0);
        let point = Point {
            t: zero,
            q: [x, y],
            v: [zero; 2],
            u: [],
            z: [],
        };
        acceleration_full_rank::<Dual<f64, 2>, _, 2, 0, 1, 0, 2>(
            &CartesianPendulum::<1>,
            &point,
            None,
        )
    };
    assert_eq!(allocations(dual), 0);
}
