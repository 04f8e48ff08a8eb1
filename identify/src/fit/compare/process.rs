//! Training one Gaussian process, scalar or GP².

use gp::{
    Algorithm, Functionals, GpError, Kernel, LatentPrior, Model, Posterior, Problem, Training,
};

/// Bounds of length-scales, in units of the variable's standard deviation.
const LENGTHS: (f64, f64) = (0.05, 100.0);
/// Bounds of prior variances, in units of the residual's.
const VARIANCES: (f64, f64) = (1e-6, 1e3);
/// Bounds of noise variances, in units of the residual's.
const NOISE: (f64, f64) = (1e-6, 10.0);
/// Where noise starts.
const FIRST_NOISE: f64 = 0.1;
/// Length-scales beyond this many standard deviations change nothing along the log.
pub(super) const FLAT: f64 = 10.0;
const RESTARTS: usize = 2;
const ITERATIONS: u64 = 100;

/// A process with squared-exponential kernels, one per latent function, whose
/// hyper-parameters maximise the evidence.
pub(super) struct Trained {
    pub posterior: Posterior,
    /// By how many nats the points are likelier than as white noise, less the price of the
    /// kernels' parameters (`½ ln N` for each that matters). Nothing is learnt where that
    /// is not positive.
    pub gain: f64,
    /// Per latent function: length-scales, and standard deviation of the prior.
    pub kernels: Vec<(Vec<f64>, f64)>,
    /// Standard deviation of the noise, per channel.
    pub noise: Vec<f64>,
}

/// Trains on `data`, whose rows and latent functions are of order one, with `channels`
/// noise channels. The first run begins at `start`, length-scales and deviation of each
/// latent function, if that is known.
pub(super) fn train(
    data: &Functionals,
    y: &[f64],
    channels: usize,
    start: Option<&[(Vec<f64>, f64)]>,
    seed: u64,
) -> Result<Trained, GpError> {
    let (dims, latents) = (data.dims(), data.n_latent());
    // In many dimensions points are far apart.
    let length = (dims as f64).sqrt();
    let unknown = vec![(vec![length; dims], 1.0); latents];
    let kernels: Vec<Kernel> = (start.unwrap_or(&unknown).iter())
        .map(|(lengths, sd)| Kernel::squared_exponential(lengths, sd * sd))
        .collect();
    let prior = LatentPrior::independent(kernels);
    let problem = Problem::new(Model::new(prior, &vec![FIRST_NOISE; channels])?, data, y);
    let fitted = Training::new(&problem)
        .bounds("*log_length*", LENGTHS.0.ln(), LENGTHS.1.ln())?
        .bounds("*log_variance*", VARIANCES.0.ln(), VARIANCES.1.ln())?
        .bounds("*log_noise*", NOISE.0.ln(), NOISE.1.ln())?
        .start_in("*log_length*", (0.5 * length).ln(), (2.0 * length).ln())?
        .algorithm(Algorithm::Lbfgs {
            max_iterations: ITERATIONS,
            gradient_tolerance: 1e-3,
            reduction_tolerance: 1e-7,
        })
        .restarts(RESTARTS)
        .seed(seed)
        .run(&problem)?;
    let posterior = Posterior::new(&fitted.model, data, y)?;
    let params = fitted.model.prior.params();
    // Independent terms: each has its length-scales, then its variance.
    let kernels: Vec<(Vec<f64>, f64)> = params
        .chunks(dims + 1)
        .map(|own| {
            let lengths = own[..dims].iter().map(|l| l.exp()).collect();
            (lengths, (0.5 * own[dims]).exp())
        })
        .collect();
    let price = |(lengths, _): &(Vec<f64>, f64)| {
        let matter = lengths.iter().filter(|&&l| l < FLAT).count();
        0.5 * (matter + 1) as f64 * (data.n_points() as f64).ln()
    };
    let price: f64 = kernels.iter().map(price).sum();
    Ok(Trained {
        posterior,
        gain: white(y, data.channels(), channels) - fitted.nll - price,
        kernels,
        noise: (fitted.model.log_noise.iter())
            .map(|v| (0.5 * v).exp())
            .collect(),
    })
}

/// Negative log likelihood of white noise of its own size in each channel, nats.
fn white(y: &[f64], of: &[usize], channels: usize) -> f64 {
    let one = |channel: usize| {
        let own = y.iter().zip(of).filter(|(_, c)| **c == channel);
        let (count, square) = own.fold((0.0, 0.0), |(n, s), (y, _)| (n + 1.0, s + y * y));
        let variance = (square / f64::max(count, 1.0)).max(NOISE.0);
        0.5 * (count * (2.0 * std::f64::consts::PI * variance).ln() + square / variance)
    };
    (0..channels).map(one).sum()
}
