//! Our generated Rust and C beside CasADi's generated C, in one run: `cargo bench`.
//!
//! What is compared is the KUKA iiwa of `models/iiwa7.urdf` with the C that CasADi made of
//! Pinocchio's model of the same arm (near-zero entries of its rotations snapped, common
//! subexpressions shared), in `../shared/peers/casadi_iiwa` beside the workspace. The batched
//! call is compared with CasADi's C as it comes too, nothing snapped: `unsnapped/derive.py`.
//!
//! How it is kept fair:
//! * the compilers may use all of this machine on both sides: `cc -O3 -march=native`, and
//!   `-C target-cpu=native` (this program builds and starts itself again with it);
//! * the same 64 states, in the same order, one call per state through a function that is not
//!   inlined, results written to memory; the same clock;
//! * the two take turns, many short rounds each, pinned to one core if `taskset` is there;
//!   the fastest round of each counts;
//! * before anything is timed, all results are compared with CasADi's.

mod driver;
mod kernels;
mod native;
mod report;

use driver::{Driver, Precision, UNSNAPPED};
use kernels::{Batch, Kernel, SAMPLES, kernels};
use report::{Batched, Row};

/// Rounds per function and side.
const ROUNDS: usize = 40;
/// CasADi's mass matrix and bias force, snapped.
const SNAPPED: &str = "Mbias_cse";
/// What a round lasts, about, in nanoseconds.
const ROUND: f64 = 2.0e6;

fn main() {
    if let Err(message) = run() {
        eprintln!("{message}");
        std::process::exit(1);
    }
}

fn run() -> Result<(), String> {
    // `cargo bench -- --list` and the like ask for tests.
    if std::env::args().any(|a| a == "--list" || a == "--test") {
        return Ok(());
    }
    if !native::is_native() {
        return native::start_again();
    }
    println!("{}", report::heading());
    let mut rows = Vec::new();
    for precision in [Precision::Double, Precision::Single] {
        let mut driver = Driver::start(precision)?;
        let single = match precision {
            Precision::Double => singly(&mut driver, &kernels::<f64>())?,
            Precision::Single => singly(&mut driver, &kernels::<f32>())?,
        };
        println!("{}", report::table(precision, &single));
        let batched = match precision {
            Precision::Double => batch(&mut driver, Batch::<dynamics::batch::WideF64>::new)?,
            Precision::Single => batch(&mut driver, Batch::<dynamics::batch::WideF32>::new)?,
        };
        println!("{}", report::batched(precision, &batched));
        rows.push(single);
    }
    println!("{}", report::verdict(&rows[0]));
    Ok(())
}

/// Compares every result, CasADi's unsnapped ones too, and times every function.
fn singly<T>(driver: &mut Driver, kernels: &[Kernel<T>]) -> Result<Vec<Row>, String>
where
    T: dynamics::Real,
{
    for kernel in kernels {
        kernel.compare(driver, kernel.casadi)?;
        if kernel.casadi == SNAPPED {
            kernel.compare(driver, UNSNAPPED)?;
        }
    }
    one_by_one(driver, kernels)
}

/// Times every function at one state after another.
fn one_by_one<T>(driver: &mut Driver, kernels: &[Kernel<T>]) -> Result<Vec<Row>, String>
where
    T: dynamics::Real,
{
    let mut rows = Vec::new();
    for kernel in kernels {
        let count = |ns: f64| (ROUND / ns).max(64.0) as usize / 64 * 64;
        let guess = driver.time(kernel.casadi, 640)?;
        let count = count(guess);
        let mut best = [f64::INFINITY; 3];
        for _ in 0..ROUNDS {
            best[0] = best[0].min(driver.time(kernel.casadi, count)?);
            best[1] = best[1].min(driver.time(kernel.ours, count)?);
            best[2] = best[2].min(kernel.time(count));
        }
        rows.push(Row {
            name: kernel.name,
            goal: kernel.goal,
            casadi: best[0],
            c: best[1],
            rust: best[2],
        });
    }
    Ok(rows)
}

/// Times mass matrix and bias force of many states at once, in turns with CasADi's C, one
/// state after another.
fn batch<L>(driver: &mut Driver, new: fn(usize) -> Batch<L>) -> Result<Batched, String>
where
    L: dynamics::batch::Lanes,
{
    let mut batches = SAMPLES.map(new);
    let mut best = Batched {
        snapped: f64::INFINITY,
        unsnapped: f64::INFINITY,
        ours: [f64::INFINITY; SAMPLES.len()],
    };
    for batch in &mut batches {
        batch.compare()?;
    }
    for _ in 0..ROUNDS {
        best.snapped = best.snapped.min(driver.time(SNAPPED, 6400)?);
        best.unsnapped = best.unsnapped.min(driver.time(UNSNAPPED, 6400)?);
        for (batch, best) in batches.iter_mut().zip(&mut best.ours) {
            // Short pieces in a row: the first of them wakes the wide units up.
            for _ in 0..10 {
                *best = best.min(batch.time());
            }
        }
    }
    Ok(best)
}
