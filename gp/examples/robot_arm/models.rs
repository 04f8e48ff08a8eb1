//! The models of Fig. 5.10 and how they are trained.

use crate::Failure;
use crate::arm::{Arm, N, State, Vector, contact};
use crate::record::{NOISE, Sample, input};
use dynamics::constrained::Baumgarte;
use gp::{
    Algorithm, Functionals, GaussPoint, Inputs, Kernel, LatentPrior, Layout, Model, Penalty,
    Posterior, Prediction, Problem, Quantity, Scaling, Training,
};

/// Coordinates of the kernel input `(q, v, u)`.
pub const DIMS: usize = 3 * N;
/// Length-scales start here, where a force is nearly linear over the data; their
/// logarithms have a prior of standard deviation 2 about it.
const LENGTH: f64 = 10.0;

/// A model of the acceleration.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// One independent SE-GP per acceleration.
    Se,
    /// Intrinsic coregionalisation.
    Icm,
    /// Linear coregionalisation: SE, bias and linear part (thesis 5.24).
    Lmc,
    /// GP² on the unconstrained acceleration, zero mean (thesis 5.14).
    AccelerationPrior,
    /// GP² on the forces, zero mean (thesis 5.6): "S-GP".
    ForcePrior,
    /// GP² on the forces, mean `Q_C + Q_u + Q_D`: "S-GP + analytical mean".
    ForcePriorMean,
}

impl Kind {
    pub const ALL: [Self; 6] = [
        Self::Se,
        Self::Icm,
        Self::Lmc,
        Self::AccelerationPrior,
        Self::ForcePrior,
        Self::ForcePriorMean,
    ];

    pub fn name(self) -> &'static str {
        match self {
            Self::Se => "SE",
            Self::Icm => "ICM",
            Self::Lmc => "LMC",
            Self::AccelerationPrior => "GP², acceleration prior",
            Self::ForcePrior => "GP², force prior",
            Self::ForcePriorMean => "GP², analytical mean",
        }
    }

    /// Whether it knows nothing of the arm.
    pub fn is_baseline(self) -> bool {
        matches!(self, Self::Se | Self::Icm | Self::Lmc)
    }

    /// Baselines see normalised accelerations, GP² those in rad/s².
    fn outputs(self, y: &[f64]) -> gp::Result<Scaling> {
        if self.is_baseline() {
            Scaling::of_outputs(y, &channels(y.len() / N))
        } else {
            Ok(unit())
        }
    }

    fn layout(self) -> Layout {
        match self {
            Self::AccelerationPrior => Layout::Acceleration,
            _ => Layout::Force,
        }
    }
}

/// How much training a model gets.
#[derive(Clone, Copy)]
pub struct Effort {
    /// Hyper-parameters are trained on so many of the points at most (independent
    /// SE-GPs on all of them); the posterior has them all.
    pub points: usize,
    /// Iterations of L-BFGS-B.
    pub iterations: u64,
}

impl Effort {
    fn count(self, kind: Kind, points: usize) -> usize {
        match kind {
            Kind::Se => points,
            _ => points.min(self.points),
        }
    }
}

/// A trained model.
pub struct Fit {
    pub kind: Kind,
    inputs: Scaling,
    outputs: Scaling,
    /// One of all outputs, or one per output.
    posteriors: Vec<Posterior>,
    /// So many points trained the hyper-parameters.
    trained_on: usize,
}

fn kernel(variance: f64) -> Kernel {
    Kernel::squared_exponential(&[LENGTH; DIMS], variance)
}

/// The kernel input of a state.
pub fn scaled(inputs: &Scaling, x: &State) -> Vec<f64> {
    input(x)
        .iter()
        .zip(inputs.shift.iter().zip(&inputs.scale))
        .map(|(x, (shift, scale))| (x - shift) / scale)
        .collect()
}

/// All that is known at a state; the arm's own friction is not used.
pub fn point(
    kind: Kind,
    arm: &Arm,
    x: &State,
    stabilisation: Option<&Baumgarte<f64>>,
) -> gp::Result<GaussPoint> {
    let terms = arm.terms(x);
    let constraint = contact(&terms, x);
    let b = stabilisation.map_or(constraint.b, |how| how.stabilise(&constraint));
    let known = match kind {
        Kind::ForcePriorMean => arm.known_force(&terms, x),
        _ => Vector::zeros(),
    };
    // Symmetric, and one row: the order of storage does not matter.
    let (mass, a) = (terms.mass.as_slice(), constraint.a.as_slice());
    GaussPoint::new(mass, a, b.as_slice(), known.as_slice())
}

fn structured(
    kind: Kind,
    arm: &Arm,
    inputs: &Scaling,
    samples: &[Sample],
    quantity: Quantity,
) -> gp::Result<Functionals> {
    let mut out = Functionals::new(DIMS, N);
    for s in samples {
        let rows = point(kind, arm, &s.x, None)?.rows(quantity, kind.layout())?;
        out.push(&scaled(inputs, &s.x), &rows.h, &rows.mean)?;
    }
    Ok(out)
}

fn plain(inputs: &Scaling, samples: &[Sample], outputs: usize) -> gp::Result<Functionals> {
    let rows: Vec<Vec<f64>> = samples.iter().map(|s| scaled(inputs, &s.x)).collect();
    Ok(Functionals::identity(&Inputs::from_rows(&rows)?, outputs))
}

fn unit() -> Scaling {
    Scaling {
        shift: vec![0.0; N],
        scale: vec![1.0; N],
    }
}

fn channels(samples: usize) -> Vec<usize> {
    (0..samples).flat_map(|_| 0..N).collect()
}

/// Measured accelerations, sample by sample.
pub fn measured(samples: &[Sample]) -> Vec<f64> {
    samples.iter().flat_map(|s| s.measured).collect()
}

/// Prior of the forces that an analytical mean leaves.
pub fn force_prior() -> LatentPrior {
    let start = |d: usize| if d + 1 == N { 1e-3 } else { 1.0 };
    LatentPrior::independent((0..N).map(|d| kernel(start(d))).collect())
}

/// Starting variances, as published: 1, of the last joint's force 0.001. Zero-mean
/// models must explain whole forces: they start at the mean square of the torques,
/// or at 100 (rad/s²)².
fn prior(kind: Kind, samples: &[Sample]) -> LatentPrior {
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

/// Train on the first points, condition on all.
fn trained(
    kind: Kind,
    model: Model,
    data: &Functionals,
    y: &[f64],
    effort: Effort,
) -> gp::Result<Posterior> {
    let count = effort.count(kind, data.n_points());
    let part = data.subset(&(0..count).collect::<Vec<_>>());
    let problem = Problem::new(model, &part, &y[..part.n_rows()]);
    let mut training = training(&problem, effort.iterations)?;
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

impl Fit {
    /// Train on samples in farthest-point order. `smaller` is the same model with
    /// fewer of the same points: its hyper-parameters are kept when they were
    /// trained on the points that would train them now.
    pub fn new(
        kind: Kind,
        arm: &Arm,
        inputs: &Scaling,
        samples: &[Sample],
        effort: Effort,
        smaller: Option<&Self>,
    ) -> Result<Self, Failure> {
        let y = measured(samples);
        let trained_on = effort.count(kind, samples.len());
        let start = prior(kind, &samples[..trained_on]);
        let outputs = kind.outputs(&y[..trained_on * N])?;
        let y = outputs.outputs(&y, &channels(samples.len()))?;
        let noise: Vec<f64> = outputs.scale.iter().map(|s| (NOISE / s).powi(2)).collect();
        let smaller = smaller.filter(|s| s.trained_on == trained_on);
        let posteriors = if kind == Kind::Se {
            let data = plain(inputs, samples, 1)?;
            let one = |d: usize| {
                let y: Vec<f64> = y.iter().skip(d).step_by(N).copied().collect();
                trained(
                    kind,
                    Model::new(start.clone(), &noise[d..=d])?,
                    &data,
                    &y,
                    effort,
                )
            };
            (0..N).map(one).collect::<gp::Result<Vec<_>>>()?
        } else {
            let data = if kind.is_baseline() {
                plain(inputs, samples, N)?
            } else {
                structured(kind, arm, inputs, samples, Quantity::Acceleration)?
            };
            vec![match smaller {
                Some(fit) => Posterior::new(fit.posteriors[0].model(), &data, &y)?,
                None => trained(kind, Model::new(start, &noise)?, &data, &y, effort)?,
            }]
        };
        Ok(Self {
            kind,
            inputs: inputs.clone(),
            outputs,
            posteriors,
            trained_on,
        })
    }

    /// A GP² with analytical mean that was trained elsewhere.
    pub fn given(inputs: &Scaling, posterior: Posterior) -> Self {
        Self {
            kind: Kind::ForcePriorMean,
            inputs: inputs.clone(),
            outputs: unit(),
            trained_on: posterior.data().n_points(),
            posteriors: vec![posterior],
        }
    }

    /// Mean and variance of a quantity; baselines know the acceleration alone.
    pub fn predict(
        &self,
        arm: &Arm,
        samples: &[Sample],
        quantity: Quantity,
    ) -> Result<Prediction, Failure> {
        if !self.kind.is_baseline() {
            let at = structured(self.kind, arm, &self.inputs, samples, quantity)?;
            return Ok(self.posteriors[0].predict(&at)?);
        }
        if quantity != Quantity::Acceleration {
            return Err(format!("{} predicts accelerations alone", self.kind.name()).into());
        }
        let raw = if self.kind == Kind::Se {
            let at = plain(&self.inputs, samples, 1)?;
            let each: gp::Result<Vec<Prediction>> =
                self.posteriors.iter().map(|p| p.predict(&at)).collect();
            let each = each?;
            let weave = |f: &dyn Fn(&Prediction) -> &[f64]| -> Vec<f64> {
                (0..samples.len())
                    .flat_map(|i| each.iter().map(move |p| (p, i)))
                    .map(|(p, i)| f(p)[i])
                    .collect()
            };
            Prediction {
                mean: weave(&|p| &p.mean),
                variance: weave(&|p| &p.variance),
            }
        } else {
            self.posteriors[0].predict(&plain(&self.inputs, samples, N)?)?
        };
        let channels = channels(samples.len());
        Ok(self.outputs.restore_prediction(&raw, &channels)?)
    }

    /// Mean acceleration alone: cheap, for scores.
    pub fn mean(&self, arm: &Arm, samples: &[Sample]) -> Result<Vec<f64>, Failure> {
        if !self.kind.is_baseline() {
            let at = structured(
                self.kind,
                arm,
                &self.inputs,
                samples,
                Quantity::Acceleration,
            )?;
            return Ok(self.posteriors[0].mean(&at)?);
        }
        let outputs = if self.kind == Kind::Se { 1 } else { N };
        let at = plain(&self.inputs, samples, outputs)?;
        let each: gp::Result<Vec<Vec<f64>>> = self.posteriors.iter().map(|p| p.mean(&at)).collect();
        let each = each?;
        let raw: Vec<f64> = if self.kind == Kind::Se {
            (0..samples.len())
                .flat_map(|i| each.iter().map(move |m| m[i]))
                .collect()
        } else {
            each.concat()
        };
        Ok(self.outputs.restore(&raw, &channels(samples.len()))?)
    }

    /// Mean acceleration at one state, with Baumgarte's `b̃` where the model has a
    /// constraint to stabilise.
    pub fn acceleration(
        &self,
        arm: &Arm,
        x: &State,
        stabilisation: Option<&Baumgarte<f64>>,
    ) -> Result<[f64; N], Failure> {
        let z = scaled(&self.inputs, x);
        let a = if self.kind.is_baseline() {
            let sample = Sample {
                t: 0.0,
                x: *x,
                measured: [0.0; N],
                truth: [0.0; N],
                lambda: 0.0,
            };
            self.mean(arm, &[sample])?
        } else {
            let rows = point(self.kind, arm, x, stabilisation)?
                .rows(Quantity::Acceleration, self.kind.layout())?;
            self.posteriors[0].mean_at(&z, &rows.h, &rows.mean)?
        };
        Ok(std::array::from_fn(|i| a[i]))
    }
}
