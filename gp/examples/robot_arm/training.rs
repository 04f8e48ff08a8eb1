//! Starting values, priors and training of the models of Fig. 5.10.

use crate::arm::N;
use crate::models::{DIMS, Kind};
use crate::record::Sample;
use gp::{
    Algorithm, Functionals, Kernel, LatentPrior, Model, Penalty, Posterior, Problem, Training,
};

/// Length-scales start here, where a force is nearly linear over the data; their
/// logarithms have a prior of standard deviation 2 about it.
const LENGTH: f64 = 10.0;

/// How much training a model gets, always on all of its points.
#[derive(Clone, Copy)]
pub struct Effort {
    /// Iterations of L-BFGS-B from the starting values.
    pub iterations: u64,
    /// Iterations from the hyper-parameters of the same model with fewer points.
    pub further: u64,
    /// Up to so many points training begins anew; independent SE-GPs always do.
    pub anew: usize,
}

fn kernel(variance: f64) -> Kernel {
    Kernel::squared_exponential(&[LENGTH; DIMS], variance)
}

/// Prior of the forces that an analytical mean leaves.
pub fn force_prior() -> LatentPrior {
    let start = |d: usize| if d + 1 == N { 1e-3 } else { 1.0 };
    LatentPrior::independent((0..N).map(|d| kernel(start(d))).collect())
}

/// Starting variances, as published: 1, of the last joint's force 0.001. Zero-mean
/// models must explain whole forces: they start at the mean square of the torques,
/// or at 100 (rad/s²)².
pub fn prior(kind: Kind, samples: &[Sample]) -> LatentPrior {
    let (weights, kappa) = (|| vec![vec![0.5; N]; N], || vec![0.1; N]);
    let square = |d: usize| {
        let sum: f64 = samples.iter().map(|s| s.x.u[d] * s.x.u[d]).sum();
        (sum / samples.len() as f64).max(1e-2)
    };
    match kind {
        Kind::Se => LatentPrior::independent(vec![kernel(1.0)]),
        Kind::Icm => LatentPrior::coregional(vec![(kernel(1.0), weights(), kappa())]),
        Kind::Lmc => LatentPrior::coregional(vec![
            (kernel(1.0), weights(), kappa()),
            (Kernel::bias(1.0), weights(), kappa()),
            (Kernel::linear(&[1.0; DIMS]), weights(), kappa()),
        ]),
        Kind::AccelerationPrior => LatentPrior::independent(vec![kernel(100.0); N]),
        Kind::ForcePrior => LatentPrior::independent((0..N).map(|d| kernel(square(d))).collect()),
        Kind::ForcePriorMean => force_prior(),
        Kind::TipForceMean => LatentPrior::independent(vec![kernel(1.0); 3]),
    }
}

/// L-BFGS-B, maximum a posteriori: `ln ℓ ~ N(ln 10, 2²)`, `ln σ² ~ N(start, 1)`.
/// Without priors the evidence of 154 hyper-parameters lets variances of forces that
/// move the arm little fall to zero, and the band of the multiplier with them.
pub fn training(problem: &Problem<'_>, iterations: u64) -> gp::Result<Training> {
    let length = Penalty::Normal {
        mean: LENGTH.ln(),
        sd: 2.0,
    };
    let mut training = Training::new(problem)
        .algorithm(Algorithm::Lbfgs {
            max_iterations: iterations,
            gradient_tolerance: 1e-3,
            reduction_tolerance: 1e-7,
        })
        .bounds("*log_length*", 0.1f64.ln(), 1e4f64.ln())?
        .penalty("*log_length*", length)?
        .fix("log_noise*")?;
    for (name, mean) in problem.names().iter().zip(problem.model.params()) {
        if name.ends_with("log_variance") {
            let near_start = Penalty::Normal { mean, sd: 1.0 };
            training = training.penalty(name, near_start)?;
        }
    }
    Ok(training)
}

/// Train and condition. `smaller`, the same model with fewer points, gives the
/// hyper-parameters to begin with; priors stay about those of `model`.
pub fn trained(
    kind: Kind,
    model: Model,
    smaller: Option<&Posterior>,
    data: &Functionals,
    y: &[f64],
    effort: Effort,
) -> gp::Result<Posterior> {
    let smaller = smaller.filter(|_| kind != Kind::Se && data.n_points() > effort.anew);
    let mut problem = Problem::new(model, data, y);
    let iterations = smaller.map_or(effort.iterations, |_| effort.further);
    let mut training = training(&problem, iterations)?;
    if let Some(smaller) = smaller {
        problem.model.prior = smaller.model().prior.clone();
    }
    if matches!(kind, Kind::Icm | Kind::Lmc) {
        // The weights carry the scale.
        training = training
            .bounds("*weight*", -10.0, 10.0)?
            .bounds("*log_kappa*", 1e-6f64.ln(), 10f64.ln())?
            .fix("term[*].log_variance")?;
    }
    let fitted = training.run(&problem)?;
    if fitted.jitter > 0.0 {
        eprintln!("{}: jitter {:.1e} was needed", kind.name(), fitted.jitter);
    }
    Posterior::new(&fitted.model, data, y)
}
