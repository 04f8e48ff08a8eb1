//! Evidence and full gradient beside its own lower bound.
//!
//! `cargo bench -p eqmotion-gp --bench evidence` prints, for 7 outputs with 21 inputs
//! (154 hyper-parameters: 7 × (21 length-scales + 1 variance)), the wall time of
//! one evidence and gradient, of one `faer` Cholesky and inverse of the same
//! size, and their ratio. Sizes can be given: `-- 100 300`.
//! `--full` adds the route through the whole inverse and model parameters. On a
//! machine that does other work, read the processor times.

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

/// User and system time of the whole process so far, seconds (Linux; 0 elsewhere).
fn cpu() -> f64 {
    let stat = std::fs::read_to_string("/proc/self/stat").unwrap_or_default();
    // The second field is the program name in brackets; utime and stime are fields 14 and 15.
    let after = stat.rsplit(')').next().unwrap_or_default();
    let ticks: f64 = after
        .split_whitespace()
        .skip(11)
        .take(2)
        .filter_map(|t| t.parse::<f64>().ok())
        .sum();
    ticks / 100.0
}

/// Smallest wall time and mean processor time of the runs of one candidate.
struct Clock {
    wall: f64,
    cpu: f64,
    runs: f64,
}

impl Clock {
    fn new() -> Self {
        Self {
            wall: f64::INFINITY,
            cpu: 0.0,
            runs: 0.0,
        }
    }

    fn run(&mut self, work: impl FnOnce()) {
        let (start, before) = (Instant::now(), cpu());
        work();
        self.wall = self.wall.min(start.elapsed().as_secs_f64());
        self.cpu += cpu() - before;
        self.runs += 1.0;
    }

    fn mean_cpu(&self) -> f64 {
        self.cpu / self.runs
    }
}

/// One Cholesky and one inverse of the given size.
fn lower_bound(a: &Mat<f64>) {
    let c = a
        .llt(Side::Lower)
        .expect("positive definite by its diagonal");
    black_box(c.inverse());
}

fn definite(n: usize) -> Mat<f64> {
    Mat::from_fn(n, n, |i, j| {
        let d = (i as f64 - j as f64) / n as f64;
        (-0.5 * d * d * 100.0).exp() + if i == j { 0.1 } else { 0.0 }
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
        "wall: smallest of the runs; cpu: mean of the runs, all threads; one candidate after the other"
    );
    println!(
        "     N | value wall | gradient wall    cpu | bound wall    cpu | ratio wall   cpu | with 4 model parameters: wall cpu"
    );
    for points in sizes {
        let repeats = (2000 / points).clamp(2, 40);
        let (model, f, y) = problem(points);
        let tangents: Vec<Tangent> = (0..4)
            .map(|_| Tangent {
                rows: vec![0.1; f.n_rows() * OUTPUTS],
                mean: vec![0.1; f.n_rows()],
            })
            .collect();
        let mut work = Workspace::default();
        let (mut value, mut ours, mut theta, mut bound) =
            (Clock::new(), Clock::new(), Clock::new(), Clock::new());
        for _ in 0..repeats {
            value.run(|| {
                black_box(gp::nll(&model, &f, &y, &mut work).expect("well posed"));
            });
            ours.run(|| {
                black_box(evidence(&model, &f, &y, &[], &mut work).expect("well posed"));
            });
            if full {
                theta.run(|| {
                    black_box(evidence(&model, &f, &y, &tangents, &mut work).expect("well posed"));
                });
            }
        }
        let memory = peak_memory();
        drop(work);
        let a = definite(points * OUTPUTS);
        for _ in 0..repeats {
            bound.run(|| lower_bound(&a));
        }
        print!(
            "{points:>6} | {:>10.4} | {:>13.4} {:>6.3} | {:>10.4} {:>6.3} | {:>10.2} {:>5.2} |",
            value.wall,
            ours.wall,
            ours.mean_cpu(),
            bound.wall,
            bound.mean_cpu(),
            ours.wall / bound.wall,
            ours.mean_cpu() / bound.mean_cpu()
        );
        if full {
            print!(" {:.4} {:.3}", theta.wall, theta.mean_cpu());
        }
        println!("  peak memory before the bound {memory}");
    }
}
