//! Evidence and full gradient beside its own lower bound.
//!
//! `cargo bench -p gp --bench evidence` prints, for 7 outputs with 21 inputs
//! (154 hyper-parameters: 7 × (21 length-scales + 1 variance)), the wall time of
//! one evidence and gradient, of one `faer` Cholesky and inverse of the same
//! size, and their ratio. Sizes can be given: `-- 100 300`.
//! `--full` adds the route through the whole inverse and model parameters.

use faer::linalg::solvers::DenseSolveCore;
use faer::{Mat, Side};
use gp::{Functionals, Kernel, LatentPrior, Model, Tangent, Workspace, evidence};
use rand::{RngExt, SeedableRng};
use std::hint::black_box;
use std::time::Instant;

const OUTPUTS: usize = 7;
const INPUTS: usize = 21;

fn problem(points: usize) -> (Model, Functionals, Vec<f64>) {
    let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(7);
    let mut uniform = |lo: f64, hi: f64| rng.random_range(lo..hi);
    let mut f = Functionals::new(INPUTS, OUTPUTS);
    let mut y = Vec::new();
    for _ in 0..points {
        let x: Vec<f64> = (0..INPUTS).map(|_| uniform(-2.0, 2.0)).collect();
        let h: Vec<f64> = (0..OUTPUTS * OUTPUTS).map(|_| uniform(-1.0, 1.0)).collect();
        f.push(&x, &h, &[0.0; OUTPUTS])
            .expect("finite numbers of the right shape");
        y.extend((0..OUTPUTS).map(|i| (x[i] + 0.3 * x[i + 7]).sin() + 0.1 * uniform(-1.0, 1.0)));
    }
    let kernels = (0..OUTPUTS)
        .map(|_| Kernel::squared_exponential(&[3.0; INPUTS], 1.0))
        .collect();
    let model =
        Model::new(LatentPrior::independent(kernels), &[0.01; OUTPUTS]).expect("positive noise");
    (model, f, y)
}

/// Smallest wall time of `repeats` runs.
fn best(repeats: usize, mut run: impl FnMut()) -> f64 {
    (0..repeats)
        .map(|_| {
            let start = Instant::now();
            run();
            start.elapsed().as_secs_f64()
        })
        .fold(f64::INFINITY, f64::min)
}

fn lower_bound(n: usize, repeats: usize) -> f64 {
    let a = Mat::from_fn(n, n, |i, j| {
        let d = (i as f64 - j as f64) / n as f64;
        (-0.5 * d * d * 100.0).exp() + if i == j { 0.1 } else { 0.0 }
    });
    best(repeats, || {
        let c = a
            .llt(Side::Lower)
            .expect("positive definite by its diagonal");
        black_box(c.inverse());
    })
}

fn peak_memory() -> String {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status
        .lines()
        .find(|l| l.starts_with("VmHWM"))
        .unwrap_or("VmHWM: unknown");
    line.trim_start_matches("VmHWM:").trim().to_string()
}

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let sizes: Vec<usize> = arguments.iter().filter_map(|a| a.parse().ok()).collect();
    let sizes = if sizes.is_empty() {
        vec![100, 300, 1000]
    } else {
        sizes
    };
    let full = arguments.iter().any(|a| a == "--full");
    println!(
        "{OUTPUTS} outputs, {INPUTS} inputs, {} hyper-parameters and {OUTPUTS} noises",
        OUTPUTS * (INPUTS + 1)
    );
    println!(
        "{:>6} {:>13} {:>13} {:>13} {:>7}  peak memory so far",
        "N", "value [s]", "gradient [s]", "bound [s]", "ratio"
    );
    for points in sizes {
        let repeats = (600 / points).clamp(2, 20);
        let (model, f, y) = problem(points);
        let mut work = Workspace::default();
        let value = best(repeats, || {
            black_box(gp::nll(&model, &f, &y, &mut work).expect("well posed"));
        });
        let ours = best(repeats, || {
            black_box(evidence(&model, &f, &y, &[], &mut work).expect("well posed"));
        });
        let memory = peak_memory();
        let theta = full.then(|| {
            let tangents: Vec<Tangent> = (0..4)
                .map(|_| Tangent {
                    rows: vec![0.1; f.n_rows() * OUTPUTS],
                    mean: vec![0.1; f.n_rows()],
                })
                .collect();
            best(repeats, || {
                black_box(evidence(&model, &f, &y, &tangents, &mut work).expect("well posed"));
            })
        });
        drop(work);
        let bound = lower_bound(points * OUTPUTS, repeats);
        println!(
            "{points:>6} {value:>13.5} {ours:>13.5} {bound:>13.5} {:>7.2}  {memory}",
            ours / bound
        );
        if let Some(theta) = theta {
            println!(
                "{points:>6} with 4 model parameters, whole inverse: {theta:.5} s, ratio {:.2}",
                theta / bound
            );
        }
    }
}
