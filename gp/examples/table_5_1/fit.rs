//! Fits of Table 5.1 by the published protocol.

use crate::benchmark::{Benchmark, Data, Kind, System};
use gp::{
    Algorithm, Atlas, Fitted, Kernel, LatentPrior, Model, Posterior, Problem, Structure, Training,
};

/// RMSE and constraint error of one fit.
pub struct Score {
    pub rmse: f64,
    pub constraint: f64,
    /// The trained model, its parameters and how training went.
    pub fitted: Fitted,
}

fn algorithm() -> Algorithm {
    Algorithm::Lbfgs {
        max_iterations: 200,
        gradient_tolerance: 1e-4,
        reduction_tolerance: 1e-9,
    }
}

fn noise(data: &Data) -> Vec<f64> {
    data.y_sd.iter().map(|s| (data.noise / s).powi(2)).collect()
}

/// Bounds and uniform starts shared by all models.
fn training(
    problem: &Problem<'_>,
    variance: (f64, f64),
    restarts: usize,
    seed: u64,
) -> gp::Result<Training> {
    let (l0, l1) = (0.5f64.ln(), 20f64.ln());
    let (v0, v1) = (variance.0.ln(), variance.1.ln());
    Training::new(problem)
        .algorithm(algorithm())
        .bounds("*log_length[*]", l0, l1)?
        .start_in("*log_length[*]", l0, l1)?
        .bounds("*log_variance*", v0, v1)?
        .start_in("*log_variance*", v0, v1)?
        .fix("log_noise[*]")
        .map(|t| t.restarts(restarts).seed(seed).forget_given())
}

fn se(dims: usize) -> Kernel {
    Kernel::squared_exponential(&vec![2.0; dims], 1.0)
}

/// Independent SE-GPs, ICM or LMC on the accelerations themselves.
fn baseline(kind: Kind, b: &Benchmark<'_>, seed: u64, restarts: usize) -> gp::Result<Fitted> {
    let (n, dims) = (b.data.y_sd.len(), b.data.dims());
    let w = || vec![vec![0.5; n]; n];
    let kappa = || vec![0.1; n];
    let prior = match kind {
        Kind::Se => LatentPrior::independent(vec![se(dims); n]),
        Kind::Icm => LatentPrior::coregional(vec![(se(dims), w(), kappa())]),
        _ => LatentPrior::coregional(vec![
            (se(dims), w(), kappa()),
            (Kernel::bias(1.0), w(), kappa()),
            (Kernel::linear(&vec![1.0; dims]), w(), kappa()),
        ]),
    };
    let problem = Problem::new(Model::new(prior, &noise(b.data))?, b, &b.data.y);
    let mut t = training(&problem, (0.01, 1.0), restarts, seed)?;
    if kind != Kind::Se {
        t = t
            .bounds("*weight*", -10.0, 10.0)?
            .start_in("*weight*", -1.0, 1.0)?
            .fix("term[*].log_variance")?;
        t = t
            .bounds("*log_kappa*", 1e-6f64.ln(), 10f64.ln())?
            .start_in("*log_kappa*", 0.01f64.ln(), 0.0)?;
    }
    t.run(&problem)
}

fn structured(b: &Benchmark<'_>, seed: u64, restarts: Option<usize>) -> gp::Result<Fitted> {
    let n = b.data.y_sd.len();
    let prior = LatentPrior::shared(n, se(b.data.dims()));
    let theta = b.start();
    let problem = Problem::new(Model::new(prior, &noise(b.data))?, b, &b.data.y)
        .with_theta(&theta, Atlas::free(theta.len()));
    let restarts = restarts.unwrap_or(if b.system.name == "duffing" { 10 } else { 5 });
    let mut t = training(&problem, (0.25, 100.0), restarts, seed)?;
    for (i, (lower, upper)) in b.theta_bounds().into_iter().enumerate() {
        let name = format!("theta[{i}]");
        t = t
            .bounds(&name, lower, upper)?
            .start_in(&name, lower, upper)?;
    }
    t.run(&problem)
}

fn score(b: &Benchmark<'_>, fitted: Fitted) -> gp::Result<Score> {
    let posterior = Posterior::new(&fitted.model, &b.functionals(&fitted.theta)?, &b.data.y)?;
    let grid = b.system.grid(b.data);
    let at = b.at(&grid, &fitted.theta)?;
    let mean = posterior.mean(&at)?;
    let n = b.data.y_sd.len();
    let (mut squares, mut constraint) = (vec![0.0; n], 0.0f64);
    for (x, a) in grid.iter().zip(mean.chunks(n)) {
        let raw: Vec<f64> = (0..n)
            .map(|i| a[i] * b.data.y_sd[i] + b.data.y_mean[i])
            .collect();
        let truth = b.system.truth(x)?;
        for i in 0..n {
            squares[i] += ((raw[i] - truth[i]) / b.data.y_sd[i]).powi(2);
        }
        constraint = constraint.max(b.system.constraint_error(x, &raw));
    }
    let rmse = squares
        .iter()
        .map(|s| (s / grid.len() as f64).sqrt())
        .sum::<f64>()
        / n as f64;
    Ok(Score {
        rmse,
        constraint,
        fitted,
    })
}

/// Fit one row of the table to one data set; `restarts` overrides the protocol's.
pub fn fit(
    kind: Kind,
    system: &System,
    data: &Data,
    seed: u64,
    restarts: Option<usize>,
) -> gp::Result<Score> {
    let b = Benchmark::new(kind, system, data);
    let fitted = match kind {
        Kind::Se | Kind::Icm | Kind::Lmc => baseline(kind, &b, seed, restarts.unwrap_or(30))?,
        Kind::Gp2 { .. } => structured(&b, seed, restarts)?,
    };
    if std::env::var_os("TABLE_VERBOSE").is_some() {
        let z: Vec<f64> = fitted
            .model
            .prior
            .params()
            .iter()
            .map(|v| v.exp())
            .collect();
        eprintln!(
            "{} {kind:?} nll {:.2} exp(params) {z:.3?} theta {:.4?}",
            system.name, fitted.nll, fitted.theta
        );
    }
    score(&b, fitted)
}
